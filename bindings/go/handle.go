package cylfuse

// #include "bridge.h"
import "C"

import (
	"runtime"
	"runtime/cgo"
	"sync"
	"unsafe"
)

// object is a handle of the library, which is freed once and never during a call.
type object struct {
	// life is held for reading by each call, for writing by Close.
	life   sync.RWMutex
	native *native
}

// native is what the garbage collector has to free. It is apart from its owner because a callback may well refer to that,
// and Go frees no cycle with a finalizer in it.
type native struct {
	handle    unsafe.Pointer // nil when it was destroyed
	destroy   func(unsafe.Pointer) C.cylfuse_status
	lastError func(unsafe.Pointer) *C.char
}

func (native *native) free() { native.destroy(native.handle) }

// own takes a handle that was just created.
func (object *object) own(held *native) {
	object.native = held
	runtime.SetFinalizer(held, (*native).free)
}

// close frees the handle, unless a call on it is running.
func (object *object) close() error {
	if !object.life.TryLock() {
		return busy()
	}
	defer object.life.Unlock()
	if object.native == nil || object.native.handle == nil {
		return nil
	}
	if err := statusError(object.native.destroy(object.native.handle)); err != nil {
		return err
	}
	runtime.SetFinalizer(object.native, nil)
	object.native.handle = nil
	return nil
}

// open lends the handle, which is not freed before `use` returns.
func (object *object) open(use func(native *native) error) error {
	object.life.RLock()
	defer object.life.RUnlock()
	native := object.native
	if native == nil || native.handle == nil {
		return ErrClosed
	}
	// The finalizer must not run during the last call.
	defer runtime.KeepAlive(native)
	return use(native)
}

// call runs one call and turns its status into an error. The library keeps the message for the thread, so the goroutine
// stays on it until it has read that.
func (object *object) call(run func(handle unsafe.Pointer) C.cylfuse_status) error {
	return object.open(func(native *native) error {
		runtime.LockOSThread()
		defer runtime.UnlockOSThread()
		status := run(native.handle)
		if status == C.CYLFUSE_STATUS_OK {
			return nil
		}
		return &Error{Status(status), C.GoString(native.lastError(native.handle))}
	})
}

// running is a call on a fitter or a detector, for its callbacks. Between calls nothing global refers to the owner, so
// that one that was forgotten is collected together with its callbacks.
type running struct {
	fitter   *Fitter
	detector *Detector
	// ended is called after each fit of FitAll.
	ended func(index int, status Status) bool
	// thrown is what a callback panicked with; the call goes on panicking when the library has returned.
	thrown any
}

// call runs one call on the open fitter and turns its status into an error.
func (fitter *Fitter) call(run func(handle *C.cylfuse_fitter) C.cylfuse_status) error {
	call := running{fitter: fitter}
	return call.run(&fitter.object, func(handle unsafe.Pointer) C.cylfuse_status {
		return run((*C.cylfuse_fitter)(handle))
	})
}

// run runs one call with what it calls back.
func (call *running) run(object *object, run func(handle unsafe.Pointer) C.cylfuse_status) error {
	err := object.call(func(handle unsafe.Pointer) C.cylfuse_status {
		key := cgo.NewHandle(call)
		defer key.Delete()
		outer := C.bridge_enter(C.uintptr_t(key))
		defer C.bridge_enter(outer)
		return run(handle)
	})
	if call.thrown != nil {
		panic(call.thrown)
	}
	return err
}

// callWithMask is call with a mask, whose shape is checked before.
func (fitter *Fitter) callWithMask(mask *Mask, run func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status) error {
	view, err := mask.maskView()
	if err != nil {
		return err
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status { return run(handle, view) })
}

// withoutHandle runs a call on nothing. Its message is kept for the thread, so the goroutine stays on it.
func withoutHandle(run func() C.cylfuse_status) error {
	runtime.LockOSThread()
	defer runtime.UnlockOSThread()
	status := run()
	if status == C.CYLFUSE_STATUS_OK {
		return nil
	}
	return &Error{Status(status), C.GoString(C.cylfuse_fitter_last_error(nil))}
}

func busy() error { return statusError(C.CYLFUSE_STATUS_BUSY) }

// list makes a slice of what the library lists. A `capacity` that is large enough saves asking for the number of items.
func list[T any](items *[]T, capacity C.size_t, call func(out *T, capacity C.size_t, count *C.size_t) C.cylfuse_status) C.cylfuse_status {
	for {
		*items = make([]T, capacity+1) // one more, for the address of the first
		var count C.size_t
		status := call(&(*items)[0], capacity, &count)
		if status != C.CYLFUSE_STATUS_BUFFER_TOO_SMALL {
			*items = (*items)[:count]
			return status
		}
		capacity = count
	}
}

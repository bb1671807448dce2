package cylfuse

// #include "bridge.h"
import "C"

import (
	"runtime"
	"runtime/cgo"
)

// FitAll fits many fitters, several at once, each as Fit does. The results stay in the fitters, for Result and all else
// that can be asked of a fit; the errors come in the order of the fitters, nil for a fit that succeeded. The callbacks of
// the fitters are not called.
//
// threads is how many fits run at the same time, 0 for as many as the machine has processors; the results have the same
// bits for any number. ended, which may be nil, hears of each fit that ended, in this goroutine: the place of the fitter,
// and StatusOK or why it failed. It returns true to go on; false stops the rest, whose errors are StatusCancelled then,
// as is that of FitAll. Its panic goes on in the caller.
func FitAll(fitters []*Fitter, threads int, ended func(index int, status Status) bool) ([]error, error) {
	if threads < 0 {
		return nil, shapeError("%d threads: numbers are 0 or greater", threads)
	}
	handles := make([]*C.cylfuse_fitter, len(fitters)+1) // one more, for the address of the first
	errs := make([]error, len(fitters))
	err := openAll(fitters, handles, func() error {
		runtime.LockOSThread()
		defer runtime.UnlockOSThread()
		statuses := make([]C.cylfuse_status, len(fitters)+1)
		call := running{ended: ended}
		key := cgo.NewHandle(&call)
		defer key.Delete()
		status := C.bridge_fit_all(&handles[0], C.size_t(len(fitters)), C.uint32_t(threads), truth(ended != nil),
			C.uintptr_t(key), &statuses[0])
		runtime.KeepAlive(fitters)
		if call.thrown != nil {
			panic(call.thrown)
		}
		if status != C.CYLFUSE_STATUS_OK && status != C.CYLFUSE_STATUS_CANCELLED {
			return &Error{Status(status), C.GoString(C.cylfuse_fitter_last_error(nil))}
		}
		for i, status := range statuses[:len(fitters)] {
			if status != C.CYLFUSE_STATUS_OK {
				errs[i] = &Error{Status(status), C.GoString(C.cylfuse_fitter_last_error(handles[i]))}
			}
		}
		return statusError(status)
	})
	return errs, err
}

// openAll lends the handles of all fitters, none of which is freed before `use` returns.
func openAll(fitters []*Fitter, handles []*C.cylfuse_fitter, use func() error) error {
	if len(fitters) == 0 {
		return use()
	}
	if !fitters[0].last.TryLock() {
		return busy()
	}
	defer fitters[0].last.Unlock()
	return fitters[0].open(func(native *native) error {
		handles[0] = (*C.cylfuse_fitter)(native.handle)
		return openAll(fitters[1:], handles[1:], use)
	})
}

//export cylfuseGoFitEnded
func cylfuseGoFitEnded(index C.size_t, status C.cylfuse_status, key C.uintptr_t) (stop C.int32_t) {
	call := cgo.Handle(key).Value().(*running)
	defer call.catch(&stop)
	return truth(!call.ended(int(index), Status(status)))
}

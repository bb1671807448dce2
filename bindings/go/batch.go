package cylfuse

// #include "bridge.h"
import "C"

import (
	"fmt"
	"runtime"
	"runtime/cgo"
)

// FitAll fits many fitters, several at once, each as Fit does. The results stay in the fitters, for Result and all else
// that can be asked of a fit; the errors come in the order of the fitters, nil for a fit that succeeded. The callbacks of
// the fitters are not called.
//
// A fitter that is busy in another call has StatusBusy, and the others are fitted all the same. With a nil or closed
// fitter in the list, or one that is there twice, which is StatusInvalidArgument, nothing is done.
//
// threads is how many fits run at the same time, 0 for as many as the machine has processors; the results have the same
// bits for any number. ended, which may be nil, is called after each fit, in this goroutine, with the index of its fitter
// and StatusOK or why it failed. It returns true to go on; false stops the rest, whose errors are StatusCancelled then,
// as is that of FitAll. Its panic goes on in the caller.
func FitAll(fitters []*Fitter, threads int, ended func(index int, status Status) bool) ([]error, error) {
	if threads < 0 {
		return nil, shapeError("%d threads: numbers are 0 or greater", threads)
	}
	if err := checkFitters(fitters); err != nil {
		return nil, err
	}
	handles := make([]*C.cylfuse_fitter, len(fitters)+1) // one more, for the address of the first
	errs := make([]error, len(fitters))
	ran := false
	err := openAll(fitters, handles, 0, func() error {
		runtime.LockOSThread()
		defer runtime.UnlockOSThread()
		statuses := make([]C.cylfuse_status, len(fitters)+1)
		call := running{ended: func(index int, status Status) bool {
			if handles[index] == nil {
				status = StatusBusy
			}
			return ended(index, status)
		}}
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
		ran = true
		for i, status := range statuses[:len(fitters)] {
			if handles[i] == nil {
				errs[i] = busy()
			} else if status != C.CYLFUSE_STATUS_OK {
				errs[i] = &Error{Status(status), C.GoString(C.cylfuse_fitter_last_error(handles[i]))}
			}
		}
		return statusError(status)
	})
	if !ran {
		return nil, err
	}
	return errs, err
}

// checkFitters wants each fitter once: the library does not see those that are busy.
func checkFitters(fitters []*Fitter) error {
	places := make(map[*Fitter]int, len(fitters))
	for i, fitter := range fitters {
		if fitter == nil {
			return &Error{StatusNullPointer, fmt.Sprintf("fitters[%d] is nil; it must be a fitter", i)}
		}
		if first, twice := places[fitter]; twice {
			text := fmt.Sprintf("fitters[%d] is the same as fitters[%d]; it must be another fitter", i, first)
			return &Error{StatusInvalidArgument, text}
		}
		places[fitter] = i
	}
	return nil
}

// openAll lends the handles of all fitters from a place on, none of which is freed before `use` returns. That of one that
// is busy stays nil: the library need not be in a call on it when something reads its result in two.
func openAll(fitters []*Fitter, handles []*C.cylfuse_fitter, from int, use func() error) error {
	if from == len(fitters) {
		return use()
	}
	fitter := fitters[from]
	opened := false
	err := fitter.open(func(native *native) error {
		opened = true
		if fitter.last.TryLock() {
			defer fitter.last.Unlock()
			handles[from] = (*C.cylfuse_fitter)(native.handle)
		}
		return openAll(fitters, handles, from+1, use)
	})
	if !opened {
		return fmt.Errorf("fitters[%d]: %w", from, err)
	}
	return err
}

//export cylfuseGoFitEnded
func cylfuseGoFitEnded(index C.size_t, status C.cylfuse_status, key C.uintptr_t) (stop C.int32_t) {
	call := cgo.Handle(key).Value().(*running)
	defer call.catch(&stop)
	return truth(!call.ended(int(index), Status(status)))
}

package cylfuse

// #include "bridge.h"
import "C"

import "runtime/cgo"

// Phase is what a fit is doing.
type Phase int32

const (
	// PhaseStart: it is about to look for a start, or looks for one and asks whether to go on.
	PhaseStart Phase = C.CYLFUSE_PHASE_START
	// PhaseSolve: it iterates, or asks after an iteration whether to go on: the last state is reported again then.
	PhaseSolve Phase = C.CYLFUSE_PHASE_SOLVE
)

// Progress is the state of a running fit, before each iteration.
type Progress struct {
	// Phase is what the fit is doing.
	Phase Phase
	// Iteration counts the iterations, from 0 with every start that is tried and every robust round.
	Iteration uint32
	// MaxIterations is the maximum number of iterations.
	MaxIterations uint32
	// Cost is the lowest so far, unit of length squared; infinite in PhaseStart.
	Cost float64
	// Lambda is the damping of the next step; 0 in PhaseStart.
	Lambda float64
	// Cylinder is the best so far; of radius 0 in PhaseStart, which has none.
	Cylinder Cylinder
}

// LogLevel is how much a log line matters.
type LogLevel int32

const (
	// LogOff: no lines.
	LogOff LogLevel = C.CYLFUSE_LOG_LEVEL_OFF
	// LogError: calls that failed.
	LogError LogLevel = C.CYLFUSE_LOG_LEVEL_ERROR
	// LogWarning: warnings about a result.
	LogWarning LogLevel = C.CYLFUSE_LOG_LEVEL_WARNING
	// LogInfo: what was pushed, which start was taken, how a fit ended.
	LogInfo LogLevel = C.CYLFUSE_LOG_LEVEL_INFO
	// LogDebug: every iteration.
	LogDebug LogLevel = C.CYLFUSE_LOG_LEVEL_DEBUG
)

// SetProgress sets what is called before every iteration of a fit, in the goroutine that called Fit; nil for nothing. It
// returns true to go on; false stops the fit, which returns StatusCancelled. Of the methods of the same fitter it may
// only call Cancel; the others return StatusBusy. Its panic goes on in the caller of Fit. It must not end the goroutine
// (runtime.Goexit, Fatal of a test): for the library the fit would go on for ever, and the fitter with it.
func (fitter *Fitter) SetProgress(callback func(Progress) bool) error {
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		status := C.bridge_set_progress(handle, truth(callback != nil))
		if status == C.CYLFUSE_STATUS_OK {
			fitter.state.Lock()
			defer fitter.state.Unlock()
			fitter.progress = callback
		}
		return status
	})
}

// SetLog sets what takes log lines up to a level, in the goroutine of the call, so in several at once when several
// goroutines call; nil for nothing. The rules of SetProgress hold here too.
func (fitter *Fitter) SetLog(maxLevel LogLevel, callback func(level LogLevel, message string)) error {
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		status := C.bridge_set_log(handle, C.cylfuse_log_level(maxLevel), truth(callback != nil))
		if status == C.CYLFUSE_STATUS_OK {
			fitter.state.Lock()
			defer fitter.state.Unlock()
			fitter.log = callback
		}
		return status
	})
}

//export cylfuseGoProgress
func cylfuseGoProgress(c *C.cylfuse_progress, key C.uintptr_t) (stop C.int32_t) {
	call := cgo.Handle(key).Value().(*running)
	defer call.catch(&stop)
	callback, _ := call.fitter.callbacks()
	if call.thrown != nil {
		return 1
	}
	if callback == nil {
		return 0
	}
	progress := Progress{
		Phase:         Phase(c.phase),
		Iteration:     uint32(c.iteration),
		MaxIterations: uint32(c.max_iterations),
		Cost:          float64(c.cost),
		Lambda:        float64(c.lambda),
	}
	if c.cylinder != nil {
		progress.Cylinder = cylinderFromC(c.cylinder)
	}
	return truth(!callback(progress))
}

//export cylfuseGoLog
func cylfuseGoLog(level C.cylfuse_log_level, message *C.char, key C.uintptr_t) {
	call := cgo.Handle(key).Value().(*running)
	var stop C.int32_t
	defer call.catch(&stop)
	if _, callback := call.fitter.callbacks(); callback != nil && call.thrown == nil {
		callback(LogLevel(level), C.GoString(message))
	}
}

func (fitter *Fitter) callbacks() (func(Progress) bool, func(LogLevel, string)) {
	fitter.state.Lock()
	defer fitter.state.Unlock()
	return fitter.progress, fitter.log
}

// catch keeps a panic of a callback, which must not run through the library, for the call to go on with.
func (call *running) catch(stop *C.int32_t) {
	if thrown := recover(); thrown != nil {
		call.thrown = thrown
		*stop = 1
	}
}

func truth(is bool) C.int32_t {
	if is {
		return 1
	}
	return 0
}

package cylfuse

// #include "bridge.h"
import "C"

import (
	"errors"
	"fmt"
)

// Status says why a call failed. It is an error, for errors.Is(err, cylfuse.StatusTooFewPoints).
type Status int32

// The numbers never change; later versions may add some.
const (
	// StatusInvalidArgument: an argument or field has a value outside its documented range.
	StatusInvalidArgument Status = C.CYLFUSE_STATUS_INVALID_ARGUMENT
	// StatusNullPointer: data that are needed are missing.
	StatusNullPointer Status = C.CYLFUSE_STATUS_NULL_POINTER
	// StatusStructSize: library and package do not belong together.
	StatusStructSize Status = C.CYLFUSE_STATUS_STRUCT_SIZE
	// StatusABIMismatch: the package was compiled for another, incompatible version of the library.
	StatusABIMismatch Status = C.CYLFUSE_STATUS_ABI_MISMATCH
	// StatusBadState: the call came before something that it needs.
	StatusBadState Status = C.CYLFUSE_STATUS_BAD_STATE
	// StatusBusy: another call on the same fitter, frame or detector is running, in another goroutine or around a callback, and
	// one of the two may change it.
	StatusBusy Status = C.CYLFUSE_STATUS_BUSY
	// StatusBufferTooSmall: a buffer for an output is too small.
	StatusBufferTooSmall Status = C.CYLFUSE_STATUS_BUFFER_TOO_SMALL
	// StatusOutOfMemory: memory could not be allocated. Pass less data at once, or free memory.
	StatusOutOfMemory Status = C.CYLFUSE_STATUS_OUT_OF_MEMORY
	// StatusUnsupported: not supported with these options or data.
	StatusUnsupported Status = C.CYLFUSE_STATUS_UNSUPPORTED
	// StatusSizeMismatch: images on one pixel grid have different sizes.
	StatusSizeMismatch Status = C.CYLFUSE_STATUS_SIZE_MISMATCH
	// StatusInvalidIntrinsics: no camera works with these intrinsics.
	StatusInvalidIntrinsics Status = C.CYLFUSE_STATUS_INVALID_INTRINSICS
	// StatusTooFewPoints: too few usable points. A fit needs 5, as many as a cylinder has degrees of freedom; a plan needs 8
	// points with independent noise.
	StatusTooFewPoints Status = C.CYLFUSE_STATUS_TOO_FEW_POINTS
	// StatusPlanarPoints: the points are as flat as a plane.
	StatusPlanarPoints Status = C.CYLFUSE_STATUS_PLANAR_POINTS
	// StatusCollinearPoints: the points lie on one straight line.
	StatusCollinearPoints Status = C.CYLFUSE_STATUS_COLLINEAR_POINTS
	// StatusEmptyMask: no pixel of the mask is set.
	StatusEmptyMask Status = C.CYLFUSE_STATUS_EMPTY_MASK
	// StatusNoDepth: no pixel in the region has a usable depth.
	StatusNoDepth Status = C.CYLFUSE_STATUS_NO_DEPTH
	// StatusNoStart: no start for the iteration could be found.
	StatusNoStart Status = C.CYLFUSE_STATUS_NO_START
	// StatusEdgeGeometry: the camera sees no limbs of the cylinder, or nothing that was given meets it.
	StatusEdgeGeometry Status = C.CYLFUSE_STATUS_EDGE_GEOMETRY
	// StatusNumerical: the arithmetic left the range of numbers.
	StatusNumerical Status = C.CYLFUSE_STATUS_NUMERICAL
	// StatusCancelled: the progress callback or Cancel asked to stop.
	StatusCancelled Status = C.CYLFUSE_STATUS_CANCELLED
	// StatusPanic: a defect of the library. The fitter can only be closed after it; others are not affected.
	StatusPanic Status = C.CYLFUSE_STATUS_PANIC
)

// Error is the name of the status and what it means in a few words.
func (status Status) Error() string {
	return C.GoString(C.cylfuse_status_string(C.cylfuse_status(status)))
}

// Error is what the library refused.
type Error struct {
	// Status is the kind of the failure.
	Status Status
	// Message says what was wrong, the value, the limit and the remedy.
	Message string
}

// Error is the message, with the name of the package before it.
func (err *Error) Error() string { return "cylfuse: " + err.Message }

// Unwrap gives the status.
func (err *Error) Unwrap() error { return err.Status }

// ErrShape is within every error about a slice that does not hold what its description says. Nothing was called then.
var ErrShape = errors.New("cylfuse: wrong shape")

// ErrClosed is the error of a call on a fitter, frame or detector that was closed, or that is no work of NewFitter,
// NewFrame, NewDetector or Detector.Fitter.
var ErrClosed = errors.New("cylfuse: the fitter, frame or detector is closed, or was not made by a function of this " +
	"package: make a new one")

func shapeError(format string, arguments ...any) error {
	return fmt.Errorf("%w: %s", ErrShape, fmt.Sprintf(format, arguments...))
}

// statusError is the error of a status without a message.
func statusError(status C.cylfuse_status) error {
	if status == C.CYLFUSE_STATUS_OK {
		return nil
	}
	return &Error{Status(status), Status(status).Error()}
}

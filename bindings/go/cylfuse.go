// Package cylfuse measures a cylinder (a pipe, a can, a shaft, a trunk) from RGB-D views: axis, radius and visible
// extent, from points or a depth image together with the two limb lines in the image.
//
// A Fitter holds options, views and data. Push what there is, fit, read the result; Clear leads to the next frame.
// SelectView leads to another view of the same cylinder, and a Frame is shared by the fitters of many cylinders. FitPoints
// does it in one call for a bare cloud. A Detector finds all cylinders of a frame or a cloud without masks.
//
// Units and frames. Lengths are in one unit, which is the caller's. Angles are in radians. The camera frame is x to the
// right, y down, z forward, with its origin in the centre of projection. Poses lead from camera frames to the reference
// frame; with one view at the identity, as at first, the two are the same. Pixel centres are at integer coordinates.
//
// Numbers. Points with a coordinate or weight that is not finite, depths of 0, below 0, not finite or, as uint16, of 65535,
// and pixels outside the mask are left out and counted. Anything else that is not finite is an error.
//
// Errors. What the library refuses is an *Error with its Status and message; a slice that does not hold what its
// description says is an ErrShape, raised before the library is called. A call that fails changes nothing. A result
// that did not converge, or that needs care for another reason, is not an error: Result.Flags tells.
//
// Goroutines. Methods that only read run side by side on a Fitter or Detector; one that changes something runs alone. What would
// disturb another call gets StatusBusy at once. Only Cancel always goes through. Different fitters run in parallel.
package cylfuse

// #cgo CFLAGS: -I${SRCDIR}/../../include/cylfuse
// #include "bridge.h"
import "C"

import "fmt"

// Version is the version of the loaded library, such as "0.2.0".
func Version() string { return C.GoString(C.cylfuse_version_string()) }

// BuildInfo says how the loaded library was built, for reports of defects.
func BuildInfo() string { return C.GoString(C.cylfuse_build_info()) }

// checkLibrary refuses a library whose structs are not those that this package was compiled for. A newer library of
// the same interface knows all that this package uses; an older one may not.
func checkLibrary() error {
	if version := uint32(C.cylfuse_abi_version()); version != C.CYLFUSE_ABI_VERSION {
		return &Error{StatusABIMismatch, fmt.Sprintf(
			"the library has version %d of the binary interface, this package needs %d: install the library that "+
				"belongs to the package", version, int(C.CYLFUSE_ABI_VERSION))}
	}
	if version := uint32(C.cylfuse_version_number()); version < C.CYLFUSE_VERSION_NUMBER {
		return &Error{StatusABIMismatch, fmt.Sprintf("the library has version %s, this package needs at least %s: "+
			"install the library that belongs to the package", Version(), C.CYLFUSE_VERSION_STRING)}
	}
	return nil
}

// FitPoints fits a cylinder to x, y, z of point after point by the default options. For anything else there is Fitter.
func FitPoints[T float32 | float64](xyz []T) (Result, error) {
	fitter, err := NewFitter()
	if err != nil {
		return Result{}, err
	}
	defer fitter.Close()
	if err := fitter.PushPoints(Points[T]{Data: xyz}, nil); err != nil {
		return Result{}, err
	}
	return fitter.Fit()
}

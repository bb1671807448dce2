package cylfuse

// #include "bridge.h"
import "C"

import (
	"runtime/cgo"
	"sync"
	"unsafe"
)

// ImageUse says whether a detector looks at the image of a frame.
type ImageUse int32

const (
	// ImageUseAuto: where there is one.
	ImageUseAuto ImageUse = C.CYLFUSE_IMAGE_USE_AUTO
	// ImageUseIgnore: never, by depth alone.
	ImageUseIgnore ImageUse = C.CYLFUSE_IMAGE_USE_IGNORE
)

// DetectorOptions are the settings of a detector. Start from DefaultDetectorOptions: 0 is no default for some fields.
// The limits of radius and axis hold for the search and for the fits.
type DetectorOptions struct {
	// ImageUse says whether the image of a frame is looked at. Default ImageUseAuto.
	ImageUse ImageUse
	// MaxThreads is the most threads, on which cylinders are fitted side by side; the result has the same bits for any
	// number. Default 1: no thread is started.
	MaxThreads uint32
	// MaxCount is the most cylinders, those with the highest scores. Default 0 = no limit.
	MaxCount uint32
	// MinPixels is the fewest pixels of a cylinder; points for a cloud. Default 100.
	MinPixels uint64
	// MinScore is the least score, in [0, 1]: the probability that there is a cylinder. Default 0.5.
	MinScore float64
	// RadiusMin is the smallest radius. Default 0 = no limit.
	RadiusMin float64
	// RadiusMax is the largest radius, equal to RadiusMin for a radius that is known. Default 0 = no limit.
	RadiusMax float64
	// Axis is the middle of the cone of directions that the axes keep, in the reference frame and of any length. Default
	// {0, 0, 0} = all directions.
	Axis [3]float64
	// AxisMaxAngle is the largest angle of an axis from Axis, in radians from 0 to pi/2; 0 for a direction that is known.
	// Default 0; must be 0 without Axis.
	AxisMaxAngle float64
}

// DefaultDetectorOptions are the settings of a new detector.
func DefaultDetectorOptions() DetectorOptions {
	var options C.cylfuse_detector_options
	C.cylfuse_detector_options_init(&options, C.sizeof_cylfuse_detector_options)
	return detectorOptionsFromC(&options)
}

func (options *DetectorOptions) toC() C.cylfuse_detector_options {
	var c C.cylfuse_detector_options
	C.cylfuse_detector_options_init(&c, C.sizeof_cylfuse_detector_options)
	c.image_use = C.cylfuse_image_use(options.ImageUse)
	c.max_threads = C.uint32_t(options.MaxThreads)
	c.max_count = C.uint32_t(options.MaxCount)
	c.min_pixels = C.uint64_t(options.MinPixels)
	c.min_score = C.double(options.MinScore)
	c.radius_min = C.double(options.RadiusMin)
	c.radius_max = C.double(options.RadiusMax)
	c.axis = vectorToC(options.Axis)
	c.axis_max_angle = C.double(options.AxisMaxAngle)
	return c
}

func detectorOptionsFromC(c *C.cylfuse_detector_options) DetectorOptions {
	return DetectorOptions{
		ImageUse:     ImageUse(c.image_use),
		MaxThreads:   uint32(c.max_threads),
		MaxCount:     uint32(c.max_count),
		MinPixels:    uint64(c.min_pixels),
		MinScore:     float64(c.min_score),
		RadiusMin:    float64(c.radius_min),
		RadiusMax:    float64(c.radius_max),
		Axis:         vectorFromC(c.axis),
		AxisMaxAngle: float64(c.axis_max_angle),
	}
}

// DetectionPhase is what a detector is doing.
type DetectionPhase int32

const (
	// DetectionSearch: it is about to look for cylinders.
	DetectionSearch DetectionPhase = C.CYLFUSE_DETECTION_PHASE_SEARCH
	// DetectionFit: it fits those that were found.
	DetectionFit DetectionPhase = C.CYLFUSE_DETECTION_PHASE_FIT
)

// DetectionProgress is how far a detector is: before the search, after it, and after each fit.
// A cloud that is searched from many places begins again with each.
type DetectionProgress struct {
	// Phase is what the detector is doing.
	Phase DetectionPhase
	// FitsDone counts the cylinders that are fitted, Fits those to fit; 0 before the search.
	FitsDone, Fits uint32
}

// Detection is a cylinder of a scene.
type Detection struct {
	// Score is the probability that there is a cylinder.
	Score float64
	// Pixels of its region; points for a cloud.
	Pixels uint64
	// Result is the outcome of its fit.
	Result Result
	// Extent is its visible piece; that of a cylinder of a cloud ends with its points. It is nil where there is none.
	Extent *Extent
	// ExtentError says why there is no Extent; nil where there is one.
	ExtentError error
}

// Labels is an image of the numbers of cylinders.
type Labels struct {
	// Data holds, row by row, 1 for the first detection and so on; 0 = none.
	Data []uint16
	// Width and Height are those of the colour image or of the cloud; Height is 1 for a cloud that is not organised.
	Width, Height int
}

// Detector finds all cylinders of a frame or a cloud, without masks, and fits each by the full method. Made by
// NewDetector.
//
// Detections, Labels, Indices and Fitter are of the last search that succeeded. Methods that only read run side by side;
// one that changes something runs alone. What would disturb another call, from another goroutine or from a callback, gets
// StatusBusy.
type Detector struct {
	object

	// last is held for writing by a search, for reading by what reads its scene in several calls.
	last sync.RWMutex

	// state guards what follows.
	state    sync.Mutex
	progress func(DetectionProgress) bool
	labels   size // of the last scene
	camera   size // of the last scene, 0 for a cloud
}

// NewDetector makes a detector with default options. Close frees what it holds; a forgotten one is freed by the garbage
// collector, which does not see how much memory that is.
func NewDetector() (*Detector, error) {
	if err := checkLibrary(); err != nil {
		return nil, err
	}
	var handle *C.cylfuse_detector
	create := func() C.cylfuse_status { return C.cylfuse_detector_create(C.CYLFUSE_ABI_VERSION, &handle) }
	if err := withoutHandle(create); err != nil {
		return nil, err
	}
	detector := new(Detector)
	detector.own(&native{
		handle:    unsafe.Pointer(handle),
		destroy:   func(h unsafe.Pointer) C.cylfuse_status { return C.cylfuse_detector_destroy((*C.cylfuse_detector)(h)) },
		lastError: func(h unsafe.Pointer) *C.char { return C.cylfuse_detector_last_error((*C.cylfuse_detector)(h)) },
	})
	return detector, nil
}

// Close frees the detector; fitters that it made stay. A second Close does nothing. StatusBusy when a call on the
// detector is running: nothing is freed then.
func (detector *Detector) Close() error { return detector.close() }

// Cancel asks the search that is running to stop: it returns StatusCancelled. When none is running it does nothing. May
// come from any goroutine and from callbacks.
func (detector *Detector) Cancel() error {
	return detector.object.call(func(handle unsafe.Pointer) C.cylfuse_status {
		return C.cylfuse_detector_cancel((*C.cylfuse_detector)(handle))
	})
}

// SetOptions replaces the options.
func (detector *Detector) SetOptions(options DetectorOptions) error {
	c := options.toC()
	return detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		return C.cylfuse_detector_set_options(handle, &c)
	})
}

// Options reads the options.
func (detector *Detector) Options() (DetectorOptions, error) {
	var c C.cylfuse_detector_options
	C.cylfuse_detector_options_init(&c, C.sizeof_cylfuse_detector_options)
	err := detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		return C.cylfuse_detector_get_options(handle, &c)
	})
	if err != nil {
		return DetectorOptions{}, err
	}
	return detectorOptionsFromC(&c), nil
}

// SetFitOptions replaces the options of the fits. Limits, MaxThreads and Start must have their defaults: they are the
// detector's.
func (detector *Detector) SetFitOptions(options Options) error {
	c := options.toC()
	return detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		return C.cylfuse_detector_set_fit_options(handle, &c)
	})
}

// FitOptions reads the options of the fits.
func (detector *Detector) FitOptions() (Options, error) {
	var c C.cylfuse_options
	C.cylfuse_options_init(&c, C.sizeof_cylfuse_options)
	err := detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		return C.cylfuse_detector_get_fit_options(handle, &c)
	})
	if err != nil {
		return Options{}, err
	}
	return optionsFromC(&c), nil
}

// SetProgress sets what is called with the progress of a search: before it, after it, and after each fit, in the goroutine
// that called Detect or DetectPoints; nil for nothing. It returns true to go on; false stops the search, which returns
// StatusCancelled. The rules of Fitter.SetProgress hold here too.
func (detector *Detector) SetProgress(callback func(DetectionProgress) bool) error {
	return detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		status := C.bridge_set_detection_progress(handle, truth(callback != nil))
		if status == C.CYLFUSE_STATUS_OK {
			detector.state.Lock()
			defer detector.state.Unlock()
			detector.progress = callback
		}
		return status
	})
}

//export cylfuseGoDetectionProgress
func cylfuseGoDetectionProgress(c *C.cylfuse_detection_progress, key C.uintptr_t) (stop C.int32_t) {
	call := cgo.Handle(key).Value().(*running)
	defer call.catch(&stop)
	if call.thrown != nil {
		return 1
	}
	call.detector.state.Lock()
	callback := call.detector.progress
	call.detector.state.Unlock()
	if callback == nil {
		return 0
	}
	return truth(!callback(DetectionProgress{DetectionPhase(c.phase), uint32(c.fits_done), uint32(c.fits)}))
}

// Detect finds all cylinders in the depth image of a frame, and fits each to its region by depth and image, in the
// reference frame to which the pose of the frame leads: by falling score, and there may be none. The frame may be changed
// or closed afterwards, of which the detector sees nothing.
func (detector *Detector) Detect(frame *Frame) ([]Detection, error) {
	var found []Detection
	err := frame.open(func(native *native) (err error) {
		frame.state.Lock()
		camera := frame.size
		frame.state.Unlock()
		found, err = detector.search(camera, camera, func(handle *C.cylfuse_detector) C.cylfuse_status {
			return C.cylfuse_detector_detect(handle, (*C.cylfuse_frame)(native.handle))
		})
		return err
	})
	return found, err
}

// DetectPoints finds all cylinders in a cloud, organised or not, and fits each to its points: by falling score, and there
// may be none. Points with a coordinate that is not finite or a weight of 0 are left out. It is looked at from where
// one sensor has seen it, in its origin or where the densities of the points tell; other clouds are looked at from all
// sides, which takes about ten times as long.
func (detector *Detector) DetectPoints(points PointCloud) ([]Detection, error) {
	call, err := points.pointsView()
	if err != nil {
		return nil, err
	}
	labels := size{int(call.view.width), int(call.view.height)}
	return detector.search(labels, size{}, func(handle *C.cylfuse_detector) C.cylfuse_status {
		return C.bridge_detect_points(handle, &call.view, call.data, call.weights, call.normals)
	})
}

func (detector *Detector) search(labels, camera size, run func(handle *C.cylfuse_detector) C.cylfuse_status) ([]Detection, error) {
	if !detector.last.TryLock() {
		return nil, busy()
	}
	defer detector.last.Unlock()
	if err := detector.call(run); err != nil {
		return nil, err
	}
	detector.state.Lock()
	detector.labels, detector.camera = labels, camera
	detector.state.Unlock()
	return detector.read()
}

// Detections reads the cylinders of the last search that succeeded, by falling score; StatusBadState when there is none.
func (detector *Detector) Detections() ([]Detection, error) {
	if !detector.last.TryRLock() {
		return nil, busy()
	}
	defer detector.last.RUnlock()
	return detector.read()
}

func (detector *Detector) read() ([]Detection, error) {
	var found []Detection
	err := detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		var count C.size_t
		if status := C.cylfuse_detector_count(handle, &count); status != C.CYLFUSE_STATUS_OK {
			return status
		}
		var raw []C.cylfuse_detection
		status := list(&raw, count, func(out *C.cylfuse_detection, capacity C.size_t, count *C.size_t) C.cylfuse_status {
			return C.cylfuse_detector_detections(handle, out, C.sizeof_cylfuse_detection, capacity, count)
		})
		for index := 0; index < len(raw) && status == C.CYLFUSE_STATUS_OK; index++ {
			one := Detection{Score: float64(raw[index].score), Pixels: uint64(raw[index].pixels)}
			if status = one.read(handle, C.size_t(index)); status == C.CYLFUSE_STATUS_OK {
				found = append(found, one)
			}
		}
		return status
	})
	if err != nil {
		return nil, err
	}
	return found, nil
}

func (detection *Detection) read(handle *C.cylfuse_detector, index C.size_t) C.cylfuse_status {
	var result C.cylfuse_result
	var estimate C.cylfuse_cylinder_estimate
	var extent C.cylfuse_extent
	C.cylfuse_result_init(&result, C.sizeof_cylfuse_result)
	C.cylfuse_cylinder_estimate_init(&estimate, C.sizeof_cylfuse_cylinder_estimate)
	C.cylfuse_extent_init(&extent, C.sizeof_cylfuse_extent)
	if status := C.cylfuse_detector_get_result(handle, index, &result); status != C.CYLFUSE_STATUS_OK {
		return status
	}
	if status := C.cylfuse_detector_get_cylinder(handle, index, &estimate); status != C.CYLFUSE_STATUS_OK {
		return status
	}
	detection.Result = resultFromC(&result, &estimate)
	switch status := C.cylfuse_detector_get_extent(handle, index, &extent); status {
	case C.CYLFUSE_STATUS_OK:
		seen := extentFromC(&extent)
		detection.Extent = &seen
	case C.CYLFUSE_STATUS_BUSY:
		return status
	default:
		detection.ExtentError = &Error{Status(status), C.GoString(C.cylfuse_detector_last_error(handle))}
	}
	return C.CYLFUSE_STATUS_OK
}

// IsComplete says whether the scene was looked at as a whole. The work of a search with its fits is bounded: of a scene with
// more in it than that, cylinders may be missing. One for whose fit there was no work left is what the search found, with
// FlagNotConverged.
func (detector *Detector) IsComplete() (bool, error) {
	var complete C.int32_t
	err := detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		return C.cylfuse_detector_is_complete(handle, &complete)
	})
	return complete != 0, err
}

// DepthMoved gives the columns (to the right) and rows (down) by which the depth of the frame was moved to where the image
// shows the same bodies; zeros where it was not. Each result then has FlagDepthShifted; labels and indices are those of the
// depth as it was given.
func (detector *Detector) DepthMoved() (columns, rows int, err error) {
	var right, down C.int32_t
	err = detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		return C.cylfuse_detector_depth_moved(handle, &right, &down)
	})
	return int(right), int(down), err
}

// Labels gives for each pixel of the colour image, or each point of the cloud, the number of its cylinder from 1 on.
func (detector *Detector) Labels() (Labels, error) {
	if !detector.last.TryRLock() {
		return Labels{}, busy()
	}
	defer detector.last.RUnlock()
	detector.state.Lock()
	labels := Labels{Width: detector.labels.width, Height: detector.labels.height}
	detector.state.Unlock()
	err := detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		capacity := C.size_t(labels.Width * labels.Height)
		return list(&labels.Data, capacity, func(out *uint16, capacity C.size_t, count *C.size_t) C.cylfuse_status {
			return C.cylfuse_detector_labels(handle, (*C.uint16_t)(out), capacity, count)
		})
	})
	if err != nil {
		return Labels{}, err
	}
	return labels, nil
}

// Indices lists the pixels or points of one detection (from 0), counted from 0 row by row, rising.
func (detector *Detector) Indices(index int) ([]uint32, error) {
	if index < 0 {
		return nil, shapeError("cylinder %d: cylinders count from 0", index)
	}
	if !detector.last.TryRLock() {
		return nil, busy()
	}
	defer detector.last.RUnlock()
	var indices []uint32
	err := detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		return list(&indices, 0, func(out *uint32, capacity C.size_t, count *C.size_t) C.cylfuse_status {
			return C.cylfuse_detector_indices(handle, C.size_t(index), (*C.uint32_t)(out), capacity, count)
		})
	})
	if err != nil {
		return nil, err
	}
	return indices, nil
}

// Fitter makes a fitter of one detection (from 0) as its fit left it, with options, frame or points, region as mask, start
// model and result: for residuals, completion, limbs and all else that can be asked of a fit, or for another fit. It shares
// the images of the frame and does not depend on the detector. Close frees it.
func (detector *Detector) Fitter(index int) (*Fitter, error) {
	if index < 0 {
		return nil, shapeError("cylinder %d: cylinders count from 0", index)
	}
	if !detector.last.TryRLock() {
		return nil, busy()
	}
	defer detector.last.RUnlock()
	var made *C.cylfuse_fitter
	err := detector.call(func(handle *C.cylfuse_detector) C.cylfuse_status {
		return C.cylfuse_detector_make_fitter(handle, C.size_t(index), &made)
	})
	if err != nil {
		return nil, err
	}
	detector.state.Lock()
	defer detector.state.Unlock()
	return ownFitter(made, detector.camera), nil
}

// call runs one call on the open detector and turns its status into an error.
func (detector *Detector) call(run func(handle *C.cylfuse_detector) C.cylfuse_status) error {
	call := running{detector: detector}
	return call.run(&detector.object, func(handle unsafe.Pointer) C.cylfuse_status {
		return run((*C.cylfuse_detector)(handle))
	})
}

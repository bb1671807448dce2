package cylfuse

// #include "bridge.h"
import "C"

import (
	"sync"
	"unsafe"
)

// Fitter estimates one cylinder: it holds options, views with their data, and the last result. Made by NewFitter.
//
// Methods that only read run side by side; one that changes something runs alone. What would disturb another call, from
// another goroutine or from a callback, gets StatusBusy.
type Fitter struct {
	object

	// last is held for writing by a fit, for reading by what reads its result in two calls.
	last sync.RWMutex

	// state guards what follows.
	state    sync.Mutex
	progress func(Progress) bool
	log      func(LogLevel, string)
	cameras  []size // of the views
	selected int    // view
}

// NewFitter makes a fitter with default options, one view at the identity, and no data. Close frees what it holds; a
// forgotten one is freed by the garbage collector, which does not see how much memory that is.
func NewFitter() (*Fitter, error) {
	if err := checkLibrary(); err != nil {
		return nil, err
	}
	var handle *C.cylfuse_fitter
	create := func() C.cylfuse_status { return C.cylfuse_fitter_create(C.CYLFUSE_ABI_VERSION, &handle) }
	if err := withoutHandle(create); err != nil {
		return nil, err
	}
	return ownFitter(handle, size{}), nil
}

// ownFitter takes a fitter that was just created, with a camera of this size.
func ownFitter(handle *C.cylfuse_fitter, camera size) *Fitter {
	fitter := &Fitter{cameras: []size{camera}}
	fitter.own(&native{
		handle:    unsafe.Pointer(handle),
		destroy:   func(h unsafe.Pointer) C.cylfuse_status { return C.cylfuse_fitter_destroy((*C.cylfuse_fitter)(h)) },
		lastError: func(h unsafe.Pointer) *C.char { return C.cylfuse_fitter_last_error((*C.cylfuse_fitter)(h)) },
	})
	return fitter
}

// Clone makes another fitter with all that this one holds, settings, data and result, but no callbacks. Images are shared,
// points are copied: clone one that is set up for each goroutine before data are pushed. Close frees it.
func (fitter *Fitter) Clone() (*Fitter, error) {
	var made *C.cylfuse_fitter
	var cameras []size
	selected := 0
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		status := C.cylfuse_fitter_clone(handle, &made)
		fitter.state.Lock()
		defer fitter.state.Unlock()
		cameras, selected = append(cameras, fitter.cameras...), fitter.selected
		return status
	})
	if err != nil {
		return nil, err
	}
	clone := ownFitter(made, size{})
	clone.cameras, clone.selected = cameras, selected
	return clone, nil
}

// Close frees the fitter. A second Close does nothing. StatusBusy when a call on the fitter is running: nothing is
// freed then.
func (fitter *Fitter) Close() error { return fitter.close() }

// Reserve makes room for the coordinates of that many more points and for that many more segments in the selected view.
func (fitter *Fitter) Reserve(points, segments int) error {
	if points < 0 || segments < 0 {
		return shapeError("%d points and %d segments: numbers are 0 or greater", points, segments)
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_reserve(handle, C.size_t(points), C.size_t(segments))
	})
}

// Clear forgets the data, all views but the first, its pose and the result; it keeps options, the cameras of the first
// view, start model, what StartLast goes on from, callbacks and memory: the way from one frame to the next.
func (fitter *Fitter) Clear() error {
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		status := C.cylfuse_fitter_clear(handle)
		if status == C.CYLFUSE_STATUS_OK {
			fitter.state.Lock()
			defer fitter.state.Unlock()
			fitter.selected, fitter.cameras = 0, fitter.cameras[:1]
		}
		return status
	})
}

// Input is data of a view, one bit each.
type Input uint32

const (
	// InputPoints: all points, those of clouds and those that were made of depth images.
	InputPoints Input = C.CYLFUSE_INPUT_POINTS
	// InputDepth: the depth image and its mask, which completion and extent look at; the points made of it stay.
	InputDepth Input = C.CYLFUSE_INPUT_DEPTH
	// InputEdges: edge segments, of PushEdges.
	InputEdges Input = C.CYLFUSE_INPUT_EDGES
	// InputImage: the image, of PushImage and of a frame.
	InputImage Input = C.CYLFUSE_INPUT_IMAGE
)

// ClearInput forgets some of the data of the selected view, and keeps the rest and the last result.
func (fitter *Fitter) ClearInput(inputs Input) error {
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_clear_input(handle, C.cylfuse_input(inputs))
	})
}

// Cancel asks the calls that are running to stop: a fit returns StatusCancelled before its next iteration. When no
// call is running it does nothing. May come from any goroutine and from callbacks.
func (fitter *Fitter) Cancel() error {
	return fitter.object.call(func(handle unsafe.Pointer) C.cylfuse_status {
		return C.cylfuse_fitter_cancel((*C.cylfuse_fitter)(handle))
	})
}

// SetOptions replaces the options.
func (fitter *Fitter) SetOptions(options Options) error {
	c := options.toC()
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_set_options(handle, &c)
	})
}

// Options reads the options.
func (fitter *Fitter) Options() (Options, error) {
	var c C.cylfuse_options
	C.cylfuse_options_init(&c, C.sizeof_cylfuse_options)
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_get_options(handle, &c)
	})
	if err != nil {
		return Options{}, err
	}
	return optionsFromC(&c), nil
}

// SelectView selects a view, so that the methods that set or push something, and those whose text says so, concern that
// view. There is one view at first, number 0, and it is selected; the number of views adds one, at the identity and
// without a camera.
//
// All views see the same cylinder. A fit uses the data of all of them; models, results and extents are in the reference
// frame, in which the poses of the views are given.
func (fitter *Fitter) SelectView(index int) error {
	if index < 0 {
		return shapeError("view %d: views count from 0", index)
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		status := C.cylfuse_fitter_select_view(handle, C.size_t(index))
		if status == C.CYLFUSE_STATUS_OK {
			fitter.state.Lock()
			defer fitter.state.Unlock()
			if fitter.selected = index; index == len(fitter.cameras) {
				fitter.cameras = append(fitter.cameras, size{})
			}
		}
		return status
	})
}

// ViewCount says how many views there are, at least 1.
func (fitter *Fitter) ViewCount() (int, error) {
	var count C.size_t
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_view_count(handle, &count)
	})
	return int(count), err
}

// SetPose sets where the camera of the selected view is in the reference frame; the identity at first.
func (fitter *Fitter) SetPose(pose Pose) error {
	rotation, translation := pose.toC()
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_set_pose(handle, &rotation[0], &translation[0])
	})
}

// SetIntrinsics sets the colour camera of the selected view, which depth images, images and edges need. Points that
// were pushed before stay as they are.
func (fitter *Fitter) SetIntrinsics(intrinsics Intrinsics) error {
	c, err := intrinsics.toC()
	if err != nil {
		return err
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		status := C.cylfuse_fitter_set_intrinsics(handle, &c)
		if status == C.CYLFUSE_STATUS_OK {
			fitter.keepSize(size{intrinsics.Width, intrinsics.Height})
		}
		return status
	})
}

// Intrinsics reads the colour camera of the selected view, which was set or came with a frame; StatusBadState where it has
// none.
func (fitter *Fitter) Intrinsics() (Intrinsics, error) {
	var c C.cylfuse_intrinsics
	C.cylfuse_intrinsics_init(&c, C.sizeof_cylfuse_intrinsics)
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_get_intrinsics(handle, &c)
	})
	if err != nil {
		return Intrinsics{}, err
	}
	return intrinsicsFromC(&c), nil
}

// SetDepthCamera gives the depth of the selected view a camera of its own, for depth that is not registered to the
// colour image: depth images that are pushed later are then in its pixels; mask, image and edges stay in those of the
// colour camera. nil takes it away.
func (fitter *Fitter) SetDepthCamera(camera *DepthCamera) error {
	c, err := camera.toC()
	if err != nil {
		return err
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_set_depth_camera(handle, c.intrinsics, &c.rotation[0], &c.translation[0])
	})
}

// UseFrame lets the selected view take camera, depth camera, pose and images from a frame, in place of its own, and
// adds the points of the depth image inside a mask (nil = all pixels), if there is one. Points and edge segments that
// were pushed stay. The images are shared and not copied. The frame may be changed or closed afterwards, of which the
// fitter sees nothing.
func (fitter *Fitter) UseFrame(frame *Frame, mask *Mask) error {
	return frame.open(func(native *native) error {
		frame.state.Lock()
		camera := frame.size
		frame.state.Unlock()
		return fitter.callWithMask(mask, func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status {
			status := C.bridge_use_frame(handle, (*C.cylfuse_frame)(native.handle), mask.view, mask.data)
			if status == C.CYLFUSE_STATUS_OK {
				fitter.keepSize(camera)
			}
			return status
		})
	})
}

// keepSize keeps the size of the camera of the selected view.
func (fitter *Fitter) keepSize(camera size) {
	fitter.state.Lock()
	defer fitter.state.Unlock()
	fitter.cameras[fitter.selected] = camera
}

// SetStartModel sets a candidate in the reference frame for StartAuto, the start of StartModel; nil takes it away.
func (fitter *Fitter) SetStartModel(model *Cylinder) error {
	c := model.optional()
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_set_start_model(handle, c)
	})
}

// PushPoints adds points to the selected view, in its camera frame when edges, the near-wall rule, completion or extent
// matter, else in any frame. The mask selects points of an organised cloud; nil = all.
func (fitter *Fitter) PushPoints(points PointCloud, mask *Mask) error {
	call, err := points.pointsView()
	if err != nil {
		return err
	}
	return fitter.callWithMask(mask, func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status {
		return C.bridge_push_points(handle, &call.view, call.data, call.weights, call.normals, mask.view, mask.data)
	})
}

// PushDepth adds the points of a depth image of the selected view; SetIntrinsics comes before. The mask is in the
// pixels of the colour image; nil = all pixels. Image and mask are kept, in place of earlier ones, for completion and
// extent.
func (fitter *Fitter) PushDepth(depth Depth, mask *Mask) error {
	call, err := depth.depthView()
	if err != nil {
		return err
	}
	return fitter.callWithMask(mask, func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status {
		return C.bridge_push_depth(handle, &call.view, call.data, mask.view, mask.data)
	})
}

// PushImage takes the image of the selected view, grey or in colour, in place of an earlier one; SetIntrinsics comes
// before. With ObjectiveRobust the limbs and the arcs of the ends are located in it and join the fit.
func (fitter *Fitter) PushImage(image Image) error {
	call, err := image.imageView()
	if err != nil {
		return err
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.bridge_push_image(handle, &call.view, call.data)
	})
}

// PushEdges adds edge segments to the selected view. A fit with segments needs intrinsics.
func (fitter *Fitter) PushEdges(edges Edges) error {
	call, err := edges.segmentsView()
	if err != nil {
		return err
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.bridge_push_edges(handle, &call.view, call.data, call.weights)
	})
}

// Counts says what was pushed into the selected view since the fitter was made or cleared, and what was left out by
// reason.
func (fitter *Fitter) Counts() (Counts, error) {
	var c C.cylfuse_counts
	C.cylfuse_counts_init(&c, C.sizeof_cylfuse_counts)
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status { return C.cylfuse_fitter_counts(handle, &c) })
	if err != nil {
		return Counts{}, err
	}
	return Counts{
		View:                 uint32(c.view),
		PointsGiven:          uint64(c.points_given),
		PointsUsed:           uint64(c.points_used),
		DroppedNotFinite:     uint64(c.dropped_not_finite),
		DroppedZeroWeight:    uint64(c.dropped_zero_weight),
		DroppedOutsideMask:   uint64(c.dropped_outside_mask),
		DroppedNoDepth:       uint64(c.dropped_no_depth),
		DroppedOutOfRange:    uint64(c.dropped_out_of_range),
		DroppedOutsideCamera: uint64(c.dropped_outside_camera),
		DroppedHidden:        uint64(c.dropped_hidden),
		SegmentsGiven:        uint64(c.segments_given),
	}, nil
}

// Fit estimates the cylinder from everything that was pushed into all views. When it fails the last result stays. Lack
// of convergence and other warnings are not errors but Flags of the result.
func (fitter *Fitter) Fit() (Result, error) {
	if !fitter.last.TryLock() {
		return Result{}, busy()
	}
	defer fitter.last.Unlock()
	return fitter.result(func(handle *C.cylfuse_fitter, result *C.cylfuse_result, estimate *C.cylfuse_cylinder_estimate) C.cylfuse_status {
		return C.cylfuse_fitter_fit(handle, result, estimate)
	})
}

// Evaluate says what a fit would report for a given cylinder in the reference frame, without iterating. The last result
// stays.
func (fitter *Fitter) Evaluate(model Cylinder) (Result, error) {
	c := model.toC()
	return fitter.result(func(handle *C.cylfuse_fitter, result *C.cylfuse_result, estimate *C.cylfuse_cylinder_estimate) C.cylfuse_status {
		return C.cylfuse_fitter_evaluate(handle, &c, result, estimate)
	})
}

// Result reads the result of the last fit that succeeded; StatusBadState when there is none.
func (fitter *Fitter) Result() (Result, error) {
	if !fitter.last.TryRLock() {
		return Result{}, busy()
	}
	defer fitter.last.RUnlock()
	return fitter.result(func(handle *C.cylfuse_fitter, result *C.cylfuse_result, estimate *C.cylfuse_cylinder_estimate) C.cylfuse_status {
		if status := C.cylfuse_fitter_get_result(handle, result); status != C.CYLFUSE_STATUS_OK {
			return status
		}
		return C.cylfuse_fitter_get_cylinder(handle, estimate)
	})
}

func (fitter *Fitter) result(run func(*C.cylfuse_fitter, *C.cylfuse_result, *C.cylfuse_cylinder_estimate) C.cylfuse_status) (Result, error) {
	var result C.cylfuse_result
	var estimate C.cylfuse_cylinder_estimate
	C.cylfuse_result_init(&result, C.sizeof_cylfuse_result)
	C.cylfuse_cylinder_estimate_init(&estimate, C.sizeof_cylfuse_cylinder_estimate)
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status { return run(handle, &result, &estimate) })
	if err != nil {
		return Result{}, err
	}
	return resultFromC(&result, &estimate), nil
}

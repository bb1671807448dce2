package cylfuse

// #include "bridge.h"
import "C"

import (
	"runtime"
	"sync"
	"unsafe"
)

// Fitter estimates one cylinder: it holds options, camera, data and the last result. Made by NewFitter.
//
// It runs one call at a time: a second one, from another goroutine or from a callback, gets StatusBusy.
type Fitter struct {
	// running is held by the one call that runs.
	running sync.Mutex
	// life guards native against Close for Cancel, which does not wait for the running call.
	life   sync.Mutex
	native *native

	progress func(Progress) bool
	log      func(LogLevel, string)
	// thrown is what a callback panicked with; the call goes on panicking when the library has returned.
	thrown any

	width, height int // of the camera, 0 before SetIntrinsics
}

// native is what the garbage collector has to free. It is apart from Fitter because a callback may well refer to its
// fitter, and Go frees no cycle with a finalizer in it.
type native struct {
	handle *C.cylfuse_fitter // nil when it was destroyed
}

func (native *native) free() { C.cylfuse_fitter_destroy(native.handle) }

// calling has the fitters that run a call, by their handles, for the callbacks. Between calls nothing global refers to a
// fitter, so that one that was forgotten is collected together with its callbacks.
var calling sync.Map

// NewFitter makes a fitter with default options and no data. Close frees what it holds; a forgotten one is freed by the
// garbage collector, which does not see how much memory that is.
func NewFitter() (*Fitter, error) {
	if err := checkLibrary(); err != nil {
		return nil, err
	}
	var handle *C.cylfuse_fitter
	create := func() C.cylfuse_status { return C.cylfuse_fitter_create(C.CYLFUSE_ABI_VERSION, &handle) }
	if err := withoutFitter(create); err != nil {
		return nil, err
	}
	owned := &native{handle}
	runtime.SetFinalizer(owned, (*native).free)
	return &Fitter{native: owned}, nil
}

// Close frees the fitter. A second Close does nothing. StatusBusy when a call on the fitter is running: nothing is freed
// then.
func (fitter *Fitter) Close() error {
	if !fitter.running.TryLock() {
		return busy()
	}
	defer fitter.running.Unlock()
	fitter.life.Lock()
	defer fitter.life.Unlock()
	handle := fitter.handle()
	if handle == nil {
		return nil
	}
	if err := statusError(C.cylfuse_fitter_destroy(handle)); err != nil {
		return err
	}
	runtime.SetFinalizer(fitter.native, nil)
	fitter.native.handle = nil
	return nil
}

// Reserve makes room, so that pushing that many more points and segments needs no memory.
func (fitter *Fitter) Reserve(points, segments int) error {
	if points < 0 || segments < 0 {
		return shapeError("%d points and %d segments: numbers are 0 or greater", points, segments)
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_reserve(handle, C.size_t(points), C.size_t(segments))
	})
}

// Clear forgets data, result and a pending request to cancel; it keeps options, camera, start model, callbacks and
// memory: the way from one frame to the next.
func (fitter *Fitter) Clear() error {
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status { return C.cylfuse_fitter_clear(handle) })
}

// Cancel asks the running fit to stop: it returns StatusCancelled before its next linear solve. When no fit is running,
// the next one stops at once, unless Clear comes before it. May come from any goroutine and from callbacks.
func (fitter *Fitter) Cancel() error {
	fitter.life.Lock()
	defer fitter.life.Unlock()
	handle := fitter.handle()
	if handle == nil {
		return ErrClosed
	}
	// Without this the finalizer might free the fitter during its last call.
	defer runtime.KeepAlive(fitter)
	return statusError(C.cylfuse_fitter_cancel(handle))
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
	c := C.cylfuse_options{struct_size: C.sizeof_cylfuse_options}
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_get_options(handle, &c)
	})
	if err != nil {
		return Options{}, err
	}
	return optionsFromC(&c), nil
}

// SetIntrinsics sets the camera, which depth images and edges need. Points that were pushed before stay as they are.
func (fitter *Fitter) SetIntrinsics(intrinsics Intrinsics) error {
	c, err := intrinsics.toC()
	if err != nil {
		return err
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		status := C.cylfuse_fitter_set_intrinsics(handle, &c)
		if status == C.CYLFUSE_STATUS_OK {
			fitter.width, fitter.height = intrinsics.Width, intrinsics.Height
		}
		return status
	})
}

// SetStartModel sets a candidate for StartAuto, the start of StartModel; nil takes it away.
func (fitter *Fitter) SetStartModel(model *Cylinder) error {
	c := model.optional()
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_set_start_model(handle, c)
	})
}

// PushPoints adds points, in the camera frame when edges, the near-wall rule, completion or extent matter, else in any
// frame. The mask selects points of an organised cloud; nil = all.
func (fitter *Fitter) PushPoints(points PointCloud, mask *Mask) error {
	call, err := points.pointsView()
	if err != nil {
		return err
	}
	return fitter.callWithMask(mask, func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status {
		return C.bridge_push_points(handle, &call.view, call.data, call.weights, call.normals, mask.view, mask.data)
	})
}

// PushDepth adds the points of a depth image of the camera; SetIntrinsics comes before. Image and mask (nil = all pixels)
// are kept, in place of earlier ones, for completion and extent.
func (fitter *Fitter) PushDepth(depth Depth, mask *Mask) error {
	call, err := depth.depthView()
	if err != nil {
		return err
	}
	return fitter.callWithMask(mask, func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status {
		return C.bridge_push_depth(handle, &call.view, call.data, mask.view, mask.data)
	})
}

// PushImage takes the grey image of the camera, in place of an earlier one; SetIntrinsics comes before. With
// ObjectiveRobust the limbs and the arcs of the ends are located in it and join the fit.
func (fitter *Fitter) PushImage(image Image) error {
	call, err := image.imageView()
	if err != nil {
		return err
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.bridge_push_image(handle, &call.view, call.data)
	})
}

// PushEdges adds edge segments. A fit with segments needs intrinsics.
func (fitter *Fitter) PushEdges(edges Edges) error {
	call, err := edges.segmentsView()
	if err != nil {
		return err
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.bridge_push_edges(handle, &call.view, call.data, call.weights)
	})
}

// Counts says what was pushed since the fitter was made or cleared, and what was left out by reason.
func (fitter *Fitter) Counts() (Counts, error) {
	c := C.cylfuse_counts{struct_size: C.sizeof_cylfuse_counts}
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status { return C.cylfuse_fitter_counts(handle, &c) })
	return Counts{
		PointsGiven:          uint64(c.points_given),
		PointsUsed:           uint64(c.points_used),
		DroppedNotFinite:     uint64(c.dropped_not_finite),
		DroppedZeroWeight:    uint64(c.dropped_zero_weight),
		DroppedOutsideMask:   uint64(c.dropped_outside_mask),
		DroppedNoDepth:       uint64(c.dropped_no_depth),
		DroppedOutOfRange:    uint64(c.dropped_out_of_range),
		DroppedOutsideCamera: uint64(c.dropped_outside_camera),
		SegmentsGiven:        uint64(c.segments_given),
	}, err
}

// Fit estimates the cylinder from everything that was pushed. When it fails the last result stays. No convergence and
// other doubts are not errors but Flags of the result.
func (fitter *Fitter) Fit() (Result, error) {
	return fitter.result(func(handle *C.cylfuse_fitter, out *C.cylfuse_result) C.cylfuse_status {
		return C.cylfuse_fitter_fit(handle, out)
	})
}

// Evaluate says what a fit would report for a given model, without iterating. The last result stays.
func (fitter *Fitter) Evaluate(model Cylinder) (Result, error) {
	c := model.toC()
	return fitter.result(func(handle *C.cylfuse_fitter, out *C.cylfuse_result) C.cylfuse_status {
		return C.cylfuse_fitter_evaluate(handle, &c, out)
	})
}

// Result reads the result of the last fit that succeeded; StatusBadState when there is none.
func (fitter *Fitter) Result() (Result, error) {
	return fitter.result(func(handle *C.cylfuse_fitter, out *C.cylfuse_result) C.cylfuse_status {
		return C.cylfuse_fitter_get_result(handle, out)
	})
}

// Residuals lists residuals of a model; nil = that of the last fit.
func (fitter *Fitter) Residuals(model *Cylinder, kind ResidualKind) ([]float64, error) {
	c := model.optional()
	var residuals []float64
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		counts := C.cylfuse_counts{struct_size: C.sizeof_cylfuse_counts}
		if status := C.cylfuse_fitter_counts(handle, &counts); status != C.CYLFUSE_STATUS_OK {
			return status
		}
		capacity := counts.points_used
		if kind == ResidualEdges {
			capacity = 2 * counts.segments_given
		}
		return list(&residuals, C.size_t(capacity), func(out *float64, capacity C.size_t, count *C.size_t) C.cylfuse_status {
			return C.cylfuse_fitter_residuals(handle, c, C.cylfuse_residual_kind(kind), (*C.double)(out), capacity, count)
		})
	})
	if err != nil {
		return nil, err
	}
	return residuals, nil
}

// LimbSamples lists what the last fit saw of the limbs in the grey image, used and refused. Empty when the image was not
// searched.
func (fitter *Fitter) LimbSamples() ([]LimbSample, error) {
	var raw []C.cylfuse_limb_sample
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		// Far more than an image gives: one of 640 x 480 pixels some 16.
		return list(&raw, 1024, func(out *C.cylfuse_limb_sample, capacity C.size_t, count *C.size_t) C.cylfuse_status {
			return C.cylfuse_fitter_limb_samples(handle, out, capacity, count)
		})
	})
	if err != nil {
		return nil, err
	}
	samples := make([]LimbSample, len(raw))
	for i, c := range raw {
		samples[i] = LimbSample{
			Pixel:  [2]float64{float64(c.pixel[0]), float64(c.pixel[1])},
			Sigma:  float64(c.sigma),
			Weight: float64(c.weight),
			Limb:   uint32(c.limb),
		}
	}
	return samples, nil
}

// Diagnose says what the data determine at a model (nil = that of the last fit), by an orthogonal factorisation of the
// whole Jacobian: more precise than Result.Condition, and far slower.
func (fitter *Fitter) Diagnose(model *Cylinder) (Diagnosis, error) {
	c := model.optional()
	out := C.cylfuse_diagnosis{struct_size: C.sizeof_cylfuse_diagnosis}
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_diagnose(handle, c, &out)
	})
	diagnosis := Diagnosis{
		Rank:          uint32(out.rank),
		Condition:     float64(out.condition),
		WeakestShift:  vectorFromC(out.weakest_shift),
		WeakestTilt:   vectorFromC(out.weakest_tilt),
		WeakestRadius: float64(out.weakest_radius),
	}
	for i, value := range out.singular_values {
		diagnosis.SingularValues[i] = float64(value)
	}
	return diagnosis, err
}

// Complete casts the ray of every pixel of a mask (nil = that of the last depth image) and takes its first meeting with
// a model (nil = that of the last fit): x, y, z of point after point in the camera frame.
func Complete[T float32 | float64](fitter *Fitter, model *Cylinder, mask *Mask, layout Layout) ([]T, Completion, error) {
	c := model.optional()
	var points []T
	completion := C.cylfuse_completion{struct_size: C.sizeof_cylfuse_completion}
	err := fitter.callWithMask(mask, func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status {
		var capacity C.size_t
		status := C.bridge_complete_bound(handle, mask.view, mask.data, C.cylfuse_layout(layout), &capacity)
		if status != C.CYLFUSE_STATUS_OK {
			return status
		}
		points = make([]T, 3*int(capacity))
		var out C.cylfuse_points_out
		C.cylfuse_points_out_init(&out, C.sizeof_cylfuse_points_out)
		out.scalar = scalarOf[T]()
		out.capacity = capacity
		out.layout = C.cylfuse_layout(layout)
		return C.bridge_complete(handle, c, mask.view, mask.data, &out, first(points), &completion)
	})
	if err != nil {
		return nil, Completion{}, err
	}
	if layout == LayoutPacked {
		points = points[:3*int(completion.count)]
	}
	return points, completionFromC(&completion), nil
}

// CompleteDepth writes the z of every point of Complete into a depth image of the camera, in units of `scale` lengths,
// and 0 where there is none.
func CompleteDepth[T uint16 | float32](fitter *Fitter, model *Cylinder, mask *Mask, scale float64) (DepthImage[T], Completion, error) {
	c := model.optional()
	var image DepthImage[T]
	completion := C.cylfuse_completion{struct_size: C.sizeof_cylfuse_completion}
	err := fitter.callWithMask(mask, func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status {
		width, height := fitter.width, fitter.height
		image = DepthImage[T]{Data: make([]T, width*height), Width: width, Height: height, Scale: scale}
		var out C.cylfuse_depth_out
		C.cylfuse_depth_out_init(&out, C.sizeof_cylfuse_depth_out)
		out.format = depthFormatOf[T]()
		out.width = C.uint32_t(width)
		out.height = C.uint32_t(height)
		out.scale = C.double(scale)
		return C.bridge_complete_depth(handle, c, mask.view, mask.data, &out, first(image.Data), &completion)
	})
	if err != nil {
		return DepthImage[T]{}, Completion{}, err
	}
	return image, completionFromC(&completion), nil
}

// Extent finds the visible piece of a model (nil = that of the last fit) in a mask (nil = that of the last depth image)
// and what its ends are, by Options.ExtentRule.
func (fitter *Fitter) Extent(model *Cylinder, mask *Mask) (Extent, error) {
	c := model.optional()
	out := C.cylfuse_extent{struct_size: C.sizeof_cylfuse_extent}
	err := fitter.callWithMask(mask, func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status {
		return C.bridge_extent(handle, c, mask.view, mask.data, &out)
	})
	if err != nil {
		return Extent{}, err
	}
	return extentFromC(&out), nil
}

// SelectEdges selects, of straight edges that a line detector found in the image, those on the two limbs of a rough
// cylinder (nil = that of the last fit) beside the points that were pushed: 1 or 2 for the limb that a segment lies on,
// in the order of Cylinder.Project, 0 for none. A limb may be `reach` pixels from that of the model; 0 = 15 % of the
// distance of the limbs, at least 4. Nothing is pushed, and weights are ignored.
func (fitter *Fitter) SelectEdges(edges Edges, model *Cylinder, reach float64) ([]uint8, error) {
	call, err := edges.segmentsView()
	if err != nil {
		return nil, err
	}
	c := model.optional()
	limbs := make([]uint8, int(call.view.count))
	err = fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.bridge_select_edges(handle, c, &call.view, call.data, C.double(reach), first(limbs), C.size_t(len(limbs)))
	})
	if err != nil {
		return nil, err
	}
	return limbs, nil
}

func (fitter *Fitter) result(run func(*C.cylfuse_fitter, *C.cylfuse_result) C.cylfuse_status) (Result, error) {
	out := newResult()
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status { return run(handle, &out) })
	if err != nil {
		return Result{}, err
	}
	return resultFromC(&out), nil
}

// call runs one call on the open fitter, alone, and turns its status into an error.
//
// The library would answer BUSY by itself, but its message belongs to the call that runs: taking the lock here keeps
// the message of a failed call from changing before it is read.
func (fitter *Fitter) call(run func(handle *C.cylfuse_fitter) C.cylfuse_status) error {
	if !fitter.running.TryLock() {
		return busy()
	}
	defer fitter.running.Unlock()
	handle := fitter.handle()
	if handle == nil {
		return ErrClosed
	}
	// This also keeps the finalizer from freeing the fitter during its last call.
	calling.Store(unsafe.Pointer(handle), fitter)
	defer calling.Delete(unsafe.Pointer(handle))
	status := run(handle)
	if thrown := fitter.thrown; thrown != nil {
		fitter.thrown = nil
		panic(thrown)
	}
	if status == C.CYLFUSE_STATUS_OK {
		return nil
	}
	return &Error{Status(status), C.GoString(C.cylfuse_fitter_last_error(handle))}
}

// callWithMask is call with a mask, whose shape is checked before.
func (fitter *Fitter) callWithMask(mask *Mask, run func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status) error {
	view, err := mask.maskView()
	if err != nil {
		return err
	}
	return fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status { return run(handle, view) })
}

// handle is nil when the fitter is closed, or was not made by NewFitter.
func (fitter *Fitter) handle() *C.cylfuse_fitter {
	if fitter.native == nil {
		return nil
	}
	return fitter.native.handle
}

func busy() error { return statusError(C.CYLFUSE_STATUS_BUSY) }

// list makes a slice of what the library lists. A `capacity` that is large enough saves asking for the number of items,
// which fails for the library, and so would reach the log.
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

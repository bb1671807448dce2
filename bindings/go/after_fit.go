package cylfuse

// #include "bridge.h"
import "C"

import "unsafe"

// Residuals lists residuals of the selected view for a model in the reference frame; nil = that of the last fit.
func (fitter *Fitter) Residuals(model *Cylinder, kind ResidualKind) ([]float64, error) {
	c := model.optional()
	var residuals []float64
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		var counts C.cylfuse_counts
		C.cylfuse_counts_init(&counts, C.sizeof_cylfuse_counts)
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

// PointWeights lists how much each point of the selected view counts at the cylinder of the last fit, in the order of
// ResidualPoints, by the weights of ObjectiveRobust, whatever was minimised: from 1 for a point on the surface down to
// 0 for an outlier, without the weight that it was given; an inlier is a point whose weight is above 0.
func (fitter *Fitter) PointWeights() (weights []float64, inliers []bool, err error) {
	var bytes []uint8
	err = fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		var counts C.cylfuse_counts
		C.cylfuse_counts_init(&counts, C.sizeof_cylfuse_counts)
		if status := C.cylfuse_fitter_counts(handle, &counts); status != C.CYLFUSE_STATUS_OK {
			return status
		}
		return list(&weights, C.size_t(counts.points_used), func(out *float64, capacity C.size_t, count *C.size_t) C.cylfuse_status {
			bytes = make([]uint8, capacity+1)
			return C.cylfuse_fitter_point_weights(handle, (*C.double)(out), (*C.uint8_t)(&bytes[0]), capacity, count)
		})
	})
	if err != nil {
		return nil, nil, err
	}
	inliers = make([]bool, len(weights))
	for i := range inliers {
		inliers[i] = bytes[i] != 0
	}
	return weights, inliers, nil
}

// PointParts tells what each point of the selected view belongs to, in the order of ResidualPoints, for a model in the
// reference frame; nil = that of the last fit.
func (fitter *Fitter) PointParts(model *Cylinder) ([]Part, error) {
	c := model.optional()
	var parts []Part
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		var counts C.cylfuse_counts
		C.cylfuse_counts_init(&counts, C.sizeof_cylfuse_counts)
		if status := C.cylfuse_fitter_counts(handle, &counts); status != C.CYLFUSE_STATUS_OK {
			return status
		}
		return list(&parts, C.size_t(counts.points_used), func(out *Part, capacity C.size_t, count *C.size_t) C.cylfuse_status {
			return C.cylfuse_fitter_point_parts(handle, c, (*C.cylfuse_part)(out), capacity, count)
		})
	})
	if err != nil {
		return nil, err
	}
	return parts, nil
}

// Limbs lists the two limbs of the last fit in each view, view after view: where they were located in the image, or why
// they were not. All are LimbNotSearched once data or options have changed since.
func (fitter *Fitter) Limbs() ([]Limb, error) {
	var raw []C.cylfuse_limb
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		var views C.size_t
		if status := C.cylfuse_fitter_view_count(handle, &views); status != C.CYLFUSE_STATUS_OK {
			return status
		}
		return list(&raw, 2*views, func(out *C.cylfuse_limb, capacity C.size_t, count *C.size_t) C.cylfuse_status {
			return C.cylfuse_fitter_limbs(handle, out, C.sizeof_cylfuse_limb, capacity, count)
		})
	})
	if err != nil {
		return nil, err
	}
	limbs := make([]Limb, len(raw))
	for i, c := range raw {
		limbs[i] = Limb{
			View:      uint32(c.view),
			Limb:      uint32(c.limb),
			Status:    LimbStatus(c.status),
			Samples:   uint32(c.samples),
			Line:      *(*[4]float64)(unsafe.Pointer(&c.line)),
			Deviation: float64(c.deviation),
		}
	}
	return limbs, nil
}

// manySamples is far more than an image gives: one of 640 x 480 pixels gives some 16.
const manySamples = 1024

// LimbSamples lists what the last fit saw of the limbs in the image of the selected view, piece by piece, used and
// refused. Empty when the image was not searched, and once data or options have changed since.
func (fitter *Fitter) LimbSamples() ([]LimbSample, error) {
	var raw []C.cylfuse_limb_sample
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return list(&raw, manySamples, func(out *C.cylfuse_limb_sample, capacity C.size_t, count *C.size_t) C.cylfuse_status {
			return C.cylfuse_fitter_limb_samples(handle, out, C.sizeof_cylfuse_limb_sample, capacity, count)
		})
	})
	if err != nil {
		return nil, err
	}
	samples := make([]LimbSample, len(raw))
	for i, c := range raw {
		samples[i] = LimbSample{
			View:      uint32(c.view),
			Limb:      uint32(c.limb),
			Pixel:     [2]float64{float64(c.pixel[0]), float64(c.pixel[1])},
			Deviation: float64(c.deviation),
			Weight:    float64(c.weight),
		}
	}
	return samples, nil
}

// EndSamples lists the samples on the arcs of both ends that Extent finds in the images, view after view: first those of
// the start, then those of the end. There are none for an end that the image of a view does not show.
func (fitter *Fitter) EndSamples(model *Cylinder, mask *Mask) ([]EndSample, error) {
	cylinder := model.optional()
	var raw []C.cylfuse_end_sample
	err := fitter.callWithMask(mask, func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status {
		return list(&raw, manySamples, func(out *C.cylfuse_end_sample, capacity C.size_t, count *C.size_t) C.cylfuse_status {
			return C.bridge_end_samples(handle, cylinder, mask.view, mask.data, out, capacity, count)
		})
	})
	if err != nil {
		return nil, err
	}
	samples := make([]EndSample, len(raw))
	for i, c := range raw {
		samples[i] = EndSample{
			View:      uint32(c.view),
			End:       uint32(c.end),
			Pixel:     [2]float64{float64(c.pixel[0]), float64(c.pixel[1])},
			Normal:    [2]float64{float64(c.normal[0]), float64(c.normal[1])},
			Deviation: float64(c.deviation),
		}
	}
	return samples, nil
}

// Diagnose says what the data determine at a model (nil = that of the last fit), by an orthogonal factorisation of the
// whole Jacobian: more precise than Result.Condition, and far slower.
func (fitter *Fitter) Diagnose(model *Cylinder) (Diagnosis, error) {
	c := model.optional()
	var out C.cylfuse_cylinder_diagnosis
	C.cylfuse_cylinder_diagnosis_init(&out, C.sizeof_cylfuse_cylinder_diagnosis)
	err := fitter.call(func(handle *C.cylfuse_fitter) C.cylfuse_status {
		return C.cylfuse_fitter_diagnose(handle, c, &out)
	})
	if err != nil {
		return Diagnosis{}, err
	}
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
	return diagnosis, nil
}

// Complete casts the ray of every pixel of a mask (nil = that of the selected view) and takes its first meeting with a
// model (nil = that of the last fit): x, y, z of point after point in the reference frame, so that those of all views
// go together.
func Complete[T float32 | float64](fitter *Fitter, model *Cylinder, mask *Mask, layout Layout) ([]T, Completion, error) {
	c := model.optional()
	var points []T
	var completion C.cylfuse_completion
	C.cylfuse_completion_init(&completion, C.sizeof_cylfuse_completion)
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
		return C.bridge_complete(handle, c, mask.view, mask.data, C.cylfuse_layout(layout), &out, first(points), &completion)
	})
	if err != nil {
		return nil, Completion{}, err
	}
	if layout == LayoutPacked {
		points = points[:3*int(completion.count)]
	}
	return points, completionFromC(&completion), nil
}

// CompleteDepth writes the z of every point of Complete, in the camera frame of the selected view, into a depth image
// on the pixels of its colour camera, in units of `scale` lengths, and 0 where there is none.
func CompleteDepth[T uint16 | float32](fitter *Fitter, model *Cylinder, mask *Mask, scale float64) (DepthImage[T], Completion, error) {
	c := model.optional()
	var image DepthImage[T]
	var completion C.cylfuse_completion
	C.cylfuse_completion_init(&completion, C.sizeof_cylfuse_completion)
	err := fitter.callWithMask(mask, func(handle *C.cylfuse_fitter, mask maskView) C.cylfuse_status {
		fitter.state.Lock()
		width, height := fitter.cameras[fitter.selected].width, fitter.cameras[fitter.selected].height
		fitter.state.Unlock()
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

// Extent finds the visible piece of a model (nil = that of the last fit) and what its ends are: in a view with a camera and a
// mask by Options.ExtentRule, in others, and from inside a pipe, by the points on the surface. `mask` stands for that of the
// selected view (nil = the one that was pushed). An end that is seen in several views is their mean by their variances; one that is seen in none is the
// outermost of what they show.
func (fitter *Fitter) Extent(model *Cylinder, mask *Mask) (Extent, error) {
	c := model.optional()
	var out C.cylfuse_extent
	C.cylfuse_extent_init(&out, C.sizeof_cylfuse_extent)
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

package cylfuse

// #include "bridge.h"
import "C"

import (
	"time"
	"unsafe"
)

// Termination is why an iteration ended.
type Termination int32

const (
	// TerminationNone: there was no iteration.
	TerminationNone Termination = C.CYLFUSE_TERMINATION_NONE
	// TerminationCost: the cost no longer fell by more than the tolerance.
	TerminationCost Termination = C.CYLFUSE_TERMINATION_COST
	// TerminationStalled: no step down to the largest damping lowered the cost, a minimum to rounding.
	TerminationStalled Termination = C.CYLFUSE_TERMINATION_STALLED
	// TerminationMaxIterations: the limit of iterations was reached.
	TerminationMaxIterations Termination = C.CYLFUSE_TERMINATION_MAX_ITERATIONS
	// TerminationRadiusRanAway: the radius left all proportion to the data, they are flat.
	TerminationRadiusRanAway Termination = C.CYLFUSE_TERMINATION_RADIUS_RAN_AWAY
	// TerminationGradient: the gradient fell below its tolerance.
	TerminationGradient Termination = C.CYLFUSE_TERMINATION_GRADIENT
	// TerminationStep: the step fell below its tolerance.
	TerminationStep Termination = C.CYLFUSE_TERMINATION_STEP
)

// Flags are warnings about a result, one bit each. None of them is an error.
type Flags uint32

const (
	// FlagEdgesIgnored: segments were given but none of them counts.
	FlagEdgesIgnored Flags = C.CYLFUSE_RESULT_FLAGS_EDGES_IGNORED
	// FlagSegmentsUnusable: some segments have no length or lie outside the field of the camera model.
	FlagSegmentsUnusable Flags = C.CYLFUSE_RESULT_FLAGS_SEGMENTS_UNUSABLE
	// FlagEdgesCross: two segments cross each other, they cannot be the two limbs.
	FlagEdgesCross Flags = C.CYLFUSE_RESULT_FLAGS_EDGES_CROSS
	// FlagEdgesCoincide: two segments lie on one line to within 2 pixels.
	FlagEdgesCoincide Flags = C.CYLFUSE_RESULT_FLAGS_EDGES_COINCIDE
	// FlagEdgesBehind: the rays of the endpoints do not meet the plane of the limbs in front of the camera.
	FlagEdgesBehind Flags = C.CYLFUSE_RESULT_FLAGS_EDGES_BEHIND
	// FlagScaleHeld: the edges alone do not tell the scale, that of the start was kept.
	FlagScaleHeld Flags = C.CYLFUSE_RESULT_FLAGS_SCALE_HELD
	// FlagWeakRadius: the data hardly determine the radius.
	FlagWeakRadius Flags = C.CYLFUSE_RESULT_FLAGS_WEAK_RADIUS
	// FlagResolutionLost: the coordinates are coarser than 0.01 % of the radius.
	FlagResolutionLost Flags = C.CYLFUSE_RESULT_FLAGS_RESOLUTION_LOST
	// FlagNotConverged: the limit of iterations came before convergence. Of a cylinder of a scene also: its depth came
	// without an image, no work was left for its fit, or no fit was as good, and it is what the search found.
	FlagNotConverged Flags = C.CYLFUSE_RESULT_FLAGS_NOT_CONVERGED
	// FlagHiddenWall: most points lie on the wall that the camera cannot see.
	FlagHiddenWall Flags = C.CYLFUSE_RESULT_FLAGS_HIDDEN_WALL
	// FlagCameraInside: the camera is inside the cylinder, there are no limbs.
	FlagCameraInside Flags = C.CYLFUSE_RESULT_FLAGS_CAMERA_INSIDE
	// FlagPointsNotFinite: points with coordinates that are not finite were left out.
	FlagPointsNotFinite Flags = C.CYLFUSE_RESULT_FLAGS_POINTS_NOT_FINITE
	// FlagPointsAndLimbsDisagree: the radius by the points and that by the limbs differ by more than 4 deviations, or the
	// points contradict limbs or edges, which were not followed.
	FlagPointsAndLimbsDisagree Flags = C.CYLFUSE_RESULT_FLAGS_POINTS_AND_LIMBS_DISAGREE
	// FlagRadiusAtLimit: a limit of the radius holds it, or the data contradict a known radius by more than 4 deviations.
	FlagRadiusAtLimit Flags = C.CYLFUSE_RESULT_FLAGS_RADIUS_AT_LIMIT
	// FlagAxisAtLimit: the axis is on the border of its cone, or the data contradict a known direction by more than 4
	// deviations.
	FlagAxisAtLimit Flags = C.CYLFUSE_RESULT_FLAGS_AXIS_AT_LIMIT
	// FlagUncertaintyUnknown: the data do not tell how uncertain the result is, and deviations and covariance are NaN: fewer
	// than eight points are independent, some degree of freedom is not determined, the coordinates are coarser than the
	// noise, or most points lie on the cylinder to the last digit and more than a tenth do not.
	FlagUncertaintyUnknown Flags = C.CYLFUSE_RESULT_FLAGS_UNCERTAINTY_UNKNOWN
	// FlagDepthShifted: depth and image are shifted against each other across the axis. Or one of the limbs is the edge of
	// something else, and the radius is wrong. From a detector also: the whole depth image was shifted, and has been moved.
	FlagDepthShifted Flags = C.CYLFUSE_RESULT_FLAGS_DEPTH_SHIFTED
	// FlagMaskEndsWithDepth: a mask holds the pixels that have depth and no others, so its sides are no hint where the limbs are.
	FlagMaskEndsWithDepth Flags = C.CYLFUSE_RESULT_FLAGS_MASK_ENDS_WITH_DEPTH
	// FlagPoorFit: the points do not lie on the cylinder: they scatter about its surface by more than 1 % of their distance
	// from the camera or, without a camera, by more than a quarter of the radius, or have a shape along the axis that no
	// cylinder has, or lie on two planes, as the sides of a box do.
	FlagPoorFit Flags = C.CYLFUSE_RESULT_FLAGS_POOR_FIT
	// FlagBodyTapers: the lines of both limbs turn against each other, so that the radius changes along the axis: the
	// body is no cylinder, or one of the lines is no limb. Or, without them, the sides of the mask do, or points without a camera tell it.
	FlagBodyTapers Flags = C.CYLFUSE_RESULT_FLAGS_BODY_TAPERS
	// FlagMaskDisagrees: the mask ends beside a limb of the cylinder along most of the axis, by more than masks are off and
	// the deviation of the radius says; or no limb was seen, and the radii by the mask and by the points differ by more than
	// 2.5 standard deviations, or the points would scatter 3 times as much if the mask were followed; or the mask holds
	// another body.
	FlagMaskDisagrees Flags = C.CYLFUSE_RESULT_FLAGS_MASK_DISAGREES
)

// Has says whether all of these warnings are there.
func (flags Flags) Has(warnings Flags) bool { return flags&warnings == warnings }

// Result is the outcome of a fit: the cylinder, how certain it is, and the numbers to judge it. NaN stands for what
// does not apply.
//
// Deviations and covariance are those of the noise of the data. With MethodFused and ObjectiveRobust they also have the
// errors that all points of a view share and DepthShared of the options states, by default 0.2 % of the depth. Errors of
// the calibration, the registration and a scale of the depth are not in them. They are NaN for RANSAC and Eberly, for an
// edge weight of 1, and where the data do not determine the number.
type Result struct {
	// Cylinder is in the reference frame; its axis point is the one nearest to the middle of the points.
	Cylinder Cylinder
	// StartCylinder is the cylinder that the iteration started from, moved into the limits.
	StartCylinder Cylinder
	// StartKind is how the start was found.
	StartKind Start
	// RadiusDeviation is the standard deviation of the radius, unit of length.
	RadiusDeviation float64
	// DirectionDeviation is the standard deviation of the direction in radians, in the plane in which it is least
	// certain.
	DirectionDeviation float64
	// PositionDeviation is the standard deviation of the axis across itself at Cylinder.Point, where it is least
	// certain, unit of length.
	PositionDeviation float64
	// RadiusFromPoints is the radius by the curvature of the points alone; NaN without segments or limbs.
	RadiusFromPoints, RadiusFromPointsDeviation float64
	// RadiusFromLimbs is the radius by the limbs, with distance and tilt of the axis from the points.
	RadiusFromLimbs, RadiusFromLimbsDeviation float64
	// RadiusZScore is RadiusFromPoints - RadiusFromLimbs in standard deviations of the difference.
	RadiusZScore float64
	// Covariance of (point, direction, radius), symmetric, of rank 5.
	Covariance [7][7]float64

	// Flags are the warnings; 0 when there are none.
	Flags Flags
	// Termination is why the iteration ended.
	Termination Termination
	// Iterations counts the iterations, RejectedSteps those whose step was rejected.
	Iterations, RejectedSteps uint32
	// LimbsLocated counts the limb lines that were located in the images and took part, at most 2 a view.
	LimbsLocated uint32
	// SegmentsUsed took part of the SegmentsGiven.
	SegmentsGiven, SegmentsUsed uint32
	// PointsUsed took part of the PointsGiven; Counts says why the others were left out.
	PointsGiven, PointsUsed uint64
	// IndependentPoints is how many points with independent noise the points of all views are worth: the noise of
	// neighbours in a depth image is alike.
	IndependentPoints float64
	// PointDeviation is the standard deviation of the points from the surface by their median, unit of length.
	PointDeviation float64
	// PointRMS is the root mean square distance of the points from the surface, unit of length.
	PointRMS float64
	// EdgeRMSPixels is the root mean square distance of the given endpoints from the limb lines in ideal pixels.
	EdgeRMSPixels float64
	// NearWallFraction is the part of the points on the wall that the camera sees.
	NearWallFraction float64
	// InitialCost is the cost of the start, Cost that of the outcome, unit of length squared.
	InitialCost, Cost float64
	// EnergyPoints is E_P, the mean squared distance of the points from the surface, unit of length squared.
	EnergyPoints float64
	// EnergyEdges is E_L, the mean squared distance of the back-projected endpoints from the limb lines, unit of length
	// squared; NaN without exactly two usable segments.
	EnergyEdges float64
	// EdgeWeight is the one that was used, 0 when no edges count; NaN where the objective has none.
	EdgeWeight float64
	// Condition number of the Jacobian at the outcome, in units of the size of the data; may be infinite.
	Condition float64
	// GradientNorm is that of half the gradient of the cost at the end, in units of the size of the data.
	GradientNorm float64
	// StepNorm is that of the last accepted step, in units of the size of the data.
	StepNorm float64
	// Lambda is the last damping.
	Lambda float64
	// TimeStart, TimeSolve and TimeTotal are wall-clock times: to find the start, to iterate, of the whole fit.
	TimeStart, TimeSolve, TimeTotal time.Duration
}

func resultFromC(result *C.cylfuse_result, estimate *C.cylfuse_cylinder_estimate) Result {
	return Result{
		Cylinder:                  cylinderFromC(&estimate.model),
		StartCylinder:             cylinderFromC(&estimate.start_model),
		StartKind:                 Start(estimate.start_kind),
		RadiusDeviation:           float64(estimate.radius_deviation),
		DirectionDeviation:        float64(estimate.direction_deviation),
		PositionDeviation:         float64(estimate.position_deviation),
		RadiusFromPoints:          float64(estimate.radius_from_points),
		RadiusFromPointsDeviation: float64(estimate.radius_from_points_deviation),
		RadiusFromLimbs:           float64(estimate.radius_from_limbs),
		RadiusFromLimbsDeviation:  float64(estimate.radius_from_limbs_deviation),
		RadiusZScore:              float64(estimate.radius_z_score),
		Covariance:                *(*[7][7]float64)(unsafe.Pointer(&estimate.covariance)),

		Flags:             Flags(result.flags),
		Termination:       Termination(result.termination),
		Iterations:        uint32(result.iterations),
		RejectedSteps:     uint32(result.rejected_steps),
		LimbsLocated:      uint32(result.limbs_located),
		SegmentsGiven:     uint32(result.segments_given),
		SegmentsUsed:      uint32(result.segments_used),
		PointsGiven:       uint64(result.points_given),
		PointsUsed:        uint64(result.points_used),
		IndependentPoints: float64(result.independent_points),
		PointDeviation:    float64(result.point_deviation),
		PointRMS:          float64(result.point_rms),
		EdgeRMSPixels:     float64(result.edge_rms_pixels),
		NearWallFraction:  float64(result.near_wall_fraction),
		InitialCost:       float64(result.initial_cost),
		Cost:              float64(result.cost),
		EnergyPoints:      float64(result.energy_points),
		EnergyEdges:       float64(result.energy_edges),
		EdgeWeight:        float64(result.edge_weight),
		Condition:         float64(result.condition),
		GradientNorm:      float64(result.gradient_norm),
		StepNorm:          float64(result.step_norm),
		Lambda:            float64(result.lambda),
		TimeStart:         duration(result.seconds_start),
		TimeSolve:         duration(result.seconds_solve),
		TimeTotal:         duration(result.seconds_total),
	}
}

func duration(seconds C.double) time.Duration {
	return time.Duration(float64(seconds) * float64(time.Second))
}

// Counts says what was pushed into one view, and what was left out by reason.
type Counts struct {
	// View that the counts are of.
	View uint32
	// PointsGiven counts points and pixels that were pushed, PointsUsed those that a fit uses.
	PointsGiven, PointsUsed uint64
	// DroppedNotFinite: a coordinate or weight is not finite.
	DroppedNotFinite uint64
	// DroppedZeroWeight: the weight is 0.
	DroppedZeroWeight uint64
	// DroppedOutsideMask: the mask is 0 there.
	DroppedOutsideMask uint64
	// DroppedNoDepth: no depth was measured there.
	DroppedNoDepth uint64
	// DroppedOutOfRange: the depth is below MinDepth or above MaxDepth.
	DroppedOutOfRange uint64
	// DroppedOutsideCamera: the camera model has no ray for the pixel.
	DroppedOutsideCamera uint64
	// DroppedHidden: the mask is set there, but the colour camera sees something nearer. Only with a depth camera of
	// its own.
	DroppedHidden uint64
	// SegmentsGiven counts edge segments that were pushed.
	SegmentsGiven uint64
}

// ResidualKind says which residuals to list.
type ResidualKind int32

const (
	// ResidualPoints is the signed distance of every used point from the surface, in the unit of length, negative
	// inside; in the order in which the points were pushed, without the dropped ones.
	ResidualPoints ResidualKind = C.CYLFUSE_RESIDUAL_KIND_POINTS
	// ResidualEdges is the signed distance of both endpoints of every used segment from its limb line, in ideal pixels.
	ResidualEdges ResidualKind = C.CYLFUSE_RESIDUAL_KIND_EDGES
)

// Part is what a point in the mask belongs to.
type Part uint8

const (
	// PartBody: the lateral surface.
	PartBody Part = C.CYLFUSE_PART_BODY
	// PartCap: a cap, which lies in the plane across the axis at an end.
	PartCap Part = C.CYLFUSE_PART_CAP
	// PartInnerWall: the inside of the cylinder, seen through an open end: its inner wall or its bottom.
	PartInnerWall Part = C.CYLFUSE_PART_INNER_WALL
	// PartOther: something nearer than the surface: a lid or a rim that is wider, a handle, what stands in front.
	PartOther Part = C.CYLFUSE_PART_OTHER
	// PartBehind: something farther away than the cylinder, the background.
	PartBehind Part = C.CYLFUSE_PART_BEHIND
)

// LimbStatus says whether a limb was located in the image, or why not.
type LimbStatus int32

const (
	// LimbLocated: it was located.
	LimbLocated LimbStatus = C.CYLFUSE_LIMB_STATUS_LOCATED
	// LimbNotSearched: there is no image, the edges were taken as given, or the objective does not look.
	LimbNotSearched LimbStatus = C.CYLFUSE_LIMB_STATUS_NOT_SEARCHED
	// LimbNoLimbs: the camera is inside the cylinder, or it lies behind.
	LimbNoLimbs LimbStatus = C.CYLFUSE_LIMB_STATUS_NO_LIMBS
	// LimbTooShort: fewer than 12 rows or columns of the image show the limb, or something in front covers it.
	LimbTooShort LimbStatus = C.CYLFUSE_LIMB_STATUS_TOO_SHORT
	// LimbNoEdge: no line near the expected place has more of an edge than noise gives.
	LimbNoEdge LimbStatus = C.CYLFUSE_LIMB_STATUS_NO_EDGE
	// LimbOutOfReach: the line left the expected place while it was refined, or lies beside the mask.
	LimbOutOfReach LimbStatus = C.CYLFUSE_LIMB_STATUS_OUT_OF_REACH
	// LimbUncertain: the line would be less certain than one set by hand, or what is there is softer than any limb.
	LimbUncertain LimbStatus = C.CYLFUSE_LIMB_STATUS_UNCERTAIN
	// LimbPatchy: a small part of the line carries it all.
	LimbPatchy LimbStatus = C.CYLFUSE_LIMB_STATUS_PATCHY
	// LimbSameLine: the other limb was found at the same place, and more certainly.
	LimbSameLine LimbStatus = C.CYLFUSE_LIMB_STATUS_SAME_LINE
)

// Limb is a limb of the cylinder in the image of one view: where it was located, or why it was not.
type Limb struct {
	// View, from 0.
	View uint32
	// Limb is 0 or 1, in the order of Cylinder.Project.
	Limb uint32
	// Status says whether the limb was located, or why not.
	Status LimbStatus
	// Samples is how many pieces of it LimbSamples lists.
	Samples uint32
	// Line is x1, y1, x2, y2: the two points of the located line whose errors across it are independent and equally
	// large, in ideal pixels. NaN when the limb was not located.
	Line [4]float64
	// Deviation is the standard deviation of either point across the line, in ideal pixels; NaN likewise.
	Deviation float64
}

// LimbSample is what a short piece of a limb in the image says.
type LimbSample struct {
	// View, from 0.
	View uint32
	// Limb that it belongs to, 0 or 1, in the order of Cylinder.Project.
	Limb uint32
	// Pixel is where the limb is seen, x and y in the (distorted) image.
	Pixel [2]float64
	// Deviation is the standard deviation across the limb in ideal pixels, by the noise of the image only.
	Deviation float64
	// Weight is its part in the line, from 1 down to 0 for a refused one.
	Weight float64
}

// EndSample is a place on the arc of an end of the cylinder in the image.
type EndSample struct {
	// View, from 0.
	View uint32
	// End is 0 for the start of the extent, 1 for its end.
	End uint32
	// Pixel is where the arc is seen, x and y in the (distorted) image.
	Pixel [2]float64
	// Normal is the unit vector across the arc in the image, away from the surface.
	Normal [2]float64
	// Deviation is the standard deviation along Normal, in pixels.
	Deviation float64
}

// Diagnosis is what the data determine at a cylinder: the singular values of the stacked Jacobian of the five degrees
// of freedom, in units of the size of the data.
type Diagnosis struct {
	// Rank counts the singular values that stand out of the rounding error; 5 when everything is determined.
	Rank uint32
	// SingularValues, the largest first.
	SingularValues [5]float64
	// Condition is the largest over the smallest singular value; may be infinite.
	Condition float64
	// WeakestShift is how the step along which the residuals change least moves the axis, in the unit of length,
	WeakestShift [3]float64
	// WeakestTilt how it tilts the axis, in radians towards this vector,
	WeakestTilt [3]float64
	// WeakestRadius and how it changes the radius, in the unit of length.
	WeakestRadius float64
}

// Layout is how completed points are arranged.
type Layout int32

const (
	// LayoutPacked has only the points that exist, one after the other, row by row of the image.
	LayoutPacked Layout = C.CYLFUSE_LAYOUT_PACKED
	// LayoutOrganised has one point for each pixel of the image, NaN where there is none.
	LayoutOrganised Layout = C.CYLFUSE_LAYOUT_ORGANISED
)

// Completion is what became of the pixels.
type Completion struct {
	// View whose pixels were completed.
	View uint32
	// Count is the number of points or pixels that were written.
	Count uint64
	// Hits are pixels of the mask whose ray meets the cylinder, Misses those whose ray passes it by.
	Hits, Misses uint64
	// OutsideCamera counts pixels of the mask for which the camera model has no ray.
	OutsideCamera uint64
	// OutOfRange counts hits whose depth does not fit the pixel format: written as 0 and not in Count.
	OutOfRange uint64
}

func completionFromC(c *C.cylfuse_completion) Completion {
	return Completion{
		uint32(c.view), uint64(c.count), uint64(c.hits), uint64(c.misses), uint64(c.outside_camera), uint64(c.out_of_range),
	}
}

// EndState is what an end of the visible cylinder is.
type EndState int32

const (
	// EndUnknown: nothing tells what lies beyond the end: no depth was measured there, or no depth image pushed.
	EndUnknown EndState = C.CYLFUSE_END_STATE_UNKNOWN
	// EndSeen: the surface ends there.
	EndSeen EndState = C.CYLFUSE_END_STATE_SEEN
	// EndCut: the border of the image cuts the cylinder off.
	EndCut EndState = C.CYLFUSE_END_STATE_CUT
	// EndHidden: something nearer than the surface covers what lies beyond.
	EndHidden EndState = C.CYLFUSE_END_STATE_HIDDEN
)

// EndSource is what the position of an end was taken from.
type EndSource int32

const (
	// EndFromExtreme: the extreme point completed over the mask.
	EndFromExtreme EndSource = C.CYLFUSE_END_SOURCE_EXTREME
	// EndFromMask: where the lines along the surface leave the mask, or where within the mask the depth shows that the body
	// ends: at a cap, an opening, a shoulder or a narrower part. Also where the image shows an arc that is less certain than that.
	EndFromMask EndSource = C.CYLFUSE_END_SOURCE_MASK
	// EndFromImage: mostly the arc of the end circle in the image: it is joined with mask and depth by the variances, and
	// is the more certain.
	EndFromImage EndSource = C.CYLFUSE_END_SOURCE_IMAGE
	// EndFromBorder: the last of the surface inside the border of the image.
	EndFromBorder EndSource = C.CYLFUSE_END_SOURCE_BORDER
	// EndFromPoints: the points on the surface, where there is no mask, and from inside a pipe.
	EndFromPoints EndSource = C.CYLFUSE_END_SOURCE_POINTS
)

// Extent is the visible piece of the cylinder, in the reference frame: End = Start + Length * direction of the model.
type Extent struct {
	// StartState is what the end against the direction is, EndState what the end along it is.
	StartState, EndState EndState
	// StartSource and EndSource are what the positions were taken from.
	StartSource, EndSource EndSource
	// StartView and EndView are the views that tell most of the ends.
	StartView, EndView uint32
	// LimbsKnown: the limbs of the model were taken as good to a fraction of a pixel in these views, so that the bias
	// of the mask was read off at them.
	LimbsKnown bool
	// Start and End are points on the axis, Center the middle of them.
	Start, End, Center [3]float64
	// Length is the distance of the ends.
	Length float64
	// StartDeviation is the standard deviation of the position of the start along the axis, for a model without error;
	// NaN for an extreme position. EndDeviation is the same for the end.
	StartDeviation, EndDeviation float64
	// LengthDeviation is the standard deviation of the length together with the uncertainty of the fit. This and what
	// follows is NaN for a model that was given, for extreme positions and when the fit has no uncertainty.
	LengthDeviation float64
	// StartCovariance, EndCovariance and CenterCovariance are those of the points, unit of length squared.
	StartCovariance, EndCovariance, CenterCovariance [3][3]float64
}

func extentFromC(c *C.cylfuse_extent) Extent {
	return Extent{
		StartState:       EndState(c.start_state),
		EndState:         EndState(c.end_state),
		StartSource:      EndSource(c.start_source),
		EndSource:        EndSource(c.end_source),
		StartView:        uint32(c.start_view),
		EndView:          uint32(c.end_view),
		LimbsKnown:       c.limbs_known != 0,
		Start:            vectorFromC(c.start),
		End:              vectorFromC(c.end),
		Center:           vectorFromC(c.center),
		Length:           float64(c.length),
		StartDeviation:   float64(c.start_deviation),
		EndDeviation:     float64(c.end_deviation),
		LengthDeviation:  float64(c.length_deviation),
		StartCovariance:  matrixFromC(c.start_covariance),
		EndCovariance:    matrixFromC(c.end_covariance),
		CenterCovariance: matrixFromC(c.center_covariance),
	}
}

package cylfuse

// #include "bridge.h"
import "C"

// Method is how the cylinder is estimated.
type Method int32

const (
	// MethodFused takes points and edges together, by the chosen Objective.
	MethodFused Method = C.CYLFUSE_METHOD_FUSED
	// MethodPoints takes the points alone by plain least squares; edges are ignored.
	MethodPoints Method = C.CYLFUSE_METHOD_POINTS
	// MethodRANSAC is random sample consensus over the points, without a final iteration.
	MethodRANSAC Method = C.CYLFUSE_METHOD_RANSAC
	// MethodEberly is Eberly's algebraic fit by the moments of the points, without a final iteration.
	MethodEberly Method = C.CYLFUSE_METHOD_EBERLY
)

// Objective is what MethodFused minimises.
type Objective int32

const (
	// ObjectiveRobust takes robust points and the distances of the segment endpoints in pixels, each weighted by its
	// own scale, with any number of segments.
	ObjectiveRobust Objective = C.CYLFUSE_OBJECTIVE_ROBUST
	// ObjectivePaper is F = (1 - w) E_P + w E_L of Zhang, Liu and Wang (Sensors 2026, 26(5), 1687), exactly, with
	// w = EdgeWeight. Takes exactly two segments, or w = 0.
	ObjectivePaper Objective = C.CYLFUSE_OBJECTIVE_PAPER
)

// Start is where the iteration starts.
type Start int32

const (
	// StartAuto takes the candidate of the kinds below that explains the data best. Never in a result.
	StartAuto Start = C.CYLFUSE_START_AUTO
	// StartLimbs takes two limb segments, scaled by the points.
	StartLimbs Start = C.CYLFUSE_START_LIMBS
	// StartMoments is Eberly's algebraic fit by the moments of the points.
	StartMoments Start = C.CYLFUSE_START_MOMENTS
	// StartRANSAC is random sample consensus over the points.
	StartRANSAC Start = C.CYLFUSE_START_RANSAC
	// StartModel is the model given by SetStartModel.
	StartModel Start = C.CYLFUSE_START_MODEL
	// StartLast is the cylinder of the last successful fit of the fitter, for frames of a sequence, also after Clear. Where
	// its limbs are about where it or the points have them, and look in the image as they did, they are not searched, and
	// the result depends on the fits before. Where not, and before the first fit, as StartAuto, with that cylinder or the
	// start model one of the candidates. Of points alone that hold several bodies the one near that cylinder is fitted.
	StartLast Start = C.CYLFUSE_START_LAST
)

// NearWall says whether the points must lie on the wall of the cylinder that a camera at the origin sees.
type NearWall int32

const (
	// NearWallAuto is on when intrinsics are set: only then is the origin known to be a camera.
	NearWallAuto NearWall = C.CYLFUSE_NEAR_WALL_AUTO
	// NearWallOn: the origin is the observer.
	NearWallOn NearWall = C.CYLFUSE_NEAR_WALL_ON
	// NearWallOff: the minimum nearest to the start stays.
	NearWallOff NearWall = C.CYLFUSE_NEAR_WALL_OFF
)

// Chart is the coordinates in which the iteration steps. All reach the same optima.
type Chart int32

const (
	// ChartAuto is ChartOrthonormal for the paper's objective where a camera stands outside the cylinder, else
	// ChartLocal.
	ChartAuto Chart = C.CYLFUSE_CHART_AUTO
	// ChartLocal is shift and tilt of the axis at the data.
	ChartLocal Chart = C.CYLFUSE_CHART_LOCAL
	// ChartOrthonormal is the orthonormal representation about the origin of coordinates, as in the paper.
	ChartOrthonormal Chart = C.CYLFUSE_CHART_ORTHONORMAL
)

// EdgeUse is what given edge segments are for ObjectiveRobust.
type EdgeUse int32

const (
	// EdgeUseRefine: a start; where there is an image, the limbs are located in it and join the fit.
	EdgeUseRefine EdgeUse = C.CYLFUSE_EDGE_USE_REFINE
	// EdgeUseAsGiven: the measurement; no limbs are looked for in the image.
	EdgeUseAsGiven EdgeUse = C.CYLFUSE_EDGE_USE_AS_GIVEN
)

// ExtentRule is how the ends of the visible cylinder are found in a mask. Without one, and from inside a pipe, the points on
// the surface tell them.
type ExtentRule int32

const (
	// ExtentRuleAuto is ExtentRuleLocated for MethodFused with ObjectiveRobust, ExtentRuleExtremes otherwise.
	ExtentRuleAuto ExtentRule = C.CYLFUSE_EXTENT_RULE_AUTO
	// ExtentRuleExtremes is the rule of the paper: the extreme positions along the axis of the completed points.
	ExtentRuleExtremes ExtentRule = C.CYLFUSE_EXTENT_RULE_EXTREMES
	// ExtentRuleLocated takes all lines along the surface together, in the mask and, when there is one, in the image.
	ExtentRuleLocated ExtentRule = C.CYLFUSE_EXTENT_RULE_LOCATED
)

// Options are the settings of a fit. Start from DefaultOptions: 0 is no default for some fields.
type Options struct {
	// Method is how the cylinder is estimated. Default MethodFused.
	Method Method
	// Objective is what MethodFused minimises. Default ObjectiveRobust.
	Objective Objective
	// Start is where the iteration starts. Default StartAuto.
	Start Start
	// NearWall says whether the points must lie on the wall that the camera sees. Default NearWallAuto.
	NearWall NearWall
	// Chart is the coordinates of the iteration. Default ChartAuto.
	Chart Chart
	// EdgeUse is what given edge segments are for ObjectiveRobust. Default EdgeUseRefine.
	EdgeUse EdgeUse
	// ExtentRule is how the ends of the visible cylinder are found. Default ExtentRuleAuto.
	ExtentRule ExtentRule
	// MaxThreads is the most threads for the sums over the points; the result has the same bits for any number.
	// Default 1: no thread is started.
	MaxThreads uint32
	// MaxIterations is the maximum number of iterations, at least 1. Default 400.
	MaxIterations uint32
	// CostTolerance is the smallest relative decrease of the cost that counts as progress, in [0, 1). Default 1e-12.
	CostTolerance float64
	// GradientTolerance ends the iteration where the cosine of the angle between the residuals and what a step can change
	// of them is not above it, in [0, 1). Default 2^-52.
	GradientTolerance float64
	// StepTolerance ends the iteration with a step that moves the surface at the data by not more than this part of their
	// largest coordinate and of their size, in [0, 1). Default 2^-52.
	StepTolerance float64
	// InitialLambda is the damping of the first step, greater than 0. Default 1e-3.
	InitialLambda float64
	// LambdaFactor is the factor by which the damping changes, greater than 1. Default 10.
	LambdaFactor float64
	// MaxLambda is the damping at which no smaller step is tried any more. Default 1e12.
	MaxLambda float64
	// EdgeWeight is the weight w of the edges in ObjectivePaper, in [0, 1]. Default 0.6; 0 is points only.
	EdgeWeight float64
	// Seed of the random samples of RANSAC: the same seed gives the same result. Default 0.
	Seed uint64
	// RANSACMaxIterations is the most random samples of RANSAC, 1 to 1,000,000. Default 1000.
	RANSACMaxIterations uint64
	// RANSACThreshold is the distance within which RANSAC counts a point as an inlier, in the unit of length.
	// Default 0 = from the data.
	RANSACThreshold float64
	// IndependentPoints is how many points with independent noise the points of one view are worth, by which points and
	// limbs are weighed against each other. Default 0 = from the data.
	IndependentPoints float64
	// DepthNoise is the standard deviation of a point across the surface, in the unit of length. Default 0 = from the data.
	DepthNoise float64
	// ImageNoise is the standard deviation of the values of the image, in their unit where that is linear in light.
	// Default 0 = from the image.
	ImageNoise float64
	// EdgeNoise is the standard deviation of an endpoint of a given edge segment across its limb, in drawn pixels.
	// Default 0 = 0.5, that of edges set by hand.
	EdgeNoise float64
	// MaskNoise is the standard deviation of a side of the mask as a whole across its limb, in drawn pixels. Default 0 =
	// 1.6, that of masks drawn by hand.
	MaskNoise float64
	// ImageBlur is the blur of the image, the standard deviation of a Gaussian in pixels. Default 0 = from the image.
	ImageBlur float64
	// DrawnPixel is the size of a pixel of the drawing in which edges and masks were made, in pixels of the image. Default
	// 0 = 1 up to 640 x 480 pixels, beyond that the square root of how many times as many pixels the image has.
	DrawnPixel float64
	// DepthShared is the standard deviation of the errors that all points of a view share, as a part of their distance.
	// Default 0 = 0.002, a fifth of what data sheets grant; less than 0 = they share none.
	DepthShared float64
	// RadiusMin is the smallest radius, which the returned cylinder keeps. Default 0 = no limit.
	RadiusMin float64
	// RadiusMax is the largest radius, equal to RadiusMin for a radius that is known. Default 0 = no limit.
	RadiusMax float64
	// Axis is the middle of the cone of directions that the returned axis keeps, of any length. Default {0, 0, 0} =
	// all directions.
	Axis [3]float64
	// AxisMaxAngle is the largest angle of the axis from Axis, in radians from 0 to pi/2; 0 for a direction that is
	// known. Default 0; must be 0 without Axis.
	AxisMaxAngle float64
}

// DefaultOptions are the settings of a new fitter.
func DefaultOptions() Options {
	var options C.cylfuse_options
	C.cylfuse_options_init(&options, C.sizeof_cylfuse_options)
	return optionsFromC(&options)
}

func (options *Options) toC() C.cylfuse_options {
	var c C.cylfuse_options
	C.cylfuse_options_init(&c, C.sizeof_cylfuse_options)
	c.method = C.cylfuse_method(options.Method)
	c.objective = C.cylfuse_objective(options.Objective)
	c.start = C.cylfuse_start(options.Start)
	c.near_wall = C.cylfuse_near_wall(options.NearWall)
	c.chart = C.cylfuse_chart(options.Chart)
	c.edge_use = C.cylfuse_edge_use(options.EdgeUse)
	c.extent_rule = C.cylfuse_extent_rule(options.ExtentRule)
	c.max_threads = C.uint32_t(options.MaxThreads)
	c.max_iterations = C.uint32_t(options.MaxIterations)
	c.cost_tolerance = C.double(options.CostTolerance)
	c.gradient_tolerance = C.double(options.GradientTolerance)
	c.step_tolerance = C.double(options.StepTolerance)
	c.initial_lambda = C.double(options.InitialLambda)
	c.lambda_factor = C.double(options.LambdaFactor)
	c.max_lambda = C.double(options.MaxLambda)
	c.edge_weight = C.double(options.EdgeWeight)
	c.seed = C.uint64_t(options.Seed)
	c.ransac_max_iterations = C.uint64_t(options.RANSACMaxIterations)
	c.ransac_threshold = C.double(options.RANSACThreshold)
	c.independent_points = C.double(options.IndependentPoints)
	c.depth_noise = C.double(options.DepthNoise)
	c.image_noise = C.double(options.ImageNoise)
	c.edge_noise = C.double(options.EdgeNoise)
	c.mask_noise = C.double(options.MaskNoise)
	c.image_blur = C.double(options.ImageBlur)
	c.drawn_pixel = C.double(options.DrawnPixel)
	c.depth_shared = C.double(options.DepthShared)
	c.radius_min = C.double(options.RadiusMin)
	c.radius_max = C.double(options.RadiusMax)
	c.axis = vectorToC(options.Axis)
	c.axis_max_angle = C.double(options.AxisMaxAngle)
	return c
}

func optionsFromC(c *C.cylfuse_options) Options {
	return Options{
		Method:              Method(c.method),
		Objective:           Objective(c.objective),
		Start:               Start(c.start),
		NearWall:            NearWall(c.near_wall),
		Chart:               Chart(c.chart),
		EdgeUse:             EdgeUse(c.edge_use),
		ExtentRule:          ExtentRule(c.extent_rule),
		MaxThreads:          uint32(c.max_threads),
		MaxIterations:       uint32(c.max_iterations),
		CostTolerance:       float64(c.cost_tolerance),
		GradientTolerance:   float64(c.gradient_tolerance),
		StepTolerance:       float64(c.step_tolerance),
		InitialLambda:       float64(c.initial_lambda),
		LambdaFactor:        float64(c.lambda_factor),
		MaxLambda:           float64(c.max_lambda),
		EdgeWeight:          float64(c.edge_weight),
		Seed:                uint64(c.seed),
		RANSACMaxIterations: uint64(c.ransac_max_iterations),
		RANSACThreshold:     float64(c.ransac_threshold),
		IndependentPoints:   float64(c.independent_points),
		DepthNoise:          float64(c.depth_noise),
		ImageNoise:          float64(c.image_noise),
		EdgeNoise:           float64(c.edge_noise),
		MaskNoise:           float64(c.mask_noise),
		ImageBlur:           float64(c.image_blur),
		DrawnPixel:          float64(c.drawn_pixel),
		DepthShared:         float64(c.depth_shared),
		RadiusMin:           float64(c.radius_min),
		RadiusMax:           float64(c.radius_max),
		Axis:                vectorFromC(c.axis),
		AxisMaxAngle:        float64(c.axis_max_angle),
	}
}

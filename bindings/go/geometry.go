package cylfuse

// #include "bridge.h"
import "C"

import "unsafe"

// DistortionModel says what the coefficients of a camera mean.
type DistortionModel int32

const (
	// DistortionNone is a pinhole; all coefficients are 0.
	DistortionNone DistortionModel = C.CYLFUSE_DISTORTION_NONE
	// DistortionBrownConrady has k1 k2 p1 p2 k3 k4 k5 k6 in the order of OpenCV.
	DistortionBrownConrady DistortionModel = C.CYLFUSE_DISTORTION_BROWN_CONRADY
	// DistortionKannalaBrandt is the fisheye model of OpenCV: k1 k2 k3 k4. Rays less than 89 degrees from the axis.
	DistortionKannalaBrandt DistortionModel = C.CYLFUSE_DISTORTION_KANNALA_BRANDT
)

// Intrinsics is a camera as a calibration gives it. Pixel centres are at integer coordinates, as in OpenCV.
type Intrinsics struct {
	// Width and Height of the image in pixels, at least 1, together at most 2^28 pixels.
	Width, Height int
	// FX and FY are the focal length in pixel widths and in pixel heights, greater than 0.
	FX, FY float64
	// CX and CY are the principal point in pixels from the centre of the first pixel, to the right and down.
	CX, CY float64
	// DistortionModel says what Distortion means.
	DistortionModel DistortionModel
	// Distortion holds the coefficients; those that the model does not have are 0.
	Distortion [8]float64
}

func (intrinsics *Intrinsics) toC() (c C.cylfuse_intrinsics, err error) {
	if err := sides("intrinsics", intrinsics.Width, intrinsics.Height); err != nil {
		return c, err
	}
	C.cylfuse_intrinsics_init(&c, C.sizeof_cylfuse_intrinsics)
	c.width = C.uint32_t(intrinsics.Width)
	c.height = C.uint32_t(intrinsics.Height)
	c.fx = C.double(intrinsics.FX)
	c.fy = C.double(intrinsics.FY)
	c.cx = C.double(intrinsics.CX)
	c.cy = C.double(intrinsics.CY)
	c.distortion_model = C.cylfuse_distortion(intrinsics.DistortionModel)
	for i, coefficient := range intrinsics.Distortion {
		c.distortion[i] = C.double(coefficient)
	}
	return c, nil
}

func intrinsicsFromC(c *C.cylfuse_intrinsics) Intrinsics {
	intrinsics := Intrinsics{
		Width: int(c.width), Height: int(c.height),
		FX: float64(c.fx), FY: float64(c.fy), CX: float64(c.cx), CY: float64(c.cy),
		DistortionModel: DistortionModel(c.distortion_model),
	}
	for i, coefficient := range c.distortion {
		intrinsics.Distortion[i] = float64(coefficient)
	}
	return intrinsics
}

// Project gives the pixels of the (distorted) image at which the camera sees points of its frame, row by row of the
// points; weights and normals are ignored. Pixels may lie beyond the border of the image; NaN for a point that is not
// finite, not in front of the camera or outside the field of its model.
func (intrinsics Intrinsics) Project(points PointCloud) ([][2]float64, error) {
	camera, err := intrinsics.toC()
	if err != nil {
		return nil, err
	}
	view, err := points.pointsView()
	if err != nil {
		return nil, err
	}
	pixels := make([][2]float64, view.view.width*view.view.height)
	out := (*C.double)(unsafe.Pointer(first(pixels)))
	err = withoutHandle(func() C.cylfuse_status {
		return C.bridge_intrinsics_project(&camera, &view.view, view.data, out, C.size_t(len(pixels)))
	})
	if err != nil {
		return nil, err
	}
	return pixels, nil
}

// Unproject gives the rays along which the camera sees pixels of the (distorted) image: the points at z = 1 of its frame;
// NaN for a pixel that is not finite or for which the model has no ray.
//
// The ray of an ideal pixel, as those of limb lines are, is that of the same intrinsics without distortion.
func (intrinsics Intrinsics) Unproject(pixels [][2]float64) ([][3]float64, error) {
	camera, err := intrinsics.toC()
	if err != nil {
		return nil, err
	}
	rays := make([][3]float64, len(pixels))
	in, out := (*C.double)(unsafe.Pointer(first(pixels))), (*C.double)(unsafe.Pointer(first(rays)))
	err = withoutHandle(func() C.cylfuse_status {
		return C.cylfuse_intrinsics_unproject(&camera, in, C.size_t(len(pixels)), out)
	})
	if err != nil {
		return nil, err
	}
	return rays, nil
}

// Pose leads from one frame to another: x' = Rotation x + Translation. The pose of a view leads from its camera frame to
// the reference frame.
type Pose struct {
	// Rotation is a rotation matrix, row by row.
	Rotation [3][3]float64
	// Translation is in the unit of length.
	Translation [3]float64
}

// Identity is the pose that moves nothing.
func Identity() Pose { return Pose{Rotation: [3][3]float64{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}} }

func (pose *Pose) toC() (rotation [9]C.double, translation [3]C.double) {
	for i := range rotation {
		rotation[i] = C.double(pose.Rotation[i/3][i%3])
	}
	return rotation, vectorToC(pose.Translation)
}

// DepthCamera is the camera of depth images that are not registered to the colour image.
type DepthCamera struct {
	// Intrinsics are those of the depth camera.
	Intrinsics Intrinsics
	// ToColour leads from the frame of the depth camera to that of the colour camera.
	ToColour Pose
}

// depthCamera is a DepthCamera for C; without intrinsics it takes the depth camera away.
type depthCamera struct {
	intrinsics  *C.cylfuse_intrinsics
	rotation    [9]C.double
	translation [3]C.double
}

func (camera *DepthCamera) toC() (c depthCamera, err error) {
	if camera == nil {
		return c, nil
	}
	intrinsics, err := camera.Intrinsics.toC()
	if err != nil {
		return c, err
	}
	c.intrinsics = &intrinsics
	c.rotation, c.translation = camera.ToColour.toC()
	return c, nil
}

// Cylinder is an infinite cylinder.
type Cylinder struct {
	// Point is on the axis, in the unit of length of the data.
	Point [3]float64
	// Direction is that of the axis. As input of any length but 0, as output of length 1. Its sign has no meaning; the
	// library gives the one with a positive largest component.
	Direction [3]float64
	// Radius in the unit of length of the data, greater than 0.
	Radius float64
}

// Distances are the signed distances of points from the surface, negative inside, NaN for a point that is not finite;
// row by row of the points. Weights are ignored.
func (cylinder Cylinder) Distances(points PointCloud) ([]float64, error) {
	view, err := points.pointsView()
	if err != nil {
		return nil, err
	}
	model := cylinder.toC()
	distances := make([]float64, view.view.width*view.view.height)
	out := (*C.double)(unsafe.Pointer(first(distances)))
	err = withoutHandle(func() C.cylfuse_status {
		return C.bridge_distances(&model, &view.view, view.data, out, C.size_t(len(distances)))
	})
	if err != nil {
		return nil, err
	}
	return distances, nil
}

// Project gives the two limb lines in the image: a u + b v + c = 0 with a² + b² = 1, in ideal pixels, which are those of
// a pinhole with the same focal lengths and principal point. StatusEdgeGeometry when the camera is inside.
func (cylinder Cylinder) Project(intrinsics Intrinsics) ([2][3]float64, error) {
	var lines [2][3]float64
	camera, err := intrinsics.toC()
	if err != nil {
		return lines, err
	}
	model := cylinder.toC()
	err = withoutHandle(func() C.cylfuse_status {
		return C.cylfuse_cylinder_project(&model, &camera, (*C.double)(unsafe.Pointer(&lines)))
	})
	return lines, err
}

// Comparison is how two cylinders differ.
type Comparison struct {
	// Angle between the axes in radians, in [0, pi / 2], whatever the signs of the directions.
	Angle float64
	// AxisDistance is the shortest distance between the two axes, in the unit of length.
	AxisDistance float64
	// RadiusRelative is (radius of the other - radius) / radius.
	RadiusRelative float64
}

// Compare says how another cylinder differs from this one.
func (cylinder Cylinder) Compare(other Cylinder) (Comparison, error) {
	a, b := cylinder.toC(), other.toC()
	var angle, distance, radius C.double
	err := withoutHandle(func() C.cylfuse_status {
		return C.cylfuse_cylinder_compare(&a, &b, &angle, &distance, &radius)
	})
	return Comparison{float64(angle), float64(distance), float64(radius)}, err
}

// Plan is a cylinder with the middle of its axis on the optical axis, of which a camera will take measurements. Lengths are
// in metres, angles in radians.
type Plan struct {
	// Distance from the camera to the middle of the axis.
	Distance float64
	// Radius and Length of the cylinder.
	Radius, Length float64
	// Tilt of the axis out of the plane of the image, and Turn of the axis in the image from the vertical.
	Tilt, Turn float64
	// Noise has a, b, c of the noise of depth a + b z + c z² at the depth z; the side of the squares of pixels that share
	// it, at least 1; the noise of a pixel of the image as a part of the step of brightness at limbs and ends; the blur of
	// the image in pixels. Nil for that of structured light and an ordinary image.
	Noise *[6]float64
}

// Deviations are standard deviations: of radius, position of the axis and length in metres, of the direction in radians.
// The length is NaN where an end lies outside the image.
type Deviations struct {
	Radius, Direction, Position, Length float64
}

// Expect gives the standard deviations to be expected: what captures of one scene scatter by, and the total, which a fit
// states.
func (plan Plan) Expect(intrinsics Intrinsics) (scatter, total Deviations, err error) {
	camera, err := intrinsics.toC()
	if err != nil {
		return scatter, total, err
	}
	cylinder := [5]float64{plan.Distance, plan.Radius, plan.Length, plan.Tilt, plan.Turn}
	err = withoutHandle(func() C.cylfuse_status {
		return C.cylfuse_plan(&camera, (*C.double)(unsafe.Pointer(&cylinder)), (*C.double)(unsafe.Pointer(plan.Noise)),
			(*C.double)(unsafe.Pointer(&scatter)), (*C.double)(unsafe.Pointer(&total)))
	})
	return scatter, total, err
}

func (cylinder *Cylinder) toC() C.cylfuse_cylinder {
	return C.cylfuse_cylinder{
		point:     vectorToC(cylinder.Point),
		direction: vectorToC(cylinder.Direction),
		radius:    C.double(cylinder.Radius),
	}
}

// optional is the model for C, where nil is that of the last fit.
func (cylinder *Cylinder) optional() *C.cylfuse_cylinder {
	if cylinder == nil {
		return nil
	}
	c := cylinder.toC()
	return &c
}

func cylinderFromC(c *C.cylfuse_cylinder) Cylinder {
	return Cylinder{vectorFromC(c.point), vectorFromC(c.direction), float64(c.radius)}
}

func vectorToC(v [3]float64) [3]C.double {
	return [3]C.double{C.double(v[0]), C.double(v[1]), C.double(v[2])}
}

func vectorFromC(v [3]C.double) [3]float64 {
	return [3]float64{float64(v[0]), float64(v[1]), float64(v[2])}
}

// matrixFromC reads a symmetric 3 x 3 matrix.
func matrixFromC(c [9]C.double) [3][3]float64 {
	var m [3][3]float64
	for i, value := range c {
		m[i/3][i%3] = float64(value)
	}
	return m
}

package cylfuse

// #include "bridge.h"
import "C"

import (
	"math"
	"math/bits"
	"unsafe"
)

// Points is a cloud in memory of the caller, which is read during the call only. Strides count in numbers, not bytes;
// 0 stands for packed.
type Points[T float32 | float64] struct {
	// Data holds x, y, z of the first point at its beginning.
	Data []T
	// Width is the number of columns of an organised cloud, or of points; with Height 0 too, all that Data holds.
	Width int
	// Height is the number of rows of an organised cloud; 0 stands for 1.
	Height int
	// PointStride is the distance of a point from the next one in its row; 0 = 3.
	PointStride int
	// RowStride is the distance of a row from the next one; 0 = Width * PointStride.
	RowStride int
	// Weights holds the weight of each point, 0 or greater; 0 drops the point. nil = every weight is 1.
	Weights []T
	// WeightStride is the distance of a weight from the next one in its row; 0 = 1.
	WeightStride int
	// WeightRowStride is the distance of a row of weights from the next one; 0 = Width * WeightStride.
	WeightRowStride int
	// Normals holds x, y, z of the normal at each point, of any length and sign. Only MethodRANSAC uses them.
	// nil = unknown.
	Normals []T
	// NormalStride is the distance of a normal from the next one in its row; 0 = 3.
	NormalStride int
	// NormalRowStride is the distance of a row of normals from the next one; 0 = Width * NormalStride.
	NormalRowStride int
}

// PointCloud is Points of float32 or of float64.
type PointCloud interface {
	pointsView() (pointsView, error)
}

// DepthImage holds z, not the distance along the ray, for each pixel of the camera, in memory of the caller, which is
// read during the call only. uint16: 0 = no measurement; float32: 0, negative or not finite = no measurement.
type DepthImage[T uint16 | float32] struct {
	// Data holds the first row at its beginning.
	Data []T
	// Width and Height must be those of the intrinsics.
	Width, Height int
	// RowStride is the distance of a row from the next one, in numbers; 0 = Width * PixelStride.
	RowStride int
	// PixelStride is the distance of a pixel from the next one, in numbers; 0 = 1.
	PixelStride int
	// Scale is the length of one unit of the stored value, greater than 0: 0.001 for millimetres when the unit of length
	// is the metre. It has no default, because a forgotten one would go straight into the radius.
	Scale float64
	// MinDepth is the nearest depth that counts, in the unit of length.
	MinDepth float64
	// MaxDepth is the farthest depth that counts, in the unit of length; 0 = no limit.
	MaxDepth float64
}

// Depth is a DepthImage of uint16 or of float32.
type Depth interface {
	depthView() (depthView, error)
}

// GreyImage is what the camera saw, linear in light or with a gamma, in memory of the caller, which is read during the
// call only.
type GreyImage[T uint8 | uint16 | float32] struct {
	// Data holds the first row at its beginning.
	Data []T
	// Width and Height must be those of the intrinsics.
	Width, Height int
	// RowStride is the distance of a row from the next one, in numbers; 0 = Width * PixelStride.
	RowStride int
	// PixelStride is the distance of a pixel from the next one, in numbers; 0 = 1. With 3 the first channel of packed
	// colours.
	PixelStride int
	// Gamma is the power of the value that is light: 2.2 for sRGB, in which cameras and image files usually come; 0 = 1.
	Gamma float64
}

// Image is a GreyImage of uint8, uint16 or float32.
type Image interface {
	imageView() (imageView, error)
}

// Mask selects pixels: non-zero = visible lateral surface of the cylinder. Its boundary may be some pixels off.
type Mask struct {
	// Data holds the first row at its beginning.
	Data []uint8
	// Width and Height are those of the image or organised cloud that it belongs to.
	Width, Height int
	// RowStride is the distance of a row from the next one, in bytes; 0 = Width * PixelStride.
	RowStride int
	// PixelStride is the distance of a pixel from the next one, in bytes; 0 = 1.
	PixelStride int
}

// Segments are pieces of the two lines that bound the cylinder in the (distorted) image, in pixels.
type Segments[T float32 | float64] struct {
	// Data holds x1, y1, x2, y2 of segment after segment; the endpoints may come in any order.
	Data []T
	// Stride is the distance of a segment from the next one, in numbers; 0 = 4.
	Stride int
	// Weights holds the weight of each segment, from 0 to 1e9; 0 leaves it out. nil = every weight is 1.
	Weights []float64
}

// Edges is Segments of float32 or of float64.
type Edges interface {
	segmentsView() (segmentsView, error)
}

// The views of the C interface without their pointers, and the pointers, which cgo wants as arguments of their own.
type (
	pointsView struct {
		view                   C.cylfuse_points_view
		data, weights, normals unsafe.Pointer
		count                  int
	}
	depthView struct {
		view C.cylfuse_depth_view
		data unsafe.Pointer
	}
	imageView struct {
		view C.cylfuse_image_view
		data unsafe.Pointer
	}
	maskView struct {
		view *C.cylfuse_mask_view
		data unsafe.Pointer
	}
	segmentsView struct {
		view          C.cylfuse_segments_view
		data, weights unsafe.Pointer
	}
)

func (points Points[T]) pointsView() (pointsView, error) {
	var call pointsView
	step := points.PointStride
	if step == 0 {
		step = 3
	}
	if points.Width == 0 && points.Height == 0 {
		if step < 3 {
			return call, shapeError("PointStride is %d: a point has 3 numbers", step)
		}
		// The last point needs no more than its own three numbers.
		if over := len(points.Data) % step; over != 0 && (step == 3 || over != 3) {
			return call, shapeError("Data has %d numbers, which is no whole number of points of %d numbers: give x, y, "+
				"z of point after point", len(points.Data), step)
		}
		points.Width = (len(points.Data) + step - 1) / step
	}
	if points.Height == 0 {
		points.Height = 1
	}
	if err := holds("Data", len(points.Data), points.Width, points.Height, points.PointStride, points.RowStride, 3); err != nil {
		return call, err
	}
	if points.Weights != nil {
		if err := holds("Weights", len(points.Weights), points.Width, points.Height, points.WeightStride, points.WeightRowStride, 1); err != nil {
			return call, err
		}
	}
	if points.Normals != nil {
		if err := holds("Normals", len(points.Normals), points.Width, points.Height, points.NormalStride, points.NormalRowStride, 3); err != nil {
			return call, err
		}
	}
	C.cylfuse_points_view_init(&call.view, C.sizeof_cylfuse_points_view)
	call.view.scalar = scalarOf[T]()
	call.view.width = C.size_t(points.Width)
	call.view.height = C.size_t(points.Height)
	call.view.point_stride = inBytes[T](points.PointStride)
	call.view.row_stride = inBytes[T](points.RowStride)
	call.view.weight_stride = inBytes[T](points.WeightStride)
	call.view.weight_row_stride = inBytes[T](points.WeightRowStride)
	call.view.normal_stride = inBytes[T](points.NormalStride)
	call.view.normal_row_stride = inBytes[T](points.NormalRowStride)
	call.data = first(points.Data)
	call.weights = first(points.Weights)
	call.normals = first(points.Normals)
	call.count = points.Width * points.Height
	return call, nil
}

func (depth DepthImage[T]) depthView() (depthView, error) {
	var call depthView
	if err := holdsPixels(len(depth.Data), depth.Width, depth.Height, depth.PixelStride, depth.RowStride); err != nil {
		return call, err
	}
	C.cylfuse_depth_view_init(&call.view, C.sizeof_cylfuse_depth_view)
	call.view.format = depthFormatOf[T]()
	call.view.width = C.uint32_t(depth.Width)
	call.view.height = C.uint32_t(depth.Height)
	call.view.row_stride = inBytes[T](depth.RowStride)
	call.view.pixel_stride = inBytes[T](depth.PixelStride)
	call.view.scale = C.double(depth.Scale)
	call.view.min_depth = C.double(depth.MinDepth)
	call.view.max_depth = C.double(depth.MaxDepth)
	call.data = first(depth.Data)
	return call, nil
}

func (image GreyImage[T]) imageView() (imageView, error) {
	var call imageView
	if err := holdsPixels(len(image.Data), image.Width, image.Height, image.PixelStride, image.RowStride); err != nil {
		return call, err
	}
	C.cylfuse_image_view_init(&call.view, C.sizeof_cylfuse_image_view)
	switch any(image.Data).(type) {
	case []uint8:
		call.view.format = C.CYLFUSE_IMAGE_FORMAT_U8
	case []uint16:
		call.view.format = C.CYLFUSE_IMAGE_FORMAT_U16
	default:
		call.view.format = C.CYLFUSE_IMAGE_FORMAT_F32
	}
	call.view.width = C.uint32_t(image.Width)
	call.view.height = C.uint32_t(image.Height)
	call.view.row_stride = inBytes[T](image.RowStride)
	call.view.pixel_stride = inBytes[T](image.PixelStride)
	call.view.gamma = C.double(image.Gamma)
	call.data = first(image.Data)
	return call, nil
}

// maskView of nil is that of no mask.
func (mask *Mask) maskView() (maskView, error) {
	if mask == nil {
		return maskView{}, nil
	}
	if err := holdsPixels(len(mask.Data), mask.Width, mask.Height, mask.PixelStride, mask.RowStride); err != nil {
		return maskView{}, err
	}
	var view C.cylfuse_mask_view
	C.cylfuse_mask_view_init(&view, C.sizeof_cylfuse_mask_view)
	view.width = C.uint32_t(mask.Width)
	view.height = C.uint32_t(mask.Height)
	view.row_stride = C.ptrdiff_t(mask.RowStride)
	view.pixel_stride = C.ptrdiff_t(mask.PixelStride)
	return maskView{&view, first(mask.Data)}, nil
}

func (segments Segments[T]) segmentsView() (segmentsView, error) {
	var call segmentsView
	step := segments.Stride
	if step == 0 {
		step = 4
	}
	if step < 4 {
		return call, shapeError("Stride is %d: a segment has 4 numbers", step)
	}
	// The last segment needs no more than its own four numbers.
	if over := len(segments.Data) % step; over != 0 && (step == 4 || over != 4) {
		return call, shapeError("Data has %d numbers, which is no whole number of segments of %d numbers: give x1, y1, "+
			"x2, y2 of segment after segment", len(segments.Data), step)
	}
	count := (len(segments.Data) + step - 1) / step
	if segments.Weights != nil && len(segments.Weights) != count {
		return call, shapeError("there are %d weights for %d segments: give one for each", len(segments.Weights), count)
	}
	C.cylfuse_segments_view_init(&call.view, C.sizeof_cylfuse_segments_view)
	call.view.scalar = scalarOf[T]()
	call.view.count = C.size_t(count)
	call.view.segment_stride = inBytes[T](segments.Stride)
	call.data = first(segments.Data)
	call.weights = first(segments.Weights)
	return call, nil
}

func scalarOf[T float32 | float64]() C.cylfuse_scalar {
	if unsafe.Sizeof(*new(T)) == 4 {
		return C.CYLFUSE_SCALAR_F32
	}
	return C.CYLFUSE_SCALAR_F64
}

func depthFormatOf[T uint16 | float32]() C.cylfuse_depth_format {
	if unsafe.Sizeof(*new(T)) == 2 {
		return C.CYLFUSE_DEPTH_FORMAT_U16
	}
	return C.CYLFUSE_DEPTH_FORMAT_F32
}

// inBytes is a stride in bytes of one in numbers.
func inBytes[T any](stride int) C.ptrdiff_t { return C.ptrdiff_t(stride * int(unsafe.Sizeof(*new(T)))) }

// first is the address of the first number, nil where there is none.
func first[T any](values []T) unsafe.Pointer {
	if len(values) == 0 {
		return nil
	}
	return unsafe.Pointer(&values[0])
}

// holdsPixels is holds for an image, whose sides the C interface takes as uint32.
func holdsPixels(length, width, height, pixelStride, rowStride int) error {
	if int64(width) > math.MaxUint32 || int64(height) > math.MaxUint32 {
		return shapeError("%d x %d pixels: no image is that large", width, height)
	}
	return holds("Data", length, width, height, pixelStride, rowStride, 1)
}

// holds refuses a slice of `length` numbers that does not hold the grid which width, height and strides describe.
func holds(name string, length, width, height, stride, rowStride, item int) error {
	if width < 0 || height < 0 {
		return shapeError("%s: %d x %d is no size", name, width, height)
	}
	// The bound keeps a stride in bytes within its type.
	if limit := math.MaxInt / 8; stride < 0 || rowStride < 0 || stride > limit || rowStride > limit {
		return shapeError("%s: strides of %d and %d numbers; a slice starts at its first number, so they are 0 or "+
			"greater", name, stride, rowStride)
	}
	if width == 0 || height == 0 {
		return nil
	}
	if stride == 0 {
		stride = item
	}
	overflow, row := bits.Mul64(uint64(width), uint64(stride))
	if rowStride != 0 {
		row = uint64(rowStride)
	}
	more, last := bits.Mul64(uint64(height-1), row)
	need, carry := bits.Add64(last, uint64(width-1)*uint64(stride), 0)
	need, again := bits.Add64(need, uint64(item), 0)
	// Numbers that items share (strides that are too small) do not count twice, or an output could be of any size.
	over, items := bits.Mul64(uint64(width), uint64(height))
	if overflow|more|carry|again|over != 0 || need > uint64(length) || items > uint64(length/item) {
		return shapeError("%s has %d numbers, too few for %d x %d with strides of %d and %d numbers", name, length,
			width, height, stride, row)
	}
	return nil
}

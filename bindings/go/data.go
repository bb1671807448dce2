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
// read during the call only. uint16: 0 and 65535 (too far) = no measurement; float32: 0, negative or not finite = no measurement.
type DepthImage[T uint16 | float32] struct {
	// Data holds the first row at its beginning.
	Data []T
	// Width and Height must be those of the intrinsics, of the depth camera where there is one.
	Width, Height int
	// RowStride is the distance of a row from the next one, in numbers; 0 = Width * PixelStride.
	RowStride int
	// PixelStride is the distance of a pixel from the next one, in numbers; 0 = 1.
	PixelStride int
	// Scale is the length of one unit of the stored value, greater than 0: 0.001 for millimetres when the unit of length
	// is the metre. It has no default, because a forgotten one would go straight into the radius.
	Scale float64
	// MinDepth is the nearest depth that becomes a point, in the unit of length. Both limits are those of the points,
	// and of the search of a detector: the extent is found with all depths.
	MinDepth float64
	// MaxDepth is the farthest depth that becomes a point, in the unit of length; 0 = no limit.
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
	// PixelStride is the distance of a pixel from the next one, in numbers; 0 = 1.
	PixelStride int
	// Gamma: light is the value to this power, from 0.1 to 10; 0 = 1, values linear in light. 2.2 is about sRGB.
	Gamma float64
}

// ColourOrder is how the colours of a pixel follow each other, each a byte; a fourth byte (alpha) is ignored.
type ColourOrder int32

const (
	// ColourRGB: red, green, blue.
	ColourRGB ColourOrder = C.CYLFUSE_IMAGE_FORMAT_RGB8
	// ColourBGR: blue, green, red, as OpenCV reads image files.
	ColourBGR ColourOrder = C.CYLFUSE_IMAGE_FORMAT_BGR8
	// ColourRGBA: red, green, blue, alpha.
	ColourRGBA ColourOrder = C.CYLFUSE_IMAGE_FORMAT_RGBA8
	// ColourBGRA: blue, green, red, alpha.
	ColourBGRA ColourOrder = C.CYLFUSE_IMAGE_FORMAT_BGRA8
)

// ColourImage is what the camera saw, in colour, in memory of the caller, which is read during the call only.
type ColourImage struct {
	// Data holds the first row at its beginning.
	Data []uint8
	// Order says what the bytes of a pixel are.
	Order ColourOrder
	// Width and Height must be those of the intrinsics.
	Width, Height int
	// RowStride is the distance of a row from the next one, in bytes; 0 = Width * PixelStride.
	RowStride int
	// PixelStride is the distance of a pixel from the next one, in bytes; 0 = 3, or 4 with alpha.
	PixelStride int
	// Gamma is as that of a GreyImage.
	Gamma float64
}

// Image is a ColourImage or a GreyImage of uint8, uint16 or float32.
type Image interface {
	imageView() (imageView, error)
}

// Mask says which pixels of the colour image show the cylinder: its lateral surface alone, or the whole object with caps,
// lids and handles. With ObjectiveRobust a fit leaves out what the depth image shows to be no part of the lateral surface.
// The boundary may be some pixels off: it is a hint and never measured.
type Mask struct {
	// Data holds the first row at its beginning.
	Data []uint8
	// Width and Height are those of the image or organised cloud that it belongs to.
	Width, Height int
	// Label is that of the cylinder in an image of labels: the pixels of this value are the mask. 0 = all pixels that are
	// not 0.
	Label uint8
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
		data, weights, normals *C.uint8_t
	}
	depthView struct {
		view C.cylfuse_depth_view
		data *C.uint8_t
	}
	imageView struct {
		view C.cylfuse_image_view
		data *C.uint8_t
	}
	maskView struct {
		view *C.cylfuse_mask_view
		data *C.uint8_t
	}
	segmentsView struct {
		view    C.cylfuse_segments_view
		data    *C.uint8_t
		weights *C.double
	}
)

func (points Points[T]) pointsView() (pointsView, error) {
	width, height := points.Width, points.Height
	switch {
	case width == 0 && height == 0:
		var err error
		if width, err = items("points", "point", len(points.Data), points.PointStride, 3); err != nil {
			return pointsView{}, err
		}
		height = 1
	case width == 0 && len(points.Data) > 0:
		return pointsView{}, shapeError("points.Height is %d, but points.Width is 0: give both, or neither for all points "+
			"of Data", height)
	case height == 0:
		height = 1
	}
	for _, part := range []struct {
		name                    string
		data                    []T
		stride, rowStride, item int
	}{
		{"points.Data", points.Data, points.PointStride, points.RowStride, 3},
		{"points.Weights", points.Weights, points.WeightStride, points.WeightRowStride, 1},
		{"points.Normals", points.Normals, points.NormalStride, points.NormalRowStride, 3},
	} {
		if part.data == nil && part.name != "points.Data" {
			continue
		}
		if err := holds(part.name, len(part.data), width, height, part.stride, part.rowStride, part.item); err != nil {
			return pointsView{}, err
		}
	}
	call := pointsView{data: first(points.Data), weights: first(points.Weights), normals: first(points.Normals)}
	C.cylfuse_points_view_init(&call.view, C.sizeof_cylfuse_points_view)
	call.view.scalar = scalarOf[T]()
	call.view.width = C.size_t(width)
	call.view.height = C.size_t(height)
	call.view.point_stride = inBytes[T](points.PointStride)
	call.view.row_stride = inBytes[T](points.RowStride)
	call.view.weight_stride = inBytes[T](points.WeightStride)
	call.view.weight_row_stride = inBytes[T](points.WeightRowStride)
	call.view.normal_stride = inBytes[T](points.NormalStride)
	call.view.normal_row_stride = inBytes[T](points.NormalRowStride)
	return call, nil
}

func (depth DepthImage[T]) depthView() (depthView, error) {
	pixels, err := pixelsOf("depth", depth.Data, depth.Width, depth.Height, depth.RowStride, depth.PixelStride, 1)
	if err != nil {
		return depthView{}, err
	}
	call := depthView{data: pixels.data}
	C.cylfuse_depth_view_init(&call.view, C.sizeof_cylfuse_depth_view)
	call.view.format = depthFormatOf[T]()
	call.view.width, call.view.height = pixels.width, pixels.height
	call.view.row_stride, call.view.pixel_stride = pixels.rowStride, pixels.pixelStride
	call.view.scale = C.double(depth.Scale)
	call.view.min_depth = C.double(depth.MinDepth)
	call.view.max_depth = C.double(depth.MaxDepth)
	return call, nil
}

func (image GreyImage[T]) imageView() (imageView, error) {
	pixels, err := pixelsOf("image", image.Data, image.Width, image.Height, image.RowStride, image.PixelStride, 1)
	if err != nil {
		return imageView{}, err
	}
	switch unsafe.Sizeof(*new(T)) {
	case 1:
		return pixels.image(C.CYLFUSE_IMAGE_FORMAT_U8, image.Gamma), nil
	case 2:
		return pixels.image(C.CYLFUSE_IMAGE_FORMAT_U16, image.Gamma), nil
	}
	return pixels.image(C.CYLFUSE_IMAGE_FORMAT_F32, image.Gamma), nil
}

func (image ColourImage) imageView() (imageView, error) {
	var channels int
	switch image.Order {
	case ColourRGB, ColourBGR:
		channels = 3
	case ColourRGBA, ColourBGRA:
		channels = 4
	default:
		return imageView{}, shapeError("image.Order is %d: give one of ColourRGB, ColourBGR, ColourRGBA and ColourBGRA",
			image.Order)
	}
	pixels, err := pixelsOf("image", image.Data, image.Width, image.Height, image.RowStride, image.PixelStride, channels)
	if err != nil {
		return imageView{}, err
	}
	return pixels.image(C.cylfuse_image_format(image.Order), image.Gamma), nil
}

// image is the view of these pixels as an image; a gamma of 0 stands for 1.
func (pixels pixels) image(format C.cylfuse_image_format, gamma float64) imageView {
	call := imageView{data: pixels.data}
	C.cylfuse_image_view_init(&call.view, C.sizeof_cylfuse_image_view)
	call.view.format = format
	call.view.width, call.view.height = pixels.width, pixels.height
	call.view.row_stride, call.view.pixel_stride = pixels.rowStride, pixels.pixelStride
	if gamma != 0 {
		call.view.gamma = C.double(gamma)
	}
	return call
}

// maskView of nil is that of no mask.
func (mask *Mask) maskView() (maskView, error) {
	if mask == nil {
		return maskView{}, nil
	}
	pixels, err := pixelsOf("mask", mask.Data, mask.Width, mask.Height, mask.RowStride, mask.PixelStride, 1)
	if err != nil {
		return maskView{}, err
	}
	var view C.cylfuse_mask_view
	C.cylfuse_mask_view_init(&view, C.sizeof_cylfuse_mask_view)
	view.width, view.height = pixels.width, pixels.height
	view.label = C.uint32_t(mask.Label)
	view.row_stride, view.pixel_stride = pixels.rowStride, pixels.pixelStride
	return maskView{&view, pixels.data}, nil
}

func (segments Segments[T]) segmentsView() (segmentsView, error) {
	count, err := items("edges", "segment", len(segments.Data), segments.Stride, 4)
	if err != nil {
		return segmentsView{}, err
	}
	if segments.Weights != nil && len(segments.Weights) != count {
		return segmentsView{}, shapeError("edges.Weights has %d numbers for %d segments: give one for each",
			len(segments.Weights), count)
	}
	call := segmentsView{data: first(segments.Data), weights: (*C.double)(unsafe.Pointer(first(segments.Weights)))}
	C.cylfuse_segments_view_init(&call.view, C.sizeof_cylfuse_segments_view)
	call.view.scalar = scalarOf[T]()
	call.view.count = C.size_t(count)
	call.view.segment_stride = inBytes[T](segments.Stride)
	return call, nil
}

// pixels is what the views of all images share.
type pixels struct {
	data                   *C.uint8_t
	width, height          C.uint32_t
	rowStride, pixelStride C.ptrdiff_t
}

func pixelsOf[T uint8 | uint16 | float32](name string, data []T, width, height, rowStride, pixelStride, item int) (pixels, error) {
	if err := sides(name, width, height); err != nil {
		return pixels{}, err
	}
	if err := holds(name+".Data", len(data), width, height, pixelStride, rowStride, item); err != nil {
		return pixels{}, err
	}
	return pixels{
		first(data), C.uint32_t(width), C.uint32_t(height), inBytes[T](rowStride), inBytes[T](pixelStride),
	}, nil
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
func first[T any](values []T) *C.uint8_t {
	if len(values) == 0 {
		return nil
	}
	return (*C.uint8_t)(unsafe.Pointer(&values[0]))
}

// sides refuses the sides of an image that are none in the C interface, where they are uint32.
func sides(name string, width, height int) error {
	for _, side := range []int{width, height} {
		if side < 0 || uint64(side) > math.MaxUint32 {
			return shapeError("%s is %d x %d pixels: no image has such sides", name, width, height)
		}
	}
	return nil
}

// maxStride keeps a stride in bytes within its type.
const maxStride = math.MaxInt / 8

// items counts the items of `size` numbers that a slice holds from its first number to its last.
func items(name, item string, length, stride, size int) (int, error) {
	if stride == 0 {
		stride = size
	}
	if stride < size || stride > maxStride {
		return 0, shapeError("the stride of %s is %d: a %s has %d numbers, so it is from %[4]d to %[5]d, or 0 for packed ones",
			name, stride, item, size, maxStride)
	}
	// The last item needs no more than its own numbers.
	if over := length % stride; over != 0 && over != size%stride {
		return 0, shapeError("%s.Data has %d numbers, which is no whole number of %ss of %d numbers", name, length, item,
			stride)
	}
	return (length + stride - size) / stride, nil
}

// holds refuses a slice of `length` numbers that does not hold the grid which width, height and strides describe.
func holds(name string, length, width, height, stride, rowStride, item int) error {
	if width < 0 || height < 0 {
		return shapeError("%s is %d x %d: sides are 0 or greater", name, width, height)
	}
	if stride < 0 || rowStride < 0 || stride > maxStride || rowStride > maxStride {
		return shapeError("%s has strides of %d and %d numbers: a slice starts at its first number, so they are from 0 "+
			"to %d", name, stride, rowStride, maxStride)
	}
	if width == 0 || height == 0 {
		return nil
	}
	if stride == 0 {
		stride = item
	}
	// What overflows is too much for any slice.
	wide, row := bits.Mul64(uint64(width), uint64(stride))
	if rowStride != 0 {
		row = uint64(rowStride)
	}
	high, need := bits.Mul64(uint64(height-1), row)
	need, carry := bits.Add64(need, uint64(width-1)*uint64(stride), 0)
	need, carryItem := bits.Add64(need, uint64(item), 0)
	// Numbers that items share (strides that are too small) do not count twice, or an output could be of any size.
	many, count := bits.Mul64(uint64(width), uint64(height))
	if wide|high|carry|carryItem|many != 0 || need > uint64(length) || count > uint64(length/item) {
		return shapeError("%s has %d numbers, too few for %d x %d with strides of %d and %d numbers", name, length,
			width, height, stride, row)
	}
	return nil
}

/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file views.hpp
 * Data in the caller's memory: what cylfuse.hpp reads and fills without a copy. Include cylfuse.hpp.
 *
 * A view is as good as the memory that it points to. Containers that are about to vanish are refused, but for calls such as
 * Fitter::push_points(), which are done with the data when they return.
 */

#ifndef CYLFUSE_VIEWS_HPP
#define CYLFUSE_VIEWS_HPP

#include <cylfuse/enums.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

namespace cylfuse {

/** @cond internal */
namespace internal {

template <class T>
struct ScalarOf {
    static_assert(sizeof(T) == 0, "coordinates must be float or double; convert the others to one of these first");
    static constexpr cylfuse_scalar value = 0;
};
template <>
struct ScalarOf<float> {
    static constexpr cylfuse_scalar value = CYLFUSE_SCALAR_F32;
};
template <>
struct ScalarOf<double> {
    static constexpr cylfuse_scalar value = CYLFUSE_SCALAR_F64;
};

// Lists what a function of the C interface has, however much it is; nothing where it fails.
template <class T, class Call>
cylfuse_status list(std::vector<T> &all, Call call)
{
    std::size_t count = 0;
    cylfuse_status status = CYLFUSE_STATUS_BUFFER_TOO_SMALL;
    while (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        all.resize(count);
        status = call(all.data(), all.size(), &count);
    }
    all.resize(status == CYLFUSE_STATUS_OK ? count : 0);
    return status;
}

// Void for a container about to vanish of which there is a view while it stays.
template <class View, class Container>
using IfTemporary = typename std::enable_if<!std::is_lvalue_reference<Container>::value &&
                                            !std::is_base_of<View, Container>::value &&
                                            std::is_constructible<View, const Container &>::value>::type;

} // namespace internal
/** @endcond */

/** Adjacent elements of the caller, as std::span has them since C++20. */
template <class T>
class Span {
public:
    /** No elements. */
    constexpr Span() noexcept : data_(nullptr), size_(0) {}
    /** `size` elements from `data` on. */
    constexpr Span(T *data, std::size_t size) noexcept : data_(data), size_(size) {}
    /** All of an array. */
    template <std::size_t N>
    constexpr Span(T (&array)[N]) noexcept : data_(array), size_(N)
    {
    }
    /** All of a container with adjacent elements, such as std::vector, std::array, std::span. */
    template <class Container, class = typename std::enable_if<std::is_convertible<
                                   decltype(std::declval<Container &>().data()), T *>::value>::type>
    constexpr Span(Container &container) noexcept : data_(container.data()), size_(container.size())
    {
    }
    /** The same elements, to be read only. */
    template <class Other, class = typename std::enable_if<std::is_same<const Other, T>::value>::type>
    constexpr Span(const Span<Other> &other) noexcept : data_(other.data()), size_(other.size())
    {
    }
    /** The first element. */
    constexpr T *data() const noexcept { return data_; }
    /** How many elements there are. */
    constexpr std::size_t size() const noexcept { return size_; }

private:
    T *data_;
    std::size_t size_;
};

/** A cloud in the caller's memory, organised or not. */
struct PointsView : cylfuse_points_view {
    /** No points. */
    PointsView() noexcept { cylfuse_points_view_init(this, sizeof(cylfuse_points_view)); }
    /**
     * `columns` * `rows` points of which `x` is the first coordinate of the first; y and z follow each x. Strides in
     * bytes, 0 for packed.
     */
    template <class T>
    PointsView(const T *x, std::size_t columns, std::size_t rows = 1, std::ptrdiff_t stride = 0,
               std::ptrdiff_t stride_of_rows = 0) noexcept
        : PointsView()
    {
        scalar = internal::ScalarOf<T>::value;
        data = x;
        width = columns;
        height = rows;
        point_stride = stride;
        row_stride = stride_of_rows;
    }
    /** Packed points. */
    template <class T>
    PointsView(Span<const std::array<T, 3>> points) noexcept
        : PointsView(reinterpret_cast<const T *>(points.data()), points.size())
    {
    }
    /** Packed points. */
    template <class T>
    PointsView(Span<std::array<T, 3>> points) noexcept : PointsView(Span<const std::array<T, 3>>(points))
    {
    }
    /** Packed points. */
    template <class T, class Allocator>
    PointsView(const std::vector<std::array<T, 3>, Allocator> &points) noexcept
        : PointsView(reinterpret_cast<const T *>(points.data()), points.size())
    {
    }
    /** Would point to points that are gone. */
    template <class T, class Allocator>
    PointsView(const std::vector<std::array<T, 3>, Allocator> &&points) = delete;
    /** Packed points. */
    template <class T, std::size_t N>
    PointsView(const std::array<std::array<T, 3>, N> &points) noexcept
        : PointsView(reinterpret_cast<const T *>(points.data()), points.size())
    {
    }
    /** Would point to points that are gone. */
    template <class T, std::size_t N>
    PointsView(const std::array<std::array<T, 3>, N> &&points) = delete;
};

/** A depth image in the caller's memory. */
struct DepthView : cylfuse_depth_view {
    /** No image. */
    DepthView() noexcept { cylfuse_depth_view_init(this, sizeof(cylfuse_depth_view)); }
    /** 16-bit depths: z = value * `unit`. `stride_of_rows` in bytes, 0 for packed. */
    DepthView(const std::uint16_t *pixels, std::uint32_t columns, std::uint32_t rows, double unit,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : DepthView(pixels, DepthFormat::U16, columns, rows, unit, stride_of_rows)
    {
    }
    /** Depths in float: z = value * `unit`. `stride_of_rows` in bytes, 0 for packed. */
    DepthView(const float *pixels, std::uint32_t columns, std::uint32_t rows, double unit,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : DepthView(pixels, DepthFormat::F32, columns, rows, unit, stride_of_rows)
    {
    }

private:
    DepthView(const void *pixels, DepthFormat stored, std::uint32_t columns, std::uint32_t rows,
              double unit, std::ptrdiff_t stride_of_rows) noexcept
        : DepthView()
    {
        format = static_cast<cylfuse_depth_format>(stored);
        data = pixels;
        width = columns;
        height = rows;
        row_stride = stride_of_rows;
        scale = unit;
    }
};

/**
 * A mask in the caller's memory: non-zero, or `label` where it is set, = the cylinder. It may hold the lateral surface alone,
 * or the whole object with caps, lids and handles: with Objective::Robust a fit leaves out what the depth image shows to be
 * no part of the lateral surface. Its boundary may be some pixels off.
 */
struct MaskView : cylfuse_mask_view {
    /** No mask. */
    MaskView() noexcept { cylfuse_mask_view_init(this, sizeof(cylfuse_mask_view)); }
    /** One byte a pixel. `stride_of_rows` in bytes, 0 for packed. */
    MaskView(const std::uint8_t *pixels, std::uint32_t columns, std::uint32_t rows,
             std::ptrdiff_t stride_of_rows = 0) noexcept
        : MaskView()
    {
        data = pixels;
        width = columns;
        height = rows;
        row_stride = stride_of_rows;
    }
};

/** An image in the caller's memory. Its values are linear in light; set `gamma` where they are not. */
struct ImageView : cylfuse_image_view {
    /** No image. */
    ImageView() noexcept { cylfuse_image_view_init(this, sizeof(cylfuse_image_view)); }
    /** Pixels of any type, grey or in colour. `stride_of_rows` in bytes, 0 for packed. */
    ImageView(const void *pixels, ImageFormat stored, std::uint32_t columns, std::uint32_t rows,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : ImageView()
    {
        format = static_cast<cylfuse_image_format>(stored);
        data = pixels;
        width = columns;
        height = rows;
        row_stride = stride_of_rows;
    }
    /** Grey values of 8 bits. `stride_of_rows` in bytes, 0 for packed. */
    ImageView(const std::uint8_t *pixels, std::uint32_t columns, std::uint32_t rows,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : ImageView(pixels, ImageFormat::U8, columns, rows, stride_of_rows)
    {
    }
    /** Grey values of 16 bits. `stride_of_rows` in bytes, 0 for packed. */
    ImageView(const std::uint16_t *pixels, std::uint32_t columns, std::uint32_t rows,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : ImageView(pixels, ImageFormat::U16, columns, rows, stride_of_rows)
    {
    }
    /** Grey values in float. `stride_of_rows` in bytes, 0 for packed. */
    ImageView(const float *pixels, std::uint32_t columns, std::uint32_t rows,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : ImageView(pixels, ImageFormat::F32, columns, rows, stride_of_rows)
    {
    }
};

/** Edge segments in the caller's memory: x1 y1 x2 y2 in pixels each. */
struct SegmentsView : cylfuse_segments_view {
    /** No segments. */
    SegmentsView() noexcept { cylfuse_segments_view_init(this, sizeof(cylfuse_segments_view)); }
    /** `number` segments of which `x1` is the first coordinate of the first. `stride` in bytes, 0 for packed. */
    template <class T>
    SegmentsView(const T *x1, std::size_t number, std::ptrdiff_t stride = 0) noexcept : SegmentsView()
    {
        scalar = internal::ScalarOf<T>::value;
        data = x1;
        count = number;
        segment_stride = stride;
    }
    /** Packed segments. */
    template <class T>
    SegmentsView(Span<const std::array<T, 4>> segments) noexcept
        : SegmentsView(reinterpret_cast<const T *>(segments.data()), segments.size())
    {
    }
    /** Packed segments. */
    template <class T>
    SegmentsView(Span<std::array<T, 4>> segments) noexcept : SegmentsView(Span<const std::array<T, 4>>(segments))
    {
    }
    /** Packed segments. */
    template <class T, class Allocator>
    SegmentsView(const std::vector<std::array<T, 4>, Allocator> &segments) noexcept
        : SegmentsView(reinterpret_cast<const T *>(segments.data()), segments.size())
    {
    }
    /** Would point to segments that are gone. */
    template <class T, class Allocator>
    SegmentsView(const std::vector<std::array<T, 4>, Allocator> &&segments) = delete;
    /** Packed segments. */
    template <class T, std::size_t N>
    SegmentsView(const std::array<std::array<T, 4>, N> &segments) noexcept
        : SegmentsView(reinterpret_cast<const T *>(segments.data()), segments.size())
    {
    }
    /** Would point to segments that are gone. */
    template <class T, std::size_t N>
    SegmentsView(const std::array<std::array<T, 4>, N> &&segments) = delete;
};

/** A buffer of the caller for points. */
struct PointsOut : cylfuse_points_out {
    /** No room. */
    PointsOut() noexcept { cylfuse_points_out_init(this, sizeof(cylfuse_points_out)); }
    /** Room for `points` points of which `x` is the first coordinate of the first. `stride` in bytes, 0 for packed. */
    template <class T>
    PointsOut(T *x, std::size_t points, std::ptrdiff_t stride = 0) noexcept : PointsOut()
    {
        scalar = internal::ScalarOf<T>::value;
        data = x;
        capacity = points;
        point_stride = stride;
    }
};

/** A buffer of the caller for a depth image. */
struct DepthOut : cylfuse_depth_out {
    /** No room. */
    DepthOut() noexcept { cylfuse_depth_out_init(this, sizeof(cylfuse_depth_out)); }
    /** 16-bit depths: z = value * `unit`. `stride_of_rows` in bytes, 0 for packed. */
    DepthOut(std::uint16_t *pixels, std::uint32_t columns, std::uint32_t rows, double unit,
             std::ptrdiff_t stride_of_rows = 0) noexcept
        : DepthOut(pixels, DepthFormat::U16, columns, rows, unit, stride_of_rows)
    {
    }
    /** Depths in float: z = value * `unit`. `stride_of_rows` in bytes, 0 for packed. */
    DepthOut(float *pixels, std::uint32_t columns, std::uint32_t rows, double unit,
             std::ptrdiff_t stride_of_rows = 0) noexcept
        : DepthOut(pixels, DepthFormat::F32, columns, rows, unit, stride_of_rows)
    {
    }

private:
    DepthOut(void *pixels, DepthFormat stored, std::uint32_t columns, std::uint32_t rows, double unit,
             std::ptrdiff_t stride_of_rows) noexcept
        : DepthOut()
    {
        format = static_cast<cylfuse_depth_format>(stored);
        data = pixels;
        width = columns;
        height = rows;
        row_stride = stride_of_rows;
        scale = unit;
    }
};

} // namespace cylfuse

#endif

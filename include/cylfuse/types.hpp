/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file types.hpp
 * What cylfuse.hpp takes and gives: errors, views, settings, results. Include cylfuse.hpp, which says how they are
 * meant.
 */

#ifndef CYLFUSE_TYPES_HPP
#define CYLFUSE_TYPES_HPP

#include <cylfuse/cylfuse.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

static_assert(CYLFUSE_ABI_VERSION == 1, "cylfuse.hpp and cylfuse.h are of different versions");

/** Measures a cylinder from one RGB-D view. */
namespace cylfuse {

// Programs may mix both modes: what is compiled in one must not be taken for the other by the linker.
#ifdef CYLFUSE_NO_EXCEPTIONS
inline namespace without_exceptions {
#else
inline namespace with_exceptions {
#endif

/** A status of the C interface: CYLFUSE_STATUS_OK or a negative number. */
using Status = cylfuse_status;

/** An infinite cylinder: point on the axis, direction, radius; the order of PCL's coefficients. */
using Cylinder = cylfuse_cylinder;

/** A failed call: the status and what was wrong, the value, the limit and the remedy. Allocates nothing. */
class Error : public std::exception {
public:
    /** A failure with its text, which is cut at 511 bytes; without one that of the status is taken. */
    explicit Error(Status status, const char *message = "") noexcept : status_(status)
    {
        if (message == nullptr || *message == '\0') {
            message = cylfuse_status_string(status);
        }
        const std::size_t length = std::strlen(message);
        const std::size_t kept = length < sizeof message_ ? length : sizeof message_ - 1;
        std::memcpy(message_, message, kept);
        message_[kept] = '\0';
    }

    /** The status, one of CYLFUSE_STATUS_.... */
    Status status() const noexcept { return status_; }

    /** The text. */
    const char *what() const noexcept override { return message_; }

private:
    Status status_;
    char message_[512];
};

#ifdef CYLFUSE_NO_EXCEPTIONS

/** What a call gives without exceptions: a value or an error. */
template <class T>
class Outcome {
public:
    /** A value, which means something when the status of the error is CYLFUSE_STATUS_OK. */
    Outcome(T value, const Error &error) : value_(std::move(value)), error_(error) {}
    /** Whether there is a value. */
    explicit operator bool() const noexcept { return error_.status() == CYLFUSE_STATUS_OK; }
    /** CYLFUSE_STATUS_OK when there is a value. */
    Status status() const noexcept { return error_.status(); }
    /** What was wrong; meaningless when there is a value. */
    const Error &error() const noexcept { return error_; }
    /** The value, meaningless after a failure. */
    T &operator*() noexcept { return value_; }
    /** The value, meaningless after a failure. */
    const T &operator*() const noexcept { return value_; }
    /** A member of the value, meaningless after a failure. */
    T *operator->() noexcept { return &value_; }
    /** A member of the value, meaningless after a failure. */
    const T *operator->() const noexcept { return &value_; }

private:
    T value_;
    Error error_;
};

/** What a call without a value gives without exceptions. */
template <>
class Outcome<void> {
public:
    /** A failure, unless the status of the error is CYLFUSE_STATUS_OK. */
    explicit Outcome(const Error &error) : error_(error) {}
    /** Whether the call did what it was asked to. */
    explicit operator bool() const noexcept { return error_.status() == CYLFUSE_STATUS_OK; }
    /** CYLFUSE_STATUS_OK or why not. */
    Status status() const noexcept { return error_.status(); }
    /** What was wrong; meaningless after a success. */
    const Error &error() const noexcept { return error_; }

private:
    Error error_;
};

/** What methods return: T with exceptions, Outcome<T> without. */
template <class T>
using Returned = Outcome<T>;

#else

/** What methods return: T with exceptions, Outcome<T> without. */
template <class T>
using Returned = T;

#endif

/** @cond internal */
namespace detail {

/** Why a call failed on a fitter, or on this thread without one. */
inline const char *last_error(Status status, const cylfuse_fitter *fitter = nullptr) noexcept
{
    return status == CYLFUSE_STATUS_OK ? "" : cylfuse_fitter_last_error(fitter);
}

#ifdef CYLFUSE_NO_EXCEPTIONS

inline Outcome<void> finish(Status status, const char *message = "")
{
    return Outcome<void>(Error(status, message));
}

template <class T>
Outcome<T> finish(Status status, T value, const char *message = "")
{
    return Outcome<T>(std::move(value), Error(status, message));
}

#else

inline void finish(Status status, const char *message = "")
{
    if (status != CYLFUSE_STATUS_OK) {
        throw Error(status, message);
    }
}

template <class T>
T finish(Status status, T value, const char *message = "")
{
    finish(status, message);
    return value;
}

#endif

template <class T>
struct ScalarOf; // Coordinates are float or double.
template <>
struct ScalarOf<float> {
    static constexpr cylfuse_scalar value = CYLFUSE_SCALAR_F32;
};
template <>
struct ScalarOf<double> {
    static constexpr cylfuse_scalar value = CYLFUSE_SCALAR_F64;
};

} // namespace detail
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
    /** The first element. */
    constexpr T *data() const noexcept { return data_; }
    /** How many elements there are. */
    constexpr std::size_t size() const noexcept { return size_; }

private:
    T *data_;
    std::size_t size_;
};

/** The settings of a fit, with the defaults at first. */
struct Options : cylfuse_options {
    Options() noexcept { cylfuse_options_init(this, sizeof(cylfuse_options)); }
};

/** A camera; a pinhole unless `distortion_model` and `distortion` are set. */
struct Intrinsics : cylfuse_intrinsics {
    /** All 0, to be filled. */
    Intrinsics() noexcept { cylfuse_intrinsics_init(this, sizeof(cylfuse_intrinsics)); }
    /** A pinhole: size of the image, focal lengths and principal point in pixels. */
    Intrinsics(std::uint32_t columns, std::uint32_t rows, double focal_x, double focal_y, double center_x,
               double center_y) noexcept
        : Intrinsics()
    {
        width = columns;
        height = rows;
        fx = focal_x;
        fy = focal_y;
        cx = center_x;
        cy = center_y;
    }
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
        scalar = detail::ScalarOf<T>::value;
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
    template <class T, class Allocator>
    PointsView(const std::vector<std::array<T, 3>, Allocator> &points) noexcept
        : PointsView(reinterpret_cast<const T *>(points.data()), points.size())
    {
    }
};

/** A depth image in the caller's memory. */
struct DepthView : cylfuse_depth_view {
    /** No image. */
    DepthView() noexcept { cylfuse_depth_view_init(this, sizeof(cylfuse_depth_view)); }
    /** 16-bit depths: z = value * `unit`. `stride_of_rows` in bytes, 0 for packed. */
    DepthView(const std::uint16_t *pixels, std::uint32_t columns, std::uint32_t rows, double unit,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : DepthView(pixels, CYLFUSE_DEPTH_FORMAT_U16, columns, rows, unit, stride_of_rows)
    {
    }
    /** Depths in float: z = value * `unit`. `stride_of_rows` in bytes, 0 for packed. */
    DepthView(const float *pixels, std::uint32_t columns, std::uint32_t rows, double unit,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : DepthView(pixels, CYLFUSE_DEPTH_FORMAT_F32, columns, rows, unit, stride_of_rows)
    {
    }

private:
    DepthView(const void *pixels, cylfuse_depth_format stored, std::uint32_t columns, std::uint32_t rows,
              double unit, std::ptrdiff_t stride_of_rows) noexcept
        : DepthView()
    {
        format = stored;
        data = pixels;
        width = columns;
        height = rows;
        row_stride = stride_of_rows;
        scale = unit;
    }
};

/** A mask in the caller's memory: non-zero = visible lateral surface of the cylinder. */
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

/** A grey image in the caller's memory. Its values are linear in light; set `gamma` where they are not. */
struct ImageView : cylfuse_image_view {
    /** No image. */
    ImageView() noexcept { cylfuse_image_view_init(this, sizeof(cylfuse_image_view)); }
    /** Values of 8 bits. `stride_of_rows` in bytes, 0 for packed. */
    ImageView(const std::uint8_t *pixels, std::uint32_t columns, std::uint32_t rows,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : ImageView(pixels, CYLFUSE_IMAGE_FORMAT_U8, columns, rows, stride_of_rows)
    {
    }
    /** Values of 16 bits. `stride_of_rows` in bytes, 0 for packed. */
    ImageView(const std::uint16_t *pixels, std::uint32_t columns, std::uint32_t rows,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : ImageView(pixels, CYLFUSE_IMAGE_FORMAT_U16, columns, rows, stride_of_rows)
    {
    }
    /** Values in float. `stride_of_rows` in bytes, 0 for packed. */
    ImageView(const float *pixels, std::uint32_t columns, std::uint32_t rows,
              std::ptrdiff_t stride_of_rows = 0) noexcept
        : ImageView(pixels, CYLFUSE_IMAGE_FORMAT_F32, columns, rows, stride_of_rows)
    {
    }

private:
    ImageView(const void *pixels, cylfuse_image_format stored, std::uint32_t columns, std::uint32_t rows,
              std::ptrdiff_t stride_of_rows) noexcept
        : ImageView()
    {
        format = stored;
        data = pixels;
        width = columns;
        height = rows;
        row_stride = stride_of_rows;
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
        scalar = detail::ScalarOf<T>::value;
        data = x1;
        count = number;
        segment_stride = stride;
    }
    /** Packed segments. */
    template <class T, class Allocator>
    SegmentsView(const std::vector<std::array<T, 4>, Allocator> &segments) noexcept
        : SegmentsView(reinterpret_cast<const T *>(segments.data()), segments.size())
    {
    }
    /** Packed segments. */
    template <class T, std::size_t N>
    SegmentsView(const std::array<std::array<T, 4>, N> &segments) noexcept
        : SegmentsView(reinterpret_cast<const T *>(segments.data()), segments.size())
    {
    }
};

/** A buffer of the caller for points. */
struct PointsOut : cylfuse_points_out {
    /** No room. */
    PointsOut() noexcept { cylfuse_points_out_init(this, sizeof(cylfuse_points_out)); }
    /** Room for `points` points of which `x` is the first coordinate of the first. `stride` in bytes, 0 for packed. */
    template <class T>
    PointsOut(T *x, std::size_t points, std::ptrdiff_t stride = 0) noexcept : PointsOut()
    {
        scalar = detail::ScalarOf<T>::value;
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
        : DepthOut(pixels, CYLFUSE_DEPTH_FORMAT_U16, columns, rows, unit, stride_of_rows)
    {
    }
    /** Depths in float: z = value * `unit`. `stride_of_rows` in bytes, 0 for packed. */
    DepthOut(float *pixels, std::uint32_t columns, std::uint32_t rows, double unit,
             std::ptrdiff_t stride_of_rows = 0) noexcept
        : DepthOut(pixels, CYLFUSE_DEPTH_FORMAT_F32, columns, rows, unit, stride_of_rows)
    {
    }

private:
    DepthOut(void *pixels, cylfuse_depth_format stored, std::uint32_t columns, std::uint32_t rows, double unit,
             std::ptrdiff_t stride_of_rows) noexcept
        : DepthOut()
    {
        format = stored;
        data = pixels;
        width = columns;
        height = rows;
        row_stride = stride_of_rows;
        scale = unit;
    }
};

/** The outcome of a fit with the numbers to judge it. */
struct Result : cylfuse_result {
    Result() noexcept : cylfuse_result() { struct_size = sizeof(cylfuse_result); }
    /** Whether a doubt is there, such as CYLFUSE_RESULT_FLAGS_WEAK_RADIUS. */
    bool has(cylfuse_result_flags doubt) const noexcept { return (flags & doubt) != 0; }
};

/** What was pushed, and what was left out by reason. */
struct Counts : cylfuse_counts {
    Counts() noexcept : cylfuse_counts() { struct_size = sizeof(cylfuse_counts); }
};

/** What the data determine at a cylinder. */
struct Diagnosis : cylfuse_diagnosis {
    Diagnosis() noexcept : cylfuse_diagnosis() { struct_size = sizeof(cylfuse_diagnosis); }
};

/** What became of the pixels of a completion. */
struct Completion : cylfuse_completion {
    Completion() noexcept : cylfuse_completion() { struct_size = sizeof(cylfuse_completion); }
};

/** The visible piece of the cylinder. */
struct Extent : cylfuse_extent {
    Extent() noexcept : cylfuse_extent() { struct_size = sizeof(cylfuse_extent); }
};

/** How two cylinders differ. */
struct Difference {
    double angle;           ///< Angle between the axes in radians, in [0, pi / 2].
    double axis_distance;   ///< Shortest distance between the two axes, in the unit of length.
    double radius_relative; ///< (radius of the second - radius of the first) / radius of the first.
};

/** The two limb lines in the image: a u + b v + c = 0 with a^2 + b^2 = 1, in ideal pixels. */
using LimbLines = std::array<std::array<double, 3>, 2>;

} // inline namespace
} // namespace cylfuse

#endif

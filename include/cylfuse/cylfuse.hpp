/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file cylfuse.hpp
 * The C interface in C++14: header only, nothing but cylfuse.h and the standard library.
 *
 * cylfuse::Fitter owns a fitter of the C interface. Its methods have the names of the C functions and do what is
 * said there; units, frames, missing values and threads are as at the top of cylfuse.h. What is filled by the
 * caller or by the library derives from the C struct of that name and sets its size and defaults, so fields are
 * used directly: `options.method = CYLFUSE_METHOD_POINTS`.
 *
 * Errors. A call that fails throws cylfuse::Error, with the status and the text of the library. Where
 * CYLFUSE_NO_EXCEPTIONS is defined nothing throws: the same methods return cylfuse::Outcome instead.
 *
 * Memory. Views point to memory of the caller and copy nothing. Only what takes a `std::vector` to be filled
 * allocates, when that vector has to grow.
 */

#ifndef CYLFUSE_HPP
#define CYLFUSE_HPP

#include <cylfuse/cylfuse.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
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

/** A grey image in the caller's memory. */
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

/** Hears of every linear solve of a fit; false stops it with CYLFUSE_STATUS_CANCELLED. */
using ProgressCallback = std::function<bool(const cylfuse_progress &)>;

/** Takes a log line, one of CYLFUSE_LOG_LEVEL_..., valid until it returns. */
using LogCallback = std::function<void(cylfuse_log_level, const char *)>;

/**
 * Estimates one cylinder. Set the camera, push data, fit; for the next frame: clear, push, fit.
 *
 * Moves but does not copy. A fitter that was moved from holds nothing: all its calls fail with
 * CYLFUSE_STATUS_NULL_POINTER. Callbacks may throw: the exception leaves the method that they were called from.
 */
class Fitter {
public:
#ifndef CYLFUSE_NO_EXCEPTIONS
    /** A fitter with default options and no data. */
    Fitter() : Fitter(create()) {}
#endif
    /** A fitter with default options and no data. */
    static Returned<Fitter> create()
    {
        cylfuse_fitter *made = nullptr;
        const Status status = cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &made);
        return detail::finish(status, Fitter(made));
    }
    /** Takes over a fitter of the C interface, which has no callbacks; NULL for one that holds nothing. */
    explicit Fitter(cylfuse_fitter *fitter) noexcept : handle_(fitter) {}

    /** The fitter for functions of the C interface; stays owned. */
    cylfuse_fitter *handle() const noexcept { return handle_.get(); }
    /** Gives the fitter away, without callbacks: cylfuse_fitter_destroy() is up to the caller then. */
    cylfuse_fitter *release() noexcept
    {
        if (handle_ && callbacks_) {
            cylfuse_fitter_set_progress(handle(), nullptr, nullptr);
            cylfuse_fitter_set_log(handle(), CYLFUSE_LOG_LEVEL_OFF, nullptr, nullptr);
        }
        callbacks_.reset();
        return handle_.release();
    }

    /** Makes room, so that pushing that many more points and segments needs no memory. */
    Returned<void> reserve(std::size_t points, std::size_t segments)
    {
        return finish(cylfuse_fitter_reserve(handle(), points, segments));
    }
    /** Forgets data and result; keeps options, camera, start model, callbacks and memory. */
    Returned<void> clear() { return finish(cylfuse_fitter_clear(handle())); }
    /** Asks the running fit to stop; from any thread. */
    Returned<void> cancel() { return detail::finish(cylfuse_fitter_cancel(handle())); }

    /** Replaces the options. */
    Returned<void> set_options(const cylfuse_options &options)
    {
        return finish(cylfuse_fitter_set_options(handle(), &options));
    }
    /** The options. */
    Returned<Options> options() const
    {
        Options options;
        const Status status = cylfuse_fitter_get_options(handle(), &options);
        return finish(status, options);
    }
    /** Sets the camera, which depth images and edges need. */
    Returned<void> set_intrinsics(const cylfuse_intrinsics &intrinsics)
    {
        return finish(cylfuse_fitter_set_intrinsics(handle(), &intrinsics));
    }
    /** Sets a model to start from; NULL takes it away. */
    Returned<void> set_start_model(const Cylinder *model)
    {
        return finish(cylfuse_fitter_set_start_model(handle(), model));
    }
    /** Sets the progress callback; an empty one takes it away. */
    Returned<void> set_progress(ProgressCallback callback)
    {
        Callbacks &all = callbacks();
        all.progress = std::move(callback);
        const cylfuse_progress_fn function = all.progress ? on_progress : nullptr;
        return finish(cylfuse_fitter_set_progress(handle(), function, &all));
    }
    /** Sets the log callback for lines up to a level; an empty one takes it away. */
    Returned<void> set_log(cylfuse_log_level max_level, LogCallback callback)
    {
        Callbacks &all = callbacks();
        all.log = std::move(callback);
        const cylfuse_log_fn function = all.log ? on_log : nullptr;
        return finish(cylfuse_fitter_set_log(handle(), max_level, function, &all));
    }

    /** Adds points. */
    Returned<void> push_points(const PointsView &points)
    {
        return finish(cylfuse_fitter_push_points(handle(), &points, nullptr));
    }
    /** Adds the points of an organised cloud inside a mask. */
    Returned<void> push_points(const PointsView &points, const MaskView &mask)
    {
        return finish(cylfuse_fitter_push_points(handle(), &points, &mask));
    }
    /** Adds the points of a depth image. */
    Returned<void> push_depth(const DepthView &depth)
    {
        return finish(cylfuse_fitter_push_depth(handle(), &depth, nullptr));
    }
    /** Adds the points of a depth image inside a mask. */
    Returned<void> push_depth(const DepthView &depth, const MaskView &mask)
    {
        return finish(cylfuse_fitter_push_depth(handle(), &depth, &mask));
    }
    /** Adds edge segments: pieces of the two limb lines in the (distorted) image. */
    Returned<void> push_edges(const SegmentsView &segments)
    {
        return finish(cylfuse_fitter_push_edges(handle(), &segments));
    }
    /** Takes the grey image of the camera, in which limbs and ends are located. */
    Returned<void> push_image(const ImageView &image)
    {
        return finish(cylfuse_fitter_push_image(handle(), &image));
    }
    /** What was pushed, and what was left out by reason. */
    Returned<Counts> counts() const
    {
        Counts counts;
        const Status status = cylfuse_fitter_counts(handle(), &counts);
        return finish(status, counts);
    }

    /** Estimates the cylinder from everything that was pushed. */
    Returned<Result> fit()
    {
        Result result;
        const Status status = cylfuse_fitter_fit(handle(), &result);
        return finish(status, result);
    }
    /** What a fit would report for a given model, without iterating. */
    Returned<Result> evaluate(const Cylinder &model) const
    {
        Result result;
        const Status status = cylfuse_fitter_evaluate(handle(), &model, &result);
        return finish(status, result);
    }
    /** The result of the last fit that succeeded. */
    Returned<Result> result() const
    {
        Result result;
        const Status status = cylfuse_fitter_get_result(handle(), &result);
        return finish(status, result);
    }
    /** Writes residuals, CYLFUSE_RESIDUAL_KIND_..., and gives their number. `model`: NULL = the last fit. */
    Returned<std::size_t> residuals(cylfuse_residual_kind kind, Span<double> out,
                                    const Cylinder *model = nullptr) const
    {
        std::size_t count = 0;
        const Status status =
            cylfuse_fitter_residuals(handle(), model, kind, out.data(), out.size(), &count);
        return finish(status, count);
    }
    /** Writes what was seen of the limbs in the image, and gives the number of samples. */
    Returned<std::size_t> limb_samples(Span<cylfuse_limb_sample> out) const
    {
        std::size_t count = 0;
        const Status status = cylfuse_fitter_limb_samples(handle(), out.data(), out.size(), &count);
        return finish(status, count);
    }
    /** What the data determine at a model. `model`: NULL = the last fit. */
    Returned<Diagnosis> diagnose(const Cylinder *model = nullptr) const
    {
        Diagnosis diagnosis;
        const Status status = cylfuse_fitter_diagnose(handle(), model, &diagnosis);
        return finish(status, diagnosis);
    }

    /** How many points a completion may give at most. `mask`: NULL = that of the last depth image. */
    Returned<std::size_t> complete_bound(cylfuse_layout layout, const MaskView *mask = nullptr) const
    {
        std::size_t bound = 0;
        const Status status = cylfuse_fitter_complete_bound(handle(), mask, layout, &bound);
        return finish(status, bound);
    }
    /** Completes the cloud over a mask. NULL = the model of the last fit, the mask of the last depth image. */
    Returned<Completion> complete(const PointsOut &out, const Cylinder *model = nullptr,
                                  const MaskView *mask = nullptr)
    {
        Completion completion;
        const Status status = cylfuse_fitter_complete(handle(), model, mask, &out, &completion);
        return finish(status, completion);
    }
    /** Completes the cloud into a vector, which gets the size of what there is. */
    template <class T, class Allocator>
    Returned<Completion> complete(std::vector<std::array<T, 3>, Allocator> &points,
                                  const Cylinder *model = nullptr, const MaskView *mask = nullptr)
    {
        std::size_t bound = 0;
        Status status = cylfuse_fitter_complete_bound(handle(), mask, CYLFUSE_LAYOUT_PACKED, &bound);
        Completion completion;
        if (status == CYLFUSE_STATUS_OK) {
            points.resize(bound);
            const PointsOut out(reinterpret_cast<T *>(points.data()), points.size());
            status = cylfuse_fitter_complete(handle(), model, mask, &out, &completion);
            points.resize(static_cast<std::size_t>(completion.count));
        }
        return finish(status, completion);
    }
    /** Completes the depth image. NULL = the model of the last fit, the mask of the last depth image. */
    Returned<Completion> complete_depth(const DepthOut &out, const Cylinder *model = nullptr,
                                        const MaskView *mask = nullptr)
    {
        Completion completion;
        const Status status = cylfuse_fitter_complete_depth(handle(), model, mask, &out, &completion);
        return finish(status, completion);
    }
    /** The visible piece of the cylinder. NULL = the model of the last fit, the mask of the last depth image. */
    Returned<Extent> extent(const Cylinder *model = nullptr, const MaskView *mask = nullptr) const
    {
        Extent extent;
        const Status status = cylfuse_fitter_extent(handle(), model, mask, &extent);
        return finish(status, extent);
    }
    /**
     * Selects, of straight edges that a line detector found, those on the two limbs of a rough cylinder beside the
     * points that were pushed: writes 1 or 2 for the limb that a segment lies on, 0 for none. `reach` in pixels, 0 =
     * 15 % of the distance of the limbs, at least 4. `model`: NULL = the last fit.
     */
    Returned<void> select_edges(const SegmentsView &segments, Span<std::uint8_t> out, double reach = 0.0,
                                const Cylinder *model = nullptr) const
    {
        return finish(
            cylfuse_fitter_select_edges(handle(), model, &segments, reach, out.data(), out.size()));
    }

private:
    struct Callbacks {
        ProgressCallback progress;
        LogCallback log;
#ifndef CYLFUSE_NO_EXCEPTIONS
        std::exception_ptr thrown;
#endif
    };
    struct Destroy {
        void operator()(cylfuse_fitter *fitter) const noexcept { cylfuse_fitter_destroy(fitter); }
    };

    // The library keeps its address: it stays where it is when the fitter moves.
    Callbacks &callbacks()
    {
        if (!callbacks_) {
            callbacks_.reset(new Callbacks());
        }
        return *callbacks_;
    }

    // No exception may run through the library: it waits here until the call is back.
    static std::int32_t on_progress(const cylfuse_progress *progress, void *user_data) noexcept
    {
        Callbacks &all = *static_cast<Callbacks *>(user_data);
#ifdef CYLFUSE_NO_EXCEPTIONS
        return all.progress(*progress) ? 0 : 1;
#else
        try {
            return all.progress(*progress) ? 0 : 1;
        } catch (...) {
            all.thrown = std::current_exception();
            return 1;
        }
#endif
    }
    static void on_log(cylfuse_log_level level, const char *message, void *user_data) noexcept
    {
        Callbacks &all = *static_cast<Callbacks *>(user_data);
#ifdef CYLFUSE_NO_EXCEPTIONS
        all.log(level, message);
#else
        try {
            all.log(level, message);
        } catch (...) {
            all.thrown = std::current_exception();
        }
#endif
    }

    void rethrow() const
    {
#ifndef CYLFUSE_NO_EXCEPTIONS
        if (callbacks_ && callbacks_->thrown) {
            std::rethrow_exception(std::exchange(callbacks_->thrown, nullptr));
        }
#endif
    }
    const char *message(Status status) const noexcept
    {
        return status == CYLFUSE_STATUS_OK ? "" : cylfuse_fitter_last_error(handle());
    }
    Returned<void> finish(Status status) const
    {
        rethrow();
        return detail::finish(status, message(status));
    }
    template <class T>
    Returned<T> finish(Status status, const T &value) const
    {
        rethrow();
        return detail::finish(status, value, message(status));
    }

    // In this order: the fitter goes first, the callbacks that it knows after it.
    std::unique_ptr<Callbacks> callbacks_;
    std::unique_ptr<cylfuse_fitter, Destroy> handle_;
};

/** Writes signed distances of points from the surface, negative inside, NaN for points that are not finite. */
inline Returned<void> distances(const Cylinder &model, const PointsView &points, Span<double> out)
{
    return detail::finish(cylfuse_cylinder_distances(&model, &points, out.data(), out.size()));
}

/** The two limb lines of a cylinder in the image. */
inline Returned<LimbLines> project(const Cylinder &model, const cylfuse_intrinsics &intrinsics)
{
    LimbLines lines{};
    const Status status = cylfuse_cylinder_project(&model, &intrinsics, lines[0].data());
    return detail::finish(status, lines);
}

/** How the second cylinder differs from the first. */
inline Returned<Difference> compare(const Cylinder &first, const Cylinder &second)
{
    Difference difference{};
    const Status status = cylfuse_cylinder_compare(&first, &second, &difference.angle,
                                                   &difference.axis_distance, &difference.radius_relative);
    return detail::finish(status, difference);
}

} // inline namespace
} // namespace cylfuse

#endif

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

#include <cylfuse/types.hpp>

#include <functional>
#include <memory>

namespace cylfuse {
#ifdef CYLFUSE_NO_EXCEPTIONS
inline namespace without_exceptions {
#else
inline namespace with_exceptions {
#endif

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
        return detail::finish(status, Fitter(made), detail::last_error(status));
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
        return detail::last_error(status, handle());
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
    const Status status = cylfuse_cylinder_distances(&model, &points, out.data(), out.size());
    return detail::finish(status, detail::last_error(status));
}

/** The two limb lines of a cylinder in the image. */
inline Returned<LimbLines> project(const Cylinder &model, const cylfuse_intrinsics &intrinsics)
{
    LimbLines lines{};
    const Status status = cylfuse_cylinder_project(&model, &intrinsics, lines[0].data());
    return detail::finish(status, lines, detail::last_error(status));
}

/** How the second cylinder differs from the first. */
inline Returned<Difference> compare(const Cylinder &first, const Cylinder &second)
{
    Difference difference{};
    const Status status = cylfuse_cylinder_compare(&first, &second, &difference.angle,
                                                   &difference.axis_distance, &difference.radius_relative);
    return detail::finish(status, difference, detail::last_error(status));
}

} // inline namespace
} // namespace cylfuse

#endif

/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file cylfuse.hpp
 * The C interface in C++14: header only, nothing but cylfuse.h and the standard library.
 *
 * cylfuse::Fitter owns a fitter of the C interface, cylfuse::Frame a frame, cylfuse::Detector a detector;
 * cylfuse::fit_all() fits many. Their methods have the names of the C functions and do what is said there; units,
 * frames of coordinates, missing values, views and threads are as at the top of cylfuse.h. What is filled by the
 * caller or by the library derives from the C struct of that name and sets its size and defaults: numbers are its
 * fields, as in `options.edge_noise = 0.5`, and enumerations are read and set by functions of the name of the
 * field, as in `options.method(cylfuse::Method::Ransac)`.
 *
 * Left out. A model that is left out is that of the last fit, a mask that of the selected view. What comes before a
 * parameter that is given is left out by `{}`: `fitter.extent({}, mask)`.
 *
 * Errors. A call that fails throws cylfuse::Error, with the status and the text of the library. Where
 * CYLFUSE_NO_EXCEPTIONS is defined nothing throws: the same methods return cylfuse::Outcome instead.
 *
 * Memory. Views point to memory of the caller and copy nothing. Only what returns or fills a `std::vector` allocates.
 */

#ifndef CYLFUSE_HPP
#define CYLFUSE_HPP

#include <cylfuse/callbacks.hpp>
#include <cylfuse/error.hpp>
#include <cylfuse/frame.hpp>
#include <cylfuse/handle.hpp>
#include <cylfuse/types.hpp>
#include <cylfuse/views.hpp>

#include <algorithm>
#include <memory>

static_assert(CYLFUSE_ABI_VERSION == 1, "cylfuse.hpp and cylfuse.h are of different versions");

namespace cylfuse {
#ifdef CYLFUSE_NO_EXCEPTIONS
inline namespace without_exceptions {
#else
inline namespace with_exceptions {
#endif

/**
 * Estimates one cylinder. Set the camera, push data, fit; for the next frame: clear, push, fit.
 *
 * Moves but does not copy, unless by clone(). A fitter that was moved from holds nothing: all its calls fail with
 * Status::NullPointer. Callbacks may throw: the exception leaves the method that they were called from. One of progress
 * stops the fit; after one of the log, which stops nothing, the method has done its work, such as adding the points.
 */
class Fitter : detail::Handle<cylfuse_fitter, detail::DestroyFitter, cylfuse_fitter_last_error> {
public:
#ifndef CYLFUSE_NO_EXCEPTIONS
    /** A fitter with default options, one view at the identity, and no data. */
    Fitter() : Fitter(create()) {}
#endif
    /** A fitter with default options, one view at the identity, and no data. */
    static Returned<Fitter> create()
    {
        cylfuse_fitter *made = nullptr;
        const cylfuse_status status = cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &made);
        return detail::finish_call(status, Fitter(made));
    }
    /** Takes over a fitter of the C interface, which has no callbacks; NULL for one that holds nothing. */
    explicit Fitter(cylfuse_fitter *fitter) noexcept : Handle(fitter) {}

    /**
     * Another fitter with all that this one holds, settings, data and result, but no callbacks. Images are shared, points are
     * copied: after clear() it takes next to nothing.
     */
    Returned<Fitter> clone() const
    {
        cylfuse_fitter *made = nullptr;
        const cylfuse_status status = cylfuse_fitter_clone(begin(), &made);
        return finish(status, Fitter(made));
    }

    /** The fitter for functions of the C interface; stays owned. */
    cylfuse_fitter *handle() const noexcept { return handle_.get(); }
    /**
     * The text of the failure of the last call, empty after one that succeeded; see cylfuse_fitter_last_error(). It stays
     * until the next call of this thread.
     */
    const char *last_error() const noexcept { return cylfuse_fitter_last_error(handle()); }
    /**
     * Gives the fitter away, without callbacks: cylfuse_fitter_destroy() is up to the caller then. NULL while a call on
     * it is running; it stays here then.
     */
    cylfuse_fitter *release() noexcept
    {
        detail::DestroyFitter &callbacks = handle_.get_deleter();
        const auto busy = [](cylfuse_status status) { return status == CYLFUSE_STATUS_BUSY; };
        if ((callbacks.progress && busy(cylfuse_fitter_set_progress(handle(), nullptr, nullptr))) ||
            (callbacks.log && busy(cylfuse_fitter_set_log(handle(), CYLFUSE_LOG_LEVEL_OFF, nullptr, nullptr)))) {
            return nullptr;
        }
        callbacks.progress.reset();
        callbacks.log.reset();
        return handle_.release();
    }

    /** Makes room for the coordinates of that many more points and for that many more segments in the selected view. */
    Returned<void> reserve(std::size_t points, std::size_t segments)
    {
        return finish(cylfuse_fitter_reserve(begin(), points, segments));
    }
    /**
     * Forgets data, result, all views but the first, and its pose; keeps what else was set, what Start::Last goes on from,
     * and memory.
     */
    Returned<void> clear() { return finish(cylfuse_fitter_clear(begin())); }
    /** Forgets some of the data of the selected view: `clear_input(Input::Depth | Input::Image)`. */
    Returned<void> clear_input(Input inputs)
    {
        return finish(cylfuse_fitter_clear_input(begin(), static_cast<cylfuse_input>(inputs)));
    }
    /** Asks the calls that are running to stop; from any thread, and from callbacks. */
    Returned<void> cancel() { return detail::finish_call(cylfuse_fitter_cancel(handle())); }

    /** Replaces the options. */
    Returned<void> set_options(const cylfuse_options &options)
    {
        return finish(cylfuse_fitter_set_options(begin(), &options));
    }
    /** The options. */
    Returned<Options> options() const
    {
        Options options;
        const cylfuse_status status = cylfuse_fitter_get_options(begin(), &options);
        return finish(status, options);
    }
    /** Selects a view for the calls that set or push something; the number of views adds one. */
    Returned<void> select_view(std::size_t index) { return finish(cylfuse_fitter_select_view(begin(), index)); }
    /** How many views there are, at least 1. */
    Returned<std::size_t> view_count() const
    {
        std::size_t count = 0;
        const cylfuse_status status = cylfuse_fitter_view_count(begin(), &count);
        return finish(status, count);
    }
    /** Sets the pose of the selected view: from its camera frame to the reference frame. */
    Returned<void> set_pose(const RigidMotion &pose)
    {
        return finish(cylfuse_fitter_set_pose(begin(), pose.rotation.data(), pose.translation.data()));
    }
    /** Sets the colour camera of the selected view, which depth images, images and edges need. */
    Returned<void> set_intrinsics(const cylfuse_intrinsics &intrinsics)
    {
        return finish(cylfuse_fitter_set_intrinsics(begin(), &intrinsics));
    }
    /** The colour camera of the selected view, which was set or came with a frame; Status::BadState where it has none. */
    Returned<Intrinsics> intrinsics() const
    {
        Intrinsics intrinsics;
        const cylfuse_status status = cylfuse_fitter_get_intrinsics(begin(), &intrinsics);
        return finish(status, intrinsics);
    }
    /** Gives the depth of the selected view a camera of its own; `to_colour` leads from it to the colour camera. */
    Returned<void> set_depth_camera(const cylfuse_intrinsics &intrinsics, const RigidMotion &to_colour)
    {
        return finish(cylfuse_fitter_set_depth_camera(begin(), &intrinsics, to_colour.rotation.data(),
                                                      to_colour.translation.data()));
    }
    /** Takes the depth camera of the selected view away. */
    Returned<void> clear_depth_camera()
    {
        return finish(cylfuse_fitter_set_depth_camera(begin(), nullptr, nullptr, nullptr));
    }
    /** Sets a model to start from; without one takes it away. */
    Returned<void> set_start_model(Optional<Cylinder> model)
    {
        return finish(cylfuse_fitter_set_start_model(begin(), model.get()));
    }
    /**
     * Sets the progress callback; an empty one takes it away. While a call is running, in another thread or around this
     * one in a callback, it fails with Status::Busy and the earlier callback stays.
     */
    Returned<void> set_progress(ProgressCallback callback)
    {
        std::unique_ptr<ProgressCallback> made;
        if (callback) {
            made.reset(new ProgressCallback(std::move(callback)));
        }
        const cylfuse_progress_fn function = made ? detail::on_progress<ProgressCallback, cylfuse_progress> : nullptr;
        const cylfuse_status status = cylfuse_fitter_set_progress(begin(), function, made.get());
        if (status == CYLFUSE_STATUS_OK) {
            handle_.get_deleter().progress = std::move(made); // The earlier one goes after the library knows the new one.
        }
        return finish(status);
    }
    /** Sets the log callback for lines up to a level; an empty one takes it away. When busy as set_progress(). */
    Returned<void> set_log(LogLevel max_level, LogCallback callback)
    {
        std::unique_ptr<LogCallback> made;
        if (callback) {
            made.reset(new LogCallback(std::move(callback)));
        }
        const cylfuse_log_fn function = made ? detail::on_log : nullptr;
        const cylfuse_status status =
            cylfuse_fitter_set_log(begin(), static_cast<cylfuse_log_level>(max_level), function, made.get());
        if (status == CYLFUSE_STATUS_OK) {
            handle_.get_deleter().log = std::move(made);
        }
        return finish(status);
    }

    /** Adds points to the selected view; `mask` selects pixels of an organised cloud. */
    Returned<void> push_points(const PointsView &points, Optional<MaskView> mask = {})
    {
        return finish(cylfuse_fitter_push_points(begin(), &points, mask.get()));
    }
    /** The same of points that vanish after the call: they are copied. */
    template <class Container, class = internal::IfTemporary<PointsView, Container>>
    Returned<void> push_points(Container &&points, Optional<MaskView> mask = {})
    {
        return push_points(PointsView(points), mask);
    }
    /** Adds the points of a depth image of the selected view; `mask` is in the pixels of the colour image. */
    Returned<void> push_depth(const DepthView &depth, Optional<MaskView> mask = {})
    {
        return finish(cylfuse_fitter_push_depth(begin(), &depth, mask.get()));
    }
    /** Adds edge segments to the selected view: pieces of the two limb lines in the (distorted) image. */
    Returned<void> push_edges(const SegmentsView &segments)
    {
        return finish(cylfuse_fitter_push_edges(begin(), &segments));
    }
    /** The same of segments that vanish after the call: they are copied. */
    template <class Container, class = internal::IfTemporary<SegmentsView, Container>>
    Returned<void> push_edges(Container &&segments)
    {
        return push_edges(SegmentsView(segments));
    }
    /** Takes the image of the selected view, grey or in colour, in which limbs and ends are located. */
    Returned<void> push_image(const ImageView &image) { return finish(cylfuse_fitter_push_image(begin(), &image)); }
    /** Lets the selected view take cameras, pose and images from a frame, and the points of its depth inside a mask. */
    Returned<void> use_frame(const Frame &frame, Optional<MaskView> mask = {})
    {
        return finish(cylfuse_fitter_use_frame(begin(), frame.handle(), mask.get()));
    }
    /** What was pushed into the selected view, and what was left out by reason. */
    Returned<Counts> counts() const
    {
        Counts counts;
        const cylfuse_status status = cylfuse_fitter_counts(begin(), &counts);
        return finish(status, counts);
    }

    /** Estimates the cylinder from everything that was pushed into all views. */
    Returned<CylinderFit> fit()
    {
        CylinderFit fit;
        const cylfuse_status status = cylfuse_fitter_fit(begin(), &fit.result, &fit.cylinder);
        return finish(status, fit);
    }
    /** What a fit would report for a given model, without iterating. */
    Returned<CylinderFit> evaluate(const Cylinder &model) const
    {
        CylinderFit fit;
        const cylfuse_status status = cylfuse_fitter_evaluate(begin(), &model, &fit.result, &fit.cylinder);
        return finish(status, fit);
    }
    /** The outcome of the last fit that succeeded. */
    Returned<CylinderFit> last_fit() const
    {
        CylinderFit fit;
        cylfuse_status status = cylfuse_fitter_get_result(begin(), &fit.result);
        if (status == CYLFUSE_STATUS_OK) {
            status = cylfuse_fitter_get_cylinder(handle(), &fit.cylinder);
        }
        return finish(status, fit);
    }
    /** What the data determine at a model. */
    Returned<Diagnosis> diagnose(Optional<Cylinder> model = {}) const
    {
        Diagnosis diagnosis;
        const cylfuse_status status = cylfuse_fitter_diagnose(begin(), model.get(), &diagnosis);
        return finish(status, diagnosis);
    }

    /** Residuals of the selected view. */
    Returned<std::vector<double>> residuals(ResidualKind kind, Optional<Cylinder> model = {}) const
    {
        return list<double>([&](double *out, std::size_t capacity, std::size_t *count) {
            return cylfuse_fitter_residuals(handle(), model.get(), static_cast<cylfuse_residual_kind>(kind), out,
                                            capacity, count);
        });
    }
    /** Writes residuals of the selected view, and gives their number; Error::needed() when there is not room enough. */
    Returned<std::size_t> residuals(ResidualKind kind, Span<double> out, Optional<Cylinder> model = {}) const
    {
        return write(out, [&](double *values, std::size_t capacity, std::size_t *count) {
            return cylfuse_fitter_residuals(handle(), model.get(), static_cast<cylfuse_residual_kind>(kind), values,
                                            capacity, count);
        });
    }
    /** How much each point of the selected view counts at the cylinder of the last fit, in the order of residuals(). */
    Returned<PointWeights> point_weights() const
    {
        PointWeights all;
        std::size_t count = 0;
        detail::forget();
        cylfuse_status status = CYLFUSE_STATUS_BUFFER_TOO_SMALL;
        for (bool sized = false; status == CYLFUSE_STATUS_BUFFER_TOO_SMALL; sized = true) {
            all.weights.resize(count);
            all.inliers.resize(count);
            status = cylfuse_fitter_point_weights(handle(), sized ? all.weights.data() : nullptr,
                                                  sized ? all.inliers.data() : nullptr, count, &count);
        }
        return finish(status, std::move(all));
    }
    /**
     * Writes what point_weights() gives, and gives the number; Error::needed() when there is not room enough. An empty buffer
     * is for what is not wanted: `point_weights({}, inliers)`.
     */
    Returned<std::size_t> point_weights(Span<double> weights, Span<std::uint8_t> inliers = {}) const
    {
        double *const to_weights = weights.size() == 0 ? nullptr : weights.data();
        std::uint8_t *const to_inliers = inliers.size() == 0 ? nullptr : inliers.data();
        const bool both = to_weights != nullptr && to_inliers != nullptr;
        const std::size_t capacity =
            both ? std::min(weights.size(), inliers.size()) : std::max(weights.size(), inliers.size());
        std::size_t count = 0;
        const cylfuse_status status = cylfuse_fitter_point_weights(begin(), to_weights, to_inliers, capacity, &count);
        return finish(status, count, count);
    }
    /** What each point of the selected view belongs to, in the order of residuals(). */
    Returned<std::vector<Part>> point_parts(Optional<Cylinder> model = {}) const
    {
        return list<Part>([&](Part *out, std::size_t capacity, std::size_t *count) {
            return cylfuse_fitter_point_parts(handle(), model.get(), reinterpret_cast<cylfuse_part *>(out), capacity,
                                              count);
        });
    }
    /** Writes what point_parts() gives, and gives the number; Error::needed() when there is not room enough. */
    Returned<std::size_t> point_parts(Span<Part> out, Optional<Cylinder> model = {}) const
    {
        return write(out, [&](Part *parts, std::size_t capacity, std::size_t *count) {
            return cylfuse_fitter_point_parts(handle(), model.get(), reinterpret_cast<cylfuse_part *>(parts), capacity,
                                              count);
        });
    }
    /** The two limbs of the last fit in each view: where they were located in the image, or why they were not. */
    Returned<std::vector<Limb>> limbs() const
    {
        return list<Limb>([&](Limb *out, std::size_t capacity, std::size_t *count) {
            return cylfuse_fitter_limbs(handle(), out, sizeof(Limb), capacity, count);
        });
    }
    /** Writes what limbs() gives, and gives the number; Error::needed() when there is not room enough. */
    Returned<std::size_t> limbs(Span<Limb> out) const
    {
        return write(out, [&](Limb *limbs, std::size_t capacity, std::size_t *count) {
            return cylfuse_fitter_limbs(handle(), limbs, sizeof(Limb), capacity, count);
        });
    }
    /** What the last fit saw of the limbs in the image of the selected view. */
    Returned<std::vector<LimbSample>> limb_samples() const
    {
        return list<LimbSample>([&](LimbSample *out, std::size_t capacity, std::size_t *count) {
            return cylfuse_fitter_limb_samples(handle(), out, sizeof(LimbSample), capacity, count);
        });
    }
    /** Writes what limb_samples() gives, and gives the number; Error::needed() when there is not room enough. */
    Returned<std::size_t> limb_samples(Span<LimbSample> out) const
    {
        return write(out, [&](LimbSample *samples, std::size_t capacity, std::size_t *count) {
            return cylfuse_fitter_limb_samples(handle(), samples, sizeof(LimbSample), capacity, count);
        });
    }
    /** The samples on the arcs of both ends that extent() finds in the images, view after view. */
    Returned<std::vector<EndSample>> end_samples(Optional<Cylinder> model = {}, Optional<MaskView> mask = {}) const
    {
        return list<EndSample>([&](EndSample *out, std::size_t capacity, std::size_t *count) {
            return cylfuse_fitter_end_samples(handle(), model.get(), mask.get(), out, sizeof(EndSample), capacity,
                                              count);
        });
    }
    /** Writes what end_samples() gives, and gives the number; Error::needed() when there is not room enough. */
    Returned<std::size_t> end_samples(Span<EndSample> out, Optional<Cylinder> model = {},
                                      Optional<MaskView> mask = {}) const
    {
        return write(out, [&](EndSample *samples, std::size_t capacity, std::size_t *count) {
            return cylfuse_fitter_end_samples(handle(), model.get(), mask.get(), samples, sizeof(EndSample), capacity,
                                              count);
        });
    }

    /** How many points a completion of the selected view may give at most. */
    Returned<std::size_t> complete_bound(Layout layout, Optional<MaskView> mask = {}) const
    {
        std::size_t bound = 0;
        const cylfuse_status status =
            cylfuse_fitter_complete_bound(begin(), mask.get(), static_cast<cylfuse_layout>(layout), &bound);
        return finish(status, bound);
    }
    /** Completes the cloud of the selected view over a mask, in the reference frame. */
    Returned<Completion> complete(const PointsOut &out, Layout layout, Optional<Cylinder> model = {},
                                  Optional<MaskView> mask = {}) const
    {
        Completion completion;
        const cylfuse_status status = cylfuse_fitter_complete(
            begin(), model.get(), mask.get(), static_cast<cylfuse_layout>(layout), &out, &completion);
        return finish(status, completion, static_cast<std::size_t>(completion.count));
    }
    /** Completes the cloud into a vector, which gets the size of what there is; its points stay where that fails. */
    template <class T, class Allocator>
    Returned<Completion> complete(std::vector<std::array<T, 3>, Allocator> &points, Optional<Cylinder> model = {},
                                  Optional<MaskView> mask = {}) const
    {
        return complete_into(points, CYLFUSE_LAYOUT_PACKED, model, mask);
    }
    /**
     * The same in the order of the image: a point for each pixel, row by row, NaN where there is none. The size of the image
     * is that of intrinsics().
     */
    template <class T, class Allocator>
    Returned<Completion> complete_organised(std::vector<std::array<T, 3>, Allocator> &points,
                                            Optional<Cylinder> model = {}, Optional<MaskView> mask = {}) const
    {
        return complete_into(points, CYLFUSE_LAYOUT_ORGANISED, model, mask);
    }
    /** Completes the depth image of the selected view, on the pixels of its colour image. */
    Returned<Completion> complete_depth(const DepthOut &out, Optional<Cylinder> model = {},
                                        Optional<MaskView> mask = {}) const
    {
        Completion completion;
        const cylfuse_status status =
            cylfuse_fitter_complete_depth(begin(), model.get(), mask.get(), &out, &completion);
        return finish(status, completion);
    }
    /** The visible piece of the cylinder. */
    Returned<Extent> extent(Optional<Cylinder> model = {}, Optional<MaskView> mask = {}) const
    {
        Extent extent;
        const cylfuse_status status = cylfuse_fitter_extent(begin(), model.get(), mask.get(), &extent);
        return finish(status, extent);
    }
    /**
     * Selects, of straight edges that a line detector found, those on the two limbs of a rough cylinder beside the
     * points that were pushed: writes 1 or 2 for the limb that a segment lies on, 0 for none; Error::needed() when there
     * is not room enough. `reach` in pixels, 0 = 15 % of the distance of the limbs, at least 4.
     */
    Returned<void> select_edges(const SegmentsView &segments, Span<std::uint8_t> out, double reach = 0.0,
                                Optional<Cylinder> model = {}) const
    {
        const cylfuse_status status =
            cylfuse_fitter_select_edges(begin(), model.get(), &segments, reach, out.data(), out.size());
        return finish_sized(status, segments.count);
    }
    /** The same of segments that vanish after the call. */
    template <class Container, class = internal::IfTemporary<SegmentsView, Container>>
    Returned<void> select_edges(Container &&segments, Span<std::uint8_t> out, double reach = 0.0,
                                Optional<Cylinder> model = {}) const
    {
        return select_edges(SegmentsView(segments), out, reach, model);
    }

private:
    // Completes into a vector: as many points as there are when packed, one a pixel when organised.
    template <class T, class Allocator>
    Returned<Completion> complete_into(std::vector<std::array<T, 3>, Allocator> &points, cylfuse_layout layout,
                                       Optional<Cylinder> model, Optional<MaskView> mask) const
    {
        std::size_t bound = 0;
        cylfuse_status status = cylfuse_fitter_complete_bound(begin(), mask.get(), layout, &bound);
        Completion completion;
        if (status == CYLFUSE_STATUS_OK) {
            const std::size_t before = points.size();
            points.resize(std::max(before, bound)); // A call that fails writes nothing: those before are still there.
            const PointsOut out(reinterpret_cast<T *>(points.data()), bound);
            status = cylfuse_fitter_complete(handle(), model.get(), mask.get(), layout, &out, &completion);
            const std::size_t made =
                layout == CYLFUSE_LAYOUT_ORGANISED ? bound : static_cast<std::size_t>(completion.count);
            points.resize(status == CYLFUSE_STATUS_OK ? made : before);
        }
        return finish(status, completion);
    }
};

} // inline namespace
} // namespace cylfuse

#include <cylfuse/batch.hpp>
#include <cylfuse/cylinder.hpp>
#include <cylfuse/detector.hpp>

#endif

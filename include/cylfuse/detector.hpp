/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file detector.hpp
 * All cylinders of a frame or a cloud. Include cylfuse.hpp, which says how it is meant.
 */

#ifndef CYLFUSE_DETECTOR_HPP
#define CYLFUSE_DETECTOR_HPP

#include <cylfuse/cylfuse.hpp>

namespace cylfuse {
#ifdef CYLFUSE_NO_EXCEPTIONS
inline namespace without_exceptions {
#else
inline namespace with_exceptions {
#endif

/**
 * Finds all cylinders of a frame or a cloud and fits each. Set the options, detect, read what was found: by index from
 * 0, the highest score first. The next call of detect() or detect_points() that succeeds takes its place.
 *
 * Moves but does not copy. A detector that was moved from holds nothing: all its calls fail with Status::NullPointer.
 * The callback may throw: the exception leaves the method that it was called from.
 */
class Detector : detail::Handle<cylfuse_detector, detail::DestroyDetector, cylfuse_detector_last_error> {
public:
#ifndef CYLFUSE_NO_EXCEPTIONS
    /** A detector with default options. */
    Detector() : Detector(create()) {}
#endif
    /** A detector with default options. */
    static Returned<Detector> create()
    {
        cylfuse_detector *made = nullptr;
        const cylfuse_status status = cylfuse_detector_create(CYLFUSE_ABI_VERSION, &made);
        return detail::finish_call(status, Detector(made));
    }
    /** Takes over a detector of the C interface, which has no callback; NULL for one that holds nothing. */
    explicit Detector(cylfuse_detector *detector) noexcept : Handle(detector) {}

    /** The detector for functions of the C interface; stays owned. */
    cylfuse_detector *handle() const noexcept { return handle_.get(); }
    /** The text of the failure of the last call, as Fitter::last_error(). */
    const char *last_error() const noexcept { return cylfuse_detector_last_error(handle()); }
    /**
     * Gives the detector away, without its callback: cylfuse_detector_destroy() is up to the caller then. NULL while a
     * call on it is running; it stays here then.
     */
    cylfuse_detector *release() noexcept
    {
        detail::DestroyDetector &callbacks = handle_.get_deleter();
        if (callbacks.progress && cylfuse_detector_set_progress(handle(), nullptr, nullptr) == CYLFUSE_STATUS_BUSY) {
            return nullptr;
        }
        callbacks.progress.reset();
        return handle_.release();
    }
    /** Asks the calls that are running to stop; from any thread, and from the callback. */
    Returned<void> cancel() { return detail::finish_call(cylfuse_detector_cancel(handle())); }

    /** Replaces the options. */
    Returned<void> set_options(const cylfuse_detector_options &options)
    {
        return finish(cylfuse_detector_set_options(begin(), &options));
    }
    /** The options. */
    Returned<DetectorOptions> options() const
    {
        DetectorOptions options;
        const cylfuse_status status = cylfuse_detector_get_options(begin(), &options);
        return finish(status, options);
    }
    /** Replaces the options of the fits; limits, threads and start stay at their defaults there. */
    Returned<void> set_fit_options(const cylfuse_options &options)
    {
        return finish(cylfuse_detector_set_fit_options(begin(), &options));
    }
    /** The options of the fits. */
    Returned<Options> fit_options() const
    {
        Options options;
        const cylfuse_status status = cylfuse_detector_get_fit_options(begin(), &options);
        return finish(status, options);
    }
    /** Sets the progress callback; an empty one takes it away. When busy as Fitter::set_progress(). */
    Returned<void> set_progress(DetectionCallback callback)
    {
        std::unique_ptr<DetectionCallback> made;
        if (callback) {
            made.reset(new DetectionCallback(std::move(callback)));
        }
        const cylfuse_detection_progress_fn function =
            made ? detail::on_progress<DetectionCallback, cylfuse_detection_progress> : nullptr;
        const cylfuse_status status = cylfuse_detector_set_progress(begin(), function, made.get());
        if (status == CYLFUSE_STATUS_OK) {
            handle_.get_deleter().progress = std::move(made);
        }
        return finish(status);
    }

    /** Finds and fits all cylinders of a frame. */
    Returned<void> detect(const Frame &frame) { return finish(cylfuse_detector_detect(begin(), frame.handle())); }
    /** Finds and fits all cylinders of a cloud, organised or not. */
    Returned<void> detect_points(const PointsView &points)
    {
        return finish(cylfuse_detector_detect_points(begin(), &points));
    }

    /** The same of points that vanish after the call: they are copied. */
    template <class Container, class = internal::IfTemporary<PointsView, Container>>
    Returned<void> detect_points(Container &&points)
    {
        return detect_points(PointsView(points));
    }

    /** How many cylinders were found. */
    Returned<std::size_t> count() const
    {
        std::size_t count = 0;
        const cylfuse_status status = cylfuse_detector_count(begin(), &count);
        return finish(status, count);
    }
    /**
     * Whether the scene was looked at as a whole. The work of a search with its fits is bounded: of a scene with more in
     * it than that, cylinders may be missing.
     */
    Returned<bool> is_complete() const
    {
        std::int32_t complete = 0;
        const cylfuse_status status = cylfuse_detector_is_complete(begin(), &complete);
        return finish(status, complete != 0);
    }
    /**
     * The columns (to the right) and rows (down) by which the depth of the frame was moved to where the image shows the
     * same bodies; zeros where it was not. Each result then has `ResultFlags::DepthShifted`; labels and indices are those
     * of the depth as it was given.
     */
    Returned<std::array<std::int32_t, 2>> depth_moved() const
    {
        std::array<std::int32_t, 2> moved{};
        const cylfuse_status status = cylfuse_detector_depth_moved(begin(), &moved[0], &moved[1]);
        return finish(status, moved);
    }
    /** The cylinders by falling score. */
    Returned<std::vector<Detection>> detections() const
    {
        return list<Detection>([&](Detection *out, std::size_t capacity, std::size_t *count) {
            return cylfuse_detector_detections(handle(), out, sizeof(Detection), capacity, count);
        });
    }
    /** Writes what detections() gives, and gives the number; Error::needed() when there is not room enough. */
    Returned<std::size_t> detections(Span<Detection> out) const
    {
        return write(out, [&](Detection *found, std::size_t capacity, std::size_t *count) {
            return cylfuse_detector_detections(handle(), found, sizeof(Detection), capacity, count);
        });
    }
    /** The outcome of the fit of a cylinder. */
    Returned<CylinderFit> fit(std::size_t index) const
    {
        CylinderFit fit;
        cylfuse_status status = cylfuse_detector_get_result(begin(), index, &fit.result);
        if (status == CYLFUSE_STATUS_OK) {
            status = cylfuse_detector_get_cylinder(handle(), index, &fit.cylinder);
        }
        return finish(status, fit);
    }
    /** The visible piece of a cylinder; that of a cylinder of a cloud ends with its points. */
    Returned<Extent> extent(std::size_t index) const
    {
        Extent extent;
        const cylfuse_status status = cylfuse_detector_get_extent(begin(), index, &extent);
        return finish(status, extent);
    }
    /** For each pixel or point, row by row, the number of its cylinder: its index + 1, 0 for none. */
    Returned<std::vector<std::uint16_t>> labels() const
    {
        return list<std::uint16_t>([&](std::uint16_t *out, std::size_t capacity, std::size_t *count) {
            return cylfuse_detector_labels(handle(), out, capacity, count);
        });
    }
    /** Writes what labels() gives, and gives the number; Error::needed() when there is not room enough. */
    Returned<std::size_t> labels(Span<std::uint16_t> out) const
    {
        return write(out, [&](std::uint16_t *labels, std::size_t capacity, std::size_t *count) {
            return cylfuse_detector_labels(handle(), labels, capacity, count);
        });
    }
    /** The pixels or points of a cylinder, counted from 0 row by row. */
    Returned<std::vector<std::uint32_t>> indices(std::size_t index) const
    {
        return list<std::uint32_t>([&](std::uint32_t *out, std::size_t capacity, std::size_t *count) {
            return cylfuse_detector_indices(handle(), index, out, capacity, count);
        });
    }
    /** Writes what indices() gives, and gives the number; Error::needed() when there is not room enough. */
    Returned<std::size_t> indices(std::size_t index, Span<std::uint32_t> out) const
    {
        return write(out, [&](std::uint32_t *indices, std::size_t capacity, std::size_t *count) {
            return cylfuse_detector_indices(handle(), index, indices, capacity, count);
        });
    }
    /** A fitter of a cylinder as its fit left it: for residuals, completion, limbs, or another fit. */
    Returned<Fitter> make_fitter(std::size_t index) const
    {
        cylfuse_fitter *made = nullptr;
        const cylfuse_status status = cylfuse_detector_make_fitter(begin(), index, &made);
        return finish(status, Fitter(made));
    }
};

} // inline namespace
} // namespace cylfuse

#endif

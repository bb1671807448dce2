/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file handle.hpp
 * What Fitter and Detector have in common. Include cylfuse.hpp.
 */

#ifndef CYLFUSE_HANDLE_HPP
#define CYLFUSE_HANDLE_HPP

#include <cylfuse/callbacks.hpp>
#include <cylfuse/error.hpp>
#include <cylfuse/views.hpp>

#include <memory>

namespace cylfuse {

/** @cond internal */
#ifdef CYLFUSE_NO_EXCEPTIONS
inline namespace without_exceptions {
#else
inline namespace with_exceptions {
#endif
namespace detail {

// A fitter whose call is still running stays, and so do the callbacks that it knows.
struct DestroyFitter {
    std::unique_ptr<ProgressCallback> progress;
    std::unique_ptr<LogCallback> log;

    void operator()(cylfuse_fitter *fitter) noexcept
    {
        if (cylfuse_fitter_destroy(fitter) != CYLFUSE_STATUS_OK) {
            static_cast<void>(progress.release());
            static_cast<void>(log.release());
        }
    }
};

// A detector whose call is still running stays, and so does the callback that it knows.
struct DestroyDetector {
    std::unique_ptr<DetectionCallback> progress;

    void operator()(cylfuse_detector *detector) noexcept
    {
        if (cylfuse_detector_destroy(detector) != CYLFUSE_STATUS_OK) {
            static_cast<void>(progress.release());
        }
    }
};

// Owns an object of the C interface, and makes errors of the statuses of its calls. `Destroy` keeps its callbacks, too:
// the library has their addresses, so they stay where they are when the object moves.
template <class Object, class Destroy, const char *(*last_error_of)(const Object *)>
class Handle {
protected:
    explicit Handle(Object *object) noexcept : handle_(object) {}

    // The object for a call that ends with one of the functions below.
    Object *begin() const noexcept
    {
        forget();
        return handle_.get();
    }
    // What a function of the C interface lists, however much it is.
    template <class T, class Call>
    Returned<std::vector<T>> list(Call call) const
    {
        std::vector<T> all;
        forget();
        const cylfuse_status status = internal::list(all, call);
        return finish(status, std::move(all));
    }
    // The same into a buffer of the caller; how much it is.
    template <class T, class Call>
    Returned<std::size_t> write(Span<T> out, Call call) const
    {
        std::size_t count = 0;
        forget();
        const cylfuse_status status = call(out.data(), out.size(), &count);
        return finish(status, count, count);
    }

    Returned<void> finish(cylfuse_status status) const { return finish_sized(status, 0); }
    // Ends a call that writes into a buffer that must hold that many elements.
    Returned<void> finish_sized(cylfuse_status status, std::size_t needed) const
    {
        rethrow();
        const bool too_small = status == CYLFUSE_STATUS_BUFFER_TOO_SMALL;
        return detail::finish(Status(status), message(status), too_small ? needed : 0);
    }
    template <class T>
    Returned<T> finish(cylfuse_status status, T value, std::size_t needed = 0) const
    {
        rethrow();
        const bool too_small = status == CYLFUSE_STATUS_BUFFER_TOO_SMALL;
        return detail::finish(Status(status), std::move(value), message(status), too_small ? needed : 0);
    }

    std::unique_ptr<Object, Destroy> handle_;

private:
    const char *message(cylfuse_status status) const noexcept
    {
        return status == CYLFUSE_STATUS_OK ? "" : last_error_of(handle_.get());
    }
};

} // namespace detail
} // inline namespace
/** @endcond */

} // namespace cylfuse

#endif

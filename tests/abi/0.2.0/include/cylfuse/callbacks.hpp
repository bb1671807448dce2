/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file callbacks.hpp
 * Functions of the caller that fitters and detectors call. Include cylfuse.hpp, which says how they are meant.
 */

#ifndef CYLFUSE_CALLBACKS_HPP
#define CYLFUSE_CALLBACKS_HPP

#include <cylfuse/types.hpp>

#include <exception>
#include <functional>
#include <utility>

namespace cylfuse {

/** Called before every iteration of a fit; false stops it with Status::Cancelled. */
using ProgressCallback = std::function<bool(const Progress &)>;

/** Hears how far a detector is; false stops it with Status::Cancelled. */
using DetectionCallback = std::function<bool(const DetectionProgress &)>;

/** Takes a log line, valid until it returns; from several threads at once when several make calls on a const fitter. */
using LogCallback = std::function<void(LogLevel, const char *)>;

/** @cond internal */
#ifdef CYLFUSE_NO_EXCEPTIONS
inline namespace without_exceptions {
namespace detail {

template <class Callback, class State>
std::int32_t on_progress(const State *progress, void *user_data) noexcept
{
    return (*static_cast<Callback *>(user_data))(*progress) ? 0 : 1;
}

inline void on_log(cylfuse_log_level level, const char *message, void *user_data) noexcept
{
    (*static_cast<LogCallback *>(user_data))(LogLevel(level), message);
}

inline void rethrow() noexcept {}

} // namespace detail
} // inline namespace
#else
inline namespace with_exceptions {
namespace detail {

// No exception may run through the library: it waits here until the call is back. Callbacks are called on the thread
// that made the call.
inline std::exception_ptr &thrown() noexcept
{
    static thread_local std::exception_ptr exception;
    return exception;
}

template <class Callback, class State>
std::int32_t on_progress(const State *progress, void *user_data) noexcept
{
    try {
        return (*static_cast<Callback *>(user_data))(*progress) ? 0 : 1;
    } catch (...) {
        thrown() = std::current_exception();
        return 1;
    }
}

inline void on_log(cylfuse_log_level level, const char *message, void *user_data) noexcept
{
    try {
        (*static_cast<LogCallback *>(user_data))(LogLevel(level), message);
    } catch (...) {
        thrown() = std::current_exception();
    }
}

inline void rethrow()
{
    if (thrown()) {
        std::rethrow_exception(std::exchange(thrown(), nullptr));
    }
}

} // namespace detail
} // inline namespace
#endif
/** @endcond */

} // namespace cylfuse

#endif

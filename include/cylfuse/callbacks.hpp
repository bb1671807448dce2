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

/** Called before every iteration of a fit, and between its other steps; false stops it with Status::Cancelled. */
using ProgressCallback = std::function<bool(const Progress &)>;

/** Is called with the progress of a detector; false stops it with Status::Cancelled. */
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

inline void forget() noexcept {}
inline void rethrow() noexcept {}

} // namespace detail
} // inline namespace
#else
inline namespace with_exceptions {
namespace detail {

// No exception may run through the library: it waits here until the call is back. Callbacks are called on the thread
// that made the call. A call that was made of the C interface leaves its exception here: every call of this wrapper begins
// with forget().
inline std::exception_ptr &thrown() noexcept
{
    static thread_local std::exception_ptr exception;
    return exception;
}

// Runs a callback, and keeps what it throws; whether it returned true. Calls that it makes itself are other calls: they
// neither see nor lose what an earlier callback of this one threw.
template <class Run>
bool keep_thrown(Run run) noexcept
{
    std::exception_ptr earlier = std::exchange(thrown(), nullptr);
    bool go_on = false;
    try {
        go_on = run();
    } catch (...) {
        earlier = std::current_exception();
    }
    thrown() = std::move(earlier);
    return go_on;
}

template <class Callback, class State>
std::int32_t on_progress(const State *progress, void *user_data) noexcept
{
    return keep_thrown([&] { return (*static_cast<Callback *>(user_data))(*progress); }) ? 0 : 1;
}

inline void on_log(cylfuse_log_level level, const char *message, void *user_data) noexcept
{
    keep_thrown([&] {
        (*static_cast<LogCallback *>(user_data))(LogLevel(level), message);
        return true;
    });
}

// What no call is waiting for.
inline void forget() noexcept { thrown() = nullptr; }

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

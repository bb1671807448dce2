/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file error.hpp
 * What calls throw, or return where nothing throws. Include cylfuse.hpp, which says how they are meant.
 */

#ifndef CYLFUSE_ERROR_HPP
#define CYLFUSE_ERROR_HPP

#include <cylfuse/enums.hpp>

#include <cstddef>
#include <cstring>
#include <exception>
#include <utility>

static_assert(CYLFUSE_ABI_VERSION == 1, "cylfuse.hpp and cylfuse.h are of different versions");

/** Measures a cylinder from RGB-D views. */
namespace cylfuse {

// Programs may mix both modes: what is compiled in one must not be taken for the other by the linker.
#ifdef CYLFUSE_NO_EXCEPTIONS
inline namespace without_exceptions {
#else
inline namespace with_exceptions {
#endif

/** A failed call: the status and what was wrong, the value, the limit and the remedy. Allocates nothing. */
class Error : public std::exception {
public:
    /** A failure with its text, which is cut at 511 bytes; without one that of the status is taken. */
    explicit Error(Status status, const char *message = "", std::size_t needed = 0) noexcept
        : status_(status), needed_(needed)
    {
        if (message == nullptr || *message == '\0') {
            message = cylfuse_status_string(static_cast<cylfuse_status>(status));
        }
        const std::size_t length = std::strlen(message);
        const std::size_t kept = length < sizeof message_ ? length : sizeof message_ - 1;
        std::memcpy(message_, message, kept);
        message_[kept] = '\0';
    }

    /** What kind of failure it is. */
    Status status() const noexcept { return status_; }

    /** How many elements a buffer must hold, where the status is Status::BufferTooSmall; else 0. */
    std::size_t needed() const noexcept { return needed_; }

    /** The text. */
    const char *what() const noexcept override { return message_; }

private:
    Status status_;
    std::size_t needed_;
    char message_[512];
};

#ifdef CYLFUSE_NO_EXCEPTIONS

/** @cond internal */
// A failure that nobody looks at is lost, so the compiler warns. Before C++17 only some compilers know the attribute, and
// clang by another name.
#if __cplusplus >= 201703L || (defined(_MSVC_LANG) && _MSVC_LANG >= 201703L)
#define CYLFUSE_NODISCARD [[nodiscard]]
#elif defined(__clang__)
#define CYLFUSE_NODISCARD [[clang::warn_unused_result]]
#elif defined(__GNUC__) && __GNUC__ >= 7
#define CYLFUSE_NODISCARD [[nodiscard]]
#else
#define CYLFUSE_NODISCARD
#endif
/** @endcond */

/** What a call gives without exceptions: a value or an error, which must be looked at. */
template <class T>
class CYLFUSE_NODISCARD Outcome {
public:
    /** A value, which means something when the status of the error is Status::Ok. */
    Outcome(T value, const Error &error) : value_(std::move(value)), error_(error) {}
    /** Whether there is a value. */
    explicit operator bool() const noexcept { return error_.status() == Status::Ok; }
    /** Status::Ok when there is a value. */
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

/** What a call without a value gives without exceptions, which must be looked at. */
template <>
class CYLFUSE_NODISCARD Outcome<void> {
public:
    /** A failure, unless the status of the error is Status::Ok. */
    explicit Outcome(const Error &error) : error_(error) {}
    /** Whether the call did what it was asked to. */
    explicit operator bool() const noexcept { return error_.status() == Status::Ok; }
    /** Status::Ok or why not. */
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

inline Outcome<void> finish(Status status, const char *message = "", std::size_t needed = 0)
{
    return Outcome<void>(Error(status, message, needed));
}

template <class T>
Outcome<T> finish(Status status, T value, const char *message = "", std::size_t needed = 0)
{
    return Outcome<T>(std::move(value), Error(status, message, needed));
}

#else

inline void finish(Status status, const char *message = "", std::size_t needed = 0)
{
    if (status != Status::Ok) {
        throw Error(status, message, needed);
    }
}

template <class T>
T finish(Status status, T value, const char *message = "", std::size_t needed = 0)
{
    if (status != Status::Ok) {
        throw Error(status, message, needed);
    }
    return value;
}

#endif

// Ends a call on nothing that keeps a text: that of this thread is taken.
inline Returned<void> finish_call(cylfuse_status status, std::size_t needed = 0)
{
    const bool too_small = status == CYLFUSE_STATUS_BUFFER_TOO_SMALL;
    return finish(Status(status), status == CYLFUSE_STATUS_OK ? "" : cylfuse_fitter_last_error(nullptr),
                  too_small ? needed : 0);
}

template <class T>
Returned<T> finish_call(cylfuse_status status, T value)
{
    return finish(Status(status), std::move(value),
                  status == CYLFUSE_STATUS_OK ? "" : cylfuse_fitter_last_error(nullptr));
}

} // namespace detail
/** @endcond */

} // inline namespace
} // namespace cylfuse

#endif

/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file batch.hpp
 * Many fits at once. Include cylfuse.hpp, which says how it is meant.
 */

#ifndef CYLFUSE_BATCH_HPP
#define CYLFUSE_BATCH_HPP

#include <cylfuse/cylfuse.hpp>

namespace cylfuse {

/** Is called after each fit of fit_all() with the index of its fitter and its status; false stops the rest. */
using FitAllCallback = std::function<bool(std::size_t, Status)>;

#ifdef CYLFUSE_NO_EXCEPTIONS
inline namespace without_exceptions {
#else
inline namespace with_exceptions {
#endif

/** @cond internal */
namespace detail {

inline std::int32_t on_fit(std::size_t index, cylfuse_status status, void *user_data) noexcept
{
#ifndef CYLFUSE_NO_EXCEPTIONS
    return keep_thrown([&] { return (*static_cast<FitAllCallback *>(user_data))(index, Status(status)); }) ? 0 : 1;
#else
    return (*static_cast<FitAllCallback *>(user_data))(index, Status(status)) ? 0 : 1;
#endif
}

} // namespace detail
/** @endcond */

/**
 * Fits many fitters, several at once, each as Fitter::fit() does, and gives their statuses in order: of a fit that failed
 * its own, while the others go on. Fitter::last_fit() and all else that can be asked of a fit follow; why one failed says
 * Fitter::last_error(), but for one that was moved from: it has Status::NullPointer and no text.
 *
 * The callbacks of the fitters are not called. Where the callback stops the rest this is no failure, as the fits that ended
 * count: the statuses are returned, and Status::Cancelled is that of each fit that had not ended. What the callback throws
 * leaves this function.
 *
 * @param fitters a container of fitters, such as `std::vector<cylfuse::Fitter>`
 * @param threads how many fits run at the same time, 0 for as many as the machine has processors; the results have the
 *   same bits for any number
 * @param callback is called after each fit, on the thread of this call; may be empty
 */
template <class Fitters>
Returned<std::vector<Status>> fit_all(Fitters &fitters, std::uint32_t threads = 0, FitAllCallback callback = {})
{
    std::vector<cylfuse_fitter *> handles;
    for (Fitter &fitter : fitters) {
        handles.push_back(fitter.handle());
    }
    std::vector<cylfuse_status> statuses(handles.size());
    detail::forget();
    const cylfuse_status status = cylfuse_fit_all(handles.data(), handles.size(), threads,
                                                  callback ? detail::on_fit : nullptr, &callback, statuses.data());
    detail::rethrow();
    std::vector<Status> all;
    for (const cylfuse_status of_fit : statuses) {
        all.push_back(Status(of_fit));
    }
    return detail::finish_call(status == CYLFUSE_STATUS_CANCELLED ? CYLFUSE_STATUS_OK : status, std::move(all));
}

} // inline namespace
} // namespace cylfuse

#endif

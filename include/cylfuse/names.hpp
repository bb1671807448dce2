/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file names.hpp
 * The version of the library, and constants as text: to_string() gives the name, describe() the name and what it means.
 * Include cylfuse.hpp.
 */

#ifndef CYLFUSE_NAMES_HPP
#define CYLFUSE_NAMES_HPP

#include <cylfuse/enums.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace cylfuse {

/** The version of the loaded library, such as "0.2.0". */
inline const char *version_string() noexcept { return cylfuse_version_string(); }
/** The same as a number, major * 65536 + minor * 256 + patch; compare it with CYLFUSE_VERSION_NUMBER. */
inline std::uint32_t version_number() noexcept { return cylfuse_version_number(); }
/** How the loaded library was built, for reports of defects. */
inline const char *build_info() noexcept { return cylfuse_build_info(); }

/** The name of a status, a colon, and what it means in a few words; a text for unknown numbers too. */
inline const char *describe(Status status) noexcept
{
    return cylfuse_status_string(static_cast<cylfuse_status>(status));
}
/** The same for why an iteration ended. */
inline const char *describe(Termination termination) noexcept
{
    return cylfuse_termination_string(static_cast<cylfuse_termination>(termination));
}
/** The same for what an end is. */
inline const char *describe(EndState state) noexcept
{
    return cylfuse_end_state_string(static_cast<cylfuse_end_state>(state));
}
/** The same for what the position of an end was taken from. */
inline const char *describe(EndSource source) noexcept
{
    return cylfuse_end_source_string(static_cast<cylfuse_end_source>(source));
}
/** The same for whether a limb was located, or why not. */
inline const char *describe(LimbStatus status) noexcept
{
    return cylfuse_limb_status_string(static_cast<cylfuse_limb_status>(status));
}
/** The same for what a point belongs to. */
inline const char *describe(Part part) noexcept { return cylfuse_part_string(static_cast<cylfuse_part>(part)); }
/** The same for one warning; for several see warnings(). */
inline const char *describe(ResultFlags warning) noexcept
{
    return cylfuse_flag_string(static_cast<cylfuse_result_flags>(warning));
}

/** What describe() says of each warning that is set; empty for none. Result::warnings() gives those of a result. */
inline std::vector<std::string> warnings(ResultFlags flags)
{
    const auto bits = static_cast<cylfuse_result_flags>(flags);
    std::vector<std::string> all;
    for (int bit = 0; bit < 32; ++bit) {
        const cylfuse_result_flags flag = bits & (cylfuse_result_flags(1) << bit);
        if (flag != 0) {
            all.emplace_back(cylfuse_flag_string(flag));
        }
    }
    return all;
}

/** @cond internal */
namespace internal {

// What comes before the colon of a text.
inline std::string name(const std::string &text) { return text.substr(0, text.find(':')); }

} // namespace internal
/** @endcond */

/** The name of a status, such as "TOO_FEW_POINTS"; "unknown status" for unknown numbers. */
inline std::string to_string(Status status) { return internal::name(describe(status)); }
/** The name of why an iteration ended, such as "GRADIENT"; "unknown" for unknown numbers, as below. */
inline std::string to_string(Termination termination) { return internal::name(describe(termination)); }
/** The name of what an end is, such as "SEEN". */
inline std::string to_string(EndState state) { return internal::name(describe(state)); }
/** The name of what the position of an end was taken from, such as "IMAGE". */
inline std::string to_string(EndSource source) { return internal::name(describe(source)); }
/** The name of whether a limb was located, or why not, such as "NO_EDGE". */
inline std::string to_string(LimbStatus status) { return internal::name(describe(status)); }
/** The name of what a point belongs to, such as "CAP". */
inline std::string to_string(Part part) { return internal::name(describe(part)); }
/** The names of all warnings that are set, separated by ", ", such as "WEAK_RADIUS, POOR_FIT"; empty for none. */
inline std::string to_string(ResultFlags flags)
{
    std::string names;
    for (const std::string &warning : warnings(flags)) {
        names += (names.empty() ? "" : ", ") + internal::name(warning);
    }
    return names;
}

} // namespace cylfuse

#endif

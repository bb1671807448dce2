/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file names.hpp
 * The version of the library, and constants as text: to_string() gives the name of any, describe() of those of errors and
 * results the name and what it means. Include cylfuse.hpp.
 */

#ifndef CYLFUSE_NAMES_HPP
#define CYLFUSE_NAMES_HPP

#include <cylfuse/enums.hpp>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
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
/** The same for where an iteration starts or started. */
inline const char *describe(Start start) noexcept
{
    return cylfuse_start_string(static_cast<cylfuse_start>(start));
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
/** The same for what a measurement says about a tolerance. */
inline const char *describe(Conformity conformity) noexcept
{
    return cylfuse_conformity_string(static_cast<cylfuse_conformity>(conformity));
}
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

// One of the names of constants whose numbers go up by 1 from the first one on.
template <class Constant>
std::string name(Constant constant, Constant first, std::initializer_list<const char *> names)
{
    const std::int64_t place = static_cast<std::int64_t>(constant) - static_cast<std::int64_t>(first);
    const bool known = place >= 0 && place < static_cast<std::int64_t>(names.size());
    return known ? names.begin()[static_cast<std::size_t>(place)] : "unknown";
}

} // namespace internal
/** @endcond */

/** The name of a status, such as "TOO_FEW_POINTS"; "unknown status" for unknown numbers. */
inline std::string to_string(Status status) { return internal::name(describe(status)); }
/** The name of why an iteration ended, such as "GRADIENT"; "unknown" for unknown numbers, as below. */
inline std::string to_string(Termination termination) { return internal::name(describe(termination)); }
/** The name of where an iteration starts or started, such as "LIMBS". */
inline std::string to_string(Start start) { return internal::name(describe(start)); }
/** The name of what an end is, such as "SEEN". */
inline std::string to_string(EndState state) { return internal::name(describe(state)); }
/** The name of what the position of an end was taken from, such as "IMAGE". */
inline std::string to_string(EndSource source) { return internal::name(describe(source)); }
/** The name of whether a limb was located, or why not, such as "NO_EDGE". */
inline std::string to_string(LimbStatus status) { return internal::name(describe(status)); }
/** The name of what a point belongs to, such as "CAP". */
inline std::string to_string(Part part) { return internal::name(describe(part)); }
/** The name of what a measurement says about a tolerance, such as "CONFORMING". */
inline std::string to_string(Conformity conformity) { return internal::name(describe(conformity)); }
/** The names of all warnings that are set, separated by ", ", such as "WEAK_RADIUS, POOR_FIT"; empty for none. */
inline std::string to_string(ResultFlags flags)
{
    std::string names;
    for (const std::string &warning : warnings(flags)) {
        names += (names.empty() ? "" : ", ") + internal::name(warning);
    }
    return names;
}
/** The name of how a cylinder is estimated, such as "FUSED". */
inline std::string to_string(Method method)
{
    return internal::name(method, Method::Fused, {"FUSED", "POINTS", "RANSAC", "EBERLY"});
}
/** The name of what is minimised, such as "ROBUST". */
inline std::string to_string(Objective objective)
{
    return internal::name(objective, Objective::Robust, {"ROBUST", "PAPER"});
}
/** The name of whether the near-wall rule holds, such as "ON". */
inline std::string to_string(NearWall rule) { return internal::name(rule, NearWall::Auto, {"AUTO", "ON", "OFF"}); }
/** The name of the coordinates of an iteration, such as "LOCAL". */
inline std::string to_string(Chart chart)
{
    return internal::name(chart, Chart::Auto, {"AUTO", "LOCAL", "ORTHONORMAL"});
}
/** The name of whether a detector looks at the image, such as "IGNORE". */
inline std::string to_string(ImageUse use) { return internal::name(use, ImageUse::Auto, {"AUTO", "IGNORE"}); }
/** The name of what given edge segments are, such as "AS_GIVEN". */
inline std::string to_string(EdgeUse use) { return internal::name(use, EdgeUse::Refine, {"REFINE", "AS_GIVEN"}); }
/** The name of how ends are found, such as "LOCATED". */
inline std::string to_string(ExtentRule rule)
{
    return internal::name(rule, ExtentRule::Auto, {"AUTO", "EXTREMES", "LOCATED"});
}
/** The name of the distortion of a lens, such as "BROWN_CONRADY". */
inline std::string to_string(Distortion model)
{
    return internal::name(model, Distortion::None, {"NONE", "BROWN_CONRADY", "KANNALA_BRANDT"});
}
/** The name of how a depth is stored, such as "U16". */
inline std::string to_string(DepthFormat format)
{
    return internal::name(format, DepthFormat::U16, {"U16", "F32"});
}
/** The name of how a pixel of an image is stored, such as "BGR8". */
inline std::string to_string(ImageFormat format)
{
    return internal::name(format, ImageFormat::U8, {"U8", "U16", "F32", "RGB8", "BGR8", "RGBA8", "BGRA8"});
}
/** The names of all data of a view that are set, separated by ", ", such as "DEPTH, IMAGE"; empty for none. */
inline std::string to_string(Input inputs)
{
    const auto bits = static_cast<cylfuse_input>(inputs);
    std::string names;
    for (int bit = 0; bit < 32; ++bit) {
        if ((bits & (cylfuse_input(1) << bit)) != 0) {
            names += (names.empty() ? "" : ", ") + internal::name(bit, 0, {"POINTS", "DEPTH", "EDGES", "IMAGE"});
        }
    }
    return names;
}
/** The name of what a fit is doing, such as "SOLVE". */
inline std::string to_string(Phase phase) { return internal::name(phase, Phase::Start, {"START", "SOLVE"}); }
/** The name of what a detector is doing, such as "SEARCH". */
inline std::string to_string(DetectionPhase phase)
{
    return internal::name(phase, DetectionPhase::Search, {"SEARCH", "FIT"});
}
/** The name of how much a log line matters, such as "WARNING". */
inline std::string to_string(LogLevel level)
{
    return internal::name(level, LogLevel::Off, {"OFF", "ERROR", "WARNING", "INFO", "DEBUG"});
}
/** The name of which residuals are listed, such as "EDGES". */
inline std::string to_string(ResidualKind kind)
{
    return internal::name(kind, ResidualKind::Points, {"POINTS", "EDGES"});
}
/** The name of how points are arranged, such as "ORGANISED". */
inline std::string to_string(Layout layout)
{
    return internal::name(layout, Layout::Packed, {"PACKED", "ORGANISED"});
}

} // namespace cylfuse

#endif

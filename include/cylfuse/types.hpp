/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file types.hpp
 * Settings and results of cylfuse.hpp. Include cylfuse.hpp, which says how they are meant.
 *
 * What derives from a struct of the C interface has its numbers as fields. Where a field is an enumeration, functions
 * of its name read it and, in settings, set it.
 */

#ifndef CYLFUSE_TYPES_HPP
#define CYLFUSE_TYPES_HPP

#include <cylfuse/enums.hpp>
#include <cylfuse/names.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>
#if __cplusplus >= 201703L
#include <optional>
#endif

namespace cylfuse {

/** An infinite cylinder: point on the axis, direction, radius; the order of PCL's coefficients. */
using Cylinder = cylfuse_cylinder;

/** @cond internal */
namespace internal {

// Copies what a library says: an older one knows fewer fields than this header, a newer one more.
template <class State>
void copy_known(State &to, const State &from) noexcept
{
    // 0 where a program made the struct.
    const bool whole = from.struct_size == 0 || from.struct_size > sizeof(State);
    const std::size_t size = whole ? sizeof(State) : from.struct_size;
    std::memcpy(&to, &from, size);
    to.struct_size = static_cast<std::uint32_t>(size);
}

} // namespace internal
/** @endcond */

/** The state of a running fit, before each iteration, and the last one again between the other steps of the fit. */
struct Progress : cylfuse_progress {
    /** All 0. */
    Progress() noexcept : cylfuse_progress{} {}
    /** What the library says; the cylinder is not copied. */
    Progress(const cylfuse_progress &state) noexcept : Progress() { internal::copy_known<cylfuse_progress>(*this, state); }
    /** What the fit is doing; `phase` has its number. */
    Phase current_phase() const noexcept { return Phase(phase); }
};

/** How far a detector is. */
struct DetectionProgress : cylfuse_detection_progress {
    /** All 0. */
    DetectionProgress() noexcept : cylfuse_detection_progress{} {}
    /** What the library says. */
    DetectionProgress(const cylfuse_detection_progress &state) noexcept : DetectionProgress()
    {
        internal::copy_known<cylfuse_detection_progress>(*this, state);
    }
    /** What the detector is doing; `phase` has its number. */
    DetectionPhase current_phase() const noexcept { return DetectionPhase(phase); }
};

/** A cylinder of a scene: score, how many pixels or points it has, the cylinder that was fitted. */
using Detection = cylfuse_detection;

/** What a short piece of a limb in the image says. */
using LimbSample = cylfuse_limb_sample;

/** A sample on the arc of an end of the cylinder in the image. */
using EndSample = cylfuse_end_sample;

/** A parameter that may be left out, by `{}` where others follow. For parameters only: it points to what was given. */
template <class T>
class Optional {
public:
    /** Nothing. */
    constexpr Optional() noexcept : value_(nullptr) {}
    /** A value, which must stay for the call. */
    constexpr Optional(const T &value) noexcept : value_(&value) {}
#if __cplusplus >= 201703L
    /** What may be a value. */
    constexpr Optional(const std::optional<T> &value) noexcept : value_(value ? &*value : nullptr) {}
#endif
    /** The value for the C interface; NULL for nothing. */
    constexpr const T *get() const noexcept { return value_; }

private:
    const T *value_;
};

/** x' = rotation * x + translation: from a camera frame to another one or to the reference frame. */
struct RigidMotion {
    std::array<double, 9> rotation{{1, 0, 0, 0, 1, 0, 0, 0, 1}}; ///< The rotation matrix, row by row.
    std::array<double, 3> translation{{0, 0, 0}};                ///< In the unit of length.
};

/** The settings of a fit, with the defaults at first. */
struct Options : cylfuse_options {
    Options() noexcept { cylfuse_options_init(this, sizeof(cylfuse_options)); }

    /** How the cylinder is estimated. */
    Method method() const noexcept { return Method(cylfuse_options::method); }
    /** Sets how the cylinder is estimated. */
    Options &method(Method value) noexcept { return set(cylfuse_options::method, value); }
    /** What Method::Fused minimises. */
    Objective objective() const noexcept { return Objective(cylfuse_options::objective); }
    /** Sets what Method::Fused minimises. */
    Options &objective(Objective value) noexcept { return set(cylfuse_options::objective, value); }
    /** Where the iteration starts. */
    Start start() const noexcept { return Start(cylfuse_options::start); }
    /** Sets where the iteration starts. */
    Options &start(Start value) noexcept { return set(cylfuse_options::start, value); }
    /** Whether the points must lie on the wall that the camera sees. */
    NearWall near_wall() const noexcept { return NearWall(cylfuse_options::near_wall); }
    /** Sets whether the points must lie on the wall that the camera sees. */
    Options &near_wall(NearWall value) noexcept { return set(cylfuse_options::near_wall, value); }
    /** The coordinates of the iteration. */
    Chart chart() const noexcept { return Chart(cylfuse_options::chart); }
    /** Sets the coordinates of the iteration. */
    Options &chart(Chart value) noexcept { return set(cylfuse_options::chart, value); }
    /** What given edge segments are. */
    EdgeUse edge_use() const noexcept { return EdgeUse(cylfuse_options::edge_use); }
    /** Sets what given edge segments are. */
    Options &edge_use(EdgeUse value) noexcept { return set(cylfuse_options::edge_use, value); }
    /** How the ends of the visible cylinder are found. */
    ExtentRule extent_rule() const noexcept { return ExtentRule(cylfuse_options::extent_rule); }
    /** Sets how the ends of the visible cylinder are found. */
    Options &extent_rule(ExtentRule value) noexcept { return set(cylfuse_options::extent_rule, value); }

private:
    template <class Enumeration>
    Options &set(std::int32_t &field, Enumeration value) noexcept
    {
        field = static_cast<std::int32_t>(value);
        return *this;
    }
};

/** The settings of a detector, with the defaults at first. */
struct DetectorOptions : cylfuse_detector_options {
    DetectorOptions() noexcept { cylfuse_detector_options_init(this, sizeof(cylfuse_detector_options)); }

    /** Whether the image of a frame is looked at. */
    ImageUse image_use() const noexcept { return ImageUse(cylfuse_detector_options::image_use); }
    /** Sets whether the image of a frame is looked at. */
    DetectorOptions &image_use(ImageUse value) noexcept
    {
        cylfuse_detector_options::image_use = static_cast<cylfuse_image_use>(value);
        return *this;
    }
};

/** A camera; a pinhole unless `distortion_model` and `distortion` are set. */
struct Intrinsics : cylfuse_intrinsics {
    /** All 0, to be filled. */
    Intrinsics() noexcept { cylfuse_intrinsics_init(this, sizeof(cylfuse_intrinsics)); }
    /** A pinhole: size of the image, focal lengths and principal point in pixels. */
    Intrinsics(std::uint32_t columns, std::uint32_t rows, double focal_x, double focal_y, double center_x,
               double center_y) noexcept
        : Intrinsics()
    {
        width = columns;
        height = rows;
        fx = focal_x;
        fy = focal_y;
        cx = center_x;
        cy = center_y;
    }
    /**
     * The same with distortion: coefficients in the order of the model, the missing ones 0. For the coefficients of OpenCV:
     * `Intrinsics(640, 480, 570, 570, 319.5, 239.5, Distortion::BrownConrady, {{k1, k2, p1, p2, k3}})`, those of its fisheye
     * model with Distortion::KannalaBrandt.
     */
    Intrinsics(std::uint32_t columns, std::uint32_t rows, double focal_x, double focal_y, double center_x,
               double center_y, Distortion model, const std::array<double, 8> &coefficients) noexcept
        : Intrinsics(columns, rows, focal_x, focal_y, center_x, center_y)
    {
        distortion_model(model);
        for (std::size_t k = 0; k < coefficients.size(); ++k) {
            distortion[k] = coefficients[k];
        }
    }
    /** What the numbers in `distortion` mean. */
    Distortion distortion_model() const noexcept { return Distortion(cylfuse_intrinsics::distortion_model); }
    /** Sets what the numbers in `distortion` mean. */
    Intrinsics &distortion_model(Distortion value) noexcept
    {
        cylfuse_intrinsics::distortion_model = static_cast<cylfuse_distortion>(value);
        return *this;
    }
};

/** The numbers to judge a fit by, whatever shape was fitted. */
struct Result : cylfuse_result {
    Result() noexcept { cylfuse_result_init(this, sizeof(cylfuse_result)); }
    /** Whether a warning is there, any of several. */
    bool has(ResultFlags any) const noexcept { return (flags & static_cast<cylfuse_result_flags>(any)) != 0; }
    /** The warnings that are set as text: of each its name, a colon, and what it means. Empty for none. */
    std::vector<std::string> warnings() const { return cylfuse::warnings(ResultFlags(flags)); }
    /** The names of the warnings that are set, separated by ", ". Empty for none. */
    std::string warning_names() const { return to_string(ResultFlags(flags)); }
    /** Why the iteration ended. */
    Termination termination() const noexcept { return Termination(cylfuse_result::termination); }
};

/** The cylinder that a fit found, how certain it is, and where the iteration started. */
struct CylinderEstimate : cylfuse_cylinder_estimate {
    CylinderEstimate() noexcept { cylfuse_cylinder_estimate_init(this, sizeof(cylfuse_cylinder_estimate)); }
    /** How the start was found. */
    Start start_kind() const noexcept { return Start(cylfuse_cylinder_estimate::start_kind); }
};

/** The outcome of a fit. */
struct CylinderFit {
    Result result;             ///< The numbers to judge it by.
    CylinderEstimate cylinder; ///< The cylinder with its deviations.
};

/** The limits of a radius, a diameter or another length, and how sure a decision about them must be. */
struct Tolerance {
    /** The limits, which conform themselves, in the unit of length; an infinite one is none. `factor` is the coverage. */
    constexpr Tolerance(double low, double high, double factor = 2.0) noexcept
        : lower(low), upper(high), coverage(factor)
    {
    }

    double lower;    ///< The lower limit.
    double upper;    ///< The upper limit, greater than the lower one.
    double coverage; ///< The coverage factor k of ISO 14253-1: deviations on either side of a value.
};

/** What was pushed into a view, and what was left out by reason. */
struct Counts : cylfuse_counts {
    Counts() noexcept { cylfuse_counts_init(this, sizeof(cylfuse_counts)); }
};

/** What the data determine at a cylinder. */
struct Diagnosis : cylfuse_cylinder_diagnosis {
    Diagnosis() noexcept { cylfuse_cylinder_diagnosis_init(this, sizeof(cylfuse_cylinder_diagnosis)); }
};

/** What became of the pixels of a completion. */
struct Completion : cylfuse_completion {
    Completion() noexcept { cylfuse_completion_init(this, sizeof(cylfuse_completion)); }
};

/** The visible piece of the cylinder. */
struct Extent : cylfuse_extent {
    Extent() noexcept { cylfuse_extent_init(this, sizeof(cylfuse_extent)); }
    /** What the end against the direction is. */
    EndState start_state() const noexcept { return EndState(cylfuse_extent::start_state); }
    /** What the end along the direction is. */
    EndState end_state() const noexcept { return EndState(cylfuse_extent::end_state); }
    /** What the position of the start was taken from. */
    EndSource start_source() const noexcept { return EndSource(cylfuse_extent::start_source); }
    /** What the position of the end was taken from. */
    EndSource end_source() const noexcept { return EndSource(cylfuse_extent::end_source); }
};

/** A limb of the cylinder in the image of one view: where it was located, or why it was not. */
struct Limb : cylfuse_limb {
    /** Whether the limb was located, or why not. */
    LimbStatus status() const noexcept { return LimbStatus(cylfuse_limb::status); }
};
static_assert(sizeof(Limb) == sizeof(cylfuse_limb), "the library fills arrays of limbs");

/** How much each point of a view counts at the cylinder of a fit. */
struct PointWeights {
    std::vector<double> weights;       ///< From 1 on the surface to 0 for an outlier.
    std::vector<std::uint8_t> inliers; ///< 1 for a point whose weight is above 0, else 0.
};

/** How two cylinders differ. */
struct Difference {
    double angle;           ///< Angle between the axes in radians, in [0, pi / 2].
    double axis_distance;   ///< Shortest distance between the two axes, in the unit of length.
    double radius_relative; ///< (radius of the second - radius of the first) / radius of the first.
};

/** The two limb lines in the image: a u + b v + c = 0 with a^2 + b^2 = 1, in ideal pixels. */
using LimbLines = std::array<std::array<double, 3>, 2>;

/** What a plan expects: standard deviations of radius, direction, position and length, as of cylfuse_plan. */
struct Expectation {
    std::array<double, 4> scatter; ///< What captures of one scene differ by.
    std::array<double, 4> total;   ///< What a measurement is off by, with what all points of a frame share.
};

} // namespace cylfuse

#endif

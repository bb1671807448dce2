/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file cylinder.hpp
 * What can be asked of cylinders, cameras and results without a fitter. Include cylfuse.hpp, which says how it is meant.
 */

#ifndef CYLFUSE_CYLINDER_HPP
#define CYLFUSE_CYLINDER_HPP

#include <cylfuse/error.hpp>
#include <cylfuse/types.hpp>
#include <cylfuse/views.hpp>

namespace cylfuse {
#ifdef CYLFUSE_NO_EXCEPTIONS
inline namespace without_exceptions {
#else
inline namespace with_exceptions {
#endif

/**
 * Writes signed distances of points from the surface, negative inside, NaN for points that are not finite; Error::needed()
 * when there is not room enough.
 */
inline Returned<void> distances(const Cylinder &model, const PointsView &points, Span<double> out)
{
    return detail::finish_call(cylfuse_cylinder_distances(&model, &points, out.data(), out.size()),
                               points.width * points.height);
}
/** The same of points that vanish after the call. */
template <class Container, class = internal::IfTemporary<PointsView, Container>>
Returned<void> distances(const Cylinder &model, Container &&points, Span<double> out)
{
    return distances(model, PointsView(points), out);
}

/** The two limb lines of a cylinder in the camera frame, in the image. */
inline Returned<LimbLines> project(const Cylinder &model, const cylfuse_intrinsics &intrinsics)
{
    LimbLines lines{};
    const cylfuse_status status = cylfuse_cylinder_project(&model, &intrinsics, lines[0].data());
    return detail::finish_call(status, lines);
}

/** The pixels of the (distorted) image at which a camera sees points of its frame; NaN where it sees none. */
inline Returned<std::vector<std::array<double, 2>>> project(const cylfuse_intrinsics &intrinsics,
                                                            const PointsView &points)
{
    std::vector<std::array<double, 2>> pixels(points.width * points.height);
    const cylfuse_status status = cylfuse_intrinsics_project(
        &intrinsics, &points, reinterpret_cast<double *>(pixels.data()), pixels.size());
    return detail::finish_call(status, std::move(pixels));
}
/** The same of points that vanish after the call. */
template <class Container, class = internal::IfTemporary<PointsView, Container>>
Returned<std::vector<std::array<double, 2>>> project(const cylfuse_intrinsics &intrinsics, Container &&points)
{
    return project(intrinsics, PointsView(points));
}

/** The rays, points at z = 1, along which a camera sees pixels of the (distorted) image; NaN where there is none. */
inline Returned<std::vector<std::array<double, 3>>> unproject(const cylfuse_intrinsics &intrinsics,
                                                              Span<const std::array<double, 2>> pixels)
{
    std::vector<std::array<double, 3>> rays(pixels.size());
    const cylfuse_status status =
        cylfuse_intrinsics_unproject(&intrinsics, reinterpret_cast<const double *>(pixels.data()), pixels.size(),
                                     reinterpret_cast<double *>(rays.data()));
    return detail::finish_call(status, std::move(rays));
}

/** What to expect of measurements of a cylinder with a camera; see cylfuse_plan for the numbers of cylinder and noise. */
inline Returned<Expectation> plan(const cylfuse_intrinsics &intrinsics, const std::array<double, 5> &cylinder)
{
    Expectation expected{};
    const cylfuse_status status =
        cylfuse_plan(&intrinsics, cylinder.data(), nullptr, expected.scatter.data(), expected.total.data());
    return detail::finish_call(status, expected);
}

/** The same with what is known of the noise. */
inline Returned<Expectation> plan(const cylfuse_intrinsics &intrinsics, const std::array<double, 5> &cylinder,
                                  const std::array<double, 6> &noise)
{
    Expectation expected{};
    const cylfuse_status status =
        cylfuse_plan(&intrinsics, cylinder.data(), noise.data(), expected.scatter.data(), expected.total.data());
    return detail::finish_call(status, expected);
}

/**
 * Decides by the rule of ISO 14253-1 whether a length conforms to a tolerance: only where the value with `coverage`
 * deviations on either side lies within the limits, and not only where it lies outside. See cylfuse_decide_conformity() for
 * the deviations and warnings that decide nothing.
 */
inline Returned<Conformity> decide_conformity(double value, double deviation, ResultFlags flags,
                                              const Tolerance &tolerance)
{
    cylfuse_conformity conformity = CYLFUSE_CONFORMITY_UNDECIDED;
    const cylfuse_status status =
        cylfuse_decide_conformity(value, deviation, static_cast<cylfuse_result_flags>(flags), tolerance.lower,
                                  tolerance.upper, tolerance.coverage, &conformity);
    return detail::finish_call(status, Conformity(conformity));
}

/** Whether the radius of a fit conforms to a tolerance, by its deviation and its warnings. */
inline Returned<Conformity> radius_conforms(const CylinderFit &fit, const Tolerance &tolerance)
{
    const CylinderEstimate &cylinder = fit.cylinder;
    return decide_conformity(cylinder.model.radius, cylinder.radius_deviation, ResultFlags(fit.result.flags), tolerance);
}

/** The same for the diameter, with limits of the diameter. */
inline Returned<Conformity> diameter_conforms(const CylinderFit &fit, const Tolerance &tolerance)
{
    const CylinderEstimate &cylinder = fit.cylinder;
    return decide_conformity(2.0 * cylinder.model.radius, 2.0 * cylinder.radius_deviation,
                             ResultFlags(fit.result.flags), tolerance);
}

/** How the second cylinder differs from the first. */
inline Returned<Difference> compare(const Cylinder &first, const Cylinder &second)
{
    Difference difference{};
    const cylfuse_status status = cylfuse_cylinder_compare(&first, &second, &difference.angle,
                                                           &difference.axis_distance, &difference.radius_relative);
    return detail::finish_call(status, difference);
}

} // inline namespace
} // namespace cylfuse

#endif

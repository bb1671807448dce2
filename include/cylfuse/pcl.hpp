/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file pcl.hpp
 * Clouds, indices and model coefficients of PCL in and out, a class in place of PCL's segmentation of cylinders, and one
 * that finds all cylinders of a scene.
 * Include it beside PCL 1.12 or later. The coordinates are those of the cloud; completion, masks, images and edges need
 * them in the camera frame.
 */

#ifndef CYLFUSE_PCL_HPP
#define CYLFUSE_PCL_HPP

#ifdef CYLFUSE_NO_EXCEPTIONS
#error "cylfuse/pcl.hpp throws, as PCL does: compile without CYLFUSE_NO_EXCEPTIONS"
#endif

#include <cylfuse/cylfuse.hpp>

#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <utility>

namespace cylfuse {
inline namespace with_exceptions {

/** @cond internal */
namespace detail {

// Few enough for the stack, enough that calls do not count.
constexpr std::size_t POINTS_AT_ONCE = 1024;

template <class PointT>
const float *coordinates(const PointT &point)
{
    static_assert(std::is_same<decltype(PointT::x), float>::value && std::is_same<decltype(PointT::y), float>::value &&
                      std::is_same<decltype(PointT::z), float>::value,
                  "the type of the points must have float members x, y, z");
    return &point.x;
}

template <class PointT>
void check_cloud(const pcl::PointCloud<PointT> &cloud)
{
    if (cloud.empty()) {
        throw Error(Status::InvalidArgument, "the cloud is empty; it must hold points");
    }
    if (std::size_t(cloud.width) * cloud.height != cloud.size()) {
        throw Error(Status::SizeMismatch,
                    ("the cloud says " + std::to_string(cloud.width) + " x " + std::to_string(cloud.height) +
                     " but holds " + std::to_string(cloud.size()) + " points; set its width and height")
                        .c_str());
    }
    const PointT &first = cloud.front();
    if (&first.y != &first.x + 1 || &first.z != &first.x + 2) {
        throw Error(Status::Unsupported, "x, y, z are not adjacent in the type of the points; copy the "
                                                "cloud to pcl::PointXYZ with pcl::copyPointCloud");
    }
}

template <class PointT>
void check_indices(const pcl::PointCloud<PointT> &cloud, const pcl::Indices &indices)
{
    if (indices.empty()) {
        throw Error(Status::InvalidArgument, "there are no indices; give at least one, or none at all");
    }
    for (std::size_t k = 0; k < indices.size(); ++k) {
        if (indices[k] < 0 || std::size_t(indices[k]) >= cloud.size()) {
            throw Error(Status::InvalidArgument,
                        ("index " + std::to_string(indices[k]) + " at position " + std::to_string(k) +
                         " is outside the cloud; it must lie in 0 to " + std::to_string(cloud.size() - 1))
                            .c_str());
        }
    }
}

// Calls use(view, first position, count) with the points of indices, some at a time, copied to the stack.
template <class PointT, class Use>
void gather(const pcl::PointCloud<PointT> &cloud, const pcl::Indices &indices, Use use)
{
    std::array<std::array<float, 3>, POINTS_AT_ONCE> some;
    for (std::size_t first = 0; first < indices.size(); first += POINTS_AT_ONCE) {
        const std::size_t count = std::min(POINTS_AT_ONCE, indices.size() - first);
        for (std::size_t k = 0; k < count; ++k) {
            const PointT &point = cloud[std::size_t(indices[first + k])];
            some[k] = {point.x, point.y, point.z};
        }
        use(PointsView(some[0].data(), count), first, count);
    }
}

} // namespace detail
/** @endcond */

/** A cloud, organised or not, where it is. Points that are not finite are left out and counted by the library. */
template <class PointT>
PointsView points_view(const pcl::PointCloud<PointT> &cloud)
{
    detail::check_cloud(cloud);
    return PointsView(detail::coordinates(cloud.front()), cloud.width, cloud.height, sizeof(PointT));
}

/** Would point to points that are gone. */
template <class PointT>
PointsView points_view(const pcl::PointCloud<PointT> &&cloud) = delete;

/** Adds the points of a cloud with these indices. Nothing is added where that fails, as for an index that is out of range. */
template <class PointT>
void push_points(Fitter &fitter, const pcl::PointCloud<PointT> &cloud, const pcl::Indices &indices)
{
    detail::check_cloud(cloud);
    detail::check_indices(cloud, indices);
    // All at once: a push that fails adds nothing.
    std::vector<std::array<float, 3>> points;
    points.reserve(indices.size());
    for (const pcl::index_t index : indices) {
        const PointT &point = cloud[std::size_t(index)];
        points.push_back({point.x, point.y, point.z});
    }
    fitter.push_points(points);
}

/** The seven coefficients of PCL's SACMODEL_CYLINDER: point on the axis, direction, radius. */
inline pcl::ModelCoefficients to_coefficients(const Cylinder &model)
{
    pcl::ModelCoefficients coefficients;
    coefficients.values.reserve(7);
    for (const double value : model.point) {
        coefficients.values.push_back(static_cast<float>(value));
    }
    for (const double value : model.direction) {
        coefficients.values.push_back(static_cast<float>(value));
    }
    coefficients.values.push_back(static_cast<float>(model.radius));
    return coefficients;
}

/** The cylinder of seven coefficients of PCL's SACMODEL_CYLINDER. */
inline Cylinder to_cylinder(const pcl::ModelCoefficients &coefficients)
{
    const std::vector<float> &values = coefficients.values;
    if (values.size() != 7) {
        throw Error(Status::InvalidArgument,
                    ("there are " + std::to_string(values.size()) +
                     " coefficients; a cylinder has 7: point on the axis, direction, radius")
                        .c_str());
    }
    return Cylinder{{values[0], values[1], values[2]}, {values[3], values[4], values[5]}, values[6]};
}

/** @cond internal */
namespace detail {

// What took the place of a cloud: it keeps header and sensor.
template <class PointT>
void replace(pcl::PointCloud<PointT> &cloud, pcl::PointCloud<PointT> &&completed)
{
    completed.header = cloud.header;
    completed.sensor_origin_ = cloud.sensor_origin_;
    completed.sensor_orientation_ = cloud.sensor_orientation_;
    cloud = std::move(completed);
}

template <class PointT>
PointsOut points_out(pcl::PointCloud<PointT> &cloud)
{
    check_cloud(cloud);
    return PointsOut(const_cast<float *>(coordinates(cloud.front())), cloud.size(), sizeof(PointT));
}

} // namespace detail
/** @endcond */

/**
 * Completes the cloud over a mask into a cloud of points that all exist, which is not organised. Model and mask may be
 * left out, as for Fitter::complete(). The cloud stays as it was where that fails.
 */
template <class PointT>
Completion complete(const Fitter &fitter, pcl::PointCloud<PointT> &cloud, Optional<Cylinder> model = {},
                    Optional<MaskView> mask = {})
{
    pcl::PointCloud<PointT> completed;
    completed.resize(fitter.complete_bound(Layout::Packed, mask));
    const Completion completion = fitter.complete(detail::points_out(completed), Layout::Packed, model, mask);
    completed.resize(static_cast<std::size_t>(completion.count));
    completed.is_dense = true;
    detail::replace(cloud, std::move(completed));
    return completion;
}

/**
 * Completes the cloud over a mask into an organised cloud of the size of the camera, with NaN where there is no point. Model
 * and mask may be left out, as for Fitter::complete(). The cloud stays as it was where that fails.
 */
template <class PointT>
Completion complete_organised(const Fitter &fitter, pcl::PointCloud<PointT> &cloud, Optional<Cylinder> model = {},
                              Optional<MaskView> mask = {})
{
    const Intrinsics camera = fitter.intrinsics();
    pcl::PointCloud<PointT> completed(camera.width, camera.height);
    const Completion completion = fitter.complete(detail::points_out(completed), Layout::Organised, model, mask);
    completed.is_dense = completion.hits - completion.out_of_range == completed.size();
    detail::replace(cloud, std::move(completed));
    return completion;
}

} // inline namespace
} // namespace cylfuse

#include <cylfuse/pcl_detection.hpp>
#include <cylfuse/pcl_segmentation.hpp>

#endif

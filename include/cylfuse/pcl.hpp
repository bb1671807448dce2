/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file pcl.hpp
 * Clouds, indices and model coefficients of PCL in and out, and a class in place of PCL's segmentation of cylinders.
 * Include it beside PCL 1.12 or later. The coordinates are those of the cloud; completion, extent and edges need
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
#include <pcl/sample_consensus/model_types.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <algorithm>
#include <cmath>
#include <limits>

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
        throw Error(CYLFUSE_STATUS_INVALID_ARGUMENT, "the cloud is empty; it must hold points");
    }
    if (std::size_t(cloud.width) * cloud.height != cloud.size()) {
        throw Error(CYLFUSE_STATUS_SIZE_MISMATCH,
                    ("the cloud says " + std::to_string(cloud.width) + " x " + std::to_string(cloud.height) +
                     " but holds " + std::to_string(cloud.size()) + " points; set its width and height")
                        .c_str());
    }
    const PointT &first = cloud.front();
    if (&first.y != &first.x + 1 || &first.z != &first.x + 2) {
        throw Error(CYLFUSE_STATUS_UNSUPPORTED, "x, y, z are not adjacent in the type of the points; copy the "
                                                "cloud to pcl::PointXYZ with pcl::copyPointCloud");
    }
}

template <class PointT>
void check_indices(const pcl::PointCloud<PointT> &cloud, const pcl::Indices &indices)
{
    if (indices.empty()) {
        throw Error(CYLFUSE_STATUS_INVALID_ARGUMENT, "there are no indices; give at least one, or none at all");
    }
    for (std::size_t k = 0; k < indices.size(); ++k) {
        if (indices[k] < 0 || std::size_t(indices[k]) >= cloud.size()) {
            throw Error(CYLFUSE_STATUS_INVALID_ARGUMENT,
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

/** Adds the points of a cloud with these indices. Nothing is added when an index is out of range. */
template <class PointT>
void push_points(Fitter &fitter, const pcl::PointCloud<PointT> &cloud, const pcl::Indices &indices)
{
    detail::check_cloud(cloud);
    detail::check_indices(cloud, indices);
    fitter.reserve(indices.size(), 0); // From here on nothing can fail between two pushes.
    detail::gather(cloud, indices,
                   [&](const PointsView &points, std::size_t, std::size_t) { fitter.push_points(points); });
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
        throw Error(CYLFUSE_STATUS_INVALID_ARGUMENT,
                    ("there are " + std::to_string(values.size()) +
                     " coefficients; a cylinder has 7: point on the axis, direction, radius")
                        .c_str());
    }
    return Cylinder{{values[0], values[1], values[2]}, {values[3], values[4], values[5]}, values[6]};
}

/**
 * Completes the cloud over a mask into a cloud of points that all exist, which is not organised. NULL = the model of
 * the last fit, the mask of the last depth image.
 */
template <class PointT>
Completion complete(Fitter &fitter, pcl::PointCloud<PointT> &cloud, const Cylinder *model = nullptr,
                    const MaskView *mask = nullptr)
{
    cloud.clear();
    cloud.resize(fitter.complete_bound(CYLFUSE_LAYOUT_PACKED, mask));
    detail::check_cloud(cloud);
    float *first = const_cast<float *>(detail::coordinates(cloud.front()));
    const PointsOut out(first, cloud.size(), sizeof(PointT));
    const Completion completion = fitter.complete(out, model, mask);
    cloud.resize(static_cast<std::size_t>(completion.count));
    cloud.is_dense = true;
    return completion;
}

/**
 * Stands in for pcl::SACSegmentationFromNormals where a cylinder is looked for: the same interface, from which it
 * derives, but no normals are needed and `segment` fits with cylfuse.
 *
 * What the settings mean here:
 * - setModelType: must be pcl::SACMODEL_CYLINDER.
 * - setDistanceThreshold: the largest distance of an inlier, of the result and of the random samples.
 * - setMaxIterations: most random samples.
 * - setOptimizeCoefficients: true (the default) fits all points robustly from where the random samples led; false
 *   ends with them.
 * - setRadiusLimits, setAxis with setEpsAngle: hold in what is returned. The axis is that of the cylinder; an angle of
 *   0, the default, is no limit.
 * - setInputNormals, setNormalDistanceWeight, setMethodType, setProbability, setNumberOfThreads, setSamplesMaxDist,
 *   setMinMaxOpeningAngle, setDistanceFromOrigin and the argument `random` have no meaning here: they are kept for
 *   their getters and do nothing. getMethod and getModel give NULL.
 *
 * A sensor smears depth around the sides of a cylinder, where it cannot see the surface. When the random samples lead
 * to a cylinder of which nearly all points lie on the side of the origin of the coordinates, that is taken for the
 * sensor, and points beyond the limbs have no influence (the near-wall rule). A cloud from all around, one in other
 * coordinates or one with a sensor origin elsewhere is fitted without that rule.
 *
 * `segment` throws cylfuse::Error where PCL prints and leaves its outputs empty; they are empty then too.
 *
 * @tparam PointT any type of points with float x, y, z
 * @tparam PointNT the type of the normals that nobody needs
 */
template <class PointT, class PointNT = pcl::Normal>
class CylinderSegmentation : public pcl::SACSegmentationFromNormals<PointT, PointNT> {
    using Base = pcl::SACSegmentationFromNormals<PointT, PointNT>;
    using Points = pcl::PCLBase<PointT>;

public:
    /** A segmentation with PCL's defaults, for cylinders. Its results are the same with `random` and without. */
    explicit CylinderSegmentation(bool random = false) : Base(random) {}

    /**
     * Fits a cylinder to the cloud, or to its points with the indices that were set.
     *
     * @param inliers the indices of the points within the distance threshold
     * @param coefficients point on the axis, direction, radius
     */
    void segment(pcl::PointIndices &inliers, pcl::ModelCoefficients &coefficients) override
    {
        inliers.indices.clear();
        coefficients.values.clear();
        check();
        detail::check_cloud(*Points::input_);
        inliers.header = coefficients.header = Points::input_->header;
        Points::initCompute(); // Without indices of the user it makes those of all points, as in PCL.
        fitter_.clear();
        if (Points::fake_indices_) {
            fitter_.push_points(points_view(*Points::input_));
        } else {
            push_points(fitter_, *Points::input_, *Points::indices_);
        }
        Options options = options_;
        options.ransac_threshold = this->getDistanceThreshold();
        options.ransac_max_iterations = static_cast<std::uint32_t>(this->getMaxIterations());
        set_radius_limits(options);
        set_axis_limit(options);
        options.method = CYLFUSE_METHOD_RANSAC;
        fitter_.set_options(options);
        result_ = fitter_.fit();
        if (this->getOptimizeCoefficients()) {
            options.method = CYLFUSE_METHOD_FUSED;
            options.start = CYLFUSE_START_MODEL;
            if (options.near_wall == CYLFUSE_NEAR_WALL_AUTO) {
                options.near_wall = faces_origin(result_.model) ? CYLFUSE_NEAR_WALL_ON : CYLFUSE_NEAR_WALL_OFF;
            }
            fitter_.set_start_model(&result_.model);
            fitter_.set_options(options);
            result_ = fitter_.fit();
        }
        coefficients.values = to_coefficients(result_.model).values;
        select_within(result_.model, inliers.indices);
    }

    /** What the last fit found, with the numbers to judge it. */
    const Result &getResult() const { return result_; }

    /** Replaces the options that PCL has no setter for; method, start, limits and RANSAC's are set by `segment`. */
    void setOptions(const Options &options) { options_ = options; }
    /** The options that PCL has no setter for. */
    const Options &getOptions() const { return options_; }

protected:
    /** The name of this class in messages. */
    std::string getClassName() const override { return "CylinderSegmentation"; }

private:
    void check() const
    {
        if (!Points::input_) {
            throw Error(CYLFUSE_STATUS_BAD_STATE, "segment needs a cloud; call setInputCloud first");
        }
        if (this->getModelType() != pcl::SACMODEL_CYLINDER) {
            throw Error(CYLFUSE_STATUS_UNSUPPORTED, ("the model type is " + std::to_string(this->getModelType()) +
                                                     "; it must be pcl::SACMODEL_CYLINDER, set by setModelType")
                                                        .c_str());
        }
        if (!(this->getDistanceThreshold() > 0.0 && std::isfinite(this->getDistanceThreshold()))) {
            throw Error(CYLFUSE_STATUS_INVALID_ARGUMENT,
                        ("the distance threshold is " + std::to_string(this->getDistanceThreshold()) +
                         "; it must be finite and greater than 0, set by setDistanceThreshold")
                            .c_str());
        }
        if (this->getMaxIterations() <= 0) {
            throw Error(CYLFUSE_STATUS_INVALID_ARGUMENT,
                        ("the number of iterations is " + std::to_string(this->getMaxIterations()) +
                         "; it must be at least 1, set by setMaxIterations")
                            .c_str());
        }
    }

    // As floats inside the limits, so that PCL finds the rounded radius inside them too.
    void set_radius_limits(Options &options)
    {
        double low = 0.0, high = 0.0;
        this->getRadiusLimits(low, high);
        constexpr double NO_LIMIT = std::numeric_limits<double>::max();
        if (!(high > 0.0)) {
            throw Error(CYLFUSE_STATUS_INVALID_ARGUMENT,
                        ("the largest radius is " + std::to_string(high) +
                         "; it must be greater than 0, set by setRadiusLimits")
                            .c_str());
        }
        low = std::max(low, 0.0);
        high = high < NO_LIMIT ? high : 0.0; // For the library 0 is no limit.
        float above = static_cast<float>(low), below = static_cast<float>(high);
        above = above < low ? std::nextafter(above, std::numeric_limits<float>::infinity()) : above;
        below = below > high ? std::nextafter(below, 0.0F) : below;
        const bool room = high == 0.0 || above <= below; // Not where the radius is known and no float.
        options.radius_min = room ? above : low;
        options.radius_max = room ? below : high;
    }

    // The angle is that at which PCL, which computes its cosine in float, is still content. As in PCL, 0 is no limit.
    void set_axis_limit(Options &options) const
    {
        const double largest = this->getEpsAngle();
        const Eigen::Vector3f middle = this->getAxis();
        const bool limited = largest > 0.0 && std::cos(largest) > 0.0;
        if (limited && middle.isZero(0.0F)) {
            throw Error(CYLFUSE_STATUS_INVALID_ARGUMENT,
                        "there is an angle but the axis is 0 0 0; set the axis by setAxis, or setEpsAngle(0)");
        }
        constexpr double ROUNDING = 2.0 * std::numeric_limits<float>::epsilon();
        for (int k = 0; k < 3; ++k) {
            options.axis[k] = limited ? double(middle[k]) : 0.0;
        }
        options.axis_max_angle = limited ? std::acos(std::min(1.0, std::cos(largest) + ROUNDING)) : 0.0;
    }

    // Whether nearly all points near the surface lie on the side of it that the origin sees. As in PCL's estimation of
    // normals the viewpoint is the sensor origin of the cloud; the rule of the library knows the origin only.
    bool faces_origin(const Cylinder &model) const
    {
        // The part of the near-wall rule of the library: less has points on the far side too.
        constexpr double NEARLY_ALL = 0.8;
        if (!Points::input_->sensor_origin_.template head<3>().isZero()) {
            return false;
        }
        const Eigen::Map<const Eigen::Vector3d> center(model.point), direction(model.direction);
        std::size_t near = 0, all = 0;
        for (const pcl::index_t index : *Points::indices_) {
            const PointT &p = (*Points::input_)[std::size_t(index)];
            const Eigen::Vector3d point(p.x, p.y, p.z);
            const Eigen::Vector3d offset = point - center;
            const Eigen::Vector3d normal = offset - direction * direction.dot(offset);
            if (std::abs(normal.norm() - model.radius) <= this->getDistanceThreshold()) {
                ++all;
                near += normal.dot(point) < 0.0;
            }
        }
        return double(near) >= NEARLY_ALL * double(all);
    }

    void select_within(const Cylinder &model, pcl::Indices &selected) const
    {
        std::array<double, detail::POINTS_AT_ONCE> distance;
        const double threshold = this->getDistanceThreshold();
        const auto select = [&](const PointsView &points, std::size_t first, std::size_t count) {
            distances(model, points, distance);
            for (std::size_t k = 0; k < count; ++k) {
                // NaN, for a point that is not finite, is within no distance.
                if (std::abs(distance[k]) <= threshold) {
                    selected.push_back((*Points::indices_)[first + k]);
                }
            }
        };
        detail::gather(*Points::input_, *Points::indices_, select);
    }

    Fitter fitter_;
    Options options_;
    Result result_;
};

} // inline namespace
} // namespace cylfuse

#endif

/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file pcl_segmentation.hpp
 * A class in place of PCL's segmentation of cylinders. Include pcl.hpp.
 */

#ifndef CYLFUSE_PCL_SEGMENTATION_HPP
#define CYLFUSE_PCL_SEGMENTATION_HPP

#include <cylfuse/pcl.hpp>

#include <pcl/console/print.h>
#include <pcl/sample_consensus/sac_model_cylinder.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <cmath>
#include <limits>
#include <locale>
#include <sstream>
#include <string>

namespace cylfuse {
inline namespace with_exceptions {

/** @cond internal */
namespace detail {

// A number as text: all digits that count, which std::to_string() cuts off after six places, and a point in any locale.
inline std::string number(double value)
{
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.precision(std::numeric_limits<double>::digits10);
    text << value;
    return text.str();
}

// Calls use(position in the indices, distance) for the points within a distance of the surface.
template <class PointT, class Use>
void within_distance(const pcl::PointCloud<PointT> &cloud, const pcl::Indices &indices, const Cylinder &model,
                     double threshold, Use use)
{
    std::array<double, POINTS_AT_ONCE> distance;
    gather(cloud, indices, [&](const PointsView &points, std::size_t first, std::size_t count) {
        distances(model, points, distance);
        for (std::size_t k = 0; k < count; ++k) {
            // NaN, for a point that is not finite, is within no distance.
            if (std::abs(distance[k]) <= threshold) {
                use(first + k, std::abs(distance[k]));
            }
        }
    });
}

// Whether a pixel of a mask is set.
inline bool holds(const cylfuse_mask_view &mask, std::size_t column, std::size_t row)
{
    const std::ptrdiff_t pixel = mask.pixel_stride != 0 ? mask.pixel_stride : 1;
    const std::ptrdiff_t stride =
        mask.row_stride != 0 ? mask.row_stride : static_cast<std::ptrdiff_t>(mask.width) * pixel;
    const std::uint8_t value =
        mask.data[static_cast<std::ptrdiff_t>(row) * stride + static_cast<std::ptrdiff_t>(column) * pixel];
    return mask.label == 0 ? value != 0 : value == mask.label;
}

// PCL's model of a cylinder by distances alone: what needs normals there needs none here.
template <class PointT, class PointNT>
class CylinderModel : public pcl::SampleConsensusModelCylinder<PointT, PointNT> {
    using Base = pcl::SampleConsensusModelCylinder<PointT, PointNT>;

public:
    using Base::Base;

    void getDistancesToModel(const Eigen::VectorXf &coefficients, std::vector<double> &all) const override
    {
        all.clear();
        if (this->isModelValid(coefficients)) {
            all.resize(this->indices_->size());
            gather(*this->input_, *this->indices_, [&](const PointsView &points, std::size_t first, std::size_t count) {
                distances(cylinder(coefficients), points, Span<double>(&all[first], count));
            });
            for (double &distance : all) {
                distance = std::abs(distance);
            }
        }
    }
    void selectWithinDistance(const Eigen::VectorXf &coefficients, const double threshold,
                              pcl::Indices &inliers) override
    {
        inliers.clear();
        this->error_sqr_dists_.clear();
        if (this->isModelValid(coefficients)) {
            within_distance(*this->input_, *this->indices_, cylinder(coefficients), threshold,
                            [&](std::size_t position, double distance) {
                                inliers.push_back((*this->indices_)[position]);
                                this->error_sqr_dists_.push_back(distance); // As PCL does: not squared.
                            });
        }
    }
    std::size_t countWithinDistance(const Eigen::VectorXf &coefficients, const double threshold) const override
    {
        std::size_t count = 0;
        if (this->isModelValid(coefficients)) {
            within_distance(*this->input_, *this->indices_, cylinder(coefficients), threshold,
                            [&](std::size_t, double) { ++count; });
        }
        return count;
    }

private:
    static Cylinder cylinder(const Eigen::VectorXf &v)
    {
        return Cylinder{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, v[6]};
    }
};

} // namespace detail
/** @endcond */

/**
 * Stands in for pcl::SACSegmentationFromNormals where a cylinder is looked for: the same interface, from which it
 * derives, but no normals are needed, `segment` fits with cylfuse, and camera, image, edges and mask may be given too.
 *
 * What the settings mean here:
 * - setModelType: must be pcl::SACMODEL_CYLINDER.
 * - setDistanceThreshold: the largest distance of an inlier, of the result and of the random samples.
 * - setMaxIterations: most random samples.
 * - setOptimizeCoefficients: true (the default) fits all points robustly, with edges and image where they are given,
 *   from where the random samples led; false ends with them.
 * - setRadiusLimits, setAxis with setEpsAngle: hold in what is returned; isAtLimit() tells whether they decided it. The
 *   axis is that of the cylinder; an angle of 0, the default, is no limit.
 * - setInputNormals, setNormalDistanceWeight, setMethodType, setProbability, setNumberOfThreads, setSamplesMaxDist,
 *   setMinMaxOpeningAngle, setDistanceFromOrigin and the argument `random` have no meaning here: they are kept for
 *   their getters and do nothing. getModel gives a model whose distances are those without normals; getMethod gives
 *   NULL.
 *
 * A sensor smears depth around the sides of a cylinder, where it cannot see the surface. With setIntrinsics the origin
 * of the coordinates is the sensor, and points beyond the limbs have no influence (the near-wall rule). Without, the
 * rule holds when the random samples lead to a cylinder whose points lie on the side of the origin; a cloud from all
 * around, one in other coordinates or one with a sensor origin elsewhere is fitted without it.
 *
 * Where there is no cylinder `segment` does what PCL does: it prints why and leaves its outputs empty. getError() has
 * the status and the text.
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

    /** The colour camera, in whose frame the cloud is: edges and image need it. */
    void setIntrinsics(const cylfuse_intrinsics &intrinsics)
    {
        static_cast<cylfuse_intrinsics &>(intrinsics_) = intrinsics;
        has_intrinsics_ = true;
    }
    /**
     * Takes the camera away; image and edges, which need it, go by `setImage({})` and `setEdges({})`. The next `segment`
     * begins with another fitter: callbacks that getFitter() was given are gone then.
     */
    void clearIntrinsics() { has_intrinsics_ = false; }
    /**
     * The image of the camera, in which the limbs are located; must stay until `segment`. An empty view, `setImage({})`,
     * takes it away.
     */
    void setImage(const ImageView &image) { image_ = image; }
    /** Pieces of the two limb lines in the image: x1 y1 x2 y2 in pixels each. `setEdges({})` takes them away. */
    void setEdges(std::vector<std::array<double, 4>> edges) { edges_ = std::move(edges); }
    /**
     * The pixels of an organised cloud that show the cylinder: see MaskView. They must stay until `segment`. An empty view,
     * `setMask({})`, takes them away.
     */
    void setMask(const MaskView &mask) { mask_ = mask; }

    /**
     * Fits a cylinder to the cloud, or to its points with the indices that were set, inside the mask.
     *
     * @param inliers the indices of the points within the distance threshold
     * @param coefficients point on the axis, direction, radius
     */
    void segment(pcl::PointIndices &inliers, pcl::ModelCoefficients &coefficients) override
    {
        inliers.indices.clear();
        coefficients.values.clear();
        error_ = Error(Status::Ok);
        try {
            check();
            inliers.header = coefficients.header = Points::input_->header;
            push();
            fit();
            const Cylinder &model = fit_.cylinder.model;
            coefficients.values = to_coefficients(model).values;
            detail::within_distance(*Points::input_, *selected_, model, this->getDistanceThreshold(),
                                    [&](std::size_t position, double) {
                                        inliers.indices.push_back((*selected_)[position]);
                                    });
            for (const ResultFlags limit : {ResultFlags::RadiusAtLimit, ResultFlags::AxisAtLimit}) {
                if (fit_.result.has(limit)) {
                    PCL_WARN("[cylfuse::%s::segment] %s\n", getClassName().c_str(), describe(limit));
                }
            }
        } catch (const Error &error) {
            error_ = error;
            PCL_ERROR("[cylfuse::%s::segment] %s\n", getClassName().c_str(), error.what());
        }
    }

    /** Why the last `segment` gave nothing; its status is Status::Ok when it gave something. */
    const Error &getError() const { return error_; }
    /**
     * Whether a limit of setRadiusLimits or setAxis decided the last `segment` that gave something: the radius or the axis is
     * at its limit, and the points fit better beyond it; or it is known, and they contradict it. Such a cylinder is rarely one
     * that is there, and PCL_WARN says so.
     */
    bool isAtLimit() const { return fit_.result.has(ResultFlags::RadiusAtLimit | ResultFlags::AxisAtLimit); }
    /** What the last `segment` that gave something found, with the numbers to judge it. */
    const CylinderFit &getResult() const { return fit_; }
    /**
     * The fitter with the data of the last `segment`: for extent, completion, weights of the points, limbs. After one that gave
     * nothing it may hold some of the data, or those before.
     */
    Fitter &getFitter() { return fitter_; }
    /** The fitter with the data of the last `segment`. */
    const Fitter &getFitter() const { return fitter_; }

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
            throw Error(Status::BadState, "segment needs a cloud; call setInputCloud first");
        }
        if (this->getModelType() != pcl::SACMODEL_CYLINDER) {
            throw Error(Status::Unsupported, ("the model type is " + std::to_string(this->getModelType()) +
                                                     "; it must be pcl::SACMODEL_CYLINDER, set by setModelType")
                                                        .c_str());
        }
        if (!(this->getDistanceThreshold() > 0.0 && std::isfinite(this->getDistanceThreshold()))) {
            throw Error(Status::InvalidArgument,
                        ("the distance threshold is " + detail::number(this->getDistanceThreshold()) +
                         "; it must be finite and greater than 0, set by setDistanceThreshold")
                            .c_str());
        }
        if (this->getMaxIterations() <= 0) {
            throw Error(Status::InvalidArgument,
                        ("the number of iterations is " + std::to_string(this->getMaxIterations()) +
                         "; it must be at least 1, set by setMaxIterations")
                            .c_str());
        }
    }

    // Hands the data to the fitter, and makes the model that getModel gives.
    void push()
    {
        detail::check_cloud(*Points::input_);
        Points::initCompute(); // Without indices of the user it makes those of all points, as in PCL.
        if (fitter_has_intrinsics_ && !has_intrinsics_) {
            fitter_ = Fitter(); // Nothing takes the camera of a fitter away.
            fitter_has_intrinsics_ = false;
        }
        fitter_.clear();
        if (has_intrinsics_) {
            fitter_.set_intrinsics(intrinsics_);
            fitter_has_intrinsics_ = true;
        }
        selected_ = Points::indices_;
        if (mask_.data != nullptr) {
            select_in_mask();
        }
        auto model = pcl::make_shared<detail::CylinderModel<PointT, PointNT>>(Points::input_, *selected_);
        double low = 0.0, high = 0.0;
        this->getRadiusLimits(low, high);
        model->setRadiusLimits(low, high);
        model->setAxis(this->getAxis());
        model->setEpsAngle(this->getEpsAngle());
        this->*ModelOfBase::address() = model;
        if (!Points::fake_indices_) {
            push_points(fitter_, *Points::input_, *selected_);
        } else if (mask_.data != nullptr) {
            fitter_.push_points(points_view(*Points::input_), mask_);
        } else {
            fitter_.push_points(points_view(*Points::input_));
        }
        if (!edges_.empty()) {
            fitter_.push_edges(edges_);
        }
        if (image_.data != nullptr) {
            fitter_.push_image(image_);
        }
    }

    void select_in_mask()
    {
        const auto &cloud = *Points::input_;
        if (mask_.width != cloud.width || mask_.height != cloud.height) {
            throw Error(Status::SizeMismatch,
                        ("the mask is " + std::to_string(mask_.width) + " x " + std::to_string(mask_.height) +
                         " but the cloud is " + std::to_string(cloud.width) + " x " + std::to_string(cloud.height) +
                         "; a mask needs an organised cloud of its size")
                            .c_str());
        }
        detail::check_indices(cloud, *Points::indices_);
        selected_ = pcl::make_shared<pcl::Indices>();
        for (const pcl::index_t index : *Points::indices_) {
            if (detail::holds(mask_, std::size_t(index) % cloud.width, std::size_t(index) / cloud.width)) {
                selected_->push_back(index);
            }
        }
    }

    // Random samples, and from where they lead everything together.
    void fit()
    {
        Options options = options_;
        options.ransac_threshold = this->getDistanceThreshold();
        options.ransac_max_iterations = static_cast<std::uint64_t>(this->getMaxIterations());
        set_radius_limits(options);
        set_axis_limit(options);
        fitter_.set_options(options.method(Method::Ransac));
        CylinderFit fit = fitter_.fit();
        if (this->getOptimizeCoefficients()) {
            if (options.near_wall() == NearWall::Auto && !has_intrinsics_) {
                options.near_wall(faces_origin(fit.cylinder.model) ? NearWall::On : NearWall::Off);
            }
            fitter_.set_start_model(fit.cylinder.model);
            fitter_.set_options(options.method(Method::Fused).start(Start::Model));
            fit = fitter_.fit();
        }
        fit_ = fit;
    }

    // As floats inside the limits, so that PCL finds the rounded radius inside them too.
    void set_radius_limits(Options &options)
    {
        double low = 0.0, high = 0.0;
        this->getRadiusLimits(low, high);
        constexpr double NO_LIMIT = std::numeric_limits<double>::max();
        if (!(high > 0.0)) {
            throw Error(Status::InvalidArgument,
                        ("the largest radius is " + detail::number(high) +
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
            throw Error(Status::InvalidArgument,
                        "there is an angle but the axis is 0 0 0; set the axis by setAxis, or setEpsAngle(0)");
        }
        constexpr double ROUNDING = 2.0 * std::numeric_limits<float>::epsilon();
        for (int k = 0; k < 3; ++k) {
            options.axis[k] = limited ? double(middle[k]) : 0.0;
        }
        options.axis_max_angle = limited ? std::acos(std::min(1.0, std::cos(largest) + ROUNDING)) : 0.0;
    }

    // Whether the points near the surface lie on the side of it that the origin sees. As in PCL's estimation of normals
    // the viewpoint is the sensor origin of the cloud; the rule of the library knows the origin only.
    bool faces_origin(const Cylinder &model) const
    {
        // Half way between a cloud from one side, 1, and one from all around, 1/2.
        constexpr double ONE_SIDED = 0.75;
        if (!Points::input_->sensor_origin_.template head<3>().isZero()) {
            return false;
        }
        pcl::Indices near;
        detail::within_distance(*Points::input_, *selected_, model, this->getDistanceThreshold(),
                                [&](std::size_t position, double) { near.push_back((*selected_)[position]); });
        if (near.empty()) {
            return false;
        }
        Fitter of_surface;
        push_points(of_surface, *Points::input_, near);
        of_surface.set_options(Options().near_wall(NearWall::On));
        Result result; // Not there, and NaN, where the rule cannot hold.
        return cylfuse_fitter_evaluate(of_surface.handle(), &model, &result, nullptr) == CYLFUSE_STATUS_OK &&
               result.near_wall_fraction >= ONE_SIDED;
    }

    // The class between makes the member of its base private.
    struct ModelOfBase : pcl::SACSegmentation<PointT> {
        static auto address() { return &ModelOfBase::model_; }
    };

    Fitter fitter_;
    Options options_;
    Intrinsics intrinsics_;
    bool has_intrinsics_ = false;
    bool fitter_has_intrinsics_ = false;
    ImageView image_;
    MaskView mask_;
    std::vector<std::array<double, 4>> edges_;
    pcl::IndicesPtr selected_;
    CylinderFit fit_;
    Error error_{Status::Ok};
};

} // inline namespace
} // namespace cylfuse

#endif

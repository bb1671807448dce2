/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file pcl_detection.hpp
 * A class in the manner of PCL that finds all cylinders of a cloud. Include pcl.hpp.
 */

#ifndef CYLFUSE_PCL_DETECTION_HPP
#define CYLFUSE_PCL_DETECTION_HPP

#include <cylfuse/pcl.hpp>

#include <pcl/common/point_tests.h>
#include <pcl/console/print.h>
#include <pcl/pcl_base.h>

namespace cylfuse {
inline namespace with_exceptions {

/**
 * Finds all cylinders of a cloud, organised or not, and fits each: in place of normals, planes that are taken out,
 * clusters, and a segmentation of each. It is used like pcl::OrganizedMultiPlaneSegmentation.
 *
 * Only points with the indices that were set take part, if there are any. It is looked at from where
 * one sensor has seen it, in its origin or where the densities of the points tell; other clouds are looked at from all
 * sides, which takes about ten times as long.
 * The ends of each cylinder are those of its points. With setIntrinsics the cloud must be organised and in the frame of
 * that camera: pixel and point go together then, its pixels tell where the ends are, and with setImage the limbs are located
 * in the image.
 *
 * Where it cannot search `segment` does what PCL does: it prints why and leaves its outputs empty. getError() has the
 * status and the text. A scene without any cylinder is no error. What a callback throws leaves `segment`, unless it is a
 * cylfuse::Error, which is such an error.
 *
 * @tparam PointT any type of points with float x, y, z
 */
template <class PointT>
class CylinderDetection : public pcl::PCLBase<PointT> {
    using Points = pcl::PCLBase<PointT>;

public:
    /** The settings of the search: limits of radius and axis, most cylinders, least score, threads. */
    void setOptions(const DetectorOptions &options) { options_ = options; }
    /** The settings of the search. */
    const DetectorOptions &getOptions() const { return options_; }
    /** The settings of the fits, such as the noise of the depth; limits, start and threads stay at their defaults there. */
    void setFitOptions(const Options &options) { fit_options_ = options; }
    /** The settings of the fits. */
    const Options &getFitOptions() const { return fit_options_; }
    /**
     * The callback for the progress of `segment`; an empty one takes it away. During `segment` it throws an Error with
     * Status::Busy, and the earlier callback stays.
     */
    void setProgress(DetectionCallback callback) { detector_.set_progress(std::move(callback)); }
    /**
     * Asks the search and the fits of a `segment` that is running to stop, from any thread and from the callback: its outputs
     * are empty then, and the status of getError() is Status::Cancelled. While nothing is searched it does nothing.
     */
    void cancel() { detector_.cancel(); }
    /** The camera in whose frame and pixels the organised cloud is. */
    void setIntrinsics(const cylfuse_intrinsics &intrinsics)
    {
        static_cast<cylfuse_intrinsics &>(intrinsics_) = intrinsics;
        has_intrinsics_ = true;
    }
    /** Takes the camera away: the cloud is searched as one without. */
    void clearIntrinsics() { has_intrinsics_ = false; }
    /**
     * The image of that camera, in which the limbs are located; must stay until `segment`. Without setIntrinsics nothing
     * looks at it. An empty view, `setImage({})`, takes it away.
     */
    void setImage(const ImageView &image) { image_ = image; }

    /**
     * Finds all cylinders, the highest score first.
     *
     * @param coefficients point on the axis, direction and radius of each cylinder
     * @param inliers the indices of its points in the cloud
     */
    void segment(std::vector<pcl::ModelCoefficients> &coefficients, std::vector<pcl::PointIndices> &inliers)
    {
        coefficients.clear();
        inliers.clear();
        error_ = Error(Status::Ok);
        try {
            const std::vector<float> used = detect();
            for (const Detection &detection : detector_.detections()) {
                const std::vector<std::uint32_t> region = detector_.indices(coefficients.size());
                coefficients.push_back(to_coefficients(detection.model));
                coefficients.back().header = Points::input_->header;
                inliers.emplace_back();
                inliers.back().header = Points::input_->header;
                for (const std::uint32_t index : region) {
                    // Of a camera's image it holds the pixels inside the outline that measured nothing, too.
                    if (used[index] > 0.0F && pcl::isFinite((*Points::input_)[index])) {
                        inliers.back().indices.push_back(pcl::index_t(index));
                    }
                }
            }
        } catch (const Error &error) {
            error_ = error;
            coefficients.clear();
            inliers.clear();
            PCL_ERROR("[cylfuse::CylinderDetection::segment] %s\n", error.what());
        }
    }

    /** Why the last `segment` could not search; its status is Status::Ok when it could. */
    const Error &getError() const { return error_; }
    /**
     * The detector with what the last `segment` that could search found: scores, deviations, ends, fitters. After one that
     * could not it still has the scene before.
     */
    const Detector &getDetector() const { return detector_; }

private:
    // Searches, and gives 1 for each point that takes part and 0 for the others.
    std::vector<float> detect()
    {
        if (!Points::input_) {
            throw Error(Status::BadState, "segment needs a cloud; call setInputCloud first");
        }
        const pcl::PointCloud<PointT> &cloud = *Points::input_;
        detail::check_cloud(cloud);
        Points::initCompute(); // Without indices of the user it makes those of all points, as in PCL.
        detail::check_indices(cloud, *Points::indices_);
        std::vector<float> used(cloud.size(), 0.0F);
        for (const pcl::index_t index : *Points::indices_) {
            used[std::size_t(index)] = 1.0F;
        }
        detector_.set_options(options_);
        detector_.set_fit_options(fit_options_);
        if (has_intrinsics_) {
            detector_.detect(frame(used));
        } else {
            // Points that were not selected stay in their places and count nothing.
            PointsView points = points_view(cloud);
            points.weights = used.data();
            detector_.detect_points(points);
        }
        return used;
    }

    // The used points of the cloud as a depth image.
    Frame frame(const std::vector<float> &used) const
    {
        const pcl::PointCloud<PointT> &cloud = *Points::input_;
        if (cloud.width != intrinsics_.width || cloud.height != intrinsics_.height) {
            throw Error(Status::SizeMismatch,
                        ("the cloud is " + std::to_string(cloud.width) + " x " + std::to_string(cloud.height) +
                         " but the intrinsics are for " + std::to_string(intrinsics_.width) + " x " +
                         std::to_string(intrinsics_.height) + "; the cloud must be organised in the pixels of the camera")
                            .c_str());
        }
        std::vector<float> depths(cloud.size());
        for (std::size_t k = 0; k < depths.size(); ++k) {
            depths[k] = used[k] > 0.0F ? cloud[k].z : 0.0F;
        }
        Frame frame;
        frame.set_intrinsics(intrinsics_);
        frame.set_depth(DepthView(depths.data(), cloud.width, cloud.height, 1.0));
        if (image_.data != nullptr) {
            frame.set_image(image_);
        }
        return frame;
    }

    DetectorOptions options_;
    Options fit_options_;
    Intrinsics intrinsics_;
    bool has_intrinsics_ = false;
    ImageView image_;
    Detector detector_;
    Error error_{Status::Ok};
};

} // inline namespace
} // namespace cylfuse

#endif

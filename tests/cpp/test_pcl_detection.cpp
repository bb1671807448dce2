// All cylinders of a cloud of PCL.
#include "pair.hpp"

#include <cylfuse/pcl.hpp>

template <class PointT>
static void all_cylinders_of_a_cloud()
{
    const Pair pair;
    const typename pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>(160, 120));
    for (std::size_t k = 0; k < cloud->size(); ++k) {
        const std::array<float, 3> p = pair.point(k);
        (*cloud)[k].x = p[0], (*cloud)[k].y = p[1], (*cloud)[k].z = p[2];
    }
    // In the middle of the first cylinder nothing was measured.
    const pcl::index_t hole = 59 * 160 + 50;
    (*cloud)[std::size_t(hole)].x = (*cloud)[std::size_t(hole)].y = (*cloud)[std::size_t(hole)].z = NAN;
    cloud->is_dense = false;
    cloud->header.frame_id = "camera";
    std::vector<pcl::ModelCoefficients> coefficients;
    std::vector<pcl::PointIndices> inliers;
    // As a bare cloud, organised or not, then in the pixels of its camera without image and with it.
    for (int kind = 0; kind < 4; ++kind) {
        cylfuse::CylinderDetection<PointT> detection;
        cloud->width = kind == 1 ? 160 * 120 : 160;
        cloud->height = kind == 1 ? 1 : 120;
        detection.setInputCloud(cloud);
        if (kind >= 2) {
            detection.setIntrinsics(pair.camera);
        }
        if (kind == 3) {
            detection.setImage(pair.image_view());
        }
        detection.segment(coefficients, inliers);
        CHECK(detection.getError().status() == cylfuse::Status::Ok);
        if (!CHECK(coefficients.size() == 2 && inliers.size() == 2)) {
            continue;
        }
        const double tolerance = kind == 3 ? 0.01 : 0.1;
        CHECK(which(cylfuse::to_cylinder(coefficients[0]), tolerance) +
                  which(cylfuse::to_cylinder(coefficients[1]), tolerance) == 1);
        CHECK(coefficients[1].header.frame_id == "camera" && inliers[1].header.frame_id == "camera");
        const std::vector<std::uint16_t> labels = detection.getDetector().labels();
        for (std::size_t k = 0; k < 2; ++k) {
            CHECK(inliers[k].indices.size() > 300);
            CHECK(inliers[k].indices.size() <= detection.getDetector().detections()[k].pixels);
            for (const pcl::index_t index : inliers[k].indices) {
                CHECK(labels[std::size_t(index)] == k + 1 && index != hole);
            }
        }
        // Only the points that were selected.
        const auto left = pcl::make_shared<pcl::Indices>();
        for (pcl::index_t k = 0; k < 160 * 120; ++k) {
            if (k % 160 < 90) {
                left->push_back(k);
            }
        }
        detection.setIndices(left);
        detection.segment(coefficients, inliers);
        if (CHECK(coefficients.size() == 1)) {
            CHECK(which(cylfuse::to_cylinder(coefficients[0]), 0.1) == 0);
            for (const pcl::index_t index : inliers[0].indices) {
                CHECK(index % 160 < 90);
            }
        }
    }
}

static void bad_input_of_a_detection_is_named()
{
    using Cloud = pcl::PointCloud<pcl::PointXYZ>;
    std::vector<pcl::ModelCoefficients> coefficients;
    std::vector<pcl::PointIndices> inliers;
    cylfuse::CylinderDetection<pcl::PointXYZ> detection;
    const auto fails = [&] {
        coefficients.resize(1);
        inliers.resize(1);
        detection.segment(coefficients, inliers);
        CHECK(coefficients.empty() && inliers.empty());
        if (detection.getError().status() != cylfuse::Status::Ok) {
            throw detection.getError();
        }
    };
    CHECK_ERROR(fails(), BAD_STATE, "setInputCloud");
    detection.setInputCloud(Cloud::Ptr(new Cloud));
    CHECK_ERROR(fails(), INVALID_ARGUMENT, "the cloud is empty");
    detection.setInputCloud(Cloud::Ptr(new Cloud(10, 10, pcl::PointXYZ(NAN, NAN, NAN))));
    fails(); // Nothing is there, which is no error.
    detection.setIndices(pcl::IndicesPtr(new pcl::Indices{5, 100}));
    CHECK_ERROR(fails(), INVALID_ARGUMENT, "index 100 at position 1");
    detection.setIndices(pcl::IndicesPtr());
    cylfuse::DetectorOptions options;
    options.min_score = -1.0;
    detection.setOptions(options);
    CHECK_ERROR(fails(), INVALID_ARGUMENT, "options.min_score");
    detection.setOptions(cylfuse::DetectorOptions());
    detection.setIntrinsics(Scene().camera);
    CHECK_ERROR(fails(), SIZE_MISMATCH, "the cloud is 10 x 10 but the intrinsics are for 160 x 120");
}

int main()
{
    all_cylinders_of_a_cloud<pcl::PointXYZ>();
    all_cylinders_of_a_cloud<pcl::PointXYZRGBNormal>();
    bad_input_of_a_detection_is_named();
    return finish("PCL, detection");
}

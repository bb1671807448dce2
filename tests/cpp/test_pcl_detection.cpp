// All cylinders of a cloud of PCL, and what is set in the classes for PCL and taken away again.
#include "pair.hpp"

#include <cylfuse/pcl.hpp>

#include <stdexcept>

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

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
        const cylfuse::EndSource ends = detection.getDetector().extent(0).end_source();
        CHECK((ends == cylfuse::EndSource::Points) == (kind < 2));
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

static Cloud::Ptr cloud_of(const Pair &pair)
{
    const Cloud::Ptr cloud(new Cloud(160, 120));
    for (std::size_t k = 0; k < cloud->size(); ++k) {
        const std::array<float, 3> p = pair.point(k);
        (*cloud)[k] = pcl::PointXYZ(p[0], p[1], p[2]);
    }
    return cloud;
}

static void fits_and_progress_can_be_set()
{
    const Pair pair;
    std::vector<pcl::ModelCoefficients> coefficients;
    std::vector<pcl::PointIndices> inliers;
    cylfuse::CylinderDetection<pcl::PointXYZ> detection;
    detection.setInputCloud(cloud_of(pair));
    detection.setIntrinsics(pair.camera);
    const auto deviation = [&] {
        detection.segment(coefficients, inliers);
        return CHECK(coefficients.size() == 2) ? detection.getDetector().fit(0).cylinder.radius_deviation : 0.0;
    };
    const double before = deviation();
    cylfuse::Options options = detection.getFitOptions();
    options.depth_shared = 0.05; // 5 % of the distance in place of 0.2.
    detection.setFitOptions(options);
    CHECK(detection.getFitOptions().depth_shared == 0.05 && deviation() > 3.0 * before);
    options.depth_noise = -1.0;
    detection.setFitOptions(options);
    detection.segment(coefficients, inliers);
    CHECK(coefficients.empty() && detection.getError().status() == cylfuse::Status::InvalidArgument);
    CHECK(std::string(detection.getError().what()).find("depth_noise") != std::string::npos);
    detection.setFitOptions(cylfuse::Options());
    CHECK(deviation() == before);

    // Stopped by what the callback returns, by cancel, and by what it throws.
    int calls = 0;
    detection.setProgress([&](const cylfuse::DetectionProgress &progress) {
        ++calls;
        CHECK_ERROR(detection.setProgress(nullptr), BUSY, "");
        return progress.current_phase() == cylfuse::DetectionPhase::Search;
    });
    detection.segment(coefficients, inliers);
    CHECK(calls > 1 && coefficients.empty() && inliers.empty());
    CHECK(detection.getError().status() == cylfuse::Status::Cancelled);
    // What could not be searched leaves what was found before.
    CHECK(detection.getDetector().count() == 2);
    detection.setProgress([&](const cylfuse::DetectionProgress &) {
        detection.cancel();
        return true;
    });
    detection.segment(coefficients, inliers);
    CHECK(coefficients.empty() && detection.getError().status() == cylfuse::Status::Cancelled);
    detection.setProgress([](const cylfuse::DetectionProgress &) -> bool { throw std::runtime_error("from the callback"); });
    std::string caught;
    try {
        detection.segment(coefficients, inliers);
    } catch (const std::runtime_error &error) {
        caught = error.what();
    }
    CHECK(caught == "from the callback");
    detection.setProgress(nullptr);
    detection.cancel(); // Nothing runs: nothing is cancelled.
    CHECK(deviation() == before);
    detection.setInputCloud(Cloud::Ptr(new Cloud));
    detection.segment(coefficients, inliers);
    CHECK(detection.getError().status() == cylfuse::Status::InvalidArgument && detection.getDetector().count() == 2);
}

static void what_was_set_can_be_taken_away()
{
    const Pair pair;
    std::vector<pcl::ModelCoefficients> all, with, without;
    std::vector<pcl::PointIndices> inliers;
    cylfuse::CylinderDetection<pcl::PointXYZ> detection;
    detection.setInputCloud(cloud_of(pair));
    const auto located = [&] {
        detection.segment(all, inliers);
        return CHECK(all.size() == 2) ? detection.getDetector().fit(0).result.limbs_located : 9;
    };
    const auto ends = [&] { return detection.getDetector().extent(0).end_source(); };
    CHECK(located() == 0 && ends() == cylfuse::EndSource::Points);
    without = all;
    detection.setIntrinsics(pair.camera);
    detection.setImage(pair.image_view());
    CHECK(located() == 2 && ends() != cylfuse::EndSource::Points);
    detection.setImage({});
    CHECK(located() == 0 && ends() != cylfuse::EndSource::Points);
    detection.clearIntrinsics();
    CHECK(located() == 0 && ends() == cylfuse::EndSource::Points && all[1].values == without[1].values);

    const Scene scene;
    const Cloud::Ptr cloud(new Cloud(160, 120));
    for (std::size_t k = 0; k < cloud->size(); ++k) {
        const float z = scene.depth[k] > 0.0F ? scene.depth[k] : NAN;
        (*cloud)[k] = pcl::PointXYZ(float((double(k % 160) - scene.camera.cx) / scene.camera.fx) * z,
                                    float((double(k / 160) - scene.camera.cy) / scene.camera.fy) * z, z);
    }
    cylfuse::CylinderSegmentation<pcl::PointXYZ> segmentation;
    pcl::PointIndices of_one;
    pcl::ModelCoefficients one;
    segmentation.setModelType(pcl::SACMODEL_CYLINDER);
    segmentation.setDistanceThreshold(0.005);
    segmentation.setMaxIterations(1000);
    segmentation.setInputCloud(cloud);
    const auto segments_used = [&] {
        segmentation.segment(of_one, one);
        CHECK(one.values.size() == 7);
        return segmentation.getResult().result.segments_used;
    };
    CHECK(segments_used() == 0);
    const std::vector<float> bare = one.values;
    segmentation.setIntrinsics(scene.camera);
    segmentation.setEdges(scene.edges);
    segmentation.setImage(cylfuse::ImageView(scene.mask.data(), 160, 120));
    segmentation.setMask(scene.mask_view());
    CHECK(segments_used() == 2 && segmentation.getFitter().intrinsics().width == 160);
    segmentation.setEdges({});
    segmentation.setImage({});
    segmentation.setMask({});
    CHECK(segments_used() == 0 && segmentation.getFitter().intrinsics().width == 160);
    segmentation.clearIntrinsics();
    CHECK(segments_used() == 0 && one.values == bare);
    CHECK_ERROR(segmentation.getFitter().intrinsics(), BAD_STATE, "");
    segmentation.setEdges(scene.edges);
    segmentation.segment(of_one, one);
    CHECK(one.values.empty() && segmentation.getError().status() == cylfuse::Status::BadState);
    segmentation.setIntrinsics(scene.camera);
    CHECK(segments_used() == 2);
}

int main()
{
    fits_and_progress_can_be_set();
    what_was_set_can_be_taken_away();
    all_cylinders_of_a_cloud<pcl::PointXYZ>();
    all_cylinders_of_a_cloud<pcl::PointXYZRGBNormal>();
    bad_input_of_a_detection_is_named();
    return finish("PCL, detection");
}

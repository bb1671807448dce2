// PCL in and out, and cross-checks against PCL's own cylinder model.
#include "check.hpp"

#include <cylfuse/pcl.hpp>

#include <pcl/sample_consensus/sac_model_cylinder.h>

#include <random>

double radius_in_another_unit(const pcl::PointCloud<pcl::PointXYZ> &cloud); // second_unit.cpp

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Normals = pcl::PointCloud<pcl::Normal>;

template <class PointT>
static typename pcl::PointCloud<PointT>::Ptr make_cloud(const std::vector<std::array<double, 3>> &points)
{
    const typename pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
    for (const auto &p : points) {
        PointT point;
        point.x = float(p[0]), point.y = float(p[1]), point.z = float(p[2]);
        cloud->push_back(point);
    }
    return cloud;
}

// With the true normals: PCL's estimate of them is not what is compared.
static Normals::Ptr make_normals(const Cloud &cloud)
{
    const Normals::Ptr normals(new Normals);
    for (const auto &p : cloud) {
        const float x = p.x - float(PIPE.point[0]), z = p.z - float(PIPE.point[2]);
        const float norm = std::sqrt(x * x + z * z);
        normals->push_back(pcl::Normal(x / norm, 0.0F, z / norm));
    }
    return normals;
}

static Cloud::Ptr noisy_cloud(double arc, double sigma, unsigned seed)
{
    auto points = pipe_points(50, 20, -arc, arc);
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, sigma);
    for (auto &p : points) {
        for (double &x : p) {
            x += noise(random);
        }
    }
    return make_cloud<pcl::PointXYZ>(points);
}

template <class PointT>
static void any_type_of_points_passes()
{
    const auto cloud = make_cloud<PointT>(pipe_points(30, 20, -1.0, 1.0));
    cloud->width = 20;
    cloud->height = 30;
    (*cloud)[7].x = NAN;
    cloud->is_dense = false;
    cylfuse::Fitter fitter;
    fitter.push_points(cylfuse::points_view(*cloud));
    CHECK(fitter.counts().points_used == 599 && fitter.counts().dropped_not_finite == 1);
    CHECK_NEAR(fitter.fit().cylinder.model.radius, PIPE.radius, 1e-6);

    // Whatever the number of points that are gathered at a time.
    pcl::Indices indices;
    for (int k = 599; k >= 0; k -= 2) {
        indices.push_back(k);
    }
    indices.insert(indices.end(), 2000, 4);
    fitter.clear();
    cylfuse::push_points(fitter, *cloud, indices);
    CHECK(fitter.counts().points_given == 2300 && fitter.counts().points_used == 2299);
    const double first = (*cloud)[599].z;
    const std::vector<double> residuals = fitter.residuals(cylfuse::ResidualKind::Points, PIPE);
    CHECK(residuals.size() == 2299);
    CHECK_NEAR(residuals[0], std::hypot((*cloud)[599].x, first - 0.8) - 0.05, 1e-7);

    const Scene scene;
    fitter.set_intrinsics(scene.camera);
    pcl::PointCloud<PointT> completed;
    completed.resize(2);
    cylfuse::Cylinder flat = PIPE;
    flat.radius = 0.0;
    CHECK_ERROR(cylfuse::complete(fitter, completed, flat, scene.mask_view()), INVALID_ARGUMENT, "radius");
    CHECK(completed.size() == 2); // A call that fails changes nothing.
    const cylfuse::Completion completion = cylfuse::complete(fitter, completed, PIPE, scene.mask_view());
    CHECK(completed.size() == completion.count && completed.width == completion.count && completed.is_dense);
    CHECK_NEAR(std::hypot(completed[0].x, completed[0].z - 0.8), 0.05, 1e-6);

    // In the order of the image; what fails changes nothing.
    CHECK_ERROR(cylfuse::complete_organised(fitter, completed, flat, scene.mask_view()), INVALID_ARGUMENT, "radius");
    CHECK(completed.height == 1 && completed.size() == completion.count);
    completed.header.frame_id = "camera";
    const auto organised = cylfuse::complete_organised(fitter, completed, PIPE, scene.mask_view());
    CHECK(organised.hits == completion.count && completed.width == 160 && completed.height == 120);
    CHECK(!completed.is_dense && completed.header.frame_id == "camera" && std::isnan(completed.at(0, 0).z));
    CHECK_NEAR(completed.at(80, 60).z, scene.depth[60 * 160 + 80], 1e-6);
    CHECK_ERROR(cylfuse::complete_organised(cylfuse::Fitter(), completed, PIPE, scene.mask_view()), BAD_STATE, "intrinsics");
}

static void coefficients_go_both_ways()
{
    const pcl::ModelCoefficients coefficients = cylfuse::to_coefficients({{1, 2, 3}, {0, 0.6, 0.8}, 0.25});
    CHECK((coefficients.values == std::vector<float>{1, 2, 3, 0, 0.6F, 0.8F, 0.25F}));
    const cylfuse::Cylinder model = cylfuse::to_cylinder(coefficients);
    CHECK(model.point[2] == 3.0 && model.direction[1] == double(0.6F) && model.radius == 0.25);
    pcl::ModelCoefficients four;
    four.values = {1, 2, 3, 4};
    CHECK_ERROR(cylfuse::to_cylinder(four), INVALID_ARGUMENT, "4 coefficients; a cylinder has 7");
}

static void settings(pcl::SACSegmentationFromNormals<pcl::PointXYZ, pcl::Normal> &segmentation, const Cloud::Ptr &cloud)
{
    segmentation.setOptimizeCoefficients(true);
    segmentation.setModelType(pcl::SACMODEL_CYLINDER);
    segmentation.setMethodType(pcl::SAC_RANSAC);
    segmentation.setNormalDistanceWeight(0.1);
    segmentation.setMaxIterations(10000);
    segmentation.setDistanceThreshold(0.005);
    segmentation.setInputCloud(cloud);
}

static void the_class_stands_in_for_that_of_pcl()
{
    Cloud::Ptr cloud = make_cloud<pcl::PointXYZ>(pipe_points(30, 20, -1.0, 1.0));
    cloud->header.frame_id = "camera";
    (*cloud)[3].x = NAN;
    (*cloud)[4].x += 0.05F;
    cylfuse::CylinderSegmentation<pcl::PointXYZ> segmentation;
    pcl::SACSegmentation<pcl::PointXYZ> &base = segmentation;
    settings(segmentation, cloud);
    CHECK(segmentation.getMaxIterations() == 10000 && segmentation.getNormalDistanceWeight() == 0.1);
    pcl::PointIndices inliers;
    pcl::ModelCoefficients coefficients;
    base.segment(inliers, coefficients);
    CHECK(inliers.indices.size() == 598 && inliers.indices[3] == 5);
    CHECK(inliers.header.frame_id == "camera" && coefficients.header.frame_id == "camera");
    CHECK(coefficients.values.size() == 7);
    CHECK_NEAR(coefficients.values[6], 0.05, 1e-4);
    CHECK(segmentation.getIndices()->size() == 600);
    CHECK(segmentation.getResult().result.points_used == 599);

    // Only the points with these indices, in their order.
    segmentation.setIndices(pcl::IndicesPtr(new pcl::Indices{500, 5, 4, 3, 100, 200, 300, 400, 17, 230, 599}));
    segmentation.segment(inliers, coefficients);
    CHECK((inliers.indices == pcl::Indices{500, 5, 100, 200, 300, 400, 17, 230, 599}));
    segmentation.setOptimizeCoefficients(false);
    segmentation.setIndices(pcl::IndicesPtr());
    segmentation.segment(inliers, coefficients);
    CHECK_NEAR(coefficients.values[6], 0.05, 1e-3);
}

// What PCL's users ask a model for, without normals.
static void the_model_can_be_used()
{
    const Cloud::Ptr cloud = make_cloud<pcl::PointXYZ>(pipe_points(30, 20, -1.0, 1.0));
    (*cloud)[4].x += 0.05F;
    cylfuse::CylinderSegmentation<pcl::PointXYZ> segmentation;
    settings(segmentation, cloud);
    pcl::PointIndices inliers;
    pcl::ModelCoefficients coefficients;
    segmentation.segment(inliers, coefficients);
    const auto model = segmentation.getModel();
    if (!CHECK(model != nullptr)) {
        return;
    }
    CHECK(model->getModelType() == pcl::SACMODEL_CYLINDER && model->getIndices()->size() == 600);
    const Eigen::VectorXf values = Eigen::Map<const Eigen::VectorXf>(coefficients.values.data(), 7);
    pcl::Indices selected;
    model->selectWithinDistance(values, 0.005, selected);
    CHECK(selected == inliers.indices && model->countWithinDistance(values, 0.005) == selected.size());
    std::vector<double> distances;
    model->getDistancesToModel(values, distances);
    CHECK(distances.size() == 600 && distances[4] > 0.005 && distances[5] < 1e-5);
    Cloud projected;
    model->projectPoints(selected, values, projected, false);
    CHECK(projected.size() == 599);
    // Where there is no cylinder there still is a model.
    cylfuse::CylinderSegmentation<pcl::PointXYZ> failing;
    const Cloud::Ptr few(new Cloud(3, 1));
    settings(failing, few);
    failing.segment(inliers, coefficients);
    CHECK(coefficients.values.empty() && failing.getModel() != nullptr);
    CHECK(failing.getError().status() == cylfuse::Status::TooFewPoints);
}

// Camera, image, edges and mask go into the fit, and the fitter gives what it knows.
static void camera_image_edges_and_mask_count()
{
    const Scene scene;
    const Cloud::Ptr cloud(new Cloud(160, 120));
    std::vector<std::uint8_t> image(160 * 120);
    for (int row = 0; row < 120; ++row) {
        for (int column = 0; column < 160; ++column) {
            const auto pixel = std::size_t(row * 160 + column);
            // A wall 0.3 behind the pipe.
            const float z = scene.depth[pixel] > 0.0F ? scene.depth[pixel] : 1.1F;
            (*cloud)[pixel] = {float((column - scene.camera.cx) / scene.camera.fx) * z,
                               float((row - scene.camera.cy) / scene.camera.fy) * z, z};
            const double inside = std::min(column - scene.edges[0][0], scene.edges[1][0] - column);
            const double part = row > 35 && row < 85 ? 0.5 * (1.0 + std::erf(inside / 0.8)) : 0.0;
            image[pixel] = std::uint8_t(60 + 120 * part);
        }
    }
    cylfuse::CylinderSegmentation<pcl::PointXYZ> segmentation;
    settings(segmentation, cloud);
    segmentation.setIntrinsics(scene.camera);
    segmentation.setImage(cylfuse::ImageView(image.data(), 160, 120));
    segmentation.setEdges(scene.edges);
    segmentation.setMask(scene.mask_view());
    pcl::PointIndices inliers;
    pcl::ModelCoefficients coefficients;
    segmentation.segment(inliers, coefficients);
    if (!CHECK(coefficients.values.size() == 7)) {
        return;
    }
    CHECK_NEAR(coefficients.values[6], PIPE.radius, 1e-4);
    const cylfuse::Result &result = segmentation.getResult().result;
    CHECK(result.segments_given == 2 && result.limbs_located == 2);
    CHECK(inliers.indices.size() == result.points_used);
    for (const pcl::index_t index : inliers.indices) {
        CHECK(scene.mask[std::size_t(index)] != 0);
    }
    CHECK(segmentation.getFitter().point_weights().inliers.size() == result.points_used);
    CHECK_NEAR(segmentation.getFitter().extent({}, scene.mask_view()).length, 0.2, 0.02);
    // Indices and mask together; a mask of another size is refused.
    pcl::IndicesPtr every_other(new pcl::Indices);
    for (pcl::index_t k = 0; k < 160 * 120; k += 2) {
        every_other->push_back(k);
    }
    segmentation.setIndices(every_other);
    segmentation.segment(inliers, coefficients);
    CHECK(!inliers.indices.empty() && inliers.indices.size() == segmentation.getResult().result.points_used);
    segmentation.setMask(cylfuse::MaskView(scene.mask.data(), 160, 60));
    segmentation.segment(inliers, coefficients);
    CHECK(inliers.indices.empty() && segmentation.getError().status() == cylfuse::Status::SizeMismatch);
}

// The origin is taken for the sensor only where the points face it.
static void clouds_in_other_coordinates_fit_too()
{
    const double pi = 3.14159265358979;
    for (const double from : {-1.0, pi - 1.0, 0.5 * pi - 1.0}) {
        cylfuse::CylinderSegmentation<pcl::PointXYZ> segmentation;
        settings(segmentation, make_cloud<pcl::PointXYZ>(pipe_points(30, 20, from, from + 2.0)));
        pcl::PointIndices inliers;
        pcl::ModelCoefficients coefficients;
        segmentation.segment(inliers, coefficients);
        CHECK_NEAR(coefficients.values[6], PIPE.radius, 1e-5);
        CHECK_NEAR(coefficients.values[2], PIPE.point[2], 1e-5);
        CHECK(inliers.indices.size() == 600);
    }
}

static void bad_input_is_named()
{
    pcl::PointIndices inliers;
    pcl::ModelCoefficients coefficients;
    // As from PCL: nothing is thrown, the outputs are empty.
    const auto fails = [&](cylfuse::CylinderSegmentation<pcl::PointXYZ> &segmentation) {
        inliers.indices = {1};
        coefficients.values = {1.0F};
        segmentation.segment(inliers, coefficients);
        CHECK(inliers.indices.empty() && coefficients.values.empty());
        if (segmentation.getError().status() != cylfuse::Status::Ok) {
            throw segmentation.getError();
        }
    };
    const Cloud::Ptr cloud = make_cloud<pcl::PointXYZ>(pipe_points(30, 20, -1.0, 1.0));
    cylfuse::CylinderSegmentation<pcl::PointXYZ> segmentation;
    CHECK_ERROR(fails(segmentation), BAD_STATE, "setInputCloud");
    segmentation.setInputCloud(cloud);
    segmentation.setModelType(pcl::SACMODEL_PLANE);
    CHECK_ERROR(fails(segmentation), UNSUPPORTED, "SACMODEL_CYLINDER");
    segmentation.setModelType(pcl::SACMODEL_CYLINDER);
    CHECK_ERROR(fails(segmentation), INVALID_ARGUMENT, "setDistanceThreshold");
    segmentation.setDistanceThreshold(-1.25e-9);
    CHECK_ERROR(fails(segmentation), INVALID_ARGUMENT, "the distance threshold is -1.25e-09;");
    segmentation.setDistanceThreshold(0.01);
    segmentation.setMaxIterations(0);
    CHECK_ERROR(fails(segmentation), INVALID_ARGUMENT, "setMaxIterations");
    segmentation.setMaxIterations(100);
    segmentation.setIndices(pcl::IndicesPtr(new pcl::Indices{5, 600}));
    CHECK_ERROR(fails(segmentation), INVALID_ARGUMENT, "index 600 at position 1 is outside the cloud; it must lie in 0 to 599");
    segmentation.setIndices(pcl::IndicesPtr(new pcl::Indices{-1}));
    CHECK_ERROR(fails(segmentation), INVALID_ARGUMENT, "index -1");
    segmentation.setIndices(pcl::IndicesPtr(new pcl::Indices));
    CHECK_ERROR(fails(segmentation), INVALID_ARGUMENT, "no indices");
    segmentation.setIndices(pcl::IndicesPtr());
    segmentation.setInputCloud(Cloud::Ptr(new Cloud));
    CHECK_ERROR(fails(segmentation), INVALID_ARGUMENT, "the cloud is empty");
    segmentation.setInputCloud(Cloud::Ptr(new Cloud(10, 10, pcl::PointXYZ(NAN, NAN, NAN))));
    CHECK_ERROR(fails(segmentation), TOO_FEW_POINTS, "0 of 100 points");
    const Cloud::Ptr wrong(new Cloud(*cloud));
    wrong->height = 7;
    segmentation.setInputCloud(wrong);
    CHECK_ERROR(fails(segmentation), SIZE_MISMATCH, "600 x 7 but holds 600");
}

// What PCL keeps from the outside.
struct ModelOfPcl : pcl::SampleConsensusModelCylinder<pcl::PointXYZ, pcl::Normal> {
    using Base = pcl::SampleConsensusModelCylinder<pcl::PointXYZ, pcl::Normal>;
    using Base::Base;
    using Base::isModelValid;
};

static void distances_inliers_and_projection_agree()
{
    const Cloud::Ptr cloud = noisy_cloud(3.0, 0.003, 1);
    std::mt19937 random(2);
    std::uniform_real_distribution<float> anywhere(-3.0F, 3.0F);
    for (int k = 0; k < 500; ++k) {
        cloud->push_back({anywhere(random), anywhere(random), anywhere(random)});
    }
    cylfuse::Fitter fitter;
    const Cloud::Ptr on_pipe = noisy_cloud(3.0, 0.003, 1);
    fitter.push_points(cylfuse::points_view(*on_pipe));
    const pcl::ModelCoefficients coefficients = cylfuse::to_coefficients(fitter.fit().cylinder.model);
    const cylfuse::Cylinder model = cylfuse::to_cylinder(coefficients); // Of the same rounded numbers.
    const Eigen::VectorXf values = Eigen::Map<const Eigen::VectorXf>(coefficients.values.data(), 7);

    ModelOfPcl of_pcl(cloud);
    of_pcl.setInputNormals(make_normals(*cloud));
    of_pcl.setNormalDistanceWeight(0.0);
    of_pcl.setRadiusLimits(0.04, 0.06);
    CHECK(of_pcl.isModelValid(values));
    std::vector<double> theirs, ours(cloud->size());
    of_pcl.getDistancesToModel(values, theirs);
    cylfuse::distances(model, cylfuse::points_view(*cloud), ours);
    double worst = 0.0;
    std::vector<double> tolerance;
    for (std::size_t k = 0; k < cloud->size(); ++k) {
        const auto &p = (*cloud)[k];
        const Eigen::Vector3d offset(p.x - model.point[0], p.y - model.point[1], p.z - model.point[2]);
        tolerance.push_back(1e-6 * (offset.norm() + model.radius));
        worst = std::max(worst, std::abs(std::abs(ours[k]) - theirs[k]) / tolerance[k]);
    }
    std::printf("largest difference of distances: %.2e of (distance to the axis point + radius)\n", 1e-6 * worst);
    CHECK(worst <= 1.0);

    constexpr double THRESHOLD = 0.004;
    pcl::Indices selected;
    of_pcl.selectWithinDistance(values, THRESHOLD, selected);
    std::vector<bool> inside(cloud->size(), false);
    for (const pcl::index_t index : selected) {
        inside[std::size_t(index)] = true;
    }
    std::size_t inliers = 0;
    for (std::size_t k = 0; k < cloud->size(); ++k) {
        const double beyond = std::abs(ours[k]) - THRESHOLD;
        inliers += beyond <= 0.0;
        CHECK((beyond <= 0.0) == inside[k] || std::abs(beyond) <= tolerance[k]);
    }
    CHECK(inliers > 500 && inliers < 1000);

    Cloud projected;
    of_pcl.projectPoints(selected, values, projected, false);
    CHECK(projected.size() == selected.size());
    ours.resize(projected.size());
    cylfuse::distances(model, cylfuse::points_view(projected), ours);
    for (const double distance : ours) {
        CHECK_NEAR(distance, 0.0, 1e-6);
    }
}

// Limits that the data do not keep to hold in what comes out, as PCL reads it.
static void fails(cylfuse::CylinderSegmentation<pcl::PointXYZ> &segmentation, pcl::PointIndices &inliers,
                  pcl::ModelCoefficients &coefficients)
{
    segmentation.segment(inliers, coefficients);
    CHECK(inliers.indices.empty() && coefficients.values.empty());
    throw segmentation.getError();
}

static void limits_hold_as_pcl_checks_them()
{
    const Cloud::Ptr cloud = noisy_cloud(1.5, 0.001, 3);
    const Eigen::Vector3f slanted(0.3F, 1.0F, 0.1F);
    const double angle = std::acos(1.0 / slanted.norm());
    for (const bool optimize : {true, false}) {
        for (const double radius : {0.03, 0.049, 0.051, 0.15}) {
            for (const double part : {0.0, 0.5, 0.99, 1.5}) {
                ModelOfPcl of_pcl(cloud);
                cylfuse::CylinderSegmentation<pcl::PointXYZ> segmentation;
                settings(segmentation, cloud);
                segmentation.setOptimizeCoefficients(optimize);
                const double low = radius < 0.05 ? 0.01 : radius, high = radius < 0.05 ? radius : 0.2;
                segmentation.setRadiusLimits(low, high);
                segmentation.setAxis(slanted);
                segmentation.setEpsAngle(part * angle);
                of_pcl.setRadiusLimits(low, high);
                of_pcl.setAxis(slanted);
                of_pcl.setEpsAngle(part * angle);
                pcl::PointIndices inliers;
                pcl::ModelCoefficients coefficients;
                segmentation.segment(inliers, coefficients);
                CHECK(of_pcl.isModelValid(Eigen::Map<const Eigen::VectorXf>(coefficients.values.data(), 7)));
            }
        }
    }
    cylfuse::CylinderSegmentation<pcl::PointXYZ> segmentation;
    settings(segmentation, cloud);
    pcl::PointIndices inliers;
    pcl::ModelCoefficients coefficients;
    segmentation.setRadiusLimits(0.045, 0.045);
    segmentation.segment(inliers, coefficients);
    CHECK(segmentation.getResult().cylinder.model.radius == 0.045);
    CHECK(segmentation.isAtLimit()); // The pipe has 0.05, and its points say so.
    segmentation.setRadiusLimits(0.05, 0.05);
    segmentation.segment(inliers, coefficients);
    CHECK(!segmentation.isAtLimit());
    // Limits that leave it out, on either side, decide, and that shows.
    for (const bool optimize : {true, false}) {
        segmentation.setOptimizeCoefficients(optimize);
        segmentation.setRadiusLimits(0.06, 0.2);
        segmentation.segment(inliers, coefficients);
        CHECK_NEAR(coefficients.values[6], 0.06, 0.002);
        CHECK(segmentation.isAtLimit());
        segmentation.setRadiusLimits(0.01, 0.04);
        segmentation.segment(inliers, coefficients);
        CHECK_NEAR(coefficients.values[6], 0.04, 0.002);
        CHECK(segmentation.isAtLimit());
        segmentation.setRadiusLimits(0.01, 0.2);
        segmentation.segment(inliers, coefficients);
        CHECK(!segmentation.isAtLimit());
    }
    segmentation.setOptimizeCoefficients(true);
    segmentation.setRadiusLimits(0.05, 0.04);
    CHECK_ERROR(fails(segmentation, inliers, coefficients), INVALID_ARGUMENT, "radius");
    segmentation.setRadiusLimits(-1.0, 0.0);
    CHECK_ERROR(fails(segmentation, inliers, coefficients), INVALID_ARGUMENT, "setRadiusLimits");
    segmentation.setRadiusLimits(-1.0, -2.5e-8);
    CHECK_ERROR(fails(segmentation, inliers, coefficients), INVALID_ARGUMENT, "the largest radius is -2.5e-08;");
    segmentation.setRadiusLimits(0.01, 0.2);
    segmentation.setEpsAngle(0.1);
    CHECK_ERROR(fails(segmentation, inliers, coefficients), INVALID_ARGUMENT, "setAxis");
}

// On clean full and half cylinders both find the same, to what PCL is off.
static void both_find_clean_cylinders()
{
    for (const double arc : {3.1, 1.55}) {
        double their_square = 0.0, our_square = 0.0, apart_square = 0.0;
        constexpr int TRIALS = 8;
        for (unsigned seed = 0; seed < TRIALS; ++seed) {
            const Cloud::Ptr cloud = noisy_cloud(arc, 0.0005, seed);
            pcl::SACSegmentationFromNormals<pcl::PointXYZ, pcl::Normal> theirs;
            cylfuse::CylinderSegmentation<pcl::PointXYZ> ours;
            pcl::PointIndices inliers;
            pcl::ModelCoefficients of_theirs, of_ours;
            settings(theirs, cloud);
            theirs.setInputNormals(make_normals(*cloud));
            theirs.segment(inliers, of_theirs);
            settings(ours, cloud);
            ours.segment(inliers, of_ours);
            const double their_radius = of_theirs.values.at(6), our_radius = of_ours.values.at(6);
            their_square += std::pow(their_radius - PIPE.radius, 2) / TRIALS;
            our_square += std::pow(our_radius - PIPE.radius, 2) / TRIALS;
            apart_square += std::pow(our_radius - their_radius, 2) / TRIALS;
            const double angle =
                cylfuse::compare(cylfuse::to_cylinder(of_theirs), cylfuse::to_cylinder(of_ours)).angle;
            CHECK(angle < 0.005);
        }
        std::printf("arc of %.1f radians, radius error (rms): PCL %.4f mm, cylfuse %.4f mm, apart %.4f mm\n", 2 * arc,
                    1e3 * std::sqrt(their_square), 1e3 * std::sqrt(our_square), 1e3 * std::sqrt(apart_square));
        CHECK(apart_square <= their_square);
    }
}

int main()
{
    any_type_of_points_passes<pcl::PointXYZ>();
    any_type_of_points_passes<pcl::PointXYZRGBNormal>();
    any_type_of_points_passes<pcl::PointXYZI>();
    coefficients_go_both_ways();
    the_class_stands_in_for_that_of_pcl();
    the_model_can_be_used();
    camera_image_edges_and_mask_count();
    clouds_in_other_coordinates_fit_too();
    bad_input_is_named();
    distances_inliers_and_projection_agree();
    limits_hold_as_pcl_checks_them();
    both_find_clean_cylinders();
    CHECK_NEAR(radius_in_another_unit(*make_cloud<pcl::PointXYZ>(pipe_points(30, 20, -1.0, 1.0))), 0.05, 1e-6);
    return finish("PCL");
}

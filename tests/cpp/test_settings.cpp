// Cameras in one expression, settings read back, fitters copied, completion in order, decisions about tolerances.
#include "check.hpp"

#include <limits>
#include <random>

using cylfuse::Conformity;
using cylfuse::Distortion;

static void cameras_in_one_expression()
{
    const cylfuse::Intrinsics opencv(640, 480, 570.0, 571.0, 319.5, 239.5, Distortion::BrownConrady,
                                     {{0.1, -0.2, 0.001, 0.002, 0.05}});
    CHECK(opencv.width == 640 && opencv.height == 480 && opencv.fy == 571.0 && opencv.cx == 319.5);
    CHECK(opencv.distortion_model() == Distortion::BrownConrady && opencv.distortion[1] == -0.2);
    CHECK(opencv.distortion[4] == 0.05 && opencv.distortion[5] == 0.0 && opencv.struct_size == sizeof(cylfuse_intrinsics));
    const cylfuse::Intrinsics fisheye(640, 480, 300.0, 300.0, 319.5, 239.5, Distortion::KannalaBrandt,
                                      {{0.02, -0.01, 0.001, 0.0}});

    // The pixels by the formulas of OpenCV.
    const std::vector<std::array<double, 3>> point = {{{0.3, -0.2, 1.0}}};
    const double x = 0.3, y = -0.2, r2 = x * x + y * y, radial = 1.0 + r2 * (0.1 + r2 * (-0.2 + r2 * 0.05));
    const std::array<double, 2> brown = cylfuse::project(opencv, point)[0];
    CHECK_NEAR(brown[0], 570.0 * (x * radial + 2 * 0.001 * x * y + 0.002 * (r2 + 2 * x * x)) + 319.5, 1e-9);
    CHECK_NEAR(brown[1], 571.0 * (y * radial + 0.001 * (r2 + 2 * y * y) + 2 * 0.002 * x * y) + 239.5, 1e-9);
    const double r = std::sqrt(r2), theta = std::atan(r), t2 = theta * theta;
    const double bent = theta * (1.0 + t2 * (0.02 + t2 * (-0.01 + t2 * 0.001))) / r;
    const std::array<double, 2> kannala = cylfuse::project(fisheye, point)[0];
    CHECK_NEAR(kannala[0], 300.0 * bent * x + 319.5, 1e-9);
    CHECK_NEAR(kannala[1], 300.0 * bent * y + 239.5, 1e-9);

    // What the model does not have is refused where the camera is used.
    cylfuse::Fitter fitter;
    const cylfuse::Intrinsics five(640, 480, 300.0, 300.0, 319.5, 239.5, Distortion::KannalaBrandt,
                                   {{0.02, 0.0, 0.0, 0.0, 0.1}});
    CHECK_ERROR(fitter.set_intrinsics(five), INVALID_INTRINSICS, "distortion[4] is 0.1");
    CHECK_ERROR(fitter.intrinsics(), BAD_STATE, "intrinsics");
    for (const cylfuse::Intrinsics &camera : {opencv, fisheye}) {
        fitter.set_intrinsics(camera);
        const cylfuse::Intrinsics back = fitter.intrinsics();
        CHECK(back.distortion_model() == camera.distortion_model() && back.distortion[1] == camera.distortion[1]);
        CHECK(back.width == 640 && back.height == 480 && back.fx == camera.fx && back.cy == camera.cy);
    }
}

static void clones_go_their_own_way()
{
    const Scene scene;
    cylfuse::Fitter fitter;
    cylfuse::Options options;
    options.max_iterations = 77;
    fitter.set_options(options);
    fitter.set_intrinsics(scene.camera);
    const cylfuse::Fitter settings = fitter.clone();
    fitter.push_depth(scene.depth_view(), scene.mask_view());
    const double radius = fitter.fit().cylinder.model.radius;
    fitter.set_progress([](const cylfuse::Progress &) { return false; });

    cylfuse::Fitter with_data = fitter.clone(), fresh = settings.clone();
    CHECK(with_data.last_fit().cylinder.model.radius == radius && with_data.options().max_iterations == 77);
    CHECK_ERROR(fitter.fit(), CANCELLED, "");
    CHECK(with_data.fit().cylinder.model.radius == radius); // Without the callback.
    CHECK(with_data.extent().length == fitter.extent().length);
    CHECK_ERROR(fresh.last_fit(), BAD_STATE, "");
    CHECK(fresh.options().max_iterations == 77 && fresh.intrinsics().fx == scene.camera.fx);
    fresh.push_depth(scene.depth_view(), scene.mask_view());
    CHECK(fresh.fit().cylinder.model.radius == radius);
    with_data.clear();
    CHECK(with_data.counts().points_given == 0 && fitter.counts().points_given > 0);
    const cylfuse::Fitter gone = std::move(with_data);
    CHECK_ERROR(with_data.clone(), NULL_POINTER, "");
}

static void completion_keeps_the_order_of_the_image()
{
    const Scene scene;
    cylfuse::Fitter fitter;
    fitter.set_intrinsics(scene.camera);
    fitter.push_depth(scene.depth_view(), scene.mask_view());
    fitter.fit();
    std::vector<std::array<float, 3>> points(3, {{1, 2, 3}});
    cylfuse::Cylinder flat = PIPE;
    flat.radius = 0.0;
    CHECK_ERROR(fitter.complete_organised(points, flat), INVALID_ARGUMENT, "radius");
    CHECK(points.size() == 3 && points[2][2] == 3.0F);
    const cylfuse::Completion completion = fitter.complete_organised(points, PIPE);
    CHECK(points.size() == 160 * 120);
    std::size_t there = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        if (scene.mask[k] == 0) {
            CHECK(std::isnan(points[k][0]));
        } else if (CHECK(!std::isnan(points[k][2]))) {
            ++there;
            CHECK_NEAR(points[k][2], scene.depth[k], 1e-6);
        }
    }
    CHECK(completion.count == points.size() && completion.hits == there && there > 1000);
    points.resize(200 * 200); // More than there are pixels.
    fitter.complete_organised(points);
    CHECK(points.size() == 160 * 120);
}

static void tolerances_are_decided()
{
    const cylfuse::ResultFlags none{};
    const cylfuse::Tolerance tolerance(19.5, 20.25);
    CHECK(cylfuse::decide_conformity(20.0, 0.12, none, tolerance) == Conformity::Conforming);
    CHECK(cylfuse::decide_conformity(20.0, 0.13, none, tolerance) == Conformity::Undecided);
    CHECK(cylfuse::decide_conformity(20.0, 0.13, none, {19.5, 20.25, 1.0}) == Conformity::Conforming);
    CHECK(cylfuse::decide_conformity(21.0, 0.3, none, tolerance) == Conformity::NotConforming);
    CHECK(cylfuse::decide_conformity(20.0, 0.12, cylfuse::ResultFlags::PoorFit, tolerance) == Conformity::Undecided);
    const double infinity = std::numeric_limits<double>::infinity();
    CHECK(cylfuse::decide_conformity(20.0, 0.13, none, {-infinity, 21.0}) == Conformity::Conforming);
    CHECK_ERROR(cylfuse::decide_conformity(20.0, 0.1, none, {21.0, 19.0}), INVALID_ARGUMENT, "21 to 19");

    std::vector<std::array<double, 3>> points = pipe_points(60, 30, -1.2, 1.2);
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0.0, 0.001);
    for (std::array<double, 3> &point : points) {
        point[2] += noise(random);
    }
    cylfuse::Fitter fitter;
    fitter.push_points(points);
    const cylfuse::CylinderFit fit = fitter.fit();
    const double r = fit.cylinder.model.radius, s = fit.cylinder.radius_deviation;
    CHECK(s > 0.0 && s < 0.02 * r);
    CHECK(cylfuse::radius_conforms(fit, {r - 2.1 * s, r + 2.1 * s}) == Conformity::Conforming);
    CHECK(cylfuse::radius_conforms(fit, {r - 1.9 * s, r + 2.1 * s}) == Conformity::Undecided);
    CHECK(cylfuse::diameter_conforms(fit, {2 * r - 4.2 * s, 2 * r + 4.2 * s}) == Conformity::Conforming);
    CHECK(cylfuse::diameter_conforms(fit, {2 * r + 4.2 * s, 3 * r}) == Conformity::NotConforming);
    // Without a deviation nothing is decided.
    fitter.set_options(cylfuse::Options().method(cylfuse::Method::Ransac));
    CHECK(cylfuse::radius_conforms(fitter.fit(), {0.0, 1.0}) == Conformity::Undecided);
}

int main()
{
    cameras_in_one_expression();
    clones_go_their_own_way();
    completion_keeps_the_order_of_the_image();
    tolerances_are_decided();
    return finish("settings");
}

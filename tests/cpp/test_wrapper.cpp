// The wrapper with exceptions.
#include "check.hpp"

#include <stdexcept>

static void fits_and_applies()
{
    const Scene scene;
    cylfuse::Fitter fitter;
    fitter.reserve(20000, 2);
    fitter.set_intrinsics(scene.camera);
    fitter.push_depth(scene.depth_view(), scene.mask_view());
    fitter.push_edges(scene.edges);
    CHECK(fitter.counts().segments_given == 2);
    const cylfuse::Result result = fitter.fit();
    CHECK_NEAR(result.model.radius, PIPE.radius, 1e-6);
    CHECK(result.segments_used == 2 && !result.has(CYLFUSE_RESULT_FLAGS_NOT_CONVERGED));
    CHECK(fitter.result().model.radius == result.model.radius);
    CHECK_NEAR(fitter.evaluate(PIPE).point_rms, 0.0, 1e-6);

    std::vector<double> residuals(static_cast<std::size_t>(result.points_used));
    CHECK(fitter.residuals(CYLFUSE_RESIDUAL_KIND_POINTS, residuals) == residuals.size());
    double four[4];
    CHECK(fitter.residuals(CYLFUSE_RESIDUAL_KIND_EDGES, four) == 4);
    CHECK_NEAR(four[3], 0.0, 1e-3);
    CHECK_ERROR(fitter.residuals(CYLFUSE_RESIDUAL_KIND_POINTS, four), BUFFER_TOO_SMALL, "4");
    CHECK(fitter.diagnose().rank == 5);

    std::vector<std::array<float, 3>> completed;
    const cylfuse::Completion completion = fitter.complete(completed);
    CHECK(completed.size() == completion.count && completion.count > 1000);
    std::vector<double> distances(completed.size());
    cylfuse::distances(PIPE, completed, distances);
    for (const double distance : distances) {
        CHECK_NEAR(distance, 0.0, 1e-6);
    }
    std::vector<std::array<double, 3>> organised(160 * 120);
    cylfuse::PointsOut out(organised[0].data(), organised.size());
    out.layout = CYLFUSE_LAYOUT_ORGANISED;
    CHECK(fitter.complete_bound(CYLFUSE_LAYOUT_ORGANISED) == organised.size());
    fitter.complete(out);
    CHECK(std::isnan(organised[0][2]) && std::abs(organised[60 * 160 + 80][2] - 0.75) < 1e-3);
    std::vector<std::uint16_t> depth(160 * 120);
    fitter.complete_depth(cylfuse::DepthOut(depth.data(), 160, 120, 1e-4), &PIPE);
    CHECK_NEAR(depth[60 * 160 + 80], 7500, 2);
    CHECK_NEAR(fitter.extent().length, 0.2, 0.01);

    std::uint8_t limbs[2];
    fitter.select_edges(scene.edges, limbs);
    CHECK(limbs[0] + limbs[1] == 3);
    const cylfuse::LimbLines lines = cylfuse::project(PIPE, scene.camera);
    CHECK_NEAR(std::abs(lines[0][0] * scene.edges[0][0] + lines[0][2]) *
                   std::abs(lines[1][0] * scene.edges[0][0] + lines[1][2]),
               0.0, 1e-9);
    const cylfuse::Difference difference = cylfuse::compare(PIPE, result.model);
    CHECK(difference.angle < 1e-5 && difference.axis_distance < 1e-6);
}

static void images_of_each_type_pass()
{
    const Scene scene;
    cylfuse::Fitter fitter;
    const std::vector<std::uint16_t> grey(160 * 120, 1000);
    CHECK_ERROR(fitter.push_image(cylfuse::ImageView(scene.mask.data(), 160, 120)), BAD_STATE, "intrinsics");
    fitter.set_intrinsics(scene.camera);
    fitter.push_image(cylfuse::ImageView(scene.mask.data(), 160, 120));
    fitter.push_image(cylfuse::ImageView(grey.data(), 160, 120));
    fitter.push_image(cylfuse::ImageView(scene.depth.data(), 160, 120));
    CHECK_ERROR(fitter.push_image(cylfuse::ImageView(grey.data(), 160, 119)), SIZE_MISMATCH, "160 x 119");
    cylfuse::ImageView coded(grey.data(), 160, 120);
    CHECK(coded.gamma == 1.0);
    coded.gamma = 2.2;
    fitter.push_image(coded);
    coded.gamma = 22.0;
    CHECK_ERROR(fitter.push_image(coded), INVALID_ARGUMENT, "gamma of the image is 22");
    cylfuse_limb_sample none[1];
    CHECK_ERROR(fitter.limb_samples(none), BAD_STATE, "fit first");
}

static void keeps_its_settings_and_moves()
{
    cylfuse::Fitter first;
    cylfuse::Options options = first.options();
    CHECK(options.method == CYLFUSE_METHOD_FUSED && options.edge_weight == 0.6);
    options.method = CYLFUSE_METHOD_POINTS;
    first.set_options(options);
    int solves = 0;
    first.set_progress([&](const cylfuse_progress &) { return ++solves > 0; });
    std::vector<std::string> lines;
    first.set_log(CYLFUSE_LOG_LEVEL_INFO, [&](cylfuse_log_level, const char *line) { lines.push_back(line); });

    cylfuse::Fitter second(std::move(first));
    CHECK(first.handle() == nullptr && second.handle() != nullptr);
    CHECK_ERROR(first.clear(), NULL_POINTER, "fitter is NULL");
    second.push_points(pipe_points(20, 10, -1.0, 1.0));
    second.set_start_model(&PIPE);
    second.fit();
    CHECK(solves > 0 && !lines.empty());
    CHECK(second.options().method == CYLFUSE_METHOD_POINTS);

    // A fitter that was given away calls nobody back.
    cylfuse_fitter *raw = second.release();
    const int before = solves;
    cylfuse::Result result;
    CHECK(cylfuse_fitter_fit(raw, &result) == CYLFUSE_STATUS_OK && solves == before);
    const cylfuse::Fitter third(raw);
    CHECK(third.handle() == raw);
}

static void exceptions_of_callbacks_come_out()
{
    cylfuse::Fitter fitter;
    fitter.push_points(pipe_points(20, 10, -1.0, 1.0));
    fitter.set_progress([](const cylfuse_progress &) -> bool { throw std::runtime_error("from the callback"); });
    std::string caught;
    try {
        fitter.fit();
    } catch (const std::runtime_error &error) {
        caught = error.what();
    }
    CHECK(caught == "from the callback");
    fitter.set_progress([](const cylfuse_progress &) { return false; });
    CHECK_ERROR(fitter.fit(), CANCELLED, "cancelled");
    fitter.set_progress(nullptr);
    fitter.cancel();
    CHECK_ERROR(fitter.fit(), CANCELLED, "cancelled");
    CHECK_NEAR(fitter.fit().model.radius, PIPE.radius, 1e-9);
}

static void bad_input_is_named()
{
    cylfuse::Fitter fitter;
    CHECK_ERROR(fitter.fit(), TOO_FEW_POINTS, "0 of 0 points");
    std::vector<std::array<double, 3>> points(10, {NAN, 0.0, 1.0});
    fitter.push_points(points);
    CHECK_ERROR(fitter.fit(), TOO_FEW_POINTS, "0 of 10 points");
    CHECK_ERROR(fitter.push_depth(Scene().depth_view()), BAD_STATE, "set the intrinsics first");
    cylfuse::Options options;
    options.edge_weight = 1.4;
    CHECK_ERROR(fitter.set_options(options), INVALID_ARGUMENT, "1.4; it must lie in [0, 1]");
    cylfuse::Intrinsics camera(640, 480, 0.0, 500.0, 320.0, 240.0);
    CHECK_ERROR(fitter.set_intrinsics(camera), INVALID_INTRINSICS, "fx is 0");
    const Scene scene;
    fitter.set_intrinsics(scene.camera);
    CHECK_ERROR(fitter.push_depth(scene.depth_view(), cylfuse::MaskView(scene.mask.data(), 160, 100)),
                SIZE_MISMATCH, "160 x 100");
    cylfuse::Cylinder flat = PIPE;
    flat.radius = 0.0;
    double out[10];
    CHECK_ERROR(cylfuse::distances(flat, points, out), INVALID_ARGUMENT, "radius is 0; it must be");
    const cylfuse::Error error(CYLFUSE_STATUS_PANIC, std::string(1000, 'x').c_str());
    CHECK(std::string(error.what()).size() == 511);
}

int main()
{
    fits_and_applies();
    images_of_each_type_pass();
    keeps_its_settings_and_moves();
    exceptions_of_callbacks_come_out();
    bad_input_is_named();
    return finish("wrapper");
}

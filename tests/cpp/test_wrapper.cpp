// The wrapper with exceptions.
#include "check.hpp"

#include <future>
#include <memory>
#include <stdexcept>
#include <thread>
#include <type_traits>

using cylfuse::Layout;
using cylfuse::ResidualKind;

// Views of what is about to vanish do not compile.
using Points = std::vector<std::array<double, 3>>;
using Segments = std::vector<std::array<double, 4>>;
static_assert(std::is_constructible<cylfuse::PointsView, const Points &>::value, "a cloud that stays");
static_assert(!std::is_constructible<cylfuse::PointsView, Points>::value, "a cloud that is gone");
static_assert(std::is_constructible<cylfuse::SegmentsView, Segments &>::value, "segments that stay");
static_assert(!std::is_constructible<cylfuse::SegmentsView, Segments>::value, "segments that are gone");
static_assert(!std::is_constructible<cylfuse::SegmentsView, std::array<std::array<float, 4>, 2>>::value, "gone");
static_assert(std::is_constructible<cylfuse::SegmentsView, cylfuse::Span<const std::array<float, 4>>>::value, "a span");
static_assert(std::is_constructible<cylfuse::PointsView, cylfuse::Span<const std::array<float, 3>>>::value, "a span");
static_assert(std::is_constructible<cylfuse::SegmentsView, cylfuse::Span<std::array<double, 4>>>::value, "a span to write");
static_assert(std::is_constructible<cylfuse::PointsView, cylfuse::Span<std::array<double, 3>>>::value, "a span to write");
static_assert(std::is_constructible<cylfuse::Span<const double>, cylfuse::Span<double>>::value, "to be read only");
static_assert(!std::is_constructible<cylfuse::Span<double>, cylfuse::Span<const double>>::value, "not to be written");
static_assert(std::is_constructible<cylfuse::PointsView, const std::array<std::array<double, 3>, 2> &>::value, "stays");
static_assert(!std::is_constructible<cylfuse::PointsView, std::array<std::array<double, 3>, 2>>::value, "gone");
template <class T>
constexpr bool moves_only()
{
    return std::is_nothrow_move_constructible<T>::value && std::is_nothrow_move_assignable<T>::value &&
           !std::is_copy_constructible<T>::value && !std::is_copy_assignable<T>::value;
}
static_assert(moves_only<cylfuse::Fitter>() && moves_only<cylfuse::Frame>() && moves_only<cylfuse::Detector>(), "");

static void fits_and_applies()
{
    const Scene scene;
    cylfuse::Fitter fitter;
    fitter.reserve(20000, 2);
    fitter.set_intrinsics(scene.camera);
    fitter.push_depth(scene.depth_view(), scene.mask_view());
    fitter.push_edges(scene.edges);
    CHECK(fitter.counts().segments_given == 2);
    const cylfuse::CylinderFit fit = fitter.fit();
    CHECK_NEAR(fit.cylinder.model.radius, PIPE.radius, 1e-6);
    CHECK(fit.result.segments_used == 2 && !fit.result.has(cylfuse::ResultFlags::NotConverged));
    CHECK(fit.result.termination() != cylfuse::Termination::None);
    CHECK(fit.cylinder.start_kind() != cylfuse::Start::Auto);
    CHECK(fitter.last_fit().cylinder.model.radius == fit.cylinder.model.radius);
    CHECK(fitter.last_fit().result.points_used == fit.result.points_used);
    CHECK_NEAR(fitter.evaluate(PIPE).result.point_rms, 0.0, 1e-6);
    CHECK(fitter.diagnose().rank == 5 && fitter.diagnose(PIPE).rank == 5);

    std::vector<std::array<float, 3>> completed;
    const cylfuse::Completion completion = fitter.complete(completed);
    CHECK(completed.size() == completion.count && completion.count > 1000);
    std::vector<double> distances(completed.size());
    cylfuse::distances(PIPE, completed, distances);
    for (const double distance : distances) {
        CHECK_NEAR(distance, 0.0, 1e-6);
    }
    std::vector<std::array<double, 3>> organised(160 * 120);
    const cylfuse::PointsOut out(organised[0].data(), organised.size());
    CHECK(fitter.complete_bound(Layout::Organised) == organised.size());
    fitter.complete(out, Layout::Organised);
    CHECK(std::isnan(organised[0][2]) && std::abs(organised[60 * 160 + 80][2] - 0.75) < 1e-3);
    std::vector<std::uint16_t> depth(160 * 120);
    fitter.complete_depth(cylfuse::DepthOut(depth.data(), 160, 120, 1e-4), PIPE);
    CHECK_NEAR(depth[60 * 160 + 80], 7500, 2);
    const cylfuse::Extent extent = fitter.extent();
    CHECK_NEAR(extent.length, 0.2, 0.01);
    CHECK(extent.start_source() == cylfuse::EndSource::Mask && extent.start_state() != cylfuse::EndState::Cut);
    CHECK_NEAR(fitter.extent({}, scene.mask_view()).length, extent.length, 1e-12);
    CHECK_NEAR(fitter.extent(PIPE).length, extent.length, 1e-3);

    std::uint8_t limbs[2];
    fitter.select_edges(scene.edges, limbs);
    CHECK(limbs[0] + limbs[1] == 3);
    const cylfuse::LimbLines lines = cylfuse::project(PIPE, scene.camera);
    CHECK_NEAR(std::abs(lines[0][0] * scene.edges[0][0] + lines[0][2]) *
                   std::abs(lines[1][0] * scene.edges[0][0] + lines[1][2]),
               0.0, 1e-9);
    const cylfuse::Difference difference = cylfuse::compare(PIPE, fit.cylinder.model);
    CHECK(difference.angle < 1e-5 && difference.axis_distance < 1e-6);

    // The camera there and back.
    const std::vector<std::array<double, 2>> pixels = {{{0.0, 0.0}}, {{100.0, 30.5}}};
    const cylfuse::Expectation expected = cylfuse::plan(scene.camera, {{0.7, 0.1, 0.3, 0.0, 0.4}});
    CHECK(expected.scatter[0] > 0.0 && expected.scatter[0] < expected.total[0]);
    std::vector<std::array<double, 3>> rays = cylfuse::unproject(scene.camera, pixels);
    CHECK(rays.size() == 2 && rays[1][2] == 1.0);
    rays.push_back({{0.0, 0.0, -1.0}});
    const std::vector<std::array<double, 2>> back = cylfuse::project(scene.camera, rays);
    CHECK(back.size() == 3 && std::isnan(back[2][0]));
    CHECK_NEAR(back[1][0], 100.0, 1e-9);
    CHECK_NEAR(back[1][1], 30.5, 1e-9);
}

// A pipe that is brighter than what is behind it, with soft limbs.
static std::vector<std::uint8_t> bright_pipe(const Scene &scene)
{
    std::vector<std::uint8_t> image(160 * 120 * 3);
    for (int row = 0; row < 120; ++row) {
        for (int column = 0; column < 160; ++column) {
            const double inside = std::min(column - scene.edges[0][0], scene.edges[1][0] - column);
            const double part = row > 35 && row < 85 ? 0.5 * (1.0 + std::erf(inside / 0.8)) : 0.0;
            for (int channel = 0; channel < 3; ++channel) {
                image[std::size_t(3 * (row * 160 + column) + channel)] = std::uint8_t(60 + 120 * part);
            }
        }
    }
    return image;
}

// However many there are, and the number that is needed where a buffer is too small.
static void lists_come_whole()
{
    const Scene scene;
    const std::vector<std::uint8_t> colours = bright_pipe(scene);
    cylfuse::Fitter fitter;
    fitter.set_intrinsics(scene.camera);
    fitter.push_depth(scene.depth_view(), scene.mask_view());
    fitter.push_edges(scene.edges);
    fitter.push_image(cylfuse::ImageView(colours.data(), cylfuse::ImageFormat::Rgb8, 160, 120));
    const cylfuse::CylinderFit fit = fitter.fit();
    const auto used = static_cast<std::size_t>(fit.result.points_used);
    CHECK(fit.result.limbs_located == 2);

    std::vector<double> residuals(used);
    CHECK(fitter.residuals(ResidualKind::Points, residuals) == used);
    CHECK(fitter.residuals(ResidualKind::Points) == residuals);
    CHECK(fitter.residuals(ResidualKind::Points, PIPE).size() == used);
    double four[4];
    CHECK(fitter.residuals(ResidualKind::Edges, four) == 4);
    CHECK_NEAR(four[3], 0.0, 1e-2);
    CHECK_ERROR(fitter.residuals(ResidualKind::Points, four), BUFFER_TOO_SMALL, "4");

    const cylfuse::PointWeights weights = fitter.point_weights();
    CHECK(weights.weights.size() == used && weights.inliers.size() == used);
    CHECK(weights.inliers[used / 2] == 1 && weights.weights[used / 2] > 0.0);
    std::vector<double> only_weights(used);
    std::vector<std::uint8_t> only_inliers(used + 3);
    CHECK(fitter.point_weights(only_weights) == used && only_weights == weights.weights);
    only_weights.assign(used, -1.0);
    CHECK(fitter.point_weights({}, only_inliers) == used);
    only_inliers.resize(used);
    CHECK(only_inliers == weights.inliers);
    only_inliers.assign(used, 7);
    CHECK(fitter.point_weights(only_weights, only_inliers) == used);
    CHECK(only_weights == weights.weights && only_inliers == weights.inliers);

    const std::vector<cylfuse::Part> parts = fitter.point_parts();
    CHECK(parts.size() == used && parts[used / 2] == cylfuse::Part::Body);
    CHECK(fitter.point_parts(PIPE).size() == used);
    std::vector<cylfuse::Part> same_parts(used, cylfuse::Part::Behind);
    CHECK(fitter.point_parts(same_parts) == used && same_parts == parts);
    CHECK(fitter.point_parts(same_parts, PIPE) == used);
    const std::vector<cylfuse::Limb> limbs = fitter.limbs();
    CHECK(limbs.size() == 2 && limbs[1].limb == 1 && limbs[1].status() == cylfuse::LimbStatus::Located);
    std::array<cylfuse::Limb, 3> same_limbs;
    CHECK(fitter.limbs(same_limbs) == 2 && same_limbs[1].samples == limbs[1].samples);
    const std::vector<cylfuse::LimbSample> samples = fitter.limb_samples();
    CHECK(samples.size() == limbs[0].samples + limbs[1].samples && samples.size() > 4);
    cylfuse::LimbSample one[1];
    std::size_t needed = 0;
    try {
        fitter.limb_samples(one);
    } catch (const cylfuse::Error &error) {
        CHECK(error.status() == cylfuse::Status::BufferTooSmall);
        needed = error.needed();
    }
    CHECK(needed == samples.size());
    const std::vector<cylfuse::EndSample> ends = fitter.end_samples();
    for (const cylfuse::EndSample &sample : ends) {
        CHECK(sample.end < 2 && sample.deviation > 0.0);
    }
    std::vector<cylfuse::EndSample> same_ends(ends.size() + 1);
    CHECK(!ends.empty() && fitter.end_samples(same_ends) == ends.size());
    CHECK(same_ends[0].pixel[0] == ends[0].pixel[0] && same_ends[ends.size() - 1].pixel[1] == ends.back().pixel[1]);
    CHECK(fitter.end_samples({}, scene.mask_view()).size() == fitter.end_samples(same_ends, {}, scene.mask_view()));
}

// The same pipe from a second camera half a turn around it, and from a frame that two fitters share.
static void views_and_frames()
{
    const Scene scene;
    const std::vector<std::uint8_t> colours = bright_pipe(scene);
    cylfuse::Fitter fitter;
    CHECK(fitter.view_count() == 1);
    fitter.set_intrinsics(scene.camera);
    fitter.push_depth(scene.depth_view(), scene.mask_view());
    fitter.select_view(1);
    CHECK(fitter.view_count() == 2);
    cylfuse::RigidMotion behind;
    behind.rotation = {{-1, 0, 0, 0, 1, 0, 0, 0, -1}};
    behind.translation = {{0, 0, 1.6}};
    fitter.set_pose(behind);
    fitter.set_intrinsics(scene.camera);
    fitter.push_depth(scene.depth_view(), scene.mask_view());
    const cylfuse::CylinderFit both = fitter.fit();
    CHECK_NEAR(both.cylinder.model.radius, PIPE.radius, 1e-6);
    CHECK_NEAR(both.cylinder.model.point[2], PIPE.point[2], 1e-6);
    CHECK(both.result.points_used == 2 * fitter.residuals(ResidualKind::Points).size());
    CHECK_ERROR(fitter.select_view(3), INVALID_ARGUMENT, "3");
    behind.rotation[0] = 1.0;
    CHECK_ERROR(fitter.set_pose(behind), INVALID_ARGUMENT, "rotation");
    // The depth camera a little beside: all points and the result move with it.
    fitter.select_view(0);
    fitter.clear();
    cylfuse::RigidMotion beside;
    beside.translation = {{0.02, 0.0, 0.0}};
    fitter.set_depth_camera(scene.camera, beside);
    fitter.push_depth(scene.depth_view());
    CHECK_NEAR(fitter.fit().cylinder.model.point[0], 0.02, 1e-6);
    fitter.clear_input(cylfuse::Input::Points | cylfuse::Input::Depth);
    fitter.clear_depth_camera();
    CHECK_ERROR(fitter.fit(), TOO_FEW_POINTS, "0 of 0 points");

    cylfuse::Frame frame;
    CHECK_ERROR(frame.set_depth(scene.depth_view()), BAD_STATE, "intrinsics");
    frame.set_intrinsics(scene.camera);
    frame.set_depth(scene.depth_view());
    frame.set_image(cylfuse::ImageView(colours.data(), cylfuse::ImageFormat::Bgr8, 160, 120));
    frame.set_pose(cylfuse::RigidMotion());
    const cylfuse::Frame moved(std::move(frame));
    CHECK_ERROR(frame.set_depth(scene.depth_view()), NULL_POINTER, "frame");
    for (int k = 0; k < 2; ++k) {
        cylfuse::Fitter one;
        one.use_frame(moved, scene.mask_view());
        CHECK_NEAR(one.fit().cylinder.model.radius, PIPE.radius, 1e-3);
    }
    const std::vector<std::uint8_t> nothing(160 * 120, 0);
    CHECK_ERROR(fitter.use_frame(moved, cylfuse::MaskView(nothing.data(), 160, 120)), EMPTY_MASK, "mask");
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
    const std::vector<std::uint8_t> colours(160 * 120 * 4, 100);
    for (const auto format : {cylfuse::ImageFormat::Rgb8, cylfuse::ImageFormat::Bgr8, cylfuse::ImageFormat::Rgba8,
                              cylfuse::ImageFormat::Bgra8}) {
        fitter.push_image(cylfuse::ImageView(colours.data(), format, 160, 120));
    }
    CHECK_ERROR(fitter.limb_samples(), BAD_STATE, "fit first");
    CHECK_ERROR(fitter.point_weights(), BAD_STATE, "fit");
    CHECK_ERROR(fitter.point_parts(), BAD_STATE, "fit");
}

static void keeps_its_settings_and_moves()
{
    const Points points = pipe_points(20, 10, -1.0, 1.0);
    cylfuse::Fitter first;
    cylfuse::Options options = first.options();
    CHECK(options.method() == cylfuse::Method::Fused && options.edge_weight == 0.6 && options.edge_noise == 0.0);
    options.method(cylfuse::Method::Points).chart(cylfuse::Chart::Local);
    options.edge_noise = 0.25;
    first.set_options(options);
    int solves = 0;
    first.set_progress([&](const cylfuse::Progress &progress) {
        // As a number and as a constant.
        CHECK(progress.phase == CYLFUSE_PHASE_START || progress.current_phase() == cylfuse::Phase::Solve);
        CHECK(progress.struct_size == sizeof(cylfuse_progress));
        CHECK((progress.cylinder != nullptr) == (progress.current_phase() == cylfuse::Phase::Solve));
        solves += progress.current_phase() == cylfuse::Phase::Solve && progress.max_iterations > 0;
        return true;
    });
    std::vector<std::string> lines;
    first.set_log(cylfuse::LogLevel::Info, [&](cylfuse::LogLevel, const char *line) { lines.push_back(line); });

    cylfuse::Fitter second(std::move(first));
    CHECK(first.handle() == nullptr && second.handle() != nullptr);
    CHECK_ERROR(first.clear(), NULL_POINTER, "fitter is NULL");
    second.push_points(points);
    second.set_start_model(PIPE);
    second.fit();
    CHECK(solves > 0 && !lines.empty());
    CHECK(second.options().method() == cylfuse::Method::Points && second.options().edge_noise == 0.25);
    second.set_start_model({});

    // A fitter that was given away calls nobody back.
    cylfuse_fitter *raw = second.release();
    const int before = solves;
    CHECK(cylfuse_fitter_fit(raw, nullptr, nullptr) == CYLFUSE_STATUS_OK && solves == before);
    cylfuse::Fitter third(raw);
    CHECK(third.handle() == raw);
    third = cylfuse::Fitter();
    CHECK(third.handle() != raw && third.counts().points_given == 0);
}

// What a callback holds must live as long as the library may call it.
static void a_running_callback_is_not_replaced()
{
    const Points points = pipe_points(20, 10, -1.0, 1.0);
    cylfuse::Fitter fitter;
    fitter.push_points(points);
    // From inside: the closure that runs holds the last reference to the witness.
    auto witness = std::make_shared<int>(7);
    const std::weak_ptr<int> alive = witness;
    int refused = 0, ran = 0;
    fitter.set_progress([&, held = std::move(witness)](const cylfuse::Progress &) {
        const cylfuse::ProgressCallback stop = [](const cylfuse::Progress &) { return false; };
        for (const auto &other : {cylfuse::ProgressCallback(), stop}) {
            try {
                fitter.set_progress(other);
            } catch (const cylfuse::Error &error) {
                refused += error.status() == cylfuse::Status::Busy;
            }
        }
        CHECK(fitter.release() == nullptr); // Nor given away.
        ran += *held == 7 && !alive.expired();
        return true;
    });
    fitter.fit();
    CHECK(ran > 0 && refused == 2 * ran && !alive.expired());
    CHECK_NEAR(fitter.fit().cylinder.model.radius, PIPE.radius, 1e-9);
    fitter.set_progress(nullptr);
    CHECK(alive.expired());

    // From another thread while a fit runs: it waits in its callback.
    std::promise<void> started, go_on;
    auto other = std::make_shared<int>(8);
    const std::weak_ptr<int> other_alive = other;
    bool first = true;
    fitter.set_progress([&, held = std::move(other)](const cylfuse::Progress &) {
        if (first) {
            first = false;
            started.set_value();
            go_on.get_future().wait();
        }
        return *held == 8;
    });
    std::thread fitting([&] { fitter.fit(); });
    started.get_future().wait();
    CHECK_ERROR(fitter.set_progress([](const cylfuse::Progress &) { return false; }), BUSY, "");
    CHECK_ERROR(fitter.set_log(cylfuse::LogLevel::Debug, [](cylfuse::LogLevel, const char *) {}), BUSY, "");
    CHECK(!other_alive.expired());
    go_on.set_value();
    fitting.join();
    CHECK_NEAR(fitter.last_fit().cylinder.model.radius, PIPE.radius, 1e-9);

    // A log callback replaces none that runs either.
    int lines = 0;
    fitter.set_log(cylfuse::LogLevel::Info, [&](cylfuse::LogLevel, const char *) {
        ++lines;
        CHECK_ERROR(fitter.set_log(cylfuse::LogLevel::Off, nullptr), BUSY, "");
    });
    fitter.fit();
    CHECK(lines > 0);
}

static void exceptions_of_callbacks_come_out()
{
    const Points points = pipe_points(20, 10, -1.0, 1.0);
    cylfuse::Fitter fitter;
    fitter.push_points(points);
    fitter.set_progress([](const cylfuse::Progress &) -> bool { throw std::runtime_error("from the callback"); });
    std::string caught;
    try {
        fitter.fit();
    } catch (const std::runtime_error &error) {
        caught = error.what();
    }
    CHECK(caught == "from the callback");
    fitter.set_progress([](const cylfuse::Progress &) { return false; });
    CHECK_ERROR(fitter.fit(), CANCELLED, "cancelled");
    fitter.set_progress(nullptr);
    fitter.cancel(); // Nothing runs: nothing is cancelled.
    CHECK_NEAR(fitter.fit().cylinder.model.radius, PIPE.radius, 1e-9);
    fitter.set_log(cylfuse::LogLevel::Info,
                   [](cylfuse::LogLevel, const char *) { throw std::logic_error("from the log"); });
    caught.clear();
    try {
        fitter.fit();
    } catch (const std::logic_error &error) {
        caught = error.what();
    }
    CHECK(caught == "from the log");
}

static void bad_input_is_named()
{
    cylfuse::Fitter fitter;
    CHECK_ERROR(fitter.fit(), TOO_FEW_POINTS, "0 of 0 points");
    std::vector<std::array<double, 3>> points(10, {NAN, 0.0, 1.0});
    fitter.push_points(points);
    CHECK_ERROR(fitter.fit(), TOO_FEW_POINTS, "0 of 10 points are usable (10 not finite)");
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
    const cylfuse::Error error(cylfuse::Status::Panic, std::string(1000, 'x').c_str());
    CHECK(std::string(error.what()).size() == 511);
}

static void many_are_fitted_at_once()
{
    const Scene scene;
    const auto fitters_of = [&scene] {
        std::vector<cylfuse::Fitter> fitters(5);
        for (cylfuse::Fitter &fitter : fitters) {
            fitter.set_intrinsics(scene.camera);
            if (&fitter != &fitters[2]) {
                fitter.push_depth(scene.depth_view(), scene.mask_view());
            }
        }
        return fitters;
    };
    cylfuse::Fitter alone = std::move(fitters_of()[0]);
    const cylfuse::CylinderFit expected = alone.fit();
    for (const std::uint32_t threads : {0u, 1u, 3u}) {
        std::vector<cylfuse::Fitter> fitters = fitters_of();
        std::size_t heard = 0;
        const std::vector<cylfuse::Status> statuses =
            cylfuse::fit_all(fitters, threads, [&heard](std::size_t index, cylfuse::Status status) {
                CHECK((status == cylfuse::Status::Ok) == (index != 2));
                ++heard;
                return true;
            });
        CHECK(heard == fitters.size() && statuses.size() == fitters.size());
        for (std::size_t k = 0; k < fitters.size(); ++k) {
            if (k == 2) {
                CHECK(statuses[k] == cylfuse::Status::TooFewPoints);
                CHECK(std::string(fitters[k].last_error()).find("points") != std::string::npos);
            } else {
                CHECK(statuses[k] == cylfuse::Status::Ok);
                CHECK(fitters[k].last_fit().cylinder.model.radius == expected.cylinder.model.radius);
            }
        }
        bool thrown = false;
        try {
            cylfuse::fit_all(fitters, threads,
                             [](std::size_t, cylfuse::Status) -> bool { throw std::runtime_error("heard"); });
        } catch (const std::runtime_error &) {
            thrown = true;
        }
        CHECK(thrown);
    }
    std::vector<cylfuse::Fitter> none;
    CHECK(cylfuse::fit_all(none).empty());
}

int main()
{
    fits_and_applies();
    many_are_fitted_at_once();
    lists_come_whole();
    views_and_frames();
    images_of_each_type_pass();
    keeps_its_settings_and_moves();
    a_running_callback_is_not_replaced();
    exceptions_of_callbacks_come_out();
    bad_input_is_named();
    return finish("wrapper");
}

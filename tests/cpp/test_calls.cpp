// What calls leave behind when they fail, are stopped or throw; data that vanish; texts.
#include "check.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

using Points = std::vector<std::array<double, 3>>;

static Points some_points() { return pipe_points(20, 10, -1.0, 1.0); }

static void constants_have_names()
{
    CHECK(cylfuse::to_string(cylfuse::Status::TooFewPoints) == "TOO_FEW_POINTS");
    CHECK(cylfuse::to_string(cylfuse::Termination::Gradient) == "GRADIENT");
    CHECK(cylfuse::to_string(cylfuse::EndState::Cut) == "CUT");
    CHECK(cylfuse::to_string(cylfuse::EndSource::Image) == "IMAGE");
    CHECK(cylfuse::to_string(cylfuse::LimbStatus::NoEdge) == "NO_EDGE");
    CHECK(cylfuse::to_string(cylfuse::Part::InnerWall) == "INNER_WALL");
    CHECK(cylfuse::to_string(cylfuse::EndState(99)) == "unknown");
    CHECK(cylfuse::to_string(cylfuse::CylinderEstimate().start_kind()) == "AUTO");
    CHECK(cylfuse::to_string(cylfuse::Start::Last) == "LAST" && cylfuse::to_string(cylfuse::Start(-1)) == "unknown");
    CHECK(cylfuse::to_string(cylfuse::Conformity::NotConforming) == "NOT_CONFORMING");
    CHECK(cylfuse::to_string(cylfuse::Conformity(3)) == "unknown");
    CHECK(cylfuse::to_string(cylfuse::Phase::Start) == "START" && cylfuse::to_string(cylfuse::Phase(0)) == "unknown");
    CHECK(cylfuse::to_string(cylfuse::Input::Depth | cylfuse::Input::Image) == "DEPTH, IMAGE");
    CHECK(cylfuse::to_string(cylfuse::Input(0)).empty() && cylfuse::to_string(cylfuse::Input(17)) == "POINTS, unknown");
    CHECK(std::string(cylfuse::describe(cylfuse::EndState::Seen)) == "SEEN: the surface ends there");
    CHECK(std::string(cylfuse::describe(cylfuse::Part::Cap)).find("CAP: ") == 0);
    CHECK(std::string(cylfuse::describe(cylfuse::Start::Limbs)).find("LIMBS: ") == 0);
    CHECK(std::string(cylfuse::describe(cylfuse::Conformity::Undecided)).find("UNDECIDED: ") == 0);
    CHECK(std::string(cylfuse::describe(cylfuse::ResultFlags::WeakRadius)).find("WEAK_RADIUS: ") == 0);

    cylfuse::Result result;
    CHECK(result.warnings().empty() && result.warning_names().empty());
    result.flags = CYLFUSE_RESULT_FLAGS_POOR_FIT | CYLFUSE_RESULT_FLAGS_WEAK_RADIUS | 1u << 31;
    CHECK(result.warning_names() == "WEAK_RADIUS, POOR_FIT, unknown flag");
    const std::vector<std::string> warnings = result.warnings();
    CHECK(warnings.size() == 3 && warnings[0] == "WEAK_RADIUS: the data hardly determine the radius");
}

// What a statement throws, empty for nothing.
template <class Statement>
static std::string thrown_by(Statement statement)
{
    try {
        statement();
    } catch (const std::exception &error) {
        return error.what();
    }
    return "";
}

static void exceptions_leave_the_call_that_they_came_from()
{
    const Points points = some_points();
    cylfuse::Fitter fitter, other;
    fitter.push_points(points);
    fitter.set_progress([](const cylfuse::Progress &) -> bool { throw std::runtime_error("from the callback"); });
    // Nobody can throw it to a caller of the C interface, and no other call does.
    CHECK(cylfuse_fitter_fit(fitter.handle(), nullptr, nullptr) == CYLFUSE_STATUS_CANCELLED);
    CHECK(thrown_by([&] { other.push_points(points); }).empty());
    CHECK(cylfuse_fitter_fit(fitter.handle(), nullptr, nullptr) == CYLFUSE_STATUS_CANCELLED);
    CHECK(thrown_by([&] { other.residuals(cylfuse::ResidualKind::Points, PIPE); }).empty());
    CHECK(cylfuse_fitter_fit(fitter.handle(), nullptr, nullptr) == CYLFUSE_STATUS_CANCELLED);
    std::vector<cylfuse::Fitter> none;
    CHECK(thrown_by([&] { cylfuse::fit_all(none); }).empty());
    CHECK(thrown_by([&] { fitter.fit(); }) == "from the callback");
    CHECK(cylfuse_fitter_fit(fitter.handle(), nullptr, nullptr) == CYLFUSE_STATUS_CANCELLED);
    cylfuse::Detector detector;
    CHECK(thrown_by([&] { detector.set_options(cylfuse::DetectorOptions()); }).empty());

    // A call that a callback makes has nothing to do with what the callback before threw, which is not lost.
    bool undisturbed = false;
    fitter.set_log(cylfuse::LogLevel::Info,
                   [](cylfuse::LogLevel, const char *) { throw std::logic_error("from the log"); });
    fitter.set_progress([&](const cylfuse::Progress &) {
        undisturbed = thrown_by([&] { other.counts(); }).empty();
        return true;
    });
    CHECK(thrown_by([&] { fitter.fit(); }) == "from the log");
    CHECK(undisturbed);

    // Of a list, which takes two calls.
    fitter.set_log(cylfuse::LogLevel::Off, nullptr);
    fitter.set_progress(nullptr);
    fitter.fit();
    int lines = 0;
    fitter.set_log(cylfuse::LogLevel::Debug, [&](cylfuse::LogLevel, const char *) {
        ++lines;
        throw std::logic_error("from the log");
    });
    const std::string thrown = thrown_by([&] { fitter.residuals(cylfuse::ResidualKind::Points); });
    CHECK(thrown == (lines > 0 ? "from the log" : ""));
}

// Callbacks of the struct of C still serve, and of a library that knows fewer fields no more are read.
static void progress_is_that_of_c()
{
    const Points points = some_points();
    cylfuse::Fitter fitter;
    fitter.push_points(points);
    int solves = 0;
    fitter.set_progress([&](const cylfuse_progress &progress) { return progress.phase != CYLFUSE_PHASE_SOLVE || ++solves > 0; });
    fitter.fit();
    CHECK(solves > 0);
    cylfuse_progress state{};
    state.phase = CYLFUSE_PHASE_SOLVE;
    state.cost = 7.0;
    CHECK(cylfuse::Progress(state).cost == 7.0);
    state.struct_size = offsetof(cylfuse_progress, cost);
    const cylfuse::Progress older(state);
    CHECK(older.current_phase() == cylfuse::Phase::Solve && older.phase == 2 && older.cost == 0.0);
    CHECK(older.struct_size == state.struct_size);
    state.struct_size = 1000;
    CHECK(cylfuse::Progress(state).cost == 7.0 && cylfuse::Progress(state).struct_size == sizeof(cylfuse_progress));
}

template <class Statement>
static std::size_t needed_by(Statement statement)
{
    try {
        statement();
    } catch (const cylfuse::Error &error) {
        CHECK(error.status() == cylfuse::Status::BufferTooSmall);
        return error.needed();
    }
    return 0;
}

static void small_buffers_say_what_is_needed()
{
    const Scene scene;
    const Points points = some_points();
    cylfuse::Fitter fitter;
    fitter.set_intrinsics(scene.camera);
    fitter.push_depth(scene.depth_view(), scene.mask_view());
    fitter.push_edges(scene.edges);
    const auto used = static_cast<std::size_t>(fitter.fit().result.points_used);
    double doubles[3];
    std::uint8_t bytes[1];
    std::array<float, 3> point;
    CHECK(needed_by([&] { cylfuse::distances(PIPE, points, doubles); }) == points.size());
    CHECK(needed_by([&] { fitter.select_edges(scene.edges, bytes); }) == scene.edges.size());
    CHECK(needed_by([&] { fitter.residuals(cylfuse::ResidualKind::Points, doubles); }) == used);
    const cylfuse::PointsOut out(point.data(), 1);
    std::vector<std::array<float, 3>> completed;
    fitter.complete(completed);
    CHECK(needed_by([&] { fitter.complete(out, cylfuse::Layout::Packed); }) >= completed.size());
    CHECK(needed_by([&] { fitter.complete(out, cylfuse::Layout::Organised); }) == 160 * 120);
    cylfuse::Detector detector;
    detector.detect_points(points);
    std::uint16_t labels[3];
    CHECK(needed_by([&] { detector.labels(labels); }) == points.size());

    cylfuse::Part part[1];
    cylfuse::Limb limb[1];
    cylfuse::Span<cylfuse::EndSample> no_samples;
    CHECK(needed_by([&] { fitter.point_weights(doubles, bytes); }) == used);
    CHECK(needed_by([&] { fitter.point_weights(doubles); }) == used);
    CHECK(needed_by([&] { fitter.point_weights({}, bytes); }) == used);
    CHECK(needed_by([&] { fitter.point_weights({}); }) == used);
    CHECK(needed_by([&] { fitter.point_parts(part); }) == used);
    CHECK(needed_by([&] { fitter.limbs(limb); }) == 2);
    CHECK(needed_by([&] { fitter.end_samples(no_samples); }) == fitter.end_samples().size());
}

static void a_failed_completion_leaves_the_points()
{
    const Scene scene;
    cylfuse::Fitter fitter;
    Points points = {{{1.0, 2.0, 3.0}}, {{4.0, 5.0, 6.0}}};
    const Points before = points;
    CHECK_ERROR(fitter.complete(points), BAD_STATE, "");
    CHECK(points == before);
    fitter.set_intrinsics(scene.camera);
    fitter.push_depth(scene.depth_view(), scene.mask_view());
    CHECK_ERROR(fitter.complete(points), BAD_STATE, "");
    CHECK(points == before);
    cylfuse::Cylinder flat = PIPE;
    flat.radius = 0.0;
    CHECK_ERROR(fitter.complete(points, flat), INVALID_ARGUMENT, "radius");
    CHECK(points == before);
    points.resize(160 * 120 + 5);
    CHECK(fitter.complete(points, PIPE).count == points.size());
    CHECK(points.size() > 1000 && points.size() < 160 * 120);
}

static void the_version_is_that_of_the_header()
{
    CHECK(cylfuse::version_number() == CYLFUSE_VERSION_NUMBER);
    CHECK(std::string(cylfuse::version_string()) == cylfuse_version_string());
    CHECK(std::string(cylfuse::build_info()).find(cylfuse::version_string()) != std::string::npos);
}

static void fits_that_are_stopped_have_their_statuses()
{
    std::vector<cylfuse::Fitter> fitters(6);
    for (cylfuse::Fitter &fitter : fitters) {
        fitter.push_points(some_points());
    }
    const std::vector<cylfuse::Status> statuses =
        cylfuse::fit_all(fitters, 1, [](std::size_t index, cylfuse::Status) { return index < 2; });
    CHECK(statuses.size() == fitters.size());
    for (std::size_t k = 0; k < statuses.size(); ++k) {
        CHECK(statuses[k] == (k < 3 ? cylfuse::Status::Ok : cylfuse::Status::Cancelled));
    }
    CHECK_NEAR(fitters[1].last_fit().cylinder.model.radius, PIPE.radius, 1e-9);
    CHECK_ERROR(fitters[5].last_fit(), BAD_STATE, "");
}

static void data_may_vanish_after_the_call()
{
    const Scene scene;
    cylfuse::Fitter fitter;
    fitter.set_intrinsics(scene.camera);
    fitter.push_points(some_points());
    fitter.push_points(Points(some_points()), {});
    fitter.push_points(cylfuse::PointsView(some_points()[0].data(), 0));
    CHECK(fitter.counts().points_given == 400);
    fitter.push_edges(std::vector<std::array<double, 4>>(scene.edges));
    fitter.push_edges(std::array<std::array<float, 4>, 1>{{{{1.0F, 2.0F, 3.0F, 40.0F}}}});
    CHECK(fitter.counts().segments_given == 3);
    fitter.push_points(std::array<std::array<float, 3>, 2>{{{{1.0F, 2.0F, 3.0F}}, {{1.0F, 2.0F, 4.0F}}}});
    CHECK(fitter.counts().points_given == 402);
    fitter.push_edges(cylfuse::Span<const std::array<double, 4>>(scene.edges));
    CHECK(fitter.counts().segments_given == 5);
    std::vector<double> distances(200);
    cylfuse::distances(PIPE, some_points(), distances);
    CHECK(std::all_of(distances.begin(), distances.end(), [](double d) { return std::abs(d) < 1e-9; }));
    CHECK(cylfuse::project(scene.camera, some_points()).size() == 200);
    std::uint8_t limbs[2];
    fitter.select_edges(std::vector<std::array<double, 4>>(scene.edges), limbs, 0.0, PIPE);
    CHECK(limbs[0] + limbs[1] == 3);
    cylfuse::Detector detector;
    detector.detect_points(some_points());
    CHECK(detector.labels().size() == 200);
}

static void handles_have_the_text_of_their_last_failure()
{
    cylfuse::Fitter fitter;
    CHECK_ERROR(fitter.fit(), TOO_FEW_POINTS, "");
    CHECK(std::string(fitter.last_error()).find("0 of 0 points") == 0);
    fitter.counts();
    CHECK(*fitter.last_error() == '\0');
    cylfuse::Frame frame;
    CHECK_ERROR(frame.set_intrinsics(cylfuse::Intrinsics()), INVALID_INTRINSICS, "");
    CHECK(*frame.last_error() != '\0');
    cylfuse::Detector detector;
    CHECK_ERROR(detector.count(), BAD_STATE, "");
    CHECK(*detector.last_error() != '\0');
}

int main()
{
    constants_have_names();
    exceptions_leave_the_call_that_they_came_from();
    progress_is_that_of_c();
    small_buffers_say_what_is_needed();
    a_failed_completion_leaves_the_points();
    the_version_is_that_of_the_header();
    fits_that_are_stopped_have_their_statuses();
    data_may_vanish_after_the_call();
    handles_have_the_text_of_their_last_failure();
    return finish("calls");
}

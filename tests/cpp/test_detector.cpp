// The class for detectors.
#include "pair.hpp"

#include <cylfuse/detector.hpp>

#include <stdexcept>
#include <string>

static void everything_goes_together()
{
    const Pair pair;
    cylfuse::Detector detector;
    CHECK_ERROR(detector.count(), BAD_STATE, "search a frame or points first");
    detector.detect(pair.frame());
    const std::vector<cylfuse::Detection> found = detector.detections();
    if (!CHECK(found.size() == 2 && detector.count() == 2)) {
        return;
    }
    CHECK(found[0].score >= found[1].score && which(found[0].model, 0.01) + which(found[1].model, 0.01) == 1);
    const std::vector<std::uint16_t> labels = detector.labels();
    CHECK(labels.size() == 160 * 120);
    for (std::size_t index = 0; index < 2; ++index) {
        const std::vector<std::uint32_t> indices = detector.indices(index);
        CHECK(indices.size() == found[index].pixels);
        std::vector<std::uint32_t> same(indices.size() + 5);
        CHECK(detector.indices(index, same) == indices.size());
        same.resize(indices.size());
        CHECK(same == indices);
        for (const std::uint32_t k : indices) {
            CHECK(labels[k] == index + 1);
        }
        const cylfuse::CylinderFit fit = detector.fit(index);
        CHECK(fit.result.limbs_located == 2 && fit.cylinder.start_kind() == cylfuse::Start::Model);
        CHECK(fit.cylinder.model.radius == found[index].model.radius);
        const cylfuse::Extent extent = detector.extent(index);
        CHECK_NEAR(extent.length, 0.22, 0.01);
        const cylfuse::Fitter fitter = detector.make_fitter(index);
        CHECK(fitter.last_fit().cylinder.model.radius == found[index].model.radius);
        CHECK(fitter.extent().length == extent.length && fitter.limbs().size() == 2);
        std::vector<std::array<double, 3>> completed;
        CHECK(fitter.complete(completed).count > indices.size() / 2);
    }
    std::array<cylfuse::Detection, 3> same;
    CHECK(detector.detections(same) == 2 && same[1].score == found[1].score && same[1].model.radius == found[1].model.radius);
    std::vector<std::uint16_t> some(7);
    std::size_t needed = 0;
    try {
        detector.labels(some);
    } catch (const cylfuse::Error &error) {
        CHECK(error.status() == cylfuse::Status::BufferTooSmall);
        needed = error.needed();
    }
    CHECK(needed == 160 * 120);
    some.resize(needed);
    CHECK(detector.labels(some) == needed && some == labels);
    CHECK_ERROR(detector.indices(2), INVALID_ARGUMENT, "index is 2");
    std::array<std::uint32_t, 1> index;
    cylfuse::Detection one[1];
    CHECK_ERROR(detector.indices(2, index), INVALID_ARGUMENT, "index is 2");
    CHECK_ERROR(detector.indices(0, index), BUFFER_TOO_SMALL, "");
    try {
        detector.detections(one);
    } catch (const cylfuse::Error &error) {
        needed = error.needed();
    }
    CHECK(needed == 2);
    CHECK_ERROR(detector.fit(2), INVALID_ARGUMENT, "index is 2");
    CHECK_ERROR(detector.make_fitter(2), INVALID_ARGUMENT, "index is 2");

    std::vector<std::array<float, 3>> points;
    for (std::size_t k = 0; k < 160 * 120; ++k) {
        points.push_back(pair.point(k));
    }
    detector.detect_points(points);
    CHECK(detector.count() == 2);
    CHECK(detector.extent(0).end_source() == cylfuse::EndSource::Points);
}

// Bumps in both directions, 12 pixels apart: more to look at than a search may.
static void a_search_that_was_cut_short_says_so()
{
    const double step = std::acos(-1.0) / 6.0;
    std::vector<float> bumps;
    for (int k = 0; k < 640 * 480; ++k) {
        bumps.push_back(float(1.0 + 1.2 / 525.0 * std::sin(step * (k % 640)) * std::sin(step * (k / 640))));
    }
    cylfuse::Frame frame;
    frame.set_intrinsics(cylfuse::Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5));
    frame.set_depth(cylfuse::DepthView(bumps.data(), 640, 480, 1.0));
    cylfuse::Detector detector;
    CHECK_ERROR(detector.is_complete(), BAD_STATE, "search a frame or points first");
    detector.detect(frame);
    CHECK(!detector.is_complete());
    const Pair pair;
    detector.detect(pair.frame());
    CHECK(detector.is_complete());
    CHECK((detector.depth_moved() == std::array<std::int32_t, 2>{0, 0}));
}

static void options_are_kept()
{
    cylfuse::Detector detector;
    cylfuse::DetectorOptions options = detector.options();
    CHECK(options.image_use() == cylfuse::ImageUse::Auto && options.min_score == 0.5 && options.max_count == 0);
    options.image_use(cylfuse::ImageUse::Ignore);
    options.radius_max = 0.04;
    detector.set_options(options);
    CHECK(detector.options().image_use() == cylfuse::ImageUse::Ignore && detector.options().radius_max == 0.04);
    cylfuse::Options fits = detector.fit_options();
    fits.depth_noise = 0.001;
    detector.set_fit_options(fits);
    CHECK(detector.fit_options().depth_noise == 0.001);
    CHECK_ERROR(detector.set_fit_options(fits.start(cylfuse::Start::Limbs)), INVALID_ARGUMENT, "start of the fits");
    options.min_score = 2.0;
    CHECK_ERROR(detector.set_options(options), INVALID_ARGUMENT, "options.min_score is 2");
    const Pair pair;
    detector.detect(pair.frame());
    CHECK(detector.count() == 1 && detector.fit(0).result.limbs_located == 0);
    CHECK(which(detector.detections()[0].model, 0.1) == 1);
}

static void callbacks_and_moves()
{
    const Pair pair;
    const cylfuse::Frame frame = pair.frame();
    cylfuse::Detector first;
    int calls = 0;
    std::uint32_t fits = 0;
    std::vector<cylfuse::DetectionPhase> phases;
    first.set_progress([&](const cylfuse::DetectionProgress &progress) {
        ++calls;
        phases.push_back(progress.current_phase());
        CHECK(progress.phase == std::int32_t(phases.back()) && progress.struct_size == sizeof(cylfuse_detection_progress));
        fits = progress.fits_done;
        CHECK_ERROR(first.set_progress(nullptr), BUSY, "busy");
        return true;
    });
    first.detect(frame);
    CHECK(calls >= 4 && fits >= 2);
    CHECK(phases.front() == cylfuse::DetectionPhase::Search && phases.back() == cylfuse::DetectionPhase::Fit);
    first.set_progress([](const cylfuse::DetectionProgress &) { return false; });
    CHECK_ERROR(first.detect(frame), CANCELLED, "cancelled");
    CHECK(first.count() == 2);
    first.set_progress([](const cylfuse::DetectionProgress &) -> bool { throw std::runtime_error("from the callback"); });
    std::string caught;
    try {
        first.detect(frame);
    } catch (const std::runtime_error &error) {
        caught = error.what();
    }
    CHECK(caught == "from the callback");
    cylfuse::Detector second(std::move(first));
    CHECK(first.handle() == nullptr && second.count() == 2);
    CHECK_ERROR(first.detect(frame), NULL_POINTER, "detector is NULL");
    // One that was given away calls nobody back.
    cylfuse_detector *raw = second.release();
    CHECK(cylfuse_detector_detect(raw, frame.handle()) == CYLFUSE_STATUS_OK);
    cylfuse::Detector third(raw);
    third.cancel(); // Nothing runs: nothing is cancelled.
    CHECK(third.count() == 2);
    third = cylfuse::Detector();
    CHECK_ERROR(third.detect(cylfuse::Frame()), BAD_STATE, "intrinsics");
}

int main()
{
    everything_goes_together();
    a_search_that_was_cut_short_says_so();
    options_are_kept();
    callbacks_and_moves();
    return finish("detector");
}

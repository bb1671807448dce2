// The wrapper in a program without exceptions.
#define CYLFUSE_NO_EXCEPTIONS
#include <cylfuse/cylfuse.hpp>
#include <cylfuse/eigen.hpp>

#include <cmath>
#include <cstdio>

int main()
{
    auto made = cylfuse::Fitter::create();
    if (!made) {
        return 1;
    }
    cylfuse::Fitter &fitter = *made;
    const auto none = fitter.fit();
    if (none || none.status() != cylfuse::Status::TooFewPoints ||
        std::string(none.error().what()).find("0 of 0 points") == std::string::npos) {
        std::printf("a fit without points: %d %s\n", int(none.status()), none.error().what());
        return 1;
    }
    std::vector<std::array<float, 3>> points;
    for (int k = 0; k < 200; ++k) {
        points.push_back({0.5F * std::cos(0.008F * float(k)), 0.1F * float(k % 7), 2.0F - 0.5F * std::sin(0.008F * float(k))});
    }
    if (!fitter.set_progress([](const cylfuse::Progress &) { return true; }) || !fitter.push_points(points)) {
        return 1;
    }
    const auto result = fitter.fit();
    if (!result || std::abs(result->cylinder.model.radius - 0.5) > 1e-5) {
        std::printf("%s, radius %f\n", result.error().what(), result->cylinder.model.radius);
        return 1;
    }
    double some[10];
    const auto residuals = fitter.residuals(cylfuse::ResidualKind::Points, some);
    if (residuals || residuals.status() != cylfuse::Status::BufferTooSmall || residuals.error().needed() != 200) {
        std::printf("a small buffer: %s, %zu needed\n", residuals.error().what(), residuals.error().needed());
        return 1;
    }
    const auto all = fitter.residuals(cylfuse::ResidualKind::Points);
    auto frame = cylfuse::Frame::create();
    if (!all || all->size() != 200 || !frame || frame->set_intrinsics(cylfuse::Intrinsics())) {
        return 1;
    }
    auto detector = cylfuse::Detector::create();
    if (!detector || detector->count().status() != cylfuse::Status::BadState || !detector->detect_points(points) ||
        *detector->count() > 1 || detector->detect(*frame)) {
        return 1;
    }
    std::vector<double> distances(3);
    const auto small = cylfuse::distances(result->cylinder.model, points, distances);
    std::vector<cylfuse::Fitter> several;
    several.push_back(std::move(fitter));
    const auto statuses = cylfuse::fit_all(several, 1, [](std::size_t, cylfuse::Status) { return false; });
    if (small || small.error().needed() != 200 || !statuses || (*statuses)[0] != cylfuse::Status::Ok) {
        std::printf("%zu needed, %s\n", small.error().needed(), statuses.error().what());
        return 1;
    }
    std::printf("without exceptions: all checks hold\n");
    return 0;
}

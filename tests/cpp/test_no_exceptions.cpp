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
    if (none || none.status() != CYLFUSE_STATUS_TOO_FEW_POINTS ||
        std::string(none.error().what()).find("0 of 0 points") == std::string::npos) {
        std::printf("a fit without points: %d %s\n", int(none.status()), none.error().what());
        return 1;
    }
    std::vector<std::array<float, 3>> points;
    for (int k = 0; k < 200; ++k) {
        points.push_back({0.5F * std::cos(0.008F * float(k)), 0.1F * float(k % 7), 2.0F - 0.5F * std::sin(0.008F * float(k))});
    }
    fitter.set_progress([](const cylfuse_progress &) { return true; });
    if (!fitter.push_points(points)) {
        return 1;
    }
    const auto result = fitter.fit();
    if (!result || std::abs(result->model.radius - 0.5) > 1e-5) {
        std::printf("%s, radius %f\n", result.error().what(), result->model.radius);
        return 1;
    }
    std::printf("without exceptions: all checks hold\n");
    return 0;
}

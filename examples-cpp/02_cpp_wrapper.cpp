// The same fit in C++: 02_cpp_wrapper FOLDER
#include "frame.hpp"

#include <cstdio>

int main(int argc, char **argv)
try {
    if (argc != 2) {
        std::fprintf(stderr, "usage: %s FOLDER with camera.txt, depth.pgm, mask.pgm and edges.txt\n", argv[0]);
        return 2;
    }
    const Frame frame(argv[1]);
    cylfuse::Fitter fitter;
    fitter.set_log(cylfuse::LogLevel::Warning, [](cylfuse::LogLevel, const char *line) { std::puts(line); });
    fitter.set_intrinsics(frame.camera);
    fitter.push_depth(frame.depth_view(), frame.mask_view());
    fitter.push_edges(frame.edges);

    // With and without the edges, and as the paper does it.
    cylfuse::Options options;
    for (const auto method : {cylfuse::Method::Ransac, cylfuse::Method::Points, cylfuse::Method::Fused}) {
        fitter.set_options(options.method(method));
        std::printf("method %d: radius %.2f mm\n", int(method), 1e3 * fitter.fit().cylinder.model.radius);
    }
    fitter.set_options(options.objective(cylfuse::Objective::Paper));
    std::printf("the paper: radius %.2f mm\n", 1e3 * fitter.fit().cylinder.model.radius);

    fitter.set_options(cylfuse::Options());
    const cylfuse::CylinderFit fit = fitter.fit();
    const cylfuse::Extent extent = fitter.extent();
    const std::vector<double> residuals = fitter.residuals(cylfuse::ResidualKind::Points);
    std::size_t within = 0;
    for (const double residual : residuals) {
        within += residual > -0.002 && residual < 0.002;
    }
    std::printf("radius %.2f mm, length %.2f mm, converged %s\n", 1e3 * fit.cylinder.model.radius, 1e3 * extent.length,
                fit.result.has(cylfuse::ResultFlags::NotConverged) ? "no" : "yes");
    std::printf("%zu of %zu points within 2 mm\n", within, residuals.size());
    return 0;
} catch (const cylfuse::Error &error) {
    std::fprintf(stderr, "status %d: %s\n", int(error.status()), error.what());
    return 1;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

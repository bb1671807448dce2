// The same as client.c, through the headers for C++ of the release that froze the interface.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cylfuse/cylfuse.hpp>
#include <vector>

int main() {
    const int width = 160, height = 120;
    std::vector<std::uint16_t> depth(width * height);
    std::vector<std::uint8_t> mask(width * height);
    for (int k = 0; k < width * height; k++) {
        const double x = (k % width - 79.5) / 150, a = x * x + 1, root = 0.36 - a * (0.36 - 0.0025);
        if (root >= 0) {
            depth[k] = static_cast<std::uint16_t>((0.6 - std::sqrt(root)) / a * 10000 + 0.5);
            mask[k] = 1;
        }
    }
    try {
        cylfuse::Fitter fitter;
        cylfuse::Options options;
        options.radius_max = 1;
        fitter.set_options(options);
        cylfuse::Intrinsics intrinsics;
        intrinsics.width = width;
        intrinsics.height = height;
        intrinsics.fx = intrinsics.fy = 150;
        intrinsics.cx = 79.5;
        intrinsics.cy = 59.5;
        fitter.set_intrinsics(intrinsics);
        cylfuse::DepthView depth_view;
        depth_view.format = CYLFUSE_DEPTH_FORMAT_U16;
        depth_view.data = depth.data();
        depth_view.width = width;
        depth_view.height = height;
        depth_view.scale = 0.0001;
        cylfuse::MaskView mask_view;
        mask_view.data = mask.data();
        mask_view.width = width;
        mask_view.height = height;
        fitter.push_depth(depth_view, mask_view);
        int steps = 0;
        fitter.set_progress([&steps](const cylfuse::Progress &) {
            steps++;
            return true;
        });
        const auto fit = fitter.fit();
        if (std::abs(fit.cylinder.model.radius - 0.05) > 5e-4 || steps == 0) {
            std::fprintf(stderr, "client.cpp: radius %g after %d steps\n", fit.cylinder.model.radius, steps);
            return 1;
        }
        const auto extent = fitter.extent();
        const auto residuals = fitter.residuals(cylfuse::ResidualKind::Points);
        if (!(extent.length > 0.3) || residuals.size() < 1000) {
            std::fprintf(stderr, "client.cpp: length %g, %zu residuals\n", extent.length, residuals.size());
            return 1;
        }
        try {
            fitter.select_view(99);
            return 1;
        } catch (const cylfuse::Error &error) {
            if (error.status() != cylfuse::Status::InvalidArgument) {
                throw;
            }
        }
        std::puts("the client runs");
    } catch (const std::exception &error) {
        std::fprintf(stderr, "client.cpp: %s\n", error.what());
        return 1;
    }
    return 0;
}

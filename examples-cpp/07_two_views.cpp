// One pipe from two sides, with a depth camera beside the colour camera: 07_two_views
//
// Makes its own data: two frames that differ by a quarter of a turn around the pipe, depth with noise of 1 mm.
#include <cylfuse/cylfuse.hpp>

#include <cmath>
#include <cstdio>
#include <random>

static const double RADIUS = 0.04, HALF_LENGTH = 0.15, DISTANCE = 0.8; // metres; the pipe runs along y
static const double BASELINE = 0.025; // from the colour camera to the depth camera, to the right

// The depth of the pipe at every pixel of a camera that has its axis `left` of its own; 0 = no pipe.
static std::vector<float> depth_image(const cylfuse::Intrinsics &camera, double left, double noise, unsigned seed)
{
    std::mt19937 random(seed);
    std::normal_distribution<double> error(0.0, noise);
    std::vector<std::array<double, 2>> pixels;
    for (std::uint32_t row = 0; row < camera.height; ++row) {
        for (std::uint32_t column = 0; column < camera.width; ++column) {
            pixels.push_back({{double(column), double(row)}});
        }
    }
    std::vector<float> depth;
    for (const auto &ray : cylfuse::unproject(camera, pixels)) {
        // |(x z + left, z - DISTANCE)| = RADIUS, the nearer z.
        const double a = ray[0] * ray[0] + 1.0, b = DISTANCE - ray[0] * left;
        const double root = b * b - a * (left * left + DISTANCE * DISTANCE - RADIUS * RADIUS);
        const double z = root > 0.0 ? (b - std::sqrt(root)) / a : 0.0;
        const bool seen = z > 0.0 && std::abs(ray[1] * z) < HALF_LENGTH;
        depth.push_back(seen ? float(z + error(random)) : 0.0F);
    }
    return depth;
}

int main()
try {
    const cylfuse::Intrinsics colour_camera(640, 480, 570.0, 570.0, 319.5, 239.5);
    const cylfuse::Intrinsics depth_camera(320, 240, 290.0, 290.0, 159.5, 119.5);
    cylfuse::RigidMotion to_colour; // A point at the origin of the depth camera is BASELINE to the right.
    to_colour.translation = {{BASELINE, 0.0, 0.0}};

    // The mask is on the pixels of the colour camera; the fitter selects those of the depth camera by it.
    std::vector<std::uint8_t> mask;
    for (const float z : depth_image(colour_camera, 0.0, 0.0, 0)) {
        mask.push_back(z > 0.0F ? 255 : 0);
    }

    cylfuse::Fitter fitter;
    for (unsigned view = 0; view < 2; ++view) {
        const std::vector<float> depth = depth_image(depth_camera, BASELINE, 0.001, view);
        const double angle = view * 1.5707963267948966;
        cylfuse::RigidMotion pose; // Around the pipe: from the frame of this camera to that of the first.
        pose.rotation = {{std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle)}};
        pose.translation = {{-DISTANCE * std::sin(angle), 0, DISTANCE - DISTANCE * std::cos(angle)}};

        // As a camera driver would hand it over; any number of fitters could use this frame.
        cylfuse::Frame frame;
        frame.set_intrinsics(colour_camera);
        frame.set_depth_camera(depth_camera, to_colour);
        frame.set_depth(cylfuse::DepthView(depth.data(), depth_camera.width, depth_camera.height, 1.0));
        frame.set_pose(pose);

        fitter.select_view(view); // The number of views adds one.
        fitter.use_frame(frame, cylfuse::MaskView(mask.data(), colour_camera.width, colour_camera.height));
        const cylfuse::CylinderFit fit = fitter.fit();
        std::printf("%zu view%s: radius %.2f +- %.2f mm, %llu points\n", fitter.view_count(), view == 0 ? "" : "s",
                    1e3 * fit.cylinder.model.radius, 1e3 * fit.cylinder.radius_deviation,
                    static_cast<unsigned long long>(fit.result.points_used));
    }
    std::printf("length %.1f mm\n", 1e3 * fitter.extent().length);
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

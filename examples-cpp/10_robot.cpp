// Where a robot finds a pipe, from two views of the camera on its arm: 10_robot
//
// The pose of the camera in the base frame is that of the flange, which the robot tells, times that of the camera in the
// frame of the flange, which a hand-eye calibration gives. The result is in the base frame. Makes its own data: the depth
// of an upright pipe, with noise of 1 mm.
#include <cylfuse/cylfuse.hpp>

#include <cmath>
#include <cstdio>
#include <random>

using cylfuse::RigidMotion;

// First `inner`, then `outer`.
static RigidMotion operator*(const RigidMotion &outer, const RigidMotion &inner)
{
    RigidMotion both;
    for (int i = 0; i < 3; ++i) {
        both.translation[i] = outer.translation[i];
        for (int j = 0; j < 3; ++j) {
            both.translation[i] += outer.rotation[3 * i + j] * inner.translation[j];
            double sum = 0.0;
            for (int k = 0; k < 3; ++k) {
                sum += outer.rotation[3 * i + k] * inner.rotation[3 * k + j];
            }
            both.rotation[3 * i + j] = sum;
        }
    }
    return both;
}

// In the base frame, z up: an upright pipe.
static const double AXIS_X = 0.6, AXIS_Y = 0.1, BOTTOM = 0.2, TOP = 0.5, RADIUS = 0.04;

// The depth of the pipe at every pixel of a camera with this pose in the base frame; 0 = no pipe.
static std::vector<float> depth_image(const cylfuse::Intrinsics &camera, const RigidMotion &pose, unsigned seed)
{
    std::mt19937 random(seed);
    std::normal_distribution<double> error(0.0, 0.001);
    std::vector<std::array<double, 2>> pixels;
    for (std::uint32_t row = 0; row < camera.height; ++row) {
        for (std::uint32_t column = 0; column < camera.width; ++column) {
            pixels.push_back({{double(column), double(row)}});
        }
    }
    std::vector<float> depth;
    for (const auto &ray : cylfuse::unproject(camera, pixels)) {
        RigidMotion tip; // The ray has z = 1, so its length in the equation below is the depth.
        tip.translation = ray;
        const auto &eye = pose.translation;
        const auto end = (pose * tip).translation;
        const double dx = end[0] - eye[0], dy = end[1] - eye[1], x = eye[0] - AXIS_X, y = eye[1] - AXIS_Y;
        const double a = dx * dx + dy * dy, b = x * dx + y * dy, c = x * x + y * y - RADIUS * RADIUS;
        const double root = b * b - a * c, z = root > 0.0 ? (-b - std::sqrt(root)) / a : 0.0;
        const double height = eye[2] + z * (end[2] - eye[2]);
        depth.push_back(z > 0.0 && height > BOTTOM && height < TOP ? float(z + error(random)) : 0.0F);
    }
    return depth;
}

// The camera in the frame of the flange, as a hand-eye calibration gives it: here 5 cm above, looking the same way.
static RigidMotion flange_to_camera()
{
    RigidMotion motion;
    motion.translation = {{0.0, -0.05, 0.02}};
    return motion;
}

// The flange in the base frame, as the robot tells it: here `angle` around the pipe, 0.7 m from it, looking at it.
static RigidMotion base_to_flange(double angle)
{
    const double s = std::sin(angle), c = std::cos(angle);
    RigidMotion motion; // Columns: x to the right, y down, z towards the pipe.
    motion.rotation = {{s, 0, c, -c, 0, s, 0, -1, 0}};
    motion.translation = {{AXIS_X - 0.7 * c, AXIS_Y - 0.7 * s, 0.35}};
    return motion;
}

int main()
try {
    const cylfuse::Intrinsics camera(640, 480, 570.0, 570.0, 319.5, 239.5);
    cylfuse::Fitter fitter;
    for (unsigned view = 0; view < 2; ++view) {
        const RigidMotion pose = base_to_flange(view == 0 ? -0.4 : 0.5) * flange_to_camera();
        const std::vector<float> depth = depth_image(camera, pose, view);
        std::vector<std::uint8_t> mask; // In practice from a segmentation, or from a detector in each view.
        for (const float z : depth) {
            mask.push_back(z > 0.0F ? 255 : 0);
        }
        fitter.select_view(view); // The number of views adds one.
        fitter.set_intrinsics(camera);
        fitter.set_pose(pose);
        fitter.push_depth(cylfuse::DepthView(depth.data(), camera.width, camera.height, 1.0),
                          cylfuse::MaskView(mask.data(), camera.width, camera.height));
    }
    const cylfuse::CylinderFit fit = fitter.fit();
    const cylfuse::Extent extent = fitter.extent();
    const double *axis = fit.cylinder.model.direction, *middle = extent.center;
    std::printf("radius %.2f mm, standard deviation %.2f mm, length %.1f mm\n", 1e3 * fit.cylinder.model.radius,
                1e3 * fit.cylinder.radius_deviation, 1e3 * extent.length);
    std::printf("in the base frame: axis %.3f %.3f %.3f, middle %.3f %.3f %.3f m, standard deviation %.1f mm\n", std::abs(axis[0]),
                std::abs(axis[1]), axis[2], middle[0], middle[1], middle[2], 1e3 * fit.cylinder.position_deviation);
    // Poses are taken as exact: the deviations know nothing of the errors of arm and calibration.
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

// Checks that count failures and go on, and a scene, for the programs in this folder.
#ifndef CHECK_HPP
#define CHECK_HPP

#include <cylfuse/cylfuse.hpp>

#include <cmath>
#include <cstdio>

static int failures = 0;

static inline bool check(bool holds, const char *what, const char *file, int line)
{
    if (!holds) {
        std::printf("%s:%d: %s\n", file, line, what);
        ++failures;
    }
    return holds;
}

#define CHECK(condition) check((condition), #condition, __FILE__, __LINE__)
#define CHECK_NEAR(value, expected, tolerance) CHECK(std::abs((value) - (expected)) <= (tolerance))

// The statement must throw cylfuse::Error with this status and a message that contains this text.
#define CHECK_ERROR(statement, expected, text)                                                            \
    do {                                                                                                  \
        bool thrown = false;                                                                              \
        try {                                                                                             \
            statement;                                                                                    \
        } catch (const cylfuse::Error &error) {                                                           \
            thrown = true;                                                                                \
            if (!CHECK(int(error.status()) == CYLFUSE_STATUS_##expected) ||                                    \
                !CHECK(std::string(error.what()).find(text) != std::string::npos)) {                      \
                std::printf("    status %d: %s\n", int(error.status()), error.what());                    \
            }                                                                                             \
        }                                                                                                 \
        check(thrown, "throws: " #statement, __FILE__, __LINE__);                                         \
    } while (0)

static inline int finish(const char *name)
{
    std::printf(failures == 0 ? "%s: all checks hold\n" : "%s: checks failed\n", name);
    return failures == 0 ? 0 : 1;
}

// A pipe of radius 0.05 along y, 0.8 in front of the camera.
static const cylfuse::Cylinder PIPE = {{0.0, 0.0, 0.8}, {0.0, 1.0, 0.0}, 0.05};

// Points on the pipe between two angles around it, 0 on the side of the camera.
static inline std::vector<std::array<double, 3>> pipe_points(int around, int along, double from, double to)
{
    std::vector<std::array<double, 3>> points;
    for (int i = 0; i < around; ++i) {
        const double angle = from + (to - from) * i / (around - 1);
        for (int j = 0; j < along; ++j) {
            points.push_back({PIPE.radius * std::sin(angle), 0.2 * j / (along - 1) - 0.1,
                              PIPE.point[2] - PIPE.radius * std::cos(angle)});
        }
    }
    return points;
}

// A depth image of the pipe in front of nothing, in metres, and its mask.
struct Scene {
    cylfuse::Intrinsics camera{160, 120, 200.0, 200.0, 79.5, 59.5};
    std::vector<float> depth = std::vector<float>(160 * 120, 0.0F);
    std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(160 * 120, 0);
    std::vector<std::array<double, 4>> edges;

    Scene()
    {
        for (int row = 0; row < 120; ++row) {
            for (int column = 0; column < 160; ++column) {
                // |(x z, z - 0.8)| = r with x = (column - cx) / f, the smaller z.
                const double x = (column - camera.cx) / camera.fx, y = (row - camera.cy) / camera.fy;
                const double a = x * x + 1.0, b = PIPE.point[2];
                const double root = b * b - a * (b * b - PIPE.radius * PIPE.radius);
                const double z = root > 0.0 ? (b - std::sqrt(root)) / a : 0.0;
                if (z > 0.0 && std::abs(y * z) < 0.1) {
                    depth[std::size_t(row * 160 + column)] = float(z);
                    mask[std::size_t(row * 160 + column)] = 255;
                }
            }
        }
        // The lines of sight along the limbs: tan = r / sqrt(d^2 - r^2).
        const double tangent = PIPE.radius / std::sqrt(0.8 * 0.8 - PIPE.radius * PIPE.radius);
        for (const double side : {-1.0, 1.0}) {
            const double u = camera.cx + side * camera.fx * tangent;
            edges.push_back({u, 40.0, u, 80.0});
        }
    }
    cylfuse::DepthView depth_view() const { return {depth.data(), 160, 120, 1.0}; }
    cylfuse::MaskView mask_view() const { return {mask.data(), 160, 120}; }
};

#endif

// Two cylinders before a wall, for the tests of detectors.
#ifndef PAIR_HPP
#define PAIR_HPP

#include "check.hpp"

static const cylfuse::Cylinder PAIR[2] = {
    {{-0.12, 0.0, 0.7}, {0.1, 0.99, 0.1}, 0.05},
    {{0.13, 0.05, 0.8}, {0.9, 0.3, 0.2}, 0.035},
};

struct Pair {
    cylfuse::Intrinsics camera{160, 120, 170.0, 170.0, 79.5, 59.5};
    std::vector<float> depth;
    std::vector<std::uint8_t> image;

    Pair()
    {
        std::uint32_t state = 1;
        for (int row = 0; row < 120; ++row) {
            for (int column = 0; column < 160; ++column) {
                int bright = 0;
                for (int ray = 0; ray < 16; ++ray) {
                    bright += seen(column + (ray % 4 - 1.5) / 4, row + (ray / 4 - 1.5) / 4).second;
                }
                // Errors of up to 1 mm, evenly spread.
                state = state * 1664525U + 1013904223U;
                depth.push_back(float(seen(column, row).first + 0.001 * (state / 2147483648.0 - 1.0)));
                image.push_back(std::uint8_t(40 + 10 * bright));
            }
        }
    }
    cylfuse::Frame frame() const
    {
        cylfuse::Frame frame;
        frame.set_intrinsics(camera);
        frame.set_depth(cylfuse::DepthView(depth.data(), 160, 120, 1.0));
        frame.set_image(image_view());
        return frame;
    }
    cylfuse::ImageView image_view() const { return {image.data(), 160, 120}; }
    std::array<float, 3> point(std::size_t k) const
    {
        const float x = float((double(k % 160) - camera.cx) / camera.fx);
        const float y = float((double(k / 160) - camera.cy) / camera.fy);
        return {x * depth[k], y * depth[k], depth[k]};
    }

private:
    // The depth at a place of the image, and whether a cylinder is seen there.
    std::pair<double, bool> seen(double column, double row) const
    {
        const std::array<double, 3> ray = {(column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy, 1.0};
        std::pair<double, bool> nearest(1.2 / (1.0 + 0.1 * ray[0] - 0.2 * ray[1]), false);
        for (const cylfuse::Cylinder &model : PAIR) {
            const double norm = std::sqrt(dot(model.direction, model.direction));
            const double along = dot(ray, model.direction) / norm, start = dot(model.point, model.direction) / norm;
            std::array<double, 3> across{}, offset{};
            for (std::size_t i = 0; i < 3; ++i) {
                across[i] = ray[i] - along * model.direction[i] / norm;
                offset[i] = model.point[i] - start * model.direction[i] / norm;
            }
            const double a = dot(across, across), b = dot(across, offset);
            const double root = b * b - a * (dot(offset, offset) - model.radius * model.radius);
            const double z = root > 0.0 ? (b - std::sqrt(root)) / a : -1.0;
            if (z > 0.0 && z < nearest.first && std::abs(z * along - start) < 0.11) {
                nearest = {z, true};
            }
        }
        return nearest;
    }
    template <class A, class B>
    static double dot(const A &a, const B &b)
    {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }
};

// Which of the two a model is; 2 for none.
static inline std::size_t which(const cylfuse::Cylinder &model, double tolerance)
{
    for (std::size_t k = 0; k < 2; ++k) {
        const cylfuse::Difference off = cylfuse::compare(PAIR[k], model);
        if (off.angle < tolerance && off.axis_distance < tolerance * PAIR[k].radius &&
            std::abs(off.radius_relative) < tolerance) {
            return k;
        }
    }
    return 2;
}

#endif

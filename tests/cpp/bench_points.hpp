// What the programs for `cylfuse bench` read and print.
#pragma once

#include <cstdio>
#include <cstring>
#include <vector>

struct BenchPoint {
    float x, y, z;
};

// x, y, z of all points in metres, as 32-bit floating-point numbers on standard input.
inline std::vector<BenchPoint> read_points()
{
    std::vector<BenchPoint> points;
    BenchPoint point;
    while (std::fread(&point, sizeof point, 1, stdin) == 1) {
        points.push_back(point);
    }
    return points;
}

// Point, direction and radius of a cylinder on a line of its own.
template <class Seven> void print_cylinder(const Seven &values)
{
    for (const auto value : values) {
        std::printf("%.9g ", static_cast<double>(value));
    }
    std::printf("\n");
}

// Whether all cylinders of a scene are wanted, not one of the whole cloud.
inline bool wants_scene(int argc, char **argv)
{
    return argc > 1 && std::strcmp(argv[1], "scene") == 0;
}

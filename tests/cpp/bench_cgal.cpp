// All cylinders of a scene by CGAL's efficient RANSAC (Schnabel, Wahl, Klein, "Efficient RANSAC for point-cloud shape
// detection", 2007), for `cylfuse bench --cgal`: the points of bench_points.hpp come in.
//
// One point in each 4 mm; normals from 24 neighbours; planes, spheres, cylinders and cones compete for the points: at least
// 100 of them, within 5 mm and 25 degrees of the shape, gaps below 15 mm, a probability of 1 % to miss the largest shape.
// Cylinders with a radius of 5 to 150 mm count.
#include "bench_points.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Shape_detection/Efficient_RANSAC.h>
#include <CGAL/grid_simplify_point_set.h>
#include <CGAL/pca_estimate_normals.h>

#include <algorithm>
#include <array>
#include <utility>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = std::pair<Kernel::Point_3, Kernel::Vector_3>;
using Points = std::vector<Point>;
using PointMap = CGAL::First_of_pair_property_map<Point>;
using NormalMap = CGAL::Second_of_pair_property_map<Point>;
using Traits = CGAL::Shape_detection::Efficient_RANSAC_traits<Kernel, Points, PointMap, NormalMap>;
using Detection = CGAL::Shape_detection::Efficient_RANSAC<Traits>;
using Cylinder = CGAL::Shape_detection::Cylinder<Traits>;

int main(int argc, char **argv)
try {
    if (!wants_scene(argc, argv)) {
        std::fprintf(stderr, "bench_cgal scene: only whole scenes\n");
        return 1;
    }
    // The same results at every run.
    CGAL::get_default_random() = CGAL::Random(0);
    Points points;
    for (const BenchPoint &point : read_points()) {
        points.emplace_back(Kernel::Point_3(point.x, point.y, point.z), Kernel::Vector_3(0, 0, 0));
    }
    const auto maps = CGAL::parameters::point_map(PointMap()).normal_map(NormalMap());
    points.erase(CGAL::grid_simplify_point_set(points, 0.004, maps), points.end());
    CGAL::pca_estimate_normals<CGAL::Sequential_tag>(points, 24, maps);

    Detection detection;
    detection.set_input(points);
    detection.add_shape_factory<CGAL::Shape_detection::Plane<Traits>>();
    detection.add_shape_factory<CGAL::Shape_detection::Sphere<Traits>>();
    detection.add_shape_factory<CGAL::Shape_detection::Cone<Traits>>();
    detection.add_shape_factory<Cylinder>();
    Detection::Parameters parameters;
    parameters.probability = 0.01;
    parameters.min_points = 100;
    parameters.epsilon = 0.005;
    parameters.cluster_epsilon = 0.015;
    parameters.normal_threshold = 0.906;
    detection.detect(parameters);

    std::vector<std::pair<std::size_t, std::array<double, 7>>> found;
    for (const auto &shape : detection.shapes()) {
        const auto *cylinder = dynamic_cast<const Cylinder *>(shape.get());
        if (cylinder == nullptr || cylinder->radius() < 0.005 || cylinder->radius() > 0.15) {
            continue;
        }
        const Kernel::Line_3 axis = cylinder->axis();
        const Kernel::Point_3 point = axis.point(0);
        const Kernel::Vector_3 direction = axis.to_vector();
        found.push_back({cylinder->indices_of_assigned_points().size(),
                         {point.x(), point.y(), point.z(), direction.x(), direction.y(), direction.z(),
                          cylinder->radius()}});
    }
    std::stable_sort(found.begin(), found.end(), [](const auto &a, const auto &b) { return a.first > b.first; });
    for (const auto &one : found) {
        print_cylinder(one.second);
    }
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

// Cylinders by the Point Cloud Library, for `cylfuse bench --pcl`: the points of bench_points.hpp come in.
//
// bench_pcl        one cylinder of all points, by pcl_pipeline.hpp; nothing is printed where none is found
// bench_pcl scene  all cylinders, as PCL's tutorials take a scene apart: one point in each 4 mm; normals; planes with more
//                  than a tenth of the points are taken away, with what is within 10 mm; what is left in clusters 15 mm apart;
//                  in each cluster cylinders one after the other, as long as one has at least 100 points and a quarter of what
//                  is left of the cluster. At most 100 iterations for a plane, as in the tutorial, and 1000 for a cylinder: one
//                  with a quarter of the points takes some seventy.
#include "bench_points.hpp"
#include "pcl_pipeline.hpp"

#include <pcl/filters/extract_indices.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/segmentation/extract_clusters.h>

#include <algorithm>

using namespace pcl_pipeline;

static constexpr std::size_t FEWEST = 100;

// The points of these indices, or all others.
template <class Point>
static typename pcl::PointCloud<Point>::Ptr extract(const typename pcl::PointCloud<Point>::ConstPtr &cloud,
                                                    const pcl::PointIndices &indices, bool others)
{
    const typename pcl::PointCloud<Point>::Ptr part(new pcl::PointCloud<Point>);
    pcl::ExtractIndices<Point> extraction;
    extraction.setInputCloud(cloud);
    extraction.setIndices(pcl::make_shared<const pcl::PointIndices>(indices));
    extraction.setNegative(others);
    extraction.filter(*part);
    return part;
}

struct Found {
    std::size_t points;
    std::vector<float> values;
};

static std::vector<Found> cylinders_of_scene(const Cloud::ConstPtr &all)
{
    Cloud::Ptr cloud(new Cloud);
    pcl::VoxelGrid<pcl::PointXYZ> grid;
    grid.setInputCloud(all);
    grid.setLeafSize(0.004f, 0.004f, 0.004f);
    grid.filter(*cloud);
    const std::size_t share = cloud->size() / 10;
    Normals::Ptr normals = normals_of(cloud);
    pcl::SACSegmentation<pcl::PointXYZ> planes;
    planes.setModelType(pcl::SACMODEL_PLANE);
    planes.setMethodType(pcl::SAC_RANSAC);
    planes.setMaxIterations(100);
    planes.setDistanceThreshold(0.01);
    planes.setOptimizeCoefficients(true);
    while (cloud->size() >= FEWEST) {
        planes.setInputCloud(cloud);
        Segment plane;
        planes.segment(plane.inliers, plane.coefficients);
        if (plane.inliers.indices.size() <= share) {
            break;
        }
        cloud = extract<pcl::PointXYZ>(cloud, plane.inliers, true);
        normals = extract<pcl::Normal>(normals, plane.inliers, true);
    }
    std::vector<pcl::PointIndices> clusters;
    if (!cloud->empty()) {
        pcl::EuclideanClusterExtraction<pcl::PointXYZ> clustering;
        clustering.setClusterTolerance(0.015);
        clustering.setMinClusterSize(int(FEWEST));
        clustering.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
        clustering.setInputCloud(cloud);
        clustering.extract(clusters);
    }
    Segmentation segmentation;
    std::vector<Found> found;
    for (const pcl::PointIndices &cluster : clusters) {
        Cloud::Ptr part = extract<pcl::PointXYZ>(cloud, cluster, false);
        Normals::Ptr part_normals = extract<pcl::Normal>(normals, cluster, false);
        while (part->size() >= FEWEST) {
            const Segment cylinder = segment(segmentation, part, part_normals, 1000);
            const std::size_t inliers = cylinder.inliers.indices.size();
            if (inliers < std::max(FEWEST, part->size() / 4) || cylinder.coefficients.values.size() != 7) {
                break;
            }
            found.push_back({inliers, cylinder.coefficients.values});
            part = extract<pcl::PointXYZ>(part, cylinder.inliers, true);
            part_normals = extract<pcl::Normal>(part_normals, cylinder.inliers, true);
        }
    }
    std::stable_sort(found.begin(), found.end(), [](const Found &a, const Found &b) { return a.points > b.points; });
    return found;
}

int main(int argc, char **argv)
try {
    const Cloud::Ptr cloud(new Cloud);
    for (const BenchPoint &point : read_points()) {
        cloud->push_back({point.x, point.y, point.z});
    }
    if (wants_scene(argc, argv)) {
        for (const Found &one : cylinders_of_scene(cloud)) {
            print_cylinder(one.values);
        }
        return 0;
    }
    Segmentation segmentation;
    const Segment found = segment(segmentation, cloud, normals_of(cloud));
    if (found.coefficients.values.size() == 7) {
        print_cylinder(found.coefficients.values);
    }
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

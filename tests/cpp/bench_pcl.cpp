// Fits a cylinder to a cloud by the Point Cloud Library, for `cylfuse bench --pcl`: reads x, y, z of all points in metres as
// 32-bit floating-point numbers from its standard input until that ends, and prints point, direction and radius.
//
// Normals from 50 neighbours, their weight 0.1, a threshold of 5 mm, at most 10,000 iterations, radius 5 to 150 mm,
// coefficients optimised: PCL's tutorial on cylinder segmentation with the threshold of a depth camera.
#include <pcl/features/normal_3d.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <cstdio>

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

int main()
try {
    const Cloud::Ptr cloud(new Cloud);
    float point[3];
    while (std::fread(point, sizeof point, 1, stdin) == 1) {
        cloud->push_back({point[0], point[1], point[2]});
    }
    const pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
    pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
    estimation.setInputCloud(cloud);
    estimation.setKSearch(50);
    estimation.compute(*normals);
    pcl::SACSegmentationFromNormals<pcl::PointXYZ, pcl::Normal> segmentation;
    segmentation.setOptimizeCoefficients(true);
    segmentation.setModelType(pcl::SACMODEL_CYLINDER);
    segmentation.setMethodType(pcl::SAC_RANSAC);
    segmentation.setNormalDistanceWeight(0.1);
    segmentation.setMaxIterations(10000);
    segmentation.setDistanceThreshold(0.005);
    segmentation.setRadiusLimits(0.005, 0.15);
    segmentation.setInputCloud(cloud);
    segmentation.setInputNormals(normals);
    pcl::PointIndices inliers;
    pcl::ModelCoefficients coefficients;
    segmentation.segment(inliers, coefficients);
    if (coefficients.values.size() != 7) {
        return 1;
    }
    for (const float value : coefficients.values) {
        std::printf("%.9g ", static_cast<double>(value));
    }
    std::printf("\n");
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

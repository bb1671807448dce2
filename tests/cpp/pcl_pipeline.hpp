// A cylinder by the Point Cloud Library as its users segment one: normals from 50 neighbours, their weight 0.1, a threshold of
// 5 mm, at most 10,000 iterations, radius 5 to 150 mm, coefficients optimised. That is PCL's tutorial on cylinder
// segmentation with the threshold of a depth camera.
#pragma once

#include <pcl/features/normal_3d.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/sac_segmentation.h>

namespace pcl_pipeline {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Normals = pcl::PointCloud<pcl::Normal>;
using Segmentation = pcl::SACSegmentationFromNormals<pcl::PointXYZ, pcl::Normal>;

inline Normals::Ptr normals_of(const Cloud::ConstPtr &cloud)
{
    pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    const Normals::Ptr normals(new Normals);
    estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
    estimation.setInputCloud(cloud);
    estimation.setKSearch(50);
    estimation.compute(*normals);
    return normals;
}

// What was segmented: no coefficients where there is nothing.
struct Segment {
    pcl::PointIndices inliers;
    pcl::ModelCoefficients coefficients;
};

// Segments a cylinder; a class with the interface of PCL's may do without the normals.
inline Segment segment(Segmentation &segmentation, const Cloud::ConstPtr &cloud, const Normals::ConstPtr &normals,
                       int iterations = 10000)
{
    segmentation.setOptimizeCoefficients(true);
    segmentation.setModelType(pcl::SACMODEL_CYLINDER);
    segmentation.setMethodType(pcl::SAC_RANSAC);
    segmentation.setNormalDistanceWeight(0.1);
    segmentation.setMaxIterations(iterations);
    segmentation.setDistanceThreshold(0.005);
    segmentation.setRadiusLimits(0.005, 0.15);
    segmentation.setInputCloud(cloud);
    if (normals) {
        segmentation.setInputNormals(normals);
    }
    Segment found;
    segmentation.segment(found.inliers, found.coefficients);
    return found;
}

} // namespace pcl_pipeline

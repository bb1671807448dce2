// PCL's tutorial on cylinder segmentation, without its normals: 03_pcl_pipeline CLOUD.pcd OUTPUT.pcd FX FY CX CY
//
// Takes the plane out of an organised cloud, fits a cylinder to the rest, and completes its surface as the camera
// with these intrinsics sees it.
#include <cylfuse/pcl.hpp>

#include <pcl/filters/extract_indices.h>
#include <pcl/io/pcd_io.h>

#include <cstdio>
#include <cstdlib>

using PointT = pcl::PointXYZ;

// Indices of the points in front of `farthest`. Points without a measurement are in no range.
static pcl::IndicesPtr in_range(const pcl::PointCloud<PointT> &cloud, float farthest)
{
    auto indices = pcl::make_shared<pcl::Indices>();
    for (std::size_t k = 0; k < cloud.size(); ++k) {
        if (cloud[k].z < farthest) {
            indices->push_back(pcl::index_t(k));
        }
    }
    return indices;
}

int main(int argc, char **argv)
try {
    if (argc != 7) {
        std::fprintf(stderr, "usage: %s CLOUD.pcd OUTPUT.pcd FX FY CX CY\n", argv[0]);
        return 2;
    }
    const pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
    if (pcl::io::loadPCDFile(argv[1], *cloud) != 0) {
        return 1;
    }
    const pcl::IndicesPtr scene = in_range(*cloud, 1.5F);

    pcl::SACSegmentation<PointT> plane_segmentation;
    pcl::PointIndices::Ptr plane(new pcl::PointIndices);
    pcl::ModelCoefficients plane_coefficients;
    plane_segmentation.setModelType(pcl::SACMODEL_PLANE);
    plane_segmentation.setMethodType(pcl::SAC_RANSAC);
    plane_segmentation.setMaxIterations(100);
    plane_segmentation.setDistanceThreshold(0.01);
    plane_segmentation.setInputCloud(cloud);
    plane_segmentation.setIndices(scene);
    plane_segmentation.segment(*plane, plane_coefficients);
    std::printf("plane: %zu of %zu points\n", plane->indices.size(), scene->size());

    pcl::ExtractIndices<PointT> extract;
    const pcl::IndicesPtr rest(new pcl::Indices);
    extract.setInputCloud(cloud);
    extract.setIndices(plane);
    extract.setNegative(true);
    extract.filter(*rest);

    // Here PCL's class would need normals: pcl::SACSegmentationFromNormals<PointT, pcl::Normal>.
    cylfuse::CylinderSegmentation<PointT> segmentation;
    pcl::PointIndices inliers;
    pcl::ModelCoefficients coefficients;
    segmentation.setModelType(pcl::SACMODEL_CYLINDER);
    segmentation.setMethodType(pcl::SAC_RANSAC);
    segmentation.setMaxIterations(1000);
    segmentation.setDistanceThreshold(0.005);
    segmentation.setInputCloud(cloud);
    segmentation.setIndices(rest);
    segmentation.segment(inliers, coefficients);
    if (coefficients.values.empty()) {
        return 1; // The class has said why, as PCL's does.
    }
    std::printf("cylinder: %zu inliers, radius %.1f mm\n", inliers.indices.size(), 1e3 * coefficients.values[6]);

    // How far the inliers reach along the axis.
    const cylfuse::Cylinder model = cylfuse::to_cylinder(coefficients);
    const auto along = [&](const PointT &p) {
        const double offset[] = {p.x - model.point[0], p.y - model.point[1], p.z - model.point[2]};
        return offset[0] * model.direction[0] + offset[1] * model.direction[1] + offset[2] * model.direction[2];
    };
    double low = 1e9, high = -1e9;
    for (const pcl::index_t index : inliers.indices) {
        low = std::min(low, along((*cloud)[std::size_t(index)]));
        high = std::max(high, along((*cloud)[std::size_t(index)]));
    }

    // The surface at all pixels, and of that what lies between the ends.
    cylfuse::Fitter fitter;
    fitter.set_intrinsics(cylfuse::Intrinsics(cloud->width, cloud->height, std::atof(argv[3]), std::atof(argv[4]),
                                              std::atof(argv[5]), std::atof(argv[6])));
    const std::vector<std::uint8_t> everywhere(cloud->size(), 255);
    const cylfuse::MaskView mask(everywhere.data(), cloud->width, cloud->height);
    pcl::PointCloud<PointT> surface, completed;
    cylfuse::complete(fitter, surface, model, mask);
    for (const PointT &point : surface) {
        if (along(point) >= low && along(point) <= high) {
            completed.push_back(point);
        }
    }
    pcl::io::savePCDFileBinary(argv[2], completed);
    std::printf("completed: %zu points\n", completed.size());
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

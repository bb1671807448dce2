// All cylinders of a cloud, in place of PCL's tutorial on cylinder segmentation with its filters, normals and planes:
// 03_pcl_pipeline CLOUD.pcd OUTPUT.pcd [FX FY CX CY]
//
// With the intrinsics of the camera that the organised cloud is from, its surfaces are completed to what the camera sees
// of them; without, the output has the points that were measured.
#include <cylfuse/pcl.hpp>

#include <pcl/common/io.h>
#include <pcl/io/pcd_io.h>

#include <cstdio>
#include <cstdlib>

using PointT = pcl::PointXYZ;

int main(int argc, char **argv)
try {
    if (argc != 3 && argc != 7) {
        std::fprintf(stderr, "usage: %s CLOUD.pcd OUTPUT.pcd [FX FY CX CY]\n", argv[0]);
        return 2;
    }
    const pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
    if (pcl::io::loadPCDFile(argv[1], *cloud) != 0) {
        return 1;
    }
    cylfuse::CylinderDetection<PointT> detection;
    detection.setInputCloud(cloud);
    if (argc == 7) {
        detection.setIntrinsics(cylfuse::Intrinsics(cloud->width, cloud->height, std::atof(argv[3]), std::atof(argv[4]),
                                                    std::atof(argv[5]), std::atof(argv[6])));
    }
    std::vector<pcl::ModelCoefficients> coefficients;
    std::vector<pcl::PointIndices> inliers;
    detection.segment(coefficients, inliers);
    if (detection.getError().status() != cylfuse::Status::Ok) {
        return 1; // The class has said why, as PCL's does.
    }
    std::printf("%zu cylinders in %zu points\n", coefficients.size(), cloud->size());

    const std::vector<cylfuse::Detection> found = detection.getDetector().detections();
    pcl::PointCloud<PointT> output, piece;
    for (std::size_t k = 0; k < coefficients.size(); ++k) {
        std::printf("%zu: %zu points, radius %.1f mm, score %.2f\n", k + 1, inliers[k].indices.size(),
                    1e3 * coefficients[k].values[6], found[k].score);
        if (argc == 7) {
            cylfuse::complete(detection.getDetector().make_fitter(k), piece);
        } else {
            pcl::copyPointCloud(*cloud, inliers[k], piece);
        }
        output += piece;
    }
    if (output.empty()) {
        return 1;
    }
    pcl::io::savePCDFileBinary(argv[2], output);
    std::printf("output: %zu points\n", output.size());
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

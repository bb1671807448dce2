// The visible surface without holes, and the ends: 06_completion_pcd FOLDER OUTPUT.pcd
//
// Writes the measured points in the mask, the completed surface and both ends into one cloud, told apart by colour.
#include "frame.hpp"

#include <cylfuse/pcl.hpp>

#include <pcl/io/pcd_io.h>

#include <cstdio>

using PointT = pcl::PointXYZRGB;

static const char *name(cylfuse::EndState state)
{
    switch (state) {
    case cylfuse::EndState::Seen: return "seen";
    case cylfuse::EndState::Cut: return "cut by the border of the image";
    case cylfuse::EndState::Hidden: return "hidden";
    default: return "unknown";
    }
}

int main(int argc, char **argv)
try {
    if (argc != 3) {
        std::fprintf(stderr, "usage: %s FOLDER OUTPUT.pcd\n", argv[0]);
        return 2;
    }
    const Frame frame(argv[1]);
    cylfuse::Fitter fitter;
    fitter.set_intrinsics(frame.camera);
    fitter.push_depth(frame.depth_view(), frame.mask_view());
    fitter.push_edges(frame.edges);
    const cylfuse::CylinderFit fit = fitter.fit();

    pcl::PointCloud<PointT> cloud;
    const cylfuse::Completion completion = cylfuse::complete(fitter, cloud);
    for (PointT &point : cloud) {
        point.r = 60, point.g = 140, point.b = 255;
    }
    const cylfuse::Extent extent = fitter.extent();
    for (const double *end : {extent.start, extent.end}) {
        PointT point;
        point.x = float(end[0]), point.y = float(end[1]), point.z = float(end[2]);
        point.r = 255, point.g = 60, point.b = 60;
        cloud.push_back(point);
    }
    pcl::io::savePCDFileBinary(argv[2], cloud);

    std::printf("radius %.2f mm, length %.2f mm\n", 1e3 * fit.cylinder.model.radius, 1e3 * extent.length);
    std::printf("one end %s, the other %s\n", name(extent.start_state()), name(extent.end_state()));
    std::printf("%llu points measured, %llu completed, %llu rays miss\n", (unsigned long long)fit.result.points_used,
                (unsigned long long)completion.count, (unsigned long long)completion.misses);
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

// Every header a second time, in a second translation unit of one program.
#include <cylfuse/eigen.hpp>
#include <cylfuse/opencv.hpp>
#include <cylfuse/pcl.hpp>

#include <cylfuse/cylfuse.h>
#include <cylfuse/cylfuse.hpp>
#include <cylfuse/eigen.hpp>
#include <cylfuse/opencv.hpp>
#include <cylfuse/pcl.hpp>

double radius_in_another_unit(const pcl::PointCloud<pcl::PointXYZ> &cloud);
double radius_in_another_unit(const pcl::PointCloud<pcl::PointXYZ> &cloud)
{
    cylfuse::Fitter fitter;
    fitter.push_points(cylfuse::points_view(cloud));
    return fitter.fit().cylinder.model.radius;
}

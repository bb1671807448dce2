// Eigen in and out.
#include "check.hpp"

#include <cylfuse/eigen.hpp>

template <class Points>
static double radius(const Points &points)
{
    cylfuse::Fitter fitter;
    fitter.push_points(cylfuse::points_view(points));
    return fitter.fit().model.radius;
}

int main()
{
    const auto points = pipe_points(30, 10, -1.0, 1.0);
    Eigen::Matrix3Xd columns(3, 300);
    Eigen::Matrix<float, Eigen::Dynamic, 4, Eigen::RowMajor> rows(300, 4);
    Eigen::MatrixXd wide = Eigen::MatrixXd::Constant(7, 300, NAN);
    std::vector<Eigen::Vector3f> list;
    std::vector<Eigen::Vector4d, Eigen::aligned_allocator<Eigen::Vector4d>> homogeneous;
    for (int k = 0; k < 300; ++k) {
        const Eigen::Vector3d p(points[std::size_t(k)].data());
        columns.col(k) = p;
        rows.row(k) << p.cast<float>().transpose(), 1.0F;
        wide.block<3, 1>(2, k) = p;
        list.push_back(p.cast<float>());
        homogeneous.push_back(p.homogeneous());
    }
    CHECK_NEAR(radius(columns), 0.05, 1e-9);
    CHECK_NEAR(radius(rows), 0.05, 1e-6);
    CHECK_NEAR(radius(wide.middleRows<3>(2)), 0.05, 1e-9);
    CHECK_NEAR(radius(columns.leftCols(200)), 0.05, 1e-9);
    CHECK_NEAR(radius(list), 0.05, 1e-6);
    CHECK_NEAR(radius(homogeneous), 0.05, 1e-9);
    CHECK_ERROR(radius(Eigen::Matrix3Xd(3, 0)), TOO_FEW_POINTS, "0 of 0 points");

    // The radius is the last of the seven numbers.
    cylfuse::Fitter fitter;
    fitter.push_points(cylfuse::points_view(list));
    const cylfuse::Result result = fitter.fit();
    const Eigen::Matrix<double, 7, 7> covariance = cylfuse::covariance(result);
    CHECK_NEAR(std::sqrt(covariance(6, 6)), result.radius_deviation, 1e-12);
    CHECK(covariance.isApprox(covariance.transpose()));

    const cylfuse::Cylinder model =
        cylfuse::make_cylinder(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 0, 2), 0.5);
    CHECK(cylfuse::point(model) == Eigen::Vector3d(1, 2, 3) && model.radius == 0.5);
    CHECK(cylfuse::direction(model) == Eigen::Vector3d(0, 0, 2));
    CHECK_NEAR(cylfuse::axis(model).distance(Eigen::Vector3d(1, 5, 9)), 3.0, 1e-12);
    Eigen::Matrix3d k;
    k << 500, 0, 320, 0, 510, 240, 0, 0, 1;
    const cylfuse::Intrinsics camera = cylfuse::intrinsics(k, 640, 480);
    CHECK(camera.fx == 500 && camera.fy == 510 && camera.cx == 320 && camera.cy == 240 && camera.width == 640);
    return finish("Eigen");
}

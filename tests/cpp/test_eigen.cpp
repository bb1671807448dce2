// Eigen in and out.
#include "check.hpp"

#include <cylfuse/eigen.hpp>

// Whether there is a view of it.
template <class Points, class = void>
struct HasView : std::false_type {};
template <class Points>
struct HasView<Points, decltype(void(cylfuse::points_view(std::declval<Points>())))> : std::true_type {};

static_assert(HasView<Eigen::Matrix3Xd &>::value && HasView<const Eigen::Array3Xf &>::value, "stays");
static_assert(!HasView<Eigen::Matrix3Xd>::value && !HasView<const Eigen::Matrix3Xd>::value, "a matrix that is gone");
static_assert(!HasView<Eigen::Array3Xf>::value, "an array that is gone");
static_assert(HasView<Eigen::Map<const Eigen::Matrix3Xd>>::value, "a map, whatever it points to");
static_assert(!HasView<std::vector<Eigen::Vector3f>>::value, "a vector that is gone");

static double radius(const cylfuse::PointsView &points)
{
    cylfuse::Fitter fitter;
    fitter.push_points(points);
    return fitter.fit().cylinder.model.radius;
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
    CHECK_NEAR(radius(cylfuse::points_view(columns)), 0.05, 1e-9);
    CHECK_NEAR(radius(cylfuse::points_view(rows)), 0.05, 1e-6);
    CHECK_NEAR(radius(cylfuse::points_view(wide.middleRows<3>(2))), 0.05, 1e-9);
    CHECK_NEAR(radius(cylfuse::points_view(columns.leftCols(200))), 0.05, 1e-9);
    CHECK_NEAR(radius(cylfuse::points_view(list)), 0.05, 1e-6);
    CHECK_NEAR(radius(cylfuse::points_view(homogeneous)), 0.05, 1e-9);
    const Eigen::Matrix3Xd none(3, 0);
    CHECK_ERROR(radius(cylfuse::points_view(none)), TOO_FEW_POINTS, "0 of 0 points");

    // The radius is the last of the seven numbers.
    cylfuse::Fitter fitter;
    fitter.push_points(cylfuse::points_view(list));
    const cylfuse::CylinderEstimate cylinder = fitter.fit().cylinder;
    const Eigen::Matrix<double, 7, 7> covariance = cylfuse::covariance(cylinder);
    CHECK_NEAR(std::sqrt(covariance(6, 6)), cylinder.radius_deviation, 1e-12);
    CHECK(covariance.isApprox(covariance.transpose()));

    const cylfuse::Cylinder model =
        cylfuse::make_cylinder(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 0, 2), 0.5);
    CHECK(cylfuse::point(model) == Eigen::Vector3d(1, 2, 3) && model.radius == 0.5);
    CHECK(cylfuse::direction(model) == Eigen::Vector3d(0, 0, 2));
    CHECK_NEAR(cylfuse::axis(model).distance(Eigen::Vector3d(1, 5, 9)), 3.0, 1e-12);
    const Eigen::Isometry3d pose =
        Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 2).normalized());
    const cylfuse::RigidMotion motion = cylfuse::rigid_motion(pose);
    CHECK(motion.rotation[1] == pose(0, 1) && motion.translation[2] == 3.0);
    CHECK(cylfuse::isometry(motion).isApprox(pose, 1e-15));
    Eigen::Matrix3d k;
    k << 500, 0, 320, 0, 510, 240, 0, 0, 1;
    const cylfuse::Intrinsics camera = cylfuse::intrinsics(k, 640, 480);
    CHECK(camera.fx == 500 && camera.fy == 510 && camera.cx == 320 && camera.cy == 240 && camera.width == 640);
    return finish("Eigen");
}

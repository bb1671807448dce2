/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file eigen.hpp
 * Eigen types in and out. Include it beside Eigen 3.3 or later; it fails in no call, so it serves with and without
 * exceptions.
 */

#ifndef CYLFUSE_EIGEN_HPP
#define CYLFUSE_EIGEN_HPP

#include <cylfuse/cylfuse.hpp>

#include <Eigen/Geometry>

namespace cylfuse {

/** The point on the axis, in the unit of length of the data. */
inline Eigen::Vector3d point(const Cylinder &model)
{
    return Eigen::Map<const Eigen::Vector3d>(model.point);
}

/** The direction of the axis, of length 1 for what the library gives. */
inline Eigen::Vector3d direction(const Cylinder &model)
{
    return Eigen::Map<const Eigen::Vector3d>(model.direction);
}

/** The axis as a line; its direction has length 1. */
inline Eigen::ParametrizedLine<double, 3> axis(const Cylinder &model)
{
    return {point(model), direction(model).normalized()};
}

/** A cylinder from a point on its axis, a direction of any length but 0 and a radius. */
inline Cylinder make_cylinder(const Eigen::Vector3d &point, const Eigen::Vector3d &direction, double radius)
{
    Cylinder model;
    Eigen::Map<Eigen::Vector3d>(model.point) = point;
    Eigen::Map<Eigen::Vector3d>(model.direction) = direction;
    model.radius = radius;
    return model;
}

/** The covariance of point, direction and radius of a fit: symmetric, of rank 5; NaN where there is none. */
inline Eigen::Matrix<double, 7, 7> covariance(const cylfuse_cylinder_estimate &cylinder)
{
    return Eigen::Map<const Eigen::Matrix<double, 7, 7>>(cylinder.covariance);
}

/** A pose, or the way from a depth camera to the colour camera. */
inline RigidMotion rigid_motion(const Eigen::Isometry3d &transform)
{
    RigidMotion motion;
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(motion.rotation.data()) = transform.linear();
    Eigen::Map<Eigen::Vector3d>(motion.translation.data()) = transform.translation();
    return motion;
}

/** The transform of Eigen of a pose. */
inline Eigen::Isometry3d isometry(const RigidMotion &motion)
{
    Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
    transform.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(motion.rotation.data());
    transform.translation() = Eigen::Map<const Eigen::Vector3d>(motion.translation.data());
    return transform;
}

/** A pinhole from a camera matrix [fx 0 cx; 0 fy cy; 0 0 1], of which only these four numbers are read. */
inline Intrinsics intrinsics(const Eigen::Matrix3d &camera_matrix, std::uint32_t width, std::uint32_t height)
{
    const Eigen::Matrix3d &k = camera_matrix;
    return Intrinsics(width, height, k(0, 0), k(1, 1), k(0, 2), k(1, 2));
}

/**
 * Points in the columns of a column-major matrix of 3 or 4 rows (x y z, and one that is not read), or in the rows of
 * a row-major one of 3 or 4 columns. Blocks and maps with strides pass too, as long as x, y, z are adjacent.
 *
 * The view points to the coefficients, which must stay. Of a matrix that is about to vanish there is none; but of a block or a
 * map nobody can tell whose coefficients they are: `points_view(Eigen::Matrix3Xd(2 * a).leftCols(5))` compiles, and points to
 * what is gone.
 */
template <class Derived>
PointsView points_view(const Eigen::DenseBase<Derived> &matrix)
{
    using Scalar = typename Derived::Scalar;
    constexpr int across = Derived::IsRowMajor ? Derived::ColsAtCompileTime : Derived::RowsAtCompileTime;
    static_assert(across == 3 || across == 4,
                  "the points must be the columns of a column-major matrix with 3 or 4 rows, or the rows of a "
                  "row-major matrix with 3 or 4 columns: x, y, z of a point are adjacent then; transpose or copy it");
    static_assert(int(Eigen::internal::inner_stride_at_compile_time<Derived>::ret) == 1,
                  "x, y, z of a point must be adjacent in memory; copy the points into a matrix first");
    const Derived &points = matrix.derived();
    const auto stride = static_cast<std::ptrdiff_t>(points.outerStride() * Eigen::Index(sizeof(Scalar)));
    return PointsView(points.data(), static_cast<std::size_t>(points.size() / across), 1, stride);
}

/** Would point to points that are gone: those of a matrix or an array, not of a block or a map. */
template <class Derived>
PointsView points_view(const Eigen::PlainObjectBase<Derived> &&matrix) = delete;

/** Points in a vector of Eigen::Vector3f, Vector3d, Vector4f or Vector4d, of which x, y, z are read. */
template <class Scalar, int Rows, int Options, class Allocator>
PointsView points_view(const std::vector<Eigen::Matrix<Scalar, Rows, 1, Options>, Allocator> &points)
{
    static_assert(Rows == 3 || Rows == 4, "a point has 3 coordinates, or 4 of which the last is not read");
    const Scalar *first = points.empty() ? nullptr : points.front().data();
    return PointsView(first, points.size(), 1, sizeof(Eigen::Matrix<Scalar, Rows, 1, Options>));
}

/** Would point to points that are gone. */
template <class Scalar, int Rows, int Options, class Allocator>
PointsView points_view(const std::vector<Eigen::Matrix<Scalar, Rows, 1, Options>, Allocator> &&points) = delete;

} // namespace cylfuse

#endif

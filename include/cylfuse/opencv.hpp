/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file opencv.hpp
 * Images, camera matrices and line segments of OpenCV in and out, and a drawing of what was found. Include it beside
 * OpenCV 4 with the modules core, imgproc and calib3d. Views point into the `cv::Mat`, which must stay.
 */

#ifndef CYLFUSE_OPENCV_HPP
#define CYLFUSE_OPENCV_HPP

#ifdef CYLFUSE_NO_EXCEPTIONS
#error "cylfuse/opencv.hpp throws, as OpenCV does: compile without CYLFUSE_NO_EXCEPTIONS"
#endif

#include <cylfuse/cylfuse.hpp>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace cylfuse {
inline namespace with_exceptions {

/** @cond internal */
namespace detail {

inline void check_image(const cv::Mat &image, const char *what, std::initializer_list<int> types,
                        const char *needed)
{
    const std::string name(what);
    if (image.empty()) {
        throw Error(Status::InvalidArgument,
                    (name + " is empty; was the file read, the camera ready?").c_str());
    }
    if (image.dims != 2) {
        throw Error(Status::InvalidArgument,
                    (name + " has " + std::to_string(image.dims) + " dimensions; it must have 2").c_str());
    }
    for (const int type : types) {
        if (image.type() == type) {
            return;
        }
    }
    throw Error(Status::InvalidArgument, (name + " is of type " + cv::typeToString(image.type()) +
                                                  "; it must be of type " + needed)
                                                     .c_str());
}

inline std::ptrdiff_t row_stride(const cv::Mat &image)
{
    return static_cast<std::ptrdiff_t>(image.step[0]);
}

inline void check_size(const cv::Mat &image, const char *what, const cylfuse_intrinsics &intrinsics)
{
    if (std::uint32_t(image.cols) != intrinsics.width || std::uint32_t(image.rows) != intrinsics.height) {
        throw Error(Status::SizeMismatch,
                    (std::string(what) + " is " + std::to_string(image.cols) + " x " +
                     std::to_string(image.rows) + " but the intrinsics are for " +
                     std::to_string(intrinsics.width) + " x " + std::to_string(intrinsics.height) +
                     "; both must have the same size: scale the image, or give the intrinsics for its size")
                        .c_str());
    }
}

inline Intrinsics intrinsics(cv::InputArray camera_matrix, cv::Size size)
{
    cv::Mat_<double> k;
    const cv::Mat given = camera_matrix.getMat();
    if (given.rows != 3 || given.cols != 3 || given.channels() != 1) {
        throw Error(Status::InvalidIntrinsics,
                    ("the camera matrix is " + std::to_string(given.cols) + " x " + std::to_string(given.rows) +
                     " of type " + cv::typeToString(given.type()) + "; it must be 3 x 3 with one channel")
                        .c_str());
    }
    given.convertTo(k, CV_64F);
    if (k(0, 1) != 0.0 || k(1, 0) != 0.0 || k(2, 0) != 0.0 || k(2, 1) != 0.0 || k(2, 2) != 1.0) {
        throw Error(Status::InvalidIntrinsics,
                    "the camera matrix must be [fx 0 cx; 0 fy cy; 0 0 1]: no skew, last row 0 0 1");
    }
    if (size.width <= 0 || size.height <= 0) {
        throw Error(Status::InvalidIntrinsics, ("the image size is " + std::to_string(size.width) + " x " +
                                                        std::to_string(size.height) + "; it must be positive")
                                                           .c_str());
    }
    return Intrinsics(static_cast<std::uint32_t>(size.width), static_cast<std::uint32_t>(size.height), k(0, 0),
                      k(1, 1), k(0, 2), k(1, 2));
}

inline cv::Mat_<double> coefficients(cv::InputArray distortion)
{
    cv::Mat_<double> row;
    const cv::Mat given = distortion.getMat();
    if (given.empty()) {
        return row;
    }
    if (given.channels() != 1 || (given.rows != 1 && given.cols != 1)) {
        throw Error(Status::InvalidIntrinsics, "the distortion coefficients must be one row or one column");
    }
    given.convertTo(row, CV_64F);
    return row.reshape(1, 1);
}

} // namespace detail
/** @endcond */

/** A depth image CV_16UC1 or CV_32FC1, z = value * `unit`: 0.001 for millimetres when lengths are in metres. */
inline DepthView depth_view(const cv::Mat &depth, double unit)
{
    detail::check_image(depth, "the depth image", {CV_16UC1, CV_32FC1}, "CV_16UC1 or CV_32FC1");
    const auto columns = static_cast<std::uint32_t>(depth.cols);
    const auto rows = static_cast<std::uint32_t>(depth.rows);
    return depth.type() == CV_16UC1
               ? DepthView(depth.ptr<std::uint16_t>(), columns, rows, unit, detail::row_stride(depth))
               : DepthView(depth.ptr<float>(), columns, rows, unit, detail::row_stride(depth));
}

/** A mask CV_8UC1: `label`, or where that is 0 all that is not 0, = the cylinder, or the whole object: see MaskView. */
inline MaskView mask_view(const cv::Mat &mask, std::uint8_t label = 0)
{
    detail::check_image(mask, "the mask", {CV_8UC1}, "CV_8UC1");
    MaskView view(mask.ptr<std::uint8_t>(), static_cast<std::uint32_t>(mask.cols),
                  static_cast<std::uint32_t>(mask.rows), detail::row_stride(mask));
    view.label = label;
    return view;
}

/**
 * An image: grey, CV_8UC1, CV_16UC1 or CV_32FC1, or in colour as OpenCV has it, CV_8UC3 (BGR) or CV_8UC4 (BGRA).
 * `gamma` is 1 for values linear in light and 2.2 for sRGB, in which cameras and image files usually come.
 */
inline ImageView image_view(const cv::Mat &image, double gamma = 1.0)
{
    detail::check_image(image, "the image", {CV_8UC1, CV_16UC1, CV_32FC1, CV_8UC3, CV_8UC4},
                        "CV_8UC1, CV_16UC1, CV_32FC1, CV_8UC3 or CV_8UC4");
    ImageFormat format = ImageFormat::U8;
    switch (image.type()) {
    case CV_16UC1: format = ImageFormat::U16; break;
    case CV_32FC1: format = ImageFormat::F32; break;
    case CV_8UC3: format = ImageFormat::Bgr8; break;
    case CV_8UC4: format = ImageFormat::Bgra8; break;
    default: break;
    }
    ImageView view(image.data, format, static_cast<std::uint32_t>(image.cols), static_cast<std::uint32_t>(image.rows),
                   detail::row_stride(image));
    view.gamma = gamma;
    return view;
}

/** An organised cloud CV_32FC3 or CV_64FC3, such as cv::reprojectImageTo3D() and cv::rgbd give. */
inline PointsView points_view(const cv::Mat &points)
{
    detail::check_image(points, "the matrix of points", {CV_32FC3, CV_64FC3}, "CV_32FC3 or CV_64FC3");
    const auto columns = static_cast<std::size_t>(points.cols);
    const auto rows = static_cast<std::size_t>(points.rows);
    return points.type() == CV_32FC3
               ? PointsView(points.ptr<float>(), columns, rows, 0, detail::row_stride(points))
               : PointsView(points.ptr<double>(), columns, rows, 0, detail::row_stride(points));
}

/** Segments as cv::LineSegmentDetector and cv::ximgproc::FastLineDetector give them; Vec4d too. */
template <class T, class Allocator>
SegmentsView segments_view(const std::vector<cv::Vec<T, 4>, Allocator> &segments)
{
    const T *first = segments.empty() ? nullptr : segments.front().val;
    return SegmentsView(first, segments.size());
}

/** Would point to segments that are gone. */
template <class T, class Allocator>
SegmentsView segments_view(const std::vector<cv::Vec<T, 4>, Allocator> &&segments) = delete;

/** Segments in one row or column of a matrix CV_32FC4 or CV_64FC4, another output of the line detectors. */
inline SegmentsView segments_view(const cv::Mat &segments)
{
    if (segments.empty()) {
        return SegmentsView();
    }
    detail::check_image(segments, "the matrix of segments", {CV_32FC4, CV_64FC4}, "CV_32FC4 or CV_64FC4");
    if (segments.rows != 1 && segments.cols != 1) {
        throw Error(Status::InvalidArgument,
                    "the matrix of segments must be one row or one column, with a segment an element");
    }
    const auto stride = static_cast<std::ptrdiff_t>(segments.cols == 1 ? segments.step[0] : segments.elemSize());
    return segments.type() == CV_32FC4 ? SegmentsView(segments.ptr<float>(), segments.total(), stride)
                                       : SegmentsView(segments.ptr<double>(), segments.total(), stride);
}

/**
 * A camera as cv::calibrateCamera() gives it: camera matrix 3 x 3 and 0, 4, 5 or 8 coefficients k1 k2 p1 p2 k3 k4 k5
 * k6. Lists of 12 or 14 pass when the thin prism and the tilt are 0.
 */
inline Intrinsics intrinsics(cv::InputArray camera_matrix, cv::InputArray distortion, cv::Size size)
{
    Intrinsics camera = detail::intrinsics(camera_matrix, size);
    const cv::Mat_<double> row = detail::coefficients(distortion);
    const int count = row.cols;
    if (count != 0 && count != 4 && count != 5 && count != 8 && count != 12 && count != 14) {
        throw Error(Status::InvalidIntrinsics, ("there are " + std::to_string(count) +
                                                        " distortion coefficients; OpenCV has 0, 4, 5, 8, 12 or 14")
                                                           .c_str());
    }
    for (int k = 0; k < count; ++k) {
        if (k < 8) {
            camera.distortion[k] = row(k);
        } else if (row(k) != 0.0) {
            throw Error(Status::Unsupported, "thin prism and tilt of the sensor are not supported; calibrate "
                                                    "with k1 k2 p1 p2 k3 k4 k5 k6, or undistort the images");
        }
    }
    camera.distortion_model(count == 0 ? Distortion::None : Distortion::BrownConrady);
    return camera;
}

/** A camera as cv::fisheye::calibrate() gives it: camera matrix 3 x 3 and 4 coefficients. */
inline Intrinsics fisheye_intrinsics(cv::InputArray camera_matrix, cv::InputArray distortion, cv::Size size)
{
    Intrinsics camera = detail::intrinsics(camera_matrix, size);
    const cv::Mat_<double> row = detail::coefficients(distortion);
    if (row.cols != 4) {
        throw Error(Status::InvalidIntrinsics, ("there are " + std::to_string(row.cols) +
                                                        " distortion coefficients; the fisheye model has 4")
                                                           .c_str());
    }
    for (int k = 0; k < 4; ++k) {
        camera.distortion[k] = row(k);
    }
    camera.distortion_model(Distortion::KannalaBrandt);
    return camera;
}

/**
 * A pose, or the way from a depth camera to the colour camera, as cv::stereoCalibrate() and cv::solvePnP() give it: a
 * rotation matrix 3 x 3 or a rotation vector, and a translation.
 */
inline RigidMotion rigid_motion(cv::InputArray rotation, cv::InputArray translation)
{
    const cv::Mat r = rotation.getMat(), t = translation.getMat();
    const auto numbers_in = [](const cv::Mat &m) { return m.total() * static_cast<std::size_t>(m.channels()); };
    if (numbers_in(r) != 3 && (r.rows != 3 || r.cols != 3 || r.channels() != 1)) {
        throw Error(Status::InvalidArgument, "the rotation must be a matrix 3 x 3 or a vector of 3 numbers");
    }
    if (numbers_in(t) != 3) {
        throw Error(Status::InvalidArgument, "the translation must be a vector of 3 numbers");
    }
    cv::Mat matrix = r;
    if (numbers_in(r) == 3) {
        cv::Rodrigues(r, matrix);
    }
    cv::Mat_<double> numbers;
    RigidMotion motion;
    matrix.convertTo(numbers, CV_64F);
    std::copy(numbers.begin(), numbers.end(), motion.rotation.begin());
    t.reshape(1, 3).convertTo(numbers, CV_64F);
    std::copy(numbers.begin(), numbers.end(), motion.translation.begin());
    return motion;
}

/**
 * Completes the depth image into a matrix of the size of the camera, which is made if it has another size or type:
 * CV_16UC1 or CV_32FC1, z = value * `unit`, 0 = none. Model and mask may be left out, as for Fitter::complete_depth().
 */
inline Completion complete_depth(const Fitter &fitter, cv::Mat &depth, int type, cv::Size size, double unit,
                                 Optional<Cylinder> model = {}, Optional<MaskView> mask = {})
{
    depth.create(size, type);
    detail::check_image(depth, "the completed depth image", {CV_16UC1, CV_32FC1}, "CV_16UC1 or CV_32FC1");
    const auto columns = static_cast<std::uint32_t>(depth.cols);
    const auto rows = static_cast<std::uint32_t>(depth.rows);
    const DepthOut out =
        type == CV_16UC1 ? DepthOut(depth.ptr<std::uint16_t>(), columns, rows, unit, detail::row_stride(depth))
                         : DepthOut(depth.ptr<float>(), columns, rows, unit, detail::row_stride(depth));
    return fitter.complete_depth(out, model, mask);
}

/**
 * The labels of what a detector found, CV_16UC1: 0 for none, else the index of the cylinder + 1. `size` is that of the
 * image of the frame, or of the organised cloud.
 */
inline cv::Mat labels(const Detector &detector, cv::Size size)
{
    const std::vector<std::uint16_t> all = detector.labels();
    if (size.width < 0 || size.height < 0 || std::size_t(size.width) * std::size_t(size.height) != all.size()) {
        throw Error(Status::SizeMismatch,
                    ("the size is " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                     " but there are " + std::to_string(all.size()) + " labels; give the size of the scene")
                        .c_str());
    }
    return cv::Mat(size, CV_16UC1, const_cast<std::uint16_t *>(all.data())).clone();
}

/**
 * Proposes edges where nobody gives them: OpenCV's line detector over a grey or colour image of 8 bits, and of what it
 * finds the pieces on the two limbs of the last fit. That is best one to the points alone, such as by
 * Method::Ransac: others look at the mask, which may be bad. `reach` as for Fitter::select_edges(). With neither
 * limb in sight there is nothing in the vector. Another size of the image than that of the selected camera is
 * Status::SizeMismatch.
 */
inline std::vector<cv::Vec4f> propose_edges(const Fitter &fitter, const cv::Mat &image, double reach = 0.0)
{
    detail::check_image(image, "the image", {CV_8UC1, CV_8UC3, CV_8UC4}, "CV_8UC1, CV_8UC3 or CV_8UC4");
    detail::check_size(image, "the image", fitter.intrinsics());
    // At its usual scale of 0.8 the detector gives coordinates that are 1/8 pixel too small.
    const cv::Ptr<cv::LineSegmentDetector> detector = cv::createLineSegmentDetector(cv::LSD_REFINE_STD, 1.0);
    std::vector<cv::Vec4f> found, proposed;
    cv::Mat grey = image;
    if (image.channels() != 1) {
        cv::cvtColor(image, grey, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
    }
    detector->detect(grey, found);
    std::vector<std::uint8_t> limbs(found.size());
    fitter.select_edges(segments_view(found), limbs, reach);
    for (std::size_t k = 0; k < found.size(); ++k) {
        if (limbs[k] != 0) {
            proposed.push_back(found[k]);
        }
    }
    return proposed;
}

/** @cond internal */
namespace detail {

inline std::array<double, 3> coordinates(const cv::Vec3d &point)
{
    return {{point[0], point[1], point[2]}};
}

// Draws a curve in space as the (distorted) image shows it; pieces that the camera does not see are left out.
inline void draw_curve(cv::Mat &image, const std::vector<std::array<double, 3>> &curve,
                       const cylfuse_intrinsics &camera, const cv::Scalar &colour)
{
    const std::vector<std::array<double, 2>> pixels = project(camera, curve);
    // Of a green line that counts as grey would be left as much as of the first channel: nothing.
    const cv::Scalar drawn =
        image.channels() == 1 ? cv::Scalar(std::max({colour[0], colour[1], colour[2]})) : colour;
    constexpr int SHIFT = 4; // cv::line takes sixteenths of a pixel.
    const auto fixed = [](const std::array<double, 2> &p) { return cv::Point(cvRound(p[0] * 16), cvRound(p[1] * 16)); };
    // Far outside its coordinates would not fit an int; not a number is nowhere.
    const auto drawable = [](const std::array<double, 2> &p) {
        return std::abs(p[0]) < 1e5 && std::abs(p[1]) < 1e5;
    };
    for (std::size_t i = 1; i < pixels.size(); ++i) {
        if (drawable(pixels[i - 1]) && drawable(pixels[i])) {
            cv::line(image, fixed(pixels[i - 1]), fixed(pixels[i]), drawn, 1, cv::LINE_AA, SHIFT);
        }
    }
}

} // namespace detail
/** @endcond */

/** The colours of draw(), in the order of the channels of the image. A grey image gets the largest channel of each. */
struct Colours {
    cv::Scalar limbs = cv::Scalar(0, 220, 0); ///< The two limbs.
    cv::Scalar ends = cv::Scalar(0, 160, 255); ///< The visible half of the circle at either end.
    cv::Scalar axis = cv::Scalar(255, 120, 0); ///< The axis.
};

/**
 * Draws the visible piece of a cylinder over an image of the camera, in colour, CV_8UC3, or grey, CV_8UC1: its limbs, its
 * ends and its axis, with the distortion of the lens. From inside a pipe there are no limbs. `pose` is that of the view whose image it is.
 */
inline void draw(cv::Mat &image, const Cylinder &model, const cylfuse_extent &extent,
                 const cylfuse_intrinsics &intrinsics, const Colours &colours = Colours(),
                 const RigidMotion &pose = RigidMotion())
{
    detail::check_image(image, "the image to draw on", {CV_8UC1, CV_8UC3}, "CV_8UC1 or CV_8UC3");
    detail::check_size(image, "the image to draw on", intrinsics);
    constexpr int PIECES = 64; // Short enough to look like a curve.
    const cv::Matx33d to_camera = cv::Matx33d(pose.rotation.data()).t();
    const cv::Vec3d position(pose.translation.data());
    const cv::Vec3d start = to_camera * (cv::Vec3d(extent.start) - position);
    const cv::Vec3d end = to_camera * (cv::Vec3d(extent.end) - position);
    const cv::Vec3d direction = to_camera * cv::normalize(cv::Vec3d(model.direction));
    const cv::Vec3d point = to_camera * (cv::Vec3d(model.point) - position);
    const cv::Vec3d center = point - direction * point.dot(direction); // The point of the axis nearest the camera.
    const double distance = cv::norm(center);
    const double radius = model.radius;
    const auto along = [&](const cv::Vec3d &offset) {
        std::vector<std::array<double, 3>> curve;
        for (int i = 0; i <= PIECES; ++i) {
            curve.push_back(detail::coordinates(start + (end - start) * (double(i) / PIECES) + offset));
        }
        return curve;
    };
    if (radius < distance) {
        const cv::Vec3d toward = center / distance;
        const cv::Vec3d sideways = direction.cross(toward);
        const double sine = radius / distance;
        const double cosine = std::sqrt((1 - sine) * (1 + sine));
        for (const double side : {-1.0, 1.0}) {
            // There the line of sight touches the surface.
            const cv::Vec3d normal = toward * -sine + sideways * (side * cosine);
            detail::draw_curve(image, along(normal * radius), intrinsics, colours.limbs);
        }
    }
    // Any two directions across the axis.
    const cv::Vec3d least = std::abs(direction[0]) < 0.6 ? cv::Vec3d(1, 0, 0) : cv::Vec3d(0, 1, 0);
    const cv::Vec3d u = cv::normalize(direction.cross(least));
    const cv::Vec3d v = direction.cross(u);
    for (const cv::Vec3d &middle : {start, end}) {
        std::vector<std::array<double, 3>> arc;
        for (int i = 0; i <= 2 * PIECES; ++i) {
            const double angle = CV_PI * i / PIECES;
            const cv::Vec3d normal = u * std::cos(angle) + v * std::sin(angle);
            const cv::Vec3d rim = middle + normal * radius;
            if (radius < distance && normal.dot(rim) >= 0) {
                detail::draw_curve(image, arc, intrinsics, colours.ends);
                arc.clear();
            } else {
                arc.push_back(detail::coordinates(rim));
            }
        }
        detail::draw_curve(image, arc, intrinsics, colours.ends);
    }
    detail::draw_curve(image, along(cv::Vec3d(0, 0, 0)), intrinsics, colours.axis);
}

} // inline namespace
} // namespace cylfuse

#endif

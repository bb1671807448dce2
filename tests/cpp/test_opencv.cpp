// OpenCV in and out.
#include "pair.hpp"

#include <cylfuse/opencv.hpp>

static const cv::Matx33d MATRIX(200, 0, 79.5, 0, 200, 59.5, 0, 0, 1);

// The scene as matrices that are parts of larger ones.
struct Images {
    Scene scene;
    cv::Mat depth, mask, image;

    Images()
    {
        cv::Mat large_depth(130, 170, CV_32FC1, cv::Scalar(-1)), large_mask(130, 170, CV_8UC1, cv::Scalar(255));
        depth = large_depth(part());
        mask = large_mask(part());
        cv::Mat(120, 160, CV_32FC1, scene.depth.data()).copyTo(depth);
        cv::Mat(120, 160, CV_8UC1, scene.mask.data()).copyTo(mask);
        // A bright pipe before a dark wall, painted four times as large and averaged.
        cv::Mat four(480, 640, CV_8UC1, cv::Scalar(60));
        for (int column = 0; column < 640; ++column) {
            const double u = (column + 0.5) / 4 - 0.5;
            if (u > scene.edges[0][0] && u < scene.edges[1][0]) {
                four(cv::Rect(column, 140, 1, 200)).setTo(180);
            }
        }
        cv::resize(four, image, cv::Size(160, 120), 0, 0, cv::INTER_AREA);
    }
    static cv::Rect part() { return {3, 5, 160, 120}; }
};

static void all_types_pass()
{
    Images images;
    cv::Mat millimetres;
    images.depth.convertTo(millimetres, CV_16U, 1e4);
    for (const auto &depth : {cylfuse::depth_view(images.depth, 1.0), cylfuse::depth_view(millimetres, 1e-4)}) {
        cylfuse::Fitter fitter;
        fitter.set_intrinsics(cylfuse::intrinsics(MATRIX, cv::noArray(), {160, 120}));
        fitter.push_depth(depth, cylfuse::mask_view(images.mask));
        CHECK_NEAR(fitter.fit().cylinder.model.radius, PIPE.radius, 1e-4);
        cv::Mat completed;
        cylfuse::complete_depth(fitter, completed, CV_32FC1, {160, 120}, 1.0, PIPE);
        CHECK_NEAR(completed.at<float>(60, 80), images.depth.at<float>(60, 80), 1e-6);
        cylfuse::complete_depth(fitter, completed, CV_16UC1, {160, 120}, 1e-4, PIPE);
        CHECK_NEAR(completed.at<std::uint16_t>(60, 80), 1e4 * images.depth.at<float>(60, 80), 1.0);
        CHECK(completed.at<std::uint16_t>(0, 0) == 0);
    }
    // An organised cloud, a part of a larger one.
    const auto points = pipe_points(30, 10, -1.0, 1.0);
    cv::Mat large(35, 12, CV_64FC3, cv::Scalar::all(NAN));
    cv::Mat cloud = large(cv::Rect(1, 2, 10, 30));
    cv::Mat(30, 10, CV_64FC3, const_cast<double *>(points[0].data())).copyTo(cloud);
    cylfuse::Fitter fitter;
    fitter.push_points(cylfuse::points_view(cloud));
    CHECK(fitter.counts().points_used == 300);
    CHECK_NEAR(fitter.fit().cylinder.model.radius, PIPE.radius, 1e-9);
}

static void segments_and_cameras()
{
    const std::vector<cv::Vec4f> segments = {{1, 2, 3, 4}, {5, 6, 7, 8}};
    const cylfuse::SegmentsView of_vector = cylfuse::segments_view(segments);
    const cv::Mat column(segments);
    const cylfuse::SegmentsView of_column = cylfuse::segments_view(column);
    CHECK(of_vector.count == 2 && of_column.count == 2 && of_column.segment_stride == 16);
    CHECK(cylfuse::segments_view(cv::Mat()).count == 0);
    CHECK_ERROR(cylfuse::segments_view(cv::Mat(2, 1, CV_32SC4)), INVALID_ARGUMENT, "CV_32SC4");

    const cylfuse::Intrinsics five =
        cylfuse::intrinsics(cv::Mat(cv::Matx33f(MATRIX)), std::vector<float>{0.5F, 0, 0, 0, 0.25F}, {160, 120});
    CHECK(five.distortion_model() == cylfuse::Distortion::BrownConrady && five.fx == 200.0);
    CHECK(five.distortion[0] == 0.5 && five.distortion[4] == 0.25);
    cylfuse::intrinsics(MATRIX, std::vector<double>(14, 0.0), {160, 120});
    const auto fisheye = cylfuse::fisheye_intrinsics(MATRIX, cv::Vec4d(0.1, 0.2, 0.3, 0.4), {160, 120});
    // The pixels are those of OpenCV.
    const std::vector<std::array<double, 3>> point = {{{0.2, -0.1, 1.0}}};
    const std::vector<cv::Point3d> of_opencv = {{0.2, -0.1, 1.0}};
    const std::vector<double> brown = {0.1, -0.2, 0.001, 0.002, 0.05, 0.01, 0.02, -0.01};
    const cv::Vec3d zero(0, 0, 0);
    std::vector<cv::Point2d> there;
    cv::projectPoints(of_opencv, zero, zero, MATRIX, brown, there);
    const auto here = cylfuse::project(cylfuse::intrinsics(MATRIX, brown, {160, 120}), point)[0];
    CHECK_NEAR(here[0], there[0].x, 1e-9);
    CHECK_NEAR(here[1], there[0].y, 1e-9);
    cv::fisheye::projectPoints(of_opencv, there, zero, zero, MATRIX, cv::Vec4d(0.1, 0.2, 0.3, 0.4));
    const auto bent = cylfuse::project(fisheye, point)[0];
    CHECK_NEAR(bent[0], there[0].x, 1e-9);
    CHECK_NEAR(bent[1], there[0].y, 1e-9);
    CHECK(fisheye.distortion_model() == cylfuse::Distortion::KannalaBrandt && fisheye.distortion[3] == 0.4);
    CHECK_ERROR(cylfuse::intrinsics(MATRIX, std::vector<double>(6, 0.0), {160, 120}), INVALID_INTRINSICS, "6");
    CHECK_ERROR(cylfuse::intrinsics(MATRIX, std::vector<double>(12, 0.1), {160, 120}), UNSUPPORTED, "thin prism");
    CHECK_ERROR(cylfuse::intrinsics(MATRIX, cv::noArray(), {160, 0}), INVALID_INTRINSICS, "160 x 0");
    CHECK_ERROR(cylfuse::intrinsics(cv::Mat::eye(3, 4, CV_64F), cv::noArray(), {160, 120}), INVALID_INTRINSICS, "4 x 3");
    cv::Matx33d skew = MATRIX;
    skew(0, 1) = 0.1;
    CHECK_ERROR(cylfuse::intrinsics(skew, cv::noArray(), {160, 120}), INVALID_INTRINSICS, "no skew");
}

static void edges_are_proposed_and_drawn()
{
    Images images;
    cylfuse::Fitter fitter;
    fitter.set_intrinsics(images.scene.camera);
    fitter.push_depth(cylfuse::depth_view(images.depth, 1.0), cylfuse::mask_view(images.mask));
    fitter.fit();
    cv::Mat colour;
    cv::cvtColor(images.image, colour, cv::COLOR_GRAY2BGR);
    for (const cv::Mat &image : {images.image, colour}) {
        const std::vector<cv::Vec4f> edges = cylfuse::propose_edges(fitter, image);
        CHECK(edges.size() == 2);
        for (const cv::Vec4f &edge : edges) {
            const double limb = edge[0] < 79.5F ? images.scene.edges[0][0] : images.scene.edges[1][0];
            CHECK_NEAR(edge[0], limb, 0.3);
            CHECK_NEAR(edge[2], limb, 0.3);
        }
    }
    // In the image the limbs are located near given edges that are a pixel off.
    cv::Mat with_alpha;
    cv::cvtColor(colour, with_alpha, cv::COLOR_BGR2BGRA);
    for (const cv::Mat &image : {images.image, colour, with_alpha}) {
        std::vector<std::array<double, 4>> off = images.scene.edges;
        off[0][0] -= 1.0, off[0][2] -= 1.0;
        fitter.push_image(cylfuse::image_view(image));
        fitter.push_edges(off);
        const cylfuse::CylinderFit fit = fitter.fit();
        CHECK(fit.result.limbs_located == 2 && fitter.limb_samples().size() > 4);
        CHECK_NEAR(fit.cylinder.model.radius, PIPE.radius, 0.0005);
    }
    cv::Mat drawn = colour.clone();
    cylfuse::draw(drawn, PIPE, fitter.extent(), images.scene.camera);
    const int limb = int(std::lround(images.scene.edges[0][0]));
    const cv::Vec3b pixel = drawn.at<cv::Vec3b>(50, limb);
    CHECK(pixel[1] > 150 && pixel[0] < 100 && pixel[2] < 100);
    CHECK(cv::norm(drawn, colour) > 0.0 && drawn.at<cv::Vec3b>(5, 5) == colour.at<cv::Vec3b>(5, 5));
    // On a grey image, dark where the limb is: the largest channel of its colour, 220.
    cv::Mat grey(120, 160, CV_8UC1, cv::Scalar(60));
    cylfuse::draw(grey, PIPE, fitter.extent(), images.scene.camera);
    CHECK(grey.type() == CV_8UC1 && grey.at<std::uint8_t>(5, 5) == 60);
    CHECK(grey.at<std::uint8_t>(50, limb) > 130 && grey.at<std::uint8_t>(50, limb) <= 220);
    CHECK(grey.at<std::uint8_t>(60, 79) + grey.at<std::uint8_t>(60, 80) > 250); // The axis, between two pixels.
    cylfuse::Colours black;
    black.limbs = black.ends = black.axis = cv::Scalar(0, 0, 0);
    grey.setTo(200);
    cylfuse::draw(grey, PIPE, fitter.extent(), images.scene.camera, black);
    CHECK(cv::countNonZero(grey > 200) == 0 && grey.at<std::uint8_t>(50, limb) < 100);
    cv::Mat sixteen(120, 160, CV_16UC1);
    CHECK_ERROR(cylfuse::draw(sixteen, PIPE, fitter.extent(), images.scene.camera), INVALID_ARGUMENT, "CV_8UC1 or CV_8UC3");
}

// Colours weigh as in the library, whatever the order of the bytes; a label is one of several masks.
static void colours_and_labels_pass()
{
    const cv::Mat colours(120, 160, CV_8UC3, cv::Scalar(10, 20, 30));
    const cylfuse::ImageView view = cylfuse::image_view(colours);
    CHECK(view.format == CYLFUSE_IMAGE_FORMAT_BGR8 && view.data == colours.data && view.gamma == 1.0);
    Images images;
    cv::Mat labels(120, 160, CV_8UC1, cv::Scalar(3));
    labels.setTo(7, images.mask);
    cylfuse::Fitter fitter;
    fitter.set_intrinsics(images.scene.camera);
    fitter.push_depth(cylfuse::depth_view(images.depth, 1.0), cylfuse::mask_view(labels, 7));
    CHECK(fitter.counts().points_used == std::uint64_t(cv::countNonZero(images.mask)));
}

static void motions_are_read_and_draw()
{
    const cv::Vec3d angle(0.0, CV_PI, 0.0), translation(0.0, 0.0, 1.6);
    cv::Matx33d matrix;
    cv::Rodrigues(angle, matrix);
    const cylfuse::RigidMotion by_vector = cylfuse::rigid_motion(angle, translation);
    const cylfuse::RigidMotion by_matrix = cylfuse::rigid_motion(cv::Mat(cv::Matx33f(matrix)), cv::Mat(translation));
    for (std::size_t k = 0; k < 9; ++k) {
        CHECK_NEAR(by_vector.rotation[k], by_matrix.rotation[k], 1e-6);
        CHECK_NEAR(by_vector.rotation[k], matrix.val[k], 1e-12);
    }
    CHECK(by_matrix.translation[2] == 1.6);
    // From behind the pipe looks the same.
    Images images;
    cylfuse::Extent extent;
    extent.start[1] = -0.1, extent.end[1] = 0.1;
    extent.start[2] = extent.end[2] = 0.8;
    cv::Mat front(120, 160, CV_8UC3, cv::Scalar::all(0)), back = front.clone();
    cylfuse::draw(front, PIPE, extent, images.scene.camera);
    cylfuse::draw(back, PIPE, extent, images.scene.camera, cylfuse::Colours(), by_vector);
    CHECK(cv::norm(front, cv::NORM_L1) > 0.0 && cv::norm(front, back, cv::NORM_INF) < 60.0);
}

static void bad_images_are_named()
{
    Images images;
    CHECK_ERROR(cylfuse::depth_view(cv::Mat(), 1.0), INVALID_ARGUMENT, "the depth image is empty");
    CHECK_ERROR(cylfuse::depth_view(images.image, 1.0), INVALID_ARGUMENT, "CV_8UC1; it must be of type CV_16UC1");
    CHECK_ERROR(cylfuse::mask_view(images.depth), INVALID_ARGUMENT, "the mask is of type CV_32FC1");
    CHECK_ERROR(cylfuse::points_view(images.depth), INVALID_ARGUMENT, "CV_32FC3 or CV_64FC3");
    CHECK_ERROR(cylfuse::rigid_motion(cv::Mat::eye(4, 4, CV_64F), cv::Vec3d()), INVALID_ARGUMENT, "3 x 3");
    CHECK_ERROR(cylfuse::rigid_motion(cv::Vec3d(), cv::Vec4d()), INVALID_ARGUMENT, "translation");
    const int sizes[] = {4, 5, 6};
    CHECK_ERROR(cylfuse::mask_view(cv::Mat(3, sizes, CV_8UC1)), INVALID_ARGUMENT, "3 dimensions");
    cylfuse::Fitter fitter;
    fitter.set_intrinsics(images.scene.camera);
    CHECK_ERROR(fitter.push_depth(cylfuse::depth_view(images.depth.rowRange(0, 100), 1.0)), SIZE_MISMATCH, "160 x 100");
    CHECK_ERROR(fitter.push_depth(cylfuse::depth_view(images.depth, 0.0)), INVALID_ARGUMENT, "scale");
    cv::Mat large(200, 200, CV_8UC3);
    CHECK_ERROR(cylfuse::draw(large, PIPE, cylfuse::Extent(), images.scene.camera), SIZE_MISMATCH, "200 x 200");
    CHECK_ERROR(cylfuse::propose_edges(fitter, large), SIZE_MISMATCH, "the image is 200 x 200");
    CHECK_ERROR(cylfuse::propose_edges(fitter, images.image), BAD_STATE, "fit first");
    CHECK_ERROR(fitter.push_image(cylfuse::image_view(images.image.rowRange(0, 7))), SIZE_MISMATCH, "160 x 7");
    CHECK_ERROR(cylfuse::image_view(cv::Mat(120, 160, CV_16UC3)), INVALID_ARGUMENT, "CV_16UC3");
    CHECK_ERROR(fitter.push_image(cylfuse::image_view(images.image, 22.0)), INVALID_ARGUMENT, "gamma of the image is 22");
    images.depth.at<float>(0, 0) = NAN;
    CHECK_ERROR(fitter.push_image(cylfuse::image_view(images.depth)), INVALID_ARGUMENT, "NaN");
}

static void labels_are_a_matrix()
{
    const Pair pair;
    cylfuse::Detector detector;
    CHECK_ERROR(cylfuse::labels(detector, {160, 120}), BAD_STATE, "first");
    detector.detect(pair.frame());
    const cv::Mat labels = cylfuse::labels(detector, {160, 120});
    CHECK(labels.type() == CV_16UC1 && labels.cols == 160 && labels.rows == 120);
    for (std::size_t index = 0; index < 2; ++index) {
        CHECK(cv::countNonZero(labels == double(index + 1)) == int(detector.detections()[index].pixels));
        for (const std::uint32_t k : detector.indices(index)) {
            CHECK(labels.at<std::uint16_t>(int(k / 160), int(k % 160)) == index + 1);
        }
    }
    CHECK_ERROR(cylfuse::labels(detector, {160, 119}), SIZE_MISMATCH, "160 x 119 but there are 19200 labels");
    CHECK_ERROR(cylfuse::labels(detector, {-160, -120}), SIZE_MISMATCH, "-160");
}

int main()
{
    labels_are_a_matrix();
    all_types_pass();
    segments_and_cameras();
    edges_are_proposed_and_drawn();
    colours_and_labels_pass();
    motions_are_read_and_draw();
    bad_images_are_named();
    return finish("OpenCV");
}

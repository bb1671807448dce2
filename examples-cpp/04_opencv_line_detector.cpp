// Depth, image and OpenCV's line detector: 04_opencv_line_detector FOLDER OVERLAY.png
//
// A first fit to the points alone tells where the limbs are to be expected; the line detector finds them.
#include <cylfuse/opencv.hpp>

#include <opencv2/imgcodecs.hpp>

#include <cstdio>
#include <fstream>

int main(int argc, char **argv)
try {
    if (argc != 3) {
        std::fprintf(stderr, "usage: %s FOLDER with camera.txt, depth.pgm, mask.pgm and image.pgm, OVERLAY.png\n", argv[0]);
        return 2;
    }
    const std::string folder(argv[1]);
    const cv::Mat depth = cv::imread(folder + "/depth.pgm", cv::IMREAD_UNCHANGED);
    const cv::Mat mask = cv::imread(folder + "/mask.pgm", cv::IMREAD_GRAYSCALE);
    const cv::Mat image = cv::imread(folder + "/image.pgm", cv::IMREAD_COLOR); // BGR goes in as it is.
    int width = 0, height = 0;
    double unit = 0.0;
    cv::Matx33d camera_matrix = cv::Matx33d::eye();
    std::ifstream camera(folder + "/camera.txt");
    camera >> width >> height >> camera_matrix(0, 0) >> camera_matrix(1, 1) >> camera_matrix(0, 2) >>
        camera_matrix(1, 2) >> unit;
    const cylfuse::Intrinsics intrinsics = cylfuse::intrinsics(camera_matrix, cv::noArray(), {width, height});

    cylfuse::Fitter fitter;
    fitter.set_intrinsics(intrinsics);
    fitter.push_depth(cylfuse::depth_view(depth, unit), cylfuse::mask_view(mask));
    // Random samples look at nothing but the points.
    fitter.set_options(cylfuse::Options().method(cylfuse::Method::Ransac));
    std::printf("points alone: radius %.2f mm\n", 1e3 * fitter.fit().cylinder.model.radius);

    const std::vector<cv::Vec4f> edges = cylfuse::propose_edges(fitter, image);
    fitter.push_edges(cylfuse::segments_view(edges));
    // In it limbs and ends are located more precisely than the detector does.
    fitter.push_image(cylfuse::image_view(image));
    fitter.set_options(cylfuse::Options());
    const cylfuse::CylinderFit fit = fitter.fit();
    const cylfuse::Extent extent = fitter.extent();
    std::printf("with %zu edges: radius %.2f +- %.2f mm, length %.2f mm, %u limbs located\n", edges.size(),
                1e3 * fit.cylinder.model.radius, 1e3 * fit.cylinder.radius_deviation, 1e3 * extent.length,
                fit.result.limbs_located);

    cv::Mat overlay = image.clone();
    cylfuse::draw(overlay, fit.cylinder.model, extent, intrinsics);
    if (!cv::imwrite(argv[2], overlay)) {
        std::fprintf(stderr, "%s cannot be written\n", argv[2]);
        return 1;
    }
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

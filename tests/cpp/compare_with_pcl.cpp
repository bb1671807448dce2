// Both classes on the same clouds, as a table: compare_with_pcl FOLDER...
//
// Each folder is a frame with depth.png, mask.png, frame.json and, for the errors, truth.json. Points only: the depth
// inside the mask. Both with the settings of pcl_pipeline.hpp. A third row has the edges that OpenCV's line detector
// proposes in image.png, without locating the limbs any further.
#include "pcl_pipeline.hpp"

#include <cylfuse/opencv.hpp>
#include <cylfuse/pcl.hpp>

#include <opencv2/imgcodecs.hpp>
#include <pcl/features/normal_3d.h>
#include <pcl/search/kdtree.h>

#include <chrono>
#include <cstdio>
#include <fstream>

using namespace pcl_pipeline;

struct Frame {
    cv::Mat depth, mask, image;
    cv::Matx33d matrix;
    std::vector<double> distortion;
    double unit;

    explicit Frame(const std::string &folder)
        : depth(cv::imread(folder + "/depth.png", cv::IMREAD_UNCHANGED)),
          mask(cv::imread(folder + "/mask.png", cv::IMREAD_GRAYSCALE)),
          image(cv::imread(folder + "/image.png", cv::IMREAD_GRAYSCALE))
    {
        const cv::FileStorage frame(folder + "/frame.json", cv::FileStorage::READ);
        const cv::FileNode camera = frame["camera"];
        matrix = {camera["fx"].real(), 0, camera["cx"].real(), 0, camera["fy"].real(), camera["cy"].real(), 0, 0, 1};
        camera["distortion"] >> distortion;
        unit = frame["depth_scale"].real();
    }

    // The depth inside the mask.
    Cloud::Ptr cloud() const
    {
        std::vector<cv::Point2d> pixels, ideal;
        std::vector<double> z;
        for (int row = 0; row < depth.rows; ++row) {
            for (int column = 0; column < depth.cols; ++column) {
                if (mask.at<std::uint8_t>(row, column) != 0 && depth.at<std::uint16_t>(row, column) != 0) {
                    pixels.emplace_back(column, row);
                    z.push_back(unit * depth.at<std::uint16_t>(row, column));
                }
            }
        }
        // Enough iterations for strong distortion.
        cv::undistortPoints(pixels, ideal, matrix, distortion, cv::noArray(), cv::noArray(),
                            cv::TermCriteria(cv::TermCriteria::COUNT, 100, 0));
        const Cloud::Ptr cloud(new Cloud);
        for (std::size_t k = 0; k < z.size(); ++k) {
            cloud->push_back({float(ideal[k].x * z[k]), float(ideal[k].y * z[k]), float(z[k])});
        }
        return cloud;
    }

    cylfuse::Cylinder with_detected_edges() const
    {
        cylfuse::Fitter fitter;
        fitter.set_intrinsics(cylfuse::intrinsics(matrix, distortion, depth.size()));
        fitter.push_depth(cylfuse::depth_view(depth, unit), cylfuse::mask_view(mask));
        fitter.set_options(cylfuse::Options().method(cylfuse::Method::Ransac));
        fitter.fit();
        fitter.set_options(cylfuse::Options());
        const std::vector<cv::Vec4f> edges = cylfuse::propose_edges(fitter, image);
        fitter.push_edges(cylfuse::segments_view(edges));
        return fitter.fit().cylinder.model;
    }
};

struct Outcome {
    cylfuse::Cylinder model;
    double seconds;
};

static Outcome timed(Segmentation &segmentation, const Cloud::Ptr &cloud, bool with_normals)
{
    const auto start = std::chrono::steady_clock::now();
    const Segment found = segment(segmentation, cloud, with_normals ? normals_of(cloud) : nullptr);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    return {cylfuse::to_cylinder(found.coefficients), time.count()};
}

static double mean(const std::vector<double> &values)
{
    double sum = 0.0;
    for (const double value : values) {
        sum += value;
    }
    return sum / double(values.size());
}

static double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

int main(int argc, char **argv)
try {
    std::vector<double> error[3], angle[2], seconds[2];
    int better = 0;
    cylfuse::CylinderSegmentation<pcl::PointXYZ> ours;
    std::printf("%-14s %6s | %-22s | %-22s | %-16s\n", "frame", "points", "radius, mm: PCL, ours", "axis, deg: PCL, ours",
                "ms: PCL, ours");
    for (int k = 1; k < argc; ++k) {
        const std::string folder(argv[k]);
        const Frame frame(folder);
        const Cloud::Ptr cloud = frame.cloud();
        Segmentation theirs;
        const Outcome outcomes[2] = {timed(theirs, cloud, true), timed(ours, cloud, false)};
        for (int of = 0; of < 2; ++of) {
            seconds[of].push_back(outcomes[of].seconds);
        }
        double relative[2] = {NAN, NAN}, degrees[2] = {NAN, NAN};
        // OpenCV prints an error when it opens what is not there.
        if (std::ifstream(folder + "/truth.json")) {
            const cv::FileStorage truth(folder + "/truth.json", cv::FileStorage::READ);
            std::vector<double> center, axis;
            truth["center"] >> center;
            truth["axis"] >> axis;
            const cylfuse::Cylinder model = {{center[0], center[1], center[2]}, {axis[0], axis[1], axis[2]},
                                             truth["radius"].real()};
            for (int of = 0; of < 2; ++of) {
                const cylfuse::Difference difference = cylfuse::compare(model, outcomes[of].model);
                relative[of] = 100.0 * std::abs(difference.radius_relative);
                degrees[of] = difference.angle * 180.0 / CV_PI;
                error[of].push_back(relative[of]);
                angle[of].push_back(degrees[of]);
            }
            const cylfuse::Difference edges = cylfuse::compare(model, frame.with_detected_edges());
            error[2].push_back(100.0 * std::abs(edges.radius_relative));
        }
        better += relative[1] < relative[0];
        std::printf("%-14s %6zu | %7.2f %7.2f (%4.1f %%, %4.1f %%) | %6.2f %6.2f | %8.1f %6.2f\n",
                    folder.substr(folder.find_last_of('/') + 1).c_str(), cloud->size(), 1e3 * outcomes[0].model.radius,
                    1e3 * outcomes[1].model.radius, relative[0], relative[1], degrees[0], degrees[1],
                    1e3 * outcomes[0].seconds, 1e3 * outcomes[1].seconds);
    }
    if (!error[0].empty()) {
        std::printf("radius error, mean:   PCL %.2f %%, ours %.2f %%, ratio %.2f\n", mean(error[0]), mean(error[1]),
                    mean(error[1]) / mean(error[0]));
        std::printf("radius error, median: PCL %.2f %%, ours %.2f %%, ratio %.2f\n", median(error[0]), median(error[1]),
                    median(error[1]) / median(error[0]));
        std::printf("radius error lower in %.0f %% of %zu frames\n", 100.0 * better / double(error[0].size()),
                    error[0].size());
        std::printf("radius error, with detected edges: mean %.2f %%, median %.2f %%\n", mean(error[2]), median(error[2]));
        std::printf("axis error, mean:     PCL %.2f deg, ours %.2f deg\n", mean(angle[0]), mean(angle[1]));
    }
    if (!seconds[0].empty()) {
        std::printf("time, mean:           PCL %.1f ms, ours %.2f ms, %.0f times faster\n", 1e3 * mean(seconds[0]),
                    1e3 * mean(seconds[1]), mean(seconds[0]) / mean(seconds[1]));
    }
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}

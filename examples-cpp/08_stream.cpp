// Follows a cylinder through a stream of frames: 08_stream FOLDER...
//
// Each folder is a recorded frame; replace the loop in `main` by that of your camera. The first frame is searched by a
// detector. Later ones need neither detector nor mask: the outline of the last cylinder is the mask, and the fit goes on from
// that cylinder and what its image showed.
#include "frame.hpp"

#include <cmath>
#include <cstdio>
#include <memory>

class Tracker {
public:
    // The cylinder in a frame; false when there is none.
    bool update(const Frame &frame, cylfuse::CylinderFit &fit)
    {
        const bool known = following_;
        following_ = false; // Until this frame is fitted.
        fit = known ? follow(frame) : find(frame);
        if (fit.cylinder.model.radius <= 0.0) {
            return false;
        }
        last_ = fit.cylinder.model;
        extent_ = fitter_.extent();
        following_ = true;
        return true;
    }
    // Whether the next frame starts from the last cylinder.
    bool following() const { return following_; }

private:
    // The best cylinder of the whole frame.
    cylfuse::CylinderFit find(const Frame &recorded)
    {
        cylfuse::Frame frame;
        frame.set_intrinsics(recorded.camera);
        frame.set_depth(recorded.depth_view());
        frame.set_image(recorded.image_view());
        detector_.detect(frame);
        if (detector_.count() == 0) {
            return {};
        }
        fitter_ = detector_.make_fitter(0);
        fitter_.set_options(fitter_.options().start(cylfuse::Start::Last)); // Where that does not do, a fit is from scratch.
        return detector_.fit(0);
    }

    // The cylinder near the last one.
    cylfuse::CylinderFit follow(const Frame &frame)
    {
        const std::vector<std::uint8_t> mask = outline_of_last(frame);
        fitter_.clear(); // Data and views; memory, options and what the last fit leaves stay.
        fitter_.set_intrinsics(frame.camera);
        fitter_.push_depth(frame.depth_view(), cylfuse::MaskView(mask.data(), frame.camera.width, frame.camera.height));
        fitter_.push_image(frame.image_view());
        return fitter_.fit();
    }

    // The outline of the last cylinder, a twentieth wider for its motion, without what stands before or behind it. Pixels
    // without depth stay: depth is often missing next to a limb, and a mask whose sides are not near the limbs misleads.
    std::vector<std::uint8_t> outline_of_last(const Frame &frame) const
    {
        std::vector<std::array<double, 2>> pixels;
        for (std::uint32_t row = 0; row < frame.camera.height; ++row) {
            for (std::uint32_t column = 0; column < frame.camera.width; ++column) {
                pixels.push_back({{double(column), double(row)}});
            }
        }
        const std::vector<std::array<double, 3>> rays = cylfuse::unproject(frame.camera, pixels); // with z = 1
        const double *axis = last_.direction, *start = extent_.start;
        std::vector<std::uint8_t> mask(pixels.size());
        for (std::size_t k = 0; k < mask.size(); ++k) {
            // Ray and start of the axis, split into parts along the axis and across it.
            const double *ray = rays[k].data();
            const double ray_along = dot(ray, axis), start_along = dot(start, axis);
            const double a = dot(ray, ray) - ray_along * ray_along;
            const double b = dot(ray, start) - ray_along * start_along;
            const double c = dot(start, start) - start_along * start_along;
            const double square = last_.radius * last_.radius;
            if (a <= 0.0 || b <= 0.0 || c - b * b / a > 1.05 * 1.05 * square) {
                continue; // The ray passes beside the cylinder.
            }
            // Where the ray meets the near wall, or comes nearest to it; what the sensor measured if it did.
            const double measured = frame.depth[k] * frame.depth_unit;
            const double z = measured > 0.0 ? measured : (b - std::sqrt(std::max(0.0, b * b - a * (c - square)))) / a;
            const double along = ray_along * z - start_along;
            const double distance = std::sqrt(std::max(0.0, a * z * z - 2.0 * b * z + c));
            const bool near = measured <= 0.0 || std::abs(distance - last_.radius) < last_.radius / 3;
            mask[k] = near && along > 0.0 && along < extent_.length ? 255 : 0;
        }
        return mask;
    }

    static double dot(const double *u, const double *v)
    {
        return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    }

    cylfuse::Detector detector_;
    cylfuse::Fitter fitter_;
    cylfuse::Cylinder last_{};
    cylfuse::Extent extent_;
    bool following_ = false;
};

int main(int argc, char **argv)
{
    if (argc < 2) {
        std::fprintf(stderr, "usage: %s FOLDER... with camera.txt, depth.pgm, mask.pgm, image.pgm and edges.txt\n", argv[0]);
        return 2;
    }
    Tracker tracker;
    for (int k = 1; k < argc; ++k) {
        const char *how = tracker.following() ? "followed" : "found";
        try {
            cylfuse::CylinderFit fit;
            if (tracker.update(Frame(argv[k]), fit)) {
                std::printf("frame %d: %s, radius %.2f mm, standard deviation %.2f mm, %u iterations\n", k, how,
                            1e3 * fit.cylinder.model.radius, 1e3 * fit.cylinder.radius_deviation, fit.result.iterations);
            } else {
                std::printf("frame %d: no cylinder\n", k);
            }
        } catch (const std::exception &error) {
            // A frame that cannot be used ends neither the program nor the stream; the next one is searched anew.
            std::printf("frame %d: lost: %s\n", k, error.what());
            tracker = Tracker();
        }
    }
    return 0;
}

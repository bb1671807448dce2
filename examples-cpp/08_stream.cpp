// Follows a cylinder through a stream of frames: 08_stream FOLDER...
//
// Each folder is a recorded frame; replace the loop in `main` by that of your camera. The first frame is searched by a
// detector. Later ones need neither detector nor mask: the pixels near the last cylinder are the mask, and the fit starts
// from that cylinder.
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
        return detector_.fit(0);
    }

    // The cylinder near the last one.
    cylfuse::CylinderFit follow(const Frame &frame)
    {
        const std::vector<std::uint8_t> mask = near_last(frame);
        fitter_.clear(); // Data and views; memory and options stay.
        fitter_.set_intrinsics(frame.camera);
        fitter_.push_depth(frame.depth_view(), cylfuse::MaskView(mask.data(), frame.camera.width, frame.camera.height));
        fitter_.push_image(frame.image_view());
        fitter_.set_start_model(last_); // One start among others: where it explains the data badly, another one is taken.
        return fitter_.fit();
    }

    // The pixels whose points lie within a third of the radius of the last cylinder's surface, and between its ends.
    std::vector<std::uint8_t> near_last(const Frame &frame) const
    {
        std::vector<std::array<double, 2>> pixels;
        for (std::uint32_t row = 0; row < frame.camera.height; ++row) {
            for (std::uint32_t column = 0; column < frame.camera.width; ++column) {
                pixels.push_back({{double(column), double(row)}});
            }
        }
        const std::vector<std::array<double, 3>> rays = cylfuse::unproject(frame.camera, pixels); // with z = 1
        std::vector<std::uint8_t> mask(pixels.size());
        for (std::size_t k = 0; k < mask.size(); ++k) {
            const double z = frame.depth[k] * frame.depth_unit;
            double along = 0.0, square = 0.0;
            for (int axis = 0; axis < 3; ++axis) {
                const double d = rays[k][axis] * z - extent_.start[axis];
                along += d * last_.direction[axis];
                square += d * d;
            }
            const double distance = std::sqrt(std::max(0.0, square - along * along));
            const bool near = std::abs(distance - last_.radius) < last_.radius / 3;
            mask[k] = z > 0.0 && near && along > 0.0 && along < extent_.length ? 255 : 0;
        }
        return mask;
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

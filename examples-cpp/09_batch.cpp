// Inspects a batch of frames and prints a table as CSV: 09_batch LOWEST HIGHEST FOLDER...
//
// LOWEST and HIGHEST are the limits of the radius in millimetres. A verdict needs the uncertainty: a part is CONFORMING or
// NOT_CONFORMING where the radius with two standard deviations on either side lies within or outside the limits (ISO 14253-1),
// and UNDECIDED otherwise, as it is with a warning that puts the deviation in doubt. A page with pictures for the browser is made
// by `cylfuse fit --report page.html FOLDER...`.
#include "frame.hpp"

#include <cstdio>
#include <cstdlib>
#include <map>

int main(int argc, char **argv)
{
    if (argc < 4) {
        std::fprintf(stderr, "usage: %s LOWEST HIGHEST FOLDER...\n", argv[0]);
        return 2;
    }
    const cylfuse::Tolerance tolerance(1e-3 * std::atof(argv[1]), 1e-3 * std::atof(argv[2])); // Metres, as the frames.
    std::map<std::string, int> counts;
    cylfuse::Fitter fitter;
    std::puts("frame,radius_mm,deviation_mm,length_mm,start,end,verdict,warnings");
    for (int k = 3; k < argc; ++k) {
        try {
            const Frame frame(argv[k]);
            fitter.clear();
            fitter.set_intrinsics(frame.camera);
            fitter.push_depth(frame.depth_view(), frame.mask_view());
            fitter.push_image(frame.image_view());
            const cylfuse::CylinderFit fit = fitter.fit();
            const cylfuse::Extent extent = fitter.extent();
            const double radius = 1e3 * fit.cylinder.model.radius, deviation = 1e3 * fit.cylinder.radius_deviation;
            const std::string verdict = to_string(cylfuse::radius_conforms(fit, tolerance));
            std::printf("%s,%.3f,%.3f,%.2f,%s,%s,%s,\"%s\"\n", argv[k], radius, deviation, 1e3 * extent.length,
                        to_string(extent.start_state()).c_str(), to_string(extent.end_state()).c_str(),
                        verdict.c_str(), fit.result.warning_names().c_str());
            ++counts[verdict];
        } catch (const std::exception &error) {
            std::printf("%s,,,,,,NOT_MEASURED,\n", argv[k]);
            std::fprintf(stderr, "%s: %s\n", argv[k], error.what());
            ++counts["NOT_MEASURED"];
        }
    }
    std::fflush(stdout);
    for (const std::pair<const std::string, int> &count : counts) {
        std::fprintf(stderr, "%d %s\n", count.second, count.first.c_str());
    }
    return 0;
}

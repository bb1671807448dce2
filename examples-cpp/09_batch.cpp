// Inspects a batch of frames and prints a table as CSV: 09_batch LOWEST HIGHEST FOLDER...
//
// LOWEST and HIGHEST are the limits of the radius in millimetres. A verdict needs the uncertainty: a part passes or fails
// where the radius with two standard deviations on either side lies within or outside the limits (ISO 14253-1), and is
// undecided otherwise, as it is with a warning that puts the deviation in doubt. A page with pictures for the browser is made
// by `cylfuse fit --report page.html FOLDER...`.
#include "frame.hpp"

#include <cstdio>
#include <cstdlib>
#include <map>

static const char *verdict(cylfuse::Conformity conformity)
{
    switch (conformity) {
    case cylfuse::Conformity::Conforming: return "pass";
    case cylfuse::Conformity::NotConforming: return "fail";
    default: return "undecided";
    }
}

int main(int argc, char **argv)
{
    if (argc < 4) {
        std::fprintf(stderr, "usage: %s LOWEST HIGHEST FOLDER...\n", argv[0]);
        return 2;
    }
    const cylfuse::Tolerance tolerance(1e-3 * std::atof(argv[1]), 1e-3 * std::atof(argv[2])); // Metres, as the frames.
    std::map<std::string, int> counts{{"pass", 0}, {"fail", 0}, {"undecided", 0}, {"not measured", 0}};
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
            const char *said = verdict(cylfuse::radius_conforms(fit, tolerance));
            std::printf("%s,%.3f,%.3f,%.2f,%s,%s,%s,\"%s\"\n", argv[k], radius, deviation, 1e3 * extent.length,
                        to_string(extent.start_state()).c_str(), to_string(extent.end_state()).c_str(), said,
                        fit.result.warning_names().c_str());
            ++counts[said];
        } catch (const std::exception &error) {
            std::printf("%s,,,,,,not measured,\n", argv[k]);
            std::fprintf(stderr, "%s: %s\n", argv[k], error.what());
            ++counts["not measured"];
        }
    }
    std::fflush(stdout);
    std::fprintf(stderr, "%d pass, %d fail, %d undecided, %d not measured\n", counts["pass"], counts["fail"],
                 counts["undecided"], counts["not measured"]);
    return 0;
}

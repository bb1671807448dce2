/* Decisions about a tolerance. */
#include "check.h"

static cylfuse_conformity decided(double value, double deviation, cylfuse_result_flags flags, double lower, double upper,
                                  double coverage)
{
    cylfuse_conformity conformity = -1;
    CHECK_ERROR(NULL, cylfuse_decide_conformity(value, deviation, flags, lower, upper, coverage, &conformity), OK, "");
    return conformity;
}

/* A fit with a deviation that is neither 0 nor large: points that lie off the surface by turns. */
static void of_a_fit(void)
{
    static double points[POINTS][3];
    for (size_t k = 0; k < POINTS; k++) {
        double shift = k * 7 % 11 / 5.0 - 1.0, across[3], along = 0.0, norm = 0.0;
        for (int i = 0; i < 3; i++) {
            across[i] = the_scene.points[k][i] - the_scene.truth.point[i];
            along += across[i] * the_scene.truth.direction[i];
        }
        for (int i = 0; i < 3; i++) {
            across[i] -= along * the_scene.truth.direction[i];
            norm += across[i] * across[i];
        }
        for (int i = 0; i < 3; i++) {
            points[k][i] = the_scene.points[k][i] + 1e-3 * shift * across[i] / sqrt(norm);
        }
    }
    cylfuse_points_view view = scene_points();
    view.data = points;
    cylfuse_fitter *fitter = new_fitter();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &view, NULL));
    cylfuse_result result = fit(fitter);
    cylfuse_cylinder_estimate estimate = cylinder_of(fitter);
    double radius = estimate.model.radius, deviation = estimate.radius_deviation;
    CHECK(deviation > 0.0 && deviation < 0.1 * radius);
    CHECK(decided(radius, deviation, result.flags, radius - 2.5 * deviation, radius + 2.5 * deviation, 0.0) ==
          CYLFUSE_CONFORMITY_CONFORMING);
    CHECK(decided(radius, deviation, result.flags, radius - 1.5 * deviation, radius + 2.5 * deviation, 0.0) ==
          CYLFUSE_CONFORMITY_UNDECIDED);
    CHECK(decided(2.0 * radius, 2.0 * deviation, result.flags, 0.0, 2.0 * radius - 5.0 * deviation, 0.0) ==
          CYLFUSE_CONFORMITY_NOT_CONFORMING);

    /* A radius that the limits fix has no deviation: it was not measured, and decides nothing. */
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.radius_min = options.radius_max = radius;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    result = fit(fitter);
    estimate = cylinder_of(fitter);
    CHECK(estimate.radius_deviation == 0.0);
    CHECK(decided(radius, estimate.radius_deviation, result.flags, 0.0, 9.0 * radius, 0.0) == CYLFUSE_CONFORMITY_UNDECIDED);
    destroy(fitter);
}

void test_conformity(void)
{
    const cylfuse_conformity conforming = CYLFUSE_CONFORMITY_CONFORMING, undecided = CYLFUSE_CONFORMITY_UNDECIDED;
    CHECK(decided(20.0, 0.125, 0, 19.5, 20.25, 0.0) == conforming);
    CHECK(decided(20.0, 0.13, 0, 19.5, 20.25, 0.0) == undecided);
    CHECK(decided(20.0, 0.13, 0, 19.5, 20.25, 1.0) == conforming);
    CHECK(decided(20.5, 0.12, 0, 19.5, 20.25, 0.0) == CYLFUSE_CONFORMITY_NOT_CONFORMING);
    CHECK(decided(20.0, 0.13, 0, 19.5, INFINITY, 0.0) == conforming);
    /* What is not known, and what a warning puts in doubt. */
    CHECK(decided(20.0, NAN, 0, 19.0, 21.0, 0.0) == undecided);
    CHECK(decided(20.0, 0.01, CYLFUSE_RESULT_FLAGS_WEAK_RADIUS, 19.0, 21.0, 0.0) == conforming);
    CHECK(decided(20.0, 0.01, CYLFUSE_RESULT_FLAGS_WEAK_RADIUS | CYLFUSE_RESULT_FLAGS_POOR_FIT, 19.0, 21.0, 0.0) == undecided);

    cylfuse_conformity out = 77;
    CHECK_ERROR(NULL, cylfuse_decide_conformity(20.0, 0.1, 0, 21.0, 19.0, 0.0, &out), INVALID_ARGUMENT,
                "the tolerance is 21 to 19; it must have a lower limit below the upper one");
    CHECK_ERROR(NULL, cylfuse_decide_conformity(20.0, 0.1, 0, 19.0, 21.0, -1.0, &out), INVALID_ARGUMENT,
                "the coverage factor is -1; it must be finite and greater than 0");
    CHECK_ERROR(NULL, cylfuse_decide_conformity(INFINITY, 0.1, 0, 19.0, 21.0, 0.0, &out), INVALID_ARGUMENT,
                "the measured value is inf");
    CHECK_ERROR(NULL, cylfuse_decide_conformity(20.0, -0.1, 0, 19.0, 21.0, 0.0, &out), INVALID_ARGUMENT,
                "the deviation is -0.1");
    CHECK_ERROR(NULL, cylfuse_decide_conformity(20.0, 0.1, 1U << 31, 19.0, 21.0, 0.0, &out), INVALID_ARGUMENT,
                "flags is 2147483648");
    CHECK_ERROR(NULL, cylfuse_decide_conformity(20.0, 0.1, 0, 19.0, 21.0, 0.0, NULL), NULL_POINTER,
                "out_conformity is NULL");
    CHECK(out == 77);
    of_a_fit();
}

/* Covariances that cannot be. */
#include "defects.h"

/* A covariance that can be one, or NaN: variances of 0 or more, correlations of at most 1. */
static void check_covariance(const outcome *found, int known, const char *what)
{
    const double *covariance = found->estimate.covariance;
    int can_be = 1;
    for (int i = 0; i < 7; i++) {
        double variance = covariance[8 * i];
        can_be &= isnan(variance) || variance >= 0.0;
        for (int j = 0; j < i; j++) {
            double square = covariance[7 * i + j] * covariance[7 * i + j];
            can_be &= !(square > (1.0 + 1e-6) * variance * covariance[8 * j]);
        }
    }
    double deviation = found->estimate.radius_deviation;
    /* A deviation far below what double can tell of the radius is none, unless the radius is known. */
    can_be &= isnan(deviation) || deviation > 1e-15 * found->estimate.model.radius ||
              found->result.point_rms < 1e-12 || (known && deviation == 0.0);
    can_be &= !isnan(deviation) || (found->result.flags & CYLFUSE_RESULT_FLAGS_UNCERTAINTY_UNKNOWN) != 0;
    if (!CHECK(can_be)) {
        printf("    %s: radius %g +- %g, rms %g, flags %u\n", what, found->estimate.model.radius, deviation,
               found->result.point_rms, (unsigned)found->result.flags);
    }
}

void impossible_variances(void)
{
    static const double seven[7][3] = {
        {0.10582885845113781, 0.17928612782569511, 0.00038473359716296979},
        {0.10547858403342507, 0.17955363425729012, -0.00010047747444059247},
        {0.10520933556306819, 0.17939516812789422, -0.00015713532137325175},
        {0.10528984815572857, 0.17975115318647325, 0.00010746370702587293},
        {0.10524718568835509, 0.17884557158761477, 5.6138678160365602e-05},
        {0.10565868128689393, 0.17928870381151166, 0.00049752086103494082},
        {0.10561020421464976, 0.17887917157309926, 0.0002190252710213053},
    };
    cylfuse_fitter *fitter = new_fitter();
    CHECK_STATUS(push(fitter, seven[0], 7), OK);
    outcome found = fit(fitter);
    if (found.status == CYLFUSE_STATUS_OK) {
        check_covariance(&found, 0, "seven points");
    }
    destroy(fitter);

    for (int round = 0; round < 400; round++) {
        double points[20][3];
        int count = 6 + round % 8 * 2;
        double arc = 0.2 + 6.0 * uniform(), noise = round % 3 != 0 ? 0.01 * uniform() : 0.0;
        for (int k = 0; k < count; k++) {
            double angle = arc * uniform();
            points[k][0] = 0.3 * cos(angle) + noise * uniform();
            points[k][1] = uniform();
            points[k][2] = 2.0 + 0.3 * sin(angle) + noise * uniform();
        }
        fitter = new_fitter();
        CHECK_STATUS(push(fitter, points[0], (size_t)count), OK);
        found = fit(fitter);
        if (found.status == CYLFUSE_STATUS_OK) {
            check_covariance(&found, 0, "few points");
        }
        destroy(fitter);
    }

    /* A known radius in the wrong unit is nothing that points can agree with: warnings or residuals show it. */
    double *points = cylinder_points(500);
    for (double radius = 1e3; radius < 1e8; radius *= 10.0) {
        fitter = new_fitter();
        CHECK_STATUS(push(fitter, points, 500), OK);
        cylfuse_options options = defaults();
        options.radius_min = options.radius_max = radius;
        if (cylfuse_fitter_set_options(fitter, &options) == CYLFUSE_STATUS_OK) {
            found = fit(fitter);
            if (found.status == CYLFUSE_STATUS_OK) {
                check_covariance(&found, 1, "a known radius");
                CHECK(found.result.flags != 0 || found.result.point_rms > 0.1);
            }
        }
        destroy(fitter);
    }
    free(points);
}

/* Intrinsics in thousandths of a pixel: what the depth shows is a needle. */
void intrinsics_in_a_wrong_unit(void)
{
    enum { COLUMNS = 640, ROWS = 480 };
    static uint16_t depths[COLUMNS * ROWS];
    static uint8_t pixels[COLUMNS * ROWS];
    double radius = 0.03, z = 0.7, x = -0.05;
    for (int step = 1; step <= 2048; step *= 8) {
        for (int k = 0; k < COLUMNS * ROWS; k++) {
            double ray = (k % COLUMNS - 319.5) / 570.0, a = 1.0 + ray * ray, b = -2.0 * (z + ray * x);
            double discriminant = b * b - 4.0 * a * (z * z + x * x - radius * radius);
            int seen = discriminant > 0.0 && abs(k / COLUMNS - 240) < 80;
            pixels[k] = (uint8_t)seen;
            depths[k] = seen ? (uint16_t)((int)((-b - sqrt(discriminant)) / (2.0 * a) * 1e4) / step * step) : 0;
        }
        cylfuse_fitter *fitter = new_fitter();
        cylfuse_intrinsics camera;
        CHECK_STATUS(cylfuse_intrinsics_init(&camera, sizeof camera), OK);
        camera.width = COLUMNS;
        camera.height = ROWS;
        camera.fx = camera.fy = 570e3;
        camera.cx = 319.5e3;
        camera.cy = 239.5e3;
        cylfuse_mask_view mask = mask_of(pixels, COLUMNS, ROWS);
        cylfuse_depth_view depth;
        CHECK_STATUS(cylfuse_depth_view_init(&depth, sizeof depth), OK);
        depth.format = CYLFUSE_DEPTH_FORMAT_U16;
        depth.data = depths;
        depth.width = COLUMNS;
        depth.height = ROWS;
        depth.scale = 1e-4;
        if (cylfuse_fitter_set_intrinsics(fitter, &camera) == CYLFUSE_STATUS_OK &&
            cylfuse_fitter_push_depth(fitter, &depth, &mask) == CYLFUSE_STATUS_OK) {
            outcome found = fit(fitter);
            if (found.status == CYLFUSE_STATUS_OK) {
                check_covariance(&found, 0, "intrinsics in a wrong unit");
            }
        }
        destroy(fitter);
    }
}

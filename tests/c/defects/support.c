/* Checks, and what makes fitters, views and points. */
#include "defects.h"

int failures = 0;

int check(int holds, const char *what, int line)
{
    if (!holds) {
        failures++;
        printf("line %d: failed: %s\n", line, what);
        fflush(stdout);
    }
    return holds;
}

int check_status(cylfuse_status got, cylfuse_status expected, const char *call, int line)
{
    if (got != expected) {
        failures++;
        printf("line %d: %s\n    returned %s (%s)\n    instead of %s\n", line, call, cylfuse_status_string(got),
               cylfuse_fitter_last_error(NULL), cylfuse_status_string(expected));
        fflush(stdout);
    }
    return got == expected;
}

cylfuse_fitter *new_fitter(void)
{
    cylfuse_fitter *fitter = NULL;
    CHECK_STATUS(cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &fitter), OK);
    return fitter;
}

void destroy(cylfuse_fitter *fitter)
{
    CHECK_STATUS(cylfuse_fitter_destroy(fitter), OK);
}

cylfuse_points_view view_of(const void *points, size_t count)
{
    cylfuse_points_view view;
    CHECK_STATUS(cylfuse_points_view_init(&view, sizeof view), OK);
    view.scalar = CYLFUSE_SCALAR_F64;
    view.data = points;
    view.width = count;
    return view;
}

cylfuse_status push(cylfuse_fitter *fitter, const double *points, size_t count)
{
    cylfuse_points_view view = view_of(points, count);
    return cylfuse_fitter_push_points(fitter, &view, NULL);
}

cylfuse_status set_camera(cylfuse_fitter *fitter, uint32_t width, uint32_t height, double fx, double fy)
{
    cylfuse_intrinsics camera;
    CHECK_STATUS(cylfuse_intrinsics_init(&camera, sizeof camera), OK);
    camera.width = width;
    camera.height = height;
    camera.fx = fx;
    camera.fy = fy;
    camera.cx = 0.5 * (width - 1);
    camera.cy = 0.5 * (height - 1);
    return cylfuse_fitter_set_intrinsics(fitter, &camera);
}

cylfuse_mask_view mask_of(const uint8_t *data, uint32_t width, uint32_t height)
{
    cylfuse_mask_view mask;
    CHECK_STATUS(cylfuse_mask_view_init(&mask, sizeof mask), OK);
    mask.data = data;
    mask.width = width;
    mask.height = height;
    return mask;
}

cylfuse_options defaults(void)
{
    cylfuse_options options;
    CHECK_STATUS(cylfuse_options_init(&options, sizeof options), OK);
    return options;
}

outcome fit(cylfuse_fitter *fitter)
{
    outcome found;
    CHECK_STATUS(cylfuse_result_init(&found.result, sizeof found.result), OK);
    CHECK_STATUS(cylfuse_cylinder_estimate_init(&found.estimate, sizeof found.estimate), OK);
    found.status = cylfuse_fitter_fit(fitter, &found.result, &found.estimate);
    return found;
}

/* Points all around a cylinder of radius 0.3. */
double *cylinder_points(size_t count)
{
    double *points = malloc(3 * sizeof(double) * count);
    if (points == NULL) {
        exit(2);
    }
    for (size_t k = 0; k < count; k++) {
        points[3 * k] = 0.1 + 0.3 * cos(0.7 * (double)k);
        points[3 * k + 1] = 0.02 * (double)(k % 50) - 0.5;
        points[3 * k + 2] = 2.0 + 0.3 * sin(0.7 * (double)k);
    }
    return points;
}

const cylfuse_cylinder CYLINDER = {{0.1, 0.0, 2.0}, {0.0, 1.0, 0.0}, 0.3};

double seconds(clockid_t of)
{
    struct timespec now;
    clock_gettime(of, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double uniform(void)
{
    static uint64_t state = 88172645463325252u;
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double)(state >> 11) / 9007199254740992.0;
}

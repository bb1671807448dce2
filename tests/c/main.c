/* Walks the whole C interface on a scene that it makes itself. Prints what fails; the exit status is 1 then. */
#include "check.h"

static int failures = 0;

int check(int holds, const char *what, const char *file, int line)
{
    if (!holds) {
        failures++;
        printf("%s:%d: failed: %s\n", file, line, what);
    }
    return holds;
}

int check_status(cylfuse_status got, cylfuse_status expected, const char *call, const char *file, int line)
{
    if (got != expected) {
        failures++;
        printf("%s:%d: %s\n    returned %s\n    instead of %s\n", file, line, call, cylfuse_status_string(got),
               cylfuse_status_string(expected));
    }
    return got == expected;
}

int check_error(const cylfuse_fitter *fitter, cylfuse_status got, cylfuse_status expected, const char *text,
                const char *call, const char *file, int line)
{
    const char *message = cylfuse_fitter_last_error(fitter);
    int found = text[0] == '\0' ? message[0] == '\0' : strstr(message, text) != NULL;
    if (!found) {
        failures++;
        printf("%s:%d: %s\n    left the message \"%s\"\n    without \"%s\"\n", file, line, call, message, text);
    }
    return check_status(got, expected, call, file, line) && found;
}

void *exactly(size_t size)
{
    void *memory = malloc(size);
    if (memory == NULL && size > 0) {
        puts("out of memory");
        exit(2);
    }
    return memory;
}

void *copy_of(const void *bytes, size_t size)
{
    void *memory = exactly(size);
    memcpy(memory, bytes, size);
    return memory;
}

cylfuse_fitter *new_fitter(void)
{
    cylfuse_fitter *fitter = NULL;
    CHECK_OK(cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &fitter));
    return fitter;
}

cylfuse_fitter *new_camera_fitter(void)
{
    cylfuse_fitter *fitter = new_fitter();
    CHECK_OK(cylfuse_fitter_set_intrinsics(fitter, &the_scene.intrinsics));
    return fitter;
}

cylfuse_fitter *new_full_fitter(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_points_view points = scene_points();
    cylfuse_segments_view edges = scene_edges();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    return fitter;
}

void destroy(cylfuse_fitter *fitter)
{
    CHECK_OK(cylfuse_fitter_destroy(fitter));
}

cylfuse_result fit(cylfuse_fitter *fitter)
{
    cylfuse_result result;
    CHECK_OK(cylfuse_result_init(&result, sizeof result));
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &result, NULL), OK, "");
    return result;
}

cylfuse_cylinder_estimate fit_cylinder(cylfuse_fitter *fitter)
{
    cylfuse_cylinder_estimate estimate;
    CHECK_OK(cylfuse_cylinder_estimate_init(&estimate, sizeof estimate));
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, NULL, &estimate), OK, "");
    return estimate;
}

cylfuse_cylinder_estimate cylinder_of(const cylfuse_fitter *fitter)
{
    cylfuse_cylinder_estimate estimate;
    CHECK_OK(cylfuse_cylinder_estimate_init(&estimate, sizeof estimate));
    CHECK_ERROR(fitter, cylfuse_fitter_get_cylinder(fitter, &estimate), OK, "");
    return estimate;
}

cylfuse_counts counts(const cylfuse_fitter *fitter)
{
    cylfuse_counts counts;
    CHECK_OK(cylfuse_counts_init(&counts, sizeof counts));
    CHECK_OK(cylfuse_fitter_counts(fitter, &counts));
    return counts;
}

int is_truth(const cylfuse_cylinder *model, double tolerance)
{
    double angle = 9, distance = 9, radius = 9;
    CHECK_OK(cylfuse_cylinder_compare(&the_scene.truth, model, &angle, &distance, &radius));
    int holds = angle <= tolerance && distance <= tolerance && fabs(radius) <= tolerance;
    if (!holds) {
        printf("off by %g rad, %g, %g of the radius\n", angle, distance, radius);
    }
    return holds;
}

int found_truth(const cylfuse_fitter *fitter, double tolerance)
{
    cylfuse_cylinder_estimate estimate = cylinder_of(fitter);
    return is_truth(&estimate.model, tolerance);
}

int fits_truth(cylfuse_fitter *fitter, double tolerance)
{
    fit(fitter);
    return found_truth(fitter, tolerance);
}

int main(void)
{
    make_scene();
    test_library();
    test_null_pointers();
    test_constants();
    test_struct_sizes();
    test_order_of_calls();
    test_points();
    test_depth();
    test_edges();
    test_image();
    test_fit();
    test_options();
    test_callbacks();
    test_threads();
    test_completion();
    test_extent();
    test_edge_selection();
    test_cylinder();
    test_plan();
    test_memory();
    test_batch();
    test_views();
    test_lists();
    test_readers();
    test_conformity();
    test_clone();
#ifdef CYLFUSE_PANIC_TEST
    test_panic();
#else
    /* With a library that is not optimised, as that of the panic test is, these take minutes. */
    test_detector();
    test_detector_calls();
#endif
    if (failures > 0) {
        printf("%d checks failed\n", failures);
        return 1;
    }
    puts("all checks hold");
    return 0;
}

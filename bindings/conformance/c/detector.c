/* The calls on a detector. */
#include "runner.h"

#include <stdlib.h>
#include <string.h>

static cylfuse_detector_options read_detector_options(const cJSON *given)
{
    static const char *const image_uses[] = {"AUTO", "IGNORE", NULL};
    cylfuse_detector_options options;
    cylfuse_detector_options_init(&options, sizeof options);
    for (const cJSON *value = given->child; value; value = value->next) {
        const char *key = value->string;
        if (strcmp(key, "image_use") == 0) options.image_use = named(value, image_uses);
        else if (strcmp(key, "max_threads") == 0) options.max_threads = (uint32_t)number(value);
        else if (strcmp(key, "max_count") == 0) options.max_count = (uint32_t)number(value);
        else if (strcmp(key, "min_pixels") == 0) options.min_pixels = (uint64_t)number(value);
        else if (strcmp(key, "min_score") == 0) options.min_score = number(value);
        else if (strcmp(key, "radius_min") == 0) options.radius_min = number(value);
        else if (strcmp(key, "radius_max") == 0) options.radius_max = number(value);
        else if (strcmp(key, "axis") == 0) numbers(value, options.axis, 3);
        else if (strcmp(key, "axis_max_angle") == 0) options.axis_max_angle = number(value);
        else stop("unknown option", key);
    }
    return options;
}

static void set_options(const run *r)
{
    cylfuse_detector_options options = read_detector_options(need(r->step, "options"));
    succeeded_on_detector(r, cylfuse_detector_set_options(r->detector, &options));
}

static void get_options(const run *r)
{
    cylfuse_detector_options options;
    cylfuse_detector_options_init(&options, sizeof options);
    if (!succeeded_on_detector(r, cylfuse_detector_get_options(r->detector, &options))) return;
    PRINT(r, options, image_use);
    PRINT(r, options, max_threads);
    PRINT(r, options, max_count);
    PRINT(r, options, min_pixels);
    PRINT(r, options, min_score);
    PRINT(r, options, radius_min);
    PRINT(r, options, radius_max);
    PRINT_LIST(r, options, axis);
    PRINT(r, options, axis_max_angle);
}

static void set_fit_options(const run *r)
{
    cylfuse_options options = read_options(need(r->step, "options"));
    succeeded_on_detector(r, cylfuse_detector_set_fit_options(r->detector, &options));
}

static void get_fit_options(const run *r)
{
    cylfuse_options options;
    cylfuse_options_init(&options, sizeof options);
    if (succeeded_on_detector(r, cylfuse_detector_get_fit_options(r->detector, &options))) print_options(r, &options);
}

/* What was found, unless `status` says that the search failed. */
static void detections(const run *r, cylfuse_status status)
{
    size_t count = 0;
    cylfuse_detection *found = NULL;
    if (status == CYLFUSE_STATUS_OK) status = cylfuse_detector_count(r->detector, &count);
    if (status == CYLFUSE_STATUS_OK) {
        found = allocate(count * sizeof *found);
        status = cylfuse_detector_detections(r->detector, found, sizeof *found, count, &count);
    }
    if (succeeded_on_detector(r, status)) {
        PRINT_COLUMN(r, found, count, score);
        PRINT_COLUMN(r, found, count, pixels);
        PRINT_COLUMNS(r, found, count, "model.point", 3, model.point[k % width]);
        PRINT_COLUMNS(r, found, count, "model.direction", 3, model.direction[k % width]);
        PRINT_COLUMNS(r, found, count, "model.radius", 1, model.radius);
    }
    free(found);
}

static size_t index_of(const run *r)
{
    return (size_t)number(need(r->step, "index"));
}

static void get_result(const run *r)
{
    cylfuse_result result;
    cylfuse_result_init(&result, sizeof result);
    if (succeeded_on_detector(r, cylfuse_detector_get_result(r->detector, index_of(r), &result))) {
        print_result(r, &result);
    }
}

static void get_cylinder(const run *r)
{
    cylfuse_cylinder_estimate estimate;
    cylfuse_cylinder_estimate_init(&estimate, sizeof estimate);
    if (succeeded_on_detector(r, cylfuse_detector_get_cylinder(r->detector, index_of(r), &estimate))) {
        print_estimate(r, &estimate);
    }
}

static void get_extent(const run *r)
{
    cylfuse_extent extent;
    cylfuse_extent_init(&extent, sizeof extent);
    if (succeeded_on_detector(r, cylfuse_detector_get_extent(r->detector, index_of(r), &extent))) {
        print_extent(r, &extent);
    }
}

static void labels(const run *r)
{
    size_t count = 0;
    cylfuse_status status = cylfuse_detector_labels(r->detector, NULL, 0, &count);
    uint16_t *found = allocate(count * sizeof *found);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_detector_labels(r->detector, found, count, &count);
    }
    double *values = allocate(count * sizeof *values);
    for (size_t k = 0; k < count; k++) values[k] = found[k];
    if (succeeded_on_detector(r, status)) print_numbers(r, "labels", values, count);
    free(values);
    free(found);
}

static void indices(const run *r)
{
    size_t count = 0;
    cylfuse_status status = cylfuse_detector_indices(r->detector, index_of(r), NULL, 0, &count);
    uint32_t *found = allocate(count * sizeof *found);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_detector_indices(r->detector, index_of(r), found, count, &count);
    }
    double *values = allocate(count * sizeof *values);
    for (size_t k = 0; k < count; k++) values[k] = found[k];
    if (succeeded_on_detector(r, status)) print_numbers(r, "indices", values, count);
    free(values);
    free(found);
}

/* The fitter takes the place of that of the case. */
static void make_fitter(run *r)
{
    cylfuse_fitter *fitter = NULL;
    if (!succeeded_on_detector(r, cylfuse_detector_make_fitter(r->detector, index_of(r), &fitter))) return;
    cylfuse_fitter_destroy(r->fitter);
    r->fitter = fitter;
}

static void detect_points(const run *r)
{
    cylfuse_points_view points = read_points(r);
    detections(r, cylfuse_detector_detect_points(r->detector, &points));
}

void run_detector_step(run *r, const char *call)
{
#define CALL(name) if (strcmp(call, #name) == 0)
    CALL(detector_set_options) set_options(r);
    else CALL(detector_get_options) get_options(r);
    else CALL(detector_set_fit_options) set_fit_options(r);
    else CALL(detector_get_fit_options) get_fit_options(r);
    else CALL(detector_cancel) succeeded_on_detector(r, cylfuse_detector_cancel(r->detector));
    else CALL(detect) detections(r, cylfuse_detector_detect(r->detector, r->frame));
    else CALL(detect_points) detect_points(r);
    else CALL(detections) detections(r, CYLFUSE_STATUS_OK);
    else CALL(detector_get_result) get_result(r);
    else CALL(detector_get_cylinder) get_cylinder(r);
    else CALL(detector_get_extent) get_extent(r);
    else CALL(labels) labels(r);
    else CALL(indices) indices(r);
    else CALL(make_fitter) make_fitter(r);
    else stop("unknown call", call);
}

/* The calls on detectors. */
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

static void get_detector_options(const run *r)
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

static void detections(const run *r)
{
    size_t count = 0;
    cylfuse_status status = cylfuse_detector_detections(r->detector, NULL, sizeof(cylfuse_detection), 0, &count);
    cylfuse_detection *found = allocate(count * sizeof *found);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_detector_detections(r->detector, found, sizeof *found, count, &count);
    }
    if (succeeded_on_detector(r, status)) {
        PRINT_COLUMN(r, found, count, score);
        PRINT_COLUMN(r, found, count, pixels);
        PRINT_VECTORS(r, found, count, model.point);
        PRINT_VECTORS(r, found, count, model.direction);
        PRINT_COLUMN(r, found, count, model.radius);
    }
    free(found);
}

static void labels(const run *r)
{
    size_t count = 0;
    cylfuse_status status = cylfuse_detector_labels(r->detector, NULL, 0, &count);
    uint16_t *all = allocate(count * sizeof *all);
    double *values = allocate(count * sizeof *values);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) status = cylfuse_detector_labels(r->detector, all, count, &count);
    for (size_t k = 0; k < count; k++) values[k] = all[k];
    if (succeeded_on_detector(r, status)) print_numbers(r, "labels", values, count);
    free(all);
    free(values);
}

static void indices(const run *r, size_t index)
{
    size_t count = 0;
    cylfuse_status status = cylfuse_detector_indices(r->detector, index, NULL, 0, &count);
    uint32_t *all = allocate(count * sizeof *all);
    double *values = allocate(count * sizeof *values);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_detector_indices(r->detector, index, all, count, &count);
    }
    for (size_t k = 0; k < count; k++) values[k] = all[k];
    if (succeeded_on_detector(r, status)) print_numbers(r, "indices", values, count);
    free(all);
    free(values);
}

static cylfuse_status make_fitter(run *r, size_t index)
{
    cylfuse_fitter *made;
    cylfuse_status status = cylfuse_detector_make_fitter(r->detector, index, &made);
    if (status == CYLFUSE_STATUS_OK) {
        cylfuse_fitter_destroy(r->fitter);
        r->fitter = made;
    }
    return status;
}

cylfuse_status new_detector(run *r)
{
    cylfuse_detector_destroy(r->detector);
    return cylfuse_detector_create(CYLFUSE_ABI_VERSION, &r->detector);
}

int run_on_detector(run *r, const char *call)
{
    cylfuse_detector *detector = r->detector;
    const cJSON *given = cJSON_GetObjectItemCaseSensitive(r->step, "index");
    size_t count = 0, index = given ? (size_t)number(given) : 0;
    cylfuse_result result;
    cylfuse_cylinder_estimate estimate;
    cylfuse_extent extent;
    cylfuse_options fits;
    cylfuse_result_init(&result, sizeof result);
    cylfuse_cylinder_estimate_init(&estimate, sizeof estimate);
    cylfuse_extent_init(&extent, sizeof extent);
    cylfuse_options_init(&fits, sizeof fits);
#define CALL(name) if (strcmp(call, #name) == 0)
    CALL(new_detector) succeeded(r, new_detector(r), NULL);
    else CALL(detector_set_options)
    {
        cylfuse_detector_options options = read_detector_options(need(r->step, "options"));
        succeeded_on_detector(r, cylfuse_detector_set_options(detector, &options));
    }
    else CALL(detector_get_options) get_detector_options(r);
    else CALL(detector_set_fit_options)
    {
        fits = read_options(need(r->step, "options"));
        succeeded_on_detector(r, cylfuse_detector_set_fit_options(detector, &fits));
    }
    else CALL(detector_get_fit_options)
    {
        if (succeeded_on_detector(r, cylfuse_detector_get_fit_options(detector, &fits))) print_options(r, &fits);
    }
    else CALL(detector_cancel) succeeded_on_detector(r, cylfuse_detector_cancel(detector));
    else CALL(detect) succeeded_on_detector(r, cylfuse_detector_detect(detector, r->frame));
    else CALL(detect_points)
    {
        cylfuse_points_view points = read_points(r);
        succeeded_on_detector(r, cylfuse_detector_detect_points(detector, &points));
    }
    else CALL(detector_count)
    {
        if (succeeded_on_detector(r, cylfuse_detector_count(detector, &count))) print_number(r, "count", (double)count);
    }
    else CALL(detector_detections) detections(r);
    else CALL(detector_get_result)
    {
        if (succeeded_on_detector(r, cylfuse_detector_get_result(detector, index, &result))) print_result(r, &result);
    }
    else CALL(detector_get_cylinder)
    {
        if (succeeded_on_detector(r, cylfuse_detector_get_cylinder(detector, index, &estimate))) print_estimate(r, &estimate);
    }
    else CALL(detector_get_extent)
    {
        if (succeeded_on_detector(r, cylfuse_detector_get_extent(detector, index, &extent))) print_extent(r, &extent);
    }
    else CALL(detector_labels) labels(r);
    else CALL(detector_indices) indices(r, index);
    else CALL(detector_make_fitter) succeeded_on_detector(r, make_fitter(r, index));
    else return 0;
    return 1;
}

/* Runs the golden cases by the C interface and prints the results as bits; the format is that of README.md.
 * cc -I../../../include runner.c read.c print.c -lcylfuse -lcjson -lm; runner cases.json */
#include "runner.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static cylfuse_status push_points(const run *r)
{
    cylfuse_points_view points = read_points(r);
    cylfuse_mask_view mask;
    return cylfuse_fitter_push_points(r->fitter, &points, read_mask(r, &mask));
}

static cylfuse_status push_depth(const run *r)
{
    array depth = read_array(r, need(r->step, "depth"));
    cylfuse_depth_view view;
    cylfuse_depth_view_init(&view, sizeof view);
    view.format = strcmp(depth.type, "u16") == 0 ? CYLFUSE_DEPTH_FORMAT_U16 : CYLFUSE_DEPTH_FORMAT_F32;
    view.data = depth.bytes;
    view.width = (uint32_t)depth.width;
    view.height = (uint32_t)depth.height;
    view.scale = number(need(r->step, "scale"));
    view.min_depth = number_or(r->step, "min_depth", 0.0);
    view.max_depth = number_or(r->step, "max_depth", 0.0);
    cylfuse_mask_view mask;
    return cylfuse_fitter_push_depth(r->fitter, &view, read_mask(r, &mask));
}

static cylfuse_status push_image(const run *r)
{
    array image = read_array(r, need(r->step, "image"));
    cylfuse_image_view view;
    cylfuse_image_view_init(&view, sizeof view);
    view.format = image.element_size == 1   ? CYLFUSE_IMAGE_FORMAT_U8
                  : image.element_size == 2 ? CYLFUSE_IMAGE_FORMAT_U16
                                            : CYLFUSE_IMAGE_FORMAT_F32;
    view.data = image.bytes;
    view.width = (uint32_t)image.width;
    view.height = (uint32_t)image.height;
    return cylfuse_fitter_push_image(r->fitter, &view);
}

static cylfuse_status push_edges(const run *r)
{
    cylfuse_segments_view segments = read_segments(r);
    return cylfuse_fitter_push_edges(r->fitter, &segments);
}

static void select_edges(const run *r)
{
    cylfuse_cylinder model;
    cylfuse_segments_view segments = read_segments(r);
    unsigned char *selected = allocate(segments.count);
    double *values = allocate(segments.count * sizeof *values);
    cylfuse_status status = cylfuse_fitter_select_edges(r->fitter, read_model(r, "model", &model), &segments,
                                                        number_or(r->step, "reach", 0.0), selected, segments.count);
    for (size_t k = 0; k < segments.count; k++) values[k] = selected[k];
    if (succeeded(r, status, r->fitter)) print_numbers(r, "selected", values, segments.count);
    free(selected);
    free(values);
}

static void counts(const run *r)
{
    cylfuse_counts counts = {.struct_size = sizeof counts};
    if (!succeeded(r, cylfuse_fitter_counts(r->fitter, &counts), r->fitter)) return;
    PRINT(r, counts, points_given);
    PRINT(r, counts, points_used);
    PRINT(r, counts, dropped_not_finite);
    PRINT(r, counts, dropped_zero_weight);
    PRINT(r, counts, dropped_outside_mask);
    PRINT(r, counts, dropped_no_depth);
    PRINT(r, counts, dropped_out_of_range);
    PRINT(r, counts, dropped_outside_camera);
    PRINT(r, counts, segments_given);
}

static void residuals(const run *r)
{
    static const char *const kinds[] = {"", "POINTS", "EDGES", NULL};
    cylfuse_cylinder model;
    const cylfuse_cylinder *given = read_model(r, "model", &model);
    cylfuse_residual_kind kind = named(need(r->step, "kind"), kinds);
    size_t count = 0;
    cylfuse_status status = cylfuse_fitter_residuals(r->fitter, given, kind, NULL, 0, &count);
    double *values = allocate(count * sizeof *values);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_fitter_residuals(r->fitter, given, kind, values, count, &count);
    }
    if (succeeded(r, status, r->fitter)) print_numbers(r, "residuals", values, count);
    free(values);
}

static void limb_samples(const run *r)
{
    size_t count = 0;
    cylfuse_status status = cylfuse_fitter_limb_samples(r->fitter, NULL, 0, &count);
    cylfuse_limb_sample *samples = allocate(count * sizeof *samples);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_fitter_limb_samples(r->fitter, samples, count, &count);
    }
    if (succeeded(r, status, r->fitter)) {
        double *values = allocate(2 * count * sizeof *values);
        for (size_t k = 0; k < 2 * count; k++) values[k] = samples[k / 2].pixel[k % 2];
        print_numbers(r, "pixel", values, 2 * count);
        for (size_t k = 0; k < count; k++) values[k] = samples[k].sigma;
        print_numbers(r, "sigma", values, count);
        for (size_t k = 0; k < count; k++) values[k] = samples[k].weight;
        print_numbers(r, "weight", values, count);
        for (size_t k = 0; k < count; k++) values[k] = samples[k].limb;
        print_numbers(r, "limb", values, count);
        free(values);
    }
    free(samples);
}

static void diagnose(const run *r)
{
    cylfuse_cylinder model;
    cylfuse_diagnosis diagnosis = {.struct_size = sizeof diagnosis};
    if (!succeeded(r, cylfuse_fitter_diagnose(r->fitter, read_model(r, "model", &model), &diagnosis), r->fitter)) return;
    PRINT(r, diagnosis, rank);
    PRINT_LIST(r, diagnosis, singular_values);
    PRINT(r, diagnosis, condition);
    PRINT_LIST(r, diagnosis, weakest_shift);
    PRINT_LIST(r, diagnosis, weakest_tilt);
    PRINT(r, diagnosis, weakest_radius);
}

static void complete(const run *r)
{
    static const char *const layouts[] = {"PACKED", "ORGANISED", NULL}, *const scalars[] = {"", "F32", "F64", NULL};
    cylfuse_cylinder model;
    cylfuse_mask_view mask;
    cylfuse_points_out out;
    cylfuse_completion completion = {.struct_size = sizeof completion};
    const cylfuse_cylinder *given = read_model(r, "model", &model);
    const cylfuse_mask_view *region = read_mask(r, &mask);
    cylfuse_points_out_init(&out, sizeof out);
    out.layout = named(need(r->step, "layout"), layouts);
    out.scalar = named(need(r->step, "scalar"), scalars);
    cylfuse_status status = cylfuse_fitter_complete_bound(r->fitter, region, out.layout, &out.capacity);
    unsigned char *bytes = allocate(out.capacity * 3 * sizeof(double));
    if (status == CYLFUSE_STATUS_OK) {
        out.data = bytes;
        status = cylfuse_fitter_complete(r->fitter, given, region, &out, &completion);
    }
    if (succeeded(r, status, r->fitter)) {
        size_t count = (size_t)completion.count * 3;
        double *values = allocate(count * sizeof *values);
        for (size_t k = 0; k < count; k++) {
            float narrow;
            memcpy(&narrow, bytes + k * sizeof narrow, sizeof narrow);
            values[k] = narrow;
        }
        if (out.scalar == CYLFUSE_SCALAR_F64) memcpy(values, bytes, count * sizeof *values);
        print_completion(r, &completion);
        print_numbers(r, "points", values, count);
        free(values);
    }
    free(bytes);
}

static void complete_depth(const run *r)
{
    static const char *const formats[] = {"", "U16", "F32", NULL};
    cylfuse_cylinder model;
    cylfuse_mask_view mask;
    cylfuse_depth_out out;
    cylfuse_completion completion = {.struct_size = sizeof completion};
    const cylfuse_cylinder *given = read_model(r, "model", &model);
    const cylfuse_mask_view *region = read_mask(r, &mask);
    cylfuse_depth_out_init(&out, sizeof out);
    out.format = named(need(r->step, "format"), formats);
    out.scale = number(need(r->step, "scale"));
    out.width = region->width;
    out.height = region->height;
    size_t count = (size_t)out.width * out.height;
    unsigned char *bytes = allocate(count * sizeof(float));
    out.data = bytes;
    if (succeeded(r, cylfuse_fitter_complete_depth(r->fitter, given, region, &out, &completion), r->fitter)) {
        double *values = allocate(count * sizeof *values);
        for (size_t k = 0; k < count; k++) {
            if (out.format == CYLFUSE_DEPTH_FORMAT_U16) {
                uint16_t whole;
                memcpy(&whole, bytes + k * sizeof whole, sizeof whole);
                values[k] = whole;
            } else {
                float narrow;
                memcpy(&narrow, bytes + k * sizeof narrow, sizeof narrow);
                values[k] = narrow;
            }
        }
        print_completion(r, &completion);
        print_numbers(r, "depth", values, count);
        free(values);
    }
    free(bytes);
}

static void extent(const run *r)
{
    cylfuse_cylinder model;
    cylfuse_mask_view mask;
    cylfuse_extent extent = {.struct_size = sizeof extent};
    const cylfuse_cylinder *given = read_model(r, "model", &model);
    if (!succeeded(r, cylfuse_fitter_extent(r->fitter, given, read_mask(r, &mask), &extent), r->fitter)) return;
    PRINT(r, extent, start_state);
    PRINT(r, extent, end_state);
    PRINT_LIST(r, extent, start);
    PRINT_LIST(r, extent, end);
    PRINT_LIST(r, extent, center);
    PRINT(r, extent, length);
    PRINT(r, extent, start_deviation);
    PRINT(r, extent, end_deviation);
    PRINT(r, extent, length_deviation);
    PRINT_LIST(r, extent, start_covariance);
    PRINT_LIST(r, extent, end_covariance);
    PRINT_LIST(r, extent, center_covariance);
}

static void distances(const run *r)
{
    cylfuse_cylinder model;
    cylfuse_points_view points = read_points(r);
    size_t count = points.width * points.height;
    double *values = allocate(count * sizeof *values);
    cylfuse_status status = cylfuse_cylinder_distances(read_model(r, "model", &model), &points, values, count);
    if (succeeded(r, status, NULL)) print_numbers(r, "distances", values, count);
    free(values);
}

static void project(const run *r)
{
    cylfuse_cylinder model;
    cylfuse_intrinsics camera = read_camera(r);
    double lines[6];
    if (succeeded(r, cylfuse_cylinder_project(read_model(r, "model", &model), &camera, lines), NULL)) {
        print_numbers(r, "lines", lines, 6);
    }
}

static void compare(const run *r)
{
    cylfuse_cylinder a, b;
    double angle, axis_distance, radius_relative;
    cylfuse_status status = cylfuse_cylinder_compare(read_model(r, "a", &a), read_model(r, "b", &b), &angle,
                                                     &axis_distance, &radius_relative);
    if (!succeeded(r, status, NULL)) return;
    print_number(r, "angle", angle);
    print_number(r, "axis_distance", axis_distance);
    print_number(r, "radius_relative", radius_relative);
}

static void set_options(const run *r)
{
    cylfuse_options options = read_options(need(r->step, "options"));
    succeeded(r, cylfuse_fitter_set_options(r->fitter, &options), r->fitter);
}

static void get_options(const run *r)
{
    cylfuse_options options = {.struct_size = sizeof options};
    if (succeeded(r, cylfuse_fitter_get_options(r->fitter, &options), r->fitter)) print_options(r, &options);
}

static void run_step(const run *r)
{
    const char *call = need(r->step, "call")->valuestring;
    cylfuse_cylinder model;
    cylfuse_result result = {.struct_size = sizeof result};
#define CALL(name) else if (strcmp(call, #name) == 0)
    if (strcmp(call, "set_intrinsics") == 0) {
        cylfuse_intrinsics camera = read_camera(r);
        succeeded(r, cylfuse_fitter_set_intrinsics(r->fitter, &camera), r->fitter);
    }
    CALL(set_options) set_options(r);
    CALL(get_options) get_options(r);
    CALL(set_start_model)
    {
        succeeded(r, cylfuse_fitter_set_start_model(r->fitter, read_model(r, "model", &model)), r->fitter);
    }
    CALL(reserve)
    {
        size_t points = (size_t)number(need(r->step, "points")), segments = (size_t)number(need(r->step, "segments"));
        succeeded(r, cylfuse_fitter_reserve(r->fitter, points, segments), r->fitter);
    }
    CALL(clear) succeeded(r, cylfuse_fitter_clear(r->fitter), r->fitter);
    CALL(cancel) succeeded(r, cylfuse_fitter_cancel(r->fitter), r->fitter);
    CALL(push_points) succeeded(r, push_points(r), r->fitter);
    CALL(push_depth) succeeded(r, push_depth(r), r->fitter);
    CALL(push_image) succeeded(r, push_image(r), r->fitter);
    CALL(push_edges) succeeded(r, push_edges(r), r->fitter);
    CALL(select_edges) select_edges(r);
    CALL(counts) counts(r);
    CALL(fit)
    {
        if (succeeded(r, cylfuse_fitter_fit(r->fitter, &result), r->fitter)) print_result(r, &result);
    }
    CALL(get_result)
    {
        if (succeeded(r, cylfuse_fitter_get_result(r->fitter, &result), r->fitter)) print_result(r, &result);
    }
    CALL(evaluate)
    {
        cylfuse_status status = cylfuse_fitter_evaluate(r->fitter, read_model(r, "model", &model), &result);
        if (succeeded(r, status, r->fitter)) print_result(r, &result);
    }
    CALL(residuals) residuals(r);
    CALL(limb_samples) limb_samples(r);
    CALL(diagnose) diagnose(r);
    CALL(complete) complete(r);
    CALL(complete_depth) complete_depth(r);
    CALL(extent) extent(r);
    CALL(distances) distances(r);
    CALL(project) project(r);
    CALL(compare) compare(r);
    else stop("unknown call", call);
}

static char *read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END) != 0) stop("cannot be read", path);
    size_t size = (size_t)ftell(file);
    char *text = allocate(size + 1);
    rewind(file);
    if (fread(text, 1, size, file) != size) stop("cannot be read", path);
    fclose(file);
    return text;
}

int main(int argc, char **argv)
{
    if (argc != 2) stop("usage", "runner cases.json");
    char *text = read_file(argv[1]);
    cJSON *file = cJSON_Parse(text);
    if (!file) stop("is not JSON", argv[1]);
    const cJSON *one, *step;
    cJSON_ArrayForEach(one, need(file, "cases"))
    {
        run r = {.file = file, .name = need(one, "name")->valuestring, .index = 0};
        if (cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &r.fitter) != CYLFUSE_STATUS_OK) stop("no fitter", r.name);
        cJSON_ArrayForEach(step, need(one, "steps"))
        {
            r.step = step;
            run_step(&r);
            r.index++;
        }
        cylfuse_fitter_destroy(r.fitter);
    }
    cJSON_Delete(file);
    free(text);
    return 0;
}

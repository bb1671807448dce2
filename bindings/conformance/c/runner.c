/* Runs the golden cases by the C interface and prints the results as bits; the format is that of README.md.
 * cc -I../../../include *.c -lcylfuse -lcjson -lm; runner cases.json */
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
    cylfuse_depth_view depth = read_depth(r);
    cylfuse_mask_view mask;
    return cylfuse_fitter_push_depth(r->fitter, &depth, read_mask(r, &mask));
}

static cylfuse_status push_image(const run *r)
{
    cylfuse_image_view image = read_image(r);
    return cylfuse_fitter_push_image(r->fitter, &image);
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
    cylfuse_counts counts;
    cylfuse_counts_init(&counts, sizeof counts);
    if (succeeded(r, cylfuse_fitter_counts(r->fitter, &counts), r->fitter)) print_counts(r, &counts);
}

static void diagnose(const run *r)
{
    cylfuse_cylinder model;
    cylfuse_cylinder_diagnosis diagnosis;
    cylfuse_cylinder_diagnosis_init(&diagnosis, sizeof diagnosis);
    cylfuse_status status = cylfuse_fitter_diagnose(r->fitter, read_model(r, "model", &model), &diagnosis);
    if (succeeded(r, status, r->fitter)) print_diagnosis(r, &diagnosis);
}

static void complete(const run *r)
{
    static const char *const layouts[] = {"PACKED", "ORGANISED", NULL}, *const scalars[] = {"", "F32", "F64", NULL};
    cylfuse_cylinder model;
    cylfuse_mask_view mask;
    cylfuse_points_out out;
    cylfuse_completion completion;
    cylfuse_completion_init(&completion, sizeof completion);
    const cylfuse_cylinder *given = read_model(r, "model", &model);
    const cylfuse_mask_view *region = read_mask(r, &mask);
    cylfuse_points_out_init(&out, sizeof out);
    cylfuse_layout layout = named(need(r->step, "layout"), layouts);
    out.scalar = named(need(r->step, "scalar"), scalars);
    cylfuse_status status = cylfuse_fitter_complete_bound(r->fitter, region, layout, &out.capacity);
    unsigned char *bytes = allocate(out.capacity * 3 * sizeof(double));
    if (status == CYLFUSE_STATUS_OK) {
        out.data = bytes;
        status = cylfuse_fitter_complete(r->fitter, given, region, layout, &out, &completion);
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
    cylfuse_completion completion;
    cylfuse_completion_init(&completion, sizeof completion);
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
    cylfuse_extent extent;
    cylfuse_extent_init(&extent, sizeof extent);
    const cylfuse_cylinder *given = read_model(r, "model", &model);
    if (succeeded(r, cylfuse_fitter_extent(r->fitter, given, read_mask(r, &mask), &extent), r->fitter)) {
        print_extent(r, &extent);
    }
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

static void intrinsics_project(const run *r)
{
    cylfuse_intrinsics camera = read_camera(r);
    cylfuse_points_view points = read_points(r);
    size_t count = points.width * points.height;
    double *pixels = allocate(2 * count * sizeof *pixels);
    cylfuse_status status = cylfuse_intrinsics_project(&camera, &points, pixels, count);
    if (succeeded(r, status, NULL)) print_numbers(r, "pixels", pixels, 2 * count);
    free(pixels);
}

static void intrinsics_unproject(const run *r)
{
    cylfuse_intrinsics camera = read_camera(r);
    const cJSON *rows = need(r->step, "pixels");
    int count = cJSON_GetArraySize(rows);
    double *pixels = allocate(2 * (size_t)count * sizeof *pixels), *rays = allocate(3 * (size_t)count * sizeof *rays);
    for (int k = 0; k < count; k++) numbers(cJSON_GetArrayItem(rows, k), pixels + 2 * k, 2);
    cylfuse_status status = cylfuse_intrinsics_unproject(&camera, pixels, (size_t)count, rays);
    if (succeeded(r, status, NULL)) print_numbers(r, "rays", rays, 3 * (size_t)count);
    free(pixels);
    free(rays);
}

static void set_options(const run *r)
{
    cylfuse_options options = read_options(need(r->step, "options"));
    succeeded(r, cylfuse_fitter_set_options(r->fitter, &options), r->fitter);
}

static void get_options(const run *r)
{
    cylfuse_options options;
    cylfuse_options_init(&options, sizeof options);
    if (succeeded(r, cylfuse_fitter_get_options(r->fitter, &options), r->fitter)) print_options(r, &options);
}

static void view_count(const run *r)
{
    size_t count = 0;
    if (succeeded(r, cylfuse_fitter_view_count(r->fitter, &count), r->fitter)) print_number(r, "count", (double)count);
}

static cylfuse_status clear_input(const run *r)
{
    static const char *const names[] = {"POINTS", "DEPTH", "EDGES", "IMAGE", NULL};
    static const cylfuse_input bits[] = {CYLFUSE_INPUT_POINTS, CYLFUSE_INPUT_DEPTH, CYLFUSE_INPUT_EDGES,
                                         CYLFUSE_INPUT_IMAGE};
    const cJSON *name;
    cylfuse_input inputs = 0;
    cJSON_ArrayForEach(name, need(r->step, "inputs")) inputs |= bits[named(name, names)];
    return cylfuse_fitter_clear_input(r->fitter, inputs);
}

/* What a camera is, of the fitter or of the frame. */
static void set_camera(const run *r, int of_frame)
{
    cylfuse_intrinsics camera = read_camera(r);
    if (of_frame) succeeded_on_frame(r, cylfuse_frame_set_intrinsics(r->frame, &camera));
    else succeeded(r, cylfuse_fitter_set_intrinsics(r->fitter, &camera), r->fitter);
}

static void set_pose(const run *r, int of_frame)
{
    double rotation[9], translation[3];
    read_pose(r, rotation, translation);
    if (of_frame) succeeded_on_frame(r, cylfuse_frame_set_pose(r->frame, rotation, translation));
    else succeeded(r, cylfuse_fitter_set_pose(r->fitter, rotation, translation), r->fitter);
}

static void set_depth_camera(const run *r, int of_frame)
{
    double rotation[9], translation[3];
    cylfuse_intrinsics camera, *given = NULL;
    if (cJSON_IsString(need(r->step, "camera"))) {
        camera = read_camera(r);
        given = &camera;
        read_pose(r, rotation, translation);
    }
    if (of_frame) succeeded_on_frame(r, cylfuse_frame_set_depth_camera(r->frame, given, rotation, translation));
    else succeeded(r, cylfuse_fitter_set_depth_camera(r->fitter, given, rotation, translation), r->fitter);
}

static void frame_set_depth(const run *r)
{
    cylfuse_depth_view depth = read_depth(r);
    succeeded_on_frame(r, cylfuse_frame_set_depth(r->frame, &depth));
}

static void frame_set_image(const run *r)
{
    cylfuse_image_view image = read_image(r);
    succeeded_on_frame(r, cylfuse_frame_set_image(r->frame, &image));
}

static void use_frame(const run *r)
{
    cylfuse_mask_view mask;
    succeeded(r, cylfuse_fitter_use_frame(r->fitter, r->frame, read_mask(r, &mask)), r->fitter);
}

static cylfuse_status new_fitter(run *r)
{
    cylfuse_fitter_destroy(r->fitter);
    return cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &r->fitter);
}

static cylfuse_status new_frame(run *r)
{
    cylfuse_frame_destroy(r->frame);
    return cylfuse_frame_create(CYLFUSE_ABI_VERSION, &r->frame);
}

/* A fit, or what it would report for a given model. */
static void fit(const run *r, int with_model)
{
    cylfuse_cylinder model;
    cylfuse_result result;
    cylfuse_cylinder_estimate estimate;
    cylfuse_result_init(&result, sizeof result);
    cylfuse_cylinder_estimate_init(&estimate, sizeof estimate);
    cylfuse_status status =
        with_model ? cylfuse_fitter_evaluate(r->fitter, read_model(r, "model", &model), &result, &estimate)
                   : cylfuse_fitter_fit(r->fitter, &result, &estimate);
    if (succeeded(r, status, r->fitter)) {
        print_result(r, &result);
        print_estimate(r, &estimate);
    }
}

static void get_result(const run *r)
{
    cylfuse_result result;
    cylfuse_result_init(&result, sizeof result);
    if (succeeded(r, cylfuse_fitter_get_result(r->fitter, &result), r->fitter)) print_result(r, &result);
}

static void get_cylinder(const run *r)
{
    cylfuse_cylinder_estimate estimate;
    cylfuse_cylinder_estimate_init(&estimate, sizeof estimate);
    if (succeeded(r, cylfuse_fitter_get_cylinder(r->fitter, &estimate), r->fitter)) print_estimate(r, &estimate);
}

static void run_step(run *r)
{
    const char *call = need(r->step, "call")->valuestring;
    cylfuse_cylinder model;
#define CALL(name) if (strcmp(call, #name) == 0)
    CALL(new_fitter) succeeded(r, new_fitter(r), NULL);
    else CALL(new_frame) succeeded(r, new_frame(r), NULL);
    else CALL(set_intrinsics) set_camera(r, 0);
    else CALL(frame_set_intrinsics) set_camera(r, 1);
    else CALL(set_pose) set_pose(r, 0);
    else CALL(frame_set_pose) set_pose(r, 1);
    else CALL(set_depth_camera) set_depth_camera(r, 0);
    else CALL(frame_set_depth_camera) set_depth_camera(r, 1);
    else CALL(frame_set_depth) frame_set_depth(r);
    else CALL(frame_set_image) frame_set_image(r);
    else CALL(use_frame) use_frame(r);
    else CALL(set_options) set_options(r);
    else CALL(get_options) get_options(r);
    else CALL(select_view)
    {
        succeeded(r, cylfuse_fitter_select_view(r->fitter, (size_t)number(need(r->step, "index"))), r->fitter);
    }
    else CALL(view_count) view_count(r);
    else CALL(set_start_model)
    {
        succeeded(r, cylfuse_fitter_set_start_model(r->fitter, read_model(r, "model", &model)), r->fitter);
    }
    else CALL(reserve)
    {
        size_t points = (size_t)number(need(r->step, "points")), segments = (size_t)number(need(r->step, "segments"));
        succeeded(r, cylfuse_fitter_reserve(r->fitter, points, segments), r->fitter);
    }
    else CALL(clear) succeeded(r, cylfuse_fitter_clear(r->fitter), r->fitter);
    else CALL(clear_input) succeeded(r, clear_input(r), r->fitter);
    else CALL(cancel) succeeded(r, cylfuse_fitter_cancel(r->fitter), r->fitter);
    else CALL(push_points) succeeded(r, push_points(r), r->fitter);
    else CALL(push_depth) succeeded(r, push_depth(r), r->fitter);
    else CALL(push_image) succeeded(r, push_image(r), r->fitter);
    else CALL(push_edges) succeeded(r, push_edges(r), r->fitter);
    else CALL(select_edges) select_edges(r);
    else CALL(counts) counts(r);
    else CALL(fit) fit(r, 0);
    else CALL(evaluate) fit(r, 1);
    else CALL(get_result) get_result(r);
    else CALL(get_cylinder) get_cylinder(r);
    else CALL(residuals) residuals(r);
    else CALL(point_weights) point_weights(r);
    else CALL(point_parts) point_parts(r);
    else CALL(limbs) limbs(r);
    else CALL(limb_samples) limb_samples(r);
    else CALL(end_samples) end_samples(r);
    else CALL(diagnose) diagnose(r);
    else CALL(complete) complete(r);
    else CALL(complete_depth) complete_depth(r);
    else CALL(extent) extent(r);
    else CALL(distances) distances(r);
    else CALL(project) project(r);
    else CALL(compare) compare(r);
    else CALL(intrinsics_project) intrinsics_project(r);
    else CALL(intrinsics_unproject) intrinsics_unproject(r);
    else if (!run_on_detector(r, call)) stop("unknown call", call);
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
        if (new_fitter(&r) != CYLFUSE_STATUS_OK || new_frame(&r) != CYLFUSE_STATUS_OK
            || new_detector(&r) != CYLFUSE_STATUS_OK) stop("no handle", r.name);
        cJSON_ArrayForEach(step, need(one, "steps"))
        {
            r.step = step;
            run_step(&r);
            r.index++;
        }
        cylfuse_fitter_destroy(r.fitter);
        cylfuse_frame_destroy(r.frame);
        cylfuse_detector_destroy(r.detector);
    }
    cJSON_Delete(file);
    free(text);
    return 0;
}

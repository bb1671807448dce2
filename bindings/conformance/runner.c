/* Runs the golden cases by the C interface and prints the results as bits; the format is that of README.md.
 * cc -I../../include runner.c -lcylfuse -lcjson -lm; runner cases.json */
#include <cjson/cJSON.h>
#include <cylfuse/cylfuse.h>

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* An array of the file: packed, row by row. */
typedef struct {
    char type[4];
    size_t element_size, height, width, channels;
    unsigned char *bytes;
} array;

typedef struct {
    const cJSON *file, *step;
    const char *name;
    int index;
    cylfuse_fitter *fitter;
} run;

static void stop(const char *what, const char *name)
{
    fprintf(stderr, "%s: %s\n", what, name ? name : "");
    exit(2);
}

static void *allocate(size_t size)
{
    void *memory = calloc(size ? size : 1, 1);
    if (!memory) stop("out of memory", NULL);
    return memory;
}

static const cJSON *get(const cJSON *object, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

static const cJSON *need(const cJSON *object, const char *key)
{
    const cJSON *value = get(object, key);
    if (!value) stop("the file lacks", key);
    return value;
}

/* A number; null stands for NaN. */
static double number(const cJSON *value)
{
    return cJSON_IsNumber(value) ? value->valuedouble : NAN;
}

static double number_or(const cJSON *object, const char *key, double otherwise)
{
    const cJSON *value = get(object, key);
    return value ? number(value) : otherwise;
}

static void numbers(const cJSON *list, double *out, int count)
{
    for (int k = 0; k < count; k++) out[k] = number(cJSON_GetArrayItem(list, k));
}

/* The position of a text in a list that ends with NULL. */
static int32_t named(const cJSON *text, const char *const *names)
{
    for (int32_t k = 0; names[k]; k++) {
        if (strcmp(names[k], text->valuestring) == 0) return k;
    }
    stop("unknown name", text->valuestring);
    return 0;
}

static int digit(char c)
{
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : 0;
}

static array read_array(const run *r, const cJSON *name)
{
    const cJSON *value = need(need(r->file, "arrays"), name->valuestring), *shape = need(value, "shape");
    const char *text = need(value, "data")->valuestring;
    int dimensions = cJSON_GetArraySize(shape);
    size_t size[3] = {1, 1, 1};
    for (int k = 0; k < dimensions; k++) size[k] = (size_t)cJSON_GetArrayItem(shape, k)->valuedouble;
    array a = {.height = 1, .width = 1, .channels = 1};
    strcpy(a.type, need(value, "type")->valuestring);
    a.element_size = strcmp(a.type, "f64") == 0 ? 8 : strcmp(a.type, "f32") == 0 ? 4 : strcmp(a.type, "u16") == 0 ? 2 : 1;
    a.bytes = allocate(strlen(text) / 4 * 3);
    size_t at = 0;
    for (; text[0]; text += 4) {
        uint32_t bits = 0;
        for (int k = 0; k < 4; k++) bits = bits << 6 | (uint32_t)digit(text[k]);
        a.bytes[at++] = (unsigned char)(bits >> 16);
        a.bytes[at++] = (unsigned char)(bits >> 8);
        a.bytes[at++] = (unsigned char)bits;
    }
    if (dimensions == 3) {
        a.height = size[0], a.width = size[1], a.channels = size[2];
    } else {
        /* Rows and columns of an image, or points and coordinates of a cloud: the caller knows. */
        a.height = size[0], a.width = size[1];
    }
    return a;
}

/* Rows of a cloud as one row of points. */
static array read_cloud(const run *r, const cJSON *name)
{
    array a = read_array(r, name);
    if (a.channels == 1) {
        a.channels = a.width, a.width = a.height, a.height = 1;
    }
    return a;
}

static void print_numbers(const run *r, const char *field, const double *values, size_t count)
{
    printf("%s\t%d\t%s\t", r->name, r->index, field);
    for (size_t k = 0; k < count; k++) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        if (k) putchar(' ');
        if (isnan(values[k])) fputs("nan", stdout);
        else printf("%016" PRIx64, bits);
    }
    putchar('\n');
}

static void print_number(const run *r, const char *field, double value)
{
    print_numbers(r, field, &value, 1);
}

#define PRINT(r, s, field) print_number(r, #field, (double)(s).field)
#define PRINT_LIST(r, s, field) print_numbers(r, #field, (s).field, sizeof (s).field / sizeof (s).field[0])

/* Prints the outcome of a call; returns whether it succeeded. */
static int succeeded(const run *r, cylfuse_status status, int has_message)
{
    if (status == CYLFUSE_STATUS_OK) {
        printf("%s\t%d\tok\n", r->name, r->index);
        return 1;
    }
    const char *text = cylfuse_status_string(status), *colon = strchr(text, ':');
    printf("%s\t%d\terror\t%.*s\t%s\n", r->name, r->index, colon ? (int)(colon - text) : 0, text,
           has_message ? cylfuse_fitter_last_error(r->fitter) : "");
    return 0;
}

static void print_model(const run *r, const char *name, const cylfuse_cylinder *model)
{
    char field[64];
    snprintf(field, sizeof field, "%s.point", name);
    print_numbers(r, field, model->point, 3);
    snprintf(field, sizeof field, "%s.direction", name);
    print_numbers(r, field, model->direction, 3);
    snprintf(field, sizeof field, "%s.radius", name);
    print_number(r, field, model->radius);
}

static void print_result(const run *r, const cylfuse_result *result)
{
    PRINT(r, *result, termination);
    PRINT(r, *result, start_kind);
    PRINT(r, *result, flags);
    PRINT(r, *result, iterations);
    PRINT(r, *result, rejected_steps);
    PRINT(r, *result, segments_used);
    PRINT(r, *result, segments_given);
    PRINT(r, *result, points_used);
    PRINT(r, *result, points_given);
    print_model(r, "model", &result->model);
    print_model(r, "start_model", &result->start_model);
    PRINT(r, *result, initial_cost);
    PRINT(r, *result, cost);
    PRINT(r, *result, energy_points);
    PRINT(r, *result, energy_edges);
    PRINT(r, *result, edge_weight);
    PRINT(r, *result, point_rms);
    PRINT(r, *result, edge_rms_pixels);
    PRINT(r, *result, near_wall_fraction);
    PRINT(r, *result, condition);
    PRINT(r, *result, lambda);
    PRINT(r, *result, gradient_norm);
    PRINT(r, *result, step_norm);
    PRINT(r, *result, radius_deviation);
    PRINT(r, *result, direction_deviation);
    PRINT(r, *result, position_deviation);
    PRINT(r, *result, radius_from_points);
    PRINT(r, *result, radius_from_points_deviation);
    PRINT(r, *result, radius_from_limbs);
    PRINT(r, *result, radius_from_limbs_deviation);
    PRINT(r, *result, radius_z_score);
    PRINT_LIST(r, *result, covariance);
    PRINT(r, *result, limbs_located);
}

static void print_options(const run *r, const cylfuse_options *options)
{
    PRINT(r, *options, method);
    PRINT(r, *options, objective);
    PRINT(r, *options, start);
    PRINT(r, *options, near_wall);
    PRINT(r, *options, chart);
    PRINT(r, *options, max_iterations);
    PRINT(r, *options, max_threads);
    PRINT(r, *options, edge_weight);
    PRINT(r, *options, initial_lambda);
    PRINT(r, *options, lambda_factor);
    PRINT(r, *options, max_lambda);
    PRINT(r, *options, cost_tolerance);
    PRINT(r, *options, ransac_threshold);
    PRINT(r, *options, seed);
    PRINT(r, *options, ransac_max_iterations);
    PRINT(r, *options, edge_use);
    PRINT(r, *options, extent_rule);
    PRINT(r, *options, radius_min);
    PRINT(r, *options, radius_max);
    PRINT_LIST(r, *options, axis);
    PRINT(r, *options, axis_max_angle);
}

static cylfuse_options read_options(const cJSON *given)
{
    static const char *const methods[] = {"FUSED", "POINTS", "RANSAC", "EBERLY", NULL};
    static const char *const objectives[] = {"ROBUST", "PAPER", NULL};
    static const char *const starts[] = {"AUTO", "LIMBS", "MOMENTS", "RANSAC", "MODEL", NULL};
    static const char *const near_walls[] = {"AUTO", "ON", "OFF", NULL};
    static const char *const charts[] = {"AUTO", "LOCAL", "ORTHONORMAL", NULL};
    static const char *const edge_uses[] = {"REFINE", "AS_GIVEN", NULL};
    static const char *const extent_rules[] = {"AUTO", "EXTREMES", "LOCATED", NULL};
    cylfuse_options options;
    cylfuse_options_init(&options, sizeof options);
    for (const cJSON *value = given->child; value; value = value->next) {
        const char *key = value->string;
#define NAME(field, names) if (strcmp(key, #field) == 0) options.field = named(value, names); else
#define NUMBER(field) if (strcmp(key, #field) == 0) options.field = number(value); else
#define COUNT(field) if (strcmp(key, #field) == 0) options.field = (uint32_t)number(value); else
        NAME(method, methods) NAME(objective, objectives) NAME(start, starts) NAME(near_wall, near_walls)
        NAME(chart, charts) NAME(edge_use, edge_uses) NAME(extent_rule, extent_rules)
        COUNT(max_iterations) COUNT(max_threads) COUNT(ransac_max_iterations)
        NUMBER(edge_weight) NUMBER(initial_lambda) NUMBER(lambda_factor) NUMBER(max_lambda)
        NUMBER(cost_tolerance) NUMBER(ransac_threshold) NUMBER(radius_min) NUMBER(radius_max)
        NUMBER(axis_max_angle)
        if (strcmp(key, "seed") == 0) options.seed = (uint64_t)number(value);
        else if (strcmp(key, "axis") == 0) numbers(value, options.axis, 3);
        else stop("unknown option", key);
    }
    return options;
}

static cylfuse_intrinsics read_camera(const run *r)
{
    static const char *const models[] = {"NONE", "BROWN_CONRADY", "KANNALA_BRANDT", NULL};
    const cJSON *given = need(need(r->file, "cameras"), need(r->step, "camera")->valuestring);
    cylfuse_intrinsics camera;
    cylfuse_intrinsics_init(&camera, sizeof camera);
    camera.distortion_model = named(need(given, "distortion_model"), models);
    camera.width = (uint32_t)number(need(given, "width"));
    camera.height = (uint32_t)number(need(given, "height"));
    camera.fx = number(need(given, "fx"));
    camera.fy = number(need(given, "fy"));
    camera.cx = number(need(given, "cx"));
    camera.cy = number(need(given, "cy"));
    numbers(need(given, "distortion"), camera.distortion, 8);
    return camera;
}

/* The model under a key; NULL when there is none. */
static const cylfuse_cylinder *read_model(const run *r, const char *key, cylfuse_cylinder *model)
{
    const cJSON *given = get(r->step, key);
    if (!cJSON_IsObject(given)) return NULL;
    numbers(need(given, "point"), model->point, 3);
    numbers(need(given, "direction"), model->direction, 3);
    model->radius = number(need(given, "radius"));
    return model;
}

/* The mask of the step; NULL when there is none. The pixels are kept until the end of the program. */
static const cylfuse_mask_view *read_mask(const run *r, cylfuse_mask_view *view)
{
    const cJSON *name = get(r->step, "mask");
    if (!name) return NULL;
    array mask = read_array(r, name);
    cylfuse_mask_view_init(view, sizeof *view);
    view->data = mask.bytes;
    view->width = (uint32_t)mask.width;
    view->height = (uint32_t)mask.height;
    return view;
}

/* Address and strides of the columns from `column` on. */
static const void *columns(const run *r, const cJSON *given, ptrdiff_t *stride, ptrdiff_t *row_stride)
{
    array a = read_cloud(r, need(given, "array"));
    *stride = (ptrdiff_t)(a.channels * a.element_size);
    *row_stride = (ptrdiff_t)a.width * *stride;
    return a.bytes + (size_t)number_or(given, "column", 0.0) * a.element_size;
}

static cylfuse_points_view read_points(const run *r)
{
    const cJSON *given = need(r->step, "points"), *weights = get(given, "weights"), *normals = get(given, "normals");
    array a = read_cloud(r, need(given, "array"));
    cylfuse_points_view view;
    cylfuse_points_view_init(&view, sizeof view);
    view.scalar = strcmp(a.type, "f32") == 0 ? CYLFUSE_SCALAR_F32 : CYLFUSE_SCALAR_F64;
    view.width = a.width;
    view.height = a.height;
    view.data = columns(r, given, &view.point_stride, &view.row_stride);
    if (weights) view.weights = columns(r, weights, &view.weight_stride, &view.weight_row_stride);
    if (normals) view.normals = columns(r, normals, &view.normal_stride, &view.normal_row_stride);
    return view;
}

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
    const cJSON *rows = need(r->step, "segments"), *weights = get(r->step, "weights");
    int count = cJSON_GetArraySize(rows);
    double *values = allocate((size_t)count * 4 * sizeof *values), *weight = allocate((size_t)count * sizeof *weight);
    for (int k = 0; k < count; k++) numbers(cJSON_GetArrayItem(rows, k), values + 4 * k, 4);
    if (weights) numbers(weights, weight, count);
    cylfuse_segments_view view;
    cylfuse_segments_view_init(&view, sizeof view);
    view.scalar = CYLFUSE_SCALAR_F64;
    view.data = values;
    view.count = (size_t)count;
    view.weights = weights ? weight : NULL;
    cylfuse_status status = cylfuse_fitter_push_edges(r->fitter, &view);
    free(values);
    free(weight);
    return status;
}

static void counts(const run *r)
{
    cylfuse_counts counts = {.struct_size = sizeof counts};
    if (!succeeded(r, cylfuse_fitter_counts(r->fitter, &counts), 1)) return;
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
    if (succeeded(r, status, 1)) print_numbers(r, "residuals", values, count);
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
    if (succeeded(r, status, 1)) {
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
    if (!succeeded(r, cylfuse_fitter_diagnose(r->fitter, read_model(r, "model", &model), &diagnosis), 1)) return;
    PRINT(r, diagnosis, rank);
    PRINT_LIST(r, diagnosis, singular_values);
    PRINT(r, diagnosis, condition);
    PRINT_LIST(r, diagnosis, weakest_shift);
    PRINT_LIST(r, diagnosis, weakest_tilt);
    PRINT(r, diagnosis, weakest_radius);
}

static void print_completion(const run *r, const cylfuse_completion *completion)
{
    PRINT(r, *completion, count);
    PRINT(r, *completion, hits);
    PRINT(r, *completion, misses);
    PRINT(r, *completion, outside_camera);
    PRINT(r, *completion, out_of_range);
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
    if (succeeded(r, status, 1)) {
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
    if (succeeded(r, cylfuse_fitter_complete_depth(r->fitter, given, region, &out, &completion), 1)) {
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
    if (!succeeded(r, cylfuse_fitter_extent(r->fitter, given, read_mask(r, &mask), &extent), 1)) return;
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
    if (succeeded(r, status, 0)) print_numbers(r, "distances", values, count);
    free(values);
}

static void project(const run *r)
{
    cylfuse_cylinder model;
    cylfuse_intrinsics camera = read_camera(r);
    double lines[6];
    if (succeeded(r, cylfuse_cylinder_project(read_model(r, "model", &model), &camera, lines), 0)) {
        print_numbers(r, "lines", lines, 6);
    }
}

static void compare(const run *r)
{
    cylfuse_cylinder a, b;
    double angle, axis_distance, radius_relative;
    cylfuse_status status = cylfuse_cylinder_compare(read_model(r, "a", &a), read_model(r, "b", &b), &angle,
                                                     &axis_distance, &radius_relative);
    if (!succeeded(r, status, 0)) return;
    print_number(r, "angle", angle);
    print_number(r, "axis_distance", axis_distance);
    print_number(r, "radius_relative", radius_relative);
}

static void set_options(const run *r)
{
    cylfuse_options options = read_options(need(r->step, "options"));
    succeeded(r, cylfuse_fitter_set_options(r->fitter, &options), 1);
}

static void get_options(const run *r)
{
    cylfuse_options options = {.struct_size = sizeof options};
    if (succeeded(r, cylfuse_fitter_get_options(r->fitter, &options), 1)) print_options(r, &options);
}

static void run_step(const run *r)
{
    const char *call = need(r->step, "call")->valuestring;
    cylfuse_cylinder model;
    cylfuse_result result = {.struct_size = sizeof result};
#define CALL(name) else if (strcmp(call, #name) == 0)
    if (strcmp(call, "set_intrinsics") == 0) {
        cylfuse_intrinsics camera = read_camera(r);
        succeeded(r, cylfuse_fitter_set_intrinsics(r->fitter, &camera), 1);
    }
    CALL(set_options) set_options(r);
    CALL(get_options) get_options(r);
    CALL(set_start_model)
    {
        succeeded(r, cylfuse_fitter_set_start_model(r->fitter, read_model(r, "model", &model)), 1);
    }
    CALL(reserve)
    {
        size_t points = (size_t)number(need(r->step, "points")), segments = (size_t)number(need(r->step, "segments"));
        succeeded(r, cylfuse_fitter_reserve(r->fitter, points, segments), 1);
    }
    CALL(clear) succeeded(r, cylfuse_fitter_clear(r->fitter), 1);
    CALL(cancel) succeeded(r, cylfuse_fitter_cancel(r->fitter), 1);
    CALL(push_points) succeeded(r, push_points(r), 1);
    CALL(push_depth) succeeded(r, push_depth(r), 1);
    CALL(push_image) succeeded(r, push_image(r), 1);
    CALL(push_edges) succeeded(r, push_edges(r), 1);
    CALL(counts) counts(r);
    CALL(fit)
    {
        if (succeeded(r, cylfuse_fitter_fit(r->fitter, &result), 1)) print_result(r, &result);
    }
    CALL(get_result)
    {
        if (succeeded(r, cylfuse_fitter_get_result(r->fitter, &result), 1)) print_result(r, &result);
    }
    CALL(evaluate)
    {
        cylfuse_status status = cylfuse_fitter_evaluate(r->fitter, read_model(r, "model", &model), &result);
        if (succeeded(r, status, 1)) print_result(r, &result);
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

/* Reads the arguments of a step. */
#include "runner.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void stop(const char *what, const char *name)
{
    fprintf(stderr, "%s: %s\n", what, name ? name : "");
    exit(2);
}

void *allocate(size_t size)
{
    void *memory = calloc(size ? size : 1, 1);
    if (!memory) stop("out of memory", NULL);
    return memory;
}

static const cJSON *get(const cJSON *object, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

const cJSON *need(const cJSON *object, const char *key)
{
    const cJSON *value = get(object, key);
    if (!value) stop("the file lacks", key);
    return value;
}

double number(const cJSON *value)
{
    return cJSON_IsNumber(value) ? value->valuedouble : NAN;
}

double number_or(const cJSON *object, const char *key, double otherwise)
{
    const cJSON *value = get(object, key);
    return value ? number(value) : otherwise;
}

void numbers(const cJSON *list, double *out, int count)
{
    for (int k = 0; k < count; k++) out[k] = number(cJSON_GetArrayItem(list, k));
}

int32_t named(const cJSON *text, const char *const *names)
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

array read_array(const run *r, const cJSON *name)
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

cylfuse_options read_options(const cJSON *given)
{
    static const char *const methods[] = {"FUSED", "POINTS", "RANSAC", "EBERLY", NULL};
    static const char *const objectives[] = {"ROBUST", "PAPER", NULL};
    static const char *const starts[] = {"AUTO", "LIMBS", "MOMENTS", "RANSAC", "MODEL", "LAST", NULL};
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
        COUNT(max_iterations) COUNT(max_threads)
        NUMBER(edge_weight) NUMBER(initial_lambda) NUMBER(lambda_factor) NUMBER(max_lambda)
        NUMBER(cost_tolerance) NUMBER(ransac_threshold) NUMBER(radius_min) NUMBER(radius_max)
        NUMBER(gradient_tolerance) NUMBER(step_tolerance) NUMBER(independent_points) NUMBER(depth_noise)
        NUMBER(image_noise) NUMBER(edge_noise) NUMBER(mask_noise) NUMBER(image_blur)
        NUMBER(drawn_pixel) NUMBER(axis_max_angle) NUMBER(depth_shared)
        if (strcmp(key, "seed") == 0) options.seed = (uint64_t)number(value);
        else if (strcmp(key, "ransac_max_iterations") == 0) options.ransac_max_iterations = (uint64_t)number(value);
        else if (strcmp(key, "axis") == 0) numbers(value, options.axis, 3);
        else stop("unknown option", key);
    }
    return options;
}

cylfuse_intrinsics read_camera(const run *r)
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

const cylfuse_cylinder *read_model(const run *r, const char *key, cylfuse_cylinder *model)
{
    const cJSON *given = get(r->step, key);
    if (!cJSON_IsObject(given)) return NULL;
    numbers(need(given, "point"), model->point, 3);
    numbers(need(given, "direction"), model->direction, 3);
    model->radius = number(need(given, "radius"));
    return model;
}

const cylfuse_mask_view *read_mask(const run *r, cylfuse_mask_view *view)
{
    const cJSON *name = get(r->step, "mask");
    if (!name) return NULL;
    array mask = read_array(r, name);
    cylfuse_mask_view_init(view, sizeof *view);
    view->data = mask.bytes;
    view->width = (uint32_t)mask.width;
    view->height = (uint32_t)mask.height;
    view->label = (uint32_t)number_or(r->step, "label", 0.0);
    return view;
}

cylfuse_depth_view read_depth(const run *r)
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
    return view;
}

cylfuse_image_view read_image(const run *r)
{
    static const char *const formats[] = {"", "U8", "U16", "F32", "RGB8", "BGR8", "RGBA8", "BGRA8", NULL};
    const cJSON *format = get(r->step, "format");
    array image = read_array(r, need(r->step, "image"));
    cylfuse_image_view view;
    cylfuse_image_view_init(&view, sizeof view);
    if (format) view.format = named(format, formats);
    else if (image.channels == 3) view.format = CYLFUSE_IMAGE_FORMAT_RGB8;
    else if (image.channels == 4) view.format = CYLFUSE_IMAGE_FORMAT_RGBA8;
    else if (image.element_size == 1) view.format = CYLFUSE_IMAGE_FORMAT_U8;
    else view.format = image.element_size == 2 ? CYLFUSE_IMAGE_FORMAT_U16 : CYLFUSE_IMAGE_FORMAT_F32;
    view.data = image.bytes;
    view.width = (uint32_t)image.width;
    view.height = (uint32_t)image.height;
    view.gamma = number_or(r->step, "gamma", view.gamma);
    return view;
}

void read_pose(const run *r, double *rotation, double *translation)
{
    const cJSON *pose = need(r->step, "pose");
    numbers(need(pose, "rotation"), rotation, 9);
    numbers(need(pose, "translation"), translation, 3);
}

/* Address and strides of the columns from `column` on. */
static const void *columns(const run *r, const cJSON *given, ptrdiff_t *stride, ptrdiff_t *row_stride)
{
    array a = read_cloud(r, need(given, "array"));
    *stride = (ptrdiff_t)(a.channels * a.element_size);
    *row_stride = (ptrdiff_t)a.width * *stride;
    return a.bytes + (size_t)number_or(given, "column", 0.0) * a.element_size;
}

cylfuse_points_view read_points(const run *r)
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

cylfuse_segments_view read_segments(const run *r)
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
    return view;
}

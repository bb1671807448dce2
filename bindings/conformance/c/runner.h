/* What the parts of the runner of the golden cases share. */
#ifndef RUNNER_H
#define RUNNER_H

#include <cjson/cJSON.h>
#include <cylfuse/cylfuse.h>

#include <stddef.h>
#include <stdint.h>

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
    cylfuse_frame *frame;
    cylfuse_detector *detector;
} run;

/* Ends the program: the file is not as described. */
void stop(const char *what, const char *name);
void *allocate(size_t size);

const cJSON *need(const cJSON *object, const char *key);
/* A number; null stands for NaN. */
double number(const cJSON *value);
double number_or(const cJSON *object, const char *key, double otherwise);
void numbers(const cJSON *list, double *out, int count);
/* The position of a text in a list that ends with NULL. */
int32_t named(const cJSON *text, const char *const *names);

/* The arguments of a step. What they point to is kept until the end of the program. */
array read_array(const run *r, const cJSON *name);
cylfuse_options read_options(const cJSON *given);
cylfuse_intrinsics read_camera(const run *r);
/* The model under a key; NULL when there is none. */
const cylfuse_cylinder *read_model(const run *r, const char *key, cylfuse_cylinder *model);
/* The mask of the step; NULL when there is none. */
const cylfuse_mask_view *read_mask(const run *r, cylfuse_mask_view *view);
cylfuse_points_view read_points(const run *r);
cylfuse_depth_view read_depth(const run *r);
cylfuse_image_view read_image(const run *r);
/* The rotation, row by row, and the translation of the step. */
void read_pose(const run *r, double *rotation, double *translation);
cylfuse_segments_view read_segments(const run *r);

void print_numbers(const run *r, const char *field, const double *values, size_t count);
void print_number(const run *r, const char *field, double value);
#define PRINT(r, s, field) print_number(r, #field, (double)(s).field)
#define PRINT_LIST(r, s, field) print_numbers(r, #field, (s).field, sizeof (s).field / sizeof (s).field[0])

/* The same field of all elements of an array, one after the other. */
#define PRINT_COLUMN(r, items, count, field) PRINT_COLUMNS(r, items, count, #field, 1, field)
#define PRINT_VECTORS(r, items, count, field)                                                                          \
    PRINT_COLUMNS(r, items, count, #field, sizeof (items)->field / sizeof *(items)->field, field[k % width])
#define PRINT_COLUMNS(r, items, count, name, columns, value)                                                           \
    do {                                                                                                               \
        const size_t width = (columns), all = (count) * width;                                                         \
        double *values = allocate(all * sizeof *values);                                                               \
        for (size_t k = 0; k < all; k++) values[k] = (items)[k / width].value;                                         \
        print_numbers(r, name, values, all);                                                                           \
        free(values);                                                                                                  \
    } while (0)

/* Prints the outcome of a call on a fitter, or without one; returns whether it succeeded. */
int succeeded(const run *r, cylfuse_status status, const cylfuse_fitter *fitter);
int succeeded_on_frame(const run *r, cylfuse_status status);
int succeeded_on_detector(const run *r, cylfuse_status status);
void print_result(const run *r, const cylfuse_result *result);
void print_estimate(const run *r, const cylfuse_cylinder_estimate *estimate);
void print_extent(const run *r, const cylfuse_extent *extent);
void print_counts(const run *r, const cylfuse_counts *counts);
void print_diagnosis(const run *r, const cylfuse_cylinder_diagnosis *diagnosis);
void print_options(const run *r, const cylfuse_options *options);
void print_completion(const run *r, const cylfuse_completion *completion);

cylfuse_status new_detector(run *r);
/* Runs a call on the detector; returns whether it is one. */
int run_on_detector(run *r, const char *call);

/* Calls that list something. */
void residuals(const run *r);
void point_weights(const run *r);
void point_parts(const run *r);
void limbs(const run *r);
void limb_samples(const run *r);
void end_samples(const run *r);

#endif

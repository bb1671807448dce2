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
} run;

/* Ends the program: the file is not as described. */
void stop(const char *what, const char *name);
void *allocate(size_t size);

const cJSON *need(const cJSON *object, const char *key);
/* A number; null stands for NaN. */
double number(const cJSON *value);
double number_or(const cJSON *object, const char *key, double otherwise);
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
cylfuse_segments_view read_segments(const run *r);

void print_numbers(const run *r, const char *field, const double *values, size_t count);
void print_number(const run *r, const char *field, double value);
#define PRINT(r, s, field) print_number(r, #field, (double)(s).field)
#define PRINT_LIST(r, s, field) print_numbers(r, #field, (s).field, sizeof (s).field / sizeof (s).field[0])

/* Prints the outcome of a call on a fitter, or without one; returns whether it succeeded. */
int succeeded(const run *r, cylfuse_status status, const cylfuse_fitter *fitter);
void print_result(const run *r, const cylfuse_result *result);
void print_options(const run *r, const cylfuse_options *options);
void print_completion(const run *r, const cylfuse_completion *completion);

#endif

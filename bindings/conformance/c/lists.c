/* The calls that list something: how many there are is asked first. */
#include "runner.h"

#include <stdlib.h>

void residuals(const run *r)
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

void point_weights(const run *r)
{
    size_t count = 0;
    cylfuse_status status = cylfuse_fitter_point_weights(r->fitter, NULL, NULL, 0, &count);
    double *weights = allocate(count * sizeof *weights), *values = allocate(count * sizeof *values);
    uint8_t *inliers = allocate(count);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_fitter_point_weights(r->fitter, weights, inliers, count, &count);
    }
    if (succeeded(r, status, r->fitter)) {
        for (size_t k = 0; k < count; k++) values[k] = inliers[k];
        print_numbers(r, "weights", weights, count);
        print_numbers(r, "inliers", values, count);
    }
    free(weights);
    free(values);
    free(inliers);
}

void point_parts(const run *r)
{
    cylfuse_cylinder model;
    const cylfuse_cylinder *given = read_model(r, "model", &model);
    size_t count = 0;
    cylfuse_status status = cylfuse_fitter_point_parts(r->fitter, given, NULL, 0, &count);
    cylfuse_part *parts = allocate(count * sizeof *parts);
    double *values = allocate(count * sizeof *values);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_fitter_point_parts(r->fitter, given, parts, count, &count);
    }
    if (succeeded(r, status, r->fitter)) {
        for (size_t k = 0; k < count; k++) values[k] = parts[k];
        print_numbers(r, "parts", values, count);
    }
    free(parts);
    free(values);
}

void limbs(const run *r)
{
    size_t count = 0;
    cylfuse_status status = cylfuse_fitter_limbs(r->fitter, NULL, sizeof(cylfuse_limb), 0, &count);
    cylfuse_limb *found = allocate(count * sizeof *found);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_fitter_limbs(r->fitter, found, sizeof *found, count, &count);
    }
    if (succeeded(r, status, r->fitter)) {
        PRINT_COLUMN(r, found, count, view);
        PRINT_COLUMN(r, found, count, limb);
        PRINT_COLUMN(r, found, count, status);
        PRINT_COLUMN(r, found, count, samples);
        PRINT_VECTORS(r, found, count, line);
        PRINT_COLUMN(r, found, count, deviation);
    }
    free(found);
}

void limb_samples(const run *r)
{
    size_t count = 0;
    cylfuse_status status = cylfuse_fitter_limb_samples(r->fitter, NULL, sizeof(cylfuse_limb_sample), 0, &count);
    cylfuse_limb_sample *samples = allocate(count * sizeof *samples);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_fitter_limb_samples(r->fitter, samples, sizeof *samples, count, &count);
    }
    if (succeeded(r, status, r->fitter)) {
        PRINT_COLUMN(r, samples, count, view);
        PRINT_COLUMN(r, samples, count, limb);
        PRINT_VECTORS(r, samples, count, pixel);
        PRINT_COLUMN(r, samples, count, deviation);
        PRINT_COLUMN(r, samples, count, weight);
    }
    free(samples);
}

void end_samples(const run *r)
{
    cylfuse_cylinder model;
    cylfuse_mask_view mask;
    const cylfuse_cylinder *given = read_model(r, "model", &model);
    const cylfuse_mask_view *region = read_mask(r, &mask);
    size_t count = 0;
    cylfuse_status status =
        cylfuse_fitter_end_samples(r->fitter, given, region, NULL, sizeof(cylfuse_end_sample), 0, &count);
    cylfuse_end_sample *samples = allocate(count * sizeof *samples);
    if (status == CYLFUSE_STATUS_BUFFER_TOO_SMALL) {
        status = cylfuse_fitter_end_samples(r->fitter, given, region, samples, sizeof *samples, count, &count);
    }
    if (succeeded(r, status, r->fitter)) {
        PRINT_COLUMN(r, samples, count, view);
        PRINT_COLUMN(r, samples, count, end);
        PRINT_VECTORS(r, samples, count, pixel);
        PRINT_VECTORS(r, samples, count, normal);
        PRINT_COLUMN(r, samples, count, deviation);
    }
    free(samples);
}

/* Prints what a step gave, as bits. */
#include "runner.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

void print_numbers(const run *r, const char *field, const double *values, size_t count)
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

void print_number(const run *r, const char *field, double value)
{
    print_numbers(r, field, &value, 1);
}


int succeeded(const run *r, cylfuse_status status, const cylfuse_fitter *fitter)
{
    if (status == CYLFUSE_STATUS_OK) {
        printf("%s\t%d\tok\n", r->name, r->index);
        return 1;
    }
    const char *text = cylfuse_status_string(status), *colon = strchr(text, ':');
    printf("%s\t%d\terror\t%.*s\t%s\n", r->name, r->index, colon ? (int)(colon - text) : 0, text,
           cylfuse_fitter_last_error(fitter));
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

void print_result(const run *r, const cylfuse_result *result)
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

void print_options(const run *r, const cylfuse_options *options)
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

void print_completion(const run *r, const cylfuse_completion *completion)
{
    PRINT(r, *completion, count);
    PRINT(r, *completion, hits);
    PRINT(r, *completion, misses);
    PRINT(r, *completion, outside_camera);
    PRINT(r, *completion, out_of_range);
}

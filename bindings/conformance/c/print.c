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

static int report(const run *r, cylfuse_status status, const char *error)
{
    if (status == CYLFUSE_STATUS_OK) {
        printf("%s\t%d\tok\n", r->name, r->index);
        return 1;
    }
    const char *text = cylfuse_status_string(status), *colon = strchr(text, ':');
    printf("%s\t%d\terror\t%.*s\t%s\n", r->name, r->index, colon ? (int)(colon - text) : 0, text, error);
    return 0;
}

int succeeded(const run *r, cylfuse_status status, const cylfuse_fitter *fitter)
{
    return report(r, status, cylfuse_fitter_last_error(fitter));
}

int succeeded_on_frame(const run *r, cylfuse_status status)
{
    return report(r, status, cylfuse_frame_last_error(r->frame));
}

int succeeded_on_detector(const run *r, cylfuse_status status)
{
    return report(r, status, cylfuse_detector_last_error(r->detector));
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
    PRINT(r, *result, flags);
    PRINT(r, *result, termination);
    PRINT(r, *result, iterations);
    PRINT(r, *result, rejected_steps);
    PRINT(r, *result, limbs_located);
    PRINT(r, *result, segments_given);
    PRINT(r, *result, segments_used);
    PRINT(r, *result, points_given);
    PRINT(r, *result, points_used);
    PRINT(r, *result, independent_points);
    PRINT(r, *result, point_deviation);
    PRINT(r, *result, point_rms);
    PRINT(r, *result, edge_rms_pixels);
    PRINT(r, *result, near_wall_fraction);
    PRINT(r, *result, initial_cost);
    PRINT(r, *result, cost);
    PRINT(r, *result, energy_points);
    PRINT(r, *result, energy_edges);
    PRINT(r, *result, edge_weight);
    PRINT(r, *result, condition);
    PRINT(r, *result, gradient_norm);
    PRINT(r, *result, step_norm);
    PRINT(r, *result, lambda);
}

void print_estimate(const run *r, const cylfuse_cylinder_estimate *estimate)
{
    PRINT(r, *estimate, start_kind);
    print_model(r, "model", &estimate->model);
    print_model(r, "start_model", &estimate->start_model);
    PRINT(r, *estimate, radius_deviation);
    PRINT(r, *estimate, direction_deviation);
    PRINT(r, *estimate, position_deviation);
    PRINT(r, *estimate, radius_from_points);
    PRINT(r, *estimate, radius_from_points_deviation);
    PRINT(r, *estimate, radius_from_limbs);
    PRINT(r, *estimate, radius_from_limbs_deviation);
    PRINT(r, *estimate, radius_z_score);
    PRINT_LIST(r, *estimate, covariance);
}

void print_options(const run *r, const cylfuse_options *options)
{
    PRINT(r, *options, method);
    PRINT(r, *options, objective);
    PRINT(r, *options, start);
    PRINT(r, *options, near_wall);
    PRINT(r, *options, chart);
    PRINT(r, *options, edge_use);
    PRINT(r, *options, extent_rule);
    PRINT(r, *options, max_threads);
    PRINT(r, *options, max_iterations);
    PRINT(r, *options, cost_tolerance);
    PRINT(r, *options, gradient_tolerance);
    PRINT(r, *options, step_tolerance);
    PRINT(r, *options, initial_lambda);
    PRINT(r, *options, lambda_factor);
    PRINT(r, *options, max_lambda);
    PRINT(r, *options, edge_weight);
    PRINT(r, *options, seed);
    PRINT(r, *options, ransac_max_iterations);
    PRINT(r, *options, ransac_threshold);
    PRINT(r, *options, independent_points);
    PRINT(r, *options, depth_noise);
    PRINT(r, *options, image_noise);
    PRINT(r, *options, edge_noise);
    PRINT(r, *options, mask_noise);
    PRINT(r, *options, image_blur);
    PRINT(r, *options, drawn_pixel);
    PRINT(r, *options, radius_min);
    PRINT(r, *options, radius_max);
    PRINT_LIST(r, *options, axis);
    PRINT(r, *options, axis_max_angle);
    PRINT(r, *options, depth_shared);
}

void print_completion(const run *r, const cylfuse_completion *completion)
{
    PRINT(r, *completion, view);
    PRINT(r, *completion, count);
    PRINT(r, *completion, hits);
    PRINT(r, *completion, misses);
    PRINT(r, *completion, outside_camera);
    PRINT(r, *completion, out_of_range);
}

void print_counts(const run *r, const cylfuse_counts *counts)
{
    PRINT(r, *counts, view);
    PRINT(r, *counts, points_given);
    PRINT(r, *counts, points_used);
    PRINT(r, *counts, dropped_not_finite);
    PRINT(r, *counts, dropped_zero_weight);
    PRINT(r, *counts, dropped_outside_mask);
    PRINT(r, *counts, dropped_no_depth);
    PRINT(r, *counts, dropped_out_of_range);
    PRINT(r, *counts, dropped_outside_camera);
    PRINT(r, *counts, dropped_hidden);
    PRINT(r, *counts, segments_given);
}

void print_extent(const run *r, const cylfuse_extent *extent)
{
    PRINT(r, *extent, start_state);
    PRINT(r, *extent, end_state);
    PRINT(r, *extent, start_source);
    PRINT(r, *extent, end_source);
    PRINT(r, *extent, start_view);
    PRINT(r, *extent, end_view);
    PRINT(r, *extent, limbs_known);
    PRINT_LIST(r, *extent, start);
    PRINT_LIST(r, *extent, end);
    PRINT_LIST(r, *extent, center);
    PRINT(r, *extent, length);
    PRINT(r, *extent, start_deviation);
    PRINT(r, *extent, end_deviation);
    PRINT(r, *extent, length_deviation);
    PRINT_LIST(r, *extent, start_covariance);
    PRINT_LIST(r, *extent, end_covariance);
    PRINT_LIST(r, *extent, center_covariance);
}

void print_diagnosis(const run *r, const cylfuse_cylinder_diagnosis *diagnosis)
{
    PRINT(r, *diagnosis, rank);
    PRINT_LIST(r, *diagnosis, singular_values);
    PRINT(r, *diagnosis, condition);
    PRINT_LIST(r, *diagnosis, weakest_shift);
    PRINT_LIST(r, *diagnosis, weakest_tilt);
    PRINT(r, *diagnosis, weakest_radius);
}

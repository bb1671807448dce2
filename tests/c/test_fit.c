/* Fits, options, what is asked about a result, and calls in the wrong order. */
#include "check.h"

void test_order_of_calls(void)
{
    cylfuse_fitter *fitter = new_fitter();
    cylfuse_result result = {.struct_size = sizeof result};
    cylfuse_cylinder_diagnosis diagnosis = {.struct_size = sizeof diagnosis};
    cylfuse_completion completion = {.struct_size = sizeof completion};
    cylfuse_extent extent = {.struct_size = sizeof extent};
    cylfuse_points_out out;
    CHECK_OK(cylfuse_points_out_init(&out, sizeof out));
    out.scalar = CYLFUSE_SCALAR_F32;
    cylfuse_depth_out depth_out;
    CHECK_OK(cylfuse_depth_out_init(&depth_out, sizeof depth_out));
    depth_out.format = CYLFUSE_DEPTH_FORMAT_F32;
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    size_t count;
    double values[2];

    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &result, NULL), TOO_FEW_POINTS, "0 of 0 points");
    CHECK_ERROR(fitter, cylfuse_fitter_get_result(fitter, &result), BAD_STATE, "fit first");
    CHECK_ERROR(fitter, cylfuse_fitter_evaluate(fitter, &the_scene.truth, &result, NULL), TOO_FEW_POINTS, "0 of 0");
    CHECK_ERROR(fitter, cylfuse_fitter_residuals(fitter, NULL, CYLFUSE_RESIDUAL_KIND_POINTS, values, 2, &count),
                BAD_STATE, "give one or fit first");
    CHECK_ERROR(fitter, cylfuse_fitter_diagnose(fitter, NULL, &diagnosis), BAD_STATE, "give one or fit first");
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, &mask), BAD_STATE, "set the intrinsics first");
    CHECK_ERROR(fitter, cylfuse_fitter_complete_bound(fitter, &mask, CYLFUSE_LAYOUT_PACKED, &count), BAD_STATE,
                "set the intrinsics first");
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, &the_scene.truth, &mask, CYLFUSE_LAYOUT_PACKED, &out, &completion), BAD_STATE,
                "set the intrinsics first");
    CHECK_OK(cylfuse_fitter_set_intrinsics(fitter, &the_scene.intrinsics));
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, &the_scene.truth, NULL, CYLFUSE_LAYOUT_PACKED, &out, &completion), BAD_STATE,
                "needs a mask");
    CHECK_ERROR(fitter, cylfuse_fitter_complete_depth(fitter, &the_scene.truth, NULL, &depth_out, &completion),
                BAD_STATE, "needs a mask");
    CHECK_ERROR(fitter, cylfuse_fitter_extent(fitter, &the_scene.truth, NULL, &extent), BAD_STATE,
                "needs points or a mask");
    CHECK_ERROR(fitter, cylfuse_fitter_extent(fitter, NULL, &mask, &extent), BAD_STATE, "give one or fit first");
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, NULL, NULL, CYLFUSE_LAYOUT_PACKED, &out, &completion), BAD_STATE,
                "give one or fit first");

    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.start = CYLFUSE_START_MODEL;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &result, NULL), BAD_STATE, "needs a start model");
    CHECK_OK(cylfuse_fitter_set_start_model(fitter, &the_scene.truth));
    CHECK(fits_truth(fitter, 1e-5));
    destroy(fitter);

    /* Edges without a camera. */
    fitter = new_fitter();
    cylfuse_points_view points = scene_points();
    cylfuse_segments_view edges = scene_edges();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &result, NULL), BAD_STATE, "intrinsics to use the edge segments");
    CHECK_OK(cylfuse_fitter_set_intrinsics(fitter, &the_scene.intrinsics));
    CHECK(fits_truth(fitter, 1e-8));
    destroy(fitter);
}

static void a_fit_and_what_it_says(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    cylfuse_result result = fit(fitter);
    cylfuse_cylinder_estimate estimate = cylinder_of(fitter);
    CHECK(is_truth(&estimate.model, 1e-9));
    CHECK_NEAR(estimate.model.radius, 0.05, 1e-6 * 0.05);
    CHECK(result.struct_size == sizeof result && result.flags == 0);
    CHECK(estimate.struct_size == sizeof estimate && estimate.start_kind != CYLFUSE_START_AUTO);
    CHECK(result.termination != CYLFUSE_TERMINATION_NONE);
    CHECK(result.points_used == POINTS && result.segments_used == 2);
    CHECK(result.point_rms < 1e-10 && result.edge_rms_pixels < 1e-6 && result.near_wall_fraction == 1.0);
    /* The data are exact: both costs are rounding, far below the square of 1e-10. */
    CHECK(isnan(result.edge_weight) && result.cost <= result.initial_cost + 1e-20);
    CHECK(result.condition > 1.0 && result.condition < 1e4);
    CHECK(result.seconds_total >= result.seconds_solve && result.seconds_total > 0.0);

    /* Beside exact points no limb says anything about the radius. */
    CHECK(estimate.radius_deviation < 1e-9 && isnan(estimate.radius_from_points) && isnan(estimate.radius_z_score));

    cylfuse_result again = {.struct_size = sizeof again};
    CHECK_OK(cylfuse_fitter_get_result(fitter, &again));
    CHECK(memcmp(&again, &result, sizeof again) == 0);

    double residuals[POINTS + 1], few[2] = {7.0, 7.0};
    size_t count = 0;
    CHECK_OK(cylfuse_fitter_residuals(fitter, NULL, CYLFUSE_RESIDUAL_KIND_POINTS, residuals, POINTS + 1, &count));
    CHECK(count == POINTS);
    for (size_t k = 0; k < count; k++) {
        CHECK(fabs(residuals[k]) < 1e-9);
    }
    cylfuse_cylinder wider = the_scene.truth;
    wider.radius += 0.01;
    CHECK_OK(cylfuse_fitter_residuals(fitter, &wider, CYLFUSE_RESIDUAL_KIND_POINTS, residuals, POINTS, &count));
    CHECK_NEAR(residuals[0], -0.01, 1e-12);
    CHECK_ERROR(fitter, cylfuse_fitter_residuals(fitter, NULL, CYLFUSE_RESIDUAL_KIND_POINTS, few, 2, &count),
                BUFFER_TOO_SMALL, "out holds 2 but 600 are needed");
    CHECK(count == POINTS && few[0] == 7.0 && few[1] == 7.0);
    count = 0;
    CHECK_STATUS(cylfuse_fitter_residuals(fitter, NULL, CYLFUSE_RESIDUAL_KIND_EDGES, NULL, 0, &count),
                 BUFFER_TOO_SMALL);
    CHECK(count == 4);
    CHECK_OK(cylfuse_fitter_residuals(fitter, NULL, CYLFUSE_RESIDUAL_KIND_EDGES, residuals, 4, &count));
    CHECK(count == 4 && fabs(residuals[0]) < 1e-6);

    cylfuse_cylinder_diagnosis diagnosis = {.struct_size = sizeof diagnosis};
    CHECK_OK(cylfuse_fitter_diagnose(fitter, NULL, &diagnosis));
    CHECK(diagnosis.rank == 5 && diagnosis.singular_values[0] >= diagnosis.singular_values[4]);
    CHECK_NEAR(diagnosis.condition, diagnosis.singular_values[0] / diagnosis.singular_values[4],
               1e-9 * diagnosis.condition);
    const double *tilt = diagnosis.weakest_tilt, *d = estimate.model.direction;
    CHECK_NEAR(tilt[0] * d[0] + tilt[1] * d[1] + tilt[2] * d[2], 0.0, 1e-12);
    CHECK(isfinite(diagnosis.weakest_shift[0]) && isfinite(diagnosis.weakest_radius));

    CHECK_OK(cylfuse_fitter_evaluate(fitter, &wider, &again, NULL));
    CHECK(again.termination == CYLFUSE_TERMINATION_NONE && again.iterations == 0);
    CHECK_NEAR(again.point_rms, 0.01, 1e-9);
    /* Evaluating does not replace the result. */
    CHECK(cylinder_of(fitter).model.radius == estimate.model.radius);
    /* Both parts, or the one that is wanted. */
    cylfuse_cylinder_estimate of_wider;
    CHECK_OK(cylfuse_cylinder_estimate_init(&of_wider, sizeof of_wider));
    CHECK_OK(cylfuse_fitter_evaluate(fitter, &wider, NULL, &of_wider));
    CHECK(of_wider.model.radius == wider.radius && of_wider.start_kind == CYLFUSE_START_MODEL);
    CHECK_OK(cylfuse_fitter_evaluate(fitter, &wider, NULL, NULL));
    CHECK_OK(cylfuse_fitter_fit(fitter, &again, &of_wider));
    CHECK(of_wider.model.radius == estimate.model.radius && again.cost == result.cost);
    destroy(fitter);
}

static void the_uncertainty_of_noisy_points(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    double noisy[POINTS][3];
    for (int k = 0; k < POINTS; k++) {
        double part = 0.002 * ((k * 7919 % 101) / 100.0 - 0.5);
        for (int i = 0; i < 3; i++) {
            noisy[k][i] = the_scene.points[k][i] * (1.0 + part);
        }
    }
    cylfuse_points_view points = scene_points();
    points.data = noisy;
    cylfuse_segments_view edges = scene_edges();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    cylfuse_cylinder_estimate result = fit_cylinder(fitter);
    double deviation = result.radius_deviation;
    CHECK(deviation > 1e-6 && deviation < 1e-3 && fabs(result.model.radius - 0.05) < 4.0 * deviation);
    CHECK(result.direction_deviation > 1e-5 && result.direction_deviation < 1e-2);
    CHECK(result.position_deviation > 1e-6 && result.position_deviation < 2e-3);
    CHECK_NEAR(result.covariance[48], deviation * deviation, 1e-9 * result.covariance[48]);
    for (int i = 0; i < 7; i++) {
        for (int j = 0; j < 7; j++) {
            CHECK(result.covariance[7 * i + j] == result.covariance[7 * j + i]);
        }
    }
    double difference = result.radius_from_points - result.radius_from_limbs;
    CHECK_NEAR(result.radius_z_score,
               difference / hypot(result.radius_from_points_deviation, result.radius_from_limbs_deviation), 1e-9);
    /* Both together know no less than either. The points may share a bend, whatever their noise. */
    CHECK(deviation <= 1.01 * fmin(result.radius_from_points_deviation, result.radius_from_limbs_deviation));
    CHECK(result.radius_from_points_deviation > 1e-6 && result.radius_from_points_deviation < 1e-2);
    cylfuse_result judged = {.struct_size = sizeof judged};
    CHECK_OK(cylfuse_fitter_get_result(fitter, &judged));
    CHECK((judged.flags & CYLFUSE_RESULT_FLAGS_POINTS_AND_LIMBS_DISAGREE) == 0);

    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.method = CYLFUSE_METHOD_RANSAC;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    result = fit_cylinder(fitter);
    CHECK(isnan(result.radius_deviation) && isnan(result.covariance[0]) && isnan(result.covariance[48]));
    destroy(fitter);
}

static void the_objective_of_the_paper(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.objective = CYLFUSE_OBJECTIVE_PAPER;
    options.chart = CYLFUSE_CHART_ORTHONORMAL;
    options.start = CYLFUSE_START_MODEL;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    cylfuse_cylinder start = the_scene.truth;
    start.point[0] += 0.01;
    start.direction[1] += 0.1;
    start.radius *= 1.2;
    CHECK_OK(cylfuse_fitter_set_start_model(fitter, &start));
    cylfuse_result result = fit(fitter);
    cylfuse_cylinder_estimate estimate = cylinder_of(fitter);
    CHECK(is_truth(&estimate.model, 1e-9));
    CHECK(estimate.start_kind == CYLFUSE_START_MODEL && estimate.start_model.radius == start.radius);
    CHECK(result.edge_weight == 0.6 && result.energy_edges >= 0.0);
    CHECK_NEAR(result.cost, 0.4 * result.energy_points + 0.6 * result.energy_edges, 1e-20);

    /* A third segment: the paper has two. */
    cylfuse_segments_view edges = scene_edges();
    edges.count = 1;
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &result, NULL), UNSUPPORTED, "exactly 2 edge segments, not 3");
    cylfuse_result kept = {.struct_size = sizeof kept};
    CHECK_OK(cylfuse_fitter_get_result(fitter, &kept));
    CHECK(memcmp(&kept, &result, sizeof kept) == 0);
    options.edge_weight = 0.0;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    result = fit(fitter);
    CHECK(found_truth(fitter, 1e-9) && result.edge_weight == 0.0 && result.segments_used == 0);
    CHECK(isnan(result.energy_edges));
    destroy(fitter);
}

static void data_that_are_no_cylinder(void)
{
    cylfuse_fitter *fitter = new_fitter();
    double flat[POINTS][3], line[POINTS][3];
    for (int k = 0; k < POINTS; k++) {
        flat[k][0] = 0.01 * (k % 20);
        flat[k][1] = 0.01 * (k / 20);
        flat[k][2] = 1.0;
        line[k][0] = line[k][1] = line[k][2] = 0.01 * k;
    }
    cylfuse_points_view points = scene_points();
    cylfuse_result result = {.struct_size = sizeof result};
    points.data = flat;
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &result, NULL), PLANAR_POINTS, "on a plane");
    CHECK_OK(cylfuse_fitter_clear(fitter));
    points.data = line;
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &result, NULL), COLLINEAR_POINTS, "on one line");
    CHECK_OK(cylfuse_fitter_clear(fitter));
    points = scene_points();
    points.width = 4;
    points.height = 1;
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &result, NULL), TOO_FEW_POINTS, "4 of 4 points");
    points = scene_points();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK(fits_truth(fitter, 1e-8));
    destroy(fitter);
}

static void cameras_that_cannot_be(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    double bad[4] = {0.0, -200.0, NAN, INFINITY};
    for (int k = 0; k < 4; k++) {
        cylfuse_intrinsics intrinsics = the_scene.intrinsics;
        intrinsics.fx = bad[k];
        CHECK_ERROR(fitter, cylfuse_fitter_set_intrinsics(fitter, &intrinsics), INVALID_INTRINSICS, "fx is");
    }
    cylfuse_intrinsics intrinsics = the_scene.intrinsics;
    intrinsics.width = 0;
    CHECK_ERROR(fitter, cylfuse_fitter_set_intrinsics(fitter, &intrinsics), INVALID_INTRINSICS, "width is 0");
    intrinsics = the_scene.intrinsics;
    intrinsics.distortion[0] = 0.1;
    CHECK_ERROR(fitter, cylfuse_fitter_set_intrinsics(fitter, &intrinsics), INVALID_INTRINSICS,
                "distortion[0] is 0.1; it must be 0");
    intrinsics.distortion_model = CYLFUSE_DISTORTION_BROWN_CONRADY;
    CHECK_OK(cylfuse_fitter_set_intrinsics(fitter, &intrinsics));
    intrinsics.distortion[7] = NAN;
    CHECK_ERROR(fitter, cylfuse_fitter_set_intrinsics(fitter, &intrinsics), INVALID_INTRINSICS, "k6 is NaN");
    intrinsics.distortion_model = CYLFUSE_DISTORTION_KANNALA_BRANDT;
    CHECK_ERROR(fitter, cylfuse_fitter_set_intrinsics(fitter, &intrinsics), INVALID_INTRINSICS, "distortion[7]");
    cylfuse_cylinder model = the_scene.truth;
    model.radius = 0.0;
    CHECK_ERROR(fitter, cylfuse_fitter_set_start_model(fitter, &model), INVALID_ARGUMENT, "radius is 0");
    model = the_scene.truth;
    model.direction[0] = model.direction[1] = model.direction[2] = 0.0;
    CHECK_ERROR(fitter, cylfuse_fitter_set_start_model(fitter, &model), INVALID_ARGUMENT, "axis direction");
    destroy(fitter);
}

/* Sums over points are the same to the last bit, whoever adds them up. */
static void any_number_of_threads(void)
{
    enum { MANY = 140000 };
    float (*many)[3] = exactly(sizeof(float[3]) * MANY);
    for (int k = 0; k < MANY; k++) {
        for (int c = 0; c < 3; c++) {
            many[k][c] = (float)(the_scene.points[k % POINTS][c] + 1e-4 * sin(k + c));
        }
    }
    cylfuse_points_view points = scene_points();
    points.scalar = CYLFUSE_SCALAR_F32;
    points.data = many;
    points.width = MANY;
    points.height = 1;
    cylfuse_fitter *fitter = new_fitter();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    free(many);
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.method = CYLFUSE_METHOD_POINTS;
    options.start = CYLFUSE_START_MODEL;
    options.max_iterations = 3;
    CHECK_OK(cylfuse_fitter_set_start_model(fitter, &the_scene.truth));
    cylfuse_result results[2];
    cylfuse_cylinder_estimate estimates[2];
    for (uint32_t k = 0; k < 2; k++) {
        options.max_threads = 1 + 3 * k;
        CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
        results[k] = fit(fitter);
        estimates[k] = cylinder_of(fitter);
    }
    CHECK(memcmp(&estimates[0], &estimates[1], sizeof estimates[0]) == 0);
    CHECK(results[0].cost == results[1].cost && results[0].iterations > 0);
    destroy(fitter);
}

static void limits_are_kept(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.radius_max = 0.049;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    cylfuse_result result = fit(fitter);
    /* The misfit is alike everywhere, so that it says nothing about the noise. */
    cylfuse_result_flags expected = CYLFUSE_RESULT_FLAGS_RADIUS_AT_LIMIT | CYLFUSE_RESULT_FLAGS_UNCERTAINTY_UNKNOWN;
    CHECK(cylinder_of(fitter).model.radius == 0.049 && result.flags == expected);
    options.radius_min = options.radius_max = 0.06;
    options.axis[1] = -2.0;
    options.axis_max_angle = 0.1;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    result = fit(fitter);
    CHECK(cylinder_of(fitter).model.radius == 0.06 && (result.flags & CYLFUSE_RESULT_FLAGS_AXIS_AT_LIMIT) != 0);
    CHECK_NEAR(acos(fabs(cylinder_of(fitter).model.direction[1])), 0.1, 1e-9);
    options.axis_max_angle = 0.0;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    CHECK(fit_cylinder(fitter).model.direction[1] == 1.0);
    options.chart = CYLFUSE_CHART_ORTHONORMAL;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &result, NULL), UNSUPPORTED, "knows no limits of radius or axis");
    destroy(fitter);
}

void test_fit(void)
{
    limits_are_kept();
    any_number_of_threads();
    a_fit_and_what_it_says();
    the_uncertainty_of_noisy_points();
    the_objective_of_the_paper();
    data_that_are_no_cylinder();
    cameras_that_cannot_be();
}

void test_options(void)
{
    cylfuse_fitter *fitter = new_fitter();
    cylfuse_options options = {
        .struct_size = sizeof options,
        .method = CYLFUSE_METHOD_EBERLY,
        .objective = CYLFUSE_OBJECTIVE_PAPER,
        .start = CYLFUSE_START_MOMENTS,
        .near_wall = CYLFUSE_NEAR_WALL_OFF,
        .chart = CYLFUSE_CHART_ORTHONORMAL,
        .edge_use = CYLFUSE_EDGE_USE_AS_GIVEN,
        .extent_rule = CYLFUSE_EXTENT_RULE_EXTREMES,
        .max_threads = 3,
        .max_iterations = 11,
        .cost_tolerance = 1e-6,
        .gradient_tolerance = 1e-7,
        .step_tolerance = 1e-8,
        .initial_lambda = 0.5,
        .lambda_factor = 4.0,
        .max_lambda = 1e6,
        .edge_weight = 0.25,
        .seed = UINT64_MAX,
        .ransac_max_iterations = 99,
        .ransac_threshold = 0.125,
        .independent_points = 55.0,
        .depth_noise = 0.002,
        .image_noise = 3.0,
        .edge_noise = 0.75,
        .mask_noise = 2.5,
        .image_blur = 0.9,
        .drawn_pixel = 2.0,
        .radius_min = 0.5,
        .radius_max = 1.5,
        .axis = {3.0, 4.0, 5.0},
        .axis_max_angle = 0.75,
        .depth_shared = 0.004,
    };
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    cylfuse_options back = {.struct_size = sizeof back};
    CHECK_OK(cylfuse_fitter_get_options(fitter, &back));
    CHECK(memcmp(&options, &back, sizeof back) == 0);

    static const struct {
        size_t offset;
        double value;
        const char *text;
    } bad[] = {
        {offsetof(cylfuse_options, edge_weight), 1.4, "options.edge_weight is 1.4; it must lie in [0, 1]"},
        {offsetof(cylfuse_options, edge_weight), -0.1, "options.edge_weight is -0.1"},
        {offsetof(cylfuse_options, initial_lambda), -1.0, "options.initial_lambda is -1"},
        {offsetof(cylfuse_options, lambda_factor), 1.0, "options.lambda_factor is 1"},
        {offsetof(cylfuse_options, max_lambda), 1e-9, "options.max_lambda is"},
        {offsetof(cylfuse_options, cost_tolerance), 1.0, "options.cost_tolerance is 1"},
        {offsetof(cylfuse_options, gradient_tolerance), 1.0, "options.gradient_tolerance is 1"},
        {offsetof(cylfuse_options, step_tolerance), -1.0, "options.step_tolerance is -1"},
        {offsetof(cylfuse_options, ransac_threshold), -1.0, "options.ransac_threshold is -1"},
        {offsetof(cylfuse_options, independent_points), -1.0, "options.independent_points is -1"},
        {offsetof(cylfuse_options, depth_noise), -1.0, "options.depth_noise is -1; it must be finite and at least 0"},
        {offsetof(cylfuse_options, image_noise), -1.0, "options.image_noise is -1"},
        {offsetof(cylfuse_options, edge_noise), -1.0, "options.edge_noise is -1"},
        {offsetof(cylfuse_options, mask_noise), -1.0, "options.mask_noise is -1"},
        {offsetof(cylfuse_options, image_blur), -1.0, "options.image_blur is -1"},
        {offsetof(cylfuse_options, drawn_pixel), -1.0, "options.drawn_pixel is -1"},
        {offsetof(cylfuse_options, radius_min), -1.0, "options.radius_min is -1; it must be finite and at least 0"},
        {offsetof(cylfuse_options, radius_max), 0.25,
         "options.radius_max is 0.25; it must be greater than 0 and at least radius_min, 0.5"},
        {offsetof(cylfuse_options, axis_max_angle), 1.75, "options.axis_max_angle is 1.75; it must lie in [0, pi/2]"},
    };
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        cylfuse_options wrong = options;
        memcpy((char *)&wrong + bad[k].offset, &bad[k].value, sizeof(double));
        CHECK_ERROR(fitter, cylfuse_fitter_set_options(fitter, &wrong), INVALID_ARGUMENT, bad[k].text);
        double not_a_number = NAN;
        memcpy((char *)&wrong + bad[k].offset, &not_a_number, sizeof(double));
        CHECK_ERROR(fitter, cylfuse_fitter_set_options(fitter, &wrong), INVALID_ARGUMENT, "is NaN");
    }
    CHECK_OK(cylfuse_fitter_get_options(fitter, &back));
    CHECK(memcmp(&options, &back, sizeof back) == 0);

    /* Points may share nothing, and a program from before this option has the default of it. */
    cylfuse_options shared = options;
    shared.depth_shared = -3.0;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &shared));
    CHECK_OK(cylfuse_fitter_get_options(fitter, &back));
    CHECK(back.depth_shared == -1.0);
    shared.struct_size = offsetof(cylfuse_options, depth_shared);
    CHECK_OK(cylfuse_fitter_set_options(fitter, &shared));
    CHECK_OK(cylfuse_fitter_get_options(fitter, &back));
    CHECK(back.depth_shared == 0.0 && back.struct_size == sizeof back);
    shared.struct_size = sizeof shared;
    shared.depth_shared = INFINITY;
    CHECK_ERROR(fitter, cylfuse_fitter_set_options(fitter, &shared), INVALID_ARGUMENT, "options.depth_shared is inf");

    cylfuse_options wrong = options;
    wrong.axis[1] = INFINITY;
    CHECK_ERROR(fitter, cylfuse_fitter_set_options(fitter, &wrong), INVALID_ARGUMENT, "axis is [3.0, inf, 5.0]");
    wrong.axis[0] = wrong.axis[1] = wrong.axis[2] = 0.0;
    CHECK_ERROR(fitter, cylfuse_fitter_set_options(fitter, &wrong), INVALID_ARGUMENT,
                "options.axis_max_angle is 0.75; it must be 0 without options.axis");

    /* Options that were never initialised are found out. */
    cylfuse_options zeros = {.struct_size = sizeof zeros};
    CHECK_ERROR(fitter, cylfuse_fitter_set_options(fitter, &zeros), INVALID_ARGUMENT, "is 0; it must");
    CHECK_OK(cylfuse_options_init(&options, sizeof options));

    /* The methods without iteration. */
    cylfuse_points_view points = scene_points();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    options.method = CYLFUSE_METHOD_EBERLY;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    cylfuse_result result = fit(fitter);
    cylfuse_cylinder_estimate estimate = cylinder_of(fitter);
    CHECK(result.termination == CYLFUSE_TERMINATION_NONE && estimate.start_kind == CYLFUSE_START_MOMENTS);
    CHECK(is_truth(&estimate.model, 1e-6));
    CHECK(isnan(result.near_wall_fraction));
    options.method = CYLFUSE_METHOD_POINTS;
    options.max_iterations = 1;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    CHECK_OK(cylfuse_fitter_set_start_model(fitter, &estimate.start_model));
    CHECK(fit(fitter).iterations <= 1);
    destroy(fitter);
}

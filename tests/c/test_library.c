/* Versions, statuses, defaults. */
#include "check.h"

static void versions_agree(void)
{
    CHECK(cylfuse_abi_version() == CYLFUSE_ABI_VERSION);
    CHECK(cylfuse_version_number() == CYLFUSE_VERSION_NUMBER);
    CHECK(CYLFUSE_VERSION_NUMBER
          == CYLFUSE_VERSION_MAJOR * 65536 + CYLFUSE_VERSION_MINOR * 256 + CYLFUSE_VERSION_PATCH);
    char text[40];
    snprintf(text, sizeof text, "%d.%d.%d", CYLFUSE_VERSION_MAJOR, CYLFUSE_VERSION_MINOR, CYLFUSE_VERSION_PATCH);
    CHECK(strcmp(text, CYLFUSE_VERSION_STRING) == 0);
    CHECK(strcmp(cylfuse_version_string(), CYLFUSE_VERSION_STRING) == 0);
    CHECK(strncmp(cylfuse_build_info(), "cylfuse " CYLFUSE_VERSION_STRING ",", 9 + strlen(text)) == 0);
}

static void statuses_have_texts(void)
{
    CHECK(CYLFUSE_STATUS_OK == 0);
    CHECK(strncmp(cylfuse_status_string(CYLFUSE_STATUS_OK), "OK: ", 4) == 0);
    CHECK(strncmp(cylfuse_status_string(CYLFUSE_STATUS_BUSY), "BUSY: ", 6) == 0);
    CHECK(strncmp(cylfuse_status_string(CYLFUSE_STATUS_TOO_FEW_POINTS), "TOO_FEW_POINTS: ", 16) == 0);
    for (cylfuse_status status = -120; status < 20; status++) {
        CHECK(strlen(cylfuse_status_string(status)) > 3);
    }
    CHECK(strncmp(cylfuse_status_string(INT32_MIN), "unknown", 7) == 0);
}

static void results_have_texts(void)
{
    CHECK(strncmp(cylfuse_flag_string(CYLFUSE_RESULT_FLAGS_WEAK_RADIUS), "WEAK_RADIUS: ", 13) == 0);
    CHECK(strncmp(cylfuse_flag_string(CYLFUSE_RESULT_FLAGS_BODY_TAPERS), "BODY_TAPERS: ", 13) == 0);
    CHECK(strncmp(cylfuse_flag_string(CYLFUSE_RESULT_FLAGS_MASK_DISAGREES), "MASK_DISAGREES: ", 16) == 0);
    CHECK(strcmp(cylfuse_termination_string(CYLFUSE_TERMINATION_COST), "COST: the cost no longer fell") == 0);
    CHECK(strncmp(cylfuse_start_string(CYLFUSE_START_MOMENTS), "MOMENTS: ", 9) == 0);
    CHECK(strcmp(cylfuse_end_state_string(CYLFUSE_END_STATE_SEEN), "SEEN: the surface ends there") == 0);
    CHECK(strncmp(cylfuse_end_source_string(CYLFUSE_END_SOURCE_BORDER), "BORDER: ", 8) == 0);
    CHECK(strncmp(cylfuse_end_source_string(CYLFUSE_END_SOURCE_POINTS), "POINTS: ", 8) == 0);
    CHECK(strncmp(cylfuse_limb_status_string(CYLFUSE_LIMB_STATUS_NO_EDGE), "NO_EDGE: ", 9) == 0);
    CHECK(strncmp(cylfuse_part_string(CYLFUSE_PART_CAP), "CAP: ", 5) == 0);
    CHECK(strncmp(cylfuse_conformity_string(CYLFUSE_CONFORMITY_NOT_CONFORMING), "NOT_CONFORMING: ", 16) == 0);
    /* What is no constant has a text, too; so have no flag and several. */
    CHECK(strncmp(cylfuse_flag_string(0), "unknown", 7) == 0);
    CHECK(strncmp(cylfuse_flag_string(3), "unknown", 7) == 0);
    CHECK(strncmp(cylfuse_flag_string(UINT32_MAX), "unknown", 7) == 0);
    CHECK(strncmp(cylfuse_termination_string(INT32_MIN), "unknown", 7) == 0);
    CHECK(strncmp(cylfuse_start_string(6), "unknown", 7) == 0);
    CHECK(strncmp(cylfuse_end_state_string(-1), "unknown", 7) == 0);
    CHECK(strncmp(cylfuse_end_source_string(99), "unknown", 7) == 0);
    CHECK(strncmp(cylfuse_limb_status_string(INT32_MAX), "unknown", 7) == 0);
    CHECK(strncmp(cylfuse_part_string(0), "unknown", 7) == 0);
    CHECK(strncmp(cylfuse_conformity_string(3), "unknown", 7) == 0);
}

static void a_handle_needs_the_same_interface(void)
{
    cylfuse_fitter *fitter = (cylfuse_fitter *)&the_scene;
    CHECK_STATUS(cylfuse_fitter_create(CYLFUSE_ABI_VERSION + 1, &fitter), ABI_MISMATCH);
    CHECK(fitter == NULL && strstr(cylfuse_fitter_last_error(NULL), "abi_version is 2; this library has 1") != NULL);
    CHECK_STATUS(cylfuse_fitter_create(CYLFUSE_ABI_VERSION, NULL), NULL_POINTER);
    CHECK_OK(cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &fitter));
    CHECK(fitter != NULL && cylfuse_fitter_last_error(fitter)[0] == '\0');
    destroy(fitter);
    CHECK_OK(cylfuse_fitter_destroy(NULL));
}

static void defaults_are_filled(void)
{
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    CHECK(options.struct_size == sizeof options);
    CHECK(options.method == CYLFUSE_METHOD_FUSED && options.objective == CYLFUSE_OBJECTIVE_ROBUST);
    CHECK(options.start == CYLFUSE_START_AUTO && options.near_wall == CYLFUSE_NEAR_WALL_AUTO);
    CHECK(options.chart == CYLFUSE_CHART_AUTO);
    CHECK(options.max_iterations == 400 && options.max_threads == 1 && options.ransac_max_iterations == 1000);
    CHECK(options.edge_weight == 0.6 && options.initial_lambda == 1e-3 && options.lambda_factor == 10.0);
    CHECK(options.max_lambda == 1e12 && options.cost_tolerance == 1e-12);
    CHECK(options.gradient_tolerance == ldexp(1.0, -52) && options.step_tolerance == ldexp(1.0, -52));
    CHECK(options.ransac_threshold == 0.0 && options.seed == 0 && options.independent_points == 0.0);
    CHECK(options.depth_noise == 0.0 && options.image_noise == 0.0 && options.image_blur == 0.0);
    CHECK(options.edge_noise == 0.0 && options.mask_noise == 0.0 && options.drawn_pixel == 0.0);
    CHECK(options.edge_use == CYLFUSE_EDGE_USE_REFINE && options.extent_rule == CYLFUSE_EXTENT_RULE_AUTO);

    cylfuse_points_view points;
    CHECK_OK(cylfuse_points_view_init(&points, sizeof points));
    CHECK(points.struct_size == sizeof points && points.height == 1 && points.data == NULL);
    cylfuse_depth_view depth;
    CHECK_OK(cylfuse_depth_view_init(&depth, sizeof depth));
    CHECK(depth.struct_size == sizeof depth && depth.scale == 1.0 && depth.max_depth == 0.0);
    cylfuse_depth_out depth_out;
    CHECK_OK(cylfuse_depth_out_init(&depth_out, sizeof depth_out));
    CHECK(depth_out.struct_size == sizeof depth_out && depth_out.scale == 1.0);
    cylfuse_points_out points_out;
    CHECK_OK(cylfuse_points_out_init(&points_out, sizeof points_out));
    CHECK(points_out.struct_size == sizeof points_out);
}

void test_library(void)
{
    versions_agree();
    statuses_have_texts();
    results_have_texts();
    a_handle_needs_the_same_interface();
    defaults_are_filled();
}

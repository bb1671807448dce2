/* NULL for every pointer of every function in turn. */
#include "check.h"

static void without_a_fitter(void)
{
    cylfuse_options options;
    cylfuse_options_init(&options, sizeof options);
    cylfuse_points_view points = scene_points();
    cylfuse_depth_view depth = scene_depth();
    cylfuse_segments_view edges = scene_edges();
    cylfuse_image_view image = scene_image();
    cylfuse_counts out_counts = {.struct_size = sizeof out_counts};
    cylfuse_result result = {.struct_size = sizeof result};
    cylfuse_cylinder_diagnosis diagnosis = {.struct_size = sizeof diagnosis};
    cylfuse_completion completion = {.struct_size = sizeof completion};
    cylfuse_extent extent = {.struct_size = sizeof extent};
    cylfuse_points_out out;
    cylfuse_points_out_init(&out, sizeof out);
    cylfuse_depth_out depth_out;
    cylfuse_depth_out_init(&depth_out, sizeof depth_out);
    double values[2];
    size_t count;

    CHECK_STATUS(cylfuse_fitter_reserve(NULL, 1, 1), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_clear(NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_cancel(NULL), NULL_POINTER);
    CHECK(strcmp(cylfuse_fitter_last_error(NULL), "fitter is NULL; give a pointer") == 0);
    CHECK_STATUS(cylfuse_fitter_set_options(NULL, &options), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_get_options(NULL, &options), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_set_intrinsics(NULL, &the_scene.intrinsics), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_set_start_model(NULL, &the_scene.truth), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_set_progress(NULL, NULL, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_set_log(NULL, CYLFUSE_LOG_LEVEL_OFF, NULL, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_push_points(NULL, &points, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_push_depth(NULL, &depth, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_push_edges(NULL, &edges), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_push_image(NULL, &image), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_counts(NULL, &out_counts), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_fit(NULL, &result, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_evaluate(NULL, &the_scene.truth, &result, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_get_result(NULL, &result), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_residuals(NULL, NULL, CYLFUSE_RESIDUAL_KIND_POINTS, values, 2, &count),
                 NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_limb_samples(NULL, NULL, sizeof(cylfuse_limb_sample), 0, &count), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_diagnose(NULL, NULL, &diagnosis), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_complete_bound(NULL, NULL, CYLFUSE_LAYOUT_PACKED, &count), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_complete(NULL, NULL, NULL, CYLFUSE_LAYOUT_PACKED, &out, &completion), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_complete_depth(NULL, NULL, NULL, &depth_out, &completion), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_extent(NULL, NULL, NULL, &extent), NULL_POINTER);
    uint8_t limbs[2];
    const cylfuse_segments_view detected = scene_edges();
    CHECK_STATUS(cylfuse_fitter_select_edges(NULL, NULL, &detected, 0.0, limbs, 2), NULL_POINTER);
}

static void without_an_argument(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    fit(fitter);
    cylfuse_result result = {.struct_size = sizeof result};
    cylfuse_completion completion = {.struct_size = sizeof completion};
    cylfuse_points_out out;
    cylfuse_points_out_init(&out, sizeof out);
    out.scalar = CYLFUSE_SCALAR_F32;
    cylfuse_depth_out depth_out;
    cylfuse_depth_out_init(&depth_out, sizeof depth_out);
    double values[2];
    size_t count = 0;
    cylfuse_residual_kind kind = CYLFUSE_RESIDUAL_KIND_POINTS;

    CHECK_ERROR(fitter, cylfuse_fitter_set_options(fitter, NULL), NULL_POINTER, "options is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_get_options(fitter, NULL), NULL_POINTER, "out_options is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_set_intrinsics(fitter, NULL), NULL_POINTER, "intrinsics is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, NULL, NULL), NULL_POINTER, "points is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, NULL, NULL), NULL_POINTER, "depth is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_push_edges(fitter, NULL), NULL_POINTER, "segments is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, NULL), NULL_POINTER, "image is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_counts(fitter, NULL), NULL_POINTER, "out_counts is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_evaluate(fitter, NULL, &result, NULL), NULL_POINTER, "model is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_get_cylinder(fitter, NULL), NULL_POINTER, "out_estimate is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_get_result(fitter, NULL), NULL_POINTER, "out_result is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_residuals(fitter, NULL, kind, NULL, POINTS + PIXELS, &count), NULL_POINTER,
                "out is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_residuals(fitter, NULL, kind, values, 2, NULL), NULL_POINTER,
                "out_count is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_limb_samples(fitter, NULL, sizeof(cylfuse_limb_sample), 0, NULL), NULL_POINTER, "out_count is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_diagnose(fitter, NULL, NULL), NULL_POINTER, "out_diagnosis is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_complete_bound(fitter, NULL, CYLFUSE_LAYOUT_PACKED, NULL), NULL_POINTER,
                "out_capacity is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, NULL, NULL, CYLFUSE_LAYOUT_PACKED, NULL, &completion), NULL_POINTER, "out is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, NULL, NULL, CYLFUSE_LAYOUT_PACKED, &out, NULL), NULL_POINTER,
                "out_completion is NULL");
    out.capacity = PIXELS;
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, NULL, NULL, CYLFUSE_LAYOUT_PACKED, &out, &completion), NULL_POINTER,
                "out.data is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_complete_depth(fitter, NULL, NULL, NULL, &completion), NULL_POINTER,
                "out is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_complete_depth(fitter, NULL, NULL, &depth_out, NULL), NULL_POINTER,
                "out_completion is NULL");
    depth_out.format = CYLFUSE_DEPTH_FORMAT_F32;
    depth_out.width = WIDTH;
    depth_out.height = HEIGHT;
    CHECK_ERROR(fitter, cylfuse_fitter_complete_depth(fitter, NULL, NULL, &depth_out, &completion), NULL_POINTER,
                "out.data is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_extent(fitter, NULL, NULL, NULL), NULL_POINTER, "out_extent is NULL");

    cylfuse_points_view points = scene_points();
    points.data = NULL;
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), NULL_POINTER, "points.data is NULL");
    depth.data = NULL;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, NULL), NULL_POINTER, "depth.data is NULL");
    depth = scene_depth();
    mask.data = NULL;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, &mask), NULL_POINTER, "mask.data is NULL");
    cylfuse_segments_view edges = scene_edges();
    edges.data = NULL;
    CHECK_ERROR(fitter, cylfuse_fitter_push_edges(fitter, &edges), NULL_POINTER, "segments.data is NULL");

    cylfuse_image_view image = scene_image();
    image.data = NULL;
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), NULL_POINTER, "image.data is NULL");

    /* Nothing of this changed what was there. */
    CHECK(counts(fitter).points_given == POINTS + PIXELS && counts(fitter).segments_given == 2);
    CHECK(fits_truth(fitter, 1e-5));
    destroy(fitter);
}

static void without_a_struct_or_number(void)
{
    const cylfuse_cylinder *truth = &the_scene.truth;
    cylfuse_points_view points = scene_points();
    double values[POINTS], a, b, c;
    CHECK_STATUS(cylfuse_options_init(NULL, sizeof(cylfuse_options)), NULL_POINTER);
    CHECK_STATUS(cylfuse_intrinsics_init(NULL, sizeof(cylfuse_intrinsics)), NULL_POINTER);
    CHECK_STATUS(cylfuse_points_view_init(NULL, sizeof(cylfuse_points_view)), NULL_POINTER);
    CHECK_STATUS(cylfuse_depth_view_init(NULL, sizeof(cylfuse_depth_view)), NULL_POINTER);
    CHECK_STATUS(cylfuse_mask_view_init(NULL, sizeof(cylfuse_mask_view)), NULL_POINTER);
    CHECK_STATUS(cylfuse_image_view_init(NULL, sizeof(cylfuse_image_view)), NULL_POINTER);
    CHECK_STATUS(cylfuse_segments_view_init(NULL, sizeof(cylfuse_segments_view)), NULL_POINTER);
    CHECK_STATUS(cylfuse_points_out_init(NULL, sizeof(cylfuse_points_out)), NULL_POINTER);
    CHECK_STATUS(cylfuse_depth_out_init(NULL, sizeof(cylfuse_depth_out)), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_distances(NULL, &points, values, POINTS), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_distances(truth, NULL, values, POINTS), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_distances(truth, &points, NULL, POINTS), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_project(NULL, &the_scene.intrinsics, values), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_project(truth, NULL, values), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_project(truth, &the_scene.intrinsics, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_plan(NULL, values, NULL, values, values), NULL_POINTER);
    CHECK_STATUS(cylfuse_plan(&the_scene.intrinsics, NULL, NULL, values, values), NULL_POINTER);
    CHECK_STATUS(cylfuse_plan(&the_scene.intrinsics, values, NULL, NULL, values), NULL_POINTER);
    CHECK_STATUS(cylfuse_plan(&the_scene.intrinsics, values, NULL, values, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_compare(NULL, truth, &a, &b, &c), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_compare(truth, NULL, &a, &b, &c), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_compare(truth, truth, NULL, &b, &c), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_compare(truth, truth, &a, NULL, &c), NULL_POINTER);
    CHECK_STATUS(cylfuse_cylinder_compare(truth, truth, &a, &b, NULL), NULL_POINTER);
}

/* Where NULL means something: no start model, no callback, no mask, no weights. */
static void where_null_is_meant(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    CHECK_ERROR(fitter, cylfuse_fitter_set_start_model(fitter, NULL), OK, "");
    CHECK_OK(cylfuse_fitter_set_progress(fitter, NULL, NULL));
    CHECK_OK(cylfuse_fitter_set_log(fitter, CYLFUSE_LOG_LEVEL_DEBUG, NULL, NULL));
    cylfuse_points_view points = scene_points();
    points.data = NULL;
    points.width = 0;
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    cylfuse_segments_view edges = scene_edges();
    edges.data = NULL;
    edges.count = 0;
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    CHECK_OK(cylfuse_cylinder_distances(&the_scene.truth, &points, NULL, 0));
    CHECK(fits_truth(fitter, 1e-6));
    destroy(fitter);
}

void test_null_pointers(void)
{
    without_a_fitter();
    without_an_argument();
    without_a_struct_or_number();
    where_null_is_meant();
}

/* What a fit says of each point, limb and sample of an end. */
#include "check.h"

/* A point far from the surface has no weight. */
static void outliers_are_told(void)
{
    double (*points)[3] = copy_of(the_scene.points, sizeof the_scene.points);
    for (int k = 0; k < POINTS; k++) {
        points[k][k % 3] += 1e-4 * (k * 7919 % 200 - 100) / 100.0;
    }
    points[17][2] += 0.5;
    cylfuse_points_view view = scene_points();
    view.data = points;
    cylfuse_fitter *fitter = new_fitter();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &view, NULL));
    cylfuse_result result = fit(fitter);
    CHECK(result.point_deviation > 0.0 && result.point_deviation < 1e-3 && result.independent_points >= 8.0);
    double weights[POINTS];
    uint8_t inliers[POINTS];
    size_t count = 0;
    CHECK_OK(cylfuse_fitter_point_weights(fitter, weights, inliers, POINTS, &count));
    CHECK(count == POINTS && weights[17] == 0.0 && inliers[17] == 0 && inliers[16] == 1);

    /* What the caller knows better. */
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.independent_points = 40.0;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    CHECK(fit(fitter).independent_points == 40.0);
    destroy(fitter);
    free(points);
}

/* Points beside the surface, told by a model that was not fitted, too. */
static void parts_are_told(void)
{
    double (*points)[3] = copy_of(the_scene.points, sizeof the_scene.points);
    enum { FRONT = POINTS / 2, INSIDE, FAR, SURFACE };
    for (int k = 0; k < 3; k++) {
        points[FRONT][k] *= 0.5;
        points[INSIDE][k] *= 1.05;
        points[FAR][k] *= 2.0;
    }
    cylfuse_points_view view = scene_points();
    view.data = points;
    cylfuse_fitter *fitter = new_fitter();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &view, NULL));
    cylfuse_part parts[POINTS];
    size_t count = 0;
    CHECK_ERROR(fitter, cylfuse_fitter_point_parts(fitter, NULL, parts, POINTS, &count), BAD_STATE, "a model");
    CHECK_ERROR(fitter, cylfuse_fitter_point_parts(fitter, &the_scene.truth, NULL, 0, &count), BUFFER_TOO_SMALL, "600");
    CHECK(count == POINTS);
    CHECK_OK(cylfuse_fitter_point_parts(fitter, &the_scene.truth, parts, POINTS, &count));
    CHECK(count == POINTS);
    CHECK(parts[FRONT] == CYLFUSE_PART_OTHER && parts[INSIDE] == CYLFUSE_PART_INNER_WALL);
    CHECK(parts[FAR] == CYLFUSE_PART_BEHIND && parts[SURFACE] == CYLFUSE_PART_BODY);
    fit(fitter);
    memset(parts, 0, sizeof parts);
    CHECK_OK(cylfuse_fitter_point_parts(fitter, NULL, parts, POINTS, &count));
    CHECK(count == POINTS && parts[FRONT] == CYLFUSE_PART_OTHER && parts[POINTS - 1] == CYLFUSE_PART_BODY);
    destroy(fitter);
    free(points);
}

/* An element as a newer program knows it. */
typedef struct {
    cylfuse_limb limb;
    uint8_t added[8];
} newer_limb;

static void limbs_and_ends_are_listed(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    size_t count = 7;
    cylfuse_limb limbs[2];
    const size_t size = sizeof limbs[0];
    CHECK_ERROR(fitter, cylfuse_fitter_limbs(fitter, limbs, size, 2, &count), BAD_STATE, "fit first");
    CHECK_ERROR(fitter, cylfuse_fitter_end_samples(fitter, NULL, NULL, NULL, sizeof(cylfuse_end_sample), 0, &count),
                BAD_STATE, "fit first");
    CHECK(count == 7);
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    fit(fitter);
    CHECK_OK(cylfuse_fitter_limbs(fitter, limbs, size, 2, &count));
    CHECK(count == 2 && limbs[0].limb == 0 && limbs[1].limb == 1 && limbs[1].view == 0);
    CHECK(limbs[0].status == CYLFUSE_LIMB_STATUS_NOT_SEARCHED && isnan(limbs[0].line[0]) && limbs[0].samples == 0);

    cylfuse_image_view image = scene_image();
    cylfuse_segments_view edges = scene_edges();
    CHECK_OK(cylfuse_fitter_push_image(fitter, &image));
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    fit(fitter);
    double lines[6];
    cylfuse_cylinder model = cylinder_of(fitter).model;
    CHECK_OK(cylfuse_cylinder_project(&model, &the_scene.intrinsics, lines));
    newer_limb newer[2];
    memset(newer, 0xAA, sizeof newer);
    CHECK_OK(cylfuse_fitter_limbs(fitter, &newer[0].limb, sizeof newer[0], 2, &count));
    for (int k = 0; k < 2; k++) {
        const cylfuse_limb *limb = &newer[k].limb;
        CHECK(limb->status == CYLFUSE_LIMB_STATUS_LOCATED && limb->deviation > 0.0 && limb->samples > 3);
        for (int end = 0; end < 2; end++) {
            const double *l = lines + 3 * k, *p = limb->line + 2 * end;
            CHECK_NEAR(l[0] * p[0] + l[1] * p[1] + l[2], 0.0, 0.5);
        }
        CHECK(newer[k].added[0] == 0 && newer[k].added[7] == 0);
    }
    CHECK_ERROR(fitter, cylfuse_fitter_limbs(fitter, limbs, size - 1, 2, &count), STRUCT_SIZE, "element_size is 55");
    CHECK_ERROR(fitter, cylfuse_fitter_limbs(fitter, limbs, 5000, 2, &count), STRUCT_SIZE, "element_size is 5000");
    CHECK_ERROR(fitter, cylfuse_fitter_limbs(fitter, limbs, size, 1, &count), BUFFER_TOO_SMALL, "2 are needed");
    CHECK_ERROR(fitter, cylfuse_fitter_limbs(fitter, NULL, size, 2, &count), NULL_POINTER, "out is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_limbs(fitter, limbs, size, 2, NULL), NULL_POINTER, "out_count is NULL");

    cylfuse_extent extent;
    CHECK_OK(cylfuse_extent_init(&extent, sizeof extent));
    CHECK_OK(cylfuse_fitter_extent(fitter, NULL, NULL, &extent));
    CHECK(extent.start_source == CYLFUSE_END_SOURCE_IMAGE && extent.end_source == CYLFUSE_END_SOURCE_IMAGE);
    CHECK(extent.start_view == 0 && extent.end_view == 0);
    CHECK_STATUS(cylfuse_fitter_end_samples(fitter, NULL, NULL, NULL, sizeof(cylfuse_end_sample), 0, &count),
                 BUFFER_TOO_SMALL);
    cylfuse_end_sample *samples = exactly(count * sizeof *samples);
    CHECK_OK(cylfuse_fitter_end_samples(fitter, NULL, NULL, samples, sizeof *samples, count, &count));
    size_t of_end[2] = {0, 0};
    for (size_t k = 0; k < count; k++) {
        CHECK(samples[k].view == 0 && samples[k].end <= 1 && samples[k].deviation > 0.0);
        CHECK_NEAR(hypot(samples[k].normal[0], samples[k].normal[1]), 1.0, 1e-12);
        CHECK(samples[k].pixel[0] > 0.0 && samples[k].pixel[0] < WIDTH);
        of_end[samples[k].end & 1]++;
    }
    CHECK(of_end[0] >= 5 && of_end[1] >= 5);
    free(samples);
    destroy(fitter);
    CHECK_STATUS(cylfuse_fitter_limbs(NULL, limbs, size, 2, &count), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_point_weights(NULL, NULL, NULL, 0, &count), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_point_parts(NULL, NULL, NULL, 0, &count), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_end_samples(NULL, NULL, NULL, NULL, sizeof(cylfuse_end_sample), 0, &count),
                 NULL_POINTER);
}

void test_lists(void)
{
    outliers_are_told();
    parts_are_told();
    limbs_and_ends_are_listed();
}

/* Completion, extent, geometry without a fitter, memory. */
#include "check.h"

static const cylfuse_layout PACKED = CYLFUSE_LAYOUT_PACKED;

static cylfuse_fitter *new_depth_fitter(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    fit(fitter);
    return fitter;
}

static cylfuse_points_out points_out(void *data, cylfuse_scalar scalar, size_t capacity)
{
    cylfuse_points_out out;
    CHECK_OK(cylfuse_points_out_init(&out, sizeof out));
    out.scalar = scalar;
    out.data = data;
    out.capacity = capacity;
    return out;
}

static void packed_points(cylfuse_fitter *fitter)
{
    size_t bound = 0;
    cylfuse_completion done = {.struct_size = sizeof done};
    CHECK_OK(cylfuse_fitter_complete_bound(fitter, NULL, CYLFUSE_LAYOUT_PACKED, &bound));
    CHECK(bound == the_scene.mask_pixels);
    double *points = exactly(24 * bound);
    cylfuse_points_out out = points_out(points, CYLFUSE_SCALAR_F64, bound);
    CHECK_OK(cylfuse_fitter_complete(fitter, &the_scene.truth, NULL, PACKED, &out, &done));
    CHECK(done.count == done.hits && done.hits + done.misses == bound && done.outside_camera == 0);
    CHECK(done.count == bound && done.out_of_range == 0);
    cylfuse_points_view view = scene_points();
    view.data = points;
    view.width = bound;
    view.height = 1;
    double *distances = exactly(8 * bound);
    CHECK_OK(cylfuse_cylinder_distances(&the_scene.truth, &view, distances, bound));
    for (size_t k = 0; k < bound; k++) {
        CHECK(fabs(distances[k]) < 1e-12);
    }

    /* Too small a buffer: the need is told and nothing written. */
    points[0] = 77.0;
    out.capacity = bound - 1;
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, &the_scene.truth, NULL, PACKED, &out, &done), BUFFER_TOO_SMALL,
                "out.data holds");
    CHECK(done.count == bound && done.hits == 0 && points[0] == 77.0);
    out.data = NULL;
    out.capacity = 0;
    CHECK_STATUS(cylfuse_fitter_complete(fitter, NULL, NULL, PACKED, &out, &done), BUFFER_TOO_SMALL);
    CHECK(done.count > 0 && done.count <= bound);

    /* A thinner model: fewer hits than pixels, and that many fit. */
    cylfuse_cylinder thin = the_scene.truth;
    thin.radius = 0.02;
    out = points_out(points, CYLFUSE_SCALAR_F64, bound);
    CHECK_OK(cylfuse_fitter_complete(fitter, &thin, NULL, PACKED, &out, &done));
    CHECK(done.hits < bound && done.misses == bound - done.hits && done.count == done.hits);
    double *few = exactly(24 * (size_t)done.hits);
    out = points_out(few, CYLFUSE_SCALAR_F64, (size_t)done.hits);
    CHECK_OK(cylfuse_fitter_complete(fitter, &thin, NULL, PACKED, &out, &done));
    CHECK(memcmp(few, points, 24 * (size_t)done.hits) == 0);
    out.capacity--;
    CHECK_STATUS(cylfuse_fitter_complete(fitter, &thin, NULL, PACKED, &out, &done), BUFFER_TOO_SMALL);
    CHECK(done.count == out.capacity + 1);

    /* A cylinder that no ray meets. */
    thin.point[0] += 10.0;
    thin.point[1] += 20.0;
    CHECK_OK(cylfuse_fitter_complete(fitter, &thin, NULL, PACKED, &out, &done));
    CHECK(done.count == 0 && done.hits == 0 && done.misses == bound);

    out.row_stride = 100;
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, NULL, NULL, PACKED, &out, &done), INVALID_ARGUMENT,
                "out.row_stride is 100; it must be 0 for packed points");
    free(few);
    free(points);
    free(distances);
}

static void organised_points(cylfuse_fitter *fitter)
{
    /* PCL's PointXYZ: three floats in 16 bytes, here with rows that have 4 bytes to spare. */
    enum { STRIDE = 16, ROW = WIDTH * STRIDE + 4, TOTAL = (HEIGHT - 1) * ROW + (WIDTH - 1) * STRIDE + 12 };
    uint8_t *memory = exactly(TOTAL);
    memset(memory, 0xAA, TOTAL);
    size_t bound = 0;
    cylfuse_completion done = {.struct_size = sizeof done};
    CHECK_OK(cylfuse_fitter_complete_bound(fitter, NULL, CYLFUSE_LAYOUT_ORGANISED, &bound));
    CHECK(bound == PIXELS);
    cylfuse_points_out out = points_out(memory, CYLFUSE_SCALAR_F32, bound);
    out.point_stride = STRIDE;
    out.row_stride = ROW;
    cylfuse_mask_view mask = scene_mask();
    CHECK_OK(cylfuse_fitter_complete(fitter, NULL, &mask, CYLFUSE_LAYOUT_ORGANISED, &out, &done));
    CHECK(done.count == PIXELS && done.hits + done.misses == the_scene.mask_pixels);
    size_t found = 0;
    for (int k = 0; k < PIXELS; k++) {
        float point[3];
        const uint8_t *at = memory + k / WIDTH * ROW + k % WIDTH * STRIDE;
        memcpy(point, at, sizeof point);
        if (the_scene.mask[k] == 0) {
            CHECK(isnan(point[0]) && isnan(point[1]) && isnan(point[2]));
        } else if (!isnan(point[2])) {
            found++;
            CHECK(fabs(point[2] - (double)the_scene.depth[k]) < 1e-4);
        }
        /* What lies between the points stays. */
        CHECK(k == PIXELS - 1 || (at[12] == 0xAA && at[15] == 0xAA));
    }
    CHECK(found == done.hits);
    out.capacity--;
    CHECK_STATUS(cylfuse_fitter_complete(fitter, NULL, &mask, CYLFUSE_LAYOUT_ORGANISED, &out, &done), BUFFER_TOO_SMALL);
    CHECK(done.count == PIXELS);
    out.capacity++;
    out.point_stride = 8;
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, NULL, &mask, CYLFUSE_LAYOUT_ORGANISED, &out, &done), INVALID_ARGUMENT,
                "out.data: the stride of a point is 8; it must be at least 12 bytes");
    out.point_stride = PTRDIFF_MAX;
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, NULL, &mask, CYLFUSE_LAYOUT_ORGANISED, &out, &done), INVALID_ARGUMENT,
                "fit into memory");
    mask.height = 60;
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, NULL, &mask, CYLFUSE_LAYOUT_ORGANISED, &out, &done), SIZE_MISMATCH, "mask is 160 x 60");
    free(memory);
}

static void depth_images(cylfuse_fitter *fitter)
{
    cylfuse_depth_out out;
    cylfuse_completion done = {.struct_size = sizeof done};
    CHECK_OK(cylfuse_depth_out_init(&out, sizeof out));
    float *floats = exactly(4 * PIXELS);
    out.format = CYLFUSE_DEPTH_FORMAT_F32;
    out.width = WIDTH;
    out.height = HEIGHT;
    /* Bottom row first. */
    out.data = floats + (HEIGHT - 1) * WIDTH;
    out.row_stride = -4 * WIDTH;
    CHECK_OK(cylfuse_fitter_complete_depth(fitter, &the_scene.truth, NULL, &out, &done));
    CHECK(done.count == the_scene.mask_pixels && done.count == done.hits);
    for (int k = 0; k < PIXELS; k++) {
        float expected = the_scene.mask[k] != 0 ? the_scene.depth[k] : 0.0f;
        CHECK(fabs(floats[(HEIGHT - 1 - k / WIDTH) * WIDTH + k % WIDTH] - (double)expected) < 1e-6);
    }
    free(floats);

    uint16_t *integers = exactly(2 * PIXELS);
    out.format = CYLFUSE_DEPTH_FORMAT_U16;
    out.data = integers;
    out.row_stride = 0;
    out.scale = 1e-3;
    CHECK_OK(cylfuse_fitter_complete_depth(fitter, &the_scene.truth, NULL, &out, &done));
    for (int k = 0; k < PIXELS; k++) {
        double expected = the_scene.mask[k] != 0 ? (double)the_scene.depth[k] : 0.0;
        CHECK(fabs(integers[k] * 1e-3 - expected) <= 0.501e-3);
    }
    /* Too fine a unit for 16 bits: nothing wrong is written. */
    out.scale = 1e-6;
    CHECK_OK(cylfuse_fitter_complete_depth(fitter, &the_scene.truth, NULL, &out, &done));
    CHECK(done.count == 0 && done.hits == the_scene.mask_pixels && done.out_of_range == done.hits);
    for (int k = 0; k < PIXELS; k++) {
        CHECK(integers[k] == 0);
    }
    double bad[4] = {0.0, -1.0, NAN, INFINITY};
    for (int k = 0; k < 4; k++) {
        out.scale = bad[k];
        CHECK_ERROR(fitter, cylfuse_fitter_complete_depth(fitter, NULL, NULL, &out, &done), INVALID_ARGUMENT,
                    "out.scale is");
    }
    out.scale = 1e-3;
    out.width--;
    CHECK_ERROR(fitter, cylfuse_fitter_complete_depth(fitter, NULL, NULL, &out, &done), SIZE_MISMATCH, "159 x 120");
    out.width++;
    out.row_stride = WIDTH;
    CHECK_ERROR(fitter, cylfuse_fitter_complete_depth(fitter, NULL, NULL, &out, &done), INVALID_ARGUMENT,
                "out.data: the stride of a row is 160; it must be at least 320 bytes");
    free(integers);
}

void test_completion(void)
{
    cylfuse_fitter *fitter = new_depth_fitter();
    packed_points(fitter);
    organised_points(fitter);
    depth_images(fitter);
    destroy(fitter);
}

static double distance(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

void test_extent(void)
{
    cylfuse_fitter *fitter = new_depth_fitter();
    cylfuse_extent extent = {.struct_size = sizeof extent};
    /* Extreme positions over pixels: to about the length of one. */
    CHECK_OK(cylfuse_fitter_extent(fitter, NULL, NULL, &extent));
    CHECK_NEAR(extent.length, 0.2, 0.006);
    CHECK(distance(extent.start, the_scene.start) < 0.006 && distance(extent.end, the_scene.end) < 0.006);
    CHECK(distance(extent.center, the_scene.truth.point) < 0.006);
    CHECK_NEAR(distance(extent.start, extent.end), extent.length, 1e-12);
    CHECK(extent.start_state == CYLFUSE_END_STATE_SEEN && extent.end_state == CYLFUSE_END_STATE_SEEN);
    CHECK(extent.length_deviation > extent.start_deviation && extent.start_deviation > 0.0);
    CHECK(extent.start_covariance[0] > 0.0 && extent.end_covariance[4] > 0.0);
    CHECK(extent.center_covariance[1] == extent.center_covariance[3]);

    /* A single pixel: one point, no length. */
    uint8_t *one = exactly(PIXELS);
    memset(one, 0, PIXELS);
    one[60 * WIDTH + 80] = 1;
    cylfuse_mask_view mask = scene_mask();
    mask.data = one;
    CHECK_OK(cylfuse_fitter_extent(fitter, &the_scene.truth, &mask, &extent));
    CHECK(extent.length == 0.0);
    CHECK(isnan(extent.start_deviation) && isnan(extent.length_deviation) && isnan(extent.center_covariance[8]));
    cylfuse_cylinder aside = the_scene.truth;
    aside.point[0] += 10.0;
    aside.point[1] += 20.0;
    CHECK_ERROR(fitter, cylfuse_fitter_extent(fitter, &aside, &mask, &extent), EDGE_GEOMETRY, "no ray of a mask");
    one[60 * WIDTH + 80] = 0;
    CHECK_ERROR(fitter, cylfuse_fitter_extent(fitter, NULL, &mask, &extent), EMPTY_MASK, "all 160 x 120");
    free(one);
    destroy(fitter);
}

void test_edge_selection(void)
{
    /* Of three segments the one across the cylinder is on no limb. */
    const double *e = the_scene.edges[0];
    double detected[3][4] = {{0}, {e[0], e[1], e[2] + 60.0, e[3]}, {0}};
    memcpy(detected[0], the_scene.edges[1], sizeof detected[0]);
    memcpy(detected[2], the_scene.edges[0], sizeof detected[2]);
    cylfuse_segments_view segments = scene_edges();
    segments.data = detected;
    segments.count = 3;
    uint8_t limbs[3] = {9, 9, 9};

    cylfuse_fitter *fitter = new_fitter();
    const cylfuse_cylinder *truth = &the_scene.truth;
    CHECK_ERROR(fitter, cylfuse_fitter_select_edges(fitter, NULL, &segments, 0.0, limbs, 3), BAD_STATE, "fit first");
    CHECK_ERROR(fitter, cylfuse_fitter_select_edges(fitter, truth, &segments, 0.0, limbs, 3), BAD_STATE, "needs intrinsics");
    CHECK_OK(cylfuse_fitter_set_intrinsics(fitter, &the_scene.intrinsics));
    CHECK_ERROR(fitter, cylfuse_fitter_select_edges(fitter, truth, &segments, 0.0, limbs, 3), BAD_STATE, "needs points");
    destroy(fitter);

    fitter = new_depth_fitter();
    CHECK_ERROR(fitter, cylfuse_fitter_select_edges(fitter, NULL, &segments, 0.0, limbs, 2), BUFFER_TOO_SMALL, "3");
    CHECK_ERROR(fitter, cylfuse_fitter_select_edges(fitter, NULL, &segments, 0.0, NULL, 3), NULL_POINTER, "out_limbs");
    CHECK_ERROR(fitter, cylfuse_fitter_select_edges(fitter, NULL, NULL, 0.0, limbs, 3), NULL_POINTER, "segments");
    CHECK_ERROR(fitter, cylfuse_fitter_select_edges(fitter, NULL, &segments, NAN, limbs, 3), INVALID_ARGUMENT, "reach is NaN");
    cylfuse_cylinder around = *truth;
    around.radius = 5.0;
    CHECK_ERROR(fitter, cylfuse_fitter_select_edges(fitter, &around, &segments, 0.0, limbs, 3), EDGE_GEOMETRY, "inside");
    CHECK(limbs[0] == 9 && limbs[1] == 9 && limbs[2] == 9);
    CHECK_OK(cylfuse_fitter_select_edges(fitter, NULL, &segments, 0.0, limbs, 3));
    CHECK(limbs[0] + limbs[2] == 3 && limbs[0] != limbs[2] && limbs[0] != 0 && limbs[1] == 0);
    segments.count = 0;
    CHECK_OK(cylfuse_fitter_select_edges(fitter, truth, &segments, 2.0, NULL, 0));
    destroy(fitter);
}

void test_cylinder(void)
{
    const cylfuse_cylinder *truth = &the_scene.truth;
    double lines[6] = {0};
    CHECK_OK(cylfuse_cylinder_project(truth, &the_scene.intrinsics, lines));
    /* Each segment of the scene lies on one of the lines. */
    for (int side = 0; side < 2; side++) {
        const double *e = the_scene.edges[side];
        double off[2];
        for (int k = 0; k < 2; k++) {
            const double *l = lines + 3 * k;
            off[k] = fabs(l[0] * e[0] + l[1] * e[1] + l[2]) + fabs(l[0] * e[2] + l[1] * e[3] + l[2]);
            CHECK_NEAR(l[0] * l[0] + l[1] * l[1], 1.0, 1e-14);
        }
        CHECK((off[0] < 1e-9) != (off[1] < 1e-9));
    }
    cylfuse_cylinder around = *truth;
    around.radius = 5.0;
    lines[0] = 7.0;
    CHECK_STATUS(cylfuse_cylinder_project(&around, &the_scene.intrinsics, lines), EDGE_GEOMETRY);
    CHECK(lines[0] == 7.0);

    double points[3][3] = {{0}, {NAN, 0.0, 0.0}, {0}}, out[3] = {1.0, 1.0, 1.0};
    memcpy(points[0], truth->point, sizeof points[0]);
    cylfuse_points_view view = scene_points();
    view.data = points;
    view.width = 3;
    view.height = 1;
    CHECK_STATUS(cylfuse_cylinder_distances(truth, &view, out, 2), BUFFER_TOO_SMALL);
    CHECK(out[0] == 1.0);
    CHECK_OK(cylfuse_cylinder_distances(truth, &view, out, 3));
    CHECK_NEAR(out[0], -truth->radius, 1e-15);
    CHECK(isnan(out[1]) && out[2] > 0.5);

    double angle, axis_distance, relative;
    cylfuse_cylinder other = {{3.0, 0.0, 1.0}, {0.0, 2.0, 0.0}, 1.5}, base = {{0.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}, 1.0};
    CHECK_OK(cylfuse_cylinder_compare(&base, &other, &angle, &axis_distance, &relative));
    CHECK_NEAR(angle, 1.5707963267948966, 1e-15);
    CHECK_NEAR(axis_distance, 1.0, 1e-15);
    CHECK_NEAR(relative, 0.5, 1e-15);
    angle = 7.0;
    other.radius = NAN;
    CHECK_STATUS(cylfuse_cylinder_compare(&base, &other, &angle, &axis_distance, &relative), INVALID_ARGUMENT);
    CHECK(angle == 7.0);
    CHECK(strstr(cylfuse_fitter_last_error(NULL), "radius is NaN") != NULL);
    other.radius = 1.5;
    CHECK_OK(cylfuse_cylinder_compare(&base, &other, &angle, &axis_distance, &relative));
    CHECK(cylfuse_fitter_last_error(NULL)[0] == '\0');
}

void test_plan(void)
{
    cylfuse_intrinsics camera;
    cylfuse_intrinsics_init(&camera, sizeof camera);
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 570.0;
    camera.cx = 319.5;
    camera.cy = 239.5;
    const double can[5] = {0.7, 0.03, 0.1, 0.35, 0.42};
    const double far_pipe[5] = {1.4, 0.03, 2.0, 0.0, 0.42};
    const double noise[6] = {0.0, 0.0, 0.039 / (575.0 * 0.075), 9.0 * 570.0 / 575.0, 0.014, 0.7};
    double scatter[4], total[4], same[4], again[4];
    CHECK_OK(cylfuse_plan(&camera, can, NULL, scatter, total));
    for (int k = 0; k < 4; k++) CHECK(scatter[k] > 0.0 && scatter[k] < total[k]);
    CHECK_OK(cylfuse_plan(&camera, can, noise, same, again));
    for (int k = 0; k < 4; k++) CHECK_NEAR(same[k], scatter[k], 1e-12);
    CHECK_OK(cylfuse_plan(&camera, far_pipe, NULL, same, again));
    CHECK(isnan(again[3]) && again[0] > total[0]);
    double bad[5] = {0.7, NAN, 0.1, 0.35, 0.42};
    scatter[0] = 7.0;
    CHECK_STATUS(cylfuse_plan(&camera, bad, NULL, scatter, total), INVALID_ARGUMENT);
    CHECK(scatter[0] == 7.0 && strstr(cylfuse_fitter_last_error(NULL), "radius is NaN") != NULL);
    bad[0] = 9.0;
    bad[1] = 0.03;
    CHECK_STATUS(cylfuse_plan(&camera, bad, NULL, scatter, total), TOO_FEW_POINTS);
}

void test_memory(void)
{
    cylfuse_fitter *fitter = new_fitter();
    CHECK_ERROR(fitter, cylfuse_fitter_reserve(fitter, SIZE_MAX, 0), OUT_OF_MEMORY, "out of memory");
    CHECK_ERROR(fitter, cylfuse_fitter_reserve(fitter, 0, SIZE_MAX), OUT_OF_MEMORY, "for the edge segments");
    CHECK_ERROR(fitter, cylfuse_fitter_reserve(fitter, SIZE_MAX / 32, 0), OUT_OF_MEMORY, "for the points");
    CHECK_OK(cylfuse_fitter_reserve(fitter, 0, 0));
    CHECK_OK(cylfuse_fitter_reserve(fitter, 5000, 8));
    CHECK_OK(cylfuse_fitter_set_intrinsics(fitter, &the_scene.intrinsics));
    /* Frame after frame. */
    for (int frame = 0; frame < 3; frame++) {
        cylfuse_points_view points = scene_points();
        cylfuse_segments_view edges = scene_edges();
        CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
        CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
        CHECK(fits_truth(fitter, 1e-9));
        CHECK_OK(cylfuse_fitter_clear(fitter));
        cylfuse_result result = {.struct_size = sizeof result};
        CHECK_STATUS(cylfuse_fitter_get_result(fitter, &result), BAD_STATE);
        CHECK(counts(fitter).points_given == 0 && counts(fitter).segments_given == 0);
    }
    destroy(fitter);
}

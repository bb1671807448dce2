/* Views, frames, clearing one input, masks with labels; cameras on their own. */
#include "check.h"

static const double IDENTITY[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
static const double NOWHERE[3] = {0.0, 0.0, 0.0};

static void one_view_needs_nothing(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    size_t views = 0;
    CHECK_OK(cylfuse_fitter_view_count(fitter, &views));
    CHECK(views == 1 && counts(fitter).view == 0);
    CHECK_OK(cylfuse_fitter_select_view(fitter, 0));
    CHECK_ERROR(fitter, cylfuse_fitter_select_view(fitter, 2), INVALID_ARGUMENT, "index is 2; it must be at most");
    CHECK_OK(cylfuse_fitter_set_pose(fitter, IDENTITY, NOWHERE));
    CHECK_ERROR(fitter, cylfuse_fitter_set_depth_camera(fitter, NULL, NULL, NULL), OK, "");
    CHECK(fits_truth(fitter, 1e-9));

    double wrong[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0};
    CHECK_ERROR(fitter, cylfuse_fitter_set_pose(fitter, wrong, NOWHERE), INVALID_ARGUMENT, "rotation is");
    double nowhere[3] = {0.0, NAN, 0.0};
    CHECK_STATUS(cylfuse_fitter_set_pose(fitter, IDENTITY, nowhere), INVALID_ARGUMENT);
    CHECK_ERROR(fitter, cylfuse_fitter_set_pose(fitter, NULL, NOWHERE), NULL_POINTER, "rotation is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_set_pose(fitter, IDENTITY, NULL), NULL_POINTER, "translation is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_set_depth_camera(fitter, &the_scene.intrinsics, NULL, NOWHERE), NULL_POINTER,
                "rotation is NULL");
    cylfuse_intrinsics bad = the_scene.intrinsics;
    bad.fx = -1.0;
    CHECK_STATUS(cylfuse_fitter_set_depth_camera(fitter, &bad, IDENTITY, NOWHERE), INVALID_INTRINSICS);
    CHECK_ERROR(fitter, cylfuse_fitter_view_count(fitter, NULL), NULL_POINTER, "out_count is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_clear_input(fitter, 16), INVALID_ARGUMENT, "inputs is 16");
    CHECK(fits_truth(fitter, 1e-9));
    destroy(fitter);

    CHECK_STATUS(cylfuse_fitter_select_view(NULL, 0), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_view_count(NULL, &views), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_set_pose(NULL, IDENTITY, NOWHERE), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_set_depth_camera(NULL, NULL, NULL, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_clear_input(NULL, CYLFUSE_INPUT_EDGES), NULL_POINTER);
}

static void frames_are_made_and_destroyed(void)
{
    cylfuse_frame *frame = (cylfuse_frame *)&the_scene;
    CHECK_STATUS(cylfuse_frame_create(CYLFUSE_ABI_VERSION + 1, &frame), ABI_MISMATCH);
    CHECK(frame == NULL);
    CHECK_STATUS(cylfuse_frame_create(CYLFUSE_ABI_VERSION, NULL), NULL_POINTER);
    CHECK_OK(cylfuse_frame_create(CYLFUSE_ABI_VERSION, &frame));
    CHECK(cylfuse_frame_last_error(frame)[0] == '\0');
    CHECK_STATUS(cylfuse_frame_set_intrinsics(frame, NULL), NULL_POINTER);
    CHECK(strstr(cylfuse_frame_last_error(frame), "intrinsics is NULL") != NULL);
    CHECK_STATUS(cylfuse_frame_set_pose(frame, IDENTITY, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_frame_set_depth_camera(frame, &the_scene.intrinsics, NULL, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_frame_set_depth(frame, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_frame_set_image(frame, NULL), NULL_POINTER);
    cylfuse_fitter *fitter = new_fitter();
    CHECK_ERROR(fitter, cylfuse_fitter_use_frame(fitter, NULL, NULL), NULL_POINTER, "frame is NULL");
    destroy(fitter);
    CHECK_OK(cylfuse_frame_destroy(frame));
    CHECK_OK(cylfuse_frame_destroy(NULL));
    CHECK(cylfuse_frame_last_error(NULL)[0] == '\0');

    cylfuse_depth_view depth = scene_depth();
    cylfuse_image_view image = scene_image();
    CHECK_STATUS(cylfuse_frame_set_intrinsics(NULL, &the_scene.intrinsics), NULL_POINTER);
    CHECK_STATUS(cylfuse_frame_set_pose(NULL, IDENTITY, NOWHERE), NULL_POINTER);
    CHECK_STATUS(cylfuse_frame_set_depth_camera(NULL, NULL, NULL, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_frame_set_depth(NULL, &depth), NULL_POINTER);
    CHECK_STATUS(cylfuse_frame_set_image(NULL, &image), NULL_POINTER);
    CHECK(strstr(cylfuse_frame_last_error(NULL), "frame is NULL") != NULL);
    CHECK_STATUS(cylfuse_fitter_use_frame(NULL, NULL, NULL), NULL_POINTER);
}

/* A turn about y and a shift: the pose of a second camera. */
static const double TURN[9] = {0.8, 0.0, 0.6, 0.0, 1.0, 0.0, -0.6, 0.0, 0.8};
static const double SHIFT[3] = {-0.5, 0.1, 0.2};

/* What a camera at that pose sees of a point: TURN' (p - SHIFT). */
static void seen_from_there(const double p[3], double out[3])
{
    for (int k = 0; k < 3; k++) {
        out[k] = 0.0;
        for (int j = 0; j < 3; j++) {
            out[k] += TURN[3 * j + k] * (p[j] - SHIFT[j]);
        }
    }
}

static void several_views_see_one_cylinder(void)
{
    double there[POINTS][3];
    for (int k = 0; k < POINTS; k++) {
        seen_from_there(the_scene.points[k], there[k]);
    }
    cylfuse_fitter *fitter = new_fitter();
    cylfuse_points_view points = scene_points();
    points.width = COLUMNS * (ROWS / 2);
    points.height = 1;
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK_OK(cylfuse_fitter_select_view(fitter, 1));
    CHECK_OK(cylfuse_fitter_set_pose(fitter, TURN, SHIFT));
    points.data = there[COLUMNS * (ROWS / 2)];
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    size_t views = 0, count = 0;
    CHECK_OK(cylfuse_fitter_view_count(fitter, &views));
    CHECK(views == 2 && counts(fitter).view == 1 && counts(fitter).points_given == POINTS / 2);
    CHECK(fits_truth(fitter, 1e-9));
    CHECK(fit(fitter).points_used == POINTS);

    /* Both views from the model in the reference frame. */
    double residuals[POINTS], weights[POINTS];
    uint8_t inliers[POINTS];
    for (size_t view = 0; view < 2; view++) {
        CHECK_OK(cylfuse_fitter_select_view(fitter, view));
        CHECK_OK(cylfuse_fitter_residuals(fitter, NULL, CYLFUSE_RESIDUAL_KIND_POINTS, residuals, POINTS, &count));
        CHECK(count == POINTS / 2);
        CHECK_OK(cylfuse_fitter_point_weights(fitter, weights, inliers, POINTS, &count));
        CHECK(count == POINTS / 2);
        for (size_t k = 0; k < count; k++) {
            CHECK(fabs(residuals[k]) < 1e-9 && weights[k] > 0.0 && weights[k] <= 1.0 && inliers[k] == 1);
        }
    }
    CHECK_OK(cylfuse_fitter_point_weights(fitter, NULL, NULL, POINTS, &count));
    CHECK_ERROR(fitter, cylfuse_fitter_point_weights(fitter, weights, NULL, 1, &count), BUFFER_TOO_SMALL, "300");
    CHECK(count == POINTS / 2);
    cylfuse_limb limbs[4];
    CHECK_OK(cylfuse_fitter_limbs(fitter, limbs, sizeof limbs[0], 4, &count));
    CHECK(count == 4 && limbs[1].view == 0 && limbs[2].view == 1 && limbs[3].limb == 1);
    CHECK_ERROR(fitter, cylfuse_fitter_select_view(fitter, 3), INVALID_ARGUMENT, "the number of views, 2");

    /* Clearing keeps the first view only. */
    CHECK_OK(cylfuse_fitter_clear(fitter));
    CHECK_OK(cylfuse_fitter_view_count(fitter, &views));
    CHECK(views == 1 && counts(fitter).view == 0 && counts(fitter).points_given == 0);
    destroy(fitter);
}

static void inputs_are_cleared_one_by_one(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    cylfuse_image_view image = scene_image();
    cylfuse_segments_view edges = scene_edges();
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    CHECK_OK(cylfuse_fitter_push_image(fitter, &image));
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    CHECK(fit(fitter).limbs_located == 2);
    CHECK_OK(cylfuse_fitter_clear_input(fitter, CYLFUSE_INPUT_IMAGE));
    cylfuse_result result = fit(fitter);
    CHECK(result.limbs_located == 0 && result.segments_used == 2);
    CHECK_OK(cylfuse_fitter_clear_input(fitter, CYLFUSE_INPUT_EDGES));
    CHECK(counts(fitter).segments_given == 0 && fit(fitter).segments_given == 0);
    CHECK_OK(cylfuse_fitter_clear_input(fitter, CYLFUSE_INPUT_DEPTH));
    cylfuse_extent extent;
    CHECK_OK(cylfuse_extent_init(&extent, sizeof extent));
    CHECK_OK(cylfuse_fitter_extent(fitter, NULL, NULL, &extent));
    CHECK(extent.start_source == CYLFUSE_END_SOURCE_POINTS);
    CHECK(counts(fitter).points_used == the_scene.mask_pixels);
    CHECK_OK(cylfuse_fitter_clear_input(fitter, CYLFUSE_INPUT_POINTS));
    CHECK(counts(fitter).points_given == 0);
    cylfuse_result kept;
    CHECK_OK(cylfuse_result_init(&kept, sizeof kept));
    CHECK_OK(cylfuse_fitter_get_result(fitter, &kept));
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, NULL, NULL), TOO_FEW_POINTS, "0 of 0 points are usable");
    destroy(fitter);
}

static void one_frame_serves_many_fitters(void)
{
    cylfuse_frame *frame = NULL;
    CHECK_OK(cylfuse_frame_create(CYLFUSE_ABI_VERSION, &frame));
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    cylfuse_image_view image = scene_image();
    cylfuse_fitter *fitters[2] = {new_fitter(), new_fitter()};
    CHECK_ERROR(fitters[0], cylfuse_fitter_use_frame(fitters[0], frame, &mask), BAD_STATE, "intrinsics");
    CHECK_STATUS(cylfuse_frame_set_depth(frame, &depth), BAD_STATE);
    CHECK_STATUS(cylfuse_frame_set_image(frame, &image), BAD_STATE);
    CHECK_OK(cylfuse_frame_set_intrinsics(frame, &the_scene.intrinsics));
    CHECK_OK(cylfuse_frame_set_depth(frame, &depth));
    CHECK_OK(cylfuse_frame_set_image(frame, &image));
    cylfuse_intrinsics other = the_scene.intrinsics;
    other.width++;
    CHECK_STATUS(cylfuse_frame_set_intrinsics(frame, &other), SIZE_MISMATCH);
    CHECK_STATUS(cylfuse_frame_set_depth_camera(frame, &other, IDENTITY, NOWHERE), SIZE_MISMATCH);
    CHECK_OK(cylfuse_frame_set_depth_camera(frame, NULL, NULL, NULL));

    mask.width--;
    CHECK_STATUS(cylfuse_fitter_use_frame(fitters[0], frame, &mask), SIZE_MISMATCH);
    mask = scene_mask();
    CHECK_OK(cylfuse_fitter_use_frame(fitters[0], frame, &mask));
    CHECK_OK(cylfuse_frame_set_pose(frame, TURN, SHIFT));
    CHECK_OK(cylfuse_fitter_use_frame(fitters[1], frame, &mask));
    CHECK_OK(cylfuse_frame_destroy(frame));

    CHECK(counts(fitters[0]).points_used == the_scene.mask_pixels);
    CHECK(fits_truth(fitters[0], 1e-4));
    /* The second one gives the cylinder in the reference frame. */
    cylfuse_cylinder_estimate estimate = fit_cylinder(fitters[1]);
    cylfuse_cylinder there = estimate.model;
    double tip[3];
    for (int k = 0; k < 3; k++) {
        tip[k] = estimate.model.point[k] + estimate.model.direction[k];
    }
    seen_from_there(estimate.model.point, there.point);
    seen_from_there(tip, there.direction);
    for (int k = 0; k < 3; k++) {
        there.direction[k] -= there.point[k];
    }
    CHECK(is_truth(&there, 1e-4));
    for (int k = 0; k < 2; k++) {
        cylfuse_extent extent;
        CHECK_OK(cylfuse_extent_init(&extent, sizeof extent));
        CHECK_OK(cylfuse_fitter_extent(fitters[k], NULL, NULL, &extent));
        CHECK_NEAR(extent.length, 0.2, 2e-3);
        CHECK(extent.start_source == CYLFUSE_END_SOURCE_IMAGE && extent.limbs_known == 1);
        destroy(fitters[k]);
    }
}

/* The depth camera beside the colour camera, with the same optics. */
static void depth_of_a_camera_of_its_own(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    double beside[3] = {0.02, 0.0, 0.0};
    CHECK_OK(cylfuse_fitter_set_depth_camera(fitter, &the_scene.intrinsics, IDENTITY, beside));
    cylfuse_depth_view depth = scene_depth();
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, NULL));
    CHECK(counts(fitter).points_given == PIXELS);
    CHECK_STATUS(cylfuse_fitter_set_depth_camera(fitter, &(cylfuse_intrinsics){.struct_size = 1}, IDENTITY, beside),
                 STRUCT_SIZE);
    /* All points have moved by the offset. */
    cylfuse_fitter *plain = new_camera_fitter();
    cylfuse_mask_view mask = scene_mask();
    CHECK_OK(cylfuse_fitter_push_depth(plain, &depth, &mask));
    cylfuse_cylinder model = fit_cylinder(plain).model;
    CHECK_OK(cylfuse_fitter_clear_input(plain, CYLFUSE_INPUT_DEPTH | CYLFUSE_INPUT_POINTS));
    CHECK_OK(cylfuse_fitter_set_depth_camera(plain, &the_scene.intrinsics, IDENTITY, beside));
    double length = 0.0;
    for (int k = 0; k < 3; k++) {
        model.point[k] += beside[k];
        length += model.direction[k] * model.direction[k];
    }
    CHECK_NEAR(length, 1.0, 1e-12);
    /* The mask is that of the colour camera, in which the cylinder has moved by 6 pixels: most of it remains. */
    CHECK_OK(cylfuse_fitter_push_depth(plain, &depth, &mask));
    CHECK(counts(plain).points_used > the_scene.mask_pixels / 2);
    cylfuse_counts all = counts(plain);
    CHECK(all.points_given == all.points_used + all.dropped_outside_mask + all.dropped_no_depth + all.dropped_hidden +
                                  all.dropped_outside_camera + all.dropped_out_of_range);
    destroy(plain);
    destroy(fitter);
}

static void colour_images_are_read(void)
{
    static const cylfuse_image_format formats[4] = {CYLFUSE_IMAGE_FORMAT_RGB8, CYLFUSE_IMAGE_FORMAT_BGR8,
                                                    CYLFUSE_IMAGE_FORMAT_RGBA8, CYLFUSE_IMAGE_FORMAT_BGRA8};
    float low = the_scene.image[0], high = low;
    for (int k = 0; k < PIXELS; k++) {
        low = fminf(low, the_scene.image[k]);
        high = fmaxf(high, the_scene.image[k]);
    }
    for (int k = 0; k < 4; k++) {
        size_t channels = k < 2 ? 3 : 4;
        uint8_t *pixels = exactly(channels * PIXELS);
        for (int p = 0; p < PIXELS; p++) {
            uint8_t value = (uint8_t)(20.0f + 200.0f * (the_scene.image[p] - low) / (high - low));
            memset(pixels + channels * (size_t)p, value, 3);
            if (channels == 4) {
                pixels[4 * p + 3] = (uint8_t)p;
            }
        }
        cylfuse_image_view image = scene_image();
        image.format = formats[k];
        image.data = pixels;
        image.row_stride = image.pixel_stride = 0;
        cylfuse_fitter *fitter = new_full_fitter();
        CHECK_OK(cylfuse_fitter_push_image(fitter, &image));
        CHECK(fit(fitter).limbs_located == 2);
        image.pixel_stride = 2;
        CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), INVALID_ARGUMENT, "the stride of a pixel is 2");
        destroy(fitter);
        free(pixels);
    }
}

/* An image of labels: the cylinder is number 7 beside others. */
static void labels_select_the_cylinder(void)
{
    uint8_t *labels = exactly(PIXELS);
    for (int k = 0; k < PIXELS; k++) {
        labels[k] = the_scene.mask[k] != 0 ? 7 : (uint8_t)(k % 7);
    }
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    mask.data = labels;
    mask.label = 7;
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    CHECK(counts(fitter).points_used == the_scene.mask_pixels);
    CHECK(fits_truth(fitter, 1e-5));
    mask.label = 8;
    CHECK_STATUS(cylfuse_fitter_push_depth(fitter, &depth, &mask), EMPTY_MASK);
    mask.label = 1000;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, &mask), INVALID_ARGUMENT, "mask.label is 1000");
    free(labels);
    destroy(fitter);
}

static void cameras_project_there_and_back(void)
{
    cylfuse_intrinsics camera = the_scene.intrinsics;
    camera.distortion_model = CYLFUSE_DISTORTION_BROWN_CONRADY;
    camera.distortion[0] = -0.1;
    camera.distortion[2] = 0.001;
    double *pixels = exactly(2 * sizeof(double) * POINTS), *rays = exactly(3 * sizeof(double) * POINTS);
    cylfuse_points_view points = scene_points();
    CHECK_OK(cylfuse_intrinsics_project(&camera, &points, pixels, POINTS));
    CHECK_OK(cylfuse_intrinsics_unproject(&camera, pixels, POINTS, rays));
    for (int k = 0; k < POINTS; k++) {
        const double *p = the_scene.points[k], *ray = rays + 3 * k;
        CHECK(ray[2] == 1.0);
        CHECK_NEAR(ray[0], p[0] / p[2], 1e-9);
        CHECK_NEAR(ray[1], p[1] / p[2], 1e-9);
    }
    /* Without distortion by hand. */
    CHECK_OK(cylfuse_intrinsics_project(&the_scene.intrinsics, &points, pixels, POINTS));
    CHECK_NEAR(pixels[0], 200.0 * the_scene.points[0][0] / the_scene.points[0][2] + 79.0, 1e-10);
    CHECK_NEAR(pixels[1], 201.0 * the_scene.points[0][1] / the_scene.points[0][2] + 60.5, 1e-10);

    double behind[2][3] = {{0.0, 0.0, -1.0}, {NAN, 0.0, 1.0}};
    points.data = behind;
    points.width = 2;
    points.height = 1;
    CHECK_OK(cylfuse_intrinsics_project(&camera, &points, pixels, 2));
    CHECK(isnan(pixels[0]) && isnan(pixels[1]) && isnan(pixels[2]));
    pixels[0] = NAN;
    CHECK_OK(cylfuse_intrinsics_unproject(&camera, pixels, 1, rays));
    CHECK(isnan(rays[0]) && isnan(rays[2]));

    CHECK_STATUS(cylfuse_intrinsics_project(&camera, &points, pixels, 1), BUFFER_TOO_SMALL);
    CHECK_STATUS(cylfuse_intrinsics_project(&camera, &points, NULL, 2), NULL_POINTER);
    CHECK_STATUS(cylfuse_intrinsics_project(NULL, &points, pixels, 2), NULL_POINTER);
    CHECK_STATUS(cylfuse_intrinsics_project(&camera, NULL, pixels, 2), NULL_POINTER);
    CHECK_STATUS(cylfuse_intrinsics_unproject(NULL, pixels, 1, rays), NULL_POINTER);
    CHECK_STATUS(cylfuse_intrinsics_unproject(&camera, NULL, 1, rays), NULL_POINTER);
    CHECK_STATUS(cylfuse_intrinsics_unproject(&camera, pixels, 1, NULL), NULL_POINTER);
    CHECK_OK(cylfuse_intrinsics_unproject(&camera, NULL, 0, NULL));
    camera.fy = 0.0;
    CHECK_STATUS(cylfuse_intrinsics_project(&camera, &points, pixels, 2), INVALID_INTRINSICS);
    CHECK_STATUS(cylfuse_intrinsics_unproject(&camera, pixels, 1, rays), INVALID_INTRINSICS);
    free(pixels);
    free(rays);
}

void test_views(void)
{
    one_view_needs_nothing();
    several_views_see_one_cylinder();
    inputs_are_cleared_one_by_one();
    frames_are_made_and_destroyed();
    one_frame_serves_many_fitters();
    depth_of_a_camera_of_its_own();
    colour_images_are_read();
    labels_select_the_cylinder();
    cameras_project_there_and_back();
}

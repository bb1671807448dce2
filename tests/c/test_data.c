/* Pushing: every form of data, and what is refused. */
#include "check.h"

static void expect_dropped(cylfuse_fitter *fitter, uint64_t given, uint64_t used)
{
    cylfuse_counts now = counts(fitter);
    CHECK(now.points_given == given && now.points_used == used);
    CHECK(now.dropped_not_finite + now.dropped_zero_weight + now.dropped_outside_mask + now.dropped_no_depth
              + now.dropped_out_of_range + now.dropped_outside_camera
          == given - used);
}

/* Fits one cloud and says whether the truth comes out. */
static int cloud_gives_truth(const cylfuse_points_view *points, const cylfuse_mask_view *mask, double tolerance)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, points, mask), OK, "");
    int holds = fits_truth(fitter, tolerance);
    destroy(fitter);
    return holds;
}

static void clouds_of_any_stride(void)
{
    cylfuse_points_view points = scene_points();
    CHECK(cloud_gives_truth(&points, NULL, 1e-9));

    /* 3 floats in elements of 17 bytes at an odd address, bottom row first, the last column first. */
    enum { STRIDE = 17, ROW = COLUMNS * STRIDE + 5, TOTAL = (ROWS - 1) * ROW + (COLUMNS - 1) * STRIDE + 12 };
    uint8_t *memory = exactly(TOTAL + 1);
    memset(memory, 0xFF, TOTAL + 1);
    for (int row = 0; row < ROWS; row++) {
        for (int column = 0; column < COLUMNS; column++) {
            const double *p = the_scene.points[row * COLUMNS + column];
            float values[3] = {(float)p[0], (float)p[1], (float)p[2]};
            memcpy(memory + 1 + (ROWS - 1 - row) * ROW + (COLUMNS - 1 - column) * STRIDE, values, sizeof values);
        }
    }
    points.scalar = CYLFUSE_SCALAR_F32;
    points.data = memory + 1 + (ROWS - 1) * ROW + (COLUMNS - 1) * STRIDE;
    points.point_stride = -STRIDE;
    points.row_stride = -ROW;
    CHECK(cloud_gives_truth(&points, NULL, 1e-5));
    free(memory);
}

static void clouds_with_masks_and_weights(void)
{
    cylfuse_points_view points = scene_points();
    uint8_t mask_pixels[POINTS];
    double weights[POINTS];
    double moved[POINTS][3];
    memcpy(moved, the_scene.points, sizeof moved);
    for (int k = 0; k < POINTS; k++) {
        /* Every third point is far off, and is masked out or has no weight. */
        mask_pixels[k] = k % 3 != 0;
        weights[k] = k % 3 != 0 ? 1.0 + 0.01 * k : 0.0;
        moved[k][2] += k % 3 != 0 ? 0.0 : 0.3;
    }
    points.data = moved;
    cylfuse_mask_view mask = scene_mask();
    mask.data = mask_pixels;
    mask.width = COLUMNS;
    mask.height = ROWS;
    CHECK(cloud_gives_truth(&points, &mask, 1e-7));
    points.weights = weights;
    CHECK(cloud_gives_truth(&points, NULL, 1e-7));

    cylfuse_fitter *fitter = new_fitter();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, &mask));
    CHECK(counts(fitter).dropped_outside_mask == POINTS / 3);
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK(counts(fitter).dropped_zero_weight == POINTS / 3);
    expect_dropped(fitter, 2 * POINTS, 2 * (POINTS - POINTS / 3));

    /* Weights with a stride of their own. */
    double wide[POINTS][2];
    for (int k = 0; k < POINTS; k++) {
        wide[k][0] = weights[k];
        wide[k][1] = -1.0;
    }
    points.weights = wide;
    points.weight_stride = sizeof wide[0];
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), OK, "");
    points.weight_stride = 0;
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), INVALID_ARGUMENT,
                "the weight of point 1 is -1");
    expect_dropped(fitter, 3 * POINTS, 3 * (POINTS - POINTS / 3));
    mask.height--;
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, &mask), SIZE_MISMATCH, "mask is 30 x 19");
    destroy(fitter);
}

static void points_that_are_not_finite(void)
{
    double moved[POINTS][3];
    memcpy(moved, the_scene.points, sizeof moved);
    moved[5][0] = NAN;
    moved[6][1] = INFINITY;
    moved[7][2] = -INFINITY;
    cylfuse_points_view points = scene_points();
    points.data = moved;
    cylfuse_fitter *fitter = new_camera_fitter();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK(counts(fitter).dropped_not_finite == 3);
    expect_dropped(fitter, POINTS, POINTS - 3);
    cylfuse_result result = fit(fitter);
    CHECK(found_truth(fitter, 1e-8));
    CHECK((result.flags & CYLFUSE_RESULT_FLAGS_POINTS_NOT_FINITE) != 0);
    CHECK(result.points_used == POINTS - 3 && result.points_given == POINTS);
    destroy(fitter);
}

static void views_that_cannot_be(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_points_view points = scene_points();
    points.point_stride = 3;
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), INVALID_ARGUMENT,
                "points.data: the stride of a point is 3; it must be at least 24 bytes");
    points = scene_points();
    points.row_stride = COLUMNS;
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), INVALID_ARGUMENT,
                "points.data: the stride of a row is 30; it must be at least 720 bytes");
    ptrdiff_t huge[4] = {PTRDIFF_MAX, PTRDIFF_MIN, PTRDIFF_MAX / 2, PTRDIFF_MIN / 2};
    for (int k = 0; k < 4; k++) {
        points = scene_points();
        points.point_stride = huge[k];
        CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), INVALID_ARGUMENT, "fit into memory");
        points = scene_points();
        points.row_stride = huge[k];
        CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), INVALID_ARGUMENT, "fit into memory");
        points = scene_points();
        points.weights = the_scene.points;
        points.weight_stride = huge[k];
        CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), INVALID_ARGUMENT, "points.weights");
        cylfuse_segments_view edges = scene_edges();
        edges.segment_stride = huge[k];
        if (edges.segment_stride < PTRDIFF_MIN / 2 || edges.segment_stride > PTRDIFF_MAX / 2) {
            CHECK_ERROR(fitter, cylfuse_fitter_push_edges(fitter, &edges), INVALID_ARGUMENT, "segments.data");
        }
        cylfuse_depth_view depth = scene_depth();
        depth.row_stride = huge[k];
        CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, NULL), INVALID_ARGUMENT, "depth.data");
        depth = scene_depth();
        depth.pixel_stride = huge[k];
        CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, NULL), INVALID_ARGUMENT, "depth.data");
        depth = scene_depth();
        cylfuse_mask_view mask = scene_mask();
        mask.row_stride = huge[k];
        CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, &mask), INVALID_ARGUMENT, "mask.data");
    }
    points = scene_points();
    points.width = SIZE_MAX;
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), INVALID_ARGUMENT, "fit into memory");
    points.height = SIZE_MAX;
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), INVALID_ARGUMENT, "fit into memory");
    cylfuse_segments_view edges = scene_edges();
    edges.count = SIZE_MAX / 32;
    CHECK_ERROR(fitter, cylfuse_fitter_push_edges(fitter, &edges), INVALID_ARGUMENT, "fit into memory");
    CHECK(counts(fitter).points_given == 0 && counts(fitter).segments_given == 0);
    destroy(fitter);
}

void test_points(void)
{
    clouds_of_any_stride();
    clouds_with_masks_and_weights();
    points_that_are_not_finite();
    views_that_cannot_be();
}

static void depth_images_of_either_format(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    expect_dropped(fitter, PIXELS, the_scene.mask_pixels);
    CHECK(counts(fitter).dropped_outside_mask == PIXELS - the_scene.mask_pixels);
    CHECK(fits_truth(fitter, 1e-5));

    /* 16 bits in tenths of a millimetre, every other pixel of rows that have 6 bytes to spare. */
    enum { ROW = 4 * WIDTH + 6 };
    uint8_t *memory = exactly(HEIGHT * ROW);
    for (int k = 0; k < PIXELS; k++) {
        uint16_t value = (uint16_t)lround(the_scene.depth[k] * 1e4f);
        memcpy(memory + k / WIDTH * ROW + k % WIDTH * 4, &value, sizeof value);
    }
    depth.format = CYLFUSE_DEPTH_FORMAT_U16;
    depth.data = memory;
    depth.row_stride = ROW;
    depth.pixel_stride = 4;
    depth.scale = 1e-4;
    CHECK_OK(cylfuse_fitter_clear(fitter));
    CHECK(counts(fitter).points_given == 0);
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    CHECK(fits_truth(fitter, 2e-3));

    /* Without a mask the range of depths tells the cylinder from the wall behind it. */
    depth.max_depth = 1.5;
    CHECK_OK(cylfuse_fitter_clear(fitter));
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, NULL));
    CHECK(counts(fitter).dropped_out_of_range == PIXELS - the_scene.mask_pixels);
    CHECK(fits_truth(fitter, 2e-3));
    free(memory);
    destroy(fitter);
}

static void depth_images_that_are_refused(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_points_view points = scene_points();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    mask.width--;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, &mask), SIZE_MISMATCH,
                "mask is 159 x 120 but depth image is 160 x 120");
    uint8_t *nothing = exactly(PIXELS);
    memset(nothing, 0, PIXELS);
    mask = scene_mask();
    mask.data = nothing;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, &mask), EMPTY_MASK, "all 160 x 120 pixels");
    free(nothing);
    depth.height--;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, NULL), SIZE_MISMATCH, "depth image is 160 x 119");
    depth.height = 0;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, NULL), SIZE_MISMATCH, "depth image is 160 x 0");

    double bad[4] = {0.0, -1.0, NAN, INFINITY};
    for (int k = 0; k < 4; k++) {
        depth = scene_depth();
        depth.scale = bad[k];
        CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, NULL), INVALID_ARGUMENT, "depth scale is");
    }
    depth = scene_depth();
    depth.min_depth = NAN;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, NULL), INVALID_ARGUMENT, "minimal depth is NaN");
    depth.min_depth = 2.0;
    depth.max_depth = 1.0;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, NULL), INVALID_ARGUMENT, "maximal depth is 1");
    float *zeros = exactly(sizeof(float) * PIXELS);
    memset(zeros, 0, sizeof(float) * PIXELS);
    depth = scene_depth();
    depth.data = zeros;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, NULL), NO_DEPTH, "none of the 19200 pixels");
    free(zeros);
    expect_dropped(fitter, POINTS, POINTS);
    CHECK(fits_truth(fitter, 1e-9));
    destroy(fitter);
}

void test_depth(void)
{
    depth_images_of_either_format();
    depth_images_that_are_refused();
}

static void limb_samples_lie_on_the_limbs(cylfuse_fitter *fitter)
{
    size_t count = 0;
    CHECK_ERROR(fitter, cylfuse_fitter_limb_samples(fitter, NULL, sizeof(cylfuse_limb_sample), 0, &count), BUFFER_TOO_SMALL, "out holds 0");
    CHECK(count >= 6);
    cylfuse_limb_sample *samples = exactly(count * sizeof *samples);
    CHECK_STATUS(cylfuse_fitter_limb_samples(fitter, samples, sizeof(cylfuse_limb_sample), count - 1, &count), BUFFER_TOO_SMALL);
    CHECK_ERROR(fitter, cylfuse_fitter_limb_samples(fitter, NULL, sizeof(cylfuse_limb_sample), count, &count), NULL_POINTER, "out is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_limb_samples(fitter, samples, sizeof(cylfuse_limb_sample), count, &count), OK, "");
    int used[2] = {0, 0};
    for (size_t k = 0; k < count; k++) {
        CHECK(samples[k].limb <= 1 && samples[k].view == 0 && samples[k].deviation > 0.0);
        CHECK(samples[k].weight >= 0.0 && samples[k].weight <= 1.0);
        if (samples[k].weight == 0.0) {
            continue;
        }
        used[samples[k].limb]++;
        /* On one of the two lines that bound the cylinder. */
        double nearest = INFINITY;
        for (int side = 0; side < 2; side++) {
            const double *e = the_scene.edges[side];
            double length = hypot(e[2] - e[0], e[3] - e[1]);
            double x = samples[k].pixel[0] - e[0], y = samples[k].pixel[1] - e[1];
            nearest = fmin(nearest, fabs(x * (e[3] - e[1]) - y * (e[2] - e[0])) / length);
        }
        CHECK(nearest < 0.5);
    }
    CHECK(used[0] >= 3 && used[1] >= 3);
    free(samples);
}

static void images_of_any_format_and_stride(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    CHECK_OK(cylfuse_fitter_clear(fitter));
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    /* An edge that is a pixel off: the image knows better. */
    cylfuse_segments_view edges = scene_edges();
    double moved[2][4];
    memcpy(moved, the_scene.edges, sizeof moved);
    moved[0][1] += 1.0;
    moved[0][3] += 1.0;
    edges.data = moved;
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    cylfuse_result without = fit(fitter);
    CHECK(without.limbs_located == 0);
    size_t samples = 9;
    CHECK_ERROR(fitter, cylfuse_fitter_limb_samples(fitter, NULL, sizeof(cylfuse_limb_sample), 0, &samples), OK, "");
    CHECK(samples == 0);

    cylfuse_image_view image = scene_image();
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), OK, "");
    cylfuse_result packed = fit(fitter);
    CHECK(packed.limbs_located == 2 && packed.segments_used == 2);
    cylfuse_cylinder_estimate from_packed = cylinder_of(fitter);
    CHECK(packed.cost != without.cost && is_truth(&from_packed.model, 1e-5));
    limb_samples_lie_on_the_limbs(fitter);
    cylfuse_extent extent = {.struct_size = sizeof extent};
    CHECK_OK(cylfuse_fitter_extent(fitter, NULL, NULL, &extent));
    CHECK_NEAR(extent.length, 0.2, 2e-3);

    /* Bottom row first, every third value of rows that have 5 bytes to spare, at an odd address. */
    enum { ROW = 3 * 2 * WIDTH + 5 };
    uint8_t *memory = exactly(HEIGHT * ROW + 1);
    memset(memory, 0xFF, HEIGHT * ROW + 1);
    for (int format = CYLFUSE_IMAGE_FORMAT_U8; format <= CYLFUSE_IMAGE_FORMAT_U16; format++) {
        int size = format == CYLFUSE_IMAGE_FORMAT_U8 ? 1 : 2;
        for (int k = 0; k < PIXELS; k++) {
            uint8_t small = (uint8_t)lround(the_scene.image[k]);
            uint16_t large = (uint16_t)lround(64.0 * the_scene.image[k]);
            uint8_t *at = memory + 1 + (HEIGHT - 1 - k / WIDTH) * ROW + k % WIDTH * 3 * size;
            memcpy(at, size == 1 ? (void *)&small : (void *)&large, (size_t)size);
        }
        image.format = format;
        image.data = memory + 1 + (HEIGHT - 1) * ROW;
        image.row_stride = -ROW;
        image.pixel_stride = 3 * size;
        CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), OK, "");
        cylfuse_result strided = fit(fitter);
        CHECK(strided.limbs_located == 2);
        CHECK_NEAR(cylinder_of(fitter).model.radius, from_packed.model.radius, 2e-5);
    }
    free(memory);

    /* Coded with a gamma. */
    image = scene_image();
    CHECK(image.gamma == 1.0);
    float *coded = exactly(sizeof the_scene.image);
    for (int k = 0; k < PIXELS; k++) {
        coded[k] = (float)pow(the_scene.image[k], 1.0 / 2.2);
    }
    image.data = coded;
    image.gamma = 2.2;
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), OK, "");
    CHECK_NEAR(fit_cylinder(fitter).model.radius, from_packed.model.radius, 1e-8);
    image.gamma = 1.0;
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), OK, "");
    CHECK(fit_cylinder(fitter).model.radius != from_packed.model.radius);
    free(coded);

    /* The segments as they are, by an option. */
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.edge_use = CYLFUSE_EDGE_USE_AS_GIVEN;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    cylfuse_result given = fit(fitter);
    CHECK(given.limbs_located == 0 && found_truth(fitter, 1e-5));
    /* Clearing forgets the image. */
    options.edge_use = CYLFUSE_EDGE_USE_REFINE;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    CHECK_OK(cylfuse_fitter_clear(fitter));
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    CHECK(fit(fitter).limbs_located == 0);
    destroy(fitter);
}

static void images_that_are_refused(void)
{
    cylfuse_image_view image = scene_image();
    cylfuse_fitter *blind = new_fitter();
    CHECK_ERROR(blind, cylfuse_fitter_push_image(blind, &image), BAD_STATE,
                "pushing an image needs intrinsics; set the intrinsics first");
    destroy(blind);

    cylfuse_fitter *fitter = new_full_fitter();
    image.width--;
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), SIZE_MISMATCH,
                "image is 159 x 120 but the image of the intrinsics is 160 x 120");
    image.width = 0;
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), SIZE_MISMATCH, "image is 0 x 120");
    image = scene_image();
    image.format = 8;
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), INVALID_ARGUMENT,
                "image.format is 8; it must be 1 (U8), 2 (U16), 3 (F32), 4 (RGB8)");
    image = scene_image();
    image.pixel_stride = 3;
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), INVALID_ARGUMENT,
                "image.data: the stride of a pixel is 3; it must be at least 4 bytes");
    image = scene_image();
    image.row_stride = WIDTH;
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), INVALID_ARGUMENT,
                "image.data: the stride of a row is 160; it must be at least 640 bytes");
    ptrdiff_t huge[2] = {PTRDIFF_MAX, PTRDIFF_MIN};
    for (int k = 0; k < 2; k++) {
        image = scene_image();
        image.row_stride = huge[k];
        CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), INVALID_ARGUMENT, "fit into memory");
    }
    double gammas[4] = {0.0, -1.0, 10.5, NAN};
    for (int k = 0; k < 4; k++) {
        image = scene_image();
        image.gamma = gammas[k];
        CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), INVALID_ARGUMENT,
                    "it must lie in [0.1, 10]; 1 = linear in light, 2.2 = sRGB");
    }
    image = scene_image();
    float *bad = copy_of(the_scene.image, sizeof the_scene.image);
    bad[3 * WIDTH + 7] = NAN;
    image.data = bad;
    CHECK_ERROR(fitter, cylfuse_fitter_push_image(fitter, &image), INVALID_ARGUMENT,
                "image value at column 7, row 3 is NaN");
    free(bad);
    CHECK(fit(fitter).limbs_located == 0);
    destroy(fitter);
}

void test_image(void)
{
    images_of_any_format_and_stride();
    images_that_are_refused();
}

void test_edges(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_points_view points = scene_points();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));

    /* As from a line detector: floats, here in elements of 20 bytes, the third one without weight. */
    float lines[3][5] = {{0}};
    double weights[3] = {1.0, 0.5, 0.0};
    for (int k = 0; k < 2; k++) {
        for (int c = 0; c < 4; c++) {
            lines[k][c] = (float)the_scene.edges[k][c];
        }
    }
    cylfuse_segments_view edges = scene_edges();
    edges.scalar = CYLFUSE_SCALAR_F32;
    edges.data = lines;
    edges.count = 3;
    edges.segment_stride = sizeof lines[0];
    edges.weights = weights;
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    CHECK(counts(fitter).segments_given == 3);
    cylfuse_result result = fit(fitter);
    CHECK(result.segments_used == 2 && result.segments_given == 3);
    CHECK(found_truth(fitter, 1e-5));

    double bad[2][4] = {{1.0, 2.0, 3.0, 4.0}, {1.0, NAN, 3.0, 4.0}};
    edges = scene_edges();
    edges.data = bad;
    CHECK_ERROR(fitter, cylfuse_fitter_push_edges(fitter, &edges), INVALID_ARGUMENT,
                "a coordinate of edge segment 1 is NaN");
    edges = scene_edges();
    weights[1] = -2.0;
    edges.weights = weights;
    CHECK_ERROR(fitter, cylfuse_fitter_push_edges(fitter, &edges), INVALID_ARGUMENT,
                "the weight of edge segment 1 is -2");
    edges.segment_stride = 4;
    CHECK_ERROR(fitter, cylfuse_fitter_push_edges(fitter, &edges), INVALID_ARGUMENT, "the stride of a segment is 4");
    CHECK(counts(fitter).segments_given == 3);
    destroy(fitter);
}

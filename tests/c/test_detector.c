/* All cylinders of a scene: two of them before a wall. What is found. */
#include "detector.h"

static const cylfuse_cylinder TRUTHS[CYLINDERS] = {
    {{-0.12, 0.0, 0.7}, {0.1, 0.99, 0.1}, 0.05},
    {{0.13, 0.05, 0.8}, {0.9, 0.3, 0.2}, 0.035},
};
static const double HALVES[CYLINDERS] = {0.12, 0.1};

/* What a camera delivers of the scene, and the same as a cloud. */
cylfuse_intrinsics pair_camera;
static float depths[ALL];
static uint8_t image_pixels[ALL];
static double points[ALL][3];
static int owners[ALL];

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The depth at which a ray (x, y, 1) meets the near wall of a cylinder between its ends; 0 when it does not. */
static double near_wall(const cylfuse_cylinder *model, double half, double x, double y)
{
    double ray[3] = {x, y, 1.0}, across[3], offset[3];
    double norm = sqrt(dot(model->direction, model->direction));
    double along = dot(ray, model->direction) / norm, start = dot(model->point, model->direction) / norm;
    for (int k = 0; k < 3; k++) {
        across[k] = ray[k] - along * model->direction[k] / norm;
        offset[k] = model->point[k] - start * model->direction[k] / norm;
    }
    double a = dot(across, across), b = dot(across, offset);
    double root = b * b - a * (dot(offset, offset) - model->radius * model->radius);
    if (root < 0.0) {
        return 0.0;
    }
    double t = (b - sqrt(root)) / a;
    return fabs(t * along - start) <= half ? t : 0.0;
}

/* The depth at a place of the image, and who is seen there: 0 the wall, then the cylinders. */
static double seen(double column, double row, int *owner)
{
    double x = (column - pair_camera.cx) / pair_camera.fx, y = (row - pair_camera.cy) / pair_camera.fy;
    double depth = 1.2 / (1.0 + 0.1 * x - 0.2 * y);
    *owner = 0;
    for (int k = 0; k < CYLINDERS; k++) {
        double z = near_wall(&TRUTHS[k], HALVES[k], x, y);
        if (z > 0.0 && z < depth) {
            depth = z;
            *owner = k + 1;
        }
    }
    return depth;
}

void make_pair(void)
{
    CHECK_OK(cylfuse_intrinsics_init(&pair_camera, sizeof pair_camera));
    pair_camera.width = WIDE;
    pair_camera.height = HIGH;
    pair_camera.fx = pair_camera.fy = 170.0;
    pair_camera.cx = 79.5;
    pair_camera.cy = 59.5;
    uint32_t state = 1;
    for (int k = 0; k < ALL; k++) {
        int column = k % WIDE, row = k / WIDE, bright = 0;
        double z = seen(column, row, &owners[k]);
        for (int ray = 0; ray < 16; ray++) {
            int owner;
            seen(column + (ray % 4 - 1.5) / 4.0, row + (ray / 4 - 1.5) / 4.0, &owner);
            bright += owner > 0;
        }
        image_pixels[k] = (uint8_t)(40 + 10 * bright);
        /* Errors of up to 1 mm, evenly spread. */
        state = state * 1664525u + 1013904223u;
        depths[k] = (float)(z + 0.001 * (state / 2147483648.0 - 1.0));
        points[k][0] = depths[k] * (column - pair_camera.cx) / pair_camera.fx;
        points[k][1] = depths[k] * (row - pair_camera.cy) / pair_camera.fy;
        points[k][2] = depths[k];
    }
}

cylfuse_depth_view pair_depth(void)
{
    cylfuse_depth_view depth;
    CHECK_OK(cylfuse_depth_view_init(&depth, sizeof depth));
    depth.format = CYLFUSE_DEPTH_FORMAT_F32;
    depth.data = depths;
    depth.width = WIDE;
    depth.height = HIGH;
    return depth;
}

cylfuse_points_view pair_points(void)
{
    cylfuse_points_view view;
    CHECK_OK(cylfuse_points_view_init(&view, sizeof view));
    view.scalar = CYLFUSE_SCALAR_F64;
    view.data = points;
    view.width = WIDE;
    view.height = HIGH;
    return view;
}

cylfuse_frame *pair_frame(int with_image)
{
    cylfuse_frame *frame = NULL;
    CHECK_OK(cylfuse_frame_create(CYLFUSE_ABI_VERSION, &frame));
    CHECK_OK(cylfuse_frame_set_intrinsics(frame, &pair_camera));
    cylfuse_depth_view depth = pair_depth();
    CHECK_OK(cylfuse_frame_set_depth(frame, &depth));
    if (with_image) {
        cylfuse_image_view image;
        CHECK_OK(cylfuse_image_view_init(&image, sizeof image));
        image.format = CYLFUSE_IMAGE_FORMAT_U8;
        image.data = image_pixels;
        image.width = WIDE;
        image.height = HIGH;
        CHECK_OK(cylfuse_frame_set_image(frame, &image));
    }
    return frame;
}

cylfuse_detector *new_detector(void)
{
    cylfuse_detector *detector = NULL;
    CHECK_OK(cylfuse_detector_create(CYLFUSE_ABI_VERSION, &detector));
    return detector;
}

cylfuse_detector_options default_options(void)
{
    cylfuse_detector_options options;
    CHECK_OK(cylfuse_detector_options_init(&options, sizeof options));
    return options;
}

size_t count_of(const cylfuse_detector *detector)
{
    size_t count = 99;
    CHECK_OK(cylfuse_detector_count(detector, &count));
    return count;
}

/* The number of the cylinder that a model is, from 0; -1 for none. */
static int which(const cylfuse_cylinder *model, double tolerance)
{
    for (int k = 0; k < CYLINDERS; k++) {
        double angle, distance, radius;
        CHECK_OK(cylfuse_cylinder_compare(&TRUTHS[k], model, &angle, &distance, &radius));
        if (angle < tolerance && distance < tolerance * TRUTHS[k].radius && fabs(radius) < tolerance) {
            return k;
        }
    }
    printf("radius %g is none of them\n", model->radius);
    return -1;
}

/* Reads all that a detector says of a scene with both cylinders, and checks one thing against another. */
static void check_scene(const cylfuse_detector *detector, double tolerance, int with_points)
{
    size_t count = 0, labelled = 0;
    cylfuse_detection list[CYLINDERS];
    if (!CHECK(count_of(detector) == CYLINDERS)) {
        return;
    }
    CHECK_OK(cylfuse_detector_detections(detector, list, sizeof list[0], CYLINDERS, &count));
    CHECK(count == CYLINDERS && list[0].score >= list[1].score && list[1].score >= 0.5 && list[0].score <= 1.0);
    uint16_t *labels = exactly(ALL * sizeof *labels);
    CHECK_OK(cylfuse_detector_labels(detector, labels, ALL, &count));
    CHECK(count == ALL);
    int found = 0;
    for (size_t index = 0; index < CYLINDERS; index++) {
        int truth = which(&list[index].model, tolerance);
        if (truth < 0) {
            CHECK(0);
            continue;
        }
        found |= 1 << truth;
        size_t pixels = (size_t)list[index].pixels, own = 0;
        uint32_t *indices = exactly(pixels * sizeof *indices);
        CHECK_OK(cylfuse_detector_indices(detector, index, indices, pixels, &count));
        CHECK(count == pixels && pixels > 300);
        for (size_t k = 0; k < count; k++) {
            CHECK(indices[k] < ALL && labels[indices[k]] == index + 1 && (k == 0 || indices[k] > indices[k - 1]));
            own += owners[indices[k]] == truth + 1;
        }
        CHECK(own > 0.95 * count);
        labelled += count;
        free(indices);

        cylfuse_result result;
        cylfuse_cylinder_estimate estimate;
        cylfuse_extent extent;
        CHECK_OK(cylfuse_result_init(&result, sizeof result));
        CHECK_OK(cylfuse_cylinder_estimate_init(&estimate, sizeof estimate));
        CHECK_OK(cylfuse_extent_init(&extent, sizeof extent));
        CHECK_OK(cylfuse_detector_get_result(detector, index, &result));
        CHECK_OK(cylfuse_detector_get_cylinder(detector, index, &estimate));
        CHECK(memcmp(&estimate.model, &list[index].model, sizeof estimate.model) == 0);
        CHECK(estimate.start_kind == CYLFUSE_START_MODEL && estimate.radius_deviation > 0.0);
        CHECK(result.points_used > 0 && result.points_used <= pixels);
        CHECK_OK(cylfuse_detector_get_extent(detector, index, &extent));
        CHECK_NEAR(extent.length, 2.0 * HALVES[truth], 0.1 * HALVES[truth]);
        CHECK((extent.end_source == CYLFUSE_END_SOURCE_POINTS) == with_points);
    }
    CHECK(found == (1 << CYLINDERS) - 1);
    for (int k = 0; k < ALL; k++) {
        CHECK(labels[k] <= CYLINDERS);
        labelled -= labels[k] != 0;
    }
    CHECK(labelled == 0);
    free(labels);
}

static void cylinders_of_a_frame(void)
{
    cylfuse_detector *detector = new_detector();
    cylfuse_frame *frame = pair_frame(1), *without = pair_frame(0);
    CHECK_OK(cylfuse_detector_detect(detector, frame));
    CHECK(cylfuse_detector_last_error(detector)[0] == '\0');
    check_scene(detector, 0.01, 0);
    cylfuse_result result;
    CHECK_OK(cylfuse_result_init(&result, sizeof result));
    CHECK_OK(cylfuse_detector_get_result(detector, 0, &result));
    CHECK(result.limbs_located == 2);

    /* The image is not looked at: as if there were none. */
    cylfuse_detection ignored[CYLINDERS], missing[CYLINDERS];
    size_t count = 0;
    cylfuse_detector_options options = default_options();
    options.image_use = CYLFUSE_IMAGE_USE_IGNORE;
    CHECK_OK(cylfuse_detector_set_options(detector, &options));
    CHECK_OK(cylfuse_detector_detect(detector, frame));
    check_scene(detector, 0.1, 0);
    CHECK_OK(cylfuse_detector_detections(detector, ignored, sizeof ignored[0], CYLINDERS, &count));
    options = default_options();
    CHECK_OK(cylfuse_detector_set_options(detector, &options));
    CHECK_OK(cylfuse_detector_detect(detector, without));
    CHECK_OK(cylfuse_detector_detections(detector, missing, sizeof missing[0], CYLINDERS, &count));
    CHECK(count == CYLINDERS && memcmp(ignored, missing, sizeof missing) == 0);

    /* In the reference frame. */
    static const double TURN[9] = {0.8, 0.0, 0.6, 0.0, 1.0, 0.0, -0.6, 0.0, 0.8}, SHIFT[3] = {-0.5, 0.1, 0.2};
    CHECK_OK(cylfuse_frame_set_pose(without, TURN, SHIFT));
    CHECK_OK(cylfuse_detector_detect(detector, without));
    cylfuse_detection turned[CYLINDERS];
    CHECK_OK(cylfuse_detector_detections(detector, turned, sizeof turned[0], CYLINDERS, &count));
    for (size_t k = 0; k < count; k++) {
        cylfuse_cylinder there = missing[k].model;
        for (int i = 0; i < 3; i++) {
            there.point[i] = SHIFT[i] + dot(TURN + 3 * i, missing[k].model.point);
            there.direction[i] = dot(TURN + 3 * i, missing[k].model.direction);
        }
        double angle, distance, radius;
        CHECK_OK(cylfuse_cylinder_compare(&there, &turned[k].model, &angle, &distance, &radius));
        CHECK(angle < 1e-9 && distance < 1e-9 && fabs(radius) < 1e-9);
    }

    /* Nothing of a frame is needed any more. */
    CHECK_OK(cylfuse_frame_destroy(without));
    CHECK_OK(cylfuse_frame_destroy(frame));
    CHECK(count_of(detector) == CYLINDERS);
    CHECK_OK(cylfuse_detector_destroy(detector));
}

static void cylinders_of_a_cloud(void)
{
    cylfuse_detector *detector = new_detector();
    cylfuse_points_view view = pair_points();
    CHECK_OK(cylfuse_detector_detect_points(detector, &view));
    check_scene(detector, 0.1, 1);

    /* Not organised, float, one after the other with other things between them, and weights. */
    struct {
        float xyz[3], weight, other[2];
    } *mixed = exactly(ALL * sizeof *mixed);
    for (int k = 0; k < ALL; k++) {
        for (int i = 0; i < 3; i++) {
            mixed[k].xyz[i] = (float)points[k][i];
        }
        mixed[k].weight = 1.0f;
    }
    view.scalar = CYLFUSE_SCALAR_F32;
    view.data = mixed;
    view.width = ALL;
    view.height = 1;
    view.point_stride = view.weight_stride = sizeof *mixed;
    view.weights = &mixed[0].weight;
    CHECK_OK(cylfuse_detector_detect_points(detector, &view));
    check_scene(detector, 0.1, 1);

    /* Weights of 0 leave points out: all but those of the wall and the first cylinder. */
    for (int k = 0; k < ALL; k++) {
        mixed[k].weight = owners[k] == 2 ? 0.0f : 2.0f;
    }
    CHECK_OK(cylfuse_detector_detect_points(detector, &view));
    CHECK(count_of(detector) == 1);
    mixed[7].weight = -1.0f;
    CHECK_ERROR(NULL, cylfuse_detector_detect_points(detector, &view), INVALID_ARGUMENT, "the weight of point 7 is -1");
    CHECK(count_of(detector) == 1);
    free(mixed);
    CHECK_OK(cylfuse_detector_destroy(detector));
}

static void a_fitter_goes_on(void)
{
    cylfuse_detector *detector = new_detector();
    cylfuse_frame *frame = pair_frame(1);
    CHECK_OK(cylfuse_detector_detect(detector, frame));
    cylfuse_fitter *fitter = NULL;
    CHECK_OK(cylfuse_detector_make_fitter(detector, 1, &fitter));
    cylfuse_cylinder_estimate estimate, kept = cylinder_of(fitter);
    cylfuse_extent extent, own;
    CHECK_OK(cylfuse_cylinder_estimate_init(&estimate, sizeof estimate));
    CHECK_OK(cylfuse_extent_init(&extent, sizeof extent));
    CHECK_OK(cylfuse_extent_init(&own, sizeof own));
    CHECK_OK(cylfuse_detector_get_cylinder(detector, 1, &estimate));
    CHECK_OK(cylfuse_detector_get_extent(detector, 1, &extent));
    cylfuse_detection list[CYLINDERS];
    size_t count = 0;
    CHECK_OK(cylfuse_detector_detections(detector, list, sizeof list[0], CYLINDERS, &count));
    CHECK_OK(cylfuse_detector_destroy(detector));
    CHECK_OK(cylfuse_frame_destroy(frame));

    /* Result, limbs, mask and image are there. */
    CHECK(memcmp(&estimate, &kept, sizeof kept) == 0);
    CHECK_OK(cylfuse_fitter_extent(fitter, NULL, NULL, &own));
    CHECK(memcmp(&extent, &own, sizeof own) == 0);
    cylfuse_limb limbs[2];
    CHECK_OK(cylfuse_fitter_limbs(fitter, limbs, sizeof limbs[0], 2, &count));
    CHECK(limbs[0].status == CYLFUSE_LIMB_STATUS_LOCATED && limbs[1].status == CYLFUSE_LIMB_STATUS_LOCATED);
    CHECK_OK(cylfuse_fitter_complete_bound(fitter, NULL, CYLFUSE_LAYOUT_PACKED, &count));
    CHECK(count == list[1].pixels);
    CHECK_STATUS(cylfuse_fitter_residuals(fitter, NULL, CYLFUSE_RESIDUAL_KIND_POINTS, NULL, 0, &count), BUFFER_TOO_SMALL);
    CHECK(count == counts(fitter).points_used && count <= list[1].pixels);
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    CHECK_OK(cylfuse_fitter_get_options(fitter, &options));
    CHECK(options.start == CYLFUSE_START_MODEL && options.max_threads == 1);
    /* The same fit once more. */
    cylfuse_cylinder_estimate again = fit_cylinder(fitter);
    CHECK(memcmp(&again.model, &kept.model, sizeof kept.model) == 0);
    destroy(fitter);

    /* Of a cloud. */
    detector = new_detector();
    cylfuse_points_view view = pair_points();
    CHECK_OK(cylfuse_detector_detect_points(detector, &view));
    CHECK_OK(cylfuse_detector_make_fitter(detector, 0, &fitter));
    CHECK_OK(cylfuse_detector_detections(detector, list, sizeof list[0], CYLINDERS, &count));
    /* Fitted to its whole region: its points share no errors. */
    CHECK(counts(fitter).points_used == list[0].pixels);
    kept = cylinder_of(fitter);
    CHECK(which(&kept.model, 0.1) >= 0);
    destroy(fitter);
    fitter = (cylfuse_fitter *)&the_scene;
    CHECK_ERROR(NULL, cylfuse_detector_make_fitter(detector, 2, &fitter), INVALID_ARGUMENT,
                "index is 2; it must be less than the number of cylinders, 2");
    CHECK(fitter == NULL);
    CHECK_OK(cylfuse_detector_destroy(detector));
}

/* Bumps in both directions, 12 pixels apart: more to look at than a search may. */
static void a_search_that_was_cut_short_says_so(void)
{
    enum { COLUMNS_OF_BUMPS = 640, ROWS_OF_BUMPS = 480 };
    const double step = acos(-1.0) / 6.0;
    float *bumps = exactly(sizeof *bumps * COLUMNS_OF_BUMPS * ROWS_OF_BUMPS);
    for (int k = 0; k < COLUMNS_OF_BUMPS * ROWS_OF_BUMPS; k++) {
        int column = k % COLUMNS_OF_BUMPS, row = k / COLUMNS_OF_BUMPS;
        bumps[k] = (float)(1.0 + 1.2 / 525.0 * sin(step * column) * sin(step * row));
    }
    cylfuse_intrinsics camera = pair_camera;
    cylfuse_depth_view depth = pair_depth();
    camera.width = depth.width = COLUMNS_OF_BUMPS;
    camera.height = depth.height = ROWS_OF_BUMPS;
    camera.fx = camera.fy = 525.0;
    camera.cx = 319.5;
    camera.cy = 239.5;
    depth.data = bumps;
    cylfuse_frame *frame = NULL, *pair = pair_frame(0);
    CHECK_OK(cylfuse_frame_create(CYLFUSE_ABI_VERSION, &frame));
    CHECK_OK(cylfuse_frame_set_intrinsics(frame, &camera));
    CHECK_OK(cylfuse_frame_set_depth(frame, &depth));
    cylfuse_detector *detector = new_detector();
    int32_t complete = -1;
    CHECK_OK(cylfuse_detector_detect(detector, frame));
    CHECK_OK(cylfuse_detector_is_complete(detector, &complete));
    CHECK(complete == 0);
    CHECK_OK(cylfuse_detector_detect(detector, pair));
    CHECK_OK(cylfuse_detector_is_complete(detector, &complete));
    CHECK(complete == 1);
    CHECK_OK(cylfuse_detector_destroy(detector));
    CHECK_OK(cylfuse_frame_destroy(pair));
    CHECK_OK(cylfuse_frame_destroy(frame));
    free(bumps);
}

static void limits_hold(void)
{
    cylfuse_detector *detector = new_detector();
    cylfuse_frame *frame = pair_frame(1);
    cylfuse_points_view view = pair_points();
    cylfuse_detector_options options = default_options(), read;
    CHECK_OK(cylfuse_detector_options_init(&read, sizeof read));
    options.radius_min = 0.04;
    options.radius_max = 0.06;
    options.axis[1] = -3.0;
    for (int cloud = 0; cloud < 2; cloud++) {
        /* Its own axis is 0.141 off. */
        double angle = options.axis_max_angle = cloud ? 0.12 : 0.2;
        CHECK_OK(cylfuse_detector_set_options(detector, &options));
        CHECK_OK(cylfuse_detector_get_options(detector, &read));
        CHECK(memcmp(&read, &options, sizeof read) == 0);
        CHECK_OK(cloud ? cylfuse_detector_detect_points(detector, &view) : cylfuse_detector_detect(detector, frame));
        cylfuse_detection only;
        size_t count = 0;
        CHECK_OK(cylfuse_detector_detections(detector, &only, sizeof only, 1, &count));
        CHECK(count == 1 && fabs(only.model.direction[1]) >= cos(angle + 1e-9) && fabs(only.model.radius - 0.05) < 0.005);
    }
    options = default_options();
    options.max_count = 1;
    CHECK_OK(cylfuse_detector_set_options(detector, &options));
    CHECK_OK(cylfuse_detector_detect(detector, frame));
    CHECK(count_of(detector) == 1);
    options.max_count = 0;
    options.min_pixels = UINT64_MAX;
    CHECK_OK(cylfuse_detector_set_options(detector, &options));
    CHECK_OK(cylfuse_detector_detect(detector, frame));
    CHECK(count_of(detector) == 0);
    CHECK_OK(cylfuse_frame_destroy(frame));
    CHECK_OK(cylfuse_detector_destroy(detector));
}

void test_detector(void)
{
    make_pair();
    cylinders_of_a_frame();
    cylinders_of_a_cloud();
    a_fitter_goes_on();
    a_search_that_was_cut_short_says_so();
    limits_hold();
}

/* Unknown constants and struct sizes. */
#include "check.h"

static void set_unknown_option(cylfuse_fitter *fitter, size_t offset, const char *name)
{
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    for (int32_t value = -1; value <= 1000; value += 1001) {
        memcpy((char *)&options + offset, &value, sizeof value);
        CHECK_ERROR(fitter, cylfuse_fitter_set_options(fitter, &options), INVALID_ARGUMENT, name);
        CHECK(strstr(cylfuse_fitter_last_error(fitter), value == -1 ? "is -1; it must be 0 (" : "is 1000;") != NULL);
    }
}

void test_constants(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    set_unknown_option(fitter, offsetof(cylfuse_options, method), "options.method");
    set_unknown_option(fitter, offsetof(cylfuse_options, objective), "options.objective");
    set_unknown_option(fitter, offsetof(cylfuse_options, start), "options.start");
    set_unknown_option(fitter, offsetof(cylfuse_options, near_wall), "options.near_wall");
    set_unknown_option(fitter, offsetof(cylfuse_options, chart), "options.chart");
    set_unknown_option(fitter, offsetof(cylfuse_options, edge_use), "options.edge_use");
    set_unknown_option(fitter, offsetof(cylfuse_options, extent_rule), "options.extent_rule");

    cylfuse_intrinsics intrinsics = the_scene.intrinsics;
    intrinsics.distortion_model = 3;
    CHECK_ERROR(fitter, cylfuse_fitter_set_intrinsics(fitter, &intrinsics), INVALID_ARGUMENT,
                "intrinsics.distortion_model is 3");
    cylfuse_points_view points = scene_points();
    points.scalar = 0;
    CHECK_ERROR(fitter, cylfuse_fitter_push_points(fitter, &points, NULL), INVALID_ARGUMENT,
                "points.scalar is 0; it must be 1 (F32) or 2 (F64)");
    cylfuse_segments_view edges = scene_edges();
    edges.scalar = 77;
    CHECK_ERROR(fitter, cylfuse_fitter_push_edges(fitter, &edges), INVALID_ARGUMENT, "segments.scalar is 77");
    cylfuse_depth_view depth = scene_depth();
    depth.format = -5;
    CHECK_ERROR(fitter, cylfuse_fitter_push_depth(fitter, &depth, NULL), INVALID_ARGUMENT, "depth.format is -5");
    CHECK_ERROR(fitter, cylfuse_fitter_set_log(fitter, 5, NULL, NULL), INVALID_ARGUMENT, "max_level is 5");

    fit(fitter);
    double values[POINTS];
    size_t count = 7;
    CHECK_ERROR(fitter, cylfuse_fitter_residuals(fitter, NULL, 0, values, POINTS, &count), INVALID_ARGUMENT,
                "kind is 0");
    cylfuse_mask_view mask = scene_mask();
    CHECK_ERROR(fitter, cylfuse_fitter_complete_bound(fitter, &mask, 2, &count), INVALID_ARGUMENT, "layout is 2");
    CHECK(count == 7);
    cylfuse_completion completion = {.struct_size = sizeof completion};
    cylfuse_points_out out;
    CHECK_OK(cylfuse_points_out_init(&out, sizeof out));
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, NULL, &mask, CYLFUSE_LAYOUT_PACKED, &out, &completion), INVALID_ARGUMENT,
                "out.scalar is 0");
    out.scalar = CYLFUSE_SCALAR_F64;
    CHECK_ERROR(fitter, cylfuse_fitter_complete(fitter, NULL, &mask, -1, &out, &completion), INVALID_ARGUMENT,
                "layout is -1");
    cylfuse_depth_out depth_out;
    CHECK_OK(cylfuse_depth_out_init(&depth_out, sizeof depth_out));
    CHECK_ERROR(fitter, cylfuse_fitter_complete_depth(fitter, NULL, &mask, &depth_out, &completion),
                INVALID_ARGUMENT, "out.format is 0");
    CHECK(fits_truth(fitter, 1e-6));
    destroy(fitter);
}

/* A struct that is larger than the library knows it, in memory of exactly its size. */
static void *enlarged(const void *known, size_t size, size_t more, uint8_t last)
{
    uint8_t *bytes = exactly(size + more);
    memset(bytes, 0, size + more);
    memcpy(bytes, known, size);
    bytes[size + more - 1] = last;
    uint32_t struct_size = (uint32_t)(size + more);
    memcpy(bytes, &struct_size, sizeof struct_size);
    return bytes;
}

static void *cut(const void *known, uint32_t struct_size)
{
    uint8_t *bytes = exactly(struct_size < 4 ? 4 : struct_size);
    memcpy(bytes, known, struct_size < 4 ? 4 : struct_size);
    memcpy(bytes, &struct_size, sizeof struct_size);
    return bytes;
}

/* Options before their first field was appended. */
enum { FIRST_OPTIONS = offsetof(cylfuse_options, depth_shared) };

typedef cylfuse_status (*input_call)(cylfuse_fitter *fitter, const void *input);

/* `first` is the size of the first published version: smaller structs are refused, those between are read. */
static void check_input(cylfuse_fitter *fitter, input_call call, const void *known, size_t first, size_t size,
                        const char *name)
{
    for (uint32_t given = 0; given < size; given += given == 0 ? 4 : 1) {
        void *small = cut(known, given);
        if (given < first) {
            CHECK_ERROR(fitter, call(fitter, small), STRUCT_SIZE, name);
        } else {
            CHECK_OK(call(fitter, small));
        }
        free(small);
    }
    for (size_t more = 1; more <= 65; more += 8) {
        void *zeros = enlarged(known, size, more, 0);
        CHECK_OK(call(fitter, zeros));
        free(zeros);
        void *newer = enlarged(known, size, more, 1);
        CHECK_ERROR(fitter, call(fitter, newer), STRUCT_SIZE, name);
        free(newer);
    }
    uint32_t huge[2] = {4097, UINT32_MAX};
    for (int k = 0; k < 2; k++) {
        void *wrong = copy_of(known, size);
        memcpy(wrong, &huge[k], sizeof huge[k]);
        CHECK_ERROR(fitter, call(fitter, wrong), STRUCT_SIZE, name);
        free(wrong);
    }
    /* Any alignment. */
    uint8_t *memory = exactly(size + 1);
    memcpy(memory + 1, known, size);
    CHECK_OK(call(fitter, memory + 1));
    free(memory);
}

static cylfuse_status set_options(cylfuse_fitter *fitter, const void *input)
{
    return cylfuse_fitter_set_options(fitter, input);
}

static cylfuse_status set_intrinsics(cylfuse_fitter *fitter, const void *input)
{
    return cylfuse_fitter_set_intrinsics(fitter, input);
}

static cylfuse_status push_points(cylfuse_fitter *fitter, const void *input)
{
    return cylfuse_fitter_push_points(fitter, input, NULL);
}

static cylfuse_status push_depth(cylfuse_fitter *fitter, const void *input)
{
    return cylfuse_fitter_push_depth(fitter, input, NULL);
}

static cylfuse_status push_mask(cylfuse_fitter *fitter, const void *input)
{
    cylfuse_depth_view depth = scene_depth();
    return cylfuse_fitter_push_depth(fitter, &depth, input);
}

static cylfuse_status push_edges(cylfuse_fitter *fitter, const void *input)
{
    return cylfuse_fitter_push_edges(fitter, input);
}

static cylfuse_status push_image(cylfuse_fitter *fitter, const void *input)
{
    return cylfuse_fitter_push_image(fitter, input);
}

static cylfuse_status complete(cylfuse_fitter *fitter, const void *input)
{
    cylfuse_completion completion = {.struct_size = sizeof completion};
    cylfuse_mask_view mask = scene_mask();
    return cylfuse_fitter_complete(fitter, &the_scene.truth, &mask, CYLFUSE_LAYOUT_PACKED, input, &completion);
}

static cylfuse_status complete_depth(cylfuse_fitter *fitter, const void *input)
{
    cylfuse_completion completion = {.struct_size = sizeof completion};
    cylfuse_mask_view mask = scene_mask();
    return cylfuse_fitter_complete_depth(fitter, &the_scene.truth, &mask, input, &completion);
}

static void inputs_of_any_size(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    check_input(fitter, set_options, &options, FIRST_OPTIONS, sizeof options,
                "options.struct_size is");
    check_input(fitter, set_intrinsics, &the_scene.intrinsics, sizeof the_scene.intrinsics,
                sizeof the_scene.intrinsics,
                "intrinsics.struct_size is");
    cylfuse_points_view points = scene_points();
    points.width = points.height = 1;
    check_input(fitter, push_points, &points, sizeof points, sizeof points, "points.struct_size is");
    cylfuse_depth_view depth = scene_depth();
    check_input(fitter, push_depth, &depth, sizeof depth, sizeof depth, "depth.struct_size is");
    cylfuse_mask_view mask = scene_mask();
    check_input(fitter, push_mask, &mask, sizeof mask, sizeof mask, "mask.struct_size is");
    cylfuse_segments_view edges = scene_edges();
    check_input(fitter, push_edges, &edges, sizeof edges, sizeof edges, "segments.struct_size is");
    cylfuse_image_view image = scene_image();
    check_input(fitter, push_image, &image, sizeof image, sizeof image, "image.struct_size is");
    cylfuse_points_out points_out;
    CHECK_OK(cylfuse_points_out_init(&points_out, sizeof points_out));
    points_out.scalar = CYLFUSE_SCALAR_F32;
    points_out.capacity = the_scene.mask_pixels;
    points_out.data = exactly(12 * points_out.capacity);
    check_input(fitter, complete, &points_out, sizeof points_out, sizeof points_out, "out.struct_size is");
    free(points_out.data);
    cylfuse_depth_out depth_out;
    CHECK_OK(cylfuse_depth_out_init(&depth_out, sizeof depth_out));
    depth_out.format = CYLFUSE_DEPTH_FORMAT_F32;
    depth_out.width = WIDTH;
    depth_out.height = HEIGHT;
    depth_out.data = exactly(4 * PIXELS);
    check_input(fitter, complete_depth, &depth_out, sizeof depth_out, sizeof depth_out, "out.struct_size is");
    free(depth_out.data);

    mask.label = 256;
    CHECK_ERROR(fitter, push_mask(fitter, &mask), INVALID_ARGUMENT, "mask.label is 256; it must lie in [0, 255]");
    destroy(fitter);
}

typedef cylfuse_status (*output_call)(const cylfuse_fitter *fitter, void *output);

static void check_output(const cylfuse_fitter *fitter, output_call call, size_t first, size_t size, const char *name)
{
    uint8_t *whole = exactly(size);
    memset(whole, 0xAA, size);
    uint32_t struct_size = (uint32_t)size;
    memcpy(whole, &struct_size, sizeof struct_size);
    CHECK_ERROR(fitter, call(fitter, whole), OK, "");

    for (uint32_t given = 0; given < size; given += given == 0 ? 4 : 1) {
        void *small = cut(whole, given);
        if (given < first) {
            CHECK_ERROR(fitter, call(fitter, small), STRUCT_SIZE, name);
        } else {
            CHECK_OK(call(fitter, small));
        }
        CHECK(memcmp((uint8_t *)small + 4, whole + 4, given < 4 ? 0 : given - 4) == 0);
        free(small);
    }
    /* A newer program: the size says what was filled, and the rest is zero. */
    uint8_t *newer = exactly(size + 9);
    memset(newer, 0xAA, size + 9);
    struct_size = (uint32_t)size + 9;
    memcpy(newer, &struct_size, sizeof struct_size);
    CHECK_OK(call(fitter, newer));
    struct_size = (uint32_t)size;
    CHECK(memcmp(newer, &struct_size, sizeof struct_size) == 0);
    CHECK(memcmp(newer + 4, whole + 4, size - 4) == 0);
    for (size_t k = 0; k < 9; k++) {
        CHECK(newer[size + k] == 0);
    }
    free(newer);
    uint8_t *unaligned = exactly(size + 1);
    memcpy(unaligned + 1, whole, size);
    CHECK_OK(call(fitter, unaligned + 1));
    CHECK(memcmp(unaligned + 1, whole, size) == 0);
    free(unaligned);
    free(whole);
}

static cylfuse_status get_options(const cylfuse_fitter *fitter, void *output)
{
    return cylfuse_fitter_get_options(fitter, output);
}

static cylfuse_status get_counts(const cylfuse_fitter *fitter, void *output)
{
    return cylfuse_fitter_counts(fitter, output);
}

static cylfuse_status get_result(const cylfuse_fitter *fitter, void *output)
{
    return cylfuse_fitter_get_result(fitter, output);
}

static cylfuse_status get_cylinder(const cylfuse_fitter *fitter, void *output)
{
    return cylfuse_fitter_get_cylinder(fitter, output);
}

static cylfuse_status diagnose(const cylfuse_fitter *fitter, void *output)
{
    return cylfuse_fitter_diagnose(fitter, NULL, output);
}

static cylfuse_status extent(const cylfuse_fitter *fitter, void *output)
{
    return cylfuse_fitter_extent(fitter, NULL, NULL, output);
}

static cylfuse_status completion(const cylfuse_fitter *fitter, void *output)
{
    cylfuse_depth_out out;
    CHECK_OK(cylfuse_depth_out_init(&out, sizeof out));
    out.format = CYLFUSE_DEPTH_FORMAT_U16;
    out.scale = 0.0001;
    out.width = WIDTH;
    out.height = HEIGHT;
    out.data = exactly(2 * PIXELS);
    cylfuse_status status = cylfuse_fitter_complete_depth(fitter, NULL, NULL, &out, output);
    free(out.data);
    return status;
}

static void outputs_of_any_size(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    fit(fitter);
    check_output(fitter, get_options, FIRST_OPTIONS, sizeof(cylfuse_options),
                 "out_options.struct_size is");
    check_output(fitter, get_counts, sizeof(cylfuse_counts), sizeof(cylfuse_counts), "out_counts.struct_size is");
    check_output(fitter, get_result, sizeof(cylfuse_result), sizeof(cylfuse_result),
                 "out_result.struct_size is");
    check_output(fitter, get_cylinder, sizeof(cylfuse_cylinder_estimate), sizeof(cylfuse_cylinder_estimate),
                 "out_estimate.struct_size is");
    check_output(fitter, diagnose, sizeof(cylfuse_cylinder_diagnosis), sizeof(cylfuse_cylinder_diagnosis), "out_diagnosis.struct_size is");
    check_output(fitter, extent, sizeof(cylfuse_extent), sizeof(cylfuse_extent),
                 "out_extent.struct_size is");
    check_output(fitter, completion, sizeof(cylfuse_completion), sizeof(cylfuse_completion), "out_completion.struct_size is");
    destroy(fitter);
}

static void defaults_of_any_size(void)
{
    for (size_t given = 0; given < FIRST_OPTIONS; given++) {
        CHECK_STATUS(cylfuse_options_init((cylfuse_options *)&the_scene, given), STRUCT_SIZE);
    }
    CHECK_STATUS(cylfuse_options_init((cylfuse_options *)&the_scene, 4097), STRUCT_SIZE);
    CHECK_STATUS(cylfuse_options_init((cylfuse_options *)&the_scene, SIZE_MAX), STRUCT_SIZE);
    CHECK(the_scene.truth.radius == 0.05);
    /* What the library does not know becomes 0, so that the struct is accepted afterwards. */
    size_t given = sizeof(cylfuse_options) + 5;
    uint8_t *memory = exactly(given);
    memset(memory, 0xAA, given);
    CHECK_OK(cylfuse_options_init((cylfuse_options *)(void *)memory, given));
    cylfuse_fitter *fitter = new_fitter();
    CHECK_OK(set_options(fitter, memory));
    destroy(fitter);
    free(memory);
}

/* The checks above hand on a fitter; where there is none, they read the text of this thread. */
static cylfuse_detector *of_detector;

static cylfuse_status set_detector_options(cylfuse_fitter *none, const void *input)
{
    (void)none;
    return cylfuse_detector_set_options(of_detector, input);
}

static cylfuse_status set_fit_options(cylfuse_fitter *none, const void *input)
{
    (void)none;
    return cylfuse_detector_set_fit_options(of_detector, input);
}

static cylfuse_status get_detector_options(const cylfuse_fitter *none, void *output)
{
    (void)none;
    return cylfuse_detector_get_options(of_detector, output);
}

static cylfuse_status get_fit_options(const cylfuse_fitter *none, void *output)
{
    (void)none;
    return cylfuse_detector_get_fit_options(of_detector, output);
}

static void structs_of_a_detector(void)
{
    cylfuse_detector_options options;
    cylfuse_options fits;
    CHECK_OK(cylfuse_detector_create(CYLFUSE_ABI_VERSION, &of_detector));
    CHECK_OK(cylfuse_detector_options_init(&options, sizeof options));
    CHECK_OK(cylfuse_options_init(&fits, sizeof fits));
    check_input(NULL, set_detector_options, &options, sizeof options, sizeof options, "options.struct_size is");
    check_input(NULL, set_fit_options, &fits, FIRST_OPTIONS, sizeof fits, "options.struct_size is");
    check_output(NULL, get_detector_options, sizeof options, sizeof options, "out_options.struct_size is");
    check_output(NULL, get_fit_options, FIRST_OPTIONS, sizeof fits, "out_options.struct_size is");
    CHECK_STATUS(cylfuse_detector_options_init(&options, sizeof options - 1), STRUCT_SIZE);
    CHECK_STATUS(cylfuse_detector_options_init(&options, 4097), STRUCT_SIZE);
    CHECK_OK(cylfuse_detector_destroy(of_detector));
}

void test_struct_sizes(void)
{
    inputs_of_any_size();
    outputs_of_any_size();
    defaults_of_any_size();
    structs_of_a_detector();
}

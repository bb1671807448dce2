/* A program of the first frozen release: what it was compiled to then must run with every later library of the same soname.
   See docs/abi.md. It only uses what the header of that release has, and prints one line. */

#include <cylfuse/cylfuse.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition)                                                       \
    do {                                                                       \
        if (!(condition)) {                                                    \
            fprintf(stderr, "client.c:%d: %s\n", __LINE__, #condition);        \
            exit(1);                                                           \
        }                                                                      \
    } while (0)
#define OK(call) CHECK((call) == CYLFUSE_STATUS_OK)

enum { WIDTH = 160, HEIGHT = 120 };

/* A pipe of radius 50 mm across the view, 0.6 m away, in tenths of millimetres. */
static uint16_t depth[HEIGHT][WIDTH];
static uint8_t mask[HEIGHT][WIDTH];
static uint8_t image[HEIGHT][WIDTH];

static void draw(void) {
    for (int v = 0; v < HEIGHT; v++) {
        for (int u = 0; u < WIDTH; u++) {
            double x = (u - 79.5) / 150;
            double a = x * x + 1, b = 0.6, c = 0.36 - 0.0025, root = b * b - a * c;
            image[v][u] = 40;
            if (root < 0) {
                continue;
            }
            double z = (b - sqrt(root)) / a;
            depth[v][u] = (uint16_t)(z * 10000 + 0.5);
            mask[v][u] = 1;
            image[v][u] = 160;
        }
    }
}

static int steps;

static int32_t hear(const cylfuse_progress *progress, void *user_data) {
    CHECK(user_data == &steps && progress->struct_size >= sizeof *progress);
    steps++;
    return 0;
}

int main(void) {
    CHECK(cylfuse_abi_version() == CYLFUSE_ABI_VERSION);
    CHECK(cylfuse_version_number() >= CYLFUSE_VERSION_NUMBER);
    CHECK(strstr(cylfuse_status_string(CYLFUSE_STATUS_BUSY), "BUSY") != NULL);
    draw();

    cylfuse_fitter *fitter;
    OK(cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &fitter));
    cylfuse_options options;
    OK(cylfuse_options_init(&options, sizeof options));
    CHECK(options.struct_size == sizeof options && options.edge_weight == 0.6 && options.max_iterations == 400);
    options.radius_max = 1;
    OK(cylfuse_fitter_set_options(fitter, &options));
    OK(cylfuse_fitter_set_progress(fitter, hear, &steps));

    cylfuse_intrinsics intrinsics;
    OK(cylfuse_intrinsics_init(&intrinsics, sizeof intrinsics));
    intrinsics.width = WIDTH;
    intrinsics.height = HEIGHT;
    intrinsics.fx = intrinsics.fy = 150;
    intrinsics.cx = 79.5;
    intrinsics.cy = 59.5;
    OK(cylfuse_fitter_set_intrinsics(fitter, &intrinsics));

    cylfuse_depth_view depth_view;
    OK(cylfuse_depth_view_init(&depth_view, sizeof depth_view));
    depth_view.format = CYLFUSE_DEPTH_FORMAT_U16;
    depth_view.data = depth;
    depth_view.width = WIDTH;
    depth_view.height = HEIGHT;
    depth_view.scale = 0.0001;
    cylfuse_mask_view mask_view;
    OK(cylfuse_mask_view_init(&mask_view, sizeof mask_view));
    mask_view.data = &mask[0][0];
    mask_view.width = WIDTH;
    mask_view.height = HEIGHT;
    OK(cylfuse_fitter_push_depth(fitter, &depth_view, &mask_view));
    cylfuse_image_view image_view;
    OK(cylfuse_image_view_init(&image_view, sizeof image_view));
    image_view.format = CYLFUSE_IMAGE_FORMAT_U8;
    image_view.data = image;
    image_view.width = WIDTH;
    image_view.height = HEIGHT;
    OK(cylfuse_fitter_push_image(fitter, &image_view));

    cylfuse_counts counts;
    OK(cylfuse_counts_init(&counts, sizeof counts));
    OK(cylfuse_fitter_counts(fitter, &counts));
    CHECK(counts.points_used > 1000 && counts.struct_size == sizeof counts);

    /* What follows the structs belongs to the program. */
    struct { cylfuse_result result; uint64_t after; } out_result;
    struct { cylfuse_cylinder_estimate estimate; uint64_t after; } out_estimate;
    out_result.after = out_estimate.after = 0x0123456789abcdefu;
    OK(cylfuse_result_init(&out_result.result, sizeof out_result.result));
    OK(cylfuse_cylinder_estimate_init(&out_estimate.estimate, sizeof out_estimate.estimate));
    OK(cylfuse_fitter_fit(fitter, &out_result.result, &out_estimate.estimate));
    CHECK(out_result.after == 0x0123456789abcdefu && out_estimate.after == 0x0123456789abcdefu);
    CHECK(out_result.result.struct_size == sizeof(cylfuse_result));
    CHECK(out_result.result.points_used == counts.points_used && steps > 0);
    const cylfuse_cylinder *model = &out_estimate.estimate.model;
    /* Limbs in a drawing without smooth edges are off by up to half a pixel, 2 mm there. */
    CHECK(fabs(model->radius - 0.05) < 3e-3 && fabs(fabs(model->direction[1]) - 1) < 1e-4);
    CHECK(isfinite(out_estimate.estimate.radius_deviation) && isfinite(out_estimate.estimate.covariance[48]));

    cylfuse_limb limbs[2];
    size_t count = 0;
    OK(cylfuse_fitter_limbs(fitter, limbs, sizeof limbs[0], 2, &count));
    CHECK(count == 2 && limbs[1].limb == 1);
    cylfuse_extent extent;
    OK(cylfuse_extent_init(&extent, sizeof extent));
    OK(cylfuse_fitter_extent(fitter, NULL, NULL, &extent));
    CHECK(extent.length > 0.3 && extent.start_state == CYLFUSE_END_STATE_CUT);
    size_t capacity = 0;
    OK(cylfuse_fitter_complete_bound(fitter, NULL, CYLFUSE_LAYOUT_PACKED, &capacity));
    float *points = malloc(capacity * 3 * sizeof *points);
    CHECK(points != NULL);
    cylfuse_points_out points_out;
    OK(cylfuse_points_out_init(&points_out, sizeof points_out));
    points_out.scalar = CYLFUSE_SCALAR_F32;
    points_out.data = points;
    points_out.capacity = capacity;
    cylfuse_completion completion;
    OK(cylfuse_completion_init(&completion, sizeof completion));
    OK(cylfuse_fitter_complete(fitter, NULL, NULL, CYLFUSE_LAYOUT_PACKED, &points_out, &completion));
    CHECK(completion.count > 1000 && completion.count <= capacity);
    free(points);

    cylfuse_frame *frame;
    OK(cylfuse_frame_create(CYLFUSE_ABI_VERSION, &frame));
    OK(cylfuse_frame_set_intrinsics(frame, &intrinsics));
    OK(cylfuse_frame_set_depth(frame, &depth_view));
    cylfuse_detector *detector;
    OK(cylfuse_detector_create(CYLFUSE_ABI_VERSION, &detector));
    OK(cylfuse_detector_detect(detector, frame));
    cylfuse_detection found[8];
    OK(cylfuse_detector_detections(detector, found, sizeof found[0], 8, &count));
    CHECK(count >= 1 && fabs(found[0].model.radius - 0.05) < 2e-3);

    CHECK(cylfuse_fitter_select_view(fitter, 99) != CYLFUSE_STATUS_OK);
    CHECK(strlen(cylfuse_fitter_last_error(fitter)) > 10);
    CHECK(cylfuse_fitter_create(CYLFUSE_ABI_VERSION + 1, &fitter) == CYLFUSE_STATUS_ABI_MISMATCH && fitter == NULL);
    OK(cylfuse_detector_destroy(detector));
    OK(cylfuse_frame_destroy(frame));
    puts("the client runs");
    return 0;
}

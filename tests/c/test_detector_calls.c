/* Detectors: bad input, callbacks, cancelling, threads. */
#include "detector.h"

#include <pthread.h>

enum { THREADS = 4 };

static void bad_options_are_named(void)
{
    cylfuse_detector *detector = new_detector();
    cylfuse_detector_options options = default_options(), before = default_options(), after = default_options();
    options.image_use = 2;
    CHECK_ERROR(NULL, cylfuse_detector_set_options(detector, &options), INVALID_ARGUMENT, "options.image_use is 2");
    double bad[] = {-0.1, 1.1, NAN, INFINITY};
    for (int k = 0; k < 4; k++) {
        options = default_options();
        options.min_score = bad[k];
        CHECK_ERROR(NULL, cylfuse_detector_set_options(detector, &options), INVALID_ARGUMENT, "options.min_score is");
    }
    options = default_options();
    options.radius_min = 2.0;
    options.radius_max = 1.0;
    CHECK_ERROR(NULL, cylfuse_detector_set_options(detector, &options), INVALID_ARGUMENT, "options.radius_max is 1");
    options = default_options();
    options.axis_max_angle = 0.1;
    CHECK_ERROR(NULL, cylfuse_detector_set_options(detector, &options), INVALID_ARGUMENT, "options.axis_max_angle is 0.1");

    cylfuse_options fits, read;
    CHECK_OK(cylfuse_options_init(&fits, sizeof fits));
    CHECK_OK(cylfuse_options_init(&read, sizeof read));
    fits.radius_max = 0.5;
    CHECK_ERROR(NULL, cylfuse_detector_set_fit_options(detector, &fits), INVALID_ARGUMENT, "of the fits is");
    CHECK_OK(cylfuse_options_init(&fits, sizeof fits));
    fits.start = CYLFUSE_START_RANSAC;
    CHECK_ERROR(NULL, cylfuse_detector_set_fit_options(detector, &fits), INVALID_ARGUMENT, "start of the fits is Ransac");
    CHECK_OK(cylfuse_options_init(&fits, sizeof fits));
    fits.max_threads = 2;
    CHECK_ERROR(NULL, cylfuse_detector_set_fit_options(detector, &fits), INVALID_ARGUMENT, "threads of the fits is 2");
    CHECK_OK(cylfuse_detector_get_options(detector, &after));
    CHECK(memcmp(&before, &after, sizeof after) == 0);

    CHECK_OK(cylfuse_options_init(&fits, sizeof fits));
    fits.depth_noise = 0.001;
    CHECK_OK(cylfuse_detector_set_fit_options(detector, &fits));
    CHECK_OK(cylfuse_detector_get_fit_options(detector, &read));
    CHECK(memcmp(&fits, &read, sizeof read) == 0);
    /* An objective that needs edges, of which there are none. */
    fits.objective = CYLFUSE_OBJECTIVE_PAPER;
    cylfuse_frame *frame = pair_frame(0);
    CHECK_OK(cylfuse_detector_set_fit_options(detector, &fits));
    cylfuse_status status = cylfuse_detector_detect(detector, frame);
    CHECK(status == CYLFUSE_STATUS_OK || status == CYLFUSE_STATUS_UNSUPPORTED);
    CHECK_OK(cylfuse_frame_destroy(frame));
    CHECK_OK(cylfuse_detector_destroy(detector));
}

static void null_pointers_are_named(void)
{
    cylfuse_detector *detector = (cylfuse_detector *)&the_scene;
    CHECK_STATUS(cylfuse_detector_create(CYLFUSE_ABI_VERSION + 1, &detector), ABI_MISMATCH);
    CHECK(detector == NULL);
    CHECK_STATUS(cylfuse_detector_create(CYLFUSE_ABI_VERSION, NULL), NULL_POINTER);
    CHECK_OK(cylfuse_detector_destroy(NULL));
    CHECK(cylfuse_detector_last_error(NULL)[0] == '\0');

    cylfuse_frame *frame = pair_frame(0);
    cylfuse_points_view view = pair_points();
    cylfuse_detector_options options = default_options();
    cylfuse_options fits = {.struct_size = sizeof fits};
    cylfuse_result result = {.struct_size = sizeof result};
    cylfuse_cylinder_estimate estimate = {.struct_size = sizeof estimate};
    cylfuse_extent extent = {.struct_size = sizeof extent};
    cylfuse_fitter *fitter = NULL;
    uint16_t label;
    uint32_t place;
    size_t count;
    int32_t complete, columns, rows;
    detector = new_detector();
    cylfuse_detector *both[2] = {NULL, detector};
    for (int k = 0; k < 2; k++) {
        /* Without a detector, and where a scene is needed without one. */
        cylfuse_detector *d = both[k];
        const cylfuse_status expected = k == 0 ? CYLFUSE_STATUS_NULL_POINTER : CYLFUSE_STATUS_BAD_STATE;
        CHECK(cylfuse_detector_count(d, &count) == expected);
        CHECK(cylfuse_detector_is_complete(d, &complete) == expected);
        CHECK(cylfuse_detector_depth_moved(d, &columns, &rows) == expected);
        CHECK(cylfuse_detector_detections(d, NULL, sizeof(cylfuse_detection), 0, &count) == expected);
        CHECK(cylfuse_detector_get_result(d, 0, &result) == expected);
        CHECK(cylfuse_detector_get_cylinder(d, 0, &estimate) == expected);
        CHECK(cylfuse_detector_get_extent(d, 0, &extent) == expected);
        CHECK(cylfuse_detector_labels(d, &label, 1, &count) == expected);
        CHECK(cylfuse_detector_indices(d, 0, &place, 1, &count) == expected);
        CHECK(cylfuse_detector_make_fitter(d, 0, &fitter) == expected && fitter == NULL);
        CHECK(strstr(cylfuse_detector_last_error(d), k == 0 ? "detector is NULL" : "search a frame or points first")
              != NULL);
    }
    CHECK_STATUS(cylfuse_detector_cancel(NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_detector_set_options(NULL, &options), NULL_POINTER);
    CHECK_STATUS(cylfuse_detector_get_options(NULL, &options), NULL_POINTER);
    CHECK_STATUS(cylfuse_detector_set_fit_options(NULL, &fits), NULL_POINTER);
    CHECK_STATUS(cylfuse_detector_get_fit_options(NULL, &fits), NULL_POINTER);
    CHECK_STATUS(cylfuse_detector_set_progress(NULL, NULL, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_detector_detect(NULL, frame), NULL_POINTER);
    CHECK_STATUS(cylfuse_detector_detect_points(NULL, &view), NULL_POINTER);

    CHECK_STATUS(cylfuse_detector_options_init(NULL, sizeof options), NULL_POINTER);
    CHECK_ERROR(NULL, cylfuse_detector_set_options(detector, NULL), NULL_POINTER, "options is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_get_options(detector, NULL), NULL_POINTER, "out_options is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_set_fit_options(detector, NULL), NULL_POINTER, "options is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_get_fit_options(detector, NULL), NULL_POINTER, "out_options is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_detect(detector, NULL), NULL_POINTER, "frame is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_detect_points(detector, NULL), NULL_POINTER, "points is NULL");
    CHECK_OK(cylfuse_detector_detect(detector, frame));
    CHECK_ERROR(NULL, cylfuse_detector_count(detector, NULL), NULL_POINTER, "out_count is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_is_complete(detector, NULL), NULL_POINTER, "out_complete is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_depth_moved(detector, NULL, &rows), NULL_POINTER, "out_columns is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_depth_moved(detector, &columns, NULL), NULL_POINTER, "out_rows is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_detections(detector, NULL, sizeof(cylfuse_detection), 9, &count), NULL_POINTER,
                "out is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_detections(detector, NULL, sizeof(cylfuse_detection), 0, NULL), NULL_POINTER,
                "out_count is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_detections(detector, NULL, 71, 0, &count), STRUCT_SIZE, "element_size is 71");
    CHECK_ERROR(NULL, cylfuse_detector_get_result(detector, 0, NULL), NULL_POINTER, "out_result is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_get_cylinder(detector, 0, NULL), NULL_POINTER, "out_estimate is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_get_extent(detector, 0, NULL), NULL_POINTER, "out_extent is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_labels(detector, NULL, ALL, &count), NULL_POINTER, "out is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_labels(detector, &label, 1, NULL), NULL_POINTER, "out_count is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_indices(detector, 0, NULL, ALL, &count), NULL_POINTER, "out is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_indices(detector, 0, &place, 1, NULL), NULL_POINTER, "out_count is NULL");
    CHECK_ERROR(NULL, cylfuse_detector_make_fitter(detector, 0, NULL), NULL_POINTER, "out_fitter is NULL");
    /* Too little room: how much is needed. */
    CHECK_ERROR(NULL, cylfuse_detector_detections(detector, NULL, sizeof(cylfuse_detection), 0, &count),
                BUFFER_TOO_SMALL, "2 are needed");
    CHECK(count == CYLINDERS);
    CHECK_STATUS(cylfuse_detector_labels(detector, &label, 1, &count), BUFFER_TOO_SMALL);
    CHECK(count == ALL);
    CHECK_STATUS(cylfuse_detector_indices(detector, 0, &place, 1, &count), BUFFER_TOO_SMALL);
    CHECK(count > 300);
    /* There are two. */
    CHECK_ERROR(NULL, cylfuse_detector_get_result(detector, 2, &result), INVALID_ARGUMENT, "index is 2");
    CHECK_STATUS(cylfuse_detector_get_cylinder(detector, SIZE_MAX, &estimate), INVALID_ARGUMENT);
    CHECK_STATUS(cylfuse_detector_get_extent(detector, 2, &extent), INVALID_ARGUMENT);
    CHECK_STATUS(cylfuse_detector_indices(detector, SIZE_MAX, &place, 1, &count), INVALID_ARGUMENT);
    CHECK_OK(cylfuse_frame_destroy(frame));
    CHECK_OK(cylfuse_detector_destroy(detector));
}

/* Searches a frame of one size whose depths are all the same, which hold no cylinder. */
static void search_flat(cylfuse_detector *detector, uint32_t width, uint32_t height, float value)
{
    cylfuse_intrinsics intrinsics = pair_camera;
    intrinsics.width = width;
    intrinsics.height = height;
    cylfuse_depth_view depth = pair_depth();
    float *pixels = exactly(sizeof(float) * width * height);
    for (size_t k = 0; k < (size_t)width * height; k++) {
        pixels[k] = value;
    }
    depth.data = pixels;
    depth.width = width;
    depth.height = height;
    cylfuse_frame *frame = NULL;
    CHECK_OK(cylfuse_frame_create(CYLFUSE_ABI_VERSION, &frame));
    CHECK_STATUS(cylfuse_detector_detect(detector, frame), BAD_STATE);
    CHECK_OK(cylfuse_frame_set_intrinsics(frame, &intrinsics));
    CHECK_ERROR(NULL, cylfuse_detector_detect(detector, frame), BAD_STATE, "needs a depth image");
    CHECK_OK(cylfuse_frame_set_depth(frame, &depth));
    CHECK_OK(cylfuse_detector_detect(detector, frame));
    CHECK(count_of(detector) == 0);
    size_t count = 0;
    uint16_t *labels = exactly(sizeof *labels * width * height);
    CHECK_OK(cylfuse_detector_labels(detector, labels, (size_t)width * height, &count));
    CHECK(count == (size_t)width * height && labels[0] == 0 && labels[count - 1] == 0);
    free(labels);
    free(pixels);
    CHECK_OK(cylfuse_frame_destroy(frame));
}

static void scenes_without_anything(void)
{
    cylfuse_detector *detector = new_detector();
    static const uint32_t SIZES[][2] = {{1, 1}, {2, 2}, {7, 3}, {1, 500}, {500, 1}, {64, 48}};
    static const float VALUES[] = {0.0f, NAN, INFINITY, -1.0f, 1.0f, 1e30f, 1e-30f};
    for (int size = 0; size < 6; size++) {
        for (int value = 0; value < 7; value++) {
            search_flat(detector, SIZES[size][0], SIZES[size][1], VALUES[value]);
        }
    }
    cylfuse_points_view view = pair_points();
    static const size_t EMPTY[][2] = {{0, 0}, {0, 1}, {0, SIZE_MAX}};
    for (int k = 0; k < 3; k++) {
        view.width = EMPTY[k][0];
        view.height = EMPTY[k][1];
        view.data = NULL;
        CHECK_OK(cylfuse_detector_detect_points(detector, &view));
        size_t count = 1;
        CHECK(count_of(detector) == 0);
        CHECK_OK(cylfuse_detector_labels(detector, NULL, 0, &count));
        CHECK(count == 0);
    }
    view = pair_points();
    view.data = NULL;
    CHECK_ERROR(NULL, cylfuse_detector_detect_points(detector, &view), NULL_POINTER, "points.data is NULL");
    view = pair_points();
    view.height = 0;
    CHECK_STATUS(cylfuse_detector_detect_points(detector, &view), INVALID_ARGUMENT);
    view = pair_points();
    view.point_stride = 3;
    CHECK_STATUS(cylfuse_detector_detect_points(detector, &view), INVALID_ARGUMENT);
    view = pair_points();
    view.width = SIZE_MAX / 2;
    CHECK_STATUS(cylfuse_detector_detect_points(detector, &view), INVALID_ARGUMENT);
    /* Four times the same place, infinities, points behind the pair_camera. */
    double odd[64][3];
    for (int kind = 0; kind < 4; kind++) {
        for (int k = 0; k < 64; k++) {
            odd[k][0] = kind == 1 ? NAN : kind == 2 ? k : 0.0;
            odd[k][1] = kind == 1 ? INFINITY : 0.0;
            odd[k][2] = kind == 3 ? -1e200 * k : 1.0;
        }
        view = pair_points();
        view.data = odd;
        view.width = 64;
        view.height = 1;
        CHECK_OK(cylfuse_detector_detect_points(detector, &view));
        CHECK(count_of(detector) == 0);
    }
    CHECK_OK(cylfuse_detector_destroy(detector));
}

typedef struct {
    cylfuse_detector *detector;
    pthread_t thread;
    int calls, stop_at, cancel_at, re_enter;
    uint32_t fits_done;
} recorder;

static int32_t record(const cylfuse_detection_progress *progress, void *user_data)
{
    recorder *now = user_data;
    now->calls++;
    CHECK(progress->struct_size == sizeof *progress && pthread_equal(pthread_self(), now->thread));
    CHECK(progress->phase == (now->calls == 1 ? CYLFUSE_DETECTION_PHASE_SEARCH : CYLFUSE_DETECTION_PHASE_FIT));
    CHECK(progress->fits_done == (uint32_t)(now->calls < 2 ? 0 : now->calls - 2));
    CHECK(progress->fits >= progress->fits_done);
    now->fits_done = progress->fits_done;
    if (now->re_enter) {
        cylfuse_detector_options options = default_options();
        size_t count = 0;
        CHECK_STATUS(cylfuse_detector_count(now->detector, &count), BUSY);
        CHECK_STATUS(cylfuse_detector_detect(now->detector, NULL), BUSY);
        CHECK_STATUS(cylfuse_detector_set_options(now->detector, &options), BUSY);
        CHECK_STATUS(cylfuse_detector_set_progress(now->detector, NULL, NULL), BUSY);
        CHECK_STATUS(cylfuse_detector_destroy(now->detector), BUSY);
        CHECK(strstr(cylfuse_detector_last_error(now->detector), "busy") != NULL);
    }
    if (now->calls == now->cancel_at) {
        CHECK_OK(cylfuse_detector_cancel(now->detector));
    }
    return now->calls == now->stop_at;
}

static void progress_is_told_and_stops(void)
{
    cylfuse_detector *detector = new_detector();
    cylfuse_frame *frame = pair_frame(1);
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        cylfuse_detector_options options = default_options();
        options.max_threads = threads;
        CHECK_OK(cylfuse_detector_set_options(detector, &options));
        recorder now = {.detector = detector, .thread = pthread_self(), .re_enter = 1};
        CHECK_OK(cylfuse_detector_set_progress(detector, record, &now));
        CHECK_OK(cylfuse_detector_detect(detector, frame));
        CHECK(now.fits_done >= CYLINDERS);
        int calls = now.calls;
        now.re_enter = 0;
        for (int stop = 1; stop <= calls; stop++) {
            int cancel = (stop + (int)threads / 2) % 2;
            now.calls = 0;
            now.stop_at = cancel ? 0 : stop;
            now.cancel_at = cancel ? stop : 0;
            CHECK_ERROR(NULL, cylfuse_detector_detect(detector, frame), CANCELLED, "cancelled by the caller");
            CHECK(now.calls >= stop);
            /* The last scene is still there. */
            CHECK(count_of(detector) == CYLINDERS);
        }
        CHECK_OK(cylfuse_detector_set_progress(detector, NULL, NULL));
        /* A request while nothing runs is none. */
        CHECK_OK(cylfuse_detector_cancel(detector));
        CHECK_OK(cylfuse_detector_detect(detector, frame));
    }
    CHECK_OK(cylfuse_frame_destroy(frame));
    CHECK_OK(cylfuse_detector_destroy(detector));
}

typedef struct {
    const cylfuse_detector *detector;
    const cylfuse_detection *expected;
} reader;

static void *read_the_scene(void *argument)
{
    const reader *shared = argument;
    cylfuse_detection list[CYLINDERS];
    size_t count = 0;
    uint16_t *labels = exactly(ALL * sizeof *labels);
    int fine = 1;
    for (int round = 0; round < 20; round++) {
        cylfuse_fitter *fitter = NULL;
        fine = fine && cylfuse_detector_labels(shared->detector, labels, ALL, &count) == CYLFUSE_STATUS_OK
               && cylfuse_detector_detections(shared->detector, list, sizeof list[0], CYLINDERS, &count)
                      == CYLFUSE_STATUS_OK
               && memcmp(list, shared->expected, sizeof list) == 0
               && cylfuse_detector_make_fitter(shared->detector, 1, &fitter) == CYLFUSE_STATUS_OK
               && cylfuse_fitter_destroy(fitter) == CYLFUSE_STATUS_OK;
    }
    free(labels);
    return fine ? argument : NULL;
}

/* The same bits for any number of threads, and readers side by side. */
static void threads_change_nothing(void)
{
    cylfuse_detector *detector = new_detector();
    cylfuse_frame *frame = pair_frame(1);
    cylfuse_detection first[CYLINDERS], list[CYLINDERS];
    size_t count = 0;
    CHECK_OK(cylfuse_detector_detect(detector, frame));
    CHECK_OK(cylfuse_detector_detections(detector, first, sizeof first[0], CYLINDERS, &count));
    for (uint32_t number = 0; number <= 3; number += 3) {
        cylfuse_detector_options options = default_options();
        options.max_threads = number;
        CHECK_OK(cylfuse_detector_set_options(detector, &options));
        CHECK_OK(cylfuse_detector_detect(detector, frame));
        CHECK_OK(cylfuse_detector_detections(detector, list, sizeof list[0], CYLINDERS, &count));
        CHECK(count == CYLINDERS && memcmp(first, list, sizeof list) == 0);
    }
    reader shared = {detector, first};
    pthread_t threads[THREADS];
    for (int k = 0; k < THREADS; k++) {
        CHECK(pthread_create(&threads[k], NULL, read_the_scene, &shared) == 0);
    }
    for (int k = 0; k < THREADS; k++) {
        void *outcome = NULL;
        pthread_join(threads[k], &outcome);
        CHECK(outcome != NULL);
    }
    CHECK_OK(cylfuse_frame_destroy(frame));
    CHECK_OK(cylfuse_detector_destroy(detector));
}

void test_detector_calls(void)
{
    null_pointers_are_named();
    bad_options_are_named();
    scenes_without_anything();
    progress_is_told_and_stops();
    threads_change_nothing();
}

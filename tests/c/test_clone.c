/* What a fitter holds, read back and copied. */
#include "check.h"

static void intrinsics_come_back(void)
{
    cylfuse_fitter *fitter = new_fitter();
    cylfuse_intrinsics back;
    CHECK_OK(cylfuse_intrinsics_init(&back, sizeof back));
    CHECK_ERROR(fitter, cylfuse_fitter_get_intrinsics(fitter, &back), BAD_STATE, "set its intrinsics or use a frame");
    cylfuse_intrinsics given = the_scene.intrinsics;
    const cylfuse_distortion models[] = {CYLFUSE_DISTORTION_NONE, CYLFUSE_DISTORTION_BROWN_CONRADY,
                                         CYLFUSE_DISTORTION_KANNALA_BRANDT};
    for (size_t k = 0; k < 3; k++) {
        given.distortion_model = models[k];
        for (int i = 0; i < 8; i++) {
            given.distortion[i] = k == 1 || (k == 2 && i < 4) ? 0.001 * (i + 1) : 0.0;
        }
        CHECK_ERROR(fitter, cylfuse_fitter_set_intrinsics(fitter, &given), OK, "");
        CHECK_ERROR(fitter, cylfuse_fitter_get_intrinsics(fitter, &back), OK, "");
        CHECK(memcmp(&back, &given, sizeof given) == 0);
    }
    /* Those of the selected view, and of its frame. */
    CHECK_OK(cylfuse_fitter_select_view(fitter, 1));
    CHECK_STATUS(cylfuse_fitter_get_intrinsics(fitter, &back), BAD_STATE);
    cylfuse_frame *frame;
    CHECK_OK(cylfuse_frame_create(CYLFUSE_ABI_VERSION, &frame));
    CHECK_OK(cylfuse_frame_set_intrinsics(frame, &the_scene.intrinsics));
    CHECK_OK(cylfuse_fitter_use_frame(fitter, frame, NULL));
    CHECK_OK(cylfuse_fitter_get_intrinsics(fitter, &back));
    CHECK(memcmp(&back, &the_scene.intrinsics, sizeof back) == 0);
    CHECK_OK(cylfuse_frame_destroy(frame));
    back.struct_size = 1;
    CHECK_ERROR(fitter, cylfuse_fitter_get_intrinsics(fitter, &back), STRUCT_SIZE, "out_intrinsics");
    CHECK_ERROR(fitter, cylfuse_fitter_get_intrinsics(fitter, NULL), NULL_POINTER, "out_intrinsics is NULL");
    CHECK_STATUS(cylfuse_fitter_get_intrinsics(NULL, &back), NULL_POINTER);
    destroy(fitter);
}

static int32_t stop(const cylfuse_progress *progress, void *user_data)
{
    (void)progress;
    (void)user_data;
    return 1;
}

static void a_clone_goes_its_own_way(void)
{
    cylfuse_fitter *fitter = new_full_fitter(), *clone = NULL, *fresh = NULL;
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.max_iterations = 77;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    CHECK_OK(cylfuse_fitter_clone(fitter, &fresh));
    cylfuse_result result;
    CHECK_OK(cylfuse_result_init(&result, sizeof result));
    CHECK_STATUS(cylfuse_fitter_get_result(fresh, &result), BAD_STATE);
    const cylfuse_cylinder_estimate found = fit_cylinder(fitter);
    CHECK_OK(cylfuse_fitter_set_progress(fitter, stop, NULL));
    CHECK_ERROR(fitter, cylfuse_fitter_clone(fitter, &clone), OK, "");

    /* Settings, data and result are there, the callback is not. */
    CHECK_OK(cylfuse_fitter_get_options(clone, &options));
    CHECK(options.max_iterations == 77);
    cylfuse_cylinder_estimate of_clone = cylinder_of(clone);
    CHECK(memcmp(&of_clone, &found, sizeof found) == 0);
    of_clone = fit_cylinder(clone);
    CHECK(memcmp(&of_clone, &found, sizeof found) == 0);
    of_clone = fit_cylinder(fresh);
    CHECK(memcmp(&of_clone, &found, sizeof found) == 0);
    CHECK_STATUS(cylfuse_fitter_fit(fitter, &result, NULL), CANCELLED);

    /* What happens to one does not happen to the other. */
    CHECK_OK(cylfuse_fitter_clear(clone));
    CHECK(counts(clone).points_given == 0 && counts(fitter).points_given == POINTS);
    destroy(fitter);
    CHECK(fits_truth(fresh, 1e-5));
    destroy(fresh);
    destroy(clone);

    fresh = (cylfuse_fitter *)&result;
    CHECK_STATUS(cylfuse_fitter_clone(NULL, &fresh), NULL_POINTER);
    fitter = new_fitter();
    CHECK_ERROR(fitter, cylfuse_fitter_clone(fitter, NULL), NULL_POINTER, "out_fitter is NULL");
    destroy(fitter);
}

void test_clone(void)
{
    intrinsics_come_back();
    a_clone_goes_its_own_way();
}

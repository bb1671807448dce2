/* Many fits at once. */
#include "check.h"

#include <pthread.h>

enum { COUNT = 12, FLAT = 4 };

/* A fitter with some of the points of the scene, others for each; the one of FLAT has a row of them only. */
static cylfuse_fitter *fitter_of(size_t index)
{
    cylfuse_fitter *fitter = new_fitter();
    cylfuse_points_view points = scene_points();
    points.width = index == FLAT ? COLUMNS : POINTS - 17 * index;
    points.height = 1;
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    return fitter;
}

typedef struct {
    cylfuse_fitter **fitters;
    pthread_t thread;
    size_t calls, stop_after;
    int ended[COUNT];
} listener;

static int32_t hear(size_t index, cylfuse_status status, void *user_data)
{
    listener *heard = user_data;
    CHECK(pthread_equal(pthread_self(), heard->thread));
    CHECK(index < COUNT && !heard->ended[index]);
    heard->ended[index] = 1;
    heard->calls++;
    /* Its result, or its text, is there already. */
    if (index == FLAT) {
        CHECK_ERROR(heard->fitters[index], status, COLLINEAR_POINTS, "on one line");
    } else {
        CHECK(status == CYLFUSE_STATUS_OK && found_truth(heard->fitters[index], 1e-9));
    }
    return heard->calls == heard->stop_after;
}

static int32_t never(const cylfuse_progress *progress, void *user_data)
{
    (void)progress;
    (void)user_data;
    CHECK(!"a callback of a fitter was called");
    return 0;
}

static void never_log(cylfuse_log_level level, const char *message, void *user_data)
{
    (void)level;
    (void)message;
    (void)user_data;
    CHECK(!"the log of a fitter was called");
}

static void fits_are_those_of_single_calls(void)
{
    cylfuse_cylinder_estimate alone[COUNT];
    for (size_t k = 0; k < COUNT; k++) {
        cylfuse_fitter *fitter = fitter_of(k);
        CHECK_OK(cylfuse_cylinder_estimate_init(&alone[k], sizeof alone[k]));
        cylfuse_status expected = k == FLAT ? CYLFUSE_STATUS_COLLINEAR_POINTS : CYLFUSE_STATUS_OK;
        CHECK(cylfuse_fitter_fit(fitter, NULL, &alone[k]) == expected);
        destroy(fitter);
    }
    static const uint32_t threads[] = {1, 0, 3, 100};
    for (size_t n = 0; n < sizeof threads / sizeof threads[0]; n++) {
        cylfuse_fitter **fitters = exactly(COUNT * sizeof *fitters);
        cylfuse_status *statuses = exactly(COUNT * sizeof *statuses);
        for (size_t k = 0; k < COUNT; k++) {
            fitters[k] = fitter_of(k);
            CHECK_OK(cylfuse_fitter_set_progress(fitters[k], never, NULL));
            CHECK_OK(cylfuse_fitter_set_log(fitters[k], CYLFUSE_LOG_LEVEL_DEBUG, never_log, NULL));
        }
        listener heard = {.fitters = fitters, .thread = pthread_self()};
        CHECK_OK(cylfuse_fit_all(fitters, COUNT, threads[n], hear, &heard, statuses));
        CHECK(heard.calls == COUNT);
        for (size_t k = 0; k < COUNT; k++) {
            CHECK_OK(cylfuse_fitter_set_log(fitters[k], CYLFUSE_LOG_LEVEL_OFF, NULL, NULL));
            if (k == FLAT) {
                CHECK(statuses[k] == CYLFUSE_STATUS_COLLINEAR_POINTS);
            } else {
                cylfuse_cylinder_estimate estimate = cylinder_of(fitters[k]);
                CHECK(statuses[k] == CYLFUSE_STATUS_OK && memcmp(&estimate, &alone[k], sizeof estimate) == 0);
            }
        }
        /* The next lot on the same fitters, without a callback. */
        CHECK_OK(cylfuse_fit_all(fitters, FLAT, threads[n], NULL, NULL, statuses));
        CHECK(statuses[0] == CYLFUSE_STATUS_OK && statuses[FLAT] == CYLFUSE_STATUS_COLLINEAR_POINTS);
        for (size_t k = 0; k < COUNT; k++) {
            destroy(fitters[k]);
        }
        free(fitters);
        free(statuses);
    }
}

static void the_rest_can_be_stopped(void)
{
    cylfuse_fitter *fitters[COUNT];
    cylfuse_status statuses[COUNT];
    for (size_t k = 0; k < COUNT; k++) {
        fitters[k] = fitter_of(k);
    }
    listener heard = {.fitters = fitters, .thread = pthread_self(), .stop_after = 3};
    CHECK_STATUS(cylfuse_fit_all(fitters, COUNT, 1, hear, &heard, statuses), CANCELLED);
    CHECK(heard.calls == 3);
    for (size_t k = 0; k < COUNT; k++) {
        CHECK(statuses[k] == (k < 3 ? CYLFUSE_STATUS_OK : CYLFUSE_STATUS_CANCELLED));
    }
    CHECK(strstr(cylfuse_fitter_last_error(fitters[COUNT - 1]), "cancelled") != NULL);
    heard.calls = heard.stop_after = 0;
    memset(heard.ended, 0, sizeof heard.ended);
    CHECK_OK(cylfuse_fit_all(fitters, COUNT, 2, hear, &heard, statuses));
    CHECK(heard.calls == COUNT);
    for (size_t k = 0; k < COUNT; k++) {
        destroy(fitters[k]);
    }
}

/* A callback of a single fit, in which the fitter is busy. */
static int32_t fit_all_inside(const cylfuse_progress *progress, void *user_data)
{
    (void)progress;
    cylfuse_fitter *fitters[3] = {user_data, NULL, fitter_of(0)};
    cylfuse_status statuses[3];
    CHECK_OK(cylfuse_fit_all(fitters, 3, 2, NULL, NULL, statuses));
    CHECK(statuses[0] == CYLFUSE_STATUS_BUSY && statuses[1] == CYLFUSE_STATUS_NULL_POINTER);
    CHECK(statuses[2] == CYLFUSE_STATUS_OK);
    CHECK(strstr(cylfuse_fitter_last_error(fitters[0]), "in a callback, make the call after it") != NULL);
    destroy(fitters[2]);
    return 1;
}

typedef struct {
    cylfuse_fitter *busy;
    uint32_t threads;
} batch;

/* Fits a busy fitter among others, from another thread than the one whose fit keeps it busy. */
static void *fit_beside(void *given)
{
    const batch *asked = given;
    cylfuse_fitter *fitters[3] = {asked->busy, new_fitter(), fitter_of(0)};
    cylfuse_status statuses[3];
    CHECK_OK(cylfuse_fit_all(fitters, 3, asked->threads, NULL, NULL, statuses));
    /* Calls on others in between. */
    CHECK(statuses[2] == CYLFUSE_STATUS_OK && found_truth(fitters[2], 1e-9));
    CHECK_ERROR(fitters[1], statuses[1], TOO_FEW_POINTS, "0 of 0 points");
    CHECK_ERROR(fitters[0], statuses[0], BUSY, "the handle is busy");
    /* The next call on it has its own text. */
    CHECK_OK(cylfuse_fitter_cancel(fitters[0]));
    CHECK(strcmp(cylfuse_fitter_last_error(fitters[2]), "") == 0);
    CHECK(strcmp(cylfuse_fitter_last_error(fitters[0]), "") == 0);
    destroy(fitters[1]);
    destroy(fitters[2]);
    return NULL;
}

static int32_t fit_beside_me(const cylfuse_progress *progress, void *user_data)
{
    (void)progress;
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, fit_beside, user_data) == 0);
    CHECK(pthread_join(thread, NULL) == 0);
    return 1;
}

static int32_t fit_busy_one(const cylfuse_progress *progress, void *user_data)
{
    (void)progress;
    cylfuse_fitter *fitters[2] = {user_data, NULL};
    cylfuse_status statuses[2];
    CHECK_OK(cylfuse_fit_all(fitters, 2, 2, NULL, NULL, statuses));
    CHECK_ERROR(fitters[0], statuses[0], BUSY, "the handle is busy");
    return 0;
}

static void a_busy_fitter_has_its_text(void)
{
    cylfuse_fitter *one = fitter_of(0), *other = fitter_of(1);
    for (uint32_t threads = 1; threads <= 3; threads++) {
        batch asked = {one, threads};
        CHECK_OK(cylfuse_fitter_set_progress(one, fit_beside_me, &asked));
        CHECK_ERROR(one, cylfuse_fitter_fit(one, NULL, NULL), CANCELLED, "cancelled");
    }
    /* The text goes with the next call of the same thread, one of many at once too. */
    CHECK_OK(cylfuse_fitter_set_progress(one, fit_busy_one, one));
    CHECK_OK(cylfuse_fitter_fit(one, NULL, NULL));
    CHECK_OK(cylfuse_fitter_set_progress(other, NULL, NULL));
    CHECK(strcmp(cylfuse_fitter_last_error(one), "") == 0);
    cylfuse_fitter *fitters[2] = {one, other};
    cylfuse_status statuses[2];
    CHECK_OK(cylfuse_fit_all(fitters, 2, 2, NULL, NULL, statuses));
    CHECK(statuses[0] == CYLFUSE_STATUS_OK && strcmp(cylfuse_fitter_last_error(one), "") == 0);
    destroy(one);
    destroy(other);
}

static void bad_lists_are_refused(void)
{
    cylfuse_fitter *one = fitter_of(0), *other = fitter_of(1);
    cylfuse_fitter *fitters[4] = {one, other, NULL, one};
    cylfuse_status statuses[4] = {7, 7, 7, 7};
    CHECK_STATUS(cylfuse_fit_all(NULL, 1, 1, NULL, NULL, statuses), NULL_POINTER);
    CHECK_STATUS(cylfuse_fit_all(fitters, 2, 1, NULL, NULL, NULL), NULL_POINTER);
    CHECK(strstr(cylfuse_fitter_last_error(NULL), "out_statuses is NULL") != NULL);
    CHECK_STATUS(cylfuse_fit_all(fitters, 4, 1, NULL, NULL, statuses), INVALID_ARGUMENT);
    CHECK(strstr(cylfuse_fitter_last_error(NULL), "fitters[3] is the same as fitters[0]") != NULL);
    CHECK(statuses[0] == 7 && statuses[3] == 7);
    CHECK_STATUS(cylfuse_fit_all(fitters, SIZE_MAX / 2, 1, NULL, NULL, statuses), OUT_OF_MEMORY);
    CHECK_OK(cylfuse_fit_all(NULL, 0, 0, NULL, NULL, NULL));

    CHECK_OK(cylfuse_fitter_set_progress(one, fit_all_inside, one));
    CHECK_STATUS(cylfuse_fitter_fit(one, NULL, NULL), CANCELLED);
    destroy(one);
    destroy(other);
}

void test_batch(void)
{
    fits_are_those_of_single_calls();
    the_rest_can_be_stopped();
    bad_lists_are_refused();
    a_busy_fitter_has_its_text();
}

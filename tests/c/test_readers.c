/* Several threads on one fitter, and whose text is whose. */
#include "check.h"

#include <pthread.h>

enum { READERS = 4, ROUNDS = 50 };

/* Readers meet inside their calls: the log callback waits until all of them are there. */
typedef struct {
    cylfuse_fitter *fitter;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    int inside;
} meeting;

static void meet_inside(cylfuse_log_level level, const char *message, void *user_data)
{
    meeting *shared = user_data;
    CHECK(level == CYLFUSE_LOG_LEVEL_ERROR && strstr(message, "kind is") != NULL);
    pthread_mutex_lock(&shared->mutex);
    shared->inside++;
    if (shared->inside == READERS) {
        /* A call that changes something would disturb them. */
        CHECK_STATUS(cylfuse_fitter_clear(shared->fitter), BUSY);
        CHECK_STATUS(cylfuse_fitter_destroy(shared->fitter), BUSY);
        CHECK(strstr(cylfuse_fitter_last_error(shared->fitter), "busy") != NULL);
        pthread_cond_broadcast(&shared->changed);
    }
    while (shared->inside < READERS) {
        pthread_cond_wait(&shared->changed, &shared->mutex);
    }
    pthread_mutex_unlock(&shared->mutex);
}

static void *fail_to_read(void *argument)
{
    meeting *shared = argument;
    size_t count = 0;
    cylfuse_status status = cylfuse_fitter_residuals(shared->fitter, NULL, 99, NULL, 0, &count);
    /* The text of the call in the callback is not that of this call. */
    const char *text = cylfuse_fitter_last_error(shared->fitter);
    int holds = status == CYLFUSE_STATUS_INVALID_ARGUMENT && strstr(text, "kind is 99") != NULL;
    return holds ? shared : NULL;
}

static void readers_run_at_once(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    meeting shared = {.fitter = fitter};
    pthread_mutex_init(&shared.mutex, NULL);
    pthread_cond_init(&shared.changed, NULL);
    CHECK_OK(cylfuse_fitter_set_log(fitter, CYLFUSE_LOG_LEVEL_ERROR, meet_inside, &shared));
    pthread_t threads[READERS];
    for (int k = 0; k < READERS; k++) {
        CHECK(pthread_create(&threads[k], NULL, fail_to_read, &shared) == 0);
    }
    for (int k = 0; k < READERS; k++) {
        void *outcome = NULL;
        pthread_join(threads[k], &outcome);
        CHECK(outcome != NULL);
    }
    CHECK(shared.inside == READERS);
    pthread_cond_destroy(&shared.changed);
    pthread_mutex_destroy(&shared.mutex);
    destroy(fitter);
}

static void *read_everything(void *argument)
{
    const cylfuse_fitter *fitter = argument;
    cylfuse_result result = {.struct_size = sizeof result};
    cylfuse_extent extent = {.struct_size = sizeof extent};
    double residuals[PIXELS];
    size_t count;
    for (int round = 0; round < ROUNDS; round++) {
        int fine = cylfuse_fitter_evaluate(fitter, &the_scene.truth, &result, NULL) == CYLFUSE_STATUS_OK
                   && cylfuse_fitter_residuals(fitter, NULL, CYLFUSE_RESIDUAL_KIND_POINTS, residuals, PIXELS, &count)
                          == CYLFUSE_STATUS_OK
                   && (round % 10 != 0 || cylfuse_fitter_extent(fitter, NULL, NULL, &extent) == CYLFUSE_STATUS_OK)
                   && cylfuse_fitter_last_error(fitter)[0] == '\0';
        if (!fine) {
            return NULL;
        }
    }
    return argument;
}

static void readers_are_never_busy(void)
{
    cylfuse_fitter *fitter = new_camera_fitter();
    cylfuse_depth_view depth = scene_depth();
    cylfuse_mask_view mask = scene_mask();
    CHECK_OK(cylfuse_fitter_push_depth(fitter, &depth, &mask));
    fit(fitter);
    pthread_t threads[READERS];
    for (int k = 0; k < READERS; k++) {
        CHECK(pthread_create(&threads[k], NULL, read_everything, fitter) == 0);
    }
    for (int k = 0; k < READERS; k++) {
        void *outcome = NULL;
        pthread_join(threads[k], &outcome);
        CHECK(outcome != NULL);
    }
    destroy(fitter);
}

static void *fail_and_leave(void *argument)
{
    CHECK_STATUS(cylfuse_fitter_set_options(argument, NULL), NULL_POINTER);
    return NULL;
}

static void texts_stay_with_their_calls(void)
{
    cylfuse_fitter *fitter = new_fitter(), *other = new_fitter();
    CHECK_STATUS(cylfuse_fitter_push_edges(fitter, NULL), NULL_POINTER);
    CHECK_STATUS(cylfuse_fitter_push_points(other, NULL, NULL), NULL_POINTER);
    CHECK(strstr(cylfuse_fitter_last_error(fitter), "segments is NULL") != NULL);
    CHECK(strstr(cylfuse_fitter_last_error(other), "points is NULL") != NULL);
    CHECK(strstr(cylfuse_fitter_last_error(NULL), "points is NULL") != NULL);
    /* A failure on another thread, as of a task that goes on here. */
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, fail_and_leave, fitter) == 0);
    pthread_join(thread, NULL);
    CHECK(strstr(cylfuse_fitter_last_error(fitter), "options is NULL") != NULL);
    CHECK(strstr(cylfuse_fitter_last_error(NULL), "points is NULL") != NULL);
    /* Success empties it, also that of calls that do not enter the fitter. */
    CHECK_OK(cylfuse_fitter_cancel(fitter));
    CHECK(cylfuse_fitter_last_error(fitter)[0] == '\0' && cylfuse_fitter_last_error(NULL)[0] == '\0');
    cylfuse_fitter *none = NULL;
    CHECK_STATUS(cylfuse_fitter_create(7, &none), ABI_MISMATCH);
    CHECK(cylfuse_fitter_last_error(NULL)[0] != '\0');
    CHECK_OK(cylfuse_fitter_destroy(NULL));
    CHECK(cylfuse_fitter_last_error(NULL)[0] == '\0');
    destroy(fitter);
    destroy(other);
}

void test_readers(void)
{
    readers_run_at_once();
    readers_are_never_busy();
    texts_stay_with_their_calls();
}

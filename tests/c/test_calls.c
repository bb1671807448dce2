/* Callbacks, cancelling, and two threads on one fitter. */
#include "check.h"

#include <pthread.h>

/* A fitter that starts away from the truth, so that it has to iterate. */
static cylfuse_fitter *new_slow_fitter(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.start = CYLFUSE_START_MODEL;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    cylfuse_cylinder start = the_scene.truth;
    start.point[0] += 0.01;
    start.direction[1] += 0.1;
    start.radius *= 1.2;
    CHECK_OK(cylfuse_fitter_set_start_model(fitter, &start));
    return fitter;
}

typedef struct {
    cylfuse_fitter *fitter;
    pthread_t thread;
    int calls, starts, solves;
    /* Stop at this call; 0 = never. */
    int stop_at, cancel_at;
    int re_enter;
} recorder;

static void try_everything(cylfuse_fitter *fitter)
{
    cylfuse_result result = {.struct_size = sizeof result};
    cylfuse_counts now = {.struct_size = sizeof now};
    cylfuse_points_view points = scene_points();
    CHECK_STATUS(cylfuse_fitter_fit(fitter, &result, NULL), BUSY);
    CHECK_STATUS(cylfuse_fitter_get_result(fitter, &result), BUSY);
    CHECK_STATUS(cylfuse_fitter_counts(fitter, &now), BUSY);
    CHECK_STATUS(cylfuse_fitter_push_points(fitter, &points, NULL), BUSY);
    CHECK_STATUS(cylfuse_fitter_clear(fitter), BUSY);
    CHECK_STATUS(cylfuse_fitter_reserve(fitter, 1, 1), BUSY);
    CHECK_STATUS(cylfuse_fitter_set_progress(fitter, NULL, NULL), BUSY);
    CHECK_STATUS(cylfuse_fitter_set_log(fitter, CYLFUSE_LOG_LEVEL_OFF, NULL, NULL), BUSY);
    /* Busy comes before everything else, such as a missing argument. */
    CHECK_STATUS(cylfuse_fitter_set_options(fitter, NULL), BUSY);
    CHECK_STATUS(cylfuse_fitter_destroy(fitter), BUSY);
    CHECK(strstr(cylfuse_fitter_last_error(fitter), "busy") != NULL);
}

static int32_t record(const cylfuse_progress *progress, void *user_data)
{
    recorder *seen = user_data;
    seen->calls++;
    CHECK(progress->struct_size == sizeof *progress && progress->max_iterations == 400);
    CHECK(pthread_equal(pthread_self(), seen->thread));
    if (progress->phase == CYLFUSE_PHASE_START) {
        seen->starts++;
        CHECK(progress->iteration == 0 && isinf(progress->cost) && progress->cylinder == NULL);
    } else {
        seen->solves++;
        CHECK(progress->phase == CYLFUSE_PHASE_SOLVE && progress->cost >= 0.0 && progress->cylinder->radius > 0.0);
    }
    if (seen->re_enter) {
        try_everything(seen->fitter);
        cylfuse_fitter *other = new_full_fitter();
        CHECK(fits_truth(other, 1e-8));
        destroy(other);
    }
    if (seen->calls == seen->cancel_at) {
        CHECK_OK(cylfuse_fitter_cancel(seen->fitter));
    }
    return seen->calls == seen->stop_at;
}

static void progress_is_told(void)
{
    cylfuse_fitter *fitter = new_slow_fitter();
    recorder seen = {.fitter = fitter, .thread = pthread_self()};
    CHECK_OK(cylfuse_fitter_set_progress(fitter, record, &seen));
    cylfuse_result result = fit(fitter);
    CHECK(seen.starts >= 1 && seen.solves >= (int)result.iterations && result.iterations > 3);

    /* The callback stops the fit at its first and third call; the result stays. */
    cylfuse_result kept = {.struct_size = sizeof kept};
    for (int stop = 1; stop <= 3; stop += 2) {
        seen.calls = 0;
        seen.stop_at = stop;
        CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &kept, NULL), CANCELLED, "cancelled by the caller");
        CHECK(seen.calls == stop);
    }
    CHECK_OK(cylfuse_fitter_get_result(fitter, &kept));
    CHECK(memcmp(&kept, &result, sizeof kept) == 0);

    seen.stop_at = 0;
    seen.calls = 0;
    seen.cancel_at = 2;
    CHECK_STATUS(cylfuse_fitter_fit(fitter, &kept, NULL), CANCELLED);
    CHECK(seen.calls == 2);
    /* That request is used up. */
    seen.cancel_at = 0;
    CHECK(fits_truth(fitter, 1e-9));

    seen.re_enter = 1;
    CHECK(fits_truth(fitter, 1e-9));
    CHECK(counts(fitter).points_given == POINTS);
    seen.calls = 0;
    CHECK_OK(cylfuse_fitter_set_progress(fitter, NULL, NULL));
    fit(fitter);
    CHECK(seen.calls == 0);
    destroy(fitter);

    /* Where random samples are drawn the fit asks whether to go on long before there is a cylinder. */
    fitter = new_full_fitter();
    cylfuse_options options;
    CHECK_OK(cylfuse_options_init(&options, sizeof options));
    options.start = CYLFUSE_START_RANSAC;
    CHECK_OK(cylfuse_fitter_set_options(fitter, &options));
    seen = (recorder){.fitter = fitter, .thread = pthread_self()};
    CHECK_OK(cylfuse_fitter_set_progress(fitter, record, &seen));
    fit(fitter);
    CHECK(seen.starts > 1 && seen.solves > 0);
    destroy(fitter);
}

static void cancelling_while_idle_does_nothing(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    CHECK_ERROR(fitter, cylfuse_fitter_set_options(fitter, NULL), NULL_POINTER, "options is NULL");
    CHECK_ERROR(fitter, cylfuse_fitter_cancel(fitter), OK, "");
    CHECK(fits_truth(fitter, 1e-9));
    CHECK_OK(cylfuse_fitter_cancel(fitter));
    CHECK(fits_truth(fitter, 1e-9));
    destroy(fitter);
}

typedef struct {
    cylfuse_fitter *fitter;
    int lines[5];
    char last[512];
} lines;

static void keep_line(cylfuse_log_level level, const char *message, void *user_data)
{
    lines *kept = user_data;
    CHECK(level >= CYLFUSE_LOG_LEVEL_ERROR && level <= CYLFUSE_LOG_LEVEL_DEBUG);
    kept->lines[level]++;
    CHECK(message[0] != '\0' && strchr(message, '\n') == NULL);
    snprintf(kept->last, sizeof kept->last, "%s", message);
    CHECK_STATUS(cylfuse_fitter_clear(kept->fitter), BUSY);
}

static void logs_are_told(void)
{
    cylfuse_fitter *fitter = new_slow_fitter();
    lines kept = {.fitter = fitter};
    cylfuse_result result = {.struct_size = sizeof result};
    CHECK_OK(cylfuse_fitter_set_log(fitter, CYLFUSE_LOG_LEVEL_DEBUG, keep_line, &kept));
    cylfuse_points_view points = scene_points();
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    CHECK(kept.lines[CYLFUSE_LOG_LEVEL_INFO] == 1 && strstr(kept.last, "1200 of 1200 points") != NULL);
    fit(fitter);
    CHECK(kept.lines[CYLFUSE_LOG_LEVEL_INFO] == 3 && kept.lines[CYLFUSE_LOG_LEVEL_DEBUG] > 1);
    size_t needed = 0;
    double one;
    CHECK_STATUS(cylfuse_fitter_residuals(fitter, NULL, CYLFUSE_RESIDUAL_KIND_POINTS, NULL, 0, &needed),
                 BUFFER_TOO_SMALL);
    CHECK(kept.lines[CYLFUSE_LOG_LEVEL_WARNING] == 0 && kept.lines[CYLFUSE_LOG_LEVEL_ERROR] == 0);
    CHECK_STATUS(cylfuse_fitter_residuals(fitter, NULL, CYLFUSE_RESIDUAL_KIND_POINTS, &one, 1, &needed),
                 BUFFER_TOO_SMALL);
    CHECK(kept.lines[CYLFUSE_LOG_LEVEL_ERROR] == 1);
    CHECK_STATUS(cylfuse_fitter_push_points(fitter, NULL, NULL), NULL_POINTER);
    CHECK(kept.lines[CYLFUSE_LOG_LEVEL_ERROR] == 2);
    CHECK(strcmp(kept.last, cylfuse_fitter_last_error(fitter)) == 0);

    /* Twice the same limb: a warning. */
    CHECK_OK(cylfuse_fitter_clear(fitter));
    CHECK_OK(cylfuse_fitter_push_points(fitter, &points, NULL));
    cylfuse_segments_view edges = scene_edges();
    edges.count = 1;
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    CHECK_OK(cylfuse_fitter_push_edges(fitter, &edges));
    memset(kept.lines, 0, sizeof kept.lines);
    CHECK_OK(cylfuse_fitter_set_log(fitter, CYLFUSE_LOG_LEVEL_WARNING, keep_line, &kept));
    result = fit(fitter);
    CHECK(result.flags == (CYLFUSE_RESULT_FLAGS_EDGES_IGNORED | CYLFUSE_RESULT_FLAGS_EDGES_COINCIDE));
    CHECK(kept.lines[CYLFUSE_LOG_LEVEL_WARNING] == 2 && kept.lines[CYLFUSE_LOG_LEVEL_INFO] == 0);
    CHECK(strstr(kept.last, "EDGES_COINCIDE") != NULL);
    CHECK_OK(cylfuse_fitter_set_log(fitter, CYLFUSE_LOG_LEVEL_OFF, keep_line, &kept));
    memset(kept.lines, 0, sizeof kept.lines);
    CHECK_STATUS(cylfuse_fitter_push_points(fitter, NULL, NULL), NULL_POINTER);
    CHECK(kept.lines[CYLFUSE_LOG_LEVEL_ERROR] == 0);
    destroy(fitter);
}

void test_callbacks(void)
{
    progress_is_told();
    cancelling_while_idle_does_nothing();
    logs_are_told();
}

/* A fit whose callback waits until the other thread has had its say. */
typedef struct {
    cylfuse_fitter *fitter;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    int running, released;
    cylfuse_status status;
} meeting;

static int32_t wait_for_release(const cylfuse_progress *progress, void *user_data)
{
    meeting *shared = user_data;
    (void)progress;
    pthread_mutex_lock(&shared->mutex);
    shared->running = 1;
    pthread_cond_signal(&shared->changed);
    while (!shared->released) {
        pthread_cond_wait(&shared->changed, &shared->mutex);
    }
    pthread_mutex_unlock(&shared->mutex);
    return 0;
}

static void *fit_in_thread(void *argument)
{
    meeting *shared = argument;
    cylfuse_result result = {.struct_size = sizeof result};
    shared->status = cylfuse_fitter_fit(shared->fitter, &result, NULL);
    return NULL;
}

/* `then` happens while the fit is running for sure. */
static cylfuse_status meet(cylfuse_fitter *fitter, void (*then)(cylfuse_fitter *))
{
    meeting shared = {.fitter = fitter, .status = 1};
    pthread_t thread;
    pthread_mutex_init(&shared.mutex, NULL);
    pthread_cond_init(&shared.changed, NULL);
    CHECK_OK(cylfuse_fitter_set_progress(fitter, wait_for_release, &shared));
    CHECK(pthread_create(&thread, NULL, fit_in_thread, &shared) == 0);
    pthread_mutex_lock(&shared.mutex);
    while (!shared.running) {
        pthread_cond_wait(&shared.changed, &shared.mutex);
    }
    pthread_mutex_unlock(&shared.mutex);
    then(fitter);
    pthread_mutex_lock(&shared.mutex);
    shared.released = 1;
    pthread_cond_signal(&shared.changed);
    pthread_mutex_unlock(&shared.mutex);
    pthread_join(thread, NULL);
    pthread_cond_destroy(&shared.changed);
    pthread_mutex_destroy(&shared.mutex);
    CHECK_OK(cylfuse_fitter_set_progress(fitter, NULL, NULL));
    return shared.status;
}

static void cancel(cylfuse_fitter *fitter)
{
    CHECK_OK(cylfuse_fitter_cancel(fitter));
}

static void *fit_alone(void *argument)
{
    cylfuse_cylinder_estimate *estimate = argument;
    cylfuse_fitter *fitter = new_full_fitter();
    *estimate = fit_cylinder(fitter);
    destroy(fitter);
    return NULL;
}

void test_threads(void)
{
    cylfuse_fitter *fitter = new_full_fitter();
    CHECK_OK(meet(fitter, try_everything));
    CHECK_STATUS(meet(fitter, cancel), CANCELLED);
    CHECK(fits_truth(fitter, 1e-9));
    destroy(fitter);

    /* Fitters of their own do not disturb each other. */
    enum { THREADS = 4 };
    pthread_t threads[THREADS];
    cylfuse_cylinder_estimate results[THREADS];
    for (int k = 0; k < THREADS; k++) {
        CHECK(pthread_create(&threads[k], NULL, fit_alone, &results[k]) == 0);
    }
    for (int k = 0; k < THREADS; k++) {
        pthread_join(threads[k], NULL);
        CHECK(memcmp(&results[k].model, &results[0].model, sizeof results[k].model) == 0);
    }
}

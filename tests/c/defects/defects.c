/* Defects that random calls once found, each with what happens instead. Run with the name of one, and of a call where
 * memory is short; prints what fails and returns 1 then. A signal or a printed line of the library is a failure too. */
#include "defects.h"

/* A mask without pixels is refused wherever one is taken. */
static void empty_masks(void)
{
    uint8_t pixel = 1;
    double points[4][3] = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 2}};
    uint16_t depths[64];
    for (int k = 0; k < 64; k++) {
        depths[k] = 1000;
    }
    cylfuse_depth_view depth;
    CHECK_STATUS(cylfuse_depth_view_init(&depth, sizeof depth), OK);
    depth.format = CYLFUSE_DEPTH_FORMAT_U16;
    depth.data = depths;
    depth.width = depth.height = 8;
    depth.scale = 1e-3;
    uint32_t sizes[3][2] = {{0, 4}, {4, 0}, {0, 0}};
    for (int k = 0; k < 3; k++) {
        cylfuse_fitter *fitter = new_fitter();
        CHECK_STATUS(set_camera(fitter, 8, 8, 10.0, 10.0), OK);
        cylfuse_mask_view mask = mask_of(&pixel, sizes[k][0], sizes[k][1]);
        cylfuse_points_view view = view_of(points, 4);
        cylfuse_extent extent;
        cylfuse_completion completion;
        cylfuse_points_out out;
        cylfuse_depth_out depth_out;
        CHECK_STATUS(cylfuse_extent_init(&extent, sizeof extent), OK);
        CHECK_STATUS(cylfuse_completion_init(&completion, sizeof completion), OK);
        CHECK_STATUS(cylfuse_points_out_init(&out, sizeof out), OK);
        CHECK_STATUS(cylfuse_depth_out_init(&depth_out, sizeof depth_out), OK);
        out.scalar = CYLFUSE_SCALAR_F64;
        depth_out.format = CYLFUSE_DEPTH_FORMAT_U16;
        depth_out.data = depths;
        depth_out.width = depth_out.height = 8;
        size_t bound;
        CHECK_STATUS(cylfuse_fitter_push_points(fitter, &view, &mask), EMPTY_MASK);
        CHECK_STATUS(cylfuse_fitter_push_depth(fitter, &depth, &mask), EMPTY_MASK);
        CHECK_STATUS(cylfuse_fitter_extent(fitter, &CYLINDER, &mask, &extent), EMPTY_MASK);
        CHECK_STATUS(cylfuse_fitter_complete_bound(fitter, &mask, CYLFUSE_LAYOUT_PACKED, &bound), EMPTY_MASK);
        CHECK_STATUS(cylfuse_fitter_complete(fitter, &CYLINDER, &mask, CYLFUSE_LAYOUT_PACKED, &out, &completion),
                     EMPTY_MASK);
        CHECK_STATUS(cylfuse_fitter_complete_depth(fitter, &CYLINDER, &mask, &depth_out, &completion), EMPTY_MASK);
        CHECK_STATUS(cylfuse_fitter_clear(fitter), OK);
        destroy(fitter);
    }
}

/* The time of an extent has a bound, or the camera is refused for its focal length. */
static void endless_extents(void)
{
    enum { WIDTH = 47, HEIGHT = 62 };
    uint8_t pixels[WIDTH * HEIGHT] = {0};
    for (int row = 20; row < 40; row++) {
        memset(pixels + row * WIDTH + 5, 1, 35);
    }
    cylfuse_cylinder model = {{0.10537, 0.0128019, 1.8711}, {0.839322, -0.0992192, 0.534503}, 0.105141};
    for (double fx = 100.0; fx < 1e10; fx *= 10.0) {
        cylfuse_fitter *fitter = new_fitter();
        cylfuse_status status = set_camera(fitter, WIDTH, HEIGHT, fx, 85.2);
        if (status != CYLFUSE_STATUS_OK) {
            CHECK(status == CYLFUSE_STATUS_INVALID_INTRINSICS && fx > 1e5);
            CHECK(strstr(cylfuse_fitter_last_error(fitter), "fx is") != NULL);
        } else {
            cylfuse_mask_view mask = mask_of(pixels, WIDTH, HEIGHT);
            cylfuse_extent extent;
            CHECK_STATUS(cylfuse_extent_init(&extent, sizeof extent), OK);
            double before = seconds(CLOCK_PROCESS_CPUTIME_ID);
            cylfuse_fitter_extent(fitter, &model, &mask, &extent);
            if (!CHECK(seconds(CLOCK_PROCESS_CPUTIME_ID) - before < 0.2)) {
                printf("    with fx %g\n", fx);
                destroy(fitter);
                return;
            }
        }
        destroy(fitter);
    }
}

/* Leaves the process that much more memory. */
static void limit_memory(size_t bytes)
{
    long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file == NULL || fscanf(file, "%ld", &pages) != 1) {
        exit(2);
    }
    fclose(file);
    size_t all = (size_t)pages * (size_t)sysconf(_SC_PAGESIZE) + bytes;
    struct rlimit limit = {all, all};
    CHECK(setrlimit(RLIMIT_AS, &limit) == 0);
}

/* Where memory runs out, a call says so and the fitter stays usable. */
static void short_memory(const char *call)
{
    size_t count = 3000000, room = 20u << 20;
    double *points = cylinder_points(count);
    cylfuse_fitter *fitter = new_fitter();
    CHECK_STATUS(push(fitter, points, count), OK);
    cylfuse_options options = defaults();
    options.method = CYLFUSE_METHOD_POINTS;
    CHECK_STATUS(cylfuse_fitter_set_options(fitter, &options), OK);
    cylfuse_detector *detector = NULL;
    CHECK_STATUS(cylfuse_detector_create(CYLFUSE_ABI_VERSION, &detector), OK);
    limit_memory(room);
    if (strcmp(call, "detect") == 0) {
        cylfuse_points_view view = view_of(points, count);
        CHECK_STATUS(cylfuse_detector_detect_points(detector, &view), OUT_OF_MEMORY);
        CHECK(strstr(cylfuse_detector_last_error(detector), "out of memory") != NULL);
        view.width = 10;
        CHECK_STATUS(cylfuse_detector_detect_points(detector, &view), OK);
    } else if (strcmp(call, "residuals") == 0) {
        /* Into the caller's own memory: nothing more is needed. */
        size_t needed = 0;
        CHECK_STATUS(cylfuse_fitter_residuals(fitter, &CYLINDER, CYLFUSE_RESIDUAL_KIND_POINTS, points, 3 * count,
                                              &needed), OK);
        CHECK(needed == count && fabs(points[0]) < 1e-6);
    } else if (strcmp(call, "diagnose") == 0) {
        cylfuse_cylinder_diagnosis diagnosis;
        CHECK_STATUS(cylfuse_cylinder_diagnosis_init(&diagnosis, sizeof diagnosis), OK);
        cylfuse_status status = cylfuse_fitter_diagnose(fitter, &CYLINDER, &diagnosis);
        CHECK(status == CYLFUSE_STATUS_OK || status == CYLFUSE_STATUS_OUT_OF_MEMORY);
    } else if (strcmp(call, "push") == 0) {
        CHECK_STATUS(push(fitter, points, count), OUT_OF_MEMORY);
        cylfuse_counts counts;
        CHECK_STATUS(cylfuse_counts_init(&counts, sizeof counts), OK);
        CHECK_STATUS(cylfuse_fitter_counts(fitter, &counts), OK);
        CHECK(counts.points_given == count);
    } else {
        cylfuse_status status = fit(fitter).status;
        CHECK(status == CYLFUSE_STATUS_OK || status == CYLFUSE_STATUS_OUT_OF_MEMORY);
    }
    CHECK_STATUS(cylfuse_detector_destroy(detector), OK);
    CHECK_STATUS(cylfuse_fitter_clear(fitter), OK);
    CHECK_STATUS(push(fitter, points, 10), OK);
    destroy(fitter);
    free(points);
}

/* Where a thread cannot be started the work is done without it. */
static void no_threads(void)
{
    size_t count = 9000;
    double *points = cylinder_points(count);
    cylfuse_fitter *fitter = new_fitter();
    CHECK_STATUS(push(fitter, points, count), OK);
    free(points);
    cylfuse_options options = defaults();
    options.method = CYLFUSE_METHOD_POINTS;
    options.max_threads = 4;
    /* Room for the lists of a fit and three stacks. */
    limit_memory(15u << 19);
    CHECK_STATUS(cylfuse_fitter_set_options(fitter, &options), OK);
    CHECK_STATUS(fit(fitter).status, OK);
    CHECK_STATUS(cylfuse_fitter_clear(fitter), OK);
    destroy(fitter);
}

typedef struct {
    cylfuse_fitter *fitter;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    int running;
    /* The processor time of the thread that fits, and what it showed at the request. */
    clockid_t clock;
    double asked;
} canceller;

static int32_t tell_that_it_runs(const cylfuse_progress *progress, void *argument)
{
    canceller *shared = argument;
    (void)progress;
    pthread_mutex_lock(&shared->mutex);
    shared->running = 1;
    pthread_cond_signal(&shared->changed);
    pthread_mutex_unlock(&shared->mutex);
    return 0;
}

static void *cancel_later(void *argument)
{
    canceller *shared = argument;
    struct timespec pause = {0, 200000000};
    pthread_mutex_lock(&shared->mutex);
    while (!shared->running) {
        pthread_cond_wait(&shared->changed, &shared->mutex);
    }
    pthread_mutex_unlock(&shared->mutex);
    nanosleep(&pause, NULL);
    shared->asked = seconds(shared->clock);
    CHECK_STATUS(cylfuse_fitter_cancel(shared->fitter), OK);
    return NULL;
}

/* RANSAC hears of a request to cancel, and its limit is told where it is set. */
static void deaf_ransac(void)
{
    enum { COUNT = 5000 };
    double *points = malloc(3 * sizeof(double) * COUNT);
    for (int k = 0; k < 3 * COUNT; k++) {
        points[k] = uniform();
    }
    canceller shared = {.fitter = new_fitter()};
    pthread_mutex_init(&shared.mutex, NULL);
    pthread_cond_init(&shared.changed, NULL);
    CHECK(pthread_getcpuclockid(pthread_self(), &shared.clock) == 0);
    CHECK_STATUS(cylfuse_fitter_set_progress(shared.fitter, tell_that_it_runs, &shared), OK);
    CHECK_STATUS(push(shared.fitter, points, COUNT), OK);
    free(points);
    cylfuse_options options = defaults();
    options.method = CYLFUSE_METHOD_RANSAC;
    options.ransac_max_iterations = 2000000;
    CHECK_STATUS(cylfuse_fitter_set_options(shared.fitter, &options), INVALID_ARGUMENT);
    CHECK(strstr(cylfuse_fitter_last_error(shared.fitter), "ransac_max_iterations is 2000000") != NULL);
    options.ransac_max_iterations = 1000000;
    options.ransac_threshold = 1e-7;
    for (int k = 0; k < 2; k++) {
        options.method = k == 0 ? CYLFUSE_METHOD_RANSAC : CYLFUSE_METHOD_FUSED;
        options.start = CYLFUSE_START_RANSAC;
        CHECK_STATUS(cylfuse_fitter_set_options(shared.fitter, &options), OK);
        pthread_t thread;
        shared.running = 0;
        CHECK(pthread_create(&thread, NULL, cancel_later, &shared) == 0);
        CHECK_STATUS(fit(shared.fitter).status, CANCELLED);
        double ended = seconds(shared.clock);
        pthread_join(thread, NULL);
        /* 50 ms on a machine that does nothing else; all samples would take many seconds. */
        CHECK(ended - shared.asked < 0.2);
    }
    destroy(shared.fitter);
    pthread_cond_destroy(&shared.changed);
    pthread_mutex_destroy(&shared.mutex);
}

/* Limits that no arithmetic can keep are an error that names them. */
static void endless_limits(void)
{
    double *points = cylinder_points(500);
    const double radii[3] = {1e50, 1e155, 1.7e308};
    const cylfuse_method methods[2] = {CYLFUSE_METHOD_FUSED, CYLFUSE_METHOD_EBERLY};
    for (int k = 0; k < 6; k++) {
        cylfuse_fitter *fitter = new_fitter();
        CHECK_STATUS(push(fitter, points, 500), OK);
        cylfuse_options options = defaults();
        options.method = methods[k % 2];
        options.radius_min = options.radius_max = radii[k / 2];
        cylfuse_status status = cylfuse_fitter_set_options(fitter, &options);
        if (status == CYLFUSE_STATUS_OK) {
            status = fit(fitter).status;
        }
        CHECK(status != CYLFUSE_STATUS_OK && status != CYLFUSE_STATUS_EDGE_GEOMETRY);
        if (!CHECK(strstr(cylfuse_fitter_last_error(fitter), "radius") != NULL)) {
            printf("    radius %g: %s\n", radii[k / 2], cylfuse_fitter_last_error(fitter));
        }
        destroy(fitter);
    }
    free(points);
}

/* What a call says it may return, and what is checked when it is pushed. */
static void statuses_and_overflow(void)
{
    double line[10][3];
    for (int k = 0; k < 10; k++) {
        line[k][0] = k;
        line[k][1] = 2 * k;
        line[k][2] = 3 + k;
    }
    double out[600];
    size_t count = 0;
    cylfuse_fitter *fitter = new_fitter();
    CHECK_STATUS(push(fitter, line[0], 10), OK);
    CHECK_STATUS(cylfuse_fitter_residuals(fitter, &CYLINDER, CYLFUSE_RESIDUAL_KIND_POINTS, out, 600, &count), OK);
    CHECK(count == 10);
    destroy(fitter);

    /* Residuals of edges need no points. */
    double edges[2][4] = {{20, 0, 21, 47}, {40, 0, 41, 47}};
    cylfuse_segments_view segments;
    CHECK_STATUS(cylfuse_segments_view_init(&segments, sizeof segments), OK);
    segments.scalar = CYLFUSE_SCALAR_F64;
    segments.data = edges;
    segments.count = 2;
    cylfuse_cylinder model = {{0, 0, 1}, {0, 1, 0}, 0.12};
    fitter = new_fitter();
    CHECK_STATUS(set_camera(fitter, 64, 48, 80.0, 80.0), OK);
    CHECK_STATUS(cylfuse_fitter_push_edges(fitter, &segments), OK);
    CHECK_STATUS(cylfuse_fitter_residuals(fitter, &model, CYLFUSE_RESIDUAL_KIND_EDGES, out, 600, &count), OK);
    CHECK(count == 4 && isfinite(out[0]));
    CHECK_STATUS(push(fitter, line[0], 10), OK);
    CHECK_STATUS(cylfuse_fitter_residuals(fitter, &model, CYLFUSE_RESIDUAL_KIND_EDGES, out, 600, &count), OK);
    CHECK(count == 4);
    destroy(fitter);

    /* Points too far apart for arithmetic are refused, or have residuals. */
    float far[1500];
    for (int k = 0; k < 1500; k++) {
        far[k] = k < 300 ? 3e38f : -3e38f;
    }
    cylfuse_points_view view = view_of(far, 500);
    view.scalar = CYLFUSE_SCALAR_F32;
    fitter = new_fitter();
    if (cylfuse_fitter_push_points(fitter, &view, NULL) == CYLFUSE_STATUS_OK) {
        CHECK_STATUS(cylfuse_fitter_residuals(fitter, &CYLINDER, CYLFUSE_RESIDUAL_KIND_POINTS, out, 600, &count), OK);
        CHECK(!isnan(out[0]));
    }
    destroy(fitter);

    /* Weights that overflow are refused, or count as they are. */
    double *points = cylinder_points(500), weights[500];
    for (int k = 0; k < 500; k++) {
        weights[k] = 1e39;
    }
    view = view_of(points, 500);
    view.weights = weights;
    fitter = new_fitter();
    cylfuse_status status = cylfuse_fitter_push_points(fitter, &view, NULL);
    if (status == CYLFUSE_STATUS_OK) {
        CHECK_STATUS(fit(fitter).status, OK);
    } else {
        CHECK(status == CYLFUSE_STATUS_INVALID_ARGUMENT);
        CHECK(strstr(cylfuse_fitter_last_error(fitter), "weight") != NULL);
    }
    destroy(fitter);
    free(points);
}

/* Texts are those of the last call, and end with the remedy. */
static void stale_and_cut_texts(void)
{
    cylfuse_fitter *fitter = new_fitter(), *none = NULL;
    cylfuse_result result;
    CHECK_STATUS(cylfuse_result_init(&result, sizeof result), OK);
    CHECK_STATUS(cylfuse_fitter_get_result(fitter, &result), BAD_STATE);
    CHECK_STATUS(cylfuse_fitter_cancel(fitter), OK);
    CHECK(cylfuse_fitter_last_error(fitter)[0] == '\0');
    cylfuse_options options = defaults();
    options.initial_lambda = 1e300;
    options.max_lambda = 1e299;
    CHECK_STATUS(cylfuse_fitter_set_options(fitter, &options), INVALID_ARGUMENT);
    const char *text = cylfuse_fitter_last_error(fitter);
    CHECK(strlen(text) < 200 && strstr(text, "1e299") != NULL && strstr(text, "1e300") != NULL);
    CHECK_STATUS(cylfuse_fitter_create(7, &none), ABI_MISMATCH);
    CHECK_STATUS(cylfuse_fitter_destroy(NULL), OK);
    CHECK(cylfuse_fitter_last_error(NULL)[0] == '\0');
    destroy(fitter);
}

/* What a fit accepts, evaluate accepts too; a condition is a number or infinite. */
static void evaluate_and_fit(void)
{
    enum { COUNT = 2000 };
    double *points = malloc(3 * sizeof(double) * COUNT);
    for (int k = 0; k < COUNT; k++) {
        points[3 * k] = 0.5 * cos(0.37 * k) + 0.05;
        points[3 * k + 1] = 0.5 * sin(0.37 * k);
        points[3 * k + 2] = 1.0 + 0.02 * (k % 100);
    }
    double edges[2][4] = {{100, 100, 120, 400}, {500, 100, 480, 400}};
    cylfuse_segments_view segments;
    CHECK_STATUS(cylfuse_segments_view_init(&segments, sizeof segments), OK);
    segments.scalar = CYLFUSE_SCALAR_F64;
    segments.data = edges;
    segments.count = 2;
    cylfuse_fitter *fitter = new_fitter();
    CHECK_STATUS(set_camera(fitter, 640, 480, 570.0, 570.0), OK);
    CHECK_STATUS(push(fitter, points, COUNT), OK);
    CHECK_STATUS(cylfuse_fitter_push_edges(fitter, &segments), OK);
    outcome found = fit(fitter);
    if (CHECK_STATUS(found.status, OK)) {
        cylfuse_result again;
        CHECK_STATUS(cylfuse_result_init(&again, sizeof again), OK);
        CHECK_STATUS(cylfuse_fitter_evaluate(fitter, &found.estimate.model, &again, NULL), OK);
        CHECK(again.flags == found.result.flags);
        CHECK(again.segments_used == found.result.segments_used);
        CHECK(fabs(again.cost - found.result.cost) <= 1e-9 * found.result.cost);
    }
    destroy(fitter);
    free(points);

    for (int round = 0; round < 100; round++) {
        int count = 50 + round * 100;
        double arc = pow(10.0, -4.0 + 4.0 * (round % 40) / 40.0);
        float *narrow = malloc(3 * sizeof(float) * (size_t)count);
        for (int k = 0; k < count; k++) {
            double angle = 1.0 + arc * k / count;
            narrow[3 * k] = (float)(0.1 * cos(angle) + 0.1);
            narrow[3 * k + 1] = (float)(k * 7919 % 1000 * 1e-4 - 0.1);
            narrow[3 * k + 2] = (float)(1.6 + 0.1 * sin(angle));
        }
        cylfuse_points_view view = view_of(narrow, (size_t)count);
        view.scalar = CYLFUSE_SCALAR_F32;
        fitter = new_fitter();
        CHECK_STATUS(cylfuse_fitter_push_points(fitter, &view, NULL), OK);
        found = fit(fitter);
        CHECK(found.status != CYLFUSE_STATUS_OK || !isnan(found.result.condition));
        destroy(fitter);
        free(narrow);
    }

    /* All points in one place, far inside the model. */
    double same[20][3];
    for (int k = 0; k < 20; k++) {
        same[k][0] = 0.4;
        same[k][1] = -0.5;
        same[k][2] = 2.0;
    }
    cylfuse_cylinder large = CYLINDER;
    large.radius = 1e200;
    cylfuse_cylinder_diagnosis diagnosis;
    CHECK_STATUS(cylfuse_cylinder_diagnosis_init(&diagnosis, sizeof diagnosis), OK);
    fitter = new_fitter();
    CHECK_STATUS(push(fitter, same[0], 20), OK);
    if (cylfuse_fitter_diagnose(fitter, &large, &diagnosis) == CYLFUSE_STATUS_OK) {
        CHECK(!isnan(diagnosis.condition));
    }
    destroy(fitter);
}

static const struct {
    const char *name;
    void (*run)(void);
} CASES[] = {
    {"empty_masks", empty_masks},
    {"endless_extents", endless_extents},
    {"no_threads", no_threads},
    {"impossible_variances", impossible_variances},
    {"intrinsics_in_a_wrong_unit", intrinsics_in_a_wrong_unit},
    {"deaf_ransac", deaf_ransac},
    {"endless_limits", endless_limits},
    {"statuses_and_overflow", statuses_and_overflow},
    {"stale_and_cut_texts", stale_and_cut_texts},
    {"evaluate_and_fit", evaluate_and_fit},
};

/* Runs the case of a name; 0 where there is none. */
static int run(const char *name)
{
    for (size_t k = 0; k < sizeof CASES / sizeof *CASES; k++) {
        if (strcmp(CASES[k].name, name) == 0) {
            CASES[k].run();
            return 1;
        }
    }
    return 0;
}

int main(int count, char **arguments)
{
    const char *name = count > 1 ? arguments[1] : "";
    if (count > 2 && strcmp(name, "short_memory") == 0) {
        short_memory(arguments[2]);
    } else if (!run(name)) {
        printf("no case \"%s\"\n", name);
        return 2;
    }
    if (failures > 0) {
        printf("%d checks failed\n", failures);
        return 1;
    }
    puts("all checks hold");
    return 0;
}

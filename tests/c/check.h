/* Checks that count failures and go on, and what the files of this program share. */
#ifndef CHECK_H
#define CHECK_H

#include <cylfuse/cylfuse.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Reports a failed check; returns whether it held. */
int check(int holds, const char *what, const char *file, int line);
int check_status(cylfuse_status got, cylfuse_status expected, const char *call, const char *file, int line);
/* Also checks that the message on the fitter contains a text; an empty one stands for an empty message. */
int check_error(const cylfuse_fitter *fitter, cylfuse_status got, cylfuse_status expected, const char *text,
                const char *call, const char *file, int line);

#define CHECK(condition) check((condition) != 0, #condition, __FILE__, __LINE__)
#define CHECK_STATUS(call, status) check_status((call), CYLFUSE_STATUS_##status, #call, __FILE__, __LINE__)
#define CHECK_OK(call) CHECK_STATUS(call, OK)
/* The call comes first in the list, so that the message is read after it. */
#define CHECK_ERROR(fitter, call, status, text)                                                          \
    do {                                                                                                 \
        cylfuse_status status_of_call = (call);                                                          \
        check_error((fitter), status_of_call, CYLFUSE_STATUS_##status, (text), #call, __FILE__, __LINE__); \
    } while (0)
#define CHECK_NEAR(value, expected, tolerance) CHECK(fabs((value) - (expected)) <= (tolerance))

/* Memory of exactly this size, so that valgrind sees every byte read or written beyond. */
void *exactly(size_t size);
void *copy_of(const void *bytes, size_t size);

/* A scene with a known cylinder in front of a pinhole. */
enum { WIDTH = 160, HEIGHT = 120, PIXELS = WIDTH * HEIGHT, COLUMNS = 30, ROWS = 20, POINTS = COLUMNS * ROWS };

typedef struct {
    cylfuse_cylinder truth;
    /* The ends of the cylinder on its axis. */
    double start[3], end[3];
    cylfuse_intrinsics intrinsics;
    /* A cloud on the near wall, organised: COLUMNS along the axis, ROWS around it. */
    double points[POINTS][3];
    /* z of every pixel, of the cylinder or of a wall behind it. */
    float depth[PIXELS];
    uint8_t mask[PIXELS];
    /* A bright cylinder before a dark wall, averaged over the area of each pixel. */
    float image[PIXELS];
    /* x1 y1 x2 y2 of a piece of either limb. */
    double edges[2][4];
    /* Pixels of the mask. */
    size_t mask_pixels;
} scene;

extern scene the_scene;
void make_scene(void);

/* Views of the scene. */
cylfuse_points_view scene_points(void);
cylfuse_depth_view scene_depth(void);
cylfuse_mask_view scene_mask(void);
cylfuse_image_view scene_image(void);
cylfuse_segments_view scene_edges(void);

/* A new fitter; with intrinsics; with points and edges of the scene too. */
cylfuse_fitter *new_fitter(void);
cylfuse_fitter *new_camera_fitter(void);
cylfuse_fitter *new_full_fitter(void);
/* Destroys a fitter, which must succeed. */
void destroy(cylfuse_fitter *fitter);

cylfuse_result fit(cylfuse_fitter *fitter);
/* Fits and gives the cylinder; the cylinder of the last fit. */
cylfuse_cylinder_estimate fit_cylinder(cylfuse_fitter *fitter);
cylfuse_cylinder_estimate cylinder_of(const cylfuse_fitter *fitter);
cylfuse_counts counts(const cylfuse_fitter *fitter);
/* Whether a model is the true one to a tolerance in length and angle. */
int is_truth(const cylfuse_cylinder *model, double tolerance);
/* Whether the last fit, or a new one, gave the true one. */
int found_truth(const cylfuse_fitter *fitter, double tolerance);
int fits_truth(cylfuse_fitter *fitter, double tolerance);

void test_library(void);
void test_null_pointers(void);
void test_constants(void);
void test_struct_sizes(void);
void test_order_of_calls(void);
void test_points(void);
void test_depth(void);
void test_edges(void);
void test_image(void);
void test_fit(void);
void test_options(void);
void test_callbacks(void);
void test_threads(void);
void test_completion(void);
void test_extent(void);
void test_edge_selection(void);
void test_cylinder(void);
void test_plan(void);
void test_memory(void);
void test_batch(void);
void test_views(void);
void test_lists(void);
void test_readers(void);
void test_conformity(void);
void test_clone(void);
void test_detector(void);
void test_detector_calls(void);
#ifdef CYLFUSE_PANIC_TEST
void test_panic(void);
#endif

#endif

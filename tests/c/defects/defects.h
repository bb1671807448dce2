/* What the parts of this program share. */
#ifndef DEFECTS_H
#define DEFECTS_H

#include <cylfuse/cylfuse.h>

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#define CHECK(condition) check((condition) != 0, #condition, __LINE__)
#define CHECK_STATUS(call, status) check_status((call), CYLFUSE_STATUS_##status, #call, __LINE__)

/* How many checks failed. */
extern int failures;

/* A cylinder, and what a fit returned. */
extern const cylfuse_cylinder CYLINDER;

typedef struct {
    cylfuse_status status;
    cylfuse_result result;
    cylfuse_cylinder_estimate estimate;
} outcome;

int check(int holds, const char *what, int line);
int check_status(cylfuse_status got, cylfuse_status expected, const char *call, int line);
cylfuse_fitter *new_fitter(void);
void destroy(cylfuse_fitter *fitter);
cylfuse_points_view view_of(const void *points, size_t count);
cylfuse_status push(cylfuse_fitter *fitter, const double *points, size_t count);
cylfuse_status set_camera(cylfuse_fitter *fitter, uint32_t width, uint32_t height, double fx, double fy);
cylfuse_mask_view mask_of(const uint8_t *data, uint32_t width, uint32_t height);
cylfuse_options defaults(void);
outcome fit(cylfuse_fitter *fitter);
double *cylinder_points(size_t count);
double seconds(clockid_t of);
double uniform(void);

/* In covariance.c. */
void impossible_variances(void);
void intrinsics_in_a_wrong_unit(void);

#endif

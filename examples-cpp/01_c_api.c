/* Fits a cylinder to a depth image with mask and edges, in C: 01_c_api FOLDER */
#include <cylfuse/cylfuse.h>

#include <stdio.h>
#include <stdlib.h>

/* A binary PGM image of the given size; 16-bit values become those of the machine. NULL when it cannot be read. */
static void *read_pgm(const char *folder, const char *name, unsigned width, unsigned height, unsigned maximum)
{
    char path[4096];
    unsigned columns, rows, most;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (file == NULL) return NULL;
    const size_t count = (size_t)width * height, size = maximum > 255 ? 2 : 1;
    unsigned char *pixels = malloc(count * size);
    if (fscanf(file, "P5 %u %u %u", &columns, &rows, &most) != 3 || columns != width || rows != height ||
        most != maximum || fgetc(file) == EOF || pixels == NULL || fread(pixels, size, count, file) != count) {
        free(pixels);
        pixels = NULL;
    }
    fclose(file);
    for (size_t k = 0; pixels != NULL && size == 2 && k < count; k++) {
        ((uint16_t *)pixels)[k] = (uint16_t)(pixels[2 * k] << 8 | pixels[2 * k + 1]);
    }
    return pixels;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: %s FOLDER with camera.txt, depth.pgm, mask.pgm and edges.txt\n", argv[0]);
        return 2;
    }
    char path[4096];
    double unit; /* metres per unit of the depth image */
    cylfuse_intrinsics intrinsics;
    cylfuse_intrinsics_init(&intrinsics, sizeof intrinsics);
    snprintf(path, sizeof path, "%s/camera.txt", argv[1]);
    FILE *file = fopen(path, "r");
    if (file == NULL || fscanf(file, "%u %u %lf %lf %lf %lf %lf", &intrinsics.width, &intrinsics.height, &intrinsics.fx,
                               &intrinsics.fy, &intrinsics.cx, &intrinsics.cy, &unit) != 7) {
        fprintf(stderr, "%s cannot be read\n", path);
        return 1;
    }
    fclose(file);
    double edges[2][4]; /* x1 y1 x2 y2 of each, in pixels */
    snprintf(path, sizeof path, "%s/edges.txt", argv[1]);
    file = fopen(path, "r");
    for (int k = 0; k < 2; k++) {
        double *edge = edges[k];
        if (file == NULL || fscanf(file, "%lf %lf %lf %lf", &edge[0], &edge[1], &edge[2], &edge[3]) != 4) {
            fprintf(stderr, "%s cannot be read\n", path);
            return 1;
        }
    }
    fclose(file);

    cylfuse_depth_view depth;
    cylfuse_depth_view_init(&depth, sizeof depth);
    depth.format = CYLFUSE_DEPTH_FORMAT_U16;
    depth.width = intrinsics.width;
    depth.height = intrinsics.height;
    depth.scale = unit;
    depth.data = read_pgm(argv[1], "depth.pgm", depth.width, depth.height, 65535);
    cylfuse_mask_view mask;
    cylfuse_mask_view_init(&mask, sizeof mask);
    mask.width = intrinsics.width;
    mask.height = intrinsics.height;
    mask.data = read_pgm(argv[1], "mask.pgm", mask.width, mask.height, 255);
    if (depth.data == NULL || mask.data == NULL) {
        fprintf(stderr, "depth.pgm or mask.pgm in %s cannot be read\n", argv[1]);
        return 1;
    }
    cylfuse_segments_view segments;
    cylfuse_segments_view_init(&segments, sizeof segments);
    segments.scalar = CYLFUSE_SCALAR_F64;
    segments.data = edges;
    segments.count = 2;

    cylfuse_fitter *fitter;
    cylfuse_status status = cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &fitter);
    if (status != CYLFUSE_STATUS_OK) {
        fprintf(stderr, "%s\n", cylfuse_status_string(status));
        return 1;
    }
    cylfuse_result result;
    cylfuse_result_init(&result, sizeof result);
    cylfuse_cylinder_estimate cylinder;
    cylfuse_cylinder_estimate_init(&cylinder, sizeof cylinder);
    cylfuse_extent extent;
    cylfuse_extent_init(&extent, sizeof extent);
    if ((status = cylfuse_fitter_set_intrinsics(fitter, &intrinsics)) == CYLFUSE_STATUS_OK &&
        (status = cylfuse_fitter_push_depth(fitter, &depth, &mask)) == CYLFUSE_STATUS_OK &&
        (status = cylfuse_fitter_push_edges(fitter, &segments)) == CYLFUSE_STATUS_OK &&
        (status = cylfuse_fitter_fit(fitter, &result, &cylinder)) == CYLFUSE_STATUS_OK &&
        (status = cylfuse_fitter_extent(fitter, NULL, NULL, &extent)) == CYLFUSE_STATUS_OK) {
        const double *direction = cylinder.model.direction;
        printf("radius %.2f +- %.2f mm, length %.2f mm, axis %.4f %.4f %.4f\n", 1e3 * cylinder.model.radius,
               1e3 * cylinder.radius_deviation, 1e3 * extent.length, direction[0], direction[1], direction[2]);
        printf("%llu of %llu points used\n", (unsigned long long)result.points_used, (unsigned long long)result.points_given);
        printf("ends: %s and %s\n", cylfuse_end_state_string(extent.start_state), cylfuse_end_state_string(extent.end_state));
        for (int bit = 0; bit < 32; bit++) {
            const cylfuse_result_flags flag = result.flags & (cylfuse_result_flags)1 << bit;
            if (flag != 0) {
                printf("warning %s\n", cylfuse_flag_string(flag));
            }
        }
    } else {
        fprintf(stderr, "%s: %s\n", cylfuse_status_string(status), cylfuse_fitter_last_error(fitter));
    }
    cylfuse_fitter_destroy(fitter);
    free((void *)depth.data);
    free((void *)mask.data);
    return status != CYLFUSE_STATUS_OK;
}

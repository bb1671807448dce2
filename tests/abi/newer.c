/* A program of a later release that finds a library of this one: what docs/abi.md says of it. The structs here end with a field
   that this library does not know, as those of a later header may. */

#include <cylfuse/cylfuse.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition)                                                       \
    do {                                                                       \
        if (!(condition)) {                                                    \
            fprintf(stderr, "newer.c:%d: %s\n", __LINE__, #condition);         \
            exit(1);                                                           \
        }                                                                      \
    } while (0)
#define OK(call) CHECK((call) == CYLFUSE_STATUS_OK)

typedef struct { cylfuse_options known; double added; } newer_options;
typedef struct { cylfuse_result known; double added; } newer_result;
typedef struct { cylfuse_limb known; double added; } newer_limb;

/* A function that this library does not have: a program that can do without it declares it weak, and asks. */
__attribute__((weak)) cylfuse_status cylfuse_fitter_of_a_later_release(cylfuse_fitter *fitter);

int main(void) {
    cylfuse_fitter *fitter;
    OK(cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &fitter));
    CHECK(cylfuse_fitter_of_a_later_release == NULL);

    /* Defaults: what is not known is zero, which means the behaviour from before. */
    newer_options options;
    memset(&options, 0xaa, sizeof options);
    OK(cylfuse_options_init(&options.known, sizeof options));
    CHECK(options.added == 0 && options.known.struct_size == sizeof options && options.known.edge_weight == 0.6);
    OK(cylfuse_fitter_set_options(fitter, &options.known));
    /* What asks for more than there is fails, says so, and changes nothing. */
    options.added = 1;
    CHECK(cylfuse_fitter_set_options(fitter, &options.known) == CYLFUSE_STATUS_STRUCT_SIZE);
    CHECK(strstr(cylfuse_fitter_last_error(fitter), "update the library") != NULL);

    /* Outputs: struct_size says what was filled, the rest is zero. */
    double points[40][3];
    for (int k = 0; k < 40; k++) {
        points[k][0] = 0.01 * (k % 8) - 0.035;
        points[k][1] = 0.02 * (k / 8);
        points[k][2] = 1 - 5 * points[k][0] * points[k][0];
    }
    cylfuse_points_view view;
    OK(cylfuse_points_view_init(&view, sizeof view));
    view.scalar = CYLFUSE_SCALAR_F64;
    view.data = points;
    view.width = 40;
    OK(cylfuse_fitter_push_points(fitter, &view, NULL));
    newer_result result;
    memset(&result, 0xaa, sizeof result);
    OK(cylfuse_result_init(&result.known, sizeof result));
    OK(cylfuse_fitter_fit(fitter, &result.known, NULL));
    CHECK(result.known.struct_size == sizeof(cylfuse_result) && result.known.points_used == 40 && result.added == 0);
    newer_limb limbs[2];
    size_t count = 0;
    memset(limbs, 0xaa, sizeof limbs);
    OK(cylfuse_fitter_limbs(fitter, &limbs[0].known, sizeof limbs[0], 2, &count));
    CHECK(count == 2 && limbs[0].added == 0 && limbs[1].known.limb == 1 && limbs[1].added == 0);
    OK(cylfuse_fitter_destroy(fitter));

    /* A library that old programs cannot use says so at the first call. */
    CHECK(cylfuse_fitter_create(CYLFUSE_ABI_VERSION + 1, &fitter) == CYLFUSE_STATUS_ABI_MISMATCH);
    puts("the client runs");
    return 0;
}

/* A defect inside the library: in the library of tests/c/panic_library.rs only. */
#include "check.h"

#ifdef CYLFUSE_PANIC_TEST

CYLFUSE_API cylfuse_status cylfuse_test_panic(cylfuse_fitter *fitter) CYLFUSE_NOEXCEPT;

void test_panic(void)
{
    CHECK_STATUS(cylfuse_test_panic(NULL), NULL_POINTER);
    cylfuse_fitter *fitter = new_full_fitter(), *other = new_full_fitter();
    CHECK_ERROR(fitter, cylfuse_test_panic(fitter), PANIC, "provoked by cylfuse_test_panic");
    CHECK(strstr(cylfuse_fitter_last_error(fitter), "defect of the library") != NULL);
    /* The message stays, and nothing else works any more. */
    cylfuse_result result = {.struct_size = sizeof result};
    CHECK_ERROR(fitter, cylfuse_fitter_fit(fitter, &result, NULL), PANIC, "provoked by cylfuse_test_panic");
    CHECK_STATUS(cylfuse_fitter_clear(fitter), PANIC);
    CHECK_STATUS(cylfuse_fitter_cancel(fitter), PANIC);
    CHECK_STATUS(cylfuse_fitter_set_options(fitter, NULL), PANIC);
    CHECK_STATUS(cylfuse_test_panic(fitter), PANIC);
    destroy(fitter);
    CHECK(fits_truth(other, 1e-9));
    destroy(other);
}

#else

/* C99 wants at least one declaration. */
typedef int no_panic_test;

#endif

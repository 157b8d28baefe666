/* Nothing of fmu returns MBSR_OK with a number that is not finite; wrong calls are refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "scarce.h"
#include "units.h"

#include <mbsrank/fmu.h>

static int no_defaults(void)
{
    return !(mbsr_default_fmu_opt().rtol > 0.0);
}

static int no_export(void)
{
    mbsr_fmu *fmu;
    return mbsr_fmu_export(NULL, NULL, &fmu, NULL) == MBSR_OK || fmu != NULL;
}

static int no_destroy(void)
{
    mbsr_fmu_destroy(NULL);
    return 0;
}

static int no_motion(void)
{
    double s[3];
    mbsr_fmu_motion none = {.count = MBSR_FMU_MOTION_MOST + 1};
    return mbsr_fmu_stored_motion(NULL, 0.0, s, s + 1, s + 2) == MBSR_OK ||
           mbsr_fmu_stored_motion(&none, 0.0, s, s + 1, s + 2) == MBSR_OK;
}

/* Functions of the component (tests/hygiene/finite.sh), each with what must not come of NULL. */
static const struct {
    const char *name;
    int (*comes)(void);
} calls[] = {
    {"mbsr_default_fmu_opt", no_defaults},
    {"mbsr_fmu_export", no_export},
    {"mbsr_fmu_destroy", no_destroy},
    {"mbsr_fmu_stored_motion", no_motion},
};

static void nothing_comes_of_null(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof calls / sizeof *calls; ++k)
        if (calls[k].comes()) fail_msg("%s", calls[k].name);
}

/* ---- memory ---- */

static int exports(void *user)
{
    unit_model *m = user;
    mbsr_fmu *fmu = NULL;
    const int status = mbsr_fmu_export(m->s.model, NULL, &fmu, NULL);
    mbsr_fmu_destroy(fmu);
    return status;
}

static void each_allocation_of_an_export_fails(void **state)
{
    static void (*const make[])(unit_model * m) = {make_linkage, make_beam, make_flyer, make_heap};
    (void)state;
    for (int k = 0; k < 4; ++k) {
        unit_model m;
        make[k](&m);
        assert_int_equal(mbsr_model_finish(m.s.model), MBSR_OK);
        const long count = test_scarce_each(exports, &m, MBSR_ERR_NO_MEMORY, 1);
        if (count == -2)
            fail_msg("allocation %ld: %ld are left", test_memory.fail_at, test_memory.live);
        assert_true(count == -1 || count > 5);
        free_model(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(nothing_comes_of_null),
                                       cmocka_unit_test(each_allocation_of_an_export_fails)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

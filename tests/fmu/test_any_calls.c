/* Calls of FMUs in any order and damaged resources, as random bytes say: tests/fuzz/fuzz_fmu.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "fuzz_files.h"

#include "close.h"

enum { MOST = 600 };

/* Any call at any time ends with a status of the standard; what is fatal does not come. */
static void calls_end_with_a_status(void **state)
{
    static uint8_t bytes[MOST];
    (void)state;
    const int runs = test_long() ? 20000 : test_seeds(60, 160);
    for (int seed = 0; seed < runs; ++seed) {
        test_rng rng = test_seed((uint64_t)seed);
        for (int k = 0; k < MOST; ++k) bytes[k] = (uint8_t)test_integer(&rng, 0, 255);
        bytes[0] = (uint8_t)seed;
        if (seed % 2) /* numbers as callers mostly give them */
            for (int k = 1; k < MOST; ++k) bytes[k] = (uint8_t)(bytes[k] % 250);
        assert_int_equal(LLVMFuzzerTestOneInput(bytes, MOST), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(calls_end_with_a_status),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Damaged files of xacro: cut short, with other bytes, with pieces elsewhere. A smoke run of
 * tests/fuzz.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "damage.h"
#include "fuzz_files.h"

#include <stdio.h>
#include <string.h>

enum { MOST = 1 << 14 };

static void damaged_files_are_expanded_or_refused(void **state)
{
    static uint8_t good[MOST], bytes[MOST];
    (void)state;
    test_rng rng = test_seed(2);
    FILE *file = fopen(TEST_FOLDER "/tests/fuzz/corpus/small.xacro", "rb");
    assert_non_null(file);
    const size_t whole = fread(good, 1, MOST / 2, file);
    fclose(file);
    assert_true(whole > 1000);
    for (int k = 0; k < 1500; ++k) {
        size_t size = whole;
        memcpy(bytes, good, whole);
        for (size_t l = test_below(&rng, 4) + 1; l > 0; --l)
            size = test_damage(&rng, bytes, size, MOST);
        assert_int_equal(LLVMFuzzerTestOneInput(bytes, size), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_files_are_expanded_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

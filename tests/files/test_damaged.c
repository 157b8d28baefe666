/* Damaged files: cut short, with other bytes, with pieces elsewhere. A smoke run of tests/fuzz.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "damage.h"
#include "fuzz_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 1 << 16 };

static size_t read_corpus(const char *name, uint8_t *to)
{
    char path[600];
    snprintf(path, sizeof path, "%s/%s", TEST_FOLDER, name);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(to, 1, MOST / 2, file);
    fclose(file);
    assert_true(size > 100);
    return size;
}

static void damaged_files_are_read_or_refused(void **state)
{
    static const char *const names[] = {
        "tests/fuzz/corpus/small.urdf", "tests/fuzz/corpus/small.xml", "examples/models/arm.urdf",
        "examples/models/quarter_car.xml", "tests/fuzz/corpus/small.sdf"};
    (void)state;
    test_rng rng = test_seed(1);
    uint8_t *good = malloc(MOST), *bytes = malloc(MOST);
    for (int file = 0; file < 5; ++file) {
        const size_t whole = read_corpus(names[file], good);
        for (int k = 0; k < 1200; ++k) {
            size_t size = whole;
            memcpy(bytes, good, whole);
            for (size_t l = test_below(&rng, 4) + 1; l > 0; --l)
                size = test_damage(&rng, bytes, size, MOST);
            assert_int_equal(LLVMFuzzerTestOneInput(bytes, size), 0);
        }
    }
    free(good);
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_files_are_read_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

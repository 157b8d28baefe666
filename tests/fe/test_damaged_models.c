/* Damaged files: a smoke run of tests/fuzz/fuzz_fe.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "damage.h"
#include "duration.h"
#include "fuzz_fe.h"

#include <stdlib.h>
#include <string.h>

enum { MOST = 1 << 12 };

static void damaged_files_are_read_or_refused(void **state)
{
    (void)state;
    test_rng rng = test_seed(3);
    for (int file = 0; file < FUZZ_FE_TEXTS; ++file) {
        const size_t whole = strlen(fuzz_fe_text[file]);
        for (int k = 0; k < test_seeds(300, 2000); ++k) {
            uint8_t bytes[MOST + 1];
            size_t size = whole;
            memcpy(bytes + 1, fuzz_fe_text[file], whole);
            for (size_t l = test_below(&rng, 4); l > 0; --l)
                size = test_damage(&rng, bytes + 1, size, MOST);
            /* a block of its own size, so that reading beyond its end shows */
            uint8_t *text = malloc(size + 1);
            memcpy(text, bytes, size + 1);
            text[0] = (uint8_t)file;
            assert_int_equal(LLVMFuzzerTestOneInput(text, size + 1), 0);
            free(text);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_files_are_read_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

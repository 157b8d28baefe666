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

/* A block of its own size, so that reading beyond its end shows. */
static void read_in_place(int file, const char *text, size_t size)
{
    uint8_t *bytes = malloc(size + 1);
    bytes[0] = (uint8_t)file;
    memcpy(bytes + 1, text, size);
    assert_int_equal(LLVMFuzzerTestOneInput(bytes, size + 1), 0);
    free(bytes);
}

/* Each word in turn becomes another one, or is left out; each line is left out, or the last. */
static void each_word_becomes_another(void **state)
{
    static const char *const words[] = {"",  "x",     "-1",  "0",           "1",     "2",
                                        "7", "1e400", "nan", "99999999999", "100001"};
    enum { WORDS = sizeof words / sizeof *words };
    (void)state;
    int turn = 0;
    for (int file = 0; file < FUZZ_FE_TEXTS; ++file) {
        const char *text = fuzz_fe_text[file];
        const size_t size = strlen(text);
        char changed[MOST];
        for (size_t from = strcspn(text, " \n=,(") + 1; from < size;) {
            const size_t length = strcspn(text + from, " \n=,()"), behind = from + length;
            for (int k = 0; k < WORDS && length > 0; ++k) {
                if (!test_long() && turn++ % 3 != 0) continue;
                const size_t other = strlen(words[k]);
                memcpy(changed, text, from);
                memcpy(changed + from, words[k], other);
                memcpy(changed + from + other, text + behind, size - behind);
                read_in_place(file, changed, size - length + other);
            }
            from = behind + 1;
        }
        for (size_t from = 0; from < size;) {
            const size_t line = strcspn(text + from, "\n") + 1, behind = from + line;
            memcpy(changed, text, from);
            if (behind < size) memcpy(changed + from, text + behind, size - behind);
            read_in_place(file, changed, behind < size ? size - line : from);
            read_in_place(file, text, from);
            from = behind;
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_files_are_read_or_refused),
        cmocka_unit_test(each_word_becomes_another),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

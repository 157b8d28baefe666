/* Damaged files: cut short, with other bytes, with pieces elsewhere. A smoke run of tests/fuzz.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
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

static size_t below(test_rng *rng, size_t n)
{
    return (size_t)(0.5 * (1.0 + test_uniform(rng)) * (double)n) % n;
}

/* Some damage; the new size. */
static size_t damage(test_rng *rng, uint8_t *bytes, size_t size)
{
    static const char *const words[] = {"nan", "1e999", "-1", "0",     "\"",
                                        "<",   ">",     "/>", "&amp;", "a"};
    const size_t at = below(rng, size), other = below(rng, size);
    const char *word = words[below(rng, sizeof words / sizeof *words)];
    switch (below(rng, 5)) {
    case 0: return at > 0 ? at : 1;
    case 1: bytes[at] = (uint8_t)below(rng, 256); return size;
    case 2: { /* a piece once more */
        const size_t length = 1 + below(rng, size - other > 200 ? 200 : size - other);
        if (size + length > MOST) return size;
        memmove(bytes + at + length, bytes + at, size - at);
        memmove(bytes + at, bytes + (other < at ? other : other + length), length);
        return size + length;
    }
    case 3: { /* a piece less */
        const size_t length = 1 + below(rng, size - at > 100 ? 100 : size - at);
        if (size <= length) return size;
        memmove(bytes + at, bytes + at + length, size - at - length);
        return size - length;
    }
    default: {
        const size_t length = strlen(word) < size - at ? strlen(word) : size - at;
        memcpy(bytes + at, word, length);
        return size;
    }
    }
}

static void damaged_files_are_read_or_refused(void **state)
{
    static const char *const names[] = {"tests/fuzz/corpus/small.urdf",
                                        "tests/fuzz/corpus/small.xml", "examples/models/arm.urdf",
                                        "examples/models/quarter_car.xml"};
    (void)state;
    test_rng rng = test_seed(1);
    uint8_t *good = malloc(MOST), *bytes = malloc(MOST);
    for (int file = 0; file < 4; ++file) {
        const size_t whole = read_corpus(names[file], good);
        for (int k = 0; k < 1500; ++k) {
            size_t size = whole;
            memcpy(bytes, good, whole);
            for (size_t l = below(&rng, 4) + 1; l > 0; --l) size = damage(&rng, bytes, size);
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

/* Damaged study files: a smoke run of tests/fuzz.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "damage.h"
#include "fuzz_files.h"
#include "scarce.h"

#include <mbsrank/study.h>

#include <string.h>

enum { MOST = 1 << 12 };

static const char good[] =
    "# a study\nmodel \"car.xml\"\nrun --t-end 2 --start pushed\nlimit 100 steps\nlimit 2 s\n"
    "sample latin 100 seed 12\nvary bodies.body.mass 250 400 unit kg\nvary d 800 2500 log\n"
    "vary k normal 1.8e5 9e3\nkeep damper every 0.02 to 2\nkeep damper max unit m\n"
    "keep rate falls 0\nkeep rubber at 0.1 0.5\n";

/* Each word in turn becomes another one, or is left out. */
static void each_word_becomes_another(void **state)
{
    static const char *const words[] = {"",      "x",   "nan", "-1", "0",   "1e300",
                                        "every", "log", "#",   "\"", "2 3", "seed"};
    static uint8_t bytes[MOST];
    const size_t size = sizeof good - 1;
    (void)state;
    for (size_t from = 0; from < size;) {
        const size_t length = strcspn(good + from, " \n");
        for (size_t k = 0; k < sizeof words / sizeof *words; ++k) {
            const size_t other = strlen(words[k]);
            memcpy(bytes, good, from);
            memcpy(bytes + from, words[k], other);
            memcpy(bytes + from + other, good + from + length, size - from - length);
            assert_int_equal(LLVMFuzzerTestOneInput(bytes, size - length + other), 0);
        }
        from += length + 1;
    }
}

static int reads(void *user)
{
    mbsr_study *study;
    double value[8];
    (void)user;
    int status = mbsr_study_read(good, sizeof good - 1, "a.study", NULL, &study, NULL);
    if (!status) status = mbsr_study_values(study, 3, value);
    mbsr_study_destroy(study);
    return status;
}

static void each_allocation_fails(void **state)
{
    (void)state;
    const long count = test_scarce_each(reads, NULL, MBSR_ERR_NO_MEMORY, 1);
    if (count == -2)
        fail_msg("allocation %ld: %ld are left", test_memory.fail_at, test_memory.live);
    assert_true(count == -1 || count > 0);
}

static void damaged_studies_are_read_or_refused(void **state)
{
    static const char *const samples[] = {"sample sobol 100", "sample rando 100",
                                          "sample grid     "};
    static uint8_t bytes[MOST];
    (void)state;
    test_rng rng = test_seed(3);
    for (int k = 0; k < 4000; ++k) {
        size_t size = sizeof good - 1;
        memcpy(bytes, good, size);
        if (k % 4 > 0) memcpy(strstr((char *)bytes, "sample"), samples[k % 4 - 1], 16);
        for (size_t l = test_below(&rng, 4) + 1; l > 0; --l)
            size = test_damage(&rng, bytes, size, MOST);
        assert_int_equal(LLVMFuzzerTestOneInput(bytes, size), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_studies_are_read_or_refused),
        cmocka_unit_test(each_word_becomes_another),
        cmocka_unit_test(each_allocation_fails),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Damaged study files: a smoke run of tests/fuzz.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "damage.h"
#include "fuzz_files.h"

#include <string.h>

enum { MOST = 1 << 12 };

static void damaged_studies_are_read_or_refused(void **state)
{
    static const char good[] =
        "# a study\nmodel \"car.xml\"\nrun --t-end 2 --start pushed\nlimit 100 steps\nlimit 2 s\n"
        "sample latin 100 seed 12\nvary bodies.body.mass 250 400 unit kg\nvary d 800 2500 log\n"
        "vary k normal 1.8e5 9e3\nkeep damper every 0.02 to 2\nkeep damper max unit m\n"
        "keep rate falls 0\nkeep rubber at 0.1 0.5\n";
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
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* How much a test repeats.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"

#include <stdlib.h>
#include <string.h>

static bool set(const char *name)
{
    const char *value = getenv(name);
    return value && strcmp(value, "1") == 0;
}

bool test_long(void)
{
    return set("MBSR_TEST_LONG");
}

int test_seeds(int few, int many)
{
#if defined(TEST_SLOW_BUILD)
    const bool slow = true;
#else
    const bool slow = set("MBSR_TEST_FEW");
#endif
    return slow && !test_long() ? few : many;
}

int test_seeds_short(int few, int many)
{
    return set("MBSR_TEST_SHORT") && !test_long() ? few : test_seeds(few, many);
}

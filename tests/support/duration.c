/* How much a test repeats.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"

#include <stdlib.h>
#include <string.h>

bool test_long(void)
{
    const char *value = getenv("MBSR_TEST_LONG");
    return value && strcmp(value, "1") == 0;
}

int test_seeds(int few, int many)
{
#if defined(TEST_SLOW_BUILD)
    return test_long() ? many : few;
#else
    (void)few;
    return many;
#endif
}

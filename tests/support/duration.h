/* How much a test repeats: one place that knows how long a test may take.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * No test takes more than 30 s on a free processor, in any build; tests/CMakeLists.txt allows it
 * ten times as much. With MBSR_TEST_LONG=1 in the environment all run in full (scripts/test.sh
 * --long), with MBSR_TEST_FEW=1 all as short as in slow builds (its further runs of what another
 * has tested), with MBSR_TEST_SHORT=1 those that take longest, where more seeds hardly reach more
 * (all its runs). Only numbers of seeds and repetitions and lengths of runs differ, never
 * what is tested.
 */
#ifndef TEST_DURATION_H
#define TEST_DURATION_H

#include <stdbool.h>

/* Whether everything is to run in full. */
bool test_long(void);

/* A number of seeds or repetitions: `few` in Debug builds and under sanitizers, which take 4 to 20
 * times as long as others, and where few are asked for; `many` elsewhere and in long runs. */
int test_seeds(int few, int many);

/* The same in tests that take longest, which take `few` with MBSR_TEST_SHORT=1, too. */
int test_seeds_short(int few, int many);

#endif

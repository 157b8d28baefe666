/* Functions of tables that give a number which is not finite at one of their calls.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SPOIL_H
#define TEST_SPOIL_H

#include <mbsrank/mbsrank.h>

/* Call `at` of them, counted from 1, has `with` among its results; 0: none. */
typedef struct test_spoil_counts {
    long asked, at;
    double with;
} test_spoil_counts;

extern test_spoil_counts test_spoil_of;

/* A model of the same bodies, force elements and closures, the functions of whose tables are such
 * ones; not finished. What was amended there is not here. NULL: too many, or one is refused. The
 * model given, its tables and those of test_spoil_end outlive it. */
mbsr_model *test_spoil_copy(const mbsr_model *model);

/* Forgets the tables of all copies. */
void test_spoil_end(void);

#endif

/* Places of the library at which a status is taken: each fails in turn.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The linker puts functions of faults.c in the place of those that functions.h names (--wrap); they
 * call these, or say that they failed. A place is where one is called from. */
#ifndef TEST_FAULTS_H
#define TEST_FAULTS_H

#include "expect.h"

#include <stdbool.h>
#include <stddef.h>

/* Lists of functions, functions_*.h. */
typedef enum test_faults_list {
    TEST_FAULTS_CORE,
    TEST_FAULTS_IDA,
    TEST_FAULTS_LINEAR,
    TEST_FAULTS_CONTACT,
    TEST_FAULTS_FE,
    TEST_FAULTS_FILES,
    TEST_FAULTS_STUDY,
    TEST_FAULTS_FMU,
    TEST_FAULTS_PROGRAM,
    TEST_FAULTS_MEMORY /* malloc, calloc and realloc */
} test_faults_list;

/* What is called: it returns a status, leaves `count` numbers in out, and frees what it took. */
typedef struct test_faults_act {
    const char *name;
    int (*call)(void *user);
    void *user;
    double *out;
    size_t count;
    double tolerance; /* of numbers where another way was taken than the one that failed */
    int slow; /* 1: in short runs only first calls fail, and bits are compared now and then */
} test_faults_act;

/* Calls it, then lets each place fail at its first call and at its last: the status says so, or the
 * numbers are those without a failure; nothing is lost, and the next call gives the same bits.
 * Places that failed in an act of that name are spared in short runs. Returns how many failed; 0
 * where the act itself is refused. */
long test_faults_each(const test_faults_act *act);

/* From now on those fail alone that are so, by their list and the address behind their call; NULL:
 * all but memory. */
void test_faults_only(bool (*here)(test_faults_list list, const char *caller));

/* Within a call: from now on nothing fails, or it may. */
void test_faults_rest(bool rests);

#endif

/* What is asked of small mechanisms, where something fails on the way.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_ACTS_H
#define TEST_ACTS_H

#include "counting.h"

#include <mbsrank/mbsrank.h>

#include <stdbool.h>

enum { TEST_ACTS_MOST = 200, TEST_ACTS_PARTS = 10, TEST_ACTS_PART = 1024 };

/* A state, and room for what the acts find. */
typedef struct test_acts_scene {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu, size;
    double t, q[TEST_ACTS_MOST], u[TEST_ACTS_MOST], zero[TEST_ACTS_MOST];
    double y[TEST_ACTS_MOST], yp[TEST_ACTS_MOST], out[TEST_ACTS_PARTS * TEST_ACTS_PART];
} test_acts_scene;

/* Functions of the caller's: how often they were called, and which call says `with`, or where that
 * is MBSR_OK gives this number. */
typedef struct test_acts_counts {
    long asked, fail_at;
    int with;
    double gives;
    bool fail_on; /* from there on, too */
    test_counting memory;
} test_acts_counts;

extern test_acts_counts test_acts_of;

enum {
    TEST_OPEN = 1,
    TEST_CLOSED = 2,
    TEST_OPEN_MASSLESS = 4,
    TEST_CLOSED_MASSLESS = 8,
    TEST_ALL = 15
};

/* An act, and of which of these models it has an answer that asks the caller's functions. */
typedef struct test_acts {
    const char *name;
    int (*act)(test_acts_scene *s);
    int models;
} test_acts;

/* The last one has no name. */
extern const test_acts test_acts_table[];

/* A slider on springs: with a mass, without one, on springs that have no damping, and where the pin
 * is a spring, too. */
typedef enum test_acts_slider {
    TEST_HEAVY,
    TEST_MASSLESS,
    TEST_ELASTIC,
    TEST_COMPLIANT
} test_acts_slider;

/* The model: four bars, or three that are open, with functions of the caller's; without mass, or
 * with. */
void test_acts_make(test_acts_scene *s, bool closed, test_acts_slider kind);

/* A state of a model, whose motion in the momentum form starts there. False: it does not, or the
 * model is too large. */
bool test_acts_take(test_acts_scene *s, mbsr_model *model, mbsr_data *data, double t,
                    const double *q, const double *u);

#endif

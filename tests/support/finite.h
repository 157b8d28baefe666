/* No number that is not finite with MBSR_OK: one row of a table for each public function, and what
 * is done with it.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The function is called with one entry of an input after the other, then all of them, replaced by
 * NaN, infinities and numbers that overflow, and with NULL for each pointer in turn. Each time it
 * must refuse with a text that names a function, body or element, or give finite numbers; and a
 * good call afterwards gives the same bits as before. hygiene.finite fails for a function of the
 * headers that stands in no table. */
#ifndef TEST_FINITE_H
#define TEST_FINITE_H

#include "expect.h"

#include <stdbool.h>

typedef enum finite_input {
    FINITE_T, /* a number; the others are arrays */
    FINITE_C,
    FINITE_Q,
    FINITE_U,
    FINITE_TAU,
    FINITE_UDOT,
    FINITE_Y,
    FINITE_YP,
    FINITE_R,
    FINITE_OTHER,
    FINITE_INPUTS
} finite_input;

enum { FINITE_OUTPUTS = 3 };

/* Objects of a call, each of which may be NULL. */
enum { FINITE_MODEL = 1, FINITE_DATA = 2, FINITE_OBJECT = 4 };

typedef struct finite_subject {
    const char *name; /* for messages */
    mbsr_model *model;
    mbsr_data *data;
    void *object; /* an ODE, a solver, a batch */
    int nq, nu, id, states;
    mbsr_dae_form form;
    double *in[FINITE_INPUTS];
    int length[FINITE_INPUTS];
    double *out[FINITE_OUTPUTS];
    const mbsr_error *(*error)(const struct finite_subject *s); /* NULL: that of the data */
    const char *complained;                                     /* about this function */
    int complaints;
} finite_subject;

typedef struct finite_row {
    const char *function;
    int (*run)(finite_subject *s);     /* NULL: it writes no numbers */
    int (*prepare)(finite_subject *s); /* before; may be NULL */
    unsigned state;                    /* inputs that prepare reads: 1 << finite_input */
    unsigned in;                       /* inputs of the call itself */
    unsigned objects;
    int (*length)(const finite_subject *s, int output); /* of each output */
} finite_row;

/* Inputs of length 0 are empty. Numbers of all others must have been given. */
void finite_give(finite_subject *s, finite_input input, int n, const double *x);

/* All of the above; returns how many of the calls with good inputs were MBSR_OK (0 or 1). */
int finite_try(finite_subject *s, const finite_row *row);

/* Frees what finite_give took; fails if there were complaints. */
void finite_free(finite_subject *s);

#endif

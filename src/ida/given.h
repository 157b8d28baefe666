/* Joint coordinates and rates that a start is given.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_GIVEN_H
#define MBSRI_IDA_GIVEN_H

#include <mbsrank/mbsrank.h>

#include <stdbool.h>

/* One of a list. */
typedef struct mbsr_simulation_given {
    bool rate; /* of a rate, else of a position */
    int body, coordinate;
    double value;
    struct mbsr_simulation_given *next;
} mbsri_given;

/* Adds to the list, or replaces the value of that coordinate. MBSR_ERR_NO_MEMORY. */
int mbsri_given_add(mbsri_given **list, mbsri_given given);

/* Writes the values into q (nq) and u (nu) of a finished model, and marks in keep_position and
 * keep_rate (nu each) what is to stay. MBSR_ERR_ID, MBSR_ERR_VALUE, with the text in *error. */
int mbsri_given_apply(const mbsri_given *list, const mbsr_model *model, double *q, double *u,
                      int *keep_position, int *keep_rate, mbsr_error *error);

void mbsri_given_free(mbsri_given *list);

/* Coordinates zero; quaternions, which begin the q of joints with one number more, 1. */
void mbsri_given_nothing(const mbsr_model *m, double *q);

#endif

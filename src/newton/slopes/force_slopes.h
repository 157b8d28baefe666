/* Derivatives of force elements: the element's own, or differences.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FORCE_SLOPES_H
#define MBSRI_FORCE_SLOPES_H

#include "forces/columns.h"
#include "recursion/data.h"

/* Numbers of a perturbation of a body's pose. */
static inline int mbsri_pose_size(const mbsri_body *b)
{
    return mbsri_pose_numbers(b->joint.space, b->np);
}

/* What mbsri_force_slopes works in: one for a model's elements, one at a time. */
typedef struct mbsri_slopes {
    mbsr_force_derivatives out; /* of the last element; its pointers point into the memory below */
    int *row, *column;          /* most.element_bodies */
    double *matrix, *work;
} mbsri_slopes;

/* Doubles and ints that it needs, and where they are given to it. */
typedef enum mbsri_slopes_room {
    MBSRI_SLOPES_BY_PAIRS, /* of elements by pairs one pair at a time */
    MBSRI_SLOPES_WHOLE     /* all of any element */
} mbsri_slopes_room;
void mbsri_slopes_size(const mbsr_model *m, mbsri_slopes_room room, size_t *doubles, size_t *ints);
void mbsri_slopes_place(const mbsr_model *m, mbsri_slopes_room room, mbsri_slopes *s,
                        double *doubles, int *ints);

/* Derivatives of an element at the state of mbsr_stage_velocities, into s->out: its own, or central
 * differences. `body`: the index of the one body it is asked for, for elements that act on every
 * body; else not used. Returns what the element returned, or MBSR_NOT_FINITE, with the data's error
 * set. Leaves f and tau of the data as they were. */
int mbsri_force_slopes(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                       mbsri_slopes *s);

/* Those of one pair of an element by pairs, which has two bodies then: along their poses and
 * velocities. Such elements read no joints, whose columns are not written. */
int mbsri_pair_slopes(const mbsr_model *m, mbsr_data *d, const mbsri_force *force,
                      const int pair[2], mbsri_slopes *s);

/* The forces themselves, in the order of the rows; s->out has these and a matrix of zeros. */
int mbsri_force_values(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                       mbsri_slopes *s, double *forces);

/* The derivatives by differences, whatever the element has. */
int mbsri_force_differences(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                            mbsri_slopes *s);

#endif

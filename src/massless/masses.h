/* Masses that stay where they are and keep their momenta, while joints turn that move none of them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MASSES_H
#define MBSRI_MASSES_H

#include "recursion/data.h"

/* A state of all masses. */
typedef struct mbsri_masses {
    double *pose;     /* size_p: of every body */
    double *momentum; /* size_v: of every body, about its centre of mass */
    double *q;        /* nq: coordinates, where joints have inertia themselves */
    double *u;        /* nu: rates, likewise */
} mbsri_masses;

/* How many numbers a record takes, and where they stand in memory. */
size_t mbsri_masses_size(const mbsr_model *m);
void mbsri_masses_place(const mbsr_model *m, double *memory, mbsri_masses *masses);

/* Notes the state q, u (the caller's order), which the data is at with its velocities. */
void mbsri_masses_note(const mbsr_model *m, mbsr_data *d, const double *q, const double *u,
                       mbsri_masses *masses);

/* p (nu) = sum of J^T M x, x the motion that takes every mass from where it is at q, the data's
 * positions, to where it was: zero if and only if none has moved, and M dq to the first order else.
 */
void mbsri_masses_displacement(const mbsr_model *m, mbsr_data *d, const mbsri_masses *masses,
                               const double *q, double *p);

/* p (nu): the momenta noted, as generalised ones at the positions of the data. */
void mbsri_masses_momenta(const mbsr_model *m, mbsr_data *d, const mbsri_masses *masses, double *p);

#endif

/* Force elements over the whole tree: applied forces f and joint forces tau.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ELEMENTS_H
#define MBSRI_ELEMENTS_H

#include "recursion/data.h"

/* The stage: f and tau at the state of mbsri_velocities. tau (nu): by the caller's order, or NULL.
 * lambda (rows): loop forces, after the derivatives of the rows, which go to loop_lambda and may be
 * there already; NULL: those of stiff rows by their law, of others zero. */
int mbsri_forces(const mbsr_model *m, mbsr_data *d, const double *tau, const double *lambda);

/* Adds to tau what the force elements that act on joints alone exert; q, u in the order of the
 * sweeps. */
int mbsri_joint_elements(const mbsr_model *m, mbsr_data *d, const double *q, const double *u);

/* Adds to f of body i its weight. */
int mbsri_weigh(const mbsr_model *m, mbsr_data *d, int i);

/* Adds to f and tau what the others exert, gravity left out; reads p, V, M, q, u of the data. */
int mbsri_body_elements(const mbsr_model *m, mbsr_data *d);

/* Adds to f and tau what one element exerts, at the state of mbsri_velocities. */
int mbsri_add_element(const mbsr_model *m, mbsr_data *d, const mbsri_force *force);

/* Energy, or dissipated power, of an element, NULL: of all; at the state of mbsri_velocities. */
typedef enum mbsri_question {
    MBSRI_FORCES,
    MBSRI_ENERGY,
    MBSRI_DISSIPATION,
    MBSRI_DERIVATIVES
} mbsri_question;
int mbsri_element_sum(const mbsr_model *m, mbsr_data *d, const mbsri_force *force,
                      mbsri_question ask, double *sum);

/* Fills the data's force_bodies for a call of an element's derivatives, with f and tau NULL; `body`
 * is the one of an element that acts on every body. Returns how many. */
int mbsri_force_bodies(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body);

/* Adds to f (d) and tau (n) what an element exerts on the body at that place of its list, on the
 * body of that index if it acts on every body; at the state of mbsri_velocities. Neither is in the
 * scratch of the data. */
int mbsri_force_on(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int place,
                   double *f, double *tau);

/* What an element's functions are called with, for as many bodies of the data's force_bodies. */
mbsr_force_args mbsri_force_args(mbsr_data *d, const mbsri_force *force, int bodies);

/* The pairs of an element by pairs that act at the state of mbsri_velocities, to force_pairs, by
 * places in its list; force_bodies has all its bodies then. A status, with the text in the data. */
int mbsri_force_pairs(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int *count);

/* Fills the first two of force_bodies with those of a pair. */
void mbsri_pair_bodies(const mbsr_model *m, mbsr_data *d, const mbsri_force *force,
                       const int pair[2]);

/* Whether an element is switched off in the data. */
bool mbsri_force_off(const mbsr_model *m, const mbsr_data *d, const mbsri_force *force);

/* Reports the status of an element's function. */
int mbsri_force_failed(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int status,
                       const char *function);

/* The element of that id; NULL, reported as MBSR_ERR_ID, if there is none. */
const mbsri_force *mbsri_find_force(const mbsr_model *m, mbsr_data *d, int id,
                                    const char *function);

#endif

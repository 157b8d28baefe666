/* Finding one's way in a finished model.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_QUERY_H
#define MBSRI_QUERY_H

#include "model/record.h"

/* Index of a body by id; -1 if there is none. MBSR_GROUND is 0. */
int mbsri_index(const mbsr_model *m, int id);

/* What coordinate k of a joint measures, locked or not: one of q, or of u. */
mbsr_coordinate_kind mbsri_joint_kind(const mbsri_joint *joint, bool velocity, int k);

/* Place of free coordinate k among all of the joint. */
int mbsri_place_of_free(const mbsri_body *b, int k);

/* What free coordinate k of a body's joint measures: one of q, or of u. */
mbsr_coordinate_kind mbsri_coordinate_kind(const mbsri_body *b, bool velocity, int k);

/* mbsri_label of a body, by index. */
const char *mbsri_body_label(const mbsr_model *m, int i, char *buffer);

/* The body whose joint has rate `rate` of the caller's u. */
int mbsri_body_of_rate(const mbsr_model *m, int rate);

/* How a motion of body i gets inertia, for messages: "", or what flexible bodies on it lack. */
const char *mbsri_mass_advice(const mbsr_model *m, int i);

/* The closure of that id in a finished model; NULL if there is none. */
const mbsri_closure *mbsri_closure_of(const mbsr_model *m, int id);

/* Number of the force elements before those that have a law of one coordinate, which are the last.
 */
static inline size_t mbsri_other_forces(const mbsr_model *m)
{
    return m->forces.count - mbsri_coordinate_count(&m->elements.along);
}

/* mbsri_label of a closure. */
const char *mbsri_closure_label(const mbsr_model *m, int id, char *buffer);

/* Vectors over all joint rates between the caller's order and that of the sweeps. */
void mbsri_gather(const mbsr_model *m, const double *caller, double *in_order);
void mbsri_scatter(const mbsr_model *m, const double *in_order, double *caller);

#endif

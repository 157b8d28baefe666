/* Rates of H, J and M along the motion.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RATES_H
#define MBSRI_RATES_H

#include "recursion/data.h"

/* Hdot, Jdot, Mdot along the motion of the state at mbsri_velocities. */
int mbsri_rates(const mbsr_model *m, mbsr_data *d);

/* The same for one body, but for one whose differences need the whole tree. */
int mbsri_rates_of(const mbsr_model *m, mbsr_data *d, int i);
/* Without Mdot, unless that is found by differences. */
int mbsri_joint_rates_of(const mbsr_model *m, mbsr_data *d, int i);
bool mbsri_rates_need_tree(const mbsri_body *b);

/* Numbers that the differences of a body take in `displaced` of the data. */
size_t mbsri_rates_room(const mbsr_model *m, const mbsri_body *b);

#endif

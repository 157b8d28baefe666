/* What is found out about a tree in a position without symmetry, when its model is finished.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SURVEY_H
#define MBSRI_SURVEY_H

#include "recursion/data.h"

/* Data with all arrays takes some kB a body: of more bodies than these the survey is left out. */
enum { MBSRI_MOST_SURVEYED = 100000 };

/* Puts the data of a model that is finished but for that into such a position, at rest; false: the
 * functions of some joint do not give one. */
bool mbsri_survey_position(const mbsr_model *m, mbsr_data *d);

/* The same for the position zero; four numbers for three rates count as a quaternion. */
bool mbsri_survey_zero(const mbsr_model *m, mbsr_data *d);

/* Inverse inertias of the joint rates at the positions of the data, the joints behind held (nu, in
 * the order of the sweeps); of rates that move little a thousandth of the largest inertia of their
 * kind counts. Overwrites vec and imp. */
void mbsri_inverse_inertias(const mbsr_model *m, mbsr_data *d, double *weight);

/* Sets `scale` of the model and `whole` of its bodies, where joints may lack some of their rank.
 * Needs groups. False: no memory. */
bool mbsri_survey(mbsr_model *m);

#endif

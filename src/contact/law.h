/* The forces at one point of contact, and their derivatives.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CONTACT_LAW_H
#define MBSRI_CONTACT_LAW_H

#include "contact/touch.h"

/* What acts on body a of a point; the opposite on b. */
typedef struct mbsri_action {
    double p[3], arm_a[3], arm_b[3]; /* the point; from the origins of the bodies */
    double v[3], w[3];               /* of a relative to b at the point; angular velocity */
    double rate, elastic, normal;    /* rate of the depth; parts of N without and with damping */
    double sliding[3], speed, drag;  /* friction = -drag sliding */
    double wn, wt[3], torsion, roll; /* moment = -(torsion wn n + roll wt) */
    double force[3], moment[3];
} mbsri_action;

void mbsri_act(const mbsr_contact_law *law, const mbsri_touch *t, const mbsr_force_body *a,
               const mbsr_force_body *b, mbsri_action *action);

/* Adds to the derivatives; a and b are entries 0 and 1 of row and column, or, exchanged, 1 and 0.
 */
void mbsri_action_slopes(const mbsr_contact_law *law, const mbsri_touch *t,
                         const mbsr_force_body *a, const mbsr_force_body *b,
                         const mbsri_action *action, const mbsr_force_derivatives *out);

/* The energy of the point, and the power that it turns into heat. */
double mbsri_action_energy(const mbsr_contact_law *law, const mbsri_touch *t);
double mbsri_action_heat(const mbsri_action *action);

#endif

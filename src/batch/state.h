/* What the sweeps over several states keep of a body, and hand on.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BATCH_STATE_H
#define MBSRI_BATCH_STATE_H

#include "batch/record.h"
#include "batch/wide.h"

#include <string.h>

/* A coordinate's row of U D^-1, and D^-1 e. */
typedef struct column {
    vec g_L, g_p;
    lanes x;
} column;

/* Of a body in one evaluation. */
typedef struct body_state {
    mat R;          /* axes of its frame in the world */
    vec rho, omega; /* from the predecessor's origin to its own; angular velocity */
    vec A_w, A_v;   /* acceleration: first its part c without u', then all of it */
    column column;  /* of a joint of one axis; for inverse dynamics (L, p) of the body */
} body_state;

/* Of a joint with a quaternion: its axes stand on the predecessor. */
typedef struct ball_state {
    mat axes;
    column column[3];
} ball_state;

/* Mbar = [I G^T; G M], (L, p) and the bound of rounding errors, on the way to the predecessor. */
typedef struct carry {
    sym I, M;
    mat G;
    vec L, p;
    lanes kappa, spread;
} carry;

/* Origin of a body and its velocity, and its angle in the plane; in trees with bodies that are seen. */
typedef struct site {
    vec r, v;
    lanes angle;
} site;

MBSRI_INLINE lanes at(const double *x, int k)
{
    return *((const lanes *)x + k);
}

#endif

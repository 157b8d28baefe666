/* What the sweeps over several states keep of a body, and hand on; along the body's own axes,
 * unless said otherwise.
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
    lanes c, s;    /* cos, sin of theta */
    vec c_w, c_v;  /* acceleration without u' and the predecessor's */
    column column; /* of a joint of one axis; before that, and in inverse dynamics, (L, p) of the
                      body */
} body_state;

/* How a body moves, for its successors; kept for those that do not follow at once. K = [A_w]x +
 * [omega]x^2 is what the acceleration A_v + K x of a point x of the body needs. */
typedef struct motion {
    vec omega, A_w, A_v;
    sym squared; /* [omega]x^2 */
    mat K;
} motion;

/* Of a joint with a quaternion: its rates are along its own axes, to which R turns from the body's.
 */
typedef struct ball_state {
    mat R;
    column column[3];
} ball_state;

/* Mbar = [I G^T; G M], (L, p) and the bound of rounding errors, on the way to the predecessor. */
typedef struct carry {
    sym I, M;
    mat G;
    vec L, p;
    lanes kappa, spread;
} carry;

/* In the world: axes of a body, its origin and that one's velocity, and its angle in the plane; in
 * trees with bodies in the sweeps. */
typedef struct site {
    mat R;
    vec r, v, rho; /* rho: from the predecessor's origin */
    lanes angle;
} site;

MBSRI_INLINE lanes at(const double *x, int k)
{
    return *((const lanes *)x + k);
}

MBSRI_INLINE vec no_vec(void)
{
    return (vec){splat(0.0), splat(0.0), splat(0.0)};
}

/* What is left to ask of a hinge's flags, for code that the compiler makes of the general one. */
MBSRI_INLINE int hinge_flags(int flags)
{
    const int open = MBSRI_TWISTED | MBSRI_HERE | MBSRI_MASSLESS;
    return (flags & open) | MBSRI_HINGE | MBSRI_TURNS | MBSRI_TILTED;
}

/* From the predecessor's origin to the body's, along the predecessor's axes. */
MBSRI_INLINE vec arm_of(const mbsri_batch_run *run, const mbsri_batch_body *b, int flags)
{
    const vec x = vec_of(b->x);
    if (!(flags & MBSRI_SLIDES)) return x;
    const double sine = b->tilt[1], z[3] = {b->twist[1] * sine, -b->twist[0] * sine, b->tilt[0]};
    const lanes q = flags & MBSRI_MOVED ? splat(run->drive[3 * b->q]) : at(run->q, b->q);
    return plus(x, splat(b->pitch) * q, vec_of(z));
}

/* K from [omega]x^2 and A_w */
MBSRI_INLINE mat turning(const sym *squared, vec A_w)
{
    return (mat){{squared->xx, squared->xy + A_w.z, squared->xz - A_w.y},
                 {squared->xy - A_w.z, squared->yy, squared->yz + A_w.x},
                 {squared->xz + A_w.y, squared->yz - A_w.x, squared->zz}};
}

/* ---- vectors from the predecessor's axes to the body's, and back; t: by theta ---- */

/* Whether theta is not always zero. */
enum { MBSRI_ROUND = MBSRI_TURNS | MBSRI_BALL };

MBSRI_INLINE turn turn_of_body(const body_state *s)
{
    return turn_of(s->c, s->s);
}

MBSRI_INLINE vec to_own(const mbsri_batch_body *b, int flags, const turn *theta, vec a)
{
    if (flags & MBSRI_TWISTED) {
        const turn beta = fixed_turn(b->twist);
        a = back_about_z(&beta, a);
    }
    if (flags & MBSRI_TILTED) {
        const turn alpha = fixed_turn(b->tilt);
        a = back_about_x(&alpha, a);
    }
    return flags & MBSRI_ROUND ? back_about_z(theta, a) : a;
}

MBSRI_INLINE vec to_pred(const mbsri_batch_body *b, int flags, const turn *theta, vec a)
{
    if (flags & MBSRI_ROUND) a = about_z(theta, a);
    if (flags & MBSRI_TILTED) {
        const turn alpha = fixed_turn(b->tilt);
        a = about_x(&alpha, a);
    }
    if (flags & MBSRI_TWISTED) {
        const turn beta = fixed_turn(b->twist);
        a = about_z(&beta, a);
    }
    return a;
}

#endif

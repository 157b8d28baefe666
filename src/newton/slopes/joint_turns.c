/* Derivatives along motions of the predecessor: see joint_turns.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Such a joint turns with its predecessor. With T for the turning of both halves of a vector, r
 * from the predecessor's origin to the body's, and omega that of the predecessor,
 *
 *   omega_i = omega + w,   v_i = v + omega x r + z,   (w, z) = -(J u + k_I)
 *   A_i = (alpha, a + alpha x r) - J u' - k_II,   k_II = -(0, omega x r') + ...
 *
 * Along a small rotation theta, V of the predecessor held, w, z, J and what J' and k_II have of the
 * joint alone turn, but the rest does not:
 *
 *   dr = theta x r,   dr' = T r' - beta x r,   dJ = T J,   dJ' = T J' - beta x J,
 *       beta = theta x omega
 *   dk_II = T k_II - D beta,   D alpha = -(0, alpha x r' + omega x (alpha x r)) - alpha x (w, z)
 *
 * and along alpha of omega, dr' = alpha x r, dJ' = alpha x J, dk_II = D alpha. The lower half of H
 * is -r cross from the left: H^T m has -(r x m_2) and the like. */
#include "newton/slopes/joint_turns.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "joints/chain.h"

#include <string.h>

typedef struct turns {
    const mbsri_body *b;
    const mbsr_data *d;
    const double *omega;        /* of the predecessor */
    double r[3], rate[3];       /* from its origin, r' */
    double between[6], push[6]; /* (w, z); J u' */
} turns;

bool mbsri_joint_turns_serve(const mbsri_body *b)
{
    return b->joint.space == MBSR_SPACE_SPATIAL && b->pred.space == MBSR_SPACE_SPATIAL &&
           b->joint.table->tangent == mbsri_chain_tangent;
}

/* a x both halves of x, added. */
static void add_turn(const double a[3], const double *x, double *y)
{
    mbsri_add_cross3(a, x, y);
    mbsri_add_cross3(a, x + 3, y + 3);
}

static turns turns_of(const mbsr_data *d, const mbsri_body *b, bool accelerated, const double *udot)
{
    const double *V = d->V + b->v, *above = d->V + b->pred.v, *x = d->p + b->p + MBSR_POSE_X,
                 *x_pred = d->p + b->pred.p + MBSR_POSE_X;
    turns t = {.b = b, .d = d, .omega = above};
    for (int k = 0; k < 3; ++k) {
        t.r[k] = x[k] - x_pred[k];
        t.rate[k] = V[3 + k] - above[3 + k];
        t.between[k] = V[k] - above[k];
        t.between[3 + k] = t.rate[k];
    }
    mbsri_add_cross3(t.r, above, t.between + 3);
    if (accelerated) mbsri_ax(6, b->n, 1.0, d->J + b->dn, udot, t.push);
    return t;
}

/* y -= D alpha, with alpha x r. */
static void leave_bias(const turns *t, const double alpha[3], const double arm_rate[3], double *y)
{
    mbsri_add_cross3(alpha, t->rate, y + 3);
    mbsri_add_cross3(t->omega, arm_rate, y + 3);
    add_turn(alpha, t->between, y);
}

/* out_k += a . (J_k x m) for the columns of J: what of J^T m changes by a x J. */
static void add_turned(const turns *t, const double *J, const double a[3], const double *m,
                       double *out)
{
    for (int k = 0; k < t->b->n; ++k, J += 6) {
        double torque[3] = {0.0};
        mbsri_add_cross3(J, m, torque);
        mbsri_add_cross3(J + 3, m + 3, torque);
        out[k] += mbsri_dot3(a, torque);
    }
}

/* Along theta. */
static void pose_column(const turns *t, const double theta[3], bool accelerated, double *x,
                        double *below, double *own)
{
    const mbsr_data *d = t->d;
    const mbsri_body *b = t->b;
    const double *m = d->imp + b->v, *sigma = d->sigma + b->v, *mu = d->mu + b->v,
                 *J = d->J + b->dn;
    double beta[3], opposite[3], dr[3], arm_rate[3], drate[3];
    mbsri_cross3(theta, t->omega, beta);
    mbsri_cross3(theta, t->r, dr);
    mbsri_cross3(beta, t->r, arm_rate);
    mbsri_cross3(theta, t->rate, drate);
    mbsri_add3(-1.0, arm_rate, drate);
    for (int k = 0; k < 3; ++k) opposite[k] = -beta[k];
    mbsri_copy(3, theta, x);
    mbsri_copy(3, dr, x + 3);
    mbsri_add_cross3(t->omega, dr, x + 9);
    add_turn(theta, t->between, x + 6);
    mbsri_add_cross3(dr, m + 3, below);
    mbsri_add_cross3(dr, sigma + 3, below + 6);
    mbsri_add_cross3(drate, m + 3, below + 6);
    add_turned(t, J, theta, m, own);
    add_turned(t, J, theta, sigma, own + b->n);
    add_turned(t, d->Jdot + b->dn, theta, m, own + b->n);
    add_turned(t, J, opposite, m, own + b->n);
    if (!accelerated) return;
    double *A = x + 12, load[6], bias[6] = {0.0};
    for (int k = 0; k < 6; ++k) load[k] = -t->push[k] - d->kII[b->v + (size_t)k];
    leave_bias(t, beta, arm_rate, bias);
    for (int k = 0; k < 6; ++k) A[k] -= bias[k];
    add_turn(theta, load, A);
    mbsri_add_cross3(d->A + b->pred.v, dr, A + 3);
    mbsri_add_cross3(dr, mu + 3, below + 12);
    add_turned(t, J, theta, mu, own + 2 * b->n);
}

/* Along alpha of omega. */
static void rate_column(const turns *t, const double alpha[3], bool accelerated, double *x,
                        double *below, double *own)
{
    const mbsr_data *d = t->d;
    const mbsri_body *b = t->b;
    const double *m = d->imp + b->v;
    double arm_rate[3];
    mbsri_cross3(alpha, t->r, arm_rate);
    mbsri_copy(3, alpha, x + 6);
    mbsri_copy(3, arm_rate, x + 9);
    mbsri_add_cross3(arm_rate, m + 3, below + 6);
    add_turned(t, d->J + b->dn, alpha, m, own + b->n);
    if (accelerated) leave_bias(t, alpha, arm_rate, x + 12);
}

void mbsri_joint_turns(const mbsr_model *m, const mbsr_data *d, int i, bool accelerated,
                       const double *udot, double *x, double *below, double *own)
{
    const mbsri_body *b = m->body + i;
    const turns t = turns_of(d, b, accelerated, udot);
    const size_t n = 3 * (size_t)b->n;
    for (size_t k = 0; k < 3; ++k) {
        double axis[3] = {0.0};
        axis[k] = 1.0;
        pose_column(&t, axis, accelerated, x + 18 * k, below + 18 * k, own + n * k);
        const size_t rate = 6 + k, shift = 3 + k;
        rate_column(&t, axis, accelerated, x + 18 * rate, below + 18 * rate, own + n * rate);
        x[18 * shift + 3 + k] = 1.0;
        x[18 * (6 + shift) + 9 + k] = 1.0;
    }
}

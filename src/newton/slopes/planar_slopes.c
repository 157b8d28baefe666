/* Derivatives of a joint in the plane: see planar_slopes.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With r from the predecessor's origin to the body's, P for a quarter turn, v_k = -J_k without its
 * angle, and omega, alpha of the predecessor,
 *
 *   V_i = V + omega P r + sum v_k u_k + ...,   A_i = A + alpha P r - J u' - k_II
 *
 * where r, v_k and k_II turn with the predecessor. A turn of it changes r by P r, r' by P r', A_i -
 * A by its P; omega changes r' by P r and A_i by 2 P r'. What coordinate k carries turns with w,
 * the angular velocity of the body where k is its angle, else that of the predecessor:
 *
 *   along q_k:  dr = v_k,  dr' = w P v_k,  dA_i = w' P v_k - w^2 v_k
 *   along u_k:  dr' = v_k,  dA_i = 2 w P v_k
 *
 * Of the axes an angle turns its own alone. Rows: -dH^T m is dr x m, and dJ^T m is J_k x m, for
 * what turns. */
#include "newton/slopes/planar_slopes.h"

#include "algebra/dense.h"
#include "joints/planar.h"

/* Rows of x and of `below`; where V and A begin; columns of the predecessor. */
enum { ROWS = 9, V = 3, A = 6, OUTER = 9 };

typedef struct flat {
    const mbsr_data *d;
    const mbsri_body *b;
    bool accelerated, grounded;
    int n;
    double r[2], rate[2], omega, alpha; /* of the predecessor */
    double rise[3];                     /* -J u' - k_II */
    const double *m, *sigma, *mu, *J, *Jdot;
} flat;

bool mbsri_planar_slopes_serve(const mbsri_body *b)
{
    int free;
    return b->joint.space == MBSR_SPACE_PLANAR &&
           mbsri_planar_coordinates(b->joint.table, b->joint.option, &free) &&
           (b->pred.space == MBSR_SPACE_PLANAR || b->pred.space == MBSR_SPACE_FIXED);
}

static double cross(const double a[2], const double b[2])
{
    return a[0] * b[1] - a[1] * b[0];
}

/* y += s P a */
static void add_quarter(double s, const double a[2], double y[2])
{
    y[0] -= s * a[1];
    y[1] += s * a[0];
}

static flat flat_of(const mbsr_data *d, const mbsri_body *b, bool accelerated, const double *udot)
{
    flat f = {.d = d,
              .b = b,
              .accelerated = accelerated,
              .grounded = b->pred.space == MBSR_SPACE_FIXED,
              .n = b->n,
              .m = d->imp + b->v,
              .sigma = d->sigma + b->v,
              .mu = d->mu + b->v,
              .J = d->J + b->dn,
              .Jdot = d->Jdot + b->dn};
    if (!f.grounded) {
        const double *p = d->p + b->p, *above = d->p + b->pred.p;
        for (int l = 0; l < 2; ++l) {
            f.r[l] = p[l] - above[l];
            f.rate[l] = d->V[b->v + (size_t)l] - d->V[b->pred.v + (size_t)l];
        }
        f.omega = d->V[b->pred.v + 2];
    }
    if (!accelerated) return f;
    if (!f.grounded) f.alpha = d->A[b->pred.v + 2];
    mbsri_ax(3, f.n, -1.0, f.J, udot, f.rise);
    for (int l = 0; l < 3; ++l) f.rise[l] -= d->kII[b->v + (size_t)l];
    return f;
}

/* What changes of r and r' leave to the predecessor. */
static void leave(const flat *f, const double dr[2], const double drate[2], double *below)
{
    if (f->grounded) return;
    below[2] = cross(dr, f->m);
    below[5] = cross(dr, f->sigma) + cross(drate, f->m);
    if (f->accelerated) below[8] = cross(dr, f->mu);
}

/* What a turn makes of the rows of axis k. */
static void turn_axis(const flat *f, int k, double *own)
{
    const double *J = f->J + 3 * k;
    own[k] = cross(J, f->m);
    own[f->n + k] = cross(J, f->sigma) + cross(f->Jdot + 3 * k, f->m);
    if (f->accelerated) own[2 * f->n + k] = cross(J, f->mu);
}

/* The predecessor's pose and V. */
static void outer_columns(const flat *f, double *x, double *below, double *own)
{
    static const double none[2] = {0.0};
    const int rows = 3 * f->n, rate = V * ROWS, turn = 2 * ROWS, spin = rate + turn;
    for (int l = 0; l < 3; ++l) x[l * ROWS + l] = x[rate + l * ROWS + V + l] = 1.0;
    add_quarter(1.0, f->r, x + turn);
    add_quarter(1.0, f->rate, x + turn + V);
    leave(f, x + turn, x + turn + V, below + turn);
    add_quarter(1.0, f->r, x + spin + V);
    leave(f, none, x + spin + V, below + spin);
    for (int k = 0; k < f->n; ++k) {
        turn_axis(f, k, own + 2 * rows);
        own[5 * rows + f->n + k] = own[2 * rows + k];
    }
    if (!f->accelerated) return;
    add_quarter(f->alpha, x + turn, x + turn + A);
    add_quarter(1.0, f->rise, x + turn + A);
    add_quarter(2.0, f->rate, x + spin + A);
}

/* q_k and u_k. */
static void inner_columns(const flat *f, int k, double *q, double *u, double *below_q,
                          double *below_u, double *own_q, double *own_u)
{
    static const double none[2] = {0.0};
    const double *J = f->J + 3 * k;
    const bool angle = J[2] != 0.0;
    const double w = angle ? f->d->V[f->b->v + 2] : f->omega,
                 rate = f->alpha + (angle ? f->rise[2] : 0.0);
    for (int l = 0; l < 3; ++l) q[l] = u[V + l] = -J[l];
    add_quarter(w, q, q + V);
    leave(f, q, q + V, below_q);
    leave(f, none, u + V, below_u);
    if (angle) {
        turn_axis(f, k, own_q);
        own_u[f->n + k] = own_q[k];
    }
    if (!f->accelerated) return;
    add_quarter(rate, q, q + A);
    for (int l = 0; l < 2; ++l) q[A + l] -= w * w * q[l];
    add_quarter(2.0 * w, u + V, u + A);
}

void mbsri_planar_slopes(const mbsri_body *b, const mbsr_data *d, bool accelerated,
                         const double *udot, double *x, double *below, double *own, double *qdot)
{
    const flat f = flat_of(d, b, accelerated, udot);
    const int rows = 3 * b->n, actions = f.grounded ? 0 : ROWS, first = f.grounded ? 0 : OUTER;
    if (!f.grounded) outer_columns(&f, x, below, own);
    for (int k = 0; k < b->n; ++k) {
        const int q = first + k, u = q + b->nq;
        inner_columns(&f, k, x + q * ROWS, x + u * ROWS, below + q * actions, below + u * actions,
                      own + q * rows, own + u * rows);
        qdot[u * b->nq + k] = 1.0;
    }
}

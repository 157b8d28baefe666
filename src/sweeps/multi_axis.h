/* Articulated-body inertia and acceleration through joints of several axes, of prescribed ones, or
 * with a quaternion, in the vectorised sweeps.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_MULTI_AXIS_H
#define MBSRI_SWEEPS_MULTI_AXIS_H

#include "algebra/jacobi.h"
#include "algebra/space3.h"
#include "sweeps/carry.h"
#include "sweeps/lane.h"
#include "sweeps/tree.h"

#include <math.h>
#include <string.h>

/* (y_L, y_p) = Mbar (x_L, x_p) */
MBSRI_INLINE void apply(const mbsri_carry *m, const double x[8], double y[8])
{
    blocks c;
    v4 y_L, y_p;
    from_memory(m, &c);
    times_masses(&c, load(x), load(x + 4), &y_L, &y_p);
    store(y, y_L);
    store(y + 4, y_p);
}

MBSRI_INLINE double product(const double a[8], const double b[8])
{
    return sum3(load(a) * load(b) + load(a + 4) * load(b + 4));
}

/* |x|^2 in units of Lambda, or of its inverse. */
static double size_in_lambda(const double x[8], double area)
{
    return mbsri_dot3(x, x) * area + mbsri_dot3(x + 4, x + 4);
}

/* D <- factors of D = L diag(d) L^T: L below the diagonal, 1 / d on it. Returns a lower bound of
 * the smallest eigenvalue of D scaled to unit diagonal, 0 if D is not positive definite: the sum of
 * the other n - 1 is below n, so that
 *
 *   smallest = det / (product of the others) > det / (n / (n - 1))^(n - 1) > det / e */
static double factorise_small(int n, double D[6][6])
{
    double determinant = 1.0, diagonals = 1.0;
    for (int k = 0; k < n; ++k) {
        double d = D[k][k], Ld[6];
        diagonals *= d;
        for (int j = 0; j < k; ++j) {
            Ld[j] = D[k][j];
            for (int l = 0; l < j; ++l) Ld[j] -= Ld[l] * D[j][l];
        }
        for (int j = 0; j < k; ++j) {
            D[k][j] = Ld[j] * D[j][j];
            d -= Ld[j] * D[k][j];
        }
        if (!(d > 0.0)) return 0.0;
        determinant *= d;
        D[k][k] = 1.0 / d;
    }
    return determinant / (n > 1 ? 2.7182818284590452 * diagonals : diagonals);
}

/* Mbar -= a b^T, which is one of several that are symmetric together. */
MBSRI_INLINE void subtract(mbsri_carry *m, const double a[8], const double b[8])
{
    blocks c;
    from_memory(m, &c);
    subtract_dyad(load(a), load(a + 4), load(b), load(b + 4), &c);
    to_memory(&c, m);
}

/* U and D of a FREE body: columns of Mbar. */
MBSRI_INLINE void open_free(const mbsri_carry *c, mbsri_sweep_multi *multi)
{
    double M[36] = {0.0};
    mbsri_carry_add_to(c, M);
    for (int k = 0; k < 6; ++k) {
        const double *from = M + 6 * k;
        store(multi->U[k], (v4){from[0], from[1], from[2], 0.0});
        store(multi->U[k] + 4, (v4){from[3], from[4], from[5], 0.0});
        memcpy(multi->D[k], from, sizeof multi->D[k]);
    }
}

/* U, D, e, the factor of D; returns the bound of factorise. */
static double open_block(const mbsri_sweep_run *run, int i, const mbsri_carry *c)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    const double *armature = run->model->armature + b->u;
    _Alignas(32) double force[8];
    memcpy(force, c->L, sizeof c->L);
    memcpy(force + 4, c->p, sizeof c->p);
    const bool free = b->flags & MBSRI_FREE;
    if (free) open_free(c, multi);
    for (int k = 0; k < b->n && !free; ++k) {
        apply(c, multi->S[k], multi->U[k]);
        for (int l = 0; l <= k; ++l)
            multi->D[k][l] = multi->D[l][k] = product(multi->S[l], multi->U[k]);
    }
    for (int k = 0; k < b->n; ++k) {
        multi->D[k][k] += armature[k];
        multi->x[k] = run->tau[b->u + k] - product(multi->S[k], force);
    }
    memcpy(multi->factor, multi->D, sizeof multi->D);
    return factorise_small(b->n, multi->factor);
}

/* ---- full rank, by the bound or by W, as in rank_bound.h; lower ranks are for the stages ---- */

/* Whether least D_kk > clear times the bound of (S^T W S)_kk; then the bound behind the joint, but
 * for the transport through it. */
static bool multi_certify(const mbsri_sweep_run *run, int i, mbsri_carry *c, double least,
                          double *trace)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_multi *multi = run->multi + b->multi;
    const double area = run->tree->length * run->tree->length;
    double turning = 0.0, sliding = 0.0;
    *trace = 0.0;
    for (int k = 0; k < 3; ++k) {
        *trace += c->I[k] / area + c->M[k];
        turning += c->I[k];
        sliding += c->M[k];
    }
    c->spread += *trace;
    if (b->soft > 0.0) {
        const double own = c->spread * b->soft;
        c->kappa = own > c->kappa ? own : c->kappa;
        c->spread = 0.0;
    }
    for (int k = 0; k < b->n; ++k) {
        const double size = size_in_lambda(multi->S[k], area), Dkk = multi->D[k][k];
        const double *S = multi->S[k], turn = S[0] * S[0] + S[1] * S[1] + S[2] * S[2],
                     slide = S[4] * S[4] + S[5] * S[5] + S[6] * S[6];
        if (!mbsri_is_known_by_bound(&run->tree->rule, least * Dkk,
                                     c->kappa * Dkk + c->spread * size,
                                     turn * turning + slide * sliding))
            return false;
    }
    return true;
}

/* A += diag(x) */
static void add_to_diagonal(const double x[8], mbsri_carry *A)
{
    for (int k = 0; k < 3; ++k) {
        A->I[k] += x[k];
        A->M[k] += x[4 + k];
    }
}

static void diagonal_of(const mbsri_carry *A, double x[8])
{
    memset(x, 0, 8 * sizeof *x);
    for (int k = 0; k < 3; ++k) {
        x[k] = A->I[k];
        x[4 + k] = A->M[k];
    }
}

/* m |r|^2, r from the predecessor's origin, of which rounding of the arms of axes that a body
 * slides along is a part (mbsri_rotated_along in recursion/errors.h): eps r of r, not eps of the
 * square, so that a share of 1e-3 leaves more than nine digits. */
static double squared_sweep_arm(const mbsri_sweep_run *run, int i, const mbsri_carry *c)
{
    const double *rho = run->state[i].rho;
    return 1e-3 * (rho[0] * rho[0] + rho[1] * rho[1] + rho[2] * rho[2]) *
           fmax(c->M[0], fmax(c->M[1], c->M[2]));
}

/* Whether all eigenvalues of D scaled by diag(S^T W S)^(-1/2) are known to nine digits; Q = W S. */
static bool multi_judge(const mbsri_sweep_run *run, int i, const mbsri_carry *c, mbsri_carry *W,
                        double Q[6][8])
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_multi *multi = run->multi + b->multi;
    const int n = b->n;
    double own[8], scaled[36], scale[6], lambda[6];
    diagonal_of(c, own);
    add_to_diagonal(own, W);
    const double turned = W->spread + (n > 1 ? squared_sweep_arm(run, i, c) : 0.0);
    for (int k = 0; k < n; ++k) {
        apply(W, multi->S[k], Q[k]);
        const double *S = multi->S[k], turn = S[0] * S[0] + S[1] * S[1] + S[2] * S[2],
                     slide = S[4] * S[4] + S[5] * S[5] + S[6] * S[6],
                     noise = product(S, Q[k]) + turn * (slide > 0.0 ? turned : W->spread) +
                             run->model->armature[b->u + k];
        scale[k] = noise > 0.0 ? 1.0 / sqrt(noise) : 1.0;
    }
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < n; ++l) scaled[n * k + l] = scale[k] * multi->D[k][l] * scale[l];
    }
    return n == 0 || (mbsri_jacobi(n, scaled, lambda) == 0 &&
                      mbsri_is_known(&run->tree->rule, lambda[n - 1], 1.0));
}

/* W <- E as in rank_bound.h, with Mbar as it was before the joint; Q is overwritten. */
static void multi_transport(const mbsri_sweep_run *run, int i, const mbsri_carry *c, mbsri_carry *W,
                            double Q[6][8])
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_multi *multi = run->multi + b->multi;
    const int n = b->n;
    double own[8], gained[8], SQ[6][6];
    diagonal_of(c, own);
    memcpy(gained, own, sizeof own);
    for (int k = 0; k < n; ++k) {
        double size = run->model->armature[b->u + k];
        for (int r = 0; r < 8; ++r) size += own[r] * multi->S[k][r] * multi->S[k][r];
        for (int r = 0; r < 8; ++r) gained[r] += size * multi->G[k][r] * multi->G[k][r];
        for (int l = 0; l < n; ++l) SQ[k][l] = product(multi->S[l], Q[k]);
    }
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < n; ++l) {
            for (int r = 0; r < 8; ++r) Q[k][r] -= 0.5 * SQ[k][l] * multi->G[l][r];
        }
    }
    for (int k = 0; k < n; ++k) {
        subtract(W, Q[k], multi->G[k]);
        subtract(W, multi->G[k], Q[k]);
    }
    add_to_diagonal(gained, W);
}

/* G = U D^-1, row by row; returns a bound of |S G^T|^2. */
static double gain(const mbsri_sweep_run *run, int i, double area)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    const int n = b->n;
    double norm = 0.0, armature = 0.0;
    for (int r = 0; r < 8; ++r) {
        double row[6];
        for (int k = 0; k < n; ++k) row[k] = multi->U[k][r];
        if (r % 4 < 3) mbsri_solve_joint(n, multi->factor, row);
        for (int k = 0; k < n; ++k) multi->G[k][r] = row[k];
    }
    for (int k = 0; k < n; ++k) {
        norm += sqrt(size_in_lambda(multi->S[k], area) * size_in_lambda(multi->G[k], 1.0 / area));
        armature += run->model->armature[b->u + k];
    }
    norm *= norm;
    return armature > 0.0 ? 2.0 + 2.0 * norm : norm; /* see rank_bound.h */
}

/* Mbar^a, then (L, p) += Mbar^a c + G e; e becomes D^-1 e. */
static void multi_condense(const mbsri_sweep_run *run, int i, mbsri_carry *c)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    _Alignas(32) double bias[8], change[8];
    for (int k = 0; k < b->n; ++k) subtract(c, multi->G[k], multi->U[k]);
    memcpy(bias, s->A_w, sizeof s->A_w);
    memcpy(bias + 4, s->A_v, sizeof s->A_v);
    apply(c, bias, change);
    for (int k = 0; k < b->n; ++k) {
        for (int r = 0; r < 8; ++r) change[r] += multi->G[k][r] * multi->x[k];
    }
    for (int r = 0; r < 4; ++r) {
        c->L[r] += change[r];
        c->p[r] += change[4 + r];
    }
    mbsri_solve_joint(b->n, multi->factor, multi->x);
}

/* A joint behind which nothing has inertia, nor has it: u' = 0 as far as joints go, and the forces
 * pass. False: something has. */
static bool pass_empty(const mbsri_sweep_run *run, int i, const mbsri_carry *c)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    for (int k = 0; k < 8; ++k) {
        if (c->I[k] != 0.0 || c->M[k] != 0.0) return false;
    }
    for (int k = 0; k < b->n; ++k) {
        if (run->model->armature[b->u + k] != 0.0) return false;
    }
    memcpy(multi->e, multi->x, sizeof multi->e);
    memset(multi->x, 0, sizeof multi->x);
    memset(multi->factor, 0, sizeof multi->factor);
    memset(multi->G, 0, sizeof multi->G);
    run->rank[i] = 0;
    return true;
}

/* A body on the root hands nothing on. */
static bool multi_backward(const mbsri_sweep_run *run, int i, mbsri_carry *c, mbsri_carry *W)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    _Alignas(32) double Q[6][8];
    double trace = 0.0;
    apply(c, multi->drive, multi->driven);
    const double least = open_block(run, i, c), area = run->tree->length * run->tree->length;
    if (b->n > 0 && !(least > 0.0)) return pass_empty(run, i, c);
    if (!(W ? multi_judge(run, i, c, W, Q) : multi_certify(run, i, c, least, &trace))) return false;
    run->rank[i] = b->n;
    if (b->parent == 0) return true;
    const double norm = b->n > 0 ? gain(run, i, area) : 1.0;
    if (W)
        multi_transport(run, i, c, W, Q);
    else
        c->spread = c->spread * norm + trace * (1.0 + norm);
    multi_condense(run, i, c);
    return true;
}

#endif

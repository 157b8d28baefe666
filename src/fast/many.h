/* Joints of several axes, of prescribed ones, or with a quaternion, in the sweeps of kernels.h,
 * which includes this file. The joint's own functions move them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MANY_H
#define MBSRI_MANY_H

#include "fast.h"
#include "lane.h"

#include "../dense.h"
#include "../jacobi.h"
#include "../joints/chain.h"
#include "../space3.h"

#include <math.h>
#include <string.h>

/* The joint's arguments; everything is seen from the predecessor's origin as these sweeps use it,
 * which takes its velocity away from all. pose, V: of the predecessor. */
static mbsr_joint_args arguments(const mbsri_fast_run *run, int i, double pose[MBSR_POSE_SIZE],
                                 double V[6])
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_joint *joint = run->tree->joint + b->many;
    const mbsri_fast_state *pred = run->state + b->parent;
    const mbsri_body *body = run->model->body + i;
    const mbsr_joint_args args = {.param = body->joint.param,
                                  .option = body->joint.option,
                                  .motion = body->joint.motion,
                                  .user = body->joint.user,
                                  .d = body->d,
                                  .np = body->np,
                                  .n = body->joint.n,
                                  .nq = body->joint.nq,
                                  .t = run->data->t,
                                  .q = run->q + b->q,
                                  .u = run->u + b->u,
                                  .pred_space = body->pred_space,
                                  .pred_d = body->d_pred,
                                  .p_pred = pose,
                                  .V_pred = V};
    memset(V, 0, 6 * sizeof *V);
    if (args.pred_space != MBSR_SPACE_FIXED) {
        double R[9];
        for (int k = 0; k < 9; ++k) R[k] = pred->R[k / 3 * 4 + k % 3];
        mbsri_multiply3(R, joint->R, pose + MBSR_POSE_R);
        mbsri_rotate3(R, joint->x, pose + MBSR_POSE_X);
        memcpy(V, pred->omega, 3 * sizeof *V);
        mbsri_cross3(pred->omega, pose + MBSR_POSE_X, V + 3);
    }
    return args;
}

/* columns of six numbers as two vectors of four each */
static void spread_out(int n, const double *from, double (*to)[8])
{
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < 3; ++l) {
            to[k][l] = from[6 * k + l];
            to[k][4 + l] = from[6 * k + 3 + l];
        }
        to[k][3] = to[k][7] = 0.0;
    }
}

static int many_kinematics(const mbsri_fast_run *run, int i, bool velocity)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_state *pred = run->state + b->parent;
    mbsri_fast_state *s = run->state + i;
    mbsri_fast_many *many = run->many + b->many;
    double pose_pred[MBSR_POSE_SIZE], V_pred[6], pose[MBSR_POSE_SIZE];
    double S[36], Sdot[36], drive[6], bias[6], swing[3];
    const mbsr_joint_args args = arguments(run, i, pose_pred, V_pred);
    const int status = mbsri_chain_motion(&args, pose, S, drive, bias, velocity ? Sdot : NULL);
    if (status) return status;
    if (args.motion && (!mbsri_finite(12, pose) || !mbsri_finite(6, bias))) return MBSR_NOT_FINITE;
    for (int k = 0; k < 9; ++k) s->R[k / 3 * 4 + k % 3] = pose[MBSR_POSE_R + k];
    memcpy(s->rho, pose + MBSR_POSE_X, 3 * sizeof *s->rho);
    s->R[3] = s->R[7] = s->R[11] = s->rho[3] = s->A_w[3] = s->A_v[3] = 0.0;
    spread_out(b->n, S, many->S);
    spread_out(1, drive, &many->drive);
    /* omega_i = omega_pi + the angular part of S u + drive */
    memcpy(s->omega, pred->omega, sizeof s->omega);
    mbsri_add3(1.0, drive, s->omega);
    for (int k = 0; k < b->n; ++k) mbsri_add3(args.u[k], many->S[k], s->omega);
    /* c = -kII + omega_pi x (omega_pi x (the predecessor's own origin)) */
    mbsri_cross3(pred->omega, V_pred + 3, swing);
    for (int k = 0; k < 3; ++k) {
        s->A_w[k] = bias[k];
        s->A_v[k] = swing[k] + bias[3 + k];
    }
    if (!velocity) return MBSR_OK;
    /* v_i = v_pi + omega_pi x rho + the linear part of S u + drive */
    spread_out(b->n, Sdot, many->Sdot);
    mbsri_cross3(pred->omega, s->rho, s->v);
    mbsri_add3(1.0, pred->v, s->v);
    mbsri_add3(1.0, drive + 3, s->v);
    for (int k = 0; k < b->n; ++k) mbsri_add3(args.u[k], many->S[k] + 4, s->v);
    s->v[3] = 0.0;
    return MBSR_OK;
}

/* Columns of a block. */
MBSRI_INLINE void columns(const double A[12], v4 C[3])
{
    for (int k = 0; k < 3; ++k) C[k] = load(A + 4 * k);
}

/* (y_L, y_p) = Mbar (x_L, x_p) */
MBSRI_INLINE void apply(const mbsri_carry *c, const double x[8], double y[8])
{
    const v4 x_L = load(x), x_p = load(x + 4);
    v4 I[3], G[3], M[3];
    columns(c->I, I);
    columns(c->G, G);
    columns(c->M, M);
    store(y, times(I, x_L) + transposed_times(G, x_p));
    store(y + 4, times(G, x_L) + times(M, x_p));
}

MBSRI_INLINE double product(const double a[8], const double b[8])
{
    return sum3(load(a) * load(b) + load(a + 4) * load(b + 4));
}

/* |x|^2 in units of Lambda, or of its inverse. */
static double size_of(const double x[8], double area)
{
    return mbsri_dot3(x, x) * area + mbsri_dot3(x + 4, x + 4);
}

/* D <- factors of D = L diag(d) L^T: L below the diagonal, 1 / d on it. Returns a lower bound of
 * the smallest eigenvalue of D scaled to unit diagonal, 0 if D is not positive definite: the
 * product of all is the determinant, and that of the other n - 1, whose sum is below n, at most (n
 * / (n - 1))^(n - 1) < e. */
static double factorise(int n, double D[6][6])
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

/* x <- D^-1 x */
static void solve(int n, double D[6][6], double x[6])
{
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < k; ++l) x[k] -= D[k][l] * x[l];
    }
    for (int k = 0; k < n; ++k) x[k] *= D[k][k];
    for (int k = n - 1; k >= 0; --k) {
        for (int l = k + 1; l < n; ++l) x[k] -= D[l][k] * x[l];
    }
}

/* Mbar -= a b^T; G is the lower left block. */
MBSRI_INLINE void subtract(mbsri_carry *c, const double a[8], const double b[8])
{
    const v4 a_L = load(a), a_p = load(a + 4);
    for (int j = 0; j < 3; ++j) {
        store(c->I + 4 * j, load(c->I + 4 * j) - a_L * splat(b[j]));
        store(c->G + 4 * j, load(c->G + 4 * j) - a_p * splat(b[j]));
        store(c->M + 4 * j, load(c->M + 4 * j) - a_p * splat(b[4 + j]));
    }
}

/* U, D, e, the factor of D; returns the bound of factorise. */
static double open_block(const mbsri_fast_run *run, int i, const mbsri_carry *c)
{
    const mbsri_fast_body *b = run->tree->body + i;
    mbsri_fast_many *many = run->many + b->many;
    _Alignas(32) double force[8];
    memcpy(force, c->L, sizeof c->L);
    memcpy(force + 4, c->p, sizeof c->p);
    for (int k = 0; k < b->n; ++k) {
        apply(c, many->S[k], many->U[k]);
        for (int l = 0; l <= k; ++l)
            many->D[k][l] = many->D[l][k] = product(many->S[l], many->U[k]);
        many->x[k] = run->tau[b->u + k] - product(many->S[k], force);
    }
    memcpy(many->factor, many->D, sizeof many->D);
    return factorise(b->n, many->factor);
}

/* ---- full rank, by the bound or by W, as in kernels.h; joints of lower rank are for the stages */

/* Whether least D_kk > clear times the bound of (S^T W S)_kk; then the bound behind the joint, but
 * for the transport through it. */
static bool many_certify(const mbsri_fast_run *run, int i, mbsri_carry *c, double least,
                         double *trace)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_many *many = run->many + b->many;
    const double area = run->tree->length * run->tree->length;
    *trace = 0.0;
    for (int k = 0; k < 3; ++k) *trace += c->I[5 * k] / area + c->M[5 * k];
    c->spread += *trace;
    if (b->soft > 0.0) {
        const double own = c->spread * b->soft;
        c->kappa = own > c->kappa ? own : c->kappa;
        c->spread = 0.0;
    }
    for (int k = 0; k < b->n; ++k) {
        const double size = size_of(many->S[k], area), Dkk = many->D[k][k];
        if (!(least * Dkk > run->tree->clear * (c->kappa * Dkk + c->spread * size))) return false;
    }
    return true;
}

/* A += diag(x) */
static void add_to_diagonal(const double x[8], mbsri_carry *A)
{
    for (int k = 0; k < 3; ++k) {
        A->I[5 * k] += x[k];
        A->M[5 * k] += x[4 + k];
    }
}

static void diagonal_of(const mbsri_carry *A, double x[8])
{
    memset(x, 0, 8 * sizeof *x);
    for (int k = 0; k < 3; ++k) {
        x[k] = A->I[5 * k];
        x[4 + k] = A->M[5 * k];
    }
}

/* Whether all eigenvalues of D scaled by diag(S^T W S)^(-1/2) are above the tolerance; Q = W S. */
static bool many_judge(const mbsri_fast_run *run, int i, const mbsri_carry *c, mbsri_carry *W,
                       double Q[6][8])
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_many *many = run->many + b->many;
    const int n = b->n;
    double own[8], scaled[36], scale[6], lambda[6];
    diagonal_of(c, own);
    add_to_diagonal(own, W);
    for (int k = 0; k < n; ++k) {
        apply(W, many->S[k], Q[k]);
        const double noise = product(many->S[k], Q[k]);
        scale[k] = noise > 0.0 ? 1.0 / sqrt(noise) : 1.0;
    }
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < n; ++l) scaled[n * k + l] = scale[k] * many->D[k][l] * scale[l];
    }
    return n == 0 ||
           (mbsri_jacobi(n, scaled, lambda) == 0 && lambda[n - 1] > run->model->rank_tolerance);
}

/* W <- E as in kernels.h, with Mbar as it was before the joint; Q is overwritten. */
static void many_transport(const mbsri_fast_run *run, int i, const mbsri_carry *c, mbsri_carry *W,
                           double Q[6][8])
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_many *many = run->many + b->many;
    const int n = b->n;
    double own[8], gained[8], SQ[6][6];
    diagonal_of(c, own);
    memcpy(gained, own, sizeof own);
    for (int k = 0; k < n; ++k) {
        double size = 0.0;
        for (int r = 0; r < 8; ++r) size += own[r] * many->S[k][r] * many->S[k][r];
        for (int r = 0; r < 8; ++r) gained[r] += size * many->G[k][r] * many->G[k][r];
        for (int l = 0; l < n; ++l) SQ[k][l] = product(many->S[l], Q[k]);
    }
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < n; ++l) {
            for (int r = 0; r < 8; ++r) Q[k][r] -= 0.5 * SQ[k][l] * many->G[l][r];
        }
    }
    for (int k = 0; k < n; ++k) {
        subtract(W, Q[k], many->G[k]);
        subtract(W, many->G[k], Q[k]);
    }
    add_to_diagonal(gained, W);
}

/* G = U D^-1, row by row; returns a bound of |S G^T|^2. */
static double gain(const mbsri_fast_run *run, int i, double area)
{
    const mbsri_fast_body *b = run->tree->body + i;
    mbsri_fast_many *many = run->many + b->many;
    const int n = b->n;
    double norm = 0.0;
    for (int r = 0; r < 8; ++r) {
        double row[6];
        for (int k = 0; k < n; ++k) row[k] = many->U[k][r];
        if (r % 4 < 3) solve(n, many->factor, row);
        for (int k = 0; k < n; ++k) many->G[k][r] = row[k];
    }
    for (int k = 0; k < n; ++k)
        norm += sqrt(size_of(many->S[k], area) * size_of(many->G[k], 1.0 / area));
    return norm * norm;
}

/* Mbar^a, then (L, p) += Mbar^a c + G e; e becomes D^-1 e. */
static void many_condense(const mbsri_fast_run *run, int i, mbsri_carry *c)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_state *s = run->state + i;
    mbsri_fast_many *many = run->many + b->many;
    _Alignas(32) double bias[8], change[8];
    for (int k = 0; k < b->n; ++k) subtract(c, many->G[k], many->U[k]);
    memcpy(bias, s->A_w, sizeof s->A_w);
    memcpy(bias + 4, s->A_v, sizeof s->A_v);
    apply(c, bias, change);
    for (int k = 0; k < b->n; ++k) {
        for (int r = 0; r < 8; ++r) change[r] += many->G[k][r] * many->x[k];
    }
    for (int r = 0; r < 4; ++r) {
        c->L[r] += change[r];
        c->p[r] += change[4 + r];
    }
    solve(b->n, many->factor, many->x);
}

/* A body on the root hands nothing on. */
static bool many_backward(const mbsri_fast_run *run, int i, mbsri_carry *c, mbsri_carry *W)
{
    const mbsri_fast_body *b = run->tree->body + i;
    mbsri_fast_many *many = run->many + b->many;
    _Alignas(32) double Q[6][8];
    double trace = 0.0;
    apply(c, many->drive, many->driven);
    const double least = open_block(run, i, c), area = run->tree->length * run->tree->length;
    if (b->n > 0 && !(least > 0.0)) return false;
    if (!(W ? many_judge(run, i, c, W, Q) : many_certify(run, i, c, least, &trace))) return false;
    run->rank[i] = b->n;
    if (b->parent == 0) return true;
    const double norm = b->n > 0 ? gain(run, i, area) : 1.0;
    if (W)
        many_transport(run, i, c, W, Q);
    else
        c->spread = c->spread * norm + trace * (1.0 + norm);
    many_condense(run, i, c);
    return true;
}

/* u' = D^-1 (e - U^T A),  A += S u' */
static void many_forward(const mbsri_fast_run *run, int i)
{
    const mbsri_fast_body *b = run->tree->body + i;
    mbsri_fast_state *s = run->state + i;
    mbsri_fast_many *many = run->many + b->many;
    const bool on_root = b->parent == 0;
    _Alignas(32) double A[8];
    double *x = many->x;
    memcpy(A, s->A_w, sizeof s->A_w);
    memcpy(A + 4, s->A_v, sizeof s->A_v);
    for (int k = 0; k < b->n; ++k) x[k] -= product(on_root ? many->U[k] : many->G[k], A);
    if (on_root) solve(b->n, many->factor, x);
    for (int k = 0; k < b->n; ++k) {
        run->out[b->u + k] = x[k];
        mbsri_add3(x[k], many->S[k], s->A_w);
        mbsri_add3(x[k], many->S[k] + 4, s->A_v);
    }
}

/* ---- momentum form, see kernels.h ---- */

static void many_momentum(const mbsri_fast_run *run, int i, mbsri_flow *f)
{
    const mbsri_fast_body *b = run->tree->body + i;
    mbsri_fast_many *many = run->many + b->many;
    _Alignas(32) double wrench[8] = {0.0};
    double vp[3];
    mbsri_cross3(run->state[i].v, f->p, vp);
    memcpy(wrench, f->N, 3 * sizeof *wrench);
    mbsri_add3(-1.0, vp, wrench);
    memcpy(wrench + 4, f->F, 3 * sizeof *wrench);
    mbsri_add3(1.0, many->driven, f->L_bar);
    mbsri_add3(1.0, many->driven + 4, f->p_bar);
    for (int k = 0; k < b->n; ++k) {
        const double *S = many->S[k], *rate = many->Sdot[k];
        run->out[b->u + k] = run->tau[b->u + k] + product(S, wrench) + mbsri_dot3(rate, f->L) +
                             mbsri_dot3(rate + 4, f->p);
        many->x[k] = run->p[b->u + k] - mbsri_dot3(S, f->L_bar) - mbsri_dot3(S + 4, f->p_bar);
    }
    for (int k = 0; k < b->n && b->parent > 0; ++k) {
        mbsri_add3(many->x[k], many->G[k], f->L_bar);
        mbsri_add3(many->x[k], many->G[k] + 4, f->p_bar);
    }
}

/* D u - ep + U^T X V_pi; V = X V_pi */
static void many_balance(const mbsri_fast_run *run, int i, const double V[8])
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_many *many = run->many + b->many;
    for (int k = 0; k < b->n; ++k) {
        double r = product(many->U[k], V) - many->x[k];
        for (int l = 0; l < b->n; ++l) r += many->D[k][l] * run->u[b->u + l];
        run->balance[b->u + k] = r;
    }
}

#endif

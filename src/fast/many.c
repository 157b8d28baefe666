/* Joints of several axes, of prescribed ones, or with a quaternion, in the sweeps of fast.h. The
 * joint's own functions move them.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fast.h"

#include "../dense.h"
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
    mbsr_joint_args args = mbsri_joint_args(run->model, run->data, i, false);
    double R[9];
    for (int k = 0; k < 9; ++k) R[k] = pred->R[k / 3 * 4 + k % 3];
    mbsri_multiply3(R, joint->R, pose + MBSR_POSE_R);
    mbsri_rotate3(R, joint->x, pose + MBSR_POSE_X);
    memcpy(V, pred->omega, 3 * sizeof *V);
    mbsri_cross3(pred->omega, pose + MBSR_POSE_X, V + 3);
    args.t = run->data->t;
    args.q = run->q + b->q;
    args.u = run->u + b->u;
    args.p_pred = pose;
    args.V_pred = V;
    args.p = args.V = NULL;
    return args;
}

/* columns of six numbers as two vectors of four each */
static void spread_out(int n, const double *from, double to[6][8])
{
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < 3; ++l) {
            to[k][l] = from[6 * k + l];
            to[k][4 + l] = from[6 * k + 3 + l];
        }
        to[k][3] = to[k][7] = 0.0;
    }
}

int mbsri_many_kinematics(const mbsri_fast_run *run, int i, bool velocity)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_state *pred = run->state + b->parent;
    mbsri_fast_state *s = run->state + i;
    mbsri_fast_many *many = run->many + b->many;
    double pose_pred[MBSR_POSE_SIZE], V_pred[6], pose[MBSR_POSE_SIZE];
    double S[36], Sdot[36], kI[3], bias[6], swing[3];
    const mbsr_joint_args args = arguments(run, i, pose_pred, V_pred);
    const int status = mbsri_chain_motion(&args, pose, S, kI, bias, velocity ? Sdot : NULL);
    if (status) return status;
    for (int k = 0; k < 9; ++k) s->R[k / 3 * 4 + k % 3] = pose[MBSR_POSE_R + k];
    memcpy(s->rho, pose + MBSR_POSE_X, 3 * sizeof *s->rho);
    s->R[3] = s->R[7] = s->R[11] = s->rho[3] = s->A_w[3] = s->A_v[3] = 0.0;
    spread_out(b->n, S, many->S);
    /* omega_i = omega_pi + (S u - kI), the angular part */
    memcpy(s->omega, pred->omega, sizeof s->omega);
    mbsri_add3(-1.0, kI, s->omega);
    for (int k = 0; k < b->n; ++k) mbsri_add3(args.u[k], many->S[k], s->omega);
    /* c = -kII + omega_pi x (omega_pi x (the predecessor's own origin)) */
    mbsri_cross3(pred->omega, V_pred + 3, swing);
    for (int k = 0; k < 3; ++k) {
        s->A_w[k] = bias[k];
        s->A_v[k] = swing[k] + bias[3 + k];
    }
    if (!velocity) return MBSR_OK;
    /* v_i = v_pi + omega_pi x rho + the linear part of S u */
    spread_out(b->n, Sdot, many->Sdot);
    mbsri_cross3(pred->omega, s->rho, s->v);
    mbsri_add3(1.0, pred->v, s->v);
    for (int k = 0; k < b->n; ++k) mbsri_add3(args.u[k], many->S[k] + 4, s->v);
    s->v[3] = 0.0;
    return MBSR_OK;
}

/* (y_L, y_p) = Mbar (x_L, x_p) */
static void apply(const mbsri_carry *c, const double x[8], double y[8])
{
    memset(y, 0, 8 * sizeof *y);
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) {
            y[k] += c->I[4 * j + k] * x[j] + c->G[4 * k + j] * x[4 + j];
            y[4 + k] += c->G[4 * j + k] * x[j] + c->M[4 * j + k] * x[4 + j];
        }
    }
}

static double product(const double a[8], const double b[8])
{
    return mbsri_dot3(a, b) + mbsri_dot3(a + 4, b + 4);
}

/* |x|^2 in units of Lambda, or of its inverse. */
static double size_of(const double x[8], double area)
{
    return mbsri_dot3(x, x) * area + mbsri_dot3(x + 4, x + 4);
}

/* D <- Cholesky factor of D scaled to unit diagonal, with inverse diagonal; returns a lower bound
 * of the scaled matrix's smallest eigenvalue: the product of all is the determinant, and that of
 * the other n - 1, whose sum is below n, at most (n / (n - 1))^(n - 1) < e. */
static double factorise(int n, double D[6][6], double scale[6])
{
    double determinant = 1.0;
    for (int k = 0; k < n; ++k) {
        if (!(D[k][k] > 0.0)) return 0.0;
        scale[k] = 1.0 / sqrt(D[k][k]);
    }
    for (int k = 0; k < n; ++k) {
        for (int j = 0; j <= k; ++j) {
            double sum = D[k][j] * scale[k] * scale[j];
            for (int l = 0; l < j; ++l) sum -= D[k][l] * D[j][l];
            if (j < k) {
                D[k][j] = sum * D[j][j];
            } else {
                if (!(sum > 0.0)) return 0.0;
                determinant *= sum;
                D[k][k] = 1.0 / sqrt(sum);
            }
        }
    }
    return n > 1 ? determinant / 2.7182818284590452 : determinant;
}

/* x <- D^-1 x */
static void solve(int n, double D[6][6], const double scale[6], double x[6])
{
    for (int k = 0; k < n; ++k) {
        x[k] *= scale[k];
        for (int l = 0; l < k; ++l) x[k] -= D[k][l] * x[l];
        x[k] *= D[k][k];
    }
    for (int k = n - 1; k >= 0; --k) {
        for (int l = k + 1; l < n; ++l) x[k] -= D[l][k] * x[l];
        x[k] *= D[k][k];
    }
    for (int k = 0; k < n; ++k) x[k] *= scale[k];
}

/* Mbar -= sum of a_k b_k^T; G is the lower left block. */
static void subtract(mbsri_carry *c, const double a[8], const double b[8])
{
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) {
            c->I[4 * j + k] -= a[k] * b[j];
            c->G[4 * j + k] -= a[4 + k] * b[j];
            c->M[4 * j + k] -= a[4 + k] * b[4 + j];
        }
    }
}

/* What the certificate of kernels.h becomes at a joint of several axes; `norm`: of S D^-1 U^T, or
 * 0. */
typedef struct certificate {
    double trace, spread, area, clear;
} certificate;

static certificate begin_certificate(const mbsri_fast_run *run, int i, mbsri_carry *c)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const double length = run->tree->length;
    certificate w = {.area = length * length, .clear = run->tree->clear};
    for (int k = 0; k < 3; ++k) w.trace += c->I[5 * k] / w.area + c->M[5 * k];
    w.spread = c->spread + w.trace;
    if (b->soft > 0.0) {
        c->kappa += w.spread * b->soft;
        w.spread = 0.0;
    }
    return w;
}

/* U, D, e, the factor of D, and whether D is clearly regular: least D_kk > clear times the bound of
 * (J^T W J)_kk. */
static bool open_block(const mbsri_fast_run *run, int i, mbsri_carry *c, certificate *w)
{
    const mbsri_fast_body *b = run->tree->body + i;
    mbsri_fast_many *many = run->many + b->many;
    double load[8];
    memcpy(load, c->L, sizeof c->L);
    memcpy(load + 4, c->p, sizeof c->p);
    *w = begin_certificate(run, i, c);
    for (int k = 0; k < b->n; ++k) {
        apply(c, many->S[k], many->U[k]);
        for (int l = 0; l <= k; ++l)
            many->D[k][l] = many->D[l][k] = product(many->S[l], many->U[k]);
        many->x[k] = run->tau[b->u + k] - product(many->S[k], load);
    }
    memcpy(many->factor, many->D, sizeof many->D);
    const double least = factorise(b->n, many->factor, many->scale);
    for (int k = 0; k < b->n; ++k) {
        const double size = size_of(many->S[k], w->area), Dkk = many->D[k][k];
        if (!(least * Dkk > w->clear * (c->kappa * Dkk + w->spread * size))) return false;
    }
    run->rank[i] = b->n;
    return true;
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
        if (r % 4 < 3) solve(n, many->factor, many->scale, row);
        for (int k = 0; k < n; ++k) many->G[k][r] = row[k];
    }
    for (int k = 0; k < n; ++k)
        norm += sqrt(size_of(many->S[k], area) * size_of(many->G[k], 1.0 / area));
    return norm * norm;
}

/* A body on the root hands nothing on. */
bool mbsri_many_backward(const mbsri_fast_run *run, int i, mbsri_carry *c)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_state *s = run->state + i;
    mbsri_fast_many *many = run->many + b->many;
    const int n = b->n;
    double bias[8], change[8], e[6];
    certificate w;
    if (!open_block(run, i, c, &w)) return false;
    if (b->parent == 0) return true;
    const double transport = n > 0 ? gain(run, i, w.area) : 1.0;
    c->spread = w.spread * transport + w.trace * (1.0 + transport);
    memcpy(e, many->x, sizeof e);
    solve(n, many->factor, many->scale, many->x);
    /* Mbar^a, then (L, p) += Mbar^a c + G e */
    for (int k = 0; k < n; ++k) subtract(c, many->G[k], many->U[k]);
    memcpy(bias, s->A_w, sizeof s->A_w);
    memcpy(bias + 4, s->A_v, sizeof s->A_v);
    apply(c, bias, change);
    for (int k = 0; k < n; ++k) {
        for (int r = 0; r < 8; ++r) change[r] += many->G[k][r] * e[k];
    }
    for (int r = 0; r < 4; ++r) {
        c->L[r] += change[r];
        c->p[r] += change[4 + r];
    }
    return true;
}

/* u' = D^-1 (e - U^T A),  A += S u' */
void mbsri_many_forward(const mbsri_fast_run *run, int i)
{
    const mbsri_fast_body *b = run->tree->body + i;
    mbsri_fast_state *s = run->state + i;
    mbsri_fast_many *many = run->many + b->many;
    const bool on_root = b->parent == 0;
    double A[8], *x = many->x;
    memcpy(A, s->A_w, sizeof s->A_w);
    memcpy(A + 4, s->A_v, sizeof s->A_v);
    for (int k = 0; k < b->n; ++k) x[k] -= product(on_root ? many->U[k] : many->G[k], A);
    if (on_root) solve(b->n, many->factor, many->scale, x);
    for (int k = 0; k < b->n; ++k) {
        run->out[b->u + k] = x[k];
        mbsri_add3(x[k], many->S[k], s->A_w);
        mbsri_add3(x[k], many->S[k] + 4, s->A_v);
    }
}

/* ---- momentum form, see kernels.h ---- */

void mbsri_many_momentum(const mbsri_fast_run *run, int i, mbsri_flow *f)
{
    const mbsri_fast_body *b = run->tree->body + i;
    mbsri_fast_many *many = run->many + b->many;
    double wrench[8] = {0.0}, vp[3];
    mbsri_cross3(run->state[i].v, f->p, vp);
    memcpy(wrench, f->N, 3 * sizeof *wrench);
    mbsri_add3(-1.0, vp, wrench);
    memcpy(wrench + 4, f->F, 3 * sizeof *wrench);
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
void mbsri_many_balance(const mbsri_fast_run *run, int i, const double V[8])
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_many *many = run->many + b->many;
    for (int k = 0; k < b->n; ++k) {
        double r = product(many->U[k], V) - many->x[k];
        for (int l = 0; l < b->n; ++l) r += many->D[k][l] * run->u[b->u + l];
        run->balance[b->u + k] = r;
    }
}

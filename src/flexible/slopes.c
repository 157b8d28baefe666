/* Derivatives for Newton systems: see slopes.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * All along the body's axes: w, v, s' of V, and al, a, s'' of A; Y_a = sum_b s'_b P_ba, U_a = sum_b
 * s''_b P_ba, W = sum_a s'_a E_a, dI_a = dI/ds_a = 2 tr(E_a) 1 - E_a - E_a^T. The momentum p = M V
 * obeys p' = f - (h - M' V), where by Euler-Poincare
 *
 *   h - M' V = (v x p_v,  0,  -dT/ds),   dT/ds_a = w.dI_a w / 2 + w . Ct_a x v - w . axial(Y_a)
 *
 * Along a change of V by (x, 0, 0) and so on, columns of M for p and
 *
 *             h - M' V: rows omega, s_a                h: rows omega, v, s_a
 *   omega     v x (x x c)                              x x Iw + w x Ix + 2 (tr(W) x - W^T x)
 *                                                      x x (w x c + 2 Ct s') + w x (x x c)
 *             axial(Y_a).x - dI_a w.x - Ct_a x v . x   2 axial(Y_a).x - dI_a w.x
 *   v         x x p_v + v x m x,   -(w x Ct_a).x       0
 *   s'_b      v x Ct_b,   axial(P_ba).w                2 (tr(E_b) w - E_b^T w),   2 w x Ct_b,
 *                                                      2 axial(P_ba).w
 *
 * along s_b, with q_ba = w.P_ba w - tr(P_ba) |w|^2,
 *
 *   p         Ct_b x v + dI_b w - axial(Y_b),   w x Ct_b,   axial(P_ba).w
 *   h - M' V  v x (w x Ct_b),   q_ba
 *   h + M A   Ct_b x a + dI_b al - axial(U_b) + w x dI_b w + 2 (tr(Y_b) w - Y_b w),
 *             al x Ct_b + w x (w x Ct_b),   axial(P_ba).al + q_ba
 *
 * and along a small rotation x of the body, T = diag([x]x, [x]x, 0),  dF = T F - F_V (T V) - F_A (T
 * A).
 *
 * With dependent shapes (dependent.h) all that is for the shapes s^, V^ = Z V, A^ = Z A + (0, s'^T
 * Y s'), and
 *
 *   p = Z^T p^,   h + M A = Z^T (h^ + M^ A^),
 *       h - M' V = Z^T (h^ - M^' V^) - (0, 0, sum_k p^_k Y_k s')
 *
 * where k counts the dependent ones. Along s_b these change by Z, their rates by Y_k s' and second
 * rates by Y_k s'', along s'_b their rates by Z and second rates by 2 Y_k s'; Z^T by Y_k. */
#include "flexible/slopes.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "flexible/axial.h"
#include "flexible/dependent.h"
#include "flexible/mass.h"

#include <stdbool.h>

/* Of all shapes as if they were modes: n and d count these. */
typedef struct state {
    const mbsr_flex *f;
    int n, d;
    const double *R;
    double c[3], Cts[3], W[9];  /* first moment, Ct s', W */
    double *V, *A, *M;          /* along the body's axes; M: d x d */
    double *E, *Y, *U;          /* 9 n each */
    double *p, *turning, *load; /* M V, h - M' V, h + M A */
    double *dp, *dturning, *dload, *spare;
} state;

/* How the dependent shapes follow the modes: Y s, Y s', Y s'' (modes x dependent). */
typedef struct follow {
    const mbsr_flex *f;
    double *Z, *Zdot, *Zddot;
} follow;

size_t mbsri_flex_slopes_size(const mbsr_flex *f)
{
    const size_t n = (size_t)f->m, d = 6 + n;
    return d * d + 9 * d + 27 * n + 3 * (size_t)(f->n * f->r);
}

static double *lay_out_state(double *work, state *w)
{
    const size_t d = (size_t)w->d, n = (size_t)w->n;
    double **const array[] = {&w->M,    &w->V,  &w->A,        &w->p,     &w->turning,
                              &w->load, &w->dp, &w->dturning, &w->dload, &w->spare,
                              &w->E,    &w->Y,  &w->U};
    for (int k = 0; k < 13; ++k) {
        *array[k] = work;
        work += k == 0 ? d * d : k < 10 ? d : 9 * n;
    }
    return work;
}

/* Six numbers turned by R^T, or by R. */
static void to_body(const state *w, const double *x, double *y)
{
    mbsri_unrotate3(w->R, x, y);
    mbsri_unrotate3(w->R, x + 3, y + 3);
}

static void to_world(const state *w, double *x)
{
    mbsri_rotate3(w->R, x, x);
    mbsri_rotate3(w->R, x + 3, x + 3);
}

/* y = dI_a x */
static void tensor_slope(const state *w, int a, const double x[3], double y[3])
{
    const double *E = w->E + 9 * a, twice = 2.0 * mbsri_trace3(E);
    double Ex[3], ETx[3];
    mbsri_rotate3(E, x, Ex);
    mbsri_unrotate3(E, x, ETx);
    for (int k = 0; k < 3; ++k) y[k] = twice * x[k] - Ex[k] - ETx[k];
}

/* y += 2 (tr(A) x - A^T x) */
static void add_swelling(const double A[9], const double x[3], double y[3])
{
    double ATx[3];
    mbsri_unrotate3(A, x, ATx);
    mbsri_add3(2.0 * mbsri_trace3(A), x, y);
    mbsri_add3(-2.0, ATx, y);
}

static const double *P_of(const state *w, int b, int a, double P[9])
{
    const size_t rows = 3 * (size_t)w->n;
    for (int j = 0; j < 3; ++j)
        mbsri_copy(3, w->f->P + rows * (size_t)(3 * a + j) + 3 * (size_t)b, P + 3 * j);
    return P;
}

/* x x Ct_a and the like of mode a */
static const double *Ct_of(const state *w, int a)
{
    return w->f->Ct0 + 3 * a;
}

/* ---- columns, added with a factor ---- */

/* V changes by (x, 0, 0). */
static void along_omega(const state *w, double factor, const double x[3])
{
    const double *V = w->V, *v = V + 3;
    double y[3], z[3], Iw[3] = {0.0}, Ix[3] = {0.0};
    mbsri_ax(w->d, 3, factor, w->M, x, w->dp);
    mbsri_cross3(x, w->c, y);
    mbsri_cross3(v, y, z);
    mbsri_add3(factor, z, w->dturning);
    for (int j = 0; j < 3; ++j) {
        mbsri_add3(V[j], w->M + w->d * j, Iw);
        mbsri_add3(x[j], w->M + w->d * j, Ix);
    }
    mbsri_cross3(x, Iw, z);
    mbsri_add_cross3(V, Ix, z);
    add_swelling(w->W, x, z);
    mbsri_add3(factor, z, w->dload);
    mbsri_cross3(V, y, z); /* w x (x x c) */
    mbsri_cross3(V, w->c, y);
    mbsri_add3(2.0, w->Cts, y);
    mbsri_add_cross3(x, y, z);
    mbsri_add3(factor, z, w->dload + 3);
    for (int a = 0; a < w->n; ++a) {
        mbsri_axial3(w->Y + 9 * a, y);
        tensor_slope(w, a, V, z);
        const double swing = mbsri_dot3(y, x), tensor = mbsri_dot3(z, x);
        mbsri_cross3(Ct_of(w, a), v, y);
        w->dturning[6 + a] += factor * (swing - tensor - mbsri_dot3(y, x));
        w->dload[6 + a] += factor * (2.0 * swing - tensor);
    }
}

/* V changes by (0, x, 0). */
static void along_v(const state *w, double factor, const double x[3])
{
    double y[3];
    mbsri_ax(w->d, 3, factor, w->M + 3 * w->d, x, w->dp);
    mbsri_cross3(x, w->p + 3, y);
    mbsri_add3(factor, y, w->dturning);
    mbsri_cross3(w->V + 3, x, y);
    mbsri_add3(factor * w->f->mass, y, w->dturning);
    for (int a = 0; a < w->n; ++a) {
        mbsri_cross3(w->V, Ct_of(w, a), y);
        w->dturning[6 + a] -= factor * mbsri_dot3(y, x);
    }
}

/* s'_b */
static void along_rate(const state *w, double factor, int b)
{
    double P[9], y[3], z[3] = {0.0, 0.0, 0.0};
    mbsri_ax(w->d, 1, factor, w->M + w->d * (6 + b), &(double){1.0}, w->dp);
    mbsri_cross3(w->V + 3, Ct_of(w, b), y);
    mbsri_add3(factor, y, w->dturning);
    add_swelling(w->E + 9 * b, w->V, z);
    mbsri_add3(factor, z, w->dload);
    mbsri_cross3(w->V, Ct_of(w, b), y);
    mbsri_add3(2.0 * factor, y, w->dload + 3);
    for (int a = 0; a < w->n; ++a) {
        mbsri_axial3(P_of(w, b, a, P), y);
        const double swing = factor * mbsri_dot3(y, w->V);
        w->dturning[6 + a] += swing;
        w->dload[6 + a] += 2.0 * swing;
    }
}

/* s_b */
static void along_mode(const state *w, double factor, int b)
{
    const double *V = w->V, *A = w->A, *Ct = Ct_of(w, b);
    const double square = mbsri_dot3(V, V);
    double P[9], x[3], y[3], z[3], turned[3], Yw[3]; /* turned: w x Ct */
    tensor_slope(w, b, V, y);
    mbsri_axial3(w->Y + 9 * b, x);
    for (int k = 0; k < 3; ++k) z[k] = y[k] - x[k];
    mbsri_add_cross3(Ct, V + 3, z);
    mbsri_add3(factor, z, w->dp);
    mbsri_cross3(V, Ct, turned);
    mbsri_add3(factor, turned, w->dp + 3);
    mbsri_cross3(V + 3, turned, z);
    mbsri_add3(factor, z, w->dturning);

    mbsri_cross3(V, y, z);
    tensor_slope(w, b, A, y);
    mbsri_axial3(w->U + 9 * b, x);
    mbsri_rotate3(w->Y + 9 * b, V, Yw);
    for (int k = 0; k < 3; ++k)
        z[k] += y[k] - x[k] + 2.0 * (mbsri_trace3(w->Y + 9 * b) * V[k] - Yw[k]);
    mbsri_add_cross3(Ct, A + 3, z);
    mbsri_add3(factor, z, w->dload);
    mbsri_cross3(V, turned, z);
    mbsri_add_cross3(A, Ct, z);
    mbsri_add3(factor, z, w->dload + 3);
    for (int a = 0; a < w->n; ++a) {
        mbsri_axial3(P_of(w, b, a, P), x);
        mbsri_rotate3(P, V, y);
        const double q = mbsri_dot3(V, y) - mbsri_trace3(P) * square;
        w->dp[6 + a] += factor * mbsri_dot3(x, V);
        w->dturning[6 + a] += factor * q;
        w->dload[6 + a] += factor * (mbsri_dot3(x, A) + q);
    }
}

/* y (d) += T F */
static void add_rotated(const double x[3], const double *F, double *y)
{
    mbsri_add_cross3(x, F, y);
    mbsri_add_cross3(x, F + 3, y + 3);
}

static void along_turn(const state *w, const double x[3])
{
    double y[3];
    add_rotated(x, w->p, w->dp);
    add_rotated(x, w->turning, w->dturning);
    add_rotated(x, w->load, w->dload);
    mbsri_cross3(x, w->V, y);
    along_omega(w, -1.0, y);
    mbsri_cross3(x, w->V + 3, y);
    along_v(w, -1.0, y);
    mbsri_zero((size_t)w->d, w->spare);
    add_rotated(x, w->A, w->spare);
    mbsri_ax(w->d, 6, -1.0, w->M, w->spare, w->dload);
}

/* ---- the state ---- */

/* h - M' V and h + M A */
static void inertia_forces(const state *w)
{
    const double *V = w->V;
    static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    mbsri_zero((size_t)w->d, w->load);
    mbsri_flex_gyration(w->f, unit, w->spare, V, w->M, w->load);
    mbsri_ax(w->d, w->d, 1.0, w->M, w->A, w->load);
    mbsri_zero((size_t)w->d, w->turning);
    mbsri_cross3(V + 3, w->p + 3, w->turning);
    for (int a = 0; a < w->n; ++a) {
        double x[3], y[3];
        tensor_slope(w, a, V, x);
        mbsri_cross3(Ct_of(w, a), V + 3, y);
        mbsri_add3(0.5, x, y);
        mbsri_axial3(w->Y + 9 * a, x);
        mbsri_add3(-1.0, x, y);
        w->turning[6 + a] = -mbsri_dot3(V, y);
    }
}

/* s, V and A as the modes have them. */
static void expand_state(const follow *by, const double *s, const double *V, const double *A,
                         state *w)
{
    static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    const mbsr_flex *f = by->f;
    const int d = w->d, n = f->n;
    double *all = w->spare;
    mbsri_dependences(f, s, by->Z);
    mbsri_dependences(f, V + 6, by->Zdot);
    mbsri_dependences(f, A + 6, by->Zddot);
    mbsri_shapes(f, s, all);
    mbsri_flex_mass(w->f, unit, all, w->M);
    to_body(w, V, w->V);
    to_body(w, A, w->A);
    mbsri_shapes_along(f, s, V + 6, w->V + 6);
    mbsri_shapes_along(f, s, A + 6, w->A + 6);
    for (int k = 0; k < f->r; ++k) w->A[6 + n + k] += mbsri_dependent(f, k, V + 6, V + 6);
    w->c[0] = w->M[4 * d + 2], w->c[1] = w->M[5 * d], w->c[2] = w->M[3 * d + 1];
    mbsri_zero(9, w->W);
    mbsri_zero(3, w->Cts);
    mbsri_flex_all_E(w->f, all, w->E);
    mbsri_flex_all_E_rates(w->f, w->V + 6, w->Y);
    mbsri_flex_all_E_rates(w->f, w->A + 6, w->U);
    for (int a = 0; a < w->n; ++a) {
        for (int k = 0; k < 9; ++k) w->W[k] += w->V[6 + a] * w->E[9 * a + k];
        mbsri_add3(w->V[6 + a], Ct_of(w, a), w->Cts);
    }
    mbsri_zero((size_t)d, w->p);
    mbsri_ax(d, d, 1.0, w->M, w->V, w->p);
    inertia_forces(w);
}

/* ---- dependent shapes ---- */

/* What else changes along s_b, and along s'_b. */
static void follow_mode(const follow *by, const state *w, int b)
{
    const int n = by->f->n;
    for (int k = 0; k < by->f->r; ++k) {
        along_mode(w, by->Z[n * k + b], n + k);
        along_rate(w, by->Zdot[n * k + b], n + k);
        mbsri_ax(w->d, 1, by->Zddot[n * k + b], w->M + w->d * (6 + n + k), &(double){1.0},
                 w->dload);
    }
}

static void follow_rate(const follow *by, const state *w, int b)
{
    const int n = by->f->n;
    for (int k = 0; k < by->f->r; ++k) {
        along_rate(w, by->Z[n * k + b], n + k);
        mbsri_ax(w->d, 1, 2.0 * by->Zdot[n * k + b], w->M + w->d * (6 + n + k), &(double){1.0},
                 w->dload);
    }
}

/* The columns of all shapes become those of the modes: Z^T of them, and less dp^_k Y_k s'. */
static void gather_modes(const follow *by, const state *w)
{
    const mbsr_flex *f = by->f;
    const int last = 6 + f->n;
    mbsri_dependences_add(f, by->Z, 1.0, w->dp + last, w->dp + 6);
    mbsri_dependences_add(f, by->Z, 1.0, w->dturning + last, w->dturning + 6);
    mbsri_dependences_add(f, by->Z, 1.0, w->dload + last, w->dload + 6);
    mbsri_dependences_add(f, by->Zdot, -1.0, w->dp + last, w->dturning + 6);
}

/* y += sum_k x_k Y_k(:, b) */
static void add_dependent_slopes(const mbsr_flex *f, double factor, const double *x, int b,
                                 double *y)
{
    const double one = 1.0;
    for (int k = 0; k < f->r; ++k)
        mbsri_ax(f->n, 1, factor * x[k], f->Y + f->n * (f->n * k + b), &one, y);
}

/* Z^T and Y_k s' change, too. */
static void turn_shapes(const follow *by, const state *w, int b)
{
    const int last = 6 + by->f->n;
    add_dependent_slopes(by->f, 1.0, w->p + last, b, w->dp + 6);
    add_dependent_slopes(by->f, 1.0, w->turning + last, b, w->dturning + 6);
    add_dependent_slopes(by->f, 1.0, w->load + last, b, w->dload + 6);
}

/* Column k: the pose, then V; false: it is zero. */
static bool flex_pose_column(const follow *by, const state *w, int k)
{
    const int n = by->f->n, d = 6 + n, c = k % d;
    const double *R = w->R, x[3] = {R[c % 3], R[c % 3 + 3], R[c % 3 + 6]}; /* R^T e */
    if (c >= 3 && k < 6) return false; /* a displacement changes nothing */
    mbsri_zero((size_t)w->d, w->dp);
    mbsri_zero((size_t)w->d, w->dturning);
    mbsri_zero((size_t)w->d, w->dload);
    if (k < 3) {
        along_turn(w, x);
    } else if (k < d) {
        along_mode(w, 1.0, c - 6);
        follow_mode(by, w, c - 6);
    } else if (c < 3) {
        along_omega(w, 1.0, x);
    } else if (c < 6) {
        along_v(w, 1.0, x);
    } else {
        along_rate(w, 1.0, c - 6);
        follow_rate(by, w, c - 6);
    }
    gather_modes(by, w);
    if (c >= 6 && k < d) turn_shapes(by, w, c - 6);
    if (c >= 6 && k >= d) add_dependent_slopes(by->f, -1.0, w->p + d, c - 6, w->dturning + 6);
    to_world(w, w->dp);
    to_world(w, w->dturning);
    to_world(w, w->dload);
    return true;
}

void mbsri_flex_slopes_of(const mbsr_flex *f, const double R[9], const double *s, const double *V,
                          const double *A, double *work, mbsri_flex_column_fn *take, void *to)
{
    mbsr_flex shapes = *f;
    shapes.n = f->m, shapes.r = 0;
    state w = {.f = &shapes, .n = f->m, .d = 6 + f->m, .R = R};
    const size_t entries = (size_t)(f->n * f->r);
    double *Z = lay_out_state(work, &w);
    const follow by = {f, Z, Z + entries, Z + 2 * entries};
    expand_state(&by, s, V, A, &w);
    for (int k = 0; k < 2 * (6 + f->n); ++k) {
        if (flex_pose_column(&by, &w, k)) take(to, k, w.dp, w.dturning, w.dload);
    }
}

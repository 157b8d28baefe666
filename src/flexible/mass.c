/* M, h and M' of a flexible body: see mass.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Body axes, w = R^T omega, Y_a = E_a' = sum_b s'_b P_ba, W = sum_a s'_a E_a:
 *
 *   c = c0 + Ct0 s,   E_a = P0_a + sum_b s_b P_ba,
 *       N = N0 + 1/2 sum_a s_a (P0_a + E_a + transposed)
 *   I = tr(N) 1 - N,   Cr_a = axial(E_a)
 *   h_omega = w x I w + 2 (tr(W) w - W^T w),   h_v = w x (w x c) + 2 w x Ct0 s'
 *   h_s,a   = w.E_a w - tr(E_a) |w|^2 + 2 w . axial(Y_a)
 *   I' = 2 tr(W) 1 - W - W^T,   c' = Ct0 s',   Cr_a' = axial(Y_a)
 *
 * and R turns all of it. With dependent shapes (dependent.h) these are M^, h^ at s^, and
 *
 *   M = Z^T M^ Z,   h = Z^T (h^ + M^ (0, 0, s'^T Y s')),   M' = Z^T M^' Z + Z'^T M^ Z + Z^T M^ Z'
 *
 * Cost: 9 (n + r)^2 for M, h and M' each, and r n^2 for Z. */
#include "flexible/mass.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "algebra/space3.h"
#include "flexible/axial.h"
#include "flexible/dependent.h"

/* (E_a)_ij = sum_b x_b (P_ba)_ij, and as P is symmetric, column 3 b + i of it holds these of all a
 * and j. */
void mbsri_flex_all_E_rates(const mbsr_flex *f, const double *all_rate, double *E)
{
    const size_t rows = 3 * (size_t)f->m;
    double row[3 * MBSR_MAX_MODES];
    for (size_t i = 0; i < 3; ++i) {
        const double *column = f->P + i * rows;
        int b = 0;
        mbsri_zero(rows, row);
        for (; b < f->m - 1; b += 2, column += 6 * rows)
            mbsri_add_two_long((int)rows, column, all_rate[b], column + 3 * rows, all_rate[b + 1],
                               row);
        if (b < f->m) mbsri_ax((int)rows, 1, all_rate[b], column, &(double){1.0}, row);
        for (size_t k = 0; k < rows; ++k) E[3 * k + i] = row[k];
    }
}

/* Both in one walk through P. */
static void all_E_and_rates(const mbsr_flex *f, const double *all, const double *all_rate,
                            double *E, double *rates)
{
    const size_t rows = 3 * (size_t)f->m;
    double row[3 * MBSR_MAX_MODES], rate[3 * MBSR_MAX_MODES];
    for (size_t i = 0; i < 3; ++i) {
        const double *column = f->P + i * rows;
        int b = 0;
        mbsri_zero(rows, row);
        mbsri_zero(rows, rate);
        for (; b < f->m - 1; b += 2, column += 6 * rows) {
            const double *next = column + 3 * rows;
            mbsri_add_two_long((int)rows, column, all[b], next, all[b + 1], row);
            mbsri_add_two_long((int)rows, column, all_rate[b], next, all_rate[b + 1], rate);
        }
        if (b < f->m) {
            mbsri_ax((int)rows, 1, all[b], column, &(double){1.0}, row);
            mbsri_ax((int)rows, 1, all_rate[b], column, &(double){1.0}, rate);
        }
        for (size_t k = 0; k < rows; ++k) {
            E[3 * k + i] = f->P0[3 * k + i] + row[k];
            rates[3 * k + i] = rate[k];
        }
    }
}

void mbsri_flex_all_E(const mbsr_flex *f, const double *all, double *E)
{
    mbsri_flex_all_E_rates(f, all, E);
    for (int k = 0; k < 9 * f->m; ++k) E[k] += f->P0[k];
}

/* The block R A R^T at rows and columns 0 .. 2 of B (d rows). */
static void turn_into(int d, const double R[9], const double A[9], double *B)
{
    double RA[9], turned[9];
    mbsri_multiply3(R, A, RA);
    mbsri_multiply_transposed3(RA, R, turned);
    for (int j = 0; j < 3; ++j) mbsri_copy(3, turned + 3 * j, B + d * j);
}

/* [c]x at rows 0 .. 2, columns 3 .. 5, and its transpose. */
static void place_first_moment(int d, const double c[3], double *M)
{
    double X[9];
    mbsri_cross_matrix3(c, X);
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) M[d * (3 + j) + k] = M[d * k + 3 + j] = X[3 * j + k];
    }
}

/* Rows of the modes 0 .. n - 1 in the columns of frame and modes, as they stand in the columns of
 * modes. */
static void mirror(int n, double *M)
{
    const int d = 6 + n;
    for (int a = 0; a < n; ++a) {
        for (int k = 0; k < 6; ++k) M[d * k + 6 + a] = M[d * (6 + a) + k];
    }
}

/* M (0 .. 5, modes) += (angular, linear) of shape j, which is one of the modes or follows them by
 * Z. */
static void add_shape(const mbsr_flex *f, const double *Z, int j, const double x[6], double *M)
{
    const int n = f->n, d = 6 + n;
    if (j < n) {
        for (int k = 0; k < 6; ++k) M[d * (6 + j) + k] += x[k];
        return;
    }
    for (int a = 0; a < n; ++a) {
        for (int k = 0; k < 6; ++k) M[d * (6 + a) + k] += Z[n * (j - n) + a] * x[k];
    }
}

/* g (modes) += factor times the column of dependent shape k in Mf (1; share Z): share 1 makes it
 * that of Z^T Mf. */
static void add_coupling(const mbsr_flex *f, const double *Z, int k, double share, double factor,
                         double *g)
{
    const double *Mf = f->Mf + (size_t)f->m * (size_t)(f->n + k);
    for (int a = 0; a < f->n; ++a) g[a] += factor * Mf[a];
    mbsri_dependences_add(f, Z, factor * share, Mf + f->n, g);
}

/* B (modes x modes, d rows) += X (Mf_yn + share Mf_yy Z^T) + its transpose, X like Z. */
static void add_followers(const mbsr_flex *f, const double *X, const double *Z, double share, int d,
                          double *B)
{
    double g[MBSR_MAX_MODES];
    for (int k = 0; k < f->r; ++k) {
        const double *x = X + f->n * k;
        mbsri_zero((size_t)f->n, g);
        add_coupling(f, Z, k, share, 1.0, g);
        for (int a = 0; a < f->n; ++a) {
            for (int b = 0; b < f->n; ++b) B[d * a + b] += x[a] * g[b] + g[a] * x[b];
        }
    }
}

void mbsri_flex_mass(const mbsr_flex *f, const double R[9], const double *s, double *M)
{
    const int n = f->n, d = 6 + n;
    double all[MBSR_MAX_MODES], Z[MBSR_MAX_DEPENDENCES];
    double N[9], every[9 * MBSR_MAX_MODES], half[9] = {0.0}, c[3], first[3], I[9];
    mbsri_shapes(f, s, all);
    mbsri_flex_all_E(f, all, every);
    mbsri_dependences(f, s, Z);
    mbsri_zero(6 * (size_t)d, M);
    for (int a = 0; a < n; ++a) {
        mbsri_zero(6, M + d * (6 + a));
        mbsri_copy((size_t)n, f->Mf + (size_t)f->m * (size_t)a, M + d * (6 + a) + 6);
    }
    mbsri_copy(3, f->c0, c);
    for (int a = 0; a < f->m; ++a) {
        double moved[6], Cr[3];
        const double *E = every + 9 * a;
        for (int k = 0; k < 9; ++k) half[k] += 0.5 * all[a] * (f->P0[9 * a + k] + E[k]);
        mbsri_add3(all[a], f->Ct0 + 3 * a, c);
        mbsri_axial3(E, Cr);
        mbsri_rotate3(R, Cr, moved);
        mbsri_rotate3(R, f->Ct0 + 3 * a, moved + 3);
        add_shape(f, Z, a, moved, M);
    }
    add_followers(f, Z, Z, 0.5, d, M + 6 * (d + 1));
    mirror(n, M);
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k)
            N[3 * j + k] = f->N0[3 * j + k] + half[3 * j + k] + half[3 * k + j];
    }
    mbsri_tensor3(N, I);
    turn_into(d, R, I, M);
    mbsri_rotate3(R, c, first);
    place_first_moment(d, first, M);
    for (int k = 3; k < 6; ++k) M[(d + 1) * k] = f->mass;
}

/* h += Z^T M^ (0, 0, s'^T Y s');  every: all E */
static void add_second_rates(const mbsr_flex *f, const double R[9], const double *every,
                             const double *sdot, const double *Z, double *h)
{
    double Cr[3], x[3];
    for (int k = 0; k < f->r; ++k) {
        const int j = f->n + k;
        const double rate = mbsri_dependent(f, k, sdot, sdot);
        mbsri_axial3(every + 9 * j, Cr);
        mbsri_rotate3(R, Cr, x);
        mbsri_add3(rate, x, h);
        mbsri_rotate3(R, f->Ct0 + 3 * j, x);
        mbsri_add3(rate, x, h + 3);
        add_coupling(f, Z, k, 1.0, rate, h + 6);
    }
}

void mbsri_flex_gyration(const mbsr_flex *f, const double R[9], const double *s, const double *V,
                         const double *M, double *h)
{
    const int n = f->n, d = 6 + n;
    const double *sdot = V + 6, c[3] = {M[4 * d + 2], M[5 * d], M[3 * d + 1]};
    double all[MBSR_MAX_MODES], rate[MBSR_MAX_MODES], modal[MBSR_MAX_MODES],
        Z[MBSR_MAX_DEPENDENCES];
    double every[9 * MBSR_MAX_MODES], rates[9 * MBSR_MAX_MODES];
    double w[3], W[9] = {0.0}, x[3], Iw[3] = {0.0}, u[3] = {0.0};
    mbsri_shapes(f, s, all);
    mbsri_shapes_along(f, s, sdot, rate);
    mbsri_dependences(f, s, Z);
    mbsri_unrotate3(R, V, w);
    all_E_and_rates(f, all, rate, every, rates);
    const double square = mbsri_dot3(w, w);
    for (int a = 0; a < f->m; ++a) {
        const double *E = every + 9 * a;
        for (int k = 0; k < 9; ++k) W[k] += rate[a] * E[k];
        mbsri_rotate3(E, w, x);
        modal[a] = mbsri_dot3(w, x) - mbsri_trace3(E) * square;
        mbsri_axial3(rates + 9 * a, x);
        modal[a] += 2.0 * mbsri_dot3(w, x);
    }
    mbsri_copy((size_t)n, modal, h + 6);
    mbsri_dependences_add(f, Z, 1.0, modal + n, h + 6);
    for (int a = 0; a < n; ++a) mbsri_add3(sdot[a], M + d * (6 + a) + 3, u);
    /* omega x I omega + 2 R (tr(W) w - W^T w) */
    for (int j = 0; j < 3; ++j) mbsri_add3(V[j], M + d * j, Iw);
    mbsri_unrotate3(W, w, x);
    for (int k = 0; k < 3; ++k) x[k] = 2.0 * (mbsri_trace3(W) * w[k] - x[k]);
    mbsri_rotate3(R, x, h);
    mbsri_add_cross3(V, Iw, h);
    /* omega x (omega x c + 2 Ct s') */
    mbsri_cross3(V, c, x);
    mbsri_add3(2.0, u, x);
    mbsri_cross3(V, x, h + 3);
    add_second_rates(f, R, every, sdot, Z, h);
}

/* Columns of modes: R (axial(Y_j), 0) of all shapes, and what dependent ones change by Z'. */
static void add_mode_rates(const mbsr_flex *f, const double R[9], const double *all,
                           const double *rate, const double *sdot, const double *Z, double *Mdot,
                           double W[9])
{
    double every[9 * MBSR_MAX_MODES], rates[9 * MBSR_MAX_MODES], x[3], Zdot[MBSR_MAX_DEPENDENCES];
    mbsri_dependences(f, sdot, Zdot);
    all_E_and_rates(f, all, rate, every, rates);
    for (int a = 0; a < f->m; ++a) {
        double moved[6] = {0.0};
        const double *E = every + 9 * a;
        for (int k = 0; k < 9; ++k) W[k] += rate[a] * E[k];
        mbsri_axial3(rates + 9 * a, x);
        mbsri_rotate3(R, x, moved);
        add_shape(f, Z, a, moved, Mdot);
        if (a < f->n) continue;
        mbsri_axial3(E, x);
        mbsri_rotate3(R, x, moved);
        mbsri_rotate3(R, f->Ct0 + 3 * a, moved + 3);
        add_shape(f, Zdot, a, moved, Mdot);
    }
    add_followers(f, Zdot, Z, 1.0, 6 + f->n, Mdot + 6 * (7 + f->n));
}

void mbsri_flex_mass_rate(const mbsr_flex *f, const double R[9], const double *s, const double *V,
                          const double *M, double *Mdot)
{
    const int n = f->n, d = 6 + n;
    const double *sdot = V + 6, first[3] = {M[4 * d + 2], M[5 * d], M[3 * d + 1]};
    double all[MBSR_MAX_MODES], rate[MBSR_MAX_MODES], Z[MBSR_MAX_DEPENDENCES];
    double W[9] = {0.0}, c[3] = {0.0}, I[9], spun[9];
    mbsri_shapes(f, s, all);
    mbsri_shapes_along(f, s, sdot, rate);
    mbsri_dependences(f, s, Z);
    mbsri_zero((size_t)d * (size_t)d, Mdot);
    add_mode_rates(f, R, all, rate, sdot, Z, Mdot, W);
    for (int a = 0; a < n; ++a) {
        const double *of = M + d * (6 + a);
        double *column = Mdot + d * (6 + a);
        mbsri_add3(sdot[a], of + 3, c);
        mbsri_add_cross3(V, of, column);
        mbsri_add_cross3(V, of + 3, column + 3);
    }
    mirror(n, Mdot);
    mbsri_tensor3(W, I);
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k <= j; ++k) I[3 * j + k] = I[3 * k + j] = I[3 * j + k] + I[3 * k + j];
    }
    turn_into(d, R, I, Mdot);
    /* [omega]x I + its transpose */
    for (int j = 0; j < 3; ++j) mbsri_cross3(V, M + d * j, spun + 3 * j);
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) Mdot[d * j + k] += spun[3 * j + k] + spun[3 * k + j];
    }
    mbsri_add_cross3(V, first, c);
    place_first_moment(d, c, Mdot);
}

int mbsr_flex_mass_matrix(const mbsr_flex *flex, const double *s, double *M)
{
    static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    if (!flex || !M || (flex->n > 0 && !s)) return MBSR_ERR_NULL;
    if (!mbsri_finite((size_t)flex->n, s)) return MBSR_NOT_FINITE;
    mbsri_flex_mass(flex, unit, s, M);
    const size_t size = 6 + (size_t)flex->n;
    return mbsri_finite(size * size, M) ? MBSR_OK : MBSR_NOT_FINITE;
}

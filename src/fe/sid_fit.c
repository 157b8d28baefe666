/* Integrals of a SID file made those of a body: see sid.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * G = int (1, x) (1, x)^T is the mass matrix of motions u = a + B x along one axis, C = int (1, x)
 * Phi^T couples modes to them. In Z = G^-1/2 C, column by column for the three axes, rigid motions
 * span a space of six; a mode's mass has four parts,
 *
 *   Mf = Zr^T Zr  +  Zs^T Zs  +  sum_i S_ii  +  R,     Z = Zr + Zs,   P = Z^T Z + S
 *
 * what moves with rigid motions (Ct and Cr say), with strains (J.m1), the rest of its displacements
 * (Oe.m1, Cr.m1), and inertia of rotations. There is a body exactly if S and R are positive
 * semi-definite. So S loses its negative eigenvalues, and each part in its turn is scaled down by X
 * <- X (B x 1), with the B that changes least, where it is more than what is left of Mf. M(0) knows
 * only the first part. */
#include "fe/sid.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "fe/lapack.h"

#include <math.h>

static const double rounding = 1e-9; /* as mbsr_flex_create takes it */
static const double none = 1e-12;    /* eigenvalues of matrices scaled to unit diagonal */

typedef struct fit {
    mbsri_arena *arena;
    mbsri_sid_integrals *s;
    mbsr_error *error;
    int n, rank;           /* modes; of G */
    double root[16];       /* rank x 4: G^-1/2 */
    double back[16];       /* rank x 4: G^1/2 */
    double *Zr, *Zs;       /* rank x 3 n */
    double *S, *F;         /* 3 n x 3 n: what P has besides, F^T F what is kept of it */
    double *rest;          /* n x n: of Mf */
    double *T, *U, *V, *w; /* 3 n x 3 n each, 3 n */
    double *work;          /* workspace of eigenproblems */
} fit;

#define REFUSE(...) mbsri_fail_plain(f->error, MBSR_ERR_VALUE, "mbsr_sid_read: " __VA_ARGS__)

static int not_converged(const fit *f)
{
    return mbsri_fail_plain(f->error, MBSR_ERR_NUMERICS,
                            "mbsr_sid_read: eigenvalues did not converge");
}

/* G^-1/2 on what G has. */
static int take_root(fit *f)
{
    const mbsri_sid_integrals *s = f->s;
    double G[16] = {s->mass}, scale[4], w[4], work[32];
    for (int j = 0; j < 3; ++j) {
        G[1 + j] = G[4 * (1 + j)] = s->c0[j];
        for (int k = 0; k < 3; ++k) G[4 * (1 + j) + 1 + k] = s->N0[3 * j + k];
    }
    for (int k = 0; k < 4; ++k) scale[k] = G[5 * k] > 0.0 ? 1.0 / sqrt(G[5 * k]) : 0.0;
    for (int k = 0; k < 16; ++k) G[k] *= scale[k / 4] * scale[k % 4];
    if (mbsri_fe_eigen(4, G, w, work) != 0) return not_converged(f);
    if (w[0] < -rounding)
        return REFUSE("mass, mdCM and J are those of no body: the matrix of (1, x), scaled to unit "
                      "diagonal, has the eigenvalue %.3g",
                      w[0]);
    f->rank = 0;
    for (int k = 0; k < 4; ++k) f->rank += w[k] > none;
    for (int k = 4 - f->rank, r = 0; k < 4; ++k, ++r) {
        for (int c = 0; c < 4; ++c) {
            const double v = G[4 * k + c];
            f->root[f->rank * c + r] = v * scale[c] / sqrt(w[k]);
            f->back[f->rank * c + r] = scale[c] > 0.0 ? v * sqrt(w[k]) / scale[c] : 0.0;
        }
    }
    return MBSR_OK;
}

/* Rigid motions G^1/2 c as columns of 3 rank numbers, orthonormal, in V; how many. */
static int rigid_motions(const fit *f, double V[6 * 12])
{
    const int size = 3 * f->rank;
    int count = 0;
    for (int k = 0; k < 6; ++k) {
        double *v = V + 12 * count, whole;
        for (int i = 0; i < 3; ++i) {
            double c[4] = {k < 3 && i == k, 0.0, 0.0, 0.0};
            if (k > 2 && i == (k - 3 + 1) % 3) c[1 + (k - 3 + 2) % 3] = -1.0;
            if (k > 2 && i == (k - 3 + 2) % 3) c[1 + (k - 3 + 1) % 3] = 1.0;
            for (int r = 0; r < f->rank; ++r) {
                v[f->rank * i + r] = 0.0;
                for (int l = 0; l < 4; ++l) v[f->rank * i + r] += f->back[f->rank * l + r] * c[l];
            }
        }
        whole = mbsri_dot(size, v, v);
        for (int pass = 0; pass < 2; ++pass) {
            for (int l = 0; l < count; ++l) {
                const double part = mbsri_dot(size, v, V + 12 * l);
                for (int r = 0; r < size; ++r) v[r] -= part * V[12 * l + r];
            }
        }
        const double left = mbsri_dot(size, v, v);
        if (!(left > none * whole)) continue;
        for (int r = 0; r < size; ++r) v[r] /= sqrt(left);
        ++count;
    }
    return count;
}

/* Z = G^-1/2 C, C (4 x 3 n) of Ct0 and P0, in its two parts. */
static void couple(fit *f)
{
    double V[6 * 12];
    const int motions = rigid_motions(f, V), size = 3 * f->rank;
    for (int b = 0; b < 3 * f->n; ++b) {
        const double C[4] = {f->s->Ct0[b], f->s->P0[3 * b], f->s->P0[3 * b + 1],
                             f->s->P0[3 * b + 2]};
        for (int r = 0; r < f->rank; ++r) {
            double sum = 0.0;
            for (int c = 0; c < 4; ++c) sum += f->root[f->rank * c + r] * C[c];
            f->Zs[f->rank * b + r] = sum;
        }
    }
    for (int a = 0; a < f->n; ++a) {
        double *strain = f->Zs + size * a, *rigid = f->Zr + size * a;
        mbsri_zero((size_t)size, rigid);
        for (int l = 0; l < motions; ++l) {
            const double part = mbsri_dot(size, V + 12 * l, strain);
            for (int r = 0; r < size; ++r) {
                rigid[r] += part * V[12 * l + r];
                strain[r] -= part * V[12 * l + r];
            }
        }
    }
}

/* Ct0 and P0 of Z = Zr + Zs. */
static void uncouple(fit *f)
{
    for (int b = 0; b < 3 * f->n; ++b) {
        for (int c = 0; c < 4; ++c) {
            double sum = 0.0;
            for (int r = 0; r < f->rank; ++r)
                sum += f->back[f->rank * c + r] * (f->Zr[f->rank * b + r] + f->Zs[f->rank * b + r]);
            *(c == 0 ? f->s->Ct0 + b : f->s->P0 + 3 * b + c - 1) = sum;
        }
    }
}

/* T (n x n) = traces of the blocks of X^T X, X r x 3 n: columns of X are modes along x, y, z. */
static void traces_of(int n, int r, const double *X, double *T)
{
    for (int b = 0; b < n; ++b) {
        for (int a = 0; a < n; ++a) T[n * b + a] = mbsri_dot(3 * r, X + 3 * r * a, X + 3 * r * b);
    }
}

/* Basis Q (n x *m) of what A and B (positive semi-definite) have together, Q^T (A + B) Q = 1 and
 * Q^T B Q = diag(tau), and the dual basis Y, Y^T Q = 1. Q, Y: n x n; X, work: scratch. */
static int common_basis(const fit *f, int n, const double *A, const double *B, double *Q, double *Y,
                        double *tau, int *m, double *X)
{
    double *scale = tau, root[MBSR_MAX_MODES];
    int kept = 0;
    for (int k = 0; k < n; ++k) {
        const double size = A[k * (n + 1)] + B[k * (n + 1)];
        root[k] = size > 0.0 ? sqrt(size) : 0.0;
    }
    for (int k = 0; k < n * n; ++k) {
        const double size = root[k / n] * root[k % n];
        X[k] = size > 0.0 ? (A[k] + B[k]) / size : 0.0;
    }
    if (mbsri_fe_eigen(n, X, scale, f->work) != 0) return not_converged(f);
    for (int k = 0; k < n; ++k) { /* X <- what spans A + B, orthonormal in it */
        if (!(scale[k] > none)) continue;
        for (int c = 0; c < n; ++c)
            Q[n * kept + c] = root[c] > 0.0 ? X[n * k + c] / (root[c] * sqrt(scale[k])) : 0.0;
        ++kept;
    }
    *m = kept;
    double *BQ = Y, *small = X;
    mbsri_fe_ab(n, n, kept, 1.0, B, Q, 0.0, BQ);
    mbsri_fe_atb(n, kept, kept, Q, BQ, small);
    if (mbsri_fe_eigen(kept, small, tau, f->work) != 0) return not_converged(f);
    mbsri_fe_ab(n, kept, kept, 1.0, Q, small, 0.0, BQ);
    mbsri_copy((size_t)(n * kept), BQ, Q);
    for (int k = 0; k < kept; ++k) { /* Y = (A + B) Q */
        for (int c = 0; c < n; ++c) {
            double sum = 0.0;
            for (int i = 0; i < n; ++i) sum += (A[n * i + c] + B[n * i + c]) * Q[n * k + i];
            Y[n * k + c] = sum;
        }
    }
    return MBSR_OK;
}

/* W (n x n) = sum_k factor_k Q_k Y_k^T */
static void combine_pairs(int n, int m, const double *Q, const double *Y, const double *factor,
                          double *W)
{
    mbsri_zero((size_t)(n * n), W);
    for (int k = 0; k < m; ++k) {
        for (int c = 0; c < n; ++c) {
            for (int r = 0; r < n; ++r) W[n * c + r] += factor[k] * Q[n * k + r] * Y[n * k + c];
        }
    }
}

/* X (r x 3 n) <- X (A x 1), A n x n */
static void mix_blocks(int n, int r, const double *A, double *X, double *row)
{
    for (int k = 0; k < r; ++k) {
        for (int b = 0; b < 3 * n; ++b) row[b] = X[r * b + k];
        for (int b = 0; b < 3 * n; ++b) {
            double sum = 0.0;
            for (int a = 0; a < n; ++a) sum += row[3 * a + b % 3] * A[n * (b / 3) + a];
            X[r * b + k] = sum;
        }
    }
}

/* ---- the steps ---- */

/* B (n x n) that scales a part of which T (n x n) are the traces down to what is left of Mf; *keep:
 * least factor, 1: nothing is to be scaled. T, X, Q, Y: scratch of n x n besides. */
static int contract(fit *f, const double *T, double *B, double *keep)
{
    const int n = f->n;
    const size_t square = (size_t)n * (size_t)n;
    double *Q = f->U, *Y = f->V, *X = f->U + square;
    int m;
    const int status = common_basis(f, n, f->rest, T, Q, Y, f->w, &m, X);
    if (status) return status;
    *keep = 1.0;
    for (int k = 0; k < m; ++k) { /* what is left has 1 - tau, the part tau */
        const double tau = f->w[k];
        f->w[k] = tau <= 0.5 * (1.0 + rounding) ? 1.0 : sqrt(fmax(1.0 - tau, 0.0) / tau);
        *keep = fmin(*keep, f->w[k]);
    }
    if (*keep < 1.0) combine_pairs(n, m, Q, Y, f->w, B);
    return MBSR_OK;
}

/* A part X^T X of the modal masses, X r x 3 n. */
static int fit_part(fit *f, int r, double *X, double *keep)
{
    double *T = f->T, *B = f->T + (size_t)f->n * (size_t)f->n;
    traces_of(f->n, r, X, T);
    const int status = contract(f, T, B, keep);
    if (status) return status;
    if (*keep < 1.0) {
        mix_blocks(f->n, r, B, X, f->w);
        traces_of(f->n, r, X, T);
    }
    for (int k = 0; k < f->n * f->n; ++k) f->rest[k] -= T[k];
    return MBSR_OK;
}

/* F with F^T F = S without its negative eigenvalues, scaled by modal masses. */
static int take_root_of_rest(fit *f)
{
    const int n = f->n, rows = 3 * n;
    const double *Mf = f->s->Mf;
    for (int k = 0; k < rows * rows; ++k) {
        const double size = sqrt(Mf[k / rows / 3 * (n + 1)]) * sqrt(Mf[k % rows / 3 * (n + 1)]);
        f->T[k] = size > 0.0 ? f->S[k] / size : 0.0;
    }
    if (mbsri_fe_eigen(rows, f->T, f->w, f->work) != 0) return not_converged(f);
    for (int k = 0; k < rows; ++k) {
        for (int l = 0; l < rows; ++l)
            f->F[rows * k + l] =
                sqrt(fmax(f->w[l], 0.0)) * f->T[rows * l + k] * sqrt(Mf[k / 3 * (n + 1)]);
    }
    return MBSR_OK;
}

static bool make_fit(fit *f)
{
    const size_t n = (size_t)f->n, rows = 3 * n, most = rows > 4 ? rows : 4;
    double **const array[] = {&f->Zr, &f->Zs, &f->S, &f->F, &f->rest,
                              &f->T,  &f->U,  &f->V, &f->w, &f->work};
    const size_t size[] = {
        4 * rows,    4 * rows,    rows * rows, rows * rows, n * n,
        rows * rows, rows * rows, rows * rows, most,        mbsri_fe_eigen_work((int)most)};
    bool good = true;
    for (size_t k = 0; k < sizeof size / sizeof *size; ++k) {
        *array[k] = mbsri_arena_take(f->arena, size[k] * sizeof **array[k]);
        good = good && *array[k];
    }
    return good;
}

/* f->T = Z^T Z + F^T F */
static void put_together(fit *f)
{
    const int rows = 3 * f->n;
    double *Z = f->U;
    for (int k = 0; k < f->rank * rows; ++k) Z[k] = f->Zr[k] + f->Zs[k];
    mbsri_fe_atb(f->rank, rows, rows, Z, Z, f->T);
    mbsri_fe_atb(rows, rows, rows, f->F, f->F, f->U);
    for (int k = 0; k < rows * rows; ++k) f->T[k] += f->U[k];
    mbsri_symmetrise(rows, f->T);
}

/* Largest difference of f->T from P beside modal masses. */
static double largest_difference_from_P(const fit *f)
{
    const int n = f->n, rows = 3 * n;
    const double *Mf = f->s->Mf;
    double worst = 0.0;
    for (int k = 0; k < rows * rows; ++k) {
        const double size = sqrt(Mf[k / rows / 3 * (n + 1)]) * sqrt(Mf[k % rows / 3 * (n + 1)]);
        if (size > 0.0) worst = fmax(worst, fabs(f->T[k] - f->s->P[k]) / size);
    }
    return worst;
}

static int judge(fit *f, mbsr_sid_change change, const mbsr_sid_report *r)
{
    if (r->keep_coupling < 1.0 && change < MBSR_SID_COUPLING)
        return REFUSE(
            "M(0), scaled to unit diagonal, has the eigenvalue %.3g: Ct and Cr give modes more "
            "mass than Me has; MBSR_SID_COUPLING would leave %.3g of them",
            r->definite, r->keep_coupling);
    if (change < MBSR_SID_SECOND_ORDER &&
        (r->keep_strain < 1.0 || r->keep_rest < 1.0 || r->changed_P > rounding))
        return REFUSE(
            "J.m1, Oe.m1 and Cr.m1 do not fit Me: to be those of a body, at least %.3g of J.m1 "
            "and %.3g of the others could stay, and P would change by %.3g of modal masses; "
            "MBSR_SID_SECOND_ORDER does so",
            r->keep_strain, r->keep_rest, r->changed_P);
    return MBSR_OK;
}

int mbsri_sid_fit(mbsri_arena *arena, mbsr_sid_change change, mbsri_sid_integrals *s,
                  mbsr_sid_report *r, mbsr_error *error)
{
    fit fitted = {.arena = arena, .s = s, .error = error, .n = s->n};
    fit *f = &fitted;
    const size_t n = (size_t)s->n, rows = 3 * n;
    if (!make_fit(f)) return MBSR_ERR_NO_MEMORY;
    int status = take_root(f);
    if (status) return status;
    couple(f);
    put_together(f);
    for (size_t k = 0; k < rows * rows; ++k) f->S[k] = s->P[k] - f->T[k];
    mbsri_copy(n * n, s->Mf, f->rest);
    status = fit_part(f, f->rank, f->Zr, &r->keep_coupling);
    if (!status) status = fit_part(f, f->rank, f->Zs, &r->keep_strain);
    if (!status) status = take_root_of_rest(f);
    if (!status) status = fit_part(f, (int)rows, f->F, &r->keep_rest);
    if (status) return status;
    put_together(f);
    r->changed_P = largest_difference_from_P(f);
    status = judge(f, change, r);
    if (status) return status;
    uncouple(f); /* in any case: what rounding leaves where a field is zero would be of no body */
    mbsri_copy(rows * rows, f->T, s->P);
    return MBSR_OK;
}

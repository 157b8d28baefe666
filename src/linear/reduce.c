/* The least number of states: what has finite eigenvalues.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of E x' = A x + B w let P be the columns of the unit matrix in the rows where E has numbers, E =
 * P Er, and K = s E - A for a real shift s that is no eigenvalue. With r = Er x,
 *
 *   x = K^-1 (P (s r - r') + B w)           S r' = (s S - 1) r + b w,   S = Er K^-1 P,  b = Er K^-1
 * B
 *
 * An eigenvalue e of the pencil is one 1 / (s - e) of S; infinite ones are zeros of S, in Jordan
 * blocks as long as the index. Zeros that are computed as eigenvalues are not zero, but the root of
 * rounding errors: huge finite eigenvalues. So they are taken out as ranges: U1 spans that of S, U2
 * that of U1^T S U1, and so on until nothing is lost. Each is a decision on singular values, with S
 * scaled, which makes it one without units. In the basis (U, W) with W what was taken out,
 *
 *   S = (S11 S12; 0 N),  N nilpotent        r = U a + W v,   v = b2 w where N b2 = 0
 *   z = a + S11^-1 S12 v                    z' = (s - S11^-1) z + (S11^-2 S12 b2 + S11^-1 b1) w
 *
 * Momenta along directions without mass are constants that no equation reads (as many as the mass
 * matrix lacks rank): r counts but for these, S in the space orthogonal to them. */
#include "linear/record.h"

#include "base/error.h"
#include "linear/lapack.h"

#include <float.h>
#include <math.h>
#include <string.h>

typedef struct reduction {
    mbsr_linear *l;
    mbsri_arena *arena;
    int n, m, states;
    int *row;            /* m: rows of E that have numbers */
    double *K, *X;       /* n x n: factors; n x (m + inputs): K^-1 (P, B) */
    double *Y;           /* outputs x (m + inputs): C X of all outputs */
    double *Er;          /* m x n */
    const double *mass;  /* nu: of rates */
    double *of_q, *of_p; /* nu x nu: q and p by what counts in energies, of_q^T of_p = 1 */
    double *S, *b;       /* m x m, m x inputs, scaled */
    double *scale;       /* m: r = (of_q, of_p, 1) scale (scaled r) */
    double *U, *W;       /* m x states, m x rest, scaled */
    int unseen, rest;    /* momenta that no equation reads; columns of W */
    double *spare;       /* n x n */
    double *work;        /* work_size */
    int *pivots;         /* 2 n */
    int work_size;
} reduction;

/* The matrices are right to some 1e-10 of their largest numbers: second derivatives of rows are
 * differences. */
static const double smallest = 1e-9, clear = 100.0;

static double *numbers(reduction *z, int rows, int columns)
{
    return mbsri_arena_take(z->arena, ((size_t)rows * (size_t)columns + 1) * sizeof(double));
}

/* C (m x n) = A (m x k, or its transpose) B (k x n) */
static void multiply_matrices(const char *transposed, int m, int n, int k, const double *A, int lda,
                              const double *B, int ldb, double *C, int ldc)
{
    const double one = 1.0, zero = 0.0;
    if (m == 0 || n == 0) return;
    if (k == 0) {
        for (int j = 0; j < n; ++j) memset(C + (size_t)j * (size_t)ldc, 0, (size_t)m * sizeof *C);
        return;
    }
    dgemm_(transposed, "N", &m, &n, &k, &one, A, &lda, B, &ldb, &zero, C, &ldc, 1, 1);
}

/* Which part of what a rate moves is left of it where others may move against it: below, it counts
 * as moved by them together. And rounding in it. */
static const double together = 1e-3, nothing = 1e-10;

/* L of D^(-1/2) M D^(-1/2) = L L^T with D = mass, by largest pivots, whose numbers go into `order`.
 * M gets lost. */
static void factor_masses(int n, const double *mass, double *M, double *L, int *order)
{
    for (int j = 0; j < n; ++j) {
        order[j] = j;
        for (int i = 0; i < n; ++i) M[j * n + i] /= sqrt(mass[i] * mass[j]);
    }
    memset(L, 0, (size_t)n * (size_t)n * sizeof *L);
    for (int k = 0; k < n; ++k) {
        int best = k;
        for (int j = k + 1; j < n; ++j) {
            if (M[order[j] * (n + 1)] > M[order[best] * (n + 1)]) best = j;
        }
        const int at = order[best];
        order[best] = order[k], order[k] = at;
        const double root = sqrt(fmax(M[at * (n + 1)], nothing));
        L[k * n + at] = root;
        for (int j = k + 1; j < n; ++j) L[k * n + order[j]] = M[at * n + order[j]] / root;
        for (int j = k + 1; j < n; ++j) {
            for (int i = k + 1; i < n; ++i)
                M[order[j] * n + order[i]] -= L[k * n + order[j]] * L[k * n + order[i]];
        }
    }
}

/* of_q = D^(-1/2) Q D^(1/2) and of_p = of_q^-T. Columns of Q are those of 1, but where several
 * rates move little together: these are columns of L^-T, which have mass 1 and move nothing along
 * the others. */
static void find_energies(reduction *z, const double *M)
{
    const int n = z->l->nu;
    int *order = z->pivots;
    double *L = z->of_p, *Q = z->of_q;
    memcpy(z->spare, M, (size_t)n * (size_t)n * sizeof *M);
    factor_masses(n, z->mass, z->spare, L, order);
    memset(Q, 0, (size_t)n * (size_t)n * sizeof *Q);
    for (int j = 0; j < n; ++j) {
        const double own = L[j * n + order[j]];
        double *x = Q + order[j] * n;
        x[order[j]] = 1.0;
        if (j >= n - z->unseen || own * own > together) continue;
        for (int k = j; k >= 0; --k) {
            double sum = k == j ? 1.0 : 0.0;
            for (int l = k + 1; l <= j; ++l) sum -= L[k * n + order[l]] * x[order[l]];
            x[order[k]] = sum / L[k * n + order[k]];
        }
    }
    for (int j = 0; j < n; ++j) {
        double *y = z->spare + order[j] * n;
        for (int k = 0; k < n; ++k) {
            double sum = k == j ? 1.0 : 0.0;
            for (int l = j; l < k; ++l) sum -= Q[order[k] * n + order[l]] * y[order[l]];
            y[order[k]] = sum / Q[order[k] * n + order[k]];
        }
    }
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const double beside = i == j ? 1.0 : sqrt(z->mass[i] / z->mass[j]);
            z->of_p[j * n + i] = z->spare[j * n + i] * beside;
            z->of_q[j * n + i] /= beside;
        }
    }
}

/* Rows and columns of A (n x n) times powers of 2, so that the largest entry of each is about 1;
 * false: one is zero. */
static bool equilibrate(int n, double *A, double *row, double *column)
{
    const size_t size = (size_t)n;
    for (int i = 0; i < n; ++i) row[i] = column[i] = 1.0;
    for (int round = 0; round < 20; ++round) {
        double *scale = round % 2 ? column : row;
        const size_t along = round % 2 ? 1 : size, across = round % 2 ? size : 1;
        for (size_t i = 0; i < size; ++i) {
            double most = 0.0;
            for (size_t j = 0; j < size; ++j) most = fmax(most, fabs(A[i * across + j * along]));
            if (!(most > 0.0)) return false;
            const double factor = exp2(-rint(round < 16 ? 0.5 * log2(most) : log2(most)));
            for (size_t j = 0; j < size; ++j) A[i * across + j * along] *= factor;
            scale[i] *= factor;
        }
    }
    return true;
}

/* Factors of A (n x n); false: it is singular to rounding. work: 4 n, iwork: n. */
static bool factor_dense(int n, double *A, int *pivots, double *work, int *iwork)
{
    int info = 0;
    double norm = 0.0, rcond = 0.0;
    if (n == 0) return true;
    for (int j = 0; j < n; ++j) {
        double sum = 0.0;
        for (int i = 0; i < n; ++i) sum += fabs(A[(size_t)j * (size_t)n + (size_t)i]);
        norm = fmax(norm, sum);
    }
    dgetrf_(&n, &n, A, &n, pivots, &info);
    if (info) return false;
    dgecon_("1", &n, A, &n, &norm, &rcond, work, iwork, &info, 1);
    return rcond > DBL_EPSILON;
}

/* K of the shift, X of it; false: it is an eigenvalue. */
static bool solve_shift(reduction *z, double shift)
{
    const mbsr_linear *l = z->l;
    const int n = z->n, count = z->m + l->inputs;
    const size_t size = (size_t)n;
    const double *E = l->part[MBSR_LINEAR_E], *A = l->part[MBSR_LINEAR_A],
                 *B = l->part[MBSR_LINEAR_B];
    double *row = z->work, *column = row + n;
    int info = 0;
    for (size_t k = 0; k < size * size; ++k) z->K[k] = shift * E[k] - A[k];
    if (!equilibrate(n, z->K, row, column) ||
        !factor_dense(n, z->K, z->pivots, column + n, z->pivots + n))
        return false;
    memset(z->X, 0, size * (size_t)count * sizeof *z->X);
    for (int j = 0; j < z->m; ++j) z->X[(size_t)j * size + (size_t)z->row[j]] = row[z->row[j]];
    for (int j = 0; j < l->inputs; ++j) {
        double *x = z->X + (size_t)(z->m + j) * size;
        for (int i = 0; i < n; ++i) x[i] = row[i] * B[(size_t)j * size + (size_t)i];
    }
    if (count > 0) dgetrs_("N", &n, &count, z->K, &n, z->pivots, z->X, &n, &info, 1);
    for (int j = 0; j < count; ++j) {
        for (int i = 0; i < n; ++i) z->X[(size_t)j * size + (size_t)i] *= column[i];
    }
    const size_t half = size * (size_t)l->nu;
    memcpy(z->K, z->X, 2 * half * sizeof *z->X);
    multiply_matrices("N", n, l->nu, l->nu, z->K, n, z->of_q, l->nu, z->X, n);
    multiply_matrices("N", n, l->nu, l->nu, z->K + half, n, z->of_p, l->nu, z->X + half, n);
    return info == 0;
}

/* The rate at which its mass swings along column j of of_q. */
static double swing_rate(const reduction *z, int j)
{
    const mbsr_linear *l = z->l;
    const size_t n = (size_t)l->info.size, nu = (size_t)l->nu;
    const double *x = z->of_q + (size_t)j * nu;
    double stiffness = 0.0;
    for (size_t k = 0; k < nu; ++k) {
        for (size_t i = 0; i < nu && x[k] != 0.0; ++i)
            stiffness += x[i] * l->part[MBSR_LINEAR_A][k * n + nu + i] * x[k];
    }
    return sqrt(fabs(stiffness) / z->mass[j]);
}

/* What forces of stiff rows whose springs have the energy 1/2 make in a row of E; 0: nothing. */
static double of_springs(const mbsr_linear *l, int row)
{
    const size_t n = (size_t)l->info.size, first = 3 * (size_t)l->nu,
                 end = first + (size_t)l->closure_rows;
    const double *E = l->part[MBSR_LINEAR_E];
    double sum = 0.0;
    for (size_t j = first; j < end; ++j) {
        const double compliance = fabs(E[j * (n + 1)]);
        if (compliance > 0.0) sum += fabs(E[j * n + (size_t)row]) / sqrt(compliance);
    }
    return sum;
}

/* Scales of r: squares of q, p and forces of stiff rows become energies of what swings at the
 * shift, or much faster; motions, which stand behind them, act on these as strongly as these on
 * them. Not as all numbers of S say: in zeros of S, which are Jordan blocks, rounding would become
 * as large as what is there. */
static void scale_states(reduction *z, double shift)
{
    const int nu = z->l->nu;
    for (int j = 0; j < nu; ++j) {
        const double root = sqrt(z->mass[j]);
        z->scale[j] = 1.0 / (root * fmax(shift, 0.1 * swing_rate(z, j)));
        z->scale[nu + j] = root;
    }
    for (int k = 2 * nu; k < z->m; ++k) {
        double row = 0.0, column = 0.0;
        z->scale[k] = of_springs(z->l, z->row[k]);
        if (z->scale[k] > 0.0) continue;
        for (int j = 0; j < 2 * nu; ++j) {
            row += fabs(z->S[(size_t)j * (size_t)z->m + (size_t)k]) * z->scale[j];
            column += fabs(z->S[(size_t)k * (size_t)z->m + (size_t)j]) / z->scale[j];
        }
        if (!(row > 0.0)) row = column > 0.0 ? 1.0 / (column * shift * shift) : 1.0;
        if (!(column > 0.0)) column = 1.0 / (row * shift * shift);
        z->scale[k] = sqrt(row / column);
    }
}

/* S and b of X, with Er, scaled. */
static void compress(reduction *z, double shift)
{
    const mbsr_linear *l = z->l;
    const int n = z->n, m = z->m;
    const double *E = l->part[MBSR_LINEAR_E];
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < m; ++i)
            z->Er[(size_t)j * (size_t)m + (size_t)i] = E[(size_t)j * (size_t)n + (size_t)z->row[i]];
    }
    memcpy(z->K, z->Er, (size_t)m * (size_t)n * sizeof *z->K);
    multiply_matrices("T", l->nu, n, l->nu, z->of_p, l->nu, z->K, m, z->Er, m);
    multiply_matrices("T", l->nu, n, l->nu, z->of_q, l->nu, z->K + l->nu, m, z->Er + l->nu, m);
    multiply_matrices("N", m, m, n, z->Er, m, z->X, n, z->S, m);
    multiply_matrices("N", m, l->inputs, n, z->Er, m, z->X + (size_t)m * (size_t)n, n, z->b, m);
    scale_states(z, shift);
    for (int j = 0; j < m + l->inputs; ++j) {
        double *column = j < m ? z->S + (size_t)j * (size_t)m : z->b + (size_t)(j - m) * (size_t)m;
        const double own = j < m ? z->scale[j] : 1.0;
        for (int i = 0; i < m; ++i) column[i] *= own / z->scale[i];
    }
}

/* A shift of the size of the finite eigenvalues: their geometric mean, from those that the present
 * one sees. Zeros in blocks of three are seen as 1e-5 or less of the shift: so small ones count
 * where there are no others. */
static double better_shift(reduction *z, double shift)
{
    static const double zero = 1e-6, small = 1e-4, infinite = 1e6;
    const int m = z->m, one = 1, size = z->work_size;
    double *re = z->work, *im = re + m;
    int info = 0;
    memcpy(z->spare, z->S, (size_t)m * (size_t)m * sizeof *z->S);
    const int left = size - 2 * m;
    dgeev_("N", "N", &m, z->spare, &m, re, im, NULL, &one, NULL, &one, im + m, &left, &info, 1, 1);
    for (int slow = 0; slow < 2; ++slow) {
        double sum = 0.0;
        int count = 0;
        for (int k = 0; k < m && info == 0; ++k) {
            const double square = re[k] * re[k] + im[k] * im[k];
            if (!(square > 0.0)) continue;
            const double rate = hypot(shift - re[k] / square, im[k] / square) / shift;
            if (!(rate > (slow ? zero : small) && rate < (slow ? small : infinite))) continue;
            sum += log(rate);
            ++count;
        }
        if (count > 0) return shift * exp(sum / count);
    }
    return shift;
}

/* The rate that coordinate j has by itself: of its mass at its stiffness or damping; 0: none. */
static double own_rate(const mbsr_linear *l, size_t j, double mass)
{
    const size_t n = (size_t)l->info.size, nu = (size_t)l->nu, p = nu + j, u = 2 * nu + j;
    const double *A = l->part[MBSR_LINEAR_A];
    return fmax(sqrt(fabs(A[j * n + p]) / mass), fabs(A[u * n + p]) / mass);
}

/* To begin with: the geometric mean of these rates, but for those that are rounding in a stiffness
 * beside the others or the rate typical of the model; where there are none, that, 1 without one. */
static double first_shift(const reduction *z, double typical)
{
    double largest = typical, sum = 0.0;
    int count = 0;
    for (int j = 0; j < z->l->nu; ++j)
        largest = fmax(largest, own_rate(z->l, (size_t)j, z->mass[j]));
    for (int j = 0; j < z->l->nu && isfinite(largest); ++j) {
        const double rate = own_rate(z->l, (size_t)j, z->mass[j]);
        if (!(rate > 1e-6 * largest)) continue;
        sum += log(rate);
        ++count;
    }
    if (count > 0) return exp(sum / count);
    return typical > 0.0 ? typical : 1.0;
}

/* What has no pole at a shift near `about`; 0: none. */
static double find_shift(reduction *z, double about)
{
    for (int k = 0; k < 8; ++k) {
        if (solve_shift(z, about)) return about;
        about *= 1.3819660112501051;
    }
    return 0.0;
}

/* One step: of cur (size x size) the range U1, and what is left U2. Returns the rank; U1 and U2
 * side by side in `range`. */
static int find_range(reduction *z, int size, const double *cur, double *range)
{
    const int one = 1, left = z->work_size - size;
    double *values = z->work;
    int info = 0, rank = 0;
    mbsr_linear_info *of = &z->l->info;
    memcpy(z->spare, cur, (size_t)size * (size_t)size * sizeof *cur);
    dgesvd_("A", "N", &size, &size, z->spare, &size, values, range, &size, NULL, &one,
            values + size, &left, &info, 1, 1);
    if (info) return 0;
    const double most = fmax(values[0], 1.0 / of->shift); /* eigenvalues of S are such */
    while (rank < size && values[rank] > smallest * most) ++rank;
    if (rank == size) of->kept = values[rank - 1] / most;
    if (rank < size) of->dropped = fmax(of->dropped, values[rank] / most);
    return rank;
}

/* U: what is orthogonal to momenta that no equation reads, the null space of A in their columns;
 * false: LAPACK failed. */
static bool find_read(reduction *z)
{
    const mbsr_linear *l = z->l;
    const size_t m = (size_t)z->m, nu = (size_t)l->nu;
    const int count = l->nu, one = 1, left = z->work_size - l->nu;
    int info = 0;
    memset(z->U, 0, m * m * sizeof *z->U);
    if (z->unseen == 0) {
        for (size_t k = 0; k < m; ++k) z->U[k * (m + 1)] = 1.0;
        return true;
    }
    multiply_matrices("N", count, count, count, l->part[MBSR_LINEAR_A] + nu * (size_t)z->n + 2 * nu,
                      z->n, z->of_p, count, z->spare, count);
    for (size_t j = 0; j < nu; ++j) {
        for (size_t i = 0; i < nu; ++i) z->spare[j * nu + i] *= z->scale[nu + j];
    }
    /* rows of V^T: those read first */
    dgesvd_("N", "A", &count, &count, z->spare, &count, z->work, NULL, &one, z->K, &count,
            z->work + nu, &left, &info, 1, 1);
    size_t at = 0;
    for (size_t k = 0; k < m; ++k) {
        if (k >= nu && k < 2 * nu) continue;
        z->U[at++ * m + k] = 1.0;
    }
    for (size_t k = 0; k < nu - (size_t)z->unseen; ++k, ++at) {
        for (size_t j = 0; j < nu; ++j) z->U[at * m + nu + j] = z->K[j * nu + k];
    }
    return info == 0;
}

/* U and W, and S11, which `cur` becomes; false: LAPACK failed. */
static bool find_ranges(reduction *z, double *cur, double *range, double *next)
{
    const size_t m = (size_t)z->m;
    int size = z->m - z->unseen;
    if (!find_read(z)) return false;
    multiply_matrices("N", z->m, size, z->m, z->S, z->m, z->U, z->m, next, z->m);
    multiply_matrices("T", size, size, z->m, z->U, z->m, next, z->m, cur, size);
    while (size > 0) {
        const int rank = find_range(z, size, cur, range);
        if (rank == size) break;
        ++z->l->info.levels;
        /* W <- (W, U U2),  U <- U U1,  cur <- U1^T cur U1 */
        multiply_matrices("N", z->m, size - rank, size, z->U, z->m,
                          range + (size_t)rank * (size_t)size, size, z->W + (size_t)z->rest * m,
                          z->m);
        z->rest += size - rank;
        multiply_matrices("N", z->m, rank, size, z->U, z->m, range, size, next, z->m);
        memcpy(z->U, next, m * (size_t)rank * sizeof *next);
        multiply_matrices("N", size, rank, size, cur, size, range, size, next, size);
        multiply_matrices("T", rank, rank, size, range, size, next, size, cur, rank);
        size = rank;
    }
    z->states = size;
    return true;
}

/* Ar = s - S11^-1 and T = S11^-1; false: singular, which ranges exclude. */
static bool invert(reduction *z, const double *S11, double *T, double *Ar)
{
    const int n = z->states;
    const size_t size = (size_t)n;
    int info = 0;
    memcpy(z->spare, S11, size * size * sizeof *S11);
    if (!factor_dense(n, z->spare, z->pivots, z->work, z->pivots + n)) return false;
    memset(T, 0, size * size * sizeof *T);
    for (size_t k = 0; k < size; ++k) T[k * (size + 1)] = 1.0;
    if (n > 0) dgetrs_("N", &n, &n, z->spare, &n, z->pivots, T, &n, &info, 1);
    for (size_t k = 0; k < size * size; ++k) Ar[k] = -T[k];
    for (size_t k = 0; k < size; ++k) Ar[k * (size + 1)] += z->l->info.shift;
    return info == 0;
}

/* A row of K^-1 P, or C K^-1 P, with `apart` from entry to entry, times scale v (m x columns) into
 * to, which has `stride`. */
static void lift(const reduction *z, const double *row, int apart, int columns, const double *v,
                 double *to, int stride)
{
    for (int j = 0; j < columns; ++j) {
        double sum = 0.0;
        for (int k = 0; k < z->m; ++k)
            sum += row[(size_t)k * (size_t)apart] * z->scale[k] *
                   v[(size_t)j * (size_t)z->m + (size_t)k];
        to[(size_t)j * (size_t)stride] = sum;
    }
}

/* Whether what output i sees of w' is rounding: its row times scale v beside the sum of its sizes.
 */
static bool is_rounding(const reduction *z, int i, const double *v)
{
    double sum = 0.0, size = 0.0;
    for (int k = 0; k < z->m; ++k) {
        const double part =
            z->Y[(size_t)k * (size_t)z->l->outputs + (size_t)i] * z->scale[k] * v[k];
        sum += part;
        size += fabs(part);
    }
    return fabs(sum) <= 1e-9 * size || size < 1e-12 * z->l->info.shift;
}

/* The matrices of inputs. T = S11^-1; a memory of numbers for each. */
static bool reduce_inputs(reduction *z, const double *T)
{
    mbsr_linear *l = z->l;
    const int m = z->m, n = z->states, rest = z->rest, count = l->inputs;
    double *S12 = numbers(z, n, rest), *SW = numbers(z, m, rest), *TS = numbers(z, n, rest),
           *b1 = numbers(z, n, count), *b2 = numbers(z, rest, count), *c = numbers(z, n, count),
           *Q = numbers(z, m, rest), *Qb = numbers(z, m, count), *v = numbers(z, m, count);
    if (z->arena->failed) return true;
    multiply_matrices("N", m, rest, m, z->S, m, z->W, m, SW, m);
    multiply_matrices("T", n, rest, m, z->U, m, SW, m, S12, n);
    multiply_matrices("N", n, rest, n, T, n, S12, n, TS, n);
    multiply_matrices("T", n, count, m, z->U, m, z->b, m, b1, n);
    multiply_matrices("T", rest, count, m, z->W, m, z->b, m, b2, rest);
    double *Br = l->part[MBSR_LINEAR_BR], *Dr = l->part[MBSR_LINEAR_DR];
    multiply_matrices("N", n, count, rest, TS, n, b2, rest, c, n);
    for (int k = 0; k < n * count; ++k) c[k] += b1[k];
    multiply_matrices("N", n, count, n, T, n, c, n, Br, n);
    /* Q = W - U T S12 */
    multiply_matrices("N", m, rest, n, z->U, m, TS, n, Q, m);
    for (int k = 0; k < m * rest; ++k) Q[k] = z->W[k] - Q[k];
    multiply_matrices("N", m, count, rest, Q, m, b2, rest, Qb, m);
    multiply_matrices("N", m, count, n, z->U, m, Br, n, v, m);
    for (int k = 0; k < m * count; ++k) v[k] = l->info.shift * Qb[k] - v[k];
    for (int i = 0; i < l->outputs; ++i) {
        lift(z, z->Y + i, l->outputs, count, v, Dr + i, l->outputs);
        for (int j = 0; j < count; ++j) {
            const int at = j * l->outputs + i;
            Dr[at] += z->Y[(size_t)(m * l->outputs + at)] + l->direct[at];
            if (!is_rounding(z, i, Qb + (size_t)j * (size_t)m)) return false;
        }
    }
    return true;
}

static void take_parts(reduction *z)
{
    mbsr_linear *l = z->l;
    const int rows[] = {z->states, z->states, l->outputs, l->outputs},
              columns[] = {z->states, l->inputs, z->states, l->inputs};
    for (int k = 0; k < 4; ++k) {
        l->rows[MBSR_LINEAR_AR + k] = rows[k];
        l->columns[MBSR_LINEAR_AR + k] = columns[k];
        l->part[MBSR_LINEAR_AR + k] = numbers(z, rows[k], columns[k]);
    }
    l->shapes = numbers(z, l->nu, z->states);
}

static int no_memory_to_reduce(mbsr_error *error, int size)
{
    return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "mbsr_linear_create: no memory for %d equations", size);
}

static bool open(reduction *z)
{
    const int n = z->n, m = z->m;
    z->pivots = mbsri_arena_take(z->arena, 2 * ((size_t)n + 1) * sizeof *z->pivots);
    z->K = numbers(z, n, n);
    z->X = numbers(z, n, m + z->l->inputs);
    z->Y = numbers(z, z->l->outputs, m + z->l->inputs);
    z->Er = numbers(z, m, n);
    z->S = numbers(z, m, m);
    z->b = numbers(z, m, z->l->inputs);
    z->scale = numbers(z, m, 1);
    z->of_q = numbers(z, z->l->nu, z->l->nu);
    z->of_p = numbers(z, z->l->nu, z->l->nu);
    z->U = numbers(z, m, m);
    z->W = numbers(z, m, m);
    z->spare = numbers(z, n, n);
    z->work_size = 10 * n + 100;
    z->work = numbers(z, z->work_size, 1);
    return !z->arena->failed;
}

/* Once S is there. */
static int solve_states(reduction *z, mbsr_error *error)
{
    mbsr_linear *l = z->l;
    const int m = z->m;
    double *cur = numbers(z, m, m), *range = numbers(z, m, m), *next = numbers(z, m, m),
           *T = numbers(z, m, m);
    if (z->arena->failed) return no_memory_to_reduce(error, z->n);
    l->info.kept = 1.0;
    if (!find_ranges(z, cur, range, next))
        return mbsri_fail(
            error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
            "mbsr_linear_create: the singular values of the equations were not found");
    l->info.states = z->states;
    if (l->info.dropped > 0.0 && l->info.kept < clear * l->info.dropped)
        return mbsri_fail(error, MBSR_RANK_CHANGED, MBSR_NONE, MBSR_NONE,
                          "mbsr_linear_create: it is not clear how many eigenvalues are finite: "
                          "numbers of %.2g were kept and of %.2g dropped; small masses or large "
                          "stiffnesses lie between zero and the others",
                          l->info.kept, l->info.dropped);
    take_parts(z);
    if (z->arena->failed) return no_memory_to_reduce(error, z->n);
    if (!invert(z, cur, T, l->part[MBSR_LINEAR_AR]))
        return mbsri_fail(error, MBSR_UNDETERMINED, MBSR_NONE, MBSR_NONE,
                          "mbsr_linear_create: the reduced equations are singular");
    multiply_matrices("N", m, z->states, z->states, z->U, m, T, z->states, next, m);
    multiply_matrices("N", l->outputs, m + l->inputs, z->n, l->output, l->outputs, z->X, z->n, z->Y,
                      l->outputs);
    for (int i = 0; i < l->nu; ++i) lift(z, z->X + i, z->n, z->states, next, l->shapes + i, l->nu);
    for (int i = 0; i < l->outputs; ++i)
        lift(z, z->Y + i, l->outputs, z->states, next, l->part[MBSR_LINEAR_CR] + i, l->outputs);
    const bool smooth = reduce_inputs(z, T);
    if (z->arena->failed) return no_memory_to_reduce(error, z->n);
    if (!smooth)
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_linear_create: an output depends on the rate of an input: the "
                          "input acts on directions without mass that springs alone hold");
    return MBSR_OK;
}

int mbsri_pencil_reduce(mbsr_linear *l, int rank, const double *mass, const double *M,
                        double typical, mbsr_error *error)
{
    reduction z = {
        .l = l, .arena = &l->arena, .n = l->info.size, .unseen = l->nu - rank, .mass = mass};
    z.row = mbsri_arena_take(z.arena, ((size_t)z.n + 1) * sizeof *z.row);
    for (int i = 0; i < z.n && z.row; ++i) {
        for (int j = 0; j < z.n; ++j) {
            if (l->part[MBSR_LINEAR_E][(size_t)j * (size_t)z.n + (size_t)i] == 0.0) continue;
            z.row[z.m++] = i;
            break;
        }
    }
    if (!z.row || !open(&z)) return no_memory_to_reduce(error, z.n);
    find_energies(&z, M);
    double shift = find_shift(&z, first_shift(&z, typical));
    for (int k = 0; k < 3 && shift > 0.0; ++k) {
        compress(&z, shift);
        const double better = better_shift(&z, shift);
        if (k == 2 || fabs(log10(better / shift)) < 1.0) break;
        shift = find_shift(&z, better);
    }
    if (!(shift > 0.0))
        return mbsri_fail(error, MBSR_UNDETERMINED, MBSR_NONE, MBSR_NONE,
                          "mbsr_linear_create: the equations are singular at any shift: nothing "
                          "determines some direction (mbsr_index_report_create names it)");
    l->info.shift = shift;
    return solve_states(&z, error);
}

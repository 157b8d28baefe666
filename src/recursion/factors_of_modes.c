/* Rank and factors of a joint block: see factors_of_modes.h, and flexible_factors.c for the
 * derivation.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/factors_of_modes.h"

#include "algebra/cholesky.h"
#include "algebra/dense.h"
#include "flexible/unit_masses.h"
#include "recursion/rank.h"

#include <float.h>
#include <math.h>

/* ---- from the markers ---- */

/* A = C C^T, largest pivots first, each as large beside its error in E as rounding; C: 6 x the
 * rank, which is returned. *least: no more than the least of them. */
static int root_of(const double *A, const double *E, double C[36], double *least)
{
    double left[36];
    int rank = 0;
    mbsri_copy(36, A, left);
    for (; rank < 6; ++rank) {
        int p = -1;
        double best = 4.0 * DBL_EPSILON, *column = C + 6 * rank;
        for (int k = 0; k < 6; ++k) {
            const double part = E[7 * k] > 0.0 ? left[7 * k] / E[7 * k] : 0.0;
            if (part > best) best = part, p = k;
        }
        if (p < 0) return rank;
        *least = fmin(*least, best);
        const double pivot = sqrt(left[7 * p]);
        for (int k = 0; k < 6; ++k) column[k] = left[6 * p + k] / pivot;
        for (int j = 0; j < 6; ++j) {
            for (int k = 0; k < 6; ++k) left[6 * j + k] -= column[j] * column[k];
        }
        for (int k = 0; k < 6; ++k) left[6 * p + k] = left[6 * k + p] = 0.0;
    }
    return rank;
}

/* The rows of V; their number, or -1 where they are too many to gain something. *least: of the
 * pivots. */
static int fill_V(const mbsr_model *m, const mbsr_data *d, int i, double *V, double *least)
{
    const mbsri_body *b = m->body + i;
    const int n = b->n, most = n / 2;
    int rows = 0;
    *least = 1.0;
    for (int k = b->on.first; k > 0; k = m->body[k].on.next) {
        const mbsri_body *marker = m->body + k;
        const double *A = d->Mbar + marker->dd,
                     *H = d->H + marker->dp + MBSRI_FRAME_ROWS * MBSRI_FRAME_ROWS;
        double C[36];
        if (mbsri_is_zero(36, A)) continue;
        const int rank = root_of(A, d->W + marker->dd, C, least);
        if (rows + rank > most) return -1;
        for (int l = 0; l < rank; ++l, ++rows) {
            mbsri_zero((size_t)n, V + rows * n);
            mbsri_atx(MBSRI_FRAME_ROWS, n, 1.0, H, C + 6 * l, V + rows * n);
        }
    }
    return rows;
}

/* Diag(D), and S = Diag(J^T W J)^(-1/2); the largest entry of that. */
static double scale_modes(const mbsr_model *m, const mbsr_data *d, int i, const mbsri_factors *f,
                          double *s)
{
    const mbsri_body *b = m->body + i;
    const int n = f->n;
    double largest = 0.0;
    for (int a = 0; a < n; ++a) f->diagonal[a] = f->flex->Mf[a * (n + 1)];
    for (int r = 0; r < f->rows; ++r) {
        for (int a = 0; a < n; ++a) f->diagonal[a] += f->V[r * n + a] * f->V[r * n + a];
    }
    mbsri_copy((size_t)n, f->diagonal, s);
    for (int k = b->on.first; k > 0; k = m->body[k].on.next) {
        const double *E = d->W + m->body[k].dd,
                     *H = d->H + m->body[k].dp + MBSRI_FRAME_ROWS * MBSRI_FRAME_ROWS;
        if (mbsri_is_zero(36, E)) continue;
        for (int a = 0; a < n; ++a) {
            double x[6] = {0.0};
            mbsri_ax(MBSRI_FRAME_ROWS, MBSRI_FRAME_ROWS, 1.0, E, H + MBSRI_FRAME_ROWS * a, x);
            s[a] += mbsri_dot(MBSRI_FRAME_ROWS, H + MBSRI_FRAME_ROWS * a, x);
        }
    }
    for (int a = 0; a < n; ++a) {
        largest = isnan(s[a]) ? s[a] : fmax(s[a], largest);
        if (isnan(largest)) return largest;
        s[a] = s[a] > 0.0 ? 1.0 / sqrt(s[a]) : 1.0;
    }
    return largest;
}

/* ---- massless modes ---- */

/* s^2 |x|^2 of a mode's entries x in the rows from `first` on. */
static double square_of(const mbsri_factors *f, const double *s, int first, int a)
{
    double sum = 0.0;
    for (int r = first; r < f->rows; ++r) sum += f->V[r * f->n + a] * f->V[r * f->n + a];
    return sum * s[a] * s[a];
}

/* Turns the rows from `row` on so that mode a is in the first of them alone; v: rows. */
static void reflect(const mbsri_factors *f, int row, int a, double *v, double *Vv)
{
    const int n = f->n, count = f->rows - row;
    double *V = f->V + row * n, squares = 0.0, length = 0.0;
    for (int r = 0; r < count; ++r) v[r] = V[r * n + a], length += v[r] * v[r];
    v[0] += v[0] < 0.0 ? -sqrt(length) : sqrt(length);
    for (int r = 0; r < count; ++r) squares += v[r] * v[r];
    mbsri_zero((size_t)n, Vv);
    mbsri_ax_long(n, count, 2.0 / squares, V, v, Vv);
    for (int r = 0; r < count; ++r) mbsri_ax(n, 1, -v[r], Vv, &(double){1.0}, V + r * n);
    for (int r = 1; r < count; ++r) V[r * n + a] = 0.0;
}

/* Exchanges massless modes in the order. */
static void bring_forward(int *order, int to, int from)
{
    const int kept = order[to];
    order[to] = order[from];
    order[from] = kept;
}

/* V_z by the order of its columns, which are those of `count` massless modes; sets `kept`, clears
 * what is left and returns the sum of its s^2 |x|^2. */
static double reduce_massless(mbsri_factors *f, const double *s, double least, int count,
                              int *order, double *work)
{
    double left = 0.0;
    for (f->kept = 0; f->kept < count && f->kept < f->rows; ++f->kept) {
        int best = f->kept;
        double largest = 0.0;
        for (int k = f->kept; k < count; ++k) {
            const double square = square_of(f, s, f->kept, order[k]);
            if (square > largest) largest = square, best = k;
        }
        if (!(largest > least)) break;
        bring_forward(order, f->kept, best);
        reflect(f, f->kept, order[f->kept], work, work + f->rows);
    }
    for (int k = f->kept; k < count; ++k) {
        left += square_of(f, s, f->kept, order[k]);
        for (int r = f->kept; r < f->rows; ++r) f->V[r * f->n + order[k]] = 0.0;
    }
    f->others = f->rows - f->kept;
    return left;
}

/* T^-1, its rows at the modes they belong to. */
static void invert_massless(const mbsri_factors *f, const int *order)
{
    const int n = f->n, k = f->kept;
    mbsri_zero((size_t)(n * k), f->T);
    for (int l = 0; l < k; ++l) {
        double *x = f->T + l * n;
        for (int j = l; j >= 0; --j) {
            double sum = j == l ? 1.0 : 0.0;
            for (int c = j + 1; c <= l; ++c) sum -= f->V[j * n + order[c]] * x[order[c]];
            x[order[j]] = sum / f->V[j * n + order[j]];
        }
    }
}

/* Null vectors, n numbers each, of the massless modes that are left. */
static void null_vectors_of_modes(const mbsri_factors *f, int count, const int *order, double *N)
{
    const int n = f->n;
    for (int k = f->kept; k < count; ++k, N += n) {
        mbsri_zero((size_t)n, N);
        for (int l = 0; l < f->kept; ++l)
            mbsri_ax(n, 1, -f->V[l * n + order[k]], f->T + l * n, &(double){1.0}, N);
        N[order[k]] = 1.0;
    }
}

/* ---- modes with mass ---- */

/* x -= (q.x) q; the part along q */
static double take_out_direction(int n, const double *q, double *x)
{
    const double part = mbsri_dot(n, q, x);
    mbsri_ax(n, 1, -part, q, &(double){1.0}, x);
    return part;
}

static void exchange_columns(int n, double *x, double *y)
{
    for (int k = 0; k < n && x != y; ++k) {
        const double kept = x[k];
        x[k] = y[k];
        y[k] = kept;
    }
}

/* The columns of Q become orthonormal, Q Z the former ones, largest first: Z (r x r, upper
 * triangular). What is nothing but rounding becomes zero. */
static void orthogonalise(const mbsri_factors *f, double *Z)
{
    const int n = f->n, r = f->others;
    mbsri_zero((size_t)(r * r), Z);
    for (int j = 0; j < r; ++j) {
        double *q = f->Q + j * n, largest = -1.0, before = 0.0;
        int best = j;
        for (int k = j; k < r; ++k) {
            const double square = mbsri_dot(n, f->Q + k * n, f->Q + k * n);
            if (square > largest) largest = square, best = k;
        }
        exchange_columns(n, q, f->Q + best * n);
        exchange_columns(r, Z + j * r, Z + best * r);
        for (int l = 0; l < j; ++l) before += Z[j * r + l] * Z[j * r + l];
        for (int l = 0; l < j; ++l) Z[j * r + l] += take_out_direction(n, f->Q + l * n, q);
        const double length = sqrt(mbsri_dot(n, q, q));
        const bool some = length > 4.0 * DBL_EPSILON * sqrt(before + length * length);
        for (int k = 0; k < n; ++k) q[k] = some ? q[k] / length : 0.0;
        Z[j * r + j] = some ? length : 0.0;
        for (int k = j + 1; k < r; ++k) Z[k * r + j] = take_out_direction(n, q, f->Q + k * n);
    }
}

/* The Cholesky factor of B = 1 + Z Z^T. */
static bool factor_B(const mbsri_factors *f, const double *Z)
{
    const int r = f->others;
    mbsri_zero((size_t)(r * r), f->B);
    for (int k = 0; k < r; ++k) f->B[k * (r + 1)] = 1.0;
    mbsri_abt(r, r, r, 1.0, Z, Z, f->B);
    return mbsri_cholesky(r, f->B);
}

/* ---- elimination ---- */

/* ||S_z^-1 T^-1 K T^-T S_z^-1|| with K = 1 + V1 (Mf_a + V2^T V2)^-1 V1^T. */
static double massless_bound(const mbsri_factors *f, const double *s, double *work)
{
    const int n = f->n, k = f->kept, r = f->others;
    double *K = work, *along = K + k * k, *x = along + k * r, *Tx = x + k, squares = 0.0;
    mbsri_zero((size_t)(k * (k + r)), K);
    mbsri_atb(n, k, k, 1.0, f->V1, f->V1, K);
    mbsri_atb(n, r, k, 1.0, f->Q, f->V1, along);
    mbsri_atb(r, k, k, -1.0, along, along, K);
    for (int c = 0; c < k; ++c) mbsri_divide_by_cholesky(1, r, f->B, along + c * r);
    mbsri_atb(r, k, k, 1.0, along, along, K);
    for (int c = 0; c < k; ++c) K[c * (k + 1)] += 1.0;
    for (int a = 0; a < n; ++a) {
        if (f->flex->root[a * (n + 1)] != 0.0) continue;
        for (int c = 0; c < k; ++c) x[c] = f->T[c * n + a] / s[a];
        mbsri_zero((size_t)k, Tx);
        mbsri_ax(k, k, 1.0, K, x, Tx);
        squares += mbsri_dot(k, x, Tx);
    }
    return squares;
}

/* A bound of 1 / lambda for the eigenvalues of S D S that are kept. */
static double bound_kept(const mbsri_factors *f, const double *s, double *work)
{
    double lightest = 0.0;
    for (int a = 0; a < f->n; ++a) {
        const double mass = f->flex->Mf[a * (f->n + 1)];
        if (mass > 0.0) lightest = fmax(lightest, 1.0 / (mass * s[a] * s[a]));
    }
    return lightest * f->flex->spread + massless_bound(f, s, work);
}

/* ||S D S||, modal masses off the diagonal left out; work: n times the rows + the square of the
 * rows. */
static double size_of_modes(const mbsri_factors *f, const double *s, double *work)
{
    const int n = f->n, rows = f->rows;
    double squares = 0.0, *SV = work, *gram = SV + n * rows;
    for (int a = 0; a < n; ++a) {
        const double square = s[a] * s[a], mass = square * f->flex->Mf[a * (n + 1)];
        squares += mass * (2.0 * square * f->diagonal[a] - mass);
        for (int r = 0; r < rows; ++r) SV[r * n + a] = s[a] * f->V[r * n + a];
    }
    mbsri_zero((size_t)(rows * rows), gram);
    mbsri_atb(n, rows, rows, 1.0, SV, SV, gram);
    return sqrt(squares + mbsri_dot(rows * rows, gram, gram));
}

/* s of the model where some rank is lacking, and X of what is dropped (rank_pivots.c). */
static void drop(const mbsr_model *m, mbsr_data *d, int i, const mbsri_factors *f, int count,
                 const int *order, double *N)
{
    const mbsri_body *b = m->body + i;
    const int rank = f->flex->massive + f->kept;
    double *s = d->s + b->group.iu;
    if (rank < f->n) {
        null_vectors_of_modes(f, count, order, N);
        if (rank > 0 && m->typical.inertia)
            mbsri_copy((size_t)f->n, m->typical.inertia + b->group.iu, s);
        mbsri_null_columns(f->n, f->n - rank, s, N, d->X + b->nn + rank * f->n);
    }
    if (rank < f->n) d->lambda[b->group.iu] = size_of_modes(f, s, N);
    d->rank[i] = rank;
}

/* Eigenvalues of S D S from here on are known to nine digits, and counted in twofold precision too.
 * Rounding errors of V, eps / sqrt(clear) where `clear` is the least pivot in Mbar^a beside its
 * error, count once and not twice as they do in D. */
static double known_from(const mbsri_rank_rule *rule, double clear)
{
    const double digits = DBL_EPSILON / 1e-9;
    return fmin(rule->known, fmax(10.0 * rule->tolerance, digits * digits / clear));
}

/* Of massless modes that are dropped this is nothing (mbsri_is_nothing). */
static double nothing_from(const mbsri_rank_rule *rule, const mbsri_factors *f, const double *s,
                           int count, const int *order)
{
    double local = 1.0;
    for (int k = f->kept; k < count; ++k)
        local = fmin(local, s[order[k]] * s[order[k]] * f->diagonal[order[k]]);
    return rule->nothing * fmin(1.0, MBSRI_FROM_BEHIND * local);
}

bool mbsri_factors_find_rank(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const mbsri_group g = mbsri_group_of(m, d, i);
    const mbsri_rank_rule rule = mbsri_rank_rule_of(m->rank_tolerance);
    const int n = b->n;
    double *work = mbsri_factors_work(m, d), *s = d->s + b->group.iu;
    int *order = d->pivots, count = 0;
    if (mbsri_given_scale(m, d, &g)) return false;
    double clear;
    const int rows = fill_V(m, d, i, d->D + b->nn, &clear);
    if (rows < 0) return false;
    const double least = known_from(&rule, clear);
    d->factors.rows[i] = rows;
    d->rank[i] = 0;
    mbsri_factors f = mbsri_factors_of(m, d, i);
    const double scale = scale_modes(m, d, i, &f, s);
    if (!isfinite(scale)) return false;
    for (int a = 0; a < n; ++a) {
        if (f.flex->root[a * (n + 1)] == 0.0) order[count++] = a;
    }
    const double left = reduce_massless(&f, s, least, count, order, work);
    const int rank = f.flex->massive + f.kept;
    const bool usual = b->survey.rank == rank + 1;
    if (left > (usual ? rule.tolerance : nothing_from(&rule, &f, s, count, order))) return false;
    f.Q = f.V1 + n * f.kept;
    invert_massless(&f, order);
    mbsri_flex_to_unit_masses(f.flex, f.rows, f.V, f.V1);
    orthogonalise(&f, work);
    if (!factor_B(&f, work)) return false;
    if (!(least * bound_kept(&f, s, work) < 1.0)) return false;
    drop(m, d, i, &f, count, order, work);
    d->scale[b->scalar_offset] = scale;
    return true;
}

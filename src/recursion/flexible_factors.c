/* Joint blocks of flexible bodies in factors: see flexible_factors.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A marker hands on Mbar^a = C C^T (6 x 6, of the rank it has). With L its modes' columns (6 x n)
 * and V the rows C^T L of all markers
 *
 *   D = Mf + V^T V
 *
 * where Mf, which is constant, is zero for massless modes (z) and regular for the others (a), with
 * R^T Mf_a R = 1. Rows of V may be turned; Householder's reflections make V_z = [ T, T'; 0, ~0 ]
 * with T (k x k) regular, largest columns first. So z has rank k, and for the columns kept, with
 * V_a = [ V1; V2 ]
 *
 *   D = [ 1  0; T^-1 V1  1 ]^T [ Mf_a + V2^T V2  0; 0  T^T T ] [ 1  0; T^-1 V1  1 ]
 *
 * Woodbury's formula for the first of these subtracts large numbers where markers carry much more
 * than modes weigh. With orthonormal rows Q it does not:
 *
 *   V2 R = Z Q,   (Mf_a + V2^T V2)^-1 = R (1 - Q^T Q + Q^T B^-1 Q) R^T,   B = 1 + Z^T Z
 *
 * Rows of V are kept as columns (n x r), zero at modes that have no part in them. Bounds as in
 * rank_pivots.c: with scaled modal masses >= 1 / spread times their diagonal
 *
 *   1 / lambda_kept <= max of spread / (S Mf_a S)  +
 *       ||S_z^-1 T^-1 (1 + V1 (Mf_a + V2^T V2)^-1 V1^T) T^-T S_z^-1|| */
#include "recursion/flexible_factors.h"

#include "algebra/cholesky.h"
#include "algebra/dense.h"
#include "flexible/unit_masses.h"
#include "joints/flexible.h"
#include "recursion/factors_of_modes.h"
#include "recursion/rank.h"

#include <math.h>

/* Below so many modes the block in one piece is as quick. */
enum { LEAST_MODES = 12 };

/* ---- which bodies ---- */

void mbsri_factors_find(mbsr_model *m)
{
    for (int i = 1; i <= m->bodies; ++i) {
        mbsri_body *b = m->body + i;
        b->on.first = b->on.next = 0;
        b->flexible.factored = b->flexible.upright && b->n >= LEAST_MODES && b->group.head == i &&
                               b->group.members == 1 && b->inertia.kind == MBSR_INERTIA_FLEXIBLE &&
                               b->inertia.flex->root;
    }
    for (int i = m->bodies; i >= 1; --i) {
        mbsri_body *b = m->body + i, *pred = m->body + b->parent;
        if (!mbsri_marker_of(b->joint.table, b->joint.user)) {
            pred->flexible.factored = false;
            continue;
        }
        b->on.next = pred->on.first;
        pred->on.first = i;
    }
}

bool mbsri_factors_open(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    if (!d->factors.allowed) return false;
    const bool serves =
        b->flexible.factored && !b->mass.added && mbsri_is_zero((size_t)b->n, b->mass.armature);
    d->factors.rows[i] = serves ? 0 : -1;
    if (!serves) return false;
    const size_t columns = (size_t)MBSRI_FRAME_ROWS * (size_t)b->d;
    mbsri_copy(columns, d->M + b->dd, d->Mbar + b->dd);
    mbsri_zero(columns, d->W + b->dd);
    return true;
}

/* C (d x 6) += (H^T A H) (., 0 .. 5) */
static void add_frame_columns(int d, const double *H, const double A[36], double *C)
{
    double AH[36] = {0.0};
    mbsri_ab(MBSRI_FRAME_ROWS, MBSRI_FRAME_ROWS, MBSRI_FRAME_ROWS, 1.0, A, H, AH);
    mbsri_atb(MBSRI_FRAME_ROWS, d, MBSRI_FRAME_ROWS, 1.0, H, AH, C);
}

void mbsri_factors_take(const mbsr_model *m, mbsr_data *d, int i, const double T[36],
                        const double E[36])
{
    const mbsri_body *b = m->body + i;
    const double *H = d->H + b->dp;
    mbsri_copy(36, T, d->Mbar + b->dd);
    mbsri_copy(36, E, d->W + b->dd);
    if (!mbsri_is_zero(36, T)) add_frame_columns(b->pred.d, H, T, d->Mbar + b->pred.dd);
    if (!mbsri_is_zero(36, E)) add_frame_columns(b->pred.d, H, E, d->W + b->pred.dd);
}

/* ---- solving ---- */

/* x (r) <- L^-T x for B = L L^T */
static void divide_back(const mbsri_factors *f, double *x)
{
    const int r = f->others;
    for (int k = r - 1; k >= 0; --k) {
        for (int l = k + 1; l < r; ++l) x[k] -= f->B[k * r + l] * x[l];
        x[k] /= f->B[k * (r + 1)];
    }
}

/* A right-hand side on its way: D^- = F F^T, F^T b = (y, x - Q c, c). */
typedef struct solving {
    double *x;         /* n: R^T b - V1 y, orthogonal to Q */
    double *y, *along; /* T^-T b, and L^-1 Q^T x */
} solving;

static void go_down(const mbsri_factors *f, const double *b, const solving *s)
{
    const int n = f->n, r = f->others;
    mbsri_flex_to_unit_masses(f->flex, 1, b, s->x);
    mbsri_zero((size_t)f->kept, s->y);
    mbsri_atx_long(n, f->kept, 1.0, f->T, b, s->y);
    mbsri_ax_long(n, f->kept, -1.0, f->V1, s->y, s->x);
    mbsri_zero((size_t)r, s->along);
    for (int turn = 0; turn < 2; ++turn) { /* what rounding leaves along Q would move the loads */
        double part[MBSR_MAX_D] = {0.0};
        mbsri_atx_long(n, r, 1.0, f->Q, s->x, part);
        mbsri_ax_long(n, r, -1.0, f->Q, part, s->x);
        for (int k = 0; k < r; ++k) s->along[k] += part[k];
    }
    mbsri_divide_by_cholesky(1, f->others, f->B, s->along);
}

/* x (n) = F s; what s holds is lost. */
static void go_up(const mbsri_factors *f, const solving *s, double *x)
{
    const int n = f->n;
    divide_back(f, s->along);
    mbsri_ax_long(n, f->others, 1.0, f->Q, s->along, s->x);
    mbsri_atx_long(n, f->kept, -1.0, f->V1, s->x, s->y);
    mbsri_flex_from_unit_masses(f->flex, s->x, x);
    mbsri_ax_long(n, f->kept, 1.0, f->T, s->y, x);
}

static solving room_for(const mbsri_factors *f, double *work)
{
    solving s = {.x = work};
    s.y = s.x + f->n, s.along = s.y + f->kept;
    return s;
}

void mbsri_factors_solve(const mbsr_model *m, mbsr_data *d, int i, const double *b, double *x)
{
    const mbsri_factors f = mbsri_factors_of(m, d, i);
    const mbsri_group g = mbsri_group_of(m, d, i);
    double *rest = mbsri_factors_work(m, d);
    const solving s = room_for(&f, rest + f.n);
    if (d->rank[i] == f.n) {
        go_down(&f, b, &s);
        go_up(&f, &s, x);
        return;
    }
    mbsri_null_force(m, d, &g, b, rest);
    for (int k = 0; k < f.n; ++k) rest[k] = b[k] - rest[k];
    go_down(&f, rest, &s);
    go_up(&f, &s, x);
    mbsri_null_part(m, d, &g, x, rest);
    for (int k = 0; k < f.n; ++k) x[k] -= rest[k];
}

void mbsri_factors_multiply(const mbsr_model *m, const mbsr_data *d, int i, const double *u,
                            double *y)
{
    const mbsri_factors f = mbsri_factors_of(m, d, i);
    double *part = mbsri_factors_work(m, d);
    mbsri_ax_long(f.n, f.n, 1.0, f.flex->Mf, u, y);
    mbsri_zero((size_t)f.rows, part);
    mbsri_atx_long(f.n, f.rows, 1.0, f.V, u, part);
    mbsri_ax_long(f.n, f.rows, 1.0, f.V, part, y);
}

void mbsri_factors_see(const mbsr_model *m, const mbsr_data *d, int i, double factor,
                       const double a[6], double *y)
{
    const mbsri_body *b = m->body + i;
    for (int k = 0; k < MBSRI_FRAME_ROWS; ++k)
        mbsri_ax(b->n, 1, -factor * a[k], d->Mbar + b->dd + k * b->d + MBSRI_FRAME_ROWS,
                 &(double){1.0}, y);
}

void mbsri_factors_load(const mbsr_model *m, mbsr_data *d, int i, double *e, double *sum)
{
    const mbsri_body *b = m->body + i;
    const mbsri_group g = mbsri_group_of(m, d, i);
    const int n = b->n;
    double *modes = sum + MBSRI_FRAME_ROWS, x[MBSR_MAX_D];
    for (int k = 0; k < n; ++k) e[k] += modes[k];
    mbsri_factors_solve(m, d, i, e, x);
    for (int k = 0; k < MBSRI_FRAME_ROWS; ++k)
        sum[k] -= mbsri_dot(n, d->Mbar + b->dd + k * b->d + MBSRI_FRAME_ROWS, x);
    /* - D D^+ e */
    for (int k = 0; k < n; ++k) modes[k] -= e[k];
    if (d->rank[i] == n) return;
    mbsri_null_force(m, d, &g, e, x);
    for (int k = 0; k < n; ++k) modes[k] += x[k];
}

/* ---- to the predecessor ---- */

/* E -= Q G^T + G Q^T - G W_s G^T  with Q = -W (frame, modes), W_s = Diag(D) + sum of H^T E H, and
 * the errors of D itself (backward.c); G: n x 6. */
static void reduce_errors(const mbsr_model *m, const mbsr_data *d, int i, const mbsri_factors *f,
                          const double *G, double E[36])
{
    const mbsri_body *b = m->body + i;
    const int n = f->n;
    const bool deficient = d->rank[i] < n;
    const double *s = d->s + b->group.iu, lambda = d->lambda[b->group.iu];
    for (int j = 0; j < MBSRI_FRAME_ROWS; ++j) {
        for (int k = 0; k < MBSRI_FRAME_ROWS; ++k) {
            const double *g = G + k * n, *W = d->W + b->dd + j * b->d + MBSRI_FRAME_ROWS;
            const double part = mbsri_dot(n, W, g);
            E[6 * j + k] += part, E[6 * k + j] += part;
            for (int a = 0; a < n; ++a) E[6 * j + k] += G[j * n + a] * f->diagonal[a] * g[a];
        }
        for (int a = 0; a < n; ++a) {
            const double own = f->diagonal[a];
            E[7 * j] +=
                G[j * n + a] * G[j * n + a] * (deficient ? fmax(own, lambda / (s[a] * s[a])) : own);
        }
    }
    for (int k = b->on.first; k > 0; k = m->body[k].on.next) {
        const double *own = d->W + m->body[k].dd,
                     *H = d->H + m->body[k].dp + MBSRI_FRAME_ROWS * MBSRI_FRAME_ROWS;
        double P[36] = {0.0}, T[36];
        if (mbsri_is_zero(36, own)) continue;
        mbsri_ab(MBSRI_FRAME_ROWS, n, MBSRI_FRAME_ROWS, 1.0, H, G, P);
        mbsri_congruence(MBSRI_FRAME_ROWS, MBSRI_FRAME_ROWS, P, own, E, T);
    }
    mbsri_symmetrise(MBSRI_FRAME_ROWS, E);
}

void mbsri_factors_reduce(const mbsr_model *m, mbsr_data *d, int i, double T[36], double E[36])
{
    const mbsri_body *b = m->body + i;
    const mbsri_factors f = mbsri_factors_of(m, d, i);
    const int n = f.n, size = n + f.rows;
    double *G = mbsri_factors_work(m, d), *down = G + MBSRI_FRAME_ROWS * n;
    const mbsri_group g = mbsri_group_of(m, d, i);
    mbsri_upper(MBSRI_FRAME_ROWS, b->d, MBSRI_FRAME_ROWS, d->Mbar + b->dd, T);
    mbsri_upper(MBSRI_FRAME_ROWS, b->d, MBSRI_FRAME_ROWS, d->W + b->dd, E);
    for (int j = 0; j < MBSRI_FRAME_ROWS; ++j) {
        E[7 * j] += d->Mbar[b->dd + (size_t)(j * (b->d + 1))];
        const solving s = room_for(&f, down + j * size);
        const double *column = d->Mbar + b->dd + j * b->d + MBSRI_FRAME_ROWS;
        go_down(&f, column, &s);
    }
    mbsri_atb(size, MBSRI_FRAME_ROWS, MBSRI_FRAME_ROWS, -1.0, down, down, T);
    for (int j = 0; j < MBSRI_FRAME_ROWS; ++j) {
        const solving s = room_for(&f, down + j * size);
        double *x = G + j * n, *null = down + MBSRI_FRAME_ROWS * size;
        go_up(&f, &s, x);
        for (int k = 0; k < n; ++k) x[k] = -x[k];
        if (d->rank[i] == n) continue;
        mbsri_null_part(m, d, &g, x, null);
        for (int k = 0; k < n; ++k) x[k] -= null[k];
    }
    reduce_errors(m, d, i, &f, G, E);
}

/* ---- elimination ---- */

/* Mbar and W in one piece again. */
static void make_whole(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const size_t dd = (size_t)b->d * (size_t)b->d;
    d->factors.rows[i] = -1;
    mbsri_copy(dd, d->M + b->dd, d->Mbar + b->dd);
    mbsri_zero(dd, d->W + b->dd);
    for (int k = b->on.first; k > 0; k = m->body[k].on.next) {
        const mbsri_body *marker = m->body + k;
        const double *H = d->H + marker->dp;
        mbsri_congruence(MBSRI_FRAME_ROWS, b->d, H, d->Mbar + marker->dd, d->Mbar + b->dd,
                         d->scratch);
        mbsri_congruence(MBSRI_FRAME_ROWS, b->d, H, d->W + marker->dd, d->W + b->dd, d->scratch);
    }
}

bool mbsri_factors_eliminate(const mbsr_model *m, mbsr_data *d, int i)
{
    if (mbsri_factors_find_rank(m, d, i)) return true;
    make_whole(m, d, i);
    return false;
}

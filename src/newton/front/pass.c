/* How a front passes its body: see pass.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Column by column, with the sizes of bodies in space and in the plane known to the compiler. */
#include "newton/front/pass.h"

#include "algebra/dense.h"
#include "base/inlined.h"
#include "newton/linear/groups.h"

#include <math.h>

enum { MOST = 6 }; /* of d where it is known */

/* Sizes of a step. `fixed`: all are known to the compiler; `plain`: nothing reads x but y. */
typedef struct sizes {
    int d, dp;
    bool below_massless, above, fixed, plain;
} sizes;

/* Where things stand in the front; -1: it has none. */
typedef struct passing {
    mbsri_front_build *b;
    double c;
    int motion;       /* the first column of x */
    int first, reach; /* the rows that read x: the first, how many */
    int y, place, a, react, momentum, rate, tau, push, kappa, below, kappa_below;
    double H[MOST * MOST], Hdot[MOST * MOST]; /* transposed, where sizes are known */
} passing;

static double *M_at(const mbsri_front_build *b, int row, int column)
{
    return b->M + (size_t)column * (size_t)b->all_rows + row;
}

static double *N_at(const mbsri_front_build *b, int row, int column)
{
    return b->N + (size_t)column * (size_t)b->all_rows + row;
}

static int variables(const mbsri_front_build *b)
{
    return mbsri_linear_motions(b->f->linear, b->b->parent) + b->b->nq + b->b->n;
}

/* ---- one column ---- */

/* Column += factor X, with the sizes of that. */
static void add_motion(const passing *p, double factor, const double *X, int count, int first,
                       double *to, double *sum)
{
    const size_t stride = (size_t)p->b->all_rows;
    const double *from = M_at(p->b, p->first, p->motion + first);
    to += p->first;
    for (int l = 0; l < count; ++l, from += stride) {
        const double x = factor * X[l], size = fabs(x);
        if (x == 0.0) continue;
        for (int r = 0; r < p->reach; ++r) to[r] += x * from[r];
        for (int r = 0; r < p->reach && sum; ++r) sum[p->first + r] += size * fabs(from[r]);
    }
}

/* The same where only y reads x: the column is zero before. */
MBSRI_INLINE void take_motion(const passing *p, const int rows, double factor, const double *X,
                              int count, int first, double *restrict y)
{
    const size_t stride = (size_t)p->b->all_rows;
    const double *from = M_at(p->b, p->y, p->motion + first);
    double t[3 * MOST];
    for (int r = 0; r < rows; ++r) t[r] = 0.0;
    for (int l = 0; l < count; ++l, from += stride) {
        const double x = factor * X[l];
        if (x == 0.0) continue;
        for (int r = 0; r < rows; ++r) t[r] += x * from[r];
    }
    for (int r = 0; r < rows; ++r) y[r] = t[r];
}

/* And its sizes. */
MBSRI_INLINE void take_motion_sizes(const passing *p, const int rows, double factor,
                                    const double *X, int count, int first, double *restrict sum)
{
    const size_t stride = (size_t)p->b->all_rows;
    const double *from = M_at(p->b, p->y, p->motion + first);
    double t[3 * MOST];
    for (int r = 0; r < rows; ++r) t[r] = 0.0;
    for (int l = 0; l < count; ++l, from += stride) {
        const double x = fabs(factor * X[l]);
        if (x == 0.0) continue;
        for (int r = 0; r < rows; ++r) t[r] += x * fabs(from[r]);
    }
    for (int r = 0; r < rows; ++r) sum[r] = t[r];
}

MBSRI_INLINE void move(const passing *p, const sizes s, double factor, const double *X, int count,
                       int first, double *M, double *N)
{
    const int rows = (s.below_massless ? 3 : 2) * s.d;
    if (!s.plain || !s.fixed) {
        add_motion(p, factor, X, count, first, M, N);
        return;
    }
    take_motion(p, rows, factor, X, count, first, M + p->y);
    if (N) take_motion_sizes(p, rows, factor, X, count, first, N + p->y);
}

/* out (dp) -= H^T y + A^T z; A: or NULL. */
MBSRI_INLINE void subtract_turned(const int d, const int dp, const double *H, const double *y,
                                  const double *A, const double *z, double *restrict out)
{
    double t[MOST];
    for (int k = 0; k < dp; ++k) t[k] = out[k];
    for (int l = 0; l < d; ++l) {
        for (int k = 0; k < dp; ++k) t[k] -= H[l * dp + k] * y[l];
    }
    for (int l = 0; l < d && A; ++l) {
        for (int k = 0; k < dp; ++k) t[k] -= A[l * dp + k] * z[l];
    }
    for (int k = 0; k < dp; ++k) out[k] = t[k];
}

/* y_pi += B y */
MBSRI_INLINE void hand_down(const passing *p, const sizes s, const double *y, double *below)
{
    if (!s.fixed) {
        mbsri_linear_pass(p->b->b, &p->b->terms, s.above, y, below);
        return;
    }
    subtract_turned(s.d, s.dp, p->H, y, NULL, NULL, below);
    subtract_turned(s.d, s.dp, p->H, y + s.d, p->Hdot, y, below + s.dp);
    if (s.above) subtract_turned(s.d, s.dp, p->H, y + 2 * s.d, NULL, NULL, below + 2 * s.dp);
}

/* The size of what eta moves an axis by, by the lengths of moment and force: 0 where it is about as
 * large. */
MBSRI_INLINE double lost_push(const double *J, const double *kappa, double push, double moved)
{
    static const double much = 1e-10;
    const double turn = fabs(J[0]) + fabs(J[1]) + fabs(J[2]),
                 slide = fabs(J[3]) + fabs(J[4]) + fabs(J[5]),
                 size = turn * kappa[0] + slide * kappa[3] + fabs(push);
    return fabs(moved) < much * size ? size : 0.0;
}

/* What eta makes of the joint's places, and of the loads above: nothing in most columns. */
MBSRI_INLINE void push_places(const passing *p, const sizes s, double *M, double *N)
{
    const mbsri_front_build *b = p->b;
    const mbsri_terms *k = &b->terms;
    const int d = s.d, n = b->b->n, nq = b->b->nq;
    const double *kappa = M + p->kappa, *push = M + p->push,
                 *qdot = k->qdot + (size_t)((variables(b) - n) * nq);
    const bool measured = N && b->watched && d == 6;
    bool none = true;
    for (int l = 0; l < d; ++l) none = none && kappa[l] == 0.0;
    for (int l = 0; l < n; ++l) none = none && push[l] == 0.0;
    if (none) return;
    for (int l = 0; l < n; ++l) {
        const double weight = b->f->model->typical.weight[b->b->iu + l],
                     load = push[l] - mbsri_dot(d, k->J + l * d, kappa), moved = weight * load;
        for (int r = 0; r < nq && moved != 0.0; ++r) M[p->place + r] -= qdot[l * nq + r] * moved;
        if (!measured) continue;
        const double lost = weight * lost_push(k->J + l * d, N + p->kappa, push[l], load);
        for (int r = 0; r < nq && lost > 0.0; ++r) N[p->place + r] += fabs(qdot[l * nq + r]) * lost;
    }
    if (p->kappa_below >= 0) mbsri_atx(d, b->b->pred.d, -1.0, k->H, kappa, M + p->kappa_below);
}

/* The sizes of what is added up in (a). */
MBSRI_INLINE void add_sizes(const passing *p, const sizes s, double *N)
{
    const mbsri_terms *k = &p->b->terms;
    const int d = s.d, n = p->b->b->n;
    const double *y = N + p->y, size = fabs(p->c);
    double *a = N + p->a;
    for (int r = 0; r < n; ++r) {
        const double *J = k->J + r * d, *Jdot = k->Jdot + r * d;
        double momentum = 0.0, rate = 0.0;
        for (int l = 0; l < d; ++l) momentum += fabs(J[l]) * y[l];
        for (int l = 0; l < d; ++l) rate += fabs(J[l]) * y[d + l] + fabs(Jdot[l]) * y[l];
        a[r] += size * momentum + rate + (s.plain ? 0.0 : N[p->tau + r]);
    }
    for (int r = 0; r < n && s.below_massless; ++r) {
        const double *J = k->J + r * d;
        double sum = s.plain ? 0.0 : N[p->tau + r];
        for (int l = 0; l < d; ++l) sum += fabs(J[l]) * y[2 * d + l];
        N[p->react + r] += sum;
    }
}

/* Rows of one column, from those of y, tau, push: d(M u), its rate, (b), and what goes to the
 * predecessor. */
MBSRI_INLINE void make_rows(const passing *p, const sizes s, double *M, double *N)
{
    const mbsri_terms *k = &p->b->terms;
    const int d = s.d, n = p->b->b->n;
    const double *y = M + p->y, *tau = s.plain ? y : M + p->tau;
    for (int r = 0; r < n; ++r) {
        const double *J = k->J + r * d, *Jdot = k->Jdot + r * d;
        double momentum = 0.0, rate = s.plain ? 0.0 : tau[r];
        for (int l = 0; l < d; ++l) momentum += J[l] * y[l];
        for (int l = 0; l < d; ++l) rate += J[l] * y[d + l] + Jdot[l] * y[l];
        M[p->momentum + r] = momentum;
        M[p->rate + r] = rate;
    }
    for (int r = 0; r < n && s.below_massless; ++r) {
        double react = s.plain ? 0.0 : -tau[r];
        for (int l = 0; l < d; ++l) react += k->J[r * d + l] * y[2 * d + l];
        M[p->react + r] += react;
    }
    if (N) add_sizes(p, s, N);
    if (p->below >= 0) hand_down(p, s, y, M + p->below);
    if (p->kappa >= 0) push_places(p, s, M, N);
}

/* (a) of a column. */
MBSRI_INLINE void combine(const passing *p, double *M)
{
    for (int r = 0; r < p->b->b->n; ++r) M[p->a + r] += p->c * M[p->momentum + r] - M[p->rate + r];
}

/* What the joint's equations have of number l of z with y held. */
MBSRI_INLINE void add_slopes(const passing *p, const sizes s, int l, double *M, double *N)
{
    const mbsri_terms *k = &p->b->terms;
    const int n = p->b->b->n, nq = p->b->b->nq, rows = (s.below_massless ? 3 : 2) * n,
              actions = (s.above ? 3 : 2) * s.dp;
    const double *own = k->own + l * rows, *below = k->below + l * actions,
                 *qdot = k->qdot + l * nq;
    for (int r = 0; r < n; ++r) {
        M[p->momentum + r] += own[r];
        M[p->rate + r] += own[n + r];
        if (s.below_massless) M[p->react + r] += own[2 * n + r];
        if (N) N[p->a + r] += fabs(p->c * own[r]) + fabs(own[n + r]);
        if (N && s.below_massless) N[p->react + r] += fabs(own[2 * n + r]);
    }
    for (int r = 0; r < nq; ++r) {
        M[p->place + r] -= qdot[r];
        if (N) N[p->place + r] += fabs(qdot[r]);
    }
    if (p->below < 0) return;
    for (int r = 0; r < actions; ++r) M[p->below + r] += below[r];
}

/* ---- all columns ---- */

static double *sums(const mbsri_front_build *b, int column)
{
    const bool measured = b->watched || column < b->size || column >= b->columns;
    return measured ? N_at(b, 0, column) : NULL;
}

/* Columns of numbers first .. first + count - 1 of z, which stand from `column` on. */
MBSRI_INLINE void pass_z(const passing *p, const sizes s, int first, int count, int column)
{
    const mbsri_front_build *b = p->b;
    const int x = mbsri_linear_motions(b->f->linear, b->i);
    for (int l = 0; l < count; ++l) {
        double *M = M_at(b, 0, column + l), *N = sums(b, column + l);
        move(p, s, 1.0, b->terms.x + (first + l) * x, x, 0, M, N);
        make_rows(p, s, M, N);
        add_slopes(p, s, first + l, M, N);
        combine(p, M);
    }
}

/* Those of u': -J of the acceleration, and the armature. */
MBSRI_INLINE void pass_rates(const passing *p, const sizes s)
{
    const mbsri_front_build *b = p->b;
    const int column = b->f->columns.at[b->at.rates], first = b->f->linear->e[b->i] + s.d;
    for (int l = 0; l < b->b->n; ++l) {
        double *M = M_at(b, 0, column + l), *N = sums(b, column + l);
        move(p, s, -1.0, b->terms.J + l * s.d, s.d, first, M, N);
        make_rows(p, s, M, N);
        combine(p, M);
        M[p->react + l] += b->b->mass.armature[l];
        if (N) N[p->react + l] += b->b->mass.armature[l];
    }
}

static bool is_among(int number, int first, int count)
{
    return number >= first && number < first + count;
}

/* Columns of what is carried, of other bodies and of joints of a group. */
MBSRI_INLINE void pass_others(const passing *p, const sizes s)
{
    const mbsri_front_build *b = p->b;
    const int above = b->f->names[b->b->parent].x, parent = b->b->parent;
    for (int j = b->own; j < b->all_columns; ++j) {
        const int number = b->column[j];
        if (parent > 0 && is_among(number, above, mbsri_linear_motions(b->f->linear, parent)))
            continue;
        if (is_among(number, b->at.x, mbsri_linear_motions(b->f->linear, b->i)) ||
            is_among(number, b->at.rates, b->b->n))
            continue;
        make_rows(p, s, M_at(b, 0, j), sums(b, j));
        combine(p, M_at(b, 0, j));
    }
}

MBSRI_INLINE void pass_all(passing *p, const sizes s)
{
    const mbsri_front_build *b = p->b;
    const mbsri_front *f = b->f;
    const int parent = b->b->parent, n = b->b->n, nq = b->b->nq,
              motions = mbsri_linear_motions(f->linear, parent);
    for (int l = 0; l < s.d && s.fixed; ++l) {
        for (int k = 0; k < s.dp; ++k) {
            p->H[l * s.dp + k] = b->terms.H[k * s.d + l];
            p->Hdot[l * s.dp + k] = b->terms.Hdot[k * s.d + l];
        }
    }
    pass_z(p, s, motions, nq + n, 0); /* dq, du: the first columns */
    for (int l = 0; l < nq; ++l) {
        *M_at(b, p->place + l, l) += p->c;
        *N_at(b, p->place + l, l) += fabs(p->c);
    }
    if (parent > 0) pass_z(p, s, 0, motions, f->columns.at[f->names[parent].x]);
    if (s.below_massless) pass_rates(p, s);
    if (!s.plain) pass_others(p, s);
}

/* ---- the range of D ---- */

/* u' = S X a */
static void take_range_columns(mbsri_front_build *b, mbsri_group g)
{
    const mbsri_front *f = b->f;
    const mbsri_terms *k = &b->terms;
    for (int r = 0; r < f->linear->rank[b->i]; ++r) {
        double *M = M_at(b, 0, f->columns.at[b->at.range + r]),
               *N = N_at(b, 0, f->columns.at[b->at.range + r]);
        for (int l = 0; l < g.members; ++l) {
            const mbsri_body *of = f->model->body + g.member[l];
            for (int j = 0; j < of->n; ++j) {
                const int at = of->group.iu - b->b->group.iu + j,
                          column = f->columns.at[f->names[g.member[l]].rates + j];
                const double weight = k->X[r * g.n + at] * k->s[at], *from = M_at(b, 0, column),
                             *size = N_at(b, 0, column);
                for (int row = 0; row < b->all_rows; ++row) M[row] += weight * from[row];
                for (int row = 0; row < b->all_rows; ++row) N[row] += fabs(weight) * size[row];
            }
        }
    }
}

/* X^T S (a) of a column; N: or NULL. */
static void take_range_rows(mbsri_front_build *b, mbsri_group g, double *M, double *N)
{
    const mbsri_front *f = b->f;
    const mbsri_terms *k = &b->terms;
    for (int r = 0; r < f->linear->rank[b->i]; ++r) {
        double value = 0.0, size = 0.0;
        for (int l = 0; l < g.members; ++l) {
            const mbsri_body *of = f->model->body + g.member[l];
            for (int j = 0; j < of->n; ++j) {
                const int at = of->group.iu - b->b->group.iu + j,
                          row = f->rows.at[f->names[g.member[l]].a] + j;
                const double weight = k->X[r * g.n + at] * k->s[at];
                value += weight * M[row];
                if (N) size += fabs(weight) * N[row];
            }
        }
        M[f->rows.at[b->at.range_of_a] + r] = value;
        if (N) N[f->rows.at[b->at.range_of_a] + r] = size;
    }
}

static void take_range(mbsri_front_build *b)
{
    const mbsri_front *f = b->f;
    const mbsri_group g = mbsri_linear_group(f->linear, b->i);
    take_range_columns(b, g);
    for (int j = 0; j < b->columns; ++j) take_range_rows(b, g, M_at(b, 0, j), sums(b, j));
}

/* ---- by sizes ---- */

static void pass_space(passing *p)
{
    pass_all(p, (sizes){6, 6, false, false, true, true});
}

static void pass_space_below_massless(passing *p)
{
    pass_all(p, (sizes){6, 6, true, true, true, true});
}

static void pass_space_more(passing *p)
{
    pass_all(p, (sizes){6, 6, false, false, true, false});
}

static void pass_space_below_massless_more(passing *p)
{
    pass_all(p, (sizes){6, 6, true, true, true, false});
}

static void pass_plane(passing *p)
{
    pass_all(p, (sizes){3, 3, false, false, true, true});
}

static void pass_plane_more(passing *p)
{
    pass_all(p, (sizes){3, 3, false, false, true, false});
}

static void pass_any(passing *p, const sizes s)
{
    pass_all(p, (sizes){s.d, s.dp, s.below_massless, s.above, false, s.plain});
}

static void choose_pass(passing *p, const sizes s)
{
    const bool space = s.d == 6 && s.dp == 6, plane = s.d == 3 && s.dp == 3;
    if (space && s.plain && !s.below_massless)
        pass_space(p);
    else if (space && s.plain && s.above)
        pass_space_below_massless(p);
    else if (space && !s.plain && !s.below_massless)
        pass_space_more(p);
    else if (space && !s.plain && s.above)
        pass_space_below_massless_more(p);
    else if (plane && s.plain && !s.below_massless)
        pass_plane(p);
    else if (plane && !s.plain && !s.below_massless)
        pass_plane_more(p);
    else
        pass_any(p, s);
}

/* Each of `count` moments and forces by its largest component: rounding stands in the others. */
static void measure_lengths(int count, double *N)
{
    for (int k = 0; k < 2 * count; ++k, N += 3) {
        const double other = N[1] > N[2] ? N[1] : N[2];
        N[0] = N[1] = N[2] = N[0] > other ? N[0] : other;
    }
}

/* Sizes of what is there before, along the unknowns. */
static void take_sizes(const mbsri_front_build *b)
{
    const mbsri_front *f = b->f;
    const int x = f->columns.at[b->at.x], behind = x + mbsri_linear_motions(f->linear, b->i),
              actions = mbsri_linear_actions(f->linear, b->i) / 6;
    for (int j = 0; j < b->all_columns; ++j) {
        double *N = j < x || j >= behind ? sums(b, j) : NULL;
        const double *M = M_at(b, 0, j);
        for (int r = 0; r < b->all_rows && N; ++r) N[r] = fabs(M[r]);
        if (!N || !b->watched || b->b->d != 6 || b->column[j] < f->columns.count) continue;
        measure_lengths(actions, N + f->rows.at[b->at.y]);
        if (f->model->position_rows > 0 && !b->plain)
            measure_lengths(1, N + f->rows.at[b->at.kappa]);
    }
}

/* What bodies of the border will add to the rates of their own impulses, and with weights that are
 * inverse inertias to the loads of eta, as their masses are. These are sizes of what is to come:
 * beside them multipliers of a body that is passed last are judged, not beside nothing. */
static void expect_masses(const mbsri_front_build *b)
{
    const mbsri_front *f = b->f;
    for (int k = 0; k < b->step->borders; ++k) {
        const int i = f->plan.border[b->step->first_border + k].body, d = f->model->body[i].d,
                  x = mbsri_linear_motions(f->linear, i), y = mbsri_linear_actions(f->linear, i),
                  e = f->linear->e[i], row = f->rows.at[f->names[i].y + d],
                  column = f->columns.at[f->names[i].x];
        const bool has_positions = f->model->position_rows > 0 && !b->plain && e == d;
        const double *P = mbsri_linear_terms(f->linear, i).P;
        for (int l = 0; l < x; ++l, P += y) {
            double *N = N_at(b, row, column + l);
            for (int r = 0; r < d; ++r) N[r] += fabs(f->c * P[r]) + fabs(P[d + r]);
            if (!has_positions || l < e || l >= e + d) continue; /* P over V is the mass */
            N = N_at(b, f->rows.at[f->names[i].kappa], column + l - e);
            for (int r = 0; r < d; ++r) N[r] += fabs(f->c * P[r]);
        }
    }
}

void mbsri_front_pass(mbsri_front_build *b)
{
    const mbsri_front *f = b->f;
    const mbsri_front_names *above = f->names + b->b->parent;
    const bool grounded = b->b->parent == 0,
               has_positions = f->model->position_rows > 0 && !b->plain;
    passing p = {.b = b,
                 .c = f->c,
                 .motion = f->columns.at[b->at.x],
                 .reach = b->all_rows,
                 .y = f->rows.at[b->at.y],
                 .place = f->rows.at[b->at.place],
                 .a = f->rows.at[b->at.a],
                 .react = f->rows.at[b->at.b],
                 .momentum = f->rows.at[b->at.momentum],
                 .rate = f->rows.at[b->at.rate],
                 .tau = b->plain ? -1 : f->rows.at[b->at.tau],
                 .push = f->rows.at[b->at.push],
                 .kappa = has_positions ? f->rows.at[b->at.kappa] : -1,
                 .below = grounded ? -1 : f->rows.at[above->y],
                 .kappa_below = grounded || !has_positions ? -1 : f->rows.at[above->kappa]};
    if (b->plain) p.first = p.y, p.reach = mbsri_linear_actions(f->linear, b->i);
    take_sizes(b);
    choose_pass(&p, (sizes){.d = b->b->d,
                            .dp = b->b->pred.d,
                            .below_massless = b->below_massless,
                            .above = f->linear->below_massless[b->b->parent],
                            .plain = b->plain});
    if (b->closes) take_range(b);
    if (b->watched && f->linear->whole && !f->served && !b->lacks_mass) expect_masses(b);
}

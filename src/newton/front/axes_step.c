/* The step of a body on a sequence of axes: see axes_step.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * This is the Newton step of a hinge, of any number of axes, of a ball and of a free body, on an
 * open tree. All that is known of the body stands in F, y over x: its own momentum, what its
 * successors have left, elements. Column by column of z = (dq, du, x of the predecessor), with
 * y = F X z, the joint makes of it
 *
 *   d(M u) = J^T m,   dP = J^T sigma + J'^T m + tau,   (a) = c d(M u) - dP,   y_pi = B y
 *
 * with the slopes of J and B (newton/slopes/). dq goes first, by q', c dq - d(G u) = r_q, of axes
 * dq = (r_q + du) / c; then du by (a), n rows with their largest entries as pivots. What is left is
 * y over x of the predecessor. A front (assemble.c, pass.c, pivots.c) does the same for anything,
 * and takes over where a pivot is small; solutions read the same factors. The numbers of
 * coordinates and rates are known to the compiler. */
#include "newton/front/axes_step.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/inlined.h"
#include "forces/gravity.h"
#include "joints/chain.h"
#include "model/query.h"
#include "newton/front/crowd.h"
#include "newton/slopes/axes.h"
#include "recursion/elements.h"

#include <math.h>
#include <string.h>

enum { MOST = 6, PLACES = 7, OWN = PLACES + MOST, ROWS = 12, COLUMNS = ROWS + OWN };

/* A pivot beside what was added up in it; below, a front decides. */
static const double good = 1e-3;

/* What is known of the body: y over x, and what elements make of q and u (forces) and of the
 * joint's loads. */
typedef struct knowns {
    double F[ROWS * ROWS];
    double by_joint[OWN][6];      /* forces on the body */
    double tau[ROWS + OWN][MOST]; /* over x, q, u */
    bool moves;                   /* x changes loads, or q and u forces */
} knowns;

/* Columns dq, du, x of the predecessor. */
typedef struct columns {
    double below[COLUMNS][ROWS]; /* y of the predecessor */
    double momentum[COLUMNS][2 * MOST];
    double a[COLUMNS][MOST];
    double size[OWN][MOST];    /* of what was added up in (a), over dq, du */
    double place[OWN][PLACES]; /* q' over dq, du, where it is not u */
} columns;

typedef struct axes_step {
    mbsri_front *f;
    const mbsr_data *d;
    const mbsri_body *b;
    const mbsri_front_step *step;
    mbsri_terms terms;
    double c, r[3], rate[3];
    int outside; /* columns of the predecessor's motion in the slopes */
    bool turns;  /* q' is not u */
    const double *J, *Jdot;
} axes_step;

/* ---- which ---- */

/* Whether the joint is a sequence of axes in space, a ball among them perhaps. */
static bool is_sequence(const mbsri_body *b)
{
    const bool seen = b->pred.space == MBSR_SPACE_SPATIAL || b->pred.space == MBSR_SPACE_FIXED;
    return b->joint.space == MBSR_SPACE_SPATIAL && b->joint.table->tangent == mbsri_chain_tangent &&
           seen && b->n > 0 && b->n <= MOST && b->nq <= PLACES;
}

/* Whether an element of the plan acts on the body alone, between it and the ground, or is a pair
 * apart. */
static bool is_on_body(const mbsri_front *f, int element, int i)
{
    const int *list, forces = (int)f->model->forces.count,
                     pair = element - forces - (int)f->model->closures.count;
    if (element >= forces && pair < 0) return false;
    if (pair >= 0 && f->crowd && f->crowd->apart[pair]) return true;
    const int force = pair < 0 ? element : f->linear->pairs.pair[pair].force,
              count = mbsri_linear_bodies(f->linear, mbsri_force_at(f->model, (size_t)force),
                                          pair < 0 ? i : pair, &list);
    bool on = true;
    for (int j = 0; j < count; ++j) on = on && (list[j] == 0 || list[j] == i);
    return on;
}

bool mbsri_front_may_step(const mbsri_front *f, int k)
{
    const mbsri_front_step *s = f->plan.step + k;
    const mbsri_body *b = f->model->body + s->body;
    bool may =
        !f->served && is_sequence(b) && s->borders <= 1 && b->inertia.kind != MBSR_INERTIA_FUNCTION;
    for (int l = 0; l < s->elements && may; ++l)
        may = is_on_body(f, f->plan.element[s->first_element + l], s->body);
    return may;
}

/* Whether it is at these ranks, with what the steps before have left. */
static bool is_plain(const mbsri_front *f, const mbsri_front_step *s)
{
    const mbsri_linear *w = f->linear;
    bool plain = !w->below_massless[s->body] && !w->coupled[s->body];
    for (int l = 0; l < s->children && plain; ++l)
        plain = f->left[f->plan.child[s->first_child + l]].plain;
    return plain;
}

/* ---- what is known over x ---- */

/* Forces of an element enter the rate of the impulse with -1. A column of one that loads joints: */
static void add_column(const double *from, int n, double *sigma, double *tau)
{
    for (int r = 0; r < 6; ++r) sigma[r] -= from[r];
    for (int r = 0; r < n; ++r) tau[r] += from[6 + r];
}

/* Of one on bodies alone. */
static void add_axis_forces(double *restrict F, const double *restrict from, int stride)
{
    for (int l = 0; l < ROWS; ++l, from += stride) {
        for (int r = 0; r < 6; ++r) F[l * ROWS + 6 + r] -= from[r];
    }
}

/* Of one on joints alone; over q and u. */
static void add_axis_loads(knowns *k, const double *from, int n, int own, int stride)
{
    for (int l = 0; l < own; ++l, from += stride) {
        for (int r = 0; r < n; ++r) k->tau[ROWS + l][r] += from[6 + r];
    }
}

static void add_matrix(knowns *k, const double *from, int n, int own, int stride)
{
    for (int l = 0; l < ROWS; ++l, from += stride) {
        if (mbsri_is_zero((size_t)(6 + n), from)) continue;
        add_column(from, n, k->F + l * ROWS + 6, k->tau[l]);
        k->moves = k->moves || !mbsri_is_zero((size_t)n, from + 6);
    }
    for (int l = 0; l < own; ++l, from += stride) {
        if (mbsri_is_zero((size_t)(6 + n), from)) continue;
        add_column(from, n, k->by_joint[l], k->tau[ROWS + l]);
        k->moves = k->moves || !mbsri_is_zero(6, from);
    }
}

/* Gravity: its moment along a rotation. */
static void add_gravity(const mbsri_force *force, const double *M, double *F)
{
    double moment[9];
    mbsri_gravity_turn(&force->def, M, moment);
    for (int l = 0; l < 3; ++l) {
        for (int r = 0; r < 3; ++r) F[l * ROWS + 6 + r] -= moment[3 * l + r];
    }
}

/* What acts along the coordinates of axes, each by itself. */
static void add_along(const mbsri_linear *w, const mbsri_body *b, knowns *k)
{
    const double *by_q = w->along + b->iu, *by_u = by_q + w->model->nu;
    for (int r = 0; r < b->n; ++r) {
        k->tau[ROWS + r][r] = by_q[r];
        k->tau[ROWS + b->n + r][r] = by_u[r];
    }
}

/* Element `element` in the call of the body or of a pair; apart: of a pair apart, of which what the
 * body feels by its own motion is added. */
static int add_element(mbsri_front *f, mbsr_data *d, int i, int element, int call, bool apart,
                       knowns *k)
{
    const mbsri_force *force = mbsri_force_at(f->model, (size_t)element);
    const bool joint = !(force->def.table->flags & MBSR_FORCE_NO_JOINT),
               alone = (force->def.table->flags & MBSR_FORCE_JOINT_ONLY) != 0;
    const int n = f->model->body[i].n, own = f->model->body[i].nq + n, width = ROWS + own;
    const int *list, count = mbsri_linear_bodies(f->linear, force, call, &list);
    const int status =
        f->linear->whole ? MBSR_OK : mbsri_linear_force(f->linear, d, (size_t)element, call);
    int rows, all;
    if (status) return status;
    const double *matrix = mbsri_linear_element(f->linear, (size_t)element, call, &rows, &all);
    if (apart) {
        mbsri_front_crowd_keep(f, call, i, matrix, rows);
        add_axis_forces(k->F, matrix + mbsri_front_crowd_own(f, call, i, rows), rows);
        return MBSR_OK;
    }
    for (int l = 0, column = 0; l < count; ++l) {
        if (list[l] == 0) continue;
        for (int j = 0, row = 0; j < count; ++j) {
            if (list[j] == 0) continue;
            const double *from = matrix + (size_t)column * (size_t)rows + row;
            if (alone)
                add_axis_loads(k, from + ROWS * (size_t)rows, n, own, rows);
            else if (joint)
                add_matrix(k, from, n, own, rows);
            else
                add_axis_forces(k->F, from, rows);
            row += 6 + n;
        }
        column += width;
    }
    return MBSR_OK;
}

static int know(mbsri_front *f, mbsr_data *d, const axes_step *s, knowns *k)
{
    const int i = s->step->body, own = s->b->nq + s->b->n;
    const bool along = !s->turns && f->linear->finite;
    int status = MBSR_OK;
    k->moves = false;
    memset(k->by_joint, 0, (size_t)own * sizeof k->by_joint[0]);
    memset(k->tau, 0, (size_t)(ROWS + own) * sizeof k->tau[0]);
    if (along) add_along(f->linear, s->b, k);
    memcpy(k->F, s->terms.P, sizeof k->F);
    for (int l = 0; l < s->step->children; ++l) {
        const double *from =
            f->matrices + f->plan.step[f->plan.child[s->step->first_child + l]].matrix;
        for (int r = 0; r < ROWS * ROWS; r += ROWS) mbsri_add_pairs(ROWS / 2, from + r, k->F + r);
    }
    for (int e = 0; e < f->model->elements.anywhere && !status; ++e) {
        const mbsri_force *force = mbsri_force_at(f->model, (size_t)e);
        if (!(force->def.table->flags & MBSR_FORCE_EVERY_BODY)) continue;
        if (!mbsri_is_gravity(&force->def))
            status = add_element(f, d, i, e, i, false, k);
        else if (!mbsri_force_off(f->model, d, force))
            add_gravity(force, d->M + s->b->dd, k->F);
    }
    const int forces = (int)f->model->forces.count, others = (int)mbsri_other_forces(f->model),
              behind = forces + (int)f->model->closures.count;
    for (int l = 0; l < s->step->elements && !status; ++l) {
        const int e = f->plan.element[s->step->first_element + l], pair = e - behind;
        if (along && e >= others && e < forces) continue;
        if (pair < 0)
            status = add_element(f, d, i, e, i, false, k);
        else
            status = add_element(f, d, i, f->linear->pairs.pair[pair].force, pair,
                                 f->crowd && f->crowd->apart[pair], k);
    }
    return status;
}

/* ---- columns ---- */

/* y += F x of columns first .. first + count - 1 */
MBSRI_INLINE void add_product(const double *F, const double *x, const int first, const int count,
                              double y[ROWS])
{
    mbsri_add_columns(ROWS / 2, count, 1.0, F + first * ROWS, x + first, y);
}

static double size6(const double *a, const double *b)
{
    return fabs(a[0]) * b[0] + fabs(a[1]) * b[1] + fabs(a[2]) * b[2] + fabs(a[3]) * b[3] +
           fabs(a[4]) * b[4] + fabs(a[5]) * b[5];
}

/* y (3) += a x b */
static void add_cross(const double a[3], const double b[3], double y[3])
{
    y[0] += a[1] * b[2] - a[2] * b[1];
    y[1] += a[2] * b[0] - a[0] * b[2];
    y[2] += a[0] * b[1] - a[1] * b[0];
}

/* What the joint makes of y of column j, and of its own slopes along number l of z. */
MBSRI_INLINE void make_column(const axes_step *s, const int n, const double y[ROWS], int l, int j,
                              const double *tau, columns *z)
{
    const double *own = s->terms.own + l * 2 * n, *slope = s->terms.below + l * ROWS;
    double *below = z->below[j], *momentum = z->momentum[j];
    for (int r = 0; r < n; ++r) {
        const double *J = s->J + 6 * r, *Jdot = s->Jdot + 6 * r;
        momentum[r] = mbsri_dot_six(J, y) + own[r];
        momentum[n + r] = mbsri_dot_six(J, y + 6) + mbsri_dot_six(Jdot, y) + own[n + r] + tau[r];
        z->a[j][r] = s->c * momentum[r] - momentum[n + r];
    }
    if (s->step->borders == 0) return;
    memcpy(below, y, ROWS * sizeof *below);
    mbsri_add_pairs(ROWS / 2, slope, below);
    add_cross(s->r, y + 3, below);
    add_cross(s->r, y + 9, below + 6);
    add_cross(s->rate, y + 3, below + 6);
}

/* And the sizes of what is added up in (a). */
MBSRI_INLINE void size_column(const axes_step *s, const int n, const double y[ROWS], int l, int j,
                              const double *tau, columns *z)
{
    const double *own = s->terms.own + l * 2 * n, c = fabs(s->c);
    for (int r = 0; r < n; ++r) {
        const double *J = s->J + 6 * r, *Jdot = s->Jdot + 6 * r;
        z->size[j][r] = c * (size6(J, y) + fabs(own[r])) + size6(J, y + 6) + size6(Jdot, y) +
                        fabs(own[n + r]) + fabs(tau[r]);
    }
}

/* Loads over number l of z: tau X; x has parts first .. first + count - 1. */
static void take_loads(const knowns *k, int n, const double *x, int first, int count, double *tau)
{
    for (int l = first; l < first + count; ++l) {
        for (int r = 0; r < n; ++r) tau[r] += x[l] * k->tau[l][r];
    }
}

/* dq and du. */
MBSRI_INLINE void pass_own(const axes_step *s, const int nq, const int n, const knowns *k,
                           columns *z)
{
    for (int j = 0; j < nq + n; ++j) {
        const int first = j < nq ? 0 : 6, count = j < nq ? ROWS : 6;
        const double *x = s->terms.x + (s->outside + j) * ROWS;
        double y[ROWS] = {0.0}, size[ROWS] = {0.0}, tau[MOST];
        add_product(k->F, x, first, count, y);
        mbsri_add_sizes(ROWS / 2, count, k->F + first * ROWS, x + first, size);
        memcpy(tau, k->tau[ROWS + j], sizeof tau);
        if (k->moves) {
            take_loads(k, n, x, first, count, tau);
            for (int r = 0; r < 6; ++r) y[6 + r] += k->by_joint[j][r];
            for (int r = 0; r < 6; ++r) size[6 + r] += fabs(k->by_joint[j][r]);
        }
        make_column(s, n, y, s->outside + j, j, tau, z);
        size_column(s, n, size, s->outside + j, j, tau, z);
    }
}

/* The motion of the predecessor: its rotation moves all, its other parts what they are. */
MBSRI_INLINE void pass_others(const axes_step *s, const int own, const int n, const knowns *k,
                              columns *z)
{
    for (int l = 0; l < ROWS; ++l) {
        const double *x = s->terms.x + l * ROWS;
        double y[ROWS], tau[MOST] = {0.0};
        memcpy(y, k->F + l * ROWS, sizeof y);
        if (l < 3) add_product(k->F, x, 3, 9, y);
        if (l >= 6 && l < 9) add_product(k->F, x, 9, 3, y);
        if (k->moves) take_loads(k, n, x, 0, ROWS, tau);
        make_column(s, n, y, l, own + l, tau, z);
    }
}

/* ---- elimination ---- */

/* What was eliminated: q' place[p] and dq p-th, then (a) row[p] and du column[p]; factors of the
 * rows of (a) and of y below. */
typedef struct pivots {
    int place[PLACES], row[MOST], column[MOST];
    double L[MOST][MOST];
    double row_scale[MOST], column_scale[MOST];
} pivots;

/* dq = (r_q + du) / c */
MBSRI_INLINE void eliminate_axes(const axes_step *s, const int n, const int others, columns *z)
{
    const double by = 1.0 / s->c, size = fabs(by);
    for (int k = 0; k < n; ++k) {
        for (int r = 0; r < n; ++r) {
            z->a[k][r] *= by;
            z->a[n + k][r] += z->a[k][r];
            z->size[n + k][r] += size * z->size[k][r];
        }
        for (int r = 0; r < others; ++r) z->below[k][r] *= by;
        for (int r = 0; r < others; ++r) z->below[n + k][r] += z->below[k][r];
    }
}

/* q' over dq and du. */
MBSRI_INLINE void take_rates(const axes_step *s, const int nq, const int n, columns *z)
{
    const double *qdot = s->terms.qdot + s->outside * nq;
    for (int j = 0; j < nq + n; ++j) {
        for (int r = 0; r < nq; ++r) z->place[j][r] = -qdot[j * nq + r];
        if (j < nq) z->place[j][j] += s->c;
    }
}

/* The largest row of dq k first; false: it is not good beside c. */
MBSRI_INLINE bool choose_place(const axes_step *s, const int nq, const int n, int k, columns *z,
                               pivots *p)
{
    int row = k;
    for (int r = k + 1; r < nq; ++r)
        if (fabs(z->place[k][r]) > fabs(z->place[k][row])) row = r;
    for (int j = 0; j < nq + n && row != k; ++j) {
        const double other = z->place[j][row];
        z->place[j][row] = z->place[j][k];
        z->place[j][k] = other;
    }
    const int first = p->place[k];
    p->place[k] = p->place[row];
    p->place[row] = first;
    return fabs(z->place[k][k]) > good * fabs(s->c);
}

/* dq by q' */
MBSRI_INLINE bool eliminate_turns(const axes_step *s, const int nq, const int n, const int others,
                                  columns *z, pivots *p)
{
    take_rates(s, nq, n, z);
    for (int k = 0; k < nq; ++k) {
        if (!choose_place(s, nq, n, k, z, p)) return false;
        const double by = 1.0 / z->place[k][k];
        for (int r = k + 1; r < nq; ++r) z->place[k][r] *= by;
        for (int r = 0; r < n; ++r) z->a[k][r] *= by, z->size[k][r] *= fabs(by);
        for (int r = 0; r < others; ++r) z->below[k][r] *= by;
        for (int j = k + 1; j < nq + n; ++j) {
            const double x = z->place[j][k];
            if (x == 0.0) continue;
            for (int r = k + 1; r < nq; ++r) z->place[j][r] -= z->place[k][r] * x;
            for (int r = 0; r < n; ++r) z->a[j][r] -= z->a[k][r] * x;
            for (int r = 0; r < n; ++r) z->size[j][r] += z->size[k][r] * fabs(x);
            for (int r = 0; r < others; ++r) z->below[j][r] -= z->below[k][r] * x;
        }
    }
    return true;
}

/* Scales by the sizes along du, `nq` columns on. */
MBSRI_INLINE void scale(const int nq, const int n, const columns *z, pivots *p)
{
    for (int r = 0; r < n; ++r) {
        double most = 0.0;
        for (int k = 0; k < n; ++k) most = fmax(most, z->size[nq + k][r]);
        p->row_scale[r] = most > 0.0 ? 1.0 / most : 0.0;
    }
    for (int k = 0; k < n; ++k) {
        double most = 0.0;
        for (int r = 0; r < n; ++r) most = fmax(most, z->size[nq + k][r] * p->row_scale[r]);
        p->column_scale[k] = most > 0.0 ? 1.0 / most : 0.0;
    }
}

/* The largest of what is left, first; false: it is not good. */
MBSRI_INLINE bool choose(const int nq, const int n, const columns *z, pivots *p, const int q)
{
    double most = 0.0;
    int row = q, column = q;
    for (int k = q; k < n; ++k) {
        for (int r = q; r < n; ++r) {
            const double size = fabs(z->a[nq + p->column[k]][p->row[r]]) * p->row_scale[p->row[r]] *
                                p->column_scale[p->column[k]];
            if (!(size > most)) continue;
            most = size;
            row = r;
            column = k;
        }
    }
    const int first_row = p->row[q], first_column = p->column[q];
    p->row[q] = p->row[row];
    p->row[row] = first_row;
    p->column[q] = p->column[column];
    p->column[column] = first_column;
    return most > good;
}

MBSRI_INLINE bool eliminate(const axes_step *s, const bool turns, const int nq, const int n,
                            const int others, columns *z, pivots *p)
{
    for (int k = 0; k < nq; ++k) p->place[k] = k;
    for (int k = 0; k < n; ++k) p->row[k] = p->column[k] = k;
    if (!turns)
        eliminate_axes(s, n, others, z);
    else if (!eliminate_turns(s, nq, n, others, z, p))
        return false;
    scale(nq, n, z, p);
    for (int q = 0; q < n; ++q) {
        if (!choose(nq, n, z, p, q)) return false;
        const int row = p->row[q], column = nq + p->column[q];
        double *factor = z->below[column];
        const double by = 1.0 / z->a[column][row];
        for (int r = q + 1; r < n; ++r) p->L[q][p->row[r]] = z->a[column][p->row[r]] * by;
        for (int r = 0; r < others; ++r) factor[r] *= by;
        for (int k = q + 1; k < n + others; ++k) {
            const int j = nq + (k < n ? p->column[k] : k);
            const double x = z->a[j][row];
            for (int r = q + 1; r < n; ++r) z->a[j][p->row[r]] -= p->L[q][p->row[r]] * x;
            for (int r = 0; r < others; ++r) z->below[j][r] -= factor[r] * x;
        }
    }
    return true;
}

/* ---- what is kept ---- */

static void keep_numbers(const axes_step *s, int nq, int n, int others, const pivots *p)
{
    const mbsri_front *f = s->f;
    const mbsri_front_names *at = f->names + s->step->body, *above = f->names + s->b->parent;
    const int own = nq + n;
    int *row = f->numbers + s->step->numbers, *column = row + own + others;
    for (int k = 0; k < nq; ++k) {
        row[k] = at->place + p->place[k];
        column[k] = at->q + k;
    }
    for (int k = 0; k < n; ++k) {
        row[nq + k] = at->a + p->row[k];
        column[nq + k] = at->u + p->column[k];
    }
    for (int k = 0; k < others; ++k) {
        row[own + k] = above->y + k;
        column[own + k] = above->x + k;
    }
}

/* Column of L and row of U of dq k, of axes and else. */
MBSRI_INLINE void keep_axis(const axes_step *s, const int n, int k, const pivots *p, double *L,
                            double *U)
{
    for (int r = 0; r < n; ++r) L[r] = 0.0;
    U[k] = s->c;
    for (int j = 0; j < n; ++j) U[n + j] = p->column[j] == k ? -1.0 : 0.0;
}

MBSRI_INLINE void keep_turn(const int nq, const int n, int k, const columns *z, const pivots *p,
                            double *L, double *U)
{
    for (int r = 0; r < nq; ++r) L[r] = r > k ? z->place[k][r] : 0.0;
    for (int j = k; j < nq; ++j) U[j] = z->place[j][k];
    for (int j = 0; j < n; ++j) U[nq + j] = z->place[nq + p->column[j]][k];
}

/* Columns of L and rows of U, d(M u) and dP, in the order of the pivots: as solutions read them. */
MBSRI_INLINE void keep_factors(const axes_step *s, const bool turns, const int nq, const int n,
                               const int others, const columns *z, const pivots *p)
{
    const int own = nq + n, size = own + others;
    double *L = s->f->LU + s->step->LU, *U = L + own * size, *kept = U + own * size;
    for (int k = 0; k < nq; ++k, L += size, U += size) {
        for (int j = 0; j < size; ++j) U[j] = 0.0;
        if (turns)
            keep_turn(nq, n, k, z, p, L, U);
        else
            keep_axis(s, n, k, p, L, U);
        for (int r = 0; r < n; ++r) L[nq + r] = z->a[k][p->row[r]];
        for (int r = 0; r < others; ++r) L[own + r] = z->below[k][r];
    }
    for (int q = 0; q < n; ++q, L += size, U += size) {
        for (int r = q + 1; r < n; ++r) L[nq + r] = p->L[q][p->row[r]];
        for (int r = 0; r < others; ++r) L[own + r] = z->below[nq + p->column[q]][r];
        for (int j = q; j < n; ++j) U[nq + j] = z->a[nq + p->column[j]][p->row[q]];
        for (int j = 0; j < others; ++j) U[own + j] = z->a[own + j][p->row[q]];
    }
    for (int j = 0; j < size; ++j) {
        const int from = j < nq || j >= own ? j : nq + p->column[j - nq];
        for (int r = 0; r < 2 * n; ++r) kept[2 * n * j + r] = z->momentum[from][r];
    }
}

/* others: rows and columns of the predecessor, none on the ground. False: a front takes over. */
MBSRI_INLINE bool pass(const axes_step *s, const bool turns, const int nq, const int n,
                       const int others, const knowns *k)
{
    const int own = nq + n;
    columns z;
    pivots p = {0};
    pass_own(s, nq, n, k, &z);
    if (others) pass_others(s, own, n, k, &z);
    if (!eliminate(s, turns, nq, n, others, &z, &p)) return false;
    if (others && !mbsri_finite(ROWS * ROWS, z.below[own])) return false;
    keep_numbers(s, nq, n, others, &p);
    keep_factors(s, turns, nq, n, others, &z, &p);
    if (others)
        memcpy(s->f->matrices + s->step->matrix, z.below[own], ROWS * ROWS * sizeof(double));
    return true;
}

static bool pass_any(const axes_step *s, int others, const knowns *k)
{
    return pass(s, s->turns, s->b->nq, s->b->n, others, k);
}

/* What models have most of, by itself. */
static bool choose_pass(const axes_step *s, const knowns *k)
{
    const int others = s->step->borders > 0 ? ROWS : 0;
    const bool free = s->b->nq == 7 && s->b->n == 6;
    if (!others) return free ? pass(s, true, 7, 6, 0, k) : pass_any(s, others, k);
    switch (s->turns ? 0 : s->b->n) {
    case 1: return pass(s, false, 1, 1, ROWS, k);
    case 2: return pass(s, false, 2, 2, ROWS, k);
    case 3: return pass(s, false, 3, 3, ROWS, k);
    default: return pass_any(s, others, k);
    }
}

int mbsri_front_step_axes(mbsri_front *f, mbsr_data *d, int k, bool *done)
{
    const mbsri_front_step *step = f->plan.step + k;
    const mbsri_body *b = f->model->body + step->body;
    axes_step s = {.f = f, .d = d, .b = b, .step = step, .c = f->c};
    knowns known;
    *done = false;
    if (!is_plain(f, step)) return MBSR_OK;
    s.terms = mbsri_linear_terms(f->linear, step->body);
    s.J = d->J + b->dn;
    s.Jdot = d->Jdot + b->dn;
    s.outside = mbsri_linear_motions(f->linear, b->parent);
    s.turns = !mbsri_axes_serve(b);
    for (int l = 0; l < 3 && s.outside > 0; ++l) {
        s.r[l] = d->p[b->p + MBSR_POSE_X + (size_t)l] - d->p[b->pred.p + MBSR_POSE_X + (size_t)l];
        s.rate[l] = d->V[b->v + 3 + (size_t)l] - d->V[b->pred.v + 3 + (size_t)l];
    }
    const int status = know(f, d, &s, &known);
    if (status) return status;
    *done = choose_pass(&s, &known);
    const int own = b->nq + b->n, size = own + (step->borders > 0 ? ROWS : 0);
    if (*done) f->left[k] = (mbsri_front_left){own, size, size, 0, true};
    return MBSR_OK;
}

/* The step of a body on a sequence of axes: see axes_step.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * This is the Newton step of a hinge, and of any number of axes, on an open tree. All that is known
 * of the body stands in F, y over x: its own momentum, what its successors have left, elements.
 * Column by column of z = (dq, du, x of the predecessor), with y = F X z, the joint makes of it
 *
 *   d(M u) = J^T m,   dP = J^T sigma + J'^T m + tau,   (a) = c d(M u) - dP,   y_pi = B y
 *
 * with the slopes of J and B (newton/slopes/axes.c). dq = (r_q + du) / c goes first, du by (a), n
 * rows with their largest entries as pivots. What is left is y over x of the predecessor. A front
 * (assemble.c, pass.c, pivots.c) does the same for anything, and takes over where a pivot is small;
 * solutions read the same factors. The number of axes is known to the compiler. */
#include "newton/front/axes_step.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/inlined.h"
#include "newton/slopes/axes.h"

#include <math.h>
#include <string.h>

enum { MOST = 6, ROWS = 12, COLUMNS = ROWS + 2 * MOST };

/* A pivot beside what was added up in it; below, a front decides. */
static const double good = 1e-3;

/* What is known of the body: y over x, and what elements make of q and u (forces) and of the
 * joint's loads. */
typedef struct knowns {
    double F[ROWS * ROWS];
    double by_joint[2 * MOST][6];      /* forces on the body */
    double tau[ROWS + 2 * MOST][MOST]; /* over x, q, u */
    bool moves;                        /* x changes loads, or q and u forces */
} knowns;

/* Columns dq, du, x of the predecessor. */
typedef struct columns {
    double below[COLUMNS][ROWS]; /* y of the predecessor */
    double momentum[COLUMNS][2 * MOST];
    double a[COLUMNS][MOST];
    double size[2 * MOST][MOST]; /* of what was added up in (a), over dq, du */
} columns;

typedef struct axes_step {
    mbsri_front *f;
    const mbsr_data *d;
    const mbsri_body *b;
    const mbsri_front_step *step;
    mbsri_terms terms;
    double c, r[3], rate[3];
    int outside; /* columns of the predecessor's motion in the slopes */
    const double *J, *Jdot;
} axes_step;

/* ---- which ---- */

bool mbsri_front_may_step(const mbsri_front *f, int k)
{
    const mbsri_front_step *s = f->plan.step + k;
    const mbsri_body *b = f->model->body + s->body;
    bool may = !f->served && mbsri_axes_serve(b) && b->n > 0 && s->borders <= 1 &&
               b->inertia.kind != MBSR_INERTIA_FUNCTION;
    for (int l = 0; l < s->elements && may; ++l) {
        const int element = f->plan.element[s->first_element + l], *list;
        may = element < (int)f->model->forces.count;
        if (!may) break;
        const int count = mbsri_linear_bodies(f->linear, mbsri_force_at(f->model, (size_t)element),
                                              s->body, &list);
        for (int j = 0; j < count; ++j) may = may && (list[j] == 0 || list[j] == s->body);
    }
    return may;
}

/* Whether it is at these ranks, with what the steps before have left. */
static bool is_plain(const mbsri_front *f, const mbsri_front_step *s)
{
    const mbsri_linear *w = f->linear;
    bool plain = !w->deep[s->body] && !w->coupled[s->body];
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
static void add_axis_loads(knowns *k, const double *from, int n, int stride)
{
    for (int l = 0; l < 2 * n; ++l, from += stride) {
        for (int r = 0; r < n; ++r) k->tau[ROWS + l][r] += from[6 + r];
    }
}

static void add_matrix(knowns *k, const double *from, int n, int stride)
{
    for (int l = 0; l < ROWS; ++l, from += stride) {
        if (mbsri_is_zero((size_t)(6 + n), from)) continue;
        add_column(from, n, k->F + l * ROWS + 6, k->tau[l]);
        k->moves = k->moves || !mbsri_is_zero((size_t)n, from + 6);
    }
    for (int l = 0; l < 2 * n; ++l, from += stride) {
        if (mbsri_is_zero((size_t)(6 + n), from)) continue;
        add_column(from, n, k->by_joint[l], k->tau[ROWS + l]);
        k->moves = k->moves || !mbsri_is_zero(6, from);
    }
}

static int add_element(mbsri_front *f, mbsr_data *d, int i, int element, knowns *k)
{
    const mbsri_force *force = mbsri_force_at(f->model, (size_t)element);
    const bool joint = !(force->def.table->flags & MBSR_FORCE_NO_JOINT),
               alone = (force->def.table->flags & MBSR_FORCE_JOINT_ONLY) != 0;
    const int n = f->model->body[i].n, width = ROWS + 2 * n;
    const int *list, count = mbsri_linear_bodies(f->linear, force, i, &list);
    const int status =
        f->linear->whole ? MBSR_OK : mbsri_linear_force(f->linear, d, (size_t)element, i);
    int rows, all;
    if (status) return status;
    const double *matrix = mbsri_linear_element(f->linear, (size_t)element, i, &rows, &all);
    for (int l = 0, column = 0; l < count; ++l) {
        if (list[l] == 0) continue;
        for (int j = 0, row = 0; j < count; ++j) {
            if (list[j] == 0) continue;
            const double *from = matrix + (size_t)column * (size_t)rows + row;
            if (alone)
                add_axis_loads(k, from + ROWS * (size_t)rows, n, rows);
            else if (joint)
                add_matrix(k, from, n, rows);
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
    const int i = s->step->body;
    int status = MBSR_OK;
    k->moves = false;
    memset(k->by_joint, 0, sizeof k->by_joint);
    memset(k->tau, 0, sizeof k->tau);
    memcpy(k->F, s->terms.P, sizeof k->F);
    for (int l = 0; l < s->step->children; ++l) {
        const double *from =
            f->matrices + f->plan.step[f->plan.child[s->step->first_child + l]].matrix;
        for (int r = 0; r < ROWS * ROWS; r += ROWS) mbsri_add_pairs(ROWS / 2, from + r, k->F + r);
    }
    for (int e = 0; e < f->model->elements.anywhere && !status; ++e) {
        if (mbsri_force_at(f->model, (size_t)e)->def.table->flags & MBSR_FORCE_EVERY_BODY)
            status = add_element(f, d, i, e, k);
    }
    for (int l = 0; l < s->step->elements && !status; ++l)
        status = add_element(f, d, i, f->plan.element[s->step->first_element + l], k);
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
MBSRI_INLINE void pass_own(const axes_step *s, const int n, const knowns *k, columns *z)
{
    for (int j = 0; j < 2 * n; ++j) {
        const int first = j < n ? 0 : 6, count = j < n ? ROWS : 6;
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
MBSRI_INLINE void pass_others(const axes_step *s, const int n, const knowns *k, columns *z)
{
    for (int l = 0; l < ROWS; ++l) {
        const double *x = s->terms.x + l * ROWS;
        double y[ROWS], tau[MOST] = {0.0};
        memcpy(y, k->F + l * ROWS, sizeof y);
        if (l < 3) add_product(k->F, x, 3, 9, y);
        if (l >= 6 && l < 9) add_product(k->F, x, 9, 3, y);
        if (k->moves) take_loads(k, n, x, 0, ROWS, tau);
        make_column(s, n, y, l, 2 * n + l, tau, z);
    }
}

/* ---- elimination ---- */

/* What was eliminated: (a) row[p] and du column[p] p-th; factors of the rows of (a) and of y below.
 */
typedef struct pivots {
    int row[MOST], column[MOST];
    double L[MOST][MOST];
    double row_scale[MOST], column_scale[MOST];
} pivots;

/* dq = (r_q + du) / c */
MBSRI_INLINE void eliminate_places(const axes_step *s, const int n, columns *z)
{
    const double by = 1.0 / s->c, size = fabs(by);
    for (int k = 0; k < n; ++k) {
        for (int r = 0; r < n; ++r) {
            z->a[k][r] *= by;
            z->a[n + k][r] += z->a[k][r];
            z->size[n + k][r] += size * z->size[k][r];
        }
        for (int r = 0; r < ROWS; ++r) z->below[k][r] *= by;
        for (int r = 0; r < ROWS; ++r) z->below[n + k][r] += z->below[k][r];
    }
}

MBSRI_INLINE void scale(const int n, const columns *z, pivots *p)
{
    for (int r = 0; r < n; ++r) {
        double most = 0.0;
        for (int k = 0; k < n; ++k) most = fmax(most, z->size[n + k][r]);
        p->row_scale[r] = most > 0.0 ? 1.0 / most : 0.0;
    }
    for (int k = 0; k < n; ++k) {
        double most = 0.0;
        for (int r = 0; r < n; ++r) most = fmax(most, z->size[n + k][r] * p->row_scale[r]);
        p->column_scale[k] = most > 0.0 ? 1.0 / most : 0.0;
    }
}

/* The largest of what is left, first; false: it is not good. */
MBSRI_INLINE bool choose(const int n, const columns *z, pivots *p, const int q)
{
    double most = 0.0;
    int row = q, column = q;
    for (int k = q; k < n; ++k) {
        for (int r = q; r < n; ++r) {
            const double size = fabs(z->a[n + p->column[k]][p->row[r]]) * p->row_scale[p->row[r]] *
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

MBSRI_INLINE bool eliminate(const axes_step *s, const int n, columns *z, pivots *p)
{
    eliminate_places(s, n, z);
    scale(n, z, p);
    for (int k = 0; k < n; ++k) p->row[k] = p->column[k] = k;
    for (int q = 0; q < n; ++q) {
        if (!choose(n, z, p, q)) return false;
        const int row = p->row[q], column = n + p->column[q];
        double *factor = z->below[column];
        const double by = 1.0 / z->a[column][row];
        for (int r = q + 1; r < n; ++r) p->L[q][p->row[r]] = z->a[column][p->row[r]] * by;
        for (int r = 0; r < ROWS; ++r) factor[r] *= by;
        for (int k = q + 1; k < n + ROWS; ++k) {
            const int j = k < n ? n + p->column[k] : n + k;
            const double x = z->a[j][row];
            for (int r = q + 1; r < n; ++r) z->a[j][p->row[r]] -= p->L[q][p->row[r]] * x;
            for (int r = 0; r < ROWS; ++r) z->below[j][r] -= factor[r] * x;
        }
    }
    return true;
}

/* ---- what is kept ---- */

static void keep_numbers(const axes_step *s, int n, int others, const pivots *p)
{
    const mbsri_front *f = s->f;
    const mbsri_front_names *at = f->names + s->step->body, *above = f->names + s->b->parent;
    int *row = f->numbers + s->step->numbers, *column = row + 2 * n + others;
    for (int k = 0; k < n; ++k) {
        row[k] = at->place + k;
        column[k] = at->q + k;
        row[n + k] = at->a + p->row[k];
        column[n + k] = at->u + p->column[k];
    }
    for (int k = 0; k < others; ++k) {
        row[2 * n + k] = above->y + k;
        column[2 * n + k] = above->x + k;
    }
}

/* Columns of L and rows of U, d(M u) and dP, in the order of the pivots: as solutions read them. */
MBSRI_INLINE void keep_factors(const axes_step *s, const int n, const int others, const columns *z,
                               const pivots *p)
{
    const int size = 2 * n + others;
    double *L = s->f->LU + s->step->LU, *U = L + 2 * n * size, *kept = U + 2 * n * size;
    for (int k = 0; k < n; ++k, L += size, U += size) {
        for (int r = 0; r < n; ++r) L[r] = 0.0;
        for (int r = 0; r < n; ++r) L[n + r] = z->a[k][p->row[r]];
        for (int r = 0; r < others; ++r) L[2 * n + r] = z->below[k][r];
        for (int j = 0; j < size; ++j) U[j] = 0.0;
        U[k] = s->c;
        for (int j = 0; j < n; ++j) U[n + j] = p->column[j] == k ? -1.0 : 0.0;
    }
    for (int q = 0; q < n; ++q, L += size, U += size) {
        for (int r = q + 1; r < n; ++r) L[n + r] = p->L[q][p->row[r]];
        for (int r = 0; r < others; ++r) L[2 * n + r] = z->below[n + p->column[q]][r];
        for (int j = q; j < n; ++j) U[n + j] = z->a[n + p->column[j]][p->row[q]];
        for (int j = 0; j < others; ++j) U[2 * n + j] = z->a[2 * n + j][p->row[q]];
    }
    for (int j = 0; j < size; ++j) {
        const int from = j < n || j >= 2 * n ? j : n + p->column[j - n];
        for (int r = 0; r < 2 * n; ++r) kept[2 * n * j + r] = z->momentum[from][r];
    }
}

/* False: a front takes over. */
MBSRI_INLINE bool pass(const axes_step *s, const int n, const knowns *k)
{
    const int others = s->step->borders > 0 ? ROWS : 0;
    columns z;
    pivots p = {0};
    pass_own(s, n, k, &z);
    if (others)
        pass_others(s, n, k, &z);
    else
        memset(z.below, 0, sizeof z.below), memset(z.a + 2 * n, 0, ROWS * sizeof z.a[0]);
    if (!eliminate(s, n, &z, &p)) return false;
    if (others && !mbsri_finite(ROWS * ROWS, z.below[2 * n])) return false;
    keep_numbers(s, n, others, &p);
    if (others)
        keep_factors(s, n, ROWS, &z, &p);
    else
        keep_factors(s, n, 0, &z, &p);
    if (others)
        memcpy(s->f->matrices + s->step->matrix, z.below[2 * n], ROWS * ROWS * sizeof(double));
    return true;
}

static bool pass_any(const axes_step *s, const knowns *k)
{
    switch (s->b->n) {
    case 1: return pass(s, 1, k);
    case 2: return pass(s, 2, k);
    case 3: return pass(s, 3, k);
    case 6: return pass(s, 6, k);
    default: return pass(s, s->b->n, k);
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
    for (int l = 0; l < 3 && s.outside > 0; ++l) {
        s.r[l] = d->p[b->p + MBSR_POSE_X + (size_t)l] - d->p[b->pred.p + MBSR_POSE_X + (size_t)l];
        s.rate[l] = d->V[b->v + 3 + (size_t)l] - d->V[b->pred.v + 3 + (size_t)l];
    }
    const int status = know(f, d, &s, &known);
    if (status) return status;
    *done = pass_any(&s, &known);
    const int n = b->n, size = 2 * n + (step->borders > 0 ? ROWS : 0);
    if (*done) f->left[k] = (mbsri_front_left){2 * n, size, size, 0, true};
    return MBSR_OK;
}

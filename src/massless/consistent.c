/* A consistent start for every form.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Along the directions a that move no mass (null_space.h) the equations of motion are balances of
 * forces, gamma(q, u, t) = 0. With C = d gamma / d u and S = d gamma / d q along these directions,
 * and Y an orthonormal basis of the left null space of C, Yc of its complement:
 *
 *   damped directions (rank of C):  Yc^T gamma = 0 fixes velocities        index 1
 *   elastic ones:                   Y^T gamma = 0 fixes positions,
 *                                   Y^T gamma' = 0 velocities              index 2
 *   otherwise                       the motion is not determined
 *
 * The start changes q along the elastic directions only, then u along all of them; momenta p = M u
 * stay. u' follows from the equations of motion, Yc^T gamma' = 0 and Y^T gamma'' = 0. Since all of
 * gamma vanishes along the motion, Y may be held fixed while differentiating.
 *
 * That takes O(N k) operations for k directions, and C by differences. Where they are many and all
 * are damped, the Newton solver does it in O(N) (damped_start.h). */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "massless/imbalance.h"
#include "massless/damped_start.h"
#include "massless/loops_start.h"
#include "massless/null_slopes.h"
#include "massless/null_space.h"
#include "massless/reduction.h"
#include "massless/scales.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"
#include "recursion/sizes.h"

#include <float.h>
#include <math.h>

mbsr_consistent_opt mbsr_default_consistent_opt(void)
{
    return (mbsr_consistent_opt){.cookie = MBSRI_COOKIE, .max_iterations = 30, .tolerance = 1e-12};
}

typedef struct start {
    mbsri_null_space w;
    const mbsri_dae_form *form;
    const mbsr_consistent_opt *opt;
    mbsr_consistent_info info;
    double t;
    int damped;                /* rank of C */
    bool moved_off;            /* u was moved to where forces change with it */
    double first_defect;       /* the elastic force at the start */
    double *q_given, *u_given; /* nq, nu */
    double *q, *u;             /* nq, nu: the state being improved */
    double *qdot, *udot;       /* nq, nu */
    double *change;            /* nu */
    mbsri_reduction reduced;   /* of C */
    mbsri_reduction rest;      /* of T = B Z, B = Y^T S or slopes of Y^T gamma'' */
    double *left, *left_error; /* k x k: [Yc Y], and what Y may be wrong by */
    double *Z, *Z_error;       /* k x (k - damped): right null vectors of C */
    double *B, *B_error;       /* (k - damped) x k */
    double *sizes;             /* k: of the forces in the null directions at the velocities given */
    double *defect, *weights, *moved, *trial; /* k */
    double *y, *yp;                           /* the result in the form asked for */
    void *memory, *more;
} start;

/* Memory of vectors over the whole state. */
static int allocate_state(start *s)
{
    const mbsr_model *m = s->w.m;
    const size_t nq = (size_t)m->nq, nu = (size_t)m->nu, size = (size_t)s->form->size(m);
    double **const array[] = {&s->q_given, &s->u_given, &s->q,  &s->u,     &s->qdot,
                              &s->udot,    &s->y,       &s->yp, &s->change};
    const size_t length[] = {nq, nu, nq, nu, nq, nu, size, size, nu};
    s->memory = mbsri_allocate(&m->allocator, (3 * nq + 4 * nu + 2 * size) * sizeof(double));
    if (!s->memory) {
        return mbsri_fail(&s->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %zu coordinates", nq + nu);
    }
    double *next = s->memory;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    return MBSR_OK;
}

/* Memory of what the directions need beside the null space itself. */
static int allocate_directions(start *s)
{
    const mbsr_model *m = s->w.m;
    const size_t k = (size_t)s->w.k;
    double **const array[] = {&s->left,  &s->left_error, &s->Z,      &s->Z_error,
                              &s->B,     &s->B_error,    &s->defect, &s->weights,
                              &s->moved, &s->trial,      &s->sizes};
    const size_t length[] = {k * k, k * k, k * k, k * k, k * k, k * k, k, k, k, k, k};
    size_t total = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) total += length[l];
    size_t reduction = mbsri_reduction_size(s->w.k) + sizeof(double);
    reduction -= reduction % sizeof(double);
    s->more = mbsri_allocate(&m->allocator, total * sizeof(double) + 2 * reduction);
    if (!s->more) {
        return mbsri_fail(&s->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %d null directions", s->w.k);
    }
    double *next = s->more;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    mbsri_reduction_place(&s->reduced, s->w.k, next);
    mbsri_reduction_place(&s->rest, s->w.k, next + reduction / sizeof(double));
    return MBSR_OK;
}

/* The direction l is not determined at the state: names its joint. */
static int undetermined(start *s, int l)
{
    const mbsr_model *m = s->w.m;
    char label[MBSRI_LABEL];
    const int i = s->w.body[l];
    return mbsri_fail(
        &s->w.d->error, MBSR_UNDETERMINED, m->body[i].id, MBSR_NONE,
        "mbsr_dae_consistent: %s: a combination of joint rates that includes its joint "
        "moves no mass, and neither a damper nor a spring resists it at this state: give it "
        "inertia, a spring or a damper, or lock it",
        mbsri_body_label(m, i, label));
}

/* Basis, C and S at (q, u); [Yc Y] and the rank of C. Of Yc, unit vectors for the rows of C with a
 * pivot serve: they and Y are independent. */
static int split(start *s)
{
    mbsri_null_space *w = &s->w;
    const int k = w->k;
    const size_t square = (size_t)k * (size_t)k;
    int status = mbsri_null_basis(w, s->t, s->q, s->u);
    if (!status) status = mbsri_null_slopes(w, s->t, s->q, s->u);
    if (status) return status;
    mbsri_copy(square, w->C, s->reduced.A);
    mbsri_copy(square, w->C_error, s->reduced.error);
    mbsri_reduce(&s->reduced, k, MBSRI_LEAST_DAMPING);
    s->damped = s->reduced.rank;
    mbsri_zero(square, s->left);
    mbsri_zero(square, s->left_error);
    for (int c = 0; c < s->damped; ++c) {
        const int row = s->reduced.pivot_row[c];
        s->left[c * k + row] = s->reduced.rows[row];
    }
    for (int c = 0; c < k - s->damped; ++c) {
        const int at = (s->damped + c) * k;
        mbsri_left_null(&s->reduced, c, s->left + at, s->left_error + at);
        mbsri_right_null(&s->reduced, c, s->Z + c * k, s->Z_error + c * k);
    }
    return MBSR_OK;
}

/* out (k) = [Yc Y]^T x */
static void turn(const start *s, const double *x, double *out)
{
    mbsri_zero((size_t)s->w.k, out);
    mbsri_atx(s->w.k, s->w.k, 1.0, s->left, x, out);
}

/* B = Y^T S with its errors. */
static void fill_springs(start *s)
{
    const mbsri_null_space *w = &s->w;
    const int k = w->k, e = k - s->damped;
    for (int c = 0; c < k; ++c) {
        const double *x = w->S + c * k, *dx = w->S_error + c * k;
        for (int r = 0; r < e; ++r) {
            const int at = (s->damped + r) * k;
            const double *y = s->left + at, *dy = s->left_error + at;
            double sum = 0.0, error = 0.0;
            for (int l = 0; l < k; ++l) {
                sum += y[l] * x[l];
                error += fabs(y[l]) * (dx[l] + 4.0 * DBL_EPSILON * fabs(x[l])) + dy[l] * fabs(x[l]);
            }
            s->B[c * e + r] = fabs(sum) > 10.0 * error ? sum : 0.0;
            s->B_error[c * e + r] = error;
        }
    }
}

/* Reduces T = B Z; a column without pivot is a direction that is not determined. */
static int factor(start *s, double small)
{
    const int k = s->w.k, e = k - s->damped;
    for (int c = 0; c < e; ++c) {
        const double *z = s->Z + c * k, *dz = s->Z_error + c * k;
        for (int r = 0; r < e; ++r) {
            double sum = 0.0, error = 0.0;
            for (int l = 0; l < k; ++l) {
                const double B = s->B[l * e + r];
                sum += B * z[l];
                error += (s->B_error[l * e + r] + 4.0 * DBL_EPSILON * fabs(B)) * fabs(z[l]) +
                         fabs(B) * dz[l];
            }
            s->rest.A[c * e + r] = fabs(sum) > 10.0 * error ? sum : 0.0;
            s->rest.error[c * e + r] = error;
        }
    }
    mbsri_reduce(&s->rest, e, small);
    if (s->rest.rank == e) return MBSR_OK;
    int column = 0, largest = 0;
    while (s->rest.column_taken[column]) ++column;
    for (int l = 0; l < k; ++l) {
        if (fabs(s->Z[column * k + l]) > fabs(s->Z[column * k + largest])) largest = l;
    }
    return undetermined(s, largest);
}

/* Pivots of x from A x = right, which has numbers for the pivot rows, in their order or (pivots
 * false) for all rows. */
static void back(const mbsri_reduction *r, bool pivots, const double *right, double *x)
{
    for (int k = 0; k < r->rank; ++k) {
        const int row = r->pivot_row[k], column = r->pivot_column[k];
        double sum = 0.0;
        for (int l = 0; l < r->rank; ++l) {
            const int from = r->pivot_row[l];
            const double value = pivots ? right[l] : right[from] * r->rows[from];
            sum += r->A[(r->n + from) * r->n + row] * value;
        }
        x[column] = sum * r->columns[column];
    }
}

/* weights with Yc^T C weights = right, B weights = the rest of right: those of the pivots of C
 * first, then weights of Z. */
static void solve(start *s, const double *right)
{
    const int k = s->w.k, e = k - s->damped;
    double *part = s->trial, *z = part + s->damped;
    mbsri_zero((size_t)k, s->weights);
    back(&s->reduced, true, right, s->weights);
    mbsri_copy((size_t)e, right + s->damped, s->w.ahead);
    mbsri_ax(e, k, -1.0, s->B, s->weights, s->w.ahead);
    back(&s->rest, false, s->w.ahead, z);
    mbsri_ax(k, e, 1.0, s->Z, z, s->weights);
}

/* ---- when an iteration ends ---- */

/* Largest |x| beside typical sizes. */
static double relative(int n, const double *x, const double *scale)
{
    double largest = 0.0;
    for (int k = 0; k < n; ++k) largest = fmax(largest, fabs(x[k]) / scale[k]);
    return largest;
}

/* sizes (k) of the forces that were added up last, in the null directions. */
static void gross_loads(start *s, double *sizes)
{
    mbsri_null_space *w = &s->w;
    mbsri_gross_forces(w->m, w->d);
    for (int l = 0; l < w->k; ++l) {
        const mbsri_group g = mbsri_group_of(w->m, w->d, w->head[l]);
        sizes[l] = mbsri_gross_load(w->m, w->d, &g, w->vector + (size_t)l * (size_t)w->m->max_n);
    }
}

/* sizes (k) += what dampers add up to forces inside, where relative velocities are differences:
 * C_lm times the multiple of direction m that is as fast as u. */
static void add_dampers(start *s, double *sizes)
{
    const mbsri_null_space *w = &s->w;
    const int k = w->k, nu = w->m->nu;
    const double speed = relative(nu, s->u, w->u_scale);
    for (int m = 0; m < k; ++m) {
        const double *a = w->direction + (size_t)m * (size_t)nu,
                     share = speed / relative(nu, a, w->u_scale);
        for (int l = 0; l < k; ++l) sizes[l] += fabs(w->C[m * k + l]) * share;
    }
}

/* Largest |gamma_l| beside the sizes of the forces, over all l, or those whose rows of C have a
 * pivot. Leaves the sizes in w.force. */
static double imbalance(start *s, const double *gamma, bool damped_only)
{
    double *sizes = s->w.force, worst = 0.0;
    gross_loads(s, sizes);
    if (damped_only) add_dampers(s, sizes);
    for (int l = 0; l < s->w.k; ++l) {
        if (gamma[l] == 0.0 || (damped_only && !s->reduced.row_taken[l])) continue;
        worst = fmax(worst, fabs(gamma[l]) / sizes[l]);
    }
    return worst;
}

static const double rounding = 1e3 * DBL_EPSILON; /* of gamma, beside these sizes */

/* Whether a correction of this size, to a vector of that size, is the last, both beside typical
 * sizes; `near`: from where one counts that does not get smaller. *last: the correction before. */
static bool settled(const start *s, double *last, double change, double size, double near)
{
    const double beside = fmax(size, 1e-3);
    const bool slow = change > 0.25 * *last && change <= near * beside;
    *last = change;
    return change <= s->opt->tolerance * beside || slow;
}

/* ---- positions: Y^T gamma = 0 by Newton's method with step halving ---- */

enum { HALVINGS = 60 };

static double elastic_defect(const start *s, const double *gamma, double *turned)
{
    turn(s, gamma, turned);
    return s->damped < s->w.k ? mbsri_largest(s->w.k - s->damped, turned + s->damped) : 0.0;
}

/* q + step q', with q' in qdot that of the direction in udot. */
static int try_position(start *s, double step, double *defect)
{
    mbsri_null_space *w = &s->w;
    for (int c = 0; c < w->m->nq; ++c) w->q[c] = s->q[c] + step * s->qdot[c];
    const int status = mbsri_null_gamma(w, s->t, w->q, s->u, s->moved);
    if (status) return status;
    *defect = elastic_defect(s, s->moved, s->trial);
    return MBSR_OK;
}

/* No state found: names the joint at which the largest force is left. */
static int unbalanced(start *s, const char *what, const double *gamma)
{
    const mbsri_null_space *w = &s->w;
    char label[MBSRI_LABEL];
    int worst = 0;
    for (int l = 1; l < w->k; ++l) {
        if (fabs(gamma[l]) > fabs(gamma[worst])) worst = l;
    }
    return mbsri_fail(&w->d->error, MBSR_NO_CONVERGENCE, w->m->body[w->body[worst]].id, MBSR_NONE,
                      "mbsr_dae_consistent: no %s at the massless joints, that of %s among them "
                      "(force left: %g)",
                      what, mbsri_body_label(w->m, w->body[worst], label), fabs(gamma[worst]));
}

static int move_positions(start *s, double before, bool *stuck)
{
    mbsri_null_space *w = &s->w;
    double after = INFINITY, step = 1.0;
    *stuck = false;
    for (int k = 0; k < HALVINGS; ++k, step *= 0.5) {
        const int status = try_position(s, step, &after);
        if (status < 0) return status;
        if (status || !(after < before)) continue;
        for (int c = 0; c < w->m->nq; ++c) s->q[c] += step * s->qdot[c];
        return MBSR_OK;
    }
    *stuck = true;
    return MBSR_OK;
}

/* Moves u by typical rates in all null directions, to where forces may change with it. */
static void move_off(start *s)
{
    const mbsri_null_space *w = &s->w;
    for (int l = 0; l < w->k; ++l) {
        const double *a = w->direction + (size_t)l * (size_t)w->m->nu,
                     step = (1.0 + 0.25 * sin(12.9898 * l)) / relative(w->m->nu, a, w->u_scale);
        mbsri_ax(w->m->nu, 1, step, a, &(double){1.0}, s->u);
    }
    s->moved_off = true;
}

/* The direction of a step at a state that split has seen: qdot; s->defect has gamma. */
static int aim_positions(start *s)
{
    mbsri_null_space *w = &s->w;
    turn(s, s->defect, s->moved);
    for (int r = 0; r < w->k; ++r) s->moved[r] = r < s->damped ? 0.0 : -s->moved[r];
    fill_springs(s);
    const int status = factor(s, MBSRI_LEAST_STIFFNESS);
    if (status) return status;
    solve(s, s->moved);
    mbsri_zero((size_t)w->m->nu, s->udot);
    mbsri_null_combine(w, s->weights, s->udot);
    return mbsri_null_rate(w, s->t, s->q, s->udot, s->qdot);
}

/* One step; *done: the positions are found. */
static int step_positions(start *s, int number, double *last, bool *done)
{
    mbsri_null_space *w = &s->w;
    int status = split(s);
    if (!status) status = mbsri_null_gamma(w, s->t, s->q, s->u, s->defect);
    if (status) return status;
    if (number == 0 && !s->moved_off) s->info.force_defect = mbsri_largest(w->k, s->defect);
    *done = s->damped == w->k;
    if (*done) return MBSR_OK;
    const bool still = imbalance(s, s->defect, false) <= rounding;
    const double before = elastic_defect(s, s->defect, s->moved);
    if (number == 0) s->first_defect = before;
    status = aim_positions(s);
    if (status == MBSR_UNDETERMINED && !still && !s->moved_off && number == 0) {
        move_off(s);
        return MBSR_OK;
    }
    /* springs that held at the start and have given way with the force still there */
    if (status == MBSR_UNDETERMINED && before > 1e-3 * s->first_defect && s->info.iterations > 0)
        return unbalanced(s, "position balances the springs", s->defect);
    if (status) return status;
    *done = still || settled(s, last, relative(w->m->nq, s->qdot, w->q_scale),
                             relative(w->m->nq, s->q, w->q_scale), 1e-8);
    if (*done) return MBSR_OK;
    s->info.iterations += 1;
    status = move_positions(s, before, done);
    if (*done && *last > 1e-6 * relative(w->m->nq, s->q, w->q_scale))
        return unbalanced(s, "position balances the springs", s->defect);
    return status;
}

static int find_positions(start *s)
{
    double last = INFINITY;
    bool done = false;
    int status = MBSR_OK;
    for (int step = 0; step < s->opt->max_iterations && !status && !done; ++step)
        status = step_positions(s, step, &last, &done);
    if (status || done) return status;
    return mbsri_fail(
        &s->w.d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
        "mbsr_dae_consistent: positions did not converge in %d iterations (the last one changed "
        "them by %g of their size)",
        s->opt->max_iterations, last);
}

/* ---- velocities: Yc^T gamma = 0 and Y^T gamma' = 0 ---- */

/* A time in which state and time change by about `share` of their size. */
static double short_time(const start *s, double share)
{
    const mbsri_null_space *w = &s->w;
    const mbsr_model *m = w->m;
    double speed = w->rate_of_tree > 0.0 ? w->rate_of_tree : 1.0;
    for (int k = 0; k < m->nq && w->k > 0; ++k)
        speed = fmax(speed, fabs(s->qdot[k]) / fmax(w->q_scale[k], fabs(s->q[k])));
    for (int k = 0; k < m->nu && w->k > 0; ++k)
        speed = fmax(speed, fabs(s->udot[k]) / fmax(w->u_scale[k], fabs(s->u[k])));
    return share / speed;
}

/* gamma at time h from the state, along q', u' (second order: q' is taken half-way). */
static int gamma_after(start *s, double h, bool accelerated, double *gamma)
{
    mbsri_null_space *w = &s->w;
    const mbsr_model *m = w->m;
    for (int c = 0; c < m->nq; ++c) w->q[c] = s->q[c] + 0.5 * h * s->qdot[c];
    for (int c = 0; c < m->nu; ++c) w->u[c] = s->u[c] + (accelerated ? 0.5 * h * s->udot[c] : 0.0);
    int status = mbsri_null_rate(w, s->t + 0.5 * h, w->q, w->u, w->rate);
    if (status) return status;
    for (int c = 0; c < m->nq; ++c) w->q[c] = s->q[c] + h * w->rate[c];
    for (int c = 0; c < m->nu; ++c) w->u[c] = s->u[c] + (accelerated ? h * s->udot[c] : 0.0);
    return mbsri_null_gamma(w, s->t + h, w->q, w->u, gamma);
}

/* gamma' and, unless NULL, gamma'' along q', u', from gamma at the state, of the second and the
 * first order in h: from gamma before and after it, or on one side. */
static int differences(start *s, double h, bool accelerated, const double *gamma, double *first,
                       double *second)
{
    const int k = s->w.k, side = s->opt->side;
    double *a = s->w.ahead, *b = s->w.behind;
    int status = gamma_after(s, side < 0 ? -h : h, accelerated, a);
    if (!status) status = gamma_after(s, side == 0 ? -h : 2.0 * side * h, accelerated, b);
    for (int l = 0; l < k && !status; ++l) {
        const double difference =
            side == 0 ? a[l] - b[l] : side * (4.0 * a[l] - b[l] - 3.0 * gamma[l]);
        first[l] = difference / (2.0 * h);
        if (second)
            second[l] =
                (side == 0 ? a[l] - 2.0 * gamma[l] + b[l] : gamma[l] - 2.0 * a[l] + b[l]) / (h * h);
    }
    return status;
}

/* out = gamma' along q' = G u with u held fixed; gamma is in s->defect. */
static int drift(start *s, double *out)
{
    const int status = mbsri_null_rate(&s->w, s->t, s->q, s->u, s->qdot);
    return status ? status : differences(s, short_time(s, 1e-5), false, s->defect, out, NULL);
}

/* out = [Yc^T gamma; Y^T gamma'] at u, and gamma in s->defect; *left: the imbalance of the
 * first, and the sizes that it is measured by. */
static int velocity_defect(start *s, double *out, double *left, double *sizes)
{
    mbsri_null_space *w = &s->w;
    int status = mbsri_null_gamma(w, s->t, s->q, s->u, s->defect);
    if (status) return status;
    *left = imbalance(s, s->defect, true);
    mbsri_copy((size_t)w->k, w->force, sizes);
    turn(s, s->defect, out);
    if (s->damped == w->k) return MBSR_OK;
    status = drift(s, s->trial);
    turn(s, s->trial, s->weights);
    for (int r = s->damped; r < w->k && !status; ++r) out[r] = s->weights[r];
    return status;
}

/* u + step change, until the damped rows of the defect, of size `before`, get smaller: the others
 * are linear in u. */
static int move_velocities(start *s, double before, bool *stuck)
{
    mbsri_null_space *w = &s->w;
    const int nu = w->m->nu;
    double step = 1.0;
    *stuck = false;
    for (int k = 0; k < HALVINGS; ++k, step *= 0.5) {
        for (int c = 0; c < nu; ++c) w->u[c] = s->u[c] + step * s->change[c];
        const int status = mbsri_null_gamma(w, s->t, s->q, w->u, s->trial);
        if (status < 0 && status != MBSR_NOT_FINITE) return status;
        if (status) continue;
        turn(s, s->trial, s->moved);
        if (s->damped > 0 && !(mbsri_largest(s->damped, s->moved) < before)) continue;
        for (int c = 0; c < nu; ++c) s->u[c] += step * s->change[c];
        return MBSR_OK;
    }
    *stuck = true;
    return MBSR_OK;
}

/* One step; *done: the velocities are found. */
static int step_velocities(start *s, int number, double *last, bool *done)
{
    mbsri_null_space *w = &s->w;
    const int k = w->k, nu = w->m->nu;
    double left = 0.0;
    bool stuck = false;
    const int damped = s->damped;
    int status = number > 0 ? split(s) : MBSR_OK;
    if (!status && s->damped != damped) /* a law has no slope there */
        return mbsri_null_gamma(w, s->t, s->q, s->u, s->defect)
                   ? MBSR_NO_CONVERGENCE
                   : unbalanced(s, "velocity balances the forces", s->defect);
    if (!status) status = velocity_defect(s, s->moved, &left, number == 0 ? s->sizes : s->trial);
    if (status) return status;
    const double before = mbsri_largest(s->damped, s->moved);
    for (int r = 0; r < k; ++r) s->moved[r] = -s->moved[r];
    fill_springs(s);
    status = factor(s, MBSRI_LEAST_STIFFNESS);
    if (status == MBSR_UNDETERMINED && number > 0)
        return unbalanced(s, "velocity balances the forces", s->defect);
    if (status) return status;
    solve(s, s->moved);
    mbsri_zero((size_t)nu, s->change);
    mbsri_null_combine(w, s->weights, s->change);
    s->info.iterations += 1;
    const double change = relative(nu, s->change, w->u_scale),
                 size = relative(nu, s->u, w->u_scale);
    const bool level = s->damped == k || change > 0.25 * *last;
    *done = (left <= rounding && level) || settled(s, last, change, size, 1e-6);
    if (*done) {
        for (int c = 0; c < nu; ++c) s->u[c] += s->change[c];
        return MBSR_OK;
    }
    status = move_velocities(s, before, &stuck);
    if (stuck && left <= 1e-9) { /* rounding of forces that cancelled unseen */
        for (int c = 0; c < nu; ++c) s->u[c] += s->change[c];
        *done = level;
        stuck = false;
    }
    return stuck && !status ? unbalanced(s, "velocity balances the forces", s->defect) : status;
}

/* Whether gamma has become small beside what it was made of at the velocities given: it is, beside
 * anything, where velocities run away. */
static int check_velocities(start *s)
{
    mbsri_null_space *w = &s->w;
    const int status = mbsri_null_gamma(w, s->t, s->q, s->u, s->defect);
    if (status) return status;
    const double least = 1e-6 * mbsri_largest(w->k, s->sizes);
    for (int l = 0; l < w->k && least > 0.0; ++l) {
        if (s->reduced.row_taken[l] && fabs(s->defect[l]) > 1e-3 * fmax(s->sizes[l], least))
            return unbalanced(s, "velocity balances the forces", s->defect);
    }
    return MBSR_OK;
}

/* *steps: of the iterations, how many are left. */
static int iterate_velocities(start *s, int *steps)
{
    double last = INFINITY;
    bool done = false;
    int status = MBSR_OK;
    for (int number = 0; *steps > 0 && !status && !done; ++number, --*steps)
        status = step_velocities(s, number, &last, &done);
    if (!status && done) return check_velocities(s);
    if (status) return status;
    return mbsri_fail(
        &s->w.d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
        "mbsr_dae_consistent: velocities did not converge in %d iterations (the last one changed "
        "them by %g of their size)",
        s->opt->max_iterations, last);
}

/* Takes the null directions out of u, with typical rates as weights: dampers and friction are
 * steepest near rest. */
static int come_to_rest(start *s)
{
    mbsri_null_space *w = &s->w;
    const int k = w->k, nu = w->m->nu;
    mbsri_reduction *gram = &s->rest;
    for (int c = 0; c < k; ++c) {
        s->moved[c] = 0.0;
        for (int r = 0; r < k; ++r) gram->A[c * k + r] = gram->error[c * k + r] = 0.0;
        for (int l = 0; l < nu; ++l) {
            const double a =
                w->direction[(size_t)c * (size_t)nu + (size_t)l] / (w->u_scale[l] * w->u_scale[l]);
            s->moved[c] -= a * s->u[l];
            for (int r = 0; r < k; ++r)
                gram->A[c * k + r] += a * w->direction[(size_t)r * (size_t)nu + (size_t)l];
        }
    }
    mbsri_reduce(gram, k, DBL_EPSILON);
    mbsri_zero((size_t)k, s->weights);
    back(gram, false, s->moved, s->weights);
    mbsri_null_combine(w, s->weights, s->u);
    return split(s);
}

/* From the velocities given; if no step from there leads on, from rest. */
static int find_velocities(start *s)
{
    int steps = s->opt->max_iterations;
    const int status = iterate_velocities(s, &steps);
    if (status != MBSR_NO_CONVERGENCE || steps == 0) return status;
    const mbsr_error first = s->w.d->error;
    mbsri_copy((size_t)s->w.m->nu, s->u_given, s->u);
    int again = come_to_rest(s);
    if (!again) again = iterate_velocities(s, &steps);
    if (again == MBSR_NO_CONVERGENCE) s->w.d->error = first;
    return again;
}

/* ---- accelerations: the equations of motion, Yc^T gamma' = 0 and Y^T gamma'' = 0 ---- */

/* out = [Yc^T gamma'; Y^T gamma''] along the motion with the present u'. */
static int defect_of_rates(start *s, double *out)
{
    mbsri_null_space *w = &s->w;
    const double h = short_time(s, 1e-4);
    int status = mbsri_null_gamma(w, s->t, s->q, s->u, s->defect);
    if (!status) status = differences(s, h, true, s->defect, s->trial, s->defect);
    if (status) return status;
    turn(s, s->trial, out);
    mbsri_copy((size_t)w->k, s->defect, s->trial);
    turn(s, s->trial, s->defect);
    for (int r = s->damped; r < w->k; ++r) out[r] = s->defect[r];
    return MBSR_OK;
}

/* B, slopes of Y^T gamma'' along the null directions: Y^T S, and where differences show more, the
 * change of C in time. */
static int slopes_of_rates(start *s)
{
    mbsri_null_space *w = &s->w;
    const mbsr_model *m = w->m;
    const int k = w->k, e = k - s->damped;
    const double time = short_time(s, 1e-4), rate = 1e-4 / time;
    fill_springs(s);
    if (e > 0) gross_loads(s, s->weights);
    for (int l = 0; l < k && e > 0; ++l) {
        const double *a = w->direction + (size_t)l * (size_t)m->nu;
        const double h =
            fmax(rate, relative(m->nu, s->udot, w->u_scale)) / relative(m->nu, a, w->u_scale);
        mbsri_ax(m->nu, 1, h, a, &(double){1.0}, s->udot);
        const int status = defect_of_rates(s, s->change);
        mbsri_ax(m->nu, 1, -h, a, &(double){1.0}, s->udot);
        if (status) return status;
        for (int r = 0; r < e; ++r) {
            const double slope = (s->change[s->damped + r] - s->moved[s->damped + r]) / h;
            const double *y = s->left + (s->damped + r) * k;
            double row = 0.0, noise = 0.0;
            for (int c = 0; c < k; ++c) {
                row = fmax(row, fabs(s->B[c * e + r]));
                noise += 1e3 * DBL_EPSILON * fabs(y[c]) * s->weights[c] / (time * time * h);
            }
            if (fabs(slope - s->B[l * e + r]) > 10.0 * noise + 1e-4 * fmax(row, fabs(slope)))
                s->B[l * e + r] = slope;
        }
    }
    return factor(s, MBSRI_LEAST_STIFFNESS);
}

/* The defect is affine in u'; what rounding leaves of it the next solutions remove. */
static int null_rates(start *s)
{
    enum { REFINED = 3 };
    int status = defect_of_rates(s, s->moved);
    if (!status) status = slopes_of_rates(s);
    for (int step = 0; step < REFINED && !status; ++step) {
        if (step > 0) status = defect_of_rates(s, s->moved);
        for (int r = 0; r < s->w.k; ++r) s->moved[r] = -s->moved[r];
        solve(s, s->moved);
        if (!status) mbsri_null_combine(&s->w, s->weights, s->udot);
    }
    return status;
}

static int find_rates(start *s)
{
    mbsri_null_space *w = &s->w;
    const mbsr_error before = w->d->error;
    int status = mbsri_forward_by_stages(w->m, w->d, s->t, s->q, s->u, NULL, s->udot);
    if (status == MBSR_UNDETERMINED) {
        w->d->error = before; /* expected: the null directions are what is looked for */
    } else if (status) {
        return status;
    }
    status = mbsri_coordinate_rates(w->m, w->d, s->qdot);
    return status || w->k == 0 ? status : null_rates(s);
}

/* ---- the call ---- */

static int check(const mbsr_model *m, mbsr_data *d, mbsr_dae_form form,
                 const mbsr_consistent_opt *opt)
{
    if (m->rows > 0 && mbsri_find_form(form) && form != MBSR_DAE_MOMENTUM) {
        return mbsri_fail(&d->error, MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: the model has closures, which only the momentum "
                          "form takes");
    }
    if (mbsr_dae_size(m, form) < 0) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: form is %d, no such form", (int)form);
    }
    if (opt->cookie != MBSRI_COOKIE) {
        return mbsri_fail(&d->error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: opt was not made by mbsr_default_consistent_opt");
    }
    if (opt->max_iterations < 1 || !(opt->tolerance > 0.0)) {
        return mbsri_fail(
            &d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
            "mbsr_dae_consistent: max_iterations is %d, tolerance is %g; both must be positive",
            opt->max_iterations, opt->tolerance);
    }
    if (opt->side < -1 || opt->side > 1) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: side is %d, must be -1, 0 or 1", opt->side);
    }
    return MBSR_OK;
}

/* Evaluates all stages at the improved state. */
static int evaluate(const start *s)
{
    int status = mbsri_positions(s->w.m, s->w.d, s->t, s->q);
    if (!status) status = mbsri_velocities(s->w.m, s->w.d, s->u);
    if (!status) status = mbsri_forces(s->w.m, s->w.d, NULL);
    return status ? status : mbsri_backward(s->w.m, s->w.d);
}

/* The improved state in the form asked for, with its rates. */
static int deliver(const start *s, double *y, double *yp)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    const size_t size = (size_t)s->form->size(m);
    int status = mbsri_pack(s->form, m, d, s->t, s->q, s->u, s->y);
    if (!status) status = evaluate(s);
    if (!status) status = s->form->start(m, d, s->t, s->y, s->udot, s->yp);
    if (status) return status;
    status = mbsri_check_result(m, d, size, s->y, "mbsr_dae_consistent");
    if (!status) status = mbsri_check_result(m, d, size, s->yp, "mbsr_dae_consistent");
    if (status) return status;
    mbsri_copy(size, s->y, y);
    mbsri_copy(size, s->yp, yp);
    return MBSR_OK;
}

/* ---- the two ways ---- */

/* By the directions that move no mass. */
static int run_directions(start *s)
{
    int status = MBSR_OK;
    s->info.null_directions = s->w.k;
    if (s->w.k > 0) {
        status = find_positions(s);
        if (!status) status = find_velocities(s);
    }
    if (!status) status = find_rates(s);
    s->info.elastic_directions = s->w.k - s->damped;
    return status;
}

static int by_directions(start *s)
{
    const mbsr_model *m = s->w.m;
    int status = mbsri_null_open(&s->w, m, s->w.d, s->t, s->q, s->u, "mbsr_dae_consistent");
    if (status) return status;
    status = allocate_directions(s);
    if (!status) status = run_directions(s);
    mbsri_release(&m->allocator, s->more);
    mbsri_null_close(&s->w);
    return status;
}

/* Beyond so many directions the Newton solver is asked first. */
enum { MANY_DIRECTIONS = 24 };

/* By the Newton solver; *served: whether it did. */
static int on_tree(start *s, bool *served)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    *served = false;
    int status = evaluate(s);
    if (status || m->nu - d->total_rank <= MANY_DIRECTIONS) return status;
    s->info.null_directions = m->nu - d->total_rank;
    s->info.force_defect = mbsri_largest_defect(m, d, false, NULL);
    status = mbsri_damped_start(m, d, s->t, s->q, s->u, s->udot, s->opt, &s->info, served);
    if (!*served) s->info = (mbsr_consistent_info){0};
    return status;
}

static double distance(int n, const double *a, const double *b)
{
    double value = 0.0;
    for (int k = 0; k < n; ++k) value = fmax(value, fabs(a[k] - b[k]));
    return value;
}

/* From the state given to the result in y, yp. */
static int run(start *s, double *y, double *yp)
{
    const mbsr_model *m = s->w.m;
    bool served;
    mbsri_copy((size_t)m->nq, s->q_given, s->q);
    mbsri_copy((size_t)m->nu, s->u_given, s->u);
    int status = on_tree(s, &served);
    if (!status && !served) status = by_directions(s);
    if (status) return status;
    s->info.position_change = distance(m->nq, s->q, s->q_given);
    s->info.velocity_change = distance(m->nu, s->u, s->u_given);
    return deliver(s, y, yp);
}

int mbsr_dae_consistent(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                        double *y, double *yp, const mbsr_consistent_opt *opt,
                        mbsr_consistent_info *info)
{
    const mbsr_consistent_opt standard = mbsr_default_consistent_opt();
    if (!opt) opt = &standard;
    int status = mbsri_enter(model, data, y && yp, MBSRI_STAGE_NONE, "mbsr_dae_consistent");
    if (!status) status = check(model, data, form, opt);
    if (status) return status;
    if (model->rows > 0) return mbsri_loops_start(model, data, form, t, y, yp, opt, info);

    start s = {.form = mbsri_find_form(form), .opt = opt, .t = t, .w = {.m = model, .d = data}};
    status = allocate_state(&s);
    if (status) return status;
    const bool watching = data->watching;
    data->watching = false; /* a new start may have other ranks */
    status = mbsri_unpack(s.form, model, data, t, y, s.q_given, s.u_given);
    if (!status) {
        status = run(&s, y, yp);
        if (info) *info = s.info;
    }
    data->watching = watching;
    mbsri_release(&model->allocator, s.memory);
    return status;
}

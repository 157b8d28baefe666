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
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "massless/damped_start.h"
#include "massless/null_slopes.h"
#include "massless/null_space.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"

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
    int damped;                               /* rank of C */
    double *q_given, *u_given;                /* nq, nu */
    double *q, *u;                            /* nq, nu: the state being improved */
    double *qdot, *udot;                      /* nq, nu */
    double *left, *right;                     /* k x k: singular vectors of C, [Yc Y] on the left */
    double *values;                           /* k */
    double *defect, *weights, *moved, *trial; /* k */
    double *matrix;                           /* k x k */
    double *y, *yp;                           /* the result in the form asked for */
    double *work;
    int lwork;
    int *pivots;
    void *memory, *more;
} start;

/* Memory of vectors over the whole state. */
static int allocate_state(start *s)
{
    const mbsr_model *m = s->w.m;
    const size_t nq = (size_t)m->nq, nu = (size_t)m->nu, size = (size_t)s->form->size(m);
    double **const array[] = {&s->q_given, &s->u_given, &s->q, &s->u,
                              &s->qdot,    &s->udot,    &s->y, &s->yp};
    const size_t length[] = {nq, nu, nq, nu, nq, nu, size, size};
    s->memory = mbsri_allocate(&m->allocator, (4 * (nq + nu) + 2 * size) * sizeof(double));
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
    s->lwork = mbsri_lapack_svd_work(s->w.k > 0 ? s->w.k : 1);
    double **const array[] = {&s->left,  &s->right, &s->values, &s->defect, &s->weights,
                              &s->moved, &s->trial, &s->matrix, &s->work};
    const size_t length[] = {k * k, k * k, k, k, k, k, k, k * k, (size_t)s->lwork};
    size_t total = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) total += length[l];
    s->more = mbsri_allocate(&m->allocator, total * sizeof(double) + k * sizeof(int));
    if (!s->more) {
        return mbsri_fail(&s->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %d null directions", s->w.k);
    }
    double *next = s->more;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    s->pivots = (int *)(void *)next;
    return MBSR_OK;
}

/* Names the joint to which null direction l belongs. */
static int undetermined(start *s, int l)
{
    const mbsr_model *m = s->w.m;
    char label[MBSRI_LABEL];
    const int i = s->w.body[l];
    return mbsri_fail(
        &s->w.d->error, MBSR_UNDETERMINED, m->body[i].id, MBSR_NONE,
        "mbsr_dae_consistent: %s: a combination of joint rates that includes its joint "
        "moves no mass, and neither a damper nor a spring resists it: give it "
        "inertia, a spring or a damper, or lock it",
        mbsri_body_label(m, i, label));
}

/* Basis, C and S at (q, u); [Yc Y] and the rank of C. Rows and columns of C are scaled to 1 where
 * they are not zero, so that units do not matter: Y = (row scales) (left singular vectors). */
static int split(start *s)
{
    mbsri_null_space *w = &s->w;
    const int k = w->k;
    int status = mbsri_null_basis(w, s->t, s->q, s->u);
    if (!status) status = mbsri_null_slopes(w, s->t, s->q, s->u);
    if (status) return status;
    mbsri_copy((size_t)k * (size_t)k, w->C, s->matrix);
    mbsri_scale_rows(k, s->matrix, s->trial);
    mbsri_scale_columns(k, s->matrix, s->moved);
    if (mbsri_lapack_svd(k, s->matrix, s->values, s->left, s->right, s->work, s->lwork) != 0) {
        return mbsri_fail(
            &w->d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
            "mbsr_dae_consistent: the singular values of the damping did not converge");
    }
    for (int c = 0; c < k; ++c) {
        for (int r = 0; r < k; ++r) s->left[c * k + r] *= s->trial[r];
    }
    s->damped = 0;
    while (s->damped < k && s->values[s->damped] > 1e-8) ++s->damped;
    return MBSR_OK;
}

/* out (k) = [Yc Y]^T x */
static void turn(const start *s, const double *x, double *out)
{
    mbsri_zero((size_t)s->w.k, out);
    mbsri_atx(s->w.k, s->w.k, 1.0, s->left, x, out);
}

/* matrix = Yc^T C over Y^T S */
static void fill_matrix(start *s)
{
    const int k = s->w.k;
    for (int c = 0; c < k; ++c) {
        double *column = s->matrix + (size_t)c * (size_t)k;
        turn(s, s->w.C + (size_t)c * (size_t)k, column);
        turn(s, s->w.S + (size_t)c * (size_t)k, s->trial);
        for (int r = s->damped; r < k; ++r) column[r] = s->trial[r];
    }
}

/* weights with matrix weights = right; a singular matrix means that something is undetermined. */
static int solve(start *s, const double *right)
{
    const int k = s->w.k;
    double *rows = s->trial, *columns = s->values;
    mbsri_scale_rows(k, s->matrix, rows);
    mbsri_scale_columns(k, s->matrix, columns);
    for (int r = 0; r < k; ++r) s->weights[r] = right[r] * rows[r];
    int rank = 0;
    const int info =
        mbsri_lapack_gelsy(k, k, s->matrix, s->weights, 1e-9, s->pivots, &rank, s->work, s->lwork);
    if (info != 0 || rank < k) {
        const int column = s->pivots[rank < k ? rank : k - 1]; /* 1 .. k, or 0 for a zero matrix */
        return undetermined(s, column > 0 ? column - 1 : 0);
    }
    for (int c = 0; c < k; ++c) s->weights[c] *= columns[c];
    return MBSR_OK;
}

/* ---- positions: Y^T gamma = 0 by Newton's method with step halving ---- */

static double elastic_defect(const start *s, const double *gamma, double *turned)
{
    turn(s, gamma, turned);
    return s->damped < s->w.k ? mbsri_largest(s->w.k - s->damped, turned + s->damped) : 0.0;
}

/* q + step q', with q' in qdot that of the direction in udot. */
static int try_step(start *s, double step, double *defect)
{
    mbsri_null_space *w = &s->w;
    for (int c = 0; c < w->m->nq; ++c) w->q[c] = s->q[c] + step * s->qdot[c];
    const int status = mbsri_null_gamma(w, s->t, w->q, s->u, s->moved);
    if (status) return status;
    *defect = elastic_defect(s, s->moved, s->trial);
    return MBSR_OK;
}

static int unbalanced(start *s, double force)
{
    const mbsri_null_space *w = &s->w;
    char label[MBSRI_LABEL];
    return mbsri_fail(
        &w->d->error, MBSR_NO_CONVERGENCE, w->m->body[w->body[0]].id, MBSR_NONE,
        "mbsr_dae_consistent: no position balances the springs at the massless joints, "
        "that of %s among them (force left: %g)",
        mbsri_body_label(w->m, w->body[0], label), force);
}

static int move_positions(start *s, double before)
{
    mbsri_null_space *w = &s->w;
    double after = INFINITY;
    for (double step = 1.0; step > 1e-3; step *= 0.5) {
        const int status = try_step(s, step, &after);
        if (status < 0) return status;
        if (status || !(after < before)) continue;
        for (int c = 0; c < w->m->nq; ++c) s->q[c] += step * s->qdot[c];
        return MBSR_OK;
    }
    return unbalanced(s, before);
}

static int find_positions(start *s)
{
    mbsri_null_space *w = &s->w;
    const int k = w->k;
    double last = INFINITY, first = 0.0;
    for (int step = 0; step < s->opt->max_iterations; ++step) {
        int status = split(s);
        if (!status) status = mbsri_null_gamma(w, s->t, s->q, s->u, s->defect);
        if (status) return status;
        if (step == 0) s->info.force_defect = mbsri_largest(k, s->defect);
        if (s->damped == k) return MBSR_OK;
        const double defect = elastic_defect(s, s->defect, s->moved);
        if (step == 0) first = defect;
        for (int r = 0; r < k; ++r) s->moved[r] = r < s->damped ? 0.0 : -s->moved[r];
        fill_matrix(s);
        status = solve(s, s->moved);
        /* springs that held at the start and have given way with the force still there */
        if (status == MBSR_UNDETERMINED && step > 0 && defect > 1e-3 * first)
            return unbalanced(s, defect);
        if (status) return status;
        mbsri_zero((size_t)w->m->nu, s->udot);
        mbsri_null_combine(w, s->weights, s->udot);
        status = mbsri_null_rate(w, s->t, s->q, s->udot, s->qdot);
        if (status) return status;
        const double change = mbsri_largest(w->m->nq, s->qdot),
                     size = 1.0 + mbsri_largest(w->m->nq, s->q);
        if (change <= s->opt->tolerance * size || (change > 0.25 * last && change <= 1e-8 * size)) {
            return MBSR_OK;
        }
        s->info.iterations += 1;
        status = move_positions(s, defect);
        if (status) return status;
        last = change;
    }
    return mbsri_fail(
        &w->d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
        "mbsr_dae_consistent: positions did not converge in %d iterations (last change %g)",
        s->opt->max_iterations, last);
}

/* ---- velocities: Yc^T gamma = 0 and Y^T gamma' = 0 ---- */

/* A time in which state and time change by about `share` of their size. */
static double short_time(const start *s, double share)
{
    const mbsr_model *m = s->w.m;
    const double speed = fmax(mbsri_largest(m->nq, s->qdot) / (1.0 + mbsri_largest(m->nq, s->q)),
                              mbsri_largest(m->nu, s->udot) / (1.0 + mbsri_largest(m->nu, s->u)));
    return share / fmax(1.0, speed);
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

/* out = gamma' along q' = G u with u held fixed. */
static int drift(start *s, double *out)
{
    int status = mbsri_null_rate(&s->w, s->t, s->q, s->u, s->qdot);
    if (status) return status;
    const double h = short_time(s, 1e-5);
    status = gamma_after(s, h, false, s->w.ahead);
    if (!status) status = gamma_after(s, -h, false, s->w.behind);
    for (int l = 0; l < s->w.k && !status; ++l)
        out[l] = (s->w.ahead[l] - s->w.behind[l]) / (2.0 * h);
    return status;
}

static int find_velocities(start *s)
{
    mbsri_null_space *w = &s->w;
    const mbsr_model *m = w->m;
    const int k = w->k;
    double last = INFINITY;
    mbsri_zero((size_t)m->nu, s->udot);
    for (int step = 0; step < s->opt->max_iterations; ++step) {
        int status = step > 0 ? mbsri_null_slopes(w, s->t, s->q, s->u) : MBSR_OK;
        if (!status) status = mbsri_null_gamma(w, s->t, s->q, s->u, s->trial);
        if (status) return status;
        turn(s, s->trial, s->moved);
        if (s->damped < k) {
            status = drift(s, s->trial);
            if (status) return status;
            turn(s, s->trial, s->defect);
            for (int r = s->damped; r < k; ++r) s->moved[r] = s->defect[r];
        }
        for (int r = 0; r < k; ++r) s->moved[r] = -s->moved[r];
        fill_matrix(s);
        status = solve(s, s->moved);
        if (status) return status;
        mbsri_zero((size_t)m->nu, w->force);
        mbsri_null_combine(w, s->weights, w->force);
        const double change = mbsri_largest(m->nu, w->force),
                     size = 1.0 + mbsri_largest(m->nu, s->u);
        for (int c = 0; c < m->nu; ++c) s->u[c] += w->force[c];
        s->info.iterations += 1;
        if (change <= s->opt->tolerance * size || (change > 0.25 * last && change <= 1e-6 * size)) {
            return MBSR_OK;
        }
        last = change;
    }
    return mbsri_fail(
        &w->d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
        "mbsr_dae_consistent: velocities did not converge in %d iterations (last change %g)",
        s->opt->max_iterations, last);
}

/* ---- accelerations: the equations of motion, Yc^T gamma' = 0 and Y^T gamma'' = 0 ---- */

/* out = [Yc^T gamma'; Y^T gamma''] along the motion with the present u'. */
static int defect_of_rates(start *s, double *out)
{
    mbsri_null_space *w = &s->w;
    const double h = short_time(s, 1e-4);
    int status = mbsri_null_gamma(w, s->t, s->q, s->u, s->defect);
    if (!status) status = gamma_after(s, h, true, w->ahead);
    if (!status) status = gamma_after(s, -h, true, w->behind);
    if (status) return status;
    for (int l = 0; l < w->k; ++l) s->trial[l] = (w->ahead[l] - w->behind[l]) / (2.0 * h);
    turn(s, s->trial, out);
    for (int l = 0; l < w->k; ++l) {
        s->trial[l] = (w->ahead[l] - 2.0 * s->defect[l] + w->behind[l]) / (h * h);
    }
    turn(s, s->trial, s->defect);
    for (int r = s->damped; r < w->k; ++r) out[r] = s->defect[r];
    return MBSR_OK;
}

/* The defect is affine in u': its slopes along the null directions by differences, one solve. */
static int null_rates(start *s)
{
    mbsri_null_space *w = &s->w;
    const mbsr_model *m = w->m;
    const int k = w->k;
    int status = defect_of_rates(s, s->moved);
    for (int l = 0; l < k && !status; ++l) {
        const double *a = w->direction + (size_t)l * (size_t)m->nu;
        double *column = s->matrix + (size_t)l * (size_t)k;
        const double h = (1.0 + mbsri_largest(m->nu, s->udot)) / mbsri_largest(m->nu, a);
        mbsri_ax(m->nu, 1, h, a, &(double){1.0}, s->udot);
        status = defect_of_rates(s, column);
        mbsri_ax(m->nu, 1, -h, a, &(double){1.0}, s->udot);
        for (int r = 0; r < k; ++r) column[r] = (column[r] - s->moved[r]) / h;
    }
    for (int r = 0; r < k; ++r) s->moved[r] = -s->moved[r];
    if (!status) status = solve(s, s->moved);
    if (!status) mbsri_null_combine(w, s->weights, s->udot);
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

/* Largest |gamma| at mbsr_backward. */
static double largest_gamma(const mbsr_model *m, const mbsr_data *d, double *force)
{
    double largest = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        const int rank = mbsri_group_rank(d, &g);
        const double *X = d->X + m->body[i].nn;
        if (rank == g.n) continue;
        mbsri_null_force(m, d, &g, d->e + g.ig, force);
        for (int l = rank; l < g.n; ++l) {
            double gamma = 0.0;
            for (int k = 0; k < g.n; ++k) gamma += d->s[g.ig + k] * X[l * g.n + k] * force[k];
            largest = fmax(largest, fabs(gamma));
        }
    }
    return largest;
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
    s->info.force_defect = largest_gamma(m, d, s->udot);
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

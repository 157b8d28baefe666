/* A consistent state of a model with closures.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * h(q, u, a) = M a + (bias - applied forces) is the inverse dynamics of the tree, K = [M -C^T; C 0] with
 * the rows that are independent.
 *
 *   positions      near the guess, with closed loops (assemble.c)
 *   velocities     K (du; Lambda) = (0; -(C u + g_t)): the momenta change by impulses of the loops alone
 *   u', lambda     K (u'; lambda) = (-h(q, u, 0); -(C' u + g_t'))
 *
 * Z spans the kernel of K in u: directions that move no mass and that no loop holds. Along them forces
 * balance, Z^T h = 0, at the velocities u + Z x, and d/dt (Z^T (h - C^T lambda)) = 0 along the motion,
 * with u' + Z x', u' and lambda of h - C^T lambda held; Z may be held because h - C^T lambda is zero. x
 * and x' are found by Newton's method, with differences of h.
 *
 * Stiff rows count as rigid here (unless the closure is not settled: then they are forces); afterwards
 * their springs get the force that was found, s = -lambda, and the positions the gaps s / k. */
#include "loops/start.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/assemble.h"
#include "loops/ranks.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"

#include <math.h>

/* h - C^T lambda at (t, q, u) and accelerations a, into r (n); lambda may be NULL. */
static int missing(mbsri_dense *w, double t, const double *q, const double *u, const double *tau,
                   const double *a, const double *lambda, double *r)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_forces(m, d, tau);
    if (status) return status;
    mbsri_inverse(m, d, a);
    mbsri_scatter(m, d->out, r);
    if (!lambda) return MBSR_OK;
    status = mbsri_closure_jacobians(m, d);
    if (status) return status;
    mbsri_closure_transpose(m, d, lambda, w->y);
    for (int k = 0; k < w->n; ++k) r[k] -= w->y[k];
    return MBSR_OK;
}

/* The closure whose row among `x` (rows) is the largest. */
static int widest(const mbsr_model *m, const double *x, double *value)
{
    const mbsri_closure *first = m->closures.data;
    int found = 0;
    *value = 0.0;
    for (int id = 0; id < (int)m->closures.count; ++id) {
        const double own = mbsri_largest(first[id].rows, x + first[id].row);
        if (own > *value) {
            *value = own;
            found = id;
        }
    }
    return found;
}

/* Rows that stay although the equations are solved contradict each other. */
static int contradiction(mbsri_dense *w, const double *left, double size, const char *what)
{
    double value;
    char label[MBSRI_LABEL];
    const int id = widest(w->m, left, &value);
    if (value <= 1e-7 * (1.0 + size)) return MBSR_OK;
    return mbsri_fail(&w->d->error, MBSR_LOOP_OPEN, MBSR_NONE, MBSR_NONE,
                      "%s: %s: its %s cannot be met, %.3g is left: closures or motions "
                      "contradict each other",
                      w->function, mbsri_closure_label(w->m, id, label), what, value);
}

/* Rows that are springs left alone count for nothing. */
static void clear_loose(const mbsr_model *m, double *x)
{
    const mbsri_closure *first = m->closures.data;
    for (const mbsri_closure *c = first; c < first + m->closures.count; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            if (mbsri_is_loose(c, k)) x[c->row + k] = 0.0;
        }
    }
}

/* The rows that K does without. */
static void leave_out(mbsri_dense *w)
{
    const mbsri_closure *first = w->m->closures.data;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            const int row = c->row + k;
            w->left_out[row] = w->d->dropped[row] || mbsri_is_loose(c, k);
        }
    }
}

/* K at (q, u). */
static int factor(mbsri_dense *w, double t, const double *q, const double *u)
{
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_velocities(w->m, w->d, u);
    return status ? status : mbsri_dense_factor(w, w->left_out);
}

static int find_velocities(mbsri_dense *w, double t, const double *q, double *u)
{
    const size_t n = (size_t)w->n;
    int status = factor(w, t, q, u);
    double *rate = w->g + n;
    mbsri_zero((size_t)w->N, w->g);
    if (!status) status = mbsri_closure_rates(w->m, w->d, rate);
    if (status) return status;
    clear_loose(w->m, rate);
    const double size = mbsri_largest(w->rows, rate);
    for (int k = 0; k < w->rows; ++k) rate[k] = w->left_out[k] ? 0.0 : -rate[k];
    mbsri_dense_solve(w, w->g, w->x);
    for (size_t k = 0; k < n; ++k) u[k] += w->x[k];
    status = mbsri_velocities(w->m, w->d, u);
    if (!status) status = mbsri_closure_rates(w->m, w->d, rate);
    if (status) return status;
    clear_loose(w->m, rate);
    return contradiction(w, rate, size, "velocity row");
}

/* The first large entry of a direction, for a text. */
static int refuse_direction(mbsri_dense *w, const double *x, const char *why)
{
    const mbsr_model *m = w->m;
    char label[MBSRI_LABEL];
    int largest = 0, at = 1;
    for (int k = 0; k < w->n; ++k) {
        if (fabs(x[k]) > fabs(x[largest])) largest = k;
    }
    for (int i = 1; i <= m->bodies; ++i) {
        if (largest >= m->body[i].u && largest < m->body[i].u + m->body[i].n) at = i;
    }
    return mbsri_fail(&w->d->error, MBSR_UNDETERMINED, m->body[at].id, MBSR_NONE,
                      "%s: u%d of %s moves no mass, no loop holds it%s", w->function,
                      largest - m->body[at].u, mbsri_body_label(m, at, label), why);
}

/* ---- directions that no loop holds ---- */

/* What the search for x or x' works on; vectors behind one another in one block. */
typedef struct balance {
    mbsri_dense *w;
    double t;
    const double *q;
    double *u, *udot, *lambda;
    int k;
    double *Z;                /* n x k */
    double *S;                /* k x k */
    double *r, *r_try;        /* k: Z^T (.) */
    double *moved, *h, *u_at; /* n */
    double *still;            /* n: zeros */
    double *q_at;             /* nq */
    void *memory;
} balance;

/* Z^T h at the velocities v. */
static int by_velocities(balance *b, const double *v, double *r)
{
    mbsri_dense *w = b->w;
    const int status = missing(w, b->t, b->q, v, NULL, b->still, NULL, b->h);
    for (int l = 0; l < b->k; ++l) r[l] = mbsri_dot(w->n, b->Z + (size_t)l * (size_t)w->n, b->h);
    return status;
}

/* d/dt of Z^T (h - C^T lambda) along the motion with accelerations a. */
static int by_rates(balance *b, const double *a, double *r)
{
    mbsri_dense *w = b->w;
    const mbsr_model *m = w->m;
    const double speed = fmax(1.0, mbsri_largest(w->n, b->u)),
                 h = mbsri_difference_step(0.0) / speed;
    mbsri_zero((size_t)b->k, r);
    for (int l = 0; l < 4; ++l) {
        const double to = mbsri_difference_place(l) * h;
        int status = mbsri_positions(m, w->d, b->t, b->q);
        if (!status) status = mbsri_displace(w, b->q, to, b->u, b->q_at);
        for (int k = 0; k < w->n; ++k) b->u_at[k] = b->u[k] + to * a[k];
        if (!status) status = missing(w, b->t + to, b->q_at, b->u_at, NULL, a, b->lambda, b->h);
        if (status) return status;
        for (int j = 0; j < b->k; ++j)
            r[j] += mbsri_difference_weight(l) / (12.0 * h) *
                    mbsri_dot(w->n, b->Z + (size_t)j * (size_t)w->n, b->h);
    }
    return MBSR_OK;
}

/* One Newton step of v = u or u' along Z towards f(v) = 0; *change: its size. */
static int step(balance *b, int (*f)(balance *, const double *, double *), double *v,
                double *change)
{
    mbsri_dense *w = b->w;
    const int n = w->n, k = b->k;
    int status = f(b, v, b->r), rank;
    const double size = fmax(1.0, mbsri_largest(n, v)), h = 1e-4 * size;
    for (int l = 0; l < k && !status; ++l) {
        double *column = b->S + (size_t)l * (size_t)k;
        for (int side = -1; side <= 1 && !status; side += 2) {
            for (int j = 0; j < n; ++j)
                b->moved[j] = v[j] + side * h * b->Z[(size_t)l * (size_t)n + (size_t)j];
            status = f(b, b->moved, side < 0 ? b->r_try : column);
        }
        for (int j = 0; j < k; ++j) column[j] = (column[j] - b->r_try[j]) / (2.0 * h);
    }
    if (status) return status;
    const double steepest = mbsri_largest(k * k, b->S);
    if (mbsri_lapack_gelsy(k, k, b->S, b->r, 1e-8, w->pivots, &rank, w->work, w->lwork) ||
        rank < k || !(steepest > 0.0))
        return refuse_direction(w, b->Z,
                                ", and no damper: springs alone, or nothing, determine it");
    *change = mbsri_largest(k, b->r) / size;
    for (int l = 0; l < k; ++l) {
        for (int j = 0; j < n; ++j) v[j] -= b->r[l] * b->Z[(size_t)l * (size_t)n + (size_t)j];
    }
    return MBSR_OK;
}

static int iterate(balance *b, int (*f)(balance *, const double *, double *), double *v,
                   const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    double change = INFINITY, last = INFINITY;
    for (int i = 0; i < opt->max_iterations; ++i) {
        const int status = step(b, f, v, &change);
        if (status) return status;
        ++info->iterations;
        if (i == 0 && f == by_velocities) info->force_defect = mbsri_largest(b->k, b->r_try);
        if (change <= opt->tolerance || (change < 1e-7 && change >= last)) return MBSR_OK;
        last = change;
    }
    return mbsri_fail(
        &b->w->d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
        "%s: no velocities found at which forces along directions without mass balance",
        b->w->function);
}

static int open_balance(balance *b)
{
    mbsri_dense *w = b->w;
    const size_t n = (size_t)w->n, k = (size_t)w->nulls, nq = (size_t)w->m->nq;
    b->k = w->nulls;
    b->memory =
        mbsri_allocate(&w->m->allocator, (n * k + k * k + 2 * k + 4 * n + nq + 1) * sizeof(double));
    if (!b->memory)
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d directions without mass", w->function, b->k);
    double *next = b->memory;
    b->Z = next;
    b->S = b->Z + n * k;
    b->r = b->S + k * k;
    b->r_try = b->r + k;
    b->moved = b->r_try + k;
    b->h = b->moved + n;
    b->u_at = b->h + n;
    b->still = b->u_at + n;
    b->q_at = b->still + n;
    mbsri_zero(n, b->still);
    for (int l = 0; l < b->k; ++l) mbsri_dense_null(w, l, b->Z + (size_t)l * n);
    return MBSR_OK;
}

/* ---- accelerations ---- */

/* K (u'; lambda) = (-h; -bias), K factored; the data at the velocities. */
static int solve_rates(mbsri_dense *w, double t, const double *q, const double *u,
                       const double *tau, double *udot, double *lambda)
{
    const size_t n = (size_t)w->n;
    double *right = w->g, *bias = right + n;
    mbsri_zero(n, w->x);
    int status = missing(w, t, q, u, tau, w->x, NULL, right);
    if (!status) status = mbsri_closure_jacobians(w->m, w->d);
    if (!status) status = mbsri_closure_bias(w->m, w->d, bias);
    if (status) return status;
    clear_loose(w->m, bias);
    for (size_t k = 0; k < n; ++k) right[k] = -right[k];
    for (int k = 0; k < w->rows; ++k) bias[k] = w->left_out[k] ? 0.0 : -bias[k];
    mbsri_dense_solve(w, right, w->x);
    mbsri_copy(n, w->x, udot);
    mbsri_copy((size_t)w->rows, w->x + n, lambda);
    /* all rows, those left out as well */
    status = mbsri_closure_bias(w->m, w->d, bias);
    if (status) return status;
    const double size = mbsri_largest(w->rows, bias) + mbsri_largest(w->n, udot);
    mbsri_closure_apply(w->m, w->d, udot, w->y);
    for (int k = 0; k < w->rows; ++k) bias[k] += w->y[k];
    clear_loose(w->m, bias);
    return contradiction(w, bias, size, "acceleration");
}

/* Forces of springs left alone, by their law, into their rows of lambda. */
static void add_loose(const mbsri_dense *w, double *lambda)
{
    const mbsri_closure *first = w->m->closures.data;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            if (mbsri_is_loose(c, k)) lambda[c->row + k] = w->d->loop_lambda[c->row + k];
        }
    }
}

int mbsri_loops_accelerate(mbsri_dense *w, double t, const double *q, const double *u,
                           const double *tau, double *udot, double *lambda)
{
    const mbsri_closure *first = w->m->closures.data;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->rows; ++k) w->left_out[c->row + k] = mbsri_is_stiff(c, k);
    }
    int status = factor(w, t, q, u);
    for (int l = 0; l < w->nulls && !status; ++l) {
        if (mbsri_dense_null(w, l, w->x) > 1e-6)
            status = refuse_direction(w, w->x, ": its acceleration is not determined");
    }
    if (!status) status = solve_rates(w, t, q, u, tau, udot, lambda);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count && !status; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            if (mbsri_is_stiff(c, k)) lambda[c->row + k] = w->d->loop_lambda[c->row + k];
        }
    }
    return status;
}

/* The data at (q, u) with the loop forces lambda, and accelerations. */
static int settle(mbsri_dense *w, const double *tau, const double *udot, const double *lambda)
{
    mbsr_data *d = w->d;
    int status = mbsri_closure_jacobians(w->m, d);
    mbsri_copy((size_t)w->rows, lambda, d->loop_lambda);
    d->loaded = true;
    if (!status) status = mbsri_forces(w->m, d, tau);
    if (status) return status;
    mbsri_inverse(w->m, d, udot);
    return MBSR_OK;
}

int mbsri_loops_forward(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                        const double *u, const double *tau, double *udot)
{
    static const char name[] = "mbsr_forward_dynamics";
    mbsri_dense w;
    int status = mbsri_check_input(d, (size_t)m->nu, u, name, "u");
    if (status) return status;
    status = mbsri_dense_open(&w, m, d, name);
    if (!status) {
        double *found = w.out, *lambda = w.out + w.n;
        status = mbsri_loops_accelerate(&w, t, q, u, tau, found, lambda);
        if (!status) status = settle(&w, tau, found, lambda);
        if (!status) status = mbsri_check_result(m, d, (size_t)m->nu, found, name);
        if (!status) mbsri_copy((size_t)m->nu, found, udot);
    }
    mbsri_dense_close(&w);
    return status;
}

/* ---- the start ---- */

/* Velocities and rates at the positions q. */
static int find_motion(mbsri_dense *w, double t, const double *q, double *u, double *udot,
                       double *lambda, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    balance b = {.w = w, .t = t, .q = q, .u = u, .udot = udot, .lambda = lambda};
    int status = find_velocities(w, t, q, u);
    info->null_directions = w->nulls;
    if (!status) status = open_balance(&b);
    if (!status && b.k > 0) status = iterate(&b, by_velocities, u, opt, info);
    if (!status) status = solve_rates(w, t, q, u, NULL, udot, lambda);
    if (!status) add_loose(w, lambda);
    if (!status && b.k > 0) status = iterate(&b, by_rates, udot, opt, info);
    mbsri_release(&w->m->allocator, b.memory);
    return status;
}

/* Gaps at which the springs of settled rows have their forces; whether they are others than before. */
static bool load_springs(mbsri_dense *w, const double *lambda)
{
    const mbsri_closure *first = w->m->closures.data;
    bool any = false;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->held; ++k) {
            if (!mbsri_is_stiff(c, k) || mbsri_is_loose(c, k)) continue;
            const double gap = -lambda[c->row + k] / c->def.stiffness[k];
            any = any || fabs(gap - w->offset[c->held_row + k]) > 1e-14;
            w->offset[c->held_row + k] = gap;
        }
    }
    return any;
}

/* Forces of settled springs at the gaps that they have been given. */
static void take_springs(const mbsri_dense *w, double *lambda)
{
    const mbsri_closure *first = w->m->closures.data;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->held; ++k) {
            if (mbsri_is_stiff(c, k) && !mbsri_is_loose(c, k))
                lambda[c->row + k] = -w->offset[c->held_row + k] * c->def.stiffness[k];
        }
    }
}

/* Springs and positions are found in turn, as often at most. */
enum { PASSES = 12 };

int mbsri_loops_consistent(mbsri_dense *w, double t, double *q, double *u, double *udot,
                           double *lambda, const mbsr_consistent_opt *opt,
                           mbsr_consistent_info *info)
{
    const mbsr_assembly_opt standard = mbsri_assembly_standard();
    mbsr_assembly_info assembly;
    mbsri_ranks here;
    int nearby;
    int status = mbsri_assemble(w, t, q, &standard, &assembly);
    if (!status) status = mbsri_ranks_around(w, t, q, w->d->dropped, &here, &nearby);
    if (status) return status;
    info->iterations = assembly.iterations;
    leave_out(w);
    for (int pass = 0; pass < PASSES && !status; ++pass) {
        status = find_motion(w, t, q, u, udot, lambda, opt, info);
        if (status || pass + 1 == PASSES || !load_springs(w, lambda)) break;
        status = mbsri_assemble(w, t, q, &standard, &assembly);
    }
    take_springs(w, lambda);
    return status;
}

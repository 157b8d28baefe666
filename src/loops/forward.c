/* Forward and inverse dynamics of models with closures, in O(bodies + loops).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   forward     M u' - C^T lambda = -h(q, u, 0),   C u' = -bias
 *   impulses    M du - C^T Lambda = 0,   C du = -(C u + g_t)
 *   inverse     B tau + C^T lambda = need with least |tau|:  tau = B^T x,
 *       B B^T x + C^T lambda = need,   C x = 0
 *
 * with the rigid rows C; springs of stiff ones are forces. Both are solved along the tree
 * (fronts/fronts.h), the second one for a tree whose only masses are a unit of armature at each
 * joint rate that is actuated. */
#include "loops/forward.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "loops/refuse.h"
#include "fronts/fronts.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/sizes.h"
#include "recursion/spans.h"

#include <math.h>

/* A motion over spans: rates from .. to - 1, the others are zero. */
typedef struct free_motion {
    int from, to;
    double *rate;
} free_motion;

typedef struct forward {
    const mbsr_model *m;
    mbsr_data *d;
    const char *function; /* for messages */
    bool settled;         /* stiff rows are springs where they are left out alone */
    const double *span;   /* nu: of joint rates; NULL: `load` is not wanted */
    double load;          /* the largest of what acts, along it */
    free_motion *free;    /* those that nothing determines */
    int frees;
    mbsri_fronts system;
    double *udot, *right, *more;                          /* nu */
    double *lambda, *springs, *bias, *rate, *more_lambda; /* rows */
} forward;

/* left_out (rows; NULL: none): rows without a part in the equations, beside springs; if `settled`
 * these alone, and springs among them. */
static int open_forward(forward *w, const mbsr_model *m, mbsr_data *d, const bool *left_out,
                        bool settled, const char *function)
{
    const size_t nu = (size_t)m->nu, rows = (size_t)m->rows;
    *w = (forward){.m = m, .d = d, .function = function, .settled = settled};
    int status = mbsri_fronts_open(&w->system, m, d, true, function);
    if (status) return status;
    for (int k = 0; k < m->rows && left_out; ++k)
        w->system.left_out[k] = left_out[k] || (!settled && w->system.left_out[k]);
    w->udot = mbsri_fronts_allocate(&w->system, (3 * nu + 5 * rows) * sizeof(double));
    if (!w->udot)
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d rows of closures", function, m->rows);
    w->right = w->udot + nu;
    w->lambda = w->right + nu;
    w->springs = w->lambda + rows;
    w->bias = w->springs + rows;
    w->rate = w->bias + rows;
    w->more_lambda = w->rate + rows;
    w->more = w->more_lambda + rows;
    return MBSR_OK;
}

/* Whether row k of a closure is a spring in these equations. */
static bool is_spring(const forward *w, const mbsri_closure *c, int k)
{
    return mbsri_is_stiff(c, k) && (!w->settled || w->system.left_out[c->row + k]);
}

/* Zero in rows of springs, or in all others. */
static void clear_rows(const forward *w, bool springs, double *row)
{
    const mbsri_closure *c = w->m->closures.data;
    for (size_t id = 0; id < w->m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k) {
            if (is_spring(w, c, k) == springs) row[c->row + k] = 0.0;
        }
    }
}

/* -h(q, u, 0) and -bias, with the forces of springs. */
static int find_right(forward *w, double t, const double *q, const double *u, const double *tau)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_closure_springs(m, d);
    if (status) return status;
    clear_rows(w, false, d->loop_lambda);
    mbsri_copy((size_t)m->rows, d->loop_lambda, w->springs);
    status = mbsri_forces(m, d, tau, d->loop_lambda);
    if (status) return status;
    mbsri_zero((size_t)m->nu, w->udot);
    mbsri_inverse(m, d, w->udot);
    mbsri_scatter(m, d->out, w->right);
    for (int k = 0; k < m->nu; ++k) w->right[k] = -w->right[k];
    status = mbsri_closure_bias(m, d, w->bias);
    for (int k = 0; k < m->rows; ++k) w->rate[k] = -w->bias[k];
    return status;
}

/* The forces of loops join the others, and accelerations. */
static int settle_forces(forward *w)
{
    mbsr_data *d = w->d;
    for (int k = 0; k < w->m->rows; ++k) d->loop_lambda[k] = w->lambda[k] + w->springs[k];
    mbsri_closure_load(w->m, d, w->lambda, d->f, d->tau);
    mbsri_inverse(w->m, d, w->udot);
    return mbsri_check_result(w->m, d, (size_t)w->m->nu, w->udot, w->function);
}

/* The equations factored, refused where a motion (of the name `what`) is not determined. */
static int factor_loops(forward *w, const char *what)
{
    const int status = mbsri_fronts_factor(&w->system, NULL, w->function);
    if (status || w->settled || w->system.frees == 0) return status;
    return mbsri_refuse_motion(w->m, w->d, mbsri_fronts_free_rate(&w->system), w->function, what);
}

/* What is left of the rows, C u' + bias, into w->rate. */
static void find_left(forward *w)
{
    mbsri_closure_apply(w->m, w->d, w->udot, w->rate);
    for (int k = 0; k < w->m->rows; ++k) w->rate[k] += w->bias[k];
    clear_rows(w, true, w->rate);
}

/* ---- motions that nothing determines ---- */

static double product_of(const free_motion *a, const double *x)
{
    return mbsri_dot(a->to - a->from, a->rate, x + a->from);
}

/* A motion (nu, over spans) less what it has of those before, twice, and of size 1, or nothing
 * where it depends on them. */
static void make_orthonormal(const forward *w, double *x)
{
    static const double rounding = 1e-9; /* of a motion that depends on others */
    const int nu = w->m->nu;
    const double whole = sqrt(mbsri_dot(nu, x, x));
    for (int pass = 0; pass < 2; ++pass) {
        for (int l = 0; l < w->frees; ++l) {
            const free_motion *a = w->free + l;
            const double part = product_of(a, x);
            for (int j = a->from; j < a->to && part != 0.0; ++j)
                x[j] -= part * a->rate[j - a->from];
        }
    }
    const double size = sqrt(mbsri_dot(nu, x, x));
    for (int j = 0; j < nu; ++j) x[j] = size > rounding * whole ? x[j] / size : 0.0;
}

/* Adds a motion (nu, over spans) without what is rounding in it. */
static bool keep_motion(forward *w, const double *x)
{
    static const double rounding = 1e-14;
    int from = 0, to = w->m->nu;
    while (from < to && fabs(x[from]) <= rounding) ++from;
    while (from < to && fabs(x[to - 1]) <= rounding) --to;
    double *rate = mbsri_fronts_allocate(&w->system, (size_t)(to - from + 1) * sizeof *rate);
    if (!rate) return false;
    mbsri_copy((size_t)(to - from), x + from, rate);
    w->free[w->frees++] = (free_motion){from, to, rate};
    return true;
}

/* As many motions as nothing determines, each of size 1 and at right angles to the others: each
 * begins at a joint, and most have rates near it alone. */
static int find_free(forward *w)
{
    const mbsr_model *m = w->m;
    const size_t nu = (size_t)m->nu, frees = (size_t)w->system.frees;
    const size_t work_size = 2 * nu + (size_t)m->rows + 2 * m->size.v;
    double *x = mbsri_fronts_allocate(&w->system,
                                      (2 * nu + work_size) * sizeof *x + frees * sizeof *w->free);
    double *seed = x ? x + nu : NULL, *work = x ? seed + nu : NULL;
    w->free = x ? (free_motion *)(void *)(work + work_size) : NULL;
    bool room = x != NULL;
    for (int l = 0; l < w->system.frees && room; ++l) {
        mbsri_fronts_free_seed(&w->system, l, seed);
        for (int pass = 0; pass < 2; ++pass) mbsri_fronts_leave_free(&w->system, seed, work);
        mbsri_scatter(m, seed, x);
        for (size_t k = 0; k < nu; ++k) x[k] /= w->span[k];
        make_orthonormal(w, x);
        room = keep_motion(w, x);
    }
    if (room) return MBSR_OK;
    return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for %d motions that nothing determines", w->function,
                      w->system.frees);
}

/* Takes from `right` what acts along motions that nothing determines. */
static void leave_free_forces(forward *w)
{
    for (int l = 0; l < w->frees; ++l) {
        const free_motion *a = w->free + l;
        double along = 0.0;
        for (int j = a->from; j < a->to; ++j)
            along += a->rate[j - a->from] * w->span[j] * w->right[j];
        for (int j = a->from; j < a->to; ++j)
            w->right[j] -= along * a->rate[j - a->from] / w->span[j];
    }
}

/* u' and lambda from what is left of the equations. */
static void refine(forward *w)
{
    const mbsr_model *m = w->m;
    mbsri_inverse(m, w->d, w->udot);
    mbsri_scatter(m, w->d->out, w->more);
    mbsri_closure_transpose(m, w->d, w->lambda, w->right);
    for (int k = 0; k < m->nu; ++k) w->right[k] -= w->more[k];
    leave_free_forces(w);
    find_left(w);
    for (int k = 0; k < m->rows; ++k) w->rate[k] = -w->rate[k];
    mbsri_fronts_solve(&w->system, w->right, w->rate, w->more, w->more_lambda);
    for (int k = 0; k < m->nu; ++k) w->udot[k] += w->more[k];
    for (int k = 0; k < m->rows; ++k) w->lambda[k] += w->more_lambda[k];
}

/* The largest works of w->right and of what is left of the balance of forces, along the spans of
 * rates. */
typedef struct works {
    double load, left;
} works;

static works find_works(const forward *w)
{
    const mbsr_model *m = w->m;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    works x = {0.0, 0.0};
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k) {
            const double span = mbsri_coordinate_span(&spans, m, b, true, k);
            x.load = fmax(x.load, span * fabs(w->right[b->u + k]));
            x.left = fmax(x.left, span * fabs(w->d->out[b->iu + k]));
        }
    }
    return x;
}

/* What accelerations are of which rounding of sums may be left: of the motion, of a model that is
 * as fast as is typical, and of what acts on all its mass. */
static double size_of_accelerations(const forward *w, double work, const double *u)
{
    const mbsr_model *m = w->m;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    const double own = m->typical.frequency, moves = mbsri_largest_rate(m, u),
                 inertia = m->typical.mass * spans.length * spans.length;
    return own * own + moves * moves + (inertia > 0.0 ? work / inertia : 0.0);
}

static int check_left(forward *w, double size)
{
    size += mbsri_largest_row(w->m, w->bias, w->system.share) + mbsri_largest_rate(w->m, w->udot);
    find_left(w);
    return mbsri_refuse_left(w->m, w->d, w->rate, w->system.share, size, "acceleration",
                             w->function);
}

/* The largest work of what acts on a body or joint by itself, before anything cancels, along the
 * spans of rates. */
static double find_load(const forward *w)
{
    const mbsr_data *d = w->d;
    double *size = d->scratch, largest = 0.0;
    for (int i = 1; i <= w->m->bodies; ++i) {
        const mbsri_body *b = w->m->body + i;
        for (int r = 0; r < b->d; ++r) size[r] = fabs(d->f[b->v + (size_t)r]);
        for (int k = 0; k < b->n; ++k)
            largest = fmax(largest, mbsri_joint_size(b, d, k, size) * w->span[b->u + k]);
    }
    return largest;
}

static int refuse_balance(const forward *w, double share)
{
    return mbsri_fail(&w->d->error, MBSR_LOOP_SINGULAR, MBSR_NONE, MBSR_NONE,
                      "%s: %.3g of the forces is left at the accelerations found: rows of closures "
                      "nearly depend on each other at t = %g",
                      w->function, share, w->d->t);
}

/* The forces of loops settle; where their small pivots have lost digits of the balance of forces,
 * what is left of it leads to better ones. */
static int settle_balance(forward *w, double load, double size)
{
    enum { TRIES = 4 };
    static const double rounding = 1e-11, usual = 1e-6;
    const mbsr_model *m = w->m;
    double before = INFINITY;
    int status = settle_forces(w);
    if (status || w->settled) return status;
    double left = find_works(w).left;
    if (left <= rounding * load) return MBSR_OK;
    mbsri_closure_transpose(m, w->d, w->lambda, w->right);
    load = fmax(load, find_works(w).load);
    for (int tries = 0; left > rounding * load; ++tries) {
        if (left > 0.5 * before || tries == TRIES)
            return left <= usual * load ? MBSR_OK : refuse_balance(w, left / load);
        before = left;
        for (int k = 0; k < m->rows; ++k) w->more_lambda[k] = -w->lambda[k];
        mbsri_closure_load(m, w->d, w->more_lambda, w->d->f, w->d->tau);
        refine(w);
        status = check_left(w, size);
        if (!status) status = settle_forces(w);
        if (status) return status;
        left = find_works(w).left;
    }
    return MBSR_OK;
}

static int accelerate(forward *w, double t, const double *q, const double *u, const double *tau)
{
    int status = find_right(w, t, q, u, tau);
    if (!status) status = factor_loops(w, ": its acceleration is not determined");
    if (status) return status;
    if (w->span) w->load = find_load(w);
    if (w->settled && w->system.frees > 0) status = find_free(w);
    if (status) return status;
    leave_free_forces(w);
    const double load = find_works(w).load, size = size_of_accelerations(w, load, u);
    const mbsr_error before = w->d->error;
    mbsri_fronts_solve(&w->system, w->right, w->rate, w->udot, w->lambda);
    status = check_left(w, size);
    if (status || w->settled) {
        w->d->error = before;
        refine(w);
        status = check_left(w, size);
    }
    return status ? status : settle_balance(w, load, size);
}

int mbsri_loops_forward(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                        const double *u, const double *tau, const bool *left_out, double *udot,
                        const char *function)
{
    forward w;
    int status = mbsri_check_input(d, (size_t)m->nu, u, function, "u");
    if (status) return status;
    status = open_forward(&w, m, d, left_out, false, function);
    if (!status) status = accelerate(&w, t, q, u, tau);
    if (!status) mbsri_copy((size_t)m->nu, w.udot, udot);
    mbsri_fronts_close(&w.system);
    return status;
}

int mbsri_loops_settled(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                        const double *u, const bool *left_out, const double *span, double *lambda,
                        double *doubt, double *load, const char *function)
{
    forward w;
    int status = open_forward(&w, m, d, left_out, true, function);
    w.span = span;
    if (!status) status = accelerate(&w, t, q, u, NULL);
    if (!status) mbsri_copy((size_t)m->rows, w.lambda, lambda);
    if (!status) mbsri_copy((size_t)m->rows, w.more_lambda, doubt);
    *load = w.load;
    mbsri_fronts_close(&w.system);
    return status;
}

int mbsri_loops_take_springs(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                             const double *u, const bool *those, double *lambda)
{
    const mbsri_closure *c = m->closures.data;
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_closure_springs(m, d);
    for (size_t id = 0; id < m->closures.count && !status; ++id, ++c) {
        for (int k = 0, row = c->row; k < c->rows; ++k, ++row) {
            if (mbsri_is_stiff(c, k) && (!those || those[row])) lambda[row] = d->loop_lambda[row];
        }
    }
    return status;
}

int mbsri_loops_count_free(const mbsr_model *m, mbsr_data *d, const bool *left_out, bool settled,
                           const char *function, int *count)
{
    forward w;
    int status = open_forward(&w, m, d, left_out, settled, function);
    if (!status) status = mbsri_closure_jacobians(m, d);
    if (!status) status = mbsri_fronts_factor(&w.system, NULL, function);
    *count = status ? 0 : w.system.frees;
    mbsri_fronts_close(&w.system);
    return status;
}

/* ---- impulses ---- */

/* C u + g_t of rigid rows, into w->rate. */
static int find_row_rates(forward *w, const double *u)
{
    int status = mbsri_velocities(w->m, w->d, u);
    if (!status) status = mbsri_closure_rates(w->m, w->d, w->rate);
    if (!status) clear_rows(w, true, w->rate);
    return status;
}

/* Twice, so that what is left is rounding of C u. */
static int push_to_rows(forward *w, double t, const double *q, double *u)
{
    enum { PASSES = 2 };
    const mbsr_model *m = w->m;
    int status = mbsri_positions(m, w->d, t, q);
    if (!status) status = mbsri_velocities(m, w->d, u);
    if (!status) status = mbsri_closure_jacobians(m, w->d);
    if (!status) status = factor_loops(w, ": its velocity is not determined");
    mbsri_zero((size_t)m->nu, w->right);
    double size = m->typical.frequency + mbsri_largest_rate(m, u);
    for (int pass = 0; pass < PASSES && !status; ++pass) {
        status = find_row_rates(w, u);
        if (status) return status;
        size = fmax(size, mbsri_largest_row(m, w->rate, w->system.share));
        for (int k = 0; k < m->rows; ++k) w->bias[k] = -w->rate[k];
        mbsri_fronts_solve(&w->system, w->right, w->bias, w->udot, w->lambda);
        for (int k = 0; k < m->nu; ++k) u[k] += w->udot[k];
    }
    if (!status) status = find_row_rates(w, u);
    if (status) return status;
    return mbsri_refuse_left(m, w->d, w->rate, w->system.share, size + mbsri_largest_rate(m, u),
                             "velocity row", w->function);
}

int mbsri_loops_push(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                     const bool *left_out, double *u, const char *function)
{
    forward w;
    int status = open_forward(&w, m, d, left_out, false, function);
    if (!status) status = push_to_rows(&w, t, q, u);
    mbsri_fronts_close(&w.system);
    return status;
}

/* ---- inverse dynamics ---- */

/* What of `need` is not there: refused, with the joint that misses most; forces count by the length
 * of the model. */
static int check_torques(const mbsr_model *m, mbsr_data *d, const double *need, double *left,
                         const char *function)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    char label[MBSRI_LABEL];
    double size = 0.0, most = 0.0;
    int at = 1, k = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const double load = mbsri_joint_load(&spans, m, b, left + b->u);
        size = fmax(size, mbsri_joint_load(&spans, m, b, need + b->u));
        if (load >= most) at = i;
        most = fmax(most, load);
    }
    if (most <= 1e-8 * size) return MBSR_OK;
    const mbsri_body *b = m->body + at;
    while (fabs(left[b->u + k]) * mbsri_coordinate_span(&spans, m, b, true, k) < most) ++k;
    return mbsri_fail(&d->error, MBSR_UNDETERMINED, m->body[at].id, MBSR_NONE,
                      "%s: the joints listed cannot bring about udot: u%d of %s, or what the loops "
                      "couple it to, is driven by none of them (%.3g is missing)",
                      function, k, mbsri_body_label(m, at, label), fabs(left[b->u + k]));
}

/* tau and -lambda from the solution. */
static int take_torques(mbsri_fronts *s, const double *actuated, const double *need, double *tau,
                        double *lambda, double *left, const char *function)
{
    const mbsr_model *m = s->m;
    mbsri_gather(m, left, s->e);
    for (int k = 0; k < m->nu; ++k) s->e[k] *= actuated[k];
    mbsri_scatter(m, s->e, tau);
    for (int k = 0; k < m->rows; ++k) lambda[k] = -lambda[k];
    mbsri_closure_transpose(m, s->d, lambda, left);
    for (int k = 0; k < m->nu; ++k) left[k] = need[k] - tau[k] - left[k];
    const int status = check_torques(m, s->d, need, left, function);
    const mbsri_closure *c = m->closures.data;
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = c->row; k < c->row + c->rows; ++k)
            if (mbsri_is_stiff(c, k - c->row)) lambda[k] = s->d->loop_lambda[k];
    }
    return status;
}

/* Of a tree without loops. */
static int actuate_tree(const mbsr_model *m, mbsr_data *d, const mbsr_motors *motors,
                        const double *need, double *tau, const char *function)
{
    double *left = d->closure_w;
    mbsri_copy((size_t)m->nu, need, left);
    for (int k = 0; k < motors->count; ++k) left[motors->rate[k]] = 0.0;
    int status = check_torques(m, d, need, left, function);
    if (!status) status = mbsri_check_result(m, d, (size_t)m->nu, need, function);
    for (int k = 0; k < m->nu && !status; ++k) tau[k] = need[k] - left[k];
    return status;
}

/* What a solution with motors is made of. */
typedef struct actuation {
    mbsri_fronts system;
    double *marked, *found, *x; /* nu, the first in the order of the sweeps */
    double *zero, *lambda;      /* rows */
} actuation;

static int open_actuation(actuation *w, const mbsr_model *m, mbsr_data *d,
                          const mbsr_motors *motors, const char *function)
{
    const size_t nu = (size_t)m->nu, rows = (size_t)m->rows;
    int status = mbsri_fronts_open(&w->system, m, d, false, function);
    if (status) return status;
    w->marked = mbsri_fronts_allocate(&w->system, (3 * nu + 2 * rows) * sizeof(double));
    if (!w->marked)
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d rows of closures", function, m->rows);
    w->found = w->marked + nu;
    w->x = w->found + nu;
    w->zero = w->x + nu;
    w->lambda = w->zero + rows;
    mbsri_zero(nu, w->x);
    mbsri_zero(rows, w->zero);
    for (int k = 0; k < motors->count; ++k) w->x[motors->rate[k]] = 1.0;
    mbsri_gather(m, w->x, w->marked);
    return MBSR_OK;
}

int mbsri_loops_actuate(const mbsr_model *m, mbsr_data *d, const mbsr_motors *motors,
                        const double *need, double *tau, const char *function)
{
    actuation w;
    const size_t nu = (size_t)m->nu, rows = (size_t)m->rows;
    if (rows == 0) return actuate_tree(m, d, motors, need, tau, function);
    int status = open_actuation(&w, m, d, motors, function);
    if (!status) status = mbsri_closure_jacobians(m, d);
    if (!status) status = mbsri_fronts_factor(&w.system, w.marked, function);
    if (!status) {
        mbsri_fronts_solve(&w.system, need, w.zero, w.x, w.lambda);
        status = take_torques(&w.system, w.marked, need, w.found, w.lambda, w.x, function);
    }
    if (!status) status = mbsri_check_result(m, d, nu, w.found, function);
    if (!status) status = mbsri_check_result(m, d, rows, w.lambda, function);
    if (!status) {
        mbsri_copy(nu, w.found, tau);
        mbsri_copy(rows, w.lambda, d->loop_lambda);
    }
    mbsri_fronts_close(&w.system);
    return status;
}

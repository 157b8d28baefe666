/* Directions that move no mass and that no loop holds.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Z spans the kernel of K in u. Along it forces balance at every time, Z^T r = 0 with r = h - C^T lambda,
 * the inverse dynamics of the tree less loop forces. With D = Z^T dh/du Z, of rank d:
 *
 *   damped     d combinations of rows of Z^T r that D sees: they fix velocities          index 1
 *   elastic    the others, Y^T Z^T r: fix positions, their derivative velocities         index 2
 *
 * Along the motion r itself vanishes, so that Z and Y may be held where they are differentiated, with u'
 * and lambda held as well: M Z = 0 and C Z = 0. Positions are found by Newton's method along Z, after
 * each step of which the loops are closed in the metric of the masses, which moves those last;
 * velocities by Newton's method along Z. u' along Z follows from differences: of Z^T r, or, where some
 * directions are elastic, of what this procedure itself makes of the state a little earlier and later. */
#include "loops/balance.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/assemble.h"
#include "loops/motion.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"
#include "recursion/spans.h"

#include <math.h>

static const double ROUNDING = 1e-10; /* of differences, beside what was added up to a force */
static const double SMALL = 1e-8;     /* of singular values, beside the largest */

/* Workspace and state; vectors behind one another in one block. */
typedef struct balance {
    mbsri_dense *w;
    const mbsr_consistent_opt *opt;
    mbsr_consistent_info *info;
    double t;
    double *q, *u, *udot, *lambda;
    int k, damped;
    double *Z;             /* n x k */
    double *size;          /* k: of what is added up to Z^T r */
    double *L, *R;         /* k x k: rows and columns, the damped ones first: L^T D R is diagonal */
    double *S;             /* k x k */
    double *r, *r_try, *x; /* k */
    double *moved, *h, *u_at;        /* n */
    double *still;                   /* n: zeros */
    double *q_at, *q_before;         /* nq */
    double *rates;                   /* n: u' that goes with the velocities tried */
    double *loads;                   /* rows: lambda, likewise */
    double *left, *right;            /* k: scales of D */
    double *wished;                  /* n: velocities that the search starts from */
    double *q_now, *u_now, *u_ahead; /* nq, n, n: of the state whose accelerations are looked for */
    double rate;                     /* 1/s: of the model (spans.h) */
    double *A, *values, *work;       /* k x k, k, svd */
    int lwork;
    void *memory;
} balance;

static int allocate(balance *b)
{
    mbsri_dense *w = b->w;
    const size_t n = (size_t)w->n, nq = (size_t)w->m->nq, rows = (size_t)w->rows;
    b->lwork = mbsri_lapack_svd_work(w->n > 0 ? w->n : 1);
    double **const array[] = {&b->Z,     &b->size,   &b->L,     &b->R,        &b->S,
                              &b->r,     &b->r_try,  &b->x,     &b->moved,    &b->h,
                              &b->u_at,  &b->still,  &b->q_at,  &b->q_before, &b->rates,
                              &b->loads, &b->left,   &b->right, &b->A,        &b->values,
                              &b->work,  &b->wished, &b->q_now, &b->u_now,    &b->u_ahead};
    const size_t length[] = {n * n, n,    n * n, n * n, n * n, n,  n,
                             n,     n,    n,     n,     n,     nq, nq,
                             n,     rows, n,     n,     n * n, n,  (size_t)b->lwork,
                             n,     nq,   n,     n};
    size_t total = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) total += length[l];
    b->memory = mbsri_allocate(&w->m->allocator, (total + 1) * sizeof(double));
    if (!b->memory)
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for directions without mass", w->function);
    double *next = b->memory;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    mbsri_zero(n, b->still);
    return MBSR_OK;
}

/* The largest of joint rates, or changes of them (n), over their spans. */
static double extent(const balance *b, const double *x)
{
    double largest = 0.0;
    for (int k = 0; k < b->w->n; ++k) largest = fmax(largest, fabs(x[k]) / b->w->span[k]);
    return largest;
}

/* The largest work of joint forces (n) over these spans. */
static double work_of(const balance *b, const double *x)
{
    double largest = 0.0;
    for (int k = 0; k < b->w->n; ++k) largest = fmax(largest, fabs(x[k]) * b->w->span[k]);
    return largest;
}

static const double *direction(const balance *b, int l)
{
    return b->Z + (size_t)l * (size_t)b->w->n;
}

/* y (k) = Z^T x */
static void along(const balance *b, const double *x, double *y)
{
    const int n = b->w->n;
    for (int l = 0; l < b->k; ++l) y[l] = mbsri_dot(n, b->Z + (size_t)l * (size_t)n, x);
}

/* y (n) += Z x */
static void combine(const balance *b, const double *x, double *y)
{
    mbsri_ax(b->w->n, b->k, 1.0, b->Z, x, y);
}

/* Z at the K factored last, and the sizes of what is added up to forces along it: the data is at the
 * forces, b->h is their sum. */
static void find_directions(balance *b)
{
    mbsri_dense *w = b->w;
    const mbsr_data *d = w->d;
    b->k = w->moving;
    for (int l = 0; l < b->k; ++l) {
        double *z = b->Z + (size_t)l * (size_t)w->n, size = 0.0;
        mbsri_dense_null(w, l, z);
        mbsri_closure_apply(w->m, w->d, z, w->y);
        for (size_t c = 0; c < w->m->size_v; ++c) size += fabs(d->closure_V[c] * d->f[c]);
        for (int c = 0; c < w->n; ++c) size += fabs(d->closure_w[c] * d->tau[c]);
        b->size[l] = size + 0.1 * work_of(b, b->h); /* z has rounding errors itself */
    }
}

/* ---- forces along Z, and their slopes ---- */

/* Z^T h at the velocities u. */
static int forces(balance *b, const double *u, double *r)
{
    const int status = mbsri_loops_missing(b->w, b->t, b->q, u, NULL, b->still, NULL, b->h);
    along(b, b->h, r);
    return status;
}

/* d/ds of Z^T (h - C^T lambda) along q + s G v, u + s a and, with `time`, t + s, u' = a and lambda held.
 */
static int change(balance *b, bool time, const double *v, const double *a, const double *held,
                  const double *lambda, double *r)
{
    mbsri_dense *w = b->w;
    const double speed = fmax(extent(b, v), time ? b->rate : 0.0),
                 h = mbsri_difference_step(0.0, 1.0) / fmax(speed, 1e-300);
    mbsri_zero((size_t)b->k, r);
    for (int l = 0; l < 4; ++l) {
        const double s = mbsri_difference_place(l) * h;
        int status = mbsri_positions(w->m, w->d, b->t, b->q);
        if (!status) status = mbsri_displace(w->m, w->d, b->q, s, v, b->q_at);
        for (int k = 0; k < w->n; ++k) b->u_at[k] = b->u[k] + s * a[k];
        if (!status)
            status = mbsri_loops_missing(w, b->t + (time ? s : 0.0), b->q_at, b->u_at, NULL, held,
                                         lambda, b->h);
        if (status) return status;
        along(b, b->h, b->x);
        for (int k = 0; k < b->k; ++k) r[k] += mbsri_difference_weight(l) / (12.0 * h) * b->x[k];
    }
    return MBSR_OK;
}

/* ---- what is damped and what is elastic ---- */

/* D by differences of velocities u, each row over what rounding may make of it (noise, k: by how much). Where nothing
 * acts at these velocities, rounding is that of the forces at the others. */
static int find_damping(balance *b, double *D, double *noise)
{
    const int n = b->w->n, k = b->k;
    const double step = 1e-2 * fmax(b->rate, extent(b, b->u));
    double work = 0.0;
    for (int l = 0; l < k; ++l) {
        double *column = D + (size_t)l * (size_t)k;
        for (int side = -1; side <= 1; side += 2) {
            mbsri_copy((size_t)n, b->u, b->moved);
            mbsri_zero((size_t)k, b->x);
            b->x[l] = side * step;
            combine(b, b->x, b->moved);
            const int status = forces(b, b->moved, side < 0 ? b->r_try : column);
            if (status) return status;
            work = fmax(work, 0.1 * work_of(b, b->h));
        }
        for (int j = 0; j < k; ++j) column[j] = (column[j] - b->r_try[j]) / (2.0 * step);
    }
    for (int j = 0; j < k; ++j) {
        noise[j] = ROUNDING * fmax(b->size[j], work) / step;
        for (int l = 0; l < k && noise[j] > 0.0; ++l) D[(size_t)(l * k + j)] /= noise[j];
    }
    return MBSR_OK;
}

/* Scales rows and columns of A (k x k) to largest entries of 1, which are written to left and right;
 * those of zeros keep 1. */
static void equilibrate(int k, double *A, double *left, double *right)
{
    for (int i = 0; i < k; ++i) {
        double largest = 0.0;
        for (int j = 0; j < k; ++j) largest = fmax(largest, fabs(A[j * k + i]));
        left[i] = largest > 0.0 ? 1.0 / largest : 1.0;
        for (int j = 0; j < k; ++j) A[j * k + i] *= left[i];
    }
    for (int j = 0; j < k; ++j) {
        const double largest = mbsri_largest(k, A + j * k);
        right[j] = largest > 0.0 ? 1.0 / largest : 1.0;
        for (int i = 0; i < k; ++i) A[j * k + i] *= right[j];
    }
}

/* L and R at the velocities, and how many directions are damped: of D over its rounding, row by row, the singular
 * values above 1. */
static int split(balance *b)
{
    const int k = b->k;
    const int status = find_damping(b, b->A, b->left);
    if (status) return status;
    if (mbsri_lapack_svd(k, b->A, b->values, b->L, b->R, b->work, b->lwork))
        return mbsri_fail(&b->w->d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                          "%s: no singular values of forces along directions without mass",
                          b->w->function);
    b->damped = 0;
    while (b->damped < k && b->values[b->damped] > 1.0) ++b->damped;
    for (int l = 0; l < k; ++l) {
        for (int j = 0; j < k; ++j) {
            if (b->left[j] > 0.0) b->L[l * k + j] /= b->left[j];
        }
    }
    return MBSR_OK;
}

/* x (e) with S x = r (e), in place; where S is singular, by numbers up to `least` that may be zero, there is a
 * direction that nothing determines. R has the directions from `first` on. */
static int solve(balance *b, int e, int first, double least, double *r)
{
    mbsri_dense *w = b->w;
    const double steepest = mbsri_largest(e * e, b->S);
    int rank = 0;
    if (!(steepest > least) ||
        mbsri_lapack_gelsy(e, e, b->S, r, least / steepest, w->pivots, &rank, w->work, w->lwork) ||
        rank < e) {
        mbsri_zero((size_t)w->n, b->moved);
        combine(b, b->R + first * b->k, b->moved);
        return mbsri_loops_refuse(w, b->moved, ", and neither a damper nor a spring resists it");
    }
    return MBSR_OK;
}

/* The same of slopes that are clear of rounding, in whatever units: rows and columns scaled. */
static int solve_scaled(balance *b, double *r)
{
    equilibrate(b->k, b->S, b->left, b->right);
    for (int j = 0; j < b->k; ++j) r[j] *= b->left[j];
    const int status = solve(b, b->k, 0, SMALL, r);
    for (int j = 0; j < b->k && !status; ++j) r[j] *= b->right[j];
    return status;
}

static int no_balance(const balance *b, const char *what, double force)
{
    return mbsri_fail(&b->w->d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                      "%s: no %s found at which forces along directions without mass balance "
                      "(force left: %.3g)",
                      b->w->function, what, force);
}

/* ---- positions ---- */

/* Closes the loops in the metric of the masses from b->q, around coordinates that stay. */
static int close(balance *b)
{
    mbsri_dense *w = b->w;
    const mbsri_closure *first = mbsri_all_closures(w->m);
    for (int step = 0; step < 20; ++step) {
        int status = mbsri_positions(w->m, w->d, b->t, b->q);
        if (!status) status = mbsri_velocities(w->m, w->d, b->u);
        if (!status) status = mbsri_dense_factor(w, w->left_out, b->opt->keep_position);
        if (!status) status = mbsri_assembly_gaps(w, w->y);
        if (status) return status;
        if (mbsri_closing_widest(w->m, &w->closing, w->y) <=
            1e-12 * mbsri_closing_size(w->m, w->d, &w->closing))
            return MBSR_OK;
        mbsri_zero((size_t)w->N, w->g);
        for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
            for (int k = 0; k < c->held; ++k) {
                if (!w->left_out[c->row + k]) w->g[w->n + c->row + k] = -w->y[c->held_row + k];
            }
        }
        mbsri_dense_solve(w, w->g, w->x);
        status = mbsri_displace(w->m, w->d, b->q, 1.0, w->x, b->q_at);
        if (status) return status;
        mbsri_copy((size_t)w->m->nq, b->q_at, b->q);
    }
    return MBSR_NO_CONVERGENCE;
}

/* From closed positions: velocities that the loops allow, Z, L, R, u' and lambda; *defect: the largest
 * elastic force beside what is added up to it. */
static int look(balance *b, double *defect)
{
    mbsri_dense *w = b->w;
    int status = mbsri_loops_velocities(w, b->t, b->q, b->u);
    if (!status) status = mbsri_loops_rates(w, b->t, b->q, b->u, NULL, b->rates, b->loads);
    if (!status) status = mbsri_loops_missing(w, b->t, b->q, b->u, NULL, b->still, NULL, b->h);
    if (!status) find_directions(b);
    *defect = 0.0;
    if (status || b->k == 0) return status;
    status = split(b);
    if (!status) status = forces(b, b->u, b->r);
    for (int l = b->damped; l < b->k; ++l) {
        const double *row = b->L + l * b->k;
        double size = 0.0;
        for (int j = 0; j < b->k; ++j) size += fabs(row[j]) * b->size[j];
        if (size > 0.0) *defect = fmax(*defect, fabs(mbsri_dot(b->k, row, b->r)) / size);
    }
    return status;
}

/* S: slopes of elastic forces along R, each row over what rounding may make of it (noise, e). */
static int find_stiffness(balance *b, double *noise)
{
    const int k = b->k, e = k - b->damped;
    double widest = 0.0;
    int status = MBSR_OK;
    for (int l = 0; l < e && !status; ++l) {
        mbsri_zero((size_t)b->w->n, b->moved);
        combine(b, b->R + (b->damped + l) * k, b->moved);
        widest = fmax(widest, extent(b, b->moved));
        status = change(b, false, b->moved, b->still, b->rates, b->loads, b->values);
        for (int j = 0; j < e; ++j)
            b->S[l * e + j] = mbsri_dot(k, b->L + (b->damped + j) * k, b->values);
    }
    for (int j = 0; j < e; ++j) {
        const double *row = b->L + (b->damped + j) * k;
        noise[j] = 0.0;
        for (int c = 0; c < k; ++c) noise[j] += ROUNDING * widest * fabs(row[c]) * b->size[c];
        for (int l = 0; l < e && noise[j] > 0.0; ++l) b->S[l * e + j] /= noise[j];
    }
    return status;
}

/* The step x (k) along Z that balances elastic forces. */
static int aim(balance *b)
{
    const int k = b->k, e = k - b->damped;
    double *part = b->values;
    mbsri_copy((size_t)k, b->r, b->r_try);
    int status = find_stiffness(b, b->left);
    if (status) return status;
    for (int j = 0; j < e; ++j) {
        part[j] = -mbsri_dot(k, b->L + (b->damped + j) * k, b->r_try);
        if (b->left[j] > 0.0) part[j] /= b->left[j];
    }
    status = solve(b, e, b->damped, 1.0, part);
    mbsri_zero((size_t)k, b->x);
    mbsri_ax(k, e, 1.0, b->R + b->damped * k, part, b->x);
    return status;
}

/* Moves along x until the elastic forces are smaller; velocities start from those wished at each place. */
static int move(balance *b, double *defect)
{
    mbsri_dense *w = b->w;
    const size_t n = (size_t)w->n, nq = (size_t)w->m->nq;
    const double before = *defect;
    double *way = w->out;
    mbsri_zero(n, way);
    combine(b, b->x, way);
    const double largest = extent(b, way);
    mbsri_copy(nq, b->q, b->q_before);
    double share = fmin(1.0, 0.5 / largest);
    for (int tries = 0; tries < 40; ++tries, share *= 0.5) {
        int status = mbsri_positions(w->m, w->d, b->t, b->q_before);
        if (!status) status = mbsri_displace(w->m, w->d, b->q_before, share, way, b->q);
        mbsri_copy(n, b->wished, b->u);
        if (!status) status = close(b);
        if (!status) status = look(b, defect);
        if (status < 0) return status;
        if (!status && *defect < before) return MBSR_OK;
        if (!status && largest < 1e-9) break;
    }
    return *defect <= 1e-8 ? MBSR_OK : no_balance(b, "positions", *defect);
}

static int find_positions(balance *b)
{
    double defect, last = INFINITY;
    mbsri_copy((size_t)b->w->n, b->u, b->wished);
    int status = look(b, &defect);
    for (int i = 0; !status && b->damped < b->k; ++i) {
        if (defect <= 1e-14 || (last < 1e-10 && defect >= 0.25 * last)) {
            status = aim(b); /* whether springs determine them at all */
            break;
        }
        if (i >= b->opt->max_iterations) return no_balance(b, "positions", defect);
        last = defect;
        status = aim(b);
        if (!status) status = move(b, &defect);
        ++b->info->iterations;
    }
    return status;
}

/* ---- velocities ---- */

/* out (k): damped rows of L^T Z^T h, and elastic rows of its derivative, at the velocities b->u. */
static int defect_of_velocities(balance *b, double *out)
{
    const int k = b->k;
    int status = forces(b, b->u, b->r);
    for (int l = 0; l < k; ++l) out[l] = mbsri_dot(k, b->L + l * k, b->r);
    if (status || b->damped == k) return status;
    status = mbsri_loops_rates(b->w, b->t, b->q, b->u, NULL, b->rates, b->loads);
    if (!status) status = change(b, true, b->u, b->rates, b->rates, b->loads, b->r);
    for (int l = b->damped; l < k; ++l) out[l] = mbsri_dot(k, b->L + l * k, b->r);
    return status;
}

/* u from the velocities in `moved` by a step along Z R_l that changes them by h over their spans. */
static double step_along(balance *b, int l, double h)
{
    const int n = b->w->n;
    mbsri_zero((size_t)n, b->u);
    combine(b, b->R + l * b->k, b->u);
    const double step = h / extent(b, b->u);
    for (int j = 0; j < n; ++j) b->u[j] = b->moved[j] + step * b->u[j];
    return step;
}

/* One Newton step of u along Z; *size: how large. */
static int step_velocities(balance *b, double *size)
{
    const int n = b->w->n, k = b->k;
    const double speed = fmax(b->rate, extent(b, b->u)), h = 1e-4 * speed;
    double *at = b->r_try, *ahead = b->values;
    int status = MBSR_OK;
    mbsri_copy((size_t)n, b->u, b->moved);
    for (int l = 0; l < k && !status; ++l) {
        double *column = b->S + l * k;
        const double back = step_along(b, l, -h);
        status = defect_of_velocities(b, ahead);
        const double on = step_along(b, l, h);
        if (!status) status = defect_of_velocities(b, column);
        for (int j = 0; j < k; ++j) column[j] = (column[j] - ahead[j]) / (on - back);
        mbsri_copy((size_t)n, b->moved, b->u);
    }
    if (!status) status = defect_of_velocities(b, at);
    if (!status) status = solve_scaled(b, at);
    if (status) return status;
    mbsri_zero((size_t)k, b->x);
    mbsri_ax(k, k, -1.0, b->R, at, b->x);
    mbsri_copy((size_t)n, b->u, b->moved);
    combine(b, b->x, b->u);
    for (int j = 0; j < n; ++j) b->moved[j] -= b->u[j];
    *size = extent(b, b->moved) / speed;
    return MBSR_OK;
}

static int find_velocities(balance *b)
{
    double size = INFINITY, last;
    int status = forces(b, b->u, b->r);
    b->info->force_defect = fmax(b->info->force_defect, mbsri_largest(b->k, b->r));
    for (int i = 0; i < b->opt->max_iterations && !status; ++i) {
        last = size;
        status = step_velocities(b, &size);
        ++b->info->iterations;
        if (size <= b->opt->tolerance || (size < 1e-7 && size >= 0.25 * last)) return status;
    }
    return status ? status : no_balance(b, "velocities", mbsri_largest(b->k, b->r));
}

/* ---- accelerations ---- */

/* u' along Z from d/dt (Z^T r) = 0, all directions damped; it is affine in u'. */
static int damped_rates(balance *b)
{
    const int n = b->w->n, k = b->k;
    const double h = fmax(b->rate * b->rate, extent(b, b->udot));
    int status = MBSR_OK;
    for (int pass = 0; pass < 2 && !status; ++pass) {
        status = change(b, true, b->u, b->udot, b->udot, b->lambda, b->r_try);
        for (int l = 0; l < k && !status; ++l) {
            mbsri_copy((size_t)n, b->udot, b->moved);
            for (int j = 0; j < n; ++j) b->moved[j] += h * direction(b, l)[j];
            status = change(b, true, b->u, b->moved, b->moved, b->lambda, b->S + l * k);
            for (int j = 0; j < k; ++j) b->S[l * k + j] = (b->S[l * k + j] - b->r_try[j]) / h;
        }
        if (!status) status = solve_scaled(b, b->r_try);
        for (int l = 0; l < k; ++l) b->r_try[l] = -b->r_try[l];
        if (!status) combine(b, b->r_try, b->udot);
    }
    return status;
}

/* The state that the procedure makes of the one that motion leads to after dt, velocities into u. */
static int state_after(balance *b, double t, double dt, double *u)
{
    mbsri_dense *w = b->w;
    b->t = t + dt;
    mbsri_copy((size_t)w->m->nq, b->q_now, b->q);
    for (int k = 0; k < w->n; ++k) b->u[k] = b->u_now[k] + dt * b->udot[k];
    int status = mbsri_positions(w->m, w->d, t, b->q);
    if (!status) status = mbsri_displace(w->m, w->d, b->q_now, dt, b->u_now, b->q);
    if (!status) status = close(b);
    if (!status) status = find_positions(b);
    if (!status) status = find_velocities(b);
    mbsri_copy((size_t)w->n, b->u, u);
    return status;
}

/* u' along Z from velocities a little earlier and later, some directions elastic. */
static int elastic_rates(balance *b)
{
    mbsri_dense *w = b->w;
    const int n = w->n;
    const double t = b->t, a = extent(b, b->udot),
                 dt = 1e-3 / fmax(fmax(b->rate, extent(b, b->u)), sqrt(a));
    double defect;
    int rank;
    mbsri_copy((size_t)w->m->nq, b->q, b->q_now);
    mbsri_copy((size_t)n, b->u, b->u_now);
    int status = state_after(b, t, dt, b->u_ahead);
    if (!status) status = state_after(b, t, -dt, b->moved);
    for (int k = 0; k < n; ++k)
        b->u_ahead[k] = (b->u_ahead[k] - b->moved[k]) / (2.0 * dt) - b->udot[k];
    b->t = t;
    mbsri_copy((size_t)w->m->nq, b->q_now, b->q);
    mbsri_copy((size_t)n, b->u_now, b->u);
    if (!status) status = mbsri_loops_factor(w, t, b->q, b->u);
    if (!status) status = look(b, &defect);
    if (status) return status;
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < b->k; ++l) w->U[l * n + k] = direction(b, l)[k] / b->w->span[k];
        b->u_ahead[k] /= b->w->span[k];
    }
    if (mbsri_lapack_gelsy(n, b->k, w->U, b->u_ahead, SMALL, w->pivots, &rank, w->work, w->lwork))
        return no_balance(b, "accelerations", 0.0);
    combine(b, b->u_ahead, b->udot);
    return MBSR_OK;
}

/* ---- the call ---- */

static int run(balance *b)
{
    mbsr_consistent_info ignored = {0}, *const info = b->info;
    int status = find_positions(b);
    info->null_directions = b->k;
    info->elastic = b->damped < b->k;
    const bool elastic = b->damped < b->k;
    if (!status && b->k > 0) status = find_velocities(b);
    if (!status) status = mbsri_loops_rates(b->w, b->t, b->q, b->u, NULL, b->udot, b->lambda);
    if (status || b->k == 0) return status;
    b->info = &ignored;
    status = elastic ? elastic_rates(b) : damped_rates(b);
    b->info = info;
    return status;
}

int mbsri_balance(mbsri_dense *w, double t, double *q, double *u, double *udot, double *lambda,
                  const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    balance b = {
        .w = w, .opt = opt, .info = info, .t = t, .q = q, .u = u, .udot = udot, .lambda = lambda};
    int status = allocate(&b);
    const mbsri_spans spans = mbsri_spans_of(w->m, NULL);
    b.rate = mbsri_span_rate(&spans);
    if (!status) status = run(&b);
    mbsri_release(&w->m->allocator, b.memory);
    return status;
}

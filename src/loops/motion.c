/* Accelerations and loop forces that closures allow, at a position.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * h(q, u, a) = M a + (bias - applied forces) is the inverse dynamics of the tree, K = [M -C^T; C 0]
 * with the rows that are independent.
 *
 *   u', lambda     K (u'; lambda) = (-h(q, u, 0); -(C' u + g_t')) */
#include "loops/motion.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "loops/ranks.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "recursion/spans.h"

#include <float.h>
#include <math.h>

/* Forces of those springs alone that K does not have as rows, for mbsri_forces. */
static int load_springs(mbsri_dense *w)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const int status = mbsri_closure_springs(w->m, w->d);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            if (mbsri_is_stiff(c, k) && !w->left_out[c->row + k])
                w->d->loop_lambda[c->row + k] = 0.0;
        }
    }
    return status;
}

/* h at (t, q, u) and no accelerations, into r (n); tau may be NULL. Springs of rows that K has are
 * left to lambda. */
static int loops_missing(mbsri_dense *w, double t, const double *q, const double *u,
                         const double *tau, double *r)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = load_springs(w);
    if (!status) status = mbsri_forces(m, d, tau, d->loop_lambda);
    if (status) return status;
    mbsri_zero((size_t)w->n, w->x);
    mbsri_inverse(m, d, w->x);
    mbsri_scatter(m, d->out, r);
    return MBSR_OK;
}

double mbsri_largest_row(const mbsr_model *m, const double *x, const double *length)
{
    double largest = 0.0;
    for (int k = 0; k < m->rows; ++k)
        largest = fmax(largest, fabs(x[k]) / (length[k] > 0.0 ? length[k] : 1.0));
    return largest;
}

int mbsri_refuse_left(const mbsr_model *m, mbsr_data *d, const double *left, const double *length,
                      double size, const char *what, const char *function)
{
    static const double rounding = 1e-7;
    const mbsri_closure *first = mbsri_all_closures(m);
    double widest = 0.0;
    int id = 0, row = 0;
    char label[MBSRI_LABEL];
    for (int n = 0; n < (int)m->closures.count; ++n) {
        for (int k = first[n].row; k < first[n].row + first[n].rows; ++k) {
            const double own = fabs(left[k]) / (length[k] > 0.0 ? length[k] : 1.0);
            if (own > widest) widest = own, id = n, row = k;
        }
    }
    if (widest <= rounding * size) return MBSR_OK;
    return mbsri_fail(&d->error, MBSR_LOOP_OPEN, MBSR_NONE, MBSR_NONE,
                      "%s: %s: its %s cannot be met, %.3g is left: closures or motions "
                      "contradict each other",
                      function, mbsri_closure_label(m, id, label), what, fabs(left[row]));
}

/* Rows of springs that K does not have count for nothing. */
static void clear_springs(const mbsri_dense *w, double *x)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            if (mbsri_is_stiff(c, k) && w->left_out[c->row + k]) x[c->row + k] = 0.0;
        }
    }
}

void mbsri_loops_leave_out(mbsri_dense *w, bool springs)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            const bool spring = springs ? mbsri_is_stiff(c, k) : mbsri_is_loose(c, k);
            const bool dropped = !springs && w->d->dropped[c->row + k];
            w->left_out[c->row + k] = spring || dropped;
        }
    }
}

int mbsri_loops_factor(mbsri_dense *w, double t, const double *q, const double *u)
{
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_velocities(w->m, w->d, u);
    return status ? status : mbsri_dense_factor(w, w->left_out, NULL);
}

int mbsri_refuse_motion(const mbsr_model *m, mbsr_data *d, int rate, const char *function,
                        const char *why)
{
    char label[MBSRI_LABEL];
    const int at = mbsri_body_of_rate(m, rate);
    return mbsri_fail(&d->error, MBSR_UNDETERMINED, m->body[at].id, MBSR_NONE,
                      "%s: u%d of %s moves no mass, no loop holds it%s", function,
                      rate - m->body[at].u, mbsri_body_label(m, at, label), why);
}

/* Where rows depend on each other, springs among them share what they bear so that their energy,
 * the sum of lambda^2 / (2 k), is least: sqrt(1/k) (lambda - N a) is shortest, where the columns of
 * N span the part of the kernel of K in lambda, K factored. Overwrites K and x. */
static int share_by_kernel(mbsri_dense *w, double *lambda)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    static const double rounding = 1e-9; /* beside a vector of length 1, before it is scaled */
    const int count = w->factor.nulls - w->factor.moving, rows = w->rows;
    double *A = w->factor.K, *b = w->factor.right, *unit = w->x, *idle = w->y;
    int rank;
    if (count == 0) return MBSR_OK;
    mbsri_zero((size_t)rows, b);
    mbsri_zero((size_t)rows * (size_t)count, A);
    for (int l = 0; l < count; ++l) {
        mbsri_dense_idle(w, l, idle);
        for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
            for (int k = 0, row = c->row; k < c->position_rows; ++k, ++row) {
                if (!mbsri_is_stiff(c, k) || w->left_out[row]) continue;
                if (fabs(idle[row]) <= rounding * w->factor.scale[w->n + row]) continue;
                b[row] = lambda[row] / sqrt(c->def.stiffness[k]);
                A[l * rows + row] = idle[row] / sqrt(c->def.stiffness[k]);
            }
        }
        const double size = mbsri_largest(rows, A + l * rows);
        unit[l] = size > 0.0 ? 1.0 / size : 0.0;
        for (int k = 0; k < rows; ++k) A[l * rows + k] *= unit[l];
    }
    if (mbsri_lapack_gelsy(rows, count, A, b, 1e-12, w->factor.pivots, &rank, w->work, w->lwork))
        return mbsri_fail(&w->d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                          "%s: a least-squares problem failed", w->function);
    for (int l = 0; l < count; ++l) {
        mbsri_dense_idle(w, l, idle);
        for (int k = 0; k < rows; ++k) lambda[k] -= unit[l] * b[l] * idle[k];
    }
    return MBSR_OK;
}

/* Loop forces that are rounding of the others and of what acts (right, n), by the work of each
 * along its row: zero. They would stiffen directions along which nothing holds. Rounding grows with
 * the condition of K. */
static void clear_traces(mbsri_dense *w, const double *right, double *lambda)
{
    const int kept = w->N - w->factor.nulls;
    const double condition = kept > 0 ? w->factor.sigma[0] / w->factor.sigma[kept - 1] : 1.0,
                 rounding = 1e-12 + w->N * DBL_EPSILON * condition;
    double *scale = w->y, largest = 0.0;
    mbsri_rank_scales(w, scale);
    for (int j = 0; j < w->n; ++j) largest = fmax(largest, fabs(right[j]) * w->span[j]);
    for (int k = 0; k < w->rows; ++k) largest = fmax(largest, fabs(lambda[k]) * scale[k]);
    for (int k = 0; k < w->rows; ++k) {
        if (fabs(lambda[k]) * scale[k] <= rounding * largest) lambda[k] = 0.0;
    }
}

/* What is left of rows (rows) that may be rounding of what acts (right, n), in the scaled
 * equations: zero. Where rows hold all that has mass, accelerations are nothing else. */
static void clear_left(const mbsri_dense *w, const double *right, double *left)
{
    static const double rounding = 1e-12;
    double largest = 0.0;
    for (int j = 0; j < w->n; ++j) largest = fmax(largest, fabs(right[j]) * w->factor.scale[j]);
    for (int k = 0; k < w->rows; ++k) {
        if (fabs(left[k]) * w->factor.scale[w->n + k] <= rounding * largest) left[k] = 0.0;
    }
}

int mbsri_loops_rates(mbsri_dense *w, double t, const double *q, const double *u, const double *tau,
                      double *udot, double *lambda)
{
    const size_t n = (size_t)w->n;
    double *right = w->g, *bias = right + n;
    int status = loops_missing(w, t, q, u, tau, right);
    if (!status) status = mbsri_closure_jacobians(w->m, w->d);
    if (!status) status = mbsri_closure_bias(w->m, w->d, bias);
    if (status) return status;
    clear_springs(w, bias);
    for (size_t k = 0; k < n; ++k) right[k] = -right[k];
    for (int k = 0; k < w->rows; ++k) bias[k] = w->left_out[k] ? 0.0 : -bias[k];
    mbsri_dense_solve(w, right, w->x);
    mbsri_copy(n, w->x, udot);
    mbsri_copy((size_t)w->rows, w->x + n, lambda);
    status = share_by_kernel(w, lambda);
    if (status) return status;
    clear_traces(w, right, lambda);
    /* all rows, those left out as well */
    status = mbsri_closure_bias(w->m, w->d, bias);
    if (status) return status;
    mbsri_rank_scales(w, w->factor.right);
    const double rate = mbsri_rate_of_model(w->m),
                 size = rate * rate + mbsri_largest_row(w->m, bias, w->factor.right) +
                        mbsri_largest_rate(w->m, udot);
    mbsri_closure_apply(w->m, w->d, udot, w->y);
    for (int k = 0; k < w->rows; ++k) bias[k] += w->y[k];
    clear_springs(w, bias);
    clear_left(w, right, bias);
    return mbsri_refuse_left(w->m, w->d, bias, w->factor.right, size, "acceleration", w->function);
}

int mbsri_loops_springs(mbsri_dense *w, double t, const double *q, const double *u, double *lambda)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_velocities(w->m, w->d, u);
    if (!status) status = mbsri_closure_springs(w->m, w->d);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count && !status; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            if (mbsri_is_stiff(c, k) && w->left_out[c->row + k])
                lambda[c->row + k] = w->d->loop_lambda[c->row + k];
        }
    }
    return status;
}

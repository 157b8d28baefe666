/* A consistent start: which directions are damped, and corrections along them.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/start.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "massless/null_slopes.h"
#include "massless/element_rows.h"
#include "massless/seen.h"
#include "model/query.h"
#include "recursion/sizes.h"

#include <float.h>
#include <math.h>

/* The direction l is not determined at the state: names its joint. */
static int undetermined(mbsri_start *s, int l)
{
    const mbsr_model *m = s->w.m;
    char label[MBSRI_LABEL];
    const int i = s->w.body[l];
    return mbsri_fail(
        &s->w.d->error, MBSR_UNDETERMINED, m->body[i].id, MBSR_NONE,
        "mbsr_dae_consistent: %s: a combination of joint rates that includes its joint "
        "moves no mass, and neither a damper nor a spring resists it at this state: give it "
        "inertia%s, a spring or a damper, or lock it",
        mbsri_body_label(m, i, label), mbsri_mass_advice(m, i));
}

/* Reduces a matrix as it stands, rounding or not, to a rank that is known. */
static void reduce_to(mbsri_reduction *r, int n, int rank)
{
    mbsri_zero((size_t)n * (size_t)n, r->error);
    mbsri_reduce(r, n, n, rank, 0.0, NULL);
}

/* C into s->reduced. */
static void load_slopes(mbsri_start *s)
{
    const size_t square = (size_t)s->w.k * (size_t)s->w.k;
    mbsri_copy(square, s->w.C, s->reduced.A);
    mbsri_copy(square, s->w.C_error, s->reduced.error);
}

/* Which of the directions Z (k x e) that no damper sees is open, by what springs see: s->open. */
static int find_open(mbsri_start *s, int e)
{
    mbsri_null_space *w = &s->w;
    const int k = w->k;
    const int status = mbsri_seen_by_springs(w, k, w->moving, e, s->Z, s->Z_error);
    if (status || w->seen.rank == e) return status;
    double *open = s->weights, *weights = s->trial;
    mbsri_left_null(&w->seen, 0, weights, NULL);
    mbsri_seen_through(k, e, s->Z, weights, open);
    s->open = 0;
    for (int l = 1; l < k; ++l) {
        if (fabs(open[l]) > fabs(open[s->open])) s->open = l;
    }
    return MBSR_OK;
}

/* The rank of C and Y = Z by what dampers see. False in *told where C does not have that rank in double
 * precision. */
static int find_seen(mbsri_start *s, bool *told)
{
    mbsri_null_space *w = &s->w;
    const int k = w->k;
    const int status = mbsri_seen_by_dampers(w, k, w->moving);
    if (status) return status;
    const int damped = w->seen.rank, e = k - damped;
    load_slopes(s);
    reduce_to(&s->reduced, k, damped);
    *told = s->reduced.rank == damped;
    for (int c = 0; c < e; ++c) mbsri_left_null(&w->seen, c, s->Z + c * k, s->Z_error + c * k);
    mbsri_copy((size_t)k * (size_t)e, s->Z, s->left + damped * k);
    mbsri_copy((size_t)k * (size_t)e, s->Z_error, s->left_error + damped * k);
    return MBSR_OK;
}

/* The same from C itself. */
static void find_null(mbsri_start *s)
{
    const int k = s->w.k;
    load_slopes(s);
    mbsri_reduce(&s->reduced, k, k, k, MBSRI_LEAST_DAMPING, NULL);
    for (int c = 0; c < k - s->reduced.rank; ++c) {
        const int at = (s->reduced.rank + c) * k;
        mbsri_left_null(&s->reduced, c, s->left + at, s->left_error + at);
        mbsri_right_null(&s->reduced, c, s->Z + c * k, s->Z_error + c * k);
    }
}

/* Basis, C and S at (q, u); [Yc Y] and the rank of C. Of Yc, unit vectors for the rows of C with a
 * pivot serve: they and Y are independent. */
int mbsri_start_directions(mbsri_start *s)
{
    mbsri_null_space *w = &s->w;
    const int k = w->k;
    const size_t square = (size_t)k * (size_t)k;
    int status = mbsri_null_basis(w, s->t, s->q, s->u);
    if (!status) status = mbsri_null_slopes(w, s->t, s->q, s->u);
    if (status) return status;
    s->open = -1;
    mbsri_zero(square, s->left);
    mbsri_zero(square, s->left_error);
    for (int l = 0; l < k; ++l) w->moving[l] = l;
    bool told = mbsri_rows_serve(w, k, w->moving, true);
    if (told) mbsri_rows_slopes(w, w->C);
    if (told) status = find_seen(s, &told);
    s->by_rows = told && mbsri_rows_serve(w, k, w->moving, false);
    if (!status && s->by_rows && s->reduced.rank < k) status = find_open(s, k - s->reduced.rank);
    if (status) return status;
    if (!told) find_null(s);
    s->damped = s->reduced.rank;
    for (int c = 0; c < s->damped; ++c) {
        const int row = s->reduced.pivot_row[c];
        s->left[c * k + row] = s->reduced.rows[row];
    }
    return MBSR_OK;
}

/* out (k) = [Yc Y]^T x */
void mbsri_start_turn(const mbsri_start *s, const double *x, double *out)
{
    mbsri_zero((size_t)s->w.k, out);
    mbsri_atx(s->w.k, s->w.k, 1.0, s->left, x, out);
}

void mbsri_start_drop_rounding(const mbsri_start *s, int first, int count, double *turned)
{
    bool all = s->by_rows;
    for (int r = first; r < first + count && all; ++r) {
        const double *y = s->left + r * s->w.k, *dy = s->left_error + r * s->w.k;
        all = fabs(turned[r]) <= 16.0 * DBL_EPSILON * mbsri_rows_strain(&s->w, y, dy);
    }
    if (all) mbsri_zero((size_t)count, turned + first);
}

/* B = Y^T S with its errors. */
void mbsri_start_springs(mbsri_start *s)
{
    const mbsri_null_space *w = &s->w;
    const int k = w->k, e = k - s->damped;
    if (s->by_rows) { /* Y = Z; of B's errors nothing is asked */
        mbsri_rows_through(w, e, s->Z, s->Z_error, s->B);
        mbsri_zero((size_t)k * (size_t)e, s->B_error);
        return;
    }
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
int mbsri_start_factor(mbsri_start *s, double small)
{
    const int k = s->w.k, e = k - s->damped;
    if (s->open >= 0) return undetermined(s, s->open);
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
            s->rest.A[c * e + r] = s->by_rows || fabs(sum) > 10.0 * error ? sum : 0.0;
            s->rest.error[c * e + r] = error;
        }
    }
    if (s->by_rows)
        reduce_to(&s->rest, e, e);
    else
        mbsri_reduce(&s->rest, e, e, e, small, NULL);
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
void mbsri_start_back(const mbsri_reduction *r, bool pivots, const double *right, double *x)
{
    for (int k = 0; k < r->rank; ++k) {
        const int row = r->pivot_row[k], column = r->pivot_column[k];
        double sum = 0.0;
        for (int l = 0; l < r->rank; ++l) {
            const int from = r->pivot_row[l];
            const double value = pivots ? right[l] : right[from] * r->rows[from];
            sum += r->A[(r->m + from) * r->n + row] * value;
        }
        x[column] = sum * r->columns[column];
    }
}

/* weights with Yc^T C weights = right, B weights = the rest of right: those of the pivots of C
 * first, then weights of Z. */
void mbsri_start_solve(mbsri_start *s, const double *right)
{
    const int k = s->w.k, e = k - s->damped;
    double *part = s->trial, *z = part + s->damped;
    mbsri_zero((size_t)k, s->weights);
    mbsri_start_back(&s->reduced, true, right, s->weights);
    mbsri_copy((size_t)e, right + s->damped, s->w.ahead);
    mbsri_ax(e, k, -1.0, s->B, s->weights, s->w.ahead);
    mbsri_start_back(&s->rest, false, s->w.ahead, z);
    mbsri_ax(k, e, 1.0, s->Z, z, s->weights);
}

/* ---- when an iteration ends ---- */

/* Largest |x| beside typical sizes. */
double mbsri_start_relative(int n, const double *x, const double *scale)
{
    double largest = 0.0;
    for (int k = 0; k < n; ++k) largest = fmax(largest, fabs(x[k]) / scale[k]);
    return largest;
}

/* sizes (k) of the forces that were added up last, in the null directions. */
void mbsri_start_loads(mbsri_start *s, double *sizes)
{
    mbsri_null_space *w = &s->w;
    mbsri_gross_forces(w->m, w->d);
    for (int l = 0; l < w->k; ++l) sizes[l] = mbsri_null_load(w, l);
    mbsri_null_remix(w, true, sizes);
}

void mbsri_start_add_dampers(const mbsri_start *s, double speed, double *sizes)
{
    const mbsri_null_space *w = &s->w;
    const int k = w->k, nu = w->m->nu;
    for (int m = 0; m < k; ++m) {
        const double *a = w->direction + (size_t)m * (size_t)nu,
                     share = speed / mbsri_start_relative(nu, a, w->u_scale);
        for (int l = 0; l < k; ++l) sizes[l] += fabs(w->C[m * k + l]) * share;
    }
}

/* Largest |gamma_l| beside the sizes of the forces, over all l, or those whose rows of C have a
 * pivot. Leaves the sizes in w.force. */
double mbsri_start_imbalance(mbsri_start *s, const double *gamma, bool damped_only)
{
    double *sizes = s->w.force, worst = 0.0;
    mbsri_start_loads(s, sizes);
    if (damped_only)
        mbsri_start_add_dampers(s, mbsri_start_relative(s->w.m->nu, s->u, s->w.u_scale), sizes);
    for (int l = 0; l < s->w.k; ++l) {
        if (gamma[l] == 0.0 || (damped_only && !s->reduced.row_taken[l])) continue;
        worst = fmax(worst, fabs(gamma[l]) / sizes[l]);
    }
    return worst;
}

bool mbsri_start_relaxed(mbsri_start *s, const double *gamma, bool damped_only)
{
    const mbsri_null_space *w = &s->w;
    const int nu = w->m->nu;
    double *sizes = s->trial, stiffest = 0.0;
    mbsri_start_loads(s, sizes);
    for (int l = 0; l < w->k; ++l) {
        const double *a = w->direction + (size_t)l * (size_t)nu;
        stiffest = fmax(stiffest, w->strain[l] / mbsri_start_relative(nu, a, w->span));
    }
    for (int l = 0; l < w->k; ++l) {
        const double *a = w->direction + (size_t)l * (size_t)nu,
                     elsewhere = stiffest * mbsri_start_relative(nu, a, w->span);
        if (damped_only && !s->reduced.row_taken[l]) continue;
        if (fabs(gamma[l]) >
            MBSRI_GAMMA_ROUNDING * (w->strain[l] + sizes[l] + MBSRI_GAMMA_ROUNDING * elsewhere))
            return false;
    }
    return true;
}

/* Whether a correction of this size, to a vector of that size, is the last, both beside typical
 * sizes; `near`: from where one counts that does not get smaller. *last: the correction before. */
bool mbsri_start_settled(const mbsri_start *s, double *last, double change, double size,
                         double near)
{
    const double beside = fmax(size, 1e-3);
    const bool slow = change > 0.25 * *last && change <= near * beside;
    *last = change;
    return change <= s->opt->tolerance * beside || slow;
}

/* No state found: names the joint at which the largest force is left. */
int mbsri_start_unbalanced(mbsri_start *s, const char *what, const double *gamma)
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

/* A time in which state and time change by about `share` of their size. */
double mbsri_start_short_time(const mbsri_start *s, double share)
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
static int gamma_after(mbsri_start *s, double h, bool accelerated, double *gamma)
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
int mbsri_start_differences(mbsri_start *s, double h, bool accelerated, const double *gamma,
                            double *first, double *second)
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

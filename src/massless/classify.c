/* The kinds of the directions that move no mass.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/report_parts.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "massless/element_rows.h"
#include "massless/null_slopes.h"
#include "massless/seen.h"

#include <float.h>
#include <math.h>

/* Gives b the number of its component. */
static void join(mbsri_report *r, int b, int number, int *count)
{
    if (r->component[b] >= 0) return;
    r->component[b] = number;
    r->member[(*count)++] = b;
}

/* Joins what some element sees together with direction a. */
static void join_seen(mbsri_report *r, int a, int number, int *count)
{
    const mbsri_row *row = r->w.element.rows.data;
    for (size_t n = 0; n < r->w.element.rows.count; ++n, ++row) {
        const mbsri_row_entry *entry =
            (const mbsri_row_entry *)r->w.element.entries.data + row->first;
        bool seen = false;
        for (int k = 0; k < row->count && !seen; ++k)
            seen = entry[k].direction == a && entry[k].value != 0.0;
        for (int k = 0; k < row->count && seen; ++k) {
            if (entry[k].value != 0.0) join(r, entry[k].direction, number, count);
        }
    }
}

/* Spreads the number of l's component over all directions coupled to it. */
void mbsri_report_mark(mbsri_report *r, int l, int number)
{
    const int k = r->w.k;
    int count = 0;
    join(r, l, number, &count);
    for (int next = 0; next < count; ++next) {
        const int a = r->member[next];
        for (int b = 0; b < k; ++b) {
            const bool coupled = r->w.C[a * k + b] != 0.0 || r->w.C[b * k + a] != 0.0 ||
                                 r->w.S[a * k + b] != 0.0 || r->w.S[b * k + a] != 0.0;
            if (coupled) join(r, b, number, &count);
        }
        join_seen(r, a, number, &count);
    }
}

/* ---- the kinds ---- */

/* T = S Z of the component, its errors and |S| |Z|: c x e each. */
static void stiffness_of(mbsri_report *r, int c, int e, double *T, double *error, double *gross)
{
    const int k = r->w.k;
    mbsri_zero((size_t)c * (size_t)e, T);
    mbsri_zero((size_t)c * (size_t)e, error);
    mbsri_zero((size_t)c * (size_t)e, gross);
    for (int b = 0; b < e; ++b) {
        for (int q = 0; q < c; ++q) {
            const double z = r->Z[b * c + q], dz = r->Z_error[b * c + q];
            for (int p = 0; p < c && (z != 0.0 || dz != 0.0); ++p) {
                const int at = r->member[q] * k + r->member[p], to = b * c + p;
                const double S = r->w.S[at], size = fabs(S);
                T[to] += S * z;
                gross[to] += size * fabs(z);
                error[to] += (r->w.S_error[at] + 4.0 * DBL_EPSILON * size) * fabs(z) + size * dz;
            }
        }
    }
}

/* reduced.A = Y^T S Z of the component with its errors, c - damped rows and columns. */
static void elastic_block(mbsri_report *r, int c, int e)
{
    double *T = r->C, *T_error = r->reduced.A + (size_t)e * (size_t)e,
           *gross = r->reduced.error + (size_t)e * (size_t)e;
    stiffness_of(r, c, e, T, T_error, gross);
    for (int b = 0; b < e; ++b) {
        for (int a = 0; a < e; ++a) {
            const double *y = r->Y + a * c, *dy = r->Y_error + a * c;
            double sum = 0.0, error = 0.0;
            for (int p = 0; p < c; ++p) {
                sum += y[p] * T[b * c + p];
                error += fabs(y[p]) * T_error[b * c + p] + dy[p] * gross[b * c + p];
            }
            r->reduced.A[b * e + a] = fabs(sum) > 10.0 * error ? sum : 0.0;
            r->reduced.error[b * e + a] = error;
        }
    }
}

/* Elastic and undetermined directions among those C does not see, Y and Z (c x e). */
static int classify_rest(mbsri_report *r, int c, int e)
{
    elastic_block(r, c, e);
    mbsri_reduce(&r->reduced, e, e, e, MBSRI_LEAST_STIFFNESS, NULL);
    const int elastic = r->reduced.rank;
    int status = MBSR_OK;
    for (int l = 0; l < e && !status; ++l) {
        double *weights = r->values; /* e numbers */
        if (l < elastic)
            mbsri_row_space(&r->reduced, l, weights);
        else
            mbsri_right_null(&r->reduced, l - elastic, weights, NULL);
        mbsri_seen_through(c, e, r->Z, weights, r->x);
        const double *sparse = l < elastic ? r->Z + r->reduced.pivot_column[l] * c : NULL;
        status = mbsri_report_add_shorter(
            r, c, r->x, sparse, l < elastic ? MBSR_DIRECTION_ELASTIC : MBSR_DIRECTION_UNDETERMINED);
    }
    return status;
}

/* The smallest of `rank` singular values of the scaled C over the largest. */
static int condition(mbsri_report *r, int c, int rank, mbsr_index_report *report)
{
    for (int b = 0; b < c; ++b) {
        for (int a = 0; a < c; ++a) r->C[b * c + a] = r->w.C[r->member[b] * r->w.k + r->member[a]];
    }
    mbsri_scale_rows(c, r->C, r->values);
    mbsri_scale_columns(c, r->C, r->values);
    if (mbsri_lapack_singular_values(c, r->C, r->values, r->work, r->lwork) != 0) {
        return mbsri_fail(&r->w.d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                          "%s: singular values did not converge", r->w.function);
    }
    report->conditioning = fmin(report->conditioning, r->values[rank - 1] / r->values[0]);
    return MBSR_OK;
}

/* By C and S themselves. */
static int classify_by_slopes(mbsri_report *r, int c, mbsr_index_report *report)
{
    const int k = r->w.k;
    for (int b = 0; b < c; ++b) {
        for (int a = 0; a < c; ++a) {
            const int at = r->member[b] * k + r->member[a];
            r->reduced.A[b * c + a] = r->w.C[at];
            r->reduced.error[b * c + a] = r->w.C_error[at];
        }
    }
    mbsri_reduce(&r->reduced, c, c, c, MBSRI_LEAST_DAMPING, NULL);
    const int damped = r->reduced.rank;
    int status = damped > 0 ? condition(r, c, damped, report) : MBSR_OK;
    for (int l = 0; l < damped && !status; ++l) {
        mbsri_row_space(&r->reduced, l, r->x);
        mbsri_zero((size_t)c, r->sparse);
        r->sparse[r->reduced.pivot_column[l]] = 1.0;
        status = mbsri_report_add_shorter(r, c, r->x, r->sparse, MBSR_DIRECTION_DAMPED);
    }
    for (int l = 0; l < c - damped; ++l) {
        mbsri_left_null(&r->reduced, l, r->Y + l * c, r->Y_error + l * c);
        mbsri_right_null(&r->reduced, l, r->Z + l * c, r->Z_error + l * c);
    }
    return !status && damped < c ? classify_rest(r, c, c - damped) : status;
}

/* ---- by what elements see ---- */

/* Elastic and undetermined directions among Z (c x e). */
static int classify_elastic(mbsri_report *r, int c, int e)
{
    const mbsri_reduction *seen = &r->w.element.reduced;
    int status = mbsri_seen_by_springs(&r->w, c, r->member, e, r->Z, r->Z_error);
    if (status) return status;
    const int elastic = seen->rank, open = e - elastic;
    double *U = r->C;
    for (int l = 0; l < open; ++l) {
        mbsri_left_null(seen, l, r->values, NULL);
        mbsri_seen_through(c, e, r->Z, r->values, U + l * c);
        mbsri_report_add(r, c, U + l * c, MBSR_DIRECTION_UNDETERMINED);
    }
    mbsri_report_unseen(r, c, open, U);
    for (int l = 0; l < elastic && !status; ++l) {
        mbsri_left_pivot(seen, l, r->values);
        mbsri_seen_through(c, e, r->Z, r->values, r->x);
        mbsri_report_part(r, c, open, l, r->x);
        status = mbsri_report_choose(r, c, r->x, open, MBSR_DIRECTION_ELASTIC);
    }
    return status;
}

static int classify_by_rows(mbsri_report *r, int c, mbsr_index_report *report)
{
    const mbsri_reduction *seen = &r->w.element.reduced;
    int status = mbsri_seen_by_dampers(&r->w, c, r->member);
    const int damped = status ? 0 : seen->rank, e = c - damped;
    if (damped > 0) status = condition(r, c, damped, report);
    for (int l = 0; l < e && !status; ++l)
        mbsri_left_null(seen, l, r->Z + l * c, r->Z_error + l * c);
    if (!status) mbsri_report_unseen(r, c, e, r->Z);
    for (int l = 0; l < damped && !status; ++l) {
        mbsri_left_pivot(seen, l, r->x);
        mbsri_report_part(r, c, e, l, r->x);
        status = mbsri_report_choose(r, c, r->x, e, MBSR_DIRECTION_DAMPED);
    }
    if (status || e == 0) return status;
    if (mbsri_rows_serve(&r->w, c, r->member, false)) return classify_elastic(r, c, e);
    mbsri_copy((size_t)(c * e), r->Z, r->Y);
    mbsri_copy((size_t)(c * e), r->Z_error, r->Y_error);
    return classify_rest(r, c, e);
}

int mbsri_report_classify(mbsri_report *r, int number, mbsr_index_report *report)
{
    int c = 0;
    for (int l = 0; l < r->w.k; ++l) {
        if (r->component[l] == number) r->member[c++] = l;
    }
    return mbsri_rows_serve(&r->w, c, r->member, true) ? classify_by_rows(r, c, report)
                                                       : classify_by_slopes(r, c, report);
}

/* The kinds of the directions that move no mass, and the choice of those shown.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/report_parts.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "massless/element_slopes.h"
#include "massless/null_slopes.h"

#include <float.h>
#include <math.h>

/* Spreads the number of l's component over all directions coupled to it. */
void mbsri_report_mark(mbsri_report *r, int l, int number)
{
    const int k = r->w.k;
    int count = 0;
    r->member[count++] = l;
    r->component[l] = number;
    for (int next = 0; next < count; ++next) {
        const int a = r->member[next];
        for (int b = 0; b < k; ++b) {
            const bool coupled = r->w.C[a * k + b] != 0.0 || r->w.C[b * k + a] != 0.0 ||
                                 r->w.S[a * k + b] != 0.0 || r->w.S[b * k + a] != 0.0;
            if (!coupled || r->component[b] >= 0) continue;
            r->component[b] = number;
            r->member[count++] = b;
        }
    }
}

/* ---- the choice of a direction ---- */

/* weights (k) of the component's directions with weights x (c), but for those that add less than 1e-6
 * of the largest joint rate: reports leave such rates out, and list no elements for them. */
static void spread(mbsri_report *r, int c, const double *x, double *weights)
{
    const mbsri_null_space *w = &r->w;
    double *size = r->sizes, largest = 0.0;
    mbsri_zero((size_t)w->k, weights);
    for (int a = 0; a < c; ++a) {
        const int l = r->member[a];
        const double *u = w->direction + (size_t)l * (size_t)w->m->nu;
        size[a] = 0.0;
        for (int k = w->from[l]; k < w->to[l] && x[a] != 0.0; ++k)
            size[a] = fmax(size[a], fabs(x[a] * u[k]) / w->span[k]);
        largest = fmax(largest, size[a]);
    }
    for (int a = 0; a < c; ++a) {
        if (size[a] >= 1e-6 * largest) weights[r->member[a]] = x[a];
    }
}

/* u, twist and q_rate of a direction. */
void mbsri_report_combine(mbsri_report *r, const double *weights)
{
    mbsri_null_mix(&r->w, MBSRI_NULL_RATES, weights, r->u, r->size);
    mbsri_null_mix(&r->w, MBSRI_NULL_TWISTS, weights, r->twist, r->size);
    mbsri_null_mix(&r->w, MBSRI_NULL_SHIFTS, weights, r->q_rate, r->size);
}

/* Whether an element determines the direction of this kind in u, twist and q_rate. */
int mbsri_report_determines(mbsri_report *r, const mbsri_force *force, mbsr_direction_kind kind,
                            bool *determined)
{
    *determined = false;
    if (kind == MBSR_DIRECTION_UNDETERMINED) return MBSR_OK;
    return mbsri_element_resists(&r->w, force, r->u, r->twist, r->q_rate,
                                 kind == MBSR_DIRECTION_DAMPED, determined);
}

/* listed: the bodies that move in the direction and belong to elements that determine it. */
static int list_bodies(mbsri_report *r, mbsr_direction_kind kind)
{
    const mbsr_model *m = r->w.m;
    const mbsri_force *force = m->forces.data;
    for (int i = 0; i <= m->bodies; ++i) r->listed[i] = false;
    for (size_t k = 0; k < m->forces.count; ++k) {
        bool determined;
        const int status = mbsri_report_determines(r, force + k, kind, &determined);
        if (status) return status;
        for (int l = 0; l < force[k].def.bodies && determined; ++l)
            r->listed[m->list_index[force[k].list + (size_t)l]] = true;
    }
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        r->listed[i] = r->listed[i] && mbsri_largest(b->n, r->u + b->u) > 0.0;
    }
    return MBSR_OK;
}

static int count_terms(const mbsr_model *m, const double *u)
{
    int count = 0;
    for (int k = 0; k < m->nu; ++k) count += u[k] != 0.0;
    return count;
}

/* A direction of the component: x, or in its stead `sparse` (NULL: none) if that has fewer terms
 * and still names the bodies on which the elements act that determine x. */
static int add(mbsri_report *r, int c, const double *x, const double *sparse,
               mbsr_direction_kind kind)
{
    const mbsr_model *m = r->w.m;
    double *weights = r->weights + (size_t)r->found * (size_t)r->w.k;
    r->kind[r->found++] = kind;
    spread(r, c, x, weights);
    mbsri_report_combine(r, weights);
    const int terms = count_terms(m, r->u);
    if (!sparse || terms <= 2) return MBSR_OK;
    const int status = list_bodies(r, kind);
    if (status) return status;
    spread(r, c, sparse, weights);
    mbsri_null_mix(&r->w, MBSRI_NULL_RATES, weights, r->other, r->size);
    bool better = count_terms(m, r->other) < terms;
    for (int i = 1; i <= m->bodies && better; ++i) {
        const mbsri_body *b = m->body + i;
        better = !r->listed[i] || mbsri_largest(b->n, r->other + b->u) > 0.0;
    }
    if (better) return MBSR_OK;
    spread(r, c, x, weights);
    return MBSR_OK;
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

/* out (c) = Z weights (e) */
static void through(const mbsri_report *r, int c, int e, const double *weights, double *out)
{
    mbsri_zero((size_t)c, out);
    for (int b = 0; b < e; ++b) {
        for (int a = 0; a < c; ++a) out[a] += weights[b] * r->Z[b * c + a];
    }
    for (int a = 0; a < c; ++a) {
        double size = 0.0;
        for (int b = 0; b < e; ++b) size += fabs(weights[b] * r->Z[b * c + a]);
        if (fabs(out[a]) <= 1e-12 * size) out[a] = 0.0;
    }
}

/* Elastic and undetermined directions among those C does not see. */
static int classify_rest(mbsri_report *r, int c, int damped)
{
    const int e = c - damped;
    for (int l = 0; l < e; ++l) {
        mbsri_left_null(&r->reduced, l, r->Y + l * c, r->Y_error + l * c);
        mbsri_right_null(&r->reduced, l, r->Z + l * c, r->Z_error + l * c);
    }
    elastic_block(r, c, e);
    mbsri_reduce(&r->reduced, e, MBSRI_LEAST_STIFFNESS);
    const int elastic = r->reduced.rank;
    int status = MBSR_OK;
    for (int l = 0; l < e && !status; ++l) {
        double *weights = r->values; /* e numbers */
        if (l < elastic)
            mbsri_row_space(&r->reduced, l, weights);
        else
            mbsri_right_null(&r->reduced, l - elastic, weights, NULL);
        through(r, c, e, weights, r->x);
        const double *sparse = l < elastic ? r->Z + r->reduced.pivot_column[l] * c : NULL;
        status = add(r, c, r->x, sparse,
                     l < elastic ? MBSR_DIRECTION_ELASTIC : MBSR_DIRECTION_UNDETERMINED);
    }
    return status;
}

/* The smallest of `rank` singular values of the scaled C over the largest. */
static int condition(mbsri_report *r, int c, int rank, mbsr_index_report *report)
{
    for (int b = 0; b < c; ++b) {
        for (int a = 0; a < c; ++a) {
            r->C[b * c + a] = r->reduced.rows[a] * r->reduced.columns[b] *
                              r->w.C[r->member[b] * r->w.k + r->member[a]];
        }
    }
    if (mbsri_lapack_svd(c, r->C, r->values, r->Y, r->Z, r->work, r->lwork) != 0) {
        return mbsri_fail(&r->w.d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                          "mbsr_index_report_create: singular values did not converge");
    }
    report->conditioning = fmin(report->conditioning, r->values[rank - 1] / r->values[0]);
    return MBSR_OK;
}

int mbsri_report_classify(mbsri_report *r, int number, mbsr_index_report *report)
{
    const int k = r->w.k;
    int c = 0;
    for (int l = 0; l < k; ++l) {
        if (r->component[l] == number) r->member[c++] = l;
    }
    for (int b = 0; b < c; ++b) {
        for (int a = 0; a < c; ++a) {
            const int at = r->member[b] * k + r->member[a];
            r->reduced.A[b * c + a] = r->w.C[at];
            r->reduced.error[b * c + a] = r->w.C_error[at];
        }
    }
    mbsri_reduce(&r->reduced, c, MBSRI_LEAST_DAMPING);
    const int damped = r->reduced.rank;
    int status = damped > 0 ? condition(r, c, damped, report) : MBSR_OK;
    for (int l = 0; l < damped && !status; ++l) {
        mbsri_row_space(&r->reduced, l, r->x);
        mbsri_zero((size_t)c, r->sparse);
        r->sparse[r->reduced.pivot_column[l]] = 1.0;
        status = add(r, c, r->x, r->sparse, MBSR_DIRECTION_DAMPED);
    }
    return !status && damped < c ? classify_rest(r, c, damped) : status;
}

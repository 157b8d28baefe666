/* The rank of one joint block in twofold precision.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   D = L L^T  by complete pivoting, with a relative error of 1e-32
 *
 * and S D S = X diag(lambda) X^T by the singular values of S L, which one-sided Jacobi rotations of
 * its columns find to a small relative error each however small they are beside others (Demmel and
 * Veselic 1992), so that L in double precision is enough. */
#include "recursion/exact_rank.h"

#include "algebra/dense.h"
#include "algebra/jacobi.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "model/query.h"
#include "recursion/errors.h"
#include "recursion/not_finite.h"
#include "recursion/pose.h"

#include <math.h>

/* A pivot is nothing but rounding below this part of what the errors of sums would be, lever arms
 * and tensors among them. */
static const double rounding = 1e-29;

/* The share of lever arms and tensors that never counts: beside the tolerance, 1e-26. */
static const double arms = 1e-14;

/* Of what was given with errors, 1 / sqrt(J^T unsure J) into strict (n); what pivots have to be
 * above into least (n). */
static void sureness(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, double *strict,
                     double *least)
{
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        for (int l = 0; l < b->n; ++l) {
            const double *J = d->J + b->dn + (size_t)(l * b->d);
            double *UJ = d->scratch;
            mbsri_zero((size_t)b->d, UJ);
            mbsri_ax(b->d, b->d, 1.0, d->unsure + b->dd, J, UJ);
            const double s = d->s[b->group.iu + l], turned = mbsri_rotated_along(d, b, l),
                         size = mbsri_dot(b->d, J, UJ) + arms * turned +
                                MBSRI_EXACT_SHARE * b->mass.armature[l];
            least[b->group.iu - g->ig + l] = rounding * (1.0 / (s * s) + turned);
            strict[b->group.iu - g->ig + l] = size > 0.0 ? 1.0 / sqrt(size) : d->s[b->group.iu + l];
        }
    }
}

/* By pivots, the largest beside its rounding first: others would carry theirs to the rest. A (n x
 * n) is lost. */
static void factorise_exactly(int n, const double *strict, const double *least, mbsri_two *A,
                              mbsri_exact_factor *f)
{
    mbsri_two_zero((size_t)(n * n), f->L);
    f->pivots = 0;
    f->left = 0.0;
    for (int k = 0; k < n; ++k) f->order[k] = k;
    for (int c = 0; c < n; ++c) {
        int best = c;
        double largest = 0.0;
        for (int k = c; k < n; ++k) {
            const int row = f->order[k];
            const double size = A[row * (n + 1)].hi / least[row];
            if (size > largest) largest = size, best = k;
        }
        if (!(largest > 1.0)) break;
        const int p = f->order[best];
        f->order[best] = f->order[c], f->order[c] = p;
        const mbsri_two pivot = mbsri_two_root(A[p * (n + 1)]);
        mbsri_two *column = f->L + c * n;
        column[p] = pivot;
        for (int k = c + 1; k < n; ++k)
            column[f->order[k]] = mbsri_two_divide(A[p * n + f->order[k]], pivot);
        for (int j = c + 1; j < n; ++j) {
            for (int k = c + 1; k <= j; ++k) {
                const int row = f->order[j], to = f->order[k];
                A[row * n + to] = A[to * n + row] =
                    mbsri_two_subtract(A[row * n + to], mbsri_two_times(column[row], column[to]));
            }
        }
        ++f->pivots;
    }
    for (int k = f->pivots; k < n; ++k) {
        const int row = f->order[k];
        f->left = fmin(f->left, strict[row] * A[row * (n + 1)].hi * strict[row]);
    }
}

/* S L of the pivots into A, its columns orthogonal and by descending length; the squares of these,
 * the eigenvalues, into lambda (n), 0 for the others. */
static bool eigenvalues(int n, const mbsri_exact_factor *f, const double *s, double *A,
                        double *lambda)
{
    for (int c = 0; c < f->pivots; ++c) {
        for (int k = 0; k < n; ++k) A[c * n + k] = s[k] * mbsri_two_value(f->L[c * n + k]);
    }
    for (int c = f->pivots; c < n; ++c) lambda[c] = 0.0;
    return mbsri_orthogonalise(n, f->pivots, A, lambda) == 0;
}

/* Columns of unit length; those from c on orthogonal to the others, as close to the axes as they
 * can be. */
static void complete(int n, int c, double *X)
{
    for (int l = 0; l < c; ++l) {
        const double length = sqrt(mbsri_dot(n, X + l * n, X + l * n));
        for (int k = 0; k < n; ++k) X[l * n + k] /= length;
    }
    for (int l = c; l < n; ++l) {
        double *x = X + l * n, most = -1.0;
        int axis = 0;
        for (int k = 0; k < n; ++k) {
            double rest = 1.0;
            for (int j = 0; j < l; ++j) rest -= X[j * n + k] * X[j * n + k];
            if (rest > most) most = rest, axis = k;
        }
        mbsri_zero((size_t)n, x);
        x[axis] = 1.0;
        for (int turn = 0; turn < 2; ++turn) {
            for (int j = 0; j < l; ++j) {
                const double part = mbsri_dot(n, X + j * n, x);
                for (int k = 0; k < n; ++k) x[k] -= part * X[j * n + k];
            }
        }
        const double length = sqrt(mbsri_dot(n, x, x));
        for (int k = 0; k < n; ++k) x[k] /= length;
    }
}

/* A state that a solver found is on the manifold of a rank that is watched up to the solver's
 * errors only: eigenvalues between those that count here and those that count in double precision,
 * that is positions off by less than 1e-6 of lengths, are as the watched rank has them. */
static int expected(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, int rank,
                    double noise)
{
    const double *lambda = d->lambda + g->ig;
    int watched = 0, sure = 0;
    if (!d->watch.active) return rank;
    for (int k = 0; k < g->members; ++k) watched += d->watch.rank[g->member[k]];
    const mbsri_rank_rule rule = mbsri_rank_rule_of(m->rank_tolerance);
    while (sure < rank && mbsri_is_inertia(&rule, lambda[sure], noise)) ++sure;
    return watched >= rank ? rank : watched > sure ? watched : sure;
}

static int fail_at_body(const mbsr_model *m, mbsr_data *d, int i, int status, double value)
{
    char label[MBSRI_LABEL];
    const char *name = mbsri_body_label(m, i, label);
    if (status == MBSR_NOT_FINITE) return mbsri_report_not_finite(m, d, name);
    if (status == MBSR_EIGEN_FAILED) {
        return mbsri_fail(&d->error, status, m->body[i].id, MBSR_NONE,
                          "%s: the eigenvalues of D did not converge at t = %g", name, d->t);
    }
    return mbsri_fail(&d->error, status, m->body[i].id, MBSR_NONE,
                      "%s: the mass on its joint is indefinite at t = %g (scaled eigenvalue %g)",
                      name, d->t, value);
}

int mbsri_exact_decision(const mbsr_model *m, mbsr_data *d, const mbsri_group *g,
                         const mbsri_two *D, mbsri_exact_factor *factor, mbsri_two *work)
{
    const int i = g->member[0], n = g->n;
    const mbsri_body *b = m->body + i;
    double *s = d->s + g->ig, *X = d->X + b->nn, *lambda = d->lambda + g->ig, noise;
    const mbsri_rank_rule rule = mbsri_rank_rule_of(m->rank_tolerance);
    mbsri_two *A = work;
    double *strict = (double *)(A + n * n), *values = strict + n, *columns = values + n,
           *least = columns + n * n;
    d->scale[b->scalar_offset] = mbsri_equilibrate(m, d, g, &noise);
    sureness(m, d, g, strict, least);
    bool finite = isfinite(d->scale[b->scalar_offset]) && mbsri_finite((size_t)n, strict);
    for (int k = 0; k < n * n; ++k) {
        A[k] = D[k];
        finite = finite && isfinite(D[k].hi) && isfinite(D[k].lo);
    }
    if (!finite) return fail_at_body(m, d, i, MBSR_NOT_FINITE, 0.0);
    factorise_exactly(n, strict, least, A, factor);
    if (factor->left < -m->rank_tolerance)
        return fail_at_body(m, d, i, MBSR_INDEFINITE_MASS, factor->left);
    bool ended = eigenvalues(n, factor, strict, columns, values);
    int rank = 0;
    while (rank < factor->pivots && mbsri_is_inertia(&rule, values[rank], 1.0)) ++rank;
    ended = eigenvalues(n, factor, s, X, lambda) && ended;
    if (!ended) return fail_at_body(m, d, i, MBSR_EIGEN_FAILED, 0.0);
    rank = expected(m, d, g, rank, noise);
    mbsri_copy((size_t)n, lambda, d->judged + g->ig);
    if (rank > 0 && rank < n && m->typical.inertia && !mbsri_given_scale(m, d, g)) {
        mbsri_copy((size_t)n, m->typical.inertia + g->ig, s);
        if (!eigenvalues(n, factor, s, X, lambda))
            return fail_at_body(m, d, i, MBSR_EIGEN_FAILED, 0.0);
    }
    complete(n, factor->pivots, X);
    d->rank[i] = rank;
    if (g->members > 1) {
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k)
                A[j * n + k] = mbsri_two_scale(mbsri_two_scale(D[j * n + k], strict[j]), strict[k]);
        }
        mbsri_share_rank(m, d, g, rank, m->rank_tolerance, A);
    }
    return MBSR_OK;
}

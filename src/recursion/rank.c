/* The rank of one joint block D and its pseudo-inverse.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * D = J^T Mbar J may be zero up to rounding, so its eigenvalues are compared with the size of the
 * rounding errors in it, not with each other (rank_rule.h). W (backward.c) is that size for Mbar:
 * the sum of all that was added up before anything cancelled, carried from body to body as an error
 * would be. With S = diag(J^T W J)^(-1/2)
 *
 *   S D S = X diag(lambda) X^T,  lambda_k > tolerance: kept (R = S X_kept), else dropped (N)
 *   D^+   = S X_kept diag(1/lambda) X_kept^T S
 *   I - D^+ D = S X_dropped X_dropped^T S^-1     projects onto the null space, spanned by N
 *
 * The eigenvalues are as exact as the largest of them. That is enough for the decision; but where
 * the noise W leaves little of one row and much of another, D^+ needs small eigenvalues to more
 * than that. So a D of full rank is inverted by Cholesky's factors, whose errors go with the
 * diagonal.
 *
 * S makes the decision the same in all units. D^+ is the Moore-Penrose pseudo-inverse of D in the
 * joint coordinates S^-1 u. What it makes of forces and momenta that D does not take up depends on
 * S, and W is a matter of which engine made it; so where D lacks some of its rank, the projections
 * are those with S of the model (assembly/survey.c), of as many eigenvalues as were kept with W. */
#include "recursion/rank.h"

#include "algebra/cholesky.h"
#include "algebra/dense.h"
#include "algebra/jacobi.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "model/query.h"
#include "recursion/errors.h"
#include "recursion/modal.h"
#include "recursion/not_finite.h"
#include "recursion/pose.h"

#include <math.h>

/* diag(J^T W J + a)^(-1/2) into s, a the armature, or with `fixed` the given s; the largest entry
 * of diag(J^T W J), and of S J^T W J S in *noise, if that is larger (1 unless s is given). A zero
 * entry belongs to a row of D that is zero. */
static double equilibrate_joint(const mbsri_body *b, const mbsr_data *d, const double *fixed,
                                double *s, double *noise)
{
    const double *armature = d->armature ? d->armature + b->iu : b->mass.armature;
    double *WJ = d->scratch, largest = 0.0;
    for (int k = 0; k < b->n; ++k) {
        const double size = mbsri_along_itself(b, d->W + b->dd, d->J + b->dn, k, WJ) + armature[k];
        s[k] = fixed ? fixed[k] : size > 0.0 ? 1.0 / sqrt(size) : 1.0;
        if (fixed) *noise = fmax(*noise, size * s[k] * s[k]);
        largest = isnan(size) ? size : fmax(size, largest);
        if (isnan(largest)) return largest;
    }
    return largest;
}

const double *mbsri_given_scale(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g)
{
    if (d->frame.used) return d->s_frame;
    const bool kept = d->keep_scale && !mbsri_apart(m, d, m->body[g->member[0]].group.head);
    return kept ? d->s : NULL;
}

double mbsri_equilibrate(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                         double *noise)
{
    const double *given = mbsri_given_scale(m, d, g);
    double largest = 0.0;
    *noise = 1.0;
    for (int k = 0; k < g->members && !isnan(largest); ++k) {
        const mbsri_body *b = m->body + g->member[k];
        const double size =
            equilibrate_joint(b, d, given ? given + b->group.iu : NULL, d->s + b->group.iu, noise);
        largest = isnan(size) ? size : fmax(size, largest);
    }
    return largest;
}

/* The largest part of errors in a row of S D S that turned tensors may have (backward.c), S with W
 * as 1; `strict` (n) gets the S for which it is 1. */
static double turned_noise(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                           double *strict)
{
    double largest = 0.0;
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        for (int l = 0; l < b->n; ++l) {
            const double s = d->s[b->group.iu + l], part = mbsri_rotated_along(d, b, l) * s * s;
            strict[b->group.iu - g->ig + l] = s / sqrt(1.0 + part);
            largest = fmax(largest, part);
        }
    }
    return largest;
}

/* How many eigenvalues of S D S are above the tolerance; A: n x n of scratch, then work. */
static int count_above(const mbsr_model *m, int n, const double *D, const double *s,
                       double tolerance, double *A)
{
    double *lambda = A + n * n, *work = lambda + n;
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) A[j * n + k] = s[j] * D[j * n + k] * s[k];
    }
    const int info = n <= MBSRI_JACOBI_MAX
                         ? mbsri_jacobi(n, A, lambda)
                         : mbsri_lapack_syev(n, A, lambda, work, m->most.lapack_work);
    int count = 0;
    for (int k = 0; k < n && info == 0; ++k) count += lambda[k] > tolerance;
    return info == 0 ? count : n;
}

/* As elimination from the last joint to the first would find it. */
void mbsri_share_rank(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, int rank,
                      double tolerance, mbsri_two *A)
{
    const int n = g->n;
    int left = rank;
    for (int k = 0; k < g->members; ++k) d->rank[g->member[k]] = 0;
    for (int i = g->members - 1; i >= 0; --i) {
        const mbsri_body *b = m->body + g->member[i];
        const int first = b->group.iu - g->ig;
        int above = first; /* no more than these are left for the joints before */
        for (int turn = 0; turn < b->n; ++turn) {
            /* the largest pivot of the joint */
            int p = first;
            for (int k = first; k < first + b->n; ++k) {
                if (A[k * (n + 1)].hi > A[p * (n + 1)].hi) p = k;
            }
            const mbsri_two pivot = A[p * (n + 1)];
            const bool clear = pivot.hi > tolerance;
            if (left == 0 || (!clear && left <= above)) break;
            ++d->rank[g->member[i]];
            --left;
            for (int k = 0; k < n && clear; ++k) {
                if (k == p) continue;
                const mbsri_two share = mbsri_two_divide(A[k * n + p], pivot);
                for (int l = 0; l < n; ++l) {
                    if (l == p) continue;
                    const mbsri_two part = mbsri_two_times(share, A[p * n + l]);
                    A[k * n + l] = mbsri_two_subtract(A[k * n + l], part);
                }
            }
            for (int k = 0; k < n; ++k) A[k * n + p] = A[p * n + k] = (mbsri_two){0.0, 0.0};
        }
    }
}

/* Eigenvalues in descending order and their eigenvectors, so that the range comes first. */
static void reverse(int n, double *X, double *lambda)
{
    for (int k = 0, l = n - 1; k < l; ++k, --l) {
        const double value = lambda[k];
        lambda[k] = lambda[l];
        lambda[l] = value;
        for (int j = 0; j < n; ++j) {
            const double entry = X[k * n + j];
            X[k * n + j] = X[l * n + j];
            X[l * n + j] = entry;
        }
    }
}

/* D^+ = D^-1 by the Cholesky factors of D; false unless D has full rank. */
static bool definite_inverse(const mbsr_model *m, mbsr_data *d, const mbsri_group *g)
{
    const int n = g->n;
    const size_t nn = (size_t)n * (size_t)n;
    double *L = d->scratch, *Y = L + nn, *Dinv = d->Dinv + m->body[g->member[0]].nn;
    if (!mbsri_definite_factor(m, d, g, L)) return false;
    mbsri_zero(nn, Y);
    for (int k = 0; k < n; ++k) Y[k * (n + 1)] = 1.0;
    mbsri_divide_by_cholesky(n, n, L, Y);
    mbsri_zero(nn, Dinv);
    mbsri_abt(n, n, n, 1.0, Y, Y, Dinv);
    return true;
}

/* Dinv = D^+ by the first `rank` eigenvalues. */
static void pseudo_inverse(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, int rank)
{
    const mbsri_body *b = m->body + g->member[0];
    const int n = g->n;
    const double *s = d->s + g->ig, *X = d->X + b->nn, *lambda = d->lambda + g->ig;
    double *Dinv = d->Dinv + b->nn;
    mbsri_zero((size_t)n * (size_t)n, Dinv);
    for (int l = 0; l < rank; ++l) {
        for (int j = 0; j < n; ++j) {
            const double factor = s[j] * X[l * n + j] / lambda[l];
            for (int k = 0; k < n; ++k) Dinv[j * n + k] += factor * s[k] * X[l * n + k];
        }
    }
}

bool mbsri_definite_factor(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, double *L)
{
    const int n = g->n;
    if (n < 2 || mbsri_group_rank(d, g) < n) return false;
    mbsri_copy((size_t)n * (size_t)n, d->D + m->body[g->member[0]].nn, L);
    return mbsri_cholesky(n, L);
}

/* X = S D S becomes X of X diag(lambda) X^T; nonzero: it did not converge. The first n numbers of
 * scratch stay. */
static int decompose(const mbsr_model *m, mbsr_data *d, const mbsri_group *g)
{
    const mbsri_body *b = m->body + g->member[0];
    const int n = g->n;
    double *X = d->X + b->nn, *lambda = d->lambda + g->ig;
    if (n == 1) {
        lambda[0] = X[0];
        X[0] = 1.0;
        return 0;
    }
    if (n <= MBSRI_JACOBI_MAX) return mbsri_jacobi(n, X, lambda); /* faster than a call */
    const int info = mbsri_lapack_syev(n, X, lambda, d->scratch + n, m->most.lapack_work);
    reverse(n, X, lambda);
    return info;
}

/* X = S D S; rounding between joints that have nothing to do with each other would mix their null
 * spaces and is left out of groups, off the diagonal. */
static void scale_block(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, const double *s,
                        double tolerance)
{
    const mbsri_body *b = m->body + g->member[0];
    const int n = g->n;
    const double *D = d->D + b->nn;
    double *X = d->X + b->nn;
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) {
            const double entry = D[j * n + k];
            const bool noise =
                j != k && g->members > 1 && fabs(s[j] * entry * s[k]) <= 0.1 * tolerance;
            X[j * n + k] = noise ? 0.0 : s[j] * entry * s[k];
        }
    }
}

void mbsri_null_columns(int n, int m, const double *s, const double *N, double *X)
{
    for (int j = 0; j < m; ++j) {
        double *x = X + j * n;
        for (int k = 0; k < n; ++k) x[k] = N[j * n + k] / s[k];
        for (int turn = 0; turn < 2; ++turn) {
            for (int l = 0; l < j; ++l)
                mbsri_ax(n, 1, -mbsri_dot(n, X + l * n, x), X + l * n, &(double){1.0}, x);
        }
        const double length = sqrt(mbsri_dot(n, x, x));
        for (int k = 0; k < n; ++k) x[k] = fabs(x[k]) > 1e-15 * length ? x[k] / length : 0.0;
    }
}

/* Columns x (m of n numbers) with the same span, of which fewer and fewer have a part in the rows
 * that are largest once row k is times size[k]: of columns that all have, the others would drown
 * when these are taken out. */
static void grade_columns(int n, int m, const double *size, double *x)
{
    for (int j = m - 1; j > 0; --j) {
        double *last = x + j * n, largest = 0.0;
        int row = 0;
        for (int k = 0; k < n; ++k) {
            double part = 0.0;
            for (int l = 0; l <= j; ++l) part = fmax(part, fabs(x[l * n + k]) * size[k]);
            if (part > largest) largest = part, row = k;
        }
        for (int l = 0; l < j; ++l) {
            double *other = x + l * n;
            const double a = last[row], b = other[row], length = hypot(a, b);
            if (b == 0.0) continue;
            for (int k = 0; k < n; ++k) {
                const double part = (a * other[k] - b * last[k]) / length;
                last[k] = (a * last[k] + b * other[k]) / length;
                other[k] = part;
            }
            other[row] = 0.0;
        }
    }
}

/* X and lambda for S = diag(s) from those for S = diag(w), of which `rank` are kept:
 *
 *   S D S = A A^T,  A = S W^-1 X_kept lambda^(1/2),    null space S^-1 W X_dropped
 *
 * With S D S itself the null space would drown where s is much larger than w: of rates that move
 * next to nothing where the model was looked at. Nonzero: it did not converge. */
static int rescale(const mbsri_group *g, mbsr_data *d, const double *w, int rank, double *X,
                   double *N)
{
    const int n = g->n;
    double *lambda = d->lambda + g->ig;
    const double *s = d->s + g->ig;
    double least = INFINITY;
    for (int k = 0; k < n; ++k) {
        N[k] = w[k] / s[k];
        least = fmin(least, N[k]);
    }
    if (mbsri_largest(n, N) > 1e4 * least) grade_columns(n, n - rank, N, X + rank * n);
    for (int l = 0; l < n; ++l) {
        for (int k = 0; k < n; ++k) {
            double *x = X + l * n + k;
            if (l < rank)
                *x *= sqrt(lambda[l]) * s[k] / w[k];
            else
                N[(l - rank) * n + k] = w[k] * *x;
        }
    }
    mbsri_null_columns(n, n - rank, s, N, X + rank * n);
    const int failed = mbsri_orthogonalise(n, rank, X, lambda);
    for (int l = 0; l < n; ++l) {
        const double length = l < rank ? sqrt(lambda[l]) : 1.0;
        for (int k = 0; k < n; ++k) X[l * n + k] /= length;
        if (l >= rank) lambda[l] = 0.0;
    }
    return failed;
}

static int not_converged(const mbsr_model *m, mbsr_data *d, int i)
{
    char label[MBSRI_LABEL];
    return mbsri_fail(&d->error, MBSR_EIGEN_FAILED, m->body[i].id, MBSR_NONE,
                      "%s: the eigenvalues of D did not converge at t = %g",
                      mbsri_body_label(m, i, label), d->t);
}

/* The rank of a group in the position without symmetry that the model was looked at in; -1: it was
 * not. */
static int usual_rank(const mbsr_model *m, const mbsri_group *g)
{
    int rank = 0;
    for (int k = 0; k < g->members; ++k) {
        if (m->body[g->member[k]].survey.rank == 0) return -1;
        rank += m->body[g->member[k]].survey.rank - 1;
    }
    return rank;
}

/* x^T S Diag(size) S x */
static double local_size(int n, const double *s, const double *size, const double *x)
{
    double local = 0.0;
    for (int k = 0; k < n; ++k) local += x[k] * x[k] * s[k] * s[k] * size[k];
    return local;
}

/* Whether each eigenvalue is either so large that D is exact to nine digits in its direction, or
 * nothing but rounding; beside as many large ones as are usual, these may be as large as the
 * tolerance. */
static bool is_clear(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, double noise,
                     double turned, double *strict)
{
    const int n = g->n;
    const mbsri_body *first = m->body + g->member[0];
    const double *lambda = d->lambda + g->ig, *D = d->D + first->nn;
    const mbsri_rank_rule rule = mbsri_rank_rule_of(m->rank_tolerance);
    double *size = strict + n;
    int kept = 0, dropped = 0;
    while (kept < n && mbsri_is_known(&rule, lambda[kept], noise)) ++kept;
    if (kept < n) mbsri_diagonal_sizes(m, d, g, size);
    const bool usual = kept == usual_rank(m, g);
    for (int k = kept; k < n; ++k) {
        const double local = local_size(n, d->s + g->ig, size, d->X + first->nn + k * n);
        dropped += mbsri_is_nothing(&rule, lambda[k], noise, local) ||
                   (usual && !mbsri_is_inertia(&rule, fabs(lambda[k]), noise));
    }
    if (kept > 0 && turned > 9.0) {
        const int sure = count_above(m, n, D, strict, 0.1 * rule.known * noise, strict + n);
        if (sure < kept) kept = sure;
    }
    return kept + dropped == n;
}

/* The rank, with S of W in place. Where errors of turned tensors are larger and the rank is not
 * full, X and lambda are with the S that has these, in scratch, and so is *s: those kept need be no
 * eigenvectors with the other one, in which rounding counts as much as they do. */
static int decide(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, double noise, bool rough,
                  int *rank, const double **s)
{
    const mbsri_rank_rule rule = mbsri_rank_rule_of(m->rank_tolerance);
    const double tolerance = rule.tolerance * noise;
    const int i = g->member[0], n = g->n;
    const double *lambda = d->lambda + g->ig;
    double *strict = d->scratch;
    const double turned = turned_noise(m, d, g, strict);
    if (!rough && !is_clear(m, d, g, noise, turned, strict)) return MBSRI_UNCLEAR;
    if (lambda[n - 1] < -tolerance * (1.0 + turned)) {
        char label[MBSRI_LABEL];
        return mbsri_fail(
            &d->error, MBSR_INDEFINITE_MASS, m->body[i].id, MBSR_NONE,
            "%s: the mass on its joint is indefinite at t = %g (scaled eigenvalue %g)",
            mbsri_body_label(m, i, label), d->t, lambda[n - 1]);
    }
    *rank = 0;
    while (*rank < n && mbsri_is_inertia(&rule, lambda[*rank], noise)) ++*rank;
    if (turned > 100.0 && *rank > 0) {
        const int sure = count_above(m, n, d->D + m->body[i].nn, strict, tolerance, strict + n);
        if (sure < *rank) *rank = sure;
        if (*rank < n) {
            *s = strict;
            scale_block(m, d, g, strict, tolerance);
            if (decompose(m, d, g)) return not_converged(m, d, i);
        }
    }
    return MBSR_OK;
}

/* reads D, J, W;  writes s, X, lambda, judged, Dinv, scale, rank.  cost: one symmetric eigenproblem
 * of size n, two where some of the rank is lacking. */
int mbsri_rank_decision(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, bool rough)
{
    const int i = g->member[0], n = g->n;
    const mbsri_body *b = m->body + i;
    const double *X = d->X + b->nn;
    double *scale = d->s + g->ig, noise;
    const double *s = scale;
    d->scale[b->scalar_offset] = mbsri_equilibrate(m, d, g, &noise);
    const double tolerance = m->rank_tolerance * noise;
    scale_block(m, d, g, s, tolerance);
    if (!isfinite(d->scale[b->scalar_offset]) || !mbsri_finite((size_t)n * (size_t)n, X)) {
        char label[MBSRI_LABEL];
        return mbsri_report_not_finite(m, d, mbsri_body_label(m, i, label));
    }
    if (decompose(m, d, g)) return not_converged(m, d, i);
    int rank = 0;
    const int status = decide(m, d, g, noise, rough, &rank, &s);
    if (status) return status;
    mbsri_copy((size_t)n, d->lambda + g->ig, d->judged + g->ig);
    d->rank[i] = rank;
    if (g->members > 1) {
        const double *D = d->D + b->nn;
        mbsri_two *A = d->exact_work;
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) A[j * n + k] = mbsri_two_of(s[j] * D[j * n + k] * s[k]);
        }
        mbsri_share_rank(m, d, g, rank, tolerance, A);
    }
    if (rank > 0 && rank < n) {
        const bool of_model = m->typical.inertia && !mbsri_given_scale(m, d, g);
        double *w = d->scratch;
        if (s == scale) mbsri_copy((size_t)n, s, w);
        if (of_model) mbsri_copy((size_t)n, m->typical.inertia + g->ig, scale);
        if ((of_model || s != scale) && rescale(g, d, w, rank, d->X + b->nn, w + n))
            return not_converged(m, d, i);
    }
    if (!definite_inverse(m, d, g)) pseudo_inverse(m, d, g, rank);
    return MBSR_OK;
}

void mbsri_null_part(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, const double *x,
                     double *y)
{
    const int n = g->n, rank = mbsri_group_rank(d, g);
    const double *s = d->s + g->ig, *X = d->X + m->body[g->member[0]].nn;
    double *weight = d->scratch;
    /* X_dropped^T S^-1 x */
    for (int l = rank; l < n; ++l) {
        weight[l] = 0.0;
        for (int k = 0; k < n; ++k) weight[l] += X[l * n + k] * x[k] / s[k];
    }
    /* S X_dropped (.) */
    mbsri_zero((size_t)n, y);
    for (int l = rank; l < n; ++l) {
        for (int k = 0; k < n; ++k) y[k] += s[k] * X[l * n + k] * weight[l];
    }
}

/* reads X, s.  For x = e = tau - J^T fbar - J^T Mbar kII the last term has no part here (Lemma
 * 2). */
void mbsri_null_force(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                      const double *x, double *y)
{
    const int n = g->n, rank = mbsri_group_rank(d, g);
    const double *s = d->s + g->ig, *X = d->X + m->body[g->member[0]].nn;
    double *weight = d->scratch;
    /* X_dropped^T S x */
    for (int l = rank; l < n; ++l) {
        weight[l] = 0.0;
        for (int k = 0; k < n; ++k) weight[l] += X[l * n + k] * s[k] * x[k];
    }
    /* S^-1 X_dropped (.) */
    mbsri_zero((size_t)n, y);
    for (int l = rank; l < n; ++l) {
        for (int k = 0; k < n; ++k) y[k] += X[l * n + k] * weight[l] / s[k];
    }
}

int mbsri_rank_watched(const mbsr_model *m, mbsr_data *d, int i)
{
    if (!d->watch.active) return MBSR_OK;
    const mbsri_group g = mbsri_group_of(m, d, i);
    const int rank = mbsri_group_rank(d, &g);
    int watched = 0;
    for (int k = 0; k < g.members; ++k) watched += d->watch.rank[g.member[k]];
    if (rank == watched) return MBSR_OK;
    char label[MBSRI_LABEL];
    return mbsri_fail(&d->error, MBSR_RANK_CHANGED, m->body[i].id, MBSR_NONE,
                      "%s: the rank of its joint%s changes from %d to %d (of %d) at t = %g",
                      mbsri_body_label(m, i, label),
                      g.members > 1 ? " and the massless ones behind it" : "", watched, rank, g.n,
                      d->t);
}

int mbsri_check_ranks(const mbsr_model *m, mbsr_data *d)
{
    int i = 1;
    while (i <= m->bodies && d->rank[i] == m->body[i].n) ++i;
    if (i > m->bodies) return MBSR_OK;
    char label[MBSRI_LABEL];
    const mbsri_body *b = m->body + i;
    return mbsri_fail(
        &d->error, MBSR_UNDETERMINED, b->id, MBSR_NONE,
        "%s: %d of the %d accelerations of its joint are not determined: they move no mass",
        mbsri_body_label(m, i, label), b->n - d->rank[i], b->n);
}

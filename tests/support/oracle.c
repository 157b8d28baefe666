/* Dense oracle for random trees.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "oracle.h"

#include <stdlib.h>
#include <string.h>

void dgesv_(const int *n, const int *nrhs, double *a, const int *lda, int *ipiv, double *b,
            const int *ldb, int *info);
void dsyev_(const char *jobz, const char *uplo, const int *n, double *a, const int *lda, double *w,
            double *work, const int *lwork, int *info, size_t jobz_length, size_t uplo_length);

void dgesvd_(const char *jobu, const char *jobvt, const int *m, const int *n, double *a,
             const int *lda, double *s, double *u, const int *ldu, double *vt, const int *ldvt,
             double *work, const int *lwork, int *info, size_t jobu_length, size_t jobvt_length);

static void solve_many(int n, int columns, double *A, double *B)
{
    int info = 0;
    int *pivots = calloc((size_t)n + 1, sizeof(int));
    if (n > 0) dgesv_(&n, &columns, A, &n, pivots, B, &n, &info);
    free(pivots);
    assert_int_equal(info, 0);
}

void test_solve(int n, double *A, double *b)
{
    solve_many(n, 1, A, b);
}

/* The block rows (8), (9) of all bodies: sparse matrix of K and H, its right-hand sides. */
typedef struct rows {
    double *KH;    /* v x v */
    double *right; /* v x (n + 2): -J, -kI - H V_root, -kII - H A_root */
} rows;

static void fill_rows(const test_tree *tree, const test_oracle *o, const double *u, rows *w)
{
    const int v = o->v;
    double root_p[2] = {0}, root_V[2] = {0}, root_A[2] = {0};
    const double t = 0.3;
    if (tree->root_d) {
        root_p[0] = sin(t), root_V[0] = cos(t), root_A[0] = -sin(t);
        root_p[1] = 0.5 * t * t, root_V[1] = t, root_A[1] = 1.0;
    }
    double *p = calloc((size_t)v + 1, sizeof(double)), *V = calloc((size_t)v + 1, sizeof(double));
    for (int i = 0; i < tree->N; ++i) {
        assert_int_equal(mbsr_body_pose(tree->model, tree->data, i, p + o->row[i]), 0);
        assert_int_equal(mbsr_body_twist(tree->model, tree->data, i, V + o->row[i]), 0);
    }
    for (int i = 0, column = 0; i < tree->N; ++i) {
        const test_joint *j = tree->joint + i;
        const int d = j->d, pred = tree->parent[i], at = o->row[i];
        double K[TEST_MAX_D * TEST_MAX_D] = {0}, H[TEST_MAX_D * TEST_MAX_D] = {0},
                              J[TEST_MAX_D * TEST_MAX_D] = {0};
        double kI[TEST_MAX_D] = {0}, kII[TEST_MAX_D] = {0}, q[TEST_MAX_D];
        int q_index, n;
        assert_int_equal(mbsr_body_coordinates(tree->model, i, &q_index, NULL, NULL, &n), 0);
        /* the callbacks alone, not the library, say what K, H, J, kI, kII are; q is recovered by
         * the caller's u order */
        const double *pose = u + tree->nu; /* q follows u in the caller's array */
        memcpy(q, pose + q_index, sizeof(double) * (size_t)n);
        const mbsr_joint_args args = {.user = (void *)j,
                                      .t = t,
                                      .q = q,
                                      .u = u + q_index,
                                      .pred_d = j->d_pred,
                                      .p_pred = pred < 0 ? root_p : p + o->row[pred],
                                      .V_pred = pred < 0 ? root_V : V + o->row[pred],
                                      .p = p + at,
                                      .V = V + at};
        test_joint_table.jacobians(&args, K, H, J, kI);
        test_joint_table.bias(&args, kII);
        for (int r = 0; r < d; ++r) {
            for (int s = 0; s < d; ++s) w->KH[(at + s) * v + at + r] = K[s * d + r];
            for (int s = 0; pred >= 0 && s < j->d_pred; ++s)
                w->KH[(o->row[pred] + s) * v + at + r] = H[s * d + r];
            for (int s = 0; s < n; ++s) w->right[(column + s) * v + at + r] = -J[s * d + r];
            w->right[o->n * v + at + r] = -kI[r];
            w->right[(o->n + 1) * v + at + r] = -kII[r];
            for (int s = 0; pred < 0 && s < j->d_pred; ++s) {
                w->right[o->n * v + at + r] -= H[s * d + r] * root_V[s];
                w->right[(o->n + 1) * v + at + r] -= H[s * d + r] * root_A[s];
            }
        }
        column += n;
    }
    free(p);
    free(V);
}

void test_oracle_make(test_oracle *o, const test_tree *tree, const double *u)
{
    *o = (test_oracle){.n = tree->nu};
    o->row = calloc((size_t)tree->N, sizeof(int));
    for (int i = 0; i < tree->N; ++i) {
        o->row[i] = o->v;
        o->v += tree->joint[i].d;
    }
    const int v = o->v, n = o->n;
    rows w = {calloc((size_t)(v * v), sizeof(double)),
              calloc((size_t)(v * (n + 2)), sizeof(double))};
    fill_rows(tree, o, u, &w);
    solve_many(v, n + 2, w.KH, w.right);
    free(w.KH);
    o->B = w.right;
    o->bI = w.right + (size_t)(n * v);
    o->bII = o->bI + v;

    o->M = calloc((size_t)(v * v), sizeof(double));
    o->mass = calloc((size_t)(n * n) + 1, sizeof(double));
    for (int i = 0; i < tree->N; ++i) {
        const int d = tree->joint[i].d, at = o->row[i];
        for (int s = 0; s < d; ++s) {
            for (int r = 0; r < d; ++r) o->M[(at + s) * v + at + r] = tree->mass[i][s * d + r];
        }
    }
    double *MB = calloc((size_t)(v * n) + 1, sizeof(double));
    for (int c = 0; c < n; ++c) {
        for (int s = 0; s < v; ++s) {
            for (int r = 0; r < v; ++r) MB[c * v + r] += o->M[s * v + r] * o->B[c * v + s];
        }
    }
    for (int c = 0; c < n; ++c) {
        for (int b = 0; b < n; ++b) {
            for (int r = 0; r < v; ++r) o->mass[c * n + b] += o->B[b * v + r] * MB[c * v + r];
        }
    }
    free(MB);
}

void test_oracle_free(test_oracle *o)
{
    free(o->B);
    free(o->M);
    free(o->mass);
    free(o->row);
}

int test_rank(const test_oracle *o, int count, const int *use, double *gap)
{
    double *A = calloc((size_t)(count * count) + 1, sizeof(double)),
           *w = calloc((size_t)count + 1, sizeof(double));
    const int lwork = 10 * count + 10;
    double *work = calloc((size_t)lwork, sizeof(double));
    const int n = o->n;
    const double *matrix = o->mass;
    const double longest = test_largest(o->v * n, o->B),
                 size = longest * longest * test_largest(o->v * o->v, o->M);
    for (int b = 0; b < count; ++b) {
        for (int a = 0; a < count; ++a) {
            const double da = matrix[use[a] * n + use[a]], db = matrix[use[b] * n + use[b]],
                         scale = da * db;
            A[b * count + a] = da > 1e-14 * size && db > 1e-14 * size
                                   ? matrix[use[b] * n + use[a]] / sqrt(scale)
                                   : 0.0;
        }
    }
    int info = 0, rank = 0;
    if (count > 0) dsyev_("N", "L", &count, A, &count, w, work, &lwork, &info, 1, 1);
    assert_int_equal(info, 0);
    double kept = 1.0, dropped = 0.0;
    for (int k = 0; k < count; ++k) {
        if (w[k] > 1e-9) {
            ++rank;
            kept = fmin(kept, w[k]);
        } else {
            dropped = fmax(dropped, fabs(w[k]));
        }
    }
    if (gap) *gap = dropped > 0.0 ? kept / dropped : INFINITY;
    free(A);
    free(w);
    free(work);
    return rank;
}

void test_null_projection(int n, const double *matrix, int rank, double *z)
{
    double *A = calloc((size_t)(n * n) + 1, sizeof(double)),
           *w = calloc((size_t)n + 1, sizeof(double));
    double *result = calloc((size_t)n + 1, sizeof(double));
    const int lwork = 10 * n + 10;
    double *work = calloc((size_t)lwork, sizeof(double));
    memcpy(A, matrix, sizeof(double) * (size_t)(n * n));
    int info = 0;
    dsyev_("V", "L", &n, A, &n, w, work, &lwork, &info, 1, 1);
    assert_int_equal(info, 0);
    for (int l = 0; l < n - rank; ++l) {
        double weight = 0.0;
        for (int k = 0; k < n; ++k) weight += A[l * n + k] * z[k];
        for (int k = 0; k < n; ++k) result[k] += weight * A[l * n + k];
    }
    memcpy(z, result, sizeof(double) * (size_t)n);
    free(A);
    free(w);
    free(result);
    free(work);
}

/* Each column, then each row divided by its largest entry, unless that is rounding. */
static void scale(int n, double *A, double tiny)
{
    for (int pass = 0; pass < 2; ++pass) {
        const int along = pass ? n : 1, across = pass ? 1 : n;
        for (int c = 0; c < n; ++c) {
            double size = 0.0;
            for (int r = 0; r < n; ++r) size = fmax(size, fabs(A[c * across + r * along]));
            for (int r = 0; r < n; ++r) {
                A[c * across + r * along] = size > tiny ? A[c * across + r * along] / size : 0.0;
            }
        }
    }
}

int test_singular_rank(int n, const double *A)
{
    const int lwork = 10 * n + 10, one = 1;
    double *copy = calloc((size_t)(n * n) + 1, sizeof(double)),
           *s = calloc((size_t)n + 1, sizeof(double));
    double *work = calloc((size_t)lwork, sizeof(double)), none = 0.0;
    memcpy(copy, A, sizeof(double) * (size_t)(n * n));
    scale(n, copy, 1e-11 * test_largest(n * n, A));
    int info = 0, rank = 0;
    if (n > 0)
        dgesvd_("N", "N", &n, &n, copy, &n, s, &none, &one, &none, &one, work, &lwork, &info, 1, 1);
    assert_int_equal(info, 0);
    while (rank < n && s[rank] > 1e-9 * s[0]) ++rank;
    free(copy);
    free(s);
    free(work);
    return rank;
}

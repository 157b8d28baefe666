/* A bar of solid elements with the averages of both ends as markers, and dense linear algebra for
 * it that shares nothing with the library.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SOLID_H
#define TEST_SOLID_H

#include "close.h"
#include "hex8.h"

#include <mbsrank/fe.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The last of the solvers that this build has. */
#ifdef TEST_WITH_CHOLMOD
static const int test_solvers = MBSR_FE_SPARSE;
#else
static const int test_solvers = MBSR_FE_DENSE;
#endif

void dsygv_(const int *itype, const char *jobz, const char *uplo, const int *n, double *a,
            const int *lda, double *b, const int *ldb, double *w, double *work, const int *lwork,
            int *info, size_t jobz_length, size_t uplo_length);
void dgeqrf_(const int *m, const int *n, double *a, const int *lda, double *tau, double *work,
             const int *lwork, int *info);
void dormqr_(const char *side, const char *trans, const int *m, const int *n, const int *k,
             const double *a, const int *lda, const double *tau, double *c, const int *ldc,
             double *work, const int *lwork, int *info, size_t side_length, size_t trans_length);
void dgesv_(const int *n, const int *nrhs, double *a, const int *lda, int *ipiv, double *b,
            const int *ldb, int *info);

typedef struct test_solid {
    hex8_block block;
    hex8_mesh mesh;
    int *ends[2];
    mbsr_fe_marker marker[2];
    mbsr_fe_def def; /* points into the rest */
} test_solid;

static inline void test_solid_define(test_solid *s)
{
    mbsr_fe_matrix A = {.rows = s->mesh.dofs,
                        .entries = (size_t)s->mesh.entries,
                        .row = s->mesh.row,
                        .column = s->mesh.column};
    s->def = mbsr_default_fe_def();
    s->def.K = s->def.M = A;
    s->def.K.value = s->mesh.K;
    s->def.M.value = s->mesh.M;
    s->def.nodes = s->mesh.nodes;
    s->def.x = s->mesh.x;
    s->def.markers = 2;
    s->def.marker = s->marker;
}

/* 1 m long, 0.1 wide, 0.08 high; its root is the face x = 0, its tip, loaded, the face x = 1. */
static inline test_solid *test_bar(int nx, int ny, int nz)
{
    test_solid *s = calloc(1, sizeof *s);
    s->block = (hex8_block){.elements = {nx, ny, nz},
                            .size = {1.0, 0.1, 0.08},
                            .E = 2.1e8,
                            .nu = 0.3,
                            .rho = 780.0,
                            .incompatible = 1};
    assert_int_equal(hex8_make(&s->block, &s->mesh), 0);
    const int nodes = (ny + 1) * (nz + 1);
    for (int end = 0; end < 2; ++end) {
        s->ends[end] = malloc((size_t)nodes * sizeof(int));
        for (int k = 0; k < nodes; ++k)
            s->ends[end][k] = hex8_node(&s->block, end * nx, k / (nz + 1), k % (nz + 1));
        s->marker[end] = (mbsr_fe_marker){
            .name = end ? "tip" : "root", .nodes = nodes, .node = s->ends[end], .loaded = end};
    }
    test_solid_define(s);
    return s;
}

static inline void test_solid_destroy(test_solid *s)
{
    hex8_destroy(&s->mesh);
    free(s->ends[0]);
    free(s->ends[1]);
    free(s);
}

/* A in full. */
static inline double *test_dense(const test_solid *s, const double *value)
{
    const size_t n = (size_t)s->mesh.dofs;
    double *A = calloc(n * n, sizeof *A);
    for (int k = 0; k < s->mesh.entries; ++k) {
        const size_t i = (size_t)s->mesh.row[k], j = (size_t)s->mesh.column[k];
        A[n * j + i] += value[k];
        if (i != j) A[n * i + j] += value[k];
    }
    return A;
}

/* C (n x 6) of an end: mean displacement and rotation by least squares. */
static inline void test_marker_columns(const test_solid *s, int end, double *C)
{
    const size_t n = (size_t)s->mesh.dofs;
    const int nodes = s->marker[end].nodes;
    double mean[3] = {0.0}, normal[9] = {0.0}, moment[3];
    int pivots[3], three = 3, info;
    memset(C, 0, 6 * n * sizeof *C);
    for (int k = 0; k < nodes; ++k) {
        for (int c = 0; c < 3; ++c) mean[c] += s->mesh.x[3 * s->ends[end][k] + c] / nodes;
    }
    for (int k = 0; k < nodes; ++k) {
        const double *x = s->mesh.x + 3 * s->ends[end][k];
        const double d[3] = {x[0] - mean[0], x[1] - mean[1], x[2] - mean[2]};
        for (int a = 0; a < 3; ++a) {
            for (int b = 0; b < 3; ++b)
                normal[3 * a + b] +=
                    (a == b ? d[0] * d[0] + d[1] * d[1] + d[2] * d[2] : 0.0) - d[a] * d[b];
        }
    }
    for (int k = 0; k < nodes; ++k) {
        const int node = s->ends[end][k];
        const double *x = s->mesh.x + 3 * node;
        const double d[3] = {x[0] - mean[0], x[1] - mean[1], x[2] - mean[2]};
        for (int c = 0; c < 3; ++c) {
            const double e[3] = {c == 0, c == 1, c == 2};
            double S[9];
            memcpy(S, normal, sizeof S);
            moment[0] = d[1] * e[2] - d[2] * e[1];
            moment[1] = d[2] * e[0] - d[0] * e[2];
            moment[2] = d[0] * e[1] - d[1] * e[0];
            const int one = 1;
            dgesv_(&three, &one, S, &three, pivots, moment, &three, &info);
            assert_int_equal(info, 0);
            for (int a = 0; a < 3; ++a) C[n * (size_t)a + (size_t)(3 * node + c)] = moment[a];
            C[n * (size_t)(3 + c) + (size_t)(3 * node + c)] = 1.0 / nodes;
        }
    }
}

/* A <- Q^T A Q with Q of the factors of C: the first six rows are then held. */
static inline void test_turn(int n, const double *C, const double *tau, double *A)
{
    const int six = 6, lwork = 64 * n;
    int info;
    double *work = malloc((size_t)lwork * sizeof *work);
    dormqr_("L", "T", &n, &n, &six, C, &n, tau, A, &n, work, &lwork, &info, 1, 1);
    assert_int_equal(info, 0);
    dormqr_("R", "N", &n, &n, &six, C, &n, tau, A, &n, work, &lwork, &info, 1, 1);
    assert_int_equal(info, 0);
    free(work);
}

/* All frequencies, rad/s, of the body free, without the rigid motions, or with the mean of its root
 * held; how many. */
static inline int test_solid_frequencies(const test_solid *s, int free_body, double *omega)
{
    const int n = s->mesh.dofs, six = 6, one = 1, rows = free_body ? n : n - 6, lwork = 64 * n;
    int info;
    double *K = test_dense(s, s->mesh.K), *M = test_dense(s, s->mesh.M),
           *C = malloc(6 * (size_t)n * sizeof *C), *w = malloc((size_t)n * sizeof *w),
           *work = malloc((size_t)lwork * sizeof *work), tau[6];
    if (!free_body) {
        test_marker_columns(s, 0, C);
        dgeqrf_(&n, &six, C, &n, tau, work, &lwork, &info);
        assert_int_equal(info, 0);
        test_turn(n, C, tau, K);
        test_turn(n, C, tau, M);
    }
    const size_t first = free_body ? 0 : 6 * (size_t)n + 6;
    dsygv_(&one, "N", "L", &rows, K + first, &n, M + first, &n, w, work, &lwork, &info, 1, 1);
    assert_int_equal(info, 0);
    for (int k = 0; k < n - 6; ++k) omega[k] = sqrt(w[free_body ? k + 6 : k]);
    free(K);
    free(M);
    free(C);
    free(w);
    free(work);
    return n - 6;
}

/* F (6 x 6): motion of the tip, rotation first, under unit loads there with the root held,
 *
 *   [K C; C^T 0] (u; reaction) = (C_tip f; 0) */
static inline void test_solid_flexibility(const test_solid *s, double F[36])
{
    const int n = s->mesh.dofs, all = n + 6, six = 6;
    const size_t N = (size_t)all;
    double *K = test_dense(s, s->mesh.K), *A = calloc(N * N, sizeof *A),
           *C = malloc(6 * (size_t)n * sizeof *C), *tip = malloc(6 * (size_t)n * sizeof *tip),
           *u = calloc(6 * N, sizeof *u);
    int *pivots = malloc(N * sizeof *pivots), info;
    test_marker_columns(s, 0, C);
    test_marker_columns(s, 1, tip);
    for (int j = 0; j < n; ++j) memcpy(A + N * (size_t)j, K + n * j, (size_t)n * sizeof *K);
    for (int c = 0; c < 6; ++c) {
        for (int k = 0; k < n; ++k) {
            /* of the size of K */
            const double entry = C[n * c + k] * K[0];
            A[N * (size_t)(n + c) + (size_t)k] = A[N * (size_t)k + (size_t)(n + c)] = entry;
            u[N * (size_t)c + (size_t)k] = tip[n * c + k];
        }
    }
    dgesv_(&all, &six, A, &all, pivots, u, &all, &info);
    assert_int_equal(info, 0);
    for (int c = 0; c < 6; ++c) {
        for (int r = 0; r < 6; ++r) {
            F[6 * c + r] = 0.0;
            for (int k = 0; k < n; ++k)
                F[6 * c + r] += tip[n * r + k] * u[N * (size_t)c + (size_t)k];
        }
    }
    free(K);
    free(A);
    free(C);
    free(tip);
    free(u);
    free(pivots);
}

/* The same of modal data with diagonal K. */
static inline void test_tip_flexibility(const mbsr_flex_def *data, int marker, double F[36])
{
    for (int k = 0; k < 36; ++k) F[k] = 0.0;
    for (int a = 0; a < data->modes; ++a) {
        const double *Phi = data->marker[marker].Phi + 3 * a,
                     *Psi = data->marker[marker].Psi + 3 * a;
        const double motion[6] = {Psi[0], Psi[1], Psi[2], Phi[0], Phi[1], Phi[2]};
        for (int k = 0; k < 36; ++k)
            F[k] += motion[k / 6] * motion[k % 6] / data->K[a * (data->modes + 1)];
    }
}

#endif

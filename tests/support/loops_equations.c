/* Random trees with loops, and their dense equations: see loops_equations.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops_equations.h"

#include "algebra/lapack.h"

#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

/* ---- random mechanisms ---- */

static void vector(test_rng *rng, double *x)
{
    test_fill(rng, 3, x);
}

static mbsr_joint random_joint(test_rng *rng, bool plane)
{
    double x[3], y[3], p[3];
    vector(rng, x);
    vector(rng, y);
    vector(rng, p);
    const mbsr_frame A = mbsr_frame_rotated(p, y, 1.0);
    const double z[3] = {0.0, 0.0, 1.0}, flat[3] = {x[0], x[1], 0.0};
    const mbsr_frame on = mbsr_frame_at(p[0], p[1], 0.0);
    const int kind = test_integer(rng, 0, 9);
    if (plane && kind < 7) return mbsr_joint_revolute(&on, NULL, z);
    if (plane) return mbsr_joint_prismatic(&on, NULL, flat);
    if (kind < 5) return mbsr_joint_revolute(&A, NULL, x);
    switch (kind) {
    case 5: return mbsr_joint_cylindrical(&A, NULL, x);
    case 6: return mbsr_joint_universal(&A, NULL, x, y);
    case 7: return mbsr_joint_spherical(&A, NULL);
    case 8: return mbsr_joint_prismatic(&A, NULL, x);
    default: return mbsr_joint_translational(&A, NULL);
    }
}

static void add_closure(loops *s, test_rng *rng, int a, int b, bool plane)
{
    double p[3], q[3], x[6];
    vector(rng, p);
    vector(rng, q);
    test_fill(rng, 6, x);
    mbsr_closure_def def;
    switch (test_integer(rng, 0, 5)) {
    case 0: def = mbsr_closure_rows(a, p, b, q, test_integer(rng, 1, 2), x); break;
    case 1: def = mbsr_closure_distance(a, p, b, q, 1.0); break;
    case 2: {
        const mbsr_joint joint = random_joint(rng, plane);
        assert_ok(mbsr_model_add_loop_joint(s->m, "loop joint", a, &joint, b, NULL, NULL, NULL),
                  mbsr_model_error(s->m));
        return;
    }
    default: def = mbsr_closure_ball(a, p, b, q); break;
    }
    if (test_integer(rng, 0, 5) == 0) {
        def.stiffness[0] = 50.0;
        def.damping[0] = 2.0;
    }
    assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
    if (test_integer(rng, 0, 4) == 0)
        assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
}

/* In the plane of space many rows are redundant. `light`: how many of ten bodies have no mass. */
void loops_make_random(loops *s, test_rng *rng, int bodies, int closures, bool plane, int light)
{
    loops_begin(s, NULL);
    for (int k = 0; k < bodies; ++k) {
        double com[3];
        const double tensor[6] = {0.3, 0.4, 0.5, 0.01, 0.02, -0.03};
        mbsr_body_def body = mbsr_default_body_def();
        vector(rng, com);
        body.parent = test_integer(rng, k > 3 ? k - 4 : -1, k - 1);
        body.joint = random_joint(rng, plane);
        if (test_integer(rng, 0, 9) >= light)
            body.inertia = mbsr_inertia_rigid(1.0 + 0.5 * test_uniform(rng), com, tensor);
        assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
    }
    for (int k = 0; k < closures; ++k) {
        const int a = test_integer(rng, 0, bodies - 1);
        int b = test_integer(rng, a > 4 ? a - 5 : -1, bodies - 1);
        if (a == b) b = MBSR_GROUND;
        add_closure(s, rng, a, b, plane);
    }
    const int two[2] = {0, 1}, coordinate[2] = {0, 0};
    const mbsr_closure_def gear =
        mbsr_closure_coupling(2, two, coordinate, (double[2]){1.0, -0.4}, 0.3);
    if (plane && test_integer(rng, 0, 3) == 0)
        assert_ok(mbsr_model_add_closure(s->m, &gear, NULL), mbsr_model_error(s->m));
    loops_build(s);
}

/* ---- loops_equations equations ---- */

void loops_find_equations(const loops *s, loops_equations *e, const double *tau)
{
    loops copy = *s;
    double C[LOOPS_MOST * LOOPS_MOST], bias[LOOPS_MOST], zero[LOOPS_MOST] = {0.0};
    const mbsr_error *error = mbsr_data_error(s->d);
    loops_rows(&copy, 0.0, s->q, s->u, C, NULL, NULL, bias);
    assert_ok(mbsr_mass_matrix(s->m, s->d, e->M), error);
    assert_ok(mbsr_inverse_dynamics(s->m, s->d, 0.0, s->q, s->u, zero, NULL, e->g), error);
    e->n = s->nu;
    for (int k = 0; k < e->n; ++k) e->g[k] = (tau ? tau[k] : 0.0) - e->g[k];
    bool rigid[LOOPS_MOST];
    for (int c = 0; c < mbsr_model_closures(s->m); ++c) {
        int row, rows;
        assert_ok(mbsr_closure_indices(s->m, c, &row, &rows, NULL, NULL), NULL);
        for (int k = 0; k < rows; ++k) rigid[row + k] = !(mbsr_closure_stiffness(s->m, c, k) > 0.0);
    }
    e->m = 0;
    for (int k = 0; k < s->rows; ++k) e->m += rigid[k];
    for (int k = 0, to = 0; k < s->rows; ++k) {
        if (!rigid[k]) continue;
        e->bias[to] = bias[k];
        for (int j = 0; j < e->n; ++j) {
            const double entry = C[j * s->rows + k];
            e->C[j * e->m + to] = fabs(entry) > 1e-14 ? entry : 0.0;
        }
        ++to;
    }
    e->N = e->n + e->m;
}

/* [P -C^T; C 0] x = (g; b) by singular values. */
void loops_solve(loops_equations *e, const double *P, const double *g, const double *b)
{
    const int N = e->N, n = e->n, lwork = mbsri_lapack_svd_work(N);
    const size_t NN = (size_t)N * (size_t)N;
    double *K = calloc(3 * NN + (size_t)N + (size_t)lwork, sizeof *K), *U = K + NN, *V = U + NN,
           *sigma = V + NN, *work = sigma + N, right[2 * LOOPS_MOST];
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) K[j * N + i] = P[j * n + i];
        for (int k = 0; k < e->m; ++k) {
            K[j * N + n + k] = e->C[j * e->m + k];
            K[(n + k) * N + j] = -e->C[j * e->m + k];
        }
    }
    memcpy(right, g, (size_t)n * sizeof *g);
    for (int k = 0; k < e->m; ++k) right[n + k] = b ? b[k] : 0.0;
    assert_int_equal(mbsri_lapack_svd(N, K, sigma, U, V, work, lwork), 0);
    memset(e->x, 0, sizeof e->x);
    e->clear = true;
    e->moves = false;
    e->left = 0.0;
    for (int l = 0; l < N; ++l) {
        const double *u = U + l * N, *v = V + l * N;
        double part = 0.0;
        for (int k = 0; k < N; ++k) part += u[k] * right[k];
        if (sigma[l] > 1e-4) {
            for (int k = 0; k < N; ++k) e->x[k] += part / sigma[l] * v[k];
            continue;
        }
        e->clear = e->clear && sigma[l] < 1e-13 * sigma[0];
        e->left = fmax(e->left, fabs(part));
        e->moves = e->moves || test_largest(n, v) > 1e-6;
    }
    free(K);
}

/* C^T lambda of the rigid rows, of the library and of these equations. */
void loops_compare_forces(loops *s, const loops_equations *e, const double *lambda, double sign,
                          double size)
{
    double rigid[LOOPS_MOST] = {0.0}, both[LOOPS_MOST];
    for (int c = 0; c < mbsr_model_closures(s->m); ++c) {
        int row, rows;
        assert_ok(mbsr_closure_indices(s->m, c, &row, &rows, NULL, NULL), NULL);
        for (int k = row; k < row + rows; ++k)
            rigid[k] = mbsr_closure_stiffness(s->m, c, k - row) > 0.0 ? 0.0 : lambda[k];
    }
    assert_ok(mbsr_closures_transpose(s->m, s->d, rigid, both), mbsr_data_error(s->d));
    for (int j = 0; j < e->n; ++j) {
        double sum = 0.0;
        for (int k = 0; k < e->m; ++k) sum += sign * e->C[j * e->m + k] * e->x[e->n + k];
        assert_close(both[j], sum, 1e-9 * size);
    }
}

/* ---- both ways: by the vectorised sweeps, and along the tree for any kind of body ---- */

/* Without its plan of loops a model is left to the latter. */
mbsri_sweep_loops *loops_hide_plan(mbsr_model *m)
{
    mbsri_sweep_loops *plan = m->tree.evaluated->loops;
    m->tree.evaluated->loops = NULL;
    return plan;
}

void loops_show_plan(mbsr_model *m, mbsri_sweep_loops *plan)
{
    m->tree.evaluated->loops = plan;
}

void loops_make_case(loops *s, test_rng *rng, uint64_t seed)
{
    static const int light[4] = {0, 0, 2, 6};
    *rng = test_seed(seed);
    loops_make_random(s, rng, test_integer(rng, 2, 9), test_integer(rng, 1, 4), seed % 2 == 0,
                      light[seed / 2 % 4]);
}

bool loops_too_large(const loops *s)
{
    return s->nq > LOOPS_MOST || s->rows > LOOPS_MOST;
}

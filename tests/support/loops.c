/* Mechanisms with closed loops, and their dense equations of motion.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   [M -C^T; C 0] (u'; lambda) = (-h; -bias),    h: inverse dynamics of the tree at u' = 0 */
#include "loops.h"

#include "algebra/lapack.h"

#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

void loops_begin(loops *s, const mbsr_root *root)
{
    mbsr_model_def def = mbsr_default_model_def();
    if (root) def.root = *root;
    memset(s, 0, sizeof *s);
    assert_ok(mbsr_model_create(&def, &s->m, NULL), NULL);
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    assert_ok(mbsr_model_add_force(s->m, &gravity, NULL), mbsr_model_error(s->m));
}

void loops_build(loops *s)
{
    assert_ok(mbsr_model_finish(s->m), mbsr_model_error(s->m));
    assert_ok(mbsr_data_create(s->m, &s->d, NULL), NULL);
    s->nq = mbsr_model_nq(s->m);
    s->nu = mbsr_model_nu(s->m);
    s->rows = mbsr_model_rows(s->m);
    s->position_rows = mbsr_model_position_rows(s->m);
    s->size = mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM);
}

void loops_finish(loops *s)
{
    loops_build(s);
    assert_true(s->nq <= LOOPS_MOST && s->rows <= LOOPS_MOST);
    assert_int_equal(s->size, s->nq + 2 * s->nu + s->rows + s->position_rows);
}

void loops_free(loops *s)
{
    mbsr_data_destroy(s->d);
    mbsr_model_destroy(s->m);
}

int loops_rod(loops *s, const char *name, int parent, double x, double y, double mass,
              double length)
{
    int id;
    mbsr_body_def body = mbsr_default_body_def();
    body.name = name;
    body.parent = parent;
    body.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){x, y, 0.0},
                                            (mbsr_planar_frame){0.0, 0.0, 0.0});
    if (mass > 0.0)
        body.inertia = mbsr_inertia_planar(mass, (double[2]){0.5 * length, 0.0},
                                           mass * length * length / 12.0);
    assert_ok(mbsr_model_add_body(s->m, &body, &id), mbsr_model_error(s->m));
    return id;
}

int loops_pin(loops *s, const char *name, int a, double ax, double ay, int b, double bx, double by)
{
    int id;
    mbsr_closure_def pin =
        mbsr_closure_ball(a, (double[3]){ax, ay, 0.0}, b, (double[3]){bx, by, 0.0});
    pin.name = name;
    assert_ok(mbsr_model_add_closure(s->m, &pin, &id), mbsr_model_error(s->m));
    return id;
}

void loops_rows(loops *s, double t, const double *q, const double *u, double *C, double *g,
                double *rate, double *bias)
{
    double e[LOOPS_MOST] = {0.0};
    const mbsr_error *error = mbsr_data_error(s->d);
    assert_ok(mbsr_stage_positions(s->m, s->d, t, q), error);
    if (g) assert_ok(mbsr_closures_gap(s->m, s->d, g), error);
    for (int k = 0; k < s->nu && C; ++k) {
        e[k] = 1.0;
        assert_ok(mbsr_closures_apply(s->m, s->d, e, C + k * s->rows), error);
        e[k] = 0.0;
    }
    if (rate || bias) assert_ok(mbsr_stage_velocities(s->m, s->d, u), error);
    if (rate) assert_ok(mbsr_closures_rate(s->m, s->d, rate), error);
    if (bias) assert_ok(mbsr_closures_bias(s->m, s->d, bias), error);
}

/* Least squares, least norm: A (r x c) x = b; returns the rank. */
static int solve(int r, int c, const double *A, const double *b, double *x)
{
    const int most = r > c ? r : c, lwork = mbsri_lapack_gelsy_work(r, c);
    double *copy = malloc((size_t)(r * c) * sizeof *copy),
           *right = calloc((size_t)most, sizeof *right),
           *work = malloc((size_t)lwork * sizeof *work);
    int *pivots = calloc((size_t)c, sizeof *pivots), rank;
    memcpy(copy, A, (size_t)(r * c) * sizeof *copy);
    memcpy(right, b, (size_t)r * sizeof *right);
    assert_int_equal(mbsri_lapack_gelsy(r, c, copy, right, 1e-11, pivots, &rank, work, lwork), 0);
    memcpy(x, right, (size_t)c * sizeof *x);
    free(copy);
    free(right);
    free(work);
    free(pivots);
    return rank;
}

void loops_close(loops *s, double t)
{
    double C[LOOPS_MOST * LOOPS_MOST], g[LOOPS_MOST], A[LOOPS_MOST * LOOPS_MOST], x[LOOPS_MOST];
    assert_int_equal(s->nq, s->nu);
    for (int i = 0; i < 50; ++i) {
        loops_rows(s, t, s->q, s->u, C, g, NULL, NULL);
        if (test_largest(s->position_rows, g) < 1e-14) return;
        /* position rows among the velocity rows */
        int to = 0;
        for (int c = 0; c < mbsr_model_closures(s->m); ++c) {
            int row, held;
            assert_ok(mbsr_closure_indices(s->m, c, &row, NULL, NULL, &held), NULL);
            for (int k = 0; k < held; ++k, ++to) {
                for (int j = 0; j < s->nu; ++j)
                    A[j * s->position_rows + to] = C[j * s->rows + row + k];
            }
        }
        solve(s->position_rows, s->nu, A, g, x);
        for (int j = 0; j < s->nu; ++j) s->q[j] -= x[j];
    }
}

/* [M -C^T; C 0] x = b. */
static int solve_saddle(loops *s, double t, const double *b, double *x)
{
    double M[LOOPS_MOST * LOOPS_MOST], C[LOOPS_MOST * LOOPS_MOST];
    const int n = s->nu, m = s->rows, N = n + m;
    double *A = calloc((size_t)(N * N), sizeof *A);
    loops_rows(s, t, s->q, s->u, C, NULL, NULL, NULL);
    assert_ok(mbsr_stage_velocities(s->m, s->d, s->u), mbsr_data_error(s->d));
    assert_ok(mbsr_mass_matrix(s->m, s->d, M), mbsr_data_error(s->d));
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) A[j * N + i] = M[j * n + i];
        for (int k = 0; k < m; ++k) {
            A[j * N + n + k] = C[j * m + k];
            A[(n + k) * N + j] = -C[j * m + k];
        }
    }
    const int rank = solve(N, N, A, b, x);
    free(A);
    return rank;
}

int loops_accelerations(loops *s, double t, const double *tau)
{
    double b[2 * LOOPS_MOST], x[2 * LOOPS_MOST], zero[LOOPS_MOST] = {0.0}, h[LOOPS_MOST];
    loops_rows(s, t, s->q, s->u, NULL, NULL, NULL, b + s->nu);
    assert_ok(mbsr_inverse_dynamics(s->m, s->d, t, s->q, s->u, zero, NULL, h),
              mbsr_data_error(s->d));
    for (int k = 0; k < s->nu; ++k) b[k] = -h[k] + (tau ? tau[k] : 0.0);
    for (int k = 0; k < s->rows; ++k) b[s->nu + k] *= -1.0;
    const int rank = solve_saddle(s, t, b, x);
    memcpy(s->udot, x, (size_t)s->nu * sizeof *x);
    memcpy(s->lambda, x + s->nu, (size_t)s->rows * sizeof *x);
    return rank;
}

void loops_velocities(loops *s, double t)
{
    double b[2 * LOOPS_MOST] = {0.0}, x[2 * LOOPS_MOST];
    loops_rows(s, t, s->q, s->u, NULL, NULL, b + s->nu, NULL);
    for (int k = 0; k < s->rows; ++k) b[s->nu + k] *= -1.0;
    solve_saddle(s, t, b, x);
    for (int k = 0; k < s->nu; ++k) s->u[k] += x[k];
}

void loops_state(loops *s, double t, double *y, double *yp)
{
    const int first = s->nq + 2 * s->nu;
    double F[8 * LOOPS_MOST];
    const mbsr_error *error = mbsr_data_error(s->d);
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, t, s->q, s->u, y), error);
    memset(yp, 0, (size_t)s->size * sizeof *yp);
    memcpy(yp + first, s->lambda, (size_t)s->rows * sizeof *yp);
    assert_ok(mbsr_dae_residual(s->m, s->d, MBSR_DAE_MOMENTUM, t, y, yp, F), error);
    for (int k = 0; k < s->nq + s->nu; ++k) yp[k] = -F[k];
    memcpy(yp + s->nq + s->nu, s->udot, (size_t)s->nu * sizeof *yp);
}

void loops_random_state(loops *s, test_rng *rng)
{
    double y[8 * LOOPS_MOST];
    test_fill(rng, s->nq, s->q);
    test_fill(rng, s->nu, s->u);
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y),
              mbsr_data_error(s->d));
    memcpy(s->q, y, (size_t)s->nq * sizeof *y); /* quaternions of length 1 */
}

void loops_add_parallelograms(loops *s, int count)
{
    int from = MBSR_GROUND;
    for (int k = 0; k < count; ++k) {
        const double at = k > 0 ? 2.0 : 0.0;
        const int a = loops_rod(s, NULL, from, at, 0.0, 1.0, 1.0),
                  top = loops_rod(s, NULL, a, 1.0, 0.0, 2.0, 2.0),
                  b = loops_rod(s, NULL, from, at + 1.0, 0.0, 1.0, 1.0),
                  c = loops_rod(s, NULL, from, at + 2.0, 0.0, k % 2 ? 0.0 : 1.0, 1.0);
        loops_pin(s, NULL, top, 1.0, 0.0, b, 1.0, 0.0);
        loops_pin(s, NULL, top, 2.0, 0.0, c, 1.0, 0.0);
        from = top;
    }
}

int loops_inverse_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                           const double *u, const double *udot, int count, const int *rate,
                           double *tau, double *lambda)
{
    const mbsr_motors motors = {count, rate};
    const int status = mbsr_inverse_dynamics(m, d, t, q, u, udot, &motors, tau);
    return status ? status : mbsr_closures_lambda(m, d, lambda);
}

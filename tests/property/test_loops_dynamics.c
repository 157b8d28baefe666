/* Forward and inverse dynamics of trees with loops, massless bodies, redundant and stiff rows against dense
 * equations that are solved by singular values.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   forward    [M -C^T; C 0] (u'; lambda) = (g; -bias) with the rigid rows; u' is unique where no motion is in
 *              the kernels of both M and C, lambda up to the kernel of C^T
 *   inverse    B tau + C^T lambda = need, of all tau that do this the shortest: tau = B^T x with C x = 0 */
#include "counting.h"
#include "kernels.h"
#include "loops.h"

#include "algebra/lapack.h"
#include "sweeps/loops.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 2 * LOOPS_MOST };

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
    const mbsr_frame A = mbsr_frame_turned(p, y, 1.0);
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
static void make(loops *s, test_rng *rng, int bodies, int closures, bool plane, int light)
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

/* ---- dense equations ---- */

typedef struct dense {
    int n, m, N;
    double M[LOOPS_MOST * LOOPS_MOST], C[LOOPS_MOST * LOOPS_MOST]; /* n x n, m x n: rigid rows */
    double g[LOOPS_MOST], bias[LOOPS_MOST];
    double x[MOST]; /* u', lambda */
    bool clear;     /* whether each singular value is either large or rounding */
    bool moves;     /* whether some motion is in the kernel */
    double left;    /* of the right-hand side */
} dense;

static void find_equations(const loops *s, dense *e, const double *tau)
{
    loops copy = *s;
    double C[LOOPS_MOST * LOOPS_MOST], bias[LOOPS_MOST], zero[LOOPS_MOST] = {0.0};
    const mbsr_error *error = mbsr_data_error(s->d);
    loops_rows(&copy, 0.0, s->q, s->u, C, NULL, NULL, bias);
    assert_ok(mbsr_mass_matrix(s->m, s->d, e->M), error);
    assert_ok(mbsr_inverse_dynamics(s->m, s->d, 0.0, s->q, s->u, zero, e->g), error);
    e->n = s->nu;
    for (int k = 0; k < e->n; ++k) e->g[k] = (tau ? tau[k] : 0.0) - e->g[k];
    bool rigid[LOOPS_MOST];
    for (int c = 0; c < mbsr_model_closures(s->m); ++c) {
        int row, rows;
        assert_ok(mbsr_closure_place(s->m, c, &row, &rows, NULL, NULL), NULL);
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
static void solve(dense *e, const double *P, const double *g, const double *b)
{
    const int N = e->N, n = e->n, lwork = mbsri_lapack_svd_work(N);
    const size_t NN = (size_t)N * (size_t)N;
    double *K = calloc(3 * NN + (size_t)N + (size_t)lwork, sizeof *K), *U = K + NN, *V = U + NN,
           *sigma = V + NN, *work = sigma + N, right[MOST];
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
static void compare_forces(loops *s, const dense *e, const double *lambda, double sign, double size)
{
    double rigid[LOOPS_MOST] = {0.0}, both[LOOPS_MOST];
    for (int c = 0; c < mbsr_model_closures(s->m); ++c) {
        int row, rows;
        assert_ok(mbsr_closure_place(s->m, c, &row, &rows, NULL, NULL), NULL);
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
static mbsri_sweep_loops *hide_loops(mbsr_model *m)
{
    mbsri_sweep_loops *plan = m->evaluated->loops;
    m->evaluated->loops = NULL;
    return plan;
}

static void show_loops(mbsr_model *m, mbsri_sweep_loops *plan)
{
    m->evaluated->loops = plan;
}

/* ---- tests ---- */

enum { SEEDS = 400 };

static void make_case(loops *s, test_rng *rng, uint64_t seed)
{
    static const int light[4] = {0, 0, 2, 6};
    *rng = test_seed(seed);
    make(s, rng, test_integer(rng, 2, 9), test_integer(rng, 1, 4), seed % 2 == 0,
         light[seed / 2 % 4]);
}

static bool too_large(const loops *s)
{
    return s->nq > LOOPS_MOST || s->rows > LOOPS_MOST;
}

/* What forward dynamics finds against these equations. */
static void compare_forward(loops *s, const dense *e, const double *tau, int *compared)
{
    double udot[LOOPS_MOST], lambda[LOOPS_MOST];
    const double size = 1.0 + test_largest(e->N, e->x);
    const int status = mbsr_forward_dynamics(s->m, s->d, 0.0, s->q, s->u, tau, udot);
    if (e->clear && e->moves) {
        assert_int_equal(status, MBSR_UNDETERMINED);
        assert_contains(mbsr_data_error(s->d)->text, "moves no mass, no loop holds it");
    } else if (e->clear && e->left > 1e-3 * size) {
        assert_int_equal(status, MBSR_LOOP_OPEN);
    } else if (e->clear && e->left < 1e-9 * size) {
        assert_ok(status, mbsr_data_error(s->d));
        for (int k = 0; k < s->nu; ++k) assert_close(udot[k], e->x[k], 1e-9 * size);
        assert_ok(mbsr_closures_force(s->m, s->d, lambda), mbsr_data_error(s->d));
        compare_forces(s, e, lambda, 1.0, size);
        ++*compared;
    }
}

/* The same by the sweeps, where they serve: by every kernel. */
static void compare_swept(loops *s, const dense *e, const double *tau, int *served)
{
    const mbsri_sweep_kernels *kernels[2], *own = s->m->evaluated->kernels;
    const double size = 1.0 + test_largest(e->N, e->x);
    for (int k = test_kernels(kernels) - 1; k >= 0; --k) {
        double udot[LOOPS_MOST];
        s->m->evaluated->kernels = kernels[k];
        const int status = mbsri_sweeps_loops_dynamics(s->m, s->d, 0.0, s->q, s->u, tau, udot);
        if (status == MBSRI_NOT_SERVED) continue;
        assert_int_equal(status, MBSR_OK);
        assert_false(e->clear && e->moves);
        assert_false(e->clear && e->left > 1e-3 * size);
        if (!e->clear || e->left > 1e-9 * size) continue;
        for (int j = 0; j < s->nu; ++j) assert_close(udot[j], e->x[j], 1e-9 * size);
        ++*served;
    }
    s->m->evaluated->kernels = own;
}

static void forward(void **state)
{
    (void)state;
    int compared = 0, served = 0, undetermined = 0, open = 0;
    for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
        test_rng rng;
        loops s;
        dense e;
        double tau[LOOPS_MOST];
        make_case(&s, &rng, seed);
        if (too_large(&s)) {
            loops_free(&s);
            continue;
        }
        loops_random_state(&s, &rng);
        test_fill(&rng, s.nu, tau);
        find_equations(&s, &e, tau);
        for (int k = 0; k < e.m; ++k) e.bias[k] = -e.bias[k];
        solve(&e, e.M, e.g, e.bias);
        compare_forward(&s, &e, tau, &compared);
        compare_swept(&s, &e, tau, &served);
        mbsri_sweep_loops *plan = hide_loops(s.m);
        compare_forward(&s, &e, tau, &compared);
        show_loops(s.m, plan);
        undetermined += e.clear && e.moves;
        open += e.clear && !e.moves && e.left > 1e-3 * (1.0 + test_largest(e.N, e.x));
        loops_free(&s);
    }
    assert_true(compared > SEEDS / 2);
    assert_true(served > SEEDS / 4);
    assert_true(undetermined > SEEDS / 20 && open > SEEDS / 20);
}

static void inverse(void **state)
{
    (void)state;
    int compared = 0, refused = 0;
    for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
        test_rng rng;
        loops s;
        dense e;
        int count = 0, actuated[LOOPS_MOST];
        double udot[LOOPS_MOST], tau[LOOPS_MOST], lambda[LOOPS_MOST], need[LOOPS_MOST],
            P[LOOPS_MOST * LOOPS_MOST] = {0.0};
        make_case(&s, &rng, seed);
        if (too_large(&s)) {
            loops_free(&s);
            continue;
        }
        loops_random_state(&s, &rng);
        test_fill(&rng, s.nu, udot);
        for (int k = 0; k < s.nu; ++k) {
            if (test_integer(&rng, 0, 9) < 7) actuated[count++] = k, P[k * (s.nu + 1)] = 1.0;
        }
        find_equations(&s, &e, NULL);
        assert_ok(mbsr_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, udot, need), NULL);
        solve(&e, P, need, NULL);
        const double size = 1.0 + test_largest(e.N, e.x), all = 1.0 + test_largest(s.nu, need);
        const int status = mbsr_closures_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, udot, count,
                                                          actuated, tau, lambda);
        if (e.clear && e.left > 1e-4 * all) {
            assert_int_equal(status, MBSR_UNDETERMINED);
            assert_contains(mbsr_data_error(s.d)->text, "driven by none");
            ++refused;
        } else if (e.clear && e.left < 1e-11 * all) {
            assert_ok(status, mbsr_data_error(s.d));
            for (int k = 0; k < s.nu; ++k)
                assert_close(tau[k], P[k * (s.nu + 1)] * e.x[k], 1e-9 * size);
            compare_forces(&s, &e, lambda, -1.0, size);
            ++compared;
        }
        loops_free(&s);
    }
    assert_true(compared > SEEDS / 10);
    assert_true(refused > SEEDS / 10);
}

/* A row of parallelograms on three legs, one behind the other: of each two rows are redundant. */
static void add_parallelograms(loops *s, int count)
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

/* In a long chain the equations of motion hold, with loops of which each hangs on the one before. */
static void long_chain(void **state)
{
    (void)state;
    enum { COUNT = 200, NU = 4 * COUNT, ROWS = 4 * COUNT };
    loops s;
    double *q = calloc(6 * NU + 3 * ROWS, sizeof *q), *u = q + NU, *udot = u + NU, *tau = udot + NU,
           *need = tau + NU, *both = need + NU, *lambda = both + NU, *bias = lambda + ROWS,
           *rate = bias + ROWS;
    loops_begin(&s, NULL);
    add_parallelograms(&s, COUNT);
    loops_build(&s);
    assert_int_equal(s.nu, NU);
    assert_int_equal(s.rows, ROWS);
    test_rng rng = test_seed(5);
    for (int k = 0; k < COUNT; ++k) {
        /* legs stand alike, against the coupler before them, which stays level */
        const double angle = 1.2 + 0.3 * test_uniform(&rng);
        q[4 * k] = q[4 * k + 2] = q[4 * k + 3] = angle;
        q[4 * k + 1] = -angle;
        tau[4 * k] = test_uniform(&rng);
    }
    const mbsr_error *error = mbsr_data_error(s.d);
    assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, q, u, tau, udot), error);
    assert_ok(mbsr_closures_force(s.m, s.d, lambda), error);
    assert_ok(mbsr_closures_transpose(s.m, s.d, lambda, both), error);
    assert_ok(mbsr_closures_bias(s.m, s.d, bias), error);
    assert_ok(mbsr_closures_apply(s.m, s.d, udot, rate), error);
    assert_ok(mbsr_inverse_dynamics(s.m, s.d, 0.0, q, u, udot, need), error);
    const double size = test_largest(NU, need) + test_largest(NU, both),
                 fast = 1.0 + test_largest(NU, udot);
    for (int k = 0; k < NU; ++k) assert_close(need[k], tau[k] + both[k], 1e-10 * size);
    for (int k = 0; k < ROWS; ++k) assert_close(rate[k], -bias[k], 1e-11 * fast);
    loops_free(&s);
    free(q);
}

/* Residuals of models so large that the sweeps go through them in pieces are those of the stages. */
static void large_residual(void **state)
{
    (void)state;
    enum { COUNT = 600 };
    loops s;
    loops_begin(&s, NULL);
    add_parallelograms(&s, COUNT);
    loops_build(&s);
    const size_t size = (size_t)mbsr_dae_size(s.m, MBSR_DAE_MOMENTUM);
    double *y = calloc(4 * size, sizeof *y), *yp = y + size, *F = yp + size, *stages = F + size;
    test_rng rng = test_seed(8);
    test_fill(&rng, (int)size, y);
    test_fill(&rng, (int)size, yp);
    const mbsr_error *error = mbsr_data_error(s.d);
    const mbsri_sweep_kernels *kernels[2];
    const test_hidden trees = test_hide_sweeps(s.m);
    assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.3, y, yp, stages), error);
    test_show_sweeps(s.m, trees);
    const double largest = test_largest((int)size, stages);
    for (int k = test_kernels(kernels) - 1; k >= 0; --k) {
        s.m->evaluated->kernels = kernels[k];
        assert_int_equal(mbsri_sweeps_momentum_residual(s.m, s.d, 0.3, y, yp, F), MBSR_OK);
        assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.3, y, yp, F), error);
        for (size_t j = 0; j < size; ++j) assert_close(F[j], stages[j], 1e-11 * largest);
    }
    loops_free(&s);
    free(y);
}

/* The sweeps take none. Elsewhere memory that runs out at any place is said, nothing is lost, and the next call
 * finds what it should. */
static void memory(void **state)
{
    (void)state;
    test_counting counting = {0};
    mbsr_model_def def = mbsr_default_model_def();
    loops s = {0};
    const int motors[2] = {0, 4};
    double q[8] = {1.0, -1.0, 1.0, 1.0, 1.3, -1.3, 1.3, 1.3}, u[8] = {0.0}, udot[8], again[8],
           tau[8], lambda[8];
    def.allocator = test_counting_allocator(&counting);
    assert_ok(mbsr_model_create(&def, &s.m, NULL), NULL);
    add_parallelograms(&s, 2);
    loops_build(&s);
    u[0] = u[2] = u[3] = 1.0;
    u[1] = -1.0;
    const long calls = counting.calls;
    assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, q, u, NULL, udot), mbsr_data_error(s.d));
    assert_int_equal(counting.calls, calls);
    mbsri_sweep_loops *plan = hide_loops(s.m);
    const long live = counting.live;
    for (int call = 0; call < 2; ++call) {
        for (long at = 1;; ++at) {
            counting.fail_at = counting.calls + at;
            counting.failed = 0;
            const int status = call == 0 ? mbsr_forward_dynamics(s.m, s.d, 0.0, q, u, NULL, again)
                                         : mbsr_closures_inverse_dynamics(s.m, s.d, 0.0, q, u, udot,
                                                                          2, motors, tau, lambda);
            assert_int_equal(counting.live, live);
            if (!counting.failed) {
                assert_ok(status, mbsr_data_error(s.d));
                assert_true(at > 2);
                break;
            }
            assert_int_equal(status, MBSR_ERR_NO_MEMORY);
            assert_contains(mbsr_data_error(s.d)->text, "no memory");
        }
        counting.fail_at = 0;
    }
    for (int k = 0; k < 8; ++k) assert_close(again[k], udot[k], 1e-12);
    for (int k = 0; k < 8; ++k) assert_close(tau[k], 0.0, 1e-10);
    show_loops(s.m, plan);
    loops_free(&s);
    assert_int_equal(counting.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(forward), cmocka_unit_test(inverse),
                                       cmocka_unit_test(long_chain),
                                       cmocka_unit_test(large_residual), cmocka_unit_test(memory)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

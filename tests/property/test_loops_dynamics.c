/* Forward dynamics of trees with loops, massless bodies, redundant and stiff rows against dense
 * equations that are solved by singular values; memory of both.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "kernels.h"
#include "loops_equations.h"

#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

/* ---- tests ---- */

enum { SEEDS = 400 };

/* What forward dynamics finds against these equations. */
static void compare_forward(loops *s, const loops_equations *e, const double *tau, int *compared)
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
        assert_ok(mbsr_closures_lambda(s->m, s->d, lambda), mbsr_data_error(s->d));
        loops_compare_forces(s, e, lambda, 1.0, size);
        ++*compared;
    }
}

/* The same by the sweeps, where they serve: by every kernel. */
static void compare_swept(loops *s, const loops_equations *e, const double *tau, int *served)
{
    const mbsri_sweep_kernels *kernels[2], *own = s->m->tree.evaluated->kernels;
    const double size = 1.0 + test_largest(e->N, e->x);
    for (int k = test_kernels(kernels) - 1; k >= 0; --k) {
        double udot[LOOPS_MOST];
        s->m->tree.evaluated->kernels = kernels[k];
        const int status = mbsri_sweeps_loops_dynamics(s->m, s->d, 0.0, s->q, s->u, tau, udot);
        if (status == MBSRI_NOT_SERVED) continue;
        assert_int_equal(status, MBSR_OK);
        assert_false(e->clear && e->moves);
        assert_false(e->clear && e->left > 1e-3 * size);
        if (!e->clear || e->left > 1e-9 * size) continue;
        for (int j = 0; j < s->nu; ++j) assert_close(udot[j], e->x[j], 1e-9 * size);
        ++*served;
    }
    s->m->tree.evaluated->kernels = own;
}

static void forward(void **state)
{
    (void)state;
    int compared = 0, served = 0, undetermined = 0, open = 0;
    for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
        test_rng rng;
        loops s;
        loops_equations e;
        double tau[LOOPS_MOST];
        loops_make_case(&s, &rng, seed);
        if (loops_too_large(&s)) {
            loops_free(&s);
            continue;
        }
        loops_random_state(&s, &rng);
        test_fill(&rng, s.nu, tau);
        loops_find_equations(&s, &e, tau);
        for (int k = 0; k < e.m; ++k) e.bias[k] = -e.bias[k];
        loops_solve(&e, e.M, e.g, e.bias);
        compare_forward(&s, &e, tau, &compared);
        compare_swept(&s, &e, tau, &served);
        mbsri_sweep_loops *plan = loops_hide_plan(s.m);
        compare_forward(&s, &e, tau, &compared);
        loops_show_plan(s.m, plan);
        undetermined += e.clear && e.moves;
        open += e.clear && !e.moves && e.left > 1e-3 * (1.0 + test_largest(e.N, e.x));
        loops_free(&s);
    }
    assert_true(compared > SEEDS / 2);
    const mbsri_sweep_kernels *kernels[2];
    assert_true(served > test_kernels(kernels) * SEEDS / 8);
    assert_true(undetermined > SEEDS / 20 && open > SEEDS / 20);
}

/* In a long chain the equations of motion hold, with loops of which each hangs on the one before.
 */
static void long_chain(void **state)
{
    (void)state;
    enum { COUNT = 200, NU = 4 * COUNT, ROWS = 4 * COUNT };
    loops s;
    double *q = calloc(6 * NU + 3 * ROWS, sizeof *q), *u = q + NU, *udot = u + NU, *tau = udot + NU,
           *need = tau + NU, *both = need + NU, *lambda = both + NU, *bias = lambda + ROWS,
           *rate = bias + ROWS;
    loops_begin(&s, NULL);
    loops_add_parallelograms(&s, COUNT);
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
    assert_ok(mbsr_closures_lambda(s.m, s.d, lambda), error);
    assert_ok(mbsr_closures_transpose(s.m, s.d, lambda, both), error);
    assert_ok(mbsr_closures_bias(s.m, s.d, bias), error);
    assert_ok(mbsr_closures_apply(s.m, s.d, udot, rate), error);
    assert_ok(mbsr_inverse_dynamics(s.m, s.d, 0.0, q, u, udot, NULL, need), error);
    const double size = test_largest(NU, need) + test_largest(NU, both),
                 fast = 1.0 + test_largest(NU, udot);
    for (int k = 0; k < NU; ++k) assert_close(need[k], tau[k] + both[k], 1e-10 * size);
    for (int k = 0; k < ROWS; ++k) assert_close(rate[k], -bias[k], 1e-11 * fast);
    loops_free(&s);
    free(q);
}

/* Residuals of random mechanisms by the sweeps are those of the stages, with bodies without inertia
 * on joints of several axes. */
static void residual(void **state)
{
    (void)state;
    enum { SIZE = 6 * LOOPS_MOST };
    int served = 0, empty = 0;
    for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
        test_rng rng;
        loops s;
        double y[SIZE], yp[SIZE], F[SIZE], stages[SIZE];
        loops_make_case(&s, &rng, seed);
        const int size = mbsr_dae_size(s.m, MBSR_DAE_MOMENTUM);
        if (!loops_too_large(&s)) {
            const mbsri_sweep_kernels *kernels[2], *own = s.m->tree.evaluated->kernels;
            loops_random_state(&s, &rng);
            test_fill(&rng, size, y);
            test_fill(&rng, size, yp);
            memcpy(y, s.q, (size_t)s.nq * sizeof *y);
            const test_hidden trees = test_hide_sweeps(s.m);
            assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.3, y, yp, stages),
                      mbsr_data_error(s.d));
            test_show_sweeps(s.m, trees);
            const double largest = 1.0 + test_largest(size, stages);
            for (int k = test_kernels(kernels) - 1; k >= 0; --k) {
                s.m->tree.evaluated->kernels = kernels[k];
                assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.3, y, yp, F),
                          mbsr_data_error(s.d));
                for (int j = 0; j < size; ++j) assert_close(F[j], stages[j], 1e-11 * largest);
                const int status = mbsri_sweeps_momentum_residual(s.m, s.d, 0.3, y, yp, F);
                served += status == MBSR_OK;
                for (int i = 1; i <= s.m->bodies; ++i)
                    empty += !status && s.m->body[i].n > 1 && s.d->rank[i] == 0 &&
                             !s.m->tree.evaluated->whole;
            }
            s.m->tree.evaluated->kernels = own;
        }
        loops_free(&s);
    }
    assert_true(served > SEEDS / 2);
    assert_true(empty > 10);
}

/* Residuals of models so large that the sweeps go through them in pieces are those of the stages.
 */
static void large_residual(void **state)
{
    (void)state;
    enum { COUNT = 600 };
    loops s;
    loops_begin(&s, NULL);
    loops_add_parallelograms(&s, COUNT);
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
        s.m->tree.evaluated->kernels = kernels[k];
        assert_int_equal(mbsri_sweeps_momentum_residual(s.m, s.d, 0.3, y, yp, F), MBSR_OK);
        assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.3, y, yp, F), error);
        for (size_t j = 0; j < size; ++j) assert_close(F[j], stages[j], 1e-11 * largest);
    }
    loops_free(&s);
    free(y);
}

/* Forward dynamics takes none, nor do motors, with the plan of the vector code and without. */
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
    loops_add_parallelograms(&s, 2);
    loops_build(&s);
    u[0] = u[2] = u[3] = 1.0;
    u[1] = -1.0;
    const long calls = counting.calls;
    assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, q, u, NULL, udot), mbsr_data_error(s.d));
    assert_ok(loops_inverse_dynamics(s.m, s.d, 0.0, q, u, udot, 2, motors, tau, lambda),
              mbsr_data_error(s.d));
    for (int k = 0; k < 8; ++k) assert_close(tau[k], 0.0, 1e-10);
    assert_int_equal(counting.calls, calls);
    mbsri_sweep_loops *plan = loops_hide_plan(s.m);
    const long live = counting.live, planned = counting.calls;
    assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, q, u, NULL, again), mbsr_data_error(s.d));
    assert_int_equal(counting.calls, planned);
    assert_ok(loops_inverse_dynamics(s.m, s.d, 0.0, q, u, udot, 2, motors, tau, lambda),
              mbsr_data_error(s.d));
    assert_int_equal(counting.calls, planned);
    assert_int_equal(counting.live, live);
    counting.fail_at = 0;
    for (int k = 0; k < 8; ++k) assert_close(again[k], udot[k], 1e-12);
    for (int k = 0; k < 8; ++k) assert_close(tau[k], 0.0, 1e-10);
    loops_show_plan(s.m, plan);
    loops_free(&s);
    assert_int_equal(counting.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(forward), cmocka_unit_test(residual),
                                       cmocka_unit_test(long_chain),
                                       cmocka_unit_test(large_residual), cmocka_unit_test(memory)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

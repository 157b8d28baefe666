/* Inverse dynamics of trees with loops and motors on some joints, with massless bodies, redundant
 * and stiff rows, too few motors and motors to spare: against dense equations that are solved by
 * singular values, and the way along the tree for any kind of body against the one in vector code.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "kernels.h"
#include "loops_equations.h"

#include "model/query.h"
#include "sweeps/dynamics.h"

#include <string.h>

enum { SEEDS = 400 };

/* What is asked for, and what is found. */
typedef struct motors {
    int count, actuated[LOOPS_MOST];
    double mark[LOOPS_MOST]; /* 1 where there is a motor, by the caller's order */
    double udot[LOOPS_MOST], tau[LOOPS_MOST], lambda[LOOPS_MOST];
    int status;
    char text[sizeof((mbsr_error *)0)->text];
} motors;

/* On `some` of ten joint rates. */
static void choose(motors *a, const loops *s, test_rng *rng, int some)
{
    memset(a, 0, sizeof *a);
    test_fill(rng, s->nu, a->udot);
    for (int k = 0; k < s->nu; ++k) {
        if (test_integer(rng, 0, 9) < some) a->actuated[a->count++] = k, a->mark[k] = 1.0;
    }
}

static void run(motors *a, loops *s)
{
    a->status = loops_inverse_dynamics(s->m, s->d, 0.0, s->q, s->u, a->udot, a->count, a->actuated,
                                       a->tau, a->lambda);
    if (a->status) memcpy(a->text, mbsr_data_error(s->d)->text, sizeof a->text);
}

static void assert_same(const motors *a, const motors *b, const loops *s, double size)
{
    for (int k = 0; k < s->nu; ++k) assert_close(a->tau[k], b->tau[k], 1e-10 * size);
    for (int k = 0; k < s->rows; ++k) assert_close(a->lambda[k], b->lambda[k], 1e-10 * size);
}

/* By both ways: statuses, texts and numbers are the same; the sweeps by every kernel, where they
 * serve. */
static void compare_ways(const motors *given, loops *s, bool clear, int *served)
{
    motors a = *given, b = *given;
    run(&a, s);
    mbsri_sweep_loops *plan = loops_hide_plan(s->m);
    run(&b, s);
    loops_show_plan(s->m, plan);
    if (!clear) return;
    assert_int_equal(a.status, b.status);
    assert_string_equal(a.text, b.text);
    if (a.status) return;
    const double size = 1.0 + test_largest(s->nu, b.tau) + test_largest(s->rows, b.lambda);
    assert_same(&a, &b, s, size);
    const mbsri_sweep_kernels *kernels[2], *own = s->m->tree.evaluated->kernels;
    double motor[LOOPS_MOST];
    mbsri_gather(s->m, given->mark, motor);
    for (int k = test_kernels(kernels) - 1; k >= 0; --k) {
        s->m->tree.evaluated->kernels = kernels[k];
        const int status =
            mbsri_sweeps_loops_inverse(s->m, s->d, 0.0, s->q, s->u, a.udot, motor, a.tau, a.lambda);
        if (status == MBSRI_NOT_SERVED) continue;
        assert_int_equal(status, MBSR_OK);
        assert_same(&a, &b, s, size);
        ++*served;
    }
    s->m->tree.evaluated->kernels = own;
}

/* Against the dense equations. */
static bool compare_dense(const motors *given, loops *s, int *compared, int *refused)
{
    motors a = *given;
    loops_equations e;
    double need[LOOPS_MOST], P[LOOPS_MOST * LOOPS_MOST] = {0.0};
    for (int k = 0; k < s->nu; ++k) P[k * (s->nu + 1)] = a.mark[k];
    loops_find_equations(s, &e, NULL);
    assert_ok(mbsr_inverse_dynamics(s->m, s->d, 0.0, s->q, s->u, a.udot, NULL, need), NULL);
    loops_solve(&e, P, need, NULL);
    const double size = 1.0 + test_largest(e.N, e.x), all = 1.0 + test_largest(s->nu, need);
    run(&a, s);
    if (e.clear && e.left > 1e-4 * all) {
        assert_int_equal(a.status, MBSR_UNDETERMINED);
        assert_contains(a.text, "driven by none");
        ++*refused;
    } else if (e.clear && e.left < 1e-11 * all) {
        assert_ok(a.status, mbsr_data_error(s->d));
        for (int k = 0; k < s->nu; ++k) assert_close(a.tau[k], a.mark[k] * e.x[k], 1e-9 * size);
        loops_compare_forces(s, &e, a.lambda, -1.0, size);
        ++*compared;
    }
    return e.clear;
}

/* Loops that are open by far, and closed ones. */
static void random_mechanisms(void **state)
{
    (void)state;
    int compared = 0, refused = 0, served = 0, closed = 0;
    for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
        test_rng rng;
        loops s;
        motors a;
        loops_make_case(&s, &rng, seed);
        if (!loops_too_large(&s)) {
            loops_random_state(&s, &rng);
            choose(&a, &s, &rng, 7);
            compare_ways(&a, &s, compare_dense(&a, &s, &compared, &refused), &served);
            choose(&a, &s, &rng, 5 + (int)(seed % 6));
            if (!mbsr_assemble(s.m, s.d, 0.0, s.q, NULL, s.q, NULL))
                compare_ways(&a, &s, compare_dense(&a, &s, &compared, &refused), &closed);
        }
        loops_free(&s);
    }
    assert_true(compared > SEEDS / 10);
    assert_true(refused > SEEDS / 10);
    assert_true(served > SEEDS / 10);
    assert_true(closed > SEEDS / 10);
}

/* A four-bar with a stiff pin that is loaded, and a rigid one: the spring is one of the forces that
 * motors need not exert, its lambda is its force, and the sum of motors and loop forces is that
 * over rigid rows. */
static void springs_count_once(void **state)
{
    (void)state;
    const int all[4] = {0, 1, 2, 3};
    double need[4], tau[4], lambda[4], forces[4], C[16], gap[4];
    loops s;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              b = loops_rod(&s, "coupler", a, 1.0, 0.0, 1.5, 2.5),
              c = loops_rod(&s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
    const int slider = loops_rod(&s, "rod", c, 2.0, 0.0, 1.0, 1.0);
    mbsr_closure_def pin =
        mbsr_closure_ball(b, (double[3]){2.5, 0.0, 0.0}, c, (double[3]){2.0, 0.0, 0.0});
    for (int k = 0; k < 2; ++k) pin.stiffness[k] = 1e3, pin.damping[k] = 10.0;
    assert_ok(mbsr_model_add_closure(s.m, &pin, NULL), mbsr_model_error(s.m));
    loops_pin(&s, "end", slider, 1.0, 0.0, MBSR_GROUND, 3.0, 2.0);
    loops_finish(&s);
    const double q[4] = {1.2, -0.9, 1.3, -0.7}, udot[4] = {0.7, -1.1, 0.4, 0.9};
    for (int k = 0; k < 4; ++k) s.u[k] = 0.3 * k - 0.4;
    assert_ok(mbsr_inverse_dynamics(s.m, s.d, 0.0, q, s.u, udot, NULL, need), mbsr_data_error(s.d));
    assert_ok(loops_inverse_dynamics(s.m, s.d, 0.0, q, s.u, udot, 4, all, tau, lambda),
              mbsr_data_error(s.d));
    loops_rows(&s, 0.0, q, s.u, C, gap, forces, NULL);
    for (int row = 0; row < 2; ++row)
        assert_close(lambda[row], -1e3 * gap[row] - 10.0 * forces[row], 1e-9);
    for (int k = 0; k < 4; ++k) {
        double sum = tau[k];
        for (int row = 2; row < 4; ++row) sum += C[4 * k + row] * lambda[row];
        assert_close(sum, need[k], 1e-10 * (1.0 + test_largest(4, need)));
    }
    assert_true(fabs(lambda[0]) > 100.0);
    loops_free(&s);
}

/* Parallelograms on three legs, which have motors on one of them, on two and to spare, on some,
 * nowhere. */
static void chains(void **state)
{
    (void)state;
    enum { MOST = 12, KINDS = 5 };
    int served[KINDS] = {0};
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        test_rng rng = test_seed(seed);
        loops s;
        motors a;
        const int count = 1 + (int)(seed % MOST), kind = (int)(seed % KINDS);
        const double gap = seed % 3 == 0 ? 1e-6 : 0.0;
        loops_begin(&s, NULL);
        loops_add_parallelograms(&s, count);
        loops_finish(&s);
        for (int k = 0; k < count; ++k) {
            const double angle = 1.2 + 0.3 * test_uniform(&rng);
            s.q[4 * k] = s.q[4 * k + 2] = s.q[4 * k + 3] = angle;
            s.q[4 * k + 1] = -angle + gap * test_uniform(&rng);
        }
        test_fill(&rng, s.nu, s.u);
        choose(&a, &s, &rng, kind == 3 ? 7 : 0);
        for (int k = 0; k < s.nu && kind < 3; ++k) {
            if (k % 4 == 0 || (kind > 0 && k % 4 == 2) || (kind > 1 && k % 4 == 1))
                a.actuated[a.count++] = k, a.mark[k] = 1.0;
        }
        compare_ways(&a, &s, true, served + kind);
        loops_free(&s);
    }
    assert_true(served[0] >= 8 && served[1] >= 4 && served[2] >= 4 && served[3] > 0);
    assert_int_equal(served[4], 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_mechanisms),
                                       cmocka_unit_test(springs_count_once),
                                       cmocka_unit_test(chains)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Newton systems by the front where more loops close on one body than fronts may wait for it:
 * products undo solutions, and memory is in proportion to the bodies.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

#include <stdlib.h>

/* Parallelograms side by side on a carrier; the solver's bytes a body. */
static double check(int count)
{
    loops s;
    mbsr_newton *newton;
    mbsr_newton_info info;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    loops_begin(&s, NULL);
    const int carrier = loops_rod(&s, "carrier", MBSR_GROUND, 0.0, 0.0, 5.0, 3.0);
    for (int k = 0; k < count; ++k) {
        const double at = 2.0 * k / count;
        const int crank = loops_rod(&s, NULL, carrier, at, 0.0, 1.0, 1.0),
                  coupler = loops_rod(&s, NULL, crank, 1.0, 0.0, 0.7, 1.0),
                  rocker = loops_rod(&s, NULL, carrier, at + 1.0, 0.0, 1.2, 1.0);
        (void)loops_pin(&s, NULL, coupler, 1.0, 0.0, rocker, 1.0, 0.0);
    }
    loops_build(&s);
    opt.by_blocks = opt.products = opt.transposes = 1;
    assert_ok(mbsr_newton_create(s.m, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
    const int n = mbsr_dae_size(s.m, MBSR_DAE_MOMENTUM);
    double *y = calloc(5 * (size_t)n, sizeof *y), *yp = y + n, *v = yp + n, *x = v + n, *r = x + n;
    test_rng rng = test_seed(4);
    test_fill(&rng, n, yp);
    test_fill(&rng, n, v);
    for (int k = 0; k < s.nq; ++k) y[k] = (k > 0 && k % 3 == 2 ? -1.0 : 1.0) + 0.01 * v[k];
    assert_ok(mbsr_newton_factor(newton, s.d, 0.0, y, yp, 100.0), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_linearise(newton, s.d, 0.0, y, yp, 100.0), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, v, x), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_multiply(newton, x, r), mbsr_newton_error(newton));
    for (int k = 0; k < n; ++k) assert_less(fabs(r[k] - v[k]), 1e-9 * test_largest(n, x));
    assert_ok(mbsr_newton_solve_transposed(newton, v, x), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_multiply_transposed(newton, x, r), mbsr_newton_error(newton));
    for (int k = 0; k < n; ++k) assert_less(fabs(r[k] - v[k]), 1e-9 * test_largest(n, x));
    assert_ok(mbsr_newton_get_info(newton, &info), NULL);
    free(y);
    mbsr_newton_destroy(newton);
    loops_free(&s);
    return (double)info.bytes / (3 * count + 1);
}

static void many_loops_on_one_body(void **state)
{
    (void)state;
    (void)check(5);
    const double few = check(25);
    assert_less(check(100), 1.05 * few);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(many_loops_on_one_body)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

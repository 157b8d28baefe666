/* Newton systems of closed models in vector code, by the front, and as the dense matrix: see
 * newton_ways.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton_ways.h"

#include "expect.h"

#include <math.h>
#include <stdlib.h>

mbsr_newton *newton_solver(const mbsr_model *m, int by_blocks)
{
    mbsr_newton *newton;
    mbsr_error error;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.by_blocks = by_blocks;
    assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &newton, &error), &error);
    return newton;
}

void newton_solve(mbsr_newton *newton, const test_newton_state *at, double c, const double *r,
                  double *x)
{
    assert_ok(mbsr_newton_factor(newton, at->data, 0.0, at->y, at->yp, c),
              mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, r, x), mbsr_newton_error(newton));
}

/* v' A^-1 r = (A^-T v)' r; x: A^-1 r. */
static void check_transposed(mbsr_newton *newton, const test_newton_state *at, double c,
                             const double *r, const double *x, double amplification)
{
    double *v = calloc(2 * (size_t)at->n, sizeof *v), *z = v + at->n, sum = 0.0, size = 0.0;
    test_rng rng = test_seed(29);
    test_fill(&rng, at->n, v);
    assert_ok(mbsr_newton_factor(newton, at->data, 0.0, at->y, at->yp, c),
              mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve_transposed(newton, v, z), mbsr_newton_error(newton));
    for (int k = 0; k < at->n; ++k) {
        sum += v[k] * x[k] - z[k] * r[k];
        size += fabs(v[k] * x[k]) + fabs(z[k] * r[k]);
    }
    assert_less(fabs(sum), 1e-12 * (1.0 + amplification) * size);
    free(v);
}

void newton_both_ways(mbsr_model *m, mbsr_data *d, const double *q, const double *u,
                      newton_sweeps sweeps, newton_look *look, int expected)
{
    static const double factors[] = {1.0, 50.0, 1e5, -30.0};
    test_newton_state at;
    test_rng rng = test_seed(11);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton *newton = newton_solver(m, 0), *front = newton_solver(m, 1), *back = NULL;
    opt.transposes = 1;
    assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &back, NULL), NULL);
    assert_ok(test_newton_start(&at, m, d, 0.0, q, u, NULL), mbsr_data_error(d));
    assert_ok(test_newton_matrices(&at, m, d), NULL);
    double *r = calloc(3 * (size_t)at.n, sizeof *r), *x = r + at.n, *y = x + at.n;
    for (int k = 0; k < 4; ++k) {
        test_fill(&rng, at.n, r);
        newton_solve(newton, &at, factors[k], r, x);
        if (sweeps != EITHER) assert_int_equal(newton->by_sweeps, sweeps == ONE_SWEEP);
        newton_solve(front, &at, factors[k], r, y);
        assert_false(front->by_sweeps);
        if (look && newton->by_sweeps) look(newton, expected);
        const test_newton_errors e = test_newton_compare(&at, factors[k], r, x);
        assert_less(test_newton_distance(&at, x, y), 1e-12 * (1.0 + e.amplification));
        assert_less(e.net_delta, 1e-10);
        assert_less(e.delta, 1e-10 * (1.0 + e.amplification));
        check_transposed(back, &at, factors[k], r, x, e.amplification);
    }
    free(r);
    mbsr_newton_destroy(newton);
    mbsr_newton_destroy(front);
    mbsr_newton_destroy(back);
    test_newton_free(&at);
}

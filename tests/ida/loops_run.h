/* Runs of mechanisms with the driver, from the library's own start.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_LOOPS_RUN_H
#define TEST_LOOPS_RUN_H

#include "loops.h"

#include <mbsrank/ida.h>

/* What a run was like. */
typedef struct loops_result {
    long steps, failures;
    double gap;
    double energy; /* its change */
    int status;
} loops_result;

/* Integrates from the guess q, u of s to t_end; q, u and lambda of s are then the last. The
 * driver's error is written to *last. */
static inline loops_result loops_try(loops *s, double tolerance, double t_end, mbsr_error *last)
{
    static double y[8 * LOOPS_MOST], yp[8 * LOOPS_MOST], F[8 * LOOPS_MOST];
    double g[LOOPS_MOST], t = 0.0;
    loops_result r = {.status = 0};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_ida_stats stats;
    mbsr_ida_drift drift;
    mbsr_error error;
    mbsr_ida *ida;
    opt.rtol = opt.atol = tolerance;
    const mbsr_error *of_data = mbsr_data_error(s->d);
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y), of_data);
    assert_ok(mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL), of_data);
    assert_ok(mbsr_ida_create(s->m, s->d, &opt, &ida, &error), &error);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    r.status = mbsr_ida_advance(ida, t_end, &t, y, yp);
    *last = *mbsr_ida_error(ida);
    assert_ok(mbsr_ida_get_stats(ida, &stats), NULL);
    r.steps = stats.steps;
    assert_ok(mbsr_ida_get_drift(ida, &drift), mbsr_ida_error(ida));
    r.energy = drift.energy_change;
    mbsr_ida_destroy(ida);
    if (r.status) return r;
    assert_ok(mbsr_dae_unpack(s->m, s->d, MBSR_DAE_MOMENTUM, t, y, s->q, s->u), NULL);
    assert_ok(mbsr_dae_residual(s->m, s->d, MBSR_DAE_MOMENTUM, t, y, yp, F), of_data);
    assert_ok(mbsr_closures_lambda(s->m, s->d, s->lambda), of_data);
    assert_ok(mbsr_stage_positions(s->m, s->d, t, s->q), NULL);
    assert_ok(mbsr_closures_gap(s->m, s->d, g), NULL);
    r.gap = test_largest(s->position_rows, g);
    assert_close(r.gap, drift.gap, 1e-15);
    return r;
}

/* The same, with the error printed. */
static inline loops_result loops_run(loops *s, double tolerance, double t_end)
{
    mbsr_error error;
    const loops_result r = loops_try(s, tolerance, t_end, &error);
    if (r.status) print_message("%s\n", error.text);
    return r;
}

#endif

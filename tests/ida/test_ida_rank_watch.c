/* The driver where a rank changes: two pendulums that swing as one until a torque parts them.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "twins.h"

#include <mbsrank/ida.h>
#include <mbsrank/driver.h>

#include <stdlib.h>

static const double begin = 0.5; /* s */

/* A driver at the library's start from q = (0, 0, 1, 1), u = (., ., 2, 2). */
static mbsr_ida *start(const twins *s, mbsr_dae_form form, int watch, double tolerance)
{
    const double q[4] = {0.0, 0.0, 1.0, 1.0}, u[4] = {0.0, 0.0, 2.0, 2.0};
    double y[12], yp[12];
    mbsr_consistent_info info;
    const mbsr_error *error = mbsr_data_error(s->data);
    assert_ok(mbsr_dae_pack(s->model, s->data, form, 0.0, q, u, y), error);
    assert_ok(mbsr_dae_consistent(s->model, s->data, form, 0.0, y, yp, NULL, &info), error);
    assert_int_equal(info.null_directions, 1);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    assert_int_equal(opt.watch_ranks, 1);
    opt.form = form;
    opt.watch_ranks = watch;
    opt.rtol = opt.atol = tolerance;
    mbsr_ida *ida = NULL;
    assert_ok(mbsr_ida_create(s->model, s->data, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    return ida;
}

static void the_driver_stops_where_the_rank_changes(void **state)
{
    (void)state;
    const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE};
    for (int f = 0; f < 2; ++f) {
        twins s;
        twins_make(&s, begin);
        mbsr_ida *ida = start(&s, forms[f], 1, 1e-6);
        double t = 7.0, y[12], yp[12];
        assert_ok(mbsr_ida_advance(ida, 0.4, &t, y, yp), mbsr_ida_error(ida));
        assert_close(y[2], y[3], 1e-9);
        assert_refused(mbsr_ida_advance(ida, 2.0, &t, y, yp), mbsr_ida_error(ida),
                       MBSR_RANK_CHANGED, 0, MBSR_NONE,
                       "mbsr_ida_advance: residual at t = 0.5|body 0 'bead'|from 1 to 2 (of 2)");
        const char *time = strstr(mbsr_ida_error(ida)->text, "t = ");
        assert_non_null(time);
        assert_close(strtod(time + 4, NULL), begin, 0.02);
        assert_true(t == 0.4); /* nothing was written */
        /* a start beyond the change has its own ranks */
        const double q[4] = {0.0, 0.0, 1.0, 1.5}, u[4] = {0.0};
        mbsr_consistent_info info;
        assert_ok(mbsr_dae_pack(s.model, s.data, forms[f], 0.6, q, u, y), NULL);
        assert_ok(mbsr_dae_consistent(s.model, s.data, forms[f], 0.6, y, yp, NULL, &info),
                  mbsr_data_error(s.data));
        assert_int_equal(info.null_directions, 0);
        assert_ok(mbsr_ida_start(ida, 0.6, y, yp), mbsr_ida_error(ida));
        assert_ok(mbsr_ida_advance(ida, 0.65, &t, y, yp), mbsr_ida_error(ida));
        mbsr_ida_destroy(ida);
        twins_free(&s);
    }
}

/* The driver watches while it integrates; before and after, the data is as the caller left it. */
static void the_watch_of_the_caller_is_restored(void **state)
{
    (void)state;
    const double beside[4] = {0.0, 0.0, 1.0, 1.0}, parted[4] = {0.0, 0.0, 1.0, 1.5}, u[4] = {0.0};
    for (int mode = 0; mode < 3; ++mode) { /* not watched; watched with other ranks, or the same */
        twins s;
        twins_make(&s, begin);
        double t, y[12], yp[12], udot[4];
        const double *own = mode == 1 ? parted : beside, *other = mode == 1 ? beside : parted;
        mbsr_ida *ida = start(&s, MBSR_DAE_MOMENTUM, 1, 1e-6);
        assert_ok(mbsr_ida_state(ida, NULL, y, yp), mbsr_ida_error(ida));
        if (mode > 0) {
            mbsr_forward_dynamics(s.model, s.data, 0.0, own, u, NULL, udot);
            assert_ok(mbsr_recursive_residual(s.model, s.data, 0.0, own, u, u, NULL, udot),
                      mbsr_data_error(s.data));
            assert_ok(mbsr_rank_watch(s.model, s.data, 1), mbsr_data_error(s.data));
        }
        for (int round = 0; round < 4; ++round) {
            const int watched = mode > 0 ? MBSR_RANK_CHANGED : MBSR_OK;
            assert_ok(mbsr_recursive_residual(s.model, s.data, 0.0, own, u, u, NULL, udot),
                      mbsr_data_error(s.data));
            assert_int_equal(mbsr_recursive_residual(s.model, s.data, 0.0, other, u, u, NULL, udot),
                             watched);
            if (round == 0) assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
            if (round == 1)
                assert_ok(mbsr_ida_advance(ida, 0.4, &t, NULL, NULL), mbsr_ida_error(ida));
            if (round == 2)
                assert_int_equal(mbsr_ida_advance(ida, 2.0, &t, NULL, NULL), MBSR_RANK_CHANGED);
        }
        mbsr_ida_destroy(ida);
        assert_int_equal(mbsr_recursive_residual(s.model, s.data, 0.0, other, u, u, NULL, udot),
                         mode > 0 ? MBSR_RANK_CHANGED : MBSR_OK);
        twins_free(&s);
    }
}

/* State at 0.8 s by the inverse-dynamics form, which knows no ranks. */
static void pass(double tolerance, double *y)
{
    twins s;
    twins_make(&s, begin);
    mbsr_ida *ida = start(&s, MBSR_DAE_INVERSE_DYNAMICS, 1, tolerance);
    double t = 0.0;
    assert_ok(mbsr_ida_advance(ida, 0.8, &t, y, NULL), mbsr_ida_error(ida));
    assert_true(t == 0.8);
    assert_ok(mbsr_recursive_residual(s.model, s.data, t, y, y + 4, y + 4, NULL, (double[4]){0.0}),
              mbsr_data_error(s.data));
    assert_int_equal(mbsr_total_rank(s.model, s.data), 4);
    mbsr_ida_destroy(ida);
    twins_free(&s);
}

static void the_inverse_dynamics_form_passes_through(void **state)
{
    (void)state;
    double a[8], b[8];
    pass(1e-5, a);
    pass(1e-7, b);
    assert_true(fabs(b[2] - b[3]) > 0.05);
    for (int k = 0; k < 4; ++k) assert_close(a[k], b[k], 2e-3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_driver_stops_where_the_rank_changes),
        cmocka_unit_test(the_watch_of_the_caller_is_restored),
        cmocka_unit_test(the_inverse_dynamics_form_passes_through),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

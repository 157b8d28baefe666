/* Watching the ranks: two pendulums on a massless bead, parallel and not.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "twins.h"

#include <mbsrank/driver.h>

/* Parallel; at right angles; one up, one down, which is parallel too. */
static const double parallel[4] = {0.1, -0.2, 0.7, 0.7}, apart[4] = {0.1, -0.2, 0.7, 0.7 + 1.57},
                    opposite[4] = {0.1, -0.2, 0.7, 0.7 - 3.141592653589793};
static const double u[4] = {0.3, 0.1, -0.4, -0.4}, still[4] = {0.0};

static int evaluate(const twins *s, const double *q)
{
    double residual[4];
    return mbsr_recursive_residual(s->model, s->data, 0.0, q, u, still, NULL, residual);
}

static int rank_of_bead(const twins *s)
{
    mbsr_rank_info info;
    assert_ok(mbsr_body_rank(s->model, s->data, 0, &info), mbsr_data_error(s->data));
    return info.rank;
}

static void the_rank_depends_on_the_pose(void **state)
{
    (void)state;
    twins s;
    twins_make(&s, INFINITY);
    const double *const pose[] = {parallel, apart, opposite};
    for (int k = 0; k < 3; ++k) {
        assert_ok(evaluate(&s, pose[k]), mbsr_data_error(s.data));
        assert_int_equal(rank_of_bead(&s), k == 1 ? 2 : 1);
        assert_int_equal(mbsr_total_rank(s.model, s.data), k == 1 ? 4 : 3);
    }
    twins_free(&s);
}

static void a_change_is_recoverable_and_named(void **state)
{
    (void)state;
    twins s;
    twins_make(&s, INFINITY);
    assert_true(MBSR_RANK_CHANGED > 0);
    const mbsr_error *error = mbsr_data_error(s.data);
    /* from 1 to 2 */
    assert_ok(evaluate(&s, parallel), error);
    assert_ok(mbsr_rank_watch(s.model, s.data, 1), error);
    assert_ok(evaluate(&s, parallel), error);
    assert_ok(evaluate(&s, opposite), error);
    assert_refused(evaluate(&s, apart), error, MBSR_RANK_CHANGED, 0, MBSR_NONE,
                   "body 0 'bead'|rank of its joint changes from 1 to 2 (of 2) at t = 0");
    /* results of the refused evaluation are not to be had */
    mbsr_rank_info info;
    assert_int_equal(mbsr_body_rank(s.model, s.data, 0, &info), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_total_rank(s.model, s.data), -1);
    /* the ranks remembered stay what they were */
    assert_ok(evaluate(&s, parallel), error);
    assert_int_equal(evaluate(&s, apart), MBSR_RANK_CHANGED);
    /* from 2 to 1 */
    assert_ok(mbsr_rank_watch(s.model, s.data, 0), error);
    assert_ok(evaluate(&s, apart), error);
    assert_ok(mbsr_rank_watch(s.model, s.data, 1), error);
    assert_ok(evaluate(&s, apart), error);
    assert_refused(evaluate(&s, parallel), error, MBSR_RANK_CHANGED, 0, MBSR_NONE,
                   "body 0 'bead'|changes from 2 to 1 (of 2)");
    /* switched on where it was on already: remembers anew */
    assert_ok(mbsr_rank_watch(s.model, s.data, 0), error);
    assert_ok(evaluate(&s, parallel), error);
    assert_ok(mbsr_rank_watch(s.model, s.data, 1), error);
    assert_ok(evaluate(&s, opposite), error);
    assert_ok(mbsr_rank_watch(s.model, s.data, 2), error);
    assert_int_equal(evaluate(&s, apart), MBSR_RANK_CHANGED);
    twins_free(&s);
}

static void it_needs_a_rank_to_remember(void **state)
{
    (void)state;
    twins s, other;
    twins_make(&s, INFINITY);
    twins_make(&other, INFINITY);
    const mbsr_error *error = mbsr_data_error(s.data);
    assert_refused(mbsr_rank_watch(s.model, s.data, 1), error, MBSR_ERR_SEQUENCE, MBSR_NONE,
                   MBSR_NONE, "mbsr_rank_watch");
    assert_ok(evaluate(&s, parallel), error);
    assert_ok(evaluate(&s, apart), error); /* nothing is watched */
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, parallel), error);
    assert_int_equal(mbsr_rank_watch(s.model, s.data, 1), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_rank_watch(s.model, s.data, 0), MBSR_OK);
    assert_int_equal(mbsr_rank_watch(NULL, s.data, 0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_rank_watch(s.model, NULL, 0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_rank_watch(other.model, s.data, 0), MBSR_ERR_MISMATCH);
    twins_free(&other);
    twins_free(&s);
}

static void a_watch_is_exchanged(void **state)
{
    (void)state;
    twins s;
    twins_make(&s, INFINITY);
    const mbsr_error *error = mbsr_data_error(s.data);
    int on = 0, rank[4] = {0};
    assert_ok(evaluate(&s, parallel), error);
    assert_ok(mbsr_rank_watch(s.model, s.data, 1), error);
    assert_ok(mbsr_rank_watch_exchange(s.model, s.data, &on, rank), error);
    assert_int_equal(on, 1);
    assert_int_equal(rank[0], 1);
    assert_ok(evaluate(&s, apart), error); /* off */
    rank[0] = 2;
    assert_ok(mbsr_rank_watch_exchange(s.model, s.data, &on, rank), error);
    assert_int_equal(on, 0);
    assert_ok(evaluate(&s, apart), error);
    assert_int_equal(evaluate(&s, parallel), MBSR_RANK_CHANGED);
    on = 1;
    rank[0] = 3;
    assert_refused(mbsr_rank_watch_exchange(s.model, s.data, &on, rank), error, MBSR_ERR_VALUE, 0,
                   MBSR_NONE, "rank[0] is 3, must be 0 .. 2");
    assert_ok(evaluate(&s, apart), error); /* as it was */
    assert_int_equal(mbsr_rank_watch_exchange(s.model, s.data, NULL, rank), MBSR_ERR_NULL);
    assert_int_equal(mbsr_rank_watch_exchange(s.model, s.data, &on, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_rank_watch_exchange(NULL, s.data, &on, rank), MBSR_ERR_NULL);
    twins_free(&s);
}

/* Two data of one model do not disturb each other. */
static void each_data_watches_for_itself(void **state)
{
    (void)state;
    twins s;
    twins_make(&s, INFINITY);
    mbsr_data *first = s.data;
    assert_ok(evaluate(&s, parallel), mbsr_data_error(s.data));
    assert_ok(mbsr_rank_watch(s.model, s.data, 1), mbsr_data_error(s.data));
    assert_ok(mbsr_data_create(s.model, &s.data, NULL), NULL);
    assert_ok(evaluate(&s, apart), mbsr_data_error(s.data));
    mbsr_data_destroy(s.data);
    s.data = first;
    assert_int_equal(evaluate(&s, apart), MBSR_RANK_CHANGED);
    twins_free(&s);
}

static void the_forms_that_need_the_rank_report_it(void **state)
{
    (void)state;
    twins s;
    twins_make(&s, INFINITY);
    const mbsr_error *error = mbsr_data_error(s.data);
    const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE,
                                   MBSR_DAE_INVERSE_DYNAMICS};
    double y[12], yp[12] = {0.0}, F[12];
    for (int f = 0; f < 3; ++f) {
        assert_ok(mbsr_rank_watch(s.model, s.data, 0), error);
        assert_ok(evaluate(&s, parallel), error);
        assert_ok(mbsr_rank_watch(s.model, s.data, 1), error);
        assert_ok(mbsr_dae_pack(s.model, s.data, forms[f], 0.0, apart, u, y), error);
        const int status = mbsr_dae_residual(s.model, s.data, forms[f], 0.0, y, yp, F);
        if (forms[f] == MBSR_DAE_INVERSE_DYNAMICS) {
            assert_ok(status, error);
            assert_true(isfinite(test_largest(8, F)));
        } else {
            assert_refused(status, error, MBSR_RANK_CHANGED, 0, MBSR_NONE, "'bead'");
        }
    }
    double udot[4], tau[4];
    assert_int_equal(mbsr_forward_dynamics(s.model, s.data, 0.0, apart, u, NULL, udot),
                     MBSR_RANK_CHANGED);
    assert_ok(mbsr_inverse_dynamics(s.model, s.data, 0.0, apart, u, still, NULL, tau), error);
    twins_free(&s);
}

/* A consistent start may have other ranks than those watched; afterwards they are watched as
 * before. */
static void a_consistent_start_may_have_other_ranks(void **state)
{
    (void)state;
    twins s;
    twins_make(&s, INFINITY);
    const mbsr_error *error = mbsr_data_error(s.data);
    double y[12], yp[12];
    assert_ok(evaluate(&s, parallel), error);
    assert_ok(mbsr_rank_watch(s.model, s.data, 1), error);
    assert_ok(mbsr_dae_pack(s.model, s.data, MBSR_DAE_MOMENTUM, 0.0, apart, u, y), error);
    mbsr_consistent_info info;
    assert_ok(mbsr_dae_consistent(s.model, s.data, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &info),
              error);
    assert_int_equal(info.null_directions, 0);
    assert_int_equal(evaluate(&s, apart), MBSR_RANK_CHANGED);
    assert_ok(mbsr_dae_pack(s.model, s.data, MBSR_DAE_MOMENTUM, 0.0, parallel, u, y), error);
    assert_ok(mbsr_dae_consistent(s.model, s.data, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &info),
              error);
    assert_int_equal(info.null_directions, 1);
    assert_int_equal(evaluate(&s, apart), MBSR_RANK_CHANGED);
    twins_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_rank_depends_on_the_pose),
        cmocka_unit_test(a_change_is_recoverable_and_named),
        cmocka_unit_test(it_needs_a_rank_to_remember),
        cmocka_unit_test(a_watch_is_exchanged),
        cmocka_unit_test(each_data_watches_for_itself),
        cmocka_unit_test(the_forms_that_need_the_rank_report_it),
        cmocka_unit_test(a_consistent_start_may_have_other_ranks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

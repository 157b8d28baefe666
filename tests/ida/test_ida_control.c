/* When the driver makes a new matrix, and of which kind, by the age of the one at hand.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "ida/control.h"

/* Old until `life` steps after it was made, then the last one improved on; what IDA asks for is
 * new, and is young again. */
static void a_matrix_serves_as_long_as_it_lives(void **state)
{
    (void)state;
    mbsri_control c = {.matrices = {.life = 4, .made_at = 10}};
    for (long step = 10; step < 14; ++step)
        assert_int_equal(mbsri_control_choose(&c, step, false, true), MBSRI_MATRIX_OLD);
    assert_int_equal(mbsri_control_choose(&c, 14, false, true), MBSRI_MATRIX_LAST);
    assert_int_equal(mbsri_control_choose(&c, 15, true, true), MBSRI_MATRIX_NEW);
    assert_int_equal(mbsri_control_choose(&c, 18, false, true), MBSRI_MATRIX_OLD);
    assert_int_equal(mbsri_control_choose(&c, 19, false, true), MBSRI_MATRIX_LAST);
    c.iterates = true;
    assert_int_equal(mbsri_control_choose(&c, 99, false, true), MBSRI_MATRIX_OLD);
}

/* Of those that live for one step, one in five is compared with the last. */
static void a_matrix_for_each_step_is_compared_now_and_then(void **state)
{
    (void)state;
    mbsri_control c = {.matrices = {.life = 1, .made_at = 20, .compared_at = 18}};
    assert_int_equal(mbsri_control_choose(&c, 20, false, true), MBSRI_MATRIX_OLD);
    for (long step = 21; step < 23; ++step)
        assert_int_equal(mbsri_control_choose(&c, step, false, true), MBSRI_MATRIX_NEW);
    assert_int_equal(mbsri_control_choose(&c, 23, false, true), MBSRI_MATRIX_LAST);
    c.matrices.life = 0;
    assert_int_equal(mbsri_control_choose(&c, 1000, false, true), MBSRI_MATRIX_OLD);
}

/* One that may leave a share of a correction is renewed when it is due, where steps are calm. */
static void a_matrix_that_leaves_too_much_is_due(void **state)
{
    (void)state;
    mbsri_control c = {.matrices = {.share = 0.1, .due = 3.0}, .looks = true};
    for (long step = 100; step < 102; ++step)
        assert_int_equal(mbsri_control_choose(&c, step, false, true), MBSRI_MATRIX_OLD);
    assert_int_equal(mbsri_control_choose(&c, 102, false, false), MBSRI_MATRIX_OLD);
    assert_int_equal(mbsri_control_choose(&c, 103, false, true), MBSRI_MATRIX_BEGIN);
    c.dear = true;
    assert_int_equal(mbsri_control_choose(&c, 104, false, true), MBSRI_MATRIX_OLD);
    c.dear = false, c.until = 90;
    assert_int_equal(mbsri_control_choose(&c, 589, false, true), MBSRI_MATRIX_OLD);
    assert_int_equal(mbsri_control_choose(&c, 590, false, true), MBSRI_MATRIX_BEGIN);
    c.until = 0;
    assert_int_equal(mbsri_control_choose(&c, 99, false, true), MBSRI_MATRIX_OLD);
    assert_int_equal(mbsri_control_choose(&c, 100, false, true), MBSRI_MATRIX_BEGIN);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_matrix_serves_as_long_as_it_lives),
        cmocka_unit_test(a_matrix_for_each_step_is_compared_now_and_then),
        cmocka_unit_test(a_matrix_that_leaves_too_much_is_due)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

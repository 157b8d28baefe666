/* Which joints are eliminated as one block.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <math.h>

enum { MOST = 24, LIMIT = 12 };

static const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0},
                    tip[3] = {0.0, 0.6, 0.0}, on_axis[3] = {0.3, 0.0, 0.0};

static mbsr_model *begin(void)
{
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    return m;
}

static int slide(mbsr_model *m, int parent, const double axis[3], mbsr_inertia inertia)
{
    return test_add_body(m, parent, mbsr_joint_prismatic(NULL, NULL, axis), inertia);
}

static int turn(mbsr_model *m, int parent, const double axis[3], mbsr_inertia inertia)
{
    return test_add_body(m, parent, mbsr_joint_revolute(NULL, NULL, axis), inertia);
}

static void finish(mbsr_model *m)
{
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
}

/* Two slides and a rod on them; what the second slide and the rod carry is given. */
static void expect_groups(mbsr_inertia carried, mbsr_inertia rod, const int expected[3])
{
    mbsr_model *m = begin();
    const int first = slide(m, MBSR_GROUND, y, mbsr_inertia_zero()),
              second = slide(m, first, z, carried);
    turn(m, second, x, rod);
    assert_int_equal(mbsr_body_group(m, 0), MBSR_NONE); /* before it is finished */
    finish(m);
    for (int k = 0; k < 3; ++k) assert_int_equal(mbsr_body_group(m, k), expected[k]);
    assert_int_equal(mbsr_body_group(m, 3), MBSR_NONE);
    mbsr_model_destroy(m);
}

static void joints_that_move_none_of_their_own_mass(void **state)
{
    (void)state;
    const double origin[3] = {0.0, 0.0, 0.0}, tensor[6] = {0.1, 0.1, 0.1, 0.0, 0.0, 0.0};
    const mbsr_inertia zero = mbsr_inertia_zero(), point = mbsr_inertia_point_mass(1.0, tip);
    expect_groups(zero, point, (int[3]){0, 0, 2});
    /* any mass moves with a slide, a moment of inertia does not */
    expect_groups(mbsr_inertia_point_mass(1e-6, tip), point, (int[3]){0, 1, 2});
    expect_groups(mbsr_inertia_rigid(0.0, origin, tensor), point, (int[3]){0, 0, 2});
    /* a mass on the axis that the rod turns about */
    expect_groups(zero, mbsr_inertia_point_mass(1.0, on_axis), (int[3]){0, 0, 0});
    /* nothing behind has mass: D is zero for good */
    expect_groups(zero, zero, (int[3]){0, 1, 2});
}

/* The same joint by itself and as a table of a user's own. */
static void a_users_joint_is_looked_at(void **state)
{
    (void)state;
    for (int own = 0; own < 2; ++own) {
        for (int massive = 0; massive < 2; ++massive) {
            mbsr_model *m = begin();
            mbsr_joint joint = mbsr_joint_prismatic(NULL, NULL, z);
            mbsr_joint_table table = *joint.table;
            table.name = "own";
            if (own) joint.table = &table;
            const int first = slide(m, MBSR_GROUND, y, mbsr_inertia_zero()),
                      second = test_add_body(m, first, joint,
                                             massive ? mbsr_inertia_point_mass(1.0, tip)
                                                     : mbsr_inertia_zero());
            turn(m, second, x, mbsr_inertia_point_mass(1.0, tip));
            finish(m);
            assert_int_equal(mbsr_body_group(m, second), massive ? second : first);
            mbsr_model_destroy(m);
        }
    }
}

/* A group has up to LIMIT bodies; a chain of more is cut, the same whatever the ids are. */
static void long_chains_are_cut(void **state)
{
    (void)state;
    for (int count = 2; count <= MOST; ++count) {
        mbsr_model *m = begin();
        int on = MBSR_GROUND, size[MOST] = {0}, groups = 0;
        for (int k = 0; k < count; ++k)
            on = slide(m, on, k % 3 == 0 ? x : k % 3 == 1 ? y : z, mbsr_inertia_zero());
        turn(m, on, x, mbsr_inertia_point_mass(1.0, tip));
        finish(m);
        for (int k = 0; k < count; ++k) {
            const int head = mbsr_body_group(m, k);
            assert_in_range(head, 0, k);
            assert_true(k == 0 || head == k || head == mbsr_body_group(m, k - 1)); /* in a row */
            groups += size[head]++ == 0;
        }
        for (int k = 0; k < count; ++k) assert_true(size[k] <= LIMIT);
        assert_int_equal(groups, (count + LIMIT - 1) / LIMIT);
        mbsr_model_destroy(m);
    }
}

/* Two branches of massless slides on a massless one. */
static void branches_belong_together(void **state)
{
    (void)state;
    mbsr_model *m = begin();
    const int foot = slide(m, MBSR_GROUND, x, mbsr_inertia_zero());
    for (int side = 0; side < 2; ++side) {
        const int arm = slide(m, foot, side ? y : z, mbsr_inertia_zero());
        turn(m, arm, x, mbsr_inertia_point_mass(1.0, tip));
    }
    finish(m);
    for (int k = 0; k < 5; ++k)
        assert_int_equal(mbsr_body_group(m, k), k == 2 || k == 4 ? k : foot);
    mbsr_model_destroy(m);
}

/* The rank of a group is that of its block, wherever among its joints it is: with the rod along y
 * the slide along y takes its mass, with the rod along z the other one. */
static void the_rank_of_the_group_stays(void **state)
{
    (void)state;
    mbsr_model *m = begin();
    mbsr_data *d = NULL;
    const int first = slide(m, MBSR_GROUND, y, mbsr_inertia_zero()),
              second = slide(m, first, z, mbsr_inertia_zero());
    turn(m, second, x, mbsr_inertia_point_mass(2.0, tip));
    finish(m);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int k = 0; k <= 64; ++k) {
        const double angle = k * 0.09817477042468103 + (k % 2 ? 1e-9 : 0.0),
                     q[3] = {0.1, 0.2, angle}, u[3] = {0.0, 0.0, 0.0};
        mbsr_rank_info rank[2];
        assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
        assert_ok(mbsr_stage_forces(m, d, NULL), mbsr_data_error(d));
        assert_ok(mbsr_stage_backward(m, d), mbsr_data_error(d));
        if (k == 0) assert_ok(mbsr_rank_watch(m, d, 1), mbsr_data_error(d));
        assert_ok(mbsr_body_rank(m, d, 0, rank), mbsr_data_error(d));
        assert_ok(mbsr_body_rank(m, d, 1, rank + 1), mbsr_data_error(d));
        assert_int_equal(rank[0].rank + rank[1].rank, 1);
        assert_int_equal(mbsr_total_rank(m, d), 2);
        assert_true(rank[0].smallest_kept > 1e-3 && rank[0].largest_dropped < 1e-14);
        /* the joint farther from the root takes what it can */
        if (k % 16 == 0) assert_int_equal(rank[k % 32 ? 1 : 0].rank, 1);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(joints_that_move_none_of_their_own_mass),
        cmocka_unit_test(a_users_joint_is_looked_at),
        cmocka_unit_test(long_chains_are_cut),
        cmocka_unit_test(branches_belong_together),
        cmocka_unit_test(the_rank_of_the_group_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

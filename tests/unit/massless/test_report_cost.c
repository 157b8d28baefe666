/* What a report of many directions without mass costs: so many evaluations as of a few.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

enum { MOST = 160 };

static long positions, evaluations;
static const mbsr_joint_table *stock;

/* The stock joint, counting. */
static int position(const mbsr_joint_args *args, double *p)
{
    ++positions;
    return stock->position(args, p);
}

/* -stiffness q - damping u, counting. */
static int evaluate(const mbsr_force_args *args)
{
    const double *param = args->force->param;
    ++evaluations;
    args->body[0].tau[0] -= param[0] * args->body[0].q[0] + param[1] * args->body[0].u[0];
    return MBSR_OK;
}

static const mbsr_force_table law = {.version = MBSR_FORCE_TABLE_VERSION,
                                     .flags = MBSR_FORCE_JOINT_ONLY,
                                     .name = "spring and damper",
                                     .evaluate = evaluate};

typedef struct train {
    int carts;
    int every;    /* each so manieth cart has a mass; the last one has it always */
    bool own;     /* elements are a user's, without derivatives */
    bool elastic; /* the joints of every other massless cart have no damper */
} train;

/* Carts on each other with springs, of which `damped` directions are damped and the others elastic.
 */
static void report(train x, int damped, int elastic)
{
    static double q[MOST], u[MOST];
    mbsr_joint_table table;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_index_report *found;
    const double axis[3] = {1.0, 0.0, 0.0};
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int i = 0; i < x.carts; ++i) {
        mbsr_body_def def = mbsr_default_body_def();
        def.parent = i > 0 ? i - 1 : MBSR_GROUND;
        def.joint = mbsr_joint_prismatic(NULL, NULL, axis);
        stock = def.joint.table;
        table = *stock;
        table.position = position;
        def.joint.table = &table;
        const bool heavy = i % x.every == x.every - 1 || i == x.carts - 1;
        def.inertia = heavy ? mbsr_inertia_particle(1.0) : mbsr_inertia_zero();
        assert_ok(mbsr_model_add_body(m, &def, NULL), mbsr_model_error(m));
        const double damping = x.elastic && i % 4 < 2 ? 0.0 : 2.0;
        mbsr_force_def force = mbsr_force_joint_spring(i, 0, 10.0, damping, 0.0);
        if (x.own) {
            force = mbsr_force_custom(&law, 1, &i, NULL);
            force.param[0] = 10.0;
            force.param[1] = damping;
        }
        assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
        q[i] = 0.1 * sin(i);
        u[i] = 0.1 * cos(i);
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    positions = evaluations = 0;
    assert_ok(mbsr_index_report_create(m, d, 0.0, q, u, &found), mbsr_data_error(d));
    assert_int_equal(found->damped, damped);
    assert_int_equal(found->elastic, elastic);
    assert_int_equal(found->undetermined, 0);
    mbsr_index_report_destroy(m, found);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void carts_with_masses_between(void **state)
{
    (void)state;
    for (int own = 0; own < 2; ++own) {
        double share[2][2];
        for (int k = 0; k < 2; ++k) {
            const int carts = k ? MOST : MOST / 4;
            report((train){carts, 2, own, true}, carts / 4, carts / 4);
            share[k][0] = (double)positions / carts;
            share[k][1] = (double)evaluations / carts;
        }
        for (int what = 0; what < 2; ++what) assert_true(share[1][what] <= 1.1 * share[0][what]);
        assert_true(share[1][0] < 300.0);
    }
}

static void carts_without_masses_between(void **state)
{
    (void)state;
    double share[2];
    for (int k = 0; k < 2; ++k) {
        const int carts = k ? MOST : MOST / 4;
        report((train){carts, carts, false, false}, carts - 1, 0);
        share[k] = (double)positions / carts;
    }
    assert_true(share[1] <= 1.1 * share[0]);
    assert_true(share[1] < 100.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(carts_with_masses_between),
                                       cmocka_unit_test(carts_without_masses_between)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

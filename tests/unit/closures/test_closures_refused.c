/* Closures that are refused, and functions that refuse models with closures: status and a text that
 * names the closure; nothing is lost.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"
#include "own_joint.h"

#include <mbsrank/driver.h>

#include <string.h>

#define assert_add_refused(s, def, status, words)                                                  \
    assert_refused(mbsr_model_add_closure((s)->m, (def), NULL), mbsr_model_error((s)->m), status,  \
                   MBSR_NONE, MBSR_NONE, words)

/* Two rods, the second on the first; and a body in a space of its own. */
static void begin(loops *s)
{
    loops_begin(s, NULL);
    const int a = loops_rod(s, "a", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    loops_rod(s, "b", a, 1.0, 0.0, 1.0, 1.0);
}

static int position(const mbsr_closure_args *args, double *g)
{
    g[0] = args->body[0].q[0];
    return 0;
}

static void definitions(void **state)
{
    (void)state;
    loops s;
    begin(&s);
    const double none[9] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0};
    mbsr_closure_def def = mbsr_closure_ball(0, NULL, 1, NULL);
    def.name = "pin";
    assert_int_equal(mbsr_model_add_closure(NULL, &def, NULL), MBSR_ERR_NULL);
    assert_add_refused(&s, NULL, MBSR_ERR_NULL, "mbsr_model_add_closure|NULL");
    def.cookie = 0;
    assert_add_refused(&s, &def, MBSR_ERR_NO_DEFAULT, "closure 0|mbsr_default_closure_def");
    def = mbsr_default_closure_def();
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "closure 0|table");
    def = mbsr_closure_ball(-7, NULL, 1, NULL);
    def.name = "pin";
    assert_add_refused(&s, &def, MBSR_ERR_ID, "closure 0 'pin' (ball)|-7");
    def = mbsr_closure_distance(0, NULL, 1, NULL, 0.0);
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "distance|length is 0");
    def = mbsr_closure_rows(0, NULL, 1, NULL, 2, none);
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "rows|direction 0|length zero");
    def = mbsr_closure_rows(0, NULL, 1, NULL, 4, none);
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "count is 4");
    def = mbsr_closure_coupling(2, (int[2]){0, 0}, (int[2]){0, 0}, (double[2]){1.0, 2.0}, 0.0);
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "coupling|twice");
    def = mbsr_closure_coupling(1, (int[1]){0}, (int[1]){0}, (double[1]){0.0}, 0.0);
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "coupling|coefficients");
    def = mbsr_closure_coupling(9, (int[9]){0}, NULL, NULL, 0.0);
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "coupling|bodies is 9");
    def = mbsr_closure_rolling_ball(0, NULL, -1.0, MBSR_GROUND, NULL);
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "rolling ball|radius");
    const mbsr_frame bad = {.x = {0.0, 0.0, 0.0}};
    def = mbsr_closure_weld(0, &bad, 1, NULL);
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "weld|frame_a");
    def = mbsr_closure_weld(0, NULL, 1, NULL);
    def.damping[2] = 1.0;
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "weld|damping[2]|no stiffness");
    def.damping[2] = 0.0;
    def.settled = 7;
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "weld|settled is 7");
    def.settled = 1;
    def = mbsr_closure_custom(NULL, 1, (int[1]){0}, 1, 1, NULL);
    assert_add_refused(&s, &def, MBSR_ERR_VALUE, "table");
    static const mbsr_closure_table
        old = {.version = MBSR_CLOSURE_TABLE_VERSION + 1, .name = "own", .position = position},
        unnamed = {.version = MBSR_CLOSURE_TABLE_VERSION, .position = position},
        nothing = {.version = MBSR_CLOSURE_TABLE_VERSION, .name = "own"},
        placed = {.version = MBSR_CLOSURE_TABLE_VERSION, .name = "own", .position = position};
    static const struct {
        const mbsr_closure_table *table;
        int rows, held;
        const char *words;
    } own[] = {{&old, 1, 1, "another version"},      {&unnamed, 1, 1, "lacks its name"},
               {&placed, 0, 0, "rows is 0"},         {&placed, MBSR_CLOSURE_ROWS + 1, 1, "rows is"},
               {&placed, 1, -1, "position_rows -1"}, {&placed, 1, 2, "position_rows 2"},
               {&nothing, 1, 1, "has no position"},  {&placed, 2, 1, "need a jacobian"}};
    for (size_t k = 0; k < sizeof own / sizeof *own; ++k) {
        def = mbsr_closure_custom(own[k].table, 1, (int[1]){0}, own[k].rows, own[k].held, NULL);
        assert_add_refused(&s, &def, MBSR_ERR_VALUE, own[k].words);
    }
    loops_finish(&s);
    assert_int_equal(mbsr_model_closures(s.m), 0);
    def = mbsr_closure_ball(0, NULL, 1, NULL);
    assert_add_refused(&s, &def, MBSR_ERR_FINISHED, "finished");
    loops_free(&s);
}

/* What shows when the model is finished; adding to the model and finishing it goes on. */
static void finish_refused(const mbsr_closure_def *def, int status, const char *words)
{
    loops s;
    begin(&s);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_planar_weld((mbsr_planar_frame){0.0, 0.0, 0.0},
                                        (mbsr_planar_frame){1.0, 0.0, 0.0});
    assert_ok(mbsr_model_add_body(s.m, &body, NULL), NULL); /* 2, on the ground */
    body.joint = mbsr_joint_spherical(NULL, NULL);
    assert_ok(mbsr_model_add_body(s.m, &body, NULL), NULL); /* 3 */
    body.parent = 3;
    assert_ok(mbsr_model_add_body(s.m, &body, NULL), NULL); /* 4 */
    body.parent = MBSR_GROUND;
    body.joint = mbsr_joint_custom(&test_own_table, 1, 1, NULL);
    body.inertia = mbsr_inertia_matrix(1, (const double[1]){1.0});
    assert_ok(mbsr_model_add_body(s.m, &body, NULL), NULL); /* 5, in a space of its own */
    assert_ok(mbsr_model_add_closure(s.m, def, NULL), mbsr_model_error(s.m));
    for (int k = 0; k < 2; ++k) {
        assert_refused(mbsr_model_finish(s.m), mbsr_model_error(s.m), status, MBSR_NONE, MBSR_NONE,
                       words);
    }
    assert_int_equal(mbsr_model_bodies(s.m), -1);
    assert_ok(mbsr_model_add_body(s.m, &body, NULL), mbsr_model_error(s.m));
    loops_free(&s);
}

static int too_many(const mbsr_closure_args *args, int *rows, int *held)
{
    (void)args;
    *rows = 1;
    *held = 2;
    return 0;
}

static void bodies(void **state)
{
    (void)state;
    static const mbsr_closure_table joints = {.version = MBSR_CLOSURE_TABLE_VERSION,
                                              .flags = MBSR_CLOSURE_JOINTS,
                                              .name = "joints",
                                              .position = position},
                                    plain = {.version = MBSR_CLOSURE_TABLE_VERSION,
                                             .name = "plain",
                                             .position = position},
                                    counts = {.version = MBSR_CLOSURE_TABLE_VERSION,
                                              .name = "counts",
                                              .position = position,
                                              .count = too_many};
    const double x[6] = {1.0, 0.0, 0.0, -2.0, 0.0, 0.0}, z[3] = {0.0, 0.0, 1.0};
    mbsr_closure_def def = mbsr_closure_ball(0, NULL, 17, NULL);
    def.name = "pin";
    finish_refused(&def, MBSR_ERR_ID, "closure 0 'pin' (ball)|body 17");
    def = mbsr_closure_weld(1, NULL, 1, NULL);
    def.name = "ring";
    finish_refused(&def, MBSR_ERR_ID, "closure 0 'ring' (weld)|both sides|body 1");
    def = mbsr_closure_weld(MBSR_GROUND, NULL, MBSR_GROUND, NULL);
    finish_refused(&def, MBSR_ERR_ID, "closure 0 (weld)|ground");
    def = mbsr_closure_ball(2, NULL, MBSR_GROUND, NULL);
    def.name = "never";
    finish_refused(&def, MBSR_ERR_VALUE, "closure 0 'never' (ball)|no joint");
    def = mbsr_closure_rows(0, NULL, MBSR_GROUND, NULL, 2, x);
    finish_refused(&def, MBSR_ERR_VALUE, "closure 0 (rows)|not independent");
    def = mbsr_closure_rows(0, NULL, MBSR_GROUND, NULL, 1, z);
    finish_refused(&def, MBSR_ERR_VALUE, "closure 0 (rows)|in the plane");
    def = mbsr_closure_coupling(1, (int[1]){1}, (int[1]){1}, x, 0.0);
    finish_refused(&def, MBSR_ERR_VALUE, "closure 0 (coupling)|coordinate 1 of body 1");
    def = mbsr_closure_coupling(1, (int[1]){3}, (int[1]){0}, x, 0.0);
    finish_refused(&def, MBSR_ERR_SPACE, "closure 0 (coupling)|body 3|rates");
    def = mbsr_closure_ball(5, NULL, MBSR_GROUND, NULL);
    finish_refused(&def, MBSR_ERR_SPACE, "closure 0 (ball)|body 5 is in GENERAL space|custom");
    def = mbsr_closure_custom(&plain, 1, (int[1]){5}, 1, 1, NULL);
    finish_refused(&def, MBSR_ERR_SPACE, "closure 0 (plain)|body 5|GENERAL|jacobian and bias");
    def = mbsr_closure_custom(&joints, 1, (int[1]){3}, 1, 1, NULL);
    finish_refused(&def, MBSR_ERR_SPACE, "closure 0 (joints)|body 3|rates");
    def = mbsr_closure_custom(&counts, 1, (int[1]){0}, 1, 1, NULL);
    finish_refused(&def, MBSR_ERR_VALUE, "closure 0 (counts)|1 rows, 2");
    def = mbsr_closure_rolling_disc(0, NULL, 1.0, MBSR_GROUND, NULL);
    finish_refused(&def, MBSR_ERR_SPACE, "closure 0 (rolling disc)|space");
    def = mbsr_closure_rolling_ball(0, NULL, 1.0, MBSR_GROUND, NULL);
    finish_refused(&def, MBSR_ERR_VALUE, "closure 0 (rolling ball)|plane");
    def = mbsr_closure_ball(0, NULL, MBSR_GROUND, NULL);
    def.stiffness[2] = 1.0;
    finish_refused(&def, MBSR_ERR_VALUE, "closure 0 (ball)|stiffness[2]|2 position rows");
}

static void loop_joints(void **state)
{
    (void)state;
    loops s;
    begin(&s);
    const mbsr_joint pin = mbsr_joint_planar_revolute((mbsr_planar_frame){1.0, 0.0, 0.0},
                                                      (mbsr_planar_frame){0.0, 0.0, 0.0});
    int closure = -5, cut = -5;
    assert_int_equal(mbsr_model_add_loop_joint(NULL, "x", 1, &pin, 0, NULL, NULL, NULL),
                     MBSR_ERR_NULL);
    assert_refused(mbsr_model_add_loop_joint(s.m, "x", 1, NULL, 0, NULL, &closure, &cut),
                   mbsr_model_error(s.m), MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "joint is NULL");
    assert_refused(mbsr_model_add_loop_joint(s.m, "x", 1, &pin, -9, NULL, &closure, &cut),
                   mbsr_model_error(s.m), MBSR_ERR_ID, MBSR_NONE, MBSR_NONE, "'x'|-9");
    assert_refused(mbsr_model_add_loop_joint(s.m, "x", 1, &pin, 2, NULL, &closure, &cut),
                   mbsr_model_error(s.m), MBSR_ERR_ID, MBSR_NONE, MBSR_NONE, "cut body");
    assert_int_equal(closure, -5);
    assert_int_equal(cut, -5);
    assert_ok(mbsr_model_add_loop_joint(s.m, "pin", 1, &pin, MBSR_GROUND, NULL, &closure, &cut),
              mbsr_model_error(s.m));
    assert_int_equal(closure, 0);
    assert_int_equal(cut, 2);
    loops_finish(&s);
    assert_int_equal(mbsr_model_bodies(s.m), 3);
    assert_string_equal(mbsr_body_name(s.m, 2), "pin");
    assert_string_equal(mbsr_closure_name(s.m, 0), "pin");
    assert_int_equal(mbsr_model_find_closure(s.m, "pin"), 0);
    assert_int_equal(mbsr_model_find_closure(s.m, "pine"), MBSR_NONE);
    assert_int_equal(mbsr_model_rows(s.m), 3);
    assert_null(mbsr_closure_name(s.m, 1));
    assert_int_equal(mbsr_closure_indices(s.m, 1, NULL, NULL, NULL, NULL), MBSR_ERR_ID);
    loops_free(&s);
}

/* Functions that serve trees alone. */
static void served_by_trees_alone(void **state)
{
    (void)state;
    static const mbsr_dae_form others[] = {MBSR_DAE_RECURSIVE, MBSR_DAE_INVERSE_DYNAMICS,
                                           MBSR_DAE_INDEX1};
    loops s;
    begin(&s);
    loops_pin(&s, "pin", 1, 1.0, 0.0, MBSR_GROUND, 0.5, 0.2);
    loops_finish(&s);
    const mbsr_error *error = mbsr_data_error(s.d);
    double y[32] = {0.0}, yp[32] = {0.0}, F[32];
    for (int k = 0; k < 3; ++k) {
        assert_int_equal(mbsr_dae_size(s.m, others[k]), -1);
        assert_refused(mbsr_dae_residual(s.m, s.d, others[k], 0.0, y, yp, F), error,
                       MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE, "closures|momentum");
        assert_refused(mbsr_dae_pack(s.m, s.d, others[k], 0.0, s.q, s.u, y), error,
                       MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE, "closures|momentum");
    }
    assert_refused(mbsr_recursive_residual(s.m, s.d, 0.0, y, y, y, NULL, F), error,
                   MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE, "mbsr_recursive_residual");
    mbsr_batch *batch;
    mbsr_ode *ode;
    mbsr_error reason;
    assert_int_equal(mbsr_batch_create(s.m, &batch, &reason), MBSR_ERR_CLOSURES);
    assert_contains(reason.text, "mbsr_batch_create|closures");
    assert_int_equal(mbsr_ode_create(s.m, s.d, 0.0, s.q, s.u, &ode), MBSR_ERR_CLOSURES);
    assert_int_equal(mbsr_data_size_lean(s.m), 0);
    assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), error);
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(definitions), cmocka_unit_test(bodies),
                                       cmocka_unit_test(loop_joints),
                                       cmocka_unit_test(served_by_trees_alone)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

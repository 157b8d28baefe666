/* Newton systems of mechanisms whose joint coordinates are coupled: in vector code, beside the
 * elimination by blocks and the dense matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"
#include "newton_ways.h"
#include "sweeps/tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double x_axis[3] = {1.0, 0.0, 0.0}, y_axis[3] = {0.0, 1.0, 0.0},
                    z_axis[3] = {0.0, 0.0, 1.0}, tilted[3] = {0.3, 1.0, -0.4};

/* ---- mechanisms ---- */

/* unit: how many units of length are a metre. */
static int add(loops *s, int parent, mbsr_joint joint, double mass, double unit)
{
    const double com[3] = {0.2 * unit, 0.05 * unit, 0.0}, m2 = mass * unit * unit,
                 tensor[6] = {0.02 * m2, 0.03 * m2, 0.04 * m2, 0.0, 0.001 * m2, 0.0};
    mbsr_body_def body = mbsr_default_body_def();
    int id;
    body.parent = parent;
    body.joint = joint;
    if (mass > 0.0) body.inertia = mbsr_inertia_rigid(mass, com, tensor);
    assert_ok(mbsr_model_add_body(s->m, &body, &id), mbsr_model_error(s->m));
    return id;
}

static int hinge(loops *s, int parent, double x, double y, const double axis[3], double mass)
{
    const mbsr_frame at = mbsr_frame_at(x, y, 0.0);
    return add(s, parent, mbsr_joint_revolute(&at, NULL, axis), mass, 1.0);
}

static mbsr_closure_def *couple(mbsr_closure_def *def, int terms, const int *body,
                                const int *coordinate, const double *a)
{
    static const int first[MBSR_CLOSURE_BODIES] = {0};
    *def = mbsr_closure_coupling(terms, body, coordinate ? coordinate : first, a, 0.1);
    return def;
}

static void add_closure(loops *s, const mbsr_closure_def *def)
{
    assert_ok(mbsr_model_add_closure(s->m, def, NULL), mbsr_model_error(s->m));
}

static void gear(loops *s, int a, int b, double ratio)
{
    mbsr_closure_def def;
    add_closure(s, couple(&def, 2, (int[2]){a, b}, NULL, (double[2]){1.0, ratio}));
}

static void finish(loops *s)
{
    test_rng rng = test_seed(23);
    loops_finish(s);
    for (int k = 0; k < s->nq; ++k) s->q[k] = 0.3 * test_uniform(&rng);
    test_fill(&rng, s->nu, s->u);
}

/* ---- solutions ---- */

static void compare_by(loops *s, newton_sweeps sweeps)
{
    assert_int_equal(s->m->tree.newton->blocks, 0);
    newton_both_ways(s->m, s->d, s->q, s->u, sweeps, NULL, 0);
}

/* All bodies in vector code, in one sweep. */
static void compare_here(loops *s)
{
    compare_by(s, ONE_SWEEP);
}

static void compare(loops *s)
{
    finish(s);
    compare_here(s);
    loops_free(s);
}

/* ---- tests ---- */

/* Every coupling is open where the next one closes; then what waits for it waits in a front. */
static void gears_between_neighbours(void **state)
{
    (void)state;
    for (int massless = 0; massless < 4; ++massless) {
        loops s;
        int last = MBSR_GROUND;
        loops_begin(&s, NULL);
        for (int k = 0; k < 7; ++k) {
            /* light bodies in the middle, one of them at the end */
            const bool none = massless > 0 && (k % massless == 1 || (massless == 3 && k == 6));
            const int at = hinge(&s, last, k ? 0.4 : 0.0, 0.0, k % 2 ? tilted : z_axis,
                                 none ? 0.0 : 1.0 + 0.1 * k);
            if (k > 0) gear(&s, last, at, k % 3 ? 0.7 : -1.3);
            last = at;
        }
        finish(&s);
        compare_by(&s, massless ? EITHER : ONE_SWEEP);
        loops_free(&s);
    }
}

static void mimicking_fingers(void **state)
{
    (void)state;
    for (int massless = 0; massless < 2; ++massless) {
        loops s;
        loops_begin(&s, NULL);
        const int arm = hinge(&s, MBSR_GROUND, 0.0, 0.0, z_axis, 2.0),
                  palm = hinge(&s, arm, 0.4, 0.0, tilted, 1.0);
        for (int finger = 0; finger < 3; ++finger) {
            const int first = hinge(&s, palm, 0.1, 0.1 * finger, y_axis, 0.3),
                      second = hinge(&s, first, 0.1, 0.0, y_axis, massless ? 0.0 : 0.2),
                      third = hinge(&s, second, 0.1, 0.0, tilted, 0.1);
            gear(&s, first, second, -0.8);
            gear(&s, first, third, -0.6);
        }
        compare(&s);
    }
}

/* Coordinates of three and four bodies, neighbours or not, that of the body before them among
 * these. */
static void differentials(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; ++kind) {
        loops s;
        mbsr_closure_def def;
        loops_begin(&s, NULL);
        const int base = hinge(&s, MBSR_GROUND, 0.0, 0.0, z_axis, 2.0),
                  cage = hinge(&s, base, 0.1, 0.0, y_axis, 1.0),
                  left = hinge(&s, kind ? cage : base, 0.1, 0.2, y_axis, 0.5),
                  right = hinge(&s, base, 0.1, -0.2, y_axis, 0.4),
                  tool = hinge(&s, right, 0.2, 0.0, tilted, 0.4);
        const int body[4] = {left, cage, kind == 2 ? base : right, tool};
        const double a[4] = {1.0, -2.0, 1.1, 0.3};
        add_closure(&s, couple(&def, kind == 1 ? 4 : 3, body, NULL, a));
        compare(&s);
    }
}

/* A screw made of two coordinates of one joint, coordinates of other joints of several axes, bodies
 * of these without mass. */
static void joints_of_several_axes(void **state)
{
    (void)state;
    for (int massless = 0; massless < 2; ++massless) {
        loops s;
        mbsr_closure_def def;
        const mbsr_frame at = mbsr_frame_at(0.3, 0.1, 0.0);
        loops_begin(&s, NULL);
        const int base = hinge(&s, MBSR_GROUND, 0.0, 0.0, z_axis, 2.0),
                  cross = add(&s, base, mbsr_joint_universal(&at, NULL, y_axis, tilted),
                              massless ? 0.0 : 1.0, 1.0),
                  nut = add(&s, base, mbsr_joint_cylindrical(&at, NULL, x_axis), 0.7, 1.0),
                  end = add(&s, cross, mbsr_joint_spherical(&at, NULL), 0.6, 1.0),
                  last = hinge(&s, end, 0.2, 0.0, z_axis, 0.3);
        add_closure(&s, couple(&def, 1, &nut, NULL, (double[1]){1.0}));
        add_closure(&s,
                    couple(&def, 2, (int[2]){nut, nut}, (int[2]){0, 1}, (double[2]){0.1, -1.0}));
        add_closure(&s, couple(&def, 2, (int[2]){cross, last}, NULL, (double[2]){1.0, 0.5}));
        add_closure(&s,
                    couple(&def, 2, (int[2]){cross, base}, (int[2]){1, 0}, (double[2]){1.0, -0.5}));
        compare(&s);
    }
}

/* Springs of shafts and belts, forces of which are unknowns; rigid gears beside them. */
static void stiff_couplings(void **state)
{
    (void)state;
    static const double stiffness[] = {1e3, 1e8, 1e12};
    for (int k = 0; k < 3; ++k) {
        loops s;
        int last = MBSR_GROUND;
        loops_begin(&s, NULL);
        for (int i = 0; i < 5; ++i) {
            const int at = hinge(&s, last, i ? 0.4 : 0.0, 0.0, i % 2 ? tilted : z_axis, 1.0);
            mbsr_closure_def def;
            couple(&def, 2, (int[2]){last, at}, NULL, (double[2]){1.0, 1.2});
            if (i % 2) def.stiffness[0] = stiffness[k], def.damping[0] = 1e-4 * stiffness[k];
            if (i > 0) add_closure(&s, &def);
            last = at;
        }
        compare(&s);
    }
}

static int wave(void *user, double t, double *s, double *rate, double *acceleration)
{
    (void)user;
    s[0] = 0.2 * sin(3.0 * t);
    rate[0] = 0.6 * cos(3.0 * t);
    acceleration[0] = -1.8 * sin(3.0 * t);
    return 0;
}

/* A coordinate that follows a function of time, and one that is held. */
static void motions(void **state)
{
    (void)state;
    loops s;
    mbsr_closure_def def;
    loops_begin(&s, NULL);
    const int a = hinge(&s, MBSR_GROUND, 0.0, 0.0, z_axis, 1.0),
              b = hinge(&s, a, 0.4, 0.0, y_axis, 1.0), c = hinge(&s, b, 0.4, 0.0, tilted, 1.0),
              d = hinge(&s, c, 0.4, 0.0, y_axis, 0.5);
    couple(&def, 1, &b, NULL, (double[1]){1.0});
    def.motion = wave;
    add_closure(&s, &def);
    add_closure(&s, couple(&def, 2, (int[2]){d, a}, NULL, (double[2]){1.0, -2.0}));
    compare(&s);
}

/* Four-bars with gears on the same joints: a freedom that the gear takes, or that it takes again.
 */
static void across_other_loops(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; ++kind) {
        loops s;
        loops_begin(&s, NULL);
        const double coupler = kind % 2 ? 0.0 : 0.6;
        const int base = loops_rod(&s, "base", MBSR_GROUND, 0.0, 0.0, 2.0, 1.0),
                  crank = loops_rod(&s, "crank", base, 0.0, 0.1, 1.0, 0.5),
                  link = loops_rod(&s, "link", crank, 0.5, 0.0, coupler, 0.8),
                  rocker = loops_rod(&s, "rocker", base, 0.8, 0.1, 1.0, 0.5),
                  tool = loops_rod(&s, "tool", rocker, 0.5, 0.0, 0.4, 0.3);
        loops_pin(&s, "pin", link, 0.8, 0.0, rocker, 0.5, 0.0);
        gear(&s, tool, base, 0.6);
        mbsr_closure_def same = mbsr_closure_coupling(2, (int[2]){crank, rocker}, (int[2]){0, 0},
                                                      (double[2]){1.0, -1.0}, 0.0);
        if (kind > 1) add_closure(&s, &same); /* a parallelogram turns both alike */
        finish(&s);
        const double q[] = {0.2, 1.1, -1.1, 1.1, 0.3}, u[] = {0.5, 1.0, -1.0, 1.0, 0.1};
        memcpy(s.q, q, sizeof q);
        memcpy(s.u, u, sizeof u);
        compare_by(&s, coupler > 0.0 ? ONE_SWEEP : BY_FRONT);
        loops_free(&s);
    }
}

/* Rack and pinion in other units of length. */
static void units(void **state)
{
    (void)state;
    static const double unit[] = {1e-3, 1.0, 1e3};
    for (int k = 0; k < 3; ++k) {
        loops s;
        mbsr_closure_def def;
        const double L = unit[k];
        const mbsr_frame at = mbsr_frame_at(0.3 * L, 0.0, 0.0);
        memset(&s, 0, sizeof s);
        assert_ok(mbsr_model_create(NULL, &s.m, NULL), NULL);
        const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81 * L, 0.0);
        assert_ok(mbsr_model_add_force(s.m, &gravity, NULL), mbsr_model_error(s.m));
        const int base = add(&s, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z_axis), 2.0, L),
                  pinion = add(&s, base, mbsr_joint_revolute(&at, NULL, y_axis), 0.5, L),
                  rack = add(&s, base, mbsr_joint_prismatic(&at, NULL, x_axis), 1.0, L),
                  arm = add(&s, rack, mbsr_joint_revolute(&at, NULL, tilted), 0.4, L);
        couple(&def, 2, (int[2]){pinion, rack}, NULL, (double[2]){0.02 * L, -1.0});
        def.param[MBSR_CLOSURE_BODIES] = 0.1 * L;
        add_closure(&s, &def);
        gear(&s, arm, base, 0.5);
        finish(&s);
        s.q[2] *= L;
        s.u[2] *= L;
        compare_here(&s);
        loops_free(&s);
    }
}

/* ---- a law of one's own ---- */

/* g = q_a q_b + sin(q_a) - constant */
static int product_gap(const mbsr_closure_args *args, double *g)
{
    const double a = args->body[0].q[0], b = args->body[1].q[0];
    g[0] = a * b + sin(a) - args->closure->param[0];
    return 0;
}

static int product_rows(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    const double a = args->body[0].q[0], b = args->body[1].q[0];
    out->matrix[out->column[0] + args->body[0].d] = b + cos(a);
    out->matrix[out->column[1] + args->body[1].d] = a;
    return 0;
}

static int product_tangent(const mbsr_closure_args *args, const double *lambda,
                           const mbsr_closure_tangent *out)
{
    const int i = out->column[0] + args->body[0].d, j = out->column[1] + args->body[1].d;
    const double a = args->body[0].q[0], *ua = args->body[0].u, *ub = args->body[1].u;
    out->force[i * out->columns + i] -= sin(a) * lambda[0];
    out->force[i * out->columns + j] += lambda[0];
    out->force[j * out->columns + i] += lambda[0];
    out->rate[i] += ub[0] - sin(a) * ua[0];
    out->rate[j] += ua[0];
    return 0;
}

/* Coordinates that turn each other's rows, with derivatives by formulas, and by differences. */
static void laws_of_one_s_own(void **state)
{
    (void)state;
    static const unsigned flags =
        MBSR_CLOSURE_JOINTS | MBSR_CLOSURE_COORDINATES | MBSR_CLOSURE_PLAIN;
    static const mbsr_closure_table table[2] = {{.version = MBSR_CLOSURE_TABLE_VERSION,
                                                 .flags = flags,
                                                 .name = "product",
                                                 .position = product_gap,
                                                 .jacobian = product_rows,
                                                 .tangent = product_tangent},
                                                {.version = MBSR_CLOSURE_TABLE_VERSION,
                                                 .flags = flags,
                                                 .name = "product by differences",
                                                 .position = product_gap,
                                                 .jacobian = product_rows}};
    for (int kind = 0; kind < 4; ++kind) {
        loops s;
        const mbsr_frame at = mbsr_frame_at(0.3, 0.1, 0.0);
        loops_begin(&s, NULL);
        const int a = hinge(&s, MBSR_GROUND, 0.0, 0.0, z_axis, 1.0),
                  b = hinge(&s, a, 0.4, 0.0, tilted, 1.0),
                  c = kind < 2
                          ? hinge(&s, b, 0.4, 0.0, y_axis, 1.0)
                          : add(&s, b, mbsr_joint_universal(&at, NULL, y_axis, tilted), 1.0, 1.0),
                  d = hinge(&s, a, 0.1, 0.3, y_axis, 0.7);
        mbsr_closure_def def = mbsr_closure_custom(table + kind % 2, 2, (int[2]){c, d}, 1, 1, NULL);
        def.param[0] = 1.2;
        add_closure(&s, &def);
        gear(&s, a, b, 0.7);
        finish(&s);
        s.q[2] = 0.8;
        compare_here(&s);
        loops_free(&s);
    }
}

/* b u_a + (1 + a^2) u_b = 0, which no function of the coordinates says. */
static int slip_rows(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    const double a = args->body[0].q[0], b = args->body[1].q[0];
    out->matrix[out->column[0] + args->body[0].d] = b;
    out->matrix[out->column[1] + args->body[1].d] = 1.0 + a * a;
    return 0;
}

/* Rates that are coupled, and no coordinates; beside a gear, too. */
static void rates_alone(void **state)
{
    (void)state;
    static const mbsr_closure_table table = {.version = MBSR_CLOSURE_TABLE_VERSION,
                                             .flags = MBSR_CLOSURE_JOINTS |
                                                      MBSR_CLOSURE_COORDINATES | MBSR_CLOSURE_PLAIN,
                                             .name = "slip",
                                             .jacobian = slip_rows};
    for (int geared = 0; geared < 2; ++geared) {
        loops s;
        loops_begin(&s, NULL);
        const int a = hinge(&s, MBSR_GROUND, 0.0, 0.0, z_axis, 1.0),
                  b = hinge(&s, a, 0.4, 0.0, tilted, 1.0), c = hinge(&s, b, 0.4, 0.0, y_axis, 1.0),
                  d = hinge(&s, a, 0.1, 0.3, y_axis, 0.7);
        const mbsr_closure_def def = mbsr_closure_custom(&table, 2, (int[2]){c, d}, 1, 0, NULL);
        add_closure(&s, &def);
        if (geared) gear(&s, a, b, 0.7);
        finish(&s);
        s.q[2] = 0.8;
        compare_here(&s);
        loops_free(&s);
    }
}

/* Another coupling says the same once more: the start leaves it out. Where nobody did, the solver
 * names it. */
static void redundant_rows(void **state)
{
    (void)state;
    loops s;
    loops_begin(&s, NULL);
    const int a = hinge(&s, MBSR_GROUND, 0.0, 0.0, z_axis, 1.0),
              b = hinge(&s, a, 0.4, 0.0, tilted, 1.0), c = hinge(&s, b, 0.4, 0.0, y_axis, 1.0);
    gear(&s, a, b, 1.0);
    gear(&s, b, c, 1.0);
    mbsr_closure_def def;
    couple(&def, 2, (int[2]){a, c}, NULL, (double[2]){1.0, -1.0});
    def.param[MBSR_CLOSURE_BODIES] = 0.0;
    def.name = "again";
    add_closure(&s, &def);
    finish(&s);
    compare_here(&s);
    double y[64], yp[64] = {0.0};
    mbsr_data *other;
    mbsr_newton *newton = newton_solver(s.m, 0);
    assert_ok(mbsr_data_create(s.m, &other, NULL), NULL);
    assert_ok(mbsr_dae_pack(s.m, other, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
    assert_refused(mbsr_newton_factor(newton, other, 0.0, y, yp, 50.0), mbsr_newton_error(newton),
                   MBSR_LOOP_SINGULAR, MBSR_NONE, MBSR_NONE, "closure|row 'coordinates'");
    mbsr_newton_destroy(newton);
    mbsr_data_destroy(other);
    loops_free(&s);
}

/* A body without mass that no coupling holds. */
static void nothing_holds(void **state)
{
    (void)state;
    loops s;
    double y[64], yp[64] = {0.0};
    loops_begin(&s, NULL);
    const int a = hinge(&s, MBSR_GROUND, 0.0, 0.0, z_axis, 1.0),
              b = hinge(&s, a, 0.4, 0.0, tilted, 0.0), c = hinge(&s, b, 0.4, 0.0, y_axis, 0.0);
    gear(&s, a, c, 1.0);
    finish(&s);
    mbsr_newton *newton = newton_solver(s.m, 0);
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
    assert_refused(mbsr_newton_factor(newton, s.d, 0.0, y, yp, 50.0), mbsr_newton_error(newton),
                   MBSR_SINGULAR_BLOCK, b, MBSR_NONE, "no loop holds");
    mbsr_newton_destroy(newton);
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(gears_between_neighbours),
                                       cmocka_unit_test(mimicking_fingers),
                                       cmocka_unit_test(differentials),
                                       cmocka_unit_test(joints_of_several_axes),
                                       cmocka_unit_test(stiff_couplings),
                                       cmocka_unit_test(motions),
                                       cmocka_unit_test(across_other_loops),
                                       cmocka_unit_test(units),
                                       cmocka_unit_test(laws_of_one_s_own),
                                       cmocka_unit_test(rates_alone),
                                       cmocka_unit_test(redundant_rows),
                                       cmocka_unit_test(nothing_holds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* What single closures exert on their bodies, and where: against statics and a rolling ball.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/closure.h>
#include <mbsrank/mbsrank.h>

#include <math.h>
#include <string.h>

typedef struct scene {
    mbsr_model *m;
    mbsr_data *d;
    double q[20], u[20], udot[20];
} scene;

static void begin(scene *s, double gx, double gy, double gz)
{
    const mbsr_force_def gravity = mbsr_force_gravity(gx, gy, gz);
    *s = (scene){.m = NULL};
    assert_ok(mbsr_model_create(NULL, &s->m, NULL), NULL);
    assert_ok(mbsr_model_add_force(s->m, &gravity, NULL), mbsr_model_error(s->m));
}

static int add_body(scene *s, mbsr_joint joint, double mass, const double centre[3], double inertia)
{
    const double tensor[6] = {inertia, inertia, inertia, 0.0, 0.0, 0.0};
    mbsr_body_def def = mbsr_default_body_def();
    int id;
    def.parent = MBSR_GROUND;
    def.joint = joint;
    def.inertia = mbsr_inertia_rigid(mass, centre, tensor);
    assert_ok(mbsr_model_add_body(s->m, &def, &id), mbsr_model_error(s->m));
    return id;
}

static int add_closure(scene *s, mbsr_closure_def def)
{
    int id;
    assert_ok(mbsr_model_add_closure(s->m, &def, &id), mbsr_model_error(s->m));
    return id;
}

static void finish(scene *s)
{
    assert_ok(mbsr_model_finish(s->m), mbsr_model_error(s->m));
    assert_ok(mbsr_data_create(s->m, &s->d, NULL), NULL);
}

static void accelerate(scene *s)
{
    assert_ok(mbsr_forward_dynamics(s->m, s->d, 0.0, s->q, s->u, NULL, s->udot),
              mbsr_data_error(s->d));
}

static void end(scene *s)
{
    mbsr_data_destroy(s->d);
    mbsr_model_destroy(s->m);
}

static void reaction(scene *s, int closure, int place, double *f)
{
    assert_ok(mbsr_closure_reaction(s->m, s->d, closure, place, f, NULL), mbsr_data_error(s->d));
}

static void assert_vector(const double *x, double a, double b, double c, double tolerance)
{
    assert_close(x[0], a, tolerance);
    assert_close(x[1], b, tolerance);
    assert_close(x[2], c, tolerance);
}

/* A ball rolls down a plane: a = 5/7 g sin, friction 2/7 m g sin, at the point of contact. Its
 * origin is beside its centre. */
static void rolling_ball(void **state)
{
    (void)state;
    const double slope = 0.4, g = 9.81, mass = 3.0, r = 0.2, centre[3] = {0.05, 0.1, -0.02};
    const double down = mass * g * sin(slope), N = mass * g * cos(slope);
    double f[6], x[3];
    scene s;
    begin(&s, g * sin(slope), 0.0, -g * cos(slope));
    const int ball = add_body(&s, mbsr_joint_free(NULL, NULL), mass, centre, 0.4 * mass * r * r);
    const int contact =
        add_closure(&s, mbsr_closure_rolling_ball(ball, centre, r, MBSR_GROUND, NULL));
    finish(&s);
    s.q[0] = 1.0;
    s.q[4] = 7.0 - centre[0], s.q[5] = -centre[1], s.q[6] = r - centre[2];
    accelerate(&s);
    reaction(&s, contact, 0, f);
    assert_ok(mbsr_closure_point(s.m, s.d, contact, x), mbsr_data_error(s.d));
    assert_vector(x, 7.0, 0.0, 0.0, 1e-15);
    assert_vector(f + 3, -2.0 / 7.0 * down, 0.0, N, 1e-12 * N);
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double arm_i = x[i] - s.q[4 + i], arm_j = x[j] - s.q[4 + j];
        assert_close(f[k], arm_i * f[3 + j] - arm_j * f[3 + i], 1e-12 * N);
    }
    double own;
    assert_int_equal(mbsr_closure_reaction(s.m, s.d, contact, 1, NULL, &own), MBSR_OK);
    end(&s);
}

/* Two bodies welded to each other, one of them held by a ball joint, the other by its joint: the
 * ball and the rail share the weight; what the weld exerts on one it takes from the other. */
static void hanging(void **state)
{
    (void)state;
    const double origin[3] = {0.0, 0.0, 0.0}, up[3] = {0.0, 0.0, 1.0}, hook[3] = {0.0, 0.0, 0.5};
    const mbsr_frame beside = mbsr_frame_at(0.0, 0.0, -1.0);
    double f[6], h[6], x[3];
    scene s;
    begin(&s, 0.0, 0.0, -10.0);
    const int above = add_body(&s, mbsr_joint_free(NULL, NULL), 2.0, origin, 0.1),
              below = add_body(&s, mbsr_joint_prismatic(NULL, NULL, up), 3.0, origin, 0.1);
    const int weld = add_closure(&s, mbsr_closure_weld(above, &beside, below, NULL)),
              ball = add_closure(&s, mbsr_closure_ball(MBSR_GROUND, hook, above, hook));
    finish(&s);
    s.q[0] = 1.0, s.q[7] = -1.0;
    accelerate(&s);
    reaction(&s, ball, 1, f);
    assert_vector(f, 0.0, 0.0, 0.0, 1e-11);
    assert_vector(f + 3, 0.0, 0.0, 50.0, 1e-11);
    assert_ok(mbsr_closure_point(s.m, s.d, ball, x), mbsr_data_error(s.d));
    assert_vector(x, 0.0, 0.0, 0.5, 1e-15);
    reaction(&s, weld, 0, f);
    reaction(&s, weld, 1, h);
    assert_vector(f + 3, 0.0, 0.0, -30.0, 1e-11);
    assert_vector(h + 3, 0.0, 0.0, 30.0, 1e-11);
    assert_ok(mbsr_closure_point(s.m, s.d, weld, x), mbsr_data_error(s.d));
    assert_vector(x, 0.0, 0.0, -1.0, 1e-15);
    end(&s);
}

/* Sliders coupled by q0 - 2 q1 = 0: forces F and -2 F along them, of which each one keeps its own.
 */
static void coupled(void **state)
{
    (void)state;
    const double origin[3] = {0.0, 0.0, 0.0}, up[3] = {0.0, 0.0, 1.0}, factor[2] = {1.0, -2.0};
    double f[6], tau, other, lambda, x[3];
    scene s;
    begin(&s, 0.0, 0.0, -10.0);
    const int body[2] = {add_body(&s, mbsr_joint_prismatic(NULL, NULL, up), 1.0, origin, 0.1),
                         add_body(&s, mbsr_joint_prismatic(NULL, NULL, up), 1.0, origin, 0.1)},
              coordinate[2] = {0, 0};
    const int gear = add_closure(&s, mbsr_closure_coupling(2, body, coordinate, factor, 0.0));
    finish(&s);
    accelerate(&s);
    assert_ok(mbsr_closures_lambda(s.m, s.d, &lambda), mbsr_data_error(s.d));
    assert_ok(mbsr_closure_reaction(s.m, s.d, gear, 0, f, &tau), mbsr_data_error(s.d));
    assert_ok(mbsr_closure_reaction(s.m, s.d, gear, 1, NULL, &other), mbsr_data_error(s.d));
    assert_close(tau, lambda, 1e-13);
    assert_close(other, -2.0 * lambda, 1e-13);
    assert_close(s.udot[0], tau - 10.0, 1e-12);
    assert_close(s.udot[1], other - 10.0, 1e-12);
    for (int k = 0; k < 6; ++k) assert_true(f[k] == 0.0);
    assert_int_equal(mbsr_closure_point(s.m, s.d, gear, x), MBSR_ERR_VALUE);
    assert_contains(mbsr_data_error(s.d)->text, "closure 0|coupling|no point");
    end(&s);
}

static void refused(void **state)
{
    (void)state;
    const double origin[3] = {0.0, 0.0, 0.0};
    double f[6], x[3];
    scene s;
    begin(&s, 0.0, 0.0, -10.0);
    const int body = add_body(&s, mbsr_joint_free(NULL, NULL), 2.0, origin, 0.1);
    add_closure(&s, mbsr_closure_ball(body, origin, MBSR_GROUND, origin));
    finish(&s);
    s.q[0] = 1.0;
    assert_int_equal(mbsr_closure_reaction(s.m, s.d, 0, 0, f, NULL), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_closure_point(s.m, s.d, 0, x), MBSR_ERR_SEQUENCE);
    accelerate(&s);
    assert_int_equal(mbsr_closure_reaction(s.m, s.d, 1, 0, f, NULL), MBSR_ERR_ID);
    assert_contains(mbsr_data_error(s.d)->text, "closure is 1|has 1");
    assert_int_equal(mbsr_closure_reaction(s.m, s.d, 0, 2, f, NULL), MBSR_ERR_VALUE);
    assert_contains(mbsr_data_error(s.d)->text, "place is 2|closure 0 (ball)|2 bodies");
    assert_int_equal(mbsr_closure_reaction(s.m, s.d, 0, -1, f, NULL), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_closure_point(s.m, s.d, -1, x), MBSR_ERR_ID);
    assert_int_equal(mbsr_closure_point(s.m, s.d, 0, NULL), MBSR_ERR_NULL);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rolling_ball),
        cmocka_unit_test(hanging),
        cmocka_unit_test(coupled),
        cmocka_unit_test(refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

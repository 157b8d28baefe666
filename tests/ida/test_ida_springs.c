/* Stock springs as closures with the driver: the motion of the force element, at the price of the
 * rigid joint, however stiff it is.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops_run.h"

#include <stdbool.h>
#include <string.h>

enum { RIGID = -1 };

typedef enum pin { BUSHING, BAND, AXES } pin; /* what ties the rod's end to the slider */

static void add(loops *s, mbsr_force_def def, int as_closure)
{
    def.as_closure = as_closure;
    def.name = "pin";
    assert_ok(mbsr_model_add_force(s->m, &def, NULL), mbsr_model_error(s->m));
}

/* Slider-crank of tests/ida/test_ida_stiff.c: crank 0.2 m and 2 kg, rod 0.6 m and 1 kg, slider 1.5
 * kg. It falls from phi = 1 at rest, with phi = -1.590430257 after 3 s where the pin is rigid. */
static void crank(loops *s, pin kind, double k, double d, int as_closure)
{
    const double a = 0.2, l = 0.6, b = asin(a * sin(1.0) / l);
    const mbsr_planar_frame own = {0.0, 0.0, 0.0}, end = {l, 0.0, 0.0};
    const double end_of_rod[3] = {l, 0.0, 0.0};
    loops_begin(s, NULL);
    const int wheel = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 2.0, a);
    const int rod = loops_rod(s, "rod", wheel, a, 0.0, 1.0, l);
    int slider;
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "slider";
    body.joint = mbsr_joint_planar_prismatic(own, own);
    body.inertia = mbsr_inertia_planar(1.5, (double[2]){0.0, 0.0}, 1.0);
    assert_ok(mbsr_model_add_body(s->m, &body, &slider), mbsr_model_error(s->m));
    const double K[9] = {k, 0.0, 0.0, 0.0, k, 0.0, 0.0, 0.0, 0.0},
                 D[9] = {d, 0.0, 0.0, 0.0, d, 0.0, 0.0, 0.0, 0.0};
    if (as_closure == RIGID) {
        loops_pin(s, "pin", rod, l, 0.0, slider, 0.0, 0.0);
    } else if (kind == BUSHING) {
        add(s, mbsr_force_planar_bushing(slider, own, rod, end, K, D), as_closure);
    } else if (kind == BAND) {
        add(s, mbsr_force_point_spring(rod, end_of_rod, slider, NULL, k, 0.0, 0.0), as_closure);
    } else {
        for (int axis = 0; axis < 2; ++axis) {
            int tip;
            body.name = "tip";
            body.parent = rod;
            body.joint = mbsr_joint_point(end, 0, 0, NULL, NULL);
            body.inertia = mbsr_inertia_zero();
            assert_ok(mbsr_model_add_body(s->m, &body, &tip), mbsr_model_error(s->m));
            add(s, mbsr_force_axis_spring(tip, slider, axis, k, d, 0.0), as_closure);
        }
    }
    loops_finish(s);
    s->q[0] = 1.0;
    s->q[1] = -1.0 - b;
    s->q[2] = a * cos(1.0) + l * cos(b);
}

/* A pendulum in space on a universal joint whose lower rod hangs on a bushing: k in all directions,
 * of the turns one is soft. */
static void pendulum(loops *s, double k, double d, int as_closure)
{
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0};
    const mbsr_frame end = mbsr_frame_at(0.0, -0.8, 0.0);
    int upper, lower;
    loops_begin(s, NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.inertia = mbsr_inertia_rigid(2.0, (double[3]){0.0, -0.4, 0.0},
                                      (double[6]){0.11, 0.01, 0.11, 0.0, 0.0, 0.0});
    body.joint = mbsr_joint_universal(NULL, NULL, z, x);
    assert_ok(mbsr_model_add_body(s->m, &body, &upper), mbsr_model_error(s->m));
    if (as_closure == RIGID) {
        const mbsr_joint hinge = mbsr_joint_revolute(&end, NULL, y);
        int cut;
        body.joint = mbsr_joint_free(NULL, NULL);
        assert_ok(mbsr_model_add_body(s->m, &body, &lower), mbsr_model_error(s->m));
        assert_ok(mbsr_model_add_loop_joint(s->m, "pin", upper, &hinge, lower, NULL, NULL, &cut),
                  mbsr_model_error(s->m));
        add(s, mbsr_force_joint_spring(cut, 0, 5.0, 0.5, 0.0), 0);
    } else {
        const double K[6] = {k, 5.0, k, k, k, k}, D[6] = {d, 0.5, d, d, d, d};
        body.joint = mbsr_joint_free(NULL, NULL);
        assert_ok(mbsr_model_add_body(s->m, &body, &lower), mbsr_model_error(s->m));
        add(s, mbsr_force_bushing(upper, &end, lower, NULL, K, D), as_closure);
    }
    loops_finish(s);
    s->q[0] = 0.7;
    const mbsr_frame turned = mbsr_frame_rotated(NULL, z, 0.7);
    mbsr_rotation_quaternion(turned.R, s->q + 2);
    s->q[6] = 0.8 * sin(0.7);
    s->q[7] = -0.8 * cos(0.7);
}

/* Both ways from the same state: soft enough for the force element. */
static void same_motion(void **state)
{
    (void)state;
    for (int kind = BUSHING; kind <= AXES; ++kind) {
        loops force, closure;
        const double d = kind == BAND ? 0.0 : 50.0;
        crank(&force, (pin)kind, 1e4, d, 0);
        crank(&closure, (pin)kind, 1e4, d, MBSR_SPRING_LOOSE);
        const loops_result x = loops_run(&force, 1e-9, 1.0), y = loops_run(&closure, 1e-9, 1.0);
        assert_int_equal(x.status, MBSR_OK);
        assert_int_equal(y.status, MBSR_OK);
        for (int k = 0; k < 3; ++k) assert_close(closure.q[k], force.q[k], 2e-6);
        assert_close(y.energy, x.energy, 1e-4);
        loops_free(&force);
        loops_free(&closure);
    }
    loops force, closure;
    pendulum(&force, 2e4, 0.0, 0);
    pendulum(&closure, 2e4, 0.0, MBSR_SPRING_LOOSE);
    assert_int_equal(loops_run(&force, 1e-9, 0.5).status, MBSR_OK);
    assert_int_equal(loops_run(&closure, 1e-9, 0.5).status, MBSR_OK);
    for (int k = 0; k < force.nq; ++k) assert_close(closure.q[k], force.q[k], 2e-6);
    loops_free(&force);
    loops_free(&closure);
}

static void at_the_price_of_the_rigid_pin(void **state)
{
    (void)state;
    /* the rigid pin loses 0.21, 2.8e-3, 1.8e-5 */
    static const double tolerance[] = {1e-4, 1e-6, 1e-8}, lost[] = {0.2, 2e-3, 3e-5};
    for (int t = 0; t < 3; ++t) {
        loops rigid;
        crank(&rigid, BUSHING, 0.0, 0.0, RIGID);
        const loops_result r = loops_run(&rigid, tolerance[t], 3.0);
        assert_int_equal(r.status, MBSR_OK);

        loops_free(&rigid);
        for (int kind = BUSHING; kind <= AXES; kind += 2) {
            for (double k = 1e8; k < 2e14; k *= 100.0) {
                loops s;
                crank(&s, (pin)kind, k, 1e-4 * k, MBSR_SPRING_SETTLED);
                const loops_result x = loops_run(&s, tolerance[t], 3.0);
                assert_int_equal(x.status, MBSR_OK);
                assert_close(s.q[0], -1.590430257, lost[t]);
                assert_true(4 * x.steps <= 5 * r.steps);
                assert_less(x.energy, 1e3 * tolerance[t]);
                loops_free(&s);
            }
        }
    }
}

static void in_space(void **state)
{
    (void)state;
    loops rigid, s;
    pendulum(&rigid, 0.0, 0.0, RIGID);
    const loops_result r = loops_run(&rigid, 1e-6, 2.0);
    assert_int_equal(r.status, MBSR_OK);
    for (double k = 1e8; k < 2e14; k *= 100.0) {
        pendulum(&s, k, 1e-4 * k, MBSR_SPRING_SETTLED);
        const loops_result x = loops_run(&s, 1e-6, 2.0);
        assert_int_equal(x.status, MBSR_OK);
        assert_true(4 * x.steps <= 5 * r.steps);
        for (int j = 0; j < 2; ++j) assert_close(s.q[j], rigid.q[j], 3e-4);
        loops_free(&s);
    }
    loops_free(&rigid);
}

static int turn(void *user, double t, double *s, double *rate, double *acceleration)
{
    (void)user;
    *s = 10.0 * t;
    *rate = 10.0;
    *acceleration = 0.0;
    return MBSR_OK;
}

/* Two shafts at an angle of 0.5 rad; the bearing of the second, without mass, is held by a bushing
 * that is soft against turning. With the second shaft's centre of mass at the joint there are no
 * forces at the start. */
static void shafts(loops *s, double k, double d, const double com[3], int as_closure)
{
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0}, tilt = 0.5,
                 moments[6] = {0.03, 0.03, 0.05}, K[6] = {10.0, 10.0, 10.0, k, k, k},
                 D[6] = {0.1, 0.1, 0.1, d, d, d};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1};
    const mbsr_frame on_shaft = mbsr_frame_at(0.0, 0.0, 0.4),
                     tilted = mbsr_frame_rotated(NULL, x, tilt),
                     on_ground = mbsr_frame_product(&tilted, &on_shaft);
    int id = MBSR_GROUND;
    loops_begin(s, NULL);
    for (int i = 0; i < 3; ++i) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = id;
        body.joint = i == 0   ? mbsr_joint_compound(NULL, NULL, 1, &axis, turn, NULL)
                     : i == 1 ? mbsr_joint_universal(NULL, NULL, x, y)
                              : mbsr_joint_revolute(&on_shaft, NULL, z);
        body.inertia = i == 1 ? mbsr_inertia_rigid(4.0, com, moments) : mbsr_inertia_zero();
        assert_ok(mbsr_model_add_body(s->m, &body, &id), mbsr_model_error(s->m));
    }
    const mbsr_force_def gravity =
        mbsr_force_gravity(0.0, 9.81, 0.0); /* against that of loops_begin */
    assert_ok(mbsr_model_add_force(s->m, &gravity, NULL), mbsr_model_error(s->m));
    add(s, mbsr_force_bushing(MBSR_GROUND, &on_ground, id, NULL, K, D), as_closure);
    loops_finish(s);
    s->q[0] = tilt;
    s->u[1] = -10.0 * sin(tilt);
    s->u[2] = -10.0 * cos(tilt);
}

/* Crank 0.2 m about z, rod 0.6 m, slider along x at z = 0.1 m; rod and slider held by a bushing
 * that is soft against turning. Where the crank stands across the slide, all its rows together lose
 * rank. */
static void crank_in_space(loops *s, double k, double d, double loss, int as_closure)
{
    const double z[3] = {0.0, 0.0, 1.0}, x[3] = {1.0, 0.0, 0.0}, phi = 1.0, beside = 0.1, rod = 0.6,
                 up = 0.2 * sin(phi), ahead = sqrt(rod * rod - up * up - beside * beside),
                 K[6] = {10.0, 10.0, 10.0, k, k, k}, D[6] = {loss, loss, loss, d, d, d},
                 length[3] = {0.2, 0.6, 0.1}, mass[3] = {2.0, 1.0, 1.5};
    const mbsr_frame tip = mbsr_frame_at(0.2, 0.0, 0.0), end = mbsr_frame_at(rod, 0.0, 0.0),
                     rail = mbsr_frame_at(0.0, 0.0, beside);
    const mbsr_joint joint[3] = {mbsr_joint_revolute(NULL, NULL, z),
                                 mbsr_joint_spherical(&tip, NULL),
                                 mbsr_joint_prismatic(&rail, NULL, x)};
    int id[3];
    loops_begin(s, NULL);
    for (int i = 0; i < 3; ++i) {
        const double com[3] = {0.5 * length[i], 0.0, 0.0},
                     across = mass[i] * length[i] * length[i] / 12.0,
                     tensor[6] = {2e-4 * mass[i], across, across, 0.0, 0.0, 0.0};
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = i == 1 ? id[0] : MBSR_GROUND;
        body.joint = joint[i];
        body.inertia = mbsr_inertia_rigid(mass[i], com, tensor);
        assert_ok(mbsr_model_add_body(s->m, &body, id + i), mbsr_model_error(s->m));
    }
    add(s, mbsr_force_bushing(id[1], &end, id[2], NULL, K, D), as_closure);
    loops_finish(s);
    const double w = 1.0 + ahead / rod, j = -beside / rod, l = -up / rod,
                 n = sqrt(w * w + j * j + l * l), c = cos(0.5 * phi) / n,
                 sine = -sin(0.5 * phi) / n;
    s->q[0] = phi;
    s->q[1] = c * w - sine * l;
    s->q[2] = -sine * j;
    s->q[3] = c * j;
    s->q[4] = c * l + sine * w;
    s->q[5] = 0.2 * cos(phi) + ahead;
}

/* Past that position, as by a force; stiffer, at the same price at all tolerances. */
static void past_loss_of_rank(void **state)
{
    (void)state;
    static const double tolerance[] = {1e-4, 1e-6, 1e-8};
    static const long most[] = {250, 550, 1150};
    loops force, closure;
    crank_in_space(&force, 1e4, 10.0, 0.0, 0);
    crank_in_space(&closure, 1e4, 10.0, 0.0, MBSR_SPRING_LOOSE);
    assert_int_equal(loops_run(&force, 1e-8, 0.6).status, MBSR_OK);
    assert_int_equal(loops_run(&closure, 1e-8, 0.6).status, MBSR_OK);
    for (int k = 0; k < force.nq; ++k) assert_close(closure.q[k], force.q[k], 2e-6);
    loops_free(&force);
    loops_free(&closure);
    for (double stiffness = 1e10; stiffness < 2e12; stiffness *= 1e2) {
        for (int l = 0; l < 3; ++l) {
            crank_in_space(&closure, stiffness, 1e-5 * stiffness, 0.1, MBSR_SPRING_LOOSE);
            const loops_result r = loops_run(&closure, tolerance[l], 1.0);
            assert_int_equal(r.status, MBSR_OK);
            assert_true(r.steps < most[l]);
            if (l == 2) assert_close(closure.q[0], -2.572803, 1e-5);
            loops_free(&closure);
        }
    }
}

/* As by a force; and on stiffer ones the angles of a universal joint, tan a = tan 0.5 cos 10 t. */
static void soft_turns(void **state)
{
    (void)state;
    static const double none[3] = {0.0};
    loops force, closure;
    shafts(&force, 1e3, 1.0, none, 0);
    shafts(&closure, 1e3, 1.0, none, MBSR_SPRING_LOOSE);
    assert_int_equal(loops_run(&force, 1e-8, 0.3).status, MBSR_OK);
    assert_int_equal(loops_run(&closure, 1e-8, 0.3).status, MBSR_OK);
    for (int k = 0; k < 3; ++k) assert_close(closure.q[k], force.q[k], 1e-6);
    loops_free(&force);
    loops_free(&closure);
    for (double stiffness = 1e6; stiffness < 2e10; stiffness *= 1e2) {
        shafts(&closure, stiffness, 1e-4 * stiffness, none, MBSR_SPRING_LOOSE);
        const loops_result r = loops_run(&closure, 1e-6, 1.0);
        assert_int_equal(r.status, MBSR_OK);
        assert_true(r.steps < 250);
        assert_close(tan(closure.q[0]), tan(0.5) * cos(10.0), 3e-5);
        loops_free(&closure);
    }
}

/* A settled start: F is zero there, and each spring bears what its gap says. `most`: of |F|. */
static void settle(loops *s, double most)
{
    double y[LOOPS_MOST], yp[LOOPS_MOST], F[LOOPS_MOST], gap[6], rate[6], size = 0.0;
    const mbsr_error *error = mbsr_data_error(s->d);
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y), error);
    assert_ok(mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL), error);
    assert_ok(mbsr_dae_residual(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), error);
    assert_less(test_largest(mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM), F), most);
    assert_ok(mbsr_dae_unpack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, s->q, s->u), error);
    loops_rows(s, 0.0, s->q, s->u, NULL, gap, rate, NULL);
    for (int k = 0; k < 6; ++k) size = fmax(size, fabs(y[s->nq + 2 * s->nu + k]));
    for (int k = 0; k < 6; ++k) {
        mbsr_closure_def def;
        assert_ok(mbsr_closure_definition(s->m, 0, &def), NULL);
        assert_close(y[s->nq + 2 * s->nu + k], def.stiffness[k] * gap[k],
                     1e-6 * size + 1e-12 * def.stiffness[k]);
    }
}

/* Six rows settled where there are fewer freedoms, by loads that move all of them: as by a force
 * from there. */
static void settled(void **state)
{
    (void)state;
    static const double beside[3] = {0.05, 0.02, 0.1}, t_end = 0.1;
    loops force, closure;
    for (int kind = 0; kind < 2; ++kind) {
        for (double k = 1e4; k < 2e10; k *= 1e2) {
            if (kind == 0)
                shafts(&closure, k, 1e-4 * k, beside, MBSR_SPRING_SETTLED);
            else
                crank_in_space(&closure, k, 1e-4 * k, 0.1, MBSR_SPRING_SETTLED);
            for (int j = 0; j < closure.nq; ++j) closure.q[j] += 0.01 * sin(3.0 * j);
            settle(&closure, 1e-7 * (1.0 + 1e-8 * k));
            if (k < 2e4) {
                if (kind == 0)
                    shafts(&force, k, 1e-4 * k, beside, 0);
                else
                    crank_in_space(&force, k, 1e-4 * k, 0.1, 0);
                memcpy(force.q, closure.q, sizeof force.q);
                memcpy(force.u, closure.u, sizeof force.u);
                assert_int_equal(loops_run(&force, 1e-8, t_end).status, MBSR_OK);
                assert_int_equal(loops_run(&closure, 1e-8, t_end).status, MBSR_OK);
                for (int j = 0; j < force.nq; ++j) assert_close(closure.q[j], force.q[j], 1e-6);
                loops_free(&force);
            }
            loops_free(&closure);
        }
    }
}

/* Two springs hold one slider, one three times as stiff: they bear its weight by their stiffness.
 */
static void shared_weight(void **state)
{
    (void)state;
    const double y[3] = {0.0, 1.0, 0.0}, none[3] = {0.0}, moments[6] = {1.0, 1.0, 1.0}, one = 1.0,
                 weight = 2.0 * 9.81;
    for (double k = 1e3; k < 2e9; k *= 1e2) {
        loops s;
        int slider, coordinate = 0;
        double gap[2];
        mbsr_body_def body = mbsr_default_body_def();
        loops_begin(&s, NULL);
        body.joint = mbsr_joint_prismatic(NULL, NULL, y);
        body.inertia = mbsr_inertia_rigid(2.0, none, moments);
        assert_ok(mbsr_model_add_body(s.m, &body, &slider), mbsr_model_error(s.m));
        for (int l = 0; l < 2; ++l) {
            mbsr_closure_def spring = mbsr_closure_coupling(1, &slider, &coordinate, &one, 0.0);
            spring.stiffness[0] = l == 0 ? k : 3.0 * k;
            spring.damping[0] = 1.0;
            assert_ok(mbsr_model_add_closure(s.m, &spring, NULL), mbsr_model_error(s.m));
        }
        loops_finish(&s);
        s.q[0] = 0.3;
        assert_int_equal(loops_run(&s, 1e-8, 0.1).status, MBSR_OK);
        assert_close(s.q[0], -weight / (4.0 * k), 1e-9 + 1e-6 * weight / k);
        assert_close(s.lambda[0], 0.25 * weight, 1e-6 * weight + 1e-12 * k);
        assert_close(s.lambda[1], 0.75 * weight, 1e-6 * weight + 3e-12 * k);
        loops_rows(&s, 0.0, s.q, s.u, NULL, gap, NULL, NULL);
        for (int l = 0; l < 2; ++l) assert_close(gap[l], s.q[0], 1e-15);
        loops_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_motion),       cmocka_unit_test(at_the_price_of_the_rigid_pin),
        cmocka_unit_test(in_space),          cmocka_unit_test(soft_turns),
        cmocka_unit_test(past_loss_of_rank), cmocka_unit_test(settled),
        cmocka_unit_test(shared_weight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

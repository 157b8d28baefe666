/* Stock springs as closures: the same forces, energies and reactions as the force elements.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

#include <mbsrank/verify.h>

#include <stdbool.h>
#include <string.h>

enum { A, B, C, BODIES }; /* of the trees below */

/* A trunk with two branches, in space or in the plane. */
static void tree(loops *s, bool flat)
{
    const double axis[3] = {2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0}, z[3] = {0.0, 0.0, 1.0};
    const mbsr_frame out = mbsr_frame_at(0.7, 0.1, flat ? 0.0 : -0.2);
    const mbsr_planar_frame end = {0.7, 0.1, 0.3}, own = {0.0, 0.0, 0.0};
    loops_begin(s, NULL);
    for (int k = 0; k < BODIES; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k == A ? MBSR_GROUND : A;
        if (flat) {
            body.joint = k == B ? mbsr_joint_planar_free(end, own)
                                : mbsr_joint_planar_revolute(k == A ? own : end, own);
            body.inertia = mbsr_inertia_planar(1.5, (double[2]){0.2, -0.1}, 0.3);
        } else {
            body.joint = k == B   ? mbsr_joint_free(&out, NULL)
                         : k == A ? mbsr_joint_universal(NULL, NULL, z, axis)
                                  : mbsr_joint_revolute(&out, NULL, axis);
            body.inertia = mbsr_inertia_rigid(1.5, (double[3]){0.2, -0.1, 0.3},
                                              (double[6]){0.4, 0.5, 0.6, 0.01, 0.02, -0.03});
        }
        assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
    }
}

typedef mbsr_force_def (*element)(void);
static const double p[3] = {0.3, -0.2, 0.1}, r[3] = {-0.1, 0.5, 0.2};

static mbsr_force_def line(void)
{
    return mbsr_force_point_spring(B, p, C, r, 230.0, 4.0, 0.4);
}

static mbsr_force_def rubber_band(void)
{
    return mbsr_force_point_spring(B, p, C, r, 230.0, 0.0, 0.0);
}

static mbsr_force_def tight_line(void)
{
    return mbsr_force_point_spring(MBSR_GROUND, p, C, r, 230.0, 3.0, 0.0);
}

static mbsr_force_def joint(void)
{
    return mbsr_force_joint_spring(C, 0, 75.0, 2.0, 0.3);
}

static mbsr_force_def gear(void)
{
    const mbsr_gear teeth = {.ratio = -1.5, .stiffness = 40.0, .damping = 3.0, .rest = 0.1};
    return mbsr_force_gear(A, 0, C, 0, &teeth);
}

static mbsr_force_def axis(void)
{
    return mbsr_force_axis_spring(B, C, 1, 90.0, 5.0, 0.2);
}

static mbsr_force_def turning_axis(void)
{
    return mbsr_force_axis_spring(B, MBSR_GROUND, 2, 90.0, 5.0, 0.2);
}

static mbsr_force_def planar_bushing(const double K[9], const double D[9])
{
    const mbsr_planar_frame a = {0.3, -0.1, 0.4}, b = {0.1, 0.2, -0.7};
    return mbsr_force_planar_bushing(B, a, C, b, K, D);
}

/* Damping that is neither proportional nor along the same directions. */
static mbsr_force_def full_bushing(void)
{
    const double K[9] = {50.0, 10.0, -3.0, 10.0, 80.0, 5.0, -3.0, 5.0, 9.0},
                 D[9] = {3.0, -1.0, 0.2, -1.0, 2.0, 0.1, 0.2, 0.1, 0.5};
    return planar_bushing(K, D);
}

/* Stiffness and damping along one direction alone, and along two. */
static mbsr_force_def strut(void)
{
    const double K[9] = {16.0, 8.0, 0.0, 8.0, 4.0, 0.0, 0.0, 0.0, 0.0},
                 D[9] = {4.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0};
    return planar_bushing(K, D);
}

static mbsr_force_def bushing(void)
{
    const mbsr_frame a = mbsr_frame_rotated(NULL, (double[3]){0.0, 0.6, 0.8}, 0.4),
                     b = mbsr_frame_at(0.1, 0.2, 0.05);
    const double K[6] = {20.0, 30.0, 10.0, 150.0, 80.0, 200.0},
                 D[6] = {0.0, 0.0, 0.0, 5.0, 7.0, 3.0};
    return mbsr_force_bushing(B, &a, C, &b, K, D);
}

/* Rows for some of the axes alone. */
static mbsr_force_def hinge(void)
{
    const double K[6] = {20.0, 0.0, 10.0, 150.0, 0.0, 0.0}, D[6] = {0.0, 0.0, 0.0, 5.0, 0.0, 0.0};
    return mbsr_force_bushing(MBSR_GROUND, NULL, B, NULL, K, D);
}

static void build(loops *s, bool flat, element make, int as_closure)
{
    mbsr_force_def force = make();
    int id;
    tree(s, flat);
    force.name = "spring";
    force.as_closure = as_closure;
    assert_ok(mbsr_model_add_force(s->m, &force, &id), mbsr_model_error(s->m));
    assert_int_equal(id, 1);
    loops_finish(s);
}

/* A position away from the one in which all agrees. */
static void random_state(const loops *s, test_rng *rng, double *q, double *u, double *udot)
{
    test_fill(rng, s->nq, q);
    test_fill(rng, s->nu, u);
    test_fill(rng, s->nu, udot);
    assert_ok(mbsr_normalise(s->m, s->d, q), mbsr_data_error(s->d));
}

static void at(loops *s, const double *q, const double *u)
{
    const mbsr_error *error = mbsr_data_error(s->d);
    assert_ok(mbsr_stage_positions(s->m, s->d, 0.3, q), error);
    assert_ok(mbsr_stage_velocities(s->m, s->d, u), error);
}

/* What both report at the state of the data, and the joint forces of a motion. */
typedef struct account {
    double tau[LOOPS_MOST], potential, power, own_energy, own_power, load[2][12];
} account;

static void take(loops *s, const double *q, const double *u, const double *udot, account *x)
{
    const mbsr_error *error = mbsr_data_error(s->d);
    memset(x, 0, sizeof *x);
    assert_ok(mbsr_inverse_dynamics(s->m, s->d, 0.3, q, u, udot, NULL, x->tau), error);
    at(s, q, u);
    assert_ok(mbsr_energy(s->m, s->d, NULL, &x->potential), error);
    assert_ok(mbsr_dissipation(s->m, s->d, &x->power), error);
    assert_ok(mbsr_force_power(s->m, s->d, 1, &x->own_energy, &x->own_power), error);
    assert_ok(mbsr_force_load(s->m, s->d, 1, 0, x->load[0], x->load[0] + 6), error);
}

static void compare(bool flat, element make)
{
    test_rng rng = test_seed(5);
    loops force, closure;
    build(&force, flat, make, 0);
    build(&closure, flat, make, MBSR_SPRING_LOOSE);
    assert_int_equal(mbsr_model_forces(closure.m), 2);
    assert_int_equal(mbsr_force_closure(force.m, 1), MBSR_NONE);
    assert_int_equal(mbsr_force_closure(closure.m, 0), MBSR_NONE);
    assert_int_equal(mbsr_force_closure(closure.m, 1), 0);
    assert_int_equal(mbsr_model_closures(closure.m), 1);
    assert_string_equal(mbsr_closure_name(closure.m, 0), "spring");
    assert_true(closure.rows > 0 && closure.rows == closure.position_rows);
    for (int trial = 0; trial < 5; ++trial) {
        double q[LOOPS_MOST], u[LOOPS_MOST], udot[LOOPS_MOST];
        account x, y;
        mbsr_closure_errors errors;
        random_state(&force, &rng, q, u, udot);
        take(&force, q, u, udot, &x);
        take(&closure, q, u, udot, &y);
        assert_true(x.own_energy > 0.0);
        const double *a = (const double *)&x, *b = (const double *)&y,
                     scale = 1.0 + test_largest(sizeof x / sizeof *a, a);
        for (size_t k = 0; k < sizeof x / sizeof *a; ++k) assert_close(b[k], a[k], 1e-13 * scale);
        assert_ok(mbsr_closure_verify(closure.m, closure.d, 0, &errors), NULL);
        assert_less(errors.jacobian, 1e-9);
        assert_less(errors.bias, 1e-7);
    }
    loops_free(&force);
    loops_free(&closure);
}

static void same_forces(void **state)
{
    (void)state;
    const element in_space[] = {line, rubber_band, tight_line, joint, gear, bushing, hinge},
                  in_plane[] = {line, rubber_band,  tight_line,   joint, gear,
                                axis, turning_axis, full_bushing, strut};
    for (size_t k = 0; k < sizeof in_space / sizeof *in_space; ++k) compare(false, in_space[k]);
    for (size_t k = 0; k < sizeof in_plane / sizeof *in_plane; ++k) compare(true, in_plane[k]);
}

/* One stiffness for each entry of the frame. */
static mbsr_force_def straight_bushing(void)
{
    const double K[9] = {50.0, 0.0, 0.0, 0.0, 80.0, 0.0, 0.0, 0.0, 9.0}, D[9] = {0.0};
    return planar_bushing(K, D);
}

static void expect_names(bool flat, element make, int count, const char *const *names)
{
    loops s;
    build(&s, flat, make, MBSR_SPRING_LOOSE);
    assert_int_equal(mbsr_model_rows(s.m), count);
    unsigned seen = 0; /* they are in any order */
    for (int row = 0; row < count; ++row) {
        const char *name;
        int k = 0;
        assert_int_equal(mbsr_closure_of_row(s.m, row, NULL, NULL, &name), MBSR_OK);
        while (k < count && strcmp(name, names[k]) != 0) ++k;
        if (k == count) fail_msg("row %d has the name '%s'", row, name);
        seen |= 1u << k;
    }
    assert_int_equal(seen, (1u << count) - 1);
    loops_free(&s);
}

/* As messages name them. */
static void rows_have_names(void **state)
{
    static const char *const of_hinge[] = {"turn about x", "turn about z", "x"},
                             *const straight[] = {"x", "y", "turn"}, *const mixed[] = {"mostly x"},
                             *const one[] = {"axis"};
    (void)state;
    expect_names(false, hinge, 3, of_hinge);
    expect_names(true, axis, 1, one);
    expect_names(true, straight_bushing, 3, straight);
    expect_names(true, strut, 1, mixed); /* along (2, 1) */
}

/* Angular damping acts on theta', as the power says and the moment with it; on small turns it is
 * that of the element. */
static mbsr_force_def damped_turns(void)
{
    const double K[6] = {20.0, 30.0, 10.0, 0.0, 0.0, 0.0}, D[6] = {4.0, 1.0, 2.0, 0.0, 0.0, 0.0};
    return mbsr_force_bushing(MBSR_GROUND, NULL, B, NULL, K, D);
}

static void angular_damping(void **state)
{
    (void)state;
    test_rng rng = test_seed(6);
    loops force, closure;
    build(&force, false, damped_turns, 0);
    build(&closure, false, damped_turns, MBSR_SPRING_LOOSE);
    double last = 0.0;
    for (int small = 0; small < 3; ++small) {
        const double size = small == 0 ? 1e-1 : small == 1 ? 1e-3 : 1e-5;
        double q[LOOPS_MOST], u[LOOPS_MOST], udot[LOOPS_MOST], worst = 0.0;
        account x, y;
        random_state(&force, &rng, q, u, udot);
        for (int k = 0; k < force.nq; ++k) q[k] *= size;
        q[2] = 1.0; /* of the quaternion of B, behind the two angles of A */
        take(&force, q, u, udot, &x);
        take(&closure, q, u, udot, &y);
        for (int k = 0; k < force.nu; ++k) worst = fmax(worst, fabs(x.tau[k] - y.tau[k]));
        assert_less(worst, 60.0 * size);
        assert_close(x.power, y.power, 60.0 * size);
        assert_true(small == 0 || worst < 0.1 * last);
        last = worst;
    }
    loops_free(&force);
    loops_free(&closure);
}

/* ---- refusals ---- */

static void refuse(bool flat, mbsr_force_def def, const char *words)
{
    loops s;
    tree(&s, flat);
    def.name = "spring";
    if (def.as_closure == 0) def.as_closure = MBSR_SPRING_SETTLED;
    assert_refused(mbsr_model_add_force(s.m, &def, NULL), mbsr_model_error(s.m), MBSR_ERR_VALUE,
                   MBSR_NONE, 1, words);
    loops_finish(&s);
    assert_int_equal(mbsr_model_forces(s.m), 1);
    assert_int_equal(mbsr_model_closures(s.m), 0);
    loops_free(&s);
}

static int law(void *user, double x, double v, double *force, double *energy, double *power)
{
    (void)user, (void)v, (void)energy, (void)power;
    *force = x;
    return 0;
}

static void refused(void **state)
{
    (void)state;
    const mbsr_spring cubic = {.stiffness = 1.0, .cubic = 2.0},
                      cable = {.stiffness = 1.0, .one_sided = 1}, function = {.function = law};
    const mbsr_gear play = {.ratio = 1.0, .stiffness = 1.0, .backlash = 0.1};
    const double K[6] = {1.0, 0.0, 0.0, 0.0, 0.0, 0.0}, D[6] = {0.0, 0.0, 0.0, 0.0, 5.0, 0.0},
                 plane[9] = {1.0}, across[9] = {0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0};
    refuse(true, mbsr_force_spring(B, p, C, r, &cubic), "force 1 'spring'|cubic");
    refuse(true, mbsr_force_spring(B, p, C, r, &cable), "one-sided");
    refuse(true, mbsr_force_spring(B, p, C, r, &function), "function");
    refuse(true, mbsr_force_gear(A, 0, C, 0, &play), "backlash");
    refuse(true, mbsr_force_joint_cubic_spring(C, 0, 1.0, 1.0, 0.0, 0.0), "cubic");
    refuse(true, mbsr_force_joint_spring(C, 0, 0.0, 0.0, 0.0), "no stiffness");
    refuse(true, mbsr_force_joint_spring(C, 0, 0.0, 1.0, 0.0), "damping[0] is 1");
    refuse(true, mbsr_force_joint_friction(C, 0, 1.0, 1.0), "no spring");
    refuse(true,
           mbsr_force_planar_bushing(B, (mbsr_planar_frame){0}, C, (mbsr_planar_frame){0}, plane,
                                     across),
           "damping acts where");
    static const double nothing[9] = {0.0},
                        pushes[9] = {1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0};
    refuse(true, planar_bushing(nothing, nothing), "no stiffness");
    refuse(true, planar_bushing(pushes, nothing), "not positive semi-definite");
    refuse(false, mbsr_force_bushing(B, NULL, C, NULL, K, D), "damping[4] is 5");
    mbsr_force_def other = joint();
    other.as_closure = 3;
    refuse(true, other, "as_closure is 3");
}

/* What its bodies refuse shows when the model is finished, which can be tried again. */
static void refused_by_bodies(void **state)
{
    (void)state;
    loops s;
    tree(&s, true);
    mbsr_force_def def = mbsr_force_joint_spring(7, 0, 1.0, 0.0, 0.0);
    def.as_closure = MBSR_SPRING_SETTLED;
    mbsr_force_def good = joint();
    good.as_closure = MBSR_SPRING_SETTLED;
    assert_ok(mbsr_model_add_force(s.m, &good, NULL), NULL);
    assert_ok(mbsr_model_add_force(s.m, &def, NULL), NULL);
    for (int k = 0; k < 2; ++k)
        assert_refused(mbsr_model_finish(s.m), mbsr_model_error(s.m), MBSR_ERR_ID, MBSR_NONE, 2,
                       "force 2|body 7");
    for (int k = BODIES; k <= 7; ++k) loops_rod(&s, "more", A, 0.0, 0.0, 1.0, 1.0);
    mbsr_closure_def pin = mbsr_closure_ball(C, NULL, C, NULL);
    pin.name = "pin";
    assert_ok(mbsr_model_add_closure(s.m, &pin, NULL), NULL);
    for (int k = 0; k < 2; ++k)
        assert_refused(mbsr_model_finish(s.m), mbsr_model_error(s.m), MBSR_ERR_ID, MBSR_NONE,
                       MBSR_NONE, "closure 0 'pin'");
    loops_free(&s);
    build(&s, true, joint, MBSR_SPRING_SETTLED);
    assert_refused(mbsr_force_switch(s.m, s.d, 1, 0), mbsr_data_error(s.d), MBSR_ERR_VALUE,
                   MBSR_NONE, 1, "force 1 is closure 0");
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_forces),       cmocka_unit_test(rows_have_names),
        cmocka_unit_test(angular_damping),   cmocka_unit_test(refused),
        cmocka_unit_test(refused_by_bodies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Four-bar linkages with a diagonal spring and damper: rest, and the eigenvalues there, against
 * their equations in one angle and a published position.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Uniform rods: crank 0.8 m, 1 kg; coupler 1 m, 1.5 kg; follower 0.9 m, 2 kg; ground 1.2 m. The
 * spring goes from the crank's bearing to the joint of coupler and follower: 60 N/m, 2 N s/m, 1 m
 * long without force. The digits are those of T = M(angle) angle'^2 / 2 and V(angle), derived with
 * fifty digits from the geometry of two circles: V' = 0, M s^2 + d s + V'' = 0.
 *
 * The benchmark "Fourbar linkage with diagonal spring" of the IFToMM library: rods of 1 m and 1 kg,
 * 25 N/m, 1 N s/m, sqrt(2) m. It is a parallelogram, M = 5/3 kg m^2, d = c sin^2(angle / 2),
 * V = 2 m g sin(angle) + k (2 cos(angle / 2) - sqrt(2))^2 / 2. The published position at rest,
 * 2.23433101898, stands in the input of B. Minaker's solution (EoM, input_ex_four_bar.m). */
#include "build.h"

#include <mbsrank/linear.h>

#include <math.h>

enum { RATES = 3 };

static const double weight = 9.81;

/* Angles of crank, coupler against it, follower; s is real at the unstable one. */
typedef struct rest {
    double guess[RATES], crank, coupler, follower, real, imaginary, other;
} rest;

/* Lengths (m), masses (kg), spring. */
typedef struct linkage {
    double length[RATES], ground, mass[RATES], stiffness, damping, free;
} linkage;

static const linkage uneven = {{0.8, 1.0, 0.9}, 1.2, {1.0, 1.5, 2.0}, 60.0, 2.0, 1.0},
                     benchmark = {{1.0, 1.0, 1.0},      1.0, {1.0, 1.0, 1.0}, 25.0, 1.0,
                                  1.4142135623730950488};

static const double published = 2.23433101898;

static const rest stable = {{1.5, -1.2, 1.9},      2.3369537194255375581,  -0.09297134985431868121,
                            2.5742853533867629887, -0.5071272800189185209, 4.8891783506866334597,
                            -0.5071272800189185209},
                  unstable = {{0.6, -0.3, 1.1},      0.66363431667610102759, 0.33094081278302722415,
                              1.1398666892378350908, 6.5491553826500252655,  0.0,
                              -6.6699967846840237791},
                  even = {{2.0, -2.0, 2.0},       2.2343310190175859114,   0.0,
                          2.2343310190175859114,  -0.24238580931050509653, 2.1339550283483802956,
                          -0.24238580931050509653};

static mbsr_joint hinge(double x)
{
    return mbsr_joint_planar_revolute((mbsr_planar_frame){.x = x}, (mbsr_planar_frame){0});
}

static mbsr_inertia rod(double mass, double length)
{
    const double middle[2] = {0.5 * length, 0.0};
    return mbsr_inertia_planar(mass, middle, mass * length * length / 12.0);
}

static mbsr_model *make(const linkage *l, mbsr_data **d)
{
    const double end[3] = {l->length[1], 0, 0}, tip[3] = {l->length[2], 0, 0};
    mbsr_model *m = empty();
    add_body(m, MBSR_GROUND, "crank", hinge(0.0), rod(l->mass[0], l->length[0]));
    add_body(m, 0, "coupler", hinge(l->length[0]), rod(l->mass[1], l->length[1]));
    add_body(m, MBSR_GROUND, "follower", hinge(l->ground), rod(l->mass[2], l->length[2]));
    add_force(
        m, mbsr_force_point_spring(MBSR_GROUND, NULL, 2, tip, l->stiffness, l->damping, l->free));
    add_force(m, mbsr_force_gravity(0, -weight, 0));
    const mbsr_closure_def pin = mbsr_closure_ball(1, end, 2, tip);
    assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
    *d = finish(m);
    return m;
}

static void compare(const mbsr_model *m, mbsr_data *d, const double *q, const rest *r)
{
    mbsr_linear *l;
    mbsr_error error;
    mbsr_mode mode[2];
    int modes;
    assert_close(q[0], r->crank, 1e-11);
    assert_close(q[0] + q[1], r->coupler, 1e-11);
    assert_close(q[2], r->follower, 1e-11);
    assert_ok(mbsr_linear_create(m, d, 0.0, q, NULL, NULL, &l, &error), &error);
    assert_ok(mbsr_linear_modes(l, mode, &modes), NULL);
    assert_int_equal(modes, r->imaginary > 0.0 ? 1 : 2);
    assert_close(mode[0].real, r->real, 1e-10);
    assert_close(mode[0].imaginary, r->imaginary, 1e-10);
    assert_close(mode[modes - 1].real, r->other, 1e-10);
    mbsr_linear_destroy(l);
}

static void it_comes_to_rest(void **state)
{
    (void)state;
    mbsr_data *d;
    mbsr_model *m = make(&uneven, &d);
    mbsr_error error;
    double q[RATES];
    assert_ok(mbsr_equilibrium(m, d, 0.0, stable.guess, NULL, q, NULL, NULL, &error), &error);
    compare(m, d, q, &stable);
    free_both(m, d);
}

static void it_balances(void **state)
{
    (void)state;
    mbsr_data *d;
    mbsr_model *m = make(&uneven, &d);
    mbsr_parameters *list;
    mbsr_trim_info info;
    mbsr_error error;
    double q[RATES], none;
    assert_ok(mbsr_parameters_create(m, &list, &error), &error);
    assert_ok(mbsr_trim(list, 0.0, unstable.guess, 0, NULL, NULL, q, &none, &info, &error), &error);
    compare(m, d, q, &unstable);
    assert_close(info.growth, unstable.real, 1e-9);
    mbsr_parameters_destroy(list);
    free_both(m, d);
}

static void it_is_the_benchmark(void **state)
{
    (void)state;
    mbsr_data *d;
    mbsr_model *m = make(&benchmark, &d);
    mbsr_error error;
    double q[RATES];
    assert_ok(mbsr_equilibrium(m, d, 0.0, even.guess, NULL, q, NULL, NULL, &error), &error);
    compare(m, d, q, &even);
    assert_close(q[2], published, 1e-10);
    free_both(m, d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(it_comes_to_rest),
                                       cmocka_unit_test(it_balances),
                                       cmocka_unit_test(it_is_the_benchmark)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

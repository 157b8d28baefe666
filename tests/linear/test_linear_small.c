/* One body that flies and is welded to what hangs on the ground by its joint, anywhere and in four
 * systems of units: as many finite eigenvalues as on paper, and these.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "build.h"
#include "units.h"

#include <mbsrank/linear.h>

#include <math.h>
#include <stdbool.h>

enum { SEEDS = 20 };

static mbsr_frame some_frame(test_rng *rng, const units *of)
{
    double x[3], quaternion[4];
    test_fill(rng, 3, x);
    test_fill(rng, 4, quaternion);
    for (int k = 0; k < 3; ++k) x[k] *= of->length;
    return mbsr_frame_quaternion(x, quaternion);
}

/* The frame of the body that flies is that of the ground. */
static mbsr_model *flying(mbsr_inertia inertia, const mbsr_joint *joint, const mbsr_frame *at)
{
    mbsr_model *m = empty();
    add_body(m, MBSR_GROUND, "body", mbsr_joint_free(NULL, NULL), inertia);
    assert_ok(mbsr_model_add_loop_joint(m, "loop", MBSR_GROUND, joint, 0, at, NULL, NULL),
              mbsr_model_error(m));
    return m;
}

/* Modes found, in 1/s, with and, unless `stiff` rows are there, without matrices; true: as many as
 * wanted. */
static bool ask(mbsr_model *m, const units *of, bool stiff, int states, int count,
                mbsr_mode mode[2][8])
{
    double q[16] = {1.0};
    mbsr_linear *l;
    mbsr_linear_info info;
    int found[2] = {count, count};
    mbsr_data *d = finish(m);
    int status = mbsr_linear_create(m, d, 0.0, q, NULL, NULL, &l, NULL);
    if (!status) {
        assert_ok(mbsr_linear_get_info(l, &info), NULL);
        assert_ok(mbsr_linear_modes(l, NULL, found), NULL);
        if (found[0] <= 8) assert_ok(mbsr_linear_modes(l, mode[0], found), NULL);
        mbsr_linear_destroy(l);
    }
    mbsr_near_opt opt = mbsr_default_near_opt();
    opt.count = 8;
    memcpy(mode[1], mode[0], 8 * sizeof mode[0][0]);
    if (!status && !stiff)
        status = mbsr_modes_near(m, d, 0.0, q, &opt, mode[1], found + 1, NULL, NULL, NULL);
    for (int k = 0; k < 16 && !status; ++k) {
        mode[k / 8][k % 8].real *= of->time;
        mode[k / 8][k % 8].imaginary *= of->time;
    }
    free_both(m, d);
    return !status && info.states == states &&
           (count < 0 || (found[0] == count && found[1] == count));
}

/* A hinge with a spring and a damper: J s^2 + d s + k = 0. */
static void hinges_on_springs(void **state)
{
    (void)state;
    static const double z[3] = {0.0, 0.0, 1.0}, tensor[6] = {0.3, 0.2, 0.4};
    int wrong = 0;
    for (int seed = 0; seed < SEEDS; ++seed) {
        const units *of = systems + seed % 4;
        test_rng rng = test_seed((uint64_t)seed);
        const double L = of->length, T = of->time, inertia = of->mass * L * L, k = 3.0, d = 0.2;
        const mbsr_frame at = some_frame(&rng, of);
        double com[3], own[6] = {0.0}, arm = 0.0, J = 0.0;
        test_fill(&rng, 3, com);
        for (int i = 0; i < 3; ++i) {
            arm += at.R[6 + i] * (com[i] - at.x[i] / L);
            own[i] = tensor[i] * inertia;
            J += tensor[i] * at.R[6 + i] * at.R[6 + i];
        }
        for (int i = 0; i < 3; ++i) {
            const double side = com[i] - at.x[i] / L - arm * at.R[6 + i];
            J += 2.0 * side * side;
            com[i] *= L;
        }
        const mbsr_joint hinge = mbsr_joint_revolute(&at, NULL, z);
        mbsr_model *m = flying(mbsr_inertia_rigid(2.0 * of->mass, com, own), &hinge, &at);
        mbsr_force_def spring =
            mbsr_force_joint_spring(1, 0, k * inertia / (T * T), d * inertia / T, 0.0);
        if (seed % 8 > 3) spring.as_closure = MBSR_SPRING_LOOSE;
        add_force(m, spring);
        mbsr_mode mode[2][8];
        bool right = ask(m, of, seed % 8 > 3, 2, 1, mode);
        for (int i = 0; i < 2 && right; ++i)
            right = fabs(mode[i][0].real + 0.5 * d / J) < 1e-7 &&
                    fabs(mode[i][0].imaginary - sqrt(k / J - 0.25 * d * d / (J * J))) < 1e-7;
        wrong += !right;
    }
    assert_int_equal(wrong, 0);
}

/* Two slides and a hinge, one slide on a spring: the body turns about its mass, which moves along
 * the other freely, and across as far as the hinge may turn. */
static void masses_that_are_free(void **state)
{
    (void)state;
    int wrong = 0;
    for (int seed = 0; seed < SEEDS; ++seed) {
        const units *of = systems + seed % 4;
        test_rng rng = test_seed((uint64_t)seed);
        mbsr_axis axes[3] = {{.kind = MBSR_AXIS_TRANSLATION, .direction = {0.0, 0.0, 1.0}},
                             {.kind = MBSR_AXIS_TRANSLATION, .direction = {1.0, 0.0, 0.0}},
                             {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 1.0, 0.0}}};
        const mbsr_frame at = some_frame(&rng, of);
        double place[3];
        test_fill(&rng, 3, place);
        for (int i = 0; i < 3; ++i) place[i] *= of->length;
        const mbsr_joint joint = mbsr_joint_compound(&at, NULL, 3, axes, NULL, NULL);
        mbsr_model *m = flying(mbsr_inertia_point_mass(of->mass, place), &joint, &at);
        add_force(m,
                  mbsr_force_joint_spring(1, 0, 5.0 * of->mass / (of->time * of->time), 0.0, 0.0));
        mbsr_mode mode[2][8];
        bool right = ask(m, of, false, 4, -1, mode);
        for (int i = 0; i < 2 && right; ++i)
            right = hypot(mode[i][0].real, mode[i][0].imaginary) < 1e-5;
        wrong += !right;
    }
    assert_int_equal(wrong, 0);
}

/* Two hinges about different axes, a spring in one. */
static void bodies_that_cannot_move(void **state)
{
    (void)state;
    static const double x[3] = {1.0, 0.0, 0.0}, tensor[6] = {0.3, 0.2, 0.4};
    int wrong = 0;
    for (int seed = 0; seed < SEEDS; ++seed) {
        const units *of = systems + seed % 4;
        test_rng rng = test_seed((uint64_t)seed);
        const double inertia = of->mass * of->length * of->length;
        const mbsr_frame at = some_frame(&rng, of), there = some_frame(&rng, of);
        double own[6];
        for (int i = 0; i < 6; ++i) own[i] = tensor[i] * inertia;
        const mbsr_joint hinge = mbsr_joint_revolute(&at, NULL, x),
                         other = mbsr_joint_revolute(&there, NULL, x);
        mbsr_model *m = flying(mbsr_inertia_rigid(2.0 * of->mass, NULL, own), &hinge, &at);
        assert_ok(mbsr_model_add_loop_joint(m, "other", MBSR_GROUND, &other, 0, &there, NULL, NULL),
                  mbsr_model_error(m));
        add_force(m,
                  mbsr_force_joint_spring(1, 0, 6.0 * inertia / (of->time * of->time), 0.0, 0.0));
        mbsr_mode mode[2][8];
        wrong += !ask(m, of, false, 0, 0, mode);
    }
    assert_int_equal(wrong, 0);
}

/* A rod that turns about its own axis, which has some moment by rounding alone: d s + k = 0. */
static void rods_about_their_axes(void **state)
{
    (void)state;
    static const double y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0};
    int wrong = 0;
    for (int turns = 0; turns < 16; ++turns) {
        const units *of = systems + turns % 4;
        const double L = of->length, T = of->time, inertia = of->mass * L * L, k = 4.0, d = 1.5,
                     end[3] = {0.0, 0.0, 0.5 * L};
        const mbsr_frame about = mbsr_frame_rotated(NULL, y, 2.0 * atan(1.0));
        mbsr_frame at = mbsr_frame_at(-L, L, 0.5 * L);
        double q[1] = {0.0};
        mbsr_linear *l;
        mbsr_mode mode[2];
        int found;
        for (int i = 0; i < 1 + turns / 4; ++i) at = mbsr_frame_product(&at, &about);
        mbsr_model *m = empty();
        add_body(m, MBSR_GROUND, "rod", mbsr_joint_revolute(&at, NULL, z),
                 mbsr_inertia_rod(of->mass, NULL, end));
        add_force(m, mbsr_force_joint_spring(0, 0, k * inertia / (T * T), d * inertia / T, 0.0));
        mbsr_data *data = finish(m);
        assert_ok(mbsr_linear_create(m, data, 0.0, q, NULL, NULL, &l, NULL), NULL);
        assert_ok(mbsr_linear_modes(l, NULL, &found), NULL);
        assert_int_equal(found, 1);
        assert_ok(mbsr_linear_modes(l, mode, &found), NULL);
        wrong += !(fabs(mode[0].real * T + k / d) < 1e-9);
        mbsr_linear_destroy(l);
        free_both(m, data);
    }
    assert_int_equal(wrong, 0);
}

/* A mass on a spring of 1e12 N/m and a row of masses on it by soft ones, as on a wall: n of these
 * swing at 2 sqrt(k / m) sin((2 i - 1) / (2 n + 1) pi / 2). */
static void soft_beside_stiff(void **state)
{
    (void)state;
    enum { SOFT = 6 };
    static const double x[3] = {1.0, 0.0, 0.0};
    const double k = 3.0, m = 2.0, stiff = 1e12, right = 2.0 * atan(1.0);
    for (size_t i = 0; i < 4; ++i) {
        const units *of = systems + i;
        const double unit = of->mass / (of->time * of->time);
        double q[SOFT + 1] = {0.0};
        mbsr_linear *l;
        mbsr_mode mode[2 * SOFT + 2];
        mbsr_error error;
        int found;
        mbsr_model *model = empty();
        for (int body = 0; body <= SOFT; ++body) {
            add_body(model, body - 1, NULL, mbsr_joint_prismatic(NULL, NULL, x),
                     mbsr_inertia_particle((body ? m : 1.0) * of->mass));
            add_force(model, mbsr_force_joint_spring(body, 0, (body ? k : stiff) * unit, 0.0, 0.0));
        }
        mbsr_data *data = finish(model);
        assert_ok(mbsr_linear_create(model, data, 0.0, q, NULL, NULL, &l, &error), &error);
        assert_ok(mbsr_linear_modes(l, NULL, &found), NULL);
        assert_int_equal(found, SOFT + 1);
        assert_ok(mbsr_linear_modes(l, mode, &found), NULL);
        for (int j = 1; j <= SOFT; ++j) {
            const double rate = 2.0 * sqrt(k / m) * sin((2.0 * j - 1.0) / (2 * SOFT + 1) * right);
            assert_close(mode[j - 1].imaginary * of->time, rate, 1e-8);
        }
        assert_close(mode[SOFT].imaginary * of->time, sqrt(stiff), 1e-4 * sqrt(stiff));
        mbsr_linear_destroy(l);
        free_both(model, data);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hinges_on_springs), cmocka_unit_test(masses_that_are_free),
        cmocka_unit_test(bodies_that_cannot_move), cmocka_unit_test(rods_about_their_axes),
        cmocka_unit_test(soft_beside_stiff)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Runs of beams with geometric stiffening: a spin-up and a falling pendulum against the elastica
 * (its tangent angle as a series, independent of any floating frame), the same modes in another
 * program, and chains of rigid links.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "flexible.h"

#include <mbsrank/simulation.h>

#include <stdbool.h>
#include <string.h>

enum { MOST = 48 };

static void check(const mbsr_simulation *s, int status)
{
    assert_ok(status, &s->error);
}

static mbsr_simulation start(mbsr_model *m, const double *q, double tolerance)
{
    static const double rest[MOST] = {0.0};
    mbsr_simulation s = mbsr_simulation_of(m);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    check(&s, mbsr_simulation_start(&s, &opt, 0.0, q ? q : rest, rest));
    return s;
}

static void place_of(mbsr_simulation *s, int body, double t, double x[3])
{
    double pose[MBSR_POSE_SIZE];
    check(s, mbsr_simulation_to(s, t));
    assert_ok(mbsr_body_pose(s->model, s->data, body, pose), mbsr_data_error(s->data));
    memcpy(x, pose + MBSR_POSE_X, 3 * sizeof *x);
}

/* ---- spin-up ---- */

/* Simo and Vu-Quoc's: 6 rad/s after 15 s. */
static int turn(void *user, double t, double *s, double *sdot, double *sddot)
{
    const double omega = 6.0, T = 15.0, k = 2.0 * 3.14159265358979323846 / T;
    const bool up = t < T;
    (void)user;
    *s = up ? omega / T * (0.5 * t * t + (cos(k * t) - 1.0) / (k * k)) : omega * (t - 0.5 * T);
    *sdot = up ? omega / T * (t - sin(k * t) / k) : omega;
    *sddot = up ? omega / T * (1.0 - cos(k * t)) : 0.0;
    return MBSR_OK;
}

enum { TIMES = 8, STEPS = 400 };

typedef struct spin {
    double at[TIMES], lowest, after; /* deflections of the tip; after: largest one from 15 s on */
    long steps;
} spin;

/* The beam on a turning hub; `tip`: its marker at the end. */
static spin spin_up(const mbsr_flex *flex, int tip, double tolerance)
{
    static const double times[TIMES] = {2.5, 5.0, 6.5, 7.5, 10.0, 12.5, 15.0, 20.0};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1};
    mbsr_flexible_def def = mbsr_default_flexible_def();
    mbsr_model *m;
    int body, end, next = 0;
    spin result = {.lowest = 0.0};
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    def.flex = flex, def.joint = mbsr_joint_compound(NULL, NULL, 1, &axis, turn, NULL);
    assert_ok(mbsr_model_add_flexible(m, &def, &body), mbsr_model_error(m));
    assert_ok(mbsr_model_add_marker(m, body, tip, NULL, &end), mbsr_model_error(m));
    mbsr_simulation s = start(m, NULL, tolerance);
    for (int k = 1; k <= STEPS; ++k) {
        const double t = 20.0 * k / STEPS;
        double x[3], angle, rate, second;
        place_of(&s, end, t, x);
        turn(NULL, t, &angle, &rate, &second);
        const double v = cos(angle) * x[1] - sin(angle) * x[0];
        result.lowest = fmin(result.lowest, v);
        if (t > 15.0) result.after = fmax(result.after, fabs(v));
        if (next < TIMES && t == times[next]) result.at[next++] = v;
    }
    assert_int_equal(next, TIMES);
    mbsr_ida_stats stats;
    mbsr_simulation_get_stats(&s, &stats);
    result.steps = stats.steps;
    mbsr_simulation_end(&s);
    return result;
}

static const double elastica[TIMES] = {-0.151274, -0.468436, -0.569876, -0.558985,
                                       -0.362672, -0.112644, 0.001275,  0.000768};

static double distance(const spin *s)
{
    double largest = 0.0;
    for (int k = 0; k < TIMES; ++k) largest = fmax(largest, fabs(s->at[k] - elastica[k]));
    return largest;
}

/* Polynomial modes: lowest deflections as another program has them. */
static void a_beam_is_spun_up(void **state)
{
    (void)state;
    static const double lowest[4] = {-0.38846, -0.57252, -0.57581, -0.57583},
                        off[4] = {0.185, 0.0114, 0.0022, 0.0022};
    for (int n = 1; n <= test_seeds(3, 4); ++n) {
        test_ritz beam = test_ritz_bending(n, 10.0, 1.4e4, 1.2);
        beam.stiffening = 1;
        mbsr_flex *flex = test_ritz_make(&beam);
        const spin s = spin_up(flex, 1, 1e-7);
        print_message("%d modes: lowest %.5f, off by %.4f, %ld steps\n", n, s.lowest, distance(&s),
                      s.steps);
        assert_close(s.lowest, lowest[n - 1], 6e-6);
        assert_less(distance(&s), off[n - 1]);
        if (n > 2) assert_close(s.after, 3.63e-3, 3e-4);
        mbsr_flex_destroy(flex);
    }
}

/* Normal modes of finite elements. The elastica's tip is 0.5737437 back at most; the rest is what
 * the field of second order leaves out. */
static void a_built_in_beam_is_spun_up(void **state)
{
    (void)state;
    for (int n = 2; n <= test_seeds(3, 4); ++n) {
        mbsr_beam_def def = mbsr_default_beam_def();
        mbsr_flex *flex;
        mbsr_error error;
        def.length = 10.0, def.density = 1.2, def.EI_z = 1.4e4;
        def.modes = n, def.stiffening = 1;
        assert_ok(mbsr_flex_beam(&def, &flex, &error), &error);
        mbsr_flex_def data;
        mbsr_flex_definition(flex, &data);
        const spin s = spin_up(flex, def.elements, 1e-6);
        print_message("%d normal modes, %d dependent shapes: lowest %.5f, off by %.4f, %ld steps\n",
                      n, data.dependent, s.lowest, distance(&s), s.steps);
        assert_int_equal(data.dependent, n * (n + 1) / 2);
        assert_less(distance(&s), 0.0022);
        assert_close(s.lowest, -0.5737437, 0.004 * 0.5737437);
        assert_close(s.after, 3.63e-3, 3e-4);
        mbsr_flex_destroy(flex);
    }
}

/* ---- a pendulum that falls ---- */

static const double fall[3] = {0.25, 0.5, 1.0};

static void a_pendulum_falls_and_stiffens(void **state)
{
    (void)state;
    static const double expected[3][6] = {
        {-0.4565492795, -0.0001155668, 0.0000046333, -3.55774519, 0.897530188, -0.440953011},
        {-1.6600990643, -0.0016196185, 0.0003265420, -5.35555482, -0.090471917, -0.995898791},
        {-3.1315890034, -0.0028597524, 0.0005177266, 0.53792519, -0.999969920, -0.007661540}};
    test_flexible w;
    double x[3];
    test_flexible_pendulum(&w, 100.0, 1);
    const int tip = w.tip;
    mbsr_simulation s = start(w.model, NULL, 1e-12);
    w.model = NULL;
    for (int k = 0; k < 3; ++k) {
        place_of(&s, tip, fall[k], x);
        for (int l = 0; l < 3; ++l) assert_close(s.q[l], expected[k][l], 2e-8);
        assert_close(s.u[0], expected[k][3], 1e-5);
        for (int l = 0; l < 2; ++l) assert_close(x[l], expected[k][4 + l], 2e-8);
    }
    mbsr_simulation_end(&s);
    test_flexible_free(&w);
}

/* Tip of `links` rigid ones with springs between, EI = 20. */
static void fall_in_links(int links, double tolerance, double tip[3][2])
{
    const double length = 1.0 / links, mass = 1.0 / links;
    const mbsr_planar_frame pin = {0.0, 0.0, 0.0}, end = {length, 0.0, 0.0};
    mbsr_model *m;
    mbsr_body_def def = mbsr_default_body_def();
    mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < links; ++k) {
        def.joint = mbsr_joint_planar_revolute(k > 0 ? end : pin, pin);
        def.inertia = mbsr_inertia_planar(mass, (double[2]){0.5 * length, 0.0},
                                          mass * length * length / 12.0);
        assert_ok(mbsr_model_add_body(m, &def, &def.parent), mbsr_model_error(m));
        mbsr_force_def spring = mbsr_force_joint_spring(def.parent, 0, 20.0 * links, 0.0, 0.0);
        if (k > 0) assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    mbsr_simulation s = start(m, NULL, tolerance);
    for (int k = 0; k < 3; ++k) {
        double p[3];
        check(&s, mbsr_simulation_to(&s, fall[k]));
        assert_ok(mbsr_body_pose(s.model, s.data, links - 1, p), mbsr_data_error(s.data));
        tip[k][0] = p[0] + length * cos(p[2]);
        tip[k][1] = p[1] + length * sin(p[2]);
    }
    mbsr_ida_stats stats;
    mbsr_simulation_get_stats(&s, &stats);
    print_message("%d links: %ld steps\n", links, stats.steps);
    mbsr_simulation_end(&s);
}

static void a_pendulum_falls_as_a_chain_of_links_does(void **state)
{
    (void)state;
    static const double in_five[3][2] = {{0.898110496, -0.439758336},
                                         {-0.088763814, -0.996047711},
                                         {-0.999962743, -0.005390389}},
                        in_ten[3][2] = {{0.898123011, -0.439732858},
                                        {-0.088724545, -0.996051167},
                                        {-0.999963250, -0.005417592}},
                        in_twenty[3][2] = {{0.898124929, -0.439728970},
                                           {-0.088721845, -0.996051422},
                                           {-0.999963354, -0.005424595}};
    static const double elastic[3][2] = {
        {0.898125461, -0.439727895}, {-0.088718111, -0.996051749}, {-0.999963387, -0.005427232}};
    double tip[3][2], x[3];
    fall_in_links(5, 1e-7, tip);
    for (int k = 0; k < 6; ++k) assert_close(tip[k / 2][k % 2], in_five[k / 2][k % 2], 1e-6);
    const int links_of = test_seeds(10, 20);
    fall_in_links(links_of, 1e-7, tip);
    for (int k = 0; k < 6; ++k)
        assert_close(tip[k / 2][k % 2], (links_of == 10 ? in_ten : in_twenty)[k / 2][k % 2], 2e-6);
    static const double linear[4] = {2.6e-3, 2.7e-3, 4.3e-4, 1.2e-3},
                        stiffening[4] = {7.7e-4, 2.6e-3, 6.2e-4, 7.3e-5};
    for (int k = test_seeds(7, 0); k < 8; ++k) {
        const int n = k % 4 + 1;
        test_flexible w;
        test_ritz beam = test_ritz_bending(n, 1.0, 20.0, 1.0);
        beam.stiffening = k >= 4;
        test_flexible_swing(&w, &beam);
        const int end = w.tip;
        mbsr_simulation s = start(w.model, NULL, 1e-7);
        w.model = NULL;
        double off = 0.0, links = 0.0;
        for (int l = 0; l < 3; ++l) {
            place_of(&s, end, fall[l], x);
            off = fmax(off, hypot(x[0] - elastic[l][0], x[1] - elastic[l][1]));
            links = fmax(links, hypot(x[0] - tip[l][0], x[1] - tip[l][1]));
        }
        print_message("%d modes, %s: %.2e from the elastica, %.2e from links\n", n,
                      k < 4 ? "linear" : "stiffening", off, links);
        const double expected = (k < 4 ? linear : stiffening)[n - 1];
        assert_close(off, expected, 0.05 * expected);
        if (k == 7) assert_less(links, 1e-4);
        mbsr_simulation_end(&s);
        test_flexible_free(&w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_beam_is_spun_up),
        cmocka_unit_test(a_built_in_beam_is_spun_up),
        cmocka_unit_test(a_pendulum_falls_and_stiffens),
        cmocka_unit_test(a_pendulum_falls_as_a_chain_of_links_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

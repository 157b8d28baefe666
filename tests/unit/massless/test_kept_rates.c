/* Starts in which joint rates and positions keep the values that they are given.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "expect.h"
#include "loops.h"
#include "units.h"

#include <math.h>

enum { MOST = 64, SYSTEMS = sizeof systems / sizeof systems[0] };

/* Of a model in some units: a start from q, u in SI units by kinds of coordinates; results in SI
 * units. */
typedef struct scene {
    const units *of;
    mbsr_model *m;
    mbsr_data *d;
    int nq, nu;
    double y[MOST], yp[MOST], q[16], u[16];
    mbsr_consistent_opt opt;
    mbsr_consistent_info info;
} scene;

static void begin(scene *s, const units *of)
{
    *s = (scene){.of = of, .opt = mbsr_default_consistent_opt()};
    assert_ok(mbsr_model_create(NULL, &s->m, NULL), NULL);
}

static void finish(scene *s)
{
    assert_ok(mbsr_model_finish(s->m), mbsr_model_error(s->m));
    assert_ok(mbsr_data_create(s->m, &s->d, NULL), NULL);
    s->nq = mbsr_model_nq(s->m);
    s->nu = mbsr_model_nu(s->m);
    assert_in_range(mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM), 1, MOST);
}

static void end(scene *s)
{
    mbsr_data_destroy(s->d);
    mbsr_model_destroy(s->m);
}

/* What a coordinate of this model has to be multiplied by: all joints have one. */
static double span(const scene *s, int k)
{
    mbsr_coordinate_kind kind;
    assert_ok(mbsr_body_coordinate_kinds(s->m, k, &kind, NULL), NULL);
    return kind == MBSR_COORDINATE_TRANSLATION ? s->of->length : 1.0;
}

static int start(scene *s, const double *q, const double *u)
{
    for (int k = 0; k < s->nu; ++k) {
        s->q[k] = q[k] * span(s, k);
        s->u[k] = u[k] * span(s, k) / s->of->time;
    }
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, s->y),
              mbsr_data_error(s->d));
    const int status =
        mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, s->y, s->yp, &s->opt, &s->info);
    for (int k = 0; k < s->nu; ++k) {
        s->q[k] = s->y[k] / span(s, k);
        s->u[k] = s->y[2 * s->nu + k] / span(s, k) * s->of->time;
    }
    return status;
}

static mbsr_inertia rod(const units *of, double mass, double length)
{
    const double com[2] = {0.5 * length * of->length, 0.0};
    return mbsr_inertia_planar(mass * of->mass, com,
                               mass * of->mass * length * length * of->length * of->length / 12.0);
}

static mbsr_planar_frame at(const units *of, double x, double y)
{
    return (mbsr_planar_frame){x * of->length, y * of->length, 0.0};
}

static void add_pin(scene *s, int a, double ax, int b, double bx)
{
    mbsr_closure_def pin = mbsr_closure_ball(a, (double[3]){ax * s->of->length, 0.0, 0.0}, b,
                                             (double[3]){bx * s->of->length, 0.0, 0.0});
    pin.name = "pin";
    assert_ok(mbsr_model_add_closure(s->m, &pin, NULL), mbsr_model_error(s->m));
}

/* Crank 0.3 m, rod 1 m (without mass, where `rod_mass` is 0), slider. */
static void slider_crank(scene *s, const units *of, double rod_mass)
{
    const mbsr_planar_frame none = at(of, 0.0, 0.0), tip = at(of, 0.3, 0.0);
    begin(s, of);
    const int crank = test_add_body(s->m, MBSR_GROUND, mbsr_joint_planar_revolute(none, none),
                                    rod(of, 1.0, 0.3)),
              link = test_add_body(s->m, crank, mbsr_joint_planar_revolute(tip, none),
                                   rod_mass > 0.0 ? rod(of, rod_mass, 1.0) : mbsr_inertia_zero()),
              slider = test_add_body(s->m, MBSR_GROUND, mbsr_joint_planar_prismatic(none, none),
                                     rod(of, 3.0, 0.1));
    add_pin(s, link, 1.0, slider, 0.0);
    finish(s);
}

static double slider_speed(double angle, double rate)
{
    const double lean = asin(0.3 * sin(angle));
    return -rate * 0.3 * (sin(angle) + cos(angle) * tan(lean));
}

/* A crank stands at 0.7 rad and turns at 100 rad/s; the slider follows by the textbook's formula.
 */
static void a_crank_turns_as_told(void **state)
{
    (void)state;
    static const double q[3] = {0.7, -0.9, 1.2}, u[3] = {100.0, 0.0, 0.0};
    static const int keep[3] = {1, 0, 0};
    for (int k = 0; k < 2 * SYSTEMS; ++k) {
        scene s;
        slider_crank(&s, systems + k / 2, k % 2 ? 2.0 : 0.0);
        s.opt.keep_position = s.opt.keep_rate = keep;
        assert_ok(start(&s, q, u), mbsr_data_error(s.d));
        assert_true(s.y[0] == 0.7 && s.y[6] == 100.0 / s.of->time);
        assert_close(s.q[2], 0.3 * cos(0.7) + sqrt(1.0 - pow(0.3 * sin(0.7), 2)), 1e-11);
        assert_close(s.u[2], slider_speed(0.7, 100.0), 1e-9);
        if (k < 2) assert_int_equal(s.info.velocity_changed, 1);
        end(&s);
    }
}

/* Both rates are kept where they agree; otherwise the text has joint, value and row, and nothing
 * changes. */
static void rates_that_contradict(void **state)
{
    (void)state;
    static const int keep[3] = {1, 0, 1}, three[3] = {1, 1, 1};
    for (int k = 0; k < SYSTEMS; ++k) {
        scene s;
        slider_crank(&s, systems + k, 2.0);
        const double lean = asin(0.3 * sin(0.7)),
                     q[3] = {0.7, -0.7 - lean, 0.3 * cos(0.7) + cos(lean)};
        double u[3] = {100.0, 0.0, slider_speed(0.7, 100.0)}, before[MOST];
        s.opt.keep_rate = keep;
        assert_ok(start(&s, q, u), mbsr_data_error(s.d));
        assert_close(s.u[1], -100.0 - 30.0 * cos(0.7) / cos(lean), 1e-9);
        u[2] = 5.0;
        assert_int_equal(start(&s, q, u), MBSR_LOOP_OPEN);
        const mbsr_error *error = mbsr_data_error(s.d);
        assert_contains(error->text, "mbsr_dae_consistent|u0 of body|row|of closure 0 'pin'");
        assert_ok(
            mbsr_dae_pack(
                s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, (double[3]){q[0], q[1], q[2] * s.of->length},
                (double[3]){u[0] / s.of->time, 0.0, u[2] * s.of->length / s.of->time}, before),
            NULL);
        assert_memory_equal(s.y, before, 9 * sizeof *before);
        s.opt.keep_rate = three;
        assert_int_equal(start(&s, q, (double[3]){0.0, 1.0, 0.0}), MBSR_LOOP_OPEN);
        assert_ok(start(&s, q, (double[3]){0.0, 0.0, 0.0}), error);
        end(&s);
    }
}

/* At its dead centre a slider stands still, whatever the crank does. */
static void a_dead_centre(void **state)
{
    (void)state;
    static const double q[3] = {0.0, 0.0, 1.3};
    static const int crank[3] = {1, 0, 0}, slider[3] = {0, 0, 1};
    scene s;
    slider_crank(&s, systems, 2.0);
    s.opt.keep_rate = crank;
    assert_ok(start(&s, q, (double[3]){10.0, 0.0, 0.0}), mbsr_data_error(s.d));
    assert_close(s.u[2], 0.0, 1e-10);
    assert_close(s.u[1], -13.0, 1e-10);
    s.opt.keep_rate = slider;
    assert_int_equal(start(&s, q, (double[3]){0.0, 0.0, 1.0}), MBSR_LOOP_OPEN);
    assert_contains(mbsr_data_error(s.d)->text, "u0 of body 2|cannot keep 1|closure 0 'pin'");
    end(&s);
}

/* Four-bar: crank 1, coupler 2.5, rocker 2, ground 2 (m); its rates by the velocities of the pin.
 */
static void a_four_bar(void **state)
{
    (void)state;
    static const int keep[3] = {0, 0, 1};
    for (int k = 0; k < SYSTEMS; ++k) {
        const units *of = systems + k;
        const mbsr_planar_frame none = at(of, 0.0, 0.0);
        scene s;
        begin(&s, of);
        const int crank = test_add_body(s.m, MBSR_GROUND, mbsr_joint_planar_revolute(none, none),
                                        rod(of, 1.0, 1.0)),
                  coupler =
                      test_add_body(s.m, crank, mbsr_joint_planar_revolute(at(of, 1.0, 0.0), none),
                                    rod(of, 2.5, 2.5)),
                  rocker = test_add_body(s.m, MBSR_GROUND,
                                         mbsr_joint_planar_revolute(at(of, 2.0, 0.0), none),
                                         rod(of, 2.0, 2.0));
        add_pin(&s, coupler, 2.5, rocker, 2.0);
        finish(&s);
        s.opt.keep_rate = keep;
        assert_ok(start(&s, (double[3]){1.2, -0.9, 1.3}, (double[3]){0.0, 0.0, -7.0}),
                  mbsr_data_error(s.d));
        /* crank e_a w_a + coupler e_b w_b = rocker e_c w_c, e turned by 90 degrees */
        const double a = s.q[0], b = a + s.q[1], c = s.q[2],
                     w_a = -7.0 * 2.0 * sin(c - b) / sin(a - b),
                     w_b = -7.0 * 2.0 * sin(c - a) / (2.5 * sin(b - a));
        assert_true(s.u[2] == -7.0 || fabs(s.u[2] + 7.0) < 1e-14);
        assert_close(s.u[0], w_a, 1e-10);
        assert_close(s.u[0] + s.u[1], w_b, 1e-10);
        end(&s);
    }
}

/* Two masses on rails at right angles, 5 m apart, at (4, 0) and (0, 3): 4 x' + 3 y' = 0. */
static void two_masses_at_a_distance(void **state)
{
    (void)state;
    static const int keep[2] = {1, 0};
    for (int k = 0; k < SYSTEMS; ++k) {
        const units *of = systems + k;
        scene s;
        begin(&s, of);
        const mbsr_planar_frame none = at(of, 0.0, 0.0),
                                up = {0.0, 0.0, 0.5 * 3.14159265358979323846};
        const int a = test_add_body(s.m, MBSR_GROUND, mbsr_joint_planar_prismatic(none, none),
                                    rod(of, 1.0, 0.1)),
                  b = test_add_body(s.m, MBSR_GROUND, mbsr_joint_planar_prismatic(up, none),
                                    rod(of, 20.0, 0.1));
        const double o[3] = {0.0, 0.0, 0.0};
        const mbsr_closure_def distance = mbsr_closure_distance(a, o, b, o, 5.0 * of->length);
        assert_ok(mbsr_model_add_closure(s.m, &distance, NULL), mbsr_model_error(s.m));
        finish(&s);
        s.opt.keep_rate = keep;
        assert_ok(start(&s, (double[2]){4.0, 3.0}, (double[2]){0.6, 0.0}), mbsr_data_error(s.d));
        assert_close(s.u[0], 0.6, 1e-13);
        assert_close(s.u[1], -0.8, 1e-12);
        end(&s);
    }
}

/* Masses of 1 and 2 kg on a rail, between them a body without mass that dampers of 5 and 8 N s/m
 * tie to both. */
static void chain(scene *s, const units *of, double stiffness)
{
    const mbsr_planar_frame none = at(of, 0.0, 0.0);
    const double N_s_m = of->mass / of->time, N_m = N_s_m / of->time;
    begin(s, of);
    const int a = test_add_body(s->m, MBSR_GROUND, mbsr_joint_planar_prismatic(none, none),
                                rod(of, 1.0, 0.1)),
              link = test_add_body(s->m, a, mbsr_joint_planar_prismatic(none, none),
                                   mbsr_inertia_zero()),
              b = test_add_body(s->m, link, mbsr_joint_planar_prismatic(none, none),
                                rod(of, 2.0, 0.1));
    const double damping = stiffness > 0.0 ? 0.0 : 1.0;
    const mbsr_force_def first = mbsr_force_joint_spring(link, 0, 5.0 * stiffness * N_m,
                                                         5.0 * damping * N_s_m, 0.0),
                         second = mbsr_force_joint_spring(b, 0, 8.0 * stiffness * N_m,
                                                          8.0 * damping * N_s_m, 0.0);
    assert_ok(mbsr_model_add_force(s->m, &first, NULL), mbsr_model_error(s->m));
    assert_ok(mbsr_model_add_force(s->m, &second, NULL), mbsr_model_error(s->m));
    finish(s);
}

/* The link moves as its dampers, or springs, let it, 5 u_1 = 8 u_2; impulses pass through these,
 * and where nothing but rates between the masses is kept their momentum stays. */
static void a_massless_link_between_kept_rates(void **state)
{
    (void)state;
    static const int both[3] = {1, 0, 1}, one[3] = {0, 0, 1}, contrary[3] = {0, 1, 1};
    static const double q[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < 2 * SYSTEMS; ++k) {
        scene s;
        chain(&s, systems + k / 2, k % 2 ? 100.0 : 0.0);
        s.opt.keep_rate = both;
        assert_ok(start(&s, q, (double[3]){2.0, 0.0, 3.0}), mbsr_data_error(s.d));
        assert_close(s.u[0], 2.0, 1e-12);
        assert_close(s.u[1], 4.8, 1e-9);
        assert_close(s.u[2], 3.0, 1e-12);
        assert_int_equal(s.info.elastic, k % 2);
        s.opt.keep_rate = one;
        assert_ok(start(&s, q, (double[3]){0.0, 0.0, 3.0}), mbsr_data_error(s.d));
        assert_close(s.u[2], 3.0, 1e-12);
        assert_close(s.u[1], 4.8, 1e-9);
        assert_close(1.0 * s.u[0] + 2.0 * (s.u[0] + s.u[1] + s.u[2]), 6.0, 1e-7);
        s.opt.keep_rate = contrary;
        assert_int_equal(start(&s, q, (double[3]){0.0, 1.0, 3.0}), MBSR_NO_CONVERGENCE);
        assert_contains(mbsr_data_error(s.d)->text, "cannot keep|no impulse reaches it");
        end(&s);
    }
}

/* In every form of a tree the same. */
static void in_every_form(void **state)
{
    (void)state;
    static const int keep[3] = {1, 0, 1};
    static const double q[3] = {0.0, 0.0, 0.0}, u[3] = {2.0, 0.0, 3.0};
    scene s;
    chain(&s, systems, 0.0);
    s.opt.keep_rate = keep;
    for (int form = MBSR_DAE_MOMENTUM; form <= MBSR_DAE_INDEX1; ++form) {
        assert_ok(mbsr_dae_pack(s.m, s.d, (mbsr_dae_form)form, 0.0, q, u, s.y), NULL);
        assert_ok(mbsr_dae_consistent(s.m, s.d, (mbsr_dae_form)form, 0.0, s.y, s.yp, &s.opt, NULL),
                  mbsr_data_error(s.d));
        assert_ok(mbsr_dae_unpack(s.m, s.d, (mbsr_dae_form)form, 0.0, s.y, s.q, s.u), NULL);
        assert_close(s.u[0], 2.0, 1e-12);
        assert_close(s.u[1], 4.8, 1e-9);
        assert_close(s.u[2], 3.0, 1e-12);
    }
    end(&s);
}

/* A parallelogram on three legs, one row redundant: all legs turn as the one that is told to. */
static void a_redundant_loop(void **state)
{
    (void)state;
    static const double angles[4] = {1.2, -1.2, 1.2, 1.2};
    int keep[4] = {0, 0, 0, 1};
    loops s;
    double y[MOST], yp[MOST];
    mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    loops_begin(&s, NULL);
    loops_add_parallelograms(&s, 1);
    loops_finish(&s);
    opt.keep_rate = keep;
    const double u[4] = {0.0, 0.0, 0.0, 4.0};
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, angles, u, y), NULL);
    assert_ok(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, &opt, NULL),
              mbsr_data_error(s.d));
    for (int k = 0; k < 4; ++k) assert_close(y[8 + k], k == 1 ? -4.0 : 4.0, 1e-10);
    keep[2] = 1;
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, angles, u, y), NULL);
    assert_int_equal(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, &opt, NULL),
                     MBSR_LOOP_OPEN);
    loops_free(&s);
}

/* Angles of a quaternion stay together; weights are positive. */
static void what_is_refused(void **state)
{
    (void)state;
    static const int keep[3] = {1, 0, 1};
    const double weight[3] = {1.0, -1.0, 1.0}, moment[6] = {1.0, 1.0, 1.0, 0.0, 0.0, 0.0};
    double q[4] = {1.0, 0.0, 0.0, 0.0}, u[3] = {1.0, 2.0, 3.0};
    scene s;
    begin(&s, systems);
    test_add_body(s.m, MBSR_GROUND, mbsr_joint_spherical(NULL, NULL),
                  mbsr_inertia_rigid(1.0, (double[3]){0.0, 0.0, 0.0}, moment));
    finish(&s);
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, q, u, s.y), NULL);
    s.opt.keep_position = keep;
    assert_refused(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.y, s.yp, &s.opt, NULL),
                   mbsr_data_error(s.d), MBSR_ERR_VALUE, 0, MBSR_NONE,
                   "keep_position[0 .. 2]|quaternion");
    s.opt.keep_position = NULL;
    s.opt.weight = weight;
    assert_refused(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.y, s.yp, &s.opt, NULL),
                   mbsr_data_error(s.d), MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "weight[1] is -1");
    s.opt.weight = NULL;
    s.opt.keep_rate = keep;
    assert_ok(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.y, s.yp, &s.opt, &s.info),
              mbsr_data_error(s.d));
    assert_int_equal(s.info.velocity_changed, MBSR_NONE);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_crank_turns_as_told),
                                       cmocka_unit_test(rates_that_contradict),
                                       cmocka_unit_test(a_dead_centre),
                                       cmocka_unit_test(a_four_bar),
                                       cmocka_unit_test(two_masses_at_a_distance),
                                       cmocka_unit_test(a_massless_link_between_kept_rates),
                                       cmocka_unit_test(in_every_form),
                                       cmocka_unit_test(a_redundant_loop),
                                       cmocka_unit_test(what_is_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

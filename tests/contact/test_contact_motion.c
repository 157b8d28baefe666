/* Motions with contact whose answers are known, by the driver and by steps of fixed size.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "shapes.h"

#include <mbsrank/sensitivity.h>
#include <mbsrank/simulation.h>

#include <stdbool.h>

/* Units in those of the test: m, kg, s. */
typedef struct units {
    double length, mass, time;
} units;

static const units systems[] = {{1, 1, 1}, {1000, 0.001, 1}, {1, 1000, 1000}, {3.28, 2.2, 0.1}};

/* Of which a scene is made: a plane below, bodies with one shape each. */
typedef struct run {
    mbsr_simulation s;
    mbsr_contacts *contacts;
    int force;
    units in;
    double q[7 * 26], u[6 * 26];
    int bodies;
} run;

static mbsr_contact_law law_in(units in, double stiffness, double damping, double friction)
{
    const double force = in.mass * in.length / (in.time * in.time);
    return (mbsr_contact_law){.stiffness = stiffness * force / pow(in.length, 1.5),
                              .exponent = 1.5,
                              .damping = damping * in.time / in.length,
                              .friction = friction,
                              .slip = 1e-4 * in.length / in.time,
                              .spin = 1e-3 / in.time};
}

static void begin(run *r, units in, bool plane, mbsr_contact_law law)
{
    mbsr_error error;
    *r = (run){.in = in, .s = mbsr_simulation_begin(NULL)};
    assert_int_equal(mbsr_contacts_create(&r->contacts, &error), MBSR_OK);
    const double g = plane ? 9.81 * in.length / (in.time * in.time) : 0.0;
    mbsr_simulation_add_force(&r->s, mbsr_force_gravity(0, 0, -g));
    mbsr_shape ground = mbsr_default_shape();
    ground.kind = MBSR_SHAPE_PLANE;
    ground.law = law;
    ground.law.stiffness = INFINITY;
    if (plane) assert_int_equal(mbsr_contacts_add(r->contacts, &ground, NULL, &error), MBSR_OK);
}

/* A ball or a box of 0.1 m half size and density 1000. */
static void add(run *r, mbsr_shape_kind kind, mbsr_contact_law law, double x, double z)
{
    mbsr_error error;
    const units in = r->in;
    const double half = 0.1 * in.length, density = 1000 * in.mass / pow(in.length, 3);
    const double edges[3] = {2 * half, 2 * half, 2 * half};
    mbsr_shape shape = mbsr_default_shape();
    shape.kind = kind;
    shape.law = law;
    for (int k = 0; k < 3; ++k) shape.size[k] = half;
    const mbsr_inertia inertia = kind == MBSR_SHAPE_BOX ? mbsr_inertia_box(density, edges)
                                                        : mbsr_inertia_sphere(density, half);
    shape.body =
        mbsr_simulation_add_body(&r->s, "body", MBSR_GROUND, mbsr_joint_free(NULL, NULL), inertia);
    if (mbsr_contacts_add(r->contacts, &shape, NULL, &error)) fail_msg("%s", error.text);
    double *q = r->q + 7 * r->bodies++;
    q[0] = 1.0;
    q[4] = x * in.length;
    q[6] = z * in.length;
}

static void start(run *r, double tolerance)
{
    mbsr_error error;
    mbsr_force_def force;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    if (mbsr_contacts_force(r->contacts, 0, &force, &error)) fail_msg("%s", error.text);
    r->force = mbsr_simulation_add_force(&r->s, force);
    if (mbsr_simulation_start(&r->s, &opt, 0.0, r->q, r->u)) fail_msg("%s", r->s.error.text);
}

static void to(run *r, double t)
{
    if (mbsr_simulation_to(&r->s, t * r->in.time)) fail_msg("%s", r->s.error.text);
    memcpy(r->q, mbsr_simulation_q(&r->s), 7 * sizeof(double) * (size_t)r->bodies);
    memcpy(r->u, mbsr_simulation_u(&r->s), 6 * sizeof(double) * (size_t)r->bodies);
}

static void end(run *r)
{
    mbsr_simulation_end(&r->s);
    mbsr_contacts_destroy(r->contacts);
}

/* How far a ball sinks in at rest, in m. */
static double depth_of(double stiffness)
{
    return pow(1000 * 4.0 / 3.0 * 3.14159265358979 * 1e-3 * 9.81 / stiffness, 1.0 / 1.5);
}

/* A ball that slides at first rolls with 5/7 of its velocity then, from 2 v / (7 mu g) on. */
static void rolling(void **unused)
{
    (void)unused;
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        const units in = systems[k];
        const mbsr_contact_law law = law_in(in, 1e7, 1.0, 0.3);
        run r;
        begin(&r, in, true, law);
        add(&r, MBSR_SHAPE_SPHERE, law, 0.0, 0.1 - depth_of(1e7));
        r.u[3] = 2.0 * in.length / in.time;
        start(&r, 1e-7);
        to(&r, 0.1);
        assert_close(r.u[3] * in.time / in.length, 2.0 - 0.3 * 9.81 * 0.1, 1e-4);
        to(&r, 1.0);
        assert_close(r.u[3] * in.time / in.length, 10.0 / 7.0, 2e-3);
        assert_close(r.u[1] * in.time * 0.1, 10.0 / 7.0, 2e-3);
        end(&r);
    }
}

/* A ball turns on its pole: I w' = -torsional N w / root(w^2 + spin^2), which has the integral
 * root(w^2 + spin^2) - spin asinh(spin / w) + torsional N t / I. */
static double wound_down(double w, double spin)
{
    return hypot(w, spin) - spin * asinh(spin / w);
}

static void spinning_down(void **unused)
{
    (void)unused;
    for (size_t k = 0; k < 4; ++k) {
        const units in = systems[k];
        const double mass = 1000.0 * 4.0 / 3.0 * 3.14159265358979323846 * 1e-3,
                     rate = 0.01 * mass * 9.81 / (0.4 * mass * 0.01), spin = 0.5;
        mbsr_contact_law law = law_in(in, 1e7, 0.1, 0.0);
        law.torsional = 0.01 * in.length;
        law.spin = spin / in.time;
        run r;
        begin(&r, in, true, law);
        add(&r, MBSR_SHAPE_SPHERE, law, 0.0, 0.1 - pow(mass * 9.81 / 1e7, 2.0 / 3.0));
        r.u[2] = 5.0 / in.time;
        start(&r, 1e-9);
        for (int l = 1; l <= 4; ++l) {
            const double t = 0.05 * l;
            to(&r, t);
            const double w = r.u[2] * in.time;
            assert_close(wound_down(w, spin) + rate * t, wound_down(5.0, spin), 1e-4);
        }
        end(&r);
    }
}

/* One that rolls comes to rest by its rolling friction alone, likewise: (I + m r^2) w' = -rolling N
 * w / root(w^2 + spin^2). */
static void rolling_down(void **unused)
{
    (void)unused;
    for (size_t k = 0; k < 4; ++k) {
        const units in = systems[k];
        const double mass = 1000.0 * 4.0 / 3.0 * 3.14159265358979323846 * 1e-3,
                     rate = 0.01 * mass * 9.81 / (1.4 * mass * 0.01), spin = 0.5;
        mbsr_contact_law law = law_in(in, 1e9, 0.1, 0.5);
        law.rolling = 0.01 * in.length;
        law.spin = spin / in.time;
        run r;
        begin(&r, in, true, law);
        add(&r, MBSR_SHAPE_SPHERE, law, 0.0, 0.1 - depth_of(1e9));
        r.u[1] = 5.0 / in.time;
        r.u[3] = 0.5 * in.length / in.time;
        start(&r, 1e-8);
        for (int l = 1; l <= 4; ++l) {
            const double t = 0.1 * l;
            to(&r, t);
            const double w = r.u[1] * in.time;
            assert_close(wound_down(w, spin) + rate * t, wound_down(5.0, spin), 2e-3);
            assert_close(r.u[3] * in.time / in.length, 0.1 * w, 1e-3);
        }
        end(&r);
    }
}

/* A box that slides stops after v^2 / (2 mu g). */
static void sliding(void **unused)
{
    (void)unused;
    const units in = systems[0];
    const mbsr_contact_law law = law_in(in, 1e7, 1.0, 0.5);
    run r;
    begin(&r, in, true, law);
    add(&r, MBSR_SHAPE_BOX, law, 0.0, 0.1 - pow(8.0 * 9.81 / 4e7, 1.0 / 1.5));
    r.u[3] = 1.0;
    start(&r, 1e-6);
    to(&r, 1.0);
    assert_close(r.q[4], 1.0 / (2.0 * 0.5 * 9.81), 1e-3);
    mbsr_contact_point point[8];
    int count;
    assert_int_equal(mbsr_contact_report(mbsr_simulation_model(&r.s), mbsr_simulation_data(&r.s),
                                         r.force, 8, point, &count),
                     MBSR_OK);
    assert_int_equal(count, 4);
    for (int k = 0; k < 4; ++k) /* while it still rocks a little: that is 0.995 of full friction */
        assert_true(hypot(point[k].sliding[0], point[k].sliding[1]) < 1e-3);
    assert_close(r.q[6], 0.1 - pow(8.0 * 9.81 / 4e7, 1.0 / 1.5), 2e-5);
    end(&r);
}

/* What a ball is thrown back with is the law's, whatever the tolerance: e of the Hunt and Crossley
 * law at the speed v obeys, with a = damping, (1 + a v) exp(-a v) = (1 - a e v) exp(a e v). */
static void bouncing(void **unused)
{
    (void)unused;
    const double a = 0.2, v = sqrt(2.0 * 9.81 * 0.5);
    double low = 0.0, high = 1.0;
    for (int k = 0; k < 60; ++k) {
        const double e = 0.5 * (low + high);
        const double left = log(1.0 + a * v) - a * v, right = log(1.0 - a * e * v) + a * e * v;
        if (right > left)
            low = e;
        else
            high = e;
    }
    static const double tolerances[] = {1e-5, 1e-7};
    for (int k = 0; k < 2; ++k) {
        const mbsr_contact_law law = law_in(systems[0], 1e8, a, 0.0);
        run r;
        begin(&r, systems[0], true, law);
        add(&r, MBSR_SHAPE_SPHERE, law, 0.0, 0.6);
        start(&r, tolerances[k]);
        to(&r, v / 9.81 + 0.1);
        /* what it has after the blow, from its energy */
        const double after = sqrt(r.u[5] * r.u[5] + 2.0 * 9.81 * (r.q[6] - 0.1));
        assert_close(after / v, low, k == 0 ? 2e-2 : 2e-3);
        end(&r);
    }
}

/* Blows of a ball without loss are taken carefully, all of them: forces there turn on and off
 * within a step, which matrices of earlier steps do not show. */
static void blows(void **unused)
{
    (void)unused;
    const mbsr_contact_law law = law_in(systems[0], 1e9, 0.0, 0.0);
    mbsr_ida_stats stats;
    run r;
    begin(&r, systems[0], true, law);
    add(&r, MBSR_SHAPE_SPHERE, law, 0.0, 5.0);
    start(&r, 1e-5);
    to(&r, 20.0);
    assert_int_equal(mbsr_simulation_get_stats(&r.s, &stats), MBSR_OK);
    print_message("%ld steps, %ld attempts carefully\n", stats.steps, stats.careful_attempts);
    assert_true(stats.careful_attempts > stats.steps);
    end(&r);
}

/* A row of balls apart from each other: the last goes with what the first had; momentum and energy
 * stay. */
static void cradle(void **unused)
{
    (void)unused;
    const mbsr_contact_law law = law_in(systems[0], 1e8, 0.0, 0.0);
    run r;
    begin(&r, systems[0], false, law);
    for (int k = 0; k < 5; ++k) add(&r, MBSR_SHAPE_SPHERE, law, 0.21 * k, 0.0);
    r.u[3] = 1.0;
    start(&r, 1e-8);
    to(&r, 0.3);
    double sum = 0.0, square = 0.0;
    for (int k = 0; k < 5; ++k) sum += r.u[6 * k + 3], square += r.u[6 * k + 3] * r.u[6 * k + 3];
    assert_close(sum, 1.0, 1e-9);
    assert_close(square, 1.0, 1e-4);
    assert_close(r.u[6 * 4 + 3], 1.0, 1e-4);
    end(&r);
}

/* Ten boxes on each other stay; each point of the lowest carries a quarter of all. */
static void stack(void **unused)
{
    (void)unused;
    const mbsr_contact_law law = law_in(systems[0], 1e7, 1.0, 0.5);
    run r;
    begin(&r, systems[0], true, law);
    for (int k = 0; k < 10; ++k) add(&r, MBSR_SHAPE_BOX, law, 0.0, 0.1 + 0.2 * k);
    start(&r, 1e-4);
    to(&r, 100.0);
    int count;
    mbsr_contact_point point[200];
    assert_int_equal(mbsr_contact_report(mbsr_simulation_model(&r.s), mbsr_simulation_data(&r.s),
                                         r.force, 200, point, &count),
                     MBSR_OK);
    double sum = 0.0;
    for (int k = 0; k < count; ++k)
        sum += point[k].body_a == MBSR_GROUND ? point[k].normal_force : 0.0;
    assert_close(sum, 80.0 * 9.81, 1e-3);
    for (int k = 0; k < 10; ++k) {
        assert_close(r.q[7 * k + 4], 0.0, 1e-3);
        assert_close(r.q[7 * k + 6], 0.1 + 0.2 * k, 1e-3 * (k + 1));
    }
    mbsr_ida_stats stats;
    assert_int_equal(mbsr_simulation_get_stats(&r.s, &stats), MBSR_OK);
    const long steps = stats.steps;
    print_message("%ld steps\n", steps);
    assert_true(steps < 3000);
    end(&r);
}

/* On a floor with the slope 0.03 five boxes creep on each other, every second one turned by 45
 * degrees: at each face friction carries that part of the normal force, so that v / root(v^2 +
 * slip^2) = 0.03 / mu there, and box k is k + 1 times as fast as the lowest one. */
static void leaning(void **unused)
{
    (void)unused;
    mbsr_contact_law law = law_in(systems[0], 1e11, 1e3, 0.5);
    run r;
    begin(&r, systems[0], false, law);
    mbsr_shape floor_ = mbsr_default_shape();
    mbsr_error error;
    floor_.kind = MBSR_SHAPE_PLANE;
    floor_.law = law;
    floor_.law.stiffness = INFINITY;
    assert_int_equal(mbsr_contacts_add(r.contacts, &floor_, NULL, &error), MBSR_OK);
    mbsr_simulation_add_force(&r.s, mbsr_force_gravity(0.03 * 9.81, 0, -9.81));
    for (int k = 0; k < 5; ++k) {
        add(&r, MBSR_SHAPE_BOX, law, 0.0, 0.1 + 0.2 * k);
        if (k % 2) r.q[7 * k] = cos(0.3926990817), r.q[7 * k + 3] = sin(0.3926990817);
    }
    start(&r, 1e-6);
    double before[5];
    to(&r, 20.0);
    for (int k = 0; k < 5; ++k) before[k] = r.q[7 * k + 4];
    to(&r, 100.0);
    const double creep = 1e-4 * 0.06 / sqrt(1.0 - 0.06 * 0.06);
    for (int k = 0; k < 5; ++k)
        assert_close((r.q[7 * k + 4] - before[k]) / 80.0, (k + 1) * creep, 1e-3 * (k + 1) * creep);
    end(&r);
}

/* A free body with one shape, at rest. */
static int add_own(run *r, const mbsr_shape *like, mbsr_inertia inertia, double x, double y,
                   double z)
{
    mbsr_error error;
    mbsr_shape shape = *like;
    shape.body =
        mbsr_simulation_add_body(&r->s, "body", MBSR_GROUND, mbsr_joint_free(NULL, NULL), inertia);
    if (mbsr_contacts_add(r->contacts, &shape, NULL, &error)) fail_msg("%s", error.text);
    double *q = r->q + 7 * r->bodies++;
    q[0] = 1.0;
    q[4] = x, q[5] = y, q[6] = z;
    return shape.body;
}

/* A slab of 10 kg with balls of 1 kg on it is pulled by 150 N over a floor with the coefficient 0.4
 * (rolling of leggedrobotics/SimBenchmark, with 25 balls): they roll with 2/7 of its acceleration,
 * whatever the direction. */
static void pulled_slab(void **unused)
{
    (void)unused;
    const int side = test_long() ? 5 : 2, balls = side * side;
    const double edges[3] = {20.0, 20.0, 1.0}, k = 1e8, weight = (10.0 + balls) * 9.81,
                 a = (150.0 - 0.4 * weight) / (10.0 + balls * 2.0 / 7.0), t = 1.0;
    for (int n = 0; n < 3; ++n) {
        const double way[2] = {cos(0.6 * n), sin(0.6 * n)};
        double wrench[6] = {0.0, 0.0, 0.0, 150.0 * way[0], 150.0 * way[1], 0.0};
        run r;
        mbsr_contact_law law = {
            .stiffness = k, .exponent = 1.0, .damping = 1e3, .friction = 0.4, .slip = 1e-6};
        begin(&r, systems[0], true, law);
        mbsr_shape slab = mbsr_default_shape(), ball = slab;
        slab.law = ball.law = law;
        for (int l = 0; l < 3; ++l) slab.size[l] = 0.5 * edges[l];
        ball.kind = MBSR_SHAPE_SPHERE;
        ball.size[0] = 0.5;
        ball.law.friction = 0.8;
        const double deep = weight / (4.0 * k);
        const int body =
            add_own(&r, &slab, mbsr_inertia_box(10.0 / 400.0, edges), 0.0, 0.0, 0.5 - deep);
        for (int l = 0; l < balls; ++l)
            add_own(&r, &ball, mbsr_inertia_sphere(6.0 / 3.14159265358979323846, 0.5),
                    2.0 * (l / side) - side + 1.0, 2.0 * (l % side) - side + 1.0,
                    1.5 - deep - 9.81 / (0.5 * k));
        mbsr_simulation_add_force(&r.s, mbsr_force_applied(body, mbsr_stored_force, wrench));
        start(&r, 1e-8);
        to(&r, t);
        for (int l = 0; l < 2; ++l) {
            assert_close(r.u[3 + l], a * t * way[l], 1e-5 * a * t);
            for (int b = 1; b <= balls; ++b)
                assert_close(r.u[6 * b + 3 + l], 2.0 / 7.0 * a * t * way[l], 1e-5 * a * t);
        }
        end(&r);
    }
}

/* What boxes cost that are thrown over a floor, in counts, which are the same on all machines. */
static void counts(void **unused)
{
    (void)unused;
    const mbsr_contact_law law = law_in(systems[0], 1e6, 1.0, 0.4);
    mbsr_ida_stats stats;
    run r;
    begin(&r, systems[0], true, law);
    for (int k = 0; k < 4; ++k) {
        add(&r, MBSR_SHAPE_BOX, law, 1.0 * k, 0.11 + 0.01 * k);
        r.u[6 * k + 3] = 1.0 + 0.1 * k;
        r.u[6 * k + 1] = 0.2 * k;
    }
    start(&r, 1e-4);
    to(&r, 0.5);
    assert_int_equal(mbsr_simulation_get_stats(&r.s, &stats), MBSR_OK);
    print_message("%ld steps, %ld residuals, %ld matrices, %ld error tests failed\n", stats.steps,
                  stats.residuals, stats.factorisations, stats.error_test_failures);
    assert_true(stats.steps < 800);
    assert_true(stats.residuals < 5 * stats.steps);
    assert_true(stats.factorisations < stats.steps);
    assert_true(5 * stats.error_test_failures < stats.steps);
    end(&r);
}

/* A ball of 1 kg is thrown at a wall at 1 m/s without gravity. It leaves as fast as it came and is
 * in contact for T = 2 x/v sqrt(pi) G(1 + a)/G(1/2 + a), a = 1/(n + 1), x = (m v^2 / 2 a k)^a, so
 * that dz/dm = -v a T/m behind. Where a force begins as x^1.5 its slope begins as a root, which
 * costs digits. */
static void mass_of_a_bouncing_ball(void **state)
{
    static const struct {
        double exponent, tolerance, off;
    } cases[] = {{2.0, 1e-6, 1e-4}, {2.0, 1e-8, 1e-6}, {1.5, 1e-6, 1e-3}, {1.5, 1e-8, 1e-4}};
    const double pi = 3.14159265358979323846, k = 2e4, radius = 0.2, end = 0.5;
    (void)state;
    for (size_t n = 0; n < sizeof cases / sizeof *cases; ++n) {
        const double a = 1.0 / (cases[n].exponent + 1.0), x = pow(0.5 / (a * k), a),
                     T = 2.0 * x * sqrt(pi) * tgamma(1.0 + a) / tgamma(0.5 + a);
        mbsr_shape shape[2] = {mbsr_default_shape(), mbsr_default_shape()};
        shape[0].kind = MBSR_SHAPE_PLANE;
        shape[1].kind = MBSR_SHAPE_SPHERE;
        shape[1].body = 0;
        shape[1].size[0] = radius;
        shape[1].law.stiffness = k;
        shape[0].law.exponent = shape[1].law.exponent = cases[n].exponent;
        scene s = scene_of(2, shape);
        mbsr_parameters *list;
        mbsr_sensitivity *sensitivity;
        mbsr_error error;
        int mass;
        assert_int_equal(mbsr_parameters_create(s.model, &list, &error), MBSR_OK);
        mass = mbsr_parameters_find(list, "bodies.body0.mass");
        mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
        opt.list = list, opt.parameters = 1, opt.which = &mass;
        opt.ida.rtol = opt.ida.atol = cases[n].tolerance;
        if (mbsr_sensitivity_create(s.model, &opt, &sensitivity, &error))
            fail_msg("%s", error.text);
        const double q[7] = {1, 0, 0, 0, 0, 0, radius + 0.05}, u[6] = {0, 0, 0, 0, 0, -1.0},
                     along[6] = {0, 0, 0, 0, 0, 1.0};
        double q_at[7], dq[7], du[6], by = 0.0;
        if (mbsr_sensitivity_run(sensitivity, 0.0, q, u, 1, &end, q_at, NULL) ||
            mbsr_sensitivity_forward(sensitivity, dq, du) ||
            mbsr_sensitivity_adjoint(sensitivity, NULL, along, &by))
            fail_msg("%s", mbsr_sensitivity_error(sensitivity)->text);
        assert_close(dq[6], -a * T, cases[n].off);
        assert_close(du[5], 0.0, cases[n].off);
        assert_close(by, du[5], 1e-12);
        mbsr_sensitivity_destroy(sensitivity);
        mbsr_parameters_destroy(list);
        end_scene(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rolling),       cmocka_unit_test(sliding),
        cmocka_unit_test(spinning_down), cmocka_unit_test(rolling_down),
        cmocka_unit_test(bouncing),      cmocka_unit_test(blows),
        cmocka_unit_test(cradle),        cmocka_unit_test(stack),
        cmocka_unit_test(leaning),       cmocka_unit_test(pulled_slab),
        cmocka_unit_test(counts),        cmocka_unit_test(mass_of_a_bouncing_ball)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Inputs and outputs by name: responses against closed forms.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "build.h"

#include <mbsrank/linear.h>

#include <complex.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

static const double mass = 2.0, stiffness = 50.0, damping = 3.0, weight = 9.81, length = 0.7,
                    pi = 3.14159265358979323846;

enum { INPUTS = 4, OUTPUTS = 5 };

/* m x" + d x' + k (x - x0) = w - m g along z. */
static mbsr_model *make_hanging(mbsr_data **d)
{
    mbsr_model *m = empty();
    const double up[3] = {0, 0, 1};
    add_body(m, MBSR_GROUND, "a mass", mbsr_joint_prismatic(NULL, NULL, up),
             mbsr_inertia_particle(mass));
    mbsr_force_def spring = mbsr_force_joint_spring(0, 0, stiffness, damping, 0.0);
    spring.name = "spring";
    add_force(m, spring);
    add_force(m, mbsr_force_gravity(0, 0, -weight));
    *d = finish(m);
    return m;
}

/* Columns of inputs: w, x0, m, k at rest; rows: x, x', z, the spring's force and its copy by f. */
static void a_mass_on_a_spring(void **state)
{
    (void)state;
    static const char *const in[INPUTS] = {"bodies.'a mass'.tau", "forces.spring.rest",
                                           "bodies.'a mass'.mass", "forces.spring.stiffness"},
                             *const out[OUTPUTS] = {"bodies.'a mass'.q", "bodies.'a mass'.u[1]",
                                                    "bodies.'a mass'.z", "forces.spring.tau",
                                                    "bodies.'a mass'.x"};
    mbsr_data *d;
    mbsr_model *m = make_hanging(&d);
    mbsr_parameters *list;
    mbsr_signal input[INPUTS], output[OUTPUTS];
    mbsr_error error;
    assert_ok(mbsr_parameters_create(m, &list, &error), &error);
    for (int k = 0; k < INPUTS; ++k)
        assert_ok(mbsr_signal_find(m, list, in[k], input + k, &error), &error);
    for (int k = 0; k < OUTPUTS; ++k)
        assert_ok(mbsr_signal_find(m, list, out[k], output + k, &error), &error);
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    opt.inputs = INPUTS, opt.outputs = OUTPUTS;
    opt.input = input, opt.output = output, opt.list = list;
    const double rest = -mass * weight / stiffness;
    mbsr_linear *l;
    assert_ok(mbsr_linear_create(m, d, 0.0, &rest, NULL, &opt, &l, &error), &error);
    mbsr_parameters_destroy(list);
    for (int k = 0; k < 4; ++k) {
        const double f = 0.4 * k;
        double re[INPUTS * OUTPUTS], im[INPUTS * OUTPUTS];
        const double complex s = 2.0 * pi * f * I, G = 1.0 / ((mass * s + damping) * s + stiffness),
                             forces[INPUTS] = {1.0, stiffness, -weight, -rest};
        assert_ok(mbsr_linear_response(l, f, re, im), NULL);
        for (int j = 0; j < INPUTS; ++j) {
            const double complex x = G * forces[j],
                                 own = j == 1   ? stiffness
                                       : j == 3 ? -rest
                                                : 0.0,
                                 y[OUTPUTS] = {x, s * x, x, own - (stiffness + damping * s) * x,
                                               0.0};
            for (int i = 0; i < OUTPUTS; ++i) {
                assert_close(re[j * OUTPUTS + i], creal(y[i]), 1e-9 * stiffness);
                assert_close(im[j * OUTPUTS + i], cimag(y[i]), 1e-9 * stiffness);
            }
        }
    }
    mbsr_linear_destroy(l);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* The tip of a pendulum about its rest, and about a steady turn of its pivot. */
static void a_point_and_a_rate(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    const double x[3] = {1, 0, 0}, below[3] = {0, 0, -length};
    add_body(m, MBSR_GROUND, "rod", mbsr_joint_revolute(NULL, NULL, x),
             mbsr_inertia_point_mass(mass, below));
    add_force(m, mbsr_force_gravity(0, 0, -weight));
    mbsr_data *d = finish(m);
    const mbsr_signal in = {.kind = MBSR_SIGNAL_JOINT},
                      tip = {.kind = MBSR_SIGNAL_POINT, .part = 1, .point = {0, 0, -length}};
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    opt.inputs = opt.outputs = 1;
    opt.input = &in, opt.output = &tip;
    mbsr_linear *l;
    const double q = 0.0;
    double re, im;
    assert_ok(mbsr_linear_create(m, d, 0.0, &q, NULL, &opt, &l, NULL), NULL);
    assert_ok(mbsr_linear_response(l, 0.0, &re, &im), NULL);
    assert_close(re, length / (mass * weight * length), 1e-12); /* y = l q, q = w / (m g l) */
    mbsr_linear_destroy(l);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* What a spring to the ground, its first body, exerts on a pendulum on the side: along y by the way
 * of its end, and about the origin. */
static void a_force_and_a_moment(void **state)
{
    (void)state;
    static const char *const out[2] = {"forces.side.f[5]", "forces.side.f"};
    mbsr_model *m = empty();
    const double x[3] = {1, 0, 0}, below[3] = {0, 0, -length}, wall[3] = {0, -1.0, -length};
    add_body(m, MBSR_GROUND, "rod", mbsr_joint_revolute(NULL, NULL, x),
             mbsr_inertia_point_mass(mass, below));
    add_force(m, mbsr_force_gravity(0, 0, -weight));
    mbsr_force_def side =
        mbsr_force_point_spring(MBSR_GROUND, wall, 0, below, stiffness, damping, 1.0);
    side.name = "side";
    add_force(m, side);
    mbsr_data *d = finish(m);
    const mbsr_signal in = {.kind = MBSR_SIGNAL_JOINT};
    mbsr_signal output[2];
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    opt.inputs = 1, opt.outputs = 2;
    opt.input = &in, opt.output = output;
    mbsr_linear *l;
    const double q = 0.0, f = 0.4, square = length * length;
    double re[2], im[2];
    for (int k = 0; k < 2; ++k)
        assert_ok(mbsr_signal_find(m, NULL, out[k], output + k, NULL), NULL);
    assert_ok(mbsr_linear_create(m, d, 0.0, &q, NULL, &opt, &l, NULL), NULL);
    assert_ok(mbsr_linear_response(l, f, re, im), NULL);
    const double complex s = 2.0 * pi * f * I, spring = stiffness + damping * s,
                         turn = 1.0 /
                                (mass * square * s * s + spring * square + mass * weight * length);
    for (int k = 0; k < 2; ++k) {
        const double complex y = -spring * length * (k ? length : 1.0) * turn;
        assert_close(re[k], creal(y), 1e-9);
        assert_close(im[k], cimag(y), 1e-9);
    }
    mbsr_linear_destroy(l);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void what_there_is_not(void **state)
{
    (void)state;
    static const struct {
        const char *name, *text;
    } wrong[] = {{"mass", "names are"},
                 {"bodies.b.q", "no body 'b'"},
                 {"bodies.'a mass'.q[2]", "has no q[2]"},
                 {"bodies.'a mass'.w", "has no w"},
                 {"forces.spring.f[9]", "has no f[9]"},
                 {"forces.force1.f", "has no f"}, /* gravity */
                 {"forces.none.f", "no force element 'none'"},
                 {"bodies.'a mass", "names are"},
                 {"bodies.'a mass'", "names are"},
                 {"bodies.'a mass'.q[0]", "has no q[0]"},
                 {"bodies.'a mass'.q[1", "has no q[1"},
                 {"bodies.'a mass'.q[1]]", "has no q[1]]"},
                 {"bodies.'a mass'.q[x]", "has no q[x]"},
                 {"forces.spring.tau[7]", "has no tau[7]"},
                 {"forces.spring.rest", "has no rest"}}; /* without a list */
    mbsr_data *d;
    mbsr_model *m = make_hanging(&d);
    mbsr_error error;
    mbsr_signal signal;
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
        assert_int_equal(mbsr_signal_find(m, NULL, wrong[k].name, &signal, &error), MBSR_ERR_VALUE);
        assert_non_null(strstr(error.text, wrong[k].text));
    }
    assert_int_equal(mbsr_signal_find(m, NULL, NULL, &signal, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_signal_find(NULL, NULL, "q", &signal, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_signal_find(m, NULL, "q", NULL, &error), MBSR_ERR_NULL);
    static const struct {
        bool input;
        mbsr_signal signal;
        const char *text;
    } bad[] = {{true, {.kind = MBSR_SIGNAL_JOINT, .id = -1}, "no such joint rate: -1"},
               {false, {.kind = MBSR_SIGNAL_RATE, .id = 99}, "no such joint rate: 99"},
               {true, {.kind = MBSR_SIGNAL_RATE}, "of a kind that it cannot be"},
               {true, {.kind = MBSR_SIGNAL_PARAMETER}, "no parameter of the list"},
               {false, {.kind = MBSR_SIGNAL_PARAMETER}, "of a kind that it cannot be"},
               {true, {.kind = MBSR_SIGNAL_POINT}, "of a kind that it cannot be"},
               {false, {.kind = MBSR_SIGNAL_POINT, .point = {NAN}}, "not at a point: 0"},
               {false, {.kind = MBSR_SIGNAL_POINT, .id = -1}, "no such body or axis"},
               {false, {.kind = MBSR_SIGNAL_POINT, .id = 99}, "no such body or axis"},
               {false, {.kind = MBSR_SIGNAL_POINT, .part = -1}, "no such body or axis"},
               {false, {.kind = MBSR_SIGNAL_POINT, .part = 3}, "no such body or axis"},
               {true, {.kind = MBSR_SIGNAL_FORCE}, "of a kind that it cannot be"},
               {false, {.kind = MBSR_SIGNAL_FORCE, .part = -1}, "no number of an element"},
               {false, {.kind = MBSR_SIGNAL_FORCE, .part = 99}, "no number of an element"},
               {false, {.kind = MBSR_SIGNAL_MOTION}, "of a kind that it cannot be"},
               {true, {.kind = MBSR_SIGNAL_MOTION}, "no such motion"},
               {true, {.kind = MBSR_SIGNAL_MOTION, .id = 99}, "no such motion"},
               {true, {.kind = MBSR_SIGNAL_CLOSURE_MOTION}, "no such motion"},
               {true, {.kind = MBSR_SIGNAL_CLOSURE_MOTION, .part = -1}, "no such motion"},
               {true, {.kind = (mbsr_signal_kind)77}, "of a kind that it cannot be: 77"}};
    double q[8] = {0.0};
    for (size_t k = 0; k < 2 + sizeof bad / sizeof *bad; ++k) {
        mbsr_linear *l;
        mbsr_linear_opt opt = mbsr_default_linear_opt();
        const bool count = k >= sizeof bad / sizeof *bad, input = count ? k % 2 : bad[k].input;
        if (input) opt.inputs = 1, opt.input = count ? NULL : &bad[k].signal;
        if (!input) opt.outputs = count ? -1 : 1, opt.output = count ? NULL : &bad[k].signal;
        assert_int_equal(mbsr_linear_create(m, d, 0.0, q, NULL, &opt, &l, &error), MBSR_ERR_VALUE);
        assert_null(l);
        assert_contains(error.text, count ? "or no list of them" : bad[k].text);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- motions ---- */

static const double turning = 3.0;

static int stay(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    (void)t;
    s[0] = 0.2;
    sdot[0] = sddot[0] = 0.0;
    return 0;
}

static int turn(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    s[0] = turning * t;
    sdot[0] = turning;
    sddot[0] = 0.0;
    return 0;
}

/* A mass on a spring on a base that a joint moves, or a closure. */
static mbsr_model *make_moved_base(bool by_closure, mbsr_data **d)
{
    mbsr_model *m = empty();
    const double up[3] = {0, 0, 1};
    const mbsr_axis rise = {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 0, 1}, .driven = 1};
    add_body(m, MBSR_GROUND, "base",
             by_closure ? mbsr_joint_prismatic(NULL, NULL, up)
                        : mbsr_joint_compound(NULL, NULL, 1, &rise, stay, NULL),
             by_closure ? mbsr_inertia_particle(5.0) : mbsr_inertia_zero());
    add_body(m, 0, "mass", mbsr_joint_prismatic(NULL, NULL, up), mbsr_inertia_particle(mass));
    mbsr_force_def spring = mbsr_force_joint_spring(1, 0, stiffness, damping, 0.0);
    spring.name = "spring";
    add_force(m, spring);
    add_force(m, mbsr_force_gravity(0, 0, -weight));
    if (by_closure) {
        mbsr_closure_def drive = mbsr_closure_rows(0, NULL, MBSR_GROUND, NULL, 1, up);
        drive.name = "drive";
        drive.motion = stay;
        assert_ok(mbsr_model_add_closure(m, &drive, NULL), mbsr_model_error(m));
    }
    *d = finish(m);
    return m;
}

static void expect(double complex y, double re, double im, double scale)
{
    assert_close(re, creal(y), 1e-9 * scale);
    assert_close(im, cimag(y), 1e-9 * scale);
}

/* m (x" + w) + d x' + k x = -m g with w the base's acceleration: x, x', heights, and the force. */
static void a_base_that_moves(void **state)
{
    (void)state;
    static const char *const in[] = {"bodies.base.motion", "closures.drive.motion[1]"},
                             *const out[] = {"bodies.mass.q", "bodies.mass.u", "bodies.mass.z",
                                             "bodies.base.z", "forces.spring.tau"};
    for (int by_closure = 0; by_closure < 2; ++by_closure) {
        mbsr_data *d;
        mbsr_model *m = make_moved_base(by_closure, &d);
        mbsr_signal input, output[OUTPUTS];
        mbsr_error error;
        assert_ok(mbsr_signal_find(m, NULL, in[by_closure], &input, &error), &error);
        for (int k = 0; k < OUTPUTS; ++k)
            assert_ok(mbsr_signal_find(m, NULL, out[k], output + k, &error), &error);
        mbsr_linear_opt opt = mbsr_default_linear_opt();
        opt.inputs = 1, opt.outputs = OUTPUTS;
        opt.input = &input, opt.output = output;
        const double sag = -mass * weight / stiffness, q[2] = {by_closure ? 0.2 : sag, sag};
        mbsr_linear *l;
        mbsr_linear_info info;
        assert_ok(mbsr_linear_create(m, d, 0.0, q, NULL, &opt, &l, &error), &error);
        assert_ok(mbsr_linear_get_info(l, &info), NULL);
        assert_int_equal(info.states, 4); /* x and x', value and rate of the motion */
        for (int k = 1; k < 5; ++k) {
            double re[OUTPUTS], im[OUTPUTS];
            const double f = 0.3 * k;
            const double complex p = 2.0 * pi * f * I,
                                 x = -mass / ((mass * p + damping) * p + stiffness);
            assert_ok(mbsr_linear_response(l, f, re, im), NULL);
            expect(x, re[0], im[0], 1.0);
            expect(p * x, re[1], im[1], 1.0);
            expect(x + 1.0 / (p * p), re[2], im[2], 1.0);
            expect(1.0 / (p * p), re[3], im[3], 1.0);
            expect(-(stiffness + damping * p) * x, re[4], im[4], stiffness);
        }
        mbsr_linear_destroy(l);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* A bead on a spring in a tube that turns: m r" + d r' + k (r - r0) = m v^2 r, v' = w. */
static void a_tube_that_turns(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    const double out[3] = {1, 0, 0}, r0 = 0.4;
    const mbsr_axis spin = {.kind = MBSR_AXIS_ROTATION, .direction = {0, 0, 1}, .driven = 1};
    add_body(m, MBSR_GROUND, "tube", mbsr_joint_compound(NULL, NULL, 1, &spin, turn, NULL),
             mbsr_inertia_zero());
    add_body(m, 0, "bead", mbsr_joint_prismatic(NULL, NULL, out), mbsr_inertia_particle(mass));
    add_force(m, mbsr_force_joint_spring(1, 0, stiffness, damping, r0));
    mbsr_data *d = finish(m);
    mbsr_signal input, output;
    mbsr_error error;
    assert_ok(mbsr_signal_find(m, NULL, "bodies.tube.motion", &input, &error), &error);
    assert_ok(mbsr_signal_find(m, NULL, "bodies.bead.q", &output, &error), &error);
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    opt.inputs = opt.outputs = 1;
    opt.input = &input, opt.output = &output;
    const double softer = stiffness - mass * turning * turning, r = stiffness * r0 / softer;
    mbsr_linear *l;
    assert_ok(mbsr_linear_create(m, d, 0.0, &r, NULL, &opt, &l, &error), &error);
    double re, im;
    assert_ok(mbsr_linear_response(l, 0.7, &re, &im), NULL);
    const double complex p = 2.0 * pi * 0.7 * I;
    expect(2.0 * mass * turning * r / (((mass * p + damping) * p + softer) * p), re, im, 1.0);
    mbsr_linear_destroy(l);
    input.part = 1;
    assert_int_equal(mbsr_linear_create(m, d, 0.0, &r, NULL, &opt, &l, &error), MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "input 0"));
    assert_int_equal(mbsr_signal_find(m, NULL, "bodies.bead.motion", &input, &error),
                     MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "has no motion"));
    opt.outputs = 1, opt.inputs = 0, output = input;
    assert_int_equal(mbsr_linear_create(m, d, 0.0, &r, NULL, &opt, &l, &error), MBSR_ERR_VALUE);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void motions_that_cannot_be_replaced(void **state)
{
    (void)state;
    mbsr_data *d;
    mbsr_model *m = make_moved_base(true, &d), *copy;
    assert_int_equal(mbsr_model_drive(NULL, 0, stay, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_drive_closure(NULL, 0, stay, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_drive(m, 0, stay, NULL), MBSR_ERR_FINISHED);
    assert_int_equal(mbsr_model_drive_closure(m, 0, stay, NULL), MBSR_ERR_FINISHED);
    assert_ok(mbsr_model_copy(m, &copy, NULL), NULL);
    assert_int_equal(mbsr_model_drive(copy, 0, stay, NULL), MBSR_ERR_VALUE);
    assert_non_null(strstr(mbsr_model_error(copy)->text, "base"));
    assert_int_equal(mbsr_model_drive(copy, 7, stay, NULL), MBSR_ERR_ID);
    assert_int_equal(mbsr_model_drive_closure(copy, 1, stay, NULL), MBSR_ERR_ID);
    assert_int_equal(mbsr_model_drive_closure(copy, 0, NULL, NULL), MBSR_ERR_NULL);
    assert_non_null(strstr(mbsr_model_error(copy)->text, "drive"));
    assert_ok(mbsr_model_drive_closure(copy, 0, turn, NULL), mbsr_model_error(copy));
    mbsr_model_destroy(copy);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* user: the place along x. */
static int stand(void *user, double t, double *s, double *rate, double *acceleration)
{
    (void)t;
    *s = *(const double *)user;
    *rate = *acceleration = 0.0;
    return 0;
}

static int stand_in_plane(void *user, double t, double *s, double *rate, double *acceleration)
{
    s[1] = rate[1] = acceleration[1] = 0.0;
    return stand(user, t, s, rate, acceleration);
}

enum { IN_PLANE, BY_JOINT, BY_CLOSURE, WAYS };

/* A shaker along x (in the plane along x and y) that carries a rod on a hinge. */
static void add_shaker(mbsr_model *m, int way, double unit, double *place)
{
    const double square = unit * unit, com[3] = {0.2 * unit, 0.0, 0.0}, z[3] = {0, 0, 1},
                 tensor[6] = {0.03 * square, 0.03 * square, 0.03 * square, 0, 0, 0};
    const mbsr_planar_frame none = {0};
    const mbsr_axis driven = {.kind = MBSR_AXIS_TRANSLATION, .direction = {1, 0, 0}, .driven = 1};
    if (way == IN_PLANE) {
        add_body(m, MBSR_GROUND, "shaker",
                 mbsr_joint_planar(none, none, 0, MBSR_X | MBSR_Y, stand_in_plane, place),
                 mbsr_inertia_planar(3.0, NULL, 0.1 * square));
        add_body(m, 0, "rod", mbsr_joint_planar_revolute(none, none),
                 mbsr_inertia_planar(2.0, com, tensor[MBSR_ZZ]));
        return;
    }
    add_body(m, MBSR_GROUND, "shaker",
             way == BY_JOINT ? mbsr_joint_compound(NULL, NULL, 1, &driven, stand, place)
                             : mbsr_joint_prismatic(NULL, NULL, driven.direction),
             mbsr_inertia_particle(3.0));
    add_body(m, 0, "rod", mbsr_joint_revolute(NULL, NULL, z), mbsr_inertia_rigid(2.0, com, tensor));
    if (way == BY_JOINT) return;
    mbsr_closure_def drive = mbsr_closure_rows(0, NULL, MBSR_GROUND, NULL, 1, driven.direction);
    drive.motion = stand;
    drive.user = place;
    assert_ok(mbsr_model_add_closure(m, &drive, NULL), mbsr_model_error(m));
}

/* A spring holds the rod across: how its angle answers the shaker's acceleration, along x and in
 * the plane then along y, times the metre. */
static void shake(int way, double unit, double answer[4])
{
    const int inputs = way == IN_PLANE ? 2 : 1, angle = way == BY_CLOSURE ? 1 : 0;
    const double tip[3] = {0.3 * unit, 0.0, 0.0}, spot[3] = {0.6 * unit, 0.3 * unit, 0.0},
                 q[2] = {angle ? 0.4 * unit : 0.1, 0.1};
    const mbsr_signal_kind kind =
        way == BY_CLOSURE ? MBSR_SIGNAL_CLOSURE_MOTION : MBSR_SIGNAL_MOTION;
    const mbsr_signal input[2] = {{.kind = kind}, {.kind = kind, .part = 1}},
                      output = {.kind = MBSR_SIGNAL_JOINT, .id = angle};
    mbsr_model *m = empty();
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    mbsr_linear *l;
    mbsr_error error;
    double place = 0.4 * unit;
    add_shaker(m, way, unit, &place);
    add_force(m, mbsr_force_point_spring(1, tip, MBSR_GROUND, spot, 400.0, 5.0, 0.1 * unit));
    mbsr_data *d = finish(m);
    /* radii of gyration about the origins: sqrt(0.1 / 3), and sqrt(0.03 / 2 + 0.2^2) */
    if (way == IN_PLANE)
        assert_close(mbsr_model_length(m) / unit, pow(0.1 / 3.0 * 0.055, 0.25), 1e-12);
    opt.inputs = inputs, opt.outputs = 1;
    opt.input = input, opt.output = &output;
    assert_ok(mbsr_linear_create(m, d, 0.0, q, NULL, &opt, &l, &error), &error);
    assert_ok(mbsr_linear_response(l, 0.7, answer, answer + 2), NULL);
    for (int k = 0; k < 4; ++k) answer[k] *= unit;
    mbsr_linear_destroy(l);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void a_shaker_in_all_units(void **state)
{
    (void)state;
    double answer[4], other[4];
    shake(IN_PLANE, 1.0, answer);
    for (double unit = 1e-6; unit < 1e10; unit *= 10.0) {
        for (int way = 0; way < WAYS; ++way) {
            shake(way, unit, other);
            for (int k = 0; k < 4; k += way == IN_PLANE ? 1 : 2)
                assert_close(other[k] / answer[k], 1.0, 1e-8);
        }
    }
}

/* A cart with friction and a rod on a hinge, which a spring holds from a point above: how the
 * friction answers a push at the cart, and the angle that the point moves aside, in SI. */
static void pull(double metre, double second, double answer[4])
{
    const double square = metre * metre, force = metre / (second * second), mu = 5.0 * force,
                 slip = 2e-3 * metre / second, x[3] = {1, 0, 0}, z[3] = {0, 0, 1},
                 com[3] = {0.2 * metre, 0.0, 0.0}, tip[3] = {0.3 * metre, 0.0, 0.0},
                 above[3] = {0.0, 0.5 * metre, 0.0}, none[3] = {0.0},
                 tensor[6] = {0.03 * square, 0.03 * square, 0.03 * square, 0, 0, 0},
                 q[2] = {0.0, 0.4};
    static const char *const in[2] = {"bodies.cart.tau", "forces.spring.point_b[1]"},
                             *const out[2] = {"forces.friction.tau", "bodies.rod.q"};
    mbsr_model *m = empty();
    mbsr_parameters *list;
    mbsr_signal input[2], output[2];
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    mbsr_linear *l;
    mbsr_error error;
    double re[4], im[4];
    add_body(m, MBSR_GROUND, "cart", mbsr_joint_prismatic(NULL, NULL, x),
             mbsr_inertia_rigid(3.0, none, tensor));
    add_body(m, MBSR_GROUND, "rod", mbsr_joint_revolute(NULL, NULL, z),
             mbsr_inertia_rigid(2.0, com, tensor));
    mbsr_force_def friction = mbsr_force_joint_friction(0, 0, mu, slip),
                   spring =
                       mbsr_force_point_spring(1, tip, MBSR_GROUND, above, 400.0 * force / metre,
                                               5.0 * force * second / metre, 0.1 * metre);
    friction.name = "friction", spring.name = "spring";
    add_force(m, friction), add_force(m, spring);
    add_force(m, mbsr_force_joint_spring(0, 0, 90.0 * force / metre, 0.0, 0.0));
    mbsr_data *d = finish(m);
    assert_ok(mbsr_parameters_create(m, &list, &error), &error);
    for (int k = 0; k < 2; ++k) {
        assert_ok(mbsr_signal_find(m, list, in[k], input + k, &error), &error);
        assert_ok(mbsr_signal_find(m, list, out[k], output + k, &error), &error);
    }
    opt.inputs = opt.outputs = 2;
    opt.input = input, opt.output = output, opt.list = list;
    assert_ok(mbsr_linear_create(m, d, 0.0, q, NULL, &opt, &l, &error), &error);
    assert_ok(mbsr_linear_response(l, 0.7 / second, re, im), NULL);
    answer[0] = re[0], answer[1] = im[0];
    answer[2] = re[3] * metre, answer[3] = im[3] * metre;
    mbsr_linear_destroy(l);
    mbsr_parameters_destroy(list);
    free_both(m, d);
}

static void differences_in_all_units(void **state)
{
    (void)state;
    double answer[4], other[4];
    pull(1.0, 1.0, answer);
    const double complex s = 2.0 * pi * 0.7 * I, c = 5.0 / 2e-3 * s,
                         friction = -c / (3.0 * s * s + c + 90.0);
    assert_close(answer[0], creal(friction), 1e-6);
    assert_close(answer[1], cimag(friction), 1e-6);
    assert_true(hypot(answer[2], answer[3]) > 0.1);
    for (double unit = 1e-4; unit < 1e5; unit *= 100.0) {
        for (int of = 0; of < 2; ++of) {
            pull(of ? 1.0 : unit, of ? unit : 1.0, other);
            for (int k = 0; k < 4; ++k) assert_close(other[k], answer[k], 1e-7);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_mass_on_a_spring),
                                       cmocka_unit_test(a_point_and_a_rate),
                                       cmocka_unit_test(a_force_and_a_moment),
                                       cmocka_unit_test(what_there_is_not),
                                       cmocka_unit_test(a_base_that_moves),
                                       cmocka_unit_test(a_tube_that_turns),
                                       cmocka_unit_test(motions_that_cannot_be_replaced),
                                       cmocka_unit_test(a_shaker_in_all_units),
                                       cmocka_unit_test(differences_in_all_units)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

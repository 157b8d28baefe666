/* Rods, points and solids on and beside the axes of joints, and light bodies before heavy ones: no
 * mass where by reasoning there is none, the right one where there is, in any position and system
 * of units.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "duration.h"
#include "body.h"

#include <mbsrank/mbsrank.h>

#include <math.h>

/* Length and mass in units of metres and kilograms: SI; mm, t; km, kg; mm, g. */
static const double units[4][2] = {{1.0, 1.0}, {1e3, 1e-3}, {1e-3, 1.0}, {1e3, 1e3}};

static mbsr_model *begin(void)
{
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    return m;
}

static mbsr_data *finish(mbsr_model *m)
{
    mbsr_data *d = NULL;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    return d;
}

/* Rank of the first joint by the stages. */
static int rank_of(const mbsr_model *m, mbsr_data *d, const double *q, const double *u)
{
    mbsr_rank_info info;
    assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_stage_forces(m, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_stage_backward(m, d), mbsr_data_error(d));
    assert_ok(mbsr_body_rank(m, d, 0, &info), mbsr_data_error(d));
    return info.rank;
}

/* A rod from the origin to p, tilted from z by `tilt`, turns about itself or about z; with
 * `carried` it is fixed to a body without mass that does. */
static void try_rod(const double unit[2], double tilt, int beside, int carried)
{
    const double length = unit[0], mass = 2.0 * unit[1], origin[3] = {0.0, 0.0, 0.0},
                 p[3] = {0.3 * tilt * length, 0.4 * tilt * length, 0.7 * length},
                 z[3] = {0.0, 0.0, length};
    const mbsr_inertia rod = mbsr_inertia_rod(mass, origin, p);
    const mbsr_joint joint = mbsr_joint_revolute(NULL, NULL, beside ? z : p);
    mbsr_model *m = begin();
    const int first = test_add_body(m, MBSR_GROUND, joint, carried ? mbsr_inertia_zero() : rod);
    if (carried) test_add_body(m, first, mbsr_joint_weld(NULL, NULL), rod);
    mbsr_data *d = finish(m);
    const double moment = mass * (p[0] * p[0] + p[1] * p[1]) / 3.0;
    for (int k = 0; k < 12; ++k) {
        const double q = 0.55 * k, u = 0.0, tau = moment;
        double udot = 0.0;
        const int status = mbsr_forward_dynamics(m, d, 0.0, &q, &u, &tau, &udot);
        if (beside) {
            assert_ok(status, mbsr_data_error(d));
            assert_close(udot, 1.0, 2e-9);
        } else {
            assert_int_equal(status, MBSR_UNDETERMINED);
        }
        assert_int_equal(rank_of(m, d, &q, &u), beside);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void a_rod_has_no_moment_about_itself(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        for (double tilt = 1.0; tilt > 0.5e-9; tilt *= 0.1) {
            for (int carried = 0; carried < 2; ++carried) {
                try_rod(units[k], tilt, 0, carried);
                if (tilt > 0.5e-6) try_rod(units[k], tilt, 1, carried);
            }
        }
    }
}

/* Two of three rotations of a rod on a ball joint move it, wherever it points. */
static void a_rod_on_a_ball_joint(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        for (double tilt = 1.0; tilt > 0.5e-9; tilt *= 0.1) {
            const double l = units[k][0], origin[3] = {0.0, 0.0, 0.0},
                         p[3] = {0.3 * tilt * l, 0.4 * tilt * l, 0.7 * l};
            mbsr_model *m = begin();
            test_add_body(m, MBSR_GROUND, mbsr_joint_spherical(NULL, NULL),
                          mbsr_inertia_rod(2.0 * units[k][1], origin, p));
            mbsr_data *d = finish(m);
            for (int turn = 0; turn < 12; ++turn) {
                const double q[4] = {cos(0.3 * turn), sin(0.3 * turn), 0.0, 0.1 * turn},
                             u[3] = {0.0, 0.0, 0.0};
                assert_int_equal(rank_of(m, d, q, u), 2);
            }
            mbsr_data_destroy(d);
            mbsr_model_destroy(m);
        }
    }
}

/* ---- random ones ---- */

static void direction(test_rng *rng, double a[3])
{
    double square;
    do {
        test_fill(rng, 3, a);
        square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    } while (square > 1.0 || square < 0.01);
    for (int k = 0; k < 3; ++k) a[k] /= sqrt(square);
}

/* across: of unit length, orthogonal to a. */
static void orthogonal(test_rng *rng, const double a[3], double across[3])
{
    direction(rng, across);
    const double along = a[0] * across[0] + a[1] * across[1] + a[2] * across[2];
    double square = 0.0;
    for (int k = 0; k < 3; ++k) {
        across[k] -= along * a[k];
        square += across[k] * across[k];
    }
    for (int k = 0; k < 3; ++k) across[k] /= sqrt(square);
}

static bool chance(test_rng *rng, double share)
{
    return test_uniform(rng) < 2.0 * share - 1.0;
}

static double positive(test_rng *rng)
{
    return 0.6 + 0.5 * test_uniform(rng);
}

/* From 1 down to 10^-decades. */
static double small(test_rng *rng, double decades)
{
    return pow(10.0, -0.5 * decades * (1.0 + test_uniform(rng)));
}

/* What lies near a line through the origin: ends p and r of a rod, or points there. */
typedef struct thing {
    double axis[3], across[3], p[3], r[3], mass, ratio; /* ratio 0: on the line */
    int kind;
    mbsr_inertia inertia;
} thing;

enum { POINT, ROD, POINTS, POINTS_AND_BALLAST, KINDS };

static thing random_thing(test_rng *rng, const double unit[2])
{
    thing x;
    direction(rng, x.axis);
    orthogonal(rng, x.axis, x.across);
    const double l = positive(rng) * unit[0];
    x.mass = positive(rng) * unit[1];
    x.ratio = chance(rng, 0.3) ? 0.0 : small(rng, 6.0);
    for (int k = 0; k < 3; ++k) {
        x.p[k] = l * (x.axis[k] + x.ratio * x.across[k]);
        x.r[k] = -0.7 * l * (x.axis[k] - 0.5 * x.ratio * x.across[k]);
    }
    for (int k = 0; k < 3 && x.ratio <= 0.0; ++k) { /* to the last digit */
        x.axis[k] = x.p[k];
        x.r[k] = -0.5 * x.p[k];
    }
    x.kind = test_integer(rng, 0, KINDS - 1);
    const mbsr_inertia p = mbsr_inertia_point_mass(x.mass, x.p),
                       r = mbsr_inertia_point_mass(0.3 * x.mass, x.r),
                       ballast = mbsr_inertia_particle(2.0 * x.mass);
    x.inertia = x.kind == POINT    ? p
                : x.kind == ROD    ? mbsr_inertia_rod(x.mass, x.p, x.r)
                : x.kind == POINTS ? mbsr_inertia_sum(p, r)
                                   : mbsr_inertia_sum(mbsr_inertia_sum(p, r), ballast);
    return x;
}

/* |a x p|^2 / |a|^2; to 1e-10 down to 1e-6 |p|^2 */
static double distance2(const double a[3], const double p[3])
{
    double square = 0.0, length = 0.0;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double c = fma(a[i], p[j], -a[j] * p[i]) - fma(a[j], p[i], -a[j] * p[i]);
        square += c * c;
        length += a[k] * a[k];
    }
    return square / length;
}

static double moment_of(const thing *x)
{
    double sum[3];
    for (int k = 0; k < 3; ++k) sum[k] = x->p[k] + x->r[k];
    const double p = distance2(x->axis, x->p), r = distance2(x->axis, x->r),
                 middle = distance2(x->axis, sum);
    return x->mass * (x->kind == POINT ? p : x->kind == ROD ? (p + r + middle) / 6.0 : p + 0.3 * r);
}

/* Joint force, energy and momentum of a joint alone that turns with rate 1, or acceleration 1,
 * about the axis of this moment; k: its coordinate among those. */
static void assert_moment(const mbsr_model *m, mbsr_data *d, const double *q, int k, double moment)
{
    double u[2] = {0.0}, udot[2] = {0.0}, tau[2], p[2], many[2], kinetic;
    mbsr_batch *batch = NULL;
    const int nu = mbsr_model_nu(m);
    udot[k] = 1.0;
    assert_ok(mbsr_inverse_dynamics(m, d, 0.0, q, u, udot, NULL, tau), mbsr_data_error(d));
    assert_close(tau[k] / moment, 1.0, 2e-9);
    assert_ok(mbsr_batch_create(m, &batch, NULL), NULL);
    assert_ok(mbsr_batch_inverse_dynamics(m, batch, 0.0, 1, q, u, udot, many, NULL), NULL);
    assert_close(many[k] / moment, 1.0, 2e-9);
    mbsr_batch_destroy(batch);
    u[k] = 1.0;
    assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_energy(m, d, &kinetic, NULL), mbsr_data_error(d));
    assert_close(kinetic / moment, 0.5, 1e-9);
    assert_int_equal(nu, k + 1);
    assert_ok(mbsr_momenta(m, d, p), mbsr_data_error(d));
    assert_close(p[k] / moment, 1.0, 2e-9);
}

/* On a revolute joint, alone, on a body without mass, or on one from which it is far. */
static void try_thing(test_rng *rng, const double unit[2])
{
    const thing x = random_thing(rng, unit);
    const int carried = test_integer(rng, 0, 1);
    double at[3], q = 3.0 * test_uniform(rng), u = 0.0, udot = 0.0;
    test_fill(rng, 3, at);
    for (int k = 0; k < 3; ++k) at[k] *= unit[0];
    const mbsr_frame frame = mbsr_frame_rotated(at, x.across, 3.0 * test_uniform(rng));
    mbsr_model *m = begin();
    const mbsr_joint joint = mbsr_joint_revolute(&frame, NULL, x.axis);
    const int first =
        test_add_body(m, MBSR_GROUND, joint, carried ? mbsr_inertia_zero() : x.inertia);
    if (carried) test_add_body(m, first, mbsr_joint_weld(NULL, NULL), x.inertia);
    mbsr_data *d = finish(m);
    const double tau = x.ratio > 0.0 ? moment_of(&x) : x.mass * unit[0] * unit[0];
    const int status = mbsr_forward_dynamics(m, d, 0.0, &q, &u, &tau, &udot);
    double inertia = 0.0;
    assert_ok(mbsr_stage_positions(m, d, 0.0, &q), mbsr_data_error(d));
    assert_ok(mbsr_mass_matrix(m, d, &inertia), mbsr_data_error(d));
    if (x.ratio > 0.0) {
        assert_ok(status, mbsr_data_error(d));
        assert_close(udot, 1.0, 2e-9);
        assert_close(inertia / tau, 1.0, 2e-9);
        assert_moment(m, d, &q, 0, tau);
    } else {
        assert_true(inertia <= 1e-28 * tau);
        assert_int_equal(status, MBSR_UNDETERMINED);
    }
    assert_int_equal(rank_of(m, d, &q, &u), x.ratio > 0.0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void things_beside_the_axis_of_a_revolute(void **state)
{
    (void)state;
    test_rng rng = test_seed(1301);
    const int count = test_long() ? 1000000 : test_seeds_short(2000, 10000);
    for (int l = 0; l < count; ++l) try_thing(&rng, units[l % 4]);
}

/* About the second axis of a universal joint, or about an oblique one by a ball joint. */
static void try_oblique(test_rng *rng, const double unit[2])
{
    thing x = random_thing(rng, unit);
    if (!(x.ratio > 0.0)) return;
    const double moment = moment_of(&x), q[2] = {test_uniform(rng), 3.0 * test_uniform(rng)};
    mbsr_model *m = begin();
    test_add_body(m, MBSR_GROUND, mbsr_joint_universal(NULL, NULL, x.across, x.axis), x.inertia);
    mbsr_data *d = finish(m);
    assert_moment(m, d, q, 1, moment);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);

    m = begin();
    test_add_body(m, MBSR_GROUND, mbsr_joint_spherical(NULL, NULL), x.inertia);
    d = finish(m);
    const double start[4] = {1.0, 0.0, 0.0, 0.0}, rest[3] = {0.0};
    double tau[3], kinetic;
    assert_ok(mbsr_inverse_dynamics(m, d, 0.0, start, rest, x.axis, NULL, tau), mbsr_data_error(d));
    double about = 0.0;
    for (int k = 0; k < 3; ++k) about += tau[k] * x.axis[k];
    assert_close(about / moment, 1.0, 2e-9);
    assert_ok(mbsr_stage_positions(m, d, 0.0, start), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, x.axis), mbsr_data_error(d));
    assert_ok(mbsr_energy(m, d, &kinetic, NULL), mbsr_data_error(d));
    assert_close(kinetic / moment, 0.5, 1e-9);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void things_beside_oblique_axes(void **state)
{
    (void)state;
    test_rng rng = test_seed(1305);
    const int count = test_long() ? 1000000 : test_seeds_short(2000, 10000);
    for (int l = 0; l < count; ++l) try_oblique(&rng, units[l % 4]);
}

/* Two points, two rods, or a cylinder on a ball or universal joint: all rotations move it unless it
 * lies on a line. */
static void try_turning(test_rng *rng, const double unit[2])
{
    thing x = random_thing(rng, unit);
    const bool ball = chance(rng, 0.5), on_line = !(x.ratio > 0.0);
    const double origin[3] = {0.0, 0.0, 0.0}, pi = 3.14159265358979323846,
                 radius = x.ratio * unit[0], length = unit[0];
    switch (test_integer(rng, 0, 2)) {
    case 0:
        x.inertia = mbsr_inertia_sum(mbsr_inertia_point_mass(x.mass, x.p),
                                     mbsr_inertia_point_mass(x.mass, x.r));
        break;
    case 1:
        x.inertia = mbsr_inertia_sum(mbsr_inertia_rod(x.mass, origin, x.p),
                                     mbsr_inertia_rod(x.mass, origin, x.r));
        break;
    default: {
        if (on_line) break;
        const mbsr_frame frame = mbsr_frame_along(x.p, x.axis);
        const double density = x.mass / (pi * radius * radius * length);
        x.inertia = mbsr_inertia_in_frame(&frame, mbsr_inertia_cylinder(density, radius, length));
    }
    }
    if (on_line) x.inertia = mbsr_inertia_rod(x.mass, x.r, x.p);
    double q[4], u[3] = {0.0};
    test_fill(rng, 4, q);
    for (int k = 0; k < 2 && !ball; ++k) q[k] *= 3.0;
    mbsr_model *m = begin();
    test_add_body(m, MBSR_GROUND,
                  ball ? mbsr_joint_spherical(NULL, NULL)
                       : mbsr_joint_universal(NULL, NULL, x.across, x.axis),
                  x.inertia);
    mbsr_data *d = finish(m);
    assert_int_equal(rank_of(m, d, q, u), (ball ? 3 : 2) - on_line);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void things_on_ball_and_universal_joints(void **state)
{
    (void)state;
    test_rng rng = test_seed(1302);
    const int count = test_long() ? 1000000 : test_seeds_short(2000, 10000);
    for (int l = 0; l < count; ++l) try_turning(&rng, units[l % 4]);
}

/* A light body before one to three heavy ones, all along or about one axis. */
static void try_train(test_rng *rng, const double unit[2])
{
    double axis[3], q[4], u[4] = {0.0}, tau[4] = {0.0}, udot[4] = {0.0};
    const double none[3] = {0.0, 0.0, 0.0}, area = unit[0] * unit[0];
    const bool turns = chance(rng, 0.5), nothing = chance(rng, 0.3);
    const int heavy = test_integer(rng, 1, 3);
    direction(rng, axis);
    test_fill(rng, 4, q);
    for (int k = 0; k < 4; ++k) q[k] *= turns ? 3.0 : unit[0];
    const double mass[2] = {nothing ? 0.0 : unit[1] * small(rng, 14.0), unit[1] * positive(rng)};
    mbsr_model *m = begin();
    int last = MBSR_GROUND;
    for (int k = 0; k <= heavy; ++k) {
        const double is = mass[k > 0], moment = is * area,
                     tensor[6] = {moment, moment, moment, 0.0, 0.0, 0.0};
        last = test_add_body(
            m, last,
            turns ? mbsr_joint_revolute(NULL, NULL, axis) : mbsr_joint_prismatic(NULL, NULL, axis),
            turns ? mbsr_inertia_rigid(is, none, tensor) : mbsr_inertia_particle(is));
    }
    mbsr_data *d = finish(m);
    tau[0] = mass[0] * (turns ? area : 1.0);
    const int status = mbsr_forward_dynamics(m, d, 0.0, q, u, tau, udot);
    if (nothing) {
        assert_int_equal(status, MBSR_UNDETERMINED);
    } else {
        assert_ok(status, mbsr_data_error(d));
        assert_close(udot[0], 1.0, 2e-9);
    }
    assert_int_equal(rank_of(m, d, q, u), !nothing);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void light_bodies_before_heavy_ones(void **state)
{
    (void)state;
    test_rng rng = test_seed(1303);
    const int count = test_long() ? 1000000 : test_seeds_short(1000, 5000);
    for (int l = 0; l < count; ++l) try_train(&rng, units[l % 4]);
}

/* A tensor of six rounded entries does not tell a moment of 1e-14 of the others from none; one of
 * 1e-10 it does, to six digits. */
static void rounded_tensors_count_as_rounded(void **state)
{
    (void)state;
    test_rng rng = test_seed(1304);
    for (int l = 0; l < 400; ++l) {
        thing x;
        do x = random_thing(&rng, units[l % 4]);
        while (x.kind != POINT || !(x.ratio > 0.0));
        const double e = l % 8 < 4 ? 1e-7 : 1e-5, p[3] = {0.0};
        double com[3], tensor[6], length = 0.0;
        for (int k = 0; k < 3; ++k) {
            com[k] = units[l % 4][0] * (x.axis[k] + e * x.across[k]);
            length += com[k] * com[k];
        }
        for (int k = 0; k < 3; ++k) tensor[k] = x.mass * (length - com[k] * com[k]);
        tensor[MBSR_XY] = -x.mass * com[0] * com[1];
        tensor[MBSR_XZ] = -x.mass * com[0] * com[2];
        tensor[MBSR_YZ] = -x.mass * com[1] * com[2];
        mbsr_model *m = begin();
        test_add_body(m, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, x.axis),
                      mbsr_inertia_rigid(x.mass, p, tensor));
        mbsr_data *d = finish(m);
        const double q = 3.0 * test_uniform(&rng), u = 0.0;
        assert_int_equal(rank_of(m, d, &q, &u), e > 1e-6);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rod_has_no_moment_about_itself),
        cmocka_unit_test(a_rod_on_a_ball_joint),
        cmocka_unit_test(things_beside_the_axis_of_a_revolute),
        cmocka_unit_test(things_beside_oblique_axes),
        cmocka_unit_test(things_on_ball_and_universal_joints),
        cmocka_unit_test(light_bodies_before_heavy_ones),
        cmocka_unit_test(rounded_tensors_count_as_rounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The same motion in other units takes the same steps.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "units.h"

#include <mbsrank/ida.h>

#include <ida/ida.h>

#include <stdbool.h>

enum { RODS = 4, SIZE = 3 * RODS };

enum { SYSTEMS = sizeof systems / sizeof systems[0] };

/* A sledge that carries rods on springs, the second without mass; or nothing but a pendulum that
 * hangs at rest. */
static mbsr_model *make(const units *in, int hangs)
{
    const double L = in->length, M = in->mass, T = in->time, torque = M * L * L / (T * T);
    const double com[2] = {0.1 * L, 0.0}, down[2] = {0.0, -0.1 * L};
    const mbsr_planar_frame here = {0.0, 0.0, 0.0}, tip = {0.2 * L, 0.0, 0.0};
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < (hangs ? 1 : RODS); ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = k == 0 && !hangs ? mbsr_joint_planar_prismatic(here, here)
                                      : mbsr_joint_planar_revolute(k > 1 ? tip : here, here);
        body.inertia = k == 2 ? mbsr_inertia_zero()
                              : mbsr_inertia_planar(0.5 * M, hangs ? down : com, 2e-3 * M * L * L);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        const double unit = k == 0 ? M / (T * T) : torque;
        const mbsr_force_def spring =
            mbsr_force_joint_spring(k, 0, 30.0 * unit, 0.3 * unit * T, 0.0);
        if (!hangs) assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81 * L / (T * T), 0.0);
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

typedef struct outcome {
    long steps, residuals;
    double first, angle; /* s, the first step; rad, at the end */
} outcome;

static outcome run(const units *in, int hangs, mbsr_dae_form form, mbsr_ida_solver solver)
{
    const double L = in->length, T = in->time;
    double q[RODS] = {0.05 * L, 0.3, -0.2, 0.1}, u[RODS] = {0.4 * L / T, 1.0 / T, 0.0, -2.0 / T};
    if (hangs) q[0] = u[0] = 0.0;
    double y[SIZE], yp[SIZE];
    outcome o = {0};
    mbsr_model *m = make(in, hangs);
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = form;
    opt.linear_solver = solver;
    opt.atol_angle = 1e-6;
    opt.atol_length = 1e-6 * L;
    opt.atol_angular_velocity = 1e-6 / T;
    opt.atol_velocity = 1e-6 * L / T;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, form, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, form, 0.0, y, yp, NULL, NULL), mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 1.0 * T, NULL, y, NULL), mbsr_ida_error(ida));
    assert_int_equal(IDAGetActualInitStep(mbsr_ida_memory(ida), &o.first), IDA_SUCCESS);
    mbsr_ida_stats stats;
    assert_int_equal(mbsr_ida_get_stats(ida, &stats), MBSR_OK);
    o.steps = stats.steps;
    o.residuals = stats.residuals;
    o.first /= T;
    o.angle = y[hangs ? 0 : 1];
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return o;
}

static void steps_do_not_depend_on_units(void **state)
{
    (void)state;
    static const struct {
        mbsr_dae_form form;
        mbsr_ida_solver solver;
    } way[] = {{MBSR_DAE_MOMENTUM, MBSR_IDA_TREE},
               {MBSR_DAE_MOMENTUM, MBSR_IDA_DENSE},
               {MBSR_DAE_INDEX1, MBSR_IDA_DENSE},
               {MBSR_DAE_RECURSIVE, MBSR_IDA_DENSE}};
    for (size_t w = 0; w < sizeof way / sizeof way[0]; ++w) {
        for (int hangs = 0; hangs < 2; ++hangs) {
            outcome si = {0};
            for (int s = 0; s < SYSTEMS; ++s) {
                const outcome o = run(systems + s, hangs, way[w].form, way[w].solver);
                print_message("%s: first step %.6g s, %ld steps, %ld residuals, angle %.8f\n",
                              systems[s].name, o.first, o.steps, o.residuals, o.angle);
                if (s == 0) si = o;
                assert_close(o.first / si.first, 1.0, 1e-6);
                assert_close(o.angle, si.angle, 1e-7);
                assert_close((double)o.steps / (double)si.steps, 1.0, 0.03);
            }
            if (hangs) assert_close(si.first, 1e-3, 1e-12);
        }
    }
}

/* ---- closed loops ---- */

enum { LOOP_MOST = 200 };

static mbsr_frame at(const units *in, const double *x)
{
    return mbsr_frame_at(x[0] * in->length, x[1] * in->length, x[2] * in->length);
}

static mbsr_inertia lump(const units *in, double mass, const double *com)
{
    const double moment = 0.05 * mass * in->mass * in->length * in->length,
                 tensor[6] = {moment, 1.2 * moment, 0.7 * moment, 0.0, 0.0, 0.0};
    const mbsr_frame centre = at(in, com);
    return mbsr_inertia_rigid(mass * in->mass, centre.x, tensor);
}

static int add(mbsr_model *m, mbsr_joint joint, mbsr_inertia inertia, int parent)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

/* Two cranks, between them a rod on a ball joint and a cylindrical one, which is cut: its body has
 * no mass, turns and slides. */
static void add_spatial_loop(mbsr_model *m, const units *in)
{
    const double B[3] = {0.3, 0.1, 0.05}, C[3] = {0.3, 0.5, 0.3}, D[3] = {1.2, -0.1, 0.2},
                 back[3] = {-0.6, 0.7, 0.15}, half[3] = {0.15, 0.05, 0.0};
    const mbsr_frame ball = at(in, B), end = at(in, C), pivot = at(in, D), seen = at(in, back);
    const int crank = add(m, mbsr_joint_revolute(NULL, NULL, (double[3]){0.2, 0.1, 1.0}),
                          lump(in, 1.0, half), MBSR_GROUND),
              rod = add(m, mbsr_joint_spherical(&ball, NULL), lump(in, 2.0, half), crank),
              other = add(m, mbsr_joint_revolute(&pivot, NULL, (double[3]){0.6, -0.2, 0.8}),
                          lump(in, 1.5, half), MBSR_GROUND);
    const mbsr_joint cut = mbsr_joint_cylindrical(&end, NULL, (double[3]){0.7, 0.3, 0.9});
    assert_ok(mbsr_model_add_loop_joint(m, "cut", rod, &cut, other, &seen, NULL, NULL),
              mbsr_model_error(m));
}

/* The ends of rod k of five, on the ground and on what they carry. */
static void place_rod(int k, double a[3], double b[3])
{
    const double angle = 1.2566 * k;
    a[0] = cos(angle), a[1] = 0.8 * sin(angle), a[2] = 1.0 + 0.02 * k;
    b[0] = 0.6 * cos(angle + 0.5), b[1] = 0.5 * sin(angle + 0.5), b[2] = 0.1 * k;
}

/* A free body on five rods: three without mass, with a universal joint and a ball joint each; two
 * with next to no moment of inertia, on ball joints, which spin about themselves. */
static void add_carried(mbsr_model *m, const units *in)
{
    const double none[3] = {0.0};
    const int body = add(m, mbsr_joint_free(NULL, NULL), lump(in, 2.0, none), MBSR_GROUND);
    for (int k = 0; k < 5; ++k) {
        double a[3], b[3];
        place_rod(k, a, b);
        const double c[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, first[3] = {c[1], -c[0], 0.0},
                     second[3] = {c[0] * c[2], c[1] * c[2], -c[0] * c[0] - c[1] * c[1]};
        const mbsr_frame A = at(in, a), B = at(in, b), tip = at(in, c);
        const double small = 4e-5 * in->mass * in->length * in->length,
                     tensor[6] = {small, small, small, 0.0, 0.0, 0.0};
        const mbsr_inertia thin = mbsr_inertia_rigid(0.3 * in->mass, tip.x, tensor);
        const bool light = k < 3;
        const int rod = add(m,
                            light ? mbsr_joint_universal(&A, NULL, first, second)
                                  : mbsr_joint_spherical(&A, NULL),
                            light ? mbsr_inertia_zero() : thin, MBSR_GROUND);
        const mbsr_joint ball = mbsr_joint_spherical(&tip, NULL);
        assert_ok(mbsr_model_add_loop_joint(m, "ball", rod, &ball, body, &B, NULL, NULL),
                  mbsr_model_error(m));
    }
}

/* A free body on five distances. */
static void add_hung(mbsr_model *m, const units *in)
{
    const double none[3] = {0.0};
    const int body = add(m, mbsr_joint_free(NULL, NULL), lump(in, 2.0, none), MBSR_GROUND);
    for (int k = 0; k < 5; ++k) {
        double a[3], b[3];
        place_rod(k, a, b);
        const mbsr_frame A = at(in, a), B = at(in, b);
        const double d[3] = {A.x[0] - B.x[0], A.x[1] - B.x[1], A.x[2] - B.x[2]};
        const mbsr_closure_def rod = mbsr_closure_distance(
            MBSR_GROUND, A.x, body, B.x, sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
        assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
    }
}

/* From rest near q = 0 for 0.3 s. */
static outcome run_loop(const units *in, void (*build)(mbsr_model *, const units *))
{
    const double L = in->length, T = in->time;
    double q[LOOP_MOST] = {0.0}, u[LOOP_MOST] = {0.0}, y[LOOP_MOST], yp[LOOP_MOST];
    outcome o = {0};
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -7.0 * L / (T * T), -6.0 * L / (T * T));
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    build(m, in);
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    for (int body = 0; body < mbsr_model_bodies(m); ++body) {
        int at_q, nq, n;
        assert_ok(mbsr_body_coordinates(m, body, &at_q, &nq, NULL, &n), NULL);
        if (nq > n) q[at_q] = 1.0;
    }
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.atol_angle = 1e-6;
    opt.atol_length = 1e-6 * L;
    opt.atol_angular_velocity = 1e-6 / T;
    opt.atol_velocity = 1e-6 * L / T;
    assert_in_range(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), 1, LOOP_MOST);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 0.3 * T, NULL, y, NULL), mbsr_ida_error(ida));
    mbsr_ida_stats stats;
    assert_int_equal(mbsr_ida_get_stats(ida, &stats), MBSR_OK);
    o.steps = stats.steps;
    o.residuals = stats.residuals;
    o.angle = y[0];
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return o;
}

static void nor_do_those_of_loops(void **state)
{
    (void)state;
    void (*const build[])(mbsr_model *, const units *) = {add_spatial_loop, add_hung, add_carried};
    for (size_t k = 0; k < sizeof build / sizeof build[0]; ++k) {
        const outcome si = run_loop(systems, build[k]);
        for (int s = 1; s < SYSTEMS; ++s) {
            const outcome o = run_loop(systems + s, build[k]);
            print_message("%s: %ld steps, %ld residuals, angle %.8f\n", systems[s].name, o.steps,
                          o.residuals, o.angle);
            assert_close(o.angle, si.angle, 1e-7);
            assert_close((double)o.steps / (double)si.steps, 1.0, 0.02);
        }
    }
}

/* ---- joints with mass in some directions ---- */

/* A bead without mass on springs and dampers carries a pendulum of a particle, along which alone it
 * has mass. jumps: a torque on that jumps at the start. */
static outcome run_bead(const units *in, bool jumps)
{
    const double L = in->length, M = in->mass, T = in->time;
    double q[3] = {0.0, 0.0, 0.5}, u[3] = {0.0, 0.0, 3.0 / T}, y[9], yp[9];
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.atol_angle = 1e-6;
    opt.atol_length = 1e-6 * L;
    opt.atol_angular_velocity = 1e-6 / T;
    opt.atol_velocity = 1e-6 * L / T;
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const int bead = add(m, mbsr_joint_point_free(), mbsr_inertia_zero(), MBSR_GROUND);
    const int rod = add(m,
                        mbsr_joint_planar_revolute((mbsr_planar_frame){0.0, 0.0, 0.0},
                                                   (mbsr_planar_frame){0.0, L, 0.0}),
                        mbsr_inertia_particle(M), bead);
    double torque = 0.0;
    const mbsr_force_def force[] = {
        mbsr_force_axis_spring(bead, MBSR_GROUND, 0, 100.0 * M / (T * T), 5.0 * M / T, 0.0),
        mbsr_force_axis_spring(bead, MBSR_GROUND, 1, 100.0 * M / (T * T), 5.0 * M / T, 0.0),
        mbsr_force_gravity(0.0, -9.81 * L / (T * T), 0.0),
        mbsr_force_joint_applied(rod, mbsr_stored_force, &torque)};
    for (int k = 0; k < 4; ++k)
        assert_ok(mbsr_model_add_force(m, force + k, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, opt.form, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, opt.form, 0.0, y, yp, NULL, NULL), mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    if (jumps) {
        torque = 3.0 * M * L * L / (T * T);
        assert_int_equal(mbsr_ida_jump(ida), MBSR_OK);
    }
    assert_ok(mbsr_ida_advance(ida, T, NULL, y, NULL), mbsr_ida_error(ida));
    mbsr_ida_stats stats;
    assert_int_equal(mbsr_ida_get_stats(ida, &stats), MBSR_OK);
    const outcome o = {.steps = stats.steps, .residuals = stats.residuals, .angle = y[2]};
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return o;
}

/* In powers of two hardly anything is rounded otherwise. */
static void nor_do_those_of_joints_with_mass_in_some_directions(void **state)
{
    (void)state;
    static const units powers[] = {{"time / 2^12", 1, 1, 4096}, {"time * 2^12", 1, 1, 1.0 / 4096}};
    for (int jumps = 0; jumps < 2; ++jumps) {
        const outcome si = run_bead(systems, jumps);
        for (size_t k = 0; k < sizeof powers / sizeof powers[0]; ++k) {
            const outcome o = run_bead(powers + k, jumps);
            print_message("%s: %ld steps, %ld residuals, angle %.12f and %.12f\n", powers[k].name,
                          o.steps, o.residuals, o.angle, si.angle);
            assert_int_equal(o.steps, si.steps);
            assert_int_equal(o.residuals, si.residuals);
            assert_close(o.angle, si.angle, 1e-9);
        }
    }
}

/* ---- large models ---- */

/* Four-bar linkages with legs of 1 m, `FOUR_BARS` of them, so that there are more than 600 joint
 * rates and rows. */
enum { FOUR_BARS = 121 };

static mbsr_inertia bar(const units *in, double mass, double length)
{
    const double L = length * in->length, M = mass * in->mass, com[2] = {0.5 * L, 0.0};
    return mbsr_inertia_planar(M, com, M * L * L / 12.0);
}

static outcome run_large(const units *in)
{
    enum { RATES = 3 * FOUR_BARS, ALL = 3 * RATES + 4 * FOUR_BARS };
    static double q[RATES], u[RATES], y[ALL], yp[ALL];
    const double L = in->length, T = in->time, end[3] = {2.0 * L, 0.0, 0.0}, top[3] = {L, 0.0, 0.0};
    const mbsr_planar_frame here = {0.0, 0.0, 0.0}, tip = {L, 0.0, 0.0};
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81 * L / (T * T), 0.0);
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < FOUR_BARS; ++k) {
        const mbsr_planar_frame left = {3.0 * L * k, 0.0, 0.0},
                                right = {3.0 * L * k + end[0], 0.0, 0.0};
        const int leg = add(m, mbsr_joint_planar_revolute(left, here), bar(in, 1.0, 1.0),
                            MBSR_GROUND),
                  coupler = add(m, mbsr_joint_planar_revolute(tip, here), bar(in, 2.0, 2.0), leg),
                  other = add(m, mbsr_joint_planar_revolute(right, here), bar(in, 1.0, 1.0),
                              MBSR_GROUND);
        const mbsr_closure_def pin = mbsr_closure_ball(coupler, end, other, top);
        assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
        q[3 * k] = q[3 * k + 2] = 1.0, q[3 * k + 1] = -1.0;
        u[3 * k] = u[3 * k + 2] = 1.0 / T, u[3 * k + 1] = -1.0 / T;
    }
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.atol_angle = 1e-6;
    opt.atol_angular_velocity = 1e-6 / T;
    assert_int_equal(mbsr_dae_size(m, opt.form), ALL);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, opt.form, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, opt.form, 0.0, y, yp, NULL, NULL), mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 0.1 * T, NULL, y, NULL), mbsr_ida_error(ida));
    mbsr_ida_stats stats;
    assert_int_equal(mbsr_ida_get_stats(ida, &stats), MBSR_OK);
    const outcome o = {.steps = stats.steps, .residuals = stats.residuals, .angle = y[0]};
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return o;
}

static void nor_do_those_of_large_models(void **state)
{
    (void)state;
    static const units small = {"2^-12, 2^12, 2^-12", 1.0 / 4096, 4096, 1.0 / 4096};
    const outcome si = run_large(systems), o = run_large(&small);
    print_message("%ld and %ld steps, %ld and %ld residuals\n", si.steps, o.steps, si.residuals,
                  o.residuals);
    assert_int_equal(o.steps, si.steps);
    assert_int_equal(o.residuals, si.residuals);
    assert_close(o.angle, si.angle, 1e-12);
}

/* ---- rows that are redundant ---- */

/* A four-bar linkage whose rows along z are redundant but for a hinge that is askew, towards the
 * pin at the start: what they open by is compared with tolerances in all units. */
static int run_askew(const units *in, double tolerance)
{
    const double L = in->length, T = in->time, none[3] = {0.0}, far[3] = {1.0, 0.0, 0.0},
                 half[3] = {0.4, -0.3, 0.0}, z[3] = {0.0, 0.0, 1.0}, askew[3] = {1e-3, -1e-3, 1.0},
                 tip[3] = {0.8, -0.6, 0.0}, along[3] = {0.7, 0.1, 0.0};
    const mbsr_frame B = at(in, tip), C = at(in, along), D = at(in, far),
                     seen = at(in, (double[3]){0.5, -0.5, 0.0});
    double q[LOOP_MOST] = {0.0}, u[LOOP_MOST] = {0.0}, y[LOOP_MOST], yp[LOOP_MOST];
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81 * L / (T * T), 0.0);
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const int crank = add(m, mbsr_joint_revolute(NULL, NULL, z), lump(in, 1.0, half), MBSR_GROUND),
              coupler = add(m, mbsr_joint_revolute(&B, NULL, z), lump(in, 2.0, none), crank),
              rocker =
                  add(m, mbsr_joint_revolute(&D, NULL, askew), lump(in, 1.0, half), MBSR_GROUND);
    const mbsr_closure_def pin = mbsr_closure_ball(coupler, C.x, rocker, seen.x);
    assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol_angle = tolerance;
    opt.atol_length = tolerance * L;
    opt.atol_angular_velocity = tolerance / T;
    opt.atol_velocity = tolerance * L / T;
    assert_in_range(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), 1, LOOP_MOST);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    const int status = mbsr_ida_advance(ida, 1.0 * T, NULL, y, NULL);
    print_message("%s, %g: %s\n", in->name, tolerance, mbsr_ida_error(ida)->text);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return status;
}

static void nor_does_what_counts_as_open(void **state)
{
    (void)state;
    for (int s = 0; s < SYSTEMS; ++s) {
        assert_int_equal(run_askew(systems + s, 1e-5), MBSR_OK);
        assert_int_equal(run_askew(systems + s, 1e-8), MBSR_LOOP_OPEN);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_do_not_depend_on_units), cmocka_unit_test(nor_do_those_of_loops),
        cmocka_unit_test(nor_do_those_of_joints_with_mass_in_some_directions),
        cmocka_unit_test(nor_do_those_of_large_models),
        cmocka_unit_test(nor_does_what_counts_as_open)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The stepper where real time needs it: contacts, dry friction, stops and stiff springs, loops,
 * and energy that does not grow; how much work steps take. Orders: test_stepper_order.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "duration.h"
#include "flexible.h"
#include "loops.h"
#include "mixed.h"
#include "real_time.h"

#include <string.h>

/* A stepper in data of its own. */
typedef struct runner {
    const mbsr_model *m;
    mbsr_data *d;
    mbsr_stepper *stepper;
    mbsr_stepper_info info; /* of the last step */
    double kinetic, energy; /* J, likewise */
} runner;

static void look(runner *r)
{
    double potential;
    assert_ok(mbsr_energy(r->m, r->d, &r->kinetic, &potential), mbsr_data_error(r->d));
    r->energy = r->kinetic + potential;
    assert_int_equal(mbsr_stepper_get_info(r->stepper, &r->info), MBSR_OK);
}

static void start_with(runner *r, const mbsr_model *m, const double *q, const double *u,
                       const mbsr_stepper_opt *opt)
{
    mbsr_error error;
    memset(r, 0, sizeof *r);
    r->m = m;
    assert_ok(mbsr_data_create(m, &r->d, &error), &error);
    assert_ok(mbsr_stepper_create(m, r->d, opt, &r->stepper, &error), &error);
    assert_ok(mbsr_stepper_start(r->stepper, 0.0, q, u), mbsr_stepper_error(r->stepper));
    look(r);
}

static void start(runner *r, const mbsr_model *m, const double *q, const double *u, int order,
                  double h)
{
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    opt.order = order;
    opt.h = h;
    start_with(r, m, q, u, &opt);
}

static void step(runner *r)
{
    assert_ok(mbsr_stepper_step(r->stepper), mbsr_stepper_error(r->stepper));
    look(r);
}

static void finish(runner *r)
{
    mbsr_stepper_destroy(r->stepper);
    mbsr_data_destroy(r->d);
}

/* ---- contacts ---- */

/* Thrown on the floor at 60 frames per second, it slides, tumbles and comes to rest. */
static void a_ragdoll_comes_to_rest_on_the_floor_at_60_frames(void **state)
{
    (void)state;
    real_time_scene s = real_time_ragdoll();
    for (int order = 1; order <= 2; ++order) {
        runner r;
        double last, pose[MBSR_POSE_SIZE];
        start(&r, s.model, s.q, s.u, order, 1.0 / 60.0);
        assert_int_equal(mbsr_model_bodies(s.model), 20);
        last = r.energy;
        for (int k = 0; k < 8 * 60; ++k) {
            step(&r);
            assert_true(r.energy <= last + 1e-6);
            last = r.energy;
            assert_true(r.info.last.residuals <= 200 && r.info.last.factorisations <= 150);
        }
        assert_true(r.kinetic < 1e-3);
        int pressed = 0;
        for (int k = 0; k < mbsr_model_forces(s.model); ++k) {
            mbsr_contact_state contact;
            if (mbsr_contact_at(s.model, r.d, k, &contact)) continue;
            pressed += contact.depth > 0.0;
            assert_true(contact.depth < 0.05);
        }
        assert_true(pressed >= 5);
        for (int k = 0; k < 20; ++k) {
            assert_ok(mbsr_body_pose(s.model, r.d, k, pose), mbsr_data_error(r.d));
            assert_true(pose[MBSR_POSE_X + 2] > -0.05 && pose[MBSR_POSE_X + 2] < 1.0);
        }
        assert_int_equal(r.info.refused, 0);
        finish(&r);
    }
    real_time_free(&s);
}

/* With little patience and no halves the impact is too much, and nothing of the step is left. */
static void a_step_without_an_acceptable_end_is_refused(void **state)
{
    (void)state;
    real_time_scene s = real_time_ragdoll();
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    runner r;
    double before[2][128], after[2][128], t, t_after;
    int status = MBSR_OK;
    opt.h = 1.0 / 30.0, opt.halvings = 0, opt.corrections = 2, opt.tolerance = 1e-6;
    start_with(&r, s.model, s.q, s.u, &opt);
    for (int k = 0; k < 60 && !status; ++k) {
        mbsr_stepper_motion(r.stepper, &t, before[0], before[1]);
        status = mbsr_stepper_step(r.stepper);
    }
    assert_refused(status, mbsr_stepper_error(r.stepper), MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                   "mbsr_stepper|by 0.0333 s is refused after 2 attempts|after 8 corrections");
    mbsr_stepper_motion(r.stepper, &t_after, after[0], after[1]);
    assert_true(t == t_after);
    assert_memory_equal(before[0], after[0], (size_t)s.nq * sizeof(double));
    assert_memory_equal(before[1], after[1], (size_t)s.nu * sizeof(double));
    look(&r);
    assert_int_equal(r.info.refused, 1);
    assert_true(r.info.last_resorts > 1); /* which have helped before */
    assert_int_equal(r.info.last.substeps, 0);
    finish(&r);
    real_time_free(&s);
}

/* A block of 2 kg on a plane, 3 m/s, friction 0.4: it stops after v^2 / (2 mu g). */
static void dry_friction_stops_a_block_where_it_should(void **state)
{
    (void)state;
    static const double v = 3.0, mu = 0.4, g = 9.81;
    for (int order = 1; order <= 2; ++order) {
        loops s;
        runner r;
        double q, u;
        loops_begin(&s, NULL);
        const int block = test_add_body(s.m, MBSR_GROUND,
                                        mbsr_joint_point((mbsr_planar_frame){0}, 1, 0, NULL, NULL),
                                        mbsr_inertia_particle(2.0));
        const mbsr_force_def friction = mbsr_force_joint_friction(block, 0, mu * 2.0 * g, 1e-4);
        assert_ok(mbsr_model_add_force(s.m, &friction, NULL), mbsr_model_error(s.m));
        loops_finish(&s);
        s.u[0] = v;
        start(&r, s.m, s.q, s.u, order, 1e-3);
        for (int k = 0; k < 1000; ++k) step(&r);
        mbsr_stepper_motion(r.stepper, NULL, &q, &u);
        assert_close(q, v * v / (2.0 * mu * g), order == 1 ? 2e-3 : 1e-4);
        assert_close(u, 0.0, 1e-9);
        finish(&r);
        loops_free(&s);
    }
}

/* A chain of five rods falls on stops and springs of 1e10 in all joints. */
static void springs_and_stops_of_1e10_are_no_trouble(void **state)
{
    (void)state;
    for (int order = 1; order <= 2; ++order) {
        loops s;
        runner r;
        double q[8];
        loops_begin(&s, NULL);
        for (int k = 0; k < 5; ++k) {
            const int rod = loops_rod(&s, "rod", k - 1, k ? 0.5 : 0.0, 0.0, k % 2 ? 0.0 : 1.0, 0.5);
            const mbsr_force_def stop = mbsr_force_joint_stop(rod, 0, -0.3, 0.3, 1e10, 1e6);
            const mbsr_force_def spring =
                mbsr_force_joint_spring(rod, 0, k % 2 ? 1e10 : 0.0, 1.0, 0.1);
            assert_ok(mbsr_model_add_force(s.m, &stop, NULL), mbsr_model_error(s.m));
            assert_ok(mbsr_model_add_force(s.m, &spring, NULL), mbsr_model_error(s.m));
        }
        loops_finish(&s);
        start(&r, s.m, s.q, s.u, order, 1.0 / 240.0);
        const double most = r.energy;
        const int steps = test_long() ? 2000 : 300;
        for (int k = 0; k < steps; ++k) {
            step(&r);
            assert_true(r.energy <= most + 1e-3);
            mbsr_stepper_motion(r.stepper, NULL, q, NULL);
            for (int j = 0; j < 5; ++j) assert_true(fabs(q[j]) < 0.3 + 1e-3);
        }
        for (int j = 0; j < 5; j += 2) assert_close(q[j], -0.3, 1e-6);
        for (int j = 1; j < 5; j += 2) assert_close(q[j], 0.1, 1e-6);
        assert_true(r.kinetic < 1e-6);
        finish(&r);
        loops_free(&s);
    }
}

/* ---- vehicles and loops ---- */

/* 10 s at 1 kHz with steering that changes every step. */
static void no_step_of_a_vehicle_takes_thrice_the_work_of_most(void **state)
{
    (void)state;
    enum { STEPS = 10000 };
    static int count[256];
    real_time_scene s = real_time_vehicle();
    for (int order = 1; order <= 2; ++order) {
        runner r;
        int longest = 0, below = 0, median = 0;
        memset(count, 0, sizeof count);
        start(&r, s.model, s.q, s.u, order, 1e-3);
        for (int k = 0; k < STEPS; ++k) {
            s.steer[0] = 2000.0 * sin(2e-3 * k);
            step(&r);
            const mbsr_stepper_work *w = &r.info.last;
            const int work = w->residuals + w->solves + w->factorisations;
            assert_true(work < 256);
            ++count[work];
            longest = work > longest ? work : longest;
        }
        while (below + count[median] <= STEPS / 2) below += count[median++];
        assert_int_equal(median,
                         order == 1 ? 5 : 9); /* 1 factorisation; 2 or 4 residuals and solves */
        assert_true(longest <= 3 * median);
        assert_int_equal(r.info.most.substeps, 1);
        assert_int_equal(r.info.last_resorts + r.info.braked + r.info.refused, 0);
        finish(&r);
    }
    real_time_free(&s);
}

static double gap_of(runner *r)
{
    mbsr_closure_report report;
    double q[128], t;
    assert_int_equal(mbsr_stepper_motion(r->stepper, &t, q, NULL), MBSR_OK);
    assert_ok(mbsr_closures_report(r->m, r->d, t, q, &report, NULL, NULL), mbsr_data_error(r->d));
    return report.gap;
}

static void loops_stay_closed_to_1e_8_at_every_step(void **state)
{
    (void)state;
    real_time_scene s = real_time_multilink();
    for (int order = 1; order <= 2; ++order) {
        runner r;
        start(&r, s.model, s.q, s.u, order, 1e-3);
        for (int k = 0; k < 100; ++k) {
            step(&r);
            assert_less(gap_of(&r), 1e-8);
        }
        finish(&r);
    }
    real_time_free(&s);
}

/* A matrix that serves ten steps: the same motion, a tenth of the factorisations. */
static void a_matrix_may_serve_several_steps(void **state)
{
    (void)state;
    real_time_scene s = real_time_multilink();
    double end[2][128];
    for (int kept = 0; kept < 2; ++kept) {
        runner r;
        mbsr_stepper_opt opt = mbsr_default_stepper_opt();
        long factorisations = 0;
        opt.matrix_steps = kept ? 10 : 1;
        start_with(&r, s.model, s.q, s.u, &opt);
        for (int k = 0; k < 200; ++k) {
            step(&r);
            factorisations += r.info.last.factorisations;
        }
        assert_less(gap_of(&r), 1e-8);
        assert_in_range(factorisations, kept ? 20 : 200, kept ? 30 : 200);
        mbsr_stepper_motion(r.stepper, NULL, end[kept], NULL);
        finish(&r);
    }
    for (int k = 0; k < s.nq; ++k) assert_close(end[1][k], end[0][k], 1e-8);
    real_time_free(&s);
}

/* A four-bar whose coupler has no mass, its crank at 0.1 rad a step. */
static void a_four_bar_that_turns_fast_stays_closed(void **state)
{
    (void)state;
    for (int order = 1; order <= 2; ++order) {
        loops s;
        runner r;
        loops_begin(&s, NULL);
        const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 5.0, 0.5);
        const int b = loops_rod(&s, "coupler", a, 0.5, 0.0, 0.0, 2.0);
        const int c = loops_rod(&s, "rocker", MBSR_GROUND, 2.0, 0.0, 1.0, 1.5);
        loops_pin(&s, "pin", b, 2.0, 0.0, c, 1.5, 0.0);
        loops_finish(&s);
        s.q[0] = 1.0, s.q[1] = -0.7, s.q[2] = 1.8;
        s.u[0] = 20.0;
        start(&r, s.m, s.q, s.u, order, 0.005);
        const int steps = test_seeds(150, 400);
        for (int k = 0; k < steps; ++k) {
            step(&r);
            assert_less(gap_of(&r), 1e-8);
        }
        finish(&r);
        loops_free(&s);
    }
}

/* ---- energy ---- */

/* The largest energy of the ragdoll far above the floor, turning at 19 rad/s, less that at the
 * start, over its kinetic energy there. */
static double tumble(const real_time_scene *s, int watch)
{
    double most = 0.0;
    runner r;
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    opt.order = 1, opt.h = 1.0 / 240.0, opt.watch_energy = watch;
    start_with(&r, s->model, s->q, s->u, &opt);
    const double begin = r.energy, moving = r.kinetic;
    for (int k = 0; k < 120; ++k) {
        step(&r);
        most = fmax(most, (r.energy - begin) / moving);
    }
    assert_int_equal(r.info.braked > 0, watch);
    finish(&r);
    return most;
}

/* Implicit Euler alone gives it half as much again. */
static void a_chain_that_tumbles_gains_no_energy(void **state)
{
    (void)state;
    real_time_scene s = real_time_ragdoll();
    for (int k = 0; k < s.nu; ++k) s.u[k] *= 5.0;
    s.q[6] = 1000.0;
    assert_true(tumble(&s, 0) > 0.5);
    assert_true(tumble(&s, 1) < 0.011);
    real_time_free(&s);
}

/* What feeds energy is let: a motor of constant torque on a flywheel without friction. */
static void a_motor_may_feed_energy(void **state)
{
    (void)state;
    static double torque = 3.0;
    static const double z[3] = {0.0, 0.0, 1.0};
    for (int order = 1; order <= 2; ++order) {
        loops s;
        runner r;
        double q, u;
        loops_begin(&s, NULL);
        const double com[3] = {0.0}, tensor[6] = {0.5, 0.5, 0.5, 0.0, 0.0, 0.0};
        const int wheel = test_add_body(s.m, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z),
                                        mbsr_inertia_rigid(1.0, com, tensor));
        const mbsr_force_def motor = mbsr_force_joint_applied(wheel, mbsr_stored_force, &torque);
        assert_ok(mbsr_model_add_force(s.m, &motor, NULL), mbsr_model_error(s.m));
        loops_finish(&s);
        start(&r, s.m, s.q, s.u, order, 0.01);
        for (int k = 0; k < 100; ++k) {
            torque = k % 20 < 10 ? 3.0 : 1.0;
            step(&r);
        }
        mbsr_stepper_motion(r.stepper, NULL, &q, &u);
        assert_close(u, 4.0, 1e-9); /* the mean of 2 N m over 0.5 kg m^2 */
        assert_int_equal(r.info.braked, 0);
        finish(&r);
        loops_free(&s);
    }
}

/* A spring that is switched on has energy that was not there. */
static void a_spring_that_is_switched_on_is_told(void **state)
{
    (void)state;
    double reached[2];
    for (int told = 0; told < 2; ++told) {
        loops s;
        runner r;
        double q;
        int force;
        loops_begin(&s, NULL);
        const int mass = test_add_body(s.m, MBSR_GROUND,
                                       mbsr_joint_point((mbsr_planar_frame){0}, 1, 0, NULL, NULL),
                                       mbsr_inertia_particle(1.0));
        const mbsr_force_def spring = mbsr_force_joint_spring(mass, 0, 100.0, 0.0, 1.0);
        assert_ok(mbsr_model_add_force(s.m, &spring, &force), mbsr_model_error(s.m));
        loops_finish(&s);
        start(&r, s.m, s.q, s.u, 2, 1e-3);
        assert_ok(mbsr_force_switch(s.m, r.d, force, 0), mbsr_data_error(r.d));
        assert_ok(mbsr_stepper_jump(r.stepper), mbsr_stepper_error(r.stepper));
        step(&r);
        assert_ok(mbsr_force_switch(s.m, r.d, force, 1), mbsr_data_error(r.d));
        if (told) assert_ok(mbsr_stepper_jump(r.stepper), mbsr_stepper_error(r.stepper));
        for (int k = 0; k < 314; ++k) step(&r);
        mbsr_stepper_motion(r.stepper, NULL, &q, NULL);
        reached[told] = q;
        assert_int_equal(r.info.braked > 0, !told);
        finish(&r);
        loops_free(&s);
    }
    assert_close(reached[1], 2.0, 1e-3); /* half a period of 0.628 s: as far beyond */
    assert_true(reached[0] < 1.0);
}

/* ---- all kinds of parts ---- */

/* The error of q after 0.2 s by steps of 2 h over that by h; beside steps of h / 8. */
static double ratio_of(const mbsr_model *m, const double *q, const double *u, double h)
{
    enum { MOST = 64 };
    double end[3][MOST], coarse = 0.0, fine = 0.0;
    const int nq = mbsr_model_nq(m);
    assert_true(nq <= MOST);
    for (int k = 0; k < 3; ++k) {
        runner r;
        const double step_of[3] = {h / 8.0, h, 2.0 * h};
        start(&r, m, q, u, 2, step_of[k]);
        const int steps = (int)(0.2 / step_of[k] + 0.5);
        for (int l = 0; l < steps; ++l) step(&r);
        mbsr_stepper_motion(r.stepper, NULL, end[k], NULL);
        assert_int_equal(r.info.refused, 0);
        finish(&r);
    }
    for (int k = 0; k < nq; ++k) {
        fine = fmax(fine, fabs(end[1][k] - end[0][k]));
        coarse = fmax(coarse, fabs(end[2][k] - end[0][k]));
    }
    return coarse / fine;
}

static void flexible_bodies_converge(void **state)
{
    (void)state;
    for (int massless = 0; massless < 2; ++massless) {
        test_flexible w;
        if (massless)
            test_flexible_massless(&w);
        else
            test_flexible_tree(&w, 0, 1);
        assert_close(ratio_of(w.model, w.q, w.u, 1e-3), 4.0, 0.2);
        test_flexible_free(&w);
    }
}

/* Users' joints, bodies of any dimension, driven and locked coordinates, on roots that move. */
static void users_joints_and_moving_roots_converge(void **state)
{
    (void)state;
    for (int scene = 0; scene < MIXED_ALL; ++scene) {
        mixed s;
        double q[MIXED_NQ], u[MIXED_NU];
        test_rng rng = test_seed(8);
        mixed_make(&s, (mixed_scene)scene);
        test_fill(&rng, s.nq, q);
        test_fill(&rng, s.nu, u);
        assert_close(ratio_of(s.model, q, u, 1e-3), 4.0, 0.2);
        mixed_free(&s);
    }
}

static void quaternions_keep_their_length(void **state)
{
    (void)state;
    real_time_scene s = real_time_ragdoll();
    runner r;
    double q[128];
    start(&r, s.model, s.q, s.u, 1, 1.0 / 60.0);
    for (int k = 0; k < 60; ++k) {
        step(&r);
        mbsr_stepper_motion(r.stepper, NULL, q, NULL);
        for (int body = 0; body < 20; ++body) {
            int at, nq, nu;
            mbsr_body_coordinates(s.model, body, &at, &nq, NULL, &nu);
            if (nq == nu) continue;
            const double *p = q + at;
            assert_close(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3], 1.0, 1e-15);
        }
    }
    finish(&r);
    real_time_free(&s);
}

/* A mass on a drive whose reference are straight lines between points: kinks inside of steps. */
static void kinks_of_tables_are_passed(void **state)
{
    (void)state;
    static const double x[4] = {0.0, 0.1003, 0.2007, 0.5}, value[4] = {0.0, 0.5, -0.3, -0.3};
    mbsr_table_def def = mbsr_default_table_def();
    mbsr_table *table;
    mbsr_error error;
    loops s;
    def.points = 4, def.x = x, def.value = value;
    assert_ok(mbsr_table_create(&def, &table, &error), &error);
    loops_begin(&s, NULL);
    const int mass =
        test_add_body(s.m, MBSR_GROUND, mbsr_joint_point((mbsr_planar_frame){0}, 1, 0, NULL, NULL),
                      mbsr_inertia_particle(1.0));
    const mbsr_servo servo = {.kp = 1e4, .kd = 50.0, .table = table};
    const mbsr_force_def drive = mbsr_force_joint_servo(mass, 0, &servo);
    assert_ok(mbsr_model_add_force(s.m, &drive, NULL), mbsr_model_error(s.m));
    loops_finish(&s);
    for (int order = 1; order <= 2; ++order) {
        runner r;
        double q;
        start(&r, s.m, s.q, s.u, order, 1e-3);
        for (int k = 1; k <= 500; ++k) {
            step(&r);
            mbsr_stepper_motion(r.stepper, NULL, &q, NULL);
            if (k == 100) assert_close(q, 0.5 * 100.0 / 100.3, 0.03);
        }
        assert_close(q, -0.3, 1e-3);
        assert_int_equal(r.info.most.substeps, 1);
        finish(&r);
    }
    loops_free(&s);
    mbsr_table_destroy(table);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ragdoll_comes_to_rest_on_the_floor_at_60_frames),
        cmocka_unit_test(a_step_without_an_acceptable_end_is_refused),
        cmocka_unit_test(dry_friction_stops_a_block_where_it_should),
        cmocka_unit_test(springs_and_stops_of_1e10_are_no_trouble),
        cmocka_unit_test(no_step_of_a_vehicle_takes_thrice_the_work_of_most),
        cmocka_unit_test(loops_stay_closed_to_1e_8_at_every_step),
        cmocka_unit_test(a_matrix_may_serve_several_steps),
        cmocka_unit_test(a_four_bar_that_turns_fast_stays_closed),
        cmocka_unit_test(a_chain_that_tumbles_gains_no_energy),
        cmocka_unit_test(a_motor_may_feed_energy),
        cmocka_unit_test(a_spring_that_is_switched_on_is_told),
        cmocka_unit_test(flexible_bodies_converge),
        cmocka_unit_test(users_joints_and_moving_roots_converge),
        cmocka_unit_test(quaternions_keep_their_length),
        cmocka_unit_test(kinks_of_tables_are_passed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

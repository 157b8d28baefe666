/* Small models for the tests of the driver, with known solutions.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_PROBLEMS_H
#define TEST_PROBLEMS_H

#include "expect.h"

#include <mbsrank/ida.h>

typedef struct problem {
    mbsr_model *model;
    mbsr_data *data;
    int size;
    double y[4], yp[4]; /* consistent start at t = 0 */
} problem;

/* Default options but for the form: these problems are written in (q, u). */
static inline mbsr_ida_opt problem_opt(void)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = MBSR_DAE_RECURSIVE;
    return opt;
}

/* What the force function `probe` does; it adds no force. */
typedef struct probe {
    long calls;
    double fail_from, fail_to; /* times between which it fails */
    long fail_first;           /* so many calls fail at the beginning */
    int second_at_one_time;    /* only evaluations after the first one at the same time fail */
    double last_time;
    int code; /* what it returns then */
} probe;

static inline int probe_function(void *user, double t, int n, double *value)
{
    probe *p = user;
    const int again = ++p->calls > 1 && t == p->last_time;
    p->last_time = t;
    for (int k = 0; k < n; ++k) value[k] = 0.0;
    if (p->calls <= p->fail_first) return p->code;
    if (t < p->fail_from || t > p->fail_to) return 0;
    return p->second_at_one_time && !again ? 0 : p->code;
}

static inline probe probe_passive(void)
{
    return (probe){.fail_from = INFINITY, .fail_to = INFINITY};
}

/* Finishes the model, makes its data, and derivatives consistent with the state y. */
static inline void problem_finish(problem *p, probe *observer)
{
    if (observer) {
        const mbsr_force_def force = mbsr_force_joint_applied(0, probe_function, observer);
        assert_ok(mbsr_model_add_force(p->model, &force, NULL), mbsr_model_error(p->model));
    }
    assert_ok(mbsr_model_finish(p->model), mbsr_model_error(p->model));
    assert_ok(mbsr_data_create(p->model, &p->data, NULL), NULL);
    p->size = mbsr_dae_size(p->model, MBSR_DAE_RECURSIVE);
    assert_in_range(p->size, 1, 4);
    if (observer) observer->fail_first = 0;
    assert_ok(
        mbsr_dae_consistent(p->model, p->data, MBSR_DAE_RECURSIVE, 0.0, p->y, p->yp, NULL, NULL),
        mbsr_data_error(p->data));
    if (observer) observer->calls = 0;
}

static inline void problem_free(problem *p)
{
    mbsr_data_destroy(p->data);
    mbsr_model_destroy(p->model);
}

static inline void problem_spring(problem *p, int axis, double stiffness, double damping)
{
    const mbsr_force_def force =
        mbsr_force_axis_spring(0, MBSR_GROUND, axis, stiffness, damping, 0.0);
    assert_ok(mbsr_model_add_force(p->model, &force, NULL), mbsr_model_error(p->model));
}

static inline void problem_point(problem *p, int free, double mass)
{
    *p = (problem){0};
    assert_ok(mbsr_model_create(NULL, &p->model, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "point";
    body.joint = mbsr_joint_point((mbsr_planar_frame){0.0, 0.0, 0.0}, free, 0, NULL, NULL);
    body.inertia = mbsr_inertia_particle(mass);
    assert_ok(mbsr_model_add_body(p->model, &body, NULL), mbsr_model_error(p->model));
}

/* A particle of 2 kg on springs of 8 N/m along x and 18 N/m along y, from (1, 0.5) m at rest:
 * x = cos(2 t), y = 0.5 cos(3 t). */
static inline void problem_oscillator(problem *p, probe *observer)
{
    problem_point(p, MBSR_X | MBSR_Y, 2.0);
    problem_spring(p, 0, 8.0, 0.0);
    problem_spring(p, 1, 18.0, 0.0);
    p->y[0] = 1.0;
    p->y[1] = 0.5;
    problem_finish(p, observer);
}

static inline void oscillator_solution(double t, double y[4])
{
    y[0] = cos(2.0 * t);
    y[1] = 0.5 * cos(3.0 * t);
    y[2] = -2.0 * sin(2.0 * t);
    y[3] = -1.5 * sin(3.0 * t);
}

/* A point without mass on a spring of 6 N/m and a damper of 2 N s/m, from 1 m: x = exp(-3 t). */
static inline void problem_massless(problem *p, probe *observer)
{
    problem_point(p, MBSR_X, 0.0);
    problem_spring(p, 0, 6.0, 2.0);
    p->y[0] = 1.0;
    problem_finish(p, observer);
}

/* A point without mass and without a force. */
static inline void problem_undetermined(problem *p, probe *observer)
{
    problem_point(p, MBSR_X, 0.0);
    const mbsr_force_def force = mbsr_force_joint_applied(0, probe_function, observer);
    assert_ok(mbsr_model_add_force(p->model, &force, NULL), mbsr_model_error(p->model));
    assert_ok(mbsr_model_finish(p->model), mbsr_model_error(p->model));
    assert_ok(mbsr_data_create(p->model, &p->data, NULL), NULL);
    p->size = 2;
    p->y[0] = 1.0;
}

/* The pendulum of the IFToMM library of benchmark problems, A01: a particle of 1 kg on a rod of 1 m
 * without mass, let go from the horizontal; g = 9.81 m/s^2. q[0] is the angle from there. */
static inline void problem_pendulum(problem *p)
{
    *p = (problem){0};
    assert_ok(mbsr_model_create(NULL, &p->model, NULL), NULL);
    const mbsr_planar_frame origin = {0.0, 0.0, 0.0};
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "pendulum";
    body.joint = mbsr_joint_planar_revolute(origin, origin);
    body.inertia = mbsr_inertia_planar(1.0, (double[2]){1.0, 0.0}, 0.0);
    assert_ok(mbsr_model_add_body(p->model, &body, NULL), mbsr_model_error(p->model));
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    assert_ok(mbsr_model_add_force(p->model, &gravity, NULL), mbsr_model_error(p->model));
    problem_finish(p, NULL);
}

/* The start of the problem in another form: y and yp of mbsr_dae_size numbers. */
static inline void problem_in_form(const problem *p, mbsr_dae_form form, double *y, double *yp)
{
    const double *u = p->y + mbsr_model_nq(p->model);
    assert_ok(mbsr_dae_pack(p->model, p->data, form, 0.0, p->y, u, y), mbsr_data_error(p->data));
    assert_ok(mbsr_dae_consistent(p->model, p->data, form, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(p->data));
}

/* A driver for the problem, started at t = 0; opt == NULL means problem_opt(). */
static inline mbsr_ida *problem_start(const problem *p, const mbsr_ida_opt *opt)
{
    const mbsr_ida_opt standard = problem_opt();
    if (!opt) opt = &standard;
    mbsr_ida *ida = NULL;
    mbsr_error error = {0};
    assert_ok(mbsr_ida_create(p->model, p->data, opt, &ida, &error), &error);
    assert_ok(mbsr_ida_start(ida, 0.0, p->y, p->yp), mbsr_ida_error(ida));
    return ida;
}

static inline mbsr_ida_stats problem_stats(const mbsr_ida *ida)
{
    mbsr_ida_stats stats;
    assert_int_equal(mbsr_ida_get_stats(ida, &stats), MBSR_OK);
    return stats;
}

/* Fails unless all counters and the last step are the same. */
static inline void assert_same_stats(mbsr_ida_stats a, mbsr_ida_stats b)
{
    assert_int_equal(a.steps, b.steps);
    assert_int_equal(a.residuals, b.residuals);
    assert_int_equal(a.jacobian_residuals, b.jacobian_residuals);
    assert_int_equal(a.jacobians, b.jacobians);
    assert_int_equal(a.newton_iterations, b.newton_iterations);
    assert_int_equal(a.newton_failures, b.newton_failures);
    assert_int_equal(a.error_test_failures, b.error_test_failures);
    assert_int_equal(a.events, b.events);
    assert_int_equal(a.raw_states, b.raw_states);
    assert_int_equal(a.last_order, b.last_order);
    assert_int_equal(a.factorisations, b.factorisations);
    assert_int_equal(a.solves, b.solves);
    assert_int_equal(a.krylov_iterations, b.krylov_iterations);
    assert_int_equal(a.stiff_tests, b.stiff_tests);
    assert_int_equal(a.stiff_iterations, b.stiff_iterations);
    assert_int_equal(a.careful_attempts, b.careful_attempts);
    assert_int_equal(a.careful_failures, b.careful_failures);
    assert_int_equal(a.filter_solves, b.filter_solves);
    assert_int_equal(a.renewals, b.renewals);
    assert_memory_equal(&a.last_step, &b.last_step, sizeof a.last_step);
}

#endif

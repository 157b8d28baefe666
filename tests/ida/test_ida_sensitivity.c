/* Sensitivities of runs: against differences of runs, against the closed form of the paper's
 * problems, forward against adjoint.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "flexible.h"
#include "loops.h"
#include "paper.h"
#include "reference_runs.h"

#include <mbsrank/driver.h>
#include <mbsrank/sensitivity.h>
#include <mbsrank/table.h>

#include <stdlib.h>
#include <string.h>

enum { TIMES = 5, MOST = 48, CHOSEN = 24 };

/* A run, and the parameters looked at. */
typedef struct subject {
    const mbsr_model *model;
    double q[MOST], u[MOST], t_end, time[TIMES];
    int count, which[CHOSEN];
    mbsr_parameters *list;
    double tolerance, within; /* of the run; what sensitivities may be off by */
    mbsr_kink_fn kink;
    bool held; /* q and u are a start for any value of the parameters */
} subject;

static subject begin(const mbsr_model *m, double t_end)
{
    subject s = {.model = m, .t_end = t_end, .tolerance = test_long() ? 1e-7 : 1e-6};
    mbsr_error error;
    s.within = 100.0 * s.tolerance;
    for (int k = 0; k < TIMES; ++k) s.time[k] = t_end * (k + 1) / TIMES;
    assert_ok(mbsr_parameters_create(m, &s.list, &error), &error);
    return s;
}

static mbsr_sensitivity_opt options(const subject *s)
{
    mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
    opt.list = s->list;
    opt.parameters = s->count;
    opt.which = s->which;
    opt.ida.rtol = opt.ida.atol = s->tolerance;
    opt.ida.kink = s->kink;
    return opt;
}

static mbsr_sensitivity *go(const subject *s)
{
    mbsr_sensitivity *sensitivity = NULL;
    mbsr_error error;
    const mbsr_sensitivity_opt opt = options(s);
    assert_ok(mbsr_sensitivity_create(s->model, &opt, &sensitivity, &error), &error);
    assert_ok(mbsr_sensitivity_run(sensitivity, 0.0, s->q, s->u, TIMES, s->time, NULL, NULL),
              mbsr_sensitivity_error(sensitivity));
    return sensitivity;
}

/* y' at y of a model with masses everywhere and stiff rows: the rows give s', the others q', p'. */
static void find_rates(const mbsr_model *m, mbsr_data *d, const double *y, double *yp)
{
    const int nq = mbsr_model_nq(m), nu = mbsr_model_nu(m), rows = mbsr_model_rows(m);
    double F[4 * MOST];
    memset(yp, 0, 4 * MOST * sizeof *yp);
    for (int again = 0; again < 2; ++again) {
        assert_ok(mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), mbsr_data_error(d));
        for (int k = 0; k < nq + nu; ++k) yp[k] -= F[k];
        for (int k = 0; k < rows && again == 0; ++k)
            yp[nq + 2 * nu + k] = -F[nq + 2 * nu + k] * mbsr_closure_stiffness(m, 0, k);
    }
    assert_ok(mbsr_forward_dynamics(m, d, 0.0, y, y + nq + nu, NULL, yp + nq + nu),
              mbsr_data_error(d));
}

/* States at the times with another value of one parameter, at a tolerance much smaller. */
static void go_with(const subject *s, int which, double value, double *q_at, double *u_at)
{
    mbsr_data *d;
    mbsr_ida *ida;
    mbsr_error error;
    assert_ok(mbsr_parameters_data(s->list, 1, &which, &value, &d, &error), &error);
    const mbsr_model *m = mbsr_data_model(d);
    const int size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM), nq = mbsr_model_nq(m),
              nu = mbsr_model_nu(m);
    double y[4 * MOST], yp[4 * MOST];
    assert_in_range(size, 1, 4 * MOST);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-4 * s->tolerance;
    opt.kink = s->kink;
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y), mbsr_data_error(d));
    if (s->held)
        find_rates(m, d, y, yp);
    else
        assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, &error), &error);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    for (int k = 0; k < TIMES; ++k) {
        assert_ok(mbsr_ida_advance(ida, s->time[k], NULL, y, NULL), mbsr_ida_error(ida));
        memcpy(q_at + k * nq, y, (size_t)nq * sizeof *y);
        memcpy(u_at + k * nu, y + nq + nu, (size_t)nu * sizeof *y);
    }
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
}

static double largest(int count, const double *x)
{
    double most = 0.0;
    for (int k = 0; k < count; ++k) most = fmax(most, fabs(x[k]));
    return most;
}

/* The largest difference over 1 + what it is a part of. */
static double apart(int count, const double *a, const double *b)
{
    double most = 0.0;
    for (int k = 0; k < count; ++k) most = fmax(most, fabs(a[k] - b[k]));
    return most / (1.0 + largest(count, b));
}

/* Derivatives along parameter k times its size, by differences of runs: fourth order. */
static void difference(const subject *s, int k, double scale, double *dq, double *du)
{
    static double q[4][TIMES * MOST], u[4][TIMES * MOST];
    mbsr_parameter p;
    const int nq = TIMES * mbsr_model_nq(s->model), nu = TIMES * mbsr_model_nu(s->model);
    const double h = 1e-3, way[4] = {h, -h, 2.0 * h, -2.0 * h};
    mbsr_parameter_get(s->list, s->which[k], &p);
    for (int l = 0; l < 4; ++l) go_with(s, s->which[k], p.value + way[l] * scale, q[l], u[l]);
    for (int l = 0; l < nq; ++l)
        dq[l] = (8.0 * (q[0][l] - q[1][l]) - (q[2][l] - q[3][l])) / (12.0 * h);
    for (int l = 0; l < nu; ++l)
        du[l] = (8.0 * (u[0][l] - u[1][l]) - (u[2][l] - u[3][l])) / (12.0 * h);
}

static double scale_of(const subject *s, int k)
{
    mbsr_parameter p;
    mbsr_parameter_get(s->list, s->which[k], &p);
    return p.value == 0.0 ? 0.1 : fabs(p.value);
}

/* Forward against differences of runs to 100 tolerances, adjoint against forward to rounding. */
static void check(const char *name, subject *s)
{
    const int nq = mbsr_model_nq(s->model), nu = mbsr_model_nu(s->model), all_q = TIMES * nq,
              all_u = TIMES * nu;
    double *dq = calloc((size_t)(s->count * all_q), sizeof *dq),
           *du = calloc((size_t)(s->count * all_u), sizeof *du), by[CHOSEN];
    static double dq_runs[TIMES * MOST], du_runs[TIMES * MOST], w_q[TIMES * MOST],
        w_u[TIMES * MOST];
    mbsr_sensitivity *sensitivity = go(s);
    assert_ok(mbsr_sensitivity_forward(sensitivity, dq, du), mbsr_sensitivity_error(sensitivity));
    for (int k = 0; k < all_q; ++k) w_q[k] = sin(1.0 + k);
    for (int k = 0; k < all_u; ++k) w_u[k] = cos(2.0 + 3 * k);
    assert_ok(mbsr_sensitivity_adjoint(sensitivity, w_q, w_u, by),
              mbsr_sensitivity_error(sensitivity));
    const int every = test_long() ? 1 : 4; /* in the short form some of them */
    for (int k = 0; k < s->count; ++k) {
        double sum = 0.0, size = 0.0;
        mbsr_parameter p;
        mbsr_parameter_get(s->list, s->which[k], &p);
        const double scale = scale_of(s, k);
        for (int l = 0; l < all_q; ++l)
            sum += w_q[l] * dq[k * all_q + l], size += fabs(w_q[l] * dq[k * all_q + l]);
        for (int l = 0; l < all_u; ++l)
            sum += w_u[l] * du[k * all_u + l], size += fabs(w_u[l] * du[k * all_u + l]);
        assert_less(fabs(by[k] - sum), 1e-11 * size + 1e-14);
        if (k % every != 0) continue;
        difference(s, k, scale, dq_runs, du_runs);
        for (int l = 0; l < all_q; ++l) dq[k * all_q + l] *= scale;
        for (int l = 0; l < all_u; ++l) du[k * all_u + l] *= scale;
        const double q_apart = apart(all_q, dq + k * all_q, dq_runs),
                     u_apart = apart(all_u, du + k * all_u, du_runs);
        print_message("%-10s %-34s %6.1f %6.1f tolerances\n", name, p.name, q_apart / s->tolerance,
                      u_apart / s->tolerance);
        assert_less(q_apart, s->within);
        assert_less(u_apart, s->within);
    }
    mbsr_sensitivity_destroy(sensitivity);
    mbsr_parameters_destroy(s->list);
    free(dq);
    free(du);
}

static void choose_all(subject *s, const char *part)
{
    for (int k = 0; k < mbsr_parameters_count(s->list) && s->count < CHOSEN; ++k) {
        mbsr_parameter p;
        mbsr_parameter_get(s->list, k, &p);
        const bool zero_mass = p.part == MBSR_PARAMETER_MASS && p.value == 0.0;
        if (strstr(p.name, part) && !zero_mass) s->which[s->count++] = k;
    }
}

static void the_papers_problems(void **state)
{
    (void)state;
    mbsr_model *m = paper_upper(&paper_standard);
    subject s = begin(m, 1.0);
    const double q[] = {0.1, 0.1, 0.05, 0.0}, u[] = {0.3, 0.2, -0.1, 0.2};
    memcpy(s.q, q, sizeof q), memcpy(s.u, u, sizeof u);
    choose_all(&s, "forces"), choose_all(&s, "mass");
    check("upper", &s);
    mbsr_model_destroy(m);
    m = paper_lower(&paper_standard);
    s = begin(m, 1.0);
    const double q_lower[] = {0.1, 0.1, 0.05}, u_lower[] = {0.3, 0.2, -0.1};
    memcpy(s.q, q_lower, sizeof q_lower), memcpy(s.u, u_lower, sizeof u_lower);
    choose_all(&s, "forces"), choose_all(&s, "mass"), choose_all(&s, "joint_");
    check("lower", &s);
    mbsr_model_destroy(m);
    for (int k = 0; k < 4; ++k) {
        oscillator_parameters p = oscillator_standard;
        p.d1 = p.d2 = k / 2 == 1 ? 0.0 : 2.0; /* springs only: index 2 */
        m = paper_oscillators(&p, k % 2);
        s = begin(m, 1.0);
        s.q[0] = 0.1, s.q[1] = 0.2, s.u[1] = 0.5;
        choose_all(&s, "stiffness"), choose_all(&s, "mass");
        if (k / 2 == 0) choose_all(&s, "damping");
        check(k / 2 == 0 ? "damped" : "elastic", &s);
        mbsr_model_destroy(m);
    }
}

/* Three bodies in space, one on a ball joint, with springs. */
static mbsr_model *arm(void)
{
    const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, com[3] = {0.02, 0.01, -0.3},
                 tensor[6] = {0.02, 0.025, 0.01, 0.001, 0.002, -0.001};
    mbsr_model *m = run_model();
    const mbsr_frame below = mbsr_frame_at(0.0, 0.0, -0.5);
    const int a = run_body(m, "a", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, x),
                           mbsr_inertia_rigid(2.0, com, tensor)),
              b = run_body(m, "b", a, mbsr_joint_spherical(&below, NULL),
                           mbsr_inertia_rigid(1.0, com, tensor)),
              c = run_body(m, "c", b, mbsr_joint_universal(&below, NULL, x, y),
                           mbsr_inertia_rigid(0.5, com, tensor));
    run_force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
    run_force(m, mbsr_force_joint_spring(c, 0, 3.0, 0.2, 0.1));
    run_force(m, mbsr_force_joint_spring(a, 0, 2.0, 0.1, 0.0));
    return run_finish(m);
}

static void a_tree_in_space(void **state)
{
    (void)state;
    mbsr_model *m = arm();
    subject s = begin(m, 0.8);
    const double q[] = {0.4, 1.0, 0.0, 0.0, 0.0, 0.3, -0.2};
    memcpy(s.q, q, sizeof q);
    for (int k = 0; k < mbsr_model_nu(m); ++k) s.u[k] = 0.5 - 0.1 * k;
    choose_all(&s, "mass"), choose_all(&s, "com[2]"), choose_all(&s, "Ixy");
    choose_all(&s, "joint_position[3]"), choose_all(&s, "force0");
    choose_all(&s, ".stiffness"), choose_all(&s, ".damping"), choose_all(&s, ".rest");
    check("space", &s);
    mbsr_model_destroy(m);
}

/* Crank 1 m, coupler 2.5 m, rocker 2 m over 2 m of ground; a stiff pin is one of springs. */
static void four_bar(loops *s, double coupler, double stiffness)
{
    loops_begin(s, NULL);
    const int a = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              b = loops_rod(s, "coupler", a, 1.0, 0.0, coupler, 2.5),
              c = loops_rod(s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
    mbsr_closure_def pin =
        mbsr_closure_ball(b, (double[3]){2.5, 0.0, 0.0}, c, (double[3]){2.0, 0.0, 0.0});
    pin.name = "pin";
    for (int k = 0; k < 2; ++k) {
        pin.stiffness[k] = stiffness;
        pin.damping[k] = 0.01 * stiffness;
    }
    assert_ok(mbsr_model_add_closure(s->m, &pin, NULL), mbsr_model_error(s->m));
    run_force(s->m, mbsr_force_joint_spring(c, 0, 20.0, 1.0, 1.0));
    loops_finish(s);
    s->q[0] = 1.2, s->q[1] = -0.9, s->q[2] = 1.3, s->u[0] = 3.0;
}

/* The start that is found for the model, whatever the parameters. */
static void hold(subject *s, mbsr_data *d)
{
    double y[4 * MOST], yp[4 * MOST];
    assert_ok(mbsr_dae_pack(s->model, d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y), NULL);
    assert_ok(mbsr_dae_consistent(s->model, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL), NULL);
    assert_ok(mbsr_dae_unpack(s->model, d, MBSR_DAE_MOMENTUM, 0.0, y, s->q, s->u), NULL);
    s->held = true;
}

static void closed_models(void **state)
{
    (void)state;
    for (int k = 0; k < 3; ++k) {
        loops l;
        four_bar(&l, k == 1 ? 0.0 : 2.5, k == 2 ? 1e4 : 0.0);
        subject s = begin(l.m, 0.8);
        if (k < 2) {
            loops_close(&l, 0.0);
            loops_velocities(&l, 0.0);
        }
        memcpy(s.q, l.q, 3 * sizeof *s.q), memcpy(s.u, l.u, 3 * sizeof *s.u);
        if (k == 2) hold(&s, l.d);
        choose_all(&s, "mass"), choose_all(&s, "bodies.rocker.com[1]"), choose_all(&s, "rocker.I");
        choose_all(&s, ".stiffness"), choose_all(&s, ".damping"), choose_all(&s, "gy");
        check(k == 0 ? "four-bar" : k == 1 ? "massless" : "stiff pin", &s);
        loops_free(&l);
    }
    loops l;
    loops_begin(&l, NULL);
    loops_add_parallelograms(&l, 2);
    loops_finish(&l);
    for (int k = 0; k < l.nu; ++k) l.q[k] = 0.0;
    for (int k = 0; k < 2; ++k) {
        l.q[4 * k] = l.q[4 * k + 2] = l.q[4 * k + 3] = 1.0, l.q[4 * k + 1] = -1.0;
    }
    loops_close(&l, 0.0);
    loops_velocities(&l, 0.0);
    subject s = begin(l.m, 0.5);
    memcpy(s.q, l.q, (size_t)l.nq * sizeof *s.q), memcpy(s.u, l.u, (size_t)l.nu * sizeof *s.u);
    choose_all(&s, "mass"), choose_all(&s, "gy");
    check("redundant", &s);
    loops_free(&l);
}

static void flexible_bodies(void **state)
{
    (void)state;
    test_flexible w;
    for (int k = 0; k < 2; ++k) {
        if (k == 0)
            test_flexible_pendulum(&w, 1.0, 0);
        else
            test_flexible_massless(&w);
        subject s = begin(w.model, 0.3);
        memcpy(s.q, w.q, sizeof w.q), memcpy(s.u, w.u, sizeof w.u);
        choose_all(&s, "forces"), choose_all(&s, "mass");
        check("flexible", &s);
        test_flexible_free(&w);
    }
}

static int jump(void *user, double t, int n, double *value)
{
    (void)user;
    for (int k = 0; k < n; ++k) value[k] = t < 0.3 ? 0.0 : 2.0;
    return 0;
}

static int at_jump(void *user, double t, int direction, mbsr_kink *next)
{
    (void)user;
    if (direction > 0 ? t < 0.3 : t > 0.3) *next = (mbsr_kink){0.3, 1};
    return 0;
}

/* A force on a body without mass jumps at 0.3 s, and so does its velocity. */
static void a_force_jumps(void **state)
{
    (void)state;
    mbsr_model *m = run_model();
    const int a = run_cart(m, "a", MBSR_GROUND, 0.0), b = run_cart(m, "b", a, 2.0);
    run_force(m, mbsr_force_joint_spring(a, 0, 30.0, 2.0, 0.1));
    run_force(m, mbsr_force_joint_spring(b, 0, 50.0, 1.0, 0.0));
    run_force(m, mbsr_force_joint_applied(a, jump, NULL));
    run_finish(m);
    subject s = begin(m, 1.0);
    s.q[0] = 0.1, s.q[1] = 0.2;
    s.kink = at_jump;
    choose_all(&s, "damping"), choose_all(&s, "stiffness"), choose_all(&s, "b.mass");
    check("jump", &s);
    mbsr_model_destroy(m);
}

/* A load falls on a stop with a damper and is thrown back. */
static void a_stop_is_hit(void **state)
{
    (void)state;
    mbsr_model *m = run_model();
    const int a = run_cart(m, "a", MBSR_GROUND, 1.5);
    run_force(m, mbsr_force_joint_spring(a, 0, 3.0, 0.2, 1.0));
    run_force(m, mbsr_force_joint_stop(a, 0, -INFINITY, 0.3, 500.0, 5.0));
    run_finish(m);
    subject s = begin(m, 1.0);
    s.u[0] = 0.5;
    choose_all(&s, "mass"), choose_all(&s, "stiffness"), choose_all(&s, "damping");
    check("stop", &s);
    mbsr_model_destroy(m);
}

/* A drive leaves the limit of its force. */
static void a_servo_at_its_limit(void **state)
{
    (void)state;
    const mbsr_servo servo = {.kp = 40.0, .kd = 3.0, .limit = 5.0, .reference = 0.5};
    mbsr_model *m = run_model();
    const int a = run_cart(m, "a", MBSR_GROUND, 1.2);
    run_force(m, mbsr_force_joint_spring(a, 0, 2.0, 0.1, 0.0));
    run_force(m, mbsr_force_joint_servo(a, 0, &servo));
    run_finish(m);
    subject s = begin(m, 1.0);
    choose_all(&s, "mass"), choose_all(&s, "force1"), choose_all(&s, "force0.stiffness");
    assert_true(s.count >= 5); /* with kp, kd, limit, reference */
    check("servo", &s);
    mbsr_model_destroy(m);
}

/* A motor passes the corner of its characteristic. */
static void a_characteristic_with_a_corner(void **state)
{
    (void)state;
    const double speed[] = {0.0, 0.5, 2.0}, torque[] = {6.0, 2.0, 0.0};
    mbsr_table_def def = mbsr_default_table_def();
    mbsr_table *table;
    def.points = 3, def.x = speed, def.value = torque;
    assert_ok(mbsr_table_create(&def, &table, NULL), NULL);
    mbsr_model *m = run_model();
    const int a = run_cart(m, "a", MBSR_GROUND, 1.5);
    run_force(m, mbsr_force_joint_spring(a, 0, 9.0, 0.5, 0.0));
    run_force(m, mbsr_force_joint_curve(a, 0, table));
    run_finish(m);
    subject s = begin(m, 1.0);
    choose_all(&s, "mass"), choose_all(&s, "stiffness"), choose_all(&s, "damping");
    check("curve", &s);
    mbsr_model_destroy(m);
    mbsr_table_destroy(table);
}

/* Teeth with play touch on one side, then on the other. */
static void teeth_with_backlash(void **state)
{
    (void)state;
    const mbsr_gear gear = {
        .ratio = -2.0, .stiffness = 300.0, .damping = 2.0, .backlash = 0.05, .rest = 0.01};
    mbsr_model *m = run_model();
    const int a = run_cart(m, "a", MBSR_GROUND, 1.5), b = run_cart(m, "b", MBSR_GROUND, 0.4);
    run_force(m, mbsr_force_joint_spring(a, 0, 30.0, 0.2, 0.0));
    run_force(m, mbsr_force_gear(a, 0, b, 0, &gear));
    run_finish(m);
    subject s = begin(m, 0.8);
    s.u[0] = 0.6;
    choose_all(&s, "mass"), choose_all(&s, "force1"), choose_all(&s, "force0.stiffness");
    assert_true(s.count >= 6);
    check("teeth", &s);
    mbsr_model_destroy(m);
}

/* A ball falls on the ground, slides and is thrown back. */
static void a_ball_on_the_ground(void **state)
{
    (void)state;
    const double z[3] = {0.0, 0.0, 1.0}, centre[3] = {0.0, 0.0, 0.0};
    const mbsr_contact contact = {.radius = 0.1,
                                  .normal = {0.0, 0.0, 1.0},
                                  .stiffness = 800.0,
                                  .exponent = 1.0,
                                  .damping = 0.3,
                                  .friction = 0.4,
                                  .slip = 0.05};
    mbsr_model *m = run_model();
    const int a = run_cart(m, "a", MBSR_GROUND, 0.2),
              b = run_body(m, "b", a, mbsr_joint_prismatic(NULL, NULL, z),
                           mbsr_inertia_point_mass(0.7, centre));
    run_force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
    run_force(m, mbsr_force_contact(b, MBSR_GROUND, &contact));
    run_finish(m);
    subject s = begin(m, 0.5);
    s.q[1] = 0.25, s.u[0] = 1.0;
    choose_all(&s, "mass"), choose_all(&s, "stiffness"), choose_all(&s, "gz");
    choose_all(&s, "friction"), choose_all(&s, "damping");
    assert_int_equal(s.count, 6);
    check("ball", &s);
    mbsr_model_destroy(m);
}

/* A stop on a body without mass between two springs: its velocity jumps where the stop is hit. */
static void a_stop_without_mass(void **state)
{
    (void)state;
    mbsr_model *m = run_model();
    const int a = run_cart(m, "a", MBSR_GROUND, 0.0), b = run_cart(m, "b", a, 2.0);
    run_force(m, mbsr_force_joint_spring(a, 0, 30.0, 0.0, 0.0));
    run_force(m, mbsr_force_joint_spring(b, 0, 50.0, 0.0, 0.0));
    run_force(m, mbsr_force_joint_stop(a, 0, -INFINITY, 0.05, 200.0, 0.0));
    run_finish(m);
    subject s = begin(m, 1.0);
    s.u[1] = 1.0;
    choose_all(&s, "force2.stiffness"), choose_all(&s, "force0.stiffness");
    choose_all(&s, "force1.stiffness"), choose_all(&s, "b.mass"), choose_all(&s, "force2.upper");
    check("series", &s);
    /* frames that turn the direction without mass */
    s = begin(m, 1.0);
    s.u[1] = 1.0;
    choose_all(&s, "bodies.b.joint_position[1]");
    assert_int_equal(s.count, 1);
    mbsr_sensitivity *sensitivity = NULL;
    const mbsr_sensitivity_opt opt = options(&s);
    assert_ok(mbsr_sensitivity_create(m, &opt, &sensitivity, NULL), NULL);
    assert_refused(mbsr_sensitivity_run(sensitivity, 0.0, s.q, s.u, TIMES, s.time, NULL, NULL),
                   mbsr_sensitivity_error(sensitivity), MBSR_ERR_SPACE, MBSR_NONE, MBSR_NONE,
                   "bodies.b.joint_position[1]: at t = ");
    mbsr_sensitivity_destroy(sensitivity);
    mbsr_parameters_destroy(s.list);
    mbsr_model_destroy(m);
}

/* Derivatives in the stiffness at the times of s against those given, and those in the mass, of
 * what depends on stiffness over mass alone. */
static void compare_with(subject *s, double stiffness, double mass, const double *dx,
                         const double *dv)
{
    double dq[2 * TIMES], du[2 * TIMES];
    choose_all(s, "forces.force0.stiffness"), choose_all(s, "mass");
    assert_int_equal(s->count, 2);
    mbsr_sensitivity *sensitivity = go(s);
    assert_ok(mbsr_sensitivity_forward(sensitivity, dq, du), mbsr_sensitivity_error(sensitivity));
    for (int k = 0; k < TIMES; ++k) {
        print_message("%g: %.2e %.2e\n", s->time[k], stiffness * dq[k] - dx[k],
                      stiffness * du[k] - dv[k]);
        assert_close(stiffness * dq[k], dx[k], 100.0 * s->tolerance);
        assert_close(stiffness * du[k], dv[k], 100.0 * s->tolerance * sqrt(stiffness / mass));
        assert_close(mass * dq[TIMES + k], -dx[k], 100.0 * s->tolerance);
    }
    mbsr_sensitivity_destroy(sensitivity);
    mbsr_parameters_destroy(s->list);
}

/* Free, then half a swing in the stop, then free again: x = d - v (t - d / v - pi / w). */
static void a_ball_on_a_stop(void **state)
{
    (void)state;
    const double mass = 1.5, stiffness = 600.0, speed = 0.8, place = 0.1,
                 w = sqrt(stiffness / mass), hit = place / speed, left = hit + acos(-1.0) / w;
    mbsr_model *m = run_model();
    const int a = run_cart(m, "a", MBSR_GROUND, mass);
    run_force(m, mbsr_force_joint_stop(a, 0, -INFINITY, place, stiffness, 0.0));
    run_finish(m);
    subject s = begin(m, 0.4);
    double dx[TIMES], dv[TIMES];
    s.u[0] = speed;
    for (int k = 0; k < TIMES; ++k) { /* times the stiffness: dw = w / 2 */
        const double t = s.time[k], since = w * (t - hit);
        const bool touches = t > hit && t < left;
        dx[k] = t < hit   ? 0.0
                : touches ? 0.5 * speed / w * (since * cos(since) - sin(since))
                          : -0.5 * speed * acos(-1.0) / w;
        dv[k] = touches ? -0.5 * speed * since * sin(since) : 0.0;
    }
    assert_true(s.time[0] < hit && s.time[1] > hit && s.time[TIMES - 1] > left);
    compare_with(&s, stiffness, mass, dx, dv);
    mbsr_model_destroy(m);
}

/* A stretched cable pulls a load until it is slack: x = e cos(w t), then -e w (t - pi / (2 w)). */
static void a_cable_goes_slack(void **state)
{
    (void)state;
    const double mass = 2.0, stiffness = 50.0, stretch = 0.2, length = 1.0,
                 w = sqrt(stiffness / mass), slack = 0.5 * acos(-1.0) / w,
                 at[3] = {-length, 0.0, 0.0}, here[3] = {0.0, 0.0, 0.0};
    const mbsr_spring cable = {.stiffness = stiffness, .free_length = length, .one_sided = 1};
    mbsr_model *m = run_model();
    const int a = run_cart(m, "a", MBSR_GROUND, mass);
    run_force(m, mbsr_force_spring(a, here, MBSR_GROUND, at, &cable));
    run_finish(m);
    subject s = begin(m, 0.6);
    double dx[TIMES], dv[TIMES];
    s.q[0] = stretch;
    for (int k = 0; k < TIMES; ++k) {
        const double t = s.time[k];
        dx[k] = t < slack ? -0.5 * stretch * w * t * sin(w * t) : -0.5 * stretch * w * t;
        dv[k] =
            t < slack ? -0.5 * stretch * w * (sin(w * t) + w * t * cos(w * t)) : -0.5 * stretch * w;
    }
    assert_true(s.time[1] < slack && s.time[3] > slack);
    compare_with(&s, stiffness, mass, dx, dv);
    mbsr_model_destroy(m);
}

static int push_beyond(const mbsr_force_args *args)
{
    args->body->tau[0] -= args->body->q[0] > 0.2 ? args->force->param[0] : 0.0;
    return MBSR_OK;
}

static double beyond(const mbsr_force_args *args)
{
    return args->body->q[0] > 0.2;
}

/* A force of one's own that jumps where its branch changes. */
static void a_force_that_jumps_is_refused(void **state)
{
    (void)state;
    const mbsr_force_table table = {.version = MBSR_FORCE_TABLE_VERSION,
                                    .name = "wall",
                                    .flags = MBSR_FORCE_JOINT_ONLY,
                                    .evaluate = push_beyond,
                                    .side = beyond};
    mbsr_model *m = run_model();
    const int a = run_cart(m, "a", MBSR_GROUND, 1.0);
    mbsr_force_def wall = mbsr_force_custom(&table, 1, &a, NULL);
    wall.param[0] = 3.0;
    run_force(m, wall);
    run_finish(m);
    subject s = begin(m, 1.0);
    s.u[0] = 1.0;
    choose_all(&s, "mass");
    mbsr_sensitivity *sensitivity = NULL;
    mbsr_error error;
    const mbsr_sensitivity_opt opt = options(&s);
    assert_ok(mbsr_sensitivity_create(m, &opt, &sensitivity, &error), &error);
    assert_refused(mbsr_sensitivity_run(sensitivity, 0.0, s.q, s.u, TIMES, s.time, NULL, NULL),
                   mbsr_sensitivity_error(sensitivity), MBSR_ERR_SPACE, MBSR_NONE, 0,
                   "(wall) jumps");
    mbsr_sensitivity_destroy(sensitivity);
    mbsr_parameters_destroy(s.list);
    mbsr_model_destroy(m);
}

/* Where the rotation vector that a spring acts on jumps. */
static void half_a_turn_is_refused(void **state)
{
    (void)state;
    static const double stiffness[6] = {0.1, 0.2, 0.3, 0.0, 0.0, 0.0};
    for (int bushing = 0; bushing < 2; ++bushing) {
        mbsr_model *m = run_model();
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_spherical(NULL, NULL);
        body.inertia = mbsr_inertia_rigid(1.0, (const double[3]){0, 0, 0},
                                          (const double[6]){1, 1.5, 2, 0, 0, 0});
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        run_force(m, bushing ? mbsr_force_bushing(MBSR_GROUND, NULL, 0, NULL, stiffness, NULL)
                             : mbsr_force_joint_rotation_spring(0, stiffness, NULL, NULL));
        run_finish(m);
        subject s = begin(m, 1.5);
        s.q[0] = 1.0;
        s.u[2] = 3.0;
        s.u[1] = 0.1;
        choose_all(&s, "mass");
        mbsr_error error;
        const mbsr_sensitivity_opt opt = options(&s);
        mbsr_sensitivity *sensitivity = NULL;
        assert_ok(mbsr_sensitivity_create(m, &opt, &sensitivity, &error), &error);
        assert_refused(mbsr_sensitivity_run(sensitivity, 0.0, s.q, s.u, TIMES, s.time, NULL, NULL),
                       mbsr_sensitivity_error(sensitivity), MBSR_ERR_SPACE, MBSR_NONE, 0, "jumps");
        /* up to there it is none */
        const double early = 0.9;
        assert_ok(mbsr_sensitivity_run(sensitivity, 0.0, s.q, s.u, 1, &early, NULL, NULL),
                  mbsr_sensitivity_error(sensitivity));
        mbsr_sensitivity_destroy(sensitivity);
        mbsr_parameters_destroy(s.list);
        mbsr_model_destroy(m);
    }
}

enum { CLOSED = 3 };

/* Derivatives of the paper's upper problem, x' = A x + b, times the parameter, by its matrix
 * exponential with parameter k 0.1 % more and less, 0.2 %: dq (TIMES x 4). */
static void differentiate_closed_form(const subject *s, int k, double *dq)
{
    static const double h = 1e-3, way[4] = {1.0, -1.0, 2.0, -2.0};
    double q[4][TIMES][4];
    for (int l = 0; l < 4; ++l) {
        paper_parameters p = paper_standard;
        double *const value[CLOSED] = {&p.cix, &p.diy, &p.mj};
        double x[EXPM_MOST];
        *value[k] *= 1.0 + h * way[l];
        const expm_system system = paper_upper_system(&p);
        paper_upper_state(s->q, s->u, x);
        for (int i = 0; i < TIMES; ++i) {
            expm_solve(&system, s->t_end / TIMES, x, x);
            paper_upper_positions(x, q[l][i]);
        }
    }
    for (int i = 0; i < TIMES; ++i)
        for (int j = 0; j < 4; ++j)
            dq[4 * i + j] =
                (8.0 * (q[0][i][j] - q[1][i][j]) - (q[2][i][j] - q[3][i][j])) / (12.0 * h);
}

static void the_closed_form(void **state)
{
    (void)state;
    static const char *const names[CLOSED] = {"forces.force0.stiffness", "forces.force1.damping",
                                              "bodies.body1.mass"};
    const double q[4] = {0.1, 0.1, 0.05, 0.0}, u[4] = {0.3, 0.2, -0.1, 0.2};
    mbsr_model *m = paper_upper(&paper_standard);
    subject s = begin(m, 1.0);
    memcpy(s.q, q, sizeof q), memcpy(s.u, u, sizeof u);
    for (int k = 0; k < CLOSED; ++k) s.which[s.count++] = mbsr_parameters_find(s.list, names[k]);
    double dq[CLOSED * TIMES * 4], exact[TIMES * 4];
    mbsr_sensitivity *sensitivity = go(&s);
    assert_ok(mbsr_sensitivity_forward(sensitivity, dq, NULL), mbsr_sensitivity_error(sensitivity));
    for (int k = 0; k < CLOSED; ++k) {
        differentiate_closed_form(&s, k, exact);
        assert_true(largest(TIMES * 4, exact) > 0.01);
        for (int l = 0; l < TIMES * 4; ++l)
            assert_close(scale_of(&s, k) * dq[k * TIMES * 4 + l], exact[l], 100.0 * s.tolerance);
    }
    mbsr_sensitivity_destroy(sensitivity);
    mbsr_parameters_destroy(s.list);
    mbsr_model_destroy(m);
}

/* ---- at rest ---- */

/* By how much x of a mass hung on a spring at rest, of natural frequency w and damping ratio zeta,
 * goes on to change with the mass. */
static double swing(double g_over_k, double w, double zeta, double t)
{
    const double damped = w * sqrt(1.0 - zeta * zeta);
    return g_over_k *
           (exp(-zeta * w * t) * (cos(damped * t) + zeta * w / damped * sin(damped * t)) - 1.0);
}

/* Nothing moves but, with `beside`, another body, slowly: no error test sees the spring. */
static void hang(double length, double tolerance, double zeta, bool beside)
{
    const double mass = 2.0, stiffness = 100.0, g = 9.81 * length, up[3] = {0.0, 0.0, 1.0},
                 across[3] = {1.0, 0.0, 0.0}, time[2] = {0.5, 1.0};
    const mbsr_force_def forces[] = {
        mbsr_force_joint_spring(0, 0, stiffness, 2.0 * zeta * sqrt(stiffness * mass), 0.0),
        mbsr_force_gravity(0.0, 0.0, -g)};
    double q[2] = {-mass * g / stiffness}, u[2] = {0.0, 1e-3 * length}, dq[4], by,
           w[4] = {0.0, 0.0, 1.0, 0.0};
    mbsr_model *m;
    mbsr_parameters *list;
    mbsr_sensitivity *sensitivity;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    test_add_body(m, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, up),
                  mbsr_inertia_particle(mass));
    if (beside)
        test_add_body(m, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, across),
                      mbsr_inertia_particle(mass));
    for (int k = 0; k < 2; ++k)
        assert_ok(mbsr_model_add_force(m, forces + k, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_parameters_create(m, &list, NULL), NULL);
    const int which = mbsr_parameters_find(list, "bodies.body0.mass"), nq = beside ? 2 : 1;
    mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
    opt.list = list, opt.which = &which, opt.parameters = 1;
    opt.ida.rtol = tolerance, opt.ida.atol = tolerance * length;
    assert_ok(mbsr_sensitivity_create(m, &opt, &sensitivity, NULL), NULL);
    assert_ok(mbsr_sensitivity_run(sensitivity, 0.0, q, u, 2, time, NULL, NULL),
              mbsr_sensitivity_error(sensitivity));
    assert_ok(mbsr_sensitivity_forward(sensitivity, dq, NULL), mbsr_sensitivity_error(sensitivity));
    w[2] = beside ? 1.0 : 0.0, w[1] = beside ? 0.0 : 1.0;
    assert_ok(mbsr_sensitivity_adjoint(sensitivity, w, NULL, &by),
              mbsr_sensitivity_error(sensitivity));
    for (int k = 0; k < 2; ++k) {
        const double exact = swing(g / stiffness, sqrt(stiffness / mass), zeta, time[k]);
        assert_close(dq[k * nq], exact, 100.0 * tolerance * length);
    }
    assert_close(by, dq[nq], 1e-11 * length);
    mbsr_sensitivity_destroy(sensitivity);
    mbsr_parameters_destroy(list);
    mbsr_model_destroy(m);
}

static void what_is_at_rest(void **state)
{
    (void)state;
    for (double tolerance = 1e-4; tolerance > 1e-11; tolerance *= 1e-2) {
        hang(1.0, tolerance, 0.0, false);
        hang(1e3, tolerance, 0.05, false);
        hang(1.0, tolerance, 0.05, true);
    }
}

/* Tolerances of each number, all the same, are those of all. */
static void tolerances_of_each_number(void **state)
{
    enum { LONGEST = 64 };
    double each[LONGEST], dq[2][TIMES * MOST];
    (void)state;
    mbsr_model *m = paper_upper(&paper_standard);
    subject s = begin(m, 1.0);
    choose_all(&s, "mass");
    for (int k = 0; k < 4; ++k) s.q[k] = 0.1, s.u[k] = 0.2;
    for (int k = 0; k < LONGEST; ++k) each[k] = s.tolerance;
    for (int k = 0; k < 2; ++k) {
        mbsr_sensitivity *sensitivity;
        mbsr_sensitivity_opt opt = options(&s);
        if (k > 0) opt.ida.atol_each = each;
        assert_true(mbsr_dae_size(m, MBSR_DAE_MOMENTUM) <= LONGEST);
        assert_ok(mbsr_sensitivity_create(m, &opt, &sensitivity, NULL), NULL);
        for (int l = 0; l < LONGEST; ++l) each[l] = k > 0 ? NAN : s.tolerance; /* have been read */
        assert_ok(mbsr_sensitivity_run(sensitivity, 0.0, s.q, s.u, TIMES, s.time, NULL, NULL),
                  mbsr_sensitivity_error(sensitivity));
        assert_ok(mbsr_sensitivity_forward(sensitivity, dq[k], NULL),
                  mbsr_sensitivity_error(sensitivity));
        mbsr_sensitivity_destroy(sensitivity);
    }
    const int count = TIMES * mbsr_model_nq(m);
    assert_true(largest(count, dq[0]) > 1e-3);
    assert_true(apart(count, dq[0], dq[1]) < s.within * largest(count, dq[0]));
    mbsr_parameters_destroy(s.list);
    mbsr_model_destroy(m);
}

/* ---- what is refused ---- */

static void refuse(const subject *s, mbsr_sensitivity_opt opt, int status, const char *words)
{
    mbsr_sensitivity *sensitivity = NULL;
    mbsr_error error;
    const int got = mbsr_sensitivity_create(s->model, &opt, &sensitivity, &error);
    assert_refused(got, &error, status, error.body, error.force, words);
    assert_null(sensitivity);
}

static void options_are_checked(void **state)
{
    (void)state;
    mbsr_model *m = paper_upper(&paper_standard);
    subject s = begin(m, 1.0);
    choose_all(&s, "mass");
    mbsr_sensitivity_opt opt = options(&s);
    opt.cookie = 0;
    refuse(&s, opt, MBSR_ERR_NO_DEFAULT, "mbsr_default_sensitivity_opt");
    opt = options(&s), opt.list = NULL;
    refuse(&s, opt, MBSR_ERR_NULL, "list is NULL");
    opt = options(&s), opt.parameters = 0;
    refuse(&s, opt, MBSR_ERR_VALUE, "parameters must be positive");
    opt = options(&s), opt.ida.form = MBSR_DAE_INDEX1;
    refuse(&s, opt, MBSR_ERR_VALUE, "MBSR_DAE_MOMENTUM");
    opt = options(&s), opt.ida.events = 1;
    refuse(&s, opt, MBSR_ERR_VALUE, "events must be 0");
    const int none = 1000;
    opt = options(&s), opt.parameters = 1, opt.which = &none;
    refuse(&s, opt, MBSR_ERR_ID, "which[0] is 1000");
    opt = options(&s);
    mbsr_sensitivity *sensitivity = NULL;
    mbsr_error error;
    assert_int_equal(mbsr_sensitivity_create(NULL, &opt, &sensitivity, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sensitivity_create(m, NULL, &sensitivity, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sensitivity_create(m, &opt, NULL, &error), MBSR_ERR_NULL);
    mbsr_model *unfinished;
    assert_ok(mbsr_model_create(NULL, &unfinished, NULL), NULL);
    assert_int_equal(mbsr_sensitivity_create(unfinished, &opt, &sensitivity, &error),
                     MBSR_ERR_UNFINISHED);
    mbsr_model_destroy(unfinished);
    mbsr_parameters_destroy(s.list);
    mbsr_model_destroy(m);
    /* frames of joints that closures hold */
    loops l;
    four_bar(&l, 2.5, 0.0);
    s = begin(l.m, 1.0);
    choose_all(&s, "crank.joint_position[1]");
    refuse(&s, options(&s), MBSR_ERR_SPACE, "bodies.crank.joint_position");
    mbsr_parameters_destroy(s.list);
    loops_free(&l);
}

static void calls_are_checked(void **state)
{
    (void)state;
    mbsr_model *m = paper_upper(&paper_standard);
    subject s = begin(m, 1.0);
    choose_all(&s, "mass");
    mbsr_sensitivity *sensitivity = NULL;
    mbsr_sensitivity_opt opt = options(&s);
    assert_ok(mbsr_sensitivity_create(m, &opt, &sensitivity, NULL), NULL);
    const mbsr_error *error = mbsr_sensitivity_error(sensitivity);
    double dq[TIMES * MOST], by[CHOSEN];
    assert_refused(mbsr_sensitivity_forward(sensitivity, dq, NULL), error, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_sensitivity_run");
    assert_refused(mbsr_sensitivity_adjoint(sensitivity, NULL, NULL, by), error, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_sensitivity_run");
    const double twice[2] = {0.5, 0.5};
    assert_refused(mbsr_sensitivity_run(sensitivity, 0.0, s.q, s.u, 2, twice, NULL, NULL), error,
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "time[1] is 0.5");
    static const struct {
        double t0;
        int times;
        double time[2];
        int status;
        const char *words;
    } runs[] = {{0.0, 0, {1.0, 2.0}, MBSR_ERR_VALUE, "times is 0"},
                {NAN, 1, {1.0, 2.0}, MBSR_NOT_FINITE, "t0"},
                {0.0, 1, {-1.0, 2.0}, MBSR_ERR_VALUE, "time[0] is -1"},
                {0.0, 2, {1.0, NAN}, MBSR_NOT_FINITE, "time[1] is nan"},
                {0.0, 2, {1.0, INFINITY}, MBSR_NOT_FINITE, "time[1] is inf"},
                {1.0, 1, {1.0, 2.0}, MBSR_ERR_VALUE, "the last time is the start"}};
    for (size_t k = 0; k < sizeof runs / sizeof *runs; ++k)
        assert_refused(mbsr_sensitivity_run(sensitivity, runs[k].t0, s.q, s.u, runs[k].times,
                                            runs[k].time, NULL, NULL),
                       error, runs[k].status, MBSR_NONE, MBSR_NONE, runs[k].words);
    assert_refused(mbsr_sensitivity_run(sensitivity, 0.0, s.q, s.u, 1, NULL, NULL, NULL), error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "time is NULL");
    assert_int_equal(mbsr_sensitivity_steps(sensitivity), 0);
    assert_ok(mbsr_sensitivity_run(sensitivity, 0.0, s.q, s.u, 1, twice, NULL, NULL), error);
    assert_true(mbsr_sensitivity_steps(sensitivity) > 2);
    const double bad[4] = {0.0, NAN, 0.0, 0.0};
    assert_refused(mbsr_sensitivity_adjoint(sensitivity, bad, NULL, by), error, MBSR_NOT_FINITE,
                   MBSR_NONE, MBSR_NONE, "weight");
    mbsr_sensitivity_destroy(sensitivity);
    /* a mass where there is none */
    s.which[0] = mbsr_parameters_find(s.list, "bodies.body0.mass");
    s.count = 1;
    opt = options(&s);
    assert_ok(mbsr_sensitivity_create(m, &opt, &sensitivity, NULL), NULL);
    assert_refused(mbsr_sensitivity_run(sensitivity, 0.0, s.q, s.u, 1, twice, NULL, NULL),
                   mbsr_sensitivity_error(sensitivity), MBSR_ERR_SPACE, MBSR_NONE, MBSR_NONE,
                   "bodies.body0.mass is zero");
    mbsr_sensitivity_destroy(sensitivity);
    mbsr_parameters_destroy(s.list);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_papers_problems),
        cmocka_unit_test(a_tree_in_space),
        cmocka_unit_test(closed_models),
        cmocka_unit_test(flexible_bodies),
        cmocka_unit_test(a_force_jumps),
        cmocka_unit_test(the_closed_form),
        cmocka_unit_test(what_is_at_rest),
        cmocka_unit_test(a_stop_is_hit),
        cmocka_unit_test(a_ball_on_a_stop),
        cmocka_unit_test(a_servo_at_its_limit),
        cmocka_unit_test(a_characteristic_with_a_corner),
        cmocka_unit_test(teeth_with_backlash),
        cmocka_unit_test(a_ball_on_the_ground),
        cmocka_unit_test(a_stop_without_mass),
        cmocka_unit_test(a_cable_goes_slack),
        cmocka_unit_test(a_force_that_jumps_is_refused),
        cmocka_unit_test(half_a_turn_is_refused),
        cmocka_unit_test(tolerances_of_each_number),
        cmocka_unit_test(options_are_checked),
        cmocka_unit_test(calls_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Functions of the caller's fail at each of their calls in turn: what was called says so by their
 * status, nothing is lost, and the next call gives the same bits as if nothing had been.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "counting.h"
#include "expect.h"

#include <mbsrank/driver.h>
#include <mbsrank/mbsrank.h>

#include <stdbool.h>
#include <string.h>

/* ---- functions of the caller's ---- */

static long asked, fail_at;
static int with;
static test_counting memory;
static bool fail_on; /* from there on, too */

static int says(void)
{
    ++asked;
    return asked == fail_at || (fail_on && fail_at > 0 && asked > fail_at) ? with : 0;
}

static int turn(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    *s = 0.1 * sin(t), *sdot = 0.1 * cos(t), *sddot = -0.1 * sin(t);
    return says();
}

static int law(void *user, double x, double v, double *force, double *energy, double *power)
{
    (void)user;
    *force = 40.0 * (x - 0.5) + 0.7 * v;
    if (energy) *energy = 20.0 * (x - 0.5) * (x - 0.5);
    if (power) *power = 0.7 * v * v;
    return says();
}

static int push(const mbsr_force_args *args)
{
    args->body[0].f[0] -= 3.0 * args->body[0].p[0] + 0.2 * args->body[0].V[0];
    return says();
}

static const mbsr_force_table pushes = {
    .version = MBSR_FORCE_TABLE_VERSION, .name = "push", .evaluate = push};

static int gap(const mbsr_closure_args *args, double *g)
{
    g[0] = args->body[0].p[1] + 0.3 * args->body[1].p[1] - args->closure->param[0];
    return says();
}

static const mbsr_closure_table gaps = {
    .version = MBSR_CLOSURE_TABLE_VERSION, .name = "gap", .position = gap};

/* ---- models ---- */

enum { MOST = 200, LONG = 16 };

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu, size;
    double q[LONG], u[LONG], zero[LONG], y[MOST], yp[MOST], out[4 * MOST];
} scene;

static void add_body(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def b = mbsr_default_body_def();
    b.parent = parent, b.joint = joint, b.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &b, NULL), mbsr_model_error(m));
}

/* Four bars, or three without the pin, with an arm that is driven and a slider on springs that may
 * have no mass. */
static void make(scene *s, bool closed, bool massless)
{
    static const double middle[2] = {0.4, 0.0}, tip[3] = {1.0, 0, 0}, wall[3] = {2.0, 0.4, 0};
    const mbsr_planar_frame none = {0}, elbow = {.x = 0.8}, base = {.x = 1.2};
    const mbsr_inertia bar = mbsr_inertia_planar(1.0, middle, 0.1);
    const mbsr_spring spring = {.function = law};

    memset(s, 0, sizeof *s);
    mbsr_model_def def = mbsr_default_model_def();
    def.allocator = test_counting_allocator(&memory);
    mbsr_model *m;
    assert_ok(mbsr_model_create(&def, &m, NULL), NULL);
    add_body(m, MBSR_GROUND, mbsr_joint_planar_revolute(none, none), bar);
    add_body(m, 0, mbsr_joint_planar_revolute(elbow, none), bar);
    add_body(m, MBSR_GROUND, mbsr_joint_planar_revolute(base, none), bar);
    add_body(m, 2, mbsr_joint_planar(elbow, none, 0, MBSR_ANGLE, turn, NULL), bar);
    add_body(m, 3, mbsr_joint_planar_prismatic(none, none),
             massless ? mbsr_inertia_zero() : mbsr_inertia_planar(0.2, middle, 0.01));
    const mbsr_force_def force[] = {
        mbsr_force_joint_spring(4, 0, 30.0, 2.0, 0.1), mbsr_force_spring(4, NULL, 5, wall, &spring),
        mbsr_force_custom(&pushes, 1, (const int[]){2}, NULL), mbsr_force_gravity(0, -9.81, 0)};
    add_body(m, MBSR_GROUND, mbsr_joint_planar_free(none, none), bar);
    for (size_t k = 0; k < sizeof force / sizeof *force; ++k)
        assert_ok(mbsr_model_add_force(m, force + k, NULL), mbsr_model_error(m));
    mbsr_closure_def pin = mbsr_closure_ball(1, tip, 2, tip);
    mbsr_closure_def own = mbsr_closure_custom(&gaps, 2, (const int[]){5, 0}, 1, 1, NULL);
    own.param[0] = 0.4;
    if (closed) assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
    if (closed) assert_ok(mbsr_model_add_closure(m, &own, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    s->model = m;
    assert_ok(mbsr_data_create(m, &s->data, NULL), NULL);
    s->nq = mbsr_model_nq(m), s->nu = mbsr_model_nu(m);
    s->size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    assert_true(s->size < MOST);
    const double q[] = {1.5, -1.4, 1.9, 0.2, 0.3, 0.4, 0.1};
    memcpy(s->q, q, sizeof q);
    if (closed)
        assert_ok(mbsr_assemble(m, s->data, 0.0, s->q, NULL, s->q, NULL), mbsr_data_error(s->data));
    assert_ok(mbsr_dae_pack(m, s->data, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, s->y),
              mbsr_data_error(s->data));
    assert_ok(mbsr_dae_consistent(m, s->data, MBSR_DAE_MOMENTUM, 0.0, s->y, s->yp, NULL, NULL),
              mbsr_data_error(s->data));
}

/* ---- what is called ---- */

static int is_staged(scene *s)
{
    int status = mbsr_stage_positions(s->model, s->data, 0.0, s->q);
    if (!status) status = mbsr_stage_velocities(s->model, s->data, s->u);
    if (!status) status = mbsr_stage_forces(s->model, s->data, NULL);
    if (!status) status = mbsr_energy(s->model, s->data, s->out, s->out + 1);
    if (!status) status = mbsr_dissipation(s->model, s->data, s->out + 2);
    if (!status) status = mbsr_momenta(s->model, s->data, s->out + 3);
    if (!status) status = mbsr_force_power(s->model, s->data, 1, s->out + 20, s->out + 21);
    if (!status) status = mbsr_force_load(s->model, s->data, 2, 0, s->out + 22, s->out + 30);
    return status;
}

static int has_loops(scene *s)
{
    mbsr_closure_report report[2];
    int unique[8];
    int status = mbsr_stage_positions(s->model, s->data, 0.0, s->q);
    if (!status) status = mbsr_stage_velocities(s->model, s->data, s->u);
    if (!status) status = mbsr_closures_gap(s->model, s->data, s->out);
    if (!status) status = mbsr_closures_rate(s->model, s->data, s->out + 10);
    if (!status) status = mbsr_closures_bias(s->model, s->data, s->out + 20);
    if (!status) status = mbsr_closures_mobility(s->model, s->data, s->out + 30);
    if (!status) status = mbsr_closures_report(s->model, s->data, 0.0, s->q, report, NULL, unique);
    if (!status) status = mbsr_assemble(s->model, s->data, 0.0, s->q, NULL, s->out + 60, NULL);
    return status;
}

static int has_dynamics(scene *s)
{
    const int status = mbsr_forward_dynamics(s->model, s->data, 0.0, s->q, s->u, NULL, s->out);
    return status ? status : mbsr_stage_accelerations(s->model, s->data, s->out);
}

static int has_inverse_dynamics(scene *s)
{
    const int status =
        mbsr_inverse_dynamics(s->model, s->data, 0.0, s->q, s->u, s->zero, NULL, s->out);
    return status ? status : mbsr_bias_forces(s->model, s->data, 0.0, s->q, s->u, s->out + LONG);
}

static int is_refined(scene *s)
{
    double *o = s->out;
    return mbsr_forward_dynamics_refined(s->model, s->data, 0.0, s->q, s->u, NULL, o, o + LONG,
                                         o + 2 * LONG);
}

static int has_a_residual(scene *s)
{
    return mbsr_recursive_residual(s->model, s->data, 0.0, s->q, s->u, s->zero, NULL, s->out);
}

static int starts_in(scene *s, mbsr_dae_form form)
{
    const int size = mbsr_dae_size(s->model, form);
    double *y = s->out, *yp = s->out + MOST, *F = s->out + 2 * MOST, share;
    int body;
    mbsr_index1_reset(s->model, s->data);
    memset(s->out, 0, sizeof s->out);
    int status = mbsr_dae_pack(s->model, s->data, form, 0.0, s->q, s->u, y);
    if (!status) status = mbsr_dae_consistent(s->model, s->data, form, 0.0, y, yp, NULL, NULL);
    if (!status) status = mbsr_dae_residual(s->model, s->data, form, 0.0, y, yp, F);
    if (!status) status = mbsr_dae_unpack(s->model, s->data, form, 0.0, y, F + size, F + size + 16);
    if (!status && mbsr_model_rows(s->model) == 0)
        status = mbsr_dae_imbalance(s->model, s->data, form, 0.0, y, &share, &body, NULL, NULL);
    return status;
}

static int starts(scene *s)
{
    return starts_in(s, MBSR_DAE_MOMENTUM);
}

static int starts_in_index1(scene *s)
{
    return starts_in(s, MBSR_DAE_INDEX1);
}

static int has_index(scene *s)
{
    mbsr_index_report *report;
    const int status = mbsr_index_report_create(s->model, s->data, 0.0, s->q, s->u, &report);
    if (status) return status;
    s->out[0] = report->conditioning;
    mbsr_index_report_destroy(s->model, report);
    return status;
}

static int is_linearised(scene *s)
{
    mbsr_newton *newton;
    int status = mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, NULL, &newton, NULL);
    if (!status) status = mbsr_newton_factor(newton, s->data, 0.0, s->y, s->yp, 50.0);
    if (!status) status = mbsr_newton_solve(newton, s->y, s->out);
    mbsr_newton_destroy(newton);
    return status;
}

static int is_completed(scene *s)
{
    mbsr_completion *completion;
    memcpy(s->out, s->y, sizeof s->y);
    memcpy(s->out + MOST, s->yp, sizeof s->yp);
    int status = mbsr_completion_create(s->model, NULL, &completion, NULL);
    if (!status)
        status = mbsr_completion_solve(completion, s->data, MBSR_DAE_MOMENTUM, 0.0, s->out,
                                       s->out + MOST);
    if (!status)
        status = mbsr_completion_motion(completion, s->data, s->out + 2 * MOST,
                                        s->out + 2 * MOST + 16, s->out + 2 * MOST + 32, s->zero);
    mbsr_completion_destroy(completion);
    memset(s->zero, 0, sizeof s->zero);
    return status;
}

static int is_stepped(scene *s)
{
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    mbsr_stepper *stepper;
    opt.h = 1e-3;
    int status = mbsr_stepper_create(s->model, s->data, &opt, &stepper, NULL);
    if (!status) status = mbsr_stepper_start(stepper, 0.0, s->q, s->u);
    if (!status) status = mbsr_stepper_step(stepper);
    if (!status) status = mbsr_stepper_motion(stepper, NULL, s->out, s->out + 16);
    mbsr_stepper_destroy(stepper);
    return status;
}

static int has_derivatives(scene *s)
{
    mbsr_derivatives *by;
    double *o = s->out;
    int status = mbsr_derivatives_create(s->model, &by, NULL);
    if (!status) status = mbsr_derivatives_forward(by, 0.0, s->q, s->u, NULL, o, NULL);
    if (!status) status = mbsr_derivatives_matrices(by, o + 20, o + 120, NULL);
    if (!status) status = mbsr_derivatives_inverse(by, 0.0, s->q, s->u, s->zero, o + 220);
    if (!status) status = mbsr_derivatives_residual(by, 0.0, s->y, s->yp, o + 240);
    mbsr_derivatives_destroy(by);
    return status;
}

static int is_an_equation(scene *s)
{
    mbsr_ode *ode;
    int status = mbsr_ode_create(s->model, s->data, 0.0, s->q, s->u, &ode);
    if (!status) status = mbsr_ode_pack(ode, 0.0, s->q, s->u, s->out);
    if (!status) status = mbsr_ode_rhs(ode, 0.0, s->out, s->out + 40);
    if (!status) memcpy(s->out + 80, s->u, sizeof s->u);
    if (!status) status = mbsr_ode_velocities(ode, 0.0, s->out, s->out + 80);
    mbsr_ode_destroy(ode);
    return status;
}

static int is_multiplied(scene *s)
{
    mbsr_newton *newton;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.products = 1;
    int status = mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, &opt, &newton, NULL);
    if (!status) status = mbsr_newton_linearise(newton, s->data, 0.0, s->y, s->yp, 50.0);
    if (!status) status = mbsr_newton_multiply(newton, s->y, s->out + MOST);
    mbsr_newton_destroy(newton);
    return status;
}

static int has_small_masses(scene *s)
{
    const mbsr_small_part slider = {4, MBSR_MASS | MBSR_MOMENT};
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    mbsr_small_masses *small;
    mbsr_error error = {.text = ""};
    opt.duration = 10.0;
    opt.parts = 1;
    opt.part = &slider;
    int status = mbsr_small_masses_create(s->model, &opt, &small, &error);
    if (!status) status = mbsr_small_masses_start(small, 0.0, s->q, s->u);
    mbsr_small_masses_destroy(small);
    return status;
}

/* ---- the test ---- */

enum { OPEN = 1, CLOSED = 2, OPEN_MASSLESS = 4, CLOSED_MASSLESS = 8, ALL = 15 };

/* Acts and of which models. */
static const struct act {
    const char *name;
    int (*act)(scene *s);
    int models;
} acts[] = {
    {"is_staged", is_staged, ALL},
    {"has_loops", has_loops, ALL},
    {"has_dynamics", has_dynamics, OPEN | CLOSED},
    {"has_inverse_dynamics", has_inverse_dynamics, ALL},
    {"is_refined", is_refined, OPEN},
    {"has_a_residual", has_a_residual, OPEN | OPEN_MASSLESS},
    {"starts", starts, ALL},
    {"starts_in_index1", starts_in_index1, OPEN | OPEN_MASSLESS},
    {"has_index", has_index, ALL},
    {"is_linearised", is_linearised, ALL},
    {"is_multiplied", is_multiplied, ALL},
    {"is_completed", is_completed, ALL},
    {"is_stepped", is_stepped, ALL},
    {"has_derivatives", has_derivatives, OPEN | CLOSED},
    {"is_an_equation", is_an_equation, OPEN | OPEN_MASSLESS},
    {"has_small_masses", has_small_masses, OPEN},
};

/* The k-th call fails, alone or with all behind it. A single one may be evaded: another way is
 * taken, or a shorter step. */
static void one_fails(scene *s, const struct act *a, const char *what, long k, bool rest)
{
    with = k % 2 ? 41 : -41;
    asked = 0, fail_at = k, fail_on = rest;
    const int status = a->act(s);
    if (asked < k || (status != with && (rest || status != MBSR_OK)))
        fail_msg("%s: %s: call %ld fails with %d: %s (%d)", what, a->name, k, with,
                 mbsr_status_name(status), status);
    fail_at = 0;
}

/* The first calls, then ever fewer of them. */
static void each_fails(scene *s, const struct act *a, const char *what)
{
    static double good[4 * MOST];
    memset(s->out, 0, sizeof s->out);
    asked = 0;
    assert_ok(a->act(s), mbsr_data_error(s->data));
    memcpy(good, s->out, sizeof good);
    const long calls = asked, slow = calls > 100000, fewer = test_seeds(1, 4);
    for (long k = 1; k <= calls; k += slow ? 100 * k : 1 + k / fewer) {
        one_fails(s, a, what, k, true);
        one_fails(s, a, what, k, false);
        if (calls > 1000 && k < calls / 2) continue;
        memset(s->out, 0, sizeof s->out);
        assert_ok(a->act(s), mbsr_data_error(s->data));
        if (memcmp(good, s->out, sizeof good) != 0)
            fail_msg("%s: %s: other numbers after call %ld of %ld failed", what, a->name, k, calls);
    }
}

static void every_status_is_handed_on(void **state)
{
    static const char *const what[] = {"open", "closed", "open, without mass",
                                       "closed, without mass"};
    (void)state;
    for (int k = 0; k < 4; ++k) {
        scene s;
        make(&s, k & 1, k & 2);
        for (size_t l = 0; l < sizeof acts / sizeof *acts; ++l)
            if (acts[l].models & 1 << k) each_fails(&s, acts + l, what[k]);
        mbsr_data_destroy(s.data);
        mbsr_model_destroy(s.model);
        assert_int_equal(memory.live, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_status_is_handed_on)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

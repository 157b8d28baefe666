/* What is asked of small mechanisms: see acts.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"

#include "expect.h"

#include <mbsrank/driver.h>

#include <string.h>

/* ---- functions of the caller's ---- */

test_acts_counts test_acts_of;

/* What a function of `n` results says, which are good: a status, or MBSR_OK and one of them is not.
 */
static int says(int n, double *const *result)
{
    test_acts_counts *c = &test_acts_of;
    ++c->asked;
    const bool fails =
        c->asked == c->fail_at || (c->fail_on && c->fail_at > 0 && c->asked > c->fail_at);
    if (fails && c->with == 0 && result[c->fail_at % n]) *result[c->fail_at % n] = c->gives;
    return fails ? c->with : 0;
}

static int turn(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    *s = 0.1 * sin(t), *sdot = 0.1 * cos(t), *sddot = -0.1 * sin(t);
    return says(3, (double *[]){s, sdot, sddot});
}

static int law(void *user, double x, double v, double *force, double *energy, double *power)
{
    const double damping = user ? *(const double *)user : 0.0;
    *force = 40.0 * (x - 0.5) + damping * v;
    if (energy) *energy = 20.0 * (x - 0.5) * (x - 0.5);
    if (power) *power = damping * v * v;
    return says(3, (double *[]){force, energy, power});
}

static int push(const mbsr_force_args *args)
{
    args->body[0].f[0] -= 3.0 * args->body[0].p[0] + 0.2 * args->body[0].V[0];
    return says(2, (double *[]){args->body[0].f, args->body[0].f + 1});
}

static const mbsr_force_table pushes = {
    .version = MBSR_FORCE_TABLE_VERSION, .name = "push", .evaluate = push};

static int gap(const mbsr_closure_args *args, double *g)
{
    g[0] = args->body[0].p[1] + 0.3 * args->body[1].p[1] - args->closure->param[0];
    return says(1, &g);
}

static const mbsr_closure_table gaps = {
    .version = MBSR_CLOSURE_TABLE_VERSION, .name = "gap", .position = gap};

/* ---- models ---- */

enum { MOST = TEST_ACTS_MOST };

typedef test_acts_scene scene;

static void add_body(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def b = mbsr_default_body_def();
    b.parent = parent, b.joint = joint, b.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &b, NULL), mbsr_model_error(m));
}

bool test_acts_take(scene *s, mbsr_model *m, mbsr_data *d, double t, const double *q,
                    const double *u)
{
    memset(s, 0, sizeof *s);
    s->model = m, s->data = d, s->t = t;
    s->nq = mbsr_model_nq(m), s->nu = mbsr_model_nu(m);
    s->size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    if (s->size > MOST || s->nu * s->nu > TEST_ACTS_PART) return false;
    memcpy(s->q, q, (size_t)s->nq * sizeof *q);
    memcpy(s->u, u, (size_t)s->nu * sizeof *u);
    return mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, t, s->q, s->u, s->y) == MBSR_OK &&
           mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, t, s->y, s->yp, NULL, NULL) == MBSR_OK;
}

/* Four bars, or three without the pin, with an arm that is driven and a slider on springs that may
 * have no mass. */
void test_acts_make(scene *s, bool closed, test_acts_slider kind)
{
    static const double middle[2] = {0.4, 0.0}, tip[3] = {1.0, 0, 0}, wall[3] = {2.0, 0.4, 0};
    const mbsr_planar_frame none = {0}, elbow = {.x = 0.8}, base = {.x = 1.2};
    const mbsr_inertia bar = mbsr_inertia_planar(1.0, middle, 0.1);
    static double some = 0.7;
    const bool elastic = kind >= TEST_ELASTIC;
    const mbsr_spring spring = {.function = law, .user = elastic ? NULL : &some};

    mbsr_model_def def = mbsr_default_model_def();
    def.allocator = test_counting_allocator(&test_acts_of.memory);
    mbsr_model *m;
    assert_ok(mbsr_model_create(&def, &m, NULL), NULL);
    add_body(m, MBSR_GROUND, mbsr_joint_planar_revolute(none, none), bar);
    add_body(m, 0, mbsr_joint_planar_revolute(elbow, none), bar);
    add_body(m, MBSR_GROUND, mbsr_joint_planar_revolute(base, none), bar);
    add_body(m, 2, mbsr_joint_planar(elbow, none, 0, MBSR_ANGLE, turn, NULL), bar);
    add_body(m, 3, mbsr_joint_planar_prismatic(none, none),
             kind != TEST_HEAVY ? mbsr_inertia_zero() : mbsr_inertia_planar(0.2, middle, 0.01));
    const mbsr_force_def force[] = {mbsr_force_joint_spring(4, 0, 30.0, elastic ? 0.0 : 2.0, 0.1),
                                    mbsr_force_spring(4, NULL, 5, wall, &spring),
                                    mbsr_force_custom(&pushes, 1, (const int[]){2}, NULL),
                                    mbsr_force_gravity(0, -9.81, 0)};
    add_body(m, MBSR_GROUND, mbsr_joint_planar_free(none, none), bar);
    for (size_t k = 0; k < sizeof force / sizeof *force; ++k)
        assert_ok(mbsr_model_add_force(m, force + k, NULL), mbsr_model_error(m));
    mbsr_closure_def pin = mbsr_closure_ball(1, tip, 2, tip);
    mbsr_closure_def own = mbsr_closure_custom(&gaps, 2, (const int[]){5, 0}, 1, 1, NULL);
    own.param[0] = 0.4;
    if (kind == TEST_COMPLIANT) pin.stiffness[0] = 4e4, pin.stiffness[1] = 5e5;
    if (closed) assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
    if (closed) assert_ok(mbsr_model_add_closure(m, &own, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_data *d;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    double q[] = {1.5, -1.4, 1.9, 0.2, 0.3, 0.4, 0.1};
    if (closed) assert_ok(mbsr_assemble(m, d, 0.0, q, NULL, q, NULL), mbsr_data_error(d));
    const double u[8] = {0.0};
    assert_true(test_acts_take(s, m, d, 0.0, q, u));
}

/* ---- what is called ---- */

#define PART(k) (s->out + (size_t)(k)*TEST_ACTS_PART)

/* What has no derivatives, or cannot be tested, is passed by. */
static int tested(int status)
{
    return status == MBSR_ERR_VALUE || status == MBSR_ERR_SPACE ? MBSR_OK : status;
}

static int is_staged(scene *s)
{
    mbsr_model *m = s->model;
    mbsr_data *d = s->data;
    int status = mbsr_stage_positions(m, d, s->t, s->q);
    if (!status) status = mbsr_stage_velocities(m, d, s->u);
    if (!status) status = mbsr_coordinate_rates(m, d, PART(0));
    if (!status) status = mbsr_stage_forces(m, d, NULL);
    if (!status) status = mbsr_energy(m, d, PART(1), PART(1) + 1);
    if (!status) status = mbsr_dissipation(m, d, PART(1) + 2);
    if (!status)
        status = tested(mbsr_tree_momentum(m, d, NULL, PART(1) + 3, PART(1) + 4, PART(1) + 8));
    if (!status) status = mbsr_momenta(m, d, PART(2));
    if (!status) status = mbsr_mass_matrix(m, d, PART(3));
    for (int k = 0; k < mbsr_model_forces(m) && !status; ++k) {
        status = mbsr_force_power(m, d, k, PART(4) + 2 * k, PART(4) + 2 * k + 1);
        if (!status) status = mbsr_force_load(m, d, k, 0, PART(5) + 6 * k, PART(6) + 6 * k);
    }
    return status;
}

static int has_reactions(scene *s)
{
    mbsr_model *m = s->model;
    mbsr_data *d = s->data;
    int status = mbsr_forward_dynamics(m, d, s->t, s->q, s->u, NULL, PART(0));
    if (!status) status = mbsr_stage_accelerations(m, d, PART(0));
    for (int k = 0; k < mbsr_model_bodies(m) && k < 12 && !status; ++k) {
        status = mbsr_body_acceleration(m, d, k, PART(1) + 32 * k);
        if (!status) status = mbsr_joint_reaction(m, d, k, PART(2) + 32 * k);
        if (!status) status = mbsr_body_jacobian(m, d, k, PART(3));
        if (!status) status = mbsr_body_energy(m, d, k, PART(4) + k);
    }
    return status;
}

static int has_loops(scene *s)
{
    mbsr_model *m = s->model;
    mbsr_data *d = s->data;
    mbsr_closure_report report[16];
    int unique[MOST];
    int status = mbsr_stage_positions(m, d, s->t, s->q);
    if (!status) status = mbsr_stage_velocities(m, d, s->u);
    if (!status) status = mbsr_closures_gap(m, d, PART(0));
    if (!status) status = mbsr_closures_rate(m, d, PART(1));
    if (!status) status = mbsr_closures_bias(m, d, PART(2));
    if (!status) status = mbsr_closures_mobility(m, d, PART(3));
    if (!status) status = mbsr_closures_report(m, d, s->t, s->q, report, NULL, unique);
    if (!status) status = mbsr_assemble(m, d, s->t, s->q, NULL, PART(4), NULL);
    return status;
}

static int has_dynamics(scene *s)
{
    const int status = mbsr_forward_dynamics(s->model, s->data, s->t, s->q, s->u, NULL, s->out);
    return status ? status : mbsr_stage_accelerations(s->model, s->data, s->out);
}

static int has_inverse_dynamics(scene *s)
{
    const int status =
        mbsr_inverse_dynamics(s->model, s->data, s->t, s->q, s->u, s->zero, NULL, PART(0));
    return status ? status : mbsr_bias_forces(s->model, s->data, s->t, s->q, s->u, PART(1));
}

static int is_refined(scene *s)
{
    return mbsr_forward_dynamics_refined(s->model, s->data, s->t, s->q, s->u, NULL, PART(0),
                                         PART(1), PART(2));
}

static int has_a_residual(scene *s)
{
    return mbsr_recursive_residual(s->model, s->data, s->t, s->q, s->u, s->zero, NULL, s->out);
}

static int starts_in(scene *s, mbsr_dae_form form)
{
    double share;
    int body;
    mbsr_index1_reset(s->model, s->data);
    memset(s->out, 0, sizeof s->out);
    int status = mbsr_dae_pack(s->model, s->data, form, s->t, s->q, s->u, PART(0));
    if (!status)
        status = mbsr_dae_consistent(s->model, s->data, form, s->t, PART(0), PART(1), NULL, NULL);
    if (!status)
        status = mbsr_dae_residual(s->model, s->data, form, s->t, PART(0), PART(1), PART(2));
    if (!status) status = mbsr_dae_unpack(s->model, s->data, form, s->t, PART(0), PART(3), PART(4));
    if (!status && mbsr_model_rows(s->model) == 0)
        status =
            mbsr_dae_imbalance(s->model, s->data, form, s->t, PART(0), &share, &body, NULL, NULL);
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
    mbsr_index_report *report = NULL;
    const int status = mbsr_index_report_create(s->model, s->data, s->t, s->q, s->u, &report);
    if (status) return status;
    s->out[0] = report->conditioning;
    mbsr_index_report_destroy(s->model, report);
    return status;
}

static int is_linearised(scene *s)
{
    mbsr_newton *newton = NULL;
    int status = mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, NULL, &newton, NULL);
    if (!status) status = mbsr_newton_factor(newton, s->data, s->t, s->y, s->yp, 50.0);
    if (!status) status = mbsr_newton_solve(newton, s->y, PART(0));
    mbsr_newton_destroy(newton);
    return status;
}

static int is_multiplied(scene *s)
{
    mbsr_newton *newton = NULL;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.products = 1;
    int status = mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, &opt, &newton, NULL);
    if (!status) status = mbsr_newton_linearise(newton, s->data, s->t, s->y, s->yp, 50.0);
    if (!status) status = mbsr_newton_multiply(newton, s->y, PART(0));
    if (!status) status = mbsr_newton_multiply_transposed(newton, s->y, PART(1));
    mbsr_newton_destroy(newton);
    return status;
}

static int is_completed(scene *s)
{
    mbsr_completion *completion = NULL;
    memcpy(PART(0), s->y, sizeof s->y);
    memcpy(PART(1), s->yp, sizeof s->yp);
    int status = mbsr_completion_create(s->model, NULL, &completion, NULL);
    if (!status)
        status =
            mbsr_completion_solve(completion, s->data, MBSR_DAE_MOMENTUM, s->t, PART(0), PART(1));
    if (!status)
        status = mbsr_completion_motion(completion, s->data, PART(2), PART(3), PART(4), PART(5));
    mbsr_completion_destroy(completion);
    return status;
}

static int is_stepped(scene *s)
{
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    mbsr_stepper *stepper = NULL;
    opt.h = 1e-3;
    int status = mbsr_stepper_create(s->model, s->data, &opt, &stepper, NULL);
    if (!status) status = mbsr_stepper_start(stepper, s->t, s->q, s->u);
    if (!status) status = mbsr_stepper_step(stepper);
    if (!status) status = mbsr_stepper_motion(stepper, NULL, PART(0), PART(1));
    mbsr_stepper_destroy(stepper);
    return status;
}

static int has_derivatives(scene *s)
{
    mbsr_derivatives *by = NULL;
    int status = mbsr_derivatives_create(s->model, &by, NULL);
    if (!status) status = mbsr_derivatives_forward(by, s->t, s->q, s->u, NULL, PART(0), NULL);
    if (!status) status = mbsr_derivatives_matrices(by, PART(1), PART(2), NULL);
    if (!status) status = mbsr_derivatives_tangent(by, s->u, s->u, s->q, PART(3), PART(3) + MOST);
    if (!status) status = mbsr_derivatives_adjoint(by, s->u, NULL, PART(4), PART(5), PART(6));
    if (!status) status = mbsr_derivatives_inverse(by, s->t, s->q, s->u, s->zero, PART(7));
    if (!status) status = mbsr_derivatives_tangent(by, s->u, s->u, s->q, PART(8), NULL);
    mbsr_derivatives_destroy(by);
    return status;
}

static int has_derivatives_of_residuals(scene *s)
{
    mbsr_derivatives *by = NULL;
    int status = mbsr_derivatives_create(s->model, &by, NULL);
    if (!status) status = mbsr_derivatives_residual(by, s->t, s->y, s->yp, PART(0));
    if (!status) status = mbsr_derivatives_residual_tangent(by, s->y, s->yp, NULL, PART(1));
    if (!status) status = mbsr_derivatives_residual_adjoint(by, s->y, PART(2), PART(3), NULL);
    mbsr_derivatives_destroy(by);
    return status;
}

/* In up to forty parameters, those that have derivatives. */
static int has_derivatives_in_parameters(scene *s)
{
    enum { MANY = 40 };
    mbsr_parameters *list = NULL;
    mbsr_derivatives *by = NULL;
    int which[MANY], count = 0;
    int status = mbsr_parameters_create(s->model, &list, NULL);
    const int all = mbsr_parameters_count(list), step = 1 + all / MANY;
    if (!status) status = mbsr_derivatives_create(s->model, &by, NULL);
    for (int k = 0; k < all && !status; k += step) {
        status = mbsr_derivatives_parameters(by, list, 1, &k);
        if (!status) which[count++] = k;
        status = tested(status);
    }
    if (!status) status = mbsr_derivatives_parameters(by, list, count, which);
    if (!status) status = mbsr_derivatives_forward(by, s->t, s->q, s->u, NULL, PART(0), NULL);
    if (!status) status = mbsr_derivatives_parameter_tangent(by, s->y, PART(1), NULL);
    if (!status) status = mbsr_derivatives_parameter_adjoint(by, s->u, NULL, PART(2));
    if (!status) status = mbsr_derivatives_residual(by, s->t, s->y, s->yp, NULL);
    if (!status) status = mbsr_derivatives_residual_tangent(by, s->y, s->yp, s->y, PART(6));
    if (!status) status = mbsr_derivatives_residual_adjoint(by, s->y, PART(3), PART(4), PART(5));
    mbsr_derivatives_destroy(by);
    mbsr_parameters_destroy(list);
    return status;
}

static int is_an_equation(scene *s)
{
    mbsr_ode *ode = NULL;
    int status = mbsr_ode_create(s->model, s->data, s->t, s->q, s->u, &ode);
    if (!status) status = mbsr_ode_pack(ode, s->t, s->q, s->u, PART(0));
    if (!status) status = mbsr_ode_rhs(ode, s->t, PART(0), PART(1));
    if (!status) memcpy(PART(2), s->u, sizeof s->u);
    if (!status) status = mbsr_ode_velocities(ode, s->t, PART(0), PART(2));
    mbsr_ode_destroy(ode);
    return status;
}

static int verify_joint(scene *s, int body)
{
    double p[MBSR_POSE_SIZE] = {0}, V[MOST];
    mbsr_joint_test at = mbsr_default_joint_test();
    mbsr_joint_errors errors;
    mbsr_body_def def;
    int q, nq, u, n;
    const int parent = mbsr_body_parent(s->model, body);
    int status = mbsr_body_definition(s->model, body, &def);
    if (!status) status = mbsr_body_coordinates(s->model, body, &q, &nq, &u, &n);
    if (status || parent == MBSR_GROUND || mbsr_body_pose_size(s->model, parent) > MBSR_POSE_SIZE)
        return status;
    status = mbsr_body_pose(s->model, s->data, parent, p);
    if (!status) status = mbsr_body_twist(s->model, s->data, parent, V);
    at.t = s->t, at.q = s->q + q, at.u = s->u + u, at.p_pred = p, at.V_pred = V;
    return status ? status : tested(mbsr_joint_verify(&def.joint, &at, &errors, NULL));
}

static int is_verified(scene *s)
{
    mbsr_force_errors force;
    mbsr_closure_errors closure;
    int status = mbsr_stage_positions(s->model, s->data, s->t, s->q);
    if (!status) status = mbsr_stage_velocities(s->model, s->data, s->u);
    for (int k = 0; k < mbsr_model_forces(s->model) && !status; ++k)
        status = tested(mbsr_force_verify(s->model, s->data, k, &force));
    for (int k = 0; k < mbsr_model_closures(s->model) && !status; ++k)
        status = mbsr_closure_verify(s->model, s->data, k, &closure);
    for (int k = 0; k < mbsr_model_bodies(s->model) && !status; ++k) status = verify_joint(s, k);
    return status;
}

static int is_copied(scene *s)
{
    mbsr_model *copy = NULL;
    mbsr_data *data = NULL;
    int status = mbsr_model_copy(s->model, &copy, NULL);
    if (!status) status = mbsr_model_finish(copy);
    if (!status) status = mbsr_data_create(copy, &data, NULL);
    if (!status)
        status = mbsr_inverse_dynamics(copy, data, s->t, s->q, s->u, s->zero, NULL, s->out);
    mbsr_data_destroy(data);
    mbsr_model_destroy(copy);
    return status;
}

static int has_small_masses(scene *s)
{
    const mbsr_small_part slider = {4, MBSR_MASS | MBSR_MOMENT};
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    mbsr_small_masses *small = NULL;
    mbsr_error error = {.text = ""};
    opt.duration = 10.0;
    opt.parts = 1;
    opt.part = &slider;
    int status = mbsr_small_masses_create(s->model, &opt, &small, &error);
    if (!status) status = mbsr_small_masses_start(small, s->t, s->q, s->u);
    mbsr_small_masses_destroy(small);
    return status;
}

/* ---- the table ---- */

/* Acts and of which models. */
const test_acts test_acts_table[] = {
    {"is_staged", is_staged, TEST_ALL},
    {"has_reactions", has_reactions, TEST_OPEN | TEST_CLOSED},
    {"has_loops", has_loops, TEST_ALL},
    {"has_dynamics", has_dynamics, TEST_OPEN | TEST_CLOSED},
    {"has_inverse_dynamics", has_inverse_dynamics, TEST_ALL},
    {"is_refined", is_refined, TEST_OPEN},
    {"has_a_residual", has_a_residual, TEST_OPEN | TEST_OPEN_MASSLESS},
    {"starts", starts, TEST_ALL},
    {"starts_in_index1", starts_in_index1, TEST_OPEN | TEST_OPEN_MASSLESS},
    {"has_index", has_index, TEST_ALL},
    {"is_linearised", is_linearised, TEST_ALL},
    {"is_multiplied", is_multiplied, TEST_ALL},
    {"is_completed", is_completed, TEST_ALL},
    {"is_stepped", is_stepped, TEST_ALL},
    {"has_derivatives", has_derivatives, TEST_OPEN | TEST_CLOSED},
    {"has_derivatives_of_residuals", has_derivatives_of_residuals, TEST_ALL},
    {"is_an_equation", is_an_equation, TEST_OPEN | TEST_OPEN_MASSLESS},
    {"has_small_masses", has_small_masses, TEST_OPEN},
    {"is_verified", is_verified, 0},
    {"is_copied", is_copied, 0},
    {"has_derivatives_in_parameters", has_derivatives_in_parameters, 0},
    {NULL, NULL, 0},
};

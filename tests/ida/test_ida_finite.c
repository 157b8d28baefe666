/* The driver and the solver for SUNDIALS: no number that is not finite with MBSR_OK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "finite.h"
#include "problems.h"

#include <mbsrank/sensitivity.h>
#include <mbsrank/sundials.h>

#include "ida/compat.h"

#include <nvector/nvector_serial.h>

enum { T = 1u << FINITE_T, C = 1u << FINITE_C, Y = 1u << FINITE_Y, YP = 1u << FINITE_YP };
enum { Q = 1u << FINITE_Q, U = 1u << FINITE_U };
enum { R = 1u << FINITE_R, OTHER = 1u << FINITE_OTHER, SIZE = 6 };

static double y_good[SIZE], yp_good[SIZE];

static double time_of(const finite_subject *s)
{
    return s->in[FINITE_T][0];
}

static const mbsr_error *ida_error(const finite_subject *s)
{
    return mbsr_ida_error(s->object);
}

static int start(finite_subject *s)
{
    return mbsr_ida_start(s->object, 0.0, y_good, yp_good);
}

static int advance(finite_subject *s)
{
    const int status = start(s);
    return status ? status : mbsr_ida_advance(s->object, 0.3, NULL, NULL, NULL);
}

static int run_start(finite_subject *s)
{
    const int status = mbsr_ida_start(s->object, time_of(s), s->in[FINITE_Y], s->in[FINITE_YP]);
    return status ? status : mbsr_ida_state(s->object, s->out[0], s->out[1], s->out[2]);
}

static int run_advance(finite_subject *s)
{
    return mbsr_ida_advance(s->object, time_of(s), s->out[0], s->out[1], s->out[2]);
}

static int run_sample(finite_subject *s)
{
    return mbsr_ida_sample(s->object, time_of(s), s->out[0], s->out[1], s->out[2]);
}

static int output(void *user, int index, double t, const double *y, const double *yp)
{
    finite_subject *s = user;
    (void)index;
    if (s->out[0]) *s->out[0] = t;
    if (s->out[1]) memcpy(s->out[1], y, SIZE * sizeof *y);
    if (s->out[2]) memcpy(s->out[2], yp, SIZE * sizeof *yp);
    return 0;
}

static int run_run(finite_subject *s)
{
    int next = 0;
    return mbsr_ida_run(s->object, 2, s->in[FINITE_OTHER], &next, output, s);
}

static int run_state(finite_subject *s)
{
    return mbsr_ida_state(s->object, s->out[0], s->out[1], s->out[2]);
}

static int run_motion(finite_subject *s)
{
    return mbsr_ida_motion(s->object, s->out[1], NULL, NULL, NULL);
}

static int run_dense(finite_subject *s)
{
    return mbsr_ida_dense(s->object, time_of(s), 1, s->out[1]);
}

static int run_stats(finite_subject *s)
{
    mbsr_ida_stats stats;
    const int status = mbsr_ida_get_stats(s->object, &stats);
    if (!status && s->out[0]) s->out[0][0] = stats.last_step;
    return status;
}

static int run_drift(finite_subject *s)
{
    mbsr_ida_drift drift;
    const int status = mbsr_ida_get_drift(s->object, &drift);
    if (!status && s->out[0]) s->out[0][0] = drift.energy + drift.energy_change + drift.largest_gap;
    return status;
}

/* ---- for an IDA of one's own ---- */

static const mbsr_error *link_error(const finite_subject *s)
{
    const mbsr_sundials *link = s->object;
    return mbsr_newton_error(link->newton);
}

static SUNContext context;

static int run_precondition(finite_subject *s)
{
    if (!s->out[1]) return MBSR_OK; /* vectors are never NULL */
    mbsr_sundials *link = s->object;
    N_Vector y = N_VMake_Serial(SIZE, s->in[FINITE_Y], context),
             yp = N_VMake_Serial(SIZE, s->in[FINITE_YP], context),
             r = N_VMake_Serial(SIZE, s->in[FINITE_R], context),
             z = N_VMake_Serial(SIZE, s->out[1], context);
    int status = mbsr_sundials_setup(time_of(s), y, yp, r, s->in[FINITE_C][0], link);
    if (!status)
        status =
            mbsr_sundials_precondition(time_of(s), y, yp, r, r, z, s->in[FINITE_C][0], 0.0, link);
    N_VDestroy(y);
    N_VDestroy(yp);
    N_VDestroy(r);
    N_VDestroy(z);
    return status;
}

static int run_product(finite_subject *s)
{
    if (!s->out[1]) return MBSR_OK;
    mbsr_sundials *link = s->object;
    const double c = s->in[FINITE_C][0];
    N_Vector y = N_VMake_Serial(SIZE, s->in[FINITE_Y], context),
             yp = N_VMake_Serial(SIZE, s->in[FINITE_YP], context),
             r = N_VMake_Serial(SIZE, s->in[FINITE_R], context),
             z = N_VMake_Serial(SIZE, s->out[1], context);
    int status = mbsr_sundials_linearise(time_of(s), y, yp, r, c, link);
    if (!status) status = mbsr_sundials_multiply(time_of(s), y, yp, r, r, z, c, link, NULL, NULL);
    N_VDestroy(y);
    N_VDestroy(yp);
    N_VDestroy(r);
    N_VDestroy(z);
    return status;
}

/* ---- sensitivities: one parameter, one time ---- */

static const mbsr_error *sensitivity_error(const finite_subject *s)
{
    return mbsr_sensitivity_error(s->object);
}

static int start_sensitivity(finite_subject *s)
{
    const double end = 0.4;
    return mbsr_sensitivity_run(s->object, 0.0, s->in[FINITE_Q], s->in[FINITE_U], 1, &end, NULL,
                                NULL);
}

static int run_sensitivity(finite_subject *s)
{
    const double end = 0.4;
    return mbsr_sensitivity_run(s->object, time_of(s), s->in[FINITE_Q], s->in[FINITE_U], 1, &end,
                                s->out[0], NULL);
}

static int run_sensitivity_forward(finite_subject *s)
{
    return mbsr_sensitivity_forward(s->object, s->out[0], NULL);
}

static int run_sensitivity_adjoint(finite_subject *s)
{
    double by[1];
    const int status = mbsr_sensitivity_adjoint(s->object, s->in[FINITE_OTHER], NULL, by);
    if (!status && s->out[0]) s->out[0][0] = s->out[0][1] = by[0];
    return status;
}

static int of_gradient(const finite_subject *s, int o)
{
    (void)s;
    return o == 0 ? 2 : 0;
}

static int of_run(const finite_subject *s, int o)
{
    (void)s;
    return o == 0 ? 1 : SIZE;
}

static int of_motion(const finite_subject *s, int o)
{
    return o == 1 ? s->nq : 0;
}

static int of_dense(const finite_subject *s, int o)
{
    (void)s;
    return o == 1 ? SIZE : 0;
}

static int of_one(const finite_subject *s, int o)
{
    (void)s;
    return o == 0;
}

static const finite_row rows[] = {
    {"mbsr_ida_start", run_start, NULL, 0, T | Y | YP, FINITE_OBJECT, of_run},
    {"mbsr_ida_advance", run_advance, start, 0, T, FINITE_OBJECT, of_run},
    {"mbsr_ida_sample", run_sample, start, 0, T, FINITE_OBJECT, of_run},
    {"mbsr_simulation_begin", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_of", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_add_body", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_add_force", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_add_closure", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_add_table", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_add_data", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_accelerations", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_reactions", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_check", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_get_stats", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_set_position", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_set_rate", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_set_none", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_start", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_to", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_sample", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_forgive", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_time", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_q", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_u", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_model", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_data", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_ida", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_status", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_error", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_simulation_end", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ida_jump", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ida_run", run_run, start, 0, OTHER, FINITE_OBJECT, of_run},
    {"mbsr_ida_state", run_state, advance, 0, 0, FINITE_OBJECT, of_run},
    {"mbsr_ida_motion", run_motion, advance, 0, 0, FINITE_OBJECT, of_motion},
    {"mbsr_ida_dense", run_dense, advance, 0, T, FINITE_OBJECT, of_dense},
    {"mbsr_ida_get_stats", run_stats, advance, 0, 0, FINITE_OBJECT, of_one},
    {"mbsr_ida_get_drift", run_drift, advance, 0, 0, FINITE_OBJECT, of_one},
    {"mbsr_ida_stiffest", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ida_event_info", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_default_ida_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ida_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ida_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ida_error", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ida_newton", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_ida_memory", NULL, NULL, 0, 0, 0, NULL},
};

/* Bad times and weights are refused: test_ida_sensitivity.c. */
static const finite_row sensitivity_rows[] = {
    {"mbsr_default_sensitivity_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sensitivity_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sensitivity_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sensitivity_steps", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sensitivity_error", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sensitivity_run", run_sensitivity, NULL, 0, T | Q | U, FINITE_OBJECT, of_gradient},
    {"mbsr_sensitivity_forward", run_sensitivity_forward, start_sensitivity, 0, 0, FINITE_OBJECT,
     of_gradient},
    {"mbsr_sensitivity_adjoint", run_sensitivity_adjoint, start_sensitivity, 0, OTHER,
     FINITE_OBJECT, of_gradient},
};

static const finite_row sundials_rows[] = {
    {"mbsr_sundials_matrix", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sundials_solver", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sundials_jacobian", NULL, NULL, 0, 0, 0, NULL}, /* the same as setup */
    {"mbsr_sundials_stiff", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sundials_stiff_set_rtol", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sundials_stiff_set_renewal", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sundials_stiff_get_info", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sundials_stiffest", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_sundials_setup", run_precondition, NULL, T | C | Y | R, 0, 0, of_dense},
    {"mbsr_sundials_precondition", run_precondition, NULL, T | C | Y | R, 0, 0, of_dense},
    {"mbsr_sundials_linearise", run_product, NULL, T | C | Y | R, 0, 0, of_dense},
    {"mbsr_sundials_multiply", run_product, NULL, T | C | Y | R, 0, 0, of_dense},
};

static finite_subject subject(const problem *p)
{
    static const double r[SIZE] = {0.1, -0.2, 0.3, 0.4, -0.5, 0.6};
    finite_subject s = {.model = p->model, .data = p->data, .form = MBSR_DAE_MOMENTUM};
    finite_give(&s, FINITE_T, 1, (double[]){0.3});
    finite_give(&s, FINITE_C, 1, (double[]){40.0});
    finite_give(&s, FINITE_Y, SIZE, y_good);
    finite_give(&s, FINITE_YP, SIZE, yp_good);
    finite_give(&s, FINITE_R, SIZE, r);
    finite_give(&s, FINITE_OTHER, 2, (double[]){0.1, 0.2});
    return s;
}

/* A particle on springs in the plane: two coordinates. */
static void oscillator(problem *p)
{
    problem_oscillator(p, NULL);
    const double q[2] = {1.0, 0.5}, u[2] = {0.0, 0.3};
    assert_int_equal(mbsr_dae_size(p->model, MBSR_DAE_MOMENTUM), SIZE);
    assert_ok(mbsr_dae_pack(p->model, p->data, MBSR_DAE_MOMENTUM, 0.0, q, u, y_good),
              mbsr_data_error(p->data));
    assert_ok(
        mbsr_dae_consistent(p->model, p->data, MBSR_DAE_MOMENTUM, 0.0, y_good, yp_good, NULL, NULL),
        mbsr_data_error(p->data));
}

static void the_driver(void **unused)
{
    (void)unused;
    static const mbsr_ida_solver solvers[] = {MBSR_IDA_DENSE, MBSR_IDA_TREE, MBSR_IDA_KRYLOV};
    static const char *const names[] = {"dense", "tree", "Krylov"};
    problem p;
    oscillator(&p);
    for (int k = 0; k < 3; ++k) {
        finite_subject s = subject(&p);
        mbsr_ida_opt opt = mbsr_default_ida_opt();
        mbsr_ida *ida;
        opt.linear_solver = solvers[k];
        opt.max_steps = 500;
        assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
        s.name = names[k];
        s.object = ida;
        s.error = ida_error;
        for (size_t l = 0; l < sizeof rows / sizeof rows[0]; ++l) {
            const int served = finite_try(&s, rows + l);
            if (rows[l].run && rows[l].length) assert_int_equal(served, 1);
        }
        mbsr_ida_destroy(ida);
        finite_free(&s);
    }
    problem_free(&p);
}

static void ignore(void *user, int code, const char *message)
{
    (void)user, (void)code, (void)message;
}

static void the_solver_for_sundials(void **unused)
{
    (void)unused;
    problem p;
    oscillator(&p);
    mbsri_ida_messages messages = {ignore, NULL};
    mbsr_sundials link = {.data = p.data};
    assert_true(mbsri_ida_context(&context, &messages));
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.products = 1;
    assert_ok(mbsr_newton_create(p.model, MBSR_DAE_MOMENTUM, &opt, &link.newton, NULL), NULL);
    finite_subject s = subject(&p);
    s.name = "an IDA of one's own";
    s.object = &link;
    s.error = link_error;
    for (size_t l = 0; l < sizeof sundials_rows / sizeof sundials_rows[0]; ++l) {
        const int served = finite_try(&s, sundials_rows + l);
        if (sundials_rows[l].run) assert_int_equal(served, 1);
    }
    mbsr_newton_destroy(link.newton);
    SUNContext_Free(&context);
    finite_free(&s);
    problem_free(&p);
}

static void sensitivities(void **unused)
{
    (void)unused;
    problem p;
    mbsr_parameters *list;
    mbsr_sensitivity *object;
    mbsr_error error;
    const int which = 0;
    oscillator(&p);
    assert_ok(mbsr_parameters_create(p.model, &list, &error), &error);
    mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
    opt.list = list, opt.which = &which, opt.parameters = 1;
    opt.ida.max_steps = 500;
    assert_ok(mbsr_sensitivity_create(p.model, &opt, &object, &error), &error);
    finite_subject s = subject(&p);
    finite_give(&s, FINITE_Q, 2, (double[]){1.0, 0.5});
    finite_give(&s, FINITE_U, 2, (double[]){0.0, 0.3});
    s.name = "sensitivities";
    s.object = object;
    s.error = sensitivity_error;
    for (size_t l = 0; l < sizeof sensitivity_rows / sizeof sensitivity_rows[0]; ++l) {
        const int served = finite_try(&s, sensitivity_rows + l);
        if (sensitivity_rows[l].run) assert_int_equal(served, 1);
    }
    finite_free(&s);
    mbsr_sensitivity_destroy(object);
    mbsr_parameters_destroy(list);
    problem_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_driver),
        cmocka_unit_test(sensitivities),
        cmocka_unit_test(the_solver_for_sundials),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Where stiff elements end a run its error names them, whatever failed.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Two rods whose tip a stiff spring holds on a rail (element 2). IDA may try no step twice. */
#include "reference_runs.h"

#include "ida/compat.h"

#include <mbsrank/sundials.h>

#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

enum { RAIL = 2, BODIES = 4, MOST = 3 * BODIES + 2 };

/* `coupled`: a wheel turns with the first rod, by a closure. */
static mbsr_model *make(int coupled, double stiffness, double damping)
{
    const mbsr_planar_frame here = {0.0, 0.0, 0.0}, end = {0.4, 0.0, 0.0};
    mbsr_model *m = run_model();
    int body = MBSR_GROUND, first = 0;
    for (int k = 0; k < 2; ++k) {
        body = run_body(m, "rod", body, mbsr_joint_planar_revolute(k ? end : here, here),
                        mbsr_inertia_planar(1.0, (double[2]){0.2, 0.0}, 0.013));
        if (k == 0) first = body;
    }
    const int tip =
        run_body(m, "tip", body, mbsr_joint_point(end, 0, 0, NULL, NULL), mbsr_inertia_zero());
    run_force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
    run_force(m, mbsr_force_joint_spring(first, 0, 1.0, 0.1, 0.0));
    run_force(m, mbsr_force_axis_spring(tip, MBSR_GROUND, 1, stiffness, damping, 0.0));
    if (coupled) {
        const int wheel = run_body(m, "wheel", MBSR_GROUND, mbsr_joint_planar_revolute(here, here),
                                   mbsr_inertia_planar(0.5, (double[2]){0.0, 0.0}, 0.01));
        const mbsr_closure_def gear = mbsr_closure_coupling(
            2, (int[2]){first, wheel}, (int[2]){0, 0}, (double[2]){1.0, -1.0}, 0.0);
        assert_ok(mbsr_model_add_closure(m, &gear, NULL), mbsr_model_error(m));
    }
    return run_finish(m);
}

static void find_start(const mbsr_model *m, mbsr_data *d, mbsr_dae_form form, double *y, double *yp)
{
    const double q[BODIES] = {0.7, -1.4, 0.0, 0.7}, u[BODIES] = {2.0, -4.0, 0.0, 2.0};
    double at[BODIES] = {0}, rate[BODIES] = {0};
    const int nq = mbsr_model_nq(m);
    assert_in_range(nq, 2, BODIES);
    for (int k = 0; k < 2; ++k) at[k] = q[k], rate[k] = u[k];
    if (mbsr_model_rows(m) > 0) at[nq - 1] = q[0], rate[nq - 1] = u[0];
    assert_ok(mbsr_dae_pack(m, d, form, 0.0, at, rate, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, form, 0.0, y, yp, NULL, NULL), mbsr_data_error(d));
}

typedef enum kind { ERROR_TESTS, ITERATIONS } kind;
static const char *const words[] = {"error tests fail by the stiffness of force element 2",
                                    "Newton's method fails by the stiffness of force element 2"};

static void end_run(mbsr_dae_form form, mbsr_ida_solver solver, int coupled, kind which, int soft)
{
    double y[MOST], yp[MOST], share[2];
    int force[2], count = 0;
    mbsr_model *m = soft ? make(coupled, 10.0, 0.1) : make(coupled, 1e9, 1e4);
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = form;
    opt.linear_solver = solver;
    if (which == ITERATIONS) opt.rtol = opt.atol = 1e-3, opt.initial_step = 0.2;
    if (soft) opt.initial_step = 0.05; /* too long for the tolerance */
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    find_start(m, d, form, y, yp);
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    void *const memory = mbsr_ida_memory(ida);
    if (which == ERROR_TESTS) assert_int_equal(IDASetMaxErrTestFails(memory, 1), IDA_SUCCESS);
    if (which == ITERATIONS) {
        assert_int_equal(IDASetMaxConvFails(memory, 1), IDA_SUCCESS);
        assert_int_equal(IDASetMaxNonlinIters(memory, 1), IDA_SUCCESS);
    }
    const int status = mbsr_ida_advance(ida, 3.0, NULL, y, NULL);
    const mbsr_error *error = mbsr_ida_error(ida);
    print_message("%s, solver %d%s: %s\n", run_form_name(form), (int)solver,
                  coupled ? ", coupled" : "", error->text);
    assert_int_equal(status, MBSR_ERR_SOLVER);
    if (soft) assert_null(strstr(error->text, "force element"));
    if (!soft) assert_non_null(strstr(error->text, words[which]));
    if (!soft) assert_non_null(strstr(error->text, "as_closure"));
    assert_int_equal(error->force, soft ? MBSR_NONE : RAIL);
    assert_ok(mbsr_ida_stiffest(ida, 2, force, share, &count), mbsr_ida_error(ida));
    assert_true(soft ? count == 0 : count > 0 && share[0] > 0.5 && force[0] == RAIL);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void whatever_fails_the_elements_are_named(void **state)
{
    (void)state;
    static const struct {
        mbsr_dae_form form;
        mbsr_ida_solver solver;
        int coupled;
    } way[] = {
        {MBSR_DAE_MOMENTUM, MBSR_IDA_TREE, 0},          {MBSR_DAE_MOMENTUM, MBSR_IDA_DENSE, 0},
        {MBSR_DAE_MOMENTUM, MBSR_IDA_KRYLOV, 0},        {MBSR_DAE_RECURSIVE, MBSR_IDA_DENSE, 0},
        {MBSR_DAE_INVERSE_DYNAMICS, MBSR_IDA_DENSE, 0}, {MBSR_DAE_INDEX1, MBSR_IDA_DENSE, 0},
        {MBSR_DAE_MOMENTUM, MBSR_IDA_TREE, 1},          {MBSR_DAE_MOMENTUM, MBSR_IDA_DENSE, 1}};
    for (size_t k = 0; k < sizeof way / sizeof way[0]; ++k) {
        end_run(way[k].form, way[k].solver, way[k].coupled, ERROR_TESTS, 0);
        end_run(way[k].form, way[k].solver, way[k].coupled, ITERATIONS, 0);
        end_run(way[k].form, way[k].solver, way[k].coupled, ERROR_TESTS, 1);
    }
}

/* ---- an IDA of one's own ---- */

typedef struct mine {
    mbsr_model *model;
    mbsr_data *data;
} mine;

static int residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, void *user)
{
    const mine *my = user;
    return mbsr_dae_residual(my->model, my->data, MBSR_DAE_MOMENTUM, t, N_VGetArrayPointer(y),
                             N_VGetArrayPointer(yp), N_VGetArrayPointer(F));
}

static void ignore(void *user, int code, const char *message)
{
    (void)user, (void)code, (void)message;
}

/* What such a solver is asked, where something is missing or it is another one. */
static void wrong_calls(const mine *my, SUNNonlinearSolver newton, SUNNonlinearSolver other)
{
    mbsr_sundials_stiff_info info;
    double share[2];
    int force[2], count;
    const struct {
        SUNNonlinearSolver solver;
        int model, data, count, force, share, status;
    } calls[] = {{NULL, 1, 1, 1, 1, 1, MBSR_ERR_NULL},   {newton, 0, 1, 1, 1, 1, MBSR_ERR_NULL},
                 {newton, 1, 0, 1, 1, 1, MBSR_ERR_NULL}, {newton, 1, 1, 0, 1, 1, MBSR_ERR_NULL},
                 {newton, 1, 1, 1, 0, 1, MBSR_ERR_NULL}, {newton, 1, 1, 1, 1, 0, MBSR_ERR_NULL},
                 {other, 1, 1, 1, 1, 1, MBSR_ERR_VALUE}};
    for (size_t k = 0; k < sizeof calls / sizeof *calls; ++k)
        assert_int_equal(mbsr_sundials_stiffest(
                             calls[k].solver, calls[k].model ? my->model : NULL,
                             calls[k].data ? my->data : NULL, 2, calls[k].force ? force : NULL,
                             calls[k].share ? share : NULL, calls[k].count ? &count : NULL),
                         calls[k].status);
    assert_int_equal(mbsr_sundials_stiff_set_rtol(NULL, 1e-3), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sundials_stiff_set_rtol(other, 1e-3), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_set_rtol(newton, -1.0), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_set_rtol(newton, NAN), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_set_rtol(newton, INFINITY), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_set_renewal(NULL, 0.5), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sundials_stiff_set_renewal(other, 0.5), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_set_renewal(newton, -0.1), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_set_renewal(newton, 1.0), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_get_info(NULL, &info), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sundials_stiff_get_info(newton, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sundials_stiff_get_info(other, &info), MBSR_ERR_VALUE);
}

static void end_own_run(kind which)
{
    mine my = {.model = make(0, 1e9, 1e4)};
    mbsri_ida_messages messages = {ignore, NULL};
    SUNContext context = NULL;
    double share[2], reached = 0.0;
    int force[2], count = -1;
    assert_ok(mbsr_data_create(my.model, &my.data, NULL), NULL);
    assert_true(mbsri_ida_context(&context, &messages));
    const int n = mbsr_dae_size(my.model, MBSR_DAE_MOMENTUM);
    N_Vector y = N_VNew_Serial(n, context), yp = N_VClone(y), id = N_VClone(y);
    find_start(my.model, my.data, MBSR_DAE_MOMENTUM, N_VGetArrayPointer(y), N_VGetArrayPointer(yp));
    assert_ok(mbsr_dae_id(my.model, my.data, MBSR_DAE_MOMENTUM, N_VGetArrayPointer(id)), NULL);
    void *ida = IDACreate(context);
    SUNNonlinearSolver newton = mbsr_sundials_stiff(my.model, y, context);
    SUNMatrix matrix = SUNDenseMatrix(n, n, context);
    SUNLinearSolver solver = SUNLinSol_Dense(y, matrix, context);
    assert_int_equal(mbsri_ida_redirect(ida, &messages), IDA_SUCCESS);
    assert_int_equal(IDAInit(ida, residual, 0.0, y, yp), IDA_SUCCESS);
    assert_int_equal(IDASStolerances(ida, 1e-6, 1e-6), IDA_SUCCESS);
    assert_int_equal(IDASetUserData(ida, &my), IDA_SUCCESS);
    assert_int_equal(IDASetLinearSolver(ida, solver, matrix), IDA_SUCCESS);
    assert_int_equal(IDASetId(ida, id), IDA_SUCCESS);
    assert_int_equal(IDASetSuppressAlg(ida, SUNTRUE), IDA_SUCCESS);
    assert_int_equal(IDASetNonlinearSolver(ida, newton), IDA_SUCCESS);
    assert_int_equal(IDASetInitStep(ida, which == ITERATIONS ? 0.2 : 1e-5), IDA_SUCCESS);
    if (which == ITERATIONS) {
        assert_int_equal(IDASetMaxConvFails(ida, 1), IDA_SUCCESS);
        assert_int_equal(IDASetMaxNonlinIters(ida, 1), IDA_SUCCESS);
    } else {
        assert_int_equal(IDASetMaxErrTestFails(ida, 1), IDA_SUCCESS);
    }
    assert_int_equal(mbsr_sundials_stiffest(newton, my.model, my.data, 2, force, share, &count),
                     MBSR_OK);
    assert_int_equal(count, 0); /* it has not been used yet */
    const int flag = IDASolve(ida, 3.0, &reached, y, yp, IDA_NORMAL);
    assert_int_equal(flag, which == ITERATIONS ? IDA_CONV_FAIL : IDA_ERR_FAIL);
    assert_int_equal(mbsr_sundials_stiffest(newton, my.model, my.data, 2, force, share, &count),
                     MBSR_OK);
    assert_true(count > 0 && share[0] > 0.5 && force[0] == RAIL);
    assert_int_equal(mbsr_sundials_stiffest(newton, my.model, my.data, 0, NULL, NULL, &count),
                     MBSR_OK);
    assert_int_equal(count, 0);
    SUNNonlinearSolver plain = SUNNonlinSol_Newton(y, context);
    wrong_calls(&my, newton, plain);
    SUNNonlinSolFree(plain);
    mbsr_model *other = make(1, 1e9, 1e4);
    assert_int_equal(mbsr_sundials_stiffest(newton, other, my.data, 2, force, share, &count),
                     MBSR_ERR_VALUE);
    mbsr_model_destroy(other);
    IDAFree(&ida);
    SUNNonlinSolFree(newton);
    SUNLinSolFree(solver);
    SUNMatDestroy(matrix);
    N_VDestroy(y);
    N_VDestroy(yp);
    N_VDestroy(id);
    SUNContext_Free(&context);
    mbsr_data_destroy(my.data);
    mbsr_model_destroy(my.model);
}

static void an_ida_of_ones_own_asks_for_them(void **state)
{
    (void)state;
    end_own_run(ERROR_TESTS);
    end_own_run(ITERATIONS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(whatever_fails_the_elements_are_named),
                                       cmocka_unit_test(an_ida_of_ones_own_asks_for_them)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

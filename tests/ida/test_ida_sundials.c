/* The Newton solver handed to IDA by hand: as linear solver, and as preconditioner.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "problems.h"
#include "reference_runs.h"

#include <mbsrank/sundials.h>

#include "ida/compat.h"

#include <ida/ida_ls.h>
#include <nvector/nvector_serial.h>
#include <stdbool.h>
#include <sunlinsol/sunlinsol_spgmr.h>

/* A double pendulum of rods with a massless joint between them, on springs. */
static mbsr_model *make_model(void)
{
    const double end[3] = {0.5, 0.0, 0.0};
    mbsr_model *m = run_model();
    int last = MBSR_GROUND;
    for (int k = 0; k < 3; ++k) {
        const mbsr_planar_frame A = {k > 0 ? 0.5 : 0.0, 0.0, 0.0};
        last = run_body(m, NULL, last, mbsr_joint_planar_revolute(A, run_origin),
                        k == 1 ? mbsr_inertia_zero() : mbsr_inertia_planar(1.0, end, 0.01));
        run_force(m, mbsr_force_joint_spring(last, 0, 5.0, 0.3, 0.0));
    }
    run_force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
    return run_finish(m);
}

enum { SIZE = 9 };

/* User data of IDA; begins with what the preconditioner looks for. */
typedef struct mine {
    mbsr_sundials link;
    const mbsr_model *model;
    mbsr_data *data; /* of the residual; the link may have another one */
} mine;

static int residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, void *user)
{
    mine *my = user;
    return mbsr_dae_residual(my->model, my->data, MBSR_DAE_MOMENTUM, t, N_VGetArrayPointer(y),
                             N_VGetArrayPointer(yp), N_VGetArrayPointer(F));
}

static void ignore(void *user, int code, const char *message)
{
    (void)user;
    (void)code;
    (void)message;
}

typedef struct counts {
    long steps, iterations, factorisations, linear;
    double y[SIZE];
} counts;

static void consistent(const mbsr_model *m, mbsr_data *d, double *y, double *yp)
{
    const double q[3] = {0.5, -0.3, 0.2}, u[3] = {0.0, 1.0, 0.0};
    assert_int_equal(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), SIZE);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
}

/* The solver alone, or with its matrices renewed in time; GMRES with it, and differences of F or
 * products with the matrix. */
typedef enum method { DIRECT, RENEWED, KRYLOV, PRODUCTS } method;

/* To t = 2 with IDA set up by hand; like the driver, but for tolerances of one size. newton: what
 * is left of Newton's method, in tolerances. */
static counts by_hand(const mbsr_model *m, mbsr_data *own, mbsr_data *d, double tolerance,
                      double newton, method by)
{
    const bool krylov = by >= KRYLOV;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mine my = {.model = m, .data = d};
    mbsri_ida_messages messages = {ignore, NULL};
    SUNContext context = NULL;
    SUNMatrix matrix = NULL;
    SUNLinearSolver solver = NULL;
    counts found = {0};
    double reached = 0.0;
    my.link.data = own;
    opt.products = by == PRODUCTS;
    assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &my.link.newton, NULL), NULL);
    assert_true(mbsri_ida_context(&context, &messages));
    N_Vector y = N_VNew_Serial(SIZE, context), yp = N_VNew_Serial(SIZE, context);
    consistent(m, d, N_VGetArrayPointer(y), N_VGetArrayPointer(yp));
    void *ida = IDACreate(context);
    SUNNonlinearSolver iteration = by == RENEWED ? mbsr_sundials_stiff(m, y, context) : NULL;
    assert_int_equal(mbsri_ida_redirect(ida, &messages), IDA_SUCCESS);
    assert_int_equal(IDAInit(ida, residual, 0.0, y, yp), IDA_SUCCESS);
    assert_int_equal(IDASStolerances(ida, tolerance, tolerance), IDA_SUCCESS);
    assert_int_equal(IDASetUserData(ida, &my), IDA_SUCCESS);
    if (krylov) {
        solver = SUNLinSol_SPGMR(y, SUN_PREC_LEFT, 5, context);
        assert_int_equal(IDASetLinearSolver(ida, solver, NULL), IDA_SUCCESS);
        assert_int_equal(IDASetPreconditioner(ida, mbsr_sundials_setup, mbsr_sundials_precondition),
                         IDA_SUCCESS);
        if (by == PRODUCTS)
            assert_int_equal(IDASetJacTimes(ida, mbsr_sundials_linearise, mbsr_sundials_multiply),
                             IDA_SUCCESS);
    } else {
        matrix = mbsr_sundials_matrix(&my.link, context);
        solver = mbsr_sundials_solver(&my.link, context);
        assert_int_equal(SUNMatGetID(matrix), SUNMATRIX_CUSTOM);
        assert_int_equal(SUNLinSolGetID(solver), SUNLINEARSOLVER_CUSTOM);
        assert_int_equal(IDASetLinearSolver(ida, solver, matrix), IDA_SUCCESS);
        assert_int_equal(IDASetJacFn(ida, mbsr_sundials_jacobian), IDA_SUCCESS);
    }
    if (by == RENEWED) {
        assert_int_equal(IDASetNonlinearSolver(ida, iteration), IDA_SUCCESS);
        assert_int_equal(mbsr_sundials_stiff_set_renewal(iteration, 0.05), MBSR_OK);
    }
    assert_int_equal(IDASetInitStep(ida, 1e-4), IDA_SUCCESS);
    assert_int_equal(IDASetNonlinConvCoef(ida, newton), IDA_SUCCESS);
    assert_int_equal(IDASetMaxNumSteps(ida, 100000), IDA_SUCCESS);
    assert_int_equal(IDASolve(ida, 2.0, &reached, y, yp, IDA_NORMAL), IDA_SUCCESS);
    memcpy(found.y, N_VGetArrayPointer(y), sizeof found.y);
    IDAGetNumSteps(ida, &found.steps);
    IDAGetNumNonlinSolvIters(ida, &found.iterations);
    mbsr_newton_info info;
    assert_ok(mbsr_newton_get_info(my.link.newton, &info), NULL);
    found.factorisations = info.factorisations;
    long asked = 0;
    assert_int_equal((krylov ? IDAGetNumPrecEvals : IDAGetNumJacEvals)(ida, &asked), IDA_SUCCESS);
    assert_int_equal(asked, info.factorisations);
    if (by == RENEWED) {
        mbsr_sundials_stiff_info made;
        assert_int_equal(mbsr_sundials_stiff_get_info(iteration, &made), MBSR_OK);
        assert_int_equal(info.solves, found.iterations + made.filter_solves + made.renewals);
        assert_true(made.renewals > 0);
    }
    if (krylov) {
        assert_int_equal(IDAGetNumLinResEvals(ida, &asked), IDA_SUCCESS);
        assert_true(by == PRODUCTS ? asked == 0 : asked > 0);
        assert_int_equal(IDAGetNumLinIters(ida, &found.linear), IDA_SUCCESS);
    }
    assert_int_equal(my.link.status, MBSR_OK);
    IDAFree(&ida);
    if (iteration) assert_int_equal(SUNNonlinSolFree(iteration), 0);
    assert_int_equal(SUNLinSolFree(solver), 0);
    if (matrix) SUNMatDestroy(matrix);
    N_VDestroy(y);
    N_VDestroy(yp);
    SUNContext_Free(&context);
    mbsr_newton_destroy(my.link.newton);
    return found;
}

/* The same by the driver. */
static counts by_driver(const mbsr_model *m, mbsr_data *d, mbsr_ida_solver solver, bool renew)
{
    double each[SIZE], y[SIZE], yp[SIZE];
    counts found = {0};
    mbsr_ida *ida = NULL;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    for (int k = 0; k < SIZE; ++k) each[k] = 1e-6;
    opt.linear_solver = solver;
    opt.atol_each = each;
    opt.rtol = 1e-6;
    opt.suppress_algebraic = 0;
    opt.initial_step = 1e-4;
    opt.krylov_size = 5;
    opt.renew_matrices = renew;
    opt.raw_outputs = 1; /* as IDA by itself */
    consistent(m, d, y, yp);
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 2.0, NULL, found.y, NULL), mbsr_ida_error(ida));
    const mbsr_ida_stats stats = problem_stats(ida);
    found.steps = stats.steps;
    found.iterations = stats.newton_iterations;
    found.factorisations = stats.factorisations;
    mbsr_ida_destroy(ida);
    return found;
}

static void ida_by_hand_does_what_the_driver_does(void **state)
{
    (void)state;
    mbsr_model *m = make_model();
    mbsr_data *d = NULL, *other = NULL;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_data_create(m, &other, NULL), NULL);
    for (int by = DIRECT; by <= KRYLOV; ++by) {
        const counts driver =
            by_driver(m, d, by == KRYLOV ? MBSR_IDA_KRYLOV : MBSR_IDA_TREE, by == RENEWED);
        print_message("%ld steps, %ld iterations, %ld factorisations\n", driver.steps,
                      driver.iterations, driver.factorisations);
        assert_true(by == RENEWED || driver.factorisations < driver.steps);
        for (int apart = 0; apart < 2; ++apart) {
            const counts hand = by_hand(m, apart ? other : d, d, 1e-6, 0.33, (method)by);
            assert_int_equal(hand.steps, driver.steps);
            assert_int_equal(hand.iterations, driver.iterations);
            assert_int_equal(hand.factorisations, driver.factorisations);
            assert_memory_equal(hand.y, driver.y, sizeof hand.y);
        }
    }
    mbsr_data_destroy(other);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Exact products in the place of differences: no more steps, and no residual for a product.
 * Rounding moves the steps of one run by a tenth, so that several are compared. */
static void products_replace_differences(void **state)
{
    (void)state;
    /* with IDA's 0.33 one run of twenty ends wrong by 4e-4, and all take half more steps */
    const double newton = 1e-2;
    mbsr_model *m = make_model();
    mbsr_data *d = NULL;
    counts all[2] = {{0}, {0}};
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int k = -2; k <= 2; ++k) {
        const double tolerance = 1e-6 * (1.0 + 0.01 * k);
        const counts differences = by_hand(m, d, d, tolerance, newton, KRYLOV),
                     products = by_hand(m, d, d, tolerance, newton, PRODUCTS);
        for (int l = 0; l < SIZE; ++l) assert_close(products.y[l], differences.y[l], 1e-4);
        all[0].steps += differences.steps;
        all[0].linear += differences.linear;
        all[1].steps += products.steps;
        all[1].linear += products.linear;
    }
    print_message("%ld and %ld steps, %ld and %ld linear iterations\n", all[0].steps, all[1].steps,
                  all[0].linear, all[1].linear);
    assert_in_range(all[1].steps, 1, 11 * all[0].steps / 10);
    assert_in_range(all[1].linear, 1, 11 * all[0].linear / 10);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- the objects themselves ---- */

typedef struct objects {
    mbsr_model *model;
    mbsr_sundials link;
    SUNContext context;
    SUNMatrix matrix;
    SUNLinearSolver solver;
    N_Vector y, yp, b, x;
} objects;

/* In place: the matrix and the solver point to o->link. */
static void make_objects(objects *o)
{
    static mbsri_ida_messages messages = {ignore, NULL};
    *o = (objects){.model = make_model()};
    assert_ok(mbsr_data_create(o->model, &o->link.data, NULL), NULL);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.products = 1;
    assert_ok(mbsr_newton_create(o->model, MBSR_DAE_MOMENTUM, &opt, &o->link.newton, NULL), NULL);
    assert_true(mbsri_ida_context(&o->context, &messages));
    o->y = N_VNew_Serial(SIZE, o->context);
    o->yp = N_VNew_Serial(SIZE, o->context);
    o->b = N_VNew_Serial(SIZE, o->context);
    o->x = N_VNew_Serial(SIZE, o->context);
    o->matrix = mbsr_sundials_matrix(&o->link, o->context);
    o->solver = mbsr_sundials_solver(&o->link, o->context);
    assert_true(o->matrix && o->solver);
    consistent(o->model, o->link.data, N_VGetArrayPointer(o->y), N_VGetArrayPointer(o->yp));
    for (int k = 0; k < SIZE; ++k) N_VGetArrayPointer(o->b)[k] = sin(1.0 + k);
}

static void free_objects(objects *o)
{
    SUNMatDestroy(o->matrix);
    assert_int_equal(SUNLinSolFree(o->solver), 0);
    N_Vector const vectors[] = {o->y, o->yp, o->b, o->x};
    for (int k = 0; k < 4; ++k) N_VDestroy(vectors[k]);
    SUNContext_Free(&o->context);
    mbsr_newton_destroy(o->link.newton);
    mbsr_data_destroy(o->link.data);
    mbsr_model_destroy(o->model);
}

static void a_solution_is_that_of_the_newton_solver(void **state)
{
    (void)state;
    objects o;
    make_objects(&o);
    double expected[SIZE];
    const double *b = N_VGetArrayPointer(o.b);
    for (int k = 0; k < 2; ++k) {
        const double c = k ? 300.0 : 7.0;
        assert_ok(mbsr_newton_factor(o.link.newton, o.link.data, 0.1, N_VGetArrayPointer(o.y),
                                     N_VGetArrayPointer(o.yp), c),
                  mbsr_newton_error(o.link.newton));
        assert_ok(mbsr_newton_solve(o.link.newton, b, expected), mbsr_newton_error(o.link.newton));
        N_VConst(0.0, o.x);
        assert_int_equal(SUNMatZero(o.matrix), 0);
        assert_int_equal(
            mbsr_sundials_jacobian(0.1, c, o.y, o.yp, NULL, o.matrix, NULL, NULL, NULL, NULL),
            MBSR_OK);
        assert_int_equal(SUNLinSolSetup(o.solver, o.matrix), 0);
        assert_int_equal(SUNLinSolSolve(o.solver, o.matrix, o.x, o.b, 0.0), 0);
        assert_memory_equal(N_VGetArrayPointer(o.x), expected, sizeof expected);
        N_VConst(0.0, o.x);
        assert_int_equal(mbsr_sundials_setup(0.1, o.y, o.yp, NULL, c, &o.link), MBSR_OK);
        assert_int_equal(
            mbsr_sundials_precondition(0.1, o.y, o.yp, NULL, o.b, o.x, c, 0.0, &o.link), MBSR_OK);
        assert_memory_equal(N_VGetArrayPointer(o.x), expected, sizeof expected);
        assert_int_equal(mbsr_sundials_linearise(0.1, o.y, o.yp, NULL, c, &o.link), MBSR_OK);
        N_Vector r = N_VClone(o.b);
        assert_int_equal(
            mbsr_sundials_multiply(0.1, o.y, o.yp, NULL, o.x, r, c, &o.link, NULL, NULL), MBSR_OK);
        for (int l = 0; l < SIZE; ++l) assert_close(N_VGetArrayPointer(r)[l], b[l], 1e-11);
        N_VDestroy(r);
    }
    free_objects(&o);
}

/* Signs as IDA reads them, in codes that it knows. */
static void failures_keep_their_sign(void **state)
{
    (void)state;
    objects o;
    make_objects(&o);
    /* nothing factored yet: wrong use */
    assert_true(SUNLinSolSolve(o.solver, o.matrix, o.x, o.b, 0.0) < 0);
    assert_int_equal(SUNLinSolSolve(o.solver, o.matrix, o.x, o.b, 0.0), MBSRI_IDA_PACKAGE_FAILED);
    assert_int_equal(o.link.status, MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_sundials_precondition(0.0, o.y, o.yp, NULL, o.b, o.x, 1.0, 0.0, &o.link),
                     MBSR_ERR_SEQUENCE);
    assert_int_equal(
        mbsr_sundials_multiply(0.0, o.y, o.yp, NULL, o.b, o.x, 1.0, &o.link, NULL, NULL),
        MBSR_ERR_SEQUENCE);
    assert_int_equal(o.link.status, MBSR_ERR_SEQUENCE);
    /* not finite: recoverable */
    assert_int_equal(mbsr_sundials_setup(0.0, o.y, o.yp, NULL, 1.0, &o.link), MBSR_OK);
    N_VGetArrayPointer(o.b)[2] = NAN;
    assert_int_equal(SUNLinSolSolve(o.solver, o.matrix, o.x, o.b, 0.0), SUNLS_PACKAGE_FAIL_REC);
    assert_int_equal(o.link.status, MBSR_NOT_FINITE);
    assert_true(MBSR_NOT_FINITE > 0);
    N_VGetArrayPointer(o.y)[0] = NAN;
    assert_int_equal(mbsr_sundials_setup(0.0, o.y, o.yp, NULL, 1.0, &o.link), MBSR_NOT_FINITE);
    assert_int_equal(mbsr_sundials_linearise(0.0, o.y, o.yp, NULL, 1.0, &o.link), MBSR_NOT_FINITE);
    assert_int_equal(
        mbsr_sundials_jacobian(0.0, 1.0, o.y, o.yp, NULL, o.matrix, NULL, NULL, NULL, NULL),
        MBSR_NOT_FINITE);
    free_objects(&o);
}

static void missing_arguments_give_no_object(void **state)
{
    (void)state;
    objects o;
    make_objects(&o);
    const mbsr_sundials whole = o.link;
    assert_null(mbsr_sundials_matrix(NULL, o.context));
    assert_null(mbsr_sundials_solver(NULL, o.context));
    assert_null(mbsr_sundials_matrix(&o.link, NULL));
    assert_null(mbsr_sundials_solver(&o.link, NULL));
    o.link.newton = NULL;
    assert_null(mbsr_sundials_matrix(&o.link, o.context));
    assert_null(mbsr_sundials_solver(&o.link, o.context));
    o.link = whole;
    o.link.data = NULL;
    assert_null(mbsr_sundials_matrix(&o.link, o.context));
    assert_null(mbsr_sundials_solver(&o.link, o.context));
    o.link = whole;
    free_objects(&o);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ida_by_hand_does_what_the_driver_does),
        cmocka_unit_test(products_replace_differences),
        cmocka_unit_test(a_solution_is_that_of_the_newton_solver),
        cmocka_unit_test(failures_keep_their_sign),
        cmocka_unit_test(missing_arguments_give_no_object),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

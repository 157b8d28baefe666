/* Stiff springs that close a loop: the driver is not stuck, and ends right.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A slider-crank, crank 0.2 m and 2 kg, rod 0.6 m and 1 kg, slider 1.5 kg on the x axis, whose rod
 * is tied to the slider by springs k and dampers d. It falls from phi = 1 at rest. With rigid pins
 * phi is -1.590430257 after 3 s, by a Runge-Kutta method for the one equation of that motion. */
#include "duration.h"
#include "problems.h"
#include "reference_runs.h"

#include <mbsrank/simulation.h>
#include <mbsrank/sundials.h>

#include "ida/compat.h"

#include <nvector/nvector_serial.h>
#include <stdbool.h>

static const double crank_length = 0.2, rod_length = 0.6, phi_start = 1.0, phi_end = -1.590430257;
enum { SIZE = 9 };

typedef struct crank {
    mbsr_model *model;
    mbsr_data *data, *other; /* of the run; to look at energies */
    double y[SIZE], yp[SIZE], energy;
} crank;

static double energy(const crank *s, double t, const double *y)
{
    double q[3], u[3], kinetic, potential;
    assert_ok(mbsr_dae_unpack(s->model, s->other, MBSR_DAE_MOMENTUM, t, y, q, u),
              mbsr_data_error(s->other));
    assert_ok(mbsr_stage_positions(s->model, s->other, t, q), mbsr_data_error(s->other));
    assert_ok(mbsr_stage_velocities(s->model, s->other, u), mbsr_data_error(s->other));
    assert_ok(mbsr_energy(s->model, s->other, &kinetic, &potential), mbsr_data_error(s->other));
    return kinetic + potential;
}

static void make(crank *s, double k, double d)
{
    const double a = crank_length, l = rod_length, b = asin(a * sin(phi_start) / l);
    const mbsr_planar_frame O = {0}, end = {a, 0, 0};
    const double q[3] = {phi_start, -phi_start - b, a * cos(phi_start) + l * cos(b)}, u[3] = {0};
    mbsr_model *m = run_model();
    const int wheel = run_body(m, "crank", MBSR_GROUND, mbsr_joint_planar_revolute(O, O),
                               mbsr_inertia_planar(2.0, (double[2]){a / 2, 0}, 2.0 * a * a / 12));
    const int rod = run_body(m, "rod", wheel, mbsr_joint_planar_revolute(end, O),
                             mbsr_inertia_planar(1.0, (double[2]){l / 2, 0}, l * l / 12));
    const int slider = run_body(m, "slider", MBSR_GROUND, mbsr_joint_planar_prismatic(O, O),
                                mbsr_inertia_particle(1.5));
    const mbsr_planar_frame at_tip = {l, 0, 0};
    const int tip =
        run_body(m, "tip", rod, mbsr_joint_point(at_tip, 0, 0, NULL, NULL), mbsr_inertia_zero());
    const int pin =
        run_body(m, "pin", slider, mbsr_joint_point(O, 0, 0, NULL, NULL), mbsr_inertia_zero());
    run_force(m, mbsr_force_gravity(0, -9.81, 0));
    for (int i = 0; i < 2; ++i) run_force(m, mbsr_force_axis_spring(tip, pin, i, k, d, 0));
    s->model = run_finish(m);
    assert_ok(mbsr_data_create(m, &s->data, NULL), NULL);
    assert_ok(mbsr_data_create(m, &s->other, NULL), NULL);
    assert_int_equal(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), SIZE);
    assert_ok(mbsr_dae_pack(m, s->data, MBSR_DAE_MOMENTUM, 0, q, u, s->y),
              mbsr_data_error(s->data));
    assert_ok(mbsr_dae_consistent(m, s->data, MBSR_DAE_MOMENTUM, 0, s->y, s->yp, NULL, NULL),
              mbsr_data_error(s->data));
    s->energy = energy(s, 0.0, s->y);
}

static void drop(crank *s)
{
    mbsr_data_destroy(s->data);
    mbsr_data_destroy(s->other);
    mbsr_model_destroy(s->model);
}

/* Damping ratio z with the mass of about 0.3 kg that the rod's tip shows. */
static double damping(double k, double z)
{
    return 2.0 * z * sqrt(0.3 * k);
}

/* Most energy at the ends of steps beyond that of the start. */
typedef struct watch {
    mbsr_ida *ida;
    const crank *crank;
    double most;
} watch;

static int look(void *user, const mbsr_ida_progress *now)
{
    watch *w = user;
    double y[SIZE];
    assert_ok(mbsr_ida_dense(w->ida, now->t, 0, y), mbsr_ida_error(w->ida));
    w->most = fmax(w->most, energy(w->crank, now->t, y) - w->crank->energy);
    return 0;
}

static mbsr_ida_stats fall(crank *s, double tolerance, mbsr_ida_solver solver, double *phi,
                           double *gained)
{
    double y[SIZE];
    watch w = {.crank = s};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    opt.linear_solver = solver;
    opt.max_steps = 10000;
    opt.progress = look;
    opt.progress_user = &w;
    assert_ok(mbsr_ida_create(s->model, s->data, &opt, &w.ida, NULL), NULL);
    assert_ok(mbsr_ida_start(w.ida, 0.0, s->y, s->yp), mbsr_ida_error(w.ida));
    assert_ok(mbsr_ida_advance(w.ida, 3.0, NULL, y, NULL), mbsr_ida_error(w.ida));
    const mbsr_ida_stats stats = problem_stats(w.ida);
    mbsr_ida_destroy(w.ida);
    *phi = y[0];
    *gained = w.most;
    return stats;
}

/* Without what is tested here, one run of most cells takes 10^4 to 10^5 steps. The rigid motion
 * alone loses 1.3 rad at 1e-3, and up to 700 tolerances at 1e-4 and 2600 at 1e-6. */
static void no_cell_is_stuck_or_wrong(void **state)
{
    (void)state;
    enum { STIFFNESSES = 4, RATIOS = 3, CELLS = STIFFNESSES * RATIOS };
    static const double tolerance[] = {1e-3, 1e-4, 1e-6}, ratio[RATIOS] = {0.3, 1.0, 10.0},
                        stiffness[STIFFNESSES] = {1e8, 1e10, 1e12, 1e14};
    static const long most[] = {5000, 4500, 8000};
    static const double wrong[] = {1.5, 0.6, 6e-3}, energy[] = {0.3, 0.1, 1e-3};
    for (int dense = 0; dense < 2; ++dense) {
        for (int t = 0; t < 3; ++t) {
            long steps = 0;
            double worst = 0.0, gained = 0.0;
            for (int c = 0; c < CELLS; ++c) {
                crank s;
                double phi, gain;
                const double k = stiffness[c / RATIOS];
                make(&s, k, damping(k, ratio[c % RATIOS]));
                const mbsr_ida_stats stats =
                    fall(&s, tolerance[t], dense ? MBSR_IDA_DENSE : MBSR_IDA_TREE, &phi, &gain);
                steps += stats.steps;
                worst = fmax(worst, fabs(phi - phi_end));
                gained = fmax(gained, gain);
                assert_true(stats.careful_attempts > 0);
                drop(&s);
            }
            print_message("%s, tolerance %g: %ld steps, error %.1e, energy gained %.1e\n",
                          dense ? "dense" : "tree", tolerance[t], steps, worst, gained);
            assert_true(steps < most[t]);
            assert_true(worst < wrong[t] && gained < energy[t]);
        }
    }
}

/* Ten rods, whose springs vibrate and have to be resolved: careful steps would not pay. IDA's own
 * takes 523 steps and 24 matrices. */
static void springs_that_vibrate_are_left_to_ida(void **state)
{
    (void)state;
    enum { RODS = 10 };
    const double z[3] = {0.0, 0.0, 1.0}, start[3] = {0.0}, end[3] = {0.1, 0.0, 0.0},
                 q[RODS] = {0.5};
    const mbsr_frame next = mbsr_frame_at(0.1, 0.0, 0.0);
    for (int dense = 0; dense < 2; ++dense) {
        mbsr_ida_opt opt = mbsr_default_ida_opt();
        mbsr_simulation s = mbsr_simulation_begin(NULL);
        for (int i = 0; i < RODS; ++i) {
            const int rod = mbsr_simulation_add_body(&s, NULL, i - 1,
                                                     mbsr_joint_revolute(i ? &next : NULL, NULL, z),
                                                     mbsr_inertia_rod(0.1, start, end));
            if (i > 0)
                mbsr_simulation_add_force(&s, mbsr_force_joint_spring(rod, 0, 100.0, 0.01, 0.0));
        }
        mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
        opt.rtol = opt.atol = 1e-4;
        opt.linear_solver = dense ? MBSR_IDA_DENSE : MBSR_IDA_TREE;
        mbsr_simulation_start(&s, &opt, 0.0, q, NULL);
        mbsr_simulation_to(&s, 1.0);
        assert_ok(s.status, &s.error);
        mbsr_ida_stats stats;
        mbsr_simulation_get_stats(&s, &stats);
        print_message("%s: %ld steps, %ld of them carefully, %ld matrices\n",
                      dense ? "dense" : "tree", stats.steps, stats.careful_attempts,
                      stats.factorisations);
        assert_true(stats.stiff_tests < 50);
        if (dense) assert_true(5 * stats.careful_attempts < stats.steps);
        if (dense) assert_true(9 * stats.factorisations < stats.steps);
        mbsr_simulation_end(&s);
    }
}

/* A chain that nothing makes stiff; where orders above 2 are not allowed, a low one is no sign. */
static void a_low_order_by_choice_is_no_alarm(void **state)
{
    (void)state;
    enum { RODS = 20 };
    const double y_axis[3] = {0.0, 1.0, 0.0}, top[3] = {0.0}, end[3] = {0.0, 0.0, -0.1},
                 q[RODS] = {0.5};
    const mbsr_frame next = mbsr_frame_at(0.0, 0.0, -0.1);
    for (int order = 1; order <= 3; ++order) {
        mbsr_ida_opt opt = mbsr_default_ida_opt();
        mbsr_simulation s = mbsr_simulation_begin(NULL);
        for (int i = 0; i < RODS; ++i)
            mbsr_simulation_add_body(&s, NULL, i - 1,
                                     mbsr_joint_revolute(i ? &next : NULL, NULL, y_axis),
                                     mbsr_inertia_rod(0.1, top, end));
        mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
        opt.max_order = order;
        opt.renew_matrices = 0; /* which makes most of them */
        mbsr_simulation_start(&s, &opt, 0.0, q, NULL);
        mbsr_simulation_to(&s, 0.2);
        assert_ok(s.status, &s.error);
        mbsr_ida_stats stats;
        mbsr_simulation_get_stats(&s, &stats);
        assert_int_equal(stats.careful_attempts, 0);
        assert_less((double)stats.factorisations, 0.1 * (double)stats.steps);
        mbsr_simulation_end(&s);
    }
}

/* ---- which element it is ---- */

static void the_stiff_elements_are_named(void **state)
{
    (void)state;
    crank s;
    double y[SIZE], share[3];
    int force[3], count = -1;
    make(&s, 1e10, 1e6); /* elements: 0 the weight, 1 and 2 the springs in x and y */
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.max_steps = 60;
    mbsr_ida *ida = NULL;
    assert_ok(mbsr_ida_create(s.model, s.data, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, s.y, s.yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_stiffest(ida, 3, force, share, &count), mbsr_ida_error(ida));
    assert_int_equal(count, 0); /* nothing has failed yet */
    assert_int_equal(mbsr_ida_advance(ida, 3.0, NULL, y, NULL), MBSR_ERR_SOLVER);
    assert_non_null(strstr(mbsr_ida_error(ida)->text, "the stiffness of force element"));
    assert_in_range(mbsr_ida_error(ida)->force, 1, 2);
    assert_ok(mbsr_ida_stiffest(ida, 3, force, share, &count), mbsr_ida_error(ida));
    assert_in_range(count, 2, 3);
    assert_int_equal(force[0] + force[1], 3);
    assert_true(share[0] >= share[1] && share[1] >= 0.0);
    assert_close(share[0] + share[1], 1.0, 1e-6);
    assert_int_equal(force[0], mbsr_ida_error(ida)->force);
    assert_ok(mbsr_ida_stiffest(ida, 0, NULL, NULL, &count), mbsr_ida_error(ida));
    assert_int_equal(count, 0);
    assert_int_equal(mbsr_ida_stiffest(NULL, 0, NULL, NULL, &count), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_stiffest(ida, 1, NULL, share, &count), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_stiffest(ida, 1, force, NULL, &count), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_stiffest(ida, 1, force, share, NULL), MBSR_ERR_NULL);
    mbsr_ida_destroy(ida);
    drop(&s);
}

/* IDA may not try again with a shorter step. True if Newton's method failed in a careful step. */
static bool newton_fails(double k, double ratio)
{
    crank s;
    double y[SIZE], share[3];
    int force[3], count = -1;
    make(&s, k, damping(k, ratio));
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-3;
    mbsr_ida *ida = NULL;
    assert_ok(mbsr_ida_create(s.model, s.data, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, s.y, s.yp), mbsr_ida_error(ida));
    assert_int_equal(IDASetMaxConvFails(mbsr_ida_memory(ida), 1), IDA_SUCCESS);
    const int status = mbsr_ida_advance(ida, 3.0, NULL, y, NULL);
    const mbsr_error *error = mbsr_ida_error(ida);
    const mbsr_ida_stats stats = problem_stats(ida);
    const bool failed = status && stats.careful_failures > 0;
    assert_true(stats.careful_failures <= stats.careful_attempts);
    if (failed) {
        print_message("%ld careful failures: %s\n", stats.careful_failures, error->text);
        assert_int_equal(status, MBSR_ERR_SOLVER);
        assert_true(stats.newton_failures > 0);
        assert_non_null(
            strstr(error->text, "Newton's method fails by the stiffness of force element"));
        assert_non_null(strstr(error->text, "as_closure"));
        assert_in_range(error->force, 1, 2);
        assert_ok(mbsr_ida_stiffest(ida, 3, force, share, &count), mbsr_ida_error(ida));
        assert_in_range(count, 1, 3);
        assert_in_range(force[0], 1, 2);
    }
    mbsr_ida_destroy(ida);
    drop(&s);
    return failed;
}

/* Where rounding times stiffness keeps it from converging, which it does in some of these. */
static void where_newtons_method_fails_the_elements_are_named(void **state)
{
    (void)state;
    static const double ratio[] = {0.3, 1.0, 10.0};
    int failed = 0;
    for (double k = 1e14; k < 2e18; k *= 10.0)
        for (int i = 0; i < 3; ++i) failed += newton_fails(k, ratio[i]);
    assert_true(failed > 0);
}

/* ---- an IDA of one's own ---- */

typedef struct mine {
    mbsr_sundials link;
    const mbsr_model *model;
} mine;

static int residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, void *user)
{
    mine *my = user;
    return mbsr_dae_residual(my->model, my->link.data, MBSR_DAE_MOMENTUM, t, N_VGetArrayPointer(y),
                             N_VGetArrayPointer(yp), N_VGetArrayPointer(F));
}

static void ignore(void *user, int code, const char *message)
{
    (void)user;
    (void)code;
    (void)message;
}

/* Steps to 3 s; 0 if 5000 are not enough. */
static long by_hand(crank *s, bool stiff, double tolerance, double *phi)
{
    mine my = {.model = s->model, .link.data = s->data};
    mbsri_ida_messages messages = {ignore, NULL};
    SUNContext context = NULL;
    assert_ok(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, NULL, &my.link.newton, NULL), NULL);
    assert_true(mbsri_ida_context(&context, &messages));
    N_Vector y = N_VNew_Serial(SIZE, context), yp = N_VNew_Serial(SIZE, context),
             id = N_VNew_Serial(SIZE, context);
    memcpy(N_VGetArrayPointer(y), s->y, sizeof s->y);
    memcpy(N_VGetArrayPointer(yp), s->yp, sizeof s->yp);
    assert_ok(mbsr_dae_id(s->model, s->data, MBSR_DAE_MOMENTUM, N_VGetArrayPointer(id)), NULL);
    void *ida = IDACreate(context);
    SUNNonlinearSolver newton = stiff ? mbsr_sundials_stiff(s->model, y, context) : NULL;
    assert_int_equal(mbsri_ida_redirect(ida, &messages), IDA_SUCCESS);
    assert_int_equal(IDAInit(ida, residual, 0.0, y, yp), IDA_SUCCESS);
    assert_int_equal(IDASStolerances(ida, tolerance, tolerance), IDA_SUCCESS);
    assert_int_equal(IDASetUserData(ida, &my), IDA_SUCCESS);
    SUNMatrix matrix = mbsr_sundials_matrix(&my.link, context);
    SUNLinearSolver solver = mbsr_sundials_solver(&my.link, context);
    assert_int_equal(IDASetLinearSolver(ida, solver, matrix), IDA_SUCCESS);
    assert_int_equal(IDASetJacFn(ida, mbsr_sundials_jacobian), IDA_SUCCESS);
    assert_int_equal(IDASetId(ida, id), IDA_SUCCESS);
    assert_int_equal(IDASetSuppressAlg(ida, SUNTRUE), IDA_SUCCESS);
    if (stiff) assert_int_equal(IDASetNonlinearSolver(ida, newton), IDA_SUCCESS);
    if (stiff) {
        assert_int_equal(mbsr_sundials_stiff_set_rtol(newton, tolerance), MBSR_OK);
        assert_int_equal(mbsr_sundials_stiff_set_renewal(newton, 0.2), MBSR_OK);
    }
    assert_int_equal(IDASetInitStep(ida, 1e-5), IDA_SUCCESS);
    assert_int_equal(IDASetMaxNumSteps(ida, 5000), IDA_SUCCESS);
    double reached = 0.0;
    long steps = 0;
    const int flag = IDASolve(ida, 3.0, &reached, y, yp, IDA_NORMAL);
    IDAGetNumSteps(ida, &steps);
    if (stiff) {
        mbsr_sundials_stiff_info info;
        assert_int_equal(mbsr_sundials_stiff_get_info(newton, &info), MBSR_OK);
        assert_true(info.stiff_tests > 0 && info.careful_attempts > 0 && info.filter_solves > 0);
    }
    *phi = N_VGetArrayPointer(y)[0];
    IDAFree(&ida);
    if (stiff) SUNNonlinSolFree(newton);
    assert_int_equal(SUNLinSolFree(solver), 0);
    SUNMatDestroy(matrix);
    N_VDestroy(y);
    N_VDestroy(yp);
    N_VDestroy(id);
    SUNContext_Free(&context);
    mbsr_newton_destroy(my.link.newton);
    return flag == IDA_SUCCESS ? steps : 0;
}

/* The same with tolerances of one size. */
static long by_driver(crank *s, double tolerance, double *phi)
{
    double y[SIZE], each[SIZE];
    mbsr_ida *ida = NULL;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    for (int k = 0; k < SIZE; ++k) each[k] = tolerance;
    opt.rtol = tolerance;
    opt.atol_each = each;
    opt.initial_step = 1e-5;
    assert_ok(mbsr_ida_create(s->model, s->data, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, s->y, s->yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 3.0, NULL, y, NULL), mbsr_ida_error(ida));
    const long steps = problem_stats(ida).steps;
    mbsr_ida_destroy(ida);
    *phi = y[0];
    return steps;
}

/* The rigid motion loses 1.3 rad at 1e-3. */
static void an_ida_of_ones_own_gets_the_same(void **state)
{
    (void)state;
    static const double tolerance[] = {1e-3, 1e-5}, wrong[] = {1.5, 0.06};
    for (int k = 8; k <= 12; k += 2) {
        crank s;
        double unused;
        make(&s, pow(10.0, k), damping(pow(10.0, k), 1.0));
        for (int t = 0; t < 2; ++t) {
            double hand, driver;
            const long own = by_hand(&s, true, tolerance[t], &hand),
                       ours = by_driver(&s, tolerance[t], &driver);
            print_message("1e%d N/m, tolerance %g: %ld steps by hand, %ld by the driver\n", k,
                          tolerance[t], own, ours);
            assert_in_range(own, 9 * ours / 10, 11 * ours / 10);
            assert_close(hand, phi_end, wrong[t]);
            assert_close(driver, phi_end, wrong[t]);
        }
        assert_int_equal(by_hand(&s, false, 1e-5, &unused), 0);
        drop(&s);
    }
}

/* ---- GMRES whose preconditioner knows nothing of the springs ---- */

/* With the accuracy that IDA asks of it this ended 20 rad off, or after 10^4 steps. By difference
 * quotients the steps are 790 to 890 at 1e10 N/m, if tolerances differ in their ninth digit. */
static void gmres_solves_what_its_preconditioner_leaves_out(void **state)
{
    (void)state;
    for (int k = 8; k <= 12; k += 2) {
        long residuals[2];
        crank s;
        make(&s, pow(10.0, k), damping(pow(10.0, k), 1.0));
        for (int products = 0; products < 2; ++products) {
            double y[SIZE];
            mbsr_ida *ida = NULL;
            mbsr_ida_opt opt = mbsr_default_ida_opt();
            opt.linear_solver = MBSR_IDA_KRYLOV;
            opt.newton.method = MBSR_NEWTON_TREE;
            opt.newton.products = products;
            assert_ok(mbsr_ida_create(s.model, s.data, &opt, &ida, NULL), NULL);
            assert_ok(mbsr_ida_start(ida, 0.0, s.y, s.yp), mbsr_ida_error(ida));
            assert_ok(mbsr_ida_advance(ida, 3.0, NULL, y, NULL), mbsr_ida_error(ida));
            const mbsr_ida_stats stats = problem_stats(ida);
            print_message("1e%d N/m: %ld steps, %ld residuals, %ld of GMRES, phi %.5f\n", k,
                          stats.steps, stats.residuals, stats.krylov_iterations, y[0]);
            assert_in_range(stats.steps, 300, test_seeds(1000, 800));
            assert_close(y[0], phi_end, 6e-3);
            residuals[products] = stats.residuals;
            mbsr_ida_destroy(ida);
        }
        assert_true(3 * residuals[1] < residuals[0]);
        drop(&s);
    }
}

static void what_does_not_fit_is_refused(void **state)
{
    (void)state;
    crank s;
    SUNContext context = NULL;
    mbsri_ida_messages messages = {ignore, NULL};
    make(&s, 1e8, 1e4);
    assert_true(mbsri_ida_context(&context, &messages));
    N_Vector y = N_VNew_Serial(SIZE, context), other = N_VNew_Serial(SIZE - 1, context);
    assert_null(mbsr_sundials_stiff(NULL, y, context));
    assert_null(mbsr_sundials_stiff(s.model, NULL, context));
    assert_null(mbsr_sundials_stiff(s.model, y, NULL));
    assert_null(mbsr_sundials_stiff(s.model, other, context));
    SUNNonlinearSolver newton = mbsr_sundials_stiff(s.model, y, context);
    mbsr_sundials_stiff_info info;
    assert_non_null(newton);
    assert_int_equal(mbsr_sundials_stiff_set_rtol(NULL, 1e-3), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sundials_stiff_set_rtol(newton, NAN), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_set_rtol(newton, -1e-3), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_set_renewal(NULL, 0.2), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sundials_stiff_set_renewal(newton, NAN), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_set_renewal(newton, 1.0), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_sundials_stiff_set_renewal(newton, 0.0), MBSR_OK);
    assert_int_equal(mbsr_sundials_stiff_get_info(NULL, &info), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sundials_stiff_get_info(newton, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sundials_stiff_get_info(newton, &info), MBSR_OK);
    assert_int_equal(info.careful_attempts, 0);
    N_Vector twin = N_VClone(y), empty = N_VCloneEmpty(y); /* these know the filter, too */
    N_VConst(2.0, twin);
    N_VConst(1.0, y);
    assert_close(N_VWrmsNormMask(twin, y, y), 2.0, 1e-14);
    N_VDestroy(empty);
    N_VDestroy(twin);
    N_VDestroy(y);
    N_VDestroy(other);
    SUNNonlinSolFree(newton);
    SUNContext_Free(&context);
    drop(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_cell_is_stuck_or_wrong),
        cmocka_unit_test(springs_that_vibrate_are_left_to_ida),
        cmocka_unit_test(a_low_order_by_choice_is_no_alarm),
        cmocka_unit_test(the_stiff_elements_are_named),
        cmocka_unit_test(where_newtons_method_fails_the_elements_are_named),
        cmocka_unit_test(an_ida_of_ones_own_gets_the_same),
        cmocka_unit_test(gmres_solves_what_its_preconditioner_leaves_out),
        cmocka_unit_test(what_does_not_fit_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Work and precision of the DAE forms: two small problems with a mass that gets smaller and then
 * zero, integrated with the IDA driver at several tolerances.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_precision [smallest tolerance [motion.csv]]      CSV on standard output
 *
 * bead: a pendulum of 1 kg, 1 m below its pivot, which is a bead held by springs c = 100 N/m and
 * dampers d in x and y. Started at the angle 2 rad with 6 rad/s, it turns over. What is without
 * inertia when the bead has no mass is its motion across the rod: a direction that turns with the
 * pendulum. d = 5 N s/m: index 1; d = 0: index 2. With a file name the motion for bead mass zero
 * and d = 5 is written there.
 *
 * oscillators: those of examples/demo_oscillators.c, a linear problem. With m1 > 0 they start at
 * rest at p1 = 0, with m1 = 0 on its smooth solution.
 *
 * The error is the largest of q at the end, against Radau IIA of order 5 on the inverse-dynamics
 * form, which decides no ranks. Two step sizes say how good that is. */
#include "bench.h"
#include "radau.h"

#include <mbsrank/ida.h>

#include <math.h>
#include <stdlib.h>

enum { Q_MOST = 3, Y_MOST = 3 * Q_MOST, FRAMES = 2000 };

static const long most_steps = 2000000;

/* ---- what is compared ------------------------------------------------------------------------ */

static const struct form {
    const char *name;
    mbsr_dae_form form;
    int suppress_algebraic;
    int zero_mass_only; /* with small masses some runs take millions of steps */
} forms[] = {
    {"momentum", MBSR_DAE_MOMENTUM, 1, 0},
    {"index1", MBSR_DAE_INDEX1, 1, 0},
    {"recursive", MBSR_DAE_RECURSIVE, 1, 0},
    {"inverse_dynamics", MBSR_DAE_INVERSE_DYNAMICS, 1, 0},
    {"momentum_all_tested", MBSR_DAE_MOMENTUM, 0, 1},
};

static const double tolerances[] = {1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};

typedef void (*build_fn)(mbsr_model *model, double mass, double damping);
static void build_bead(mbsr_model *model, double mass, double damping);
static void build_oscillators(mbsr_model *model, double mass, double damping);

static const struct problem {
    const char *name;
    build_fn build;
    double mass, damping, T;
    int n;
    double q[Q_MOST], u[Q_MOST];
    long reference_steps;
} problems[] = {
    {"bead", build_bead, 0.0, 5.0, 10.0, 3, {0, 0, 2}, {0, 0, 6}, 10000},
    {"bead", build_bead, 1e-8, 5.0, 10.0, 3, {0, 0, 2}, {0, 0, 6}, 10000},
    {"bead", build_bead, 1e-7, 5.0, 10.0, 3, {0, 0, 2}, {0, 0, 6}, 10000},
    {"bead", build_bead, 1e-6, 5.0, 10.0, 3, {0, 0, 2}, {0, 0, 6}, 10000},
    {"bead", build_bead, 1e-5, 5.0, 10.0, 3, {0, 0, 2}, {0, 0, 6}, 10000},
    {"bead", build_bead, 1e-4, 5.0, 10.0, 3, {0, 0, 2}, {0, 0, 6}, 10000},
    {"bead", build_bead, 1e-3, 5.0, 10.0, 3, {0, 0, 2}, {0, 0, 6}, 10000},
    {"bead", build_bead, 0.0, 0.0, 10.0, 3, {0, 0, 2}, {0, 0, 6}, 20000},
    {"oscillators", build_oscillators, 0.0, 1e-5, 2.0, 2, {0.5, -0.5}, {0, 0}, 2000},
    {"oscillators", build_oscillators, 1e-6, 1e-5, 2.0, 2, {0, 0}, {0, 0}, 100000},
    {"oscillators", build_oscillators, 1e-5, 1e-5, 2.0, 2, {0, 0}, {0, 0}, 100000},
    {"oscillators", build_oscillators, 1e-4, 1e-5, 2.0, 2, {0, 0}, {0, 0}, 50000},
    {"oscillators", build_oscillators, 1e-3, 1e-5, 2.0, 2, {0, 0}, {0, 0}, 10000},
};

enum {
    FORMS = sizeof forms / sizeof forms[0],
    TOLERANCES = sizeof tolerances / sizeof tolerances[0],
    PROBLEMS = sizeof problems / sizeof problems[0]
};

/* ---- models ---------------------------------------------------------------------------------- */

static int add_body(mbsr_model *model, int parent, mbsr_joint joint, double mass)
{
    int id = MBSR_NONE;
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = parent;
    body.joint = joint;
    body.inertia = mbsr_inertia_particle(mass);
    bench_check(mbsr_model_add_body(model, &body, &id), "body", mbsr_model_error(model)->text);
    return id;
}

static void add_force(mbsr_model *model, mbsr_force_def force)
{
    bench_check(mbsr_model_add_force(model, &force, NULL), "force", mbsr_model_error(model)->text);
}

static void build_bead(mbsr_model *model, double mass, double damping)
{
    const mbsr_planar_frame pivot = {0.0, 0.0, 0.0}, above = {0.0, 1.0, 0.0};
    const int bead = add_body(model, MBSR_GROUND, mbsr_joint_point_free(), mass);
    add_body(model, bead, mbsr_joint_planar_revolute(pivot, above), 1.0);
    for (int axis = 0; axis < 2; ++axis)
        add_force(model, mbsr_force_axis_spring(bead, MBSR_GROUND, axis, 100.0, damping, 0.0));
    add_force(model, mbsr_force_gravity(0.0, -9.81, 0.0));
}

static int unit_force(void *user, double t, int n, double *value)
{
    (void)user, (void)t, (void)n;
    value[0] = 1.0;
    return MBSR_OK;
}

static void build_oscillators(mbsr_model *model, double mass, double damping)
{
    const mbsr_joint joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
    const int first = add_body(model, MBSR_GROUND, joint, mass);
    const int second = add_body(model, first, joint, 1.0);
    add_force(model, mbsr_force_axis_spring(first, MBSR_GROUND, 0, 1.0, damping, 0.0));
    add_force(model, mbsr_force_axis_spring(second, first, 0, 1.0, damping, 0.0));
    add_force(model, mbsr_force_applied(first, unit_force, NULL));
}

/* A model with its data. */
typedef struct setup {
    mbsr_model *model;
    mbsr_data *data;
} setup;

static setup make(const struct problem *problem)
{
    setup s;
    bench_check(mbsr_model_create(NULL, &s.model, NULL), "model", NULL);
    problem->build(s.model, problem->mass, problem->damping);
    bench_check(mbsr_model_finish(s.model), "finish", mbsr_model_error(s.model)->text);
    bench_check(mbsr_data_create(s.model, &s.data, NULL), "data", NULL);
    return s;
}

static void start(const struct problem *problem, const setup *s, mbsr_dae_form form, double *y,
                  double *yp)
{
    int status = mbsr_dae_pack(s->model, s->data, form, 0.0, problem->q, problem->u, y);
    if (!status) status = mbsr_dae_consistent(s->model, s->data, form, 0.0, y, yp, NULL, NULL);
    bench_check(status, "start", mbsr_data_error(s->data)->text);
}

static void destroy(setup *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

static double distance(int n, const double *a, const double *b)
{
    double largest = 0.0;
    for (int k = 0; k < n; ++k) largest = fmax(largest, fabs(a[k] - b[k]));
    return largest;
}

/* ---- reference ------------------------------------------------------------------------------- */

static void integrate_reference(const struct problem *problem, long steps, double *q)
{
    double y[Y_MOST], yp[Y_MOST];
    setup s = make(problem);
    start(problem, &s, MBSR_DAE_INVERSE_DYNAMICS, y, yp);
    radau_integrate(s.model, s.data, MBSR_DAE_INVERSE_DYNAMICS, problem->T, steps, y, yp);
    for (int k = 0; k < problem->n; ++k) q[k] = y[k];
    destroy(&s);
}

/* The published end of the pendulum on the bead without mass: x, y, angle, to 10 decimals. */
static void check_published(const double *q)
{
    const double published[3] = {0.0577674475, -0.0628665209, 7.0972129298};
    const double off = distance(3, q, published);
    printf("# published for bead, mass 0, damping 5: off by %.1e\n", off);
    if (!(off < 2e-10)) bench_check(MBSR_NO_CONVERGENCE, "reference and published values", NULL);
}

static void find_reference(const struct problem *problem, double *q)
{
    double coarse[Q_MOST];
    integrate_reference(problem, problem->reference_steps / 2, coarse);
    integrate_reference(problem, problem->reference_steps, q);
    printf("# reference %s, mass %g, damping %g, t = %g: q =", problem->name, problem->mass,
           problem->damping, problem->T);
    for (int k = 0; k < problem->n; ++k) printf(" %.12f", q[k]);
    printf("; %ld and %ld steps differ by %.1e\n", problem->reference_steps,
           problem->reference_steps / 2, distance(problem->n, q, coarse));
    if (problem == problems) check_published(q);
}

/* ---- runs ------------------------------------------------------------------------------------ */

typedef struct run {
    int status;
    mbsr_ida_stats stats;
    double seconds, error;
} run;

static run integrate(const struct problem *problem, const struct form *form, double tolerance,
                     const double *reference)
{
    run result = {.error = NAN};
    double y[Y_MOST], yp[Y_MOST];
    mbsr_ida *ida;
    mbsr_error error;
    setup s = make(problem);
    start(problem, &s, form->form, y, yp);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = form->form;
    opt.rtol = opt.atol = tolerance;
    opt.suppress_algebraic = form->suppress_algebraic;
    opt.max_steps = most_steps;
    bench_check(mbsr_ida_create(s.model, s.data, &opt, &ida, &error), "driver", error.text);
    bench_check(mbsr_ida_start(ida, 0.0, y, yp), "driver", mbsr_ida_error(ida)->text);
    const double begin = bench_now();
    result.status = mbsr_ida_advance(ida, problem->T, NULL, y, yp);
    result.seconds = bench_now() - begin;
    if (!result.status) result.error = distance(problem->n, y, reference); /* y begins with q */
    bench_check(mbsr_ida_get_stats(ida, &result.stats), "statistics", NULL);
    mbsr_ida_destroy(ida);
    destroy(&s);
    return result;
}

static void report(const struct problem *problem, const struct form *form, double tolerance,
                   const double *reference)
{
    const run r = integrate(problem, form, tolerance, reference);
    const char *result = r.status == MBSR_OK           ? "ok"
                         : r.stats.steps >= most_steps ? "too_many_steps"
                         : r.status == MBSR_ERR_SOLVER ? "solver_failed"
                                                       : mbsr_status_name(r.status);
    printf("%s,%g,%g,%s,%g,%s,%ld,%ld,%ld,%ld,%ld,%ld,%.4f,", problem->name, problem->mass,
           problem->damping, form->name, tolerance, result, r.stats.steps, r.stats.residuals,
           r.stats.jacobian_residuals, r.stats.newton_iterations, r.stats.newton_failures,
           r.stats.error_test_failures, r.seconds);
    printf(r.status ? "\n" : "%.3e\n", r.error);
    fflush(stdout);
}

/* ---- motion ---------------------------------------------------------------------------------- */

/* t, x, y of the bead, x, y of the pendulum's mass. */
static void record_motion(const struct problem *problem, const char *path)
{
    double y[Y_MOST], yp[Y_MOST], bead[2], mass[3];
    mbsr_ida *ida;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-8;
    FILE *file = fopen(path, "w");
    if (!file) bench_check(MBSR_ERR_VALUE, "cannot write", path);
    setup s = make(problem);
    start(problem, &s, opt.form, y, yp);
    bench_check(mbsr_ida_create(s.model, s.data, &opt, &ida, NULL), "driver", NULL);
    bench_check(mbsr_ida_start(ida, 0.0, y, yp), "driver", mbsr_ida_error(ida)->text);
    fprintf(file, "# %s, mass %g, damping %g: t,x,y of the bead,x,y of the pendulum's mass\n",
            problem->name, problem->mass, problem->damping);
    for (int k = 0; k <= FRAMES; ++k) {
        const double t = problem->T * k / FRAMES;
        if (k) {
            bench_check(mbsr_ida_advance(ida, t, NULL, y, yp), "motion", mbsr_ida_error(ida)->text);
        }
        bench_check(mbsr_stage_positions(s.model, s.data, t, y), "motion", NULL);
        bench_check(mbsr_body_pose(s.model, s.data, 0, bead), "motion", NULL);
        bench_check(mbsr_body_pose(s.model, s.data, 1, mass), "motion", NULL);
        fprintf(file, "%.4f,%.6f,%.6f,%.6f,%.6f\n", t, bead[0], bead[1], mass[0], mass[1]);
    }
    fclose(file);
    mbsr_ida_destroy(ida);
    destroy(&s);
}

int main(int argc, char **argv)
{
    const double smallest = argc > 1 ? atof(argv[1]) : tolerances[TOLERANCES - 1];
    double reference[PROBLEMS][Q_MOST];
    if (!(smallest > 0.0)) {
        fprintf(stderr, "usage: bench_precision [smallest tolerance [motion.csv]]\n");
        return EXIT_FAILURE;
    }
    if (argc > 2) record_motion(problems, argv[2]);
    bench_header(stdout,
                 "libmbsrank: work and precision of the DAE forms, SUNDIALS IDA, rtol = atol");
    for (int p = 0; p < PROBLEMS; ++p) find_reference(problems + p, reference[p]);
    printf("# too_many_steps: given up at %ld steps; the numbers of such a run, and of one in "
           "which the solver failed, are those up to there\n"
           "problem,mass,damping,form,tolerance,result,steps,residuals,jacobian_residuals,"
           "newton_iterations,newton_failures,error_test_failures,cpu_s,error\n",
           most_steps);
    for (int p = 0; p < PROBLEMS; ++p) {
        for (int f = 0; f < FORMS; ++f) {
            if (forms[f].zero_mass_only && problems[p].mass > 0.0) continue;
            for (int k = 0; k < TOLERANCES && tolerances[k] >= 0.999 * smallest; ++k)
                report(problems + p, forms + f, tolerances[k], reference[p]);
        }
    }
    return EXIT_SUCCESS;
}

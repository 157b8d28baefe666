/* Newton's method for stiff elements as a nonlinear solver of SUNDIALS.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/stiff.h"
#include "ida/vectors.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <math.h>
#include <stdlib.h>

static mbsri_stiff *content(SUNNonlinearSolver solver)
{
    return solver->content;
}

/* ---- a step ---- */

/* An attempt begins. */
static void begin_attempt(mbsri_stiff *s, N_Vector w, void *memory)
{
    s->memory = memory;
    s->weight = w;
    s->now.call = MBSRI_CALL_NONE;
    s->now.iterations = s->now.failures = 0;
    s->now.hides = false;
    mbsri_stiff_look_back(s); /* by c of the attempt before */
    const long before = s->now.steps;
    IDAGetNumSteps(memory, &s->now.steps);
    mbsri_stiff_note_step(s, before);
    IDAGetCurrentCj(memory, &s->now.c);
}

/* It has ended well. The longest step so far: what is fast beside it is stiff, however short steps
 * have become. */
static void end(mbsri_stiff *s)
{
    const double c = fabs(s->now.c);
    s->now.call = MBSRI_CALL_AWAITED;
    if (c > 0.0 && !(s->blame.slowest > 0.0 && s->blame.slowest <= c)) s->blame.slowest = c;
}

static void set_careful(mbsri_stiff *s, bool careful)
{
    if (s->now.careful != careful) mbsri_stiff_prepare(s, careful);
    s->now.careful = careful;
}

static int solve_nonlinear(SUNNonlinearSolver solver, N_Vector predicted, N_Vector ee, N_Vector w,
                           sunrealtype tolerance, sunbooleantype set_up, void *memory)
{
    mbsri_stiff *s = content(solver);
    begin_attempt(s, w, memory);
    int status = SUN_NLS_CONTINUE;
    if (mbsri_control_mode(&s->control, s->now.steps) == MBSRI_MODE_ORDINARY) {
        set_careful(s, false);
        status = mbsri_stiff_iterate_plainly(s, predicted, ee, tolerance, set_up);
    }
    if (status == SUN_NLS_CONTINUE) {
        set_careful(s, true);
        status = mbsri_stiff_iterate(s, ee, tolerance / s->stricter, tolerance, !set_up);
    }
    if (!status) end(s);
    return status;
}

/* ---- what IDA asks besides, and hands over ---- */

static int initialize(SUNNonlinearSolver solver)
{
    mbsri_stiff *s = content(solver);
    mbsri_control_begin(&s->control);
    s->blame.slowest = 0.0;
    s->rounding.norm = 0.0;
    s->rounding.at = 0;
    s->past.known = 0;
    s->made.c = 0.0;
    s->now.steps = 0;
    s->now.call = MBSRI_CALL_NONE;
    s->now.suspect = false;
    s->id = NULL;
    return SUNNonlinSolInitialize(s->plain);
}

static int set_system(SUNNonlinearSolver solver, SUNNonlinSolSysFn function)
{
    content(solver)->system = function;
    return SUNNonlinSolSetSysFn(content(solver)->plain, function);
}

static int set_set_up(SUNNonlinearSolver solver, SUNNonlinSolLSetupFn function)
{
    content(solver)->set_up = function;
    return SUNNonlinSolSetLSetupFn(content(solver)->plain, function);
}

/* IDA's, for the plain iteration. */
static int watched_solve(N_Vector b, void *memory)
{
    (void)memory;
    return mbsri_stiff_solve(mbsri_stiff_behind(b), b);
}

static int set_solve(SUNNonlinearSolver solver, SUNNonlinSolLSolveFn function)
{
    content(solver)->solve = function;
    return SUNNonlinSolSetLSolveFn(content(solver)->plain, watched_solve);
}

static int set_test(SUNNonlinearSolver solver, SUNNonlinSolConvTestFn function, void *data)
{
    return SUNNonlinSolSetConvTestFn(content(solver)->plain, function, data);
}

static int set_most(SUNNonlinearSolver solver, int iterations)
{
    return SUNNonlinSolSetMaxIters(content(solver)->plain, iterations);
}

static int get_iterations(SUNNonlinearSolver solver, long int *iterations)
{
    *iterations = content(solver)->now.iterations;
    return SUN_NLS_SUCCESS;
}

static int get_failures(SUNNonlinearSolver solver, long int *failures)
{
    *failures = content(solver)->now.failures;
    return SUN_NLS_SUCCESS;
}

/* ---- birth and death ---- */

enum { VECTORS = 10 };

static void list_vectors(mbsri_stiff *s, N_Vector *vector[VECTORS])
{
    N_Vector *const all[VECTORS] = {
        &s->change,      &s->filtered, &s->trial,        &s->error,     &s->blame.direction,
        &s->blame.state, &s->past.y,   &s->past.attempt, &s->past.rate, &s->past.attempt_rate};
    for (int k = 0; k < VECTORS; ++k) vector[k] = all[k];
}

static int destroy(SUNNonlinearSolver solver)
{
    mbsri_stiff *s = content(solver);
    N_Vector *vector[VECTORS];
    list_vectors(s, vector);
    for (int k = 0; k < VECTORS; ++k) {
        if (*vector[k]) N_VDestroy(*vector[k]);
    }
    if (s->plain) SUNNonlinSolFree(s->plain);
    free(s->blame.stiffness);
    free(s);
    solver->content = NULL;
    SUNNonlinSolFreeEmpty(solver);
    return SUN_NLS_SUCCESS;
}

static void set_operations(SUNNonlinearSolver solver)
{
    solver->ops->initialize = initialize;
    solver->ops->solve = solve_nonlinear;
    solver->ops->free = destroy;
    solver->ops->setsysfn = set_system;
    solver->ops->setlsetupfn = set_set_up;
    solver->ops->setlsolvefn = set_solve;
    solver->ops->setctestfn = set_test;
    solver->ops->setmaxiters = set_most;
    solver->ops->getnumiters = get_iterations;
    solver->ops->getnumconvfails = get_failures;
}

/* The vectors are made before y knows of the filter: they need none. Those of the plain iteration
 * do. */
static bool make(SUNNonlinearSolver solver, N_Vector y, SUNContext context)
{
    mbsri_stiff *s = content(solver);
    N_Vector *vector[VECTORS];
    list_vectors(s, vector);
    mbsri_ida_use_own_operations(y);
    for (int k = 0; k < VECTORS; ++k) {
        *vector[k] = N_VClone(y);
        if (!*vector[k]) return false;
        N_VConst(0.0, *vector[k]);
    }
    s->blame.stiffness = calloc((size_t)s->blame.forces + 1, sizeof *s->blame.stiffness);
    if (!s->blame.stiffness) return false;
    mbsri_control_begin(&s->control);
    s->control.looks = true;
    mbsri_stiff_set_rtol(s, 0.0);
    if (!mbsri_stiff_attach(s, y)) return false;
    s->plain = SUNNonlinSol_Newton(y, context);
    if (!s->plain) return false;
    solver->ops->gettype = s->plain->ops->gettype;
    return true;
}

SUNNonlinearSolver mbsri_stiff_create(const mbsr_model *model, mbsr_dae_form form, N_Vector y,
                                      SUNContext context)
{
    if (N_VGetVectorID(y) != SUNDIALS_NVEC_SERIAL) return NULL;
    if (N_VGetLength(y) != mbsr_dae_size(model, form)) return NULL;
    mbsri_stiff *s = calloc(1, sizeof *s);
    SUNNonlinearSolver solver = s ? SUNNonlinSolNewEmpty(context) : NULL;
    if (!solver) {
        free(s);
        return NULL;
    }
    solver->content = s;
    set_operations(solver);
    s->first = mbsr_model_nq(model);
    s->blame.forces = mbsr_model_forces(model);
    s->last =
        form == MBSR_DAE_MOMENTUM ? s->first + mbsr_model_nu(model) : mbsr_dae_size(model, form);
    if (make(solver, y, context)) return solver;
    destroy(solver);
    return NULL;
}

void mbsri_stiff_set_rtol(mbsri_stiff *s, double rtol)
{
    static const double share = 0.3, loosest = 7e-5;
    s->stricter = fmax(1.0, rtol / loosest) / share;
}

mbsri_stiff *mbsri_stiff_of(SUNNonlinearSolver solver)
{
    return solver->ops->solve == solve_nonlinear ? content(solver) : NULL;
}

/* ---- an IDA of one's own ---- */

SUNNonlinearSolver mbsr_sundials_stiff(const mbsr_model *model, N_Vector y, SUNContext context)
{
    if (!model || !y || !context) return NULL;
    return mbsri_stiff_create(model, MBSR_DAE_MOMENTUM, y, context);
}

int mbsr_sundials_stiff_set_rtol(SUNNonlinearSolver solver, double rtol)
{
    if (!solver) return MBSR_ERR_NULL;
    if (!mbsri_stiff_of(solver) || !(rtol >= 0.0 && isfinite(rtol))) return MBSR_ERR_VALUE;
    mbsri_stiff_set_rtol(content(solver), rtol);
    return MBSR_OK;
}

int mbsr_sundials_stiff_set_renewal(SUNNonlinearSolver solver, double share)
{
    if (!solver) return MBSR_ERR_NULL;
    if (!mbsri_stiff_of(solver) || !(share >= 0.0 && share < 1.0)) return MBSR_ERR_VALUE;
    content(solver)->control.matrices.share = share;
    return MBSR_OK;
}

int mbsr_sundials_stiff_get_info(SUNNonlinearSolver solver, mbsr_sundials_stiff_info *info)
{
    if (!solver || !info) return MBSR_ERR_NULL;
    if (!mbsri_stiff_of(solver)) return MBSR_ERR_VALUE;
    *info = content(solver)->info;
    return MBSR_OK;
}

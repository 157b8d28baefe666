/* Newton's method for stiff elements, as a nonlinear solver of SUNDIALS.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Predicted coordinates leave a stiff element strained by g, of the second order in the step, and
 * k g is a large force. With an old matrix, whose stiff direction has turned by an angle a since,
 * an iteration leaves a force k g a across that direction, where there is only the inertia m c^2 to
 * resist it: the iterations creep or diverge, or stop, small in the norm, with a rest of strain
 * whose energy is not small. A new matrix in each iteration leaves k g^2: it converges quadratically
 * or not at all. So in careful steps the matrix is new at first, and in each iteration in which the residual
 * r of the momenta, r / c, shows that something is still strained, and the last correction has to be small
 * itself, not by a rate of convergence. (Of a Krylov method it is the preconditioner that would be new, in
 * each step is enough. Where momenta do not show all that is strained it is new in each iteration.) Other
 * steps are left to the solver of SUNDIALS, or begin with a new matrix (renewal.c).
 *
 * There a stiff matrix may hide a force: a residual r of the momenta is an error r / c of theirs unless
 * something stiff takes it, and where the matrix is old, that may be gone: a stop that was left, a direction
 * that has turned. The correction is small then, and passes for converged. So where r / c was more than the
 * tolerance, and the correction less than a third of it, the next residual is looked at. As long as its
 * r / c is beyond the tolerance and halves each time, iterations with the matrix at hand go on; where it does
 * not, iterations with new matrices have the last word. */
#include "ida/stiff.h"
#include "ida/vectors.h"

#include <ida/ida.h>
#include <ida/ida_ls.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <math.h>
#include <stdlib.h>

enum { ITERATIONS = 10, NEAR = 10 };

/* Whether two corrections in a row, of new matrices, are of one size: the stiff direction turns so much
 * in one of them that the next has to undo what it did. An old matrix would not do here. */
static bool turns(double before, double size, double tolerance)
{
    return before > tolerance && size > 0.3 * before;
}

/* IDA's tolerance is for what is left after the last iteration. Where rounding keeps corrections
 * above the smaller one here, four of them in a row within it will do; or within `rounding`, where they do not
 * even shrink: with short steps h rounding of q is one of velocities by 1/h. Nothing better is to be had either
 * where corrections have been shortened in vain twice. */
static int iterate(mbsri_stiff *s, N_Vector ee, N_Vector w, double tolerance, double rounding)
{
    static const double share = 0.03;
    const double enough = s->looks ? share * tolerance : 0.0,
                 within = s->iterates ? INFINITY : enough;
    int small = 0, still = 0, vain = 0;
    double before = 0.0, power = 0.0;
    bool grows = false;
    for (int k = 1; k <= ITERATIONS; ++k) {
        mbsri_search search = MBSRI_SEARCH_NONE;
        int status = mbsri_stiff_evaluate(s, ee);
        if (!status && k > 1) status = mbsri_stiff_search(s, ee, power, enough, &search);
        if (status) return status;
        if (search == MBSRI_SEARCH_IN_VAIN && ++vain == 2) return SUN_NLS_SUCCESS;
        N_VScale(1.0, s->change, s->trial);
        status = mbsri_stiff_correct(s, ee, k == 1 || search ? 0.0 : within);
        if (status) return status;
        power = mbsri_stiff_power(s, s->change, s->trial);
        N_VScale(1.0, s->change, s->filtered);
        const double size = N_VWrmsNorm(s->change, w);
        if (k == 2 && turns(before, size, tolerance)) mbsri_stiff_begin(s);
        small = size <= tolerance ? small + 1 : 0;
        still = size <= rounding ? still + 1 : 0;
        grows = still > 1 && (grows || size > before);
        if (size <= share * tolerance || small == 4 || (still > 3 && grows)) return SUN_NLS_SUCCESS;
        before = size;
    }
    ++s->failures;
    return SUN_NLS_CONV_RECVR;
}

/* Where the plain iteration fails, or misleads, twice within a few steps the next ones are careful. */
static void note_failure(mbsri_stiff *s)
{
    if (s->failed_at >= 0 && s->steps >= s->failed_at && s->steps - s->failed_at < NEAR) {
        ++s->info.stiff_iterations;
        mbsri_stiff_try(s);
    }
    s->failed_at = s->steps;
}

/* IDA's, for the plain iteration. */
static int watched_solve(N_Vector b, void *memory)
{
    (void)memory;
    return mbsri_stiff_solve(mbsri_stiff_behind(b), b);
}

/* What the linear solver is, as soon as it has worked: it iterates, or has made a matrix. */
static void learn(mbsri_stiff *s)
{
    long linear = 0, matrices = 0, quotients = 0;
    if (IDAGetNumLinIters(s->memory, &linear) < 0) return;
    IDAGetNumJacEvals(s->memory, &matrices);
    IDAGetNumLinResEvals(s->memory, &quotients);
    s->iterates = linear > 0;
    s->quotients = !s->iterates && quotients > 0;
    s->dear = s->dear || s->iterates || s->quotients;
    s->learned = s->iterates || (matrices > 0 && !s->careful);
}

/* What stiff elements ask of an iterative solver: of IDA's own accuracy, a twentieth of what Newton's
 * method leaves, elements that its preconditioner knows nothing of make wrong corrections, and so do
 * quotients over the length of a tolerance. 0 and 1 are IDA's defaults. */
static void prepare(mbsri_stiff *s, bool careful)
{
    if (s->iterates) {
        IDASetEpsLin(s->memory, careful ? 1e-7 : 0.0);
        IDASetIncrementFactor(s->memory, careful ? 1e-2 : 1.0);
    }
    if (s->prepare) s->prepare(s->user, careful);
}

static int iterate_and_count(mbsri_stiff *s, N_Vector ee, N_Vector w, double tolerance,
                             double rounding)
{
    ++s->info.careful_attempts;
    const int status = iterate(s, ee, w, tolerance, rounding);
    if (status != SUN_NLS_CONV_RECVR) return status;
    ++s->info.careful_failures;
    mbsri_stiff_keep(s, ee, true);
    return status;
}

/* Plain iterations go on until the momenta that are left do not matter: MOST of them, as long as they
 * halve what is left. SUN_NLS_CONTINUE: that was not enough. */
static int go_on(mbsri_stiff *s, N_Vector ee, double tolerance)
{
    enum { MOST = 4 };
    double before = INFINITY;
    for (int k = 0;; ++k) {
        int status = s->system(ee, s->change, s->memory);
        if (status) return status;
        const double now = mbsri_stiff_left(s);
        if (now <= tolerance) return SUN_NLS_SUCCESS;
        if (k == MOST || !(now < 0.5 * before)) return SUN_NLS_CONTINUE;
        before = now;
        ++s->iterations;
        N_VScale(-1.0, s->change, s->change);
        status = s->solve(s->change, s->memory);
        if (status) return status;
        N_VLinearSum(1.0, ee, 1.0, s->change, ee);
    }
}

/* Iterations with new matrices after plain ones. Where they are dear and have nothing to correct, the
 * next are put off, for twice as long each time. */
static int renew(mbsri_stiff *s, N_Vector ee, N_Vector w, double tolerance)
{
    enum { LONGEST = 128 };
    if (s->steps < s->verify_at) return SUN_NLS_SUCCESS;
    N_VScale(1.0, ee, s->error);
    prepare(s, true);
    const int status = iterate_and_count(s, ee, w, tolerance, tolerance);
    prepare(s, false);
    N_VLinearSum(1.0, ee, -1.0, s->error, s->error);
    const bool misled = status || N_VWrmsNorm(s->error, w) > tolerance;
    s->pause = misled || s->pause == 0 ? 1 : 2 * s->pause;
    if (s->pause > LONGEST) s->pause = LONGEST;
    s->verify_at = s->dear ? s->steps + s->pause : 0;
    if (misled) note_failure(s);
    return status;
}

/* After plain iterations that may have been misled. */
static int verify(mbsri_stiff *s, N_Vector ee, N_Vector w, double tolerance)
{
    if (!s->hides) return SUN_NLS_SUCCESS;
    const int status = go_on(s, ee, tolerance);
    return status == SUN_NLS_CONTINUE ? renew(s, ee, w, tolerance) : status;
}

/* The longest step so far: what is fast beside it is stiff, however short steps have become. */
static void note_pace(mbsri_stiff *s)
{
    if (s->c == 0.0) return;
    const double c = fabs(s->c);
    if (!(s->slowest > 0.0 && s->slowest <= c)) s->slowest = c;
}

/* Newton's method of SUNDIALS. */
static int iterate_plainly(mbsri_stiff *s, N_Vector predicted, N_Vector ee, N_Vector w,
                           double tolerance, bool set_up)
{
    const int status = SUNNonlinSolSolve(s->plain, predicted, ee, w, tolerance, set_up, s->memory);
    SUNNonlinSolGetNumIters(s->plain, &s->iterations);
    SUNNonlinSolGetNumConvFails(s->plain, &s->stale);
    s->failures = s->stale;
    s->untested = s->untested || set_up || s->stale > 0;
    return status;
}

/* An attempt begins. */
static void begin(mbsri_stiff *s, N_Vector w, void *memory)
{
    s->memory = memory;
    s->weight = w;
    s->norms = -1;
    s->iterations = s->failures = 0;
    s->hides = false;
    if (s->off) return;
    mbsri_stiff_look_back(s); /* by c of the attempt before */
    const long before = s->steps;
    IDAGetNumSteps(memory, &s->steps);
    mbsri_stiff_note_step(s, before);
    IDAGetCurrentCj(memory, &s->c);
}

static int solve(SUNNonlinearSolver solver, N_Vector predicted, N_Vector ee, N_Vector w,
                 sunrealtype tolerance, sunbooleantype set_up, void *memory);

/* An ordinary step. */
static int solve_plainly(SUNNonlinearSolver solver, N_Vector predicted, N_Vector ee, N_Vector w,
                         double tolerance, bool set_up)
{
    mbsri_stiff *s = solver->content;
    const mbsri_matrix matrix = mbsri_stiff_choose(s, set_up);
    int status;
    if (matrix == MBSRI_MATRIX_BEGIN)
        status = mbsri_stiff_begin_anew(s, ee, w, tolerance);
    else
        status = iterate_plainly(s, predicted, ee, w, tolerance, matrix == MBSRI_MATRIX_NEW);
    if (status == SUN_NLS_CONV_RECVR) note_failure(s);
    if (matrix != MBSRI_MATRIX_BEGIN)
        status = mbsri_stiff_judge(s, matrix, status, ee, w, tolerance);
    if (!s->learned) learn(s);
    if (status) return status;
    if (!mbsri_stiff_wrong_matrix(s, predicted, ee)) return verify(s, ee, w, tolerance);
    ++s->info.stiff_iterations;
    mbsri_stiff_try(s);
    N_VConst(0.0, ee);
    return solve(solver, predicted, ee, w, tolerance, set_up, s->memory);
}

static int solve(SUNNonlinearSolver solver, N_Vector predicted, N_Vector ee, N_Vector w,
                 sunrealtype tolerance, sunbooleantype set_up, void *memory)
{
    mbsri_stiff *s = solver->content;
    const bool before = s->careful;
    begin(s, w, memory);
    if (s->off) return iterate_plainly(s, predicted, ee, w, tolerance, set_up);
    s->careful = mbsri_stiff_careful(s);
    if (s->careful != before) prepare(s, s->careful);
    const int status = s->careful ? iterate_and_count(s, ee, w, tolerance / s->stricter, tolerance)
                                  : solve_plainly(solver, predicted, ee, w, tolerance, set_up);
    if (status) return status;
    s->norms = 0;
    note_pace(s);
    return status;
}

/* ---- what IDA asks besides, and hands over ---- */

static SUNNonlinearSolver_Type type(SUNNonlinearSolver solver)
{
    (void)solver;
    return SUNNONLINEARSOLVER_ROOTFIND;
}

static int initialize(SUNNonlinearSolver solver)
{
    mbsri_stiff *s = solver->content;
    s->careful_until = s->span = 0;
    s->tested_step = s->slowest = 0.0;
    s->verify_at = 0;
    s->pause = 0;
    s->enough = MBSRI_STIFF_ALARM;
    s->failed_at = s->rejected_at = s->turned_at = -1;
    s->learned = s->untested = false;
    s->past.known = 0;
    s->steps = 0;
    s->rated = 0;
    s->due = 2.0;
    s->norms = -1;
    s->suspect = false;
    s->id = NULL;
    s->vibrations = 0;
    s->vibrated_at = 0;
    s->patience = 1;
    s->age = 0;
    s->life = s->made_at = s->measured_at = 0;
    return SUNNonlinSolInitialize(s->plain);
}

static int set_system(SUNNonlinearSolver solver, SUNNonlinSolSysFn function)
{
    mbsri_stiff *s = solver->content;
    s->system = function;
    return SUNNonlinSolSetSysFn(s->plain, function);
}

static int set_set_up(SUNNonlinearSolver solver, SUNNonlinSolLSetupFn function)
{
    mbsri_stiff *s = solver->content;
    s->set_up = function;
    return SUNNonlinSolSetLSetupFn(s->plain, function);
}

static int set_solve(SUNNonlinearSolver solver, SUNNonlinSolLSolveFn function)
{
    mbsri_stiff *s = solver->content;
    s->solve = function;
    return SUNNonlinSolSetLSolveFn(s->plain, watched_solve);
}

static int set_test(SUNNonlinearSolver solver, SUNNonlinSolConvTestFn function, void *data)
{
    return SUNNonlinSolSetConvTestFn(((mbsri_stiff *)solver->content)->plain, function, data);
}

static int set_most(SUNNonlinearSolver solver, int iterations)
{
    return SUNNonlinSolSetMaxIters(((mbsri_stiff *)solver->content)->plain, iterations);
}

static int get_iterations(SUNNonlinearSolver solver, long int *iterations)
{
    *iterations = ((const mbsri_stiff *)solver->content)->iterations;
    return SUN_NLS_SUCCESS;
}

static int get_current(SUNNonlinearSolver solver, int *iteration)
{
    *iteration = (int)((const mbsri_stiff *)solver->content)->iterations - 1;
    return SUN_NLS_SUCCESS;
}

static int get_failures(SUNNonlinearSolver solver, long int *failures)
{
    *failures = ((const mbsri_stiff *)solver->content)->failures;
    return SUN_NLS_SUCCESS;
}

/* ---- birth and death ---- */

static int destroy(SUNNonlinearSolver solver)
{
    mbsri_stiff *s = solver->content;
    N_Vector const vector[] = {s->change,    s->filtered, s->trial,  s->error,
                               s->direction, s->state,    s->past.y, s->past.attempt};
    for (size_t k = 0; k < sizeof vector / sizeof vector[0]; ++k) {
        if (vector[k]) N_VDestroy(vector[k]);
    }
    if (s->plain) SUNNonlinSolFree(s->plain);
    free(s->stiffness);
    free(s);
    solver->content = NULL;
    SUNNonlinSolFreeEmpty(solver);
    return SUN_NLS_SUCCESS;
}

static void set_operations(SUNNonlinearSolver solver)
{
    solver->ops->gettype = type;
    solver->ops->initialize = initialize;
    solver->ops->solve = solve;
    solver->ops->free = destroy;
    solver->ops->setsysfn = set_system;
    solver->ops->setlsetupfn = set_set_up;
    solver->ops->setlsolvefn = set_solve;
    solver->ops->setctestfn = set_test;
    solver->ops->setmaxiters = set_most;
    solver->ops->getnumiters = get_iterations;
    solver->ops->getcuriter = get_current;
    solver->ops->getnumconvfails = get_failures;
}

/* The vectors are made before y knows of the filter: they need none. Those of the plain iteration do. */
static bool make(mbsri_stiff *s, N_Vector y, SUNContext context)
{
    N_Vector *const vector[] = {&s->change,    &s->filtered, &s->trial,  &s->error,
                                &s->direction, &s->state,    &s->past.y, &s->past.attempt};
    mbsri_ida_use_own_operations(y);
    for (size_t k = 0; k < sizeof vector / sizeof vector[0]; ++k) {
        *vector[k] = N_VClone(y);
        if (!*vector[k]) return false;
        N_VConst(0.0, *vector[k]);
    }
    s->stiffness = calloc((size_t)s->forces + 1, sizeof *s->stiffness);
    if (!s->stiffness) return false;
    s->failed_at = s->rejected_at = s->norms = -1;
    mbsri_stiff_set_rtol(s, 0.0);
    s->looks = true;
    if (!mbsri_stiff_attach(s, y)) return false;
    s->plain = SUNNonlinSol_Newton(y, context);
    return s->plain != NULL;
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
    s->forces = mbsr_model_forces(model);
    s->last =
        form == MBSR_DAE_MOMENTUM ? s->first + mbsr_model_nu(model) : mbsr_dae_size(model, form);
    if (make(s, y, context)) return solver;
    destroy(solver);
    return NULL;
}

void mbsri_stiff_set_rtol(mbsri_stiff *s, double rtol)
{
    static const double share = 0.3, loosest = 7e-5;
    s->stricter = fmax(1.0, rtol / loosest) / share;
}

SUNNonlinearSolver mbsr_sundials_stiff(const mbsr_model *model, N_Vector y, SUNContext context)
{
    if (!model || !y || !context) return NULL;
    return mbsri_stiff_create(model, MBSR_DAE_MOMENTUM, y, context);
}

mbsri_stiff *mbsri_stiff_of(SUNNonlinearSolver solver)
{
    return solver->ops->solve == solve ? solver->content : NULL;
}

int mbsr_sundials_stiff_set_rtol(SUNNonlinearSolver solver, double rtol)
{
    if (!solver) return MBSR_ERR_NULL;
    if (solver->ops->solve != solve || !(rtol >= 0.0 && isfinite(rtol))) return MBSR_ERR_VALUE;
    mbsri_stiff_set_rtol(solver->content, rtol);
    return MBSR_OK;
}

int mbsr_sundials_stiff_set_renewal(SUNNonlinearSolver solver, double share)
{
    if (!solver) return MBSR_ERR_NULL;
    if (solver->ops->solve != solve || !(share >= 0.0 && share < 1.0)) return MBSR_ERR_VALUE;
    ((mbsri_stiff *)solver->content)->wrong = share;
    return MBSR_OK;
}

int mbsr_sundials_stiff_get_info(SUNNonlinearSolver solver, mbsr_sundials_stiff_info *info)
{
    if (!solver || !info) return MBSR_ERR_NULL;
    if (solver->ops->solve != solve) return MBSR_ERR_VALUE;
    *info = ((const mbsri_stiff *)solver->content)->info;
    return MBSR_OK;
}

/* PETSc's time stepper TS, with Newton systems solved on the tree (mbsr_newton): a chain of 30
 * beads, every other one without mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * TS asks for F and for a matrix dF/dU + shift dF/dU', which is dF/dy + c dF/dy': the residual and
 * mbsr_newton_factor as they are. The matrix is a shell; KSPPREONLY applies the shell
 * preconditioner, mbsr_newton_solve, once. The matrix multiplies nothing, so the line search has to
 * be SNESLINESEARCHBASIC: one that looks at |F| would be no good, the rows of F having different
 * units.
 *
 * And TS has to be told which tolerances: by itself it tests all of y alike. u is algebraic and
 * belongs into no error test; a momentum is tested by the error of a velocity times a mass,
 * mbsr_momentum_scales. Without that the chain seems to hang: SNES stops when |F| is 1e-8 of what
 * it was, after one iteration where steps are short, since the guess lacks large forces. That
 * leaves O(h^2) in u, where the error test of a method of order 4 finds it and keeps the steps
 * short.
 *
 * The table has such a run, ended after 450 steps, and one as it should be. Reference: the IDA
 * driver with a tolerance of 1e-10. */
#include <mbsrank/ida.h>
#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include "build.h"

#include <petscts.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { PAIRS = 15, MOST = 450 };
static const double T = 0.5, tolerance = 1e-8;

/* What the callbacks need. */
typedef struct problem {
    mbsr_model *m;
    mbsr_data *d;
    mbsr_newton *newton;
    int nq, nu, size;
    double mass[3 * PAIRS]; /* momenta over velocities, at the start */
} problem;

/* Pairs of a bead without mass, held to the one before by springs and dampers, and a rod that hangs
 * on it, a particle at its end; the first rod is let go from the level. y of the momentum form at
 * the start. */
static problem chain(double *y, double *yp)
{
    const double length = 1.0 / PAIRS, q[3 * PAIRS] = {0.0, 0.0, 0.5 * acos(-1.0)};
    const double u[3 * PAIRS] = {0.0};
    const mbsr_planar_frame centre = {0}, end = {0.0, length, 0.0};
    problem c = {.m = new_model()};
    mbsr_error error;
    for (int last = MBSR_GROUND, i = 0; i < PAIRS; ++i) {
        const int bead = add_body(c.m, "bead", last, mbsr_joint_point_free(), mbsr_inertia_zero());
        for (int axis = 0; axis < 2; ++axis)
            add_force(c.m, mbsr_force_axis_spring(bead, last, axis, 100.0, 5.0, 0.0));
        last = add_body(c.m, "rod", bead, mbsr_joint_planar_revolute(centre, end),
                        mbsr_inertia_particle(1.0 / PAIRS));
    }
    add_force(c.m, mbsr_force_gravity(0.0, -9.81, 0.0));
    check(mbsr_model_finish(c.m), mbsr_model_error(c.m));
    check(mbsr_data_create(c.m, &c.d, &error), &error);
    check(mbsr_newton_create(c.m, MBSR_DAE_MOMENTUM, NULL, &c.newton, &error), &error);
    c.nq = mbsr_model_nq(c.m), c.nu = mbsr_model_nu(c.m);
    c.size = mbsr_dae_size(c.m, MBSR_DAE_MOMENTUM);
    check(mbsr_dae_pack(c.m, c.d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(c.d));
    check(mbsr_dae_consistent(c.m, c.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
          mbsr_data_error(c.d));
    check(mbsr_newton_factor(c.newton, c.d, 0.0, y, yp, 1.0), mbsr_newton_error(c.newton));
    check(mbsr_momentum_scales(c.m, c.d, c.mass), mbsr_data_error(c.d));
    return c;
}

/* A recoverable status lets TS try a shorter step; others end the run with the library's text. */
static PetscErrorCode residual(TS ts, PetscReal t, Vec y, Vec yp, Vec F, void *user)
{
    problem *c = user;
    const PetscScalar *in, *rate;
    PetscScalar *out;
    SNES snes;
    PetscCall(VecGetArrayRead(y, &in));
    PetscCall(VecGetArrayRead(yp, &rate));
    PetscCall(VecGetArrayWrite(F, &out));
    const int status = mbsr_dae_residual(c->m, c->d, MBSR_DAE_MOMENTUM, t, in, rate, out);
    PetscCall(VecRestoreArrayRead(y, &in));
    PetscCall(VecRestoreArrayRead(yp, &rate));
    PetscCall(VecRestoreArrayWrite(F, &out));
    PetscCall(TSGetSNES(ts, &snes));
    if (status > 0) PetscCall(SNESSetFunctionDomainError(snes));
    PetscCheck(status >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "%s", mbsr_data_error(c->d)->text);
    return 0;
}

static PetscErrorCode factor(TS ts, PetscReal t, Vec y, Vec yp, PetscReal shift, Mat A, Mat P,
                             void *user)
{
    problem *c = user;
    const PetscScalar *in, *rate;
    SNES snes;
    (void)A, (void)P;
    PetscCall(VecGetArrayRead(y, &in));
    PetscCall(VecGetArrayRead(yp, &rate));
    const int status = mbsr_newton_factor(c->newton, c->d, t, in, rate, shift);
    PetscCall(VecRestoreArrayRead(y, &in));
    PetscCall(VecRestoreArrayRead(yp, &rate));
    PetscCall(TSGetSNES(ts, &snes));
    if (status > 0) PetscCall(SNESSetJacobianDomainError(snes));
    PetscCheck(status >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "%s",
               mbsr_newton_error(c->newton)->text);
    return 0;
}

static PetscErrorCode solve(PC pc, Vec r, Vec delta)
{
    problem *c;
    const PetscScalar *in;
    PetscScalar *out;
    PetscCall(PCShellGetContext(pc, &c));
    PetscCall(VecGetArrayRead(r, &in));
    PetscCall(VecGetArrayWrite(delta, &out));
    const int status = mbsr_newton_solve(c->newton, in, out);
    PetscCall(VecRestoreArrayRead(r, &in));
    PetscCall(VecRestoreArrayWrite(delta, &out));
    PetscCheck(!status, PETSC_COMM_SELF, PETSC_ERR_LIB, "%s", mbsr_newton_error(c->newton)->text);
    return 0;
}

/* u out of the error test, by a tolerance without end. */
static PetscErrorCode set_tolerances(TS ts, const problem *c)
{
    Vec absolute, relative;
    PetscCall(VecCreateSeq(PETSC_COMM_SELF, c->size, &absolute));
    PetscCall(VecDuplicate(absolute, &relative));
    PetscCall(VecSet(absolute, tolerance));
    PetscCall(VecSet(relative, tolerance));
    for (int k = 0; k < c->nu; ++k) {
        const int p = c->nq + k, u = p + c->nu;
        PetscCall(VecSetValue(absolute, p, tolerance * c->mass[k], INSERT_VALUES));
        PetscCall(VecSetValue(absolute, u, PETSC_INFINITY, INSERT_VALUES));
        PetscCall(VecSetValue(relative, u, 0.0, INSERT_VALUES));
    }
    PetscCall(TSSetTolerances(ts, 0.0, absolute, 0.0, relative));
    PetscCall(VecDestroy(&absolute));
    PetscCall(VecDestroy(&relative));
    return 0;
}

static PetscErrorCode set_newton(TS ts, Mat A, problem *c)
{
    SNES snes;
    KSP ksp;
    PC pc;
    SNESLineSearch search;
    PetscCall(TSSetIJacobian(ts, A, A, factor, c));
    PetscCall(TSGetSNES(ts, &snes));
    PetscCall(SNESGetLineSearch(snes, &search));
    PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHBASIC));
    PetscCall(SNESSetCheckJacobianDomainError(snes, PETSC_TRUE));
    PetscCall(SNESGetKSP(snes, &ksp));
    PetscCall(KSPSetType(ksp, KSPPREONLY));
    PetscCall(KSPGetPC(ksp, &pc));
    PetscCall(PCSetType(pc, PCSHELL));
    PetscCall(PCShellSetContext(pc, c));
    PetscCall(PCShellSetApply(pc, solve));
    return 0;
}

/* Runs from y, which becomes the state at *t; all entries of y are tested alike, or as they should
 * be. */
static PetscErrorCode run(problem *c, bool alike, double *y, double *t, int *steps)
{
    Vec state, F;
    Mat A;
    TS ts;
    PetscInt taken;
    PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, c->size, y, &state));
    PetscCall(VecDuplicate(state, &F));
    PetscCall(MatCreateShell(PETSC_COMM_SELF, c->size, c->size, c->size, c->size, c, &A));
    PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
    PetscCall(TSSetType(ts, TSARKIMEX));
    PetscCall(TSARKIMEXSetType(ts, TSARKIMEX4));
    PetscCall(TSSetEquationType(ts, TS_EQ_DAE_IMPLICIT_INDEX1));
    PetscCall(TSSetIFunction(ts, F, residual, c));
    PetscCall(set_newton(ts, A, c));
    if (alike)
        PetscCall(TSSetTolerances(ts, tolerance, NULL, tolerance, NULL));
    else
        PetscCall(set_tolerances(ts, c));
    PetscCall(TSSetTimeStep(ts, 1e-3));
    PetscCall(TSSetMaxTime(ts, T));
    PetscCall(TSSetMaxSteps(ts, MOST));
    PetscCall(TSSetMaxSNESFailures(ts, 100)); /* iterations that fail, in all */
    PetscCall(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
    PetscCall(TSSetFromOptions(ts));
    PetscCall(TSSolve(ts, state));
    PetscCall(TSGetTime(ts, t));
    PetscCall(TSGetStepNumber(ts, &taken));
    *steps = (int)taken;
    PetscCall(TSDestroy(&ts));
    PetscCall(MatDestroy(&A));
    PetscCall(VecDestroy(&F));
    PetscCall(VecDestroy(&state));
    return 0;
}

/* q at T by the driver; returns its steps. */
static long reference(const problem *c, const double *y, const double *yp, double tol, double *end)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_ida_stats stats;
    mbsr_error error;
    mbsr_ida *ida;
    opt.rtol = opt.atol = tol;
    check(mbsr_ida_create(c->m, c->d, &opt, &ida, &error), &error);
    check(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    check(mbsr_ida_advance(ida, T, NULL, end, NULL), mbsr_ida_error(ida));
    check(mbsr_ida_get_stats(ida, &stats), mbsr_ida_error(ida));
    mbsr_ida_destroy(ida);
    return stats.steps;
}

/* Largest difference of q. */
static double differ(const problem *c, const double *y, const double *exact)
{
    double largest = 0.0;
    for (int k = 0; k < c->nq; ++k) largest = fmax(largest, fabs(y[k] - exact[k]));
    return largest;
}

int main(int argc, char **argv)
{
    static const char *const name[2] = {"TS, all tested alike", "TS, u not tested"};
    double start[9 * PAIRS], yp[9 * PAIRS], y[9 * PAIRS], exact[9 * PAIRS], t[2], error = 0.0;
    int steps[2] = {0};
    PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
    problem c = chain(start, yp);
    reference(&c, start, yp, 1e-10, exact);
    printf("                        steps   to [s]   factorisations   error of q\n");
    for (int k = 0; k < 2; ++k) {
        mbsr_newton_info before, after;
        memcpy(y, start, sizeof y);
        check(mbsr_newton_get_info(c.newton, &before), mbsr_newton_error(c.newton));
        PetscCall(run(&c, k == 0, y, &t[k], &steps[k]));
        check(mbsr_newton_get_info(c.newton, &after), mbsr_newton_error(c.newton));
        printf("%-21s %7d   %6.4f   %14ld", name[k], steps[k], t[k],
               after.factorisations - before.factorisations);
        error = differ(&c, y, exact);
        printf(t[k] < T ? "\n" : "   %10.1e\n", error);
    }
    const long ida = reference(&c, start, yp, tolerance, y);
    printf("%-21s %7ld   %6.4f   %14s   %10.1e\n", "the IDA driver", ida, T, "",
           differ(&c, y, exact));
    mbsr_newton_destroy(c.newton);
    mbsr_data_destroy(c.d);
    mbsr_model_destroy(c.m);
    PetscCall(PetscFinalize());
    return t[1] == T && error < 1e-5 && steps[1] < MOST && t[0] < T ? 0 : 1;
}

/* The Newton solver (newton.h) as a linear solver of SUNDIALS, for those who drive IDA themselves.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Belongs to the component ida and needs the headers of SUNDIALS 6.4 or newer, as <mbsrank/ida.h>
 * does not. The residual that IDA integrates has to be mbsr_dae_residual of the momentum form on
 * serial vectors (more exactly: vectors with an array, N_VGetArrayPointer).
 *
 *   mbsr_sundials link = {.newton = newton, .data = data};
 *   SUNMatrix matrix = mbsr_sundials_matrix(&link, context);
 *   SUNLinearSolver solver = mbsr_sundials_solver(&link, context);
 *   IDASetLinearSolver(ida, solver, matrix);
 *   IDASetJacFn(ida, mbsr_sundials_jacobian);
 *
 * The matrix has no storage: where IDA asks for a new Jacobian the system is factored on the tree,
 * and the factorisation is kept as IDA keeps one of a dense matrix, over iterations and steps, with
 * IDA's correction for a change of c = cj. (To a solver of the type SUNLINEARSOLVER_MATRIX_EMBEDDED
 * IDA never says when to factor, and it makes neither that correction nor a second attempt with a
 * new Jacobian; so this one is of the type SUNLINEARSOLVER_DIRECT.)
 *
 * Where mbsr_newton_info.exact is 0, the solver is for preconditioning:
 *
 *   SUNLinearSolver solver = SUNLinSol_SPGMR(y, SUN_PREC_LEFT, 30, context);
 *   IDASetLinearSolver(ida, solver, NULL);
 *   IDASetUserData(ida, &mine);   -- a structure whose first member is the mbsr_sundials
 *   IDASetPreconditioner(ida, mbsr_sundials_setup, mbsr_sundials_precondition);
 *
 * and, with `products` in the mbsr_newton_opt, products with the matrix in place of differences of
 * F:
 *
 *   IDASetJacTimes(ida, mbsr_sundials_linearise, mbsr_sundials_multiply); */
#ifndef MBSRANK_SUNDIALS_H
#define MBSRANK_SUNDIALS_H

#include <mbsrank/newton.h>

#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>
#include <sundials/sundials_nonlinearsolver.h>
#include <sundials/sundials_nvector.h>
#include <sundials/sundials_types.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a linear solver works with. The caller's; it, the solver and the data have to stay in place
 * as long as IDA uses them. */
typedef struct mbsr_sundials {
    mbsr_newton *newton;
    mbsr_data *data; /* may be that of the residual */
    int status;      /* result: of the last factorisation, solution or product; the text is in
                      * mbsr_newton_error */
} mbsr_sundials;

/* A matrix without storage, and a linear solver of the type SUNLINEARSOLVER_DIRECT that solves with
 * the last factorisation; to be freed by SUNMatDestroy and SUNLinSolFree, which leave *link alone.
 * NULL where an argument or a member of *link is NULL or SUNDIALS gets no memory. */
MBSR_API SUNMatrix mbsr_sundials_matrix(mbsr_sundials *link, SUNContext context);
MBSR_API SUNLinearSolver mbsr_sundials_solver(mbsr_sundials *link, SUNContext context);

/* For IDASetJacFn: factors at (t, y, y') with c = cj. `jacobian` is a matrix made above; r, user
 * and the vectors are not read. Returns the status, whose sign means to IDA what it means here. */
MBSR_API int mbsr_sundials_jacobian(sunrealtype t, sunrealtype cj, N_Vector y, N_Vector yp,
                                    N_Vector r, SUNMatrix jacobian, void *user, N_Vector work1,
                                    N_Vector work2, N_Vector work3);

/* For IDASetPreconditioner: factors, and solves. `user`, what IDASetUserData was given, points to
 * an mbsr_sundials or to a structure that begins with one. Return the status. */
MBSR_API int mbsr_sundials_setup(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, sunrealtype cj,
                                 void *user);
MBSR_API int mbsr_sundials_precondition(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F,
                                        N_Vector r, N_Vector z, sunrealtype cj, sunrealtype delta,
                                        void *user);

/* For IDASetJacTimes: mbsr_newton_linearise at (t, y, y') with c = cj, and mbsr_newton_multiply, Jv
 * = A v. `user` as above. Return the status. */
MBSR_API int mbsr_sundials_linearise(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F,
                                     sunrealtype cj, void *user);
MBSR_API int mbsr_sundials_multiply(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, N_Vector v,
                                    N_Vector Jv, sunrealtype cj, void *user, N_Vector work1,
                                    N_Vector work2);

/* ---- stiff force elements ---- */

/* Stiff springs with dampers that close a loop, bushings and stops make IDA's error test fail again
 * and again, and Newton's method with an old matrix inaccurate (docs/dae_forms.md). This is a
 * nonlinear solver for IDA that goes with an error test of its own:
 *
 *   N_Vector y = N_VNew_Serial(mbsr_dae_size(model, MBSR_DAE_MOMENTUM), context);
 *   SUNNonlinearSolver newton = mbsr_sundials_stiff(model, y, context);       -- before IDAInit
 *   IDAInit(ida, F, t, y, yp);
 *   ...                                                -- IDASetLinearSolver, of any kind
 *   IDASetId(ida, id);  IDASetSuppressAlg(ida, SUNTRUE);
 *   IDASetNonlinearSolver(ida, newton);
 *
 * As long as nothing is stiff, all goes as without it. Where an error test of low order fails by an
 * error of the momenta that the next step will have forgotten, or the order stays low, IDA takes
 * the next 20 steps carefully, and more where they show that it is needed: with a new matrix in
 * each iteration, and errors of momenta tested by what is left of them after one implicit step. At
 * relative tolerances above 1e-4 steps of a mechanism that stiff elements close are so long that
 * they gain energy; IDA does not tell the solver what was asked for, mbsr_sundials_stiff_set_rtol
 * does. Iterative linear solvers are made to solve such steps accurately (IDASetEpsLin,
 * IDASetIncrementFactor). A step that hits a stop may fail more tests than the 10 that IDA allows:
 * IDASetMaxErrTestFails, 30. Vectors that IDA makes of y refer to the solver: free it after IDA,
 * and y too. They take their operations from y, which gets the library's own here: the bits of
 * SUNDIALS' serial vectors, and faster where those are compiled without optimisation; operations
 * that the caller has replaced stay. The error test is as without it if algebraic variables are not
 * suppressed. NULL where an argument is NULL, y is not a serial vector of that length, or there is
 * no memory. */
MBSR_API SUNNonlinearSolver mbsr_sundials_stiff(const mbsr_model *model, N_Vector y,
                                                SUNContext context);

/* The relative tolerance that IDA was given, 0 or more: steps that are taken carefully are held to
 * 1e-4 where it is larger. MBSR_ERR_NULL; MBSR_ERR_VALUE if the solver is another one, or rtol is
 * negative or not finite. */
MBSR_API int mbsr_sundials_stiff_set_rtol(SUNNonlinearSolver solver, double rtol);

/* Lets steps begin with a new matrix where the old one would leave more than this share of a
 * correction, 0 <= share < 1; 0 (default): none does, IDA keeps its matrices. Half as many steps
 * and iterations may do then. 0.05 is right where a matrix costs no more than two residuals, as
 * mbsr_sundials_solver's on a tree of rigid bodies, 0.2 where it costs ten. Nothing changes with
 * iterative solvers and matrices by difference quotients. MBSR_ERR_NULL; MBSR_ERR_VALUE if the
 * solver is another one, or the share is out of range. */
MBSR_API int mbsr_sundials_stiff_set_renewal(SUNNonlinearSolver solver, double share);

/* What it has done since it was made. */
typedef struct mbsr_sundials_stiff_info {
    long stiff_tests;      /* error tests that would have failed in a stiff direction alone */
    long stiff_iterations; /* Newton's method failed twice within 10 steps, or a matrix of
                            * difference quotients was wrong */
    long careful_attempts; /* steps tried carefully after these */
    long careful_failures; /* of these, those in which Newton's method did not converge */
    long filter_solves;    /* linear systems solved besides those of Newton's iterations */
    long renewals; /* steps that began with a new matrix; each takes a solution besides, too */
} mbsr_sundials_stiff_info;

/* What the nonlinear solver has done so far. MBSR_ERR_NULL; MBSR_ERR_VALUE if the solver is another
 * one. */
MBSR_API int mbsr_sundials_stiff_get_info(SUNNonlinearSolver solver,
                                          mbsr_sundials_stiff_info *info);

/* The force elements that make the model stiff, as mbsr_ida_stiffest, for the model and data of the
 * residual: where a test or an iteration has told, or, where some have failed since the start
 * without telling, those that are fast beside the longest step, at the end of the last one. To be
 * called between two calls of IDASolve, after a failure above all. The data is left at that state.
 * MBSR_ERR_NULL; MBSR_ERR_VALUE if the solver is another one or made for another model; the
 * statuses of mbsr_stage_positions, mbsr_energy and mbsr_force_power. */
MBSR_API int mbsr_sundials_stiffest(SUNNonlinearSolver solver, const mbsr_model *model,
                                    mbsr_data *data, int most, int *force, double *share,
                                    int *count);

#ifdef __cplusplus
}
#endif

#endif

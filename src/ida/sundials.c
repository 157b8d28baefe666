/* The Newton solver as a linear solver of SUNDIALS: a matrix without storage, factored on the tree.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/compat.h"

#include <mbsrank/sundials.h>

#include <stdlib.h>

/* The operations return an int in SUNDIALS 6 and a SUNErrCode, which is an int, since 7; success is
 * zero in both. */
enum { SUCCESS = 0 };

static int factor_system(mbsr_sundials *link, sunrealtype t, N_Vector y, N_Vector yp,
                         sunrealtype cj)
{
    link->status = mbsr_newton_factor(link->newton, link->data, t, N_VGetArrayPointer(y),
                                      N_VGetArrayPointer(yp), cj);
    return link->status;
}

static int solve_system(mbsr_sundials *link, N_Vector r, N_Vector delta)
{
    link->status =
        mbsr_newton_solve(link->newton, N_VGetArrayPointer(r), N_VGetArrayPointer(delta));
    return link->status;
}

/* ---- the matrix ---- */

static SUNMatrix_ID matrix_id(SUNMatrix A)
{
    (void)A;
    return SUNMATRIX_CUSTOM;
}

/* IDA clears a matrix before it asks for a new Jacobian. */
static int matrix_zero(SUNMatrix A)
{
    (void)A;
    return SUCCESS;
}

SUNMatrix mbsr_sundials_matrix(mbsr_sundials *link, SUNContext context)
{
    if (!link || !link->newton || !link->data || !context) return NULL;
    SUNMatrix A = SUNMatNewEmpty(context);
    if (!A) return NULL;
    A->content = link;
    A->ops->getid = matrix_id;
    A->ops->zero = matrix_zero;
    A->ops->destroy = SUNMatFreeEmpty;
    return A;
}

int mbsr_sundials_jacobian(sunrealtype t, sunrealtype cj, N_Vector y, N_Vector yp, N_Vector r,
                           SUNMatrix jacobian, void *user, N_Vector work1, N_Vector work2,
                           N_Vector work3)
{
    (void)r;
    (void)user;
    (void)work1;
    (void)work2;
    (void)work3;
    return factor_system(jacobian->content, t, y, yp, cj);
}

/* ---- the linear solver ---- */

static SUNLinearSolver_Type solver_type(SUNLinearSolver S)
{
    (void)S;
    return SUNLINEARSOLVER_DIRECT;
}

static SUNLinearSolver_ID solver_id(SUNLinearSolver S)
{
    (void)S;
    return SUNLINEARSOLVER_CUSTOM;
}

/* A x = b. What this returns has to be one of the codes that IDA knows: it takes others for
 * success. */
static int solver_solve(SUNLinearSolver S, SUNMatrix A, N_Vector x, N_Vector b, sunrealtype tol)
{
    (void)A;
    (void)tol;
    const int status = solve_system(S->content, b, x);
    if (status == MBSR_OK) return SUCCESS;
    return status > 0 ? SUNLS_PACKAGE_FAIL_REC : MBSRI_IDA_PACKAGE_FAILED;
}

static int solver_free(SUNLinearSolver S)
{
    SUNLinSolFreeEmpty(S);
    return SUCCESS;
}

SUNLinearSolver mbsr_sundials_solver(mbsr_sundials *link, SUNContext context)
{
    if (!link || !link->newton || !link->data || !context) return NULL;
    SUNLinearSolver S = SUNLinSolNewEmpty(context);
    if (!S) return NULL;
    S->content = link;
    S->ops->gettype = solver_type;
    S->ops->getid = solver_id;
    S->ops->solve = solver_solve;
    S->ops->free = solver_free;
    return S;
}

/* ---- the preconditioner ---- */

int mbsr_sundials_setup(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, sunrealtype cj,
                        void *user)
{
    (void)F;
    return factor_system(user, t, y, yp, cj);
}

int mbsr_sundials_precondition(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, N_Vector r,
                               N_Vector z, sunrealtype cj, sunrealtype delta, void *user)
{
    (void)t;
    (void)y;
    (void)yp;
    (void)F;
    (void)cj;
    (void)delta;
    return solve_system(user, r, z);
}

/* ---- products ---- */

int mbsr_sundials_linearise(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, sunrealtype cj,
                            void *user)
{
    mbsr_sundials *link = user;
    (void)F;
    link->status = mbsr_newton_linearise(link->newton, link->data, t, N_VGetArrayPointer(y),
                                         N_VGetArrayPointer(yp), cj);
    return link->status;
}

int mbsr_sundials_multiply(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, N_Vector v,
                           N_Vector Jv, sunrealtype cj, void *user, N_Vector work1, N_Vector work2)
{
    mbsr_sundials *link = user;
    (void)t;
    (void)y;
    (void)yp;
    (void)F;
    (void)cj;
    (void)work1;
    (void)work2;
    link->status =
        mbsr_newton_multiply(link->newton, N_VGetArrayPointer(v), N_VGetArrayPointer(Jv));
    return link->status;
}

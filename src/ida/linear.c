/* The linear systems of the Newton iterations: which solver, and how IDA calls it.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/linear.h"

#include "ida/shift.h"
#include "ida/callbacks.h"
#include "ida/error.h"
#include "ida/stiff.h"

#include <ida/ida_ls.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_dense.h>

/* ---- choice ---- */

/* Derivatives for dense matrices where difference quotients do not serve (differences.c), if there
 * are any without. */
static void take_tangent(mbsr_ida *ida)
{
    mbsr_newton_opt opt = ida->opt.newton;
    mbsr_newton_info info;
    opt.products = 1;
    if (ida->opt.form != MBSR_DAE_MOMENTUM || mbsr_model_rows(ida->model) > 0 ||
        mbsr_newton_create(ida->model, ida->opt.form, &opt, &ida->linear.tangent, NULL))
        return;
    if (mbsr_newton_get_info(ida->linear.tangent, &info) == MBSR_OK && info.exact) return;
    mbsr_newton_destroy(ida->linear.tangent);
    ida->linear.tangent = NULL;
}

/* The Newton solver, and AUTO decided. */
static int choose_solver(mbsr_ida *ida, mbsr_error *error)
{
    mbsr_ida_solver *solver = &ida->opt.linear_solver;
    if (*solver == MBSR_IDA_AUTO && ida->opt.form != MBSR_DAE_MOMENTUM) *solver = MBSR_IDA_DENSE;
    if (*solver == MBSR_IDA_DENSE) return MBSR_OK;
    mbsr_error reason;
    const int status = mbsr_newton_create(ida->model, ida->opt.form, &ida->opt.newton,
                                          &ida->linear.link.newton, &reason);
    if (status == MBSR_ERR_SPACE && *solver == MBSR_IDA_AUTO) {
        *solver = MBSR_IDA_DENSE;
        return MBSR_OK;
    }
    if (status && error) *error = reason;
    if (status || *solver != MBSR_IDA_AUTO) return status;
    mbsr_newton_info info;
    mbsr_newton_get_info(ida->linear.link.newton, &info);
    *solver = info.exact ? MBSR_IDA_TREE : MBSR_IDA_KRYLOV;
    return MBSR_OK;
}

/* Whether there are contacts, or other elements by pairs. */
static bool has_pairs(const mbsr_model *m)
{
    bool any = false;
    for (int k = 0; k < mbsr_model_forces(m); ++k) {
        mbsr_force_def def;
        any = any || (mbsr_force_definition(m, k, &def) == MBSR_OK &&
                      (def.table->flags & MBSR_FORCE_BY_PAIRS) != 0);
    }
    return any;
}

/* Bodies in vector code make a matrix cheap, blocks and force elements across the tree dear,
 * flexible bodies and many elements too dear to be made without need. Contacts make it take as long
 * as 15 residuals. */
void mbsri_ida_judge_matrix(const mbsr_ida *ida)
{
    enum { MANY = 8, SPACE = 6, KEPT = 5 };
    static const double share = 0.2, cheap = 0.05;
    mbsri_stiff *stiff = mbsri_stiff_of(ida->nonlinear);
    const int bodies = mbsr_model_bodies(ida->model);
    mbsr_newton_info info;
    int largest = 0;
    if (ida->opt.linear_solver != MBSR_IDA_TREE ||
        mbsr_newton_get_info(ida->linear.link.newton, &info))
        return;
    for (int i = 0; i < bodies; ++i) {
        const int dimension = mbsr_body_dimension(ida->model, i);
        if (dimension > largest) largest = dimension;
    }
    stiff->control.dear = info.across > MANY;
    stiff->control.matrices.kept = has_pairs(ida->model) ? KEPT : 0;
    if (!ida->opt.renew_matrices || stiff->control.dear || largest > SPACE) return;
    stiff->control.matrices.share = info.across == 0 && MANY * info.blocks < bodies ? cheap : share;
}

int mbsri_ida_make_solver(mbsr_ida *ida, mbsr_error *error)
{
    const int status = choose_solver(ida, error);
    if (status) return status;
    if (ida->opt.linear_solver == MBSR_IDA_DENSE) take_tangent(ida);
    switch (ida->opt.linear_solver) {
    case MBSR_IDA_TREE:
        ida->linear.matrix = mbsr_sundials_matrix(&ida->linear.link, ida->context);
        if (ida->linear.matrix)
            ida->linear.solver = mbsr_sundials_solver(&ida->linear.link, ida->context);
        break;
    case MBSR_IDA_KRYLOV:
        ida->linear.solver =
            SUNLinSol_SPGMR(ida->y, SUN_PREC_LEFT, ida->opt.krylov_size, ida->context);
        break;
    default:
        ida->linear.matrix = SUNDenseMatrix(ida->size, ida->size, ida->context);
        if (ida->linear.matrix)
            ida->linear.solver = SUNLinSol_Dense(ida->y, ida->linear.matrix, ida->context);
        break;
    }
    if (ida->linear.solver) return MBSR_OK;
    return mbsri_ida_refuse(error, MBSR_ERR_NO_MEMORY,
                            "mbsr_ida_create: no memory for the linear systems of size %d",
                            ida->size);
}

/* ---- as IDA calls it ---- */

/* After a factorisation or solution at t: its failure is noted as one of the residual is. */
static int noted(mbsr_ida *ida, sunrealtype t, const char *what)
{
    const int status = ida->linear.link.status;
    if (!status) return MBSR_OK;
    const mbsr_error *error = mbsr_newton_error(ida->linear.link.newton);
    return mbsri_ida_failed(ida, t, status, error, what);
}

static int jacobian(sunrealtype t, sunrealtype cj, N_Vector y, N_Vector yp, N_Vector r,
                    SUNMatrix matrix, void *user, N_Vector a, N_Vector b, N_Vector c)
{
    mbsri_ida_shift_back(user, t, &y, &yp);
    mbsr_sundials_jacobian(t, cj, y, yp, r, matrix, NULL, a, b, c);
    return noted(user, t, "Newton equations");
}

static int set_up(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, sunrealtype cj, void *user)
{
    mbsr_ida *ida = user;
    mbsri_ida_shift_back(ida, t, &y, &yp);
    mbsr_sundials_setup(t, y, yp, F, cj, &ida->linear.link);
    return noted(ida, t, "Newton equations");
}

static int precondition(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, N_Vector r, N_Vector z,
                        sunrealtype cj, sunrealtype delta, void *user)
{
    mbsr_ida *ida = user;
    mbsr_sundials_precondition(t, y, yp, F, r, z, cj, delta, &ida->linear.link);
    return noted(ida, t, "preconditioner");
}

static int linearise(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, sunrealtype cj, void *user)
{
    mbsr_ida *ida = user;
    mbsri_ida_shift_back(ida, t, &y, &yp);
    mbsr_sundials_linearise(t, y, yp, F, cj, &ida->linear.link);
    return noted(ida, t, "products");
}

static int multiply(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, N_Vector v, N_Vector Jv,
                    sunrealtype cj, void *user, N_Vector a, N_Vector b)
{
    mbsr_ida *ida = user;
    mbsr_sundials_multiply(t, y, yp, F, v, Jv, cj, &ida->linear.link, a, b);
    return noted(ida, t, "product");
}

int mbsri_ida_attach_solver(mbsr_ida *ida)
{
    void *const memory = ida->memory;
    int flag = IDASetLinearSolver(memory, ida->linear.solver, ida->linear.matrix);
    if (flag >= 0 && ida->opt.linear_solver == MBSR_IDA_TREE) flag = IDASetJacFn(memory, jacobian);
    if (flag < 0 || ida->opt.linear_solver != MBSR_IDA_KRYLOV) return flag;
    flag = IDASetPreconditioner(memory, set_up, precondition);
    if (flag >= 0 && ida->opt.newton.products) flag = IDASetJacTimes(memory, linearise, multiply);
    /* GMRES stops by the root of a sum of squares, and IDA allows it sqrt(n) for one of a mean; the
     * largest entry is never more than that root */
    return flag >= 0 && ida->opt.max_norm ? IDASetLSNormFactor(memory, 1.0) : flag;
}

/* ---- statistics ---- */

void mbsri_ida_count_solver(const mbsr_ida *ida, mbsr_newton_info *info)
{
    *info = (mbsr_newton_info){0};
    if (ida->linear.link.newton) mbsr_newton_get_info(ida->linear.link.newton, info);
}

const mbsr_newton *mbsr_ida_newton(const mbsr_ida *ida)
{
    return ida ? ida->linear.link.newton : NULL;
}

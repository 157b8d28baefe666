/* The reduced ODE (q, p) with SUNDIALS CVODE: two massless carts in a row, the last of three with
 * mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Each cart is on the one before it (relative coordinates), springs and dampers between them. The
 * two velocities without mass are found inside the right-hand side; CVODE sees an ordinary ODE. */
#include <mbsrank/mbsrank.h>

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#ifndef SUN_COMM_NULL /* SUNDIALS 6 */
#define SUN_COMM_NULL NULL
#endif

static void check(int status, const mbsr_error *error)
{
    if (status == MBSR_OK) return;
    fprintf(stderr, "%s: %s\n", mbsr_status_name(status), error->text);
    exit(1);
}

static mbsr_model *carts(void)
{
    mbsr_model *m;
    check(mbsr_model_create(NULL, &m, NULL), mbsr_model_error(NULL));
    for (int k = 0; k < 3; ++k) {
        mbsr_body_def cart = mbsr_default_body_def();
        cart.parent = k - 1;
        cart.joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
        cart.inertia = mbsr_inertia_particle(k < 2 ? 0.0 : 1.0);
        check(mbsr_model_add_body(m, &cart, NULL), mbsr_model_error(m));
        const mbsr_force_def spring = mbsr_force_axis_spring(k, k - 1, 0, 30.0, 3.0, 0.0);
        check(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* Statuses of the library have CVODE's signs: they go through as they are. */
static int rhs(sunrealtype t, N_Vector x, N_Vector xdot, void *ode)
{
    return mbsr_ode_rhs(ode, t, N_VGetArrayPointer(x), N_VGetArrayPointer(xdot));
}

int main(void)
{
    mbsr_model *m = carts();
    mbsr_data *d;
    mbsr_ode *ode;
    SUNContext context;
    check(mbsr_data_create(m, &d, NULL), mbsr_data_error(NULL));
    const double q[3] = {0.1, 0.1, 0.1}, u[3] = {0.0};
    check(mbsr_ode_create(m, d, 0.0, q, u, &ode), mbsr_data_error(d));
    if (SUNContext_Create(SUN_COMM_NULL, &context)) return 1;
    N_Vector x = N_VNew_Serial(mbsr_ode_size(ode), context);
    SUNMatrix A = SUNDenseMatrix(mbsr_ode_size(ode), mbsr_ode_size(ode), context);
    SUNLinearSolver solver = SUNLinSol_Dense(x, A, context);
    void *cvode = CVodeCreate(CV_BDF, context);
    check(mbsr_ode_pack(ode, 0.0, q, u, N_VGetArrayPointer(x)), mbsr_data_error(d));
    if (CVodeInit(cvode, rhs, 0.0, x) || CVodeSStolerances(cvode, 1e-9, 1e-9) ||
        CVodeSetUserData(cvode, ode) || CVodeSetLinearSolver(cvode, solver, A)) {
        return 1;
    }
    sunrealtype t = 0.0;
    if (CVode(cvode, 2.0, x, &t, CV_NORMAL) < 0) return 1;

    /* three equal springs and dampers in series on the mass: 10 N/m, 1 N s/m, started at 0.3 m */
    const double *state = N_VGetArrayPointer(x), w = sqrt(10.0 - 0.25);
    const double exact = 0.3 * exp(-0.5 * t) * (cos(w * t) + 0.5 / w * sin(w * t));
    const double found = state[0] + state[1] + state[2];
    long steps = 0;
    CVodeGetNumSteps(cvode, &steps);
    printf("mass at t = %g: %.8f m, exact %.8f m, %ld steps\n", (double)t, found, exact, steps);

    CVodeFree(&cvode);
    SUNLinSolFree(solver);
    SUNMatDestroy(A);
    N_VDestroy(x);
    SUNContext_Free(&context);
    mbsr_ode_destroy(ode);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return fabs(found - exact) < 1e-7 ? 0 : 1;
}

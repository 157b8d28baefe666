/* The model of an instance, its start and its evaluation.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_SOLVE_H
#define MBSRI_FMU_SOLVE_H

#include "fmu/instance.h"

/* The model as parameters are, with data; and away with the data and all that solves it. */
mbsri_result mbsri_make_model(mbsri_instance *in);
void mbsri_drop_model(mbsri_instance *in);

/* The consistent state near q0, u0 at t_start: y, yp, q, u. */
mbsri_result mbsri_find_start(mbsri_instance *in);

/* What steps or differentiates, at the state: the driver, the stepper or the ODE. */
mbsri_result mbsri_make_solver(mbsri_instance *in);

/* in->solver.stepper, at the state in y and yp. */
mbsri_result mbsri_make_stepper(mbsri_instance *in, const mbsr_stepper_opt *opt);

/* The data at the accelerations of the state, udot, lambda. */
mbsri_result mbsri_evaluate(mbsri_instance *in);

#endif

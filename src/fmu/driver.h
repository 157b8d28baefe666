/* Co-simulation with steps by the error, which IDA takes. In sets of sources (SourceSet.cmake)
 * own_driver.c has these functions, without IDA: in->solver.stepper stands for in->solver.ida.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_DRIVER_H
#define MBSRI_FMU_DRIVER_H

#include "fmu/instance.h"

/* in->solver.ida, from the state in y and yp at t; and away with it, where there is one. */
mbsri_result mbsri_make_driver(mbsri_instance *in);
void mbsri_drop_driver(mbsri_instance *in);

/* Its state into y and yp; its motion into q, u, udot, lambda. A status, with the text of it. */
int mbsri_driver_state(mbsri_instance *in, const mbsr_error **error);
int mbsri_driver_motion(mbsri_instance *in, const mbsr_error **error);

/* As mbsri_step. */
mbsri_result mbsri_drive(mbsri_instance *in, double t_end, bool *event);

#endif

/* The linear solver of the driver.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_LINEAR_H
#define MBSRI_IDA_LINEAR_H

#include "ida/record.h"

/* Decides on the linear solver and makes it; hands it to IDA (an IDA flag). */
int mbsri_ida_make_solver(mbsr_ida *ida, mbsr_error *error);
int mbsri_ida_attach_solver(mbsr_ida *ida);

/* What a matrix costs, for when the next is made. */
void mbsri_ida_judge_matrix(const mbsr_ida *ida);

/* What the Newton solver has counted; zero where there is none. */
void mbsri_ida_count_solver(const mbsr_ida *ida, mbsr_newton_info *info);

#endif

/* Error texts of the driver.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_ERROR_H
#define MBSRI_IDA_ERROR_H

#include "base/format.h"
#include "ida/record.h"

/* Writes *error (if not NULL) and returns status; refuse: without body and force element; pass_on:
 * with those and the text of `why` behind what is said here. */
int mbsri_ida_fail(mbsr_error *error, int status, int body, int force, const char *format, ...)
    MBSRI_FORMAT(5, 6);
int mbsri_ida_refuse(mbsr_error *error, int status, const char *format, ...) MBSRI_FORMAT(3, 4);
int mbsri_ida_pass_on(mbsr_error *error, int status, const mbsr_error *why, const char *format, ...)
    MBSRI_FORMAT(4, 5);

/* Writes the numbers of a message of IDA, which follow the locale, with a point. */
void mbsri_ida_point_numbers(char *message);

/* MBSR_ERR_SOLVER, or MBSR_ERR_NO_MEMORY for IDA_MEM_FAIL; the text has the name of IDA's flag and
 * its message. */
int mbsri_ida_solver_failed(const mbsr_ida *ida, mbsr_error *error, int flag, const char *function);

#endif

/* Error texts of the component.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_ERROR_H
#define MBSRI_FMU_ERROR_H

#include "base/format.h"

#include <mbsrank/base.h>

/* Writes *error (if not NULL) and returns status. */
int mbsri_fmu_fail(mbsr_error *error, int status, const char *format, ...) MBSRI_FORMAT(3, 4);

/* snprintf whose numbers have a point in every locale. */
int mbsri_fmu_print(char *text, size_t size, const char *format, ...) MBSRI_FORMAT(3, 4);

#endif

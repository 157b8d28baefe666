/* Error texts: every refusal goes through mbsri_fail.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ERROR_H
#define MBSRI_ERROR_H

#include "base/format.h"

#include <mbsrank/base.h>

/* Writes *error (if not NULL) and returns status. */
int mbsri_fail(mbsr_error *error, int status, int body, int force, const char *format, ...)
    MBSRI_FORMAT(5, 6);

/* The same, of no body and no force element. */
int mbsri_fail_plain(mbsr_error *error, int status, const char *format, ...) MBSRI_FORMAT(3, 4);

/* snprintf whose numbers have a point in every locale. */
int mbsri_print(char *text, size_t size, const char *format, ...) MBSRI_FORMAT(3, 4);

/* "body 3 'rod'" into a buffer of MBSRI_LABEL; returns the buffer. */
enum { MBSRI_LABEL = 80 };
const char *mbsri_label(char *buffer, const char *kind, int id, const char *name);

#endif

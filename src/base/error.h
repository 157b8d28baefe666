/* Error texts: every refusal goes through mbsri_fail.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ERROR_H
#define MBSRI_ERROR_H

#include <mbsrank/base.h>

#if defined(__GNUC__)
#define MBSRI_FORMAT(a, b) __attribute__((format(printf, a, b)))
#else
#define MBSRI_FORMAT(a, b)
#endif

/* Writes *error (if not NULL) and returns status. */
int mbsri_fail(mbsr_error *error, int status, int body, int force, const char *format, ...)
    MBSRI_FORMAT(5, 6);

/* "body 3 'rod'" into a buffer of MBSRI_LABEL; returns the buffer. */
enum { MBSRI_LABEL = 80 };
const char *mbsri_label(char *buffer, const char *kind, int id, const char *name);

#endif

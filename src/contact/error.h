/* Error texts of the component.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CONTACT_ERROR_H
#define MBSRI_CONTACT_ERROR_H

#include "base/format.h"

#include <mbsrank/base.h>

/* Writes a text, as far as there is room for it. */
void mbsri_contact_print(char *text, size_t size, const char *format, ...) MBSRI_FORMAT(3, 4);

/* The same to an error, which may be NULL; returns status. */
int mbsri_contact_fail(mbsr_error *error, int status, const char *format, ...) MBSRI_FORMAT(3, 4);

#endif

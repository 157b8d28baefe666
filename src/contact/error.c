/* Error texts of the component: see error.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "contact/error.h"

void mbsri_contact_print(char *text, size_t size, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)mbsri_vprint(text, size, format, arguments);
    va_end(arguments);
}

int mbsri_contact_fail(mbsr_error *error, int status, const char *format, ...)
{
    if (!error) return status;
    *error = (mbsr_error){.status = status, .body = MBSR_NONE, .force = MBSR_NONE};
    va_list arguments;
    va_start(arguments, format);
    (void)mbsri_vprint(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    return status;
}

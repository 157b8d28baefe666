/* Error texts of the component: see error.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/error.h"

int mbsri_fmu_fail(mbsr_error *error, int status, const char *format, ...)
{
    if (!error) return status;
    *error = (mbsr_error){.status = status, .body = MBSR_NONE, .force = MBSR_NONE};
    va_list arguments;
    va_start(arguments, format);
    mbsri_vprint(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    return status;
}

int mbsri_fmu_print(char *text, size_t size, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = mbsri_vprint(text, size, format, arguments);
    va_end(arguments);
    return length;
}

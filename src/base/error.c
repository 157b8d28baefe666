/* Error texts and labels.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>

int mbsri_fail(mbsr_error *error, int status, int body, int force, const char *format, ...)
{
    if (!error) return status;
    error->status = status;
    error->body = body;
    error->force = force;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    return status;
}

const char *mbsri_label(char *buffer, const char *kind, int id, const char *name)
{
    if (name && name[0]) {
        snprintf(buffer, MBSRI_LABEL, "%s %d '%s'", kind, id, name);
    } else {
        snprintf(buffer, MBSRI_LABEL, "%s %d", kind, id);
    }
    return buffer;
}

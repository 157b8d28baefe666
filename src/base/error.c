/* Error texts and labels.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/error.h"

static void write_error(mbsr_error *error, int status, int body, int force, const char *format,
                        va_list arguments)
{
    if (!error) return;
    error->status = status;
    error->body = body;
    error->force = force;
    mbsri_vprint(error->text, sizeof error->text, format, arguments);
}

int mbsri_fail(mbsr_error *error, int status, int body, int force, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    write_error(error, status, body, force, format, arguments);
    va_end(arguments);
    return status;
}

int mbsri_fail_plain(mbsr_error *error, int status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    write_error(error, status, MBSR_NONE, MBSR_NONE, format, arguments);
    va_end(arguments);
    return status;
}

int mbsri_print(char *text, size_t size, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = mbsri_vprint(text, size, format, arguments);
    va_end(arguments);
    return length;
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

/* Error texts of the driver.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int mbsri_ida_fail(mbsr_error *error, int status, int body, int force, const char *format, ...)
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

/* Name of an IDA flag into a buffer of FLAG; returns the buffer. IDA allocates it. */
enum { FLAG = 32 };
static const char *flag_name(int flag, char *buffer)
{
    char *name = IDAGetReturnFlagName(flag);
    buffer[0] = '\0';
    if (name) strncat(buffer, name, FLAG - 1);
    free(name);
    return buffer;
}

int mbsri_ida_solver_failed(const mbsr_ida *ida, mbsr_error *error, int flag, const char *function)
{
    char name[FLAG];
    const int status = flag == IDA_MEM_FAIL ? MBSR_ERR_NO_MEMORY : MBSR_ERR_SOLVER;
    return mbsri_ida_fail(error, status, MBSR_NONE, MBSR_NONE, "%s: %s: %s", function,
                          flag_name(flag, name), ida->message);
}

const mbsr_error *mbsr_ida_error(const mbsr_ida *ida)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the driver is NULL"};
    return ida ? &ida->error : &none;
}

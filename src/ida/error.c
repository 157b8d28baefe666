/* Error texts of the driver.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "driver.h"

#include <stdarg.h>
#include <stdio.h>

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

int mbsri_ida_solver_failed(const mbsr_ida *ida, mbsr_error *error, int flag, const char *function)
{
    char name[MBSRI_IDA_FLAG];
    const int status = flag == IDA_MEM_FAIL ? MBSR_ERR_NO_MEMORY : MBSR_ERR_SOLVER;
    return mbsri_ida_fail(error, status, MBSR_NONE, MBSR_NONE, "%s: %s: %s", function,
                          mbsri_ida_flag_name(flag, name), ida->message);
}

const mbsr_error *mbsr_ida_error(const mbsr_ida *ida)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the driver is NULL"};
    return ida ? &ida->error : &none;
}

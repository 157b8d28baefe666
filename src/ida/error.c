/* Error texts of the driver.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/error.h"

#include <stdlib.h>
#include <string.h>

static int write(mbsr_error *error, int status, int body, int force, const char *format,
                 va_list arguments)
{
    if (!error) return status;
    error->status = status;
    error->body = body;
    error->force = force;
    mbsri_vprint(error->text, sizeof error->text, format, arguments);
    return status;
}

int mbsri_ida_fail(mbsr_error *error, int status, int body, int force, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    write(error, status, body, force, format, arguments);
    va_end(arguments);
    return status;
}

int mbsri_ida_refuse(mbsr_error *error, int status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    write(error, status, MBSR_NONE, MBSR_NONE, format, arguments);
    va_end(arguments);
    return status;
}

int mbsri_ida_pass_on(mbsr_error *error, int status, const mbsr_error *why, const char *format, ...)
{
    mbsr_error said;
    va_list arguments;
    va_start(arguments, format);
    write(&said, status, why->body, why->force, format, arguments);
    va_end(arguments);
    return mbsri_ida_fail(error, status, said.body, said.force, "%s: %s", said.text, why->text);
}

static bool digit(char c)
{
    return c >= '0' && c <= '9';
}

/* What stands between the digits of 0.5 in this locale, between two digits of the message. */
void mbsri_ida_point_numbers(char *message)
{
    char half[16] = "";
    snprintf(half, sizeof half, "%.1f", 0.5);
    const size_t length = strlen(half) > 2 ? strlen(half) - 2 : 0;
    if (length == 0 || (length == 1 && half[1] == '.')) return;
    char *to = message;
    for (const char *from = message; *from; ++to) {
        const bool found = to > message && digit(to[-1]) && strncmp(from, half + 1, length) == 0 &&
                           digit(from[length]);
        *to = found ? '.' : *from;
        from += found ? length : 1;
    }
    *to = '\0';
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

/* What a flag says, and what to do. */
static const char *flag_words(int flag)
{
    switch (flag) {
    case IDA_TOO_MUCH_WORK:
        return "max_steps steps ended before the time: call again, or allow more";
    case IDA_TOO_MUCH_ACC:
        return "the tolerances ask for more than rounding leaves: larger rtol or atol";
    case IDA_ERR_FAIL:
        return "no step is short enough for the tolerances: something jumps, or they are too tight";
    case IDA_CONV_FAIL:
        return "Newton's method fails with the shortest steps: something jumps, or a derivative is "
               "wrong";
    case IDA_LSETUP_FAIL: return "the Newton matrix has no factors";
    case IDA_LSOLVE_FAIL: return "the linear systems cannot be solved";
    case IDA_RES_FAIL:
    case IDA_FIRST_RES_FAIL: return "the residual cannot be evaluated";
    case IDA_REP_RES_ERR: return "the residual cannot be evaluated near the state reached";
    case IDA_RTFUNC_FAIL: return "an event function failed";
    case IDA_BAD_EWT: return "a tolerance has become zero: atol must be positive";
    case IDA_MEM_FAIL: return "no memory";
    default: return NULL;
    }
}

int mbsri_ida_solver_failed(const mbsr_ida *ida, mbsr_error *error, int flag, const char *function)
{
    char name[FLAG];
    const int status = flag == IDA_MEM_FAIL ? MBSR_ERR_NO_MEMORY : MBSR_ERR_SOLVER;
    const char *words = flag_words(flag);
    return mbsri_ida_refuse(error, status, "%s: %s: %s%s%s", function, flag_name(flag, name),
                            words ? words : "", words && ida->failing.message[0] ? "; " : "",
                            ida->failing.message);
}

const mbsr_error *mbsr_ida_error(const mbsr_ida *ida)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the driver is NULL"};
    return ida ? &ida->error : &none;
}

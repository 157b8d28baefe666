/* Status names, version, error texts.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#define MBSRI_STRING_(x) #x
#define MBSRI_STRING(x) MBSRI_STRING_(x)

const char *mbsr_status_name(int status)
{
    switch (status) {
#define MBSRI_CASE(name, value, text)                                                              \
    case value: return #name;
        MBSR_STATUS_MAP(MBSRI_CASE)
#undef MBSRI_CASE
    default: return "callback status";
    }
}

const char *mbsr_status_text(int status)
{
    switch (status) {
#define MBSRI_CASE(name, value, text)                                                              \
    case value: return text;
        MBSR_STATUS_MAP(MBSRI_CASE)
#undef MBSRI_CASE
    default: return "a callback returned this status";
    }
}

const char *mbsr_version(void)
{
    return MBSRI_STRING(MBSR_VERSION_MAJOR) "." MBSRI_STRING(MBSR_VERSION_MINOR) "." MBSRI_STRING(
        MBSR_VERSION_PATCH);
}

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

bool mbsri_finite(size_t n, const double *x)
{
    /* 0 x is 0 for finite x and NaN for others; four sums at a time do not wait for each other */
    double sum[4] = {0.0};
    size_t k = 0;
    for (; k + 4 <= n; k += 4) {
        for (size_t l = 0; l < 4; ++l) sum[l] += 0.0 * x[k + l];
    }
    for (; k < n; ++k) sum[0] += 0.0 * x[k];
    return sum[0] + sum[1] + sum[2] + sum[3] == 0.0;
}

double mbsri_largest(int n, const double *x)
{
    double value = 0.0;
    for (int k = 0; k < n; ++k) value = fmax(value, fabs(x[k]));
    return value;
}

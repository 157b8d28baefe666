/* Status names and texts, version.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/base.h>

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

/* How the functions of FMI 3.0 begin.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMI3_ENTER_H
#define MBSRI_FMI3_ENTER_H

#include "fmu/fmi3_functions.h"
#include "fmu/instance.h"

enum {
    ASKED = MBSRI_INITIALIZATION | MBSRI_INITIALIZED | MBSRI_TERMINATED,
    ALWAYS = ASKED | MBSRI_INSTANTIATED,
    RUNNING = MBSRI_INSTANTIATED | MBSRI_INITIALIZATION | MBSRI_INITIALIZED,
    EVENTS = MBSRI_EVENT_MODE | MBSRI_CONTINUOUS
};

/* The instance, where the function may be called; else returns. */
#define ENTER(modes)                                                                               \
    mbsri_instance *in = c;                                                                        \
    if (!in || !mbsri_allowed(in, (modes), __func__)) return fmi3Error

/* The same for functions of model exchange, or of co-simulation. */
#define ENTER_OF(is_exchange, modes)                                                               \
    ENTER(modes);                                                                                  \
    if (in->exchange != (is_exchange))                                                             \
    return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: the instance is of %s", __func__,           \
                                 in->exchange ? "model exchange" : "co-simulation")

static inline fmi3Status wrong_count(mbsri_instance *in, const char *function)
{
    return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: numbers of values do not fit each other",
                                 function);
}

#endif

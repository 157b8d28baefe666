/* How functions of FMI begin. FMI_STATUS and FMI_ERROR: a version's type of a status, its error.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_ENTER_H
#define MBSRI_FMU_ENTER_H

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
    if (!in || !mbsri_allowed(in, (modes), __func__)) return FMI_ERROR

/* The same for functions of model exchange, or of co-simulation. */
#define ENTER_OF(is_exchange, modes)                                                               \
    ENTER(modes);                                                                                  \
    if (in->exchange != (is_exchange))                                                             \
    return (FMI_STATUS)mbsri_say(in, MBSRI_ERROR, "%s: the instance is of %s", __func__,           \
                                 in->exchange ? "model exchange" : "co-simulation")

#endif

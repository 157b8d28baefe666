/* How functions of FMI begin. FMI_ERROR: the status of an error, of a version.
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
#define ENTER(modes) ENTER_OF(MBSRI_EITHER, modes)

/* The same for functions of model exchange, or of co-simulation. */
#define ENTER_OF(is_exchange, modes)                                                               \
    mbsri_instance *in = mbsri_entered(c, (is_exchange), (modes), __func__);                       \
    if (!in) return FMI_ERROR

#endif

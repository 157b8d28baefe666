/* How the functions of FMI 3.0 begin.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMI3_ENTER_H
#define MBSRI_FMI3_ENTER_H

#include "fmu/fmi3_functions.h"
#include "fmu/instance.h"

#define FMI_ERROR fmi3Error
#include "fmu/enter.h"

static inline fmi3Status wrong_count(mbsri_instance *in, const char *function)
{
    return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: numbers of values do not fit each other",
                                 function);
}

#endif

/* Event functions of an instance: what model exchange hands out, and the driver watches.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_INDICATORS_H
#define MBSRI_FMU_INDICATORS_H

#include "fmu/instance.h"

/* Event functions at q, u in data of the model: distances to stops, depths of contacts. */
int mbsri_indicate(mbsri_instance *in, mbsr_data *data, double t, const double *q, const double *u,
                   double *value);

#endif

/* A consistent start by Newton systems: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_START_H
#define MBSRI_START_H

#include "massless/start_systems.h"

/* From s->q_given and s->u_given to a state in w->y, with u' and q', p' in w->rate and loop forces
 * in w->yp. Statuses of mbsr_dae_consistent, reported in w->error. *clear: whether it is beyond
 * doubt that forces determine all directions without mass. */
int mbsri_start_find(mbsri_start *s, mbsr_data *d, double t, bool *clear);

#endif

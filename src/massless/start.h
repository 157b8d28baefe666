/* A consistent start by Newton systems: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_START_H
#define MBSRI_START_H

#include "massless/start_systems.h"

/* A consistent state in w->y (size) near s->q_given (nq), s->u_given (nu), its q', p', u' in
 * w->rate and its loop forces in w->yp. Statuses of mbsr_dae_consistent, reported in w->error.
 * *clear: whether forces determine all directions without mass beyond doubt. */
int mbsri_start_find(mbsri_start *s, mbsr_data *d, double t, bool *clear);

#endif

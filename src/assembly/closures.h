/* Closures of a model that is being finished.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ASSEMBLY_CLOSURES_H
#define MBSRI_ASSEMBLY_CLOSURES_H

#include "model/record.h"

/* Their bodies by index, checks, places of their rows; once the bodies and their coordinates are
 * numbered. */
int mbsri_closures_resolve(mbsr_model *m, int N);

/* Takes away those that springs have become: they come back with the next attempt. */
void mbsri_closures_forget(mbsr_model *m);

#endif

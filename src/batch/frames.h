/* Frames of the bodies of a batch.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BATCH_FRAMES_H
#define MBSRI_BATCH_FRAMES_H

#include "batch/record.h"

/* The constants of `from` in its own frame, and how that stands on that of `parent`. */
void mbsri_batch_take(const mbsri_sweep_body *from, int parent, mbsri_batch_body *b);

/* Turns the frames of all bodies about their z axes, as record.h says. */
void mbsri_batch_align(int bodies, mbsri_batch_body *body);

#endif

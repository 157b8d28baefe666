/* The motion of a mode as a run, which the viewer shows.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_MODE_MOTION_H
#define MBSRANK_MODE_MOTION_H

#include "program/program.h"

#include <mbsrank/linear.h>

/* One period about rest (nq) without its decay, or a decay down to 5 %, in 60 steps: the largest
 * turn is 0.2 rad, or the largest way a tenth of the model. re, im: the shape. To the file, as a
 * run. A code. */
int mode_motion_write(const program_model *p, const double *rest, const mbsr_mode *mode,
                      const double *re, const double *im, const char *path);

#endif

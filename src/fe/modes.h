/* Normal modes, by Lanczos' method in blocks.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_MODES_H
#define MBSRI_FE_MODES_H

#include "fe/statics.h"

enum { MBSRI_FE_BLOCK = 8 };

typedef struct mbsri_fe_modes {
    int count;
    double *U;     /* n x count, by frequency, of mass 1, seen as `L` of mbsri_fe_find_modes says */
    double *omega; /* count */
} mbsri_fe_modes;

/* The lowest modes of the body held (L = C) or free (L = relief), as many as def says. */
int mbsri_fe_find_modes(mbsri_fe_statics *statics, const double *L, mbsri_fe_modes *modes);

/* Tells def->progress; what that returns. */
int mbsri_fe_tell(const mbsri_fe_body *body, const char *stage, double done);

#endif

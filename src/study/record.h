/* What a study has beside its public struct.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_STUDY_RECORD_H
#define MBSRI_STUDY_RECORD_H

#include "files/arena.h"

#include <mbsrank/study.h>

typedef struct mbsr_study_sample {
    mbsri_arena arena;
    double *listed;  /* of a list: runs x parameters */
    uint32_t *order; /* of a Latin hypercube: parameters x runs, a permutation each */
    uint32_t *v;     /* of Sobol': parameters x MBSRI_SOBOL_BITS */
} mbsr_study_sample;

/* Makes what the sampling of a study that has been read needs; false: no memory. */
int mbsri_study_prepare(const mbsr_study *study, mbsr_study_sample *sample);

#endif

/* Modal data of flexible bodies, as they are kept.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FLEX_DATA_H
#define MBSRI_FLEX_DATA_H

#include <mbsrank/flex.h>

/* The arrays stand in one piece of memory; those of a body without modes are of length zero. */
struct mbsr_flex {
    mbsr_allocator allocator;
    int n, markers;
    double mass, c0[3], N0[9];
    double *Ct0, *P0, *P, *Mf, *K, *D; /* as in mbsr_flex_def */
    mbsr_flex_marker *marker;          /* Phi and Psi are not NULL */
};

#endif

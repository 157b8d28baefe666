/* Modes of a beam's finite elements.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BEAM_MODES_H
#define MBSRI_BEAM_MODES_H

#include "flexible/data.h"

enum { MBSRI_BEAM_NODE = 6 };

/* Dofs of node k: u, v, w, rotations about x, y, z; those that deform count, without the root's. */
typedef struct mbsri_beam {
    const mbsr_beam_def *def;
    int dofs, free; /* all: 6 (elements + 1) */
    int *dof;       /* free: which they are */
    double *K, *M;  /* free x free */
    int modes, most;
    double *mode;        /* dofs x most, with zeros where the beam does not deform */
    double *flexibility; /* 1 / omega^2 of each, with K = 1 */
    int normal;          /* how many of them are normal modes */
    double *work;        /* scratch of beam_modes.c */
} mbsri_beam;

/* Doubles of work for `free` dofs and `loads` load cases. */
size_t mbsri_beam_work(int free, int loads);

/* mode, flexibility, modes and normal from K and M. MBSR_ERR_VALUE: K is not positive definite;
 * MBSR_ERR_NUMERICS. */
int mbsri_beam_find_modes(mbsri_beam *b);

#endif

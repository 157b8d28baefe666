/* Finite elements of a beam, and their modes.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BEAM_H
#define MBSRI_BEAM_H

#include "flexible/flex.h"

enum { MBSRI_BEAM_NODE = 6, MBSRI_BEAM_POINTS = 5, MBSRI_BEAM_ELEMENTS = 40 };

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
    double *work;        /* of beam_modes.c */
} mbsri_beam;

/* A point of quadrature in element e: weight (m), x (m), and displacement and rotation there in terms of the
 * 12 dofs of the element. */
typedef struct mbsri_beam_point {
    double weight, x;
    double shift[3][12], turn[3][12];
} mbsri_beam_point;

void mbsri_beam_point_of(const mbsr_beam_def *def, int e, int k, mbsri_beam_point *point);

/* Doubles of work for `free` dofs and `loads` load cases. */
size_t mbsri_beam_work(int free, int loads);

/* mode, flexibility, modes and normal from K and M. MBSR_ERR_VALUE: K is not positive definite;
 * MBSR_EIGEN_FAILED. */
int mbsri_beam_find_modes(mbsri_beam *b);

#endif

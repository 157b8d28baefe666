/* What a SID file holds, and modal data of it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_SID_H
#define MBSRI_FE_SID_H

#include "fe/lines.h"
#include "files/arena.h"

#include <mbsrank/sid.h>

/* A Taylor expansion m0 + sum_k m1_k q_k of a matrix. */
typedef struct mbsri_taylor {
    bool there;
    int rows, columns;
    double *m0; /* rows x columns, column-major */
    double *m1; /* by mode: rows x columns each; NULL: not wanted or not there */
    bool more;  /* whether m1 is there and not zero */
} mbsri_taylor;

/* The matrices of a file: X(name, shape: rows, columns, whether m1 is wanted, whether it must be
 * there); n: modes. */
#define MBSRI_SID_BLOCKS(X)                                                                        \
    X(mdCM, 3, 1, true, true)                                                                      \
    X(J, 6, 1, true, true)                                                                         \
    X(Ct, n, 3, false, true)                                                                       \
    X(Cr, n, 3, true, true)                                                                        \
    X(Me, n, n, false, true)                                                                       \
    X(Gr, 3, 3 * n, false, false)                                                                  \
    X(Ge, n, 3 * n, false, false)                                                                  \
    X(Oe, n, 6, true, false)                                                                       \
    X(ksigma, n, 1, false, false)                                                                  \
    X(Ke, n, n, false, true)                                                                       \
    X(De, n, n, false, false)

typedef struct mbsri_sid_node {
    int id;
    mbsri_taylor origin, phi, psi, AP;
} mbsri_sid_node;

typedef struct mbsri_sid {
    int modes;
    double mass;
    const char **name; /* modes */
#define MBSRI_SID_MEMBER(name, rows, columns, first, must) mbsri_taylor name;
    MBSRI_SID_BLOCKS(MBSRI_SID_MEMBER)
#undef MBSRI_SID_MEMBER
    mbsri_list nodes; /* mbsri_sid_node */
} mbsri_sid;

/* Parses a text; MBSR_ERR_NO_MEMORY is without an error text. */
int mbsri_sid_parse(mbsri_arena *arena, mbsri_lines *lines, mbsri_sid *sid);

/* Integrals, of modes n: mbsr_flex_def has them. */
typedef struct mbsri_sid_integrals {
    int n;
    double mass, c0[3], N0[9];
    double *Ct0, *P0, *P, *Mf; /* 3 n, 9 n, 9 n n, n n */
} mbsri_sid_integrals;

/* Tries whether these are integrals of a body, and makes them so as far as `change` allows. Writes
 * keep_coupling, keep_strain, keep_rest and changed_P of the report, of which it reads definite. */
int mbsri_sid_fit(mbsri_arena *arena, mbsr_sid_change change, mbsri_sid_integrals *s,
                  mbsr_sid_report *report, mbsr_error *error);

#endif

/* The model that is reduced: matrices, nodes, dofs, markers, rigid motions.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_BODY_H
#define MBSRI_FE_BODY_H

#include "fe/sparse.h"

/* A marker: its motion is C^T u, six numbers, rotation first; loads are C f. */
typedef struct mbsri_fe_marker {
    int nodes, *node; /* nodes of the marker, by index in def->x */
    int turns;        /* whether its rotation is that of a node or of a set; 0: it has none */
    double x[3];      /* seen from the root */
    double S[9];      /* inverse of S of a set, mbsr_fe_marker */
} mbsri_fe_marker;

typedef struct mbsri_fe_body {
    const mbsr_fe_def *def;
    mbsri_arena *arena;
    mbsr_error *error;
    int n, nodes;
    mbsri_sparse K, M, D;  /* D.n = 0: none */
    int *node, *direction; /* node, by index, and direction of each dof */
    int *dof;              /* 6 x nodes; -1: none */
    double *x;             /* 3 x nodes, seen from the root */
    double *T;             /* n x 6: rotations about the root, displacements */
    int markers;
    mbsri_fe_marker *marker;
    double rigid; /* largest |K T| beside |K| |T| */
} mbsri_fe_body;

#define MBSRI_FE_REFUSE(...)                                                                       \
    mbsri_fe_fail(body->error, MBSR_ERR_VALUE, "mbsr_fe_reduce: " __VA_ARGS__)

/* Everything but the options of def, checked. */
int mbsri_fe_body_make(mbsri_fe_body *body);

/* motion (6) = C^T u */
void mbsri_fe_motion(const mbsri_fe_body *body, int marker, const double *u, double motion[6]);

/* f (n) += C load (6) */
void mbsri_fe_load(const mbsri_fe_body *body, int marker, const double load[6], double *f);

/* "dof 12 (node 5, direction 1)" into a buffer of MBSRI_FE_LABEL; returns the buffer. */
enum { MBSRI_FE_LABEL = 80 };
const char *mbsri_fe_label(const mbsri_fe_body *body, int dof, char *buffer);

#endif

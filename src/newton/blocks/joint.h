/* One joint, or a group of joints, while its equations are made and eliminated (factor.c, coupled.c).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BLOCK_JOINT_H
#define MBSRI_BLOCK_JOINT_H

#include "newton/blocks/record.h"
#include "newton/slopes/joint_slopes.h"

/* A joint while its block is made, or a group of joints. */
typedef struct mbsri_block_joint {
    mbsr_newton *w;
    mbsr_data *d;
    const mbsri_body *b;
    const mbsri_node *node, *above;
    mbsri_kept kept;
    int i;
    int motions, actions, motions_pred, actions_pred; /* lengths of x, y, x_pi, y_pi */
    int columns, q, u, a;                             /* of z, and where its parts begin */
    int n, nq;                                        /* its u, its q; of a group: of all joints */
    double *P;
    double *action;         /* actions x columns: y = P x + action z of force elements */
    double *below;          /* actions_pred x columns: y_pi */
    double *reaction;       /* n x columns: d(J^T mu - tau) */
    double *torque;         /* n x columns: dtau */
    double *torque_x;       /* n x motions: likewise, along x */
    double *pull;           /* d_pred x motions: f of the predecessor along x */
    double *pull_z;         /* d_pred x columns */
    double *y;              /* actions */
    double *size, *size_mu; /* n: what is added up in the rows of (a) and of (b) */
    double *size_a;         /* n: likewise, in the columns of du' of (b) */
    bool elements;          /* action, torque, pull are not all zero */
} mbsri_block_joint;

/* What a text of MBSR_SINGULAR_BLOCK says of a joint. */
#define MBSRI_SINGULAR_ADVICE                                                                      \
    "nothing determines its rates: give it inertia, a spring or a damper, or lock it "             \
    "(mbsr_index_report_create names all such directions)"

/* The matrix P of body i, mbsri_actions rows by mbsri_motions columns. */
double *mbsri_tree_matrix(const mbsr_newton *w, int i);

/* The joint of body i: its arrays in `memory`, what of the data solving needs, and what mass and
 * force elements give; a status. How much memory it takes. */
int mbsri_block_begin(mbsr_newton *w, mbsr_data *d, int i, double *memory, mbsri_block_joint *j);
size_t mbsri_block_size(const mbsr_newton *w, int i);

/* Column of z -> column of the joint's derivatives, which always have those of A. */
static inline int mbsri_block_source(const mbsri_block_joint *j, const mbsri_joint_slopes *s, int k)
{
    return k < j->q ? k : s->q + k - j->q;
}

/* Adds what is added up in the rows of the joint in one column to size, size_mu, size_a: y and own of
 * that column; `kind` says of which unknown it is. */
typedef enum mbsri_column_kind { MBSRI_COLUMN_Q, MBSRI_COLUMN_U, MBSRI_COLUMN_A } mbsri_column_kind;
void mbsri_block_measure(mbsri_block_joint *j, double c, mbsri_column_kind kind, const double *y,
                         const double *own, const double *torque);

/* Cq = (c - d(G u)/dq)^-1, Q = Cq G of the joint, both nq rows; false: singular. A, rows, columns,
 * pivots: scratch. */
bool mbsri_block_coordinates(const mbsri_body *b, double c, const mbsri_joint_slopes *s, double *Cq,
                             double *Q, double *A, double *rows, double *columns, int *pivots);

/* The rest, when all columns are there: the unknowns eliminated, the predecessor's matrix completed;
 * with the texts of what fails. */
int mbsri_block_finish(mbsri_block_joint *j, double c);

/* The unit of du' as an unknown, in which it weighs as much in (b) as du. Where accelerations are
 * large, as those of light bodies, (b) would else look singular to the rounding errors of dq and
 * du. */
double mbsri_block_unit(const mbsri_block_joint *j);

/* MBSR_SINGULAR_BLOCK and MBSR_NOT_FINITE of a joint. */
int mbsri_block_singular(mbsri_block_joint *j, const char *what, const char *advice);
int mbsri_block_not_finite(mbsri_block_joint *j);

#endif

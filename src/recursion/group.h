/* Groups: joints next to each other that the recursion eliminates as one block.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The recursion is a factorisation of the mass matrix, L^T D L by blocks. With a block a joint it
 * is not a continuous one where bodies without mass hang on each other: behind prismatic y and z,
 * the mass of a rod that turns about x makes D of y and D of z singular in turn, while D of both
 * keeps its rank. So joints like these are one block (assembly/groups.c says which): the group
 * counts as a body whose joint has the freedoms of all of them. For its head r, the member that all
 * others hang on, and with the inertias C of what no joint of the group takes away,
 *
 *   C_i = M_i + sum of H_j^T C_j H_j (members) + sum of H_j^T Mbar^a_j H_j (others)
 *   F_b = C_b J_b,  F_pi(i) = -H_i^T F_i up to the head;    D_ab = J_a^T F_b,  U = F at the head
 *
 * U and D are what the recursion needs of a joint, and Mbar_r = C_r; for a group of one they are
 * Mbar J and J^T Mbar J. Vectors over the rates of a group (e, s, X, ...) have them in the order of
 * its members; mbsri_body.group.iu is where a joint begins there. */
#ifndef MBSRI_GROUP_H
#define MBSRI_GROUP_H

#include "recursion/data.h"

typedef struct mbsri_group {
    const int *member; /* bodies, by ascending index: the head first */
    int members;
    int n;  /* joint rates of all */
    int ig; /* where they begin */
} mbsri_group;

/* Whether the joints of the group of that head are eliminated one by one. */
static inline bool mbsri_apart(const mbsr_model *m, const mbsr_data *d, int head)
{
    return d->single || (m->order.grouped && d->apart[head]);
}

/* Whether body i is the head of a group; others are done with it. */
static inline bool mbsri_heads(const mbsr_model *m, const mbsr_data *d, int i)
{
    const int head = m->body[i].group.head;
    return head == i || mbsri_apart(m, d, head);
}

/* The group of head i: as it is in the model, and as the data holds it. */
static inline mbsri_group mbsri_group_in_model(const mbsr_model *m, int i)
{
    const mbsri_body *b = m->body + i;
    return (mbsri_group){m->order.member + b->group.at, b->group.members, b->group.n, b->group.iu};
}

static inline mbsri_group mbsri_group_of(const mbsr_model *m, const mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    if (!mbsri_apart(m, d, b->group.head)) return mbsri_group_in_model(m, i);
    return (mbsri_group){m->order.member + b->group.at, 1, b->n, b->group.iu};
}

/* Whether elimination joint by joint would find other equations than that of the whole group: where
 * some joint lacks rank and one behind it in the group, that gets eliminated before, does not lack
 * all. Else a joint lacks rank because nothing of its group takes part in its motion. */
static inline bool mbsri_coupled(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g)
{
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        const int rank = d->rank[g->member[k]];
        if (rank == b->n) continue;
        if (rank > 0) return true;
        for (int l = k + 1; l < g->members; ++l) {
            int above = g->member[l];
            while (above > g->member[k]) above = m->body[above].parent;
            if (above == g->member[k] && d->rank[g->member[l]] > 0) return true;
        }
    }
    return false;
}

/* Sum of the ranks of its joints, which is that of its block. */
static inline int mbsri_group_rank(const mbsr_data *d, const mbsri_group *g)
{
    int rank = 0;
    for (int k = 0; k < g->members; ++k) rank += d->rank[g->member[k]];
    return rank;
}

/* y: U (d x n at the head) of the inertias A, one d x d block a body; JY (n x n): D. work: 2 d n of
 * the largest member. */
void mbsri_group_products(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                          const double *A, double *Y, double *JY, double *work);

/* D (n x n) += the armature of its joints on the diagonal. */
void mbsri_group_add_armature(const mbsr_model *m, const mbsri_group *g, double *D);

/* The load on the group of head i, and what it takes up:  e (n) -= J^T (b - C a),  sum (d) += G e.
 * a are the accelerations that k makes in a group whose predecessor and joints rest, a_i = -H_i
 * a_pi - k_i; b and k with d numbers a body; sum = b + C k of the head. Nothing where body i is not
 * a head. work: d times the members and one. */
void mbsri_group_load(const mbsr_model *m, const mbsr_data *d, int i, const double *b,
                      const double *k, double *e, double *sum, double *work);

/* x (n) <- L^-1 x, where D = L Diag(D_j) L^T with a block a joint, regular or zero by their ranks:
 * what elimination joint by joint, from the last to the first, leaves of x. work: 2 n^2 + n. */
void mbsri_group_separate(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, double *x,
                          double *work);

/* x (n) <-> a vector by the caller's order. */
void mbsri_group_gather(const mbsr_model *m, const mbsri_group *g, const double *caller, double *x);
void mbsri_group_scatter(const mbsr_model *m, const mbsri_group *g, const double *x,
                         double *caller);

#endif

/* Directions that move no mass: a basis, and the forces in them, for starts and reports.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The combinations of joint rates that leave every mass at rest are the null space of the
 * joint-space mass matrix. One basis vector a belongs to each null vector N e_l of a block D_j: it
 * starts with that rate at j and continues to the leaves by the recursion of Az
 * (recursion/forward.c),
 *
 *   a_i = z_i - D_i^+ J_i^T Mbar_i H_i Vz_pi,  Vz_i = -H_i Vz_pi - J_i a_i,  z_j = N e_l, others 0.
 *
 * The forces in these directions are gamma_l = N_l^T (projection of e_j on the null space of D_j).
 * The projection is taken where the forces are evaluated and N where the basis was built, so that
 * gamma is smooth in (t, q, u) although eigenvectors may flip or turn.
 *
 * What is left of a_i and Vz_i where their terms cancel but for rounding is set to zero
 * (null_lift.h). */
#ifndef MBSRI_NULL_SPACE_H
#define MBSRI_NULL_SPACE_H

#include "algebra/differences.h"
#include "base/memory.h"
#include "massless/reduction.h"
#include "newton/slopes/force_slopes.h"
#include "recursion/data.h"

/* The null vectors of a group's joint block and the work of lifting them to the leaves. */
typedef struct mbsri_null_lifting {
    double *basis;       /* max_n x max_n: N of a group */
    double *work;        /* of null_lift.c */
    double *rate_error;  /* nu x k: what directions may be wrong by */
    double *twist_error; /* size_v x k: what twists may be wrong by */
} mbsri_null_lifting;

/* Forces that are kept while gamma is evaluated elsewhere. */
typedef struct mbsri_null_loads {
    bool on;         /* gamma takes the forces of some elements from f and tau */
    bool *own;       /* forces: which these are (element_slopes.h) */
    double *f, *tau; /* size_v, nu */
    double *lambda;  /* rows of closures: loop forces (null_loops.h); NULL: none are known */
    double lever;    /* with lambda: the longest lever of the mechanism, m */
} mbsri_null_loads;

/* Directions that are sums of those that gamma was built for (shorten.h). */
typedef struct mbsri_null_sums {
    bool on;
    double *weights; /* k x k: a column each */
    double *gamma;   /* k: of those */
    int *head;       /* k: of the first group among those */
} mbsri_null_sums;

/* Differences of gamma along the directions (null_slopes.h); directions of one colour are taken at
 * once. */
typedef struct mbsri_null_difference {
    double *ahead, *behind; /* k */
    double *slopes, *sizes; /* k x decades: of one column, and of the forces differenced */
    double *shift;          /* nu */
    bool *affects; /* k x k: whether direction l may change gamma_k, at l k + k (couplings.h) */
    bool *tables;  /* work of couplings.c */
    int *colour;   /* k */
    int colours;
} mbsri_null_difference;

/* What elements see of the directions (element_rows.h, element_slopes.h). */
typedef struct mbsri_null_elements {
    double *q_rate, *V_rate; /* nq x k, size_v x k: change of q and of V along the directions */
    double *strain;          /* k: forces, were all positions off by their typical sizes */
    double *reaction;        /* 4 x the most rows or columns of an element's derivatives */
    int *moving;             /* k: directions that move the element at work */
    int *touched;            /* N: bodies whose V changes along the direction at work */
    mbsri_slopes slope;      /* work of element_slopes.c */
    double *factor;          /* factor_size (factor_size + 3) */
    int factor_size;         /* the most rows or columns */
    int *factor_places;      /* 2 factor_size */
    mbsri_array rows, entries;
    bool *dense[2];          /* k: whether C, and S, have entries that no row explains */
    int *place;              /* k: place in the list at work; -1: not in it */
    mbsri_reduction reduced; /* reduction of the rows (seen.h) */
    mbsri_array room;        /* its numbers */
} mbsri_null_elements;

/* Typical sizes (scales.h). */
typedef struct mbsri_null_scale {
    double *q, *u; /* nq, nu */
    double *span;  /* nu: typical length where u is a velocity, 1 elsewhere */
} mbsri_null_scale;

typedef struct mbsri_null_space {
    const mbsr_model *m;
    mbsr_data *d;
    const char *function; /* for messages */
    int k;                /* directions */
    double size;          /* typical length of the tree, m */
    double rate_of_tree;  /* typical rate, 1/s */
    int *head;            /* k: head of the group of joints (recursion/group.h) each belongs to */
    int *body;            /* k: index of the body among these whose joint lacks rank for it */
    double *vector;       /* max_n x k: N_l */
    double *direction;    /* nu x k: a_l */
    double *twist;        /* size_v x k: Vz of a_l, zero at bodies that stand still */
    double *C;            /* k x k: d gamma / d u along the directions */
    double *S;            /* k x k: d gamma / d q along the directions */
    double *C_error, *S_error; /* k x k: what their entries may be wrong by */
    double *q, *u, *rate;      /* nq, nu, nq: displaced state of differences, q' of a direction */
    double *force;             /* nu: forces along null directions, scratch */
    double *q_given;           /* nq: where the directions were counted */
    int *rank;                 /* bodies + 1: ranks of the joint blocks at q_given */
    int *from, *to;            /* 3 k: rows of direction, twist and q_rate that are not zero */
    mbsri_null_lifting lift;
    mbsri_null_loads loads;
    mbsri_null_sums sums;
    mbsri_null_difference difference;
    mbsri_null_elements element;
    mbsri_null_scale scale;
    void *memory;
} mbsri_null_space;

/* Evaluates the state up to mbsr_stage_backward; the directions there are counted and memory is
 * taken for them from the model's allocator. */
int mbsri_null_open(mbsri_null_space *w, const mbsr_model *m, mbsr_data *d, double t,
                    const double *q, const double *u, const char *function);
void mbsri_null_close(mbsri_null_space *w);

/* The basis at a state. MBSR_RANK_CHANGED if the number of directions is not k. */
int mbsri_null_basis(mbsri_null_space *w, double t, const double *q, const double *u);

/* Directions and twists of the sums of vectors in w->sums.weights, with the errors that they have
 * themselves. */
int mbsri_null_lift_again(mbsri_null_space *w, double t, const double *q, const double *u);

/* gamma (k) at a state; the basis stays. */
int mbsri_null_gamma(mbsri_null_space *w, double t, const double *q, const double *u,
                     double *gamma);

/* The sum of the sizes of the forces that gamma_l was added up from, after mbsri_gross_forces:
 * those along the vector, and a trace of all on the joints of its group, whose part beside the null
 * space is taken out but for rounding. */
double mbsri_null_load(const mbsri_null_space *w, int l);

/* x (k), numbers of the vectors that gamma was built for, becomes that of the sums of them that are
 * the directions (shorten.h): T^T x, or by sizes |T|^T x. Nothing unless w->sums.on. */
void mbsri_null_remix(const mbsri_null_space *w, bool sizes, double *x);

/* What is combined by mbsri_null_mix: directions (nu), their twists (size_v) or q_rate (nq). */
typedef enum mbsri_null_field {
    MBSRI_NULL_RATES,
    MBSRI_NULL_TWISTS,
    MBSRI_NULL_SHIFTS
} mbsri_null_field;

/* y = sum of a part of the directions with these weights (k), without rounding where they cancel.
 * size: as many numbers of scratch. After mbsri_null_extents. */
void mbsri_null_mix(const mbsri_null_space *w, mbsri_null_field part, const double *weights,
                    double *y, double *size);

/* Notes which rows of the parts are not zero. */
void mbsri_null_extents(mbsri_null_space *w);

/* rate = G(q) x for any x (nu) at the positions of the data, whose u becomes x. */
int mbsri_null_rate_here(mbsri_null_space *w, const double *x, double *rate);

/* Divides each row, or column, of A (k x k) by its largest entry unless that is zero; scale (k)
 * gets the factors. */
void mbsri_scale_rows(int k, double *A, double *scale);
void mbsri_scale_columns(int k, double *A, double *scale);

#endif

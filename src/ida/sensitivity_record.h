/* Sensitivities of runs: the record, and steps of the linearised equations.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Nodes 0 .. steps are the start and the ends of the steps. Backward differences of step k over the
 * nodes k, k - 1 .. k - order,
 *
 *   (A_k + a_0 E_k) s_k = R_k T_k - E_k sum_{i >= 1} a_i s_{k-i}      A = dF/dy, E = dF/dy'
 *
 * with R = dF/dtau and T the derivatives of inverse dynamics in the parameters. p in s is less by
 * what a parameter does to the mass matrix, dM u, which makes T all of the right-hand side
 * (docs/study.md). At the beginning of a run, and behind a kink, the node before step k is replaced
 * by a short step of implicit Euler from it with the matrices of step k: directions that springs
 * alone hold jump there. */
#ifndef MBSRI_IDA_SENSITIVITY_RECORD_H
#define MBSRI_IDA_SENSITIVITY_RECORD_H

#include <mbsrank/derivatives.h>
#include <mbsrank/sensitivity.h>

#include <stdbool.h>
#include <stddef.h>

enum { MBSRI_NODES = 6 }; /* of the longest formula */

/* A step of the run; `since`: how many steps of its segment are before it. crossed: the segment
 * begins where an element took another branch, within a step; nothing jumps there. */
typedef struct mbsri_kept_step {
    double t;
    int order, since;
    bool crossed;
} mbsri_kept_step;

/* A growing array; `count` elements of it are in use. */
typedef struct mbsri_kept {
    void *data;
    size_t count, capacity;
} mbsri_kept;

/* Elements whose laws have branches, and those that they were on last. */
typedef struct mbsri_sides {
    int count, *force;
    double *last, *now; /* count each */
    double *y;          /* size */
    double *F;          /* 3 size */
    mbsr_data *data;
} mbsri_sides;

struct mbsr_sensitivity {
    const mbsr_model *model;
    mbsr_sensitivity_opt opt;
    mbsr_data *data;
    mbsr_ida *ida;
    mbsr_derivatives *derivatives;
    mbsr_newton *newton, *back; /* solves; solves transposed */
    int size, nq, nu, parameters;
    bool plain;   /* a tree without directions that lack mass: u does not jump */
    bool restart; /* behind a kink */
    bool cut;     /* the last step ended at a crossing */
    int rise;     /* what orders have risen to behind a crossing */
    struct {
        bool made;    /* there is one, */
        bool checked; /* of which some sums have not found a step too long, */
        bool divided; /* or with steps divided */
    } run;
    double start;     /* time */
    mbsri_kept step;  /* mbsri_kept_step of node 1, 2, .. */
    mbsri_kept state; /* y, y' of these */
    mbsri_kept time;  /* of outputs */
    double *given;    /* q, u that it was given; q, u of its consistent start; nu and parameters */
    double *work;     /* 4 size + parameters: of the formulas below */
    int zero;         /* the first parameter that is a mass of zero; MBSR_NONE */
    char named[96];   /* its name */
    double *value;    /* parameters: of these */
    double *begin;    /* y, y' at the start */
    bool elastic;     /* there are directions without mass that springs alone hold */
    char frame[96];   /* name of the first parameter of a joint's frame; "": there is none */
    mbsri_sides sides;
    mbsr_error error;
};

/* What step k does: its nodes besides its own, weights a_0 .. a_order; of an output at t the nodes
 * node, node - 1 .. node - order and their weights. */
typedef struct mbsri_formula {
    long node;
    int order;
    double weight[MBSRI_NODES];
} mbsri_formula;

static inline const mbsri_kept_step *mbsri_kept_at(const mbsr_sensitivity *s, long node)
{
    return (const mbsri_kept_step *)s->step.data + (node - 1);
}

mbsri_formula mbsri_sensitivity_rate(const mbsr_sensitivity *s, long node);
mbsri_formula mbsri_sensitivity_output(const mbsr_sensitivity *s, long from, double t);

/* The factor c of the short step before node k. */
double mbsri_sensitivity_short(const mbsr_sensitivity *s, long node);

/* The matrices of step k in `newton`, with c; T in `derivatives`, where `sources`. A status. */
int mbsri_sensitivity_at(mbsr_sensitivity *s, mbsr_newton *newton, long node, double c);
int mbsri_sensitivity_sources(mbsr_sensitivity *s, long node);

/* y and y' at a node from 1 on; time of any. */
const double *mbsri_sensitivity_state(const mbsr_sensitivity *s, long node);
double mbsri_sensitivity_time(const mbsr_sensitivity *s, long node);

/* Forward equations, of `count` weighted sums of parameters (count x parameters; NULL: of each by
 * itself), with what is known of the last nodes. */
typedef struct mbsri_forward_run {
    mbsr_sensitivity *s;
    int count;
    const double *weight;
    double *node; /* MBSRI_NODES x count x size */
    double *tau;  /* count x nu: T */
    double *jump; /* parameters x nu; NULL without weights */
} mbsri_forward_run;

static inline double *mbsri_forward_node(const mbsri_forward_run *f, long node, int k)
{
    const size_t size = (size_t)f->s->size, count = (size_t)f->count;
    return f->node + ((size_t)(node % MBSRI_NODES) * count + (size_t)k) * size;
}

/* s at a node, from those before. A status. */
int mbsri_forward_step(mbsri_forward_run *f, long node);

/* Of each sum, by the tolerances of q: the largest value on the way, and the largest error of a
 * step of those after the first. */
typedef struct mbsri_step_errors {
    double *largest, *worst; /* count */
} mbsri_step_errors;

/* The error of sum k at a node, in the same measure; what it may be beside the largest value, and
 * whatever that is, of relative changes of parameters. */
double mbsri_sensitivity_error_of(const mbsri_forward_run *f, long node, int k);
double mbsri_sensitivity_allowed(const mbsri_forward_run *f, int k, double largest);

/* Notes those at a node that was just reached. */
void mbsri_sensitivity_note_errors(const mbsri_forward_run *f, long node, mbsri_step_errors *e);

/* Whether they are no more than some tolerances. */
bool mbsri_sensitivity_is_fine(const mbsri_forward_run *f, const mbsri_step_errors *e);

/* Divides steps that are too long for sensitivities; looks first whether there are any. A status.
 */
int mbsri_sensitivity_divide(mbsr_sensitivity *s);
int mbsri_sensitivity_check(mbsr_sensitivity *s);

/* Step k begins a segment, and u jumps before it: p of s then jumps by minus dM times what u jumps
 * by. For each parameter added to p, which is `stride` numbers behind that of the last one; or of
 * the weights w (nu) of p, added to by (parameters). A status. */
int mbsri_sensitivity_jump(mbsr_sensitivity *s, long node, double *p, size_t stride);
int mbsri_sensitivity_jump_back(mbsr_sensitivity *s, long node, const double *w, double *by);

/* Finds the elements of the model that have branches. A status, with *error. */
int mbsri_sensitivity_find_sides(mbsr_sensitivity *s, mbsr_error *error);
void mbsri_sensitivity_free_sides(mbsri_sides *sides);

/* Notes the branches at `from`, in the last step. Or looks for the first place up to `to` where one
 * is left: *before and *behind are its sides, or *before == to. Statuses. */
int mbsri_sensitivity_note_sides(mbsr_sensitivity *s, double from);
int mbsri_sensitivity_cross(mbsr_sensitivity *s, double from, double to, double *before,
                            double *behind);

/* The driver whose steps are kept. A status, with *error. */
int mbsri_sensitivity_driver(mbsr_sensitivity *s, mbsr_error *error);

/* Room for `more` elements behind those in use, numbers that are zero, and their end. false and
 * NULL: there is no memory. */
bool mbsri_sensitivity_reserve(mbsri_kept *array, size_t more, size_t element);
double *mbsri_sensitivity_take(size_t count);
void mbsri_sensitivity_free(void *memory);

/* Writes s->error and returns the status. */
int mbsri_sensitivity_fail(mbsr_sensitivity *s, int status, const mbsr_error *why,
                           const char *function);

#endif

/* Positions that close loops.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_ASSEMBLE_H
#define MBSRI_LOOPS_ASSEMBLE_H

#include "loops/closing.h"
#include "recursion/closures.h"

#include <mbsrank/dae.h>
#include <mbsrank/closure.h>

/* The standard options, but for their cookie. */
static inline mbsr_assembly_opt mbsri_assembly_standard(void)
{
    return (mbsr_assembly_opt){.max_iterations = 100, .tolerance = 1e-12};
}

/* The standard options with what a consistent start is asked of positions. */
static inline mbsr_assembly_opt mbsri_assembly_of(const mbsr_consistent_opt *opt)
{
    mbsr_assembly_opt assembly = mbsri_assembly_standard();
    assembly.weight = opt->weight;
    assembly.keep_position = opt->keep_position;
    return assembly;
}

/* Workspace of one search. */
typedef struct mbsri_closer {
    const mbsr_model *m;
    mbsr_data *d;
    const char *function;   /* for messages */
    mbsri_closing closing;  /* of the positions that a search begins with */
    double *offset;         /* position rows: what the gaps are to be, zero at first */
    bool *let_go;           /* rows: that may open, none at first */
    double *g, *g_try;      /* position rows */
    double *x, *resist;     /* nu */
    double *zero, *step;    /* nu */
    double *right, *lambda; /* rows */
    double *compliance;     /* rows */
    double *q_try;          /* nq */
    struct mbsri_fronts *system;
    void *memory;
} mbsri_closer;

/* Takes memory from the model's allocator; mbsri_closer_close gives it back, after a failure too.
 */
int mbsri_closer_open(mbsri_closer *w, const mbsr_model *m, mbsr_data *d, const char *function);
void mbsri_closer_close(mbsri_closer *w);

/* Whether positions are to close position row k of the closure. */
static inline bool mbsri_is_asked(const mbsri_closer *w, const mbsri_closure *c, int k)
{
    return !mbsri_is_loose(c, k) && !w->let_go[c->row + k];
}

/* q (nq) is brought to a closed position, or the nearest found (MBSR_LOOP_OPEN, with its text), in
 * O(bodies + loops) a step. */
int mbsri_assemble(mbsri_closer *w, double t, double *q, const mbsr_assembly_opt *opt,
                   mbsr_assembly_info *info);

/* to (nq) = q moved by step along the joint rates x (n): q + step G x, at the positions q of the
 * data. */
int mbsri_displace(const mbsr_model *m, mbsr_data *d, const double *q, double step, const double *x,
                   double *to);

#endif

/* Positions that close loops.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_ASSEMBLE_H
#define MBSRI_LOOPS_ASSEMBLE_H

#include "loops/dense.h"

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

/* q (nq) is brought to a closed position, or the nearest found (MBSR_LOOP_OPEN, with its text).
 * Uses A, b, C, g, x, y and q_try of the workspace; q may be its q. */
int mbsri_assemble(mbsri_dense *w, double t, double *q, const mbsr_assembly_opt *opt,
                   mbsr_assembly_info *info);

/* Gaps at the positions of the data, into g (held), less what they are to be; loose springs have
 * none. */
int mbsri_assembly_gaps(const mbsri_dense *w, double *g);

/* to (nq) = q moved by step along the joint rates x (n): q + step G x, at the positions q of the
 * data. */
int mbsri_displace(const mbsr_model *m, mbsr_data *d, const double *q, double step, const double *x,
                   double *to);

#endif

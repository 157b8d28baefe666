/* Closed loops in a run.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_LOOPS_H
#define MBSRI_IDA_LOOPS_H

#include "ida/record.h"

/* Where in y the multipliers of closures begin; the size of y where there are none. */
int mbsri_ida_loops(const mbsr_ida *ida);

/* Tolerances of the multipliers from those of p and q: what moves no p, or q, by more; in large
 * models by the largest of these of each kind. place (nu): of what the joint rates move. A status
 * of the data. Uses `work`, and nu numbers of `displaced`. */
int mbsri_ida_scale_multipliers(mbsr_ida *ida, const double *place);

/* Raises tolerances of the forces of stiff rows to what rounding of their gaps makes. */
void mbsri_ida_allow_rounding(mbsr_ida *ida);

/* Newton's method for closures, at the start: where it fails twice within a few steps it gets a new
 * matrix in each iteration (ida/iteration.c), without the filter of errors; momenta whose
 * tolerances are not given are tested by what they move (ida/filter.c). Where springs of stiff rows
 * share a force among rows that depend on each other it does so in every step: how they share it
 * turns with the mechanism, and an old matrix leaves their stiffness times that. */
void mbsri_ida_take_care(mbsr_ida *ida);

/* After IDA has given up: MBSR_LOOP_SINGULAR, with the name of the loop, where rows of closures are
 * dependent, or nearly, in the last good state, or bodies without mass stretched; else MBSR_OK. */
int mbsri_ida_blame_loops(mbsr_ida *ida);

/* Before a step from y: the same, as the failure of a callback, where the integration hardly moves
 * on. */
int mbsri_ida_watch_loops(mbsr_ida *ida, N_Vector y);

/* MBSR_LOOP_OPEN where rows that were left out as redundant at the start have opened: at the end,
 * and before a step from y, as the failure of a callback. */
int mbsri_ida_check_dropped(mbsr_ida *ida);
int mbsri_ida_watch_dropped(mbsr_ida *ida, double t, N_Vector y);

#endif

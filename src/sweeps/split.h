/* A tree in parts for several threads: subtrees, and the trunk that they stand on.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * What a sweep does with a body depends on its predecessor or on its successors only, so subtrees
 * are swept side by side: root to leaves after the trunk, leaves to root before it. A subtree
 * leaves what it has for its predecessor (mbsri_part_state); the trunk takes it at the place in the
 * order where one thread would have it, so that every sum is added up in the same order and results
 * agree to the last bit. */
#ifndef MBSRI_SWEEPS_SPLIT_H
#define MBSRI_SWEEPS_SPLIT_H

#include "sweeps/tree.h"

#include <mbsrank/threads.h>

/* Where a sweep to the root stands: what the body before hands on, and the next free places of the
 * stacks where several successors wait for each other. */
typedef struct mbsri_part_state {
    mbsri_carry carry, noise; /* noise: W, of exact sweeps */
    mbsri_flow flow;
    union {
        struct {
            mbsri_carry *stack, *noises;
            mbsri_flow *flows;
        };
        double room[4]; /* pointers have four bytes or eight */
    };
} mbsri_part_state;
MBSRI_CHECK_LAYOUT(mbsri_part_state);

/* kept: body `first` does not hand on what it has, which stays in the state; `join` does so later,
 * with its flags. */
typedef struct mbsri_part_kernels {
    int (*move)(const mbsri_sweep_run *run, int first, int last, bool velocity);
    /* False: the rank of some joint is not clear. */
    bool (*backward)(const mbsri_sweep_run *run, int first, int last, bool exact, bool kept,
                     mbsri_part_state *state);
    void (*momentum)(const mbsri_sweep_run *run, int first, int last, bool kept,
                     mbsri_part_state *state);
    void (*loads)(const mbsri_sweep_run *run, int first, int last, bool kept,
                  mbsri_part_state *state);
    void (*join_backward)(int flags, bool exact, mbsri_part_state *state);
    void (*join_momentum)(int flags, mbsri_part_state *state);
    void (*join_loads)(int flags, mbsri_part_state *state);
    int (*accelerate)(const mbsri_sweep_run *run, int first, int last);
    void (*balance)(const mbsri_sweep_run *run, int first, int last);
    void (*forward)(const mbsri_sweep_run *run, int first, int last);
} mbsri_part_kernels;

/* The split that serves this run, whose tree is known; NULL: one thread does. */
mbsr_split *mbsri_split_of(const mbsri_sweep_run *run);

/* Of all bodies but those of the subtrees: angles, motion. A status. */
int mbsri_split_move(const mbsri_sweep_run *run, mbsr_split *split, bool velocity);

/* The backward recursion, of subtrees after their motion; with the momentum form's part where the
 * run has momenta. By the bound, then by W; 0, or another number where the stages have to do it. */
int mbsri_split_backward(const mbsri_sweep_run *run, mbsr_split *split, bool velocity);
void mbsri_split_forward(const mbsri_sweep_run *run, mbsr_split *split);

/* Inverse dynamics from the angles on. A status. */
int mbsri_split_inverse(const mbsri_sweep_run *run, mbsr_split *split);

#endif

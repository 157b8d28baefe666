/* A run from output to output and from input to input.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_DRIVE_H
#define MBSRANK_DRIVE_H

#include "program/inputs.h"

#include <mbsrank/simulation.h>

/* Options of a run. */
typedef struct run_options {
    program_options common;
    const char *inputs, *outputs, *file, *form;
    double t_end, rtol, atol, step; /* step 0: a hundredth of t_end */
    bool quiet;
} run_options;

/* Options of `command`, checked for what a run needs; a code. */
int drive_options(const char *command, int argc, char **argv, run_options *o);

/* From output to output, s. */
double drive_step(const run_options *o);

/* Form and tolerances; a code. */
int drive_integrator(const run_options *o, mbsr_ida_opt *opt);

/* Who takes the states of a run. */
typedef struct drive_taker {
    double (*next)(void *user); /* when the next state is wanted, s; infinite: at the end */
    /* Takes a state, of an event or not; a code other than DONE ends the run. */
    int (*take)(void *user, const mbsr_simulation *s, bool event);
    void *user;
} drive_taker;

/* From the start of a simulation to the end of the run. A code of the taker; where the simulation
 * fails FAILED, with the reason in `text`. */
int drive(const run_options *o, const program_model *m, mbsr_simulation *s, inputs *in,
          const drive_taker *taker, char text[MBSR_TEXT_SIZE]);

#endif

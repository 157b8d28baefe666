/* What a page shows of a run: poses and joint reactions of all bodies, sample by sample.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_MOTION_H
#define MBSRANK_MOTION_H

#include "program/inputs.h"
#include "program/touching.h"

/* Numbers of a body in a sample. */
enum { POSE_NUMBERS = 7, REACTION_NUMBERS = 6, LOOP_NUMBERS = 9, TOUCH_NUMBERS = 6 };

/* A closure that acts at a point, and the body on which it is shown. */
typedef struct shown_loop {
    int closure, place, body;
} shown_loop;

typedef struct motion {
    int samples;
    double *time;    /* s */
    float *q;        /* samples x nq */
    float *pose;     /* samples x bodies x 7: origin (m), quaternion (w first) */
    float *reaction; /* samples x bodies x 6: what the joint exerts on the body, force (N) and
                        moment about the joint's point (N m), world axes; NULL: not known */
    int loops;
    shown_loop *loop;  /* loops */
    float *loop_force; /* samples x loops x 9: where the closure acts (m), what it exerts on the
                          body, force and moment about that point, world axes; NULL as reaction */
    int touches;       /* points of contact of a sample, at most */
    float *touch; /* samples x touches x 6: where (m), and the force (N) on the one of both bodies
                     that has the larger id, world axes; zeros where there are fewer */
    char without[MBSR_TEXT_SIZE]; /* why; "" where they are known */
    double *point;                /* bodies x 3: the joint's point on the body, m, body axes */
} motion;

/* Of a run (from `mbsrank run`, which must have all joints; with their rates there are reactions)
 * under its inputs, with the points of what touches; run == NULL: of the consistent start near q
 * and u (NULL: at rest). A code. The motion is freed in any case. */
int motion_make(const program_model *m, touching *contacts, const char *path, const table *run,
                inputs *in, const double *q, const double *u, motion *to);
void motion_free(motion *to);

#endif

/* What the code in the documents takes for granted when it is run: four bodies, and names for them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef SNIPPET_WORLD_H
#define SNIPPET_WORLD_H

#include <math.h>
#include <mbsrank/mbsrank.h>
#include <stdio.h>

extern mbsr_model *m, *model;
extern mbsr_data *d, *data;
extern mbsr_newton *newton;
extern mbsr_body_def body;
extern mbsr_joint_table table;
extern mbsr_error error;
extern double t, c, *q, *u, *y, *yp, *F, *delta;
extern int status, n;
extern void *user;
extern const char *text;
extern size_t size;

#endif

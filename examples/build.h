/* What the examples from 10 on share: building a model in fewer lines. 01 to 09 write these calls
 * out.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef EXAMPLES_BUILD_H
#define EXAMPLES_BUILD_H

#include <mbsrank/mbsrank.h>

#include <stdio.h>
#include <stdlib.h>

static inline void check(int status, const mbsr_error *error)
{
    if (status == MBSR_OK) return;
    fprintf(stderr, "%s: %s\n", mbsr_status_name(status), error->text);
    exit(1);
}

static inline mbsr_model *new_model(void)
{
    mbsr_model *m;
    mbsr_error error;
    check(mbsr_model_create(NULL, &m, &error), &error);
    return m;
}

/* Returns the id. A massless body: mbsr_inertia_zero(). */
static inline int add_body(mbsr_model *m, const char *name, int parent, mbsr_joint joint,
                           mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id;
    body.name = name;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    check(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

static inline void add_force(mbsr_model *m, mbsr_force_def force)
{
    check(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
}

/* A CSV file in the folder the program runs in. */
static inline FILE *csv(const char *name)
{
    FILE *file = fopen(name, "w");
    if (!file) exit(1);
    return file;
}

#endif

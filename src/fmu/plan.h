/* A model as an FMU carries it: definitions of its parts, inputs, sites, names and start.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   exporter:  model -> plan (take.h) -> bytes (plan.h)      FMU:
 *       bytes -> plan (plan.h) -> model (build.h)
 *
 * Definitions are those of the public headers. Their pointers stand for what is in the plan: tables
 * of functions have numbers (stock.h), and `user` is a link to a table, modal data, shapes, an
 * input or a motion of the plan. */
#ifndef MBSRI_FMU_PLAN_H
#define MBSRI_FMU_PLAN_H

#include "fmu/stream.h"

#include <mbsrank/closure.h>
#include <mbsrank/contact.h>
#include <mbsrank/flex.h>
#include <mbsrank/fmu.h>
#include <mbsrank/model.h>

typedef enum mbsri_link_kind {
    MBSRI_LINK_NONE,
    MBSRI_LINK_TABLE,
    MBSRI_LINK_FLEX,
    MBSRI_LINK_SHAPES,
    MBSRI_LINK_INPUT, /* the first of the numbers that the element reads */
    MBSRI_LINK_MOTION
} mbsri_link_kind;

/* What `user` of a definition stands for, and the function that reads it. */
typedef struct mbsri_link {
    int kind, index;
    int function; /* 0: none, or that of the table of functions; 1: mbsr_table_..., 2: the
                     importer's numbers */
} mbsri_link;

typedef struct mbsri_plan_body {
    mbsr_body_def def;
    mbsri_link link;
    int flex;                /* index of the modal data of a flexible inertia; else -1 */
    int joint_n;             /* rates of the joint as given */
    const double *locked_at; /* joint_n values of locked coordinates, NaN for others; NULL: none */
    int drops;               /* mbsr_model_drop_locked */
    const double *added;     /* d x d, mbsr_model_regularise; NULL: none */
    int armatures;           /* how many rates have armature given: n, or 0 */
    double *armature;
} mbsri_plan_body;

typedef struct mbsri_plan_force {
    mbsr_force_def def;
    mbsri_link link;
} mbsri_plan_force;

typedef struct mbsri_plan_closure {
    mbsr_closure_def def;
    mbsri_link link;
} mbsri_plan_closure;

typedef struct mbsri_plan_table {
    mbsr_table_def def;
    const void *from; /* while it is taken: the table itself */
} mbsri_plan_table;

typedef struct mbsri_plan_flex {
    mbsr_flex_def def;
    const void *from;
} mbsri_plan_flex;

typedef struct mbsri_plan_shapes {
    mbsr_contacts_def def;
    const void *from;
} mbsri_plan_shapes;

/* One number that the importer sets. */
typedef struct mbsri_plan_input {
    const char *name;
    const char *unit;
    double start, range[2]; /* value at the start; its range, infinite: none */
    const void *from;
} mbsri_plan_input;

/* A motion of `count` coordinates: for each three inputs, value and first and second derivative. */
typedef struct mbsri_plan_motion {
    int input, count;
    const void *from;
} mbsri_plan_motion;

typedef struct mbsri_plan_site {
    const char *name;
    int body;
    mbsr_frame frame;
} mbsri_plan_site;

/* A number of q or u. */
typedef struct mbsri_plan_coordinate {
    const char *joint; /* name */
    int place;         /* 1, 2, ... of several of that joint; 0: it has one */
    int kind;          /* mbsr_coordinate_kind */
    double start;
} mbsri_plan_coordinate;

/* How co-simulation steps. */
typedef struct mbsri_plan_steps {
    double rtol, atol;
    double fixed_step; /* s; 0: steps by the error */
    int order;         /* order of fixed steps, 1 or 2 */
} mbsri_plan_steps;

typedef struct mbsri_unit_plan {
    mbsri_arena arena; /* memory of all that is pointed to */
    const char *name;
    double rank_tolerance;
    mbsri_plan_steps steps;
    int outputs; /* mbsr_fmu_outputs */
    int model_exchange;
    int bodies, forces, closures, tables, flexes, contacts, inputs, motions, sites, nq, nu;
    mbsri_plan_body *body;
    mbsri_plan_force *force;
    mbsri_plan_closure *closure;
    mbsri_plan_table *table;
    mbsri_plan_flex *flex;
    mbsri_plan_shapes *shapes; /* of each object of contacts */
    mbsri_plan_input *input;
    mbsri_plan_motion *motion;
    mbsri_plan_site *site;
    mbsri_plan_coordinate *q, *u;
} mbsri_unit_plan;

void mbsri_plan_open(mbsri_unit_plan *plan, const mbsr_allocator *allocator);
void mbsri_plan_close(mbsri_unit_plan *plan);

/* The plan as bytes of its arena; NULL: no memory. */
const unsigned char *mbsri_plan_write(mbsri_unit_plan *plan, size_t *size);

/* And back, in a plan just opened. MBSR_ERR_FILE with the reason: it is damaged, or of another
 * version of the library. */
int mbsri_plan_read(mbsri_unit_plan *plan, const unsigned char *data, size_t size,
                    mbsr_error *error);

/* Where rate `coordinate` of a body's joint, as it was given, stands in u; -1: it is locked, or
 * there is none. */
int mbsri_plan_rate(const mbsri_unit_plan *plan, int body, int coordinate);

/* Unit of a force along rate `at` of u; "": not known. */
const char *mbsri_plan_effort(const mbsri_unit_plan *plan, int at);

/* What an importer has to say to an FMU that is of this model: 32 hexadecimal digits of the bytes.
 */
enum { MBSRI_TOKEN = 33 };
void mbsri_plan_token(const unsigned char *data, size_t size, char token[MBSRI_TOKEN]);

#endif

/* The variables of an FMU: the same list for its description and for its run.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A variable's number in the list, from 0 on, is its value reference. The order: time; parameters; inputs; joint coordinates, rates,
 * accelerations; momenta and derivatives of the states (model exchange); sites, forces, reactions, energies; event indicators. */
#ifndef MBSRI_FMU_VARIABLES_H
#define MBSRI_FMU_VARIABLES_H

#include "fmu/build.h"

typedef enum mbsri_variable_kind {
    MBSRI_TIME,
    MBSRI_PARAMETER, /* a number of the plan; `of`: 1 and the body whose tensor a change makes inexact, or 0 */
    MBSRI_INPUT, /* `of`: its number */
    MBSRI_Q,     /* `of`: place in q, u */
    MBSRI_U,
    MBSRI_UDOT,
    MBSRI_P,
    MBSRI_QDOT, /* derivatives of states */
    MBSRI_PDOT,
    MBSRI_SITE,     /* `of`: its number; component 0 .. 2: position, 3 .. 6: quaternion */
    MBSRI_FORCE,    /* of an element; its f on its first body */
    MBSRI_EFFORT,   /* and its tau */
    MBSRI_REACTION, /* of the joint of a body */
    MBSRI_LOOP,     /* `of`: row of the closures */
    MBSRI_KINETIC,
    MBSRI_POTENTIAL,
    MBSRI_INDICATOR /* of an element; component 0: lower stop or contact, 1: upper stop */
} mbsri_variable_kind;

typedef struct mbsri_variable {
    mbsri_variable_kind kind;
    int of, component;
    const char *name, *description;
    const char *unit;  /* "": none is known */
    double start;      /* of parameters, inputs, q and u */
    double *place;     /* of a parameter: in the plan */
    int derivative_of; /* the number of its state; -1: it is no derivative */
} mbsri_variable;

typedef struct mbsri_variables {
    mbsri_variable *list;
    int count, parameters;              /* in all; parameters stand from 1 on */
    int inputs_at, q_at, u_at, udot_at; /* numbers of the first ones */
    int p_at, derivatives_at;           /* of model exchange, else -1 */
    int indicators_at, indicators;
} mbsri_variables;

/* In memory of the plan. `model` is that of the plan, finished. False: no memory. */
bool mbsri_list_variables(mbsri_plan *plan, const mbsr_model *model, mbsri_variables *variables);

#endif

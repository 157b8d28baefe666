/* One variable of an FMU.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_VARIABLE_H
#define MBSRI_FMU_VARIABLE_H

typedef enum mbsri_variable_kind {
    MBSRI_TIME,
    MBSRI_PARAMETER, /* `of`: its number in the model's list */
    MBSRI_INPUT,     /* `of`: its number */
    MBSRI_Q,         /* `of`: place in q, u */
    MBSRI_U,
    MBSRI_UDOT,
    MBSRI_P,
    MBSRI_QDOT, /* derivatives of states */
    MBSRI_PDOT,
    MBSRI_SITE,     /* `of`: its number; component 0 .. 2: position, 3 .. 6: quaternion */
    MBSRI_FORCE,    /* of an element; its f on one of its bodies */
    MBSRI_EFFORT,   /* and its tau on the first */
    MBSRI_REACTION, /* of the joint of a body */
    MBSRI_LOOP,     /* `of`: row of the closures */
    MBSRI_KINETIC,
    MBSRI_POTENTIAL,
    MBSRI_INDICATOR /* of an element; component 0: lower stop or contact, 1: upper stop */
} mbsri_variable_kind;

typedef struct mbsri_variable {
    mbsri_variable_kind kind;
    int of, component, place; /* place: of the body in the element's list */
    const char *name, *description;
    const char *unit;  /* "": none is known */
    double start;      /* start value of parameters, inputs, q and u */
    int derivative_of; /* the number of its state; -1: it is no derivative */
} mbsri_variable;

#endif

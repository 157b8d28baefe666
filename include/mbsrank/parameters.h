/* The numbers of a model by name, and models in which some of them are others.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   mbsr_parameters_create(model, &all, &error);
 *   int mass = mbsr_parameters_find(all, "bodies.rod.mass");
 *   mbsr_parameters_data(all, 1, &mass, &heavier, &data, &error);
 *   mbsr_forward_dynamics(mbsr_data_model(data), data, t, q, u, NULL, udot);
 *
 * A finished model stays as it is and is shared. Other values live in models of their own, or in
 * data that own such a model: they are checked like those of a model that is added to and finished,
 * ranks and everything that is planned are decided anew for them. What is evaluated afterwards
 * allocates nothing that the model did not. */
#ifndef MBSRANK_PARAMETERS_H
#define MBSRANK_PARAMETERS_H

#include <mbsrank/data.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a parameter belongs to. */
typedef enum mbsr_parameter_owner {
    MBSR_PARAMETER_BODY,
    MBSR_PARAMETER_FORCE,
    MBSR_PARAMETER_CLOSURE,
    MBSR_PARAMETER_TABLE
} mbsr_parameter_owner;

/* Which number of its owner it is. */
typedef enum mbsr_parameter_part {
    MBSR_PARAMETER_MASS,       /* of a body, kg */
    MBSR_PARAMETER_COM,        /* centre of mass, m */
    MBSR_PARAMETER_TENSOR,     /* about the centre of mass: MBSR_XX ... MBSR_YZ, kg m^2 */
    MBSR_PARAMETER_MOMENT,     /* of a body in the plane, kg m^2 */
    MBSR_PARAMETER_ARMATURE,   /* along a joint rate, kg m^2 or kg */
    MBSR_PARAMETER_JOINT,      /* param of its joint: origins of the frames A and B, m; in the plane
                                * their angles too, rad */
    MBSR_PARAMETER_LAW,        /* param of a force element */
    MBSR_PARAMETER_STIFFNESS,  /* of a stiff row of a closure */
    MBSR_PARAMETER_DAMPING,    /* likewise */
    MBSR_PARAMETER_POINT,      /* x of a table */
    MBSR_PARAMETER_TABLE_VALUE /* value of a table */
} mbsr_parameter_part;

/* A parameter, as mbsr_parameter_get tells it. Texts live as long as the list. */
typedef struct mbsr_parameter {
    const char *name;           /* "bodies.rod.mass", see below */
    const char *unit;           /* "kg", "N.m/rad"; "": not known */
    const char *description;    /* a few words */
    mbsr_parameter_owner owner; /* kind of its owner, */
    int id;                     /* whose id this is; of tables 0, 1, ... as they are found */
    mbsr_parameter_part part;   /* which of its numbers, */
    int index;                  /* and which of several: 0, 1, ... */
    double value;               /* in the model that the list was made of */
} mbsr_parameter;

/* The parameters of a model, numbered 0, 1, ...: these numbers are the handles. Read-only once
 * made: several threads may use one list at once. */
typedef struct mbsr_parameters mbsr_parameters;

/* Lists the parameters of a finished model. The list keeps a copy of its definition and does not
 * need the model any more, but what the model shares with its caller: tables of functions, `user`
 * pointers, tables.
 *
 *   bodies.NAME.mass, .com[1..3], .Ixx .. .Iyz, .I (in the plane), .armature (several:
 *       .armature[1..]), .joint_position[1..3], .joint_offset[1..3]: origin of frame A on the
 *       predecessor and of frame B on the body; in the plane [1..2], .joint_angle, .offset_angle
 *   forces.NAME.PARAMETER: as messages call it: stiffness, damping, rest, free_length, ...
 *   closures.NAME.stiffness[1..], .damping[1..]: of stiff rows
 *   tables.tableK.x[1..], .value[1..]: of tables of up to 1024 numbers, point by point
 *
 * Parts without a name are called body3, force0 and so on by their ids, tables table1, table2, ...;
 * a name that is no identifier stands in quotes. Not listed are inertias by matrix and function,
 * those of which something is neglected (mbsr_model_neglect), modal data, param of force elements
 * that the table does not name, frames and points among them, and what functions of the caller
 * read.
 *
 * On failure *list is NULL and the reason in *error (which may be NULL): MBSR_ERR_NULL,
 * MBSR_ERR_UNFINISHED, MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_parameters_create(const mbsr_model *model, mbsr_parameters **list,
                                    mbsr_error *error);
MBSR_API void mbsr_parameters_destroy(mbsr_parameters *list); /* NULL is allowed */

MBSR_API int mbsr_parameters_count(const mbsr_parameters *list); /* -1 for NULL */

/* The first parameter of that name, or MBSR_NONE. Looks at one after the other. */
MBSR_API int mbsr_parameters_find(const mbsr_parameters *list, const char *name);

/* MBSR_ERR_NULL, MBSR_ERR_ID for a parameter that does not exist. */
MBSR_API int mbsr_parameter_get(const mbsr_parameters *list, int parameter, mbsr_parameter *out);

/* A finished model in which parameter which[k] has the value value[k], k = 0 .. count-1, and
 * everything else is as in the model of the list; ids of parts are the same, and so are places in q
 * and u. Of a parameter that comes twice the later value counts. Time and memory are those of
 * mbsr_model_copy and mbsr_model_finish. The model is the caller's and independent of the list;
 * tables that were changed are its own.
 *
 * Centres and tensors that change lose further digits (`exact` of mbsr_inertia). The three
 * armatures of a quaternion are given together. On failure *model is NULL and the reason in *error
 * (which may be NULL): MBSR_ERR_NULL, MBSR_ERR_ID (which[k]), MBSR_NOT_FINITE (value[k]); statuses
 * with which mbsr_model_add_body, mbsr_model_add_force, mbsr_model_add_closure,
 * mbsr_model_armature, mbsr_table_create and mbsr_model_finish refuse the part, which the text
 * names. */
MBSR_API int mbsr_parameters_model(const mbsr_parameters *list, int count, const int *which,
                                   const double *value, mbsr_model **model, mbsr_error *error);

/* Data that own such a model: mbsr_data_model is what is given to functions beside them, and
 * objects are made of, such as Newton solvers and drivers, which end before the data do. Freed by
 * mbsr_data_destroy. Statuses of mbsr_parameters_model and mbsr_data_create. */
MBSR_API int mbsr_parameters_data(const mbsr_parameters *list, int count, const int *which,
                                  const double *value, mbsr_data **data, mbsr_error *error);

/* The model that data belong to: the one they were made of, or their own; NULL for NULL. */
MBSR_API const mbsr_model *mbsr_data_model(const mbsr_data *data);

#ifdef __cplusplus
}
#endif

#endif

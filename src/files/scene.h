/* What the readers make of a file, before it becomes a model.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_SCENE_H
#define MBSRI_FILES_SCENE_H

#include "files/arena.h"
#include "files/path.h"
#include "files/xml.h"

#include <mbsrank/files.h>

enum { MBSRI_POWERS = 5, MBSRI_TERMS = 10 };

/* A joint of the file; axis and anchor in the body that it carries. */
typedef struct mbsri_scene_joint {
    mbsr_file_joint joint; /* body and places are set when the model is made */
    const mbsri_element *element;
    double axis[3], anchor[3];
    double pitch; /* of a hinge that is a screw, m/rad */
    double stiffness, cubic, rest, damping, armature;
    bool force_limited; /* what actuators do, in sum */
    double force_range[2];
    double limit_reference[2], limit_impedance; /* solreflimit, the largest of solimplimit */
    bool relative; /* a free joint that counts from where its body is drawn, not from its parent */
} mbsri_scene_joint;

typedef struct mbsri_scene_body {
    const char *name;
    const mbsri_element *element;
    int parent;       /* index among the bodies; -1: the world */
    mbsr_frame frame; /* in the parent, as drawn */
    mbsr_inertia inertia;
    double weightless; /* part of its weight that something carries */
    int first, joints; /* its joints */
    int id;            /* in the model */
} mbsri_scene_body;

/* sum of factor times coordinate of joints */
typedef struct mbsri_scene_sum {
    int count, joint[MBSRI_TERMS];
    double factor[MBSRI_TERMS];
} mbsri_scene_sum;

typedef struct mbsri_scene_tendon {
    const char *name;
    const mbsri_element *element;
    mbsri_scene_sum sum;              /* of a fixed tendon */
    int count, site[MBSRI_PATH_MOST]; /* of one in space, from site to site */
    double stiffness, damping;
    double rest[2];     /* no force between; NaN: as in the pose of rest */
    bool force_limited; /* what actuators do, in sum */
    double force_range[2];
} mbsri_scene_tendon;

typedef struct mbsri_scene_actuator {
    mbsr_file_actuator actuator;
    const mbsri_element *element;
    mbsri_scene_sum sum; /* empty: it does not act on joints */
    int tendon, site;    /* what else it acts on; -1: not on one. On nothing: it is left out */
    double gear[6];      /* on a site */
} mbsri_scene_actuator;

typedef enum mbsri_scene_equality_kind {
    MBSRI_CONNECT,
    MBSRI_WELD,
    MBSRI_POLYNOMIAL,
    MBSRI_SUM
} mbsri_scene_equality_kind;

typedef struct mbsri_scene_equality {
    mbsri_scene_equality_kind kind;
    const char *name;
    const mbsri_element *element;
    int body[2];      /* indices, -1: the world */
    double anchor[3]; /* in body 0 */
    bool placed;      /* `frame` is given; else that of the pose as drawn */
    mbsr_frame frame; /* of body 1 in body 0 */
    bool at_sites;    /* the frames `end` of both bodies, or their origins, coincide */
    mbsr_frame end[2];
    mbsri_scene_sum sum; /* as drawn it is right with `offset` */
    double offset;
    int joint[2]; /* q0 - ref0 = polynomial of (q1 - ref1); second -1: of 0 */
    double power[MBSRI_POWERS];
} mbsri_scene_equality;

typedef struct mbsri_scene_key {
    mbsr_file_key key;
    const mbsri_element *element;
    const char *position, *velocity, *control; /* as in the file, NULL: not given */
} mbsri_scene_key;

typedef struct mbsri_scene {
    mbsri_arena *arena;
    const mbsr_file_opt *opt;
    mbsr_file_format format;
    const char *name, *home; /* folder of the file, with its slash */
    double gravity[3];
    bool with_passive, with_closures,
        with_actuators;              /* as the options, unless the file switches them off */
    bool with_limits, with_friction; /* unless the file switches them off */
    mbsri_list bodies, joints, tendons, actuators, equalities, keys, sites, sensors, shapes,
        excludes, pairs, hulls, /* excludes: two ints each; hulls: what hulls.c has made */
        findings;
    char message[MBSR_TEXT_SIZE]; /* why the file is refused; "": it is not */
} mbsri_scene;

/* Refuses the file: names file, line and element; keeps the first reason. Always false. */
bool mbsri_file_refuse(mbsri_scene *s, const mbsri_element *e, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Lists something that the model does not have. */
void mbsri_file_find(mbsri_scene *s, const mbsri_element *e, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static inline mbsri_scene_body *mbsri_scene_bodies(const mbsri_scene *s)
{
    return s->bodies.items;
}

static inline mbsri_scene_joint *mbsri_scene_joints(const mbsri_scene *s)
{
    return s->joints.items;
}

/* Numbers of an attribute, which if it is missing stay as they are; false: refused. How many stood
 * there goes to *count, which may be NULL. */
bool mbsri_numbers(mbsri_scene *s, const mbsri_element *e, const char *attribute, const char *value,
                   int least, int most, double *to, int *count);

/* The readers. False: refused, or no memory. */
bool mbsri_urdf_read(mbsri_scene *s, const mbsri_element *root);
bool mbsri_mjcf_read(mbsri_scene *s, mbsri_element *root);
bool mbsri_sdf_read(mbsri_scene *s, const mbsri_element *root);

/* Whether it is the root of a file of SDF: <sdf>, or <gazebo> with a version. */
bool mbsri_sdf_is_root(const mbsri_element *e);

/* The text of errno that a load function has returned; "" where that says nothing. */
const char *mbsri_file_why(int reason);

/* Whether a joint has one axis: a hinge or a slide. */
static inline bool mbsri_has_axis(const mbsr_file_joint *j)
{
    return j->kind == MBSR_FILE_HINGE || j->kind == MBSR_FILE_SLIDE;
}

#endif

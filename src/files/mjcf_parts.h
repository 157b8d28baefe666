/* What the parts of the reader of MJCF share.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_MJCF_PARTS_H
#define MBSRI_FILES_MJCF_PARTS_H

#include "files/looks.h"
#include "files/names.h"
#include "files/scene.h"

/* A class of defaults. */
typedef struct mbsri_class {
    const char *name; /* of the main one NULL */
    const struct mbsri_class *parent;
    struct mbsri_class *next; /* of all classes */
    mbsri_list elements;      /* const mbsri_element *: <default>, several perhaps */
} mbsri_class;

typedef enum mbsri_from_shapes {
    MBSRI_SHAPES_NEVER,
    MBSRI_SHAPES_ALWAYS,
    MBSRI_SHAPES_AUTO
} mbsri_from_shapes;

typedef struct mbsri_mjcf {
    mbsri_scene *s;
    bool radian, autolimits;
    char sequence[4]; /* of Euler angles */
    mbsri_from_shapes from_shapes;
    double groups[2];     /* of shapes that count for inertias */
    const char *home;     /* folder of the file, with its slash */
    const char *folder;   /* of meshes; NULL: none */
    bool strip;           /* names of files go without their folders */
    mbsri_class *classes; /* the last one made */
    mbsri_list meshes;
    mbsri_looks materials, textures;
    mbsri_names bodies, joints, sites;
} mbsri_mjcf;

/* An element with its class, from which it has what it does not say itself. */
typedef struct mbsri_node {
    const mbsri_element *e;
    const char *kind; /* its name among the defaults; NULL: it has none */
    const mbsri_class *class;
    const char *const
        *alike; /* kinds whose defaults count, too, NULL behind the last; NULL: none */
} mbsri_node;

/* The class of that name, NULL for the main one; NULL: none. */
mbsri_class *mbsri_mjcf_class(const mbsri_mjcf *m, const char *name);

/* childclass: of the bodies around it; NULL: none. False: there is no such class. */
bool mbsri_mjcf_node(mbsri_mjcf *m, const mbsri_element *e, const char *kind,
                     const char *childclass, mbsri_node *node);

/* NULL: nobody says so. */
const char *mbsri_mjcf_get(const mbsri_node *node, const char *attribute);
bool mbsri_mjcf_numbers(mbsri_mjcf *m, const mbsri_node *node, const char *attribute, int least,
                        int most, double *to, int *count);
bool mbsri_mjcf_number(mbsri_mjcf *m, const mbsri_node *node, const char *attribute, double *to);

/* Whether an attribute that is on, off or (`automatic`) missing or "auto". */
bool mbsri_mjcf_switch(const mbsri_node *node, const char *attribute, bool automatic);

/* pos and the orientation in all its spellings. */
bool mbsri_mjcf_frame(mbsri_mjcf *m, const mbsri_node *node, mbsr_frame *frame);

/* z along a direction by the shortest turn. */
mbsr_frame mbsri_mjcf_along(const double x[3], const double z[3]);

/* The parts of a file. */
bool mbsri_mjcf_world(mbsri_mjcf *m, const mbsri_element *world);
bool mbsri_mjcf_equalities(mbsri_mjcf *m, const mbsri_element *list);
bool mbsri_mjcf_tendons(mbsri_mjcf *m, const mbsri_element *list);
bool mbsri_mjcf_actuators(mbsri_mjcf *m, const mbsri_element *list);

#endif

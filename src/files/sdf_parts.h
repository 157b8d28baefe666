/* What the parts of the reader of SDF share.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_SDF_PARTS_H
#define MBSRI_FILES_SDF_PARTS_H

#include "files/names.h"
#include "files/scene.h"

typedef enum mbsri_sdf_kind {
    MBSRI_SDF_MODEL,
    MBSRI_SDF_LINK,
    MBSRI_SDF_JOINT,
    MBSRI_SDF_FRAME
} mbsri_sdf_kind;

/* Something that has a pose. */
typedef struct mbsri_sdf_node {
    mbsri_sdf_kind kind;
    const char *name; /* with the names of its models before it, model::link */
    const mbsri_element *element;
    int model;                 /* the node in which it stands; -1: the world */
    int version;               /* x of SDF 1.x, of its file */
    const mbsri_element *pose; /* <pose>; NULL: none */
    const char *placement;     /* of a model: the frame that its pose places; NULL: its own */
    bool fixed;                /* a model that does not move, or part of one */
    int canonical;             /* of a model: its first link; -1: it has none */
    enum { MBSRI_SDF_NEW, MBSRI_SDF_OPEN, MBSRI_SDF_KNOWN } state; /* of its frame */
    mbsr_frame frame;                                              /* in that of its model */
    int end[2];  /* of a joint: links of parent and child; -1: the world */
    int body;    /* of a link: its index in the scene; -1: not yet */
    int carrier; /* of a link: the joint that carries it; -1: none */
} mbsri_sdf_node;

typedef struct mbsri_sdf {
    mbsri_scene *s;
    mbsri_list nodes;  /* in the order of the file, models before what stands in them */
    mbsri_names names; /* nodes */
    int depth, files;  /* of those that include each other, and how many */
    int version;       /* x of SDF 1.x, of the file that is read */
    bool alone;        /* the file is one model, whose name is left out of others */
} mbsri_sdf;

static inline mbsri_sdf_node *mbsri_sdf_nodes(const mbsri_sdf *f)
{
    return f->nodes.items;
}

/* Numbers in a child of an element, which if it is missing stay as they are; false: refused. */
bool mbsri_sdf_numbers(mbsri_scene *s, const mbsri_element *e, const char *child, int count,
                       double *to);

/* A switch, and its value where it is missing. */
bool mbsri_sdf_switch(const mbsri_element *e, const char *child, bool missing);

/* The numbers of a <pose>, NULL: the identity. What it is relative to does not count. */
bool mbsri_sdf_read_pose(mbsri_scene *s, const mbsri_element *pose, mbsr_frame *frame);

/* A finding for each element that nobody reads and that may matter. */
void mbsri_sdf_find_words(mbsri_scene *s, const mbsri_element *root);

/* ---- frames ---- */

/* The name of a model that stands alone. */
#define MBSRI_SDF_ALONE "__model__"

/* A name inside of a model (-1: the world) with those of its models before it; NULL: no memory. */
const char *mbsri_sdf_full_name(const mbsri_sdf *f, int model, const char *name);

/* The node that a name means inside of a model (-1: the world); -1: none. */
int mbsri_sdf_find(const mbsri_sdf *f, int model, const char *name);

/* Where a name is, as seen from a model; "" and NULL: that model itself. e: who asks. */
bool mbsri_sdf_place(mbsri_sdf *f, const mbsri_element *e, int model, const char *name,
                     mbsr_frame *frame);

/* Where a node is in the world. */
bool mbsri_sdf_world(mbsri_sdf *f, int node, mbsr_frame *frame);

/* The link that a name is fixed to, -1: the world. */
bool mbsri_sdf_link(mbsri_sdf *f, const mbsri_element *e, int model, const char *name, int *link);

/* ---- the parts ---- */

/* The joints of a node into the scene, for the body with that frame in the world, which it carries.
 */
bool mbsri_sdf_joints(mbsri_sdf *f, int node, const mbsr_frame *body);

/* The direction of an axis of a joint along the axes of a body with that frame in the world. */
bool mbsri_sdf_direction(mbsri_sdf *f, int node, const mbsri_element *axis, const mbsr_frame *body,
                         double direction[3]);

/* Whether it relates the angles of others, and joins nothing. */
bool mbsri_sdf_is_gear(const mbsri_sdf_node *n);

/* Joints that follow others, once all are there. */
bool mbsri_sdf_relations(mbsri_sdf *f);

bool mbsri_sdf_inertia(mbsri_sdf *f, const mbsri_element *link, mbsr_inertia *inertia);
bool mbsri_sdf_shapes(mbsri_sdf *f, int link, const mbsr_frame *world, int body);

/* Bodies, and the joints that close loops, from all nodes. */
bool mbsri_sdf_tree(mbsri_sdf *f);

#endif

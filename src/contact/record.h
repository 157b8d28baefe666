/* Shapes as the component keeps them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CONTACT_RECORD_H
#define MBSRI_CONTACT_RECORD_H

#include <mbsrank/contact.h>

#include <stdbool.h>

enum { MBSRI_SHAPE_NAME = 48 };

/* The core of a shape, which its surface keeps the distance `radius` from: corners, edges and faces
 * of a convex body (of points and segments there are fewer), or what `kind` says. */
typedef struct mbsri_core {
    double radius;
    int corners, edges, faces;
    const double (*corner)[3];
    const int (*edge)[2];
    const double (*side)[2][3]; /* of an edge between faces: into each of them, unit; or NULL */
    const double (*face)[4];    /* unit normal; its product with the points of the plane */
    const int (*triangle)[3];   /* of each face; NULL: the core is a box */
    double half[3];             /* box, cylinder (radius, half length), ellipsoid */
} mbsri_core;

typedef struct mbsri_field mbsri_field; /* field.h */

typedef struct mbsri_shape {
    char name[MBSRI_SHAPE_NAME];
    int id, body, place; /* place: of the body in the element's list */
    int part, carrier;   /* bodies: the first that is rigidly joined; that of the part below */
    mbsr_shape_kind kind;
    double R[9], x[3];           /* in the body */
    double middle[3], extent[3]; /* of a box around all of it, in the shape's frame */
    double ball;                 /* radius of one about the middle around all of it */
    unsigned groups, mask;
    mbsr_contact_law law;
    double margin; /* the largest that it has in a law, from when the element is made */
    mbsri_core core;
    const mbsri_field *field; /* HEIGHTS, else NULL */
    void *memory;             /* of the core */
} mbsri_shape;

struct mbsr_contacts {
    int count, room, given_room;
    mbsri_shape *shape;
    mbsr_shape *given; /* as they were added, with names and arrays of their own */
    int excluded, excluded_room;
    int (*exclude)[2]; /* bodies, the smaller id first */
    int joined_bodies;
    int (*joined)[2]; /* by bodies of the model: part and carrier as of a shape; or NULL */
    int couples, couples_room;
    mbsr_shape_pair *couple; /* a < b */
    /* from here on set when the element is made */
    bool made;
    int bodies, grounds, most; /* grounds: shapes that only the ground has; most: pairs of shapes */
    int *body;                 /* ids */
    int *first;                /* bodies + 1: of the shapes of each in `member` */
    int *member;
};

/* Planes and height fields are on the ground, and solid all the way down. */
static inline bool mbsri_is_ground(mbsr_shape_kind kind)
{
    return kind == MBSR_SHAPE_PLANE || kind == MBSR_SHAPE_HEIGHTS;
}

static inline bool mbsri_by_groups(const mbsri_shape *x, const mbsri_shape *y)
{
    return (x->groups & y->mask) != 0 || (y->groups & x->mask) != 0;
}

/* Of law.c: the order of couples, in which they stand once the element is made, and of excluded
 * bodies; the couple of shapes a < b, or NULL; whether shapes may touch, and by which law. */
int mbsri_compare_couples(const void *x, const void *y);
int mbsri_compare_excluded(const void *x, const void *y);
const mbsr_shape_pair *mbsri_find_couple(const mbsr_contacts *c, int a, int b);
bool mbsri_may_touch(const mbsr_contacts *c, int a, int b);
mbsr_contact_law mbsri_law_of_shapes(const mbsr_contacts *c, int a, int b);

/* The element's table. */
extern const mbsr_force_table mbsri_contacts_table;

#endif

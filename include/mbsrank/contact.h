/* Contact between bodies: shapes that find each other (component contact).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Shapes are added to an object, which then makes one force element of them all. The element acts
 * between two bodies where their shapes touch, at several points where faces lie on each other.
 * Bodies are SPATIAL, or the ground. docs/contact.md has laws, cost and limits. */
#ifndef MBSRANK_CONTACT_H
#define MBSRANK_CONTACT_H

#include <mbsrank/dynamics.h>
#include <mbsrank/force.h>
#include <mbsrank/model.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Where two surfaces have passed each other by the depth x > 0 (m), with the rate x', the normal
 * force is
 *
 *   N = stiffness x^exponent (1 + damping x'), never negative
 *
 * (Hunt and Crossley, 1975), and with the velocity v that slides and the angular velocity w of one
 * body relative to the other, in its parts along the normal and across, wn and wt, there act
 *
 *   friction N v / sqrt(|v|^2 + slip^2)             against v,
 *   torsional N wn / sqrt(wn^2 + spin^2)            against wn, a moment,
 *   rolling N wt / sqrt(|wt|^2 + spin^2)            against wt, likewise.
 *
 * Of the laws of two shapes the stiffnesses act one behind the other, k = ka kb / (ka + kb), and
 * margins add up; of the other numbers the larger counts. */
typedef struct mbsr_contact_law {
    double stiffness; /* N/m^exponent, > 0; INFINITY: that of the other shape counts */
    double exponent;  /* >= 1; default 1.5 */
    double damping;   /* s/m, >= 0; about 3/2 (1 - e) / v makes e the restitution at the speed v */
    double friction;  /* >= 0 */
    double slip;      /* m/s, > 0 where there is friction */
    double torsional, rolling; /* m, >= 0 */
    double spin;               /* rad/s, > 0 where one of these is not zero */
    double margin;             /* m, >= 0; x counts from where the surfaces are that far apart */
} mbsr_contact_law;

/* A shape; copied when it is added. */
typedef struct mbsr_shape {
    int cookie;           /* set by mbsr_default_shape */
    const char *name;     /* for messages; NULL: none */
    int body;             /* id, or MBSR_GROUND (default) */
    mbsr_shape_kind kind; /* default: a box, which has no size yet */
    mbsr_frame frame;     /* in the body; default: the body's own */
    double size[3];       /* m, > 0; spatial.h */
    /* Radius to which edges and corners of boxes, cylinders and meshes are rounded, m; 0 (default):
     * a 20th of the least size, a 50th of the distance from its centre to its farthest corner for a
     * mesh. Of a box or cylinder it comes off the edges; a mesh is larger by it all round. A depth
     * beyond the sum of both shapes' is still found, but its normal may jump. */
    double rounding;
    int vertices, triangles; /* MESH: their numbers */
    const double *vertex;    /* 3 a vertex, m, in the shape's frame */
    const int *triangle;     /* 3 a triangle, counter-clockwise from outside */
    /* HEIGHTS: samples along y and x, 2 or more each, over the rectangle of `size`, and heights
     * along z, m, row by row; first that of the least y, in it that of the least x. The surface is
     * smooth (docs/contact.md). */
    int rows, columns;
    const double *height;
    /* Two shapes touch where one's groups and the other's mask have a bit in common; default 1
     * and 1. */
    unsigned groups, mask;
    mbsr_contact_law
        law; /* default: stiffness INFINITY, exponent 1.5, slip 1e-3, spin 1e-2, else zero */
} mbsr_shape;

MBSR_API mbsr_shape mbsr_default_shape(void);

/* All shapes of a model. */
typedef struct mbsr_contacts mbsr_contacts;

/* MBSR_ERR_NULL, MBSR_ERR_NO_MEMORY; `error` may be NULL here and below. */
MBSR_API int mbsr_contacts_create(mbsr_contacts **contacts, mbsr_error *error);

/* Behind all models that the element was added to, and their data. NULL is accepted. */
MBSR_API void mbsr_contacts_destroy(mbsr_contacts *contacts);

/* Adds a shape; *id (may be NULL) counts from 0. Refused by name: sizes that are not positive and
 * finite, frames that are not right-handed and orthonormal to 1e-6, laws out of range, meshes that
 * are open, flat or not convex to 1e-6 of their size, height fields of less than 2 x 2 samples or
 * with heights that are not finite, planes and height fields that are not on the ground.
 * MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE, MBSR_ERR_ID, MBSR_ERR_FINISHED (the element
 * has been made), MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_contacts_add(mbsr_contacts *contacts, const mbsr_shape *shape, int *id,
                               mbsr_error *error);

/* Shapes of two bodies never touch; shapes of one body never do, nor two of the ground.
 * MBSR_ERR_NULL, MBSR_ERR_ID, MBSR_ERR_FINISHED, MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_contacts_exclude(mbsr_contacts *contacts, int body_a, int body_b,
                                   mbsr_error *error);

/* Two shapes of different bodies touch by a law of their own, whatever their groups are and even
 * where their bodies are excluded; law NULL: they never touch. Two shapes that have a law twice are
 * refused by mbsr_contacts_force. MBSR_ERR_NULL, MBSR_ERR_ID,
 * MBSR_ERR_VALUE, MBSR_ERR_FINISHED, MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_contacts_pair(mbsr_contacts *contacts, int shape_a, int shape_b,
                                const mbsr_contact_law *law, mbsr_error *error);

/* Which bodies hang together: joined has two ids for each body of the model, the first of those
 * that are welded to each other, and that of those which carry them, MBSR_NONE where the ground
 * does. Bodies of which the first is the same never touch, nor do those of which one carries the
 * other. In the place of what was given before. MBSR_ERR_NULL, MBSR_ERR_VALUE, MBSR_ERR_FINISHED,
 * MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_contacts_join(mbsr_contacts *contacts, int bodies, const int *joined,
                                mbsr_error *error);

typedef struct mbsr_file mbsr_file; /* files.h */

/* What mbsr_contacts_add_file has done. */
typedef struct mbsr_contacts_of_file {
    int shapes;       /* that were added */
    int left_out;     /* planes and height fields that move, meshes without a hull (hull_corners of
                         files.h), and what has a size of zero */
    double stiffness; /* N/m of each shape */
} mbsr_contacts_of_file;

/* The shapes for contact of a file (component files): with its groups, frictions, pairs and
 * excluded bodies; meshes by their hulls. `model` is finished and has the file's bodies. Bodies
 * that a joint connects never touch, bodies without shapes between them left aside; nor do those
 * that are welded to each other. Planes and height fields of what is welded to the ground are the
 * ground's. Laws are linear: stiffness (0: 2 m / (T z)^2 with the file's
 * time T and damping z, so that two shapes make half of that; m is the mass of all that moves, at
 * most ten times that of the heaviest tree, and 1 kg where nothing has mass), and a damping with
 * which what weighs m comes to rest within about T. *told may be NULL. MBSR_ERR_NULL,
 * MBSR_ERR_VALUE, MBSR_ERR_UNFINISHED, statuses of mbsr_contacts_add. */
MBSR_API int mbsr_contacts_add_file(mbsr_contacts *contacts, const mbsr_file *file,
                                    const mbsr_model *model, double stiffness,
                                    mbsr_contacts_of_file *told, mbsr_error *error);

/* What mbsr_contacts_attach has made. */
typedef struct mbsr_touching {
    mbsr_contacts *contacts; /* NULL: no shape touches. To be destroyed behind the model */
    mbsr_model *model;       /* finished; NULL likewise. To be destroyed */
    int force;               /* the element */
    mbsr_contacts_of_file told;
    int bodies; /* pairs of bodies, neither of them the ground, that are drawn into each other */
    int shapes; /* pairs of shapes of the ground and of what a joint holds to it, likewise */
} mbsr_touching;

/* A copy of a model of a file with the element of mbsr_contacts_add_file, whose laws are by the
 * masses of another one, finished and with the same bodies (masses; NULL: of the model). What is
 * drawn into each other at q (nq), so that two shapes press with more than the weight of all
 * bodies, never touches. On failure nothing is left. MBSR_ERR_NULL, MBSR_ERR_NO_MEMORY, statuses of
 * mbsr_contacts_add_file, mbsr_model_finish and mbsr_stage_positions. */
MBSR_API int mbsr_contacts_attach(const mbsr_file *file, const mbsr_model *masses,
                                  const mbsr_model *model, const double *q, double stiffness,
                                  mbsr_touching *made, mbsr_error *error);

/* The element of all shapes, to be added to a model by mbsr_model_add_force; no shape can be added
 * then. max_pairs: shapes that are near each other at a time, at most, for which data set memory
 * aside; 0: 16 for each shape and 64 more. More of them end an evaluation with MBSR_ERR_MEMORY_SIZE
 * and the names of the two. Refused by name: shapes that may touch but have no
 * stiffness. MBSR_ERR_NULL, MBSR_ERR_VALUE, MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_contacts_force(mbsr_contacts *contacts, int max_pairs, mbsr_force_def *force,
                                 mbsr_error *error);

/* Two shapes with a law of their own. */
typedef struct mbsr_shape_pair {
    int a, b;  /* shapes, a < b */
    int never; /* 1: they never touch, and the law does not count */
    mbsr_contact_law law;
} mbsr_shape_pair;

/* An object as it was given: mbsr_contacts_add, _exclude, _pair and _join with these make another
 * one of the same forces. */
typedef struct mbsr_contacts_def {
    int shapes, excluded, pairs, bodies;
    int max_pairs; /* of mbsr_contacts_force, or fewer where fewer may touch; 0: not made, or none
                    */
    const mbsr_shape *shape;
    const int *exclude; /* two bodies each */
    const mbsr_shape_pair *pair;
    const int *joined; /* two for each of `bodies` */
} mbsr_contacts_def;

/* Pointers are into *contacts, valid until something is added. MBSR_ERR_NULL. */
MBSR_API int mbsr_contacts_definition(const mbsr_contacts *contacts, mbsr_contacts_def *def);

/* The table of elements that mbsr_contacts_force makes; their user is the object. */
MBSR_API const mbsr_force_table *mbsr_contacts_table(void);

/* One point at which two shapes touch, along the axes of the world. */
typedef struct mbsr_contact_point {
    int shape_a, shape_b; /* ids, a before b */
    int body_a, body_b;   /* ids, or MBSR_GROUND */
    double point[3];      /* m, halfway between both surfaces */
    double normal[3];     /* from b to a */
    double depth, rate;   /* m, m/s */
    double normal_force;  /* N on a along the normal */
    double friction[3];   /* N on a */
    double moment[3];  /* N m on a, by torsional and rolling friction, and of a cylinder on a plane
                          by its weights */
    double sliding[3]; /* m/s, of a over b */
} mbsr_contact_point;

/* The points of an element at the state of mbsr_stage_velocities, by shapes, the first `most` of
 * them (0: none is wanted) to `points`, and how many there are. MBSR_ERR_NULL, MBSR_ERR_ID,
 * MBSR_ERR_VALUE (the element is not one of shapes), MBSR_NOT_FINITE; what evaluations return. */
MBSR_API int mbsr_contact_report(const mbsr_model *model, mbsr_data *data, int force, int most,
                                 mbsr_contact_point *points, int *count);

#ifdef __cplusplus
}
#endif

#endif

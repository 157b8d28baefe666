/* Small trees of all kinds of bodies on a moving root: joints with quaternions, driven and locked
 * coordinates, a weld, general bodies with K other than the unit matrix, masses of every sort.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_MIXED_H
#define TEST_MIXED_H

#include "expect.h"

enum { MIXED_BODIES = 8, MIXED_NQ = 28, MIXED_NU = 24 };

typedef enum mixed_scene {
    MIXED_SPACE,  /* bodies in space on a moving root in space */
    MIXED_PLANE,  /* points, bodies in the plane and in space on a moving root in the plane */
    MIXED_ARM,    /* rigid bodies and stock joints on a root at rest, no applied forces */
    MIXED_SCENES, /* number of the above, which have no general body */
    MIXED_GENERAL = MIXED_SCENES, /* SPACE and one general body */
    MIXED_GENERAL_PLANE,          /* PLANE and one general body */
    MIXED_ALL
} mixed_scene;

/* What a body was made of, as the test knows it. */
typedef struct mixed_body {
    int id, parent;
    mbsr_space space;
    int d, np;
    double M[36]; /* d x d; SPATIAL and PLANAR: about the origin, along the body's axes */
    int loaded;   /* mixed_load acts on it */
} mixed_body;

typedef struct mixed {
    mixed_scene scene;
    mbsr_model *model;
    mbsr_data *data;
    int bodies, nq, nu, root_d;
    mixed_body body[MIXED_BODIES];
} mixed;

/* The structure must stay where it is until it is freed. */
void mixed_make(mixed *s, mixed_scene scene);
void mixed_free(mixed *s);

/* What the applied force on a loaded body is: n numbers. */
void mixed_load(int id, double t, int n, double *value);

/* A spring on this joint coordinate of this body: stiffness, damping, rest. */
enum { MIXED_SPRUNG_BODY = 1, MIXED_SPRUNG = 0 };
extern const double mixed_spring[3];

/* c += a x b */
void mixed_cross(const double a[3], const double b[3], double c[3]);

#endif

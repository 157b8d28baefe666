/* Stiff trees with parts without mass, described without reference to any library, so that each can
 * build the same: a beam, a cable, a vehicle, random trees.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef STIFF_H
#define STIFF_H

#ifdef __cplusplus
extern "C" {
#endif

enum { STIFF_GROUND = -1, STIFF_AXES = 3 };

/* A joint is a sequence of axes, each moving what follows it, with a spring-damper in each. */
typedef struct stiff_axis {
    int turns;           /* 1: rotation (rad), 0: translation (m) */
    double direction[3]; /* unit vector along the axes of the predecessor, as moved by the axes
                          * before */
    double stiffness, damping, rest, start;
} stiff_axis;

typedef struct stiff_body {
    int parent;      /* STIFF_GROUND or an earlier body */
    double place[3]; /* of the body's origin in the predecessor, all axes at zero, m; orientations
                      * are the same there */
    int free;        /* 1: moves freely, no axes */
    int axes;
    stiff_axis axis[STIFF_AXES];
    double mass, com[3], tensor[6]; /* kg; m; kg m^2 about com: xx yy zz xy xz yz */
} stiff_body;

/* A ball joint with rubber: three linear spring-dampers of free length `length` from the points
 * at_a - length e_k of body a, e_k along its axes, to the point at_b of body b. They are without
 * force where at_a and at_b meet. */
typedef struct stiff_ball {
    int a, b;
    double at_a[3], at_b[3], stiffness, damping, length;
} stiff_ball;

typedef struct stiff_model {
    char name[32];
    int chain;    /* 1: each body hangs on the one before, with its mass at its outer end */
    int in_plane; /* 1: everything stays in the x-y plane and may be built there */
    int bodies, massless, balls, loads;
    stiff_body *body;
    stiff_ball *ball;
    int *load;         /* bodies on which `force` acts */
    double load_at[3]; /* where: in body axes */
    /* Force (N, world) on load k, of position and velocity of that point (world). */
    void (*force)(int k, double t, const double *p, const double *v, double *f);
    double gravity[3];
    double T;                      /* s, end of the run */
    double mass_size, moment_size; /* kg, kg m^2: of a typical body, for those who need a little */
} stiff_model;

/* The beam of the Test Set for IVP Solvers with n rods, 1 m and 1 kg (docs/dae_forms.md): rods
 * without mass, a particle at the outer end of each, k = n N m/rad in the joints (2 n in the
 * first), so that the fastest of its modes has 4 n^2 rad/s. Unlike there the joints are damped, by
 * 1e-3 s times their stiffness: a mode of frequency w by 5e-4 s w of what is critical, 0.2 % for
 * the slowest, and the fast ones do not vibrate. Without damping they would have to be followed, or
 * a method of order 2 used: those of higher order are unstable for them. */
void stiff_beam(stiff_model *s, int n);

/* A steel rope of 10 m, 2 kg and 0.5 N m^2 hangs from a clamp; its end is pulled to one side and to
 * another. n massless segments on universal joints with springs and damping of 1e-2 s times their
 * stiffness, particles at the ends of the segments. */
void stiff_cable(stiff_model *s, int n);

/* A car over a bump: chassis, four wheels, 50 links without mass. */
void stiff_vehicle(stiff_model *s);

/* A random tree, each body hung on any of those before it: of each three bodies the first has no
 * mass and turns about the same axis as the second, which rides on it alone: two springs-dampers in
 * series. Stiffnesses over four decades. */
void stiff_tree(stiff_model *s, int n);

void stiff_free(stiff_model *s);

#ifdef __cplusplus
}
#endif

#endif

/* Inertia of one body: any symmetric positive semi-definite mass matrix, zero included.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_INERTIA_H
#define MBSRANK_INERTIA_H

#include <mbsrank/base.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum mbsr_inertia_kind {
    MBSR_INERTIA_NOT_GIVEN = 0, /* counts as zero; told apart from a zero that somebody stated */
    MBSR_INERTIA_PARTICLE = 1,
    MBSR_INERTIA_PLANAR = 2,
    MBSR_INERTIA_MATRIX = 3,
    MBSR_INERTIA_FUNCTION = 4
} mbsr_inertia_kind;

/* A mass matrix that depends on the pose. Writes M (d x d, column-major, symmetric positive
 * semi-definite) and the gyroscopic force h (d) of M A + h = f; both arrive set to zero. Returns 0
 * or a status as in mbsr_joint_table. */
typedef int (*mbsr_inertia_fn)(void *user, double t, const double *p, const double *V, double *M,
                               double *h);

/* An inertia as a value; made by a constructor below, copied into the model. */
typedef struct mbsr_inertia {
    mbsr_inertia_kind kind;
    double mass;          /* kg */
    double com[2];        /* m, centre of mass in body axes (PLANAR) */
    double moment;        /* kg m^2 about the centre of mass (PLANAR) */
    int d;                /* size of matrix (MATRIX) */
    const double *matrix; /* d x d, copied by mbsr_model_add_body (MATRIX) */
    mbsr_inertia_fn function;
    void *user; /* for function; not copied, may be NULL */
} mbsr_inertia;

/* Zero, stated. Any space. */
MBSR_API mbsr_inertia mbsr_inertia_zero(void);

/* A particle at the body's origin. POINT and PLANAR bodies. mass >= 0 kg. */
MBSR_API mbsr_inertia mbsr_inertia_particle(double mass);

/* A rigid body in the plane. PLANAR bodies. mass >= 0 kg, com in m in body axes, moment >= 0 kg m^2
 * about com. */
MBSR_API mbsr_inertia mbsr_inertia_planar(double mass, const double com[2], double moment);

/* A constant mass matrix: symmetric, positive semi-definite, d x d. Any space. `matrix` must stay
 * valid until the body is added. */
MBSR_API mbsr_inertia mbsr_inertia_matrix(int d, const double *matrix);

/* A mass matrix by function. Any space. */
MBSR_API mbsr_inertia mbsr_inertia_function(mbsr_inertia_fn function, void *user);

#ifdef __cplusplus
}
#endif

#endif

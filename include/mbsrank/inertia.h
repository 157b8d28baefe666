/* Inertia of one body: any symmetric positive semi-definite mass matrix, zero included.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * M is d x d. Of a rigid body in space it is the spatial inertia, about the body's origin and along
 * the world axes: with the mass m, the first moment s = m (centre of mass - origin) and the tensor
 * I about the origin,
 *
 *   M = [ I  [s]x ; -[s]x  m 1 ]
 *   M A + h = wrench,     h = (omega x I omega, omega x (omega x s)) */
#ifndef MBSRANK_INERTIA_H
#define MBSRANK_INERTIA_H

#include <mbsrank/base.h>
#include <mbsrank/spatial.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How an inertia was given. */
typedef enum mbsr_inertia_kind {
    MBSR_INERTIA_INVALID = -1,  /* what a constructor cannot make; refused when a body is added */
    MBSR_INERTIA_NOT_GIVEN = 0, /* counts as zero; told apart from a zero that somebody stated */
    MBSR_INERTIA_PARTICLE = 1,
    MBSR_INERTIA_PLANAR = 2,
    MBSR_INERTIA_MATRIX = 3,
    MBSR_INERTIA_FUNCTION = 4,
    MBSR_INERTIA_SPATIAL = 5,
    MBSR_INERTIA_FLEXIBLE = 6
} mbsr_inertia_kind;

/* Modal data of a flexible body (flex.h). */
typedef struct mbsr_flex mbsr_flex;

/* A mass matrix that depends on the pose. Writes M (d x d, column-major, symmetric positive
 * semi-definite) and the gyroscopic force h (d) of M A + h = f; both arrive set to zero. Returns 0
 * or a status as in mbsr_joint_table. */
typedef int (*mbsr_inertia_fn)(void *user, double t, const double *p, const double *V, double *M,
                               double *h);

/* An inertia as a value; made by a constructor below, copied into the model.
 *
 * Rods, points, solids, and what mbsr_inertia_in_frame and mbsr_inertia_sum make of them, keep
 * their tensor and centre of mass to 32 digits, so that a small moment about one axis beside a
 * large one about others stays what it is. Of tensors given by their entries diagonal ones count as
 * exact, others as rounded: `lost` is their trace then. Who changes com or tensor of an inertia
 * afterwards sets `exact` to 0. */
typedef struct mbsr_inertia {
    mbsr_inertia_kind kind;
    double mass;          /* kg */
    double com[3];        /* m, centre of mass in body axes (PLANAR: x, y; SPATIAL) */
    double moment;        /* kg m^2 about the centre of mass (PLANAR) */
    double tensor[6];     /* kg m^2 about the centre of mass in body axes (SPATIAL), see below */
    int d;                /* size of matrix (MATRIX) */
    const double *matrix; /* d x d, copied by mbsr_model_add_body (MATRIX) */
    mbsr_inertia_fn function;
    void *user;    /* for function; not copied, may be NULL */
    int unchecked; /* 1: the tensor need not be one of a body (SPATIAL), see below */
    int exact;     /* 1: the next three are given (SPATIAL); the constructors below give them */
    double com_rest[3], tensor_rest[6]; /* what rounding com and tensor has left off */
    double lost;           /* kg m^2: the tensor is wrong by this times machine precision */
    const mbsr_flex *flex; /* FLEXIBLE; must outlive the model */
} mbsr_inertia;

/* Zero, stated. Any space. */
MBSR_API mbsr_inertia mbsr_inertia_zero(void);

/* A particle at the body's origin. POINT, PLANAR and SPATIAL bodies. mass >= 0 kg. */
MBSR_API mbsr_inertia mbsr_inertia_particle(double mass);

/* A rigid body in the plane. PLANAR bodies. mass >= 0 kg, com in m in body axes (NULL: the origin),
 * moment >= 0 kg m^2 about com. */
MBSR_API mbsr_inertia mbsr_inertia_planar(double mass, const double com[2], double moment);

/* ---- rigid bodies in space: SPATIAL bodies ----
 *
 * A tensor of inertia is given by its six entries xx, yy, zz, xy, xz, yz in kg m^2. They are those
 * of the matrix: xx = sum of m (y^2 + z^2), xy = -sum of m x y. Parts without mass are allowed
 * everywhere. Refused when the body is added, as no distribution of mass has it: a negative mass;
 * about the centre of mass a principal moment that is negative, or larger than the sum of the other
 * two (by more than 1e-6 of it, so that rounded data pass).
 *
 * A point that is NULL is the body's origin; a tensor or edges that are NULL make an inertia that
 * is refused when the body is added. */

enum { MBSR_XX, MBSR_YY, MBSR_ZZ, MBSR_XY, MBSR_XZ, MBSR_YZ };

/* Mass in kg, centre of mass in m in body axes, tensor about the centre of mass along body axes. */
MBSR_API mbsr_inertia mbsr_inertia_rigid(double mass, const double com[3], const double tensor[6]);

/* The same where the tensor need not be that of a distribution of mass, such as data of another
 * program that violate the triangle inequality of the principal moments: one moment may be larger
 * than the sum of the other two. The mass matrix must still be finite and positive semi-definite:
 * mass and principal moments about the centre of mass are not negative (but for 1e-6 of the largest
 * moment). mbsr_inertia_in_frame and mbsr_inertia_sum keep the licence. */
MBSR_API mbsr_inertia mbsr_inertia_rigid_unchecked(double mass, const double com[3],
                                                   const double tensor[6]);

/* The same as mbsr_inertia_rigid with the tensor about the origin and along the axes of `frame`,
 * which stands in the body (NULL: the body's own frame); com in body axes. */
MBSR_API mbsr_inertia mbsr_inertia_rigid_about(double mass, const double com[3],
                                               const mbsr_frame *frame, const double tensor[6]);

/* A particle at a point of the body, m. */
MBSR_API mbsr_inertia mbsr_inertia_point_mass(double mass, const double at[3]);

/* A thin uniform rod between two points of the body, m. */
MBSR_API mbsr_inertia mbsr_inertia_rod(double mass, const double a[3], const double b[3]);

/* Solids of uniform density (kg/m^3) about the body's origin: a box with edges along the axes, a
 * sphere, a cylinder and a capsule (a cylinder of `length` between two half-spheres) along z. m. */
MBSR_API mbsr_inertia mbsr_inertia_box(double density, const double edges[3]);
MBSR_API mbsr_inertia mbsr_inertia_sphere(double density, double radius);
MBSR_API mbsr_inertia mbsr_inertia_cylinder(double density, double radius, double length);
MBSR_API mbsr_inertia mbsr_inertia_capsule(double density, double radius, double length);

/* An inertia given in `frame`, which stands in the body (NULL: the body's own). PARTICLE, SPATIAL
 * and zero. */
MBSR_API mbsr_inertia mbsr_inertia_in_frame(const mbsr_frame *frame, mbsr_inertia inertia);

/* Both together. PARTICLE, SPATIAL and zero; anything else is refused when the body is added. */
MBSR_API mbsr_inertia mbsr_inertia_sum(mbsr_inertia a, mbsr_inertia b);

/* ---- in general ---- */

/* A constant mass matrix: symmetric, positive semi-definite, d x d. Any space. For a SPATIAL body
 * it is taken along the body's axes and turns with it: M = diag(R, R) matrix diag(R, R)^T, kinetic
 * energy 1/2 V^T M V, and the forces that follow from this energy (Kirchhoff's equations). With its
 * 3 x 3 blocks M = [ Mww Mwv ; Mvw Mvv ] its weight is that of the mass m and first moment s,
 *
 *   m = trace(Mvv) / 3,     [s]x = (Mwv - Mwv^T) / 2,
 *
 * a rigid body's own m and s. `matrix` must stay valid until the body is added. */
MBSR_API mbsr_inertia mbsr_inertia_matrix(int d, const double *matrix);

/* A mass matrix by function. Any space. */
MBSR_API mbsr_inertia mbsr_inertia_function(mbsr_inertia_fn function, void *user);

#ifdef __cplusplus
}
#endif

#endif

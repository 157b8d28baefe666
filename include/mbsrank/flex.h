/* Flexible bodies: modal data, markers, and how they stand in a tree.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Floating frame of reference. A material point x of the undeformed body is at r + R rho,
 *
 *   rho = x + Phi(x) s,     velocity  v + omega x R rho + R Phi s'
 *
 * with the frame (R, r) of the body and modal coordinates s. The field is linear in s but for
 * dependent shapes (below). Its mass matrix is exact, without these of second degree in s: with
 * exact integrals it is a Gram matrix, positive semi-definite at every s. With E_a = int rho
 * Phi_a^T, c = int rho, I the tensor about the frame's origin and axial(int a b^T) = int a x b,
 * along the body's axes,
 *
 *   M = [ I  [c]x  Cr ;  -[c]x  m 1  Ct0 ;  Cr^T  Ct0^T  Mf ],     Cr_a = axial(E_a)
 *
 * Modes may be massless: a mode whose Ct0, P0, P and Mf are zero has stiffness and damping only. So
 * static modes (attachment, constraint, residual modes) cost no small steps. With damping they are
 * damped directions of the model (index 1), without damping elastic ones (index 2): see index.h.
 *
 * Geometric stiffening. A beam that bends gets shorter along its axis, in second order, and what
 * pulls at it stiffens it: spin, weight, forces on markers. Dependent shapes chi_k give the field
 * this order,
 *
 *   rho = x + Phi(x) s + sum_k chi_k(x) y_k,     y_k = 1/2 s^T Y_k s
 *
 * exactly as if they were further modes, bound to follow s: with s^ = (s, y) and Z = ds^/ds,
 * M = Z^T M^(s^) Z. So M(s) is still a Gram matrix, and all is derived from one kinetic energy.
 *
 *   mbsr_flex_create(&def, &link, &error);
 *   mbsr_flexible_def at = mbsr_default_flexible_def();
 *   at.flex = link, at.marker = root, at.joint = mbsr_joint_revolute(NULL, NULL, axis);
 *   mbsr_model_add_flexible(model, &at, &body);
 *   mbsr_model_add_marker(model, body, tip, "tip", &end);
 *
 * `end` is then a SPATIAL body without mass that moves with the marker: joints, closures and force
 * elements take it as any other. */
#ifndef MBSRANK_FLEX_H
#define MBSRANK_FLEX_H

#include <mbsrank/force.h>
#include <mbsrank/inertia.h>
#include <mbsrank/joint.h>
#include <mbsrank/model.h>

#ifdef __cplusplus
extern "C" {
#endif

#define MBSR_MAX_MODES (MBSR_MAX_D - 6)
#define MBSR_MAX_DEPENDENCES 4096

/* A frame fixed to the material. It moves by Phi s and turns by the rotation vector Psi s, along
 * the body's axes: its origin is at x + Phi s, its axes are exp([Psi s]x) R. Of a linear theory:
 * Psi s should stay well below 1 rad. */
typedef struct mbsr_flex_marker {
    mbsr_frame frame;  /* x, R: in the undeformed body */
    const double *Phi; /* 3 x shapes, modes first, then chi; NULL: zero */
    const double *Psi; /* 3 x shapes, rad per unit of s or y; NULL: zero */
} mbsr_flex_marker;

/* Modal data: integrals over the mass of the undeformed body, along its axes, about its origin. All
 * matrices column-major; units: kg and m for what has mass, where Phi s is in m. */
typedef struct mbsr_flex_def {
    int cookie;        /* set by mbsr_default_flex_def */
    int modes;         /* 0 .. MBSR_MAX_MODES */
    int dependent;     /* shapes that depend on them; default 0. shapes = modes + dependent, at most
                        * MBSR_MAX_MODES; modes dependent at most MBSR_MAX_DEPENDENCES */
    double mass;       /* kg */
    double c0[3];      /* int x */
    double N0[9];      /* int x x^T; the tensor of inertia is tr(N0) 1 - N0 */
    const double *Ct0; /* 3 x shapes: int Phi_a, then int chi_k; NULL: zero */
    const double *P0;  /* 3 x 3 shapes: int x Phi_a^T in the columns 3 a .. 3 a + 2; NULL: zero */
    const double *P;   /* 3 shapes x 3 shapes: int Phi_a Phi_b^T in rows 3 a .., columns 3 b ..;
                        * NULL: zero */
    const double *Mf;  /* shapes x shapes; NULL: tr int Phi_a Phi_b^T, as it is for displacements.
                        * More than that is inertia of rotations. */
    const double *Y; /* modes x modes x dependent, each Y_k symmetric; NULL where there are none */
    const double *K; /* modes x modes, stiffness */
    const double *D; /* modes x modes, damping; NULL: zero */
    int markers;     /* 1 or more */
    const mbsr_flex_marker *marker;
    mbsr_allocator allocator; /* default: malloc and free */
} mbsr_flex_def;

MBSR_API mbsr_flex_def mbsr_default_flex_def(void);

/* Everything is copied. The data are read-only once made and may be shared by bodies, models and
 * threads; they must outlive the models.
 *
 * On failure *flex is NULL and the reason in *error (which may be NULL): MBSR_ERR_NULL,
 * MBSR_ERR_NO_DEFAULT, MBSR_ERR_NO_MEMORY, MBSR_ERR_NUMERICS, and MBSR_ERR_VALUE for numbers that
 * are not finite, matrices that are not symmetric (to 1e-9 of what is on the diagonal), axes of a
 * marker that are not orthonormal, and what is indefinite (scaled to unit diagonal, with the
 * eigenvalue in the text, by more than 1e-9): K, D, the Gram matrix of (1, x, Phi_1, ..., Phi_n,
 * chi_1, ...), and what Mf adds to it. Data with an indefinite Gram matrix belong to no
 * distribution of mass; their M(s) may have directions of negative mass. */
MBSR_API int mbsr_flex_create(const mbsr_flex_def *def, mbsr_flex **flex, mbsr_error *error);
MBSR_API void mbsr_flex_destroy(mbsr_flex *flex); /* NULL is allowed */

/* The data as they are kept: pointers into *flex, valid as long as that; Ct0, P0, P, Mf, K, D and
 * the markers' Phi and Psi are not NULL where there are modes, and Y where there are dependent
 * shapes. MBSR_ERR_NULL. */
MBSR_API int mbsr_flex_definition(const mbsr_flex *flex, mbsr_flex_def *data);

/* M(s), (6 + modes) x (6 + modes), along the body's axes; s: modes. MBSR_ERR_NULL, MBSR_NOT_FINITE
 * (s). */
MBSR_API int mbsr_flex_mass_matrix(const mbsr_flex *flex, const double *s, double *M);

/* A large amplitude of a mode: that which moves the body by `length` (m, > 0), in the mean square
 * over its mass or at a marker, or turns a marker by 1 rad; 1 where it does neither to speak of,
 * and for a mode or length that is none. By these, coordinates s are compared with lengths and
 * angles. */
MBSR_API double mbsr_flex_span(const mbsr_flex *flex, int mode, double length);

/* ---- beams ---- */

/* A straight, slender, uniform beam along x, held at its root, x = 0 (Euler and Bernoulli; cubic
 * finite elements for bending, linear ones for stretching and torsion). */
typedef struct mbsr_beam_def {
    int cookie;        /* set by mbsr_default_beam_def */
    double length;     /* m, > 0 */
    double density;    /* kg/m, >= 0 */
    double EA;         /* N: stretching; here and below 0, the default: it does not deform so */
    double EI_y, EI_z; /* N m^2: bending about y (displacement along z) and about z (along y) */
    double GJ;         /* N m^2: torsion */
    double radius_y, radius_z; /* m, >= 0: radii of gyration of the section along y and z; default
                                * 0: its mass is on the axis, torsion has none, and a straight beam
                                * that flies free turns about its axis without: MBSR_UNDETERMINED */
    double tip_mass;           /* kg, >= 0: a particle at the end */
    int elements;              /* 1 .. 40, default 15; see below */
    int modes;                 /* normal modes at most, the lowest ones; default 4 */
    double frequency;          /* rad/s: no normal mode above; default INFINITY */
    int loaded;                /* nodes that get static modes for all their loads; default 0 */
    const int *node;           /* these: 1 .. elements */
    double cutoff;  /* rad/s: static modes above it are massless; default 0: all of them */
    double damping; /* ratio zeta >= 0 of all modes, see below; default 0 */
    int stiffening; /* 1: with dependent shapes, by which bending shortens the beam; default 0 */
    mbsr_allocator allocator; /* default: malloc and free */
} mbsr_beam_def;

MBSR_API mbsr_beam_def mbsr_default_beam_def(void);

/* Modal data of a beam whose frame is its root: markers 0 .. elements are its nodes, at x = k
 * length / elements, along the axes of the beam.
 *
 * With 15 elements the frequencies of the first four bending modes are too high by 2e-7, 7e-6, 5e-5
 * and 2e-4, as elements^-4; of stretching and torsion by 5e-4, 4e-3, 1.2e-2 and 2.3e-2, as
 * elements^-2.
 *
 * Modes are first the normal modes of the beam clamped at the root, of mass 1, by frequency; then
 * residual attachment modes of the loaded nodes, K^-1 F less what the normal modes have of it, made
 * independent and diagonal, by frequency. So deflections under loads at these nodes are exact (as
 * finite elements are) whatever `modes` is. Those with omega <= cutoff have mass 1, the others none
 * and K = 1. Damping is 2 zeta omega of modes with mass; of a massless one D = 2 zeta / omega_c K,
 * omega_c the cutoff or the highest frequency with mass, what is larger.
 *
 * With `stiffening`, modes with mass shorten the beam along x as their slopes say, in second order,
 *
 *   -1/2 sum_ab s_a s_b int_0^x v_a' v_b' + w_a' w_b'
 *
 * by as few dependent shapes as give that to 1e-6. Needed where the beam spins or is pulled; modes
 * without mass do not shorten it.
 *
 * Statuses of mbsr_flex_create; MBSR_ERR_VALUE names the field. */
MBSR_API int mbsr_flex_beam(const mbsr_beam_def *def, mbsr_flex **flex, mbsr_error *error);

/* ---- in a tree ---- */

/* Inertia of a FLEXIBLE body with these data. Here and below, `flex` that is NULL is refused when
 * the part is added. */
MBSR_API mbsr_inertia mbsr_inertia_flexible(const mbsr_flex *flex);

/* What carries a flexible body: it is held at a marker that coincides with the frame of a SPATIAL
 * predecessor, or of the root at rest. q = s, u = s'; n = modes. The body is FLEXIBLE. */
MBSR_API mbsr_joint mbsr_joint_mount(const mbsr_flex *flex, int marker);

/* A marker as a SPATIAL body on its FLEXIBLE predecessor. n = 0. */
MBSR_API mbsr_joint mbsr_joint_marker(const mbsr_flex *flex, int marker);

/* Stiffness and damping of a FLEXIBLE body: f_s = -K s - D s', with energy 1/2 s^T K s, dissipation
 * s'^T D s'. */
MBSR_API mbsr_force_def mbsr_force_elastic(int body, const mbsr_flex *flex);

/* A flexible body in one call. */
typedef struct mbsr_flexible_def {
    int cookie;            /* set by mbsr_default_flexible_def */
    const char *name;      /* copied; NULL: none */
    int parent;            /* a SPATIAL body, a marker of another flexible body, or MBSR_GROUND */
    const mbsr_flex *flex; /* must outlive the model */
    int marker;            /* of flex, at which the body is held; default 0 */
    mbsr_joint joint; /* from the parent to that marker; with joint.table NULL, the default, the
                       * marker is held fast to the parent's frame */
} mbsr_flexible_def;

MBSR_API mbsr_flexible_def mbsr_default_flexible_def(void);

/* Adds, where there is a joint, a SPATIAL body without mass that it carries (its id is *body - 1),
 * then the FLEXIBLE body on its mount with its inertia, then its elastic element. q and u of the
 * former are those of the joint, of the latter s and s'. *body: id of the FLEXIBLE body. Statuses
 * as mbsr_model_add_body and mbsr_model_add_force; on failure nothing has been added. */
MBSR_API int mbsr_model_add_flexible(mbsr_model *model, const mbsr_flexible_def *def, int *body);

/* Adds a body without mass that moves with a marker of a FLEXIBLE body added before; *id: its id.
 * name may be NULL. MBSR_ERR_ID, MBSR_ERR_SPACE, and statuses as mbsr_model_add_body. */
MBSR_API int mbsr_model_add_marker(mbsr_model *model, int body, int marker, const char *name,
                                   int *id);

#ifdef __cplusplus
}
#endif

#endif

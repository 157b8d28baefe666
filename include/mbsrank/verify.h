/* Tests of joints, force elements and closures of a caller's own: the functions of a table against
 * differences. For whoever writes one, once, in tests of his own.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_VERIFY_H
#define MBSRANK_VERIFY_H

#include <mbsrank/closure.h>
#include <mbsrank/dynamics.h>
#include <mbsrank/joint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- joints ---- */

/* The state to test at: any state of motion in which nothing is zero by accident. All rates count:
 * with u and V_pred zero, kII and the rates of K, H, J have nothing to show. */
typedef struct mbsr_joint_test {
    int cookie;            /* set by mbsr_default_joint_test */
    mbsr_space pred_space; /* meaning of the predecessor's coordinates; default FIXED */
    int pred_d, pred_np;   /* of a predecessor in GENERAL or FLEXIBLE space; else not read */
    double t;              /* s; default 0 */
    const double *q;       /* nq */
    const double *u;       /* n */
    const double *p_pred;  /* pose of the predecessor; not read when it is FIXED */
    const double *V_pred;  /* pred_d, likewise */
    double step; /* length of the differences, as change of coordinates (m, rad) and, where that is
                    less, of t (s); default 0.004 */
    int V_is_not_rate; /* GENERAL only: 1 where V is not p' of the body or of the predecessor; so
                          it is taken to be where np differs from d; default 0 */
    mbsr_allocator allocator; /* for what the test needs in between; default: malloc and free */
} mbsr_joint_test;

MBSR_API mbsr_joint_test mbsr_default_joint_test(void);

/* What was found. Each number is relative: 0 is perfect, rounding and differences leave about 1e-9,
 * an error in the formulas usually 1e-2 to 2. An entry of a matrix or vector is compared with the
 * largest entry of K, H and J in its row, times the largest rate or acceleration. -1: there is
 * nothing to test.
 *
 * Each field is about what that function wrote, taking K and the position for granted:
 *   K, or the position, wrong     H, J, kI and kII
 *   coordinate_rates wrong        J and, though they may be right, kII, Hdot and Jdot
 *   coordinate_rates not linear   coordinate_rates besides
 *
 * tangent and rate_tangent are compared with differences of what the other functions wrote, so that
 * an error in one of these shows there too. They are taken along each number of q, u and V_pred,
 * the predecessor's pose (of one in space: along small rotations and displacements) and along all
 * at once. */
typedef struct mbsr_joint_errors {
    double position;           /* of a SPATIAL body: R against a rotation; 2: left-handed */
    double H;                  /* K dV + H dV_pred = 0 for motions of the predecessor alone */
    double J;                  /* K dV + J du = 0 for motions of the joint alone, q' = G(q) u */
    double kI;                 /* K V + kI = 0 where only t runs */
    double kII;                /* K A + kII = 0 along a motion with u and V_pred constant */
    double Kdot, Hdot, Jdot;   /* rates along that motion */
    double coordinate_rates;   /* G(q) u is linear in u */
    double normalise;          /* the pose before and after; m, rad */
    double tangent;            /* derivatives of position and jacobians */
    double rate_tangent;       /* derivatives of bias, rates and coordinate_rates */
    double largest;            /* of all the above */
    char text[MBSR_TEXT_SIZE]; /* where that one was found: entry, value, value by differences */
} mbsr_joint_errors;

/* Tests the functions of a joint's table in one state, by differences of its positions: for
 * whoever writes a joint, once, in tests of his own.
 *
 *   mbsr_joint_test at = mbsr_default_joint_test();
 *   at.q = q, at.u = u;
 *   mbsr_joint_errors errors;
 *   assert(mbsr_joint_verify(&joint, &at, &errors, NULL) == MBSR_OK && errors.largest < 1e-7);
 *
 * V is read from the poses: p' of POINT, PLANAR and GENERAL bodies; of a SPATIAL body omega from R
 * and r'. Of a GENERAL body whose V is not p' (see V_is_not_rate) only kII and the rates are
 * compared, with V from (8); of a GENERAL predecessor of that kind V_pred must be zero and H is not
 * tested. Costs some hundred calls of the joint's functions for each column of H and J, and
 * allocates.
 *
 * Status: MBSR_OK (whatever the errors), MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE or
 * MBSR_ERR_SPACE (what mbsr_model_add_body or the joint's check refuses, and states that cannot be
 * tested), MBSR_NOT_FINITE (a function wrote NaN, or numbers overflow), MBSR_SINGULAR_K,
 * MBSR_ERR_NO_MEMORY, and what a function of the joint returned, unchanged. The reason is in
 * *error, which may be NULL; *errors is then not to be read. */
MBSR_API int mbsr_joint_verify(const mbsr_joint *joint, const mbsr_joint_test *at,
                               mbsr_joint_errors *errors, mbsr_error *error);

/* ---- force elements ---- */

/* What was found. An entry df/dx or dtau/dx is compared with the largest of its block: all
 * derivatives of f (or tau) of one body with respect to the pose (or V, q, u) of one body. 0 is
 * perfect, rounding and differences leave about 1e-9, an error in the formulas usually 1e-3 to 2.
 * Differences beside a point where a force has a kink or jumps show that instead. What is below the
 * rounding of the forces themselves, 1e-10 of the largest of the body, does not count. */
typedef struct mbsr_force_errors {
    double largest;
    char text[MBSR_TEXT_SIZE]; /* where it was found: entry, bodies, value, value by differences */
} mbsr_force_errors;

/* Tests the `derivatives` of a force element's table in the state of mbsr_stage_velocities: for
 * whoever writes an element, once, in tests of his own. A good state has nothing that is zero by
 * accident, and bodies not farther from the origin than the element is large.
 *
 *   mbsr_force_errors errors;
 *   assert(mbsr_force_verify(model, data, force, &errors) == MBSR_OK && errors.largest < 1e-7);
 *
 * Of an element that acts on every body each is tested; those whose derivatives the library does
 * not ask for, because their mass is given by function (force.h), count as right. The data stays as
 * it is. Memory is taken from the model's allocator and given back.
 *
 * Status: MBSR_OK (whatever the errors), MBSR_ERR_NULL, MBSR_ERR_SEQUENCE, MBSR_ERR_ID (no such
 * force), MBSR_ERR_VALUE (it has no derivatives of its own), MBSR_NOT_FINITE (something is NaN),
 * MBSR_ERR_NO_MEMORY, and what a function of the element returned, unchanged; the reason is in
 * mbsr_data_error, and *errors is then not to be read. */
MBSR_API int mbsr_force_verify(const mbsr_model *model, mbsr_data *data, int force,
                               mbsr_force_errors *errors);

/* ---- closures ---- */

/* What was found by mbsr_closure_verify: the largest errors of C, g_t and the bias against
 * differences, relative to the largest entry of each. */
typedef struct mbsr_closure_errors {
    double jacobian, drift, bias;
    char text[MBSR_TEXT_SIZE]; /* where the largest was found */
} mbsr_closure_errors;

/* Tests the functions of a closure's table against differences of g (of the velocity rows for the
 * bias) in the state of mbsr_stage_velocities: for whoever writes one, in tests of his own. About
 * 1e-8 where they are right. Rows that are not position rows are tested for their bias alone; the
 * turns of a weld only where its frames agree. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE, MBSR_ERR_ID,
 * MBSR_NOT_FINITE, what a table returned. */
MBSR_API int mbsr_closure_verify(const mbsr_model *model, mbsr_data *data, int closure,
                                 mbsr_closure_errors *errors);

#ifdef __cplusplus
}
#endif

#endif

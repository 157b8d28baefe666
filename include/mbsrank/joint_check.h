/* A test of a joint's functions against differences of its positions, and of its derivatives.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_JOINT_CHECK_H
#define MBSRANK_JOINT_CHECK_H

#include <mbsrank/joint.h>

#ifdef __cplusplus
extern "C" {
#endif

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

#ifdef __cplusplus
}
#endif

#endif

/* A test of a force element's derivatives against differences of its forces.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_FORCE_CHECK_H
#define MBSRANK_FORCE_CHECK_H

#include <mbsrank/data.h>
#include <mbsrank/model.h>

#ifdef __cplusplus
extern "C" {
#endif

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

#ifdef __cplusplus
}
#endif

#endif

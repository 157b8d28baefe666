/* Validation of what is added to a model; each writes the model's error and returns its status.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CHECK_H
#define MBSRI_CHECK_H

#include "model/record.h"

/* label: the body's name in messages; *regular: the mass matrix is constant in rank and clearly
 * positive definite. */
int mbsri_check_joint(mbsr_model *m, const mbsr_joint *joint, int id, const char *label);
/* The scales of a table of a body's joint or of a force element (the other id MBSR_NONE). */
int mbsri_check_scales(mbsr_model *m, const mbsr_scales *scales, int body, int force,
                       const char *label, const char *name);
int mbsri_check_inertia(mbsr_model *m, const mbsr_inertia *inertia, mbsr_space space, int d, int id,
                        const char *label, bool *regular);
/* A force element, with its list of bodies, and a closure. */
int mbsri_check_force(mbsr_model *m, const mbsr_force_def *def, int id, const char *label);
int mbsri_check_closure(mbsr_model *m, const mbsr_closure_def *def, const char *label);

#endif

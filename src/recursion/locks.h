/* Joints of which some coordinates are held (mbsr_model_lock).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOCKS_H
#define MBSRI_LOCKS_H

#include "model/record.h"

/* full = x with the values held, or zeros, put in; J = full without the columns held. */
void mbsri_with_held(const mbsri_body *b, const double *x, bool values, double *full);
void mbsri_drop_held(const mbsri_body *b, const double *full, double *J);

#endif

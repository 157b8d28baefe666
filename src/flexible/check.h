/* Whether modal data are those of a body.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FLEX_CHECK_H
#define MBSRI_FLEX_CHECK_H

#include "flexible/data.h"

/* Refuses data that are not; f is filled. Statuses as mbsr_flex_create. */
int mbsri_flex_check(const mbsr_flex *f, mbsr_error *error);

#endif

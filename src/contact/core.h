/* The cores of shapes: corners, edges and faces.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CONTACT_CORE_H
#define MBSRI_CONTACT_CORE_H

#include "contact/record.h"

/* Makes the core of a shape whose kind and frame stand, and the box around it. A status, with a
 * text that begins behind the shape's name. */
int mbsri_core_make(const mbsr_shape *from, mbsri_shape *shape, char text[MBSR_TEXT_SIZE]);

/* Whether the sizes of such a shape are positive. */
bool mbsri_core_has_size(mbsr_shape_kind kind, const double size[3]);

#endif

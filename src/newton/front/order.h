/* Orders in which the bodies of a tree may be passed, successors first.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_ORDER_H
#define MBSRI_FRONT_ORDER_H

#include "newton/front/source.h"

/* N bodies: the deepest first. work: 2 N + 2. */
void mbsri_front_order_by_depth(const mbsr_model *m, int *order, int *work);

/* That with the fewest bodies in its border next; false: there is no memory. */
bool mbsri_front_order_by_border(const mbsri_front_source *from, int *order);

#endif

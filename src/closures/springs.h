/* Stock springs as closures with stiff rows.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSURES_SPRINGS_H
#define MBSRI_CLOSURES_SPRINGS_H

#include "forces/springs.h"

#include <mbsrank/closure.h>

/* Refuses an element that asks to be a closure and cannot, as far as it shows without its bodies.
 */
int mbsri_spring_check(const mbsr_force_def *force, char text[MBSR_TEXT_SIZE]);

/* Such an element on these bodies as a closure; its name is left to the caller. */
mbsr_closure_def mbsri_spring_closure(const mbsr_force_def *force, const int body[2],
                                      const mbsr_space space[2]);

#endif

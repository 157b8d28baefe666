/* Mbar, D and what follows from them in the arrays of the stages, where a bound of the rounding
 * errors is enough to tell that every joint has full rank.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BOUNDED_H
#define MBSRI_BOUNDED_H

#include "sweeps/tree.h"

/* Whether the model is an open tree of rigid bodies, each joint by itself. */
bool mbsri_bounded_serves(const mbsr_model *m);

/* What is constant, to bounds (N + 1). */
void mbsri_bounded_prepare(const mbsr_model *m, mbsri_sweep_load *bounds);

/* Where all bodies are free behind a root at rest, each by a joint with a constant J, and by their
 * inertia alone have full rank in every pose: ranks and J' = 0, at the stage of velocities.
 * Derivatives of their joints read no momenta and no forces. */
bool mbsri_bounded_free(const mbsr_model *m, mbsr_data *d, mbsri_sweep_load *bounds);

/* As mbsri_backward after the stage of forces, but for eigenvectors of D and exact errors; the
 * stage stays that of forces. False: it does not tell, and the arrays are for mbsri_backward to
 * write. */
bool mbsri_bounded_backward(const mbsr_model *m, mbsr_data *d, mbsri_sweep_load *bounds);

#endif

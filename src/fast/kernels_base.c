/* The sweeps for every processor.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "kernels.h"
#include "newton_kernels.h"

const mbsri_fast_kernels mbsri_fast_base = {
    "baseline", trigonometry, kinematics,    backward,           forward,     inverse,
    velocities, momentum,     newton_factor, newton_factor_deep, newton_solve};

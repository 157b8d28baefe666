/* The sweeps for x86-64 with AVX2 and FMA (x86-64-v3).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "kernels.h"
#include "newton_kernels.h"

const mbsri_fast_kernels mbsri_fast_v3 = {
    "x86-64-v3", trigonometry, kinematics,    backward,           forward,     inverse,
    velocities,  momentum,     newton_factor, newton_factor_deep, newton_solve};

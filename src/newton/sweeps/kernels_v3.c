/* The Newton sweeps for x86-64 with AVX2 and FMA (x86-64-v3).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/vmovq.h"

#include "newton/sweeps/looped.h"
#include "newton/sweeps/looped_transposed.h"

const mbsri_newton_kernels mbsri_newton_v3 = {newton_factor,       newton_factor_below_massless,
                                              newton_factor_mixed, newton_factor_looped,
                                              newton_solve,        newton_solve_transposed};

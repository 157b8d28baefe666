/* The Newton sweeps for every processor.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/sweeps/looped.h"
#include "newton/sweeps/looped_transposed.h"

const mbsri_newton_kernels mbsri_newton_base = {newton_factor,       newton_factor_below_massless,
                                                newton_factor_mixed, newton_factor_looped,
                                                newton_solve,        newton_solve_transposed};

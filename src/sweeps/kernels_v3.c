/* The sweeps for x86-64 with AVX2 and FMA (x86-64-v3).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/vmovq.h"

#include "sweeps/inverse_loops.h"
#include "sweeps/open_loops.h"
#include "sweeps/parts.h"
#include "sweeps/trigonometry.h"

const mbsri_sweep_kernels mbsri_sweeps_v3 = {
    "x86-64-v3",   trigonometry,   kinematics,    backward,       forward,
    inverse,       velocities,     momentum,      block_backward, forward_block,
    &part_kernels, loops_backward, loops_forward, loops_inverse,  momenta};

/* What IDA has counted.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/count.h"

void mbsri_ida_count(const mbsr_ida *ida, mbsr_ida_stats *stats)
{
    static int (*const get[])(void *, long int *) = {
        IDAGetNumSteps,           IDAGetNumLinResEvals,         IDAGetNumJacEvals,
        IDAGetNumNonlinSolvIters, IDAGetNumNonlinSolvConvFails, IDAGetNumErrTestFails,
        IDAGetNumLinIters};
    long *const sum[] = {&stats->steps,
                         &stats->jacobian_residuals,
                         &stats->jacobians,
                         &stats->newton_iterations,
                         &stats->newton_failures,
                         &stats->error_test_failures,
                         &stats->krylov_iterations};
    for (size_t k = 0; k < sizeof get / sizeof get[0]; ++k) {
        long int value = 0;
        get[k](ida->memory, &value);
        *sum[k] += value;
    }
}

/* Where runs are stopped.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/stops.h"

#include <math.h>

int mbsri_ida_next_jump(const mbsr_model *m, mbsr_kink_fn kink, void *user, double t, double t_end,
                        double *stop)
{
    for (*stop = t; *stop < t_end;) {
        mbsr_kink next = {INFINITY, 1}, other = {INFINITY, 1};
        int status = mbsr_model_kink(m, *stop, 1, &next);
        if (!status && kink) status = kink(user, *stop, 1, &other);
        if (status) return status;
        if (other.t < next.t || (other.t == next.t && other.derivative < next.derivative))
            next = other;
        *stop = fmin(next.t, t_end);
        if (next.derivative <= 1) break;
    }
    return MBSR_OK;
}

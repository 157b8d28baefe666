/* A motion by numbers that are stored: see mbsrank/fmu.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/fmu.h>

int mbsr_fmu_stored_motion(void *motion, double t, double *s, double *sdot, double *sddot)
{
    const mbsr_fmu_motion *m = motion;
    (void)t;
    if (!m) return MBSR_ERR_NULL;
    if (m->count < 1 || m->count > MBSR_FMU_MOTION_MOST) return MBSR_ERR_VALUE;
    for (int k = 0; k < m->count; ++k) {
        s[k] = m->value[3 * k];
        sdot[k] = m->value[3 * k + 1];
        sddot[k] = m->value[3 * k + 2];
    }
    return MBSR_OK;
}

/* No steps by the error: what a set of sources has in the place of driver.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/driver.h"

mbsri_result mbsri_make_driver(mbsri_instance *in)
{
    return mbsri_say(in, MBSRI_ERROR,
                     "these sources have no integrator of variable steps: export with a fixed one");
}

void mbsri_drop_driver(mbsri_instance *in)
{
    (void)in;
}

int mbsri_driver_state(mbsri_instance *in, const mbsr_error **error)
{
    (void)in;
    *error = NULL;
    return MBSR_ERR_UNAVAILABLE;
}

int mbsri_driver_motion(mbsri_instance *in, const mbsr_error **error)
{
    return mbsri_driver_state(in, error);
}

mbsri_result mbsri_drive(mbsri_instance *in, double t_end, bool *event)
{
    (void)t_end;
    *event = false;
    return mbsri_make_driver(in);
}

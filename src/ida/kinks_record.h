/* What the driver knows of kinks: see kinks.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_KINKS_RECORD_H
#define MBSRI_IDA_KINKS_RECORD_H

#include <sundials/sundials_nvector.h>

#include <stdbool.h>

typedef struct mbsri_ida_kinks {
    double at;      /* the next kink, or the end of a sample; +-INFINITY: none */
    int derivative; /* of the state, the lowest that jumps there; 0: none, the end of a sample */
    double gap;     /* steps end so much before it and begin so much behind it; s, > 0 */
    bool known;     /* `at` is the next one after IDA's time */
    bool aimed;     /* IDA has had a time to stop at */
    bool reached;   /* the run stands at the kink: the state is the one before it */
    bool requested; /* mbsr_ida_jump */
    bool sampled;   /* whether a sample is under way */
    double end;     /* end of that sample, s */
    int patience;   /* restarts to come without c */
    double step;    /* the first one after the last restart with c; 0: none so far */

    bool shifted;             /* IDA integrates z = y - c, see kinks.h */
    double from;              /* t0 */
    N_Vector c_derivative[2]; /* y'', y''' in c */
    N_Vector y, yp;           /* of z, z' in a callback */
    N_Vector node[3];         /* q', p' and u at t0, t0 + s, t0 + 2 s */
    N_Vector ahead;           /* the state there */
    N_Vector right;           /* of a Newton system */
    N_Vector work;            /* nq + 4 nu numbers */
} mbsri_ida_kinks;

#endif

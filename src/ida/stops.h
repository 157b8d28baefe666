/* Where runs are stopped.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_STOPS_H
#define MBSRI_IDA_STOPS_H

#include <mbsrank/ida.h>

/* The next time beyond t at which forces or rates jump, by the model's tables and by kink (NULL:
 * none), or t_end. A status of kink. */
int mbsri_ida_next_jump(const mbsr_model *m, mbsr_kink_fn kink, void *user, double t, double t_end,
                        double *stop);

#endif

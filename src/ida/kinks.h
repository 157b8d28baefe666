/* Kinks: known times at which derivatives of the state jump.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Steps end at a kink and go on behind it, so that none is taken across. Functions of time are
 * asked a few roundings before it and behind it only. Where y' jumps IDA starts anew, from q and
 * the momenta there, with u and y' found again. It begins with order 1 and steps h, h, 2 h, 4 h ..,
 * the first error h^2 y'' / 2; h is chosen so that such steps fill the time to the next kink.
 *
 * Where the motion is smooth up to the next kink, |y'''| (t1 - t0) < |y''|, IDA integrates
 *
 *   z = y - c(t),   c = y''(t0) (t - t0)^2 / 2 + y'''(t0) (t - t0)^3 / 6,
 *       F(t, z + c, z' + c') = 0
 *
 * from the kink t0 to the next one t1: what is left in z is of the fourth order, and one step or
 * two do. Any c will do as far as the result is concerned; y'' and y''' come from difference
 * quotients. */
#ifndef MBSRI_IDA_KINKS_H
#define MBSRI_IDA_KINKS_H

#include "ida/record.h"

/* Before IDA goes on: leaves the kink at which the run stands, and has IDA stop at the next one. */
int mbsri_ida_leave_kink(mbsr_ida *ida);

/* After a stop at a kink: the present time is that of the kink. */
void mbsri_ida_arrive(mbsr_ida *ida);

#endif

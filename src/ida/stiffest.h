/* The force elements whose stiffness fails error tests.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_STIFFEST_H
#define MBSRI_IDA_STIFFEST_H

#include "ida/record.h"

/* After a failure of IDA, its flag, the text of which stands in ida->error: adds the names of the
 * elements, if there are any. */
void mbsri_ida_blame_stiff(mbsr_ida *ida, int flag);

#endif

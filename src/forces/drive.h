/* Drives that follow tables.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DRIVE_H
#define MBSRI_DRIVE_H

#include <mbsrank/force.h>

/* How many derivatives more than its table's function q and the momenta have, for an element whose
 * function is mbsr_table_force: 1, but for a servo, which reads the first derivative too, 0. */
int mbsri_table_lead(const mbsr_force_def *def);

#endif

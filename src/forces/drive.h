/* What the library knows of elements on joint coordinates.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DRIVE_H
#define MBSRI_DRIVE_H

#include <mbsrank/force.h>

#include <stdbool.h>

/* How many derivatives more than its table's function q and the momenta have, for an element whose
 * function is mbsr_table_force: 1, but for a servo, which reads the first derivative too, 0. */
int mbsri_table_lead(const mbsr_force_def *def);

/* Whether `user` of an element is a table: its function of time, or the curve of a motor. */
bool mbsri_reads_table(const mbsr_force_def *def);

/* How many joint coordinates an element acts on, option[k] of body k each; 0: none that it names.
 */
int mbsri_force_coordinates(const mbsr_force_def *def);

/* A gear of which coordinate k stands still at a value; and one as it was given, but for its
 * coordinates. */
void mbsri_gear_hold(mbsr_force_def *def, int k, double value);
void mbsri_gear_release(mbsr_force_def *def);

#endif

/* Tables in motions and forces.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_TABLE_H
#define MBSRI_TABLE_H

#include <mbsrank/table.h>

/* Columns of a table; -1: NULL. */
int mbsri_table_columns(const mbsr_table *table);

/* Writes that the table, or NULL, has not `columns` columns into text; returns the status. */
int mbsri_table_refuse(const mbsr_table *table, int columns, char text[MBSR_TEXT_SIZE]);

#endif

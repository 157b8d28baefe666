/* The report as a table for people.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_TABLE_H
#define MBSRI_SMALL_TABLE_H

#include "small/record.h"

/* Bytes that the text takes at most. */
size_t mbsri_small_text_size(const mbsr_small_masses *s);

/* Writes s->text. */
void mbsri_small_write(mbsr_small_masses *s, const mbsr_small_masses_report *report);

#endif

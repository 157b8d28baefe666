/* What the stock force elements share.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_STOCK_H
#define MBSRI_STOCK_H

#include "../internal.h"

/* A definition with its cookie, table and up to two bodies set. */
mbsr_force_def mbsri_stock_force(const mbsr_force_table *table, int bodies, int a, int b);

/* Writes a refusal into text and returns status. */
int mbsri_refuse(char text[MBSR_TEXT_SIZE], int status, const char *format, ...) MBSRI_FORMAT(3, 4);

/* Entry k of a body's pose or velocity; a root at rest counts as zero. */
static inline double mbsri_entry(const mbsr_force_body *body, const double *x, int k)
{
    return body->space == MBSR_SPACE_FIXED ? 0.0 : x[k];
}

#endif

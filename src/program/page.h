/* The data of a page, as JSON.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_PAGE_H
#define MBSRANK_PAGE_H

#include "program/motion.h"

typedef struct page {
    const program_options *options;
    const program_model *model;
    const motion *motion;
    const table *run;    /* NULL: none */
    const double *q, *u; /* at the start */
} page;

/* Its members that are the model's, with a comma behind (page_model.c). */
void page_put_model(FILE *to, const page *p);

/* The names are those that src/program/viewer/data.js reads. A code. */
int page_write(FILE *to, const page *p);

#endif

/* Pictures by gnuplot.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_PLOT_H
#define MBSRANK_PLOT_H

#include <stdio.h>

typedef struct plot_options {
    const char *run, *file, *columns, *title, *over, *terminal;
} plot_options;

/* Begins a picture of so many panels below each other; NULL after a complaint. */
FILE *plot_begin(const plot_options *o, int panels);

/* A code. */
int plot_end(const plot_options *o, FILE *to);

/* A text in quotes of gnuplot. */
void plot_text(FILE *to, const char *text);

/* Results of a study: envelopes of columns over time, histograms, or all over a parameter. A code.
 */
int plot_study(const plot_options *o);

#endif

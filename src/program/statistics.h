/* Statistics of numbers.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_STATISTICS_H
#define MBSRANK_STATISTICS_H

typedef struct study_statistics {
    long count;
    double mean, deviation, least, low, median, high, most; /* low and high: 5 % and 95 % */
} study_statistics;

/* Of finite numbers, which are sorted; quantiles are between neighbours, as numpy's. NaN for none.
 */
study_statistics statistics_of(long count, double *x);

#endif

/* Work at equal error of two ways to integrate.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef WORK_H
#define WORK_H

enum { WORK_RUNS = 16, WORK_COSTS = 5 };

/* CPU time, evaluations of the residual, factorisations, solutions, steps. */
extern const char *const work_cost_name[WORK_COSTS];

/* One way at several tolerances. */
typedef struct work {
    int runs;
    double error[WORK_RUNS], cost[WORK_RUNS][WORK_COSTS];
} work;

void work_add(work *w, double error, const double cost[WORK_COSTS]);

/* Costs of a over those of b: sums over the tolerances, and at equal errors, the mean of log cost
 * interpolated over log error where both have some; 0 if they have none in common, or no cost. */
double work_ratio_of_sums(const work *a, const work *b, int cost);
double work_ratio(const work *a, const work *b, int cost);

#endif

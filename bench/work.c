/* Work at equal error of two ways to integrate.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "work.h"

#include <math.h>

const char *const work_cost_name[WORK_COSTS] = {"cpu", "residuals", "factorisations", "solves",
                                                "steps"};

void work_add(work *w, double error, const double cost[WORK_COSTS])
{
    if (w->runs == WORK_RUNS || !(error > 0.0)) return;
    for (int k = 0; k < WORK_COSTS; ++k) w->cost[w->runs][k] = cost[k];
    w->error[w->runs++] = error;
}

double work_ratio_of_sums(const work *a, const work *b, int cost)
{
    double sum_a = 0.0, sum_b = 0.0;
    for (int k = 0; k < a->runs; ++k) sum_a += a->cost[k][cost];
    for (int k = 0; k < b->runs; ++k) sum_b += b->cost[k][cost];
    return sum_b > 0.0 ? sum_a / sum_b : 0.0;
}

/* What an error costs: points (log error, log cost) of runs of which none is both cheaper and
 * better. */
typedef struct front {
    int points;
    double error[WORK_RUNS], cost[WORK_RUNS]; /* costs rise, errors fall */
} front;

static front front_of(const work *w, int cost)
{
    front f = {0};
    double least = INFINITY, dearest = -1.0;
    for (int step = 0; step < w->runs; ++step) {
        int next = -1;
        for (int k = 0; k < w->runs; ++k) {
            const double c = w->cost[k][cost];
            if (c > dearest && (next < 0 || c < w->cost[next][cost])) next = k;
        }
        if (next < 0) break;
        dearest = w->cost[next][cost];
        if (!(w->error[next] < least) || !(dearest > 0.0)) continue;
        least = w->error[next];
        f.error[f.points] = log(least);
        f.cost[f.points++] = log(dearest);
    }
    return f;
}

static double cost_at(const front *f, double error)
{
    int k = 1;
    while (k + 1 < f->points && f->error[k] > error) ++k;
    const double share = (f->error[k - 1] - error) / (f->error[k - 1] - f->error[k]);
    return f->cost[k - 1] + share * (f->cost[k] - f->cost[k - 1]);
}

double work_ratio(const work *a, const work *b, int cost)
{
    enum { ERRORS = 40 };
    const front f = front_of(a, cost), g = front_of(b, cost);
    if (f.points < 2 || g.points < 2) return 0.0;
    const double high = fmin(f.error[0], g.error[0]),
                 low = fmax(f.error[f.points - 1], g.error[g.points - 1]);
    if (!(low < high)) return 0.0;
    double sum = 0.0;
    for (int k = 0; k <= ERRORS; ++k) {
        const double error = low + (high - low) * k / ERRORS;
        sum += cost_at(&f, error) - cost_at(&g, error);
    }
    return exp(sum / (ERRORS + 1));
}

/* Which rows of closures are independent, front by front: see row_fronts.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops/row_fronts.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "base/memory.h"
#include "fronts/idle.h"
#include "fronts/spread.h"
#include "loops/closing.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/rounding.h"

#include <math.h>

struct mbsri_row_fronts {
    const mbsr_model *m;
    mbsr_data *d;
    const char *function;
    mbsri_fronts system;
    const double *span;                      /* nu, the caller's order */
    double *metric;                          /* nu, in the order of the sweeps: of the inertias */
    double *g, *x;                           /* nu */
    double *zero, *lambda, *inverse, *scale; /* rows */
    int *order;   /* rows: the last of those that depend on each other are left out */
    bool *shared; /* rows */
    bool lost;    /* digits, in some ranks */
};

bool mbsri_any_stiff(const mbsr_model *m)
{
    const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
    bool any = false;
    for (; c < end; ++c) {
        for (int k = 0; k < c->position_rows; ++k) any = any || mbsri_is_stiff(c, k);
    }
    return any;
}

static void fill_order(mbsri_row_fronts *w)
{
    const mbsri_closure *first = mbsri_all_closures(w->m), *end = first + w->m->closures.count;
    int place = 0;
    for (int others = 0; others < 2; ++others) {
        for (const mbsri_closure *c = first; c < end; ++c) {
            for (int k = others ? c->position_rows : 0; k < (others ? c->rows : c->position_rows);
                 ++k)
                w->order[c->row + k] = place++;
        }
    }
}

static int no_memory(const mbsr_model *m, mbsr_data *d, const char *function)
{
    return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for ranks of %d rows of closures", function, m->rows);
}

int mbsri_row_fronts_open(const mbsr_model *m, mbsr_data *d, const double *span,
                          const char *function, mbsri_row_fronts **fronts)
{
    const size_t nu = (size_t)m->nu, rows = (size_t)m->rows, numbers = 3 * nu + 4 * rows;
    mbsri_row_fronts *w =
        mbsri_allocate(&m->allocator, sizeof *w + numbers * sizeof(double) + rows * sizeof(int) +
                                          rows * sizeof(bool));
    *fronts = w;
    if (!w) return no_memory(m, d, function);
    *w = (mbsri_row_fronts){
        .m = m, .d = d, .function = function, .span = span, .metric = (double *)(void *)(w + 1)};
    w->g = w->metric + nu;
    w->x = w->g + nu;
    w->zero = w->x + nu;
    w->lambda = w->zero + rows;
    w->inverse = w->lambda + rows;
    w->scale = w->inverse + rows;
    w->order = (int *)(void *)(w->scale + rows);
    w->shared = (bool *)(w->order + rows);
    mbsri_zero(rows, w->zero);
    for (size_t k = 0; k < nu; ++k) w->x[k] = 1.0 / (span[k] * span[k]);
    mbsri_gather(m, w->x, w->metric);
    fill_order(w);
    return mbsri_fronts_open(&w->system, m, d, true, function);
}

void mbsri_row_fronts_close(mbsri_row_fronts *w)
{
    mbsri_fronts_close(&w->system);
    mbsri_release(&w->m->allocator, w);
}

bool mbsri_row_fronts_lost(const mbsri_row_fronts *w)
{
    return w->lost;
}

const bool *mbsri_row_fronts_shared(const mbsri_row_fronts *w)
{
    return w->shared;
}

enum { KINDS = 3 };

/* The length to which each row is compared, as those of ranks.h. */
static void find_scales(mbsri_row_fronts *w)
{
    const mbsri_closure *first = mbsri_all_closures(w->m), *end = first + w->m->closures.count;
    double largest[KINDS] = {0.0};
    double *square = w->lambda;
    mbsri_row_squares(w->m, w->d, w->span, square);
    for (const mbsri_closure *c = first; c < end; ++c) {
        double own[KINDS] = {0.0};
        for (int k = 0; k < c->rows; ++k) {
            const int kind = (int)mbsri_row_kind(w->m, w->d, c, k);
            own[kind] = fmax(own[kind], sqrt(square[c->row + k]));
        }
        for (int k = 0; k < c->rows; ++k)
            w->scale[c->row + k] = own[(int)mbsri_row_kind(w->m, w->d, c, k)];
        for (int kind = 0; kind < KINDS; ++kind) largest[kind] = fmax(largest[kind], own[kind]);
    }
    for (const mbsri_closure *c = first; c < end; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            const int kind = (int)mbsri_row_kind(w->m, w->d, c, k);
            w->scale[c->row + k] = fmax(w->scale[c->row + k], 1e-3 * largest[kind]);
        }
    }
}

/* x = W^-1 (g + C^T lambda) with C x = 0, from w->g; its square in the metric. */
static double project(mbsri_row_fronts *w)
{
    double square = 0.0;
    mbsri_fronts_solve(&w->system, w->g, w->zero, w->x, w->lambda);
    for (int j = 0; j < w->m->nu; ++j) square += w->x[j] * w->x[j] / (w->span[j] * w->span[j]);
    return square;
}

/* g = C^T of rows of length 1, with signs: those dropped, or those kept; whether there is one. */
static bool add_rows(mbsri_row_fronts *w, const bool *dropped, bool those)
{
    bool any = false;
    for (int k = 0; k < w->m->rows; ++k) {
        const double sign = k % 3 == 1 ? -1.0 : 1.0;
        const bool taken = dropped[k] == those;
        any = any || taken;
        w->inverse[k] = taken && w->scale[k] > 0.0 ? sign / w->scale[k] : 0.0;
    }
    if (any) mbsri_closure_transpose(w->m, w->d, w->inverse, w->g);
    return any;
}

/* What all rows that are dropped have beside the span of the others, squared: of g + C^T lambda
 * itself, so that it is no smaller than the true one, whatever lambda. */
static double distance_of_dropped(mbsri_row_fronts *w, const bool *dropped)
{
    double square = 0.0;
    if (!add_rows(w, dropped, true)) return 0.0;
    (void)project(w);
    for (int k = 0; k < w->m->rows; ++k) w->lambda[k] = dropped[k] ? 0.0 : w->lambda[k];
    mbsri_closure_transpose(w->m, w->d, w->lambda, w->x);
    for (int j = 0; j < w->m->nu; ++j) {
        const double left = (w->g[j] + w->x[j]) * w->span[j];
        square += left * left;
    }
    return square;
}

/* Whether forces of the rows kept are found from what they do: not where rows depend on others. */
static bool are_kept_found(mbsri_row_fronts *w, const bool *dropped)
{
    static const double part = 1e-3;
    bool found = true;
    if (!add_rows(w, dropped, false)) return true;
    (void)project(w);
    for (int k = 0; k < w->m->rows; ++k) {
        if (!dropped[k] && !(fabs(w->lambda[k] + w->inverse[k]) * w->scale[k] <= part))
            found = false;
    }
    return found;
}

static void measure_rows(mbsri_row_fronts *w, const bool *dropped, mbsri_ranks *found)
{
    for (int k = 0; k < w->m->rows; ++k) {
        const double size = w->inverse[k] * w->scale[k] * w->scale[k],
                     pivot = dropped[k]   ? found->largest_dropped
                             : size > 0.0 ? 1.0 / size
                                          : 0.0;
        if (!dropped[k]) {
            ++found->independent;
            found->smallest_kept = fmin(found->smallest_kept, pivot);
        }
        if (w->d->dropped[k] || pivot >= found->weakest_pivot) continue;
        found->weakest_pivot = pivot;
        found->weakest = k;
    }
}

static int factor(mbsri_row_fronts *w)
{
    return mbsri_fronts_factor(&w->system, w->metric, w->function);
}

int mbsri_row_fronts_rank(mbsri_row_fronts *w, const bool *without, bool *dropped,
                          mbsri_ranks *found)
{
    const int rows = w->m->rows;
    for (int k = 0; k < rows; ++k) w->system.left_out[k] = without && without[k];
    find_scales(w);
    int status = factor(w);
    if (!status && !mbsri_idle_rows(&w->system, w->order, dropped, w->shared))
        status = no_memory(w->m, w->d, w->function);
    if (status) return status;
    for (int k = 0; k < rows; ++k)
        w->system.left_out[k] = dropped[k] = dropped[k] || (without && without[k]);
    status = factor(w);
    if (status) return status;
    *found = (mbsri_ranks){.smallest_kept = INFINITY, .weakest = -1, .weakest_pivot = INFINITY};
    found->largest_dropped = distance_of_dropped(w, dropped);
    w->lost =
        w->lost || !(found->largest_dropped <= MBSRI_DEPENDENT) || !are_kept_found(w, dropped);
    if (!mbsri_fronts_spread(&w->system, w->inverse)) return no_memory(w->m, w->d, w->function);
    measure_rows(w, dropped, found);
    w->lost = w->lost || (found->independent > 0 && !(found->smallest_kept > MBSRI_DEPENDENT));
    return MBSR_OK;
}

void mbsri_row_fronts_allow(mbsri_row_fronts *w, double *x)
{
    for (int j = 0; j < w->m->nu; ++j) w->g[j] = x[j] / w->span[j];
    (void)project(w);
    for (int j = 0; j < w->m->nu; ++j) x[j] = w->x[j] / w->span[j];
}

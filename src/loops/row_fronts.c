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

/* Trees that closures tie to each other, and which of their rows are looked at: `count` from
 * `first` on in `listed`, now `length` of them from `at` on, or what is left. */
typedef struct tied {
    int first, count, at, length;
    double square; /* of what these have together */
} tied;

struct mbsri_row_fronts {
    const mbsr_model *m;
    mbsr_data *d;
    const char *function;
    mbsri_fronts system;
    const double *span;                      /* nu, the caller's order */
    double *metric;                          /* nu, in the order of the sweeps: of the inertias */
    double *g, *x;                           /* nu */
    double *zero, *lambda, *inverse, *scale; /* rows */
    double *compliance;                      /* rows: while forces are shared */
    int *order, *kind; /* rows: the last of those that depend on each other are left out; order of
                        * kinds of rows alone */
    tied *part;        /* parts of the model that do not depend on each other */
    int parts, *part_of_rate, *part_of_row; /* nu, -1: none; rows */
    int *listed;                            /* rows, part by part */
    bool *shared;                           /* rows */
    bool *more, *other, *taken;             /* rows: for a short time */
    bool careful; /* such a row was not in the span of those kept: of them the row of the last kind
                     goes that has most part in it */
};

/* Rows that were dropped are taken back where they are farther than this from the span of those
 * kept, squared; in turns, as often at most. */
static const double apart = 2.0 * MBSRI_DEPENDENT;
enum { TURNS = 12 };

bool mbsri_any_stiff(const mbsr_model *m)
{
    const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
    bool any = false;
    for (; c < end; ++c) {
        for (int k = 0; k < c->position_rows; ++k) any = any || mbsri_is_stiff(c, k);
    }
    return any;
}

void mbsri_row_fronts_order(mbsri_row_fronts *w, const int *late)
{
    const mbsri_closure *first = mbsri_all_closures(w->m), *end = first + w->m->closures.count;
    int place = 0;
    for (int round = 0; round <= MBSRI_LATEST; ++round) {
        for (const mbsri_closure *c = first; c < end; ++c) {
            for (int k = 0; k < c->rows; ++k) {
                const int kind = late ? late[c->row + k] : 0,
                          own = k >= c->position_rows ? MBSRI_LATEST : kind;
                w->kind[c->row + k] = kind;
                if (own == round) w->order[c->row + k] = place++;
            }
        }
    }
}

static int no_memory_for_rows(const mbsr_model *m, mbsr_data *d, const char *function)
{
    return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for ranks of %d rows of closures", function, m->rows);
}

static int first_tied(int *tree, int i)
{
    while (tree[i] != i) i = tree[i] = tree[tree[i]];
    return i;
}

/* tree: bodies + 1, the first of those that are joined; number: as many, their part. */
static void find_parts(mbsri_row_fronts *w, int *tree, int *number)
{
    const mbsr_model *m = w->m;
    const mbsri_closure *first = mbsri_all_closures(m), *end = first + m->closures.count;
    for (int i = 0; i <= m->bodies; ++i) {
        tree[i] = i == 0 || m->body[i].parent == 0 ? i : first_tied(tree, m->body[i].parent);
        number[i] = -1;
    }
    for (const mbsri_closure *c = first; c < end; ++c) {
        int joined = 0;
        for (int l = 0; l < c->bodies; ++l) {
            const int own = first_tied(tree, c->body[l]);
            if (own > 0 && joined > 0) tree[own] = joined;
            if (own > 0) joined = first_tied(tree, own);
        }
    }
    w->parts = 0;
    for (const mbsri_closure *c = first; c < end; ++c) {
        int own = 0;
        for (int l = 0; l < c->bodies && own == 0; ++l) own = first_tied(tree, c->body[l]);
        if (number[own] < 0) number[own] = w->parts++;
        for (int k = 0; k < c->rows; ++k) w->part_of_row[c->row + k] = number[own];
    }
    for (int i = 1; i <= m->bodies; ++i) {
        for (int l = 0; l < m->body[i].n; ++l)
            w->part_of_rate[m->body[i].u + l] = number[first_tied(tree, i)];
    }
}

int mbsri_row_fronts_open(const mbsr_model *m, mbsr_data *d, const double *span,
                          const char *function, mbsri_row_fronts **fronts)
{
    const size_t nu = (size_t)m->nu, rows = (size_t)m->rows, numbers = 3 * nu + 5 * rows,
                 bodies = (size_t)m->bodies + 1, ints = 4 * rows + nu + 2 * bodies;
    mbsri_row_fronts *w = mbsri_allocate(
        &m->allocator, sizeof *w + numbers * sizeof(double) + m->closures.count * sizeof(tied) +
                           ints * sizeof(int) + 4 * rows * sizeof(bool));
    *fronts = w;
    if (!w) return no_memory_for_rows(m, d, function);
    *w = (mbsri_row_fronts){
        .m = m, .d = d, .function = function, .span = span, .metric = (double *)(void *)(w + 1)};
    w->g = w->metric + nu;
    w->x = w->g + nu;
    w->zero = w->x + nu;
    w->lambda = w->zero + rows;
    w->inverse = w->lambda + rows;
    w->scale = w->inverse + rows;
    w->compliance = w->scale + rows;
    w->part = (tied *)(void *)(w->compliance + rows);
    w->order = (int *)(void *)(w->part + m->closures.count);
    w->kind = w->order + rows;
    w->part_of_row = w->kind + rows;
    w->listed = w->part_of_row + rows;
    w->part_of_rate = w->listed + rows;
    w->shared = (bool *)(w->part_of_rate + nu + 2 * bodies);
    w->more = w->shared + rows;
    w->other = w->more + rows;
    w->taken = w->other + rows;
    mbsri_zero(rows, w->zero);
    for (size_t k = 0; k < nu; ++k) w->x[k] = 1.0 / (span[k] * span[k]);
    mbsri_gather(m, w->x, w->metric);
    mbsri_row_fronts_order(w, NULL);
    find_parts(w, w->part_of_rate + nu, w->part_of_rate + nu + bodies);
    return mbsri_fronts_open(&w->system, m, d, true, function);
}

void mbsri_row_fronts_close(mbsri_row_fronts *w)
{
    mbsri_fronts_close(&w->system);
    mbsri_release(&w->m->allocator, w);
}

const bool *mbsri_row_fronts_shared(const mbsri_row_fronts *w)
{
    return w->shared;
}

enum { KINDS = 3 };

/* Sets squares of rows to zero that are rounding of what they have of their bodies: no joint moves
 * against them. */
static void clear_rounding(const mbsri_row_fronts *w, double *square)
{
    const mbsri_closure *first = mbsri_all_closures(w->m), *end = first + w->m->closures.count;
    const double lever = mbsri_longest_lever(w->m, w->d);
    for (const mbsri_closure *c = first; c < end; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            double size = 0.0;
            for (int l = 0; l < c->bodies; ++l) {
                double turn, move;
                if (c->column[l] < 0) continue;
                mbsri_row_parts(w->m, w->d, c, l, k, &turn, &move);
                size = fmax(size, turn + lever * move);
            }
            if (square[c->row + k] <= pow(mbsri_row_rounding(c) * size, 2))
                square[c->row + k] = 0.0;
        }
    }
}

/* The length to which each row is compared, as those of ranks.h. */
static void find_scales(mbsri_row_fronts *w)
{
    const mbsri_closure *first = mbsri_all_closures(w->m), *end = first + w->m->closures.count;
    double largest[KINDS] = {0.0};
    double *square = w->lambda;
    mbsri_row_squares(w->m, w->d, w->span, square);
    clear_rounding(w, square);
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

/* g = C^T of the rows of `those`, of length 1, with signs; false: there are none. */
static bool add_rows(mbsri_row_fronts *w, const bool *those, bool has)
{
    bool any = false;
    for (int k = 0; k < w->m->rows; ++k) {
        const double sign = k % 3 == 1 ? -1.0 : 1.0;
        const bool taken = those[k] == has;
        any = any || taken;
        w->inverse[k] = taken && w->scale[k] > 0.0 ? sign / w->scale[k] : 0.0;
    }
    if (any) mbsri_closure_transpose(w->m, w->d, w->inverse, w->g);
    return any;
}

/* Lists the rows of w->more, part by part; at first those of a part stand together. */
static void list_rows(mbsri_row_fronts *w)
{
    int used = 0;
    for (int p = 0; p < w->parts; ++p) w->part[p] = (tied){.length = 1};
    for (int k = 0; k < w->m->rows; ++k) w->part[w->part_of_row[k]].count += w->more[k];
    for (int p = 0; p < w->parts; ++p) {
        tied *t = w->part + p;
        t->first = used;
        used += t->count;
        while (t->length < t->count) t->length *= 2;
        t->count = 0;
    }
    for (int k = 0; k < w->m->rows; ++k) {
        tied *t = w->part + w->part_of_row[k];
        if (w->more[k]) w->listed[t->first + t->count++] = k;
    }
}

/* Takes the rows of each part that are to be looked at; false: there are none. */
static bool take_intervals(const mbsri_row_fronts *w)
{
    bool any = false;
    for (int k = 0; k < w->m->rows; ++k) w->taken[k] = false;
    for (int p = 0; p < w->parts; ++p) {
        const tied *t = w->part + p;
        for (int k = t->at; k < t->at + t->length && k < t->count; ++k)
            any = w->taken[w->listed[t->first + k]] = true;
    }
    return any;
}

/* What the rows taken have together beside the span of those kept, squared, part by part: of
 * g + C^T lambda itself, so that it is no smaller than the true one, whatever lambda. */
static void measure_parts(mbsri_row_fronts *w, const bool *dropped)
{
    (void)project(w);
    for (int k = 0; k < w->m->rows; ++k) w->lambda[k] = dropped[k] ? 0.0 : w->lambda[k];
    mbsri_closure_transpose(w->m, w->d, w->lambda, w->x);
    for (int p = 0; p < w->parts; ++p) w->part[p].square = 0.0;
    for (int j = 0; j < w->m->nu; ++j) {
        const double left = (w->g[j] + w->x[j]) * w->span[j];
        if (w->part_of_rate[j] >= 0) w->part[w->part_of_rate[j]].square += left * left;
    }
}

/* Marks in w->other the rows that w->more has and that do not depend on those kept; of all others
 * the largest distance. Halves of what is apart, of all parts at once, from first to last. */
static bool find_apart(mbsri_row_fronts *w, const bool *dropped, double *largest)
{
    bool found = false;
    list_rows(w);
    while (take_intervals(w)) {
        (void)add_rows(w, w->taken, true);
        measure_parts(w, dropped);
        for (int p = 0; p < w->parts; ++p) {
            tied *t = w->part + p;
            if (t->at >= t->count) continue;
            const bool one = t->length == 1 || t->at + 1 == t->count;
            if (t->square > apart && !one) {
                t->length /= 2;
                continue;
            }
            if (t->square > apart)
                found = w->other[w->listed[t->first + t->at]] = true;
            else
                *largest = fmax(*largest, t->square);
            t->at += t->length;
            while (t->length < t->count && t->at % (2 * t->length) == 0) t->length *= 2;
        }
    }
    return found;
}

/* Whether forces of the rows kept are found from what they do, and better from what that leaves:
 * not where rows depend on others. */
static bool are_kept_found(mbsri_row_fronts *w, const bool *dropped)
{
    static const double part = 1e-3;
    bool found = false;
    if (!add_rows(w, dropped, false)) return true;
    for (int pass = 0; pass < 2 && !found; ++pass) {
        if (pass > 0) mbsri_closure_transpose(w->m, w->d, w->inverse, w->g);
        (void)project(w);
        found = true;
        for (int k = 0; k < w->m->rows; ++k) {
            if (dropped[k]) continue;
            w->inverse[k] += w->lambda[k];
            found = found && fabs(w->inverse[k]) * w->scale[k] <= part;
        }
    }
    return found;
}

/* Of rows without those of `without`. */
static void measure_rows(mbsri_row_fronts *w, const bool *without, const bool *dropped,
                         mbsri_ranks *found)
{
    for (int k = 0; k < w->m->rows; ++k) {
        if (without && without[k]) continue;
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

/* (C W C^T)^-1 of row k into w->lambda; the row of the greatest place that it clearly has. These
 * are marked in w->more. */
static int last_beside(mbsri_row_fronts *w, int k)
{
    static const double clear = 1e-3;
    double largest = 0.0;
    int last = k;
    mbsri_zero((size_t)w->m->nu, w->g);
    w->zero[k] = 1.0;
    mbsri_fronts_solve(&w->system, w->g, w->zero, w->x, w->lambda);
    w->zero[k] = 0.0;
    for (int l = 0; l < w->m->rows; ++l) largest = fmax(largest, fabs(w->lambda[l]) * w->scale[l]);
    for (int l = 0; l < w->m->rows; ++l) {
        if (!(fabs(w->lambda[l]) * w->scale[l] > clear * largest)) continue;
        w->more[l] = true;
        if (w->order[l] > w->order[last]) last = l;
    }
    return last;
}

/* Drops rows that are next to the span of those before, by what each is from all others,
 * w->inverse; whether there are some. With y of (C W C^T)^-1, |C^T y|^2 = y_k. */
static bool drop_next_to_others(mbsri_row_fronts *w, bool *dropped)
{
    bool any = false;
    for (int k = 0; k < w->m->rows; ++k) w->more[k] = false;
    for (int k = 0; k < w->m->rows; ++k) {
        const double size = w->inverse[k] * w->scale[k] * w->scale[k];
        if (dropped[k] || w->more[k] || size * MBSRI_DEPENDENT < 1.0) continue;
        const int last = last_beside(w, k);
        const double part = w->lambda[last] * w->scale[last];
        if (w->lambda[k] <= MBSRI_DEPENDENT * part * part) dropped[last] = any = true;
    }
    return any;
}

/* Marks in w->more rows that depend on others as the factors are. */
static int find_idle(mbsri_row_fronts *w, bool *shared)
{
    return mbsri_idle_rows(&w->system, w->careful ? w->kind : w->order, w->more, shared)
               ? MBSR_OK
               : no_memory_for_rows(w->m, w->d, w->function);
}

/* The factors without the rows dropped, and what these are wrong about, where digits got lost:
 * *changed. */
static int mend(mbsri_row_fronts *w, const bool *without, bool *dropped, double *largest,
                bool *changed)
{
    const int rows = w->m->rows;
    for (int k = 0; k < rows; ++k) w->system.left_out[k] = dropped[k];
    int status = mbsri_fronts_factor(&w->system, w->metric, w->function);
    if (!status) status = find_idle(w, w->other);
    *changed = false;
    *largest = 0.0;
    for (int k = 0; k < rows && !status; ++k) {
        if (w->more[k] && !dropped[k]) dropped[k] = *changed = true;
    }
    if (status || *changed) return status;
    for (int k = 0; k < rows; ++k) {
        w->more[k] = dropped[k] && !(without && without[k]);
        w->other[k] = false;
    }
    *changed = find_apart(w, dropped, largest);
    for (int k = 0; k < rows; ++k) dropped[k] = dropped[k] && !w->other[k];
    w->careful = w->careful || *changed;
    if (*changed) return MBSR_OK;
    if (!mbsri_fronts_spread(&w->system, w->inverse))
        return no_memory_for_rows(w->m, w->d, w->function);
    *changed = drop_next_to_others(w, dropped);
    return MBSR_OK;
}

/* The rows that depend on others by factors of all, but for digits that get lost. */
static int drop_idle(mbsri_row_fronts *w, const bool *without, bool *dropped)
{
    const int rows = w->m->rows;
    for (int k = 0; k < rows; ++k) w->system.left_out[k] = without && without[k];
    int status = mbsri_fronts_factor(&w->system, w->metric, w->function);
    if (!status) status = find_idle(w, w->shared);
    for (int k = 0; k < rows && !status; ++k)
        dropped[k] = w->more[k] || (without && without[k]) || !(w->scale[k] > 0.0);
    return status;
}

/* Rows that are taken back and dropped again are next to rounding: the factors decide, by which
 * equations are solved. */
static int leave_idle(mbsri_row_fronts *w, const bool *without, bool *dropped)
{
    int status = drop_idle(w, without, dropped);
    for (int k = 0; k < w->m->rows; ++k) w->system.left_out[k] = dropped[k];
    if (!status) status = mbsri_fronts_factor(&w->system, w->metric, w->function);
    if (!status && !mbsri_fronts_spread(&w->system, w->inverse))
        status = no_memory_for_rows(w->m, w->d, w->function);
    return status;
}

int mbsri_row_fronts_rank(mbsri_row_fronts *w, const bool *without, const bool *near, bool *dropped,
                          mbsri_ranks *found)
{
    bool changed = true;
    w->careful = false;
    find_scales(w);
    for (int k = 0; k < w->m->rows && near; ++k) dropped[k] = near[k];
    int status = near ? MBSR_OK : drop_idle(w, without, dropped);
    *found = (mbsri_ranks){.smallest_kept = INFINITY, .weakest = -1, .weakest_pivot = INFINITY};
    for (int turn = 0; turn < TURNS && changed && !status; ++turn)
        status = mend(w, without, dropped, &found->largest_dropped, &changed);
    if (!status && changed) status = leave_idle(w, without, dropped);
    if (status) return status;
    measure_rows(w, without, dropped, found);
    if ((found->independent > 0 && !(found->smallest_kept > 0.0)) || !are_kept_found(w, dropped))
        return mbsri_fail(&w->d->error, MBSR_LOOP_SINGULAR, MBSR_NONE, MBSR_NONE,
                          "%s: not found which rows of closures depend on others: digits get lost",
                          w->function);
    return MBSR_OK;
}

void mbsri_row_fronts_allow(mbsri_row_fronts *w, double *x)
{
    for (int j = 0; j < w->m->nu; ++j) w->g[j] = x[j] / w->span[j];
    (void)project(w);
    for (int j = 0; j < w->m->nu; ++j) x[j] = w->x[j] / w->span[j];
}

/* ---- forces that stiff rows share ---- */

/* Compliances in proportion to those of the springs, the largest `part` beside what rows move. */
static void fill_compliance(mbsri_row_fronts *w, const double *stiffness)
{
    static const double part = 1e-2;
    double softest = INFINITY;
    for (int k = 0; k < w->m->rows; ++k) {
        if (stiffness[k] > 0.0 && w->scale[k] > 0.0)
            softest = fmin(softest, stiffness[k] * w->scale[k] * w->scale[k]);
    }
    for (int k = 0; k < w->m->rows; ++k)
        w->compliance[k] = stiffness[k] > 0.0 ? part * softest / stiffness[k] : 0.0;
}

/* With W x - C^T lambda = -C^T given and C x + P (lambda - before) = 0, x goes to zero, a hundredth
 * of it being left each time, and P lambda is in the range of C. */
static void share_given(mbsri_row_fronts *w, double *lambda)
{
    enum { MOST = 40 };
    static const double enough = 1e-14;
    const int rows = w->m->rows;
    mbsri_closure_transpose(w->m, w->d, lambda, w->g);
    for (int j = 0; j < w->m->nu; ++j) w->g[j] = -w->g[j];
    mbsri_zero((size_t)rows, lambda);
    double change = 1.0, most = 0.0;
    for (int pass = 0; pass < MOST && change > enough * most; ++pass) {
        for (int k = 0; k < rows; ++k) w->inverse[k] = w->compliance[k] * lambda[k];
        mbsri_fronts_solve(&w->system, w->g, w->inverse, w->x, w->lambda);
        change = most = 0.0;
        for (int k = 0; k < rows; ++k) {
            change = fmax(change, fabs(w->lambda[k] - lambda[k]) * w->scale[k]);
            most = fmax(most, fabs(w->lambda[k]) * w->scale[k]);
            lambda[k] = w->lambda[k];
        }
    }
}

int mbsri_row_fronts_share(mbsri_row_fronts *w, const double *stiffness, const bool *left_out,
                           double *lambda)
{
    find_scales(w);
    fill_compliance(w, stiffness);
    for (int k = 0; k < w->m->rows; ++k) w->system.left_out[k] = left_out[k];
    w->system.compliance = w->compliance;
    const int status = mbsri_fronts_factor(&w->system, w->metric, w->function);
    if (!status) share_given(w, lambda);
    w->system.compliance = NULL;
    return status;
}

const double *mbsri_row_fronts_scales(mbsri_row_fronts *w)
{
    find_scales(w);
    return w->scale;
}

void mbsri_row_fronts_clear_traces(mbsri_row_fronts *w, double load, const double *doubt,
                                   double *lambda)
{
    static const double rounding = 1e-9, doubtful = 16.0;
    const double *scale = mbsri_row_fronts_scales(w);
    double largest = load, error = 0.0;
    for (int k = 0; k < w->m->rows; ++k) {
        largest = fmax(largest, fabs(lambda[k]) * scale[k]);
        error = fmax(error, doubtful * fabs(doubt[k]) * scale[k]);
    }
    error = fmax(error, rounding * largest);
    for (int k = 0; k < w->m->rows; ++k) {
        if (fabs(lambda[k]) * scale[k] <= error) lambda[k] = 0.0;
    }
}

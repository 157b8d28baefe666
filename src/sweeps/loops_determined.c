/* Inverse dynamics of loops whose forces follow from the joints without motors alone: see loops.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * As many of these as there are rows that are felt anywhere: X v = -e is square, whatever the
 * motors do. */
#include "sweeps/loops.h"

#include "algebra/dense.h"

#include <math.h>

/* Of a group: equations X v = b of the motions, what was added up in X, and what rows are. */
typedef struct determining {
    int motions, rows;
    double *X, *sizes; /* motions x rows, an equation behind the other */
    double *b;         /* motions */
    double *scale;    /* rows: largest number of the column, then its inverse; 0: nobody feels it */
    int *row, *pivot; /* rows: names; motions: the column eliminated */
} determining;

static bool is_row(const mbsri_loop_run *w, int id)
{
    return id < w->run->model->rows;
}

/* Places for the unknowns of a group, rows and motions each from 0 on, and memory behind what
 * waits; false: some are not complete at body i. */
static bool begin_group(const mbsri_loop_run *w, const mbsri_open_part *part, int head, int i,
                        determining *e)
{
    *e = (determining){.row = w->set};
    for (int p = head; p >= 0; p = w->mate[p]) {
        const mbsri_open open = mbsri_open_at(part + p);
        for (int k = 0; k < open.count; ++k) {
            const int id = open.id[k];
            if (w->slot[id] >= 0) continue;
            if (!is_row(w, id)) {
                w->slot[id] = e->motions++;
                continue;
            }
            if (w->loops->closes[id] < i) return false;
            w->slot[id] = e->rows;
            e->row[e->rows++] = id;
        }
    }
    const size_t entries = (size_t)e->motions * (size_t)e->rows;
    e->X = w->top;
    e->sizes = e->X + entries;
    e->b = e->sizes + entries;
    e->scale = e->b + e->motions;
    e->pivot = e->row + e->rows;
    mbsri_zero(2 * entries + (size_t)(e->motions + e->rows), e->X);
    return true;
}

static void clear_slots(const mbsri_loop_run *w, const mbsri_open_part *part, int head)
{
    for (int p = head; p >= 0; p = w->mate[p]) {
        const mbsri_open open = mbsri_open_at(part + p);
        for (int k = 0; k < open.count; ++k) w->slot[open.id[k]] = -1;
    }
}

/* The equations of the motions; false: a row that none of them feels is not idle. */
static bool fill_equations(const mbsri_loop_run *w, const mbsri_open_part *part, int head,
                           determining *e)
{
    int felt = 0;
    for (int p = head; p >= 0; p = w->mate[p]) {
        const mbsri_open open = mbsri_open_at(part + p);
        for (int k = 0; k < open.count; ++k) {
            if (is_row(w, open.id[k])) continue;
            const int at = w->slot[open.id[k]];
            e->b[at] = w->s[open.id[k]];
            for (int l = 0; l < open.count; ++l) {
                if (!is_row(w, open.id[l])) continue;
                const int column = w->slot[open.id[l]];
                e->X[at * e->rows + column] += open.F[k * open.count + l];
                e->sizes[at * e->rows + column] += open.sizes[k * open.count + l];
            }
        }
    }
    for (int k = 0; k < e->rows; ++k) {
        double largest = 0.0;
        for (int j = 0; j < e->motions; ++j) largest = fmax(largest, fabs(e->X[j * e->rows + k]));
        e->scale[k] = largest > 0.0 ? 1.0 / largest : 0.0;
        felt += largest > 0.0;
    }
    return felt == e->motions;
}

/* What a group leaves to the joints before it; false: a row that no motion feels is felt by others.
 */
static bool add_determined_force(mbsri_loop_run *w, const mbsri_open_part *part, int head,
                                 const determining *e, bool root)
{
    double force[6] = {0.0};
    for (int k = 0; k < e->rows; ++k) {
        const int id = e->row[k];
        double Q[8] = {0.0}, lengths[8] = {0.0}, F = 0.0;
        for (int p = head; p >= 0; p = w->mate[p]) {
            const mbsri_open open = mbsri_open_at(part + p);
            int at = 0;
            while (at < open.count && open.id[at] != id) ++at;
            if (at == open.count) continue;
            F += open.F[at * (open.count + 1)];
            for (int l = 0; l < 8; ++l) {
                Q[l] += open.Q[8 * at + l];
                lengths[l] += open.lengths[8 * at + l];
            }
        }
        const bool felt = e->scale[k] > 0.0;
        if (!felt && F != 0.0) return false;
        for (int l = 0; l < 8 && !root; ++l) {
            if (fabs(Q[l]) <= MBSRI_PIVOTS_ROUNDING * lengths[l]) continue;
            if (!felt) return false;
            force[l < 4 ? l : l - 1] += Q[l] * w->v[id];
        }
    }
    for (int l = 0; l < 6; ++l) w->force[l] += force[l];
    return true;
}

/* The column of equation j with the largest number beside those of its column. */
static int find_equation_pivot(const determining *e, int j)
{
    int best = 0;
    double largest = -1.0;
    for (int k = 0; k < e->rows; ++k) {
        const double beside = fabs(e->X[j * e->rows + k]) * e->scale[k];
        bool used = false;
        for (int l = 0; l < j; ++l) used = used || e->pivot[l] == k;
        if (used || beside <= largest) continue;
        largest = beside;
        best = k;
    }
    return best;
}

/* False: not plainly regular. */
static bool eliminate_system(const determining *e)
{
    static const double plainly = 1e-3; /* beside what was added up */
    const int n = e->rows;
    for (int j = 0; j < e->motions; ++j) {
        const double *x = e->X + j * n;
        const int at = e->pivot[j] = find_equation_pivot(e, j);
        if (!(fabs(x[at]) > plainly * e->sizes[j * n + at])) return false;
        for (int l = j + 1; l < e->motions; ++l) {
            double *y = e->X + l * n, *size = e->sizes + l * n;
            const double share = y[at] / x[at];
            if (share == 0.0) continue;
            for (int k = 0; k < n; ++k) {
                y[k] -= share * x[k];
                size[k] += fabs(share * x[k]);
            }
            e->b[l] -= share * e->b[j];
        }
    }
    return true;
}

/* v of the rows. */
static void substitute_rows(const mbsri_loop_run *w, const determining *e)
{
    for (int k = 0; k < e->rows; ++k) w->v[e->row[k]] = 0.0;
    for (int j = e->motions - 1; j >= 0; --j) {
        const double *x = e->X + j * e->rows;
        double sum = e->b[j];
        for (int l = j + 1; l < e->motions; ++l) sum -= x[e->pivot[l]] * w->v[e->row[e->pivot[l]]];
        w->v[e->row[e->pivot[j]]] = sum / x[e->pivot[j]];
    }
}

bool mbsri_open_loops_determine(mbsri_loop_run *w, const mbsri_open_part *part, int head, int i)
{
    determining e;
    bool served = begin_group(w, part, head, i, &e);
    served = served && fill_equations(w, part, head, &e) && eliminate_system(&e);
    if (served) substitute_rows(w, &e);
    served = served && add_determined_force(w, part, head, &e, i == 0);
    clear_slots(w, part, head);
    return served;
}

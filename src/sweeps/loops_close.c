/* Loops that close, in the vectorised sweeps: see loops_close.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/loops_close.h"

#include "algebra/dense.h"

#include <math.h>
#include <string.h>

/* ---- loops that close ---- */

void mbsri_loops_clear_sums(mbsri_loop_run *w)
{
    memset(w->Mbar, 0, sizeof w->Mbar);
    memset(w->noise, 0, sizeof w->noise);
    memset(w->force, 0, sizeof w->force);
}

static int index_of_four(int k)
{
    return k < 3 ? k : k + 1; /* in vectors of four numbers */
}

static void add_open_part(const mbsri_loop_run *w, const mbsri_open *open, mbsri_pivots *f)
{
    const int n = f->size, N = n + f->d;
    for (int j = 0; j < open->count; ++j) {
        const int column = w->slot[open->id[j]];
        double *A = f->A + column * N, *sizes = f->sizes + column * N;
        for (int l = 0; l < open->count; ++l) {
            A[w->slot[open->id[l]]] += open->F[j * open->count + l];
            sizes[w->slot[open->id[l]]] += open->sizes[j * open->count + l];
        }
        for (int l = 0; l < f->d; ++l) {
            A[n + l] += open->Q[8 * j + index_of_four(l)];
            sizes[n + l] += open->lengths[8 * j + index_of_four(l)];
        }
    }
}

/* Loads that are nothing but rounding are none: those of a loop that is closed balance. Then the
 * upper half. */
static void finish_loads(mbsri_pivots *f)
{
    const int n = f->size, N = n + f->d;
    for (int k = 0; k < n; ++k) {
        for (int l = n; l < N; ++l) {
            double *load = f->A + k * N + l;
            if (fabs(*load) <= MBSRI_PIVOTS_ROUNDING * f->sizes[k * N + l]) *load = 0.0;
            f->A[l * N + k] = *load;
            f->sizes[l * N + k] = f->sizes[k * N + l];
        }
    }
}

/* In the record to be kept; what is needed for a short time behind what waits. */
static mbsri_pivots *open_pivots(mbsri_loop_run *w, int i, int d, int size, int complete)
{
    const size_t n = (size_t)size;
    const size_t bytes = sizeof(mbsri_pivots) + (3 * n + (n + 1) / 2) * sizeof(double);
    mbsri_pivots *f = mbsri_open_loops_keep(w, i, bytes);
    w->last->closes = true;
    *f = (mbsri_pivots){
        .size = size, .complete = complete, .d = d, .scale = (double *)(void *)(f + 1)};
    f->value = f->scale + n;
    f->across = f->value + n;
    f->id = (int *)(void *)(f->across + n);
    f->A = w->store;
    f->sizes = w->top;
    f->shared = w->run->model->rows;
    f->share = w->share;
    return f;
}

/* What the accelerations behind the pivots get. */
static void add_open_mass(mbsri_loop_run *w, const mbsri_pivots *f)
{
    const int n = f->size, d = f->d, N = n + d;
    for (int k = 0; k < d; ++k) {
        for (int l = 0; l < d; ++l) w->Mbar[k * d + l] -= f->A[(n + k) * N + n + l];
        w->noise[k] += f->sizes[(n + k) * (N + 1)];
    }
}

/* Rows that nothing is left of share by least norm; false: so is a motion, which nothing
 * determines. */
static bool settle_left(mbsri_loop_run *w, mbsri_pivots *f)
{
    const size_t n = (size_t)f->size, N = n + (size_t)f->d;
    bool *wanted = (bool *)(void *)w->top;
    w->store = f->A + n * N;
    f->idle = w->store;
    if (f->left == 0) return true;
    for (int l = 0; l < f->left; ++l) {
        wanted[l] = true;
        if (f->id[f->pivots + l] >= w->run->model->rows) return false;
    }
    mbsri_pivots_find_idle(f, wanted);
    w->store += (size_t)f->idles * n;
    return true;
}

/* The unknowns of loops that are open still, after those that have closed, from place `base` on. */
static void add_rest(const mbsri_pivots *f, const mbsri_open *to, int base)
{
    const int n = f->size, N = n + f->d, first = f->complete;
    for (int k = first; k < n; ++k) {
        const int column = base + k - first;
        for (int l = first; l < n; ++l) {
            const int entry = column * to->count + base + l - first;
            to->F[entry] = f->A[k * N + l];
            to->sizes[entry] = f->sizes[k * N + l];
        }
        for (int l = 0; l < f->d; ++l) {
            to->Q[8 * column + index_of_four(l)] = f->A[k * N + n + l];
            to->lengths[8 * column + index_of_four(l)] = f->sizes[k * N + n + l];
        }
    }
}

/* Whether the loads of a group, whose unknowns have their places, are nothing but rounding. */
static bool is_balanced(const mbsri_loop_run *w, const mbsri_open_part *part, int head, int size)
{
    double *Q = w->top, *lengths = Q + 8 * size;
    bool balanced = true;
    mbsri_zero(16 * (size_t)size, Q);
    for (int p = head; p >= 0; p = w->mate[p]) {
        const mbsri_open open = mbsri_open_at(part + p);
        for (int k = 0; k < open.count; ++k) {
            const int at = 8 * w->slot[open.id[k]];
            for (int l = 0; l < 8; ++l) {
                Q[at + l] += open.Q[8 * k + l];
                lengths[at + l] += open.lengths[8 * k + l];
            }
        }
    }
    for (int k = 0; k < 8 * size; ++k)
        balanced = balanced && fabs(Q[k]) <= MBSRI_PIVOTS_ROUNDING * lengths[k];
    return balanced;
}

bool mbsri_loops_close_group(mbsri_loop_run *w, const mbsri_open_part *part, int head, int i,
                             const int *set, int size, int complete, const mbsri_open *to, int base)
{
    const bool apart = w->motor && complete == size && is_balanced(w, part, head, size);
    mbsri_pivots *f = open_pivots(w, i, i > 0 && !apart ? 6 : 0, size, complete);
    const size_t N = (size_t)(size + f->d);
    mbsri_zero(N * N, f->A);
    mbsri_zero(N * N, f->sizes);
    memcpy(f->id, set, (size_t)size * sizeof *set);
    for (int p = head; p >= 0; p = w->mate[p]) {
        const mbsri_open open = mbsri_open_at(part + p);
        add_open_part(w, &open, f);
    }
    finish_loads(f);
    mbsri_pivots_eliminate(f);
    add_open_mass(w, f);
    add_rest(f, to, base);
    if (f->pivots + f->left < complete || !settle_left(w, f)) return false;
    mbsri_pivots_forward(f, w->s, w->force);
    return true;
}

/* ---- loops that close by themselves ---- */

static const double plainly = 1e-3; /* a pivot beside what was added up in it */

/* Whether all parts have the same unknowns, rows that are complete at body i. */
static bool are_alike(const mbsri_loop_run *w, const mbsri_open_part *part, int count, int i)
{
    const mbsri_open first = mbsri_open_at(part);
    for (int k = 0; k < first.count; ++k) {
        if (first.id[k] >= w->run->model->rows || w->loops->closes[first.id[k]] < i) return false;
    }
    for (int p = 1; p < count; ++p) {
        const mbsri_open open = mbsri_open_at(part + p);
        if (open.count != first.count) return false;
        for (int k = 0; k < first.count; ++k) {
            if (open.id[k] != first.id[k]) return false;
        }
    }
    return true;
}

/* Column j of [F; Q], on and below the diagonal; what was added up in its diagonal. */
static double add_part_column(const mbsri_open_part *part, int count, int j, const mbsri_pivots *f)
{
    const int n = f->size;
    double *A = f->A + j * (n + f->d), lengths[6] = {0.0}, size = 0.0;
    for (int l = j; l < n + f->d; ++l) A[l] = 0.0;
    for (int p = 0; p < count; ++p) {
        const mbsri_open open = mbsri_open_at(part + p);
        const double *F = open.F + j * n, *Q = open.Q + 8 * j, *own = open.lengths + 8 * j;
        for (int l = j; l < n; ++l) A[l] += F[l];
        size += open.sizes[j * n + j];
        for (int l = 0; l < f->d; ++l) {
            A[n + l] += Q[index_of_four(l)];
            lengths[l] += own[index_of_four(l)];
        }
    }
    for (int l = 0; l < f->d; ++l) {
        if (fabs(A[n + l]) <= MBSRI_PIVOTS_ROUNDING * lengths[l]) A[n + l] = 0.0;
    }
    return size;
}

/* Pivot p alone: what it adds to the inertia, and the columns behind it. */
static void take_pivot(mbsri_loop_run *w, mbsri_pivots *f, int p, double *sizes)
{
    const int n = f->size, N = n + f->d;
    double *x = f->A + p * N, *load = x + n;
    const double inverse = 1.0 / x[p];
    for (int k = 0; k < f->d; ++k) {
        const double share = load[k] * inverse;
        for (int l = 0; l < 6; ++l) w->Mbar[6 * k + l] += share * load[l];
        w->noise[k] += share * load[k];
    }
    for (int j = p + 1; j < n; ++j) {
        const double share = x[j] * inverse;
        double *y = f->A + j * N;
        if (share == 0.0) continue; /* mostly so where a row ties only few bodies */
        for (int l = j; l < N; ++l) y[l] -= share * x[l];
        sizes[j] += share * x[j];
    }
    for (int l = p + 1; l < N; ++l) x[l] *= inverse;
}

bool mbsri_loops_close_alone(mbsri_loop_run *w, const mbsri_open_part *part, int count, int i)
{
    mbsri_open_record *last = w->last;
    double *const store = w->store;
    if (!are_alike(w, part, count, i)) return false;
    const mbsri_open open = mbsri_open_at(part);
    mbsri_pivots *f = open_pivots(w, i, i > 0 ? 6 : 0, open.count, open.count);
    double *sizes = f->scale;
    bool plain = true;
    for (int k = 0; k < f->size; ++k) {
        f->id[k] = open.id[k];
        f->across[k] = 0.0;
        sizes[k] = add_part_column(part, count, k, f);
    }
    for (; f->pivots < f->size && plain; ++f->pivots) {
        const int p = f->pivots;
        plain = f->A[p * (f->size + f->d + 1)] > plainly * sizes[p];
        if (plain) take_pivot(w, f, p, sizes);
    }
    if (plain) {
        w->store = f->A + f->size * (f->size + f->d);
        mbsri_pivots_forward(f, w->s, w->force);
        return true;
    }
    mbsri_loops_clear_sums(w);
    w->last = last;
    w->store = store;
    return false;
}

/* ---- loops that close where others go on ---- */

/* The matrix of a group, on and below its diagonal, what was added up there, and lengths of the
 * loads (8 each). */
static void gather_group(const mbsri_loop_run *w, const mbsri_open_part *part, int head,
                         const mbsri_pivots *f, double *sizes, double *lengths)
{
    const int n = f->size, N = n + f->d;
    mbsri_zero((size_t)(n * N), f->A);
    mbsri_zero((size_t)n, sizes);
    mbsri_zero(8 * (size_t)n, lengths);
    for (int p = head; p >= 0; p = w->mate[p]) {
        const mbsri_open open = mbsri_open_at(part + p);
        for (int j = 0; j < open.count; ++j) {
            const int column = w->slot[open.id[j]];
            double *A = f->A + column * N;
            for (int l = 0; l < open.count; ++l) {
                const int row = w->slot[open.id[l]];
                if (row >= column) A[row] += open.F[j * open.count + l];
            }
            sizes[column] += open.sizes[j * open.count + j];
            for (int l = 0; l < f->d; ++l) A[n + l] += open.Q[8 * j + index_of_four(l)];
            for (int l = 0; l < 8; ++l) lengths[8 * column + l] += open.lengths[8 * j + l];
        }
    }
    for (int j = 0; j < f->complete; ++j) { /* as finish_loads */
        double *load = f->A + j * N + n;
        for (int l = 0; l < f->d; ++l) {
            if (fabs(load[l]) <= MBSRI_PIVOTS_ROUNDING * lengths[8 * j + index_of_four(l)])
                load[l] = 0.0;
        }
    }
}

/* What was added up in the numbers of the unknowns that go on: by their parts, then by the pivots.
 */
static void gather_sizes(const mbsri_loop_run *w, const mbsri_open_part *part, int head,
                         const mbsri_pivots *f, const mbsri_open *to, int base)
{
    const int first = f->complete;
    for (int p = head; p >= 0; p = w->mate[p]) {
        const mbsri_open open = mbsri_open_at(part + p);
        for (int j = 0; j < open.count; ++j) {
            const int column = w->slot[open.id[j]] - first;
            for (int l = 0; l < open.count && column >= 0; ++l) {
                const int row = w->slot[open.id[l]] - first;
                if (row < 0) continue;
                to->sizes[(base + column) * to->count + base + row] +=
                    open.sizes[j * open.count + l];
            }
        }
    }
}

/* The unknowns that go on, when all pivots are taken. */
static void add_passing(const mbsri_pivots *f, const double *lengths, const mbsri_open *to,
                        int base)
{
    const int n = f->size, N = n + f->d, first = f->complete;
    for (int j = first; j < n; ++j) {
        const int column = base + j - first;
        const double *A = f->A + j * N;
        for (int l = 0; l < 8; ++l) to->lengths[8 * column + l] = lengths[8 * j + l];
        for (int p = 0; p < first; ++p) {
            const double *L = f->A + p * N, size = fabs(L[j] * L[p]);
            for (int l = 0; l < f->d; ++l)
                to->lengths[8 * column + index_of_four(l)] += size * fabs(L[n + l]);
            for (int l = first; l < n; ++l)
                to->sizes[column * to->count + base + l - first] += size * fabs(L[l]);
        }
        for (int l = j; l < n; ++l) {
            const int row = base + l - first;
            const double size = to->sizes[column * to->count + row],
                         x = fabs(A[l]) <= MBSRI_PIVOTS_ROUNDING * size ? 0.0 : A[l];
            to->F[column * to->count + row] = to->F[row * to->count + column] = x;
        }
        for (int l = 0; l < f->d; ++l) {
            double *Q = to->Q + 8 * column + index_of_four(l);
            const double size = to->lengths[8 * column + index_of_four(l)];
            *Q = fabs(A[n + l]) <= MBSRI_PIVOTS_ROUNDING * size ? 0.0 : A[n + l];
        }
    }
}

bool mbsri_loops_close_plainly(mbsri_loop_run *w, const mbsri_open_part *part, int head, int i,
                               const int *set, int size, int complete, const mbsri_open *to,
                               int base)
{
    mbsri_open_record *last = w->last;
    double *const store = w->store;
    bool plain = !w->motor;
    for (int k = 0; k < size; ++k) plain = plain && set[k] < w->run->model->rows;
    if (!plain) return false;
    mbsri_pivots *f = open_pivots(w, i, i > 0 ? 6 : 0, size, complete);
    double *sizes = f->scale, *lengths = f->sizes, Mbar[36], noise[6];
    memcpy(Mbar, w->Mbar, sizeof Mbar);
    memcpy(noise, w->noise, sizeof noise);
    memcpy(f->id, set, (size_t)size * sizeof *set);
    mbsri_zero((size_t)size, f->across);
    gather_group(w, part, head, f, sizes, lengths);
    for (; f->pivots < complete && plain; ++f->pivots) {
        const int p = f->pivots;
        plain = f->A[p * (size + f->d + 1)] > plainly * sizes[p];
        if (plain) take_pivot(w, f, p, sizes);
    }
    if (plain) {
        gather_sizes(w, part, head, f, to, base);
        add_passing(f, lengths, to, base);
        w->store = f->A + size * (size + f->d);
        mbsri_pivots_forward(f, w->s, w->force);
        return true;
    }
    memcpy(w->Mbar, Mbar, sizeof Mbar);
    memcpy(w->noise, noise, sizeof noise);
    w->last = last;
    w->store = store;
    return false;
}

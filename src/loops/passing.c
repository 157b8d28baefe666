/* What is unknown of loops, past a joint: see passing.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops/passing.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "recursion/closures.h"

#include <math.h>

static int still_open(const mbsri_pivots *f)
{
    return f->size - f->pivots - f->left;
}

/* What is open at body i: how many unknowns; and these. */
static int count_open(const mbsri_system *w, int i)
{
    int count = 0;
    for (const mbsri_pivots *f = w->closing[i]; f; f = f->next) count += still_open(f);
    return count;
}

static void list_open(const mbsri_system *w, int i, int *id)
{
    for (const mbsri_pivots *f = w->closing[i]; f; f = f->next) {
        for (int k = f->pivots + f->left; k < f->size; ++k) *id++ = f->id[k];
    }
}

/* F of what is open, into what is carried on. */
static void copy_open(const mbsri_system *w, int i, mbsri_waiting *p)
{
    int at = 0;
    for (const mbsri_pivots *f = w->closing[i]; f; f = f->next) {
        const int N = f->size + f->d, first = f->pivots + f->left;
        for (int k = first; k < f->size; ++k) {
            for (int l = first; l < f->size; ++l) {
                const int entry = (at + k - first) * p->count + at + l - first;
                p->F[entry] = f->A[k * N + l];
                p->sizes[entry] = f->sizes[k * N + l];
            }
        }
        at += still_open(f);
    }
}

/* E: what rows read of the joint itself, taken from X (n numbers a column), and added to what X consists of. */
static void read_joint(mbsri_system *w, int i, int count, const int *id, double *X, double *parts)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const mbsri_body *b = w->m->body + i;
    for (int k = 0; k < count; ++k) w->slot[id[k]] = k;
    for (int end = w->first_end[i]; end >= 0; end = w->next_end[end]) {
        const mbsri_closure *c = first + end / MBSRI_ENDS;
        if (!(c->def.table->flags & MBSR_CLOSURE_JOINTS)) continue;
        const double *C =
            w->d->closure_C + c->at + (size_t)((c->column[end % MBSRI_ENDS] + b->d) * c->rows);
        for (int j = 0; j < b->n; ++j, C += c->rows) {
            for (int k = 0; k < c->rows; ++k) {
                const int column = w->slot[c->row + k];
                if (column < 0) continue;
                mbsri_share(fabs(C[k]), 0.0, 0.0, w->share + c->row + k);
                X[column * b->n + j] -= C[k];
                parts[column * b->n + j] += fabs(C[k]);
            }
        }
    }
    for (int k = 0; k < count; ++k) w->slot[id[k]] = -1;
}

/* X = J^T Q - E, without what is rounding in it. */
static void project(mbsri_system *w, int i, int count, const int *id, double *X, double *parts)
{
    const mbsri_body *b = w->m->body + i;
    const double *J = w->d->J + b->dn;
    int at = 0;
    mbsri_zero((size_t)(b->n * count), X);
    mbsri_zero((size_t)(b->n * count), parts);
    for (const mbsri_pivots *f = w->closing[i]; f; f = f->next) {
        const int n = f->size, N = n + f->d;
        for (int k = f->pivots + f->left; k < n; ++k, ++at) {
            for (int j = 0; j < b->n; ++j) {
                for (int l = 0; l < b->d; ++l) {
                    X[at * b->n + j] += J[j * b->d + l] * f->A[k * N + n + l];
                    parts[at * b->n + j] += fabs(J[j * b->d + l]) * f->sizes[k * N + n + l];
                }
            }
        }
    }
    read_joint(w, i, count, id, X, parts);
    for (int k = 0; k < b->n * count; ++k) {
        if (fabs(X[k]) <= MBSRI_PIVOTS_ROUNDING * parts[k]) X[k] = 0.0;
    }
}

/* Column l of N, the null space of the joint's D: its largest number is 1, whatever rounding there is in D. */
static void null_column(const mbsri_system *w, int i, int l, double *N)
{
    const mbsri_body *b = w->m->body + i;
    const double *x = w->d->X + b->nn + (size_t)(l * b->n);
    for (int k = 0; k < b->n; ++k)
        N[k] = fabs(x[k]) > MBSRI_PIVOTS_ROUNDING ? w->d->s[b->ig + k] * x[k] : 0.0;
    const double largest = mbsri_largest(b->n, N);
    for (int k = 0; k < b->n; ++k) N[k] /= largest;
}

/* -N^T X of null motion N (n), and what was added up in it; false where it is zero: no loop holds it. */
static bool null_row(int n, int count, const double *N, const double *X, double *row, double *sizes)
{
    bool some = false;
    for (int k = 0; k < count; ++k) {
        row[k] = sizes[k] = 0.0;
        for (int j = 0; j < n; ++j) {
            row[k] -= N[j] * X[k * n + j];
            sizes[k] += fabs(N[j] * X[k * n + j]);
        }
        if (fabs(row[k]) <= 10.0 * MBSRI_PIVOTS_ROUNDING * sizes[k]) row[k] = 0.0;
        some = some || row[k] != 0.0;
    }
    return some;
}

/* X, and N of those motions without mass that a loop holds; NULL: no memory. parts: as project has them, of
 * n x count; row: 2 count. */
static mbsri_passing *see_joint(mbsri_system *w, int i, int count)
{
    const mbsri_body *b = w->m->body + i;
    const int rank = w->d->rank[i], nulls = b->n - rank;
    const size_t k = (size_t)count, n = (size_t)b->n, all = k + (size_t)nulls;
    mbsri_passing *p =
        mbsri_system_allocate(w, sizeof *p + n * all * sizeof(double) + all * sizeof(int));
    double *scratch = mbsri_system_allocate(w, (n * k + 2 * k) * sizeof *scratch);
    if (!p || !scratch) return NULL;
    *p = (mbsri_passing){.count = count, .X = (double *)(void *)(p + 1)};
    p->N = p->X + n * k;
    p->id = (int *)(void *)(p->X + n * all);
    list_open(w, i, p->id);
    project(w, i, count, p->id, p->X, scratch);
    for (int l = rank; l < b->n; ++l) {
        double *N = p->N + p->nulls * b->n, *row = scratch + n * k;
        null_column(w, i, l, N);
        if (null_row(b->n, count, N, p->X, row, row + k))
            p->id[count + p->nulls++] = w->m->rows + b->iu + l;
        else
            w->free = b->iu + l;
    }
    return p;
}

/* F + X^T D^+ X, with the rows of null motions. */
static void add_joint(const mbsri_system *w, int i, const mbsri_passing *p, mbsri_waiting *to)
{
    const mbsri_body *b = w->m->body + i;
    const double *Dinv = w->d->Dinv + b->nn;
    const int n = b->n;
    for (int k = 0; k < p->count; ++k) {
        for (int l = 0; l < p->count; ++l) {
            double sum = 0.0, size = 0.0;
            for (int r = 0; r < n; ++r) {
                for (int c = 0; c < n; ++c) {
                    const double part = p->X[l * n + r] * Dinv[c * n + r] * p->X[k * n + c];
                    sum += part;
                    size += fabs(part);
                }
            }
            to->F[k * to->count + l] += sum;
            to->sizes[k * to->count + l] += size;
        }
    }
    for (int l = 0; l < p->nulls; ++l) {
        const int at = (p->count + l) * to->count;
        null_row(n, p->count, p->N + l * n, p->X, to->F + at, to->sizes + at);
        for (int k = 0; k < p->count; ++k) {
            to->F[k * to->count + p->count + l] = to->F[at + k];
            to->sizes[k * to->count + p->count + l] = to->sizes[at + k];
        }
    }
}

/* Q - G X of one unknown (rest), and what was added up in it: |Q| + |U| |D^+| |X|, which has the large numbers of a D^+
 * that cancel in G X. */
static void take_joint(const mbsri_system *w, const mbsri_body *b, const double *X, double *rest,
                       double *sizes)
{
    const double *U = w->d->U + b->dg, *G = w->d->G + b->dg, *Dinv = w->d->Dinv + b->nn;
    for (int j = 0; j < b->n; ++j) {
        double size = 0.0;
        for (int k = 0; k < b->n; ++k) size += fabs(Dinv[k * b->n + j] * X[k]);
        for (int r = 0; r < b->d; ++r) {
            rest[r] -= G[j * b->d + r] * X[j];
            sizes[r] += fabs(U[j * b->d + r]) * size;
        }
    }
}

/* Q_pred = -H^T (Q - G X), and what was added up in it. work: 2 d. */
static void carry_loads(const mbsri_system *w, int i, const mbsri_passing *p, mbsri_waiting *to,
                        double *work)
{
    const mbsri_body *b = w->m->body + i;
    const double *H = w->d->H + b->dp;
    int at = 0;
    for (const mbsri_pivots *f = w->closing[i]; f; f = f->next) {
        const int n = f->size, N = n + f->d;
        for (int k = f->pivots + f->left; k < n; ++k, ++at) {
            mbsri_copy((size_t)b->d, f->A + k * N + n, work);
            mbsri_copy((size_t)b->d, f->sizes + k * N + n, work + b->d);
            take_joint(w, b, p->X + at * b->n, work, work + b->d);
            for (int c = 0; c < b->d_pred; ++c) {
                for (int r = 0; r < b->d; ++r) {
                    to->Q[at * b->d_pred + c] -= H[c * b->d + r] * work[r];
                    to->lengths[at * b->d_pred + c] += fabs(H[c * b->d + r]) * work[b->d + r];
                }
            }
        }
    }
}

/* Marks those of `count` rows (columns numbers each, one behind the other, that get lost) that depend on the
 * others, by elimination with the largest pivots. */
static void find_dependent(int count, int columns, double *rows, bool *dependent)
{
    static const double nothing = 1e-11;
    for (int k = 0; k < count; ++k) {
        double *row = rows + k * columns, largest = 0.0;
        for (int j = 0; j < columns; ++j) largest = fmax(largest, fabs(row[j]));
        for (int j = 0; j < columns && largest > 0.0; ++j) row[j] /= largest;
        dependent[k] = true;
    }
    for (int turn = 0; turn < count; ++turn) {
        int best = -1, column = 0;
        double largest = nothing;
        for (int k = 0; k < count; ++k) {
            for (int j = 0; j < columns && dependent[k]; ++j) {
                if (fabs(rows[k * columns + j]) <= largest) continue;
                largest = fabs(rows[k * columns + j]);
                best = k;
                column = j;
            }
        }
        if (best < 0) return;
        dependent[best] = false;
        for (int k = 0; k < count; ++k) {
            const double share = rows[k * columns + column] / rows[best * columns + column];
            for (int j = 0; j < columns && dependent[k]; ++j)
                rows[k * columns + j] -= share * rows[best * columns + j];
        }
    }
}

/* Takes unknown k out of what is carried to a body of d velocities. */
static void leave_out(mbsri_waiting *p, int k, int d)
{
    const int n = p->count, left = n - 1;
    for (int j = 0, column = 0; j < n; ++j) {
        if (j == k) continue;
        for (int i = 0, row = 0; i < n; ++i) {
            if (i == k) continue;
            p->F[column * left + row] = p->F[j * n + i];
            p->sizes[column * left + row++] = p->sizes[j * n + i];
        }
        for (int i = 0; i < d; ++i) {
            p->Q[column * d + i] = p->Q[j * d + i];
            p->lengths[column * d + i] = p->lengths[j * d + i];
        }
        p->id[column++] = p->id[j];
    }
    p->count = left;
}

/* More motions without mass than rows cannot all be held by these: those whose rows depend on others are
 * determined by nothing, and are left out, so that no more is carried than the loops themselves need. */
static int limit_motions(mbsri_system *w, mbsri_waiting *p, int d)
{
    const int rows = w->m->rows, n = p->count, columns = n + d;
    int motions = 0;
    for (int k = 0; k < n; ++k) motions += p->id[k] >= rows;
    if (2 * motions <= n) return MBSR_OK;
    double *row = mbsri_system_allocate(w, (size_t)(motions * columns) * sizeof *row);
    bool *dependent = mbsri_system_allocate(w, (size_t)motions * sizeof *dependent);
    if (!row || !dependent) return MBSR_ERR_NO_MEMORY;
    for (int k = 0, to = 0; k < n; ++k) {
        if (p->id[k] < rows) continue;
        mbsri_copy((size_t)n, p->F + k * n, row + to * columns);
        mbsri_copy((size_t)d, p->Q + k * d, row + to * columns + n);
        ++to;
    }
    find_dependent(motions, columns, row, dependent);
    for (int k = n - 1; k >= 0; --k) {
        if (p->id[k] < rows || !dependent[--motions]) continue;
        w->free = p->id[k] - rows;
        leave_out(p, k, d);
    }
    return MBSR_OK;
}

int mbsri_system_pass(mbsri_system *w, int i)
{
    const mbsri_body *b = w->m->body + i;
    const int count = count_open(w, i);
    w->joint[i] = NULL;
    if (count == 0) {
        if (w->d->rank[i] < b->n) w->free = b->iu + w->d->rank[i];
        return MBSR_OK;
    }
    mbsri_passing *p = see_joint(w, i, count);
    mbsri_waiting *to = p ? mbsri_open_waiting(w, count + p->nulls, b->d_pred) : NULL;
    double *work = mbsri_system_allocate(w, 2 * (size_t)b->d * sizeof *work);
    if (!to || !work) return MBSR_ERR_NO_MEMORY;
    w->joint[i] = p;
    for (int k = 0; k < to->count; ++k) to->id[k] = p->id[k];
    copy_open(w, i, to);
    add_joint(w, i, p, to);
    carry_loads(w, i, p, to, work);
    to->next = w->behind[b->parent];
    w->behind[b->parent] = to;
    return limit_motions(w, to, b->d_pred);
}

/* What is unknown of loops, past a joint: see fronts.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fronts/assemble.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "recursion/closures.h"
#include "recursion/modal.h"
#include "recursion/rounding.h"

#include <math.h>

/* Those that pass of a front: the unknowns behind its pivots, but for the body's own motion. */
static int count_passing(const mbsri_pivots *f, const mbsri_body *b)
{
    return f->size + f->d - b->d - f->pivots - f->left;
}

/* E: what rows read of the joint itself, taken from X (n numbers a column), and added to what X
 * consists of. */
static void read_joint(mbsri_fronts *w, int i, int count, const int *id, double *X, double *parts)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const mbsri_body *b = w->m->body + i;
    for (int k = 0; k < count; ++k) w->slot[id[k]] = k;
    for (int end = w->plan->first_end[i]; end >= 0; end = w->plan->next_end[end]) {
        const mbsri_closure *c = first + end / MBSRI_ENDS;
        if (!mbsri_reads_joints(c)) continue;
        const double *C =
            w->d->closure_C + c->at + (size_t)((c->column[end % MBSRI_ENDS] + b->d) * c->rows);
        for (int j = 0; j < b->n; ++j, C += c->rows) {
            for (int k = 0; k < c->rows; ++k) {
                const int column = w->slot[c->row + k];
                if (column < 0) continue;
                mbsri_share_of_joint(w->m, b, j, C[k], w->share + c->row + k);
                X[column * b->n + j] -= C[k];
                parts[column * b->n + j] += fabs(C[k]);
            }
        }
    }
    for (int k = 0; k < count; ++k) w->slot[id[k]] = -1;
}

/* J^T Q of so many columns, and what is added up in it. */
static inline void project_columns(int d, int n, int count, int stride, const double *J,
                                   const double *Q, const double *sizes, double *X, double *parts)
{
    for (int k = 0; k < count; ++k, Q += stride, sizes += stride) {
        for (int j = 0; j < n; ++j) {
            double sum = 0.0, size = 0.0;
            for (int l = 0; l < d; ++l) {
                sum += J[j * d + l] * Q[l];
                size += fabs(J[j * d + l]) * sizes[l];
            }
            *X++ = sum;
            *parts++ = size;
        }
    }
}

/* X = J^T Q - E, without what is rounding in it. */
static void project(mbsri_fronts *w, int i, const mbsri_pivots *f, int count, const int *id,
                    double *X, double *parts)
{
    const mbsri_body *b = w->m->body + i;
    const int N = f->size + f->d, first = N - b->d - count;
    const double *J = w->d->J + b->dn, *Q = f->A + first * N + N - b->d,
                 *sizes = f->sizes + first * N + N - b->d;
    if (b->d == 6 && b->n == 1) /* sizes known to the compiler */
        project_columns(6, 1, count, N, J, Q, sizes, X, parts);
    else if (b->d == 3 && b->n == 1)
        project_columns(3, 1, count, N, J, Q, sizes, X, parts);
    else
        project_columns(b->d, b->n, count, N, J, Q, sizes, X, parts);
    read_joint(w, i, count, id, X, parts);
    for (int k = 0; k < b->n * count; ++k)
        X[k] = fabs(X[k]) <= MBSRI_PIVOTS_ROUNDING * parts[k] ? 0.0 : X[k];
}

void mbsri_fronts_null_column(const mbsri_fronts *w, int i, int l, double *N)
{
    const mbsri_body *b = w->m->body + i;
    const double *x = w->d->X + b->nn + (size_t)(l * b->n);
    for (int k = 0; k < b->n; ++k)
        N[k] = fabs(x[k]) > MBSRI_PIVOTS_ROUNDING ? w->d->s[b->group.iu + k] * x[k] : 0.0;
    const double largest = mbsri_largest(b->n, N);
    for (int k = 0; k < b->n; ++k) N[k] /= largest;
}

/* How far null motion N of a joint may be off, |D^+| |dD| |N|: what rank decisions take for
 * rounding in D, dD, turns it towards what has little mass. */
static void find_null_errors(const mbsri_fronts *w, const mbsri_body *b, const double *N,
                             double *errors)
{
    const mbsr_data *d = w->d;
    const double *Dinv = d->Dinv + b->nn,
                 *armature = d->armature ? d->armature + b->iu : b->mass.armature;
    const int n = b->n;
    double size = 0.0;
    mbsri_zero((size_t)n, errors);
    for (int j = 0; j < n; ++j) {
        const double added =
            sqrt(mbsri_along_itself(b, d->W + b->dd, d->J + b->dn, j, d->scratch) + armature[j]);
        size += fabs(N[j]) * added;
        for (int k = 0; k < n; ++k) errors[k] += fabs(Dinv[j * n + k]) * added;
    }
    for (int k = 0; k < n; ++k) errors[k] *= w->m->rank_tolerance * size;
}

/* -N^T X of null motion N (n), and what was added up in it; false where it is zero: no loop holds
 * it. errors: n of scratch. */
static bool null_row(const mbsri_fronts *w, const mbsri_body *b, int count, const double *N,
                     const double *X, double *row, double *sizes, double *errors)
{
    const int n = b->n;
    bool some = false;
    find_null_errors(w, b, N, errors);
    for (int k = 0; k < count; ++k) {
        double error = 0.0;
        row[k] = sizes[k] = 0.0;
        for (int j = 0; j < n; ++j) {
            row[k] -= N[j] * X[k * n + j];
            sizes[k] += fabs(N[j] * X[k * n + j]);
            error += errors[j] * fabs(X[k * n + j]);
        }
        if (fabs(row[k]) <= 10.0 * MBSRI_PIVOTS_ROUNDING * sizes[k] + error) row[k] = 0.0;
        some = some || row[k] != 0.0;
    }
    return some;
}

/* X, and N of those motions without mass that a loop holds; NULL: no memory. */
static mbsri_passing *see_joint(mbsri_fronts *w, int k, int count)
{
    const mbsri_pivots *f = &w->front;
    const int i = w->plan->step[k].body;
    const mbsri_body *b = w->m->body + i;
    const int rank = w->d->rank[i], nulls = b->n - rank;
    const size_t c = (size_t)count, n = (size_t)b->n, all = c + (size_t)nulls;
    mbsri_passing *p =
        mbsri_fronts_allocate(w, sizeof *p + n * all * sizeof(double) + all * sizeof(int));
    double *scratch = mbsri_fronts_scratch(w, n * c + 2 * c + n);
    if (!p || !scratch) return NULL;
    *p = (mbsri_passing){.count = count, .X = (double *)(void *)(p + 1)};
    p->N = p->X + n * c;
    p->id = (int *)(void *)(p->X + n * all);
    for (int l = 0; l < count; ++l) p->id[l] = f->id[f->size + f->d - b->d - count + l];
    project(w, i, f, count, p->id, p->X, scratch);
    for (int l = rank; l < b->n; ++l) {
        double *N = p->N + p->nulls * b->n, *row = scratch + n * c;
        mbsri_fronts_null_column(w, i, l, N);
        if (null_row(w, b, count, N, p->X, row, row + c, row + 2 * c))
            p->id[count + p->nulls++] = mbsri_rate_number(w, b) + l;
        else
            mbsri_fronts_note_free(w, b->iu + l);
    }
    return p;
}

/* A of what passes, and X^T D^+ X: columns of `count` numbers from A, where they begin N apart,
 * into to, `rows` apart. z, size: n of scratch. */
static inline void add_columns(int n, int count, const double *Dinv, const double *X, int N,
                               const double *A, const double *sizes, int rows, double *to,
                               double *to_sizes, double *z, double *size)
{
    for (int k = 0; k < count; ++k) {
        for (int r = 0; r < n; ++r) {
            z[r] = size[r] = 0.0;
            for (int c = 0; c < n; ++c) {
                const double part = Dinv[c * n + r] * X[k * n + c];
                z[r] += part;
                size[r] += fabs(part);
            }
        }
        for (int l = 0; l < count; ++l) {
            double sum = A[k * N + l], total = sizes[k * N + l];
            for (int r = 0; r < n; ++r) {
                sum += X[l * n + r] * z[r];
                total += fabs(X[l * n + r]) * size[r];
            }
            to[k * rows + l] = sum;
            to_sizes[k * rows + l] = total;
        }
    }
}

/* A of what passes, and X^T D^+ X, with the rows of null motions. work: 2 n. */
static void add_joint(const mbsri_fronts *w, const mbsri_pivots *f, const mbsri_body *b,
                      const mbsri_passing *p, mbsri_part *to, double *work)
{
    const double *Dinv = w->d->Dinv + b->nn;
    const int n = b->n, N = f->size + f->d, first = (N - b->d - p->count) * (N + 1),
              count = to->count;
    if (n == 1) /* a size known to the compiler */
        add_columns(1, p->count, Dinv, p->X, N, f->A + first, f->sizes + first, count, to->A,
                    to->sizes, work, work + 1);
    else
        add_columns(n, p->count, Dinv, p->X, N, f->A + first, f->sizes + first, count, to->A,
                    to->sizes, work, work + n);
    for (int l = p->count; l < p->count + p->nulls; ++l) {
        double *row = to->A + l * count, *sizes = to->sizes + l * count;
        null_row(w, b, p->count, p->N + (l - p->count) * n, p->X, row, sizes, work);
        for (int k = 0; k < p->count; ++k) {
            to->A[k * count + l] = row[k];
            to->sizes[k * count + l] = sizes[k];
        }
    }
}

/* Of the joint: G, |U| |D^+| with the sizes of what U was added up from, -H^T and |H|^T (d_pred x
 * d). */
typedef struct carrying {
    const double *G;
    double *errors, *H, *H_sizes;
} carrying;

static carrying see_body(const mbsri_fronts *w, const mbsri_body *b, double *work)
{
    const double *U = w->d->U + b->dg, *Dinv = w->d->Dinv + b->nn, *H = w->d->H + b->dp,
                 *W = w->d->W + b->dd, *s = w->d->s + b->group.iu;
    const int d = b->d, n = b->n, pred = b->pred.d;
    const carrying c = {w->d->G + b->dg, work, work + d * n, work + d * n + d * pred};
    for (int j = 0; j < n; ++j) {
        for (int r = 0; r < d; ++r) {
            double sum = 0.0;
            for (int k = 0; k < n; ++k) {
                const double size = sqrt(W[r * (d + 1)]) / s[k];
                sum += fmax(fabs(U[k * d + r]), size) * fabs(Dinv[j * n + k]);
            }
            c.errors[j * d + r] = sum;
        }
    }
    for (int k = 0; k < pred; ++k) {
        for (int r = 0; r < d; ++r) {
            c.H[r * pred + k] = -H[k * d + r];
            c.H_sizes[r * pred + k] = fabs(H[k * d + r]);
        }
    }
    return c;
}

/* -H^T (Q - G X) of one unknown, and what was added up in it: |H|^T (|Q| + |U| |D^+| |X|), which
 * has the large numbers of a D^+ that cancel in G X. rest, large: d of scratch. */
static inline void carry_column(int d, int n, int d_pred, const carrying *c, const double *X,
                                const double *Q, const double *Q_sizes, double *rest, double *large,
                                double *load, double *size)
{
    for (int r = 0; r < d; ++r) {
        rest[r] = Q[r];
        large[r] = Q_sizes[r];
    }
    for (int j = 0; j < n; ++j) {
        for (int r = 0; r < d; ++r) {
            rest[r] -= c->G[j * d + r] * X[j];
            large[r] += c->errors[j * d + r] * fabs(X[j]);
        }
    }
    for (int k = 0; k < d_pred; ++k) load[k] = size[k] = 0.0;
    for (int r = 0; r < d; ++r) {
        for (int k = 0; k < d_pred; ++k) {
            load[k] += c->H[r * d_pred + k] * rest[r];
            size[k] += c->H_sizes[r * d_pred + k] * large[r];
        }
    }
}

/* Q_pred = -H^T (Q - G X), and what was added up in it, for the predecessor's motion, which the
 * part has from w->slot on. work: d (n + 2) + 2 d_pred (d + 1). */
static void carry_loads(const mbsri_fronts *w, const mbsri_pivots *f, const mbsri_body *b,
                        const mbsri_passing *p, mbsri_part *to, double *work)
{
    const int d = b->d, n = b->n, pred = b->pred.d, N = f->size + f->d, first = N - d - p->count,
              count = to->count, row = w->slot[mbsri_motion_number(w, w->m->body + b->parent)];
    const carrying c = see_body(w, b, work);
    double *rest = work + d * (n + 2 * pred), *large = rest + d, *load = large + d,
           *size = load + pred;
    for (int k = 0; k < p->count; ++k) {
        const double *X = p->X + k * n, *Q = f->A + (first + k) * N + N - d,
                     *sizes = f->sizes + (first + k) * N + N - d;
        if (d == 6 && n == 1 && pred == 6) /* sizes known to the compiler */
            carry_column(6, 1, 6, &c, X, Q, sizes, rest, large, load, size);
        else if (d == 3 && n == 1 && pred == 3)
            carry_column(3, 1, 3, &c, X, Q, sizes, rest, large, load, size);
        else
            carry_column(d, n, pred, &c, X, Q, sizes, rest, large, load, size);
        double *A = to->A + k * count + row, *A_sizes = to->sizes + k * count + row;
        for (int l = 0; l < pred; ++l) {
            A[l] += load[l];
            A_sizes[l] += size[l];
            to->A[(row + l) * count + k] += load[l];
            to->sizes[(row + l) * count + k] += size[l];
        }
    }
}

/* Marks those of `count` rows (columns numbers each, one behind the other, that get lost) that
 * depend on the others, by elimination with the largest pivots. */
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

/* Takes unknown k out of a part. */
static void leave_out(mbsri_part *p, int k)
{
    const int n = p->count, left = n - 1;
    for (int j = 0, column = 0; j < n; ++j) {
        if (j == k) continue;
        for (int i = 0, row = 0; i < n; ++i) {
            if (i == k) continue;
            p->A[column * left + row] = p->A[j * n + i];
            p->sizes[column * left + row++] = p->sizes[j * n + i];
        }
        p->id[column++] = p->id[j];
    }
    p->count = left;
}

static bool is_rate(const mbsri_fronts *w, int id)
{
    return id >= w->m->rows && id < w->m->rows + w->m->nu;
}

/* More motions without mass than rows cannot all be held by these: those whose rows depend on
 * others are determined by nothing, and are left out, so that no more is carried than the loops
 * themselves need. */
static bool limit_motions(mbsri_fronts *w, mbsri_part *p)
{
    int motions = 0, rows = 0, to = 0;
    for (int k = 0; k < p->count; ++k) {
        motions += is_rate(w, p->id[k]);
        rows += p->id[k] < w->m->rows;
    }
    if (motions <= rows) return true;
    double *row = mbsri_fronts_scratch(w, (size_t)(motions * (p->count + 1)));
    if (!row) return false;
    bool *dependent = (bool *)(void *)(row + motions * p->count);
    for (int k = 0; k < p->count; ++k) {
        if (is_rate(w, p->id[k]))
            mbsri_copy((size_t)p->count, p->A + k * p->count, row + to++ * p->count);
    }
    find_dependent(motions, p->count, row, dependent);
    for (int k = p->count - 1; k >= 0; --k) {
        if (!is_rate(w, p->id[k]) || !dependent[--motions]) continue;
        mbsri_fronts_note_free(w, p->id[k] - w->m->rows);
        leave_out(p, k);
    }
    return true;
}

/* The part that goes on from a body: what passes, its own null motions, and the motion of the
 * predecessor, where that is not the root, whose motion is known. */
static mbsri_part *open_next(mbsri_fronts *w, const mbsri_body *b, const mbsri_passing *p)
{
    const mbsri_body *pred = w->m->body + b->parent;
    const int motion = mbsri_motion_number(w, pred);
    int count = p->count + p->nulls;
    for (int k = 0; k < p->count; ++k) w->slot[p->id[k]] = k;
    const bool there = b->parent == 0 || w->slot[motion] >= 0;
    mbsri_part *to = mbsri_fronts_open_part(w, there ? count : count + b->pred.d);
    if (to) {
        mbsri_zero(2 * (size_t)(to->count * to->count), to->A);
        for (int k = 0; k < count; ++k) to->id[k] = p->id[k];
        for (int k = 0; k < b->pred.d && !there; ++k) {
            w->slot[motion + k] = count;
            to->id[count++] = motion + k;
        }
    }
    return to;
}

static size_t scratch_size(const mbsri_body *b)
{
    const size_t d = (size_t)b->d, n = (size_t)b->n, pred = (size_t)b->pred.d;
    return d * (n + 2) + 2 * pred * (d + 1) + 2 * n;
}

bool mbsri_fronts_pass(mbsri_fronts *w, int k)
{
    const int i = w->plan->step[k].body;
    const mbsri_body *b = w->m->body + i;
    const mbsri_pivots *f = &w->front;
    const int count = w->pivots[k] ? count_passing(f, b) : 0;
    if (count == 0) {
        for (int l = b->n - 1; l >= w->d->rank[i]; --l) mbsri_fronts_note_free(w, b->iu + l);
        return true;
    }
    mbsri_passing *p = w->passing[k] = see_joint(w, k, count);
    mbsri_part *to = p ? w->part[k] = open_next(w, b, p) : NULL;
    double *work = to ? mbsri_fronts_scratch(w, scratch_size(b)) : NULL;
    if (!work) return false;
    to->planned = w->planned && p->nulls == 0;
    add_joint(w, f, b, p, to, work);
    if (b->parent > 0) carry_loads(w, f, b, p, to, work);
    for (int l = 0; l < to->count; ++l) w->slot[to->id[l]] = -1;
    return limit_motions(w, to);
}

/* What meets in a step, and its pivots: see assemble.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fronts/assemble.h"

#include "algebra/dense.h"
#include "recursion/closures.h"
#include "recursion/pose.h"
#include "recursion/rounding.h"

#include <math.h>
#include <string.h>

/* ---- which unknowns ---- */

/* Whether all of them are as planned. */
static bool is_planned(const mbsri_fronts *w, int k)
{
    const mbsri_plan *plan = w->plan;
    const mbsri_plan_step *s = plan->step + k;
    const mbsri_closure *first = mbsri_all_closures(w->m);
    for (int l = 0; l < s->children; ++l) {
        const int child = plan->child[s->first + l];
        const mbsri_part *p = w->part[child];
        if (p ? !p->planned : plan->step[child].leaves > 0) return false;
    }
    for (int end = s->body > 0 ? plan->first_end[s->body] : -1; end >= 0;
         end = plan->next_end[end]) {
        const mbsri_closure *c = first + end / MBSRI_ENDS;
        for (int row = c->row; row < c->row + c->rows; ++row)
            if (w->left_out[row]) return false;
    }
    const mbsri_closure *c = first + (s->closure < 0 ? 0 : s->closure);
    for (int row = c->row; s->closure >= 0 && row < c->row + c->rows; ++row)
        if (w->left_out[row]) return false;
    return true;
}

static mbsri_census take_plan(const mbsri_fronts *w, int k)
{
    const mbsri_plan_step *s = w->plan->step + k;
    const int *name = w->plan->name + s->names;
    const int count = s->complete + s->waiting + s->motions + s->own;
    for (int j = 0; j < count; ++j) {
        w->set[j] = name[j];
        w->slot[name[j]] = j;
    }
    return (mbsri_census){s->complete, s->waiting, s->motions, s->own, s->complete > 0};
}

/* ---- their matrix ---- */

static bool open_front(mbsri_fronts *w, const mbsri_census *u)
{
    const int n = u->complete + u->waiting, d = u->motions + u->own, N = n + d;
    mbsri_pivots *f = &w->front;
    if (!mbsri_fronts_make_room(w, N)) return false;
    f->size = n;
    f->complete = u->complete;
    f->d = d;
    f->pivots = f->left = 0;
    f->sizes = f->A + N * N;
    memcpy(f->id, w->set, (size_t)N * sizeof *f->id);
    mbsri_zero(2 * (size_t)N * (size_t)N, f->A);
    return true;
}

/* The names of the front, and L of its pivots. */
static mbsri_pivots *keep_pivots(mbsri_fronts *w)
{
    const mbsri_pivots *from = &w->front;
    const size_t N = (size_t)(from->size + from->d), pivots = (size_t)from->pivots;
    mbsri_pivots *f =
        mbsri_fronts_allocate(w, sizeof *f + pivots * (N + 1) * sizeof(double) + N * sizeof(int));
    if (!f) return NULL;
    *f = *from;
    f->sizes = f->scale = f->value = NULL;
    f->A = (double *)(void *)(f + 1);
    f->across = f->A + pivots * N;
    f->id = (int *)(void *)(f->across + pivots);
    mbsri_copy(pivots * N, from->A, f->A);
    mbsri_copy(pivots, from->across, f->across);
    memcpy(f->id, from->id, N * sizeof *f->id);
    return f;
}

/* Overwrites the part's names with its places. */
static void add_part(const mbsri_fronts *w, mbsri_part *p, mbsri_pivots *f)
{
    const int N = f->size + f->d, n = p->count;
    int *at = p->id;
    for (int j = 0; j < n; ++j) at[j] = w->slot[at[j]];
    for (int j = 0; j < n; ++j) {
        double *A = f->A + at[j] * N, *sizes = f->sizes + at[j] * N;
        const double *from = p->A + j * n, *from_sizes = p->sizes + j * n;
        for (int l = 0; l < n; ++l) {
            A[at[l]] += from[l];
            sizes[at[l]] += from_sizes[l];
        }
    }
}

/* What the rows of a closure read of its body l. */
static void read_end(mbsri_fronts *w, const mbsri_closure *c, int l, mbsri_pivots *f)
{
    const mbsri_body *b = w->m->body + c->body[l];
    const int N = f->size + f->d, motion = mbsri_motion_number(w, b);
    for (int k = 0; k < c->rows; ++k) {
        const double *C = w->d->closure_C + c->at + (size_t)(c->column[l] * c->rows + k);
        double turn, move;
        if (w->left_out[c->row + k]) continue;
        mbsri_row_parts(w->m, w->d, c, l, k, &turn, &move);
        mbsri_share(turn, move, w->m->typical.length, w->share + c->row + k);
        const int column = w->slot[c->row + k];
        for (int j = 0; j < b->d; ++j) {
            const int row = w->slot[motion + j];
            const double size = mbsri_is_angle(b->joint.space, j) ? turn + w->lever * move : move;
            f->A[column * N + row] += C[j * c->rows];
            f->A[row * N + column] += C[j * c->rows];
            f->sizes[column * N + row] += size;
            f->sizes[row * N + column] += size;
        }
    }
}

static void add_compliance(const mbsri_fronts *w, const mbsri_closure *c, mbsri_pivots *f)
{
    const int next = f->size + f->d + 1;
    for (int row = c->row; row < c->row + c->rows; ++row) {
        if (w->left_out[row] || w->slot[row] < 0) continue;
        f->A[w->slot[row] * next] += w->compliance[row];
        f->sizes[w->slot[row] * next] += w->compliance[row];
    }
}

static void fill_front(mbsri_fronts *w, int k, mbsri_pivots *f)
{
    const mbsri_plan_step *s = w->plan->step + k;
    const mbsri_closure *first = mbsri_all_closures(w->m);
    for (int l = 0; l < s->children; ++l) {
        const int child = w->plan->child[s->first + l];
        if (!w->part[child]) continue;
        add_part(w, w->part[child], f);
        mbsri_fronts_close_part(w, w->part[child]);
        w->part[child] = NULL;
    }
    for (int end = s->body > 0 ? w->plan->first_end[s->body] : -1; end >= 0;
         end = w->plan->next_end[end]) {
        if (mbsri_takes_end(w->m, w->plan, k, end / MBSRI_ENDS, s->body))
            read_end(w, first + end / MBSRI_ENDS, end % MBSRI_ENDS, f);
    }
    if (s->closure < 0) return;
    const mbsri_closure *c = first + s->closure;
    if (w->compliance) add_compliance(w, c, f);
    for (int l = 0; l < c->bodies; ++l) {
        if (mbsri_plan_reads(c, l) && mbsri_takes_end(w->m, w->plan, k, s->closure, c->body[l]))
            read_end(w, c, l, f);
    }
}

/* Loads that are nothing but rounding are none: those of a loop that is closed balance. */
static void clear_loads(mbsri_pivots *f)
{
    const int n = f->size, N = n + f->d;
    for (int k = 0; k < n; ++k) {
        for (int l = n; l < N; ++l) {
            if (fabs(f->A[k * N + l]) <= MBSRI_PIVOTS_ROUNDING * f->sizes[k * N + l])
                f->A[k * N + l] = f->A[l * N + k] = 0.0;
        }
    }
}

/* The inertia that the body's motion gets, with its errors. */
static void add_mass(mbsri_fronts *w, const mbsri_pivots *f, const mbsri_body *b)
{
    const int N = f->size + f->d, first = N - b->d;
    double *Mbar = w->d->Mbar + b->dd, *W = w->d->W + b->dd;
    for (int k = 0; k < b->d; ++k) {
        for (int l = 0; l < b->d; ++l) Mbar[k * b->d + l] -= f->A[(first + k) * N + first + l];
        W[k * (b->d + 1)] += f->sizes[(first + k) * (N + 1)];
    }
}

/* Of what is left at the end nothing determines the motions. */
static void note_left(mbsri_fronts *w, const mbsri_pivots *f)
{
    for (int k = f->pivots; k < f->pivots + f->left; ++k) {
        if (f->id[k] >= w->m->rows) mbsri_fronts_note_free(w, f->id[k] - w->m->rows);
    }
}

bool mbsri_fronts_assemble(mbsri_fronts *w, int k)
{
    const mbsri_plan_step *s = w->plan->step + k;
    const mbsri_front_unknowns names = {w->m, w->plan, w->part, w->left_out, w->slot, w->set};
    const bool root = k == w->plan->steps - 1;
    w->pivots[k] = NULL;
    w->passing[k] = NULL;
    w->part[k] = NULL;
    w->planned = is_planned(w, k);
    mbsri_census u = w->planned ? take_plan(w, k) : mbsri_fronts_names(&names, k);
    if (!u.rows && !root) {
        u.waiting += u.complete;
        u.complete = 0;
    }
    mbsri_pivots *f = &w->front;
    const int count = u.complete + u.waiting + u.motions + u.own;
    const bool any = count > u.own || s->children > 0;
    if (any && !open_front(w, &u)) return false;
    if (any) fill_front(w, k, f);
    for (int j = 0; j < count; ++j) w->slot[w->set[j]] = -1;
    if (!any) return true;
    clear_loads(f);
    if (u.complete > 0) mbsri_pivots_eliminate(f);
    note_left(w, f);
    w->planned = w->planned && f->pivots + f->left == f->complete;
    if (s->body > 0) add_mass(w, f, w->m->body + s->body);
    w->pivots[k] = keep_pivots(w);
    return w->pivots[k] != NULL;
}

bool mbsri_fronts_leave(mbsri_fronts *w, int k)
{
    const mbsri_pivots *f = &w->front;
    if (!w->pivots[k]) return true;
    const int first = f->pivots + f->left, N = f->size + f->d, count = N - first;
    if (count == 0) return true;
    mbsri_part *p = w->part[k] = mbsri_fronts_open_part(w, count);
    if (!p) return false;
    p->planned = w->planned;
    for (int j = 0; j < count; ++j) {
        p->id[j] = f->id[first + j];
        mbsri_copy((size_t)count, f->A + (first + j) * N + first, p->A + j * count);
        mbsri_copy((size_t)count, f->sizes + (first + j) * N + first, p->sizes + j * count);
    }
    return true;
}

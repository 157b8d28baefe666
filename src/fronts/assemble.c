/* What meets in a step, and its pivots: see assemble.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fronts/assemble.h"

#include "algebra/dense.h"
#include "recursion/closures.h"
#include "recursion/pose.h"
#include "recursion/rounding.h"

#include <math.h>

/* Unknowns of one step: those complete, rows that wait, motions, and of these the body's own. */
typedef struct census {
    int complete, waiting, motions, own;
    bool rows; /* some of those complete are rows */
} census;

/* ---- which unknowns ---- */

static bool is_motion(const mbsri_fronts *w, int id)
{
    return id >= w->m->rows + w->m->nu;
}

static bool is_complete(const mbsri_fronts *w, int id, int k)
{
    return id >= w->m->rows || w->eliminated[id] <= k;
}

/* Whether step k takes the end of a closure on its own body, or of its own closure on a body that
 * is not passed. */
static bool takes_end(const mbsri_fronts *w, int k, int closure, int body)
{
    const mbsri_plan *plan = w->plan;
    const int gone = plan->when[w->m->bodies + 1 + closure];
    return plan->step[k].body == body ? gone > k : gone == k && plan->when[body] > k;
}

/* An unknown of the turn: 0 those complete, 1 rows that wait, 2 motions of other bodies. */
static void add_unknown(mbsri_fronts *w, int k, int turn, int id, int *count)
{
    const int kind = is_motion(w, id) ? 2 : is_complete(w, id, k) ? 0 : 1;
    if (kind != turn || w->slot[id] >= 0) return;
    w->slot[id] = *count;
    w->set[(*count)++] = id;
}

static void add_end(mbsri_fronts *w, int k, int turn, const mbsri_closure *c, int l, int *count)
{
    const mbsri_body *b = w->m->body + c->body[l];
    bool any = false;
    for (int row = c->row; row < c->row + c->rows; ++row) {
        if (w->left_out[row]) continue;
        any = true;
        add_unknown(w, k, turn, row, count);
    }
    for (int j = 0; j < b->d && any; ++j)
        add_unknown(w, k, turn, mbsri_motion_number(w, b) + j, count);
}

static void add_turn(mbsri_fronts *w, int k, int turn, int *count)
{
    const mbsri_plan_step *s = w->plan->step + k;
    const mbsri_closure *first = mbsri_all_closures(w->m);
    for (int l = 0; l < s->children; ++l) {
        const mbsri_part *p = w->part[w->plan->child[s->first + l]];
        for (int j = 0; p && j < p->count; ++j) add_unknown(w, k, turn, p->id[j], count);
    }
    for (int end = s->body > 0 ? w->first_end[s->body] : -1; end >= 0; end = w->next_end[end]) {
        if (takes_end(w, k, end / MBSRI_ENDS, s->body))
            add_end(w, k, turn, first + end / MBSRI_ENDS, end % MBSRI_ENDS, count);
    }
    if (s->closure < 0) return;
    const mbsri_closure *c = first + s->closure;
    for (int l = 0; l < c->bodies; ++l) {
        if (mbsri_plan_reads(c, l) && takes_end(w, k, s->closure, c->body[l]))
            add_end(w, k, turn, c, l, count);
    }
}

/* The unknowns of step k into w->set, with their slots. */
static census find_unknowns(mbsri_fronts *w, int k)
{
    const mbsri_plan_step *s = w->plan->step + k;
    const mbsri_body *b = w->m->body + s->body;
    census u = {.own = s->body > 0 ? b->d : 0};
    int count = 0;
    for (int j = 0; j < u.own; ++j) w->slot[mbsri_motion_number(w, b) + j] = 0;
    add_turn(w, k, 0, &count);
    u.complete = count;
    for (int j = 0; j < count; ++j) u.rows = u.rows || w->set[j] < w->m->rows;
    add_turn(w, k, 1, &count);
    u.waiting = count - u.complete;
    add_turn(w, k, 2, &count);
    u.motions = count - u.complete - u.waiting;
    for (int j = 0; j < u.own; ++j) {
        w->slot[mbsri_motion_number(w, b) + j] = count;
        w->set[count++] = mbsri_motion_number(w, b) + j;
    }
    return u;
}

/* ---- their matrix ---- */

static mbsri_pivots *open_pivots(mbsri_fronts *w, const census *u)
{
    const size_t n = (size_t)(u->complete + u->waiting), d = (size_t)(u->motions + u->own),
                 N = n + d, numbers = 2 * N * N + 3 * n;
    mbsri_pivots *f =
        mbsri_fronts_allocate(w, sizeof *f + numbers * sizeof(double) + N * sizeof(int));
    if (!f) return NULL;
    *f = (mbsri_pivots){
        .size = (int)n, .complete = u->complete, .d = (int)d, .A = (double *)(void *)(f + 1)};
    f->sizes = f->A + N * N;
    f->scale = f->sizes + N * N;
    f->value = f->scale + n;
    f->across = f->value + n;
    f->id = (int *)(void *)(f->across + n);
    for (size_t k = 0; k < N; ++k) f->id[k] = w->set[k];
    mbsri_zero(2 * N * N, f->A);
    return f;
}

static void add_part(const mbsri_fronts *w, const mbsri_part *p, mbsri_pivots *f)
{
    const int N = f->size + f->d, n = p->count;
    for (int j = 0; j < n; ++j) {
        double *A = f->A + w->slot[p->id[j]] * N, *sizes = f->sizes + w->slot[p->id[j]] * N;
        for (int l = 0; l < n; ++l) {
            A[w->slot[p->id[l]]] += p->A[j * n + l];
            sizes[w->slot[p->id[l]]] += p->sizes[j * n + l];
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
        mbsri_share(turn, move, w->m->length, w->share + c->row + k);
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

static void fill(mbsri_fronts *w, int k, mbsri_pivots *f)
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
    for (int end = s->body > 0 ? w->first_end[s->body] : -1; end >= 0; end = w->next_end[end]) {
        if (takes_end(w, k, end / MBSRI_ENDS, s->body))
            read_end(w, first + end / MBSRI_ENDS, end % MBSRI_ENDS, f);
    }
    if (s->closure < 0) return;
    const mbsri_closure *c = first + s->closure;
    for (int l = 0; l < c->bodies; ++l) {
        if (mbsri_plan_reads(c, l) && takes_end(w, k, s->closure, c->body[l])) read_end(w, c, l, f);
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
static void note_free(mbsri_fronts *w, const mbsri_pivots *f)
{
    for (int k = f->pivots; k < f->pivots + f->left; ++k) {
        if (f->id[k] >= w->m->rows) w->free = f->id[k] - w->m->rows;
    }
}

bool mbsri_fronts_assemble(mbsri_fronts *w, int k)
{
    const mbsri_plan_step *s = w->plan->step + k;
    const bool root = k == w->plan->steps - 1;
    w->pivots[k] = NULL;
    w->passing[k] = NULL;
    w->part[k] = NULL;
    census u = find_unknowns(w, k);
    if (!u.rows && !root) {
        u.waiting += u.complete;
        u.complete = 0;
    }
    const int count = u.complete + u.waiting + u.motions + u.own;
    if (count > u.own || s->children > 0) {
        w->pivots[k] = open_pivots(w, &u);
        if (!w->pivots[k]) return false;
        fill(w, k, w->pivots[k]);
        clear_loads(w->pivots[k]);
    }
    for (int j = 0; j < count; ++j) w->slot[w->set[j]] = -1;
    mbsri_pivots *f = w->pivots[k];
    if (!f) return true;
    if (u.complete > 0) mbsri_pivots_eliminate(f);
    note_free(w, f);
    if (s->body > 0) add_mass(w, f, w->m->body + s->body);
    return true;
}

bool mbsri_fronts_leave(mbsri_fronts *w, int k)
{
    const mbsri_pivots *f = w->pivots[k];
    const int first = f ? f->pivots + f->left : 0, N = f ? f->size + f->d : 0, count = N - first;
    if (count == 0) return true;
    mbsri_part *p = w->part[k] = mbsri_fronts_open_part(w, count);
    if (!p) return false;
    for (int j = 0; j < count; ++j) {
        p->id[j] = f->id[first + j];
        mbsri_copy((size_t)count, f->A + (first + j) * N + first, p->A + j * count);
        mbsri_copy((size_t)count, f->sizes + (first + j) * N + first, p->sizes + j * count);
    }
    return true;
}

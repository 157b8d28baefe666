/* Factors of the equations of motion with loops: see system.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops/system.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "loops/passing.h"
#include "loops/rounding.h"
#include "recursion/backward.h"
#include "recursion/closures.h"
#include "recursion/errors.h"
#include "recursion/group.h"
#include "recursion/pose.h"
#include "recursion/rank.h"

#include <math.h>

/* ---- what comes together at a body ---- */

/* What the rows of a closure read of its body l, as something carried; NULL: no memory. */
static mbsri_waiting *open_end(mbsri_system *w, const mbsri_closure *c, int l, double lever)
{
    const mbsri_body *b = w->m->body + c->body[l];
    int count = 0;
    for (int k = 0; k < c->rows; ++k) count += !w->left_out[c->row + k];
    mbsri_waiting *p = mbsri_open_waiting(w, count, b->d);
    if (!p) return NULL;
    count = 0;
    for (int k = 0; k < c->rows; ++k) {
        const double *C = w->d->closure_C + c->at + (size_t)(c->column[l] * c->rows + k);
        double turn, move;
        if (w->left_out[c->row + k]) continue;
        mbsri_row_parts(w->m, w->d, c, l, k, &turn, &move);
        mbsri_share(turn, move, w->m->length, w->share + c->row + k);
        for (int j = 0; j < b->d; ++j) {
            p->Q[count * b->d + j] = C[j * c->rows];
            p->lengths[count * b->d + j] =
                mbsri_is_angle(b->joint.space, j) ? turn + lever * move : move;
        }
        p->id[count++] = c->row + k;
    }
    return p;
}

/* The parts that meet at body i, into w->part; -1: no memory. */
static int find_parts(mbsri_system *w, int i, double lever)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    int count = 0;
    for (mbsri_waiting *p = w->behind[i]; p; p = p->next) w->part[count++] = p;
    for (int end = w->first_end[i]; end >= 0; end = w->next_end[end]) {
        w->part[count] = open_end(w, first + end / MBSRI_ENDS, end % MBSRI_ENDS, lever);
        if (!w->part[count]) return -1;
        ++count;
    }
    return count;
}

static int group_of(mbsri_system *w, int p)
{
    while (w->group[p] != p) p = w->group[p] = w->group[w->group[p]];
    return p;
}

/* Parts that share an unknown belong together: those of one group follow each other by w->mate. */
static void group_parts(mbsri_system *w, int count)
{
    for (int p = 0; p < count; ++p) {
        w->group[p] = p;
        for (int k = 0; k < w->part[p]->count; ++k) {
            int *slot = w->slot + w->part[p]->id[k];
            if (*slot >= 0) w->group[group_of(w, *slot)] = p;
            *slot = p;
        }
    }
    for (int p = 0; p < count; ++p) {
        for (int k = 0; k < w->part[p]->count; ++k) w->slot[w->part[p]->id[k]] = -1;
        w->mate[p] = -1;
    }
    for (int p = 0; p < count; ++p) {
        const int head = group_of(w, p);
        if (head == p) continue;
        w->mate[p] = w->mate[head];
        w->mate[head] = p;
    }
}

static bool is_complete(const mbsri_system *w, int id, int i)
{
    return id >= w->m->rows || w->closes[id] >= i;
}

/* The unknowns of a group into w->set, those that may be eliminated at body i first; where no row is among
 * these, nothing is. */
static int find_unknowns(mbsri_system *w, int head, int i, int *complete)
{
    int count = 0;
    bool rows = i == 0;
    for (int turn = 0; turn < 2; ++turn) {
        for (int p = head; p >= 0; p = w->mate[p]) {
            for (int k = 0; k < w->part[p]->count; ++k) {
                const int id = w->part[p]->id[k];
                if (w->slot[id] >= 0 || is_complete(w, id, i) != (turn == 0)) continue;
                rows = rows || (turn == 0 && id < w->m->rows);
                w->slot[id] = count;
                w->set[count++] = id;
            }
        }
        if (turn == 0) *complete = count;
    }
    if (!rows) *complete = 0;
    return count;
}

static void add_part(const mbsri_system *w, const mbsri_waiting *p, mbsri_pivots *f)
{
    const int n = f->size, N = n + f->d, k = p->count;
    for (int j = 0; j < k; ++j) {
        const int column = w->slot[p->id[j]];
        double *A = f->A + column * N, *sizes = f->sizes + column * N;
        for (int l = 0; l < k; ++l) {
            A[w->slot[p->id[l]]] += p->F[j * k + l];
            sizes[w->slot[p->id[l]]] += p->sizes[j * k + l];
        }
        for (int l = 0; l < f->d; ++l) {
            A[n + l] += p->Q[j * f->d + l];
            f->A[(n + l) * N + column] += p->Q[j * f->d + l];
            sizes[n + l] += p->lengths[j * f->d + l];
            f->sizes[(n + l) * N + column] += p->lengths[j * f->d + l];
        }
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

static mbsri_pivots *open_pivots(mbsri_system *w, int size, int complete, int d)
{
    const size_t n = (size_t)size, N = n + (size_t)d, c = (size_t)complete,
                 numbers = 2 * N * N + 2 * n + c + n * c;
    mbsri_pivots *f =
        mbsri_system_allocate(w, sizeof *f + numbers * sizeof(double) + n * sizeof(int));
    if (!f) return NULL;
    *f = (mbsri_pivots){.size = size, .complete = complete, .d = d, .A = (double *)(void *)(f + 1)};
    f->sizes = f->A + N * N;
    f->scale = f->sizes + N * N;
    f->value = f->scale + n;
    f->across = f->value + n;
    f->idle = f->across + c;
    f->id = (int *)(void *)(f->idle + n * c);
    f->shared = w->m->rows;
    f->share = w->share;
    mbsri_zero(2 * N * N, f->A);
    return f;
}

/* What is left of rows, being redundant, shares by least norm; a motion that is left is determined by
 * nothing. */
static int settle_left(mbsri_system *w, mbsri_pivots *f)
{
    if (f->left == 0) return MBSR_OK;
    bool *wanted = mbsri_system_allocate(w, (size_t)f->left * sizeof *wanted);
    if (!wanted) return MBSR_ERR_NO_MEMORY;
    for (int l = 0; l < f->left; ++l) {
        const int id = f->id[f->pivots + l];
        wanted[l] = id < w->m->rows;
        if (!wanted[l]) w->free = id - w->m->rows;
    }
    mbsri_pivots_find_idle(f, wanted);
    return MBSR_OK;
}

/* The inertia of what was eliminated, with its errors. */
static void add_mass(mbsri_system *w, const mbsri_pivots *f, int i)
{
    const int n = f->size, d = f->d, N = n + d;
    double *Mbar = w->d->Mbar + w->m->body[i].dd, *W = w->d->W + w->m->body[i].dd;
    for (int k = 0; k < d && f->pivots > 0; ++k) {
        for (int l = 0; l < d; ++l) Mbar[k * d + l] -= f->A[(n + k) * N + n + l];
        W[k * (d + 1)] += f->sizes[(n + k) * (N + 1)];
    }
}

/* Eliminates what is complete of a group; the others go on. */
static int close_group(mbsri_system *w, int head, int i)
{
    const mbsri_body *b = w->m->body + i;
    const int d = i > 0 ? b->d : 0;
    int complete = 0, size = find_unknowns(w, head, i, &complete);
    mbsri_pivots *f = open_pivots(w, size, complete, d);
    if (!f) return MBSR_ERR_NO_MEMORY;
    for (int k = 0; k < size; ++k) f->id[k] = w->set[k];
    for (int p = head; p >= 0; p = w->mate[p]) add_part(w, w->part[p], f);
    clear_loads(f);
    for (int k = 0; k < size; ++k) w->slot[w->set[k]] = -1;
    if (complete > 0) mbsri_pivots_eliminate(f);
    if (complete > 0 && settle_left(w, f)) return MBSR_ERR_NO_MEMORY;
    add_mass(w, f, i);
    f->next = w->closing[i];
    w->closing[i] = f;
    return MBSR_OK;
}

static int close_loops(mbsri_system *w, int i, double lever)
{
    w->closing[i] = NULL;
    if (!w->behind[i] && w->first_end[i] < 0) return MBSR_OK;
    const int count = find_parts(w, i, lever);
    if (count < 0) return MBSR_ERR_NO_MEMORY;
    group_parts(w, count);
    for (int p = 0; p < count; ++p) {
        if (w->group[p] == p && close_group(w, p, i)) return MBSR_ERR_NO_MEMORY;
    }
    return MBSR_OK;
}

/* ---- factoring ---- */

/* U, D, its rank and pseudo-inverse, and G of the joint. */
static int factor_joint(mbsri_system *w, int i, const double *armature)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    const mbsri_body *b = m->body + i;
    const mbsri_group g = mbsri_group_of(m, d, i);
    double *U = d->U + b->dg, *G = d->G + b->dg, *D = d->D + b->nn;
    mbsri_symmetrise(b->d, d->Mbar + b->dd);
    mbsri_add_diagonal(b->d, 1.0, d->Mbar + b->dd, d->W + b->dd);
    mbsri_group_products(m, d, &g, d->Mbar, U, D, d->scratch);
    if (!armature) mbsri_group_add_armature(m, &g, D);
    for (int k = 0; k < b->n && armature; ++k) D[k * (b->n + 1)] += armature[b->iu + k];
    d->rank[i] = 0;
    d->scale[b->seat] = 0.0;
    const int status = b->n > 0 ? mbsri_rank_decision(m, d, &g, true) : MBSR_OK;
    mbsri_zero((size_t)(b->d * b->n), G);
    mbsri_ab(b->d, b->n, b->n, 1.0, U, d->Dinv + b->nn, G);
    return status;
}

static void begin_masses(mbsri_system *w, const double *armature)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, d->M);
    mbsri_zero(m->size_dd, d->W);
    if (armature)
        mbsri_zero(m->size_dd, d->Mbar);
    else
        mbsri_copy(m->size_dd, d->M, d->Mbar);
    for (int i = 0; i <= m->bodies; ++i)
        d->turned[m->body[i].seat] =
            armature ? 0.0 : mbsri_own_turned(m->body + i, d->M + m->body[i].dd);
}

static int eliminate(mbsri_system *w, const double *armature)
{
    const mbsr_model *m = w->m;
    const double lever = mbsri_longest_lever(m, w->d);
    begin_masses(w, armature);
    mbsri_zero((size_t)m->rows, w->share);
    for (int i = 0; i <= m->bodies; ++i) w->behind[i] = NULL;
    for (int i = m->bodies; i > 0; --i) {
        int status = close_loops(w, i, lever);
        if (!status) status = factor_joint(w, i, armature);
        if (!status) status = mbsri_system_pass(w, i);
        if (status) return status;
        mbsri_pass_masses(m, w->d, i, false);
    }
    return close_loops(w, 0, lever);
}

int mbsri_system_factor(mbsri_system *w, const double *armature, const char *function)
{
    mbsr_data *d = w->d;
    const bool single = d->single;
    if (d->stage > MBSRI_STAGE_FORCES) d->stage = MBSRI_STAGE_FORCES;
    d->single = true;
    w->free = -1;
    const int status = eliminate(w, armature);
    d->single = single;
    if (status != MBSR_ERR_NO_MEMORY) return status;
    return mbsri_fail(&d->error, status, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for the loops that are open at once", function);
}

int mbsri_system_free_rate(const mbsri_system *w)
{
    int i = 1, most = 0;
    while (w->free >= w->m->body[i].iu + w->m->body[i].n || w->free < w->m->body[i].iu) ++i;
    const mbsri_body *b = w->m->body + i;
    const double *x = w->d->X + b->nn + (size_t)((w->free - b->iu) * b->n), *s = w->d->s + b->ig;
    for (int k = 0; k < b->n; ++k) {
        if (fabs(s[k] * x[k]) > fabs(s[most] * x[most])) most = k;
    }
    return b->u + most;
}

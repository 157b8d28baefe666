/* Ranks of closures cluster by cluster: see clusters.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops/clusters.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "base/memory.h"
#include "recursion/rounding.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/spans.h"
#include "recursion/pose.h"

#include <math.h>

enum { MOST = 400 }; /* joint rates, or rows, of a cluster */

typedef struct clusters {
    const mbsr_model *m;
    mbsr_data *d;
    int *of_closure; /* closures: a closure of the same cluster, itself if it stands for it */
    int *of_body;    /* bodies + 1: a closure that reads its joint, -1: none */
    int *next_body,
        *first_body; /* lists of bodies, from the leaves, by the closure that stands for them */
    int *next_closure, *first_closure;       /* likewise of closures, the last first */
    int *place;                              /* bodies + 1: of its rates in the cluster */
    int *closure, *row;                      /* of one cluster, as many as closures */
    double *f, *f_size;                      /* size_v */
    double *C, *Q;                           /* MOST x MOST */
    double *scale, *x, *line, *sizes, *span; /* MOST */
    mbsri_spans spans;
    void *memory;
} clusters;

static int allocate(clusters *w)
{
    const size_t closures = w->m->closures.count, bodies = (size_t)w->m->bodies + 1,
                 numbers = 2 * w->m->size_v + 2 * MOST * MOST + 5 * MOST;
    w->memory = mbsri_allocate(&w->m->allocator, numbers * sizeof(double) +
                                                     (6 * closures + 3 * bodies) * sizeof(int));
    if (!w->memory)
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for ranks of %zu closures", closures);
    w->f = w->memory;
    w->f_size = w->f + w->m->size_v;
    w->C = w->f_size + w->m->size_v;
    w->Q = w->C + MOST * MOST;
    w->scale = w->Q + MOST * MOST;
    w->x = w->scale + MOST;
    w->line = w->x + MOST;
    w->sizes = w->line + MOST;
    w->span = w->sizes + MOST;
    w->of_closure = (int *)(void *)(w->span + MOST);
    w->next_closure = w->of_closure + closures;
    w->first_closure = w->next_closure + closures;
    w->closure = w->first_closure + closures;
    w->row = w->closure + closures;
    w->of_body = w->row + closures;
    w->next_body = w->of_body + bodies;
    w->place = w->next_body + bodies;
    w->first_body = w->place + bodies;
    return MBSR_OK;
}

/* ---- which closures belong together ---- */

static int root_of(clusters *w, int id)
{
    while (w->of_closure[id] != id) {
        w->of_closure[id] = w->of_closure[w->of_closure[id]];
        id = w->of_closure[id];
    }
    return id;
}

/* The joint of body i is read by closure `id`. */
static void join(clusters *w, int i, int id)
{
    if (w->of_body[i] >= 0) w->of_closure[root_of(w, w->of_body[i])] = root_of(w, id);
    w->of_body[i] = id;
}

static void find_clusters(clusters *w)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const int closures = (int)w->m->closures.count;
    for (int i = 0; i <= w->m->bodies; ++i) w->of_body[i] = -1;
    for (int id = 0; id < closures; ++id) {
        const mbsri_closure *c = first + id;
        w->of_closure[id] = id;
        for (int l = 0; l < c->bodies; ++l) {
            for (int i = c->body[l]; i > c->meets; i = w->m->body[i].parent) join(w, i, id);
        }
    }
    for (int id = 0; id < closures; ++id) w->first_closure[id] = w->first_body[id] = -1;
    for (int id = closures - 1; id >= 0; --id) {
        const int root = root_of(w, id);
        w->next_closure[id] = w->first_closure[root];
        w->first_closure[root] = id;
    }
    for (int i = 1; i <= w->m->bodies; ++i) {
        if (w->of_body[i] < 0) continue;
        const int root = root_of(w, w->of_body[i]);
        w->next_body[i] = w->first_body[root];
        w->first_body[root] = i;
    }
}

/* ---- the rows of one cluster ---- */

/* What row k has of its bodies and joints, into f and line, with the sizes of what is added up. */
static void begin_row(clusters *w, const mbsri_closure *c, int k, double lever)
{
    for (int l = 0; l < c->bodies; ++l) {
        const mbsri_body *b = w->m->body + c->body[l];
        double turn, move;
        if (c->column[l] < 0 || c->body[l] == 0) continue;
        mbsri_row_parts(w->m, w->d, c, l, k, &turn, &move);
        const double *C = w->d->closure_C + c->at + (size_t)(c->column[l] * c->rows + k);
        for (int j = 0; j < b->d; ++j, C += c->rows) {
            w->f[b->v + (size_t)j] += *C;
            w->f_size[b->v + (size_t)j] +=
                mbsri_is_angle(b->joint.space, j) ? turn + lever * move : move;
        }
        if (!(c->def.table->flags & MBSR_CLOSURE_JOINTS)) continue;
        for (int j = 0; j < b->n; ++j, C += c->rows) {
            w->line[w->place[c->body[l]] + j] += *C;
            w->sizes[w->place[c->body[l]] + j] += fabs(*C);
        }
    }
}

/* Row k of the closure over the n rates of the cluster, into line: -J^T f from the leaves to where
 * it meets. */
static void find_row(clusters *w, const mbsri_closure *c, int k, int root, int n, double lever)
{
    const mbsr_model *m = w->m;
    const mbsr_data *d = w->d;
    mbsri_zero((size_t)n, w->line);
    mbsri_zero((size_t)n, w->sizes);
    begin_row(w, c, k, lever);
    for (int i = w->first_body[root]; i >= 0; i = w->next_body[i]) {
        const mbsri_body *b = m->body + i;
        double *f = w->f + b->v, *size = w->f_size + b->v, *line = w->line + w->place[i],
               *sizes = w->sizes + w->place[i];
        for (int j = 0; j < b->n; ++j) {
            for (int r = 0; r < b->d; ++r) {
                const double J = d->J[b->dn + (size_t)(j * b->d + r)];
                line[j] -= J * f[r];
                sizes[j] += fabs(J) * size[r];
            }
        }
        const bool on = b->parent != c->meets && b->parent > 0;
        for (int j = 0; j < b->d_pred && on; ++j) {
            for (int r = 0; r < b->d; ++r) {
                const double H = d->H[b->dp + (size_t)(j * b->d + r)];
                w->f[b->pred_v + (size_t)j] -= H * f[r];
                w->f_size[b->pred_v + (size_t)j] += fabs(H) * size[r];
            }
        }
        mbsri_zero((size_t)b->d, f);
        mbsri_zero((size_t)b->d, size);
    }
    const double share = mbsri_row_rounding(c);
    for (int j = 0; j < n; ++j) {
        if (!(fabs(w->line[j]) > share * w->sizes[j])) w->line[j] = 0.0;
    }
}

/* Marks the rows of the cluster that closure `root` stands for. */
static bool rank_cluster(clusters *w, int root, double lever, double dependent, bool *dropped,
                         mbsri_ranks *found)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    mbsri_row_set s = {.m = w->m,
                       .d = w->d,
                       .closure = w->closure,
                       .row = w->row,
                       .dependent = dependent,
                       .C = w->C,
                       .span = w->span,
                       .Q = w->Q,
                       .scale = w->scale,
                       .x = w->x,
                       .left = w->line};
    for (int i = w->first_body[root]; i >= 0; i = w->next_body[i]) {
        w->place[i] = s.n;
        s.n += w->m->body[i].n;
    }
    for (int id = w->first_closure[root]; id >= 0; id = w->next_closure[id]) {
        w->closure[s.count] = id;
        w->row[s.count++] = s.rows;
        s.rows += first[id].rows;
    }
    if (s.n > MOST || s.rows > MOST) return false;
    for (int i = w->first_body[root]; i >= 0; i = w->next_body[i]) {
        const mbsri_body *b = w->m->body + i;
        for (int k = 0; k < b->n; ++k)
            w->span[w->place[i] + k] = mbsri_coordinate_span(&w->spans, w->m, b, true, k);
    }
    for (int l = 0; l < s.count; ++l) {
        const mbsri_closure *c = first + w->closure[l];
        for (int k = 0; k < c->rows; ++k) {
            find_row(w, c, k, root, s.n, lever);
            for (int j = 0; j < s.n; ++j) w->C[j * s.rows + w->row[l] + k] = w->line[j];
        }
    }
    mbsri_ranks_of(&s, dropped, found);
    return true;
}

int mbsri_ranks_by_clusters(const mbsr_model *m, mbsr_data *d, double dependent, bool *dropped,
                            mbsri_ranks *found, bool *served)
{
    clusters w = {.m = m, .d = d, .spans = mbsri_spans_of(m, NULL)};
    int status = allocate(&w);
    *found = mbsri_no_ranks();
    *served = !status;
    if (!status) status = mbsri_closure_jacobians(m, d);
    if (!status) {
        const double lever = mbsri_longest_lever(m, d);
        mbsri_zero(2 * m->size_v, w.f);
        find_clusters(&w);
        for (int id = 0; id < (int)m->closures.count && *served; ++id) {
            if (w.of_closure[id] == id)
                *served = rank_cluster(&w, id, lever, dependent, dropped, found);
        }
    }
    mbsri_release(&m->allocator, w.memory);
    return status;
}

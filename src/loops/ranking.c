/* Workspace of ranks of the rows of closures: see ranking.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops/ranking.h"

#include "base/error.h"
#include "base/memory.h"
#include "loops/row_fronts.h"
#include "recursion/spans.h"

static void find_spans(mbsri_ranking *w)
{
    const mbsri_spans spans = mbsri_spans_of(w->m, NULL);
    for (int i = 1; i <= w->m->bodies; ++i) {
        const mbsri_body *b = w->m->body + i;
        for (int k = 0; k < b->n; ++k)
            w->span[b->u + k] = mbsri_coordinate_span(&spans, w->m, b, true, k);
    }
}

static int no_memory_for_ranks(const mbsri_ranking *w)
{
    return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for ranks of %d rows of closures over %d joint rates",
                      w->function, w->rows, w->n);
}

static int open_arrays(mbsri_ranking *w)
{
    const size_t n = (size_t)w->n, rows = (size_t)w->rows, nq = (size_t)w->m->nq;
    double **const array[] = {&w->span, &w->x,        &w->g,    &w->y,
                              &w->q,    &w->q_beside, &w->free, &w->out};
    const size_t length[] = {n, n, rows, rows, nq, nq, 8 * n, n + rows};
    enum { ARRAYS = sizeof length / sizeof *length };
    size_t numbers = 0;
    for (int k = 0; k < ARRAYS; ++k) numbers += length[k];
    w->memory = mbsri_allocate(&w->m->allocator, numbers * sizeof(double) + rows * sizeof(int) +
                                                     6 * rows * sizeof(bool) + 1);
    if (!w->memory) return no_memory_for_ranks(w);
    double *next = w->memory;
    for (int k = 0; k < ARRAYS; ++k) {
        *array[k] = next;
        next += length[k];
    }
    w->late = (int *)(void *)next;
    w->other = (bool *)(w->late + rows);
    w->apart = w->other + rows;
    w->left_out = w->apart + rows;
    w->shared = w->left_out + rows;
    w->beside = w->shared + rows;
    find_spans(w);
    return MBSR_OK;
}

int mbsri_ranking_open(mbsri_ranking *w, const mbsr_model *m, mbsr_data *d, bool rigid,
                       const char *function)
{
    *w = (mbsri_ranking){.m = m,
                         .d = d,
                         .function = function,
                         .n = m->nu,
                         .rows = m->rows,
                         .position_rows = m->position_rows,
                         .springs = !rigid && mbsri_any_stiff(m)};
    int status = open_arrays(w);
    if (!status) status = mbsri_closer_open(&w->closer, m, d, function);
    return status ? status : mbsri_row_fronts_open(m, d, w->span, function, &w->fronts);
}

void mbsri_ranking_close(mbsri_ranking *w)
{
    if (!w->m) return;
    if (w->fronts) mbsri_row_fronts_close(w->fronts);
    w->fronts = NULL;
    mbsri_closer_close(&w->closer);
    mbsri_release(&w->m->allocator, w->memory);
    w->memory = NULL;
}

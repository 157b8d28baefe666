/* The diagonal of the inverse of the equations of motion with loops: see spread.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fronts/spread.h"

#include "algebra/dense.h"

#include <math.h>

/* Variances of the unknowns of a front: motions and others (count squared). Of a body that passes
 * without front, of its motion. */
typedef struct variances {
    int count;
    const int *id;
    double *P;
} variances;

typedef struct spread {
    mbsri_fronts *w;
    variances *at; /* steps */
    double *M;     /* most x most: answers to unit inputs, by columns */
    double *MP;    /* times the inputs' variances */
    double *Q;     /* most squared: variances of inputs */
    int *input;    /* most: unknowns */
    int most;      /* inputs, or numbers of an answer */
} spread;

/* ---- memory ---- */

static const mbsri_body *body_of(const mbsri_fronts *w, int k)
{
    return w->m->body + w->plan->step[k].body;
}

static int rates_of(const mbsri_fronts *w, int k)
{
    return w->plan->step[k].body > 0 ? body_of(w, k)->n : 0;
}

static int unknowns_of(const mbsri_fronts *w, int k)
{
    const mbsri_pivots *f = w->pivots[k];
    if (f) return f->size + f->d;
    return w->plan->step[k].body > 0 ? body_of(w, k)->d : 0;
}

/* The unknowns that step k has left, into `input`; how many. */
static int find_inputs(const mbsri_fronts *w, int k, int *input)
{
    const mbsri_pivots *f = w->pivots[k];
    const mbsri_passing *p = w->passing[k];
    int count = 0;
    if (w->plan->step[k].body == 0) {
        for (int l = f ? f->pivots + f->left : 0; f && l < f->size + f->d; ++l)
            input[count++] = f->id[l];
        return count;
    }
    const mbsri_body *b = body_of(w, k);
    const int motion = mbsri_motion_number(w, w->m->body + b->parent);
    for (int l = 0; l < b->pred.d && b->parent > 0; ++l) input[count++] = motion + l;
    for (int l = 0; p && l < p->count + p->nulls; ++l) {
        if (p->id[l] < motion || p->id[l] >= motion + b->pred.d) input[count++] = p->id[l];
    }
    return count;
}

static bool allocate_spread(spread *x)
{
    mbsri_fronts *w = x->w;
    const int steps = w->plan->steps;
    for (int k = 0; k < steps; ++k) {
        const int own = rates_of(w, k) + unknowns_of(w, k),
                  inputs = own + rates_of(w, k) +
                           (w->plan->step[k].body > 0 ? body_of(w, k)->pred.d : 0);
        x->most = inputs > x->most ? inputs : x->most;
    }
    const size_t most = (size_t)x->most;
    x->at = mbsri_fronts_allocate(w, (size_t)steps * sizeof *x->at);
    x->M = mbsri_fronts_allocate(w, 3 * most * most * sizeof *x->M);
    x->input = mbsri_fronts_allocate(w, most * sizeof *x->input);
    if (!x->at || !x->M || !x->input) return false;
    x->MP = x->M + most * most;
    x->Q = x->MP + most * most;
    return true;
}

/* The unknowns of a step: those of its front, or the motion of its body. */
static bool open_variances(spread *x, int k)
{
    mbsri_fronts *w = x->w;
    const size_t count = (size_t)unknowns_of(w, k);
    variances *s = x->at + k;
    *s = (variances){.count = (int)count};
    if (count == 0) return true;
    s->P = mbsri_fronts_allocate(w, count * count * sizeof(double) + count * sizeof(int));
    if (!s->P) return false;
    mbsri_zero(count * count, s->P);
    if (w->pivots[k]) {
        s->id = w->pivots[k]->id;
        return true;
    }
    int *id = (int *)(void *)(s->P + count * count);
    for (int l = 0; l < s->count; ++l) id[l] = mbsri_motion_number(w, body_of(w, k)) + l;
    s->id = id;
    return true;
}

/* ---- answers ---- */

/* Column `to` of M: rates and unknowns of step k as they are. */
static void read_answer(spread *x, int k, int to)
{
    const mbsri_fronts *w = x->w;
    const int n = rates_of(w, k);
    const variances *s = x->at + k;
    double *column = x->M + (size_t)to * (size_t)x->most;
    if (n > 0) mbsri_copy((size_t)n, w->e + body_of(w, k)->iu, column);
    for (int l = 0; l < s->count; ++l) column[n + l] = w->v[s->id[l]];
}

static void clear(const spread *x, int k)
{
    const variances *s = x->at + k;
    for (int l = 0; l < s->count; ++l) x->w->v[s->id[l]] = 0.0;
}

/* Answers to what the step has left, one after the other. */
static void answer_inputs(spread *x, int k, int inputs)
{
    mbsri_fronts *w = x->w;
    const int n = rates_of(w, k);
    for (int l = 0; l < inputs; ++l) {
        w->v[x->input[l]] = 1.0;
        if (w->plan->step[k].body > 0) {
            mbsri_zero((size_t)n, w->e + body_of(w, k)->iu);
            mbsri_fronts_rates(w, k, w->d->scratch);
        }
        mbsri_fronts_move(w, k);
        read_answer(x, k, l);
        clear(x, k);
        w->v[x->input[l]] = 0.0;
    }
}

/* Answers to rates of its own, with D^+ to Q. */
static void answer_rates(spread *x, int k)
{
    mbsri_fronts *w = x->w;
    const mbsri_body *b = body_of(w, k);
    double *rate = w->e + b->iu;
    for (int j = 0; j < b->n; ++j) {
        mbsri_zero((size_t)b->n, rate);
        rate[j] = 1.0;
        mbsri_fronts_move(w, k);
        read_answer(x, k, j);
        clear(x, k);
    }
    mbsri_zero((size_t)b->n, rate);
    mbsri_copy((size_t)(b->n * b->n), w->d->Dinv + b->nn, x->Q);
}

/* ---- variances ---- */

/* Of what step k has left into Q. Motions left out are zero, as nothing determines them. */
static void take_inputs(spread *x, int k, int inputs)
{
    const mbsri_fronts *w = x->w;
    int next = w->plan->step[k].next;
    const int body = w->plan->step[k].body;
    if (body > 0 && !w->passing[k]) next = w->plan->when[w->m->body[body].parent];
    const variances *s = x->at + next;
    for (int l = 0; l < s->count; ++l) w->slot[s->id[l]] = l;
    for (int j = 0; j < inputs; ++j) {
        const int from = w->slot[x->input[j]];
        for (int l = 0; l < inputs; ++l) {
            const int other = w->slot[x->input[l]];
            x->Q[j * inputs + l] = from >= 0 && other >= 0 ? s->P[from * s->count + other] : 0.0;
        }
    }
    for (int l = 0; l < s->count; ++l) w->slot[s->id[l]] = -1;
}

/* Adds M Q M^T, of `inputs` columns of M, to the variances of rates, with `sizes` to what is added
 * up in these, and to P. */
static void add_answers(spread *x, int k, int inputs, double *rate, double *sizes)
{
    const int n = rates_of(x->w, k), N = x->at[k].count, rows = n + N, most = x->most;
    double *P = x->at[k].P;
    for (int l = 0; l < inputs; ++l) {
        double *column = x->MP + l * most;
        mbsri_zero((size_t)rows, column);
        for (int j = 0; j < inputs; ++j) {
            const double part = x->Q[l * inputs + j], *M = x->M + j * most;
            for (int r = 0; r < rows && part != 0.0; ++r) column[r] += part * M[r];
        }
    }
    for (int l = 0; l < inputs; ++l) {
        const double *column = x->MP + l * most, *other = x->M + l * most;
        for (int r = 0; r < n; ++r) {
            rate[r] += column[r] * other[r];
            sizes[r] += fabs(column[r] * other[r]);
        }
        for (int c = 0; c < N; ++c) {
            const double part = other[n + c];
            for (int r = 0; r < N && part != 0.0; ++r) P[c * N + r] += column[n + r] * part;
        }
    }
}

/* -F^-1 of the pivots. */
static void add_pivots(spread *x, int k)
{
    mbsri_fronts *w = x->w;
    const mbsri_pivots *f = w->pivots[k];
    const int N = x->at[k].count;
    for (int j = 0; f && j < f->pivots; ++j) {
        w->s[f->id[j]] = 1.0;
        mbsri_fronts_reduce(f, w->s);
        mbsri_fronts_substitute(f, w->s, w->v);
        for (int l = 0; l < f->pivots; ++l) x->at[k].P[j * N + l] -= w->v[f->id[l]];
        for (int l = 0; l < N; ++l) w->s[f->id[l]] = w->v[f->id[l]] = 0.0;
    }
}

static bool spread_step(spread *x, int k)
{
    mbsri_fronts *w = x->w;
    double sizes[MBSR_MAX_D] = {0.0}, rate[MBSR_MAX_D] = {0.0};
    if (!open_variances(x, k)) return false;
    const int n = rates_of(w, k), inputs = find_inputs(w, k, x->input);
    if (n > 0) {
        answer_rates(x, k);
        add_answers(x, k, n, rate, sizes);
    }
    if (inputs > 0) {
        answer_inputs(x, k, inputs);
        take_inputs(x, k, inputs);
        add_answers(x, k, inputs, rate, sizes);
    }
    for (int j = 0; j < n; ++j)
        w->e[body_of(w, k)->iu + j] = fabs(rate[j]) > 1e-13 * sizes[j] ? rate[j] : 0.0;
    add_pivots(x, k);
    return true;
}

static void take_rows(const spread *x, int k, double *row)
{
    const mbsri_pivots *f = x->w->pivots[k];
    for (int j = 0; f && j < f->pivots; ++j) {
        if (f->id[j] < x->w->m->rows) row[f->id[j]] = fabs(x->at[k].P[j * (x->at[k].count + 1)]);
    }
}

bool mbsri_fronts_spread(mbsri_fronts *w, double *row)
{
    spread x = {.w = w};
    const size_t unknowns = (size_t)w->m->rows + (size_t)w->m->nu + w->m->size.v;
    if (!allocate_spread(&x)) return false;
    mbsri_zero(unknowns, w->s);
    mbsri_zero(unknowns, w->v);
    if (row) mbsri_zero((size_t)w->m->rows, row);
    for (int k = w->plan->steps - 1; k >= 0; --k) {
        if (!spread_step(&x, k)) return false;
        if (row) take_rows(&x, k, row);
    }
    return true;
}

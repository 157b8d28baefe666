/* What a unit impulse on each joint rate changes it by, loops closed: see mobility.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The matrix of the equations (system.h) is K = L B L^T, and the way back, x = L^-T y, goes from the root to the leaves.
 * So K^-1 = L^-T B^-1 L^-1 is what variances of y, D^+ at joints and -F^-1 where loops close, independent of each other,
 * become on that way: a body needs those of its acceleration and of what is unknown of loops there, P, and each
 * successor takes its own from these (Takahashi 1973 for sparse matrices in general).
 *
 * Motions that nothing determines are found by solving K x = K z for some z: what x and z differ by is one of them.
 */
#include "loops/mobility.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "loops/passing.h"
#include "loops/system.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/not_finite.h"
#include "recursion/spans.h"

#include <math.h>

/* At a body: of its acceleration (d) and then of the unknowns of all groups that close there, or do not yet. */
typedef struct spread {
    int count, *id;
    double *P; /* (d + count) squared */
} spread;

typedef struct mobility {
    mbsri_system w;
    spread *at;      /* bodies + 1 */
    double *out, *z; /* nu, in the order of the sweeps */
    double *M;       /* most x most: answers to unit inputs, by columns */
    double *MP;      /* times the inputs' variances */
    double *Q;       /* most squared: variances of inputs */
    int most;        /* inputs, or numbers of an answer */
} mobility;

static int unknowns_at(const mbsri_system *w, int i)
{
    int count = 0;
    for (const mbsri_pivots *f = w->closing[i]; f; f = f->next) count += f->size;
    return count;
}

static int passing_at(const mbsri_system *w, int i)
{
    const mbsri_passing *p = w->joint[i];
    return i > 0 && p ? p->count + p->nulls : 0;
}

/* Memory, and which unknowns there are at each body. */
static int prepare(mobility *x)
{
    const mbsr_model *m = x->w.m;
    for (int i = 0; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const int n = i > 0 ? b->n : 0, rows = n + b->d + unknowns_at(&x->w, i),
                  inputs = (i > 0 ? b->d_pred : 0) + passing_at(&x->w, i) + n;
        x->most = rows > x->most ? rows : x->most;
        x->most = inputs > x->most ? inputs : x->most;
    }
    const size_t most = (size_t)x->most, nu = (size_t)m->nu;
    x->at = mbsri_system_allocate(&x->w, ((size_t)m->bodies + 1) * sizeof *x->at);
    x->out =
        mbsri_system_allocate(&x->w, (4 * nu + (size_t)m->rows + 3 * most * most) * sizeof(double));
    if (!x->at || !x->out) return MBSR_ERR_NO_MEMORY;
    x->z = x->out + nu;
    x->M = x->z + 3 * nu + (size_t)m->rows;
    x->MP = x->M + most * most;
    x->Q = x->MP + most * most;
    for (int i = 0; i <= m->bodies; ++i) {
        const size_t count = (size_t)unknowns_at(&x->w, i), N = count + (size_t)m->body[i].d;
        spread *s = x->at + i;
        s->P = mbsri_system_allocate(&x->w, N * N * sizeof(double) + count * sizeof(int));
        if (!s->P) return MBSR_ERR_NO_MEMORY;
        s->id = (int *)(void *)(s->P + N * N);
        s->count = 0;
        for (mbsri_pivots *f = x->w.closing[i]; f; f = f->next) {
            f->idles = 0; /* how redundant rows share moves nothing */
            for (int k = 0; k < f->size; ++k) s->id[s->count++] = f->id[k];
        }
    }
    return MBSR_OK;
}

/* ---- answers ---- */

/* Column `to` of M: rates, acceleration and unknowns of body i as they are. */
static void read_answer(mobility *x, int i, int to)
{
    const mbsri_system *w = &x->w;
    const mbsri_body *b = w->m->body + i;
    const int n = i > 0 ? b->n : 0;
    const spread *s = x->at + i;
    double *column = x->M + (size_t)to * (size_t)x->most;
    mbsri_copy((size_t)n, w->e + b->iu, column);
    mbsri_copy((size_t)b->d, w->a + b->v, column + n);
    for (int k = 0; k < s->count; ++k) column[n + b->d + k] = w->v[s->id[k]];
}

/* The answer of body i to one of its inputs, into column `to`. */
static void answer(mobility *x, int i, double *input, int to)
{
    mbsri_system *w = &x->w;
    const mbsri_body *b = w->m->body + i;
    mbsri_zero((size_t)b->n, w->e + b->iu);
    *input = 1.0;
    mbsri_system_rates(w, i, w->d->scratch);
    mbsri_system_move(w, i);
    read_answer(x, i, to);
    *input = 0.0;
}

static void clear(mobility *x, int i)
{
    const mbsri_body *b = x->w.m->body + i;
    const spread *s = x->at + i;
    mbsri_zero((size_t)b->d, x->w.a + b->v);
    for (int k = 0; k < s->count; ++k) x->w.v[s->id[k]] = 0.0;
}

/* Answers to what comes from the predecessor; how many. */
static int answer_inputs(mobility *x, int i)
{
    mbsri_system *w = &x->w;
    const mbsri_body *b = w->m->body + i;
    const int passing = passing_at(w, i);
    int count = 0;
    for (int k = 0; k < b->d_pred; ++k) answer(x, i, w->a + b->pred_v + k, count++);
    for (int k = 0; k < passing; ++k) answer(x, i, w->v + w->joint[i]->id[k], count++);
    return count;
}

/* ---- variances ---- */

/* Of what comes from the predecessor of body i into Q: its own P, of what passes the joint. Motions left out there are
 * zero, as nothing determines them. */
static void take_inputs(mobility *x, int i, int inputs)
{
    const mbsri_system *w = &x->w;
    const mbsri_body *b = w->m->body + i;
    const spread *s = x->at + b->parent;
    const int d = b->d_pred, N = d + s->count;
    for (int k = 0; k < s->count; ++k) w->slot[s->id[k]] = d + k;
    for (int k = 0; k < inputs; ++k) {
        const int from = k < d ? k : w->slot[w->joint[i]->id[k - d]];
        for (int l = 0; l < inputs; ++l) {
            const int other = l < d ? l : w->slot[w->joint[i]->id[l - d]];
            x->Q[k * inputs + l] = from >= 0 && other >= 0 ? s->P[from * N + other] : 0.0;
        }
    }
    for (int k = 0; k < s->count; ++k) w->slot[s->id[k]] = -1;
}

/* Adds M Q M^T, of `inputs` columns of M from `first` on, to the variances of rates, with `sizes` to what is
 * added up in these, and to P. */
static void add_answers(mobility *x, int i, int first, int inputs, double *sizes)
{
    const mbsri_system *w = &x->w;
    const mbsri_body *b = w->m->body + i;
    const int n = i > 0 ? b->n : 0, N = b->d + x->at[i].count, rows = n + N, most = x->most;
    const double *M = x->M + (size_t)first * (size_t)most;
    double *P = x->at[i].P;
    for (int l = 0; l < inputs; ++l) {
        double *column = x->MP + l * most;
        mbsri_zero((size_t)rows, column);
        for (int k = 0; k < inputs; ++k) {
            const double part = x->Q[l * inputs + k];
            for (int r = 0; r < rows && part != 0.0; ++r) column[r] += part * M[k * most + r];
        }
    }
    for (int l = 0; l < inputs; ++l) {
        const double *column = x->MP + l * most, *other = M + l * most;
        for (int r = 0; r < n; ++r) {
            w->e[b->iu + r] += column[r] * other[r];
            sizes[r] += fabs(column[r] * other[r]);
        }
        for (int c = 0; c < N; ++c) {
            const double part = other[n + c];
            for (int r = 0; r < N && part != 0.0; ++r) P[c * N + r] += column[n + r] * part;
        }
    }
}

/* -F^-1 of the pivots. */
static void add_group(mobility *x, int i, const mbsri_pivots *f, int first)
{
    mbsri_system *w = &x->w;
    const mbsri_body *b = w->m->body + i;
    const int N = b->d + x->at[i].count;
    double *P = x->at[i].P + (size_t)(b->d + first) * (size_t)(N + 1);
    for (int k = 0; k < f->pivots; ++k) {
        w->s[f->id[k]] = 1.0;
        mbsri_pivots_forward(f, w->s, w->fbar + b->v);
        mbsri_pivots_backward(f, w->s, w->a + b->v, w->v);
        for (int l = 0; l < f->pivots; ++l) P[k * N + l] -= w->v[f->id[l]];
        for (int l = 0; l < f->size; ++l) w->s[f->id[l]] = w->v[f->id[l]] = 0.0;
    }
}

/* Answers to rates of its own, with D^+ to Q. */
static void answer_rates(mobility *x, int i, int first)
{
    mbsri_system *w = &x->w;
    const mbsri_body *b = w->m->body + i;
    double *rate = w->e + b->iu;
    for (int k = 0; k < b->n; ++k) {
        mbsri_zero((size_t)b->n, rate);
        rate[k] = 1.0;
        mbsri_system_move(w, i);
        read_answer(x, i, first + k);
    }
    mbsri_zero((size_t)b->n, rate);
    mbsri_copy((size_t)(b->n * b->n), w->d->Dinv + b->nn, x->Q);
}

/* The variances at body i; of its rates in place of these in e. */
static void spread_body(mobility *x, int i)
{
    mbsri_system *w = &x->w;
    const mbsri_body *b = w->m->body + i;
    const int N = b->d + x->at[i].count;
    double sizes[MBSR_MAX_D] = {0.0};
    mbsri_zero((size_t)N * (size_t)N, x->at[i].P);
    if (i > 0) {
        const int inputs = answer_inputs(x, i);
        clear(x, i);
        answer_rates(x, i, inputs);
        add_answers(x, i, inputs, b->n, sizes);
        take_inputs(x, i, inputs);
        add_answers(x, i, 0, inputs, sizes);
        for (int k = 0; k < b->n; ++k) {
            if (!(fabs(w->e[b->iu + k]) > 1e-13 * sizes[k])) w->e[b->iu + k] = 0.0;
        }
    }
    clear(x, i);
    int first = 0;
    for (const mbsri_pivots *f = w->closing[i]; f; f = f->next) {
        add_group(x, i, f, first);
        first += f->size;
    }
}

static void spread_all(mobility *x)
{
    mbsri_system *w = &x->w;
    const size_t unknowns = (size_t)w->m->rows + (size_t)w->m->nu;
    mbsri_zero(unknowns, w->s);
    mbsri_zero(unknowns, w->v);
    mbsri_zero(w->m->size_v, w->a);
    for (int i = 0; i <= w->m->bodies; ++i) spread_body(x, i);
}

/* ---- motions that nothing determines ---- */

/* M z: a = -(H a_pred + J z), and the momenta back along the tree; z and the result in the order of the sweeps. */
static void multiply(mobility *x, const double *z, double *result)
{
    const mbsr_model *m = x->w.m;
    const mbsr_data *d = x->w.d;
    double *a = x->w.a, *p = x->w.fbar;
    mbsri_zero(m->size_v, a);
    mbsri_zero(m->size_v, p);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_ax(b->d, b->d_pred, -1.0, d->H + b->dp, a + b->pred_v, a + b->v);
        mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, z + b->iu, a + b->v);
        mbsri_ax(b->d, b->d, 1.0, d->M + b->dd, a + b->v, p + b->v);
    }
    for (int k = 0; k < m->nu; ++k) result[k] = m->armature[k] * z[k];
    for (int i = m->bodies; i > 0; --i) {
        const mbsri_body *b = m->body + i;
        mbsri_atx(b->d, b->n, -1.0, d->J + b->dn, p + b->v, result + b->iu);
        mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, p + b->v, p + b->pred_v);
    }
}

/* Rates that these have a part in have no mobility. */
static void mark_undetermined(mobility *x)
{
    mbsri_system *w = &x->w;
    const mbsr_model *m = w->m;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double *z = x->z, *g = z + m->nu, *found = g + m->nu, *rows = found + m->nu;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = b->iu; k < b->iu + b->n; ++k)
            z[k] = (1.0 + 0.5 * sin(12.9898 * k)) * mbsri_rate_span(&spans, m, b, k - b->iu);
    }
    multiply(x, z, w->e);
    mbsri_scatter(m, w->e, g);
    mbsri_scatter(m, z, found);
    mbsri_closure_apply(m, w->d, found, rows);
    mbsri_system_solve(w, g, rows, found, rows);
    mbsri_gather(m, found, w->e);
    for (int k = 0; k < m->nu; ++k) {
        if (fabs(w->e[k] - z[k]) > 1e-6 * z[k]) x->out[k] = -1.0;
    }
}

static int find(mobility *x, double *result, const char *function)
{
    mbsri_system *w = &x->w;
    const mbsri_closure *c = w->m->closures.data;
    for (size_t id = 0; id < w->m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k)
            w->left_out[c->row + k] = mbsri_is_loose(c, k) || w->d->dropped[c->row + k];
    }
    int status = mbsri_closure_jacobians(w->m, w->d);
    if (!status) status = mbsri_system_factor(w, NULL, function);
    if (status) return status;
    if (prepare(x))
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d joint rates and %d rows of closures", function,
                          w->m->nu, w->m->rows);
    spread_all(x);
    for (int k = 0; k < w->m->nu; ++k) x->out[k] = fmax(w->e[k], 0.0);
    if (w->free >= 0) mark_undetermined(x);
    status = mbsri_check_result(w->m, w->d, (size_t)w->m->nu, x->out, function);
    if (!status) mbsri_scatter(w->m, x->out, result);
    return status;
}

int mbsri_loops_mobility(const mbsr_model *m, mbsr_data *d, double *result, const char *function)
{
    mobility x = {.most = 0};
    int status = mbsri_system_open(&x.w, m, d, function);
    if (!status) status = find(&x, result, function);
    mbsri_system_close(&x.w);
    return status;
}

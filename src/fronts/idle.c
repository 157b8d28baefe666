/* Loop forces that move nothing: see idle.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fronts/idle.h"

#include "algebra/dense.h"

#include <math.h>

/* A vector over some rows. It counts by those whose closures meet at one body, nothing of it is
 * nearer to the root, and those of one body are orthonormal there. */
typedef struct mbsri_idle {
    int count, *row;
    double *value;
    double *weight; /* value times squared shares, zero for rows that do not count */
    int meets;      /* the body */
    int turn;       /* the last one that it was subtracted in */
    struct mbsri_idle *next;
} idle;

/* Vectors that have a row. */
typedef struct touch {
    idle *vector;
    struct touch *next;
} touch;

typedef struct search {
    mbsri_fronts *w;
    touch **touched; /* rows */
    idle **found;    /* bodies: that meet there */
    double *value;   /* rows: of the vector that is being made */
    int *row, count; /* where it may differ from zero */
    bool *listed;    /* rows: those among these */
    int *meets;      /* rows: where their closures meet */
    int *stack;      /* steps */
    int turn;
} search;

static const double ROUNDING = 1e-12; /* of what is added up in a number */
static const double DEPENDENT = 1e-9; /* of the norm of the whole vector, less others */
static const double CLEAR = 1e-3;     /* of a vector's largest number: of a row that may go */

static double share_of(const mbsri_fronts *w, int row)
{
    return w->share[row] > 0.0 ? w->share[row] : 1.0;
}

/* ---- a vector ---- */

static void list(search *x, int row)
{
    if (x->listed[row]) return;
    x->listed[row] = true;
    x->row[x->count++] = row;
}

/* Forces of the pivots of a front, where its other unknowns have theirs; motions are zero. */
static void follow_pivots(search *x, const mbsri_pivots *f)
{
    const mbsri_fronts *w = x->w;
    const int N = f->size + f->d;
    for (int p = f->pivots - 1; p >= 0; --p) {
        const double *L = f->A + p * N;
        const bool first = f->across[p] != 0.0;
        double sum = 0.0, size = 0.0;
        if (f->id[p] >= w->m->rows) continue;
        for (int i = first ? p + 2 : p + 1; i < f->size; ++i) {
            sum -= L[i] * w->v[f->id[i]];
            size += fabs(L[i] * w->v[f->id[i]]);
        }
        if (fabs(sum) <= ROUNDING * size) continue;
        w->v[f->id[p]] = sum;
        list(x, f->id[p]);
    }
}

/* Whether the step has passed something on that the vector has. */
static bool is_reached(const mbsri_fronts *w, int k)
{
    const mbsri_passing *p = w->passing[k];
    const mbsri_pivots *f = w->pivots[k];
    bool reached = false;
    if (p) {
        for (int l = 0; l < p->count && !reached; ++l)
            reached = p->id[l] < w->m->rows && w->v[p->id[l]] != 0.0;
    } else if (f) {
        for (int l = f->pivots + f->left; l < f->size && !reached; ++l)
            reached = f->id[l] < w->m->rows && w->v[f->id[l]] != 0.0;
    }
    return reached;
}

/* The vector with 1 in `row`, which nothing is left of in step k. */
static void make(search *x, int k, int row)
{
    const mbsri_fronts *w = x->w;
    int depth = 0;
    x->count = 0;
    list(x, row);
    w->v[row] = 1.0;
    x->stack[depth++] = k;
    while (depth > 0) {
        const mbsri_plan_step *s = w->plan->step + x->stack[--depth];
        const mbsri_pivots *f = w->pivots[s - w->plan->step];
        if (f) follow_pivots(x, f);
        for (int l = 0; l < s->children; ++l) {
            const int child = w->plan->child[s->first + l];
            if (is_reached(w, child)) x->stack[depth++] = child;
        }
    }
    for (int l = 0; l < x->count; ++l) {
        x->value[x->row[l]] = w->v[x->row[l]];
        w->v[x->row[l]] = 0.0;
    }
}

/* ---- all of them ---- */

/* y . z over the rows that meet at the body of z. */
static double product(const search *x, const idle *z)
{
    double sum = 0.0;
    for (int k = 0; k < z->count; ++k) sum += z->weight[k] * x->value[z->row[k]];
    return sum;
}

static void subtract_projection(search *x, idle *z)
{
    const double part = product(x, z);
    z->turn = x->turn;
    for (int k = 0; k < z->count; ++k) {
        list(x, z->row[k]);
        x->value[z->row[k]] -= part * z->value[k];
    }
}

enum { ALL = -1 };

/* Its norm over the rows that meet at a body, or ALL. */
static double norm_at(const search *x, int body)
{
    double square = 0.0;
    for (int k = 0; k < x->count; ++k) {
        const double value = x->value[x->row[k]] * share_of(x->w, x->row[k]);
        if (body == ALL || x->meets[x->row[k]] == body) square += value * value;
    }
    return sqrt(square);
}

/* Less those of the body that overlap there, twice; its norm that is left there. */
static double make_orthogonal(search *x, int body)
{
    for (int twice = 0; twice < 2; ++twice) {
        ++x->turn;
        for (int k = 0; k < x->count; ++k) {
            if (x->meets[x->row[k]] != body) continue;
            for (const touch *t = x->touched[x->row[k]]; t; t = t->next) {
                if (t->vector->meets == body && t->vector->turn != x->turn)
                    subtract_projection(x, t->vector);
            }
        }
    }
    return norm_at(x, body);
}

/* The first body at which rows of the vector meet, -1: there is nothing. */
static int first_meeting(const search *x)
{
    int first = -1;
    for (int k = 0; k < x->count; ++k) {
        const int body = x->meets[x->row[k]];
        if (x->value[x->row[k]] != 0.0 && (first < 0 || body < first)) first = body;
    }
    return first;
}

/* What the vector counts by: the body, and *norm of it there; -1: it depends on others. A part that
 * is rounding beside the vector does not count: divided by its norm there, the rest is without
 * bound. */
static int settle_direction(search *x, double *norm)
{
    const double all = norm_at(x, ALL);
    int body;
    while ((body = first_meeting(x)) >= 0) {
        *norm = make_orthogonal(x, body);
        if (*norm > DEPENDENT * all) return body;
        for (int k = 0; k < x->count; ++k) {
            if (x->meets[x->row[k]] == body) x->value[x->row[k]] = 0.0;
        }
    }
    return -1;
}

static bool keep(search *x)
{
    mbsri_fronts *w = x->w;
    double norm = 1.0;
    const int body = settle_direction(x, &norm);
    const size_t n = (size_t)x->count;
    idle *z = mbsri_fronts_allocate(w, sizeof *z +
                                           n * (2 * sizeof(double) + sizeof(touch) + sizeof(int)));
    if (!z) return false;
    *z = (idle){.meets = body, .value = (double *)(void *)(z + 1)};
    z->weight = z->value + n;
    touch *t = (touch *)(void *)(z->weight + n);
    z->row = (int *)(void *)(t + n);
    for (size_t k = 0; k < n; ++k) {
        const int row = x->row[k];
        const double value = x->value[row] / norm;
        x->value[row] = 0.0;
        x->listed[row] = false;
        if (value == 0.0 || body < 0) continue;
        t[z->count] = (touch){z, x->touched[row]};
        x->touched[row] = t + z->count;
        const double share = x->meets[row] == body ? share_of(w, row) : 0.0;
        z->row[z->count] = row;
        z->weight[z->count] = share * share * value;
        z->value[z->count++] = value;
    }
    if (body < 0) return true;
    z->next = x->found[body];
    x->found[body] = z;
    return true;
}

/* The rows of step k that nothing is left of; alone, their forces are zero already. */
static bool find_in(search *x, int k)
{
    const mbsri_pivots *f = x->w->pivots[k];
    bool room = true;
    for (int l = 0; f && l < f->left && room; ++l) {
        const int row = f->id[f->pivots + l];
        if (row >= x->w->m->rows) continue;
        make(x, k, row);
        if (x->count > 1) {
            room = keep(x);
        } else {
            x->value[row] = 0.0;
            x->listed[row] = false;
        }
    }
    return room;
}

static bool open_search(search *x)
{
    mbsri_fronts *w = x->w;
    const size_t rows = (size_t)w->m->rows, steps = (size_t)w->plan->steps,
                 bodies = (size_t)w->m->bodies + 1;
    x->touched = mbsri_fronts_allocate(w, rows * sizeof *x->touched);
    x->found = mbsri_fronts_allocate(w, bodies * sizeof *x->found);
    x->value = mbsri_fronts_allocate(w, rows * sizeof *x->value);
    x->row = mbsri_fronts_allocate(w, (2 * rows + steps) * sizeof *x->row);
    x->listed = mbsri_fronts_allocate(w, rows * sizeof *x->listed);
    if (!x->touched || !x->found || !x->value || !x->row || !x->listed) return false;
    x->meets = x->row + rows;
    x->stack = x->meets + rows;
    mbsri_zero(rows, x->value);
    mbsri_zero(rows + (size_t)w->m->nu, w->v);
    for (size_t k = 0; k < rows; ++k) x->touched[k] = NULL, x->listed[k] = false;
    for (size_t i = 0; i < bodies; ++i) x->found[i] = NULL;
    const mbsri_closure *c = w->m->closures.data;
    for (size_t id = 0; id < w->m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k) x->meets[c->row + k] = c->meets;
    }
    return true;
}

bool mbsri_idle_find(mbsri_fronts *w)
{
    bool any = false;
    w->idle = NULL;
    for (int k = 0; k < w->plan->steps && !any; ++k) any = w->pivots[k] && w->pivots[k]->left > 0;
    if (!any) return true;
    search x = {.w = w};
    if (!open_search(&x)) return false;
    for (int k = 0; k < w->plan->steps; ++k) {
        if (!find_in(&x, k)) return false;
    }
    for (int i = w->m->bodies; i >= 0; --i) { /* the root first, at last */
        while (x.found[i]) {
            idle *z = x.found[i];
            x.found[i] = z->next;
            z->next = w->idle;
            w->idle = z;
        }
    }
    return true;
}

void mbsri_idle_leave_out(const mbsri_fronts *w, double *lambda)
{
    for (const idle *z = w->idle; z; z = z->next) {
        double part = 0.0;
        for (int k = 0; k < z->count; ++k) part += z->weight[k] * lambda[z->row[k]];
        for (int k = 0; k < z->count; ++k) lambda[z->row[k]] -= part * z->value[k];
    }
}

/* ---- which rows depend on others ---- */

typedef struct echelon {
    mbsri_fronts *w;
    const int *order;
    const idle **owner; /* rows: the vector of which this is the last one */
    double *value;      /* rows: of the vector at work */
    int *row, count;    /* where it may differ from zero */
    bool *listed;       /* rows */
} echelon;

static double part_of(const echelon *x, int row)
{
    return fabs(x->value[row]) * share_of(x->w, row);
}

/* The row with the greatest place of those that the vector clearly has, of several in one place
 * that of which it has most; -1: it is zero. */
static int last_row(const echelon *x)
{
    double largest = 0.0;
    int last = -1;
    for (int k = 0; k < x->count; ++k) largest = fmax(largest, part_of(x, x->row[k]));
    for (int k = 0; k < x->count; ++k) {
        const int row = x->row[k];
        const double part = part_of(x, row);
        if (!(part > CLEAR * largest)) continue;
        const int later = last < 0 ? 1 : x->order[row] - x->order[last];
        if (later > 0 || (later == 0 && part > part_of(x, last))) last = row;
    }
    return last;
}

static void add_vector(echelon *x, const idle *z, double factor)
{
    for (int k = 0; k < z->count; ++k) {
        const int row = z->row[k];
        if (!x->listed[row]) {
            x->listed[row] = true;
            x->value[row] = 0.0;
            x->row[x->count++] = row;
        }
        x->value[row] += factor * z->value[k];
    }
}

static double pivot_value(const idle *z, int row)
{
    int k = 0;
    while (z->row[k] != row) ++k;
    return z->value[k];
}

/* The vector less others, until its last row is that of none of these. Where digits got lost that
 * need not come to an end: such a vector has no row of its own. */
static bool reduce_echelon(echelon *x, const idle *z)
{
    int last, steps = x->w->m->rows;
    x->count = 0;
    add_vector(x, z, 1.0);
    while ((last = last_row(x)) >= 0 && x->owner[last] && steps-- > 0) {
        const idle *other = x->owner[last];
        add_vector(x, other, -x->value[last] / pivot_value(other, last));
        x->value[last] = 0.0;
    }
    if (last >= 0 && x->owner[last]) last = -1;
    const size_t n = (size_t)x->count;
    idle *own = last < 0
                    ? NULL
                    : mbsri_fronts_allocate(x->w, sizeof *own + n * (sizeof(double) + sizeof(int)));
    for (int k = 0; k < x->count; ++k) x->listed[x->row[k]] = false;
    if (last < 0 || !own) return last < 0;
    *own = (idle){.count = x->count, .value = (double *)(void *)(own + 1)};
    own->row = (int *)(void *)(own->value + n);
    for (int k = 0; k < x->count; ++k) {
        own->row[k] = x->row[k];
        own->value[k] = x->value[x->row[k]];
    }
    x->owner[last] = own;
    return true;
}

static void mark_shared(const mbsri_fronts *w, const idle *z, bool *shared)
{
    static const double part = 1e-6;
    double largest = 0.0;
    for (int k = 0; k < z->count; ++k)
        largest = fmax(largest, fabs(z->value[k]) * share_of(w, z->row[k]));
    for (int k = 0; k < z->count; ++k) {
        if (fabs(z->value[k]) * share_of(w, z->row[k]) > part * largest) shared[z->row[k]] = true;
    }
}

bool mbsri_idle_rows(mbsri_fronts *w, const int *order, bool *dependent, bool *shared)
{
    const size_t rows = (size_t)w->m->rows;
    echelon x = {.w = w, .order = order};
    x.owner = mbsri_fronts_allocate(
        w, rows * (sizeof *x.owner + sizeof(double) + sizeof(int) + sizeof(bool)));
    if (!x.owner) return false;
    x.value = (double *)(void *)(x.owner + rows);
    x.row = (int *)(void *)(x.value + rows);
    x.listed = (bool *)(x.row + rows);
    for (size_t k = 0; k < rows; ++k) {
        x.owner[k] = NULL;
        x.listed[k] = dependent[k] = shared[k] = false;
    }
    for (const idle *z = w->idle; z; z = z->next) {
        mark_shared(w, z, shared);
        if (!reduce_echelon(&x, z)) return false;
    }
    for (size_t k = 0; k < rows; ++k) dependent[k] = x.owner[k] != NULL;
    for (const idle *z = w->idle; z; z = z->next) {
        for (int k = 0; k < z->count; ++k) x.listed[z->row[k]] = true;
    }
    for (int k = 0; k < w->plan->steps; ++k) { /* rows of zeros depend on nothing else */
        const mbsri_pivots *f = w->pivots[k];
        for (int l = 0; f && l < f->left; ++l) {
            const int row = f->id[f->pivots + l];
            if (row < w->m->rows && !x.listed[row]) dependent[row] = shared[row] = true;
        }
    }
    return true;
}

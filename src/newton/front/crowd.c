/* Iterations for the forces in pairs apart: see crowd.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/front/crowd.h"

#include "algebra/dense.h"
#include "base/memory.h"
#include "newton/slopes/relation.h"

#include <mbsrank/dae.h>

#include <math.h>
#include <string.h>

/* Vectors until GMRES begins anew, how often it does, and plans that leave nothing apart after it
 * has failed. */
enum { VECTORS = 30, RESTARTS = 4, RESTS = 10 };

/* ---- memory ---- */

static int crowd_larger(int a, int b)
{
    return a > b ? a : b;
}

/* The longest block and answer of two bodies. */
static void find_lengths(const mbsr_model *m, mbsri_front_crowd *c)
{
    int rows = 0, columns = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        rows = crowd_larger(rows, b->d);
        columns = crowd_larger(columns, mbsri_pose_size(b) + b->d);
    }
    c->block = (size_t)rows * (size_t)columns;
    c->answer = (size_t)rows * (size_t)rows;
}

static size_t crowd_place(const mbsr_model *m, mbsri_front_crowd *c, unsigned char *memory)
{
    const size_t bodies = (size_t)m->bodies + 1, pairs = (size_t)m->elements.pairs,
                 size = m->size.v;
    size_t used = 0;
    double **const doubles[] = {&c->blocks,     &c->weight,   &c->loads,     &c->solution,
                                &c->given,      &c->answers,  &c->zero,      &c->basis,
                                &c->hessenberg, &c->rotation, &c->projected, &c->motions};
    const size_t count[] = {2 * pairs * c->block,
                            size,
                            size,
                            size,
                            size,
                            2 * pairs * c->answer,
                            (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM),
                            (VECTORS + 1) * size,
                            (size_t)VECTORS * (VECTORS + 1),
                            2 * (size_t)VECTORS,
                            VECTORS + 1,
                            bodies * c->block};
    for (size_t k = 0; k < sizeof doubles / sizeof doubles[0]; ++k)
        *doubles[k] = mbsri_take_bytes(memory, &used, count[k] * sizeof(double));
    c->group = mbsri_take_bytes(memory, &used, bodies * sizeof *c->group);
    c->size = mbsri_take_bytes(memory, &used, bodies * sizeof *c->size);
    c->apart = mbsri_take_bytes(memory, &used, pairs * sizeof *c->apart);
    c->order = mbsri_take_bytes(memory, &used, pairs * sizeof *c->order);
    return used;
}

mbsri_front_crowd *mbsri_front_crowd_create(const mbsr_model *m, int together, double error)
{
    mbsri_front_crowd *c = mbsri_allocate(&m->allocator, sizeof *c);
    if (!c) return NULL;
    *c = (mbsri_front_crowd){.together = together, .error = error};
    find_lengths(m, c);
    const size_t size = crowd_place(m, c, NULL);
    c->memory = mbsri_allocate(&m->allocator, size);
    if (!c->memory) {
        mbsri_release(&m->allocator, c);
        return NULL;
    }
    (void)crowd_place(m, c, c->memory);
    memset(c->apart, 0, (size_t)m->elements.pairs * sizeof *c->apart);
    mbsri_zero((size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM), c->zero);
    c->bytes = sizeof *c + size;
    return c;
}

void mbsri_front_crowd_destroy(const mbsr_model *m, mbsri_front_crowd *crowd)
{
    if (!crowd) return;
    mbsri_release(&m->allocator, crowd->memory);
    mbsri_release(&m->allocator, crowd);
}

/* ---- which pairs are apart ---- */

static int crowd_head_of(int *group, int i)
{
    while (group[i] != i) i = group[i] = group[group[i]];
    return i;
}

static void crowd_join(mbsri_front_crowd *c, int a, int b)
{
    if (a == 0 || b == 0) return;
    a = crowd_head_of(c->group, a);
    b = crowd_head_of(c->group, b);
    if (a == b) return;
    const int head = a < b ? a : b, other = a < b ? b : a;
    c->group[other] = head;
    c->size[head] += c->size[other];
}

/* Bodies that pairs tie, with those that joints, elements and closures tie to them; the largest
 * group. */
static int largest_group(mbsri_front *f)
{
    const mbsr_model *m = f->model;
    const mbsri_pairs *pairs = &f->linear->pairs;
    mbsri_front_crowd *c = f->crowd;
    const mbsri_front_source from = {.model = m, .pairs = pairs};
    int largest = 0;
    for (int i = 0; i <= m->bodies; ++i) c->group[i] = i, c->size[i] = 1;
    for (int i = 1; i <= m->bodies; ++i) crowd_join(c, i, m->body[i].parent);
    for (int k = 0; k < mbsri_front_elements(&from); ++k) {
        const int *list, count = mbsri_front_bodies(&from, k, &list);
        for (int l = 1; l < count; ++l) crowd_join(c, list[0], list[l]);
    }
    for (int i = 1; i <= m->bodies; ++i) largest = c->size[i] > largest ? c->size[i] : largest;
    return largest;
}

static bool may_be_apart(const mbsr_model *m, const mbsri_acting *pair)
{
    return pair->body[0] > 0 && pair->body[1] > 0 &&
           mbsri_force_at(m, (size_t)pair->force)->def.table->flags & MBSR_FORCE_NO_JOINT &&
           mbsri_relate(m, pair->body[0], pair->body[1]) == MBSRI_APART;
}

static int first_of(const mbsri_acting *pair)
{
    return pair->body[0] < pair->body[1] ? pair->body[0] : pair->body[1];
}

/* Those apart, by the first of their bodies. */
static void order_pairs(mbsri_front *f)
{
    const mbsri_acting *pair = f->linear->pairs.pair;
    mbsri_front_crowd *c = f->crowd;
    int *start = c->group, sum = 0;
    for (int i = 0; i <= f->model->bodies; ++i) start[i] = 0;
    for (int k = 0; k < f->linear->pairs.count; ++k) start[first_of(pair + k)] += c->apart[k];
    for (int i = 0; i <= f->model->bodies; ++i) {
        const int count = start[i];
        start[i] = sum;
        sum += count;
    }
    for (int k = 0; k < f->linear->pairs.count; ++k)
        if (c->apart[k]) c->order[start[first_of(pair + k)]++] = k;
}

void mbsri_front_crowd_part(mbsri_front *f)
{
    mbsri_front_crowd *c = f->crowd;
    const mbsri_pairs *pairs = &f->linear->pairs;
    const bool many = c->rest == 0 && largest_group(f) > c->together;
    c->count = 0;
    if (c->rest > 0) --c->rest;
    for (int k = 0; k < pairs->count; ++k) {
        c->apart[k] = many && may_be_apart(f->model, pairs->pair + k);
        c->count += c->apart[k];
    }
    order_pairs(f);
}

/* ---- loads ---- */

void mbsri_front_crowd_begin(mbsri_front *f, const mbsr_data *d)
{
    enum { MOST = 6 };
    const mbsr_model *m = f->model;
    double least[MOST], *weight = f->crowd->weight;
    for (int r = 0; r < MOST; ++r) least[r] = INFINITY;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int r = 0; r < b->d; ++r) {
            const double mass = d->M[b->dd + (size_t)(r * (b->d + 1))];
            weight[b->v + (size_t)r] = mass;
            if (mass > 0.0 && mass < least[r % MOST]) least[r % MOST] = mass;
        }
    }
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int r = 0; r < b->d; ++r) {
            double *w = weight + b->v + (size_t)r;
            const double other = isfinite(least[r % MOST]) ? least[r % MOST] : 1.0;
            *w = 1.0 / (*w > 0.0 ? *w : other);
        }
    }
}

/* Bodies of a pair apart: forces on `on` by the motion of `by`, and its block and answer. */
typedef struct direction {
    int on, by;
    double *block, *answer;
} direction;

static direction direction_of(const mbsri_front *f, int pair, int side)
{
    const mbsri_acting *now = f->linear->pairs.pair + pair;
    const size_t at = 2 * (size_t)pair + (size_t)side;
    const mbsri_front_crowd *c = f->crowd;
    return (direction){now->body[1 - side], now->body[side], c->blocks + at * c->block,
                       c->answers + at * c->answer};
}

/* Where the rows and columns of the second body of a pair begin. */
static int second_row(const mbsri_front *f, int pair)
{
    const mbsri_body *first = f->model->body + f->linear->pairs.pair[pair].body[0];
    return first->d + first->n;
}

static int second_column(const mbsri_front *f, int pair)
{
    const int i = f->linear->pairs.pair[pair].body[0];
    const mbsri_body *first = f->model->body + i;
    return f->linear->e[i] + first->d + first->nq + first->n;
}

size_t mbsri_front_crowd_own(const mbsri_front *f, int pair, int i, int rows)
{
    if (f->linear->pairs.pair[pair].body[0] == i) return 0;
    return (size_t)second_column(f, pair) * (size_t)rows + (size_t)second_row(f, pair);
}

void mbsri_front_crowd_keep(mbsri_front *f, int pair, int i, const double *matrix, int rows)
{
    const int side = f->linear->pairs.pair[pair].body[0] == i ? 0 : 1;
    const direction to = direction_of(f, pair, side);
    const mbsri_body *on = f->model->body + to.on, *by = f->model->body + to.by;
    const int x = f->linear->e[to.by] + by->d;
    const double *from = side == 0 ? matrix + second_row(f, pair)
                                   : matrix + (size_t)second_column(f, pair) * (size_t)rows;
    for (int l = 0; l < x; ++l)
        mbsri_copy((size_t)on->d, from + (size_t)l * (size_t)rows, to.block + l * on->d);
}

void mbsri_front_crowd_load(mbsri_front *f)
{
    const mbsr_model *m = f->model;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const double *F = f->crowd->loads + b->v;
        double *rate = f->h + f->names[i].y + b->d;
        for (int r = 0; r < b->d; ++r) rate[r] = F[r];
        for (int r = 0; r < b->d && f->linear->below_massless[i]; ++r) rate[b->d + r] = -F[r];
    }
}

/* F (size_v) = E x */
static void find_forces(const mbsri_front *f, double *F)
{
    const mbsr_model *m = f->model;
    mbsri_zero(m->size.v, F);
    for (int k = 0; k < f->linear->pairs.count; ++k) {
        for (int side = 0; side < 2 && f->crowd->apart[k]; ++side) {
            const direction of = direction_of(f, k, side);
            const mbsri_body *on = m->body + of.on, *by = m->body + of.by;
            mbsri_ax_often(on->d, f->linear->e[of.by] + by->d, 1.0, of.block,
                           f->value + f->names[of.by].x, F + on->v);
        }
    }
}

/* ---- GMRES ---- */

/* In four sums, none of which waits for another. */
static double crowd_product(const mbsri_front_crowd *c, size_t n, const double *a, const double *b)
{
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    size_t k = 0;
    for (; k + 4 <= n; k += 4) {
        for (size_t l = 0; l < 4; ++l) sum[l] += a[k + l] * b[k + l] * c->weight[k + l];
    }
    for (; k < n; ++k) sum[0] += a[k] * b[k] * c->weight[k];
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

static void crowd_add(size_t n, double by, const double *restrict x, double *restrict y)
{
    for (size_t k = 0; k < n; ++k) y[k] += by * x[k];
}

static void crowd_scale(size_t n, double by, double *x)
{
    for (size_t k = 0; k < n; ++k) x[k] *= by;
}

/* ---- bodies that are alone ---- */

static bool are_alone(const mbsri_front *f)
{
    bool alone = true;
    for (int k = 0; k < f->plan.steps && alone; ++k)
        alone = f->plan.step[k].floats && mbsri_front_is_alone(f, k);
    return alone;
}

void mbsri_front_crowd_finish(mbsri_front *f, mbsri_front_response_of response)
{
    const mbsr_model *m = f->model;
    mbsri_front_crowd *c = f->crowd;
    c->alone = are_alone(f);
    if (!c->alone) return;
    for (int k = 0; k < f->plan.steps; ++k)
        response(f, k, c->motions + (size_t)f->plan.step[k].body * c->block);
    for (int k = 0; k < 2 * f->linear->pairs.count; ++k) {
        const direction of = direction_of(f, k / 2, k % 2);
        const mbsri_body *on = m->body + of.on, *by = m->body + of.by;
        const int x = f->linear->e[of.by] + by->d;
        const double *motion = c->motions + (size_t)of.by * c->block;
        for (int r = 0; r < by->d && c->apart[k / 2]; ++r) {
            double *answer = of.answer + r * on->d;
            mbsri_zero((size_t)on->d, answer);
            mbsri_ax_often(on->d, x, 1.0, of.block, motion + r * x, answer);
        }
    }
}

/* F += by L x, or by U x, where E S = L + U: forces on the second body of a pair, or on the first.
 * Pairs stand in the order of their first bodies, so that where F is x, (1 - L)^-1 x is left. */
static void add_answers(const mbsri_front *f, bool second, double by, const double *x, double *F)
{
    const mbsri_front_crowd *c = f->crowd;
    for (int k = 0; k < c->count; ++k) {
        const int pair = c->order[k], *body = f->linear->pairs.pair[pair].body;
        const direction of = direction_of(f, pair, second == (body[0] < body[1]) ? 0 : 1);
        const mbsri_body *on = f->model->body + of.on, *moving = f->model->body + of.by;
        mbsri_ax_often(on->d, moving->d, by, of.answer, x + moving->v, F + on->v);
    }
}

/* F = P z: (1 - L)^-1 z where bodies are alone, else z. */
static void crowd_prepare(const mbsri_front *f, const double *z, double *F)
{
    mbsri_copy(f->model->size.v, z, F);
    if (f->crowd->alone) add_answers(f, true, 1.0, F, F);
}

/* y = (1 - E S) P z */
static void crowd_apply(mbsri_front *f, mbsri_front_sweep_of sweep, const double *z, double *y)
{
    const size_t n = f->model->size.v;
    crowd_prepare(f, z, f->crowd->loads);
    if (f->crowd->alone) {
        mbsri_copy(n, z, y);
        add_answers(f, false, -1.0, f->crowd->loads, y);
        return;
    }
    sweep(f, f->crowd->zero);
    find_forces(f, y);
    for (size_t k = 0; k < n; ++k) y[k] = z[k] - y[k];
}

/* Column j of the Hessenberg matrix by the rotations so far, and a new one; what is left then. */
static double crowd_rotate(mbsri_front_crowd *c, int j)
{
    double *h = c->hessenberg + (ptrdiff_t)j * (VECTORS + 1), *g = c->projected;
    for (int k = 0; k < j; ++k) {
        const double cosine = c->rotation[2 * k], sine = c->rotation[2 * k + 1], a = h[k];
        h[k] = cosine * a + sine * h[k + 1];
        h[k + 1] = cosine * h[k + 1] - sine * a;
    }
    const double length = hypot(h[j], h[j + 1]);
    const double cosine = length > 0.0 ? h[j] / length : 1.0,
                 sine = length > 0.0 ? h[j + 1] / length : 0.0;
    c->rotation[2 * j] = cosine;
    c->rotation[2 * j + 1] = sine;
    h[j] = length;
    g[j + 1] = -sine * g[j];
    g[j] *= cosine;
    return fabs(g[j + 1]);
}

/* Adds to z the best of `count` vectors. */
static void crowd_combine(mbsri_front_crowd *c, size_t n, int count, double *z)
{
    for (int j = count - 1; j >= 0; --j) {
        double *g = c->projected;
        const double *h = c->hessenberg + (ptrdiff_t)j * (VECTORS + 1);
        g[j] = h[j] > 0.0 ? g[j] / h[j] : 0.0;
        for (int k = 0; k < j; ++k) g[k] -= h[k] * g[j];
    }
    for (int j = 0; j < count; ++j) crowd_add(n, c->projected[j], c->basis + (size_t)j * n, z);
}

/* From the first vector, of length `size` before it was made 1, until `least` is left; what is. */
static double crowd_iterate(mbsri_front *f, mbsri_front_sweep_of sweep, double size, double least,
                            double *z)
{
    mbsri_front_crowd *c = f->crowd;
    const size_t n = f->model->size.v;
    double left = size;
    int count = 0;
    c->projected[0] = size;
    while (count < VECTORS && left > least) {
        double *next = c->basis + (size_t)(count + 1) * n,
               *h = c->hessenberg + (ptrdiff_t)count * (VECTORS + 1);
        crowd_apply(f, sweep, c->basis + (size_t)count * n, next);
        for (int k = 0; k <= count; ++k) {
            const double *of = c->basis + (size_t)k * n;
            h[k] = crowd_product(c, n, of, next);
            crowd_add(n, -h[k], of, next);
        }
        h[count + 1] = sqrt(crowd_product(c, n, next, next));
        if (h[count + 1] > 0.0) crowd_scale(n, 1.0 / h[count + 1], next);
        left = crowd_rotate(c, count++);
        if (!(left <= size)) break; /* not finite */
    }
    crowd_combine(c, n, count, z);
    c->iterations += count;
    return left;
}

bool mbsri_front_crowd_solve(mbsri_front *f, const double *r, mbsri_front_sweep_of sweep)
{
    mbsri_front_crowd *c = f->crowd;
    const size_t n = f->model->size.v;
    double *z = c->solution, *first = c->basis;
    mbsri_zero(n, z);
    mbsri_zero(n, c->loads);
    sweep(f, r);
    find_forces(f, c->given);
    const double goal = c->error * sqrt(crowd_product(c, n, c->given, c->given));
    double left = goal > 0.0 ? INFINITY : goal;
    for (int k = 0; k < RESTARTS && left > goal; ++k) {
        crowd_apply(f, sweep, z, first);
        for (size_t l = 0; l < n; ++l) first[l] = c->given[l] - first[l];
        left = sqrt(crowd_product(c, n, first, first));
        if (!(left > goal)) break;
        crowd_scale(n, 1.0 / left, first);
        left = crowd_iterate(f, sweep, left, goal, z);
    }
    crowd_prepare(f, z, c->loads);
    if (left <= goal) return true;
    c->rest = RESTS;
    return false;
}

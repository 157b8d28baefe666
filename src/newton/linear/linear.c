/* The linearised equations: see linear.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/linear/linear.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forces/coordinate_laws.h"
#include "forces/gravity.h"
#include "forms/loops.h"
#include "forms/momentum.h"
#include "model/query.h"
#include "newton/slopes/axes.h"
#include "newton/slopes/body_slopes.h"
#include "newton/slopes/closure_slopes.h"
#include "newton/slopes/joint_slopes.h"
#include "newton/slopes/relation.h"
#include "recursion/backward.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/group.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "sweeps/bounded.h"

#include <math.h>
#include <string.h>

int mbsri_linear_check(const mbsr_model *m, const char *function, mbsr_error *error)
{
    char label[MBSRI_LABEL];
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const bool joint = mbsri_joint_slopes_serve(b, m->body[b->parent].np);
        if (joint && mbsri_body_slopes_serve(b)) continue;
        return mbsri_fail(error, MBSR_ERR_SPACE, b->id, MBSR_NONE,
                          "%s: %s: %s leaves its rates to differences, where V is not the rate of "
                          "a pose",
                          function, mbsri_body_label(m, i, label),
                          joint ? "its inertia" : "its joint");
    }
    for (size_t k = 0; k < m->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)m->closures.data + k;
        if (mbsri_closure_tangents_serve(m, c)) continue;
        return mbsri_fail(error, MBSR_ERR_SPACE, MBSR_NONE, MBSR_NONE,
                          "%s: %s (%s) reads joint coordinates that have rates other than u; use a "
                          "dense matrix",
                          function, mbsri_closure_label(m, (int)k, label), c->def.table->name);
    }
    return MBSR_OK;
}

/* ---- memory ---- */

/* How much the last joint takes of its own. */
static size_t own_terms(const mbsri_linear *l, int i)
{
    const mbsri_body *b = l->model->body + i;
    const size_t d = (size_t)b->d, dp = (size_t)b->pred.d, e = (size_t)l->e[i],
                 columns = (size_t)l->e[b->parent] + 2 * dp + (size_t)(b->nq + b->n);
    return 3 * (dp + (size_t)b->n) * columns + 3 * d * (e + 2 * d);
}

/* own, above: whether the body and its predecessor are below massless joints. */
static size_t place_terms(const mbsri_linear *l, int i, bool own, bool above, double *memory,
                          mbsri_terms *k)
{
    const mbsri_body *b = l->model->body + i;
    const size_t d = (size_t)b->d, dp = (size_t)b->pred.d, n = (size_t)b->n, nq = (size_t)b->nq,
                 x = (size_t)l->e[i] + (own ? 2 : 1) * d,
                 columns = (size_t)l->e[b->parent] + (above ? 2 : 1) * dp + nq + n,
                 y = (own ? 3 : 2) * d, y_pred = (above ? 3 : 2) * dp, rows = (own ? 3 : 2) * n,
                 all = (size_t)b->group.n;
    double **const kept[] = {&k->x,    &k->qdot, &k->H, &k->Hdot, &k->J,
                             &k->Jdot, &k->G,    &k->s, &k->X};
    const size_t length[] = {x * columns, nq * columns, d * dp, d * dp,   d * n,
                             d * n,       d * all,      all,    all * all};
    double **const first[] = {&k->below, &k->own, &k->P};
    const size_t length_of_first[] = {y_pred * columns, rows * columns, y * x};
    double *one = l->terms_of_one;
    size_t used = 0, unused = 0;
    for (int at = 0; at < 3; ++at)
        *first[at] = l->whole ? mbsri_take(&memory, &used, length_of_first[at])
                              : mbsri_take(&one, &unused, length_of_first[at]);
    for (size_t at = 0; at < sizeof length / sizeof length[0]; ++at)
        *kept[at] = mbsri_take(&memory, &used, length[at]);
    return used;
}

static void place_all_terms(mbsri_linear *l)
{
    for (int i = 1; i <= l->model->bodies; ++i) {
        if (l->served && !l->served[i]) continue;
        place_terms(l, i, l->below_massless[i], l->below_massless[l->model->body[i].parent],
                    l->store + l->terms[i], l->of + i);
    }
}

static bool on_every_body(const mbsri_force *force)
{
    return (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
}

static bool by_pairs(const mbsri_force *force)
{
    return (force->def.table->flags & MBSR_FORCE_BY_PAIRS) != 0;
}

int mbsri_linear_bodies(const mbsri_linear *l, const mbsri_force *force, int i, const int **list)
{
    const mbsr_model *m = l->model;
    if (by_pairs(force)) {
        *list = l->pairs.pair[i].body;
        return 2;
    }
    *list = on_every_body(force) ? m->order.member + m->body[i].group.at
                                 : m->stored.list_index + force->list;
    return on_every_body(force) ? 1 : force->def.bodies;
}

void mbsri_linear_calls(const mbsri_linear *l, size_t k, int *first, int *last)
{
    const mbsri_force *force = mbsri_force_at(l->model, k);
    *first = on_every_body(force) ? 1 : 0;
    *last = on_every_body(force) ? l->model->bodies : 0;
    if (!by_pairs(force)) return;
    while (*first < l->pairs.count && l->pairs.pair[*first].force < (int)k) ++*first;
    *last = *first - 1;
    while (*last + 1 < l->pairs.count && l->pairs.pair[*last + 1].force == (int)k) ++*last;
}

static void add_to_pattern(const mbsri_linear *l, int i, int *rows, int *columns)
{
    const mbsri_body *b = l->model->body + i;
    if (i == 0) return;
    *rows += b->d + b->n;
    *columns += l->e[i] + b->d + b->nq + b->n;
}

/* Rows and columns of the largest pair. */
static void pair_shape(const mbsri_linear *l, int *rows, int *columns)
{
    *rows = *columns = 0;
    for (int i = 1; i <= l->model->bodies; ++i) {
        int r = 0, c = 0;
        add_to_pattern(l, i, &r, &c);
        if (2 * r > *rows) *rows = 2 * r;
        if (2 * c > *columns) *columns = 2 * c;
    }
}

static void shape(const mbsri_linear *l, const mbsri_force *force, int i, int *rows, int *columns)
{
    *rows = *columns = 0;
    if (by_pairs(force)) {
        for (int k = 0; k < 2; ++k) add_to_pattern(l, l->pairs.pair[i].body[k], rows, columns);
    } else if (on_every_body(force)) {
        add_to_pattern(l, i, rows, columns);
    } else {
        mbsri_slopes_shape(l->model, force, rows, columns);
    }
}

/* Where the derivatives of a call are kept. */
static size_t body_place_of(const mbsri_linear *l, size_t k, int i)
{
    if (by_pairs(mbsri_force_at(l->model, k))) return l->of_pairs + (size_t)i * l->a_pair;
    return l->element[k] + (on_every_body(mbsri_force_at(l->model, k)) ? l->each[i] : 0);
}

const double *mbsri_linear_element(const mbsri_linear *l, size_t k, int i, int *rows, int *columns)
{
    shape(l, mbsri_force_at(l->model, k), i, rows, columns);
    return l->whole ? l->store + body_place_of(l, k, i) : l->slopes.out.matrix;
}

static size_t number_bodies(mbsri_linear *l)
{
    const mbsr_model *m = l->model;
    size_t used = 0, each = 0;
    l->motions = 0;
    for (int i = 0; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        l->e[i] = mbsri_pose_size(b);
        l->motion[i] = l->motions;
        l->motions += (size_t)(l->e[i] + 2 * b->d);
        l->each[i] = each;
        l->terms[i] = used;
        if (i == 0 || (l->served && !l->served[i])) continue;
        mbsri_terms k;
        each += (size_t)((b->d + b->n) * (l->e[i] + b->d + b->nq + b->n));
        used += place_terms(l, i, true, true, NULL, &k);
    }
    return used;
}

/* Offsets of all; the store's length. */
static size_t number_all(mbsri_linear *l, size_t *work)
{
    const mbsr_model *m = l->model;
    size_t used = number_bodies(l);
    for (size_t k = 0; k < m->forces.count; ++k) {
        int first, last;
        l->element[k] = used;
        if (by_pairs(mbsri_force_at(l->model, k))) continue;
        mbsri_linear_calls(l, k, &first, &last);
        for (int i = first; i <= last && l->whole; ++i) {
            int rows, columns;
            shape(l, mbsri_force_at(l->model, k), i, &rows, &columns);
            used += (size_t)rows * (size_t)columns;
        }
    }
    int rows, columns;
    pair_shape(l, &rows, &columns);
    l->of_pairs = used;
    l->a_pair = l->whole ? (size_t)rows * (size_t)columns : 0;
    used += (size_t)m->elements.pairs * l->a_pair;
    *work = 0;
    for (size_t k = 0; k < m->closures.count; ++k) {
        const mbsri_closure *c = mbsri_closure_at(l->model, k);
        const size_t most = mbsri_closure_tangents_work(c);
        l->closure[k] = used;
        used += (size_t)c->columns * (size_t)(c->columns + 2 * c->rows);
        if (most > *work) *work = most;
    }
    return used;
}

static size_t numbers_size(const mbsr_model *m)
{
    const size_t bodies = (size_t)m->bodies + 1;
    return bodies * sizeof(mbsri_terms) +
           (3 * bodies + m->forces.count + m->closures.count) * sizeof(size_t) +
           (size_t)m->elements.pairs * sizeof(mbsri_acting) + 2 * bodies * sizeof(int) +
           (2 * bodies + (size_t)m->rows) * sizeof(bool);
}

static void place_numbers(mbsri_linear *l, void *memory)
{
    const mbsr_model *m = l->model;
    const size_t bodies = (size_t)m->bodies + 1;
    l->of = memory;
    l->motion = (size_t *)(void *)(l->of + bodies);
    l->terms = l->motion + bodies;
    l->each = l->terms + bodies;
    l->element = l->each + bodies;
    l->closure = l->element + m->forces.count;
    l->pairs.pair = (mbsri_acting *)(void *)(l->closure + m->closures.count);
    l->rank = (int *)(void *)(l->pairs.pair + m->elements.pairs);
    l->e = l->rank + bodies;
    l->below_massless = (bool *)(void *)(l->e + bodies);
    l->coupled = l->below_massless + bodies;
    l->dropped = l->coupled + bodies;
}

static size_t place_doubles(mbsri_linear *l, size_t store, size_t work, double *memory)
{
    const mbsr_model *m = l->model;
    size_t used = 0, slopes, ints, one = 0;
    mbsri_slopes_size(m, MBSRI_SLOPES_BY_PAIRS, &slopes, &ints);
    for (int i = 1; i <= m->bodies && !l->whole; ++i) {
        const size_t terms = own_terms(l, i);
        if (terms > one) one = terms;
    }
    l->store = mbsri_take(&memory, &used, store);
    l->work = mbsri_take(&memory, &used, work);
    l->joint = mbsri_take(&memory, &used, mbsri_joint_slopes_size(m));
    l->body = mbsri_take(&memory, &used, mbsri_body_slopes_size(m));
    l->spare = mbsri_take(&memory, &used, (size_t)(m->nq + 3 * m->nu));
    l->along = mbsri_take(&memory, &used, 2 * (size_t)m->nu);
    l->terms_of_one = mbsri_take(&memory, &used, one);
    double *matrix = mbsri_take(&memory, &used, slopes);
    if (memory)
        mbsri_slopes_place(m, MBSRI_SLOPES_BY_PAIRS, &l->slopes, matrix, (int *)(void *)memory);
    return used * sizeof(double) + ints * sizeof(int);
}

mbsri_linear *mbsri_linear_create(const mbsr_model *m, bool whole, const bool *served)
{
    const size_t head = (sizeof(mbsri_linear) + 15) / 16 * 16,
                 numbers = (numbers_size(m) + 15) / 16 * 16;
    unsigned char *memory = mbsri_allocate(&m->allocator, head + numbers);
    if (!memory) return NULL;
    mbsri_linear *l = (void *)memory;
    *l = (mbsri_linear){.model = m, .whole = whole, .served = served};
    place_numbers(l, memory + head);
    size_t work;
    const size_t store = number_all(l, &work), doubles = place_doubles(l, store, work, NULL);
    double *block = mbsri_allocate(&m->allocator, doubles);
    if (!block) {
        mbsri_release(&m->allocator, l);
        return NULL;
    }
    place_doubles(l, store, work, block);
    memset(l->of, 0, ((size_t)m->bodies + 1) * sizeof *l->of);
    memset(l->below_massless, 0, ((size_t)m->bodies + 1) * sizeof *l->below_massless);
    place_all_terms(l);
    l->bytes = head + numbers + doubles;
    return l;
}

void mbsri_linear_destroy(mbsri_linear *l)
{
    if (!l) return;
    const mbsr_allocator allocator = l->model->allocator;
    mbsri_release(&allocator, l->store);
    mbsri_release(&allocator, l);
}

/* ---- linearising ---- */

/* The data at the state: stage of velocities; */
static int move(const mbsr_model *m, mbsr_data *d, double t, const double *y)
{
    const int status = mbsri_positions(m, d, t, y);
    return status ? status : mbsri_velocities(m, d, y + m->nq + m->nu);
}

/* then momenta, rates and forces. */
static int find_momenta(const mbsr_model *m, mbsr_data *d, const double *y, const double *yp,
                        double *spare)
{
    const double *u = y + m->nq + m->nu;
    int status = MBSR_OK;
    if (m->rows > 0) {
        mbsri_loops_take(m, d, u + m->nu, yp + m->nq + 2 * m->nu);
        status = mbsri_closure_jacobians(m, d);
    }
    const double *lambda = m->rows > 0 ? d->loop_lambda : NULL;
    return status ? status : mbsri_momentum_derivatives(m, d, lambda, spare, spare + m->nq);
}

static int find_ranks(const mbsr_model *m, mbsr_data *d)
{
    const int status = mbsri_backward(m, d);
    return status || !m->order.grouped ? status : mbsri_backward_apart(m, d);
}

int mbsri_linear_state(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                       const double *yp, double *spare)
{
    int status = move(m, d, t, y);
    if (!status) status = find_momenta(m, d, y, yp, spare);
    return status ? status : find_ranks(m, d);
}

/* A and mu at the accelerations that are known, which go into rates (nu), for joints that lack rank
 * and those behind. x, rate: as many numbers as a group's joints have rates. */
static void linear_react(const mbsr_model *m, mbsr_data *d, double *rates, double *x, double *rate)
{
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        mbsri_known_part(m, d, &g, x, rate);
        mbsri_group_scatter(m, &g, rate, rates);
    }
    mbsri_inverse(m, d, rates);
}

bool mbsri_linear_mark(mbsri_linear *l, const mbsr_data *d, const int *rank)
{
    const mbsr_model *m = l->model;
    bool some = false, other = false;
    l->below_massless[0] = l->coupled[0] = false;
    l->rank[0] = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        for (int k = 0; k < g.members; ++k) l->rank[g.member[k]] = 0;
        l->rank[i] = rank && g.members == 1 ? rank[i] : mbsri_group_rank(d, &g);
        for (int k = 0; k < g.members; ++k) {
            const int at = g.member[k];
            const bool below_massless =
                g.members > 1 || l->below_massless[m->body[i].parent] || l->rank[i] < g.n;
            l->coupled[at] = g.members > 1;
            other = other || below_massless != l->below_massless[at];
            l->below_massless[at] = below_massless;
            some = some || below_massless;
        }
    }
    if (other) place_all_terms(l);
    return some;
}

void mbsri_linear_mark_all(mbsri_linear *l)
{
    for (int i = 1; i <= l->model->bodies; ++i) l->below_massless[i] = true;
    place_all_terms(l);
}

/* The first rows of a column of one matrix, to a column of another that has these alone. */
static void copy_column(int from, int rows_from, const double *A, int to, int rows, double *B)
{
    mbsri_copy((size_t)rows, A + (size_t)from * (size_t)rows_from, B + (size_t)to * (size_t)rows);
}

/* s and X where D is regular, whose eigenvectors only the stages have: any basis will do, by D
 * itself where the data has it. */
static void take_whole_range(const mbsri_body *b, const mbsr_data *d, bool known,
                             const mbsri_terms *k)
{
    const size_t n = (size_t)b->n;
    mbsri_zero(n * n, k->X);
    for (size_t l = 0; l < n; ++l) {
        const double D = known ? d->D[b->nn + l * (n + 1)] : 0.0;
        k->s[l] = D > 0.0 ? 1.0 / sqrt(D) : 1.0;
        k->X[l * (n + 1)] = 1.0;
    }
}

/* G, s and X of a joint or group. */
static void take_basis(const mbsri_linear *l, const mbsr_data *d, int i, const mbsri_terms *k)
{
    const mbsri_body *b = l->model->body + i;
    const bool single = !l->coupled[i];
    const size_t n = single ? (size_t)b->n : (size_t)b->group.n;
    if (!single && b->group.head != i) return;
    mbsri_zero((size_t)b->d * n, k->G); /* of bodies that are free nothing is handed on by it */
    if (!l->bounds.free) mbsri_copy((size_t)b->d * n, d->G + b->dg, k->G);
    if ((l->served || l->bounds.told) && single && l->rank[i] == b->n) {
        take_whole_range(b, d, !l->bounds.free, k);
        return;
    }
    mbsri_copy(n, d->s + b->group.iu, k->s);
    mbsri_copy(n * n, d->X + b->nn, k->X);
}

/* x, below, own and qdot of a joint of any kind. */
static int differentiate(mbsri_linear *l, mbsr_data *d, int i, const mbsri_terms k)
{
    const mbsr_model *m = l->model;
    const mbsri_body *b = m->body + i;
    const int x = mbsri_linear_motions(l, i), x_pred = mbsri_linear_motions(l, b->parent),
              columns = x_pred + b->nq + b->n;
    mbsri_joint_slopes s;
    mbsri_joint_slopes_place(&s, l->joint);
    const int status = mbsri_joint_slopes_of(m, d, i, l->below_massless[i], d->udot + b->iu, &s);
    if (status) return status;
    for (int at = 0; at < columns; ++at) {
        const int from = at < x_pred ? at : s.q + at - x_pred;
        copy_column(from, s.e + 2 * b->d, s.x, at, x, k.x);
        copy_column(from, 3 * b->pred.d, s.below, at, mbsri_linear_actions(l, b->parent), k.below);
        copy_column(from, 3 * b->n, s.own, at, (l->below_massless[i] ? 3 : 2) * b->n, k.own);
        copy_column(from, b->nq, s.qdot, at, b->nq, k.qdot);
    }
    return MBSR_OK;
}

int mbsri_linear_joint(mbsri_linear *l, mbsr_data *d, int i)
{
    const mbsr_model *m = l->model;
    const mbsri_body *b = m->body + i;
    const mbsri_terms k = mbsri_linear_terms(l, i);
    const int x = mbsri_linear_motions(l, i);
    int status = MBSR_OK;
    if (!l->below_massless[i] && !l->below_massless[b->parent] && mbsri_axes_serve(b))
        mbsri_axes_slopes(b, d, k.x, k.below, k.own, k.qdot);
    else
        status = differentiate(l, d, i, k);
    if (status) return status;
    const size_t nd = (size_t)b->d, n = (size_t)b->n, dp = nd * (size_t)b->pred.d, dn = nd * n;
    mbsri_zero((size_t)(mbsri_linear_actions(l, i) * x), k.P);
    status = mbsri_body_slopes_add(m, d, i, l->below_massless[i], k.P, l->body);
    mbsri_copy(dp, d->H + b->dp, k.H);
    mbsri_copy(dp, d->Hdot + b->dp, k.Hdot);
    mbsri_copy(dn, d->J + b->dn, k.J);
    mbsri_copy(dn, d->Jdot + b->dn, k.Jdot);
    take_basis(l, d, i, &k);
    return status;
}

/* The derivatives of pair i, zeros along joints. */
static void copy_motions(const mbsri_linear *l, int i, const mbsr_force_derivatives *s, double *to)
{
    const size_t rows = (size_t)s->rows;
    mbsri_zero(rows * (size_t)s->columns, to);
    for (int side = 0; side < 2; ++side) {
        const int body = l->pairs.pair[i].body[side];
        const size_t at = body > 0 ? rows * (size_t)s->column[side] : 0,
                     x = body > 0 ? (size_t)(l->e[body] + l->model->body[body].d) : 0;
        mbsri_copy(x * rows, s->matrix + at, to + at);
    }
}

int mbsri_linear_force(mbsri_linear *l, mbsr_data *d, size_t k, int i)
{
    const mbsri_force *force = mbsri_force_at(l->model, k);
    const int status =
        by_pairs(force) ? mbsri_pair_slopes(l->model, d, force, l->pairs.pair[i].place, &l->slopes)
                        : mbsri_force_slopes(l->model, d, force, i, &l->slopes);
    if (status || !l->whole) return status;
    const mbsr_force_derivatives *s = &l->slopes.out;
    double *to = l->store + body_place_of(l, k, i);
    if (by_pairs(force)) {
        copy_motions(l, i, s, to);
    } else {
        mbsri_copy((size_t)s->rows * (size_t)s->columns, s->matrix, to);
    }
    return MBSR_OK;
}

static void find_along(mbsri_linear *l, const mbsr_data *d)
{
    const mbsr_model *m = l->model;
    const size_t nu = (size_t)m->nu;
    mbsri_zero(2 * nu, l->along);
    mbsri_coordinate_slopes(&m->elements.along, d->element.off + mbsri_other_forces(m), d->q, d->u,
                            l->along, l->along + nu);
    l->finite = mbsri_finite(2 * nu, l->along);
}

static int keep_element(mbsri_linear *l, mbsr_data *d, size_t k)
{
    int first, last, status = MBSR_OK;
    mbsri_linear_calls(l, k, &first, &last);
    for (int i = first; i <= last && !status; ++i) status = mbsri_linear_force(l, d, k, i);
    return status;
}

static int keep_closures(mbsri_linear *l, mbsr_data *d)
{
    for (size_t k = 0; k < l->model->closures.count; ++k) {
        const mbsri_closure *c = mbsri_closure_at(l->model, k);
        const size_t columns = (size_t)c->columns, rows = (size_t)c->rows;
        double *to = l->store + l->closure[k];
        mbsri_closure_tangents out = {.S = to, .slope = to + columns * columns};
        const int status = mbsri_closure_tangents_of(l->model, d, c, l->work, &out);
        if (status) return status;
        mbsri_copy(rows * columns, d->closure_C + c->at, out.slope + rows * columns);
        for (int r = c->row; r < c->row + c->rows; ++r) l->dropped[r] = d->dropped[r];
    }
    return MBSR_OK;
}

/* Which pairs act, element by element. */
static int find_pairs(mbsri_linear *l, mbsr_data *d)
{
    const mbsr_model *m = l->model;
    l->pairs.count = 0;
    for (size_t k = 0; k < m->forces.count && m->elements.pairs > 0; ++k) {
        const mbsri_force *force = mbsri_force_at(l->model, k);
        int count;
        if (!by_pairs(force)) continue;
        const int status = mbsri_force_pairs(m, d, force, &count);
        if (status) return status;
        for (int j = 0; j < count; ++j) {
            mbsri_acting *pair = l->pairs.pair + l->pairs.count++;
            *pair = (mbsri_acting){.force = (int)k};
            for (int side = 0; side < 2; ++side) {
                pair->place[side] = d->element.pairs[j][side];
                pair->body[side] = m->stored.list_index[force->list + (size_t)pair->place[side]];
            }
        }
    }
    return MBSR_OK;
}

int mbsri_linear_open(mbsri_linear *l, mbsr_data *d, double t, const double *y, const double *yp,
                      double c)
{
    const mbsr_model *m = l->model;
    l->c = c;
    int status = move(m, d, t, y);
    l->bounds.free =
        !status && l->bounds.load && l->bounds.forward && mbsri_bounded_free(m, d, l->bounds.load);
    if (!status && !l->bounds.free) status = find_momenta(m, d, y, yp, l->spare);
    l->bounds.told = l->bounds.free ||
                     (!status && l->bounds.load && mbsri_bounded_backward(m, d, l->bounds.load));
    if (l->bounds.told) /* the stage itself runs when somebody asks for it */
        mbsri_remember(m, d, MBSRI_PENDING_FORWARD, y, y + m->nq + m->nu, NULL);
    else if (!status)
        status = find_ranks(m, d);
    if (status) return status;
    find_along(l, d);
    double *rates = l->spare, *x = rates + m->nu;
    if (mbsri_linear_mark(l, d, NULL)) linear_react(m, d, rates, x, x + m->nu);
    return l->whole ? MBSR_OK : find_pairs(l, d); /* else with what is kept */
}

int mbsri_linear_keep(mbsri_linear *l, mbsr_data *d)
{
    const mbsr_model *m = l->model;
    int status = MBSR_OK;
    for (int i = 1; i <= m->bodies && !status; ++i) status = mbsri_linear_joint(l, d, i);
    if (!status) status = find_pairs(l, d);
    for (size_t k = 0; k < m->forces.count && !status; ++k) status = keep_element(l, d, k);
    if (!status) status = keep_closures(l, d);
    return status;
}

bool mbsri_linear_is_plain(const mbsr_model *m, size_t k)
{
    return k >= mbsri_other_forces(m) || mbsri_is_gravity(&mbsri_force_at(m, k)->def);
}

int mbsri_linear_elements(mbsri_linear *l, mbsr_data *d)
{
    const mbsr_model *m = l->model;
    int status = find_pairs(l, d);
    for (size_t k = 0; k < m->forces.count && !status; ++k) {
        if (!mbsri_linear_is_plain(m, k)) status = keep_element(l, d, k);
    }
    return status;
}

int mbsri_linear_at(mbsri_linear *l, mbsr_data *d, double t, const double *y, const double *yp,
                    double c)
{
    int status = mbsri_linear_open(l, d, t, y, yp, c);
    if (!status) status = mbsri_linear_keep(l, d);
    if (!status && l->model->order.grouped) status = mbsri_backward(l->model, d);
    return status;
}

/* y_pi += B y:  -H^T m,  -(H^T sigma + H'^T m),  -H^T mu */
void mbsri_linear_pass(const mbsri_body *b, const mbsri_terms *k, bool below_massless,
                       const double *y, double *below)
{
    const int d = b->d, dp = b->pred.d;
    mbsri_atx_often(d, dp, -1.0, k->H, y, below);
    mbsri_atx_often(d, dp, -1.0, k->H, y + d, below + dp);
    mbsri_atx_often(d, dp, -1.0, k->Hdot, y, below + dp);
    if (below_massless) mbsri_atx_often(d, dp, -1.0, k->H, y + 2 * d, below + 2 * dp);
}

void mbsri_linear_pass_transposed(const mbsri_body *b, const mbsri_terms *k, bool below_massless,
                                  const double *below, double *y)
{
    const int d = b->d, dp = b->pred.d;
    mbsri_ax(d, dp, -1.0, k->H, below, y);
    mbsri_ax(d, dp, -1.0, k->Hdot, below + dp, y);
    mbsri_ax(d, dp, -1.0, k->H, below + dp, y + d);
    if (below_massless) mbsri_ax(d, dp, -1.0, k->H, below + 2 * dp, y + 2 * d);
}

void mbsri_linear_split(const mbsri_terms *k, int n, int rank, double *x, double *y)
{
    for (int j = 0; j < n; ++j) y[j] = x[j], x[j] = 0.0;
    for (int l = rank; l < n; ++l) {
        const double *X = k->X + l * n;
        double weight = 0.0;
        for (int j = 0; j < n; ++j) weight += X[j] * k->s[j] * y[j];
        for (int j = 0; j < n; ++j) x[j] += X[j] * weight / k->s[j];
    }
    for (int j = 0; j < n; ++j) y[j] -= x[j];
}

void mbsri_linear_split_transposed(const mbsri_terms *k, int n, int rank, double *x, double *y)
{
    mbsri_zero((size_t)n, y);
    for (int l = rank; l < n; ++l) {
        const double *X = k->X + l * n;
        double weight = 0.0;
        for (int j = 0; j < n; ++j) weight += X[j] / k->s[j] * x[j];
        for (int j = 0; j < n; ++j) y[j] += X[j] * weight * k->s[j];
    }
    for (int j = 0; j < n; ++j) x[j] -= y[j];
}

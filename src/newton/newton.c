/* The Newton solver: creation and its entries.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "model/query.h"
#include "newton/blocks/carried.h"
#include "newton/blocks/factor.h"
#include "newton/blocks/kept.h"
#include "newton/blocks/linked.h"
#include "newton/correction.h"
#include "newton/linear/product.h"
#include "newton/slopes/body_slopes.h"
#include "newton/slopes/closure_slopes.h"
#include "newton/slopes/force_slopes.h"
#include "newton/slopes/joint_slopes.h"
#include "newton/slopes/relation.h"
#include "newton/sweeps/sweeps.h"
#include "newton/tree.h"
#include "recursion/group.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { LARGEST_RANK = 120 };

/* Multiplications a body past which loops are too many to be carried, and what one of the front counts beside one of
 * these. */
static const double too_many = 30000.0, slower = 3.0;

mbsr_newton_opt mbsr_default_newton_opt(void)
{
    return (mbsr_newton_opt){
        .cookie = MBSRI_COOKIE, .method = MBSR_NEWTON_AUTO, .max_rank = LARGEST_RANK};
}

/* ---- what is refused ---- */

static int wrong(mbsr_error *error, int status, const char *text, int value)
{
    return mbsri_fail(error, status, MBSR_NONE, MBSR_NONE, "mbsr_newton_create: %s is %d", text,
                      value);
}

static int check(const mbsr_model *m, mbsr_dae_form form, const mbsr_newton_opt *opt,
                 mbsr_error *error)
{
    if (opt->cookie != MBSRI_COOKIE) {
        return mbsri_fail(error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "mbsr_newton_create: opt was not made by mbsr_default_newton_opt");
    }
    if (!m->finished) {
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "mbsr_newton_create: the model is not finished");
    }
    if (form != MBSR_DAE_MOMENTUM)
        return wrong(error, MBSR_ERR_VALUE, "only MBSR_DAE_MOMENTUM is served; form", (int)form);
    if (opt->method < MBSR_NEWTON_AUTO || opt->method > MBSR_NEWTON_ELIMINATED)
        return wrong(error, MBSR_ERR_VALUE, "method", (int)opt->method);
    if (opt->max_rank < 0) return wrong(error, MBSR_ERR_VALUE, "max_rank", opt->max_rank);
    if (opt->lean && opt->products)
        return wrong(error, MBSR_ERR_VALUE, "a lean solver has no products; products",
                     opt->products);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        char label[MBSRI_LABEL];
        const bool joint = mbsri_joint_slopes_serve(b, m->body[b->parent].np);
        if (joint && mbsri_body_slopes_serve(b)) continue;
        return mbsri_fail(error, MBSR_ERR_SPACE, b->id, MBSR_NONE,
                          "mbsr_newton_create: %s: %s leaves its rates to differences, where V "
                          "is not the rate of a pose",
                          mbsri_body_label(m, i, label), joint ? "its inertia" : "its joint");
    }
    for (size_t k = 0; k < m->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)m->closures.data + k;
        char label[MBSRI_LABEL];
        if (mbsri_closure_tangents_serve(m, c)) continue;
        return mbsri_fail(
            error, MBSR_ERR_SPACE, MBSR_NONE, MBSR_NONE,
            "mbsr_newton_create: %s (%s) reads joint coordinates that have rates other "
            "than u; use a dense matrix",
            mbsri_closure_label(m, (int)k, label), c->def.table->name);
    }
    return MBSR_OK;
}

/* ---- memory ---- */

/* One pass that counts, and one that places. */
typedef struct layout {
    double *doubles;
    int *ints;
    size_t used, used_ints;
} layout;

/* A place, of no length too: parts of vectors are found by adding to it. */
static void doubles(layout *l, double **at, size_t count)
{
    *at = l->doubles ? l->doubles + l->used : NULL;
    l->used += count;
}

static void ints(layout *l, int **at, size_t count)
{
    *at = l->ints ? l->ints + l->used_ints : NULL;
    l->used_ints += count;
}

/* The lengths of the arrays that have numbers of each body: lean solvers have room for those that are
 * seen, which come first. */
static mbsri_lengths lengths_of(const mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    if (w->lean) return m->seen;
    return (mbsri_lengths){
        .v = m->size_v, .rates = m->size_rates, .coordinates = (size_t)m->nq, .bodies = 0};
}

/* Offsets of a body, which in a lean solver takes none unless it is seen; the matrices of bodies whose
 * elimination has begun share slots: one is taken when the last successor is met, which comes first,
 * and left when the body is done. */
static void number_bodies(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    size_t store = 0;
    w->size_x = w->size_n = w->slot_size = 0;
    for (int i = 0; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_node *node = w->node + i;
        const int most = b->group_nq > 2 * b->group_n ? b->group_nq : 2 * b->group_n;
        node->e = mbsri_pose_size(b);
        node->last = 0;
        node->x = w->size_x;
        node->v = w->size_n;
        if (i > 0) w->node[b->parent].last = i;
        if (w->lean && !b->seen) continue;
        w->size_x += (size_t)(node->e + 2 * b->d);
        w->size_n += (size_t)most;
        const size_t slot = (size_t)(node->e + 2 * b->d) * (size_t)(3 * b->d);
        if (slot > w->slot_size) w->slot_size = slot;
    }
    for (int i = 1; i <= m->bodies; ++i) {
        mbsri_kept kept;
        w->node[i].store = store;
        if (!w->lean || m->body[i].seen) store += mbsri_keep(w, i, NULL, &kept);
    }
    w->store_size = store;
}

/* free: N numbers of scratch. */
static void number_slots(mbsr_newton *w, int *unused)
{
    const mbsr_model *m = w->model;
    int count = 0;
    w->slots = 0;
    for (int i = m->bodies; i >= 1; --i) {
        const int parent = m->body[i].parent;
        if (w->node[i].last == 0) w->node[i].slot = count > 0 ? unused[--count] : w->slots++;
        if (parent > 0 && w->node[parent].last == i)
            w->node[parent].slot = count > 0 ? unused[--count] : w->slots++;
        /* those of a group are left together, with its head */
        if (m->body[i].head != i) continue;
        const mbsri_group g = mbsri_group_in_model(m, i);
        for (int k = 0; k < g.members; ++k) unused[count++] = w->node[g.member[k]].slot;
    }
}

static void lay_out_correction(mbsr_newton *w, layout *l)
{
    const mbsr_model *m = w->model;
    mbsri_correction *c = &w->correction;
    size_t left = 0, read = 0;
    c->most = 0;
    for (int k = 0; k < c->count; ++k) {
        mbsri_across *a = c->element + k;
        int columns;
        mbsri_slopes_shape(m, (const mbsri_force *)m->forces.data + a->force, &a->most, &columns);
        a->left = left;
        a->read = read;
        left += (size_t)a->most * (size_t)a->most;
        read += (size_t)a->most * (size_t)columns;
        c->most += a->most;
    }
    const size_t most = w->corrected ? (size_t)c->most : 0, any = w->corrected ? 1 : 0;
    doubles(l, &c->left, any * left);
    doubles(l, &c->read, any * read);
    doubles(l, &c->matrix, most * most);
    doubles(l, &c->weights, most);
    doubles(l, &c->rows, most);
    doubles(l, &c->columns, most);
    doubles(l, &c->load, any * (m->size_v + (size_t)m->nu));
    doubles(l, &c->delta, any * (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM));
    ints(l, &c->pivots, most);
}

/* Elements across are asked for by the elimination of each of their bodies, and for what couples these. */
static void lay_out_slopes(mbsr_newton *w, layout *l)
{
    const mbsr_model *m = w->model;
    const mbsri_force *force = m->forces.data;
    size_t doubles_of, ints_of;
    double *at;
    int *numbers;
    mbsri_slopes_size(m, &doubles_of, &ints_of);
    doubles(l, &at, doubles_of);
    ints(l, &numbers, ints_of);
    mbsri_kept_slopes *kept = &w->kept;
    kept->count = w->lean ? 0 : w->correction.count;
    kept->stride = 0;
    for (int k = 0; k < kept->count; ++k) {
        int rows, columns;
        mbsri_slopes_shape(m, force + w->correction.element[k].force, &rows, &columns);
        const size_t size = (size_t)rows * (size_t)columns;
        if (size > kept->stride) kept->stride = size;
    }
    doubles(l, &kept->store, (size_t)kept->count * kept->stride);
    ints(l, &kept->known, (size_t)kept->count);
    ints(l, &kept->number, kept->count > 0 ? m->forces.count : 0);
    if (!l->doubles) return;
    mbsri_slopes_place(m, &w->slopes, at, numbers);
    mbsri_slopes_forget(kept);
    if (kept->count == 0) return;
    for (size_t k = 0; k < m->forces.count; ++k) kept->number[k] = -1;
    for (int k = 0; k < kept->count; ++k) kept->number[w->correction.element[k].force] = k;
    w->slopes.kept = kept;
}

static void lay_out(mbsr_newton *w, layout *l)
{
    const mbsr_model *m = w->model;
    const size_t answers = w->corrected && w->sweep_size > 0 ? 1 : 0;
    doubles(l, &w->motion, answers * 12 * ((size_t)m->bodies + 1));
    if (answers == 0) w->motion = NULL;
    doubles(l, &w->solution, (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM));
    if (w->front) return;
    lay_out_slopes(w, l);
    lay_out_correction(w, l);
    const mbsri_lengths of = lengths_of(w);
    if (w->lean && of.bodies == 1) return; /* but the root */
    doubles(l, &w->store, w->store_size);
    doubles(l, &w->slot, (size_t)w->slots * w->slot_size);
    doubles(l, &w->x, w->size_x);
    doubles(l, &w->b, 3 * of.v);
    if (w->carried.memory)
        w->v = w->carried.value + w->carried.multipliers;
    else
        doubles(l, &w->v, w->size_n);
    doubles(l, &w->wbar, of.v);
    double **const vector[] = {&w->rq, &w->rp, &w->ru, &w->q0, &w->momentum, &w->range, &w->spare};
    const size_t length[] = {of.coordinates,           of.rates, of.rates,
                             of.coordinates,           of.rates, of.rates,
                             of.coordinates + of.rates};
    for (size_t k = 0; k < sizeof length / sizeof length[0]; ++k) doubles(l, vector[k], length[k]);
    doubles(l, &w->work, mbsri_tree_work(w));
    doubles(l, &w->joint, mbsri_joint_slopes_size(m));
    doubles(l, &w->body, mbsri_body_slopes_size(m));
    ints(l, &w->pivots, w->size_n);
}

/* Counts the elements of each body and, where `listed` tells, lists them in their order. Elements on single
 * bodies and on neighbours are listed with each body; elements across too, for what of them stays on the
 * tree. One that has a body twice is listed once. */
static void list_elements(mbsr_newton *w, bool listed)
{
    const mbsr_model *m = w->model;
    const mbsri_force *force = m->forces.data;
    for (int i = 1; i <= m->bodies; ++i) w->node[i].count = 0;
    for (size_t k = 0; k < m->forces.count; ++k) {
        const int *on = m->list_index + force[k].list;
        if (force[k].def.table->flags & MBSR_FORCE_EVERY_BODY) continue;
        for (int l = 0; l < force[k].def.bodies; ++l) {
            mbsri_node *node = w->node + on[l];
            bool again = on[l] == 0;
            for (int before = 0; before < l; ++before) again = again || on[before] == on[l];
            if (again) continue;
            if (listed) w->listed[node->first + node->count] = (int)k;
            ++node->count;
        }
    }
}

/* Numbers the elements: body after body, those on every body, across. */
static void list_all(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    const mbsri_force *force = m->forces.data;
    int used = 0;
    list_elements(w, false);
    for (int i = 1; i <= m->bodies; ++i) {
        w->node[i].first = used;
        used += w->node[i].count;
    }
    list_elements(w, true);
    w->first_every = used;
    for (size_t k = 0; k < m->forces.count; ++k) {
        if (force[k].def.table->flags & MBSR_FORCE_EVERY_BODY)
            w->listed[w->first_every + w->every++] = (int)k;
        if (!mbsri_may_cross(m, force + k)) continue;
        w->correction.element[w->correction.count++] = (mbsri_across){.force = (int)k};
    }
}

/* Room for `listed`, with the numbers of bodies' elements. */
static size_t count_listed(const mbsr_model *m)
{
    const mbsri_force *force = m->forces.data;
    size_t count = m->forces.count;
    for (size_t k = 0; k < m->forces.count; ++k) count += (size_t)force[k].def.bodies;
    return count;
}

/* Memory of the sweeps in vector code, aligned as they need it. */
static bool place_sweeps(mbsr_newton *w)
{
    if (w->sweep_size == 0) return true;
    w->sweep_block = mbsri_allocate(&w->model->allocator, w->sweep_size + MBSR_DATA_ALIGNMENT);
    if (!w->sweep_block) return false;
    const uintptr_t at = (uintptr_t)w->sweep_block, unit = MBSR_DATA_ALIGNMENT;
    w->sweeps =
        mbsri_newton_sweeps_place(w->model, w->lean, (void *)((at + unit - 1) / unit * unit), w);
    w->info.bytes += w->sweep_size + MBSR_DATA_ALIGNMENT;
    return true;
}

static bool place_products(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    w->linear = mbsri_linear_create(m);
    if (!w->linear) return false;
    const size_t size = mbsri_vectors_place(w->linear, NULL, &w->vectors) * sizeof(double);
    w->of_products = mbsri_allocate(&m->allocator, size);
    if (!w->of_products) return false;
    (void)mbsri_vectors_place(w->linear, w->of_products, &w->vectors);
    w->info.bytes += w->linear->bytes + size;
    return true;
}

/* Loops: carried along the tree, where few are open at once; else by the front, if that takes fewer operations. */
static bool place_loops(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    if (m->rows == 0 || w->lean) return true;
    if (!mbsri_carried_plan(w)) return false;
    const double carrying = mbsri_carried_operations(w);
    if (carrying < too_many * m->bodies) return mbsri_carried_create(w);
    const double operations = mbsri_front_operations(m);
    if (operations < 0.0) return false;
    if (carrying < too_many * m->bodies + slower * operations) return mbsri_carried_create(w);
    mbsri_carried_destroy(w);
    w->sweep_size = 0;
    w->front = mbsri_front_create(m);
    if (!w->front) return false;
    w->info.bytes += w->front->bytes;
    return true;
}

/* How elements across are taken in. */
static bool choose_method(mbsr_newton *w, const mbsr_newton_opt *opt)
{
    const mbsr_model *m = w->model;
    const mbsr_newton_method method = opt->method;
    const bool eliminated = method == MBSR_NEWTON_AUTO || method == MBSR_NEWTON_ELIMINATED;
    int most = 0, columns, rows;
    if (w->front) return true;
    for (int k = 0; k < w->correction.count; ++k) {
        const int force = w->correction.element[k].force;
        mbsri_slopes_shape(m, (const mbsri_force *)m->forces.data + force, &rows, &columns);
        most += rows;
    }
    if (eliminated && !mbsri_links_create(w, method == MBSR_NEWTON_ELIMINATED)) return false;
    w->corrected = w->correction.count > 0 && !w->linked && method != MBSR_NEWTON_TREE &&
                   (method != MBSR_NEWTON_AUTO || most <= opt->max_rank);
    return true;
}

static bool place(mbsr_newton *w, const mbsr_newton_opt *opt)
{
    const mbsr_model *m = w->model;
    const size_t bodies = (size_t)m->bodies + 1, listed = count_listed(m);
    const size_t nodes = bodies * sizeof *w->node,
                 across = (m->forces.count + 1) * sizeof *w->correction.element;
    w->numbers = mbsri_allocate(&m->allocator, nodes + across + (listed + bodies) * sizeof(int));
    if (!w->numbers) return false;
    w->node = w->numbers;
    w->correction.element = (mbsri_across *)(void *)((unsigned char *)w->numbers + nodes);
    w->listed = (int *)(void *)((unsigned char *)w->numbers + nodes + across);
    memset(w->numbers, 0, nodes + across);
    number_bodies(w);
    number_slots(w, w->listed); /* before it is filled */
    list_all(w);
    if (!place_loops(w) || !choose_method(w, opt)) return false;
    layout l = {0};
    lay_out(w, &l);
    w->block =
        mbsri_allocate(&m->allocator, l.used * sizeof(double) + l.used_ints * sizeof(int) + 8);
    if (!w->block) return false;
    w->info.bytes += sizeof *w + w->carried.bytes + w->links.bytes + nodes + across +
                     (listed + bodies) * sizeof(int) + l.used * sizeof(double) +
                     l.used_ints * sizeof(int);
    l = (layout){.doubles = w->block, .ints = (int *)(void *)((double *)w->block + l.used)};
    lay_out(w, &l);
    /* the sweeps leave it alone where there are no elements on bodies */
    if (w->motion) mbsri_zero(12 * bodies, w->motion);
    return place_sweeps(w) && (!opt->products || place_products(w));
}

static int no_memory(const mbsr_model *m, mbsr_error *error)
{
    return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "mbsr_newton_create: no memory for %d bodies and %d closures", m->bodies,
                      (int)m->closures.count);
}

int mbsr_newton_create(const mbsr_model *model, mbsr_dae_form form, const mbsr_newton_opt *opt,
                       mbsr_newton **newton, mbsr_error *error)
{
    const mbsr_newton_opt standard = mbsr_default_newton_opt();
    if (!opt) opt = &standard;
    if (newton) *newton = NULL;
    if (!model || !newton) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "mbsr_newton_create: %s is NULL", model ? "newton" : "model");
    }
    const int status = check(model, form, opt, error);
    if (status) return status;
    mbsr_newton *w = mbsri_allocate(&model->allocator, sizeof *w);
    if (w) {
        *w = (mbsr_newton){.model = model,
                           .lean = opt->lean != 0,
                           .sweep_size =
                               opt->by_blocks ? 0 : mbsri_newton_sweeps_size(model, opt->lean != 0),
                           .error = {MBSR_OK, MBSR_NONE, MBSR_NONE, ""}};
        if (!place(w, opt)) {
            mbsr_newton_destroy(w);
            w = NULL;
        }
    }
    if (!w) return no_memory(model, error);
    const bool across = w->correction.count > 0;
    w->info.method = w->linked || (w->front && across) ? MBSR_NEWTON_ELIMINATED
                     : w->corrected                    ? MBSR_NEWTON_CORRECTED
                                                       : MBSR_NEWTON_TREE;
    w->info.across = w->correction.count;
    w->info.blocks = w->sweeps ? w->sweeps->tree->blocks : model->bodies;
    w->info.exact = w->info.method != MBSR_NEWTON_TREE || w->correction.count == 0;
    *newton = w;
    return MBSR_OK;
}

void mbsr_newton_destroy(mbsr_newton *newton)
{
    if (!newton) return;
    const mbsr_allocator allocator = newton->model->allocator;
    mbsri_carried_destroy(newton);
    mbsri_links_destroy(newton);
    mbsri_front_destroy(newton->front);
    mbsri_linear_destroy(newton->linear);
    if (newton->of_products) mbsri_release(&allocator, newton->of_products);
    if (newton->block) mbsri_release(&allocator, newton->block);
    if (newton->numbers) mbsri_release(&allocator, newton->numbers);
    if (newton->sweep_block) mbsri_release(&allocator, newton->sweep_block);
    mbsri_release(&allocator, newton);
}

/* ---- factoring and solving ---- */

static int refuse(mbsr_newton *w, int status, const char *text)
{
    return mbsri_fail(&w->error, status, MBSR_NONE, MBSR_NONE, "%s", text);
}

static int factor(mbsr_newton *w, mbsr_data *d, double t, const double *y, const double *yp,
                  double c)
{
    mbsri_slopes_forget(&w->kept);
    if (w->front) return mbsri_front_factor(w->front, d, t, y, yp, c);
    const int status = mbsri_newton_tree_factor(w, d, t, y, yp, c);
    return status || !w->corrected ? status : mbsri_correction_factor(w, d);
}

int mbsr_newton_factor(mbsr_newton *newton, mbsr_data *data, double t, const double *y,
                       const double *yp, double c)
{
    mbsr_newton *w = newton;
    if (!w) return MBSR_ERR_NULL;
    w->factored = false;
    if (!data || !y || !yp)
        return refuse(w, MBSR_ERR_NULL, "mbsr_newton_factor: data, y or yp is NULL");
    if (!isfinite(c) || c == 0.0) {
        return mbsri_fail(&w->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_newton_factor: c is %g, must be finite and not zero", c);
    }
    const mbsr_model *m = w->model;
    int status = mbsri_enter(m, data, true, MBSRI_STAGE_NONE, "mbsr_newton_factor");
    if (!status) status = factor(w, data, t, y, yp, c);
    if (status) {
        const mbsr_error *error = mbsr_data_error(data);
        return mbsri_fail(&w->error, status, error->body, error->force, "%s", error->text);
    }
    w->factored = true;
    ++w->info.factorisations;
    return MBSR_OK;
}

int mbsr_newton_solve(mbsr_newton *newton, const double *r, double *delta)
{
    mbsr_newton *w = newton;
    if (!w) return MBSR_ERR_NULL;
    if (!r || !delta) return refuse(w, MBSR_ERR_NULL, "mbsr_newton_solve: r or delta is NULL");
    if (!w->factored)
        return refuse(w, MBSR_ERR_SEQUENCE, "mbsr_newton_solve: there is no factorisation");
    const size_t size = (size_t)mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
    if (!mbsri_finite(size, r))
        return refuse(w, MBSR_NOT_FINITE, "mbsr_newton_solve: r is not finite");
    if (size == 0) {
        ++w->info.solves; /* no coordinates, and no arrays of them */
        return MBSR_OK;
    }
    if (w->front)
        mbsri_front_solve(w->front, r, w->solution);
    else if (w->corrected)
        mbsri_correction_solve(w, r, w->solution);
    else
        mbsri_newton_tree_solve(w, r, NULL, w->solution);
    ++w->info.solves;
    if (!mbsri_finite(size, w->solution))
        return refuse(w, MBSR_NOT_FINITE, "mbsr_newton_solve: the solution is not finite");
    mbsri_copy(size, w->solution, delta);
    return MBSR_OK;
}

/* ---- products ---- */

int mbsr_newton_linearise(mbsr_newton *newton, mbsr_data *data, double t, const double *y,
                          const double *yp, double c)
{
    mbsr_newton *w = newton;
    if (!w) return MBSR_ERR_NULL;
    w->linearised = false;
    if (!data || !y || !yp)
        return refuse(w, MBSR_ERR_NULL, "mbsr_newton_linearise: data, y or yp is NULL");
    if (!w->linear) {
        return refuse(w, MBSR_ERR_SEQUENCE,
                      "mbsr_newton_linearise: the solver was created without `products`");
    }
    if (!isfinite(c)) {
        return mbsri_fail(&w->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_newton_linearise: c is %g, must be finite", c);
    }
    int status = mbsri_enter(w->model, data, true, MBSRI_STAGE_NONE, "mbsr_newton_linearise");
    if (!status) status = mbsri_linear_at(w->linear, data, t, y, yp, c);
    if (status) {
        const mbsr_error *error = mbsr_data_error(data);
        return mbsri_fail(&w->error, status, error->body, error->force, "%s", error->text);
    }
    w->linearised = true;
    return MBSR_OK;
}

int mbsr_newton_multiply(mbsr_newton *newton, const double *delta, double *r)
{
    mbsr_newton *w = newton;
    if (!w) return MBSR_ERR_NULL;
    if (!delta || !r) return refuse(w, MBSR_ERR_NULL, "mbsr_newton_multiply: delta or r is NULL");
    if (!w->linearised) {
        return refuse(w, MBSR_ERR_SEQUENCE,
                      "mbsr_newton_multiply: mbsr_newton_linearise has not run or has failed");
    }
    const size_t size = (size_t)mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
    if (!mbsri_finite(size, delta))
        return refuse(w, MBSR_NOT_FINITE, "mbsr_newton_multiply: delta is not finite");
    mbsri_product(w->linear, delta, &w->vectors, w->solution);
    if (!mbsri_finite(size, w->solution))
        return refuse(w, MBSR_NOT_FINITE, "mbsr_newton_multiply: the product is not finite");
    mbsri_copy(size, w->solution, r);
    return MBSR_OK;
}

int mbsr_newton_get_info(const mbsr_newton *newton, mbsr_newton_info *info)
{
    if (!newton || !info) return MBSR_ERR_NULL;
    *info = newton->info;
    return MBSR_OK;
}

const mbsr_error *mbsr_newton_error(const mbsr_newton *newton)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the solver is NULL"};
    return newton ? &newton->error : &none;
}

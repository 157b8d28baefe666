/* The Newton solver: creation and its entries.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "flexible/data.h"
#include "forms/loops.h"
#include "newton/carried/carried.h"
#include "newton/correction.h"
#include "newton/front/transposed.h"
#include "newton/linear/product_transposed.h"
#include "newton/slopes/relation.h"
#include "newton/solution.h"
#include "newton/sweeps/sweeps.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { LARGEST_RANK = 120 };

/* Multiplications a body past which loops are too many to be carried, and what one of the front
 * counts beside one of these. */
static const double too_many = 3000.0, slower = 3.0;

mbsr_newton_opt mbsr_default_newton_opt(void)
{
    return (mbsr_newton_opt){.cookie = MBSRI_COOKIE,
                             .method = MBSR_NEWTON_AUTO,
                             .max_rank = LARGEST_RANK,
                             .pairs_error = 1e-5};
}

/* ---- what is refused ---- */

static int wrong(mbsr_error *error, int status, const char *text, int value)
{
    return mbsri_fail(error, status, MBSR_NONE, MBSR_NONE, "mbsr_newton_create: %s is %d", text,
                      value);
}

static int check_options(const mbsr_model *m, mbsr_dae_form form, const mbsr_newton_opt *opt,
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
    if (opt->together < 0) return wrong(error, MBSR_ERR_VALUE, "together", opt->together);
    if (!(opt->pairs_error > 0.0 && opt->pairs_error < 1.0)) {
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_newton_create: pairs_error is %g, not between 0 and 1",
                          opt->pairs_error);
    }
    if (opt->lean && m->elements.pairs > 0)
        return wrong(error, MBSR_ERR_VALUE, "a lean solver does not serve elements by pairs; lean",
                     opt->lean);
    if (opt->lean && opt->products)
        return wrong(error, MBSR_ERR_VALUE, "a lean solver has no products; products",
                     opt->products);
    if (opt->lean && opt->transposes)
        return wrong(error, MBSR_ERR_VALUE, "a lean solver solves nothing transposed; transposes",
                     opt->transposes);
    return mbsri_linear_check(m, "mbsr_newton_create", error);
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
    l->used += count + MBSRI_FENCE / sizeof(double);
    if (*at) mbsri_fence(*at + count, MBSRI_FENCE, false);
}

static void ints(layout *l, int **at, size_t count)
{
    *at = l->ints ? l->ints + l->used_ints : NULL;
    l->used_ints += count;
}

static void lay_out_correction(mbsr_newton *w, layout *l)
{
    const mbsr_model *m = w->model;
    mbsri_correction *c = &w->correction;
    size_t left = 0, read = 0, most_rows = 0, most_columns = 0;
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
        if ((size_t)a->most > most_rows) most_rows = (size_t)a->most;
        if ((size_t)columns > most_columns) most_columns = (size_t)columns;
    }
    const size_t most = (size_t)c->most;
    doubles(l, &c->left, left);
    doubles(l, &c->read, read);
    doubles(l, &c->matrix, most * most);
    doubles(l, &c->weights, most);
    doubles(l, &c->rows, most);
    doubles(l, &c->columns, most);
    doubles(l, &c->span.row, most_rows);
    doubles(l, &c->span.column, most_columns);
    doubles(l, &c->delta, (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM));
    ints(l, &c->pivots, most);
}

static void lay_out_slopes(mbsr_newton *w, layout *l)
{
    const mbsr_model *m = w->model;
    size_t doubles_of, ints_of;
    double *at;
    int *numbers;
    mbsri_slopes_size(m, MBSRI_SLOPES_BY_PAIRS, &doubles_of, &ints_of);
    doubles(l, &at, doubles_of);
    ints(l, &numbers, ints_of);
    if (l->doubles) mbsri_slopes_place(m, MBSRI_SLOPES_BY_PAIRS, &w->slopes, at, numbers);
}

static void lay_out(mbsr_newton *w, layout *l)
{
    const mbsr_model *m = w->model;
    doubles(l, &w->solution, (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM));
    if (!w->lean || w->corrected) doubles(l, &w->load, m->size.v + (size_t)m->nu);
    if (!w->lean) doubles(l, &w->right, (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM));
    if (!w->corrected) return;
    doubles(l, &w->motion, 12 * ((size_t)m->bodies + 1));
    lay_out_slopes(w, l);
    lay_out_correction(w, l);
}

static void list_across(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    for (size_t k = 0; k < m->forces.count; ++k) {
        if (!mbsri_may_cross(m, (const mbsri_force *)m->forces.data + k)) continue;
        w->correction.element[w->correction.count++] = (mbsri_across){.force = (int)k};
    }
}

static void number_nodes(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    for (int i = 0; i <= m->bodies; ++i) {
        w->node[i] = (mbsri_node){.e = mbsri_pose_size(m->body + i), .v = w->size_n};
        w->size_n += 2 * (size_t)m->body[i].n;
    }
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

/* What is not in vector code. */
static bool place_front(mbsr_newton *w, const mbsr_newton_opt *opt)
{
    if (w->lean) return true;
    w->front = mbsri_front_create(w->model, NULL, opt->together, opt->pairs_error, w->transposes);
    if (w->front) w->info.bytes += w->front->bytes;
    return w->front != NULL;
}

/* Bodies of other kinds among those in vector code. */
static bool place_mixed(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    const mbsri_sweeps *tree = m->tree.newton;
    if (w->sweep_size == 0 || tree->blocks == 0) return true;
    bool *served = mbsri_allocate(&m->allocator, ((size_t)m->bodies + 1) * sizeof *served);
    if (!served) return false;
    for (int i = 0; i <= m->bodies; ++i)
        served[i] = i > 0 && i <= tree->bodies && tree->body[i].flags & MBSRI_BLOCK;
    w->mixed = mbsri_front_create(m, served, 0, 0.0, w->transposes);
    mbsri_release(&m->allocator, served);
    if (w->mixed) w->info.bytes += w->mixed->bytes;
    return w->mixed != NULL;
}

static bool place_products(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    w->linear = mbsri_linear_create(m, true, NULL);
    if (!w->linear) return false;
    const size_t vectors = mbsri_vectors_place(w->linear, NULL, &w->vectors),
                 size = (vectors + (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM)) * sizeof(double);
    w->of_products = mbsri_allocate(&m->allocator, size);
    if (!w->of_products) return false;
    (void)mbsri_vectors_place(w->linear, w->of_products, &w->vectors);
    w->other = (double *)w->of_products + vectors;
    w->info.bytes += w->linear->bytes + size;
    return true;
}

/* Multiplications of a correction, beside those of the front: a solution in vector code for each
 * unit of rank takes about 100 a body, and the derivatives of a body for the front as long as 5000.
 */
static bool correction_is_cheaper(const mbsr_newton *w, int rank)
{
    const double bodies = w->model->bodies, size = rank;
    return 100.0 * bodies * size + size * size * size < 5000.0 * bodies + w->front->plan.operations;
}

/* Whether the block of a flexible body has full rank whatever is behind: no mode lacks mass. */
static bool has_modal_mass(const mbsri_body *b)
{
    const mbsr_flex *flex = b->inertia.kind == MBSR_INERTIA_FLEXIBLE ? b->inertia.flex : NULL;
    return b->flexible.upright && flex && flex->root && flex->massive == flex->n;
}

/* Whether vector code leaves no more to a front than bodies and joints: elements across, and
 * flexible bodies with massless modes, whose null spaces the sweeps have by pivots, make it all the
 * front's. */
static bool may_be_mixed(const mbsr_newton *w, const mbsr_newton_opt *opt)
{
    const mbsr_model *m = w->model;
    bool served = w->correction.count == 0 || opt->method == MBSR_NEWTON_TREE;
    for (int i = 1; i <= m->bodies && served; ++i)
        served = !m->body[i].flexible.modal || has_modal_mass(m->body + i);
    return served;
}

/* How elements across are taken in, and so by what. */
static void choose_method(mbsr_newton *w, const mbsr_newton_opt *opt)
{
    const mbsr_model *m = w->model;
    const mbsr_newton_method method = opt->method;
    int most = 0, columns, rows;
    if (w->sweep_size > 0 && m->tree.newton->blocks > 0 && !may_be_mixed(w, opt)) w->sweep_size = 0;
    if (w->correction.count == 0 || w->sweep_size == 0 || method == MBSR_NEWTON_TREE) return;
    for (int k = 0; k < w->correction.count; ++k) {
        const int force = w->correction.element[k].force;
        mbsri_slopes_shape(m, (const mbsri_force *)m->forces.data + force, &rows, &columns);
        most += rows;
    }
    w->corrected = method == MBSR_NEWTON_AUTO
                       ? most <= opt->max_rank && (w->lean || correction_is_cheaper(w, most))
                       : method == MBSR_NEWTON_CORRECTED || w->lean;
    if (!w->corrected && !w->lean) w->sweep_size = 0;
}

/* Loops in vector code: carried along the tree, where few are open at once; else the front takes
 * fewer operations. */
static bool place_loops(mbsr_newton *w)
{
    const int bodies = w->model->bodies;
    if (w->model->rows == 0 || w->sweep_size == 0) return true;
    if (!mbsri_carried_plan(w)) return false;
    const double carrying = mbsri_carried_operations(w);
    if (carrying < too_many * bodies + slower * w->front->plan.operations)
        return mbsri_carried_create(w);
    mbsri_carried_destroy(w);
    w->sweep_size = 0;
    return true;
}

/* Whether the front alone solves transposed systems of the model. */
static bool needs_front(const mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    return w->correction.count > 0 || !m->tree.newton || m->tree.newton->blocks > 0;
}

static bool place_parts(mbsr_newton *w, const mbsr_newton_opt *opt)
{
    const mbsr_model *m = w->model;
    const size_t bodies = (size_t)m->bodies + 1, nodes = bodies * sizeof *w->node,
                 across = (m->forces.count + 1) * sizeof *w->correction.element;
    w->numbers = mbsri_allocate(&m->allocator, nodes + across);
    if (!w->numbers) return false;
    w->node = w->numbers;
    w->correction.element = (mbsri_across *)(void *)((unsigned char *)w->numbers + nodes);
    number_nodes(w);
    list_across(w);
    if (!opt->by_blocks && m->elements.pairs == 0 && !(opt->transposes && needs_front(w)))
        w->sweep_size = mbsri_newton_sweeps_size(m, w->lean);
    if (!place_front(w, opt) || !place_loops(w)) return false;
    choose_method(w, opt);
    if (!place_mixed(w)) return false;
    layout l = {0};
    lay_out(w, &l);
    w->block =
        mbsri_allocate(&m->allocator, l.used * sizeof(double) + l.used_ints * sizeof(int) + 8);
    if (!w->block) return false;
    w->info.bytes += sizeof *w + w->carried.bytes + nodes + across + l.used * sizeof(double) +
                     l.used_ints * sizeof(int);
    l = (layout){.doubles = w->block, .ints = (int *)(void *)((double *)w->block + l.used)};
    lay_out(w, &l);
    /* the sweeps leave it alone where there are no elements on bodies */
    if (w->corrected) mbsri_zero(12 * bodies, w->motion);
    return place_sweeps(w) && (!opt->products || place_products(w));
}

static int no_memory_for_newton(const mbsr_model *m, mbsr_error *error)
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
    const int status = check_options(model, form, opt, error);
    if (status) return status;
    mbsr_newton *w = mbsri_allocate(&model->allocator, sizeof *w);
    if (w) {
        *w = (mbsr_newton){.model = model,
                           .lean = opt->lean != 0,
                           .transposes = opt->transposes != 0,
                           .error = {MBSR_OK, MBSR_NONE, MBSR_NONE, ""}};
        if (!place_parts(w, opt)) {
            mbsr_newton_destroy(w);
            w = NULL;
        }
    }
    if (!w) return no_memory_for_newton(model, error);
    w->info.method = w->corrected                            ? MBSR_NEWTON_CORRECTED
                     : w->sweeps || w->correction.count == 0 ? MBSR_NEWTON_TREE
                                                             : MBSR_NEWTON_ELIMINATED;
    w->info.across = w->correction.count;
    w->info.blocks = w->sweeps ? w->sweeps->tree->blocks : model->bodies;
    w->info.exact = w->info.method != MBSR_NEWTON_TREE || w->info.across == 0;
    *newton = w;
    return MBSR_OK;
}

void mbsr_newton_destroy(mbsr_newton *newton)
{
    if (!newton) return;
    const mbsr_allocator allocator = newton->model->allocator;
    mbsri_carried_destroy(newton);
    mbsri_front_destroy(newton->front);
    mbsri_front_destroy(newton->mixed);
    mbsri_linear_destroy(newton->linear);
    if (newton->of_products) mbsri_release(&allocator, newton->of_products);
    if (newton->block) mbsri_release(&allocator, newton->block);
    if (newton->numbers) mbsri_release(&allocator, newton->numbers);
    if (newton->sweep_block) mbsri_release(&allocator, newton->sweep_block);
    mbsri_release(&allocator, newton);
}

/* ---- factoring and solving ---- */

static int refuse_call(mbsr_newton *w, int status, const char *text)
{
    return mbsri_fail(&w->error, status, MBSR_NONE, MBSR_NONE, "%s", text);
}

/* A status, or MBSRI_NOT_SERVED. */
static int factor_by_sweeps(mbsr_newton *w, mbsr_data *d, double t, const double *y,
                            const double *yp, double c)
{
    const mbsr_model *m = w->model;
    const double *u = y + m->nq + m->nu;
    if (!w->sweeps) return MBSRI_NOT_SERVED;
    if (m->rows > 0) mbsri_loops_take(m, d, u + m->nu, yp + m->nq + 2 * m->nu);
    const int status = mbsri_newton_sweeps_factor(w->sweeps, d, t, y, u, c);
    return status || !w->corrected ? status : mbsri_correction_factor(w, d);
}

/* By the sweeps in vector code where they serve, else by the front. */
static int factor_newton(mbsr_newton *w, mbsr_data *d, double t, const double *y, const double *yp,
                         double c)
{
    w->info.rank = 0;
    const int status = factor_by_sweeps(w, d, t, y, yp, c);
    w->by_sweeps = status != MBSRI_NOT_SERVED;
    const int blocks = w->by_sweeps ? w->sweeps->tree->blocks : w->model->bodies;
    w->info.vector_code = w->by_sweeps && (w->model->bodies == 0 || blocks < w->model->bodies);
    w->info.exact = !w->by_sweeps || w->corrected || w->info.across == 0;
    w->info.blocks = blocks;
    if (w->by_sweeps) return status;
    if (w->sweeps) w->sweeps->last.marked = false;
    if (!w->lean) {
        const int failed = mbsri_front_factor(w->front, d, t, y, yp, c);
        w->info.exact = !mbsri_front_iterates(w->front);
        return failed;
    }
    return mbsri_fail(&d->error, MBSR_ERR_LEAN, MBSR_NONE, MBSR_NONE,
                      "mbsr_newton_factor: the solver was created lean, and the sweeps in vector "
                      "code do not serve %s",
                      w->sweeps ? "this state" : "this model");
}

int mbsr_newton_factor(mbsr_newton *newton, mbsr_data *data, double t, const double *y,
                       const double *yp, double c)
{
    mbsr_newton *w = newton;
    if (!w) return MBSR_ERR_NULL;
    w->factored = false;
    if (!data || !y || !yp)
        return refuse_call(w, MBSR_ERR_NULL, "mbsr_newton_factor: data, y or yp is NULL");
    if (!isfinite(c) || c == 0.0) {
        return mbsri_fail(&w->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_newton_factor: c is %g, must be finite and not zero", c);
    }
    const mbsr_model *m = w->model;
    int status = mbsri_enter(m, data, true, MBSRI_STAGE_NONE, "mbsr_newton_factor");
    if (!status) status = factor_newton(w, data, t, y, yp, c);
    if (status) {
        const mbsr_error *error = mbsr_data_error(data);
        return mbsri_fail(&w->error, status, error->body, error->force, "%s", error->text);
    }
    w->factored = true;
    ++w->info.factorisations;
    return MBSR_OK;
}

/* tau on the right-hand side into w->load, which has changes of joint forces on the left. */
static void load_joints(mbsr_newton *w, const double *tau)
{
    const mbsr_model *m = w->model;
    mbsri_zero(m->size.v, w->load);
    for (int k = 0; k < m->nu; ++k) w->load[m->size.v + (size_t)k] = -tau[m->order.u_of[k]];
}

/* r + (dF/dtau) tau into w->right, with the derivatives that the front has. */
static const double *add_torque(mbsr_newton *w, const double *r, const double *tau)
{
    const int size = mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
    mbsri_product_of_torque(w->front->linear, tau, &w->front->vectors, w->solution);
    for (int k = 0; k < size; ++k) w->right[k] = r[k] + w->solution[k];
    return w->right;
}

bool mbsri_newton_solution(mbsr_newton *w, const double *r, const double *tau)
{
    bool done = true;
    if (tau && w->by_sweeps) load_joints(w, tau);
    if (!w->by_sweeps)
        done = mbsri_front_solve(w->front, tau ? add_torque(w, r, tau) : r, w->solution);
    else if (w->corrected)
        mbsri_correction_solve(w, r, tau != NULL, w->solution);
    else
        mbsri_newton_sweeps_solve(w->sweeps, r, tau ? w->load : NULL, w->solution, NULL);
    ++w->info.solves;
    return done;
}

void mbsri_newton_solution_transposed(mbsr_newton *w, const double *v, double *x, double *tau)
{
    if (w->by_sweeps) {
        mbsri_newton_sweeps_solve_transposed(w->sweeps, v, x, tau);
        for (int k = 0; k < w->model->nu && tau; ++k) tau[k] = -tau[k];
    } else {
        mbsri_front_solve_transposed(w->front, v, x);
        if (tau) mbsri_product_of_torque_transposed(w->front->linear, x, &w->front->vectors, tau);
    }
    ++w->info.solves;
}

int mbsr_newton_solve(mbsr_newton *newton, const double *r, double *delta)
{
    mbsr_newton *w = newton;
    if (!w) return MBSR_ERR_NULL;
    if (!r || !delta) return refuse_call(w, MBSR_ERR_NULL, "mbsr_newton_solve: r or delta is NULL");
    if (!w->factored)
        return refuse_call(w, MBSR_ERR_SEQUENCE, "mbsr_newton_solve: there is no factorisation");
    const size_t size = (size_t)mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
    if (!mbsri_finite(size, r))
        return refuse_call(w, MBSR_NOT_FINITE, "mbsr_newton_solve: r is not finite");
    if (size == 0) {
        ++w->info.solves; /* no coordinates, and no arrays of them */
        return MBSR_OK;
    }
    const bool done = mbsri_newton_solution(w, r, NULL);
    if (!mbsri_finite(size, w->solution))
        return refuse_call(w, MBSR_NOT_FINITE, "mbsr_newton_solve: the solution is not finite");
    if (!done) {
        return refuse_call(w, MBSR_NO_CONVERGENCE,
                           "mbsr_newton_solve: the forces between bodies that are not eliminated "
                           "together do not converge");
    }
    mbsri_copy(size, w->solution, delta);
    return MBSR_OK;
}

int mbsr_newton_solve_transposed(mbsr_newton *newton, const double *v, double *x)
{
    mbsr_newton *w = newton;
    if (!w) return MBSR_ERR_NULL;
    if (!v || !x)
        return refuse_call(w, MBSR_ERR_NULL, "mbsr_newton_solve_transposed: v or x is NULL");
    if (!w->transposes) {
        return refuse_call(
            w, MBSR_ERR_SEQUENCE,
            "mbsr_newton_solve_transposed: the solver was created without `transposes`");
    }
    if (!w->factored) {
        return refuse_call(w, MBSR_ERR_SEQUENCE,
                           "mbsr_newton_solve_transposed: there is no factorisation");
    }
    const size_t size = (size_t)mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
    if (!mbsri_finite(size, v))
        return refuse_call(w, MBSR_NOT_FINITE, "mbsr_newton_solve_transposed: v is not finite");
    if (size == 0) {
        ++w->info.solves;
        return MBSR_OK;
    }
    mbsri_newton_solution_transposed(w, v, w->solution, NULL);
    if (!mbsri_finite(size, w->solution)) {
        return refuse_call(w, MBSR_NOT_FINITE,
                           "mbsr_newton_solve_transposed: the solution is not finite");
    }
    mbsri_copy(size, w->solution, x);
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
        return refuse_call(w, MBSR_ERR_NULL, "mbsr_newton_linearise: data, y or yp is NULL");
    if (!w->linear) {
        return refuse_call(w, MBSR_ERR_SEQUENCE,
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
    if (!delta || !r)
        return refuse_call(w, MBSR_ERR_NULL, "mbsr_newton_multiply: delta or r is NULL");
    if (!w->linearised) {
        return refuse_call(w, MBSR_ERR_SEQUENCE,
                           "mbsr_newton_multiply: mbsr_newton_linearise has not run or has failed");
    }
    const size_t size = (size_t)mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
    if (!mbsri_finite(size, delta))
        return refuse_call(w, MBSR_NOT_FINITE, "mbsr_newton_multiply: delta is not finite");
    mbsri_product(w->linear, delta, &w->vectors, w->solution);
    if (!mbsri_finite(size, w->solution))
        return refuse_call(w, MBSR_NOT_FINITE, "mbsr_newton_multiply: the product is not finite");
    mbsri_copy(size, w->solution, r);
    return MBSR_OK;
}

int mbsr_newton_multiply_torque(mbsr_newton *newton, const double *tau, double *r)
{
    mbsr_newton *w = newton;
    if (!w) return MBSR_ERR_NULL;
    if (!tau || !r)
        return refuse_call(w, MBSR_ERR_NULL, "mbsr_newton_multiply_torque: tau or r is NULL");
    if (!w->linearised) {
        return refuse_call(
            w, MBSR_ERR_SEQUENCE,
            "mbsr_newton_multiply_torque: mbsr_newton_linearise has not run or has failed");
    }
    if (!mbsri_finite((size_t)w->model->nu, tau))
        return refuse_call(w, MBSR_NOT_FINITE, "mbsr_newton_multiply_torque: tau is not finite");
    const size_t size = (size_t)mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
    mbsri_product_of_torque(w->linear, tau, &w->vectors, w->solution);
    if (!mbsri_finite(size, w->solution))
        return refuse_call(w, MBSR_NOT_FINITE,
                           "mbsr_newton_multiply_torque: the product is not finite");
    mbsri_copy(size, w->solution, r);
    return MBSR_OK;
}

int mbsr_newton_multiply_transposed(mbsr_newton *newton, const double *x, double *v)
{
    mbsr_newton *w = newton;
    if (!w) return MBSR_ERR_NULL;
    if (!x || !v)
        return refuse_call(w, MBSR_ERR_NULL, "mbsr_newton_multiply_transposed: x or v is NULL");
    if (!w->linearised) {
        return refuse_call(
            w, MBSR_ERR_SEQUENCE,
            "mbsr_newton_multiply_transposed: mbsr_newton_linearise has not run or has "
            "failed");
    }
    const size_t size = (size_t)mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
    if (!mbsri_finite(size, x))
        return refuse_call(w, MBSR_NOT_FINITE, "mbsr_newton_multiply_transposed: x is not finite");
    mbsri_product_transposed(w->linear, x, &w->vectors, w->solution);
    if (!mbsri_finite(size, w->solution)) {
        return refuse_call(w, MBSR_NOT_FINITE,
                           "mbsr_newton_multiply_transposed: the product is not finite");
    }
    mbsri_copy(size, w->solution, v);
    return MBSR_OK;
}

int mbsr_newton_get_info(const mbsr_newton *newton, mbsr_newton_info *info)
{
    if (!newton || !info) return MBSR_ERR_NULL;
    *info = newton->info;
    if (newton->front) info->iterations = mbsri_front_iterations(newton->front);
    return MBSR_OK;
}

const mbsr_error *mbsr_newton_error(const mbsr_newton *newton)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the solver is NULL"};
    return newton ? &newton->error : &none;
}

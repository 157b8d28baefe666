/* Derivatives of inverse and forward dynamics: entries.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "derivatives/record.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "derivatives/rigid_elements.h"
#include "derivatives/rigid_seeds.h"
#include "forms/momentum.h"
#include "model/query.h"
#include "newton/slopes/relation.h"
#include "recursion/backward.h"
#include "recursion/closure_differences.h"
#include "recursion/closures.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "recursion/refine.h"

static const char inverse_name[] = "mbsr_derivatives_inverse",
                  forward_name[] = "mbsr_derivatives_forward";

/* ---- memory ---- */

/* The longest that a joint, element or closure reads or gives. */
static size_t widest(const mbsri_linear *l)
{
    const mbsr_model *m = l->model;
    size_t most = 3 * (size_t)m->most.columns;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const size_t count = (size_t)(l->e[b->parent] + 2 * b->pred.d + b->nq + b->n + l->e[i] +
                                      2 * b->d + b->nq + b->n);
        if (count > most) most = count;
    }
    for (size_t k = 0; k < m->forces.count; ++k) {
        int rows, columns;
        mbsri_slopes_shape(m, (const mbsri_force *)m->forces.data + k, &rows, &columns);
        if ((size_t)(rows + columns) > most) most = (size_t)(rows + columns);
    }
    return most;
}

static bool place_arrays(mbsr_derivatives *w)
{
    const mbsr_model *m = w->model;
    const size_t nu = (size_t)m->nu, nq = (size_t)m->nq, rows = (size_t)m->rows,
                 most = widest(w->linear), columns = (size_t)m->most.columns;
    struct {
        double **at;
        size_t count;
    } const part[] = {{&w->motion, w->linear->motions},
                      {&w->mu, m->size.v},
                      {&w->dq, nq},
                      {&w->torque, nu},
                      {&w->load, 3 * nu},
                      {&w->in, most},
                      {&w->out, most},
                      {&w->right, nu},
                      {&w->solution, nu},
                      {&w->column, nu},
                      {&w->rows, rows},
                      {&w->lambda, rows},
                      {&w->weight, 2 * rows},
                      {&w->acceleration, 2 * m->size_c},
                      {&w->work, columns * (size_t)(4 + MBSR_CLOSURE_ROWS) + nq + nu}};
    size_t count = 1;
    for (size_t k = 0; k < sizeof part / sizeof part[0]; ++k) count += part[k].count;
    w->memory = mbsri_allocate(&m->allocator, count * sizeof(double));
    if (!w->memory) return false;
    mbsri_zero(count, w->memory);
    double *next = w->memory;
    for (size_t k = 0; k < sizeof part / sizeof part[0]; ++k) {
        *part[k].at = next;
        next += part[k].count;
    }
    return true;
}

/* Room for products of the residual; whether there is memory. */
static bool place_residual(mbsr_derivatives *w)
{
    mbsri_residual *z = &w->residual;
    const mbsr_model *m = w->model;
    const size_t size = (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM), nu = (size_t)m->nu,
                 rows = (size_t)m->rows, all = rows + (size_t)m->position_rows,
                 vectors = mbsri_vectors_place(w->linear, NULL, &z->vectors),
                 count = vectors + 3 * size + 3 * nu + rows + all;
    z->memory = mbsri_allocate(&m->allocator, (count + 1) * sizeof(double));
    if (!z->memory) return false;
    mbsri_zero(count, z->memory);
    mbsri_vectors_place(w->linear, z->memory, &z->vectors);
    double **const place[] = {&z->given,          &z->result,       &z->other,
                              &z->sources.pulse,  &z->sources.load, &z->sources.drift,
                              &z->sources.lambda, &z->sources.rows};
    const size_t length[] = {size, size, size, nu, nu, nu, rows, all};
    double *next = z->memory + vectors;
    for (size_t k = 0; k < sizeof place / sizeof *place; ++k) {
        *place[k] = next;
        next += length[k];
    }
    return true;
}

int mbsr_derivatives_create(const mbsr_model *model, mbsr_derivatives **derivatives,
                            mbsr_error *error)
{
    static const char name[] = "mbsr_derivatives_create";
    if (derivatives) *derivatives = NULL;
    if (!model || !derivatives)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", name,
                          model ? "derivatives" : "model");
    if (!model->finished)
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", name);
    const int status = mbsri_linear_check(model, name, error);
    if (status) return status;
    mbsr_derivatives *w = mbsri_allocate(&model->allocator, sizeof *w);
    if (w) {
        *w = (mbsr_derivatives){.model = model, .error = {MBSR_OK, MBSR_NONE, MBSR_NONE, ""}};
        w->linear = mbsri_linear_create(model, true, NULL);
        if (mbsri_rigid_serves(model)) w->rigid = mbsri_rigid_create(model);
    }
    if (!w || !w->linear || !place_residual(w) || (mbsri_rigid_serves(model) && !w->rigid) ||
        !place_arrays(w) || mbsr_data_create(model, &w->data, NULL)) {
        mbsr_derivatives_destroy(w);
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d bodies", name, model->bodies);
    }
    *derivatives = w;
    return MBSR_OK;
}

void mbsri_derivatives_forget(mbsr_derivatives *w)
{
    if (w->factored) mbsri_fronts_close(&w->fronts);
    w->factored = w->redundant = false;
    w->at = MBSRI_LINEARISED_NOT;
    w->by_sweeps = false;
}

void mbsri_derivatives_unchoose(mbsr_derivatives *w)
{
    if (w->rigid) mbsri_rigid_seeds_destroy(w->rigid->seeds, w->model);
    if (w->rigid) w->rigid->seeds = NULL;
    mbsri_seeds_destroy(&w->seeds, w->model);
    mbsri_seeds_destroy(&w->rigid_seed, w->model);
    mbsri_seeds_destroy(&w->residual.seeds, w->model);
}

void mbsr_derivatives_destroy(mbsr_derivatives *derivatives)
{
    mbsr_derivatives *w = derivatives;
    if (!w) return;
    const mbsr_allocator allocator = w->model->allocator;
    mbsri_derivatives_forget(w);
    mbsri_linear_destroy(w->linear);
    mbsri_derivatives_unchoose(w);
    mbsri_rigid_destroy(w->rigid);
    mbsr_data_destroy(w->data);
    if (w->memory) mbsri_release(&allocator, w->memory);
    if (w->residual.memory) mbsri_release(&allocator, w->residual.memory);
    mbsri_release(&allocator, w);
}

mbsr_data *mbsr_derivatives_data(mbsr_derivatives *derivatives)
{
    return derivatives ? derivatives->data : NULL;
}

const mbsr_error *mbsr_derivatives_error(const mbsr_derivatives *derivatives)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                                    "the derivatives are NULL"};
    return derivatives ? &derivatives->error : &none;
}

/* ---- linearising ---- */

/* Second derivatives of the rows, along places and rates of the bodies of each closure. */
static int find_acceleration_slopes(mbsr_derivatives *w)
{
    const mbsr_model *m = w->model;
    mbsr_data *d = w->data;
    double *a = w->in;
    int status = MBSR_OK;
    for (size_t k = 0; k < m->closures.count && !status; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)m->closures.data + k;
        mbsri_zero((size_t)c->columns, a);
        for (int l = 0; l < c->bodies; ++l) {
            const mbsri_body *b = m->body + c->body[l];
            if (c->column[l] < 0) continue;
            mbsri_copy((size_t)b->d, d->A + b->v, a + c->column[l]);
            if (mbsri_reads_joints(c) && c->body[l] > 0)
                mbsri_copy((size_t)b->n, d->udot + b->iu, a + c->column[l] + b->d);
        }
        double *out = w->acceleration + 2 * c->at;
        status = mbsri_closure_acceleration_tangent(m, d, c, a, w->work, out,
                                                    out + c->rows * c->columns);
        if (status) status = mbsri_closure_failed(m, d, c, status, "a function");
    }
    return status;
}

/* The linearised inverse dynamics at the state, with the loop forces `lambda` where there are
 * closures; NULL: without what changes their accelerations, which nobody asks for. */
static int linearise_inverse(mbsr_derivatives *w, double t, const double *q, const double *u,
                             const double *udot, const double *lambda)
{
    const mbsr_model *m = w->model;
    mbsr_data *d = w->data;
    double *qdot = w->work, *pdot = qdot + m->nq;
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status && m->rows > 0 && lambda) status = mbsri_closure_jacobians(m, d);
    if (!status) status = mbsri_momentum_derivatives(m, d, lambda, qdot, pdot);
    if (!status) status = mbsri_backward(m, d);
    if (!status && m->order.grouped) status = mbsri_backward_apart(m, d);
    if (status) return status;
    (void)mbsri_linear_mark(w->linear, d, NULL);
    mbsri_linear_mark_all(w->linear);
    mbsri_inverse(m, d, udot);
    status = mbsri_linear_keep(w->linear, d);
    if (!status && lambda) status = find_acceleration_slopes(w);
    if (!status) status = mbsri_seeds_find(&w->seeds, w->linear, d);
    if (!status && m->order.grouped) status = mbsri_backward(m, d);
    return status;
}

/* At accelerations that the data has found, or has found torques for. */
static int linearise(mbsr_derivatives *w, double t, const double *q, const double *u,
                     const double *udot, bool forward)
{
    const mbsri_pending kept = forward ? MBSRI_PENDING_FORWARD : MBSRI_PENDING_INVERSE;
    if (w->rigid && w->data->pending == kept && w->rigid_seed.count == w->seeds.count) {
        w->by_sweeps = true;
        int status = mbsri_rigid_linearise(w->rigid, w->data, q, u, udot, forward);
        if (!status && w->rigid->elements) status = mbsri_rigid_elements_keep(w);
        if (!status && w->rigid_seed.count > 0) status = mbsri_rigid_seeds_find(w, t, q, u, udot);
        return status;
    }
    if (forward) mbsri_copy((size_t)w->model->rows, w->data->loop_lambda, w->lambda);
    return linearise_inverse(w, t, q, u, udot, forward ? w->lambda : NULL);
}

int mbsri_derivatives_take_error(mbsr_derivatives *w, int status)
{
    const mbsr_error *error = mbsr_data_error(w->data);
    return mbsri_fail(&w->error, status, error->body, error->force, "%s", error->text);
}

int mbsri_derivatives_refuse(mbsr_derivatives *w, int status, const char *function,
                             const char *text)
{
    return mbsri_fail(&w->error, status, MBSR_NONE, MBSR_NONE, "%s: %s", function, text);
}

int mbsr_derivatives_inverse(mbsr_derivatives *derivatives, double t, const double *q,
                             const double *u, const double *udot, double *tau)
{
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    mbsri_derivatives_forget(w);
    if (!q || !u || !udot)
        return mbsri_derivatives_refuse(w, MBSR_ERR_NULL, inverse_name,
                                        "a required pointer is NULL");
    int status = mbsr_inverse_dynamics(w->model, w->data, t, q, u, udot, NULL, w->solution);
    if (!status) status = linearise(w, t, q, u, udot, false);
    if (status) return mbsri_derivatives_take_error(w, status);
    if (tau) mbsri_copy((size_t)w->model->nu, w->solution, tau);
    w->at = MBSRI_LINEARISED_INVERSE;
    return MBSR_OK;
}

/* Factors of the equations with loops. */
static int factor_loops(mbsr_derivatives *w)
{
    mbsri_fronts *s = &w->fronts;
    int status = mbsri_fronts_open(s, w->model, w->data, true, forward_name);
    w->factored = true;
    if (!status) status = mbsri_fronts_factor(s, NULL, forward_name);
    for (int k = 0; k < s->plan->steps && !status; ++k)
        w->redundant = w->redundant || (s->pivots[k] && s->pivots[k]->left > 0);
    return status;
}

int mbsr_derivatives_forward(mbsr_derivatives *derivatives, double t, const double *q,
                             const double *u, const double *tau, double *udot, double *lambda)
{
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    mbsri_derivatives_forget(w);
    if (!q || !u)
        return mbsri_derivatives_refuse(w, MBSR_ERR_NULL, forward_name,
                                        "a required pointer is NULL");
    const mbsr_model *m = w->model;
    int status = mbsr_forward_dynamics(m, w->data, t, q, u, tau, w->solution);
    if (!status) status = linearise(w, t, q, u, w->solution, true);
    if (!status && m->rows > 0) status = factor_loops(w);
    if (status) {
        mbsri_derivatives_forget(w);
        return mbsri_derivatives_take_error(w, status);
    }
    if (lambda) mbsri_copy((size_t)m->rows, w->lambda, lambda);
    if (udot) mbsri_copy((size_t)m->nu, w->solution, udot);
    w->at = MBSRI_LINEARISED_FORWARD;
    return MBSR_OK;
}

/* ---- products ---- */

/* x (nu) and forces (rows) from M x - C^T forces = right, C x = b; on a tree M x = right. */
static void solve_mass(mbsr_derivatives *w, const double *right, const double *b, double *x,
                       double *forces)
{
    const mbsr_model *m = w->model;
    if (m->rows > 0) {
        mbsri_fronts_solve(&w->fronts, right, b, x, forces);
        return;
    }
    mbsri_gather(m, right, w->data->out);
    for (int k = 0; k < m->nu; ++k) w->data->out[k] = -w->data->out[k];
    mbsri_refine_solve(m, w->data, x);
}

void mbsri_derivatives_turn(const mbsr_derivatives *w, bool back, const double *from, double *to)
{
    const mbsri_linear *l = w->linear;
    mbsri_zero((size_t)(back ? w->model->nu : w->model->nq), to);
    for (int i = 1; i <= w->model->bodies; ++i) {
        const mbsri_body *b = w->model->body + i;
        const mbsri_terms k = mbsri_linear_terms(l, i);
        const double *G =
            k.qdot + (size_t)(mbsri_linear_motions(l, b->parent) + b->nq) * (size_t)b->nq;
        if (back)
            mbsri_atx(b->nq, b->n, 1.0, G, from + b->q, to + b->u);
        else
            mbsri_ax(b->nq, b->n, 1.0, G, from + b->u, to + b->q);
    }
}

static int check_product(mbsr_derivatives *w, const char *name, bool arguments,
                         const double *lambda)
{
    if (!arguments) return mbsri_derivatives_refuse(w, MBSR_ERR_NULL, name, "out is NULL");
    if (w->at != MBSRI_LINEARISED_INVERSE && w->at != MBSRI_LINEARISED_FORWARD)
        return mbsri_derivatives_refuse(
            w, MBSR_ERR_SEQUENCE, name,
            "call mbsr_derivatives_inverse or mbsr_derivatives_forward first");
    if (lambda && w->at == MBSRI_LINEARISED_INVERSE)
        return mbsri_derivatives_refuse(
            w, MBSR_ERR_VALUE, name,
            "inverse dynamics has no loop forces; those of forward dynamics are "
            "linearised by mbsr_derivatives_forward");
    if (lambda && w->redundant)
        return mbsri_derivatives_refuse(
            w, MBSR_LOOP_SINGULAR, name,
            "rows of closures depend on others, so that forces do not determine lambda");
    return MBSR_OK;
}

bool mbsri_finite_or_null(size_t n, const double *x)
{
    return !x || mbsri_finite(n, x);
}

/* A copy, or zeros. */
static void copy_or_zero(size_t n, const double *from, double *to)
{
    if (from)
        mbsri_copy(n, from, to);
    else
        mbsri_zero(n, to);
}

/* Those of a tree without loops. */
static int tangent_by_sweeps(mbsr_derivatives *w, const char *name, const double *dq,
                             const double *du, const double *dload, double *out)
{
    const size_t nu = (size_t)w->model->nu;
    const int *place = w->model->order.u_of;
    const bool forward = w->at == MBSRI_LINEARISED_FORWARD;
    const mbsri_rigid_kernels *kernels = w->rigid->kernels;
    double *zero = w->load, *given = zero + nu;
    mbsri_zero(nu, zero);
    copy_or_zero(nu, dload, given);
    dq = dq ? dq : zero;
    du = du ? du : zero;
    const bool seeded = w->rigid_seed.active;
    const size_t more = w->rigid->elements || seeded ? nu : 0;
    mbsri_zero(more, w->torque);
    if (seeded) mbsri_rigid_seeds_along(w);
    if (w->rigid->elements) mbsri_rigid_elements_along(w, dq, du);
    for (size_t k = 0; k < more && forward; ++k) given[place[k]] += w->torque[k];
    (forward ? kernels->forward_tangent : kernels->tangent)(w->rigid, dq, du, given, w->solution);
    for (size_t k = 0; k < more && !forward; ++k) w->solution[place[k]] -= w->torque[k];
    if (!mbsri_finite(nu, w->solution))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "it overflows");
    mbsri_copy(nu, w->solution, out);
    return MBSR_OK;
}

int mbsr_derivatives_tangent(mbsr_derivatives *derivatives, const double *dq, const double *du,
                             const double *dload, double *out, double *dlambda)
{
    static const char name[] = "mbsr_derivatives_tangent";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    const int status = check_product(w, name, out != NULL, dlambda);
    if (status) return status;
    const mbsr_model *m = w->model;
    const size_t nu = (size_t)m->nu, rows = (size_t)m->rows;
    if (!mbsri_finite_or_null(nu, dq) || !mbsri_finite_or_null(nu, du) ||
        !mbsri_finite_or_null(nu, dload))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "dq, du or dload is not finite");
    double *rates = w->load, *given = rates + m->nu, *load = given + m->nu, *forces = w->weight;
    const bool forward = w->at == MBSRI_LINEARISED_FORWARD;
    if (w->by_sweeps) return tangent_by_sweeps(w, name, dq, du, dload, out);
    copy_or_zero(nu, dq, rates);
    mbsri_derivatives_turn(w, false, rates, w->dq);
    copy_or_zero(nu, du, rates);
    copy_or_zero(nu, dload, given);
    if (!forward) {
        mbsri_derivatives_tangent(w, w->dq, rates, given, load);
        if (!mbsri_finite(nu, load))
            return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "it overflows");
        mbsri_copy(nu, load, out);
        return MBSR_OK;
    }
    mbsri_zero(nu, w->right);
    mbsri_derivatives_tangent(w, w->dq, rates, w->right, load);
    for (int k = 0; k < m->nu; ++k) w->right[k] = given[k] - load[k];
    for (int k = 0; k < m->rows; ++k) w->rows[k] = -w->rows[k];
    solve_mass(w, w->right, w->rows, w->solution, forces);
    if (!mbsri_finite(nu, w->solution))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "it overflows");
    mbsri_copy(nu, w->solution, out);
    for (size_t k = 0; k < rows && dlambda; ++k) dlambda[k] = forces[k] + w->lambda[k];
    return MBSR_OK;
}

/* Of forward dynamics: right = K^-T (w, w_lambda), the weights of the rows of inverse dynamics
 * (their negative) and of the rows' second derivatives. */
static void solve_back(mbsr_derivatives *w, const double *by, const double *by_lambda)
{
    const mbsr_model *m = w->model;
    const mbsri_closure *c = m->closures.data;
    double *rigid = w->weight + m->rows;
    mbsri_zero(2 * (size_t)m->rows, w->weight);
    for (size_t k = 0; k < m->closures.count && by_lambda; ++k, ++c) {
        for (int r = c->row; r < c->row + c->rows; ++r) {
            if (mbsri_is_stiff(c, r - c->row))
                w->weight[r] = by_lambda[r];
            else
                rigid[r] = -by_lambda[r];
        }
    }
    solve_mass(w, by, rigid, w->right, w->rows);
}

/* Of a tree without loops: dq, du, and du' of inverse dynamics; of forward dynamics `right` is by
 * tau. */
static void adjoint_by_sweeps(mbsr_derivatives *w, const double *weights, double *dq, double *du,
                              double *dudot)
{
    mbsri_rigid *r = w->rigid;
    const bool forward = w->at == MBSRI_LINEARISED_FORWARD;
    const double sign = forward ? -1.0 : 1.0, *by = forward ? w->right : weights;
    if (forward)
        r->kernels->solve(r, weights, w->right);
    else
        r->kernels->move(r, weights);
    if (r->elements) mbsri_rigid_elements_back(w, by);
    r->kernels->gradients(r, sign, by, dq, du, forward ? NULL : dudot);
    for (int k = 0; k < w->model->nu && r->elements; ++k) {
        dq[k] += sign * r->by_q[k];
        du[k] += sign * r->by_u[k];
    }
}

int mbsr_derivatives_adjoint(mbsr_derivatives *derivatives, const double *w_out,
                             const double *w_lambda, double *by_q, double *by_u, double *by_load)
{
    static const char name[] = "mbsr_derivatives_adjoint";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    const int status = check_product(w, name, true, w_lambda);
    if (status) return status;
    const mbsr_model *m = w->model;
    const size_t nu = (size_t)m->nu, rows = (size_t)m->rows;
    if (!mbsri_finite_or_null(nu, w_out) || !mbsri_finite_or_null(rows, w_lambda))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "w or w_lambda is not finite");
    double *weights = w->load, *du = weights + m->nu, *dudot = du + m->nu;
    const bool forward = w->at == MBSRI_LINEARISED_FORWARD;
    copy_or_zero(nu, w_out, weights);
    if (w->by_sweeps) {
        adjoint_by_sweeps(w, weights, w->solution, du, dudot);
    } else {
        mbsri_zero(rows, w->rows);
        mbsri_zero(rows, w->weight);
        if (forward) {
            solve_back(w, weights, w_lambda);
            for (int k = 0; k < m->nu; ++k) weights[k] = -w->right[k];
        }
        mbsri_derivatives_adjoint(w, weights, w->dq, du, dudot);
        mbsri_derivatives_turn(w, true, w->dq, w->solution);
    }
    const double *of_load = forward ? w->right : dudot;
    if (!mbsri_finite(nu, w->solution) || !mbsri_finite(nu, du) || !mbsri_finite(nu, of_load))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "it overflows");
    if (by_q) mbsri_copy(nu, w->solution, by_q);
    if (by_u) mbsri_copy(nu, du, by_u);
    if (by_load) mbsri_copy(nu, of_load, by_load);
    return MBSR_OK;
}

/* The column `k` of by_q (0), by_u (1), by_load (2). */
static int column_by_product(mbsr_derivatives *w, int which, int k, double *out)
{
    double *e = w->column;
    e[k] = 1.0;
    const int status = mbsr_derivatives_tangent(w, which == 0 ? e : NULL, which == 1 ? e : NULL,
                                                which == 2 ? e : NULL, out, NULL);
    e[k] = 0.0;
    return status;
}

int mbsr_derivatives_matrices(mbsr_derivatives *derivatives, double *by_q, double *by_u,
                              double *by_load)
{
    static const char name[] = "mbsr_derivatives_matrices";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    int status = check_product(w, name, true, NULL);
    if (status) return status;
    const size_t nu = (size_t)w->model->nu;
    double *const matrix[] = {by_q, by_u, by_load};
    const bool by_sweeps = w->by_sweeps && !w->rigid->elements;
    if (by_sweeps && w->rigid->kernels->matrices(w->rigid, by_q, by_u, by_load,
                                                 w->at == MBSRI_LINEARISED_FORWARD))
        return MBSR_OK;
    for (int which = 0; which < 3 && !status; ++which) {
        for (size_t k = 0; k < nu && matrix[which] && !by_sweeps && !status; ++k)
            status = column_by_product(w, which, (int)k, matrix[which] + k * nu);
        if (!status && matrix[which] && !mbsri_finite(nu * nu, matrix[which]))
            status = mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "it overflows");
    }
    return status;
}

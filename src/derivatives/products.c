/* Linearised inverse dynamics and its transpose.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Root to leaves x, the perturbations of pose, V and A of each body; then forces by them, of
 * elements and closures; leaves to root the changes of reactions mu, and what they make of joint
 * forces:
 *
 *   z = (x_pi, dq, du)     x = X z - (0, 0, J du')
 *       mu = P x + f - sum (H^T mu)_j + B z of the predecessor
 *   load = own z + J^T mu - tau + armature du'
 *
 * The transpose runs through the same from its end to its beginning. Matrices of the linearised
 * momentum form have rows of momenta, their rates and reactions one below the other: here the last
 * of them count.
 *
 * reads X, P, B, own, J, H of mbsri_terms;  cost: (e + 2 d) (e_pi + 2 d_pi + nq + n) and so on a
 * body, both ways */
#include "derivatives/record.h"

#include "algebra/dense.h"
#include "recursion/closures.h"

/* y (r) += A x, and y (c) += A^T x: rows `first` .. first + r - 1 of a matrix that has `stride`. */
static void rows_times(int stride, int first, int r, int c, const double *A, const double *x,
                       double *y)
{
    for (int j = 0; j < c; ++j) {
        const double *a = A + (size_t)j * (size_t)stride + first;
        for (int k = 0; k < r; ++k) y[k] += a[k] * x[j];
    }
}

static void rows_transposed(int stride, int first, int r, int c, const double *A, const double *x,
                            double *y)
{
    for (int j = 0; j < c; ++j) y[j] += mbsri_dot(r, A + (size_t)j * (size_t)stride + first, x);
}

/* Shape of what a joint reads. */
typedef struct shape {
    int x, pred, columns; /* numbers of x, of that of the predecessor, of z */
    bool below;           /* the predecessor moves: it has a mu */
} shape;

static shape shape_of(const mbsri_linear *l, int i)
{
    const mbsri_body *b = l->model->body + i;
    const int pred = mbsri_linear_motions(l, b->parent);
    return (shape){.x = mbsri_linear_motions(l, i),
                   .pred = pred,
                   .columns = pred + b->nq + b->n,
                   .below = l->below_massless[b->parent]};
}

/* ---- tangent ---- */

static void move_along(mbsr_derivatives *w, int i, const double *dq, const double *du,
                       const double *dudot, double *load)
{
    const mbsri_linear *l = w->linear;
    const mbsri_body *b = l->model->body + i;
    const mbsri_terms k = mbsri_linear_terms(l, i);
    const shape s = shape_of(l, i);
    double *z = w->in, *x = w->motion + l->motion[i];
    mbsri_copy((size_t)s.pred, w->motion + l->motion[b->parent], z);
    mbsri_copy((size_t)b->nq, dq + b->q, z + s.pred);
    mbsri_copy((size_t)b->n, du + b->u, z + s.pred + b->nq);
    mbsri_zero((size_t)s.x, x);
    mbsri_ax(s.x, s.columns, 1.0, k.x, z, x);
    mbsri_ax(b->d, b->n, -1.0, k.J, dudot + b->u, x + l->e[i] + b->d);
    for (int j = 0; j < b->n; ++j) load[b->u + j] = b->mass.armature[j] * dudot[b->u + j];
    if (w->seeds.active) {
        const double *seed = w->seeds.sum[MBSRI_SEED_MOTION] + l->motion[i];
        for (int j = 0; j < s.x; ++j) x[j] += seed[j];
        for (int j = 0; j < b->n; ++j) load[b->u + j] += w->seeds.sum[MBSRI_SEED_LOAD][b->u + j];
    }
    rows_times(3 * b->n, 2 * b->n, b->n, s.columns, k.own, z, load + b->u);
    if (s.below)
        rows_times(3 * b->pred.d, 2 * b->pred.d, b->pred.d, s.columns, k.below, z,
                   w->mu + b->pred.v);
}

static void react_to(mbsr_derivatives *w, int i, double *load)
{
    const mbsri_linear *l = w->linear;
    const mbsri_body *b = l->model->body + i;
    const mbsri_terms k = mbsri_linear_terms(l, i);
    double *mu = w->mu + b->v;
    rows_times(3 * b->d, 2 * b->d, b->d, mbsri_linear_motions(l, i), k.P, w->motion + l->motion[i],
               mu);
    for (int j = 0; j < b->n; ++j) load[b->u + j] -= w->torque[b->iu + j];
    mbsri_atx(b->d, b->n, 1.0, k.J, mu, load + b->u);
    mbsri_atx(b->d, b->pred.d, -1.0, k.H, mu, w->mu + b->pred.v);
}

/* z of an element in the call of body i; its bodies. */
static int read_element(const mbsr_derivatives *w, size_t k, int i, const double *dq,
                        const double *du, const int **list)
{
    const mbsri_linear *l = w->linear;
    const int bodies = mbsri_linear_bodies(l, mbsri_force_at(l->model, k), i, list);
    double *z = w->in;
    for (int j = 0; j < bodies; ++j) {
        const mbsri_body *b = l->model->body + (*list)[j];
        if ((*list)[j] == 0) continue;
        const size_t x = (size_t)(l->e[(*list)[j]] + b->d);
        mbsri_copy(x, w->motion + l->motion[(*list)[j]], z);
        mbsri_copy((size_t)b->nq, dq + b->q, z + x);
        mbsri_copy((size_t)b->n, du + b->u, z + x + b->nq);
        z += x + (size_t)(b->nq + b->n);
    }
    return bodies;
}

void mbsri_derivatives_elements(mbsr_derivatives *w, const double *dq, const double *du)
{
    const mbsri_linear *l = w->linear;
    for (size_t k = 0; k < l->model->forces.count; ++k) {
        int first, last, rows, columns;
        if (w->by_sweeps && mbsri_linear_is_plain(l->model, k)) continue;
        mbsri_linear_calls(l, k, &first, &last);
        for (int i = first; i <= last; ++i) {
            const int *list;
            const double *matrix = mbsri_linear_element(l, k, i, &rows, &columns);
            const int bodies = read_element(w, k, i, dq, du, &list);
            double *f = w->out;
            mbsri_zero((size_t)rows, f);
            mbsri_ax(rows, columns, 1.0, matrix, w->in, f);
            for (int j = 0; j < bodies; ++j) {
                const mbsri_body *b = l->model->body + list[j];
                if (list[j] == 0) continue;
                for (int r = 0; r < b->d; ++r) w->mu[b->v + (size_t)r] += f[r];
                for (int r = 0; r < b->n; ++r) w->torque[b->iu + r] += f[b->d + r];
                f += b->d + b->n;
            }
        }
    }
}

/* Place, rate and acceleration of a closure's columns; or their gradients, added to those of bodies
 * and joints. */
typedef struct reading {
    double *place, *rate, *acceleration;
} reading;

static void read_closure(const mbsr_derivatives *w, const mbsri_closure *c, const double *dq,
                         const double *du, const reading *to)
{
    const mbsri_linear *l = w->linear;
    mbsri_zero(3 * (size_t)c->columns, to->place);
    for (int k = 0; k < c->bodies; ++k) {
        const int i = c->body[k], at = c->column[k];
        const mbsri_body *b = l->model->body + i;
        if (at < 0 || i == 0) continue;
        const double *x = w->motion + l->motion[i];
        mbsri_copy((size_t)b->d, x, to->place + at);
        mbsri_copy((size_t)b->d, x + l->e[i], to->rate + at);
        mbsri_copy((size_t)b->d, x + l->e[i] + b->d, to->acceleration + at);
        if (!mbsri_reads_joints(c)) continue;
        mbsri_copy((size_t)b->n, dq + b->q, to->place + at + b->d);
        mbsri_copy((size_t)b->n, du + b->u, to->rate + at + b->d);
    }
}

/* Matrices of closure k: S of its forces by its columns, the slopes of its rows, its constraint
 * matrix C, and the second derivatives of the rows along the motion. */
typedef struct closure_matrices {
    const double *S, *slope, *C, *acceleration;
} closure_matrices;

static closure_matrices matrices_of(const mbsr_derivatives *w, const mbsri_closure *c, size_t k)
{
    const mbsri_closure_part of = mbsri_linear_closure(w->linear, k);
    return (closure_matrices){of.S, of.slope, of.C, w->acceleration + 2 * c->at};
}

static reading reading_at(double *memory, const mbsri_closure *c)
{
    return (reading){memory, memory + c->columns, memory + 2 * c->columns};
}

static void add_closures_along(mbsr_derivatives *w, const double *dq, const double *du,
                               const double *dudot)
{
    const mbsri_linear *l = w->linear;
    for (size_t k = 0; k < l->model->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)l->model->closures.data + k;
        const int n = c->columns, rows = c->rows;
        const closure_matrices a = matrices_of(w, c, k);
        const reading z = reading_at(w->in, c);
        double gap[MBSR_CLOSURE_ROWS] = {0.0}, rate[MBSR_CLOSURE_ROWS] = {0.0}, *force = w->out;
        read_closure(w, c, dq, du, &z);
        for (int j = 0; mbsri_reads_joints(c) && j < c->bodies; ++j) {
            const mbsri_body *b = l->model->body + c->body[j];
            if (c->column[j] >= 0 && c->body[j] > 0)
                mbsri_copy((size_t)b->n, dudot + b->u, z.acceleration + c->column[j] + b->d);
        }
        mbsri_ax(rows, n, 1.0, a.C, z.place, gap);
        mbsri_ax(rows, n, 1.0, a.C, z.rate, rate);
        mbsri_ax(rows, n, 1.0, a.slope, z.place, rate);
        mbsri_zero((size_t)rows, w->rows + c->row);
        mbsri_ax(rows, n, 1.0, a.C, z.acceleration, w->rows + c->row);
        mbsri_ax(rows, n, 1.0, a.acceleration, z.place, w->rows + c->row);
        mbsri_ax(rows, n, 1.0, a.acceleration + (size_t)rows * (size_t)n, z.rate, w->rows + c->row);
        for (int r = 0; r < rows; ++r)
            w->lambda[c->row + r] =
                mbsri_is_stiff(c, r) ? -c->def.stiffness[r] * gap[r] - c->def.damping[r] * rate[r]
                                     : 0.0;
        for (int r = c->row; r < c->row + rows && w->seeds.active; ++r)
            w->lambda[r] += w->seeds.sum[MBSRI_SEED_SPRING][r];
        mbsri_zero((size_t)n, force);
        mbsri_ax(n, n, 1.0, a.S, z.place, force);
        mbsri_atx(rows, n, 1.0, a.C, w->lambda + c->row, force);
        for (int j = 0; j < c->bodies; ++j) {
            const mbsri_body *b = l->model->body + c->body[j];
            if (c->column[j] < 0 || c->body[j] == 0) continue;
            const double *f = force + c->column[j];
            for (int r = 0; r < b->d; ++r) w->mu[b->v + (size_t)r] += f[r];
            for (int r = 0; r < b->n && mbsri_reads_joints(c); ++r)
                w->torque[b->iu + r] += f[b->d + r];
        }
    }
}

void mbsri_derivatives_tangent(mbsr_derivatives *w, const double *dq, const double *du,
                               const double *dudot, double *load)
{
    const mbsr_model *m = w->model;
    mbsri_zero((size_t)mbsri_linear_motions(w->linear, 0), w->motion);
    mbsri_zero(m->size.v, w->mu);
    mbsri_zero((size_t)m->nu, w->torque);
    if (w->seeds.active) {
        mbsri_copy(m->size.v, w->seeds.sum[MBSRI_SEED_REACTION], w->mu);
        mbsri_copy((size_t)m->nu, w->seeds.sum[MBSRI_SEED_TORQUE], w->torque);
    }
    for (int i = 1; i <= m->bodies; ++i) move_along(w, i, dq, du, dudot, load);
    mbsri_derivatives_elements(w, dq, du);
    add_closures_along(w, dq, du, dudot);
    for (int i = m->bodies; i >= 1; --i) react_to(w, i, load);
}

/* ---- adjoint ---- */

/* Gradients of mu, root to leaves, and of what P x adds to it. */
static void unact(mbsr_derivatives *w, int i, const double *load)
{
    const mbsri_linear *l = w->linear;
    const mbsri_body *b = l->model->body + i;
    const mbsri_terms k = mbsri_linear_terms(l, i);
    const int x = mbsri_linear_motions(l, i);
    double *mu = w->mu + b->v;
    mbsri_zero((size_t)b->d, mu);
    mbsri_ax(b->d, b->n, 1.0, k.J, load + b->u, mu);
    mbsri_ax(b->d, b->pred.d, -1.0, k.H, w->mu + b->pred.v, mu);
    mbsri_zero((size_t)x, w->motion + l->motion[i]);
    rows_transposed(3 * b->d, 2 * b->d, b->d, x, k.P, mu, w->motion + l->motion[i]);
}

static void unmove(mbsr_derivatives *w, int i, const double *load, double *dq, double *du,
                   double *dudot)
{
    const mbsri_linear *l = w->linear;
    const mbsri_body *b = l->model->body + i;
    const mbsri_terms k = mbsri_linear_terms(l, i);
    const shape s = shape_of(l, i);
    double *z = w->in, *x = w->motion + l->motion[i], *pred = w->motion + l->motion[b->parent];
    mbsri_zero((size_t)s.columns, z);
    mbsri_atx(s.x, s.columns, 1.0, k.x, x, z);
    rows_transposed(3 * b->n, 2 * b->n, b->n, s.columns, k.own, load + b->u, z);
    if (s.below)
        rows_transposed(3 * b->pred.d, 2 * b->pred.d, b->pred.d, s.columns, k.below,
                        w->mu + b->pred.v, z);
    for (int j = 0; j < b->n; ++j) dudot[b->u + j] += b->mass.armature[j] * load[b->u + j];
    mbsri_atx(b->d, b->n, -1.0, k.J, x + l->e[i] + b->d, dudot + b->u);
    for (int j = 0; j < s.pred && s.below; ++j) pred[j] += z[j];
    for (int j = 0; j < b->nq; ++j) dq[b->q + j] += z[s.pred + j];
    for (int j = 0; j < b->n; ++j) du[b->u + j] += z[s.pred + b->nq + j];
}

void mbsri_derivatives_elements_back(mbsr_derivatives *w, const double *load, double *dq,
                                     double *du)
{
    const mbsri_linear *l = w->linear;
    for (size_t k = 0; k < l->model->forces.count; ++k) {
        int first, last, rows, columns;
        if (w->by_sweeps && mbsri_linear_is_plain(l->model, k)) continue;
        mbsri_linear_calls(l, k, &first, &last);
        for (int i = first; i <= last; ++i) {
            const int *list;
            const double *matrix = mbsri_linear_element(l, k, i, &rows, &columns);
            const int bodies = mbsri_linear_bodies(l, mbsri_force_at(l->model, k), i, &list);
            double *f = w->out, *z = w->in;
            for (int j = 0; j < bodies; ++j) {
                const mbsri_body *b = l->model->body + list[j];
                if (list[j] == 0) continue;
                mbsri_copy((size_t)b->d, w->mu + b->v, f);
                for (int r = 0; r < b->n; ++r) f[b->d + r] = -load[b->u + r];
                f += b->d + b->n;
            }
            mbsri_zero((size_t)columns, z);
            mbsri_atx(rows, columns, 1.0, matrix, w->out, z);
            for (int j = 0; j < bodies; ++j) {
                const mbsri_body *b = l->model->body + list[j];
                if (list[j] == 0) continue;
                double *x = w->motion + l->motion[list[j]];
                const int count = l->e[list[j]] + b->d;
                for (int r = 0; r < count; ++r) x[r] += z[r];
                for (int r = 0; r < b->nq; ++r) dq[b->q + r] += z[count + r];
                for (int r = 0; r < b->n; ++r) du[b->u + r] += z[count + b->nq + r];
                z += count + b->nq + b->n;
            }
        }
    }
}

/* Adds what stands in the columns of a closure to the gradients of its bodies and joints. */
static void give_closure(const mbsr_derivatives *w, const mbsri_closure *c, const reading *z,
                         double *dq, double *du, double *dudot)
{
    const mbsri_linear *l = w->linear;
    for (int k = 0; k < c->bodies; ++k) {
        const int i = c->body[k], at = c->column[k];
        const mbsri_body *b = l->model->body + i;
        if (at < 0 || i == 0) continue;
        double *x = w->motion + l->motion[i];
        for (int r = 0; r < b->d; ++r) {
            x[r] += z->place[at + r];
            x[l->e[i] + r] += z->rate[at + r];
            x[l->e[i] + b->d + r] += z->acceleration[at + r];
        }
        for (int r = 0; r < b->n && mbsri_reads_joints(c); ++r) {
            dq[b->q + r] += z->place[at + b->d + r];
            du[b->u + r] += z->rate[at + b->d + r];
            dudot[b->u + r] += z->acceleration[at + b->d + r];
        }
    }
}

static void unadd_closures(mbsr_derivatives *w, const double *load, double *dq, double *du,
                           double *dudot)
{
    const mbsri_linear *l = w->linear;
    for (size_t k = 0; k < l->model->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)l->model->closures.data + k;
        const int n = c->columns, rows = c->rows;
        const closure_matrices a = matrices_of(w, c, k);
        const reading z = reading_at(w->in, c);
        double gap[MBSR_CLOSURE_ROWS] = {0.0}, rate[MBSR_CLOSURE_ROWS] = {0.0}, *force = w->out;
        mbsri_zero((size_t)n, force);
        for (int j = 0; j < c->bodies; ++j) {
            const mbsri_body *b = l->model->body + c->body[j];
            if (c->column[j] < 0 || c->body[j] == 0) continue;
            double *f = force + c->column[j];
            mbsri_copy((size_t)b->d, w->mu + b->v, f);
            for (int r = 0; r < b->n && mbsri_reads_joints(c); ++r) f[b->d + r] = -load[b->u + r];
        }
        double lambda[MBSR_CLOSURE_ROWS] = {0.0};
        mbsri_ax(rows, n, 1.0, a.C, force, lambda);
        for (int r = 0; r < rows; ++r) {
            if (!mbsri_is_stiff(c, r)) continue;
            const double all = lambda[r] + w->weight[c->row + r];
            w->lambda[c->row + r] = all;
            gap[r] = -c->def.stiffness[r] * all;
            rate[r] = -c->def.damping[r] * all;
        }
        const double *of_rows = w->rows + c->row;
        mbsri_zero(3 * (size_t)n, z.place);
        mbsri_atx(n, n, 1.0, a.S, force, z.place);
        mbsri_atx(rows, n, 1.0, a.C, gap, z.place);
        mbsri_atx(rows, n, 1.0, a.slope, rate, z.place);
        mbsri_atx(rows, n, 1.0, a.acceleration, of_rows, z.place);
        mbsri_atx(rows, n, 1.0, a.C, rate, z.rate);
        mbsri_atx(rows, n, 1.0, a.acceleration + (size_t)rows * (size_t)n, of_rows, z.rate);
        mbsri_atx(rows, n, 1.0, a.C, of_rows, z.acceleration);
        give_closure(w, c, &z, dq, du, dudot);
    }
}

void mbsri_derivatives_adjoint(mbsr_derivatives *w, const double *load, double *dq, double *du,
                               double *dudot)
{
    const mbsr_model *m = w->model;
    mbsri_zero((size_t)m->root.d, w->mu);
    mbsri_zero((size_t)m->nq, dq);
    mbsri_zero((size_t)m->nu, du);
    mbsri_zero((size_t)m->nu, dudot);
    for (int i = 1; i <= m->bodies; ++i) unact(w, i, load);
    mbsri_derivatives_elements_back(w, load, dq, du);
    unadd_closures(w, load, dq, du, dudot);
    for (int i = m->bodies; i >= 1; --i) unmove(w, i, load, dq, du, dudot);
}

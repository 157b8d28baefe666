/* Neglected inertia forces by inverse dynamics; loads as columns.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With dM, dh what is left out of the mass matrix and the gyroscopic force of a body, the neglected
 * force is w = dM A + dh - (weight of dM). The full equations of motion are those of the reduced
 * model under the load -w. */
#include "small/loads.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "forces/gravity.h"
#include "recursion/elements.h"
#include "recursion/inertia.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "small/twins.h"

#include <float.h>
#include <math.h>

enum { SMALL_D = 6 }; /* d of bodies in the plane and in space */

/* dM and dh of a candidate in its pose and velocity; M, h: scratch of the same sizes. */
static int neglected(const mbsr_small_masses *s, const mbsri_candidate *c, double t,
                     const double *p, const double *V, double *dM, double *dh, double *M, double *h)
{
    const mbsri_body *whole = s->full.model->body + c->i;
    mbsri_body left = *whole;
    const int d = whole->d;
    left.inertia = c->left;
    mbsri_inertia_mass(whole, p, dM);
    int status = mbsri_inertia_velocity(whole, t, p, V, dM, dh);
    mbsri_inertia_mass(&left, p, M);
    if (!status) status = mbsri_inertia_velocity(&left, t, p, V, M, h);
    for (int k = 0; k < d * d; ++k) dM[k] -= M[k];
    for (int k = 0; k < d; ++k) dh[k] -= h[k];
    return status;
}

/* f += weight of dM */
static int add_weight(const mbsr_small_masses *s, const mbsri_candidate *c, double t,
                      const double *p, const double *V, const double *dM, double *f)
{
    const mbsr_model *m = s->full.model;
    const mbsri_body *b = m->body + c->i;
    const mbsri_force *force = m->forces.data;
    const mbsr_force_body body = {.id = b->id,
                                  .space = b->joint.space,
                                  .d = b->d,
                                  .np = b->np,
                                  .p = p,
                                  .V = V,
                                  .M = dM,
                                  .inertia = &b->inertia,
                                  .f = f};
    int status = MBSR_OK;
    for (size_t k = 0; k < m->forces.count && !status; ++k) {
        const mbsr_force_args args = {.force = &force[k].def, .t = t, .bodies = 1, .body = &body};
        if (mbsri_is_gravity(&force[k].def)) status = force[k].def.table->evaluate(&args);
    }
    return status;
}

/* Scratch of a body: dM, dh, M, h, weight; those of usual size on the stack. */
typedef struct scratch {
    double numbers[2 * SMALL_D * SMALL_D + 3 * SMALL_D];
    double *dM, *dh, *M, *h, *weight;
    void *taken;
} scratch;

static bool open_scratch(const mbsr_small_masses *s, int d, scratch *x)
{
    const size_t n = (size_t)d;
    x->taken = NULL;
    if (d > SMALL_D) x->taken = mbsri_allocate(&s->allocator, (2 * n * n + 3 * n) * sizeof(double));
    x->dM = d > SMALL_D ? x->taken : x->numbers;
    if (!x->dM) return false;
    x->M = x->dM + n * n;
    x->dh = x->M + n * n;
    x->h = x->dh + n;
    x->weight = x->h + n;
    return true;
}

/* force = dM A + dh - weight, or, with impulse, dM (A - B). */
static int evaluate_loads(mbsr_small_masses *s, mbsri_candidate *c, double t, const double *p,
                          const double *V, const double *A, double *force, bool weighs)
{
    const int d = s->full.model->body[c->i].d;
    scratch x;
    if (!open_scratch(s, d, &x)) return MBSR_ERR_NO_MEMORY;
    int status = neglected(s, c, t, p, V, x.dM, x.dh, x.M, x.h);
    mbsri_zero((size_t)d, x.weight);
    if (!status && weighs) status = add_weight(s, c, t, p, V, x.dM, x.weight);
    for (int k = 0; k < d; ++k) force[k] = weighs ? x.dh[k] - x.weight[k] : 0.0;
    mbsri_ax(d, d, 1.0, x.dM, A, force);
    mbsri_release(&s->allocator, x.taken);
    return status;
}

int mbsri_small_forces(mbsr_small_masses *s, double t, const double *y, const double *yp)
{
    const mbsr_model *m = s->reduced.model;
    mbsr_data *d = s->reduced.data;
    const int u = m->nq + m->nu;
    int status = mbsri_positions(m, d, t, y);
    if (!status) status = mbsri_velocities(m, d, y + u);
    if (!status) status = mbsri_forces(m, d, NULL, NULL);
    if (status) return mbsri_small_failed(s, status, mbsr_data_error(d));
    mbsri_inverse(m, d, yp + u);
    for (int k = 0; k < s->candidates && !status; ++k) {
        mbsri_candidate *c = s->candidate + k;
        const mbsri_body *b = m->body + c->i;
        status = evaluate_loads(s, c, t, d->p + b->p, d->V + b->v, d->A + b->v, c->force, true);
        for (int l = 0; l < b->d; ++l)
            if (!isfinite(c->force[l])) status = MBSR_NOT_FINITE;
        if (status)
            return mbsri_fail(&s->error, status, c->body, MBSR_NONE,
                              "body %d: its inertia force could not be evaluated at t = %g",
                              c->body, t);
    }
    return status;
}

int mbsri_small_split(mbsr_small_masses *s, double t, const double *y, double h)
{
    const mbsr_model *m = s->reduced.model;
    mbsr_data *d = s->reduced.data;
    int status = mbsri_positions(m, d, t, y);
    if (!status) status = mbsri_velocities(m, d, y + m->nq + m->nu);
    for (int k = 0; k < s->candidates && !status; ++k) {
        mbsri_candidate *c = s->candidate + k;
        const mbsri_body *b = m->body + c->i;
        const double *p = d->p + b->p, *V = d->V + b->v;
        double *A = s->work.load;
        status = evaluate_loads(s, c, t, p, V, d->A + b->v, c->mean, false);
        for (int l = 0; l < b->d; ++l) c->rest[l] = c->force[l] - c->mean[l];
        for (int l = 0; l < b->d && h > 0.0; ++l) A[l] = (V[l] - c->velocity[l]) / h;
        if (!status && h > 0.0) status = evaluate_loads(s, c, t, p, V, A, c->mean, false);
        mbsri_copy((size_t)b->d, V, c->velocity);
    }
    return mbsri_small_failed(s, status, mbsr_data_error(d));
}

int mbsri_small_impulses(mbsr_small_masses *s, double t, const double *y)
{
    const mbsr_model *m = s->reduced.model;
    mbsr_data *d = s->reduced.data;
    int status = mbsri_positions(m, d, t, s->start.q);
    if (!status) status = mbsri_velocities(m, d, s->start.u);
    if (status) return mbsri_small_failed(s, status, mbsr_data_error(d));
    for (int k = 0; k < s->candidates; ++k) {
        const mbsri_body *b = m->body + s->candidate[k].i;
        mbsri_copy((size_t)b->d, d->V + b->v, s->candidate[k].impulse);
    }
    status = mbsri_positions(m, d, t, y);
    if (!status) status = mbsri_velocities(m, d, y + m->nq + m->nu);
    if (status) return mbsri_small_failed(s, status, mbsr_data_error(d));
    for (int k = 0; k < s->candidates && !status; ++k) {
        mbsri_candidate *c = s->candidate + k;
        const mbsri_body *b = m->body + c->i;
        double *jump = s->work.load;
        for (int l = 0; l < b->d; ++l) jump[l] = c->impulse[l] - d->V[b->v + (size_t)l];
        status = evaluate_loads(s, c, t, d->p + b->p, d->V + b->v, jump, c->impulse, false);
    }
    return mbsri_small_failed(s, status, mbsr_data_error(d));
}

int mbsri_small_unloaded(mbsr_small_masses *s, const mbsri_twin *twin, double t, const double *y,
                         const double *yp)
{
    const int status =
        mbsr_dae_residual(twin->model, twin->data, MBSR_DAE_MOMENTUM, t, y, yp, s->work.F);
    return mbsri_small_failed(s, status, mbsr_data_error(twin->data));
}

/* F is linear in the load, which is taken so large that rounding of F does not count beside it. */
int mbsri_small_column(mbsr_small_masses *s, const mbsri_twin *twin, double t, const double *y,
                       const double *yp, mbsri_small_load *load, const double *x, double *column)
{
    static const double large = 1e10,
                        least = 1e10 * DBL_MIN; /* of which large is a finite multiple */
    double most = 0.0;
    for (int k = 0; k < load->n; ++k) most = fmax(most, fabs(x[k]));
    mbsri_zero((size_t)s->size, column);
    if (most < least) return MBSR_OK;
    for (int k = 0; k < load->n; ++k) load->value[k] = x[k] * (large / most);
    const int status =
        mbsr_dae_residual(twin->model, twin->data, MBSR_DAE_MOMENTUM, t, y, yp, s->work.F_loaded);
    mbsri_zero((size_t)load->n, load->value);
    if (status) return mbsri_small_failed(s, status, mbsr_data_error(twin->data));
    for (int k = 0; k < s->size; ++k)
        column[k] = (s->work.F_loaded[k] - s->work.F[k]) * (most / large);
    return MBSR_OK;
}

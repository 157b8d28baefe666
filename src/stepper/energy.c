/* The account of energy: see energy.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Implicit steps damp what is stiff, but along joint coordinates that turn fast (a tumbling
 * chain) their error may feed energy, step by step. What the tree can have is known:
 *
 *   E <= A + W        A: at the end of the substep before, the least of E and A + W
 *                     W = 2 h max(P, P_mean, 0): more than elements without an energy do, by power
 *                     at the end, P with its u and P_mean with the mean of u over the substep
 *
 * An E above that by more than 0.01 S, and by rounding, is not believed. S is the kinetic energy
 * that the tree has had and has not lost since: S <- max(T, S + change of A). By 0.1 S more the
 * substep is tried again in halves, unless it is the smallest. Else u and p are multiplied by
 * the root of 1 - excess / T, but not by less than a half, which takes the excess away as far as
 * it is kinetic; what loops allow stays allowed, being linear in u. A does not follow an E above
 * it, so that what is made in many steps is seen as what is made in one.
 *
 * Not where the root moves, joints are driven or closures follow a motion: their power is not
 * known. */
#include "stepper/energy.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "recursion/elements.h"

#include <math.h>

/* Whether an element exerts forces whose energy and heat nobody tells. */
static bool feeds(const mbsri_force *force)
{
    const mbsr_force_table *table = force->def.table;
    return force->def.spring || (!table->energy && !table->dissipation);
}

static bool serves(const mbsr_model *m)
{
    if (m->root.motion) return false;
    for (int i = 1; i <= m->bodies; ++i)
        if (m->body[i].joint.motion) return false;
    const mbsri_closure *c = m->closures.data;
    for (size_t k = 0; k < m->closures.count; ++k)
        if (c[k].def.motion) return false;
    return true;
}

/* Power of the elements that feed, W, at the state that the data is at. */
static int find_power(mbsr_stepper *s, double *power)
{
    const mbsr_model *m = s->model;
    mbsr_data *d = s->data;
    const mbsri_force *force = m->forces.data;
    mbsri_zero(m->size.v, d->f);
    mbsri_zero((size_t)m->nu, d->tau);
    for (size_t k = 0; k < m->forces.count; ++k) {
        if (!feeds(force + k) || mbsri_force_off(m, d, force + k)) continue;
        const int status = mbsri_add_element(m, d, force + k);
        if (status) return status;
    }
    *power = mbsri_dot((int)m->size.v, d->f, d->V) + mbsri_dot(m->nu, d->tau, d->u);
    return MBSR_OK;
}

/* W of a substep of length h that ends with the rates u, where the data is at
 * mbsr_stage_velocities. */
static int find_work(mbsr_stepper *s, double h, const double *u, double *work)
{
    double mean = 0.0, end = 0.0;
    *work = 0.0;
    if (!s->account.fed) return MBSR_OK;
    int status = find_power(s, &end);
    if (!status) status = mbsr_stage_velocities(s->model, s->data, s->mean);
    if (!status) status = find_power(s, &mean);
    if (!status) status = mbsr_stage_velocities(s->model, s->data, u);
    *work = 2.0 * h * fmax(0.0, fmax(mean, end));
    return status;
}

int mbsri_stepper_open_account(mbsr_stepper *s)
{
    mbsri_stepper_account *a = &s->account;
    const mbsri_force *force = s->model->forces.data;
    double potential = 0.0;
    *a = (mbsri_stepper_account){.served = s->opt.watch_energy && serves(s->model)};
    if (!a->served) return MBSR_OK;
    for (size_t k = 0; k < s->model->forces.count; ++k) a->fed = a->fed || feeds(force + k);
    const int status = mbsr_energy(s->model, s->data, &a->scale, &potential);
    if (status) s->cause = *mbsr_data_error(s->data);
    a->energy = a->scale + potential;
    return status;
}

/* Takes `excess` of the kinetic energy away, as far as half of u does; what is left of it. */
static double brake(mbsr_stepper *s, double kinetic, double excess)
{
    static const double most = 0.75;
    const size_t nq = (size_t)s->model->nq, nu = (size_t)s->model->nu;
    const double share = kinetic > 0.0 ? fmin(excess / kinetic, most) : 0.0;
    const double factor = sqrt(1.0 - share);
    for (size_t k = nq; k < nq + 2 * nu; ++k) s->Y[k] *= factor;
    ++s->info.braked;
    return (1.0 - share) * kinetic;
}

int mbsri_stepper_settle(mbsr_stepper *s, double h, bool last)
{
    static const double slack = 0.01, much = 0.1, rounding = 1e-9;
    mbsri_stepper_account *a = &s->account;
    if (!a->served) return MBSR_OK;
    double kinetic, potential, work = 0.0;
    double *u = s->Y + s->model->nq + s->model->nu;
    int status = mbsr_energy(s->model, s->data, &kinetic, &potential);
    if (!status) status = find_work(s, h, u, &work);
    if (status) s->cause = *mbsr_data_error(s->data);
    if (status) return status;
    const double there = a->energy + work, scale = fmax(a->scale, kinetic);
    const double excess =
        kinetic + potential - there - slack * scale - rounding * (kinetic + fabs(potential));
    if (!last && excess > much * scale) {
        return mbsri_fail(&s->cause, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                          "the step makes %.3g J beside a kinetic energy of %.3g J", excess,
                          kinetic);
    }
    if (excess > 0.0) {
        kinetic = brake(s, kinetic, excess);
        status = mbsr_stage_velocities(s->model, s->data, u);
        if (status) s->cause = *mbsr_data_error(s->data);
        if (status) return status;
    }
    const double now = fmin(there, kinetic + potential);
    a->scale = fmax(kinetic, a->scale + now - a->energy);
    a->energy = now;
    return MBSR_OK;
}

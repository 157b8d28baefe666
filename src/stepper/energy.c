/* The account of energy: see energy.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Implicit steps damp what is stiff, but along joint coordinates that turn fast (a tumbling chain) their error
 * may feed energy, step by step. What the tree can have is known:
 *
 *   E <= A + W        A: at the end of a step before, the least of E and A + W
 *                     W = 2 h max(P_0, P_1, 0), more than what elements without an energy feed by their power P
 *
 * An E above that by more than 0.01 S is not believed. S is the kinetic energy that the tree has had and has not
 * lost since: S <- max(T, S + change of A). Where that is less than 0.1 S, u and p are
 * multiplied by the root of 1 - excess / T, which takes the excess away; what loops allow stays allowed, being
 * linear in u. Where it is more the substep is refused, and braked only where no shorter one is left. So E
 * never exceeds what was there and what was fed by more than 0.01 S, however many steps are taken.
 *
 * Not where the root moves, joints are driven or closures follow a motion: their power is not known. */
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

/* Power of the elements that feed, W. */
static int find_power(mbsr_stepper *s, double *power)
{
    const mbsr_model *m = s->model;
    mbsr_data *d = s->data;
    const mbsri_force *force = m->forces.data;
    *power = 0.0;
    bool some = false;
    for (size_t k = 0; k < m->forces.count; ++k) {
        if (!feeds(force + k) || mbsri_force_off(m, d, force + k)) continue;
        if (!some) {
            mbsri_zero(m->size_v, d->f);
            mbsri_zero((size_t)m->nu, d->tau);
        }
        some = true;
        const int status = mbsri_add_element(m, d, force + k);
        if (status) return status;
    }
    if (some) *power = mbsri_dot((int)m->size_v, d->f, d->V) + mbsri_dot(m->nu, d->tau, d->u);
    return MBSR_OK;
}

static int measure(mbsr_stepper *s, double *kinetic, double *energy, double *power)
{
    double potential = 0.0;
    int status = mbsr_energy(s->model, s->data, kinetic, &potential);
    if (!status) status = find_power(s, power);
    if (status) s->cause = *mbsr_data_error(s->data);
    *energy = *kinetic + potential;
    return status;
}

int mbsri_stepper_open_account(mbsr_stepper *s)
{
    mbsri_stepper_account *a = &s->account;
    a->served = s->opt.watch_energy && serves(s->model);
    return a->served ? measure(s, &a->scale, &a->energy, &a->power) : MBSR_OK;
}

/* Takes `excess` of the kinetic energy away. */
static int brake(mbsr_stepper *s, double kinetic, double excess)
{
    const size_t nq = (size_t)s->model->nq, nu = (size_t)s->model->nu;
    const double factor = sqrt(1.0 - excess / kinetic);
    for (size_t k = nq; k < nq + 2 * nu; ++k) s->Y[k] *= factor;
    ++s->info.braked;
    const int status = mbsr_velocities(s->model, s->data, s->Y + nq + nu);
    if (status) s->cause = *mbsr_data_error(s->data);
    return status;
}

int mbsri_stepper_settle(mbsr_stepper *s, double h, bool last)
{
    static const double slack = 0.01, much = 0.1;
    mbsri_stepper_account *a = &s->account;
    if (!a->served) return MBSR_OK;
    double kinetic, energy, power;
    int status = measure(s, &kinetic, &energy, &power);
    if (status) return status;
    const double there = a->energy + 2.0 * h * fmax(0.0, fmax(a->power, power));
    const double scale = fmax(a->scale, kinetic), excess = energy - there - slack * scale;
    if (excess >= kinetic || (!last && excess > much * scale)) {
        return mbsri_fail(&s->cause, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                          "the step has made %.3g J, beside a kinetic energy of %.3g J",
                          energy - there, kinetic);
    }
    if (excess > 0.0) {
        status = brake(s, kinetic, excess);
        if (status) return status;
        energy -= excess;
        kinetic -= excess;
    }
    const double now = fmin(there, energy);
    a->scale = fmax(kinetic, a->scale + now - a->energy);
    a->energy = now;
    a->power = power;
    return MBSR_OK;
}

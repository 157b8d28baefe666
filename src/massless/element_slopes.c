/* Slopes of single force elements in the directions that move no mass: see element_slopes.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With the derivatives F_V, F_u, F_x, F_q of what an element exerts, f and tau, and the twist w_l
 * and joint rates a_l of direction l,
 *
 *   C_kl += (w_k, a_k)^T (F_V w_l + F_u a_l)
 *   S_kl += (w_k, a_k)^T (F_x w_l + F_V V'_l + F_q q'_l)
 *
 * where V'_l is the change of V along q'_l = G a_l with u held. Errors are those of rounding in
 * these sums. */
#include "massless/element_slopes.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "forces/columns.h"
#include "massless/element_power.h"
#include "massless/element_reaction.h"
#include "massless/element_rows.h"
#include "massless/scales.h"
#include "model/query.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"

#include <float.h>
#include <math.h>

static const double rounding = MBSRI_ELEMENT_ROUNDING;

/* An element whose derivatives stand for its law: its own, without M, of bodies whose pose changes
 * with their twist. Those that act on every body are mostly weights, whose slopes cancel. */
static bool usable(const mbsr_model *m, const mbsri_force *force)
{
    const mbsr_force_table *table = force->def.table;
    if (!table->derivatives || table->flags & MBSR_FORCE_EVERY_BODY) return false;
    if (table->flags & MBSR_FORCE_JOINT_ONLY) return true;
    if (!(table->flags & MBSR_FORCE_NO_MASS)) return false;
    for (int k = 0; k < force->def.bodies; ++k) {
        const int i = m->stored.list_index[force->list + (size_t)k];
        if (i > 0 && m->body[i].joint.space == MBSR_SPACE_GENERAL) return false;
    }
    return true;
}

/* ---- the slopes ---- */

/* Column l of A and its errors: the reaction y in all moving directions. doubted: what lever arms
 * are wrong by counts beside y, or (S, whose forces are themselves differences of positions) beside
 * gross. They are as wrong on the side of the motion as on that of the power. */
static void add_column(mbsri_null_space *w, int bodies, int moving, int l, const double *y,
                       const double *gross, const double *doubted, double *A, double *error)
{
    const mbsr_model *m = w->m;
    for (int n = 0; n < moving; ++n) {
        const size_t k = (size_t)w->element.moving[n], at = (size_t)l * (size_t)w->k + k,
                     across = k * (size_t)w->k + (size_t)l;
        const double *twist = w->twist + k * m->size.v,
                     doubt = rounding * mbsri_element_doubt(w, bodies, twist, doubted) +
                             mbsri_element_error(w, bodies, (int)k, doubted);
        double size;
        A[at] += mbsri_element_power(w, bodies, w->direction + k * (size_t)m->nu, twist, y, gross,
                                     &size);
        error[at] += rounding * size + doubt;
        error[across] += doubt;
    }
}

/* Directions that move something the element sees, or may within their errors, into
 * w->element.moving. */
static int find_moving(mbsri_null_space *w, const mbsri_force *force)
{
    const size_t nu = (size_t)w->m->nu, v = w->m->size.v;
    int count = 0;
    for (size_t l = 0; l < (size_t)w->k; ++l) {
        if (mbsri_element_moves(w, force, 0, w->direction + l * nu, w->twist + l * v) ||
            mbsri_element_moves(w, force, 0, w->lift.rate_error + l * nu,
                                w->lift.twist_error + l * v))
            w->element.moving[count++] = (int)l;
    }
    return count;
}

/* What an element adds to w->element.strain; strain (rows): of mbsri_element_strain. */
static void add_strain(mbsri_null_space *w, const mbsri_force *force, const double *strain)
{
    const mbsr_model *m = w->m;
    const int moving = find_moving(w, force);
    for (int n = 0; n < moving; ++n) {
        const size_t l = (size_t)w->element.moving[n];
        double size;
        (void)mbsri_element_power(w, force->def.bodies, w->direction + l * (size_t)m->nu,
                                  w->twist + l * m->size.v, strain, strain, &size);
        w->element.strain[l] += size;
    }
}

/* Whether what an element exerts is more than what rounding of positions makes of its stiffness;
 * adds this to w->element.strain. */
static int exerts(mbsri_null_space *w, const mbsri_force *force, bool *something)
{
    int status = mbsri_force_slopes(w->m, w->d, force, 0, &w->element.slope);
    if (status) return status;
    const int bodies = force->def.bodies;
    double *y = w->element.reaction, *gross = y + w->element.slope.out.rows;
    mbsri_element_strain(w, bodies, false, gross);
    add_strain(w, force, gross);
    status = mbsri_force_values(w->m, w->d, force, 0, &w->element.slope, y);
    *something = mbsri_element_stands_out(w, bodies, 1e3 * DBL_EPSILON, y, gross);
    return status;
}

int mbsri_hold_elements(mbsri_null_space *w)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    const mbsri_force *force = m->forces.data;
    int status = MBSR_OK;
    mbsri_zero((size_t)w->k, w->element.strain);
    mbsri_zero((size_t)m->nu, d->tau);
    mbsri_zero(m->size.v, d->f);
    for (size_t k = 0; k < m->forces.count && !status; ++k) {
        w->loads.own[k] = usable(m, force + k);
        bool something = false;
        if (w->loads.own[k]) status = exerts(w, force + k, &something);
        if (!status && something) status = mbsri_add_element(m, d, force + k);
    }
    mbsri_copy((size_t)m->nu, d->tau, w->loads.tau);
    mbsri_copy(m->size.v, d->f, w->loads.f);
    d->stage = MBSRI_STAGE_VELOCITIES;
    return status;
}

int mbsri_element_rate(mbsri_null_space *w, double *rate)
{
    const mbsr_model *m = w->m;
    const mbsri_force *force = m->forces.data;
    double springs = 0.0, dampers = 0.0;
    for (size_t k = 0; k < m->forces.count; ++k) {
        if (!usable(m, force + k)) continue;
        const int status = mbsri_force_slopes(m, w->d, force + k, 0, &w->element.slope);
        if (status) return status;
        const int bodies = force[k].def.bodies;
        mbsri_element_strain(w, bodies, false, w->element.reaction);
        springs = fmax(springs, mbsri_element_work(w, bodies, w->element.reaction));
        mbsri_element_strain(w, bodies, true, w->element.reaction);
        dampers = fmax(dampers, mbsri_element_work(w, bodies, w->element.reaction));
    }
    const double inertia = m->typical.mass * w->size * w->size;
    if (inertia > 0.0)
        *rate = springs > 0.0 ? sqrt(springs / inertia) : dampers / inertia;
    else
        *rate = dampers > 0.0 ? springs / dampers : 0.0;
    if (!isfinite(*rate)) *rate = 0.0;
    return MBSR_OK;
}

static int add_element(mbsri_null_space *w, int number)
{
    const mbsr_model *m = w->m;
    const mbsri_force *force = (const mbsri_force *)m->forces.data + number;
    int status = mbsri_force_slopes(m, w->d, force, 0, &w->element.slope);
    if (status) return status;
    const int bodies = force->def.bodies, moving = find_moving(w, force);
    double *y = w->element.reaction, *gross = y + w->element.slope.out.rows;
    for (int n = 0; n < moving; ++n) {
        const size_t l = (size_t)w->element.moving[n];
        const double *a = w->direction + l * (size_t)m->nu, *twist = w->twist + l * m->size.v;
        const mbsri_element_motion rate = {.V = twist, .u = a},
                                   shift = {.pose = twist,
                                            .V = w->element.V_rate + l * m->size.v,
                                            .q = w->element.q_rate + l * (size_t)m->nq};
        if (mbsri_element_react(w, bodies, rate, true, y, gross) &&
            mbsri_element_stands_out(w, bodies, 10.0 * rounding, y, gross) &&
            mbsri_element_react(w, bodies, rate, false, y, gross))
            add_column(w, bodies, moving, (int)l, y, gross, y, w->C, w->C_error);
        if (mbsri_element_react(w, bodies, shift, true, y, gross))
            add_column(w, bodies, moving, (int)l, y, gross, gross, w->S, w->S_error);
    }
    status = mbsri_element_rows(w, number, moving, true);
    return status ? status : mbsri_element_rows(w, number, moving, false);
}

/* Bodies whose position to their predecessor, or whose pose, changes along direction l; how many.
 */
static int find_touched(const mbsri_null_space *w, int l)
{
    const mbsr_model *m = w->m;
    const double *a = w->direction + (size_t)l * (size_t)m->nu,
                 *twist = w->twist + (size_t)l * m->size.v;
    int count = 0;
    for (int i = w->sums.head[l]; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const double *before = twist + m->body[b->parent].v;
        if (mbsri_largest(b->n, a + b->u) > 0.0 || mbsri_largest(b->d, twist + b->v) > 0.0 ||
            mbsri_largest(b->pred.d, before) > 0.0)
            w->element.touched[count++] = i;
    }
    return count;
}

/* Positions and velocities of the bodies touched, at q + step rate. */
static int place_bodies(mbsri_null_space *w, int count, const double *q, const double *rate,
                        double step)
{
    int status = MBSR_OK;
    for (int n = 0; n < count && !status; ++n) {
        const int i = w->element.touched[n];
        const mbsri_body *b = w->m->body + i;
        for (int c = 0; c < b->nq; ++c)
            w->d->q[b->iq + c] = step != 0.0 ? q[b->q + c] + step * rate[b->q + c] : q[b->q + c];
        status = mbsri_position_of(w->m, w->d, i);
        if (!status) status = mbsri_velocity_of(w->m, w->d, i);
    }
    return status;
}

/* V' of one direction: by differences where it moves bodies or turns joints, with the motion of the
 * predecessor elsewhere; what may be rounding is zero. The data is, and stays, at mbsri_velocities
 * of the state. */
static int velocity_change(mbsri_null_space *w, const double *q, int l)
{
    const mbsr_model *m = w->m;
    const mbsr_data *d = w->d;
    const double *rate = w->element.q_rate + (size_t)l * (size_t)m->nq;
    double *change = w->element.V_rate + (size_t)l * m->size.v;
    const double h = 1e-3 * mbsri_unit_step(m->nq, rate, q, w->scale.q);
    const int count = find_touched(w, l);
    int status = MBSR_OK;
    for (int k = 0; k < 4 && !status; ++k) {
        status = place_bodies(w, count, q, rate, mbsri_difference_place(k) * h);
        for (int n = 0; n < count; ++n) {
            const mbsri_body *b = m->body + w->element.touched[n];
            for (size_t c = b->v; c < b->v + (size_t)b->d; ++c)
                change[c] += mbsri_difference_weight(k) / (12.0 * h) * d->V[c];
        }
    }
    if (!status) status = place_bodies(w, count, q, rate, 0.0);
    for (int i = w->sums.head[l], n = 0; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double *own = change + b->v;
        if (n < count && w->element.touched[n] == i) {
            const double size = mbsri_largest(b->d, d->V + b->v) / h;
            for (int c = 0; c < b->d; ++c) {
                if (fabs(own[c]) <= 10.0 * rounding * size) own[c] = 0.0;
            }
            ++n;
        } else if (mbsri_largest(b->pred.d, change + b->pred.v) > 0.0) {
            mbsri_ax(b->d, b->pred.d, -1.0, d->H + b->dp, change + b->pred.v, own);
        }
    }
    return status;
}

/* Whether some element with derivatives of its own sees velocities of bodies. */
static bool bodies_seen(const mbsri_null_space *w)
{
    const mbsri_force *force = w->m->forces.data;
    bool some = false;
    for (size_t k = 0; k < w->m->forces.count; ++k)
        some = some || (w->loads.own[k] && !(force[k].def.table->flags & MBSR_FORCE_JOINT_ONLY));
    return some;
}

int mbsri_element_slopes(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const mbsr_model *m = w->m;
    int status = mbsri_positions(m, w->d, t, q);
    if (!status) status = mbsri_velocities(m, w->d, u);
    mbsri_zero(m->size.v * (size_t)w->k, w->element.V_rate);
    const int changes = bodies_seen(w) ? w->k : 0;
    for (int l = 0; l < changes && !status; ++l) status = velocity_change(w, q, l);
    for (size_t k = 0; k < m->forces.count && !status; ++k) {
        if (w->loads.own[k]) status = add_element(w, (int)k);
    }
    return status;
}

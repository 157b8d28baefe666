/* Which joints the recursion eliminates as one block: see groups.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A joint is open where it moves nothing of the mass of its own body: its body has no mass, or has
 * it on the axis of the joint; joints of several axes are looked at in one position without
 * symmetry. The rank of D of an open joint is up to what hangs on it and may pass from one such
 * joint to the next as these move. So open joints next to each other are one group, unless nothing
 * behind them has any mass: then D is zero for good. Others have what they move themselves: where
 * that is less than all of D, as of a mass point on a ball joint, the rest mostly stays as it is.
 *
 * A group has up to MOST bodies and joint rates, which is more than what dummy bodies in place of
 * one joint have. */
#include "assembly/groups.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "assembly/data.h"
#include "assembly/survey.h"
#include "base/memory.h"
#include "sweeps/tree.h"

#include <math.h>

enum { MOST = MBSRI_GROUP_MOST };

/* Mass that does not exceed this part of what it is made of may be rounding. */
static const double least = 1e-8;

/* Whether a joint of one axis moves its body's own mass. */
static bool turns_mass(const mbsri_sweep_body *b)
{
    if (b->flags & MBSRI_TURNS)
        return b->I[10] > least * (b->I[0] + b->I[5]) || (b->pitch != 0.0 && b->c[3] > 0.0);
    if (b->flags & MBSRI_SLIDES) return b->c[3] > 0.0;
    return b->c[3] > 0.0 || b->I[0] + b->I[5] + b->I[10] > 0.0; /* held fast */
}

/* Whether the joint is of one axis, of a body that is not welded to another. */
static bool one_axis(const mbsr_model *m, int i)
{
    return m->tree.plain && !(m->tree.plain->body[i].flags & (MBSRI_BLOCK | MBSRI_MULTI));
}

/* Whether the joint moves mass in the position of the data; without freedom, whether there is any.
 */
static bool moves_mass(const mbsri_body *b, const mbsr_data *d)
{
    const double *M = d->M + b->dd;
    double *U = d->scratch;
    for (int k = 0; k < b->d && b->n == 0; ++k) {
        if (M[k * (b->d + 1)] > 0.0) return true;
    }
    for (int k = 0; k < b->n; ++k) {
        const double *J = d->J + b->dn + (size_t)(k * b->d);
        double size = 0.0;
        for (int l = 0; l < b->d; ++l) size += fabs(J[l]) * sqrt(fabs(M[l * (b->d + 1)]));
        mbsri_zero((size_t)b->d, U);
        mbsri_ax(b->d, b->d, 1.0, M, J, U);
        if (mbsri_dot(b->d, J, U) > least * size * size) return true;
    }
    return false;
}

/* Which of the joints marked are not open after all, by a position without symmetry; all where
 * their functions do not give one. False: no memory. */
static bool look_at_positions(mbsr_model *m, int *open)
{
    mbsr_data *d;
    if (mbsr_data_create(m, &d, NULL)) return false;
    const bool there = mbsri_survey_position(m, d);
    for (int i = 1; i <= m->bodies && there; ++i) {
        if (open[i] && !one_axis(m, i)) open[i] = !moves_mass(m->body + i, d);
    }
    mbsr_data_destroy(d);
    return true;
}

/* Whether every rate of the joint has armature, which is inertia of its own. */
static bool has_armature(const mbsri_body *b)
{
    bool every = b->n > 0;
    for (int k = 0; k < b->n; ++k) every = every && b->mass.armature[k] > 0.0;
    return every;
}

/* open (bodies + 1): whether the joints are. False: no memory. */
static bool find_open(mbsr_model *m, int *open)
{
    bool unknown = false;
    for (int i = 1; i <= m->bodies; ++i) {
        open[i] = i <= m->live && !m->body[i].mass.regular && !has_armature(m->body + i) &&
                  (!one_axis(m, i) || !turns_mass(m->tree.plain->body + i));
    }
    open[0] = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        const int parent = m->body[i].parent;
        unknown = unknown || (open[i] && open[parent] && !(one_axis(m, i) && one_axis(m, parent)));
    }
    return !unknown || look_at_positions(m, open);
}

static bool massless(const mbsri_body *b)
{
    const mbsr_inertia *inertia = &b->inertia;
    if (b->mass.added) return false;
    switch (inertia->kind) {
    case MBSR_INERTIA_NOT_GIVEN: return true;
    case MBSR_INERTIA_PARTICLE: return inertia->mass == 0.0;
    case MBSR_INERTIA_PLANAR: return inertia->mass == 0.0 && inertia->moment == 0.0;
    case MBSR_INERTIA_SPATIAL:
        return inertia->mass == 0.0 && mbsri_largest(6, inertia->tensor) == 0.0;
    case MBSR_INERTIA_MATRIX:
        return !inertia->matrix || mbsri_largest(b->d * b->d, inertia->matrix) == 0.0;
    case MBSR_INERTIA_FUNCTION:
    case MBSR_INERTIA_FLEXIBLE:
    case MBSR_INERTIA_INVALID: break;
    }
    return false;
}

/* Heads. work: 5 (bodies + 1), all zero. A head's members and n count its group while this
 * grows: that of a body is added to those of all its successors or, where this is too much, to none
 * of them, so that the order of bodies does not matter. False: no memory. */
static bool grow_groups(mbsr_model *m, int *work)
{
    const int bodies = m->bodies;
    int *open = work, *alive = open + bodies + 1, *rates = alive + bodies + 1,
        *behind = rates + bodies + 1, *cut = behind + bodies + 1;
    if (!find_open(m, open)) return false;
    for (int i = bodies; i >= 1; --i) {
        mbsri_body *b = m->body + i;
        cut[i] = b->group.n + rates[i] > MOST || b->group.members + behind[i] > MOST;
        if (!cut[i]) {
            b->group.n += rates[i];
            b->group.members += behind[i];
        }
        alive[i] = alive[i] || !massless(b);
        if (!alive[i] || b->parent == 0) continue;
        alive[b->parent] = 1;
        if (!open[i] || !open[b->parent]) continue;
        b->group.head = b->parent;
        rates[b->parent] += b->group.n;
        behind[b->parent] += b->group.members;
    }
    for (int i = 1; i <= bodies; ++i) {
        mbsri_body *b = m->body + i;
        if (b->group.head != i)
            b->group.head = cut[b->group.head] ? i : m->body[b->group.head].group.head;
    }
    return true;
}

/* Members, head by head. next: bodies + 1. */
static void list_members(mbsr_model *m, int bodies, int *next)
{
    int at = 0;
    for (int i = 1; i <= bodies; ++i) m->body[i].group.members = 0;
    for (int i = 1; i <= bodies; ++i) ++m->body[m->body[i].group.head].group.members;
    for (int i = 1; i <= bodies; ++i) {
        next[i] = at;
        at += m->body[i].group.members;
    }
    for (int i = 1; i <= bodies; ++i) {
        mbsri_body *b = m->body + i;
        b->group.at = next[b->group.head]++;
        m->order.member[b->group.at] = i;
    }
}

/* The group of head i takes its places behind those already placed; blocks are of its own size. */
static void place_group(mbsr_model *m, int i, mbsri_lengths *used)
{
    mbsri_body *b = m->body + i;
    b->group.n = b->group.nq = 0;
    for (int k = 0; k < b->group.members; ++k) {
        mbsri_body *member = m->body + m->order.member[b->group.at + k];
        member->group.iu = (int)used->rates;
        member->group.iq = (int)used->coordinates;
        used->rates += (size_t)member->n;
        used->coordinates += (size_t)member->nq;
        b->group.n += member->n;
        b->group.nq += member->nq;
    }
    for (int k = 0; k < b->group.members; ++k) {
        mbsri_body *member = m->body + m->order.member[b->group.at + k];
        if (k > 0) member->group.n = member->n, member->group.nq = member->nq;
        member->nn = used->nn;
        member->dg = used->dg;
        used->nn += (size_t)member->group.n * (size_t)member->group.n;
        used->dg += (size_t)member->d * (size_t)member->group.n;
    }
    m->order.grouped = m->order.grouped || b->group.members > 1;
    if (b->group.n > m->most.n) m->most.n = b->group.n;
    if (b->group.n > m->most.d) m->most.d = b->group.n;
}

/* Vectors by groups and blocks, of groups with bodies in the sweeps first. */
static void place_all(mbsr_model *m, int bodies, int *seen)
{
    mbsri_lengths used = {0};
    for (int i = 0; i <= bodies; ++i) seen[i] = 0;
    for (int i = 1; i <= bodies; ++i) {
        if (m->body[i].survey.in_sweeps) seen[m->body[i].group.head] = 1;
    }
    for (int wanted = 1; wanted >= 0; --wanted) {
        for (int i = 1; i <= bodies; ++i) {
            if (m->body[i].group.head == i && seen[i] == wanted) place_group(m, i, &used);
        }
        if (wanted == 0) continue;
        m->in_sweeps.rates = used.rates;
        m->in_sweeps.coordinates = used.coordinates;
        m->in_sweeps.nn = used.nn;
        m->in_sweeps.dg = used.dg;
    }
    m->size.rates = used.rates;
    m->size.nn = used.nn;
    m->size.dg = used.dg;
}

bool mbsri_groups_build(mbsr_model *m)
{
    const int bodies = m->bodies;
    int *work = mbsri_allocate(&m->allocator, 5 * ((size_t)bodies + 1) * sizeof *work);
    m->order.member = mbsri_allocate(&m->allocator, (size_t)bodies * sizeof *m->order.member);
    bool built = work && m->order.member;
    if (built) {
        for (int i = 0; i <= bodies; ++i) m->body[i].group.head = i;
        list_members(m, bodies, work);
        place_all(m, bodies, work);
        for (int i = 0; i <= bodies; ++i) m->body[i].group.members = 1;
        for (int i = 0; i < 5 * (bodies + 1); ++i) work[i] = 0;
        built = grow_groups(m, work);
    }
    if (built) {
        list_members(m, bodies, work);
        place_all(m, bodies, work);
    }
    mbsri_release(&m->allocator, work);
    return built;
}

bool mbsri_groups_place(mbsr_model *m)
{
    const int bodies = m->bodies;
    int *old = mbsri_allocate(&m->allocator, 2 * ((size_t)bodies + 1) * sizeof *old);
    double *scale =
        m->typical.inertia ? mbsri_allocate(&m->allocator, (size_t)m->nu * sizeof *scale) : NULL;
    const bool memory = old && (scale || !m->typical.inertia);
    if (memory) {
        for (int i = 1; i <= bodies; ++i) old[i] = m->body[i].group.iu;
        place_all(m, bodies, old + bodies + 1);
    }
    for (int i = 1; i <= bodies && memory && scale; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k) scale[b->group.iu + k] = m->typical.inertia[old[i] + k];
    }
    mbsri_release(&m->allocator, old);
    mbsri_release(&m->allocator, memory ? m->typical.inertia : scale);
    if (memory) m->typical.inertia = scale;
    return memory;
}

/* What is found out about a tree in a position without symmetry: see survey.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Where the joint block D of several rates lacks some of its rank, projections on its range are
 * taken in coordinates u_k / s_k (recursion/rank.c), with
 *
 *   s_k = (a_k + sum_l J_lk^2 c_l)^(-1/2),   c_i = diag(M_i) + sum_j (H_j^2)^T c_j
 *
 * (squares entry by entry): about the inertia that rate k of the joint moves at q = 0 when all
 * joints behind it are held, made of sums in which nothing cancels. These are numbers of the model
 * and not of the state, so that projections are as smooth as D, and those of the sweeps are those
 * of the stages; and they depend neither on units nor on the order of bodies. A rate that moves
 * nothing at q = 0 gets the least s of its joint, else of its group, else of its kind, each beside
 * its span (recursion/spans.h). The multipliers of position rows are weighed by the same inertias,
 * w_k = s_k^2.
 *
 * Joints like that, and groups that have to be eliminated in one piece, are not taken apart in the
 * sweeps: their bodies are `whole`, those of such groups `coupled` too. Whole are also joints of
 * several axes behind joints without inertia, whose Newton systems are those of blocks. */
#include "assembly/survey.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "assembly/data.h"
#include "base/memory.h"
#include "recursion/backward.h"
#include "recursion/exact.h"
#include "recursion/group.h"
#include "recursion/kinematics.h"
#include "recursion/spans.h"
#include "sweeps/tree.h"

#include <math.h>

bool mbsri_survey_position(const mbsr_model *m, mbsr_data *d)
{
    for (int k = 0; k < m->nq; ++k) d->q_base[k] = 0.4 + 0.3 * sin(1.0 + 2.0 * k);
    mbsri_zero((size_t)m->nu, d->u_base);
    return !mbsri_positions(m, d, 0.0, d->q_base) && !mbsri_velocities(m, d, d->u_base);
}

bool mbsri_survey_zero(const mbsr_model *m, mbsr_data *d)
{
    mbsri_zero((size_t)m->nq, d->q_base);
    mbsri_zero((size_t)m->nu, d->u_base);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        if (b->nq > b->n) d->q_base[b->q] = 1.0;
    }
    return !mbsri_positions(m, d, 0.0, d->q_base) && !mbsri_velocities(m, d, d->u_base);
}

/* The inertia that each joint rate moves times the square of its span, into x (nu, in the order of
 * the sweeps): masses times squares of lengths, whatever the rate is. Overwrites imp, which is c.
 */
static void find_inertias(const mbsr_model *m, mbsr_data *d, double *x)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double *c = d->imp;
    for (int i = 0; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->d; ++k) c[b->v + (size_t)k] = d->M[b->dd + (size_t)(k * (b->d + 1))];
    }
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const double *own = c + b->v, *J = d->J + b->dn, *H = d->H + b->dp;
        for (int k = 0; k < b->n; ++k) {
            const double span = mbsri_coordinate_span(&spans, m, b, true, k);
            double *inertia = x + b->iu + k;
            *inertia = b->mass.armature[k];
            for (int l = 0; l < b->d; ++l) *inertia += J[k * b->d + l] * own[l] * J[k * b->d + l];
            *inertia *= span * span;
        }
        for (int k = 0; k < b->pred.d; ++k) {
            for (int l = 0; l < b->d; ++l)
                c[b->pred.v + (size_t)k] += H[k * b->d + l] * own[l] * H[k * b->d + l];
        }
    }
}

enum { KINDS = 3 };

/* What rounding of positions leaves of an inertia on the axis that it turns about, beside a usual
 * one. */
static const double trace = 1e-28;

/* The largest inertia of each kind of rate; of kinds without, what is typical of the model: of one
 * without mass that of a unit of it. */
static void find_largest_inertia(const mbsr_model *m, const double *inertia, double *largest)
{
    const double length = mbsri_spans_of(m, NULL).length,
                 mass = m->typical.mass > 0.0 ? m->typical.mass : 1.0,
                 usual = mass * length * length;
    mbsr_coordinate_kind kind[MBSR_MAX_D];
    for (int k = 0; k < KINDS; ++k) largest[k] = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsr_body_coordinate_kinds(m, b->id, NULL, kind);
        for (int k = 0; k < b->n; ++k) {
            double *most = largest + (int)kind[k];
            *most = fmax(*most, inertia[b->iu + k]);
        }
    }
    for (int k = 0; k < KINDS; ++k) {
        if (!(largest[k] > trace * usual)) largest[k] = usual;
    }
}

/* s of all joint rates, by groups, from their inertias. */
static void find_scale(const mbsr_model *m, const double *inertia)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    mbsr_coordinate_kind kind[MBSR_MAX_D];
    double of_kind[KINDS];
    find_largest_inertia(m, inertia, of_kind);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const double *own = inertia + b->iu;
        double *s = m->typical.inertia + b->group.iu, largest = 0.0, most = 0.0;
        const mbsri_group g = mbsri_group_in_model(m, b->group.head);
        mbsr_body_coordinate_kinds(m, b->id, NULL, kind);
        for (int k = 0; k < b->n; ++k) {
            if (own[k] > trace * of_kind[(int)kind[k]]) largest = fmax(largest, own[k]);
        }
        for (int l = 0; l < g.members && !(largest > 0.0); ++l) {
            const mbsri_body *other = m->body + g.member[l];
            for (int k = 0; k < other->n; ++k) most = fmax(most, inertia[other->iu + k]);
        }
        if (!(largest > 0.0)) largest = most;
        for (int k = 0; k < b->n; ++k) {
            const double usual = of_kind[(int)kind[k]], other = largest > 0.0 ? largest : usual;
            s[k] = mbsri_coordinate_span(&spans, m, b, true, k) /
                   sqrt(own[k] > trace * usual ? own[k] : other);
        }
    }
}

/* The weights w of the multipliers of position rows (forms/loops.c): inverse inertias, of rates
 * that move little a thousandth of the largest of their kind. */
static void find_weights(const mbsr_model *m, const double *inertia, double *weight)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double largest[KINDS];
    mbsr_coordinate_kind kind[MBSR_MAX_D];
    find_largest_inertia(m, inertia, largest);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsr_body_coordinate_kinds(m, b->id, NULL, kind);
        for (int k = 0; k < b->n; ++k) {
            const double span = mbsri_coordinate_span(&spans, m, b, true, k);
            weight[b->iu + k] =
                span * span / fmax(inertia[b->iu + k], 1e-3 * largest[(int)kind[k]]);
        }
    }
}

void mbsri_inverse_inertias(const mbsr_model *m, mbsr_data *d, double *weight)
{
    find_inertias(m, d, d->vec);
    find_weights(m, d->vec, weight);
}

/* Whether the eigenvalues of a group that are kept are large, and the others nothing but rounding
 * of positions or, where masses were given with errors, of these: then as many large ones in
 * another position are all that there are. The data holds exact masses. */
static bool clear_cut(const mbsr_data *d, const mbsri_group *g, bool given)
{
    static const double large = 1e-6, rounding = 1e-26;
    const int rank = mbsri_group_rank(d, g);
    bool clear = true;
    for (int k = 0; k < g->n; ++k) {
        const double lambda = d->judged[g->ig + k];
        clear = clear && (k < rank ? lambda > large : given || lambda < rounding);
    }
    return clear;
}

/* Which bodies are whole, and which groups, by their ranks. */
static void mark(mbsr_model *m, mbsr_data *d, bool exact, bool *behind)
{
    const bool given = mbsri_given_with_errors(m, d);
    behind[0] = false;
    for (int i = 1; i <= m->bodies; ++i) {
        mbsri_body *b = m->body + i;
        const mbsri_group g = mbsri_group_in_model(m, b->group.head);
        const bool lacks = d->rank[i] < b->n;
        b->survey.rank = exact && clear_cut(d, &g, given) ? d->rank[i] + 1 : 0;
        behind[i] = behind[b->parent] || lacks;
        b->group.coupled = g.members > 1 && mbsri_coupled(m, d, &g);
        b->survey.whole = b->group.coupled || (b->n > 1 && behind[i]);
        behind[i] = behind[i] || b->survey.whole;
    }
}

/* Whether the sweeps could take the joint of body i, a user's, for one of theirs. */
static bool may_be_users(const mbsr_model *m, int i)
{
    const mbsri_body *b = m->body + i;
    const bool above = b->pred.space == MBSR_SPACE_SPATIAL || b->pred.space == MBSR_SPACE_FIXED;
    return m->tree.plain && i <= m->live && m->tree.plain->body[i].flags & MBSRI_BLOCK &&
           b->joint.space == MBSR_SPACE_SPATIAL && above && mbsri_embeds_inertia(b) &&
           b->joint.table->flags & MBSR_JOINT_UNIT_K && b->group.head == i && b->group.members <= 1;
}

static bool any_users(const mbsr_model *m)
{
    bool some = false;
    for (int i = 1; i <= m->bodies && !some; ++i) some = may_be_users(m, i);
    return some && m->bodies <= MBSRI_MOST_SURVEYED;
}

/* Joints of users' whose H is a translation and whose D is regular. */
static void mark_users(mbsr_model *m, const mbsr_data *d)
{
    for (int i = 1; i <= m->bodies; ++i) {
        mbsri_body *b = m->body + i;
        double rho[3];
        b->survey.users = may_be_users(m, i) && !b->survey.whole && d->rank[i] == b->n &&
                          (b->pred.d == 0 || mbsri_is_translation(d->H + b->dp, rho));
    }
}

/* Whether some joint of several rates, or some group, may lack rank. */
static bool concerned(const mbsr_model *m)
{
    bool some = m->order.grouped;
    if (m->bodies > MBSRI_MOST_SURVEYED) return false;
    for (int i = 1; i <= m->bodies && !some; ++i)
        some = !m->body[i].mass.regular && m->body[i].n > 1;
    return some;
}

/* At the position zero; false without memory. Where there is no such position the scale stays
 * unknown, and weights are 1. */
static bool weigh_at_zero(mbsr_model *m, mbsr_data *d, bool ranks)
{
    double *inertia = d->vec;
    const size_t size = (size_t)m->nu * sizeof(double);
    if (ranks) m->typical.inertia = mbsri_allocate(&m->allocator, size);
    if (m->rows > 0) m->typical.weight = mbsri_allocate(&m->allocator, size);
    if ((ranks && !m->typical.inertia) || (m->rows > 0 && !m->typical.weight)) return false;
    for (int k = 0; k < m->nu && m->typical.weight; ++k) m->typical.weight[k] = 1.0;
    if (!mbsri_survey_zero(m, d)) {
        mbsri_release(&m->allocator, m->typical.inertia);
        m->typical.inertia = NULL;
        return true;
    }
    find_inertias(m, d, inertia);
    if (m->typical.inertia) find_scale(m, inertia);
    if (m->typical.weight) find_weights(m, inertia, m->typical.weight);
    return true;
}

bool mbsri_survey(mbsr_model *m)
{
    const bool ranks = concerned(m), users = any_users(m);
    if (!ranks && !users && m->rows == 0) return true;
    mbsr_data *d;
    bool *behind = mbsri_allocate(&m->allocator, (size_t)m->bodies + 1);
    const bool created = mbsr_data_create(m, &d, NULL) == MBSR_OK,
               memory = behind && created && weigh_at_zero(m, d, ranks);
    const bool wanted = memory && (m->typical.inertia || users);
    if (wanted && mbsri_survey_position(m, d) && !mbsri_backward_masses(m, d)) {
        const bool exact = m->typical.inertia && !mbsri_exact_masses(m, d);
        if (m->typical.inertia && (exact || !mbsri_backward_masses(m, d)))
            mark(m, d, exact, behind);
        if (users) mark_users(m, d);
    }
    if (created) mbsr_data_destroy(d);
    mbsri_release(&m->allocator, behind);
    return memory;
}

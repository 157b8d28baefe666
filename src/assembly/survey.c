/* What is found out about a tree in a position without symmetry: see survey.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Where the joint block D of several rates lacks some of its rank, projections on its range are taken
 * in coordinates u_k / s_k (recursion/rank.c), with
 *
 *   s_k = (sum_l J_lk^2 c_l)^(-1/2),   c_i = diag(M_i) + sum_j (H_j^2)^T c_j
 *
 * (squares entry by entry): about the inertia that rate k of the joint moves at q = 0 when all joints
 * behind it are held, made of sums in which nothing cancels. These are numbers of the model and not of
 * the state, so that projections are as smooth as D, and those of the sweeps are those of the stages;
 * and they depend neither on units nor on the order of bodies. A rate that moves nothing at q = 0 gets
 * the s of another one of its joint.
 *
 * Joints like that, and groups that have to be eliminated in one piece, are not taken apart in the
 * sweeps: their bodies are `whole`, those of such groups `coupled` too. Whole are also joints of
 * several axes behind joints without inertia, whose Newton systems are those of blocks. */
#include "assembly/survey.h"

#include "algebra/dense.h"
#include "assembly/data.h"
#include "base/memory.h"
#include "recursion/backward.h"
#include "recursion/group.h"
#include "recursion/kinematics.h"

#include <math.h>

bool mbsri_survey_position(const mbsr_model *m, mbsr_data *d)
{
    for (int k = 0; k < m->nq; ++k) d->q_base[k] = 0.4 + 0.3 * sin(1.0 + 2.0 * k);
    mbsri_zero((size_t)m->nu, d->u_base);
    return !mbsri_positions(m, d, 0.0, d->q_base) && !mbsri_velocities(m, d, d->u_base);
}

/* The position zero; four numbers for three rates count as a quaternion. */
static bool place_zero(const mbsr_model *m, mbsr_data *d)
{
    mbsri_zero((size_t)m->nq, d->q_base);
    mbsri_zero((size_t)m->nu, d->u_base);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        if (b->nq > b->n) d->q_base[b->q] = 1.0;
    }
    return !mbsri_positions(m, d, 0.0, d->q_base) && !mbsri_velocities(m, d, d->u_base);
}

/* s of all joint rates, by groups. Overwrites imp, which is c. */
static void find_scale(const mbsr_model *m, mbsr_data *d)
{
    double *c = d->imp;
    for (int i = 0; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->d; ++k) c[b->v + (size_t)k] = d->M[b->dd + (size_t)(k * (b->d + 1))];
    }
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const double *own = c + b->v, *J = d->J + b->dn, *H = d->H + b->dp;
        double *s = m->scale + b->ig, largest = 0.0;
        for (int k = 0; k < b->n; ++k) {
            s[k] = 0.0;
            for (int l = 0; l < b->d; ++l) s[k] += J[k * b->d + l] * own[l] * J[k * b->d + l];
            largest = fmax(largest, s[k]);
        }
        if (!(largest > 0.0)) largest = 1.0;
        for (int k = 0; k < b->n; ++k) s[k] = 1.0 / sqrt(s[k] > 0.0 ? s[k] : largest);
        for (int k = 0; k < b->d_pred; ++k) {
            for (int l = 0; l < b->d; ++l)
                c[b->pred_v + (size_t)k] += H[k * b->d + l] * own[l] * H[k * b->d + l];
        }
    }
}

/* Which bodies are whole, and which groups, by their ranks. */
static void mark(mbsr_model *m, const mbsr_data *d, bool *behind)
{
    behind[0] = false;
    for (int i = 1; i <= m->bodies; ++i) {
        mbsri_body *b = m->body + i;
        const mbsri_group g = mbsri_group_in_model(m, b->head);
        const bool lacks = d->rank[i] < b->n;
        b->usual = d->rank[i] + 1;
        behind[i] = behind[b->parent] || lacks;
        b->coupled = g.members > 1 && mbsri_coupled(m, d, &g);
        b->whole = b->coupled || (b->n > 1 && behind[i]);
        behind[i] = behind[i] || b->whole;
    }
}

/* Data with all arrays takes some kB a body: of more bodies than these the survey is left out. */
enum { MOST_SURVEYED = 100000 };

/* Whether some joint of several rates, or some group, may lack rank. */
static bool concerned(const mbsr_model *m)
{
    bool some = m->grouped;
    if (m->bodies > MOST_SURVEYED) return false;
    for (int i = 1; i <= m->bodies && !some; ++i) some = !m->body[i].regular && m->body[i].n > 1;
    return some;
}

bool mbsri_survey(mbsr_model *m)
{
    if (!concerned(m)) return true;
    mbsr_data *d;
    m->scale = mbsri_allocate(&m->allocator, (size_t)m->nu * sizeof *m->scale);
    bool *behind = mbsri_allocate(&m->allocator, (size_t)m->bodies + 1);
    const bool memory = m->scale && behind && mbsr_data_create(m, &d, NULL) == MBSR_OK;
    const bool found = memory && place_zero(m, d);
    if (found) {
        find_scale(m, d);
        if (mbsri_survey_position(m, d) && !mbsri_backward_masses(m, d)) mark(m, d, behind);
    } else {
        mbsri_release(&m->allocator, m->scale);
        m->scale = NULL;
    }
    if (memory) mbsr_data_destroy(d);
    mbsri_release(&m->allocator, behind);
    return memory;
}

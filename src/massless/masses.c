/* Masses that stay where they are: see masses.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A body with the centre of mass r off its origin x, turned by R, is where it was, at (x_0, R_0),
 * when
 *
 *   x_0 + R_0 R^T r - x - r = 0,   J (R_0 R^T - R R_0^T)^v = 0
 *
 * so that a point that turns about itself, and a rod about its axis, count as staying. M times the
 * twist (w, x_0 + R_0 R^T r
 * - x - r - w x r) is zero for these. Momenta are kept with their moments about the centre of mass.
 */
#include "massless/masses.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "recursion/inertia.h"
#include "recursion/modal.h"
#include "recursion/pose.h"

#include <mbsrank/joint.h>

size_t mbsri_masses_size(const mbsr_model *m)
{
    return m->size.p + m->size.v + (size_t)m->nq + (size_t)m->nu;
}

void mbsri_masses_place(const mbsr_model *m, double *memory, mbsri_masses *masses)
{
    masses->pose = memory;
    masses->momentum = masses->pose + m->size.p;
    masses->q = masses->momentum + m->size.v;
    masses->u = masses->q + m->nq;
}

/* From the origin of a body to its centre of mass; zero where it has none. */
static void find_centre(const mbsri_body *b, const double *M, double r[3])
{
    r[0] = r[1] = r[2] = 0.0;
    if (mbsri_turns(b->joint.space)) {
        /* M = [. m [r]x; . m I] in the first six rows and columns */
        const size_t d = (size_t)b->d;
        const double mass = (M[3 * d + 3] + M[4 * d + 4] + M[5 * d + 5]) / 3.0;
        if (!(mass > 0.0)) return;
        r[0] = 0.5 * (M[4 * d + 2] - M[5 * d + 1]) / mass;
        r[1] = 0.5 * (M[5 * d] - M[3 * d + 2]) / mass;
        r[2] = 0.5 * (M[3 * d + 1] - M[4 * d]) / mass;
    } else if (b->joint.space == MBSR_SPACE_PLANAR && M[0] > 0.0) {
        r[0] = M[7] / M[0];
        r[1] = -M[6] / M[0];
    }
}

/* The moment of a momentum or force p (d) about another point, at r from the one it is about: plus
 * sign r x. */
static void move_moment(mbsr_space space, double sign, const double r[3], double *p)
{
    if (mbsri_turns(space)) {
        double moment[3];
        mbsri_cross3(r, p + 3, moment);
        mbsri_add3(sign, moment, p);
    } else if (space == MBSR_SPACE_PLANAR) {
        p[2] += sign * (r[0] * p[1] - r[1] * p[0]);
    }
}

void mbsri_masses_note(const mbsr_model *m, mbsr_data *d, const double *q, const double *u,
                       mbsri_masses *masses)
{
    mbsri_copy(m->size.p, d->p, masses->pose);
    mbsri_copy((size_t)m->nq, q, masses->q);
    mbsri_copy((size_t)m->nu, u, masses->u);
    mbsri_zero(m->size.v, masses->momentum);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double r[3], *p = masses->momentum + b->v;
        mbsri_inertia_times(b, d->p + b->p, d->M + b->dd, 1.0, d->V + b->v, p);
        find_centre(b, d->M + b->dd, r);
        move_moment(b->joint.space, -1.0, r, p);
    }
}

/* The twist x (d) that takes a body from pose p to `to`. */
static void find_twist(const mbsri_body *b, const double *p, const double *to, const double r[3],
                       double *x)
{
    if (mbsri_turns(b->joint.space)) {
        double turned[3], arm[3], swing[3];
        const double *R = p + MBSR_POSE_R, *S = to + MBSR_POSE_R;
        for (int k = 0; k < 3; ++k) x[k] = 0.0;
        /* half the sum of cross products of axes before and after */
        for (int k = 0; k < 3; ++k) mbsri_add_cross3(R + 3 * k, S + 3 * k, x);
        for (int k = 0; k < 3; ++k) x[k] *= 0.5;
        mbsri_unrotate3(R, r, arm);
        mbsri_rotate3(S, arm, turned);
        mbsri_cross3(x, r, swing);
        for (int k = 0; k < 3; ++k)
            x[3 + k] = to[MBSR_POSE_X + k] + turned[k] - p[MBSR_POSE_X + k] - r[k] - swing[k];
        for (int k = 6; k < b->d; ++k)
            x[k] = to[MBSR_POSE_SIZE + k - 6] - p[MBSR_POSE_SIZE + k - 6];
    } else if (b->joint.space == MBSR_SPACE_PLANAR) {
        const double turn = to[2] - p[2];
        for (int k = 0; k < 2; ++k) x[k] = to[k] - p[k] + (cos(turn) - 1.0) * r[k];
        x[2] = sin(turn);
    } else {
        for (int k = 0; k < b->d; ++k) x[k] = to[k] - p[k];
    }
}

/* p (nu) from minus the momenta of bodies in d->imp, on which what is behind them is piled up. */
static void gather(const mbsr_model *m, mbsr_data *d, double *p)
{
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const double *imp = d->imp + b->v;
        mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, imp, d->imp + b->pred.v);
        mbsri_add_rates(b, d->J + b->dn, imp, p + b->u);
    }
}

void mbsri_masses_displacement(const mbsr_model *m, mbsr_data *d, const mbsri_masses *masses,
                               const double *q, double *p)
{
    double *x = d->scratch;
    mbsri_zero(m->size.v, d->imp);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double r[3];
        find_centre(b, d->M + b->dd, r);
        find_twist(b, d->p + b->p, masses->pose + b->p, r, x);
        mbsri_inertia_times(b, d->p + b->p, d->M + b->dd, -1.0, x, d->imp + b->v);
        /* coordinates of joints with inertia of their own, but for quaternions, which bodies tell
         */
        for (int k = 0; k < b->n; ++k) {
            const double off = b->n == b->nq ? masses->q[b->q + k] - q[b->q + k] : 0.0;
            p[b->u + k] = b->mass.armature[k] * off;
        }
    }
    gather(m, d, p);
}

void mbsri_masses_momenta(const mbsr_model *m, mbsr_data *d, const mbsri_masses *masses, double *p)
{
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double r[3], *imp = d->imp + b->v;
        mbsri_copy((size_t)b->d, masses->momentum + b->v, imp);
        find_centre(b, d->M + b->dd, r);
        move_moment(b->joint.space, 1.0, r, imp);
        for (int k = 0; k < b->d; ++k) imp[k] = -imp[k];
        for (int k = 0; k < b->n; ++k) p[b->u + k] = b->mass.armature[k] * masses->u[b->u + k];
    }
    mbsri_zero((size_t)m->body[0].d, d->imp + m->body[0].v);
    gather(m, d, p);
}

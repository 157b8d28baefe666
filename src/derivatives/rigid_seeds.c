/* Parameters in derivatives of trees of rigid bodies: see rigid_seeds.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "derivatives/rigid_seeds.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "base/memory.h"
#include "model/query.h"
#include "recursion/elements.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "sweeps/build.h"

#include <stdint.h>
#include <string.h>

enum { FRAME = sizeof(mbsri_rigid_frame) / sizeof(double) };

/* ---- memory ---- */

static bool reaches_weld(const mbsri_seeded *p, const mbsr_model *m)
{
    const mbsr_parameter_owner owner = p->parameter.info.owner;
    if (owner == MBSR_PARAMETER_BODY) return p->index > m->live;
    if (owner != MBSR_PARAMETER_FORCE || p->index < 0) return false;
    const mbsri_force *force = mbsri_force_at(m, (size_t)p->index);
    bool found = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) && m->live < m->bodies;
    for (int j = 0; j < force->def.bodies && !found; ++j)
        found = m->stored.list_index[force->list + (size_t)j] > m->live;
    return found;
}

bool mbsri_rigid_seeds_serve(const mbsri_seeds *s, const mbsr_model *m)
{
    bool serve = true;
    for (int k = 0; k < s->count && serve; ++k) serve = !reaches_weld(s->of + k, m);
    return serve;
}

/* Numbers the bodies whose frames are chosen; how many. */
static int number_frames(mbsri_seeds *s, int bodies, int *frame)
{
    int frames = 0;
    for (int i = 0; i <= bodies; ++i) frame[i] = -1;
    for (size_t j = 0; j < s->seeds; ++j) {
        mbsri_seed *seed = s->seed + j;
        if (seed->place != MBSRI_SEED_MOTION) continue;
        if (frame[seed->at] < 0) frame[seed->at] = frames++;
        seed->at = (size_t)frame[seed->at] * FRAME;
    }
    return frames;
}

mbsri_rigid_seeds *mbsri_rigid_seeds_create(const mbsr_model *m, mbsri_seeds *s)
{
    const size_t bodies = (size_t)m->live + 1;
    mbsri_rigid_seeds *r = mbsri_allocate(&m->allocator, sizeof *r);
    if (!r) return NULL;
    *r = (mbsri_rigid_seeds){.active = false};
    r->frame = mbsri_allocate(&m->allocator, bodies * sizeof *r->frame);
    const size_t frames = r->frame ? (size_t)number_frames(s, m->live, r->frame) : 0,
                 count = 2 * frames * FRAME + bodies * (8 + 6);
    if (r->frame) r->memory = mbsri_allocate(&m->allocator, (count + 4) * sizeof(double));
    if (!r->memory) {
        mbsri_rigid_seeds_destroy(r, m);
        return NULL;
    }
    const uintptr_t past = (uintptr_t)r->memory % 32;
    double *next = (double *)(void *)((unsigned char *)r->memory + (32 - past));
    mbsri_zero(count, next);
    r->sum = (mbsri_rigid_frame *)(void *)next;
    r->by = r->sum + frames;
    r->load = next + 2 * frames * FRAME;
    r->own = (double(*)[3])(void *)(r->load + 8 * bodies);
    r->arm = r->own + bodies;
    for (int i = 1; i <= m->live; ++i) mbsri_sweeps_own_origin(m->tree.evaluated, m, i, r->own[i]);
    s->sum[MBSRI_SEED_MOTION] = r->sum->x[0];
    s->length[MBSRI_SEED_MOTION] = frames * FRAME;
    return r;
}

void mbsri_rigid_seeds_destroy(mbsri_rigid_seeds *r, const mbsr_model *m)
{
    if (!r) return;
    const mbsr_allocator allocator = m->allocator;
    if (r->frame) mbsri_release(&allocator, r->frame);
    if (r->memory) mbsri_release(&allocator, r->memory);
    mbsri_release(&allocator, r);
}

/* ---- at the state ---- */

/* a -= w x r. */
static void less_cross(const double w[3], const double r[3], double a[3])
{
    double c[3];
    mbsri_cross3(w, r, c);
    mbsri_add3(-1.0, c, a);
}

/* Changes x of pose, V and A (angular parts first) of a body at its own origin, where v and a are
 * as given, to those at its point as seen in the moving body. */
static void see_frame(const mbsri_sweep_state *s, const double arm[3], const double v[3],
                      const double a[3], const double x[18], mbsri_rigid_frame *to)
{
    const double *theta = x, *omega = s->omega, *alpha = s->A_w;
    double swing[3], turn[3], still[3];
    memcpy(to->motion[0], theta, 3 * sizeof *theta);
    memcpy(to->motion[1], x + 3, 3 * sizeof *x);
    memcpy(to->x[0], x + 6, 3 * sizeof *x);
    memcpy(to->motion[2], x + 9, 3 * sizeof *x);
    memcpy(to->x[1], x + 12, 3 * sizeof *x);
    memcpy(to->x[2], x + 15, 3 * sizeof *x);
    less_cross(theta, arm, to->motion[1]);
    less_cross(theta, omega, to->x[0]);
    less_cross(theta, alpha, to->x[1]);
    less_cross(theta, v, to->motion[2]);
    less_cross(theta, a, to->x[2]);
    /* v - omega x arm, a - alpha x arm - omega x (omega x arm), arm fixed in the body */
    less_cross(to->x[0], arm, to->motion[2]);
    less_cross(to->x[1], arm, to->x[2]);
    mbsri_cross3(omega, arm, swing);
    mbsri_cross3(to->x[0], arm, turn);
    less_cross(to->x[0], swing, to->x[2]);
    less_cross(omega, turn, to->x[2]);
    /* the sweeps take gravity for an acceleration, which does not turn with the body */
    memcpy(still, a, sizeof still);
    less_cross(alpha, arm, still);
    less_cross(omega, swing, still);
    mbsri_add3(-1.0, s->A_v, still);
    mbsri_add_cross3(theta, still, to->x[2]);
}

/* C += x* f of a turn and a displacement of the point, and a force there. */
static void turn_force(const double theta[3], const double shift[3], const double f[6], double C[8])
{
    mbsri_add_cross3(theta, f, C);
    mbsri_add_cross3(shift, f + 3, C);
    mbsri_add_cross3(theta, f + 3, C + 4);
}

static int frame_value(mbsr_derivatives *w, const mbsri_seeded *p, mbsri_rigid_frame *to)
{
    mbsr_data *d = w->data;
    const mbsri_body *b = w->model->body + p->index;
    const double *arm = w->rigid->seeds->arm[p->index];
    double V[6], A[6], mu[6], f[6], x[18];
    bool behind;
    const int status = mbsri_frame_change(p, w->model, d, x, &behind);
    if (status) return status;
    mbsri_lift(b->d, d->V + b->v, V);
    mbsri_lift(b->d, d->A + b->v, A);
    mbsri_lift(b->d, d->mu + b->v, mu);
    for (int k = 0; k < 6; ++k) f[k] = -mu[k];
    mbsri_add_cross3(arm, f + 3, f);
    double theta[3], back[3] = {-x[0], -x[1], -x[2]}, shift[3];
    memcpy(theta, x, sizeof theta);
    memcpy(shift, x + 3, sizeof shift);
    less_cross(theta, arm, shift);
    turn_force(theta, shift, f, to->C[behind]);
    if (b->joint.space == MBSR_SPACE_POINT) { /* whose axes do not turn: it turns back behind */
        mbsri_cross3(theta, arm, shift);
        turn_force(back, shift, f, to->C[1]);
        memset(x, 0, sizeof theta);
    }
    see_frame(d->sweep.state + p->index, arm, V + 3, A + 3, x, to);
    return MBSR_OK;
}

int mbsri_rigid_seeds_find(mbsr_derivatives *w, double t, const double *q, const double *u,
                           const double *udot)
{
    const mbsr_model *m = w->model;
    mbsr_data *d = w->data;
    mbsri_seeds *s = &w->rigid_seed;
    const mbsri_pending pending = d->pending;
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_forces(m, d, NULL, NULL);
    if (status) return status;
    mbsri_inverse(m, d, udot);
    for (int i = 1; i <= m->live; ++i) {
        const double *R = d->sweep.state[i].R, *own = w->rigid->seeds->own[i];
        double *arm = w->rigid->seeds->arm[i];
        for (int k = 0; k < 3; ++k) arm[k] = R[k] * own[0] + R[4 + k] * own[1] + R[8 + k] * own[2];
    }
    for (int k = 0; k < s->count && !status; ++k) {
        const mbsri_seeded *p = s->of + k;
        if (p->first == p->last) continue;
        if (p->parameter.info.part != MBSR_PARAMETER_JOINT) {
            status = mbsri_seed_values(s, p, w->linear, d);
            continue;
        }
        mbsri_rigid_frame *to = (mbsri_rigid_frame *)(void *)w->rigid->seeds->sum;
        memset(to, 0, sizeof *to);
        status = frame_value(w, p, to);
        memcpy(s->value + s->seed[p->first].value, to, sizeof *to);
    }
    d->accelerated = false;
    d->stage = MBSRI_STAGE_NONE;
    d->pending = pending; /* as the sweeps have left it */
    return status;
}

/* ---- products ---- */

void mbsri_rigid_seeds_along(mbsr_derivatives *w)
{
    const mbsr_model *m = w->model;
    mbsri_rigid_seeds *r = w->rigid->seeds;
    const double *mu = w->rigid_seed.sum[MBSRI_SEED_REACTION];
    for (int i = 1; i <= m->live; ++i) {
        const mbsri_body *b = m->body + i;
        double f[6], *load = r->load + 8 * i;
        mbsri_lift(b->d, mu + b->v, f);
        mbsri_add_cross3(r->arm[i], f + 3, f);
        memcpy(load, f, 3 * sizeof *f);
        memcpy(load + 4, f + 3, 3 * sizeof *f);
    }
    for (int k = 0; k < m->nu; ++k)
        w->torque[k] = w->rigid_seed.sum[MBSRI_SEED_TORQUE][k] -
                       w->rigid_seed.sum[MBSRI_SEED_LOAD][m->order.u_of[k]];
}

void mbsri_rigid_seeds_back(mbsr_derivatives *w, double sign, const double *weights)
{
    const mbsr_model *m = w->model;
    const mbsri_rigid_seeds *r = w->rigid->seeds;
    mbsri_zero(m->size.v, w->mu);
    for (int i = 1; i <= m->live; ++i) {
        const mbsri_body *b = m->body + i;
        const double *Y = w->rigid->work[i].f;
        double f[6] = {-Y[0], -Y[1], -Y[2], -Y[4], -Y[5], -Y[6]};
        mbsri_add_cross3(f, r->arm[i], f + 3);
        mbsri_lower(b->d, f, w->mu + b->v);
    }
    for (int k = 0; k < m->nu; ++k) w->torque[k] = -weights[m->order.u_of[k]];
    const double *const gradient[MBSRI_SEED_PLACES] = {r->by->x[0], w->mu, w->torque, weights,
                                                       w->lambda};
    mbsri_seeds_back(&w->rigid_seed, gradient);
    for (int k = 0; k < w->rigid_seed.count; ++k) w->rigid_seed.by[k] *= sign;
}

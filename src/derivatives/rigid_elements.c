/* Force elements in derivatives of trees of rigid bodies: see rigid_elements.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Elements know bodies by their own frames, along the world's axes: of body i, whose own origin is
 * `arm` from its point, with theta and xi the rotation and the displacement of that point along dq,
 *
 *   theta = theta_pi + sum S_w x,   xi = xi_pi + theta_pi x r + sum S_v x
 *   dv = dv_pi + domega_pi x r + sum (S_v y + (T_v + v_pi x S_w) x)      seen in the moving body
 *   own pose: (theta, xi + theta x arm),   own V: (domega + theta x omega,
 *       dv + domega x arm + theta x v_own),   load: df - theta x f, its moment + arm x force */
#include "derivatives/rigid_elements.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "recursion/kinematics.h"
#include "sweeps/embed.h"

#include <string.h>

/* ---- at the state ---- */

static void keep_body(const mbsr_derivatives *w, int i)
{
    const mbsri_rigid *r = w->rigid;
    const mbsr_data *d = w->data;
    const mbsri_body *b = w->model->body + i;
    mbsri_rigid_own *own = r->own + i;
    double V[6];
    memcpy(own->arm, d->sweep.load[i].arm, sizeof own->arm);
    mbsri_lift(b->d, d->V + b->v, V);
    memcpy(own->v_own, V + 3, sizeof own->v_own);
    mbsri_lift(b->d, d->f + b->v, own->f);
}

/* G of q' = G u, by columns. */
static int keep_rates(mbsr_derivatives *w, int i, double *G)
{
    const mbsri_body *b = w->model->body + i;
    double *u = w->data->u + b->iu;
    int status = MBSR_OK;
    for (int k = 0; k < b->n && !status; ++k) {
        mbsri_zero((size_t)b->n, u);
        u[k] = 1.0;
        status = mbsri_coordinate_rates_of(w->model, w->data, i, G + k * b->nq);
    }
    mbsri_copy((size_t)b->n, w->rigid->u + b->iu, u);
    return status;
}

int mbsri_rigid_elements_keep(mbsr_derivatives *w)
{
    const mbsr_model *m = w->model;
    mbsri_rigid *r = w->rigid;
    mbsr_data *d = w->data;
    mbsri_copy((size_t)m->nq, r->q, d->q);
    mbsri_copy((size_t)m->nu, r->u, d->u);
    double *G = r->G;
    int status = MBSR_OK;
    for (int i = 0; i <= r->tree->bodies && !status; ++i) {
        const mbsri_body *b = m->body + i;
        if (r->tree->body_forces) {
            memcpy(r->own[i].v, d->sweep.state[i].v, sizeof r->own[i].v);
            if (i > 0 && r->tree->body[i].flags & MBSRI_LOADED) keep_body(w, i);
        }
        if (i == 0 || !b->joint.table->coordinate_rates) continue;
        status = keep_rates(w, i, G);
        G += b->nq * b->n;
    }
    return status ? status : mbsri_linear_elements(w->linear, d);
}

/* ---- along a direction ---- */

/* dq of q = G x, or with `back` x = G^T dq, added. */
static void turn_rates(const mbsr_derivatives *w, bool back, const double *from, double *to)
{
    const double *G = w->rigid->G;
    for (int i = 1; i <= w->rigid->tree->bodies; ++i) {
        const mbsri_body *b = w->model->body + i;
        const bool plain = !b->joint.table->coordinate_rates;
        for (int k = 0; k < b->n && plain; ++k) {
            if (back)
                to[b->u + k] += from[b->q + k];
            else
                to[b->q + k] = from[b->u + k];
        }
        if (plain) continue;
        if (back) {
            mbsri_atx(b->nq, b->n, 1.0, G, from + b->q, to + b->u);
        } else {
            mbsri_zero((size_t)b->nq, to + b->q);
            mbsri_ax(b->nq, b->n, 1.0, G, from + b->u, to + b->q);
        }
        G += b->nq * b->n;
    }
}

/* theta, xi, domega, dv of body i. */
static void move_seen(const mbsri_rigid *r, int i, const double *dq, const double *du)
{
    const mbsri_rigid_body *b = r->body + i;
    const mbsri_rigid_seeds *s = r->seeds;
    const double *pred = r->motion[b->parent], *v_pred = r->own[b->parent].v;
    double *to = r->motion[i];
    memcpy(to, pred, sizeof r->motion[i]);
    mbsri_add_cross3(pred, b->r, to + 3);
    mbsri_add_cross3(pred + 6, b->r, to + 9);
    for (int k = 0; k < b->n; ++k) {
        const mbsri_rigid_column *c = r->column + b->first + k;
        const double x = dq[c->u], y = du[c->u];
        double drift[3];
        mbsri_cross3(v_pred, c->S, drift);
        for (int l = 0; l < 3; ++l) {
            to[l] += c->S[l] * x;
            to[3 + l] += c->S[4 + l] * x;
            to[6 + l] += c->T[l] * x + c->S[l] * y;
            to[9 + l] += (c->T[4 + l] + drift[l]) * x + c->S[4 + l] * y;
        }
    }
    if (!s || !s->active || s->frame[i] < 0) return;
    const mbsri_rigid_frame *frame = s->sum + s->frame[i];
    mbsri_add3(1.0, frame->motion[0], to);
    mbsri_add3(1.0, frame->motion[1], to + 3);
    mbsri_add3(1.0, frame->x[0], to + 6);
    mbsri_add3(1.0, frame->motion[2], to + 9);
}

/* Pose and V of body i as elements see them. */
static void show_seen(const mbsr_derivatives *w, int i)
{
    const mbsri_rigid *r = w->rigid;
    const mbsri_body *b = w->model->body + i;
    const mbsri_rigid_own *own = r->own + i;
    const double *x = r->motion[i], *omega = r->body[i].omega;
    double pose[6], V[6], *to = w->motion + w->linear->motion[i];
    memcpy(pose, x, sizeof pose);
    memcpy(V, x + 6, sizeof V);
    mbsri_add_cross3(x, own->arm, pose + 3);
    mbsri_add_cross3(x, omega, V);
    mbsri_add_cross3(x + 6, own->arm, V + 3);
    mbsri_add_cross3(x, own->v_own, V + 3);
    mbsri_lower(b->d, pose, to);
    mbsri_lower(b->d, V, to + w->linear->e[i]);
}

static void take_load(const mbsr_derivatives *w, int i)
{
    const mbsri_rigid *r = w->rigid;
    const mbsri_body *b = w->model->body + i;
    const mbsri_rigid_own *own = r->own + i;
    const double *x = r->motion[i];
    double f[6], turned[3], *load = r->load + 8 * i;
    mbsri_lift(b->d, w->mu + b->v, f);
    for (int half = 0; half < 6; half += 3) {
        mbsri_cross3(x, own->f + half, turned);
        mbsri_add3(-1.0, turned, f + half);
    }
    mbsri_add_cross3(own->arm, f + 3, f);
    memcpy(load, f, 3 * sizeof *f);
    memcpy(load + 4, f + 3, 3 * sizeof *f);
}

void mbsri_rigid_elements_along(mbsr_derivatives *w, const double *dq, const double *du)
{
    const mbsr_model *m = w->model;
    mbsri_rigid *r = w->rigid;
    const mbsri_sweeps *tree = r->tree;
    turn_rates(w, false, dq, w->dq);
    memset(r->motion[0], 0, sizeof r->motion[0]); /* the way back adds to what the root sees */
    for (int i = 1; i <= tree->bodies && tree->body_forces; ++i) {
        move_seen(r, i, dq, du);
        if (!(tree->body[i].flags & MBSRI_LOADED)) continue;
        show_seen(w, i);
        mbsri_zero((size_t)m->body[i].d, w->mu + m->body[i].v);
    }
    mbsri_derivatives_elements(w, w->dq, du);
    for (int i = 1; i <= tree->bodies && tree->body_forces; ++i) {
        if (tree->body[i].flags & MBSRI_LOADED) take_load(w, i);
    }
}

/* ---- and back ---- */

/* Weights of the load of body i. */
static void weigh_load(const mbsr_derivatives *w, int i)
{
    const mbsri_rigid *r = w->rigid;
    const mbsri_body *b = w->model->body + i;
    const double *Y = r->work[i].f;
    double by[6] = {-Y[0], -Y[1], -Y[2], -Y[4], -Y[5], -Y[6]};
    mbsri_add_cross3(by, r->own[i].arm, by + 3);
    mbsri_lower(b->d, by, w->mu + b->v);
    double *x = r->motion[i]; /* of theta: by . (-theta x f) */
    mbsri_add_cross3(by, r->own[i].f, x);
    mbsri_add_cross3(by + 3, r->own[i].f + 3, x);
    mbsri_zero((size_t)(w->linear->e[i] + b->d), w->motion + w->linear->motion[i]);
}

/* The gradient by own pose and V to that by theta, xi, domega, dv. */
static void take_gradient(const mbsr_derivatives *w, int i)
{
    const mbsri_rigid *r = w->rigid;
    const mbsri_body *b = w->model->body + i;
    const mbsri_rigid_own *own = r->own + i;
    const double *from = w->motion + w->linear->motion[i];
    double pose[6], V[6], *x = r->motion[i];
    mbsri_lift(b->d, from, pose);
    mbsri_lift(b->d, from + w->linear->e[i], V);
    for (int k = 0; k < 6; ++k) {
        x[k] += pose[k];
        x[6 + k] += V[k];
    }
    mbsri_add_cross3(own->arm, pose + 3, x);
    mbsri_add_cross3(r->body[i].omega, V, x);
    mbsri_add_cross3(own->arm, V + 3, x + 6);
    mbsri_add_cross3(own->v_own, V + 3, x);
}

static void unmove_seen(const mbsri_rigid *r, int i)
{
    const mbsri_rigid_body *b = r->body + i;
    const double *x = r->motion[i], *v_pred = r->own[b->parent].v;
    double *pred = r->motion[b->parent];
    if (r->seeds && r->seeds->frame[i] >= 0) {
        mbsri_rigid_frame *frame = r->seeds->by + r->seeds->frame[i];
        memcpy(frame->motion[0], x, 3 * sizeof *x);
        memcpy(frame->motion[1], x + 3, 3 * sizeof *x);
        memcpy(frame->motion[2], x + 9, 3 * sizeof *x);
    }
    for (int k = 0; k < b->n; ++k) {
        const mbsri_rigid_column *c = r->column + b->first + k;
        double drift[3];
        mbsri_cross3(v_pred, c->S, drift);
        mbsri_add3(1.0, c->T + 4, drift);
        r->by_q[c->u] +=
            mbsri_dot3(c->S, x) + mbsri_dot3(c->S + 4, x + 3) + mbsri_dot3(drift, x + 9);
        r->by_u[c->u] += mbsri_dot3(c->S + 4, x + 9);
    }
    mbsri_add3(1.0, x, pred);
    mbsri_add3(1.0, x + 3, pred + 3);
    mbsri_add3(1.0, x + 9, pred + 9);
    mbsri_add_cross3(b->r, x + 3, pred);
    mbsri_add_cross3(b->r, x + 9, pred + 6);
    mbsri_add3(1.0, x + 6, r->work[i].x[0]);
}

void mbsri_rigid_elements_back(mbsr_derivatives *w, const double *by)
{
    const mbsr_model *m = w->model;
    mbsri_rigid *r = w->rigid;
    const mbsri_sweeps *tree = r->tree;
    const int bodies = tree->body_forces ? tree->bodies : 0;
    memset(r->motion, 0, ((size_t)bodies + 1) * sizeof *r->motion);
    for (int i = 1; i <= bodies; ++i) {
        if (tree->body[i].flags & MBSRI_LOADED) weigh_load(w, i);
    }
    mbsri_zero((size_t)m->nq, w->dq);
    mbsri_zero((size_t)m->nu, r->by_q);
    mbsri_zero((size_t)m->nu, r->by_u);
    mbsri_derivatives_elements_back(w, by, w->dq, r->by_u);
    turn_rates(w, true, w->dq, r->by_q);
    for (int i = bodies; i >= 1; --i) {
        if (tree->body[i].flags & MBSRI_LOADED) take_gradient(w, i);
        unmove_seen(r, i);
    }
}

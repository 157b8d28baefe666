/* Bodies that others than the lanes look at, state by state: with the kernels, since every number
 * of theirs is a vector there.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Blocks (sweeps/block.h) and force elements on bodies have functions for one state. Each lane has
 * data of its own for them, with what the sweeps in one state keep of the bodies in the sweeps
 * (assembly/places.h); a body's numbers are laid down there, and taken up again, one lane after the
 * other. A lane whose functions fail is not served, and its state goes alone. */
#ifndef MBSRI_BATCH_SEEN_H
#define MBSRI_BATCH_SEEN_H

#include "batch/carry.h"

#include "sweeps/block.h"

/* Lanes that hold states, and are served so far. */
#define MBSRI_EACH_LANE(run, l)                                                                    \
    for (int l = 0; l < (run)->count; ++l)                                                         \
        if ((run)->served >> l & 1u)

MBSRI_INLINE void fail(mbsri_batch_run *run, int l)
{
    run->served &= ~(1u << l);
}

/* ---- one lane of a vector ---- */

MBSRI_INLINE void lay(vec x, int l, double *to)
{
    to[0] = x.x[l], to[1] = x.y[l], to[2] = x.z[l];
}

MBSRI_INLINE void take(const double *x, int l, vec *to)
{
    to->x[l] = x[0], to->y[l] = x[1], to->z[l] = x[2];
}

/* ---- motion ---- */

MBSRI_INLINE site *site_of(const mbsri_batch_run *run, int i)
{
    return (site *)run->place + i;
}

static void place_root(const mbsri_batch_run *run)
{
    site *to = site_of(run, 0);
    to->R = (mat){vec_of(run->R), vec_of(run->R + 3), vec_of(run->R + 6)};
    to->r = vec_of(run->r);
    to->v = vec_of(run->v);
    to->angle = splat(run->r[3]);
}

MBSRI_INLINE motion *motion_of(const mbsri_batch_run *run, int i)
{
    return (motion *)run->motion + i;
}

/* Along the axes that the sweeps in one state have. */
MBSRI_INLINE void lay_motion(const mbsri_batch_run *run, int i)
{
    const mbsri_batch_body *b = run->body + i;
    const site *at = site_of(run, i);
    const int body = run->origin[i];
    const lanes c = splat(b->own[0]), s = splat(b->own[1]);
    const vec x = plus(scaled(at->R.x, c), -s, at->R.y), y = plus(scaled(at->R.y, c), s, at->R.x),
              omega = times(&at->R, motion_of(run, i)->omega);
    MBSRI_EACH_LANE(run, l)
    {
        mbsri_sweep_state *to = run->lane[l].state + body;
        double *r = run->lane[l].load[body].r;
        lay(x, l, to->R), lay(y, l, to->R + 4), lay(at->R.z, l, to->R + 8);
        lay(at->rho, l, to->rho), lay(omega, l, to->omega), lay(at->v, l, to->v);
        lay(at->r, l, r);
        r[3] = at->angle[l];
    }
}

static void move_block(mbsri_batch_run *run, int i)
{
    site *at = site_of(run, i);
    const int body = run->origin[i];
    vec omega = no_vec();
    memset(at, 0, sizeof *at);
    MBSRI_EACH_LANE(run, l)
    {
        const mbsri_sweep_run *lane = run->lane + l;
        const mbsri_sweep_state *from = lane->state + body;
        const double *r = lane->load[body].r;
        if (mbsri_block_move(lane, body)) {
            fail(run, l);
            continue;
        }
        take(from->R, l, &at->R.x), take(from->R + 4, l, &at->R.y), take(from->R + 8, l, &at->R.z);
        take(from->omega, l, &omega), take(from->v, l, &at->v);
        take(r, l, &at->r);
        at->angle[l] = r[3];
    }
    motion_of(run, i)->omega = transposed_times(&at->R, omega);
}

/* The angle of a body in the plane, behind its origin. */
static lanes planar_angle(const mbsri_batch_run *run, int body, lanes pred)
{
    const mbsri_sweep_own *own = run->lane->tree->own + body;
    const mbsri_joint *joint = &run->lane->model->body[body].joint;
    if (joint->space != MBSR_SPACE_PLANAR) return splat(0.0);
    const lanes known = pred + splat(own->angle);
    if (own->coordinate >= 0) return known + at(run->q, own->coordinate);
    if (own->coordinate == MBSRI_ANGLE_HELD) return known;
    return known + splat(mbsri_driven_angle(joint, run->lane->data->t));
}

/* The axes of body i, which is no block, from those of its predecessor. */
MBSRI_INLINE mat place_axes(const mbsri_batch_run *run, int i, const ball_state *ball)
{
    const mbsri_batch_body *b = run->body + i;
    const body_state *s = (const body_state *)run->state + i;
    const turn theta = turn_of(s->c, s->s);
    const mat P = site_of(run, b->parent)->R, back = transposed(&P);
    /* rows along the predecessor's axes become rows along the body's */
    const mat rows = {to_own(b, b->flags, &theta, back.x), to_own(b, b->flags, &theta, back.y),
                      to_own(b, b->flags, &theta, back.z)},
              R = transposed(&rows);
    return b->flags & MBSRI_BALL ? product(&R, &ball->R) : R;
}

/* Where body i is, likewise, and the velocity of its origin; omega is known. */
MBSRI_INLINE void place_body(const mbsri_batch_run *run, int i, const ball_state *ball)
{
    const mbsri_batch_body *b = run->body + i;
    const site *from = site_of(run, b->parent);
    const vec omega = times(&from->R, motion_of(run, b->parent)->omega);
    site *to = site_of(run, i);
    to->R = place_axes(run, i, ball);
    to->rho = times(&from->R, arm_of(run, b, b->flags));
    to->r = add(from->r, to->rho);
    to->v = add(from->v, cross(omega, to->rho));
    if (b->flags & MBSRI_SLIDES) {
        const bool moved = (b->flags & MBSRI_MOVED) != 0;
        const lanes u = moved ? splat(run->drive[3 * b->q + 1]) : at(run->u, b->u);
        to->v = plus(to->v, splat(b->pitch) * u, to->R.z);
    }
    to->angle = from->angle;
    if (b->flags & MBSRI_PLANE) to->angle = planar_angle(run, run->origin[i], from->angle);
    if (b->flags & MBSRI_SEEN) lay_motion(run, i);
}

/* ---- leaves to root ---- */

static void lay_carry(const carry *c, int l, mbsri_carry *to)
{
    const mat *G = &c->G;
    *to = (mbsri_carry){
        .I = {c->I.xx[l], c->I.yy[l], c->I.zz[l], 0.0, c->I.yz[l], c->I.xz[l], c->I.xy[l]},
        .G = {G->x.x[l], G->y.y[l], G->z.z[l], 0.0, G->y.x[l], G->z.y[l], G->x.z[l], 0.0, G->z.x[l],
              G->x.y[l], G->y.z[l]},
        .M = {c->M.xx[l], c->M.yy[l], c->M.zz[l], 0.0, c->M.yz[l], c->M.xz[l], c->M.xy[l]},
        .kappa = c->kappa[l],
        .spread = c->spread[l]};
    lay(c->L, l, to->L), lay(c->p, l, to->p);
}

static void take_carry(const mbsri_carry *from, int l, carry *c)
{
    sym *const to[2] = {&c->I, &c->M};
    const double *const A[2] = {from->I, from->M}, *G = from->G;
    for (int k = 0; k < 2; ++k) {
        to[k]->xx[l] = A[k][0], to[k]->yy[l] = A[k][1], to[k]->zz[l] = A[k][2];
        to[k]->yz[l] = A[k][4], to[k]->xz[l] = A[k][5], to[k]->xy[l] = A[k][6];
    }
    take((double[]){G[0], G[9], G[6]}, l, &c->G.x);
    take((double[]){G[4], G[1], G[10]}, l, &c->G.y);
    take((double[]){G[8], G[5], G[2]}, l, &c->G.z);
    take(from->L, l, &c->L), take(from->p, l, &c->p);
    c->kappa[l] = from->kappa;
    c->spread[l] = from->spread;
}

/* c of body i, about the origin and along the axes of the block that is its predecessor. */
static void give_to_block(mbsri_batch_run *run, int i, carry *c)
{
    const int block = run->origin[run->body[i].parent];
    turn_carry(&site_of(run, run->body[i].parent)->R, c);
    MBSRI_EACH_LANE(run, l)
    {
        mbsri_carry one;
        lay_carry(c, l, &one);
        mbsri_block_receive(run->lane + l, block, &one, NULL);
    }
}

/* Past block i, to c what a predecessor in the lanes gets. */
static void pass_block(mbsri_batch_run *run, int i, carry *c)
{
    memset(c, 0, sizeof *c);
    MBSRI_EACH_LANE(run, l)
    {
        const mbsri_sweep_run *lane = run->lane + l;
        _Alignas(32) mbsri_carry one;
        memset(&one, 0, sizeof one);
        const bool clear = lane->tree->kernels->block_backward(lane, run->origin[i], &one);
        if (clear && lane->rank[run->origin[i]] == run->body[i].n)
            take_carry(&one, l, c);
        else
            fail(run, l);
    }
    turn_carry_back(&site_of(run, run->body[i].parent)->R, c);
}

/* -(L, p) of what elements exert on body i, about its origin. */
static void take_loads(const mbsri_batch_run *run, int i, vec *L, vec *p)
{
    const mat *R = &site_of(run, i)->R;
    *L = *p = no_vec();
    MBSRI_EACH_LANE(run, l)
    {
        const mbsri_sweep_load *load = run->lane[l].load + run->origin[i];
        take(load->L, l, L);
        take(load->p, l, p);
    }
    *L = scaled(transposed_times(R, *L), splat(-1.0));
    *p = scaled(transposed_times(R, *p), splat(-1.0));
}

static void add_loads(const mbsri_batch_run *run, int i, carry *c)
{
    vec L, p;
    take_loads(run, i, &L, &p);
    c->L = add(c->L, L);
    c->p = add(c->p, p);
}

/* ---- accelerations ---- */

MBSRI_INLINE void lay_acceleration(const mbsri_batch_run *run, int i)
{
    const mat *R = &site_of(run, i)->R;
    const vec A_w = times(R, motion_of(run, i)->A_w), A_v = times(R, motion_of(run, i)->A_v);
    MBSRI_EACH_LANE(run, l)
    {
        mbsri_sweep_state *to = run->lane[l].state + run->origin[i];
        lay(A_w, l, to->A_w), lay(A_v, l, to->A_v);
    }
}

/* A of block i by a function for one state, and its numbers of `out` where it has found them. */
static void accelerate_block(const mbsri_batch_run *run, int i,
                             void (*accelerate_one)(const mbsri_sweep_run *, int), bool rates)
{
    const mbsri_batch_body *b = run->body + i;
    const mat *R = &site_of(run, i)->R;
    vec A_w = no_vec(), A_v = no_vec();
    lanes *out = (lanes *)run->out;
    MBSRI_EACH_LANE(run, l)
    {
        const mbsri_sweep_run *lane = run->lane + l;
        const mbsri_sweep_state *from = lane->state + run->origin[i];
        accelerate_one(lane, run->origin[i]);
        take(from->A_w, l, &A_w), take(from->A_v, l, &A_v);
        for (int k = 0; k < b->n && rates; ++k) out[b->u + k][l] = lane->out[b->u + k];
    }
    motion_of(run, i)->A_w = transposed_times(R, A_w);
    motion_of(run, i)->A_v = transposed_times(R, A_v);
}

/* ---- inverse dynamics ---- */

static void add_wrench(const mbsri_batch_run *run, int i, body_state *s)
{
    vec L, p;
    take_loads(run, i, &L, &p);
    s->column.g_L = add(s->column.g_L, L);
    s->column.g_p = add(s->column.g_p, p);
}

/* Joint forces of block i, and the wrench on its predecessor in the lanes. */
static void react_block(const mbsri_batch_run *run, int i, vec *L, vec *p)
{
    const mbsri_batch_body *b = run->body + i;
    const mat *R = &site_of(run, b->parent)->R;
    lanes *out = (lanes *)run->out;
    *L = *p = no_vec();
    MBSRI_EACH_LANE(run, l)
    {
        const mbsri_sweep_run *lane = run->lane + l;
        double force[8];
        mbsri_block_react(lane, run->origin[i], force, force + 4);
        take(force, l, L), take(force + 4, l, p);
        for (int k = 0; k < b->n; ++k) out[b->u + k][l] = lane->out[b->u + k];
    }
    *L = transposed_times(R, *L);
    *p = transposed_times(R, *p);
}

/* (L, p) about the origin and along the axes of the block that is its predecessor. */
static void give_force(const mbsri_batch_run *run, int i, vec L, vec p)
{
    const int parent = run->body[i].parent;
    const mat *R = &site_of(run, parent)->R;
    L = times(R, L);
    p = times(R, p);
    MBSRI_EACH_LANE(run, l)
    {
        double force[8];
        lay(L, l, force), lay(p, l, force + 4);
        mbsri_block_receive_force(run->lane + l, run->origin[parent], force, force + 4);
    }
}

#endif

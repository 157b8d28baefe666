/* Bodies that others than the lanes look at, state by state: with the kernels, since every number of
 * theirs is a vector there.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Blocks (sweeps/block.h) and force elements on bodies have functions for one state. Each lane has data
 * of its own for them, with what the sweeps in one state keep of the bodies that are seen
 * (assembly/places.h); a body's numbers are laid down there, and taken up again, one lane after the
 * other. A lane whose functions fail is not served, and its state goes alone. */
#ifndef MBSRI_BATCH_SEEN_H
#define MBSRI_BATCH_SEEN_H

#include "batch/state.h"

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
    to->r = vec_of(run->r);
    to->v = vec_of(run->v);
    to->angle = splat(run->r[3]);
}

MBSRI_INLINE void lay_motion(const mbsri_batch_run *run, int i)
{
    const body_state *s = (const body_state *)run->state + i;
    const site *at = site_of(run, i);
    const int body = run->origin[i];
    MBSRI_EACH_LANE(run, l)
    {
        mbsri_sweep_state *to = run->lane[l].state + body;
        double *r = run->lane[l].load[body].r;
        lay(s->R.x, l, to->R), lay(s->R.y, l, to->R + 4), lay(s->R.z, l, to->R + 8);
        lay(s->rho, l, to->rho), lay(s->omega, l, to->omega), lay(at->v, l, to->v);
        lay(at->r, l, r);
        r[3] = at->angle[l];
    }
}

static void move_block(mbsri_batch_run *run, int i)
{
    body_state *s = (body_state *)run->state + i;
    site *at = site_of(run, i);
    const int body = run->origin[i];
    memset(s, 0, sizeof *s);
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
        take(from->R, l, &s->R.x), take(from->R + 4, l, &s->R.y), take(from->R + 8, l, &s->R.z);
        take(from->rho, l, &s->rho), take(from->omega, l, &s->omega), take(from->v, l, &at->v);
        take(r, l, &at->r);
        at->angle[l] = r[3];
    }
}

/* The angle of a body in the plane, behind its origin. */
static lanes angle_of(const mbsri_batch_run *run, int body, lanes pred)
{
    const mbsri_sweep_own *own = run->lane->tree->own + body;
    const mbsri_joint *joint = &run->lane->model->body[body].joint;
    if (joint->space != MBSR_SPACE_PLANAR) return splat(0.0);
    const lanes known = pred + splat(own->angle);
    if (own->coordinate >= 0) return known + at(run->q, own->coordinate);
    if (own->coordinate == MBSRI_ANGLE_HELD) return known;
    return known + splat(mbsri_driven_angle(joint, run->lane->data->t));
}

/* Origin and its velocity of body i, no block, that has been moved. */
MBSRI_INLINE void place_body(const mbsri_batch_run *run, int i)
{
    const mbsri_sweep_body *b = run->body + i;
    const body_state *s = (const body_state *)run->state + i,
                     *pred = (body_state *)run->state + b->parent;
    const site *from = site_of(run, b->parent);
    site *to = site_of(run, i);
    to->r = add(from->r, s->rho);
    to->v = add(from->v, cross(pred->omega, s->rho));
    if (b->flags & MBSRI_SLIDES) {
        const bool moved = (b->flags & MBSRI_MOVED) != 0;
        const lanes u = moved ? splat(run->drive[3 * b->q + 1]) : at(run->u, b->u);
        to->v = plus(to->v, splat(b->pitch) * u, s->R.z);
    }
    to->angle = from->angle;
    if (b->flags & MBSRI_PLANE) to->angle = angle_of(run, run->origin[i], from->angle);
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

/* c of body i, about the origin of the block that is its predecessor. */
static void give_to_block(mbsri_batch_run *run, int i, const carry *c)
{
    const int block = run->origin[run->body[i].parent];
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
}

/* -(L, p) of what elements exert on body i, about its origin. */
static void take_loads(const mbsri_batch_run *run, int i, vec *L, vec *p)
{
    const vec none = {splat(0.0), splat(0.0), splat(0.0)};
    *L = *p = none;
    MBSRI_EACH_LANE(run, l)
    {
        const mbsri_sweep_load *load = run->lane[l].load + run->origin[i];
        take(load->L, l, L);
        take(load->p, l, p);
    }
    *L = plus(none, splat(-1.0), *L);
    *p = plus(none, splat(-1.0), *p);
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
    const body_state *s = (const body_state *)run->state + i;
    MBSRI_EACH_LANE(run, l)
    {
        mbsri_sweep_state *to = run->lane[l].state + run->origin[i];
        lay(s->A_w, l, to->A_w), lay(s->A_v, l, to->A_v);
    }
}

/* A of block i by a function for one state, and its numbers of `out` where it has found them. */
static void accelerate_block(const mbsri_batch_run *run, int i,
                             void (*accelerate_one)(const mbsri_sweep_run *, int), bool rates)
{
    body_state *s = (body_state *)run->state + i;
    const mbsri_sweep_body *b = run->body + i;
    lanes *out = (lanes *)run->out;
    MBSRI_EACH_LANE(run, l)
    {
        const mbsri_sweep_run *lane = run->lane + l;
        const mbsri_sweep_state *from = lane->state + run->origin[i];
        accelerate_one(lane, run->origin[i]);
        take(from->A_w, l, &s->A_w), take(from->A_v, l, &s->A_v);
        for (int k = 0; k < b->n && rates; ++k) out[b->u + k][l] = lane->out[b->u + k];
    }
}

/* ---- inverse dynamics ---- */

static void add_wrench(const mbsri_batch_run *run, int i, body_state *s)
{
    vec L, p;
    take_loads(run, i, &L, &p);
    s->column.g_L = add(s->column.g_L, L);
    s->column.g_p = add(s->column.g_p, p);
}

/* Joint forces of block i, and to its predecessor in the lanes the wrench on it. */
static void react_block(const mbsri_batch_run *run, int i)
{
    const mbsri_sweep_body *b = run->body + i;
    column *pred = &((body_state *)run->state + b->parent)->column;
    lanes *out = (lanes *)run->out;
    vec L, p;
    memset(&L, 0, sizeof L);
    memset(&p, 0, sizeof p);
    MBSRI_EACH_LANE(run, l)
    {
        const mbsri_sweep_run *lane = run->lane + l;
        double force[8];
        mbsri_block_react(lane, run->origin[i], force, force + 4);
        take(force, l, &L), take(force + 4, l, &p);
        for (int k = 0; k < b->n; ++k) out[b->u + k][l] = lane->out[b->u + k];
    }
    if (b->parent == 0 || b->flags & MBSRI_TO_BLOCK) return;
    pred->g_L = add(pred->g_L, L);
    pred->g_p = add(pred->g_p, p);
}

static void give_force(const mbsri_batch_run *run, int i, vec L, vec p)
{
    const int block = run->origin[run->body[i].parent];
    MBSRI_EACH_LANE(run, l)
    {
        double force[8];
        lay(L, l, force), lay(p, l, force + 4);
        mbsri_block_receive_force(run->lane + l, block, force, force + 4);
    }
}

#endif

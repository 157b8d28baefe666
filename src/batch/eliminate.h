/* Past joints, leaves to root: U = Mbar S, D = S^T U, e = tau - S^T (L, p), then Mbar - U D^-1 U^T,
 * the force (L, p) + U D^-1 e, and the bound of rounding errors with them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BATCH_ELIMINATE_H
#define MBSRI_BATCH_ELIMINATE_H

#include "batch/carry.h"

/* ---- whether D is known, as `certify` of the sweeps has it (sweeps/rank_bound.h) ---- */

/* The norm of Mbar; where bodies lie in a plane, without what no joint takes away. */
MBSRI_INLINE lanes trace_of(const mbsri_batch_run *run, const mbsri_batch_body *b, const carry *c)
{
    const sym *I = &c->I, *M = &c->M;
    const lanes per_area = splat(run->per_area);
    const double *n = b->normal;
    if (!(b->flags & MBSRI_LEVEL))
        return (I->xx + I->yy + I->zz) * per_area + (M->xx + M->yy + M->zz);
    return (splat(n[0]) * I->xx + splat(n[1]) * I->yy + splat(n[2]) * I->zz) * per_area +
           (splat(1.0 - n[0]) * M->xx + splat(1.0 - n[1]) * M->yy + splat(1.0 - n[2]) * M->zz);
}

/* The bound with the errors of Mbar itself, whose norm is at most `trace`; a regular body's (see
 * mbsri_sweep_body.soft) goes into kappa. Returns what stays in spread. */
MBSRI_INLINE lanes noise_of(carry *c, lanes trace, double soft)
{
    const lanes spread = c->spread + trace;
    if (!(soft > 0.0)) return spread;
    c->kappa = larger(spread * splat(soft), c->kappa);
    return splat(0.0);
}

/* D is regular and known to nine digits of `local`, out of which it comes; size: |S|^2. */
MBSRI_INLINE lane_bits is_known(const mbsri_batch_run *run, const carry *c, lanes D, lanes local,
                                lanes spread, double size)
{
    const double least = run->rule.by_parts;
    return (D > splat(MBSRI_NINE_DIGITS) * local) &
           (D - splat(least) * (D * c->kappa) > splat(least * size) * spread);
}

/* ---- a joint that turns about z, and nothing more ---- */

/* S = (z, 0) without armature: U is a column of Mbar, and behind the joint what I and G have about
 * z is zero, and L.z = tau. */
typedef struct hinge {
    lanes U_x, U_y, g_x, g_y, e; /* x and y of U_L and of U_L D^-1; e */
    vec U_p, g_p;
    turn theta, alpha;
} hinge;

MBSRI_INLINE column eliminate_hinge(const mbsri_batch_run *run, const mbsri_batch_body *b,
                                    lanes tau, carry *c, lane_bits *clear, hinge *j)
{
    const lanes D = c->I.zz, trace = trace_of(run, b, c), Dinv = splat(1.0) / D, one = splat(1.0);
    lanes local = D;
    if (!(b->flags & MBSRI_FLAT)) local += c->I.xx + c->I.yy;
    const lanes spread = noise_of(c, trace, b->soft);
    *clear &= is_known(run, c, D, local, spread, run->area);
    j->U_x = c->I.xz, j->U_y = c->I.yz, j->U_p = c->G.z;
    j->g_x = j->U_x * Dinv, j->g_y = j->U_y * Dinv, j->g_p = scaled(j->U_p, Dinv);
    j->e = tau - c->L.z;
    /* |S|^2 |g|^2 */
    const lanes transport =
        (j->g_x * j->g_x + j->g_y * j->g_y + one) + splat(run->area) * dot(j->g_p, j->g_p);
    c->spread = spread * transport + trace * (one + transport);
    c->L.z = tau;
    return (column){{j->g_x, j->g_y, one}, j->g_p, j->e * Dinv};
}

/* Block by block: Mbar^a, what (L, p) + U D^-1 e + Mbar^a c have of it, and turned by theta and
 * alpha. */
MBSRI_INLINE void pass_M(const hinge *j, vec v, carry *c)
{
    subtract_product(&c->M, j->g_p, j->U_p);
    c->p = add(plus(c->p, j->e, j->g_p), sym_times(&c->M, v));
    sym_about_z(&j->theta, &c->M);
    sym_about_x(&j->alpha, &c->M);
}

MBSRI_INLINE void pass_G(const hinge *j, vec w, vec v, carry *c)
{
    const turn *t = &j->theta, *alpha = &j->alpha;
    const vec x = plus(c->G.x, -j->U_x, j->g_p), y = plus(c->G.y, -j->U_y, j->g_p);
    c->L.x += dot(x, v);
    c->L.y += dot(y, v);
    c->p = plus(plus(c->p, w.x, x), w.y, y);
    const lanes d = x.x - y.y, sum = x.y + y.x, move = t->ss * d + t->sc * sum,
                across = t->sc * d - t->ss * sum;
    const vec to_x = {x.x - move, x.y + across, t->c * x.z - t->s * y.z},
              to_y = {y.x + across, y.y + move, t->s * x.z + t->c * y.z};
    c->G.x = about_x(alpha, to_x);
    const vec tilted = about_x(alpha, to_y);
    c->G.y = scaled(tilted, alpha->c);
    c->G.z = scaled(tilted, alpha->s);
}

MBSRI_INLINE void pass_I(const hinge *j, vec w, carry *c)
{
    const turn *t = &j->theta, *alpha = &j->alpha;
    const lanes xx = c->I.xx - j->g_x * j->U_x, xy = c->I.xy - j->g_x * j->U_y,
                yy = c->I.yy - j->g_y * j->U_y, d = xx - yy, twice = xy + xy,
                move = t->ss * d + t->sc * twice;
    c->L.x += j->e * j->g_x + xx * w.x + xy * w.y;
    c->L.y += j->e * j->g_y + xy * w.x + yy * w.y;
    const lanes to_xy = xy + (t->sc * d - t->ss * twice), to_yy = yy + move;
    c->I.xx = xx - move;
    c->I.xy = alpha->c * to_xy, c->I.xz = alpha->s * to_xy;
    c->I.yy = alpha->cc * to_yy, c->I.yz = alpha->sc * to_yy, c->I.zz = alpha->ss * to_yy;
}

/* ---- others ---- */

/* One coordinate: U, D, e; what D comes from, |S|^2. */
typedef struct coordinate {
    vec U_L, U_p;
    lanes D, e, local;
    double size;
} coordinate;

MBSRI_INLINE column eliminate(const mbsri_batch_run *run, const mbsri_batch_body *b, double soft,
                              const coordinate *j, carry *c, lane_bits *clear)
{
    const lanes trace = trace_of(run, b, c), Dinv = splat(1.0) / j->D;
    const lanes spread = noise_of(c, trace, soft);
    *clear &= is_known(run, c, j->D, j->local, spread, j->size);
    const column g = {scaled(j->U_L, Dinv), scaled(j->U_p, Dinv), j->e * Dinv};
    lanes transport =
        splat(j->size) * (dot(g.g_L, g.g_L) * splat(run->per_area) + dot(g.g_p, g.g_p));
    if (b->armature > 0.0) /* 1 - S g^T projects on nothing: (1 + |S| |g|)^2 <= 2 + 2 |S|^2 |g|^2 */
        transport = splat(2.0) + splat(2.0) * transport;
    c->spread = spread * transport + trace * (splat(1.0) + transport);
    subtract_product(&c->I, g.g_L, j->U_L);
    subtract_product(&c->M, g.g_p, j->U_p);
    c->G = (mat){plus(c->G.x, -j->U_L.x, g.g_p), plus(c->G.y, -j->U_L.y, g.g_p),
                 plus(c->G.z, -j->U_L.z, g.g_p)};
    c->L = plus(c->L, j->e, g.g_L);
    c->p = plus(c->p, j->e, g.g_p);
    return g;
}

/* S = (alpha z, h z) with alpha = 1 where it turns and h = pitch where it slides. */
MBSRI_INLINE column eliminate_axis(const mbsri_batch_run *run, const mbsri_batch_body *b, lanes tau,
                                   carry *c, lane_bits *clear)
{
    const lanes h = splat(b->pitch);
    coordinate j = {no_vec(), no_vec(), splat(b->armature), tau, splat(0.0), 0.0};
    if (b->flags & MBSRI_TURNS) {
        j.U_L = (vec){c->I.xz, c->I.yz, c->I.zz};
        j.U_p = c->G.z;
        j.size = run->area;
        j.local = c->I.zz;
        if (!(b->flags & MBSRI_FLAT)) j.local += c->I.xx + c->I.yy;
        j.e -= c->L.z;
    }
    if (b->flags & MBSRI_SLIDES) {
        const vec row = {c->G.x.z, c->G.y.z, c->G.z.z}, M_z = {c->M.xz, c->M.yz, c->M.zz};
        j.U_L = plus(j.U_L, h, row);
        j.U_p = plus(j.U_p, h, M_z);
        j.size += b->pitch * b->pitch;
        j.local += splat(b->pitch * b->pitch) * (c->M.xx + c->M.yy + c->M.zz);
        j.D += h * j.U_p.z;
        j.e -= h * c->p.z;
    }
    if (b->flags & MBSRI_TURNS) j.D += j.U_L.z;
    return eliminate(run, b, b->soft, &j, c, clear);
}

/* The three rates of a quaternion, one after the other. */
MBSRI_INLINE void eliminate_ball(const mbsri_batch_run *run, const mbsri_batch_body *b,
                                 ball_state *ball, carry *c, lane_bits *clear)
{
    const lanes armature = splat(b->armature), *tau = (const lanes *)run->load + b->u;
    const sym *I = &c->I;
    turn_carry(&ball->R, c);
    const coordinate z = {{I->xz, I->yz, I->zz}, c->G.z,   I->zz + armature, tau[2] - c->L.z,
                          I->xx + I->yy + I->zz, run->area};
    ball->column[2] = eliminate(run, b, b->soft, &z, c, clear);
    const coordinate y = {{I->xy, I->yy, I->yz}, c->G.y,   I->yy + armature, tau[1] - c->L.y,
                          I->xx + I->yy + I->zz, run->area};
    ball->column[1] = eliminate(run, b, 0.0, &y, c, clear);
    const coordinate x = {{I->xx, I->xy, I->xz}, c->G.x,   I->xx + armature, tau[0] - c->L.x,
                          I->xx + I->yy + I->zz, run->area};
    ball->column[0] = eliminate(run, b, 0.0, &x, c, clear);
}

/* (L, p) += Mbar^a c, all turned by theta and alpha. */
MBSRI_INLINE void turn_other(const mbsri_batch_body *b, const body_state *s, carry *c)
{
    const vec w = s->c_w, v = s->c_v;
    c->L = add(c->L, add(sym_times(&c->I, w), transposed_times(&c->G, v)));
    c->p = add(c->p, add(times(&c->G, w), sym_times(&c->M, v)));
    if (b->flags & MBSRI_ROUND) {
        const turn theta = turn_of_body(s);
        carry_about_z(&theta, c);
    }
    if (b->flags & MBSRI_TILTED) {
        const turn alpha = fixed_turn(b->tilt);
        carry_about_x(&alpha, c);
    }
}

#endif

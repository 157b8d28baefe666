/* The sweeps over a tree at several states side by side; compiled by kernels_*.c for
 * different processors, each with its own MBSRI_LANES.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Symbols and equations are those of sweeps/motion.h. */
#include "batch/seen.h"

#include "sweeps/sine.h"

#include <string.h>

/* ---- between the caller's order and the lanes ---- */

MBSRI_INLINE unsigned set_of(lane_bits where)
{
    unsigned set = 0;
    for (int l = 0; l < MBSRI_LANES; ++l) set |= (unsigned)(where[l] & 1) << l;
    return set;
}

static unsigned gather(int n, const int *place, int count, const double *from, double *to)
{
    const double *state[MBSRI_LANES];
    lane_bits finite = {0};
    finite = ~finite;
    for (int l = 0; l < MBSRI_LANES; ++l)
        state[l] = from + (size_t)n * (size_t)(l < count ? l : count - 1);
    for (int k = 0; k < n; ++k) {
        const int from_k = place ? place[k] : k;
        lanes x;
        for (int l = 0; l < MBSRI_LANES; ++l) x[l] = state[l][from_k];
        finite &= x - x == splat(0.0);
        *((lanes *)to + k) = x;
    }
    return set_of(finite);
}

static unsigned scatter(int n, const int *place, int count, const double *from, double *to)
{
    lane_bits finite = {0};
    finite = ~finite;
    for (int k = 0; k < n; ++k) {
        const lanes x = *((const lanes *)from + k);
        double *const to_k = to + (place ? place[k] : k);
        finite &= x - x == splat(0.0);
        for (int l = 0; l < MBSRI_LANES; ++l) {
            if (l < count) to_k[(size_t)n * (size_t)l] = x[l];
        }
    }
    return set_of(finite);
}

/* ---- root to leaves: R, rho, omega, c ---- */

/* A += S u' */
MBSRI_INLINE void add_rate(const mbsri_sweep_body *b, vec Z, lanes udot, vec *A_w, vec *A_v)
{
    if (b->flags & MBSRI_TURNS) *A_w = plus(*A_w, udot, Z);
    if (b->flags & MBSRI_SLIDES) *A_v = plus(*A_v, splat(b->pitch) * udot, Z);
}

/* B <- B R(q / |q|); false where q is zero. */
MBSRI_INLINE lane_bits turn_by_quaternion(const double *q, int k, mat *B)
{
    const lanes w = at(q, k), x = at(q, k + 1), y = at(q, k + 2), z = at(q, k + 3);
    const lanes square = w * w + x * x + y * y + z * z, s = splat(2.0) / square;
    const lanes wx = s * w * x, wy = s * w * y, wz = s * w * z, xx = s * x * x, xy = s * x * y,
                xz = s * x * z, yy = s * y * y, yz = s * y * z, zz = s * z * z, one = splat(1.0);
    const vec X = {one - (yy + zz), xy + wz, xz - wy}, Y = {xy - wz, one - (xx + zz), yz + wx},
              Z = {xz + wy, yz - wx, one - (xx + yy)};
    const mat P = *B;
    *B = (mat){times(&P, X), times(&P, Y), times(&P, Z)};
    return square > splat(0.0);
}

MBSRI_INLINE lane_bits turn_by_angle(lanes angle, mat *B)
{
    lanes sine, cosine;
    sine_cosine(angle, &sine, &cosine);
    const mat P = *B;
    B->x = plus(scaled(P.x, cosine), sine, P.y);
    B->y = plus(scaled(P.y, cosine), -sine, P.x);
    return (angle < splat((double)MBSRI_REDUCED)) & (angle > splat(-(double)MBSRI_REDUCED));
}

/* Which states have coordinates that are served. */
MBSRI_INLINE lane_bits move_body(const mbsri_batch_run *run, const mbsri_sweep_body *b,
                                 ball_state *ball, body_state *s)
{
    const body_state *pred = (const body_state *)run->state + b->parent;
    const mat P = pred->R;
    const vec omega_pred = pred->omega, none = {splat(0.0), splat(0.0), splat(0.0)};
    mat B = {turned(&P, b->A), turned(&P, b->A + 4), turned(&P, b->A + 8)};
    vec rho = turned(&P, b->x), omega = omega_pred, c_w = none, c_v = none;
    lane_bits served = {0};
    served = ~served;
    if (b->flags & (MBSRI_TURNS | MBSRI_SLIDES)) {
        const bool moved = (b->flags & MBSRI_MOVED) != 0;
        const double *drive = run->drive + (moved ? 3 * b->q : 0);
        const lanes q = moved ? splat(drive[0]) : at(run->q, b->q),
                    u = moved ? splat(drive[1]) : at(run->u, b->u);
        const vec turning = scaled(cross(omega_pred, B.z), u);
        if (b->flags & MBSRI_SLIDES) {
            rho = plus(rho, splat(b->pitch) * q, B.z);
            c_v = scaled(turning, splat(2.0 * b->pitch));
        }
        if (b->flags & MBSRI_TURNS) {
            omega = plus(omega, u, B.z);
            c_w = turning;
            served = turn_by_angle(q, &B);
        }
        if (moved) add_rate(b, B.z, splat(drive[2]), &c_w, &c_v);
    } else if (b->flags & MBSRI_BALL) {
        const vec u = {at(run->u, b->u), at(run->u, b->u + 1), at(run->u, b->u + 2)};
        const vec relative = times(&B, u);
        ball->axes = B;
        omega = add(omega, relative);
        c_w = cross(omega_pred, relative);
        served = turn_by_quaternion(run->q, b->q, &B);
    }
    s->R = B;
    s->rho = rho;
    s->omega = omega;
    s->A_w = c_w;
    s->A_v = add(c_v, cross(omega_pred, cross(omega_pred, rho)));
    return served;
}

static void move_root(const mbsri_batch_run *run)
{
    body_state *s = run->state;
    s->R = (mat){vec_of(run->R), vec_of(run->R + 3), vec_of(run->R + 6)};
    s->omega = vec_of(run->omega);
    s->A_w = vec_of(run->A);
    s->A_v = vec_of(run->A + 3);
}

/* any: there are bodies that are seen. */
MBSRI_INLINE lane_bits kinematics(mbsri_batch_run *run, bool any)
{
    body_state *s = run->state;
    ball_state *ball = run->ball;
    lane_bits served = {0};
    served = ~served;
    move_root(run);
    if (any) place_root(run);
    for (int i = 1; i <= run->bodies; ++i) {
        const mbsri_sweep_body *b = run->body + i;
        if (any && b->flags & MBSRI_BLOCK) {
            move_block(run, i);
            continue;
        }
        served &= move_body(run, b, ball, s + i);
        if (any) place_body(run, i);
        if (b->flags & MBSRI_BALL) ++ball;
    }
    return served;
}

/* ---- leaves to root: Mbar, D, e ---- */

MBSRI_INLINE lanes larger(lanes a, lanes b)
{
    const lane_bits first = a > b;
    return (lanes)((first & (lane_bits)a) | (~first & (lane_bits)b));
}

/* c += what other successors left. */
MBSRI_INLINE void add_carry(const carry *m, carry *c)
{
    add_to(&c->I, &m->I);
    add_to(&c->M, &m->M);
    c->G = (mat){add(c->G.x, m->G.x), add(c->G.y, m->G.y), add(c->G.z, m->G.z)};
    c->L = add(c->L, m->L);
    c->p = add(c->p, m->p);
    c->kappa = larger(m->kappa, c->kappa);
    c->spread += m->spread;
}

/* Own inertia, turned into the world, and its gyroscopic force. */
MBSRI_INLINE void add_own(const mbsri_sweep_body *b, const body_state *s, carry *c)
{
    const mat R = s->R;
    const vec omega = s->omega, h = turned(&R, b->c);
    const mat N = {turned(&R, b->I), turned(&R, b->I + 4), turned(&R, b->I + 8)};
    const sym I = {N.x.x * R.x.x + N.y.x * R.y.x + N.z.x * R.z.x,
                   N.x.y * R.x.y + N.y.y * R.y.y + N.z.y * R.z.y,
                   N.x.z * R.x.z + N.y.z * R.y.z + N.z.z * R.z.z,
                   N.x.x * R.x.y + N.y.x * R.y.y + N.z.x * R.z.y,
                   N.x.x * R.x.z + N.y.x * R.y.z + N.z.x * R.z.z,
                   N.x.y * R.x.z + N.y.y * R.y.z + N.z.y * R.z.z};
    c->L = add(c->L, cross(omega, sym_times(&I, omega)));
    c->p = add(c->p, cross(omega, cross(omega, h)));
    add_to(&c->I, &I);
    /* G = -[h]x */
    c->G.x.y -= h.z, c->G.x.z += h.y;
    c->G.y.x += h.z, c->G.y.z -= h.x;
    c->G.z.x -= h.y, c->G.z.y += h.x;
    const lanes mass = splat(b->c[3]);
    c->M.xx += mass, c->M.yy += mass, c->M.zz += mass;
}

/* From a body's origin to its predecessor's: with r = [rho]x
 *   G <- G' = G - M r,  I <- I + r G' + (r G)^T,  L <- L + r p */
MBSRI_INLINE void translate(vec r, carry *c)
{
    const sym *M = &c->M;
    const mat G = c->G, N = {{G.x.x - M->xy * r.z + M->xz * r.y, G.x.y - M->yy * r.z + M->yz * r.y,
                              G.x.z - M->yz * r.z + M->zz * r.y},
                             {G.y.x - M->xz * r.x + M->xx * r.z, G.y.y - M->yz * r.x + M->xy * r.z,
                              G.y.z - M->zz * r.x + M->xz * r.z},
                             {G.z.x - M->xx * r.y + M->xy * r.x, G.z.y - M->xy * r.y + M->yy * r.x,
                              G.z.z - M->xz * r.y + M->yz * r.x}};
    c->I.xx = c->I.xx + r.y * N.x.z - r.z * N.x.y + r.y * G.x.z - r.z * G.x.y;
    c->I.yy = c->I.yy + r.z * N.y.x - r.x * N.y.z + r.z * G.y.x - r.x * G.y.z;
    c->I.zz = c->I.zz + r.x * N.z.y - r.y * N.z.x + r.x * G.z.y - r.y * G.z.x;
    c->I.xy = c->I.xy + r.z * N.x.x - r.x * N.x.z + r.y * G.y.z - r.z * G.y.y;
    c->I.xz = c->I.xz + r.x * N.x.y - r.y * N.x.x + r.y * G.z.z - r.z * G.z.y;
    c->I.yz = c->I.yz + r.x * N.y.y - r.y * N.y.x + r.z * G.z.x - r.x * G.z.z;
    c->G = N;
    c->L = add(c->L, cross(r, c->p));
}

MBSRI_INLINE lanes trace_of(const carry *c, int flags, double per_area)
{
    if (flags & MBSRI_LEVEL) return c->I.zz * splat(per_area) + (c->M.xx + c->M.yy);
    return (c->I.xx + c->I.yy + c->I.zz) * splat(per_area) + (c->M.xx + c->M.yy + c->M.zz);
}

/* The bound of rounding errors with those of Mbar itself, whose norm is at most `trace`; a regular
 * body's (see mbsri_sweep_body.soft) goes into kappa. Returns what stays in spread. */
MBSRI_INLINE lanes noise_of(carry *c, lanes trace, double soft)
{
    const lanes spread = c->spread + trace;
    if (!(soft > 0.0)) return spread;
    c->kappa = larger(spread * splat(soft), c->kappa);
    return splat(0.0);
}

/* One coordinate, S = (alpha Z, h Z) with alpha = 1 where it turns and h = pitch where it slides:
 * U = Mbar S, D = S^T U, e = tau - S^T (L, p), then Mbar - U D^-1 U^T and (L, p) + U D^-1 e, and
 * the bound of rounding errors with them. *clear &= D is regular and known to nine digits, as
 * `certify` of the sweeps has it. */
MBSRI_INLINE column eliminate(const mbsri_batch_run *run, int flags, double pitch, double soft,
                              double armature, vec Z, lanes tau, carry *c, lane_bits *clear)
{
    const lanes per_area = splat(run->per_area), least = splat(run->rule.by_parts),
                h = splat(pitch);
    const vec none = {splat(0.0), splat(0.0), splat(0.0)};
    vec U_L = none, U_p = none;
    lanes D = splat(armature), e = tau;
    double size = 0.0;
    lanes local = splat(0.0);
    if (flags & MBSRI_TURNS) {
        U_L = sym_times(&c->I, Z);
        U_p = times(&c->G, Z);
        size = 1.0 / run->per_area;
        local = c->I.zz;
        if (!(flags & MBSRI_FLAT)) local += c->I.xx + c->I.yy;
    }
    if (flags & MBSRI_SLIDES) {
        U_L = plus(U_L, h, transposed_times(&c->G, Z));
        U_p = plus(U_p, h, sym_times(&c->M, Z));
        D += h * dot(Z, U_p);
        e -= h * dot(Z, c->p);
        size += pitch * pitch;
        local += splat(pitch * pitch) * (c->M.xx + c->M.yy + c->M.zz);
    }
    if (flags & MBSRI_TURNS) {
        D += dot(Z, U_L);
        e -= dot(Z, c->L);
    }
    const lanes trace = trace_of(c, flags, run->per_area), Dinv = splat(1.0) / D;
    const lanes spread = noise_of(c, trace, soft);
    *clear &= (D > splat(MBSRI_NINE_DIGITS) * local) &
              (D - least * (D * c->kappa) > least * (spread * splat(size)));
    const column g = {scaled(U_L, Dinv), scaled(U_p, Dinv), e * Dinv};
    lanes transport = splat(size) * (dot(g.g_L, g.g_L) * per_area + dot(g.g_p, g.g_p));
    if (armature > 0.0) /* 1 - S g^T projects on nothing: (1 + |S| |g|)^2 <= 2 + 2 |S|^2 |g|^2 */
        transport = splat(2.0) + splat(2.0) * transport;
    c->spread = spread * transport + trace * (splat(1.0) + transport);
    subtract_product(&c->I, g.g_L, U_L);
    subtract_product(&c->M, g.g_p, U_p);
    c->G = (mat){plus(c->G.x, -U_L.x, g.g_p), plus(c->G.y, -U_L.y, g.g_p),
                 plus(c->G.z, -U_L.z, g.g_p)};
    c->L = plus(c->L, e, g.g_L);
    c->p = plus(c->p, e, g.g_p);
    return g;
}

/* All coordinates of a body. */
MBSRI_INLINE void eliminate_all(const mbsri_batch_run *run, const mbsri_sweep_body *b,
                                ball_state *ball, body_state *s, carry *c, lane_bits *clear)
{
    if (b->flags & MBSRI_BALL) {
        const mat Z = ball->axes;
        const int flags = MBSRI_TURNS;
        ball->column[2] = eliminate(run, flags, 0.0, b->soft, b->armature, Z.z,
                                    at(run->load, b->u + 2), c, clear);
        ball->column[1] =
            eliminate(run, flags, 0.0, 0.0, b->armature, Z.y, at(run->load, b->u + 1), c, clear);
        ball->column[0] =
            eliminate(run, flags, 0.0, 0.0, b->armature, Z.x, at(run->load, b->u), c, clear);
    } else if (b->n > 0) {
        s->column = eliminate(run, b->flags, b->pitch, b->soft, b->armature, s->R.z,
                              at(run->load, b->u), c, clear);
    } else {
        const lanes trace = trace_of(c, b->flags, run->per_area);
        c->spread = noise_of(c, trace, b->soft) + trace;
    }
}

/* (L, p) += Mbar^a c, all to the predecessor's origin. */
MBSRI_INLINE void hand_on(const mbsri_batch_run *run, const mbsri_sweep_body *b,
                          const body_state *s, carry *c)
{
    c->L = add(c->L, add(sym_times(&c->I, s->A_w), transposed_times(&c->G, s->A_v)));
    c->p = add(c->p, add(times(&c->G, s->A_w), sym_times(&c->M, s->A_v)));
    if (b->flags & MBSRI_HERE) return;
    translate(s->rho, c);
    /* ||X||^2 <= (1 + |rho| / L)^2 <= 2 + 2 |rho|^2 / L^2 */
    if (b->flags & MBSRI_SLIDES)
        c->spread *= splat(2.0) + splat(2.0 * run->per_area) * dot(s->rho, s->rho);
    else
        c->spread *= splat(b->spread);
}

MBSRI_INLINE lane_bits backward(mbsri_batch_run *run, bool any)
{
    carry *top = run->stack, c;
    ball_state *ball = run->ball;
    lane_bits clear = {0};
    clear = ~clear;
    for (int i = 1; i <= run->bodies; ++i) ball += (run->body[i].flags & MBSRI_BALL) != 0;
    memset(&c, 0, sizeof c);
    for (int i = run->bodies; i >= 1; --i) {
        const mbsri_sweep_body *b = run->body + i;
        body_state *s = (body_state *)run->state + i;
        const int flags = b->flags;
        if (any && flags & MBSRI_BLOCK) {
            pass_block(run, i, &c);
        } else {
            if (flags & MBSRI_LEAF) memset(&c, 0, sizeof c);
            if (flags & MBSRI_BRANCHES) add_carry(--top, &c);
            if (!(flags & MBSRI_MASSLESS)) add_own(b, s, &c);
            if (any && flags & MBSRI_LOADED) add_loads(run, i, &c);
            if (flags & MBSRI_BALL) --ball;
            eliminate_all(run, b, ball, s, &c, &clear);
            if (b->parent > 0) hand_on(run, b, s, &c);
            if (any && flags & MBSRI_TO_BLOCK) give_to_block(run, i, &c);
        }
        if (b->parent == 0 || flags & MBSRI_NEXT) continue;
        if (!(flags & MBSRI_OPENS)) add_carry(--top, &c);
        *top++ = c;
    }
    return clear;
}

/* ---- root to leaves: A, u' ---- */

/* A <- X A of the predecessor + c */
MBSRI_INLINE void accelerate(const mbsri_batch_run *run, const mbsri_sweep_body *b,
                             const body_state *s, vec *A_w, vec *A_v)
{
    const body_state *pred = (const body_state *)run->state + b->parent;
    const vec w = pred->A_w;
    *A_w = add(w, s->A_w);
    *A_v = add(add(pred->A_v, s->A_v), cross(w, s->rho));
}

MBSRI_INLINE lanes rate_of(const column *g, vec A_w, vec A_v)
{
    return g->x - (dot(g->g_L, A_w) + dot(g->g_p, A_v));
}

MBSRI_INLINE void forward_sweep(const mbsri_batch_run *run, bool any)
{
    const ball_state *ball = run->ball;
    lanes *out = (lanes *)run->out;
    for (int i = 1; i <= run->bodies; ++i) {
        const mbsri_sweep_body *b = run->body + i;
        body_state *s = (body_state *)run->state + i;
        vec A_w, A_v;
        if (any && b->flags & MBSRI_BLOCK) {
            accelerate_block(run, i, run->lane->tree->kernels->block_forward, true);
            continue;
        }
        accelerate(run, b, s, &A_w, &A_v);
        if (b->flags & MBSRI_BALL) {
            const vec axis[3] = {ball->axes.x, ball->axes.y, ball->axes.z};
            for (int k = 0; k < 3; ++k) {
                const lanes udot = rate_of(ball->column + k, A_w, A_v);
                out[b->u + k] = udot;
                A_w = plus(A_w, udot, axis[k]);
            }
            ++ball;
        } else if (b->n > 0) {
            const lanes udot = rate_of(&s->column, A_w, A_v);
            out[b->u] = udot;
            add_rate(b, s->R.z, udot, &A_w, &A_v);
        }
        s->A_w = A_w;
        s->A_v = A_v;
        if (any && b->flags & MBSRI_SEEN) lay_acceleration(run, i);
    }
}

static unsigned forward(mbsri_batch_run *run)
{
    const lane_bits served = kinematics(run, false), clear = backward(run, false);
    forward_sweep(run, false);
    return set_of(served & clear);
}

static unsigned move_seen(mbsri_batch_run *run)
{
    const lane_bits served = kinematics(run, true);
    return run->served &= set_of(served);
}

static unsigned forward_seen(mbsri_batch_run *run)
{
    const lane_bits clear = backward(run, true);
    run->served &= set_of(clear);
    forward_sweep(run, true);
    return run->served;
}

/* ---- inverse dynamics: F = M A + h root to leaves, S^T (sum of F to the leaves) back ---- */

/* (L, p) = M A + gyroscopic force, in the place of the column. */
MBSRI_INLINE void own_load(const mbsri_sweep_body *b, body_state *s, vec A_w, vec A_v)
{
    const mat R = s->R;
    const mat I = {vec_of(b->I), vec_of(b->I + 4), vec_of(b->I + 8)};
    const vec omega = s->omega, h = turned(&R, b->c);
    const vec w = transposed_times(&R, omega), a = transposed_times(&R, A_w);
    const vec in_body = add(times(&I, a), cross(w, times(&I, w)));
    s->column.g_L = add(times(&R, in_body), cross(h, A_v));
    s->column.g_p = plus(add(cross(A_w, h), cross(omega, cross(omega, h))), splat(b->c[3]), A_v);
}

/* any: there are bodies that are seen, and all have been moved. */
MBSRI_INLINE lane_bits loads(const mbsri_batch_run *run, bool any)
{
    ball_state *ball = run->ball;
    lane_bits served = {0};
    served = ~served;
    if (!any) move_root(run);
    for (int i = 1; i <= run->bodies; ++i) {
        const mbsri_sweep_body *b = run->body + i;
        body_state *s = (body_state *)run->state + i;
        vec A_w, A_v;
        if (any && b->flags & MBSRI_BLOCK) {
            accelerate_block(run, i, mbsri_block_accelerate, false);
            memset(&s->column, 0, sizeof s->column);
            continue;
        }
        if (!any) served &= move_body(run, b, ball, s);
        accelerate(run, b, s, &A_w, &A_v);
        if (b->flags & MBSRI_BALL) {
            const vec udot = {at(run->load, b->u), at(run->load, b->u + 1),
                              at(run->load, b->u + 2)};
            A_w = add(A_w, times(&ball->axes, udot));
            ++ball;
        } else if (b->n > 0) {
            add_rate(b, s->R.z, at(run->load, b->u), &A_w, &A_v);
        }
        s->A_w = A_w;
        s->A_v = A_v;
        if (b->flags & MBSRI_MASSLESS)
            memset(&s->column, 0, sizeof s->column);
        else
            own_load(b, s, A_w, A_v);
        if (any && b->flags & MBSRI_LOADED) add_wrench(run, i, s);
        if (any && b->flags & MBSRI_SEEN) lay_acceleration(run, i);
    }
    return served;
}

MBSRI_INLINE void joint_forces(const mbsri_batch_run *run, bool any)
{
    const ball_state *ball = run->ball;
    lanes *out = (lanes *)run->out;
    for (int i = 1; i <= run->bodies; ++i) ball += (run->body[i].flags & MBSRI_BALL) != 0;
    for (int i = run->bodies; i >= 1; --i) {
        const mbsri_sweep_body *b = run->body + i;
        const body_state *s = (const body_state *)run->state + i;
        const vec L = s->column.g_L, p = s->column.g_p;
        const lanes armature = splat(b->armature);
        if (any && b->flags & MBSRI_BLOCK) {
            react_block(run, i);
            continue;
        }
        if (b->flags & MBSRI_BALL) {
            const vec force = transposed_times(&(--ball)->axes, L);
            out[b->u] = force.x, out[b->u + 1] = force.y, out[b->u + 2] = force.z;
            for (int k = 0; k < 3; ++k) out[b->u + k] += armature * at(run->load, b->u + k);
        } else if (b->n > 0) {
            lanes force = splat(0.0);
            if (b->flags & MBSRI_TURNS) force = dot(s->R.z, L);
            if (b->flags & MBSRI_SLIDES) force += splat(b->pitch) * dot(s->R.z, p);
            out[b->u] = force + armature * at(run->load, b->u);
        }
        if (b->parent == 0) continue;
        const vec moment = add(L, cross(s->rho, p));
        if (any && b->flags & MBSRI_TO_BLOCK) {
            give_force(run, i, moment, p);
            continue;
        }
        column *pred = &((body_state *)run->state + b->parent)->column;
        pred->g_L = add(pred->g_L, moment);
        pred->g_p = add(pred->g_p, p);
    }
}

static unsigned inverse(mbsri_batch_run *run)
{
    const lane_bits served = loads(run, false);
    joint_forces(run, false);
    return set_of(served);
}

static unsigned inverse_seen(mbsri_batch_run *run)
{
    loads(run, true);
    joint_forces(run, true);
    return run->served;
}

#define MBSRI_BATCH_KERNELS(label)                                                                 \
    {                                                                                              \
        .name = (label), .lanes = MBSRI_LANES, .state_size = sizeof(body_state),                   \
        .ball_size = sizeof(ball_state), .stack_size = sizeof(carry), .place_size = sizeof(site),  \
        .gather = gather, .scatter = scatter, .forward = forward, .inverse = inverse,              \
        .move_seen = move_seen, .forward_seen = forward_seen, .inverse_seen = inverse_seen         \
    }

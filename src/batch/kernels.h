/* The sweeps over a tree at several states side by side; compiled by kernels_*.c for
 * different processors, each with its own MBSRI_LANES.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Symbols and equations are those of sweeps/motion.h, but all vectors are along the axes of the
 * body that they belong to (record.h): its inertia and its joint's axis are constants there, and
 * what is turned from body to body is turned by two numbers at a time. */
#include "batch/eliminate.h"
#include "batch/order.h"
#include "batch/seen.h"

#include "sweeps/sine.h"

/* ---- root to leaves: theta, omega, c, gyroscopic forces ---- */

/* A coordinate, its rate and acceleration; u' where the joint does not prescribe it. */
MBSRI_INLINE lanes coordinate_of(const mbsri_batch_run *run, const mbsri_batch_body *b, int flags)
{
    return flags & MBSRI_MOVED ? splat(run->drive[3 * b->q]) : at(run->q, b->q);
}

MBSRI_INLINE lanes rate_of(const mbsri_batch_run *run, const mbsri_batch_body *b, int flags)
{
    return flags & MBSRI_MOVED ? splat(run->drive[3 * b->q + 1]) : at(run->u, b->u);
}

/* A += S u' */
MBSRI_INLINE void add_rate(const mbsri_batch_body *b, int flags, lanes udot, vec *A_w, vec *A_v)
{
    if (flags & MBSRI_TURNS) A_w->z += udot;
    if (flags & MBSRI_SLIDES) A_v->z += splat(b->pitch) * udot;
}

/* R(q / |q|); false where q is zero. */
MBSRI_INLINE lane_bits ball_turn(const double *q, int k, mat *R)
{
    const lanes w = at(q, k), x = at(q, k + 1), y = at(q, k + 2), z = at(q, k + 3);
    const lanes square = w * w + x * x + y * y + z * z, s = splat(2.0) / square;
    const lanes wx = s * w * x, wy = s * w * y, wz = s * w * z, xx = s * x * x, xy = s * x * y,
                xz = s * x * z, yy = s * y * y, yz = s * y * z, zz = s * z * z, one = splat(1.0);
    *R = (mat){{one - (yy + zz), xy + wz, xz - wy},
               {xy - wz, one - (xx + zz), yz + wx},
               {xz + wy, yz - wx, one - (xx + yy)}};
    return square > splat(0.0);
}

/* The rotation of the joint; which states have coordinates that are served. */
MBSRI_INLINE lane_bits turn_joint(const mbsri_batch_run *run, const mbsri_batch_body *b, int flags,
                                  ball_state *ball, body_state *s)
{
    lane_bits served = {0};
    if (flags & MBSRI_TURNS) {
        const lanes q = coordinate_of(run, b, flags), most = splat((double)MBSRI_REDUCED);
        sine_cosine(q + splat(b->offset), &s->s, &s->c);
        return (q < most) & (q > -most);
    }
    if (flags & MBSRI_BALL) {
        s->c = splat(b->base[0]), s->s = splat(b->base[1]);
        return ball_turn(run->q, b->q, &ball->R);
    }
    return ~served;
}

/* omega of the predecessor along the body's axes (a quaternion's: the joint's) to that of the body;
 * what of the acceleration comes with it is added to c. */
MBSRI_INLINE vec add_velocity(const mbsri_batch_run *run, const mbsri_batch_body *b, int flags,
                              const ball_state *ball, vec omega, vec *c_w, vec *c_v)
{
    if (flags & (MBSRI_TURNS | MBSRI_SLIDES)) {
        const lanes u = rate_of(run, b, flags), x = u * omega.y, y = u * omega.x; /* u omega x z */
        if (flags & MBSRI_SLIDES) {
            const lanes twice = splat(2.0 * b->pitch);
            c_v->x += twice * x, c_v->y -= twice * y;
        }
        if (flags & MBSRI_TURNS) {
            c_w->x += x, c_w->y -= y;
            omega.z += u;
        }
        if (flags & MBSRI_MOVED) add_rate(b, flags, splat(run->drive[3 * b->q + 2]), c_w, c_v);
    } else if (flags & MBSRI_BALL) {
        const vec u = {at(run->u, b->u), at(run->u, b->u + 1), at(run->u, b->u + 2)};
        *c_w = add(*c_w, cross(omega, u));
        omega = transposed_times(&ball->R, add(omega, u));
    }
    return omega;
}

/* [omega]x^2 */
MBSRI_INLINE sym squared(vec omega)
{
    const lanes xx = omega.x * omega.x, yy = omega.y * omega.y, zz = omega.z * omega.z;
    return (sym){-(yy + zz),        -(xx + zz),        -(xx + yy),
                 omega.x * omega.y, omega.x * omega.z, omega.y * omega.z};
}

/* omega x I omega, by the square: the skew part of its product with the tensor */
MBSRI_INLINE vec gyration(const mbsri_batch_body *b, const sym *W)
{
    const double *I = b->I;
    const lanes xy = splat(I[3]), xz = splat(I[4]), yz = splat(I[5]);
    return (vec){xz * W->xy - xy * W->xz + splat(I[2] - I[1]) * W->yz + yz * (W->yy - W->zz),
                 xy * W->yz - yz * W->xy + splat(I[0] - I[2]) * W->xz + xz * (W->zz - W->xx),
                 yz * W->xz - xz * W->yz + splat(I[1] - I[0]) * W->xy + xy * (W->xx - W->yy)};
}

/* *m: omega and its square, of the predecessor, then of the body. */
MBSRI_INLINE lane_bits move_body(const mbsri_batch_run *run, const mbsri_batch_body *b, int flags,
                                 ball_state *ball, body_state *s, motion *m)
{
    const lane_bits served = turn_joint(run, b, flags, ball, s);
    const turn theta = {s->c, s->s, s->c, s->s, s->s};
    vec c_w = no_vec(), c_v = no_vec();
    if (!(flags & MBSRI_HERE))
        c_v = to_own(b, flags, &theta, sym_times(&m->squared, arm_of(run, b, flags)));
    m->omega = add_velocity(run, b, flags, ball, to_own(b, flags, &theta, m->omega), &c_w, &c_v);
    m->squared = squared(m->omega);
    s->c_w = c_w;
    s->c_v = c_v;
    if (flags & MBSRI_MASSLESS) return served;
    s->column.g_L = gyration(b, &m->squared);
    s->column.g_p = sym_times(&m->squared, vec_of(b->c));
    return served;
}

/* The root has the axes of run->R. */
static void move_root(const mbsri_batch_run *run)
{
    motion *m = run->motion;
    const mat R = {vec_of(run->R), vec_of(run->R + 3), vec_of(run->R + 6)};
    m->omega = transposed_times(&R, vec_of(run->omega));
    m->A_w = transposed_times(&R, vec_of(run->A));
    m->A_v = transposed_times(&R, vec_of(run->A + 3));
    m->squared = squared(m->omega);
    m->K = turning(&m->squared, m->A_w);
}

/* Of the predecessor of body i, where that is not the body before. */
MBSRI_INLINE bool hangs_elsewhere(const mbsri_batch_run *run, int i, bool any)
{
    return any || run->body[i].parent != i - 1 || i == 1;
}

/* any: there are bodies in the sweeps. */
MBSRI_INLINE lane_bits kinematics(mbsri_batch_run *run, bool any)
{
    body_state *s = run->state;
    motion *kept = run->motion, m;
    ball_state *ball = run->ball;
    lane_bits served = {0};
    served = ~served;
    move_root(run);
    if (any) place_root(run);
    for (int i = 1; i <= run->bodies; ++i) {
        const mbsri_batch_body *b = run->body + i;
        if (any && b->flags & MBSRI_BLOCK) {
            move_block(run, i);
            kept[i].squared = squared(kept[i].omega);
            continue;
        }
        if (hangs_elsewhere(run, i, any)) {
            m.omega = kept[b->parent].omega;
            m.squared = kept[b->parent].squared;
        }
        if (b->flags & MBSRI_HINGE)
            served &= move_body(run, b, hinge_flags(b->flags), ball, s + i, &m);
        else
            served &= move_body(run, b, b->flags, ball, s + i, &m);
        if (any || b->flags & MBSRI_BRANCHES) {
            kept[i].omega = m.omega;
            kept[i].squared = m.squared;
        }
        if (any) place_body(run, i, ball);
        if (b->flags & MBSRI_BALL) ++ball;
    }
    return served;
}

/* ---- leaves to root: Mbar, D, e ---- */

/* All coordinates of a body, and to the predecessor's axes but for beta. */
MBSRI_INLINE void pass_hinge(const mbsri_batch_run *run, const mbsri_batch_body *b, body_state *s,
                             carry *c, lane_bits *clear)
{
    hinge j;
    s->column = eliminate_hinge(run, b, at(run->load, b->u), c, clear, &j);
    if (b->parent == 0) return;
    const vec w = s->c_w, v = s->c_v;
    j.theta = turn_of_body(s);
    j.alpha = fixed_turn(b->tilt);
    pass_M(&j, v, c);
    pass_G(&j, w, v, c);
    pass_I(&j, w, c);
    c->L = about_x(&j.alpha, about_z(&j.theta, c->L));
    c->p = about_x(&j.alpha, about_z(&j.theta, c->p));
}

MBSRI_INLINE void pass_other(const mbsri_batch_run *run, const mbsri_batch_body *b,
                             ball_state *ball, body_state *s, carry *c, lane_bits *clear)
{
    if (b->flags & MBSRI_BALL) {
        eliminate_ball(run, b, ball, c, clear);
    } else if (b->n > 0) {
        s->column = eliminate_axis(run, b, at(run->load, b->u), c, clear);
    } else {
        const lanes trace = trace_of(run, b, c);
        c->spread = noise_of(c, trace, b->soft) + trace;
    }
    if (b->parent > 0) turn_other(b, s, c);
}

/* To the predecessor's axes and origin. */
MBSRI_INLINE void hand_on(const mbsri_batch_run *run, const mbsri_batch_body *b, carry *c)
{
    if (b->flags & MBSRI_TWISTED) {
        const turn beta = fixed_turn(b->twist);
        carry_about_z(&beta, c);
    }
    if (b->flags & MBSRI_HERE) return;
    const vec rho = arm_of(run, b, b->flags);
    translate(rho, c);
    /* ||X||^2 <= (1 + |rho| / L)^2 <= 2 + 2 |rho|^2 / L^2 */
    if (b->flags & MBSRI_SLIDES)
        c->spread *= splat(2.0) + splat(2.0 * run->per_area) * dot(rho, rho);
    else
        c->spread *= splat(b->spread);
}

MBSRI_INLINE lane_bits backward(mbsri_batch_run *run, bool any)
{
    carry *top = run->stack, c = no_carry();
    ball_state *ball = run->ball;
    lane_bits clear = {0};
    clear = ~clear;
    for (int i = 1; i <= run->bodies; ++i) ball += (run->body[i].flags & MBSRI_BALL) != 0;
    for (int i = run->bodies; i >= 1; --i) {
        const mbsri_batch_body *b = run->body + i;
        body_state *s = (body_state *)run->state + i;
        const int flags = b->flags;
        if (any && flags & MBSRI_BLOCK) {
            pass_block(run, i, &c);
        } else {
            if (flags & MBSRI_LEAF) c = no_carry();
            if (flags & MBSRI_BRANCHES) add_carry(--top, &c);
            if (!(flags & MBSRI_MASSLESS)) add_own(b, s, &c);
            if (any && flags & MBSRI_LOADED) add_loads(run, i, &c);
            if (flags & MBSRI_BALL) --ball;
            if (flags & MBSRI_HINGE)
                pass_hinge(run, b, s, &c, &clear);
            else
                pass_other(run, b, ball, s, &c, &clear);
            if (b->parent > 0) hand_on(run, b, &c);
            if (any && flags & MBSRI_TO_BLOCK) give_to_block(run, i, &c);
        }
        if (b->parent == 0 || flags & MBSRI_NEXT) continue;
        if (!(flags & MBSRI_OPENS)) add_carry(--top, &c);
        keep_carry(&c, top++);
    }
    return clear;
}

/* ---- root to leaves: A, u' ---- */

MBSRI_INLINE lanes rate_by(const column *g, vec A_w, vec A_v)
{
    return g->x - (dot(g->g_L, A_w) + dot(g->g_p, A_v));
}

/* u' from A of the predecessor, which becomes that of the body. */
MBSRI_INLINE void accelerate(const mbsri_batch_run *run, const mbsri_batch_body *b, int flags,
                             const body_state *s, const ball_state *ball, vec *A_w, vec *A_v)
{
    const turn theta = {s->c, s->s, s->c, s->s, s->s};
    lanes *out = (lanes *)run->out + b->u;
    vec w = *A_w, v = *A_v;
    if (!(flags & MBSRI_HERE)) v = add(v, cross(w, arm_of(run, b, flags)));
    w = add(to_own(b, flags, &theta, w), s->c_w);
    v = add(to_own(b, flags, &theta, v), s->c_v);
    if (flags & MBSRI_HINGE) {
        const column *g = &s->column; /* where g_L.z = 1 */
        const lanes turned = g->x - g->g_L.x * w.x - g->g_L.y * w.y, slid = dot(g->g_p, v);
        *out = (turned - w.z) - slid;
        w.z = turned - slid;
    } else if (flags & MBSRI_BALL) {
        for (int k = 0; k < 3; ++k) {
            out[k] = rate_by(ball->column + k, w, v);
            *(k == 0 ? &w.x : k == 1 ? &w.y : &w.z) += out[k];
        }
        w = transposed_times(&ball->R, w);
        v = transposed_times(&ball->R, v);
    } else if (b->n > 0) {
        *out = rate_by(&s->column, w, v);
        add_rate(b, flags, *out, &w, &v);
    }
    *A_w = w;
    *A_v = v;
}

MBSRI_INLINE void forward_sweep(const mbsri_batch_run *run, bool any)
{
    const body_state *s = run->state;
    const ball_state *ball = run->ball;
    motion *kept = run->motion;
    vec A_w = no_vec(), A_v = no_vec();
    for (int i = 1; i <= run->bodies; ++i) {
        const mbsri_batch_body *b = run->body + i;
        if (any && b->flags & MBSRI_BLOCK) {
            accelerate_block(run, i, run->lane->tree->kernels->block_forward, true);
            continue;
        }
        if (hangs_elsewhere(run, i, any)) A_w = kept[b->parent].A_w, A_v = kept[b->parent].A_v;
        if (b->flags & MBSRI_HINGE)
            accelerate(run, b, hinge_flags(b->flags), s + i, ball, &A_w, &A_v);
        else
            accelerate(run, b, b->flags, s + i, ball, &A_w, &A_v);
        if (any || b->flags & MBSRI_BRANCHES) kept[i].A_w = A_w, kept[i].A_v = A_v;
        if (b->flags & MBSRI_BALL) ++ball;
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

/* The body's moment about its origin where its points have the accelerations A_v + K x: twice the
 * skew part of K times the integral of x x^T, written with the tensor of inertia, whose small
 * numbers are kept, and h x A_v */
MBSRI_INLINE vec moment_of(const mbsri_batch_body *b, const motion *m)
{
    const double *I = b->I;
    const mat *K = &m->K;
    const sym *W = &m->squared;
    const lanes xy = splat(I[3]), xz = splat(I[4]), yz = splat(I[5]);
    const vec along = {splat(I[0]) * m->A_w.x + splat(I[2] - I[1]) * W->yz,
                       splat(I[1]) * m->A_w.y + splat(I[0] - I[2]) * W->xz,
                       splat(I[2]) * m->A_w.z + splat(I[1] - I[0]) * W->xy},
              across = {xz * K->x.y - xy * K->x.z + yz * (K->y.y - K->z.z),
                        xy * K->y.z - yz * K->y.x + xz * (K->z.z - K->x.x),
                        yz * K->z.x - xz * K->z.y + xy * (K->x.x - K->y.y)};
    return add(add(along, across), cross(vec_of(b->c), m->A_v));
}

/* *m: of the predecessor, then of the body. */
MBSRI_INLINE lane_bits load_body(const mbsri_batch_run *run, const mbsri_batch_body *b, int flags,
                                 ball_state *ball, body_state *s, motion *m)
{
    const lane_bits served = turn_joint(run, b, flags, ball, s);
    const turn theta = {s->c, s->s, s->c, s->s, s->s};
    vec w = m->A_w, v = m->A_v;
    if (!(flags & MBSRI_HERE)) v = add(v, times(&m->K, arm_of(run, b, flags)));
    w = to_own(b, flags, &theta, w);
    v = to_own(b, flags, &theta, v);
    m->omega = add_velocity(run, b, flags, ball, to_own(b, flags, &theta, m->omega), &w, &v);
    if (flags & MBSRI_BALL) {
        const lanes *udot = (const lanes *)run->load + b->u;
        w = transposed_times(&ball->R, add(w, (vec){udot[0], udot[1], udot[2]}));
        v = transposed_times(&ball->R, v);
    } else if (flags & MBSRI_HINGE || b->n > 0) {
        add_rate(b, flags, at(run->load, b->u), &w, &v);
    }
    m->A_w = w;
    m->A_v = v;
    m->squared = squared(m->omega);
    m->K = turning(&m->squared, w);
    if (flags & MBSRI_MASSLESS) {
        s->column.g_L = s->column.g_p = no_vec();
        return served;
    }
    s->column.g_L = moment_of(b, m);
    s->column.g_p = plus(times(&m->K, vec_of(b->c)), splat(b->mass), v);
    return served;
}

/* any: there are bodies in the sweeps, and all have been moved. */
MBSRI_INLINE lane_bits loads(const mbsri_batch_run *run, bool any)
{
    ball_state *ball = run->ball;
    motion *kept = run->motion, m;
    lane_bits served = {0};
    served = ~served;
    move_root(run);
    for (int i = 1; i <= run->bodies; ++i) {
        const mbsri_batch_body *b = run->body + i;
        body_state *s = (body_state *)run->state + i;
        if (any && b->flags & MBSRI_BLOCK) {
            accelerate_block(run, i, mbsri_block_accelerate, false);
            kept[i].K = turning(&kept[i].squared, kept[i].A_w);
            continue;
        }
        if (hangs_elsewhere(run, i, any)) m = kept[b->parent];
        if (b->flags & MBSRI_HINGE)
            served &= load_body(run, b, hinge_flags(b->flags), ball, s, &m);
        else
            served &= load_body(run, b, b->flags, ball, s, &m);
        if (any || b->flags & MBSRI_BRANCHES) kept[i] = m;
        if (b->flags & MBSRI_BALL) ++ball;
        if (any && b->flags & MBSRI_LOADED) add_wrench(run, i, s);
        if (any && b->flags & MBSRI_SEEN) lay_acceleration(run, i);
    }
    return served;
}

/* Joint forces of a body from the wrench (L, p), which goes to the predecessor's axes and origin.
 */
MBSRI_INLINE void balance(const mbsri_batch_run *run, const mbsri_batch_body *b, int flags,
                          const body_state *s, const ball_state *ball, vec *L, vec *p)
{
    const turn theta = {s->c, s->s, s->c, s->s, s->s};
    const lanes armature = splat(b->armature), *udot = (const lanes *)run->load + b->u;
    lanes *out = (lanes *)run->out + b->u;
    if (flags & MBSRI_HINGE) {
        *out = L->z;
    } else if (flags & MBSRI_BALL) {
        *L = times(&ball->R, *L);
        *p = times(&ball->R, *p);
        out[0] = L->x + armature * udot[0];
        out[1] = L->y + armature * udot[1];
        out[2] = L->z + armature * udot[2];
    } else if (b->n > 0) {
        lanes force = armature * *udot;
        if (flags & MBSRI_TURNS) force += L->z;
        if (flags & MBSRI_SLIDES) force += splat(b->pitch) * p->z;
        *out = force;
    }
    if (b->parent == 0) return;
    *L = to_pred(b, flags, &theta, *L);
    *p = to_pred(b, flags, &theta, *p);
    if (!(flags & MBSRI_HERE)) *L = add(*L, cross(arm_of(run, b, flags), *p));
}

MBSRI_INLINE void joint_forces(const mbsri_batch_run *run, bool any)
{
    const ball_state *ball = run->ball;
    vec L = no_vec(), p = no_vec();
    for (int i = 1; i <= run->bodies; ++i) ball += (run->body[i].flags & MBSRI_BALL) != 0;
    for (int i = run->bodies; i >= 1; --i) {
        const mbsri_batch_body *b = run->body + i;
        body_state *s = (body_state *)run->state + i;
        if (any && b->flags & MBSRI_BLOCK) {
            react_block(run, i, &L, &p);
        } else {
            if (b->flags & MBSRI_LEAF) L = p = no_vec();
            L = add(L, s->column.g_L);
            p = add(p, s->column.g_p);
            if (b->flags & MBSRI_BALL) --ball;
            if (b->flags & MBSRI_HINGE)
                balance(run, b, hinge_flags(b->flags), s, ball, &L, &p);
            else
                balance(run, b, b->flags, s, ball, &L, &p);
            if (any && b->flags & MBSRI_TO_BLOCK) give_force(run, i, L, p);
        }
        if (b->parent == 0 || b->flags & (MBSRI_NEXT | MBSRI_TO_BLOCK)) continue;
        column *pred = &((body_state *)run->state + b->parent)->column;
        pred->g_L = add(pred->g_L, L);
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
        .motion_size = sizeof(motion), .ball_size = sizeof(ball_state),                            \
        .stack_size = sizeof(carry), .place_size = sizeof(site), .gather = gather_states,          \
        .scatter = scatter, .forward = forward, .inverse = inverse, .move_seen = move_seen,        \
        .forward_seen = forward_seen, .inverse_seen = inverse_seen                                 \
    }

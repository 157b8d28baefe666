/* The tree that the vectorised sweeps run over, made when a model is finished.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/build.h"

#include "algebra/space3.h"
#include "base/memory.h"
#include "forces/gravity.h"
#include "inertias/exact.h"
#include "joints/chain.h"
#include "recursion/closures.h"
#include "recursion/rank.h"
#include "recursion/rates.h"
#include "sweeps/loops.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* Whether body i has a user's joint and is no block all the same. */
static bool asks(const mbsri_sweeps *tree, const mbsr_model *m, int i)
{
    return tree->users > 0 && m->body[i].survey.users;
}

/* Whether the joint is one axis that is not prescribed, or a weld; its step goes to *kind. */
static bool is_simple(const mbsri_joint *joint, int *kind)
{
    const int steps = joint->option[0], code = joint->option[1];
    *kind = steps == 0 ? 0 : code & MBSRI_STEP_KIND;
    return steps == 0 || (steps == 1 && !(code & MBSRI_DRIVEN) && *kind != MBSRI_QUATERNION);
}

static bool is_simple_of(const mbsr_model *m, int i, int *kind)
{
    double param[MBSRI_EMBED_PARAMS];
    const mbsri_joint chain = mbsri_embedded_joint(m->body + i, param);
    return is_simple(&chain, kind);
}

/* Whether body i has a moment that its tensor in double precision does not have: none does where z
 * is the axis of its joint. */
static bool hides_moment(const mbsr_model *m, int i, bool asks)
{
    const mbsr_inertia *inertia = &m->body[i].inertia;
    int kind;
    if (inertia->kind != MBSR_INERTIA_SPATIAL || !mbsri_exact_hides_moment(inertia)) return false;
    return asks || !is_simple_of(m, i, &kind) || kind == 0;
}

/* Whether body i is none of the blocks. */
static bool embeds(const mbsri_sweeps *tree, const mbsr_model *m, int i)
{
    if (tree->whole && m->body[i].survey.whole &&
        !(tree->massless_on_loop && m->body[i].loop.massless))
        return false;
    if (tree->with_loops && m->body[i].loop.by_blocks) return false;
    const bool users = asks(tree, m, i);
    return (users || mbsri_embeds(m, tree->bodies, i)) && !hides_moment(m, i, users);
}

static bool is_simple_body(const mbsri_sweeps *tree, const mbsr_model *m, int i)
{
    int kind;
    return !asks(tree, m, i) && is_simple_of(m, i, &kind);
}

/* How many bodies are blocks. */
static int count_blocks(const mbsri_sweeps *tree, const mbsr_model *m)
{
    int count = 0;
    for (int i = 1; i <= tree->bodies; ++i) count += !embeds(tree, m, i);
    return count;
}

/* ---- constants of the bodies ---- */

/* The frame that the sweeps use, in the body's own: z along the axis of frame B, its origin on
 * it. */
static mbsr_frame frame_in_body(const mbsri_joint *joint)
{
    int kind;
    if (!is_simple(joint, &kind) || kind == 0) return mbsr_frame_identity();
    const mbsr_frame turned = mbsr_frame_along(NULL, joint->param + MBSRI_AXES);
    mbsr_frame B;
    memcpy(B.x, joint->param + MBSRI_B, sizeof B.x);
    memcpy(B.R, joint->param + MBSRI_B + 3, sizeof B.R);
    return mbsr_frame_product(&B, &turned);
}

static mbsr_frame frame_of_body(const mbsri_sweeps *tree, const mbsr_model *m, int i)
{
    if (tree->body[i].flags & (MBSRI_BLOCK | MBSRI_USERS)) return mbsr_frame_identity();
    double param[MBSRI_EMBED_PARAMS];
    const mbsri_joint chain = mbsri_embedded_joint(m->body + i, param);
    return frame_in_body(&chain);
}

void mbsri_sweeps_own_origin(const mbsri_sweeps *tree, const mbsr_model *m, int i, double x[3])
{
    const mbsr_frame in_body = frame_of_body(tree, m, i), own = mbsr_frame_inverse(&in_body);
    memcpy(x, own.x, sizeof own.x);
}

/* A difference of places of that size: what is but their rounding is zero. Else it would be all the
 * lever arm of a point on an axis, and pass for inertia. */
static void drop_rounding(double size, double x[3])
{
    for (int k = 0; k < 3; ++k) {
        if (fabs(x[k]) <= 8.0 * DBL_EPSILON * size) x[k] = 0.0;
    }
}

/* The body's frame at q = 0 in its predecessor's own frame. */
static mbsr_frame frame_at_rest(const mbsri_joint *joint, const mbsr_frame *in_body)
{
    mbsr_frame A, B;
    memcpy(A.x, joint->param + MBSRI_A, sizeof A.x);
    memcpy(A.R, joint->param + MBSRI_A + 3, sizeof A.R);
    memcpy(B.x, joint->param + MBSRI_B, sizeof B.x);
    memcpy(B.R, joint->param + MBSRI_B + 3, sizeof B.R);
    const mbsr_frame back = mbsr_frame_inverse(&B), body = mbsr_frame_product(&A, &back);
    return mbsr_frame_product(&body, in_body);
}

static void pad(int columns, const double *from, double *to)
{
    for (int j = 0; j < columns; ++j) memcpy(to + 4 * j, from + 3 * j, 3 * sizeof *to);
}

/* lambda = min(m / 2, i / (L^2 + 2 |c|^2)), i the smallest principal moment about the centre of
 * mass, which is at least det / (trace / 2)^2. */
double mbsri_sweeps_regularity(const mbsr_inertia *inertia, double length)
{
    const double *t = inertia->tensor, *c = inertia->com;
    const double I[9] = {t[MBSR_XX], t[MBSR_XY], t[MBSR_XZ], t[MBSR_XY], t[MBSR_YY],
                         t[MBSR_YZ], t[MBSR_XZ], t[MBSR_YZ], t[MBSR_ZZ]};
    double minor[3];
    mbsri_cross3(I, I + 3, minor);
    const double half = 0.5 * (I[0] + I[4] + I[8]), determinant = mbsri_dot3(minor, I + 6);
    const double least = half > 0.0 ? determinant / (half * half) : 0.0, square = length * length;
    const double lambda = fmin(0.5 * inertia->mass, least / (square + 2.0 * mbsri_dot3(c, c)));
    return lambda > 1e-9 * (inertia->mass + half / square) ? lambda : 0.0;
}

/* Inertia about the origin and along the axes of the frame; how regular it is. */
static void place_inertia(const mbsr_inertia *given, const mbsr_frame *in_body, double length,
                          mbsri_sweep_body *b)
{
    const mbsr_frame body = mbsr_frame_inverse(in_body);
    mbsr_inertia inertia = mbsr_inertia_in_frame(&body, *given);
    drop_rounding(mbsri_norm3(given->com) + mbsri_norm3(in_body->x), inertia.com);
    for (int k = 0; k < 3; ++k) {
        if (inertia.com[k] == 0.0) inertia.com_rest[k] = 0.0;
    }
    /* about the frame's origin: there a moment of next to nothing about z is what it is */
    mbsri_exact about = mbsri_exact_of(&inertia);
    mbsri_exact_parallel_axes(about.mass, about.com, about.tensor);
    const double lambda = mbsri_sweeps_regularity(&inertia, length);
    if (lambda > 0.0) b->soft = 1.0 / lambda;
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k)
            b->I[4 * j + k] = mbsri_two_value(about.tensor[mbsri_tensor_place(j, k)]);
        b->c[j] = inertia.mass * inertia.com[j];
    }
    b->c[3] = inertia.mass;
    double largest = inertia.mass;
    for (int k = 0; k < 6; ++k) largest = fmax(largest, fabs(inertia.tensor[k]));
    if (largest == 0.0) b->flags |= MBSRI_MASSLESS;
}

static void place_block(mbsri_sweeps *tree, const mbsr_model *m, int i)
{
    const mbsri_body *body = m->body + i;
    tree->body[i] = (mbsri_sweep_body){.parent = body->parent,
                                       .q = body->iq,
                                       .u = body->iu,
                                       .n = body->n,
                                       .spread = 1.0,
                                       .flags = MBSRI_BLOCK | MBSRI_SHARP};
    if (mbsri_has_twist(body->joint.space) && mbsri_has_twist(body->pred.space))
        tree->body[i].flags |= MBSRI_BOUNDED;
    tree->block_of[tree->blocks++] = i;
    tree->rates = tree->rates && !mbsri_rates_need_tree(body);
}

static void place_users(mbsri_sweeps *tree, const mbsr_model *m, int i)
{
    const mbsri_body *body = m->body + i;
    tree->body[i] = (mbsri_sweep_body){.parent = body->parent,
                                       .q = body->iq,
                                       .u = body->iu,
                                       .n = body->n,
                                       .spread = 1.0,
                                       .flags = MBSRI_MULTI | MBSRI_USERS,
                                       .multi = tree->multi++};
}

/* Whether the joint is a free one, of the body's own frame along the axes of a root at rest. */
static bool is_free(const mbsr_model *m, const mbsri_body *body, const mbsri_joint *joint)
{
    static const int steps[5] = {4, MBSRI_TRANSLATION | 3 << MBSRI_PLACE_SHIFT,
                                 MBSRI_TRANSLATION | 4 << MBSRI_PLACE_SHIFT,
                                 MBSRI_TRANSLATION | 5 << MBSRI_PLACE_SHIFT, MBSRI_QUATERNION};
    const double *A = joint->param + MBSRI_A, *B = joint->param + MBSRI_B;
    bool plain = body->parent == 0 && m->root.space == MBSR_SPACE_FIXED && !joint->motion;
    for (int k = 0; k < 5; ++k) plain = plain && joint->option[k] == steps[k];
    for (int k = 0; k < 9 && plain; ++k) {
        const double unit = k % 4 == 0;
        plain = A[3 + k] == unit && B[3 + k] == unit && B[k / 3] == 0.0 &&
                joint->param[MBSRI_AXES + MBSRI_AXIS_SIZE * (k / 3) + k % 3] == unit;
    }
    return plain;
}

static void place_body(mbsri_sweeps *tree, const mbsr_model *m, int i)
{
    const mbsri_body *body = m->body + i;
    double param[MBSRI_EMBED_PARAMS];
    const mbsri_joint chain = mbsri_embedded_joint(body, param), *const joint = &chain;
    mbsri_sweep_body *b = tree->body + i;
    int kind;
    const bool simple = is_simple(joint, &kind);
    const mbsr_frame in_body = frame_in_body(joint);
    *b = (mbsri_sweep_body){
        .parent = body->parent, .q = body->iq, .u = body->iu, .n = body->n, .spread = 1.0};
    if (body->joint.space != MBSR_SPACE_SPATIAL) b->flags |= MBSRI_PLANE;
    mbsr_frame pred = mbsr_frame_identity();
    if (body->parent > 0) pred = frame_of_body(tree, m, body->parent);
    pred = mbsr_frame_inverse(&pred);
    if (simple) {
        const mbsr_frame rest = frame_at_rest(joint, &in_body);
        mbsr_frame frame = mbsr_frame_product(&pred, &rest);
        drop_rounding(mbsri_norm3(pred.x) + mbsri_norm3(joint->param + MBSRI_A) +
                          mbsri_norm3(joint->param + MBSRI_B),
                      frame.x);
        pad(3, frame.R, b->A);
        pad(1, frame.x, b->x);
        if (kind == MBSRI_ROTATION || kind == MBSRI_SCREW) b->flags |= MBSRI_TURNS;
        if (kind == MBSRI_TRANSLATION || kind == MBSRI_SCREW) b->flags |= MBSRI_SLIDES;
        b->pitch = kind == MBSRI_SCREW ? joint->param[MBSRI_AXES + 3]
                                       : (kind == MBSRI_TRANSLATION ? 1.0 : 0.0);
    } else {
        b->flags |= MBSRI_MULTI;
        b->multi = tree->multi++;
        mbsri_sweep_joint *seat = tree->joint + b->multi;
        memcpy(seat->R, pred.R, sizeof pred.R);
        memcpy(seat->x, pred.x, sizeof pred.x);
        seat->chain = mbsri_embedded_joint(body, seat->param);
        if (is_free(m, body, &seat->chain)) b->flags |= MBSRI_FREE;
    }
}

/* The mean distance of bodies from their predecessors, with those on the root or without; 0: there
 * is none. */
static double mean_distance(const mbsri_sweeps *tree, bool rooted)
{
    double sum = 0.0;
    int count = 0;
    for (int i = 1; i <= tree->bodies; ++i) {
        const double length = mbsri_norm3(tree->body[i].x);
        if (!(length > 0.0) || (tree->body[i].parent == 0 && !rooted)) continue;
        sum += length;
        ++count;
    }
    return count > 0 ? sum / count : 0.0;
}

/* A length typical of the tree. Nothing passes on to the root, so where mechanisms stand on it does
 * not count if there is something else. */
static double typical_length(const mbsri_sweeps *tree)
{
    const double inner = mean_distance(tree, false), all = mean_distance(tree, true);
    return inner > 0.0 ? inner : all > 0.0 ? all : 1.0;
}

/* In the plane from here to the root and to the leaves, errors about x and y do not matter. */
static void measure_planes(mbsri_sweeps *tree)
{
    tree->length = typical_length(tree);
    tree->area = tree->length * tree->length;
    tree->per_area = 1.0 / tree->area;
    for (int k = 0; k < 3; ++k) {
        tree->trace[0][k] = tree->per_area;
        tree->trace[0][4 + k] = 1.0;
        tree->trace[1][k] = k == 2 ? tree->per_area : 0.0;
        tree->trace[1][4 + k] = k == 2 ? 0.0 : 1.0;
    }
}

/* The inertia of body i of the tree with those of the bodies that are welded to it, along its own
 * axes. */
static mbsr_inertia whole_inertia(const mbsri_sweeps *tree, const mbsr_model *m, int i)
{
    mbsr_inertia sum = mbsri_embedded_inertia(m->body + i, tree->length);
    for (int k = m->body[i].on.welded; k > 0; k = m->stand[k - 1].next) {
        const mbsri_stand *stand = m->stand + (k - 1);
        const mbsr_inertia part = mbsri_embedded_inertia(m->body + m->live + k, tree->length);
        sum = mbsr_inertia_sum(sum, mbsr_inertia_in_frame(&stand->frame, part));
    }
    return sum;
}

static void place_inertias(mbsri_sweeps *tree, const mbsr_model *m)
{
    measure_planes(tree);
    for (int i = 1; i <= tree->bodies; ++i) {
        mbsri_sweep_body *b = tree->body + i;
        const double stretch = 1.0 + mbsri_norm3(b->x) / tree->length;
        const mbsr_frame in_body = frame_of_body(tree, m, i);
        b->spread = stretch * stretch;
        if (!mbsri_embeds_inertia(m->body + i)) continue; /* of a block */
        const mbsr_inertia inertia = whole_inertia(tree, m, i);
        place_inertia(&inertia, &in_body, tree->length, b);
    }
}

static void place_angles(mbsri_sweeps *tree)
{
    int last = -1;
    for (int i = 1; i <= tree->bodies; ++i) {
        const mbsri_sweep_body *b = tree->body + i;
        if (!(b->flags & MBSRI_TURNS)) continue;
        if (last < 0) tree->first_angle = b->q;
        last = b->q;
    }
    tree->angles = last < 0 ? 0 : last + 1 - tree->first_angle;
}

/* Bodies with none but bodies in the plane behind them, themselves included. */
static void mark_flat(mbsri_sweeps *tree, const mbsr_model *m)
{
    for (int i = 1; i <= tree->bodies; ++i) {
        const mbsr_space space = m->body[i].joint.space;
        if (space == MBSR_SPACE_PLANAR || space == MBSR_SPACE_POINT)
            tree->body[i].flags |= MBSRI_FLAT;
    }
    for (int i = tree->bodies; i >= 1; --i) {
        const mbsri_sweep_body *b = tree->body + i;
        if (!(b->flags & MBSRI_FLAT)) tree->body[b->parent].flags &= ~MBSRI_FLAT;
    }
    for (int i = 1; i <= tree->bodies; ++i) {
        mbsri_sweep_body *b = tree->body + i;
        const bool level = b->parent == 0 || tree->body[b->parent].flags & MBSRI_LEVEL;
        if (level && b->flags & MBSRI_FLAT) b->flags |= MBSRI_LEVEL;
    }
}

/* How the backward sweep hands Mbar on: to the body before, or through the stack; blocks keep what
 * they get in arrays of their own. */
static void place_hand_overs(mbsri_sweeps *tree)
{
    int waiting = 0;
    for (int i = 0; i <= tree->bodies; ++i) {
        if (!(tree->body[i].flags & MBSRI_BLOCK)) tree->body[i].flags |= MBSRI_LEAF;
    }
    for (int i = tree->bodies; i >= 1; --i) {
        mbsri_sweep_body *b = tree->body + i, *pred = tree->body + b->parent;
        const bool last = (pred->flags & MBSRI_LEAF) != 0;
        if (b->flags & MBSRI_BRANCHES) --waiting;
        if (b->parent > 0 && !(pred->flags & (MBSRI_BLOCK | MBSRI_PLANE))) b->flags |= MBSRI_SIX;
        if (pred->flags & MBSRI_BLOCK) {
            b->flags |= MBSRI_NEXT | MBSRI_TO_BLOCK;
            if (!(b->flags & MBSRI_SHARP)) pred->flags &= ~MBSRI_SHARP;
            continue;
        }
        if (b->parent == 0 || b->parent == i - 1) {
            b->flags |= MBSRI_NEXT;
        } else if (last) {
            b->flags |= MBSRI_OPENS;
            if (++waiting > tree->depth) tree->depth = waiting;
        }
        if (b->parent > 0 && !last) pred->flags |= MBSRI_BRANCHES;
        pred->flags &= ~MBSRI_LEAF;
    }
}

/* Marks the bodies on which an element acts. */
static void mark_loaded(mbsri_sweeps *tree, const mbsr_model *m, const mbsri_force *force)
{
    const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    const int marks = MBSRI_LOADED | MBSRI_ACTED;
    for (int i = 1; i <= tree->bodies && every; ++i) tree->body[i].flags |= marks;
    for (int l = 0; l < force->def.bodies && !every; ++l) {
        const int i = m->stored.list_index[force->list + (size_t)l];
        if (i > 0) tree->body[i].flags |= marks;
    }
}

/* Those on which closures act. */
static void mark_closed(mbsri_sweeps *tree, const mbsr_model *m)
{
    const mbsri_closure *c = m->closures.data;
    for (size_t k = 0; k < m->closures.count; ++k, ++c) {
        if (mbsri_is_coupling(c)) continue;
        /* above those that stand to each other somehow, a common displacement changes nothing */
        const bool relative = (c->def.table->flags & MBSR_CLOSURE_RELATIVE) != 0;
        const int marks = relative ? MBSRI_LOADED : MBSRI_LOADED | MBSRI_ACTING;
        for (int l = 0; l < c->bodies; ++l) {
            if (c->body[l] > 0) tree->body[c->body[l]].flags |= marks;
        }
    }
}

/* Where Newton systems carry loops in vector code. */
static void mark_fronts(mbsri_sweeps *tree, const mbsr_model *m)
{
    for (int i = 1; i <= tree->bodies && tree->with_loops; ++i) {
        if (tree->body[i].flags & MBSRI_BLOCK) continue;
        if (m->body[i].loop.spans) tree->body[i].flags |= MBSRI_FRONT;
        if (m->body[i].loop.closes) tree->body[i].flags |= MBSRI_CLOSES;
    }
}

static void collect_forces(mbsri_sweeps *tree, const mbsr_model *m)
{
    const mbsri_force *force = m->forces.data;
    tree->body_forces = tree->blocks > 0 || tree->users > 0 || m->rows > 0;
    mark_closed(tree, m);
    for (size_t k = 0; k < m->forces.count; ++k, ++force) {
        const unsigned flags = force->def.table->flags;
        if (force->resting) continue;
        if (mbsri_is_gravity(&force->def)) {
            mbsri_add3(1.0, force->def.param, tree->gravity);
        } else if (flags & MBSR_FORCE_JOINT_ONLY) {
            tree->joint_forces = true;
        } else {
            tree->body_forces = true;
            tree->masses = tree->masses || !(flags & MBSR_FORCE_NO_MASS);
            mark_loaded(tree, m, force);
        }
    }
}

/* Blocks place themselves. */
static void mark_placed(mbsri_sweeps *tree)
{
    const int seen = MBSRI_LOADED | MBSRI_BLOCK | MBSRI_USERS | MBSRI_PLACED;
    for (int i = tree->bodies; i >= 1; --i) {
        mbsri_sweep_body *b = tree->body + i, *pred = tree->body + b->parent;
        if (!(b->flags & seen)) continue;
        if (!(b->flags & MBSRI_BLOCK)) b->flags |= MBSRI_PLACED;
        if (!(pred->flags & MBSRI_BLOCK)) pred->flags |= MBSRI_PLACED;
    }
}

static bool has_inertia(const mbsri_sweep_body *b, const mbsri_body *body)
{
    bool any = !(b->flags & MBSRI_MASSLESS);
    for (int k = 0; k < body->n; ++k) any = any || body->mass.armature[k] > 0.0;
    return any;
}

/* What of the tree Newton systems with loops take for wide, and for heavy. */
static void mark_widths(mbsri_sweeps *tree, const mbsr_model *m)
{
    for (int i = tree->bodies; i >= 1 && tree->with_loops; --i) {
        mbsri_sweep_body *b = tree->body + i, *pred = tree->body + b->parent;
        if (b->flags & MBSRI_ACTED) b->flags |= MBSRI_ACTING;
        if (b->flags & (MBSRI_ACTING | MBSRI_FRONT)) b->flags |= MBSRI_WIDE_JOINT;
        if (b->flags & (MBSRI_WIDE_JOINT | MBSRI_LOADED | MBSRI_CLOSES)) b->flags |= MBSRI_WIDE;
        if (b->flags & MBSRI_WIDE_JOINT) pred->flags |= MBSRI_WIDE;
        if (has_inertia(b, m->body + i)) b->flags |= MBSRI_HEAVY;
        pred->flags |= b->flags & (MBSRI_ACTING | MBSRI_HEAVY);
    }
    for (int i = 1; i <= tree->bodies; ++i) {
        mbsri_sweep_body *b = tree->body + i;
        if (b->parent > 0 && tree->body[b->parent].flags & MBSRI_WIDE) b->flags |= MBSRI_TO_WIDE;
    }
}

/* The bodies' own frames in those of the sweeps, where force elements need them. */
static bool place_own_frames(mbsri_sweeps *tree, const mbsr_model *m)
{
    if (!tree->body_forces) return true;
    const size_t size = ((size_t)tree->bodies + 1) * sizeof *tree->own;
    tree->own = mbsri_allocate(&m->allocator, size + (size_t)tree->bodies * sizeof *tree->loaded);
    if (!tree->own) return false;
    tree->loaded = (int *)(void *)((unsigned char *)tree->own + size);
    for (int i = 1; i <= tree->bodies; ++i) {
        if ((tree->body[i].flags & (MBSRI_LOADED | MBSRI_BLOCK)) == MBSRI_LOADED)
            tree->loaded[tree->loads++] = i;
    }
    for (int i = 1; i <= tree->bodies; ++i) {
        const mbsr_frame in_body = frame_of_body(tree, m, i), own = mbsr_frame_inverse(&in_body);
        memcpy(tree->own[i].R, own.R, sizeof own.R);
        memcpy(tree->own[i].x, own.x, sizeof own.x);
        mbsri_embedded_angle(m->body + i, &tree->own[i].angle, &tree->own[i].coordinate);
    }
    return true;
}

/* NULL: built without vector types. No model then has sweeps, and the stages serve all. */
static const mbsri_sweep_kernels *choose_kernels(void)
{
#if defined(MBSR_WITHOUT_VECTORS)
    return NULL;
#else
#if defined(MBSR_WITH_V3)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return &mbsri_sweeps_v3;
#endif
    return &mbsri_sweeps_base;
#endif
}

static bool allocate_tree(mbsri_sweeps *tree, const mbsr_model *m, int blocks)
{
    const int bodies = tree->bodies;
    int multi = 0;
    for (int i = 1; i <= bodies; ++i) multi += embeds(tree, m, i) && !is_simple_body(tree, m, i);
    tree->block = mbsri_allocate(&m->allocator, ((size_t)bodies + 1) * sizeof *tree->body + 64);
    tree->joint = mbsri_allocate(&m->allocator, (size_t)multi * sizeof *tree->joint);
    tree->block_of = mbsri_allocate(&m->allocator, (size_t)blocks * sizeof *tree->block_of);
    return tree->block && tree->joint && tree->block_of;
}

static void release_sweeps(const mbsr_model *m, mbsri_sweeps *tree)
{
    if (!tree) return;
    mbsri_sweeps_release_loops(m, tree);
    mbsri_release(&m->allocator, tree->block);
    mbsri_release(&m->allocator, tree->joint);
    mbsri_release(&m->allocator, tree->block_of);
    mbsri_release(&m->allocator, tree->own);
    mbsri_release(&m->allocator, tree);
}

/* Whether bodies of the sweeps are behind some flexible body. */
static bool has_modal(const mbsri_sweeps *tree, const mbsr_model *m)
{
    bool modal = false;
    for (int i = 1; i <= tree->bodies; ++i)
        modal = modal || (m->body[i].flexible.modal && !(tree->body[i].flags & MBSRI_SHARP));
    return modal;
}

static void place_armature(const mbsri_body *body, mbsri_sweep_body *b)
{
    if (b->n > 0) b->armature = body->mass.armature[0];
    b->mixes = b->armature > 0.0;
}

/* Everything of a tree that has memory for its bodies. */
static bool place_in_tree(mbsri_sweeps *tree, const mbsr_model *m)
{
    const uintptr_t above = (uintptr_t)tree->block % 64;
    tree->body = (void *)((unsigned char *)tree->block + (above ? 64 - above : 0));
    memset(tree->body, 0, sizeof *tree->body);
    for (int i = 1; i <= tree->bodies; ++i) {
        if (!embeds(tree, m, i))
            place_block(tree, m, i);
        else if (asks(tree, m, i))
            place_users(tree, m, i);
        else
            place_body(tree, m, i);
    }
    for (int i = 1; i <= tree->bodies; ++i) place_armature(m->body + i, tree->body + i);
    place_inertias(tree, m);
    place_angles(tree);
    mark_flat(tree, m);
    place_hand_overs(tree);
    tree->modal = has_modal(tree, m);
    mark_fronts(tree, m);
    collect_forces(tree, m);
    mark_placed(tree);
    mark_widths(tree, m);
    return place_own_frames(tree, m);
}

/* Which bodies are blocks: those that are whole, unless they are light; on loops; not so many with
 * users' joints. */
typedef struct selection {
    bool whole, with_loops, massless_on_loop;
    int users;
} selection;

static bool build_sweeps(const mbsr_model *m, selection s, mbsri_sweeps **built)
{
    mbsri_sweeps *tree = mbsri_allocate(&m->allocator, sizeof *tree);
    if (!tree) return false;
    *tree = (mbsri_sweeps){.bodies = m->live,
                           .rule = mbsri_rank_rule_of(m->rank_tolerance),
                           .rates = true,
                           .users = s.users,
                           .whole = s.whole,
                           .with_loops = s.with_loops,
                           .massless_on_loop = s.massless_on_loop,
                           .kernels = choose_kernels()};
    const int blocks = count_blocks(tree, m);
    const bool memory = allocate_tree(tree, m, blocks) && place_in_tree(tree, m);
    if (memory)
        *built = tree;
    else
        release_sweeps(m, tree);
    return memory;
}

bool mbsri_sweeps_build(mbsr_model *m)
{
    if (!choose_kernels()) return true;
    if (!build_sweeps(m, (selection){0}, &m->tree.plain)) return false;
    m->tree.newton = m->tree.evaluated = m->tree.plain;
    return true;
}

/* ---- loops in Newton systems ---- */

/* The bodies of closure c up to where it closes, and that one: whether some are blocks; or all of
 * them are from now on. */
static bool any_by_blocks(const mbsr_model *m, const mbsri_closure *c)
{
    bool any = c->meets > 0 && m->body[c->meets].loop.by_blocks;
    for (int k = 0; k < c->def.bodies; ++k) {
        for (int i = c->body[k]; i > c->meets && !any; i = m->body[i].parent)
            any = m->body[i].loop.by_blocks;
    }
    return any;
}

static bool leave_to_blocks(mbsr_model *m, const mbsri_closure *c)
{
    bool changed = c->meets > 0 && !m->body[c->meets].loop.by_blocks;
    if (c->meets > 0) m->body[c->meets].loop.by_blocks = true;
    for (int k = 0; k < c->def.bodies; ++k) {
        for (int i = c->body[k]; i > c->meets; i = m->body[i].parent) {
            changed = changed || !m->body[i].loop.by_blocks;
            m->body[i].loop.by_blocks = true;
        }
    }
    return changed;
}

/* Whether the body has inertia, or the rates of its joint. */
static bool is_heavy(const mbsri_body *b)
{
    if (!mbsri_embeds_inertia(b)) return true;
    const mbsr_inertia inertia = mbsri_embedded_inertia(b, 1.0);
    bool any = inertia.mass > 0.0;
    for (int k = 0; k < 6; ++k) any = any || inertia.tensor[k] != 0.0;
    for (int k = 0; k < b->n; ++k) any = any || b->mass.armature[k] > 0.0;
    return any;
}

static void mark_empty(mbsr_model *m)
{
    for (int i = 0; i <= m->bodies; ++i) m->body[i].loop.empty = i > 0 && !is_heavy(m->body + i);
    for (int i = m->bodies; i >= 1; --i) {
        if (!m->body[i].loop.empty) m->body[m->body[i].parent].loop.empty = false;
    }
}

/* Which bodies on loops are light: empty, and the rows of the loops past them are enough to hold
 * all their rates. False: no memory. */
static bool mark_light(mbsr_model *m)
{
    const mbsri_closure *c = m->closures.data;
    int *excess = mbsri_allocate(&m->allocator, ((size_t)m->bodies + 1) * sizeof *excess);
    if (!excess) return false;
    for (int i = 0; i <= m->bodies; ++i) {
        m->body[i].loop.massless = m->body[i].loop.spans && m->body[i].loop.empty;
        excess[i] = m->body[i].n;
    }
    for (int i = m->bodies; i >= 1; --i) {
        mbsri_body *b = m->body + i;
        if (!b->loop.massless) m->body[b->parent].loop.massless = false;
        excess[b->parent] += excess[i];
    }
    for (size_t k = 0; k < m->closures.count; ++k) {
        for (int l = 0; l < c[k].def.bodies; ++l) {
            for (int i = c[k].body[l]; i > c[k].meets; i = m->body[i].parent)
                excess[i] -= c[k].rows;
        }
    }
    for (int i = 1; i <= m->bodies; ++i) {
        mbsri_body *b = m->body + i;
        if (m->body[b->parent].loop.massless && excess[b->parent] > 0) excess[i] = 1;
    }
    for (int i = 1; i <= m->bodies; ++i)
        m->body[i].loop.massless = m->body[i].loop.massless && excess[i] <= 0;
    mbsri_release(&m->allocator, excess);
    return true;
}

/* Loops that have bodies in common are in vector code together, or not. True: all of the tree is.
 */
static bool choose_loops(mbsr_model *m, selection s)
{
    const mbsri_sweeps plan = {.bodies = m->live,
                               .whole = s.whole,
                               .with_loops = true,
                               .massless_on_loop = s.massless_on_loop};
    const mbsri_closure *c = m->closures.data;
    const size_t count = m->closures.count;
    for (int i = 1; i <= m->live; ++i) {
        mbsri_body *b = m->body + i;
        b->loop.by_blocks = false; /* which embeds asks for */
        b->loop.by_blocks = (b->loop.spans || b->loop.closes) && !embeds(&plan, m, i);
    }
    bool changed = true;
    for (size_t k = 0; k < count; ++k) {
        if (mbsri_reads_joints(c + k) && !mbsri_is_coupling(c + k)) (void)leave_to_blocks(m, c + k);
    }
    while (changed) {
        changed = false;
        for (size_t k = 0; k < count; ++k)
            changed = (any_by_blocks(m, c + k) && leave_to_blocks(m, c + k)) || changed;
    }
    return count_blocks(&plan, m) == 0;
}

/* Whether forward dynamics with loops has a sweep. */
static bool carries_loops(const mbsr_model *m)
{
    const mbsri_sweeps *tree = m->tree.evaluated;
    return tree->blocks == 0 && !tree->whole && !tree->modal && m->root.space == MBSR_SPACE_FIXED;
}

/* Whether some body is whole for another reason than that nothing there has inertia. */
static bool any_left_whole(const mbsr_model *m)
{
    bool any = false;
    for (int i = 1; i <= m->bodies; ++i)
        any = any || (m->body[i].survey.whole && !m->body[i].loop.empty);
    return any;
}

bool mbsri_sweeps_build_others(mbsr_model *m)
{
    selection s = {0};
    if (!m->tree.plain && m->rows == 0) return true;
    for (int i = 1; i <= m->bodies; ++i) {
        s.whole = s.whole || m->body[i].survey.whole;
        s.users += m->body[i].survey.users;
    }
    selection eliminated = {.whole = s.whole, .with_loops = m->rows > 0, .massless_on_loop = true};
    if (m->rows > 0) {
        mark_empty(m);
        if (!mark_light(m)) return false;
        /* beside blocks, bodies without inertia are eliminated by those (newton/sweeps/looped.h) */
        if (!choose_loops(m, eliminated)) {
            eliminated.massless_on_loop = false;
            (void)choose_loops(m, eliminated);
        }
    }
    if (!choose_kernels()) return true;
    if ((s.whole || m->rows > 0) && !build_sweeps(m, eliminated, &m->tree.newton)) return false;
    m->tree.evaluated = m->tree.newton;
    if (s.users == 0 && m->rows == 0) return true;
    if (m->rows > 0) s.whole = any_left_whole(m); /* or D is zero for good: multi_axis.h */
    if (!build_sweeps(m, s, &m->tree.evaluated)) return false;
    return m->rows == 0 || !carries_loops(m) || mbsri_sweeps_plan_loops(m->tree.evaluated, m);
}

void mbsri_sweeps_release(mbsr_model *m)
{
    if (m->tree.evaluated != m->tree.newton) release_sweeps(m, m->tree.evaluated);
    if (m->tree.newton != m->tree.plain) release_sweeps(m, m->tree.newton);
    release_sweeps(m, m->tree.plain);
    m->tree.plain = m->tree.newton = m->tree.evaluated = NULL;
}

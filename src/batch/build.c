/* Making the object for batches of states: the tree with joints of several axes taken apart, and
 * one block of memory.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "batch/build.h"
#include "batch/frames.h"

#include "algebra/space3.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/threads.h"
#include "joints/chain.h"
#include "sweeps/dynamics.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdint.h>
#include <string.h>

/* ---- joints of several axes ---- */

static mbsr_frame frame_of_param(const double param[12])
{
    mbsr_frame frame;
    memcpy(frame.x, param, sizeof frame.x);
    memcpy(frame.R, param + 3, sizeof frame.R);
    return frame;
}

static void place_frame(const mbsr_frame *frame, mbsri_sweep_body *b)
{
    for (int j = 0; j < 3; ++j) memcpy(b->A + 4 * j, frame->R + 3 * j, 3 * sizeof *b->A);
    memcpy(b->x, frame->x, sizeof frame->x);
}

static bool is_identity(const mbsr_frame *frame)
{
    const mbsr_frame identity = mbsr_frame_identity();
    for (int k = 0; k < 9; ++k) {
        if (frame->R[k] != identity.R[k]) return false;
    }
    return frame->x[0] == 0.0 && frame->x[1] == 0.0 && frame->x[2] == 0.0;
}

/* A step's body: its kind, coordinates (counted by *moved where they are prescribed) and the frame
 * that it moves; *frame is where the last step left the running frame, then the running frame in
 * that of this step. */
static void place_step(const mbsri_joint *joint, int step, const mbsri_sweep_body *whole,
                       const double *armature, mbsr_frame *frame, int *moved, mbsri_sweep_body *b)
{
    const int code = joint->option[1 + step], kind = code & MBSRI_STEP_KIND,
              coordinate = code >> MBSRI_PLACE_SHIFT;
    const double *axis = joint->param + MBSRI_AXES + MBSRI_AXIS_SIZE * step;
    const bool ball = kind == MBSRI_QUATERNION;
    const mbsr_frame along = ball ? mbsr_frame_identity() : mbsr_frame_along(NULL, axis);
    const mbsr_frame start = mbsr_frame_product(frame, &along);
    *b = (mbsri_sweep_body){.spread = 1.0,
                            .q = whole->q + (ball ? 0 : coordinate + joint->nq - joint->n),
                            .u = whole->u + coordinate,
                            .n = ball ? 3 : 1,
                            .armature = code & MBSRI_DRIVEN ? 0.0 : armature[coordinate],
                            .flags = whole->flags & (MBSRI_FLAT | MBSRI_LEVEL)};
    place_frame(&start, b);
    if (ball) b->flags |= MBSRI_BALL;
    if (code & MBSRI_DRIVEN) {
        b->flags |= MBSRI_MOVED;
        b->q = (*moved)++;
        b->n = 0;
    }
    if (kind == MBSRI_ROTATION || kind == MBSRI_SCREW) b->flags |= MBSRI_TURNS;
    if (kind == MBSRI_TRANSLATION || kind == MBSRI_SCREW) b->flags |= MBSRI_SLIDES;
    b->pitch = kind == MBSRI_SCREW ? axis[3] : (kind == MBSRI_TRANSLATION ? 1.0 : 0.0);
    *frame = mbsr_frame_inverse(&along);
}

/* The bodies that stand for body i, at most MBSRI_MAX_STEPS + 1; returns their number. The first
 * hangs on the predecessor, the last has the inertia and the successors. */
static int take_apart(const mbsr_model *m, int i, int *moved, mbsri_sweep_body *list)
{
    const mbsri_sweeps *tree = m->tree.plain;
    const mbsri_sweep_body *whole = tree->body + i;
    if (!(whole->flags & MBSRI_MULTI)) { /* blocks among them */
        *list = *whole;
        return 1;
    }
    const mbsri_sweep_joint *predecessor = tree->joint + whole->multi;
    const mbsri_joint *joint = &predecessor->chain;
    mbsr_frame own, A = frame_of_param(joint->param + MBSRI_A),
                    B = frame_of_param(joint->param + MBSRI_B);
    memcpy(own.R, predecessor->R, sizeof own.R);
    memcpy(own.x, predecessor->x, sizeof own.x);
    mbsr_frame frame = mbsr_frame_product(&own, &A);
    int count = 0;
    for (; count < joint->option[0]; ++count)
        place_step(joint, count, whole, m->body[i].mass.armature, &frame, moved, list + count);
    B = mbsr_frame_inverse(&B);
    frame = mbsr_frame_product(&frame, &B);
    if (!is_identity(&frame)) {
        list[count] = (mbsri_sweep_body){.spread = 1.0};
        place_frame(&frame, list + count++);
    }
    return count;
}

/* What the parts of a body have to do with the rest of the tree. */
static void join_parts_of_body(const mbsr_model *m, int i, int count, mbsri_sweep_body *part)
{
    const mbsri_sweeps *tree = m->tree.plain;
    const mbsri_sweep_body *whole = tree->body + i;
    const int above = MBSRI_NEXT | MBSRI_OPENS | MBSRI_TO_BLOCK,
              below = MBSRI_LEAF | MBSRI_BRANCHES | MBSRI_LOADED | MBSRI_PLANE;
    mbsri_sweep_body *last = part + count - 1;
    for (int k = 0; k < count; ++k) {
        mbsri_sweep_body *b = part + k;
        const double stretch = 1.0 + mbsri_norm3(b->x) / tree->length;
        b->spread = stretch * stretch;
        b->flags &= ~(above | below);
        b->flags |= k == 0 ? whole->flags & above : MBSRI_NEXT;
        if (b != last) b->flags |= MBSRI_MASSLESS;
        if (mbsri_norm3(b->x) == 0.0 && !(b->flags & MBSRI_SLIDES)) b->flags |= MBSRI_HERE;
    }
    last->flags |= whole->flags & (below | MBSRI_MASSLESS);
    memcpy(last->I, whole->I, sizeof last->I);
    memcpy(last->c, whole->c, sizeof last->c);
    last->soft = whole->soft;
    if (m->body[i].survey.in_sweeps && !(whole->flags & MBSRI_BLOCK)) last->flags |= MBSRI_SEEN;
}

/* What the tree of a model becomes: bodies, quaternions, prescribed coordinates. */
typedef struct parts {
    int bodies, balls, moved;
} parts;

/* False: the lanes do not serve the model. */
static bool count_parts(const mbsr_model *m, parts *n)
{
    mbsri_sweep_body list[MBSRI_MAX_STEPS + 1];
    *n = (parts){0, 0, 0};
    if (!m->tree.plain || m->tree.plain->blocks == m->bodies) return false;
    for (int i = 1; i <= m->live; ++i) {
        const int count = take_apart(m, i, &n->moved, list);
        n->bodies += count;
        for (int k = 0; k < count; ++k) n->balls += (list[k].flags & MBSRI_BALL) != 0;
    }
    return true;
}

/* last: bodies + 1 places to work in, for each body of the model where its last part is; origin, if
 * not NULL: the other way round. */
static void place_tree(const mbsr_model *m, int *last, mbsri_batch_body *body, int *origin)
{
    mbsri_sweep_body part[MBSRI_MAX_STEPS + 1];
    int moved = 0, next = 1;
    mbsri_batch_take(m->tree.plain->body, 0, body);
    last[0] = 0;
    for (int i = 1; i <= m->live; ++i) {
        const int count = take_apart(m, i, &moved, part),
                  parent = last[m->tree.plain->body[i].parent];
        join_parts_of_body(m, i, count, part);
        for (int k = 0; k < count; ++k, ++next) {
            mbsri_batch_take(part + k, k ? next - 1 : parent, body + next);
            if (origin) origin[next] = k == count - 1 ? i : 0;
        }
        last[i] = next - 1;
    }
    if (origin) origin[0] = 0;
    mbsri_batch_align(next - 1, body);
}

/* ---- memory ---- */

static size_t lean_size(const mbsr_model *m)
{
    const size_t size = mbsr_data_size_lean(m);
    return (size + MBSR_DATA_ALIGNMENT - 1) / MBSR_DATA_ALIGNMENT * MBSR_DATA_ALIGNMENT;
}

/* Whether some body is looked at state by state. */
static bool has_seen(const mbsr_model *m)
{
    return m->tree.plain->body_forces;
}

/* Places the object and its arrays in `base`, or with base == NULL only returns the size. lane:
 * where the first of the lanes' data is, if there are any. */
static size_t lay_out_batch(const mbsr_model *m, const mbsri_batch_kernels *kernels, parts n,
                            unsigned char *base, mbsr_batch **batch, void **data, void **lane)
{
    mbsr_batch counted;
    size_t used = 0;
    mbsr_batch *b = mbsri_take_bytes(base, &used, sizeof *b);
    *data = mbsri_take_bytes(base, &used, mbsr_data_size(m));
    *batch = b;
    if (!kernels) return used;
    if (!b) b = &counted;
    const size_t N = (size_t)n.bodies + 1, scalar = (size_t)kernels->lanes * sizeof(double);
    b->body = mbsri_take_bytes(base, &used, N * sizeof *b->body);
    b->run.state = mbsri_take_bytes(base, &used, N * kernels->state_size);
    b->run.motion = mbsri_take_bytes(base, &used, N * kernels->motion_size);
    b->run.ball = mbsri_take_bytes(base, &used, (size_t)n.balls * kernels->ball_size);
    b->run.stack =
        mbsri_take_bytes(base, &used, (size_t)m->tree.plain->depth * kernels->stack_size);
    b->run.drive = mbsri_take_bytes(base, &used, 3 * (size_t)n.moved * sizeof *b->run.drive);
    b->q = mbsri_take_bytes(base, &used, (size_t)m->nq * scalar);
    b->u = mbsri_take_bytes(base, &used, (size_t)m->nu * scalar);
    b->load = mbsri_take_bytes(base, &used, (size_t)m->nu * scalar);
    b->run.out = mbsri_take_bytes(base, &used, (size_t)m->nu * scalar);
    b->q_place = m->order.as_given
                     ? NULL
                     : mbsri_take_bytes(base, &used, (size_t)m->nq * sizeof *b->q_place);
    b->u_place = m->order.as_given
                     ? NULL
                     : mbsri_take_bytes(base, &used, (size_t)m->nu * sizeof *b->u_place);
    if (!has_seen(m)) return used;
    b->run.place = mbsri_take_bytes(base, &used, N * kernels->place_size);
    b->run.lane = mbsri_take_bytes(base, &used, (size_t)kernels->lanes * sizeof *b->run.lane);
    b->origin = mbsri_take_bytes(base, &used, N * sizeof *b->origin);
    *lane = mbsri_take_bytes(base, &used, (size_t)kernels->lanes * lean_size(m));
    return used;
}

/* Every lane has data, in which bodies that are no blocks have full rank: other states go alone. */
static int start_lanes(const mbsr_model *m, mbsr_batch *b, unsigned char *memory, mbsr_error *error)
{
    int status = MBSR_OK;
    for (int l = 0; l < b->kernels->lanes && !status; ++l) {
        mbsr_data *d;
        status = mbsr_data_init_lean(m, memory + (size_t)l * lean_size(m), lean_size(m), &d, error);
        if (!status) mbsri_sweeps_attach(b->run.lane + l, m, m->tree.plain, d);
    }
    return status;
}

static void place_coordinates(const mbsr_model *m, mbsr_batch *b)
{
    for (int k = 0; k < m->nq && b->q_place; ++k) b->q_place[m->order.q_of[k]] = k;
    for (int k = 0; k < m->nu && b->u_place; ++k) b->u_place[m->order.u_of[k]] = k;
}

static int begin_batch(const mbsr_model *m, const mbsri_batch_kernels *kernels, int bodies,
                       void *lane, mbsr_batch *b, mbsr_error *error)
{
    b->model = m;
    b->kernels = kernels;
    b->error = (mbsr_error){MBSR_OK, MBSR_NONE, MBSR_NONE, ""};
    b->failed = -1;
    b->single = 0;
    b->allocator = m->allocator;
    b->result = MBSR_OK;
    b->shares = 1;
    b->share = NULL;
    if (!kernels) return MBSR_OK;
    place_coordinates(m, b);
    const double length = m->tree.plain->length;
    b->run.bodies = bodies;
    b->run.body = b->body;
    b->run.q = b->q;
    b->run.u = b->u;
    b->run.load = b->load;
    b->run.area = length * length;
    b->run.per_area = 1.0 / b->run.area;
    b->run.rule = mbsri_rank_rule_of(m->rank_tolerance);
    if (!lane) {
        b->run.lane = NULL;
        b->origin = NULL;
    }
    b->run.origin = b->origin;
    /* in place of states a list, which is done with before the first call */
    place_tree(m, b->run.state, b->body, b->origin);
    return lane ? start_lanes(m, b, lane, error) : MBSR_OK;
}

int mbsri_batch_make(const mbsr_model *model, const mbsri_batch_kernels *kernels,
                     mbsr_batch **batch, mbsr_error *error)
{
    parts n;
    void *data, *lane = NULL;
    if (batch) *batch = NULL;
    if (!model || !batch) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "mbsr_batch_create: %s is NULL", !model ? "model" : "batch");
    }
    if (!model->finished) {
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "mbsr_batch_create: the model is not finished");
    }
    if (model->rows > 0) {
        return mbsri_fail(error, MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE,
                          "mbsr_batch_create: the model has closures, which batches do not serve");
    }
    if (!count_parts(model, &n)) kernels = NULL;
    const size_t size = lay_out_batch(model, kernels, n, NULL, batch, &data, &lane);
    unsigned char *block = mbsri_allocate(&model->allocator, size + MBSR_DATA_ALIGNMENT);
    if (!block) {
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_batch_create: no memory for %zu bytes", size);
    }
    const size_t above = (uintptr_t)block % MBSR_DATA_ALIGNMENT;
    unsigned char *base = block + (above ? MBSR_DATA_ALIGNMENT - above : 0);
    mbsr_batch *b;
    lay_out_batch(model, kernels, n, base, &b, &data, &lane);
    b->block = block;
    int status = begin_batch(model, kernels, n.bodies, lane, b, error);
    if (!status) status = mbsr_data_init(model, data, mbsr_data_size(model), &b->data, error);
    if (status) {
        mbsri_release(&model->allocator, block);
        return status;
    }
    *batch = b;
    return MBSR_OK;
}

static const mbsri_batch_kernels *choose_kernels(void)
{
#if defined(MBSR_WITHOUT_VECTORS)
    return NULL;
#else
#if defined(MBSR_WITH_V4)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("fma"))
        return &mbsri_batch_v4;
#endif
#if defined(MBSR_WITH_V3)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return &mbsri_batch_v3;
#endif
    return &mbsri_batch_base;
#endif
}

int mbsr_batch_create(const mbsr_model *model, mbsr_batch **batch, mbsr_error *error)
{
    return mbsri_batch_make(model, choose_kernels(), batch, error);
}

/* The other shares of a batch, one less than the workers; MBSR_ERR_NO_MEMORY leaves those made to
 * the batch. */
static int add_shares(const mbsr_model *model, const mbsr_parallel *parallel, mbsr_batch *b,
                      mbsr_error *error)
{
    const size_t size = (size_t)parallel->workers * sizeof(mbsr_batch *);
    b->parallel = *parallel;
    b->share = mbsri_allocate(&model->allocator, size);
    if (!b->share) {
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_batch_create_parallel: no memory for %zu bytes", size);
    }
    int status = MBSR_OK;
    b->share[0] = b;
    while (b->shares < parallel->workers && !status) {
        status = mbsr_batch_create(model, b->share + b->shares, error);
        b->shares += !status;
    }
    return status;
}

int mbsr_batch_create_parallel(const mbsr_model *model, const mbsr_parallel *parallel,
                               mbsr_batch **batch, mbsr_error *error)
{
    if (batch) *batch = NULL;
    int status = mbsri_parallel_check(parallel, "mbsr_batch_create_parallel", error);
    if (!status) status = mbsr_batch_create(model, batch, error);
    if (!status && parallel->workers > 1) status = add_shares(model, parallel, *batch, error);
    if (!status) return MBSR_OK;
    if (batch) {
        mbsr_batch_destroy(*batch);
        *batch = NULL;
    }
    return status;
}

void mbsr_batch_destroy(mbsr_batch *batch)
{
    if (!batch) return;
    const mbsr_allocator allocator = batch->allocator;
    for (int k = 1; k < batch->shares; ++k) mbsr_batch_destroy(batch->share[k]);
    mbsri_release(&allocator, batch->share);
    mbsri_release(&allocator, batch->block);
}

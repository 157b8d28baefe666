/* The model of a scene: bodies with their joints, springs, actuators and closures.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Joints of one body move it in turn, each by an axis that the ones before it have moved, with q -
 * ref from where the body is drawn:
 *
 *   T = T_body P_1 R(q_1 - ref_1) P_1^-1 P_2 R(q_2 - ref_2) P_2^-1 ...,   P_k: to the anchor
 *
 * Those with one anchor are one compound joint, in whose coordinates the constant parts R(-ref) are
 * carried behind all axes: R(a, q - ref) = R(a, q) K with K = R(a, -ref), K R(b, x) = R(K b, x) K.
 * Another anchor, a ball, or an axis along which those before it turn or slide already, as drawn,
 * begins a body without mass in between. */
#include "files/build.h"

#include "files/build_parts.h"
#include "files/states.h"
#include "algebra/space3.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_AXES = 6 };

/* ---- bodies and joints ---- */

/* Where the next body hangs, and in which frame. */
typedef struct seat {
    int parent;
    mbsr_frame frame;
} seat;

static mbsr_frame at(const double x[3])
{
    return mbsr_frame_at(x[0], x[1], x[2]);
}

static bool name_body(mbsri_scene *s, mbsr_file *file, const char *name)
{
    mbsri_list *names = &((mbsri_file *)file)->names;
    const char **place = mbsri_list_add(s->arena, names, sizeof *place);
    if (!place) return false;
    *place = name;
    file->body_name = names->items;
    file->bodies = names->count;
    return true;
}

static bool add_scene_body(mbsri_scene *s, mbsr_file *file, const mbsri_scene_body *b,
                           const char *name, const seat *on, mbsr_joint joint, mbsr_inertia inertia,
                           int *id)
{
    mbsr_body_def def = mbsr_default_body_def();
    def.name = name;
    def.parent = on->parent;
    def.joint = joint;
    def.inertia = inertia;
    if (mbsr_model_add_body(file->model, &def, id))
        return mbsri_scene_refused(s, b->element, file->model);
    return name_body(s, file, name);
}

/* A compound joint that grows. */
typedef struct chain {
    mbsr_axis axis[MOST_AXES];
    double armature[MOST_AXES];
    int count;
    int drawn[2];              /* slides, hinges */
    double direction[2][3][3]; /* theirs as drawn */
    bool anchored;
    double anchor[3];
    double shift[3]; /* along slides before the first rotation */
    mbsr_frame K;
} chain;

static void start_chain(chain *c)
{
    *c = (chain){.K = mbsr_frame_identity()};
}

/* Whether a direction lies in the span of some others, up to three. */
static bool depends(int count, const double (*span)[3], const double direction[3])
{
    double own[4][3];
    memcpy(own[count], direction, sizeof *own);
    for (int k = 0; k <= count; ++k) { /* Gram and Schmidt */
        double square = 0.0;
        if (k < count) memcpy(own[k], span[k], sizeof *own);
        for (int l = 0; l < k; ++l) {
            double along = 0.0;
            for (int i = 0; i < 3; ++i) along += own[l][i] * own[k][i];
            for (int i = 0; i < 3; ++i) own[k][i] -= along * own[l][i];
        }
        for (int i = 0; i < 3; ++i) square += own[k][i] * own[k][i];
        if (!(square > 1e-12)) return true;
        for (int i = 0; i < 3; ++i) own[k][i] /= sqrt(square);
    }
    return false;
}

/* False: the joint needs a body of its own. */
static bool grow(chain *c, const mbsri_scene_joint *j)
{
    const bool hinge = j->joint.kind == MBSR_FILE_HINGE;
    const double *x = c->K.x;
    if (c->count == MOST_AXES) return false;
    if (depends(c->drawn[hinge], (const double(*)[3])c->direction[hinge], j->axis)) return false;
    memcpy(c->direction[hinge][c->drawn[hinge]++], j->axis, sizeof j->axis);
    if (hinge && c->anchored && memcmp(c->anchor, j->anchor, sizeof c->anchor) != 0) return false;
    if (hinge && (x[0] != 0.0 || x[1] != 0.0 || x[2] != 0.0)) {
        if (c->anchored) return false;
        memcpy(c->shift, x, sizeof c->shift); /* slides alone so far: before them all the same */
        c->K = mbsr_frame_identity();
    }
    if (hinge && !c->anchored) {
        c->anchored = true;
        memcpy(c->anchor, j->anchor, sizeof c->anchor);
    }
    mbsr_axis *axis = c->axis + c->count;
    const bool screw = hinge && j->pitch != 0.0;
    *axis = (mbsr_axis){.kind = screw   ? MBSR_AXIS_SCREW
                                : hinge ? MBSR_AXIS_ROTATION
                                        : MBSR_AXIS_TRANSLATION,
                        .pitch = j->pitch};
    mbsri_rotate3(c->K.R, j->axis, axis->direction);
    c->armature[c->count++] = j->armature;
    if (j->joint.ref != 0.0) {
        const double back[3] = {-j->joint.ref * j->axis[0], -j->joint.ref * j->axis[1],
                                -j->joint.ref * j->axis[2]};
        const mbsr_frame R = hinge ? mbsr_frame_rotated(NULL, j->axis, -j->joint.ref) : at(back);
        c->K = mbsr_frame_product(&c->K, &R);
    }
    return true;
}

static mbsr_joint chain_joint(const chain *c, const mbsr_frame *frame)
{
    const mbsr_frame anchor = at(c->anchor), shift = at(c->shift);
    mbsr_frame A = mbsr_frame_product(frame, &anchor), B = mbsr_frame_inverse(&c->K);
    A = mbsr_frame_product(&A, &shift);
    B = mbsr_frame_product(&anchor, &B);
    if (c->count == 0) return mbsr_joint_weld(&A, &B);
    if (c->count > 1 || c->axis->kind == MBSR_AXIS_SCREW)
        return mbsr_joint_compound(&A, &B, c->count, c->axis, NULL, NULL);
    return (c->axis->kind == MBSR_AXIS_ROTATION ? mbsr_joint_revolute
                                                : mbsr_joint_prismatic)(&A, &B, c->axis->direction);
}

/* The joints from `first` on that one body can have: how many, and its joint. */
static int take_joints(const mbsri_scene_joint *joints, int count, const mbsr_frame *frame,
                       mbsr_joint *joint, double armature[MOST_AXES])
{
    const mbsri_scene_joint *j = joints;
    if (count > 0 && (j->joint.kind == MBSR_FILE_BALL || j->joint.kind == MBSR_FILE_FREE)) {
        const mbsr_frame B = at(j->anchor), A = mbsr_frame_product(frame, &B);
        *joint = j->joint.kind == MBSR_FILE_BALL
                     ? mbsr_joint_spherical(&A, &B)
                     : mbsr_joint_free(j->relative ? frame : NULL, NULL);
        for (int k = 0; k < MOST_AXES; ++k) armature[k] = j->armature;
        return 1;
    }
    chain c;
    start_chain(&c);
    int taken = 0;
    while (taken < count &&
           (j[taken].joint.kind == MBSR_FILE_HINGE || j[taken].joint.kind == MBSR_FILE_SLIDE)) {
        if (!grow(&c, j + taken)) break;
        ++taken;
    }
    memcpy(armature, c.armature, sizeof c.armature);
    *joint = chain_joint(&c, frame);
    return taken;
}

static bool add_armature(mbsri_scene *s, mbsr_model *model, int id, int n, const double *armature,
                         const mbsri_element *e)
{
    bool some = false;
    for (int k = 0; k < n; ++k) some = some || armature[k] != 0.0;
    return !some || !mbsr_model_armature(model, id, n, armature) ||
           mbsri_scene_refused(s, e, model);
}

static const char *between_name(mbsri_scene *s, const mbsri_scene_body *b, const char *joint)
{
    char text[160];
    const int length = snprintf(text, sizeof text, "%.70s/%.70s", b->name, joint);
    return mbsri_arena_text(s->arena, text, (size_t)length);
}

static bool add_bodies_of(mbsri_scene *s, mbsr_file *file, mbsri_scene_body *b)
{
    seat on = {b->parent < 0 ? MBSR_GROUND : mbsri_scene_bodies(s)[b->parent].id, b->frame};
    mbsri_scene_joint *joints = mbsri_scene_joints(s) + b->first;
    int done = 0;
    do {
        mbsr_joint joint;
        double armature[MOST_AXES];
        const int taken = take_joints(joints + done, b->joints - done, &on.frame, &joint, armature);
        const bool last = done + taken == b->joints;
        const char *name = last ? b->name : between_name(s, b, joints[done].joint.name);
        int id;
        if (!add_scene_body(s, file, b, name, &on, joint, last ? b->inertia : mbsr_inertia_zero(),
                            &id))
            return false;
        if (!add_armature(s, file->model, id, joint.n, armature,
                          taken > 0 ? joints[done].element : b->element))
            return false;
        for (int k = 0; k < taken; ++k) {
            joints[done + k].joint.body = id;
            joints[done + k].joint.coordinate = joints[done + k].joint.position = k;
        }
        done += taken;
        on = (seat){id, mbsr_frame_identity()};
        b->id = id;
    } while (done < b->joints);
    return true;
}

/* ---- closures ---- */

static mbsr_closure_def between_bodies(const mbsri_scene *s, const mbsri_scene_equality *q,
                                       const mbsr_frame *frames)
{
    mbsr_frame relative = q->frame;
    int id[2];
    const mbsr_frame world = mbsr_frame_identity();
    const mbsr_frame *T[2];
    for (int k = 0; k < 2; ++k) {
        id[k] = q->body[k] < 0 ? MBSR_GROUND : mbsri_scene_bodies(s)[q->body[k]].id;
        T[k] = q->body[k] < 0 ? &world : frames + q->body[k];
    }
    if (q->at_sites && q->kind == MBSRI_WELD)
        return mbsr_closure_weld(id[0], q->end, id[1], q->end + 1);
    if (q->at_sites) return mbsr_closure_ball(id[0], q->end[0].x, id[1], q->end[1].x);
    if (!q->placed) {
        const mbsr_frame back = mbsr_frame_inverse(T[0]);
        relative = mbsr_frame_product(&back, T[1]);
    }
    if (q->kind == MBSRI_WELD) return mbsr_closure_weld(id[0], &relative, id[1], NULL);
    const mbsr_frame anchor = at(q->anchor), back = mbsr_frame_inverse(&relative),
                     other = mbsr_frame_product(&back, &anchor);
    return mbsr_closure_ball(id[0], q->anchor, id[1], other.x);
}

static mbsr_closure_def between_joints(const mbsri_scene *s, const mbsri_scene_equality *q)
{
    const mbsr_file_joint *a = &mbsri_scene_joints(s)[q->joint[0]].joint,
                          *b = q->joint[1] < 0 ? NULL : &mbsri_scene_joints(s)[q->joint[1]].joint;
    const int body[2] = {a->body, b ? b->body : MBSR_NONE},
              coordinate[2] = {a->coordinate, b ? b->coordinate : 0};
    const double factor[2] = {1.0, -q->power[1]}, ref[2] = {a->ref, b ? b->ref : 0.0};
    if (!b) return mbsr_closure_coupling(1, body, coordinate, factor, ref[0] + q->power[0]);
    if (q->power[2] == 0.0 && q->power[3] == 0.0 && q->power[4] == 0.0)
        return mbsr_closure_coupling(2, body, coordinate, factor,
                                     ref[0] + q->power[0] - q->power[1] * ref[1]);
    return mbsri_closure_polynomial(body, coordinate, ref, q->power);
}

/* A sum over joints is as drawn, but for an offset. */
static mbsr_closure_def between_sums(const mbsri_scene *s, const mbsri_scene_equality *q)
{
    int body[MBSR_CLOSURE_BODIES], coordinate[MBSR_CLOSURE_BODIES];
    double drawn = q->offset;
    for (int k = 0; k < q->sum.count; ++k) {
        const mbsr_file_joint *j = &mbsri_scene_joints(s)[q->sum.joint[k]].joint;
        body[k] = j->body;
        coordinate[k] = j->coordinate;
        drawn += q->sum.factor[k] * j->ref;
    }
    return mbsr_closure_coupling(q->sum.count, body, coordinate, q->sum.factor, drawn);
}

/* The body with joints that carries this one; -1: the world. */
static int carrier(const mbsri_scene *s, int body)
{
    const mbsri_scene_body *b = mbsri_scene_bodies(s);
    while (body >= 0 && b[body].joints == 0) body = b[body].parent;
    return body;
}

/* Whether nothing can move between both its bodies. */
static bool is_rigid(mbsri_scene *s, const mbsri_scene_equality *q)
{
    const bool rigid = (q->kind == MBSRI_CONNECT || q->kind == MBSRI_WELD) &&
                       carrier(s, q->body[0]) == carrier(s, q->body[1]);
    if (rigid)
        mbsri_file_find(s, q->element, "it is left out: nothing moves between both its bodies");
    return rigid;
}

static bool add_scene_closures(mbsri_scene *s, mbsr_file *file)
{
    const mbsri_scene_equality *q = s->equalities.items;
    if (!s->with_closures || s->equalities.count == 0) return true;
    const mbsr_frame *frames = mbsri_scene_drawn(s);
    if (!frames) return false;
    for (int k = 0; k < s->equalities.count; ++k, ++q) {
        if (is_rigid(s, q)) continue;
        mbsr_closure_def def = q->kind == MBSRI_POLYNOMIAL ? between_joints(s, q)
                               : q->kind == MBSRI_SUM      ? between_sums(s, q)
                                                           : between_bodies(s, q, frames);
        def.name = q->name;
        if (mbsr_model_add_closure(file->model, &def, NULL))
            return mbsri_scene_refused(s, q->element, file->model);
    }
    return true;
}

/* ---- all of it ---- */

bool mbsri_scene_build(mbsri_scene *s, mbsr_file *file, const mbsri_element *root)
{
    mbsri_scene_body *bodies = mbsri_scene_bodies(s);
    mbsr_file_site *sites = s->sites.items;
    mbsr_file_shape *shapes = s->shapes.items;
    for (int k = 0; k < s->bodies.count; ++k) {
        if (!add_bodies_of(s, file, bodies + k)) return false;
    }
    if (!mbsri_scene_settle(s)) return false;
    /* so far by index */
    for (int k = 0; k < s->sites.count; ++k)
        sites[k].body = sites[k].body < 0 ? MBSR_GROUND : bodies[sites[k].body].id;
    mbsr_file_sensor *sensors = s->sensors.items;
    for (int k = 0; k < s->sensors.count; ++k) {
        mbsr_file_sensor *of = sensors + k;
        of->body = of->body < 0 ? MBSR_GROUND : bodies[of->body].id;
        of->from_body = of->from_body < 0 ? MBSR_GROUND : bodies[of->from_body].id;
    }
    for (int k = 0; k < s->shapes.count; ++k)
        shapes[k].body = shapes[k].body < 0 ? MBSR_GROUND : bodies[shapes[k].body].id;
    int *exclude = s->excludes.items;
    for (int k = 0; k < 2 * s->excludes.count; ++k)
        exclude[k] = exclude[k] < 0 ? MBSR_GROUND : bodies[exclude[k]].id;
    return mbsri_scene_forces(s, file, root) && mbsri_scene_actuators(s, file) &&
           add_scene_closures(s, file) && mbsri_scene_states(s, file);
}

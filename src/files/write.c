/* A model as MJCF: see files.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The body of a joint with frames A and B and the axes R_k stands, as drawn at q = ref, at
 *
 *   T = A R_1(ref_1) R_2(ref_2) ... B^-1,
 *
 * and axis k moves it about B (R_k+1(ref_k+1) ...)^-1, seen in the body, by q_k - ref_k. */
#include "files/solids.h"
#include "files/writer.h"
#include "files/xml.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { COOKIE = 0x6d627377, DEEPEST = MBSRI_XML_DEPTH - 10 };

mbsr_write_opt mbsr_default_write_opt(void)
{
    return (mbsr_write_opt){.cookie = COOKIE};
}

static int refuse_writing(mbsr_error *error, int status, const char *text)
{
    if (!error) return status;
    *error = (mbsr_error){.status = status, .body = MBSR_NONE, .force = MBSR_NONE};
    snprintf(error->text, sizeof error->text, "mbsr_file_write_mjcf: %.220s", text);
    return status;
}

/* ---- what is to be written ---- */

static bool take_tables(mbsri_file_writer *w)
{
    const size_t bodies = (size_t)w->bodies + 1, rates = (size_t)w->nu + 1;
    w->body = mbsri_arena_take(w->arena, bodies * sizeof *w->body);
    w->def = mbsri_arena_take(w->arena, bodies * sizeof *w->def);
    w->chain = mbsri_arena_take(w->arena, bodies * sizeof *w->chain);
    w->frame = mbsri_arena_take(w->arena, bodies * sizeof *w->frame);
    w->world = mbsri_arena_take(w->arena, bodies * sizeof *w->world);
    w->joint_at = mbsri_arena_take(w->arena, bodies * sizeof *w->joint_at);
    w->lift = mbsri_arena_take(w->arena, 3 * bodies * sizeof *w->lift);
    w->before = mbsri_arena_take(w->arena, bodies * sizeof *w->before);
    w->joined = mbsri_arena_take(w->arena, bodies * sizeof *w->joined);
    w->joint = mbsri_arena_take(w->arena, rates * sizeof *w->joint);
    return !w->arena->failed;
}

/* Why a body cannot be written; NULL: it can. */
static const char *obstacle(const mbsri_file_writer *w, int k)
{
    const mbsr_joint_chain *c = w->chain + k;
    if (mbsr_joint_chain_of(&w->def[k].joint, w->chain + k))
        return "its joint is none that MJCF has";
    if (mbsr_body_locks(w->model, k) > 0) return "coordinates of its joint are locked";
    for (int l = 0; l < c->axes; ++l) {
        if (c->axis[l].kind == MBSR_AXIS_SCREW) return "MJCF has no screws";
        if (c->axis[l].driven) return "MJCF has no driven axes";
    }
    return NULL;
}

/* Free joints of MJCF begin at the world: those on bodies that do not move are moved there. */
static bool lift_free(mbsri_file_writer *w, int k)
{
    mbsr_joint_chain *c = w->chain + k;
    if (!c->quaternion || c->axes == 0) return true;
    for (int p = w->def[k].parent; p != MBSR_GROUND; p = w->def[p].parent) {
        const mbsr_joint_chain *weld = w->chain + p;
        if (weld->quaternion || weld->axes > 0) return false;
        const mbsr_frame back = mbsr_frame_inverse(&weld->B),
                         drawn = mbsr_frame_product(&weld->A, &back);
        c->A = mbsr_frame_product(&drawn, &c->A);
    }
    w->def[k].parent = MBSR_GROUND;
    return true;
}

static bool cannot(mbsri_file_writer *w, int k, const char *why)
{
    snprintf(w->message, sizeof w->message, "body %d '%.80s': %s", k, mbsr_body_name(w->model, k),
             why);
    return false;
}

static bool read_bodies(mbsri_file_writer *w)
{
    for (int k = 0; k < w->bodies; ++k) {
        mbsr_body_definition(w->model, k, w->def + k);
        const char *why = obstacle(w, k);
        if (why) return cannot(w, k, why);
    }
    for (int k = 0; k < w->bodies; ++k)
        if (!lift_free(w, k)) return cannot(w, k, "free joints of MJCF begin at the world");
    return true;
}

/* A name that no other one has: as given, else what stands for it. */
static const char *own_name(mbsri_file_writer *w, mbsri_names *names, const char *given,
                            const char *instead, int number)
{
    const char *name = given;
    for (int k = 0; !name || !*name || mbsri_names_find(names, name) >= 0; ++k) {
        name = mbsri_write_print(w, k > 0 ? "%s_%d_%d" : "%s_%d", instead, number, k);
        if (w->arena->failed) return "";
    }
    mbsri_names_add(w->arena, names, name, number);
    return name;
}

/* What was read of each joint, by its first rate. */
static const mbsr_file_joint **joints_read(const mbsri_file_writer *w)
{
    const mbsr_file_joint **read = mbsri_arena_take(w->arena, ((size_t)w->nu + 1) * sizeof *read);
    for (int k = 0; read && w->file && k < w->file->joints; ++k) {
        const mbsr_file_joint *j = w->file->joint + k;
        int first;
        if (j->kind == MBSR_FILE_FIXED) continue;
        mbsr_body_coordinates(w->model, j->body, NULL, NULL, &first, NULL);
        read[first + j->coordinate] = j;
    }
    return read;
}

static void name_joints(mbsri_file_writer *w, mbsri_names *names, const mbsr_file_joint **read,
                        int k)
{
    const mbsr_joint_chain *c = w->chain + k;
    const int count = c->quaternion ? 1 : c->axes;
    int first;
    mbsr_body_coordinates(w->model, k, NULL, NULL, &first, NULL);
    w->joint_at[k] = first;
    for (int l = 0; l < count; ++l) {
        mbsri_written_joint *j = w->joint + first + l;
        j->of = read[first + l];
        j->body = k, j->coordinate = l;
        j->kind = c->quaternion ? (c->axes > 0 ? MBSR_FILE_FREE : MBSR_FILE_BALL)
                  : c->axis[l].kind == MBSR_AXIS_ROTATION ? MBSR_FILE_HINGE
                                                          : MBSR_FILE_SLIDE;
        j->name = own_name(w, names, j->of ? j->of->name : NULL, "joint", first + l);
    }
}

static mbsr_frame turned_by(const mbsr_axis *axis, double q)
{
    const double *a = axis->direction;
    if (axis->kind == MBSR_AXIS_ROTATION) return mbsr_frame_rotated(NULL, a, q);
    return mbsr_frame_at(q * a[0], q * a[1], q * a[2]);
}

/* Its axes and where it is drawn; a free joint where q0 has it. */
static void draw_body(mbsri_file_writer *w, int k)
{
    const mbsr_joint_chain *c = w->chain + k;
    mbsri_written_joint *joints = w->joint + w->joint_at[k];
    mbsr_frame T = c->A, behind = c->B;
    const bool is_free = c->quaternion && c->axes > 0;
    if (is_free && w->file) {
        int q;
        mbsr_body_coordinates(w->model, k, &q, NULL, NULL, NULL);
        const mbsr_frame drawn = mbsr_frame_quaternion(w->file->q0 + q + 4, w->file->q0 + q);
        T = mbsr_frame_product(&T, &drawn);
    }
    if (c->quaternion) memcpy(joints->anchor, c->B.x, sizeof joints->anchor);
    for (int l = c->quaternion ? -1 : c->axes - 1; l >= 0; --l) {
        mbsri_written_joint *j = joints + l;
        const double ref = j->of ? j->of->ref : 0.0, *a = c->axis[l].direction;
        for (int i = 0; i < 9; ++i) j->axis[i % 3] += behind.R[i] * a[i / 3];
        memcpy(j->anchor, behind.x, sizeof j->anchor);
        if (!(ref < 0.0 || ref > 0.0)) continue;
        const mbsr_frame back = turned_by(c->axis + l, -ref);
        behind = mbsr_frame_product(&behind, &back);
    }
    const mbsr_frame end = mbsr_frame_inverse(&behind);
    w->frame[k] = mbsr_frame_product(&T, &end);
}

/* ---- joints with several anchors in one body ---- */

/* Whether the reader made this body to carry a joint of another one, whose only predecessor it is.
 */
static bool is_between(const mbsri_file_writer *w, int k, int child)
{
    const char *name = mbsr_body_name(w->model, k), *of = mbsr_body_name(w->model, child);
    const size_t length = strlen(of);
    double mass, centre[3], tensor[6], size = 0.0;
    if (!w->file || strncmp(name, of, length) != 0 || name[length] != '/') return false;
    if (w->chain[k].axes == 0 && !w->chain[k].quaternion) return false;
    if (!mbsri_solid_of(&w->def[k].inertia, &mass, centre, tensor)) return false;
    for (int l = 0; l < 6; ++l) size += fabs(tensor[l]);
    return !(mass > 0.0) && !(size > 0.0);
}

static void count_children(const mbsri_file_writer *w, int *children)
{
    for (int k = 0; k < w->bodies; ++k) children[k] = 0;
    for (int k = 0; k < w->bodies; ++k)
        if (w->def[k].parent != MBSR_GROUND) ++children[w->def[k].parent];
}

/* Axes and anchors of body k and of those whose joints stand before its own, seen from its one
 * successor. */
static void carry_joints(mbsri_file_writer *w, int k, const mbsr_frame *child)
{
    const mbsr_frame back = mbsr_frame_inverse(child);
    for (int at = k; at != MBSR_NONE; at = w->before[at]) {
        mbsri_written_joint *j = w->joint + w->joint_at[at];
        const int count = w->chain[at].quaternion ? 1 : w->chain[at].axes;
        for (int l = 0; l < count; ++l, ++j) {
            double axis[3], anchor[3];
            for (int i = 0; i < 3; ++i) {
                axis[i] = anchor[i] = 0.0;
                for (int m = 0; m < 3; ++m) {
                    axis[i] += back.R[3 * m + i] * j->axis[m];
                    anchor[i] += back.R[3 * m + i] * j->anchor[m];
                }
                anchor[i] += back.x[i];
            }
            memcpy(j->axis, axis, sizeof axis);
            memcpy(j->anchor, anchor, sizeof anchor);
        }
    }
}

/* Bodies in between give their joints to the body that they carry. */
static void join_bodies(mbsri_file_writer *w)
{
    int *children = mbsri_arena_take(w->arena, ((size_t)w->bodies + 1) * sizeof *children);
    if (!children) return;
    count_children(w, children);
    for (int k = 0; k < w->bodies; ++k) w->before[k] = MBSR_NONE;
    for (int k = 0; k < w->bodies; ++k) {
        const int p = w->def[k].parent;
        if (p == MBSR_GROUND || children[p] != 1 || !is_between(w, p, k)) continue;
        carry_joints(w, p, w->frame + k);
        w->before[k] = p;
        w->joined[p] = true;
        w->frame[k] = mbsr_frame_product(w->frame + p, w->frame + k);
        w->def[k].parent = w->def[p].parent;
    }
}

/* ---- frames in the world ---- */

/* Predecessors may have larger ids: those of a body are drawn first. */
static void place_in_world(mbsri_file_writer *w, int k)
{
    mbsr_frame T = w->frame[k];
    for (int p = w->def[k].parent; p != MBSR_GROUND; p = w->def[p].parent)
        T = mbsr_frame_product(w->frame + p, &T);
    w->world[k] = T;
}

static bool too_deep(mbsri_file_writer *w, int k)
{
    int depth = 0;
    for (int p = k; p != MBSR_GROUND; p = w->def[p].parent) ++depth;
    if (depth <= DEEPEST) return false;
    snprintf(w->message, sizeof w->message, "body %d '%.80s' has more than %d predecessors", k,
             mbsr_body_name(w->model, k), DEEPEST);
    return true;
}

static bool prepare_writing(mbsri_file_writer *w)
{
    mbsri_names bodies = {.count = 0}, joints = {.count = 0};
    if (!take_tables(w) || !read_bodies(w)) return false;
    const mbsr_file_joint **read = joints_read(w);
    if (!read) return false;
    mbsri_names_add(w->arena, &bodies, "world", 0);
    for (int k = 0; k < w->bodies; ++k) {
        if (too_deep(w, k)) return false;
        w->body[k] = own_name(w, &bodies, mbsr_body_name(w->model, k), "body", k);
        name_joints(w, &joints, read, k);
        draw_body(w, k);
    }
    join_bodies(w);
    for (int k = 0; k < w->bodies; ++k) place_in_world(w, k);
    mbsri_write_collect(w);
    return !w->arena->failed;
}

/* ---- all of it ---- */

static void write_all(mbsri_file_writer *w)
{
    mbsri_text *t = &w->text;
    mbsri_begin(t, "mujoco");
    mbsri_set_text(t, "model", w->file ? w->file->name : NULL);
    mbsri_into(t);
    mbsri_begin(t, "compiler");
    mbsri_set_text(t, "angle", "radian");
    mbsri_set_text(t, "inertiafromgeom", "false");
    mbsri_set_text(t, "meshdir", w->opt->mesh_folder);
    mbsri_end(t);
    mbsri_begin(t, "option");
    mbsri_set_numbers(t, "gravity", 3, w->gravity);
    mbsri_into(t);
    mbsri_begin(t, "flag");
    mbsri_set_text(t, "refsafe", "disable"); /* time constants are as they stand */
    mbsri_end(t);
    mbsri_out(t, "option");
    mbsri_write_bodies(w);
    mbsri_write_rest(w);
    mbsri_out(t, "mujoco");
}

static int write_model(mbsri_file_written *to, const mbsr_model *model, const mbsr_file *file,
                       const mbsr_write_opt *opt, mbsr_error *error)
{
    mbsri_file_writer writer = {.arena = &to->arena,
                                .model = model,
                                .file = file,
                                .opt = opt,
                                .text = {.arena = &to->arena},
                                .bodies = mbsr_model_bodies(model),
                                .nu = mbsr_model_nu(model)};
    mbsri_file_writer *w = &writer;
    const bool good = prepare_writing(w);
    if (good) write_all(w);
    if (w->arena->failed) return refuse_writing(error, MBSR_ERR_NO_MEMORY, "no memory");
    if (!good) return refuse_writing(error, MBSR_ERR_SPACE, w->message);
    const mbsr_finding *f = w->findings.items;
    if (opt->strict && w->findings.count > 0) {
        char reason[MBSR_TEXT_SIZE];
        snprintf(reason, sizeof reason, "%.70s: %.100s (%d such findings, strict mode)", f->element,
                 f->text, w->findings.count);
        return refuse_writing(error, MBSR_ERR_FILE, reason);
    }
    to->written = (mbsr_written){
        .text = w->text.data, .size = w->text.size, .findings = w->findings.count, .finding = f};
    return MBSR_OK;
}

int mbsr_file_write_mjcf(const mbsr_model *model, const mbsr_file *file, const mbsr_write_opt *opt,
                         mbsr_written **written, mbsr_error *error)
{
    const mbsr_write_opt standard = mbsr_default_write_opt();
    if (written) *written = NULL;
    if (!model || !written)
        return refuse_writing(error, MBSR_ERR_NULL, model ? "written is NULL" : "model is NULL");
    if (!opt) opt = &standard;
    if (opt->cookie != COOKIE)
        return refuse_writing(error, MBSR_ERR_NO_DEFAULT,
                              "the options were not made by mbsr_default_write_opt");
    if ((opt->allocator.allocate == NULL) != (opt->allocator.release == NULL))
        return refuse_writing(error, MBSR_ERR_VALUE, "opt.allocator has one of its two functions");
    if (mbsr_model_bodies(model) < 0)
        return refuse_writing(error, MBSR_ERR_UNFINISHED, "the model is not finished");
    if (file && (file->bodies != mbsr_model_bodies(model) || file->nq != mbsr_model_nq(model)))
        return refuse_writing(error, MBSR_ERR_MISMATCH,
                              "the model is not that of the file as read");
    mbsri_arena arena;
    mbsri_arena_open(&arena, &opt->allocator);
    mbsri_file_written *to = mbsri_arena_take(&arena, sizeof *to);
    if (!to) {
        mbsri_arena_close(&arena);
        return refuse_writing(error, MBSR_ERR_NO_MEMORY, "no memory");
    }
    to->arena = arena;
    const int status = write_model(to, model, file, opt, error);
    if (status)
        mbsr_written_destroy(&to->written);
    else
        *written = &to->written;
    return status;
}

void mbsr_written_destroy(mbsr_written *written)
{
    if (!written) return;
    mbsri_arena arena = ((mbsri_file_written *)(void *)written)->arena;
    mbsri_arena_close(&arena);
}

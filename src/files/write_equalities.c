/* Equalities and keys of MJCF.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/elements.h"
#include "files/writer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static mbsr_frame frame_at(const double param[12])
{
    mbsr_frame frame;
    memcpy(frame.x, param, sizeof frame.x);
    memcpy(frame.R, param + 3, sizeof frame.R);
    return frame;
}

/* The bodies, the first of which is none of the ground; which one that is. */
static int set_bodies(mbsri_file_writer *w, const mbsr_closure_def *def)
{
    const int first = def->body[0] == MBSR_GROUND, other = def->body[!first];
    mbsri_set_text(&w->text, "body1", w->body[def->body[first]]);
    if (other != MBSR_GROUND) mbsri_set_text(&w->text, "body2", w->body[other]);
    return first;
}

static void write_weld(mbsri_file_writer *w, const mbsr_closure_def *def)
{
    mbsr_frame end[2] = {frame_at(def->param), frame_at(def->param + 12)};
    double pose[7];
    mbsri_begin(&w->text, "weld");
    mbsri_set_text(&w->text, "name", def->name);
    const int first = set_bodies(w, def);
    const mbsr_frame back = mbsr_frame_inverse(end + !first),
                     relative = mbsr_frame_product(end + first, &back);
    memcpy(pose, relative.x, sizeof relative.x);
    mbsr_rotation_quaternion(relative.R, pose + 3);
    mbsri_set_numbers(&w->text, "relpose", 7, pose);
    mbsri_end(&w->text);
}

bool mbsri_written_is_open(const mbsri_file_writer *w, const mbsr_closure_def *def)
{
    const mbsr_frame unit = mbsr_frame_identity();
    double x[2][3], gap = 0.0, size = 1e-9;
    if (def->table != mbsr_closure_ball(0, NULL, 1, NULL).table) return false;
    for (int k = 0; k < 2; ++k) {
        const double *p = def->param + 12 * k;
        const mbsr_frame *T = def->body[k] == MBSR_GROUND ? &unit : w->world + def->body[k];
        for (int l = 0; l < 3; ++l) {
            x[k][l] = T->x[l] + T->R[l] * p[0] + T->R[3 + l] * p[1] + T->R[6 + l] * p[2];
            size = fmax(size, fabs(x[k][l]));
        }
    }
    for (int l = 0; l < 3; ++l) gap = fmax(gap, fabs(x[0][l] - x[1][l]));
    return gap > 1e-9 * size;
}

/* MJCF tells the point on the first body; that on the other is where it is as drawn, else both are
 * sites. */
static void write_connect(mbsri_file_writer *w, const mbsr_closure_def *def, int id)
{
    mbsri_begin(&w->text, "connect");
    mbsri_set_text(&w->text, "name", def->name);
    if (mbsri_written_is_open(w, def)) {
        bool there;
        mbsri_set_text(&w->text, "site1", mbsri_write_end_name(w, def, id, 0, &there));
        mbsri_set_text(&w->text, "site2", mbsri_write_end_name(w, def, id, 1, &there));
    } else {
        const int first = set_bodies(w, def);
        mbsri_set_numbers(&w->text, "anchor", 3, def->param + 12 * first);
    }
    mbsri_end(&w->text);
}

/* q0 - ref0 = polynomial of (q1 - ref1). */
static void write_relation(mbsri_file_writer *w, const char *name, const mbsri_written_joint *a,
                           const mbsri_written_joint *b, const double power[5])
{
    mbsri_begin(&w->text, "joint");
    mbsri_set_text(&w->text, "name", name);
    mbsri_set_text(&w->text, "joint1", a->name);
    if (b) mbsri_set_text(&w->text, "joint2", b->name);
    mbsri_set_numbers(&w->text, "polycoef", 5, power);
    mbsri_end(&w->text);
}

static double ref_of(const mbsri_written_joint *j)
{
    return j && j->of ? j->of->ref : 0.0;
}

/* A relation of more than two coordinates: of a fixed tendon, which write_tendons has. */
static bool write_sum_equality(mbsri_file_writer *w, const mbsr_closure_def *def, int id)
{
    double power[5] = {def->param[MBSR_CLOSURE_BODIES]};
    if (!mbsri_written_has_axes(w, def)) return false;
    for (int k = 0; k < def->bodies; ++k)
        power[0] -= def->param[k] * ref_of(mbsri_written_joint_of(w, def->body[k], def->option[k]));
    mbsri_begin(&w->text, "tendon");
    mbsri_set_text(&w->text, "name", def->name);
    mbsri_set_text(&w->text, "tendon1", mbsri_write_print(w, "closure_%d", id));
    mbsri_set_numbers(&w->text, "polycoef", 5, power);
    mbsri_end(&w->text);
    return true;
}

static bool write_coupling(mbsri_file_writer *w, const mbsr_closure_def *def, int id)
{
    const double *f = def->param, offset = def->param[MBSR_CLOSURE_BODIES];
    const mbsri_written_joint *j[2] = {NULL, NULL};
    double power[5] = {0.0};
    if (def->bodies > 2) return write_sum_equality(w, def, id);
    if (!(fabs(f[0]) > 0.0)) return false;
    for (int k = 0; k < def->bodies; ++k) {
        j[k] = mbsri_written_joint_of(w, def->body[k], def->option[k]);
        if (!mbsri_written_has_axis(j[k])) return false;
    }
    if (def->bodies > 1) power[1] = -f[1] / f[0];
    power[0] = offset / f[0] - ref_of(j[0]) + power[1] * ref_of(j[1]);
    write_relation(w, def->name, j[0], j[1], power);
    return true;
}

static bool write_polynomial(mbsri_file_writer *w, const mbsr_closure_def *def)
{
    int coordinate[2];
    double ref[2], power[5];
    if (!mbsri_polynomial_of(def, coordinate, ref, power)) return false;
    const mbsri_written_joint *a = mbsri_written_joint_of(w, def->body[0], coordinate[0]),
                              *b = mbsri_written_joint_of(w, def->body[def->bodies > 1],
                                                          coordinate[1]);
    if (!mbsri_written_has_axis(a) || !mbsri_written_has_axis(b)) return false;
    if (fabs(ref_of(a) - ref[0]) + fabs(ref_of(b) - ref[1]) > 0.0) return false;
    write_relation(w, def->name, a, b, power);
    return true;
}

static bool write_equality(mbsri_file_writer *w, const mbsr_closure_def *def, int id)
{
    const mbsr_closure_table *weld = mbsr_closure_weld(0, NULL, 1, NULL).table,
                             *ball = mbsr_closure_ball(0, NULL, 1, NULL).table,
                             *coupling = mbsr_closure_coupling(0, NULL, NULL, NULL, 0.0).table;
    for (int k = 0; k < MBSR_CLOSURE_ROWS; ++k)
        if (def->stiffness[k] > 0.0) return false;
    if (def->motion || def->compliant > 0) return false;
    if (def->table == ball) {
        write_connect(w, def, id);
        return true;
    }
    if (def->table == coupling) return write_coupling(w, def, id);
    if (def->table != weld) return write_polynomial(w, def);
    write_weld(w, def);
    return true;
}

/* A force element that is a closure has been told among the forces. */
static bool is_spring(const mbsri_file_writer *w, int closure)
{
    for (int k = 0; k < mbsr_model_forces(w->model); ++k)
        if (mbsr_force_closure(w->model, k) == closure) return true;
    return false;
}

void mbsri_write_equalities(mbsri_file_writer *w)
{
    bool open = false;
    for (int k = 0; k < mbsr_model_closures(w->model); ++k) {
        mbsr_closure_def def;
        char element[120];
        if (mbsr_closure_definition(w->model, k, &def)) continue;
        mbsri_write_section(w, &open, "equality");
        if (write_equality(w, &def, k) || is_spring(w, k)) continue;
        snprintf(element, sizeof element, "closure %d '%.80s'", k, def.name ? def.name : "");
        mbsri_write_find(w, element, "MJCF cannot say this '%.60s': it is left out",
                         def.table->name);
    }
    if (open) mbsri_out(&w->text, "equality");
}

/* ---- keys ---- */

/* Of the actuators that are written. */
static void write_controls(mbsri_file_writer *w, const double *control)
{
    const mbsr_file *f = w->file;
    double *written = mbsri_arena_take(w->arena, ((size_t)f->actuators + 1) * sizeof *written);
    int count = 0;
    for (int k = 0; written && k < f->actuators; ++k)
        if (f->actuator[k].force != MBSR_NONE) written[count++] = control[k];
    if (count > 0) mbsri_set_numbers(&w->text, "ctrl", count, written);
}

void mbsri_write_keys(mbsri_file_writer *w)
{
    const mbsr_file *f = w->file;
    bool open = false;
    for (int k = 0; f && k < f->keys; ++k) {
        const size_t numbers = (size_t)(f->nq + f->nu) + 1;
        double *qpos = mbsri_arena_take(w->arena, numbers * sizeof *qpos);
        if (!qpos || mbsr_file_mujoco_state(f, 1, f->key[k].q, f->key[k].u, qpos, qpos + f->nq))
            continue;
        mbsri_write_section(w, &open, "keyframe");
        mbsri_begin(&w->text, "key");
        mbsri_set_text(&w->text, "name", f->key[k].name);
        mbsri_set_number(&w->text, "time", f->key[k].time);
        if (f->nq > 0) mbsri_set_numbers(&w->text, "qpos", f->nq, qpos);
        if (f->nu > 0) mbsri_set_numbers(&w->text, "qvel", f->nu, qpos + f->nq);
        write_controls(w, f->key[k].control);
        mbsri_end(&w->text);
    }
    if (open) mbsri_out(&w->text, "keyframe");
}

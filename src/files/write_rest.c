/* What stands beside the bodies in MJCF: springs, tendons, actuators.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/thrust.h"
#include "files/writer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The parameter of that name of a stock element. */
static double parameter(const mbsr_force_def *def, const char *name)
{
    for (int k = 0; def->table->parameter && k < MBSR_FORCE_PARAMS; ++k) {
        const char *own = def->table->parameter(k);
        if (!own || !*own) break;
        if (strcmp(own, name) == 0) return def->param[k];
    }
    return 0.0;
}

/* ---- force elements: into joints and gravity, or lists ---- */

static bool add_joint_spring(mbsri_file_writer *w, const mbsr_force_def *def)
{
    mbsri_written_joint *j = w->joint + w->joint_at[def->body[0]] + def->option[0];
    const double stiffness = parameter(def, " (stiffness)");
    if (!mbsri_written_has_axis(j) || parameter(def, " (cubic)") > 0.0) return false;
    j->stiffness += stiffness;
    j->moment += stiffness * parameter(def, " (rest)");
    j->damping += parameter(def, " (damping)");
    return true;
}

/* The same about all axes, at rest where the joint is drawn. */
static bool add_rotation_spring(mbsri_file_writer *w, const mbsr_force_def *def)
{
    mbsri_written_joint *j = w->joint + w->joint_at[def->body[0]];
    const double k = parameter(def, " (stiffness[0])"), d = parameter(def, " (damping[0])");
    const double same =
        fabs(k - parameter(def, " (stiffness[1])")) + fabs(k - parameter(def, " (stiffness[2])")) +
        fabs(d - parameter(def, " (damping[1])")) + fabs(d - parameter(def, " (damping[2])"));
    if (!j->name || j->kind != MBSR_FILE_BALL || same > 0.0) return false;
    if (fabs(parameter(def, " (rest[0])") - 1.0) > 1e-15 && k > 0.0) return false;
    j->stiffness += k;
    j->damping += d;
    return true;
}

/* The same along all coordinates of a free joint, at rest where its body is drawn. */
static bool add_free_spring(mbsri_file_writer *w, const mbsr_force_def *def)
{
    const int body = def->body[1];
    double k[6], d[6], off = 0.0;
    if (def->body[0] != MBSR_GROUND || body == MBSR_GROUND) return false;
    mbsri_written_joint *j = w->joint + w->joint_at[body];
    if (!j->name || j->kind != MBSR_FILE_FREE) return false;
    for (int l = 0; l < 6; ++l) {
        k[l] = parameter(def, " (stiffness[0])");
        d[l] = parameter(def, " (damping[0])");
    }
    const mbsr_force_def same = mbsr_force_bushing(MBSR_GROUND, w->frame + body, body, NULL, k, d);
    for (int l = 0; l < MBSR_FORCE_PARAMS; ++l)
        off = fmax(off, fabs(same.param[l] - def->param[l]));
    if (off > 1e-12) return false;
    j->stiffness += k[0];
    j->damping += d[0];
    return true;
}

static mbsri_written_spring *new_spring(mbsri_file_writer *w, const mbsr_force_def *def, int id)
{
    mbsri_written_spring *s = mbsri_list_add(w->arena, &w->springs, sizeof *s);
    const int *body = def->body_list ? def->body_list : def->body;
    if (!s) return NULL;
    s->name = mbsri_write_print(w, "spring_%d", id);
    s->count = def->bodies;
    for (int k = 0; k < s->count; ++k) s->body[k] = body[k];
    return s;
}

/* Once it has its points. */
static void name_sites(mbsri_file_writer *w, mbsri_written_spring *s, int id)
{
    for (int k = 0; k < s->count; ++k) {
        const double *x = s->point[k];
        const mbsr_frame frame = mbsr_frame_at(x[0], x[1], x[2]);
        s->site[k] = mbsri_write_site_name(
            w, s->body[k], &frame, mbsri_write_print(w, "spring_%d_%c", id, 'a' + k), s->there + k);
    }
}

static bool add_point_spring(mbsri_file_writer *w, const mbsr_force_def *def, int id)
{
    if (def->option[0] != 0 || parameter(def, " (cubic)") > 0.0) return false;
    mbsri_written_spring *s = new_spring(w, def, id);
    if (!s) return true;
    s->stiffness = parameter(def, " (stiffness)");
    s->damping = parameter(def, " (damping)");
    s->rest[0] = s->rest[1] = parameter(def, " (free_length)");
    for (int k = 0; k < 2; ++k) {
        for (int l = 0; l < 3; ++l) {
            char name[24];
            snprintf(name, sizeof name, " (point_%c[%d])", "ab"[k], l);
            s->point[k][l] = parameter(def, name);
        }
    }
    name_sites(w, s, id);
    return true;
}

static bool add_path(mbsri_file_writer *w, const mbsr_force_def *def, int id)
{
    mbsri_written_spring *s = new_spring(w, def, id);
    if (!s) return true;
    const bool path = mbsri_path_of(def, s->point, &s->stiffness, &s->damping, s->rest);
    name_sites(w, s, id);
    return path;
}

/* Those between joint coordinates become tendons and actuators, which are written later. */
static bool is_transmission(const mbsri_file_writer *w, const mbsr_force_def *def, int id)
{
    int coordinate[MBSRI_TRANSMISSION_MOST];
    double factor[MBSRI_TRANSMISSION_MOST];
    mbsri_transmission t;
    if (!mbsri_transmission_of(def, &t, coordinate, factor)) return false;
    for (int k = 0; k < t.count; ++k)
        if (!mbsri_written_has_axis(mbsri_written_joint_of(w, t.body[k], coordinate[k])))
            return false;
    if (!t.law.control) return true;
    for (int k = 0; w->file && k < w->file->actuators; ++k)
        if (w->file->actuator[k].force == id) return true;
    return false;
}

/* What carries a part of the weight of a body: all gravity is known behind the last element. */
static bool add_lift(mbsri_file_writer *w, const mbsr_force_def *def)
{
    double F[3];
    if (!mbsri_lift_of(def, F)) return false;
    for (int k = 0; k < 3; ++k) w->lift[3 * def->body[0] + k] += F[k];
    return true;
}

/* The thrust of an actuator, which is written later. */
static bool is_thrust(const mbsri_file_writer *w, const mbsr_force_def *def, int id)
{
    mbsri_thrust t;
    bool known = false;
    for (int k = 0; w->file && k < w->file->actuators; ++k)
        known = known || w->file->actuator[k].force == id;
    return known && mbsri_thrust_of(def, &t);
}

static bool add_force(mbsri_file_writer *w, const mbsr_force_def *def, int id)
{
    const mbsr_force_table *joint = mbsr_force_joint_spring(0, 0, 1.0, 0.0, 0.0).table,
                           *rotation = mbsr_force_joint_rotation_spring(0, NULL, NULL, NULL).table,
                           *point = mbsr_force_point_spring(0, NULL, 1, NULL, 1.0, 0.0, 0.0).table;
    const mbsr_force_table *bushing = mbsr_force_bushing(0, NULL, 1, NULL, NULL, NULL).table;
    if (def->function || def->spring || def->as_closure != 0) return false;
    if (def->table == joint) return add_joint_spring(w, def);
    if (def->table == rotation) return add_rotation_spring(w, def);
    if (def->table == point) return add_point_spring(w, def, id);
    if (def->table == mbsri_path_table()) return add_path(w, def, id);
    if (def->table == bushing) return add_free_spring(w, def);
    if (def->table != mbsr_force_gravity(0.0, 0.0, 1.0).table)
        return add_lift(w, def) || is_thrust(w, def, id) || is_transmission(w, def, id);
    for (int k = 0; k < 3; ++k) w->gravity[k] += def->param[k];
    return true;
}

void mbsri_write_collect(mbsri_file_writer *w)
{
    for (int id = 0; id < mbsr_model_forces(w->model); ++id) {
        mbsr_force_def def;
        char element[120];
        if (mbsr_force_definition(w->model, id, &def) || add_force(w, &def, id)) continue;
        snprintf(element, sizeof element, "force %d '%.80s'", id, def.name ? def.name : "");
        mbsri_write_find(w, element, "a force of the kind '%.60s' is left out", def.table->name);
    }
}

/* ---- tendons and actuators ---- */

static void write_sum(mbsri_file_writer *w, const char *name, const mbsri_transmission *t,
                      double scale, bool spring)
{
    mbsri_text *x = &w->text;
    mbsri_begin(x, "fixed");
    mbsri_set_text(x, "name", name);
    if (spring) {
        if (fabs(t->law.bias[1]) > 0.0) mbsri_set_number(x, "stiffness", -t->law.bias[1]);
        if (fabs(t->law.bias[2]) > 0.0) mbsri_set_number(x, "damping", -t->law.bias[2]);
        mbsri_set_numbers(x, "springlength", t->law.rest[0] < t->law.rest[1] ? 2 : 1, t->law.rest);
    }
    mbsri_into(x);
    for (int k = 0; k < t->count; ++k) {
        mbsri_begin(x, "joint");
        mbsri_set_text(x, "joint", mbsri_written_joint_of(w, t->body[k], t->coordinate[k])->name);
        mbsri_set_number(x, "coef", t->factor[k] / scale);
        mbsri_end(x);
    }
    mbsri_out(x, "fixed");
}

/* Sums of coordinates that closures relate. */
static void write_closure_sums(mbsri_file_writer *w, bool *open)
{
    const mbsr_closure_table *coupling = mbsr_closure_coupling(0, NULL, NULL, NULL, 0.0).table;
    for (int id = 0; id < mbsr_model_closures(w->model); ++id) {
        mbsr_closure_def def;
        if (mbsr_closure_definition(w->model, id, &def) || def.table != coupling ||
            def.bodies < 3 || !mbsri_written_has_axes(w, &def))
            continue;
        const mbsri_transmission t = {
            .count = def.bodies, .body = def.body, .coordinate = def.option, .factor = def.param};
        mbsri_write_section(w, open, "tendon");
        write_sum(w, mbsri_write_print(w, "closure_%d", id), &t, 1.0, false);
    }
}

static double gear_of(const mbsr_file_actuator *a)
{
    return fabs(a->gear) > 0.0 ? a->gear : 1.0;
}

/* Of a tendon there is a name by the element; springlength -1 is none in MJCF. */
static void write_tendons(mbsri_file_writer *w)
{
    bool open = false;
    const mbsri_written_spring *s = w->springs.items;
    for (int id = 0; id < mbsr_model_forces(w->model); ++id) {
        int coordinate[MBSRI_TRANSMISSION_MOST];
        double factor[MBSRI_TRANSMISSION_MOST], scale = 1.0;
        mbsr_force_def def;
        mbsri_transmission t;
        if (mbsr_force_definition(w->model, id, &def) || !is_transmission(w, &def, id) ||
            !mbsri_transmission_of(&def, &t, coordinate, factor))
            continue;
        if (t.law.control && t.count == 1) continue;
        for (int k = 0; t.law.control && k < w->file->actuators; ++k)
            if (w->file->actuator[k].force == id) scale = gear_of(w->file->actuator + k);
        mbsri_write_section(w, &open, "tendon");
        write_sum(w, mbsri_write_print(w, "tendon_%d", id), &t, scale, !t.law.control);
    }
    write_closure_sums(w, &open);
    for (int k = 0; k < w->springs.count; ++k) {
        mbsri_write_section(w, &open, "tendon");
        mbsri_begin(&w->text, "spatial");
        mbsri_set_text(&w->text, "name", s[k].name);
        mbsri_set_number(&w->text, "stiffness", s[k].stiffness);
        mbsri_set_number(&w->text, "damping", s[k].damping);
        mbsri_set_numbers(&w->text, "springlength", s[k].rest[0] < s[k].rest[1] ? 2 : 1, s[k].rest);
        mbsri_into(&w->text);
        for (int l = 0; l < s[k].count; ++l) {
            mbsri_begin(&w->text, "site");
            mbsri_set_text(&w->text, "site", s[k].site[l]);
            mbsri_end(&w->text);
        }
        mbsri_out(&w->text, "spatial");
    }
    if (open) mbsri_out(&w->text, "tendon");
}

/* What it acts on: a joint, a tendon or a site. False: nothing that is written. */
static bool write_target(mbsri_file_writer *w, const mbsr_file_actuator *a)
{
    int coordinate[MBSRI_TRANSMISSION_MOST];
    double factor[MBSRI_TRANSMISSION_MOST];
    mbsr_force_def def;
    mbsri_transmission t;
    mbsri_thrust thrust;
    mbsri_text *x = &w->text;
    if (mbsr_force_definition(w->model, a->force, &def)) return false;
    const bool sums = mbsri_transmission_of(&def, &t, coordinate, factor);
    if (!sums && !mbsri_thrust_of(&def, &thrust)) return false;
    mbsri_begin(x, "general");
    mbsri_set_text(x, "name", a->name);
    if (!sums) {
        bool there;
        mbsri_set_text(x, "site",
                       mbsri_write_site_name(w, thrust.body, &thrust.frame,
                                             mbsri_write_print(w, "thrust_%d", a->force), &there));
        mbsri_set_numbers(x, "gear", 6, thrust.gear);
    } else if (t.count == 1) {
        mbsri_set_text(x, "joint", mbsri_written_joint_of(w, t.body[0], coordinate[0])->name);
        mbsri_set_number(x, "gear", factor[0]);
    } else {
        mbsri_set_text(x, "tendon", mbsri_write_print(w, "tendon_%d", a->force));
        mbsri_set_number(x, "gear", gear_of(a));
    }
    return true;
}

static void write_actuator(mbsri_file_writer *w, const mbsr_file_actuator *a)
{
    mbsri_text *x = &w->text;
    if (!write_target(w, a)) return;
    mbsri_set_number(x, "gainprm", a->gain);
    if (fabs(a->bias[0]) + fabs(a->bias[1]) + fabs(a->bias[2]) > 0.0) {
        mbsri_set_text(x, "biastype", "affine");
        mbsri_set_numbers(x, "biasprm", 3, a->bias);
    }
    if (a->limited) {
        mbsri_set_text(x, "ctrllimited", "true");
        mbsri_set_numbers(x, "ctrlrange", 2, a->range);
    }
    if (a->force_limited) {
        mbsri_set_text(x, "forcelimited", "true");
        mbsri_set_numbers(x, "forcerange", 2, a->force_range);
    }
    mbsri_end(x);
}

static void write_actuators(mbsri_file_writer *w)
{
    bool open = false;
    for (int k = 0; w->file && k < w->file->actuators; ++k) {
        const mbsr_file_actuator *a = w->file->actuator + k;
        char element[120];
        if (a->force != MBSR_NONE) {
            mbsri_write_section(w, &open, "actuator");
            write_actuator(w, a);
            continue;
        }
        snprintf(element, sizeof element, "actuator '%.80s'", a->name);
        mbsri_write_find(w, element, "the model does not have it: it is left out");
    }
    if (open) mbsri_out(&w->text, "actuator");
}

void mbsri_write_rest(mbsri_file_writer *w)
{
    write_tendons(w);
    write_actuators(w);
    mbsri_write_equalities(w);
    mbsri_write_contacts(w);
    mbsri_write_keys(w);
}

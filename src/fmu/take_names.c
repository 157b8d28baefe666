/* Names and start of coordinates, sites: see take_names.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/take_names.h"

#include "base/error.h"
#include "fmu/names.h"

#include <math.h>
#include <string.h>

/* The names of a body's coordinates: those of the body, or of the joints of the file that they are.
 */
static void name_coordinates(mbsri_unit_plan *p, const char *label, const int first[2],
                             const int count[2])
{
    mbsri_plan_coordinate *const list[2] = {p->q + first[0], p->u + first[1]};
    for (int v = 0; v < 2; ++v)
        for (int k = 0; k < count[v]; ++k) {
            list[v][k].joint = label;
            list[v][k].place = count[v] > 1 ? k + 1 : 0;
        }
}

static void name_by_file(mbsri_unit_plan *p, const mbsr_file *file, const mbsr_model *model)
{
    static const int sizes[][2] = {[MBSR_FILE_FIXED] = {0, 0},
                                   [MBSR_FILE_HINGE] = {1, 1},
                                   [MBSR_FILE_SLIDE] = {1, 1},
                                   [MBSR_FILE_BALL] = {4, 3},
                                   [MBSR_FILE_FREE] = {7, 6}};
    for (int k = 0; k < file->joints; ++k) {
        const mbsr_file_joint *j = file->joint + k;
        int first[2], count[2], own[2];
        if (!*j->name || mbsr_body_locks(model, j->body) > 0 ||
            mbsr_body_coordinates(model, j->body, first, own, first + 1, own + 1))
            continue;
        first[0] += j->position;
        first[1] += j->coordinate;
        memcpy(count, sizes[j->kind], sizeof count);
        if (j->position + count[0] <= own[0] && j->coordinate + count[1] <= own[1])
            name_coordinates(p, j->name, first, count);
    }
}

static const char *body_label(mbsri_unit_plan *p, int id)
{
    return mbsri_fmu_label(&p->arena, "body", p->body[id].def.name, id);
}

static void take_kinds(mbsri_unit_plan *p, const mbsr_model *model, int id, const int first[2],
                       const int count[2])
{
    mbsr_coordinate_kind kind[2][MBSR_MAX_D + 2];
    mbsri_plan_coordinate *const list[2] = {p->q + first[0], p->u + first[1]};
    mbsr_body_coordinate_kinds(model, id, kind[0], kind[1]);
    for (int v = 0; v < 2; ++v)
        for (int k = 0; k < count[v]; ++k) list[v][k].kind = (int)kind[v][k];
    if (count[0] == count[1] + 1) /* a quaternion */
        for (int k = 0; k < 4; ++k) list[0][k].kind = MBSR_COORDINATE_OTHER;
}

static int take_coordinates(mbsri_unit_plan *p, const mbsr_model *model, const mbsr_fmu_opt *opt)
{
    for (int id = 0; id < p->bodies; ++id) {
        int first[2], count[2];
        const char *label = body_label(p, id);
        if (!label) return MBSR_ERR_NO_MEMORY;
        mbsr_body_coordinates(model, id, first, count, first + 1, count + 1);
        name_coordinates(p, label, first, count);
        take_kinds(p, model, id, first, count);
        if (count[0] == count[1] + 1) p->q[first[0]].start = 1.0;
    }
    if (opt->file) name_by_file(p, opt->file, model);
    for (int k = 0; k < p->nq && opt->q0; ++k) p->q[k].start = opt->q0[k];
    for (int k = 0; k < p->nu && opt->u0; ++k) p->u[k].start = opt->u0[k];
    return MBSR_OK;
}

/* Elements without a name are called by their joint and what they are, or by the latter and their
 * id; actuators as the file does. */
static int name_forces(mbsri_unit_plan *p, const mbsr_fmu_opt *opt)
{
    for (int k = 0; k < p->forces; ++k) {
        mbsr_force_def *def = &p->force[k].def;
        const char *kind = def->table->name;
        if (def->name && *def->name) continue;
        for (int a = 0; opt->file && a < opt->file->actuators; ++a)
            if (opt->file->actuator[a].force == k) def->name = opt->file->actuator[a].name;
        if (def->name && *def->name) continue;
        char text[256];
        const bool joint = strncmp(kind, "joint ", 6) == 0;
        const int rate = joint ? mbsri_plan_rate(p, def->body[0], def->option[0]) : -1;
        if (rate >= 0)
            mbsri_print(text, sizeof text, "%.200s_%s", p->u[rate].joint, kind + 6);
        else if (strcmp(kind, "gravity") == 0)
            mbsri_print(text, sizeof text, "gravity");
        else
            mbsri_print(text, sizeof text, "%s_%d", kind, k);
        for (char *c = text; *c; ++c)
            if (*c == ' ' || *c == '-') *c = '_';
        def->name = mbsri_arena_text(&p->arena, text, strlen(text));
        if (!def->name) return MBSR_ERR_NO_MEMORY;
    }
    return MBSR_OK;
}

/* Units of inputs that are wrenches or joint forces. */
static void find_units(mbsri_unit_plan *p, const mbsr_model *model)
{
    for (int k = 0; k < p->forces; ++k) {
        const mbsri_plan_force *f = p->force + k;
        const bool wrench = strcmp(f->def.table->name, "wrench") == 0;
        int at, n;
        if (f->link.kind != MBSRI_LINK_INPUT || f->link.function != 2) continue;
        mbsri_plan_input *input = p->input + f->link.index;
        for (int c = 0; wrench && c < 6; ++c) input[c].unit = c < 3 ? "N.m" : "N";
        if (strcmp(f->def.table->name, "applied joint force") != 0) continue;
        mbsr_body_coordinates(model, f->def.body[0], NULL, NULL, &at, &n);
        for (int c = 0; c < n; ++c) input[c].unit = mbsri_plan_effort(p, at + c);
    }
}

/* The sites given, those of the file, or the frames of all bodies. Those on the ground do not move,
 * and are left out. */
static int take_sites(mbsri_unit_plan *p, const mbsr_fmu_opt *opt, mbsr_error *error)
{
    const mbsr_file_site *site = opt->sites >= 0 ? opt->site : opt->file ? opt->file->site : NULL;
    int count = opt->sites >= 0 ? opt->sites : opt->file ? opt->file->sites : 0;
    const bool of_bodies = opt->sites < 0 && count == 0;
    if (of_bodies) count = p->bodies;
    p->site = mbsri_arena_take(&p->arena, ((size_t)count + 1) * sizeof *p->site);
    if (!p->site) return MBSR_ERR_NO_MEMORY;
    for (int k = 0; k < count; ++k) {
        mbsri_plan_site *to = p->site + p->sites;
        if (of_bodies) {
            *to = (mbsri_plan_site){body_label(p, k), k, mbsr_frame_identity()};
        } else if (site[k].body == MBSR_GROUND) {
            continue;
        } else {
            *to = (mbsri_plan_site){site[k].name, site[k].body, site[k].frame};
        }
        if (to->body < 0 || to->body >= p->bodies)
            return mbsri_fail_plain(error, MBSR_ERR_VALUE,
                                    "mbsr_fmu_export: site %d is on body %d, there are %d", k,
                                    to->body, p->bodies);
        if (!to->name) return MBSR_ERR_NO_MEMORY;
        if (p->body[to->body].def.joint.space != MBSR_SPACE_GENERAL) ++p->sites;
    }
    return MBSR_OK;
}

static int check_start(const mbsri_unit_plan *p, mbsr_error *error)
{
    for (int k = 0; k < p->nq + p->nu; ++k) {
        const mbsri_plan_coordinate *c = k < p->nq ? p->q + k : p->u + (k - p->nq);
        if (!isfinite(c->start))
            return mbsri_fail_plain(error, MBSR_NOT_FINITE, "mbsr_fmu_export: %s[%d] is %g",
                                    k < p->nq ? "q0" : "u0", k < p->nq ? k : k - p->nq, c->start);
    }
    return MBSR_OK;
}

int mbsri_take_names(mbsri_unit_plan *plan, const mbsr_model *model, const mbsr_fmu_opt *opt,
                     mbsr_error *error)
{
    const char *name = opt->name ? opt->name : opt->file ? opt->file->name : "";
    plan->name = mbsri_printable(&plan->arena, *name ? name : "model");
    plan->nq = mbsr_model_nq(model);
    plan->nu = mbsr_model_nu(model);
    plan->q = mbsri_arena_take(&plan->arena, ((size_t)plan->nq + 1) * sizeof *plan->q);
    plan->u = mbsri_arena_take(&plan->arena, ((size_t)plan->nu + 1) * sizeof *plan->u);
    int status = plan->name && plan->q && plan->u ? MBSR_OK : MBSR_ERR_NO_MEMORY;
    if (!status) status = take_coordinates(plan, model, opt);
    if (!status) status = name_forces(plan, opt);
    if (status) return mbsri_fail_plain(error, status, "mbsr_fmu_export: no memory for the names");
    find_units(plan, model);
    status = take_sites(plan, opt, error);
    return status ? status : check_start(plan, error);
}

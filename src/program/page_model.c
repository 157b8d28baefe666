/* The model in the data of a page: see page.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/page.h"
#include "program/progress.h"
#include "program/surface.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static void put_vector(FILE *to, const char *name, int n, const double *x)
{
    fprintf(to, ", \"%s\": ", name);
    put_numbers(to, n, x);
}

static void put_scalar(FILE *to, const char *name, double x)
{
    fprintf(to, ", \"%s\": ", name);
    put_number(to, x);
}

/* Where a frame is: origin, then axes by columns. */
static void put_frame(FILE *to, const char *name, const mbsr_frame *frame)
{
    double numbers[12];
    memcpy(numbers, frame->x, sizeof frame->x);
    memcpy(numbers + 3, frame->R, sizeof frame->R);
    put_vector(to, name, 12, numbers);
}

/* ---- bodies and joints ---- */

/* What carries the body: frames A and B, between them axes and a quaternion, as in
 * mbsr_joint_chain. */
static void put_chain(FILE *to, const mbsr_joint *joint)
{
    static const char *const kinds[] = {"", "hinge", "slide", "screw"};
    mbsr_joint_chain c;
    if (mbsr_joint_chain_of(joint, &c))
        c = (mbsr_joint_chain){.A = mbsr_frame_identity(), .B = mbsr_frame_identity()};
    put_frame(to, "A", &c.A);
    put_frame(to, "B", &c.B);
    fprintf(to, ", \"quaternion\": %s, \"axes\": [", c.quaternion ? "true" : "false");
    for (int k = 0; k < c.axes; ++k) {
        fprintf(to, "%s{\"kind\": \"%s\"", k > 0 ? ", " : "", kinds[c.axis[k].kind]);
        put_vector(to, "direction", 3, c.axis[k].direction);
        put_scalar(to, "pitch", c.axis[k].pitch);
        fputc('}', to);
    }
    fputc(']', to);
}

static void put_bodies(FILE *to, const program_model *m)
{
    fputs("\"bodies\": [", to);
    for (int k = 0; k < m->file->bodies; ++k) {
        mbsr_body_def def = mbsr_default_body_def();
        double mass;
        int q;
        mbsr_body_definition(m->model, k, &def);
        mbsr_body_coordinates(m->model, k, &q, NULL, NULL, NULL);
        const bool massless = weigh_body(&def.inertia, &mass);
        fputs(k > 0 ? ",\n{\"name\": " : "\n{\"name\": ", to);
        put_json(to, m->file->body_name[k]);
        fprintf(to, ", \"parent\": %d, \"massless\": %s", def.parent, massless ? "true" : "false");
        put_scalar(to, "mass", mass);
        fprintf(to, ", \"q\": %d", q);
        put_vector(to, "centre", 3, def.inertia.com);
        put_chain(to, &def.joint);
        fputc('}', to);
    }
    fputs("],\n", to);
}

/* Ranges are null where there are none. */
static void put_joints(FILE *to, const mbsr_file *f)
{
    static const char *const kinds[] = {"fixed", "hinge", "slide", "ball", "free"};
    fputs("\"joints\": [", to);
    for (int k = 0; k < f->joints; ++k) {
        const mbsr_file_joint *j = f->joint + k;
        fputs(k > 0 ? ",\n{\"name\": " : "\n{\"name\": ", to);
        put_json(to, j->name);
        fprintf(to,
                ", \"kind\": \"%s\", \"body\": %d, \"position\": %d, \"range\": ", kinds[j->kind],
                j->body, j->position);
        if (j->limited)
            put_numbers(to, 2, j->range);
        else
            fputs("null", to);
        fputc('}', to);
    }
    fputs("],\n", to);
}

/* Joints that follow others: the sum of coefficient[k] q[k] is the offset. */
static void put_couplings(FILE *to, const program_model *m)
{
    const mbsr_closure_table *coupling = mbsr_closure_coupling(0, NULL, NULL, NULL, 0.0).table;
    const char *before = "";
    fputs("\"couplings\": [", to);
    for (int k = 0; k < mbsr_model_closures(m->model); ++k) {
        mbsr_closure_def def;
        if (mbsr_closure_definition(m->model, k, &def) || def.table != coupling) continue;
        fprintf(to, "%s{\"q\": ", before);
        for (int l = 0; l < def.bodies; ++l) {
            int q;
            mbsr_body_coordinates(m->model, def.body[l], &q, NULL, NULL, NULL);
            fprintf(to, "%c%d", l > 0 ? ',' : '[', q + def.option[l]);
        }
        fputc(']', to);
        put_vector(to, "coefficient", def.bodies, def.param);
        put_scalar(to, "offset", def.param[MBSR_CLOSURE_BODIES]);
        fputc('}', to);
        before = ",\n";
    }
    fputs("],\n", to);
}

/* Loops of bodies: a ball joint or weld between frames on two of them, -1 the ground. */
static void put_ties(FILE *to, const program_model *m)
{
    const mbsr_closure_table *weld = mbsr_closure_weld(0, NULL, 1, NULL).table,
                             *ball = mbsr_closure_ball(0, NULL, 1, NULL).table;
    const char *before = "";
    fputs("\"ties\": [", to);
    for (int k = 0; k < mbsr_model_closures(m->model); ++k) {
        mbsr_closure_def def;
        if (mbsr_closure_definition(m->model, k, &def) || (def.table != weld && def.table != ball))
            continue;
        fprintf(to, "%s{\"kind\": \"%s\", \"body\": [%d, %d], \"frames\": [", before,
                def.table == weld ? "weld" : "ball", def.body[0], def.body[1]);
        put_numbers(to, 12, def.param);
        fputc(',', to);
        put_numbers(to, 12, def.param + 12);
        fputs("]}", to);
        before = ",\n";
    }
    fputs("],\n", to);
}

/* ---- what stands on bodies ---- */

/* What a mesh is called in the page: its file, or the first shape with its numbers. NULL: none. */
static const char *mesh_name(const mbsr_file *f, int k, char name[32])
{
    const mbsr_file_shape *s = f->shape;
    int first = 0;
    if (s[k].triangles == 0) return s[k].mesh;
    while (s[first].triangle != s[k].triangle) ++first;
    snprintf(name, 32, "#%d", first);
    return name;
}

static void put_shapes(FILE *to, const mbsr_file *f)
{
    static const char *const kinds[] = {"box",       "sphere", "cylinder", "capsule",
                                        "ellipsoid", "plane",  "mesh",     "mesh"};
    static const double whole[3] = {1.0, 1.0, 1.0};
    fputs("\"shapes\": [", to);
    for (int k = 0; k < f->shapes; ++k) {
        const mbsr_file_shape *s = f->shape + k;
        double quaternion[4];
        mbsr_rotation_quaternion(s->frame.R, quaternion);
        fprintf(to,
                "%s{\"body\": %d, \"kind\": \"%s\", \"visual\": %s, \"contact\": %s, \"name\": ",
                k > 0 ? ",\n" : "\n", s->body, kinds[s->kind], s->visual ? "true" : "false",
                s->contact ? "true" : "false");
        put_json(to, s->name);
        put_vector(to, "at", 3, s->frame.x);
        put_vector(to, "turn", 4, quaternion);
        put_vector(to, "size", 3, s->kind == MBSR_SHAPE_HEIGHTS ? whole : s->size);
        put_vector(to, "colour", 4, s->colour);
        fprintf(to, ", \"coloured\": %s", s->coloured ? "true" : "false");
        char own[32];
        const char *mesh = mesh_name(f, k, own);
        if (mesh) fputs(", \"mesh\": ", to), put_json(to, mesh);
        fputc('}', to);
    }
    fputs("],\n", to);
}

static void put_sites(FILE *to, const mbsr_file *f)
{
    fputs("\"sites\": [", to);
    for (int k = 0; k < f->sites; ++k) {
        fputs(k > 0 ? ",\n{\"name\": " : "\n{\"name\": ", to);
        put_json(to, f->site[k].name);
        fprintf(to, ", \"body\": %d", f->site[k].body);
        put_frame(to, "frame", &f->site[k].frame);
        fputc('}', to);
    }
    fputs("],\n", to);
}

/* Those that the file gives by numbers, each once; what stands before the next one is returned. */
static const char *put_numbered_meshes(FILE *to, const mbsr_file *f)
{
    const char *before = "\n";
    for (int k = 0; k < f->shapes; ++k) {
        const mbsr_file_shape *s = f->shape + k;
        char name[32], first[32];
        mbsr_error error = {.text = ""};
        snprintf(first, sizeof first, "#%d", k);
        if (s->triangles == 0 || strcmp(mesh_name(f, k, name), first) != 0) continue;
        fprintf(to, "%s\"%s\": ", before, name);
        if (put_triangles(to, name, s->triangles, s->triangle, &error))
            say(stderr, "%s: its body is drawn without\n", error.text);
        before = ",\n";
    }
    return before;
}

/* Each file once, by the name that shapes have for it; those that are not drawn are told. */
static void put_meshes(FILE *to, const page *p)
{
    const mbsr_file *f = p->model->file;
    progress shown = progress_begin("meshes", f->shapes, false);
    fputs("\"meshes\": {", to);
    const char *before = put_numbered_meshes(to, f);
    for (int k = 0; k < f->shapes; ++k) {
        progress_show(&shown, k);
        const char *name = new_mesh(p->model, k);
        if (!name) continue;
        size_t size;
        char *bytes = read_beside(p->options, name, &size);
        if (!bytes) {
            const char *why = errno == EPERM
                                  ? "it is elsewhere than the model: --folder, --anywhere"
                                  : strerror(errno);
            progress_end(&shown);
            say(stderr, "mesh '%s' cannot be read (%s): its body is drawn without\n", name, why);
            continue;
        }
        fputs(before, to);
        put_json(to, name);
        fputs(": ", to);
        mbsr_error error = {.text = ""};
        if (put_mesh(to, name, bytes, size, &error)) {
            progress_end(&shown);
            say(stderr, "%s: its body is drawn without\n", error.text);
        }
        before = ",\n";
        free(bytes);
    }
    progress_end(&shown);
    fputs("},\n", to);
}

void page_put_model(FILE *to, const page *p)
{
    put_bodies(to, p->model);
    put_joints(to, p->model->file);
    put_couplings(to, p->model);
    put_ties(to, p->model);
    put_shapes(to, p->model->file);
    put_sites(to, p->model->file);
    put_meshes(to, p);
}

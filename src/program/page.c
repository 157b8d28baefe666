/* The data of a page: see page.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/page.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static void put_number(FILE *to, double x)
{
    if (isfinite(x))
        fprintf(to, "%.9g", x);
    else
        fputs("null", to);
}

static void put_numbers(FILE *to, int n, const double *x)
{
    for (int k = 0; k < n; ++k) {
        fputc(k > 0 ? ',' : '[', to);
        put_number(to, x[k]);
    }
    fputs(n > 0 ? "]" : "[]", to);
}

/* Bytes in base64, in quotes. */
static void put_bytes(FILE *to, const void *bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *b = bytes;
    fputc('"', to);
    for (size_t k = 0; k < size; k += 3) {
        const size_t left = size - k;
        const unsigned long group = (unsigned long)b[k] << 16 |
                                    (left > 1 ? (unsigned long)b[k + 1] << 8 : 0) |
                                    (left > 2 ? b[k + 2] : 0);
        const char four[4] = {digits[group >> 18], digits[group >> 12 & 63],
                              left > 1 ? digits[group >> 6 & 63] : '=',
                              left > 2 ? digits[group & 63] : '='};
        fwrite(four, 1, 4, to);
    }
    fputc('"', to);
}

/* Numbers of 4 bytes, the lowest byte first. */
static void put_floats(FILE *to, size_t n, const float *x)
{
    unsigned char *bytes = malloc(4 * n + 1);
    for (size_t k = 0; k < n && bytes; ++k) {
        uint32_t bits;
        memcpy(&bits, x + k, sizeof bits);
        for (int l = 0; l < 4; ++l) bytes[4 * k + (size_t)l] = (unsigned char)(bits >> 8 * l);
    }
    put_bytes(to, bytes, bytes ? 4 * n : 0);
    free(bytes);
}

/* ---- the model ---- */

/* Where the joint is on the predecessor and on the body, and its axes in the predecessor. */
static void put_joint(FILE *to, const mbsr_joint *joint, const double point[3])
{
    static const char *const kinds[] = {"", "hinge", "slide", "screw"};
    mbsr_joint_chain c;
    if (mbsr_joint_chain_of(joint, &c)) c = (mbsr_joint_chain){.A = mbsr_frame_identity()};
    fputs(", \"anchor\": ", to);
    put_numbers(to, 3, c.A.x);
    fputs(", \"point\": ", to);
    put_numbers(to, 3, point);
    fprintf(to, ", \"ball\": %s, \"axes\": [", c.quaternion ? "true" : "false");
    for (int k = 0; k < c.axes; ++k) {
        double axis[3] = {0.0};
        for (int l = 0; l < 9; ++l) axis[l % 3] += c.A.R[l] * c.axis[k].direction[l / 3];
        fprintf(to, "%s{\"kind\": \"%s\", \"direction\": ", k > 0 ? ", " : "",
                kinds[c.axis[k].kind]);
        put_numbers(to, 3, axis);
        fputc('}', to);
    }
    fputc(']', to);
}

static void put_bodies(FILE *to, const page *p)
{
    const mbsr_file *f = p->model->file;
    fputs("\"bodies\": [", to);
    for (int k = 0; k < f->bodies; ++k) {
        mbsr_body_def def = mbsr_default_body_def();
        double mass;
        mbsr_body_definition(p->model->model, k, &def);
        const bool massless = weigh_body(&def.inertia, &mass);
        fputs(k > 0 ? ",\n{\"name\": " : "\n{\"name\": ", to);
        put_json(to, f->body_name[k]);
        fprintf(to, ", \"parent\": %d, \"massless\": %s, \"mass\": ", def.parent,
                massless ? "true" : "false");
        put_number(to, mass);
        fputs(", \"centre\": ", to);
        put_numbers(to, 3, def.inertia.com);
        put_joint(to, &def.joint, p->motion->point + 3 * (size_t)k);
        fputs(", \"joints\": [", to);
        const char *before = "";
        for (int j = 0; j < f->joints; ++j) {
            if (f->joint[j].body != k) continue;
            fputs(before, to);
            put_json(to, f->joint[j].name);
            before = ", ";
        }
        fputs("]}", to);
    }
    fputs("]", to);
}

static void put_shapes(FILE *to, const mbsr_file *f)
{
    static const char *const kinds[] = {"box",       "sphere", "cylinder", "capsule",
                                        "ellipsoid", "plane",  "mesh"};
    fputs("\"shapes\": [", to);
    for (int k = 0; k < f->shapes; ++k) {
        const mbsr_file_shape *s = f->shape + k;
        double quaternion[4];
        mbsr_rotation_quaternion(s->frame.R, quaternion);
        fprintf(to, "%s{\"body\": %d, \"kind\": \"%s\", \"visual\": %s, \"name\": ",
                k > 0 ? ",\n" : "\n", s->body, kinds[s->kind], s->visual ? "true" : "false");
        put_json(to, s->name);
        fputs(", \"at\": ", to);
        put_numbers(to, 3, s->frame.x);
        fputs(", \"turn\": ", to);
        put_numbers(to, 4, quaternion);
        fputs(", \"size\": ", to);
        put_numbers(to, 3, s->size);
        fputs(", \"colour\": ", to);
        put_numbers(to, 4, s->colour);
        if (s->mesh) fputs(", \"mesh\": ", to), put_json(to, s->mesh);
        fputc('}', to);
    }
    fputs("]", to);
}

/* Each file once, by the name that shapes have for it; those that are not there are told. */
static void put_meshes(FILE *to, const page *p)
{
    const mbsr_file *f = p->model->file;
    const char *before = "\n";
    fputs("\"meshes\": {", to);
    for (int k = 0; k < f->shapes; ++k) {
        const char *name = f->shape[k].mesh;
        bool known = !name;
        for (int l = 0; l < k && !known; ++l)
            known = f->shape[l].mesh && strcmp(f->shape[l].mesh, name) == 0;
        if (known) continue;
        size_t size;
        char *bytes = read_beside(p->options, name, &size);
        if (!bytes) {
            fprintf(stderr, "mesh '%s' cannot be read: its body is drawn without\n", name);
            continue;
        }
        fputs(before, to);
        put_json(to, name);
        fputs(": ", to);
        put_bytes(to, bytes, size);
        before = ",\n";
        free(bytes);
    }
    fputs("}", to);
}

/* ---- the run ---- */

static int put_columns(FILE *to, const table *run)
{
    fputs("\"columns\": [", to);
    float *values = run ? malloc((size_t)run->lines * sizeof *values) : NULL;
    if (run && !values) return complain(FAILED, "no memory");
    for (int k = 1; run && k < run->columns; ++k) {
        for (int l = 0; l < run->lines; ++l) values[l] = (float)table_at(run, l, k);
        fputs(k > 1 ? ",\n{\"name\": " : "\n{\"name\": ", to);
        put_json(to, run->name[k]);
        fputs(", \"values\": ", to);
        put_floats(to, (size_t)run->lines, values);
        fputc('}', to);
    }
    free(values);
    fputs("]", to);
    return DONE;
}

static void put_motion(FILE *to, const page *p)
{
    const motion *m = p->motion;
    const size_t all = (size_t)m->samples * (size_t)p->model->file->bodies;
    fputs("\"times\": ", to);
    put_numbers(to, m->samples, m->time);
    fputs(",\n\"poses\": ", to);
    put_floats(to, POSE_NUMBERS * all, m->pose);
    fputs(",\n\"reactions\": ", to);
    if (m->reaction)
        put_floats(to, REACTION_NUMBERS * all, m->reaction);
    else
        fputs("null", to);
    fputs(",\n\"loops\": [", to);
    for (int k = 0; k < m->loops; ++k) {
        fputs(k > 0 ? ", {\"name\": " : "{\"name\": ", to);
        put_json(to, mbsr_closure_name(p->model->model, m->loop[k].closure));
        fprintf(to, ", \"body\": %d}", m->loop[k].body);
    }
    fputs("],\n\"loopForces\": ", to);
    if (m->loop_force)
        put_floats(to, LOOP_NUMBERS * (size_t)m->samples * (size_t)m->loops, m->loop_force);
    else
        fputs("null", to);
    fputs(",\n\"without\": ", to);
    put_json(to, m->without);
}

static void put_findings(FILE *to, const mbsr_file *f)
{
    fputs("\"findings\": [", to);
    for (int k = 0; k < f->findings; ++k) {
        fprintf(to, "%s{\"line\": %d, \"element\": ", k > 0 ? ",\n" : "\n", f->finding[k].line);
        put_json(to, f->finding[k].element);
        fputs(", \"text\": ", to);
        put_json(to, f->finding[k].text);
        fputc('}', to);
    }
    fputs("]", to);
}

int page_write(FILE *to, const page *p)
{
    const char *slash = strrchr(p->options->path, '/');
    const mbsr_file *f = p->model->file;
    fputs("{\"title\": ", to);
    put_json(to, f->name[0] ? f->name : slash ? slash + 1 : p->options->path);
    fputs(", \"file\": ", to);
    put_json(to, p->options->path);
    fprintf(to, ", \"version\": \"%s\",\n", mbsr_version());
    put_bodies(to, p);
    fputs(",\n", to);
    put_shapes(to, f);
    fputs(",\n", to);
    put_meshes(to, p);
    fputs(",\n", to);
    put_motion(to, p);
    fputs(",\n", to);
    int code = put_columns(to, p->run);
    fputs(",\n", to);
    put_findings(to, f);
    fputs(",\n\"report\": ", to);
    if (!code && report_write(to, p->model, p->q, p->u, true) > UNDETERMINED) fputs("null", to);
    fputs("}\n", to);
    return code;
}

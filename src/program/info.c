/* mbsrank info: what a model consists of.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/program.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const kinds[] = {"fixed", "hinge", "slide", "ball", "free"};

/* Mass of all bodies at the start; a code. */
static int weigh_all(const program_model *m, const double *q, double *mass, double centre[3])
{
    const int n = mbsr_model_nu(m->model);
    double *u = calloc((size_t)n + 1, sizeof *u);
    int status = u ? mbsr_stage_positions(m->model, m->data, 0.0, q) : MBSR_ERR_NO_MEMORY;
    if (!status) status = mbsr_stage_velocities(m->model, m->data, u);
    if (!status) status = mbsr_tree_momentum(m->model, m->data, NULL, mass, centre, NULL);
    free(u);
    return status ? complain(FAILED, "%s", mbsr_data_error(m->data)->text) : DONE;
}

/* weigh_body of body k. */
static bool mass_of(const program_model *m, int k, double *mass)
{
    mbsr_body_def def = mbsr_default_body_def();
    mbsr_body_definition(m->model, k, &def);
    return weigh_body(&def.inertia, mass);
}

/* The first joint of each body, and the next one of the same; -1: none. Beside them how deep bodies
 * are. */
typedef struct tree {
    int *first, *next, *depth;
} tree;

static bool make_tree(const program_model *m, tree *t)
{
    const mbsr_file *f = m->file;
    const size_t bodies = (size_t)f->bodies + 1;
    t->first = malloc((2 * bodies + (size_t)f->joints + 1) * sizeof *t->first);
    if (!t->first) return false;
    t->depth = t->first + bodies;
    t->next = t->depth + bodies;
    for (int k = 0; k < f->bodies; ++k) {
        const int parent = mbsr_body_parent(m->model, k);
        t->first[k] = -1;
        t->depth[k] = parent < 0 ? 0 : t->depth[parent] + 1; /* read before */
    }
    for (int k = f->joints - 1; k >= 0; --k) {
        t->next[k] = t->first[f->joint[k].body];
        t->first[f->joint[k].body] = k;
    }
    return true;
}

static void print_body(FILE *to, const program_model *m, const tree *t, int k)
{
    const mbsr_file *f = m->file;
    double own;
    int q;
    const bool massless = mass_of(m, k, &own);
    mbsr_body_coordinates(m->model, k, &q, NULL, NULL, NULL);
    say(to, "%*s%s  ", 2 * t->depth[k], "", f->body_name[k][0] ? f->body_name[k] : "(no name)");
    if (massless)
        fprintf(to, "no mass");
    else if (isfinite(own))
        fprintf(to, "%.6g kg", own);
    else
        fprintf(to, "a tensor that no body has");
    for (int j = t->first[k]; j >= 0; j = t->next[j])
        say(to, "  %s '%s' q[%d]", kinds[f->joint[j].kind], f->joint[j].name,
            q + f->joint[j].position);
    fputc('\n', to);
}

static int print_text(FILE *to, const program_options *o, const program_model *m, double mass,
                      const double centre[3])
{
    const mbsr_file *f = m->file;
    tree t;
    if (!make_tree(m, &t)) return complain(FAILED, "no memory");
    say(to, "%s: %d bodies, %d joints, nq %d, nu %d, %d closures with %d rows\n",
        f->name[0] ? f->name : "(no name)", f->bodies, f->joints, f->nq, f->nu,
        mbsr_model_closures(m->model), mbsr_model_rows(m->model));
    fprintf(to, "mass %.9g kg, centre of mass (%.6g, %.6g, %.6g) m as drawn\n", mass, centre[0],
            centre[1], centre[2]);
    for (int k = 0; k < f->bodies; ++k) print_body(to, m, &t, k);
    free(t.first);
    for (int k = 0; k < f->actuators; ++k)
        say(to, "actuator '%s'%s\n", f->actuator[k].name,
            f->actuator[k].force == MBSR_NONE ? " (left out)" : "");
    for (int k = 0; k < f->keys; ++k) say(to, "key '%s'\n", f->key[k].name);
    for (int k = 0; k < f->shapes; ++k)
        if (lacks_mesh(o, m, k)) say(to, "mesh '%s' is missing\n", f->shape[k].mesh);
    fprintf(to, "%d findings\n", f->findings);
    return DONE;
}

static void print_joints(FILE *to, const program_model *m)
{
    const mbsr_file *f = m->file;
    for (int k = 0; k < f->joints; ++k) {
        int q, u;
        mbsr_body_coordinates(m->model, f->joint[k].body, &q, NULL, &u, NULL);
        fprintf(to, "%s{\"name\": ", k > 0 ? ", " : "");
        put_json(to, f->joint[k].name);
        fprintf(to, ", \"type\": \"%s\", \"body\": %d, \"q\": %d, \"u\": %d, \"range\": ",
                kinds[f->joint[k].kind], f->joint[k].body, q + f->joint[k].position,
                u + f->joint[k].coordinate);
        if (f->joint[k].limited)
            fprintf(to, "[%.17g, %.17g]}", f->joint[k].range[0], f->joint[k].range[1]);
        else
            fprintf(to, "null}");
    }
}

static const char *actuator_name(const mbsr_file *f, int k)
{
    return f->actuator[k].name;
}

static const char *key_name(const mbsr_file *f, int k)
{
    return f->key[k].name;
}

/* Ends the list before. */
static void print_names(FILE *to, const char *title, int count,
                        const char *(*name)(const mbsr_file *, int), const mbsr_file *f)
{
    fprintf(to, "], \"%s\": [", title);
    for (int k = 0; k < count; ++k) {
        if (k > 0) fprintf(to, ", ");
        put_json(to, name(f, k));
    }
}

static int print_json(FILE *to, const program_options *o, const program_model *m, double mass,
                      const double centre[3])
{
    const mbsr_file *f = m->file;
    fprintf(to, "{\"name\": ");
    put_json(to, f->name);
    fprintf(to,
            ", \"nq\": %d, \"nu\": %d, \"rows\": %d, \"mass\": %.17g, \"centre\": [%.17g, %.17g, "
            "%.17g], \"bodies\": [",
            f->nq, f->nu, mbsr_model_rows(m->model), mass, centre[0], centre[1], centre[2]);
    for (int k = 0; k < f->bodies; ++k) {
        fprintf(to, "%s{\"name\": ", k > 0 ? ", " : "");
        put_json(to, f->body_name[k]);
        double own;
        const bool massless = mass_of(m, k, &own);
        fprintf(to, ", \"parent\": %d, \"massless\": %s, \"mass\": ", mbsr_body_parent(m->model, k),
                massless ? "true" : "false");
        if (isfinite(own))
            fprintf(to, "%.17g}", own);
        else
            fprintf(to, "null}");
    }
    fprintf(to, "], \"joints\": [");
    print_joints(to, m);
    const char *before = "";
    fprintf(to, "], \"missing\": [");
    for (int k = 0; k < f->shapes; ++k) {
        if (!lacks_mesh(o, m, k)) continue;
        fprintf(to, "%s", before);
        put_json(to, f->shape[k].mesh);
        before = ", ";
    }
    print_names(to, "actuators", f->actuators, actuator_name, f);
    print_names(to, "keys", f->keys, key_name, f);
    fprintf(to, "], \"findings\": [");
    for (int k = 0; k < f->findings; ++k) {
        fprintf(to, "%s{\"file\": ", k > 0 ? ", " : "");
        put_json(to, f->finding[k].file);
        fprintf(to, ", \"line\": %d, \"element\": ", f->finding[k].line);
        put_json(to, f->finding[k].element);
        fprintf(to, ", \"text\": ");
        put_json(to, f->finding[k].text);
        fputc('}', to);
    }
    fputs("]}\n", to);
    return DONE;
}

int parameters_write(FILE *to, const program_model *m, bool json)
{
    mbsr_parameters *list;
    mbsr_parameter p;
    mbsr_error error = {.text = ""};
    if (mbsr_parameters_create(m->model, &list, &error)) return complain(FAILED, "%s", error.text);
    if (json) fputc('[', to);
    for (int k = 0; !mbsr_parameter_get(list, k, &p); ++k) {
        if (!json) {
            say(to, "%s = %.9g%s%s\n", p.name, p.value, *p.unit ? " " : "", p.unit);
            continue;
        }
        fprintf(to, "%s{\"name\": ", k > 0 ? ",\n " : "");
        put_json(to, p.name);
        fprintf(to, ", \"value\": %.17g, \"unit\": \"%s\", \"description\": \"%s\"}", p.value,
                p.unit, p.description);
    }
    if (json) fputs("]\n", to);
    mbsr_parameters_destroy(list);
    return DONE;
}

int info_write(FILE *to, const program_options *o, const program_model *m, const double *q,
               bool json)
{
    double mass = 0.0, centre[3] = {0.0};
    const int code = weigh_all(m, q, &mass, centre);
    if (code) return code;
    return json ? print_json(to, o, m, mass, centre) : print_text(to, o, m, mass, centre);
}

int run_info(int argc, char **argv)
{
    program_options o = {.path = NULL};
    bool parameters = false;
    program_model m;
    const double *q, *u;
    int code = DONE;
    for (int at = 0; at < argc && !code; ++at) {
        if (strcmp(argv[at], "--parameters") == 0)
            parameters = true;
        else if (!common_option(argc, argv, &at, &o, &code))
            code = complain(USAGE, "info: there is no option %s", argv[at]);
        if (at < 0) break;
    }
    if (code) return code;
    code = open_model(&o, o.json, &m);
    if (parameters) {
        if (!code) code = parameters_write(stdout, &m, o.json);
        close_model(&m);
        return code;
    }
    if (!code) code = start_state(&o, &m, &q, &u);
    if (!code) code = info_write(stdout, &o, &m, q, o.json);
    close_model(&m);
    return code;
}

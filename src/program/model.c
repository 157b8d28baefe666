/* Models from files, for every command.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 200809L
#include "program/folders.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The value in "NAME=VALUE", whose name is cut off in place; NULL: complains that it is not of this
 * form. */
static const char *cut_pair(char *text, const char *option, const char *form)
{
    char *mark = strchr(text, '=');
    if (!mark || mark == text) {
        complain(USAGE, "%s: '%s' is not %s", option, text, form);
        return NULL;
    }
    *mark = '\0';
    return mark + 1;
}

static int add_package(program_options *o, char *text)
{
    const char *folder = cut_pair(text, "--package", "NAME=DIR");
    if (!folder) return USAGE;
    if (o->packages == MOST_PAIRS)
        return complain(USAGE, "--package: there are more than %d", MOST_PAIRS);
    o->package[o->packages++] = (mbsr_file_package){text, folder};
    return DONE;
}

static int add_argument(program_options *o, char *text)
{
    const char *value = cut_pair(text, "--arg", "NAME=VALUE");
    if (!value) return USAGE;
    if (o->arguments == MOST_PAIRS)
        return complain(USAGE, "--arg: there are more than %d", MOST_PAIRS);
    o->argument[o->arguments++] = (mbsr_xacro_argument){text, value};
    return DONE;
}

static int add_set(program_options *o, char *text)
{
    const char *value = cut_pair(text, "--set", "NAME=VALUE");
    char *end;
    if (!value) return USAGE;
    if (o->sets == MOST_PAIRS) return complain(USAGE, "--set: there are more than %d", MOST_PAIRS);
    o->value[o->sets] = strtod(value, &end);
    if (!*value || *end || !isfinite(o->value[o->sets]))
        return complain(USAGE, "--set: %s is '%s', which is no number", text, value);
    o->set[o->sets++] = text;
    return DONE;
}

/* What limits and dry friction of joints become; 1: taken, 0: another option, -1: a bad value. */
static int take_force(int argc, char **argv, int *at, program_options *o)
{
    static const char *const name[] = {"--stop-stiffness", "--stop-damping", "--slip"};
    double *const number[] = {&o->stop_stiffness, &o->stop_damping, &o->slip};
    for (int k = 0; k < 3; ++k) {
        const char *value = option_value(argc, argv, at, name[k]);
        if (*at < 0) return -1;
        if (value) return option_number(name[k], value, number[k]) ? 1 : -1;
    }
    return 0;
}

bool common_option(int argc, char **argv, int *at, program_options *o, int *code)
{
    const char *argument = argv[*at], *value;
    const int force = take_force(argc, argv, at, o);
    if (force) {
        if (force < 0) *code = USAGE;
    } else if (strcmp(argument, "--json") == 0) {
        o->json = true;
    } else if (strcmp(argument, "--strict") == 0) {
        o->strict = true;
    } else if (strcmp(argument, "--floating") == 0) {
        o->floating = true;
    } else if (strcmp(argument, "--no-limits") == 0) {
        o->limits = false;
    } else if (strcmp(argument, "--no-friction") == 0) {
        o->friction = false;
    } else if (strcmp(argument, "--no-contacts") == 0) {
        o->contacts = false;
    } else if (strcmp(argument, "--anywhere") == 0) {
        o->anywhere = true;
    } else if ((value = option_value(argc, argv, at, "--start"))) {
        o->start = value;
    } else if (*at >= 0 && (value = option_value(argc, argv, at, "--package"))) {
        *code = add_package(o, argv[*at] + strlen(argv[*at]) - strlen(value));
    } else if (*at >= 0 && (value = option_value(argc, argv, at, "--arg"))) {
        *code = add_argument(o, argv[*at] + strlen(argv[*at]) - strlen(value));
    } else if (*at >= 0 && (value = option_value(argc, argv, at, "--set"))) {
        *code = add_set(o, argv[*at] + strlen(argv[*at]) - strlen(value));
    } else if (*at >= 0 && (value = option_value(argc, argv, at, "--folder"))) {
        if (o->folders == 16) *code = complain(USAGE, "--folder: there are more than 16");
        if (!*code) o->folder[o->folders++] = value;
    } else if (*at < 0) {
        *code = USAGE;
    } else if (argument[0] != '-' || argument[1] == '\0') {
        if (o->path) *code = complain(USAGE, "one file at a time: '%s' is a second one", argument);
        o->path = argument;
    } else {
        return false;
    }
    return true;
}

/* ---- other files ---- */

/* Of hulls of meshes that touch: more cost time, two hulls as the product of their edges. */
enum { HULL_CORNERS = 32 };

typedef struct loaded {
    const program_options *options;
    program_model *model; /* which keeps their paths */
    char *text[4096];
    int count;
    bool told; /* that files elsewhere are not read */
} loaded;

static char *read_allowed(const program_options *o, const char *path, size_t *size)
{
    return may_read(o, path) ? read_file(path, size) : NULL;
}

/* False: no memory. */
static bool keep_path(program_model *m, const char *path)
{
    char **more = realloc(m->other, ((size_t)m->others + 1) * sizeof *more), *copy = strdup(path);
    if (more) m->other = more;
    if (!more || !copy) {
        free(copy);
        return false;
    }
    m->other[m->others++] = copy;
    return true;
}

static int load_file(void *user, const char *path, const char **text, size_t *size)
{
    loaded *l = user;
    if (l->count == (int)(sizeof l->text / sizeof *l->text)) return EMFILE;
    char *contents = read_allowed(l->options, path, size);
    if (!contents) {
        const int reason = errno;
        if (reason == EPERM && !l->told)
            say(stderr,
                "mbsrank: %s is elsewhere than the model: --folder DIR or --anywhere allows it\n",
                path);
        l->told = l->told || reason == EPERM;
        return reason;
    }
    l->text[l->count++] = contents;
    if (!keep_path(l->model, path)) return ENOMEM;
    *text = contents;
    return 0;
}

static int read_model(const program_options *o, program_model *m)
{
    loaded others = {.options = o, .model = m};
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_error error = {.text = ""};
    m->text = read_file(o->path, &m->size);
    if (!m->text) return complain_of_file(NOT_READ, o->path, "read");
    opt.strict = o->strict;
    opt.floating = o->floating;
    opt.limits = o->limits;
    opt.friction = o->friction;
    opt.stop_stiffness = o->stop_stiffness;
    opt.stop_damping = o->stop_damping;
    opt.slip = o->slip;
    opt.hull_corners = o->contacts ? HULL_CORNERS : 0;
    opt.packages = o->packages;
    opt.package = o->package;
    opt.xacro = (mbsr_xacro_opt){o->arguments, o->argument, 1}; /* may_read decides */
    opt.load = load_file;
    opt.user = &others;
    const int status = mbsr_file_read(m->text, m->size, o->path, &opt, &m->file, &error);
    for (int k = 0; k < others.count; ++k) free(others.text[k]);
    return status ? complain(NOT_READ, "%s", error.text) : DONE;
}

/* The file gets a model with the values of --set in the place of its own. */
static int set_parameters(const program_options *o, program_model *m)
{
    mbsr_parameters *list;
    mbsr_error error = {.text = ""};
    mbsr_model *made;
    int which[MOST_PAIRS], code = DONE;
    if (o->sets == 0) return DONE;
    if (mbsr_parameters_create(m->model, &list, &error)) return complain(FAILED, "%s", error.text);
    for (int k = 0; k < o->sets && !code; ++k) {
        which[k] = mbsr_parameters_find(list, o->set[k]);
        if (which[k] == MBSR_NONE)
            code = complain(USAGE, "--set: there is no parameter %s; mbsrank info --parameters",
                            o->set[k]);
    }
    if (!code && mbsr_parameters_model(list, o->sets, which, o->value, &made, &error))
        code = complain(USAGE, "--set: %s", error.text);
    mbsr_parameters_destroy(list);
    if (code) return code;
    m->read = mbsr_file_take_model(m->file);
    m->model = m->file->model = made;
    return DONE;
}

int open_model(const program_options *o, bool quiet, program_model *m)
{
    mbsr_error error = {.text = ""};
    *m = (program_model){.text = NULL};
    if (!o->path) return complain(USAGE, "there is no file; mbsrank --help");
    const int code = read_model(o, m);
    if (code) return code;
    m->model = m->file->model;
    for (int k = 0; k < m->file->findings && !quiet; ++k) {
        const mbsr_finding *f = m->file->finding + k;
        say(stderr, "%s:%d: %s: %s\n", f->file, f->line, f->element, f->text);
    }
    if (mbsr_model_finish(m->model))
        return complain(NOT_READ, "%s: %s", o->path, mbsr_model_error(m->model)->text);
    const int set = set_parameters(o, m);
    if (set) return set;
    if (mbsr_data_create(m->model, &m->data, &error)) return complain(FAILED, "%s", error.text);
    return DONE;
}

void close_model(program_model *m)
{
    mbsr_data_destroy(m->data);
    mbsr_file_destroy(m->file);
    mbsr_model_destroy(m->read);
    for (int k = 0; k < m->others; ++k) free(m->other[k]);
    free(m->other);
    free(m->text);
}

bool weigh_body(const mbsr_inertia *i, double *mass)
{
    const bool zero = i->kind == MBSR_INERTIA_NOT_GIVEN ||
                      (i->kind == MBSR_INERTIA_MATRIX && !i->matrix), /* zero, stated */
        rigid = i->kind == MBSR_INERTIA_SPATIAL || i->kind == MBSR_INERTIA_PARTICLE;
    bool none = i->mass == 0.0;
    for (int k = 0; k < 6; ++k) none = none && i->tensor[k] == 0.0;
    *mass = zero ? 0.0 : rigid ? i->mass : NAN;
    return zero || (rigid && none);
}

void model_hash(const program_model *m, char to[MODEL_HASH])
{
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t k = 0; k < m->size; ++k)
        hash = (hash ^ (unsigned char)m->text[k]) * UINT64_C(1099511628211);
    snprintf(to, MODEL_HASH, "%016" PRIx64, hash);
}

/* Its path in the folder of the model. */
enum { PATH = 2048 };
static const char *beside(const program_options *o, const char *name, char path[PATH])
{
    const char *slash = strrchr(o->path, '/');
    const int folder = slash && name[0] != '/' ? (int)(slash + 1 - o->path) : 0;
    snprintf(path, PATH, "%.*s%s", folder, o->path, name);
    return path;
}

char *read_beside(const program_options *o, const char *name, size_t *size)
{
    char path[PATH];
    char *text = read_allowed(o, beside(o, name, path), size);
    const int reason = errno;
    if (!text) text = read_allowed(o, name, size);
    if (!text && reason == EPERM) errno = EPERM;
    return text;
}

bool has_beside(const program_options *o, const char *name)
{
    char path[PATH];
    return may_read(o, beside(o, name, path)) || may_read(o, name);
}

const char *new_mesh(const program_model *m, int k)
{
    const mbsr_file_shape *shape = m->file->shape;
    const char *name = shape[k].mesh;
    for (int l = 0; l < k && name; ++l)
        if (shape[l].mesh && strcmp(shape[l].mesh, name) == 0) return NULL;
    return name;
}

bool lacks_mesh(const program_options *o, const program_model *m, int k)
{
    const char *name = new_mesh(m, k);
    return name && !has_beside(o, name);
}

int start_state(const program_options *o, const program_model *m, const double **q,
                const double **u)
{
    *q = m->file->q0;
    *u = NULL;
    if (!o->start) return DONE;
    const int key = mbsr_file_find_key(m->file, o->start);
    if (key < 0) return complain(USAGE, "%s has no key '%s'", o->path, o->start);
    *q = m->file->key[key].q;
    *u = m->file->key[key].u;
    for (int k = 0; k < m->file->actuators; ++k) m->file->control[k] = m->file->key[key].control[k];
    return DONE;
}

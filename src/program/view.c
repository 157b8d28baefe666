/* mbsrank view: a page that shows a model, and a run of it.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 200809L
#include "program/bytes.h"
#include "program/page.h"
#include "program/read_table.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct view_options {
    program_options common;
    const char *run, *inputs, *file;
    bool live;     /* the page runs the model itself */
    char own[256]; /* name of the page where -o says none */
} view_options;

/* The model's name with .html in the folder at hand, which may be a page of an earlier call and no
 * other file. */
static int name_page(view_options *o)
{
    static const char begins[] = "<!DOCTYPE html>\n<!-- A model of mbsrank";
    const char *slash = strrchr(o->common.path, '/'), *name = slash ? slash + 1 : o->common.path,
               *dot = strrchr(name, '.');
    char line[sizeof begins] = "";
    if (strcmp(name, "-") == 0) return complain(USAGE, "view: -o is missing");
    snprintf(o->own, sizeof o->own, "%.*s.html", dot && dot > name ? (int)(dot - name) : 200, name);
    FILE *there = fopen(o->own, "r");
    if (there) {
        const size_t size = fread(line, 1, sizeof line - 1, there);
        fclose(there);
        if (size > 0 && strcmp(line, begins) != 0)
            return complain(USAGE, "view: -o is missing, and %s is no page of mbsrank", o->own);
    }
    o->file = o->own;
    return DONE;
}

static int read_view_options(int argc, char **argv, view_options *o)
{
    int code = DONE;
    for (int at = 0; at < argc && !code; ++at) {
        const char *value;
        const bool second = o->common.path && (argv[at][0] != '-' || !argv[at][1]);
        if (second && o->run)
            return complain(USAGE, "view: one run at a time: '%s' is a second one", argv[at]);
        if (second)
            o->run = argv[at];
        else if (strcmp(argv[at], "--live") == 0)
            o->live = true;
        else if ((value = option_value(argc, argv, &at, "--inputs")))
            o->inputs = value;
        else if (at >= 0 && (value = option_value(argc, argv, &at, "-o")))
            o->file = value;
        else if (at >= 0 && !common_option(argc, argv, &at, &o->common, &code))
            return complain(USAGE, "view: there is no option %s", argv[at]);
        if (at < 0) return USAGE;
    }
    if (!code && o->common.json) return complain(USAGE, "view: there is no option --json");
    if (!code && o->live && (o->run || o->inputs))
        return complain(USAGE, "view: --live runs the model in the page: no run, no --inputs");
    return !code && o->common.path && !o->file ? name_page(o) : code;
}

static int read_run(const view_options *o, const program_model *m, table *run)
{
    char hash[MODEL_HASH];
    const int code = table_read(o->run, run);
    model_hash(m, hash);
    if (!code && run->hash[0] && strcmp(run->hash, hash) != 0)
        fprintf(stderr, "%s: the run is of a model with another text than %s has now\n", o->run,
                o->common.path);
    return code;
}

/* ---- the bundle: the page without data ---- */

/* viewer.html, or live.html of the package for JavaScript: beside the program in a build tree, else
 * where it is installed, seen from the program. */
static char *read_bundle(bool live)
{
    static const char *const all[2][3] = {
        {"viewer.html", MBSR_VIEWER_FOLDER "/viewer.html", MBSR_VIEWER_INSTALLED "/viewer.html"},
        {"live.html", MBSR_VIEWER_FOLDER "/live.html", MBSR_VIEWER_INSTALLED "/live.html"}};
    const char *const *places = all[live];
    const char *given = getenv(live ? "MBSRANK_LIVE" : "MBSRANK_VIEWER");
    char program[1024], path[2048];
    size_t size;
    if (given) return read_file(given, &size);
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    program[length > 0 ? length : 0] = '\0';
    char *slash = strrchr(program, '/');
    for (int k = 0; slash && k < 2; ++k) {
        slash[1] = '\0';
        snprintf(path, sizeof path, "%s%s", program, places[k]);
        char *text = read_file(path, &size);
        if (text) return text;
    }
    return read_file(places[2], &size);
}

/* A file by its path; where it cannot be read the page is without. */
static bool put_beside(FILE *to, const program_options *o, const char *path)
{
    size_t size;
    char *bytes = read_beside(o, path, &size);
    if (!bytes) return true;
    fputs(",\n", to);
    put_json(to, path);
    fputs(": ", to);
    const bool good = put_bytes(to, bytes, size);
    free(bytes);
    return good;
}

static void put_values(FILE *to, const char *name, int count, const char *const *key,
                       const double *value)
{
    fprintf(to, ", \"%s\": {", name);
    for (int k = 0; k < count; ++k) {
        if (k > 0) fputs(", ", to);
        put_json(to, key[k]);
        fprintf(to, ": %.17g", value[k]);
    }
    fputs("}", to);
}

/* What a page that runs the model needs of it: options as `read` of the package for JavaScript has
 * them, and all files. */
static int write_source(FILE *to, const page *p)
{
    const program_options *o = p->options;
    const program_model *m = p->model;
    fputs("{\"name\": ", to);
    put_json(to, o->path);
    fprintf(to,
            ", \"options\": {\"floating\": %s, \"limits\": %s, \"friction\": %s, \"contacts\": %s",
            o->floating ? "true" : "false", o->limits ? "true" : "false",
            o->friction ? "true" : "false", o->contacts ? "true" : "false");
    if (o->start) fputs(", \"start\": ", to), put_json(to, o->start);
    fputs(", \"packages\": {", to);
    for (int k = 0; k < o->packages; ++k) {
        if (k > 0) fputs(", ", to);
        put_json(to, o->package[k].name), fputs(": ", to), put_json(to, o->package[k].folder);
    }
    fputs("}, \"arguments\": {", to);
    for (int k = 0; k < o->arguments; ++k) {
        if (k > 0) fputs(", ", to);
        put_json(to, o->argument[k].name), fputs(": ", to), put_json(to, o->argument[k].value);
    }
    fputs("}", to);
    put_values(to, "set", o->sets, o->set, o->value);
    fputs("},\n\"files\": {", to);
    put_json(to, o->path);
    fputs(": ", to);
    bool good = put_bytes(to, m->text, m->size);
    for (int k = 0; k < m->others && good; ++k) good = put_beside(to, o, m->other[k]);
    for (int k = 0; k < m->file->shapes && good; ++k) {
        const char *mesh = new_mesh(m, k);
        if (mesh) good = put_beside(to, o, mesh);
    }
    fputs("}}\n", to);
    return good ? DONE : complain(FAILED, "no memory");
}

static int write_page(const view_options *o, const page *p)
{
    static const char mark[] = "<!--data-->";
    char *bundle = read_bundle(o->live), *at = bundle ? strstr(bundle, mark) : NULL;
    int code = DONE;
    if (!at) {
        free(bundle);
        return o->live
                   ? complain(FAILED, "this installation has no page that runs models: it was "
                                      "built without the CMake option MBSR_WEB; MBSRANK_LIVE "
                                      "may name one")
                   : complain(FAILED, "this installation has no viewer: it was built without npm "
                                      "(CMake option MBSR_VIEWER); MBSRANK_VIEWER may name one");
    }
    FILE *to = strcmp(o->file, "-") == 0 ? stdout : fopen(o->file, "w");
    if (to) {
        *at = '\0';
        fputs(bundle, to);
        fputs("<script type=\"application/json\" id=\"data\">", to);
        code = (o->live ? write_source : page_write)(to, p);
        fputs("</script>", to);
        fputs(at + strlen(mark), to);
    }
    const bool bad = !to || fflush(to) != 0 || ferror(to);
    const int reason = errno;
    if (to && to != stdout) fclose(to);
    free(bundle);
    errno = reason;
    if (bad) return complain_of_file(FAILED, o->file, "written");
    if (o->file == o->own) fprintf(stderr, "the page is %s\n", o->own);
    return code;
}

int run_view(int argc, char **argv)
{
    view_options o = {.common = {.limits = true, .friction = true, .contacts = true}, .own = ""};
    program_model m = {.text = NULL};
    table run = {.text = NULL};
    inputs in = {.actuator = NULL};
    motion shown = {.samples = 0};
    touching contacts = {.contacts = NULL};
    const double *q, *u;
    int code = read_view_options(argc, argv, &o);
    if (code) return code;
    code = open_model(&o.common, false, &m);
    if (!code) code = start_state(&o.common, &m, &q, &u);
    if (!code && o.run) code = read_run(&o, &m, &run);
    if (!code && o.inputs) code = inputs_read(&m, o.inputs, &in);
    if (!code) code = touching_put(&m, q, o.common.contacts, true, &contacts);
    double *rates = code ? NULL : calloc((size_t)mbsr_model_nu(m.model) + 1, sizeof *rates);
    if (!code && !rates) code = complain(FAILED, "no memory");
    if (!code && u) memcpy(rates, u, (size_t)mbsr_model_nu(m.model) * sizeof *u);
    if (!code) code = motion_make(&m, &contacts, o.run, o.run ? &run : NULL, &in, q, rates, &shown);
    if (!code) code = write_page(&o, &(page){&o.common, &m, &shown, o.run ? &run : NULL, q, rates});
    free(rates);
    motion_free(&shown);
    inputs_free(&in);
    table_free(&run);
    close_model(&m);
    mbsr_model_destroy(contacts.model);
    touching_free(&contacts);
    return code;
}

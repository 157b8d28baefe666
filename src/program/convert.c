/* mbsrank convert: a model from a file as MJCF.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _XOPEN_SOURCE 700
#include "program/program.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

static int write_file(const char *path, const mbsr_written *w)
{
    FILE *to = strcmp(path, "-") == 0 ? stdout : fopen(path, "w");
    if (!to) return complain_of_file(FAILED, path, "written");
    bool good = fwrite(w->text, 1, w->size, to) == w->size;
    good = fflush(to) == 0 && good;
    if (to != stdout) good = fclose(to) == 0 && good;
    return good ? DONE : complain_of_file(FAILED, path, "written");
}

/* Whether the mesh is there. */
static int has_mesh(void *user, const char *name)
{
    return has_beside(user, name);
}

/* The folder of the model, where the text goes to another one; else NULL. */
static const char *folder_of_meshes(const char *from, const char *to, char folder[PATH_MAX])
{
    const char *slash[2] = {strrchr(from, '/'), strrchr(to, '/')};
    const size_t length[2] = {slash[0] ? (size_t)(slash[0] - from) : 0,
                              slash[1] ? (size_t)(slash[1] - to) : 0};
    char own[2048];
    if (length[0] == length[1] && strncmp(from, to, length[0]) == 0) return NULL;
    snprintf(own, sizeof own, "%.*s", (int)(slash[0] ? length[0] + 1 : 1), slash[0] ? from : ".");
    return realpath(own, folder);
}

static int convert_model(const program_options *o, const program_model *m, const char *path)
{
    mbsr_written *written;
    mbsr_error error;
    char folder[PATH_MAX];
    mbsr_write_opt opt = mbsr_default_write_opt();
    opt.strict = o->strict;
    opt.has_mesh = has_mesh;
    opt.user = (void *)o;
    opt.mesh_folder = folder_of_meshes(o->path, path, folder);
    if (mbsr_file_write_mjcf(m->model, m->file, &opt, &written, &error))
        return complain(FAILED, "%s", error.text);
    for (int k = 0; k < written->findings; ++k)
        say(stderr, "%s: %s: %s\n", path, written->finding[k].element, written->finding[k].text);
    const int code = write_file(path, written);
    mbsr_written_destroy(written);
    return code;
}

int run_convert(int argc, char **argv)
{
    program_options o = {.path = NULL};
    program_model m = {.text = NULL};
    const char *to = NULL;
    int code = DONE;
    for (int at = 0; at < argc && !code; ++at) {
        const bool second = o.path && (argv[at][0] != '-' || !argv[at][1]);
        if (second && to)
            code = complain(USAGE, "convert: two files: '%s' is a third one", argv[at]);
        else if (second)
            to = argv[at];
        else if (!common_option(argc, argv, &at, &o, &code))
            code = complain(USAGE, "convert: there is no option %s", argv[at]);
        if (at < 0) return USAGE;
    }
    if (!code && (o.json || o.start))
        code = complain(USAGE, "convert: there is no option %s", o.json ? "--json" : "--start");
    if (!code && o.path && !to) code = complain(USAGE, "convert: where to is missing");
    if (code) return code;
    code = open_model(&o, false, &m);
    if (!code) code = convert_model(&o, &m, to);
    close_model(&m);
    return code;
}

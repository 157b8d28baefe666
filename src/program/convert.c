/* mbsrank convert: a model from a file as MJCF.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _XOPEN_SOURCE 700
#include "program/program.h"

#include <errno.h>
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

/* Whether the text goes to another folder than the model's. */
static bool goes_elsewhere(const char *from, const char *to)
{
    const char *slash[2] = {strrchr(from, '/'), strrchr(to, '/')};
    const size_t length[2] = {slash[0] ? (size_t)(slash[0] - from) : 0,
                              slash[1] ? (size_t)(slash[1] - to) : 0};
    return length[0] != length[1] || strncmp(from, to, length[0]) != 0;
}

/* The folder of the model as it is known everywhere; NULL: errno says why. */
static const char *folder_of_meshes(const char *from, char folder[PATH_MAX])
{
    const char *slash = strrchr(from, '/');
    char own[PATH_MAX];
    const int length =
        snprintf(own, sizeof own, "%.*s", slash ? (int)(slash + 1 - from) : 1, slash ? from : ".");
    if (length >= 0 && length < (int)sizeof own) return realpath(own, folder);
    errno = ENAMETOOLONG;
    return NULL;
}

static int convert_model(const program_options *o, const program_model *m, const char *path)
{
    mbsr_written *written;
    mbsr_error error = {.text = ""};
    char folder[PATH_MAX];
    mbsr_write_opt opt = mbsr_default_write_opt();
    opt.strict = o->strict;
    opt.has_mesh = has_mesh;
    opt.user = (void *)o;
    if (goes_elsewhere(o->path, path)) {
        opt.mesh_folder = folder_of_meshes(o->path, folder);
        if (!opt.mesh_folder) return complain_of_file(FAILED, o->path, "found from elsewhere");
    }
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

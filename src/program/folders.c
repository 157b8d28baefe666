/* Which files a model may name: see folders.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _XOPEN_SOURCE 700
#include "program/folders.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Whether an absolute path is in a folder, which need not be there. */
static bool is_in(const char *path, const char *folder)
{
    char *real = realpath(folder, NULL);
    const size_t length = real ? strlen(real) : 0;
    const bool in = length > 0 && strncmp(path, real, length) == 0 &&
                    (path[length] == '/' || real[length - 1] == '/');
    free(real);
    return in;
}

/* Of the model, with "meshes" beside it, those of packages and those named. */
static bool is_allowed(const program_options *o, const char *path)
{
    char own[2048], beside[2100];
    const char *slash = strrchr(o->path, '/');
    snprintf(own, sizeof own, "%.*s", slash ? (int)(slash + 1 - o->path) : 2,
             slash ? o->path : "./");
    snprintf(beside, sizeof beside, "%s../meshes", own);
    bool in = o->anywhere || is_in(path, own) || is_in(path, beside);
    for (int k = 0; k < o->packages && !in; ++k) in = is_in(path, o->package[k].folder);
    for (int k = 0; k < o->folders && !in; ++k) in = is_in(path, o->folder[k]);
    return in;
}

bool may_read(const program_options *o, const char *path)
{
    struct stat what;
    char *real = realpath(path, NULL);
    if (!real) return false;
    const bool good = stat(real, &what) == 0, in = is_allowed(o, real);
    free(real);
    if (!good) return false;
    errno = S_ISDIR(what.st_mode) ? EISDIR : !S_ISREG(what.st_mode) ? ENODEV : EPERM;
    return S_ISREG(what.st_mode) && in;
}

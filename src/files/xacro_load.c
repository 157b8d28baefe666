/* Other files of an expansion of xacro: see xacro_load.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro_load.h"

#include "files/xacro_yaml.h"

#include <string.h>

typedef struct loaded {
    const char *path;
    const mbsri_element *root; /* of XML; else the value of YAML */
    mbsri_value value;
} loaded;

/* ---- where files may be ---- */

/* A path without "." and without ".." but at its beginning; "" is the folder where the program
 * runs. */
static char *tidy(mbsri_xacro *x, const char *path)
{
    const bool absolute = *path == '/';
    char *whole = mbsri_xacro_take(x, strlen(path) + 2), *at = whole;
    if (!whole) return NULL;
    if (absolute) *at++ = '/';
    char *first = at; /* behind what ".." cannot take back */
    while (*path) {
        const size_t length = strcspn(path, "/");
        const bool up = length == 2 && path[0] == '.' && path[1] == '.';
        if (up && at > first) {
            for (--at; at > first && at[-1] != '/';) --at;
        } else if (length > 0 && !(length == 1 && *path == '.') && !(up && absolute)) {
            memcpy(at, path, length);
            at += length;
            *at++ = '/';
            if (up) first = at;
        }
        path += length + (path[length] == '/');
    }
    if (at > whole + absolute) --at;
    *at = '\0';
    return whole;
}

static bool goes_up(const char *path)
{
    return path[0] == '.' && path[1] == '.' && (path[2] == '/' || path[2] == '\0');
}

/* Both tidy. */
static bool is_within(const char *path, const char *folder)
{
    const size_t length = strlen(folder);
    if (length == 0) return *path != '/' && !goes_up(path);
    if (strncmp(path, folder, length) != 0) return false;
    if (folder[length - 1] == '/') return true;
    return path[length] == '/' && !goes_up(path + length + 1);
}

static bool may_load(mbsri_xacro *x, const char *path)
{
    const mbsr_file_opt *opt = x->s->opt;
    const char *home = tidy(x, x->home);
    bool allowed = opt->xacro.outside || (home && is_within(path, home));
    for (int k = 0; home && !allowed && k < opt->packages; ++k) {
        const char *folder = tidy(x, opt->package[k].folder);
        if (!folder) return false;
        allowed = is_within(path, folder);
    }
    return allowed ||
           mbsri_xacro_refuse(x, "%.60s is neither in the model's folder nor in a package", path);
}

/* ---- loading ---- */

/* Where a file is, tidy; NULL: refused. */
static const char *locate(mbsri_xacro *x, const char *path)
{
    const char *whole = mbsri_xacro_beside(x, path), *clean = whole ? tidy(x, whole) : NULL;
    return clean && may_load(x, clean) ? clean : NULL;
}

/* The file as it was read before; NULL: it was not. */
static const loaded *recall(const mbsri_xacro *x, const char *path, bool xml)
{
    const loaded *file = x->files.items;
    for (int k = 0; k < x->files.count; ++k) {
        if (strcmp(file[k].path, path) == 0 && (file[k].root != NULL) == xml) return file + k;
    }
    return NULL;
}

static bool keep_file(mbsri_xacro *x, const loaded *file)
{
    loaded *place = mbsri_list_add(x->s->arena, &x->files, sizeof *place);
    if (place) *place = *file;
    return place != NULL;
}

/* The text of a file; *text stays NULL where it is missing and may be. False: refused. */
static bool load_text(mbsri_xacro *x, const char *path, bool optional, const char **text,
                      size_t *size)
{
    const mbsr_file_opt *opt = x->s->opt;
    *text = NULL;
    if (x->files.count == MBSRI_XACRO_FILES)
        return mbsri_xacro_refuse(x, "there are more than %d other files", MBSRI_XACRO_FILES);
    const int reason = opt->load ? opt->load(opt->user, path, text, size) : 1;
    if (!reason) return mbsri_xacro_spend(x, *size);
    *text = NULL;
    return optional || mbsri_xacro_refuse(x, "there is no file %.60s%s%s", path,
                                          reason > 1 ? ": " : "", mbsri_file_why(reason));
}

bool mbsri_xacro_include(mbsri_xacro *x, const char *path, bool optional,
                         const mbsri_element **root)
{
    const char *text, *clean = locate(x, path);
    const loaded *known = clean ? recall(x, clean, true) : NULL;
    size_t size;
    *root = known ? known->root : NULL;
    if (!clean || known) return clean != NULL;
    if (!load_text(x, clean, optional, &text, &size) || !text) return optional && !x->s->message[0];
    *root = mbsri_xml_read(x->s->arena, text, size, clean, x->s->message);
    return *root && keep_file(x, &(loaded){.path = clean, .root = *root});
}

bool mbsri_xacro_load_yaml(mbsri_xacro *x, const char *path, mbsri_value *value)
{
    const char *text, *clean = locate(x, path);
    const loaded *known = clean ? recall(x, clean, false) : NULL;
    size_t size;
    if (known) *value = known->value;
    if (!clean || known) return clean != NULL;
    return load_text(x, clean, false, &text, &size) &&
           mbsri_yaml_read(x, text, size, clean, value) &&
           keep_file(x, &(loaded){.path = clean, .value = *value});
}

/* Files that a file of MJCF names: see mjcf_include.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mjcf_include.h"

#include "files/xml_make.h"

#include <string.h>

enum { MOST_INCLUDES = 200 };

typedef struct includes {
    mbsri_scene *s;
    const char *folder; /* of the file, with its slash */
    const char *path[MOST_INCLUDES];
    int count;
} includes;

mbsri_element *mbsri_mjcf_load(mbsri_scene *s, const mbsri_element *e, const char *path)
{
    const char *text;
    size_t size;
    const int reason = s->opt->load ? s->opt->load(s->opt->user, path, &text, &size) : 1;
    if (!reason) return mbsri_xml_read(s->arena, text, size, path, s->message);
    mbsri_file_refuse(s, e, "there is no file %.60s%s%s", mbsri_attribute(e, "file"),
                      reason > 1 ? ": " : "", mbsri_file_why(reason));
    return NULL;
}

static mbsri_element *load_included(includes *i, const mbsri_element *e)
{
    mbsri_scene *s = i->s;
    const char *file = mbsri_attribute(e, "file");
    if (!file) {
        mbsri_file_refuse(s, e, "it has no file");
        return NULL;
    }
    const char *path = mbsri_arena_join(s->arena, file[0] == '/' ? "" : i->folder, file, "");
    bool good = path != NULL;
    for (int k = 0; k < i->count && good; ++k)
        good = strcmp(i->path[k], path) != 0 ||
               mbsri_file_refuse(s, e, "the file %.60s is included twice", file);
    if (good && i->count == MOST_INCLUDES)
        good = mbsri_file_refuse(s, e, "there are more than %d includes", MOST_INCLUDES);
    if (!good) return NULL;
    i->path[i->count++] = path;
    return mbsri_mjcf_load(s, e, path);
}

static bool expand_includes(includes *i, mbsri_element *e, int depth)
{
    if (depth > MBSRI_XML_DEPTH)
        return mbsri_file_refuse(i->s, e, "elements stand in each other too deeply");
    for (mbsri_element *c = e->child, *before = NULL; c; before = c, c = c->next) {
        while (c && mbsri_is(c, "include")) {
            mbsri_element *root = load_included(i, c);
            if (!root) return false;
            mbsri_element *first = root->child ? root->child : c->next;
            if (root->last) root->last->next = c->next;
            for (mbsri_element *in = root->child; in && in != c->next; in = in->next)
                in->parent = e;
            if (before)
                before->next = first;
            else
                e->child = first;
            if (e->last == c) e->last = root->last ? root->last : before;
            c = first;
        }
        if (!c) break;
        if (!expand_includes(i, c, depth + 1)) return false;
    }
    return true;
}

bool mbsri_mjcf_include(mbsri_scene *s, mbsri_element *root, const char *folder)
{
    includes i = {.s = s, .folder = folder};
    return expand_includes(&i, root, 1);
}

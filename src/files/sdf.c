/* SDF: worlds and models with what they include, from version 1.2 on.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * What has a pose becomes a node, by its name with those of its models before it; poses, joints and
 * bodies come after all nodes are known. Included files are models of SDF in the folder of the file
 * or of a package; a folder stands for the newest file of its model.config. */
#include "files/sdf_parts.h"
#include "files/urdf_parts.h"

#include <stdio.h>
#include <string.h>

enum { MOST_DEPTH = 20, MOST_FILES = 1000, MOST_NODES = 1 << 20 };

/* ---- texts ---- */

/* A text without the white space around it; NULL: there is none, or no memory. */
static const char *trimmed(mbsri_scene *s, const char *text)
{
    if (!text) return NULL;
    text += strspn(text, " \t\r\n");
    size_t length = strlen(text);
    while (length > 0 && strchr(" \t\r\n", text[length - 1])) --length;
    return mbsri_arena_text(s->arena, text, length);
}

/* ---- nodes ---- */

/* The second number of a version 1.x; -1: it is none. */
static int minor_of(const char *version)
{
    int minor;
    char rest;
    return version && sscanf(version, "1.%d%c", &minor, &rest) == 1 ? minor : -1;
}

/* Whether the version of a file is read; it becomes that of the nodes to come. */
static bool has_version(mbsri_sdf *f, const mbsri_element *root)
{
    const char *version = mbsri_attribute(root, "version");
    f->version = minor_of(version);
    if (f->version >= 2) return true;
    return mbsri_file_refuse(f->s, root, "SDF of version '%.20s' is not read, but from 1.2 on",
                             version ? version : "");
}

/* A node of that name; *number, which may be NULL: where it is. */
static bool add_node(mbsri_sdf *f, const mbsri_element *e, mbsri_sdf_kind kind, const char *name,
                     int model, int *number)
{
    mbsri_scene *s = f->s;
    if (!name || !name[0]) return mbsri_file_refuse(s, e, "it has no name");
    if (f->nodes.count >= MOST_NODES) return mbsri_file_refuse(s, e, "there are too many elements");
    const char *full = mbsri_sdf_full_name(f, model, name);
    if (!full) return false;
    if (mbsri_names_find(&f->names, full) >= 0)
        return mbsri_file_refuse(s, e, "there are two of the name '%.60s'", full);
    const int at = f->nodes.count;
    mbsri_sdf_node *node = mbsri_list_add(s->arena, &f->nodes, sizeof *node);
    if (!node) return false;
    *node = (mbsri_sdf_node){.kind = kind,
                             .name = full,
                             .element = e,
                             .model = model,
                             .version = f->version,
                             .pose = mbsri_child(e, "pose"),
                             .fixed = model >= 0 && mbsri_sdf_nodes(f)[model].fixed,
                             .canonical = -1,
                             .end = {-1, -1},
                             .body = -1,
                             .carrier = -1};
    if (number) *number = at;
    return mbsri_names_add(s->arena, &f->names, full, at);
}

static bool add_model(mbsri_sdf *f, const mbsri_element *e, const mbsri_element *include,
                      int model);

/* ---- other files ---- */

/* The root of the file at a path from the folder of e; NULL: there is none, or it is refused. */
static mbsri_element *open_file(mbsri_sdf *f, const mbsri_element *e, const char *path, int *reason)
{
    mbsri_scene *s = f->s;
    const char *text;
    size_t size;
    const char *folder = path[0] == '/' ? "" : mbsri_arena_folder(s->arena, e->file),
               *full = folder ? mbsri_arena_join(s->arena, folder, path, "") : NULL;
    *reason = full && s->opt->load ? s->opt->load(s->opt->user, full, &text, &size) : 1;
    return *reason ? NULL : mbsri_xml_read(s->arena, text, size, full, s->message);
}

/* The file in a folder, the newest of its model.config; NULL: there is none. */
static mbsri_element *open_folder(mbsri_sdf *f, const mbsri_element *e, const char *path,
                                  int *reason)
{
    mbsri_arena *arena = f->s->arena;
    const char *config = mbsri_arena_join(arena, path, "/model.config", ""), *file = "model.sdf";
    const mbsri_element *root = config ? open_file(f, e, config, reason) : NULL;
    int newest = -1;
    for (const mbsri_element *c = mbsri_child(root, "sdf"); c; c = mbsri_next(c)) {
        const int minor = minor_of(mbsri_attribute(c, "version"));
        if (!c->text || minor < newest) continue;
        file = trimmed(f->s, c->text);
        newest = minor;
    }
    if (f->s->message[0] || !file) return NULL;
    const char *own = mbsri_arena_join(arena, path, "/", file);
    return own ? open_file(f, e, own, reason) : NULL;
}

/* model://NAME of no known package is NAME beside the file, or beside its folder. */
static mbsri_element *open_uri(mbsri_sdf *f, const mbsri_element *e, const char *uri)
{
    static const char scheme[] = "model://";
    const char *path = mbsri_package_path(f->s, uri), *const before[2] = {"", "../"};
    const bool unknown = path && strncmp(path, scheme, sizeof scheme - 1) == 0;
    mbsri_element *root = NULL;
    int reason = 1;
    for (int k = 0; k < (unknown ? 2 : 1) && path && !root && !f->s->message[0]; ++k) {
        const char *own =
            unknown ? mbsri_arena_join(f->s->arena, before[k], path + sizeof scheme - 1, "") : path;
        const size_t length = own ? strlen(own) : 0;
        const bool file = length > 4 && (strcmp(own + length - 4, ".sdf") == 0 ||
                                         strcmp(own + length - 4, ".xml") == 0);
        if (own) root = (file ? open_file : open_folder)(f, e, own, &reason);
    }
    if (!root && !f->s->message[0])
        mbsri_file_refuse(f->s, e, "there is no model %.80s%s%s", uri, reason > 1 ? ": " : "",
                          mbsri_file_why(reason));
    return root;
}

static bool add_include(mbsri_sdf *f, const mbsri_element *e, int model)
{
    mbsri_scene *s = f->s;
    const char *uri = trimmed(s, mbsri_text_of(e, "uri")), *merge = mbsri_attribute(e, "merge");
    if (!uri) return mbsri_file_refuse(s, e, "it has no uri");
    if (merge && strcmp(merge, "true") == 0) return mbsri_file_refuse(s, e, "merge is not read");
    if (f->depth >= MOST_DEPTH || f->files++ >= MOST_FILES)
        return mbsri_file_refuse(s, e, "models include each other too deeply, or too many");
    const mbsri_element *root = open_uri(f, e, uri), *of = mbsri_child(root, "model");
    if (!root) return false;
    if (!mbsri_sdf_is_root(root) || !of)
        return mbsri_file_refuse(s, e, "%.80s is no model of SDF", uri);
    const int version = f->version;
    if (!has_version(f, root)) return false;
    mbsri_sdf_find_words(s, root);
    ++f->depth;
    const bool good = add_model(f, of, e, model);
    --f->depth;
    f->version = version;
    return good;
}

/* ---- models ---- */

/* The name of a joint, with more behind it where another has that name. */
static const char *free_name(mbsri_sdf *f, const mbsri_element *e, int model)
{
    const char *name = mbsri_attribute(e, "name"), *own = name;
    while (own && own[0]) {
        const char *full = mbsri_sdf_full_name(f, model, own);
        if (!full || mbsri_names_find(&f->names, full) < 0) break;
        own = mbsri_arena_join(f->s->arena, own, "_joint", "");
    }
    if (own != name) mbsri_file_find(f->s, e, "its name is taken: \"_joint\" is put behind it");
    return own;
}

/* What stands in a world or model; before version 1.7 joints behind all others, by whose names
 * theirs may change. */
static bool add_all(mbsri_sdf *f, const mbsri_element *e, int model)
{
    const bool old = f->version < 7;
    for (const mbsri_element *c = e->child; c; c = c->next) {
        const char *name = mbsri_attribute(c, "name");
        int number;
        if (mbsri_is(c, "link")) {
            if (!add_node(f, c, MBSRI_SDF_LINK, name, model, &number)) return false;
            for (int m = model; m >= 0; m = mbsri_sdf_nodes(f)[m].model)
                if (mbsri_sdf_nodes(f)[m].canonical < 0) mbsri_sdf_nodes(f)[m].canonical = number;
        }
        if (mbsri_is(c, "frame") && !add_node(f, c, MBSRI_SDF_FRAME, name, model, NULL))
            return false;
        if (!old && mbsri_is(c, "joint") && !add_node(f, c, MBSRI_SDF_JOINT, name, model, NULL))
            return false;
        if (mbsri_is(c, "model") && !add_model(f, c, NULL, model)) return false;
        if (mbsri_is(c, "include") && !add_include(f, c, model)) return false;
    }
    for (const mbsri_element *c = old ? mbsri_child(e, "joint") : NULL; c; c = mbsri_next(c))
        if (!add_node(f, c, MBSRI_SDF_JOINT, free_name(f, c, model), model, NULL)) return false;
    return true;
}

/* include: what says otherwise than the model, NULL: nothing. */
static bool add_model(mbsri_sdf *f, const mbsri_element *e, const mbsri_element *include, int model)
{
    const char *name = trimmed(f->s, mbsri_text_of(include, "name")),
               *canonical = mbsri_attribute(e, "canonical_link"),
               *placement = trimmed(f->s, mbsri_text_of(include, "placement_frame"));
    int number;
    if (!name) name = f->alone && model < 0 ? MBSRI_SDF_ALONE : mbsri_attribute(e, "name");
    if (!add_node(f, e, MBSRI_SDF_MODEL, name, model, &number)) return false;
    mbsri_sdf_node *node = mbsri_sdf_nodes(f) + number;
    if (include && mbsri_child(include, "pose")) node->pose = mbsri_child(include, "pose");
    node->placement = placement ? placement : mbsri_attribute(e, "placement_frame");
    node->fixed =
        node->fixed || mbsri_sdf_switch(include, "static", mbsri_sdf_switch(e, "static", false));
    if (!add_all(f, e, number)) return false;
    if (!canonical || !canonical[0]) return true;
    const int link = mbsri_sdf_find(f, number, canonical);
    if (link < 0 || mbsri_sdf_nodes(f)[link].kind != MBSRI_SDF_LINK)
        return mbsri_file_refuse(f->s, e, "its canonical link '%.60s' is no link", canonical);
    mbsri_sdf_nodes(f)[number].canonical = link;
    return true;
}

/* The nodes of a file, with those that it includes. Gravity is of the physics before version 1.6.
 */
static bool sdf_collect(mbsri_sdf *f, const mbsri_element *root)
{
    const mbsri_element *world = mbsri_child(root, "world"), *only = mbsri_child(root, "model");
    if (!has_version(f, root)) return false;
    mbsri_sdf_find_words(f->s, root);
    if (world && mbsri_next(world))
        return mbsri_file_refuse(f->s, mbsri_next(world), "there is a second world");
    if (world) {
        const mbsri_element *of = f->version < 6 ? mbsri_child(world, "physics") : NULL;
        return mbsri_sdf_numbers(f->s, world, "gravity", 3, f->s->gravity) &&
               mbsri_sdf_numbers(f->s, of, "gravity", 3, f->s->gravity) && add_all(f, world, -1);
    }
    if (!only) return mbsri_file_refuse(f->s, root, "there is neither a world nor a model");
    if (mbsri_next(only))
        return mbsri_file_refuse(f->s, mbsri_next(only), "there is a second model without a world");
    f->alone = true;
    return add_model(f, only, NULL, -1);
}

bool mbsri_sdf_is_root(const mbsri_element *e)
{
    return mbsri_is(e, "sdf") || (mbsri_is(e, "gazebo") && mbsri_attribute(e, "version"));
}

bool mbsri_sdf_read(mbsri_scene *s, const mbsri_element *root)
{
    mbsri_sdf f = {.s = s};
    const mbsri_element *world = mbsri_child(root, "world"),
                        *named = world ? world : mbsri_child(root, "model");
    s->name = named ? mbsri_attribute(named, "name") : NULL;
    return sdf_collect(&f, root) && mbsri_sdf_tree(&f) && mbsri_sdf_relations(&f);
}

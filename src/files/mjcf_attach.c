/* Models that a file of MJCF attaches: their elements stand in it, under other names, before
 * anything else is read.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * <attach model body prefix> is a frame with the body of that name from the file of <asset><model
 * name file>; with `frame` instead of `body` it has what stands in that frame, and with neither all
 * of the world. Names and references get the prefix; so do classes, whose main one is PREFIXmain.
 * With the world, and with a body as well, come assets, and of the other sections those elements
 * that name nothing outside of what is attached. Options of the model do not count. */
#include "files/mjcf_copies.h"
#include "files/mjcf_include.h"
#include "files/xml_make.h"

#include <string.h>

enum { MOST_DEPTH = 20, MOST_MODELS = 1000 };

/* A <model>. */
typedef struct asset {
    const char *name;
    mbsri_element *root;
} asset;

/* How copies are named. */
typedef struct naming {
    const char *prefix;
    bool own; /* of the file itself: classes and assets are those that there are */
} naming;

/* What is done for one tree. */
typedef struct host {
    mbsri_mjcf *m;
    mbsri_element *root;
    mbsri_list assets;
    mbsri_element sections; /* of what is attached, to stand before those of the root */
} host;

/* ---- names ---- */

static bool is_one_of(const char *word, const char *const *words)
{
    while (*words && strcmp(*words, word) != 0) ++words;
    return *words != NULL;
}

static const char *with_prefix(mbsri_copies *c, const mbsri_element *e, const char *attribute,
                               const char *value)
{
    static const char *const names[] = {"name", "target", "objname", "refname", NULL},
                             *const shared[] = {"class",   "childclass", "material", "mesh",
                                                "texture", "hfield",     NULL};
    const naming *by = c->user;
    (void)e;
    const bool named = is_one_of(attribute, names) || mbsri_copies_kind(attribute) ||
                       (!by->own && is_one_of(attribute, shared));
    if (!named || strcmp(value, "world") == 0) return value;
    return mbsri_arena_join(c->m->s->arena, by->prefix, value, "");
}

/* ---- sections ---- */

/* Whether all that an element names was entered. */
static bool is_complete(mbsri_copies *c, const mbsri_element *e)
{
    for (const char **a = e->attribute; *a; a += 2) {
        const char *kind = mbsri_copies_kind(a[0]);
        if (kind && strcmp(a[1], "world") != 0 && !mbsri_copies_know(c, a[0], a[1])) return false;
    }
    const char *type = mbsri_attribute(e, "objtype"), *name = mbsri_attribute(e, "objname");
    if (type && name && strcmp(type, "xbody") == 0) type = "body";
    if (type && name && mbsri_copies_kind(type) && !mbsri_copies_know(c, type, name)) return false;
    for (const mbsri_element *child = e->child; child; child = child->next)
        if (!is_complete(c, child)) return false;
    return true;
}

/* A copy of an element of a section, with a class in any case, and with the name that its file
 * gives it. */
static bool copy_into(mbsri_copies *c, const mbsri_element *e, const char *main, mbsri_element *to)
{
    mbsri_arena *arena = c->m->s->arena;
    const char *file = mbsri_attribute(e, "file"), *name = mbsri_attribute(e, "name");
    mbsri_element *again = mbsri_copy_element(c, e);
    if (!again) return false;
    if (!mbsri_attribute(e, "class") && !mbsri_element_set(arena, again, "class", main))
        return false;
    if (file && !name) {
        name = mbsri_mjcf_stem(arena, file);
        if (name) name = mbsri_arena_join(arena, ((const naming *)c->user)->prefix, name, "");
        if (!name || !mbsri_element_set(arena, again, "name", name)) return false;
    }
    mbsri_append(to, again);
    return true;
}

static bool copy_section(mbsri_copies *c, const mbsri_element *section, const char *main,
                         mbsri_element *to)
{
    const bool tendon = mbsri_is(section, "tendon"), assets = mbsri_is(section, "asset");
    mbsri_element *copy = mbsri_element_like(c->m->s->arena, section, section->name);
    if (!copy) return false;
    for (const mbsri_element *e = section->child; e; e = e->next) {
        if ((assets && mbsri_is(e, "model")) || (!assets && !is_complete(c, e))) continue;
        if (!mbsri_copies_enter(c, tendon ? "tendon" : section->name, e) ||
            !copy_into(c, e, main, copy))
            return false;
    }
    mbsri_append(to, copy);
    return true;
}

static bool copy_default(mbsri_copies *c, const mbsri_element *section, const char *main,
                         mbsri_element *to)
{
    mbsri_element *copy = mbsri_copy_element(c, section);
    if (!copy || !mbsri_element_set(c->m->s->arena, copy, "class", main)) return false;
    mbsri_append(to, copy);
    return true;
}

/* Tendons stand before what names them. */
static bool copy_sections(mbsri_copies *c, const mbsri_element *root, const char *main,
                          mbsri_element *to)
{
    static const char *const names[] = {"asset",    "tendon",   "contact",
                                        "equality", "actuator", "sensor"};
    const char *plain = with_prefix(c, root, "class", MBSRI_PLAIN_CLASS);
    if (!plain || !mbsri_mjcf_class_of(c->m, plain, NULL) || !mbsri_mjcf_class_of(c->m, main, NULL))
        return false;
    for (const mbsri_element *s = mbsri_child(root, "default"); s; s = mbsri_next(s))
        if (!copy_default(c, s, main, to)) return false;
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
        for (const mbsri_element *s = mbsri_child(root, names[k]); s; s = mbsri_next(s))
            if (!copy_section(c, s, main, to)) return false;
    }
    return true;
}

/* ---- what is attached ---- */

/* The element of that kind and name below e; *class: the childclass that holds there. */
static const mbsri_element *find_below(const mbsri_element *e, const char *kind, const char *name,
                                       const char **class)
{
    const char *outer = *class, *own;
    for (const mbsri_element *c = e->child; c; c = c->next) {
        const char *other = mbsri_attribute(c, "name");
        if (mbsri_is(c, kind) && other && strcmp(other, name) == 0) return c;
        own = mbsri_attribute(c, "childclass");
        *class = own ? own : outer;
        const mbsri_element *found = find_below(c, kind, name, class);
        if (found) return found;
    }
    *class = outer;
    return NULL;
}

static const mbsri_element *find_source(const mbsri_element *root, const char *kind,
                                        const char *name, const char **class)
{
    const mbsri_element *found = NULL;
    for (const mbsri_element *w = mbsri_child(root, "worldbody"); w && !found; w = mbsri_next(w)) {
        *class = mbsri_attribute(w, "childclass");
        found = find_below(w, kind, name, class);
    }
    return found;
}

/* Enters what is attached, and copies it into a frame. */
static bool copy_source(mbsri_copies *c, const mbsri_element *source, bool within,
                        mbsri_element *frame)
{
    if (within && !mbsri_copies_enter_all(c, source)) return false;
    if (!within) { /* alone among its siblings */
        mbsri_element alone = *source, holder = {.child = &alone};
        alone.next = NULL;
        if (!mbsri_copies_enter_all(c, &holder)) return false;
    }
    for (const mbsri_element *e = within ? source->child : source; e; e = within ? e->next : NULL) {
        mbsri_element *again = mbsri_copy_element(c, e);
        if (!again) return false;
        mbsri_append(frame, again);
    }
    return true;
}

static const asset *find_asset(const host *h, const char *name)
{
    const asset *a = h->assets.items;
    for (int k = 0; k < h->assets.count; ++k)
        if (strcmp(a[k].name, name) == 0) return a + k;
    return NULL;
}

/* Where it comes from: the tree, and in it the body or frame; NULL: all of its world. False:
 * refused. */
static bool read_source(const host *h, const mbsri_element *e, const mbsri_element **root,
                        const mbsri_element **source, const char **class)
{
    const char *model = mbsri_attribute(e, "model"), *body = mbsri_attribute(e, "body"),
               *frame = mbsri_attribute(e, "frame"), *name = frame && !body ? frame : body;
    const asset *a = model ? find_asset(h, model) : NULL;
    *class = NULL;
    *source = NULL;
    if (!mbsri_attribute(e, "prefix")) return mbsri_file_refuse(h->m->s, e, "it has no prefix");
    if (model && !a) return mbsri_file_refuse(h->m->s, e, "'%.50s' is no model", model);
    if (!model && !name)
        return mbsri_file_refuse(h->m->s, e, "it has neither model nor body nor frame");
    *root = a ? a->root : h->root;
    const mbsri_element *world = mbsri_child(*root, "worldbody");
    if (world) *class = mbsri_attribute(world, "childclass");
    if (!name) return true;
    *source = find_source(*root, body ? "body" : "frame", name, class);
    return *source ||
           mbsri_file_refuse(h->m->s, e, "there is no %s '%.50s'", body ? "body" : "frame", name);
}

/* The frame in the place of an <attach>; NULL: refused, or no memory. */
static mbsri_element *attach(host *h, const mbsri_element *e)
{
    mbsri_arena *arena = h->m->s->arena;
    const mbsri_element *root = NULL, *source;
    const char *class;
    if (!read_source(h, e, &root, &source, &class)) return NULL;
    naming by = {mbsri_attribute(e, "prefix"), root == h->root};
    mbsri_copies c = {.m = h->m, .rename = with_prefix, .user = &by};
    const char *prefix = by.own ? "" : by.prefix,
               *main = mbsri_arena_join(arena, prefix, "main", ""),
               *holds = class ? mbsri_arena_join(arena, prefix, class, "") : main;
    mbsri_element *frame = mbsri_element_like(arena, e, "frame");
    if (!frame || !main || !holds || !mbsri_element_set(arena, frame, "childclass", holds))
        return NULL;
    bool good = !source || copy_source(&c, source, false, frame);
    for (const mbsri_element *w = mbsri_child(root, "worldbody"); w && !source && good;
         w = mbsri_next(w))
        good = copy_source(&c, w, true, frame);
    return good && (by.own || copy_sections(&c, root, main, &h->sections)) ? frame : NULL;
}

static bool attach_all(host *h, mbsri_element *e)
{
    for (mbsri_element *c = e->child, *before = NULL; c; before = c, c = c->next) {
        mbsri_element all = {.child = NULL};
        if (!mbsri_is(c, "attach")) {
            if (!attach_all(h, c)) return false;
            continue;
        }
        mbsri_element *frame = attach(h, c);
        if (!frame) return false;
        mbsri_append(&all, frame);
        c = mbsri_put_in_place(e, before, c, &all);
    }
    return true;
}

/* ---- models ---- */

/* What of a model does not come with it. */
static void find_rest(mbsri_mjcf *m, const mbsri_element *root)
{
    const mbsri_element *keys = mbsri_child(root, "keyframe"),
                        *option = mbsri_child(root, "option");
    if (keys && keys->child)
        mbsri_file_find(m->s, keys, "keys of a model that is attached are left out");
    if (option) mbsri_file_find(m->s, option, "options of a model that is attached do not count");
}

static void mark(mbsri_element *e, int model)
{
    e->model = model;
    for (mbsri_element *c = e->child; c; c = c->next) mark(c, model);
}

static bool expand_attached(mbsri_mjcf *m, mbsri_element *root, int depth);

static bool add_asset(host *h, const mbsri_element *e, int depth)
{
    mbsri_scene *s = h->m->s;
    const char *file = mbsri_attribute(e, "file"), *name = mbsri_attribute(e, "name");
    int number;
    if (!file) return mbsri_file_refuse(s, e, "it has no file");
    if (depth >= MOST_DEPTH || h->m->compilers.count > MOST_MODELS)
        return mbsri_file_refuse(s, e, "models attach each other too deeply, or too many");
    const bool absolute = file[0] == '/';
    const char *home = mbsri_mjcf_compiler(h->m, e)->home,
               *seen = mbsri_arena_join(s->arena, absolute ? "" : home, file, ""),
               *path =
                   seen ? mbsri_arena_join(s->arena, absolute ? "" : h->m->home, seen, "") : NULL;
    mbsri_element *root = path ? mbsri_mjcf_load(s, e, path) : NULL;
    if (!root) return false;
    const char *folder = mbsri_arena_folder(s->arena, seen);
    if (!mbsri_is(root, "mujoco"))
        return mbsri_file_refuse(s, e, "its file is no <mujoco> of MJCF");
    if (!name) name = mbsri_attribute(root, "model");
    if (!folder || !mbsri_mjcf_add_compiler(h->m, folder, &number)) return false;
    mark(root, number);
    find_rest(h->m, root);
    if (!expand_attached(h->m, root, depth + 1)) return false;
    asset *to = mbsri_list_add(s->arena, &h->assets, sizeof *to);
    if (to) *to = (asset){name ? name : "", root};
    return to != NULL;
}

static bool add_assets(host *h, int depth)
{
    for (const mbsri_element *s = mbsri_child(h->root, "asset"); s; s = mbsri_next(s)) {
        for (const mbsri_element *e = mbsri_child(s, "model"); e; e = mbsri_next(e))
            if (!add_asset(h, e, depth)) return false;
    }
    return true;
}

/* Sections of what is attached come first. */
static void put_sections(host *h)
{
    if (!h->sections.child) return;
    for (mbsri_element *e = h->sections.child; e; e = e->next) e->parent = h->root;
    h->sections.last->next = h->root->child;
    h->root->child = h->sections.child;
}

static bool expand_attached(mbsri_mjcf *m, mbsri_element *root, int depth)
{
    host h = {.m = m, .root = root};
    const char *folder = mbsri_arena_folder(m->s->arena, root->file);
    if (!folder || !mbsri_mjcf_include(m->s, root, folder)) return false;
    mark(root, root->model);
    mbsri_mjcf_find_words(m, root);
    for (const mbsri_element *e = mbsri_child(root, "compiler"); e; e = mbsri_next(e))
        if (!mbsri_mjcf_read_compiler(m, e)) return false;
    if (!mbsri_mjcf_composites(m, root) || !add_assets(&h, depth)) return false;
    for (mbsri_element *e = root->child; e; e = e->next)
        if (mbsri_is(e, "worldbody") && !attach_all(&h, e)) return false;
    put_sections(&h);
    return mbsri_mjcf_replicate(m, root);
}

bool mbsri_mjcf_expand(mbsri_mjcf *m, mbsri_element *root)
{
    return expand_attached(m, root, 0);
}

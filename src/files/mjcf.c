/* MJCF: the file as a whole, with its includes, defaults and options.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Sections may stand several times and in any order; they are read in the order in which they need each
 * other. */
#include "files/colours.h"
#include "files/mjcf_parts.h"
#include "files/numbers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- includes ---- */

enum { MOST_INCLUDES = 200 };

typedef struct includes {
    mbsri_scene *s;
    const char *folder; /* of the file, with its slash */
    const char *path[MOST_INCLUDES];
    int count;
} includes;

static const char *folder_of(mbsri_scene *s, const char *path)
{
    const char *slash = strrchr(path, '/');
    return mbsri_arena_text(s->arena, path, slash ? (size_t)(slash - path) + 1 : 0);
}

static mbsri_element *load(includes *i, const mbsri_element *e)
{
    mbsri_scene *s = i->s;
    const char *file = mbsri_attribute(e, "file"), *text;
    char path[512];
    size_t size;
    if (!file) {
        mbsri_file_refuse(s, e, "it has no file");
        return NULL;
    }
    snprintf(path, sizeof path, "%.250s%.250s", file[0] == '/' ? "" : i->folder, file);
    for (int k = 0; k < i->count; ++k) {
        if (strcmp(i->path[k], path) != 0) continue;
        mbsri_file_refuse(s, e, "the file %.60s is included twice", file);
        return NULL;
    }
    const int reason = i->count < MOST_INCLUDES && s->opt->load
                           ? s->opt->load(s->opt->user, path, &text, &size)
                           : 1;
    if (reason) {
        mbsri_file_refuse(s, e, "there is no file %.60s%s%s", file, reason > 1 ? ": " : "",
                          mbsri_file_why(reason));
        return NULL;
    }
    const char *name = i->path[i->count++] = mbsri_arena_text(s->arena, path, strlen(path));
    return name ? mbsri_xml_read(s->arena, text, size, name, s->message) : NULL;
}

/* In the place of an <include> what is in the file. */
static bool expand(includes *i, mbsri_element *e, int depth)
{
    if (depth > MBSRI_XML_DEPTH)
        return mbsri_file_refuse(i->s, e, "elements stand in each other too deeply");
    for (mbsri_element *c = e->child, *before = NULL; c; before = c, c = c->next) {
        while (c && mbsri_is(c, "include")) {
            mbsri_element *root = load(i, c);
            if (!root) return false;
            mbsri_element *first = root->child ? root->child : c->next;
            if (root->last) root->last->next = c->next;
            for (mbsri_element *in = root->child; in && in != c->next; in = in->next)
                in->parent = e;
            if (before)
                before->next = first;
            else
                e->child = first;
            c = first;
        }
        if (!c) break;
        if (!expand(i, c, depth + 1)) return false;
    }
    return true;
}

/* ---- defaults ---- */

/* parent NULL: of the main class. */
static bool add_class(mbsri_mjcf *m, const mbsri_element *e, const mbsri_class *parent)
{
    const char *name = parent ? mbsri_attribute(e, "class") : NULL;
    if (parent && !name) return mbsri_file_refuse(m->s, e, "it has no class");
    mbsri_class *class = mbsri_mjcf_class(m, name);
    if (!class) {
        class = mbsri_arena_take(m->s->arena, sizeof *class);
        if (!class) return false;
        *class = (mbsri_class){.name = name, .parent = parent, .next = m->classes};
        m->classes = class;
    }
    const mbsri_element **place = mbsri_list_add(m->s->arena, &class->elements, sizeof *place);
    if (!place) return false;
    *place = e;
    for (const mbsri_element *c = mbsri_child(e, "default"); c; c = mbsri_next(c)) {
        if (!add_class(m, c, class)) return false;
    }
    return true;
}

/* ---- options ---- */

/* What the compiler of MuJoCo would change in a model. */
static void find_changes(mbsri_mjcf *m, const mbsri_element *e)
{
    static const char *const names[] = {"boundmass", "boundinertia"};
    for (int k = 0; k < 2; ++k) {
        const char *value = mbsri_attribute(e, names[k]);
        double x;
        if (value && mbsri_read_numbers(value, 1, 1, &x) == 1 && x > 0.0)
            mbsri_file_find(m->s, e, "%s is not applied: masses stay as they are", names[k]);
    }
    const char *balance = mbsri_attribute(e, "balanceinertia");
    if (balance && strcmp(balance, "true") == 0)
        mbsri_file_find(m->s, e, "balanceinertia is not applied: tensors stay as they are");
    const char *align = mbsri_attribute(e, "alignfree");
    if (align && strcmp(align, "true") == 0)
        mbsri_file_find(m->s, e, "alignfree is not applied: free bodies keep their frames");
}

static bool read_compiler(mbsri_mjcf *m, const mbsri_element *e)
{
    const mbsri_node node = {.e = e};
    const char *angle = mbsri_attribute(e, "angle"), *sequence = mbsri_attribute(e, "eulerseq"),
               *shapes = mbsri_attribute(e, "inertiafromgeom"),
               *coordinate = mbsri_attribute(e, "coordinate"),
               *folder = mbsri_attribute(e, "meshdir"), *assets = mbsri_attribute(e, "assetdir");
    if (angle) m->radian = strcmp(angle, "radian") == 0;
    if (folder || assets) m->folder = folder ? folder : assets;
    m->strip = mbsri_mjcf_switch(&node, "strippath", m->strip);
    m->exact = mbsri_mjcf_switch(&node, "exactmeshinertia", m->exact);
    m->fit_around = mbsri_mjcf_switch(&node, "fitaabb", m->fit_around);
    m->autolimits = mbsri_mjcf_switch(&node, "autolimits", m->autolimits);
    if (coordinate && strcmp(coordinate, "global") == 0)
        return mbsri_file_refuse(m->s, e, "global coordinates are not read");
    if (sequence) {
        if (strlen(sequence) != 3 || strspn(sequence, "xyzXYZ") != 3)
            return mbsri_file_refuse(m->s, e, "eulerseq=\"%.20s\" is not three axes", sequence);
        memcpy(m->sequence, sequence, sizeof m->sequence);
    }
    if (shapes)
        m->from_shapes = strcmp(shapes, "auto") == 0                          ? MBSRI_SHAPES_AUTO
                         : mbsri_mjcf_switch(&node, "inertiafromgeom", false) ? MBSRI_SHAPES_ALWAYS
                                                                              : MBSRI_SHAPES_NEVER;
    find_changes(m, e);
    return mbsri_mjcf_number(m, &node, "settotalmass", &m->total) &&
           mbsri_mjcf_numbers(m, &node, "inertiagrouprange", 2, 2, m->groups, NULL);
}

/* What is switched off. */
static void read_flags(mbsri_mjcf *m, const mbsri_element *flag)
{
    static const char *const names[] = {"passive",   "spring",    "damper",
                                        "equality",  "actuation", "constraint",
                                        "clampctrl", "limit",     "frictionloss"};
    bool off[9] = {false};
    for (int k = 0; flag && k < 9; ++k) {
        const char *value = mbsri_attribute(flag, names[k]);
        off[k] = value && strcmp(value, "disable") == 0;
    }
    if (off[0] || (off[1] && off[2])) m->s->with_passive = false;
    if (off[1] != off[2] && m->s->with_passive)
        mbsri_file_find(m->s, flag, "springs and dampers are not switched off apart: both stay");
    if (off[3] || off[5]) m->s->with_closures = false;
    if (off[4]) m->s->with_actuators = false;
    if (off[6]) m->free_controls = true;
    if (off[5] || off[7]) m->s->with_limits = false;
    if (off[5] || off[8]) m->s->with_friction = false;
}

static bool read_option(mbsri_mjcf *m, const mbsri_element *e)
{
    static const char *const fluid[] = {"density", "viscosity"};
    const mbsri_element *flag = mbsri_child(e, "flag");
    const char *gravity = flag ? mbsri_attribute(flag, "gravity") : NULL;
    read_flags(m, flag);
    if (mbsri_attribute(e, "actuatorgroupdisable"))
        m->idle = mbsri_attribute(e, "actuatorgroupdisable");
    for (int k = 0; k < 2; ++k) {
        double x = 0.0;
        if (!mbsri_numbers(m->s, e, fluid[k], mbsri_attribute(e, fluid[k]), 1, 1, &x, NULL))
            return false;
        if (x != 0.0) mbsri_file_find(m->s, e, "the fluid around (%s) is left out", fluid[k]);
    }
    if (!mbsri_numbers(m->s, e, "gravity", mbsri_attribute(e, "gravity"), 3, 3, m->s->gravity,
                       NULL))
        return false;
    if (gravity && strcmp(gravity, "disable") == 0) memset(m->s->gravity, 0, sizeof m->s->gravity);
    return true;
}

static bool add_assets(mbsri_mjcf *m, const mbsri_element *list)
{
    for (const mbsri_element *e = mbsri_child(list, "mesh"); e; e = mbsri_next(e)) {
        if (!mbsri_mjcf_add_mesh(m, e)) return false;
    }
    return mbsri_mjcf_looks(m->s, list, "material", &m->materials) &&
           mbsri_mjcf_looks(m->s, list, "texture", &m->textures);
}

/* ---- keys ---- */

static bool add_keys(mbsri_mjcf *m, const mbsri_element *list)
{
    for (const mbsri_element *e = mbsri_child(list, "key"); e; e = mbsri_next(e)) {
        mbsri_scene_key key = {.element = e,
                               .position = mbsri_attribute(e, "qpos"),
                               .velocity = mbsri_attribute(e, "qvel"),
                               .control = mbsri_attribute(e, "ctrl")};
        const char *name = mbsri_attribute(e, "name");
        key.key.name = name ? name : "";
        if (!mbsri_numbers(m->s, e, "time", mbsri_attribute(e, "time"), 1, 1, &key.key.time, NULL))
            return false;
        mbsri_scene_key *place = mbsri_list_add(m->s->arena, &m->s->keys, sizeof *place);
        if (!place) return false;
        *place = key;
    }
    return true;
}

/* ---- the file ---- */

/* Sections that the readers below do not know, and that say more than how things look or what is sensed. */
static void find_sections(mbsri_mjcf *m, const mbsri_element *root)
{
    static const char *const known[] = {"compiler", "option", "size",   "visual",    "statistic",
                                        "default",  "asset",  "custom", "worldbody", "contact",
                                        "equality", "tendon", "sensor", "actuator",  "keyframe"};
    for (const mbsri_element *e = root->child; e; e = e->next) {
        bool found = !e->child && !e->attribute[0]; /* it says nothing */
        for (size_t k = 0; k < sizeof known / sizeof *known && !found; ++k)
            found = mbsri_is(e, known[k]);
        if (!found)
            mbsri_file_find(m->s, e, "sections of this kind are left out, with all in them");
    }
}

typedef bool read_section(mbsri_mjcf *m, const mbsri_element *e);

static bool each(mbsri_mjcf *m, const mbsri_element *root, const char *name, read_section *read)
{
    for (const mbsri_element *e = mbsri_child(root, name); e; e = mbsri_next(e)) {
        if (!read(m, e)) return false;
    }
    return true;
}

static bool add_main_class(mbsri_mjcf *m, const mbsri_element *e)
{
    return add_class(m, e, NULL);
}

bool mbsri_mjcf_read(mbsri_scene *s, mbsri_element *root)
{
    mbsri_mjcf m = {.s = s,
                    .autolimits = true,
                    .sequence = "xyz",
                    .from_shapes = MBSRI_SHAPES_AUTO,
                    .groups = {0.0, 5.0}};
    includes i = {.s = s, .folder = folder_of(s, root->file)};
    const char *name = mbsri_attribute(root, "model");
    s->name = name ? name : "";
    m.home = i.folder;
    if (!i.folder || !expand(&i, root, 1)) return false;
    s->gravity[0] = s->gravity[1] = 0.0;
    s->gravity[2] = -9.81;
    find_sections(&m, root);
    mbsri_mjcf_find_words(&m, root);
    return each(&m, root, "compiler", read_compiler) && mbsri_mjcf_replicate(&m, root) &&
           each(&m, root, "option", read_option) && each(&m, root, "default", add_main_class) &&
           each(&m, root, "asset", add_assets) && each(&m, root, "worldbody", mbsri_mjcf_world) &&
           mbsri_mjcf_scale(&m, root) && each(&m, root, "tendon", mbsri_mjcf_tendons) &&
           each(&m, root, "equality", mbsri_mjcf_equalities) &&
           each(&m, root, "actuator", mbsri_mjcf_actuators) &&
           each(&m, root, "sensor", mbsri_mjcf_sensors) && each(&m, root, "keyframe", add_keys);
}

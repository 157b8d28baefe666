/* MJCF: the file as a whole, with its includes, defaults and options.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Sections may stand several times and in any order; they are read in the order in which they need
 * each other. */
#include "files/colours.h"
#include "files/mjcf_include.h"
#include "files/mjcf_parts.h"
#include "files/numbers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- defaults ---- */

/* parent NULL: the main class, of a model that is attached by its name. */
static bool add_class(mbsri_mjcf *m, const mbsri_element *e, const mbsri_class *parent)
{
    const char *name = parent || e->model ? mbsri_attribute(e, "class") : NULL;
    if (parent && !name) return mbsri_file_refuse(m->s, e, "it has no class");
    mbsri_class *class = mbsri_mjcf_class_of(m, name, parent);
    if (!class) return false;
    const mbsri_element **place = mbsri_list_add(m->s->arena, &class->elements, sizeof *place);
    if (!place) return false;
    *place = e;
    for (const mbsri_element *c = mbsri_child(e, "default"); c; c = mbsri_next(c)) {
        if (!add_class(m, c, class)) return false;
    }
    return true;
}

/* ---- options ---- */

/* What is switched off. */
static void read_flags(mbsri_mjcf *m, const mbsri_element *flag)
{
    static const char *const names[] = {"passive",      "spring",     "damper",    "equality",
                                        "actuation",    "constraint", "clampctrl", "limit",
                                        "frictionloss", "refsafe"};
    bool off[10] = {false};
    for (int k = 0; flag && k < 10; ++k) {
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
    if (off[9]) m->unsafe = true;
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
                       NULL) ||
        !mbsri_numbers(m->s, e, "timestep", mbsri_attribute(e, "timestep"), 1, 1, &m->timestep,
                       NULL))
        return false;
    if (gravity && strcmp(gravity, "disable") == 0) memset(m->s->gravity, 0, sizeof m->s->gravity);
    return true;
}

/* Pictures on surfaces; those around all are not looked for. */
static void find_pictures(mbsri_mjcf *m, const mbsri_element *list)
{
    for (const mbsri_element *e = mbsri_child(list, "texture"); e; e = mbsri_next(e)) {
        const char *type = mbsri_attribute(e, "type");
        if (mbsri_attribute(e, "file") && !(type && strcmp(type, "skybox") == 0))
            mbsri_file_find(m->s, e, "its picture is not drawn");
    }
}

static bool add_assets(mbsri_mjcf *m, const mbsri_element *list)
{
    find_pictures(m, list);
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
    mbsri_mjcf m = {.s = s, .home = s->home, .root = root, .timestep = 0.002};
    int number;
    const char *name = mbsri_attribute(root, "model");
    s->name = name ? name : "";
    if (!mbsri_mjcf_add_compiler(&m, "", &number) || !mbsri_mjcf_expand(&m, root)) return false;
    s->gravity[0] = s->gravity[1] = 0.0;
    s->gravity[2] = -9.81;
    return each(&m, root, "option", read_option) && each(&m, root, "default", add_main_class) &&
           each(&m, root, "asset", add_assets) && each(&m, root, "worldbody", mbsri_mjcf_world) &&
           mbsri_mjcf_scale(&m, root) && each(&m, root, "tendon", mbsri_mjcf_tendons) &&
           each(&m, root, "equality", mbsri_mjcf_equalities) &&
           each(&m, root, "contact", mbsri_mjcf_contacts) &&
           each(&m, root, "actuator", mbsri_mjcf_actuators) &&
           each(&m, root, "sensor", mbsri_mjcf_sensors) && each(&m, root, "keyframe", add_keys);
}

/* Elements of MJCF under other names: see mjcf_copies.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mjcf_copies.h"

#include "files/xml_make.h"

#include <stdio.h>
#include <string.h>

enum { MOST_ELEMENTS = 1 << 20 };

static const char *key_of(mbsri_copies *c, const char *kind, const char *name)
{
    const size_t length = strlen(kind) + strlen(name) + 2;
    char *key = mbsri_arena_take(c->m->s->arena, length);
    if (key) snprintf(key, length, "%s %s", kind, name);
    return key;
}

bool mbsri_copies_enter(mbsri_copies *c, const char *kind, const mbsri_element *e)
{
    const char *name = mbsri_attribute(e, "name");
    const char *key = name ? key_of(c, kind, name) : "";
    if (!name || !key) return key != NULL;
    return mbsri_names_find(&c->names, key) >= 0 ||
           mbsri_names_add(c->m->s->arena, &c->names, key, 0);
}

bool mbsri_copies_enter_all(mbsri_copies *c, const mbsri_element *e)
{
    for (const mbsri_element *child = e->child; child; child = child->next) {
        const char *kind = mbsri_is(child, "freejoint") ? "joint" : child->name;
        if (!mbsri_copies_enter(c, kind, child) || !mbsri_copies_enter_all(c, child)) return false;
    }
    return true;
}

const char *mbsri_copies_kind(const char *attribute)
{
    static const char *const kinds[][2] = {
        {"joint", "joint"},    {"joint1", "joint"},      {"joint2", "joint"},
        {"site", "site"},      {"site1", "site"},        {"site2", "site"},
        {"refsite", "site"},   {"sidesite", "site"},     {"slidersite", "site"},
        {"cranksite", "site"}, {"body", "body"},         {"body1", "body"},
        {"body2", "body"},     {"geom", "geom"},         {"geom1", "geom"},
        {"geom2", "geom"},     {"tendon", "tendon"},     {"tendon1", "tendon"},
        {"tendon2", "tendon"}, {"actuator", "actuator"}, {"jointinparent", "joint"}};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k)
        if (strcmp(kinds[k][0], attribute) == 0) return kinds[k][1];
    return NULL;
}

bool mbsri_copies_know(mbsri_copies *c, const char *attribute, const char *value)
{
    const char *kind = mbsri_copies_kind(attribute), *key = kind ? key_of(c, kind, value) : NULL;
    return key && mbsri_names_find(&c->names, key) >= 0;
}

mbsri_element *mbsri_copy_element(mbsri_copies *c, const mbsri_element *e)
{
    mbsri_arena *arena = c->m->s->arena;
    size_t count = 1;
    if (++c->m->copied > MOST_ELEMENTS) {
        mbsri_file_refuse(c->m->s, e, "there are too many copies of elements");
        return NULL;
    }
    while (e->attribute[count - 1]) ++count;
    mbsri_element *to = mbsri_element_like(arena, e, e->name);
    const char **attribute = mbsri_arena_take(arena, count * sizeof *attribute);
    if (!to || !attribute) return NULL;
    to->attribute = attribute;
    for (size_t k = 0; k + 1 < count; k += 2) {
        attribute[k] = e->attribute[k];
        attribute[k + 1] = c->rename(c, e, e->attribute[k], e->attribute[k + 1]);
        if (!attribute[k + 1]) return NULL;
    }
    for (const mbsri_element *child = e->child; child; child = child->next) {
        mbsri_element *again = mbsri_copy_element(c, child);
        if (!again) return NULL;
        mbsri_append(to, again);
    }
    return to;
}

/* Replicas in MJCF: written out before anything else is read.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Replica i of <replicate count offset euler sep> is a frame with its elements, whose names end in sep and i, with as many
 * digits as count has. It is turned by i euler and stands at
 *
 *   x_0 = 0,   x_(i+1) = x_i + R(i euler) offset
 *
 * Elements of other sections that refer to one of these names are there once for each replica, behind the others of their
 * section. Inner replicas come first. */
#include "files/mjcf_parts.h"
#include "files/numbers.h"

#include <stdio.h>
#include <string.h>

enum { MOST_ELEMENTS = 1 << 20 };

/* One <replicate>. */
typedef struct replicas {
    mbsri_mjcf *m;
    mbsri_names names; /* "kind name" of what stands in it or refers to it */
    int count, digits;
    const char *separator;
    int *made; /* elements so far, of all of them */
} replicas;

/* ---- names ---- */

static const char *key_of(replicas *r, const char *kind, const char *name)
{
    const size_t length = strlen(kind) + strlen(name) + 2;
    char *key = mbsri_arena_take(r->m->s->arena, length);
    if (key) snprintf(key, length, "%s %s", kind, name);
    return key;
}

static bool enter(replicas *r, const char *kind, const mbsri_element *e)
{
    const char *name = mbsri_attribute(e, "name");
    const char *key = name ? key_of(r, kind, name) : "";
    if (!name || !key) return key != NULL;
    return mbsri_names_find(&r->names, key) >= 0 ||
           mbsri_names_add(r->m->s->arena, &r->names, key, 0);
}

static bool enter_all(replicas *r, const mbsri_element *e)
{
    for (const mbsri_element *c = e->child; c; c = c->next) {
        const char *kind = mbsri_is(c, "freejoint") ? "joint" : c->name;
        if (!enter(r, kind, c) || !enter_all(r, c)) return false;
    }
    return true;
}

/* What an attribute of other sections refers to; NULL: nothing that is replicated. */
static const char *kind_of(const char *attribute)
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

static bool is_known(replicas *r, const char *attribute, const char *value)
{
    const char *kind = kind_of(attribute), *key = kind ? key_of(r, kind, value) : NULL;
    return key && mbsri_names_find(&r->names, key) >= 0;
}

static bool refers(replicas *r, const mbsri_element *e)
{
    for (const char **a = e->attribute; *a; a += 2)
        if (is_known(r, a[0], a[1])) return true;
    for (const mbsri_element *c = e->child; c; c = c->next)
        if (refers(r, c)) return true;
    return false;
}

/* ---- copies ---- */

static void append(mbsri_element *parent, mbsri_element *e)
{
    e->parent = parent;
    e->next = NULL;
    if (parent->last)
        parent->last->next = e;
    else
        parent->child = e;
    parent->last = e;
}

static const char *with_suffix(replicas *r, const char *name, int i)
{
    const size_t length = strlen(name) + strlen(r->separator) + 16;
    char *text = mbsri_arena_take(r->m->s->arena, length);
    if (text) snprintf(text, length, "%s%s%0*d", name, r->separator, r->digits, i);
    return text;
}

/* An element for replica i; `inside`: one that stands in the <replicate>, whose names alone change. */
static mbsri_element *copy(replicas *r, const mbsri_element *e, int i, bool inside)
{
    mbsri_arena *arena = r->m->s->arena;
    size_t count = 1;
    if (++*r->made > MOST_ELEMENTS) {
        mbsri_file_refuse(r->m->s, e, "there are too many replicas");
        return NULL;
    }
    while (e->attribute[count - 1]) ++count;
    mbsri_element *to = mbsri_arena_take(arena, sizeof *to);
    const char **attribute = mbsri_arena_take(arena, count * sizeof *attribute);
    if (!to || !attribute) return NULL;
    *to = *e;
    to->child = to->last = NULL;
    to->attribute = attribute;
    for (size_t k = 0; k + 1 < count; k += 2) {
        const char *name = e->attribute[k], *value = e->attribute[k + 1];
        const bool own = strcmp(name, "name") == 0 || (!inside && is_known(r, name, value));
        attribute[k] = name;
        attribute[k + 1] = own ? with_suffix(r, value, i) : value;
    }
    for (const mbsri_element *c = e->child; c; c = c->next) {
        mbsri_element *child = copy(r, c, i, inside);
        if (!child) return NULL;
        append(to, child);
    }
    return to;
}

/* ---- replicas ---- */

static const char *three_numbers(mbsri_arena *arena, const double x[3])
{
    char text[100];
    const int length = snprintf(text, sizeof text, "%.17g %.17g %.17g", x[0], x[1], x[2]);
    for (char *c = text; *c; ++c) /* the point of the locale */
        if (!strchr("+-0123456789e .", *c)) *c = '.';
    return mbsri_arena_text(arena, text, (size_t)length);
}

/* The frame of replica i, at x, which moves on to the next one. */
static mbsri_element *frame_of(mbsri_mjcf *m, const mbsri_element *e, int i, const double offset[3],
                               const double euler[3], double x[3])
{
    mbsri_arena *arena = m->s->arena;
    mbsri_element *frame = mbsri_arena_take(arena, sizeof *frame);
    const char **attribute = mbsri_arena_take(arena, 7 * sizeof *attribute),
               *class = mbsri_attribute(e, "childclass");
    const double turn[3] = {i * euler[0], i * euler[1], i * euler[2]};
    if (!frame || !attribute) return NULL;
    *frame =
        (mbsri_element){.name = "frame", .file = e->file, .line = e->line, .attribute = attribute};
    attribute[0] = "pos", attribute[1] = three_numbers(arena, x);
    attribute[2] = "euler", attribute[3] = three_numbers(arena, turn);
    if (class) attribute[4] = "childclass", attribute[5] = class;
    mbsr_frame at;
    const mbsri_node node = {.e = frame};
    if (!attribute[1] || !attribute[3] || !mbsri_mjcf_frame(m, &node, &at)) return NULL;
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) x[k] += at.R[3 * l + k] * offset[l];
    return frame;
}

/* Elements of a section that refer to what stands in replicas: removed, and made again for each of these. */
static bool copy_section(replicas *r, mbsri_element *section)
{
    mbsri_list found = {.count = 0};
    mbsri_element *e = section->child;
    section->child = section->last = NULL;
    for (mbsri_element *next; e; e = next) {
        next = e->next;
        if (!refers(r, e)) {
            append(section, e);
            continue;
        }
        const bool tendon = mbsri_is(section, "tendon");
        mbsri_element **place = mbsri_list_add(r->m->s->arena, &found, sizeof *place);
        if (!place || !enter(r, tendon ? "tendon" : section->name, e)) return false;
        *place = e;
    }
    for (int k = 0; k < r->count * found.count; ++k) {
        mbsri_element *again =
            copy(r, ((mbsri_element **)found.items)[k % found.count], k / found.count, false);
        if (!again) return false;
        append(section, again);
    }
    return true;
}

static bool copy_sections(replicas *r, mbsri_element *root)
{
    static const char *const names[] = {"tendon", "contact", "equality", "actuator", "sensor"};
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
        for (mbsri_element *s = root->child; s; s = s->next)
            if (mbsri_is(s, names[k]) && !copy_section(r, s)) return false;
    }
    return true;
}

/* The frames in place of a <replicate>, the first to *first and the last returned; NULL: refused, or no memory. */
static mbsri_element *write_out(mbsri_mjcf *m, const mbsri_element *e, int *made,
                                mbsri_element *root, mbsri_element **first)
{
    double offset[3] = {0.0}, euler[3] = {0.0}, x[3] = {0.0};
    const char *count = mbsri_attribute(e, "count"), *separator = mbsri_attribute(e, "sep");
    replicas r = {.m = m, .separator = separator ? separator : "", .made = made};
    mbsri_element all = {.child = NULL};
    if (!count || !mbsri_read_integer(count, &r.count) || r.count < 1) {
        mbsri_file_refuse(m->s, e, "count is no positive number");
        return NULL;
    }
    for (int power = r.count; power > 0; power /= 10) ++r.digits;
    if (!mbsri_numbers(m->s, e, "offset", mbsri_attribute(e, "offset"), 3, 3, offset, NULL) ||
        !mbsri_numbers(m->s, e, "euler", mbsri_attribute(e, "euler"), 3, 3, euler, NULL) ||
        !enter_all(&r, e))
        return NULL;
    for (int i = 0; i < r.count; ++i) {
        mbsri_element *frame = frame_of(m, e, i, offset, euler, x);
        if (!frame) return NULL;
        append(&all, frame);
        for (const mbsri_element *c = e->child; c; c = c->next) {
            mbsri_element *again = copy(&r, c, i, true);
            if (!again) return NULL;
            append(frame, again);
        }
    }
    *first = all.child;
    return copy_sections(&r, root) ? all.last : NULL;
}

static bool expand(mbsri_mjcf *m, mbsri_element *e, int *made, mbsri_element *root)
{
    for (mbsri_element *c = e->child, *before = NULL; c; before = c, c = c->next) {
        if (!expand(m, c, made, root)) return false;
        if (!mbsri_is(c, "replicate")) continue;
        mbsri_element *first, *last = write_out(m, c, made, root, &first);
        if (!last) return false;
        for (mbsri_element *frame = first; frame; frame = frame->next) frame->parent = e;
        last->next = c->next;
        if (before)
            before->next = first;
        else
            e->child = first;
        if (e->last == c) e->last = last;
        c = last;
    }
    return true;
}

bool mbsri_mjcf_replicate(mbsri_mjcf *m, mbsri_element *root)
{
    int made = 0;
    for (mbsri_element *e = root->child; e; e = e->next)
        if (mbsri_is(e, "worldbody") && !expand(m, e, &made, root)) return false;
    return true;
}

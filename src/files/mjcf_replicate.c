/* Replicas in MJCF: written out before anything else is read.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Replica i of <replicate count offset euler sep> is a frame with its elements, whose names end in
 * sep and i, with as many digits as count has. It is turned by i euler and stands at
 *
 *   x_0 = 0,   x_(i+1) = x_i + R(i euler) offset
 *
 * Elements of other sections that refer to one of these names are there once for each replica,
 * behind the others of their section. Inner replicas come first. */
#include "files/mjcf_copies.h"
#include "files/numbers.h"
#include "files/xml_make.h"

#include <stdio.h>
#include <string.h>

/* One <replicate>. */
typedef struct replicas {
    mbsri_copies copies;
    int count, digits;
    const char *separator;
    int number;  /* of the replica that is made */
    bool inside; /* of what stands in the <replicate> the names alone change */
} replicas;

static const char *with_suffix(mbsri_copies *c, const mbsri_element *e, const char *attribute,
                               const char *value)
{
    const replicas *r = c->user;
    (void)e;
    if (strcmp(attribute, "name") != 0 && (r->inside || !mbsri_copies_know(c, attribute, value)))
        return value;
    const size_t length = strlen(value) + strlen(r->separator) + 16;
    char *text = mbsri_arena_take(c->m->s->arena, length);
    if (text) snprintf(text, length, "%s%s%0*d", value, r->separator, r->digits, r->number);
    return text;
}

static bool refers(replicas *r, const mbsri_element *e)
{
    for (const char **a = e->attribute; *a; a += 2)
        if (mbsri_copies_know(&r->copies, a[0], a[1])) return true;
    for (const mbsri_element *c = e->child; c; c = c->next)
        if (refers(r, c)) return true;
    return false;
}

/* The frame of replica i, at x, which moves on to the next one. */
static mbsri_element *frame_of(mbsri_mjcf *m, const mbsri_element *e, int i, const double offset[3],
                               const double euler[3], double x[3])
{
    mbsri_arena *arena = m->s->arena;
    mbsri_element *frame = mbsri_element_like(arena, e, "frame");
    const char *class = mbsri_attribute(e, "childclass");
    const double turn[3] = {i * euler[0], i * euler[1], i * euler[2]};
    mbsr_frame at;
    if (!frame || !mbsri_element_set_numbers(arena, frame, "pos", 3, x) ||
        !mbsri_element_set_numbers(arena, frame, "euler", 3, turn) ||
        (class && !mbsri_element_set(arena, frame, "childclass", class)))
        return NULL;
    const mbsri_mjcf_part node = {.e = frame};
    if (!mbsri_mjcf_frame(m, &node, &at)) return NULL;
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) x[k] += at.R[3 * l + k] * offset[l];
    return frame;
}

/* Elements of a section that refer to what stands in replicas: removed, and made again for each of
 * these. */
static bool copy_section(replicas *r, mbsri_element *section)
{
    mbsri_list found = {.count = 0};
    mbsri_element *e = section->child;
    section->child = section->last = NULL;
    for (mbsri_element *next; e; e = next) {
        next = e->next;
        if (!refers(r, e)) {
            mbsri_append(section, e);
            continue;
        }
        const bool tendon = mbsri_is(section, "tendon");
        mbsri_element **place = mbsri_list_add(r->copies.m->s->arena, &found, sizeof *place);
        if (!place || !mbsri_copies_enter(&r->copies, tendon ? "tendon" : section->name, e))
            return false;
        *place = e;
    }
    for (int k = 0; k < r->count * found.count; ++k) {
        r->number = k / found.count;
        mbsri_element *again =
            mbsri_copy_element(&r->copies, ((mbsri_element **)found.items)[k % found.count]);
        if (!again) return false;
        mbsri_append(section, again);
    }
    return true;
}

static bool copy_sections(replicas *r, mbsri_element *root)
{
    static const char *const names[] = {"tendon", "contact", "equality", "actuator", "sensor"};
    r->inside = false;
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
        for (mbsri_element *s = root->child; s; s = s->next)
            if (mbsri_is(s, names[k]) && !copy_section(r, s)) return false;
    }
    return true;
}

/* The frames in place of a <replicate>, into `all`. */
static bool write_out(mbsri_mjcf *m, const mbsri_element *e, mbsri_element *root,
                      mbsri_element *all)
{
    double offset[3] = {0.0}, euler[3] = {0.0}, x[3] = {0.0};
    const char *count = mbsri_attribute(e, "count"), *separator = mbsri_attribute(e, "sep");
    replicas r = {.copies = {.m = m, .rename = with_suffix},
                  .separator = separator ? separator : "",
                  .inside = true};
    r.copies.user = &r;
    if (!count || !mbsri_read_integer(count, &r.count) || r.count < 1)
        return mbsri_file_refuse(m->s, e, "count is no positive number");
    for (int power = r.count; power > 0; power /= 10) ++r.digits;
    if (!mbsri_numbers(m->s, e, "offset", mbsri_attribute(e, "offset"), 3, 3, offset, NULL) ||
        !mbsri_numbers(m->s, e, "euler", mbsri_attribute(e, "euler"), 3, 3, euler, NULL) ||
        !mbsri_copies_enter_all(&r.copies, e))
        return false;
    for (; r.number < r.count; ++r.number) {
        mbsri_element *frame = frame_of(m, e, r.number, offset, euler, x);
        if (!frame) return false;
        mbsri_append(all, frame);
        for (const mbsri_element *c = e->child; c; c = c->next) {
            mbsri_element *again = mbsri_copy_element(&r.copies, c);
            if (!again) return false;
            mbsri_append(frame, again);
        }
    }
    return copy_sections(&r, root);
}

static bool expand_replicas(mbsri_mjcf *m, mbsri_element *e, mbsri_element *root)
{
    for (mbsri_element *c = e->child, *before = NULL; c; before = c, c = c->next) {
        mbsri_element all = {.child = NULL};
        if (!expand_replicas(m, c, root)) return false;
        if (!mbsri_is(c, "replicate")) continue;
        if (!write_out(m, c, root, &all)) return false;
        c = mbsri_put_in_place(e, before, c, &all);
    }
    return true;
}

bool mbsri_mjcf_replicate(mbsri_mjcf *m, mbsri_element *root)
{
    for (mbsri_element *e = root->child; e; e = e->next)
        if (mbsri_is(e, "worldbody") && !expand_replicas(m, e, root)) return false;
    return true;
}

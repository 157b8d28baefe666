/* Attributes of MJCF: defaults by classes, orientations, names.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mjcf_parts.h"
#include "files/numbers.h"
#include "algebra/space3.h"

#include <math.h>
#include <string.h>

const char *mbsri_mjcf_name(const mbsri_element *e)
{
    const char *name = mbsri_attribute(e, "name");
    return name ? name : "";
}

/* The class of that name, NULL for the main one; NULL: none. */
static mbsri_class *mjcf_class(const mbsri_mjcf *m, const char *name)
{
    mbsri_class *c = m->classes;
    while (c && (name && c->name ? strcmp(c->name, name) != 0 : c->name != name)) c = c->next;
    return c;
}

mbsri_class *mbsri_mjcf_class_of(mbsri_mjcf *m, const char *name, const mbsri_class *parent)
{
    mbsri_class *class = mjcf_class(m, name);
    if (class) return class;
    class = mbsri_arena_take(m->s->arena, sizeof *class);
    if (!class) return NULL;
    *class = (mbsri_class){.name = name, .parent = parent, .next = m->classes};
    m->classes = class;
    return class;
}

bool mbsri_mjcf_node(mbsri_mjcf *m, const mbsri_element *e, const char *kind,
                     const char *childclass, mbsri_mjcf_part *node)
{
    const char *class = mbsri_attribute(e, "class");
    if (!class) class = childclass;
    if (class && strcmp(class, "main") == 0) class = NULL;
    *node = (mbsri_mjcf_part){e, kind, mjcf_class(m, class), NULL};
    return !class || node->class || mbsri_file_refuse(m->s, e, "there is no class '%.50s'", class);
}

static bool is_kind(const mbsri_mjcf_part *node, const mbsri_element *e)
{
    bool is = mbsri_is(e, node->kind);
    for (const char *const *kind = node->alike; kind && *kind && !is; ++kind)
        is = mbsri_is(e, *kind);
    return is;
}

/* What a class says of this kind of elements; the last of several defaults counts. */
static const char *said_by_class(const mbsri_class *class, const mbsri_mjcf_part *node,
                                 const char *attribute)
{
    const mbsri_element *const *elements = class->elements.items;
    const char *said = NULL;
    for (int k = class->elements.count - 1; k >= 0 && !said; --k) {
        for (const mbsri_element *e = elements[k]->child; e; e = e->next) {
            const char *value = is_kind(node, e) ? mbsri_attribute(e, attribute) : NULL;
            if (value) said = value;
        }
    }
    return said;
}

const char *mbsri_mjcf_get(const mbsri_mjcf_part *node, const char *attribute)
{
    const char *value = mbsri_attribute(node->e, attribute);
    const mbsri_class *class = node->kind ? node->class : NULL;
    for (; class && !value; class = class->parent) value = said_by_class(class, node, attribute);
    return value;
}

bool mbsri_mjcf_numbers(mbsri_mjcf *m, const mbsri_mjcf_part *node, const char *attribute,
                        int least, int most, double *to, int *count)
{
    return mbsri_numbers(m->s, node->e, attribute, mbsri_mjcf_get(node, attribute), least, most, to,
                         count);
}

bool mbsri_mjcf_number(mbsri_mjcf *m, const mbsri_mjcf_part *node, const char *attribute,
                       double *to)
{
    return mbsri_mjcf_numbers(m, node, attribute, 1, 1, to, NULL);
}

bool mbsri_mjcf_law(mbsri_mjcf *m, const mbsri_mjcf_part *node, const char *attribute,
                    double *linear, double *cubic)
{
    double law[3] = {*linear};
    if (!mbsri_mjcf_numbers(m, node, attribute, 1, 3, law, NULL)) return false;
    const bool left = law[1] != 0.0 || (law[2] != 0.0 && !(cubic && law[2] > 0.0));
    if (left)
        mbsri_file_find(m->s, node->e, "of its %s the first number alone is followed", attribute);
    *linear = law[0];
    if (cubic) *cubic = left ? 0.0 : law[2];
    return true;
}

bool mbsri_mjcf_switch(const mbsri_mjcf_part *node, const char *attribute, bool automatic)
{
    const char *value = mbsri_mjcf_get(node, attribute);
    if (!value || strcmp(value, "auto") == 0) return automatic;
    return strcmp(value, "true") == 0;
}

bool mbsri_mjcf_range(mbsri_mjcf *m, const mbsri_mjcf_part *node, const char *attribute,
                      const char *limited, double range[2], bool *holds)
{
    if (!mbsri_mjcf_numbers(m, node, attribute, 2, 2, range, NULL)) return false;
    const bool some = range[0] != 0.0 || range[1] != 0.0;
    *holds = mbsri_mjcf_switch(node, limited, some && mbsri_mjcf_compiler(m, node->e)->autolimits);
    return !*holds || range[0] < range[1] ||
           mbsri_file_refuse(m->s, node->e, "%s is no range", attribute);
}

/* ---- orientations ---- */

static double length_of(int n, const double *x)
{
    double square = 0.0;
    for (int k = 0; k < n; ++k) square += x[k] * x[k];
    return sqrt(square);
}

mbsr_frame mbsri_mjcf_along(const double x[3], const double z[3])
{
    const double axis[3] = {-z[1], z[0], 0.0}, sine = length_of(2, axis),
                 across[3] = {1.0, 0.0, 0.0}, angle = atan2(sine, z[2]);
    return mbsr_frame_rotated(x, sine > 1e-10 * length_of(3, z) ? axis : across, angle);
}

static mbsr_frame by_euler(const char sequence[4], const double x[3], const double angle[3])
{
    mbsr_frame frame = mbsr_frame_identity();
    for (int k = 0; k < 3; ++k) {
        const char letter = sequence[k];
        const bool fixed = letter >= 'X' && letter <= 'Z';
        double axis[3] = {0.0};
        axis[letter - (fixed ? 'X' : 'x')] = 1.0;
        const mbsr_frame turn = mbsr_frame_rotated(NULL, axis, angle[k]);
        frame = fixed ? mbsr_frame_product(&turn, &frame) : mbsr_frame_product(&frame, &turn);
    }
    memcpy(frame.x, x, sizeof frame.x);
    return frame;
}

static bool by_axes(mbsr_frame *frame, const double axes[6])
{
    double *X = frame->R, *Y = X + 3, *Z = Y + 3, along = 0.0;
    const double size = length_of(3, axes);
    for (int k = 0; k < 3; ++k) X[k] = axes[k] / size;
    for (int k = 0; k < 3; ++k) along += X[k] * axes[3 + k];
    for (int k = 0; k < 3; ++k) Y[k] = axes[3 + k] - along * X[k];
    const double rest = length_of(3, Y);
    for (int k = 0; k < 3; ++k) Y[k] /= rest;
    mbsri_cross3(X, Y, Z);
    return size > 0.0 && rest > 1e-12 * length_of(3, axes + 3);
}

bool mbsri_mjcf_frame(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_frame *frame)
{
    static const char *const names[] = {"quat", "axisangle", "xyaxes", "zaxis", "euler"};
    static const int sizes[] = {4, 4, 6, 3, 3};
    const mbsri_compiler *c = mbsri_mjcf_compiler(m, node->e);
    const double unit = c->radian ? 1.0 : 3.14159265358979323846 / 180.0;
    double x[3] = {0.0}, given[6];
    int way = -1;
    if (!mbsri_mjcf_numbers(m, node, "pos", 3, 3, x, NULL)) return false;
    for (int k = 0; k < 5; ++k) {
        int count;
        double read[6];
        if (!mbsri_mjcf_numbers(m, node, names[k], sizes[k], sizes[k], read, &count)) return false;
        if (count == 0) continue;
        if (way >= 0 && mbsri_attribute(node->e, names[way]) && mbsri_attribute(node->e, names[k]))
            return mbsri_file_refuse(m->s, node->e, "it has two orientations, %s and %s",
                                     names[way], names[k]);
        if (way >= 0 && mbsri_attribute(node->e, names[way])) continue;
        way = k;
        memcpy(given, read, sizeof given);
    }
    *frame = mbsr_frame_at(x[0], x[1], x[2]);
    if (way < 0) return true;
    bool good = way == 4 || length_of(way == 1 ? 3 : sizes[way], given) > 0.0;
    if (good && way == 0) *frame = mbsr_frame_quaternion(x, given);
    if (good && way == 1) *frame = mbsr_frame_rotated(x, given, unit * given[3]);
    if (good && way == 2) good = by_axes(frame, given);
    if (good && way == 3) *frame = mbsri_mjcf_along(x, given);
    if (way == 4) {
        for (int k = 0; k < 3; ++k) given[k] *= unit;
        *frame = by_euler(c->sequence, x, given);
    }
    return good || mbsri_file_refuse(m->s, node->e, "%s has no direction", names[way]);
}

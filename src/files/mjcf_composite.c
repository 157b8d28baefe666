/* Composites of MJCF: a cable, written out as bodies before anything else is read.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The cable runs along points x_0 .. x_n: those of `vertex`, or by `curve` in each coordinate, with
 * s = i / n,
 *
 *   s: size[0] s,   cos(s): size[1] cos(pi size[2] s),   sin(s): size[1] sin(pi size[2] s),   0: 0
 *
 * Edge i is a body at x_i with its x axis along the edge and its y axis along a normal, which the
 * turn of one edge to the next carries on; where the first two edges are in line there is none, and
 * x is turned to each edge. Each body has a ball joint, the first one as `initial` says. Defaults
 * of the file do not hold for what a composite makes. */
#include "files/mjcf_parts.h"
#include "files/numbers.h"
#include "algebra/space3.h"
#include "files/xml_make.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_POINTS = 100000 };

typedef struct cable {
    mbsri_mjcf *m;
    const mbsri_element *e;
    const char *prefix, *type, *initial;
    double offset[3], size[3]; /* half edges of a box, radius of others */
    int points;
    double *point;
    double normal[3], turn[4]; /* of the edge before */
} cable;

/* ---- points ---- */

/* False: there is no such curve. */
static bool on_curve(const char *kind, size_t length, const double size[3], double s, double *x)
{
    static const char *const kinds[] = {"s", "cos(s)", "sin(s)", "0"};
    const double angle = 3.14159265358979323846 * s * size[2],
                 values[] = {size[0] * s, size[1] * cos(angle), size[1] * sin(angle), 0.0};
    *x = 0.0;
    for (int k = 0; k < 4; ++k) {
        if (strlen(kinds[k]) != length || strncmp(kind, kinds[k], length) != 0) continue;
        *x = values[k];
        return true;
    }
    return length == 0;
}

static bool make_points(cable *c)
{
    mbsri_scene *s = c->m->s;
    double count[3] = {1.0, 1.0, 1.0}, size[3] = {1.0, 0.0, 0.0}, quat[4] = {1.0};
    const char *curve = mbsri_attribute(c->e, "curve");
    if (!mbsri_numbers(s, c->e, "count", mbsri_attribute(c->e, "count"), 1, 3, count, NULL) ||
        !mbsri_numbers(s, c->e, "size", mbsri_attribute(c->e, "size"), 1, 3, size, NULL) ||
        !mbsri_numbers(s, c->e, "quat", mbsri_attribute(c->e, "quat"), 4, 4, quat, NULL))
        return false;
    if (!(count[0] >= 2.0 && count[0] <= MOST_POINTS) || count[1] != 1.0 || count[2] != 1.0)
        return mbsri_file_refuse(s, c->e, "its count is not from 2 to %d, in one direction",
                                 MOST_POINTS);
    c->points = (int)count[0];
    c->point = mbsri_arena_take(s->arena, 3 * (size_t)c->points * sizeof *c->point);
    if (!c->point) return false;
    const mbsr_frame turn = mbsr_frame_quaternion(NULL, quat);
    for (int i = 0; i < c->points; ++i) {
        const char *kind = curve ? curve : "";
        for (int k = 0; k < 3; ++k) {
            kind += strspn(kind, " \t\n\r");
            const size_t length = strcspn(kind, " \t\n\r");
            double x;
            if (!on_curve(kind, length, size, (double)i / (c->points - 1), &x))
                return mbsri_file_refuse(s, c->e, "curve has a part that is no curve");
            for (int l = 0; l < 3; ++l) c->point[3 * i + l] += turn.R[3 * k + l] * x;
            kind += length;
        }
    }
    return true;
}

static bool read_points(cable *c)
{
    mbsri_scene *s = c->m->s;
    const char *text = mbsri_attribute(c->e, "vertex");
    int count = 0;
    if (!text) return make_points(c);
    double value;
    for (const char *at = text; *at; ++count)
        if (!mbsri_read_number(&at, &value))
            return mbsri_file_refuse(s, c->e, "vertex is not numbers alone");
    c->points = count / 3;
    if (count % 3 != 0 || c->points < 2 || c->points > MOST_POINTS)
        return mbsri_file_refuse(s, c->e, "vertex is not 2 to %d points", MOST_POINTS);
    c->point = mbsri_arena_take(s->arena, (size_t)count * sizeof *c->point);
    for (int k = 0; k < count && c->point; ++k) (void)mbsri_read_number(&text, c->point + k);
    return c->point != NULL;
}

/* ---- frames ---- */

/* To length 1, but for one that has none; what it was. */
static double normalise(double x[3])
{
    const double length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    if (length < 1e-7) return 0.0;
    for (int k = 0; k < 3; ++k) x[k] /= length;
    return length;
}

/* From point i to the next one, and its length. */
static double edge_of(const cable *c, int i, double edge[3])
{
    for (int k = 0; k < 3; ++k) edge[k] = c->point[3 * (i + 1) + k] - c->point[3 * i + k];
    return normalise(edge);
}

/* The quaternion of axes, of which the last two may be zero. */
static void quaternion_of(double axis[3][3], double q[4])
{
    const double trace = axis[0][0] + axis[1][1] + axis[2][2];
    int i = axis[1][1] > axis[2][2] ? 1 : 2;
    if (axis[0][0] > axis[1][1] && axis[0][0] > axis[2][2]) i = 0;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    double square = 0.0;
    if (trace > 0.0) {
        q[0] = 0.5 * sqrt(1.0 + trace);
        for (int l = 0; l < 3; ++l) {
            const int a = (l + 1) % 3, b = (l + 2) % 3;
            q[1 + l] = 0.25 * (axis[a][b] - axis[b][a]) / q[0];
        }
    } else {
        q[1 + i] = 0.5 * sqrt(1.0 + 2.0 * axis[i][i] - trace);
        q[0] = 0.25 * (axis[j][k] - axis[k][j]) / q[1 + i];
        q[1 + j] = 0.25 * (axis[i][j] + axis[j][i]) / q[1 + i];
        q[1 + k] = 0.25 * (axis[i][k] + axis[k][i]) / q[1 + i];
    }
    for (int l = 0; l < 4; ++l) square += q[l] * q[l];
    for (int l = 0; l < 4; ++l) q[l] /= sqrt(square);
}

/* The quaternion of edge i, and its length; carries the normal on. */
static double turn_edge(cable *c, int i, double q[4])
{
    double axis[3][3], other[3], across[3];
    const double length = edge_of(c, i, axis[0]);
    if (i == 0) {
        memset(other, 0, sizeof other);
        if (c->points > 2) (void)edge_of(c, 1, other);
        mbsri_cross3(axis[0], other, across);
        (void)normalise(across);
        mbsri_cross3(across, axis[0], c->normal);
        memcpy(axis[2], across, sizeof axis[2]);
    } else {
        (void)edge_of(c, i - 1, other);
        mbsri_cross3(other, axis[0], across);
        const double sine = normalise(across),
                     cosine = other[0] * axis[0][0] + other[1] * axis[0][1] + other[2] * axis[0][2];
        if (sine > 0.0) {
            const mbsr_frame turn = mbsr_frame_rotated(NULL, across, atan2(sine, cosine));
            double n[3] = {0.0};
            for (int k = 0; k < 3; ++k)
                for (int l = 0; l < 3; ++l) n[l] += turn.R[3 * k + l] * c->normal[k];
            memcpy(c->normal, n, sizeof n);
        }
    }
    (void)normalise(c->normal);
    if (i > 0) {
        mbsri_cross3(axis[0], c->normal, axis[2]);
        (void)normalise(axis[2]);
    }
    memcpy(axis[1], c->normal, sizeof axis[1]);
    quaternion_of(axis, q);
    return length;
}

/* ---- bodies ---- */

/* PREFIX, a letter, and first, last or the number of the edge. */
static const char *part_name(const cable *c, const char *letter, int i)
{
    char number[16];
    snprintf(number, sizeof number, "_%d", i);
    const char *place = i == 0 ? "_first" : i == c->points - 2 ? "_last" : number;
    return mbsri_arena_join(c->m->s->arena, c->prefix, letter, place);
}

/* An element in a body, with what a child of the composite says, without the defaults of the file.
 */
static mbsri_element *add_piece(const cable *c, mbsri_element *body, const char *kind,
                                const char *name)
{
    mbsri_arena *arena = c->m->s->arena;
    const mbsri_element *said = mbsri_child(c->e, kind);
    mbsri_element *e = mbsri_element_like(arena, said ? said : c->e, kind);
    if (!e || !name || !mbsri_element_set(arena, e, "name", name) ||
        !mbsri_element_set(arena, e, "class", MBSRI_PLAIN_CLASS))
        return NULL;
    for (const char **a = said ? said->attribute : NULL; a && *a; a += 2)
        if (strcmp(a[0], "kind") != 0 && !mbsri_element_set(arena, e, a[0], a[1])) return NULL;
    mbsri_append(body, e);
    return e;
}

static bool add_shape(const cable *c, mbsri_element *body, int i, double length)
{
    mbsri_arena *arena = c->m->s->arena;
    char name[16];
    const double ends[6] = {0.0, 0.0, 0.0, length}, middle[3] = {0.5 * length},
                 size[3] = {0.5 * length, c->size[1], c->size[2]};
    snprintf(name, sizeof name, "G%d", i);
    mbsri_element *e = add_piece(c, body, "geom", mbsri_arena_join(arena, c->prefix, name, ""));
    if (!e) return false;
    if (strcmp(c->type, "box") != 0) return mbsri_element_set_numbers(arena, e, "fromto", 6, ends);
    return mbsri_element_set_numbers(arena, e, "pos", 3, middle) &&
           mbsri_element_set_numbers(arena, e, "size", 3, size);
}

static bool add_cable_joint(const cable *c, mbsri_element *body, int i)
{
    mbsri_arena *arena = c->m->s->arena;
    const bool free = i == 0 && strcmp(c->initial, "free") == 0;
    if (i == 0 && strcmp(c->initial, "none") == 0) return true;
    mbsri_element *e = add_piece(c, body, "joint", part_name(c, "J", i));
    return e && mbsri_element_set(arena, e, "type", free ? "free" : "ball") &&
           (!free || (mbsri_element_set(arena, e, "damping", "0") &&
                      mbsri_element_set(arena, e, "armature", "0") &&
                      mbsri_element_set(arena, e, "frictionloss", "0")));
}

static bool add_end(const cable *c, mbsri_element *body, int i, double length)
{
    const double x[3] = {i == c->points - 2 ? length : 0.0};
    if (i > 0 && i < c->points - 2) return true;
    mbsri_element *e = add_piece(c, body, "site", part_name(c, "S", i));
    return e && mbsri_element_set_numbers(c->m->s->arena, e, "pos", 3, x);
}

/* Edge i on the one before; NULL: no memory. */
static mbsri_element *add_cable_body(cable *c, mbsri_element *parent, int i)
{
    mbsri_arena *arena = c->m->s->arena;
    double q[4], own[4], x[3] = {0.0}, edge[3];
    const double length = turn_edge(c, i, own), *p = c->turn;
    const char *name = part_name(c, "B", i);
    mbsri_element *body = mbsri_element_like(arena, c->e, "body");
    if (i == 0) {
        for (int k = 0; k < 3; ++k) x[k] = c->offset[k] + c->point[k];
        memcpy(q, own, sizeof q);
    } else { /* conj(p) own */
        x[0] = edge_of(c, i - 1, edge);
        q[0] = p[0] * own[0] + p[1] * own[1] + p[2] * own[2] + p[3] * own[3];
        q[1] = p[0] * own[1] - p[1] * own[0] - p[2] * own[3] + p[3] * own[2];
        q[2] = p[0] * own[2] + p[1] * own[3] - p[2] * own[0] - p[3] * own[1];
        q[3] = p[0] * own[3] - p[1] * own[2] + p[2] * own[1] - p[3] * own[0];
    }
    memcpy(c->turn, own, sizeof c->turn);
    if (!body || !name || !mbsri_element_set(arena, body, "name", name) ||
        !mbsri_element_set_numbers(arena, body, "pos", 3, x) ||
        !mbsri_element_set_numbers(arena, body, "quat", 4, q) || !add_shape(c, body, i, length) ||
        !add_cable_joint(c, body, i) || !add_end(c, body, i, length))
        return NULL;
    mbsri_append(parent, body);
    return body;
}

/* ---- composites ---- */

static const char *text_of(const mbsri_element *e, const char *attribute, const char *standard)
{
    const char *value = e ? mbsri_attribute(e, attribute) : NULL;
    return value ? value : standard;
}

static bool write_out(mbsri_mjcf *m, const mbsri_element *e, mbsri_element *all)
{
    mbsri_scene *s = m->s;
    const mbsri_element *shape = mbsri_child(e, "geom"), *plugin = mbsri_child(e, "plugin");
    const char *kind = text_of(e, "type", "");
    cable c = {.m = m,
               .e = e,
               .prefix = text_of(e, "prefix", ""),
               .type = text_of(shape, "type", "sphere"),
               .initial = text_of(e, "initial", "ball")};
    if (strcmp(kind, "cable") != 0)
        return mbsri_file_refuse(s, e, "a composite of type '%.30s' is not read, but cables alone",
                                 kind);
    if (strcmp(c.type, "capsule") != 0 && strcmp(c.type, "cylinder") != 0 &&
        strcmp(c.type, "box") != 0)
        return mbsri_file_refuse(s, e, "its geom is no capsule, cylinder or box");
    if (!mbsri_numbers(s, e, "offset", mbsri_attribute(e, "offset"), 3, 3, c.offset, NULL) ||
        !mbsri_numbers(s, e, "size", text_of(shape, "size", NULL), 1, 3, c.size, NULL) ||
        !read_points(&c))
        return false;
    for (int k = 0; k < 3 * c.points; ++k) c.point[k] = (double)(float)c.point[k]; /* as MuJoCo */
    if (plugin)
        mbsri_file_find(s, plugin, "its force (of '%.60s') is left out",
                        text_of(plugin, "plugin", text_of(plugin, "instance", "")));
    mbsri_element *body = all;
    for (int i = 0; i < c.points - 1 && body; ++i) body = add_cable_body(&c, body, i);
    return body != NULL;
}

static bool expand_composites(mbsri_mjcf *m, mbsri_element *e)
{
    for (mbsri_element *c = e->child, *before = NULL; c; before = c, c = c->next) {
        mbsri_element all = {.child = NULL};
        if (!mbsri_is(c, "composite")) {
            if (!expand_composites(m, c)) return false;
            continue;
        }
        if (!mbsri_mjcf_class_of(m, MBSRI_PLAIN_CLASS, NULL) || !write_out(m, c, &all))
            return false;
        c = mbsri_put_in_place(e, before, c, &all);
    }
    return true;
}

bool mbsri_mjcf_composites(mbsri_mjcf *m, mbsri_element *root)
{
    for (mbsri_element *e = root->child; e; e = e->next)
        if (mbsri_is(e, "worldbody") && !expand_composites(m, e)) return false;
    return true;
}

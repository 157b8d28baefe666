/* Loops of URDF: extensions that several programs share.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * <loop> and <loop_constraint> have places on a predecessor and a successor whose origins coincide;
 * so has <loop_joint>, on link1 and link2. A <coupling> of ratio c relates the joints from the
 * nearest common predecessor p of both links:
 *
 *   c (sum of q from p to the predecessor) = sum of q from p to the successor */
#include "files/names.h"
#include "files/urdf_parts.h"

#include <mbsrank/closure.h>

#include <string.h>

typedef struct loops {
    mbsri_scene *s;
    mbsri_names bodies; /* by name */
} loops;

/* The body that one of these children names, and the child. */
static bool find_end(loops *l, const mbsri_element *e, const char *const names[2], int *body,
                     const mbsri_element **end)
{
    *end = mbsri_child(e, names[0]);
    if (!*end) *end = mbsri_child(e, names[1]);
    const char *link = *end ? mbsri_attribute(*end, "link") : NULL;
    *body = mbsri_names_find(&l->bodies, link);
    return *body >= 0 || mbsri_file_refuse(l->s, e, "its %s '%.50s' is no link of the robot",
                                           names[0], link ? link : "");
}

static bool find_ends(loops *l, const mbsri_element *e, int body[2], const mbsri_element *end[2])
{
    static const char *const names[2][2] = {{"predecessor", "link1"}, {"successor", "link2"}};
    return find_end(l, e, names[0], body, end) && find_end(l, e, names[1], body + 1, end + 1);
}

static mbsri_scene_equality *new_equality(loops *l, const mbsri_element *e,
                                          mbsri_scene_equality_kind kind)
{
    const char *name = mbsri_attribute(e, "name");
    mbsri_scene_equality *q = mbsri_list_add(l->s->arena, &l->s->equalities, sizeof *q);
    if (q) *q = (mbsri_scene_equality){.kind = kind, .name = name ? name : "", .element = e};
    return q;
}

static bool add_loop(loops *l, const mbsri_element *e)
{
    const char *type = mbsri_attribute(e, "type");
    const mbsri_element *end[2];
    int body[2];
    mbsr_frame place[2];
    if (!find_ends(l, e, body, end)) return false;
    if (type && strcmp(type, "revolute") != 0 && strcmp(type, "continuous") != 0 &&
        strcmp(type, "spherical") != 0) {
        mbsri_file_find(l->s, e, "loops of the type '%.30s' are left out", type);
        return true;
    }
    for (int k = 0; k < 2; ++k) {
        const mbsri_element *origin = mbsri_child(end[k], "origin");
        if (!mbsri_urdf_place(l->s, e, origin ? origin : end[k], place + k)) return false;
    }
    mbsri_scene_equality *q = new_equality(l, e, MBSRI_CONNECT);
    if (!q) return false;
    q->at_sites = true;
    memcpy(q->body, body, sizeof q->body);
    memcpy(q->end, place, sizeof q->end);
    return true;
}

/* ---- couplings ---- */

static int depth_of(const mbsri_scene *s, int body)
{
    int depth = 0;
    for (; body >= 0; body = mbsri_scene_bodies(s)[body].parent) ++depth;
    return depth;
}

static int common_of(const mbsri_scene *s, const int body[2])
{
    int at[2] = {body[0], body[1]}, depth[2] = {depth_of(s, at[0]), depth_of(s, at[1])};
    while (at[0] != at[1]) {
        const int deeper = depth[1] > depth[0];
        at[deeper] = mbsri_scene_bodies(s)[at[deeper]].parent;
        --depth[deeper];
    }
    return at[0];
}

/* The joints from a body up to another one; false: one has not one axis, or there are too many. */
static bool add_joints(const mbsri_scene *s, int from, int to, double factor, mbsri_scene_sum *sum)
{
    for (int at = from; at != to; at = mbsri_scene_bodies(s)[at].parent) {
        const mbsri_scene_body *b = mbsri_scene_bodies(s) + at;
        if (b->joints == 0) continue;
        const mbsr_file_joint_kind kind = mbsri_scene_joints(s)[b->first].joint.kind;
        if (b->joints > 1 || (kind != MBSR_FILE_HINGE && kind != MBSR_FILE_SLIDE)) return false;
        if (sum->count == MBSR_CLOSURE_BODIES) return false;
        sum->joint[sum->count] = b->first;
        sum->factor[sum->count++] = factor;
    }
    return true;
}

static bool add_coupling(loops *l, const mbsri_element *e)
{
    const mbsri_element *ratio = mbsri_child(e, "ratio"), *end[2];
    double c = 1.0;
    int body[2];
    mbsri_scene_sum sum = {.count = 0};
    if (!find_ends(l, e, body, end)) return false;
    if (ratio && !mbsri_numbers(l->s, e, "ratio", mbsri_attribute(ratio, "value"), 1, 1, &c, NULL))
        return false;
    const int common = common_of(l->s, body);
    if (!add_joints(l->s, body[0], common, c, &sum) ||
        !add_joints(l->s, body[1], common, -1.0, &sum) || sum.count == 0) {
        mbsri_file_find(
            l->s, e, "it is left out: between its links there are not 1 to %d joints with one axis",
            MBSR_CLOSURE_BODIES);
        return true;
    }
    mbsri_scene_equality *q = new_equality(l, e, MBSRI_SUM);
    if (q) q->sum = sum;
    return q != NULL;
}

bool mbsri_urdf_loops(mbsri_scene *s, const mbsri_element *root)
{
    loops l = {.s = s};
    const mbsri_scene_body *b = mbsri_scene_bodies(s);
    for (int k = 0; k < s->bodies.count; ++k)
        if (!mbsri_names_add(s->arena, &l.bodies, b[k].name, k)) return false;
    for (const mbsri_element *e = root->child; e; e = e->next) {
        const bool loop =
            mbsri_is(e, "loop") || mbsri_is(e, "loop_constraint") || mbsri_is(e, "loop_joint");
        if (loop && !add_loop(&l, e)) return false;
        if (mbsri_is(e, "coupling") && !add_coupling(&l, e)) return false;
    }
    return true;
}

/* The links of SDF as a tree of bodies.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The first joint of the file whose child a link is carries it; a link that none carries is free,
 * or part of the world where its model is static. Any other joint closes a loop: a fixed one by a
 * weld, a ball by its point, all others by a body without mass that hangs on the parent by the
 * joint, and is welded to the child. So does a joint whose child has its parent on it. Bodies come
 * depth first, children in the order of the file. */
#include "files/sdf_parts.h"
#include "files/urdf_parts.h"

#include <string.h>

typedef struct tree {
    mbsri_sdf *f;
    int *first, *loop; /* joints that carry, that close loops: by parent (the last: the world) */
    int *next;         /* of either, by joint */
    int *group;        /* links that are joined so far, by one of them */
    int *cut;          /* by joint, the body that is welded to its child; -1: none */
} tree;

static int group_of(tree *t, int link)
{
    while (t->group[link] != link) link = t->group[link] = t->group[t->group[link]];
    return link;
}

static bool take_arrays(tree *t)
{
    const size_t count = (size_t)t->f->nodes.count + 1;
    int *all = mbsri_arena_take(t->f->s->arena, 5 * count * sizeof *all);
    if (!all) return false;
    t->first = all, t->loop = all + count, t->next = t->loop + count;
    t->group = t->next + count, t->cut = t->group + count;
    for (size_t k = 0; k < 5 * count; ++k) all[k] = -1;
    for (size_t k = 0; k < count; ++k) t->group[k] = (int)k;
    return true;
}

/* ---- which joint carries which link ---- */

static bool find_ends(mbsri_sdf *f, int node)
{
    static const char *const names[2] = {"parent", "child"};
    const mbsri_sdf_node n = mbsri_sdf_nodes(f)[node];
    int end[2];
    for (int k = 0; k < 2; ++k) {
        const char *name = mbsri_text_of(n.element, names[k]);
        if (!name) return mbsri_file_refuse(f->s, n.element, "it has no %s", names[k]);
        if (!mbsri_sdf_link(f, n.element, n.model, name, end + k)) return false;
    }
    if (end[1] < 0) return mbsri_file_refuse(f->s, n.element, "its child is the world");
    if (end[0] == end[1]) return mbsri_file_refuse(f->s, n.element, "it joins a link to itself");
    memcpy(mbsri_sdf_nodes(f)[node].end, end, sizeof end);
    return true;
}

static bool choose_carriers(tree *t)
{
    mbsri_sdf_node *n = mbsri_sdf_nodes(t->f);
    const int world = t->f->nodes.count;
    for (int k = 0; k < t->f->nodes.count; ++k)
        if (n[k].kind == MBSRI_SDF_LINK && n[k].fixed) t->group[k] = world;
    for (int k = 0; k < t->f->nodes.count; ++k) {
        if (n[k].kind != MBSRI_SDF_JOINT) continue;
        if (!find_ends(t->f, k)) return false;
        if (mbsri_sdf_is_gear(n + k)) continue;
        const int parent = group_of(t, n[k].end[0] < 0 ? world : n[k].end[0]), child = n[k].end[1];
        if (n[child].carrier >= 0 || n[child].fixed || group_of(t, child) == parent) continue;
        n[child].carrier = k;
        t->group[child] = parent;
    }
    for (int k = t->f->nodes.count - 1; k >= 0; --k) {
        if (n[k].kind != MBSRI_SDF_JOINT || mbsri_sdf_is_gear(n + k)) continue;
        int *list = (n[n[k].end[1]].carrier == k ? t->first : t->loop) +
                    (n[k].end[0] < 0 ? world : n[k].end[0]);
        t->next[k] = *list;
        *list = k;
    }
    return true;
}

/* ---- bodies ---- */

static mbsri_scene_body *new_body(mbsri_scene *s, const char *name, const mbsri_element *e,
                                  int parent)
{
    mbsri_scene_body *b = mbsri_list_add(s->arena, &s->bodies, sizeof *b);
    if (b)
        *b = (mbsri_scene_body){.name = name,
                                .element = e,
                                .parent = parent,
                                .frame = mbsr_frame_identity(),
                                .inertia = {.kind = MBSR_INERTIA_NOT_GIVEN},
                                .first = s->joints.count};
    return b;
}

/* The frame of a link in that of another one, -1: the world. */
static bool place_on(mbsri_sdf *f, int parent, const mbsr_frame *world, mbsr_frame *frame)
{
    mbsr_frame below;
    if (!mbsri_sdf_world(f, parent, &below)) return false;
    const mbsr_frame back = mbsr_frame_inverse(&below);
    *frame = mbsr_frame_product(&back, world);
    return true;
}

typedef enum closing { CLOSED_BY_WELD, CLOSED_BY_POINT, CLOSED_BY_BODY } closing;

static closing closing_of(const mbsri_sdf_node *n)
{
    const char *type = mbsri_attribute(n->element, "type");
    if (type && strcmp(type, "fixed") == 0) return CLOSED_BY_WELD;
    return type && strcmp(type, "ball") == 0 ? CLOSED_BY_POINT : CLOSED_BY_BODY;
}

/* The bodies without mass on a link, or on the world, by which loops are closed; where their
 * children are as drawn. */
static bool add_cuts(tree *t, int at, int parent)
{
    mbsri_sdf *f = t->f;
    for (int joint = t->loop[at]; joint >= 0; joint = t->next[joint]) {
        const mbsri_sdf_node n = mbsri_sdf_nodes(f)[joint];
        const int body = f->s->bodies.count;
        mbsr_frame world, frame;
        if (closing_of(&n) != CLOSED_BY_BODY) continue;
        mbsri_scene_body *b = new_body(f->s, n.name, n.element, parent);
        if (!b || !mbsri_sdf_world(f, n.end[1], &world) || !place_on(f, n.end[0], &world, &frame) ||
            !mbsri_sdf_joints(f, joint, &world))
            return false;
        b = mbsri_scene_bodies(f->s) + body;
        b->frame = frame;
        b->joints = f->s->joints.count - b->first;
        t->cut[joint] = body;
    }
    return true;
}

/* A link by its joint, freely, or as part of the world. */
static bool add_link(tree *t, int link)
{
    static const double none[3] = {0.0};
    mbsri_sdf *f = t->f;
    mbsri_scene *s = f->s;
    const mbsri_sdf_node n = mbsri_sdf_nodes(f)[link];
    const int carrier = n.carrier, parent = carrier < 0 ? -1 : mbsri_sdf_nodes(f)[carrier].end[0],
              at = s->bodies.count;
    mbsri_scene_body *b =
        new_body(s, n.name, n.element, parent < 0 ? -1 : mbsri_sdf_nodes(f)[parent].body);
    mbsr_frame world, frame;
    if (!b || !mbsri_sdf_world(f, link, &world) || !place_on(f, parent, &world, &frame))
        return false;
    b->frame = frame;
    b->weightless = mbsri_sdf_switch(n.element, "gravity", true) ? 0.0 : 1.0;
    mbsri_sdf_nodes(f)[link].body = at;
    if (carrier >= 0 && !mbsri_sdf_joints(f, carrier, &world)) return false;
    if (carrier < 0 && !n.fixed) {
        mbsri_scene_joint *j = mbsri_urdf_joint(s, n.element, MBSR_FILE_FREE, none);
        if (!j) return false;
        j->joint.name = n.name;
    }
    b = mbsri_scene_bodies(s) + at;
    b->joints = s->joints.count - b->first;
    return mbsri_sdf_inertia(f, n.element, &b->inertia) && mbsri_sdf_shapes(f, link, &world, at) &&
           add_cuts(t, link, at);
}

/* All that hangs on a link, or on the world; the link of the joint that carries it is there. */
static bool add_branches(tree *t, int at)
{
    mbsri_sdf *f = t->f;
    for (int joint = t->first[at]; joint >= 0;) {
        const int child = mbsri_sdf_nodes(f)[joint].end[1];
        if (!add_link(t, child)) return false;
        if (t->first[child] >= 0) {
            joint = t->first[child];
            continue;
        }
        while (joint >= 0 && t->next[joint] < 0) {
            const int below = mbsri_sdf_nodes(f)[joint].end[0];
            joint = below == at || below < 0 ? -1 : mbsri_sdf_nodes(f)[below].carrier;
        }
        if (joint >= 0) joint = t->next[joint];
    }
    return true;
}

/* ---- loops ---- */

static bool add_loop(tree *t, int joint)
{
    mbsri_sdf *f = t->f;
    mbsri_scene *s = f->s;
    const mbsri_sdf_node n = mbsri_sdf_nodes(f)[joint];
    const int child = mbsri_sdf_nodes(f)[n.end[1]].body, cut = t->cut[joint],
              parent = n.end[0] < 0 ? -1 : mbsri_sdf_nodes(f)[n.end[0]].body;
    const bool ball = closing_of(&n) == CLOSED_BY_POINT;
    mbsr_frame own;
    mbsri_scene_equality *q = mbsri_list_add(s->arena, &s->equalities, sizeof *q);
    if (!q || !mbsri_sdf_world(f, joint, &own)) return false;
    *q = (mbsri_scene_equality){.kind = ball ? MBSRI_CONNECT : MBSRI_WELD,
                                .name = n.name,
                                .element = n.element,
                                .body = {cut < 0 ? parent : cut, child},
                                .at_sites = true,
                                .end = {mbsr_frame_identity(), mbsr_frame_identity()}};
    return cut >= 0 ||
           (place_on(f, n.end[0], &own, q->end) && place_on(f, n.end[1], &own, q->end + 1));
}

bool mbsri_sdf_tree(mbsri_sdf *f)
{
    tree t = {.f = f};
    const int world = f->nodes.count;
    if (!take_arrays(&t) || !choose_carriers(&t) || !add_branches(&t, world)) return false;
    for (int k = 0; k < world; ++k) {
        const mbsri_sdf_node *n = mbsri_sdf_nodes(f) + k;
        if (n->kind == MBSRI_SDF_LINK && n->carrier < 0 &&
            !(add_link(&t, k) && add_branches(&t, k)))
            return false;
    }
    if (!add_cuts(&t, world, -1)) return false;
    for (int at = 0; at <= world; ++at)
        for (int joint = t.loop[at]; joint >= 0; joint = t.next[joint])
            if (!add_loop(&t, joint)) return false;
    return true;
}

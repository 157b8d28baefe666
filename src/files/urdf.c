/* URDF: links and joints of a robot.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Direct children of <robot> count alone: transmissions and extensions of simulators have links and
 * joints of their own. Bodies come depth first, children in the order of the file. */
#include "files/colours.h"
#include "files/hulls.h"
#include "files/names.h"
#include "files/numbers.h"
#include "files/solids.h"
#include "files/urdf_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct link {
    const mbsri_element *element;
    const char *name;
    int body;        /* -1: not reached yet */
    int joint;       /* by which it hangs; -1: none */
    int first, last; /* joints that hang on it, -1: none */
} link;

typedef struct hinge {
    const mbsri_element *element;
    int parent, child; /* links */
    int next;          /* of those on the same parent */
    int joint;         /* in the scene, the last of its joints; -1: fixed */
} hinge;

typedef struct named {
    const char *name;
    int link;
} named;

typedef struct robot {
    mbsri_scene *s;
    mbsri_list links, hinges;
    named *order;       /* the links by name */
    mbsri_names joints; /* hinges by name */
    mbsri_looks materials;
} robot;

/* ---- pieces ---- */

static bool read_origin(mbsri_scene *s, const mbsri_element *e, mbsr_frame *frame)
{
    return mbsri_urdf_place(s, e, mbsri_child(e, "origin"), frame);
}

static bool read_value(mbsri_scene *s, const mbsri_element *e, const mbsri_element *of,
                       const char *attribute, double *value)
{
    return !of || mbsri_numbers(s, e, attribute, mbsri_attribute(of, attribute), 1, 1, value, NULL);
}

static bool read_inertia(mbsri_scene *s, const mbsri_element *e, mbsr_inertia *inertia)
{
    static const char *const names[6] = {"ixx", "iyy", "izz", "ixy", "ixz", "iyz"};
    const mbsri_element *inertial = mbsri_child(e, "inertial"),
                        *tensor = mbsri_child(inertial, "inertia");
    double mass = 0.0, I[6] = {0.0};
    mbsr_frame frame;
    *inertia = (mbsr_inertia){.kind = MBSR_INERTIA_NOT_GIVEN};
    if (!inertial) {
        if (mbsri_is(e, "link")) mbsri_file_find(s, e, "it has no <inertial>: zero mass");
        return true;
    }
    if (!read_origin(s, inertial, &frame) ||
        !read_value(s, e, mbsri_child(inertial, "mass"), "value", &mass))
        return false;
    for (int k = 0; k < 6; ++k) {
        if (!read_value(s, e, tensor, names[k], I + k)) return false;
    }
    return mbsri_stated_solid(s, e, mass, &frame, I, inertia);
}

/* ---- shapes ---- */

/* Three numbers, or one for all. */
static bool read_scale(mbsri_scene *s, const mbsri_element *of, double scale[3])
{
    int count;
    if (!mbsri_numbers(s, of, "scale", mbsri_attribute(of, "scale"), 1, 3, scale, &count))
        return false;
    if (count == 1) scale[1] = scale[2] = scale[0];
    return count != 2 || mbsri_file_refuse(s, of, "scale is not 3 numbers");
}

static bool read_geometry(mbsri_scene *s, const mbsri_element *e, mbsr_file_shape *shape,
                          bool *known)
{
    const mbsri_element *geometry = mbsri_child(e, "geometry"),
                        *of = geometry ? geometry->child : NULL;
    double edges[3] = {0.0}, length = 0.0;
    *known = of != NULL;
    if (!of) return true;
    if (mbsri_is(of, "box")) {
        shape->kind = MBSR_SHAPE_BOX;
        if (!mbsri_numbers(s, of, "size", mbsri_attribute(of, "size"), 3, 3, edges, NULL))
            return false;
        for (int k = 0; k < 3; ++k) shape->size[k] = 0.5 * edges[k];
    } else if (mbsri_is(of, "sphere") || mbsri_is(of, "cylinder") || mbsri_is(of, "capsule")) {
        shape->kind = mbsri_is(of, "sphere")     ? MBSR_SHAPE_SPHERE
                      : mbsri_is(of, "cylinder") ? MBSR_SHAPE_CYLINDER
                                                 : MBSR_SHAPE_CAPSULE;
        if (!read_value(s, of, of, "radius", shape->size) ||
            !read_value(s, of, of, "length", &length))
            return false;
        shape->size[1] = 0.5 * length;
    } else if (mbsri_is(of, "mesh")) {
        shape->kind = MBSR_SHAPE_MESH;
        shape->mesh = mbsri_package_path(s, mbsri_attribute(of, "filename"));
        shape->size[0] = shape->size[1] = shape->size[2] = 1.0;
        *known = shape->mesh != NULL;
        return read_scale(s, of, shape->size);
    } else {
        mbsri_file_find(s, of, "a shape of this kind is not drawn");
        *known = false;
    }
    return true;
}

static bool read_shapes(mbsri_scene *s, const mbsri_element *e, int body,
                        const mbsri_looks *materials)
{
    for (const mbsri_element *c = e->child; c; c = c->next) {
        const bool visual = mbsri_is(c, "visual");
        if (!visual && !mbsri_is(c, "collision")) continue;
        mbsr_file_shape shape = {.name = mbsri_attribute(c, "name"),
                                 .body = body,
                                 .colour = {0.7, 0.7, 0.7, 1.0},
                                 .visual = visual,
                                 .contact = !visual,
                                 .groups = 1,
                                 .mask = 1,
                                 .friction = {1.0, 0.0, 0.0},
                                 .settle = {0.02, 1.0}};
        bool known;
        if (!shape.name) shape.name = "";
        if (!read_origin(s, c, &shape.frame) || !read_geometry(s, c, &shape, &known) ||
            !mbsri_urdf_colour(s, c, materials, &shape))
            return false;
        if (!known) continue;
        if (!mbsri_hull_shape(s, c, &shape)) return false;
        mbsr_file_shape *place = mbsri_list_add(s->arena, &s->shapes, sizeof *place);
        if (!place) return false;
        *place = shape;
    }
    return true;
}

/* ---- the tree ---- */

static int compare_names(const void *a, const void *b)
{
    return strcmp(((const named *)a)->name, ((const named *)b)->name);
}

static int find_link(const robot *r, const char *name)
{
    const named key = {.name = name};
    const named *found =
        bsearch(&key, r->order, (size_t)r->links.count, sizeof *r->order, compare_names);
    return found ? found->link : -1;
}

/* e: where it stands, or a joint for one that is not declared. */
static bool add_link(robot *r, const mbsri_element *e, const char *name)
{
    if (!name || !name[0]) return mbsri_file_refuse(r->s, e, "it has no name");
    link *l = mbsri_list_add(r->s->arena, &r->links, sizeof *l);
    if (l)
        *l = (link){.element = e, .name = name, .body = -1, .joint = -1, .first = -1, .last = -1};
    return l != NULL;
}

/* The link `world`, which need not be declared, where joints hang on it. */
static bool add_world(robot *r, const mbsri_element *root)
{
    for (const mbsri_element *e = mbsri_child(root, "link"); e; e = mbsri_next(e)) {
        const char *name = mbsri_attribute(e, "name");
        if (name && strcmp(name, "world") == 0) return true;
    }
    for (const mbsri_element *e = mbsri_child(root, "joint"); e; e = mbsri_next(e)) {
        const mbsri_element *parent = mbsri_child(e, "parent");
        const char *name = parent ? mbsri_attribute(parent, "link") : NULL;
        if (name && strcmp(name, "world") == 0) return add_link(r, e, name);
    }
    return true;
}

static bool sort_links(robot *r)
{
    const link *links = r->links.items;
    const int count = r->links.count;
    r->order = mbsri_arena_take(r->s->arena, (size_t)count * sizeof *r->order);
    if (!r->order) return false;
    for (int k = 0; k < count; ++k) r->order[k] = (named){links[k].name, k};
    qsort(r->order, (size_t)count, sizeof *r->order, compare_names);
    for (int k = 1; k < count; ++k) {
        if (compare_names(r->order + k - 1, r->order + k) == 0)
            return mbsri_file_refuse(r->s, links[r->order[k].link].element,
                                     "there are two links of that name");
    }
    return true;
}

/* The link that a joint names. */
static bool end_of(robot *r, const mbsri_element *e, const char *end, int *number)
{
    const mbsri_element *of = mbsri_child(e, end);
    const char *name = of ? mbsri_attribute(of, "link") : NULL;
    if (!name) return mbsri_file_refuse(r->s, e, "it has no <%s link>", end);
    *number = find_link(r, name);
    return *number >= 0 ||
           mbsri_file_refuse(r->s, e, "its %s '%.50s' is no link of the robot", end, name);
}

static bool add_hinge(robot *r, const mbsri_element *e)
{
    hinge h = {.element = e, .next = -1, .joint = -1};
    const int number = r->hinges.count;
    if (!mbsri_attribute(e, "name")) return mbsri_file_refuse(r->s, e, "it has no name");
    if (!end_of(r, e, "parent", &h.parent) || !end_of(r, e, "child", &h.child)) return false;
    link *links = r->links.items, *parent = links + h.parent, *child = links + h.child;
    if (child->joint >= 0)
        return mbsri_file_refuse(r->s, e, "its child '%.50s' hangs on another joint, too",
                                 child->name);
    hinge *place = mbsri_list_add(r->s->arena, &r->hinges, sizeof *place);
    if (!place) return false;
    *place = h;
    child->joint = number;
    if (parent->last >= 0)
        ((hinge *)r->hinges.items)[parent->last].next = number;
    else
        parent->first = number;
    parent->last = number;
    return true;
}

/* Where a name is there twice the first joint has it. */
static bool name_hinges(robot *r)
{
    const hinge *hinges = r->hinges.items;
    for (int k = 0; k < r->hinges.count; ++k) {
        const char *name = mbsri_attribute(hinges[k].element, "name");
        if (mbsri_names_find(&r->joints, name) >= 0)
            mbsri_file_find(r->s, hinges[k].element, "another joint has this name, too");
        else if (!mbsri_names_add(r->s->arena, &r->joints, name, k))
            return false;
    }
    return true;
}

/* ---- joints ---- */

static bool read_limits(mbsri_scene *s, const mbsri_element *e, bool continuous,
                        mbsri_scene_joint *j)
{
    const mbsri_element *limit = mbsri_child(e, "limit"), *dynamics = mbsri_child(e, "dynamics");
    if (!read_value(s, e, limit, "lower", j->joint.range) ||
        !read_value(s, e, limit, "upper", j->joint.range + 1) ||
        !read_value(s, e, dynamics, "damping", &j->damping) ||
        !read_value(s, e, dynamics, "friction", &j->joint.friction))
        return false;
    const bool ranged = limit && !continuous;
    j->joint.limited = ranged && j->joint.range[0] < j->joint.range[1];
    if (ranged && j->joint.range[0] > j->joint.range[1])
        mbsri_file_find(s, e, "its limits are left out: lower is above upper");
    return true;
}

/* A joint with one axis. */
static bool add_axis(mbsri_scene *s, const mbsri_element *e, mbsr_file_joint_kind kind,
                     bool continuous)
{
    const mbsri_element *axis = mbsri_child(e, "axis");
    double a[3] = {1.0, 0.0, 0.0};
    if (axis && !mbsri_numbers(s, e, "xyz", mbsri_attribute(axis, "xyz"), 3, 3, a, NULL))
        return false;
    const double length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    if (!(length > 0.0) || !isfinite(length))
        return mbsri_file_refuse(s, e, "its axis has no direction");
    for (int k = 0; k < 3; ++k) a[k] /= length;
    mbsri_scene_joint *j = mbsri_urdf_joint(s, e, kind, a);
    return j && read_limits(s, e, continuous, j);
}

/* Slides along two directions across the axis and turns about it. */
static bool add_planar(mbsri_scene *s, const mbsri_element *e)
{
    const mbsri_element *axis = mbsri_child(e, "axis");
    double a[3] = {1.0, 0.0, 0.0};
    if (axis && !mbsri_numbers(s, e, "xyz", mbsri_attribute(axis, "xyz"), 3, 3, a, NULL))
        return false;
    if (a[0] == 0.0 && a[1] == 0.0 && a[2] == 0.0)
        return mbsri_file_refuse(s, e, "its axis has no direction");
    const mbsr_frame along = mbsr_frame_along(NULL, a);
    for (int k = 0; k < 3; ++k) {
        mbsri_scene_joint *j =
            mbsri_urdf_joint(s, e, k < 2 ? MBSR_FILE_SLIDE : MBSR_FILE_HINGE, along.R + 3 * k);
        if (!j || !read_limits(s, e, true, j)) return false;
    }
    return true;
}

static bool add_ball(mbsri_scene *s, const mbsri_element *e)
{
    static const double none[3] = {0.0};
    mbsri_scene_joint *j = mbsri_urdf_joint(s, e, MBSR_FILE_BALL, none);
    return j && read_limits(s, e, true, j);
}

static bool add_floating(mbsri_scene *s, const mbsri_element *e)
{
    static const double none[3] = {0.0};
    mbsri_scene_joint *j = mbsri_urdf_joint(s, e, MBSR_FILE_FREE, none);
    if (j) j->relative = true;
    return j != NULL;
}

/* The joints of a hinge into the scene, *added of them. */
static bool add_joints(mbsri_scene *s, const mbsri_element *e, int *added)
{
    const char *type = mbsri_attribute(e, "type");
    const int before = s->joints.count;
    bool good = true;
    if (!type) return mbsri_file_refuse(s, e, "it has no type");
    if (strcmp(type, "revolute") == 0)
        good = add_axis(s, e, MBSR_FILE_HINGE, false);
    else if (strcmp(type, "continuous") == 0)
        good = add_axis(s, e, MBSR_FILE_HINGE, true);
    else if (strcmp(type, "prismatic") == 0)
        good = add_axis(s, e, MBSR_FILE_SLIDE, false);
    else if (strcmp(type, "planar") == 0)
        good = add_planar(s, e);
    else if (strcmp(type, "floating") == 0)
        good = add_floating(s, e);
    else if (strcmp(type, "ball") == 0 || strcmp(type, "spherical") == 0)
        good = add_ball(s, e);
    else if (strcmp(type, "fixed") != 0)
        return mbsri_file_refuse(s, e, "there is no type '%.40s'", type);
    *added = s->joints.count - before;
    return good;
}

/* Link number `at` as a body on its parent's. */
static bool add_body(robot *r, int at)
{
    mbsri_scene *s = r->s;
    link *l = (link *)r->links.items + at;
    hinge *h = l->joint < 0 ? NULL : (hinge *)r->hinges.items + l->joint;
    mbsri_scene_body b = {.name = l->name,
                          .element = l->element,
                          .parent = h ? ((link *)r->links.items)[h->parent].body : -1,
                          .frame = mbsr_frame_identity(),
                          .first = s->joints.count};
    l->body = s->bodies.count;
    if (h) {
        if (!read_origin(s, h->element, &b.frame) || !add_joints(s, h->element, &b.joints))
            return false;
        if (b.joints == 1) h->joint = b.first;
    } else if (s->opt->floating) {
        static const double none[3] = {0.0};
        mbsri_scene_joint *j = mbsri_urdf_joint(s, l->element, MBSR_FILE_FREE, none);
        if (!j) return false;
        j->joint.name = "root";
        b.joints = 1;
    }
    if (!read_inertia(s, l->element, &b.inertia) ||
        !read_shapes(s, l->element, l->body, &r->materials))
        return false;
    mbsri_scene_body *place = mbsri_list_add(s->arena, &s->bodies, sizeof *place);
    if (place) *place = b;
    return place != NULL;
}

/* The joint to go on with from link `at`: its first, else the next one up the tree; -1: none. */
static int follow(const robot *r, int at)
{
    const link *links = r->links.items;
    const hinge *hinges = r->hinges.items;
    if (links[at].first >= 0) return links[at].first;
    while (links[at].joint >= 0) {
        const hinge *h = hinges + links[at].joint;
        if (h->next >= 0) return h->next;
        at = h->parent;
    }
    return -1;
}

static bool add_tree(robot *r)
{
    mbsri_scene *s = r->s;
    const link *links = r->links.items;
    int root = -1;
    for (int k = 0; k < r->links.count; ++k) {
        if (links[k].joint >= 0) continue;
        if (root >= 0)
            return mbsri_file_refuse(s, links[k].element,
                                     "there is a second root: '%.50s' is one, too",
                                     links[root].name);
        root = k;
    }
    if (root < 0)
        return mbsri_file_refuse(s, links->element, "the joints form a cycle: there is no root");
    if (!add_body(r, root)) return false;
    for (int h = follow(r, root); h >= 0;) {
        const int child = ((const hinge *)r->hinges.items)[h].child;
        if (!add_body(r, child)) return false;
        h = follow(r, child);
    }
    for (int k = 0; k < r->links.count; ++k) {
        if (links[k].body < 0)
            return mbsri_file_refuse(s, links[k].element, "it hangs on a cycle of joints");
    }
    return true;
}

/* ---- mimicking joints ---- */

static bool add_mimic(robot *r, const hinge *h, const mbsri_element *mimic)
{
    mbsri_scene *s = r->s;
    const hinge *hinges = r->hinges.items;
    const char *of = mbsri_attribute(mimic, "joint");
    double factor = 1.0, offset = 0.0;
    if (!read_value(s, h->element, mimic, "multiplier", &factor) ||
        !read_value(s, h->element, mimic, "offset", &offset))
        return false;
    if (!of)
        return mbsri_file_refuse(s, h->element, "it mimics no joint: there is no attribute joint");
    const int other = mbsri_names_find(&r->joints, of);
    if (other < 0)
        return mbsri_file_refuse(s, h->element, "it mimics '%.50s', which is no joint", of);
    if (hinges + other == h) return mbsri_file_refuse(s, h->element, "it mimics itself");
    if (h->joint < 0 || hinges[other].joint < 0) {
        mbsri_file_find(s, h->element,
                        "mimicking is left out: one of both joints has not one axis");
        return true;
    }
    mbsri_scene_equality *q = mbsri_list_add(s->arena, &s->equalities, sizeof *q);
    if (!q) return false;
    *q = (mbsri_scene_equality){.kind = MBSRI_POLYNOMIAL,
                                .name = mbsri_attribute(h->element, "name"),
                                .element = h->element,
                                .joint = {h->joint, hinges[other].joint},
                                .power = {offset, factor}};
    return true;
}

/* Elements that are neither of URDF nor of the usual extensions, which say nothing of a model's
 * motion. */
static void find_others(mbsri_scene *s, const mbsri_element *root)
{
    static const char *const known[][14] = {
        {"robot", "link", "joint", "transmission", "gazebo", "material", "mujoco", "sensor",
         "ros2_control", "loop", "loop_constraint", "loop_joint", "coupling", NULL},
        {"link", "inertial", "visual", "collision", NULL},
        {"joint", "origin", "axis", "parent", "child", "limit", "dynamics", "mimic",
         "safety_controller", NULL},
    };
    for (const mbsri_element *e = root; e; e = e == root ? root->child : e->next) {
        for (size_t k = 0; k < sizeof known / sizeof *known; ++k) {
            if (!mbsri_is(e, known[k][0])) continue;
            for (const mbsri_element *c = e->child; c; c = c->next) {
                bool found = mbsri_is(c, "calibration");
                for (const char *const *word = known[k] + 1; *word && !found; ++word)
                    found = mbsri_is(c, *word);
                if (!found)
                    mbsri_file_find(s, c, "elements of this kind are left out, with all in them");
            }
        }
    }
}

/* Elements and attributes of xacro anywhere. */
static bool refuse_xacro(mbsri_scene *s, const mbsri_element *e)
{
    for (const mbsri_element *at = e; at;) {
        if (strncmp(at->name, "xacro:", 6) == 0)
            return mbsri_file_refuse(s, at,
                                     "this is xacro, but the root does not declare xmlns:xacro");
        for (const char **a = at->attribute; *a; a += 2) {
            if (strstr(a[1], "${"))
                return mbsri_file_refuse(s, at,
                                         "%s=\"%.40s\" is xacro, but the root does not declare "
                                         "xmlns:xacro",
                                         a[0], a[1]);
        }
        if (at->child) {
            at = at->child;
            continue;
        }
        while (at != e && !at->next) at = at->parent;
        at = at == e ? NULL : at->next;
    }
    return true;
}

bool mbsri_urdf_read(mbsri_scene *s, const mbsri_element *root)
{
    robot r = {.s = s};
    const char *name = mbsri_attribute(root, "name");
    s->name = name ? name : "";
    if (!refuse_xacro(s, root) || !mbsri_urdf_looks(s, root, &r.materials)) return false;
    find_others(s, root);
    for (const mbsri_element *e = mbsri_child(root, "link"); e; e = mbsri_next(e)) {
        if (!add_link(&r, e, mbsri_attribute(e, "name"))) return false;
    }
    if (r.links.count == 0) return mbsri_file_refuse(s, root, "the robot has no links");
    if (!add_world(&r, root) || !sort_links(&r)) return false;
    for (const mbsri_element *e = mbsri_child(root, "joint"); e; e = mbsri_next(e)) {
        if (!add_hinge(&r, e)) return false;
    }
    if (!name_hinges(&r) || !add_tree(&r)) return false;
    const hinge *hinges = r.hinges.items;
    for (int k = 0; k < r.hinges.count; ++k) {
        const mbsri_element *mimic = mbsri_child(hinges[k].element, "mimic");
        if (mimic && !add_mimic(&r, hinges + k, mimic)) return false;
    }
    return mbsri_urdf_loops(s, root);
}

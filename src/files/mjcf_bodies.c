/* Bodies of MJCF with their joints, inertias, shapes and sites.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/colours.h"
#include "files/mesh.h"
#include "files/mjcf_parts.h"
#include "files/solids.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Where elements stand. */
typedef struct place {
    int body;                /* index; -1: the world */
    const mbsr_frame *frame; /* of <frame> elements around, in the body */
    const char *childclass;
} place;

/* What shapes give a body whose inertia they make. */
typedef struct shapes {
    mbsr_inertia inertia;
    bool some;
} shapes;

static const char *name_of(const mbsri_element *e)
{
    const char *name = mbsri_attribute(e, "name");
    return name ? name : "";
}

/* Gives its name, if it has one, to a number. */
static bool enter(mbsri_mjcf *m, const mbsri_element *e, mbsri_names *names, int number)
{
    const char *name = name_of(e);
    if (!name[0]) return true;
    if (mbsri_names_find(names, name) >= 0)
        return mbsri_file_refuse(m->s, e, "there are two of that name");
    return mbsri_names_add(m->s->arena, names, name, number);
}

/* ---- joints ---- */

static bool kind_of(mbsri_mjcf *m, const mbsri_node *node, mbsr_file_joint_kind *kind)
{
    const char *type = mbsri_mjcf_get(node, "type");
    *kind = MBSR_FILE_HINGE;
    if (!type || strcmp(type, "hinge") == 0) return true;
    *kind = strcmp(type, "slide") == 0  ? MBSR_FILE_SLIDE
            : strcmp(type, "ball") == 0 ? MBSR_FILE_BALL
                                        : MBSR_FILE_FREE;
    return *kind != MBSR_FILE_FREE || strcmp(type, "free") == 0 ||
           mbsri_file_refuse(m->s, node->e, "there is no type '%.40s'", type);
}

static bool read_joint(mbsri_mjcf *m, const mbsri_node *node, const mbsr_frame *frame,
                       mbsri_scene_joint *j)
{
    const double unit = m->radian ? 1.0 : 3.14159265358979323846 / 180.0;
    double axis[3] = {0.0, 0.0, 1.0}, anchor[3] = {0.0};
    int ranged;
    if (!kind_of(m, node, &j->joint.kind)) return false;
    if (!mbsri_mjcf_numbers(m, node, "axis", 3, 3, axis, NULL) ||
        !mbsri_mjcf_numbers(m, node, "pos", 3, 3, anchor, NULL) ||
        !mbsri_mjcf_number(m, node, "ref", &j->joint.ref) ||
        !mbsri_mjcf_number(m, node, "springref", &j->rest) ||
        !mbsri_mjcf_number(m, node, "stiffness", &j->stiffness) ||
        !mbsri_mjcf_number(m, node, "damping", &j->damping) ||
        !mbsri_mjcf_number(m, node, "armature", &j->armature) ||
        !mbsri_mjcf_number(m, node, "frictionloss", &j->joint.friction) ||
        !mbsri_mjcf_numbers(m, node, "range", 2, 2, j->joint.range, &ranged))
        return false;
    const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    if (!(length > 0.0)) return mbsri_file_refuse(m->s, node->e, "its axis has no direction");
    if (j->armature < 0.0) return mbsri_file_refuse(m->s, node->e, "its armature is negative");
    for (int k = 0; k < 3; ++k) {
        j->axis[k] = j->anchor[k] = 0.0;
        for (int l = 0; l < 3; ++l) {
            j->axis[k] += frame->R[3 * l + k] * axis[l] / length;
            j->anchor[k] += frame->R[3 * l + k] * anchor[l];
        }
        j->anchor[k] += frame->x[k];
    }
    if (j->joint.kind == MBSR_FILE_HINGE || j->joint.kind == MBSR_FILE_BALL) {
        j->joint.range[0] *= unit;
        j->joint.range[1] *= unit;
    }
    if (j->joint.kind == MBSR_FILE_HINGE) j->joint.ref *= unit, j->rest *= unit;
    if (j->joint.kind == MBSR_FILE_BALL || j->joint.kind == MBSR_FILE_FREE)
        j->joint.ref = j->rest = 0.0;
    j->joint.limited = mbsri_mjcf_switch(node, "limited", ranged > 0 && m->autolimits);
    if (mbsri_mjcf_get(node, "springdamper"))
        mbsri_file_find(m->s, node->e, "springdamper is left out");
    if (mbsri_mjcf_switch(node, "actuatorfrclimited",
                          m->autolimits && mbsri_mjcf_get(node, "actuatorfrcrange")))
        mbsri_file_find(m->s, node->e, "forces of actuators are not limited to actuatorfrcrange");
    return true;
}

static bool add_joint(mbsri_mjcf *m, const mbsri_element *e, const place *at)
{
    mbsri_scene *s = m->s;
    mbsri_scene_body *b = mbsri_scene_bodies(s) + at->body;
    mbsri_scene_joint j = {.element = e, .joint = {.name = name_of(e), .kind = MBSR_FILE_FREE}};
    if (at->body < 0) return mbsri_file_refuse(s, e, "the world has no joints");
    if (!enter(m, e, &m->joints, s->joints.count)) return false;
    if (mbsri_is(e, "joint")) {
        mbsri_node node;
        if (!mbsri_mjcf_node(m, e, "joint", at->childclass, &node) ||
            !read_joint(m, &node, at->frame, &j))
            return false;
    }
    const bool free = j.joint.kind == MBSR_FILE_FREE;
    const mbsri_scene_joint *first = mbsri_scene_joints(s) + b->first;
    if ((free && b->joints > 0) || (b->joints > 0 && first->joint.kind == MBSR_FILE_FREE))
        return mbsri_file_refuse(s, e, "a free joint stands alone on its body");
    if (free && b->parent >= 0)
        return mbsri_file_refuse(s, e, "a free joint is for bodies of the world");
    mbsri_scene_joint *joint = mbsri_list_add(s->arena, &s->joints, sizeof *joint);
    if (!joint) return false;
    *joint = j;
    ++b->joints;
    return true;
}

/* ---- inertias ---- */

static bool read_inertial(mbsri_mjcf *m, const mbsri_element *e, mbsr_inertia *inertia)
{
    const mbsri_node node = {.e = e};
    mbsr_frame frame;
    double mass = 0.0, I[6] = {0.0}, moments[3];
    int diagonal, full;
    if (!mbsri_mjcf_frame(m, &node, &frame) || !mbsri_mjcf_number(m, &node, "mass", &mass) ||
        !mbsri_mjcf_numbers(m, &node, "diaginertia", 3, 3, I, &diagonal) ||
        !mbsri_mjcf_numbers(m, &node, "fullinertia", 6, 6, I, &full))
        return false;
    if (mass < 0.0) return mbsri_file_refuse(m->s, e, "its mass is negative");
    if (diagonal && full)
        return mbsri_file_refuse(m->s, e, "it has two tensors, diaginertia and fullinertia");
    mbsri_moments(I, moments);
    if (moments[0] < -1e-6 * fabs(moments[2]))
        mbsri_file_find(m->s, e, "a principal moment of inertia is negative; kept as it is");
    else if (moments[2] > (1.0 + 1e-6) * (moments[0] + moments[1]))
        mbsri_file_find(m->s, e,
                        "no body has these moments of inertia (one is larger than the sum "
                        "of the others); kept as they are");
    *inertia = mbsri_solid(m->s->arena, mass, &frame, I);
    return true;
}

/* ---- shapes ---- */

static bool shape_kind(mbsri_mjcf *m, const mbsri_node *node, mbsr_shape_kind *kind, bool *known)
{
    static const char *const names[] = {"box",       "sphere", "cylinder", "capsule",
                                        "ellipsoid", "plane",  "mesh"};
    const char *type = mbsri_mjcf_get(node, "type");
    *known = true;
    *kind = mbsri_mjcf_get(node, "mesh") ? MBSR_SHAPE_MESH : MBSR_SHAPE_SPHERE;
    if (!type) return true;
    for (int k = 0; k < 7; ++k) {
        if (strcmp(type, names[k]) != 0) continue;
        *kind = (mbsr_shape_kind)k;
        return true;
    }
    *known = false;
    if (strcmp(type, "hfield") != 0 && strcmp(type, "sdf") != 0)
        return mbsri_file_refuse(m->s, node->e, "there is no type '%.40s'", type);
    mbsri_file_find(m->s, node->e, "a shape of type '%.10s' is left out", type);
    return true;
}

/* Sizes, and the frame of one that is given from end to end. */
static bool read_size(mbsri_mjcf *m, const mbsri_node *node, mbsr_file_shape *shape)
{
    static const int least[] = {3, 1, 2, 2, 3, 0, 0};
    double ends[6], along[3], length = 0.0, middle[3];
    int given, count;
    const bool ended = shape->kind == MBSR_SHAPE_CAPSULE || shape->kind == MBSR_SHAPE_CYLINDER ||
                       shape->kind == MBSR_SHAPE_BOX || shape->kind == MBSR_SHAPE_ELLIPSOID;
    if (!mbsri_mjcf_numbers(m, node, "size", 0, 3, shape->size, &count) ||
        !mbsri_mjcf_numbers(m, node, "fromto", 6, 6, ends, &given))
        return false;
    if (given && ended) {
        for (int k = 0; k < 3; ++k) {
            along[k] = ends[k] - ends[3 + k];
            middle[k] = 0.5 * (ends[k] + ends[3 + k]);
            length += along[k] * along[k];
        }
        if (!(length > 0.0)) return mbsri_file_refuse(m->s, node->e, "fromto has no length");
        const bool round = shape->kind == MBSR_SHAPE_CAPSULE || shape->kind == MBSR_SHAPE_CYLINDER;
        shape->frame = mbsri_mjcf_along(middle, along);
        if (!round) shape->size[1] = shape->size[0];
        shape->size[round ? 1 : 2] = 0.5 * sqrt(length);
        return count > 0 || mbsri_file_refuse(m->s, node->e, "it has no size");
    }
    for (int k = 0; k < least[shape->kind]; ++k) {
        if (!(shape->size[k] > 0.0))
            return mbsri_file_refuse(m->s, node->e, "its size must be %d positive number%s",
                                     least[shape->kind], least[shape->kind] > 1 ? "s" : "");
    }
    return true;
}

/* The <mesh> of that name, which may be that of its file without ending; NULL: none. */
static const mbsri_element *find_mesh(const mbsri_mjcf *m, const char *name)
{
    const mbsri_element *const *meshes = m->meshes.items;
    for (int k = 0; name && k < m->meshes.count; ++k) {
        const char *own = mbsri_attribute(meshes[k], "name"),
                   *file = mbsri_attribute(meshes[k], "file");
        const char *last = file ? strrchr(file, '/') : NULL;
        if (last) file = last + 1;
        const size_t length = strlen(name);
        if (own ? strcmp(own, name) == 0
                : file && strncmp(file, name, length) == 0 && file[length] == '.')
            return meshes[k];
    }
    return NULL;
}

/* Its file, with the folder of meshes; NULL: it has none. */
static const char *mesh_path(const mbsri_mjcf *m, const mbsri_element *mesh)
{
    const char *file = mesh ? mbsri_attribute(mesh, "file") : NULL;
    char path[512];
    const char *last = file && m->strip ? strrchr(file, '/') : NULL;
    if (last) file = last + 1;
    if (!file || !m->folder || file[0] == '/') return file;
    const int length = snprintf(path, sizeof path, "%.250s/%.250s", m->folder, file);
    return mbsri_arena_text(m->s->arena, path, (size_t)length);
}

/* Volume, centre and tensor of a mesh; *known: it has them, else there is a finding. */
static bool measure_mesh(mbsri_mjcf *m, const mbsri_element *e, const char *name, double *volume,
                         double centre[3], double tensor[6], bool *known)
{
    const mbsri_element *mesh = find_mesh(m, name);
    const char *file = mesh_path(m, mesh), *text, *wrong = "there is no such file";
    double scale[3] = {1.0, 1.0, 1.0};
    mbsri_node node;
    char path[512];
    size_t size;
    int reason = 1;
    *known = false;
    if (mesh && (!mbsri_mjcf_node(m, mesh, "mesh", NULL, &node) ||
                 !mbsri_mjcf_numbers(m, &node, "scale", 3, 3, scale, NULL)))
        return false;
    snprintf(path, sizeof path, "%.250s%.250s", file && file[0] == '/' ? "" : m->home,
             file ? file : "");
    const char *inertia = mesh ? mbsri_mjcf_get(&node, "inertia") : NULL;
    if (inertia && strcmp(inertia, "shell") == 0)
        wrong = "it is a shell";
    else if (mesh && (mbsri_attribute(mesh, "refpos") || mbsri_attribute(mesh, "refquat")))
        wrong = "refpos and refquat are not read";
    else if (file && m->s->opt->load)
        reason = m->s->opt->load(m->s->opt->user, path, &text, &size);
    if (reason == 0)
        wrong = mbsri_mesh_solid(m->s->arena, text, size, scale, volume, centre, tensor);
    *known = wrong == NULL;
    if (wrong)
        mbsri_file_find(m->s, e,
                        "the mass of mesh '%.40s' is left out, its body has no <inertial>: %s%s%s",
                        name ? name : "", wrong, reason > 1 ? ": " : "", mbsri_file_why(reason));
    return true;
}

/* Its part of the inertia of the body, where `sum` is given. */
static bool weigh(mbsri_mjcf *m, const mbsri_node *node, const mbsr_file_shape *shape, shapes *sum)
{
    double density = 1000.0, mass = 0.0, group = 0.0, volume, I[6];
    int given;
    if (!mbsri_mjcf_number(m, node, "density", &density) ||
        !mbsri_mjcf_number(m, node, "group", &group) ||
        !mbsri_mjcf_numbers(m, node, "mass", 1, 1, &mass, &given))
        return false;
    if (mass < 0.0 || density < 0.0)
        return mbsri_file_refuse(m->s, node->e, "its mass or density is negative");
    if (sum && mbsri_mjcf_switch(node, "shellinertia", false))
        mbsri_file_find(m->s, node->e, "its inertia is that of a solid, not of a shell");
    if (!sum || group < m->groups[0] || group > m->groups[1]) return true;
    mbsr_frame frame = shape->frame;
    if (shape->kind == MBSR_SHAPE_MESH) {
        double centre[3];
        bool known;
        if ((given ? mass : density) == 0.0) return true;
        if (!measure_mesh(m, node->e, mbsri_mjcf_get(node, "mesh"), &volume, centre, I, &known))
            return false;
        if (!known) return true;
        const mbsr_frame at_centre = mbsr_frame_at(centre[0], centre[1], centre[2]);
        frame = mbsr_frame_product(&frame, &at_centre);
    } else if (!mbsri_shape_solid(shape->kind, shape->size, &volume, I) || !(volume > 0.0)) {
        return true;
    }
    const double factor = given ? mass / volume : density;
    if (factor == 0.0) return true;
    for (int k = 0; k < 6; ++k) I[k] *= factor;
    const mbsr_inertia own = mbsri_solid(m->s->arena, factor * volume, &frame, I);
    sum->inertia = sum->some ? mbsr_inertia_sum(sum->inertia, own) : own;
    sum->some = true;
    return true;
}

/* Groups above 2 are those that MuJoCo does not show at first. */
static bool find_use(mbsri_mjcf *m, const mbsri_node *node, mbsr_file_shape *shape)
{
    double group = 0.0, type = 1.0, affinity = 1.0;
    if (!mbsri_mjcf_number(m, node, "group", &group) ||
        !mbsri_mjcf_number(m, node, "contype", &type) ||
        !mbsri_mjcf_number(m, node, "conaffinity", &affinity))
        return false;
    shape->visual = group <= 2.0;
    shape->contact = type != 0.0 || affinity != 0.0;
    return true;
}

static bool add_shape(mbsri_mjcf *m, const mbsri_element *e, const place *at, shapes *sum)
{
    mbsr_file_shape shape = {.name = name_of(e), .body = at->body, .colour = {0.5, 0.5, 0.5, 1.0}};
    mbsri_node node;
    bool known;
    if (!mbsri_mjcf_node(m, e, "geom", at->childclass, &node) ||
        !shape_kind(m, &node, &shape.kind, &known))
        return false;
    if (!known) return true;
    if (!mbsri_mjcf_frame(m, &node, &shape.frame) || !read_size(m, &node, &shape) ||
        !mbsri_mjcf_colour(m, &node, &shape) || !find_use(m, &node, &shape))
        return false;
    shape.frame = mbsr_frame_product(at->frame, &shape.frame);
    if (shape.kind == MBSR_SHAPE_MESH)
        shape.mesh = mesh_path(m, find_mesh(m, mbsri_mjcf_get(&node, "mesh")));
    if (!weigh(m, &node, &shape, sum)) return false;
    mbsr_file_shape *to = mbsri_list_add(m->s->arena, &m->s->shapes, sizeof *to);
    if (to) *to = shape;
    return to != NULL;
}

static bool add_site(mbsri_mjcf *m, const mbsri_element *e, const place *at)
{
    mbsri_node node;
    mbsr_frame frame;
    if (!mbsri_mjcf_node(m, e, "site", at->childclass, &node) ||
        !mbsri_mjcf_frame(m, &node, &frame) || !enter(m, e, &m->sites, m->s->sites.count))
        return false;
    mbsr_file_site *site = mbsri_list_add(m->s->arena, &m->s->sites, sizeof *site);
    if (!site) return false;
    *site = (mbsr_file_site){name_of(e), at->body, mbsr_frame_product(at->frame, &frame)};
    return true;
}

/* ---- bodies ---- */

static bool add_children(mbsri_mjcf *m, const mbsri_element *e, const place *at, shapes *sum);

static bool add_bodies(mbsri_mjcf *m, const mbsri_element *e, const place *at);

/* What is not part of a body: bodies come later, so that its joints stand together. */
static bool add_child(mbsri_mjcf *m, const mbsri_element *e, const place *at, shapes *sum)
{
    static const char *const others[] = {"inertial", "camera", "light"};
    bool known = false;
    if (mbsri_is(e, "joint") || mbsri_is(e, "freejoint")) return add_joint(m, e, at);
    if (mbsri_is(e, "geom")) return add_shape(m, e, at, sum);
    if (mbsri_is(e, "site")) return add_site(m, e, at);
    for (int k = 0; k < 3; ++k) known = known || mbsri_is(e, others[k]);
    if (!known) mbsri_file_find(m->s, e, "elements of this kind are left out, with all in them");
    return true;
}

/* Where the elements in a <frame> stand. */
static bool step_into(mbsri_mjcf *m, const mbsri_element *e, const place *at, mbsr_frame *frame,
                      place *within)
{
    const mbsri_node node = {.e = e};
    const char *class = mbsri_attribute(e, "childclass");
    mbsr_frame own;
    if (!mbsri_mjcf_frame(m, &node, &own)) return false;
    *frame = mbsr_frame_product(at->frame, &own);
    *within = (place){at->body, frame, class ? class : at->childclass};
    return true;
}

static bool add_children(mbsri_mjcf *m, const mbsri_element *e, const place *at, shapes *sum)
{
    for (const mbsri_element *c = e->child; c; c = c->next) {
        mbsr_frame frame;
        place within;
        if (mbsri_is(c, "body")) continue;
        if (mbsri_is(c, "frame")) {
            if (!step_into(m, c, at, &frame, &within) || !add_children(m, c, &within, sum))
                return false;
        } else if (!add_child(m, c, at, sum)) {
            return false;
        }
    }
    return true;
}

static bool add_inertia(mbsri_mjcf *m, const mbsri_element *e, int body, const shapes *sum)
{
    const mbsri_element *inertial = mbsri_child(e, "inertial");
    mbsr_inertia inertia = {.kind = MBSR_INERTIA_NOT_GIVEN};
    if (sum->some)
        inertia = sum->inertia;
    else if (inertial && m->from_shapes != MBSRI_SHAPES_ALWAYS &&
             !read_inertial(m, inertial, &inertia))
        return false;
    mbsri_scene_bodies(m->s)[body].inertia = inertia;
    return true;
}

static bool add_body(mbsri_mjcf *m, const mbsri_element *e, const place *at)
{
    const mbsri_node node = {.e = e};
    const char *class = mbsri_attribute(e, "childclass"), *mocap = mbsri_attribute(e, "mocap");
    double weightless = 0.0;
    mbsri_scene_body b = {.name = name_of(e), .element = e, .parent = at->body};
    const mbsr_frame own = mbsr_frame_identity();
    const place within = {m->s->bodies.count, &own, class ? class : at->childclass};
    shapes sum = {.some = false};
    if (!enter(m, e, &m->bodies, m->s->bodies.count)) return false;
    if (!mbsri_mjcf_frame(m, &node, &b.frame)) return false;
    b.frame = mbsr_frame_product(at->frame, &b.frame);
    b.first = m->s->joints.count;
    if (mocap && strcmp(mocap, "true") == 0)
        mbsri_file_find(m->s, e, "a mocap body stays where it is drawn");
    if (!mbsri_mjcf_number(m, &node, "gravcomp", &weightless)) return false;
    if (weightless != 0.0) mbsri_file_find(m->s, e, "gravity compensation is left out");
    mbsri_scene_body *to = mbsri_list_add(m->s->arena, &m->s->bodies, sizeof *to);
    if (!to) return false;
    *to = b;
    const bool weighed = m->from_shapes == MBSRI_SHAPES_ALWAYS ||
                         (m->from_shapes == MBSRI_SHAPES_AUTO && !mbsri_child(e, "inertial"));
    return add_children(m, e, &within, weighed ? &sum : NULL) &&
           add_inertia(m, e, within.body, &sum) && add_bodies(m, e, &within);
}

static bool add_bodies(mbsri_mjcf *m, const mbsri_element *e, const place *at)
{
    for (const mbsri_element *c = e->child; c; c = c->next) {
        mbsr_frame frame;
        place within;
        if (mbsri_is(c, "body")) {
            if (!add_body(m, c, at)) return false;
        } else if (mbsri_is(c, "frame")) {
            if (!step_into(m, c, at, &frame, &within) || !add_bodies(m, c, &within)) return false;
        }
    }
    return true;
}

bool mbsri_mjcf_world(mbsri_mjcf *m, const mbsri_element *world)
{
    const mbsr_frame own = mbsr_frame_identity();
    const place at = {-1, &own, mbsri_attribute(world, "childclass")};
    return add_children(m, world, &at, NULL) && add_bodies(m, world, &at);
}

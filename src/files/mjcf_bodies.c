/* Bodies of MJCF with their joints, inertias, shapes and sites.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mjcf_parts.h"
#include "files/solids.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Gives its name, if it has one, to a number. */
static bool enter(mbsri_mjcf *m, const mbsri_element *e, mbsri_names *names, int number)
{
    const char *name = mbsri_mjcf_name(e);
    if (!name[0]) return true;
    if (mbsri_names_find(names, name) >= 0)
        return mbsri_file_refuse(m->s, e, "there are two of that name");
    return mbsri_names_add(m->s->arena, names, name, number);
}

/* ---- joints ---- */

static bool kind_of(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_joint_kind *kind)
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

/* 5 numbers of impedance, of which the second is the largest. */
static bool read_limit(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsri_scene_joint *j)
{
    double impedance[5] = {0.9, 0.95};
    if (!mbsri_mjcf_reference(m, node, "solreflimit", j->limit_reference) ||
        !mbsri_mjcf_numbers(m, node, "solimplimit", 1, 5, impedance, NULL))
        return false;
    j->limit_impedance = fmin(fmax(impedance[1], 1e-4), 1.0 - 1e-4);
    return true;
}

static bool read_joint(mbsri_mjcf *m, const mbsri_mjcf_part *node, const mbsr_frame *frame,
                       mbsri_scene_joint *j)
{
    const mbsri_compiler *c = mbsri_mjcf_compiler(m, node->e);
    const double unit = c->radian ? 1.0 : 3.14159265358979323846 / 180.0;
    double axis[3] = {0.0, 0.0, 1.0}, anchor[3] = {0.0};
    int ranged;
    if (!kind_of(m, node, &j->joint.kind)) return false;
    const bool axial = j->joint.kind == MBSR_FILE_HINGE || j->joint.kind == MBSR_FILE_SLIDE;
    if (!mbsri_mjcf_numbers(m, node, "axis", 3, 3, axis, NULL) ||
        !mbsri_mjcf_numbers(m, node, "pos", 3, 3, anchor, NULL) ||
        !mbsri_mjcf_number(m, node, "ref", &j->joint.ref) ||
        !mbsri_mjcf_number(m, node, "springref", &j->rest) ||
        !mbsri_mjcf_law(m, node, "stiffness", &j->stiffness, axial ? &j->cubic : NULL) ||
        !mbsri_mjcf_law(m, node, "damping", &j->damping, NULL) ||
        !mbsri_mjcf_number(m, node, "armature", &j->armature) ||
        !mbsri_mjcf_number(m, node, "frictionloss", &j->joint.friction) ||
        !mbsri_mjcf_numbers(m, node, "range", 2, 2, j->joint.range, &ranged))
        return false;
    if (!read_limit(m, node, j)) return false;
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
    j->joint.limited = mbsri_mjcf_switch(node, "limited", ranged > 0 && c->autolimits);
    if (mbsri_mjcf_get(node, "springdamper"))
        mbsri_file_find(m->s, node->e, "springdamper is left out");
    return mbsri_mjcf_range(m, node, "actuatorfrcrange", "actuatorfrclimited", j->force_range,
                            &j->force_limited);
}

static bool add_joint(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at)
{
    mbsri_scene *s = m->s;
    mbsri_scene_body *b = mbsri_scene_bodies(s) + at->body;
    mbsri_scene_joint j = {.limit_reference = {0.02, 1.0},
                           .limit_impedance = 0.95,
                           .element = e,
                           .joint = {.name = mbsri_mjcf_name(e), .kind = MBSR_FILE_FREE}};
    if (at->body < 0) return mbsri_file_refuse(s, e, "the world has no joints");
    if (!enter(m, e, &m->joints, s->joints.count)) return false;
    if (mbsri_is(e, "joint")) {
        mbsri_mjcf_part node;
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

/* Its principal axes as well. */
static bool read_inertial(mbsri_mjcf *m, const mbsri_element *e, mbsr_inertia *inertia,
                          mbsr_frame *principal)
{
    const mbsri_mjcf_part node = {.e = e};
    mbsr_frame frame;
    double mass = 0.0, I[6] = {0.0}, moments[3];
    int diagonal, full;
    if (!mbsri_mjcf_frame(m, &node, &frame) || !mbsri_mjcf_number(m, &node, "mass", &mass) ||
        !mbsri_mjcf_numbers(m, &node, "diaginertia", 3, 3, I, &diagonal) ||
        !mbsri_mjcf_numbers(m, &node, "fullinertia", 6, 6, I, &full))
        return false;
    if (diagonal && full)
        return mbsri_file_refuse(m->s, e, "it has two tensors, diaginertia and fullinertia");
    *principal = frame;
    if (full) mbsri_principal(I, MBSRI_NO_PRODUCT, moments, principal->R);
    return mbsri_stated_solid(m->s, e, mass, &frame, I, inertia);
}

static bool add_site(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at)
{
    mbsri_mjcf_part node;
    mbsr_frame frame;
    if (!mbsri_mjcf_node(m, e, "site", at->childclass, &node) ||
        !mbsri_mjcf_frame(m, &node, &frame) || !enter(m, e, &m->sites, m->s->sites.count))
        return false;
    mbsr_file_site *site = mbsri_list_add(m->s->arena, &m->s->sites, sizeof *site);
    if (!site) return false;
    *site = (mbsr_file_site){mbsri_mjcf_name(e), at->body, mbsr_frame_product(at->frame, &frame)};
    return true;
}

/* ---- bodies ---- */

static bool add_children(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at,
                         mbsri_mjcf_solids *sum);

static bool add_bodies(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at);

/* A flex bends or stretches, unless it is rigid: then it moves no mass. */
static bool leave_flex(mbsri_mjcf *m, const mbsri_element *e)
{
    const char *type = mbsri_attribute(e, "type"), *rigid = mbsri_attribute(e, "rigid");
    const bool still = rigid && strcmp(rigid, "true") == 0;
    m->without_flex = m->without_flex || !still;
    mbsri_file_find(m->s, e,
                    still ? "a rigid flex of type '%.30s' is not drawn"
                          : "a soft body (a flex of type '%.30s') is left out",
                    type ? type : "grid");
    return true;
}

/* What is not part of a body: bodies come later, so that its joints stand together. */
static bool add_child(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at,
                      mbsri_mjcf_solids *sum)
{
    static const char *const others[] = {"inertial", "camera", "light"};
    bool known = false;
    if (mbsri_is(e, "flexcomp")) return leave_flex(m, e);
    if (mbsri_is(e, "joint") || mbsri_is(e, "freejoint")) return add_joint(m, e, at);
    if (mbsri_is(e, "geom")) return mbsri_mjcf_add_shape(m, e, at, sum);
    if (mbsri_is(e, "site")) return add_site(m, e, at);
    for (int k = 0; k < 3; ++k) known = known || mbsri_is(e, others[k]);
    if (!known) mbsri_file_find(m->s, e, "elements of this kind are left out, with all in them");
    return true;
}

/* Where the elements in a <frame> stand. */
static bool step_into(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at,
                      mbsr_frame *frame, mbsri_mjcf_at *within)
{
    const mbsri_mjcf_part node = {.e = e};
    const char *class = mbsri_attribute(e, "childclass");
    mbsr_frame own;
    if (!mbsri_mjcf_frame(m, &node, &own)) return false;
    *frame = mbsr_frame_product(at->frame, &own);
    *within = (mbsri_mjcf_at){at->body, frame, class ? class : at->childclass};
    return true;
}

static bool add_children(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at,
                         mbsri_mjcf_solids *sum)
{
    for (const mbsri_element *c = e->child; c; c = c->next) {
        mbsr_frame frame;
        mbsri_mjcf_at within;
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

/* Axes and centre of what shapes give. */
static mbsr_frame axes_of(const mbsri_mjcf_solids *sum)
{
    mbsr_frame frame = sum->frame;
    double mass, I[6], moments[3];
    if (sum->heavy != 1 && mbsri_solid_of(&sum->inertia, &mass, frame.x, I))
        mbsri_principal(I, MBSRI_NO_PRODUCT, moments, frame.R);
    return frame;
}

/* A body's inertia, with its principal axes. */
static bool add_inertia(mbsri_mjcf *m, const mbsri_element *e, int body,
                        const mbsri_mjcf_solids *sum, mbsr_frame *principal)
{
    const mbsri_element *inertial = mbsri_child(e, "inertial");
    mbsr_inertia inertia = {.kind = MBSR_INERTIA_NOT_GIVEN};
    *principal = mbsr_frame_identity();
    if (sum->some) {
        inertia = sum->inertia;
        *principal = axes_of(sum);
    } else if (inertial && !read_inertial(m, inertial, &inertia, principal)) {
        return false;
    }
    mbsri_scene_bodies(m->s)[body].inertia = inertia;
    return true;
}

/* MuJoCo takes principal axes for those of the body where their quaternion is that within 1e-6,
 * and then a centre of mass within 1e-6 m for its origin. */
static void find_dropped(mbsri_mjcf *m, const mbsri_scene_body *b, const mbsr_frame *principal)
{
    const double *R = principal->R;
    double mass, x[3], I[6], moments[3], most = 0.0, products = 0.0, away = 0.0;
    if (!mbsri_solid_of(&b->inertia, &mass, x, I)) return;
    mbsri_moments(I, moments);
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double turn = 0.25 * fabs(R[3 * i + j] - R[3 * j + i]);
        most = fmax(most, turn);
        products = fmax(products, 2.0 * turn * fabs(I[i] - I[j]));
        away = fmax(away, fabs(x[k]));
    }
    if (R[0] + R[4] + R[8] < 2.9 || most >= 1e-6 || !(moments[2] > 0.0)) return;
    mbsri_find_products(m->s, b->element, products / moments[2]);
    if (away < 1e-6 && away > MBSRI_DROPPED * sqrt(moments[2] / mass))
        mbsri_file_find(m->s, b->element,
                        "its centre of mass stays %.0e m from its origin, which MuJoCo drops",
                        away);
}

/* A free body that carries none may count from its principal axes: then all that is fixed to it is
 * moved there. */
static void align(mbsri_mjcf *m, int body, mbsr_frame *principal)
{
    mbsri_scene_body *b = mbsri_scene_bodies(m->s) + body;
    const mbsri_scene_joint *j = mbsri_scene_joints(m->s) + b->first;
    if (b->joints != 1 || j->joint.kind != MBSR_FILE_FREE || m->s->bodies.count > body + 1) return;
    const mbsri_mjcf_part node = {.e = j->element};
    if (b->inertia.kind != MBSR_INERTIA_SPATIAL ||
        !mbsri_mjcf_switch(&node, "align", mbsri_mjcf_compiler(m, b->element)->align))
        return;
    const mbsr_frame back = mbsr_frame_inverse(principal);
    mbsr_file_shape *shapes = m->s->shapes.items;
    mbsr_file_site *sites = m->s->sites.items;
    b->frame = mbsr_frame_product(&b->frame, principal);
    b->inertia = mbsr_inertia_in_frame(&back, b->inertia);
    for (int k = m->s->shapes.count; k-- > 0 && shapes[k].body == body;)
        shapes[k].frame = mbsr_frame_product(&back, &shapes[k].frame);
    for (int k = m->s->sites.count; k-- > 0 && sites[k].body == body;)
        sites[k].frame = mbsr_frame_product(&back, &sites[k].frame);
    *principal = mbsr_frame_identity();
}

static bool add_body(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at)
{
    const mbsri_mjcf_part node = {.e = e};
    const char *class = mbsri_attribute(e, "childclass"), *mocap = mbsri_attribute(e, "mocap");
    mbsri_scene_body b = {.name = mbsri_mjcf_name(e), .element = e, .parent = at->body};
    const mbsr_frame own = mbsr_frame_identity();
    mbsr_frame principal;
    const mbsri_mjcf_at within = {m->s->bodies.count, &own, class ? class : at->childclass};
    mbsri_mjcf_solids sum = {.some = false};
    if (!enter(m, e, &m->bodies, m->s->bodies.count)) return false;
    if (!mbsri_mjcf_frame(m, &node, &b.frame)) return false;
    b.frame = mbsr_frame_product(at->frame, &b.frame);
    b.first = m->s->joints.count;
    if (mocap && strcmp(mocap, "true") == 0)
        mbsri_file_find(m->s, e, "a mocap body stays where it is drawn");
    if (!mbsri_mjcf_number(m, &node, "gravcomp", &b.weightless)) return false;
    mbsri_scene_body *to = mbsri_list_add(m->s->arena, &m->s->bodies, sizeof *to);
    if (!to) return false;
    *to = b;
    const mbsri_from_shapes from = mbsri_mjcf_compiler(m, e)->from_shapes;
    const bool weighed =
        from == MBSRI_SHAPES_ALWAYS || (from == MBSRI_SHAPES_AUTO && !mbsri_child(e, "inertial"));
    if (!add_children(m, e, &within, weighed ? &sum : NULL) ||
        !add_inertia(m, e, within.body, &sum, &principal) || !add_bodies(m, e, &within))
        return false;
    align(m, within.body, &principal);
    find_dropped(m, mbsri_scene_bodies(m->s) + within.body, &principal);
    return true;
}

static bool add_bodies(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at)
{
    for (const mbsri_element *c = e->child; c; c = c->next) {
        mbsr_frame frame;
        mbsri_mjcf_at within;
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
    const mbsri_mjcf_at at = {-1, &own, mbsri_attribute(world, "childclass")};
    return add_children(m, world, &at, NULL) && add_bodies(m, world, &at);
}

bool mbsri_mjcf_scale(mbsri_mjcf *m, const mbsri_element *root)
{
    mbsri_scene_body *b = mbsri_scene_bodies(m->s);
    double sum = 0.0, mass, centre[3], I[6];
    for (int k = 0; k < m->s->bodies.count && m->total > 0.0; ++k)
        if (mbsri_solid_of(&b[k].inertia, &mass, centre, I)) sum += mass;
    if (!(m->total > 0.0)) return true;
    const double factor = m->total / sum;
    if (!isfinite(factor) || !(factor > 0.0))
        return mbsri_file_refuse(m->s, root, "there is no mass that settotalmass could scale");
    for (int k = 0; k < m->s->bodies.count; ++k) {
        if (b[k].inertia.kind == MBSR_INERTIA_NOT_GIVEN ||
            !mbsri_solid_of(&b[k].inertia, &mass, centre, I))
            continue;
        const mbsr_frame at = mbsr_frame_at(centre[0], centre[1], centre[2]);
        for (int l = 0; l < 6; ++l) I[l] *= factor;
        b[k].inertia = mbsri_solid(m->s->arena, factor * mass, &at, I);
    }
    return true;
}

/* Equalities and tendons of MJCF.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mjcf_parts.h"
#include "files/numbers.h"

#include <math.h>
#include <string.h>

/* ---- equalities ---- */

/* The body that an attribute names; `world` may be missing. *known false: it is part of a soft
 * body. */
static bool end_of(mbsri_mjcf *m, const mbsri_element *e, const char *attribute, bool world,
                   int *body, bool *known)
{
    const char *name = mbsri_attribute(e, attribute);
    *body = -1;
    if (!name && !world) return mbsri_file_refuse(m->s, e, "it has no %s", attribute);
    if (!name || strcmp(name, "world") == 0) return true;
    *body = mbsri_names_find(&m->bodies, name);
    *known = *known && (*body >= 0 || !m->without_flex);
    return *body >= 0 || m->without_flex ||
           mbsri_file_refuse(m->s, e, "%s '%.50s' is no body", attribute, name);
}

/* Frames on bodies that coincide. */
static bool read_sites(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsri_scene_equality *q)
{
    static const char *const attributes[2] = {"site1", "site2"};
    const mbsr_file_site *sites = m->s->sites.items;
    q->at_sites = true;
    for (int k = 0; k < 2; ++k) {
        const char *name = mbsri_attribute(node->e, attributes[k]);
        const int at = mbsri_names_find(&m->sites, name);
        if (at < 0)
            return mbsri_file_refuse(m->s, node->e, "%s '%.50s' is no site", attributes[k],
                                     name ? name : "");
        q->body[k] = sites[at].body;
        q->end[k] = sites[at].frame;
    }
    return true;
}

/* Adds factor times the length of a fixed tendon, less that as drawn; *known false: it is none that
 * the model has. */
static bool add_length(mbsri_mjcf *m, const mbsri_element *e, const char *attribute, double factor,
                       mbsri_scene_equality *q, bool *known)
{
    const char *name = mbsri_attribute(e, attribute);
    const mbsri_scene_tendon *t = m->s->tendons.items;
    int at = 0, term;
    while (name && at < m->s->tendons.count && strcmp(t[at].name, name) != 0) ++at;
    if (!name || at == m->s->tendons.count)
        return mbsri_file_refuse(m->s, e, "%s '%.50s' is no tendon", attribute, name ? name : "");
    *known = *known && t[at].sum.count > 0;
    for (int k = 0; k < t[at].sum.count && *known; ++k) {
        const int joint = t[at].sum.joint[k];
        for (term = 0; term < q->sum.count && q->sum.joint[term] != joint; ++term) continue;
        if (term == MBSRI_TERMS || term == MBSR_CLOSURE_BODIES) *known = false;
        if (!*known) break;
        if (term == q->sum.count) q->sum.joint[q->sum.count++] = joint;
        q->sum.factor[term] += factor * t[at].sum.factor[k];
    }
    return true;
}

static bool read_tendons(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsri_scene_equality *q,
                         bool *known)
{
    double power[MBSRI_POWERS] = {0.0, 1.0};
    if (!mbsri_mjcf_numbers(m, node, "polycoef", 1, MBSRI_POWERS, power, NULL)) return false;
    *known = power[2] == 0.0 && power[3] == 0.0 && power[4] == 0.0;
    q->offset = power[0];
    if (!add_length(m, node->e, "tendon1", 1.0, q, known) ||
        (mbsri_attribute(node->e, "tendon2") &&
         !add_length(m, node->e, "tendon2", -power[1], q, known)))
        return false;
    if (!*known)
        mbsri_file_find(
            m->s, node->e,
            "it is left out: its tendons are not fixed ones of %d joints in all, in linear "
            "relation",
            MBSR_CLOSURE_BODIES);
    return true;
}

static bool read_bodies(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsri_scene_equality *q,
                        bool *known)
{
    const mbsri_element *e = node->e;
    double pose[7] = {0.0}, turning = 1.0;
    int anchor, given;
    if (!end_of(m, e, "body1", false, q->body, known) ||
        !end_of(m, e, "body2", true, q->body + 1, known) ||
        !mbsri_mjcf_numbers(m, node, "anchor", 3, 3, q->anchor, &anchor) ||
        !mbsri_mjcf_numbers(m, node, "relpose", 7, 7, pose, &given) ||
        !mbsri_mjcf_number(m, node, "torquescale", &turning))
        return false;
    if (!*known) {
        mbsri_file_find(m->s, e, "it is left out with the soft body that it holds");
        return true;
    }
    if (q->kind == MBSRI_WELD && turning == 0.0)
        mbsri_file_find(m->s, e, "it holds the turn as well: its torquescale of 0 is left out");
    if (q->kind == MBSRI_CONNECT && anchor == 0)
        return mbsri_file_refuse(m->s, e, "it has no anchor");
    const double turn = fabs(pose[3]) + fabs(pose[4]) + fabs(pose[5]) + fabs(pose[6]);
    q->placed = q->kind == MBSRI_WELD && given && turn > 0.0;
    if (q->placed) q->frame = mbsr_frame_quaternion(pose, pose + 3);
    return q->body[0] != q->body[1] || mbsri_file_refuse(m->s, e, "both its bodies are the same");
}

static bool coupled_joint(mbsri_mjcf *m, const mbsri_element *e, const char *attribute, int *joint)
{
    const char *name = mbsri_attribute(e, attribute);
    *joint = mbsri_names_find(&m->joints, name);
    return *joint >= 0 ||
           mbsri_file_refuse(m->s, e, "%s '%.50s' is no joint", attribute, name ? name : "");
}

/* The same of a joint with one axis. */
static bool joint_of(mbsri_mjcf *m, const mbsri_element *e, const char *attribute, int *joint)
{
    return coupled_joint(m, e, attribute, joint) &&
           (mbsri_has_axis(&mbsri_scene_joints(m->s)[*joint].joint) ||
            mbsri_file_refuse(m->s, e, "%s '%.50s' has not one axis", attribute,
                              mbsri_attribute(e, attribute)));
}

static bool read_joints(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsri_scene_equality *q)
{
    const mbsri_element *e = node->e;
    q->power[1] = 1.0;
    q->joint[1] = -1;
    if (!joint_of(m, e, "joint1", q->joint)) return false;
    if (mbsri_attribute(e, "joint2") && !joint_of(m, e, "joint2", q->joint + 1)) return false;
    if (q->joint[0] == q->joint[1])
        return mbsri_file_refuse(m->s, e, "both its joints are the same");
    return mbsri_mjcf_numbers(m, node, "polycoef", 1, MBSRI_POWERS, q->power, NULL);
}

/* *known false: it is left out, as a finding says. */
static bool read_equality(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsri_scene_equality *q,
                          bool *known)
{
    const mbsri_element *e = node->e;
    const bool connect = mbsri_is(e, "connect"), weld = mbsri_is(e, "weld");
    q->kind = connect                 ? MBSRI_CONNECT
              : weld                  ? MBSRI_WELD
              : mbsri_is(e, "tendon") ? MBSRI_SUM
                                      : MBSRI_POLYNOMIAL;
    if ((connect || weld) && mbsri_attribute(e, "site1")) return read_sites(m, node, q);
    if (connect || weld) return read_bodies(m, node, q, known);
    if (mbsri_is(e, "joint")) return read_joints(m, node, q);
    if (mbsri_is(e, "tendon")) return read_tendons(m, node, q, known);
    mbsri_file_find(m->s, e, "equalities of this kind are left out");
    *known = false;
    return true;
}

static bool add_equality(mbsri_mjcf *m, const mbsri_element *e)
{
    mbsri_scene_equality q = {.name = mbsri_mjcf_name(e), .element = e};
    mbsri_mjcf_part node;
    if (!mbsri_mjcf_node(m, e, "equality", NULL, &node)) return false;
    if (!mbsri_mjcf_switch(&node, "active", true)) {
        mbsri_file_find(m->s, e, "it is not active and left out");
        return true;
    }
    bool known = true;
    if (!read_equality(m, &node, &q, &known)) return false;
    if (!known) return true;
    mbsri_scene_equality *to = mbsri_list_add(m->s->arena, &m->s->equalities, sizeof *to);
    if (to) *to = q;
    return to != NULL;
}

bool mbsri_mjcf_equalities(mbsri_mjcf *m, const mbsri_element *list)
{
    for (const mbsri_element *e = list->child; e; e = e->next) {
        if (!add_equality(m, e)) return false;
    }
    return true;
}

/* ---- shapes that touch by a law of their own, bodies that never touch ---- */

/* The shape that an attribute names; -1: there is none. */
static int shape_of(const mbsri_mjcf *m, const mbsri_element *e, const char *attribute)
{
    const mbsr_file_shape *shape = m->s->shapes.items;
    const char *name = mbsri_attribute(e, attribute);
    int at = m->s->shapes.count - 1;
    while (name && at >= 0 && strcmp(shape[at].name, name) != 0) --at;
    return name ? at : -1;
}

/* Two shapes with a law of their own. */
static bool add_own_pair(mbsri_mjcf *m, const mbsri_element *e)
{
    mbsr_file_pair pair = {.shape = {shape_of(m, e, "geom1"), shape_of(m, e, "geom2")}};
    double friction[5], kinds = 3.0;
    mbsri_mjcf_part node;
    int given;
    if (pair.shape[0] < 0 || pair.shape[1] < 0 || pair.shape[0] == pair.shape[1]) {
        const char *name = mbsri_attribute(e, pair.shape[0] < 0 ? "geom1" : "geom2");
        mbsri_file_find(m->s, e, "it is left out: '%.60s' is none of two shapes", name ? name : "");
        return true;
    }
    mbsri_mjcf_plain_law(pair.friction, pair.settle);
    if (!mbsri_mjcf_node(m, e, "pair", NULL, &node) ||
        !mbsri_mjcf_number(m, &node, "condim", &kinds) ||
        !mbsri_mjcf_number(m, &node, "margin", &pair.margin) ||
        !mbsri_mjcf_numbers(m, &node, "friction", 1, 5, friction, &given) ||
        !mbsri_mjcf_reference(m, &node, "solref", pair.settle))
        return false;
    if (pair.margin < 0.0) return mbsri_file_refuse(m->s, e, "its margin is negative");
    if (given > 0) pair.friction[0] = friction[0];
    if (given > 1 && friction[1] != friction[0])
        mbsri_file_find(m->s, e, "its first friction holds in all directions");
    if (given > 2) pair.friction[1] = friction[2];
    if (given > 3) pair.friction[2] = friction[3];
    mbsri_mjcf_rub(kinds, pair.friction);
    for (int k = 0; k < 2; ++k) ((mbsr_file_shape *)m->s->shapes.items)[pair.shape[k]].contact = 1;
    mbsr_file_pair *to = mbsri_list_add(m->s->arena, &m->s->pairs, sizeof *to);
    if (to) *to = pair;
    return to != NULL;
}

bool mbsri_mjcf_contacts(mbsri_mjcf *m, const mbsri_element *list)
{
    for (const mbsri_element *e = list->child; e; e = e->next) {
        bool known = true;
        int body[2];
        if (mbsri_is(e, "pair")) {
            if (!add_own_pair(m, e)) return false;
            continue;
        }
        if (!mbsri_is(e, "exclude")) {
            mbsri_file_find(m->s, e, "it is left out");
            continue;
        }
        if (!end_of(m, e, "body1", false, body, &known) ||
            !end_of(m, e, "body2", false, body + 1, &known))
            return false;
        int *to = known ? mbsri_list_add(m->s->arena, &m->s->excludes, sizeof body) : NULL;
        if (known && !to) return false;
        if (known) memcpy(to, body, sizeof body);
    }
    return true;
}

/* ---- tendons ---- */

/* False in *known: it is left out. */
static bool read_sum(mbsri_mjcf *m, const mbsri_element *e, mbsri_scene_tendon *t, bool *known)
{
    *known = false;
    for (const mbsri_element *c = e->child; c; c = c->next) {
        double factor = 0.0;
        int joint;
        if (!mbsri_is(c, "joint")) continue;
        if (!coupled_joint(m, c, "joint", &joint) ||
            !mbsri_numbers(m->s, c, "coef", mbsri_attribute(c, "coef"), 1, 1, &factor, NULL))
            return false;
        const bool axial = mbsri_has_axis(&mbsri_scene_joints(m->s)[joint].joint);
        if (!axial || t->sum.count == MBSRI_TERMS) {
            t->sum.count = 0;
            mbsri_file_find(m->s, e,
                            axial ? "it is left out: it has more than %d joints"
                                  : "it is left out: one of its joints has not one axis",
                            MBSRI_TERMS);
            return true;
        }
        t->sum.joint[t->sum.count] = joint;
        t->sum.factor[t->sum.count++] = factor;
    }
    *known = t->sum.count > 0;
    return true;
}

static bool read_path(mbsri_mjcf *m, const mbsri_element *e, mbsri_scene_tendon *t, bool *known)
{
    *known = true;
    for (const mbsri_element *c = e->child; c; c = c->next) {
        const char *name = mbsri_attribute(c, "site");
        const int site = mbsri_names_find(&m->sites, name);
        if (mbsri_is(c, "site") && site < 0)
            return mbsri_file_refuse(m->s, c, "'%.50s' is no site", name ? name : "");
        *known = *known && mbsri_is(c, "site") && t->count < MBSRI_PATH_MOST;
        if (*known) t->site[t->count++] = site;
    }
    *known = *known && t->count > 1;
    if (!*known) {
        t->count = 0;
        if (t->stiffness != 0.0 || t->damping != 0.0)
            mbsri_file_find(m->s, e,
                            "its spring is left out: its path is not from site to site, %d at most",
                            MBSRI_PATH_MOST);
    }
    return true;
}

static bool add_tendon(mbsri_mjcf *m, const mbsri_element *e)
{
    mbsri_scene_tendon t = {.name = mbsri_mjcf_name(e), .element = e, .rest = {-1.0, -1.0}};
    const bool fixed = mbsri_is(e, "fixed");
    mbsri_mjcf_part node;
    double friction = 0.0, armature = 0.0;
    int lengths;
    bool known;
    if (!fixed && !mbsri_is(e, "spatial")) return true;
    if (!mbsri_mjcf_node(m, e, "tendon", NULL, &node) ||
        !mbsri_mjcf_law(m, &node, "stiffness", &t.stiffness, NULL) ||
        !mbsri_mjcf_law(m, &node, "damping", &t.damping, NULL) ||
        !mbsri_mjcf_number(m, &node, "frictionloss", &friction) ||
        !mbsri_mjcf_number(m, &node, "armature", &armature) ||
        !mbsri_mjcf_range(m, &node, "actuatorfrcrange", "actuatorfrclimited", t.force_range,
                          &t.force_limited) ||
        !mbsri_mjcf_numbers(m, &node, "springlength", 1, 2, t.rest, &lengths) ||
        !(fixed ? read_sum : read_path)(m, e, &t, &known))
        return false;
    if (lengths == 1) t.rest[1] = t.rest[0];
    if (t.rest[0] == -1.0 && t.rest[1] == -1.0) t.rest[0] = t.rest[1] = NAN;
    if (mbsri_mjcf_switch(&node, "limited",
                          mbsri_mjcf_compiler(m, e)->autolimits && mbsri_mjcf_get(&node, "range")))
        mbsri_file_find(m->s, e, "its limits are left out");
    if (friction > 0.0) mbsri_file_find(m->s, e, "its dry friction is left out");
    if (armature > 0.0) mbsri_file_find(m->s, e, "its armature is left out");
    mbsri_scene_tendon *to = mbsri_list_add(m->s->arena, &m->s->tendons, sizeof *to);
    if (to) *to = t;
    return to != NULL;
}

bool mbsri_mjcf_tendons(mbsri_mjcf *m, const mbsri_element *list)
{
    for (const mbsri_element *e = list->child; e; e = e->next) {
        if (!add_tendon(m, e)) return false;
    }
    return true;
}

/* Equalities, tendons and actuators of MJCF.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mjcf_parts.h"
#include "files/numbers.h"

#include <math.h>
#include <string.h>

/* ---- equalities ---- */

/* The body that an attribute names; `world` may be missing. */
static bool end_of(mbsri_mjcf *m, const mbsri_element *e, const char *attribute, bool world,
                   int *body)
{
    const char *name = mbsri_attribute(e, attribute);
    *body = -1;
    if (!name && !world) return mbsri_file_refuse(m->s, e, "it has no %s", attribute);
    if (!name || strcmp(name, "world") == 0) return true;
    *body = mbsri_names_find(&m->bodies, name);
    return *body >= 0 || mbsri_file_refuse(m->s, e, "%s '%.50s' is no body", attribute, name);
}

static bool read_bodies(mbsri_mjcf *m, const mbsri_node *node, mbsri_scene_equality *q)
{
    const mbsri_element *e = node->e;
    double pose[7] = {0.0}, turning = 1.0;
    int anchor, given;
    if (!end_of(m, e, "body1", false, q->body) || !end_of(m, e, "body2", true, q->body + 1) ||
        !mbsri_mjcf_numbers(m, node, "anchor", 3, 3, q->anchor, &anchor) ||
        !mbsri_mjcf_numbers(m, node, "relpose", 7, 7, pose, &given) ||
        !mbsri_mjcf_number(m, node, "torquescale", &turning))
        return false;
    if (q->kind == MBSRI_WELD && turning == 0.0)
        mbsri_file_find(m->s, e, "it holds the turn as well: its torquescale of 0 is left out");
    if (q->kind == MBSRI_CONNECT && anchor == 0)
        return mbsri_file_refuse(m->s, e, "it has no anchor");
    q->placed = q->kind == MBSRI_WELD && given &&
                (pose[3] != 0.0 || pose[4] != 0.0 || pose[5] != 0.0 || pose[6] != 0.0);
    if (q->placed) q->frame = mbsr_frame_quaternion(pose, pose + 3);
    return q->body[0] != q->body[1] || mbsri_file_refuse(m->s, e, "both its bodies are the same");
}

static bool find_joint(mbsri_mjcf *m, const mbsri_element *e, const char *attribute, int *joint)
{
    const char *name = mbsri_attribute(e, attribute);
    *joint = mbsri_names_find(&m->joints, name);
    return *joint >= 0 ||
           mbsri_file_refuse(m->s, e, "%s '%.50s' is no joint", attribute, name ? name : "");
}

static bool has_axis(const mbsri_mjcf *m, int joint)
{
    const mbsr_file_joint_kind kind = mbsri_scene_joints(m->s)[joint].joint.kind;
    return kind == MBSR_FILE_HINGE || kind == MBSR_FILE_SLIDE;
}

/* The same of a joint with one axis. */
static bool joint_of(mbsri_mjcf *m, const mbsri_element *e, const char *attribute, int *joint)
{
    return find_joint(m, e, attribute, joint) &&
           (has_axis(m, *joint) || mbsri_file_refuse(m->s, e, "%s '%.50s' has not one axis",
                                                     attribute, mbsri_attribute(e, attribute)));
}

static bool read_joints(mbsri_mjcf *m, const mbsri_node *node, mbsri_scene_equality *q)
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

static bool add_equality(mbsri_mjcf *m, const mbsri_element *e)
{
    mbsri_scene_equality q = {.name = mbsri_mjcf_name(e), .element = e};
    mbsri_node node;
    if (!mbsri_mjcf_node(m, e, "equality", NULL, &node)) return false;
    const bool connect = mbsri_is(e, "connect"), weld = mbsri_is(e, "weld");
    if (!mbsri_mjcf_switch(&node, "active", true)) {
        mbsri_file_find(m->s, e, "it is not active and left out");
        return true;
    }
    if (!connect && !weld && !mbsri_is(e, "joint")) {
        mbsri_file_find(m->s, e, "equalities of this kind are left out");
        return true;
    }
    if (mbsri_attribute(e, "site1")) {
        mbsri_file_find(m->s, e, "an equality between sites is left out");
        return true;
    }
    q.kind = connect ? MBSRI_CONNECT : weld ? MBSRI_WELD : MBSRI_POLYNOMIAL;
    if (!(connect || weld ? read_bodies : read_joints)(m, &node, &q)) return false;
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

/* ---- tendons ---- */

/* False in *known: it is left out. */
static bool read_sum(mbsri_mjcf *m, const mbsri_element *e, mbsri_scene_tendon *t, bool *known)
{
    *known = false;
    for (const mbsri_element *c = e->child; c; c = c->next) {
        double factor = 0.0;
        int joint;
        if (!mbsri_is(c, "joint")) continue;
        if (!find_joint(m, c, "joint", &joint) ||
            !mbsri_numbers(m->s, c, "coef", mbsri_attribute(c, "coef"), 1, 1, &factor, NULL))
            return false;
        const bool axial = has_axis(m, joint);
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
    mbsri_node node;
    double friction = 0.0, armature = 0.0;
    int lengths;
    bool known;
    if (!fixed && !mbsri_is(e, "spatial")) return true;
    if (!mbsri_mjcf_node(m, e, "tendon", NULL, &node) ||
        !mbsri_mjcf_law(m, &node, "stiffness", &t.stiffness, NULL) ||
        !mbsri_mjcf_law(m, &node, "damping", &t.damping, NULL) ||
        !mbsri_mjcf_number(m, &node, "frictionloss", &friction) ||
        !mbsri_mjcf_number(m, &node, "armature", &armature) ||
        !mbsri_mjcf_numbers(m, &node, "springlength", 1, 2, t.rest, &lengths) ||
        !(fixed ? read_sum : read_path)(m, e, &t, &known))
        return false;
    if (lengths == 1) t.rest[1] = t.rest[0];
    if (t.rest[0] == -1.0 && t.rest[1] == -1.0) t.rest[0] = t.rest[1] = NAN;
    if (mbsri_mjcf_switch(&node, "limited", m->autolimits && mbsri_mjcf_get(&node, "range")))
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

/* ---- actuators ---- */

/* What it acts on; an empty sum: nothing that the library has. */
static bool read_target(mbsri_mjcf *m, const mbsri_node *node, mbsri_scene_actuator *a)
{
    const mbsri_element *e = node->e;
    const char *joint = mbsri_attribute(e, "joint"), *tendon = mbsri_attribute(e, "tendon");
    const mbsri_scene_tendon *tendons = m->s->tendons.items;
    if (!joint) joint = mbsri_attribute(e, "jointinparent");
    if (joint) {
        const int at = mbsri_names_find(&m->joints, joint);
        if (at < 0) return mbsri_file_refuse(m->s, e, "'%.50s' is no joint", joint);
        const mbsr_file_joint_kind kind = mbsri_scene_joints(m->s)[at].joint.kind;
        if (kind == MBSR_FILE_HINGE || kind == MBSR_FILE_SLIDE)
            a->sum = (mbsri_scene_sum){.count = 1, .joint = {at}, .factor = {1.0}};
    }
    for (int k = 0; tendon && k < m->s->tendons.count; ++k) {
        if (strcmp(tendons[k].name, tendon) == 0) a->sum = tendons[k].sum;
    }
    if (a->sum.count == 0)
        mbsri_file_find(m->s, e,
                        "it is left out: it acts on neither a joint with one axis nor a "
                        "fixed tendon");
    return true;
}

static bool is(const char *a, const char *b)
{
    return a && strcmp(a, b) == 0;
}

/* The law of a general actuator; false in *known: it is left out. */
static bool read_general(mbsri_mjcf *m, const mbsri_node *node, mbsr_file_actuator *a, bool *known)
{
    const char *gain = mbsri_mjcf_get(node, "gaintype"), *bias = mbsri_mjcf_get(node, "biastype"),
               *dynamics = mbsri_mjcf_get(node, "dyntype");
    const char *given = mbsri_mjcf_get(node, "gainprm"), *more = mbsri_mjcf_get(node, "biasprm");
    double prm[10] = {1.0}, law[10] = {0.0};
    *known = (!gain || is(gain, "fixed")) && (!bias || is(bias, "none") || is(bias, "affine")) &&
             (!dynamics || is(dynamics, "none"));
    if (!mbsri_numbers(m->s, node->e, "gainprm", given, 1, 10, prm, NULL) ||
        !mbsri_numbers(m->s, node->e, "biasprm", more, 1, 10, law, NULL))
        return false;
    a->gain = prm[0];
    for (int k = 0; k < 3 && is(bias, "affine"); ++k) a->bias[k] = law[k];
    return true;
}

static bool read_law(mbsri_mjcf *m, const mbsri_node *node, mbsr_file_actuator *a, bool *known)
{
    const mbsri_element *e = node->e;
    double kp = 1.0, kv = 0.0;
    *known = true;
    if (mbsri_is(e, "general")) return read_general(m, node, a, known);
    if (mbsri_is(e, "motor")) {
        a->gain = 1.0;
    } else if (mbsri_is(e, "position")) {
        if (!mbsri_mjcf_number(m, node, "kp", &kp) || !mbsri_mjcf_number(m, node, "kv", &kv))
            return false;
        a->gain = kp, a->bias[1] = -kp, a->bias[2] = -kv;
        *known = !mbsri_mjcf_get(node, "dampratio") && !mbsri_mjcf_get(node, "timeconst");
    } else if (mbsri_is(e, "velocity")) {
        kv = 1.0;
        if (!mbsri_mjcf_number(m, node, "kv", &kv)) return false;
        a->gain = kv, a->bias[2] = -kv;
    } else {
        *known = false;
    }
    return true;
}

/* Whether its group is switched off. */
static bool is_idle(const mbsri_mjcf *m, const mbsri_node *node)
{
    const char *own = mbsri_mjcf_get(node, "group"), *at = m->idle;
    double group = 0.0, idle;
    if (own) (void)mbsri_read_numbers(own, 1, 1, &group);
    while (at && *at) {
        if (!mbsri_read_number(&at, &idle)) return false;
        if (idle == group) return true;
    }
    return false;
}

static bool add_actuator(mbsri_mjcf *m, const mbsri_element *e)
{
    /* gears and ranges are defaults of all kinds alike */
    static const char *const kinds[] = {"general",     "motor",  "position", "velocity",
                                        "intvelocity", "damper", "cylinder", "muscle",
                                        "adhesion",    NULL};
    mbsri_scene_actuator a = {.element = e, .actuator = {.name = mbsri_mjcf_name(e)}};
    mbsri_node node;
    double gear[6] = {1.0};
    int ranged;
    bool known;
    if (!mbsri_mjcf_node(m, e, e->name, NULL, &node) || !read_law(m, &node, &a.actuator, &known))
        return false;
    node.alike = kinds;
    if (!mbsri_mjcf_numbers(m, &node, "gear", 1, 6, gear, NULL) ||
        !mbsri_mjcf_numbers(m, &node, "ctrlrange", 2, 2, a.actuator.range, &ranged))
        return false;
    a.actuator.gear = gear[0];
    a.actuator.limited = mbsri_mjcf_switch(&node, "ctrllimited", ranged && m->autolimits);
    if (!known)
        mbsri_file_find(m->s, e, "it is left out: the library has no actuator of its kind");
    else if (!is_idle(m, &node) && !read_target(m, &node, &a))
        return false;
    if (a.sum.count > 0 && mbsri_mjcf_switch(&node, "forcelimited",
                                             m->autolimits && mbsri_mjcf_get(&node, "forcerange")))
        mbsri_file_find(m->s, e, "its force is not limited to forcerange");
    mbsri_scene_actuator *to = mbsri_list_add(m->s->arena, &m->s->actuators, sizeof *to);
    if (to) *to = a;
    return to != NULL;
}

bool mbsri_mjcf_actuators(mbsri_mjcf *m, const mbsri_element *list)
{
    for (const mbsri_element *e = list->child; e; e = e->next) {
        if (!add_actuator(m, e)) return false;
    }
    return true;
}

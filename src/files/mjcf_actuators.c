/* Actuators of MJCF: what they act on, by which law, within which ranges.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mjcf_parts.h"
#include "files/numbers.h"

#include <string.h>

static bool is(const char *a, const char *b)
{
    return a && strcmp(a, b) == 0;
}

/* Whether its group is switched off. */
static bool is_idle(const mbsri_mjcf *m, const mbsri_mjcf_part *node)
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

/* ---- what it acts on ---- */

static bool driven_joint(mbsri_mjcf *m, const mbsri_element *e, const char *joint,
                         mbsri_scene_actuator *a)
{
    const int at = mbsri_names_find(&m->joints, joint);
    if (at < 0) return mbsri_file_refuse(m->s, e, "'%.50s' is no joint", joint);
    const mbsr_file_joint_kind kind = mbsri_scene_joints(m->s)[at].joint.kind;
    if (kind == MBSR_FILE_HINGE || kind == MBSR_FILE_SLIDE)
        a->sum = (mbsri_scene_sum){.count = 1, .joint = {at}, .factor = {1.0}};
    return true;
}

static bool find_site(mbsri_mjcf *m, const mbsri_element *e, const char *site,
                      mbsri_scene_actuator *a)
{
    const int at = mbsri_names_find(&m->sites, site);
    if (at < 0) return mbsri_file_refuse(m->s, e, "'%.50s' is no site", site);
    if (!mbsri_attribute(e, "refsite")) a->site = at;
    return true;
}

/* Neither joints nor a site: nothing that the library has. */
static bool read_target(mbsri_mjcf *m, const mbsri_element *e, mbsri_scene_actuator *a)
{
    const char *joint = mbsri_attribute(e, "joint"), *tendon = mbsri_attribute(e, "tendon"),
               *site = mbsri_attribute(e, "site");
    const mbsri_scene_tendon *tendons = m->s->tendons.items;
    if (!joint) joint = mbsri_attribute(e, "jointinparent");
    if (joint && !driven_joint(m, e, joint, a)) return false;
    if (site && !find_site(m, e, site, a)) return false;
    for (int k = 0; tendon && k < m->s->tendons.count; ++k) {
        if (strcmp(tendons[k].name, tendon) != 0) continue;
        a->sum = tendons[k].sum;
        a->tendon = k;
    }
    if (a->sum.count == 0 && a->site < 0)
        mbsri_file_find(m->s, e,
                        "it is left out: it acts on neither a joint with one axis, nor a fixed "
                        "tendon, nor a site");
    return true;
}

/* ---- its law ---- */

/* Why a general actuator is left out; NULL: it is not. */
static const char *obstacle(const mbsri_mjcf_part *node)
{
    const char *gain = mbsri_mjcf_get(node, "gaintype"), *bias = mbsri_mjcf_get(node, "biastype"),
               *state = mbsri_mjcf_get(node, "dyntype");
    if (gain && !is(gain, "fixed")) return "its gain is not fixed";
    if (bias && !is(bias, "none") && !is(bias, "affine")) return "its bias is not affine";
    if (state && !is(state, "none") && !is(state, "filter") && !is(state, "filterexact"))
        return "it has a state of its own";
    return NULL;
}

static bool read_general(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_actuator *a,
                         const char **left)
{
    const char *state = mbsri_mjcf_get(node, "dyntype");
    double prm[10] = {1.0}, law[10] = {0.0};
    *left = obstacle(node);
    if (!mbsri_mjcf_numbers(m, node, "gainprm", 1, 10, prm, NULL) ||
        !mbsri_mjcf_numbers(m, node, "biasprm", 1, 10, law, NULL))
        return false;
    a->gain = prm[0];
    for (int k = 0; k < 3 && is(mbsri_mjcf_get(node, "biastype"), "affine"); ++k)
        a->bias[k] = law[k];
    if (!*left && state && !is(state, "none"))
        mbsri_file_find(m->s, node->e, "its control acts at once: its filter is left out");
    return true;
}

/* A damping above zero is a ratio of the critical one: build_actuators.c. */
static bool read_position(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_actuator *a)
{
    double kp = 1.0, kv = 0.0, ratio = 0.0, time = 0.0;
    int damped, rated;
    if (!mbsri_mjcf_number(m, node, "kp", &kp) ||
        !mbsri_mjcf_numbers(m, node, "kv", 1, 1, &kv, &damped) ||
        !mbsri_mjcf_numbers(m, node, "dampratio", 1, 1, &ratio, &rated) ||
        !mbsri_mjcf_number(m, node, "timeconst", &time))
        return false;
    if (ratio < 0.0) return mbsri_file_refuse(m->s, node->e, "its dampratio is negative");
    if (rated && mbsri_attribute(node->e, "kv") && mbsri_attribute(node->e, "dampratio"))
        return mbsri_file_refuse(m->s, node->e, "it has both kv and dampratio");
    a->gain = kp, a->bias[1] = -kp;
    a->bias[2] = rated && !mbsri_attribute(node->e, "kv") ? ratio : -kv;
    if (time > 0.0)
        mbsri_file_find(m->s, node->e, "its control acts at once: its timeconst is left out");
    return true;
}

/* *left: why it is left out, NULL: it is not. */
static bool read_law(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_actuator *a,
                     const char **left)
{
    double kv = 1.0;
    *left = NULL;
    if (mbsri_is(node->e, "general")) return read_general(m, node, a, left);
    if (mbsri_is(node->e, "position")) return read_position(m, node, a);
    if (mbsri_is(node->e, "motor")) {
        a->gain = 1.0;
    } else if (mbsri_is(node->e, "velocity")) {
        if (!mbsri_mjcf_number(m, node, "kv", &kv)) return false;
        a->gain = kv, a->bias[2] = -kv;
    } else {
        *left = "the library has no actuator of its kind";
    }
    return true;
}

/* ---- its ranges ---- */

/* That of its joint, made larger about its middle by a factor. */
static bool inherit_range(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsri_scene_actuator *a)
{
    double factor = 0.0;
    if (!mbsri_mjcf_number(m, node, "inheritrange", &factor)) return false;
    if (!(factor > 0.0)) return true;
    if (a->sum.count != 1 || a->tendon >= 0) {
        mbsri_file_find(m->s, node->e, "its control is not limited to the range of its tendon");
        return true;
    }
    const double *range = mbsri_scene_joints(m->s)[a->sum.joint[0]].joint.range;
    const double middle = 0.5 * (range[0] + range[1]), half = 0.5 * factor * (range[1] - range[0]);
    if (!(half > 0.0)) return mbsri_file_refuse(m->s, node->e, "the joint has no range to inherit");
    a->actuator.range[0] = middle - half;
    a->actuator.range[1] = middle + half;
    a->actuator.limited = !m->free_controls;
    return true;
}

static bool read_ranges(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsri_scene_actuator *a)
{
    mbsr_file_actuator *to = &a->actuator;
    bool limited, force_limited;
    if (!mbsri_mjcf_numbers(m, node, "gear", 1, 6, a->gear, NULL) ||
        !mbsri_mjcf_range(m, node, "ctrlrange", "ctrllimited", to->range, &limited) ||
        !mbsri_mjcf_range(m, node, "forcerange", "forcelimited", to->force_range, &force_limited))
        return false;
    to->limited = limited && !m->free_controls;
    to->force_limited = force_limited;
    to->gear = a->gear[0];
    return true;
}

static bool add_actuator(mbsri_mjcf *m, const mbsri_element *e)
{
    /* gears and ranges are defaults of all kinds alike */
    static const char *const kinds[] = {"general",     "motor",  "position", "velocity",
                                        "intvelocity", "damper", "cylinder", "muscle",
                                        "adhesion",    NULL};
    mbsri_scene_actuator a = {.element = e,
                              .actuator = {.name = mbsri_mjcf_name(e)},
                              .tendon = -1,
                              .site = -1,
                              .gear = {1.0}};
    mbsri_mjcf_part node;
    const char *left;
    if (!mbsri_mjcf_node(m, e, e->name, NULL, &node) || !read_law(m, &node, &a.actuator, &left))
        return false;
    node.alike = kinds;
    if (!read_ranges(m, &node, &a)) return false;
    if (left)
        mbsri_file_find(m->s, e, "it is left out: %s", left);
    else if (!is_idle(m, &node) && (!read_target(m, e, &a) || !inherit_range(m, &node, &a)))
        return false;
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

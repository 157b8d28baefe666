/* The vocabulary of MJCF: which attributes the readers follow, and which say nothing of a model's
 * motion.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Whatever else an element has is named by a finding. */
#include "files/mjcf_parts.h"

#include <string.h>

/* What looks, touches, is sensed, names or steers a solver stands beside what is followed. */
#define NAMES "name class childclass group user "
#define PLACE "pos quat axisangle xyaxes zaxis euler "
#define LOOKS "rgba material size type "
#define TOUCH                                                                                      \
    "contype conaffinity condim priority friction solmix solref solimp margin gap surfacevel "     \
    "adhesion fluidshape fluidcoef "
#define LIMITS "solreflimit solimplimit solreffriction solimpfriction "
#define DRIVE                                                                                      \
    NAMES "joint jointinparent tendon site refsite body slidersite cranksite cranklength gear "    \
          "ctrlrange ctrllimited forcerange forcelimited lengthrange inheritrange "
#define CABLE                                                                                      \
    NAMES LIMITS "limited range frictionloss springlength stiffness damping armature width "       \
                 "material rgba actuatorfrcrange actuatorfrclimited "
#define EQUAL NAMES "active solref solimp "

typedef struct vocabulary {
    const char *section, *element, *attributes;
} vocabulary;

static const vocabulary words[] = {
    {"", "compiler",
     "angle eulerseq autolimits inertiafromgeom inertiagrouprange meshdir assetdir texturedir "
     "strippath fitaabb "
     "coordinate boundmass boundinertia settotalmass balanceinertia alignfree discardvisual "
     "usethread fusestatic "
     "saveinertial conflict convexhull exactmeshinertia "},
    {"", "option",
     "timestep impratio tolerance ls_tolerance noslip_tolerance ccd_tolerance mpr_tolerance "
     "sleep_tolerance gravity "
     "wind magnetic density viscosity o_margin o_solref o_solimp o_friction integrator cone "
     "jacobian solver "
     "iterations ls_iterations noslip_iterations ccd_iterations mpr_iterations sdf_iterations "
     "sdf_initpoints "
     "actuatorgroupdisable collision apirate "},
    {"option", "flag",
     "constraint equality frictionloss limit contact passive spring damper gravity clampctrl "
     "warmstart filterparent "
     "actuation refsafe sensor midphase eulerdamp autoreset nativeccd island multiccd override "
     "energy fwdinv "
     "invdiscrete sleep diagexact sensornoise "},
    {"asset", "mesh",
     "name class content_type file vertex normal texcoord face refpos refquat scale smoothnormal "
     "maxhullvert inertia "
     "material "},
    {"asset", "hfield", "name class content_type file nrow ncol elevation size "},
    {"worldbody", "body", NAMES PLACE "mocap gravcomp sleep simple "},
    {"worldbody", "frame", NAMES PLACE},
    {"asset", "model", "name file content_type "},
    {"worldbody", "attach", "model body frame prefix "},
    {"worldbody", "composite", "prefix type count offset quat curve initial size vertex "},
    {"worldbody", "replicate", "count offset euler sep childclass "},
    {"worldbody", "inertial", PLACE "mass diaginertia fullinertia "},
    {"worldbody", "joint",
     NAMES LIMITS "type pos axis springdamper limited range ref springref stiffness damping "
                  "armature frictionloss "
                  "actuatorfrcrange actuatorfrclimited "},
    {"worldbody", "freejoint", NAMES "align "},
    {"worldbody", "geom",
     NAMES PLACE LOOKS TOUCH "mass density shellinertia fromto mesh hfield fitscale "},
    {"worldbody", "site", NAMES PLACE LOOKS "fromto "},
    {"contact", "pair",
     "name class geom1 geom2 condim friction solref solimp solreffriction margin gap "},
    {"equality", "connect", EQUAL "body1 body2 anchor site1 site2 "},
    {"equality", "weld", EQUAL "body1 body2 anchor relpose site1 site2 torquescale "},
    {"equality", "joint", EQUAL "joint1 joint2 polycoef "},
    {"equality", "equality", EQUAL},
    {"tendon", "spatial", CABLE},
    {"tendon", "fixed", CABLE},
    {"tendon", "tendon", CABLE},
    {"equality", "tendon", EQUAL "tendon1 tendon2 polycoef "},
    {"tendon", "joint", "joint coef "},
    {"tendon", "site", "site "},
    {"tendon", "geom", "geom sidesite "},
    {"tendon", "pulley", "divisor "},
    {"actuator", "general", DRIVE "dyntype gaintype biastype dynprm gainprm biasprm "},
    {"actuator", "motor", DRIVE},
    {"actuator", "position", DRIVE "kp kv dampratio timeconst "},
    {"actuator", "velocity", DRIVE "kv "},
    {"keyframe", "key", "name time qpos qvel ctrl "},
};

static bool has_word(const char *list, const char *word)
{
    const size_t length = strlen(word);
    for (const char *at = list; (at = strstr(at, word)); at += length)
        if ((at == list || at[-1] == ' ') && at[length] == ' ') return true;
    return false;
}

static const vocabulary *find_words(const char *section, const char *element)
{
    for (size_t k = 0; k < sizeof words / sizeof *words; ++k)
        if (strcmp(words[k].section, section) == 0 && strcmp(words[k].element, element) == 0)
            return words + k;
    return NULL;
}

static void check_attributes(mbsri_mjcf *m, const char *section, const mbsri_element *e)
{
    const vocabulary *v = find_words(section, e->name);
    for (const char **a = e->attribute; v && *a; a += 2)
        if (!has_word(v->attributes, *a))
            mbsri_file_find(m->s, e, "its attribute %.40s is not followed", *a);
}

/* Elements in each other, from one of a section on. */
static void check_all(mbsri_mjcf *m, const char *section, const mbsri_element *top)
{
    for (const mbsri_element *e = top; e;) {
        check_attributes(m, section, e);
        if (e->child && !mbsri_is(e, "composite") && !mbsri_is(e, "flexcomp")) {
            e = e->child;
            continue;
        }
        while (e != top && !e->next) e = e->parent;
        e = e == top ? NULL : e->next;
    }
}

/* The section that an element of a class of defaults belongs to. */
static const char *section_of(const char *element)
{
    for (size_t k = 0; k < sizeof words / sizeof *words; ++k)
        if (strcmp(words[k].element, element) == 0 && words[k].section[0]) return words[k].section;
    return "";
}

static void check_defaults(mbsri_mjcf *m, const mbsri_element *list, int depth)
{
    if (depth > MBSRI_XML_DEPTH) return;
    for (const mbsri_element *e = list->child; e; e = e->next) {
        if (mbsri_is(e, "default"))
            check_defaults(m, e, depth + 1);
        else
            check_attributes(m, section_of(e->name), e);
    }
}

/* Sections that the readers below do not know, and that say more than how things look or what is
 * sensed. */
static void find_sections(mbsri_mjcf *m, const mbsri_element *root)
{
    static const char *const known[] = {"compiler", "option", "size",   "visual",    "statistic",
                                        "default",  "asset",  "custom", "worldbody", "contact",
                                        "equality", "tendon", "sensor", "actuator",  "keyframe"};
    for (const mbsri_element *e = root->child; e; e = e->next) {
        bool found = !e->child && !e->attribute[0]; /* it says nothing */
        for (size_t k = 0; k < sizeof known / sizeof *known && !found; ++k)
            found = mbsri_is(e, known[k]);
        if (!found)
            mbsri_file_find(m->s, e, "sections of this kind are left out, with all in them");
    }
}

void mbsri_mjcf_find_words(mbsri_mjcf *m, const mbsri_element *root)
{
    find_sections(m, root);
    for (const mbsri_element *e = root->child; e; e = e->next) {
        check_attributes(m, "", e);
        if (mbsri_is(e, "default")) check_defaults(m, e, 0);
        for (const mbsri_element *c = e->child; c && !mbsri_is(e, "default"); c = c->next)
            check_all(m, e->name, c);
    }
}

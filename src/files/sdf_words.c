/* The vocabulary of SDF: which elements the reader follows, and which say nothing of a model's
 * motion.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Whatever else stands in one of these is named by a finding. */
#include "files/sdf_parts.h"

#include <string.h>

/* Below those that are not listed here nothing is looked at. */
static const char *const words[][2] = {
    {"sdf", "world model "},
    {"gazebo", "world model "}, /* the root before version 1.3 */
    {"world", "gravity model include frame joint light scene physics gui audio atmosphere "
              "magnetic_field wind "
              "spherical_coordinates plugin state "},
    {"model", "pose static link joint frame model include self_collide allow_auto_disable "
              "enable_wind plugin "},
    {"include", "uri name pose static placement_frame plugin "},
    {"frame", "pose "},
    {"link", "pose inertial visual collision gravity self_collide enable_wind must_be_base_link "
             "sensor light "
             "plugin projector audio_sink audio_source "},
    {"inertial", "pose mass inertia density auto_inertia_params "},
    {"inertia", "ixx iyy izz ixy ixz iyz "},
    {"joint", "pose parent child axis axis2 physics sensor plugin thread_pitch screw_thread_pitch "
              "gearbox_ratio "
              "gearbox_reference_body "},
    {"axis", "xyz limit dynamics mimic use_parent_model_frame initial_position "},
    {"axis2", "xyz limit dynamics mimic use_parent_model_frame initial_position "},
    {"limit", "lower upper effort velocity stiffness dissipation "},
    {"dynamics", "damping friction spring_stiffness spring_reference "},
    {"mimic", "multiplier offset reference "},
    {"visual",
     "pose geometry material transparency cast_shadows laser_retro visibility_flags plugin meta "},
    {"material", "ambient diffuse specular emissive shininess lighting render_order double_sided "
                 "script shader "},
    {"collision", "pose geometry surface laser_retro max_contacts density auto_inertia_params "},
};

static const char *words_of(const char *element)
{
    for (size_t k = 0; k < sizeof words / sizeof *words; ++k)
        if (strcmp(words[k][0], element) == 0) return words[k][1];
    return NULL;
}

static bool has_word(const char *list, const char *word)
{
    const size_t length = strlen(word);
    for (const char *at = list; (at = strstr(at, word)); at += length)
        if ((at == list || at[-1] == ' ') && at[length] == ' ') return true;
    return false;
}

void mbsri_sdf_find_words(mbsri_scene *s, const mbsri_element *root)
{
    for (const mbsri_element *e = root; e;) {
        const char *list = words_of(e->name);
        for (const mbsri_element *c = list ? e->child : NULL; c; c = c->next)
            if (!has_word(list, c->name) && !strchr(c->name, ':'))
                mbsri_file_find(s, c, "elements of this kind are left out, with all in them");
        if (list && e->child) {
            e = e->child;
            continue;
        }
        while (e != root && !e->next) e = e->parent;
        e = e == root ? NULL : e->next;
    }
}

/* Colours of shapes: see colours.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/colours.h"

/* ---- URDF ---- */

static bool keep_coloured(mbsri_scene *s, const mbsri_element *of, mbsri_looks *to)
{
    for (const mbsri_element *e = mbsri_child(of, "material"); e; e = mbsri_next(e)) {
        if (mbsri_child(e, "color") && !mbsri_looks_keep(s->arena, e, to)) return false;
    }
    return true;
}

bool mbsri_urdf_looks(mbsri_scene *s, const mbsri_element *robot, mbsri_looks *materials)
{
    if (!keep_coloured(s, robot, materials)) return false;
    for (const mbsri_element *e = mbsri_child(robot, "link"); e; e = mbsri_next(e)) {
        for (const mbsri_element *v = mbsri_child(e, "visual"); v; v = mbsri_next(v)) {
            if (!keep_coloured(s, v, materials)) return false;
        }
    }
    return true;
}

bool mbsri_urdf_colour(mbsri_scene *s, const mbsri_element *e, const mbsri_looks *materials,
                       mbsr_file_shape *shape)
{
    const mbsri_element *material = mbsri_child(e, "material"),
                        *colour = mbsri_child(material, "color");
    int count;
    if (mbsri_child(material, "texture")) mbsri_file_find(s, material, "its picture is not drawn");
    if (material && !colour)
        colour =
            mbsri_child(mbsri_looks_find(materials, mbsri_attribute(material, "name")), "color");
    if (!colour) return true;
    if (!mbsri_numbers(s, colour, "rgba", mbsri_attribute(colour, "rgba"), 4, 4, shape->colour,
                       &count))
        return false;
    shape->coloured = count > 0;
    return true;
}

/* ---- MJCF ---- */

bool mbsri_mjcf_looks(mbsri_scene *s, const mbsri_element *list, const char *kind, mbsri_looks *to)
{
    for (const mbsri_element *e = mbsri_child(list, kind); e; e = mbsri_next(e)) {
        if (!mbsri_looks_keep(s->arena, e, to)) return false;
    }
    return true;
}

/* By the first colour of a texture that is computed; those of files are not read. */
static bool tint(mbsri_mjcf *m, const mbsri_element *texture, double rgba[4])
{
    double first[3] = {0.8, 0.8, 0.8};
    if (!texture || !mbsri_attribute(texture, "builtin")) return true;
    if (!mbsri_numbers(m->s, texture, "rgb1", mbsri_attribute(texture, "rgb1"), 3, 3, first, NULL))
        return false;
    for (int k = 0; k < 3; ++k) rgba[k] *= first[k];
    return true;
}

bool mbsri_mjcf_colour(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_shape *shape)
{
    const mbsri_element *material =
        mbsri_looks_find(&m->materials, mbsri_mjcf_get(node, "material"));
    mbsri_mjcf_part look;
    int given = 0;
    if (material) {
        for (int k = 0; k < 4; ++k) shape->colour[k] = 1.0;
        if (!mbsri_mjcf_node(m, material, "material", NULL, &look) ||
            !mbsri_mjcf_numbers(m, &look, "rgba", 0, 4, shape->colour, NULL) ||
            !tint(m, mbsri_looks_find(&m->textures, mbsri_mjcf_get(&look, "texture")),
                  shape->colour))
            return false;
    }
    if (!mbsri_mjcf_numbers(m, node, "rgba", 0, 4, shape->colour, &given)) return false;
    shape->coloured = material || given > 0;
    return true;
}

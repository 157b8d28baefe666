/* What the parts of the reader of URDF share: see urdf_parts.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/urdf_parts.h"

#include <string.h>

mbsr_frame mbsri_rpy_frame(const double x[3], const double rpy[3])
{
    static const double axes[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    mbsr_frame frame = mbsr_frame_rotated(x, axes[2], rpy[2]);
    for (int k = 1; k >= 0; --k) {
        const mbsr_frame turn = mbsr_frame_rotated(NULL, axes[k], rpy[k]);
        frame = mbsr_frame_product(&frame, &turn);
    }
    return frame;
}

bool mbsri_urdf_place(mbsri_scene *s, const mbsri_element *of, const mbsri_element *e,
                      mbsr_frame *frame)
{
    double x[3] = {0.0}, rpy[3] = {0.0};
    if (e && !(mbsri_numbers(s, of, "xyz", mbsri_attribute(e, "xyz"), 3, 3, x, NULL) &&
               mbsri_numbers(s, of, "rpy", mbsri_attribute(e, "rpy"), 3, 3, rpy, NULL)))
        return false;
    *frame = mbsri_rpy_frame(x, rpy);
    return true;
}

const char *mbsri_package_path(mbsri_scene *s, const char *name)
{
    static const char *const schemes[] = {"package://", "model://"};
    const char *package = NULL;
    if (name && strncmp(name, "file://", 7) == 0) return name + 7;
    for (int k = 0; k < 2 && name; ++k)
        if (strncmp(name, schemes[k], strlen(schemes[k])) == 0) package = name + strlen(schemes[k]);
    if (!package) return name;
    const size_t length = strcspn(package, "/");
    for (int k = 0; k < s->opt->packages; ++k) {
        const mbsr_file_package *p = s->opt->package + k;
        if (strlen(p->name) != length || strncmp(p->name, package, length) != 0) continue;
        return mbsri_arena_join(s->arena, p->folder, package + length, "");
    }
    return name;
}

mbsri_scene_joint *mbsri_urdf_joint(mbsri_scene *s, const mbsri_element *e,
                                    mbsr_file_joint_kind kind, const double axis[3])
{
    const char *name = mbsri_attribute(e, "name");
    mbsri_scene_joint *j = mbsri_list_add(s->arena, &s->joints, sizeof *j);
    if (!j) return NULL;
    *j = (mbsri_scene_joint){.limit_reference = {0.02, 1.0},
                             .limit_impedance = 1.0,
                             .element = e,
                             .joint = {.name = name ? name : "", .kind = kind}};
    memcpy(j->axis, axis, sizeof j->axis);
    return j;
}

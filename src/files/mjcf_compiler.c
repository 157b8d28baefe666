/* Options of the compiler of MJCF.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mjcf_parts.h"
#include "files/numbers.h"

#include <string.h>

bool mbsri_mjcf_add_compiler(mbsri_mjcf *m, const char *home, int *number)
{
    *number = m->compilers.count;
    mbsri_compiler *to = mbsri_list_add(m->s->arena, &m->compilers, sizeof *to);
    if (!to) return false;
    *to = (mbsri_compiler){.autolimits = true,
                           .sequence = "xyz",
                           .from_shapes = MBSRI_SHAPES_AUTO,
                           .groups = {0.0, 5.0},
                           .home = home};
    return true;
}

/* What the compiler of MuJoCo would change in a model. */
static void find_changes(mbsri_mjcf *m, const mbsri_element *e)
{
    static const char *const names[] = {"boundmass", "boundinertia"};
    for (int k = 0; k < 2; ++k) {
        const char *value = mbsri_attribute(e, names[k]);
        double x;
        if (value && mbsri_read_numbers(value, 1, 1, &x) == 1 && x > 0.0)
            mbsri_file_find(m->s, e, "%s is not applied: masses stay as they are", names[k]);
    }
    const char *balance = mbsri_attribute(e, "balanceinertia");
    if (balance && strcmp(balance, "true") == 0)
        mbsri_file_find(m->s, e, "balanceinertia is not applied: tensors stay as they are");
}

/* Of the file itself. */
static bool read_total(mbsri_mjcf *m, const mbsri_element *e)
{
    const mbsri_mjcf_part node = {.e = e};
    double other = 0.0;
    if (!mbsri_mjcf_number(m, &node, "settotalmass", e->model == 0 ? &m->total : &other))
        return false;
    if (other > 0.0)
        mbsri_file_find(m->s, e, "settotalmass of a model that is attached is not applied");
    return true;
}

bool mbsri_mjcf_read_compiler(mbsri_mjcf *m, const mbsri_element *e)
{
    mbsri_compiler *c = mbsri_mjcf_compiler(m, e);
    const mbsri_mjcf_part node = {.e = e};
    const char *angle = mbsri_attribute(e, "angle"), *sequence = mbsri_attribute(e, "eulerseq"),
               *shapes = mbsri_attribute(e, "inertiafromgeom"),
               *coordinate = mbsri_attribute(e, "coordinate"),
               *folder = mbsri_attribute(e, "meshdir"), *assets = mbsri_attribute(e, "assetdir");
    if (angle) c->radian = strcmp(angle, "radian") == 0;
    if (folder || assets) c->folder = folder ? folder : assets;
    c->align = mbsri_mjcf_switch(&node, "alignfree", c->align);
    c->strip = mbsri_mjcf_switch(&node, "strippath", c->strip);
    c->exact = mbsri_mjcf_switch(&node, "exactmeshinertia", c->exact);
    c->fit_around = mbsri_mjcf_switch(&node, "fitaabb", c->fit_around);
    c->autolimits = mbsri_mjcf_switch(&node, "autolimits", c->autolimits);
    if (coordinate && strcmp(coordinate, "global") == 0)
        return mbsri_file_refuse(m->s, e, "global coordinates are not read");
    if (sequence) {
        if (strlen(sequence) != 3 || strspn(sequence, "xyzXYZ") != 3)
            return mbsri_file_refuse(m->s, e, "eulerseq=\"%.20s\" is not three axes", sequence);
        memcpy(c->sequence, sequence, sizeof c->sequence);
    }
    if (shapes)
        c->from_shapes = strcmp(shapes, "auto") == 0                          ? MBSRI_SHAPES_AUTO
                         : mbsri_mjcf_switch(&node, "inertiafromgeom", false) ? MBSRI_SHAPES_ALWAYS
                                                                              : MBSRI_SHAPES_NEVER;
    find_changes(m, e);
    return read_total(m, e) &&
           mbsri_mjcf_numbers(m, &node, "inertiagrouprange", 2, 2, c->groups, NULL);
}

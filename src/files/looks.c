/* Elements that others name: see looks.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/looks.h"

bool mbsri_looks_keep(mbsri_arena *arena, const mbsri_element *e, mbsri_looks *to)
{
    const char *name = mbsri_attribute(e, "name");
    if (!name || mbsri_names_find(&to->names, name) >= 0) return true;
    const int number = to->elements.count;
    const mbsri_element **place = mbsri_list_add(arena, &to->elements, sizeof *place);
    if (!place) return false;
    *place = e;
    return mbsri_names_add(arena, &to->names, name, number);
}

const mbsri_element *mbsri_looks_find(const mbsri_looks *looks, const char *name)
{
    const int number = mbsri_names_find(&looks->names, name);
    return number < 0 ? NULL : ((const mbsri_element *const *)looks->elements.items)[number];
}

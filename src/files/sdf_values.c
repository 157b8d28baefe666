/* Values in the children of elements of SDF.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/sdf_parts.h"

#include <string.h>

bool mbsri_sdf_numbers(mbsri_scene *s, const mbsri_element *e, const char *child, int count,
                       double *to)
{
    return mbsri_numbers(s, e, child, mbsri_text_of(e, child), count, count, to, NULL);
}

bool mbsri_sdf_switch(const mbsri_element *e, const char *child, bool missing)
{
    const char *text = mbsri_text_of(e, child);
    if (!text) return missing;
    text += strspn(text, " \t\r\n");
    return *text == '1' || strncmp(text, "true", 4) == 0 || strncmp(text, "True", 4) == 0 ||
           strncmp(text, "TRUE", 4) == 0;
}

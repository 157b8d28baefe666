/* Names of variables, as variableNamingConvention="structured" has them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_NAMES_H
#define MBSRI_FMU_NAMES_H

#include "files/arena.h"

/* group.label.part[index], without what is "" or 0; a label that is no identifier is quoted. NULL:
 * no memory. */
char *mbsri_name(mbsri_arena *arena, const char *group, const char *label, const char *part,
                 int index);

/* The name of a part, or what stands for it: "body3". NULL: no memory. */
const char *mbsri_fmu_label(mbsri_arena *arena, const char *part, const char *name, int id);

/* The label with ? for what is no printable character of ASCII. */
char *mbsri_printable(mbsri_arena *arena, const char *label);

/* The label as an identifier of C, for names of files and functions. */
char *mbsri_identifier(mbsri_arena *arena, const char *label);

#endif

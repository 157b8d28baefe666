/* What goes into every FMU: the shared object and the set of sources.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_BINARY_H
#define MBSRI_FMU_BINARY_H

#include <stddef.h>

/* The bytes of the shared object; NULL: the library was built without. */
const unsigned char *mbsri_fmu_binary(size_t *size);

/* The set of sources as cmake/SourceSet.cmake writes it: of each file a line with its name and its
 * length in bytes, then the file and a line's end; NULL: the library was built without. */
const char *mbsri_fmu_source_set(size_t *size);

/* The folder and the ending that the standard gives a shared object of this system, by its version;
 * NULL: it names none. */
const char *mbsri_fmu_platform(int version);
const char *mbsri_fmu_ending(void);

#endif

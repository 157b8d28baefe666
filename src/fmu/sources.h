/* The sources that go into a source FMU.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_SOURCES_H
#define MBSRI_FMU_SOURCES_H

#include "fmu/zip.h"

/* Files below sources/, in memory of an arena. */
typedef struct mbsri_unit_sources {
    int count;
    mbsri_zip_file *file;
} mbsri_unit_sources;

/* The set of sources for a version of the standard, with the model as an array of bytes and, for
 * FMI 3.0, buildDescription.xml. False: the library was built without the set; where there is no
 * memory the arena has failed. */
bool mbsri_list_sources(mbsri_unit_sources *sources, mbsri_arena *arena, int version,
                        const char *identifier, const unsigned char *model, size_t size);

/* The name of a source to be compiled, without its folder; NULL: the file is a header. */
const char *mbsri_source_name(const mbsri_zip_file *file);

#endif

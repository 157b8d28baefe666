/* An archive of files, stored as they are (ZIP, PKWARE's APPNOTE 6.3).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_ZIP_H
#define MBSRI_FMU_ZIP_H

#include "fmu/stream.h"

typedef struct mbsri_zip_file {
    const char *name; /* with / between folders */
    const unsigned char *data;
    size_t size;
} mbsri_zip_file;

/* In memory of the arena; NULL: no memory, or more than 4 GiB. */
const unsigned char *mbsri_zip(mbsri_arena *arena, int count, const mbsri_zip_file *file,
                               size_t *size);

#endif

/* The model of a set of sources, which has it as an array of bytes: see resource.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/resource.h"

#include <stdlib.h>
#include <string.h>

/* In model.c, which the exporter writes. */
extern const unsigned char mbsri_model_bytes[];
extern const size_t mbsri_model_size;

unsigned char *mbsri_read_resource(const char *folder, size_t *size)
{
    unsigned char *data = malloc(mbsri_model_size);
    (void)folder;
    if (data) memcpy(data, mbsri_model_bytes, mbsri_model_size);
    *size = mbsri_model_size;
    return data;
}

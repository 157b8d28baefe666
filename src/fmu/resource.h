/* The model of an FMU as bytes.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_RESOURCE_H
#define MBSRI_FMU_RESOURCE_H

#include <stddef.h>

/* In memory of malloc; NULL: it cannot be read, or there is no memory. resource.c reads it from the
 * folder of the resources, source_model.c has it in the program. */
unsigned char *mbsri_read_resource(const char *folder, size_t *size);

#endif

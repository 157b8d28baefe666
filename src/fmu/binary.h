/* The shared object that goes into every FMU.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_BINARY_H
#define MBSRI_FMU_BINARY_H

#include <stddef.h>

/* Its bytes; NULL: the library was built without. */
const unsigned char *mbsri_fmu_binary(size_t *size);

/* The folder and the ending that the standard gives a shared object of this system, by its version;
 * NULL: it names none. */
const char *mbsri_fmu_platform(int version);
const char *mbsri_fmu_ending(void);

#endif

/* States of an instance, kept and brought back.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_SAVED_H
#define MBSRI_FMU_SAVED_H

#include "fmu/instance.h"

typedef struct mbsri_saved mbsri_saved;

/* A step after mbsri_save begins as it does after mbsri_restore, so that it is the same to the last
 * bit. *saved may be one that was made before, which is written over. */
mbsri_result mbsri_save(mbsri_instance *in, const char *function, mbsri_saved **saved);
mbsri_result mbsri_restore(mbsri_instance *in, const char *function, const mbsri_saved *saved);
void mbsri_saved_destroy(mbsri_saved *saved); /* NULL is allowed */

/* As bytes, for the same FMU in another process. */
size_t mbsri_saved_size(const mbsri_saved *saved);
mbsri_result mbsri_serialize(mbsri_instance *in, const char *function, const mbsri_saved *saved,
                             unsigned char *bytes, size_t size);
mbsri_result mbsri_deserialize(mbsri_instance *in, const char *function, const unsigned char *bytes,
                               size_t size, mbsri_saved **saved);

#endif

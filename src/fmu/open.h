/* Making, freeing and resetting instances.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_OPEN_H
#define MBSRI_FMU_OPEN_H

#include "fmu/instance.h"

/* Reads the plan of `folder`, the resources, with or without a separator at its end, and holds
 * `token` against it. NULL, after a message by *as, of which name, exchange, log, logger,
 * environment, callback are taken. */
mbsri_instance *mbsri_instance_create(const mbsri_instance *as, const char *folder,
                                      const char *token);
void mbsri_instance_destroy(mbsri_instance *in); /* NULL is allowed */

/* As it was created. */
mbsri_result mbsri_instance_reset(mbsri_instance *in);

#endif

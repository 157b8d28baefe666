/* Bodies of a model that is not finished.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ENTRY_RECORD_H
#define MBSRI_ENTRY_RECORD_H

#include "model/record.h"

/* The record of a body that was added, for amendments by `function`; NULL: refused with
 * MBSR_ERR_FINISHED or MBSR_ERR_ID in *status, MBSR_OK otherwise. */
mbsri_body_entry *mbsri_find_entry(mbsr_model *m, int body, const char *function, int *status);

#endif

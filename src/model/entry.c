/* Bodies of a model that is not finished.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "model/entry.h"

#include "base/error.h"

mbsri_body_entry *mbsri_find_entry(mbsr_model *m, int body, const char *function, int *status)
{
    *status = MBSR_OK;
    if (m->finished) {
        *status = mbsri_fail(&m->error, MBSR_ERR_FINISHED, MBSR_NONE, MBSR_NONE,
                             "%s: the model is finished and cannot be changed", function);
    } else if (body < 0 || (size_t)body >= m->entries.count) {
        *status = mbsri_fail(&m->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                             "%s: there is no body %d yet", function, body);
    }
    return *status ? NULL : (mbsri_body_entry *)m->entries.data + body;
}

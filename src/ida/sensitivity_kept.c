/* Sensitivities of runs: memory and failures.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/error.h"
#include "ida/sensitivity_record.h"

#include <stdlib.h>

bool mbsri_sensitivity_reserve(mbsri_kept *array, size_t more, size_t element)
{
    const size_t needed = array->count + more, twice = 2 * array->capacity;
    if (needed <= array->capacity) return true;
    const size_t capacity = needed > twice ? needed : twice;
    void *data = realloc(array->data, capacity * element);
    if (!data) return false;
    array->data = data;
    array->capacity = capacity;
    return true;
}

double *mbsri_sensitivity_take(size_t count)
{
    return calloc(count + 1, sizeof(double));
}

void mbsri_sensitivity_free(void *memory)
{
    free(memory);
}

int mbsri_sensitivity_fail(mbsr_sensitivity *s, int status, const mbsr_error *why,
                           const char *function)
{
    return mbsri_ida_pass_on(&s->error, status, why, "%s", function);
}

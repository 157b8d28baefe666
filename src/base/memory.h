/* Memory by the caller's allocator, and arrays that grow.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MEMORY_H
#define MBSRI_MEMORY_H

#include <mbsrank/model.h>

#include <stdbool.h>
#include <stddef.h>

/* A growing array; `count` elements of it are in use. */
typedef struct mbsri_array {
    void *data;
    size_t count, capacity;
} mbsri_array;

void *mbsri_allocate(const mbsr_allocator *allocator, size_t size);
void mbsri_release(const mbsr_allocator *allocator, void *memory);

/* Makes room for `more` elements behind those in use; false if memory is short (the array is then
 * unchanged). */
bool mbsri_reserve(const mbsr_allocator *allocator, mbsri_array *array, size_t more,
                   size_t element);

#endif

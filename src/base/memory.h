/* Memory by the caller's allocator, and arrays that grow.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MEMORY_H
#define MBSRI_MEMORY_H

#include <mbsrank/data.h>
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

/* The next `size` bytes of a block, or NULL where there is no block yet and sizes are counted:
 * *used grows, by whole multiples of MBSR_DATA_ALIGNMENT. */
static inline void *mbsri_take_bytes(unsigned char *block, size_t *used, size_t size)
{
    void *here = block ? block + *used : NULL;
    *used += (size + MBSR_DATA_ALIGNMENT - 1) / MBSR_DATA_ALIGNMENT * MBSR_DATA_ALIGNMENT;
    return here;
}

/* The next `count` numbers at *memory, which moves on; NULL: they are counted. */
static inline double *mbsri_take(double **memory, size_t *used, size_t count)
{
    double *here = *memory;
    if (here) *memory += count;
    *used += count;
    return here;
}

/* Makes room for `more` elements behind those in use; false if memory is short (the array is then
 * unchanged). */
bool mbsri_reserve(const mbsr_allocator *allocator, mbsri_array *array, size_t more,
                   size_t element);

#endif

/* Memory by the caller's allocator, and arrays that grow.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MEMORY_H
#define MBSRI_MEMORY_H

#include <mbsrank/data.h>
#include <mbsrank/model.h>

#include <stdbool.h>
#include <stddef.h>

#if defined(MBSR_FENCES)
#include <sanitizer/asan_interface.h>
#endif

/* A growing array; `count` elements of it are in use. */
typedef struct mbsri_array {
    void *data;
    size_t count, capacity;
} mbsri_array;

void *mbsri_allocate(const mbsr_allocator *allocator, size_t size);
void mbsri_release(const mbsr_allocator *allocator, void *memory);

/* With MBSR_FENCES, which needs the address sanitizer, MBSRI_FENCE bytes between two arrays of one
 * block may not be touched, nor what an array is short of a whole line; elsewhere there are none.
 */
#if defined(MBSR_FENCES)
#define MBSRI_FENCE ((size_t)MBSR_DATA_ALIGNMENT)
#else
#define MBSRI_FENCE ((size_t)0)
#endif

/* May bytes be touched? */
static inline void mbsri_fence(void *memory, size_t size, bool open)
{
#if defined(MBSR_FENCES)
    if (open)
        ASAN_UNPOISON_MEMORY_REGION(memory, size);
    else
        ASAN_POISON_MEMORY_REGION(memory, size);
#else
    (void)memory;
    (void)size;
    (void)open;
#endif
}

/* The next `size` bytes of a block, or NULL where there is no block yet and sizes are counted:
 * *used grows, by whole multiples of MBSR_DATA_ALIGNMENT. */
static inline void *mbsri_take_bytes(unsigned char *block, size_t *used, size_t size)
{
    const size_t lines = (size + MBSR_DATA_ALIGNMENT - 1) / MBSR_DATA_ALIGNMENT,
                 whole = lines * MBSR_DATA_ALIGNMENT + MBSRI_FENCE;
    unsigned char *here = block ? block + *used : NULL;
    *used += whole;
    if (!here) return NULL;
    mbsri_fence(here, size, true);
    mbsri_fence(here + size, whole - size, false);
    return here;
}

/* The next `count` numbers at *memory, which moves on; NULL: they are counted. No fences: such
 * memory is laid out in more than one way. */
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

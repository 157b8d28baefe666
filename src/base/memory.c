/* The caller's allocator, or malloc and free.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void *mbsri_allocate(const mbsr_allocator *allocator, size_t size)
{
    if (size == 0) size = 1;
    return allocator->allocate ? allocator->allocate(allocator->user, size) : malloc(size);
}

void mbsri_release(const mbsr_allocator *allocator, void *memory)
{
    if (!memory) return;
    if (allocator->release) {
        allocator->release(allocator->user, memory);
    } else {
        free(memory);
    }
}

bool mbsri_reserve(const mbsr_allocator *allocator, mbsri_array *array, size_t more, size_t element)
{
    if (array->count + more <= array->capacity) return true;
    size_t capacity = array->capacity ? array->capacity : 8;
    while (capacity < array->count + more) {
        if (capacity > SIZE_MAX / 2 / element) return false;
        capacity *= 2;
    }
    void *data = mbsri_allocate(allocator, capacity * element);
    if (!data) return false;
    if (array->count > 0) memcpy(data, array->data, array->count * element);
    mbsri_release(allocator, array->data);
    array->data = data;
    array->capacity = capacity;
    return true;
}

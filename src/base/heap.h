/* A heap of numbers with scores: which comes next in a greedy order.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_HEAP_H
#define MBSRI_HEAP_H

#include "base/memory.h"

/* `version`: of its score, where that may have changed since. */
typedef struct mbsri_key {
    double score;
    int vertex, version;
} mbsri_key;

/* heap: of mbsri_key. False: there is no memory. */
bool mbsri_heap_insert(const mbsr_allocator *allocator, mbsri_array *heap, mbsri_key now);

/* The least score, of equal ones the largest number; the heap is not empty. */
mbsri_key mbsri_heap_take(mbsri_array *heap);

#endif

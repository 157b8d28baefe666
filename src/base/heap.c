/* A heap of numbers with scores: see heap.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/heap.h"

static bool is_less(mbsri_key a, mbsri_key b)
{
    return a.score < b.score || (a.score == b.score && a.vertex > b.vertex);
}

bool mbsri_heap_insert(const mbsr_allocator *allocator, mbsri_array *heap, mbsri_key now)
{
    if (!mbsri_reserve(allocator, heap, 1, sizeof now)) return false;
    mbsri_key *key = heap->data;
    size_t at = heap->count++;
    for (; at > 0 && is_less(now, key[(at - 1) / 2]); at = (at - 1) / 2)
        key[at] = key[(at - 1) / 2];
    key[at] = now;
    return true;
}

mbsri_key mbsri_heap_take(mbsri_array *heap)
{
    mbsri_key *key = heap->data, top = key[0], last = key[--heap->count];
    size_t at = 0, count = heap->count;
    for (size_t child = 1; child < count; child = 2 * at + 1) {
        if (child + 1 < count && is_less(key[child + 1], key[child])) ++child;
        if (!is_less(key[child], last)) break;
        key[at] = key[child];
        at = child;
    }
    if (count > 0) key[at] = last;
    return top;
}

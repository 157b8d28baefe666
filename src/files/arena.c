/* Memory of what is read: see arena.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/arena.h"

#include <limits.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef union header {
    struct mbsri_arena_block {
        struct mbsri_arena_block *next;
        size_t size, used;
    } block;
    max_align_t align;
} header;

/* Bytes; 0: each piece has a block of its own, so that in tests every piece may be refused. */
#if !defined(MBSRI_ARENA_BLOCK)
#define MBSRI_ARENA_BLOCK (1 << 16)
#endif

static void *take_memory(const mbsr_allocator *a, size_t size)
{
    return a->allocate ? a->allocate(a->user, size) : malloc(size);
}

static void release(const mbsr_allocator *a, void *memory)
{
    if (a->release)
        a->release(a->user, memory);
    else
        free(memory);
}

void mbsri_arena_open(mbsri_arena *arena, const mbsr_allocator *allocator)
{
    *arena = (mbsri_arena){.allocator = *allocator};
}

void mbsri_arena_close(mbsri_arena *arena)
{
    while (arena->block) {
        struct mbsri_arena_block *next = arena->block->next;
        release(&arena->allocator, arena->block);
        arena->block = next;
    }
}

static bool add_block(mbsri_arena *arena, size_t size)
{
    header *h = NULL;
    if (size < SIZE_MAX - sizeof *h) h = take_memory(&arena->allocator, sizeof *h + size);
    if (!h) {
        arena->failed = true;
        return false;
    }
    h->block.next = arena->block;
    h->block.size = size;
    h->block.used = 0;
    arena->block = &h->block;
    return true;
}

void *mbsri_arena_take(mbsri_arena *arena, size_t size)
{
    const size_t unit = sizeof(max_align_t);
    if (arena->failed || size > SIZE_MAX / 2) {
        arena->failed = true;
        return NULL;
    }
    const size_t need = (size + unit - 1) / unit * unit;
    if (!arena->block || arena->block->size - arena->block->used < need) {
        if (!add_block(arena, need > MBSRI_ARENA_BLOCK ? need : MBSRI_ARENA_BLOCK)) return NULL;
    }
    unsigned char *place = (unsigned char *)((header *)(void *)arena->block + 1);
    place += arena->block->used;
    arena->block->used += need;
    memset(place, 0, need);
    return place;
}

char *mbsri_arena_text(mbsri_arena *arena, const char *text, size_t length)
{
    char *copy = mbsri_arena_take(arena, length + 1);
    if (copy) memcpy(copy, text, length);
    return copy;
}

char *mbsri_arena_folder(mbsri_arena *arena, const char *path)
{
    const char *slash = strrchr(path, '/');
    return mbsri_arena_text(arena, path, slash ? (size_t)(slash - path) + 1 : 0);
}

char *mbsri_arena_join(mbsri_arena *arena, const char *a, const char *b, const char *c)
{
    const size_t size[3] = {strlen(a), strlen(b), strlen(c)};
    char *text = mbsri_arena_take(arena, size[0] + size[1] + size[2] + 1);
    if (!text) return NULL;
    memcpy(text, a, size[0]);
    memcpy(text + size[0], b, size[1]);
    memcpy(text + size[0] + size[1], c, size[2]);
    return text;
}

void *mbsri_list_add(mbsri_arena *arena, mbsri_list *list, size_t size)
{
    if (list->count == list->room) {
        if (list->room > INT_MAX / 4) arena->failed = true;
        const int room = list->room > 0 ? 2 * list->room : 8;
        void *items = mbsri_arena_take(arena, (size_t)room * size);
        if (!items) return NULL;
        if (list->count > 0) memcpy(items, list->items, (size_t)list->count * size);
        list->items = items;
        list->room = room;
    }
    return (unsigned char *)list->items + (size_t)list->count++ * size;
}

/* Memory of what is read: taken piece by piece, released all at once.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_ARENA_H
#define MBSRI_FILES_ARENA_H

#include <mbsrank/base.h>

#include <stdbool.h>

typedef struct mbsri_arena {
    mbsr_allocator allocator;
    struct mbsri_arena_block *block;
    bool failed; /* there was no memory: everything taken since is NULL */
} mbsri_arena;

void mbsri_arena_open(mbsri_arena *arena, const mbsr_allocator *allocator);
void mbsri_arena_close(mbsri_arena *arena);

/* Zeros, aligned for any object; NULL: no memory. */
void *mbsri_arena_take(mbsri_arena *arena, size_t size);

/* A copy with a NUL behind it. */
char *mbsri_arena_text(mbsri_arena *arena, const char *text, size_t length);

/* Three texts behind each other, with a NUL. */
char *mbsri_arena_join(mbsri_arena *arena, const char *a, const char *b, const char *c);

/* The folder of a path, with its slash. */
char *mbsri_arena_folder(mbsri_arena *arena, const char *path);

/* A growing array: `items` of `count`, with room for one more; false: no memory. */
typedef struct mbsri_list {
    void *items;
    int count, room;
} mbsri_list;

/* One more, of zeros; NULL: no memory. Items may move. */
void *mbsri_list_add(mbsri_arena *arena, mbsri_list *list, size_t size);

#endif

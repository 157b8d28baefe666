/* Numbers by name: see names.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/names.h"

#include <stdint.h>
#include <string.h>

/* FNV-1a */
static uint64_t hash(const char *name)
{
    uint64_t h = UINT64_C(14695981039346656037);
    for (; *name; ++name) h = (h ^ (unsigned char)*name) * UINT64_C(1099511628211);
    return h;
}

/* Where the name is, or would be; room is a power of 2 and not full. */
static mbsri_name *slot_of(const mbsri_names *names, const char *name)
{
    size_t at = (size_t)hash(name) & (names->room - 1);
    while (names->slot[at].name && strcmp(names->slot[at].name, name) != 0)
        at = (at + 1) & (names->room - 1);
    return names->slot + at;
}

int mbsri_names_find(const mbsri_names *names, const char *name)
{
    if (!name || names->room == 0) return -1;
    const mbsri_name *at = slot_of(names, name);
    return at->name ? at->number : -1;
}

const char *mbsri_names_same(const mbsri_names *names, const char *name)
{
    return names->room > 0 ? slot_of(names, name)->name : NULL;
}

bool mbsri_names_add(mbsri_arena *arena, mbsri_names *names, const char *name, int number)
{
    if (2 * names->count >= names->room) {
        const mbsri_names old = *names;
        names->room = old.room > 0 ? 2 * old.room : 64;
        names->slot = mbsri_arena_take(arena, names->room * sizeof *names->slot);
        if (!names->slot) {
            *names = old;
            return false;
        }
        for (size_t k = 0; k < old.room; ++k) {
            if (old.slot[k].name) *slot_of(names, old.slot[k].name) = old.slot[k];
        }
    }
    *slot_of(names, name) = (mbsri_name){name, number};
    ++names->count;
    return true;
}

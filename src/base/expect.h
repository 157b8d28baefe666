/* Memory that is read or written soon, asked for beforehand: large models do not fit into caches.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_EXPECT_H
#define MBSRI_EXPECT_H

#include <stdint.h>

/* Bytes of a line of the cache; bodies beyond which trees count as larger than a cache. */
enum { MBSRI_LINE = 64, MBSRI_LARGE = 2000 };

#if defined(__GNUC__)
#define MBSRI_PREFETCH(at, write) __builtin_prefetch(at, write)
#else
#define MBSRI_PREFETCH(at, write) (void)(at)
#endif

/* The lines of [from, to), to be read, and to be written. */
static inline void mbsri_expect(const void *from, const void *to)
{
    const char *at = (const char *)from - (uintptr_t)from % MBSRI_LINE;
    for (; at < (const char *)to; at += MBSRI_LINE) MBSRI_PREFETCH(at, 0);
}

static inline void mbsri_expect_room(const void *from, const void *to)
{
    const char *at = (const char *)from - (uintptr_t)from % MBSRI_LINE;
    for (; at < (const char *)to; at += MBSRI_LINE) MBSRI_PREFETCH(at, 1);
}

#endif

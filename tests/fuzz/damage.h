/* Damage to texts: cut short, other bytes, pieces elsewhere.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_DAMAGE_H
#define TEST_DAMAGE_H

#include "close.h"

#include <string.h>

static inline size_t test_below(test_rng *rng, size_t n)
{
    return (size_t)(0.5 * (1.0 + test_uniform(rng)) * (double)n) % n;
}

/* Some damage to a text, which has room for `most` bytes; the new size. */
static inline size_t test_damage(test_rng *rng, uint8_t *bytes, size_t size, size_t most)
{
    static const char *const words[] = {"nan", "1e999", "-1", "0",     "\"",
                                        "<",   ">",     "/>", "&amp;", "a"};
    const size_t at = test_below(rng, size), other = test_below(rng, size);
    const char *word = words[test_below(rng, sizeof words / sizeof *words)];
    switch (test_below(rng, 5)) {
    case 0: return at > 0 ? at : 1;
    case 1: bytes[at] = (uint8_t)test_below(rng, 256); return size;
    case 2: { /* a piece once more */
        const size_t length = 1 + test_below(rng, size - other > 200 ? 200 : size - other);
        if (size + length > most) return size;
        memmove(bytes + at + length, bytes + at, size - at);
        memmove(bytes + at, bytes + (other < at ? other : other + length), length);
        return size + length;
    }
    case 3: { /* a piece less */
        const size_t length = 1 + test_below(rng, size - at > 100 ? 100 : size - at);
        if (size <= length) return size;
        memmove(bytes + at, bytes + at + length, size - at - length);
        return size - length;
    }
    default: {
        const size_t length = strlen(word) < size - at ? strlen(word) : size - at;
        memcpy(bytes + at, word, length);
        return size;
    }
    }
}

#endif

/* Numbers that look random and depend on their place alone.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RANDOM_H
#define MBSRI_RANDOM_H

#include <stdint.h>

/* The output function of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014). */
static inline uint64_t mbsri_mix(uint64_t z)
{
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

/* Number `index` of stream `stream` of a seed, 64 bits. */
static inline uint64_t mbsri_hash(uint64_t seed, uint64_t stream, uint64_t index)
{
    const uint64_t golden = UINT64_C(0x9e3779b97f4a7c15);
    return mbsri_mix(mbsri_mix(seed + (stream + 1) * golden) + (index + 1) * golden);
}

/* Between 0 and 1, exclusive. */
static inline double mbsri_unit_number(uint64_t bits)
{
    return ((double)(bits >> 11) + 0.5) / 9007199254740992.0; /* 2^53 */
}

#endif

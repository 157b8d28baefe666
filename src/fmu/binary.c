/* What goes into every FMU, the shared object and the set of sources: their bytes stand in the
 * library, put there by the assembler.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/binary.h"

#include <stdint.h>

#if defined(__GNUC__) && defined(__ELF__)
/* The bytes of a file between two symbols. */
#define EMBED(begin, end, path)                                                                    \
    __asm__(".section .rodata.mbsri_fmu,\"a\"\n"                                                   \
            ".balign 16\n"                                                                         \
            ".globl " #begin "\n"                                                                  \
            ".hidden " #begin "\n"                                                                 \
            ".type " #begin ", %object\n" #begin ":\n"                                             \
            ".incbin \"" path "\"\n"                                                               \
            ".globl " #end "\n"                                                                    \
            ".hidden " #end "\n"                                                                   \
            ".type " #end ", %object\n" #end ":\n"                                                 \
            ".byte 0\n"                                                                            \
            ".previous\n");                                                                        \
    extern const unsigned char begin[], end[]
#endif

#if defined(EMBED) && defined(MBSR_FMU_BINARY)
EMBED(mbsri_fmu_begin, mbsri_fmu_end, MBSR_FMU_BINARY);

const unsigned char *mbsri_fmu_binary(size_t *size)
{
    *size = (size_t)((uintptr_t)mbsri_fmu_end - (uintptr_t)mbsri_fmu_begin);
    return mbsri_fmu_begin;
}
#else
const unsigned char *mbsri_fmu_binary(size_t *size)
{
    *size = 0;
    return NULL;
}
#endif

#if defined(EMBED) && defined(MBSR_FMU_SOURCE_SET)
EMBED(mbsri_fmu_set_begin, mbsri_fmu_set_end, MBSR_FMU_SOURCE_SET);

const char *mbsri_fmu_source_set(size_t *size)
{
    *size = (size_t)((uintptr_t)mbsri_fmu_set_end - (uintptr_t)mbsri_fmu_set_begin);
    return (const char *)mbsri_fmu_set_begin;
}
#else
const char *mbsri_fmu_source_set(size_t *size)
{
    *size = 0;
    return NULL;
}
#endif

#if defined(__x86_64__)
#define MACHINE "x86_64"
#elif defined(__aarch64__)
#define MACHINE "aarch64"
#elif defined(__i386__)
#define MACHINE "x86"
#endif

const char *mbsri_fmu_platform(int version)
{
#if defined(__linux__) && defined(MACHINE)
    if (version == 3) return MACHINE "-linux";
#if defined(__x86_64__)
    return "linux64";
#elif defined(__i386__)
    return "linux32";
#else
    return MACHINE "-linux"; /* which 2.0 has no name for */
#endif
#else
    (void)version;
    return NULL;
#endif
}

const char *mbsri_fmu_ending(void)
{
    return ".so";
}

/* Small functions that are to be part of their callers, as the compiler alone would not always have
 * it. Not where nothing is optimised, or little under sanitizers (MBSR_NOT_INLINED): whole sweeps
 * are made of them, and would be compiled ten to twenty times as long for the same checks.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_INLINED_H
#define MBSRI_INLINED_H

#if defined(__OPTIMIZE__) && defined(__GNUC__) && !defined(MBSR_NOT_INLINED)
#define MBSRI_INLINE static inline __attribute__((always_inline))
#else
#define MBSRI_INLINE static inline
#endif

#endif

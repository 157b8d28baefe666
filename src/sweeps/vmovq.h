/* An encoding of one instruction, for the code with AVX2: valgrind 3.19 decodes vmovq between two
 * registers as a load, not as a store, which the assembler takes where it is a byte shorter.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_VMOVQ_H
#define MBSRI_VMOVQ_H

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
__asm__(".ifndef mbsri_vmovq\n"
        ".set mbsri_vmovq, 1\n"
        ".macro vmovq operands:vararg\n"
        "{load} vmovq \\operands\n"
        ".endm\n"
        ".endif");
#endif

#endif

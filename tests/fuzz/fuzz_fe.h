/* The target of fuzz_fe.c, and good texts to begin with.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef FUZZ_FE_H
#define FUZZ_FE_H

#include <stddef.h>
#include <stdint.h>

enum { FUZZ_FE_TEXTS = 7 };

/* K, M, D, nodes, dofs, markers of a small frame, and a SID file. */
extern const char *const fuzz_fe_text[FUZZ_FE_TEXTS];

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

#endif

/* The target of tests/fuzz/fuzz_model.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_FUZZ_MODEL_H
#define TEST_FUZZ_MODEL_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

#endif

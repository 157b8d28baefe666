/* The memory of readers with a block for each piece: of tests that let every allocation fail.
 * SPDX-License-Identifier: BSD-3-Clause */
#define MBSRI_ARENA_BLOCK 0
#include "files/arena.c"

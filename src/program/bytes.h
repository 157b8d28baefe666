/* Bytes in a page.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_BYTES_H
#define MBSRANK_BYTES_H

#include <stdbool.h>
#include <stdio.h>

/* A string of JSON: the bytes deflated (the format of zlib) and then in base64. Where zlib is not
 * built in, in base64 alone; src/program/viewer/data.js tells one from the other by the first byte,
 * which is 'z' or '-'. False: no memory, and the string is empty. */
bool put_bytes(FILE *to, const void *bytes, size_t size);

/* The same of numbers of 4 bytes, the lowest byte first. */
bool put_floats(FILE *to, size_t count, const float *x);

#endif

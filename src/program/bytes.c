/* Bytes in a page: see bytes.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/bytes.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(MBSR_WITH_ZLIB)
#include <zlib.h>
#endif

static void put_base64(FILE *to, const unsigned char *b, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t k = 0; k < size; k += 3) {
        const size_t left = size - k;
        const unsigned long group = (unsigned long)b[k] << 16 |
                                    (left > 1 ? (unsigned long)b[k + 1] << 8 : 0) |
                                    (left > 2 ? b[k + 2] : 0);
        const char four[4] = {digits[group >> 18], digits[group >> 12 & 63],
                              left > 1 ? digits[group >> 6 & 63] : '=',
                              left > 2 ? digits[group & 63] : '='};
        fwrite(four, 1, 4, to);
    }
}

bool put_bytes(FILE *to, const void *bytes, size_t size)
{
#if defined(MBSR_WITH_ZLIB)
    uLongf shorter = compressBound((uLong)size);
    unsigned char *packed = malloc(shorter);
    const bool good =
        packed && compress2(packed, &shorter, bytes, (uLong)size, Z_DEFAULT_COMPRESSION) == Z_OK;
    fputs("\"z", to);
    if (good) put_base64(to, packed, shorter);
    free(packed);
#else
    const bool good = true;
    fputs("\"-", to);
    put_base64(to, bytes, size);
#endif
    fputc('"', to);
    return good;
}

bool put_floats(FILE *to, size_t count, const float *x)
{
    unsigned char *bytes = malloc(4 * count + 1);
    for (size_t k = 0; k < count && bytes; ++k) {
        uint32_t bits;
        memcpy(&bits, x + k, sizeof bits);
        for (int l = 0; l < 4; ++l) bytes[4 * k + (size_t)l] = (unsigned char)(bits >> 8 * l);
    }
    const bool good = put_bytes(to, bytes, bytes ? 4 * count : 0) && bytes;
    free(bytes);
    return good;
}

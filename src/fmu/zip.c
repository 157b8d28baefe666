/* Archives: see zip.h.
 *
 * Each file has a local header before its bytes and an entry in the directory behind all of them,
 * whose end says where it begins. Files are stored, not compressed, with the first day that the
 * format knows, so that the same files give the same bytes.
 * SPDX-License-Identifier: BSD-3-Clause
 */
#include "fmu/zip.h"

#include <string.h>

enum {
    LOCAL = 0x04034b50,
    CENTRAL = 0x02014b50,
    END = 0x06054b50,
    VERSION = 20,
    LOCAL_SIZE = 30,
    CENTRAL_SIZE = 46,
    END_SIZE = 22,
    FIRST_DAY = 0x21 /* 1 January 1980 */
};

static unsigned char *put16(unsigned char *to, uint32_t x)
{
    *to++ = (unsigned char)(x & 255u);
    *to++ = (unsigned char)(x >> 8 & 255u);
    return to;
}

static unsigned char *put32(unsigned char *to, uint32_t x)
{
    return put16(put16(to, x & 0xffffu), x >> 16);
}

/* What both headers have: time, day, checksum, sizes, lengths of the name and of what follows it.
 */
static unsigned char *put_file(unsigned char *to, const mbsri_zip_file *f, uint32_t crc)
{
    to = put16(to, 0);
    to = put16(to, FIRST_DAY);
    to = put32(to, crc);
    to = put32(to, (uint32_t)f->size);
    to = put32(to, (uint32_t)f->size);
    to = put16(to, (uint32_t)strlen(f->name));
    return put16(to, 0);
}

static unsigned char *put_bytes(unsigned char *to, const void *from, size_t count)
{
    if (count > 0) memcpy(to, from, count);
    return to + count;
}

/* The local header: version, flags, method "stored". */
static unsigned char *put_local(unsigned char *to, const mbsri_zip_file *f, uint32_t crc)
{
    to = put16(put16(put16(put32(to, LOCAL), VERSION), 0), 0);
    to = put_file(to, f, crc);
    to = put_bytes(to, f->name, strlen(f->name));
    return put_bytes(to, f->data, f->size);
}

/* The entry in the directory: besides no comment, disk 0, no attributes, and where the file is. */
static unsigned char *put_central(unsigned char *to, const mbsri_zip_file *f, uint32_t crc,
                                  uint32_t at)
{
    to = put16(put16(put16(put16(put32(to, CENTRAL), VERSION), VERSION), 0), 0);
    to = put_file(to, f, crc);
    to = put16(put16(put16(to, 0), 0), 0);
    to = put32(put32(to, 0), at);
    return put_bytes(to, f->name, strlen(f->name));
}

const unsigned char *mbsri_zip(mbsri_arena *arena, int count, const mbsri_zip_file *file,
                               size_t *size)
{
    size_t files = 0, directory = 0;
    for (int k = 0; k < count; ++k) {
        const size_t name = strlen(file[k].name);
        files += LOCAL_SIZE + name + file[k].size;
        directory += CENTRAL_SIZE + name;
    }
    *size = files + directory + END_SIZE;
    if (*size > UINT32_MAX || count > UINT16_MAX) return NULL;
    unsigned char *data = mbsri_arena_take(arena, *size), *to = data;
    uint32_t *crc = mbsri_arena_take(arena, (size_t)(count + 1) * sizeof *crc);
    uint32_t *at = mbsri_arena_take(arena, (size_t)(count + 1) * sizeof *at);
    if (!data || !crc || !at) return NULL;
    for (int k = 0; k < count; ++k) {
        crc[k] = mbsri_crc32(file[k].data, file[k].size);
        at[k] = (uint32_t)(to - data);
        to = put_local(to, file + k, crc[k]);
    }
    for (int k = 0; k < count; ++k) to = put_central(to, file + k, crc[k], at[k]);
    to = put16(put16(put32(to, END), 0), 0);
    to = put16(put16(to, (uint32_t)count), (uint32_t)count);
    to = put32(put32(to, (uint32_t)directory), (uint32_t)files);
    put16(to, 0);
    return data;
}

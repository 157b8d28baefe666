/* Numbers and texts as bytes: see stream.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/stream.h"

#include <string.h>

mbsri_stream mbsri_stream_write(mbsri_arena *arena)
{
    return (mbsri_stream){.writing = true, .arena = arena};
}

mbsri_stream mbsri_stream_read(mbsri_arena *arena, const unsigned char *data, size_t size)
{
    return (mbsri_stream){.arena = arena, .from = data, .size = size};
}

static void put_bytes(mbsri_stream *s, const unsigned char *bytes, size_t count)
{
    if (s->failed) return;
    if (s->room - s->size < count) {
        const size_t room = 2 * (s->size + count) + 4096;
        unsigned char *larger = mbsri_arena_take(s->arena, room);
        s->failed = !larger;
        if (s->failed) return;
        if (s->size > 0) memcpy(larger, s->data, s->size);
        s->data = larger;
        s->room = room;
    }
    memcpy(s->data + s->size, bytes, count);
    s->size += count;
}

/* The next bytes; NULL: there are not as many. */
static const unsigned char *get(mbsri_stream *s, size_t count)
{
    if (s->failed || s->size - s->at < count) {
        s->failed = true;
        return NULL;
    }
    const unsigned char *bytes = s->from + s->at;
    s->at += count;
    return bytes;
}

static void pass_word(mbsri_stream *s, int bytes, uint64_t *x)
{
    unsigned char piece[8];
    if (s->writing) {
        for (int k = 0; k < bytes; ++k) piece[k] = (unsigned char)(*x >> (8 * k) & 255u);
        put_bytes(s, piece, (size_t)bytes);
        return;
    }
    const unsigned char *from = get(s, (size_t)bytes);
    *x = 0;
    for (int k = 0; from && k < bytes; ++k) *x |= (uint64_t)from[k] << (8 * k);
}

void mbsri_pass_int(mbsri_stream *s, int *x)
{
    uint64_t word = (uint32_t)*x;
    pass_word(s, 4, &word);
    const uint32_t low = (uint32_t)word;
    *x = low <= INT32_MAX ? (int)low : -(int)(UINT32_MAX - low) - 1;
}

void mbsri_pass_number(mbsri_stream *s, double *x)
{
    uint64_t word;
    memcpy(&word, x, sizeof word);
    pass_word(s, 8, &word);
    memcpy(x, &word, sizeof word);
}

void mbsri_pass_numbers(mbsri_stream *s, size_t count, double *x)
{
    for (size_t k = 0; k < count; ++k) mbsri_pass_number(s, x + k);
}

void mbsri_pass_text(mbsri_stream *s, const char **x)
{
    int length = s->writing && *x ? (int)strlen(*x) : 0;
    mbsri_pass_int(s, &length);
    if (s->writing) {
        if (length > 0) put_bytes(s, (const unsigned char *)*x, (size_t)length);
        return;
    }
    const unsigned char *from = length >= 0 ? get(s, (size_t)length) : NULL;
    if (from && memchr(from, 0, (size_t)length)) from = NULL;
    *x = from ? mbsri_arena_text(s->arena, (const char *)from, (size_t)length) : NULL;
    s->failed = s->failed || !*x;
    if (!*x) *x = "";
}

/* Whether there is an array, and room for it where it is read; NULL: there is none. */
static void *pass_place(mbsri_stream *s, size_t count, size_t bytes, size_t size, const void *x)
{
    int there = x != NULL;
    mbsri_pass_int(s, &there);
    if (s->writing || !there) return NULL;
    if (s->failed || (s->size - s->at) / bytes < count) {
        s->failed = true;
        return NULL;
    }
    void *made = mbsri_arena_take(s->arena, (count + 1) * size);
    s->failed = s->failed || !made;
    return made;
}

void mbsri_pass_array(mbsri_stream *s, size_t count, const double **x)
{
    double *made = pass_place(s, count, 8, sizeof *made, *x);
    if (s->writing) {
        for (size_t k = 0; *x && k < count; ++k) {
            double value = (*x)[k];
            mbsri_pass_number(s, &value);
        }
        return;
    }
    if (made) mbsri_pass_numbers(s, count, made);
    *x = made;
}

void mbsri_pass_ints(mbsri_stream *s, size_t count, const int **x)
{
    int *made = pass_place(s, count, 4, sizeof *made, *x);
    for (size_t k = 0; (made || (s->writing && *x)) && k < count; ++k) {
        int value = s->writing ? (*x)[k] : 0;
        mbsri_pass_int(s, &value);
        if (made) made[k] = value;
    }
    if (!s->writing) *x = made;
}

void mbsri_pass_records(mbsri_stream *s, int *count, void **records, size_t size)
{
    mbsri_pass_int(s, count);
    if (s->writing) return;
    *records = NULL;
    if (!s->failed && *count >= 0 && (size_t)*count <= (s->size - s->at) / 8)
        *records = mbsri_arena_take(s->arena, ((size_t)*count + 1) * size);
    if (*records) return;
    s->failed = true;
    *count = 0;
}

uint32_t mbsri_crc32(const unsigned char *data, size_t size)
{
    uint32_t of_byte[256], crc = UINT32_MAX;
    for (uint32_t byte = 0; byte < 256; ++byte) {
        uint32_t x = byte;
        for (int bit = 0; bit < 8; ++bit) x = x >> 1 ^ (UINT32_C(0xedb88320) & (0u - (x & 1u)));
        of_byte[byte] = x;
    }
    for (size_t k = 0; k < size; ++k) crc = crc >> 8 ^ of_byte[(crc ^ data[k]) & 255u];
    return ~crc;
}

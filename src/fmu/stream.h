/* Numbers and texts as bytes, in both directions: who describes a record with these functions can
 * write it and read it.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Whole numbers have four bytes, others are IEEE doubles of eight, the lowest byte first, whatever
 * the processor; a text has its length, then its bytes. What is read is never trusted: lengths are
 * held against the bytes that are there. */
#ifndef MBSRI_FMU_STREAM_H
#define MBSRI_FMU_STREAM_H

#include "files/arena.h"

#include <stdint.h>

typedef struct mbsri_stream {
    bool writing;
    bool failed;               /* no memory, or what is read is not such a record */
    mbsri_arena *arena;        /* memory of the bytes written, or of what is read */
    unsigned char *data;       /* written so far */
    const unsigned char *from; /* to be read */
    size_t size, room, at;     /* bytes of either; room of those written; read so far */
} mbsri_stream;

mbsri_stream mbsri_stream_write(mbsri_arena *arena);
mbsri_stream mbsri_stream_read(mbsri_arena *arena, const unsigned char *data, size_t size);

/* Each writes *x, or reads it; zero is read once the stream has failed. */
void mbsri_pass_int(mbsri_stream *s, int *x);
void mbsri_pass_number(mbsri_stream *s, double *x);
void mbsri_pass_numbers(mbsri_stream *s, size_t count, double *x);

/* A text of the arena; NULL is written as "". */
void mbsri_pass_text(mbsri_stream *s, const char **x);

/* Numbers of the arena; NULL stays NULL. */
void mbsri_pass_array(mbsri_stream *s, size_t count, const double **x);
void mbsri_pass_ints(mbsri_stream *s, size_t count, const int **x);

/* How many records of `size` bytes in memory follow, each of at least eight bytes, and the array
 * for them, of zeros when it is read. */
void mbsri_pass_records(mbsri_stream *s, int *count, void **records, size_t size);

/* CRC-32 of bytes (ISO 3309), as ZIP has it. */
uint32_t mbsri_crc32(const unsigned char *data, size_t size);

#endif

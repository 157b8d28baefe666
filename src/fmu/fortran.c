/* What the static LAPACK of a distribution takes from the runtime of Fortran, so that the shared object of FMUs needs no such runtime:
 * a message about wrong arguments, which says nothing here, and the concatenation of texts.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <stddef.h>
#include <string.h>

void xerbla_(const char *name, const int *argument, size_t length);
void _gfortran_concat_string(size_t size, char *to, size_t first, const char *a, size_t second,
                             const char *b);

void xerbla_(const char *name, const int *argument, size_t length)
{
    (void)name;
    (void)argument;
    (void)length;
}

/* a, then b, then blanks */
void _gfortran_concat_string(size_t size, char *to, size_t first, const char *a, size_t second,
                             const char *b)
{
    const size_t head = first < size ? first : size,
                 tail = second < size - head ? second : size - head;
    memcpy(to, a, head);
    memcpy(to + head, b, tail);
    memset(to + head + tail, ' ', size - head - tail);
}

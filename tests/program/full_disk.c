/* A disk that is full: loaded before the C library, it lets writes into regular files fail from the
 * one on that MBSR_FULL_AT says, with ENOSPC and half of the bytes written. The file that
 * MBSR_FULL_COUNT names gets the number of writes that there were.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

static long writes;

static int is_full(int file)
{
    struct stat s;
    const char *at = getenv("MBSR_FULL_AT");
    if (fstat(file, &s) != 0 || !S_ISREG(s.st_mode)) return 0;
    ++writes;
    return at && writes >= atol(at);
}

static ssize_t write_half(int file, const void *bytes, size_t size)
{
    ssize_t (*real)(int, const void *, size_t);
    *(void **)&real = dlsym(RTLD_NEXT, "write");
    if (size > 1) return real(file, bytes, size / 2);
    errno = ENOSPC;
    return -1;
}

ssize_t write(int file, const void *bytes, size_t size)
{
    static int halves;
    ssize_t (*real)(int, const void *, size_t);
    *(void **)&real = dlsym(RTLD_NEXT, "write");
    if (!is_full(file)) return real(file, bytes, size);
    if (halves++ == 0) return write_half(file, bytes, size);
    errno = ENOSPC;
    return -1;
}

ssize_t pwrite(int file, const void *bytes, size_t size, off_t offset)
{
    ssize_t (*real)(int, const void *, size_t, off_t);
    *(void **)&real = dlsym(RTLD_NEXT, "pwrite");
    if (!is_full(file)) return real(file, bytes, size, offset);
    errno = ENOSPC;
    return -1;
}

ssize_t pwrite64(int file, const void *bytes, size_t size, off64_t offset)
{
    ssize_t (*real)(int, const void *, size_t, off64_t);
    *(void **)&real = dlsym(RTLD_NEXT, "pwrite64");
    if (!is_full(file)) return real(file, bytes, size, offset);
    errno = ENOSPC;
    return -1;
}

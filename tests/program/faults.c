/* Calls of the operating system that fail: loaded before the C library, it lets one call of the
 * function that MBSR_FAULT names fail, the one of the number MBSR_FAULT_AT, counted from 1. The
 * file that MBSR_FAULT_COUNT names gets the number of calls that there were. With MBSR_FAULT_EACH
 * the program's main is called again and again, each time another of the calls fails.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *what = "", *count_file;
static long calls, at;

__attribute__((constructor)) static void begin(void)
{
    const char *number = getenv("MBSR_FAULT_AT"), *name = getenv("MBSR_FAULT");
    count_file = getenv("MBSR_FAULT_COUNT");
    at = number ? atol(number) : 0;
    what = name ? name : "";
}

__attribute__((destructor)) static void end(void)
{
    FILE *(*real)(const char *, const char *);
    *(void **)&real = dlsym(RTLD_NEXT, "fopen");
    what = "";
    FILE *to = count_file ? real(count_file, "w") : NULL;
    if (!to) return;
    fprintf(to, "%ld\n", calls);
    fclose(to);
}

static int fails(const char *name, int error)
{
    if (strcmp(name, what) != 0 || ++calls != at) return 0;
    errno = error;
    return 1;
}

/* The function of the C library, and one in its place that fails by returning `bad`. */
#define FAULT(type, name, error, bad, parameters, arguments)                                       \
    type name parameters                                                                           \
    {                                                                                              \
        type(*real) parameters;                                                                    \
        if (fails(#name, error)) return bad;                                                       \
        *(void **)&real = dlsym(RTLD_NEXT, #name);                                                 \
        return real arguments;                                                                     \
    }

FAULT(FILE *, fopen, EMFILE, NULL, (const char *path, const char *mode), (path, mode))
FAULT(int, fflush, EIO, EOF, (FILE * file), (file))
FAULT(int, fclose, EIO, EOF, (FILE * file), (file))
FAULT(int, fsync, EIO, -1, (int file), (file))
FAULT(int, ftruncate, EIO, -1, (int file, off_t size), (file, size))
FAULT(int, flock, EINTR, -1, (int file, int operation), (file, operation))
FAULT(int, rename, EACCES, -1, (const char *from, const char *to), (from, to))
FAULT(int, mkdir, EACCES, -1, (const char *path, mode_t mode), (path, mode))
FAULT(DIR *, opendir, EMFILE, NULL, (const char *path), (path))
FAULT(char *, realpath, ENOMEM, NULL, (const char *path, char *to), (path, to))
FAULT(pid_t, fork, EAGAIN, -1, (void), ())
FAULT(void *, mmap, ENOMEM, MAP_FAILED,
      (void *place, size_t size, int access, int flags, int file, off_t offset),
      (place, size, access, flags, file, offset))
FAULT(size_t, fread, EIO, 0, (void *to, size_t size, size_t number, FILE *file),
      (to, size, number, file))

#if defined(__GLIBC__)
typedef int (*program_main)(int count, char **argument, char **environment);

static program_main whole;

/* Whether the program ended as it should: well, or with a word on standard error, a file. */
static int ends(int code)
{
    const off_t said = lseek(STDERR_FILENO, 0, SEEK_END);
    return code == 0 || (code > 0 && code <= 4 && said > 0);
}

/* The program without a failure, then with that of each call, until there are fewer calls. */
static int each_fails(int count, char **argument, char **environment)
{
    const char *const name = what;
    int code = whole(count, argument, environment);
    calls = 0;
    for (at = 1; code == 0; ++at) {
        if (ftruncate(STDERR_FILENO, lseek(STDERR_FILENO, 0, SEEK_SET)) != 0) return 5;
        what = name;
        const int got = whole(count, argument, environment);
        what = "";
        if (calls < at) break;
        if (!ends(got)) code = 6;
        calls = 0;
    }
    calls = at;
    return code;
}

/* How a program begins: with its main, or with that above. */
int __libc_start_main(program_main called, int count, char **argument, void (*init)(void),
                      void (*fini)(void), void (*loader_fini)(void), void *stack_end);
int __libc_start_main(program_main called, int count, char **argument, void (*init)(void),
                      void (*fini)(void), void (*loader_fini)(void), void *stack_end)
{
    int (*real)(program_main, int, char **, void (*)(void), void (*)(void), void (*)(void), void *);
    *(void **)&real = dlsym(RTLD_NEXT, "__libc_start_main");
    whole = called;
    return real(getenv("MBSR_FAULT_EACH") ? each_fails : called, count, argument, init, fini,
                loader_fini, stack_end);
}

FAULT(FILE *, fopen64, EMFILE, NULL, (const char *path, const char *mode), (path, mode))
FAULT(int, ftruncate64, EIO, -1, (int file, off64_t size), (file, size))

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *memory, size_t size);

void *malloc(size_t size)
{
    return fails("malloc", ENOMEM) ? NULL : __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    return fails("malloc", ENOMEM) ? NULL : __libc_calloc(count, size);
}

void *realloc(void *memory, size_t size)
{
    return fails("malloc", ENOMEM) ? NULL : __libc_realloc(memory, size);
}
#endif

/* Functions of the library that fail when they are told to: see faults.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "faults.h"

#include "duration.h"

#ifdef TEST_WITH_FILES
#include "files/arena.h"
#endif

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- places ---- */

enum { PLACES = 1 << 14, ACTS = 256 };

typedef struct place {
    const char *function, *caller;
    test_faults_list list;
    long calls, all;              /* in this run, and in one without a failure */
    unsigned char done[ACTS / 8]; /* acts in which it failed */
} place;

static place places[PLACES];
static bool on;
static const place *volatile fails;
static long at, live, failed;
static int says;

static place *place_of(const char *function, test_faults_list list, const char *caller)
{
    size_t k = (size_t)((uintptr_t)caller * 11400714819323198485u >> 40) % PLACES;
    while (places[k].caller && (places[k].caller != caller || places[k].function != function))
        k = (k + 1) % PLACES;
    places[k].function = function, places[k].caller = caller, places[k].list = list;
    return places + k;
}

static bool fails_here(const char *function, test_faults_list list, const char *caller)
{
    if (!on) return false;
    place *p = place_of(function, list, caller);
    const bool fail = ++p->calls == at && p == fails;
    failed += fail;
    return fail;
}

/* ---- memory ---- */

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void __real_free(void *memory);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void __wrap_free(void *memory);

void *__wrap_malloc(size_t size)
{
    if (fails_here("malloc", TEST_FAULTS_MEMORY, __builtin_return_address(0))) return NULL;
    void *memory = __real_malloc(size);
    live += memory != NULL;
    return memory;
}

void *__wrap_calloc(size_t count, size_t size)
{
    if (fails_here("calloc", TEST_FAULTS_MEMORY, __builtin_return_address(0))) return NULL;
    void *memory = __real_calloc(count, size);
    live += memory != NULL;
    return memory;
}

void *__wrap_realloc(void *memory, size_t size)
{
    if (fails_here("realloc", TEST_FAULTS_MEMORY, __builtin_return_address(0))) return NULL;
    void *changed = __real_realloc(memory, size);
    live += !memory && changed;
    return changed;
}

void __wrap_free(void *memory)
{
    live -= memory != NULL;
    __real_free(memory);
}

/* ---- functions in the place of others ---- */

/* Six words and eight numbers in registers, the others in memory, as on x86-64; eight words on
 * AArch64: what these get they hand on, whatever they stand for. Weak: not every build has all. */
#define WORDS                                                                                      \
    long a, long b, long c, long d, long e, long f, double r, double s, double t, double u,        \
        double v, double w, double x, double y, long g, long h, long i, long j, long k, long l,    \
        long m, long n, long o, long p, long q
#define THEM a, b, c, d, e, f, r, s, t, u, v, w, x, y, g, h, i, j, k, l, m, n, o, p, q
#define FAULT(type, name, failure)                                                                 \
    type __real_##name(WORDS) __attribute__((weak));                                               \
    type __wrap_##name(WORDS);                                                                     \
    type __wrap_##name(WORDS)                                                                      \
    {                                                                                              \
        if (fails_here(#name, LIST, __builtin_return_address(0))) return failure;                  \
        return __real_##name(THEM);                                                                \
    }
/* A status, whether it succeeded, what SUNDIALS returns, the number that says no. */
#define STATUS(name) FAULT(long, name, says)
#define SUCCESS(name) FAULT(long, name, 0)
#define FLAG(name) FAULT(long, name, -21)
#define NUMBER(name) FAULT(double, name, 0.0)
/* LAPACK's, which says so in an argument, one of the words. */
#define INFO(name, word)                                                                           \
    void __real_##name(WORDS) __attribute__((weak));                                               \
    void __wrap_##name(WORDS);                                                                     \
    void __wrap_##name(WORDS)                                                                      \
    {                                                                                              \
        if (fails_here(#name, LIST, __builtin_return_address(0)))                                  \
            *(int *)word = 1;                                                                      \
        else                                                                                       \
            __real_##name(THEM);                                                                   \
    }
/* Of the system: errno says why. */
#define SYSTEM(name, failure) FAULT(long, name, (errno = EIO, failure))
/* What it closes is closed. */
#define CLOSES(name, failure) FAULT(long, name, (__real_##name(THEM), errno = EIO, failure))
/* How a command of the program ends. */
#define CODE(name) FAULT(long, name, (fputs("failed\n", stderr), 4))
/* A result of the FMI. */
#define RESULT(name) FAULT(long, name, 3)
/* Memory of an arena, which knows that there was none. */
#define ARENA(name) FAULT(long, name, (((mbsri_arena *)a)->failed = true, 0))
/* Memory that the caller frees, or NULL. */
#define TAKEN(name, taken)                                                                         \
    void *__real_##name(WORDS) __attribute__((weak));                                              \
    void *__wrap_##name(WORDS);                                                                    \
    void *__wrap_##name(WORDS)                                                                     \
    {                                                                                              \
        if (fails_here(#name, LIST, __builtin_return_address(0))) {                                \
            errno = EIO;                                                                           \
            return NULL;                                                                           \
        }                                                                                          \
        void *given = __real_##name(THEM);                                                         \
        live += given && (taken);                                                                  \
        return given;                                                                              \
    }
/* The caller frees what it gives. */
#define GIVEN(name)                                                                                \
    void *__real_##name(WORDS) __attribute__((weak));                                              \
    void *__wrap_##name(WORDS);                                                                    \
    void *__wrap_##name(WORDS)                                                                     \
    {                                                                                              \
        void *given = __real_##name(THEM);                                                         \
        live += given != NULL;                                                                     \
        return given;                                                                              \
    }

#ifdef TEST_WITH_CORE
#define LIST TEST_FAULTS_CORE
#include "functions_core.h"
#undef LIST
#endif
#ifdef TEST_WITH_IDA
#define LIST TEST_FAULTS_IDA
#include "functions_ida.h"
#undef LIST
#endif
#ifdef TEST_WITH_LINEAR
#define LIST TEST_FAULTS_LINEAR
#include "functions_linear.h"
#undef LIST
#endif
#ifdef TEST_WITH_CONTACT
#define LIST TEST_FAULTS_CONTACT
#include "functions_contact.h"
#undef LIST
#endif
#ifdef TEST_WITH_FE
#define LIST TEST_FAULTS_FE
#include "functions_fe.h"
#undef LIST
#endif
#ifdef TEST_WITH_FILES
#define LIST TEST_FAULTS_FILES
#include "functions_files.h"
#undef LIST
#endif
#ifdef TEST_WITH_STUDY
#define LIST TEST_FAULTS_STUDY
#include "functions_study.h"
#undef LIST
#endif
#ifdef TEST_WITH_FMU
#define LIST TEST_FAULTS_FMU
#include "functions_fmu.h"
#undef LIST
#endif
#ifdef TEST_WITH_PROGRAM
#define LIST TEST_FAULTS_PROGRAM
#include "functions_program.h"
#undef LIST
#endif

/* ---- each place ---- */

static bool (*only)(test_faults_list list, const char *caller);

void test_faults_only(bool (*here)(test_faults_list list, const char *caller))
{
    only = here;
}

void test_faults_rest(bool rests)
{
    on = !rests;
}

static int run(const test_faults_act *act)
{
    for (size_t k = 0; k < PLACES; ++k) places[k].calls = 0;
    memset(act->out, 0, act->count * sizeof *act->out);
    on = true;
    const int status = act->call(act->user);
    on = false;
    return status;
}

static unsigned number_of(const char *name)
{
    static const char *names[ACTS];
    for (unsigned k = 0; k < ACTS; ++k) {
        if (!names[k]) names[k] = name;
        if (strcmp(names[k], name) == 0) return k;
    }
    fail_msg("too many acts");
    return 0;
}

/* Where a place is in the executable, for addr2line. */
extern const char __executable_start[];

static void complain_of(const test_faults_act *act, const place *p, long call, const char *what)
{
    fail_msg("%s: call %ld of %s from %#zx fails: %s", act->name, call, p->function,
             (size_t)(p->caller - __executable_start), what);
}

static bool is_alike(const test_faults_act *act, const double *good, size_t k)
{
    return fabs(act->out[k] - good[k]) <= act->tolerance * (1.0 + fabs(good[k])) ||
           (isnan(act->out[k]) && isnan(good[k]));
}

static void one_fails(const test_faults_act *act, const double *good, place *p, long call)
{
    const long kept = live, before = failed;
    char what[100];
    fails = p, at = call, says = call % 2 ? -41 : 41;
    const int status = run(act);
    fails = NULL, at = 0;
    if (failed == before) complain_of(act, p, call, "it is not called");
    for (size_t k = 0; status == MBSR_OK && k < act->count; ++k) {
        if (is_alike(act, good, k)) continue;
        snprintf(what, sizeof what, "no word of it, number %zu is %.10g, not %.10g", k, act->out[k],
                 good[k]);
        complain_of(act, p, call, what);
        break;
    }
    if (live != kept) complain_of(act, p, call, "memory is lost");
    if (act->slow && !test_long() && failed % 8) return;
    if (run(act) != MBSR_OK || memcmp(act->out, good, act->count * sizeof *good) != 0)
        complain_of(act, p, call, "not as before behind it");
    if (live != kept) complain_of(act, p, call, "memory is lost behind it");
}

long test_faults_each(const test_faults_act *act)
{
    const unsigned number = number_of(act->name), byte = number / 8, bit = 1u << number % 8;
    if (run(act) != MBSR_OK) return 0;
    double *good = malloc(act->count * sizeof *good);
    memcpy(good, act->out, act->count * sizeof *good);
    for (size_t k = 0; k < PLACES; ++k) places[k].all = places[k].calls;
    long count = 0;
    for (size_t k = 0; k < PLACES; ++k) {
        place *p = places + k;
        if (p->caller && !(only ? only(p->list, p->caller) : p->list != TEST_FAULTS_MEMORY))
            continue;
        if (!p->all || (p->done[byte] & bit && !test_long())) continue;
        p->done[byte] |= (unsigned char)bit;
        one_fails(act, good, p, 1);
        const long half = p->all / 2, last = p->all;
        if (half > 1 && (!act->slow || test_long())) one_fails(act, good, p, half);
        if (last > 1 && (!act->slow || test_long())) one_fails(act, good, p, last);
        ++count;
    }
    free(good);
    return count;
}

/* What the benchmark programs share: clock, statistics, random numbers, the head of a CSV file.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef BENCH_H
#define BENCH_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* CPU time of the process in seconds. It leaves out the time in which other programs had the core,
 * but not what they do to caches and clock frequency. */
double bench_now(void);

typedef struct bench_quartiles {
    double min, q1, median, q3;
} bench_quartiles;

/* Sorts the samples. Quartiles are interpolated linearly between neighbours. */
bench_quartiles bench_statistics(int samples, double *sample);

/* A straight line through (log x, log y) by least squares: its slope and the standard error
 * of the slope, which is 0 for fewer than three points. */
typedef struct bench_line {
    double slope, error;
} bench_line;

bench_line bench_fit_power(int points, const double *x, const double *y);

/* Random numbers (splitmix64), the same on every machine. */
uint64_t bench_random(uint64_t *state);

double bench_uniform(uint64_t *state, double low, double high);

/* Random order of `count` integers. */
void bench_shuffle(uint64_t *state, size_t count, int *array);

/* Takes `samples` of each of `count` measurements, all in one random order:
 * sample[which * samples + k] = measure(context, which). */
void bench_sample_all(int count, int samples, double (*measure)(void *context, int which),
                      void *context, double *sample);

/* Lines that begin with '#': what was measured, date, machine, compiler, flags, library version,
 * BLAS and LAPACK. The flags are those in the environment variable MBSR_BENCH_FLAGS, which
 * run.sh sets. */
void bench_header(FILE *out, const char *title);

/* Ends the program with a message if status is not 0. `detail`: the library's text, or NULL. */
void bench_check(int status, const char *what, const char *detail);

/* calloc, or the end of the program. */
void *bench_allocate(size_t count, size_t size);

#endif

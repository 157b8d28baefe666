/* What the benchmark programs share: clock, statistics, random numbers, the head of a CSV file.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 200809L

#include "bench.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { LINE = 1024 };

double bench_now(void)
{
    struct timespec now;
    bench_check(clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now), "clock_gettime", NULL);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- statistics ------------------------------------------------------------------------------ */

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double quantile(int samples, const double *sorted, double share)
{
    const double place = share * (samples - 1);
    const int below = (int)place, above = below + 1 < samples ? below + 1 : below;
    return sorted[below] + (place - below) * (sorted[above] - sorted[below]);
}

bench_quartiles bench_statistics(int samples, double *sample)
{
    qsort(sample, (size_t)samples, sizeof *sample, compare);
    return (bench_quartiles){.min = sample[0],
                             .q1 = quantile(samples, sample, 0.25),
                             .median = quantile(samples, sample, 0.5),
                             .q3 = quantile(samples, sample, 0.75)};
}

bench_line bench_fit_power(int points, const double *x, const double *y)
{
    double mean_x = 0.0, mean_y = 0.0, xx = 0.0, xy = 0.0, rest = 0.0;
    for (int k = 0; k < points; ++k) {
        mean_x += log(x[k]) / points;
        mean_y += log(y[k]) / points;
    }
    for (int k = 0; k < points; ++k) {
        xx += (log(x[k]) - mean_x) * (log(x[k]) - mean_x);
        xy += (log(x[k]) - mean_x) * (log(y[k]) - mean_y);
    }
    const double slope = xy / xx;
    for (int k = 0; k < points; ++k) {
        const double defect = log(y[k]) - mean_y - slope * (log(x[k]) - mean_x);
        rest += defect * defect;
    }
    return (bench_line){slope, points > 2 ? sqrt(rest / (points - 2) / xx) : 0.0};
}

/* ---- random numbers -------------------------------------------------------------------------- */

uint64_t bench_random(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

double bench_uniform(uint64_t *state, double low, double high)
{
    return low + (high - low) * ldexp((double)(bench_random(state) >> 11), -53);
}

void bench_shuffle(uint64_t *state, size_t count, int *array)
{
    for (size_t k = count; k > 1; --k) {
        const size_t other = (size_t)(bench_random(state) % k);
        const int held = array[k - 1];
        array[k - 1] = array[other];
        array[other] = held;
    }
}

void bench_sample_all(int count, int samples, double (*measure)(void *context, int which),
                      void *context, double *sample)
{
    const size_t total = (size_t)count * (size_t)samples;
    int *order = bench_allocate(total, sizeof *order);
    uint64_t state = 1;
    for (size_t k = 0; k < total; ++k) order[k] = (int)k;
    bench_shuffle(&state, total, order);
    for (size_t k = 0; k < total; ++k) sample[order[k]] = measure(context, order[k] / samples);
    free(order);
}

/* ---- head of a CSV file ---------------------------------------------------------------------- */

/* What follows `key` and a colon in the first such line of a file; "unknown" if there is none. */
static void read_field(const char *path, const char *key, char value[LINE])
{
    char line[LINE];
    FILE *file = fopen(path, "r");
    strcpy(value, "unknown");
    while (file && fgets(line, LINE, file)) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, key, strlen(key)) != 0 || !colon) continue;
        strcpy(value, colon + 1 + strspn(colon + 1, " \t"));
        value[strcspn(value, "\n")] = '\0';
        break;
    }
    if (file) fclose(file);
}

static void print_load(FILE *out)
{
    double load[3] = {0.0};
    FILE *file = fopen("/proc/loadavg", "r");
    if (file && fscanf(file, "%lf %lf %lf", load, load + 1, load + 2) == 3) {
        fprintf(out, "# load average at start: %.2f (1 min) %.2f (5 min)\n", load[0], load[1]);
    }
    if (file) fclose(file);
}

/* The shared libraries in this process whose names contain blas or lapack. */
static void print_blas(FILE *out)
{
    char line[LINE], last[LINE] = "";
    FILE *file = fopen("/proc/self/maps", "r");
    fprintf(out, "# BLAS and LAPACK:");
    while (file && fgets(line, LINE, file)) {
        char *path = strchr(line, '/');
        if (!path || (!strstr(path, "blas") && !strstr(path, "lapack"))) continue;
        path[strcspn(path, "\n")] = '\0';
        if (strcmp(path, last) != 0) fprintf(out, " %s", path);
        strcpy(last, path);
    }
    fprintf(out, "%s\n", last[0] ? "" : " no shared library of that name in the process");
    if (file) fclose(file);
}

static const char *compiler(void)
{
#if defined(__clang__)
    return "clang " __clang_version__;
#elif defined(__GNUC__)
    return "gcc " __VERSION__;
#else
    return "unknown";
#endif
}

void bench_header(FILE *out, const char *title)
{
    char model[LINE], date[64];
    const char *flags = getenv("MBSR_BENCH_FLAGS");
    const time_t now = time(NULL);
    struct tm utc;
    read_field("/proc/cpuinfo", "model name", model);
    strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", gmtime_r(&now, &utc));
    fprintf(out, "# %s\n# date: %s\n", title, date);
    fprintf(out, "# machine: %s, %ld cores\n", model, sysconf(_SC_NPROCESSORS_ONLN));
    print_load(out);
    fprintf(out, "# compiler: %s\n# flags: %s\n", compiler(), flags ? flags : "not recorded");
    fprintf(out, "# library: libmbsrank %s\n", mbsr_version());
    print_blas(out);
}

/* ---- ends of the program --------------------------------------------------------------------- */

void bench_check(int status, const char *what, const char *detail)
{
    if (status == 0) return;
    fprintf(stderr, "%s: %d (%s) %s\n", what, status, mbsr_status_name(status),
            detail ? detail : "");
    exit(EXIT_FAILURE);
}

void *bench_allocate(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (!memory) bench_check(MBSR_ERR_NO_MEMORY, "calloc", NULL);
    return memory;
}

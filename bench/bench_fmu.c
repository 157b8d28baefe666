/* What a communication step of an FMU costs beside the steps of IDA inside it.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_fmu SHARED_OBJECT [steps]      CSV on standard output; default 20 000 steps
 *
 * A chain of rods runs from communication point to communication point, 100 us apart, in the shared
 * object of FMUs and by mbsr_ida_advance; both take turns, medians of 9. What they differ by is the
 * overhead. */
#define _XOPEN_SOURCE 700
#include "bench.h"

#include <mbsrank/fmu.h>
#include <mbsrank/simulation.h>

#include <dlfcn.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SAMPLES = 9, STEPS = 20000 };
static const double H = 1e-4; /* s */

typedef void *instance;

/* The functions of FMI 3.0 that a run calls. */
static struct {
    instance (*make)(const char *, const char *, const char *, bool, bool, bool, bool,
                     const uint32_t *, size_t, void *, void *, void *);
    int (*enter)(instance, bool, double, double, bool, double);
    int (*leave)(instance);
    int (*step)(instance, double, double, bool, bool *, bool *, bool *, double *);
    void (*free)(instance);
} fmi;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void build(mbsr_simulation *s, int rods)
{
    static const double y[3] = {0.0, 1.0, 0.0}, a[3] = {0.0}, b[3] = {1.0, 0.0, 0.0};
    const mbsr_frame tip = mbsr_frame_at(1.0, 0.0, 0.0);
    int last = MBSR_GROUND;
    *s = mbsr_simulation_begin(NULL);
    for (int k = 0; k < rods; ++k) {
        last = mbsr_simulation_add_body(s, NULL, last,
                                        mbsr_joint_revolute(k > 0 ? &tip : NULL, NULL, y),
                                        mbsr_inertia_rod(1.0, a, b));
        mbsr_simulation_add_force(s, mbsr_force_joint_spring(last, 0, 5.0, 0.1, 0.0));
    }
    mbsr_simulation_add_force(s, mbsr_force_gravity(0.0, 0.0, -9.81));
}

static bool load(const char *path)
{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) return false;
    *(void **)&fmi.make = dlsym(library, "fmi3InstantiateCoSimulation");
    *(void **)&fmi.enter = dlsym(library, "fmi3EnterInitializationMode");
    *(void **)&fmi.leave = dlsym(library, "fmi3ExitInitializationMode");
    *(void **)&fmi.step = dlsym(library, "fmi3DoStep");
    *(void **)&fmi.free = dlsym(library, "fmi3FreeInstance");
    return fmi.make && fmi.enter && fmi.leave && fmi.step && fmi.free;
}

/* The number behind `key` in the archive, whose files are stored. */
static const unsigned char *find(const mbsr_fmu *fmu, const char *key)
{
    const size_t length = strlen(key);
    for (size_t k = 0; k + length < fmu->size; ++k)
        if (memcmp(fmu->data + k, key, length) == 0) return fmu->data + k + length;
    return NULL;
}

static uint32_t size_of(const unsigned char *name)
{
    const unsigned char *head = name - strlen("resources/model.mbsrank") - 30;
    return (uint32_t)head[18] | (uint32_t)head[19] << 8 | (uint32_t)head[20] << 16 |
           (uint32_t)head[21] << 24;
}

/* An instance of the model, from resources in a folder; NULL: there is none. */
static instance open_unit(const mbsr_model *model, const char *folder)
{
    mbsr_fmu *fmu;
    char path[128], token[40] = "";
    if (mbsr_fmu_export(model, NULL, &fmu, NULL)) return NULL;
    const unsigned char *bytes = find(fmu, "resources/model.mbsrank"),
                        *key = find(fmu, "instantiationToken=\"");
    snprintf(path, sizeof path, "%s/model.mbsrank", folder);
    FILE *to = bytes && key ? fopen(path, "wb") : NULL;
    const bool good = to && fwrite(bytes, 1, size_of(bytes), to) == size_of(bytes);
    if (to) fclose(to);
    if (good) memcpy(token, key, 32);
    mbsr_fmu_destroy(fmu);
    instance c =
        good ? fmi.make("one", token, folder, false, false, false, false, NULL, 0, NULL, NULL, NULL)
             : NULL;
    remove(path);
    return c;
}

static double run_unit(instance c, int steps)
{
    bool flags[3];
    double last, t = now();
    for (int k = 0; k < steps; ++k) fmi.step(c, k * H, H, true, flags, flags + 1, flags + 2, &last);
    return now() - t;
}

static double run_driver(mbsr_simulation *s, int steps)
{
    const double t = now();
    for (int k = 1; k <= steps; ++k) mbsr_ida_advance(s->ida, k * H, NULL, NULL, NULL);
    return now() - t;
}

static int compare(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

int main(int argc, char **argv)
{
    char folder[] = "bench_fmu_XXXXXX";
    const int steps = argc > 2 ? atoi(argv[2]) : STEPS;
    if (argc < 2 || steps < 1 || !load(argv[1]) || !mkdtemp(folder)) {
        fputs("usage: bench_fmu SHARED_OBJECT [steps]\n", stderr);
        return 2;
    }
    puts("rods,unit_us,driver_us,overhead_us,export_and_instance_ms");
    for (int rods = 1; rods <= 64; rods *= 8) {
        double unit[SAMPLES], driver[SAMPLES], overhead[SAMPLES], made[SAMPLES];
        for (int k = 0; k < SAMPLES; ++k) {
            mbsr_simulation s;
            build(&s, rods);
            if (mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL)) return 1;
            const double t = now();
            instance c = open_unit(s.model, folder);
            made[k] = 1e3 * (now() - t);
            if (!c || fmi.enter(c, false, 0.0, 0.0, false, 0.0) || fmi.leave(c)) return 1;
            unit[k] = 1e6 * run_unit(c, steps) / steps;
            driver[k] = 1e6 * run_driver(&s, steps) / steps;
            overhead[k] = unit[k] - driver[k];
            fmi.free(c);
            mbsr_simulation_end(&s);
        }
        qsort(unit, SAMPLES, sizeof *unit, compare);
        qsort(driver, SAMPLES, sizeof *driver, compare);
        qsort(overhead, SAMPLES, sizeof *overhead, compare);
        qsort(made, SAMPLES, sizeof *made, compare);
        printf("%d,%.3f,%.3f,%.3f,%.2f\n", rods, unit[SAMPLES / 2], driver[SAMPLES / 2],
               overhead[SAMPLES / 2], made[SAMPLES / 2]);
    }
    return remove(folder) != 0;
}

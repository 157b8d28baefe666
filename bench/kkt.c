/* Rods in redundant coordinates by KLU: see kkt.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "kkt.h"

#include <stddef.h>

#ifdef BENCH_KLU
#include "bench.h"

#include <klu.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct entry {
    int row, column;
    double value;
} entry;

struct bench_kkt {
    int size, entries;
    int *from, *row; /* compressed columns */
    double *value, *right, *x;
    klu_common common;
    klu_symbolic *symbolic;
    klu_numeric *numeric;
};

static void add(entry *list, int *count, int row, int column, double value)
{
    list[(*count)++] = (entry){row, column, value};
    if (row != column) list[(*count)++] = (entry){column, row, value};
}

/* M of a rod about its origin. */
static void add_mass(const bench_rod *rod, int i, entry *list, int *count)
{
    const double m = rod->mass, c = 0.5 * rod->length, s = sin(rod->angle), k = cos(rod->angle);
    add(list, count, 3 * i, 3 * i, m);
    add(list, count, 3 * i + 1, 3 * i + 1, m);
    add(list, count, 3 * i + 2, 3 * i + 2, m * rod->length * rod->length / 3.0);
    add(list, count, 3 * i, 3 * i + 2, -m * c * s);
    add(list, count, 3 * i + 1, 3 * i + 2, m * c * k);
}

/* sign times the velocity of a point of a rod, into two rows. */
static void add_point(const bench_rod *rod, int i, double x, double y, double sign, int row,
                      entry *list, int *count)
{
    if (i < 0) return;
    add(list, count, row, 3 * i, sign);
    add(list, count, row + 1, 3 * i + 1, sign);
    add(list, count, row, 3 * i + 2, -sign * (y - rod[i].y));
    add(list, count, row + 1, 3 * i + 2, sign * (x - rod[i].x));
}

static void compress(bench_kkt *k, const entry *list, int count)
{
    memset(k->from, 0, ((size_t)k->size + 1) * sizeof *k->from);
    for (int l = 0; l < count; ++l) ++k->from[list[l].column + 1];
    for (int j = 0; j < k->size; ++j) k->from[j + 1] += k->from[j];
    int *next = bench_allocate((size_t)k->size, sizeof *next);
    memcpy(next, k->from, (size_t)k->size * sizeof *next);
    for (int l = 0; l < count; ++l) {
        const int place = next[list[l].column]++;
        k->row[place] = list[l].row;
        k->value[place] = list[l].value;
    }
    free(next);
}

bench_kkt *bench_kkt_open(int rods, const bench_rod *rod, int pins, const bench_pin *pin,
                          const double *gravity)
{
    const int most = 40 * (rods + pins);
    int count = 0;
    bench_kkt *k = bench_allocate(1, sizeof *k);
    entry *list = bench_allocate((size_t)most, sizeof *list);
    k->size = 5 * rods + 2 * pins;
    k->from = bench_allocate((size_t)k->size + 1, sizeof *k->from);
    k->row = bench_allocate((size_t)most, sizeof *k->row);
    k->value = bench_allocate((size_t)most, sizeof *k->value);
    k->right = bench_allocate((size_t)k->size, sizeof *k->right);
    k->x = bench_allocate((size_t)k->size, sizeof *k->x);
    for (int i = 0; i < rods; ++i) {
        const double c = 0.5 * rod[i].length, m = rod[i].mass;
        add_mass(rod + i, i, list, &count);
        add_point(rod, i, rod[i].x, rod[i].y, 1.0, 3 * rods + 2 * i, list, &count);
        add_point(rod, rod[i].parent, rod[i].x, rod[i].y, -1.0, 3 * rods + 2 * i, list, &count);
        k->right[3 * i] = m * gravity[0];
        k->right[3 * i + 1] = m * gravity[1];
        k->right[3 * i + 2] =
            m * c * (cos(rod[i].angle) * gravity[1] - sin(rod[i].angle) * gravity[0]);
    }
    for (int l = 0; l < pins; ++l) {
        add_point(rod, pin[l].a, pin[l].x, pin[l].y, 1.0, 5 * rods + 2 * l, list, &count);
        add_point(rod, pin[l].b, pin[l].x, pin[l].y, -1.0, 5 * rods + 2 * l, list, &count);
    }
    compress(k, list, count);
    free(list);
    klu_defaults(&k->common);
    k->symbolic = klu_analyze(k->size, k->from, k->row, &k->common);
    return k;
}

void bench_kkt_close(bench_kkt *k)
{
    if (!k) return;
    klu_free_numeric(&k->numeric, &k->common);
    klu_free_symbolic(&k->symbolic, &k->common);
    free(k->from);
    free(k->row);
    free(k->value);
    free(k->right);
    free(k->x);
    free(k);
}

int bench_kkt_factor(bench_kkt *k)
{
    if (k->numeric) klu_free_numeric(&k->numeric, &k->common);
    k->numeric = klu_factor(k->from, k->row, k->value, k->symbolic, &k->common);
    return k->numeric != NULL;
}

const double *bench_kkt_solve(bench_kkt *k)
{
    memcpy(k->x, k->right, (size_t)k->size * sizeof *k->x);
    return klu_solve(k->symbolic, k->numeric, k->size, 1, k->x, &k->common) ? k->x : NULL;
}

#else

bench_kkt *bench_kkt_open(int rods, const bench_rod *rod, int pins, const bench_pin *pin,
                          const double *gravity)
{
    (void)rods, (void)rod, (void)pins, (void)pin, (void)gravity;
    return NULL;
}

void bench_kkt_close(bench_kkt *k)
{
    (void)k;
}

int bench_kkt_factor(bench_kkt *k)
{
    return k != NULL;
}

const double *bench_kkt_solve(bench_kkt *k)
{
    (void)k;
    return NULL;
}

#endif

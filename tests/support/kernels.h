/* The kernels of the vectorised sweeps that this processor runs, and distances between results.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_KERNELS_H
#define TEST_KERNELS_H

#include "sweeps/dynamics.h"

#include <math.h>

/* Returns how many. */
static inline int test_kernels(const mbsri_sweep_kernels *list[2])
{
    int count = 0;
    list[count++] = &mbsri_sweeps_base;
#if defined(MBSR_WITH_V3)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        list[count++] = &mbsri_sweeps_v3;
#endif
    return count;
}

static inline void test_use_kernels(mbsr_model *m, const mbsri_sweep_kernels *kernels)
{
    m->tree.plain->kernels = m->tree.newton->kernels = m->tree.evaluated->kernels = kernels;
}

/* Without its trees for the sweeps a model is evaluated by the stages. */
typedef struct test_hidden {
    mbsri_sweeps *sweeps, *whole, *evaluated;
} test_hidden;

static inline test_hidden test_hide_sweeps(mbsr_model *m)
{
    const test_hidden trees = {m->tree.plain, m->tree.newton, m->tree.evaluated};
    m->tree.plain = m->tree.newton = m->tree.evaluated = NULL;
    return trees;
}

static inline void test_show_sweeps(mbsr_model *m, test_hidden trees)
{
    m->tree.plain = trees.sweeps;
    m->tree.newton = trees.whole;
    m->tree.evaluated = trees.evaluated;
}

/* Largest difference relative to the largest entry of b or 1. */
static inline double test_relative_distance(int n, const double *a, const double *b)
{
    double off = 0.0, size = 1.0;
    for (int k = 0; k < n; ++k) {
        off = fmax(off, fabs(a[k] - b[k]));
        size = fmax(size, fabs(b[k]));
    }
    return off / size;
}

#endif

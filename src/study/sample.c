/* Values of parameters, run by run.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "study/quantile.h"
#include "study/random.h"
#include "study/record.h"
#include "study/sobol.h"

#include <math.h>

static double spread_value(const mbsr_study_parameter *p, double z)
{
    switch (p->spread) {
    case MBSR_SPREAD_LOG: return exp((1.0 - z) * log(p->low) + z * log(p->high));
    case MBSR_SPREAD_NORMAL: return p->low + p->high * mbsri_normal_quantile(z);
    case MBSR_SPREAD_UNIFORM: break;
    }
    return (1.0 - z) * p->low + z * p->high;
}

/* z of level l. */
static double level_at(const mbsr_study_parameter *p, long l)
{
    if (p->spread == MBSR_SPREAD_NORMAL || p->levels == 1)
        return ((double)l + 0.5) / (double)p->levels;
    return (double)l / (double)(p->levels - 1);
}

int mbsri_study_prepare(const mbsr_study *s, mbsr_study_sample *sample)
{
    const size_t parameters = (size_t)s->parameters, runs = (size_t)s->runs;
    if (s->sampling == MBSR_SAMPLING_SOBOL) {
        sample->v =
            mbsri_arena_take(&sample->arena, parameters * MBSRI_SOBOL_BITS * sizeof *sample->v + 1);
        for (int k = 0; k < s->parameters && sample->v; ++k)
            mbsri_sobol_directions(k, sample->v + k * MBSRI_SOBOL_BITS);
        return sample->v != NULL;
    }
    if (s->sampling != MBSR_SAMPLING_LATIN) return 1;
    sample->order = mbsri_arena_take(&sample->arena, parameters * runs * sizeof *sample->order + 1);
    for (size_t k = 0; k < parameters && sample->order; ++k) {
        uint32_t *order = sample->order + k * runs;
        for (size_t i = 0; i < runs; ++i) {
            const uint64_t bits = mbsri_hash(s->seed, (uint64_t)k + (UINT64_C(1) << 32), i);
            const size_t j = (size_t)(bits % (i + 1));
            order[i] = order[j];
            order[j] = (uint32_t)i;
        }
    }
    return sample->order != NULL;
}

/* z of parameter k. */
static double unit_in(const mbsr_study *s, int k, long run)
{
    const mbsr_study_sample *sample = s->sample;
    const uint64_t bits = mbsri_hash(s->seed, (uint64_t)k, (uint64_t)run);
    if (s->sampling == MBSR_SAMPLING_LATIN) {
        const uint32_t part = sample->order[(size_t)k * (size_t)s->runs + (size_t)run];
        return ((double)part + mbsri_unit_number(bits)) / (double)s->runs;
    }
    if (s->sampling == MBSR_SAMPLING_SOBOL) {
        uint32_t x = mbsri_sobol_point(sample->v + k * MBSRI_SOBOL_BITS, (uint32_t)run);
        if (s->seed != 0) x ^= (uint32_t)(mbsri_hash(s->seed, (uint64_t)k, 0) >> 32);
        return ((double)x + 0.5) / 4294967296.0; /* 2^32 */
    }
    return mbsri_unit_number(bits);
}

int mbsr_study_values(const mbsr_study *s, long run, double *value)
{
    if (!s || !value) return MBSR_ERR_NULL;
    if (run < 0 || run >= s->runs) return MBSR_ERR_ID;
    long rest = run;
    for (int k = s->parameters - 1; k >= 0; --k) {
        const mbsr_study_parameter *p = s->parameter + k;
        if (s->sampling == MBSR_SAMPLING_LIST) {
            value[k] = s->sample->listed[(size_t)run * (size_t)s->parameters + (size_t)k];
        } else if (s->sampling == MBSR_SAMPLING_GRID) {
            value[k] = spread_value(p, level_at(p, rest % p->levels));
            rest /= p->levels;
        } else {
            value[k] = spread_value(p, unit_in(s, k, run));
        }
    }
    return MBSR_OK;
}

/* Mobility of joint rates with loops closed, along the tree, against dense equations that are
 * solved by singular values.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops_equations.h"

#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

enum { SEEDS = 400 };

/* All rows but those that the data leaves out; stiff ones count as rigid where their closures are
 * settled, as here. */
static void find(const loops *s, loops_equations *e)
{
    loops copy = *s;
    int dropped[LOOPS_MOST];
    double C[LOOPS_MOST * LOOPS_MOST];
    loops_rows(&copy, 0.0, s->q, s->u, C, NULL, NULL, NULL);
    assert_ok(mbsr_mass_matrix(s->m, s->d, e->M), mbsr_data_error(s->d));
    assert_ok(mbsr_closures_redundant(s->m, s->d, dropped), mbsr_data_error(s->d));
    e->n = s->nu;
    e->m = s->rows;
    e->N = e->n + e->m;
    for (int k = 0; k < e->m * e->n; ++k)
        e->C[k] = dropped[k % e->m] || fabs(C[k]) <= 1e-14 ? 0.0 : C[k];
}

/* A unit impulse on rate k, by K^+; where it is not in the range of K, some motion that nothing
 * determines has a part in that rate. */
static void compare(loops *s, int *compared, int *undetermined, int *held)
{
    double mobility[LOOPS_MOST], size = 0.0, unit[LOOPS_MOST] = {0.0};
    loops_equations e;
    find(s, &e);
    assert_ok(mbsr_stage_positions(s->m, s->d, 0.0, s->q), mbsr_data_error(s->d));
    assert_ok(mbsr_closures_mobility(s->m, s->d, mobility), mbsr_data_error(s->d));
    for (int k = 0; k < s->nu; ++k) size = fmax(size, mobility[k]);
    for (int k = 0; k < s->nu; ++k) {
        unit[k] = 1.0;
        loops_solve(&e, e.M, unit, NULL);
        unit[k] = 0.0;
        if (!e.clear) return;
        if (e.left > 1e-4) {
            assert_true(mobility[k] == -1.0);
            ++*undetermined;
        } else if (e.left < 1e-9) {
            assert_close(mobility[k], e.x[k], 1e-9 * (1.0 + size));
            *held += e.x[k] < 1e-9;
            ++*compared;
        }
    }
}

static void random_mechanisms(void **state)
{
    (void)state;
    int compared = 0, undetermined = 0, held = 0;
    for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
        test_rng rng;
        loops s;
        loops_make_case(&s, &rng, seed);
        if (!loops_too_large(&s)) {
            loops_random_state(&s, &rng);
            compare(&s, &compared, &undetermined, &held);
            if (!mbsr_assemble(s.m, s.d, 0.0, s.q, NULL, s.q, NULL))
                compare(&s, &compared, &undetermined, &held);
        }
        loops_free(&s);
    }
    print_message("%d rates compared, %d undetermined, %d held\n", compared, undetermined, held);
    assert_true(compared > 4 * SEEDS);
    assert_true(undetermined > SEEDS / 10);
    assert_true(held > SEEDS / 10);
}

static size_t taken;

static void *count_bytes(void *user, size_t size)
{
    (void)user;
    taken += size;
    return malloc(size);
}

static void release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

/* What is taken for parallelograms in a row, in bytes, with the data. */
static size_t bytes_of(int count)
{
    loops s = {0};
    mbsr_model_def def = mbsr_default_model_def();
    def.allocator = (mbsr_allocator){count_bytes, release, NULL};
    assert_ok(mbsr_model_create(&def, &s.m, NULL), NULL);
    loops_add_parallelograms(&s, count);
    loops_build(&s);
    double *q = calloc(2 * (size_t)s.nq, sizeof *q);
    for (int k = 0; k < s.nq; ++k) q[k] = 0.1 * sin(k);
    assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, q), mbsr_data_error(s.d));
    taken = 0;
    assert_ok(mbsr_closures_mobility(s.m, s.d, q + s.nq), mbsr_data_error(s.d));
    assert_true(test_largest(s.nu, q + s.nq) > 0.0);
    const size_t data = mbsr_data_size(s.m);
    free(q);
    loops_free(&s);
    return taken + data;
}

static void memory_is_linear(void **state)
{
    (void)state;
    const size_t some = bytes_of(400), twice = bytes_of(800);
    assert_true(twice <= some * 21 / 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_mechanisms),
        cmocka_unit_test(memory_is_linear),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

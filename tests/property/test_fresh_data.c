/* What is computed does not depend on what stood in the memory of the data before.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "medley.h"

#include "expect.h"

#include <mbsrank/dae.h>
#include <mbsrank/dynamics.h>

#include <stdlib.h>
#include <string.h>

enum { SEEDS = 30, ROOM = 1024 };

/* What is asked of a state, with the numbers that come back. */
typedef struct answers {
    int status[3];
    double udot[ROOM], y[ROOM], yp[ROOM], F[ROOM];
} answers;

static void ask(const medley *s, int pattern, answers *a)
{
    const size_t size = (mbsr_data_size(s->m) + 63) / 64 * 64;
    void *memory = aligned_alloc(64, size);
    mbsr_data *d;
    assert_non_null(memory);
    memset(memory, pattern, size);
    memset(a, 0, sizeof *a);
    assert_int_equal(mbsr_data_init(s->m, memory, size, &d, NULL), MBSR_OK);
    a->status[0] = mbsr_forward_dynamics(s->m, d, s->t, s->q, s->u, NULL, a->udot);
    memset(memory, pattern, size);
    assert_int_equal(mbsr_data_init(s->m, memory, size, &d, NULL), MBSR_OK);
    a->status[1] = mbsr_dae_pack(s->m, d, MBSR_DAE_MOMENTUM, s->t, s->q, s->u, a->y);
    if (!a->status[1])
        a->status[1] =
            mbsr_dae_consistent(s->m, d, MBSR_DAE_MOMENTUM, s->t, a->y, a->yp, NULL, NULL);
    memset(memory, pattern, size);
    assert_int_equal(mbsr_data_init(s->m, memory, size, &d, NULL), MBSR_OK);
    if (!a->status[1])
        a->status[2] = mbsr_dae_residual(s->m, d, MBSR_DAE_MOMENTUM, s->t, a->y, a->yp, a->F);
    free(memory);
}

static void memory_leaves_no_trace(void **state)
{
    static answers zero, other;
    int models = 0;
    (void)state;
    for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
        medley s;
        const medley_choice c = medley_choose(seed);
        if (!medley_make(&s, &c)) {
            medley_free(&s);
            continue;
        }
        assert_true(mbsr_dae_size(s.m, MBSR_DAE_MOMENTUM) <= ROOM);
        ask(&s, 0, &zero);
        ask(&s, 0x55, &other);
        if (memcmp(&zero, &other, sizeof zero) != 0) {
            print_message("seed %d: statuses %d %d %d and %d %d %d, residual %d\n", (int)seed,
                          zero.status[0], zero.status[1], zero.status[2], other.status[0],
                          other.status[1], other.status[2],
                          memcmp(zero.F, other.F, sizeof zero.F) != 0);
            fail();
        }
        ++models;
        medley_free(&s);
    }
    assert_true(models > SEEDS / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(memory_leaves_no_trace)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

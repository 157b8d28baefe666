/* Masses and ranks by the bound of rounding errors alone, against the stage that has the errors
 * themselves: where the bound tells, every joint has full rank and all is the same.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "recursion/backward.h"
#include "rigid_tree.h"
#include "sweeps/bounded.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct counts {
    int told, deficient;
} counts;

static void compare(const char *what, size_t count, const double *x, const double *reference)
{
    double largest = 0.0, off = 0.0;
    for (size_t k = 0; k < count; ++k) {
        largest = fmax(largest, fabs(reference[k]));
        off = fmax(off, fabs(x[k] - reference[k]));
    }
    if (!(off <= 1e-10 * largest)) print_error("%s: off by %.2e of %.2e\n", what, off, largest);
    assert_true(off <= 1e-10 * largest);
}

static void check(const mbsr_model *m, mbsr_data *d, counts *n)
{
    const size_t sizes[] = {m->size.dd, m->size.dg, m->size.dg, m->size.nn, m->size.nn};
    const double *const arrays[] = {d->Mbar, d->U, d->G, d->D, d->Dinv};
    static const char *const names[] = {"Mbar", "U", "G", "D", "Dinv"};
    double *kept[5];
    bool full = true;
    mbsri_sweep_load *bounds = calloc((size_t)m->bodies + 1, sizeof *bounds);
    assert_int_equal(mbsri_backward(m, d), MBSR_OK);
    for (int k = 0; k < 5; ++k) {
        kept[k] = malloc((sizes[k] + 1) * sizeof *kept[k]);
        memcpy(kept[k], arrays[k], sizes[k] * sizeof *kept[k]);
    }
    for (int i = 1; i <= m->bodies; ++i) full = full && d->rank[i] == m->body[i].n;
    mbsri_bounded_prepare(m, bounds);
    const bool told = mbsri_bounded_backward(m, d, bounds);
    n->told += told;
    n->deficient += !full;
    assert_true(full || !told);
    for (int k = 0; k < 5; ++k) {
        if (told) compare(names[k], sizes[k], arrays[k], kept[k]);
        free(kept[k]);
    }
    for (int i = 1; i <= m->bodies && told; ++i) assert_int_equal(d->rank[i], m->body[i].n);
    free(bounds);
}

static void tells_what_the_stage_does(void **state)
{
    (void)state;
    counts n = {0};
    int served = 0;
    for (uint64_t seed = 1; seed <= 120; ++seed) {
        test_rigid_tree tree;
        const test_rigid_choice choice = {.seed = seed,
                                          .bodies = 3 + (int)(seed % 10),
                                          .many = 0.5,
                                          .branching = 0.4,
                                          .length = 0.5,
                                          .forces = 1,
                                          .moving = seed % 2,
                                          .armature = 0.2,
                                          .massless = seed % 4 == 0 ? 0.3 : 0.0,
                                          .light = seed % 4 == 1 ? 0.3 : 0.0};
        test_rigid_tree_make(&tree, choice);
        const mbsr_model *m = tree.model;
        mbsr_data *d = tree.data;
        assert_ok(mbsr_stage_positions(m, d, tree.t, tree.q), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(m, d, tree.u), mbsr_data_error(d));
        assert_ok(mbsr_stage_forces(m, d, tree.tau), mbsr_data_error(d));
        served += mbsri_bounded_serves(m);
        if (mbsri_bounded_serves(m)) check(m, d, &n);
        test_rigid_tree_free(&tree);
    }
    if (served == 0) skip(); /* without vector types */
    print_message("%d trees, %d told, %d with a deficient joint\n", served, n.told, n.deficient);
    assert_true(3 * n.told > served && n.deficient > 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(tells_what_the_stage_does)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Runs of random models that are told in units 4096 times as long, heavy or slow, which no number
 * but exponents knows of: as many steps, to the same state.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "any_model.h"
#include "duration.h"

#include <mbsrank/driver.h>
#include <mbsrank/ida.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { LENGTH = 8 * ANY_MOST };

static const units told[] = {{"m, kg, s", 1.0, 1.0, 1.0},
                             {"m / 4096", 4096.0, 1.0, 1.0},
                             {"4096 kg, 4096 s", 1.0, 1.0 / 4096.0, 1.0 / 4096.0},
                             {"m / 4096, 4096 kg, s / 4096", 4096.0, 1.0 / 4096.0, 4096.0}};

/* Where a run of 0.3 s ends, in SI units, and what it took. */
typedef struct ended {
    long steps;
    double q[ANY_MOST], u[ANY_MOST];
} ended;

static mbsr_ida_opt options(const units *of)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.atol_angle = 1e-6;
    opt.atol_length = 1e-6 * of->length;
    opt.atol_angular_velocity = 1e-6 / of->time;
    opt.atol_velocity = 1e-6 * of->length / of->time;
    return opt;
}

static void run(any_model *s, ended *e)
{
    const mbsr_ida_opt opt = options(s->of);
    double y[LENGTH] = {0.0}, yp[LENGTH] = {0.0}, t;
    mbsr_data *d;
    mbsr_ida *ida;
    mbsr_ida_stats stats;
    assert_ok(mbsr_data_create(s->m, &d, NULL), NULL);
    assert_true(mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM) <= LENGTH);
    assert_ok(mbsr_dae_pack(s->m, d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(s->m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    assert_ok(mbsr_ida_create(s->m, d, &opt, &ida, NULL), mbsr_data_error(d));
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 0.3 * s->of->time, &t, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_get_stats(ida, &stats), NULL);
    e->steps = stats.steps;
    assert_ok(mbsr_dae_unpack(s->m, d, MBSR_DAE_MOMENTUM, t, y, e->q, e->u), mbsr_data_error(d));
    for (int k = 0; k < s->nq; ++k) e->q[k] /= s->turn[k] ? 1.0 : s->of->length;
    for (int k = 0; k < s->nu; ++k) e->u[k] *= s->of->time / (s->turns[k] ? 1.0 : s->of->length);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
}

static double difference(int n, const double *a, const double *b)
{
    double most = 0.0, size = 1.0;
    for (int k = 0; k < n; ++k) {
        most = fmax(most, fabs(a[k] - b[k]));
        size = fmax(size, fabs(b[k]));
    }
    return most / size;
}

static void check(uint64_t seed, bool rich)
{
    static const double rounding = 1e-9;
    ended first;
    for (size_t l = 0; l < sizeof told / sizeof told[0]; ++l) {
        any_model s;
        ended e;
        assert_true(any_model_make(&s, seed, told + l, rich));
        run(&s, &e);
        if (l == 0) first = e;
        const double q = difference(s.nq, e.q, first.q), u = difference(s.nu, e.u, first.u);
        if (e.steps != first.steps || !(q < rounding) || !(u < rounding))
            fail_msg("seed %d, %s: %ld steps for %ld, q %.1e, u %.1e", (int)seed, told[l].name,
                     e.steps, first.steps, q, u);
        mbsr_model_destroy(s.m);
    }
}

static void units_change_no_run(void **state)
{
    static const struct {
        uint64_t seed;
        bool rich;
    } model[] = {{994001, true},  {994002, true}, {994003, false}, {994005, true},
                 {994009, false}, {994011, true}, {994005, false}, {994011, false},
                 {994012, true},  {994017, true}, {994023, true}};
    const int models = test_long() ? (int)(sizeof model / sizeof model[0]) : test_seeds(3, 6);
    (void)state;
    for (int k = 0; k < models; ++k) check(model[k].seed, model[k].rich);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(units_change_no_run)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

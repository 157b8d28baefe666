/* Reports on small masses along runs: predicted against measured errors and steps.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "paper.h"
#include "small_study.h"

/* Exponents of ten of the mass ratios, all of them in long runs. */
static int next(int exponent)
{
    return exponent - (test_long() ? 1 : 2);
}

static const mbsr_small_part first_mass = {0, MBSR_MASS};

static void name_first(study *s)
{
    s->opt.part = &first_mass;
    s->opt.parts = 1;
}

static void oscillators(void **unused)
{
    (void)unused;
    const double q[2][2] = {{0.1, 0.1}, {0.1, 0.0}}, u[2] = {0.0, 0.0};
    for (int damped = 0; damped < 2; ++damped) {
        for (int relative = 0; relative < 2; ++relative) {
            for (int e = -1; e >= -6; e = next(e)) {
                oscillator_parameters p = oscillator_standard;
                p.m1 = pow(10.0, e);
                p.d1 = p.d2 = damped ? 1.0 : 0.0;
                mbsr_model *m = paper_oscillators(&p, relative);
                study s = study_of(m, 10.0, 0.0);
                name_first(&s);
                s.q = q[relative];
                s.u = u;
                study_check(damped ? "oscillators, damped" : "oscillators", p.m1, &s);
                mbsr_model_destroy(m);
            }
        }
    }
}

static void planar_configurations(void **unused)
{
    (void)unused;
    const double start[8] = {0.1, 0.1, 0.05, 0.0, 0.3, 0.2, -0.1, 0.2},
                 lower[6] = {0.1, 0.1, 0.05, 0.3, 0.2, -0.1};
    for (int damped = 0; damped < 2; ++damped) {
        for (int e = -1; e >= -6; e = next(e)) {
            paper_parameters p = paper_standard;
            p.mi = p.mj * pow(10.0, e);
            if (!damped) p.dix = p.diy = p.djx = 0.0;
            mbsr_model *m = paper_upper(&p);
            study s = study_of(m, 2.0, 0.2);
            name_first(&s);
            s.q = start;
            s.u = start + 4;
            study_check(damped ? "upper, damped" : "upper", p.mi, &s);
            mbsr_model_destroy(m);
            m = paper_lower(&p);
            s = study_of(m, 2.0, 0.2);
            name_first(&s);
            s.q = lower;
            s.u = lower + 3;
            study_check(damped ? "lower, damped" : "lower", p.mi, &s);
            mbsr_model_destroy(m);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(oscillators),
        cmocka_unit_test(planar_configurations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

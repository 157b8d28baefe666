/* The limit equations of M. Arnold, Mech. Sci. 4 (2013), Sect. 4, term by term at random states.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "paper.h"

#include "assembly/data.h"

enum { STATES = 100 };

/* Residual of either form at a random state. */
typedef struct sample {
    double q[4], u[4], a[4], r[4];
} sample;

static void draw(test_rng *rng, sample *s)
{
    test_fill(rng, 4, s->q);
    test_fill(rng, 4, s->u);
    test_fill(rng, 4, s->a);
}

static void evaluate(mbsr_model *m, mbsr_data *d, sample *s)
{
    mbsri_data_poison(d);
    assert_int_equal(mbsr_recursive_residual(m, d, 0.0, s->q, s->u, s->a, NULL, s->r), MBSR_OK);
}

static int rank_of(mbsr_model *m, mbsr_data *d, int body)
{
    mbsr_rank_info info;
    assert_int_equal(mbsr_body_rank(m, d, body, &info), MBSR_OK);
    return info.rank;
}

/* (34): 0 = -dix qix' - cix qix + djx qjx' + cjx qjx, 0 = -diy qiy' - ciy qiy.  (35): mj (qjx'' +
 * qix'') = -djx qjx' - cjx qjx, mj (qjy'' + qiy'') = 0. The residual is mass terms minus forces. */
static void upper_configuration_has_the_limit_equations(void **unused)
{
    (void)unused;
    const paper_parameters p = paper_standard;
    mbsr_model *m = paper_upper(&p);
    mbsr_data *d;
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    test_rng rng = test_seed(34);
    for (int k = 0; k < STATES; ++k) {
        sample s;
        draw(&rng, &s);
        evaluate(m, d, &s);
        const double *q = s.q, *u = s.u, *a = s.a;
        assert_close(s.r[0], p.dix * u[0] + p.cix * q[0] - p.djx * u[2] - p.cjx * q[2], 1e-13);
        assert_close(s.r[1], p.diy * u[1] + p.ciy * q[1], 1e-13);
        assert_close(s.r[2], p.mj * (a[2] + a[0]) + p.djx * u[2] + p.cjx * q[2], 1e-13);
        assert_close(s.r[3], p.mj * (a[3] + a[1]), 1e-13);
        assert_int_equal(rank_of(m, d, 0), 0);
        assert_int_equal(rank_of(m, d, 1), 2);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* (36) in joint coordinates: mj qix'' = -dix qix' - cix qix, 0 = -diy qiy' - ciy qiy, mj (qj'' +
 * qiy'') = 0. */
static void lower_configuration_has_the_limit_equations(void **unused)
{
    (void)unused;
    const paper_parameters p = paper_standard;
    mbsr_model *m = paper_lower(&p);
    mbsr_data *d;
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    test_rng rng = test_seed(36);
    for (int k = 0; k < STATES; ++k) {
        sample s;
        draw(&rng, &s);
        evaluate(m, d, &s);
        const double *q = s.q, *u = s.u, *a = s.a;
        assert_close(s.r[0], p.mj * a[0] + p.dix * u[0] + p.cix * q[0], 1e-13);
        assert_close(s.r[1], p.diy * u[1] + p.ciy * q[1], 1e-13);
        assert_close(s.r[2], p.mj * (a[2] + a[1]), 1e-13);
        assert_int_equal(rank_of(m, d, 0), 1);
        assert_int_equal(rank_of(m, d, 1), 1);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Mbar_i = diag(mi + mj, mi), fbar_i = f_i, D_i the same: Sect. 4 gives them in numbers. */
static void lower_configuration_has_the_paper_s_condensed_mass(void **unused)
{
    (void)unused;
    for (int massless = 0; massless < 2; ++massless) {
        paper_parameters p = paper_standard;
        p.mi = massless ? 0.0 : 0.25;
        mbsr_model *m = paper_lower(&p);
        mbsr_data *d;
        sample s;
        test_rng rng = test_seed(17);
        assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
        draw(&rng, &s);
        evaluate(m, d, &s);
        const mbsri_body *b = m->body + m->index[0];
        const double *Mbar = d->Mbar + b->dd, *fbar = d->fbar + b->v;
        assert_close(Mbar[0], p.mi + p.mj, 1e-15);
        assert_close(Mbar[3], p.mi, 1e-15);
        assert_close(Mbar[1], 0.0, 1e-15);
        assert_close(fbar[0], -p.dix * s.u[0] - p.cix * s.q[0], 1e-14);
        assert_close(fbar[1], -p.diy * s.u[1] - p.ciy * s.q[1], 1e-14);
        assert_int_equal(rank_of(m, d, 0), massless ? 1 : 2);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* Full equations (33) for mi > 0: both configurations at random states. */
static void equations_with_mass_are_those_of_newton(void **unused)
{
    (void)unused;
    paper_parameters p = paper_standard;
    p.mi = 0.25;
    mbsr_model *upper = paper_upper(&p), *lower = paper_lower(&p);
    mbsr_data *du, *dl;
    assert_int_equal(mbsr_data_create(upper, &du, NULL), MBSR_OK);
    assert_int_equal(mbsr_data_create(lower, &dl, NULL), MBSR_OK);
    test_rng rng = test_seed(33);
    for (int k = 0; k < STATES; ++k) {
        sample s;
        draw(&rng, &s);
        const double *q = s.q, *u = s.u;
        double a[4];
        assert_int_equal(mbsr_forward_dynamics(upper, du, 0.0, q, u, NULL, a), MBSR_OK);
        assert_close(p.mi * a[0], -p.dix * u[0] - p.cix * q[0] + p.djx * u[2] + p.cjx * q[2],
                     1e-12);
        assert_close(p.mi * a[1], -p.diy * u[1] - p.ciy * q[1], 1e-12);
        assert_close(p.mj * (a[0] + a[2]), -p.djx * u[2] - p.cjx * q[2], 1e-12);
        assert_close(p.mj * (a[1] + a[3]), 0.0, 1e-12);
        assert_int_equal(mbsr_forward_dynamics(lower, dl, 0.0, q, u, NULL, a), MBSR_OK);
        assert_close((p.mi + p.mj) * a[0], -p.dix * u[0] - p.cix * q[0], 1e-12);
        assert_close(p.mi * a[1], -p.diy * u[1] - p.ciy * q[1], 1e-12);
        assert_close(p.mj * (a[1] + a[2]), 0.0, 1e-12);
    }
    mbsr_data_destroy(du);
    mbsr_data_destroy(dl);
    mbsr_model_destroy(upper);
    mbsr_model_destroy(lower);
}

/* (6) in both coordinates, and the equation of m2 with p1'' = q1'' in it (relative). */
static void oscillators_have_the_limit_equations(void **unused)
{
    (void)unused;
    oscillator_parameters p = oscillator_standard;
    p.d1 = 0.3, p.d2 = 0.7, p.c1 = 2.0;
    mbsr_model *absolute = paper_oscillators(&p, 0), *relative = paper_oscillators(&p, 1);
    mbsr_data *da, *dr;
    assert_int_equal(mbsr_data_create(absolute, &da, NULL), MBSR_OK);
    assert_int_equal(mbsr_data_create(relative, &dr, NULL), MBSR_OK);
    test_rng rng = test_seed(6);
    for (int k = 0; k < STATES; ++k) {
        sample s;
        draw(&rng, &s);
        const double *q = s.q, *u = s.u, *a = s.a;
        evaluate(relative, dr, &s);
        assert_close(-s.r[0], p.F - p.d1 * u[0] - p.c1 * q[0] + p.d2 * u[1] + p.c2 * q[1], 1e-13);
        assert_close(s.r[1], p.m2 * (a[0] + a[1]) + p.d2 * u[1] + p.c2 * q[1], 1e-13);
        evaluate(absolute, da, &s);
        assert_close(-s.r[0],
                     p.F - p.d1 * u[0] - p.c1 * q[0] + p.d2 * (u[1] - u[0]) + p.c2 * (q[1] - q[0]),
                     1e-13);
        assert_close(s.r[1], p.m2 * a[1] + p.d2 * (u[1] - u[0]) + p.c2 * (q[1] - q[0]), 1e-13);
    }
    mbsr_data_destroy(da);
    mbsr_data_destroy(dr);
    mbsr_model_destroy(absolute);
    mbsr_model_destroy(relative);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(upper_configuration_has_the_limit_equations),
        cmocka_unit_test(lower_configuration_has_the_limit_equations),
        cmocka_unit_test(lower_configuration_has_the_paper_s_condensed_mass),
        cmocka_unit_test(equations_with_mass_are_those_of_newton),
        cmocka_unit_test(oscillators_have_the_limit_equations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Small masses: what excites the fast motion along a run, by closed forms.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A block of 1 kg is pushed along a slide by a force that begins within the run. A flag of little
 * mass m stands on it on a spring k and a damper d: without mass it stays where it is, and with it
 *
 *   m x'' + d x' + k x = -m a(t),    a the acceleration of the block, but for O(m). */
#include "small_study.h"

#include <complex.h>

enum { BLOCK = 0, FLAG = 1 };

/* A force of `most` from `begin` on: for good, or as sin^4 over a time. */
typedef struct push {
    double most, begin, time;
} push;

static const double pi = 3.14159265358979323846;

static int push_at(void *user, double t, int n, double *value)
{
    const push *p = user;
    const double x = t - p->begin;
    (void)n;
    if (p->time > 0.0)
        value[0] = x > 0.0 && x < p->time ? p->most * pow(sin(pi * x / p->time), 4.0) : 0.0;
    else
        value[0] = x < 0.0 ? 0.0 : p->most;
    return MBSR_OK;
}

/* Where it begins, and sin^4 also where it ends. */
static int push_kink(void *user, double t, int direction, mbsr_kink *next)
{
    const push *p = user;
    const double at[2] = {p->begin, p->begin + p->time};
    for (int k = 0; k < (p->time > 0.0 ? 2 : 1); ++k)
        if ((at[k] - t) * direction > 0.0 && (next->t - at[k]) * direction > 0.0)
            *next = (mbsr_kink){at[k], p->time > 0.0 ? 5 : 1};
    return MBSR_OK;
}

static mbsr_model *flag(double m, double k, double d, push *force)
{
    mbsr_model *model = NULL;
    const double mass[2] = {1.0, m};
    const mbsr_planar_frame frame = {0.0, 0.0, 0.0};
    assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
    for (int i = 0; i < 2; ++i) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = i == BLOCK ? MBSR_GROUND : BLOCK;
        body.joint = mbsr_joint_planar_prismatic(frame, frame);
        body.inertia = mbsr_inertia_particle(mass[i]);
        assert_ok(mbsr_model_add_body(model, &body, NULL), mbsr_model_error(model));
    }
    const mbsr_force_def spring = mbsr_force_joint_spring(FLAG, 0, k, d, 0.0),
                         applied = mbsr_force_joint_applied(BLOCK, push_at, force);
    assert_ok(mbsr_model_add_force(model, &spring, NULL), mbsr_model_error(model));
    assert_ok(mbsr_model_add_force(model, &applied, NULL), mbsr_model_error(model));
    assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
    return model;
}

static const double rest[2] = {0.0, 0.0};
static const mbsr_small_part part = {FLAG, MBSR_MASS};

static study study_push(const mbsr_model *m, push *force)
{
    study s = study_of(m, 1.0, 0.1);
    s.opt.part = &part;
    s.opt.parts = 1;
    s.ida.kink = push_kink;
    s.ida.kink_user = force;
    s.q = s.u = rest;
    return s;
}

/* Amplitude and steps along the run of the reduced model; at the start there is nothing. */
static double follow(study *s, long *predicted, long *measured)
{
    static study_path path;
    mbsr_small_masses_report report;
    mbsr_small_masses *small = study_begin(s, rest, rest);
    assert_ok(mbsr_small_masses_get_report(small, &report), NULL);
    assert_true(report.mass[0].amplitude == 0.0 && report.steps == 0.0);
    mbsr_small_masses_destroy(small);
    small = study_predict(s);
    assert_ok(mbsr_small_masses_get_report(small, &report), NULL);
    const double amplitude = report.direction[report.mass[0].direction].amplitude;
    *predicted = s->steps + (long)report.steps;
    mbsr_small_masses_destroy(small);
    assert_ok(study_run(s, s->model, rest, rest, 1.0, &path), NULL);
    *measured = path.steps;
    return amplitude;
}

static void check_steps(long predicted, long measured)
{
    assert_true(measured < 2 * predicted);
    assert_true(predicted < 2 * measured);
}

/* At once: a swing of m a / k about the new place. */
static void a_force_that_jumps_excites(void **unused)
{
    (void)unused;
    for (int e = -2; e >= -5; --e) {
        for (int damped = 0; damped < 2; ++damped) {
            const double m = pow(10.0, e), k = 100.0;
            push force = {20.0, 0.37, 0.0};
            mbsr_model *model = flag(m, k, damped ? 0.1 * sqrt(k * m) : 0.0, &force);
            study s = study_push(model, &force);
            long predicted, measured;
            const double swing = follow(&s, &predicted, &measured), exact = m * force.most / k;
            print_message("m = %.0e, damping ratio %g: swing %.3e (%.3e), steps %ld (%ld), %s\n", m,
                          damped ? 0.05 : 0.0, exact, swing, measured, predicted,
                          mbsr_small_verdict_text(s.verdict));
            /* the run excites some tenths of its tolerance by itself */
            assert_close(swing, exact, 0.05 * exact + 0.2 * s.ida.atol);
            check_steps(predicted, measured);
            mbsr_model_destroy(model);
        }
    }
}

/* |integral a exp(i w t) dt| / w, by Simpson's rule. */
static double left_by(const push *force, double w)
{
    enum { PIECES = 4000 };
    double complex sum = 0.0;
    for (int k = 0; k <= PIECES; ++k) {
        const double x = (double)k / PIECES;
        sum += (k == 0 || k == PIECES ? 1.0
                : k % 2               ? 4.0
                                      : 2.0) *
               pow(sin(pi * x), 4.0) * cexp(I * w * force->time * x);
    }
    return force->most * force->time / (3.0 * PIECES) * cabs(sum) / w;
}

/* For a time T, 5 to 40 times 1 / w: the swing that the push leaves, which ends as next to nothing.
 * Of long pushes the report shows what of the displacement m a / k follows with a lag. */
static void a_short_push_excites(void **unused)
{
    (void)unused;
    static const double turns[] = {5.0, 10.0, 14.0, 20.0, 28.0, 40.0}; /* w T */
    for (int k = 0; k < 6; ++k) {
        const double m = 1e-3, stiffness = 100.0;
        push force = {20.0, 0.37, turns[k] / sqrt(stiffness / m)};
        mbsr_model *model = flag(m, stiffness, 0.0, &force);
        study s = study_push(model, &force);
        s.ida.max_step = 0.05 * force.time;
        long predicted, measured;
        const double swing = follow(&s, &predicted, &measured),
                     exact = left_by(&force, sqrt(stiffness / m));
        print_message("push of %g / w: swing %.3e (%.3e), steps %ld (%ld)\n", turns[k], exact,
                      swing, measured, predicted);
        mbsr_model_destroy(model);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_force_that_jumps_excites),
        cmocka_unit_test(a_short_push_excites),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Small masses: starts on the smooth motion, and reports on a pendulum on a bead, a quarter of a
 * car and the car axis.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "paper.h"
#include "small_study.h"

#include <mbsrank/simulation.h>

#include <complex.h>

void dgeev_(const char *left, const char *right, const int *n, double *A, const int *lda,
            double *real, double *imaginary, double *vl, const int *ldvl, double *vr,
            const int *ldvr, double *work, const int *lwork, int *info);

/* ---- smooth start ---- */

/* The part of x = (p1 - 1, p2 - 1, v1, v2) in the fastest eigenspace of the oscillators, by left
 * and right eigenvectors; c1 = c2 = F = m2 = 1. */
static void fast_part(const oscillator_parameters *p, const double x[4], double fast[4])
{
    const int n = 4, work_size = 64;
    double A[16] = {0.0}, re[4], im[4], vl[16], vr[16], work[64];
    int info, f = 0;
    A[8] = A[13] = 1.0;
    A[2] = -(p->c1 + p->c2) / p->m1, A[6] = p->c2 / p->m1;
    A[10] = -(p->d1 + p->d2) / p->m1, A[14] = p->d2 / p->m1;
    A[3] = p->c2 / p->m2, A[7] = -p->c2 / p->m2, A[11] = p->d2 / p->m2, A[15] = -p->d2 / p->m2;
    dgeev_("V", "V", &n, A, &n, re, im, vl, &n, vr, &n, work, &work_size, &info);
    assert_int_equal(info, 0);
    for (int k = 1; k < 4; ++k) /* of a pair the first */
        if (hypot(re[k], im[k]) > hypot(re[f], im[f]) * (1.0 + 1e-12)) f = k;
    double complex share = 0.0, norm = 0.0;
    const int pair = im[f] != 0.0;
    for (int k = 0; k < 4; ++k) {
        const double complex left = vl[4 * f + k] - (pair ? I * vl[4 * f + 4 + k] : 0.0),
                             right = vr[4 * f + k] + (pair ? I * vr[4 * f + 4 + k] : 0.0);
        share += left * x[k];
        norm += left * right;
    }
    for (int k = 0; k < 4; ++k) {
        const double complex right = vr[4 * f + k] + (pair ? I * vr[4 * f + 4 + k] : 0.0);
        fast[k] = (pair ? 2.0 : 1.0) * creal(share / norm * right);
    }
}

typedef struct smooth_start {
    double q[2], u[2]; /* of the model */
    double fast[4];    /* what of it is fast */
} smooth_start;

static smooth_start find(const oscillator_parameters *p, mbsr_small_masses *small, int order,
                         int relative)
{
    smooth_start s;
    assert_ok(mbsr_small_masses_smooth(small, order, s.q, s.u), mbsr_small_masses_error(small));
    const double x[4] = {s.q[0] - 1.0, (relative ? s.q[0] : 0.0) + s.q[1] - 1.0, s.u[0],
                         (relative ? s.u[0] : 0.0) + s.u[1]};
    fast_part(p, x, s.fast);
    return s;
}

static int by_size(const void *a, const void *b)
{
    const long x = *(const long *)a, y = *(const long *)b;
    return (x > y) - (x < y);
}

/* Steps at tolerances about 1e-6 in all; undamped, the median from starts that are moved by 1e-9:
 * there BDF excites the fast motion by itself, and two starts as close as that may differ by a
 * factor 2. */
static long steps_from(const study *like, const smooth_start *s, int damped)
{
    enum { RUNS = 21 };
    static study_path path;
    long steps[RUNS], sum = 0;
    test_rng rng = test_seed(7);
    for (int k = 0; k < RUNS; ++k) {
        smooth_start moved = *s;
        for (int j = 0; j < 2 && !damped; ++j) {
            moved.q[j] += 1e-9 * test_uniform(&rng);
            moved.u[j] += 1e-9 * test_uniform(&rng);
        }
        const double factor = damped ? pow(2.0, 0.2 * (k - RUNS / 2)) : 1.0;
        assert_ok(study_run(like, like->model, moved.q, moved.u, factor, &path), NULL);
        steps[k] = path.steps;
        sum += path.steps;
    }
    qsort(steps, RUNS, sizeof steps[0], by_size);
    return damped ? sum : steps[RUNS / 2];
}

/* From q and u; the amplitudes that are left. */
static void check_smooth(const oscillator_parameters *p, const study *x, int relative,
                         const double *q, const double *u)
{
    mbsr_small_masses *small = study_begin(x, q, u);
    const double damping = p->d1;
    const smooth_start one = find(p, small, 1, relative), two = find(p, small, 2, relative);
    const double a = hypot(one.fast[0], one.fast[2] * sqrt(p->m1)),
                 b = hypot(two.fast[0], two.fast[2] * sqrt(p->m1));
    print_message("m1 = %.0e, d = %.0e: fast amplitude %.1e, order 2 %.1e\n", p->m1, damping, a, b);
    assert_less(a, 0.5 * p->m1);
    assert_less(b, (damping < 0.3 * sqrt(p->m1) ? 0.1 * p->m1 : 2.0) * p->m1 * a + 1e-13);
    mbsr_small_masses_destroy(small);
    if (u[0] != 0.0 || u[1] != 0.0) return;
    smooth_start exact = two;
    exact.q[0] -= two.fast[0];
    exact.u[0] -= two.fast[2];
    exact.q[1] -= two.fast[1] - (relative ? two.fast[0] : 0.0);
    exact.u[1] -= two.fast[3] - (relative ? two.fast[2] : 0.0);
    const long steps = steps_from(x, &two, damping > 0.1),
               least = steps_from(x, &exact, damping > 0.1);
    print_message("    %ld steps, %ld from the exact start\n", steps, least);
    assert_less((double)steps, 1.2 * (double)least);
}

static void each_order_leaves_less_of_the_fast_motion(void **unused)
{
    (void)unused;
    static const mbsr_small_part first = {0, MBSR_MASS};
    static const double damping[] = {0.0, 1e-5, 1e-2, 1.0},
                        u[2][2] = {{0.0, 0.0}, {0.0, 0.1}}; /* from rest, and moving */
    for (int d = 0; d < 4; ++d) {
        for (int relative = 0; relative < 2; ++relative) {
            for (int e = -2; e >= -4; --e) {
                oscillator_parameters p = oscillator_standard;
                p.m1 = pow(10.0, e);
                p.d1 = p.d2 = damping[d];
                const double q[2] = {0.1, relative ? 0.0 : 0.1};
                mbsr_model *m = paper_oscillators(&p, relative);
                study x = study_of(m, 10.0, 0.0);
                x.opt.part = &first;
                x.opt.parts = 1;
                for (int k = 0; k < 2; ++k) check_smooth(&p, &x, relative, q, u[k]);
                mbsr_model_destroy(m);
            }
        }
    }
}

/* ---- models ---- */

static mbsr_model *empty(void)
{
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    return m;
}

static int add(mbsr_model *m, const char *name, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    int id;
    mbsr_body_def body = mbsr_default_body_def();
    body.name = name;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

static void force(mbsr_model *m, mbsr_force_def def)
{
    assert_ok(mbsr_model_add_force(m, &def, NULL), mbsr_model_error(m));
}

/* A particle of 1 kg, 1 m below its pivot, on a bead that springs and dampers hold. */
static void a_pendulum_on_a_bead(void **unused)
{
    (void)unused;
    const double q[3] = {0.02, -0.05, 0.3}, u[3] = {0.0, 0.0, 1.0};
    const mbsr_small_part bead = {0, MBSR_MASS};
    for (int damped = 0; damped < 2; ++damped) {
        for (int e = -2; e >= (damped        ? -8
                               : test_long() ? -6
                                             : -4);
             e -= test_long() ? 1
                  : damped    ? 3
                              : 2) {
            const double damping = damped ? 15.0 : 0.0;
            mbsr_model *m = empty();
            add(m, "bead", MBSR_GROUND, mbsr_joint_point_free(),
                mbsr_inertia_particle(pow(10.0, e)));
            add(m, "rod", 0,
                mbsr_joint_planar_revolute((mbsr_planar_frame){0.0, 0.0, 0.0},
                                           (mbsr_planar_frame){0.0, 1.0, 0.0}),
                mbsr_inertia_particle(1.0));
            force(m, mbsr_force_axis_spring(0, MBSR_GROUND, 0, 100.0, damping, 0.0));
            force(m, mbsr_force_axis_spring(0, MBSR_GROUND, 1, 100.0, damping, 0.0));
            force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
            assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
            study s = study_of(m, 2.0, 0.1);
            s.opt.part = &bead;
            s.opt.parts = 1;
            s.q = q;
            s.u = u;
            study_check(damped ? "bead, damped" : "bead", pow(10.0, e), &s);
            mbsr_model_destroy(m);
        }
    }
}

/* 5 cm high, from 0.2 s to 0.4 s: h = 0.05 sin^4 w (t - 0.2) */
static int road(void *user, double t, double *h, double *v, double *a)
{
    const double w = acos(-1.0) / 0.2, S = sin(w * (t - 0.2)), C = cos(w * (t - 0.2));
    (void)user;
    if (t < 0.2 || t > 0.4) return MBSR_OK;
    *h = 0.05 * pow(S, 4.0);
    *v = 0.05 * w * 4.0 * pow(S, 3.0) * C;
    *a = 0.05 * w * w * (12.0 * S * S * C * C - 4.0 * pow(S, 4.0));
    return MBSR_OK;
}

/* That of examples/10_quarter_car.c: carrier and spring seat are small. */
static void a_quarter_of_a_car(void **unused)
{
    (void)unused;
    static const double up[3] = {0.0, 0.0, 1.0}, zero[3] = {0.0}, k[3] = {2e5, 2e4, 1e6},
                        d[3] = {50.0, 1500.0, 50.0};
    static const char *const name[3] = {"carrier", "seat", "body"};
    const mbsr_small_part small[2] = {{1, MBSR_MASS}, {2, MBSR_MASS}};
    const mbsr_axis rise = {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 0, 1}, .driven = 1};
    for (int e = 0; e >= -4; e -= test_long() ? 1 : 2) {
        mbsr_model *m = empty();
        int body = add(m, "road", MBSR_GROUND,
                       mbsr_joint_compound(NULL, NULL, 1, &rise, road, NULL), mbsr_inertia_zero());
        for (int i = 0; i < 3; ++i) {
            body = add(m, name[i], body, mbsr_joint_prismatic(NULL, NULL, up),
                       mbsr_inertia_particle(i < 2 ? pow(10.0, e) : 400.0));
            force(m, mbsr_force_joint_spring(body, 0, k[i], d[i], 0.0));
        }
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        study s = study_of(m, 1.0, 0.02);
        s.opt.part = small;
        s.opt.parts = 2;
        s.q = s.u = zero;
        study_check("quarter car", pow(10.0, e), &s);
        mbsr_model_destroy(m);
    }
}

/* ---- a check after the fact ---- */

static void a_simulation_says_what_its_zeros_have_done(void **unused)
{
    (void)unused;
    oscillator_parameters p = oscillator_standard;
    p.m1 = 1e-2;
    p.d1 = p.d2 = 1.0;
    const double q[2] = {0.1, 0.1}, u[2] = {0.0, 0.0};
    const mbsr_small_part first = {0, MBSR_MASS};
    mbsr_model *m = paper_oscillators(&p, 0), *copy;
    study like = study_of(m, 10.0, 0.0);
    like.opt.part = &first;
    like.opt.parts = 1;
    assert_ok(mbsr_model_copy(m, &copy, NULL), NULL);
    assert_ok(mbsr_model_neglect(copy, 0, MBSR_MASS), mbsr_model_error(copy));
    mbsr_simulation s = mbsr_simulation_of(copy);
    mbsr_small_masses_report report;
    assert_int_equal(mbsr_simulation_start(&s, NULL, 0.0, q, u), MBSR_OK);
    mbsr_small_masses *small = study_begin(&like, s.q, s.u);
    const mbsr_small_masses_report expected = study_follow(&like, small, NULL);
    like.opt.part = NULL;
    like.opt.parts = 0;
    assert_ok(mbsr_simulation_watch_masses(&s, &like.opt), &s.error);
    for (int k = 1; k <= 2000; ++k) mbsr_simulation_to(&s, 10.0 * pow(k / 2000.0, 3.0));
    assert_ok(mbsr_simulation_get_masses(&s, &report), &s.error);
    print_message("error %.3e at t = %g, by each step %.3e at t = %g\n", report.error, report.time,
                  expected.error, expected.time);
    assert_int_equal(report.body, 0);
    assert_less(report.error, 1.2 * expected.error);
    assert_less(expected.error, 1.2 * report.error);
    mbsr_simulation_end(&s);
    mbsr_small_masses_destroy(small);
    mbsr_model_destroy(m);

    s = mbsr_simulation_begin(NULL);
    assert_int_equal(mbsr_simulation_get_masses(&s, &report), MBSR_ERR_SEQUENCE);
    mbsr_simulation_forgive(&s);
    assert_int_equal(mbsr_simulation_watch_masses(&s, &like.opt), MBSR_ERR_SEQUENCE);
    assert_contains(s.error.text, "mbsr_simulation_start first");
    mbsr_simulation_end(&s);
}

/* A bead snaps through between two wells while a cart pulls it: without its mass it stands still
 * where the wells end, and jumps. */
static void a_bead_that_snaps_through(void **unused)
{
    (void)unused;
    const double slide[3] = {1.0, 0.0, 0.0}, above[3] = {0.0, 1.0, 0.0}, well = -sqrt(1.25),
                 q[2] = {well, well}, u[2] = {0.0, 1.0};
    mbsr_model *m;
    mbsr_body_def body = mbsr_default_body_def();
    mbsr_small_masses *small;
    mbsr_error error;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    body.joint = mbsr_joint_prismatic(NULL, NULL, slide);
    for (int k = 0; k < 2; ++k) {
        body.inertia = mbsr_inertia_particle(k == 0 ? 1e-6 : 100.0);
        body.name = k == 0 ? "bead" : "cart";
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    force(m, mbsr_force_point_spring(0, NULL, MBSR_GROUND, above, 1.0, 0.0, 1.5));
    force(m, mbsr_force_point_spring(0, above, 1, above, 0.1, 0.0, 0.0));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    opt.duration = 20.0;
    for (int k = 3; k <= 9; k += 3) {
        mbsr_ida_opt ida = mbsr_default_ida_opt();
        mbsr_ida_stats stats;
        ida.rtol = ida.atol = pow(10.0, -k);
        assert_ok(mbsr_small_masses_create(m, &opt, &small, &error), &error);
        assert_ok(mbsr_small_masses_start(small, 0.0, q, u), mbsr_small_masses_error(small));
        assert_refused(mbsr_small_masses_run(small, &ida, 20.0, &stats, &error), &error,
                       MBSR_SINGULAR_BLOCK, 0, MBSR_NONE,
                       "u0|bead|runs away|the smooth motion ends");
        assert_in_range(stats.steps, 50, 3000);
        mbsr_small_masses_destroy(small);
    }
    mbsr_model_destroy(m);
}

/* A particle on two light links that a spring holds bent: without their masses the mass of the arm
 * is singular where it comes to be straight, and the run stood still there, for 300 000 steps of
 * 1e-30 s. With dampers the elbow passes, or stays away. */
static void an_arm_that_comes_to_be_straight(void **unused)
{
    (void)unused;
    static const double Y[3] = {0.0, 1.0, 0.0}, q[3] = {0.5, 0.4, 0.0}, u[3] = {0.0};
    static const mbsr_small_part links[2] = {{0, MBSR_MASS | MBSR_MOMENT},
                                             {1, MBSR_MASS | MBSR_MOMENT}};
    for (int damped = 0; damped < 2; ++damped) {
        mbsr_model *m;
        mbsr_small_masses *small;
        mbsr_error error;
        mbsr_ida_stats stats;
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        for (int k = 0; k < 3; ++k) {
            const mbsr_frame end = mbsr_frame_at(0.0, 0.0, k == 0 ? 0.0 : -1.0);
            mbsr_body_def body = mbsr_default_body_def();
            body.name = k == 0 ? "upper" : k == 1 ? "lower" : "tip";
            body.parent = k - 1;
            body.joint = mbsr_joint_revolute(&end, NULL, Y);
            body.inertia = mbsr_inertia_particle(1.0);
            if (k < 2)
                body.inertia =
                    mbsr_inertia_rod(1e-5, (double[3]){0.0}, (double[3]){0.0, 0.0, -1.0});
            assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
            const double damping = damped || k == 2 ? 0.1 : 0.0;
            force(m, mbsr_force_joint_spring(k, 0, k < 2 ? 50.0 : 1.0, damping, 0.0));
        }
        force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
        opt.duration = 3.0;
        opt.parts = 2;
        opt.part = links;
        assert_ok(mbsr_small_masses_create(m, &opt, &small, &error), &error);
        assert_ok(mbsr_small_masses_start(small, 0.0, q, u), mbsr_small_masses_error(small));
        const int status = mbsr_small_masses_run(small, NULL, 3.0, &stats, &error);
        if (damped)
            assert_ok(status, &error);
        else
            assert_refused(status, &error, MBSR_SINGULAR_BLOCK, 1, MBSR_NONE,
                           "u0|lower|runs away|the smooth motion ends");
        assert_in_range(stats.steps, 100, 3000);
        mbsr_small_masses_destroy(small);
        mbsr_model_destroy(m);
    }
}

/* Behind the coupler of a four-bar linkage a light wheel turns freely: it keeps its mass, and a
 * light rod on springs is looked at without. */
static void a_light_wheel_on_a_linkage(void **unused)
{
    (void)unused;
    const double z[3] = {0.0, 0.0, 1.0}, rows[6] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0},
                 end[3] = {1.0, 0.0, 0.0}, right = 1.5707963267948966;
    const double q[5] = {right, -right, right, 0.0, 0.3}, u[5] = {0.0};
    mbsr_model *m;
    mbsr_small_masses *small;
    mbsr_small_masses_report report;
    mbsr_error error;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 5; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        const double light = k < 3 ? 1.0 : 1e-5,
                     moment[6] = {0.1 * light, 0.1 * light, 0.1 * light};
        const mbsr_frame at = mbsr_frame_at(k == 0 ? 0.0 : 1.0, 0.0, 0.0);
        body.parent = k == 0 || k == 2 ? MBSR_GROUND : k == 4 ? 1 : k == 3 ? 1 : 0;
        body.joint = mbsr_joint_revolute(&at, NULL, z);
        body.inertia = mbsr_inertia_rigid(light, (double[3]){0.0}, moment);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    const mbsr_closure_def pin = mbsr_closure_rows(1, end, 2, end, 2, rows);
    assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
    force(m, mbsr_force_joint_spring(4, 0, 10.0, 0.1, 0.3));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    opt.duration = 1.0;
    assert_ok(mbsr_small_masses_create(m, &opt, &small, &error), &error);
    assert_ok(mbsr_small_masses_start(small, 0.0, q, u), mbsr_small_masses_error(small));
    assert_ok(mbsr_small_masses_get_report(small, &report), mbsr_small_masses_error(small));
    assert_int_equal(report.masses, 2);
    assert_close(report.amplitude, report.mass[0].amplitude + report.mass[1].amplitude, 1e-15);
    assert_contains(report.text, "all zeros together|swings that are lost");
    for (int k = 0; k < 2; ++k) {
        const bool wheel = report.mass[k].body == 3;
        assert_int_equal(report.mass[k].verdict,
                         wheel ? MBSR_SMALL_UNDETERMINED : MBSR_SMALL_MAY_BE_ZERO);
    }
    mbsr_small_masses_destroy(small);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_order_leaves_less_of_the_fast_motion),
        cmocka_unit_test(a_pendulum_on_a_bead),
        cmocka_unit_test(a_quarter_of_a_car),
        cmocka_unit_test(a_simulation_says_what_its_zeros_have_done),
        cmocka_unit_test(a_bead_that_snaps_through),
        cmocka_unit_test(an_arm_that_comes_to_be_straight),
        cmocka_unit_test(a_light_wheel_on_a_linkage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

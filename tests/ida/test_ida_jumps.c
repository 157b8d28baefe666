/* Forces that jump within a step: a servo that comes out of its saturation, a stop that is hit.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "problems.h"
#include "reference_runs.h"

enum { SIZE = 6 };

static const double weight = 9.81;

static const double at_rest[2] = {0.0};

/* The run of a model of one or two coordinates; max |q - reference| in tolerances. */
static double loss_of(const mbsr_model *m, const double *q, const double *u, double t_end,
                      double tolerance, const double *reference, long *steps)
{
    double y[SIZE], yp[SIZE], loss = 0.0;
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, t_end, NULL, y, NULL), mbsr_ida_error(ida));
    *steps += problem_stats(ida).steps;
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    for (int k = 0; k < mbsr_model_nq(m); ++k) loss = fmax(loss, fabs(y[k] - reference[k]));
    return loss / tolerance;
}

/* Of runs at 21 tolerances from 1e-3 to 1e-7: the most that one loses, the mean of the logarithms,
 * and their steps. */
typedef struct losses {
    double most, mean;
    long steps;
} losses;

static losses losses_of(const mbsr_model *m, const double *q, const double *u, double t_end,
                        const double *reference)
{
    enum { RUNS = 21 };
    losses l = {0.0, 0.0, 0};
    for (int k = 0; k < RUNS; ++k) {
        const double loss = loss_of(m, q, u, t_end, pow(10.0, -3.0 - 0.2 * k), reference, &l.steps);
        l.most = fmax(l.most, loss);
        l.mean += log10(loss) / RUNS;
    }
    print_message("%ld steps, at most %.0f tolerances lost, 10^%.2f in the mean\n", l.steps, l.most,
                  l.mean);
    return l;
}

/* ---- a cart on a servo, with a pole that hangs from it ---- */

typedef struct cart {
    double force, time; /* N, of either sign; s: what the servo adds to x of x' */
} cart;

/* Rates of x, the pole's angle a, and theirs. */
static void rates(const cart *c, double sign, const double s[4], double rate[4])
{
    const double M = 4.0, m = 0.5, J = 1.0 / 3.0, w = s[3], cosine = cos(s[1]), sine = sin(s[1]);
    const double f = sign * c->force - m * w * w * sine, g = -m * weight * sine - 0.02 * w;
    const double det = M * J - m * m * cosine * cosine;
    rate[0] = s[2], rate[1] = s[3];
    rate[2] = (J * f + m * cosine * g) / det;
    rate[3] = (m * cosine * f + M * g) / det;
}

static void advance(const cart *c, double sign, double h, double s[4])
{
    double k[4][4], at[4];
    for (int j = 0; j < 4; ++j) {
        const double part = j == 0 ? 0.0 : j == 3 ? h : 0.5 * h;
        for (int i = 0; i < 4; ++i) at[i] = s[i] + (j ? part * k[j - 1][i] : 0.0);
        rates(c, sign, at, k[j]);
    }
    for (int i = 0; i < 4; ++i)
        s[i] += h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
}

/* x and a after `time`: a servo as stiff as that pushes one way or the other, by the sign of 0.5 -
 * x - time x'. */
static void switched(const cart *c, double time, double end[2])
{
    double s[4] = {0.0, 0.4, 0.0, 0.0}, sign = 1.0, left = time;
    while (left > 0.0) {
        double h = fmin(1e-4, left), low = 0.0, high = h, at[4];
        memcpy(at, s, sizeof s);
        advance(c, sign, h, at);
        const bool turns = sign * (0.5 - at[0] - c->time * at[2]) < 0.0;
        for (int k = 0; k < 60 && turns; ++k) {
            h = 0.5 * (low + high);
            memcpy(at, s, sizeof s);
            advance(c, sign, h, at);
            if (sign * (0.5 - at[0] - c->time * at[2]) < 0.0)
                high = h;
            else
                low = h;
        }
        memcpy(s, at, sizeof s);
        if (turns) sign = -sign;
        left -= h;
    }
    end[0] = s[0], end[1] = s[1];
}

/* kp = 1e8 N/m: the servo turns round within 1e-7 s. Steps of high order after long ones passed
 * IDA's test with errors of 1000 tolerances: up to 9000 were lost, 10^2.8 in the mean. */
static void a_servo_turns_round_between_steps(void **state)
{
    (void)state;
    static const double q[2] = {0.0, 0.4}, X[3] = {1.0, 0.0, 0.0}, Y[3] = {0.0, 1.0, 0.0};
    const mbsr_servo servo = {.kp = 1e8, .kd = 2e4, .reference = 0.5, .limit = 60.0};
    const cart c = {servo.limit, servo.kd / servo.kp};
    double reference[2];
    mbsr_model *m = run_model();
    const int body = run_body(m, "cart", MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, X),
                              mbsr_inertia_particle(3.0));
    const int pole = run_body(m, "pole", body, mbsr_joint_revolute(NULL, NULL, Y),
                              mbsr_inertia_rod(1.0, (double[3]){0.0}, (double[3]){0, 0, -1.0}));
    run_force(m, mbsr_force_joint_servo(body, 0, &servo));
    run_force(m, mbsr_force_joint_spring(pole, 0, 0.0, 0.02, 0.0));
    run_force(m, mbsr_force_gravity(0.0, 0.0, -weight));
    switched(&c, 2.0, reference);
    const losses l = losses_of(run_finish(m), q, at_rest, 2.0, reference);
    assert_true(l.most < 1500.0 && l.mean < 2.3);
    assert_in_range(l.steps, 4000, 9000);
    mbsr_model_destroy(m);
}

/* ---- an arm of two links whose elbow has stops ---- */

typedef struct stops {
    double stiffness, ratio, end[2]; /* the last by IDA alone at 1e-11 */
} stops;

static mbsr_model *arm(double stiffness, double ratio)
{
    static const double Y[3] = {0.0, 1.0, 0.0};
    const mbsr_frame elbow = mbsr_frame_at(0.0, 0.0, -1.0);
    mbsr_model *m = run_model();
    const int upper = run_body(m, "upper", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, Y),
                               mbsr_inertia_rod(1.0, (double[3]){0.0}, (double[3]){0, 0, -1.0}));
    const int lower = run_body(m, "lower", upper, mbsr_joint_revolute(&elbow, NULL, Y),
                               mbsr_inertia_rod(0.7, (double[3]){0.0}, (double[3]){0, 0, -0.8}));
    const double damping = 2.0 * ratio * sqrt(0.1 * stiffness);
    run_force(m, mbsr_force_joint_stop(lower, 0, -0.5, 0.7, stiffness, damping));
    run_force(m, mbsr_force_gravity(0.0, 0.0, -weight));
    return run_finish(m);
}

static const double raised[2] = {1.8, 0.2};

/* An impact was taken for an offset of something stiff, and filtered: 23 000 and 11 000 tolerances
 * lost. One run in 600 still lost 1000 to 2600, by each compiler another: where the arm moved
 * freely along an error the stop counted as one that had acted before. */
static void a_stop_that_is_hit_takes_the_impact(void **state)
{
    (void)state;
    static const stops table[] = {{1e10, 0.02, {1.52327792, 0.25474554}},
                                  {1e12, 0.1, {1.36972570, 0.69024734}}};
    for (int k = 0; k < 2; ++k) {
        const stops *s = table + k;
        mbsr_model *m = arm(s->stiffness, s->ratio);
        const losses l = losses_of(m, raised, at_rest, 3.0, s->end);
        assert_true(l.most < 300.0 && l.mean < 1.5);
        assert_in_range(l.steps, 5000, 25000);
        mbsr_model_destroy(m);
    }
}

/* 1e14 N m/rad: the last digit of the elbow's angle is 1.1e-2 N m. A search for where these balance
 * found nothing, and took back the correction of the shoulder, too: one run in ten lost 400 to
 * 7000 tolerances. What the elbow needs to be held falls through less than that digit in a
 * millisecond when it leaves: no tolerance makes 4e-6 of that certain. */
static void a_stop_that_bears_a_load_holds_nothing_else(void **state)
{
    (void)state;
    enum { RUNS = 30 };
    static const double end[2] = {1.3289997064152381, 0.69959097653360713};
    static const double rounding = 4e-6;
    double most = 0.0;
    long steps = 0;
    mbsr_model *m = arm(1e14, 0.5);
    for (int k = 0; k < RUNS; ++k) {
        const double tolerance = 2e-9 * pow(5.0, (double)k / (RUNS - 1));
        const double loss = loss_of(m, raised, at_rest, 3.0, tolerance, end, &steps);
        assert_less(loss * tolerance, fmax(1000.0 * tolerance, rounding));
        most = fmax(most, loss);
    }
    print_message("%ld steps, at most %.0f tolerances lost\n", steps, most);
    assert_true(most < test_seeds(2000, 1000)); /* without optimisation 1236, 2.5e-6 rad */
    assert_in_range(steps, 30L * RUNS, 6000L * RUNS);
    mbsr_model_destroy(m);
}

/* ---- a body that bounces ---- */

/* At 1 m/s off a spring, without loss: the longer the steps before, the smaller IDA's constant of
 * the one that meets the spring. 20 times that let it end anywhere in it: up to 110 000 tolerances
 * lost with 1e14 N/m, 10^3.0 in the mean. */
static void a_bounce_is_as_good_at_any_stiffness(void **state)
{
    (void)state;
    static const double q[1] = {0.0}, u[1] = {1.0}, X[3] = {1.0, 0.0, 0.0}, limit = 0.7,
                        t_end = 2.0;
    for (int k = 6; k <= 14; k += 2) {
        const double stiffness = pow(10.0, k);
        const double end = limit - (t_end - limit - acos(-1.0) / sqrt(stiffness));
        mbsr_model *m = run_model();
        const int body = run_body(m, "body", MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, X),
                                  mbsr_inertia_particle(1.0));
        run_force(m, mbsr_force_joint_stop(body, 0, -1e3, limit, stiffness, 0.0));
        const losses l = losses_of(run_finish(m), q, u, t_end, &end);
        assert_true(l.most < 300.0 && l.mean < 1.6);
        assert_in_range(l.steps, 1000, 4000);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_servo_turns_round_between_steps),
        cmocka_unit_test(a_stop_that_is_hit_takes_the_impact),
        cmocka_unit_test(a_bounce_is_as_good_at_any_stiffness),
        cmocka_unit_test(a_stop_that_bears_a_load_holds_nothing_else)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Tables: values and derivatives between and beyond the points, kinks, refusals, in models.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <float.h>

enum { POINTS = 7, COLUMNS = 2 };

static const double X[POINTS] = {-1.0, -0.25, 0.0, 0.5, 0.6, 2.0, 3.0};
static const double V[POINTS * COLUMNS] = {1.0, 0.0, 2.0, -1.0, 2.5,  -1.0, 2.0,
                                           0.5, 0.0, 0.7, 0.0,  -2.0, 0.25, 1.0};

static mbsr_table *make(mbsr_table_kind kind, mbsr_table_beyond beyond)
{
    mbsr_table_def def = mbsr_default_table_def();
    mbsr_table *table = NULL;
    mbsr_error error = {0};
    def.points = POINTS;
    def.x = X;
    def.columns = COLUMNS;
    def.value = V;
    def.kind = kind;
    def.beyond = beyond;
    assert_ok(mbsr_table_create(&def, &table, &error), &error);
    return table;
}

static mbsr_table *make_one(int points, const double *x, const double *v, mbsr_table_kind kind)
{
    mbsr_table_def def = mbsr_default_table_def();
    mbsr_table *table = NULL;
    mbsr_error error = {0};
    def.points = points;
    def.x = x;
    def.value = v;
    def.kind = kind;
    assert_ok(mbsr_table_create(&def, &table, &error), &error);
    return table;
}

/* Value, first and second derivative of one column. */
static void at(const mbsr_table *table, int column, double x, double out[3])
{
    double value[COLUMNS], first[COLUMNS], second[COLUMNS];
    assert_int_equal(mbsr_table_value(table, x, value, first, second), MBSR_OK);
    out[0] = value[column];
    out[1] = first[column];
    out[2] = second[column];
}

static void tables_go_through_their_points(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; ++kind) {
        mbsr_table *table = make((mbsr_table_kind)kind, MBSR_TABLE_REFUSE);
        for (int k = 0; k < POINTS; ++k) {
            for (int c = 0; c < COLUMNS; ++c) {
                double out[3];
                at(table, c, X[k], out);
                assert_close(out[0], V[k * COLUMNS + c], 1e-14);
            }
        }
        mbsr_table_destroy(table);
    }
}

/* Inside the pieces, against differences of the values. */
static void derivatives_are_those_of_the_values(void **state)
{
    (void)state;
    const double h = 1e-4;
    for (int kind = 0; kind < 3; ++kind) {
        mbsr_table *table = make((mbsr_table_kind)kind, MBSR_TABLE_STRAIGHT);
        for (double x = -1.51; x < 3.5; x += 0.0421) {
            for (int c = 0; c < COLUMNS; ++c) {
                double a[3], b[3], out[3];
                int near = 0;
                for (int k = 0; k < POINTS; ++k) near = near || fabs(x - X[k]) < 2.0 * h;
                if (near) continue;
                at(table, c, x - h, a);
                at(table, c, x + h, b);
                at(table, c, x, out);
                assert_close((b[0] - a[0]) / (2.0 * h), out[1], 1e-4);
                assert_close((b[1] - a[1]) / (2.0 * h), out[2], 1e-6);
            }
        }
        mbsr_table_destroy(table);
    }
}

/* How much derivative n of column c jumps at X[k]. */
static double jump(const mbsr_table *table, int c, int k, int n)
{
    double left[3], right[3];
    at(table, c, nextafter(X[k], -INFINITY), left);
    at(table, c, X[k], right);
    return right[n] - left[n];
}

static void kinds_are_as_smooth_as_they_say(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; ++kind) {
        mbsr_table *table = make((mbsr_table_kind)kind, MBSR_TABLE_CONSTANT);
        for (int k = 1; k < POINTS - 1; ++k) {
            for (int c = 0; c < COLUMNS; ++c) {
                for (int n = 0; n <= kind; ++n) assert_close(jump(table, c, k, n), 0.0, 1e-12);
            }
        }
        mbsr_table_destroy(table);
    }
}

/* Two continuous derivatives, the points, and a continuous third derivative at the first and last
 * inner point are all there is to such a spline. So a cubic is its own spline. */
static void splines_are_not_a_knot(void **state)
{
    (void)state;
    mbsr_table *table = make(MBSR_TABLE_SPLINE, MBSR_TABLE_REFUSE);
    for (int c = 0; c < COLUMNS; ++c) {
        for (int k = 1; k < POINTS - 1; k += POINTS - 3) {
            /* the second derivative is a line in each piece */
            double a[3], b[3], d[3];
            at(table, c, X[k - 1], a);
            at(table, c, X[k], b);
            at(table, c, 0.5 * (X[k] + X[k + 1]), d);
            const double left = (b[2] - a[2]) / (X[k] - X[k - 1]),
                         right = (d[2] - b[2]) / (0.5 * (X[k + 1] - X[k]));
            assert_close(left, right, 1e-10 * (1.0 + fabs(left)));
        }
    }
    mbsr_table_destroy(table);
    for (int points = 2; points <= POINTS; ++points) {
        double v[POINTS], out[3];
        const int degree = points < 4 ? points - 1 : 3;
        const double a[4] = {0.3, -1.2, degree > 1 ? 0.7 : 0.0, degree > 2 ? 0.4 : 0.0};
        for (int k = 0; k < points; ++k) v[k] = a[0] + X[k] * (a[1] + X[k] * (a[2] + X[k] * a[3]));
        table = make_one(points, X, v, MBSR_TABLE_SPLINE);
        for (double x = X[0]; x < X[points - 1]; x += 0.03) {
            at(table, 0, x, out);
            assert_close(out[0], a[0] + x * (a[1] + x * (a[2] + x * a[3])), 1e-13);
            assert_close(out[1], a[1] + x * (2.0 * a[2] + 3.0 * x * a[3]), 1e-12);
            assert_close(out[2], 2.0 * a[2] + 6.0 * x * a[3], 1e-11);
        }
        mbsr_table_destroy(table);
    }
}

/* Between neighbours in each piece; slopes by hand: harmonic means, and zero where values turn. */
static void monotone_tables_do_not_overshoot(void **state)
{
    (void)state;
    mbsr_table *table = make(MBSR_TABLE_MONOTONE, MBSR_TABLE_REFUSE);
    double out[3];
    for (int k = 0; k + 1 < POINTS; ++k) {
        for (int c = 0; c < COLUMNS; ++c) {
            const double a = V[k * COLUMNS + c], b = V[(k + 1) * COLUMNS + c];
            double before = a;
            for (int l = 0; l <= 20; ++l) {
                at(table, c, X[k] + (X[k + 1] - X[k]) * l / 20.0 * (1.0 - 1e-15), out);
                assert_true(b >= a ? out[0] >= before - 1e-14 : out[0] <= before + 1e-14);
                before = out[0];
            }
        }
    }
    at(table, 0, 0.0, out); /* 2, 2.5, 2: a turn */
    assert_close(out[1], 0.0, 0.0);
    at(table, 0, -0.25, out); /* pieces of 0.75 and 0.25 with slopes 4/3 and 2 */
    assert_close(out[1], 3.0 / (1.25 / (4.0 / 3.0) + 1.75 / 2.0), 1e-14);
    at(table, 1, -0.25, out); /* beside a flat piece */
    assert_close(out[1], 0.0, 0.0);
    mbsr_table_destroy(table);
    /* a line is a line, at its ends too */
    const double x[3] = {0.0, 1.0, 4.0}, v[3] = {1.0, 3.0, 9.0};
    table = make_one(3, x, v, MBSR_TABLE_MONOTONE);
    for (double place = 0.0; place < 4.0; place += 0.25) {
        at(table, 0, place, out);
        assert_close(out[0], 1.0 + 2.0 * place, 1e-14);
    }
    mbsr_table_destroy(table);
}

static void beyond_their_ends(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; ++kind) {
        mbsr_table *constant = make((mbsr_table_kind)kind, MBSR_TABLE_CONSTANT),
                   *straight = make((mbsr_table_kind)kind, MBSR_TABLE_STRAIGHT),
                   *refuse = make((mbsr_table_kind)kind, MBSR_TABLE_REFUSE);
        for (int side = 0; side < 2; ++side) {
            const int end = side ? POINTS - 1 : 0;
            const double x = X[end] + (side ? 2.0 : -2.0);
            double out[3], edge[3], untouched[COLUMNS] = {7.0, 7.0};
            at(constant, 1, x, out);
            assert_true(out[0] == V[end * COLUMNS + 1] && out[1] == 0.0 && out[2] == 0.0);
            at(straight, 1, X[end], edge);
            at(straight, 1, x, out);
            assert_close(out[0], edge[0] + (x - X[end]) * edge[1], 1e-13);
            assert_true(out[1] == edge[1] && out[2] == 0.0);
            assert_int_equal(mbsr_table_value(refuse, x, untouched, NULL, NULL), MBSR_ERR_VALUE);
            assert_true(untouched[0] == 7.0 && untouched[1] == 7.0);
            assert_int_equal(mbsr_table_value(refuse, X[end], untouched, NULL, NULL), MBSR_OK);
        }
        mbsr_table_destroy(constant);
        mbsr_table_destroy(straight);
        mbsr_table_destroy(refuse);
    }
}

/* ---- kinks ---- */

static void expect_kinks(const mbsr_table *table, int count, const double *x, const int *derivative)
{
    double from = -INFINITY, next = 0.0;
    int found = 0;
    for (int k = 0; k <= count; ++k, from = next) {
        assert_int_equal(mbsr_table_kink(table, from, 1, &next, &found), MBSR_OK);
        assert_true(next == (k < count ? x[k] : INFINITY));
        if (k < count) assert_int_equal(found, derivative[k]);
    }
    from = INFINITY;
    for (int k = count - 1; k >= -1; --k, from = next) {
        assert_int_equal(mbsr_table_kink(table, from, -1, &next, &found), MBSR_OK);
        assert_true(next == (k >= 0 ? x[k] : -INFINITY));
        if (k >= 0) assert_int_equal(found, derivative[k]);
    }
    if (count == 0) return;
    assert_int_equal(mbsr_table_kink(table, nextafter(x[0], INFINITY), -1, &next, &found), MBSR_OK);
    assert_true(next == x[0]);
    assert_int_equal(mbsr_table_kink(table, nextafter(x[0], -INFINITY), 1, &next, &found), MBSR_OK);
    assert_true(next == x[0]);
}

static void kinks_are_where_derivatives_jump(void **state)
{
    (void)state;
    mbsr_table *table = make(MBSR_TABLE_LINEAR, MBSR_TABLE_CONSTANT);
    expect_kinks(table, POINTS, X, (const int[]){1, 1, 1, 1, 1, 1, 1});
    mbsr_table_destroy(table);
    table = make(MBSR_TABLE_MONOTONE, MBSR_TABLE_STRAIGHT);
    expect_kinks(table, POINTS, X, (const int[]){2, 2, 2, 2, 2, 2, 2});
    mbsr_table_destroy(table);
    table = make(MBSR_TABLE_SPLINE, MBSR_TABLE_CONSTANT);
    expect_kinks(table, POINTS, X, (const int[]){1, 3, 3, 3, 3, 3, 1});
    mbsr_table_destroy(table);
    /* three points in a line, and a slope of zero at an end where it stays */
    const double x[5] = {0.0, 0.1, 0.3, 0.4, 1.0}, v[5] = {0.1, 0.2, 0.4, 0.5, 0.5};
    table = make_one(5, x, v, MBSR_TABLE_LINEAR);
    expect_kinks(table, 2, (const double[]){0.0, 0.4}, (const int[]){1, 1});
    mbsr_table_destroy(table);
}

/* ---- refusals ---- */

static void refuse(const mbsr_table_def *def, int status, const char *words)
{
    mbsr_table *table = (mbsr_table *)(void *)&words;
    mbsr_error error = {0};
    assert_refused(mbsr_table_create(def, &table, &error), &error, status, MBSR_NONE, MBSR_NONE,
                   words);
    assert_null(table);
    assert_int_equal(mbsr_table_create(def, &table, NULL), status);
}

static void bad_tables_are_refused_with_the_index(void **state)
{
    (void)state;
    double x[4] = {0.0, 1.0, 2.0, 3.0}, v[8] = {0.0};
    mbsr_table_def def = mbsr_default_table_def(), good;
    def.points = 4;
    def.x = x;
    def.value = v;
    def.columns = 2;
    good = def;
    refuse(NULL, MBSR_ERR_NULL, "def is NULL");
    assert_int_equal(mbsr_table_create(&good, NULL, NULL), MBSR_ERR_NULL);
    def.cookie = 0;
    refuse(&def, MBSR_ERR_NO_DEFAULT, "mbsr_default_table_def");
    def = good, def.points = 1;
    refuse(&def, MBSR_ERR_VALUE, "points is 1, must be 2 or more");
    def = good, def.columns = 0;
    refuse(&def, MBSR_ERR_VALUE, "columns is 0, must be 1 .. 256");
    def = good, def.kind = (mbsr_table_kind)3;
    refuse(&def, MBSR_ERR_VALUE, "kind is 3");
    def = good, def.beyond = (mbsr_table_beyond)-1;
    refuse(&def, MBSR_ERR_VALUE, "beyond is -1");
    def = good, def.x = NULL;
    refuse(&def, MBSR_ERR_NULL, "x is NULL");
    def = good, def.value = NULL;
    refuse(&def, MBSR_ERR_NULL, "value is NULL");
    const double wrong[] = {1.0, 0.5, NAN, INFINITY};
    const char *const text[] = {"x[2] is 1, not above x[1], which is 1",
                                "x[2] is 0.5, not above x[1], which is 1", "x[2] is nan",
                                "x[2] is inf"};
    for (int k = 0; k < 4; ++k) {
        x[2] = wrong[k];
        refuse(&good, MBSR_ERR_VALUE, text[k]);
    }
    x[2] = 2.0;
    v[5] = NAN;
    refuse(&good, MBSR_ERR_VALUE, "value[5] is nan (point 2, column 1)");
    v[5] = 0.0, v[4] = 1e300, x[2] = nextafter(1.0, 2.0);
    refuse(&good, MBSR_ERR_VALUE, "slope at x[1]|column 0|overflows");
}

static void questions_that_make_no_sense_are_refused(void **state)
{
    (void)state;
    mbsr_table *table = make(MBSR_TABLE_LINEAR, MBSR_TABLE_CONSTANT);
    double value[COLUMNS] = {0.0}, next = 0.0;
    int derivative = 0;
    assert_int_equal(mbsr_table_value(NULL, 0.0, value, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_table_value(table, NAN, value, NULL, NULL), MBSR_NOT_FINITE);
    assert_int_equal(mbsr_table_value(table, INFINITY, value, NULL, NULL), MBSR_NOT_FINITE);
    mbsr_table_destroy(table);
    table = make(MBSR_TABLE_LINEAR, MBSR_TABLE_STRAIGHT); /* the value alone overflows */
    assert_int_equal(mbsr_table_value(table, DBL_MAX, value, NULL, NULL), MBSR_NOT_FINITE);
    assert_int_equal(mbsr_table_kink(NULL, 0.0, 1, &next, &derivative), MBSR_ERR_NULL);
    assert_int_equal(mbsr_table_kink(table, 0.0, 1, NULL, &derivative), MBSR_ERR_NULL);
    assert_int_equal(mbsr_table_kink(table, 0.0, 1, &next, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_table_kink(table, 0.0, 0, &next, &derivative), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_table_kink(table, NAN, 1, &next, &derivative), MBSR_NOT_FINITE);
    assert_int_equal(mbsr_table_force(table, 0.0, 1, value), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_table_force(NULL, 0.0, 1, value), MBSR_ERR_NULL);
    mbsr_table_destroy(table);
    mbsr_table_destroy(NULL);
}

/* ---- in models ---- */

static void models_know_the_kinks_of_their_tables(void **state)
{
    (void)state;
    const double x[3] = {0.0, 1.0, 3.0}, v[3] = {0.0, 1.0, 0.5}, later[3] = {1.0, 1.5, 4.0};
    const double axis[3] = {1.0, 0.0, 0.0};
    const mbsr_axis drive = {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 0, 1}, .driven = 1};
    mbsr_table *height = make_one(3, x, v, MBSR_TABLE_MONOTONE),
               *force = make_one(3, later, v, MBSR_TABLE_LINEAR),
               *two = make(MBSR_TABLE_LINEAR, MBSR_TABLE_CONSTANT);
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    mbsr_kink next;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_compound(NULL, NULL, 1, &drive, mbsr_table_motion, two);
    assert_refused(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m), MBSR_ERR_VALUE, 0,
                   MBSR_NONE, "2 columns, must have 1");
    body.joint.user = NULL;
    assert_refused(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m), MBSR_ERR_NULL, 0,
                   MBSR_NONE, "must be the table");
    body.joint = mbsr_joint_planar((mbsr_planar_frame){0}, (mbsr_planar_frame){0}, MBSR_ANGLE,
                                   MBSR_X, mbsr_table_motion, two);
    assert_refused(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m), MBSR_ERR_VALUE, 0,
                   MBSR_NONE, "2 columns, must have 1");
    body.joint = mbsr_joint_compound(NULL, NULL, 1, &drive, mbsr_table_motion, height);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body = mbsr_default_body_def();
    body.parent = 0;
    body.joint = mbsr_joint_prismatic(NULL, NULL, axis);
    body.inertia = mbsr_inertia_particle(2.0);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    mbsr_force_def pull = mbsr_force_joint_applied(1, mbsr_table_force, force);
    assert_ok(mbsr_model_add_force(m, &pull, NULL), mbsr_model_error(m));
    assert_int_equal(mbsr_model_kink(m, 0.0, 1, &next), MBSR_ERR_UNFINISHED);
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);

    const double t[] = {0.0, 1.0, 1.5, 3.0, 4.0};
    const int derivative[] = {1, 2, 2, 1, 2}; /* at 0 and 3 the height stands still from a slope */
    for (int k = 0; k < 5; ++k) {
        assert_int_equal(mbsr_model_kink(m, k ? t[k - 1] : -9.0, 1, &next), MBSR_OK);
        assert_true(next.t == t[k]);
        assert_int_equal(next.derivative, derivative[k]);
        assert_int_equal(mbsr_model_kink(m, k < 4 ? t[k + 1] : 9.0, -1, &next), MBSR_OK);
        assert_true(next.t == t[k]);
    }
    assert_int_equal(mbsr_model_kink(m, 4.0, 1, &next), MBSR_OK);
    assert_true(next.t == INFINITY && next.derivative == 1);
    assert_int_equal(mbsr_model_kink(m, 0.0, -1, &next), MBSR_OK);
    assert_true(next.t == -INFINITY);
    assert_int_equal(mbsr_model_kink(m, 0.0, 2, &next), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_model_kink(m, NAN, 1, &next), MBSR_NOT_FINITE);
    assert_int_equal(mbsr_model_kink(NULL, 0.0, 1, &next), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_kink(m, 0.0, 1, NULL), MBSR_ERR_NULL);

    /* the slider is pulled by half the way from (1, 0) to (1.5, 1), the table stands at its height
     */
    double q = 0.2, u = 0.0, udot = 0.0, pose[MBSR_POSE_SIZE], out[3];
    assert_ok(mbsr_forward_dynamics(m, d, 1.25, &q, &u, NULL, &udot), mbsr_data_error(d));
    assert_close(udot, 0.25, 1e-14);
    assert_ok(mbsr_body_pose(m, d, 1, pose), mbsr_data_error(d));
    at(height, 0, 1.25, out);
    assert_close(pose[MBSR_POSE_X + 2], out[0], 1e-15);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    mbsr_table_destroy(height);
    mbsr_table_destroy(force);
    mbsr_table_destroy(two);
}

static void forces_want_as_many_columns_as_they_have_components(void **state)
{
    (void)state;
    mbsr_table *two = make(MBSR_TABLE_LINEAR, MBSR_TABLE_CONSTANT);
    const double axis[3] = {1.0, 0.0, 0.0};
    for (int k = 0; k < 4; ++k) {
        mbsr_model *m = NULL;
        assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_prismatic(NULL, NULL, axis);
        body.inertia = mbsr_inertia_particle(2.0);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        mbsr_force_def force =
            k == 0   ? mbsr_force_joint_applied(0, mbsr_table_force, two)
            : k == 1 ? mbsr_force_applied(0, mbsr_table_force, two)
                     : mbsr_force_wrench(0, NULL, 0, mbsr_table_force, k == 2 ? two : NULL);
        assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
        assert_refused(mbsr_model_finish(m), mbsr_model_error(m),
                       k < 3 ? MBSR_ERR_VALUE : MBSR_ERR_NULL, MBSR_NONE, 0,
                       k == 0  ? "2 columns, must have 1"
                       : k < 3 ? "2 columns, must have 6"
                               : "must be the table");
        mbsr_model_destroy(m);
    }
    mbsr_table_destroy(two);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_go_through_their_points),
        cmocka_unit_test(derivatives_are_those_of_the_values),
        cmocka_unit_test(kinds_are_as_smooth_as_they_say),
        cmocka_unit_test(splines_are_not_a_knot),
        cmocka_unit_test(monotone_tables_do_not_overshoot),
        cmocka_unit_test(beyond_their_ends),
        cmocka_unit_test(kinks_are_where_derivatives_jump),
        cmocka_unit_test(bad_tables_are_refused_with_the_index),
        cmocka_unit_test(questions_that_make_no_sense_are_refused),
        cmocka_unit_test(models_know_the_kinks_of_their_tables),
        cmocka_unit_test(forces_want_as_many_columns_as_they_have_components),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

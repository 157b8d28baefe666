/* Height fields: planes and paraboloids that they have exactly, borders, refusals.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "shapes.h"

#include <math.h>
#include <stdlib.h>

enum { SAMPLES = 9 };

typedef double (*surface_fn)(double x, double y);

static double tilted(double x, double y)
{
    return 0.3 + 0.4 * x - 0.2 * y;
}

static double level(double x, double y)
{
    (void)x, (void)y;
    return 0.0;
}

static const double radius = 1.5;

static double bowl(double x, double y)
{
    return (x * x + y * y) / (2.0 * radius);
}

static double hill(double x, double y)
{
    return -bowl(x, y);
}

static double rough(double x, double y)
{
    return 0.03 * sin(40.0 * x) * cos(31.0 * y) + 0.02 * sin(17.0 * x + 23.0 * y);
}

/* Over 2 x 1.6 m in units of `length`; heights to `height`, at most 50 x 50. */
static mbsr_shape field_of(surface_fn f, int columns, int rows, double length, double *height)
{
    mbsr_shape s = sample_shape(MBSR_SHAPE_HEIGHTS, MBSR_GROUND);
    s.size[0] = length, s.size[1] = 0.8 * length;
    s.columns = columns, s.rows = rows;
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i)
            height[j * columns + i] =
                length * f(2.0 * i / (columns - 1) - 1.0, 1.6 * j / (rows - 1) - 0.8);
    }
    s.height = height;
    return s;
}

static void draw_pose(uint64_t *seed, double q[7], double u[6])
{
    double length = 0.0;
    for (int k = 0; k < 4; ++k) q[k] = draw(seed), length += q[k] * q[k];
    for (int k = 0; k < 4; ++k) q[k] /= sqrt(length);
    for (int k = 0; k < 6; ++k) u[k] = draw(seed);
}

/* ---- planes ---- */

static void check_same(const mbsr_contact_point *x, const mbsr_contact_point *y)
{
    assert_close(x->depth, y->depth, 1e-14);
    assert_close(x->normal_force, y->normal_force, 1e-10 * (1.0 + y->normal_force));
    for (int k = 0; k < 3; ++k) {
        assert_close(x->normal[k], y->normal[k], 1e-13);
        assert_close(x->point[k], y->point[k], 1e-13);
        assert_close(x->friction[k], y->friction[k], 1e-9 * (1.0 + y->normal_force));
    }
}

/* What is a plane as samples is that plane to rounding, of two samples and of many. */
static void planes(void **unused)
{
    (void)unused;
    static const mbsr_shape_kind kinds[] = {MBSR_SHAPE_SPHERE, MBSR_SHAPE_CAPSULE, MBSR_SHAPE_BOX,
                                            MBSR_SHAPE_MESH, MBSR_SHAPE_ELLIPSOID};
    double height[2500];
    const double on[3] = {0.0, 0.0, 0.3}, normal[3] = {-0.4, 0.2, 1.0};
    uint64_t seed = 3;
    int touched = 0;
    for (int k = 0; k < 10; ++k) {
        mbsr_shape shape[2] = {field_of(tilted, k % 2 ? 2 : 31, k % 2 ? 2 : 17, 1.0, height),
                               sample_shape(kinds[k / 2], 0)};
        scene field = scene_of(2, shape);
        shape[0].kind = MBSR_SHAPE_PLANE;
        shape[0].frame = mbsr_frame_along(on, normal);
        scene plane = scene_of(2, shape);
        for (int l = 0; l < 25; ++l) {
            double q[7], u[6];
            mbsr_contact_point x[64], y[64];
            draw_pose(&seed, q, u);
            q[4] = 0.5 * draw(&seed), q[5] = 0.4 * draw(&seed);
            q[6] = tilted(q[4], q[5]) + 0.2 + 0.06 * draw(&seed);
            const int count = points_at(&plane, q, u, 64, y);
            assert_int_equal(points_at(&field, q, u, 64, x), count);
            for (int p = 0; p < count; ++p) check_same(x + p, y + p);
            touched += count > 0;
        }
        end_scene(&field);
        end_scene(&plane);
    }
    assert_true(touched > 90);
}

/* A margin of the field is one of the plane: a ball feels it from as far above. */
static void margins(void **unused)
{
    (void)unused;
    double height[64];
    mbsr_shape shape[2] = {field_of(level, 8, 8, 1.0, height), sample_shape(MBSR_SHAPE_SPHERE, 0)};
    shape[0].law.margin = 0.05;
    scene field = scene_of(2, shape);
    shape[0].kind = MBSR_SHAPE_PLANE;
    shape[0].frame = mbsr_frame_identity();
    scene plane = scene_of(2, shape);
    for (int k = 0; k < 30; ++k) {
        const double q[7] = {1.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.2 - 0.021 + 0.003 * k}, u[6] = {0.0};
        mbsr_contact_point x, y;
        const int count = points_at(&plane, q, u, 1, &y);
        assert_int_equal(count, k < 24);
        assert_int_equal(points_at(&field, q, u, 1, &x), count);
        if (count > 0) check_same(&x, &y);
    }
    end_scene(&field);
    end_scene(&plane);
}

/* ---- paraboloids ---- */

/* A sphere over a place of a paraboloid, moved off along the normal: the depth is known. In four
 * systems of units. */
static void paraboloids(void **unused)
{
    (void)unused;
    static const double lengths[] = {1.0, 1000.0, 3.28, 0.01};
    uint64_t seed = 5;
    for (int k = 0; k < 8; ++k) {
        const surface_fn f = k % 2 ? hill : bowl;
        const double unit = lengths[k / 2], sign = k % 2 ? -1.0 : 1.0;
        double height[2500];
        mbsr_shape shape[2] = {field_of(f, 21, SAMPLES, unit, height),
                               sample_shape(MBSR_SHAPE_SPHERE, 0)};
        shape[1].size[0] = 0.2 * unit;
        shape[0].law.stiffness = shape[1].law.stiffness = 2e4 / pow(unit, 1.5);
        scene s = scene_of(2, shape);
        for (int l = 0; l < 20; ++l) {
            double q[7], u[6];
            mbsr_contact_point point[4];
            draw_pose(&seed, q, u);
            const double x = 0.9 * draw(&seed), y = 0.7 * draw(&seed),
                         up[3] = {-sign * x / radius, -sign * y / radius, 1.0},
                         size = sqrt(up[0] * up[0] + up[1] * up[1] + 1.0),
                         depth = 0.05 * (1.0 + draw(&seed)), off = 0.2 - depth;
            q[4] = unit * (x + off * up[0] / size);
            q[5] = unit * (y + off * up[1] / size);
            q[6] = unit * (f(x, y) + off * up[2] / size);
            assert_int_equal(points_at(&s, q, u, 4, point), 1);
            assert_close(point->depth, unit * depth, 1e-14 * unit);
            for (int r = 0; r < 3; ++r)
                assert_close(fabs(point->normal[r]), fabs(up[r] / size), 1e-12);
            assert_close(point->normal_force,
                         1e4 * pow(depth, 1.5) * fmax(0.0, 1.0 + 0.3 * point->rate),
                         1e-9 * point->normal_force);
        }
        end_scene(&s);
    }
}

/* ---- the nearest point ---- */

/* The spline of samples 0.1 m apart, away from the border, by values of the cubic B-spline. */
static double spline_at(const double *height, int columns, double x, double y)
{
    const double at[2] = {(x + 1.0) / 0.1, (y + 0.8) / 0.1};
    const int cell[2] = {(int)floor(at[0]), (int)floor(at[1])};
    double w[2][4], sum = 0.0;
    for (int k = 0; k < 2; ++k) {
        for (int l = 0; l < 4; ++l) {
            const double far = fabs(at[k] - (cell[k] + l - 1));
            w[k][l] = far < 1.0   ? 2.0 / 3.0 - far * far + far * far * far / 2.0
                      : far < 2.0 ? pow(2.0 - far, 3.0) / 6.0
                                  : 0.0;
        }
    }
    for (int k = 0; k < 16; ++k) {
        const double *h = height + (cell[1] + k / 4 - 1) * columns + cell[0] + k % 4 - 1;
        double control = h[0];
        for (int l = 0; l < 9; ++l) { /* (1 - second difference / 6) along x and y */
            static const double part[3] = {-1.0 / 6.0, 4.0 / 3.0, -1.0 / 6.0};
            control +=
                (part[l / 3] * part[l % 3] - (l == 4)) * h[(l / 3 - 1) * columns + l % 3 - 1];
        }
        sum += w[0][k % 4] * w[1][k / 4] * control;
    }
    return sum;
}

/* The least distance from a point, of places of a grid around the last best one, ever finer. */
static double least_distance(const double *height, int columns, const double p[3], double reach)
{
    double best = INFINITY, at[2] = {p[0], p[1]}, next[2] = {p[0], p[1]};
    for (double step = reach / 20.0; step > 1e-7; step /= 5.0) {
        const int side = step < reach / 20.0 ? 21 : 41;
        for (int k = 0; k < side * side; ++k) {
            const double x = at[0] + step * (k % side - side / 2),
                         y = at[1] + step * (k / side - side / 2),
                         z = spline_at(height, columns, x, y) - p[2],
                         square = (x - p[0]) * (x - p[0]) + (y - p[1]) * (y - p[1]) + z * z;
            if (square < best) best = square, next[0] = x, next[1] = y;
        }
        at[0] = next[0], at[1] = next[1];
    }
    return sqrt(best);
}

/* Spheres from a tenth of a cell to two cells over a rough field: the deepest of their points is
 * where a search for it ends; and there are none where the field is farther. */
static void nearest(void **unused)
{
    (void)unused;
    static const double radii[] = {0.01, 0.05, 0.1, 0.2};
    double height[2500];
    uint64_t seed = 8;
    int touched = 0, apart = 0;
    for (int k = 0; k < 4; ++k) {
        const double r = radii[k];
        mbsr_shape shape[2] = {field_of(rough, 21, 17, 1.0, height),
                               sample_shape(MBSR_SHAPE_SPHERE, 0)};
        shape[1].size[0] = r;
        scene s = scene_of(2, shape);
        for (int l = 0; l < 20; ++l) {
            double q[7], u[6], deepest = -INFINITY;
            mbsr_contact_point point[64];
            draw_pose(&seed, q, u);
            q[4] = 0.5 * draw(&seed), q[5] = 0.3 * draw(&seed);
            q[6] = spline_at(height, 21, q[4], q[5]) + r * (1.1 + 0.6 * draw(&seed));
            const double least = least_distance(height, 21, q + 4, 1.2 * r);
            const int count = points_at(&s, q, u, 64, point);
            for (int p = 0; p < count; ++p) deepest = fmax(deepest, point[p].depth);
            if (least < r - 1e-6) assert_close(deepest, r - least, 1e-8);
            if (least > r + 1e-6) assert_int_equal(count, 0);
            touched += least < r;
            apart += least > r;
        }
        end_scene(&s);
    }
    assert_true(touched > 40 && apart > 10);
}

/* ---- borders ---- */

/* The force on a shape at a place of a line over cells of a rough field and beyond its border. */
static double force_at(scene *s, double x, double z, double force[3])
{
    const double u[6] = {0.1, 0.3, 0.2, 0.4, 0.1, -0.3}, q[7] = {0.8, 0.6, 0.0, 0.0, x, 0.1 * x, z};
    mbsr_contact_point point[64];
    double size = 0.0;
    const int count = points_at(s, q, u, 64, point);
    assert_true(count <= 64);
    for (int r = 0; r < 3; ++r) {
        force[r] = 0.0;
        for (int p = 0; p < count; ++p)
            force[r] += point[p].normal_force * point[p].normal[r] + point[p].friction[r];
        size += force[r] * force[r];
    }
    return sqrt(size);
}

/* The largest change between places of a part of the line, and between which of them it is. */
static double largest_change(scene *s, int steps, double z, double part[2], double *most)
{
    double before[3], change = 0.0;
    const double from = part[0], width = part[1] - part[0];
    *most = fmax(*most, force_at(s, from, z, before));
    for (int k = 1; k <= steps; ++k) {
        double force[3], off = 0.0;
        *most = fmax(*most, force_at(s, from + width * k / steps, z, force));
        for (int r = 0; r < 3; ++r) {
            off += (force[r] - before[r]) * (force[r] - before[r]);
            before[r] = force[r];
        }
        if (sqrt(off) <= change) continue;
        change = sqrt(off);
        part[0] = from + width * (k - 1) / steps, part[1] = from + width * k / steps;
    }
    return change;
}

/* Where the force changes most it has no jump: seen ever more closely, the change vanishes. */
static void borders(void **unused)
{
    (void)unused;
    static const mbsr_shape_kind kinds[] = {MBSR_SHAPE_SPHERE, MBSR_SHAPE_CAPSULE, MBSR_SHAPE_BOX};
    for (int k = 0; k < 3; ++k) {
        const double z = 0.2 - 0.045 * k;
        double height[2500], most = 0.0, change = 0.0, beyond[3];
        mbsr_shape shape[2] = {field_of(rough, 30, 25, 1.0, height), sample_shape(kinds[k], 0)};
        if (k > 0) shape[1].size[0] = 0.12, shape[1].size[1] = 0.1, shape[1].size[2] = 0.12;
        shape[1].rounding = k == 2 ? 0.05 : 0.0;
        scene s = scene_of(2, shape);
        for (int begin = 0; begin < 2; ++begin) {
            double part[2] = {begin ? 0.95 : 0.3, begin ? 1.15 : 0.5};
            change = largest_change(&s, 50, z, part, &most);
            for (int closer = 0; closer < 5; ++closer)
                change = largest_change(&s, 10, z, part, &most);
            assert_true(change < 1e-4 * most);
        }
        assert_true(most > 10.0);
        assert_true(force_at(&s, 1.4, z, beyond) == 0.0);
        end_scene(&s);
    }
}

/* Far away, and at numbers that overflow, there is a status or nothing that is not finite. */
static void extremes(void **unused)
{
    (void)unused;
    static const double extreme[] = {1e3, -1e6, 1e100, -1e160, 1e200, 1e300};
    double height[2500];
    for (int kind = MBSR_SHAPE_BOX; kind <= MBSR_SHAPE_MESH; ++kind) {
        if (kind == MBSR_SHAPE_PLANE) continue;
        const mbsr_shape shape[2] = {field_of(rough, SAMPLES, SAMPLES, 1.0, height),
                                     sample_shape((mbsr_shape_kind)kind, 0)};
        scene s = scene_of(2, shape);
        for (int k = 0; k < 18; ++k) {
            double q[7] = {1, 0, 0, 0, 0.1, 0.2, 0.1}, u[6] = {0};
            mbsr_contact_point point[64];
            int count = 0;
            q[4 + k % 3] = extreme[k / 3];
            int status = mbsr_stage_positions(s.model, s.data, 0.0, q);
            if (!status) status = mbsr_stage_velocities(s.model, s.data, u);
            if (!status) status = mbsr_contact_report(s.model, s.data, s.force, 64, point, &count);
            for (int p = 0; p < count && p < 64 && !status; ++p)
                assert_true(isfinite(point[p].depth + point[p].normal_force));
        }
        end_scene(&s);
    }
}

/* A hill under the middle of a box that is held by no corner, and of a capsule. */
static void sticks_out(void **unused)
{
    (void)unused;
    double height[25] = {0.0};
    height[12] = 0.2;
    for (int k = 0; k < 2; ++k) {
        mbsr_shape shape[2] = {sample_shape(MBSR_SHAPE_HEIGHTS, MBSR_GROUND),
                               sample_shape(k ? MBSR_SHAPE_CAPSULE : MBSR_SHAPE_BOX, 0)};
        shape[0].size[0] = shape[0].size[1] = 1.0;
        shape[0].rows = shape[0].columns = 5;
        shape[0].height = height;
        if (k) shape[1].frame = mbsr_frame_along(NULL, (double[]){1.0, 0.0, 0.0});
        scene s = scene_of(2, shape);
        const double q[7] = {1, 0, 0, 0, 0, 0, 0.25 - 0.05 * k}, u[6] = {0};
        mbsr_contact_point point[8];
        assert_int_equal(points_at(&s, q, u, 8, point), 1);
        assert_close(fabs(point->normal[2]), 1.0, 1e-12);
        assert_true(point->depth > 0.01 && point->depth < 0.06);
        end_scene(&s);
    }
}

/* ---- refusals ---- */

static void refuse(mbsr_shape shape, int status, const char *what)
{
    mbsr_contacts *c = NULL;
    mbsr_error error;
    shape.name = "hills";
    assert_int_equal(mbsr_contacts_create(&c, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_add(c, &shape, NULL, &error), status);
    assert_non_null(strstr(error.text, "'hills'"));
    if (!strstr(error.text, what)) fail_msg("%s", error.text);
    mbsr_contacts_destroy(c);
}

static void refusals(void **unused)
{
    (void)unused;
    double height[2500];
    const mbsr_shape good = field_of(bowl, SAMPLES, SAMPLES, 1.0, height);
    mbsr_shape s = good;
    s.rows = 1;
    refuse(s, MBSR_ERR_VALUE, "rows is 1");
    s = good, s.columns = 9000;
    refuse(s, MBSR_ERR_VALUE, "columns is 9000");
    s = good, s.size[1] = 0.0;
    refuse(s, MBSR_ERR_VALUE, "size[1] is 0");
    s = good, s.height = NULL;
    refuse(s, MBSR_ERR_NULL, "height is NULL");
    s = good, s.body = 3;
    refuse(s, MBSR_ERR_VALUE, "a height field on body 3");
    height[7] = NAN;
    refuse(good, MBSR_ERR_VALUE, "height[7] is nan");
    height[7] = -INFINITY;
    refuse(good, MBSR_ERR_VALUE, "height[7] is -inf");
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(planes),      cmocka_unit_test(margins),
                                       cmocka_unit_test(paraboloids), cmocka_unit_test(nearest),
                                       cmocka_unit_test(borders),     cmocka_unit_test(sticks_out),
                                       cmocka_unit_test(extremes),    cmocka_unit_test(refusals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

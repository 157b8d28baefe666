/* Ellipsoids and cylinders against all shapes: beside spheres, beside supports along many
 * directions, and at rest.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "shapes.h"

static const double still[12] = {0};

static void draw_turn(uint64_t *seed, double q[4])
{
    double length = 0.0;
    for (int k = 0; k < 4; ++k) q[k] = draw(seed), length += q[k] * q[k];
    for (int k = 0; k < 4; ++k) q[k] /= sqrt(length);
}

static double deepest(int count, const mbsr_contact_point *point)
{
    double most = 0.0;
    for (int k = 0; k < count; ++k) most = fmax(most, point[k].depth);
    return most;
}

/* The second body comes along a direction until they touch by the depth. */
static int come(scene *s, double q[14], const double from[3], double depth,
                mbsr_contact_point *point)
{
    double near = 0.0, far = 2.0 / sqrt(from[0] * from[0] + from[1] * from[1] + from[2] * from[2]);
    for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (near + far);
        for (int l = 0; l < 3; ++l) q[11 + l] = middle * from[l];
        if (deepest(points_at(s, q, still, 128, point), point) > depth)
            near = middle;
        else
            far = middle;
    }
    for (int l = 0; l < 3; ++l) q[11 + l] = near * from[l];
    return points_at(s, q, still, 128, point);
}

/* An ellipsoid with three equal axes is a sphere. */
static void as_spheres(void **unused)
{
    (void)unused;
    uint64_t seed = 3;
    for (int kind = MBSR_SHAPE_BOX; kind <= MBSR_SHAPE_MESH; ++kind) {
        if (kind == MBSR_SHAPE_PLANE) continue;
        mbsr_shape shapes[2] = {sample_shape((mbsr_shape_kind)kind, 0),
                                sample_shape(MBSR_SHAPE_ELLIPSOID, 0)};
        shapes[1].size[1] = shapes[1].size[2] = shapes[1].size[0];
        scene round = scene_of(2, shapes);
        shapes[1].kind = MBSR_SHAPE_SPHERE;
        scene sphere = scene_of(2, shapes);
        for (int k = 0; k < 100; ++k) {
            double q[14] = {0};
            const double from[3] = {draw(&seed), draw(&seed), 0.3 + draw(&seed)};
            mbsr_contact_point a[128], b[128];
            draw_turn(&seed, q);
            draw_turn(&seed, q + 7);
            assert_int_equal(come(&round, q, from, 0.004, a), 1);
            assert_int_equal(points_at(&sphere, q, still, 128, b), 1);
            /* a prism stands for a cylinder */
            const double off = kind == MBSR_SHAPE_CYLINDER ? 0.9e-3 : 1e-12;
            assert_true(fabs(a[0].depth - b[0].depth) < off);
            for (int l = 0; l < 3 && kind != MBSR_SHAPE_CYLINDER; ++l) {
                assert_true(fabs(a[0].normal[l] - b[0].normal[l]) < 1e-9);
                assert_true(fabs(a[0].point[l] - b[0].point[l]) < 1e-9);
            }
        }
        end_scene(&round);
        end_scene(&sphere);
    }
}

/* How far a shape reaches along n, turned by q. */
static double reach(const mbsr_shape *s, const double q[4], const double n[3])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double R[9] = {1 - 2 * (y * y + z * z), 2 * (x * y + w * z),     2 * (x * z - w * y),
                         2 * (x * y - w * z),     1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
                         2 * (x * z + w * y),     2 * (y * z - w * x),     1 - 2 * (x * x + y * y)};
    double m[3], sum = 0.0;
    for (int k = 0; k < 3; ++k) m[k] = R[3 * k] * n[0] + R[3 * k + 1] * n[1] + R[3 * k + 2] * n[2];
    switch (s->kind) {
    case MBSR_SHAPE_SPHERE: return s->size[0];
    case MBSR_SHAPE_CAPSULE: return s->size[0] + s->size[1] * fabs(m[2]);
    case MBSR_SHAPE_ELLIPSOID:
        for (int k = 0; k < 3; ++k) sum += s->size[k] * s->size[k] * m[k] * m[k];
        return sqrt(sum);
    case MBSR_SHAPE_BOX:
        for (int k = 0; k < 3; ++k) sum += (s->size[k] - 0.0075) * fabs(m[k]);
        return sum + 0.0075; /* 0.15 / 20 */
    default:
        sum = -INFINITY;
        for (int k = 0; k < 6; ++k)
            sum = fmax(sum, octahedron[3 * k] * m[0] + octahedron[3 * k + 1] * m[1] +
                                octahedron[3 * k + 2] * m[2]);
        return sum + 0.3 / 50.0;
    }
}

/* The distance between planes of support is the negative depth along the normal, and no larger
 * along any other direction. */
static void least_depth(void **unused)
{
    (void)unused;
    static const mbsr_shape_kind kinds[] = {MBSR_SHAPE_SPHERE, MBSR_SHAPE_CAPSULE, MBSR_SHAPE_BOX,
                                            MBSR_SHAPE_MESH, MBSR_SHAPE_ELLIPSOID};
    uint64_t seed = 11;
    for (int kind = 0; kind < 5; ++kind) {
        mbsr_shape shapes[2] = {sample_shape(kinds[kind], 0),
                                sample_shape(MBSR_SHAPE_ELLIPSOID, 0)};
        scene s = scene_of(2, shapes);
        for (int k = 0; k < 200; ++k) {
            double q[14] = {0};
            const double from[3] = {draw(&seed), draw(&seed), 0.3 + draw(&seed)};
            mbsr_contact_point point[128];
            draw_turn(&seed, q);
            draw_turn(&seed, q + 7);
            assert_int_equal(come(&s, q, from, 0.004, point), 1);
            for (int l = 0; l < 500; ++l) {
                const double width = l == 0 ? 0.0 : pow(10.0, 2.0 * draw(&seed) - 2.0);
                double n[3], length = 0.0, apart = 0.0;
                for (int i = 0; i < 3; ++i) {
                    n[i] = point[0].normal[i] + width * draw(&seed);
                    length += n[i] * n[i];
                }
                for (int i = 0; i < 3; ++i) {
                    n[i] /= sqrt(length);
                    apart += n[i] * (q[4 + i] - q[11 + i]);
                }
                const double back[3] = {-n[0], -n[1], -n[2]};
                apart -= reach(&shapes[0], q, back) + reach(&shapes[1], q + 7, n);
                if (l == 0)
                    assert_true(fabs(apart + point[0].depth) < 1e-12);
                else
                    assert_true(apart <= -point[0].depth + 1e-12);
            }
        }
        end_scene(&s);
    }
}

/* On the top of a large box, pressed in by 1 mm. */
static void at_rest(void **unused)
{
    (void)unused;
    const double half = sqrt(0.5);
    mbsr_contact_point point[128];
    mbsr_shape shapes[2] = {sample_shape(MBSR_SHAPE_BOX, MBSR_GROUND),
                            sample_shape(MBSR_SHAPE_CYLINDER, 0)};
    shapes[0].size[0] = shapes[0].size[1] = shapes[0].size[2] = 1.0;
    shapes[0].frame.x[2] = -1.0;
    scene s = scene_of(2, shapes);
    const double standing[7] = {1, 0, 0, 0, 0.1, 0.2, 0.249};
    assert_int_equal(points_at(&s, standing, still, 128, point), 24);
    for (int k = 0; k < 24; ++k) {
        assert_close(point[k].depth, 1e-3, 1e-12);
        assert_close(point[k].normal[2], -1.0, 1e-12); /* on the box, which is first */
    }
    const double lying[7] = {half, half, 0, 0, 0.1, 0.2, 0.199};
    assert_true(points_at(&s, lying, still, 128, point) >= 2);
    assert_true(fabs(deepest(2, point) - 1e-3) < 0.9e-3);
    end_scene(&s);
    shapes[1].kind = MBSR_SHAPE_ELLIPSOID;
    s = scene_of(2, shapes);
    const double on_end[7] = {half, half, 0, 0, 0.1, 0.2, 0.249};
    assert_int_equal(points_at(&s, on_end, still, 128, point), 1);
    assert_close(point[0].depth, 1e-3, 1e-12);
    assert_close(point[0].point[0], 0.1, 1e-12);
    assert_close(point[0].point[2], -0.5e-3, 1e-12);
    end_scene(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(as_spheres), cmocka_unit_test(least_depth),
                                       cmocka_unit_test(at_rest)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Inertias of solids against integrals over their slices, of rods and turned tensors against mass
 * points.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "space.h"

#include <string.h>

static const double node[3] = {-0.774596669241483377, 0.0, 0.774596669241483377},
                    weight[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};

static void assert_same_inertia(const mbsr_inertia *a, const mbsr_inertia *b)
{
    assert_int_equal(a->kind, MBSR_INERTIA_SPATIAL);
    assert_int_equal(b->kind, MBSR_INERTIA_SPATIAL);
    assert_close(a->mass, b->mass, 1e-13 * b->mass);
    for (int k = 0; k < 3; ++k) assert_close(a->com[k], b->com[k], 1e-13);
    const double size = test_largest(6, b->tensor);
    for (int k = 0; k < 6; ++k) assert_close(a->tensor[k], b->tensor[k], 1e-13 * size);
}

/* Square of a body's radius at the height z. */
typedef double (*profile)(double radius, double half, double z);

static double straight(double radius, double half, double z)
{
    (void)half, (void)z;
    return radius * radius;
}

static double rounded(double radius, double half, double z)
{
    const double beyond = fabs(z) - half;
    return radius * radius - (beyond > 0.0 ? beyond * beyond : 0.0);
}

/* Adds discs between two heights, by Gauss's rule: exact, as the moments are polynomials of degree
 * 4 there. A disc of mass m has m r^2 / 2 about its axis, half of that across. */
static void add_discs(double density, profile square, double radius, double half, double low,
                      double high, mbsr_inertia *sum)
{
    const double pi = acos(-1.0);
    for (int k = 0; k < 3; ++k) {
        const double z = 0.5 * (low + high) + 0.5 * (high - low) * node[k],
                     r2 = square(radius, half, z),
                     mass = density * pi * r2 * weight[k] * 0.5 * (high - low);
        sum->mass += mass;
        sum->tensor[MBSR_XX] += mass * (0.25 * r2 + z * z);
        sum->tensor[MBSR_YY] += mass * (0.25 * r2 + z * z);
        sum->tensor[MBSR_ZZ] += mass * 0.5 * r2;
    }
}

static void round_solids_are_the_sum_of_their_discs(void **unused)
{
    (void)unused;
    const double density = 700.0, r = 0.3, length = 0.8;
    mbsr_inertia sphere = {.kind = MBSR_INERTIA_SPATIAL}, cylinder = sphere, capsule = sphere;
    add_discs(density, rounded, r, 0.0, -r, 0.0, &sphere);
    add_discs(density, rounded, r, 0.0, 0.0, r, &sphere);
    add_discs(density, straight, r, 0.5 * length, -0.5 * length, 0.5 * length, &cylinder);
    add_discs(density, rounded, r, 0.5 * length, -0.5 * length - r, -0.5 * length, &capsule);
    add_discs(density, rounded, r, 0.5 * length, -0.5 * length, 0.5 * length, &capsule);
    add_discs(density, rounded, r, 0.5 * length, 0.5 * length, 0.5 * length + r, &capsule);
    const mbsr_inertia made[] = {
        mbsr_inertia_sphere(density, r), mbsr_inertia_cylinder(density, r, length),
        mbsr_inertia_capsule(density, r, length), mbsr_inertia_capsule(density, r, 0.0)};
    assert_same_inertia(made, &sphere);
    assert_same_inertia(made + 1, &cylinder);
    assert_same_inertia(made + 2, &capsule);
    assert_same_inertia(made + 3, &sphere);
}

/* Gauss's points, which are exact for moments of second order. */
static void boxes_and_rods_are_the_sum_of_points(void **unused)
{
    (void)unused;
    const double density = 300.0, edges[3] = {0.3, 0.5, 0.7}, a[3] = {0.2, -0.4, 0.1},
                 b[3] = {0.9, 0.3, -0.5};
    mbsr_inertia box = mbsr_inertia_zero(), rod = mbsr_inertia_zero();
    for (int k = 0; k < 27; ++k) {
        const int at[3] = {k % 3, k / 3 % 3, k / 9};
        double x[3], mass = density;
        for (int c = 0; c < 3; ++c) {
            x[c] = 0.5 * edges[c] * node[at[c]];
            mass *= 0.5 * edges[c] * weight[at[c]];
        }
        box = mbsr_inertia_sum(box, mbsr_inertia_point_mass(mass, x));
    }
    for (int k = 0; k < 3; ++k) {
        double x[3];
        for (int c = 0; c < 3; ++c) x[c] = 0.5 * (a[c] + b[c]) + 0.5 * (b[c] - a[c]) * node[k];
        rod = mbsr_inertia_sum(rod, mbsr_inertia_point_mass(2.0 * 0.5 * weight[k], x));
    }
    const mbsr_inertia made[] = {mbsr_inertia_box(density, edges), mbsr_inertia_rod(2.0, a, b)};
    assert_same_inertia(made, &box);
    assert_same_inertia(made + 1, &rod);
}

/* Points in a frame: their tensor about its origin and along its axes, and their places in the
 * body. */
static void a_tensor_may_be_given_about_any_point_and_axes(void **unused)
{
    (void)unused;
    test_rng rng = test_seed(4);
    const mbsr_frame frame = test_frame(&rng, 0.5);
    mbsr_inertia whole = mbsr_inertia_zero(), inside = mbsr_inertia_zero();
    double tensor[6] = {0.0};
    for (int k = 0; k < 4; ++k) {
        const double mass = 1.5 + test_uniform(&rng);
        double x[3], there[3];
        test_fill(&rng, 3, x);
        for (int c = 0; c < 3; ++c) {
            there[c] = frame.x[c];
            for (int l = 0; l < 3; ++l) there[c] += frame.R[3 * l + c] * x[l];
            tensor[c] += mass * (x[(c + 1) % 3] * x[(c + 1) % 3] + x[(c + 2) % 3] * x[(c + 2) % 3]);
        }
        tensor[MBSR_XY] -= mass * x[0] * x[1];
        tensor[MBSR_XZ] -= mass * x[0] * x[2];
        tensor[MBSR_YZ] -= mass * x[1] * x[2];
        whole = mbsr_inertia_sum(whole, mbsr_inertia_point_mass(mass, there));
        inside = mbsr_inertia_sum(inside, mbsr_inertia_point_mass(mass, x));
    }
    const mbsr_inertia about = mbsr_inertia_rigid_about(whole.mass, whole.com, &frame, tensor),
                       moved = mbsr_inertia_in_frame(&frame, inside);
    assert_same_inertia(&about, &whole);
    assert_same_inertia(&moved, &whole);
}

static void what_is_no_solid_is_marked(void **unused)
{
    (void)unused;
    const double edges[3] = {0.1, -0.1, 0.1}, none[6] = {0.0}, com[3] = {0.0};
    mbsr_frame no_frame;
    memset(&no_frame, 0, sizeof no_frame);
    const mbsr_inertia planar = mbsr_inertia_planar(1.0, com, 0.1),
                       point = mbsr_inertia_particle(1.0);
    const mbsr_frame at = mbsr_frame_at(1.0, 0.0, 0.0);
    const mbsr_inertia wrong[] = {mbsr_inertia_box(1.0, edges),
                                  mbsr_inertia_sphere(1.0, -0.1),
                                  mbsr_inertia_cylinder(1.0, -0.1, 1.0),
                                  mbsr_inertia_cylinder(1.0, 0.1, -1.0),
                                  mbsr_inertia_capsule(1.0, -0.1, 1.0),
                                  mbsr_inertia_capsule(1.0, 0.1, -1.0),
                                  mbsr_inertia_rigid_about(1.0, com, &no_frame, none),
                                  mbsr_inertia_in_frame(&no_frame, point),
                                  mbsr_inertia_in_frame(&at, planar),
                                  mbsr_inertia_sum(planar, point),
                                  mbsr_inertia_sum(point, planar)};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k)
        assert_int_equal(wrong[k].kind, MBSR_INERTIA_INVALID);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_solids_are_the_sum_of_their_discs),
        cmocka_unit_test(boxes_and_rods_are_the_sum_of_points),
        cmocka_unit_test(a_tensor_may_be_given_about_any_point_and_axes),
        cmocka_unit_test(what_is_no_solid_is_marked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

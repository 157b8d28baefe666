/* Frames and rotations: against the series of the exponential, there and back.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "algebra/frames.h"
#include "space.h"
#include "transform.h"

#include <string.h>

static void assert_frame(const mbsr_frame *f, const transform *T, double tolerance)
{
    double p[MBSR_POSE_SIZE];
    transform_pose(T, p);
    for (int k = 0; k < 9; ++k) assert_close(f->R[k], p[k], tolerance);
    for (int k = 0; k < 3; ++k) assert_close(f->x[k], p[MBSR_POSE_X + k], tolerance);
}

static void constructors_agree_with_the_exponential(void **state)
{
    (void)state;
    test_rng rng = test_seed(31);
    const double none[3] = {0, 0, 0};
    for (int l = 0; l < 200; ++l) {
        double x[3], axis[3], w[3], q[4];
        test_fill(&rng, 3, x);
        test_fill(&rng, 3, axis);
        test_fill(&rng, 4, q);
        const double angle = 7.0 * test_uniform(&rng);
        const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
        for (int k = 0; k < 3; ++k) w[k] = angle * axis[k] / length;
        transform T = transform_exp(w, none);
        for (int k = 0; k < 3; ++k) T.m[k][3] = x[k];
        const mbsr_frame turned = mbsr_frame_rotated(x, axis, angle);
        assert_frame(&turned, &T, 1e-14);

        T = transform_quaternion(q);
        const mbsr_frame by_quaternion = mbsr_frame_quaternion(NULL, q);
        assert_frame(&by_quaternion, &T, 1e-14);

        T = transform_unit();
        for (int k = 0; k < 3; ++k) T.m[k][3] = x[k];
        const mbsr_frame at = mbsr_frame_at(x[0], x[1], x[2]);
        assert_frame(&at, &T, 0.0);

        const mbsr_frame along = mbsr_frame_along(x, axis);
        assert_less(mbsri_frame_defect(along.R), 1e-15);
        for (int k = 0; k < 3; ++k) {
            assert_close(along.R[6 + k], axis[k] / length, 1e-15);
            assert_close(along.x[k], x[k], 0.0);
        }
    }
    const transform unit = transform_unit();
    const mbsr_frame identity = mbsr_frame_identity();
    assert_frame(&identity, &unit, 0.0);
}

/* The z axis along a coordinate axis, in either sense, and with zeros and ties among its
 * components. */
static void a_frame_along_any_axis_is_right_handed(void **state)
{
    (void)state;
    for (int code = 0; code < 27; ++code) {
        const double z[3] = {code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1};
        const mbsr_frame f = mbsr_frame_along(NULL, z);
        if (code == 13) {
            for (int k = 0; k < 9; ++k) assert_close(f.R[k], 0.0, 0.0);
            continue;
        }
        assert_less(mbsri_frame_defect(f.R), 1e-15);
        double along = 0.0;
        for (int k = 0; k < 3; ++k) along += f.R[6 + k] * z[k];
        assert_close(along, sqrt(z[0] * z[0] + z[1] * z[1] + z[2] * z[2]), 1e-15);
    }
}

static void directions_without_length_make_no_frame(void **state)
{
    (void)state;
    const double zero[3] = {0, 0, 0}, bad[3] = {0, NAN, 1}, huge[3] = {INFINITY, 0, 0},
                 none[4] = {0, 0, 0, 0};
    const double *const list[] = {zero, bad, huge};
    for (int k = 0; k < 3; ++k) {
        const mbsr_frame a = mbsr_frame_rotated(NULL, list[k], 0.3),
                         b = mbsr_frame_along(NULL, list[k]);
        assert_true(isinf(mbsri_frame_defect(a.R)) && isinf(mbsri_frame_defect(b.R)));
    }
    const mbsr_frame c = mbsr_frame_quaternion(NULL, none);
    assert_true(isinf(mbsri_frame_defect(c.R)));
}

static void lengths_do_not_matter(void **state)
{
    (void)state;
    static const double lengths[] = {1e-300, 1e-160, 1e160, 1e300};
    test_rng rng = test_seed(32);
    double axis[3], q[4], long_axis[3], long_q[4];
    test_fill(&rng, 3, axis);
    test_fill(&rng, 4, q);
    const mbsr_frame a = mbsr_frame_rotated(NULL, axis, 0.7), b = mbsr_frame_along(NULL, axis),
                     c = mbsr_frame_quaternion(NULL, q);
    for (int l = 0; l < 4; ++l) {
        for (int k = 0; k < 3; ++k) long_axis[k] = lengths[l] * axis[k];
        for (int k = 0; k < 4; ++k) long_q[k] = lengths[l] * q[k];
        const mbsr_frame x = mbsr_frame_rotated(NULL, long_axis, 0.7),
                         y = mbsr_frame_along(NULL, long_axis),
                         z = mbsr_frame_quaternion(NULL, long_q);
        for (int k = 0; k < 9; ++k) {
            assert_close(x.R[k], a.R[k], 1e-15);
            assert_close(y.R[k], b.R[k], 1e-15);
            assert_close(z.R[k], c.R[k], 1e-15);
        }
    }
}

static void products_and_inverses_compose(void **state)
{
    (void)state;
    test_rng rng = test_seed(33);
    for (int l = 0; l < 100; ++l) {
        const mbsr_frame a = test_frame(&rng, 2.0), b = test_frame(&rng, 2.0);
        const transform Ta = transform_of(a.R, a.x), Tb = transform_of(b.R, b.x);
        const transform ab = transform_product(Ta, Tb), back = transform_inverse(Ta);
        const mbsr_frame product = mbsr_frame_product(&a, &b), inverse = mbsr_frame_inverse(&a);
        assert_frame(&product, &ab, 1e-14);
        assert_frame(&inverse, &back, 1e-14);
        const transform unit = transform_unit();
        const mbsr_frame one = mbsr_frame_product(&inverse, &a),
                         other = mbsr_frame_product(&a, &inverse);
        assert_frame(&one, &unit, 1e-14);
        assert_frame(&other, &unit, 1e-14);
    }
}

/* Each component largest in turn (the four branches), both signs, also where the others vanish or
 * nearly do. */
static void rotations_and_quaternions_convert_there_and_back(void **state)
{
    (void)state;
    static const double sizes[] = {1.0, 1e-1, 1e-5, 1e-9, 0.0};
    test_rng rng = test_seed(34);
    for (int largest = 0; largest < 4; ++largest) {
        for (int s = 0; s < 5; ++s) {
            for (int l = 0; l < 40; ++l) {
                double q[4], R[9], back[4], length = 0.0;
                test_fill(&rng, 4, q);
                for (int k = 0; k < 4; ++k) q[k] *= sizes[s];
                q[largest] = l % 2 ? 1.5 : -1.5;
                for (int k = 0; k < 4; ++k) length += q[k] * q[k];
                mbsr_quaternion_rotation(q, R);
                mbsr_rotation_quaternion(R, back);
                /* w >= 0 chooses the sign; where w is zero either will do */
                double sign = q[0] < 0.0 ? -1.0 : 1.0;
                if (fabs(q[0]) < 1e-14) sign = back[largest] * q[largest] < 0.0 ? -1.0 : 1.0;
                for (int k = 0; k < 4; ++k)
                    assert_close(back[k], sign * q[k] / sqrt(length), 4e-16);
                assert_true(back[0] >= 0.0);
            }
        }
    }
}

static void defects_of_frames_are_measured(void **state)
{
    (void)state;
    test_rng rng = test_seed(35);
    mbsr_frame f = test_frame(&rng, 1.0), g = f;
    assert_less(mbsri_frame_defect(f.R), 1e-15);
    for (int k = 0; k < 3; ++k) g.R[k] *= 1.0 + 1e-4; /* column 0 longer */
    assert_close(mbsri_frame_defect(g.R), 2e-4, 1e-7);
    for (int k = 0; k < 3; ++k) g.R[k] = f.R[k] + 1e-4 * f.R[3 + k]; /* and leaning */
    assert_close(mbsri_frame_defect(g.R), 1e-4, 1e-7);
    for (int k = 0; k < 3; ++k) g.R[k] = -f.R[k];
    assert_true(isinf(mbsri_frame_defect(g.R)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constructors_agree_with_the_exponential),
        cmocka_unit_test(a_frame_along_any_axis_is_right_handed),
        cmocka_unit_test(directions_without_length_make_no_frame),
        cmocka_unit_test(lengths_do_not_matter),
        cmocka_unit_test(products_and_inverses_compose),
        cmocka_unit_test(rotations_and_quaternions_convert_there_and_back),
        cmocka_unit_test(defects_of_frames_are_measured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

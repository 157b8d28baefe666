/* Derivatives of contact forces, and their balance of power, for all pairs of shapes.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "shapes.h"

#include "newton/slopes/force_slopes.h"
#include "recursion/elements.h"

#include <stdlib.h>

/* Quaternions and positions of two free bodies, and velocities. */
typedef struct state {
    double q[14], u[12];
} state;

static void draw_state(uint64_t *seed, int bodies, state *s)
{
    for (int b = 0; b < bodies; ++b) {
        double *q = s->q + 7 * b, length = 0.0;
        for (int k = 0; k < 4; ++k) q[k] = draw(seed), length += q[k] * q[k];
        for (int k = 0; k < 4; ++k) q[k] /= sqrt(length);
        for (int k = 0; k < 3; ++k) q[4 + k] = 0.2 * draw(seed);
    }
    for (int k = 0; k < 12; ++k) s->u[k] = draw(seed);
}

/* Moves body 0 along a direction until it touches by about that depth. */
static int approach(scene *s, state *at, const double away[3], double depth)
{
    double near = 0.0, far = 2.0 / sqrt(away[0] * away[0] + away[1] * away[1] + away[2] * away[2]);
    const double from[3] = {at->q[4], at->q[5], at->q[6]};
    mbsr_contact_point point[64];
    int count = 0;
    for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (near + far);
        for (int l = 0; l < 3; ++l) at->q[4 + l] = from[l] + middle * away[l];
        count = points_at(s, at->q, at->u, 64, point);
        double most = 0.0;
        for (int l = 0; l < count; ++l) most = fmax(most, point[l].depth);
        if (most > depth)
            near = middle;
        else
            far = middle;
    }
    return points_at(s, at->q, at->u, 64, point);
}

static double energy_at(scene *s, const state *at, double h)
{
    state moved = *at;
    double kinetic, potential, rate[14];
    assert_int_equal(mbsr_stage_positions(s->model, s->data, 0.0, at->q), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(s->model, s->data, at->u), MBSR_OK);
    assert_int_equal(mbsr_coordinate_rates(s->model, s->data, rate), MBSR_OK);
    for (int k = 0; k < 7 * s->bodies; ++k) moved.q[k] += h * rate[k];
    assert_int_equal(mbsr_stage_positions(s->model, s->data, 0.0, moved.q), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(s->model, s->data, at->u), MBSR_OK);
    assert_int_equal(mbsr_energy(s->model, s->data, &kinetic, &potential), MBSR_OK);
    return potential;
}

/* Power of the forces, heat and the rate of the energy. */
static void check_power(scene *s, const state *at)
{
    const double h = 1e-6, rate = (energy_at(s, at, h) - energy_at(s, at, -h)) / (2.0 * h);
    double heat, power = 0.0, size = 0.0, f[6];
    (void)energy_at(s, at, 0.0);
    assert_int_equal(mbsr_dissipation(s->model, s->data, &heat), MBSR_OK);
    for (int b = 0; b < s->bodies; ++b) {
        const double *V = at->u + 6 * b;       /* the twist, of a free body */
        const int place = b + (s->bodies < 2); /* the ground stands before bodies */
        assert_int_equal(mbsr_force_load(s->model, s->data, s->force, place, f, NULL), MBSR_OK);
        for (int k = 0; k < 6; ++k) power += f[k] * V[k], size += fabs(f[k] * V[k]);
    }
    assert_true(heat >= -1e-9 * size);
    assert_close(power + heat + rate, 0.0, 2e-6 * (size + fabs(rate) + heat));
}

/* ---- differences ---- */

/* Rotates about an axis of the world by a small angle. */
static void rotate(double q[4], int axis, double angle)
{
    double by[4] = {cos(0.5 * angle), 0, 0, 0}, p[4];
    by[1 + axis] = sin(0.5 * angle);
    p[0] = by[0] * q[0] - by[1] * q[1] - by[2] * q[2] - by[3] * q[3];
    p[1] = by[0] * q[1] + by[1] * q[0] + by[2] * q[3] - by[3] * q[2];
    p[2] = by[0] * q[2] - by[1] * q[3] + by[2] * q[0] + by[3] * q[1];
    p[3] = by[0] * q[3] + by[1] * q[2] - by[2] * q[1] + by[3] * q[0];
    memcpy(q, p, sizeof p);
}

static void loads(scene *s, const state *at, double f[12])
{
    assert_int_equal(mbsr_stage_positions(s->model, s->data, 0.0, at->q), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(s->model, s->data, at->u), MBSR_OK);
    for (int b = 0; b < s->bodies; ++b) {
        const int place = b + (s->bodies < 2); /* the ground stands before bodies */
        assert_int_equal(mbsr_force_load(s->model, s->data, s->force, place, f + 6 * b, NULL),
                         MBSR_OK);
    }
}

/* The largest error of the derivatives, relative to the largest of those by poses or rates; their
 * steps of 1e-8 m, rad, m/s and rad/s reach no change of features. */
static double slopes_off(scene *s, const state *at)
{
    const double h = 1e-8;
    double off[2] = {0, 0}, size[2] = {0, 0};
    size_t doubles, ints;
    mbsri_slopes_size(s->model, MBSRI_SLOPES_WHOLE, &doubles, &ints);
    double *memory = calloc(doubles, sizeof *memory);
    int *integers = calloc(ints, sizeof *integers);
    assert_true(memory && integers);
    mbsri_slopes own;
    mbsri_slopes_place(s->model, MBSRI_SLOPES_WHOLE, &own, memory, integers);
    double none[12];
    loads(s, at, none);
    assert_int_equal(mbsri_force_slopes(s->model, s->data,
                                        mbsri_find_force(s->model, s->data, s->force, "slopes"), 0,
                                        &own),
                     MBSR_OK);
    for (int c = 0; c < 12 * s->bodies; ++c) {
        const int body = c / 12, r = c % 12, pose = r < 6;
        const int place = body + (s->bodies < 2);
        double f[2][12];
        for (int k = 0; k < 2; ++k) {
            state moved = *at;
            const double by = k ? h : -h;
            if (r < 3)
                rotate(moved.q + 7 * body, r, by);
            else if (pose)
                moved.q[7 * body + 4 + r - 3] += by;
            else
                moved.u[6 * body + r - 6] += by;
            loads(s, &moved, f[k]);
        }
        for (int l = 0; l < 6 * s->bodies; ++l) {
            const int row = own.row[l / 6 + (s->bodies < 2)] + l % 6,
                      column = own.column[place] + r;
            const double value = own.matrix[(ptrdiff_t)column * own.out.rows + row];
            size[pose] = fmax(size[pose], fabs(value));
            off[pose] = fmax(off[pose], fabs(value - (f[1][l] - f[0][l]) / (2.0 * h)));
        }
    }
    free(memory);
    free(integers);
    return fmax(off[0] / size[0], off[1] / size[1]);
}

static void slopes(void **unused)
{
    (void)unused;
    uint64_t seed = 7;
    double worst = 0.0;
    int tried = 0;
    for (int a = MBSR_SHAPE_BOX; a <= MBSR_SHAPE_MESH; ++a) {
        for (int b = MBSR_SHAPE_BOX; b <= MBSR_SHAPE_MESH; ++b) {
            mbsr_shape shape[2] = {sample_shape((mbsr_shape_kind)a, 0),
                                   sample_shape((mbsr_shape_kind)b, 0)};
            shape[0].law.margin = 0.01 * (b % 2);
            if (b == MBSR_SHAPE_PLANE) continue;
            if (a == MBSR_SHAPE_PLANE) shape[0].body = MBSR_GROUND;
            for (int k = 0; k < 6; ++k) {
                const double shift = 0.05 * draw(&seed);
                if (a != MBSR_SHAPE_PLANE || k % 2) shape[k % 2].frame.x[k / 2] = shift;
            }
            scene s = scene_of(2, shape);
            for (int k = 0; k < 12; ++k) {
                state at;
                double away[3] = {draw(&seed), draw(&seed), 0.5 + draw(&seed)};
                draw_state(&seed, 2, &at);
                if (a == MBSR_SHAPE_PLANE) away[0] = away[1] = 0.0, away[2] = 1.0;
                if (approach(&s, &at, away, 0.004) == 0) continue;
                const double off = slopes_off(&s, &at);
                if (off > 1e-6) print_message("kinds %d %d, state %d: %g\n", a, b, k, off);
                worst = fmax(worst, off);
                ++tried;
                /* weights of edges have no energy of their own */
                const int plain = a == MBSR_SHAPE_PLANE || a == MBSR_SHAPE_SPHERE ||
                                  a == MBSR_SHAPE_ELLIPSOID || b == MBSR_SHAPE_ELLIPSOID;
                if (plain) check_power(&s, &at);
            }
            end_scene(&s);
        }
    }
    print_message("%d states, largest error %g\n", tried, worst);
    assert_true(tried > 400);
    assert_true(worst < 1e-6);
}

/* A body on a rough field, its hollows narrower than some shapes. */
static void slopes_on_field(void **unused)
{
    (void)unused;
    enum { SIDE = 21 };
    uint64_t seed = 11;
    double worst = 0.0, height[SIDE * SIDE];
    int tried = 0;
    for (int k = 0; k < SIDE * SIDE; ++k) height[k] = 0.04 * draw(&seed);
    for (int kind = MBSR_SHAPE_BOX; kind <= MBSR_SHAPE_MESH; ++kind) {
        if (kind == MBSR_SHAPE_PLANE) continue;
        mbsr_shape shape[2] = {sample_shape(MBSR_SHAPE_HEIGHTS, MBSR_GROUND),
                               sample_shape((mbsr_shape_kind)kind, 0)};
        shape[0].size[0] = shape[0].size[1] = 1.0;
        shape[0].rows = shape[0].columns = SIDE;
        shape[0].height = height;
        shape[0].frame.x[0] = 0.03, shape[0].frame.x[2] = -0.1;
        scene s = scene_of(2, shape);
        uint64_t own = 4, *from = &seed;
        /* a capsule in a hollow that is hardly wider: where its weight is below one are few places
         */
        const int states = kind == MBSR_SHAPE_CAPSULE ? 48 : 12;
        for (int k = 0; k < states; ++k) {
            if (k == 12) from = &own;
            const double up[3] = {0.0, 0.0, 1.0};
            state at;
            draw_state(from, 1, &at);
            if (k == 0) at.q[4] = 1.09;
            if (approach(&s, &at, up, 0.004) == 0) continue;
            const double off = slopes_off(&s, &at);
            if (off > 1e-6) print_message("kind %d, state %d: %g\n", kind, k, off);
            worst = fmax(worst, off);
            ++tried;
        }
        end_scene(&s);
    }
    print_message("%d states on a field, largest error %g\n", tried, worst);
    assert_true(tried > 50);
    assert_true(worst < 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(slopes), cmocka_unit_test(slopes_on_field)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

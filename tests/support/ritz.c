/* Beams in closed form: see ritz.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * int (x/L)^p = density L / (p + 1) + tip and so on; slopes of y turn about z, of z about -y.
 * Bending along one direction by (x/L)^p and (x/L)^r shortens the beam by int_0^x p r (x/L)^(p + r
 * - 2) / L^2, so shortening is made of shapes (x/L)^(p + r - 1). */
#include "ritz.h"

#include "expect.h"

#include <string.h>

enum { SHAPES = TEST_RITZ_MODES + TEST_RITZ_SHORTENINGS };

typedef struct arrays {
    int shapes, dir[SHAPES], massless[SHAPES];
    double power[SHAPES];
    double Ct0[3 * SHAPES], P0[9 * SHAPES], P[9 * SHAPES * SHAPES];
    double Y[TEST_RITZ_MODES * TEST_RITZ_MODES * TEST_RITZ_SHORTENINGS];
    double Phi[TEST_RITZ_MARKERS][3 * SHAPES], Psi[TEST_RITZ_MARKERS][3 * SHAPES];
} arrays;

/* The shape along x of this power. */
static int shortening(const test_ritz *b, arrays *w, double power)
{
    int k = b->modes;
    while (k < w->shapes && w->power[k] != power) ++k;
    if (k == w->shapes) {
        assert_true(w->shapes < SHAPES);
        w->power[w->shapes++] = power;
    }
    return k;
}

static void list_shapes(const test_ritz *b, arrays *w)
{
    const int n = w->shapes = b->modes;
    for (int a = 0; a < n; ++a) {
        w->dir[a] = b->dir[a];
        w->massless[a] = b->massless[a];
        w->power[a] = b->power[a];
    }
    for (int a = 0; a < n * b->stiffening; ++a) {
        for (int c = 0; c < n; ++c) {
            if (b->dir[a] != b->dir[c] || b->massless[a] || b->massless[c]) continue;
            const double power = b->power[a] + b->power[c] - 1.0;
            const int k = shortening(b, w, power);
            w->Y[n * (n * (k - n) + a) + c] = -b->power[a] * b->power[c] / (power * b->length);
        }
    }
}

static void integrate(const test_ritz *b, arrays *w)
{
    const double L = b->length, share = b->density * L;
    const int n = w->shapes;
    for (int a = 0; a < n; ++a) {
        if (w->massless[a]) continue;
        w->Ct0[3 * a + w->dir[a]] = share / (w->power[a] + 1.0) + b->tip;
        w->P0[9 * a + 3 * w->dir[a]] = share * L / (w->power[a] + 2.0) + b->tip * L;
        for (int c = 0; c < n; ++c) {
            if (!w->massless[c])
                w->P[3 * n * (3 * c + w->dir[c]) + 3 * a + w->dir[a]] =
                    share / (w->power[a] + w->power[c] + 1.0) + b->tip;
        }
    }
}

static void place_markers(const test_ritz *b, arrays *w, mbsr_flex_marker *marker)
{
    for (int k = 0; k < b->markers; ++k) {
        const double x = b->at[k] / b->length;
        for (int a = 0; a < w->shapes; ++a) {
            const double slope = w->power[a] * pow(x, w->power[a] - 1.0) / b->length;
            w->Phi[k][3 * a + w->dir[a]] = pow(x, w->power[a]);
            if (w->dir[a] == 1) w->Psi[k][3 * a + 2] = slope;
            if (w->dir[a] == 2) w->Psi[k][3 * a + 1] = -slope;
        }
        marker[k] = (mbsr_flex_marker){.frame = b->turn[k], .Phi = w->Phi[k], .Psi = w->Psi[k]};
        if (b->turn[k].R[0] == 0.0) marker[k].frame = mbsr_frame_identity();
        marker[k].frame.x[0] = b->at[k];
    }
}

mbsr_flex *test_ritz_make(const test_ritz *beam)
{
    const test_ritz *b = beam;
    arrays w;
    mbsr_flex_marker marker[TEST_RITZ_MARKERS];
    mbsr_flex_def def = mbsr_default_flex_def();
    mbsr_flex *flex;
    mbsr_error error;
    memset(&w, 0, sizeof w);
    list_shapes(b, &w);
    integrate(b, &w);
    place_markers(b, &w, marker);
    def.modes = b->modes;
    def.dependent = w.shapes - b->modes;
    def.Y = w.Y;
    def.mass = b->density * b->length + b->tip;
    def.c0[0] = b->length * (0.5 * b->density * b->length + b->tip);
    def.N0[0] = b->length * b->length * (b->density * b->length / 3.0 + b->tip);
    def.Ct0 = w.Ct0, def.P0 = w.P0, def.P = w.P;
    def.K = b->K, def.D = b->D;
    def.markers = b->markers, def.marker = marker;
    assert_ok(mbsr_flex_create(&def, &flex, &error), &error);
    return flex;
}

/* A (n x n) = diag(x) */
static void fill_diagonal(int n, const double *x, double *A)
{
    for (int k = 0; k < n; ++k) A[k * (n + 1)] = x[k];
}

test_ritz test_ritz_bending(int modes, double length, double EI, double density)
{
    test_ritz b = {
        .length = length, .density = density, .modes = modes, .markers = 2, .at = {0.0, length}};
    for (int a = 0; a < modes; ++a) {
        const double p = b.power[a] = a + 2.0;
        b.dir[a] = 1;
        for (int c = 0; c < modes; ++c) {
            const double r = c + 2.0;
            b.K[a * modes + c] =
                EI / (length * length * length) * p * (p - 1.0) * r * (r - 1.0) / (p + r - 3.0);
        }
    }
    return b;
}

test_ritz test_ritz_pendulum(double EI)
{
    return test_ritz_bending(2, 1.0, EI, 1.0);
}

test_ritz test_ritz_first(void)
{
    static const double axis[3] = {1.0, 0.0, 0.0};
    test_ritz b = {.length = 1.0,
                   .density = 1.5,
                   .tip = 0.2,
                   .modes = 3,
                   .dir = {1, 2, 1},
                   .power = {2.0, 2.0, 3.0},
                   .markers = 3,
                   .at = {0.0, 1.0, 0.5}};
    fill_diagonal(3, (double[3]){40.0, 30.0, 120.0}, b.K);
    fill_diagonal(3, (double[3]){0.1, 0.2, 0.3}, b.D);
    b.turn[1] = mbsr_frame_rotated(NULL, axis, 0.5);
    return b;
}

test_ritz test_ritz_second(void)
{
    test_ritz b = {.length = 0.8,
                   .density = 1.0,
                   .modes = 2,
                   .dir = {1, 2},
                   .power = {2.0, 2.0},
                   .markers = 2,
                   .at = {0.0, 0.8}};
    fill_diagonal(2, (double[2]){25.0, 20.0}, b.K);
    fill_diagonal(2, (double[2]){0.05, 0.05}, b.D);
    return b;
}

test_ritz test_ritz_massless(void)
{
    test_ritz b = {.length = 1.0,
                   .density = 1.0,
                   .modes = 3,
                   .dir = {1, 2, 1},
                   .massless = {0, 0, 1},
                   .power = {2.0, 2.0, 4.0},
                   .markers = 2,
                   .at = {0.0, 1.0}};
    fill_diagonal(3, (double[3]){30.0, 20.0, 500.0}, b.K);
    fill_diagonal(3, (double[3]){0.1, 0.1, 1.0}, b.D);
    return b;
}

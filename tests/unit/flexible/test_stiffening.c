/* Geometric stiffening by dependent shapes: digits of an independent program, the mass matrix
 * against the field integrated point by point, forces against differences of the kinetic energy,
 * Newton systems, and what is refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "flexible.h"
#include "newton_system.h"

#include "algebra/space3.h"
#include "flexible/mass.h"
#include "flexible/rotation_vector.h"
#include "flexible/slopes.h"

#include <stdlib.h>
#include <string.h>

static const mbsr_error *error_of(const test_flexible *w)
{
    return mbsr_data_error(w->data);
}

static void assert_all_close(int n, const double *x, const double *expected, double tolerance)
{
    for (int k = 0; k < n; ++k)
        assert_close(x[k], expected[k], tolerance * fmax(1.0, fabs(expected[k])));
}

static void a_pendulum_that_stiffens(void **state)
{
    (void)state;
    static const double udot[3] = {1728.909456647806, -5616.647897721585, 4116.096465757335},
                        momenta[3] = {0.418332973050650, 0.316689076190477, 0.254782066233767},
                        tip[2] = {0.952327151324609, 0.305056825407552};
    test_flexible w;
    double x[3], pose[12], T, U;
    test_flexible_pendulum(&w, 100.0, 1);
    assert_ok(mbsr_forward_dynamics(w.model, w.data, 0.0, w.q, w.u, NULL, x), error_of(&w));
    assert_all_close(3, x, udot, 1e-11);
    assert_ok(mbsr_energy(w.model, w.data, &T, &U), error_of(&w));
    assert_close(T, 0.26286054894956756, 1e-14);
    assert_close(U, 1.508513179846954, 1e-13);
    assert_ok(mbsr_momenta(w.model, w.data, x), error_of(&w));
    assert_all_close(3, x, momenta, 1e-13);
    assert_ok(mbsr_body_pose(w.model, w.data, w.tip, pose), error_of(&w));
    assert_all_close(2, pose + MBSR_POSE_X, tip, 1e-14);
    test_flexible_free(&w);
}

/* ---- the field, point by point ---- */

enum { MODES = 3, D = 6 + MODES, POINTS = 6 };

/* Gauss's points and weights on 0 .. 1, exact to degree 11. */
static const double gauss_x[POINTS] = {0.033765242898423975, 0.16939530676686776,
                                       0.38069040695840156,  0.6193095930415985,
                                       0.8306046932331322,   0.966234757101576},
                    gauss_w[POINTS] = {0.08566224618958525, 0.18038078652406944,
                                       0.23395696728634546, 0.23395696728634546,
                                       0.18038078652406944, 0.08566224618958525};

/* Place of the material at z = x / L, and what V moves it by: 3 x D. The beam has modes z^2 along
 * y, z^2 along z and z^3 along y, and shortens by half the integral of its squared slopes. */
static void field(const test_ritz *b, double z, const double s[MODES], double rho[3],
                  double N[3 * D])
{
    const double L = b->length;
    rho[0] = L * z, rho[1] = s[0] * z * z + s[2] * z * z * z, rho[2] = s[1] * z * z;
    memset(N, 0, 3 * D * sizeof *N);
    double shortening[MODES] = {0.0};
    for (int k = 0; k < POINTS; ++k) {
        const double t = z * gauss_x[k], weight = z * gauss_w[k] / L,
                     dy = 2.0 * s[0] * t + 3.0 * s[2] * t * t, dz = 2.0 * s[1] * t;
        rho[0] -= 0.5 * weight * (dy * dy + dz * dz);
        shortening[0] -= weight * dy * 2.0 * t;
        shortening[1] -= weight * dz * 2.0 * t;
        shortening[2] -= weight * dy * 3.0 * t * t;
    }
    for (int a = 0; a < MODES; ++a) N[3 * (6 + a)] = shortening[a];
    N[3 * 6 + 1] = N[3 * 7 + 2] = z * z, N[3 * 8 + 1] = z * z * z;
    N[3 * 3] = N[3 * 4 + 1] = N[3 * 5 + 2] = 1.0;
    N[1] = -rho[2], N[2] = rho[1]; /* e_x x rho and so on */
    N[3] = rho[2], N[5] = -rho[0];
    N[6] = -rho[1], N[7] = rho[0];
}

static void the_mass_matrix_is_that_of_the_field(void **state)
{
    (void)state;
    test_ritz beam = test_ritz_first();
    beam.stiffening = 1;
    mbsr_flex *flex = test_ritz_make(&beam);
    double s[MODES], M[D * D], rho[3], N[3 * D];
    test_rng rng = test_seed(11);
    for (int trial = 0; trial < 20; ++trial) {
        double expected[D * D] = {0.0};
        test_fill(&rng, MODES, s);
        for (int k = 0; k <= POINTS; ++k) { /* the last one is the mass at the tip */
            const double m = k < POINTS ? beam.density * beam.length * gauss_w[k] : beam.tip;
            field(&beam, k < POINTS ? gauss_x[k] : 1.0, s, rho, N);
            for (int c = 0; c < D; ++c) {
                for (int r = 0; r < D; ++r)
                    expected[D * c + r] += m * (N[3 * c] * N[3 * r] + N[3 * c + 1] * N[3 * r + 1] +
                                                N[3 * c + 2] * N[3 * r + 2]);
            }
        }
        assert_int_equal(mbsr_flex_mass_matrix(flex, s, M), MBSR_OK);
        assert_all_close(D * D, M, expected, 1e-13);
    }
    mbsr_flex_destroy(flex);
}

/* ---- relations ---- */

/* dE/dt = -dissipation + power of the load, by differences of the energy along q', u'. */
static void energy_changes_by_what_is_dissipated(void **state)
{
    (void)state;
    static const double load[6] = {0.1, 0.2, -0.3, 1.0, -2.0, 0.5},
                        step[4] = {-2.0, -1.0, 1.0, 2.0};
    const double h = 1e-4;
    test_flexible w;
    double udot[8], tau[8], E[4], T, U, power, V[6];
    test_flexible_tree(&w, 0, 1);
    const test_flexible at = w;
    assert_ok(mbsr_forward_dynamics(w.model, w.data, 0.0, w.q, w.u, NULL, udot), error_of(&w));
    assert_ok(mbsr_dissipation(w.model, w.data, &power), error_of(&w));
    assert_ok(mbsr_body_twist(w.model, w.data, mbsr_model_bodies(w.model) - 1, V), error_of(&w));
    double work = -power;
    for (int k = 0; k < 6; ++k) work += load[k] * V[k];
    for (int l = 0; l < 4; ++l) {
        const double s = step[l] * h;
        for (int k = 0; k < 8; ++k) {
            w.q[k] = at.q[k] + s * at.u[k] + 0.5 * s * s * udot[k];
            w.u[k] = at.u[k] + s * udot[k];
        }
        assert_ok(mbsr_stage_positions(w.model, w.data, 0.0, w.q), error_of(&w));
        assert_ok(mbsr_stage_velocities(w.model, w.data, w.u), error_of(&w));
        assert_ok(mbsr_energy(w.model, w.data, &T, &U), error_of(&w));
        E[l] = T + U;
    }
    assert_close((E[0] - 8.0 * E[1] + 8.0 * E[2] - E[3]) / (12.0 * h), work,
                 1e-8 * fabs(work) + 1e-8);
    assert_ok(mbsr_inverse_dynamics(w.model, w.data, 0.0, at.q, at.u, udot, NULL, tau),
              error_of(&w));
    for (int k = 0; k < 8; ++k) assert_close(tau[k], 0.0, 1e-12);
    test_flexible_free(&w);
}

/* p' of the momentum form is the derivative of p along q', u'. */
static void momenta_change_as_the_momentum_form_says(void **state)
{
    (void)state;
    static const double step[4] = {-2.0, -1.0, 1.0, 2.0}, weight[4] = {1.0, -8.0, 8.0, -1.0};
    const double h = 1e-4;
    test_flexible w;
    double y[24], yp[24] = {0.0}, F[24], udot[8], p[8], rate[8] = {0.0};
    test_flexible_tree(&w, 1, 1);
    const test_flexible at = w;
    assert_ok(mbsr_dae_pack(w.model, w.data, MBSR_DAE_MOMENTUM, 0.0, w.q, w.u, y), error_of(&w));
    assert_ok(mbsr_dae_residual(w.model, w.data, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), error_of(&w));
    assert_ok(mbsr_forward_dynamics(w.model, w.data, 0.0, w.q, w.u, NULL, udot), error_of(&w));
    for (int l = 0; l < 4; ++l) {
        const double s = step[l] * h;
        for (int k = 0; k < 8; ++k) {
            w.q[k] = at.q[k] + s * at.u[k] + 0.5 * s * s * udot[k];
            w.u[k] = at.u[k] + s * udot[k];
        }
        assert_ok(mbsr_stage_positions(w.model, w.data, 0.0, w.q), error_of(&w));
        assert_ok(mbsr_stage_velocities(w.model, w.data, w.u), error_of(&w));
        assert_ok(mbsr_momenta(w.model, w.data, p), error_of(&w));
        for (int k = 0; k < 8; ++k) rate[k] += weight[l] * p[k] / (12.0 * h);
    }
    for (int k = 0; k < 8; ++k) assert_close(fabs(F[8 + k]), fabs(rate[k]), 1e-7);
    test_flexible_free(&w);
}

static void newton_systems_agree_with_differences(void **state)
{
    (void)state;
    for (int tree = 0; tree < 2; ++tree) {
        test_flexible w;
        test_newton_state s;
        mbsr_newton *newton;
        mbsr_error error;
        double r[32], x[32];
        test_rng rng = test_seed(9);
        if (tree)
            test_flexible_tree(&w, 0, 1);
        else
            test_flexible_pendulum(&w, 100.0, 1);
        assert_ok(test_newton_start(&s, w.model, w.data, 0.0, w.q, w.u, NULL), error_of(&w));
        assert_ok(test_newton_matrices(&s, w.model, w.data), error_of(&w));
        assert_ok(mbsr_newton_create(w.model, MBSR_DAE_MOMENTUM, NULL, &newton, &error), &error);
        test_fill(&rng, s.n, r);
        for (int k = 0; k < 3; ++k) {
            const double c = (double[3]){1.0, 30.0, 1e4}[k];
            assert_ok(mbsr_newton_factor(newton, s.data, s.t, s.y, s.yp, c),
                      mbsr_newton_error(newton));
            assert_ok(mbsr_newton_solve(newton, r, x), mbsr_newton_error(newton));
            const test_newton_errors e = test_newton_compare(&s, c, r, x);
            assert_less(e.row, 1e-8);
            assert_less(e.net_row, 1e-9);
        }
        mbsr_newton_destroy(newton);
        test_newton_free(&s);
        test_flexible_free(&w);
    }
}

/* A flexible body moving: R turned by exp([turn]x). */
typedef struct motion {
    const mbsr_flex *flex;
    double R[9], s[MODES], V[D], A[D];
} motion;

/* M V, h - M' V and h + M A. */
static void forces(const motion *m, double F[3 * D])
{
    double M[D * D], Mdot[D * D], h[D] = {0.0};
    mbsri_flex_mass(m->flex, m->R, m->s, M);
    mbsri_flex_gyration(m->flex, m->R, m->s, m->V, M, h);
    mbsri_flex_mass_rate(m->flex, m->R, m->s, m->V, M, Mdot);
    for (int r = 0; r < D; ++r) {
        F[r] = 0.0;
        F[D + r] = F[2 * D + r] = h[r];
        for (int c = 0; c < D; ++c) {
            F[r] += M[D * c + r] * m->V[c];
            F[D + r] -= Mdot[D * c + r] * m->V[c];
            F[2 * D + r] += M[D * c + r] * m->A[c];
        }
    }
}

static void change(motion *m, int column, double step)
{
    double turn[3] = {0.0}, E[9], R[9];
    if (column >= D) m->V[column - D] += step;
    if (column >= 6 && column < D) m->s[column - 6] += step;
    if (column >= 3) return;
    turn[column] = step;
    const mbsri_rotation_vector by = mbsri_rotation_vector_of(turn);
    mbsri_exp3(&by, E);
    mbsri_multiply3(E, m->R, R);
    memcpy(m->R, R, sizeof R);
}

static void take(void *to, int column, const double *momentum, const double *turning,
                 const double *load)
{
    const size_t size = D * sizeof(double);
    double *F = (double *)to + 3 * D * column;
    memcpy(F, momentum, size);
    memcpy(F + D, turning, size);
    memcpy(F + 2 * D, load, size);
}

static void derivatives_agree_with_differences(void **state)
{
    (void)state;
    static const double step[4] = {-2.0, -1.0, 1.0, 2.0}, weight[4] = {1.0, -8.0, 8.0, -1.0};
    const double h = 1e-3;
    test_ritz beam = test_ritz_first();
    test_rng rng = test_seed(5);
    for (int trial = 0; trial < 6; ++trial) {
        beam.stiffening = trial % 2;
        mbsr_flex *flex = test_ritz_make(&beam);
        motion at = {.flex = flex};
        double quaternion[4], slopes[2 * D * 3 * D] = {0.0}, F[3 * D];
        double *work = malloc(mbsri_flex_slopes_size(flex) * sizeof *work);
        test_fill(&rng, 4, quaternion);
        mbsr_quaternion_rotation(quaternion, at.R);
        test_fill(&rng, MODES, at.s);
        test_fill(&rng, D, at.V);
        test_fill(&rng, D, at.A);
        mbsri_flex_slopes_of(flex, at.R, at.s, at.V, at.A, work, take, slopes);
        for (int column = 0; column < 2 * D; ++column) {
            double expected[3 * D] = {0.0};
            for (int l = 0; l < 4; ++l) {
                motion moved = at;
                change(&moved, column, step[l] * h);
                forces(&moved, F);
                for (int k = 0; k < 3 * D; ++k) expected[k] += weight[l] * F[k] / (12.0 * h);
            }
            assert_all_close(3 * D, slopes + 3 * D * column, expected, 1e-9);
        }
        free(work);
        mbsr_flex_destroy(flex);
    }
}

/* ---- data ---- */

static void refuse(const mbsr_flex_def *def, int status, const char *words)
{
    mbsr_flex *flex;
    mbsr_error error = {0};
    assert_refused(mbsr_flex_create(def, &flex, &error), &error, status, MBSR_NONE, MBSR_NONE,
                   words);
    assert_null(flex);
}

static void what_does_not_fit_is_refused(void **state)
{
    (void)state;
    test_ritz beam = test_ritz_pendulum(100.0);
    beam.stiffening = 1;
    mbsr_flex *good = test_ritz_make(&beam);
    mbsr_flex_def data;
    double Y[12];
    assert_int_equal(mbsr_flex_definition(good, &data), MBSR_OK);
    assert_int_equal(data.dependent, 3); /* (x/L)^3, ^4, ^5 */
    assert_close(data.Y[0], -4.0 / 3.0, 1e-15);
    memcpy(Y, data.Y, sizeof Y);
    mbsr_flex_def def = data;
    def.Y = Y;
    Y[5] = 7.0;
    refuse(&def, MBSR_ERR_VALUE, "dependent shape 1 is not symmetric|(1,0) is 7");
    Y[5] = NAN;
    refuse(&def, MBSR_ERR_VALUE, "Y(|nan");
    def = data, def.Y = NULL;
    refuse(&def, MBSR_ERR_NULL, "Y is NULL|3 dependent shapes");
    def = data, def.dependent = -1;
    refuse(&def, MBSR_ERR_VALUE, "dependent is -1|0 .. 248");
    def = data, def.dependent = 249;
    refuse(&def, MBSR_ERR_VALUE, "dependent is 249|0 .. 248");
    def = data, def.modes = 100, def.dependent = 50;
    refuse(&def, MBSR_ERR_VALUE, "dependent is 50|at most 4096");
    double P[9 * 25];
    memcpy(P, data.P, sizeof P);
    P[15 * 6 + 6] = 0.0; /* int of (x/L)^6, but the other integrals are kept */
    def = data, def.P = P;
    refuse(&def, MBSR_ERR_VALUE, "Gram matrix|indefinite");
    mbsr_flex_destroy(good);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pendulum_that_stiffens),
        cmocka_unit_test(the_mass_matrix_is_that_of_the_field),
        cmocka_unit_test(energy_changes_by_what_is_dissipated),
        cmocka_unit_test(momenta_change_as_the_momentum_form_says),
        cmocka_unit_test(newton_systems_agree_with_differences),
        cmocka_unit_test(derivatives_agree_with_differences),
        cmocka_unit_test(what_does_not_fit_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

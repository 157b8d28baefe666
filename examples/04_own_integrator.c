/* The residual in one's own solver: implicit Euler with a fixed step, no SUNDIALS.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * F(t, y, (y - y_old) / h) = 0 is solved in every step by Newton's method with a difference
 * quotient for the matrix. Four functions of the library are enough: mbsr_dae_size,
 * mbsr_dae_consistent, mbsr_dae_residual and mbsr_data_error. */
#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIZE = 4 };

static void check(int status, const mbsr_error *error)
{
    if (status == MBSR_OK) return;
    fprintf(stderr, "%s: %s\n", mbsr_status_name(status), error->text);
    exit(1);
}

/* A mass of 2 kg on a Maxwell element: spring 50 N/m, massless node, damper 10 N s/m in series. */
static mbsr_model *maxwell(void)
{
    mbsr_model *m;
    check(mbsr_model_create(NULL, &m, NULL), mbsr_model_error(NULL));
    mbsr_body_def body = mbsr_default_body_def(); /* the node */
    body.joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
    check(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body.inertia = mbsr_inertia_particle(2.0); /* the mass */
    check(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    const mbsr_force_def spring = mbsr_force_axis_spring(0, MBSR_GROUND, 0, 50.0, 0.0, 0.0);
    const mbsr_force_def damper = mbsr_force_axis_spring(1, 0, 0, 0.0, 10.0, 0.0);
    check(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    check(mbsr_model_add_force(m, &damper, NULL), mbsr_model_error(m));
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* x <- A^-1 x by elimination; A[row][column]. q before u: no pivoting needed. */
static void solve(double A[SIZE][SIZE], double x[SIZE])
{
    for (int k = 0; k < SIZE; ++k) {
        for (int r = 0; r < SIZE; ++r) {
            const double factor = r == k ? 0.0 : A[r][k] / A[k][k];
            for (int c = k; c < SIZE; ++c) A[r][c] -= factor * A[k][c];
            x[r] -= factor * x[k];
        }
    }
    for (int k = 0; k < SIZE; ++k) x[k] /= A[k][k];
}

static void residual(const mbsr_model *m, mbsr_data *d, double t, double h, const double *y,
                     const double *old, double *F)
{
    double yp[SIZE];
    for (int k = 0; k < SIZE; ++k) yp[k] = (y[k] - old[k]) / h;
    check(mbsr_dae_residual(m, d, MBSR_DAE_RECURSIVE, t, y, yp, F), mbsr_data_error(d));
}

static void step(const mbsr_model *m, mbsr_data *d, double t, double h, double *y)
{
    double old[SIZE], F[SIZE], moved[SIZE], A[SIZE][SIZE];
    for (int k = 0; k < SIZE; ++k) old[k] = y[k];
    for (int newton = 0; newton < 3; ++newton) {
        residual(m, d, t, h, y, old, F);
        for (int c = 0; c < SIZE; ++c) {
            const double kept = y[c];
            y[c] += 1e-6;
            residual(m, d, t, h, y, old, moved);
            y[c] = kept;
            for (int r = 0; r < SIZE; ++r) A[r][c] = (moved[r] - F[r]) / 1e-6;
        }
        solve(A, F);
        for (int k = 0; k < SIZE; ++k) y[k] -= F[k];
    }
}

int main(void)
{
    mbsr_model *m = maxwell();
    mbsr_data *d;
    check(mbsr_data_create(m, &d, NULL), mbsr_data_error(NULL));

    /* started with v = 1 m/s: node and mass obey c x = d (v - x'), m v' = -c x, so x = exp(-a t)
     * sin(w t) / w */
    const double T = 0.5, a = 50.0 / 10.0 / 2.0, w = sqrt(50.0 / 2.0 - a * a),
                 exact = exp(-a * T) * sin(w * T) / w;
    double error = 0.0;
    for (int steps = 100; steps <= 800; steps *= 2) {
        double y[SIZE] = {0.0, 0.0, 0.0, 1.0}, yp[SIZE];
        check(mbsr_dae_consistent(m, d, MBSR_DAE_RECURSIVE, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
        for (int k = 1; k <= steps; ++k) step(m, d, T * k / steps, T / steps, y);
        const double before = error;
        error = fabs(y[0] - exact);
        printf("%4d steps: x = %.6f m, error %.2e", steps, y[0], error);
        if (steps > 100) printf(" (%.2f of the one before)", error / before);
        printf("\n");
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return error < 1e-3 ? 0 : 1;
}

/* A joint of one's own: a bead on a parabolic wire, written as an implicit constraint.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Coordinates p = (x, y), joint coordinate q = x. The wire y = x^2 / 2 is given as
 *   0 = k(p, q) = (x - q, y - x^2 / 2),  K = [1 0; -x 1],  J = (-1, 0),  kII = K' V = (0, -x'^2).
 * K is not the unit matrix: the library factors it. */
#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdio.h>

static int position(const mbsr_joint_args *args, double *p)
{
    p[0] = args->q[0];
    p[1] = 0.5 * args->q[0] * args->q[0];
    return MBSR_OK;
}

static int jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)H, (void)kI;  /* preset to zero; K to the unit matrix */
    K[1] = -args->p[0]; /* row 1, column 0 */
    J[0] = -1.0;
    return MBSR_OK;
}

static int bias(const mbsr_joint_args *args, double *kII)
{
    kII[1] = -args->V[0] * args->V[0];
    return MBSR_OK;
}

static const mbsr_joint_table wire = {.version = MBSR_JOINT_TABLE_VERSION,
                                      .name = "wire",
                                      .position = position,
                                      .jacobians = jacobians,
                                      .bias = bias};

/* Weight on a body of a space that only its joint knows. */
static int weight(void *user, double t, int d, double *f)
{
    (void)t, (void)d;
    f[1] = -9.81 * *(const double *)user;
    return MBSR_OK;
}

int main(void)
{
    double mass = 2.0, M[4] = {mass, 0.0, 0.0, mass};
    mbsr_model *m;
    mbsr_data *d;
    mbsr_body_def bead = mbsr_default_body_def();
    bead.name = "bead";
    bead.joint = mbsr_joint_custom(&wire, 2, 1, NULL);
    bead.inertia = mbsr_inertia_matrix(2, M);
    mbsr_force_def load = mbsr_force_applied(0, weight, &mass);
    if (mbsr_model_create(NULL, &m, NULL)) return 1;
    if (mbsr_model_add_body(m, &bead, NULL) || mbsr_model_add_force(m, &load, NULL) ||
        mbsr_model_finish(m)) {
        fprintf(stderr, "%s\n", mbsr_model_error(m)->text);
        return 1;
    }
    if (mbsr_data_create(m, &d, NULL)) return 1;

    /* (1 + x^2) x'' = -x (g + x'^2), by hand from the Lagrangian */
    double worst = 0.0;
    for (int k = -2; k <= 2; ++k) {
        const double x = 0.5 * k, v = 1.0 + 0.3 * k, expected = -x * (9.81 + v * v) / (1.0 + x * x);
        double a = 0.0;
        if (mbsr_forward_dynamics(m, d, 0.0, &x, &v, NULL, &a)) {
            fprintf(stderr, "%s\n", mbsr_data_error(d)->text);
            return 1;
        }
        printf("x = %+.1f m, x' = %.1f m/s: x'' = %+.6f m/s^2, by hand %+.6f\n", x, v, a, expected);
        worst = fmax(worst, fabs(a - expected));
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return worst < 1e-12 ? 0 : 1;
}

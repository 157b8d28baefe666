/* Two coupled oscillators, the first without mass, in absolute and in relative coordinates (M.
 * Arnold, Mech. Sci. 4 (2013), doi:10.5194/ms-4-221-2013, Sect. 2.2).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * ground - c1, d1 - m1 - c2, d2 - m2, a force F on m1. With m1 = 0 its equation is of first order,
 * (6). In relative coordinates, q2 = p2 - p1, the equation of m2 contains the acceleration of the
 * massless body: the recursion keeps it out of its sums and puts it where it belongs. Both give the
 * same motion. */
#include <mbsrank/ida.h>
#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void check(int status, const mbsr_error *error)
{
    if (status == MBSR_OK) return;
    fprintf(stderr, "%s: %s\n", mbsr_status_name(status), error->text);
    exit(1);
}

static int force(void *user, double t, int n, double *value)
{
    (void)user, (void)t, (void)n;
    value[0] = 1.0; /* N along x */
    return MBSR_OK;
}

static mbsr_model *build(int relative)
{
    mbsr_model *m;
    mbsr_error error;
    check(mbsr_model_create(NULL, &m, &error), &error);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
    check(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m)); /* body 0: m1 = 0 */
    body.parent = relative ? 0 : MBSR_GROUND;
    body.inertia = mbsr_inertia_particle(1.0);
    check(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m)); /* body 1: m2 */
    const mbsr_force_def forces[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 1.0, 0.1, 0.0),
                                     mbsr_force_axis_spring(1, 0, 0, 1.0, 0.1, 0.0),
                                     mbsr_force_applied(0, force, NULL)};
    for (int k = 0; k < 3; ++k)
        check(mbsr_model_add_force(m, &forces[k], NULL), mbsr_model_error(m));
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

int main(void)
{
    double p[2][2];
    for (int relative = 0; relative < 2; ++relative) {
        mbsr_model *m = build(relative);
        mbsr_data *d;
        mbsr_ida *ida;
        mbsr_error error;
        mbsr_ida_stats stats;
        /* m1 in its quasi-static place, m2 at rest at 0 */
        const double q[2] = {0.5, relative ? -0.5 : 0.0}, u[2] = {0.0, 0.0};
        double y[6], yp[6]; /* momentum form: q, p, u */
        check(mbsr_data_create(m, &d, &error), &error);
        check(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
        check(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
        check(mbsr_ida_create(m, d, NULL, &ida, &error), &error);
        check(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
        check(mbsr_ida_advance(ida, 2.0, NULL, y, NULL), mbsr_ida_error(ida));
        check(mbsr_ida_get_stats(ida, &stats), mbsr_ida_error(ida));
        p[relative][0] = y[0];
        p[relative][1] = relative ? y[0] + y[1] : y[1];
        printf("%s coordinates: p1(2) = %.6f, p2(2) = %.6f, %ld steps\n",
               relative ? "relative" : "absolute", p[relative][0], p[relative][1], stats.steps);
        mbsr_ida_destroy(ida);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    return fabs(p[0][0] - p[1][0]) + fabs(p[0][1] - p[1][1]) < 1e-4 ? 0 : 1;
}

/* Two mass points in the plane, the first without mass (M. Arnold, Mech. Sci. 4 (2013),
 * doi:10.5194/ms-4-221-2013, Fig. 3, upper plot).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Point i hangs on springs and dampers in x and y; point j on a spring and damper along x from i,
 * and is free along y. With m_i = 0 point i has two equations of first order, (34), and no inertia
 * at all. */
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

int main(void)
{
    mbsr_model *m;
    mbsr_data *d;
    mbsr_ida *ida;
    mbsr_error error;
    int i, j;

    /* the tree: ground - i - j */
    check(mbsr_model_create(NULL, &m, &error), &error);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "i";
    body.joint = mbsr_joint_point_free();
    body.inertia = mbsr_inertia_particle(0.0); /* kg: zero means zero */
    check(mbsr_model_add_body(m, &body, &i), mbsr_model_error(m));
    body.name = "j";
    body.parent = i;
    body.inertia = mbsr_inertia_particle(1.0);
    check(mbsr_model_add_body(m, &body, &j), mbsr_model_error(m));

    /* springs and dampers: between, axis, N/m, N s/m, rest length */
    const mbsr_force_def springs[] = {mbsr_force_axis_spring(i, MBSR_GROUND, 0, 40.0, 2.0, 0.0),
                                      mbsr_force_axis_spring(i, MBSR_GROUND, 1, 30.0, 3.0, 0.0),
                                      mbsr_force_axis_spring(j, i, 0, 20.0, 0.5, 0.0)};
    for (int k = 0; k < 3; ++k)
        check(mbsr_model_add_force(m, &springs[k], NULL), mbsr_model_error(m));
    check(mbsr_model_finish(m), mbsr_model_error(m));
    check(mbsr_data_create(m, &d, &error), &error);

    /* a consistent start: u_i follows from the forces on the massless point */
    double y[8] = {0.1, 0.1, 0.05, 0.0, 0.0, 0.0, 0.0, 0.2}, yp[8], t; /* q_i, q_j, u_i, u_j */
    mbsr_consistent_info start;
    check(mbsr_dae_consistent(m, d, MBSR_DAE_RECURSIVE, 0.0, y, yp, NULL, &start),
          mbsr_data_error(d));
    mbsr_rank_info rank;
    check(mbsr_body_rank(m, d, i, &rank), mbsr_data_error(d));
    printf("rank of point i: %d of %d; velocities found for %d directions\n", rank.rank, rank.n,
           start.null_directions);

    /* integrate and compare q_iy with its closed form 0.1 exp(-c t / d) */
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = MBSR_DAE_RECURSIVE;
    opt.rtol = opt.atol = 1e-8;
    check(mbsr_ida_create(m, d, &opt, &ida, &error), &error);
    check(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    double worst = 0.0;
    for (int k = 1; k <= 10; ++k) {
        check(mbsr_ida_advance(ida, 0.1 * k, &t, y, yp), mbsr_ida_error(ida));
        printf("t = %.1f  q_ix = %+.6f  q_iy = %+.6f  q_jx = %+.6f\n", t, y[0], y[1], y[2]);
        worst = fmax(worst, fabs(y[1] - 0.1 * exp(-30.0 / 3.0 * t)));
    }
    printf("largest error of q_iy: %.1e\n", worst);

    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return worst < 1e-6 ? 0 : 1;
}

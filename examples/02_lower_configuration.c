/* Two mass points joined by a slider, the first without mass (M. Arnold, Mech. Sci. 4 (2013),
 * doi:10.5194/ms-4-221-2013, Fig. 3, lower plot).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Point j keeps the distance l in x from point i and is free in y. With m_i = 0 point i carries the
 * mass of j in x, but nothing in y: its block D has rank 1, one equation of second and one of first
 * order, (36). */
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
    const double c = 40.0, damping = 2.0, mass = 1.0, l = 0.5;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_ida *ida;
    mbsr_error error;
    int i, j;

    check(mbsr_model_create(NULL, &m, &error), &error);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "i"; /* no inertia given: zero */
    body.joint = mbsr_joint_point_free();
    check(mbsr_model_add_body(m, &body, &i), mbsr_model_error(m));
    body.name = "j";
    body.parent = i;
    body.joint = mbsr_joint_point((mbsr_planar_frame){l, 0.0, 0.0}, MBSR_Y, 0, NULL, NULL);
    body.inertia = mbsr_inertia_particle(mass);
    check(mbsr_model_add_body(m, &body, &j), mbsr_model_error(m));
    for (int axis = 0; axis < 2; ++axis) {
        const mbsr_force_def spring = mbsr_force_axis_spring(i, MBSR_GROUND, axis, c, damping, 0.0);
        check(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    check(mbsr_model_finish(m), mbsr_model_error(m));
    check(mbsr_data_create(m, &d, &error), &error);

    double y[6] = {0.1, 0.1, 0.0, 0.0, 0.0, 0.3}, yp[6], t; /* q_ix, q_iy, q_j and their rates */
    check(mbsr_dae_consistent(m, d, MBSR_DAE_RECURSIVE, 0.0, y, yp, NULL, NULL),
          mbsr_data_error(d));
    const double speed = y[4] + y[5]; /* of j in y; nothing pushes it, so it stays */
    mbsr_rank_info rank;
    check(mbsr_body_rank(m, d, i, &rank), mbsr_data_error(d));
    printf("rank of point i: %d of %d, smallest kept %.2g, largest dropped %.2g, tolerance %.0e\n",
           rank.rank, rank.n, rank.smallest_kept, rank.largest_dropped, rank.tolerance);

    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = MBSR_DAE_RECURSIVE;
    opt.rtol = opt.atol = 1e-8;
    check(mbsr_ida_create(m, d, &opt, &ida, &error), &error);
    check(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    double worst = 0.0;
    for (int k = 1; k <= 10; ++k) {
        check(mbsr_ida_advance(ida, 0.1 * k, &t, y, yp), mbsr_ida_error(ida));
        const double decay = damping / (2.0 * mass), omega = sqrt(c / mass - decay * decay);
        const double x = 0.1 * exp(-decay * t) * (cos(omega * t) + decay / omega * sin(omega * t));
        printf("t = %.1f  q_ix = %+.6f  q_iy = %+.6f  y of j = %+.6f\n", t, y[0], y[1],
               y[1] + y[2]);
        worst = fmax(worst, fmax(fabs(y[0] - x), fabs(y[1] - 0.1 * exp(-c / damping * t))));
        worst = fmax(worst, fabs(y[1] + y[2] - 0.1 - speed * t));
    }
    printf("largest error: %.1e\n", worst);

    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return worst < 1e-5 ? 0 : 1;
}

/* Linkages of IFToMM's benchmarks.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sheet.h"

#include <math.h>

static int bar(mbsr_simulation *s, int parent, double x, double angle)
{
    static const double com[2] = {0.5, 0.0};
    return mbsr_simulation_add_body(s, NULL, parent,
                                    mbsr_joint_planar_revolute((mbsr_planar_frame){x, 0.0, angle},
                                                               (mbsr_planar_frame){0.0, 0.0, 0.0}),
                                    mbsr_inertia_planar(1.0, com, 1.0 / 12.0));
}

/* Upright cranks of 1 m on the ground, couplers from the end of one to the end of the next. */
static void double_four_bar(sheet *out)
{
    static const double tip[3] = {1.0, 0.0, 0.0},
                        theirs[4] = {0.3284573768, 0.9445187937, 1.423050003, -0.4948670827};
    const double up = acos(0.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    int crank[3];
    for (int k = 0; k < 3; ++k) crank[k] = bar(&s, MBSR_GROUND, k, up);
    for (int k = 0; k < 2; ++k) {
        const int coupler = bar(&s, crank[k], 1.0, -up);
        mbsr_simulation_add_closure(&s, mbsr_closure_ball(coupler, tip, crank[k + 1], tip));
    }
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
    mbsr_simulation_set_rate(&s, crank[0], 0, -1.0);
    sheet_start(&s, 1e-10, NULL, NULL);
    sheet_run(&s, 10.0);
    const double a = up + s.q[0], rate = s.u[0];
    sheet_problem(
        out, "Double four-bar at 10 s",
        "End of the first crank. Benchmark A02 of IFToMM with two windows; digits of Exudyn's "
        "fourBarMechanismIftomm.py with its shortest step, 1.25·10⁻⁴ s, whose own error is "
        "some 10⁻⁶.");
    sheet_add(out, "x, m", theirs[0], cos(a), 2e-6);
    sheet_add(out, "y, m", theirs[1], sin(a), 2e-6);
    sheet_add(out, "x′, m/s", theirs[2], -rate * sin(a), 4e-6);
    sheet_add(out, "y′, m/s", theirs[3], rate * cos(a), 4e-6);
    mbsr_simulation_end(&s);
}

/* Six hinges at right angles along the edges of a cube: one freedom where a count gives none. */
static void bricard(sheet *out)
{
    static const double axis[6][3] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0},
                                      {0, 1, 0}, {0, 0, 1}, {1, 0, 0}},
                        step[5][3] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, 1, 0}};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_closure_report report;
    int body = MBSR_GROUND;
    mbsr_frame at = mbsr_frame_identity();
    for (int k = 0; k < 5; ++k) {
        const double origin[3] = {0.0, 0.0, 0.0};
        body = mbsr_simulation_add_body(&s, NULL, body, mbsr_joint_revolute(&at, NULL, axis[k]),
                                        mbsr_inertia_rod(1.0, origin, step[k]));
        at = mbsr_frame_at(step[k][0], step[k][1], step[k][2]);
    }
    const mbsr_joint last = mbsr_joint_revolute(&at, NULL, axis[5]);
    const mbsr_frame end = mbsr_frame_at(0.0, 0.0, 1.0);
    sheet_check(
        mbsr_model_add_loop_joint(s.model, "last", body, &last, MBSR_GROUND, &end, NULL, NULL),
        mbsr_model_error(s.model));
    sheet_check(mbsr_model_finish(s.model), mbsr_model_error(s.model));
    mbsr_data *d = mbsr_simulation_add_data(&s);
    const double q[6] = {0.0};
    sheet_check(mbsr_closures_report(s.model, d, 0.0, q, &report, NULL, NULL), mbsr_data_error(d));
    sheet_problem(
        out, "Bricard's mechanism",
        "Benchmark A04 of IFToMM: one freedom, where counting freedoms and rows gives none.");
    sheet_add(out, "mobility", 1.0, report.mobility, 0.1);
    sheet_add(out, "redundant rows of six", 1.0, report.rows - report.independent, 0.1);
    mbsr_simulation_end(&s);
}

void sheet_linkages(sheet *out)
{
    double_four_bar(out);
    bricard(out);
}

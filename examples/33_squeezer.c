/* Andrews' squeezer, seven bodies in three loops, against published digits.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The mechanism and its data are those of the Test Set for IVP Solvers (problem "Andrews' squeezing
 * mechanism"). Tree: K1 - K2, K3, K5 - K4 and K7 - K6 on the ground; three pins at the end of K2
 * close the loops. A motor of 0.033 N m drives K1 from rest, a spring pulls at K3; within 30 ms K1
 * turns two and a half times, ever faster. First the pins are rigid, then elastic, 1e10 N/m, which
 * costs hardly a step more: the spring of a stiff closure is an unknown of the equations, and
 * nothing in them grows with it. squeezer.csv has the links at some times for squeezer.gp. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>
#include <string.h>

enum { K1, K2, K3, K5, K4, K7, K6, BODIES };
static const double T = 0.03, d = 28e-3;

static int torque(void *user, double t, int n, double *value)
{
    (void)user, (void)t, (void)n;
    value[0] = 0.033;
    return MBSR_OK;
}

static void link_body(mbsr_model *m, const char *name, int parent, double x, double y, double mass,
                      double moment, double cx, double cy)
{
    const mbsr_planar_frame at = {x, y, 0.0}, own = {0.0, 0.0, 0.0};
    const double com[2] = {cx, cy};
    add_body(m, name, parent, mbsr_joint_planar_revolute(at, own),
             mbsr_inertia_planar(mass, com, moment));
}

/* The end of K2 on a point of another body; stiffness in N/m, 0: rigid. */
static void pin(mbsr_model *m, const char *name, int body, double x, double y, double stiffness)
{
    const double end[3] = {-d, 0.0, 0.0}, there[3] = {x, y, 0.0};
    mbsr_closure_def def = mbsr_closure_ball(K2, end, body, there);
    def.name = name;
    for (int k = 0; k < 2; ++k) {
        def.stiffness[k] = stiffness;
        def.damping[k] = 1e-5 * stiffness; /* N s/m */
    }
    check(mbsr_model_add_closure(m, &def, NULL), mbsr_model_error(m));
}

static mbsr_model *squeezer(double stiffness)
{
    const double xa = -0.06934, ya = -0.00227, xb = -0.03635, yb = 0.03273;
    const double on_K3[3] = {2e-2, -18e-3, 0.0}, on_ground[3] = {0.014, 0.072, 0.0};
    mbsr_model *m = new_model();
    link_body(m, "K1", MBSR_GROUND, 0.0, 0.0, 0.04325, 2.194e-6, 92e-5, 0.0);
    link_body(m, "K2", K1, 7e-3, 0.0, 0.00365, 4.410e-7, -115e-4, 0.0);
    link_body(m, "K3", MBSR_GROUND, xb, yb, 0.02373, 5.255e-6, 1874e-5, 1043e-5);
    link_body(m, "K5", MBSR_GROUND, xa, ya, 0.07050, 1.169e-5, 2308e-5, 916e-5);
    link_body(m, "K4", K5, 4e-2, 0.0, 0.00706, 5.667e-7, 0.0, -(2e-2 - 1421e-5));
    link_body(m, "K7", MBSR_GROUND, xa, ya, 0.05498, 1.912e-5, 1228e-5, 449e-5);
    link_body(m, "K6", K7, 0.0, -4e-2, 0.00706, 5.667e-7, 2e-2 - 1421e-5, 0.0);
    pin(m, "K2-K3", K3, 0.0, -35e-3, stiffness);
    pin(m, "K2-K4", K4, 0.0, -2e-2, stiffness);
    pin(m, "K2-K6", K6, 2e-2, 0.0, stiffness);
    add_force(m, mbsr_force_joint_applied(K1, torque, NULL));
    add_force(m, mbsr_force_point_spring(K3, on_K3, MBSR_GROUND, on_ground, 4530.0, 0.0, 0.07785));
    return m;
}

/* Lines through the origins of the bodies listed to the common pin. */
static void draw(FILE *file, mbsr_simulation *s)
{
    static const int line[4][2] = {{K1, K2}, {K3, K3}, {K5, K4}, {K7, K6}};
    double end[3];
    check(mbsr_body_pose(s->model, s->data, K2, end), mbsr_data_error(s->data));
    end[0] -= d * cos(end[2]);
    end[1] -= d * sin(end[2]);
    for (int k = 0; k < 4; ++k) {
        for (int l = 0; l < 2; ++l) {
            double pose[3];
            check(mbsr_body_pose(s->model, s->data, line[k][l], pose), mbsr_data_error(s->data));
            fprintf(file, "%g,%g,%g\n", 1e3 * pose[0], 1e3 * pose[1], s->t);
        }
        fprintf(file, "%g,%g,%g\n\n", 1e3 * end[0], 1e3 * end[1], s->t);
    }
    fprintf(file, "\n");
}

/* beta, Theta, gamma, delta, Phi, epsilon, Omega at 0.03 s, by the Test Set, in the order of the
 * bodies */
static const double published[BODIES] = {
    15.81077119629904,   -15.75637105984298, 0.04082224013073101, 0.5244099658805304,
    -0.5347301163226948, 1.048080741042263,  0.5347301163226948};

/* Runs at one tolerance; returns the largest difference of an angle from the digits. */
static double run(double stiffness, double tolerance, FILE *file)
{
    static const double q[BODIES] = {-0.0617138900142764496, 0.0,
                                     0.455279819163070380,   0.487364979543842550,
                                     0.222668390165885885,   1.23054744454982120,
                                     -0.222668390165885885},
                        u[BODIES] = {0.0};
    mbsr_simulation s = run_start(squeezer(stiffness), q, u, tolerance);
    for (int i = 1; i <= 6; ++i) {
        run_to(&s, T * i / 6);
        if (file) draw(file, &s);
    }
    double worst = 0.0;
    for (int i = 0; i < BODIES; ++i) worst = fmax(worst, fabs(s.q[i] - published[i]));
    printf("%9.0e   %6ld   %.1e\n", tolerance, run_steps(&s), worst);
    mbsr_simulation_end(&s);
    return worst;
}

int main(void)
{
    static const double tolerance[] = {1e-4, 1e-6, 1e-8, 1e-10}, stiffness[] = {0.0, 1e10};
    double worst[2] = {0.0};
    FILE *file = csv("squeezer.csv");
    for (int l = 0; l < 2; ++l) {
        printf("%s pins\ntolerance    steps   largest difference of an angle at 0.03 s\n",
               l ? "elastic" : "rigid");
        for (int k = 0; k < 4; ++k)
            worst[l] = run(stiffness[l], tolerance[k], k == 2 && l == 0 ? file : NULL);
    }
    fclose(file);
    return worst[0] < 1e-7 && worst[1] < 1e-4 ? 0 : 1;
}

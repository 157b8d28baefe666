/* Events: a ball falls on a floor and jumps, with what a blow leaves of its speed given by a
 * number.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Two event functions: the height, which is zero at a blow, and the speed, which is zero at the
 * top. The driver stops where one of them changes sign and says which way. At a blow u jumps, so
 * the run is started anew from there; the top is looked at only, and the same call goes on. By
 * hand: with restitution e the ball returns to e^2 of the height, and the blows are at
 *
 *   sqrt(2 h / g) (1 + 2 e + 2 e^2 + ... + 2 e^(k - 1)).
 *
 * Contacts that press and give are force elements, and need no events: 17_bouncing_ball.c. */
#include <mbsrank/simulation.h>

#include <math.h>
#include <stdio.h>

enum { HEIGHT = 0, SPEED = 1, EVENTS = 2, BLOWS = 8 };
static const double h = 1.0, g = 9.81, e = 0.8; /* m, m/s^2, - */

/* y of the momentum form: q, p, u */
static int event(void *user, double t, const double *y, const double *yp, double *value)
{
    (void)user, (void)t, (void)yp;
    value[HEIGHT] = y[0];
    value[SPEED] = y[2];
    return MBSR_OK;
}

int main(void)
{
    const double up[3] = {0, 0, 1};
    double at = sqrt(2.0 * h / g), top = h, worst = 0.0;
    int blows = 0, tops = 0, direction[EVENTS] = {0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_simulation_add_body(&s, "ball", MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, up),
                             mbsr_inertia_particle(0.5));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -g));
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-9;
    opt.events = EVENTS;
    opt.event = event;
    mbsr_simulation_start(&s, &opt, 0.0, &h, NULL);
    printf("t [s]      by hand    what     height [m]   by hand\n");
    while (blows < BLOWS && mbsr_simulation_to(&s, 100.0) == MBSR_EVENT) {
        mbsr_ida_event_info(s.ida, direction);
        if (direction[HEIGHT] < 0) {
            printf("%.6f   %.6f   blow\n", s.t, at);
            worst = fmax(worst, fabs(s.t - at));
            ++blows;
            at += 2.0 * pow(e, blows) * sqrt(2.0 * h / g);
            top *= e * e;
            const double q = 0.0, u = -e * s.u[0];
            mbsr_simulation_start(&s, &opt, s.t, &q, &u);
        } else if (direction[SPEED] < 0) {
            printf("%.6f              top      %.6f     %.6f\n", s.t, s.q[0], top);
            worst = fmax(worst, fabs(s.q[0] - top));
            ++tops;
        }
    }
    if (s.status) fprintf(stderr, "%s\n", s.error.text);
    mbsr_simulation_end(&s);
    return blows == BLOWS && tops == BLOWS - 1 && worst < 1e-7 ? 0 : 1;
}

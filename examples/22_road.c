/* A quarter of a car on a measured road, given as a table.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The model of 10_quarter_car.c: carrier and spring seat have no mass. The road is known at 2001
 * points; between them it is straight, monotone or a spline. At the points of a straight table the
 * velocity of the road jumps: the driver knows them and ends its steps there; the same table read
 * by a function of one's own makes it stumble. Smoother ones need no such care. Reference: the
 * table with a tolerance of 1e-10. With any argument the road is shorter. */
#include <mbsrank/simulation.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { POINTS = 2001, TIMES = 100 };
static int points = POINTS; /* one every 10 ms */

static const double k[3] = {2e5, 2e4, 1e6}, d[3] = {50.0, 1500.0, 50.0}; /* s, N/m, N s/m */

/* A road like those measured: white noise, and what is left of it after some metres. */
static void measure(double *t, double *height)
{
    unsigned long random = 1;
    for (int n = 1; n < points; ++n) {
        random = (random * 1103515245ul + 12345ul) % 2147483648ul;
        t[n] = 0.01 * n;
        height[n] = 0.98 * height[n - 1] + 0.003 * ((double)random / 2147483648.0 - 0.5);
    }
}

/* The same road, but the driver does not see that it is a table. */
static int hidden(void *road, double t, double *s, double *sdot, double *sddot)
{
    return mbsr_table_value(road, t, s, sdot, sddot);
}

/* Deflection of tyre, spring and mount together at TIMES times, m; returns the steps. */
static long drive(mbsr_table_kind kind, int known, double tolerance, double *deflection)
{
    static double t[POINTS], height[POINTS];
    const double up[3] = {0, 0, 1};
    const mbsr_axis rise = {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 0, 1}, .driven = 1};
    const char *name[3] = {"carrier", "seat", "body"};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    measure(t, height);
    mbsr_table *road = mbsr_simulation_add_table(&s, kind, points, t, height);
    int body = mbsr_simulation_add_body(
        &s, "road", MBSR_GROUND,
        mbsr_joint_compound(NULL, NULL, 1, &rise, known ? mbsr_table_motion : hidden, road),
        mbsr_inertia_zero());
    for (int i = 0; i < 3; ++i) {
        body = mbsr_simulation_add_body(&s, name[i], body, mbsr_joint_prismatic(NULL, NULL, up),
                                        i < 2 ? mbsr_inertia_zero() : mbsr_inertia_particle(400.0));
        mbsr_simulation_add_force(&s, mbsr_force_joint_spring(body, 0, k[i], d[i], 0.0));
    }
    opt.rtol = opt.atol = tolerance;
    mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
    for (int n = 0; n < TIMES && !mbsr_simulation_to(&s, 0.01 * (points - 1) * (n + 0.93) / TIMES);
         ++n)
        deflection[n] = s.q[0] + s.q[1] + s.q[2];
    if (s.status) {
        fprintf(stderr, "%s\n", s.error.text);
        exit(1);
    }
    mbsr_ida_stats stats;
    mbsr_simulation_get_stats(&s, &stats);
    const long steps = stats.steps;
    mbsr_simulation_end(&s);
    return steps;
}

/* Largest difference from the reference. */
static double differ(const double *a, const double *b)
{
    double largest = 0.0;
    for (int n = 0; n < TIMES; ++n) largest = fmax(largest, fabs(a[n] - b[n]));
    return largest;
}

int main(int argc, char **argv)
{
    (void)argv;
    if (argc > 1) points = 151;
    static const char *const name[3] = {"straight", "monotone", "spline"};
    double exact[TIMES], found[TIMES];
    int wrong = 0;
    printf("road       by a function           as a table\n");
    for (mbsr_table_kind kind = MBSR_TABLE_LINEAR; kind <= MBSR_TABLE_SPLINE; ++kind) {
        const int straight = kind == MBSR_TABLE_LINEAR;
        drive(kind, 1, 1e-10, exact);
        const long before = drive(kind, 0, 1e-6, found);
        const double blind = differ(found, exact);
        const long steps = drive(kind, 1, straight ? 1e-3 : 1e-6, found);
        const double known = differ(found, exact);
        printf("%-9s %6ld steps, %.0e m   %6ld steps, %.0e m\n", name[kind], before, blind, steps,
               known);
        wrong += steps > before || known > 1e-4 || (straight && steps > 4 * points);
    }
    return wrong;
}

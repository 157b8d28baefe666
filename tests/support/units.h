/* Four systems of units that models are tried in.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_UNITS_H
#define TEST_UNITS_H

/* How many of the new units make one SI unit. */
typedef struct units {
    const char *name;
    double length, mass, time;
} units;

static const units systems[] = {
    {"m, kg, s", 1, 1, 1},
    {"mm, t, s", 1e3, 1e-3, 1},
    {"km, kg, s", 1e-3, 1, 1},
    {"mm, g, ms", 1e3, 1e3, 1e3},
};

#endif

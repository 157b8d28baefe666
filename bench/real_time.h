/* Models of real time: a ragdoll, and two vehicles. Shared by bench_stepper and the tests of the
 * stepper.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef REAL_TIME_H
#define REAL_TIME_H

#include <mbsrank/mbsrank.h>

typedef struct real_time_scene {
    mbsr_model *model; /* finished */
    int nq, nu;
    double *q, *u; /* nq, nu: the state at the start */
    double
        *steer; /* N m, on the toe of the front wheels, held by the caller; NULL: not a vehicle */
    int trunk;  /* id of the pelvis, of the chassis */
} real_time_scene;

/* 20 bodies on ball joints and hinges with limits, each with a contact on the floor, thrown:
 * turning, 1.6 m high. */
real_time_scene real_time_ragdoll(void);

/* A tree of 13 bodies, 4 of them without mass, and 20 rubber bushings: chassis, and for each
 * wheel an arm without mass with strut, whose bearing gives way ahead and aside; an upright that
 * gives way in toe and camber; a wheel that gives way along its axle, with a tyre. 10 m/s on a
 * flat road. */
real_time_scene real_time_vehicle(void);

/* Multi-link suspensions: for each wheel five links without mass on universal joints, 20 in all,
 * held by ball closures to uprights that are free: 29 bodies, 60 rows. 10 m/s on a flat road. */
real_time_scene real_time_multilink(void);

void real_time_free(real_time_scene *scene);

#endif

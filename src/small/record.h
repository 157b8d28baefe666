/* The report on small masses: what it keeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Two twins of the model, with and without the candidates' masses, have additional force elements
 * that exert what they are told: wrenches on the candidates' bodies, joint forces on the bodies of
 * their directions. F of the momentum form is linear in these, so that differences of F are the
 * columns of loads for its Newton matrix. */
#ifndef MBSRI_SMALL_RECORD_H
#define MBSRI_SMALL_RECORD_H

#include "model/record.h"

#include <mbsrank/small_masses.h>

/* n numbers, value + (t - from) rate + (t - from)^2 / 2 bend, that an element exerts. */
typedef struct mbsri_small_load {
    int n;
    double from;
    double *value, *rate, *bend;
} mbsri_small_load;

/* What an error has been largest as. */
typedef struct mbsri_small_worst {
    double error, share, time;
    int output;
} mbsri_small_worst;

typedef struct mbsri_candidate {
    int body, i, parts; /* id, index, parts of its inertia */
    double ratio;
    bool held;             /* it keeps its mass: without it its motion is undetermined */
    mbsr_inertia left;     /* what of its inertia is left */
    mbsri_small_load load; /* on it, in both twins */
    double *force;         /* d: inertia force less weight, neglected, at the last state */
    double *impulse;       /* d: neglected momentum of the start given against the reduced one */
    double *beside;        /* d: force at another time, for its rate */
    double *velocity;      /* d: V of the last state */
    double *rest, *mean;   /* d: force without the part by acceleration, and that by the mean one */
    double *error[3];      /* size: first-order change of y, at this state and the two before */
    double *offset;        /* size: the same at the start, of what is fast alone */
    mbsri_small_worst worst;
    double steps, now; /* that its zero has saved so far, and in the last step */
} mbsri_candidate;

/* A body whose joint rates are directions of a candidate. */
typedef struct mbsri_pushed {
    int i, candidate;
    mbsri_small_load push; /* on its joint, in both twins */
} mbsri_pushed;

/* A lightly damped direction (slow.h). */
typedef struct mbsri_light {
    int q, u;              /* places of its coordinate and rate */
    double relaxation;     /* d / k */
    double rate[4];        /* its slow rate and three derivatives of that, at the start */
    double kept[4];        /* ... without load */
    double position[5];    /* where it is at five times */
    const double *pattern; /* size: what moves with its coordinate (q) and rate (u) while all masses
                              stay */
} mbsri_light;

/* The fast motion of a direction along a run (swings.c). */
typedef struct mbsri_swing {
    double re, im;       /* b */
    double load, rest;   /* w, and its part without acceleration */
    double before, size; /* of the swing, in tolerances of the integrator */
} mbsri_swing;

typedef struct mbsri_twin {
    mbsr_model *model;
    mbsr_data *data;
    mbsr_newton *newton;
} mbsri_twin;

struct mbsr_small_masses {
    const mbsr_model *given;
    mbsr_allocator allocator;
    mbsr_small_masses_opt opt; /* part and tolerance_each: copies in the block */
    mbsr_error error;

    int candidates, pushes, directions, outputs, size; /* size: of y */
    mbsri_candidate *candidate;
    mbsri_pushed *pushed;
    mbsr_small_direction *direction;
    double *tolerance; /* of outputs */
    mbsri_twin full, reduced;
    mbsr_model *clean; /* the reduced model for the caller's run */
    struct {
        int count;
        mbsri_light *each; /* lightly damped directions, with room for all */
        double *wanted;    /* one number of each */
        double c;          /* of the factorisation that the reduced twin's solver has */
    } slow;
    struct {
        mbsri_swing *each; /* of each direction */
        double *pattern;   /* size a direction: what moves with its coordinate */
        double *scale;     /* of the inertia of each direction's joint */
        double *impedance; /* 4 a direction */
    } swings;

    /* the run so far */
    struct {
        bool known;
        double t;
        double *q, *u; /* nq, nu: as given */
    } start;
    struct {
        int states;
        double t[3]; /* of this state and of the two before */
    } run;
    double *y, *yp, *y_full, *yp_full; /* size: the state, without and with the masses */
    struct {
        double *along[3]; /* nu: generalised force, rest and mean */
        double *scale;    /* nu: scale of inertia in the reduced model */
        double *momentum; /* nu: p of the last state */
        double *tested;   /* nu: its change in tolerances */
    } rates;
    struct {
        double saved;            /* steps of all zeros so far */
        mbsri_small_worst worst; /* of all zeros together */
    } zeros;
    struct {
        long count, at_start;
    } factorised;
    struct {
        double *F, *F_loaded, *rhs, *total, *slope; /* size */
        double *trial;                              /* 3 size */
        double *kept;                               /* 2 size: y, yp while there is a load */
        double *above, *below;                      /* outputs, at a state displaced both ways */
        double *q, *u;                              /* nq, nu: displaced */
        double *load;                               /* the most numbers of a load */
    } work;
    struct {
        mbsr_small_mass *mass;
        char *text;
        size_t text_size;
    } report;
    double *numbers; /* the memory of all of the above that are numbers */
};

#endif

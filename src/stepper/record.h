/* The stepper: what it keeps.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_STEPPER_RECORD_H
#define MBSRI_STEPPER_RECORD_H

#include "model/record.h"

#include <mbsrank/stepper.h>

/* What energy may be there: see energy.c. */
typedef struct mbsri_stepper_account {
    bool served;   /* all that feeds energy is known */
    bool fed;      /* some elements may feed it */
    double energy; /* J, that the tree can have by what it had and was fed */
    double scale;  /* J, kinetic energy that it has had and has not lost since */
} mbsri_stepper_account;

struct mbsr_stepper {
    const mbsr_model *model;
    mbsr_data *data;
    mbsr_newton *newton;
    mbsr_stepper_opt opt;
    size_t size; /* length of y */
    bool started;
    double t, from;           /* s: of y; from where steps of opt.h are counted */
    long since;               /* steps of opt.h since then */
    double *y, *yp;           /* size each: the state, and its slopes */
    double *kept_y, *kept_yp; /* the same at the begin of a step */
    double *Y, *K, *base;     /* size each: a stage, its slopes, and what of Y is known */
    double *F, *delta;        /* size each: residual and correction */
    double *before;           /* size: the correction before */
    double *span;             /* nq + nu: over what size coordinates change; of rates but for 1/s */
    double *mean;             /* nu: mean of u over a substep */
    int age;                  /* substeps that the factorisation at hand has served */
    double factored;          /* c of the factorisation at hand, 1/s; 0: none */
    mbsri_stepper_account account, kept_account;
    mbsr_stepper_info info;
    mbsr_error error, cause; /* the last failure of a call; of an attempt */
    void *memory;
};

#endif

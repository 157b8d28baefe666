/* The driver's structure; what goes on from step to step is decided by control.h and stiff.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_RECORD_H
#define MBSRI_IDA_RECORD_H

#include <mbsrank/completion.h>
#include <mbsrank/ida.h>
#include <mbsrank/sundials.h>

#include "ida/compat.h"
#include "ida/kinks_record.h"

#include <nvector/nvector_serial.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>
#include <sundials/sundials_nonlinearsolver.h>

#include <stdbool.h>

/* The state as it is handed out, see outputs.h. */
typedef struct mbsri_ida_output {
    mbsr_completion *completion; /* NULL: as it was interpolated */
    N_Vector y, yp;              /* size */
    bool complete;               /* whether they are completed at the present time */
    bool tried;                  /* whether that was tried at the present time */
    long raw;                    /* states that could not be completed, since mbsr_ida_start */
    double since;                /* time of the last jump, s */
} mbsri_ida_output;

/* What tolerances are made of, see tolerances.c. */
typedef struct mbsri_ida_tolerances {
    N_Vector atol, mass; /* size */
    double
        time; /* s, in which a velocity that errs by its tolerance errs by that of its coordinate */
    bool scales; /* they follow the masses at the start, see mbsr_ida_opt */
} mbsri_ida_tolerances;

/* The linear solver, see linear.c. */
typedef struct mbsri_ida_linear {
    SUNMatrix matrix; /* NULL for KRYLOV */
    SUNLinearSolver solver;
    mbsr_sundials link;   /* its newton is NULL for DENSE */
    mbsr_newton *tangent; /* DENSE, momentum form: its derivatives where there are any, or NULL */
    mbsr_newton_info newton_before; /* at the start of the run */
} mbsri_ida_linear;

typedef struct mbsri_ida_count_record {
    long residuals, events;
    long central_residuals; /* of these, for central differences */
    mbsr_ida_stats before;  /* what IDA had counted when its history was last thrown away */
} mbsri_ida_count_record;

/* Where the run is. */
typedef struct mbsri_ida_run {
    bool started; /* a state is set and no step from it has failed for good */
    bool failed;  /* a step has failed for good; y and yp are the last good state */
    bool stepped; /* IDASolve was called since */
    bool event;   /* the last call of mbsr_ida_advance ended in an event */
    double present;
    double direction;           /* +1 or -1 once stepped */
    N_Vector first_y, first_yp; /* the state from which IDA started last */
} mbsri_ida_run;

/* What failed in a callback. */
typedef struct mbsri_ida_failing {
    int callback; /* status of the last evaluation of the residual or of the event functions */
    mbsr_error failure;           /* what is known of it when it is not zero */
    double wall;                  /* time of the last recoverable failure of the residual */
    int blocked;                  /* failures in a row at time `wall`, but for rounding */
    char message[MBSR_TEXT_SIZE]; /* IDA's last message in the present call */
} mbsri_ida_failing;

/* The last call of the progress function. */
typedef struct mbsri_ida_reported {
    long steps;
    double at;    /* real time, s; where progress_interval asks for it */
    bool stopped; /* it ended the last call of mbsr_ida_advance */
    int still;    /* steps in a row, up to the last one, that did not move the time */
} mbsri_ida_reported;

/* For mbsr_ida_get_drift. */
typedef struct mbsri_ida_drift_record {
    double first_energy, largest_gap;
    long steps;    /* IDA's, when the gap was looked at last */
    bool measured; /* the energy is known */
} mbsri_ida_drift_record;

/* The last look at closures. */
typedef struct mbsri_ida_look {
    long steps;
    double at;          /* its time, s */
    double longest_way; /* the longest between two looks, s */
} mbsri_ida_look;

struct mbsr_ida {
    const mbsr_model *model;
    mbsr_data *data;
    mbsr_ida_opt opt; /* atol_each is not kept: see tol; linear_solver is what AUTO became */
    int size;         /* length of y */
    SUNContext context;
    void *memory; /* IDA's own */
    mbsri_ida_messages messages;
    N_Vector y, yp;                 /* size: the state at run.present */
    N_Vector work, displaced, zero; /* size */
    mbsri_ida_tolerances tol;
    mbsri_ida_kinks kinks;
    mbsri_ida_output output;
    mbsri_ida_linear linear;
    SUNNonlinearSolver nonlinear; /* see stiff.h */
    mbsri_ida_count_record count;
    mbsri_ida_run run;
    mbsri_ida_failing failing;
    mbsri_ida_reported report;
    mbsri_ida_drift_record drift;
    mbsri_ida_look look;
    int watch;    /* the watch of ranks that is not in force, see watch.h */
    int *watched; /* its ranks, as many as bodies */
    int *dropped; /* rows of closures that are left out, as many as rows */
    bool turns;   /* index-1 form: one more event function watches the reference */
    mbsr_error error;
    int rising[]; /* opt.events + 1: directions of the last event; the last for `turns` */
};

/* Below this cosine between its bases and the reference, the reference of the index-1 form is
 * renewed: about 60 degrees. */
#define MBSRI_IDA_TURNED 0.5

#endif

/* One instance of an FMU, whatever version of the standard it is called by.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The plan is read from the resources, and a model is built of it. The initialisation makes another
 * one where parameters have changed. From the start on the state is q and u at t (model
 * exchange: x = (q, p) of ode.h); the data is evaluated when something is asked for. Functions
 * return MBSRI_OK or what is wrong, after a message. */
#ifndef MBSRI_FMU_INSTANCE_H
#define MBSRI_FMU_INSTANCE_H

#include "base/format.h"
#include "fmu/build.h"
#include "fmu/variables.h"

#include <mbsrank/completion.h>
#include <mbsrank/derivatives.h>
#include <mbsrank/ida.h>
#include <mbsrank/ode.h>
#include <mbsrank/stepper.h>

/* The numbers that the status has in both versions. */
typedef enum mbsri_result {
    MBSRI_OK,
    MBSRI_WARNING,
    MBSRI_DISCARD,
    MBSRI_ERROR,
    MBSRI_FATAL
} mbsri_result;

/* A step of the driver has ended, and an intermediate update is wanted: what its callback returns.
 */
enum { MBSRI_PAUSE = 1 };

/* Categories of messages; bits. */
enum {
    MBSRI_LOG_EVENTS = 1,
    MBSRI_LOG_WARNING = 2,
    MBSRI_LOG_DISCARD = 4,
    MBSRI_LOG_ERROR = 8,
    MBSRI_LOG_ALL = 15
};

/* States of the calling sequence; bits. After an error, and after fmi3Terminate, the instance is
 * TERMINATED. */
typedef enum mbsri_unit_mode {
    MBSRI_INSTANTIATED = 1,
    MBSRI_INITIALIZATION = 2,
    MBSRI_EVENT_MODE = 4,
    MBSRI_CONTINUOUS = 8, /* model exchange, between events */
    MBSRI_STEP = 16,      /* co-simulation, at a communication point */
    MBSRI_TERMINATED = 32,
    MBSRI_INTERMEDIATE = 64, /* within a step, called by the importer's callback */
    MBSRI_INITIALIZED = 28
} mbsri_unit_mode;

typedef struct mbsri_instance mbsri_instance;

/* Hands a message to the importer. */
typedef void (*mbsri_logger)(mbsri_instance *in, mbsri_result result, const char *category,
                             const char *text);

/* Tells the importer of a step inside; *early: it wants control back at *time, not before. */
typedef void (*mbsri_intermediate)(mbsri_instance *in, double t, bool *early, double *time);

struct mbsri_instance {
    char *name;
    bool exchange; /* model exchange */
    mbsri_unit_mode mode;
    struct {
        unsigned log; /* categories that it wants */
        mbsri_logger logger;
        void *environment;
        void (*callback)(void), (*updater)(void); /* its functions, to be cast to their types */
        mbsri_intermediate intermediate;          /* NULL: none is wanted */
        bool event_mode, early_return;            /* whether it handles them */
    } importer;
    struct {
        unsigned char *bytes; /* the plan */
        size_t size;
    } resources;
    mbsri_unit_plan plan;
    mbsri_variables variables;

    mbsri_built built;
    struct {
        double *value;   /* as they are set */
        double *changed; /* scratch: values, and in `which` numbers, of those not as in the plan */
        int *which;
        bool stale; /* they have changed since the model was built */
    } parameters;
    struct {
        mbsr_data *data, *event_data;
        mbsr_completion *completion;
        mbsr_ida *ida;         /* driver of co-simulation with steps by the error */
        mbsr_stepper *stepper; /* with fixed ones, and of sources */
        mbsr_ode *ode;         /* right-hand side of model exchange */
        mbsr_newton *newton;   /* derivatives, made when they are asked for */
        mbsr_derivatives *forward;
    } solver;

    struct {
        double t, *q, *u; /* asked for: nq, nu */
    } start;
    double t, tolerance;                        /* tolerance 0: that of the plan */
    double h;                                   /* s, the next step of sources; 0: not known */
    double *input;                              /* as many as the plan has */
    double *t_motion;                           /* when those of each motion were set */
    bool inputs_changed;                        /* since the last step */
    double *q, *u, *udot, *lambda, *x, *y, *yp; /* the state, and what is evaluated there */
    double *work;   /* three times y, and an indicator for each element */
    int size, rows; /* lengths of y and of lambda */
    bool started;   /* y and yp are a state that the solvers may start from */
    bool evaluated; /* udot, lambda and the data are of q, u, t and the inputs */
    bool fresh;     /* the driver begins anew from y and yp */
};

/* Whether co-simulation tells events: it has stops or contacts, and steps by the error. */
bool mbsri_has_events(const mbsri_instance *in);

/* A message: an event, or the reason of a result that is not MBSRI_OK, which is returned. After an
 * error the instance is terminated. */
void mbsri_tell(mbsri_instance *in, const char *format, ...) MBSRI_FORMAT(2, 3);
mbsri_result mbsri_say(mbsri_instance *in, mbsri_result result, const char *format, ...)
    MBSRI_FORMAT(3, 4);

/* A failure of the library, as an error; `of` may be NULL. */
mbsri_result mbsri_failed(mbsri_instance *in, const char *what, int status, const mbsr_error *of);

/* Tells the importer of a step that has ended at t; false: it wants control back there. *t_end
 * becomes the time at which it wants it later on. */
bool mbsri_update(mbsri_instance *in, double t, double *t_end);

enum { MBSRI_EITHER = -1 };

/* The instance c where a function may be called now, of model exchange (true), of co-simulation
 * (false) or of MBSRI_EITHER; else NULL, after a message where there is an instance. */
mbsri_instance *mbsri_entered(void *c, int exchange, unsigned modes, const char *function);

/* Categories by their names; false, after a message: there is no such one. count 0: all. */
bool mbsri_set_log(mbsri_instance *in, bool on, size_t count, const char *const *category);

#endif

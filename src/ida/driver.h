/* The driver's structure and what its source files share.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_DRIVER_H
#define MBSRI_IDA_DRIVER_H

#include <mbsrank/ida.h>
#include <mbsrank/sundials.h>

#include "compat.h"

#include <nvector/nvector_serial.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include <stdbool.h>

#if defined(__GNUC__)
#define MBSRI_IDA_FORMAT(a, b) __attribute__((format(printf, a, b)))
#else
#define MBSRI_IDA_FORMAT(a, b)
#endif

struct mbsr_ida {
    const mbsr_model *model;
    mbsr_data *data;
    mbsr_ida_opt opt; /* atol_each is not kept: see atol; linear_solver is what AUTO became */
    int size;         /* length of y */

    SUNContext context;
    void *memory;                                  /* IDA's own */
    N_Vector y, yp, atol, work, moved, zero, mass; /* size; y and yp are the state at `present` */
    SUNMatrix matrix;                              /* NULL for KRYLOV */
    SUNLinearSolver solver;
    mbsr_sundials link;             /* its newton is NULL for DENSE */
    mbsr_newton_info newton_before; /* at the start of the run */
    mbsri_ida_messages messages;
    char message[MBSR_TEXT_SIZE]; /* IDA's last message in the present call */

    bool watches; /* the ranks of data are watched on behalf of this driver */
    bool scales;  /* tolerances follow the masses at the start, see mbsr_ida_opt */
    bool started; /* a state is set and no step from it has failed for good */
    bool stepped; /* IDASolve was called since */
    bool event;   /* the last call of mbsr_ida_advance ended in an event */
    double present;
    double direction; /* +1 or -1 once stepped */
    long residuals, events;
    mbsr_ida_stats before; /* what IDA had counted when its history was last thrown away */
    bool turns;            /* index-1 form: one more event function watches the reference */

    long reported;      /* steps at the last call of the progress function */
    double reported_at; /* real time of it, s; where progress_interval asks for it */
    bool stopped;       /* it ended the last call */

    double wall; /* time of the last recoverable failure of the residual */
    int blocked; /* how many in a row were at the same time but for rounding */

    int callback; /* status of the last evaluation of the residual or of the event functions */
    mbsr_error failure; /* what is known of it when it is not zero */
    mbsr_error error;
    int rising[]; /* opt.events + 1: directions of the last event; the last for `turns` */
};

/* Below this cosine between its bases and the reference, the reference of the index-1 form is
 * renewed: about 60 degrees. */
#define MBSRI_IDA_TURNED 0.5

/* Adds what IDA has counted so far to *stats. */
void mbsri_ida_count(const mbsr_ida *ida, mbsr_ida_stats *stats);

/* Writes *error (if not NULL) and returns status. */
int mbsri_ida_fail(mbsr_error *error, int status, int body, int force, const char *format, ...)
    MBSRI_IDA_FORMAT(5, 6);

/* MBSR_ERR_SOLVER, or MBSR_ERR_NO_MEMORY for IDA_MEM_FAIL; the text has the name of IDA's flag and
 * its message. */
int mbsri_ida_solver_failed(const mbsr_ida *ida, mbsr_error *error, int flag, const char *function);

/* Name of an IDA flag into a buffer of MBSRI_IDA_FLAG; returns the buffer. */
enum { MBSRI_IDA_FLAG = 32 };
const char *mbsri_ida_flag_name(int flag, char *buffer);

/* Refuses options that make no sense. `size`: length of y. */
int mbsri_ida_check(const mbsr_ida_opt *opt, int size, mbsr_error *error);

/* ---- callbacks.c: as IDA calls them; `user` is the driver ---- */

int mbsri_ida_residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, void *user);
int mbsri_ida_events(sunrealtype t, N_Vector y, N_Vector yp, sunrealtype *value, void *user);

/* Notes the failure of an evaluation at t; what the callback has to return to IDA. */
int mbsri_ida_failed(mbsr_ida *ida, double t, int status, const mbsr_error *error,
                     const char *what);

/* ---- tolerances.c ---- */

/* Absolute tolerances that the options say, and from the data at mbsr_backward those of what stands
 * beside q and u: errors that atol in a velocity makes, momenta with the mass on their joint,
 * index-1 velocities with its square root. */
void mbsri_ida_set_tolerances(mbsr_ida *ida);
void mbsri_ida_scale_tolerances(mbsr_ida *ida);

/* Tolerance of entry k at y, and IDA's weights, its reciprocals. A momentum is tested with the
 * error it makes in its joint's velocity: mass (rtol |u| + atol). */
double mbsri_ida_tolerance(const mbsr_ida *ida, const double *y, int k);
int mbsri_ida_weights(N_Vector y, N_Vector weight, void *user);

/* Norm of the first n entries of x as in IDA's error test. */
double mbsri_ida_norm(const mbsr_ida *ida, int n, const double *x);

/* Vectors cloned from v measure by the largest entry where IDA calls for a root mean square. */
void mbsri_ida_use_max_norm(N_Vector v);

/* ---- linear.c ---- */

/* Decides on the linear solver and makes it; hands it to IDA (an IDA flag). */
int mbsri_ida_make_solver(mbsr_ida *ida, mbsr_error *error);
int mbsri_ida_attach_solver(mbsr_ida *ida);

/* What the Newton solver has counted; zero where there is none. */
void mbsri_ida_count_solver(const mbsr_ida *ida, mbsr_newton_info *info);

/* ---- advance.c ---- */

/* mbsr_ida_advance to a finite time after a start; the state stays in the driver. */
int mbsri_ida_advance(mbsr_ida *ida, double t_end);
void mbsri_ida_put(const mbsr_ida *ida, double *t, double *y, double *yp);

/* Whether two times differ by no more than rounding, as IDA sees it. */
bool mbsri_ida_same_time(double a, double b);

/* ---- run.c ---- */

/* Calls the progress function if it is due; its status. */
int mbsri_ida_report(mbsr_ida *ida);
void mbsri_ida_report_anew(mbsr_ida *ida);

#endif

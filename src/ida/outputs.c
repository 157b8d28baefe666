/* States as they are handed out: see outputs.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/outputs.h"

#include "ida/error.h"
#include "ida/tolerances.h"
#include "ida/vectors.h"
#include "ida/watch.h"

#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <string.h>

int mbsri_ida_make_outputs(mbsr_ida *ida, mbsr_error *error)
{
    mbsri_ida_output *o = &ida->output;
    if (ida->opt.raw_outputs) return MBSR_OK;
    N_Vector *const vector[] = {&o->y, &o->yp};
    for (size_t k = 0; k < sizeof vector / sizeof vector[0]; ++k) {
        *vector[k] = N_VNew_Serial(ida->size, ida->context);
        if (!*vector[k])
            return mbsri_ida_refuse(error, MBSR_ERR_NO_MEMORY,
                                    "mbsr_ida_create: no memory for a state of size %d", ida->size);
        mbsri_ida_use_own_operations(*vector[k]);
    }
    mbsr_newton_opt newton = ida->opt.newton;
    newton.together = 0; /* accelerations come of one solution */
    return mbsr_completion_create(ida->model,
                                  ida->opt.linear_solver == MBSR_IDA_DENSE ? NULL : &newton,
                                  &o->completion, error);
}

void mbsri_ida_free_outputs(mbsr_ida *ida)
{
    mbsri_ida_output *o = &ida->output;
    mbsr_completion_destroy(o->completion);
    if (o->y) N_VDestroy(o->y);
    if (o->yp) N_VDestroy(o->yp);
}

/* The span of time in which nothing jumps, around the present; the time that stands for it, which
 * is before a kink. */
static double look_around(mbsr_ida *ida)
{
    const mbsri_ida_kinks *k = &ida->kinks;
    const double way = ida->run.direction, before = ida->run.present - way * k->gap,
                 t = k->reached ? before : ida->run.present, begin = ida->output.since,
                 end = k->reached                    ? before
                       : k->known && isfinite(k->at) ? k->at - way * k->gap
                                                     : way * INFINITY;
    const mbsr_completion_times times = {
        .from = fmin(begin, end), .to = fmax(begin, end), .follow = 1};
    mbsr_completion_set_times(ida->output.completion, &times);
    return t;
}

/* Whether closures have stiff rows. */
static bool has_stiff_rows(const mbsr_ida *ida)
{
    for (int c = 0; c < mbsr_model_closures(ida->model); ++c) {
        int row, rows;
        mbsr_closure_indices(ida->model, c, &row, &rows, NULL, NULL);
        for (int k = 0; k < rows; ++k) {
            if (mbsr_closure_stiffness(ida->model, c, k) > 0.0) return true;
        }
    }
    return false;
}

/* The state as it was interpolated, into the output. */
static void copy_raw(mbsr_ida *ida)
{
    N_VScale(1.0, ida->y, ida->output.y);
    N_VScale(1.0, ida->yp, ida->output.yp);
}

/* The state as it was interpolated between the ends of the last step, stiff springs relaxed. */
static int relax(mbsr_ida *ida, double t)
{
    mbsri_ida_output *o = &ida->output;
    double end = 0.0, step = 0.0;
    IDAGetCurrentTime(ida->memory, &end);
    IDAGetLastStep(ida->memory, &step);
    const double way = fmin(fabs(t - (end - step)), fabs(end - t)), least = 1e-3 * fabs(step);
    copy_raw(ida);
    return mbsr_completion_relax(o->completion, ida->data, t, ida->run.direction / fmax(way, least),
                                 N_VGetArrayPointer(o->y), N_VGetArrayPointer(o->yp));
}

/* Largest |x_k| s over the tolerances of the entries first .. last - 1. */
static double tolerances(const mbsr_ida *ida, const double *x, double s, int first, int last)
{
    const double *y = N_VGetArrayPointer(ida->y);
    double largest = 0.0;
    for (int k = first; k < last; ++k)
        largest = fmax(largest, fabs(x[k]) * s / mbsri_ida_tolerance(ida, y, k));
    return largest;
}

/* By how much in tolerances the completed state would change in a step more than the interpolation
 * does, over what is common: of momenta, where stiff elements are strained by errors of positions;
 * where dampers hold what has no mass, of positions and velocities too. What gives way to springs
 * through dampers, at rates k / d, has velocities that are off by k / d times errors of positions,
 * and accelerations by (k / d)^2 times these; interpolated velocities there are rough. */
static double strain(mbsr_ida *ida)
{
    static const double of_positions = 3.0, of_momenta = 30.0, of_velocities = 1000.0;
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    double step = 0.0, *change = N_VGetArrayPointer(ida->work);
    mbsr_completion_info info;
    if (ida->opt.form != MBSR_DAE_MOMENTUM) return 0.0;
    IDAGetLastStep(ida->memory, &step);
    mbsr_completion_get_info(ida->output.completion, &info);
    N_VLinearSum(1.0, ida->output.yp, -1.0, ida->yp, ida->work);
    const double momenta = tolerances(ida, change, fabs(step), nq, nq + nu) / of_momenta;
    if (!info.damped) return momenta;
    const double positions = tolerances(ida, change, fabs(step), 0, nq) / of_positions,
                 velocities =
                     tolerances(ida, change, fabs(step), nq + nu, nq + 2 * nu) / of_velocities;
    return fmax(momenta, fmax(positions, velocities));
}

static bool complete_at(mbsr_ida *ida, double t)
{
    mbsri_ida_output *o = &ida->output;
    return mbsr_completion_solve(o->completion, ida->data, ida->opt.form, t,
                                 N_VGetArrayPointer(o->y), N_VGetArrayPointer(o->yp)) == MBSR_OK;
}

/* The same state with its strain, which is so much, taken out where that leaves less, unless that
 * is far away: in a step that has passed over an impact momenta are off by what it changes. */
static void relieve(mbsr_ida *ida, double t, double strained)
{
    static const double far = 1000.0;
    mbsri_ida_output *o = &ida->output;
    const int controlled = mbsr_model_nq(ida->model) + mbsr_model_nu(ida->model);
    const int status = relax(ida, t);
    N_VLinearSum(1.0, o->y, -1.0, ida->y, ida->work);
    const double moved = tolerances(ida, N_VGetArrayPointer(ida->work), 1.0, 0, controlled);
    if (!status && moved <= far && complete_at(ida, t) && strain(ida) <= strained) return;
    copy_raw(ida);
    o->complete = complete_at(ida, t);
}

/* The joint accelerations among y' of a form; NULL where it has others. */
static const double *accelerations_of(const mbsr_ida *ida, const double *yp)
{
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    switch (ida->opt.form) {
    case MBSR_DAE_MOMENTUM: return yp + nq + nu;
    case MBSR_DAE_RECURSIVE:
    case MBSR_DAE_INVERSE_DYNAMICS: return yp + nq;
    case MBSR_DAE_INDEX1: break;
    }
    return NULL;
}

/* The state as it is, in joint coordinates; the data is at its accelerations. */
static int show_raw(mbsr_ida *ida, double *q, double *u, double *udot, double *lambda)
{
    const mbsr_model *m = ida->model;
    mbsr_data *d = ida->data;
    const double *y = N_VGetArrayPointer(ida->y), *yp = N_VGetArrayPointer(ida->yp),
                 *rates = accelerations_of(ida, yp);
    const size_t nq = (size_t)mbsr_model_nq(m), nu = (size_t)mbsr_model_nu(m);
    double *own = N_VGetArrayPointer(ida->displaced);
    const bool closed = mbsr_model_rows(m) > 0;
    double *work = N_VGetArrayPointer(ida->work);
    int status = mbsr_dae_unpack(m, d, ida->opt.form, ida->run.present, y, own, own + nq);
    if (!status && !closed)
        status = mbsr_inverse_dynamics(m, d, ida->run.present, own, own + nq, rates, NULL, work);
    if (!status && closed)
        status = mbsr_dae_residual(m, d, ida->opt.form, ida->run.present, y, yp, work);
    if (!status && closed) status = mbsr_stage_accelerations(m, d, rates);
    if (!status && closed && lambda) status = mbsr_closures_lambda(m, d, lambda);
    if (status)
        return mbsri_ida_pass_on(&ida->error, status, mbsr_data_error(d), "mbsr_ida_motion");
    if (q) memcpy(q, own, nq * sizeof *q);
    if (u) memcpy(u, own + nq, nu * sizeof *u);
    if (udot) memcpy(udot, rates, nu * sizeof *udot);
    return MBSR_OK;
}

/* The start, completed for the form whose y' has no joint accelerations. */
static int complete_start(mbsr_ida *ida)
{
    mbsri_ida_output *o = &ida->output;
    N_VScale(1.0, ida->y, o->y);
    N_VScale(1.0, ida->yp, o->yp);
    const int status =
        mbsr_completion_solve(o->completion, ida->data, ida->opt.form, ida->run.present,
                              N_VGetArrayPointer(o->y), N_VGetArrayPointer(o->yp));
    if (!status) return MBSR_OK;
    return mbsri_ida_pass_on(&ida->error, status, mbsr_completion_error(o->completion),
                             "mbsr_ida_motion: the start");
}

int mbsr_ida_motion(mbsr_ida *ida, double *q, double *u, double *udot, double *lambda)
{
    if (!ida) return MBSR_ERR_NULL;
    if (!ida->run.started && !ida->run.failed)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_SEQUENCE,
                                "mbsr_ida_motion: call mbsr_ida_start first");
    mbsri_ida_complete(ida);
    if (ida->output.complete)
        return mbsr_completion_motion(ida->output.completion, ida->data, q, u, udot, lambda);
    if (ida->opt.form != MBSR_DAE_INDEX1) return show_raw(ida, q, u, udot, lambda);
    if (!ida->output.completion || ida->run.failed)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_VALUE,
                                "mbsr_ida_motion: the index-1 form has no joint accelerations of "
                                "its own, and raw_outputs is set");
    const int status = complete_start(ida);
    return status ? status
                  : mbsr_completion_motion(ida->output.completion, ida->data, q, u, udot, lambda);
}

void mbsri_ida_complete(mbsr_ida *ida)
{
    mbsri_ida_output *o = &ida->output;
    if (!o->completion || o->complete || o->tried || !ida->run.stepped) return;
    const double t = look_around(ida);
    o->tried = true;
    mbsri_ida_exchange_watch(ida);
    if (!has_stiff_rows(ida) || relax(ida, t)) copy_raw(ida);
    o->complete = complete_at(ida, t);
    const double strained = o->complete && !has_stiff_rows(ida) ? strain(ida) : 0.0;
    if (strained > 1.0) relieve(ida, t, strained);
    mbsri_ida_exchange_watch(ida);
    o->raw += !o->complete;
}

/* Creation and destruction of the driver.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With error_test.c and nonlinear.c, whose objects SUNDIALS wants in memory of their own, the only
 * file of the component that takes memory. */
#include "ida/callbacks.h"
#include "ida/shift.h"
#include "ida/compat.h"
#include "ida/differences.h"
#include "ida/error.h"
#include "ida/linear.h"
#include "ida/options.h"
#include "ida/outputs.h"
#include "ida/stiff.h"
#include "ida/tolerances.h"
#include "ida/vectors.h"

#include <stdlib.h>

/* Keeps the message of an error; warnings, which have positive codes, are dropped. */
static void receive(void *user, int code, const char *message)
{
    mbsr_ida *ida = user;
    if (code > 0) return;
    size_t k = 0;
    for (; k + 1 < sizeof ida->failing.message && message[k]; ++k) {
        ida->failing.message[k] = message[k] == '\n' ? ' ' : message[k];
    }
    ida->failing.message[k] = '\0';
    mbsri_ida_point_numbers(ida->failing.message);
}

/* Refuses arguments from which no driver can be made. */
static int check_arguments(const mbsr_model *model, const mbsr_data *data, const mbsr_ida_opt *opt,
                           mbsr_ida **ida, mbsr_error *error)
{
    if (!model || !data || !ida)
        return mbsri_ida_refuse(error, MBSR_ERR_NULL, "mbsr_ida_create: %s is NULL",
                                !model  ? "model"
                                : !data ? "data"
                                        : "ida");
    if (opt->cookie != mbsr_default_ida_opt().cookie)
        return mbsri_ida_refuse(error, MBSR_ERR_NO_DEFAULT,
                                "mbsr_ida_create: opt was not made by mbsr_default_ida_opt");
    if (mbsr_model_bodies(model) < 0)
        return mbsri_ida_refuse(error, MBSR_ERR_UNFINISHED,
                                "mbsr_ida_create: the model is not finished");
    const int size = mbsr_dae_size(model, opt->form);
    if (size < 0)
        return mbsri_ida_refuse(error, MBSR_ERR_VALUE,
                                mbsr_model_rows(model) > 0
                                    ? "mbsr_ida_create: form is %d, but the model has closures, "
                                      "which only MBSR_DAE_MOMENTUM takes"
                                    : "mbsr_ida_create: form is %d, no such form",
                                (int)opt->form);
    if (size == 0)
        return mbsri_ida_refuse(error, MBSR_ERR_VALUE,
                                "mbsr_ida_create: the model has no joint coordinates to integrate");
    return mbsri_ida_check(opt, size, error);
}

static int no_memory_for(const mbsr_ida *ida, mbsr_error *error, const char *what)
{
    return mbsri_ida_refuse(error, MBSR_ERR_NO_MEMORY,
                            "mbsr_ida_create: no memory for %s of size %d", what, ida->size);
}

/* Newton's method for stiff elements, in the forms that it serves; false without memory. */
static bool make_nonlinear(mbsr_ida *ida)
{
    const mbsr_ida_opt *opt = &ida->opt;
    const bool accelerations =
        opt->form == MBSR_DAE_RECURSIVE || opt->form == MBSR_DAE_INVERSE_DYNAMICS;
    ida->nonlinear = mbsri_stiff_create(ida->model, opt->form, ida->y, ida->context);
    if (!ida->nonlinear) return false;
    if (mbsr_model_rows(ida->model) > 0) return true; /* the rest: mbsri_ida_take_care */
    mbsri_stiff *stiff = mbsri_stiff_of(ida->nonlinear);
    stiff->low_order = opt->max_order < 3;
    mbsri_ida_judge_matrix(ida);
    mbsri_stiff_set_rtol(stiff, opt->rtol);
    if (accelerations) {
        stiff->weigh = mbsri_ida_weigh;
        stiff->control.looks = false;
    }
    if (opt->linear_solver == MBSR_IDA_DENSE) {
        stiff->prepare = mbsri_ida_use_central;
        stiff->user = ida;
    }
    return true;
}

enum { VECTORS = 9 };

static void list_vectors(mbsr_ida *ida, N_Vector *vector[VECTORS])
{
    N_Vector *const all[VECTORS] = {&ida->y,        &ida->yp,          &ida->tol.atol,
                                    &ida->work,     &ida->displaced,   &ida->zero,
                                    &ida->tol.mass, &ida->run.first_y, &ida->run.first_yp};
    for (int k = 0; k < VECTORS; ++k) vector[k] = all[k];
}

/* SUNDIALS' objects; a failure leaves those made so far to mbsr_ida_destroy. */
static int make_objects(mbsr_ida *ida, mbsr_error *error)
{
    ida->messages = (mbsri_ida_messages){receive, ida};
    if (!mbsri_ida_context(&ida->context, &ida->messages)) {
        return no_memory_for(ida, error, "a SUNDIALS context for a problem");
    }
    N_Vector *vector[VECTORS];
    list_vectors(ida, vector);
    for (int k = 0; k < VECTORS; ++k) {
        *vector[k] = N_VNew_Serial(ida->size, ida->context);
        if (!*vector[k]) return no_memory_for(ida, error, "a vector");
        mbsri_ida_use_own_operations(*vector[k]);
        N_VConst(0.0, *vector[k]);
        if (ida->opt.max_norm) mbsri_ida_use_max_norm(*vector[k]); /* IDA clones it with them */
    }
    if (!mbsri_ida_make_kinks(ida))
        return no_memory_for(ida, error, "what kinks need for a problem");
    int status = mbsri_ida_make_solver(ida, error);
    if (!status) status = mbsri_ida_make_outputs(ida, error);
    if (status) return status;
    if (!make_nonlinear(ida)) return no_memory_for(ida, error, "Newton's method for a problem");
    ida->memory = IDACreate(ida->context);
    if (!ida->memory) return no_memory_for(ida, error, "IDA for a problem");
    return MBSR_OK;
}

/* Whether data belongs to model: mbsr_dae_id tells, which needs no state in these forms. */
static int check_data(const mbsr_model *model, mbsr_data *data, mbsr_error *error)
{
    const mbsr_dae_form form = mbsr_model_rows(model) > 0 ? MBSR_DAE_MOMENTUM : MBSR_DAE_RECURSIVE;
    const size_t n = (size_t)mbsr_dae_size(model, form);
    double *id = calloc(n, sizeof *id);
    if (!id)
        return mbsri_ida_refuse(error, MBSR_ERR_NO_MEMORY,
                                "mbsr_ida_create: no memory for %zu numbers", n);
    const int status = mbsr_dae_id(model, data, form, id);
    free(id);
    if (!status) return MBSR_OK;
    return mbsri_ida_refuse(error, status, "mbsr_ida_create: %s", mbsr_status_text(status));
}

/* How much of the error test Newton iterations may leave where loop forces are found by them: IDA's
 * own 0.33 costs 15 to 40 % more steps (docs/closed_loops.md). */
static const double CLOSED_LOOPS = 0.1;

/* Each failed test of a step makes it a quarter as long. IDA's own 10 are a millionth, too few for
 * a step of a hundredth of a second that hits a stop of 1e10 N/m. */
enum { MOST_FAILURES = 30 };

/* Hands the options to IDA; an IDA flag. */
static int configure(mbsr_ida *ida)
{
    const mbsr_ida_opt *opt = &ida->opt;
    void *const memory = ida->memory;
    int flag = mbsri_ida_redirect(memory, &ida->messages);
    if (flag >= 0) flag = IDAInit(memory, mbsri_ida_residual, 0.0, ida->y, ida->yp);
    if (flag >= 0) flag = IDAWFtolerances(memory, mbsri_ida_weights);
    if (flag >= 0) flag = IDASetUserData(memory, ida);
    if (flag >= 0) flag = mbsri_ida_attach_solver(ida);
    if (flag >= 0 && mbsr_model_rows(ida->model) > 0)
        flag = IDASetNonlinConvCoef(memory, CLOSED_LOOPS);
    if (flag >= 0) flag = IDASetNonlinearSolver(memory, ida->nonlinear);
    if (flag >= 0) flag = IDASetMaxOrd(memory, opt->max_order);
    if (flag >= 0) flag = IDASetMaxNumSteps(memory, opt->max_steps);
    if (flag >= 0) flag = IDASetMaxErrTestFails(memory, MOST_FAILURES);
    if (flag >= 0) flag = IDASetMaxStep(memory, opt->max_step);
    const int events = opt->events + (ida->turns ? 1 : 0);
    if (flag >= 0 && events > 0) {
        flag = IDARootInit(memory, events, mbsri_ida_events);
        if (flag >= 0) flag = IDASetNoInactiveRootWarn(memory);
    }
    return flag;
}

static int make(mbsr_ida *ida, mbsr_error *error)
{
    const int status = make_objects(ida, error);
    if (status) return status;
    mbsri_ida_set_tolerances(ida);
    const int flag = configure(ida);
    return flag < 0 ? mbsri_ida_solver_failed(ida, error, flag, "mbsr_ida_create") : MBSR_OK;
}

int mbsr_ida_create(const mbsr_model *model, mbsr_data *data, const mbsr_ida_opt *opt,
                    mbsr_ida **ida, mbsr_error *error)
{
    const mbsr_ida_opt standard = mbsr_default_ida_opt();
    if (!opt) opt = &standard;
    if (ida) *ida = NULL;
    int status = check_arguments(model, data, opt, ida, error);
    if (!status) status = check_data(model, data, error);
    if (status) return status;
    mbsr_ida *made = calloc(1, sizeof *made + ((size_t)opt->events + 1) * sizeof made->rising[0]);
    if (!made)
        return mbsri_ida_refuse(error, MBSR_ERR_NO_MEMORY,
                                "mbsr_ida_create: no memory for the driver");
    made->model = model;
    made->data = data;
    made->linear.link.data = data;
    made->opt = *opt;
    made->size = mbsr_dae_size(model, opt->form);
    made->turns = opt->form == MBSR_DAE_INDEX1;
    made->error = (mbsr_error){MBSR_OK, MBSR_NONE, MBSR_NONE, ""};
    made->watched = calloc((size_t)mbsr_model_bodies(model), sizeof *made->watched);
    made->dropped = calloc((size_t)mbsr_model_rows(model) + 1, sizeof *made->dropped);
    status = made->watched && made->dropped ? make(made, error)
                                            : no_memory_for(made, error, "the ranks of a problem");
    if (status) {
        mbsr_ida_destroy(made);
        return status;
    }
    *ida = made;
    return MBSR_OK;
}

void mbsr_ida_destroy(mbsr_ida *ida)
{
    if (!ida) return;
    if (ida->memory) IDAFree(&ida->memory);
    if (ida->nonlinear) SUNNonlinSolFree(ida->nonlinear);
    if (ida->linear.solver) SUNLinSolFree(ida->linear.solver);
    if (ida->linear.matrix) SUNMatDestroy(ida->linear.matrix);
    mbsr_newton_destroy(ida->linear.link.newton);
    mbsr_newton_destroy(ida->linear.tangent);
    N_Vector *vector[VECTORS];
    list_vectors(ida, vector);
    for (int k = 0; k < VECTORS; ++k)
        if (*vector[k]) N_VDestroy(*vector[k]);
    mbsri_ida_free_kinks(ida);
    mbsri_ida_free_outputs(ida);
    if (ida->context) SUNContext_Free(&ida->context);
    free(ida->watched);
    free(ida->dropped);
    free(ida);
}

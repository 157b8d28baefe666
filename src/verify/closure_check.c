/* A test of a closure's functions against differences.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "model/query.h"
#include "recursion/closure_differences.h"
#include "recursion/closure_rows.h"
#include "recursion/closures.h"

#include <mbsrank/verify.h>

#include <math.h>

typedef struct verifier {
    const mbsr_model *m;
    mbsr_data *d;
    const mbsri_closure *c;
    mbsri_closure_view view;
    mbsr_closure_errors *errors;
    double worst; /* so far */
} verifier;

/* The largest difference of `own` and `truth` (n numbers, every one of row k mod stride), relative
 * to the largest of all. */
static double compare_rows(verifier *w, const char *what, int stride, int rows, int n,
                           const double *own, const double *truth)
{
    double size = 0.0, largest = 0.0;
    for (int k = 0; k < n; ++k) size = fmax(size, fmax(fabs(own[k]), fabs(truth[k])));
    for (int k = 0; k < n; ++k) {
        if (k % stride >= rows) continue;
        const double off = fabs(own[k] - truth[k]) / fmax(size, 1e-3);
        if (off <= largest) continue; /* NaN counts */
        largest = off;
        if (off <= w->worst) continue;
        w->worst = off;
        mbsri_print(w->errors->text, sizeof w->errors->text,
                    "%s: row %d, column %d is %.9g, by differences %.9g", what, k % stride,
                    k / stride, own[k], truth[k]);
    }
    return largest;
}

static int verify_jacobian(verifier *w, double *truth)
{
    const mbsri_closure *c = w->c;
    const size_t size = (size_t)c->rows * (size_t)c->columns;
    if (!c->def.table->jacobian || c->position_rows == 0) return MBSR_OK;
    mbsri_zero(size, truth);
    const int status = mbsri_closure_slopes(w->m, c, &w->view, w->d->closure_x, truth);
    if (status) return mbsri_closure_failed(w->m, w->d, c, status, "position");
    w->errors->jacobian = compare_rows(w, "jacobian", c->rows, c->position_rows, (int)size,
                                       w->d->closure_C + c->at, truth);
    return MBSR_OK;
}

static int verify_drift(verifier *w)
{
    const mbsri_closure *c = w->c;
    double own[MBSR_CLOSURE_ROWS] = {0.0}, truth[MBSR_CLOSURE_ROWS] = {0.0};
    if (!c->def.table->drift || c->position_rows == 0) return MBSR_OK;
    int status = mbsri_closure_table_drift(c, &w->view.args, own);
    if (status) return mbsri_closure_failed(w->m, w->d, c, status, "drift");
    status = mbsri_closure_drift(w->m, c, &w->view, w->d->closure_x, truth);
    if (status) return mbsri_closure_failed(w->m, w->d, c, status, "position");
    w->errors->drift = compare_rows(w, "drift", c->rows, c->position_rows, c->rows, own, truth);
    return MBSR_OK;
}

static int verify_bias(verifier *w)
{
    const mbsri_closure *c = w->c;
    double own[MBSR_CLOSURE_ROWS] = {0.0}, truth[MBSR_CLOSURE_ROWS] = {0.0};
    if (!c->def.table->bias) return MBSR_OK;
    int status = mbsri_closure_table_bias(c, &w->view.args, own);
    if (status) return mbsri_closure_failed(w->m, w->d, c, status, "bias");
    status = mbsri_closure_curvature(w->m, w->d, c, &w->view, truth);
    if (status) return mbsri_closure_failed(w->m, w->d, c, status, "jacobian");
    w->errors->bias = compare_rows(w, "bias", c->rows, c->rows, c->rows, own, truth);
    return MBSR_OK;
}

int mbsr_closure_verify(const mbsr_model *model, mbsr_data *data, int closure,
                        mbsr_closure_errors *errors)
{
    static const char name[] = "mbsr_closure_verify";
    int status = mbsri_enter(model, data, errors != NULL, MBSRI_STAGE_VELOCITIES, name);
    if (status) return status;
    const mbsri_closure *c = mbsri_closure_of(model, closure);
    if (!c)
        return mbsri_fail(&data->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                          "%s: there is no closure %d", name, closure);
    status = mbsri_closure_jacobians(model, data);
    if (status) return status;
    const size_t size = (size_t)c->rows * (size_t)c->columns * sizeof(double);
    double *truth = mbsri_allocate(&model->allocator, size);
    if (!truth)
        return mbsri_fail(&data->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "%s: no memory",
                          name);
    *errors = (mbsr_closure_errors){.jacobian = 0.0};
    verifier w = {.m = model, .d = data, .c = c, .errors = errors};
    mbsri_view_closure(model, data, c, true, &w.view);
    status = verify_jacobian(&w, truth);
    if (!status) status = verify_drift(&w);
    if (!status) status = verify_bias(&w);
    mbsri_release(&model->allocator, truth);
    const double sum = errors->jacobian + errors->drift + errors->bias;
    if (!status && !isfinite(sum))
        return mbsri_fail(&data->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                          "%s: closure %d (%s): %s", name, closure, c->def.table->name,
                          errors->text);
    return status;
}

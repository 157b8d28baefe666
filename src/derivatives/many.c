/* Derivatives of forward dynamics at many states: states shared out among objects of one state.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/error.h"
#include "base/memory.h"
#include "base/threads.h"
#include "model/record.h"

#include <mbsrank/derivatives.h>

#include <math.h>

enum { INPUTS = 6, OUTPUTS = 4 };

/* What one worker has: an object, and the first failure among its states. */
typedef struct share {
    mbsr_derivatives *derivatives;
    int failed, result;
    mbsr_error error;
} share;

struct mbsr_derivatives_batch {
    const mbsr_model *model;
    mbsr_parallel parallel;
    int shares, failed;
    share *share;
    mbsr_error error;
};

typedef enum product { TANGENT, ADJOINT, MATRICES } product;

/* A call. in: q, u, tau and three directions, of TANGENT dq, du, dtau, of ADJOINT w; out: udot and
 * results, of TANGENT one. */
typedef struct request {
    mbsr_derivatives_batch *b;
    product product;
    double t;
    int states;
    const double *in[INPUTS];
    double *out[OUTPUTS];
    int *status;
} request;

/* ---- making ---- */

int mbsr_derivatives_batch_create(const mbsr_model *model, const mbsr_parallel *parallel,
                                  mbsr_derivatives_batch **batch, mbsr_error *error)
{
    static const char function[] = "mbsr_derivatives_batch_create";
    if (batch) *batch = NULL;
    if (!model || !batch)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", function,
                          model ? "batch" : "model");
    int status = parallel ? mbsri_parallel_check(parallel, function, error) : MBSR_OK;
    if (status) return status;
    const int workers = parallel ? parallel->workers : 1;
    mbsr_derivatives_batch *b = mbsri_allocate(&model->allocator, sizeof *b);
    share *shares = mbsri_allocate(&model->allocator, (size_t)workers * sizeof *shares);
    if (!b || !shares) {
        mbsri_release(&model->allocator, b);
        mbsri_release(&model->allocator, shares);
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d workers", function, workers);
    }
    *b = (mbsr_derivatives_batch){.model = model, .share = shares, .failed = -1};
    if (parallel) b->parallel = *parallel;
    while (b->shares < workers && !status) {
        shares[b->shares] = (share){.failed = -1};
        status = mbsr_derivatives_create(model, &shares[b->shares++].derivatives, error);
    }
    if (status)
        mbsr_derivatives_batch_destroy(b);
    else
        *batch = b;
    return status;
}

void mbsr_derivatives_batch_destroy(mbsr_derivatives_batch *batch)
{
    if (!batch) return;
    const mbsr_allocator allocator = batch->model->allocator;
    for (int k = 0; k < batch->shares; ++k) mbsr_derivatives_destroy(batch->share[k].derivatives);
    mbsri_release(&allocator, batch->share);
    mbsri_release(&allocator, batch);
}

/* ---- evaluating ---- */

/* Numbers of output k for a state. */
static size_t numbers_of_output(const request *r, int k)
{
    const size_t nu = (size_t)r->b->model->nu;
    return r->product == MATRICES && k > 0 ? nu * nu : nu;
}

static int evaluate_state(const request *r, mbsr_derivatives *d, int state)
{
    const mbsr_model *m = r->b->model;
    const double *in[INPUTS];
    double *out[OUTPUTS];
    for (int k = 0; k < INPUTS; ++k)
        in[k] = r->in[k] ? r->in[k] + (size_t)state * (size_t)(k == 0 ? m->nq : m->nu) : NULL;
    for (int k = 0; k < OUTPUTS; ++k)
        out[k] = r->out[k] ? r->out[k] + (size_t)state * numbers_of_output(r, k) : NULL;
    int status = mbsr_derivatives_forward(d, r->t, in[0], in[1], in[2], out[0], NULL);
    if (status) return status;
    switch (r->product) {
    case TANGENT: return mbsr_derivatives_tangent(d, in[3], in[4], in[5], out[1], NULL);
    case ADJOINT: return mbsr_derivatives_adjoint(d, in[3], NULL, out[1], out[2], out[3]);
    case MATRICES: return mbsr_derivatives_matrices(d, out[1], out[2], out[3]);
    }
    return MBSR_ERR_VALUE;
}

/* States k, k + shares, ... would mix the shares' cache lines: each takes a stretch. */
static void evaluate_share(void *arg, int which)
{
    const request *r = arg;
    share *s = r->b->share + which;
    const int each = r->states / r->b->shares, more = r->states % r->b->shares,
              first = which * each + (which < more ? which : more),
              end = first + each + (which < more);
    s->failed = -1;
    s->result = MBSR_OK;
    for (int state = first; state < end; ++state) {
        const int status = evaluate_state(r, s->derivatives, state);
        if (r->status) r->status[state] = status;
        if (status == MBSR_OK) continue;
        for (int k = 0; k < OUTPUTS; ++k) {
            const size_t n = numbers_of_output(r, k);
            for (size_t l = 0; l < n && r->out[k]; ++l) r->out[k][(size_t)state * n + l] = NAN;
        }
        if (s->failed >= 0) continue;
        s->failed = state;
        s->result = status;
        const mbsr_error *why = mbsr_derivatives_error(s->derivatives);
        (void)mbsri_fail(&s->error, status, why->body, why->force, "state %d: %.240s", state,
                         why->text);
    }
}

static int evaluate_all(const request *r, bool arguments, const char *function)
{
    mbsr_derivatives_batch *b = r->b;
    if (!b) return MBSR_ERR_NULL;
    if (!arguments || !r->in[0] || !r->in[1])
        return mbsri_fail(&b->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "%s: a required pointer is NULL", function);
    if (r->states < 1)
        return mbsri_fail(&b->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: states is %d, must be at least 1", function, r->states);
    if (b->shares > 1)
        b->parallel.run(b->parallel.user, b->shares, evaluate_share, (void *)r);
    else
        evaluate_share((void *)r, 0);
    b->failed = -1;
    for (int k = 0; k < b->shares; ++k) {
        if (b->share[k].failed < 0) continue;
        b->failed = b->share[k].failed;
        b->error = b->share[k].error;
        return b->share[k].result;
    }
    return MBSR_OK;
}

int mbsr_derivatives_batch_tangent(mbsr_derivatives_batch *batch, double t, int states,
                                   const double *q, const double *u, const double *tau,
                                   const double *dq, const double *du, const double *dtau,
                                   double *udot, double *dudot, int *status)
{
    return evaluate_all(
        &(request){batch, TANGENT, t, states, {q, u, tau, dq, du, dtau}, {udot, dudot}, status},
        dudot != NULL, "mbsr_derivatives_batch_tangent");
}

int mbsr_derivatives_batch_adjoint(mbsr_derivatives_batch *batch, double t, int states,
                                   const double *q, const double *u, const double *tau,
                                   const double *w, double *udot, double *by_q, double *by_u,
                                   double *by_tau, int *status)
{
    return evaluate_all(
        &(request){batch, ADJOINT, t, states, {q, u, tau, w}, {udot, by_q, by_u, by_tau}, status},
        w != NULL, "mbsr_derivatives_batch_adjoint");
}

int mbsr_derivatives_batch_matrices(mbsr_derivatives_batch *batch, double t, int states,
                                    const double *q, const double *u, const double *tau,
                                    double *udot, double *by_q, double *by_u, double *by_tau,
                                    int *status)
{
    return evaluate_all(
        &(request){batch, MATRICES, t, states, {q, u, tau}, {udot, by_q, by_u, by_tau}, status},
        true, "mbsr_derivatives_batch_matrices");
}

int mbsr_derivatives_batch_failed(const mbsr_derivatives_batch *batch)
{
    return batch ? batch->failed : -1;
}

const mbsr_error *mbsr_derivatives_batch_error(const mbsr_derivatives_batch *batch)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the batch is NULL"};
    return batch ? &batch->error : &none;
}

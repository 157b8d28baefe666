/* Diagnosis of the directions that move no mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With C = d gamma / d u and S = d gamma / d q along the null directions (null_space.h), directions
 * whose C and S do not couple are looked at apart. In each such component, with the errors of C and
 * S carried along (reduction.h):
 *
 *   rank of C               damped
 *   Y^T C = 0, C Z = 0      the others; of these the rank of Y^T S Z is elastic
 *   Y^T S Z x = 0           Z x is undetermined
 *
 * Mostly C = -B^T B, S = -A^T A with a row for what a damper or spring sees (element_rows.h). Then
 *
 *   rank of B               damped
 *   B Z = 0                 the others; of these the rank of A Z is elastic
 *   A Z x = 0               Z x is undetermined
 *
 * Damped directions are determined up to elastic and undetermined ones, and elastic up to
 * undetermined ones; which are shown is a choice (choose.c). */
#include "algebra/lapack.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "loops/refuse.h"
#include "massless/null_loops.h"
#include "massless/null_slopes.h"
#include "massless/open.h"
#include "massless/report_parts.h"
#include "model/query.h"
#include "recursion/not_finite.h"

#include <math.h>

/* Takes memory for everything but the null space; the doubles first. */
static int allocate_report(mbsri_report *r)
{
    const mbsr_model *m = r->w.m;
    const size_t k = (size_t)r->w.k;
    r->lwork = mbsri_lapack_svd_work(r->w.k > 0 ? r->w.k : 1);
    double **const array[] = {&r->C,       &r->values, &r->Y,       &r->Z,    &r->Y_error,
                              &r->Z_error, &r->x,      &r->sparse,  &r->u,    &r->twist,
                              &r->q_rate,  &r->other,  &r->weights, &r->size, &r->sizes,
                              &r->other_x, &r->span,   &r->work};
    const size_t length[] = {k * k,
                             k,
                             k * k,
                             k * k,
                             k * k,
                             k * k,
                             k,
                             k,
                             (size_t)m->nu,
                             m->size.v,
                             (size_t)m->nq,
                             (size_t)m->nu,
                             k * k,
                             m->size.v + (size_t)m->nq + (size_t)m->nu,
                             k,
                             k,
                             k,
                             (size_t)r->lwork};
    size_t total = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) total += length[l];
    const size_t reduced = mbsri_reduction_size(r->w.k, r->w.k) / sizeof(double) + 1,
                 tail = 2 * k * sizeof(int) + k * sizeof(mbsr_direction_kind) +
                        ((size_t)m->bodies + 1 + m->forces.count) * sizeof(bool);
    r->memory = mbsri_allocate(&m->allocator, (total + reduced) * sizeof(double) + tail);
    if (!r->memory) {
        return mbsri_fail(&r->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d null directions", r->w.function, r->w.k);
    }
    double *next = r->memory;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    mbsri_reduction_place(&r->reduced, r->w.k, r->w.k, next);
    next += reduced;
    r->component = (int *)(void *)next;
    r->member = r->component + k;
    r->kind = (mbsr_direction_kind *)(void *)(r->member + k);
    r->listed = (bool *)(void *)(r->kind + k);
    r->determining = r->listed + m->bodies + 1;
    return MBSR_OK;
}

/* All components; fills weights, kind, and the counts of the report. */
static int analyse(mbsri_report *r, double t, const double *q, const double *u,
                   mbsr_index_report *report)
{
    mbsri_null_space *w = &r->w;
    int status = MBSR_OK, independent = 0;
    const int all = w->k;
    if (w->loads.lambda) status = mbsri_null_loop_forces(w, t, q, u, &independent);
    if (!status) status = mbsri_null_basis(w, t, q, u);
    if (!status) status = mbsri_null_slopes(w, t, q, u);
    int components = 0;
    for (int l = 0; l < w->k; ++l) r->component[l] = -1;
    for (int l = 0; l < w->k && !status; ++l) {
        if (r->component[l] < 0) mbsri_report_mark(r, l, components++);
    }
    for (int number = 0; number < components && !status; ++number) {
        status = mbsri_report_classify(r, number, report);
    }
    if (!status)
        status = mbsri_check_result(w->m, w->d, (size_t)r->found * (size_t)w->k, r->weights,
                                    w->function);
    if (!status) status = mbsri_check_result(w->m, w->d, 1, &report->conditioning, w->function);
    for (int l = 0; l < r->found; ++l) {
        report->damped += r->kind[l] == MBSR_DIRECTION_DAMPED;
        report->elastic += r->kind[l] == MBSR_DIRECTION_ELASTIC;
        report->undetermined += r->kind[l] == MBSR_DIRECTION_UNDETERMINED;
    }
    report->loop_supported = all - w->k;
    report->dynamic = w->m->nu - independent - w->k;
    report->directions = w->k;
    report->index = report->undetermined > 0     ? -1
                    : report->elastic > 0        ? 2
                    : w->k > 0 || w->m->rows > 0 ? 1
                                                 : 0;
    return status;
}

/* Names the joint with the largest rate of the first direction that is not determined. */
static int refuse_undetermined(mbsri_report *r)
{
    const mbsri_null_space *w = &r->w;
    int l = 0, largest = 0;
    while (r->kind[l] != MBSR_DIRECTION_UNDETERMINED) ++l;
    mbsri_report_combine(r, r->weights + (size_t)l * (size_t)w->k);
    for (int k = 1; k < w->m->nu; ++k) {
        if (fabs(r->u[k]) / w->scale.span[k] > fabs(r->u[largest]) / w->scale.span[largest])
            largest = k;
    }
    const int i = mbsri_body_of_rate(w->m, largest);
    char label[MBSRI_LABEL];
    return mbsri_fail(&w->d->error, MBSR_UNDETERMINED, w->m->body[i].id, MBSR_NONE,
                      "%s: u%d of %s moves no mass%s, and neither a damper nor a spring resists it "
                      "at this state: give it inertia%s, a spring or a damper, or lock it",
                      w->function, largest - w->m->body[i].u, mbsri_body_label(w->m, i, label),
                      w->m->rows > 0 ? ", no loop holds it" : "", mbsri_mass_advice(w->m, i));
}

int mbsri_refuse_open(const mbsr_model *m, mbsr_data *d, double t, const double *q, const double *u,
                      const char *function, mbsri_verdict *verdict)
{
    mbsri_report r = {.found = 0};
    mbsr_index_report result = {.conditioning = 1.0};
    const mbsr_error before = d->error;
    *verdict = (mbsri_verdict){.made = false};
    int status = mbsri_null_open(&r.w, m, d, t, q, u, function);
    if (!status) {
        status = allocate_report(&r);
        if (!status) status = analyse(&r, t, q, u, &result);
        if (!status)
            *verdict = (mbsri_verdict){r.w.k, result.elastic, true, mbsri_nothing_acts(&r.w)};
        const bool changes = status == MBSR_RANK_CHANGED && m->rows == 0;
        if (status >= 0 && !changes) d->error = before;
        if (!status && result.undetermined > 0)
            status = refuse_undetermined(&r);
        else if (status >= 0 && !changes)
            status = MBSR_OK;
        mbsri_release(&m->allocator, r.memory);
        mbsri_null_close(&r.w);
    }
    return status;
}

int mbsri_refuse_elsewhere(mbsr_data *d, const char *function)
{
    return mbsri_fail(&d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                      "%s: forces determine all directions without mass at the state given, but "
                      "not where these forces balance",
                      function);
}

int mbsr_index_report_create(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                             const double *u, mbsr_index_report **report)
{
    if (report) *report = NULL;
    int status =
        mbsri_enter(model, data, q && u && report, MBSRI_STAGE_NONE, "mbsr_index_report_create");
    if (status) return status;
    mbsri_report r = {.found = 0};
    mbsr_index_report result = {.conditioning = 1.0};
    const bool watching = data->watch.active;
    data->watch.active = false;
    status = mbsri_null_open(&r.w, model, data, t, q, u, "mbsr_index_report_create");
    if (!status) {
        status = allocate_report(&r);
        if (!status) status = analyse(&r, t, q, u, &result);
        if (!status) status = mbsri_report_write(&r, result, report);
        mbsri_release(&model->allocator, r.memory);
        mbsri_null_close(&r.w);
    }
    data->watch.active = watching;
    return status;
}

void mbsr_index_report_destroy(const mbsr_model *model, mbsr_index_report *report)
{
    if (model && report) mbsri_release(&model->allocator, report);
}

/* Loops at a state: entry points.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/dynamics.h>
#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "loops/assemble.h"
#include "loops/closing.h"
#include "loops/forward.h"
#include "loops/mobility.h"
#include "loops/ranks.h"
#include "recursion/rounding.h"
#include "loops/settled.h"
#include "loops/stretch.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "sweeps/dynamics.h"

#include <math.h>

mbsr_assembly_opt mbsr_default_assembly_opt(void)
{
    mbsr_assembly_opt opt = mbsri_assembly_standard();
    opt.cookie = MBSRI_COOKIE;
    return opt;
}

static int check_assembly_opt(const mbsr_model *m, mbsr_data *d, const mbsr_assembly_opt *opt)
{
    if (opt->cookie != MBSRI_COOKIE)
        return mbsri_fail(&d->error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "mbsr_assemble: opt was not made by mbsr_default_assembly_opt");
    if (opt->max_iterations < 1 || !(opt->tolerance > 0.0 && isfinite(opt->tolerance)))
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_assemble: max_iterations is %d, tolerance is %g; both must be "
                          "positive",
                          opt->max_iterations, opt->tolerance);
    return mbsri_closing_check(m, d, opt->weight, opt->keep_position, "mbsr_assemble");
}

int mbsr_assemble(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                  const mbsr_assembly_opt *opt, double *q_closed, mbsr_assembly_info *info)
{
    static const char name[] = "mbsr_assemble";
    const mbsr_assembly_opt standard = mbsr_default_assembly_opt();
    mbsr_assembly_info found = {.closure = MBSR_NONE};
    mbsri_closer w;
    if (!opt) opt = &standard;
    int status = mbsri_enter(model, data, q && q_closed, MBSRI_STAGE_NONE, name);
    if (!status) status = check_assembly_opt(model, data, opt);
    if (!status) status = mbsri_check_input(data, (size_t)model->nq, q, name, "q");
    if (status) return status;
    double *found_q = NULL;
    status = mbsri_closer_open(&w, model, data, name);
    if (!status) {
        found_q = mbsri_allocate(&model->allocator, (size_t)model->nq * sizeof *found_q);
        if (!found_q)
            status = mbsri_fail(&data->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                                "%s: no memory for %d positions", name, model->nq);
    }
    if (!status) {
        mbsri_copy((size_t)model->nq, q, found_q);
        status = mbsri_assemble_settled(&w, t, found_q, opt, &found);
    }
    if (!status || status == MBSR_LOOP_OPEN) {
        for (int k = 0; k < model->nq; ++k)
            found.change = fmax(found.change, fabs(found_q[k] - q[k]));
        mbsri_copy((size_t)model->nq, found_q, q_closed);
        if (info) *info = found;
    }
    mbsri_release(&model->allocator, found_q);
    mbsri_closer_close(&w);
    return status;
}

/* ---- report ---- */

/* Directions of the tree that move no mass, those of them that no loop holds, and how well the
 * others are held; at rest. */
static int count_massless(mbsri_ranking *w, double t, const double *q, mbsr_closure_report *report)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    mbsri_zero((size_t)w->n, w->x);
    int row = -1, status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, w->x);
    if (!status) status = mbsri_forces(m, d, NULL, NULL);
    if (!status) status = mbsri_backward(m, d);
    if (!status) status = mbsri_closure_jacobians(m, d);
    if (status) return status;
    report->massless = w->n - d->total_rank;
    status = mbsri_loops_stretch(w, mbsri_row_fronts_scales(w->fronts), &report->stretch, &row);
    report->stretched = row < 0 ? MBSR_NONE : row;
    if (status || report->massless == 0) return status;
    return mbsri_loops_count_free(m, d, w->left_out, true, w->function, &report->undetermined);
}

static void mark_stiff(const mbsri_ranking *w, bool *stiff)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->rows; ++k) stiff[c->row + k] = mbsri_is_stiff(c, k);
    }
}

static int report_on(mbsri_ranking *w, double t, const double *q, mbsr_closure_report *report,
                     int *redundant, int *unique)
{
    mbsri_ranks here;
    int nearby;
    bool *dropped = w->left_out, *stiff = w->other;
    int status = mbsri_ranks_around(w, t, q, dropped, &here, &nearby);
    mark_stiff(w, stiff);
    for (int k = 0; k < w->rows && redundant && !status; ++k)
        redundant[k] = dropped[k] && !stiff[k];
    if (!status) status = mbsri_ranks_here(w, dropped, &here);
    if (status) return status;
    *report = (mbsr_closure_report){.rows = w->rows,
                                    .independent = here.independent,
                                    .nearby = nearby,
                                    .smallest_kept = here.smallest_kept,
                                    .largest_dropped = here.largest_dropped,
                                    .weakest = here.weakest < 0 ? MBSR_NONE : here.weakest,
                                    .weakest_pivot = here.weakest_pivot};
    for (int k = 0; k < w->rows && unique; ++k) unique[k] = !w->shared[k];
    status = count_massless(w, t, q, report);
    report->mobility = w->n - here.independent - report->undetermined;
    if (!status) status = mbsri_closure_gaps(w->m, w->d, w->g);
    report->gap = status ? 0.0 : mbsri_largest(w->position_rows, w->g);
    return status;
}

int mbsr_closures_report(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                         mbsr_closure_report *report, int *redundant, int *unique)
{
    static const char name[] = "mbsr_closures_report";
    mbsri_ranking w;
    int status = mbsri_enter(model, data, q && report, MBSRI_STAGE_NONE, name);
    if (!status) status = mbsri_check_input(data, (size_t)model->nq, q, name, "q");
    if (status) return status;
    const bool watching = data->watch.active;
    data->watch.active = false;
    status = mbsri_ranking_open(&w, model, data, false, name);
    if (!status) status = report_on(&w, t, q, report, redundant, unique);
    mbsri_ranking_close(&w);
    data->watch.active = watching;
    return status;
}

/* ---- mobility ---- */

int mbsr_closures_mobility(const mbsr_model *model, mbsr_data *data, double *mobility)
{
    static const char name[] = "mbsr_closures_mobility";
    const int status = mbsri_enter(model, data, mobility != NULL, MBSRI_STAGE_POSITIONS, name);
    return status ? status : mbsri_loops_mobility(model, data, mobility, name);
}

/* ---- rows ---- */

int mbsr_closure_of_row(const mbsr_model *model, int row, int *closure, int *own, const char **name)
{
    if (!model) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    if (row < 0 || row >= model->rows) return MBSR_ERR_ID;
    const mbsri_closure *c = model->closures.data;
    for (size_t among = model->closures.count, half; among > 1; among -= half) {
        half = among / 2; /* the last that begins at the row or before */
        if (c[half].row <= row) c += half;
    }
    if (closure) *closure = (int)(c - (const mbsri_closure *)model->closures.data);
    if (own) *own = row - c->row;
    if (name) *name = mbsri_closure_row_name(model, c, row - c->row);
    return MBSR_OK;
}

int mbsr_closure_row_kind(const mbsr_model *model, mbsr_data *data, int row,
                          mbsr_coordinate_kind *kind, double *lever)
{
    static const char name[] = "mbsr_closure_row_kind";
    int id, own, status = mbsri_enter(model, data, kind || lever, MBSRI_STAGE_POSITIONS, name);
    if (status) return status;
    status = mbsr_closure_of_row(model, row, &id, &own, NULL);
    if (status)
        return mbsri_fail(&data->error, status, MBSR_NONE, MBSR_NONE, "%s: there is no row %d",
                          name, row);
    const mbsri_closure *c = (const mbsri_closure *)model->closures.data + id;
    status =
        lever ? mbsri_closure_jacobians(model, data) : mbsri_closure_jacobian_of(model, data, c);
    if (status) return status;
    if (kind) *kind = mbsri_row_kind(model, data, c, own);
    if (!lever) return MBSR_OK;
    *lever = mbsri_longest_lever(model, data);
    return mbsri_check_result(model, data, 1, lever, name);
}

int mbsr_closures_redundant(const mbsr_model *model, mbsr_data *data, int *redundant)
{
    const int status =
        mbsri_enter(model, data, redundant != NULL, MBSRI_STAGE_NONE, "mbsr_closures_redundant");
    for (int k = 0; !status && k < model->rows; ++k) redundant[k] = data->dropped[k];
    return status;
}

int mbsr_closures_set_redundant(const mbsr_model *model, mbsr_data *data, const int *redundant)
{
    const int status = mbsri_enter(model, data, redundant != NULL, MBSRI_STAGE_NONE,
                                   "mbsr_closures_set_redundant");
    for (int k = 0; !status && k < model->rows; ++k) data->dropped[k] = redundant[k] != 0;
    return status;
}

/* ---- loop forces ---- */

int mbsr_closures_set_lambda(const mbsr_model *model, mbsr_data *data, const double *lambda)
{
    static const char name[] = "mbsr_closures_set_lambda";
    int status = mbsri_enter(model, data, lambda != NULL, MBSRI_STAGE_VELOCITIES, name);
    if (!status) status = mbsri_check_input(data, (size_t)model->rows, lambda, name, "lambda");
    if (!status) status = mbsri_closure_jacobians(model, data);
    if (status) return status;
    mbsri_copy((size_t)model->rows, lambda, data->loop_lambda);
    data->lambda_known = true;
    data->stage = MBSRI_STAGE_VELOCITIES;
    data->pending = MBSRI_PENDING_NONE;
    data->accelerated = false;
    return MBSR_OK;
}

int mbsr_closures_lambda(const mbsr_model *model, mbsr_data *data, double *lambda)
{
    const bool there = /* no stage need run */
        data && (data->pending == MBSRI_PENDING_MOTION || data->pending == MBSRI_PENDING_INVERSE);
    const int status =
        mbsri_enter(model, data, lambda != NULL, there ? MBSRI_STAGE_NONE : MBSRI_STAGE_FORCES,
                    "mbsr_closures_lambda");
    if (status) return status;
    mbsri_copy((size_t)model->rows, data->loop_lambda, lambda);
    return MBSR_OK;
}

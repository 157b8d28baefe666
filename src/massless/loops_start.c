/* A consistent start of a model with closures.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/loops_start.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "loops/assemble.h"
#include "loops/ranks.h"
#include "massless/imbalance.h"
#include "massless/loops_tree_start.h"
#include "massless/open.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/spans.h"

#include <math.h>

typedef struct start {
    mbsri_ranking w;
    const mbsri_dae_form *form;
    double t;
    double *q, *u, *udot, *lambda; /* nq, nu, nu, rows */
    double *y, *yp, *F, *near;     /* size; near: a state beside y */
    double *left, *shaken;         /* bodies + 1: forces left, and in that state */
    double *memory;
} start;

static int allocate_loops(start *s, const mbsr_model *m, mbsr_data *d)
{
    const size_t nq = (size_t)m->nq, nu = (size_t)m->nu, rows = (size_t)m->rows,
                 size = (size_t)s->form->size(m), bodies = (size_t)m->bodies + 1,
                 numbers = nq + 2 * nu + rows + 4 * size + 2 * bodies;
    s->memory = mbsri_allocate(&m->allocator, numbers * sizeof(double));
    if (!s->memory)
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %zu numbers", numbers);
    s->q = s->memory;
    s->u = s->q + nq;
    s->udot = s->u + nu;
    s->lambda = s->udot + nu;
    s->y = s->lambda + rows;
    s->yp = s->y + size;
    s->F = s->yp + size;
    s->near = s->F + size;
    s->left = s->near + size;
    s->shaken = s->left + bodies;
    return MBSR_OK;
}

/* Forces along directions without mass in a state that is 1e-8 of typical sizes beside y, springs
 * of stiff rows included, to `shaken`, *force: the largest that is applied there; then the residual
 * at y once more. */
static int shake(const start *s, double *work)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double *q = s->near, *u = s->near + m->nq + m->nu;
    mbsri_copy((size_t)s->form->size(m), s->y, s->near);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->nq; ++k)
            q[b->q + k] += 1e-8 * mbsri_coordinate_span(&spans, m, b, false, k);
        for (int k = 0; k < b->n; ++k)
            u[m->order.u_of[b->iu + k]] += 1e-8 * mbsri_rate_span(&spans, m, b, k);
    }
    int status = mbsri_pack(s->form, m, d, s->t, q, u, s->F);
    if (status) return status;
    mbsri_copy((size_t)s->form->size(m), s->F, s->near);
    status = s->form->residual(m, d, s->t, s->near, s->yp, s->F);
    if (!status) status = mbsri_enter(m, d, true, MBSRI_STAGE_BACKWARD, "mbsr_dae_consistent");
    if (!status) mbsri_defects(m, d, 0.0, s->shaken);
    *work = mbsri_work_of_forces(m, d);
    return status ? status : s->form->residual(m, d, s->t, s->y, s->yp, s->F);
}

/* Refuses forces along directions without mass that do not balance; after the residual at the
 * state. Where hardly any forces act, what is left may be rounding: nothing beside what a small
 * displacement makes. */
static int check_balance(const start *s)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    char label[MBSRI_LABEL];
    double there;
    int head, status = mbsri_enter(m, d, true, MBSRI_STAGE_BACKWARD, "mbsr_dae_consistent");
    if (status) return status;
    const double work = mbsri_work_of_forces(m, d),
                 share = mbsri_largest_defect(m, d, true, 1e-8 * work, &head);
    if (share <= 1e-6) return MBSR_OK;
    mbsri_defects(m, d, 1e-6, s->left);
    status = shake(s, &there);
    if (status) return status;
    /* where no more acts than a small displacement makes, rounding of that is all there is */
    const double least = work <= 1e-6 * there ? 1e-7 * there : 1e-8 * work;
    bool rounding = true;
    for (int i = 1; i <= m->bodies; ++i)
        rounding = rounding && (s->left[i] <= least || s->left[i] <= 1e-5 * s->shaken[i]);
    if (rounding) return MBSR_OK;
    return mbsri_fail(
        &d->error, MBSR_NO_CONVERGENCE, m->body[head].id, MBSR_NONE,
        "mbsr_dae_consistent: no state found at which forces along directions without "
        "mass balance: of those on %s %.3g is left",
        mbsri_body_label(m, head, label), share);
}

/* s' = k (C u + g_t), from F at s' = 0, of springs without damping that are as they are, and of
 * settled ones in rows that others leave to move, with what their dampers take taken from s. */
static void take_rates(start *s, int at)
{
    const mbsr_model *m = s->w.m;
    const mbsri_closure *first = mbsri_all_closures(m);
    for (const mbsri_closure *c = first; c < first + m->closures.count; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const bool as_it_is = mbsri_is_loose(c, k), damped = c->def.damping[k] > 0.0;
            const int row = at + c->row + k;
            if (!mbsri_is_stiff(c, k) || (as_it_is ? damped : !s->w.d->dropped[c->row + k]))
                continue;
            s->yp[row] = -c->def.stiffness[k] * s->F[row];
            if (!as_it_is) s->y[row] -= c->def.damping[k] / c->def.stiffness[k] * s->yp[row];
        }
    }
}

/* y, with the springs at the forces found, and y'. */
static int deliver(start *s, double *y, double *yp)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    const mbsri_closure *first = mbsri_all_closures(m);
    const int at = m->nq + 2 * m->nu;
    const size_t size = (size_t)s->form->size(m);
    int status = mbsri_pack(s->form, m, d, s->t, s->q, s->u, s->y);
    mbsri_zero(size, s->yp);
    for (const mbsri_closure *c = first; c < first + m->closures.count; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            const int row = c->row + k;
            if (!mbsri_is_stiff(c, k)) {
                s->yp[at + row] = s->lambda[row];
                continue;
            }
            /* lambda = -(s + (damping / stiffness) s') */
            const double gap_force = s->y[at + row];
            if (mbsri_is_loose(c, k) && c->def.damping[k] > 0.0)
                s->yp[at + row] =
                    -(s->lambda[row] + gap_force) * c->def.stiffness[k] / c->def.damping[k];
            else if (!mbsri_is_loose(c, k))
                s->y[at + row] = -s->lambda[row];
        }
    }
    if (!status) status = s->form->residual(m, d, s->t, s->y, s->yp, s->F);
    if (!status) status = check_balance(s);
    if (status) return status;
    for (int k = 0; k < m->nq + m->nu; ++k) s->yp[k] = -s->F[k];
    take_rates(s, at);
    mbsri_copy((size_t)m->nu, s->udot, s->yp + m->nq + m->nu);
    status = mbsri_check_result(m, d, size, s->y, "mbsr_dae_consistent");
    if (!status) status = mbsri_check_result(m, d, size, s->yp, "mbsr_dae_consistent");
    if (status) return status;
    mbsri_copy(size, s->y, y);
    mbsri_copy(size, s->yp, yp);
    return MBSR_OK;
}

/* No state was found, with that status: whether one given has a direction that nothing determines.
 */
static int refuse_given(start *s, const double *y, int found)
{
    const mbsr_error before = s->w.d->error;
    int status = mbsri_unpack(s->form, s->w.m, s->w.d, s->t, y, s->q, s->u);
    mbsri_verdict verdict = {.made = false};
    if (!status)
        status = mbsri_refuse_open(s->w.m, s->w.d, s->t, s->q, s->u, s->w.function, &verdict);
    if (status) return status;
    s->w.d->error = before;
    return found == MBSR_UNDETERMINED && verdict.made
               ? mbsri_refuse_elsewhere(s->w.d, s->w.function)
               : found;
}

/* A sum of all forces at time t, with weights that belong to no pattern. */
static int weigh(const start *s, double t, double *sum)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    int status = mbsri_positions(m, d, t, s->q);
    if (!status) status = mbsri_velocities(m, d, s->u);
    if (!status) status = mbsri_forces(m, d, NULL, NULL);
    *sum = 0.0;
    for (size_t k = 0; k < m->size.v && !status; ++k)
        *sum += (1.0 + 0.5 * sin(12.9898 * (double)k)) * d->f[k];
    for (int k = 0; k < m->nu && !status; ++k) *sum += (1.0 + 0.5 * sin(78.233 * k)) * d->tau[k];
    return status;
}

/* Whether forces are the same a little earlier and later. */
static int are_steady(const start *s, bool *steady)
{
    const mbsr_error before = s->w.d->error;
    double now, sum;
    int status = weigh(s, s->t, &now);
    *steady = true;
    for (int side = -1; side <= 1 && !status; side += 2) {
        status = weigh(s, s->t + side * 1e-3 * fmax(1.0, fabs(s->t)), &sum);
        *steady = *steady && !status && sum == now;
        if (status <= 0) continue;
        s->w.d->error = before; /* a time at which they cannot be told */
        status = MBSR_OK;
    }
    return status;
}

/* Whether velocities are zero and closed loops leave them so: no closure moves by itself. Springs
 * in rows that a start takes as they are may pull. */
static int stands(start *s, bool *still)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    double *rate = s->w.y, *bias = s->w.g;
    const mbsri_closure *c = m->closures.data;
    *still = mbsri_largest(m->nu, s->u) == 0.0;
    for (size_t n = 0; n < m->closures.count; ++n, ++c) {
        for (int k = 0; k < c->rows; ++k) *still = *still && !mbsri_is_loose(c, k);
    }
    if (!*still) return MBSR_OK;
    int status = are_steady(s, still);
    if (status || !*still) return status;
    status = mbsri_positions(m, d, s->t, s->q);
    if (!status) status = mbsri_velocities(m, d, s->u);
    if (!status) status = mbsri_closure_jacobians(m, d);
    if (!status) status = mbsri_closure_rates(m, d, rate);
    if (!status) status = mbsri_closure_bias(m, d, bias);
    *still = mbsri_largest(m->rows, rate) == 0.0 && mbsri_largest(m->rows, bias) == 0.0;
    return status;
}

/* A state at rest with closed loops on which nothing acts stays as it is: *served. */
static int rest(start *s, const mbsr_consistent_opt *opt, mbsr_consistent_info *info, bool *served)
{
    const mbsr_assembly_opt assembly_opt = mbsri_assembly_of(opt);
    mbsr_assembly_info assembly;
    mbsri_verdict verdict = {.made = false};
    mbsri_ranks here;
    bool still;
    int nearby, status = stands(s, &still);
    *served = false;
    if (status || !still) return status;
    const size_t nq = (size_t)s->w.m->nq;
    const mbsr_error before = s->w.d->error;
    mbsri_copy(nq, s->q, s->near);
    status = mbsri_assemble(&s->w.closer, s->t, s->q, &assembly_opt, &assembly);
    const bool open = status > 0; /* settled springs may be where rigid rows cannot */
    if (!status) status = mbsri_ranks_around(&s->w, s->t, s->q, s->w.d->dropped, &here, &nearby);
    if (!status)
        status = mbsri_refuse_open(s->w.m, s->w.d, s->t, s->q, s->u, s->w.function, &verdict);
    *served = !status && verdict.made && verdict.still;
    if (!*served) mbsri_copy(nq, s->near, s->q);
    if (open) s->w.d->error = before;
    if (!*served) return open ? MBSR_OK : status;
    info->iterations = assembly.iterations;
    info->null_directions = verdict.directions;
    info->elastic = verdict.elastic > 0;
    mbsri_zero((size_t)s->w.m->nu, s->udot);
    mbsri_zero((size_t)s->w.m->rows, s->lambda);
    return MBSR_OK;
}

/* The start of the tree; where there is none a state may be at rest. *rests: it stays as it is. */
static int find_or_rest(start *s, const double *y, const mbsr_consistent_opt *opt,
                        mbsr_consistent_info *info, bool *rests)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    int status = mbsri_stiff_tree_start(m, d, s->t, s->q, s->u, s->udot, s->lambda, opt, info);
    if (status <= 0) return status;
    const mbsr_error refused = d->error;
    const int refusal = status;
    status = mbsri_ranking_open(&s->w, m, d, true, "mbsr_dae_consistent");
    if (!status) status = mbsri_unpack(s->form, m, d, s->t, y, s->q, s->u);
    if (!status) status = rest(s, opt, info, rests);
    if (status < 0 || *rests) return status;
    d->error = refused;
    return refusal;
}

static int find(start *s, const double *y, const mbsr_consistent_opt *opt,
                mbsr_consistent_info *info)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    bool rests = false;
    int status = mbsri_unpack(s->form, m, d, s->t, y, s->q, s->u);
    if (!status) status = find_or_rest(s, y, opt, info, &rests);
    if ((status == MBSR_NO_CONVERGENCE || status == MBSR_UNDETERMINED ||
         status == MBSR_LOOP_SINGULAR) &&
        info->null_directions > 0)
        return refuse_given(s, y, status);
    return status;
}

int mbsri_loops_start(const mbsr_model *m, mbsr_data *d, mbsr_dae_form form, double t, double *y,
                      double *yp, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    start s = {.w = {.m = m, .d = d}, .form = mbsri_find_form(form), .t = t};
    *info = (mbsr_consistent_info){0};
    int status = allocate_loops(&s, m, d);
    if (status) return status;
    status = find(&s, y, opt, info);
    if (!status) status = deliver(&s, y, yp);
    mbsri_ranking_close(&s.w);
    mbsri_release(&m->allocator, s.memory);
    return status;
}

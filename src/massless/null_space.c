/* Directions that move no mass.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/null_space.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "massless/echelon.h"
#include "massless/null_answer.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"
#include "recursion/sizes.h"

#include <math.h>

/* The stage of forces with those held in place of the forces of their elements. */
static int given_forces(mbsri_null_space *w)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    mbsri_copy((size_t)m->nu, w->loads.tau, d->tau);
    mbsri_copy(m->size.v, w->loads.f, d->f);
    for (size_t k = (size_t)m->root.d; k < m->size.v; ++k) d->f[k] -= d->h[k];
    const mbsri_force *force = m->forces.data;
    int status = MBSR_OK;
    for (size_t k = 0; k < m->forces.count && !status; ++k) {
        if (!w->loads.own[k]) status = mbsri_add_element(m, d, force + k);
    }
    if (!status && m->rows > 0) mbsri_closure_load(m, d, d->loop_lambda, d->f, d->tau);
    if (!status) d->stage = MBSRI_STAGE_FORCES;
    return status;
}

/* Loop forces lambda for the forces of the state of mbsri_velocities. */
static int take_loop_forces(mbsri_null_space *w)
{
    if (!w->loads.lambda) return MBSR_OK;
    const int status = mbsri_closure_jacobians(w->m, w->d);
    mbsri_copy((size_t)w->m->rows, w->loads.lambda, w->d->loop_lambda);
    return status;
}

/* exactly: null vectors are as exact as what they are told from; forces along them need less. */
static int evaluate_motion(mbsri_null_space *w, double t, const double *q, const double *u,
                           bool exactly)
{
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_velocities(w->m, w->d, u);
    if (!status) status = take_loop_forces(w);
    if (!status)
        status = w->loads.on ? given_forces(w) : mbsri_forces(w->m, w->d, NULL, w->loads.lambda);
    w->d->exactly = exactly;
    if (!status) status = mbsri_backward(w->m, w->d);
    w->d->exactly = false;
    return status;
}

static int body_span(const mbsri_body *b)
{
    return mbsri_pose_size(b) + b->d + b->nq + b->n;
}

/* The most rows or columns of the derivatives of an element. */
static int element_span(const mbsr_model *m)
{
    const mbsri_force *force = m->forces.data;
    int largest = 0;
    for (size_t k = 0; k < m->forces.count; ++k, ++force) {
        int span = 0;
        for (int l = 0; l < force->def.bodies; ++l)
            span += body_span(m->body + m->stored.list_index[force->list + (size_t)l]);
        if (span > largest) largest = span;
    }
    for (int i = 1; i <= m->bodies; ++i)
        if (body_span(m->body + i) > largest) largest = body_span(m->body + i);
    return largest;
}

static int take_memory(mbsri_null_space *w)
{
    const mbsr_model *m = w->m;
    const size_t k = (size_t)w->k, nu = (size_t)m->nu, nq = (size_t)m->nq, n = (size_t)m->most.n;
    const size_t steps = (MBSRI_HIGHEST_DECADE - MBSRI_LOWEST_DECADE + 1) * k, v = m->size.v;
    size_t slope = 0, ints = 0;
    const size_t span = k > 0 ? (size_t)element_span(m) : 0;
    double *slope_place, *lambda;
    if (k > 0) mbsri_slopes_size(m, MBSRI_SLOPES_WHOLE, &slope, &ints);
    const struct {
        double **place;
        size_t length;
    } part[] = {
        {&w->vector, n * k},
        {&w->direction, nu * k},
        {&w->twist, v * k},
        {&w->C, k * k},
        {&w->S, k * k},
        {&w->C_error, k * k},
        {&w->S_error, k * k},
        {&w->difference.ahead, k},
        {&w->difference.behind, k},
        {&w->difference.slopes, steps},
        {&w->difference.sizes, steps},
        {&w->q, nq},
        {&w->u, nu},
        {&w->rate, nq},
        {&w->force, nu},
        {&w->lift.work, mbsri_null_lift_room(m)},
        {&w->lift.rate_error, nu * k},
        {&w->lift.twist_error, v * k},
        {&w->lift.basis, n * n},
        {&w->loads.f, v},
        {&w->loads.tau, nu},
        {&w->element.q_rate, nq * k},
        {&w->element.V_rate, v * k},
        {&w->element.reaction, 4 * span},
        {&w->element.factor, span * (span + 3)},
        {&w->scale.q, nq},
        {&w->scale.u, nu},
        {&w->scale.span, nu},
        {&w->q_given, nq},
        {&w->difference.shift, nu},
        {&w->sums.weights, k * k},
        {&w->sums.gamma, k},
        {&w->element.strain, k},
        {&lambda, (size_t)m->rows},
        {&slope_place, slope},
    };
    enum { PARTS = sizeof part / sizeof *part };
    size_t total = 0;
    for (size_t l = 0; l < PARTS; ++l) total += part[l].length;
    w->memory = mbsri_allocate(
        &m->allocator,
        total * sizeof(double) +
            (12 * k + ints + 2 * span + 2 * (size_t)m->bodies + 1) * sizeof(int) +
            (m->forces.count + 2 * k * k + 2 * k + 4 * ((size_t)m->bodies + 1) * k) * sizeof(bool) +
            1);
    if (!w->memory) {
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d null directions", w->function, w->k);
    }
    double *next = w->memory;
    for (size_t l = 0; l < PARTS; ++l) {
        *part[l].place = next;
        next += part[l].length;
    }
    if (m->rows > 0) mbsri_zero((size_t)m->rows, w->loads.lambda = lambda);
    w->head = (int *)(void *)next;
    w->body = w->head + w->k;
    w->element.moving = w->body + w->k;
    w->difference.colour = w->element.moving + w->k;
    w->element.place = w->difference.colour + w->k;
    w->from = w->element.place + w->k;
    w->to = w->from + 3 * w->k;
    w->sums.head = w->to + 3 * w->k;
    w->element.touched = w->sums.head + w->k;
    w->rank = w->element.touched + m->bodies;
    if (k > 0)
        mbsri_slopes_place(m, MBSRI_SLOPES_WHOLE, &w->element.slope, slope > 0 ? slope_place : NULL,
                           w->rank + m->bodies + 1);
    w->element.factor_size = (int)span;
    w->element.factor_places = w->rank + m->bodies + 1 + ints;
    w->loads.own = (bool *)(void *)(w->element.factor_places + 2 * span);
    w->element.dense[0] = w->loads.own + m->forces.count;
    w->element.dense[1] = w->element.dense[0] + k;
    w->difference.affects = w->element.dense[1] + k;
    w->difference.tables = w->difference.affects + k * k;
    for (int i = 0; i <= m->bodies; ++i) w->rank[i] = w->d->rank[i];
    return MBSR_OK;
}

int mbsri_null_open(mbsri_null_space *w, const mbsr_model *m, mbsr_data *d, double t,
                    const double *q, const double *u, const char *function)
{
    *w = (mbsri_null_space){.m = m, .d = d, .function = function};
    const int status = evaluate_motion(w, t, q, u, true);
    if (status) return status;
    w->k = m->nu - d->total_rank;
    const int refused = take_memory(w);
    if (!refused) mbsri_copy((size_t)m->nq, q, w->q_given);
    return refused;
}

void mbsri_null_close(mbsri_null_space *w)
{
    mbsri_release(&w->m->allocator, w->memory);
    mbsri_release(&w->m->allocator, w->element.rows.data);
    mbsri_release(&w->m->allocator, w->element.entries.data);
    mbsri_release(&w->m->allocator, w->element.room.data);
    w->element.rows = w->element.entries = w->element.room = (mbsri_array){NULL, 0, 0};
    w->memory = NULL;
}

/* Rank of a group where the directions were counted. */
static int counted_rank(const mbsri_null_space *w, const mbsri_group *g)
{
    int rank = 0;
    for (int k = 0; k < g->members; ++k) rank += w->rank[g->member[k]];
    return rank;
}

/* Whether the rank of the group of head i is as it was; of others, which are done with it, it is.
 */
static bool same_rank(const mbsri_null_space *w, int i)
{
    if (!mbsri_heads(w->m, w->d, i)) return true;
    const mbsri_group g = mbsri_group_of(w->m, w->d, i);
    return mbsri_group_rank(w->d, &g) == counted_rank(w, &g);
}

/* The number of directions must be the one that memory was taken for. */
static int check_number(mbsri_null_space *w)
{
    const mbsr_model *m = w->m;
    const int now = m->nu - w->d->total_rank;
    if (now == w->k) return MBSR_OK;
    char label[MBSRI_LABEL];
    int i = 1;
    while (i < m->bodies && same_rank(w, i)) ++i;
    const mbsri_body *b = m->body + i;
    const mbsri_group g = mbsri_group_of(m, w->d, b->group.head);
    return mbsri_fail(&w->d->error, MBSR_RANK_CHANGED, b->id, MBSR_NONE,
                      "%s: %s: the rank of its joint%s changes from %d to %d (of %d) at t = %g, "
                      "q0 = %g, and the directions without mass from %d to %d: begin where "
                      "the ranks around the state are its own",
                      w->function, mbsri_body_label(m, i, label),
                      g.members > 1 ? " and the massless ones behind it" : "", counted_rank(w, &g),
                      mbsri_group_rank(w->d, &g), g.n, w->d->t, b->nq > 0 ? w->q_given[b->q] : 0.0,
                      w->k, now);
}

/* The body of the group whose joint lacks the rank number `missing`, from the head on. */
static int lacking(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, int missing)
{
    int k = 0;
    while (k < g->members - 1) {
        missing -= m->body[g->member[k]].n - d->rank[g->member[k]];
        if (missing < 0) break;
        ++k;
    }
    return g->member[k];
}

/* Direction number l of the null rates w->u, added up from the sizes w->difference.shift, which
 * begins at body i. */
static void lift(mbsri_null_space *w, int l, int i)
{
    const size_t at = (size_t)l * (size_t)w->m->nu, at_v = (size_t)l * w->m->size.v;
    const mbsri_lifted out = {w->direction + at, w->lift.rate_error + at, w->twist + at_v,
                              w->lift.twist_error + at_v};
    mbsri_null_lift(w->m, w->d, i, w->u, w->difference.shift, &out, w->lift.work);
    mbsri_null_answer(w->m, w->d, i, &out);
}

/* Null rates and their sizes += weight times vector l. */
static void add_vector(mbsri_null_space *w, int l, double weight)
{
    const mbsri_group g = mbsri_group_of(w->m, w->d, w->head[l]);
    const double *vector = w->vector + (size_t)l * (size_t)w->m->most.n;
    for (int k = 0, at = 0; k < g.members; ++k) {
        const mbsri_body *b = w->m->body + g.member[k];
        for (int c = 0; c < b->n; ++c, ++at) {
            w->u[b->u + c] += weight * vector[at];
            w->difference.shift[b->u + c] += fabs(weight * vector[at]);
        }
    }
}

static void clear_rates(mbsri_null_space *w)
{
    mbsri_zero((size_t)w->m->nu, w->u);
    mbsri_zero((size_t)w->m->nu, w->difference.shift);
}

int mbsri_null_lift_again(mbsri_null_space *w, double t, const double *q, const double *u)
{
    int status = evaluate_motion(w, t, q, u, true);
    for (int l = 0; l < w->k && !status; ++l) {
        const double *weight = w->sums.weights + (size_t)l * (size_t)w->k;
        clear_rates(w);
        for (int n = 0; n < w->k; ++n) {
            if (weight[n] != 0.0) add_vector(w, n, weight[n]);
        }
        lift(w, l, w->sums.head[l]);
    }
    return status;
}

int mbsri_null_basis(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    int status = evaluate_motion(w, t, q, u, true);
    if (!status) status = check_number(w);
    if (status) return status;
    int column = 0;
    w->sums.on = false;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        const int rank = mbsri_group_rank(d, &g);
        mbsri_copy((size_t)((g.n - rank) * g.n), d->X + m->body[i].nn + rank * g.n, w->lift.basis);
        mbsri_echelon(g.n, g.n - rank, w->lift.basis);
        for (int l = rank; l < g.n; ++l, ++column) {
            double *vector = w->vector + (size_t)column * (size_t)m->most.n;
            for (int k = 0; k < g.n; ++k)
                vector[k] = d->s[g.ig + k] * w->lift.basis[(l - rank) * g.n + k];
            w->head[column] = w->sums.head[column] = i;
            w->body[column] = lacking(m, d, &g, l - rank);
            clear_rates(w);
            add_vector(w, column, 1.0);
            lift(w, column, i);
        }
    }
    return MBSR_OK;
}

void mbsri_null_remix(const mbsri_null_space *w, bool sizes, double *x)
{
    double *y = w->sums.gamma;
    if (!w->sums.on) return;
    mbsri_copy((size_t)w->k, x, y);
    for (int l = 0; l < w->k; ++l) {
        const double *column = w->sums.weights + (size_t)l * (size_t)w->k;
        x[l] = 0.0;
        for (int n = 0; n < w->k; ++n) x[l] += (sizes ? fabs(column[n]) : column[n]) * y[n];
    }
}

int mbsri_null_gamma(mbsri_null_space *w, double t, const double *q, const double *u, double *gamma)
{
    const mbsr_model *m = w->m;
    int status = evaluate_motion(w, t, q, u, false);
    if (!status) status = check_number(w);
    if (status) return status;
    for (int l = 0; l < w->k; ++l) {
        const mbsri_group g = mbsri_group_of(m, w->d, w->head[l]);
        if (l == 0 || w->head[l] != w->head[l - 1])
            mbsri_null_force(m, w->d, &g, w->d->e + g.ig, w->force);
        gamma[l] = mbsri_dot(g.n, w->vector + (size_t)l * (size_t)m->most.n, w->force);
    }
    mbsri_null_remix(w, false, gamma);
    return mbsri_check_result(m, w->d, (size_t)w->k, gamma, w->function);
}

double mbsri_null_load(const mbsri_null_space *w, int l)
{
    static const double trace = 0.01; /* of sizes, of which 1e-13 is rounding */
    const mbsri_group g = mbsri_group_of(w->m, w->d, w->head[l]);
    const double *vector = w->vector + (size_t)l * (size_t)w->m->most.n, *s = w->d->s + g.ig;
    double *all = w->lift.work, largest = 0.0;
    for (int k = 0; k < g.n; ++k) largest = fmax(largest, fabs(vector[k]) / s[k]);
    for (int k = 0; k < g.n; ++k) all[k] = trace * largest * s[k];
    return mbsri_gross_load(w->m, w->d, &g, vector) + mbsri_gross_load(w->m, w->d, &g, all);
}

int mbsri_null_rate_here(mbsri_null_space *w, const double *x, double *rate)
{
    mbsri_gather(w->m, x, w->d->u);
    w->d->stage = MBSRI_STAGE_POSITIONS;
    return mbsri_coordinate_rates(w->m, w->d, rate);
}

/* The numbers of a part, and how many a direction has. */
static const double *part_of(const mbsri_null_space *w, mbsri_null_field part, size_t *rows)
{
    *rows = part == MBSRI_NULL_RATES    ? (size_t)w->m->nu
            : part == MBSRI_NULL_TWISTS ? w->m->size.v
                                        : (size_t)w->m->nq;
    return part == MBSRI_NULL_RATES    ? w->direction
           : part == MBSRI_NULL_TWISTS ? w->twist
                                       : w->element.q_rate;
}

void mbsri_null_extents(mbsri_null_space *w)
{
    for (int part = 0; part < 3; ++part) {
        size_t rows;
        const double *A = part_of(w, (mbsri_null_field)part, &rows);
        for (int l = 0; l < w->k; ++l) {
            const double *column = A + (size_t)l * rows;
            size_t from = 0, to = rows;
            while (from < rows && column[from] == 0.0) ++from;
            while (to > from && column[to - 1] == 0.0) --to;
            w->from[part * w->k + l] = (int)from;
            w->to[part * w->k + l] = (int)to;
        }
    }
}

void mbsri_null_mix(const mbsri_null_space *w, mbsri_null_field part, const double *weights,
                    double *y, double *size)
{
    size_t rows;
    const double *A = part_of(w, part, &rows);
    mbsri_zero(rows, y);
    mbsri_zero(rows, size);
    for (int l = 0; l < w->k; ++l) {
        const double *column = A + (size_t)l * rows;
        const int at = (int)part * w->k + l;
        for (int r = w->from[at]; r < w->to[at] && weights[l] != 0.0; ++r) {
            const double term = weights[l] * column[r];
            y[r] += term;
            size[r] += fabs(term);
        }
    }
    for (size_t r = 0; r < rows; ++r) {
        if (!(fabs(y[r]) > 1e-10 * size[r])) y[r] = 0.0;
    }
}

/* Divides each row by its largest entry; scale (k) gets the factors. */
void mbsri_scale_rows(int k, double *A, double *scale)
{
    for (int r = 0; r < k; ++r) {
        double size = 0.0;
        for (int c = 0; c < k; ++c) size = fmax(size, fabs(A[c * k + r]));
        scale[r] = size > 0.0 ? 1.0 / size : 1.0;
        for (int c = 0; c < k; ++c) A[c * k + r] *= scale[r];
    }
}

void mbsri_scale_columns(int k, double *A, double *scale)
{
    for (int c = 0; c < k; ++c) {
        const double size = mbsri_largest(k, A + c * k);
        scale[c] = size > 0.0 ? 1.0 / size : 1.0;
        for (int r = 0; r < k; ++r) A[c * k + r] *= scale[c];
    }
}

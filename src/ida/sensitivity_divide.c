/* Sensitivities of runs: steps that are too long for them.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The run's error test does not see what a parameter would set swinging: at rest its steps grow
 * without end. Where errors (sensitivity_errors.c) are far more than the tolerance beside the
 * largest x of the run, some sums of relative changes of all parameters are followed, and steps are
 * divided until it is less. States within a step are cubics of those at its ends. First steps of
 * segments are left as they are, but the first of all. */
#include "ida/error.h"
#include "ida/record.h"
#include "ida/sensitivity_record.h"

#include <math.h>
#include <string.h>

enum { SUMS = 4, TURNS = 4, HIGHEST = 3 }; /* HIGHEST: order where steps are divided */

static const double longer = 1.5, shorter = 0.1;

typedef struct division {
    mbsri_forward_run f;
    mbsr_sensitivity *s;
    mbsri_kept step, state;  /* as they were */
    mbsri_step_errors found; /* on the way */
    double largest[SUMS], worst[SUMS];
    double scale[SUMS]; /* largest values of the run before */
    double h;           /* of steps divided; 0: the last was not */
} division;

/* The largest error at a node over what is allowed. */
static double find_error(const division *v, long node)
{
    double most = 0.0;
    for (int k = 0; k < v->f.count; ++k) {
        const double error = mbsri_sensitivity_error_of(&v->f, node, k);
        if (error > 0.0)
            most = fmax(most, error / mbsri_sensitivity_allowed(&v->f, k, v->scale[k]));
    }
    return most;
}

/* ---- dividing ---- */

static const mbsri_kept_step *old_at(const division *v, long node)
{
    return (const mbsri_kept_step *)v->step.data + (node - 1);
}

static double time_before(const division *v, long node)
{
    return node > 1 ? old_at(v, node - 1)->t : v->s->start;
}

/* The state at t within the step to the old node. */
static void interpolate(const division *v, long node, double t, double *y)
{
    const size_t size = (size_t)v->s->size;
    const double *to = (const double *)v->state.data + 2 * size * (size_t)(node - 1),
                 *from = node > 1 ? to - 2 * size : v->s->begin, start = time_before(v, node),
                 h = old_at(v, node)->t - start, x = (t - start) / h;
    for (size_t k = 0; k < size; ++k) {
        const double slope = (to[k] - from[k]) / h, a = from[size + k] - slope,
                     b = to[size + k] - slope;
        y[k] = from[k] + x * (to[k] - from[k]) + h * x * (1.0 - x) * (a * (1.0 - x) - b * x);
        y[size + k] = slope + a * (1.0 - x) * (1.0 - 3.0 * x) + b * x * (3.0 * x - 2.0);
    }
}

/* One more node at t in the step to the old one: at its end, that. first: it begins a segment. */
static int add_node(division *v, long node, double t, int order, bool first)
{
    mbsr_sensitivity *s = v->s;
    const size_t size = (size_t)s->size;
    const mbsri_kept_step *old = old_at(v, node);
    if (!mbsri_sensitivity_reserve(&s->step, 1, sizeof(mbsri_kept_step)) ||
        !mbsri_sensitivity_reserve(&s->state, 2 * size, sizeof(double)))
        return mbsri_ida_refuse(&s->error, MBSR_ERR_NO_MEMORY,
                                "sensitivity: no memory for %zu steps", s->step.count + 1);
    mbsri_kept_step *step = (mbsri_kept_step *)s->step.data + s->step.count;
    double *y = (double *)s->state.data + s->state.count;
    *step = (mbsri_kept_step){t, order, first ? 0 : step[-1].since + 1, first && old->crossed};
    if (t < old->t)
        interpolate(v, node, t, y);
    else
        memcpy(y, (const double *)v->state.data + 2 * size * (size_t)(node - 1),
               2 * size * sizeof *y);
    ++s->step.count;
    s->state.count += 2 * size;
    return MBSR_OK;
}

static int order_after(const mbsr_sensitivity *s, int own)
{
    const int next = mbsri_kept_at(s, (long)s->step.count)->order + 1,
              risen = next < HIGHEST ? next : HIGHEST;
    return own > risen ? own : risen;
}

/* The last node goes; the start, which the first step has made another, is as it was. */
static void take_back(division *v)
{
    mbsr_sensitivity *s = v->s;
    --s->step.count;
    s->state.count -= 2 * (size_t)s->size;
    if (s->step.count == 0)
        memset(mbsri_forward_node(&v->f, 0, 0), 0,
               (size_t)v->f.count * (size_t)s->size * sizeof(double));
}

/* From the last node to that of an old step, in steps that are short enough. */
static int go_over(division *v, long node)
{
    static const double shortest = 1e-4, rounding = 1e-10;
    mbsr_sensitivity *s = v->s;
    const mbsri_kept_step *old = old_at(v, node);
    const double from = time_before(v, node),
                 least = fmax(shortest * (old->t - from), rounding * (old->t - s->start));
    bool vain = false; /* there is a corner, or rounding */
    const bool divides = old->since > 0 || node == 1;
    double at = from;
    while (at < old->t) {
        const bool divided = divides && v->h > 0.0, first = old->since == 0 && at == from,
                   last = !divided || vain || at + v->h >= old->t - least;
        const double h = last ? old->t - at : v->h;
        const int order = divided && !first ? order_after(s, old->order) : old->order;
        int status = add_node(v, node, last ? old->t : at + h, order, first);
        const long added = (long)s->step.count;
        if (!status) status = mbsri_forward_step(&v->f, added);
        if (status) return status;
        const double error = divides ? find_error(v, added) : 0.0,
                     by = 0.9 * pow(fmax(error, 1e-9),
                                    -1.0 / (mbsri_sensitivity_rate(s, added).order + 1));
        if (error > 1.0 && h > least && !vain) {
            v->h = h * fmax(shorter, fmin(by, 0.9));
            take_back(v);
            continue;
        }
        mbsri_sensitivity_note_errors(&v->f, added, &v->found);
        vain = vain || error > 1.0;
        if (divided && (!last || h >= v->h)) v->h = h * fmin(longer, fmax(by, 0.5));
        at = last ? old->t : at + h;
    }
    return MBSR_OK;
}

/* All steps anew; after a failure they are as they were. */
static int divide_steps(division *v)
{
    mbsr_sensitivity *s = v->s;
    v->step = s->step, v->state = s->state;
    s->step = s->state = (mbsri_kept){0};
    v->h = 0.0;
    int status = MBSR_OK;
    for (long node = 1; node <= (long)v->step.count && !status; ++node) status = go_over(v, node);
    mbsri_kept *const gone[] = {status ? &s->step : &v->step, status ? &s->state : &v->state};
    mbsri_sensitivity_free(gone[0]->data);
    mbsri_sensitivity_free(gone[1]->data);
    if (status) s->step = v->step, s->state = v->state;
    return status;
}

/* ---- all ---- */

/* The sums, of alternate signs lest they cancel. */
static void choose_sums(const mbsr_sensitivity *s, int count, double *weight)
{
    for (int k = 0; k < s->parameters; ++k) {
        const double size = s->value[k] != 0.0 ? s->value[k] : 1.0;
        weight[(size_t)(k % count) * (size_t)s->parameters + (size_t)k] =
            k / count % 2 ? -size : size;
    }
}

/* Along all nodes, as they are. */
static int follow_nodes(division *v)
{
    int status = MBSR_OK;
    for (long node = 1; node <= (long)v->s->step.count && !status; ++node) {
        status = mbsri_forward_step(&v->f, node);
        if (!status) mbsri_sensitivity_note_errors(&v->f, node, &v->found);
    }
    return status;
}

/* With what is known of sizes, in turns, as long as they turn out to be much less. */
static int divide_in_turns(division *v)
{
    bool less = true;
    int status = MBSR_OK;
    for (int turn = 0; turn < TURNS && less && !status; ++turn) {
        memset(v->f.node, 0,
               (size_t)MBSRI_NODES * (size_t)v->f.count * (size_t)v->s->size * sizeof(double));
        memcpy(v->scale, v->largest, sizeof v->scale);
        memset(v->largest, 0, sizeof v->largest);
        memset(v->worst, 0, sizeof v->worst);
        status = divide_steps(v);
        less = false;
        for (int k = 0; k < v->f.count; ++k) less = less || v->largest[k] < 0.25 * v->scale[k];
    }
    return status;
}

/* By `count` sums; asked: where their errors are not fine. */
static int follow_sums(mbsr_sensitivity *s, int count, bool asked)
{
    const size_t nodes = (size_t)MBSRI_NODES * (size_t)count * (size_t)s->size,
                 weights = (size_t)count * (size_t)s->parameters,
                 tau = (size_t)count * (size_t)s->nu, jump = (size_t)s->parameters * (size_t)s->nu;
    double *memory = mbsri_sensitivity_take(nodes + weights + tau + jump);
    if (!memory)
        return mbsri_ida_refuse(&s->error, MBSR_ERR_NO_MEMORY,
                                "sensitivity: no memory for %d sums of parameters", count);
    double *weight = memory + nodes;
    choose_sums(s, count, weight);
    division v = {.s = s,
                  .f = {.s = s,
                        .count = count,
                        .weight = weight,
                        .node = memory,
                        .tau = weight + weights,
                        .jump = weight + weights + tau}};
    v.found = (mbsri_step_errors){v.largest, v.worst};
    int status = follow_nodes(&v);
    const bool fine = asked && mbsri_sensitivity_is_fine(&v.f, &v.found);
    if (!status && !fine) {
        status = divide_in_turns(&v);
        s->run.divided = !status;
    }
    s->run.checked = !status;
    mbsri_sensitivity_free(memory);
    return status;
}

int mbsri_sensitivity_divide(mbsr_sensitivity *s)
{
    return follow_sums(s, s->parameters < SUMS ? s->parameters : SUMS, false);
}

int mbsri_sensitivity_check(mbsr_sensitivity *s)
{
    return s->run.checked ? MBSR_OK : follow_sums(s, 1, true);
}

/* Inputs and outputs of linear equations, and their names.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Parameters theta enter F(t, y, y') = 0 by a column -F_theta of B, central differences of models.
 * Outputs are rows on x = (dq, dp, du, forces): joints and points by Jacobians, forces of elements
 * by central differences of what they exert, along dq and du, and along theta beside that. */
#include "linear/record.h"

#include "base/error.h"
#include "linear/spans.h"

#include <mbsrank/closure.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char name[] = "mbsr_linear_create";

/* Differences of fourth order: places, and weights over 12. */
static const double places[] = {1.0, -1.0, 2.0, -2.0}, weights[] = {8.0, -8.0, -1.0, 1.0};

/* ---- what there is ---- */

static int refuse_signal(bool input, int k, const char *why, int number, mbsr_error *error)
{
    return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "%s: %s %d is %s %d", name,
                      input ? "input" : "output", k, why, number);
}

/* Numbers of f and tau of an element on the body at a place; 0: on none. */
static int numbers_of_force(const mbsr_model *m, int force, int place)
{
    const int body = mbsri_body_of_force(m, force, place);
    int n;
    if (body == MBSR_GROUND) return 0;
    mbsr_body_coordinates(m, body, NULL, NULL, NULL, &n);
    return mbsr_body_dimension(m, body) + n;
}

static int check_signal(const mbsr_model *m, const mbsr_parameters *list, bool input, int k,
                        const mbsr_signal *s, mbsr_error *error)
{
    switch (s->kind) {
    case MBSR_SIGNAL_JOINT:
    case MBSR_SIGNAL_RATE:
        if (input && s->kind == MBSR_SIGNAL_RATE) break;
        if (s->id >= 0 && s->id < mbsr_model_nu(m)) return MBSR_OK;
        return refuse_signal(input, k, "of no such joint rate:", s->id, error);
    case MBSR_SIGNAL_PARAMETER:
        if (!input) break;
        if (list && s->id >= 0 && s->id < mbsr_parameters_count(list)) return MBSR_OK;
        return refuse_signal(input, k, "no parameter of the list:", s->id, error);
    case MBSR_SIGNAL_POINT:
        if (input) break;
        for (int l = 0; l < 3; ++l)
            if (!isfinite(s->point[l])) return refuse_signal(false, k, "not at a point:", l, error);
        if (s->id >= 0 && s->id < mbsr_model_bodies(m) && s->part >= 0 && s->part < 3)
            return MBSR_OK;
        return refuse_signal(false, k, "of no such body or axis:", s->id, error);
    case MBSR_SIGNAL_FORCE:
        if (input) break;
        if (s->part >= 0 && s->part < numbers_of_force(m, s->id, s->place)) return MBSR_OK;
        return refuse_signal(false, k, "no number of an element:", s->part, error);
    case MBSR_SIGNAL_MOTION:
    case MBSR_SIGNAL_CLOSURE_MOTION:
        if (!input) break;
        if (s->part >= 0 && s->part < mbsri_motions_of(m, s->kind, s->id)) return MBSR_OK;
        return refuse_signal(true, k, "of no such motion of a stock joint or closure:", s->part,
                             error);
    }
    return refuse_signal(input, k, "of a kind that it cannot be:", (int)s->kind, error);
}

int mbsri_signals_check(const mbsr_model *m, const mbsr_linear_opt *opt, mbsr_error *error)
{
    for (int side = 0; side < 2; ++side) {
        const int count = side ? opt->outputs : opt->inputs;
        const mbsr_signal *list = side ? opt->output : opt->input;
        if (count < 0 || (count > 0 && !list))
            return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "%s: %d %ss, or no list of them", name, count,
                              side ? "output" : "input");
        for (int k = 0; k < count; ++k) {
            const int status = check_signal(m, opt->list, side == 0, k, list + k, error);
            if (status) return status;
        }
    }
    return MBSR_OK;
}

/* ---- parameters ---- */

static double length_or_one(const mbsr_model *m)
{
    const double length = mbsr_model_length(m);
    return length > 0.0 ? length : 1.0;
}

/* Coordinates of points are without a unit. */
static double step_of_signal(const mbsr_model *m, const mbsr_parameter *p)
{
    const bool way = strcmp(p->unit, "m") == 0 || strcmp(p->unit, "") == 0,
               turn = strcmp(p->unit, "rad") == 0;
    return p->value != 0.0 ? 0x1p-10 * fabs(p->value)
           : way           ? 0x1p-10 * length_or_one(m)
           : turn          ? 0x1p-10
                           : 1.0;
}

/* Column j of B, and what forces see of it at once. r: 2 numbers for each of y. */
static int enter_parameter(mbsr_linear *l, const mbsri_coordinates *c, const double *y,
                           const double *yp, const mbsr_linear_opt *opt, int j, double *r,
                           mbsr_error *error)
{
    mbsr_parameter p;
    const int which = opt->input[j].id, at_u = c->nq + c->nu;
    mbsr_parameter_get(opt->list, which, &p);
    const double h = step_of_signal(c->model, &p);
    memset(r, 0, 2 * (size_t)c->size * sizeof *r);
    for (int k = 0; k < 4; ++k) {
        const double value = p.value + places[k] * h, weight = weights[k] / (12.0 * h);
        mbsr_data *d;
        int status = mbsr_parameters_data(opt->list, 1, &which, &value, &d, error);
        if (status) return status;
        const mbsr_model *m = mbsr_data_model(d);
        double *F = r + c->size;
        if (mbsr_dae_size(m, MBSR_DAE_MOMENTUM) != c->size) status = MBSR_ERR_VALUE;
        if (!status) status = mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, c->t, y, yp, F);
        for (int i = 0; i < c->size && !status; ++i) r[i] += weight * F[i];
        if (!status) status = mbsr_stage_positions(m, d, c->t, y);
        if (!status) status = mbsr_stage_velocities(m, d, y + at_u);
        for (int i = 0; i < l->outputs && !status; ++i) {
            double force = 0.0;
            if (opt->output[i].kind != MBSR_SIGNAL_FORCE) continue;
            status = mbsri_sample_force(m, d, opt->output + i, &force);
            l->direct[j * l->outputs + i] += weight * force;
        }
        if (status)
            (void)mbsri_fail(error, status, MBSR_NONE, MBSR_NONE, "%s: with %.60s = %g: %s", name,
                             p.name, value, mbsr_data_error(d)->text);
        mbsr_data_destroy(d);
        if (status) return status;
    }
    mbsri_pencil_rows(c, r, -1.0, l->part[MBSR_LINEAR_B] + (size_t)j * (size_t)l->info.size);
    return MBSR_OK;
}

/* ---- outputs ---- */

/* The velocity of a point by u: its displacement along dq. */
static int see_point(mbsr_linear *l, const mbsri_coordinates *c, int i, const mbsr_signal *s,
                     double *u)
{
    double drift[3], v[3];
    memset(u, 0, (size_t)c->nu * sizeof *u);
    int status = mbsr_stage_velocities(c->model, c->data, u);
    if (!status) status = mbsr_body_point(c->model, c->data, s->id, s->point, NULL, drift, NULL);
    for (int k = 0; k < c->nu && !status; ++k) {
        u[k] = 1.0;
        status = mbsr_stage_velocities(c->model, c->data, u);
        if (!status) status = mbsr_body_point(c->model, c->data, s->id, s->point, NULL, v, NULL);
        l->output[(size_t)k * (size_t)l->outputs + (size_t)i] = v[s->part] - drift[s->part];
        u[k] = 0.0;
    }
    return status;
}

/* What is far along each rate, into span (nu); how fast the model moves, in these. */
static double find_rate_spans(const mbsri_coordinates *c, const double *u, double *span)
{
    double speed = mbsr_model_rate(c->model);
    for (int i = 0; i < c->bodies; ++i)
        mbsri_linear_spans(c->model, i, true, length_or_one(c->model), span + c->joint[i][2]);
    for (int k = 0; k < c->nu; ++k) speed = fmax(speed, fabs(u[k]) / span[k]);
    return speed > 0.0 ? speed : 1.0;
}

/* Forces of elements along dq, and along du. work: 2 nq + 3 nu numbers. */
static int see_force(mbsr_linear *l, const mbsri_coordinates *c, int i, const mbsr_signal *s,
                     const double *y, double *work)
{
    const int nq = c->nq, nu = c->nu;
    double *q = work, *u = q + nq, *x = u + nu, *dq = x + nu, *span = dq + nq;
    const double speed = find_rate_spans(c, y + nq + nu, span);
    int status = MBSR_OK;
    for (int k = 0; k < 2 * nu && !status; ++k) {
        const int rate = k % nu;
        const double h = k < nu ? 0x1p-14 * span[rate] : 0x1p-16 * span[rate] * speed;
        double slope = 0.0;
        memset(x, 0, (size_t)nu * sizeof *x);
        x[rate] = 1.0;
        mbsri_coordinates_lift(c, x, dq);
        for (int p = 0; p < 4 && !status; ++p) {
            double force = 0.0;
            memcpy(q, y, (size_t)nq * sizeof *q);
            memcpy(u, y + nq + nu, (size_t)nu * sizeof *u);
            for (int j = 0; j < nq && k < nu; ++j) q[j] += places[p] * h * dq[j];
            if (k >= nu) u[rate] += places[p] * h;
            status = mbsr_stage_positions(c->model, c->data, c->t, q);
            if (!status) status = mbsr_stage_velocities(c->model, c->data, u);
            if (!status) status = mbsri_sample_force(c->model, c->data, s, &force);
            slope += weights[p] / (12.0 * h) * force;
        }
        l->output[(size_t)(k < nu ? rate : 2 * nu + rate) * (size_t)l->outputs + (size_t)i] = slope;
    }
    return status;
}

int mbsri_signals_enter(mbsr_linear *l, const mbsri_coordinates *c, const double *y,
                        const double *yp, const mbsr_linear_opt *opt, mbsr_error *error)
{
    double *work =
        mbsri_arena_take(&l->arena, (2 * (size_t)(c->size + c->nq + c->nu) + 1) * sizeof *work);
    int status = MBSR_OK;
    if (!work)
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "%s: no memory", name);
    int at = c->size - c->nq + c->nu;
    for (int j = 0; j < l->inputs && !status; ++j) {
        if (opt->input[j].kind == MBSR_SIGNAL_PARAMETER)
            status = enter_parameter(l, c, y, yp, opt, j, work, error);
        if (!mbsri_is_motion(opt->input + j)) continue;
        status = mbsri_motion_enter(l, c, y, yp, opt, j, at, work, error);
        at += 2;
    }
    if (status) return status;
    for (int i = 0; i < l->outputs && !status; ++i) {
        const mbsr_signal *s = opt->output + i;
        const size_t rate = s->kind == MBSR_SIGNAL_RATE ? 2 * (size_t)c->nu : 0;
        if (s->kind == MBSR_SIGNAL_POINT)
            status = see_point(l, c, i, s, work);
        else if (s->kind == MBSR_SIGNAL_FORCE)
            status = see_force(l, c, i, s, y, work);
        else
            l->output[(rate + (size_t)s->id) * (size_t)l->outputs + (size_t)i] = 1.0;
        if (!status) status = mbsr_stage_positions(c->model, c->data, c->t, y);
    }
    if (!status) status = mbsr_stage_velocities(c->model, c->data, y + c->nq + c->nu);
    if (!status) return MBSR_OK;
    const mbsr_error *why = mbsr_data_error(c->data);
    return mbsri_fail(error, status, why->body, why->force, "%s: %s", name, why->text);
}

/* ---- names ---- */

enum { LABEL = 128 };

/* Reads a label, perhaps in quotes; returns behind it, or NULL. */
static const char *read_label(const char *text, char label[LABEL])
{
    const bool quoted = *text == '\'';
    int n = 0;
    if (quoted) ++text;
    for (; *text && n < LABEL - 1 && *text != (quoted ? '\'' : '.'); ++text) {
        if (quoted && *text == '\\' && text[1]) ++text;
        label[n++] = *text;
    }
    label[n] = '\0';
    if (quoted && *text == '\'') ++text;
    return *text == '.' ? text + 1 : NULL;
}

/* A part of several: NAME or NAME[k], as 0, 1, ...; -1: it is another. */
static int read_part(const char *text, const char *part)
{
    const size_t length = strlen(part);
    char *end;
    if (strncmp(text, part, length) != 0) return -1;
    if (!text[length]) return 0;
    if (text[length] != '[') return -1;
    const long k = strtol(text + length + 1, &end, 10);
    return k >= 1 && k <= 2 * MBSR_MAX_D && strcmp(end, "]") == 0 ? (int)k - 1 : -1;
}

/* What signals belong to, as names begin. */
enum { OF_BODY, OF_FORCE, OF_CLOSURE, OWNERS };
static const char *const owner[] = {"body", "force element", "closure"},
                         *const room[] = {"bodies.", "forces.", "closures."},
                         *const label_of[] = {"body", "force", "closure"};

/* The body, element or closure of that label; -1: none. */
static int find_labelled(const mbsr_model *m, int kind, const char *label)
{
    char made[LABEL];
    const int count = kind == OF_FORCE     ? mbsr_model_forces(m)
                      : kind == OF_CLOSURE ? mbsr_model_closures(m)
                                           : mbsr_model_bodies(m);
    for (int k = 0; k < count; ++k) {
        mbsr_force_def def = {.name = NULL};
        if (kind == OF_FORCE) (void)mbsr_force_definition(m, k, &def);
        const char *given = kind == OF_FORCE     ? def.name
                            : kind == OF_CLOSURE ? mbsr_closure_name(m, k)
                                                 : mbsr_body_name(m, k);
        mbsri_print(made, sizeof made, "%s%d", label_of[kind], k);
        if (strcmp(given && *given ? given : made, label) == 0) return k;
    }
    return -1;
}

static bool signal_of_motion(const mbsr_model *m, mbsr_signal_kind kind, int id, const char *part,
                             mbsr_signal *out)
{
    const int at = read_part(part, "motion");
    if (at < 0 || at >= mbsri_motions_of(m, kind, id)) return false;
    *out = (mbsr_signal){.kind = kind, .id = id, .part = at};
    return true;
}

static bool signal_of_body(const mbsr_model *m, int body, const char *part, mbsr_signal *out)
{
    if (signal_of_motion(m, MBSR_SIGNAL_MOTION, body, part, out)) return true;
    static const char *const rates[] = {"tau", "q", "u"};
    int u, n;
    mbsr_body_coordinates(m, body, NULL, NULL, &u, &n);
    for (int k = 0; k < 3; ++k) {
        const int at = read_part(part, rates[k]);
        if (at < 0 || at >= n) continue;
        *out = (mbsr_signal){.kind = k == 2 ? MBSR_SIGNAL_RATE : MBSR_SIGNAL_JOINT, .id = u + at};
        return true;
    }
    if (strlen(part) != 1 || *part < 'x' || *part > 'z') return false;
    *out = (mbsr_signal){.kind = MBSR_SIGNAL_POINT, .id = body, .part = *part - 'x'};
    return true;
}

static bool signal_of_force(const mbsr_model *m, int force, const char *part, mbsr_signal *out)
{
    mbsr_force_def def;
    mbsr_signal made = {.kind = MBSR_SIGNAL_FORCE, .id = force};
    if (mbsr_force_definition(m, force, &def) || def.table->flags & MBSR_FORCE_EVERY_BODY)
        return false;
    while (made.place + 1 < def.bodies && mbsri_body_of_force(m, force, made.place) == MBSR_GROUND)
        ++made.place;
    const int body = mbsri_body_of_force(m, force, made.place), f = read_part(part, "f"),
              tau = read_part(part, "tau");
    if (body == MBSR_GROUND) return false;
    const int size = mbsr_body_dimension(m, body);
    made.part = f >= 0 && f < size ? f : tau >= 0 ? size + tau : -1;
    if (made.part < 0 || made.part >= numbers_of_force(m, force, made.place)) return false;
    *out = made;
    return true;
}

int mbsr_signal_find(const mbsr_model *model, const mbsr_parameters *list, const char *text,
                     mbsr_signal *signal, mbsr_error *error)
{
    static const char function[] = "mbsr_signal_find";
    mbsr_model_def def;
    if (!model || !text || !signal)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", function,
                          !model  ? "model"
                          : !text ? "name"
                                  : "signal");
    if (mbsr_model_definition(model, &def))
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", function);
    const int parameter = list ? mbsr_parameters_find(list, text) : MBSR_NONE;
    if (parameter >= 0) {
        *signal = (mbsr_signal){.kind = MBSR_SIGNAL_PARAMETER, .id = parameter};
        return MBSR_OK;
    }
    char label[LABEL];
    int kind = 0;
    while (kind < OWNERS && strncmp(text, room[kind], strlen(room[kind])) != 0) ++kind;
    const char *part = kind < OWNERS ? read_label(text + strlen(room[kind]), label) : NULL;
    if (!part)
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: %.100s: names are bodies.NAME.PART, forces.NAME.PART, "
                          "closures.NAME.PART, or those of parameters",
                          function, text);
    const int id = find_labelled(model, kind, label);
    if (id < 0)
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: there is no %s '%.100s'", function, owner[kind], label);
    if (kind == OF_BODY    ? signal_of_body(model, id, part, signal)
        : kind == OF_FORCE ? signal_of_force(model, id, part, signal)
                           : signal_of_motion(model, MBSR_SIGNAL_CLOSURE_MOTION, id, part, signal))
        return MBSR_OK;
    return mbsri_fail(error, MBSR_ERR_VALUE, kind == OF_BODY ? id : MBSR_NONE,
                      kind == OF_FORCE ? id : MBSR_NONE, "%s: %s '%.100s' has no %.40s", function,
                      owner[kind], label, part);
}

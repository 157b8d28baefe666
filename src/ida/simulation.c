/* A model, its data and a driver in one hand.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/error.h"
#include "ida/given.h"

#include <mbsrank/simulation.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Keeps the first failure, with its error; returns the status. */
static int note(mbsr_simulation *s, int status, const mbsr_error *error)
{
    if (status == MBSR_OK || status == MBSR_EVENT) return status;
    s->error = *error;
    s->error.status = status;
    return s->status = status;
}

static int refuse_run(mbsr_simulation *s, int status, const char *text)
{
    mbsr_error error;
    mbsri_ida_refuse(&error, status, "%s", text);
    return note(s, status, &error);
}

mbsr_simulation mbsr_simulation_begin(const mbsr_model_def *def)
{
    mbsr_simulation s = {.error = {MBSR_OK, MBSR_NONE, MBSR_NONE, ""}};
    mbsr_error error;
    note(&s, mbsr_model_create(def, &s.model, &error), &error);
    return s;
}

mbsr_simulation mbsr_simulation_of(mbsr_model *model)
{
    mbsr_simulation s = {.model = model, .error = {MBSR_OK, MBSR_NONE, MBSR_NONE, ""}};
    if (!model) refuse_run(&s, MBSR_ERR_NULL, "mbsr_simulation_of: model is NULL");
    return s;
}

/* ---- building ---- */

/* The id of what has been added; none after a failure. */
static int added(mbsr_simulation *s, int status, int id)
{
    return note(s, status, mbsr_model_error(s->model)) ? MBSR_NONE : id;
}

int mbsr_simulation_add_body(mbsr_simulation *s, const char *name, int parent, mbsr_joint joint,
                             mbsr_inertia inertia)
{
    int id = MBSR_NONE;
    mbsr_body_def def = mbsr_default_body_def();
    if (!s || s->status) return MBSR_NONE;
    def.name = name;
    def.parent = parent;
    def.joint = joint;
    def.inertia = inertia;
    const int status = mbsr_model_add_body(s->model, &def, &id);
    return added(s, status, id);
}

int mbsr_simulation_add_force(mbsr_simulation *s, mbsr_force_def force)
{
    int id = MBSR_NONE;
    if (!s || s->status) return MBSR_NONE;
    const int status = mbsr_model_add_force(s->model, &force, &id);
    return added(s, status, id);
}

int mbsr_simulation_add_closure(mbsr_simulation *s, mbsr_closure_def closure)
{
    int id = MBSR_NONE;
    if (!s || s->status) return MBSR_NONE;
    const int status = mbsr_model_add_closure(s->model, &closure, &id);
    return added(s, status, id);
}

/* ---- what else belongs to it ---- */

typedef struct mbsr_simulation_part {
    mbsr_table *table;
    mbsr_data *data;
    struct mbsr_simulation_part *next;
} part;

/* A new one, empty; NULL, with a failure, without memory. */
static part *add_part(mbsr_simulation *s, const char *no_memory)
{
    part *made = calloc(1, sizeof *made);
    if (!made) {
        refuse_run(s, MBSR_ERR_NO_MEMORY, no_memory);
        return NULL;
    }
    made->next = s->parts;
    return s->parts = made;
}

mbsr_table *mbsr_simulation_add_table(mbsr_simulation *s, mbsr_table_kind kind, int points,
                                      const double *x, const double *value)
{
    mbsr_table_def def = mbsr_default_table_def();
    mbsr_error error;
    if (!s || s->status) return NULL;
    part *made = add_part(s, "mbsr_simulation_add_table: no memory for a table");
    if (!made) return NULL;
    def.kind = kind;
    def.points = points;
    def.x = x;
    def.value = value;
    note(s, mbsr_table_create(&def, &made->table, &error), &error);
    return made->table;
}

static int finish(mbsr_simulation *s)
{
    if (mbsr_model_bodies(s->model) >= 0) return MBSR_OK;
    return note(s, mbsr_model_finish(s->model), mbsr_model_error(s->model));
}

mbsr_data *mbsr_simulation_add_data(mbsr_simulation *s)
{
    mbsr_error error;
    if (!s || s->status || finish(s)) return NULL;
    part *made = add_part(s, "mbsr_simulation_add_data: no memory for data");
    if (!made) return NULL;
    note(s, mbsr_data_create(s->model, &made->data, &error), &error);
    return made->data;
}

/* ---- start ---- */

/* The model finished, its data and the vectors, once. */
static int prepare(mbsr_simulation *s, mbsr_dae_form form)
{
    mbsr_error error;
    if (finish(s)) return s->status;
    if (!s->data && note(s, mbsr_data_create(s->model, &s->data, &error), &error)) return s->status;
    const int size = mbsr_dae_size(s->model, form), nq = mbsr_model_nq(s->model),
              nu = mbsr_model_nu(s->model);
    if (size < 0) {
        return refuse_run(s, MBSR_ERR_VALUE,
                          "mbsr_simulation_start: there is no such form, or not with closures");
    }
    const int rows = mbsr_model_rows(s->model);
    s->q = calloc((size_t)(nq + 2 * nu + rows) + 2 * (size_t)size + 1, sizeof *s->q);
    if (!s->q)
        return refuse_run(s, MBSR_ERR_NO_MEMORY, "mbsr_simulation_start: no memory for a state");
    s->u = s->q + nq;
    s->udot = s->u + nu;
    s->lambda = s->udot + nu;
    s->y = s->lambda + rows;
    s->yp = s->y + size;
    s->form = form;
    return MBSR_OK;
}

/* The driver's state in joint coordinates, with the data at its accelerations. The index-1 form as
 * it is interpolated has none: at its velocities. */
static int evaluate_state(mbsr_simulation *s)
{
    int status = mbsr_ida_motion(s->ida, s->q, s->u, s->udot, s->lambda);
    if (status != MBSR_ERR_VALUE) return note(s, status, mbsr_ida_error(s->ida));
    for (int k = 0; k < mbsr_model_nu(s->model); ++k) s->udot[k] = NAN;
    status = mbsr_dae_unpack(s->model, s->data, s->form, s->t, s->y, s->q, s->u);
    if (!status) status = mbsr_stage_positions(s->model, s->data, s->t, s->q);
    if (!status) status = mbsr_stage_velocities(s->model, s->data, s->u);
    return note(s, status, mbsr_data_error(s->data));
}

static int give(mbsr_simulation *s, mbsri_given given)
{
    if (!s) return MBSR_ERR_NULL;
    if (s->status) return s->status;
    if (!mbsri_given_add(&s->given, given)) return MBSR_OK;
    return refuse_run(s, MBSR_ERR_NO_MEMORY,
                      given.rate ? "mbsr_simulation_set_rate: no memory for a value"
                                 : "mbsr_simulation_set_position: no memory for a value");
}

int mbsr_simulation_set_position(mbsr_simulation *s, int body, int coordinate, double value)
{
    return give(s, (mbsri_given){false, body, coordinate, value, NULL});
}

int mbsr_simulation_set_rate(mbsr_simulation *s, int body, int coordinate, double value)
{
    return give(s, (mbsri_given){true, body, coordinate, value, NULL});
}

int mbsr_simulation_set_none(mbsr_simulation *s)
{
    if (!s) return MBSR_ERR_NULL;
    mbsri_given_free(s->given);
    s->given = NULL;
    return s->status;
}

/* The consistent state near q and u that has what is given, into y and yp. */
static int make_consistent(mbsr_simulation *s)
{
    const int nu = mbsr_model_nu(s->model);
    mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    mbsr_error error;
    int *keep = calloc(2 * (size_t)nu + 1, sizeof *keep);
    if (!keep)
        return refuse_run(s, MBSR_ERR_NO_MEMORY,
                          "mbsr_simulation_start: no memory for what is given");
    opt.keep_position = keep;
    opt.keep_rate = keep + nu;
    if (!note(s, mbsri_given_apply(s->given, s->model, s->q, s->u, keep, keep + nu, &error),
              &error)) {
        int status = mbsr_dae_pack(s->model, s->data, s->form, s->t, s->q, s->u, s->y);
        if (!status)
            status =
                mbsr_dae_consistent(s->model, s->data, s->form, s->t, s->y, s->yp, &opt, &s->start);
        note(s, status, mbsr_data_error(s->data));
    }
    free(keep);
    return s->status;
}

int mbsr_simulation_start(mbsr_simulation *s, const mbsr_ida_opt *opt, double t, const double *q,
                          const double *u)
{
    if (!s) return MBSR_ERR_NULL;
    if (s->status) return s->status;
    const mbsr_ida_opt standard = mbsr_default_ida_opt();
    mbsr_error error;
    if (!opt) opt = &standard;
    mbsr_ida_destroy(s->ida);
    mbsr_small_masses_destroy(s->small);
    s->ida = NULL;
    s->small = NULL;
    double *before = s->q; /* q and u may be there */
    const int prepared = prepare(s, opt->form);
    if (!prepared) mbsri_given_nothing(s->model, s->q);
    if (!prepared && q) memcpy(s->q, q, (size_t)mbsr_model_nq(s->model) * sizeof *q);
    if (!prepared && u) memcpy(s->u, u, (size_t)mbsr_model_nu(s->model) * sizeof *u);
    if (s->q != before) free(before);
    if (prepared) return prepared;
    s->t = t;
    if (s->form == MBSR_DAE_INDEX1) mbsr_index1_reset(s->model, s->data);
    if (make_consistent(s)) return s->status;
    if (note(s, mbsr_ida_create(s->model, s->data, opt, &s->ida, &error), &error)) return s->status;
    if (note(s, mbsr_ida_start(s->ida, t, s->y, s->yp), mbsr_ida_error(s->ida))) return s->status;
    return evaluate_state(s);
}

/* ---- masses that the model neglects ---- */

int mbsr_simulation_watch_masses(mbsr_simulation *s, const mbsr_small_masses_opt *opt)
{
    static const mbsr_small_part none = {MBSR_NONE, 0};
    static const char function[] = "mbsr_simulation_watch_masses";
    if (!s) return MBSR_ERR_NULL;
    if (s->status) return s->status;
    if (!s->ida || s->form != MBSR_DAE_MOMENTUM) {
        mbsr_error error;
        const int status = s->ida ? MBSR_ERR_VALUE : MBSR_ERR_SEQUENCE;
        mbsri_ida_refuse(&error, status, "%s: %s", function,
                         s->ida ? "only the momentum form is served"
                                : "call mbsr_simulation_start first");
        return note(s, status, &error);
    }
    mbsr_small_masses_opt named = opt ? *opt : mbsr_default_small_masses_opt();
    if (!named.part) named.part = &none; /* none are looked for besides */
    mbsr_error error;
    mbsr_small_masses_destroy(s->small);
    s->small = NULL;
    s->watched = s->t;
    if (note(s, mbsr_small_masses_create(s->model, &named, &s->small, &error), &error))
        return s->status;
    return note(s, mbsr_small_masses_start(s->small, s->t, s->q, s->u),
                mbsr_small_masses_error(s->small));
}

int mbsr_simulation_get_masses(mbsr_simulation *s, mbsr_small_masses_report *report)
{
    if (!s) return MBSR_ERR_NULL;
    if (s->status) return s->status;
    if (!s->small)
        return refuse_run(s, MBSR_ERR_SEQUENCE,
                          "mbsr_simulation_get_masses: call mbsr_simulation_watch_masses first");
    return note(s, mbsr_small_masses_get_report(s->small, report),
                mbsr_small_masses_error(s->small));
}

static int watch(mbsr_simulation *s)
{
    if (!s->small || !(s->t > s->watched)) return MBSR_OK;
    s->watched = s->t;
    const int status = mbsr_small_masses_step(s->small, s->t, s->y, s->yp);
    return note(s, status, mbsr_small_masses_error(s->small));
}

/* ---- running ---- */

static int run(mbsr_simulation *s, double t,
               int (*advance)(mbsr_ida *ida, double t_end, double *t, double *y, double *yp),
               const char *early)
{
    if (!s) return MBSR_ERR_NULL;
    if (s->status) return s->status;
    if (!s->ida) return refuse_run(s, MBSR_ERR_SEQUENCE, early);
    const int status = note(s, advance(s->ida, t, NULL, NULL, NULL), mbsr_ida_error(s->ida));
    const int handed = mbsr_ida_state(s->ida, &s->t, s->y, s->yp);
    if (handed) return status == MBSR_OK ? note(s, handed, mbsr_ida_error(s->ida)) : status;
    if (status == MBSR_OK || status == MBSR_EVENT)
        return evaluate_state(s) || watch(s) ? s->status : status;
    (void)mbsr_dae_unpack(s->model, s->data, s->form, s->t, s->y, s->q, s->u);
    return status;
}

int mbsr_simulation_to(mbsr_simulation *s, double t)
{
    return run(s, t, mbsr_ida_advance, "mbsr_simulation_to: call mbsr_simulation_start first");
}

int mbsr_simulation_sample(mbsr_simulation *s, double t)
{
    return run(s, t, mbsr_ida_sample, "mbsr_simulation_sample: call mbsr_simulation_start first");
}

/* ---- what a state has ---- */

/* A copy of n numbers of the state. */
static int tell(mbsr_simulation *s, const double *numbers, int n, double *to, const char *early)
{
    if (!s || !to) return MBSR_ERR_NULL;
    if (!s->ida && s->status) return s->status;
    if (!s->ida) return refuse_run(s, MBSR_ERR_SEQUENCE, early);
    if (n > 0) memcpy(to, numbers, (size_t)n * sizeof *to);
    return s->status;
}

int mbsr_simulation_accelerations(mbsr_simulation *s, double *udot)
{
    return tell(s, s ? s->udot : NULL, s && s->ida ? mbsr_model_nu(s->model) : 0, udot,
                "mbsr_simulation_accelerations: call mbsr_simulation_start first");
}

int mbsr_simulation_reactions(mbsr_simulation *s, double *lambda)
{
    return tell(s, s ? s->lambda : NULL, s && s->ida ? mbsr_model_rows(s->model) : 0, lambda,
                "mbsr_simulation_reactions: call mbsr_simulation_start first");
}

int mbsr_simulation_check(mbsr_simulation *s, int status)
{
    if (!s) return MBSR_ERR_NULL;
    if (s->status) return s->status;
    note(s, status, s->data ? mbsr_data_error(s->data) : mbsr_model_error(s->model));
    return s->status;
}

int mbsr_simulation_get_stats(const mbsr_simulation *s, mbsr_ida_stats *stats)
{
    if (stats) *stats = (mbsr_ida_stats){0};
    if (!s || !stats) return MBSR_ERR_NULL;
    return s->ida ? mbsr_ida_get_stats(s->ida, stats) : MBSR_OK;
}

void mbsr_simulation_forgive(mbsr_simulation *s)
{
    if (!s || !s->model) return;
    s->status = MBSR_OK;
    s->error = (mbsr_error){MBSR_OK, MBSR_NONE, MBSR_NONE, ""};
}

void mbsr_simulation_end(mbsr_simulation *s)
{
    if (!s) return;
    mbsr_ida_destroy(s->ida);
    mbsr_small_masses_destroy(s->small);
    mbsr_data_destroy(s->data);
    for (const part *p = s->parts; p; p = p->next) mbsr_data_destroy(p->data);
    mbsr_model_destroy(s->model);
    while (s->parts) {
        part *first = s->parts;
        s->parts = first->next;
        mbsr_table_destroy(first->table);
        free(first);
    }
    mbsri_given_free(s->given);
    free(s->q);
    s->given = NULL;
    s->model = NULL;
    s->data = NULL;
    s->ida = NULL;
    s->small = NULL;
    s->q = s->u = s->udot = s->lambda = s->y = s->yp = NULL;
}

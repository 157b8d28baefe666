/* The library as a module of WebAssembly: what mbsrank.js calls beside functions of the headers.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A model is opened as the program opens it, from files that the host shows by WASI; complaints go
 * to its standard error. Models made of others share what was read and the shapes that touch. */
#define _POSIX_C_SOURCE 200809L
#include "modes.h"
#include "program/folders.h"
#include "program/page.h"
#include "program/touching.h"

#include <mbsrank/parameters.h>
#include <mbsrank/simulation.h>
#include <mbsrank/stepper.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT(name) __attribute__((export_name(#name)))

/* What was read, for all models made of it. */
typedef struct source {
    int users;
    char *texts; /* of the options */
    program_options options;
    program_model read; /* its model is that of the file; data at which nothing is kept */
    touching touching;
} source;

typedef struct web_model {
    int users; /* its own, runs and steppers */
    source *source;
    mbsr_model *model;
    int owned; /* the model is this one's, else the source's */
    mbsr_data *data;
    double held[6]; /* of a model that is pulled: moment (N m) and force (N) on the point */
} web_model;

/* The last failure of a function here, as the library tells it. */
static mbsr_error failure;

EXPORT(web_error) const mbsr_error *web_error(void)
{
    return &failure;
}

/* The host decides which files there are. */
bool may_read(const program_options *o, const char *path)
{
    FILE *file = fopen(path, "rb");
    (void)o;
    if (file) fclose(file);
    return file != NULL;
}

static int fail(const mbsr_error *why)
{
    failure = *why;
    return failure.status;
}

static int out_of_memory(void)
{
    failure = (mbsr_error){MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "no memory"};
    return failure.status;
}

/* ---- models ---- */

static void release(source *s)
{
    if (--s->users > 0) return;
    mbsr_model_destroy(s->touching.model);
    touching_free(&s->touching);
    close_model(&s->read);
    free(s->texts);
    free(s);
}

EXPORT(web_close) void web_close(web_model *w)
{
    if (--w->users > 0) return;
    mbsr_data_destroy(w->data);
    if (w->owned) mbsr_model_destroy(w->model);
    release(w->source);
    free(w);
}

/* Takes a finished model, owned or not, with data of its own; NULL: it cannot, and all is gone. */
static web_model *take(web_model *w, source *s, mbsr_model *model, int owned)
{
    mbsr_error error = {.text = ""};
    mbsr_data *data = NULL;
    const int status = w ? mbsr_data_create(model, &data, &error) : out_of_memory();
    if (status) {
        if (w) fail(&error);
        if (owned) mbsr_model_destroy(model);
        free(w);
        return NULL;
    }
    w->users = 1;
    w->source = s;
    w->model = model;
    w->owned = owned;
    w->data = data;
    ++s->users;
    return w;
}

static int read_options(source *s, int count)
{
    char **argument = calloc((size_t)count + 1, sizeof *argument), *text = s->texts;
    int code = argument ? DONE : FAILED;
    for (int k = 0; k < count && argument; ++k, text += strlen(text) + 1) argument[k] = text;
    for (int at = 0; at < count && !code; ++at) {
        if (!common_option(count, argument, &at, &s->options, &code))
            code = complain(USAGE, "there is no option %s", argument[at]);
        if (at < 0) code = USAGE;
    }
    free(argument);
    return code;
}

/* A model by the options of the program, `count` texts one behind the other, which are this one's
 * from now on; NULL after a complaint, or a failure. */
EXPORT(web_open) web_model *web_open(char *texts, int count, int touch)
{
    source *s = calloc(1, sizeof *s);
    web_model *w = NULL;
    failure = (mbsr_error){.status = MBSR_OK};
    if (!s) {
        free(texts);
        out_of_memory();
        return NULL;
    }
    *s = (source){.users = 1, .texts = texts};
    s->options = (program_options){.limits = true, .friction = true, .anywhere = true};
    int code = read_options(s, count);
    const double *q, *u;
    if (!code) code = open_model(&s->options, true, &s->read);
    if (!code) code = start_state(&s->options, &s->read, &q, &u);
    if (!code) code = touching_make(&s->read, q, touch != 0, true, &s->touching);
    if (!code)
        w = take(calloc(1, sizeof *w), s, s->touching.model ? s->touching.model : s->read.model, 0);
    release(s);
    return w;
}

EXPORT(web_model_of) mbsr_model *web_model_of(const web_model *w)
{
    return w->model;
}

EXPORT(web_data_of) mbsr_data *web_data_of(const web_model *w)
{
    return w->data;
}

/* The controls of its actuators, one each. */
EXPORT(web_controls) double *web_controls(const web_model *w)
{
    return w->source->read.file->control;
}

/* q (nq), u (nu) and controls of a key; of -1 the state of the options. */
EXPORT(web_key) const double *web_key(const web_model *w, int key, int which)
{
    const mbsr_file *f = w->source->read.file;
    if (key < 0) {
        const double *q, *u;
        start_state(&w->source->options, &w->source->read, &q, &u);
        return which == 0 ? q : which == 1 ? u : NULL;
    }
    return which == 0 ? f->key[key].q : which == 1 ? f->key[key].u : f->key[key].control;
}

/* The same with other values of parameters, by name. */
EXPORT(web_with)
web_model *web_with(const web_model *w, int count, const char *names, const double *value)
{
    mbsr_parameters *list = NULL;
    mbsr_model *made = NULL;
    mbsr_error error = {.text = ""};
    int *which = calloc((size_t)count + 1, sizeof *which);
    if (!which) out_of_memory();
    int status = which ? mbsr_parameters_create(w->model, &list, &error) : MBSR_ERR_NO_MEMORY;
    for (int k = 0; k < count && !status; ++k, names += strlen(names) + 1) {
        which[k] = mbsr_parameters_find(list, names);
        if (which[k] != MBSR_NONE) continue;
        error = (mbsr_error){.status = status = MBSR_ERR_ID, MBSR_NONE, MBSR_NONE, ""};
        snprintf(error.text, sizeof error.text, "there is no parameter '%.200s'", names);
    }
    if (!status) status = mbsr_parameters_model(list, count, which, value, &made, &error);
    if (status && which) fail(&error);
    mbsr_parameters_destroy(list);
    free(which);
    return status ? NULL : take(calloc(1, sizeof *w), w->source, made, 1);
}

/* ---- pulling ---- */

/* The same with a spring (N/m, N s/m) from a point of a body (body axes) to one in the world,
 * `anchor`; web_held has the moment and force that the caller holds at the point besides, by which
 * the spring's other end moves. */
EXPORT(web_pulled)
web_model *web_pulled(const web_model *w, int body, const double point[3], const double anchor[3],
                      double stiffness, double damping)
{
    const double k[6] = {0, 0, 0, stiffness, stiffness, stiffness},
                 c[6] = {0, 0, 0, damping, damping, damping};
    mbsr_frame from = mbsr_frame_identity(), to = from;
    mbsr_error error = {.text = ""};
    mbsr_model *made = NULL;
    web_model *pulled = calloc(1, sizeof *pulled);
    int status = pulled ? mbsr_model_copy(w->model, &made, &error) : out_of_memory();
    if (status && pulled) fail(&error);
    if (!status) {
        memcpy(from.x, anchor, sizeof from.x);
        memcpy(to.x, point, sizeof to.x);
        mbsr_force_def spring = mbsr_force_bushing(MBSR_GROUND, &from, body, &to, k, c),
                       hand = mbsr_force_wrench(body, point, 0, mbsr_stored_force, pulled->held);
        spring.name = "spring of the hand";
        hand.name = "hand";
        status = mbsr_model_add_force(made, &spring, NULL);
        if (!status) status = mbsr_model_add_force(made, &hand, NULL);
        if (!status) status = mbsr_model_finish(made);
        if (status) fail(mbsr_model_error(made));
    }
    if (!status) return take(pulled, w->source, made, 1);
    mbsr_model_destroy(made);
    free(pulled);
    return NULL;
}

EXPORT(web_held) double *web_held(web_model *w)
{
    return w->held;
}

/* ---- texts: of JSON, but for reports to be read; the caller frees them; NULL: a complaint ---- */

enum { WEB_INFO, WEB_PARAMETERS, WEB_REPORT, WEB_REPORT_TEXT, WEB_PAGE };

/* What the page of the program has of it, near q and u. */
static int write_page(FILE *to, const web_model *w, const program_model *m, const double *q,
                      const double *u)
{
    motion shown;
    touching none = {.contacts = NULL};
    int code = motion_make(m, &none, NULL, NULL, NULL, q, u, &shown);
    if (!code) code = page_write(to, &(page){&w->source->options, m, &shown, NULL, q, u});
    motion_free(&shown);
    return code;
}

EXPORT(web_text) char *web_text(const web_model *w, int what, const double *q, const double *u)
{
    program_model m = w->source->read;
    char *text = NULL;
    size_t size = 0;
    FILE *to = open_memstream(&text, &size);
    if (!to) {
        out_of_memory();
        return NULL;
    }
    m.model = w->model;
    m.data = w->data;
    int code = what == WEB_INFO         ? info_write(to, &w->source->options, &m, q, true)
               : what == WEB_PARAMETERS ? parameters_write(to, &m, true)
               : what == WEB_PAGE       ? write_page(to, w, &m, q, u)
                                        : report_write(to, &m, q, u, what == WEB_REPORT);
    if (fclose(to) || (code > UNDETERMINED)) {
        free(text);
        return NULL;
    }
    return text;
}

/* ---- where bodies are ---- */

/* Axes by columns, then origin: 12 numbers a body, at the state of the data. */
static int find_poses(const mbsr_model *model, mbsr_data *data, double *to)
{
    int status = MBSR_OK;
    for (int k = 0; k < mbsr_model_bodies(model) && !status; ++k, to += 12) {
        double pose[MBSR_POSE_SIZE];
        status = mbsr_body_pose(model, data, k, pose);
        memcpy(to, pose + MBSR_POSE_R, 9 * sizeof *to);
        memcpy(to + 9, pose + MBSR_POSE_X, 3 * sizeof *to);
    }
    return status;
}

EXPORT(web_poses) int web_poses(const web_model *w, double t, const double *q, double *to)
{
    int status = mbsr_stage_positions(w->model, w->data, t, q);
    if (!status) status = find_poses(w->model, w->data, to);
    return status ? fail(mbsr_data_error(w->data)) : MBSR_OK;
}

/* Kinetic and potential energy, J. */
EXPORT(web_energy)
int web_energy(const web_model *w, double t, const double *q, const double *u, double to[2])
{
    int status = mbsr_stage_positions(w->model, w->data, t, q);
    if (!status) status = mbsr_stage_velocities(w->model, w->data, u);
    if (!status) status = mbsr_energy(w->model, w->data, to, to + 1);
    return status ? fail(mbsr_data_error(w->data)) : MBSR_OK;
}

/* The mass matrix (nu x nu) at q. */
EXPORT(web_mass_matrix)
int web_mass_matrix(const web_model *w, double t, const double *q, double *matrix)
{
    int status = mbsr_stage_positions(w->model, w->data, t, q);
    if (!status) status = mbsr_mass_matrix(w->model, w->data, matrix);
    return status ? fail(mbsr_data_error(w->data)) : MBSR_OK;
}

/* Size and rank of each joint's block, two numbers a body, at q and u. */
EXPORT(web_ranks)
int web_ranks(const web_model *w, double t, const double *q, const double *u, int *to)
{
    int status = mbsr_stage_positions(w->model, w->data, t, q);
    if (!status) status = mbsr_stage_velocities(w->model, w->data, u);
    if (!status) status = mbsr_stage_forces(w->model, w->data, NULL);
    if (!status) status = mbsr_stage_backward(w->model, w->data);
    for (int k = 0; k < mbsr_model_bodies(w->model) && !status; ++k) {
        mbsr_rank_info info;
        status = mbsr_body_rank(w->model, w->data, k, &info);
        to[2 * k] = info.n;
        to[2 * k + 1] = info.rank;
    }
    return status ? fail(mbsr_data_error(w->data)) : MBSR_OK;
}

/* `count` modes that swing about a state, two numbers each, which the caller frees; NULL: a
 * failure. */
EXPORT(web_modes)
double *web_modes(const web_model *w, double t, const double *q, const double *u, int *count)
{
    double *found;
    return web_find_modes(w->model, w->data, t, q, u, &found, count, &failure) ? NULL : found;
}

/* ---- runs of the driver ---- */

/* The model, which its copy shares elements with, lives as long. */
typedef struct web_run {
    mbsr_simulation s;
    web_model *owner;
} web_run;

EXPORT(web_run_end) void web_run_end(web_run *run)
{
    mbsr_simulation_end(&run->s);
    web_close(run->owner);
    free(run);
}

/* One of a copy of the model, at the consistent state near q and u; NULL: there is none. */
EXPORT(web_run)
web_run *web_run_begin(web_model *w, double t, const double *q, const double *u,
                       const double number[6])
{
    web_run *run = malloc(sizeof *run);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_model *copy;
    mbsr_error error;
    if (!run || mbsr_model_copy(w->model, &copy, &error)) {
        if (run)
            fail(&error);
        else
            out_of_memory();
        free(run);
        return NULL;
    }
    opt.rtol = number[0];
    opt.atol = number[1];
    opt.initial_step = number[2];
    opt.max_step = number[3];
    opt.max_order = (int)number[4];
    opt.max_steps = (long)number[5];
    *run = (web_run){mbsr_simulation_of(copy), w};
    ++w->users;
    if (!mbsr_simulation_start(&run->s, &opt, t, q, u)) return run;
    fail(&run->s.error);
    web_run_end(run);
    return NULL;
}

EXPORT(web_run_to) int web_run_to(web_run *run, double t)
{
    mbsr_simulation *s = &run->s;
    mbsr_simulation_forgive(s); /* what was refused before */
    return mbsr_simulation_to(s, t) ? fail(&s->error) : MBSR_OK;
}

EXPORT(web_run_poses) int web_run_poses(web_run *run, double *to)
{
    mbsr_simulation *s = &run->s;
    const int status = find_poses(s->model, s->data, to);
    return status ? fail(mbsr_data_error(s->data)) : MBSR_OK;
}

/* Kinetic and potential energy at the present state, J. */
EXPORT(web_run_energy) int web_run_energy(web_run *run, double to[2])
{
    mbsr_simulation *s = &run->s;
    const int status = mbsr_energy(s->model, s->data, to, to + 1);
    return status ? fail(mbsr_data_error(s->data)) : MBSR_OK;
}

/* Places of q, u, u' and loop forces. */
EXPORT(web_run_state) void web_run_state(const web_run *run, double *t, const double *to[4])
{
    const mbsr_simulation *s = &run->s;
    *t = s->t;
    to[0] = s->q;
    to[1] = s->u;
    to[2] = s->udot;
    to[3] = s->lambda;
}

/* Steps, residuals, Newton iterations, their failures, failed error tests, factorisations, solves,
 * the last step in s. */
EXPORT(web_run_stats) void web_run_stats(const web_run *run, double to[8])
{
    mbsr_ida_stats cost;
    mbsr_simulation_get_stats(&run->s, &cost);
    const double number[8] = {(double)cost.steps,
                              (double)cost.residuals,
                              (double)cost.newton_iterations,
                              (double)cost.newton_failures,
                              (double)cost.error_test_failures,
                              (double)cost.factorisations,
                              (double)cost.solves,
                              cost.last_step};
    memcpy(to, number, sizeof number);
}

/* ---- steps of fixed size ---- */

typedef struct web_stepper {
    web_model *owner;
    const mbsr_model *model;
    mbsr_data *data;
    mbsr_stepper *stepper;
} web_stepper;

EXPORT(web_stepper_end) void web_stepper_end(web_stepper *s)
{
    mbsr_stepper_destroy(s->stepper);
    mbsr_data_destroy(s->data);
    web_close(s->owner);
    free(s);
}

/* Steps of h (s) by a method of order 1 or 2 from the consistent state near q and u; NULL: there
 * is none. */
EXPORT(web_stepper)
web_stepper *web_stepper_begin(web_model *w, double h, int order, double t, const double *q,
                               const double *u)
{
    web_stepper *s = calloc(1, sizeof *s);
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    mbsr_error error = {.text = ""};
    if (!s) {
        out_of_memory();
        return NULL;
    }
    opt.h = h;
    opt.order = order;
    s->owner = w;
    s->model = w->model;
    ++w->users;
    int status = mbsr_data_create(w->model, &s->data, &error);
    if (!status) status = mbsr_stepper_create(w->model, s->data, &opt, &s->stepper, &error);
    if (status) fail(&error);
    if (!status && (status = mbsr_stepper_start(s->stepper, t, q, u)))
        fail(mbsr_stepper_error(s->stepper));
    if (!status) return s;
    web_stepper_end(s);
    return NULL;
}

/* `count` steps, as many as succeed. */
EXPORT(web_stepper_step) int web_stepper_step(web_stepper *s, int count)
{
    for (int k = 0; k < count; ++k)
        if (mbsr_stepper_step(s->stepper)) return fail(mbsr_stepper_error(s->stepper));
    return MBSR_OK;
}

EXPORT(web_stepper_motion) int web_stepper_motion(web_stepper *s, double *t, double *q, double *u)
{
    return mbsr_stepper_motion(s->stepper, t, q, u);
}

EXPORT(web_stepper_poses) int web_stepper_poses(web_stepper *s, double *to)
{
    const int status = find_poses(s->model, s->data, to);
    return status ? fail(mbsr_data_error(s->data)) : MBSR_OK;
}

EXPORT(web_stepper_energy) int web_stepper_energy(web_stepper *s, double to[2])
{
    const int status = mbsr_energy(s->model, s->data, to, to + 1);
    return status ? fail(mbsr_data_error(s->data)) : MBSR_OK;
}

/* ---- batches ---- */

EXPORT(web_batch) mbsr_batch *web_batch(const web_model *w)
{
    mbsr_batch *batch;
    mbsr_error error;
    if (!mbsr_batch_create(w->model, &batch, &error)) return batch;
    fail(&error);
    return NULL;
}

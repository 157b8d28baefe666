/* Poses and reactions of a run: see motion.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/motion.h"

#include "program/columns.h"
#include "program/progress.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where the state stands in the table: a column for each number of q and u. */
typedef struct places {
    int nq, nu;
    int *q, *u;    /* -1: of no joint of the file */
    bool rates;    /* u is known */
    double *state; /* q, then u, then u' */
} places;

static bool allocate_motion(const program_model *m, int samples, places *at, motion *to)
{
    const size_t bodies = (size_t)m->file->bodies, all = (size_t)samples * bodies + 1;
    at->nq = mbsr_model_nq(m->model);
    at->nu = mbsr_model_nu(m->model);
    at->q = malloc((size_t)(at->nq + at->nu + 1) * sizeof *at->q);
    at->u = at->q + at->nq;
    at->state = calloc((size_t)(at->nq + 2 * at->nu) + 1, sizeof *at->state);
    to->samples = samples;
    to->time = calloc((size_t)samples + 1, sizeof *to->time);
    to->q = calloc((size_t)samples * (size_t)at->nq + 1, sizeof *to->q);
    to->pose = calloc(all, POSE_NUMBERS * sizeof *to->pose);
    to->reaction = calloc(all, REACTION_NUMBERS * sizeof *to->reaction);
    to->point = calloc(bodies + 1, 3 * sizeof *to->point);
    to->loop = calloc((size_t)mbsr_model_closures(m->model) + 1, sizeof *to->loop);
    return at->q && at->state && to->time && to->q && to->pose && to->reaction && to->point &&
           to->loop;
}

static void forget_reactions(motion *to, const char *why)
{
    free(to->reaction);
    free(to->loop_force);
    to->reaction = to->loop_force = NULL;
    snprintf(to->without, sizeof to->without, "%s", why);
}

/* The joint's point on each body. */
static void find_points(const program_model *m, motion *to)
{
    for (int k = 0; k < m->file->bodies; ++k) {
        mbsr_body_def def;
        mbsr_joint_chain chain;
        if (mbsr_body_definition(m->model, k, &def)) continue;
        if (mbsr_joint_chain_of(&def.joint, &chain)) continue;
        memcpy(to->point + 3 * (size_t)k, chain.B.x, sizeof chain.B.x);
    }
}

/* Closures whose table says where they act, by the first of their bodies that is not the ground. */
static bool find_loops(const program_model *m, motion *to)
{
    for (int k = 0; k < mbsr_model_closures(m->model); ++k) {
        mbsr_closure_def def;
        if (mbsr_closure_definition(m->model, k, &def) || !def.table->point) continue;
        const int place = def.body[0] == MBSR_GROUND ? 1 : 0;
        if (place >= def.bodies || def.body[place] == MBSR_GROUND) continue;
        to->loop[to->loops++] = (shown_loop){k, place, def.body[place]};
    }
    const size_t all = (size_t)to->samples * (size_t)to->loops + 1;
    to->loop_force = calloc(all, LOOP_NUMBERS * sizeof *to->loop_force);
    return to->loop_force != NULL;
}

/* Which column has which number; columns of one name are taken in turn. */
static int find_columns(const program_model *m, const char *path, const table *run, places *at)
{
    columns wanted;
    const int code = columns_make(m, "state", &wanted);
    int last = 0;
    at->rates = true;
    for (int k = 0; k < at->nq + at->nu; ++k) at->q[k] = -1;
    for (int k = 0; k < wanted.count && !code; ++k) {
        const column *c = wanted.list + k;
        const int found = table_find(run, c->name, last + 1);
        if (found >= 0) {
            (c->kind == COLUMN_Q ? at->q : at->u)[c->at] = last = found;
        } else if (c->kind == COLUMN_U) {
            at->rates = false;
        } else {
            const int missing = complain(
                NOT_READ, "%s has no column '%s': run without --output, or --output state, has all",
                path, c->name);
            free(wanted.list);
            return missing;
        }
    }
    free(wanted.list);
    return code;
}

/* ---- a sample ---- */

/* A status, as below. */
static int keep_poses(const program_model *m, float *to)
{
    for (int k = 0; k < m->file->bodies; ++k, to += POSE_NUMBERS) {
        double pose[MBSR_POSE_SIZE], quaternion[4];
        const int status = mbsr_body_pose(m->model, m->data, k, pose);
        if (status) return status;
        mbsr_rotation_quaternion(pose + MBSR_POSE_R, quaternion);
        for (int l = 0; l < 3; ++l) to[l] = (float)pose[MBSR_POSE_X + l];
        for (int l = 0; l < 4; ++l) to[3 + l] = (float)quaternion[l];
    }
    return MBSR_OK;
}

/* A wrench at the body's origin as force and as moment about the point `arm` away. */
static void keep_wrench(const double wrench[6], const double arm[3], float to[6])
{
    const double *F = wrench + 3;
    for (int l = 0; l < 3; ++l) {
        const int i = (l + 1) % 3, j = (l + 2) % 3;
        to[l] = (float)F[l];
        to[3 + l] = (float)(wrench[l] - arm[i] * F[j] + arm[j] * F[i]);
    }
}

/* Moments about the joint's point. */
static int keep_reactions(const program_model *m, const double *point, float *to)
{
    for (int k = 0; k < m->file->bodies; ++k, to += REACTION_NUMBERS, point += 3) {
        double pose[MBSR_POSE_SIZE], wrench[6], arm[3];
        int status = mbsr_body_pose(m->model, m->data, k, pose);
        if (!status) status = mbsr_joint_reaction(m->model, m->data, k, wrench);
        if (status) return status;
        const double *R = pose + MBSR_POSE_R;
        for (int l = 0; l < 3; ++l)
            arm[l] = R[l] * point[0] + R[3 + l] * point[1] + R[6 + l] * point[2];
        keep_wrench(wrench, arm, to);
    }
    return MBSR_OK;
}

/* Moments about where the closure acts. */
static int keep_loops(const program_model *m, const motion *shown, float *to)
{
    int status = MBSR_OK;
    for (int k = 0; k < shown->loops && !status; ++k, to += LOOP_NUMBERS) {
        const shown_loop *loop = shown->loop + k;
        double pose[MBSR_POSE_SIZE], wrench[6], point[3], arm[3];
        status = mbsr_closure_point(m->model, m->data, loop->closure, point);
        if (!status) status = mbsr_body_pose(m->model, m->data, loop->body, pose);
        if (!status)
            status =
                mbsr_closure_reaction(m->model, m->data, loop->closure, loop->place, wrench, NULL);
        for (int l = 0; l < 3 && !status; ++l) {
            to[l] = (float)point[l];
            arm[l] = point[l] - pose[MBSR_POSE_X + l];
        }
        if (!status) keep_wrench(wrench, arm, to + 3);
    }
    return status;
}

/* Accelerations in directions that move no mass are no matter for reactions. */
static int react(const program_model *m, double t, const places *at)
{
    const double *q = at->state, *u = q + at->nq;
    double *udot = at->state + at->nq + at->nu;
    const int status = mbsr_forward_dynamics(m->model, m->data, t, q, u, NULL, udot);
    if (status != MBSR_OK && status != MBSR_UNDETERMINED) return status;
    return mbsr_stage_accelerations(m->model, m->data, udot);
}

/* Points of contact, with more places for them in all samples where these are too few. A code. */
static int keep_touches(touching *contacts, mbsr_data *data, int k, motion *to)
{
    const int code = touching_look(contacts, data);
    if (code) return code;
    if (contacts->count > to->touches) {
        const size_t old = TOUCH_NUMBERS * (size_t)to->touches,
                     new = TOUCH_NUMBERS * 2 * (size_t)contacts->count;
        float *larger = calloc((size_t)to->samples * new, sizeof *larger);
        if (!larger) return complain(FAILED, "no memory");
        for (size_t l = 0; l < (size_t)k && old > 0; ++l)
            memcpy(larger + l * new, to->touch + l * old, old * sizeof *larger);
        free(to->touch);
        to->touch = larger;
        to->touches = 2 * contacts->count;
    }
    if (contacts->count == 0) return DONE;
    float *here = to->touch + TOUCH_NUMBERS * (size_t)k * (size_t)to->touches;
    for (int l = 0; l < contacts->count; ++l, here += TOUCH_NUMBERS)
        touching_arrow(contacts, l, here, here + 3);
    return DONE;
}

/* Reactions at the state, where there are any and they can be had. */
static void sample_reactions(const program_model *m, int k, const places *at, motion *to)
{
    const size_t bodies = (size_t)m->file->bodies, loops = (size_t)to->loops;
    if (!to->reaction) return;
    int status = react(m, to->time[k], at);
    if (!status) status = keep_loops(m, to, to->loop_force + (size_t)k * loops * LOOP_NUMBERS);
    if (!status)
        status = keep_reactions(m, to->point, to->reaction + (size_t)k * bodies * REACTION_NUMBERS);
    if (status) forget_reactions(to, mbsr_data_error(m->data)->text);
}

static int sample_motion(const program_model *m, touching *contacts, int k, const places *at,
                         motion *to)
{
    const size_t bodies = (size_t)m->file->bodies;
    sample_reactions(m, k, at, to);
    int status = MBSR_OK;
    if (!to->reaction) status = mbsr_stage_positions(m->model, m->data, to->time[k], at->state);
    if (!status) status = keep_poses(m, to->pose + (size_t)k * bodies * POSE_NUMBERS);
    if (status) return complain(FAILED, "t = %g: %s", to->time[k], mbsr_data_error(m->data)->text);
    if (to->reaction && contacts->model && keep_touches(contacts, m->data, k, to)) return FAILED;
    for (int l = 0; l < at->nq; ++l)
        to->q[(size_t)k * (size_t)at->nq + (size_t)l] = (float)at->state[l];
    return DONE;
}

/* ---- all of them ---- */

static int follow_run(const program_model *m, touching *contacts, const table *run, inputs *in,
                      const places *at, motion *to)
{
    int code = DONE;
    progress shown = progress_begin("poses", run->lines, false);
    for (int k = 0; k < run->lines && !code; ++k) {
        progress_show(&shown, k);
        for (int l = 0; l < at->nq + at->nu; ++l)
            if (at->q[l] >= 0) at->state[l] = table_at(run, k, at->q[l]);
        to->time[k] = table_at(run, k, 0);
        inputs_set(in, to->time[k], m->file->control);
        code = sample_motion(m, contacts, k, at, to);
    }
    progress_end(&shown);
    return code;
}

/* The consistent state near the one given; reactions only there. */
static int stand(const program_model *m, touching *contacts, const double *q, const double *u,
                 const places *at, motion *to)
{
    const mbsr_dae_form form = MBSR_DAE_MOMENTUM;
    const int size = mbsr_dae_size(m->model, form);
    double *y = calloc(2 * (size_t)size + 1, sizeof *y), *rates = at->state + at->nq;
    if (!y) return complain(FAILED, "no memory");
    memcpy(at->state, q, (size_t)at->nq * sizeof *q);
    if (u) memcpy(rates, u, (size_t)at->nu * sizeof *u);
    int status = mbsr_dae_pack(m->model, m->data, form, 0.0, at->state, rates, y);
    if (!status)
        status = mbsr_dae_consistent(m->model, m->data, form, 0.0, y, y + size, NULL, NULL);
    if (!status) status = mbsr_dae_unpack(m->model, m->data, form, 0.0, y, at->state, rates);
    free(y);
    if (status) forget_reactions(to, "there is no consistent start");
    return sample_motion(m, contacts, 0, at, to);
}

int motion_make(const program_model *m, touching *contacts, const char *path, const table *run,
                inputs *in, const double *q, const double *u, motion *to)
{
    places at = {.q = NULL};
    int code = DONE;
    *to = (motion){.samples = 0};
    if (run && run->lines == 0) return complain(NOT_READ, "%s has no lines of numbers", path);
    if (!allocate_motion(m, run ? run->lines : 1, &at, to)) code = complain(FAILED, "no memory");
    if (!code) find_points(m, to);
    if (!code && !find_loops(m, to)) code = complain(FAILED, "no memory");
    if (!code && run) {
        code = find_columns(m, path, run, &at);
        if (!at.rates)
            forget_reactions(to, "the run has no rates of the joints: mbsrank run --output state");
        if (!code) code = follow_run(m, contacts, run, in, &at, to);
    } else if (!code) {
        code = stand(m, contacts, q, u, &at, to);
    }
    free(at.q);
    free(at.state);
    return code;
}

void motion_free(motion *to)
{
    free(to->time);
    free(to->q);
    free(to->pose);
    free(to->reaction);
    free(to->loop_force);
    free(to->touch);
    free(to->loop);
    free(to->point);
}

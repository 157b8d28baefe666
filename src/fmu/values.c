/* Values of variables: see values.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/values.h"

#include "fmu/exchange.h"
#include "fmu/indicators.h"
#include "fmu/solve.h"

#include <mbsrank/dynamics.h>

#include <math.h>

/* ---- asking ---- */

/* Component of a site's pose. */
static int value_of_site(mbsri_instance *in, const mbsri_variable *v, double *value)
{
    const mbsri_plan_site *site = in->plan.site + v->of;
    const mbsr_space space = in->plan.body[site->body].def.joint.space;
    double pose[MBSR_POSE_SIZE + MBSR_MAX_D], x[3], e[4];
    if (v->component < 3) {
        const int status = mbsr_body_point(in->built.model, in->solver.data, site->body,
                                           site->frame.x, x, NULL, NULL);
        if (!status) *value = x[v->component];
        return status;
    }
    int status = mbsr_body_pose(in->built.model, in->solver.data, site->body, pose);
    if (status) return status;
    mbsr_frame turned = mbsr_frame_identity();
    if (space == MBSR_SPACE_PLANAR) {
        const double zero[3] = {0.0}, axis[3] = {0.0, 0.0, 1.0};
        turned = mbsr_frame_rotated(zero, axis, pose[2]);
    } else {
        for (int k = 0; k < 9; ++k) turned.R[k] = pose[MBSR_POSE_R + k];
    }
    turned = mbsr_frame_product(&turned, &site->frame);
    status = mbsr_rotation_quaternion(turned.R, e);
    if (!status) *value = e[v->component - 3];
    return status;
}

/* What an element exerts on one of its bodies. */
static int value_of_force(mbsri_instance *in, const mbsri_variable *v, double *value)
{
    double f[MBSR_MAX_D], tau[MBSR_MAX_D];
    const int status = mbsr_force_load(in->built.model, in->solver.data, v->of, v->place, f, tau);
    if (!status) *value = v->kind == MBSRI_FORCE ? f[v->component] : tau[v->component];
    return status;
}

static int value_of_energy(mbsri_instance *in, bool kinetic, double *value)
{
    return mbsr_energy(in->built.model, in->solver.data, kinetic ? value : NULL,
                       kinetic ? NULL : value);
}

static int value_of_reaction(mbsri_instance *in, const mbsri_variable *v, double *value)
{
    double f[MBSR_MAX_D];
    const int status = mbsr_joint_reaction(in->built.model, in->solver.data, v->of, f);
    if (!status) *value = f[v->component];
    return status;
}

static int value_of_indicator(mbsri_instance *in, const mbsri_variable *v, double *value)
{
    const int at = (int)(v - in->variables.list) - in->variables.indicators_at;
    const int status = mbsri_indicate(in, in->solver.event_data, in->t, in->q, in->u, in->work);
    if (!status) *value = in->work[at];
    return status;
}

/* A value of the evaluated state. */
static int value_here(mbsri_instance *in, const mbsri_variable *v, double *value)
{
    switch (v->kind) {
    case MBSRI_Q: *value = in->q[v->of]; return MBSR_OK;
    case MBSRI_U: *value = in->u[v->of]; return MBSR_OK;
    case MBSRI_UDOT: *value = in->udot[v->of]; return MBSR_OK;
    case MBSRI_LOOP: *value = in->lambda[v->of]; return MBSR_OK;
    case MBSRI_SITE: return value_of_site(in, v, value);
    case MBSRI_FORCE:
    case MBSRI_EFFORT: return value_of_force(in, v, value);
    case MBSRI_REACTION: return value_of_reaction(in, v, value);
    case MBSRI_KINETIC:
    case MBSRI_POTENTIAL: return value_of_energy(in, v->kind == MBSRI_KINETIC, value);
    case MBSRI_INDICATOR: return value_of_indicator(in, v, value);
    default: return mbsri_state_value(in, v, value);
    }
}

/* What is known without any evaluation; true: it is such a one. */
static bool value_given(const mbsri_instance *in, const mbsri_variable *v, double *value)
{
    const bool start = in->mode == MBSRI_INSTANTIATED;
    switch (v->kind) {
    case MBSRI_TIME: *value = in->t; return true;
    case MBSRI_PARAMETER: *value = in->parameters.value[v->of]; return true;
    case MBSRI_INPUT: *value = in->input[v->of]; return true;
    case MBSRI_Q: *value = in->start.q[v->of]; return start;
    case MBSRI_U: *value = in->start.u[v->of]; return start;
    default: return false;
    }
}

static const mbsri_variable *find_variable(mbsri_instance *in, const char *function,
                                           unsigned reference)
{
    if (reference < (unsigned)in->variables.count) return in->variables.list + reference;
    mbsri_say(in, MBSRI_ERROR, "%s: there is no variable with the value reference %u of a real",
              function, reference);
    return NULL;
}

mbsri_result mbsri_get(mbsri_instance *in, const char *function, const unsigned *reference,
                       size_t count, double *value)
{
    if (count > 0 && (!reference || !value))
        return mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", function);
    for (size_t k = 0; k < count; ++k) {
        const mbsri_variable *v = find_variable(in, function, reference[k]);
        if (!v) return MBSRI_ERROR;
        if (value_given(in, v, value + k)) continue;
        if (in->mode == MBSRI_INSTANTIATED)
            return mbsri_say(in, MBSRI_ERROR, "%s: %s has no value before initialization mode",
                             function, v->name);
        const mbsri_result result = mbsri_evaluate(in);
        if (result) return result;
        const int status = value_here(in, v, value + k);
        if (status) return mbsri_failed(in, v->name, status, mbsr_data_error(in->solver.data));
    }
    return MBSRI_OK;
}

/* ---- setting ---- */

static bool may_set(const mbsri_instance *in, const mbsri_variable *v)
{
    const unsigned before = MBSRI_INSTANTIATED | MBSRI_INITIALIZATION;
    switch (v->kind) {
    case MBSRI_INPUT: return true;
    case MBSRI_PARAMETER:
    case MBSRI_Q:
    case MBSRI_U: return ((unsigned)in->mode & before) != 0;
    default: return false;
    }
}

/* The motion of which an input is goes on from here. */
static void begin_motion(mbsri_instance *in, int input)
{
    for (int k = 0; k < in->plan.motions; ++k) {
        const mbsri_plan_motion *m = in->plan.motion + k;
        if (input < m->input || input >= m->input + 3 * m->count || in->t_motion[k] == in->t)
            continue;
        in->t_motion[k] = in->t;
        in->inputs_changed = true;
    }
}

static void set_one(mbsri_instance *in, const mbsri_variable *v, double value)
{
    switch (v->kind) {
    case MBSRI_INPUT:
        begin_motion(in, v->of);
        if (in->input[v->of] < value || in->input[v->of] > value) in->inputs_changed = true;
        in->input[v->of] = value;
        break;
    case MBSRI_PARAMETER:
        in->parameters.value[v->of] = value;
        in->parameters.stale = true;
        break;
    case MBSRI_Q: in->start.q[v->of] = value; break;
    default: in->start.u[v->of] = value; break;
    }
    in->evaluated = false;
    if (in->mode == MBSRI_INITIALIZATION) in->started = false;
}

mbsri_result mbsri_set(mbsri_instance *in, const char *function, const unsigned *reference,
                       size_t count, const double *value)
{
    if (count > 0 && (!reference || !value))
        return mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", function);
    for (size_t k = 0; k < count; ++k) {
        const mbsri_variable *v = find_variable(in, function, reference[k]);
        if (!v) return MBSRI_ERROR;
        if (!may_set(in, v))
            return mbsri_say(in, MBSRI_ERROR, "%s: %s cannot be set now", function, v->name);
        if (!isfinite(value[k]))
            return mbsri_say(in, MBSRI_ERROR, "%s: %g for %s is not finite", function, value[k],
                             v->name);
    }
    for (size_t k = 0; k < count; ++k) set_one(in, in->variables.list + reference[k], value[k]);
    return MBSRI_OK;
}

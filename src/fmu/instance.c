/* Instances: making, logging, resetting. See instance.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/instance.h"

#include "fmu/error.h"
#include "fmu/solve.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- messages ---- */

/* In the messages of the standard # begins a value reference, and ## is #. */
static void send(mbsri_instance *in, mbsri_result result, const char *format, va_list arguments)
{
    static const char *const categories[] = {"logEvents", "logStatusWarning", "logStatusDiscard",
                                             "logStatusError", "logStatusError"};
    char text[768], escaped[2 * sizeof text];
    const unsigned bit = 1u << (result > MBSRI_ERROR ? MBSRI_ERROR : result);
    if (!in->logger || (!(in->log & bit) && result < MBSRI_ERROR)) return;
    mbsri_vprint(text, sizeof text, format, arguments);
    char *to = escaped;
    for (const char *from = text; *from; ++from) {
        if (*from == '#') *to++ = '#';
        *to++ = *from;
    }
    *to = '\0';
    in->logger(in, result, categories[result], escaped);
}

void mbsri_tell(mbsri_instance *in, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    send(in, MBSRI_OK, format, arguments);
    va_end(arguments);
}

mbsri_result mbsri_say(mbsri_instance *in, mbsri_result result, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    send(in, result, format, arguments);
    va_end(arguments);
    if (result >= MBSRI_ERROR) in->mode = MBSRI_TERMINATED;
    return result;
}

bool mbsri_allowed(mbsri_instance *in, unsigned modes, const char *function)
{
    static const char *const names[] = {"instantiated",
                                        "in initialization mode",
                                        "in event mode",
                                        "in continuous-time mode",
                                        "in step mode",
                                        "terminated",
                                        "in intermediate update mode"};
    int k = 0;
    if ((unsigned)in->mode & modes) return true;
    while (k < 6 && (unsigned)in->mode != 1u << k) ++k;
    mbsri_say(in, MBSRI_ERROR, "%s: must not be called while the instance is %s", function,
              names[k]);
    return false;
}

bool mbsri_set_log(mbsri_instance *in, bool on, size_t count, const char *const *category)
{
    static const char *const names[] = {"logEvents", "logStatusWarning", "logStatusDiscard",
                                        "logStatusError", "logAll"};
    unsigned chosen = count > 0 ? 0u : MBSRI_LOG_ALL;
    for (size_t k = 0; k < count; ++k) {
        unsigned l = 0;
        while (l < 5 && (!category || !category[k] || strcmp(category[k], names[l]) != 0)) ++l;
        if (l == 5) {
            mbsri_say(in, MBSRI_ERROR, "there is no category '%.60s' of messages",
                      category && category[k] ? category[k] : "");
            return false;
        }
        chosen |= l == 4 ? MBSRI_LOG_ALL : 1u << l;
    }
    if (count == 0)
        in->log = on ? MBSRI_LOG_ALL : 0u;
    else
        in->log = on ? in->log | chosen : in->log & ~chosen;
    return true;
}

/* ---- resources ---- */

/* No model is larger. */
enum { MOST_BYTES = 1 << 30 };

static unsigned char *read_all(FILE *from, size_t *size)
{
    size_t room = 1 << 16;
    unsigned char *data = malloc(room);
    *size = 0;
    while (data) {
        *size += fread(data + *size, 1, room - *size, from);
        if (*size < room) break;
        unsigned char *larger = room < MOST_BYTES ? realloc(data, 2 * room) : NULL;
        if (!larger) free(data);
        data = larger;
        room *= 2;
    }
    return data;
}

static bool read_resource(mbsri_instance *in, const char *folder)
{
    static const char name[] = "model.mbsrank";
    const size_t length = strlen(folder);
    const bool ends = length > 0 && (folder[length - 1] == '/' || folder[length - 1] == '\\');
    char *path = malloc(length + sizeof name + 1);
    if (!path) {
        mbsri_say(in, MBSRI_ERROR, "no memory for the path of the model");
        return false;
    }
    mbsri_fmu_print(path, length + sizeof name + 1, "%s%s%s", folder, ends ? "" : "/", name);
    FILE *from = fopen(path, "rb");
    if (from) {
        in->resource = read_all(from, &in->resource_size);
        fclose(from);
    }
    if (!in->resource) mbsri_say(in, MBSRI_ERROR, "%s: the model cannot be read", path);
    free(path);
    return in->resource != NULL;
}

/* ---- the plan ---- */

static bool take_arrays(mbsri_instance *in)
{
    const size_t nq = (size_t)in->plan.nq, nu = (size_t)in->plan.nu;
    in->input = calloc((size_t)(in->plan.inputs + in->plan.motions) + 1, sizeof *in->input);
    in->q0 = calloc(nq + nu + 1, sizeof *in->q0);
    if (!in->input || !in->q0) return false;
    in->t_motion = in->input + in->plan.inputs;
    in->u0 = in->q0 + nq;
    for (int k = 0; k < in->plan.inputs; ++k) in->input[k] = in->plan.input[k].start;
    for (size_t k = 0; k < nq; ++k) in->q0[k] = in->plan.q[k].start;
    for (size_t k = 0; k < nu; ++k) in->u0[k] = in->plan.u[k].start;
    return true;
}

static bool open_plan(mbsri_instance *in)
{
    const mbsr_allocator standard = {NULL, NULL, NULL};
    mbsr_error error;
    mbsri_plan_open(&in->plan, &standard);
    if (mbsri_plan_read(&in->plan, in->resource, in->resource_size, &error)) {
        mbsri_say(in, MBSRI_ERROR, "the model in the resources cannot be read: %s", error.text);
        return false;
    }
    if (!take_arrays(in)) {
        mbsri_say(in, MBSRI_ERROR, "no memory for the model");
        return false;
    }
    if (in->exchange && !in->plan.model_exchange) {
        mbsri_say(in, MBSRI_ERROR, "the FMU does not offer model exchange");
        return false;
    }
    in->mode = MBSRI_INSTANTIATED;
    if (mbsri_make_model(in)) return false;
    if (mbsri_list_variables(&in->plan, in->built.model, &in->variables)) return true;
    mbsri_say(in, MBSRI_ERROR, "no memory for the variables");
    return false;
}

static void close_plan(mbsri_instance *in)
{
    mbsri_drop_model(in);
    free(in->input);
    free(in->q0);
    in->input = in->q0 = in->u0 = NULL;
    mbsri_plan_close(&in->plan);
}

/* ---- instances ---- */

mbsri_instance *mbsri_instance_create(const mbsri_instance *as, const char *folder,
                                      const char *token)
{
    mbsri_instance *in = malloc(sizeof *in);
    mbsri_instance first = *as;
    char own[MBSRI_TOKEN];
    if (in) *in = *as, in->name = malloc(strlen(as->name) + 1);
    if (!in || !in->name) {
        mbsri_say(&first, MBSRI_ERROR, "no memory for an instance");
        free(in);
        return NULL;
    }
    memcpy(in->name, as->name, strlen(as->name) + 1);
    bool good = read_resource(in, folder);
    if (good) {
        mbsri_plan_token(in->resource, in->resource_size, own);
        good = strcmp(own, token) == 0;
        if (!good)
            mbsri_say(in, MBSRI_ERROR,
                      "the model in the resources is another one: '%.40s' is not "
                      "its token",
                      token);
    }
    if (good && open_plan(in)) return in;
    mbsri_instance_destroy(in);
    return NULL;
}

void mbsri_instance_destroy(mbsri_instance *in)
{
    if (!in) return;
    close_plan(in);
    free(in->resource);
    free(in->name);
    free(in);
}

bool mbsri_has_events(const mbsri_instance *in)
{
    return in->variables.indicators > 0 && !(in->plan.fixed_step > 0.0);
}

mbsri_result mbsri_instance_reset(mbsri_instance *in)
{
    close_plan(in);
    in->t = in->t_start = in->tolerance = 0.0;
    in->inputs_changed = in->started = in->evaluated = in->fresh = in->stale = false;
    return open_plan(in) ? MBSRI_OK : MBSRI_FATAL;
}

/* The functions of FMI 2.0: each checks that it may be called now, and calls what both versions
 * share.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/fmi2_functions.h"

#include "fmu/cycle.h"
#include "fmu/exchange.h"
#include "fmu/open.h"
#include "fmu/saved.h"
#include "fmu/values.h"

#include <stdlib.h>
#include <string.h>

#define FMI_ERROR fmi2Error
#include "fmu/enter.h"

/* ---- instances ---- */

const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

static void send_fmi2(mbsri_instance *in, mbsri_result result, const char *category,
                      const char *text)
{
    const fmi2CallbackLogger logger = (fmi2CallbackLogger)in->importer.callback;
    logger(in->importer.environment, in->name, (fmi2Status)result, category, "%s", text);
}

static int digit(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* The path of a URI file:///path, file:/path or file://localhost/path, or what is no URI as it is;
 * to be freed. NULL: no memory. */
static char *path_of(const char *uri)
{
    const char *from = uri;
    if (strncmp(from, "file:", 5) == 0) {
        from += 5;
        if (strncmp(from, "//", 2) == 0) {
            from += 2;
            if (strncmp(from, "localhost/", 10) == 0) from += 9;
        }
    }
    char *path = malloc(strlen(from) + 1), *to = path;
    const bool escapes = from != uri;
    while (path && *from) {
        const int high = escapes && *from == '%' ? digit(from[1]) : -1,
                  low = high >= 0 ? digit(from[2]) : -1;
        *to++ = low >= 0 ? (char)(16 * high + low) : *from;
        from += low >= 0 ? 3 : 1;
    }
    if (path) *to = '\0';
    return path;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    mbsri_instance as = {.name = (char *)(name ? name : ""),
                         .exchange = type == fmi2ModelExchange,
                         .importer.log = logging ? MBSRI_LOG_ALL : 0u,
                         .mode = MBSRI_INSTANTIATED};
    (void)visible;
    if (functions && functions->logger) {
        as.importer.logger = send_fmi2;
        as.importer.callback = (void (*)(void))functions->logger;
        as.importer.environment = functions->componentEnvironment;
    }
    if (!name || !*name || !guid || !resources ||
        (type != fmi2ModelExchange && type != fmi2CoSimulation)) {
        mbsri_say(&as, MBSRI_ERROR, "%s: %s", __func__,
                  !name || !*name ? "the name of the instance is empty"
                  : !guid         ? "the GUID is NULL"
                  : !resources    ? "the resources are NULL"
                                  : "the type is neither model exchange nor co-simulation");
        return NULL;
    }
    char *path = path_of(resources);
    if (!path) mbsri_say(&as, MBSRI_ERROR, "%s: no memory", __func__);
    mbsri_instance *in = path ? mbsri_instance_create(&as, path, guid) : NULL;
    free(path);
    return in;
}

void fmi2FreeInstance(fmi2Component c)
{
    mbsri_instance_destroy(c);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
                               const fmi2String category[])
{
    ENTER(ALWAYS);
    return mbsri_set_log(in, on != fmi2False, count, category) ? fmi2OK : fmi2Error;
}

/* ---- from mode to mode ---- */

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stopDefined, fmi2Real stop)
{
    ENTER(MBSRI_INSTANTIATED);
    (void)stopDefined;
    (void)stop;
    return (fmi2Status)mbsri_set_up(in, __func__, toleranceDefined ? tolerance : 0.0, start);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    ENTER(MBSRI_INSTANTIATED);
    return (fmi2Status)mbsri_initialize(in);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    ENTER(MBSRI_INITIALIZATION);
    return (fmi2Status)mbsri_initialized(in, __func__,
                                         in->exchange ? MBSRI_EVENT_MODE : MBSRI_STEP);
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ENTER(MBSRI_INITIALIZED);
    in->mode = MBSRI_TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    ENTER(ALWAYS);
    return (fmi2Status)mbsri_instance_reset(in);
}

/* ---- values ---- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    ENTER(ALWAYS);
    return (fmi2Status)mbsri_get(in, __func__, vr, n, value);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       const fmi2Real value[])
{
    ENTER(RUNNING);
    return (fmi2Status)mbsri_set(in, __func__, vr, n, value);
}

/* All variables are real: others can be asked for, and set, none at a time. */
static fmi2Status none(mbsri_instance *in, size_t count, const char *function)
{
    if (count == 0) return fmi2OK;
    return (fmi2Status)mbsri_say(in, MBSRI_ERROR, "%s: there are no variables of this type",
                                 function);
}

#define OTHERS(function, modes, type)                                                              \
    fmi2Status function(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[])    \
    {                                                                                              \
        ENTER(modes);                                                                              \
        (void)vr;                                                                                  \
        (void)value;                                                                               \
        return none(in, n, __func__);                                                              \
    }

OTHERS(fmi2GetInteger, ALWAYS, fmi2Integer)
OTHERS(fmi2GetBoolean, ALWAYS, fmi2Boolean)
OTHERS(fmi2GetString, ALWAYS, fmi2String)
OTHERS(fmi2SetInteger, RUNNING, const fmi2Integer)
OTHERS(fmi2SetBoolean, RUNNING, const fmi2Boolean)
OTHERS(fmi2SetString, RUNNING, const fmi2String)

/* ---- states ---- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    ENTER(ALWAYS);
    return (fmi2Status)mbsri_save(in, __func__, (mbsri_saved **)state);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    ENTER(ALWAYS);
    return (fmi2Status)mbsri_restore(in, __func__, state);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    ENTER(ALWAYS);
    if (!state) return fmi2OK;
    mbsri_saved_destroy(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    ENTER(ALWAYS);
    if (!state || !size)
        return (fmi2Status)mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", __func__);
    *size = mbsri_saved_size(state);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    ENTER(ALWAYS);
    return (fmi2Status)mbsri_serialize(in, __func__, state, (unsigned char *)bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    ENTER(ALWAYS);
    return (fmi2Status)mbsri_deserialize(in, __func__, (const unsigned char *)bytes, size,
                                         (mbsri_saved **)state);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                        size_t unknowns, const fmi2ValueReference known[],
                                        size_t knowns, const fmi2Real seed[],
                                        fmi2Real sensitivity[])
{
    ENTER(MBSRI_INITIALIZATION | MBSRI_INITIALIZED);
    return (fmi2Status)mbsri_differentiate(in, __func__, false, unknown, unknowns, known, knowns,
                                           seed, sensitivity);
}

/* ---- model exchange ---- */

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    ENTER_OF(true, MBSRI_CONTINUOUS);
    in->mode = MBSRI_EVENT_MODE;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    ENTER_OF(true, MBSRI_EVENT_MODE);
    if (!info) return (fmi2Status)mbsri_say(in, MBSRI_ERROR, "%s: info is NULL", __func__);
    *info = (fmi2EventInfo){.newDiscreteStatesNeeded = fmi2False};
    info->nextEventTimeDefined = mbsri_next_event(in, &info->nextEventTime);
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    ENTER_OF(true, MBSRI_EVENT_MODE);
    in->mode = MBSRI_CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetBefore,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminate)
{
    ENTER_OF(true, MBSRI_CONTINUOUS);
    (void)noSetBefore;
    if (!enterEventMode || !terminate)
        return (fmi2Status)mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", __func__);
    *enterEventMode = *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t)
{
    ENTER_OF(true, EVENTS);
    return (fmi2Status)mbsri_set_time(in, __func__, t);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    ENTER_OF(true, MBSRI_CONTINUOUS);
    return (fmi2Status)mbsri_set_states(in, __func__, x, n);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real xdot[], size_t n)
{
    ENTER_OF(true, ASKED);
    return (fmi2Status)mbsri_get_derivatives(in, __func__, xdot, n);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real value[], size_t n)
{
    ENTER_OF(true, ASKED);
    return (fmi2Status)mbsri_get_indicators(in, __func__, value, n);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    ENTER_OF(true, ASKED);
    return (fmi2Status)mbsri_get_states(in, __func__, x, n);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    ENTER_OF(true, ALWAYS);
    return (fmi2Status)mbsri_get_nominals(in, __func__, x, n);
}

/* ---- co-simulation ---- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    ENTER_OF(false, RUNNING);
    (void)vr, (void)n, (void)order, (void)value;
    return (fmi2Status)mbsri_say(in, MBSRI_ERROR, "%s: inputs are not interpolated", __func__);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[])
{
    ENTER_OF(false, MBSRI_STEP | MBSRI_TERMINATED);
    (void)vr, (void)n, (void)order, (void)value;
    return (fmi2Status)mbsri_say(in, MBSRI_ERROR, "%s: outputs have no derivatives", __func__);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean noSetBefore)
{
    ENTER_OF(false, MBSRI_STEP);
    bool event;
    (void)noSetBefore;
    return (fmi2Status)mbsri_communicate(in, __func__, t, h, &event);
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    ENTER_OF(false, MBSRI_STEP);
    return (fmi2Status)mbsri_say(in, MBSRI_ERROR, "%s: no step is pending", __func__);
}

/* What a step that was discarded has reached; no step is ever pending. */
static fmi2Status no_status(mbsri_instance *in, const char *function)
{
    return (fmi2Status)mbsri_say(in, MBSRI_DISCARD, "%s: there is no such status", function);
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    ENTER_OF(false, MBSRI_STEP | MBSRI_TERMINATED);
    if (kind != fmi2DoStepStatus || !value) return no_status(in, __func__);
    *value = in->mode == MBSRI_STEP ? fmi2OK : fmi2Error;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    ENTER_OF(false, MBSRI_STEP | MBSRI_TERMINATED);
    if (kind != fmi2LastSuccessfulTime || !value) return no_status(in, __func__);
    *value = in->t;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    ENTER_OF(false, MBSRI_STEP | MBSRI_TERMINATED);
    (void)kind, (void)value;
    return no_status(in, __func__);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    ENTER_OF(false, MBSRI_STEP | MBSRI_TERMINATED);
    if (kind != fmi2Terminated || !value) return no_status(in, __func__);
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    ENTER_OF(false, MBSRI_STEP | MBSRI_TERMINATED);
    (void)kind, (void)value;
    return no_status(in, __func__);
}

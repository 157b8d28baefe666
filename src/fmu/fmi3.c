/* The functions of FMI 3.0: each checks that it may be called now, and calls what both versions
 * share.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/fmi3_functions.h"

#include "fmu/cycle.h"
#include "fmu/exchange.h"
#include "fmu/fmi3_enter.h"
#include "fmu/open.h"
#include "fmu/saved.h"
#include "fmu/values.h"

/* ---- instances ---- */

const char *fmi3GetVersion(void)
{
    return "3.0";
}

/* What an importer hands over: two functions. */
typedef struct callbacks {
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback update;
} callbacks;

static void send_fmi3(mbsri_instance *in, mbsri_result result, const char *category,
                      const char *text)
{
    const fmi3LogMessageCallback log = (fmi3LogMessageCallback)in->importer.callback;
    log(in->importer.environment, (fmi3Status)result, category, text);
}

static void update(mbsri_instance *in, double t, bool *early, double *time)
{
    const fmi3IntermediateUpdateCallback call =
        (fmi3IntermediateUpdateCallback)in->importer.updater;
    const mbsri_unit_mode mode = in->mode;
    in->mode = MBSRI_INTERMEDIATE;
    call(in->importer.environment, t, true, true, true, in->importer.early_return, early, time);
    *early = *early && in->importer.early_return;
    if (in->mode == MBSRI_INTERMEDIATE) in->mode = mode;
}

static fmi3Instance instantiate(mbsri_instance as, fmi3String name, fmi3String token,
                                fmi3String resources, callbacks given, const char *function)
{
    as.name = (char *)(name ? name : "");
    as.mode = MBSRI_INSTANTIATED;
    if (given.log) {
        as.importer.logger = send_fmi3;
        as.importer.callback = (void (*)(void))given.log;
    }
    if (given.update) {
        as.importer.intermediate = update;
        as.importer.updater = (void (*)(void))given.update;
    }
    if (name && *name && token && resources) return mbsri_instance_create(&as, resources, token);
    mbsri_say(&as, MBSRI_ERROR, "%s: %s", function,
              !name || !*name ? "the name of the instance is empty"
              : !token        ? "the instantiation token is NULL"
                              : "the path of the resources is NULL");
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logMessage)
{
    (void)visible;
    const mbsri_instance as = {.exchange = true,
                               .importer.log = logging ? MBSRI_LOG_ALL : 0u,
                               .importer.environment = environment};
    return instantiate(as, name, token, resources, (callbacks){logMessage, NULL}, __func__);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference required[], size_t requiredCount,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)visible;
    (void)required;
    (void)requiredCount;
    const mbsri_instance as = {.importer.log = logging ? MBSRI_LOG_ALL : 0u,
                               .importer.event_mode = eventModeUsed,
                               .importer.early_return = earlyReturnAllowed,
                               .importer.environment = environment};
    mbsri_instance *in = instantiate(as, name, token, resources,
                                     (callbacks){logMessage, intermediateUpdate}, __func__);
    if (!in || !eventModeUsed || mbsri_has_events(in)) return in;
    mbsri_say(in, MBSRI_ERROR, "%s: the FMU has no event mode", __func__);
    mbsri_instance_destroy(in);
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback logMessage,
    fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    (void)clockUpdate, (void)lock, (void)unlock;
    if (logMessage)
        logMessage(environment, fmi3Error, "logStatusError",
                   "fmi3InstantiateScheduledExecution: the FMU offers no scheduled execution");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c)
{
    mbsri_instance_destroy(c);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count,
                               const fmi3String category[])
{
    ENTER(ALWAYS);
    return mbsri_set_log(in, on, count, category) ? fmi3OK : fmi3Error;
}

/* ---- from mode to mode ---- */

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stopDefined, fmi3Float64 stop)
{
    ENTER(MBSRI_INSTANTIATED);
    (void)stopDefined;
    (void)stop;
    const mbsri_result result =
        mbsri_set_up(in, __func__, toleranceDefined ? tolerance : 0.0, start);
    return (fmi3Status)(result ? result : mbsri_initialize(in));
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    ENTER(MBSRI_INITIALIZATION);
    const bool events = in->exchange || in->importer.event_mode;
    return (fmi3Status)mbsri_initialized(in, __func__, events ? MBSRI_EVENT_MODE : MBSRI_STEP);
}

fmi3Status fmi3EnterEventMode(fmi3Instance c)
{
    ENTER(MBSRI_CONTINUOUS | MBSRI_STEP);
    if (!in->exchange && !in->importer.event_mode)
        return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: event mode is not used", __func__);
    in->mode = MBSRI_EVENT_MODE;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *needUpdate, fmi3Boolean *terminate,
                                    fmi3Boolean *nominalsChanged, fmi3Boolean *valuesChanged,
                                    fmi3Boolean *nextEventDefined, fmi3Float64 *nextEvent)
{
    ENTER(MBSRI_EVENT_MODE);
    if (!needUpdate || !terminate || !nominalsChanged || !valuesChanged || !nextEventDefined ||
        !nextEvent)
        return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", __func__);
    *needUpdate = *terminate = *nominalsChanged = *valuesChanged = false;
    *nextEventDefined = in->exchange && mbsri_next_event(in, nextEvent);
    return fmi3OK;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c)
{
    ENTER(MBSRI_INITIALIZATION | MBSRI_EVENT_MODE);
    return fmi3OK; /* there are none */
}

fmi3Status fmi3EnterStepMode(fmi3Instance c)
{
    ENTER_OF(false, MBSRI_EVENT_MODE);
    in->mode = MBSRI_STEP;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance c)
{
    ENTER(MBSRI_INITIALIZED);
    in->mode = MBSRI_TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    ENTER(ALWAYS);
    return (fmi3Status)mbsri_instance_reset(in);
}

/* ---- values ---- */

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                          fmi3Float64 value[], size_t values)
{
    ENTER(ALWAYS | MBSRI_INTERMEDIATE);
    if (n != values) return wrong_count(in, __func__);
    return (fmi3Status)mbsri_get(in, __func__, vr, n, value);
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                          const fmi3Float64 value[], size_t values)
{
    ENTER(RUNNING | MBSRI_INTERMEDIATE);
    if (n != values) return wrong_count(in, __func__);
    return (fmi3Status)mbsri_set(in, __func__, vr, n, value);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknown[],
                                        size_t unknowns, const fmi3ValueReference known[],
                                        size_t knowns, const fmi3Float64 seed[], size_t seeds,
                                        fmi3Float64 sensitivity[], size_t sensitivities)
{
    ENTER(MBSRI_INITIALIZATION | MBSRI_INITIALIZED);
    if (seeds != knowns || sensitivities != unknowns) return wrong_count(in, __func__);
    return (fmi3Status)mbsri_differentiate(in, __func__, false, unknown, unknowns, known, knowns,
                                           seed, sensitivity);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknown[],
                                    size_t unknowns, const fmi3ValueReference known[],
                                    size_t knowns, const fmi3Float64 seed[], size_t seeds,
                                    fmi3Float64 sensitivity[], size_t sensitivities)
{
    ENTER(MBSRI_INITIALIZATION | MBSRI_INITIALIZED);
    if (seeds != unknowns || sensitivities != knowns) return wrong_count(in, __func__);
    return (fmi3Status)mbsri_differentiate(in, __func__, true, unknown, unknowns, known, knowns,
                                           seed, sensitivity);
}

/* ---- states ---- */

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    ENTER(ALWAYS);
    return (fmi3Status)mbsri_save(in, __func__, (mbsri_saved **)state);
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    ENTER(ALWAYS);
    return (fmi3Status)mbsri_restore(in, __func__, state);
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    ENTER(ALWAYS);
    if (!state) return fmi3OK;
    mbsri_saved_destroy(*state);
    *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    ENTER(ALWAYS);
    if (!state || !size)
        return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", __func__);
    *size = mbsri_saved_size(state);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    ENTER(ALWAYS);
    return (fmi3Status)mbsri_serialize(in, __func__, state, bytes, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size,
                                   fmi3FMUState *state)
{
    ENTER(ALWAYS);
    return (fmi3Status)mbsri_deserialize(in, __func__, bytes, size, (mbsri_saved **)state);
}

/* ---- model exchange ---- */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c)
{
    ENTER_OF(true, MBSRI_EVENT_MODE);
    in->mode = MBSRI_CONTINUOUS;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean noSetBefore,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminate)
{
    ENTER_OF(true, MBSRI_CONTINUOUS);
    (void)noSetBefore;
    if (!enterEventMode || !terminate)
        return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", __func__);
    *enterEventMode = *terminate = false;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 t)
{
    ENTER_OF(true, EVENTS);
    return (fmi3Status)mbsri_set_time(in, __func__, t);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n)
{
    ENTER_OF(true, MBSRI_CONTINUOUS);
    return (fmi3Status)mbsri_set_states(in, __func__, x, n);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 value[], size_t n)
{
    ENTER_OF(true, ASKED);
    return (fmi3Status)mbsri_get_derivatives(in, __func__, value, n);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 value[], size_t n)
{
    ENTER_OF(true, ASKED);
    return (fmi3Status)mbsri_get_indicators(in, __func__, value, n);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 value[], size_t n)
{
    ENTER_OF(true, ASKED);
    return (fmi3Status)mbsri_get_states(in, __func__, value, n);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 value[], size_t n)
{
    ENTER_OF(true, ALWAYS);
    return (fmi3Status)mbsri_get_nominals(in, __func__, value, n);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *count)
{
    ENTER_OF(true, ALWAYS);
    if (!count) return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: count is NULL", __func__);
    *count = (size_t)in->variables.indicators;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *count)
{
    ENTER_OF(true, ALWAYS);
    if (!count) return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: count is NULL", __func__);
    *count = (size_t)(in->plan.nq + in->plan.nu);
    return fmi3OK;
}

/* ---- co-simulation ---- */

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean noSetBefore,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminate,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    ENTER_OF(false, MBSRI_STEP);
    bool event;
    (void)noSetBefore;
    if (!eventHandlingNeeded || !terminate || !earlyReturn || !lastSuccessfulTime)
        return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", __func__);
    const mbsri_result result = mbsri_communicate(in, __func__, t, h, &event);
    *eventHandlingNeeded = event;
    *terminate = false;
    *earlyReturn = !result && in->t < t + h;
    *lastSuccessfulTime = in->t;
    return (fmi3Status)result;
}

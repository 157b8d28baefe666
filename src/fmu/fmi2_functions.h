/* Types and functions of the Functional Mock-up Interface 2.0.4, as its text defines them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMI2_FUNCTIONS_H
#define MBSRI_FMI2_FUNCTIONS_H

#include <stddef.h>

#if defined(_WIN32)
#define MBSRI_FMI_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define MBSRI_FMI_EXPORT __attribute__((visibility("default")))
#else
#define MBSRI_FMI_EXPORT
#endif

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef char fmi2Byte;
typedef const char *fmi2String;

enum { fmi2False = 0, fmi2True = 1 };

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum {
    fmi2DoStepStatus,
    fmi2PendingStatus,
    fmi2LastSuccessfulTime,
    fmi2Terminated
} fmi2StatusKind;

typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String instance, fmi2Status,
                                   fmi2String category, fmi2String message, ...);

typedef struct {
    fmi2CallbackLogger logger;
    void *(*allocateMemory)(size_t count, size_t size);
    void (*freeMemory)(void *memory);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

typedef struct {
    fmi2Boolean newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged,
        valuesOfContinuousStatesChanged, nextEventTimeDefined;
    fmi2Real nextEventTime;
} fmi2EventInfo;

#define MBSRI_FMI2(type) MBSRI_FMI_EXPORT type

MBSRI_FMI2(const char *) fmi2GetTypesPlatform(void);
MBSRI_FMI2(const char *) fmi2GetVersion(void);
MBSRI_FMI2(fmi2Status)
fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String category[]);
MBSRI_FMI2(fmi2Component)
fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging);
MBSRI_FMI2(void) fmi2FreeInstance(fmi2Component c);
MBSRI_FMI2(fmi2Status)
fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                    fmi2Real start, fmi2Boolean stopDefined, fmi2Real stop);
MBSRI_FMI2(fmi2Status) fmi2EnterInitializationMode(fmi2Component c);
MBSRI_FMI2(fmi2Status) fmi2ExitInitializationMode(fmi2Component c);
MBSRI_FMI2(fmi2Status) fmi2Terminate(fmi2Component c);
MBSRI_FMI2(fmi2Status) fmi2Reset(fmi2Component c);

MBSRI_FMI2(fmi2Status)
fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]);
MBSRI_FMI2(fmi2Status)
fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]);
MBSRI_FMI2(fmi2Status)
fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]);
MBSRI_FMI2(fmi2Status)
fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]);
MBSRI_FMI2(fmi2Status)
fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]);
MBSRI_FMI2(fmi2Status)
fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]);
MBSRI_FMI2(fmi2Status)
fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]);
MBSRI_FMI2(fmi2Status)
fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]);

MBSRI_FMI2(fmi2Status) fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state);
MBSRI_FMI2(fmi2Status) fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state);
MBSRI_FMI2(fmi2Status) fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state);
MBSRI_FMI2(fmi2Status)
fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size);
MBSRI_FMI2(fmi2Status)
fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size);
MBSRI_FMI2(fmi2Status)
fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state);
MBSRI_FMI2(fmi2Status)
fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                             const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
                             fmi2Real sensitivity[]);

MBSRI_FMI2(fmi2Status) fmi2EnterEventMode(fmi2Component c);
MBSRI_FMI2(fmi2Status) fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info);
MBSRI_FMI2(fmi2Status) fmi2EnterContinuousTimeMode(fmi2Component c);
MBSRI_FMI2(fmi2Status)
fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetBefore, fmi2Boolean *enterEventMode,
                            fmi2Boolean *terminate);
MBSRI_FMI2(fmi2Status) fmi2SetTime(fmi2Component c, fmi2Real t);
MBSRI_FMI2(fmi2Status) fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n);
MBSRI_FMI2(fmi2Status) fmi2GetDerivatives(fmi2Component c, fmi2Real xdot[], size_t n);
MBSRI_FMI2(fmi2Status) fmi2GetEventIndicators(fmi2Component c, fmi2Real value[], size_t n);
MBSRI_FMI2(fmi2Status) fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n);
MBSRI_FMI2(fmi2Status) fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n);

MBSRI_FMI2(fmi2Status)
fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                            const fmi2Integer order[], const fmi2Real value[]);
MBSRI_FMI2(fmi2Status)
fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                             const fmi2Integer order[], fmi2Real value[]);
MBSRI_FMI2(fmi2Status)
fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean noSetBefore);
MBSRI_FMI2(fmi2Status) fmi2CancelStep(fmi2Component c);
MBSRI_FMI2(fmi2Status) fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value);
MBSRI_FMI2(fmi2Status)
fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value);
MBSRI_FMI2(fmi2Status)
fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value);
MBSRI_FMI2(fmi2Status)
fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value);
MBSRI_FMI2(fmi2Status)
fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value);

#endif

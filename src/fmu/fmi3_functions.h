/* Types and functions of the Functional Mock-up Interface 3.0, as its text defines them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMI3_FUNCTIONS_H
#define MBSRI_FMI3_FUNCTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define MBSRI_FMI3(type) __declspec(dllexport) type
#elif defined(__GNUC__)
#define MBSRI_FMI3(type) __attribute__((visibility("default"))) type
#else
#define MBSRI_FMI3(type) type
#endif

typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8, fmi3Byte;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean, fmi3Clock;
typedef char fmi3Char;
typedef const fmi3Char *fmi3String;
typedef const fmi3Byte *fmi3Binary;

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum {
    fmi3Independent,
    fmi3Constant,
    fmi3Fixed,
    fmi3Tunable,
    fmi3Discrete,
    fmi3Dependent
} fmi3DependencyKind;
typedef enum {
    fmi3IntervalNotYetKnown,
    fmi3IntervalUnchanged,
    fmi3IntervalChanged
} fmi3IntervalQualifier;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String category,
                                       fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64 time,
                                               fmi3Boolean setRequested, fmi3Boolean getAllowed,
                                               fmi3Boolean stepFinished, fmi3Boolean canReturnEarly,
                                               fmi3Boolean *earlyReturnRequested,
                                               fmi3Float64 *earlyReturnTime);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

MBSRI_FMI3(const char *) fmi3GetVersion(void);
MBSRI_FMI3(fmi3Status)
fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String category[]);
MBSRI_FMI3(fmi3Instance)
fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                             fmi3Boolean visible, fmi3Boolean logging,
                             fmi3InstanceEnvironment environment,
                             fmi3LogMessageCallback logMessage);
MBSRI_FMI3(fmi3Instance)
fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                            fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean eventModeUsed,
                            fmi3Boolean earlyReturnAllowed, const fmi3ValueReference required[],
                            size_t requiredCount, fmi3InstanceEnvironment environment,
                            fmi3LogMessageCallback logMessage,
                            fmi3IntermediateUpdateCallback intermediateUpdate);
MBSRI_FMI3(fmi3Instance)
fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                  fmi3Boolean visible, fmi3Boolean logging,
                                  fmi3InstanceEnvironment environment,
                                  fmi3LogMessageCallback logMessage,
                                  fmi3ClockUpdateCallback clockUpdate,
                                  fmi3LockPreemptionCallback lock,
                                  fmi3UnlockPreemptionCallback unlock);
MBSRI_FMI3(void) fmi3FreeInstance(fmi3Instance c);
MBSRI_FMI3(fmi3Status)
fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                            fmi3Float64 start, fmi3Boolean stopDefined, fmi3Float64 stop);
MBSRI_FMI3(fmi3Status)
fmi3ExitInitializationMode(fmi3Instance c);
MBSRI_FMI3(fmi3Status)
fmi3Terminate(fmi3Instance c);
MBSRI_FMI3(fmi3Status)
fmi3Reset(fmi3Instance c);
MBSRI_FMI3(fmi3Status)
fmi3EnterConfigurationMode(fmi3Instance c);
MBSRI_FMI3(fmi3Status)
fmi3ExitConfigurationMode(fmi3Instance c);
MBSRI_FMI3(fmi3Status)
fmi3EvaluateDiscreteStates(fmi3Instance c);
MBSRI_FMI3(fmi3Status)
fmi3EnterContinuousTimeMode(fmi3Instance c);
MBSRI_FMI3(fmi3Status)
fmi3EnterStepMode(fmi3Instance c);
MBSRI_FMI3(fmi3Status)
fmi3EnterEventMode(fmi3Instance c);

MBSRI_FMI3(fmi3Status)
fmi3GetFloat32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float32 value[],
               size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetFloat32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float32 value[],
               size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[],
               size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[],
               size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetInt8(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int8 value[],
            size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetInt8(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int8 value[],
            size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetUInt8(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt8 value[],
             size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetUInt8(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt8 value[],
             size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetInt16(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int16 value[],
             size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetInt16(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int16 value[],
             size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetUInt16(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt16 value[],
              size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetUInt16(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt16 value[],
              size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int32 value[],
             size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int32 value[],
             size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetUInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt32 value[],
              size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetUInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt32 value[],
              size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int64 value[],
             size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int64 value[],
             size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt64 value[],
              size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 value[],
              size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean value[],
               size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean value[],
               size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3String value[],
              size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String value[],
              size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t size[],
              fmi3Binary value[], size_t values);
MBSRI_FMI3(fmi3Status)
fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t size[],
              const fmi3Binary value[], size_t values);
MBSRI_FMI3(fmi3Status)
fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Clock value[]);
MBSRI_FMI3(fmi3Status)
fmi3SetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Clock value[]);

MBSRI_FMI3(fmi3Status)
fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference vr, size_t *count);
MBSRI_FMI3(fmi3Status)
fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                            size_t elementOfDependent[], fmi3ValueReference independent[],
                            size_t elementOfIndependent[], fmi3DependencyKind kind[], size_t count);
MBSRI_FMI3(fmi3Status)
fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state);
MBSRI_FMI3(fmi3Status)
fmi3SetFMUState(fmi3Instance c, fmi3FMUState state);
MBSRI_FMI3(fmi3Status)
fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state);
MBSRI_FMI3(fmi3Status)
fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size);
MBSRI_FMI3(fmi3Status)
fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size);
MBSRI_FMI3(fmi3Status)
fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state);
MBSRI_FMI3(fmi3Status)
fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknown[], size_t unknowns,
                             const fmi3ValueReference known[], size_t knowns,
                             const fmi3Float64 seed[], size_t seeds, fmi3Float64 sensitivity[],
                             size_t sensitivities);
MBSRI_FMI3(fmi3Status)
fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknown[], size_t unknowns,
                         const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[],
                         size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities);

MBSRI_FMI3(fmi3Status)
fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                       fmi3Float64 interval[], fmi3IntervalQualifier qualifier[]);
MBSRI_FMI3(fmi3Status)
fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                        fmi3UInt64 counter[], fmi3UInt64 resolution[],
                        fmi3IntervalQualifier qualifier[]);
MBSRI_FMI3(fmi3Status)
fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 shift[]);
MBSRI_FMI3(fmi3Status)
fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counter[],
                     fmi3UInt64 resolution[]);
MBSRI_FMI3(fmi3Status)
fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                       const fmi3Float64 interval[]);
MBSRI_FMI3(fmi3Status)
fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                        const fmi3UInt64 counter[], const fmi3UInt64 resolution[]);
MBSRI_FMI3(fmi3Status)
fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                    const fmi3Float64 shift[]);
MBSRI_FMI3(fmi3Status)
fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                     const fmi3UInt64 counter[], const fmi3UInt64 resolution[]);

MBSRI_FMI3(fmi3Status)
fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *needUpdate, fmi3Boolean *terminate,
                         fmi3Boolean *nominalsChanged, fmi3Boolean *valuesChanged,
                         fmi3Boolean *nextEventDefined, fmi3Float64 *nextEvent);
MBSRI_FMI3(fmi3Status)
fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean noSetBefore, fmi3Boolean *enterEventMode,
                            fmi3Boolean *terminate);
MBSRI_FMI3(fmi3Status)
fmi3SetTime(fmi3Instance c, fmi3Float64 t);
MBSRI_FMI3(fmi3Status)
fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n);
MBSRI_FMI3(fmi3Status)
fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 value[], size_t n);
MBSRI_FMI3(fmi3Status)
fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 value[], size_t n);
MBSRI_FMI3(fmi3Status)
fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 value[], size_t n);
MBSRI_FMI3(fmi3Status)
fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 value[], size_t n);
MBSRI_FMI3(fmi3Status)
fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *count);
MBSRI_FMI3(fmi3Status)
fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *count);
MBSRI_FMI3(fmi3Status)
fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                         const fmi3Int32 order[], fmi3Float64 value[], size_t values);
MBSRI_FMI3(fmi3Status)
fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean noSetBefore,
           fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminate, fmi3Boolean *earlyReturn,
           fmi3Float64 *lastSuccessfulTime);
MBSRI_FMI3(fmi3Status)
fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 t);

#endif

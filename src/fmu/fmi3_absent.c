/* The functions of FMI 3.0 for what this FMU does not have: variables of other types, clocks,
 * dependencies of elements, structural parameters, scheduled execution. They refuse, with a
 * message, but for calls with no variables.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/fmi3_enter.h"

/* What is asked for, or set, of `count` variables. */
static fmi3Status none(mbsri_instance *in, size_t count, const char *function)
{
    if (count == 0) return fmi3OK;
    return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: there are no variables of this type",
                                 function);
}

static fmi3Status refuse_call(mbsri_instance *in, const char *function)
{
    return (fmi3Status)mbsri_say(in, MBSRI_ERROR, "%s: the FMU does not offer this", function);
}

#define TYPE(type)                                                                                 \
    fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n,              \
                             fmi3##type value[], size_t values)                                    \
    {                                                                                              \
        ENTER(ALWAYS);                                                                             \
        (void)vr, (void)value;                                                                     \
        return none(in, n + values, __func__);                                                     \
    }                                                                                              \
    fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n,              \
                             const fmi3##type value[], size_t values)                              \
    {                                                                                              \
        ENTER(RUNNING);                                                                            \
        (void)vr, (void)value;                                                                     \
        return none(in, n + values, __func__);                                                     \
    }

TYPE(Float32)
TYPE(Int8)
TYPE(UInt8)
TYPE(Int16)
TYPE(UInt16)
TYPE(Int32)
TYPE(UInt32)
TYPE(Int64)
TYPE(UInt64)
TYPE(Boolean)
TYPE(String)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t size[],
                         fmi3Binary value[], size_t values)
{
    ENTER(ALWAYS);
    (void)vr, (void)size, (void)value;
    return none(in, n + values, __func__);
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                         const size_t size[], const fmi3Binary value[], size_t values)
{
    ENTER(RUNNING);
    (void)vr, (void)size, (void)value;
    return none(in, n + values, __func__);
}

/* ---- clocks ---- */

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Clock value[])
{
    ENTER(RUNNING);
    (void)vr, (void)value;
    return none(in, n, __func__);
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                        const fmi3Clock value[])
{
    ENTER(RUNNING);
    (void)vr, (void)value;
    return none(in, n, __func__);
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                  fmi3Float64 interval[], fmi3IntervalQualifier qualifier[])
{
    ENTER(RUNNING);
    (void)vr, (void)interval, (void)qualifier;
    return none(in, n, __func__);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                   fmi3UInt64 counter[], fmi3UInt64 resolution[],
                                   fmi3IntervalQualifier qualifier[])
{
    ENTER(RUNNING);
    (void)vr, (void)counter, (void)resolution, (void)qualifier;
    return none(in, n, __func__);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                               fmi3Float64 shift[])
{
    ENTER(RUNNING);
    (void)vr, (void)shift;
    return none(in, n, __func__);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                fmi3UInt64 counter[], fmi3UInt64 resolution[])
{
    ENTER(RUNNING);
    (void)vr, (void)counter, (void)resolution;
    return none(in, n, __func__);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                  const fmi3Float64 interval[])
{
    ENTER(RUNNING);
    (void)vr, (void)interval;
    return none(in, n, __func__);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                   const fmi3UInt64 counter[], const fmi3UInt64 resolution[])
{
    ENTER(RUNNING);
    (void)vr, (void)counter, (void)resolution;
    return none(in, n, __func__);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                               const fmi3Float64 shift[])
{
    ENTER(RUNNING);
    (void)vr, (void)shift;
    return none(in, n, __func__);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                const fmi3UInt64 counter[], const fmi3UInt64 resolution[])
{
    ENTER(RUNNING);
    (void)vr, (void)counter, (void)resolution;
    return none(in, n, __func__);
}

/* ---- dependencies of elements, structural parameters, derivatives of outputs, scheduled execution
 * ---- */

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference vr, size_t *count)
{
    ENTER(ALWAYS);
    (void)vr, (void)count;
    return refuse_call(in, __func__);
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                                       size_t elementOfDependent[],
                                       fmi3ValueReference independent[],
                                       size_t elementOfIndependent[], fmi3DependencyKind kind[],
                                       size_t count)
{
    ENTER(ALWAYS);
    (void)dependent, (void)elementOfDependent, (void)independent, (void)elementOfIndependent,
        (void)kind, (void)count;
    return refuse_call(in, __func__);
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c)
{
    ENTER(ALWAYS);
    return refuse_call(in, __func__);
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c)
{
    ENTER(ALWAYS);
    return refuse_call(in, __func__);
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                    const fmi3Int32 order[], fmi3Float64 value[], size_t values)
{
    ENTER(MBSRI_STEP | MBSRI_INTERMEDIATE | MBSRI_TERMINATED);
    (void)vr, (void)n, (void)order, (void)value, (void)values;
    return refuse_call(in, __func__);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 t)
{
    ENTER(ALWAYS);
    (void)clock, (void)t;
    return refuse_call(in, __func__);
}

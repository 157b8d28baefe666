/* Calls of an FMU in any order, with arguments and at times as bytes say, and resources that bytes
 * damage: each call ends with a status of the standard, none is fatal, and what is read with OK is
 * finite unless a caller gave what is not. For libFuzzer (option MBSR_FUZZ);
 * tests/fmu/test_any_calls.c calls it, too.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _XOPEN_SOURCE 700
#include "fuzz_files.h"

#include "fmu/fmi2_functions.h"
#include "fmu/fmi3_functions.h"
#include "units.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MODELS = 4, NUMBERS = 40, VARIABLES = 1000, RESOURCE = 1 << 16 };

/* Where a caller stands. */
enum { BEFORE, EVENTS, CONTINUOUS, STEPS };

/* A model as files, exported at the first call. */
typedef struct exported {
    char folder[64], resources[96], token[64];
    unsigned char data[RESOURCE];
    size_t size;
    unsigned inputs[VARIABLES], parameters[VARIABLES], outputs[VARIABLES];
    unsigned n_inputs, n_parameters, n_outputs, variables;
    size_t states, indicators;
} exported;

/* What a caller may give: mostly what fits. */
typedef struct caller {
    const uint8_t *next, *end;
    void *c, *saved;
    fmi3ValueReference vr[4];
    double in[NUMBERS], out[NUMBERS];
    uint8_t bytes[1 << 15];
    size_t n, size;
    const exported *e;
    int mode, co_simulation;
    double t, saved_t;
    int careful; /* gives what fits only */
    int odd;     /* a number that is no number was given, or one beyond 1e100 */
} caller;

static exported kept[2][MODELS];

static void remove_folders(void)
{
    for (int k = 0; k < 2 * MODELS; ++k) {
        char command[96];
        if (!kept[k % 2][k / 2].size) continue;
        snprintf(command, sizeof command, "rm -rf '%s'", kept[k % 2][k / 2].folder);
        if (system(command)) abort();
    }
}

static void read_file(const char *path, void *data, size_t most, size_t *size)
{
    FILE *from = fopen(path, "rb");
    *size = from ? fread(data, 1, most, from) : 0;
    if (*size == 0 || *size == most) abort();
    fclose(from);
}

static void read_variables(exported *e, const char *text)
{
    static const char word[] = "valueReference=\"";
    for (const char *at = strstr(text, word); at; at = strstr(at + 1, word)) {
        const unsigned vr = (unsigned)strtoul(at + sizeof word - 1, NULL, 10);
        const char *end = strchr(at, '>'), *role = strstr(at, "causality=\"");
        if (vr >= VARIABLES) abort();
        if (vr >= e->variables) e->variables = vr + 1;
        if (!role || role > end) continue;
        role += strlen("causality=\"");
        if (!strncmp(role, "input", 5)) e->inputs[e->n_inputs++] = vr;
        if (!strncmp(role, "output", 6)) e->outputs[e->n_outputs++] = vr;
        if (!strncmp(role, "parameter", 9)) e->parameters[e->n_parameters++] = vr;
    }
    for (const char *at = text; (at = strstr(at, " derivative=\"")); ++at) ++e->states;
    for (const char *at = text; (at = strstr(at, "<EventIndicator ")); ++at) ++e->indicators;
    const char *count = strstr(text, "numberOfEventIndicators=\"");
    if (count) e->indicators = strtoul(count + strlen("numberOfEventIndicators=\""), NULL, 10);
    if (e->states >= NUMBERS || e->indicators >= NUMBERS) abort();
    if (!e->variables || !e->n_parameters) abort();
}

static const exported *export_unit(int model, int version)
{
    static void (*const make[MODELS])(unit_model * m) = {make_arm, make_beam, make_linkage,
                                                         make_body};
    static char text[1 << 20];
    exported *e = &kept[version == 2][model];
    mbsr_fmu_opt opt = mbsr_default_fmu_opt();
    unit_model m;
    mbsr_fmu *fmu;
    char path[128], folder[] = "fmu calls XXXXXX";
    size_t length;
    if (e->size) return e;
    if (!kept[0][0].size && !kept[1][0].size && atexit(remove_folders)) abort();
    make[model](&m);
    opt.version = version;
    if (mbsr_model_finish(m.s.model) || mbsr_fmu_export(m.s.model, &opt, &fmu, NULL) ||
        !mkdtemp(folder) || unpack(fmu, folder))
        abort();
    mbsr_fmu_destroy(fmu);
    free_model(&m);
    memcpy(e->folder, folder, sizeof folder);
    snprintf(path, sizeof path, "%s/modelDescription.xml", folder);
    read_file(path, text, sizeof text - 1, &length);
    text[length] = '\0';
    read_variables(e, text);
    const char *word = version == 2 ? "guid=\"" : "instantiationToken=\"";
    const char *token = strstr(text, word) + strlen(word);
    snprintf(e->token, sizeof e->token, "%.*s", (int)strcspn(token, "\""), token);
    snprintf(e->resources, sizeof e->resources, "%s/resources/", folder);
    snprintf(path, sizeof path, "%smodel.mbsrank", e->resources);
    read_file(path, e->data, sizeof e->data, &e->size);
    return e;
}

/* Of 0 to n - 1. */
static unsigned pick(caller *x, unsigned n)
{
    return x->next < x->end ? *x->next++ % n : 0;
}

static double number(caller *x)
{
    static const double odd[] = {NAN, INFINITY, -1e300, 1e150};
    const unsigned high = pick(x, 256);
    if (!x->careful && high > 251) {
        x->odd = 1;
        return odd[high - 252];
    }
    return ((double)high - 126.0) / 126.0;
}

/* At times NULL, or one number more. */
static void *place(caller *x, void *memory)
{
    return x->careful || pick(x, 16) ? memory : NULL;
}

static size_t about(caller *x, size_t n)
{
    return x->careful || pick(x, 10) ? n : n + 1;
}

static void give(caller *x)
{
    x->n = pick(x, 4);
    for (int k = 0; k < 4; ++k)
        x->vr[k] = (256 * pick(x, 256) + pick(x, 256)) % (x->e->variables + !x->careful);
    const double scale = number(x), turn = number(x);
    for (int k = 0; k < NUMBERS; ++k) x->in[k] = k ? scale * sin(k + turn) : scale;
}

/* What was read with OK. */
static int read_numbers(caller *x, int status, size_t n)
{
    if (status == fmi3OK && !x->odd) {
        for (size_t k = 0; k < n; ++k)
            if (!isfinite(x->out[k])) abort();
    }
    return status;
}

/* What follows from a call that was OK: where the caller stands, and at what time. */
static int goes(caller *x, int status, int next)
{
    if (status == fmi3OK) x->mode = next;
    if (status == fmi3OK && next == BEFORE) x->t = 0.0;
    return status;
}

static int steps(caller *x, int status, double h)
{
    if (status == fmi3OK) x->t += h;
    return status;
}

/* The state that is kept, or goes back to it. */
static int keeps(caller *x, int status)
{
    if (status == fmi3OK) x->saved_t = x->t;
    return status;
}

static int goes_back(caller *x, int status)
{
    if (status == fmi3OK) x->t = x->saved_t;
    return status;
}

static int changes_mode(caller *x)
{
    bool a, b, d, e, f;
    switch (pick(x, 13)) {
    case 0: return (int)fmi3EnterInitializationMode(x->c, pick(x, 2), x->in[1], 0, false, 0);
    case 1: return (int)fmi3ExitInitializationMode(x->c);
    case 2: return (int)fmi3EnterContinuousTimeMode(x->c);
    case 3: return (int)fmi3EnterStepMode(x->c);
    case 4: return (int)fmi3EnterEventMode(x->c);
    case 5: return (int)fmi3Reset(x->c);
    case 6: return (int)fmi3EnterConfigurationMode(x->c);
    case 7: return (int)fmi3EvaluateDiscreteStates(x->c);
    case 8: return (int)fmi3UpdateDiscreteStates(x->c, place(x, &a), &b, &d, &e, &f, x->out);
    case 9: return (int)fmi3Terminate(x->c);
    default: return fmi3OK;
    }
}

static int reads_or_writes(caller *x)
{
    fmi3String text[4] = {"", "", "", ""};
    switch (pick(x, 8)) {
    case 0: return (int)fmi3SetFloat64(x->c, place(x, x->vr), x->n, x->in, about(x, x->n));
    case 1: return (int)fmi3GetString(x->c, x->vr, x->n, text, about(x, x->n));
    case 2: return (int)fmi3GetClock(x->c, x->vr, x->n, (bool *)x->bytes);
    case 3: return (int)fmi3GetBoolean(x->c, x->vr, x->n, (bool *)x->bytes, x->n);
    case 4: return (int)fmi3GetNumberOfVariableDependencies(x->c, x->vr[0], place(x, &x->size));
    case 5: return (int)fmi3SetDebugLogging(x->c, pick(x, 2), 0, NULL);
    default: {
        const size_t n = about(x, x->n);
        return read_numbers(x, (int)fmi3GetFloat64(x->c, x->vr, x->n, place(x, x->out), n), n);
    }
    }
}

static int moves(caller *x)
{
    bool a, b, d;
    const size_t n = about(x, x->e->states);
    switch (pick(x, x->mode == CONTINUOUS ? 7 : 8)) {
    case 0: return (int)fmi3SetTime(x->c, 0.1 * fabs(x->in[1]));
    case 1: return (int)fmi3SetContinuousStates(x->c, place(x, x->in), n);
    case 2: return read_numbers(x, (int)fmi3GetContinuousStates(x->c, x->out, n), n);
    case 3: return read_numbers(x, (int)fmi3GetContinuousStateDerivatives(x->c, x->out, n), n);
    case 4: return read_numbers(x, (int)fmi3GetNominalsOfContinuousStates(x->c, x->out, n), n);
    case 5: return (int)fmi3GetEventIndicators(x->c, place(x, x->out), about(x, x->e->indicators));
    case 6: return (int)fmi3CompletedIntegratorStep(x->c, true, place(x, &a), &b);
    default: {
        const double h = pick(x, 20) ? 8e-5 * pick(x, 250) : x->in[2];
        return (int)fmi3DoStep(x->c, x->t, fabs(h) > 0.1 ? NAN : h, true, place(x, &a), &b, &d,
                               x->out);
    }
    }
}

/* What of this can be asked for: a derivative of outputs with respect to parameters. */
static void choose_derivative(caller *x)
{
    if (!x->careful) return;
    for (size_t k = 0; k < 3; ++k)
        x->vr[k] = k < x->n && x->e->n_outputs ? x->e->outputs[pick(x, x->e->n_outputs)]
                                               : x->e->parameters[pick(x, x->e->n_parameters)];
}

static int keeps_or_derives(caller *x)
{
    const size_t n = x->n, m = 3 - n;
    choose_derivative(x);
    if (x->careful && !x->saved) return keeps(x, (int)fmi3GetFMUState(x->c, &x->saved));
    switch (pick(x, 7)) {
    case 0: return keeps(x, (int)fmi3GetFMUState(x->c, place(x, &x->saved)));
    case 1: return goes_back(x, (int)fmi3SetFMUState(x->c, x->saved));
    case 2: return (int)fmi3FreeFMUState(x->c, &x->saved);
    case 3: return (int)fmi3SerializedFMUStateSize(x->c, x->saved, place(x, &x->size));
    case 4: return (int)fmi3SerializeFMUState(x->c, x->saved, x->bytes, sizeof x->bytes);
    case 5: {
        const size_t given = about(x, n);
        double *out = place(x, x->out);
        return read_numbers(
            x, (int)fmi3GetAdjointDerivative(x->c, x->vr, n, x->vr + n, m, x->in, given, out, m),
            m);
    }
    default: {
        const size_t given = about(x, m);
        double *in = place(x, x->in);
        return read_numbers(
            x,
            (int)fmi3GetDirectionalDerivative(x->c, x->vr, n, x->vr + n, m, in, given, x->out, n),
            n);
    }
    }
}

static int changes_mode2(caller *x)
{
    fmi2EventInfo info;
    fmi2Boolean a, b;
    switch (pick(x, 13)) {
    case 0: return (int)fmi2SetupExperiment(x->c, 0, x->in[1], 0.0, 0, 0.0);
    case 1: return (int)fmi2EnterInitializationMode(x->c);
    case 2: return (int)fmi2ExitInitializationMode(x->c);
    case 3: return (int)fmi2EnterContinuousTimeMode(x->c);
    case 4: return (int)fmi2EnterEventMode(x->c);
    case 5: return (int)fmi2Reset(x->c);
    case 6: return (int)fmi2NewDiscreteStates(x->c, place(x, &info));
    case 7: return (int)fmi2CompletedIntegratorStep(x->c, 1, place(x, &a), &b);
    case 8: return (int)fmi2Terminate(x->c);
    case 9: return (int)fmi2CancelStep(x->c);
    default: return fmi2OK;
    }
}

static int reads_or_writes2(caller *x)
{
    fmi2String text[4] = {"", "", "", ""};
    fmi2Integer whole[4] = {0, 1, 2, 0};
    const fmi2StatusKind kind = (fmi2StatusKind)pick(x, 4);
    fmi2Status status;
    switch (pick(x, 15)) {
    case 0: return (int)fmi2SetReal(x->c, place(x, x->vr), x->n, place(x, x->in));
    case 1: return (int)fmi2GetInteger(x->c, x->vr, x->n, whole);
    case 2: return (int)fmi2GetBoolean(x->c, x->vr, x->n, whole);
    case 3: return (int)fmi2GetString(x->c, x->vr, x->n, text);
    case 4: return (int)fmi2SetInteger(x->c, x->vr, x->n, whole);
    case 5: return (int)fmi2SetBoolean(x->c, x->vr, x->n, whole);
    case 6: return (int)fmi2SetString(x->c, x->vr, x->n, text);
    case 7: return (int)fmi2GetStatus(x->c, kind, &status);
    case 8: return (int)fmi2GetRealStatus(x->c, kind, place(x, x->out));
    case 9: return (int)fmi2GetIntegerStatus(x->c, kind, whole);
    case 10: return (int)fmi2GetBooleanStatus(x->c, kind, place(x, whole));
    case 11: return (int)fmi2GetStringStatus(x->c, kind, text);
    case 12: return (int)fmi2SetDebugLogging(x->c, 1, 0, NULL);
    default: return read_numbers(x, (int)fmi2GetReal(x->c, x->vr, x->n, place(x, x->out)), x->n);
    }
}

static int moves2(caller *x)
{
    const fmi2Integer order[4] = {1, 1, (int)pick(x, 3), 1};
    const size_t n = about(x, x->e->states);
    switch (pick(x, x->mode == CONTINUOUS ? 6 : 9)) {
    case 0: return (int)fmi2SetTime(x->c, 0.1 * fabs(x->in[1]));
    case 1: return (int)fmi2SetContinuousStates(x->c, place(x, x->in), n);
    case 2: return read_numbers(x, (int)fmi2GetContinuousStates(x->c, x->out, n), n);
    case 3: return read_numbers(x, (int)fmi2GetDerivatives(x->c, x->out, n), n);
    case 4: return read_numbers(x, (int)fmi2GetNominalsOfContinuousStates(x->c, x->out, n), n);
    case 5: return (int)fmi2GetEventIndicators(x->c, place(x, x->out), about(x, x->e->indicators));
    case 6: return (int)fmi2SetRealInputDerivatives(x->c, x->vr, x->n, order, place(x, x->in));
    case 7:
        return read_numbers(x, (int)fmi2GetRealOutputDerivatives(x->c, x->vr, x->n, order, x->out),
                            x->n);
    default: return (int)fmi2DoStep(x->c, x->t, 8e-5 * pick(x, 250), 1);
    }
}

static int keeps_or_derives2(caller *x)
{
    size_t size;
    choose_derivative(x);
    if (x->careful && !x->saved) return keeps(x, (int)fmi2GetFMUstate(x->c, &x->saved));
    switch (pick(x, 6)) {
    case 0: return keeps(x, (int)fmi2GetFMUstate(x->c, place(x, &x->saved)));
    case 1: return goes_back(x, (int)fmi2SetFMUstate(x->c, x->saved));
    case 2: return (int)fmi2FreeFMUstate(x->c, &x->saved);
    case 3: return (int)fmi2SerializedFMUstateSize(x->c, x->saved, place(x, &size));
    case 4: return (int)fmi2SerializeFMUstate(x->c, x->saved, (char *)x->bytes, sizeof x->bytes);
    default:
        return read_numbers(x,
                            (int)fmi2GetDirectionalDerivative(x->c, x->vr, x->n, x->vr + x->n,
                                                              3 - x->n, place(x, x->in), x->out),
                            x->n);
    }
}

static void note2(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                  fmi2String category, fmi2String message, ...)
{
    (void)environment;
    (void)instance;
    (void)category;
    if (status == fmi2Fatal || !message[0]) abort();
}

static void note3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                  fmi3String message)
{
    (void)environment;
    (void)category;
    if (status == fmi3Fatal || !message[0]) abort();
}

static void *instantiate3(const char *token, const char *resources, int co_simulation)
{
    return co_simulation
               ? fmi3InstantiateCoSimulation("one", token, resources, false, true, false, false,
                                             NULL, 0, NULL, note3, NULL)
               : fmi3InstantiateModelExchange("one", token, resources, false, true, NULL, note3);
}

static void *instantiate2(const char *token, const char *resources, int co_simulation)
{
    static const fmi2CallbackFunctions functions = {note2, calloc, free, NULL, NULL};
    return fmi2Instantiate("one", co_simulation ? fmi2CoSimulation : fmi2ModelExchange, token,
                           resources, &functions, 0, 1);
}

static int sets(caller *x, const unsigned *vr, unsigned n, int version)
{
    if (!n) return fmi3OK;
    for (size_t k = 0; k < x->n; ++k) x->vr[k] = vr[pick(x, n)];
    return version == 2 ? (int)fmi2SetReal(x->c, x->vr, x->n, x->in)
                        : (int)fmi3SetFloat64(x->c, x->vr, x->n, x->in, x->n);
}

static int gets(caller *x, int version)
{
    const int status = version == 2 ? (int)fmi2GetReal(x->c, x->vr, x->n, x->out)
                                    : (int)fmi3GetFloat64(x->c, x->vr, x->n, x->out, x->n);
    return read_numbers(x, status, x->n);
}

static int fits_everywhere(caller *x, int version)
{
    switch (pick(x, 3)) {
    case 0: return sets(x, x->e->inputs, x->e->n_inputs, version);
    case 1: return version == 2 ? keeps_or_derives2(x) : keeps_or_derives(x);
    default: return gets(x, version);
    }
}

/* A call that the standard allows where the caller stands. */
static int fits(caller *x)
{
    bool a, b, d, e, f;
    if (x->mode != BEFORE && pick(x, 4) == 0) return fits_everywhere(x, 3);
    if (x->mode == BEFORE && pick(x, 4) == 0)
        return sets(x, x->e->parameters, x->e->n_parameters, 3);
    switch (x->mode) {
    case BEFORE: {
        int status = (int)fmi3EnterInitializationMode(x->c, false, 0, 0, false, 0);
        if (status == fmi3OK) status = (int)fmi3ExitInitializationMode(x->c);
        if (status == fmi3OK && !x->co_simulation) {
            status = (int)fmi3GetNumberOfContinuousStates(x->c, &x->size);
            if (status || x->size != x->e->states) abort();
        }
        return goes(x, status, x->co_simulation ? STEPS : EVENTS);
    }
    case EVENTS:
        return pick(x, 2) ? (int)fmi3UpdateDiscreteStates(x->c, &a, &b, &d, &e, &f, x->out)
                          : goes(x, (int)fmi3EnterContinuousTimeMode(x->c), CONTINUOUS);
    case CONTINUOUS: return pick(x, 8) ? moves(x) : goes(x, (int)fmi3EnterEventMode(x->c), EVENTS);
    default: {
        const double h = 8e-5 * (1 + pick(x, 250));
        if (!pick(x, 16)) return goes(x, (int)fmi3Reset(x->c), BEFORE);
        return steps(x, (int)fmi3DoStep(x->c, x->t, h, true, &a, &b, &d, x->out), h);
    }
    }
}

static int fits2(caller *x)
{
    fmi2EventInfo info;
    if (x->mode != BEFORE && pick(x, 4) == 0) return fits_everywhere(x, 2);
    if (x->mode == BEFORE && pick(x, 4) == 0)
        return sets(x, x->e->parameters, x->e->n_parameters, 2);
    switch (x->mode) {
    case BEFORE: {
        int status = (int)fmi2SetupExperiment(x->c, 0, 0.0, 0.0, 0, 0.0);
        if (status == fmi2OK) status = (int)fmi2EnterInitializationMode(x->c);
        if (status == fmi2OK) status = (int)fmi2ExitInitializationMode(x->c);
        return goes(x, status, x->co_simulation ? STEPS : EVENTS);
    }
    case EVENTS:
        return pick(x, 2) ? (int)fmi2NewDiscreteStates(x->c, &info)
                          : goes(x, (int)fmi2EnterContinuousTimeMode(x->c), CONTINUOUS);
    case CONTINUOUS: return pick(x, 8) ? moves2(x) : goes(x, (int)fmi2EnterEventMode(x->c), EVENTS);
    default: {
        const double h = 8e-5 * (1 + pick(x, 250));
        if (!pick(x, 16)) return goes(x, (int)fmi2Reset(x->c), BEFORE);
        return steps(x, (int)fmi2DoStep(x->c, x->t, h, 1), h);
    }
    }
}

static void calls(caller *x, int version)
{
    static int (*const act[2][4])(caller * x) = {
        {changes_mode, reads_or_writes, moves, keeps_or_derives},
        {changes_mode2, reads_or_writes2, moves2, keeps_or_derives2}};
    x->mode = BEFORE;
    for (int k = 0; k < 100 && x->next < x->end; ++k) {
        give(x);
        const int any = !x->careful && pick(x, 12) == 0,
                  status = any            ? act[version == 2][pick(x, 4)](x)
                           : version == 2 ? fits2(x)
                                          : fits(x);
        if (status < fmi3OK || status > fmi3Error) abort();
        if (status != fmi3Error || !pick(x, 4)) continue;
        const int again = version == 2 ? (int)fmi2Reset(x->c) : (int)fmi3Reset(x->c);
        if (goes(x, again, BEFORE)) abort();
    }
}

/* Bytes of the resources changed in up to 40 places, under the token that belongs to them. */
static void damaged(caller *x, const exported *e)
{
    static unsigned char data[RESOURCE];
    char path[128], token[33];
    size_t size = e->size;
    memcpy(data, e->data, size);
    for (int k = 0; k < 40 && x->next < x->end; ++k) {
        const size_t at = (256 * pick(x, 256) + pick(x, 256)) % size;
        data[at] = (unsigned char)pick(x, 256);
    }
    stamp(data, size, token);
    snprintf(path, sizeof path, "%smodel.mbsrank", e->resources);
    FILE *to = fopen(path, "wb");
    if (!to || fwrite(data, 1, size, to) != size || fclose(to)) abort();
    x->c = instantiate3(token, e->resources, 1);
    if (!x->c) return;
    bool event, terminate, early;
    double last;
    (void)fmi3EnterInitializationMode(x->c, false, 0.0, 0.0, false, 0.0);
    (void)fmi3ExitInitializationMode(x->c);
    (void)fmi3DoStep(x->c, 0.0, 1e-3, true, &event, &terminate, &early, &last);
    fmi3FreeInstance(x->c);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static caller x;
    if (size < 2) return 0;
    const int version = bytes[0] % 2 ? 2 : 3, co_simulation = bytes[0] / 2 % 2;
    const exported *e = export_unit(bytes[0] / 4 % MODELS, version);
    memset(&x, 0, sizeof x);
    x.next = bytes + 1;
    x.end = bytes + size;
    x.e = e;
    x.co_simulation = co_simulation;
    x.careful = bytes[0] / 64 % 2;
    if (version == 3 && bytes[0] / 16 % 4 == 0) {
        damaged(&x, e);
        return 0;
    }
    char path[128];
    snprintf(path, sizeof path, "%smodel.mbsrank", e->resources);
    FILE *to = fopen(path, "wb");
    if (!to || fwrite(e->data, 1, e->size, to) != e->size || fclose(to)) abort();
    x.c = (version == 2 ? instantiate2 : instantiate3)(e->token, e->resources, co_simulation);
    if (!x.c && co_simulation) abort();
    if (!x.c) return 0; /* what has loops is not exchanged */
    calls(&x, version);
    if (version == 2) {
        (void)fmi2FreeFMUstate(x.c, &x.saved);
        fmi2FreeInstance(x.c);
    } else {
        (void)fmi3FreeFMUState(x.c, &x.saved);
        fmi3FreeInstance(x.c);
    }
    return 0;
}

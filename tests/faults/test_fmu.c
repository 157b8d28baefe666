/* Units are exported and run as an importer does, where each place of the component fmu at which a
 * status is taken fails.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _XOPEN_SOURCE 700
#include "faults.h"

#include "../fmu/units.h"
#include "files/xml_make.h"
#include "fmu/fmi2_functions.h"
#include "fmu/fmi3_functions.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

/* What functions of the component call, which are linked behind those of files: steps of solvers
 * are of other tests. */
static bool of_the_component(test_faults_list list, const char *caller)
{
    return list == TEST_FAULTS_FMU || (uintptr_t)caller > (uintptr_t)mbsri_put_in_place;
}

enum { NUMBERS = 1024, ROOM = 40, OUTPUTS = 6, VARIABLES = 300, BYTES = 1 << 16 };

static double out[NUMBERS];

/* A unit that was unpacked, and value references of it. */
typedef struct unit {
    mbsr_fmu_opt opt;
    unit_model model;
    char folder[32], resources[64], token[64];
    unsigned input, parameter, output[OUTPUTS], all[VARIABLES];
    bool has_input;
    size_t states, indicators, variables;
} unit;

/* ---- units in folders ---- */

static unsigned first_of(const char *text, const char *causality, const char *beyond)
{
    const char *at = beyond ? beyond : strstr(text, causality);
    while (at && at > text && strncmp(at, "valueReference=\"", 16) != 0) --at;
    return at && at > text ? (unsigned)strtoul(at + 16, NULL, 10) : 0;
}

static void read_description(unit *n)
{
    static char text[1 << 20];
    char path[64];
    snprintf(path, sizeof path, "%s/modelDescription.xml", n->folder);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    const char *token = strstr(text, n->opt.version == 2 ? "guid=\"" : "instantiationToken=\"");
    token = strchr(token, '"') + 1;
    snprintf(n->token, sizeof n->token, "%.*s", (int)strcspn(token, "\""), token);
    n->has_input = strstr(text, "causality=\"input\"") != NULL;
    n->input = first_of(text, "causality=\"input\"", NULL);
    n->parameter = first_of(text, "causality=\"parameter\"", NULL);
    const char *output = strstr(text, "causality=\"output\"");
    for (int k = 0; k < OUTPUTS; ++k) { /* the last one again where there are no more */
        const char *next = k > 0 ? strstr(output + 1, "causality=\"output\"") : NULL;
        if (next) output = next;
        n->output[k] = first_of(text, NULL, output);
    }
    for (const char *at = text; (at = strstr(at, "valueReference=\"")) && n->variables < VARIABLES;)
        n->all[n->variables++] = (unsigned)strtoul(at += 16, NULL, 10);
    for (const char *at = text; (at = strstr(at, " derivative=\"")); ++at) ++n->states;
    for (const char *at = text; (at = strstr(at, "<EventIndicator ")); ++at) ++n->indicators;
    const char *count = strstr(text, "numberOfEventIndicators=\"");
    if (count) n->indicators = strtoul(strchr(count, '"') + 1, NULL, 10);
    assert_true(n->states < ROOM && n->indicators < ROOM);
}

static void open_unit(unit *n, void (*make)(unit_model *m), int version, double step)
{
    mbsr_fmu *fmu;
    *n = (unit){.opt = mbsr_default_fmu_opt(), .folder = "faults XXXXXX"};
    n->opt.version = version;
    n->opt.fixed_step = step;
    make(&n->model);
    assert_int_equal(mbsr_model_finish(n->model.s.model), MBSR_OK);
    assert_int_equal(mbsr_fmu_export(n->model.s.model, &n->opt, &fmu, NULL), MBSR_OK);
    assert_non_null(mkdtemp(n->folder));
    assert_int_equal(unpack(fmu, n->folder), 0);
    mbsr_fmu_destroy(fmu);
    snprintf(n->resources, sizeof n->resources, "%s/resources/", n->folder);
    read_description(n);
}

static void close_unit(unit *n)
{
    char words[64];
    snprintf(words, sizeof words, "rm -r '%s'", n->folder);
    assert_int_equal(system(words), 0);
    free_model(&n->model);
}

/* ---- acts ---- */

static int is_exported(void *user)
{
    const unit *n = user;
    mbsr_fmu *fmu = NULL;
    const int status = mbsr_fmu_export(n->model.s.model, &n->opt, &fmu, NULL);
    for (size_t k = 0; !status && k < fmu->size; ++k) out[k % NUMBERS] += fmu->data[k];
    mbsr_fmu_destroy(fmu);
    return status;
}

static void note3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                  fmi3String message)
{
    (void)environment, (void)status, (void)category, (void)message;
}

/* The first status that is not OK is kept. */
#define TRY(call)                                                                                  \
    do {                                                                                           \
        if (!status) status = (int)(call);                                                         \
    } while (0)

static int goes_back3(const unit *n, fmi3Instance c)
{
    static fmi3Byte bytes[BYTES];
    fmi3FMUState saved = NULL, again = NULL;
    size_t size = 0;
    int status = (int)fmi3GetFMUState(c, &saved);
    TRY(fmi3SerializedFMUStateSize(c, saved, &size));
    TRY(size > BYTES ? fmi3Error : fmi3SerializeFMUState(c, saved, bytes, size));
    TRY(fmi3DeserializeFMUState(c, bytes, size, &again));
    TRY(fmi3SetFMUState(c, again));
    TRY(fmi3GetFloat64(c, n->output, OUTPUTS, out + 40, OUTPUTS));
    fmi3FreeFMUState(c, &again);
    fmi3FreeFMUState(c, &saved);
    return status;
}

static int is_initialized3(const unit *n, fmi3Instance c)
{
    const double value = 0.1;
    double parameter = 0.0;
    int status = (int)fmi3GetFloat64(c, &n->parameter, 1, &parameter, 1);
    parameter *= 1.01;
    TRY(fmi3SetFloat64(c, &n->parameter, 1, &parameter, 1));
    TRY(fmi3EnterInitializationMode(c, true, 1e-6, 0.0, true, 1.0));
    if (n->has_input) TRY(fmi3SetFloat64(c, &n->input, 1, &value, 1));
    TRY(fmi3GetFloat64(c, n->output, OUTPUTS, out, OUTPUTS));
    TRY(fmi3ExitInitializationMode(c));
    return status;
}

static int is_derived3(const unit *n, fmi3Instance c, unsigned of, double *to)
{
    const double seed[OUTPUTS] = {1.0, 0.5};
    int status = 0;
    TRY(fmi3GetDirectionalDerivative(c, n->output, OUTPUTS, &of, 1, seed, 1, to, OUTPUTS));
    TRY(fmi3GetAdjointDerivative(c, n->output, OUTPUTS, &of, 1, seed, OUTPUTS, to + OUTPUTS, 1));
    return status;
}

static int is_stepped3(void *user)
{
    const unit *n = user;
    bool a, b, d;
    double last;
    fmi3Instance c = fmi3InstantiateCoSimulation("one", n->token, n->resources, false, true, false,
                                                 false, NULL, 0, NULL, note3, NULL);
    if (!c) return fmi3Error;
    int status = is_initialized3(n, c);
    TRY(is_derived3(n, c, n->has_input ? n->input : n->parameter, out + 8));
    TRY(is_derived3(n, c, n->parameter, out + 20));
    TRY(fmi3DoStep(c, 0.0, 0.002, true, &a, &b, &d, &last));
    TRY(fmi3GetFloat64(c, n->all, n->variables, out + 300, n->variables));
    TRY(goes_back3(n, c));
    TRY(fmi3DoStep(c, 0.002, 0.002, true, &a, &b, &d, &last));
    TRY(fmi3GetFloat64(c, n->output, OUTPUTS, out + 50, OUTPUTS));
    TRY(fmi3Reset(c));
    TRY(is_initialized3(n, c));
    fmi3FreeInstance(c);
    return status;
}

static int is_exchanged3(void *user)
{
    const unit *n = user;
    bool a, b, d, e, f;
    double x[ROOM], last;
    fmi3Instance c =
        fmi3InstantiateModelExchange("one", n->token, n->resources, false, true, NULL, note3);
    if (!c) return fmi3Error;
    int status = is_initialized3(n, c);
    TRY(fmi3UpdateDiscreteStates(c, &a, &b, &d, &e, &f, &last));
    TRY(fmi3EnterContinuousTimeMode(c));
    TRY(fmi3GetContinuousStates(c, x, n->states));
    TRY(fmi3GetNominalsOfContinuousStates(c, out + 60, n->states));
    TRY(fmi3SetTime(c, 0.001));
    if (!status && n->states) x[0] += 1e-3;
    TRY(fmi3SetContinuousStates(c, x, n->states));
    TRY(fmi3GetContinuousStateDerivatives(c, out + 100, n->states));
    TRY(fmi3GetEventIndicators(c, out + 140, n->indicators));
    TRY(fmi3CompletedIntegratorStep(c, true, &a, &b));
    TRY(is_derived3(n, c, n->has_input ? n->input : n->parameter, out + 180));
    TRY(is_derived3(n, c, n->parameter, out + 200));
    TRY(fmi3EnterEventMode(c));
    TRY(goes_back3(n, c));
    fmi3FreeInstance(c);
    return status;
}

static void note2(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                  fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)instance, (void)status, (void)category, (void)message;
}

static int is_stepped2(void *user)
{
    static const fmi2CallbackFunctions functions = {note2, calloc, free, NULL, NULL};
    const unit *n = user;
    const double one = 1.0, value = 0.1;
    fmi2FMUstate saved = NULL;
    fmi2Component c =
        fmi2Instantiate("one", fmi2CoSimulation, n->token, n->resources, &functions, 0, 1);
    if (!c) return fmi2Error;
    int status = (int)fmi2SetupExperiment(c, 1, 1e-6, 0.0, 1, 1.0);
    TRY(fmi2EnterInitializationMode(c));
    if (n->has_input) TRY(fmi2SetReal(c, &n->input, 1, &value));
    TRY(fmi2ExitInitializationMode(c));
    TRY(fmi2GetFMUstate(c, &saved));
    TRY(fmi2DoStep(c, 0.0, 0.002, 1));
    TRY(fmi2GetReal(c, n->all, n->variables, out + 300));
    const unsigned of = n->has_input ? n->input : n->parameter;
    TRY(fmi2GetDirectionalDerivative(c, n->output, OUTPUTS, &of, 1, &one, out + 2));
    TRY(fmi2SetFMUstate(c, saved));
    TRY(fmi2DoStep(c, 0.0, 0.001, 1));
    TRY(fmi2GetReal(c, n->output, OUTPUTS, out + 10));
    fmi2FreeFMUstate(c, &saved);
    fmi2FreeInstance(c);
    return status;
}

static int is_exchanged2(void *user)
{
    static const fmi2CallbackFunctions functions = {note2, calloc, free, NULL, NULL};
    const unit *n = user;
    double x[ROOM];
    fmi2EventInfo info;
    fmi2Boolean a, b;
    fmi2Component c =
        fmi2Instantiate("one", fmi2ModelExchange, n->token, n->resources, &functions, 0, 1);
    if (!c) return fmi2Error;
    int status = (int)fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0);
    TRY(fmi2EnterInitializationMode(c));
    TRY(fmi2ExitInitializationMode(c));
    TRY(fmi2NewDiscreteStates(c, &info));
    TRY(fmi2EnterContinuousTimeMode(c));
    TRY(fmi2GetContinuousStates(c, x, n->states));
    TRY(fmi2SetTime(c, 0.001));
    TRY(fmi2SetContinuousStates(c, x, n->states));
    TRY(fmi2GetDerivatives(c, out, n->states));
    TRY(fmi2GetNominalsOfContinuousStates(c, out + 60, n->states));
    TRY(fmi2GetEventIndicators(c, out + 120, n->indicators));
    TRY(fmi2CompletedIntegratorStep(c, 1, &a, &b));
    fmi2FreeInstance(c);
    return status;
}

static long each(const char *name, int (*call)(void *user), unit *n)
{
    const test_faults_act act = {name, call, n, out, NUMBERS, 1e-4, 1};
    return test_faults_each(&act);
}

static void of_units(void **state)
{
    static void (*const make[])(unit_model * m) = {make_arm,   make_linkage, make_beam,
                                                   make_balls, make_flyer,   make_wheel};
    (void)state;
    long failed = 0;
    test_faults_only(of_the_component);
    for (int k = 0; k < 6; ++k) {
        for (int fixed = 0; fixed < (k == 0 || k == 3 ? 2 : 1); ++fixed) {
            unit n;
            open_unit(&n, make[k], 3, fixed ? 1e-3 : 0.0);
            failed += each("is exported", is_exported, &n);
            failed += each(fixed ? "is stepped by fixed ones" : "is stepped", is_stepped3, &n);
            if (!fixed) failed += each("is exchanged", is_exchanged3, &n);
            close_unit(&n);
        }
    }
    for (int k = 0; k < 2; ++k) {
        unit n;
        open_unit(&n, make[k], 2, 0.0);
        failed += each("is exported for 2", is_exported, &n);
        failed += each("is stepped by 2", is_stepped2, &n);
        failed += each("is exchanged by 2", is_exchanged2, &n);
        close_unit(&n);
    }
    test_faults_only(NULL);
    assert_in_range(failed, 100, 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_units)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* FMUs in an importer in C: against the same run in process, in several threads, on damaged
 * resources.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _XOPEN_SOURCE 700
#include "close.h"
#include "duration.h"
#include "expect.h"
#include "fmu/fmi2_functions.h"
#include "fmu/fmi3_functions.h"
#include "own_joint.h"
#include "units.h"

#include <dlfcn.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* An FMU in a folder, loaded. */
typedef struct loaded {
    char folder[64], resources[96], token[64], *description;
    void *library;
    unit_model model;
} loaded;

static char messages[4096];

static void note(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                 fmi3String message)
{
    (void)environment;
    (void)status;
    (void)category;
    snprintf(messages, sizeof messages, "%s", message);
}

static char *read_text(const char *path)
{
    FILE *from = fopen(path, "rb");
    char *text = calloc(1, 1 << 20);
    assert_non_null(from);
    assert_true(fread(text, 1, (1 << 20) - 1, from) > 0);
    fclose(from);
    return text;
}

static void load_version(loaded *l, void (*make)(unit_model *m), double fixed_step, int version)
{
    mbsr_fmu *fmu;
    mbsr_error error;
    mbsr_fmu_opt opt = mbsr_default_fmu_opt();
    char path[128];
    opt.rtol = opt.atol = 1e-9;
    opt.fixed_step = fixed_step;
    opt.version = version;
    make(&l->model);
    assert_int_equal(mbsr_model_finish(l->model.s.model), MBSR_OK);
    assert_ok(mbsr_fmu_export(l->model.s.model, &opt, &fmu, &error), &error);
    snprintf(l->folder, sizeof l->folder, "fmu test XXXXXX");
    assert_non_null(mkdtemp(l->folder));
    assert_int_equal(unpack(fmu, l->folder), 0);
    mbsr_fmu_destroy(fmu);
    snprintf(path, sizeof path, "%s/modelDescription.xml", l->folder);
    l->description = read_text(path);
    const char *word = version == 2 ? "guid=\"" : "instantiationToken=\"",
               *token = strstr(l->description, word);
    assert_non_null(token);
    snprintf(l->token, sizeof l->token, "%.*s", (int)strcspn(token + strlen(word), "\""),
             token + strlen(word));
    snprintf(l->resources, sizeof l->resources, "%s/resources/", l->folder);
    snprintf(path, sizeof path, "./%s/binaries/%s/model.so", l->folder,
             version == 2 ? "linux64" : "x86_64-linux");
    l->library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    assert_non_null(l->library);
}

static void load(loaded *l, void (*make)(unit_model *m), double fixed_step)
{
    load_version(l, make, fixed_step, 3);
}

static void unload(loaded *l)
{
    char command[128];
    dlclose(l->library);
    free(l->description);
    free_model(&l->model);
    snprintf(command, sizeof command, "rm -r '%s'", l->folder);
    assert_int_equal(system(command), 0);
}

/* A function by its name, as it is declared. */
#define FUNCTION(l, name) __extension__((__typeof__(&name))dlsym((l)->library, #name))

/* The value reference of a variable. */
static fmi3ValueReference find(const loaded *l, const char *name)
{
    char text[128];
    snprintf(text, sizeof text, "name=\"%s\" valueReference=\"", name);
    const char *at = strstr(l->description, text);
    assert_non_null(at);
    return (fmi3ValueReference)strtoul(at + strlen(text), NULL, 10);
}

static fmi3Instance instantiate(const loaded *l)
{
    fmi3Instance c = FUNCTION(l, fmi3InstantiateCoSimulation)(
        "one", l->token, l->resources, false, true, false, false, NULL, 0, NULL, note, NULL);
    return c;
}

static void initialize(const loaded *l, fmi3Instance c)
{
    assert_int_equal(FUNCTION(l, fmi3EnterInitializationMode)(c, false, 0.0, 0.0, false, 0.0),
                     fmi3OK);
    assert_int_equal(FUNCTION(l, fmi3ExitInitializationMode)(c), fmi3OK);
}

static void step(const loaded *l, fmi3Instance c, double t, double h)
{
    bool event, terminate, early;
    double last;
    assert_int_equal(FUNCTION(l, fmi3DoStep)(c, t, h, true, &event, &terminate, &early, &last),
                     fmi3OK);
    assert_false(event || terminate || early);
    assert_true(fabs(last - t - h) < 1e-12);
}

static double get(const loaded *l, fmi3Instance c, const char *name)
{
    const fmi3ValueReference vr = find(l, name);
    double value;
    assert_int_equal(FUNCTION(l, fmi3GetFloat64)(c, &vr, 1, &value, 1), fmi3OK);
    return value;
}

/* ---- against the same run in process ---- */

static void compare_run(void (*make)(unit_model *m), double fixed_step, const char *const *names,
                        double error)
{
    loaded l;
    load(&l, make, fixed_step);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-9;
    assert_int_equal(mbsr_simulation_start(&l.model.s, &opt, 0.0, NULL, NULL), MBSR_OK);
    fmi3Instance c = instantiate(&l);
    assert_non_null(c);
    initialize(&l, c);
    for (int k = 0; k < 40; ++k) step(&l, c, 0.01 * k, 0.01);
    assert_int_equal(mbsr_simulation_to(&l.model.s, 0.4), MBSR_OK);
    const mbsr_simulation *s = &l.model.s;
    for (int k = 0; names[k]; ++k) {
        char name[80];
        snprintf(name, sizeof name, "joints.%s.q", names[k]);
        assert_true(fabs(get(&l, c, name) - s->q[k]) < error);
        snprintf(name, sizeof name, "joints.%s.u", names[k]);
        assert_true(fabs(get(&l, c, name) - s->u[k]) < 30.0 * error);
        snprintf(name, sizeof name, "joints.%s.a", names[k]);
        assert_true(fabs(get(&l, c, name) - s->udot[k]) < 3000.0 * error);
    }
    double kinetic, potential;
    mbsr_energy(s->model, s->data, &kinetic, &potential);
    assert_true(fabs(get(&l, c, "energy.kinetic") - kinetic) < 300.0 * error);
    assert_true(fabs(get(&l, c, "energy.potential") - potential) < 300.0 * error);
    FUNCTION(&l, fmi3FreeInstance)(c);
    unload(&l);
}

static void arm_runs_as_in_process(void **state)
{
    static const char *const names[] = {"upper", "'lower arm'", "flap", NULL};
    (void)state;
    compare_run(make_arm, 0.0, names, 1e-6);
}

static void closed_linkage_runs_as_in_process(void **state)
{
    static const char *const names[] = {"coupler", "rocker", NULL};
    (void)state;
    compare_run(make_linkage, 0.0, names, 1e-6);
}

static void vehicle_runs_by_fixed_steps(void **state)
{
    static const char *const names[] = {"body", "wheel", NULL};
    (void)state;
    compare_run(make_vehicle, 1e-4, names, 1e-5);
}

/* A step of a description that nobody checked may be as short as numbers are: that many are not
 * taken, and the instance goes on. */
static void endless_steps_are_refused(void **state)
{
    (void)state;
    loaded l;
    bool event, terminate, early;
    double last;
    load(&l, make_vehicle, 1e-250);
    fmi3Instance c = instantiate(&l);
    assert_non_null(c);
    initialize(&l, c);
    assert_int_equal(
        FUNCTION(&l, fmi3DoStep)(c, 0.0, 1e-3, true, &event, &terminate, &early, &last),
        fmi3Discard);
    FUNCTION(&l, fmi3FreeInstance)(c);
    unload(&l);
}

/* Numbers of q, and what contacts exert on bodies. */
static void contacts_run_as_in_process(void **state)
{
    static const char *const names[] = {"dice", "peg", "egg", "pill", "stone", "foot"};
    loaded l;
    double most = 0.0;
    (void)state;
    load(&l, make_heap, 0.0);
    mbsr_simulation *s = &l.model.s;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-9;
    assert_int_equal(mbsr_simulation_start(s, &opt, 0.0, NULL, NULL), MBSR_OK);
    fmi3Instance c = instantiate(&l);
    assert_non_null(c);
    initialize(&l, c);
    const int steps = test_seeds(30, 60);
    for (int k = 0; k < steps; ++k) {
        step(&l, c, 0.01 * k, 0.01);
        assert_int_equal(mbsr_simulation_to(s, 0.01 * (k + 1)), MBSR_OK);
        for (int b = 0; b < 6; ++b) {
            double f[6];
            assert_int_equal(
                mbsr_force_load(s->model, s->data, mbsr_model_forces(s->model) - 1, b + 1, f, NULL),
                MBSR_OK);
            for (int i = 0; i < 6; ++i) {
                char name[80];
                snprintf(name, sizeof name, "contacts.%s.f[%d]", names[b], i + 1);
                assert_true(fabs(get(&l, c, name) - f[i]) < 1e-6 * (1.0 + fabs(f[i])));
            }
            most = fmax(most, fabs(f[5]));
        }
        for (int i = 0; i < 7; ++i) {
            char name[80];
            snprintf(name, sizeof name, "joints.dice.q[%d]", i + 1);
            assert_true(fabs(get(&l, c, name) - s->q[i]) < 1e-8);
        }
    }
    assert_true(most > 20.0); /* more than it weighs */
    FUNCTION(&l, fmi3FreeInstance)(c);
    unload(&l);
}

/* Two pendulums part, and a rank changes: against the form that decides no ranks. */
static void ranks_change_within_a_step(void **state)
{
    static const double q[4] = {0.0, 0.0, 1.0, 1.0}, u[4] = {0.0, 0.0, 2.0, 2.0};
    static const char *const names[] = {"left", "right"};
    loaded l;
    (void)state;
    load(&l, make_twins, 0.0);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = MBSR_DAE_INVERSE_DYNAMICS;
    opt.rtol = opt.atol = 1e-8;
    assert_int_equal(mbsr_simulation_start(&l.model.s, &opt, 0.0, q, u), MBSR_OK);
    fmi3Instance c = instantiate(&l);
    for (int k = 0; k < 2; ++k) {
        char name[40];
        snprintf(name, sizeof name, "joints.%s.q", names[k]);
        const fmi3ValueReference vr[2] = {find(&l, name), find(&l, name) + 4};
        const double start[2] = {q[2 + k], u[2 + k]};
        assert_int_equal(FUNCTION(&l, fmi3SetFloat64)(c, vr, 2, start, 2), fmi3OK);
    }
    initialize(&l, c);
    for (int k = 0; k < 8; ++k) step(&l, c, 0.1 * k, 0.1);
    assert_true(strstr(messages, "ranks change") != NULL);
    assert_int_equal(mbsr_simulation_to(&l.model.s, 0.8), MBSR_OK);
    for (int k = 0; k < 2; ++k) {
        char name[40];
        snprintf(name, sizeof name, "joints.%s.q", names[k]);
        assert_true(fabs(get(&l, c, name) - l.model.s.q[2 + k]) < 1e-4);
    }
    FUNCTION(&l, fmi3FreeInstance)(c);
    unload(&l);
}

/* A wrench that an input holds: what the same force does in process. */
static void inputs_are_held_as_in_process(void **state)
{
    loaded l;
    (void)state;
    load(&l, make_beam, 0.0);
    l.model.motion.value[4] = 3.0; /* not in the FMU, which has its own */
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-9;
    assert_int_equal(mbsr_simulation_start(&l.model.s, &opt, 0.0, NULL, NULL), MBSR_OK);
    fmi3Instance c = instantiate(&l);
    initialize(&l, c);
    const fmi3ValueReference vr = find(&l, "inputs.push[5]");
    const double push = 3.0;
    assert_int_equal(FUNCTION(&l, fmi3SetFloat64)(c, &vr, 1, &push, 1), fmi3OK);
    for (int k = 0; k < 10; ++k) step(&l, c, 0.01 * k, 0.01);
    assert_int_equal(mbsr_simulation_to(&l.model.s, 0.1), MBSR_OK);
    for (int k = 1; k < mbsr_model_nq(l.model.s.model); ++k) {
        char name[80];
        snprintf(name, sizeof name, "joints.beam.q[%d]", k);
        assert_true(fabs(get(&l, c, name) - l.model.s.q[k]) < 1e-6);
    }
    FUNCTION(&l, fmi3FreeInstance)(c);
    unload(&l);
}

/* ---- parameters: those of the library, by the same names ---- */

static void set(const loaded *l, fmi3Instance c, const char *name, double value)
{
    const fmi3ValueReference vr = find(l, name);
    assert_int_equal(FUNCTION(l, fmi3SetFloat64)(c, &vr, 1, &value, 1), fmi3OK);
}

/* All parameters are there; runs with some others are those of the library with these. */
static void compare_parameters(void (*make)(unit_model *m), const char *const *names,
                               const double *values, int count, const char *joint)
{
    loaded l;
    mbsr_parameters *list;
    mbsr_model *changed;
    mbsr_error error;
    int which[4];
    char name[80];
    load(&l, make, 0.0);
    assert_ok(mbsr_parameters_create(l.model.s.model, &list, &error), &error);
    fmi3Instance c = instantiate(&l);
    for (int k = 0; k < mbsr_parameters_count(list); ++k) {
        mbsr_parameter p;
        mbsr_parameter_get(list, k, &p);
        assert_true(get(&l, c, p.name) == p.value);
    }
    for (int k = 0; k < count; ++k) {
        which[k] = mbsr_parameters_find(list, names[k]);
        set(&l, c, names[k], values[k]);
    }
    assert_ok(mbsr_parameters_model(list, count, which, values, &changed, &error), &error);
    initialize(&l, c);
    step(&l, c, 0.0, 0.2);
    mbsr_simulation s = mbsr_simulation_of(changed);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-9;
    assert_int_equal(mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL), MBSR_OK);
    assert_int_equal(mbsr_simulation_to(&s, 0.2), MBSR_OK);
    snprintf(name, sizeof name, "joints.%s.q", joint);
    assert_true(fabs(get(&l, c, name) - s.q[0]) < 1e-7);
    assert_true(fabs(s.q[0]) > 1e-3);
    mbsr_simulation_end(&s);
    FUNCTION(&l, fmi3FreeInstance)(c);
    mbsr_parameters_destroy(list);
    unload(&l);
}

static void parameters_are_those_of_the_library(void **state)
{
    static const char *const of_arm[] = {"bodies.upper.joint_offset[1]", "bodies.upper.com[1]",
                                         "bodies.upper.armature", "forces.spring.rest"},
                             *const of_linkage[] = {"tables.table1.value[2]",
                                                    "bodies.coupler.mass"};
    static const double arm[] = {-0.1, 0.2, 0.05, 0.7}, linkage[] = {0.4, 3.0};
    (void)state;
    compare_parameters(make_arm, of_arm, arm, 4, "upper");
    compare_parameters(make_linkage, of_linkage, linkage, 2, "coupler");
}

/* ---- threads, locale ---- */

typedef struct runner {
    const loaded *l;
    double q;
} runner;

static void *run(void *user)
{
    runner *r = user;
    bool flags[3];
    double last;
    const fmi3ValueReference vr = find(r->l, "joints.upper.q");
    for (int repeat = 0; repeat < 3; ++repeat) {
        fmi3Instance c = FUNCTION(r->l, fmi3InstantiateCoSimulation)(
            "one", r->l->token, r->l->resources, false, false, false, false, NULL, 0, NULL, NULL,
            NULL);
        FUNCTION(r->l, fmi3EnterInitializationMode)(c, false, 0.0, 0.0, false, 0.0);
        FUNCTION(r->l, fmi3ExitInitializationMode)(c);
        for (int k = 0; k < 20; ++k) FUNCTION(r->l, fmi3DoStep)
        (c, 0.01 * k, 0.01, true, flags, flags + 1, flags + 2, &last);
        FUNCTION(r->l, fmi3GetFloat64)(c, &vr, 1, &r->q, 1);
        FUNCTION(r->l, fmi3FreeInstance)(c);
    }
    return NULL;
}

static void instances_run_in_threads(void **state)
{
    loaded l;
    pthread_t thread[4];
    runner r[4];
    (void)state;
    load(&l, make_arm, 0.0);
    for (int k = 0; k < 4; ++k) {
        r[k] = (runner){&l, NAN};
        assert_int_equal(pthread_create(thread + k, NULL, run, r + k), 0);
    }
    for (int k = 0; k < 4; ++k) pthread_join(thread[k], NULL);
    for (int k = 1; k < 4; ++k) assert_true(r[k].q == r[0].q);
    unload(&l);
}

static void locale_stays(void **state)
{
    loaded l;
    (void)state;
    char *before = strdup(setlocale(LC_ALL, NULL));
    load(&l, make_vehicle, 0.0);
    fmi3Instance c = instantiate(&l);
    initialize(&l, c);
    step(&l, c, 0.0, 0.1);
    FUNCTION(&l, fmi3FreeInstance)(c);
    assert_string_equal(setlocale(LC_ALL, NULL), before);
    unload(&l);
    free(before);
}

/* ---- FMI 2.0 from the same shared object ---- */

static void note2(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                  fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)name, (void)status, (void)category, (void)message;
}

static void uris_are_read(void **state)
{
    loaded l;
    char uri[600], here[400];
    (void)state;
    load(&l, make_vehicle, 0.0);
    const fmi2CallbackFunctions functions = {.logger = note2};
    assert_non_null(getcwd(here, sizeof here));
    char escaped[sizeof l.folder * 3];
    static const char *const forms[] = {"file://%s/%s/resources", "file:%s/%s/resources",
                                        "file://localhost%s/%s/resources"},
                             *const wrong[] = {"file:%s/%%zz%s", "file:%s/%%4z%s", "file:%s/%%::%s",
                                               "%s/%%20%s"};
    for (int k = 0; k < 3; ++k) {
        char *to = escaped;
        for (const char *c = l.folder; *c; ++c)
            to += snprintf(to, 4, k < 2 ? "%%%02x" : "%%%02X", (unsigned)*c);
        snprintf(uri, sizeof uri, forms[k], here, escaped);
        fmi2Component c = FUNCTION(&l, fmi2Instantiate)("one", fmi2CoSimulation, l.token, uri,
                                                        &functions, fmi2False, fmi2False);
        assert_non_null(c);
        FUNCTION(&l, fmi2FreeInstance)(c);
    }
    for (int k = 0; k < 4; ++k) {
        snprintf(uri, sizeof uri, wrong[k], here, l.folder);
        assert_null(FUNCTION(&l, fmi2Instantiate)("one", fmi2CoSimulation, l.token, uri, &functions,
                                                  fmi2False, fmi2False));
    }
    unload(&l);
}

/* ---- wrong calls ---- */

/* Where an instance stands before a wrong call; any error terminates it, a reset gets it back. */
enum { FRESH, BEGUN, READY };

static void *stand(const loaded *l, fmi3Instance c, int where)
{
    assert_int_equal(FUNCTION(l, fmi3Reset)(c), fmi3OK);
    if (where >= BEGUN)
        assert_int_equal(FUNCTION(l, fmi3EnterInitializationMode)(c, false, 0.0, 0.0, false, 0.0),
                         fmi3OK);
    if (where >= READY) assert_int_equal(FUNCTION(l, fmi3ExitInitializationMode)(c), fmi3OK);
    messages[0] = '\0';
    return c;
}

/* A call of fmi3name(c, ...) there is an error that says so. */
#define WRONG(where, text, name, ...)                                                              \
    do {                                                                                           \
        stand(&l, c, where);                                                                       \
        assert_int_equal(FUNCTION(&l, name)(c, __VA_ARGS__), fmi3Error);                           \
        assert_contains(messages, text "|" #name);                                                 \
    } while (0)

/* Not made: the message says why. */
#define NOT_MADE(call, text)                                                                       \
    do {                                                                                           \
        messages[0] = '\0';                                                                        \
        assert_null(call);                                                                         \
        assert_contains(messages, text);                                                           \
    } while (0)

static void wrong_values_are_refused(const loaded *with, fmi3Instance c)
{
    const loaded l = *with;
    const fmi3ValueReference q = find(&l, "joints.upper.q"),
                             spring = find(&l, "forces.spring.stiffness"), none = 9999;
    double x = 0.0, odd = NAN;
    WRONG(FRESH, "start time", fmi3EnterInitializationMode, false, 0.0, NAN, false, 0.0);
    WRONG(FRESH, "tolerance", fmi3EnterInitializationMode, true, 1.5, 0.0, false, 0.0);
    WRONG(FRESH, "9999", fmi3GetFloat64, &none, 1, &x, 1);
    WRONG(BEGUN, "numbers of values", fmi3GetFloat64, &q, 1, &x, 2);
    WRONG(BEGUN, "NULL", fmi3GetFloat64, NULL, 1, &x, 1);
    WRONG(BEGUN, "NULL", fmi3GetFloat64, &q, 1, NULL, 1);
    WRONG(BEGUN, "numbers of values", fmi3SetFloat64, &q, 2, &x, 1);
    WRONG(BEGUN, "NULL", fmi3SetFloat64, NULL, 1, &x, 1);
    WRONG(BEGUN, "NULL", fmi3SetFloat64, &q, 1, NULL, 1);
    WRONG(BEGUN, "9999", fmi3SetFloat64, &none, 1, &x, 1);
    WRONG(BEGUN, "nan for joints.upper.q", fmi3SetFloat64, &q, 1, &odd, 1);
    WRONG(READY, "cannot be set now", fmi3SetFloat64, &spring, 1, &x, 1);
    WRONG(READY, "numbers", fmi3GetDirectionalDerivative, &q, 1, &q, 1, &x, 2, &x, 1);
    WRONG(READY, "numbers", fmi3GetDirectionalDerivative, &q, 1, &q, 1, &x, 1, &x, 2);
    WRONG(READY, "NULL", fmi3GetDirectionalDerivative, NULL, 1, &q, 1, &x, 1, &x, 1);
    WRONG(READY, "NULL", fmi3GetDirectionalDerivative, &q, 1, NULL, 1, &x, 1, &x, 1);
    WRONG(READY, "NULL", fmi3GetDirectionalDerivative, &q, 1, &q, 1, NULL, 1, &x, 1);
    WRONG(READY, "numbers", fmi3GetAdjointDerivative, &q, 1, &q, 1, &x, 2, &x, 1);
    WRONG(READY, "numbers", fmi3GetAdjointDerivative, &q, 1, &q, 1, &x, 1, &x, 2);
    WRONG(READY, "NULL", fmi3GetAdjointDerivative, &q, 1, &q, 1, &x, 1, NULL, 1);
}

static void wrong_states_are_refused(const loaded *with, fmi3Instance c)
{
    const loaded l = *with;
    fmi3FMUState saved = NULL;
    size_t size;
    WRONG(FRESH, "NULL", fmi3GetFMUState, NULL);
    WRONG(READY, "NULL", fmi3SetFMUState, NULL);
    WRONG(READY, "NULL", fmi3SerializedFMUStateSize, NULL, &size);
    stand(&l, c, READY);
    assert_int_equal(FUNCTION(&l, fmi3GetFMUState)(c, &saved), fmi3OK);
    WRONG(READY, "NULL", fmi3SerializedFMUStateSize, saved, NULL);
    WRONG(READY, "NULL", fmi3DeserializeFMUState, NULL, 8, &saved);
    stand(&l, c, READY);
    assert_int_equal(FUNCTION(&l, fmi3FreeFMUState)(c, &saved), fmi3OK);
    assert_int_equal(FUNCTION(&l, fmi3FreeFMUState)(c, NULL), fmi3OK);
}

static void wrong_steps_are_refused(void **state)
{
    loaded l;
    bool event, end, early;
    double t;
    (void)state;
    load(&l, make_arm, 0.0);
    assert_string_equal(FUNCTION(&l, fmi3GetVersion)(), "3.0");
    fmi3Instance c = instantiate(&l);
    wrong_values_are_refused(&l, c);
    wrong_states_are_refused(&l, c);
    WRONG(READY, "must be positive", fmi3DoStep, 0.0, -1.0, true, &event, &end, &early, &t);
    WRONG(READY, "must be positive", fmi3DoStep, 0.0, NAN, true, &event, &end, &early, &t);
    WRONG(READY, "point is 5", fmi3DoStep, 5.0, 0.1, true, &event, &end, &early, &t);
    WRONG(READY, "point is nan", fmi3DoStep, NAN, 0.1, true, &event, &end, &early, &t);
    WRONG(READY, "NULL", fmi3DoStep, 0.0, 0.1, true, NULL, &end, &early, &t);
    WRONG(READY, "NULL", fmi3DoStep, 0.0, 0.1, true, &event, NULL, &early, &t);
    WRONG(READY, "NULL", fmi3DoStep, 0.0, 0.1, true, &event, &end, NULL, &t);
    WRONG(READY, "NULL", fmi3DoStep, 0.0, 0.1, true, &event, &end, &early, NULL);
    stand(&l, c, READY);
    assert_int_equal(FUNCTION(&l, fmi3EnterEventMode)(c), fmi3Error);
    assert_contains(messages, "event mode is not used");
    FUNCTION(&l, fmi3FreeInstance)(c);
#define MAKE(name, token, folder)                                                                  \
    FUNCTION(&l, fmi3InstantiateCoSimulation)                                                      \
    (name, token, folder, false, false, false, false, NULL, 0, NULL, note, NULL)
    NOT_MADE(MAKE(NULL, l.token, l.resources), "name");
    NOT_MADE(MAKE("", l.token, l.resources), "name");
    NOT_MADE(MAKE("one", NULL, l.resources), "token");
    NOT_MADE(MAKE("one", l.token, NULL), "resources");
    for (int k = 0; k < 2; ++k)
        NOT_MADE(FUNCTION(&l, fmi3InstantiateScheduledExecution)("one", l.token, l.resources, false,
                                                                 false, NULL, k ? note : NULL, NULL,
                                                                 NULL, NULL),
                 k ? "no scheduled execution" : "");
    unload(&l);
    load(&l, make_vehicle, 1e-3);
    NOT_MADE(FUNCTION(&l, fmi3InstantiateCoSimulation)("one", l.token, l.resources, false, false,
                                                       true, false, NULL, 0, NULL, note, NULL),
             "no event mode");
    unload(&l);
}

static void wrong_exchange_is_refused(void **state)
{
    loaded l;
    bool b[5];
    double t, x[16] = {0.0};
    size_t states, count;
    (void)state;
    load(&l, make_body, 0.0);
    fmi3Instance c = FUNCTION(&l, fmi3InstantiateModelExchange)("one", l.token, l.resources, false,
                                                                false, NULL, note);
    bool *const flag[] = {b, b + 1, b + 2, b + 3, b + 4, NULL};
    for (int k = 0; k < 5; ++k) {
        bool *given[5];
        memcpy(given, flag, sizeof given);
        given[k] = NULL;
        WRONG(READY, "NULL", fmi3UpdateDiscreteStates, given[0], given[1], given[2], given[3],
              given[4], &t);
    }
    WRONG(READY, "NULL", fmi3UpdateDiscreteStates, b, b + 1, b + 2, b + 3, b + 4, NULL);
    WRONG(READY, "NULL", fmi3GetNumberOfContinuousStates, NULL);
    WRONG(READY, "NULL", fmi3GetNumberOfEventIndicators, NULL);
    stand(&l, c, READY);
    assert_int_equal(FUNCTION(&l, fmi3GetNumberOfContinuousStates)(c, &states), fmi3OK);
    assert_int_equal(FUNCTION(&l, fmi3GetNumberOfEventIndicators)(c, &count), fmi3OK);
    assert_true(states > 0 && states < 16);
    for (int k = 0; k < 4; ++k) {
        stand(&l, c, READY);
        assert_int_equal(FUNCTION(&l, fmi3EnterContinuousTimeMode)(c), fmi3OK);
        x[0] = k == 3 ? NAN : 0.0;
        assert_int_equal(k == 0   ? FUNCTION(&l, fmi3CompletedIntegratorStep)(c, true, NULL, b)
                         : k == 1 ? FUNCTION(&l, fmi3CompletedIntegratorStep)(c, true, b, NULL)
                         : k == 2 ? FUNCTION(&l, fmi3SetContinuousStates)(c, x, states + 1)
                                  : FUNCTION(&l, fmi3SetContinuousStates)(c, x, states),
                         fmi3Error);
        assert_contains(messages, k < 2 ? "NULL" : k == 2 ? "3 numbers" : "state 0 is nan");
    }
    FUNCTION(&l, fmi3FreeInstance)(c);
    unload(&l);
}

static char messages2[512];

static void note_words(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                       fmi2String category, fmi2String message, ...)
{
    va_list words;
    (void)environment, (void)name, (void)status, (void)category;
    va_start(words, message);
    vsnprintf(messages2, sizeof messages2, message, words);
    va_end(words);
}

static void wrong_calls_of_fmi2_are_refused(void **state)
{
    loaded l;
    const fmi2CallbackFunctions functions = {.logger = note_words};
    (void)state;
    load_version(&l, make_body, 0.0, 2);
    assert_string_equal(FUNCTION(&l, fmi2GetVersion)(), "2.0");
    assert_string_equal(FUNCTION(&l, fmi2GetTypesPlatform)(), "default");
    const struct {
        const char *name, *guid, *resources, *text;
        int type;
    } bad[] = {{NULL, l.token, l.resources, "name", fmi2CoSimulation},
               {"", l.token, l.resources, "name", fmi2CoSimulation},
               {"one", NULL, l.resources, "GUID", fmi2ModelExchange},
               {"one", l.token, NULL, "resources", fmi2ModelExchange},
               {"one", l.token, l.resources, "type", 7}};
    for (int k = 0; k < 10; ++k) {
        messages2[0] = '\0';
        assert_null(FUNCTION(&l, fmi2Instantiate)(bad[k / 2].name, (fmi2Type)bad[k / 2].type,
                                                  bad[k / 2].guid, bad[k / 2].resources,
                                                  k % 2 ? NULL : &functions, fmi2False, fmi2True));
        assert_contains(messages2, k % 2 ? "" : bad[k / 2].text);
    }
    for (int exchange = 0; exchange < 2; ++exchange) {
        fmi2Component c =
            FUNCTION(&l, fmi2Instantiate)("one", exchange ? fmi2ModelExchange : fmi2CoSimulation,
                                          l.token, l.resources, &functions, fmi2False, fmi2False);
        for (int k = 0; k < 4; ++k) {
            bool refused = false;
            fmi2Boolean enter;
            fmi2EventInfo info;
            assert_int_equal(FUNCTION(&l, fmi2Reset)(c), fmi2OK);
            assert_int_equal(
                FUNCTION(&l, fmi2SetupExperiment)(c, fmi2True, 1e-6, 0.0, fmi2False, 0.0), fmi2OK);
            assert_int_equal(FUNCTION(&l, fmi2EnterInitializationMode)(c), fmi2OK);
            assert_int_equal(FUNCTION(&l, fmi2ExitInitializationMode)(c), fmi2OK);
            if (!exchange) {
                fmi2Status status = fmi2Fatal;
                fmi2Real last = -1.0;
                fmi2Boolean ended = fmi2True;
                assert_int_equal(FUNCTION(&l, fmi2GetStatus)(c, fmi2DoStepStatus, &status), fmi2OK);
                assert_int_equal(status, fmi2OK);
                assert_int_equal(FUNCTION(&l, fmi2GetRealStatus)(c, fmi2LastSuccessfulTime, &last),
                                 fmi2OK);
                assert_true(last == 0.0);
                assert_int_equal(FUNCTION(&l, fmi2GetBooleanStatus)(c, fmi2Terminated, &ended),
                                 fmi2OK);
                assert_int_equal(ended, fmi2False);
                refused =
                    FUNCTION(&l, fmi2GetStatus)(c, fmi2PendingStatus, &status) == fmi2Discard &&
                    FUNCTION(&l, fmi2GetStatus)(c, fmi2DoStepStatus, NULL) == fmi2Discard &&
                    FUNCTION(&l, fmi2GetRealStatus)(c, fmi2Terminated, &last) == fmi2Discard &&
                    FUNCTION(&l, fmi2GetRealStatus)(c, fmi2LastSuccessfulTime, NULL) ==
                        fmi2Discard &&
                    FUNCTION(&l, fmi2GetBooleanStatus)(c, fmi2DoStepStatus, &ended) ==
                        fmi2Discard &&
                    FUNCTION(&l, fmi2GetBooleanStatus)(c, fmi2Terminated, NULL) == fmi2Discard &&
                    FUNCTION(&l, fmi2GetIntegerStatus)(c, fmi2Terminated, NULL) == fmi2Discard &&
                    FUNCTION(&l, fmi2GetStringStatus)(c, fmi2PendingStatus, NULL) == fmi2Discard;
            } else if (k == 0) {
                refused = FUNCTION(&l, fmi2NewDiscreteStates)(c, NULL) == fmi2Error;
            } else {
                assert_int_equal(FUNCTION(&l, fmi2NewDiscreteStates)(c, &info), fmi2OK);
                assert_int_equal(FUNCTION(&l, fmi2EnterContinuousTimeMode)(c), fmi2OK);
                refused = k == 3 ? FUNCTION(&l, fmi2DoStep)(c, 0.0, 0.1, fmi2True) == fmi2Error
                                 : FUNCTION(&l, fmi2CompletedIntegratorStep)(
                                       c, fmi2True, k == 1 ? NULL : &enter,
                                       k == 1 ? &enter : NULL) == fmi2Error;
            }
            if (!refused) fail_msg("%s, call %d", exchange ? "exchange" : "co-simulation", k);
        }
        assert_int_equal(FUNCTION(&l, fmi2FreeFMUstate)(c, NULL), fmi2OK);
        FUNCTION(&l, fmi2FreeInstance)(c);
    }
    unload(&l);
}

/* ---- derivatives ---- */

/* <w, J v> = <J^T w, v> of everything that is told, whichever way it is found. */
static void adjoint_derivatives_are_transposed(void **state)
{
    static const char *const known[] = {"joints.upper.q", "joints.upper.p", "joints.flap.q",
                                        "inputs.motor"},
                             *const unknown[] = {"energy.kinetic", "energy.potential",
                                                 "joints.upper.pdot", "joints.flap.a"};
    static const double x[] = {0.2, -0.4, 0.3, 0.5, 0.7, 0.0};
    enum { KNOWN = 4, UNKNOWN = 4 };
    loaded l;
    (void)state;
    load(&l, make_arm, 0.0);
    fmi3ValueReference in[KNOWN], out[UNKNOWN];
    for (int k = 0; k < KNOWN; ++k) in[k] = find(&l, known[k]);
    for (int k = 0; k < UNKNOWN; ++k) out[k] = find(&l, unknown[k]);
    fmi3Instance c = FUNCTION(&l, fmi3InstantiateModelExchange)("one", l.token, l.resources, false,
                                                                false, NULL, note);
    initialize(&l, c);
    assert_int_equal(FUNCTION(&l, fmi3EnterContinuousTimeMode)(c), fmi3OK);
    assert_int_equal(FUNCTION(&l, fmi3SetContinuousStates)(c, x, 6), fmi3OK);
    const double v[KNOWN] = {0.3, -0.7, 0.2, 0.9}, w[UNKNOWN] = {0.5, -0.4, 1.1, 0.6};
    double Jv[UNKNOWN], JTw[KNOWN], left = 0.0, right = 0.0;
    assert_int_equal(FUNCTION(&l, fmi3GetDirectionalDerivative)(c, out, UNKNOWN, in, KNOWN, v,
                                                                KNOWN, Jv, UNKNOWN),
                     fmi3OK);
    assert_int_equal(
        FUNCTION(&l, fmi3GetAdjointDerivative)(c, out, UNKNOWN, in, KNOWN, w, UNKNOWN, JTw, KNOWN),
        fmi3OK);
    for (int k = 0; k < UNKNOWN; ++k) left += w[k] * Jv[k];
    for (int k = 0; k < KNOWN; ++k) right += v[k] * JTw[k];
    assert_true(fabs(left) > 1e-3);
    if (!(fabs(left - right) < 1e-6 * fabs(left))) fail_msg("%.12g, %.12g", left, right);
    FUNCTION(&l, fmi3FreeInstance)(c);
    unload(&l);
}

/* Differences go by what is much in the model, not by 1 m or 1 kg m/s. */
static void derivatives_of_small_models(void **state)
{
    (void)state;
    const double x[2] = {1e-6, 5e-13}, one = 1.0, l = sqrt(5.0) * 1e-6, u = x[1] / 1e-9,
                 s = sqrt(u * u + 1e-6);
    const struct {
        const char *of, *by;
        double value;
    } wanted[] = {{"energy.potential", "joints.mite.q", (l - 1e-6) * x[0] / l},
                  {"forces.friction.tau[1]", "joints.mite.p", -1e-15 / (s * s * s) / 1e-9},
                  {"energy.kinetic", "bodies.mite.mass", -0.5 * u * u}};
    loaded with;
    load(&with, make_mite, 0.0);
    fmi3Instance c = FUNCTION(&with, fmi3InstantiateModelExchange)(
        "one", with.token, with.resources, false, false, NULL, note);
    initialize(&with, c);
    assert_int_equal(FUNCTION(&with, fmi3EnterContinuousTimeMode)(c), fmi3OK);
    assert_int_equal(FUNCTION(&with, fmi3SetContinuousStates)(c, x, 2), fmi3OK);
    for (int k = 0; k < 3; ++k) {
        const fmi3ValueReference of = find(&with, wanted[k].of), by = find(&with, wanted[k].by);
        double along, against;
        assert_int_equal(
            FUNCTION(&with, fmi3GetDirectionalDerivative)(c, &of, 1, &by, 1, &one, 1, &along, 1),
            fmi3OK);
        assert_int_equal(
            FUNCTION(&with, fmi3GetAdjointDerivative)(c, &of, 1, &by, 1, &one, 1, &against, 1),
            fmi3OK);
        print_message("%s by %s: %.9g, %.9g, exactly %.9g\n", wanted[k].of, wanted[k].by, along,
                      against, wanted[k].value);
        assert_close(along / wanted[k].value, 1.0, 1e-6);
        assert_close(against / wanted[k].value, 1.0, 1e-6);
    }
    FUNCTION(&with, fmi3FreeInstance)(c);
    unload(&with);
}

/* ---- damaged resources ---- */

/* Resources of these bytes, under the token that belongs to them. */
static fmi3Instance try_bytes(const loaded *l, unsigned char *data, size_t size)
{
    char path[128], token[33];
    stamp(data, size, token);
    snprintf(path, sizeof path, "%smodel.mbsrank", l->resources);
    FILE *to = fopen(path, "wb");
    assert_non_null(to);
    assert_int_equal(fwrite(data, 1, size, to), size);
    fclose(to);
    messages[0] = '\0';
    return FUNCTION(l, fmi3InstantiateCoSimulation)("one", token, l->resources, false, true, false,
                                                    false, NULL, 0, NULL, note, NULL);
}

/* Each byte changed, the checksum right: refused with a message, or a model that runs or says why
 * it does not. */
static void damaged_resources_are_refused(void **state)
{
    loaded l;
    char path[128];
    int refused = 0;
    (void)state;
    load(&l, make_linkage, 0.0);
    snprintf(path, sizeof path, "%smodel.mbsrank", l.resources);
    unsigned char *data = (unsigned char *)read_text(path);
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    const size_t size = (size_t)info.st_size;
    for (size_t k = 0; k < size; k += k < 400 ? 1 : 37) {
        const unsigned char was = data[k];
        data[k] = (unsigned char)(k % 3 ? ~was : was + 1);
        fmi3Instance c = try_bytes(&l, data, size);
        data[k] = was;
        refused += !c;
        assert_true(c || messages[0]);
        if (!c) continue;
        FUNCTION(&l, fmi3EnterInitializationMode)(c, false, 0.0, 0.0, false, 0.0);
        FUNCTION(&l, fmi3ExitInitializationMode)(c);
        FUNCTION(&l, fmi3FreeInstance)(c);
    }
    assert_true(refused > 100);
    for (size_t cut = 0; cut < size; cut += 311) assert_null(try_bytes(&l, data, cut));
    free(data);
    unload(&l);
}

/* ---- what is not exported ---- */

static int own_function(void *user, double t, int n, double *value)
{
    (void)user, (void)t;
    for (int k = 0; k < n; ++k) value[k] = 0.0;
    return 0;
}

static void refuse(unit_model *m, const mbsr_fmu_opt *opt, int status, const char *text)
{
    mbsr_fmu *fmu;
    mbsr_error error;
    mbsr_model_finish(m->s.model);
    assert_int_equal(mbsr_fmu_export(m->s.model, opt, &fmu, &error), status);
    assert_null(fmu);
    assert_contains(error.text, text);
}

static int own_motion(void *user, double t, double *x, double *v, double *a)
{
    (void)user;
    *x = t, *v = 1.0, *a = 0.0;
    return 0;
}

static int own_law(void *user, double x, double v, double *force, double *energy, double *power)
{
    (void)user, (void)v;
    *force = x;
    if (energy) *energy = 0.5 * x * x;
    if (power) *power = 0.0;
    return 0;
}

static int own_mass(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    (void)user, (void)t, (void)p, (void)V, (void)h;
    for (int k = 0; k < 6; ++k) M[7 * k] = 1.0;
    return 0;
}

static int own_push(const mbsr_force_args *args)
{
    args->body[0].f[5] += 1.0;
    return 0;
}

static int own_gap(const mbsr_closure_args *args, double *g)
{
    *g = args->body[0].p[MBSR_POSE_X];
    return 0;
}

static int own_root(void *user, double t, double *p, double *V, double *A)
{
    (void)user, (void)V, (void)A;
    for (int k = 0; k < 3; ++k) p[4 * k] = 1.0;
    p[MBSR_POSE_X] = t, V[3] = 1.0;
    return 0;
}

static const mbsr_force_table own_forces = {
    .version = MBSR_FORCE_TABLE_VERSION, .name = "push", .evaluate = own_push};
static const mbsr_closure_table own_gaps = {
    .version = MBSR_CLOSURE_TABLE_VERSION, .name = "gap", .position = own_gap};

enum { OWN_JOINT, OWN_MOTION, OWN_MASS, OWN_TABLE, OWN_LAW, OWN_FORCE, OWN_GAP, FOLLOWS_OWN, OWNS };

/* A vehicle's body with a part by somebody's own function. */
static void make_own(unit_model *m, int own)
{
    static const double up[3] = {0.0, 0.0, 1.0};
    const int bodies[] = {0};
    const mbsr_spring law = {.function = own_law};
    const mbsr_axis driven = {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 0, 1}, .driven = 1};
    const mbsr_joint joint = own == OWN_JOINT ? mbsr_joint_custom(&test_own_table, 1, 1, NULL)
                             : own == OWN_MOTION
                                 ? mbsr_joint_compound(NULL, NULL, 1, &driven, own_motion, NULL)
                                 : mbsr_joint_prismatic(NULL, NULL, up);
    make_body(m);
    if (own <= OWN_MASS)
        mbsr_simulation_add_body(&m->s, "mine", MBSR_GROUND, joint,
                                 own == OWN_MASS    ? mbsr_inertia_function(own_mass, NULL)
                                 : own == OWN_JOINT ? mbsr_inertia_matrix(1, (double[]){1.0})
                                                    : mbsr_inertia_particle(1.0));
    else if (own <= OWN_FORCE) {
        mbsr_force_def force = own == OWN_TABLE ? mbsr_force_custom(&own_forces, 1, bodies, NULL)
                               : own == OWN_LAW ? mbsr_force_spring(0, NULL, MBSR_GROUND, up, &law)
                                                : mbsr_force_joint_applied(0, own_function, NULL);
        force.name = "mine";
        mbsr_simulation_add_force(&m->s, force);
    } else {
        mbsr_closure_def closure = own == OWN_GAP
                                       ? mbsr_closure_custom(&own_gaps, 1, bodies, 1, 1, NULL)
                                       : mbsr_closure_distance(0, NULL, MBSR_GROUND, up, 1.0);
        if (own == FOLLOWS_OWN) closure.motion = own_motion;
        closure.name = "mine";
        mbsr_simulation_add_closure(&m->s, closure);
    }
}

static void own_functions_are_refused(void **state)
{
    static const char *const part[OWNS] = {"body 'mine'|joint is of a table",
                                           "body 'mine'|joint follows",
                                           "body 'mine'|inertia",
                                           "force 'mine'|of a table",
                                           "force 'mine'|law",
                                           "force 'mine'|it is a function",
                                           "closure 'mine'|of a table",
                                           "closure 'mine'|follows"};
    unit_model m;
    (void)state;
    for (int own = 0; own < OWNS; ++own) {
        make_own(&m, own);
        refuse(&m, NULL, MBSR_ERR_VALUE, part[own]);
        mbsr_fmu *fmu;
        assert_int_equal(mbsr_fmu_export(m.s.model, NULL, &fmu, NULL), MBSR_ERR_VALUE);
        free_model(&m);
    }
    mbsr_model_def def = mbsr_default_model_def();
    def.root = mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, own_root, NULL);
    m = (unit_model){.s = mbsr_simulation_begin(&def)};
    refuse(&m, NULL, MBSR_ERR_VALUE, "the root moves by a function");
    free_model(&m);
}

/* Every kind of closure and a lock come back: what does not fit is refused. */
static void stock_closures_are_taken_along(void **state)
{
    static const double along[3] = {1.0, 0.0, 0.0}, up[3] = {0.0, 0.0, 1.0}, one[1] = {1.0};
    const int body[1] = {0}, coordinate[1] = {0};
    const mbsr_closure_def closures[] = {mbsr_closure_distance(1, NULL, MBSR_GROUND, along, 1.0),
                                         mbsr_closure_coupling(1, body, coordinate, one, 0.0),
                                         mbsr_closure_rolling_ball(2, NULL, 0.1, MBSR_GROUND, NULL),
                                         mbsr_closure_rolling_disc(3, NULL, 0.1, MBSR_GROUND, NULL),
                                         mbsr_closure_body_rows(1, NULL, 0, NULL, 1, along),
                                         mbsr_closure_weld(4, NULL, 3, NULL)};
    enum { CLOSURES = sizeof closures / sizeof *closures };
    const double tensor[6] = {1.0, 1.0, 1.0, 0.0, 0.0, 0.0}, none[3] = {0.0}, armature[1] = {0.1};
    unit_model m;
    mbsr_fmu *fmu;
    mbsr_error error;
    char text[40];
    (void)state;
    make_body(&m);
    for (int k = 1; k <= 4; ++k)
        mbsr_simulation_add_body(&m.s, NULL, MBSR_GROUND, mbsr_joint_free(NULL, NULL),
                                 mbsr_inertia_rigid(1.0, none, tensor));
    const int table = mbsr_simulation_add_body(&m.s, "table", MBSR_GROUND,
                                               mbsr_joint_universal(NULL, NULL, along, up),
                                               mbsr_inertia_rigid(1.0, none, tensor));
    assert_ok(mbsr_model_lock(m.s.model, table, 1, 0.3), mbsr_model_error(m.s.model));
    assert_ok(mbsr_model_armature(m.s.model, 0, 1, armature), mbsr_model_error(m.s.model));
    for (int k = 0; k < CLOSURES; ++k) mbsr_simulation_add_closure(&m.s, closures[k]);
    assert_ok(mbsr_model_finish(m.s.model), mbsr_model_error(m.s.model));
    assert_ok(mbsr_fmu_export(m.s.model, NULL, &fmu, &error), &error);
    snprintf(text, sizeof text, "closures (%d)", CLOSURES);
    assert_contains(fmu->text, text);
    mbsr_fmu_destroy(fmu);
    free_model(&m);
}

static void exchange_is_refused_with_the_reason(void **state)
{
    unit_model m;
    mbsr_fmu_opt opt = mbsr_default_fmu_opt();
    opt.kinds = MBSR_FMU_MODEL_EXCHANGE;
    (void)state;
    make_linkage(&m);
    refuse(&m, &opt, MBSR_ERR_VALUE, "closures");
    free_model(&m);
    make_body(&m);
    const int flap = mbsr_simulation_add_body(
        &m.s, "flap", 0, mbsr_joint_revolute(NULL, NULL, (double[3]){1.0, 0.0, 0.0}),
        mbsr_inertia_zero());
    mbsr_simulation_add_force(&m.s, mbsr_force_joint_spring(flap, 0, 5.0, 0.0, 0.1));
    refuse(&m, &opt, MBSR_ERR_VALUE, "springs alone");
    free_model(&m);
}

static void options_are_checked(void **state)
{
    unit_model m;
    mbsr_error error;
    mbsr_fmu *fmu;
    (void)state;
    make_body(&m);
    mbsr_fmu_opt opt = mbsr_default_fmu_opt();
    assert_int_equal(mbsr_fmu_export(m.s.model, &opt, &fmu, &error), MBSR_ERR_UNFINISHED);
    opt.version = 1;
    refuse(&m, &opt, MBSR_ERR_VALUE, "version");
    const mbsr_file_site sites[] = {{"a", MBSR_GROUND, mbsr_frame_identity()},
                                    {"b", 7, mbsr_frame_identity()}};
    const mbsr_file file = {.bodies = 99};
    const mbsr_fmu_opt usual = mbsr_default_fmu_opt();
    mbsr_fmu_opt bad[] = {usual, usual, usual, usual, usual, usual, usual, usual, usual, usual};
    static const struct {
        int status;
        const char *text;
    } why[] = {{MBSR_ERR_VALUE, "kinds"},       {MBSR_ERR_VALUE, "order"},
               {MBSR_ERR_VALUE, "outputs"},     {MBSR_ERR_VALUE, "sites"},
               {MBSR_ERR_NULL, "site is NULL"}, {MBSR_ERR_VALUE, "site 1 is on body 7"},
               {MBSR_ERR_MISMATCH, "file"},     {MBSR_ERR_VALUE, "kinds"},
               {MBSR_ERR_VALUE, "outputs"},     {MBSR_NOT_FINITE, "u0[0] is nan"}};
    bad[0].kinds = 4, bad[1].order = 3, bad[2].outputs = MBSR_FMU_ALL + 1, bad[3].sites = -2;
    bad[4].sites = 1, bad[5].sites = 2, bad[5].site = sites, bad[6].file = &file;
    bad[7].kinds = -1, bad[8].outputs = -1, bad[9].u0 = (double[]){NAN};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k)
        refuse(&m, bad + k, why[k].status, why[k].text);
    opt = mbsr_default_fmu_opt();
    opt.rtol = NAN;
    refuse(&m, &opt, MBSR_ERR_VALUE, "rtol");
    opt = mbsr_default_fmu_opt();
    opt.fixed_step = -1.0;
    refuse(&m, &opt, MBSR_ERR_VALUE, "fixed_step");
    opt = mbsr_default_fmu_opt();
    opt.q0 = (double[]){INFINITY};
    refuse(&m, &opt, MBSR_NOT_FINITE, "q0");
    opt.cookie = 0;
    refuse(&m, &opt, MBSR_ERR_NO_DEFAULT, "mbsr_default_fmu_opt");
    assert_int_equal(mbsr_fmu_export(NULL, NULL, &fmu, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_fmu_export(m.s.model, NULL, NULL, NULL), MBSR_ERR_NULL);
    mbsr_fmu_destroy(NULL);
    free_model(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arm_runs_as_in_process),
        cmocka_unit_test(closed_linkage_runs_as_in_process),
        cmocka_unit_test(vehicle_runs_by_fixed_steps),
        cmocka_unit_test(endless_steps_are_refused),
        cmocka_unit_test(contacts_run_as_in_process),
        cmocka_unit_test(ranks_change_within_a_step),
        cmocka_unit_test(inputs_are_held_as_in_process),
        cmocka_unit_test(parameters_are_those_of_the_library),
        cmocka_unit_test(instances_run_in_threads),
        cmocka_unit_test(locale_stays),
        cmocka_unit_test(uris_are_read),
        cmocka_unit_test(wrong_steps_are_refused),
        cmocka_unit_test(wrong_exchange_is_refused),
        cmocka_unit_test(wrong_calls_of_fmi2_are_refused),
        cmocka_unit_test(adjoint_derivatives_are_transposed),
        cmocka_unit_test(derivatives_of_small_models),
        cmocka_unit_test(damaged_resources_are_refused),
        cmocka_unit_test(own_functions_are_refused),
        cmocka_unit_test(stock_closures_are_taken_along),
        cmocka_unit_test(exchange_is_refused_with_the_reason),
        cmocka_unit_test(options_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

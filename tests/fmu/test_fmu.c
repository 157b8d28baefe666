/* FMUs in an importer in C: against the same run in process, in several threads, on damaged
 * resources.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _XOPEN_SOURCE 700
#include "close.h"
#include "duration.h"
#include "expect.h"
#include "fmu/fmi2_functions.h"
#include "fmu/fmi3_functions.h"
#include "units.h"

#include <dlfcn.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
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
    char escaped[sizeof l.folder * 3], *to = escaped;
    for (const char *c = l.folder; *c; ++c)
        to += snprintf(to, 4, *c == ' ' ? "%%20" : "%c", *c == ' ' ? 0 : *c);
    static const char *const forms[] = {"file://%s/%s/resources", "file:%s/%s/resources",
                                        "file://localhost%s/%s/resources"};
    for (int k = 0; k < 3; ++k) {
        snprintf(uri, sizeof uri, forms[k], here, escaped);
        fmi2Component c = FUNCTION(&l, fmi2Instantiate)("one", fmi2CoSimulation, l.token, uri,
                                                        &functions, fmi2False, fmi2False);
        assert_non_null(c);
        FUNCTION(&l, fmi2FreeInstance)(c);
    }
    unload(&l);
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

static void own_functions_are_refused(void **state)
{
    unit_model m;
    (void)state;
    make_body(&m);
    mbsr_force_def own = mbsr_force_joint_applied(0, own_function, NULL);
    own.name = "mine";
    mbsr_simulation_add_force(&m.s, own);
    refuse(&m, NULL, MBSR_ERR_VALUE, "'mine'|function of your own");
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
        cmocka_unit_test(ranks_change_within_a_step),
        cmocka_unit_test(inputs_are_held_as_in_process),
        cmocka_unit_test(parameters_are_those_of_the_library),
        cmocka_unit_test(instances_run_in_threads),
        cmocka_unit_test(locale_stays),
        cmocka_unit_test(uris_are_read),
        cmocka_unit_test(damaged_resources_are_refused),
        cmocka_unit_test(own_functions_are_refused),
        cmocka_unit_test(exchange_is_refused_with_the_reason),
        cmocka_unit_test(options_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

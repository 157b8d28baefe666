/* Commands of the program mbsrank, where each place of it fails at which a status is taken, a file
 * opened, written or read, or HDF5 asked.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _GNU_SOURCE
#include "faults.h"

#include "program/bytes.h"
#include "program/crew.h"
#include "program/hdf5_texts.h"
#include "program/read_table.h"
#include "program/study_data.h"
#include "program/study_results.h"

#include <fcntl.h>
#include <hdf5.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NUMBERS = 64, WORDS = 24 };

static double out[NUMBERS];

/* What the program and journals ask, and all that functions of the program call, which are linked
 * one file after the other: what steps of solvers do then is of other tests. */
static bool of_the_program(test_faults_list list, const char *caller)
{
    const uintptr_t at = (uintptr_t)caller;
    const bool here = at > (uintptr_t)put_bytes && at < (uintptr_t)run_fmu + 4096;
    return here || (list >= TEST_FAULTS_STUDY && list < TEST_FAULTS_MEMORY);
}

/* A command by its words, and the file that it writes; NULL: none. */
typedef struct command {
    const char *words, *result;
    int (*run)(int argc, char **argv);
} command;

/* ---- what is written ---- */

static int streams[2];

/* Standard output and error go into files, or back. */
static void redirect(bool away)
{
    static const char *const names[2] = {"out", "err"};
    fflush(NULL);
    for (int k = 0; k < 2; ++k) {
        const int to = away ? open(names[k], O_RDWR | O_CREAT | O_TRUNC, 0666) : streams[k];
        if (away) streams[k] = dup(1 + k);
        dup2(to, 1 + k);
        close(to);
    }
}

static void take_file(const char *path, double *to)
{
    uint64_t sum = UINT64_C(14695981039346656037);
    FILE *file = fopen(path, "rb");
    for (int byte; file && (byte = fgetc(file)) != EOF; ++to[2])
        sum = (sum ^ (uint64_t)byte) * UINT64_C(1099511628211);
    if (file) fclose(file);
    to[0] = (double)(sum >> 32), to[1] = (double)(sum & 0xffffffffu);
}

/* How much there is on standard error. */
static off_t said(void)
{
    struct stat s;
    return stat("err", &s) == 0 ? s.st_size : 0;
}

/* Numbers of the first columns of a run, and attributes of it. Where it cannot be read again that
 * is another result. */
static void take_run(const char *path)
{
    static const char *const attributes[] = {"format", "form", "end", "model"};
    table t;
    const int code = table_read(path, &t);
    out[19] = code;
    if (!code) out[20] = t.lines, out[21] = t.columns;
    for (int k = 0; k < 20 && !code && k < t.lines * t.columns; ++k) out[22 + k] = t.value[k];
    table_free(&t);
    if (!strstr(path, ".h5")) return;
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    for (int k = 0; k < 4; ++k) {
        char *text = hdf5_get_text(file, attributes[k]);
        out[50 + k] = text ? (double)strlen(text) : -1.0;
        free(text);
    }
    H5Fclose(file);
}

/* A page without reactions says so. */
static bool is_bare(const char *page)
{
    static char text[1 << 20];
    FILE *file = fopen(page, "rb");
    if (!file) return true;
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    return strstr(text, "\"reactions\": null") != NULL;
}

/* What a command says that does all, and whether its page is bare. */
static off_t usual;
static bool usually_bare;

/* Bytes; of a fit and of HDF5 numbers. */
static int take_results(const command *c)
{
    const bool fitted = c->run == run_fit;
    if (!fitted) take_file("out", out);
    if (fitted || (c->result && c->run == run_run && strstr(c->result, ".h5")))
        take_run(c->result);
    else if (c->result && !strstr(c->result, ".h5"))
        take_file(c->result, out + 4);
    if (c->run != run_view) return DONE;
    if (usual < 0) usually_bare = is_bare(c->result);
    return is_bare(c->result) != usually_bare ? UNDETERMINED : DONE;
}

/* A code, where there is a word of it; UNDETERMINED also where there is one of something else than
 * usually. */
static int act(void *user)
{
    const command *c = user;
    char words[400], *argv[WORDS + 1];
    int argc = 0;
    test_faults_rest(true);
    redirect(true);
    if (c->result) unlink(c->result);
    snprintf(words, sizeof words, "%s", c->words);
    for (char *at = strtok(words, " "); at; at = strtok(NULL, " ")) argv[argc++] = at;
    argv[argc] = NULL;
    test_faults_rest(false);
    int code = c->run(argc, argv);
    test_faults_rest(true);
    redirect(false);
    if (H5Fget_obj_count((hid_t)H5F_OBJ_ALL, H5F_OBJ_ALL) != 0)
        fail_msg("mbsrank %s: HDF5 has something open", c->words);
    if (code && said() == 0) fail_msg("mbsrank %s: ended with %d, not a word", c->words, code);
    if (!code && usual >= 0 && said() != usual) code = UNDETERMINED;
    if (!code) code = take_results(c);
    test_faults_rest(false);
    return code;
}

static long each(const char *name, const command *list, size_t count)
{
    long failed = 0;
    for (size_t k = 0; k < count; ++k) {
        const test_faults_act a = {name, act,     (void *)(uintptr_t)(list + k),
                                   out,  NUMBERS, list[k].run == run_fit ? 1e-3 : 0.0,
                                   1};
        usual = -1;
        if (act(a.user) != DONE) fail_msg("mbsrank %s: is refused", list[k].words);
        usual = said();
        failed += test_faults_each(&a);
        assert_int_equal(act(a.user), DONE); /* its file, for others */
    }
    return failed;
}

#define MODELS TEST_FOLDER "/examples/models/"
#define CAR MODELS "quarter_car.xml"

static void of_models(void **state)
{
    static const command list[] = {
        {CAR " --json", NULL, run_info},
        {"--parameters " MODELS "wiper.sdf", NULL, run_info},
        {CAR " --set bodies.body.mass=300", NULL, run_check},
        {"--json " MODELS "suspension.xml", NULL, run_check},
        {"--small --time 0.01 " CAR, NULL, run_check},
        {MODELS "arm.urdf arm.xml", "arm.xml", run_convert},
        {MODELS "arm.urdf -o arm.fmu --t-end 0.1", NULL, run_fmu},
        {MODELS "arm.urdf -o arm.fmu --sources", NULL, run_fmu},
    };
    (void)state;
    const long failed = each("a command", list, sizeof list / sizeof *list);
    assert_in_range(failed, 20, 100000);
}

static void of_runs(void **state)
{
    static const command list[] = {
        {CAR " --t-end 0.01 --step 0.005 --start pushed --no-contacts -o run.csv", "run.csv",
         run_run},
        {CAR " --t-end 0.03 --step 0.01 --json --output state,energy -o run.h5", "run.h5", run_run},
        {MODELS "gripper.xml --t-end 0.02 --step 0.01 --inputs " MODELS
                "grip.csv --output contacts,hand.pos -o grip.csv",
         "grip.csv", run_run},
        {CAR " run.csv -o view.html", "view.html", run_view},
        {CAR " run.h5 -o view.html", "view.html", run_view},
        {MODELS "gripper.xml --live -o view.html", "view.html", run_view},
        {CAR " --start pushed --data run.csv --set forces.force2.damping=1480 "
             "--vary forces.force2.damping --json -o fit.csv --quiet --no-contacts --rtol 1e-4 "
             "--atol 1e-5",
         "fit.csv", run_fit},
    };
    (void)state;
    const long failed = each("a run", list, sizeof list / sizeof *list);
    assert_in_range(failed, 20, 100000);
}

static void of_linear_equations(void **state)
{
    static const command list[] = {
        {"--trim forces.force1.rest --hold all " CAR, NULL, run_static},
        {"--json " CAR, NULL, run_static},
        {CAR, NULL, run_modes},
        {"--count 2 --json " CAR, NULL, run_modes},
        {"--mode 1 -o mode.csv " CAR, "mode.csv", run_modes},
        {"--inputs tyre --outputs tyre,bodies.body.z --json " CAR, NULL, run_linearise},
        {"--inputs tyre --outputs tyre -o linear.mat " CAR, "linear.mat", run_linearise},
        {"--inputs tyre --outputs tyre -o linear.csv " CAR, "linear.csv", run_linearise},
        {"--inputs tyre --outputs tyre -o linear.h5 " CAR, "linear.h5", run_linearise},
        {"--inputs forces.force1.rest --outputs bodies.body.z --response 0.5:5:3 " CAR, NULL,
         run_linearise},
    };
    (void)state;
    const long failed = each("an analysis", list, sizeof list / sizeof *list);
    assert_in_range(failed, 20, 100000);
}

/* ---- studies ---- */

static long next_run(void *user)
{
    return (*(long *)user)++;
}

static void is_done(void *user)
{
    (void)user;
}

/* All runs in this process, and their results. */
static int do_study(study_work *w, const char *result)
{
    static const long todo[2] = {0, 1};
    const crew all = {.work = w, .folder = "study.runs", .todo = todo, .count = 2, .jobs = 1};
    study_results r = {.work = NULL};
    long next = 0;
    int code = crew_work(&all, 0, next_run, &next, NULL, is_done);
    if (!code) code = results_collect(w, "study.runs", &r);
    if (!code && r.outcomes[MBSR_RUN_DONE] != 2) code = complain(FAILED, "%s", r.text[0]);
    if (!code) code = results_write(&r, result);
    if (!code) code = results_tell(&r, true, stdout);
    results_free(&r);
    return code;
}

/* The numbers, read again. */
static int take_study(const char *result)
{
    study_data d = {.unit = NULL};
    const int code = study_data_read(result, &d);
    for (int k = 0; !code && k < d.t.columns * d.t.lines && k < 30; ++k)
        out[10 + k] = isnan(d.t.value[k]) ? -1.0 : d.t.value[k];
    study_data_free(&d);
    return code;
}

static int run_small_study(int argc, char **argv)
{
    study_work w = {.study = NULL};
    (void)argc;
    unlink("study.runs/0.journal");
    int code = study_open(argv[0], true, &w);
    if (!code) code = do_study(&w, argv[1]);
    study_close(&w);
    test_faults_rest(true);
    if (!code) out[9] = take_study(argv[1]);
    test_faults_rest(false);
    return code;
}

static int read_study(int argc, char **argv)
{
    (void)argc;
    return take_study(argv[0]);
}

static void of_studies(void **state)
{
    static const command list[] = {
        {"small.study study.csv", "study.csv", run_small_study},
        {"study.csv", NULL, read_study},
        {"small.study study.h5", "study.h5", run_small_study},
        {"study.h5", NULL, read_study},
    };
    (void)state;
    FILE *to = fopen("small.study", "w");
    assert_non_null(to);
    fprintf(to,
            "model %s\nrun --t-end 0.004 --no-contacts --start pushed\nsample grid\n"
            "vary bodies.body.mass 250 400 levels 2\nkeep damper max\nkeep damper at 0.002 0.004\n"
            "keep damper.rate falls 0\nkeep body.pos.z mean\n",
            CAR);
    fclose(to);
    const long failed = each("a study", list, sizeof list / sizeof *list);
    assert_in_range(failed, 20, 100000);
}

/* A folder to work in. */
static int enter(void **state)
{
    static char folder[] = "faults_XXXXXX";
    *state = folder;
    test_faults_only(of_the_program);
    if (!mkdtemp(folder) || chdir(folder)) return -1;
    FILE *to = fopen("bundle", "w");
    if (!to) return -1;
    fputs("before<!--data-->after", to);
    return fclose(to) || setenv("MBSRANK_VIEWER", "bundle", 1) ||
           setenv("MBSRANK_LIVE", "bundle", 1);
}

static int leave(void **state)
{
    char words[80];
    snprintf(words, sizeof words, "rm -rf '%s'", (const char *)*state);
    test_faults_only(NULL);
    return chdir("..") || system(words);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_models), cmocka_unit_test(of_runs),
                                       cmocka_unit_test(of_linear_equations),
                                       cmocka_unit_test(of_studies)};
    return cmocka_run_group_tests(tests, enter, leave);
}

/* FMUs of models: see mbsrank/fmu.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/cookie.h"
#include "fmu/binary.h"
#include "fmu/build.h"
#include "fmu/describe.h"
#include "base/error.h"
#include "fmu/names.h"
#include "fmu/sources.h"
#include "fmu/take.h"
#include "fmu/zip.h"

#include <mbsrank/closure.h>
#include <mbsrank/index.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

mbsr_fmu_opt mbsr_default_fmu_opt(void)
{
    return (mbsr_fmu_opt){.cookie = MBSRI_COOKIE,
                          .version = 3,
                          .sites = -1,
                          .rtol = 1e-6,
                          .atol = 1e-6,
                          .order = 2,
                          .outputs = MBSR_FMU_ALL,
                          .stop_time = 1.0,
                          .step_size = 1e-3};
}

/* ---- arguments ---- */

static int wrong_field(mbsr_error *error, const char *field, double value, const char *rule)
{
    return mbsri_fail_plain(error, MBSR_ERR_VALUE, "mbsr_fmu_export: opt.%s is %g, must be %s",
                            field, value, rule);
}

static int check_experiment(const mbsr_fmu_opt *opt, mbsr_error *error)
{
    const struct {
        const char *name;
        double value;
        bool zero; /* may be zero */
    } numbers[] = {{"rtol", opt->rtol, false},
                   {"atol", opt->atol, false},
                   {"fixed_step", opt->fixed_step, true},
                   {"stop_time", opt->stop_time, false},
                   {"step_size", opt->step_size, false}};
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; ++k) {
        const double x = numbers[k].value;
        if (!isfinite(x) || x < 0.0 || (!numbers[k].zero && !(x > 0.0)))
            return wrong_field(error, numbers[k].name, x,
                               numbers[k].zero ? "finite and not negative" : "finite and positive");
    }
    return MBSR_OK;
}

static int check_options(const mbsr_fmu_opt *opt, mbsr_error *error)
{
    if (opt->cookie != MBSRI_COOKIE)
        return mbsri_fail_plain(error, MBSR_ERR_NO_DEFAULT,
                                "mbsr_fmu_export: opt was not made by mbsr_default_fmu_opt");
    if (opt->version != 2 && opt->version != 3)
        return wrong_field(error, "version", opt->version, "2 or 3");
    if (opt->kinds < 0 || opt->kinds > 3) return wrong_field(error, "kinds", opt->kinds, "0 .. 3");
    if (opt->order != 1 && opt->order != 2)
        return wrong_field(error, "order", opt->order, "1 or 2");
    if (opt->outputs < 0 || opt->outputs > MBSR_FMU_ALL)
        return wrong_field(error, "outputs", opt->outputs, "a sum of mbsr_fmu_outputs");
    if (opt->sites < -1) return wrong_field(error, "sites", opt->sites, "-1 or more");
    if (opt->sites > 0 && !opt->site)
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "mbsr_fmu_export: opt.site is NULL");
    return check_experiment(opt, error);
}

static int check_model(const mbsr_model *model, const mbsr_fmu_opt *opt, mbsr_error *error)
{
    const int bodies = mbsr_model_bodies(model);
    if (bodies < 0)
        return mbsri_fail_plain(error, MBSR_ERR_UNFINISHED,
                                "mbsr_fmu_export: the model is not finished");
    if (opt->file && (opt->file->bodies > bodies || opt->file->nu > mbsr_model_nu(model)))
        return mbsri_fail_plain(error, MBSR_ERR_MISMATCH,
                                "mbsr_fmu_export: the model is not that of opt.file");
    return MBSR_OK;
}

/* ---- whether the model has an ODE ---- */

/* Why not, into text of MBSR_TEXT_SIZE; "": it has one. */
static int ask_for_exchange(const mbsr_model *model, const mbsri_unit_plan *plan, char *text,
                            mbsr_error *error)
{
    mbsr_index_report *report = NULL;
    mbsr_data *data = NULL;
    *text = '\0';
    if (mbsr_model_closures(model) > 0) {
        mbsri_print(text, MBSR_TEXT_SIZE,
                    "it has closures (%d), whose loop forces are no states of an ODE",
                    mbsr_model_closures(model));
        return MBSR_OK;
    }
    double *q = calloc((size_t)(plan->nq + plan->nu) + 1, sizeof *q);
    if (!q) return mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "mbsr_fmu_export: no memory");
    for (int k = 0; k < plan->nq; ++k) q[k] = plan->q[k].start;
    for (int k = 0; k < plan->nu; ++k) q[plan->nq + k] = plan->u[k].start;
    int status = mbsr_data_create(model, &data, error);
    if (!status) {
        status = mbsr_index_report_create(model, data, 0.0, q, q + plan->nq, &report);
        if (status && error) *error = *mbsr_data_error(data);
    }
    if (!status && report->undetermined > 0)
        mbsri_print(text, MBSR_TEXT_SIZE, "%d directions without mass are undetermined: %.150s",
                    report->undetermined, report->text);
    else if (!status && report->elastic > 0)
        mbsri_print(text, MBSR_TEXT_SIZE,
                    "%d directions without mass are held by springs alone (index %d), such as "
                    "one of the joint of body %d: dampers there make an ODE",
                    report->elastic, report->index, report->direction->term->body);
    if (!status) mbsr_index_report_destroy(model, report);
    mbsr_data_destroy(data);
    free(q);
    return status;
}

static int choose_kinds(const mbsr_model *model, const mbsr_fmu_opt *opt, mbsri_unit_plan *plan,
                        int *kinds, char *text, mbsr_error *error)
{
    *text = '\0';
    *kinds = opt->kinds ? opt->kinds : MBSR_FMU_CO_SIMULATION | MBSR_FMU_MODEL_EXCHANGE;
    if (*kinds & MBSR_FMU_MODEL_EXCHANGE) {
        const int status = ask_for_exchange(model, plan, text, error);
        if (status) return status;
    }
    if (*text && opt->kinds)
        return mbsri_fail_plain(error, MBSR_ERR_VALUE, "mbsr_fmu_export: no model exchange: %s",
                                text);
    if (*text) *kinds = MBSR_FMU_CO_SIMULATION;
    plan->model_exchange = (*kinds & MBSR_FMU_MODEL_EXCHANGE) != 0;
    return MBSR_OK;
}

/* ---- the archive ---- */

/* The result, with memory of its own. */
typedef struct made_fmu {
    mbsr_fmu fmu;
    mbsri_arena arena;
    char text[MBSR_TEXT_SIZE];
} made_fmu;

static char *print_path(mbsri_arena *arena, const char *folder, const char *name)
{
    const size_t size = strlen(folder) + strlen(name) + 32;
    char *path = mbsri_arena_take(arena, size);
    if (path) mbsri_print(path, size, "binaries/%s/%s%s", folder, name, mbsri_fmu_ending());
    return path;
}

static int zip_parts(made_fmu *made, const mbsri_described *d, const mbsr_fmu_opt *opt,
                     const unsigned char *model, size_t size, mbsr_error *error)
{
    mbsri_text text = {.arena = &made->arena};
    const int first = 3;
    const size_t count = (size_t)(first + d->sources->count);
    mbsri_zip_file *file = mbsri_arena_take(&made->arena, count * sizeof *file);
    const char *platform = mbsri_fmu_platform(opt->version);
    if (!file) return mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "mbsr_fmu_export: no memory");
    file[0] = (mbsri_zip_file){"modelDescription.xml", NULL, 0};
    file[1] = (mbsri_zip_file){"resources/model.mbsrank", model, size};
    file[2].data = mbsri_fmu_binary(&file[2].size);
    for (int k = 0; k < d->sources->count; ++k) file[first + k] = d->sources->file[k];
    if (!platform || !file[2].data)
        return mbsri_fail_plain(error, MBSR_ERR_UNAVAILABLE,
                                "mbsr_fmu_export: the library was built without the shared object "
                                "of FMUs");
    (opt->version == 2 ? mbsri_describe2 : mbsri_describe3)(&text, d);
    file[0].data = (const unsigned char *)text.data;
    file[0].size = text.size;
    file[2].name = print_path(&made->arena, platform, d->identifier);
    if (!made->arena.failed)
        made->fmu.data = mbsri_zip(&made->arena, (int)count, file, &made->fmu.size);
    if (made->arena.failed || !made->fmu.data)
        return mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "mbsr_fmu_export: no memory");
    return MBSR_OK;
}

/* The plan of the model, read back as the FMU will, described and packed. */
static int make_archive(made_fmu *made, const mbsr_model *model, const mbsr_fmu_opt *opt,
                        mbsri_unit_plan *plan, mbsri_unit_plan *back, mbsr_error *error)
{
    char token[MBSRI_TOKEN];
    size_t size;
    mbsri_built built;
    mbsri_variables variables;
    int status = mbsri_plan_take(plan, model, opt, error);
    if (!status) status = choose_kinds(model, opt, plan, &made->fmu.kinds, made->text, error);
    if (status) return status;
    const unsigned char *bytes = mbsri_plan_write(plan, &size);
    if (!bytes) return mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "mbsr_fmu_export: no memory");
    status = mbsri_plan_read(back, bytes, size, error);
    const size_t inputs = (size_t)(plan->inputs + plan->motions) + 1;
    double *input = calloc(inputs, sizeof *input);
    if (!input) status = mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "mbsr_fmu_export: no memory");
    for (int k = 0; k < plan->inputs && input; ++k) input[k] = plan->input[k].start;
    mbsr_error own = {.text = ""};
    if (!status) status = mbsri_build(back, input, input + plan->inputs, &built, &own);
    if (own.text[0] && error) *error = own;
    if (!status) {
        mbsri_plan_token(bytes, size, token);
        mbsri_unit_sources sources = {0, NULL};
        const char *identifier = mbsri_identifier(&made->arena, plan->name);
        const bool there =
            !opt->sources || !identifier ||
            mbsri_list_sources(&sources, &made->arena, opt->version, identifier, bytes, size);
        const mbsri_described d = {.plan = back,
                                   .model = built.model,
                                   .variables = &variables,
                                   .identifier = identifier,
                                   .token = token,
                                   .kinds = made->fmu.kinds,
                                   .stop_time = opt->stop_time,
                                   .step_size = opt->step_size,
                                   .sources = &sources};
        if (!there && !made->arena.failed)
            status = mbsri_fail_plain(error, MBSR_ERR_UNAVAILABLE,
                                      "mbsr_fmu_export: the library was built without the sources "
                                      "of FMUs");
        else if (there && mbsri_list_variables(back, &built, &variables) && d.identifier)
            status = zip_parts(made, &d, opt, bytes, size, error);
        else
            status = mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "mbsr_fmu_export: no memory");
        mbsri_built_destroy(&built);
    }
    free(input);
    return status;
}

int mbsr_fmu_export(const mbsr_model *model, const mbsr_fmu_opt *opt, mbsr_fmu **fmu,
                    mbsr_error *error)
{
    const mbsr_fmu_opt standard = mbsr_default_fmu_opt();
    if (fmu) *fmu = NULL;
    if (!fmu || !model)
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "mbsr_fmu_export: %s is NULL",
                                fmu ? "model" : "fmu");
    if (!opt) opt = &standard;
    int status = check_options(opt, error);
    if (!status) status = check_model(model, opt, error);
    if (status) return status;
    mbsri_arena arena;
    mbsri_unit_plan plan, back;
    mbsri_arena_open(&arena, &opt->allocator);
    made_fmu *made = mbsri_arena_take(&arena, sizeof *made);
    if (!made) {
        mbsri_arena_close(&arena);
        return mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "mbsr_fmu_export: no memory");
    }
    made->arena = arena;
    mbsri_plan_open(&plan, &opt->allocator);
    mbsri_plan_open(&back, &opt->allocator);
    status = make_archive(made, model, opt, &plan, &back, error);
    mbsri_plan_close(&back);
    mbsri_plan_close(&plan);
    made->fmu.text = made->text;
    if (status)
        mbsr_fmu_destroy(&made->fmu);
    else
        *fmu = &made->fmu;
    return status;
}

void mbsr_fmu_destroy(mbsr_fmu *fmu)
{
    if (!fmu) return;
    mbsri_arena arena = ((made_fmu *)fmu)->arena;
    mbsri_arena_close(&arena);
}

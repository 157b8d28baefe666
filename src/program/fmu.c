/* mbsrank fmu: a model from a file as a Functional Mock-up Unit.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/touching.h"

#include <mbsrank/fmu.h>

#include <stdlib.h>
#include <string.h>

typedef struct fmu_options {
    program_options common;
    const char *to, *kind, *name;
    bool sources;
    double version, order, fixed_step, rtol, atol, t_end, step; /* 0: default */
} fmu_options;

static int read_fmu_options(int argc, char **argv, fmu_options *o)
{
    static const char *const names[] = {"--fmi",  "--order", "--fixed-step", "--rtol",
                                        "--atol", "--t-end", "--step"};
    double *const number[] = {&o->version, &o->order, &o->fixed_step, &o->rtol,
                              &o->atol,    &o->t_end, &o->step};
    static const char *const texts[] = {"-o", "--kind", "--name"};
    const char **const text[] = {&o->to, &o->kind, &o->name};
    int code = DONE;
    for (int at = 0; at < argc && !code; ++at) {
        bool taken = strcmp(argv[at], "--sources") == 0;
        o->sources = o->sources || taken;
        for (int k = 0; k < 7 && !taken && at >= 0; ++k) {
            const char *value = option_value(argc, argv, &at, names[k]);
            if (value && !option_number(names[k], value, number[k])) return USAGE;
            taken = value != NULL;
        }
        for (int k = 0; k < 3 && !taken && at >= 0; ++k) {
            const char *value = option_value(argc, argv, &at, texts[k]);
            if (value) *text[k] = value, taken = true;
        }
        if (at < 0) return USAGE;
        if (!taken && !common_option(argc, argv, &at, &o->common, &code))
            return complain(USAGE, "fmu: there is no option %s", argv[at]);
        if (at < 0) return USAGE;
    }
    if (!code && !o->to) return complain(USAGE, "fmu: -o UNIT is missing");
    if (!code && o->common.json) return complain(USAGE, "fmu: there is no option --json");
    return code;
}

static int kinds_of(const char *kind, int *kinds)
{
    static const char *const names[] = {"cs", "me", "both"};
    *kinds = 0;
    for (int k = 0; k < 3 && kind; ++k)
        if (strcmp(kind, names[k]) == 0) *kinds = k + 1;
    if (kind && *kinds == 0)
        return complain(USAGE, "--kind: '%s' is neither cs nor me nor both", kind);
    return DONE;
}

static int write_unit(const char *path, const mbsr_fmu *fmu)
{
    FILE *to = fopen(path, "wb");
    if (!to) return complain_of_file(FAILED, path, "written");
    bool good = fwrite(fmu->data, 1, fmu->size, to) == fmu->size;
    good = fclose(to) == 0 && good;
    return good ? DONE : complain_of_file(FAILED, path, "written");
}

/* "arm" for models/arm.urdf; to be freed. */
static char *stem_of(const char *path)
{
    const char *slash = strrchr(path, '/'), *from = slash ? slash + 1 : path;
    const size_t length = strcspn(from, ".");
    char *stem = calloc(length + 1, 1);
    if (stem) memcpy(stem, from, length);
    return stem;
}

/* Shapes touch as in a run that begins at the unit's start. */
static int make_fmu(const fmu_options *o, program_model *m, touching *contacts)
{
    mbsr_fmu *fmu;
    mbsr_error error = {.text = ""};
    mbsr_fmu_opt opt = mbsr_default_fmu_opt();
    int code = start_state(&o->common, m, &opt.q0, &opt.u0);
    if (!code) code = kinds_of(o->kind, &opt.kinds);
    if (!code) code = touching_put(m, opt.q0, o->common.contacts, false, contacts);
    if (code) return code;
    char *stem = stem_of(o->common.path);
    opt.file = m->file;
    opt.name = o->name ? o->name : *m->file->name ? m->file->name : stem;
    if (o->version > 0.0) opt.version = (int)o->version;
    if (o->order > 0.0) opt.order = (int)o->order;
    if (o->rtol > 0.0) opt.rtol = o->rtol;
    if (o->atol > 0.0) opt.atol = o->atol;
    if (o->t_end > 0.0) opt.stop_time = o->t_end;
    if (o->step > 0.0) opt.step_size = o->step;
    opt.fixed_step = o->fixed_step;
    opt.sources = o->sources;
    if (mbsr_fmu_export(m->model, &opt, &fmu, &error)) {
        free(stem);
        return complain(FAILED, "%s", error.text);
    }
    if (*fmu->text) say(stderr, "mbsrank: co-simulation alone: %s\n", fmu->text);
    code = write_unit(o->to, fmu);
    mbsr_fmu_destroy(fmu);
    free(stem);
    return code;
}

int run_fmu(int argc, char **argv)
{
    fmu_options o = {.common = {.limits = true, .friction = true, .contacts = true}};
    program_model m = {.text = NULL};
    touching contacts = {.contacts = NULL};
    int code = read_fmu_options(argc, argv, &o);
    if (code) return code;
    code = open_model(&o.common, false, &m);
    if (!code) code = make_fmu(&o, &m, &contacts);
    close_model(&m);
    mbsr_model_destroy(contacts.model);
    touching_free(&contacts);
    return code;
}

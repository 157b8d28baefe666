/* Reading a file: see files.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/build.h"
#include "files/writer.h"
#include "files/xacro_expand.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { COOKIE = 0x6d627366 };

mbsr_file_opt mbsr_default_file_opt(void)
{
    return (mbsr_file_opt){.cookie = COOKIE,
                           .gravity = {0.0, 0.0, -9.81},
                           .closures = 1,
                           .actuators = 1,
                           .passive = 1,
                           .model = mbsr_default_model_def()};
}

/* What a public function says; `entry` is its name, NULL where the text is about a file. */
static int fail(mbsr_error *error, int status, const char *entry, const char *text)
{
    if (!error) return status;
    *error = (mbsr_error){.status = status, .body = MBSR_NONE, .force = MBSR_NONE};
    snprintf(error->text, sizeof error->text, "%s%s%s", entry ? entry : "", entry ? ": " : "",
             text);
    return status;
}

static int check_numbers(const mbsr_file_opt *opt, const char *entry, mbsr_error *error)
{
    const double sizes[] = {opt->stop_stiffness, opt->stop_damping, opt->slip};
    static const char *const names[] = {"stop_stiffness", "stop_damping", "slip"};
    char reason[80];
    for (int k = 0; k < 3; ++k) {
        if (isfinite(sizes[k]) && sizes[k] >= 0.0 && isfinite(opt->gravity[k])) continue;
        const bool own = !(isfinite(sizes[k]) && sizes[k] >= 0.0);
        snprintf(reason, sizeof reason, "opt.%s is %g", own ? names[k] : "gravity",
                 own ? sizes[k] : opt->gravity[k]);
        return fail(error, MBSR_ERR_VALUE, entry, reason);
    }
    return MBSR_OK;
}

static int check_lists(const mbsr_file_opt *opt, const char *entry, mbsr_error *error)
{
    const mbsr_xacro_opt *xacro = &opt->xacro;
    if (opt->hull_corners < 0 || (opt->hull_corners > 0 && opt->hull_corners < 4))
        return fail(error, MBSR_ERR_VALUE, entry, "opt.hull_corners is neither 0 nor 4 or more");
    if (opt->packages < 0) return fail(error, MBSR_ERR_VALUE, entry, "opt.packages is negative");
    if (opt->packages > 0 && !opt->package)
        return fail(error, MBSR_ERR_NULL, entry, "opt.package is NULL");
    for (int k = 0; k < opt->packages; ++k) {
        if (!opt->package[k].name || !opt->package[k].folder)
            return fail(error, MBSR_ERR_NULL, entry, "a name or folder in opt.package is NULL");
    }
    if (xacro->arguments < 0)
        return fail(error, MBSR_ERR_VALUE, entry, "opt.xacro.arguments is negative");
    if (xacro->arguments > 0 && !xacro->argument)
        return fail(error, MBSR_ERR_NULL, entry, "opt.xacro.argument is NULL");
    for (int k = 0; k < xacro->arguments; ++k) {
        if (!xacro->argument[k].name || !xacro->argument[k].value)
            return fail(error, MBSR_ERR_NULL, entry,
                        "a name or value in opt.xacro.argument is NULL");
    }
    return MBSR_OK;
}

/* What both entries are given; `to` is where the result goes. */
static int check_entry(const char *text, const mbsr_file_opt *opt, bool to, const char *entry,
                       mbsr_error *error)
{
    if (!to || !text)
        return fail(error, MBSR_ERR_NULL, entry, to ? "text is NULL" : "the result is NULL");
    if (opt->cookie != COOKIE)
        return fail(error, MBSR_ERR_NO_DEFAULT, entry,
                    "the options were not made by mbsr_default_file_opt");
    int status = check_numbers(opt, entry, error);
    if (!status) status = check_lists(opt, entry, error);
    if (status) return status;
    if (opt->format < MBSR_FILE_ANY || opt->format > MBSR_FILE_SDF)
        return fail(error, MBSR_ERR_VALUE, entry, "opt.format is none of the formats");
    return MBSR_OK;
}

static bool read_scene(mbsri_scene *s, mbsri_element *root)
{
    s->format = mbsri_is(root, "robot")    ? MBSR_FILE_URDF
                : mbsri_is(root, "mujoco") ? MBSR_FILE_MJCF
                : mbsri_sdf_is_root(root)  ? MBSR_FILE_SDF
                                           : MBSR_FILE_ANY;
    if (s->format == MBSR_FILE_ANY)
        return mbsri_file_refuse(s, root,
                                 "this is no <robot> of URDF, <mujoco> of MJCF or <sdf> of SDF");
    if (s->opt->format != MBSR_FILE_ANY && s->opt->format != s->format)
        return mbsri_file_refuse(s, root, "the file is not of the format wanted");
    s->home = mbsri_arena_folder(s->arena, root->file);
    if (!s->home) return false;
    if (s->format == MBSR_FILE_SDF) return mbsri_sdf_read(s, root);
    return s->format == MBSR_FILE_URDF ? mbsri_urdf_read(s, root) : mbsri_mjcf_read(s, root);
}

static void hand_over(const mbsri_scene *s, mbsr_file *file)
{
    file->format = s->format;
    file->name = s->name ? s->name : "";
    file->sites = s->sites.count;
    file->site = s->sites.items;
    file->sensors = s->sensors.count;
    file->sensor = s->sensors.items;
    file->shapes = s->shapes.count;
    file->shape = s->shapes.items;
    file->excluded = s->excludes.count;
    file->exclude = s->excludes.items;
    file->pairs = s->pairs.count;
    file->pair = s->pairs.items;
    file->findings = s->findings.count;
    file->finding = s->findings.items;
}

static bool refuse_findings(mbsri_scene *s)
{
    const mbsr_finding *f = s->findings.items;
    if (!s->opt->strict || s->findings.count == 0) return true;
    snprintf(s->message, sizeof s->message,
             "%.60s:%d: %.60s: %.80s (%d such findings, strict mode)", f->file, f->line, f->element,
             f->text, s->findings.count);
    return false;
}

/* Lists that stay empty have a place, too. */
static void open_lists(mbsri_scene *s)
{
    mbsri_list *const lists[] = {
        &s->bodies, &s->joints,   &s->tendons, &s->actuators, &s->equalities, &s->keys, &s->sites,
        &s->shapes, &s->findings, &s->sensors, &s->excludes,  &s->pairs,      &s->hulls};
    void *nothing = mbsri_arena_take(s->arena, 1);
    for (size_t k = 0; k < sizeof lists / sizeof *lists; ++k) lists[k]->items = nothing;
}

static mbsri_scene open_scene(mbsri_arena *arena, const mbsr_file_opt *opt)
{
    mbsri_scene s = {.arena = arena,
                     .opt = opt,
                     .name = "",
                     .with_passive = opt->passive,
                     .with_closures = opt->closures,
                     .with_actuators = opt->actuators,
                     .with_limits = true,
                     .with_friction = true};
    open_lists(&s);
    memcpy(s.gravity, opt->gravity, sizeof s.gravity);
    return s;
}

/* The elements of a text, without xacro; NULL: refused, or no memory. */
static mbsri_element *read_elements(mbsri_scene *s, const char *text, size_t size, const char *name)
{
    if (!name) name = "text";
    const char *file = mbsri_arena_text(s->arena, name, strlen(name));
    mbsri_element *root = file ? mbsri_xml_read(s->arena, text, size, file, s->message) : NULL;
    return root && mbsri_xacro_is(root) ? mbsri_xacro_expand(s, root) : root;
}

/* Why nothing was read. */
static int fail_reading(const mbsri_scene *s, const char *entry, mbsr_error *error)
{
    if (s->arena->failed) return fail(error, MBSR_ERR_NO_MEMORY, entry, "no memory");
    return fail(error, MBSR_ERR_FILE, NULL, s->message[0] ? s->message : "the file is not read");
}

static const char read_entry[] = "mbsr_file_read", expand_entry[] = "mbsr_file_expand_xacro";

static int read(mbsri_file *f, const char *text, size_t size, const char *name,
                const mbsr_file_opt *opt, mbsr_error *error)
{
    mbsri_scene scene = open_scene(&f->arena, opt), *s = &scene;
    mbsri_element *root = read_elements(s, text, size, name);
    bool good = root && read_scene(s, root);
    if (good) {
        const int status = mbsr_model_create(&opt->model, &f->file.model, error);
        if (status) return status;
        good = mbsri_scene_build(s, &f->file, root);
    }
    good = good && !f->arena.failed && refuse_findings(s);
    if (!good) return fail_reading(s, read_entry, error);
    hand_over(s, &f->file);
    return MBSR_OK;
}

int mbsr_file_read(const char *text, size_t size, const char *name, const mbsr_file_opt *opt,
                   mbsr_file **file, mbsr_error *error)
{
    const mbsr_file_opt standard = mbsr_default_file_opt();
    if (!opt) opt = &standard;
    if (file) *file = NULL;
    int status = check_entry(text, opt, file != NULL, read_entry, error);
    if (status) return status;
    mbsri_arena arena;
    mbsri_arena_open(&arena, &opt->model.allocator);
    mbsri_file *f = mbsri_arena_take(&arena, sizeof *f);
    if (!f) return fail(error, MBSR_ERR_NO_MEMORY, read_entry, "no memory");
    f->arena = arena;
    status = read(f, text, size, name, opt, error);
    if (status) {
        mbsr_file_destroy(&f->file);
        return status;
    }
    *file = &f->file;
    return MBSR_OK;
}

/* ---- the text of a file of xacro ---- */

static void write_element(mbsri_text *t, const mbsri_element *e)
{
    mbsri_begin(t, e->name);
    for (const char **a = e->attribute; *a; a += 2) mbsri_set_attribute(t, a[0], a[1]);
    if (!e->child) {
        mbsri_end(t);
        return;
    }
    mbsri_into(t);
    for (const mbsri_element *child = e->child; child; child = child->next) write_element(t, child);
    mbsri_out(t, e->name);
}

static int expand_text(mbsri_file_written *w, const char *text, size_t size, const char *name,
                       const mbsr_file_opt *opt, mbsr_error *error)
{
    mbsri_scene s = open_scene(&w->arena, opt);
    mbsri_text written = {.arena = &w->arena};
    const mbsri_element *root = read_elements(&s, text, size, name);
    if (root) write_element(&written, root);
    if (!root || w->arena.failed || !refuse_findings(&s))
        return fail_reading(&s, expand_entry, error);
    w->written = (mbsr_written){written.data, written.size, s.findings.count, s.findings.items};
    return MBSR_OK;
}

int mbsr_file_expand_xacro(const char *text, size_t size, const char *name,
                           const mbsr_file_opt *opt, mbsr_written **written, mbsr_error *error)
{
    const mbsr_file_opt standard = mbsr_default_file_opt();
    if (!opt) opt = &standard;
    if (written) *written = NULL;
    int status = check_entry(text, opt, written != NULL, expand_entry, error);
    if (status) return status;
    mbsri_arena arena;
    mbsri_arena_open(&arena, &opt->model.allocator);
    mbsri_file_written *w = mbsri_arena_take(&arena, sizeof *w);
    if (!w) return fail(error, MBSR_ERR_NO_MEMORY, expand_entry, "no memory");
    w->arena = arena;
    status = expand_text(w, text, size, name, opt, error);
    if (status)
        mbsr_written_destroy(&w->written);
    else
        *written = &w->written;
    return status;
}

/* ---- what was read ---- */

void mbsr_file_destroy(mbsr_file *file)
{
    if (!file) return;
    mbsr_model_destroy(file->model);
    mbsri_arena arena = ((mbsri_file *)(void *)file)->arena;
    mbsri_arena_close(&arena);
}

mbsr_model *mbsr_file_take_model(mbsr_file *file)
{
    mbsr_model *model = file ? file->model : NULL;
    if (file) file->model = NULL;
    return model;
}

int mbsr_file_find_joint(const mbsr_file *file, const char *name)
{
    for (int k = 0; file && name && k < file->joints; ++k) {
        if (name[0] && strcmp(file->joint[k].name, name) == 0) return k;
    }
    return -1;
}

int mbsr_file_find_site(const mbsr_file *file, const char *name)
{
    for (int k = 0; file && name && k < file->sites; ++k) {
        if (name[0] && strcmp(file->site[k].name, name) == 0) return k;
    }
    return -1;
}

int mbsr_file_find_actuator(const mbsr_file *file, const char *name)
{
    for (int k = 0; file && name && k < file->actuators; ++k) {
        if (name[0] && strcmp(file->actuator[k].name, name) == 0) return k;
    }
    return -1;
}

int mbsr_file_find_sensor(const mbsr_file *file, const char *name)
{
    for (int k = 0; file && name && k < file->sensors; ++k) {
        if (name[0] && strcmp(file->sensor[k].name, name) == 0) return k;
    }
    return -1;
}

int mbsr_file_find_key(const mbsr_file *file, const char *name)
{
    for (int k = 0; file && name && k < file->keys; ++k) {
        if (name[0] && strcmp(file->key[k].name, name) == 0) return k;
    }
    return -1;
}

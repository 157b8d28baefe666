/* The sources that go into a source FMU: see sources.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/sources.h"

#include "files/write_text.h"
#include "fmu/binary.h"
#include "base/error.h"

#include <stdlib.h>
#include <string.h>

static const char folder[] = "sources/";

const char *mbsri_source_name(const mbsri_zip_file *file)
{
    const char *name = file->name + sizeof folder - 1, *dot = strrchr(name, '.');
    return strchr(name, '/') || !dot || strcmp(dot, ".c") != 0 ? NULL : name;
}

static void add_file(mbsri_unit_sources *s, mbsri_arena *arena, const char *name, size_t length,
                     const char *data, size_t size)
{
    char *path = mbsri_arena_take(arena, sizeof folder + length);
    if (!path) return;
    memcpy(path, folder, sizeof folder - 1);
    memcpy(path + sizeof folder - 1, name, length);
    path[sizeof folder - 1 + length] = '\0';
    s->file[s->count++] = (mbsri_zip_file){path, (const unsigned char *)data, size};
}

static void add_text(mbsri_unit_sources *s, const char *name, const mbsri_text *t)
{
    if (t->data) add_file(s, t->arena, name, strlen(name), t->data, t->size);
}

static void put_line(mbsri_text *t, const char *line)
{
    mbsri_put(t, line, strlen(line));
}

/* ---- what depends on the model ---- */

static void add_model(mbsri_unit_sources *s, mbsri_arena *arena, const unsigned char *model,
                      size_t size)
{
    mbsri_text t = {.arena = arena};
    char number[48];
    put_line(&t, "#include \"mbsrank_set.h\"\n\nextern const unsigned char mbsri_model_bytes[];\n"
                 "extern const size_t mbsri_model_size;\n");
    mbsri_print(number, sizeof number, "const size_t mbsri_model_size = %zu;\n", size);
    put_line(&t, number);
    put_line(&t, "const unsigned char mbsri_model_bytes[] = {");
    for (size_t k = 0; k < size; ++k) {
        mbsri_print(number, sizeof number, "%s%d,", k % 24 ? " " : "\n    ", model[k]);
        put_line(&t, number);
    }
    put_line(&t, "\n};\n");
    add_text(s, "model.c", &t);
}

static void add_identifier(mbsri_unit_sources *s, mbsri_arena *arena, int version,
                           const char *identifier)
{
    mbsri_text t = {.arena = arena};
    const char *macro = version == 2 ? "FMI2_FUNCTION_PREFIX" : "FMI3_FUNCTION_PREFIX";
    put_line(&t, "#ifndef ");
    put_line(&t, macro);
    put_line(&t, "\n#define ");
    put_line(&t, macro);
    put_line(&t, " ");
    put_line(&t, identifier);
    put_line(&t, "_\n#endif\n");
    add_text(s, "model_identifier.h", &t);
}

static void add_description(mbsri_unit_sources *s, mbsri_arena *arena, const char *identifier)
{
    mbsri_text t = {.arena = arena};
    put_line(&t, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    mbsri_begin(&t, "fmiBuildDescription");
    mbsri_set_text(&t, "fmiVersion", "3.0");
    mbsri_into(&t);
    mbsri_begin(&t, "BuildConfiguration");
    mbsri_set_text(&t, "modelIdentifier", identifier);
    mbsri_into(&t);
    mbsri_begin(&t, "SourceFileSet");
    mbsri_set_text(&t, "language", "C11");
    mbsri_into(&t);
    for (int k = 0; k < s->count; ++k) {
        const char *name = mbsri_source_name(s->file + k);
        if (!name) continue;
        mbsri_begin(&t, "SourceFile");
        mbsri_set_text(&t, "name", name);
        mbsri_end(&t);
    }
    mbsri_begin(&t, "PreprocessorDefinition");
    mbsri_set_text(&t, "name", "FMI3_OVERRIDE_FUNCTION_PREFIX");
    mbsri_set_text(&t, "value", "");
    mbsri_set_text(&t, "optional", "true");
    mbsri_set_text(&t, "description", "for a shared object: functions by their own names");
    mbsri_end(&t);
    mbsri_out(&t, "SourceFileSet");
    mbsri_out(&t, "BuildConfiguration");
    mbsri_out(&t, "fmiBuildDescription");
    add_text(s, "buildDescription.xml", &t);
}

/* ---- the set ---- */

/* Whether the file is one of the functions of the other version. */
static bool is_of_other(const char *name, int version)
{
    return strncmp(name, version == 2 ? "fmu_fmi3" : "fmu_fmi2", 8) == 0;
}

/* Calls add_file for each file of the set, or counts them where s has no room yet. */
static int pass_set(mbsri_unit_sources *s, mbsri_arena *arena, int version, const char *set,
                    size_t size)
{
    int count = 0;
    for (const char *at = set; at < set + size; ++count) {
        const char *space = memchr(at, ' ', (size_t)(set + size - at));
        char *line;
        const size_t length = (size_t)strtoul(space, &line, 10);
        if (s->file && !is_of_other(at, version))
            add_file(s, arena, at, (size_t)(space - at), line + 1, length);
        at = line + 1 + length + 1;
    }
    return count;
}

bool mbsri_list_sources(mbsri_unit_sources *sources, mbsri_arena *arena, int version,
                        const char *identifier, const unsigned char *model, size_t size)
{
    size_t length;
    const char *set = mbsri_fmu_source_set(&length);
    *sources = (mbsri_unit_sources){0, NULL};
    if (!set) return false;
    const size_t most = (size_t)pass_set(sources, arena, version, set, length) + 3;
    sources->file = mbsri_arena_take(arena, most * sizeof *sources->file);
    if (!sources->file) return true;
    pass_set(sources, arena, version, set, length);
    add_model(sources, arena, model, size);
    add_identifier(sources, arena, version, identifier);
    if (version == 3) add_description(sources, arena, identifier);
    return true;
}

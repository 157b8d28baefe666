/* Whatever bytes the expansion of xacro gets, it expands or refuses them, and what it expands has
 * no xacro left. For libFuzzer (option MBSR_FUZZ); tests/files/test_damaged_xacro.c calls it, too.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fuzz_files.h"

#include <mbsrank/files.h>

#include <stdlib.h>
#include <string.h>

/* The model, a form feed, and a file of YAML; the model includes itself. */
typedef struct given {
    const char *text[2];
    size_t size[2];
} given;

static int load(void *user, const char *path, const char **text, size_t *size)
{
    const given *g = user;
    const int yaml = strstr(path, ".yaml") != NULL;
    if (strstr(path, "missing")) return 1;
    *text = g->text[yaml];
    *size = g->size[yaml];
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static const mbsr_file_package package = {"here", "folder/"};
    static const mbsr_xacro_argument argument = {"given", "0.5"};
    const char *text = (const char *)bytes;
    const uint8_t *mark = size > 0 ? memchr(bytes, '\f', size) : NULL;
    const size_t first = mark ? (size_t)(mark - bytes) : size;
    given g = {{text, mark ? text + first + 1 : ""}, {first, mark ? size - first - 1 : 0}};
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_written *once, *twice;
    mbsr_error error;
    opt.load = load;
    opt.user = &g;
    opt.packages = 1;
    opt.package = &package;
    opt.xacro.arguments = 1;
    opt.xacro.argument = &argument;
    const int status = mbsr_file_expand_xacro(text, first, "a/file.xacro", &opt, &once, &error);
    if (status) {
        if (once || error.status != status || !error.text[0]) abort();
        return 0;
    }
    if (mbsr_file_expand_xacro(once->text, once->size, "plain.xml", &opt, &twice, &error)) abort();
    if (twice->size != once->size || memcmp(twice->text, once->text, once->size) != 0) abort();
    mbsr_written_destroy(twice);
    mbsr_written_destroy(once);
    return 0;
}

/* Small files of xacro in texts, beside other files.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_XACRO_SMALL_H
#define TEST_XACRO_SMALL_H

#include "small.h"

#define XACRO(inside) "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'>" inside "</robot>"

typedef struct other_file {
    const char *path, *text;
} other_file;

/* `user` is a table that ends with a NULL. */
static inline int load_other(void *user, const char *path, const char **text, size_t *size)
{
    for (const other_file *file = user; file && file->path; ++file) {
        if (strcmp(file->path, path) != 0) continue;
        *text = file->text;
        *size = strlen(file->text);
        return 0;
    }
    return 2; /* ENOENT everywhere */
}

static inline mbsr_file_opt with_files(const other_file *files)
{
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.load = load_other;
    opt.user = (void *)files;
    return opt;
}

/* What is between <robot> and </robot>, without white space at the beginning of lines. */
static inline void assert_expands_with(const char *text, const mbsr_file_opt *opt,
                                       const char *expected)
{
    mbsr_written *written;
    mbsr_error error;
    char got[4096], *to = got;
    assert_ok(mbsr_file_expand_xacro(text, strlen(text), "arm/small.xacro", opt, &written, &error),
              &error);
    const char *from = strchr(written->text, '>') + 1;
    assert_true(written->size < sizeof got);
    for (; *from && strncmp(from, "</robot>", 8) != 0; ++from) {
        if (*from == '\n')
            from += strspn(from, "\n ") - 1;
        else
            *to++ = *from;
    }
    *to = '\0';
    assert_string_equal(got, expected);
    mbsr_written_destroy(written);
}

static inline void assert_expands(const char *text, const char *expected)
{
    assert_expands_with(text, NULL, expected);
}

static inline void assert_xacro_refused(const char *text, const mbsr_file_opt *opt,
                                        const char *words)
{
    mbsr_written *written;
    mbsr_error error = {.text = ""};
    const int status =
        mbsr_file_expand_xacro(text, strlen(text), "arm/small.xacro", opt, &written, &error);
    if (status != MBSR_ERR_FILE) print_error("%s\n", text);
    assert_int_equal(status, MBSR_ERR_FILE);
    assert_null(written);
    assert_int_equal(error.status, status);
    assert_contains(error.text, words);
}

#endif

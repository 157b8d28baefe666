/* Small files in texts.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SMALL_H
#define TEST_SMALL_H

#include "expect.h"

#include <mbsrank/files.h>

#include <string.h>

static inline mbsr_file *read_small(const char *text, const mbsr_file_opt *opt)
{
    mbsr_file *file;
    mbsr_error error;
    assert_ok(mbsr_file_read(text, strlen(text), "small.xml", opt, &file, &error), &error);
    return file;
}

/* Refused, with these words in the reason. */
static inline void assert_file_refused(const char *text, const mbsr_file_opt *opt,
                                       const char *words)
{
    mbsr_file *file;
    mbsr_error error = {.text = ""};
    const int status = mbsr_file_read(text, strlen(text), "small.xml", opt, &file, &error);
    if (status != MBSR_ERR_FILE) print_error("%s\n", text);
    assert_int_equal(status, MBSR_ERR_FILE);
    assert_null(file);
    assert_int_equal(error.status, status);
    assert_contains(error.text, words);
}

/* Some finding has these words. */
static inline void assert_found(const mbsr_file *file, const char *element, const char *words)
{
    for (int k = 0; k < file->findings; ++k) {
        if (strcmp(file->finding[k].element, element) != 0) continue;
        assert_contains(file->finding[k].text, words);
        return;
    }
    print_error("nothing is said of %s\n", element);
    fail();
}

#endif

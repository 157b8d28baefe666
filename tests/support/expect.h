/* Checks of refusals: a status together with what its text must contain.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_EXPECT_H
#define TEST_EXPECT_H

#include "close.h"

#include <mbsrank/mbsrank.h>

#include <string.h>

/* Fails unless `text` contains each of the words, which are separated by '|'. */
#define assert_contains(text, words) assert_contains_at((text), (words), __FILE__, __LINE__)

static inline void assert_contains_at(const char *text, const char *words, const char *file,
                                      int line)
{
    while (*words) {
        const size_t length = strcspn(words, "|");
        char word[MBSR_TEXT_SIZE] = "";
        memcpy(word, words, length < sizeof word ? length : sizeof word - 1);
        if (!strstr(text, word)) {
            print_error("the text\n    \"%s\"\ndoes not contain \"%s\"\n", text, word);
            _fail(file, line);
        }
        words += length;
        if (*words) ++words;
    }
}

/* Fails unless `result` is `status`, the error records it with this culprit, and its text contains
 * the words. */
#define assert_refused(result, error, status, body, force, words)                                  \
    assert_refused_at((result), (error), (status), (body), (force), (words), __FILE__, __LINE__)

static inline void assert_refused_at(int result, const mbsr_error *error, int status, int body,
                                     int force, const char *words, const char *file, int line)
{
    if (result != status || error->status != status || error->body != body ||
        error->force != force) {
        print_error("returned %s (%d), recorded %s (%d) body %d force %d, expected %s (%d) body %d "
                    "force %d\n"
                    "    \"%s\"\n",
                    mbsr_status_name(result), result, mbsr_status_name(error->status),
                    error->status, error->body, error->force, mbsr_status_name(status), status,
                    body, force, error->text);
        _fail(file, line);
    }
    assert_contains_at(error->text, words, file, line);
}

/* Fails unless the result is MBSR_OK; shows the text otherwise. */
#define assert_ok(result, error) assert_ok_at((result), (error), __FILE__, __LINE__)

static inline void assert_ok_at(int result, const mbsr_error *error, const char *file, int line)
{
    if (result == MBSR_OK) return;
    print_error("returned %s (%d): %s\n", mbsr_status_name(result), result,
                error ? error->text : "");
    _fail(file, line);
}

#endif

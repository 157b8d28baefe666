/* Damaged files of xacro: cut short, with other bytes, with pieces elsewhere. A smoke run of
 * tests/fuzz.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "damage.h"
#include "expect.h"
#include "fuzz_files.h"
#include "scarce.h"

#include <mbsrank/files.h>

#include <stdio.h>
#include <string.h>

enum { MOST = 1 << 14 };

static size_t read_corpus(uint8_t *to)
{
    FILE *file = fopen(TEST_FOLDER "/tests/fuzz/corpus/small.xacro", "rb");
    assert_non_null(file);
    const size_t size = fread(to, 1, MOST / 2, file);
    fclose(file);
    assert_true(size > 1000);
    return size;
}

static void damaged_files_are_expanded_or_refused(void **state)
{
    static uint8_t good[MOST], bytes[MOST];
    (void)state;
    test_rng rng = test_seed(2);
    const size_t whole = read_corpus(good);
    for (int k = 0; k < 1500; ++k) {
        size_t size = whole;
        memcpy(bytes, good, whole);
        for (size_t l = test_below(&rng, 4) + 1; l > 0; --l)
            size = test_damage(&rng, bytes, size, MOST);
        assert_int_equal(LLVMFuzzerTestOneInput(bytes, size), 0);
    }
}

/* ---- memory ---- */

/* A model, a form feed, and the YAML that it loads. */
static char text[MOST];
static size_t sizes[2];

static int load(void *user, const char *path, const char **part, size_t *size)
{
    (void)user;
    const int yaml = strstr(path, ".yaml") != NULL;
    if (strstr(path, "missing")) return 1;
    *part = yaml ? text + sizes[0] + 1 : text;
    *size = sizes[yaml];
    return 0;
}

static int expands(void *user)
{
    static const mbsr_file_package package = {"here", "folder/"};
    static const mbsr_xacro_argument argument = {"given", "0.5"};
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_written *written;
    mbsr_error *error = user;
    opt.load = load;
    opt.packages = opt.xacro.arguments = 1;
    opt.package = &package;
    opt.xacro.argument = &argument;
    const int status =
        mbsr_file_expand_xacro(text, sizes[0], "a/file.xacro", &opt, &written, error);
    if (!status) mbsr_written_destroy(written);
    return status;
}

/* Each allocation of an expansion fails in turn, those of the XML parser, too. */
static void each_allocation_fails(void **state)
{
    (void)state;
    mbsr_error error;
    const size_t size = read_corpus((uint8_t *)text);
    const char *mark = memchr(text, '\f', size);
    assert_non_null(mark);
    sizes[0] = (size_t)(mark - text);
    sizes[1] = size - sizes[0] - 1;
    assert_ok(expands(&error), &error);
    const long count = test_scarce_each(expands, &error, MBSR_ERR_NO_MEMORY, 1);
    if (count == -2)
        fail_msg("allocation %ld: %ld are left: %s", test_memory.fail_at, test_memory.live,
                 error.text);
    assert_true(count == -1 || count > 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_files_are_expanded_or_refused),
        cmocka_unit_test(each_allocation_fails),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

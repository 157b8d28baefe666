/* Damaged files: cut short, with other bytes, with pieces elsewhere. A smoke run of tests/fuzz.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "damage.h"
#include "duration.h"
#include "fuzz_files.h"
#include "scarce.h"

#include <mbsrank/files.h>
#include <mbsrank/mbsrank.h>

#include <stdio.h>
#include <string.h>

enum { MOST = 1 << 16 };

static size_t read_corpus(const char *name, uint8_t *to)
{
    char path[600];
    snprintf(path, sizeof path, "%s/%s", TEST_FOLDER, name);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(to, 1, MOST / 2, file);
    fclose(file);
    assert_true(size > 100);
    return size;
}

static void damaged_files_are_read_or_refused(void **state)
{
    static const char *const names[] = {
        "tests/fuzz/corpus/small.urdf", "tests/fuzz/corpus/small.xml", "examples/models/arm.urdf",
        "examples/models/quarter_car.xml", "tests/fuzz/corpus/small.sdf"};
    (void)state;
    test_rng rng = test_seed(1);
    uint8_t *good = malloc(MOST), *bytes = malloc(MOST);
    for (int file = 0; file < 5; ++file) {
        const size_t whole = read_corpus(names[file], good);
        for (int k = 0; k < 1200; ++k) {
            size_t size = whole;
            memcpy(bytes, good, whole);
            for (size_t l = test_below(&rng, 4) + 1; l > 0; --l)
                size = test_damage(&rng, bytes, size, MOST);
            assert_int_equal(LLVMFuzzerTestOneInput(bytes, size), 0);
        }
    }
    free(good);
    free(bytes);
}

/* ---- every attribute and text ---- */

static const char *const all[] = {
    "tests/fuzz/corpus/small.urdf",  "tests/fuzz/corpus/small.xml",
    "tests/fuzz/corpus/small.sdf",   "examples/models/arm.urdf",
    "examples/models/marbles.xml",   "examples/models/gripper.xml",
    "examples/models/quadruped.xml", "examples/models/suspension.xml",
    "examples/models/wiper.sdf",     "tests/fuzz/corpus/attributes.xml",
    "tests/fuzz/corpus/elements.sdf"};

enum { FILES = sizeof all / sizeof *all };

/* The text with [from, to) replaced by a word, read. */
static void read_with(const uint8_t *good, size_t size, size_t from, size_t to, const char *word,
                      uint8_t *bytes)
{
    const size_t length = strlen(word);
    memcpy(bytes, good, from);
    memcpy(bytes + from, word, length);
    memcpy(bytes + from + length, good + to, size - to);
    assert_int_equal(LLVMFuzzerTestOneInput(bytes, size - (to - from) + length), 0);
}

/* What stands between quotes, or between > and <, one after the other, becomes something else. */
static void each_value_becomes_another(void **state)
{
    static const char *const words[] = {
        "", "x", "nan", "-1", "0", "1 2 3 4 5 6 7 8 9 10 11 12", "1e300", "2"};
    enum { WORDS = sizeof words / sizeof *words };
    (void)state;
    const int every = test_long() ? 1 : 3;
    uint8_t *good = malloc(MOST), *bytes = malloc(MOST);
    int turn = 0;
    for (int file = 0; file < FILES; ++file) {
        const size_t size = read_corpus(all[file], good);
        for (size_t k = 0; k < size; ++k) {
            const uint8_t end = good[k] == '>' ? '<' : good[k];
            if (end != '"' && end != '\'' && end != '<') continue;
            const uint8_t *to = memchr(good + k + 1, end, size - k - 1);
            if (!to) break;
            const size_t last = (size_t)(to - good);
            for (int l = 0; l < WORDS; ++l)
                if (turn++ % every == 0) read_with(good, size, k + 1, last, words[l], bytes);
            k = end == '<' ? last - 1 : last;
        }
    }
    free(good);
    free(bytes);
}

/* Each element and attribute, by its name, is one that nobody knows. */
static void each_name_is_unknown(void **state)
{
    (void)state;
    const int every = test_long() ? 1 : 3;
    uint8_t *good = malloc(MOST), *bytes = malloc(MOST);
    int turn = 0;
    for (int file = 0; file < FILES; ++file) {
        const size_t size = read_corpus(all[file], good);
        for (size_t k = 1; k < size; ++k) {
            if (good[k] != '=' || turn++ % every != 0) continue;
            size_t from = k;
            while (from > 0 && !strchr(" \t\n<", good[from - 1])) --from;
            read_with(good, size, from, k, "unknown", bytes);
        }
    }
    free(good);
    free(bytes);
}

/* Where the attribute that ends with the = at k begins, and behind its value. */
static bool find_attribute(const uint8_t *good, size_t size, size_t k, size_t *from, size_t *to)
{
    if (good[k] != '=' || k + 1 >= size || !strchr("'\"", good[k + 1])) return false;
    const uint8_t *end = memchr(good + k + 2, good[k + 1], size - k - 2);
    for (*from = k; *from > 0 && !strchr(" \t\n<", good[*from - 1]);) --*from;
    *to = end ? (size_t)(end - good) + 1 : 0;
    return end;
}

/* Each attribute is missing, or has the value of one of the others behind it. */
static void each_attribute_is_missing_or_has_the_value_of_another(void **state)
{
    enum { OTHERS = 40, LONGEST = 256 };
    (void)state;
    const int every = test_long() ? 1 : 11;
    uint8_t *good = malloc(MOST), *bytes = malloc(MOST);
    char value[LONGEST];
    int turn = 0;
    for (int file = 0; file < FILES; ++file) {
        const size_t size = read_corpus(all[file], good);
        for (size_t k = 1; k < size; ++k) {
            size_t from, to, other, behind;
            if (!find_attribute(good, size, k, &from, &to)) continue;
            read_with(good, size, from, to, "", bytes);
            int count = 0;
            for (size_t l = to; l < size && count < OTHERS; ++l) {
                if (!find_attribute(good, size, l, &other, &behind)) continue;
                ++count;
                if (behind - l - 3 >= sizeof value || turn++ % every != 0) continue;
                memcpy(value, good + l + 2, behind - l - 3);
                value[behind - l - 3] = '\0';
                read_with(good, size, k + 2, to - 1, value, bytes);
            }
        }
    }
    free(good);
    free(bytes);
}

/* Each element without children is missing, comes twice, or comes behind the next one too. */
static void each_element_is_missing_or_comes_twice(void **state)
{
    enum { LONGEST = 2048 };
    (void)state;
    uint8_t *good = malloc(MOST), *bytes = malloc(MOST);
    char element[LONGEST];
    for (int file = 0; file < FILES; ++file) {
        const size_t size = read_corpus(all[file], good);
        for (size_t k = 1; k + 1 < size; ++k) {
            if (good[k] != '/' || good[k + 1] != '>') continue;
            size_t from = k;
            while (from > 0 && good[from] != '<') --from;
            const size_t to = k + 2, length = to - from;
            read_with(good, size, from, to, "", bytes);
            if (length >= sizeof element) continue;
            memcpy(element, good + from, length);
            element[length] = '\0';
            read_with(good, size, to, to, element, bytes);
            const uint8_t *next = memchr(good + to, '>', size - to);
            if (next)
                read_with(good, size, (size_t)(next - good) + 1, (size_t)(next - good) + 1, element,
                          bytes);
        }
    }
    free(good);
    free(bytes);
}

/* ---- memory ---- */

typedef struct reading {
    const char *text, *name;
    size_t size;
} reading;

static int part_of(void *user, const char *path, const char **text, size_t *size)
{
    static const char part[] =
        "<mujoco><worldbody><body name='o'><joint/></body></worldbody></mujoco>";
    (void)user;
    (void)path;
    *text = part;
    *size = strlen(part);
    return 0;
}

static int reads(void *user)
{
    const reading *r = user;
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_file *file;
    mbsr_written *written = NULL;
    mbsr_error error;
    opt.load = part_of;
    opt.limits = opt.friction = 1;
    opt.stop_stiffness = 10.0;
    opt.slip = 1e-3;
    int status = mbsr_file_read(r->text, r->size, r->name, &opt, &file, &error);
    if (!status) status = mbsr_model_finish(file->model);
    if (!status) status = mbsr_file_write_mjcf(file->model, file, NULL, &written, &error);
    mbsr_written_destroy(written);
    mbsr_file_destroy(file);
    return status;
}

/* Each allocation of a file that is read fails in turn, those of the XML parser, too. */
static void each_allocation_fails(void **state)
{
    (void)state;
    uint8_t *good = malloc(MOST);
    for (int file = 0; file < FILES; ++file) {
        const reading r = {
            .text = (const char *)good, .name = all[file], .size = read_corpus(all[file], good)};
        if (reads((void *)&r) != MBSR_OK) continue; /* what the corpus has that is refused */
        const long count = test_scarce_each(reads, (void *)&r, MBSR_ERR_NO_MEMORY, 1);
        if (count == -2)
            fail_msg("%s: allocation %ld: %ld are left", all[file], test_memory.fail_at,
                     test_memory.live);
        assert_true(count == -1 || count > 20);
    }
    free(good);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_files_are_read_or_refused),
        cmocka_unit_test(each_value_becomes_another),
        cmocka_unit_test(each_name_is_unknown),
        cmocka_unit_test(each_attribute_is_missing_or_has_the_value_of_another),
        cmocka_unit_test(each_element_is_missing_or_comes_twice),
        cmocka_unit_test(each_allocation_fails),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

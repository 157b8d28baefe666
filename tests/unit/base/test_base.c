/* Status codes, texts and version.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include "algebra/numbers.h"
#include "base/error.h"

#include <stdio.h>

typedef struct entry {
    const char *name;
    int value;
    const char *text;
} entry;

#define ENTRY(name, value, text) {#name, value, text},
static const entry map[] = {MBSR_STATUS_MAP(ENTRY)};
enum { COUNT = sizeof map / sizeof map[0] };

static void every_status_has_its_own_name_text_and_value(void **state)
{
    (void)state;
    for (int k = 0; k < COUNT; ++k) {
        assert_string_equal(mbsr_status_name(map[k].value), map[k].name);
        assert_string_equal(mbsr_status_text(map[k].value), map[k].text);
        for (int l = 0; l < k; ++l) {
            assert_int_not_equal(map[k].value, map[l].value);
            assert_string_not_equal(map[k].name, map[l].name);
            assert_string_not_equal(map[k].text, map[l].text);
        }
    }
}

/* The statuses of the headers, written out: none may be lost or renumbered. */
static void the_map_is_complete_and_its_numbers_are_fixed(void **state)
{
    (void)state;
    static const int value[] = {MBSR_OK,
                                MBSR_SINGULAR_K,
                                MBSR_RANK_DEFICIENT_J,
                                MBSR_NOT_FINITE,
                                MBSR_INDEFINITE_MASS,
                                MBSR_EIGEN_FAILED,
                                MBSR_DEGENERATE_FORCE,
                                MBSR_UNDETERMINED,
                                MBSR_NO_CONVERGENCE,
                                MBSR_EVENT,
                                MBSR_RANK_CHANGED,
                                MBSR_FRAME_TURNED,
                                MBSR_ZERO_QUATERNION,
                                MBSR_SINGULAR_BLOCK,
                                MBSR_LOOP_SINGULAR,
                                MBSR_LOOP_OPEN,
                                MBSR_ERR_NULL,
                                MBSR_ERR_NO_DEFAULT,
                                MBSR_ERR_VALUE,
                                MBSR_ERR_ID,
                                MBSR_ERR_CYCLE,
                                MBSR_ERR_SPACE,
                                MBSR_ERR_FINISHED,
                                MBSR_ERR_UNFINISHED,
                                MBSR_ERR_NO_MEMORY,
                                MBSR_ERR_MEMORY_SIZE,
                                MBSR_ERR_MEMORY_ALIGNMENT,
                                MBSR_ERR_MISMATCH,
                                MBSR_ERR_SEQUENCE,
                                MBSR_ERR_SOLVER,
                                MBSR_ERR_LEAN,
                                MBSR_ERR_CLOSURES,
                                MBSR_ERR_FILE,
                                MBSR_ERR_UNAVAILABLE,
                                MBSR_ERR_NUMERICS};
    assert_int_equal((int)(sizeof value / sizeof value[0]), COUNT);
    assert_int_equal(value[0], 0);
    for (int k = 1; k < COUNT; ++k)
        assert_int_equal(value[k], k < 16 ? 1000 + k : -1000 - (k - 15));
    for (int k = 0; k < COUNT; ++k) assert_int_equal(value[k], map[k].value);
}

/* 0 ok, > 0 recoverable, < 0 fatal; MBSR_ERR_... are the fatal ones. */
static void the_sign_tells_recoverable_from_fatal(void **state)
{
    (void)state;
    for (int k = 0; k < COUNT; ++k) {
        const int fatal = strncmp(map[k].name, "MBSR_ERR_", 9) == 0,
                  fine = strcmp(map[k].name, "MBSR_OK") == 0;
        if (fine) assert_int_equal(map[k].value, 0);
        if (fatal) assert_true(map[k].value < -1000);
        if (!fatal && !fine) assert_true(map[k].value > 1000);
    }
}

static void codes_of_callbacks_have_a_name_and_a_text(void **state)
{
    (void)state;
    static const int codes[] = {1, -1, 17, -7, 1000, -1000, 999999, -999999};
    for (size_t k = 0; k < sizeof codes / sizeof codes[0]; ++k) {
        assert_string_equal(mbsr_status_name(codes[k]), "callback status");
        assert_contains(mbsr_status_text(codes[k]), "callback");
    }
}

static void the_version_text_agrees_with_the_macros(void **state)
{
    (void)state;
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", MBSR_VERSION_MAJOR, MBSR_VERSION_MINOR,
             MBSR_VERSION_PATCH);
    assert_string_equal(mbsr_version(), text);
}

static void a_failure_records_status_culprit_and_text(void **state)
{
    (void)state;
    mbsr_error error;
    assert_int_equal(mbsri_fail(&error, MBSR_ERR_VALUE, 3, MBSR_NONE, "mass is %g", -2.5),
                     MBSR_ERR_VALUE);
    assert_int_equal(error.status, MBSR_ERR_VALUE);
    assert_int_equal(error.body, 3);
    assert_int_equal(error.force, MBSR_NONE);
    assert_string_equal(error.text, "mass is -2.5");
    assert_int_equal(mbsri_fail(NULL, 17, 0, 0, "%s", "dropped"), 17);
}

static void a_long_text_is_cut_short_and_terminated(void **state)
{
    (void)state;
    struct {
        mbsr_error error;
        char guard[16];
    } w;
    memset(&w, 'g', sizeof w);
    mbsri_fail(&w.error, MBSR_ERR_VALUE, 0, 0, "%0400d", 7);
    assert_int_equal(strlen(w.error.text), MBSR_TEXT_SIZE - 1);
    for (size_t k = 0; k < sizeof w.guard; ++k) assert_int_equal(w.guard[k], 'g');
}

static void a_label_names_kind_id_and_name_within_its_buffer(void **state)
{
    (void)state;
    char buffer[MBSRI_LABEL + 8];
    memset(buffer, 'g', sizeof buffer);
    assert_string_equal(mbsri_label(buffer, "body", 3, "rod"), "body 3 'rod'");
    assert_string_equal(mbsri_label(buffer, "force", 12, ""), "force 12");
    assert_string_equal(mbsri_label(buffer, "force", 12, NULL), "force 12");
    char name[300];
    memset(name, 'n', sizeof name);
    name[sizeof name - 1] = '\0';
    assert_int_equal(strlen(mbsri_label(buffer, "body", 3, name)), MBSRI_LABEL - 1);
    assert_int_equal(buffer[MBSRI_LABEL], 'g');
}

static void finite_finds_nan_and_both_infinities_anywhere(void **state)
{
    (void)state;
    double x[5] = {0.0, 1e308, -1e308, 5e-324, -0.0};
    assert_true(mbsri_finite(5, x));
    assert_true(mbsri_finite(0, NULL));
    for (int k = 0; k < 5; ++k) {
        const double held = x[k];
        for (int bad = 0; bad < 3; ++bad) {
            x[k] = bad == 0 ? NAN : bad == 1 ? INFINITY : -INFINITY;
            assert_false(mbsri_finite(5, x));
        }
        x[k] = held;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_status_has_its_own_name_text_and_value),
        cmocka_unit_test(the_map_is_complete_and_its_numbers_are_fixed),
        cmocka_unit_test(the_sign_tells_recoverable_from_fatal),
        cmocka_unit_test(codes_of_callbacks_have_a_name_and_a_text),
        cmocka_unit_test(the_version_text_agrees_with_the_macros),
        cmocka_unit_test(a_failure_records_status_culprit_and_text),
        cmocka_unit_test(a_long_text_is_cut_short_and_terminated),
        cmocka_unit_test(a_label_names_kind_id_and_name_within_its_buffer),
        cmocka_unit_test(finite_finds_nan_and_both_infinities_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

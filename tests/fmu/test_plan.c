/* The bytes of a model in an FMU, where a number is another one: refused, or read as what is
 * written and read alike.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/plan.h"
#include "fmu/take.h"

#include "duration.h"
#include "expect.h"
#include "units.h"

#include <mbsrank/fmu.h>

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const mbsr_allocator standard = {NULL, NULL, NULL};

/* Reads and writes: the bytes that are written, to be freed; NULL where they are refused. */
static unsigned char *again(const unsigned char *bytes, size_t size, size_t *length)
{
    mbsri_unit_plan plan;
    mbsr_error error = {.text = ""};
    unsigned char *copy = NULL;
    mbsri_plan_open(&plan, &standard);
    const int status = mbsri_plan_read(&plan, bytes, size, &error);
    if (!status) {
        const unsigned char *written = mbsri_plan_write(&plan, length);
        assert_non_null(written);
        copy = malloc(*length);
        memcpy(copy, written, *length);
    } else {
        assert_int_equal(error.status, status);
        assert_true(error.text[0]);
    }
    mbsri_plan_close(&plan);
    return copy;
}

/* 1 where the bytes are refused; what is read instead is written and read as the same. */
static int refused(const unsigned char *bytes, size_t size)
{
    size_t length = 0, same = 0;
    unsigned char *first = again(bytes, size, &length);
    if (!first) return 1;
    unsigned char *second = again(first, length, &same);
    assert_non_null(second);
    assert_true(same == length && memcmp(first, second, same) == 0);
    free(first);
    free(second);
    return 0;
}

static void damaged_models_are_refused_or_read_as_they_stand(void **state)
{
    static void (*const make[])(unit_model * m) = {make_linkage, make_beam,  make_vehicle,
                                                   make_wheel,   make_balls, make_heap};
    static const uint32_t number[] = {0xffffffff, 0x00100000, 3, 0x7ff80000};
    const size_t work = (size_t)(test_long() ? 100000000 : test_seeds(400000, 800000));
    (void)state;
    for (size_t model = 0; model < sizeof make / sizeof *make; ++model) {
        unit_model m;
        mbsri_unit_plan plan;
        mbsr_error error;
        size_t size;
        long count = 0, all = 0;
        char token[33];
        make[model](&m);
        const mbsr_fmu_opt opt = mbsr_default_fmu_opt();
        assert_ok(mbsr_model_finish(m.s.model), mbsr_model_error(m.s.model));
        mbsri_plan_open(&plan, &standard);
        assert_ok(mbsri_plan_take(&plan, m.s.model, &opt, &error), &error);
        const unsigned char *bytes = mbsri_plan_write(&plan, &size);
        assert_non_null(bytes);
        assert_int_equal(refused(bytes, size), 0);
        const size_t step = size * size / work + 1;
        unsigned char *changed = malloc(size);
        for (size_t k = 0; k < sizeof number / sizeof *number; ++k) {
            for (size_t at = k % step; at + 4 <= size; at += step, ++all) {
                memcpy(changed, bytes, size);
                for (size_t l = 0; l < 4; ++l)
                    changed[at + l] = (unsigned char)(number[k] >> 8 * l);
                stamp(changed, size, token);
                count += refused(changed, size);
            }
        }
        for (size_t less = 0; less < size; less += size / 20 + 1, ++all)
            count += refused(bytes, less); /* it ends too early */
        assert_true(count > all / 20 && count < all);
        free(changed);
        mbsri_plan_close(&plan);
        free_model(&m);
    }
}

static void rates_have_places_and_units(void **state)
{
    unit_model m;
    mbsri_unit_plan plan;
    mbsr_error error;
    (void)state;
    make_arm(&m);
    const mbsr_fmu_opt opt = mbsr_default_fmu_opt();
    assert_ok(mbsr_model_finish(m.s.model), mbsr_model_error(m.s.model));
    mbsri_plan_open(&plan, &standard);
    assert_ok(mbsri_plan_take(&plan, m.s.model, &opt, &error), &error);
    assert_int_equal(mbsri_plan_rate(&plan, 1, 0), 1);
    assert_int_equal(mbsri_plan_rate(&plan, 1, 1), -1);
    assert_int_equal(mbsri_plan_rate(&plan, 1, -1), -1);
    assert_int_equal(mbsri_plan_rate(&plan, -1, 0), -1);
    assert_int_equal(mbsri_plan_rate(&plan, plan.bodies, 0), -1);
    assert_string_equal(mbsri_plan_effort(&plan, 0), "N.m");
    assert_string_equal(mbsri_plan_effort(&plan, -1), "");
    assert_string_equal(mbsri_plan_effort(&plan, plan.nu), "");
    mbsri_plan_close(&plan);
    free_model(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_models_are_refused_or_read_as_they_stand),
        cmocka_unit_test(rates_have_places_and_units)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Whatever bytes a study file has, it is read or refused with a text, and every run that is read
 * has finite values. For libFuzzer (option MBSR_FUZZ); tests/study/test_damaged_study.c calls it,
 * too.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fuzz_files.h"

#include <mbsrank/study.h>

#include <math.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    mbsr_study *s;
    mbsr_error error;
    const int status = mbsr_study_read((const char *)bytes, size, "a.study", NULL, &s, &error);
    if (status) {
        if (s || error.status != status || !error.text[0]) abort();
        return 0;
    }
    double *value = calloc((size_t)s->parameters, sizeof *value);
    const long runs[] = {0, s->runs / 2, s->runs - 1};
    for (int k = 0; k < 3; ++k) {
        if (!value || mbsr_study_values(s, runs[k], value)) abort();
        for (int l = 0; l < s->parameters; ++l)
            if (isnan(value[l])) abort();
    }
    free(value);
    mbsr_study_destroy(s);
    return 0;
}

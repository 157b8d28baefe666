/* Whatever bytes the readers of the component fe get, they read or refuse them, and what is read
 * can be reduced or is refused. For libFuzzer (option MBSR_FUZZ); tests/fe/test_damaged_models.c
 * calls it, too. The first byte says as which of the files the others are taken.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fuzz_fe.h"

#include "small_sid.h"

#include <mbsrank/fe.h>
#include <mbsrank/sid.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A rod of springs between two nodes: six times k (u_2 - u_1), with levers where it turns. */
const char *const fuzz_fe_text[FUZZ_FE_TEXTS] = {
    "%%MatrixMarket matrix coordinate real symmetric\n% stretch, bending both ways, torsion\n"
    "12 12 24\n"
    "1 1 5e1\n7 1 -5e1\n7 7 5e1\n4 4 2.0\n10 4 -2.0\n10 10 2\n"
    "2 2 12\n6 2 6\n8 2 -12\n12 2 6\n6 6 4\n8 6 -6\n12 6 2\n8 8 12\n12 8 -6\n12 12 4\n"
    "3 3 12\n5 3 -6\n9 3 -12\n11 3 -6\n5 5 4\n9 5 6\n11 5 2\n9 9 12.0\n",
    "%%MatrixMarket matrix coordinate real general\n12 12 6\n"
    "1 1 0.5\n2 2 0.5\n3 3 .5\n7 7 0.5\n8 8 0.5\n9 9 0.5\n",
    "%%MatrixMarket matrix coordinate real symmetric\n12 12 3\n"
    "1 1 0.5\n7 1 -0.5\n7 7 0.5\n",
    "# id x y z\n1 0 0 0\n2, 1.0, 0.0, 0.0\n",
    "1 1\n1 2\n1 3\n1.4\n1.5\n1.6\n2 1\n2 2\n2 3\n2 4\n2 5\n2 6\n",
    "# the root first\nroot node 1\ntip node 2\n",
    test_small_sid};

static void reduce(mbsr_fe_input *input)
{
    mbsr_flex *flex;
    mbsr_fe_report *report;
    mbsr_error error;
    mbsr_flex_def data;
    if (input->def.nodes > 100) return;
    input->def.modes = 2;
    const int status = mbsr_fe_reduce(&input->def, &flex, &report, &error);
    if (status) {
        if (flex || report || error.status != status || !error.text[0]) abort();
        return;
    }
    if (mbsr_flex_definition(flex, &data) || !isfinite(data.mass) || !report->text[0]) abort();
    for (int k = 0; k < data.modes * data.modes; ++k) {
        if (!isfinite(data.K[k]) || !isfinite(data.Mf[k])) abort();
    }
    mbsr_fe_report_destroy(report);
    mbsr_flex_destroy(flex);
}

/* As far as may be changed. */
static void read_sid(const char *text, size_t size)
{
    mbsr_sid_opt opt = mbsr_default_sid_opt();
    mbsr_flex *flex;
    mbsr_sid_report *report;
    mbsr_sid_text *again;
    mbsr_error error;
    mbsr_flex_def data;
    opt.change = MBSR_SID_COUPLING;
    const int status = mbsr_sid_read(text, size, "damaged", &opt, &flex, &report, &error);
    if (status) {
        if (flex || report || error.status != status || !error.text[0]) abort();
        return;
    }
    if (mbsr_flex_definition(flex, &data) || !isfinite(data.mass) || !report->text[0]) abort();
    for (int k = 0; k < 9 * data.modes * data.modes; ++k) {
        if (!isfinite(data.P[k])) abort();
    }
    if (mbsr_sid_write(flex, "a", NULL, &again, &error)) abort();
    mbsr_sid_text_destroy(again);
    mbsr_sid_report_destroy(report);
    mbsr_flex_destroy(flex);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    enum { SID = FUZZ_FE_TEXTS - 1 };
    mbsr_fe_text text[FUZZ_FE_TEXTS];
    mbsr_fe_input *input;
    mbsr_error error;
    if (size == 0) return 0;
    if (bytes[0] % FUZZ_FE_TEXTS == SID) {
        read_sid((const char *)bytes + 1, size - 1);
        return 0;
    }
    for (int k = 0; k < FUZZ_FE_TEXTS; ++k)
        text[k] = (mbsr_fe_text){.text = fuzz_fe_text[k], .size = strlen(fuzz_fe_text[k])};
    text[bytes[0] % FUZZ_FE_TEXTS] =
        (mbsr_fe_text){.text = (const char *)bytes + 1, .size = size - 1, .name = "damaged"};
    const mbsr_fe_files files = {text[0], text[1], text[2], text[3], text[4], text[5]};
    const int status = mbsr_fe_read(&files, NULL, &input, &error);
    if (status) {
        if (input || error.status != status || !error.text[0]) abort();
        return 0;
    }
    reduce(input);
    mbsr_fe_input_destroy(input);
    return 0;
}

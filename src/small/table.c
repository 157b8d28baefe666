/* One line a mass.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small/table.h"

#include "base/error.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { LINE = 256, NAME = 20 };

size_t mbsri_small_text_size(const mbsr_small_masses *s)
{
    return (size_t)(s->candidates + 4) * LINE;
}

/* Whether another body has the name. */
static bool is_shared(const mbsr_model *m, int body, const char *name)
{
    bool shared = false;
    for (int id = 0; id < mbsr_model_bodies(m) && !shared; ++id)
        shared = id != body && strcmp(mbsr_body_name(m, id), name) == 0;
    return shared;
}

/* Names that several bodies have are followed by the id. */
static const char *name_of(const mbsr_model *m, int body, char buffer[NAME + 16])
{
    const char *name = mbsr_body_name(m, body);
    char id[16];
    const int digits = snprintf(id, sizeof id, " #%d", body);
    if (name && name[0] && is_shared(m, body, name))
        snprintf(buffer, NAME + 1, "%.*s%s", NAME - digits, name, id);
    else if (name && name[0])
        snprintf(buffer, NAME + 1, "%s", name);
    else
        snprintf(buffer, NAME + 1, "body %d", body);
    return buffer;
}

/* "flange               moment u0      ": widths of columns of words are set here, as mbsri_print
 * knows none. */
static void words(const mbsr_small_masses *s, const mbsr_small_mass *x, char *text, size_t size)
{
    static const char *const parts[] = {"", "mass", "moment", "both"};
    char name[NAME + 16], rate[NAME + 32] = "-", carrier[NAME + 16];
    if (x->direction != MBSR_NONE) {
        const mbsr_small_direction *y = s->direction + x->direction;
        const int length = snprintf(rate, sizeof rate, "u%d", y->coordinate);
        if (y->body != x->body && length > 0)
            snprintf(rate + length, sizeof rate - (size_t)length, " of %s",
                     name_of(s->given, y->body, carrier));
    }
    snprintf(text, size, "%-20s %-6s %-8s", name_of(s->given, x->body, name), parts[x->parts & 3],
             rate);
}

static int line(const mbsr_small_masses *s, const mbsr_small_mass *x, char *text, size_t size)
{
    const mbsr_small_direction none = {0};
    const mbsr_small_direction *y = x->direction == MBSR_NONE ? &none : s->direction + x->direction;
    char first[3 * NAME + 16];
    words(s, x, first, sizeof first);
    return mbsri_print(text, size, "%s %9.2e %9.2e %9.2e %9.2e %9.2e %9.2e %7.0f  %s\n", first,
                       y->frequency, y->damping_ratio, y->fastness, x->error, x->share,
                       x->amplitude, x->steps, mbsr_small_verdict_text(x->verdict));
}

void mbsri_small_write(mbsr_small_masses *s, const mbsr_small_masses_report *report)
{
    size_t used = 0;
    int length = snprintf(s->report.text, s->report.text_size,
                          "%-20s %-6s %-8s %9s %9s %9s %9s %9s %9s %7s\n", "body", "parts", "rate",
                          "rad/s", "damping", "fastness", "error", "/ allowed", "swing", "steps");
    used += length > 0 ? (size_t)length : 0;
    for (int k = 0; k < s->candidates; ++k) {
        length = line(s, s->report.mass + k, s->report.text + used, s->report.text_size - used);
        if (length > 0) used += (size_t)length;
    }
    mbsri_print(
        s->report.text + used, s->report.text_size - used,
        "all zeros together: error %.2e, %.2e of what is allowed, at t = %g; swings that are "
        "lost: up to %.2e of it\n",
        report->error, report->share, report->time, report->amplitude);
}

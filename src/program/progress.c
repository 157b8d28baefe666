/* How far a long computation is: see progress.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 200809L
#include "program/progress.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

progress progress_begin(const char *what, double whole, bool quiet)
{
    const double begin = now();
    return (progress){.what = what,
                      .whole = whole,
                      .wanted = !quiet && isatty(2),
                      .begin = begin,
                      .latest = begin + 0.4};
}

void progress_show(progress *p, double done)
{
    if (!p->wanted) return;
    const double time = now(), taken = time - p->begin, part = done / p->whole;
    if (time - p->latest < 0.1) return;
    fprintf(stderr, "\r%s: %3.0f %%, %.0f s left\033[K", p->what, 100.0 * part,
            part > 0.0 ? taken * (1.0 - part) / part : 0.0);
    fflush(stderr);
    p->latest = time;
    p->shown = true;
}

void progress_end(progress *p)
{
    if (p->shown) fputs("\r\033[K", stderr);
    p->shown = false;
}

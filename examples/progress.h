/* How far a long run is, for whoever sits at a terminal; nothing in a file or a pipe.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef EXAMPLES_PROGRESS_H
#define EXAMPLES_PROGRESS_H

#include <stdio.h>

#ifdef _WIN32
#include <io.h>
#define isatty _isatty
#else
#include <unistd.h>
#endif

/* done: 0 to 1. The next line, this one or one of the results, goes over it. */
static inline void show_progress(double done)
{
    static int shown = -1;
    const int percent = (int)(100.0 * done);
    if (percent == shown || !isatty(2)) return;
    shown = percent;
    if (percent < 100)
        fprintf(stderr, "%3d %%\r", percent);
    else
        fprintf(stderr, "     \r");
}

#endif

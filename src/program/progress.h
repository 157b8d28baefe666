/* How far a long computation is: a line on standard error where that is a terminal, and nothing
 * elsewhere.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_PROGRESS_H
#define MBSRANK_PROGRESS_H

#include <stdbool.h>

typedef struct progress {
    const char *what;     /* is being done */
    double whole;         /* when it is done */
    bool wanted, shown;   /* there is a terminal; the line stands there */
    double begin, latest; /* when it began and was shown, s */
} progress;

progress progress_begin(const char *what, double whole, bool quiet);

/* `done` of `whole`. Ten times a second at most, and not in the first half of a second. */
void progress_show(progress *p, double done);

/* Takes the line away. */
void progress_end(progress *p);

#endif

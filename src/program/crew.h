/* Processes that do the runs of a study.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_CREW_H
#define MBSRANK_CREW_H

#include "program/study_run.h"

/* What the study is done with. */
typedef struct crew {
    study_work *work;
    const char *folder; /* of journals */
    const long *todo;   /* runs that are to be done */
    long count;
    int jobs; /* processes */
    bool quiet;
} crew;

/* SIGINT and SIGTERM from now on end a study after the runs at hand. */
void crew_catch_signals(void);
bool crew_interrupted(void);

/* Hands out a number: the place in `todo` of the run that is next; from `count` on there is none.
 */
typedef long (*crew_hand_out)(void *user);

/* Does runs as they are handed out, into the journal of that number, until there are none, or it is
 * interrupted. `doing` (may be NULL) gets the place of the run at hand; `done` is called after
 * each. A code after a complaint. */
int crew_work(const crew *c, int journal, crew_hand_out next, void *user, volatile long *doing,
              void (*done)(void *user));

/* All of it in `jobs` processes of this machine, which share a counter. What a process was doing
 * that crashed is recorded, and another one takes its place. A code. */
int crew_run(const crew *c);

#endif

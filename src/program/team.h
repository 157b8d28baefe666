/* Processes on several machines, by MPI: what mpirun has started.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_TEAM_H
#define MBSRANK_TEAM_H

#include "program/crew.h"

/* One of the processes that mpirun has started; alone without. */
typedef struct team {
    int rank, size; /* 0 hands out runs, the others do them */
} team;

/* A code: FAILED where mpirun has started several, and this program was built without MPI. */
int team_begin(team *t);
void team_end(const team *t);

/* The code of rank 0, for all. */
int team_code(const team *t, int code);

/* The runs that are to be done, as rank 0 has them, for all; others get a list to be freed. A code.
 */
int team_share(const team *t, long **todo, long *count);

/* Rank 0 hands out, waiting without a processor; the others work, each into a journal of its own.
 * Returns to all when all have ended. The worst code. */
int team_run(const team *t, const crew *c);

#endif

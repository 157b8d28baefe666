/* Processes on several machines, by MPI: see team.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 200809L
#include "program/team.h"

#include <stdlib.h>

/* What mpirun says to those it starts; NULL: it has not. */
static const char *launched(void)
{
    static const char *const names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"};
    const char *said = NULL;
    for (int k = 0; k < 3 && !said; ++k) said = getenv(names[k]);
    return said;
}

#if defined(MBSR_WITH_MPI)
#include "program/progress.h"

#include <mpi.h>
#include <time.h>

enum { ASK = 1, ANSWER = 2, END = 3 };

int team_begin(team *t)
{
    *t = (team){.rank = 0, .size = 1};
    if (!launched()) return DONE;
    MPI_Init(NULL, NULL);
    MPI_Comm_rank(MPI_COMM_WORLD, &t->rank);
    MPI_Comm_size(MPI_COMM_WORLD, &t->size);
    return DONE;
}

void team_end(const team *t)
{
    (void)t;
    int begun = 0;
    MPI_Initialized(&begun);
    if (begun) MPI_Finalize();
}

int team_code(const team *t, int code)
{
    if (t->size > 1) MPI_Bcast(&code, 1, MPI_INT, 0, MPI_COMM_WORLD);
    return code;
}

int team_share(const team *t, long **todo, long *count)
{
    if (t->size == 1) return DONE;
    MPI_Bcast(count, 1, MPI_LONG, 0, MPI_COMM_WORLD);
    if (t->rank > 0) *todo = malloc(((size_t)*count + 1) * sizeof **todo);
    int bad = *todo == NULL, any;
    MPI_Allreduce(&bad, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    if (any) return complain(FAILED, "no memory");
    MPI_Bcast(*todo, (int)*count, MPI_LONG, 0, MPI_COMM_WORLD);
    return DONE;
}

static void doze(void)
{
    const struct timespec pause = {.tv_nsec = 200000};
    nanosleep(&pause, NULL);
}

/* ---- rank 0 ---- */

/* Answers requests with the next few runs, less and less of them, until all workers have ended. */
static int hand_out(const team *t, const crew *c)
{
    progress shown = progress_begin("study", (double)c->count, c->quiet);
    long next = 0, done = 0;
    int code = DONE;
    for (int left = t->size - 1; left > 0;) {
        MPI_Status status;
        int there;
        MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &there, &status);
        progress_show(&shown, (double)done);
        if (!there) {
            doze();
            continue;
        }
        long said[2], answer[2] = {next, (c->count - next) / (8L * (t->size - 1))};
        MPI_Recv(said, 2, MPI_LONG, status.MPI_SOURCE, status.MPI_TAG, MPI_COMM_WORLD, &status);
        done += said[0];
        if (said[1]) code = (int)said[1];
        if (status.MPI_TAG == END) {
            --left;
            continue;
        }
        answer[1] = answer[1] < 1 ? 1 : answer[1] > 16 ? 16 : answer[1];
        if (next + answer[1] > c->count) answer[1] = c->count - next;
        if (code || crew_interrupted()) answer[1] = 0;
        next += answer[1];
        MPI_Send(answer, 2, MPI_LONG, status.MPI_SOURCE, ANSWER, MPI_COMM_WORLD);
    }
    progress_end(&shown);
    return code;
}

/* ---- the others ---- */

typedef struct worker {
    const crew *crew;
    long next, end; /* of those that were handed out */
    long done;      /* since the last request */
} worker;

static long next_of_team(void *user)
{
    worker *w = user;
    if (w->next == w->end) {
        long said[2] = {w->done, 0}, answer[2];
        MPI_Send(said, 2, MPI_LONG, 0, ASK, MPI_COMM_WORLD);
        MPI_Recv(answer, 2, MPI_LONG, 0, ANSWER, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        w->done = 0;
        w->next = answer[0];
        w->end = answer[0] + answer[1];
    }
    return w->next < w->end ? w->next++ : w->crew->count;
}

static void note_of_team(void *user)
{
    ++((worker *)user)->done;
}

int team_run(const team *t, const crew *c)
{
    int code, worst, all_there = 0;
    if (t->rank == 0) {
        code = hand_out(t, c);
    } else {
        worker w = {.crew = c};
        code = crew_work(c, t->rank - 1, next_of_team, &w, NULL, note_of_team);
        long said[2] = {w.done, code};
        MPI_Send(said, 2, MPI_LONG, 0, END, MPI_COMM_WORLD);
    }
    MPI_Request request;
    MPI_Iallreduce(&code, &worst, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD, &request);
    for (;;) {
        MPI_Test(&request, &all_there, MPI_STATUS_IGNORE);
        if (all_there) return worst;
        doze();
    }
}

#else

int team_begin(team *t)
{
    *t = (team){.rank = 0, .size = 1};
    const char *said = launched();
    if (!said || atoi(said) == 1) return DONE;
    return complain(FAILED, "this mbsrank was built without MPI; study --jobs N");
}

void team_end(const team *t)
{
    (void)t;
}

int team_code(const team *t, int code)
{
    (void)t;
    return code;
}

int team_share(const team *t, long **todo, long *count)
{
    (void)t, (void)todo, (void)count;
    return DONE;
}

int team_run(const team *t, const crew *c)
{
    (void)t;
    return crew_run(c);
}

#endif

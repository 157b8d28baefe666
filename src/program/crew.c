/* Processes that do the runs of a study: see crew.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _DEFAULT_SOURCE
#include "program/crew.h"

#include "program/progress.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

static volatile sig_atomic_t interrupted;

static void wake(int number)
{
    (void)number;
}

static void interrupt_crew(int number)
{
    (void)number;
    interrupted = 1;
}

void crew_catch_signals(void)
{
    struct sigaction action = {.sa_handler = interrupt_crew};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

bool crew_interrupted(void)
{
    return interrupted != 0;
}

/* ---- one process ---- */

int crew_work(const crew *c, int journal, crew_hand_out next, void *user, volatile long *doing,
              void (*done)(void *user))
{
    mbsr_journal *j;
    mbsr_error error = {.text = ""};
    mbsr_journal_opt opt = mbsr_default_journal_opt();
    opt.folder = c->folder;
    opt.key = c->work->key;
    opt.writer = journal;
    if (mbsr_journal_open(&opt, c->work->study, &j, &error))
        return complain(FAILED, "%s", error.text);
    int code = DONE;
    while (!code && !interrupted) {
        const long at = next(user);
        if (at >= c->count) break;
        if (doing) *doing = at;
        mbsr_study_result result;
        study_do(c->work, c->todo[at], &result);
        if (mbsr_journal_add(j, &result, &error)) code = complain(FAILED, "%s", error.text);
        if (doing) *doing = -1;
        if (!code) done(user);
    }
    if (mbsr_journal_close(j, 1) && !code)
        code = complain(FAILED, "%s: a journal cannot be written", c->folder);
    return code;
}

/* ---- processes that share a counter ---- */

enum { MOST_JOBS = 1024 };

/* What they share. */
typedef struct shared {
    atomic_long next, done;         /* places in `todo` handed out, runs in journals */
    atomic_int stop;                /* somebody wants all to end */
    volatile long doing[MOST_JOBS]; /* place in `todo` of each; -1: none */
} shared;

typedef struct member {
    const crew *crew;
    shared *all;
    long parent; /* process that waits for it */
} member;

static long next_shared(void *user)
{
    const member *me = user;
    if (atomic_load(&me->all->stop) || (long)getppid() != me->parent) return me->crew->count;
    return atomic_fetch_add(&me->all->next, 1);
}

static void note_shared(void *user)
{
    const member *me = user;
    atomic_fetch_add(&me->all->done, 1);
}

/* A process of its own for journal k; -1: none. */
static pid_t begin_job(const crew *c, shared *all, int k)
{
    member me = {.crew = c, .all = all, .parent = (long)getpid()};
    all->doing[k] = -1;
    fflush(NULL);
    const pid_t process = fork();
    if (process != 0) return process;
    const int code = crew_work(c, k, next_shared, &me, all->doing + k, note_shared);
    if (code) atomic_store(&all->stop, 1);
    fflush(NULL);
    _exit(code);
}

/* Records the run that a process has died of. */
static int record_crash(const crew *c, int k, long at, int signal)
{
    mbsr_journal *j;
    mbsr_error error = {.text = ""};
    mbsr_journal_opt opt = mbsr_default_journal_opt();
    char text[MBSR_TEXT_SIZE];
    opt.folder = c->folder;
    opt.key = c->work->key;
    opt.writer = k;
    snprintf(text, sizeof text, "the process died of signal %d, %s", signal, strsignal(signal));
    const mbsr_study_result result = {
        .run = c->todo[at], .outcome = MBSR_RUN_CRASHED, .status = signal, .text = text};
    int status = mbsr_journal_open(&opt, c->work->study, &j, &error);
    if (!status) {
        status = mbsr_journal_add(j, &result, &error);
        mbsr_journal_close(j, 1);
    }
    return status ? complain(FAILED, "%s", error.text) : DONE;
}

static bool is_crash(int signal)
{
    return signal == SIGSEGV || signal == SIGABRT || signal == SIGBUS || signal == SIGFPE ||
           signal == SIGILL;
}

/* What a process that has ended leaves to be done; *again: another one takes its place. A code. */
static int end_job(const crew *c, shared *all, int k, int status, bool *again)
{
    const long at = all->doing[k];
    *again = false;
    if (WIFEXITED(status)) return WEXITSTATUS(status);
    const int signal = WTERMSIG(status);
    *again = !interrupted && !atomic_load(&all->stop);
    if (at >= 0 && is_crash(signal)) {
        atomic_fetch_add(&all->done, 1);
        return record_crash(c, k, at, signal);
    }
    complain(FAILED, "a process was killed by signal %d; its run is left for the next time",
             signal);
    return DONE;
}

/* Waits for all, and looks after them. */
static int tend(const crew *c, shared *all, pid_t *process)
{
    progress shown = progress_begin("study", (double)c->count, c->quiet);
    int code = DONE, left = c->jobs;
    while (left > 0) {
        int status;
        poll(NULL, 0, 100); /* or until a process ends */
        if (interrupted) atomic_store(&all->stop, 1);
        progress_show(&shown, (double)atomic_load(&all->done));
        for (int k = 0; k < c->jobs; ++k) {
            bool again;
            if (process[k] <= 0 || waitpid(process[k], &status, WNOHANG) != process[k]) continue;
            const int ended = end_job(c, all, k, status, &again);
            if (ended) code = ended;
            process[k] = again && !code ? begin_job(c, all, k) : 0;
            left -= process[k] <= 0;
        }
    }
    progress_end(&shown);
    return code;
}

int crew_run(const crew *c)
{
    if (c->jobs > MOST_JOBS) return complain(USAGE, "study: --jobs is at most %d", (int)MOST_JOBS);
    int code = DONE;
    pid_t *process = calloc((size_t)c->jobs, sizeof *process);
    shared *all =
        mmap(NULL, sizeof *all, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (!process || all == MAP_FAILED) {
        free(process);
        return complain(FAILED, "study: %s", strerror(errno));
    }
    const struct sigaction action = {.sa_handler = wake};
    sigaction(SIGCHLD, &action, NULL);
    crew one = *c;
    for (int k = 0; k < c->jobs && !code; ++k) {
        process[k] = begin_job(c, all, k);
        if (process[k] < 0) {
            atomic_store(&all->stop, 1);
            code = complain(FAILED, "study: no process can be made: %s", strerror(errno));
        } else {
            one.jobs = k + 1;
        }
    }
    const int ended = process[0] > 0 ? tend(&one, all, process) : DONE;
    munmap(all, sizeof *all);
    free(process);
    return code ? code : ended;
}

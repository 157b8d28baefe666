/* mbsrank study: many runs of one model.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _DEFAULT_SOURCE
#include "program/hdf5.h"
#include "program/study_results.h"
#include "program/team.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

typedef struct study_options {
    const char *path, *file;
    double jobs;
    bool quiet, json, anew;
} study_options;

static int read_study_options(int argc, char **argv, study_options *o)
{
    for (int at = 0; at < argc; ++at) {
        const char *value = option_value(argc, argv, &at, "--jobs");
        if (at < 0) return USAGE;
        if (value) {
            if (!option_number("--jobs", value, &o->jobs)) return USAGE;
            if (o->jobs > 1024.0 || o->jobs != (double)(int)o->jobs)
                return complain(USAGE, "study: --jobs is a whole number up to 1024");
            continue;
        }
        value = option_value(argc, argv, &at, "-o");
        if (at < 0) return USAGE;
        if (value)
            o->file = value;
        else if (strcmp(argv[at], "--quiet") == 0)
            o->quiet = true;
        else if (strcmp(argv[at], "--json") == 0)
            o->json = true;
        else if (strcmp(argv[at], "--anew") == 0)
            o->anew = true;
        else if (argv[at][0] == '-')
            return complain(USAGE, "study: there is no option %s", argv[at]);
        else if (o->path)
            return complain(USAGE, "one file at a time: '%s' is a second one", argv[at]);
        else
            o->path = argv[at];
    }
    if (!o->path) return complain(USAGE, "there is no file; mbsrank study --help");
    return DONE;
}

/* Where results go: as options say, or NAME.h5 here for FOLDER/NAME.study; to be freed. */
static char *result_path(const study_options *o)
{
#if defined(MBSR_WITH_HDF5)
    const char *ending = ".h5";
#else
    const char *ending = ".csv";
#endif
    const char *name = strrchr(o->path, '/');
    name = o->file ? o->file : name ? name + 1 : o->path;
    const size_t size = strlen(name) + 8;
    char *path = malloc(size);
    if (!path) return NULL;
    snprintf(path, size, "%s", name);
    if (o->file) return path;
    char *point = strrchr(path, '.');
    if (point && point != path) *point = '\0';
    strcat(path, ending);
    return path;
}

/* ---- the folder of journals ---- */

/* So that one command at a time works there: its processes hold the lock as long as one lives. */
static int lock_folder(const char *folder)
{
    char path[4096];
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return complain_of_file(FAILED, folder, "made");
    snprintf(path, sizeof path, "%s/lock", folder);
    const int file = open(path, O_RDWR | O_CREAT, 0666);
    if (file < 0) return complain_of_file(FAILED, path, "written");
    for (int k = 0; flock(file, LOCK_EX | LOCK_NB) != 0; ++k) {
        const struct timespec pause = {.tv_nsec = 50000000};
        if (errno != EWOULDBLOCK && errno != EINTR) return complain_of_file(FAILED, path, "locked");
        if (k == 20) say(stderr, "waiting for another mbsrank that works at %s\n", folder);
        if (k == 1200 || crew_interrupted())
            return complain(FAILED, "another mbsrank works at %s", folder);
        nanosleep(&pause, NULL);
    }
    return DONE; /* the file stays open */
}

/* Removes what earlier commands have left. */
static int clear_folder(const char *folder)
{
    DIR *all = opendir(folder);
    int code = DONE;
    if (!all) return complain_of_file(FAILED, folder, "read");
    for (const struct dirent *entry; !code && (entry = readdir(all));) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (ends_in(entry->d_name, ".journal") && remove(path) != 0)
            code = complain_of_file(FAILED, path, "removed");
    }
    closedir(all);
    return code;
}

/* The runs that are to be done yet, to be freed. A code. */
static int list_todo(const study_work *w, const char *folder, long **todo, long *count)
{
    mbsr_journal *j;
    mbsr_error error = {.text = ""};
    mbsr_journal_opt opt = mbsr_default_journal_opt();
    opt.folder = folder;
    opt.key = w->key;
    opt.writer = -1;
    *count = 0;
    if (mbsr_journal_open(&opt, w->study, &j, &error)) {
        if (error.status == MBSR_ERR_MISMATCH)
            return complain(USAGE, "%s; --anew begins anew, -o goes elsewhere", error.text);
        return complain(FAILED, "%s", error.text);
    }
    *todo = malloc((size_t)w->study->runs * sizeof **todo);
    for (long run = 0; *todo && run < w->study->runs; ++run)
        if (!mbsr_journal_has(j, run)) (*todo)[(*count)++] = run;
    mbsr_journal_close(j, 0);
    return *todo ? DONE : complain(FAILED, "no memory");
}

/* ---- all of it ---- */

static int tell_end(const study_results *r, bool stopped)
{
    const long *n = r->outcomes;
    const long failed = n[MBSR_RUN_FAILED] + n[MBSR_RUN_STEPS] + n[MBSR_RUN_CRASHED];
    if (failed > 0) {
        say(stderr, "%ld of %ld runs failed; run %ld: %s\n", failed, r->runs, r->failed[0],
            r->text[0]);
    }
    if (n[MBSR_RUN_TIME] > 0)
        say(stderr, "%ld runs took too long; the same command tries them again\n",
            n[MBSR_RUN_TIME]);
    if (n[MBSR_RUN_MISSING] > 0 || stopped)
        return complain(FAILED, "%ld of %ld runs are not done; the same command goes on",
                        n[MBSR_RUN_MISSING], r->runs);
    return DONE;
}

/* What rank 0 does before the others work. */
static int prepare_study(const study_options *o, const study_work *w, const char *folder,
                         long **todo, long *count)
{
    int code = lock_folder(folder);
    if (!code && o->anew) code = clear_folder(folder);
    if (!code) code = list_todo(w, folder, todo, count);
    if (!code && *count > 0 && *count < w->study->runs && !o->quiet)
        say(stderr, "%ld of %ld runs are done already\n", w->study->runs - *count, w->study->runs);
    return code;
}

/* And behind them. */
static int end_study(const study_options *o, study_work *w, const char *path, const char *folder)
{
    study_results r = {.work = NULL};
    int code = results_collect(w, folder, &r);
    if (!code) code = results_write(&r, path);
    if (!code) code = results_tell(&r, o->json, stdout);
    if (!code) code = tell_end(&r, crew_interrupted());
    results_free(&r);
    return code;
}

static int do_study(const study_options *o, const team *t, study_work *w, const char *path,
                    const char *folder)
{
    long *todo = NULL, count = 0;
    int code = t->rank == 0 ? prepare_study(o, w, folder, &todo, &count) : DONE;
    code = team_code(t, code);
    if (!code) code = team_share(t, &todo, &count);
    if (!code && count > 0) {
        const crew all = {.work = w,
                          .folder = folder,
                          .todo = todo,
                          .count = count,
                          .jobs = o->jobs > (double)count ? (int)count : (int)o->jobs,
                          .quiet = o->quiet};
        code = t->size > 1 ? team_run(t, &all) : crew_run(&all);
    }
    if (!code && t->rank == 0) code = end_study(o, w, path, folder);
    free(todo);
    return code;
}

/* Opens the study, on rank 0 first, and does it. */
static int open_and_do(const study_options *o, const team *t)
{
    study_work w = {.study = NULL};
    char *path = result_path(o), *folder = path ? malloc(strlen(path) + 8) : NULL;
    int code = folder ? DONE : complain(FAILED, "no memory");
    if (!code) sprintf(folder, "%s.runs", path);
#if !defined(MBSR_WITH_HDF5)
    if (!code && names_hdf5(path)) code = hdf5_write_study(NULL, path);
#endif
    if (!code && t->size > 1 && o->jobs > 1.0)
        code = complain(USAGE, "study: --jobs is for one process, not under mpirun");
    if (!code && t->rank == 0) code = study_open(o->path, o->quiet, &w);
    code = team_code(t, code);
    if (!code && t->rank > 0) code = study_open(o->path, true, &w);
    if (!code) code = do_study(o, t, &w, path, folder);
    free(folder);
    free(path);
    study_close(&w);
    return code;
}

int run_study(int argc, char **argv)
{
    study_options o = {.jobs = 1.0};
    team t;
    int code = read_study_options(argc, argv, &o);
    if (!code) code = team_begin(&t);
    if (code) return code;
    crew_catch_signals();
    code = open_and_do(&o, &t);
    team_end(&t);
    return code;
}

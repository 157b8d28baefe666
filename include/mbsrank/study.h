/* Many runs of one model: what is varied and kept, and a journal of what has been done (component
 * study).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   mbsr_study_read(text, size, "car.study", NULL, &study, &error);
 *   mbsr_journal_open(&opt, study, &journal, &error);
 *   for (long run = 0; run < study->runs; ++run) {
 *       if (mbsr_journal_has(journal, run)) continue;
 *       mbsr_study_values(study, run, value);
 *       ... a run with these values of the parameters gives `result` ...
 *       mbsr_journal_add(journal, &result, &error);
 *   }
 *
 * Values depend on the study and the number of the run alone, so that any number of processes may
 * do the runs in any order. docs/study.md says how the program mbsrank does them. */
#ifndef MBSRANK_STUDY_H
#define MBSRANK_STUDY_H

#include <mbsrank/base.h>

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- what a study is ---- */

/* How values of parameters are chosen. Each makes numbers z between 0 and 1, exclusive, which
 * mbsr_spread turns into values. */
typedef enum mbsr_sampling {
    MBSR_SAMPLING_GRID,   /* all combinations of levels, those of the last parameter first */
    MBSR_SAMPLING_LIST,   /* values line by line */
    MBSR_SAMPLING_RANDOM, /* independent numbers */
    MBSR_SAMPLING_LATIN,  /* Latin hypercube: each of `runs` equal parts of every range once */
    MBSR_SAMPLING_SOBOL   /* Sobol' points */
} mbsr_sampling;

/* "grid", "list", ...: the word of study files; NULL for another number. */
MBSR_API const char *mbsr_sampling_name(mbsr_sampling sampling);

/* Where the values of a parameter are. */
typedef enum mbsr_spread {
    MBSR_SPREAD_UNIFORM, /* low + z (high - low) */
    MBSR_SPREAD_LOG,     /* low^(1 - z) high^z */
    MBSR_SPREAD_NORMAL   /* low + high times the normal quantile of z: mean and deviation */
} mbsr_spread;

/* A parameter that is varied. */
typedef struct mbsr_study_parameter {
    const char *name, *unit; /* unit "": not said */
    int line;                /* of the file */
    mbsr_spread spread;
    double low, high;
    int levels; /* of a grid; z in the middle of as many parts if normal, else from 0 to 1; one
                   level: z = 1/2 */
} mbsr_study_parameter;

/* What of a run is kept. */
typedef enum mbsr_study_kind {
    MBSR_KEEP_AT,    /* at chosen times */
    MBSR_KEEP_MAX,   /* largest of all outputs of the run */
    MBSR_KEEP_MIN,   /* smallest */
    MBSR_KEEP_MEAN,  /* mean over time, by trapezoids between outputs */
    MBSR_KEEP_RISES, /* when it first passes a level upwards, s; NaN: never */
    MBSR_KEEP_FALLS  /* and downwards */
} mbsr_study_kind;

/* An output: what is kept of a column. */
typedef struct mbsr_study_output {
    const char *column, *unit; /* unit "": not said */
    int line;
    mbsr_study_kind kind;
    double level;
    int times;          /* of AT; else 0 */
    const double *time; /* s, ascending, of AT */
    int first, count;   /* its numbers among those of a run */
} mbsr_study_output;

/* A study, as its file says. Arrays belong to it. */
typedef struct mbsr_study {
    const char *name, *model; /* paths, as they are given; model "": none is named */
    int model_line;
    int words; /* of `run` */
    const char *const *word;
    int run_line;
    long max_steps;  /* of a run; 0: as many as it takes */
    double max_time; /* s of real time of a run; 0: likewise */
    mbsr_sampling sampling;
    uint64_t seed;
    long runs;
    int parameters;
    const mbsr_study_parameter *parameter;
    int outputs;
    const mbsr_study_output *output;
    int numbers;                            /* of all outputs of a run */
    const struct mbsr_study_sample *sample; /* its own */
} mbsr_study;

/* Sobol' points have direction numbers for so many parameters (Joe and Kuo 2008, new-joe-kuo-6). */
#define MBSR_SOBOL_PARAMETERS 64

/* Reads a study of `size` bytes (no NUL is needed); `name` is that of its file, for messages (NULL:
 * none). allocator NULL: malloc and free. Lines are words between blanks, "in quotes" with blanks;
 * # begins a comment:
 *
 *   model PATH
 *   run WORD ...                     options of the run, handed on as they are
 *   limit N steps; limit X s
 *   sample grid; list; random N; latin N; sobol N; then [seed S]
 *   vary NAME LOW HIGH [log] [levels N] [unit U]
 *   vary NAME normal MEAN DEVIATION [levels N] [unit U]
 *   vary NAME [unit U]               with sample list
 *   values X ...                     of all parameters, in the order of `vary`, with sample list
 *   keep COLUMN at T ... [unit U]
 *   keep COLUMN every H to T         at 0, H, 2 H ... T
 *   keep COLUMN max; min; mean; rises LEVEL; falls LEVEL
 *
 * Seeds are 0 .. 2^64 - 1; default 0. On failure *study is NULL, and the text of *error (may be
 * NULL) names file, line and word. Numbers do not depend on the locale. MBSR_ERR_NULL,
 * MBSR_ERR_FILE, MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_study_read(const char *text, size_t size, const char *name,
                             const mbsr_allocator *allocator, mbsr_study **study,
                             mbsr_error *error);
MBSR_API void mbsr_study_destroy(mbsr_study *study); /* NULL is allowed */

/* Values of all parameters in a run, 0 .. runs - 1. Bits of z, which the values follow from:
 *
 *   random   z = (h(seed, k, run) / 2^11 + 1/2) / 2^53 for parameter k, h of 64 bits by SplitMix64
 *            (Steele, Lea, Flood 2014): h(s, k, i) = mix(mix(s + (k + 1) g) + (i + 1) g)
 *   latin    z = (p(run) + z of random) / runs, p a permutation by Fisher and Yates that takes its
 *            numbers from h(seed, k + 2^32, i)
 *   sobol    32 bits in the order of Gray's code; with seed != 0 their exclusive or with the upper
 *            32 of h(seed, k, 0); and half of the last one more
 *
 * value: study->parameters numbers. MBSR_ERR_NULL, MBSR_ERR_ID. */
MBSR_API int mbsr_study_values(const mbsr_study *study, long run, double *value);

/* ---- what has been done ---- */

/* How a run ended. */
typedef enum mbsr_outcome {
    MBSR_RUN_DONE = 0,
    MBSR_RUN_FAILED = 1,  /* with a status and a text */
    MBSR_RUN_STEPS = 2,   /* more than max_steps */
    MBSR_RUN_TIME = 3,    /* more than max_time: depends on the machine, so it is no result */
    MBSR_RUN_CRASHED = 4, /* its process died */
    MBSR_RUN_MISSING = 5  /* not done yet */
} mbsr_outcome;

/* One run. */
typedef struct mbsr_study_result {
    long run;
    mbsr_outcome outcome;
    int status;          /* of a failure */
    long steps;          /* it took */
    const double *value; /* study->numbers; not read, and NaN in the journal, unless it is DONE */
    const char *text;    /* of a failure; NULL: "" */
} mbsr_study_result;

typedef struct mbsr_journal mbsr_journal;

/* Where journals are. */
typedef struct mbsr_journal_opt {
    int cookie;               /* set by mbsr_default_journal_opt */
    const char *folder;       /* is made if it is not there */
    int writer;               /* this process writes the file of that number; -1: none, default 0 */
    uint64_t key;             /* tells studies and models apart; default 0 */
    mbsr_allocator allocator; /* default: malloc and free (both functions NULL) */
} mbsr_journal_opt;

MBSR_API mbsr_journal_opt mbsr_default_journal_opt(void);

/* Opens a journal and reads what all processes have written there. A file ends in the middle of a
 * run where its process was killed: a writer cuts its own there, and all else is read up to it. A
 * run counts once, however often it is there; one ended by time gives way to any other. Two
 * journals must not write the same file at once. On failure *journal is NULL and *error says why.
 * MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_MISMATCH: a file there belongs to another key or
 * study; MBSR_ERR_FILE: it cannot be read or written, with the reason of the system;
 * MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_journal_open(const mbsr_journal_opt *opt, const mbsr_study *study,
                               mbsr_journal **journal, mbsr_error *error);

/* Closes it; what was added is with the system then, and on the disk if `sync`. NULL is allowed.
 * MBSR_ERR_FILE. */
MBSR_API int mbsr_journal_close(mbsr_journal *journal, int sync);

/* Writes a run behind the others, all of it or nothing: if there is no room the file is cut to what
 * it was. MBSR_ERR_NULL, MBSR_ERR_ID, MBSR_ERR_VALUE (the outcome), MBSR_ERR_SEQUENCE: it has no
 * writer; MBSR_ERR_FILE, with the reason of the system. */
MBSR_API int mbsr_journal_add(mbsr_journal *journal, const mbsr_study_result *result,
                              mbsr_error *error);

/* How a run ended, as it was when the journal was opened, or added here since; MBSR_RUN_MISSING
 * also for NULL and a run that does not exist. */
MBSR_API mbsr_outcome mbsr_journal_outcome(const mbsr_journal *journal, long run);

/* 1: the run need not be done; 0: it is missing, or was ended by time. */
MBSR_API int mbsr_journal_has(const mbsr_journal *journal, long run);

/* What is known of a run. `value` has room for study->numbers, `text` for MBSR_TEXT_SIZE; result's
 * point there. Of a run that is missing numbers are NaN. MBSR_ERR_NULL, MBSR_ERR_ID, MBSR_ERR_FILE:
 * it cannot be read again. */
MBSR_API int mbsr_journal_get(mbsr_journal *journal, long run, double *value, char *text,
                              mbsr_study_result *result, mbsr_error *error);

#ifdef __cplusplus
}
#endif

#endif

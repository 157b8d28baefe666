/* What the commands of mbsrank share.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_PROGRAM_H
#define MBSRANK_PROGRAM_H

#include <mbsrank/files.h>
#include <mbsrank/mbsrank.h>

#include <stdbool.h>
#include <stdio.h>

/* How the program ends. */
enum { DONE = 0, UNDETERMINED = 1, USAGE = 2, NOT_READ = 3, FAILED = 4 };

/* ---- text.c ---- */

/* What printf would write, with ? for the control characters that texts of a file may have. */
void say(FILE *to, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* "mbsrank: ..." on stderr; returns `code`. */
int complain(int code, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* "... cannot be `what` (read, written): " and the reason, which is in errno. */
int complain_of_file(int code, const char *path, const char *what);

/* A string of JSON, quoted. */
void put_json(FILE *to, const char *text);

/* A number of JSON in 9 digits, null where it is not finite; an array of them. */
void put_number(FILE *to, double x);
void put_numbers(FILE *to, int n, const double *x);

/* The whole file, with a NUL behind it; NULL: it cannot be read, and errno says why: EFBIG beyond 1
 * GiB. */
char *read_file(const char *path, size_t *size);

/* Whether the text is longer than the ending, and ends so. */
bool ends_in(const char *text, const char *ending);

/* The value of option `name` at argv[*at] ("--name value" or "--name=value"), which moves on; NULL:
 * it is another. Without a value complains and sets *at to -1. */
const char *option_value(int argc, char **argv, int *at, const char *name);

/* A positive number alone; false: complains. */
bool option_number(const char *name, const char *value, double *number);

/* ---- model.c ---- */

/* A file with its model finished, and data. */
typedef struct program_model {
    char *text;
    size_t size; /* bytes of the text */
    mbsr_file *file;
    mbsr_model *model; /* owned by the file until it is taken */
    mbsr_model *read;  /* before --set; NULL: the same */
    mbsr_data *data;
    int others;   /* files that were read besides, */
    char **other; /* by their paths */
} program_model;

/* Options that every command has; texts point into the arguments. */
enum { MOST_PAIRS = 64 };
typedef struct program_options {
    const char *path;
    const char *start; /* name of a key; NULL: as drawn */
    bool json, strict, floating;
    bool limits, friction;                     /* by the rule of files.h */
    bool contacts;                             /* shapes touch, meshes by their hulls */
    double stop_stiffness, stop_damping, slip; /* as in mbsr_file_opt; 0: none */
    mbsr_file_package package[MOST_PAIRS];     /* names point into the arguments */
    mbsr_xacro_argument argument[MOST_PAIRS];  /* likewise */
    int packages, arguments;
    const char *set[MOST_PAIRS]; /* names of parameters, and their values */
    double value[MOST_PAIRS];
    int sets;
    const char *folder[16]; /* where files that the model names may be, too */
    int folders;
    bool anywhere; /* whether includes may be in any folder */
} program_options;

/* Takes a common option at argv[*at]; false: it is none. Code in *code, DONE as long as all is
 * well. */
bool common_option(int argc, char **argv, int *at, program_options *o, int *code);

/* DONE, or a code after a complaint. Findings go to stderr unless `quiet`. */
int open_model(const program_options *o, bool quiet, program_model *m);
void close_model(program_model *m);

/* Whether a body has neither mass nor moment of inertia, and its mass; NaN: it is no rigid one. */
bool weigh_body(const mbsr_inertia *inertia, double *mass);

/* Tells texts of models apart, such as the one of a run from the one that is shown: FNV-1a, 64
 * bits. */
enum { MODEL_HASH = 17 };
void model_hash(const program_model *m, char to[MODEL_HASH]);

/* The state to start from: q and u of the key named, else as drawn; a code. */
int start_state(const program_options *o, const program_model *m, const double **q,
                const double **u);

/* A file that the model names, such as a mesh: from the folder of the model, or as it stands.
 * read_file; EPERM: it is elsewhere than options allow. */
char *read_beside(const program_options *o, const char *name, size_t *size);

bool has_beside(const program_options *o, const char *name); /* whether there is one */

/* The mesh of shape `k`, where no earlier shape has it; else NULL. */
const char *new_mesh(const program_model *m, int k);

/* Whether the file of such a mesh is not there. */
bool lacks_mesh(const program_options *o, const program_model *m, int k);

/* ---- info.c ---- */

/* What a model consists of, with masses as at q, and its parameters. A code. */
int info_write(FILE *to, const program_options *o, const program_model *m, const double *q,
               bool json);
int parameters_write(FILE *to, const program_model *m, bool json);

/* ---- report.c ---- */

/* The index report, or with closures that of their rows. UNDETERMINED where something is; DONE; or
 * a code after a complaint, with nothing written as JSON. */
int report_write(FILE *to, const program_model *m, const double *q, const double *u, bool json);

/* The same, but the object of JSON stays open for more members. */
int report_begin(FILE *to, const program_model *m, const double *q, const double *u, bool json);

/* ---- commands ---- */

int run_info(int argc, char **argv);
int run_check(int argc, char **argv);
int run_run(int argc, char **argv);
int run_fit(int argc, char **argv);
int run_study(int argc, char **argv);
int run_view(int argc, char **argv);
int run_plot(int argc, char **argv);
int run_convert(int argc, char **argv);
int run_fmu(int argc, char **argv);
int run_static(int argc, char **argv);
int run_modes(int argc, char **argv);
int run_linearise(int argc, char **argv);

#endif

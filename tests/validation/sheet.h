/* Public references and the library's own digits, row by row.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef VALIDATION_SHEET_H
#define VALIDATION_SHEET_H

#include <mbsrank/simulation.h>

enum { SHEET_ROWS = 400 };

typedef struct sheet_row {
    const char *problem, *source; /* of the first row of a problem, else NULL */
    const char *quantity;
    double theirs, ours;
    double allowed; /* difference; decides how many digits are shown, too */
} sheet_row;

typedef struct sheet {
    sheet_row row[SHEET_ROWS];
    int rows;
    const char *problem, *source; /* of the next row */
} sheet;

/* Begins a problem; `source` says where its digits were published. */
void sheet_problem(sheet *s, const char *problem, const char *source);
void sheet_add(sheet *s, const char *quantity, double theirs, double ours, double allowed);

/* Runs to a time; what fails is told, and ends the program. */
void sheet_run(mbsr_simulation *s, double t);
void sheet_check(int status, const mbsr_error *error);
/* Starts a run with this tolerance near q, u; NULL: as mbsr_simulation_start. */
void sheet_start(mbsr_simulation *s, double tolerance, const double *q, const double *u);

/* The problems, a file each. */
void sheet_ivp(sheet *s);
void sheet_bicycle(sheet *s);
void sheet_linkages(sheet *s);
void sheet_bodies(sheet *s);
void sheet_adams(sheet *s);
void sheet_modelica(sheet *s);
void sheet_modelica_more(sheet *s);
void sheet_exudyn(sheet *s);
void sheet_flight(sheet *s);
void sheet_iltis(sheet *s);

#endif

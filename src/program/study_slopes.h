/* How what a run keeps changes with the parameters of a study.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_STUDY_SLOPES_H
#define MBSRANK_STUDY_SLOPES_H

#include "program/study_run.h"

/* Derivatives of study->numbers, all outputs at the same times, in each parameter (parameter after
 * parameter), at w->parameter: by forward sensitivities of one run. 0, or another number where they
 * are not to be had: with inputs, columns that need accelerations or contacts, or what
 * mbsr_sensitivity_create and mbsr_sensitivity_run refuse. */
int study_slopes(study_work *w, double *slope);

#endif

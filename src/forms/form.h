/* What a form of the equations of motion consists of, and the forms there are.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FORM_H
#define MBSRI_FORM_H

#include "recursion/data.h"

#include <mbsrank/dae.h>

/* One form of the equations of motion. y = (q, rest). */
typedef struct mbsri_dae_form {
    mbsr_dae_form form;
    int (*size)(const mbsr_model *m);
    int (*id)(const mbsr_model *m, mbsr_data *d, double *id);
    int (*pack)(const mbsr_model *m, mbsr_data *d, double t, const double *q, const double *u,
                double *y);
    int (*unpack)(const mbsr_model *m, mbsr_data *d, double t, const double *y, double *q,
                  double *u);
    /* y' at y, where u' is given; the data is at mbsr_stage_backward of that state */
    int (*start)(const mbsr_model *m, mbsr_data *d, double t, const double *y, const double *udot,
                 double *yp);
    int (*residual)(const mbsr_model *m, mbsr_data *d, double t, const double *y, const double *yp,
                    double *F);
} mbsri_dae_form;

extern const mbsri_dae_form mbsri_form_recursive, mbsri_form_inverse_dynamics, mbsri_form_momentum,
    mbsri_form_index1;

#endif

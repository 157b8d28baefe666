/* Any form, by its number.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DAE_H
#define MBSRI_DAE_H

#include "forms/form.h"

/* pack, unpack of a form, with q brought to its normal form. */
int mbsri_pack(const mbsri_dae_form *form, const mbsr_model *m, mbsr_data *d, double t,
               const double *q, const double *u, double *y);
int mbsri_unpack(const mbsri_dae_form *form, const mbsr_model *m, mbsr_data *d, double t,
                 const double *y, double *q, double *u);

/* y and y' of a form at the state q, u with accelerations u'. */
int mbsri_pack_motion(const mbsri_dae_form *form, const mbsr_model *m, mbsr_data *d, double t,
                      const double *q, const double *u, const double *udot, double *y, double *yp);

/* The form of that number; NULL if there is none. */
const mbsri_dae_form *mbsri_find_form(mbsr_dae_form form);

#endif

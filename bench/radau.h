/* A reference integrator: Radau IIA of order 5 with fixed step, for any form of the equations.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef RADAU_H
#define RADAU_H

#include <mbsrank/mbsrank.h>

/* Integrates F(t, y, y') = 0 from 0 to T in `steps` equal steps, of which the first is divided into
 * smaller ones, so that a fast motion at the start is followed. y and yp: state and derivative, in
 * and out. Stiffly accurate: the equations hold at the end of every step, algebraic ones included.
 * Ends the program where the Newton iteration fails. */
void radau_integrate(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double T,
                     long steps, double *y, double *yp);

#endif

/* Stiff trees in libmbsrank: the model, a start, tolerances, where the bodies are.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef BUILD_H
#define BUILD_H

#include "stiff.h"

#include <mbsrank/mbsrank.h>

/* The finished model. Bodies in the plane if the description allows it and `plane` is 1.
 * `replacement`: mass in kg instead of none of bodies without mass (with the same share of the
 * moments); 0: none. The model refers to *s. */
mbsr_model *build_model(stiff_model *s, int plane, double replacement);

/* A consistent state y, y' of the momentum form at t = 0, from rest in the description's
 * position. */
void build_start(const stiff_model *s, const mbsr_model *model, mbsr_data *data, double *y,
                 double *yp);

/* Absolute tolerances (mbsr_dae_size of the momentum form) for errors of about `tolerance`, in m or
 * rad, of a chain's places and directions, which are sums over its n joints: of joint angles
 * tolerance / n, of momenta tolerance times the moment of the masses further out times the chain's
 * length, as if the error were a motion of all of them. (The driver's own, which take each joint
 * alone, are n times tighter than that.) */
void build_tolerances(const stiff_model *s, const mbsr_model *model, double tolerance,
                      double *atol);

/* Where the bodies' origins are: 3 numbers each. */
void build_places(const mbsr_model *model, mbsr_data *data, double t, const double *q, double *x);

#endif

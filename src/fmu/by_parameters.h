/* Derivatives of variables with respect to parameters.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * What stays: the values of the start in initialization mode; q and p of model exchange; q and u of
 * co-simulation, whose accelerations and loop forces follow by analytic products where these exist.
 * Else central differences between models with other parameters. */
#ifndef MBSRI_FMU_BY_PARAMETERS_H
#define MBSRI_FMU_BY_PARAMETERS_H

#include "fmu/instance.h"

/* References of variables, and of parameters among them. */
typedef struct mbsri_by_parameters {
    const char *function; /* whose messages these are */
    const unsigned *unknown, *parameter;
    size_t unknowns, parameters;
} mbsri_by_parameters;

/* Adds (d unknowns / d parameters) seed to the sensitivities of the unknowns. */
mbsri_result mbsri_along_parameters(mbsri_instance *in, const mbsri_by_parameters *d,
                                    const double *seed, double *sensitivity);

/* Those of the parameters: against a seed of the unknowns. */
mbsri_result mbsri_against_parameters(mbsri_instance *in, const mbsri_by_parameters *d,
                                      const double *seed, double *sensitivity);

#endif

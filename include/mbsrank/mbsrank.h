/* libmbsrank: O(N) dynamics of trees of bodies with zero or rank-deficient mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Forward dynamics (articulated-body algorithm, with pseudo-inverses), inverse dynamics (recursive
 * Newton-Euler algorithm), mass matrix (composite rigid-body algorithm), and the equations of
 * motion as a differential-algebraic equation (DAE) in minimal coordinates.
 *
 * Includes all headers of the core but <mbsrank/driver.h>, which is for those who write
 * integrators. The components have headers of their own: ida.h, simulation.h and sundials.h;
 * files.h; contact.h; fe.h and sid.h; linear.h; fmu.h. */
#ifndef MBSRANK_MBSRANK_H
#define MBSRANK_MBSRANK_H

#include <mbsrank/base.h>
#include <mbsrank/batch.h>
#include <mbsrank/closure.h>
#include <mbsrank/completion.h>
#include <mbsrank/dae.h>
#include <mbsrank/data.h>
#include <mbsrank/derivatives.h>
#include <mbsrank/dynamics.h>
#include <mbsrank/flex.h>
#include <mbsrank/force.h>
#include <mbsrank/index.h>
#include <mbsrank/inertia.h>
#include <mbsrank/joint.h>
#include <mbsrank/model.h>
#include <mbsrank/newton.h>
#include <mbsrank/ode.h>
#include <mbsrank/parameters.h>
#include <mbsrank/small_masses.h>
#include <mbsrank/spatial.h>
#include <mbsrank/stepper.h>
#include <mbsrank/table.h>
#include <mbsrank/threads.h>
#include <mbsrank/verify.h>

#endif

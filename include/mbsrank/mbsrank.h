/* libmbsrank: O(N) dynamics of trees of bodies with zero or rank-deficient mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Forward dynamics (articulated-body algorithm, with pseudo-inverses), inverse dynamics (recursive
 * Newton-Euler algorithm), mass matrix (composite rigid-body algorithm), and the equations of
 * motion as a differential-algebraic equation (DAE) in minimal coordinates.
 *
 * Includes everything but <mbsrank/ida.h> and <mbsrank/simulation.h>, which belong to the component
 * ida. */
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
#include <mbsrank/force_check.h>
#include <mbsrank/index.h>
#include <mbsrank/inertia.h>
#include <mbsrank/joint.h>
#include <mbsrank/joint_check.h>
#include <mbsrank/loops.h>
#include <mbsrank/model.h>
#include <mbsrank/newton.h>
#include <mbsrank/ode.h>
#include <mbsrank/small_masses.h>
#include <mbsrank/spatial.h>
#include <mbsrank/stepper.h>
#include <mbsrank/table.h>
#include <mbsrank/threads.h>

#endif

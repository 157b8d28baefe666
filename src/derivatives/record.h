/* Derivatives of inverse and forward dynamics: what the object holds.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DERIVATIVES_RECORD_H
#define MBSRI_DERIVATIVES_RECORD_H

#include "derivatives/rigid.h"
#include "derivatives/seeds.h"
#include "fronts/fronts.h"
#include "newton/linear/product.h"
#include "newton/linear/product_sources.h"

#include <mbsrank/dae.h>
#include <mbsrank/derivatives.h>

typedef enum mbsri_linearised {
    MBSRI_LINEARISED_NOT,
    MBSRI_LINEARISED_INVERSE,
    MBSRI_LINEARISED_FORWARD,
    MBSRI_LINEARISED_RESIDUAL
} mbsri_linearised;

/* The residual of the momentum form: vectors of its products; seeds of parameters, whose sums are
 * `sources`; of y and y' (size of y each) what is given, and what belongs to c = 0. */
typedef struct mbsri_residual {
    mbsri_vectors vectors;
    mbsri_seeds seeds;
    mbsri_sources sources;
    double *given, *result, *other;
    double *memory;
} mbsri_residual;

struct mbsr_derivatives {
    const mbsr_model *model;
    mbsr_data *data; /* with the factors, as long as there are derivatives */
    mbsr_error error;
    mbsri_linear *linear;   /* with the accelerations of all bodies */
    mbsri_rigid *rigid;     /* NULL: the model is none */
    mbsri_seeds seeds;      /* of parameters, and for the sweeps */
    mbsri_seeds rigid_seed; /* with rigid->seeds; none where the sweeps do not serve them */
    mbsri_residual residual;
    mbsri_linearised at;
    bool by_sweeps; /* of `rigid` */
    bool factored;  /* `fronts` have been */
    bool redundant; /* and some rows depend on others */
    mbsri_fronts fronts;
    double *memory;
    /* vectors of one product: x of bodies, their reactions, q and u of joints (in the caller's
     * order, the forces of elements in that of the sweeps) */
    double *motion, *mu, *dq, *torque, *load;
    double *in, *out;               /* of one joint, element or closure */
    double *right, *solution;       /* nu */
    double *column;                 /* nu: zeros, but for a unit vector */
    double *rows, *lambda, *weight; /* rows: accelerations of closures, their forces */
    double *acceleration;           /* of each closure from its `at` on twice: by place, by rate */
    double *work;
};

/* No state is linearised any more. */
void mbsri_derivatives_forget(mbsr_derivatives *w);

/* A failure of the data, or with this text, as that of the object; the status. */
int mbsri_derivatives_take_error(mbsr_derivatives *w, int status);
int mbsri_derivatives_refuse(mbsr_derivatives *w, int status, const char *function,
                             const char *text);

/* Whether all of x (n) are finite, or there is none: NULL. */
bool mbsri_finite_or_null(size_t n, const double *x);

/* dq of q = G x, or with `back` x = G^T dq, of the state linearised. */
void mbsri_derivatives_turn(const mbsr_derivatives *w, bool back, const double *from, double *to);

/* No parameters are chosen any more. */
void mbsri_derivatives_unchoose(mbsr_derivatives *w);

/* Along dq (nq), du and du' (nu, by the caller's order), and what `seeds` add: the change of J^T mu
 * - tau into load, of second derivatives of the closures' rows into rows, of the forces of stiff
 * rows into lambda, where others stay. */
void mbsri_derivatives_tangent(mbsr_derivatives *w, const double *dq, const double *du,
                               const double *dudot, double *load);

/* The transpose: w of load (nu), `rows` and `weight` of the rows and of the forces of stiff rows;
 * adds nothing: writes dq (nq), du, du' (nu). */
void mbsri_derivatives_adjoint(mbsr_derivatives *w, const double *load, double *dq, double *du,
                               double *dudot);

/* Of these the part of force elements, by sweeps but for plain ones (mbsri_linear_is_plain): from x
 * of bodies to mu and `torque`; and from weights in mu and load, added. */
void mbsri_derivatives_elements(mbsr_derivatives *w, const double *dq, const double *du);
void mbsri_derivatives_elements_back(mbsr_derivatives *w, const double *load, double *dq,
                                     double *du);

#endif

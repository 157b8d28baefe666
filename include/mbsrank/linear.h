/* Equilibria, linear equations of motion and modes of vibration (component linear).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * mbsr_equilibrium finds positions at which a model rests. mbsr_linear_create linearises its
 * equations of motion there, or in a steady motion, about q, u:
 *
 *   E x' = A x + B w,      x = (dq, dp, du, dlambda)      descriptor form
 *   z' = Ar z + Br w,  y = Cr z + Dr w                    least number of states
 *
 * dq are joint rates: changes of q are G(q) dq, so that a quaternion has three. E is singular where
 * loops are closed or masses vanish; the second form has left only what has finite eigenvalues.
 * From it come modes and frequency response. All matrices are column-major. Made for models of some
 * hundred joint rates: dense, O(n^3). docs/linear.md has the equations. */
#ifndef MBSRANK_LINEAR_H
#define MBSRANK_LINEAR_H

#include <mbsrank/newton.h>
#include <mbsrank/parameters.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- equilibria ---- */

typedef struct mbsr_equilibrium_opt {
    int cookie;         /* set by mbsr_default_equilibrium_opt */
    int max_iterations; /* default 500 */
    double tolerance;   /* of the last step: turns in rad, ways over the size of the model; default
                           1e-11 */
} mbsr_equilibrium_opt;

MBSR_API mbsr_equilibrium_opt mbsr_default_equilibrium_opt(void);

/* What mbsr_equilibrium has found. */
typedef struct mbsr_equilibrium_info {
    int iterations, factorisations;
    double step; /* the last one, as `tolerance` */
    int worst;   /* the joint rate, a place in u, along which forces are farthest from balance;
                    MBSR_NONE at a solution */
} mbsr_equilibrium_info;

/* Positions q_rest (nq) near the guess q at which all forces balance at time t, with u = 0 and
 * motions of drives as they stand; loops are closed. lambda (rows of closures): their forces;
 * lambda and info may be NULL, q_rest may be q.
 *
 * The way is that of a body let go in honey: implicit Euler steps from rest, each followed by a
 * stop, whose length grows as forces come to balance until they are Newton's. So it ends in a
 * stable equilibrium of the basin that the guess is in, mostly; a guess next to an unstable one
 * stays there. With springs and masses in any units.
 *
 * MBSR_NO_CONVERGENCE: no balance is found; the text names the joint whose forces are farthest from
 * it: nothing may hold it. MBSR_UNDETERMINED: a direction without mass that no force determines, as
 * mbsr_newton_factor names it. MBSR_LOOP_OPEN: a loop closes only where rows depend on others, and
 * comes open on the way. This and other statuses of mbsr_assemble, mbsr_dae_consistent and the
 * residual; MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE, MBSR_ERR_NO_MEMORY. q_rest is then
 * as it was. error may be NULL. */
MBSR_API int mbsr_equilibrium(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                              const mbsr_equilibrium_opt *opt, double *q_rest, double *lambda,
                              mbsr_equilibrium_info *info, mbsr_error *error);

/* ---- trim: some positions held, some parameters free ---- */

typedef struct mbsr_trim_opt {
    int cookie;         /* set by mbsr_default_trim_opt */
    int held;           /* how many joint rates are held; -1: all; default 0 */
    const int *hold;    /* which, places in u: along these the positions stay as given */
    int max_iterations; /* default 100 */
    double tolerance;   /* of the last step (turns in rad, ways over the length of the model), and
                           of what is left of forces over the largest; default 1e-10 */
} mbsr_trim_opt;

MBSR_API mbsr_trim_opt mbsr_default_trim_opt(void);

/* What mbsr_trim has found. */
typedef struct mbsr_trim_info {
    int iterations;
    double step;         /* the last one, as `tolerance` */
    int worst;           /* after MBSR_NO_CONVERGENCE: the rate along which forces are farthest from
                            balance; else MBSR_NONE */
    double loose;        /* 0 .. 1: how much of the least determined unknown nothing determines; it
                            has moved as little as the others allow. 0: all are determined */
    int loose_rate;      /* that unknown: a place in u, or MBSR_NONE, */
    int loose_parameter; /* or a parameter, or MBSR_NONE */
    double growth; /* 1/s: largest real part of the eigenvalues about that rest: above rounding
                      it is unstable; NaN: mbsr_linear_create refuses there */
} mbsr_trim_info;

/* Positions near q (nq) and values of the parameters which[k] of a model at which it rests at time
 * t with u = 0: forces balance and loops are closed. Positions stay where they are along rates that
 * are held; the parameters start at their values in the list. So
 *
 *   with all rates held and the free lengths (rests) of springs free, the preloads that keep the
 *       model at rest where it is drawn;
 *   with one coordinate held and a torque, a reference of a servo or an entry of a table free, the
 *       input that keeps it there, the others as they come to rest;
 *   with gravity or a load raised from list to list, the last positions as the next guess, the
 *       path of rest over the load.
 *
 * Newton's method with least steps: of more unknowns than equations determine, each moves no more
 * than needed (columns brought to one length), and mbsr_trim_info.loose names one that nothing
 * determines. It finds unstable rests as well as stable ones, which mbsr_trim_info.growth tells.
 * Dense, O(n^3), made for some hundred rates; a set of values costs mbsr_parameters_model: one a
 * step, two more for each parameter without products or that moves loops. q_rest (nq, may be q) and
 * value (count) are written on success. opt, info, error may be NULL; count may be 0.
 *
 * MBSR_NO_CONVERGENCE names the joint whose forces are farthest from balance; MBSR_LOOP_OPEN: the
 * loops cannot be closed with what is held. MBSR_ERR_ID, MBSR_ERR_VALUE (a parameter that comes
 * twice, hold, options), MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_NO_MEMORY, MBSR_EIGEN_FAILED
 * (LAPACK's), statuses of mbsr_parameters_data, mbsr_derivatives_create, mbsr_derivatives_inverse
 * and mbsr_bias_forces. */
MBSR_API int mbsr_trim(const mbsr_parameters *list, double t, const double *q, int count,
                       const int *which, const mbsr_trim_opt *opt, double *q_rest, double *value,
                       mbsr_trim_info *info, mbsr_error *error);

/* ---- linear equations ---- */

typedef struct mbsr_linear mbsr_linear;

/* What an input or output is. */
typedef enum mbsr_signal_kind {
    MBSR_SIGNAL_JOINT, /* input: joint force along joint rate `id`, a place in u, such as that of
                        * a motor; output: displacement dq along it */
    MBSR_SIGNAL_RATE,  /* output: du of that rate */
    MBSR_SIGNAL_PARAMETER, /* input: parameter `id` of the list of the options */
    MBSR_SIGNAL_POINT,  /* output: displacement of `point` of body `id` along world axis `part` */
    MBSR_SIGNAL_FORCE,  /* output: number `part` of what element `id` exerts on the body at
                         * `place`, f and then tau of mbsr_force_load */
    MBSR_SIGNAL_MOTION, /* input: acceleration of entry `part` of the motion that the joint of body
                         * `id` follows; its value and rate become states */
    MBSR_SIGNAL_CLOSURE_MOTION /* input: likewise of closure `id` */
} mbsr_signal_kind;

/* An input or output. */
typedef struct mbsr_signal {
    mbsr_signal_kind kind;
    int id, part, place;
    double point[3]; /* in body axes, m */
} mbsr_signal;

/* The signal of a name:
 *
 *   bodies.NAME.tau[1..]   input: joint force along a rate of the body's joint; alone: the first
 *   bodies.NAME.q[1..]     output: displacement along it;   .u[1..]: the rate
 *   bodies.NAME.x, .y, .z  output: the body's origin
 *   bodies.NAME.motion[1..], closures.NAME.motion[1..]
 *                          input: acceleration of what a stock joint or closure follows
 *   forces.NAME.f[1..]     output: of mbsr_force_load on its first body, the ground left out;
 *                          .tau[1..] likewise
 *
 * and inputs by the names of parameters in the list (NULL: none). Names as in parameters.h.
 * MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_VALUE: there is none of that name; the text says
 * where it ends. *signal is then as it was. error may be NULL. */
MBSR_API int mbsr_signal_find(const mbsr_model *model, const mbsr_parameters *list,
                              const char *name, mbsr_signal *signal, mbsr_error *error);

typedef struct mbsr_linear_opt {
    int cookie; /* set by mbsr_default_linear_opt */
    int inputs, outputs;
    const mbsr_signal *input;    /* w; default none */
    const mbsr_signal *output;   /* y; default none */
    const mbsr_parameters *list; /* made of the model, where inputs are parameters; else NULL */
} mbsr_linear_opt;

MBSR_API mbsr_linear_opt mbsr_default_linear_opt(void);

/* What an object is. */
typedef struct mbsr_linear_info {
    int size;            /* of the descriptor form */
    int states;          /* of the least form: finite eigenvalues */
    int levels;          /* in how many steps the others were taken out */
    double kept;         /* the least number left in the end over the largest, and the */
    double dropped;      /* largest dropped on the way, likewise; 0: nothing was to be decided */
    double shift;        /* 1/s: real, at which the matrix was factored */
    double acceleration; /* largest |u'| of the state: 0 at rest and in steady motion */
} mbsr_linear_info;

/* Linearises at (t, q, u), brought to a consistent state by mbsr_dae_consistent first; u may be
 * NULL for rest. opt may be NULL. The data is left at that state; the object needs neither model
 * nor data afterwards. Memory is taken by calloc. On failure *linear is NULL and the reason in
 * *error (may be NULL). MBSR_RANK_CHANGED where it is not clear how many eigenvalues are finite
 * (numbers kept and dropped lie within a factor of 100); MBSR_UNDETERMINED where the pencil is
 * singular: some direction is determined by nothing; MBSR_ERR_VALUE for an input or output that
 * does not exist or is none, and for outputs that jump with the rate of an input; MBSR_ERR_NULL,
 * MBSR_ERR_NO_DEFAULT, MBSR_ERR_NO_MEMORY, statuses of mbsr_newton_create, mbsr_dae_consistent and
 * mbsr_newton_linearise. */
MBSR_API int mbsr_linear_create(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                                const double *u, const mbsr_linear_opt *opt, mbsr_linear **linear,
                                mbsr_error *error);
MBSR_API void mbsr_linear_destroy(mbsr_linear *linear); /* NULL is allowed */

MBSR_API int mbsr_linear_get_info(const mbsr_linear *linear,
                                  mbsr_linear_info *info); /* MBSR_ERR_NULL */

/* Rows of E, A and B: dq' = ..., momenta, equations of u, velocity rows and position rows of
 * closures. Columns: dq, dp, du (nu each), then loop forces of velocity rows (of stiff rows the
 * force of the spring), then multipliers of position rows, then value and rate of each motion that
 * is an input, with rows s' = v and v' = w. */
typedef enum mbsr_linear_part {
    MBSR_LINEAR_E,
    MBSR_LINEAR_A,
    MBSR_LINEAR_B,
    MBSR_LINEAR_AR,
    MBSR_LINEAR_BR,
    MBSR_LINEAR_CR,
    MBSR_LINEAR_DR,
    MBSR_LINEAR_PARTS
} mbsr_linear_part;

/* One of these matrices, which lives as long as the object, and its shape (may be NULL). NULL for a
 * part that does not exist. */
MBSR_API const double *mbsr_linear_matrix(const mbsr_linear *linear, mbsr_linear_part part,
                                          int *rows, int *columns);

/* A mode exp(s t), s = real + i imaginary (1/s). */
typedef struct mbsr_mode {
    double real, imaginary; /* imaginary >= 0: of a pair one is given */
    double frequency;       /* imaginary / (2 pi), Hz */
    double damping;         /* -real / |s|; 0 for s = 0 */
} mbsr_mode;

/* Modes in the order of |s|: *count of them into modes, which has room for mbsr_linear_info.states.
 * modes may be NULL, to count. MBSR_ERR_NULL, MBSR_NO_CONVERGENCE (LAPACK's). */
MBSR_API int mbsr_linear_modes(mbsr_linear *linear, mbsr_mode *modes, int *count);

/* Shape of mode k: complex amplitudes of dq (nu each), the largest of them 1. The velocity is s
 * times that. im may be NULL. MBSR_ERR_NULL, MBSR_ERR_VALUE for a mode that does not exist. */
MBSR_API int mbsr_linear_shape(mbsr_linear *linear, int k, double *re, double *im);

/* Frequency response Cr (i 2 pi f - Ar)^-1 Br + Dr at f Hz: outputs x inputs, real and imaginary
 * parts. MBSR_ERR_NULL, MBSR_NOT_FINITE, MBSR_ERR_VALUE where f is an eigenvalue. */
MBSR_API int mbsr_linear_response(mbsr_linear *linear, double frequency, double *re, double *im);

/* Where the energy of a mode is, about rest at (t, q): shares of bodies in the kinetic energy
 * (kinetic: as many as bodies; the armature of a joint counts for its body), of force elements in
 * the potential energy (potential: as many as forces) and in what is dissipated (dissipated). mode,
 * re, im: as found; im may be NULL, and so may outputs. The sizes of each add up to 1, or all are
 * zero. An element whose forces grow along the shape has a negative share: gravity on what stands
 * upright, a spring that is pressed together seen across. So gravity and forces that are there at
 * rest take part. Closures, stiff rows too, and elements that became such, count for nothing.
 *
 * The element's x^T (-dQ/dq) x and x^T (-dQ/du) x, by differences in some 1e-5 rad, to 1e-6 or so.
 * O(bodies + elements) a mode. The data is left near q. MBSR_ERR_NULL, MBSR_ERR_UNFINISHED,
 * MBSR_ERR_NO_MEMORY, statuses of mbsr_stage_positions and mbsr_force_load. error may be NULL. */
MBSR_API int mbsr_mode_participation(const mbsr_model *model, mbsr_data *data, double t,
                                     const double *q, const mbsr_mode *mode, const double *re,
                                     const double *im, double *kinetic, double *potential,
                                     double *dissipated, mbsr_error *error);

/* ---- a few modes of large models ---- */

typedef struct mbsr_near_opt {
    int cookie;       /* set by mbsr_default_near_opt */
    int count;        /* of modes wanted, 1 .. 1000; default 20 */
    double shift;     /* > 0, in 1/s: modes nearest to it; 0 (default): the slowest, by |s| */
    double tolerance; /* of eigenvalues, over their distance from the shift; default 1e-10 */
} mbsr_near_opt;

MBSR_API mbsr_near_opt mbsr_default_near_opt(void);

/* Modes about rest at (t, q), an equilibrium, as mbsr_linear_create and mbsr_linear_modes find
 * them, without matrices: by Krylov-Schur iteration on Newton systems of the momentum form. That is
 * a factorisation and some hundred solutions in O(N), and 8 count + 60 vectors of nu numbers, or
 * 480 of nu < 500. Modes that come several times, as in models with equal parts, are given as
 * often. Of more modes next to the slowest than there are vectors any may be given whose |s| is
 * within a thousandth.
 *
 * modes: room for opt->count; *found of them, in the order of |s|. Fewer are found where the model
 * has fewer; those farther away than 10^4 times the shift count as infinite. re, im: shapes as from
 * mbsr_linear_shape, nu numbers a mode, or NULL. opt may be NULL.
 *
 * MBSR_ERR_VALUE: an option out of range, a closure with stiff rows, or a q at which forces would
 * move the model by more than 1e-6 rad, or of its length. MBSR_NO_CONVERGENCE: not
 * all were found, and none is given. MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_UNFINISHED,
 * MBSR_ERR_NO_MEMORY, statuses of mbsr_dae_consistent, mbsr_newton_create, mbsr_newton_factor (a
 * shift that is an eigenvalue) and mbsr_newton_solve. error may be NULL. */
MBSR_API int mbsr_modes_near(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                             const mbsr_near_opt *opt, mbsr_mode *modes, int *found, double *re,
                             double *im, mbsr_error *error);

#ifdef __cplusplus
}
#endif

#endif

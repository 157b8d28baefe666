/* Whatever a caller builds and asks for, with numbers of any kind: every call ends with a status, a
 * refusal has a text, and what is MBSR_OK is finite. The bytes say which bodies, joints, elements,
 * closures and amendments there are, with which numbers, and in which order calls follow. For
 * libFuzzer (option MBSR_FUZZ); tests/unit/assembly/test_any_bytes.c calls it, too.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fuzz_model.h"

#include <mbsrank/batch.h>
#include <mbsrank/completion.h>
#include <mbsrank/derivatives.h>
#include <mbsrank/flex.h>
#include <mbsrank/mbsrank.h>
#include <mbsrank/stepper.h>

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_BODIES = 10, MOST_PARTS = 8, MOST_NUMBERS = 200 };

typedef struct input {
    const uint8_t *bytes;
    size_t left;
    mbsr_model *m;
    mbsr_flex *flex;
    int bodies;
    bool huge; /* some number has a square that is none */
} input;

static unsigned byte_of(input *in)
{
    if (in->left == 0) return 0;
    --in->left;
    return *in->bytes++;
}

static int below(input *in, int n)
{
    return (int)(byte_of(in) % (unsigned)n);
}

/* Mostly of the size of 1; one in 32 is none that a caller should give. */
static double number(input *in)
{
    static const double hostile[] = {NAN,   INFINITY, -INFINITY,      1e300, -1e300,
                                     1e200, 1e-300,   0.25 * DBL_MIN, 1e154, -1e-160};
    static const double usual[] = {0.0, 1.0, -1.0, 0.5, -0.5, 2.0, 0.1, 1e-3, 3.0, -0.7};
    const int kind = below(in, 32);
    if (kind == 31) {
        const double x = hostile[below(in, 10)];
        in->huge = in->huge || fabs(x) > 1e100;
        return x;
    }
    if (kind < 20) return usual[kind / 2];
    return ((int)byte_of(in) - 128) / 50.0;
}

static double positive(input *in)
{
    const double x = number(in);
    return below(in, 16) ? fabs(x) : x;
}

static void numbers(input *in, int n, double *x)
{
    for (int k = 0; k < n; ++k) x[k] = number(in);
}

/* One of the bodies, at times the ground or none that is there. */
static int some_body(input *in)
{
    const int choice = below(in, 24);
    if (choice == 0) return MBSR_GROUND;
    if (choice == 1) return -7;
    if (choice == 2) return in->bodies + 3;
    return in->bodies > 0 ? choice % in->bodies : MBSR_GROUND;
}

static void require(int condition)
{
    if (!condition) abort();
}

/* A refusal has a text. */
static int taken(int status, const mbsr_error *error)
{
    require(status == MBSR_OK || (error->status == status && error->text[0] != '\0'));
    return status == MBSR_OK;
}

static mbsr_frame some_frame(input *in)
{
    double x[3], axis[3];
    numbers(in, 3, x);
    numbers(in, 3, axis);
    switch (below(in, 4)) {
    case 0: return mbsr_frame_identity();
    case 1: return mbsr_frame_at(x[0], x[1], x[2]);
    case 2: return mbsr_frame_along(x, axis);
    default: return mbsr_frame_rotated(x, axis, number(in));
    }
}

/* ---- parts ---- */

static int motion(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    s[0] = 0.1 * sin(t), sdot[0] = 0.1 * cos(t), sddot[0] = -0.1 * sin(t);
    return 0;
}

static mbsr_joint some_compound(input *in, const mbsr_frame *A, const mbsr_frame *B)
{
    mbsr_axis axes[3];
    const int count = below(in, 4);
    int driven = 0;
    for (int k = 0; k < count; ++k) {
        axes[k] = (mbsr_axis){.kind = (mbsr_axis_kind)(1 + below(in, 3)), .pitch = number(in)};
        numbers(in, 3, axes[k].direction);
        axes[k].driven = driven == 0 && below(in, 6) == 0;
        driven += axes[k].driven;
    }
    return mbsr_joint_compound(A, B, count, axes, driven ? motion : NULL, NULL);
}

static mbsr_joint some_joint(input *in)
{
    const mbsr_frame A = some_frame(in), B = some_frame(in);
    const mbsr_planar_frame a = {number(in), number(in), number(in)},
                            b = {number(in), number(in), number(in)};
    double x[3], y[3];
    numbers(in, 3, x);
    numbers(in, 3, y);
    switch (below(in, 18)) {
    case 0: return mbsr_joint_weld(&A, &B);
    case 1: return mbsr_joint_prismatic(&A, &B, x);
    case 2: return mbsr_joint_cylindrical(&A, &B, x);
    case 3: return mbsr_joint_universal(&A, &B, x, y);
    case 4: return mbsr_joint_spherical(&A, &B);
    case 5: return mbsr_joint_free(&A, &B);
    case 6: return mbsr_joint_translational(&A, &B);
    case 7: return mbsr_joint_in_plane(&A, &B);
    case 8: return mbsr_joint_screw(&A, &B, x, number(in));
    case 9: return mbsr_joint_planar_revolute(a, b);
    case 10: return mbsr_joint_planar_prismatic(a, b);
    case 11: return mbsr_joint_planar_free(a, b);
    case 12: return mbsr_joint_planar_weld(a, b);
    case 13: return mbsr_joint_point_free();
    case 14: return mbsr_joint_mount(in->flex, below(in, 4) - 1);
    case 15: return mbsr_joint_marker(in->flex, below(in, 4) - 1);
    case 16: return some_compound(in, &A, &B);
    default: return mbsr_joint_revolute(&A, &B, x);
    }
}

static mbsr_inertia some_inertia(input *in)
{
    double x[3], tensor[6];
    numbers(in, 3, x);
    for (int k = 0; k < 6; ++k) tensor[k] = k < 3 ? positive(in) : 0.1 * number(in);
    switch (below(in, 10)) {
    case 0: return mbsr_inertia_particle(positive(in));
    case 1: return mbsr_inertia_planar(positive(in), x, positive(in));
    case 2: return mbsr_inertia_point_mass(positive(in), x);
    case 3: return mbsr_inertia_rod(positive(in), x, tensor);
    case 4: return mbsr_inertia_box(positive(in), tensor);
    case 5: return mbsr_inertia_rigid(positive(in), x, tensor);
    case 6: return mbsr_inertia_flexible(in->flex);
    case 7: return mbsr_inertia_sum(mbsr_inertia_point_mass(1.0, x), mbsr_inertia_box(1.0, tensor));
    default: return mbsr_inertia_zero();
    }
}

static mbsr_force_def some_force(input *in)
{
    const int a = some_body(in), b = some_body(in);
    double x[3], y[3], k[6], d[6];
    numbers(in, 3, x);
    numbers(in, 3, y);
    for (int l = 0; l < 6; ++l) k[l] = positive(in), d[l] = positive(in);
    const mbsr_frame A = some_frame(in), B = some_frame(in);
    mbsr_gear gear = {.ratio = k[0], .stiffness = k[1], .damping = d[1]};
    switch (below(in, 10)) {
    case 0: return mbsr_force_axis_spring(a, b, below(in, 7) - 1, k[0], d[0], x[0]);
    case 1: return mbsr_force_point_spring(a, x, b, y, k[0], d[0], k[1]);
    case 2: return mbsr_force_bushing(a, &A, b, &B, k, d);
    case 3: return mbsr_force_joint_spring(a, below(in, 7) - 1, k[0], d[0], x[0]);
    case 4: return mbsr_force_joint_stop(a, below(in, 4) - 1, x[0], x[1], k[0], d[0]);
    case 5: return mbsr_force_joint_friction(a, below(in, 4) - 1, k[0], k[1]);
    case 6: return mbsr_force_elastic(a, in->flex);
    case 7: return mbsr_force_gear(a, below(in, 3), b, below(in, 3), &gear);
    case 8: return mbsr_force_joint_rotation_spring(a, k, d, NULL);
    default: return mbsr_force_gravity(x[0], x[1], -9.81);
    }
}

static mbsr_closure_def some_closure(input *in)
{
    const int a = some_body(in), b = some_body(in), pair[2] = {a, b};
    const int coordinate[2] = {below(in, 3), below(in, 3)};
    double x[3], y[3], rows[9];
    numbers(in, 3, x);
    numbers(in, 3, y);
    numbers(in, 9, rows);
    const mbsr_frame A = some_frame(in), B = some_frame(in);
    mbsr_closure_def def;
    switch (below(in, 9)) {
    case 0: def = mbsr_closure_weld(a, &A, b, &B); break;
    case 1: def = mbsr_closure_rows(a, x, b, y, below(in, 5), rows); break;
    case 2: def = mbsr_closure_distance(a, x, b, y, positive(in)); break;
    case 3: def = mbsr_closure_coupling(below(in, 3), pair, coordinate, rows, number(in)); break;
    case 4: def = mbsr_closure_rolling_ball(a, x, positive(in), b, &B); break;
    case 5: def = mbsr_closure_rolling_disc(a, &A, positive(in), b, &B); break;
    case 6: def = mbsr_closure_body_rows(a, x, b, y, below(in, 5), rows); break;
    default: def = mbsr_closure_ball(a, x, b, y); break;
    }
    for (int k = 0; k < 3 && below(in, 4) == 0; ++k) {
        def.stiffness[k] = 1e4 * positive(in);
        def.damping[k] = positive(in);
    }
    if (below(in, 8) == 0) def.motion = motion;
    return def;
}

/* Bodies one after the other, most of them on one that is there. */
static void add_body(input *in)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id = -5;
    body.parent = below(in, 3) ? in->bodies - 1 : some_body(in);
    if (in->bodies == 0) body.parent = MBSR_GROUND;
    body.joint = some_joint(in);
    body.inertia = some_inertia(in);
    if (taken(mbsr_model_add_body(in->m, &body, &id), mbsr_model_error(in->m))) {
        require(id == in->bodies);
        ++in->bodies;
    } else {
        require(id == -5);
    }
}

static void amend(input *in)
{
    double values[6];
    const int body = some_body(in);
    for (int k = 0; k < 6; ++k) values[k] = positive(in);
    int status;
    switch (below(in, 5)) {
    case 0: status = mbsr_model_lock(in->m, body, below(in, 4) - 1, number(in)); break;
    case 1: status = mbsr_model_armature(in->m, body, below(in, 7), values); break;
    case 2: status = mbsr_model_neglect(in->m, body, below(in, 8)); break;
    case 3: status = mbsr_model_drop_locked(in->m, body); break;
    default: status = mbsr_model_restore(in->m, body); break;
    }
    (void)taken(status, mbsr_model_error(in->m));
}

static void build(input *in)
{
    const int count = 1 + below(in, MOST_BODIES);
    for (int k = 0; k < count; ++k) add_body(in);
    for (int k = below(in, MOST_PARTS); k > 0; --k) {
        const mbsr_force_def def = some_force(in);
        (void)taken(mbsr_model_add_force(in->m, &def, NULL), mbsr_model_error(in->m));
    }
    for (int k = below(in, 4); k > 0; --k) {
        const mbsr_closure_def def = some_closure(in);
        (void)taken(mbsr_model_add_closure(in->m, &def, NULL), mbsr_model_error(in->m));
    }
    for (int k = below(in, 3); k > 0; --k) amend(in);
}

/* ---- what is asked ---- */

/* What is MBSR_OK is finite. */
static int answered(int status, int n, const double *x)
{
    for (int k = 0; k < n && status == MBSR_OK; ++k) require(isfinite(x[k]));
    return status == MBSR_OK;
}

static void solve(input *in, mbsr_data *d, const double *y, const double *yp, int size)
{
    double v[3 * MOST_NUMBERS], x[3 * MOST_NUMBERS];
    mbsr_newton *newton;
    mbsr_error error;
    if (!taken(mbsr_newton_create(in->m, MBSR_DAE_MOMENTUM, NULL, &newton, &error), &error)) return;
    for (int k = 0; k < size; ++k) v[k] = 1.0;
    if (mbsr_newton_factor(newton, d, 0.1, y, yp, 100.0) == MBSR_OK) {
        (void)answered(mbsr_newton_solve(newton, v, x), size, x);
        (void)answered(mbsr_newton_solve_transposed(newton, v, x), size, x);
    }
    if (mbsr_newton_linearise(newton, d, 0.1, y, yp, 100.0) == MBSR_OK)
        (void)answered(mbsr_newton_multiply(newton, v, x), size, x);
    mbsr_newton_destroy(newton);
}

static void differentiate(input *in, mbsr_data *d, const double *q, const double *u, int nu)
{
    double out[MOST_NUMBERS], ones[MOST_NUMBERS], udot[MOST_NUMBERS];
    mbsr_derivatives *derivatives;
    (void)d;
    if (mbsr_derivatives_create(in->m, &derivatives, NULL)) return;
    for (int k = 0; k < nu; ++k) ones[k] = 1.0;
    if (answered(mbsr_derivatives_forward(derivatives, 0.1, q, u, NULL, udot, NULL), nu, udot))
        (void)answered(mbsr_derivatives_tangent(derivatives, ones, ones, ones, out, NULL), nu, out);
    mbsr_derivatives_destroy(derivatives);
}

static void report(input *in, mbsr_data *d, const double *q, const double *u)
{
    mbsr_index_report *index;
    mbsr_closure_report closures;
    if (mbsr_index_report_create(in->m, d, 0.1, q, u, &index) == MBSR_OK) {
        require(index->text[0] != '\0' || index->undetermined == 0);
        require(index->directions == index->damped + index->elastic + index->undetermined);
        mbsr_index_report_destroy(in->m, index);
    }
    if (mbsr_closures_report(in->m, d, 0.1, q, &closures, NULL, NULL)) return;
    require(closures.independent >= 0 && closures.independent <= closures.rows);
    if (in->huge) return;
    require(closures.undetermined >= 0 && closures.undetermined <= closures.massless);
    require(closures.mobility >= 0 && closures.mobility <= mbsr_model_nu(in->m));
}

static void ask(input *in, mbsr_data *d)
{
    const int nq = mbsr_model_nq(in->m), nu = mbsr_model_nu(in->m),
              size = mbsr_dae_size(in->m, MBSR_DAE_MOMENTUM);
    double q[MOST_NUMBERS], u[MOST_NUMBERS], x[MOST_NUMBERS], closed[MOST_NUMBERS];
    double y[3 * MOST_NUMBERS], yp[3 * MOST_NUMBERS], F[3 * MOST_NUMBERS];
    if (nq > MOST_NUMBERS || size > 3 * MOST_NUMBERS) return;
    numbers(in, nq, q);
    numbers(in, nu, u);
    if (mbsr_assemble(in->m, d, 0.1, q, NULL, closed, NULL) == MBSR_OK) {
        for (int k = 0; k < nq; ++k) q[k] = closed[k];
    }
    (void)answered(mbsr_forward_dynamics(in->m, d, 0.1, q, u, NULL, x), nu, x);
    (void)answered(mbsr_inverse_dynamics(in->m, d, 0.1, q, u, u, NULL, x), nu, x);
    report(in, d, q, u);
    differentiate(in, d, q, u, nu);
    if (!answered(mbsr_dae_pack(in->m, d, MBSR_DAE_MOMENTUM, 0.1, q, u, y), size, y)) return;
    for (int k = 0; k < size; ++k) yp[k] = 0.0;
    (void)answered(mbsr_dae_residual(in->m, d, MBSR_DAE_MOMENTUM, 0.1, y, yp, F), size, F);
    solve(in, d, y, yp, size);
    if (answered(mbsr_dae_consistent(in->m, d, MBSR_DAE_MOMENTUM, 0.1, y, yp, NULL, NULL), size, y))
        require(answered(MBSR_OK, size, yp));
}

/* ---- calls in any order ---- */

typedef struct objects {
    mbsr_data *d;
    mbsr_batch *batch;
    mbsr_stepper *stepper;
    mbsr_completion *completion;
    mbsr_newton *newton;
    int nq, nu, size;
    double q[2 * MOST_NUMBERS], u[2 * MOST_NUMBERS], y[3 * MOST_NUMBERS], yp[3 * MOST_NUMBERS];
    double x[8 * MOST_NUMBERS]; /* for results */
} objects;

/* A status of the library, with a text. Callbacks of these models return none of their own. */
static void said(int status, const mbsr_error *error)
{
    require(status == MBSR_OK || strcmp(mbsr_status_name(status), mbsr_status_name(-9)) != 0);
    require(status == MBSR_OK || !error || error->text[0] != '\0');
}

static int stage(input *in, objects *o)
{
    const mbsr_model *m = in->m;
    double *x = o->x;
    switch (below(in, 12)) {
    case 0: return mbsr_stage_positions(m, o->d, 0.1, o->q);
    case 1: return mbsr_stage_velocities(m, o->d, o->u);
    case 2: return mbsr_stage_forces(m, o->d, NULL);
    case 3: return mbsr_stage_backward(m, o->d);
    case 4: return mbsr_stage_forward(m, o->d, x, x + o->nu);
    case 5: return mbsr_stage_accelerations(m, o->d, o->u);
    case 6: return mbsr_coordinate_rates(m, o->d, x);
    case 7: return mbsr_momenta(m, o->d, x);
    case 8: return mbsr_energy(m, o->d, x, x + 1);
    case 9: return mbsr_dissipation(m, o->d, x);
    case 10: return mbsr_rank_watch(m, o->d, below(in, 2));
    default: return mbsr_closures_lambda(m, o->d, x);
    }
}

static int look(input *in, objects *o)
{
    const mbsr_model *m = in->m;
    const int body = some_body(in), part = below(in, 10) - 1;
    double *x = o->x;
    switch (below(in, 10)) {
    case 0: return mbsr_body_pose(m, o->d, body, x);
    case 1: return mbsr_body_twist(m, o->d, body, x);
    case 2: return mbsr_body_acceleration(m, o->d, body, x);
    case 3: return mbsr_joint_reaction(m, o->d, body, x);
    case 4: return mbsr_body_energy(m, o->d, body, x);
    case 5: return mbsr_force_power(m, o->d, part, x, x + 1);
    case 6: return mbsr_force_switch(m, o->d, part, below(in, 2));
    case 7: return mbsr_closure_reaction(m, o->d, part, below(in, 4) - 1, x, x + 20);
    case 8: return mbsr_closure_point(m, o->d, part, x);
    default: return mbsr_closures_gap(m, o->d, x);
    }
}

static int whole(input *in, objects *o)
{
    const mbsr_model *m = in->m;
    double *x = o->x;
    switch (below(in, 8)) {
    case 0: return mbsr_forward_dynamics(m, o->d, 0.1, o->q, o->u, o->u, x);
    case 1: return mbsr_inverse_dynamics(m, o->d, 0.1, o->q, o->u, o->u, NULL, x);
    case 2: return mbsr_bias_forces(m, o->d, 0.1, o->q, o->u, x);
    case 3: return mbsr_dae_unpack(m, o->d, MBSR_DAE_MOMENTUM, 0.1, o->y, x, x + o->nq);
    case 4: return mbsr_dae_residual(m, o->d, MBSR_DAE_MOMENTUM, 0.1, o->y, o->yp, x);
    case 5: return mbsr_dae_id(m, o->d, MBSR_DAE_MOMENTUM, x);
    case 6: return mbsr_normalise(m, o->d, o->q);
    default: return mbsr_dae_pack(m, o->d, MBSR_DAE_MOMENTUM, 0.1, o->q, o->u, o->y);
    }
}

static int batch(input *in, objects *o)
{
    int status[2];
    if (!o->batch) return mbsr_batch_create(in->m, &o->batch, NULL);
    for (int k = 0; k < o->nq; ++k) o->q[o->nq + k] = o->q[k];
    for (int k = 0; k < o->nu; ++k) o->u[o->nu + k] = 0.5 * o->u[k];
    if (below(in, 2))
        return mbsr_batch_forward_dynamics(in->m, o->batch, 0.1, below(in, 3), o->q, o->u, NULL,
                                           o->x, status);
    return mbsr_batch_inverse_dynamics(in->m, o->batch, 0.1, below(in, 3), o->q, o->u, o->u, o->x,
                                       NULL);
}

static int steps(input *in, objects *o)
{
    double t;
    if (!o->stepper) return mbsr_stepper_create(in->m, o->d, NULL, &o->stepper, NULL);
    switch (below(in, 6)) {
    case 0:
    case 1: return mbsr_stepper_step(o->stepper);
    case 2: return mbsr_stepper_to(o->stepper, number(in));
    case 3: return mbsr_stepper_motion(o->stepper, &t, o->q, o->u);
    case 4: return mbsr_stepper_resume(o->stepper, 0.1, o->y, o->yp);
    default: return mbsr_stepper_start(o->stepper, 0.1, o->q, o->u);
    }
}

static int completes(input *in, objects *o)
{
    if (!o->completion) return mbsr_completion_create(in->m, NULL, &o->completion, NULL);
    switch (below(in, 3)) {
    case 0: return mbsr_completion_solve(o->completion, o->d, MBSR_DAE_MOMENTUM, 0.1, o->y, o->yp);
    case 1:
        said(mbsr_completion_motion(o->completion, o->d, o->q, o->u, NULL, NULL),
             mbsr_data_error(o->d));
        return MBSR_OK;
    default:
        return mbsr_completion_dynamics(o->completion, o->d, 0.1, o->q, o->u, NULL, o->x,
                                        o->x + o->nu);
    }
}

static int newton(input *in, objects *o)
{
    if (!o->newton) {
        mbsr_newton_opt opt = mbsr_default_newton_opt();
        opt.lean = below(in, 2);
        opt.products = below(in, 2);
        return mbsr_newton_create(in->m, MBSR_DAE_MOMENTUM, &opt, &o->newton, NULL);
    }
    switch (below(in, 5)) {
    case 0: return mbsr_newton_factor(o->newton, o->d, 0.1, o->y, o->yp, 100.0);
    case 1: return mbsr_newton_solve(o->newton, o->y, o->x);
    case 2: return mbsr_newton_solve_transposed(o->newton, o->y, o->x);
    case 3: return mbsr_newton_linearise(o->newton, o->d, 0.1, o->y, o->yp, 100.0);
    default: return mbsr_newton_multiply(o->newton, o->y, o->x);
    }
}

static void any_order(input *in, mbsr_data *d)
{
    objects o = {.d = d, .nq = mbsr_model_nq(in->m), .nu = mbsr_model_nu(in->m)};
    o.size = mbsr_dae_size(in->m, MBSR_DAE_MOMENTUM);
    if (o.nq > MOST_NUMBERS || o.size > 3 * MOST_NUMBERS) return;
    for (int calls = 0; calls < 40 && in->left > 0; ++calls) {
        switch (below(in, 10)) {
        case 0: numbers(in, o.nq, o.q); break;
        case 1: numbers(in, o.nu, o.u); break;
        case 2: said(batch(in, &o), mbsr_batch_error(o.batch)); break;
        case 3: said(steps(in, &o), mbsr_stepper_error(o.stepper)); break;
        case 4: said(completes(in, &o), mbsr_completion_error(o.completion)); break;
        case 5: said(newton(in, &o), mbsr_newton_error(o.newton)); break;
        case 6: said(whole(in, &o), mbsr_data_error(d)); break;
        case 7: said(look(in, &o), mbsr_data_error(d)); break;
        default: said(stage(in, &o), mbsr_data_error(d)); break;
        }
    }
    mbsr_batch_destroy(o.batch);
    mbsr_stepper_destroy(o.stepper);
    mbsr_completion_destroy(o.completion);
    mbsr_newton_destroy(o.newton);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    input in = {.bytes = bytes, .left = size};
    mbsr_beam_def beam = mbsr_default_beam_def();
    mbsr_data *d;
    beam.length = 1.0, beam.density = 1.0, beam.EI_y = 10.0, beam.EI_z = 20.0;
    beam.elements = 3, beam.modes = 2;
    if (below(&in, 4) == 0 && mbsr_flex_beam(&beam, &in.flex, NULL)) in.flex = NULL;
    require(mbsr_model_create(NULL, &in.m, NULL) == MBSR_OK);
    build(&in);
    if (taken(mbsr_model_finish(in.m), mbsr_model_error(in.m)) &&
        mbsr_data_create(in.m, &d, NULL) == MBSR_OK) {
        if (below(&in, 2))
            ask(&in, d);
        else
            any_order(&in, d);
        mbsr_data_destroy(d);
    }
    mbsr_model_destroy(in.m);
    mbsr_flex_destroy(in.flex);
    return 0;
}

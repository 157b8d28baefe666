/* Random models with flexible bodies, of modes with and without mass: what they answer depends
 * neither on units nor on the amplitudes that modes are told in, and is what the equations ask.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "duration.h"
#include "units.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { MODES = 3, MARKERS = 3, PLACES = 16, MOST = 48, SIZE = 3 * MOST };

/* A model under way. */
typedef struct maker {
    mbsr_model *m;
    test_rng rng;
    units of;
    double amplitude; /* of a mode that is told by another: as many times 1, or 1 over that */
    mbsr_flex *flex[3];
    int flexes, place[PLACES], places; /* bodies in space */
    double unit[MOST];                 /* nu: of the amplitudes of modes, 1 of others */
    int nu;
} maker;

/* What it answers, in SI units and amplitudes of the first telling. */
typedef struct answers {
    int status, undetermined, elastic, damped, nq, nu;
    double q[MOST], u[MOST], udot[MOST], weight[MOST]; /* the last of closed models */
    double scale[MOST];                                /* of momenta, of models with some mass */
    double left, solved; /* of the equations, at the start; of a Newton system */
} answers;

static double share(maker *w)
{
    return 0.5 * (1.0 + test_uniform(&w->rng));
}

static mbsr_frame frame(maker *w)
{
    mbsr_frame f = mbsr_frame_identity();
    double quaternion[4] = {test_integer(&w->rng, 1, 3)};
    for (int k = 1; k < 4; ++k) quaternion[k] = test_integer(&w->rng, -2, 2);
    if (share(w) < 0.5) assert_ok(mbsr_quaternion_rotation(quaternion, f.R), NULL);
    for (int k = 0; k < 3; ++k) f.x[k] = 0.3 * test_integer(&w->rng, -2, 2) * w->of.length;
    return f;
}

static mbsr_joint joint(maker *w)
{
    static const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0};
    const mbsr_frame f = frame(w);
    const double axis[3] = {test_integer(&w->rng, -1, 1), test_integer(&w->rng, -1, 1), 1.0};
    switch (test_integer(&w->rng, 0, 5)) {
    case 0: return mbsr_joint_prismatic(&f, NULL, axis);
    case 1: return mbsr_joint_spherical(&f, NULL);
    case 2: return mbsr_joint_universal(&f, NULL, x, y);
    case 3: return mbsr_joint_free(&f, NULL);
    default: return mbsr_joint_revolute(&f, NULL, axis);
    }
}

/* Particles that modes with mass move: integrals of their masses. */
static void add_particles(maker *w, int modes, const double *unit, const bool *massless,
                          mbsr_flex_def *f, double *Ct0, double *P0, double *P)
{
    const int count = test_integer(&w->rng, 0, 3), n = 3 * modes;
    for (int p = 0; p < count; ++p) {
        const double mass = exp(2.0 * test_uniform(&w->rng)) * w->of.mass;
        double x[3], Phi[3 * MODES];
        for (int k = 0; k < 3; ++k) x[k] = 0.4 * test_integer(&w->rng, -2, 2) * w->of.length;
        for (int k = 0; k < n; ++k) {
            const double way = test_uniform(&w->rng) * w->of.length * unit[k / 3];
            Phi[k] = massless[k / 3] ? 0.0 : way;
        }
        f->mass += mass;
        for (int k = 0; k < 3; ++k) {
            f->c0[k] += mass * x[k];
            for (int l = 0; l < 3; ++l) f->N0[3 * l + k] += mass * x[k] * x[l];
            for (int l = 0; l < n; ++l) P0[3 * l + k] += mass * x[k] * Phi[l];
        }
        for (int l = 0; l < n; ++l) {
            Ct0[l] += mass * Phi[l];
            for (int k = 0; k < n; ++k) P[n * l + k] += mass * Phi[k] * Phi[l];
        }
    }
}

/* Modal data, with the modes' units of amplitude. */
static mbsr_flex *make_flex(maker *w, int *markers, int *modes, double *unit)
{
    double Ct0[3 * MODES] = {0.0}, P0[9 * MODES] = {0.0}, P[9 * MODES * MODES] = {0.0},
                   K[MODES * MODES] = {0.0}, D[MODES * MODES] = {0.0}, Phi[MARKERS][3 * MODES],
                   Psi[MARKERS][3 * MODES];
    const double area = w->of.length * w->of.length, damped = share(w);
    mbsr_flex_marker marker[MARKERS] = {{.frame = mbsr_frame_identity()}};
    mbsr_flex_def f = mbsr_default_flex_def();
    bool massless[MODES];
    mbsr_error error;
    const int n = f.modes = *modes = test_integer(&w->rng, 1, MODES);
    for (int k = 0; k < n; ++k) {
        massless[k] = share(w) < 0.5;
        unit[k] = pow(w->amplitude, test_integer(&w->rng, -1, 1));
    }
    add_particles(w, n, unit, massless, &f, Ct0, P0, P);
    for (int k = 0; k < n; ++k) {
        const double c = w->of.mass / w->of.time * area * unit[k] * unit[k];
        K[k * (n + 1)] = exp(3.0 + 2.0 * test_uniform(&w->rng)) * c / w->of.time;
        D[k * (n + 1)] = damped < 0.4 ? exp(test_uniform(&w->rng)) * c : 0.0;
    }
    f.markers = *markers = test_integer(&w->rng, 2, MARKERS);
    for (int i = 1; i < *markers; ++i) {
        marker[i] = (mbsr_flex_marker){frame(w), Phi[i], Psi[i]};
        for (int k = 0; k < 3 * n; ++k) {
            Phi[i][k] = test_uniform(&w->rng) * w->of.length * unit[k / 3];
            Psi[i][k] = test_integer(&w->rng, 0, 1) * test_uniform(&w->rng) * unit[k / 3];
        }
    }
    f.Ct0 = Ct0, f.P0 = P0, f.P = P, f.K = K, f.D = D, f.marker = marker;
    assert_ok(mbsr_flex_create(&f, w->flex + w->flexes, &error), &error);
    return w->flex[w->flexes++];
}

static int any_place(maker *w, int from)
{
    return w->place[test_integer(&w->rng, from, w->places - 1)];
}

static void add_flexible(maker *w)
{
    int markers, modes, id, end;
    mbsr_flexible_def def = mbsr_default_flexible_def();
    double unit[MODES];
    const mbsr_joint on = joint(w);
    const bool fast = share(w) < 0.3;
    def.parent = any_place(w, 0);
    def.flex = make_flex(w, &markers, &modes, unit);
    if (!fast) def.joint = on, w->nu += on.n;
    memcpy(w->unit + w->nu, unit, (size_t)modes * sizeof *unit);
    w->nu += modes;
    assert_ok(mbsr_model_add_flexible(w->m, &def, &id), mbsr_model_error(w->m));
    for (int k = 1; k < markers; ++k) {
        assert_ok(mbsr_model_add_marker(w->m, id, k, NULL, &end), mbsr_model_error(w->m));
        w->place[w->places++] = end;
    }
}

static void add_rigid(maker *w)
{
    const double mass = exp(test_uniform(&w->rng)) * w->of.mass, L = w->of.length,
                 I = 0.1 * mass * L * L, com[3] = {0.4 * test_uniform(&w->rng) * L, 0.1 * L, 0.0},
                 tensor[6] = {I, 1.1 * I, 1.2 * I};
    const bool massless = share(w) < 0.3;
    const mbsr_joint on = joint(w);
    const int parent = any_place(w, 0);
    w->nu += on.n;
    w->place[w->places++] = test_add_body(
        w->m, parent, on, massless ? mbsr_inertia_zero() : mbsr_inertia_rigid(mass, com, tensor));
}

static void add_force(maker *w, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(w->m, &force, NULL), mbsr_model_error(w->m));
}

static void add_forces(maker *w)
{
    const double L = w->of.length, d = w->of.mass / w->of.time, k = d / w->of.time;
    const int count = test_integer(&w->rng, 0, 3);
    for (int n = 0; n < count; ++n) {
        const int a = any_place(w, 1), b = any_place(w, 0);
        const double x[3] = {0.2 * test_uniform(&w->rng) * L, 0.1 * L, 0.2 * L},
                     y[3] = {test_uniform(&w->rng) * L, test_uniform(&w->rng) * L, L},
                     stiffness = exp(3.0 + test_uniform(&w->rng)) * k,
                     damping = share(w) < 0.4 ? exp(test_uniform(&w->rng)) * d : 0.0;
        if (a != b) add_force(w, mbsr_force_point_spring(a, x, b, y, stiffness, damping, 0.8 * L));
    }
    for (int n = 0; n < 2; ++n) {
        const mbsr_frame at = frame(w);
        double stiffness[6], damping[6];
        const int a = any_place(w, 1);
        for (int l = 0; l < 6; ++l) {
            const double unit = l < 3 ? L * L : 1.0;
            stiffness[l] = exp(3.0 + test_uniform(&w->rng)) * k * unit;
            damping[l] = n * exp(test_uniform(&w->rng)) * d * unit;
        }
        if (share(w) < 0.5)
            add_force(w, mbsr_force_bushing(a, &at, MBSR_GROUND, &at, stiffness, damping));
    }
    add_force(w, mbsr_force_gravity(0.0, -9.81 * L / (w->of.time * w->of.time), 0.0));
}

/* Returns whether a loop has to be closed. */
static bool make(maker *w, uint64_t seed, const units *of, double amplitude)
{
    *w = (maker){.rng = test_seed(seed), .of = *of, .amplitude = amplitude, .places = 1};
    for (int k = 0; k < MOST; ++k) w->unit[k] = 1.0;
    w->place[0] = MBSR_GROUND;
    assert_ok(mbsr_model_create(NULL, &w->m, NULL), NULL);
    for (int left = test_integer(&w->rng, 1, 3); left > 0; --left) {
        if (share(w) < 0.6 || (w->flexes == 0 && left == 1))
            add_flexible(w);
        else
            add_rigid(w);
    }
    add_forces(w);
    const double L = of->length, x[3] = {0.2 * L, 0.3 * test_uniform(&w->rng) * L, 0.0},
                 y[3] = {3.0 * test_uniform(&w->rng) * L, 2.0 * L, L};
    const mbsr_closure_def rod = mbsr_closure_distance(any_place(w, 1), x, MBSR_GROUND, y, 2.5 * L);
    const bool closed = share(w) < 0.35;
    if (closed) assert_ok(mbsr_model_add_closure(w->m, &rod, NULL), mbsr_model_error(w->m));
    assert_ok(mbsr_model_finish(w->m), mbsr_model_error(w->m));
    return closed;
}

static double unit_of(const maker *w, mbsr_coordinate_kind kind, int rate)
{
    return kind == MBSR_COORDINATE_OTHER         ? 1.0 / w->unit[rate]
           : kind == MBSR_COORDINATE_TRANSLATION ? w->of.length
                                                 : 1.0;
}

/* Units of q and u, and a state in SI units. */
static void choose_state(maker *w, double *unit_q, double *unit_u, double *q, double *u)
{
    for (int b = 0; b < mbsr_model_bodies(w->m); ++b) {
        mbsr_coordinate_kind kind_q[MBSR_MAX_D + 1], kind_u[MBSR_MAX_D + 1];
        int at_q, nq, at, n;
        assert_ok(mbsr_body_coordinates(w->m, b, &at_q, &nq, &at, &n), NULL);
        assert_ok(mbsr_body_coordinate_kinds(w->m, b, kind_q, kind_u), NULL);
        for (int k = 0; k < nq; ++k) {
            const bool mode = kind_q[k] == MBSR_COORDINATE_OTHER, turn = nq > n && k < 4;
            unit_q[at_q + k] = unit_of(w, kind_q[k], at + k);
            q[at_q + k] = (mode ? 0.1 : turn ? 0.4 : 1.0) * test_uniform(&w->rng);
            if (turn && k == 0) q[at_q] = 1.0;
        }
        for (int k = 0; k < n; ++k) {
            const bool mode = kind_u[k] == MBSR_COORDINATE_OTHER;
            unit_u[at + k] = unit_of(w, kind_u[k], at + k) / w->of.time;
            u[at + k] = (mode ? 0.3 : 1.0) * test_uniform(&w->rng);
        }
    }
}

/* What is left of F at the state, over the typical size of each row; what a Newton system leaves
 * of its right-hand side. */
static void check_equations(maker *w, mbsr_data *d, const double *unit_q, const double *unit_u,
                            const double *y, const double *yp, answers *a)
{
    const double T = w->of.time, power = w->of.mass * w->of.length * w->of.length / (T * T * T);
    const int nq = a->nq, nu = a->nu;
    double F[SIZE], x[SIZE] = {0.0}, size = 1.0;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton *newton;
    opt.products = 1;
    assert_ok(mbsr_dae_residual(w->m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), mbsr_data_error(d));
    for (int k = 0; k < nu; ++k) size = fmax(size, fabs(yp[nq + k]) * unit_u[k] / power);
    for (int k = 0; k < 2 * nu; ++k) {
        const double rate = k < nu ? 1.0 : 1.0 / T; /* momenta, or forces, in the last rows */
        a->left = fmax(a->left, fabs(F[nq + k]) * unit_u[k % nu] * rate / power / size);
    }
    assert_ok(mbsr_newton_create(w->m, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
    assert_ok(mbsr_newton_factor(newton, d, 0.0, y, yp, 30.0 / T), mbsr_newton_error(newton));
    for (int k = 0; k < nq; ++k) x[k] = sin(1.0 + k) * unit_q[k];
    for (int k = 0; k < nu; ++k) {
        x[nq + k] = sin(2.0 + k) * power * T / unit_u[k];
        x[nq + nu + k] = sin(3.0 + k) * unit_u[k];
    }
    assert_ok(mbsr_newton_linearise(newton, d, 0.0, y, yp, 30.0 / T), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_multiply(newton, x, F), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, F, x), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_multiply(newton, x, x), mbsr_newton_error(newton));
    for (int l = 0; l < 2; ++l) { /* rows of momenta, of rates */
        double largest = 0.0, most = 0.0;
        for (int k = 0; k < nu; ++k) {
            largest = fmax(largest, fabs(F[nq + l * nu + k]) * unit_u[k]);
            most = fmax(most, fabs(x[nq + l * nu + k] - F[nq + l * nu + k]) * unit_u[k]);
        }
        a->solved = fmax(a->solved, most / largest);
    }
    mbsr_newton_destroy(newton);
}

static void report(maker *w, mbsr_data *d, const double *q, const double *u, answers *a)
{
    mbsr_index_report *report;
    assert_ok(mbsr_index_report_create(w->m, d, 0.0, q, u, &report), mbsr_data_error(d));
    a->undetermined = report->undetermined;
    a->elastic = report->elastic;
    a->damped = report->damped;
    mbsr_index_report_destroy(w->m, report);
}

/* The weights of multipliers of position rows: inverse inertias; the scales of momenta: inertias.
 */
static void weigh(maker *w, mbsr_data *d, const double *q, const double *u, const double *unit_u,
                  bool closed, answers *a)
{
    const double energy = w->of.mass * w->of.length * w->of.length / (w->of.time * w->of.time);
    if (closed) assert_ok(mbsr_closures_weight(w->m, a->weight), NULL);
    assert_ok(mbsr_stage_positions(w->m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(w->m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_stage_forces(w->m, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_stage_backward(w->m, d), mbsr_data_error(d));
    assert_ok(mbsr_momentum_scales(w->m, d, a->scale), mbsr_data_error(d));
    /* of several modes of a joint the largest counts, as they are told */
    const bool massive = mbsr_total_rank(w->m, d) > 0 && w->amplitude == 1.0;
    for (int k = 0; k < mbsr_model_nu(w->m); ++k) {
        const double square = unit_u[k] * unit_u[k];
        a->weight[k] *= energy / square;
        a->scale[k] *= massive ? square / energy : 0.0;
    }
}

/* From the state in `first`, where that has one; false: the loop cannot be closed. */
static bool ask(uint64_t seed, const units *of, double amplitude, const answers *first, answers *a)
{
    double q[MOST], u[MOST], unit_q[MOST], unit_u[MOST], y[SIZE], yp[SIZE];
    mbsr_data *d;
    maker w;
    const bool closed = make(&w, seed, of, amplitude);
    *a = (answers){.nq = mbsr_model_nq(w.m), .nu = mbsr_model_nu(w.m)};
    assert_true(a->nq <= MOST && mbsr_dae_size(w.m, MBSR_DAE_MOMENTUM) <= SIZE);
    assert_ok(mbsr_data_create(w.m, &d, NULL), NULL);
    choose_state(&w, unit_q, unit_u, q, u);
    for (int k = 0; k < a->nq; ++k) q[k] = (first ? first->q[k] : q[k]) * unit_q[k];
    for (int k = 0; k < a->nu; ++k) u[k] = (first ? first->u[k] : u[k]) * unit_u[k];
    weigh(&w, d, q, u, unit_u, closed, a);
    const bool open = closed && !first && mbsr_assemble(w.m, d, 0.0, q, NULL, q, NULL) != MBSR_OK;
    if (!open) {
        report(&w, d, q, u, a);
        assert_ok(mbsr_dae_pack(w.m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
        a->status = mbsr_dae_consistent(w.m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
        if (a->undetermined > 0) assert_true(a->status != MBSR_OK);
    }
    for (int k = 0; k < a->nq && !open && !a->status; ++k) a->q[k] = y[k] / unit_q[k];
    for (int k = 0; k < a->nu && !open && !a->status; ++k) {
        a->u[k] = y[a->nq + a->nu + k] / unit_u[k];
        a->udot[k] = yp[a->nq + a->nu + k] / unit_u[k] * of->time;
    }
    if (!open && !a->status) check_equations(&w, d, unit_q, unit_u, y, yp, a);
    mbsr_data_destroy(d);
    mbsr_model_destroy(w.m);
    for (int k = 0; k < w.flexes; ++k) mbsr_flex_destroy(w.flex[k]);
    return !open;
}

/* The largest difference beside the largest number of b. */
static double off(int n, const double *a, const double *b)
{
    double most = 0.0, size = 1.0;
    for (int k = 0; k < n; ++k) {
        most = fmax(most, fabs(a[k] - b[k]));
        size = fmax(size, fabs(b[k]));
    }
    return most / size;
}

static void compare(uint64_t seed, int telling, const answers *a, const answers *with)
{
    const double q = off(with->nq, a->q, with->q), u = off(with->nu, a->u, with->u),
                 udot = off(with->nu, a->udot, with->udot),
                 weight = fmax(off(with->nu, a->weight, with->weight),
                               a->scale[0] > 0.0 ? off(with->nu, a->scale, with->scale) : 0.0);
    const bool good = a->status == with->status && a->undetermined == with->undetermined &&
                      a->elastic == with->elastic && a->damped == with->damped && q <= 1e-8 &&
                      u <= 1e-6 && udot <= 1e-5 && weight <= 1e-9 && a->left <= 1e-9 &&
                      a->solved <= 1e-9;
    if (!good)
        print_error("seed %d, telling %d: status %d, %d/%d/%d for %d/%d/%d, q %.1e u %.1e u' %.1e "
                    "weight %.1e left %.1e solved %.1e\n",
                    (int)seed, telling, a->status, a->undetermined, a->elastic, a->damped,
                    with->undetermined, with->elastic, with->damped, q, u, udot, weight, a->left,
                    a->solved);
    assert_true(good);
}

/* 1: it starts. */
static int check(uint64_t seed)
{
    answers from, first, other;
    const bool closed = ask(seed, systems, 1.0, NULL, &from), starts = closed && !from.status;
    if (starts) (void)ask(seed, systems, 1.0, &from, &first);
    for (int k = 1; k < 5; ++k) {
        const units *of = systems + (k < 4 ? k : 0);
        const double amplitude = k < 4 ? 1.0 : 1e3;
        /* where springs balance far away that may be another place */
        if (from.elastic == 0 || from.undetermined > 0) {
            assert_int_equal(ask(seed, of, amplitude, NULL, &other), closed);
            compare(seed, k, &other, &from);
        }
        if (!starts) continue;
        (void)ask(seed, of, amplitude, &from, &other);
        compare(seed, k, &other, &first);
    }
    return starts;
}

static void told_in_units_and_amplitudes(void **state)
{
    (void)state;
    const int seeds = test_long() ? 1000 : test_seeds(6, 14);
    int started = 0;
    for (int seed = 1; seed <= seeds; ++seed) started += check((uint64_t)seed);
    assert_true(started > seeds / 2);
}

/* Directions behind markers, of groups of massless bodies, in a quarter of a millimetre. */
static void directions_told_in_short_lengths(void **state)
{
    (void)state;
    static const units lengths = {"m / 4096, kg, s", 4096.0, 1.0, 1.0};
    static const int seed[] = {556, 672};
    for (int k = 0; k < 2; ++k) {
        answers first, other;
        assert_int_equal(ask((uint64_t)seed[k], systems, 1.0, NULL, &first),
                         ask((uint64_t)seed[k], &lengths, 1.0, NULL, &other));
        assert_int_equal(other.undetermined, first.undetermined);
        assert_int_equal(other.elastic, first.elastic);
        assert_int_equal(other.damped, first.damped);
        assert_true(first.elastic > 0);
    }
}

/* A hinge, and behind it thirteen rates that are one group but for that: modes without mass, a free
 * joint to another such body. */
static void groups_begin_at_a_mount(void **state)
{
    (void)state;
    static const double z[3] = {0.0, 0.0, 1.0},
                        K[9] = {50.0, 0.0, 0.0, 0.0, 70.0, 0.0, 0.0, 0.0, 60.0},
                        D[9] = {2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0},
                        Phi[9] = {0.0, 0.5, 0.2, 0.1, -0.2, 0.6, 0.3, 0.0, 0.0},
                        Psi[9] = {0.0, 0.3, 0.0, 0.2, 0.0, 0.0, 0.0, 0.0, 0.1},
                        point[3] = {0.0, 0.2, 0.0}, there[3] = {1.0, 1.0, 1.0};
    const mbsr_flex_marker marker[2] = {{.frame = mbsr_frame_identity()},
                                        {mbsr_frame_at(0.7, 0.0, 0.0), Phi, Psi}};
    mbsr_flex_def f = mbsr_default_flex_def();
    mbsr_flexible_def def = mbsr_default_flexible_def();
    maker w = {.of = systems[0]};
    mbsr_error error;
    mbsr_data *d;
    int body, end;
    f.modes = 3, f.K = K, f.D = D, f.markers = 2, f.marker = marker, f.mass = 2.0, f.c0[0] = 0.8;
    f.N0[0] = 0.5, f.N0[4] = f.N0[8] = 0.1;
    assert_ok(mbsr_flex_create(&f, w.flex, &error), &error);
    assert_ok(mbsr_model_create(NULL, &w.m, NULL), NULL);
    def.flex = w.flex[0];
    for (int k = 0; k < 2; ++k) {
        def.joint = k ? mbsr_joint_free(NULL, NULL) : mbsr_joint_revolute(NULL, NULL, z);
        assert_ok(mbsr_model_add_flexible(w.m, &def, &body), mbsr_model_error(w.m));
        assert_ok(mbsr_model_add_marker(w.m, body, 1, NULL, &end), mbsr_model_error(w.m));
        def.parent = end;
    }
    add_force(&w, mbsr_force_point_spring(end, point, MBSR_GROUND, there, 20.0, 1.0, 0.5));
    assert_ok(mbsr_model_finish(w.m), mbsr_model_error(w.m));
    assert_ok(mbsr_data_create(w.m, &d, NULL), NULL);
    answers a = {.nq = mbsr_model_nq(w.m), .nu = mbsr_model_nu(w.m)};
    double q[MOST] = {0.3, 0.02, -0.03, 0.01, 1.0, 0.2, -0.3}, u[MOST], one[MOST], y[SIZE],
           yp[SIZE];
    for (int k = 0; k < MOST; ++k) u[k] = 0.5 * cos(2.0 * k), one[k] = 1.0;
    assert_ok(mbsr_dae_pack(w.m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(w.m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    check_equations(&w, d, one, one, y, yp, &a);
    assert_true(a.left <= 1e-12 && a.solved <= 1e-9);
    mbsr_data_destroy(d);
    mbsr_model_destroy(w.m);
    mbsr_flex_destroy(w.flex[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(told_in_units_and_amplitudes),
                                       cmocka_unit_test(directions_told_in_short_lengths),
                                       cmocka_unit_test(groups_begin_at_a_mount)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
